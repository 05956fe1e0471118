//! D where deviations stand beside the parameters: the volume of the parameters' confidence ellipsoid alone.
//!
//! ```text
//! minimise det(C)^(1/p),     C = T M^-1 T' (p x p),  rows of T: the parameters
//! ```
//!
//! (D_s-optimality: A. C. Atkinson, A. N. Donev, R. D. Tobias, Optimum Experimental Designs, 2007, 10.3.) Taking block `i` out first, `Mi = M - Xi'Xi`, a replacement `j` leaves
//!
//! ```text
//! det C_j = det C_i det(I + Xj A Xj') / det(I + Xj Mi^-1 Xj'),     A = Mi^-1 - Mi^-1 T' C_i^-1 T Mi^-1
//! ```
//!
//! where `A` is what the deviations would scatter if the parameters were known.
#![allow(
    clippy::indexing_slicing,
    reason = "packed triangles are made here over the rows of a block, with one entry for each candidate"
)]

use super::combinations::Volume;
use super::largest::{Worst, inverse_root};
use super::state::{State, packed};
use crate::elements::Elements;

impl Worst for Volume {
    fn of(&self, inverse: &[f64]) -> f64 {
        self.triangle(inverse).map_or(f64::NAN, |c| (c.log_determinant() / self.size()).exp())
    }

    fn replacement(&self, state: &mut State<'_>, at: usize, inverse: &[f64], now: f64) -> Option<(usize, f64)> {
        let (blocks, n, k) = (state.problem.blocks, state.problem.blocks.unknowns(), state.problem.blocks.rows());
        let (without, slopes) = self.with_slopes(inverse)?;
        let deviations: Vec<f64> = inverse.iter().zip(&slopes).map(|(all, own)| all - own).collect();
        let mut work = vec![0.0; blocks.count()];
        let mut spread = |matrix: &[f64]| {
            let mut sums = vec![vec![0.0; blocks.count()]; k * (k + 1) / 2];
            for s in 0..k {
                for r in 0..=s {
                    blocks.quadratic(r, s, matrix, &mut sums[packed(r, s)], &mut work);
                }
            }
            sums
        };
        let (all, beside) = (spread(inverse), spread(&deviations));
        state.effort += (2 * blocks.count() * n * n * k) as f64;
        // -2 log det L^-1 = log det(I + G)
        let log_det = |sums: &[Vec<f64>], j: usize| {
            let root = inverse_root(k, |r, s| sums[packed(r, s)].at(j));
            -2.0 * (0..k).map(|r| root[packed(r, r)].ln()).sum::<f64>()
        };
        let mut best: Option<(usize, f64)> = None;
        for j in state.replacements(at) {
            let value = ((without + log_det(&beside, j) - log_det(&all, j)) / self.size()).exp();
            if value < best.map_or(now, |(_, value)| value) {
                best = Some((j, value));
            }
        }
        best
    }
}
