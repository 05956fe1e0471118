//! What is tested of the residuals of a device: their size, signs in their order, normality, lack of fit beside replicates.
#![allow(clippy::indexing_slicing, reason = "a `Lane` has `LANES` numbers")]

use super::block::{LANES, Lane, Sums, lane, network, normality};
use crate::fit;
use crate::mix::Mix;
use crate::number;
use crate::quality::{self, NormalScores, Signs, Whitened};
use crate::uncertainty::quantiles;
use std::cell::RefCell;
use std::collections::HashMap;
use std::hash::BuildHasherDefault;

/// Up to so many residuals are sorted side by side.
const NETWORK: usize = 256;
/// Share of a threshold within which the exact probability decides.
const SLACK: f64 = 1e-6;

/// Rows whose uncertainties differ by more than this factor want the refinement of a fit of their own.
pub(super) const UNLIKE: f64 = 100.0;

/// What is known of the values of a device before anything is computed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sizes {
    /// The least positive and the largest size.
    values: [f64; 2],
    /// The largest in units of its uncertainty.
    pub weighed: f64,
    /// Least and largest weight.
    weights: [f64; 2],
}

impl Sizes {
    pub const NONE: Sizes = Sizes { values: [f64::INFINITY, 0.0], weighed: 0.0, weights: [f64::INFINITY, 0.0] };

    /// A value and the reciprocal of its uncertainty.
    #[inline(always)]
    pub fn take(&mut self, value: f64, weight: f64) {
        let less = |a: f64, b: f64| if a < b { a } else { b };
        let more = |a: f64, b: f64| if a > b { a } else { b };
        let size = value.abs();
        let ([least, most], [lightest, heaviest]) = (self.values, self.weights);
        self.values = [if size > 0.0 { less(size, least) } else { least }, more(size, most)];
        self.weighed = more(size * weight, self.weighed);
        self.weights = [less(weight, lightest), more(weight, heaviest)];
    }

    /// Can they be squared, and are they weighed alike?
    pub fn are_plain(&self) -> bool {
        let ([least, most], [lightest, heaviest]) = (self.values, self.weights);
        // reciprocals are rounded
        !(most > fit::MOST || least < fit::LEAST || heaviest * (1.0 - 1e-12) > UNLIKE * lightest)
    }

    /// The largest value in units of its uncertainty, and the largest uncertainty.
    pub fn in_units(&self) -> (f64, f64) {
        (self.weighed, 1.0 / self.weights[0])
    }
}

/// What the tests of devices of one shape share.
#[derive(Debug, Clone)]
pub(super) struct Tests {
    pub scores: Option<NormalScores>,
    /// How as many values as count for normality are sorted.
    pub network: Vec<(usize, usize)>,
    dof: usize,
    /// Is the scatter of the readings estimated?
    scaled: bool,
    /// From here on the largest gain is looked at more closely; `None` where nothing can be tested.
    threshold: Option<f64>,
}

impl Tests {
    /// `sorted` residuals count for normality, `checked` readings may be found suspicious.
    pub fn new(sorted: usize, checked: usize, (dof, scaled, level): (usize, bool, f64)) -> Self {
        let single = -(level.ln() / checked.max(1) as f64).exp_m1();
        let threshold = match (scaled, dof) {
            (false, 1..) => quantiles::chi_square_quantile(1.0 - single, 1.0),
            (true, 2..) => quantiles::fisher_f_quantile(1.0 - single, 1.0, dof as f64 - 1.0),
            _ => None,
        };
        let network = network(if sorted <= NETWORK { sorted } else { 0 });
        Tests { scores: NormalScores::new(sorted), network, dof, scaled, threshold }
    }

    /// Probabilities of the test of normality of eight devices; NaN where there is none.
    #[inline(always)]
    pub fn normality(&self, values: &mut [Lane]) -> Lane {
        match &self.scores {
            None => [f64::NAN; LANES],
            Some(scores) if self.network.is_empty() => std::array::from_fn(|l| {
                let mut own: Vec<f64> = lane(values, l).collect();
                scores.test(&mut own).map_or(f64::NAN, |test| test.p)
            }),
            Some(scores) => normality(scores, &self.network, values),
        }
    }

    /// Can the reading with the largest gain be suspicious? Of sums of squares near the threshold the exact probability decides.
    pub fn may_be_suspicious(&self, squares: f64, best: f64) -> bool {
        let Some(threshold) = self.threshold else { return false };
        let statistic = if self.scaled {
            let rest = (squares - best).max(0.0) / (self.dof as f64 - 1.0);
            if rest > 0.0 { best / rest } else { f64::INFINITY }
        } else {
            best
        };
        !(statistic < threshold * (1.0 - SLACK) || best == 0.0)
    }
}

