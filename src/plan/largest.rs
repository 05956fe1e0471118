//! Exchanges for what is largest: the worst of several variances is not smooth in the design, so every replacement is weighed by all of them.
//!
//! Taking block `i` out first, `Mi = M - Xi'Xi`, a replacement `j` leaves for a predicted row `r`
//!
//! ```text
//! r' (Mi + Xj'Xj)^-1 r = r' Mi^-1 r - b' T^-1 b,    T = I + Xj Mi^-1 Xj',   b = Xj Mi^-1 r
//! ```
#![allow(
    clippy::indexing_slicing,
    reason = "`t`, roots and along are made here, packed over the rows of a block, with one entry for each candidate or replacement"
)]

use super::blocks::{Blocks, add_outer, invert, times};
use super::problem::{SWEEPS, WORTH, information};
use super::state::{State, packed};
use crate::linear::dot;

/// Replacements that are tried one by one where the block cannot be taken out.
const REPLACEMENTS: usize = 60;
/// Products of predicted rows, candidates and unknowns beyond which only the most informative replacements are weighed.
const ALL: usize = 20_000_000;

/// The worst of several variances: what the design makes small where it is not smooth.
pub(super) trait Worst {
    /// Its value for `M^-1`, row by row.
    fn of(&self, inverse: &[f64]) -> f64;
    /// The replacement that leaves the smallest value below `now`, and that value; `inverse` is that without the block at `at`.
    fn replacement(&self, state: &mut State<'_>, at: usize, inverse: &[f64], now: f64) -> Option<(usize, f64)>;
}

impl Worst for Blocks {
    fn of(&self, inverse: &[f64]) -> f64 {
        self.largest_quadratic(inverse)
    }

    fn replacement(&self, state: &mut State<'_>, at: usize, inverse: &[f64], now: f64) -> Option<(usize, f64)> {
        best_replacement(state, at, self, inverse, now)
    }
}

/// Exchanges that lower the worst.
pub(super) fn lower(state: &mut State<'_>, worst: &impl Worst) {
    let blocks = state.problem.blocks;
    let mut now = worst.of(&state.inverse);
    for _ in 0..SWEEPS {
        let mut improved = false;
        let mut settled = vec![false; blocks.count()];
        for at in 0..state.chosen.len() {
            if settled[state.chosen[at]] {
                continue;
            }
            let mut without = information(blocks, state.problem.base, &state.chosen);
            for r in 0..blocks.rows() {
                add_outer(&mut without, -1.0, &blocks.row(state.chosen[at], r));
            }
            let best = match invert(&without, blocks.unknowns()) {
                Some((inverse, _)) => worst.replacement(state, at, &inverse, now),
                None => one_by_one(state, at, worst, &without, now),
            };
            match best.filter(|(_, value)| *value < now * (1.0 - WORTH)) {
                Some((j, _)) => {
                    state.exchange(at, j);
                    let after = worst.of(&state.inverse);
                    improved |= after < now * (1.0 - 0.5 * WORTH);
                    now = after;
                    settled.fill(false);
                }
                None => settled[state.chosen[at]] = true,
            }
        }
        if !improved || state.refactor().is_none() {
            return;
        }
    }
}

/// The replacement that leaves the smallest largest variance; `inverse` is that without the block at `at`.
fn best_replacement(
    state: &mut State<'_>,
    at: usize,
    predicted: &Blocks,
    inverse: &[f64],
    now: f64,
) -> Option<(usize, f64)> {
    let (blocks, n, k) = (state.problem.blocks, state.problem.blocks.unknowns(), state.problem.blocks.rows());
    let rows = predicted.count() * predicted.rows();
    // T of every candidate, then those that are weighed
    let mut work = vec![0.0; blocks.count()];
    let mut t = vec![vec![0.0; blocks.count()]; k * (k + 1) / 2];
    for s in 0..k {
        for r in 0..=s {
            blocks.quadratic(r, s, inverse, &mut t[packed(r, s)], &mut work);
        }
    }
    let mut replacements = state.replacements(at);
    let most = ALL / (rows * n * k).max(1);
    if replacements.len() > most.max(REPLACEMENTS) {
        let told = |j: usize| (0..k).map(|r| t[packed(r, r)][j]).sum::<f64>();
        replacements.sort_by(|a, b| told(*b).total_cmp(&told(*a)));
        replacements.truncate(most.max(REPLACEMENTS));
    }
    let few = blocks.subset(&replacements);
    state.effort += (rows * few.count() * n * k) as f64 + (blocks.count() * n * n * k) as f64;
    // L^-1 of every replacement, packed by rows
    let roots: Vec<Vec<f64>> = replacements.iter().map(|j| inverse_root(k, |r, s| t[packed(r, s)][*j])).collect();
    let mut worst = vec![0.0_f64; replacements.len()];
    let mut along = vec![vec![0.0; replacements.len()]; k];
    for p in 0..predicted.count() {
        for q in 0..predicted.rows() {
            let x = predicted.row(p, q);
            let w = times(inverse, &x);
            let own = dot(&x, &w);
            for (r, out) in along.iter_mut().enumerate() {
                few.along(r, &w, out);
            }
            for (c, worst) in worst.iter_mut().enumerate() {
                let root = &roots[c];
                let mut less = 0.0;
                for r in 0..k {
                    let y: f64 = (0..=r).map(|s| root[packed(s, r)] * along[s][c]).sum();
                    less += y * y;
                }
                *worst = worst.max(own - less);
            }
        }
    }
    let mut best: Option<(usize, f64)> = None;
    for (j, value) in replacements.iter().zip(&worst) {
        if *value < now && best.is_none_or(|(_, before)| *value < before) {
            best = Some((*j, *value));
        }
    }
    best
}

/// `L^-1` of `I + G`, `L L' = I + G`; element (r, s), s <= r, at `packed(s, r)`.
pub(super) fn inverse_root(k: usize, g: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let mut l = vec![0.0; k * (k + 1) / 2];
    for r in 0..k {
        for c in 0..=r {
            let sum: f64 = (0..c).map(|m| l[packed(m, r)] * l[packed(m, c)]).sum();
            let own = g(c, r) + f64::from(u8::from(r == c)) - sum;
            l[packed(c, r)] = if r == c { own.max(1e-300).sqrt() } else { own / l[packed(c, c)] };
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

/// The same where the block cannot be taken out: the most informative replacements, each with a factorisation of its own.
fn one_by_one(state: &mut State<'_>, at: usize, worst: &impl Worst, without: &[f64], now: f64) -> Option<(usize, f64)> {
    let (blocks, n) = (state.problem.blocks, state.problem.blocks.unknowns());
    let told = |j: usize| (0..blocks.rows()).map(|r| state.spread[packed(r, r)][j]).sum::<f64>();
    let mut replacements: Vec<usize> = (0..blocks.count()).filter(|j| state.allowed(at, *j)).collect();
    replacements.sort_by(|a, b| told(*b).total_cmp(&told(*a)));
    let mut best: Option<(usize, f64)> = None;
    for j in replacements.into_iter().take(REPLACEMENTS) {
        let mut m = without.to_vec();
        for r in 0..blocks.rows() {
            add_outer(&mut m, 1.0, &blocks.row(j, r));
        }
        let Some((inverse, _)) = invert(&m, n) else { continue };
        let value = worst.of(&inverse);
        if value < now && best.is_none_or(|(_, before)| value < before) {
            best = Some((j, value));
        }
    }
    state.effort += (REPLACEMENTS * n * n * n) as f64;
    best
}
