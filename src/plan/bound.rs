//! The approximate design: weights instead of whole repeats. No exact design can be better, so it bounds the efficiency of an exact one.
//!
//! ```text
//! maximise log det M(w),  minimise log det T M(w)^-1 T',  tr(W M(w)^-1)  or  max_i x_i' M(w)^-1 x_i,   M(w) = M0 + N sum w_j Xj'Xj,   w >= 0, sum w = 1
//! ```
//!
//! Multiplicative weights (S. D. Silvey, D. M. Titterington, B. Torsney, Comm. Statist. A 7 (1978) 1379). The bound is not
//! the value that the iteration has reached but that of the tangent: the objectives are convex in `w`, so it holds after any iteration. The
//! largest prediction is at least any weighted mean of predictions, `max_i d_i >= sum m_i d_i = tr(W_m M^-1)`, so it is bounded by the
//! trace for weights `m` of the predicted rows that grow where `d_i` is large; the largest eigenvalue by `tr(Z C)` in the same way.
#![allow(
    clippy::indexing_slicing,
    reason = "`active` holds numbers of candidates, with one weight each; matrices are `n x n` row by row, made here"
)]

use super::blocks::{Blocks, add_outer, invert, packed, sandwich};
use super::objective::{Combinations, Objective};
use crate::linear::dot;
use crate::number;
use faer::{Mat, Scale, Side};

/// The approximate design and its lower bound.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Bound {
    /// No exact design has a smaller value of the objective.
    pub value: f64,
    /// The objective of these weights: the bound is loose by no more than the difference.
    pub reached: f64,
    /// Weight of each candidate, summing to 1.
    pub weights: Vec<f64>,
}

const ITERATIONS: usize = 5000;
/// Multiplications after which the iteration stops: a second or two.
const EFFORT: f64 = 3e9;
/// Stop when the bound is this near the value reached (relative, for one unknown).
const NEAR: f64 = 1e-5;
/// The bound needs all candidates; between bounds so many steps are made with those that have weight.
const STEPS: usize = 10;
/// A candidate with less weight than this and less than the mean gain is dropped: its weight would only decrease further.
const WEIGHTLESS: f64 = 1e-9;
/// Weight that all candidates share where the best ones alone would leave the information singular.
const LEAST: f64 = 1e-6;

/// Bound on designs of `total` candidates; `None` where even all candidates together leave a defect.
pub(super) fn bound(blocks: &Blocks, base: &[f64], objective: &Objective, total: f64) -> Option<Bound> {
    let (n, count) = (blocks.unknowns(), blocks.count());
    let mut best: Option<Bound> = None;
    let mut reached = f64::INFINITY;
    let spread = |active: &[usize], weights: &[f64]| {
        let mut all = vec![0.0; count];
        active.iter().zip(weights).for_each(|(j, w)| all[*j] = *w);
        all
    };
    // active candidates, their rows and their weights
    let mut active: Vec<usize> = (0..count).collect();
    let mut rows = blocks.clone();
    let mut weights = vec![1.0 / count as f64; count];
    let mut mixture = Mixture::of(objective);
    let mut least = 0.0;
    // logarithms of determinants, of so many unknowns: their slopes' steps are those of D
    let logarithm_of = match objective {
        Objective::Determinant => Some(n as f64),
        Objective::Volume(volume) => Some(volume.size()),
        _ => None,
    };
    let predicted = if let Objective::Largest(rows) = objective { rows.rows() * rows.count() } else { 0 };
    let size = blocks.rows() * count + predicted;
    let most = number::count(EFFORT / (2.0 * (size * n * n) as f64)).clamp(50, ITERATIONS);
    for iteration in 0..most {
        let repeats: Vec<f64> = weights.iter().map(|w| total * w).collect();
        let Some((inverse, log_det)) = invert(&rows.weighted(base, &repeats), n) else {
            // the best weights for one quantity may not determine others: from then on every candidate keeps a minimal weight
            if least > 0.0 {
                break;
            }
            least = LEAST / count as f64;
            weights = spread(&active, &weights).into_iter().map(|w| w + least).collect();
            (active, rows) = ((0..count).collect(), blocks.clone());
            continue;
        };
        // value of the smooth objective at these weights, and the matrix whose quadratic forms are its slopes
        let (slopes, value, here) = match (objective, &mut mixture) {
            (_, Some(mixture)) => {
                let (w, largest) = mixture.follow(&inverse);
                (sandwich(&inverse, &w, n), dot(&w, &inverse), largest)
            }
            (Objective::Trace(w), _) => {
                let value = dot(w, &inverse);
                (sandwich(&inverse, w, n), value, value)
            }
            (Objective::Volume(functions), _) => {
                let Some((value, slopes)) = functions.with_slopes(&inverse) else { break };
                (slopes, value, value)
            }
            _ => (inverse, -log_det, -log_det),
        };
        let gain = gains(&rows, &slopes);
        let mean = dot(&gain, &weights);
        reached = here.min(reached);
        if iteration % STEPS == 0 {
            let most = gains(blocks, &slopes).into_iter().fold(0.0, f64::max);
            let lower = if logarithm_of.is_some() {
                value - total * (most - mean)
            } else {
                // tr(W M^-1)^2 <= tr(W M*^-1) tr(M* M^-1 W M^-1) by Cauchy and Schwarz, for every M*
                value * value / (value + total * (most - mean))
            };
            if best.as_ref().is_none_or(|b| lower > b.value) {
                best = Some(Bound { value: lower, reached, weights: spread(&active, &weights) });
            }
            let near = NEAR * logarithm_of.unwrap_or(reached.abs());
            if best.as_ref().is_some_and(|b| reached - b.value <= near) || !(mean > 0.0) {
                break;
            }
            let stays: Vec<bool> = weights.iter().zip(&gain).map(|(w, g)| *w > WEIGHTLESS || *g >= mean).collect();
            if least == 0.0 && 4 * stays.iter().filter(|stays| **stays).count() < 3 * active.len() {
                // candidates beyond the list were dropped
                let kept = |k: &usize| stays.get(*k).copied().unwrap_or(false);
                let places: Vec<usize> = (0..active.len()).filter(kept).collect();
                (active, weights) = places.iter().map(|k| (active[*k], weights[*k])).unzip();
                rows = blocks.subset(&active);
                continue;
            }
        }
        let step = |g: f64| if logarithm_of.is_some() { g / mean } else { (g / mean).sqrt() };
        weights.iter_mut().zip(&gain).for_each(|(w, g)| *w = (*w * step(*g)).max(least));
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|w| *w /= sum);
    }
    let best = best.map(|b| Bound { reached, ..b });
    match objective {
        Objective::Volume(volume) => best.map(|b| {
            let root = |value: f64| (value / volume.size()).exp();
            Bound { value: root(b.value), reached: root(b.reached), ..b }
        }),
        _ => best,
    }
}

