//! The lines solved for their inputs.
#![allow(
    clippy::indexing_slicing,
    reason = "`Corrector::new` makes bias, matrix and sensitivity over its lines and solved inputs, and parts over all inputs; numbers in `which` are places of inputs"
)]

use super::bound::{Bound, Slot, State};
use super::calibration::{Calibration, LineInput, Quantity};
use crate::algebra::Scratch;
use crate::elements::{Elements, OrNan};
use crate::error::{Fault, Malformed, Result};
use nalgebra::{DMatrix, DVector, Vector3};

/// A corrected sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Corrected {
    /// The solved inputs, in [`Calibration::solved`] order, in the bench's units.
    pub inputs: Vec<f64>,
    /// Did the exact lines come to a solution?
    pub converged: bool,
}

/// A calibration made ready to correct samples.
#[derive(Debug, Clone)]
pub struct Corrector {
    bound: Vec<Bound>,
    /// All inputs; those that are given, by their index here.
    inputs: Vec<LineInput>,
    parameters: Vec<f64>,
    covariance: DMatrix<f64>,
    /// `f(0)`, one for each sensor.
    bias: DVector<f64>,
    /// `df/dq` at zero, sensors x solved inputs.
    sensitivity: DMatrix<f64>,
    /// Its (pseudo) inverse, solved inputs x sensors.
    matrix: DMatrix<f64>,
    /// Vectors that belong to a solved or given component: rate and force part of each input.
    parts: Vec<(Vector3<f64>, Vector3<f64>)>,
}

/// Rounds in all, and of `q <- q + M (s - f(q))` among them; exported sources have the same.
pub(super) const ROUNDS: usize = 160;
pub(super) const CONTRACTING: usize = 60;
/// A change of an input below this share of the input (or of what one unit of the last place of the readings moves) is none.
const SETTLED: f64 = 4.0 * f64::EPSILON;

impl Corrector {
    /// Bind the lines and invert them at zero input.
    ///
    /// Errors: `Missing` where the calibration solves for nothing (no sensor follows a rate or force), `Value` where the sensors' sensitivities
    /// cannot be inverted.
    pub fn new(calibration: &Calibration) -> Result<Self> {
        if calibration.solved().next().is_none() {
            let why: Vec<String> =
                calibration.left_out.iter().map(|(sensor, why)| format!("{sensor}: {why}")).collect();
            return Err(Malformed::new(Fault::Missing, "this calibration corrects nothing")
                .expected("a sensor whose model line follows a rate w_* or a specific force a_*")
                .found(if why.is_empty() { "none".into() } else { why.join("; ") }));
        }
        let bound: Vec<Bound> = calibration
            .lines
            .iter()
            .map(|line| Bound::new(line, calibration, &calibration.inputs))
            .collect::<Result<_>>()?;
        let mut corrector = Corrector {
            bound,
            inputs: calibration.inputs.clone(),
            parameters: calibration.parameters.values.clone(),
            covariance: square(&calibration.parameters.covariance),
            bias: DVector::zeros(0),
            sensitivity: DMatrix::zeros(0, 0),
            matrix: DMatrix::zeros(0, 0),
            parts: parts(&calibration.inputs),
        };
        let zero = vec![0.0; corrector.solved()];
        let fallbacks = corrector.fallbacks();
        let (bias, sensitivity) = corrector.lines_at(&zero, &fallbacks);
        let Some(matrix) = inverse(&sensitivity) else {
            return Err(Malformed::new(Fault::Value, "the sensors' sensitivities cannot be inverted")
                .expected("sensors along independent directions")
                .found(format!("sensitivities {sensitivity:.3e}")));
        };
        (corrector.bias, corrector.sensitivity, corrector.matrix) = (bias, sensitivity, matrix);
        Ok(corrector)
    }

    /// How many inputs are solved for.
    pub(crate) fn solved(&self) -> usize {
        self.inputs.iter().filter(|i| i.solved).count()
    }

    /// Readings at zero input, one for each sensor.
    pub fn bias(&self) -> &[f64] {
        self.bias.as_slice()
    }

    /// `d reading / d input` at zero input, sensors x solved inputs.
    pub fn sensitivity(&self) -> &DMatrix<f64> {
        &self.sensitivity
    }

    /// Slope of each line by the specific force along x, y and z at zero input, whether the forces are solved for or given.
    pub(super) fn by_force(&self) -> Vec<Vector3<f64>> {
        let mut by_force = Vec::new();
        let zero = vec![0.0; self.solved()];
        self.each_line(&zero, &self.fallbacks(), |_, bound, _, slopes| by_force.push(bound.by_input(slopes).1));
        by_force
    }

    /// `M` of `q = M (s - b)`, solved inputs x sensors.
    pub fn matrix(&self) -> &DMatrix<f64> {
        &self.matrix
    }

    /// Rate and specific force that one unit of each input stands for, in [`Calibration::inputs`] order.
    pub(super) fn parts(&self) -> &[(Vector3<f64>, Vector3<f64>)] {
        &self.parts
    }

