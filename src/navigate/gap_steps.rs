//! The gap as it shrinks: with the cause that reduces it most, with that one and the next, and so on, each set refined anew on the full simulation.

use super::cause::Cause;
use super::gap::GapStep;
use super::products::Products;
use super::refine::{Search, State};
use crate::diagnosis::Gap;
use crate::elements::Elements;

/// With more causes than this only the first and the last gap are reported.
const MOST: usize = 12;

impl Search<'_> {
    /// The gap before, after each of the causes of a state, and after all of them with single values left out; `whole` is the gap before.
    pub fn gap_steps(&mut self, state: &State, whole: &[f64]) -> Vec<GapStep> {
        let (u, out) = (self.u, &state.out);
        // random walks are no members of the set: with them, all gaps are innovations
        let walks: Vec<String> = self.unstated.iter().map(|walk| walk.cause.id()).collect();
        let step = |set: &[Cause], left_out: usize, gap: Gap| GapStep {
            with: walks.iter().cloned().chain(set.iter().map(Cause::id)).collect(),
            left_out,
            gap,
        };
        let mut steps = vec![step(&[], 0, self.case.gap(whole, u, &[], 0))];
        let order = if state.set.len() > MOST { Vec::new() } else { self.order(state) };
        let causes =
            |places: &[usize]| places.iter().filter_map(|k| state.set.get(*k)).copied().collect::<Vec<Cause>>();
        for count in 1..order.len() {
            let (set, start): (Vec<Cause>, Vec<f64>) =
                order.iter().take(count).filter_map(|k| Some((*state.set.get(*k)?, *state.values.get(*k)?))).unzip();
            // a set that cannot be flown is left out
            let Some(fitted) = self.refine(&set, &start, out) else { continue };
            steps.push(step(&set, 0, self.case.gap(&self.case.residual(&fitted.flown.predicted), u, &[], set.len())));
        }
        let set = if order.is_empty() { state.set.clone() } else { causes(&order) };
        let residual = self.case.residual(&state.flown.predicted);
        if !set.is_empty() {
            steps.push(step(&set, 0, self.case.gap(&residual, u, &[], set.len())));
        }
        if !out.is_empty() {
            steps.push(step(&set, out.len(), self.case.gap(&residual, u, out, set.len())));
        }
        steps
    }

    /// Members of a state's set in the order in which they reduce the gap most, given those before them.
    fn order(&self, state: &State) -> Vec<usize> {
        let mut columns = state.flown.jacobian.clone();
        columns.push(self.case.observed(&state.flown, &state.values));
        self.case.weigh(self.u, &state.out, &mut columns);
        let Some(residual) = columns.pop() else { return Vec::new() };
        let count = columns.len();
        let (products, _) = Products::normalised(columns, &residual);
        let mut order: Vec<usize> = Vec::with_capacity(count);
        while order.len() < count {
            let Some(solved) = products.solve(&order) else { return Vec::new() };
            let gains = products.gains(&order, &solved);
            let remaining = (0..count).filter(|k| !order.contains(k));
            match remaining.max_by(|a, b| gains.at(*a).total_cmp(&gains.at(*b)).then(b.cmp(a))) {
                Some(next) => order.push(next),
                None => break,
            }
        }
        order
    }
}