/// `tr(Xj B Xj')` of every candidate.
fn gains(blocks: &Blocks, b: &[f64]) -> Vec<f64> {
    let sums = blocks.quadratics(b);
    (0..blocks.count()).map(|j| (0..blocks.rows()).map(|r| sums[packed(r, r)][j]).sum()).collect()
}

/// Weights for the largest of several variances: a mass on predicted rows that sums to one, or a positive semidefinite `Z` of trace one with
/// `lambda_max(C) >= tr(Z C)`.
enum Mixture<'a> {
    /// Of row r of candidate j at `r * count + j`.
    Rows(&'a Blocks, Vec<f64>),
    Combined(&'a Combinations, Mat<f64>),
}

impl<'a> Mixture<'a> {
    /// All alike; `None` for an objective that is smooth.
    fn of(objective: &'a Objective) -> Option<Self> {
        match objective {
            Objective::Largest(rows) => {
                let all = rows.rows() * rows.count();
                Some(Mixture::Rows(rows, vec![1.0 / all as f64; all]))
            }
            Objective::Eigenvalue(t) => {
                let p = t.0.nrows();
                Some(Mixture::Combined(t, Mat::<f64>::identity(p, p) * Scale(1.0 / t.size())))
            }
            _ => None,
        }
    }

    /// Move the weights towards the largest variances at `M^-1`; `sum m x x'` or `T' Z T`, row by row, and the largest variance.
    fn follow(&mut self, inverse: &[f64]) -> (Vec<f64>, f64) {
        match self {
            Mixture::Rows(rows, mass) => {
                let sums = rows.quadratics(inverse);
                let variance: Vec<f64> = (0..rows.rows()).flat_map(|r| &sums[packed(r, r)]).copied().collect();
                let mean = dot(mass, &variance);
                mass.iter_mut().zip(&variance).for_each(|(m, d)| *m *= d / mean);
                let sum: f64 = mass.iter().sum();
                mass.iter_mut().for_each(|m| *m /= sum);
                let mut w = vec![0.0; rows.unknowns() * rows.unknowns()];
                // rows without mass are left out
                for (k, m) in mass.iter().enumerate().filter(|(_, m)| **m > 1e-12) {
                    add_outer(&mut w, *m, &rows.row(k % rows.count(), k / rows.count()));
                }
                (w, variance.into_iter().fold(0.0, f64::max))
            }
            // Z <- C^(1/2) Z C^(1/2) over its trace
            Mixture::Combined(functions, weights) => {
                let c = functions.image(inverse);
                let mut largest = f64::NAN;
                if let Ok(eigen) = c.self_adjoint_eigen(Side::Lower) {
                    let p = c.nrows();
                    let scaled = Mat::from_fn(p, p, |i, k| eigen.U()[(i, k)] * eigen.S()[k].max(0.0).sqrt());
                    let root = scaled * eigen.U().transpose();
                    let moved = &root * &*weights * &root;
                    let trace: f64 = (0..p).map(|k| moved[(k, k)]).sum();
                    if trace > 0.0 {
                        *weights = Mat::from_fn(p, p, |i, j| 0.5 * (moved[(i, j)] + moved[(j, i)]) / trace);
                    }
                    largest = eigen.S()[p - 1];
                }
                (functions.weighted(weights), largest)
            }
        }
    }
}
