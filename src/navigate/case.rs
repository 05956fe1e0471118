//! One question about measured navigation errors: its causes and their columns, its noise, and the full simulation of some causes.

use super::cause::{self, Cause};
use super::changing::Columns;
use super::errors::{ErrorSource, ImuErrors};
use super::measured::{CHANNELS, Channels, Measured};
use super::mission::Mission;
use super::settings::Settings;
use super::signatures;
use super::whiten::{Walks, whiten};
use crate::diagnosis::{Gap, NoiseFrom};
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use crate::linear::{dot, norm};
use crate::uncertainty::quantiles::chi_square_survival;
use std::rc::Rc;

/// A cell that is left out has so many times its standard uncertainty.
const LEFT_OUT: f64 = 1e7;
/// Size of a finite difference, in standard deviations of all values together.
const DIFFERENCE: f64 = 30.0;
/// but standard deviations no smaller than these (rad, m/s, m), against which the rounding of the simulation is negligible.
const ROUNDED: Channels = [1e-9, 1e-9, 1e-9, 1e-5, 1e-5, 1e-2, 1e-2];

/// One question, and what is common to all rounds.
#[derive(Clone)]
pub(super) struct Case<'a> {
    pub mission: &'a Mission,
    pub measured: &'a Measured,
    pub causes: Vec<Cause>,
    pub columns: Rc<Columns>,
    /// The columns of all causes.
    pub raw: Rc<Vec<Vec<f64>>>,
    /// Errors around which the columns are the derivatives,
    pub around: ImuErrors,
    /// and the full simulation of them.
    pub there: Rc<Vec<f64>>,
    pub from: NoiseFrom,
    pub settings: Settings,
}

/// The full simulation at some values of some causes.
#[derive(Clone)]
pub(super) struct Flown {
    pub predicted: Vec<f64>,
    /// Derivatives by each cause.
    pub jacobian: Vec<Vec<f64>>,
}

impl<'a> Case<'a> {
    pub fn new(mission: &'a Mission, measured: &'a Measured, settings: &Settings) -> Result<Self> {
        settings.common.check()?;
        let stated = measured.cells().all(|cell| cell.u.is_some());
        if mission.errors.is_noisy() && !stated {
            return Err(Malformed::new(Fault::Missing, "random walks and unknown noise cannot be distinguished")
                .expected("a standard uncertainty (a column with _u) of everything measured, or a mission without random walks"));
        }
        let columns = Columns::new(mission, measured);
        let mut present = [false; CHANNELS];
        measured.cells().for_each(|cell| present.get_mut(cell.channel).into_iter().for_each(|slot| *slot = true));
        // fewer times of a step where they would fill the memory
        let steps = if measured.count() > 20_000 { 8 } else { 24 };
        let causes = cause::catalogue(&present, measured.last_time(), steps);
        let raw = causes.iter().map(|cause| columns.of(cause)).collect();
        Ok(Case {
            mission,
            measured,
            causes,
            columns: Rc::new(columns),
            raw: Rc::new(raw),
            around: mission.errors,
            there: Rc::new(signatures::prediction(mission, measured, &mission.errors)),
            from: if stated { NoiseFrom::Stated } else { NoiseFrom::Residuals },
            settings: *settings,
        })
    }

