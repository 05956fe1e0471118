//! Causes that stand beside something which nothing explains.
//!
//! Where no set of causes leaves noise, the search of campaigns (`diagnosis`, one effect after another) is asked on the linear model: each cause
//! must be beyond doubt against the noise *and* what is still unexplained, a component of variance whose grouping (a channel, a stretch of time) and
//! size are estimated with it. What it names is refined on the full simulation and asked again from there, until the names settle. Causes that
//! change in time can build any course of time: beside an unexplained rest they are candidates that others must beat, but are not named.

use super::cause::Cause;
use super::measured::{CHANNELS, Cell};
use super::refine::{State, Walk};
use super::walk::Linear;
use crate::diagnosis::{Felt, NoiseFrom, Plain, Stands};
use crate::elements::Elements;
use std::collections::HashMap;

/// Rounds of naming and refining, at most.
const ROUNDS: usize = 6;
/// Stretches of so many consecutive rows of a run may share what nothing explains.
const STRETCHES: [usize; 5] = [3, 6, 12, 24, 48];
/// Candidates that are told as the nearest to what is left.
const NEAREST: usize = 3;

/// What stands, and what comes nearest to the rest.
pub(super) struct Partly {
    pub state: State,
    /// For each cause of the state.
    pub stands: Vec<Stands>,
    pub nearest: Vec<Cause>,
    /// The share of what is left that they would take off.
    pub nearest_share: f64,
}

