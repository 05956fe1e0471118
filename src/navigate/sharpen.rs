//! The time of a step or a warm-up and the period of a wave, refined between the points of the grid of candidates.

use super::cause::{Cause, Change};
use super::changing::Columns;
use super::products::INDEPENDENT;
use super::refine::{Search, State};
use super::shortened::Shortened;
use super::weighed::{CourseFit, Given, Weighed};
use crate::linear::dot;
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

/// By how much a column of unit norm reduces the sum of squares given others; `None` where it depends on them.
fn gain(column: &[f64], (basis, residual): &Given) -> Option<f64> {
    let outside = 1.0 - basis.iter().map(|b| dot(b, column).powi(2)).sum::<f64>();
    (outside > INDEPENDENT).then(|| dot(column, residual).powi(2) / outside)
}

impl Search<'_> {
    /// The steps and warm-ups that reduce the sum of squares most under each condition, as many as it asks for and of each bias and channel one, with their
    /// times refined: those of the grid are too far apart for what the data say of them.
    pub(super) fn timed(&self, rows: &Weighed, conditions: &[(Given, usize)]) -> Vec<Cause> {
        let shortest = self.last() / rows.short.measured.longest_run().max(1) as f64;
        let mut found = Vec::new();
        for (given, count) in conditions {
            let mut best: Vec<(f64, Cause)> = Vec::new();
            for (cause, (column, norm)) in self.case.causes.iter().zip(&rows.unit) {
                if !matches!(cause.change(), Some(Change::Step(_) | Change::WarmUp(_))) || *norm == 0.0 {
                    continue;
                }
                let Some(gain) = gain(column, given) else { continue };
                match best.iter_mut().find(|(_, other)| other.family() == cause.family()) {
                    Some(other) if other.0 < gain => *other = (gain, *cause),
                    Some(_) => {}
                    None => best.push((gain, *cause)),
                }
            }
            best.sort_by(|a, b| b.0.total_cmp(&a.0));
            let finest = |(_, cause): &(f64, Cause)| self.finest(rows, cause, given, shortest);
            let fits = best.iter().take(*count).filter_map(finest);
            found.extend(fits.filter(|fit| !self.case.is_absurd(&fit.cause, fit.size)).map(|fit| fit.cause));
        }
        found
    }

    /// What the times, periods and phases of some causes can do: columns along the derivatives by them, of these columns' rows.
    pub(super) fn moves(&self, set: &[Cause], columns: &Columns) -> Vec<Vec<f64>> {
        let of = |cause: &Cause| {
            let beside = cause.change().map_or(Vec::new(), |change| change.beside(self.last()));
            let column = |change| cause.with_change(change).map(|cause| columns.of(&cause));
            let moved = beside.into_iter().filter_map(move |[a, b]| Some((column(a)?, column(b)?)));
            moved.map(|(a, b)| a.iter().zip(b).map(|(a, b)| b - a).collect::<Vec<f64>>()).collect::<Vec<_>>()
        };
        set.iter().flat_map(of).collect()
    }

    /// The best time near that of a step or a warm-up; `None` for what is neither.
    fn finest(&self, rows: &Weighed, cause: &Cause, given: &Given, shortest: f64) -> Option<CourseFit> {
        let at = |change: Change| {
            // a change that is over between two rows is not visible in them
            let is_seen = !matches!(change, Change::WarmUp(time) if time < shortest);
            let fit = rows.fit(cause.with_change(change).filter(|_| is_seen)?, given)?;
            Some((-fit.gain, fit))
        };
        let found = match cause.change()? {
            Change::Step(time) => By::Shift(self.spacing()).finest(time, |time| at(Change::Step(time))),
            Change::WarmUp(time) => By::Factor(3f64.ln()).finest(time.max(shortest), |time| at(Change::WarmUp(time))),
            _ => None,
        };
        found.map(|(_, fit)| fit)
    }

    /// Time between the steps of the grid, s.
    fn spacing(&self) -> f64 {
        let steps = self.case.causes.iter().filter_map(|cause| match cause {
            Cause::Changing(_, Change::Step(time)) => Some(*time),
            _ => None,
        });
        steps.fold(f64::INFINITY, f64::min)
    }

    /// The time of a step, a warm-up or a wave is one of a coarse grid: the best one near it, on the linear model, finer and finer. Was any moved?
    pub(super) fn sharpen(&self, state: &State, set: &mut [Cause], values: &mut [f64]) -> bool {
        let last = self.last();
        if !set.iter().any(Cause::is_course) {
            return false;
        }
        // in all rows: a time is known better than a row of fewer is long
        let mut rows = self.weighed(&state.out);
        if rows.short.is_short() {
            let whole = Shortened::whole(self.case.measured, &self.case.without(self.u, &state.out));
            rows = Rc::new(Weighed::of_rows(&self.case, whole, &state.out));
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
            let found = match kind.change() {
                Some(Change::Square { .. }) => rows.square(&kind, &others, last, ROUNDS),
                Some(Change::Wave { period, .. }) => rows.finest_wave(&kind, period, &others, last),
                Some(_) => self.finest(&rows, &kind, &others, shortest),
                None => continue,
            };
            let before = rows.fit(kind, &others).map(|fit| fit.gain);
            if let Some((fit, before)) = found.zip(before)
                && fit.gain - before > SHARPER
                && let (Some(cause), Some(size)) = (set.get_mut(k), values.get_mut(k))
            {
                (*cause, *size, moved) = (fit.cause, fit.size, true);
            }
        }
        moved
    }
}
