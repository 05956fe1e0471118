//! A random walk that the mission does not state: angle random walk of the gyros, velocity random walk of the accelerometers.
//!
//! With a walk of density `q` the innovations `e` of what some causes leave (see `whiten.rs`) have the likelihood
//!
//! ```text
//! -2 ln L(q) = sum e^2 + sum ln(h P h^T + u^2)          (the causes fitted anew for each q)
//! ```
//!
//! A walk is named where it is far likelier than none and than every set of other causes, and where its innovations are white: of the right size
//! in each channel, without memory from row to row. A pattern that is none is not: nothing else fits the sizes of seven channels with one number.

use super::cause::Cause;
use super::errors::{ImuErrors, Instrument};
use super::measured::CHANNELS;
use super::mission::Mission;
use super::refine::{State, Walk};
use super::search::Products;
use super::signatures::{Instant, instants, motion, times};
use super::whiten::whiten;
use crate::diagnosis::NoiseFrom;
use crate::linear::{dot, normalise};

/// Densities that are tried first, rad/sqrt(s) or (m/s)/sqrt(s) alike: their range, and the factor between them.
const RANGE: (f64, f64) = (1e-9, 1e-2);
const FACTOR: f64 = 4.0;

/// A random walk found.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wander {
    pub instrument: Instrument,
    /// Its density, SI.
    pub density: f64,
    pub u: f64,
    /// `-2 ln L` with it, but for the constant that it has without.
    pub deviance: f64,
    /// By how much it is less than that of none.
    pub gain: f64,
}

impl Wander {
    /// The cause.
    pub fn cause(&self) -> Cause {
        Cause::RandomWalk(self.instrument)
    }

    /// The mission with it.
    pub fn stated(&self, mission: &Mission) -> Mission {
        let mut mission = mission.clone();
        mission.errors = with(&mission.errors, self.instrument, self.density);
        mission
    }
}

fn with(errors: &ImuErrors, instrument: Instrument, density: f64) -> ImuErrors {
    let mut errors = *errors;
    let triad = if instrument == Instrument::Gyro { &mut errors.gyro } else { &mut errors.accelerometer };
    triad.random_walk = triad.random_walk.hypot(density);
    errors
}