/// Suspicious readings, counted from 1 among the device's rows, and the probability of the most significant; `reading` is that of a row, from 0.
pub(super) fn suspects(
    whitened: &Whitened<'_>,
    (readings, level): (usize, f64),
    reading: impl Fn(usize) -> Option<usize>,
) -> (Vec<usize>, f64) {
    let found = quality::snoop(whitened, readings, level);
    let suspects = || found.iter().flat_map(|found| &found.suspects);
    let least = suspects().map(|suspect| suspect.p).fold(f64::NAN, f64::min);
    (suspects().filter_map(|suspect| Some(reading(suspect.row)? + 1)).collect(), least)
}

/// Probabilities of the runs test by counts: they depend on nothing else.
type Runs = HashMap<(usize, usize, usize), f64, BuildHasherDefault<Mix>>;

thread_local! {
    static RUNS: RefCell<Runs> = RefCell::default();
}
/// As many of them are kept.
const RUNS_KEPT: usize = 1 << 16;

/// Sums of cells: rows of equal inputs.
#[derive(Debug, Default)]
pub(super) struct Cells {
    /// Weight and weighted sum of each cell.
    sums: Vec<(f64, f64)>,
    weights: Vec<f64>,
}

impl Cells {
    /// Probability of the test for lack of fit of residuals with their weights `1/u^2`, as [`quality::lack_of_fit`] has it; `None` where nothing is
    /// replicated, or nothing is left to be lack of fit.
    pub fn lack_of_fit(
        &mut self,
        (cell, count): (&[usize], usize),
        (v, weight): (&[f64], impl Iterator<Item = f64>),
        dof: usize,
    ) -> Option<f64> {
        let Cells { sums, weights } = self;
        let pure_dof = cell.len().checked_sub(count).filter(|pure| *pure > 0)?;
        let between_dof = dof.checked_sub(pure_dof).filter(|rest| *rest > 0)?;
        sums.clear();
        sums.resize(count, (0.0, 0.0));
        weights.clear();
        weights.extend(weight);
        for ((v, w), cell) in v.iter().zip(weights.iter()).zip(cell) {
            let Some((weight, sum)) = sums.get_mut(*cell) else { continue };
            *weight += w;
            *sum += v * w;
        }
        let between: f64 = sums.iter().map(|(weight, sum)| sum * sum / weight).sum();
        let (mut pure, mut total) = (0.0, 0.0);
        for ((v, w), cell) in v.iter().zip(weights.iter()).zip(cell) {
            let mean = sums.get(*cell).map_or(0.0, |(weight, sum)| sum / weight);
            pure += (v - mean) * (v - mean) * w;
            total += v * v * w;
        }
        quality::lack_of_fit_p(pure, pure_dof, between, between_dof, total).map(|(_, p)| p)
    }
}

/// The smallest probability of the runs tests of the sensors; `rows` are the sensor of each residual, and its place in their order.
pub(super) fn least_runs_p(rows: impl Iterator<Item = (usize, usize, f64)>) -> f64 {
    let mut sorted: Vec<(usize, usize, f64)> = rows.collect();
    sorted.sort_by_key(|(sensor, place, _)| (*sensor, *place));
    let of_sensor = sorted.chunk_by(|a, b| a.0 == b.0).map(|own| runs_p(own.iter().map(|(.., v)| *v)));
    of_sensor.fold(f64::NAN, f64::min)
}

/// Probability of the runs test; NaN where there is none. Equal counts have equal probabilities, and return often.
fn runs_p(residuals: impl Iterator<Item = f64>) -> f64 {
    let mut signs = Signs::default();
    residuals.for_each(|v| signs.take(v));
    runs_of(signs.positive, signs.negative, signs.runs)
}

impl Sums {
    /// The same of all residuals of one of the eight, none of them zero.
    pub(super) fn runs_p(&self, l: usize, count: usize) -> f64 {
        let positive = number::count(self.positive[l]);
        runs_of(positive, count - positive, 1 + number::count(self.changes[l]))
    }
}

/// The same by counts.
fn runs_of(positive: usize, negative: usize, runs: usize) -> f64 {
    let key = (positive, negative, runs);
    RUNS.with_borrow_mut(|seen| {
        if seen.len() > RUNS_KEPT {
            seen.clear();
        }
        *seen.entry(key).or_insert_with(|| quality::runs_of(positive, negative, runs).map_or(f64::NAN, |test| test.p))
    })
}
