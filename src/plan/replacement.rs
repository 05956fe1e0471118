//! The best replacement of a chosen block for objectives that are not smooth in the design: every replacement is evaluated with all variances. Without block `i`,
//! `Mi = M - Xi'Xi`, a replacement `j` gives, with `S = I + Xj Mi^-1 Xj'`,
//!
//! ```text
//! r' Mi^-1 r - b' S^-1 b,  b = Xj Mi^-1 r     T Mi^-1 T' - B' S^-1 B,  B = Xj Mi^-1 T'
//! det C_j = det C_i det(I + Xj A Xj') / det S,     C = T M^-1 T',     A = Mi^-1 - Mi^-1 T' C_i^-1 T Mi^-1
//! ```
//!
//! where `A` is the covariance of the deviations for known parameters. Along the worst direction `v` of `T Mi^-1 T'` alone the second is a
//! lower bound, so replacements are evaluated in the order of their bounds until none can be better.
#![allow(
    clippy::indexing_slicing,
    reason = "`Objective::fits` has made sure of a row at least and of the unknowns in each; packed triangles and lists are made here over the rows of a block, with one entry for each candidate or replacement"
)]

use super::blocks::{add_outer, packed, times};
use super::objective::{Objective, largest_eigenvalue};
use super::state::State;
use crate::linear::dot;
use faer::{Mat, Side};

/// Replacements that are evaluated at least, and that are tried one by one where the design without the block is singular.
const REPLACEMENTS: usize = 60;
/// Products of predicted rows, candidates and unknowns beyond which only the most informative replacements are evaluated.
const ALL: usize = 20_000_000;

impl Objective {
    /// The replacement with the smallest value of the objective below `now`, and that value; `inverse` is `Mi^-1`, without the block at `at`.
    pub(super) fn replacement(
        &self,
        state: &mut State<'_>,
        at: usize,
        inverse: &[f64],
        now: f64,
    ) -> Option<(usize, f64)> {
        let (blocks, n, k) = (state.problem.blocks, state.problem.blocks.unknowns(), state.problem.blocks.rows());
        let count = blocks.count();
        let spread = blocks.quadratics(inverse);
        let root_of = |sums: &[Vec<f64>], j: usize| inverse_root(k, |r, s| sums[packed(r, s)][j]);
        let mut replacements = state.replacements(at);
        let mut best: Option<(usize, f64)> = None;
        match self {
            Objective::Determinant | Objective::Trace(_) => {}
            Objective::Largest(predicted) => {
                let rows = predicted.count() * predicted.rows();
                let most = (ALL / (rows * n * k).max(1)).max(REPLACEMENTS);
                if replacements.len() > most {
                    most_informative(&mut replacements, &spread, k, most);
                }
                let few = blocks.subset(&replacements);
                state.effort += (rows * few.count() * n * k) as f64 + (count * n * n * k) as f64;
                let roots: Vec<Vec<f64>> = replacements.iter().map(|j| root_of(&spread, *j)).collect();
                let mut worst = vec![0.0_f64; replacements.len()];
                let mut along = vec![vec![0.0; replacements.len()]; k];
                for p in 0..predicted.count() {
                    for q in 0..predicted.rows() {
                        let x = predicted.row(p, q);
                        let w = times(inverse, &x);
                        let variance = dot(&x, &w);
                        along.iter_mut().enumerate().for_each(|(r, out)| few.along(r, &w, out));
                        for (c, worst) in worst.iter_mut().enumerate() {
                            *worst = worst.max(variance - squared(&roots[c], k, |s| along[s][c]));
                        }
                    }
                }
                replacements.into_iter().zip(worst).for_each(|replacement| keep(&mut best, now, replacement));
            }
            Objective::Eigenvalue(combinations) => {
                let image = combinations.image(inverse);
                let eigen = image.self_adjoint_eigen(Side::Lower).ok()?;
                let p = image.nrows();
                // eigenvalues come in nondecreasing order
                let (worst, most) = (combinations.combined(|i| eigen.U()[(i, p - 1)]), eigen.S()[p - 1]);
                let w = times(inverse, &worst);
                let mut along = vec![vec![0.0; count]; k];
                along.iter_mut().enumerate().for_each(|(r, out)| blocks.along(r, &w, out));
                let bound = |j: usize| most - squared(&root_of(&spread, j), k, |s| along[s][j]);
                let mut bounded: Vec<(f64, usize)> = replacements.into_iter().map(|j| (bound(j), j)).collect();
                bounded.sort_by(|a, b| a.0.total_cmp(&b.0));
                state.effort += (count * (n * n + 2 * k * n) * k) as f64;
                let columns: Vec<Vec<f64>> = combinations.0.iter().map(|row| times(inverse, row)).collect();
                for (bound, j) in bounded {
                    if bound >= best.map_or(now, |(_, value)| value) {
                        break;
                    }
                    let root = root_of(&spread, j);
                    // rows of L^-1 B
                    let rows: Vec<Vec<f64>> = (0..k).map(|r| blocks.row(j, r)).collect();
                    let b: Vec<Vec<f64>> = rows.iter().map(|x| columns.iter().map(|c| dot(x, c)).collect()).collect();
                    let of_root = |r: usize, c: usize| (0..=r).map(|s| root[packed(s, r)] * b[s][c]).sum::<f64>();
                    let white: Vec<Vec<f64>> = (0..k).map(|r| (0..p).map(|c| of_root(r, c)).collect()).collect();
                    let less = |i: usize, c: usize| white.iter().map(|row| row[i] * row[c]).sum::<f64>();
                    let reduced = Mat::from_fn(p, p, |i, c| image[(i, c)] - less(i, c));
                    state.effort += (k * n * p + 10 * p * p * p) as f64;
                    keep(&mut best, now, (j, largest_eigenvalue(&reduced)));
                }
            }
            Objective::Volume(functions) => {
                let (without, slopes) = functions.with_slopes(inverse)?;
                let deviations: Vec<f64> = inverse.iter().zip(&slopes).map(|(all, part)| all - part).collect();
                let known = blocks.quadratics(&deviations);
                state.effort += (2 * count * n * n * k) as f64;
                // -2 log det L^-1 = log det(I + G)
                let log_det = |sums: &[Vec<f64>], j: usize| {
                    let root = root_of(sums, j);
                    -2.0 * (0..k).map(|r| root[packed(r, r)].ln()).sum::<f64>()
                };
                for j in replacements {
                    let value = ((without + log_det(&known, j) - log_det(&spread, j)) / functions.size()).exp();
                    keep(&mut best, now, (j, value));
                }
            }
        }
        best
    }

