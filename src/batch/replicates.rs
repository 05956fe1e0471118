//! What is tested of the residuals of many devices alike: lack of fit beside replicates, and their order.

use crate::elements::Elements;
use crate::mix::Mix;
use crate::quality;
use std::cell::RefCell;
use std::collections::HashMap;
use std::hash::BuildHasherDefault;

/// Rows of equal inputs.
#[derive(Debug, Clone, Default)]
pub(super) struct Replicates {
    /// Cell of each row, one after the other.
    cell: Vec<usize>,
    /// Sum of weights of each cell.
    weight: Vec<f64>,
    /// Weight of each row.
    own: Vec<f64>,
    pure_dof: usize,
    between_dof: usize,
}

/// Probabilities of the runs test by counts: they depend on nothing else.
type Runs = HashMap<(usize, usize, usize), f64, BuildHasherDefault<Mix>>;

thread_local! {
    static RUNS: RefCell<Runs> = RefCell::default();
}
/// As many of them are kept.
const RUNS_KEPT: usize = 1 << 16;

impl Replicates {
    pub fn new(cells: &[usize], u: &[f64], dof: usize) -> Self {
        let count = cells.iter().max().map_or(0, |most| most + 1);
        let mut weight = vec![0.0; count];
        let own: Vec<f64> = u.iter().map(|u| 1.0 / (u * u)).collect();
        for (cell, own) in cells.iter().zip(&own) {
            weight.get_mut(*cell).into_iter().for_each(|sum| *sum += own);
        }
        let filled = weight.iter().filter(|sum| **sum > 0.0).count();
        let pure_dof = cells.len() - filled;
        Replicates { cell: cells.to_vec(), weight, own, pure_dof, between_dof: dof.saturating_sub(pure_dof) }
    }

    /// Is anything replicated, and something left to be lack of fit?
    pub fn are_tested(&self) -> bool {
        self.pure_dof > 0 && self.between_dof > 0
    }

    /// Probability of the test for lack of fit, as [`quality::lack_of_fit`] has it.
    pub fn lack_of_fit(&self, v: &[f64], sums: &mut Vec<f64>) -> Option<f64> {
        if !self.are_tested() {
            return None;
        }
        sums.clear();
        sums.resize(self.weight.len(), 0.0);
        let rows = || v.iter().zip(&self.own).zip(&self.cell);
        for ((v, own), cell) in rows() {
            sums.get_mut(*cell).into_iter().for_each(|sum| *sum += v * own);
        }
        let between: f64 = sums
            .iter()
            .zip(&self.weight)
            .map(|(sum, weight)| if *weight > 0.0 { sum * sum / weight } else { 0.0 })
            .sum();
        for (sum, weight) in sums.iter_mut().zip(&self.weight) {
            *sum /= weight;
        }
        let (mut pure, mut total) = (0.0, 0.0);
        for ((v, own), cell) in rows() {
            let mean = sums.at(*cell);
            pure += (v - mean) * (v - mean) * own;
            total += v * v * own;
        }
        quality::lack_of_fit_p(pure, self.pure_dof, between, self.between_dof, total).map(|(_, p)| p)
    }
}

/// Sums of cells, for devices whose cells are their own.
#[derive(Debug, Default)]
pub(super) struct Sorted {
    /// Weight and weighted sum of each cell.
    sums: Vec<(f64, f64)>,
    own: Vec<f64>,
}

impl Sorted {
    /// Probability of the test for lack of fit of residuals with their weights `1/u`, as [`quality::lack_of_fit`] has it.
    pub fn lack_of_fit(
        &mut self,
        (cell, count): (&[usize], usize),
        (v, weight): (&[f64], impl Iterator<Item = f64>),
        dof: usize,
    ) -> Option<f64> {
        let Sorted { sums, own } = self;
        let pure_dof = cell.len().checked_sub(count).filter(|pure| *pure > 0)?;
        let between_dof = dof.checked_sub(pure_dof).filter(|rest| *rest > 0)?;
        sums.clear();
        sums.resize(count, (0.0, 0.0));
        own.clear();
        own.extend(weight.map(|w| w * w));
        for ((v, own), cell) in v.iter().zip(own.iter()).zip(cell) {
            let Some((weight, sum)) = sums.get_mut(*cell) else { continue };
            *weight += own;
            *sum += v * own;
        }
        let between: f64 = sums.iter().map(|(weight, sum)| sum * sum / weight).sum();
        let (mut pure, mut total) = (0.0, 0.0);
        for ((v, own), cell) in v.iter().zip(own.iter()).zip(cell) {
            let mean = sums.get(*cell).map_or(0.0, |(weight, sum)| sum / weight);
            pure += (v - mean) * (v - mean) * own;
            total += v * v * own;
        }
        quality::lack_of_fit_p(pure, pure_dof, between, between_dof, total).map(|(_, p)| p)
    }
}

/// Probability of the runs test; NaN where there is none. Equal counts have equal probabilities, and return often.
pub(super) fn runs_p(residuals: impl Iterator<Item = f64>) -> f64 {
    let (mut positive, mut negative, mut runs, mut last) = (0_usize, 0_usize, 0_usize, None);
    for v in residuals.filter(|v| *v != 0.0 && v.is_finite()) {
        let sign = v > 0.0;
        if sign {
            positive += 1;
        } else {
            negative += 1;
        }
        runs += usize::from(last != Some(sign));
        last = Some(sign);
    }
    runs_of(positive, negative, runs)
}

/// The same by counts.
pub(super) fn runs_of(positive: usize, negative: usize, runs: usize) -> f64 {
    let key = (positive, negative, runs);
    RUNS.with_borrow_mut(|seen| {
        if seen.len() > RUNS_KEPT {
            seen.clear();
        }
        *seen.entry(key).or_insert_with(|| quality::runs_of(positive, negative, runs).map_or(f64::NAN, |test| test.p))
    })
}
