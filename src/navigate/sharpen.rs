//! The time of a step or a warm-up, finer than the grid of candidates.

use super::cause::{Cause, Change};
use super::refine::{State, Walk};
use super::search::INDEPENDENT;
use crate::linear::{dot, orthonormal, project};

impl Walk<'_> {
    /// The time of a step or a warm-up is one of a coarse grid: the best one near it, on the linear model, finer and finer. Was any moved?
    pub(super) fn sharpen(&self, state: &State, set: &mut [Cause], values: &mut [f64]) -> bool {
        const PARTS: i32 = 8;
        const LEVELS: i32 = 5;
        let steps = self.case.causes.iter().filter_map(|own| match own {
            Cause::Changing(_, Change::Step(time)) => Some(*time),
            _ => None,
        });
        let spacing = steps.fold(f64::INFINITY, f64::min);
        let member = |cause: &Cause| state.set.iter().position(|own| own == cause);
        let column = |cause: &Cause| {
            let own = member(cause).and_then(|k| state.flown.jacobian.get(k));
            own.cloned().unwrap_or_else(|| self.case.raw_of(cause))
        };
        let mut laid = self.case.left(&state.flown.predicted);
        for (column, value) in state.flown.jacobian.iter().zip(&state.values) {
            laid.iter_mut().zip(column).for_each(|(y, c)| *y += c * value);
        }
        let mut moved = false;
        for k in 0..set.len() {
            let Some(&own) = set.get(k) else { continue };
            let (start, warm) = match own {
                Cause::Changing(_, Change::Step(time)) | Cause::Reference(_, Some(Change::Step(time))) => (time, false),
                Cause::Changing(_, Change::WarmUp(time)) => (time, true),
                _ => continue,
            };
            let make = |time: f64| match own {
                Cause::Changing(source, Change::WarmUp(_)) => Cause::Changing(source, Change::WarmUp(time)),
                Cause::Changing(source, _) => Cause::Changing(source, Change::Step(time)),
                Cause::Reference(channel, _) => Cause::Reference(channel, Some(Change::Step(time))),
                other => other,
            };
            // what the others leave
            let mut fixed: Vec<Vec<f64>> =
                set.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, cause)| column(cause)).collect();
            fixed.push(laid.clone());
            self.case.weigh(self.u, &[], &mut fixed);
            let Some(mut residual) = fixed.pop() else { continue };
            let basis = orthonormal(fixed, INDEPENDENT);
            project(&mut residual, &basis);
            let square = dot(&residual, &residual);
            let try_at = |time: f64| -> Option<(f64, f64)> {
                let mut candidate = [self.case.columns.of(&make(time))];
                self.case.weigh(self.u, &[], &mut candidate);
                let [mut own] = candidate;
                let whole = dot(&own, &own);
                project(&mut own, &basis);
                let left = dot(&own, &own);
                let along = dot(&own, &residual);
                (left > INDEPENDENT * whole).then(|| (square - along * along / left, along / left))
            };
            let Some((mut rss, mut value)) = try_at(start) else { continue };
            let (before, mut time) = (rss, start);
            let mut width = if warm { 3f64.ln() } else { spacing };
            for _ in 0..LEVELS {
                let middle = time;
                for part in -PARTS..=PARTS {
                    let shift = width * f64::from(part) / f64::from(PARTS);
                    let trial = if warm { middle * shift.exp() } else { middle + shift };
                    if !(trial > 0.0 && shift.is_finite()) || part == 0 {
                        continue;
                    }
                    if let Some((own, at)) = try_at(trial).filter(|(own, _)| *own < rss) {
                        (rss, value, time) = (own, at, trial);
                    }
                }
                width *= 1.5 / f64::from(PARTS);
            }
            if before - rss > 0.5
                && let (Some(cause), Some(size)) = (set.get_mut(k), values.get_mut(k))
            {
                (*cause, *size, moved) = (make(time), value, true);
            }
        }
        moved
    }
}