    /// The same question with columns around other errors than the mission's; `None` where those cannot be flown.
    pub fn around(&self, errors: &ImuErrors, u: &[f64]) -> Option<Case<'a>> {
        let steps: Vec<f64> =
            ErrorSource::catalogue().iter().map(|source| self.step(&Cause::Constant(*source), u)).collect();
        let there = signatures::prediction(self.mission, self.measured, errors);
        let columns = self.columns.around(self.mission, self.measured, errors, &steps);
        let raw: Vec<Vec<f64>> = self.causes.iter().map(|cause| columns.of(cause)).collect();
        if there.iter().chain(raw.iter().flatten()).any(|v| !v.is_finite()) {
            return None;
        }
        let (columns, raw, there) = (Rc::new(columns), Rc::new(raw), Rc::new(there));
        Some(Case { columns, raw, there, around: *errors, ..self.clone() })
    }

    /// The same question with random walks that the mission does not state.
    pub fn with_walks(&self, walks: Walks) -> Case<'a> {
        Case { columns: Rc::new(self.columns.walking(walks)), ..self.clone() }
    }

    /// The question for the first rows alone, `early`, with their values marked in `kept`.
    pub fn until<'b>(&self, early: &'b Measured, kept: &[bool]) -> Case<'b>
    where
        'a: 'b,
    {
        let cut = |values: &[f64]| -> Vec<f64> {
            values.iter().zip(kept).filter(|(_, kept)| **kept).map(|(value, _)| *value).collect()
        };
        Case {
            measured: early,
            raw: Rc::new(self.raw.iter().map(|column| cut(column)).collect()),
            there: Rc::new(cut(&self.there)),
            ..self.clone()
        }
    }

    /// Size of a finite difference by a constant error.
    fn step(&self, cause: &Cause, u: &[f64]) -> f64 {
        let u = u.iter().zip(self.measured.cells()).map(|(u, cell)| u.max(ROUNDED.at(cell.channel)));
        let norm = self.raw_of(cause).iter().zip(u).map(|(c, u)| (c / u) * (c / u)).sum::<f64>().sqrt();
        (DIFFERENCE / norm.max(1e-300)).min(1e-3 * cause.limit())
    }

    /// Nonlinearity: the norm of `predicted`, the full simulation of some errors, minus its linear prediction by the columns, in standard deviations, and
    /// as a share of the norm of what the errors do.
    pub fn bent(&self, errors: &ImuErrors, predicted: &[f64], u: &[f64]) -> (f64, f64) {
        let moved: Vec<f64> = predicted.iter().zip(self.there.iter()).map(|(a, b)| a - b).collect();
        let mut missed = moved.clone();
        for (source, column) in ErrorSource::catalogue().iter().zip(self.raw.iter()) {
            let by = source.of(errors) - source.of(&self.around);
            if by != 0.0 {
                missed.iter_mut().zip(column).for_each(|(slot, c)| *slot -= by * c);
            }
        }
        let [missed, moved] = [missed, moved].map(|column| norm(&self.whitened(column, u, &[])));
        (missed, missed / moved.max(f64::MIN_POSITIVE))
    }

    /// Stated standard uncertainties; where there are none, the size of the gap.
    pub fn first_u(&self, gap: &[f64]) -> Vec<f64> {
        let (sizes, _) = self.noise(gap, 0);
        // cells have channels that `sizes` lists
        self.measured.cells().map(|cell| cell.u.or(sizes.get(cell.channel).copied()).unwrap_or(1.0)).collect()
    }

    /// The same from the residuals of a fit; no less than what rounding makes of the gap.
    pub fn u_of(&self, residual: &[f64], fitted: usize, gap: &[f64]) -> Vec<f64> {
        let ((sizes, _), (first, _)) = (self.noise(residual, fitted), self.noise(gap, 0));
        let of = |channel: usize| Some(sizes.get(channel)?.max(1e-9 * first.get(channel)?));
        // likewise
        self.measured.cells().map(|cell| cell.u.or(of(cell.channel)).unwrap_or(1.0)).collect()
    }

    /// The mission's errors, changed by the values of some causes; causes that a mission does not contain are left out.
    pub fn with(&self, causes: &[Cause], values: &[f64]) -> ImuErrors {
        let mut errors = self.mission.errors;
        for (source, value) in causes.iter().zip(values).filter_map(|(cause, value)| Some((cause.constant()?, value))) {
            source.set(&mut errors, source.of(&self.mission.errors) + value);
        }
        errors
    }

    pub fn is_absurd(&self, cause: &Cause, value: f64) -> bool {
        let before = cause.constant().map_or(0.0, |source| source.of(&self.mission.errors));
        !((before + value).abs() <= cause.limit())
    }

    /// Fly some causes; `None` where the navigator runs over a pole or a cause is absurd.
    pub fn fly(&self, causes: &[Cause], values: &[f64], u: &[f64]) -> Option<Flown> {
        if causes.iter().zip(values).any(|(cause, value)| self.is_absurd(cause, *value)) {
            return None;
        }
        // constants by differences of the full simulation, side by side; the others are linear
        let mut flights = vec![self.with(causes, values)];
        let mut steps = Vec::new();
        for (k, cause) in causes.iter().enumerate() {
            if cause.constant().is_none() {
                steps.push(0.0);
                continue;
            }
            let step = self.step(cause, u);
            let mut moved = values.to_vec();
            moved.get_mut(k).into_iter().for_each(|value| *value += step);
            flights.push(self.with(causes, &moved));
            steps.push(step);
        }
        let flown = signatures::predictions(self.mission, self.measured, &flights);
        let (base, others) = flown.split_first()?;
        let mut others = others.iter();
        let mut jacobian = Vec::with_capacity(causes.len());
        let mut predicted = base.clone();
        for ((cause, value), step) in causes.iter().zip(values).zip(steps) {
            if step > 0.0 {
                let moved = others.next()?;
                jacobian.push(moved.iter().zip(base).map(|(a, b)| (a - b) / step).collect::<Vec<f64>>());
            } else {
                let column = self.raw_of(cause);
                predicted.iter_mut().zip(&column).for_each(|(slot, c)| *slot += value * c);
                jacobian.push(column);
            }
        }
        let finite = |values: &[f64]| values.iter().all(|v| v.is_finite());
        (finite(&predicted) && jacobian.iter().all(|column| finite(column))).then_some(Flown { predicted, jacobian })
    }

    /// The column of a cause, from those in memory or computed.
    pub fn raw_of(&self, cause: &Cause) -> Vec<f64> {
        let kept = self.causes.iter().position(|other| other == cause).and_then(|j| self.raw.get(j));
        kept.cloned().unwrap_or_else(|| self.columns.of(cause))
    }

    /// Weigh columns: divided by `u`, random walks whitened; cells that are left out have no weight.
    pub fn weigh(&self, u: &[f64], out: &[usize], columns: &mut [Vec<f64>]) {
        whiten(self.measured, &self.columns.walks, &self.without(u, out), columns);
    }

    /// By how much the logarithms of the innovations' variances exceed those without random walks, summed.
    pub fn spread(&self, u: &[f64], out: &[usize]) -> f64 {
        whiten(self.measured, &self.columns.walks, &self.without(u, out), &mut []).iter().sum()
    }

    /// Standard uncertainties with which cells that are left out have no weight.
    pub fn without(&self, u: &[f64], out: &[usize]) -> Vec<f64> {
        let mut u = u.to_vec();
        out.iter().for_each(|at| u.get_mut(*at).into_iter().for_each(|u| *u *= LEFT_OUT));
        u
    }

    /// A column weighed, its random walks whitened.
    pub fn whitened(&self, column: Vec<f64>, u: &[f64], out: &[usize]) -> Vec<f64> {
        let mut columns = [column];
        self.weigh(u, out, &mut columns);
        let [column] = columns;
        column
    }

    /// `measured - predicted`.
    pub fn residual(&self, predicted: &[f64]) -> Vec<f64> {
        self.measured.cells().zip(predicted).map(|(cell, p)| cell.value - p).collect()
    }

    /// What the linear model of a set has to explain, `residual + J x`, at the values `x` at which it was flown.
    pub fn observed(&self, flown: &Flown, values: &[f64]) -> Vec<f64> {
        let mut observed = self.residual(&flown.predicted);
        for (column, value) in flown.jacobian.iter().zip(values) {
            observed.iter_mut().zip(column).for_each(|(y, c)| *y += c * value);
        }
        observed
    }

    /// Can these data show a cause at some size that a navigator's unit has?
    pub fn is_visible(&self, cause: &Cause, u: &[f64]) -> bool {
        !self.is_invisible(cause, norm(&self.whitened(self.raw_of(cause), u, &[])))
    }

    /// The same by the norm of its weighed column.
    pub fn is_invisible(&self, cause: &Cause, norm: f64) -> bool {
        !(norm * cause.limit() > self.settings.unseen)
    }

    /// A gap; cells that are left out count neither in it nor in its degrees of freedom.
    pub fn gap(&self, residual: &[f64], u: &[f64], out: &[usize], fitted: usize) -> Gap {
        let white = self.whitened(residual.to_vec(), u, out);
        let chi_square = dot(&white, &white);
        let dof = white.len().saturating_sub(fitted + out.len());
        let max = white.iter().fold(0.0_f64, |max, v| max.max(v.abs()));
        let stated = self.from == NoiseFrom::Stated && dof > 0;
        let p = if stated { chi_square_survival(chi_square, dof as f64) } else { None };
        let rms = (dof > 0).then(|| (chi_square / dof as f64).sqrt());
        Gap { rms, max, chi_square, dof, p, residuals: Vec::new() }
    }
}
