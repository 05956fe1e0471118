//! E: the largest eigenvalue of `T M^-1 T'`, the variance of the worst determined combination of what is asked for.
//!
//! ```text
//! E = max over |v| = 1 of v' T M^-1 T' v = lambda_max(T M^-1 T'),     rows of T: what is asked for, in units in which it is compared
//! ```
//!
//! (F. Pukelsheim, Optimal Design of Experiments, 1993, 6.4.) Taking block `i` out first, `Mi = M - Xi'Xi`, a replacement `j` leaves
//! `T Mi^-1 T' - B' S^-1 B`, with `B = Xj Mi^-1 T'` and `S = I + Xj Mi^-1 Xj'`. Along the worst direction `v` of `T Mi^-1 T'` alone that is a
//! bound from below, so replacements are weighed in the order of their bounds until none can be better.
#![allow(
    clippy::indexing_slicing,
    reason = "`Combinations::fits` has made sure of a row at least and of the unknowns in each; spread and along are made here over the block's rows"
)]

use super::blocks::times;
use super::combinations::{Combinations, largest_eigenvalue};
use super::largest::{Worst, inverse_root};
use super::state::{State, packed};
use crate::elements::Elements;
use crate::linear::dot;
use faer::{Mat, Side};

impl Worst for Combinations {
    fn of(&self, inverse: &[f64]) -> f64 {
        largest_eigenvalue(&self.image(inverse))
    }

    fn replacement(&self, state: &mut State<'_>, at: usize, inverse: &[f64], now: f64) -> Option<(usize, f64)> {
        let (blocks, n, k) = (state.problem.blocks, state.problem.blocks.unknowns(), state.problem.blocks.rows());
        let own = self.image(inverse);
        let eigen = own.self_adjoint_eigen(Side::Lower).ok()?;
        let p = own.nrows();
        // eigenvalues come in nondecreasing order
        let (worst, most) = (self.combined(|i| eigen.U()[(i, p - 1)]), eigen.S()[p - 1]);
        let w = times(inverse, &worst);
        let mut work = vec![0.0; blocks.count()];
        let mut spread = vec![vec![0.0; blocks.count()]; k * (k + 1) / 2];
        for s in 0..k {
            for r in 0..=s {
                blocks.quadratic(r, s, inverse, &mut spread[packed(r, s)], &mut work);
            }
        }
        let mut along = vec![vec![0.0; blocks.count()]; k];
        along.iter_mut().enumerate().for_each(|(r, out)| blocks.along(r, &w, out));
        let root_of = |j: usize| inverse_root(k, |r, s| spread[packed(r, s)].at(j));
        let less = |root: &[f64], b: &dyn Fn(usize) -> f64| {
            (0..k).map(|r| (0..=r).map(|s| root[packed(s, r)] * b(s)).sum::<f64>().powi(2)).sum::<f64>()
        };
        let bound = |j: usize| most - less(&root_of(j), &|s| along[s].at(j));
        let mut replacements: Vec<(f64, usize)> = state.replacements(at).into_iter().map(|j| (bound(j), j)).collect();
        replacements.sort_by(|a, b| a.0.total_cmp(&b.0));
        state.effort += (blocks.count() * (n * n + 2 * k * n) * k) as f64;
        let columns: Vec<Vec<f64>> = self.0.iter().map(|row| times(inverse, row)).collect();
        let mut best: Option<(usize, f64)> = None;
        for (bound, j) in replacements {
            if bound >= best.map_or(now, |(_, value)| value) {
                break;
            }
            let root = root_of(j);
            // rows of L^-1 B
            let rows: Vec<Vec<f64>> = (0..k).map(|r| blocks.row(j, r)).collect();
            let b: Vec<Vec<f64>> = rows.iter().map(|x| columns.iter().map(|c| dot(x, c)).collect()).collect();
            let white: Vec<Vec<f64>> =
                (0..k).map(|r| (0..p).map(|c| (0..=r).map(|s| root[packed(s, r)] * b[s][c]).sum()).collect()).collect();
            let left = Mat::from_fn(p, p, |i, c| own[(i, c)] - white.iter().map(|row| row[i] * row[c]).sum::<f64>());
            let value = largest_eigenvalue(&left);
            state.effort += (k * n * p + 10 * p * p * p) as f64;
            if value < best.map_or(now, |(_, value)| value) {
                best = Some((j, value));
            }
        }
        best
    }
}

/// Weights for the bound: `lambda_max(C) >= tr(Z C)` for every positive semidefinite `Z` of trace one.
pub(super) struct Mixture {
    weights: Mat<f64>,
}

impl Mixture {
    /// All combinations alike.
    pub(super) fn new(combinations: &Combinations) -> Self {
        let p = combinations.0.len();
        Mixture { weights: Mat::from_fn(p, p, |i, j| if i == j { 1.0 / p.max(1) as f64 } else { 0.0 }) }
    }

    /// `Z <- C^(1/2) Z C^(1/2)` over its trace, with `C = T M^-1 T'`, whose largest eigenvalue is returned.
    pub(super) fn follow(&mut self, combinations: &Combinations, inverse: &[f64]) -> f64 {
        let c = combinations.image(inverse);
        let Ok(eigen) = c.self_adjoint_eigen(Side::Lower) else { return f64::NAN };
        let p = c.nrows();
        let root = Mat::from_fn(p, p, |i, j| {
            (0..p).map(|k| eigen.U()[(i, k)] * eigen.S()[k].max(0.0).sqrt() * eigen.U()[(j, k)]).sum::<f64>()
        });
        let moved = &root * &self.weights * &root;
        let trace: f64 = (0..p).map(|k| moved[(k, k)]).sum();
        if trace > 0.0 {
            self.weights = Mat::from_fn(p, p, |i, j| 0.5 * (moved[(i, j)] + moved[(j, i)]) / trace);
        }
        eigen.S()[p - 1]
    }

    /// `T' Z T`, row by row.
    pub(super) fn weight_matrix(&self, combinations: &Combinations) -> Vec<f64> {
        let n = combinations.0.first().map_or(0, Vec::len);
        let half: Vec<Vec<f64>> =
            (0..self.weights.nrows()).map(|i| combinations.combined(|k| self.weights[(i, k)])).collect();
        let mut w = vec![0.0; n * n];
        for (row, other) in combinations.0.iter().zip(&half) {
            for (out, x) in w.chunks_exact_mut(n).zip(row) {
                out.iter_mut().zip(other).for_each(|(out, y)| *out += x * y);
            }
        }
        w
    }
}
