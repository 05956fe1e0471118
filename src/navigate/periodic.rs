//! A bias or a channel of the reference that goes up and down, as under a temperature that is held between two limits.
//!
//! ```text
//! x sin(2 pi t / T + phase) = a cos(2 pi t / T) + b sin(2 pi t / T),      x^2 = a^2 + b^2,  tan(phase) = a / b
//! ```
//!
//! At a period `T` it is linear in `a` and `b`. Every bias and every channel is tried with every whole number of half waves in the run, beside a set and
//! beside nothing; the period is made finer about the best (`sharpen.rs`). Those that take off most are candidates.

use super::cause::{Cause, Change};
use super::products::INDEPENDENT;
use super::refine::{State, Walk};
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
/// Waves that are candidates: those that take off most, of each bias and channel one. They bound the work; a second wave of a set is found beside the first.
const CANDIDATES: usize = 4;

/// A wave beside some causes: what it takes off the sum of squares, and its amplitude.
pub(super) struct WaveFit {
    pub cause: Cause,
    pub size: f64,
    pub gain: f64,
}

/// What a wave is beside: an orthonormal basis, and a residual outside of it.
pub(super) type Beside = (Vec<Vec<f64>>, Vec<f64>);

impl Weighed {
    /// Cosine and sine of a wave of this period of a bias or a channel, weighed; `None` for what does not wave.
    fn both(&self, of: &Cause, period: f64) -> Option<[Vec<f64>; 2]> {
        let mut columns = [self.made.of(&of.waving(period, FRAC_PI_2)?), self.made.of(&of.waving(period, 0.0)?)];
        self.weigh(&mut columns);
        Some(columns)
    }

    /// The best phase of a wave; `None` for what does not wave, or is not independent.
    pub(super) fn wave(&self, of: &Cause, period: f64, beside: &Beside) -> Option<WaveFit> {
        phased(of, period, self.both(of, period)?, beside)
    }

    pub(super) fn beside(&self, fixed: impl IntoIterator<Item = Vec<f64>>, mut residual: Vec<f64>) -> Beside {
        let basis = orthonormal(fixed, INDEPENDENT);
        project(&mut residual, &basis);
        (basis, residual)
    }
}

fn phased(of: &Cause, period: f64, mut columns: [Vec<f64>; 2], (basis, residual): &Beside) -> Option<WaveFit> {
    let [c, s] = columns.each_ref().map(|column| dot(column, column));
    columns.iter_mut().for_each(|column| project(column, basis));
    let [cosine, sine] = &columns;
    let (cc, cs, ss) = (dot(cosine, cosine), dot(cosine, sine), dot(sine, sine));
    let determinant = cc * ss - cs * cs;
    if !(cc > INDEPENDENT * c && ss > INDEPENDENT * s && determinant > INDEPENDENT * cc * ss) {
        return None;
    }
    let (along_c, along_s) = (dot(cosine, residual), dot(sine, residual));
    let a = (ss * along_c - cs * along_s) / determinant;
    let b = (cc * along_s - cs * along_c) / determinant;
    let cause = of.waving(period, a.atan2(b))?;
    Some(WaveFit { cause, size: a.hypot(b), gain: a * along_c + b * along_s })
}

/// What may grow may go up and down.
fn grows(own: &Cause) -> bool {
    matches!(own, Cause::Changing(_, Change::Ramp) | Cause::Reference(_, Some(Change::Ramp)))
}