impl Walk<'_> {
    /// The causes that stand where a walk has ended without explaining all; `None` where none does, or the noise is not stated.
    pub fn partly(&mut self, best: &State) -> Option<Partly> {
        if self.case.from != NoiseFrom::Stated {
            return None;
        }
        // from the constants among what came nearest, or from nothing
        let constant: Vec<(Cause, f64)> =
            best.set.iter().zip(&best.values).filter(|(cause, _)| cause.is_constant()).map(|(c, v)| (*c, *v)).collect();
        let starts = if constant.is_empty() { vec![constant] } else { vec![constant, Vec::new()] };
        starts.into_iter().find_map(|start| {
            let (set, values): (Vec<Cause>, Vec<f64>) = start.into_iter().unzip();
            let state = self.refine(&set, &values, &[])?;
            self.settle(state)
        })
    }

    /// Naming and refining in turn, from a state.
    fn settle(&mut self, mut state: State) -> Option<Partly> {
        let settings = self.case.settings.common;
        let out = self.standing_out(&state);
        if out != state.out {
            state = self.refine(&state.set.clone(), &state.values.clone(), &out)?;
        }
        let mut before: Vec<Vec<Cause>> = Vec::new();
        for _ in 0..ROUNDS {
            let linear = self.linear(&state);
            let plain = self.plain(&linear, &state, false);
            // causes that change in time build any course of time
            let is_pattern = |set: &[usize]| {
                let changing = |j: &&usize| linear.causes.get(**j).is_none_or(Cause::is_course);
                set.iter().filter(changing).count() > 0
            };
            let start: Vec<usize> =
                state.set.iter().filter_map(|cause| linear.causes.iter().position(|own| own == cause)).collect();
            let set = plain.one_after_another(&start, &settings, &is_pattern);
            let causes: Vec<Cause> = set.iter().filter_map(|j| linear.causes.get(*j).copied()).collect();
            let same = causes.len() == state.set.len() && causes.iter().all(|cause| state.set.contains(cause));
            if same && !before.is_empty() {
                let stands = state.set.iter().filter_map(|cause| {
                    let place = causes.iter().position(|own| own == cause)?;
                    plain.stands(&set, place, false, &settings)
                });
                let stands: Vec<Stands> = stands.collect();
                let nearest = plain.nearest(&set, NEAREST);
                let with: Vec<usize> = set.iter().chain(&nearest).copied().collect();
                let nearest_share = 1.0 - plain.rss_of(&with) / plain.rss_of(&set).max(f64::MIN_POSITIVE);
                let nearest = nearest.iter().filter_map(|j| linear.causes.get(*j).copied()).collect();
                let all = stands.len() == state.set.len() && !state.set.is_empty();
                return all.then_some(Partly { state, stands, nearest, nearest_share });
            }
            // names that come round again do not settle
            if causes.is_empty() || before.contains(&causes) {
                return None;
            }
            before.push(causes.clone());
            let solved = linear.products.solve(&set)?;
            let sized = |(j, x): (&usize, &f64)| linear.norms.get(*j).map_or(0.0, |norm| x / norm);
            let values: Vec<f64> = set.iter().zip(&solved.values).map(sized).collect();
            self.tell(before.len(), &causes);
            state = self.refine(&causes, &values, &state.out)?;
            self.relinearise(&state);
            let out = self.standing_out(&state);
            if out != state.out {
                state = self.refine(&state.set.clone(), &state.values.clone(), &out)?;
            }
        }
        None
    }

    /// The question of a linear model for the search of campaigns: its rows without those that are left out. Where something is unexplained each
    /// channel is weighed by what is left in it, if that is more than its noise.
    pub(super) fn plain(&self, linear: &Linear, state: &State, whole: bool) -> Plain {
        let mut left = [self.case.left(&state.flown.predicted)];
        self.case.weigh(self.u, &state.out, &mut left);
        let [left] = left;
        let cells = self.case.measured.cells().zip(&left).enumerate().filter(|(at, _)| !state.out.contains(at));
        let cells: Vec<(usize, Cell, f64)> = cells.map(|(at, (cell, left))| (at, cell, *left)).collect();
        let size = |channel: usize| {
            let own = cells.iter().filter(|(_, cell, _)| cell.channel == channel);
            let (sum, count) = own.fold((0.0, 0.0), |(sum, count), (.., v)| (sum + v * v, count + 1.0));
            if whole { 1.0 } else { (sum / f64::max(count, 1.0)).sqrt().max(1.0) }
        };
        let sizes: [f64; CHANNELS] = std::array::from_fn(size);
        let kept = |column: &[f64]| -> Vec<f64> {
            // columns have a value for each cell
            let one = |(at, cell, _): &(usize, Cell, f64)| column.get(*at).copied().map(|v| v / sizes.at(cell.channel));
            cells.iter().filter_map(one).collect()
        };
        let columns: Vec<Vec<f64>> = linear.products.columns().iter().map(|column| kept(column)).collect();
        // beside an unexplained rest a course of time is as doubtful as what only small tilts leave in a campaign
        let doubtful = self.case.settings.common.indistinguishable;
        let penalty = linear.products.plausibility_penalty.iter().zip(&linear.causes).map(|(own, cause)| match cause {
            // what has none is not seen: a column of zeros
            _ if !own.is_finite() => 0.0,
            cause if cause.is_course() => own.max(doubtful),
            _ => *own,
        });
        let from = if whole { NoiseFrom::Stated } else { NoiseFrom::Residuals };
        let residual = kept(linear.products.residual());
        Plain::new(&columns, residual, self.distinct, from, groupings(&cells), penalty.collect())
    }
}

/// What a rest may be shared by: stretches of time of every channel, or of one.
fn groupings(cells: &[(usize, Cell, f64)]) -> Vec<Felt> {
    let mut found = Vec::new();
    for stretch in STRETCHES {
        for one in std::iter::once(None).chain((0..CHANNELS).map(Some)) {
            let mut places: HashMap<(usize, usize, usize), usize> = HashMap::new();
            let mut group = |cell: &Cell| {
                let count = places.len();
                let key = (cell.run, cell.row / stretch, cell.channel);
                one.is_none_or(|own| own == cell.channel).then(|| *places.entry(key).or_insert(count))
            };
            let group = cells.iter().map(|(_, cell, _)| group(cell)).collect();
            let of = one.map_or(String::new(), |channel| format!(" of channel {channel}"));
            found.push(Felt { name: format!("stretches of {stretch} rows{of}"), group, size: vec![1.0; cells.len()] });
        }
    }
    found
}
