//! The exchange problem, and its designs.

use super::blocks::{Blocks, roots};
use super::objective::Objective;
use super::prices::Prices;

/// The exchange problem.
#[derive(Debug, Clone)]
pub(super) struct Problem<'a> {
    /// The candidates.
    pub blocks: &'a Blocks,
    /// Information of the kept readings and of priors, row by row.
    pub base: &'a [f64],
    /// What is made small.
    pub objective: &'a Objective,
    /// How many blocks are chosen.
    pub choose: usize,
    /// How often one candidate may be chosen.
    pub most_repeats: usize,
    /// For coordinate exchange: candidates that differ from each in one coordinate; empty for Fedorov's exchange.
    pub neighbours: &'a [Vec<usize>],
    /// Prices and budget, where there is a budget instead of a number.
    pub prices: Option<&'a Prices>,
}

impl<'a> Problem<'a> {
    /// A problem without limits of number, repeats or cost.
    pub fn of(blocks: &'a Blocks, base: &'a [f64], objective: &'a Objective) -> Self {
        Problem { blocks, base, objective, choose: 0, most_repeats: usize::MAX, neighbours: &[], prices: None }
    }

    /// Are there so many portions for each unknown that starts round the approximate design? Single exchanges would take long from elsewhere.
    pub fn has_many(&self) -> bool {
        self.choose > MANY * self.blocks.unknowns()
    }

    /// Have designs fewer rows than unknowns, and so are singular whatever the rounding?
    pub fn is_short(&self) -> bool {
        let n = self.blocks.unknowns();
        self.choose.saturating_mul(self.blocks.rows()).saturating_add(roots(self.base.to_vec(), n).len()) < n
    }

    /// Is a design feasible: repeats, number and cost within their limits?
    pub fn allows(&self, chosen: &[usize]) -> bool {
        counted(chosen).iter().all(|(_, times)| *times as usize <= self.most_repeats)
            && match self.prices {
                Some(prices) => chosen.len() <= self.choose && prices.affords(prices.of(chosen)),
                None => chosen.len() == self.choose,
            }
    }

    /// A design with its value from a fresh factorisation; `None` where it is singular.
    pub fn design(&self, mut chosen: Vec<usize>) -> Option<Design> {
        chosen.sort_unstable();
        let value =
            self.objective.value(&information(self.blocks, self.base, &counted(&chosen)), self.blocks.unknowns())?;
        Some(Design { chosen, value, effort: 0.0 })
    }
}

/// A chosen design.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Design {
    /// Candidates, sorted, with repeats.
    pub chosen: Vec<usize>,
    /// The objective's value after a fresh factorisation.
    pub value: f64,
    /// Multiplications that were spent on it, roughly.
    pub effort: f64,
}

/// Smallest relative improvement of the criterion for which an exchange is made: less is rounding, and could cycle.
pub(super) const WORTH: f64 = 1e-9;

/// Portions for each unknown above which starts round the approximate design.
const MANY: usize = 40;

/// Every candidate of a list, and how often it is in it.
pub(super) fn counted(chosen: &[usize]) -> Vec<(usize, u32)> {
    let mut sorted = chosen.to_vec();
    sorted.sort_unstable();
    let mut counts: Vec<(usize, u32)> = Vec::new();
    for j in sorted {
        match counts.last_mut() {
            Some((last, times)) if *last == j => *times += 1,
            _ => counts.push((j, 1)),
        }
    }
    counts
}

/// `M`, for candidates and how often each is chosen.
pub(super) fn information(blocks: &Blocks, base: &[f64], chosen: &[(usize, u32)]) -> Vec<f64> {
    let mut m = base.to_vec();
    chosen.iter().for_each(|(j, times)| blocks.add(&mut m, f64::from(*times), *j));
    m
}