    /// The same where `Mi` is singular: the most informative replacements, with one factorisation each.
    pub(super) fn one_by_one(
        &self,
        state: &mut State<'_>,
        at: usize,
        without: &[f64],
        now: f64,
    ) -> Option<(usize, f64)> {
        let (blocks, n) = (state.problem.blocks, state.problem.blocks.unknowns());
        let mut replacements: Vec<usize> = (0..blocks.count()).filter(|j| state.allowed(at, *j)).collect();
        most_informative(&mut replacements, &state.spread, blocks.rows(), REPLACEMENTS);
        let mut best: Option<(usize, f64)> = None;
        for j in replacements {
            let mut m = without.to_vec();
            for r in 0..blocks.rows() {
                add_outer(&mut m, 1.0, &blocks.row(j, r));
            }
            let Some((inverse, _)) = super::blocks::invert(&m, n) else { continue };
            if let Some(value) = self.of(&inverse) {
                keep(&mut best, now, (j, value));
            }
        }
        state.effort += (REPLACEMENTS * n * n * n) as f64;
        best
    }
}

/// Keep a replacement with a value below `now` and below the best so far.
fn keep(best: &mut Option<(usize, f64)>, now: f64, (j, value): (usize, f64)) {
    if value < best.map_or(now, |(_, before)| before) {
        *best = Some((j, value));
    }
}

/// The `most` candidates with the largest sums of `x' M^-1 x`.
fn most_informative(list: &mut Vec<usize>, spread: &[Vec<f64>], k: usize, most: usize) {
    let information = |j: usize| (0..k).map(|r| spread[packed(r, r)][j]).sum::<f64>();
    list.sort_by(|a, b| information(*b).total_cmp(&information(*a)));
    list.truncate(most);
}

/// `|L^-1 b|^2`.
fn squared(root: &[f64], k: usize, b: impl Fn(usize) -> f64) -> f64 {
    (0..k).fold(0.0, |sum, r| {
        let y: f64 = (0..=r).map(|s| root[packed(s, r)] * b(s)).sum();
        sum + y * y
    })
}

/// `L^-1` of `I + G`, `L L' = I + G`; element (r, s), s <= r, at `packed(s, r)`.
fn inverse_root(k: usize, g: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let mut l = vec![0.0; k * (k + 1) / 2];
    for r in 0..k {
        for c in 0..=r {
            let sum: f64 = (0..c).map(|m| l[packed(m, r)] * l[packed(m, c)]).sum();
            let remainder = g(c, r) + f64::from(u8::from(r == c)) - sum;
            l[packed(c, r)] = if r == c { remainder.max(1e-300).sqrt() } else { remainder / l[packed(c, c)] };
        }
    }
    let mut inverse = vec![0.0; k * (k + 1) / 2];
    for c in 0..k {
        for r in c..k {
            let sum: f64 = (c..r).map(|m| l[packed(m, r)] * inverse[packed(c, m)]).sum();
            inverse[packed(c, r)] = (f64::from(u8::from(r == c)) - sum) / l[packed(r, r)];
        }
    }
    inverse
}
