//! A bias or a channel of the reference that goes up and down, as under a temperature that is held between two limits.
//!
//! ```text
//! x sin(2 pi t / T + phase) = a cos(2 pi t / T) + b sin(2 pi t / T),      x^2 = a^2 + b^2,  tan(phase) = a / b
//! ```
//!
//! At a period `T` it is linear in `a` and `b`. Every bias and every channel is tried with every whole number of half waves in the run, the other
//! causes fitted anew beside it; the period is made finer about the best (`sharpen.rs`). It has the rank of a cause with two fitted numbers more,
//! its period and its phase.

use super::case::Case;
use super::cause::{Cause, Change};
use super::refine::{State, Walk};
use super::search::INDEPENDENT;
use super::sharpen::By;
use super::weighed::Weighed;
use crate::linear::{dot, orthonormal, project};
use std::f64::consts::FRAC_PI_2;

/// Half waves in a run that are tried: fewer are a ramp or a warm-up,
const LEAST: usize = 2;
/// more than one in so many rows is no wave that the rows show,
const SEEN: usize = 4;
/// and no more than this.
const MOST: usize = 80;
/// Biases and channels whose period is made finer: those whose waves take off most.
const FINER: usize = 6;
/// Waves that take off the same, of which each is tried.
const TRIED: usize = 4;
/// Waves of one set that are looked for.
const ROUNDS: usize = 2;

/// A wave beside some causes: what it takes off the sum of squares, and its amplitude.
pub(super) struct WaveFit {
    pub cause: Cause,
    pub size: f64,
    pub gain: f64,
}

impl Weighed {
    /// The best phase of a wave of this period of a bias or a channel, beside what an orthonormal basis and `residual` outside of it stand for;
    /// weighted columns. `None` for what does not wave, or is not independent.
    pub(super) fn wave(&self, of: &Cause, period: f64, (basis, residual): (&[Vec<f64>], &[f64])) -> Option<WaveFit> {
        let mut columns = [self.made.of(&of.waving(period, FRAC_PI_2)?), self.made.of(&of.waving(period, 0.0)?)];
        self.weigh(&mut columns);
        let whole: [f64; 2] = std::array::from_fn(|k| columns.get(k).map_or(0.0, |c| dot(c, c)));
        columns.iter_mut().for_each(|column| project(column, basis));
        let [cosine, sine] = &columns;
        let (cc, cs, ss) = (dot(cosine, cosine), dot(cosine, sine), dot(sine, sine));
        let determinant = cc * ss - cs * cs;
        let [c, s] = whole;
        if !(cc > INDEPENDENT * c && ss > INDEPENDENT * s && determinant > INDEPENDENT * cc * ss) {
            return None;
        }
        let (along_c, along_s) = (dot(cosine, residual), dot(sine, residual));
        let a = (ss * along_c - cs * along_s) / determinant;
        let b = (cc * along_s - cs * along_c) / determinant;
        let cause = of.waving(period, a.atan2(b))?;
        Some(WaveFit { cause, size: a.hypot(b), gain: a * along_c + b * along_s })
    }
}

impl<'a> Walk<'a> {
    /// The time of the last row, s.
    pub(super) fn last(&self) -> f64 {
        self.case.measured.cells().fold(f64::MIN_POSITIVE, |last, cell| last.max(cell.time))
    }

    /// The waves that take most off what a state leaves, of each bias and channel the likeliest, if they are worth their price; the best first.
    ///
    /// Beside causes that a wave makes needless several take off the same.
    fn likeliest_waves(&self, state: &State) -> Vec<WaveFit> {
        let rows = self.weighed(&state.out);
        let left = self.case.left(&state.flown.predicted);
        let mut fixed = rows.rows(state.flown.jacobian.iter().chain([&left]));
        let Some(mut residual) = fixed.pop() else { return Vec::new() };
        let basis = orthonormal(fixed, INDEPENDENT);
        project(&mut residual, &basis);
        let last = self.last();
        // no run, no wave
        let longest = rows.short.measured.runs.iter().map(|run| run.rows.len()).max().unwrap_or_default();
        let most = (longest / SEEN).clamp(LEAST, MOST);
        let at = |cause: &Cause, period: f64| {
            let own = rows.wave(cause, period, (&basis, &residual))?;
            Some((-own.gain, own))
        };
        let coarse = |cause: &Cause| {
            let periods = (LEAST..=most).map(|half_waves| 2.0 * last / half_waves as f64);
            let gains = periods.filter_map(|period| Some((at(cause, period)?.0, period)));
            gains.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(gain, period)| (gain, period, *cause))
        };
        // what may grow may go up and down
        let grows =
            |own: &&Cause| matches!(own, Cause::Changing(_, Change::Ramp) | Cause::Reference(_, Some(Change::Ramp)));
        let mut likeliest: Vec<(f64, f64, Cause)> = self.case.causes.iter().filter(grows).filter_map(coarse).collect();
        likeliest.sort_by(|a, b| a.0.total_cmp(&b.0));
        let finest = |(_, period, cause): &(f64, f64, Cause)| {
            By::HalfWave(last).finest(*period, |period| at(cause, period)).map(|(_, own)| own)
        };
        let mut found: Vec<WaveFit> = likeliest.iter().take(FINER).filter_map(finest).collect();
        let settings = &self.case.settings;
        let price = |own: &WaveFit| self.penalty + settings.rank_penalty * own.cause.rank();
        found.retain(|own| own.gain > price(own) && !self.case.is_absurd(&own.cause, own.size));
        found.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        let near = found.first().map_or(0.0, |best| best.gain - self.penalty - settings.indistinguishable);
        found.retain(|own| own.gain >= near);
        found.truncate(TRIED);
        found
    }

    /// Walks from a state with a wave beside its causes, and with a second one where something is left.
    pub(super) fn go_up_and_down(&mut self, best: &mut (State, Case<'a>), start: &State) {
        let mut from = start.clone();
        for round in 0..ROUNDS {
            self.case = best.1.clone();
            let mut longer: Option<State> = None;
            for wave in self.likeliest_waves(&from) {
                let (mut set, mut values) = (from.set.clone(), from.values.clone());
                set.push(wave.cause);
                values.push(wave.size);
                self.case = best.1.clone();
                self.tell(round, &set);
                let state = self.refine_or_damp(&set, &values, &from.out);
                let Some(state) = state.and_then(|state| self.walk(state, self.case.settings.causes)) else { continue };
                if longer.as_ref().is_none_or(|own| self.score(&state) < self.score(own)) {
                    longer = Some(state.clone());
                }
                self.keep(best, Some(state));
            }
            match longer {
                Some(state) if !self.is_finished(&best.0) => from = state,
                _ => return,
            }
        }
    }
}
