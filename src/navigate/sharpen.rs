//! The time of a step or a warm-up and the period of a wave, refined between the points of the grid of candidates.

use super::cause::{Cause, Change};
use super::refine::{Search, State};
use super::weighed::Weighed;
use std::rc::Rc;

/// Trials on each side of a time, on each of so many levels.
const PARTS: i32 = 8;
const LEVELS: i32 = 5;

/// Rounds of refining the edges and the period of a square wave in turn, at most.
const ROUNDS: usize = 24;
/// A refinement that reduces the sum of squares by less, in variances of the noise, is none.
pub(super) const SHARPER: f64 = 0.5;

/// How a time is varied: by how much at first.
#[derive(Clone, Copy)]
pub(super) enum By {
    /// A step's time, s.
    Shift(f64),
    /// A warm-up's, in its logarithm.
    Factor(f64),
    /// A wave's period, by one half wave more or less in a time as long as this, s.
    HalfWave(f64),
}

impl By {
    /// The time near `start` at which `try_at` is least, on ever finer grids, with its value there; `None` where it has none at the start.
    pub(super) fn finest<T>(self, start: f64, try_at: impl Fn(f64) -> Option<(f64, T)>) -> Option<(f64, T)> {
        let (mut best, mut time, mut width) = (try_at(start)?, start, 1.0);
        for _ in 0..LEVELS {
            let middle = time;
            for part in (-PARTS..=PARTS).filter(|part| *part != 0) {
                let trial = self.moved(middle, width * f64::from(part) / f64::from(PARTS));
                if !(trial > 0.0 && trial.is_finite()) {
                    continue;
                }
                if let Some(better) = try_at(trial).filter(|(least, _)| *least < best.0) {
                    (best, time) = (better, trial);
                }
            }
            width *= 1.5 / f64::from(PARTS);
        }
        Some(best)
    }

    fn moved(self, time: f64, share: f64) -> f64 {
        match self {
            By::Shift(most) => time + share * most,
            By::Factor(most) => time * (share * most).exp(),
            // what is longer than the run is no wave that it shows
            By::HalfWave(last) => (1.0 / (1.0 / time + share * 0.5 / last).max(f64::MIN_POSITIVE)).min(last),
        }
    }
}

impl Search<'_> {
    /// The time of a step, a warm-up or a wave is one of a coarse grid: the best one near it, on the linear model, finer and finer. Was any moved?
    pub(super) fn sharpen(&self, state: &State, set: &mut [Cause], values: &mut [f64]) -> bool {
        let steps = self.case.causes.iter().filter_map(|cause| match cause {
            Cause::Changing(_, Change::Step(time)) => Some(*time),
            _ => None,
        });
        let spacing = steps.fold(f64::INFINITY, f64::min);
        let last = self.last();
        if !set.iter().any(Cause::is_course) {
            return false;
        }
        // in all rows: a time is known better than a row of fewer is long
        let mut rows = self.weighed(&state.out);
        if rows.short.is_short() {
            rows = Rc::new(Weighed::whole(&self.case, self.u, &state.out));
        }
        let shortest = last / rows.short.measured.longest_run().max(1) as f64;
        let (columns, observed) = self.linearised(state, &rows);
        let member = |cause: &Cause| state.set.iter().position(|other| other == cause);
        let column = |cause: &Cause| {
            let kept = member(cause).and_then(|k| columns.get(k));
            kept.cloned().unwrap_or_else(|| rows.of(&self.case, cause))
        };
        let mut moved = false;
        for k in 0..set.len() {
            let Some(&kind) = set.get(k) else { continue };
            // what the others leave
            let fixed = set.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, cause)| column(cause));
            let others = rows.given(fixed, observed.clone());
            let at = |change: Change| {
                let fit = match change {
                    Change::Wave { period, .. } => rows.wave(&kind, period, &others)?,
                    // a change that is over between two rows is not visible in them
                    Change::WarmUp(time) if time < shortest => return None,
                    _ => rows.fit(kind.with_change(change)?, &others)?,
                };
                Some((-fit.gain, fit))
            };
            let found = match kind.change() {
                Some(Change::Square { .. }) => rows.square(&kind, &others, last, ROUNDS).map(|fit| (-fit.gain, fit)),
                Some(Change::Step(time)) => By::Shift(spacing).finest(time, |time| at(Change::Step(time))),
                Some(Change::WarmUp(time)) => {
                    By::Factor(3f64.ln()).finest(time.max(shortest), |time| at(Change::WarmUp(time)))
                }
                Some(Change::Wave { period, phase }) => {
                    By::HalfWave(last).finest(period, |period| at(Change::Wave { period, phase }))
                }
                _ => continue,
            };
            let before = rows.fit(kind, &others).map(|fit| fit.gain);
            if let Some(((_, fit), before)) = found.zip(before)
                && fit.gain - before > SHARPER
                && let (Some(cause), Some(size)) = (set.get_mut(k), values.get_mut(k))
            {
                (*cause, *size, moved) = (fit.cause, fit.size, true);
            }
        }
        moved
    }
}