impl Walk<'_> {
    /// The time of the last row, s.
    pub(super) fn last(&self) -> f64 {
        self.case.measured.cells().fold(f64::MIN_POSITIVE, |last, cell| last.max(cell.time))
    }

    /// The waves that take most off: beside a state's set, beside nothing, beside what is constant of the set, and beside all of it but one cause, which a
    /// wave of another period may have called for.
    pub(super) fn likeliest_waves(&self, state: &State) -> Vec<Cause> {
        let rows = self.weighed(&state.out);
        let (own, laid) = self.laid(state, &rows);
        let with = |keep: &dyn Fn(usize) -> bool| {
            let kept = own.iter().enumerate().filter(|(k, _)| keep(*k)).map(|(_, column)| column.clone());
            rows.beside(kept, laid.clone())
        };
        let is_constant = |k: usize| state.set.get(k).is_some_and(Cause::is_constant);
        let mut settings = vec![(with(&|_| true), CANDIDATES)];
        if !state.set.is_empty() {
            settings.push((with(&|_| false), CANDIDATES));
        }
        if (0..own.len()).any(|k| !is_constant(k)) {
            settings.push((with(&is_constant), CANDIDATES));
        }
        if own.len() > 1 {
            settings.extend((0..own.len()).map(|left| (with(&|k| k != left), 1)));
        }
        let last = self.last();
        // no run, no wave
        let longest = rows.short.measured.runs.iter().map(|run| run.rows.len()).max().unwrap_or_default();
        let most = (longest / SEEN).clamp(LEAST, MOST);
        let mut coarse: Vec<Vec<(f64, f64, Cause)>> = vec![Vec::new(); settings.len()];
        for cause in self.case.causes.iter().filter(|own| grows(own)) {
            let mut best: Vec<Option<(f64, f64, Cause)>> = vec![None; settings.len()];
            for half_waves in LEAST..=most {
                let period = 2.0 * last / half_waves as f64;
                let Some(columns) = rows.both(cause, period) else { continue };
                for ((beside, _), best) in settings.iter().zip(&mut best) {
                    let gain = phased(cause, period, columns.clone(), beside).map_or(0.0, |own| own.gain);
                    if best.as_ref().is_none_or(|own| gain > own.0) {
                        *best = Some((gain, period, *cause));
                    }
                }
            }
            coarse.iter_mut().zip(best).for_each(|(all, own)| all.extend(own));
        }
        let mut found = Vec::new();
        for ((beside, count), mut all) in settings.iter().zip(coarse) {
            all.sort_by(|a, b| b.0.total_cmp(&a.0));
            let finest = |(_, period, cause): &(f64, f64, Cause)| {
                let at = |period: f64| rows.wave(cause, period, beside).map(|own| (-own.gain, own));
                By::HalfWave(last).finest(*period, at).map(|(_, own)| own)
            };
            let own = all.iter().take(*count).filter_map(finest);
            found.extend(own.filter(|own| !self.case.is_absurd(&own.cause, own.size)).map(|own| own.cause));
        }
        found
    }

    /// What may go up and down with each wave of a state's set, at its period: other biases, other channels.
    pub(super) fn alike(&self, state: &State) -> Vec<Cause> {
        let rows = self.weighed(&state.out);
        let (own, laid) = self.laid(state, &rows);
        let period = |cause: &Cause| match cause {
            Cause::Changing(_, Change::Wave { period, .. })
            | Cause::Reference(_, Some(Change::Wave { period, .. })) => Some(*period),
            _ => None,
        };
        let mut found = Vec::new();
        for (place, period) in state.set.iter().enumerate().filter_map(|(k, cause)| Some((k, period(cause)?))) {
            let others = own.iter().enumerate().filter(|(k, _)| *k != place).map(|(_, column)| column.clone());
            let beside = rows.beside(others, laid.clone());
            let is_other = |own: &&Cause| match (own, state.set.get(place)) {
                (Cause::Changing(a, _), Some(Cause::Changing(b, _))) => a != b,
                (Cause::Reference(a, _), Some(Cause::Reference(b, _))) => a != b,
                _ => true,
            };
            let waves = self.case.causes.iter().filter(|own| grows(own)).filter(is_other);
            found.extend(waves.filter_map(|own| Some(rows.wave(own, period, &beside)?.cause)));
        }
        found
    }
}