impl Walk<'_> {
    /// The random walk that may explain what a state leaves, or what it needs causes for that change in time; if one does.
    pub fn wander(&self, state: &State) -> Option<Wander> {
        let fixed = self.is_complete(state) && state.set.iter().all(Cause::is_constant);
        if fixed || self.case.from != NoiseFrom::Stated {
            return None;
        }
        // beside all ordinary causes, of which none is left out
        let state = self.ordinary.as_ref().unwrap_or(state);
        let mut columns = state.flown.jacobian.clone();
        let mut laid = self.case.left(&state.flown.predicted);
        for (column, value) in columns.iter().zip(&state.values) {
            laid.iter_mut().zip(column).for_each(|(y, c)| *y += c * value);
        }
        columns.push(laid);
        let one = |instrument: Instrument| -> Option<Wander> {
            let unit = self.unit(instrument);
            let fit = |density: f64| self.deviance(&unit, density, &state.out, &columns).map(|(deviance, _)| deviance);
            let none = fit(0.0)?;
            let mut best = (none, 0.0);
            let mut density = RANGE.0;
            while density < RANGE.1 {
                if let Some(own) = fit(density).filter(|own| *own < best.0) {
                    best = (own, density);
                }
                density *= FACTOR;
            }
            if best.1 == 0.0 {
                return None;
            }
            // golden section on the logarithm
            let share = 0.5 * (5f64.sqrt() - 1.0);
            let (mut low, mut high) = ((best.1 / FACTOR).ln(), (best.1 * FACTOR).ln());
            for _ in 0..24 {
                let (a, b) = (high - share * (high - low), low + share * (high - low));
                if fit(a.exp())? < fit(b.exp())? { high = b } else { low = a }
            }
            let density = (0.5 * (low + high)).exp();
            let (deviance, white) = self.deviance(&unit, density, &state.out, &columns)?;
            // curvature of the deviance in the density's logarithm
            let step = 0.1_f64;
            let bend = (fit(density * step.exp())? - 2.0 * deviance + fit(density * (-step).exp())?) / (step * step);
            let u = if bend > 0.0 { density * (2.0 / bend).sqrt() } else { density };
            let found = Wander { instrument, density, u, deviance, gain: none - deviance };
            (found.gain > self.penalty && self.is_white(&white, &state.out)).then_some(found)
        };
        let both = [Instrument::Gyro, Instrument::Accelerometer].map(one);
        both.into_iter().flatten().min_by(|a, b| a.deviance.total_cmp(&b.deviance))
    }

    /// The score of a state with all that its random walk costs.
    pub fn score_of_all(&self, state: &State) -> f64 {
        let own = self.wander.map_or(0.0, |own| self.penalty + self.case.settings.rank_penalty * own.cause().rank());
        self.score(state) + self.case.spread(self.u, &state.out) + own
    }

    /// What the random walk of one instrument alone builds up at the measured rows, for a density of one.
    fn unit(&self, instrument: Instrument) -> Vec<Vec<Instant>> {
        let case = &self.case;
        let mut mission = case.mission.clone();
        mission.errors = with(&mission.errors.noiseless(), instrument, 1.0);
        let runs = case.measured.runs.iter().zip(times(case.measured));
        runs.map(|(run, times)| instants(&mission, motion(&mission, run.motion), &times)).collect()
    }

    /// `-2 ln L` with a density beside the mission's own walks, and the innovations that are left; the last of the columns is what they explain.
    fn deviance(
        &self,
        unit: &[Vec<Instant>],
        density: f64,
        out: &[usize],
        columns: &[Vec<f64>],
    ) -> Option<(f64, Vec<f64>)> {
        let case = &self.case;
        let square = density * density;
        let mut walks = unit.to_vec();
        walks.iter_mut().flatten().flat_map(|own| own.walk.iter_mut().flatten()).for_each(|v| *v *= square);
        for (own, more) in walks.iter_mut().flatten().zip(case.columns.walks.iter().flatten()) {
            let pairs = own.walk.iter_mut().flatten().zip(more.walk.iter().flatten());
            pairs.for_each(|(v, more)| *v += more);
        }
        let mut columns = columns.to_vec();
        let size = whiten(case.measured, &walks, &case.without(self.u, out), &mut columns);
        let residual = columns.pop()?;
        let count = columns.len();
        columns.iter_mut().for_each(|column| {
            normalise(column);
        });
        let products = Products::new(columns.clone(), &residual, vec![0.0; count], 0.0);
        let solved = products.damped(&(0..count).collect::<Vec<usize>>(), 1e-9)?;
        let mut left = residual;
        for (column, value) in columns.iter().zip(&solved.values) {
            left.iter_mut().zip(column).for_each(|(y, c)| *y -= c * value);
        }
        let deviance = dot(&left, &left) + size;
        deviance.is_finite().then_some((deviance, left))
    }

    /// Are innovations of unit size in each channel of each run, in both its halves, and without memory?
    fn is_white(&self, white: &[f64], out: &[usize]) -> bool {
        let mut groups: Vec<Vec<f64>> = vec![Vec::new(); self.case.measured.runs.len() * CHANNELS];
        for (at, (cell, value)) in self.case.measured.cells().zip(white).enumerate() {
            if !out.contains(&at) {
                groups.get_mut(cell.run * CHANNELS + cell.channel).into_iter().for_each(|group| group.push(*value));
            }
        }
        let most = self.case.settings.white;
        let sized = |values: &[f64]| {
            let n = values.len() as f64;
            ((dot(values, values) - n) / (2.0 * n).sqrt()).abs() < most
        };
        groups.iter().filter(|group| group.len() >= 8).all(|group| {
            let (first, second) = group.split_at(group.len() / 2);
            let memory: f64 = group.iter().zip(group.iter().skip(1)).map(|(a, b)| a * b).sum();
            sized(first) && sized(second) && (memory / (group.len() as f64).sqrt()).abs() < most
        })
    }
}