    /// The values of given inputs where none are given, one value for each of them.
    pub(crate) fn fallbacks(&self) -> Vec<f64> {
        self.inputs.iter().filter(|i| !i.solved).map(|i| i.fallback()).collect()
    }

    /// Given values with the fallbacks of those that are not there.
    fn filled(&self, given: &[f64]) -> Vec<f64> {
        let mut filled = self.fallbacks();
        filled.iter_mut().zip(given).for_each(|(slot, value)| *slot = *value);
        filled
    }

    /// The first-order correction `M (s - b)`.
    pub fn linear(&self, readings: &[f64]) -> Vec<f64> {
        let difference = DVector::from_fn(self.bound.len(), |i, _| readings.or_nan(i) - self.bias[i]);
        (&self.matrix * difference).as_slice().to_vec()
    }

    /// Readings of all sensors for these inputs (solved and given): the lines themselves.
    pub fn readings(&self, inputs: &[f64], given: &[f64]) -> Vec<f64> {
        let (mut room, mut values, mut scratch) = (Vec::new(), Vec::new(), Scratch::default());
        let state = self.state(inputs, given, &mut room);
        let value = |bound: &Bound| {
            bound.fill(&state, &mut values);
            bound.tape.value(&values, &mut scratch)
        };
        self.bound.iter().map(value).collect()
    }

    /// Correct one sample: readings in [`Calibration::lines`] order, given inputs in their order (short or empty: their fallbacks).
    ///
    /// The first order is the start; then `q <- q + M (s - f(q))` while it contracts, and where it does not Newton's steps
    /// `q <- q + (M df/dq)^-1 M (s - f(q))`, whose solution is the same.
    pub fn correct(&self, readings: &[f64], given: &[f64]) -> Corrected {
        let filled = self.filled(given);
        let mut q = vec![0.0; self.solved()];
        let size: Vec<f64> = (0..q.len())
            .map(|i| (0..self.bound.len()).map(|j| (self.matrix[(i, j)] * readings.or_nan(j)).abs()).sum())
            .collect();
        let (mut newton, mut last) = (false, f64::INFINITY);
        for round in 0..ROUNDS {
            let at = self.readings(&q, &filled);
            let difference = DVector::from_fn(self.bound.len(), |i, _| readings.or_nan(i) - at.at(i));
            let mut step = Some(&self.matrix * difference);
            if newton {
                let slopes = &self.matrix * self.lines_at(&q, &filled).1;
                step = step.and_then(|step| slopes.lu().solve(&step));
            }
            let Some(step) = step.filter(|step| step.iter().all(|dq| dq.is_finite())) else { break };
            let share = |((q, dq), size): ((&f64, &f64), &f64)| match *dq {
                0.0 => 0.0,
                dq => dq.abs() / (q + dq).abs().max(*size),
            };
            let change = q.iter().zip(step.iter()).zip(&size).map(share).fold(0.0, f64::max);
            if !newton && change > SETTLED && (change >= last || round >= CONTRACTING) {
                newton = true;
                continue;
            }
            q.iter_mut().zip(step.iter()).for_each(|(q, dq)| *q += dq);
            // rounding of the slopes comes on top in Newton's steps
            if change <= if newton { 4.0 * SETTLED } else { SETTLED } {
                return Corrected { inputs: q, converged: true };
            }
            last = change;
        }
        Corrected { inputs: vec![f64::NAN; q.len()], converged: false }
    }

    /// Covariance of the corrected inputs from the calibration alone (not the noise of the sample), solved x solved; `None` where no
    /// uncertainty is known.
    pub fn covariance(&self, inputs: &[f64], given: &[f64]) -> Option<DMatrix<f64>> {
        if self.covariance.is_empty() {
            return None;
        }
        let c = self.inputs_by_parameter(inputs, given)?;
        let covariance = &c * &self.covariance * c.transpose();
        covariance.iter().all(|v| v.is_finite()).then_some(covariance)
    }

    /// `dq/dp = -(df/dq)^-1 df/dp`, solved inputs x parameters.
    pub(super) fn inputs_by_parameter(&self, inputs: &[f64], given: &[f64]) -> Option<DMatrix<f64>> {
        let filled = self.filled(given);
        Some(inverse(&self.lines_at(inputs, &filled).1)? * self.by_parameter(inputs, &filled))
    }

    /// Rate, force and all given values for these inputs.
    fn state<'a>(&'a self, inputs: &[f64], given: &[f64], room: &'a mut Vec<f64>) -> State<'a> {
        let (mut rate, mut force) = (Vector3::zeros(), Vector3::zeros());
        room.clear();
        let (mut next_solved, mut next_given) = (inputs.iter(), given.iter());
        for (input, (by_rate, by_force)) in self.inputs.iter().zip(&self.parts) {
            let value = if input.solved { next_solved.next() } else { next_given.next() };
            let value = value.copied().unwrap_or(f64::NAN); // fewer than there are: no value
            rate += by_rate * value;
            force += by_force * value;
            room.push(value);
        }
        State { rate, force, given: room, parameters: &self.parameters }
    }

