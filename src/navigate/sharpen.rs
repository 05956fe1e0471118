//! The time of a step or a warm-up and the period of a wave, refined between the points of the grid of candidates.

use super::cause::{Cause, Change};
use super::periodic::SHARPER;
use super::products::INDEPENDENT;
use super::refine::{Search, State};
use super::weighed::Weighed;
use crate::linear::{dot, project};
use std::rc::Rc;

/// Trials on each side of a time, on each of so many levels.
const PARTS: i32 = 8;
const LEVELS: i32 = 5;

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
            let (start, by) = match kind.change() {
                Some(near @ Change::Square { .. }) => {
                    let before = rows.fit(kind, &others).map_or(0.0, |fit| fit.gain);
                    let found = rows.square(&kind, near, &others, last).filter(|fit| fit.gain - before > SHARPER);
                    if let Some((found, (cause, size))) = found.zip(set.get_mut(k).zip(values.get_mut(k))) {
                        (*cause, *size, moved) = (found.cause, found.size, true);
                    }
                    continue;
                }
                Some(Change::Step(time)) => (time, By::Shift(spacing)),
                Some(Change::WarmUp(time)) => (time.max(shortest), By::Factor(3f64.ln())),
                Some(Change::Wave { period, .. }) => (period, By::HalfWave(last)),
                _ => continue,
            };
            let (basis, residual) = &others;
            let square = dot(residual, residual);
            // a cause given the others: the residual sum of squares, and its size
            let fitted = |cause: &Cause| -> Option<(f64, f64)> {
                let mut projected = column(cause);
                let whole = dot(&projected, &projected);
                project(&mut projected, basis);
                let outside = dot(&projected, &projected);
                let along = dot(&projected, residual);
                (outside > INDEPENDENT * whole).then(|| (square - along * along / outside, along / outside))
            };
            // the best of its kind with this time
            let try_at = |time: f64| -> Option<(f64, (f64, Cause))> {
                let change = match by {
                    By::HalfWave(_) => {
                        let wave = rows.wave(&kind, time, &others)?;
                        return Some((square - wave.gain, (wave.size, wave.cause)));
                    }
                    // a change that is over between two rows is not visible in them
                    By::Factor(_) if time < shortest => return None,
                    By::Factor(_) => Change::WarmUp(time),
                    By::Shift(_) => Change::Step(time),
                };
                let cause = kind.with_change(change)?;
                fitted(&cause).map(|(rss, size)| (rss, (size, cause)))
            };
            let Some((before, _)) = fitted(&kind) else { continue };
            let Some((rss, (value, sharper))) = by.finest(start, try_at) else { continue };
            if before - rss > SHARPER
                && let (Some(cause), Some(size)) = (set.get_mut(k), values.get_mut(k))
            {
                (*cause, *size, moved) = (sharper, value, true);
            }
        }
        moved
    }
}