    /// Each line with its value and its slopes by each of its names.
    fn each_line(&self, inputs: &[f64], given: &[f64], mut each: impl FnMut(usize, &Bound, f64, &[f64])) {
        let (mut room, mut values, mut scratch) = (Vec::new(), Vec::new(), Scratch::default());
        let state = self.state(inputs, given, &mut room);
        for (i, bound) in self.bound.iter().enumerate() {
            bound.fill(&state, &mut values);
            let mut slopes = vec![0.0; bound.slots.len()];
            let value = bound.tape.gradient(&values, &mut scratch, &mut slopes);
            each(i, bound, value, &slopes);
        }
    }

    /// Values of the lines, and their slopes by the solved inputs.
    fn lines_at(&self, inputs: &[f64], given: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let mut at = DVector::zeros(self.bound.len());
        let mut slopes = DMatrix::zeros(self.bound.len(), self.solved());
        self.each_line(inputs, given, |i, bound, value, gradient| {
            at[i] = value;
            let (by_rate, by_force) = bound.by_input(gradient);
            let solved = self.inputs.iter().zip(&self.parts).filter(|(input, _)| input.solved);
            for (j, (_, (rate, force))) in solved.enumerate() {
                slopes[(i, j)] = by_rate.dot(rate) + by_force.dot(force);
            }
        });
        (at, slopes)
    }

    /// `-df/dp`, sensors x parameters.
    fn by_parameter(&self, inputs: &[f64], given: &[f64]) -> DMatrix<f64> {
        let mut slopes = DMatrix::zeros(self.bound.len(), self.parameters.len());
        self.each_line(inputs, given, |i, bound, _, gradient| {
            for (slot, slope) in bound.slots.iter().zip(gradient) {
                if let Slot::Parameter(k) = slot {
                    slopes[(i, *k)] -= slope;
                }
            }
        });
        slopes
    }
}

/// The vectors whose multiples add up to the rate and the force: for each kind the rows of the pseudo-inverse of the inputs' directions, so that
/// what no input fixes is zero.
fn parts(inputs: &[LineInput]) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    let mut parts = vec![(Vector3::zeros(), Vector3::zeros()); inputs.len()];
    for quantity in [Quantity::Rate, Quantity::Force] {
        let which: Vec<usize> =
            (0..inputs.len()).filter(|k| inputs.get(*k).is_some_and(|i| i.quantity == quantity)).collect();
        if which.is_empty() {
            continue;
        }
        let directions = DMatrix::from_fn(which.len(), 3, |i, j| inputs[which[i]].direction()[j]);
        let perpendicular = (0..which.len())
            .all(|i| (0..i).all(|j| inputs[which[i]].direction().dot(&inputs[which[j]].direction()).abs() < 1e-15));
        let inverse = match perpendicular {
            // directions that are perpendicular are their own inverse, without rounding
            true => DMatrix::from_fn(3, which.len(), |i, j| {
                let direction = inputs[which[j]].direction();
                direction[i] / direction.norm_squared()
            }),
            // the singular value decomposition of at most a few unit rows cannot fail on finite numbers; zeros would say so in the readings
            false => directions.pseudo_inverse(1e-9).unwrap_or_else(|_| DMatrix::zeros(3, which.len())),
        };
        for (column, k) in which.iter().enumerate() {
            let v = Vector3::new(inverse[(0, column)], inverse[(1, column)], inverse[(2, column)]);
            *(if quantity == Quantity::Rate { &mut parts[*k].0 } else { &mut parts[*k].1 }) = v;
        }
    }
    parts
}

/// The inverse of a square matrix, the pseudo-inverse (least squares) of a tall one; columns are scaled to one size first.
fn inverse(a: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let (m, n) = a.shape();
    if m < n || a.iter().any(|x| !x.is_finite()) {
        return None;
    }
    let scales: Vec<f64> = (0..n).map(|j| a.column(j).norm()).collect();
    if scales.iter().any(|s| !(*s > 0.0)) {
        return None;
    }
    let scaled = DMatrix::from_fn(m, n, |i, j| a[(i, j)] / scales[j]);
    let inverse = if m == n {
        // rows too: gyros and accelerometers read in different units
        let rows: Vec<f64> = (0..m).map(|i| scaled.row(i).norm()).collect();
        if rows.iter().any(|r| !(*r > 0.0)) {
            return None;
        }
        let both = DMatrix::from_fn(m, n, |i, j| scaled[(i, j)] / rows[i]);
        let solved = both.full_piv_lu().try_inverse()?;
        DMatrix::from_fn(n, m, |i, j| solved[(i, j)] / rows[j])
    } else {
        let qr = scaled.clone().qr();
        let r = qr.r();
        if (0..n).any(|k| r[(k, k)].abs() < 1e-12) {
            return None;
        }
        r.solve_upper_triangular(&qr.q().transpose())?
    };
    let inverse = DMatrix::from_fn(n, m, |i, j| inverse[(i, j)] / scales[i]);
    inverse.iter().all(|x| x.is_finite()).then_some(inverse)
}

fn square(rows: &[Vec<f64>]) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), rows.len(), |i, j| rows.at(i).at(j))
}
