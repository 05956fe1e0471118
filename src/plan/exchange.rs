//! Exchange: start from some candidates, then replace one chosen candidate at a time while the criterion improves.
//!
//! With `M` the information of the design, replacing block `i` by block `j` multiplies the determinant by
//!
//! ```text
//! det(M + Xj'Xj - Xi'Xi) / det M = |det(S + X M^-1 X')|,   X = [Xj; Xi],  S = diag(1, .., -1, ..)
//! tr(W M'^-1) = tr(W M^-1) - tr[(S + X M^-1 X')^-1 X M^-1 W M^-1 X']
//! ```
//!
//! (V. V. Fedorov, Theory of Optimal Experiments, 1972, 3.1; the order of trials is that of R. D. Cook, C. J. Nachtsheim, Technometrics 22
//! (1980) 315: the best partner of one chosen block at a time). Partners are weighed in `partners.rs`, `M^-1` and the sums over candidates
//! follow by the rank-one updates of `state.rs`; every start ends with a fresh factorisation, so that no drift of them reaches the answer.

use super::blocks::{Blocks, add_outer, dot, invert};
use super::budget::Prices;
use super::state::State;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use rayon::prelude::*;

/// What the exchange makes small, in the coordinates of the blocks.
#[derive(Debug, Clone, PartialEq)]
pub enum Objective {
    /// `-log det M`: D.
    Determinant,
    /// `tr(W M^-1)`, `W` symmetric and row by row: A, and c with `W = c c'`.
    Trace(Vec<f64>),
    /// The largest `x' M^-1 x` over all rows of these blocks: G.
    Largest(Blocks),
}

/// The exchange problem.
#[derive(Debug, Clone)]
pub(super) struct Problem<'a> {
    /// What may be chosen.
    pub blocks: &'a Blocks,
    /// Information of what is kept, row by row.
    pub base: &'a [f64],
    /// What is made small.
    pub objective: &'a Objective,
    /// How many blocks are chosen.
    pub choose: usize,
    /// How often one candidate may be chosen.
    pub most_repeats: usize,
    /// For coordinate exchange: candidates that differ from each in one coordinate; empty for Fedorov's exchange.
    pub neighbours: &'a [Vec<usize>],
    /// Prices that exchanges must keep to, where there is a budget instead of a number.
    pub prices: Option<&'a Prices>,
}

/// A chosen design.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Design {
    /// Candidates, sorted, with repeats.
    pub chosen: Vec<usize>,
    /// The objective's value after a fresh factorisation.
    pub value: f64,
}

/// An exchange must improve the criterion by this share to be made: less is rounding, and could go round in a circle.
pub(super) const WORTH: f64 = 1e-9;
/// More sweeps than this have never been needed.
pub(super) const SWEEPS: usize = 200;
/// Exchanges between fresh factorisations.
const REFACTOR: usize = 50;

/// `M`, for a list of chosen candidates.
pub(super) fn information(blocks: &Blocks, base: &[f64], chosen: &[usize]) -> Vec<f64> {
    let mut m = base.to_vec();
    for j in chosen {
        for r in 0..blocks.rows() {
            add_outer(&mut m, 1.0, &blocks.row(*j, r));
        }
    }
    m
}

/// The objective's value for an information matrix of `n` unknowns; `None` where it is singular.
pub(super) fn value(objective: &Objective, m: &[f64], n: usize) -> Option<f64> {
    let (inverse, log_det) = invert(m, n)?;
    Some(match objective {
        Objective::Determinant => -log_det,
        Objective::Trace(w) => dot(w, &inverse),
        Objective::Largest(predicted) => predicted.largest_quadratic(&inverse),
    })
}

/// Every start from its own seed; the best value, and how many starts reached it. The same seed gives the same design on any machine.
pub(super) fn best_of_starts(problem: &Problem<'_>, starts: usize, seed: u64) -> Option<(Design, usize)> {
    best_of(starts, seed, |rng| start(problem, rng))
}

/// The best of designs that a search makes from random numbers.
pub(super) fn best_of(
    starts: usize,
    seed: u64,
    search: impl Fn(&mut Pcg64Mcg) -> Option<Design> + Sync,
) -> Option<(Design, usize)> {
    let one = |k: u64| search(&mut Pcg64Mcg::seed_from_u64(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(k)));
    let designs: Vec<Option<Design>> = match starts {
        0 | 1 => vec![one(0)],
        _ => (0..starts as u64).into_par_iter().map(one).collect(),
    };
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.abs().max(b.abs()).max(1e-300);
    let mut best: Option<(Design, usize)> = None;
    for design in designs.into_iter().flatten() {
        match &mut best {
            Some((known, hits)) if near(known.value, design.value) => *hits += 1,
            Some((known, _)) if known.value <= design.value => {}
            _ => best = Some((design, 1)),
        }
    }
    best
}

/// One start: random blocks first, then the most informative, then exchanges until none is worth it. `None` where no such design is regular.
fn start(problem: &Problem<'_>, rng: &mut Pcg64Mcg) -> Option<Design> {
    let mut state = State::begin(problem, rng)?;
    improve_state(&mut state);
    let mut chosen = state.chosen;
    chosen.sort_unstable();
    let m = information(problem.blocks, problem.base, &chosen);
    let value = value(problem.objective, &m, problem.blocks.unknowns())?;
    Some(Design { chosen, value })
}

/// Exchanges until none is worth it.
pub(super) fn improve_state(state: &mut State<'_>) {
    match state.problem.objective {
        Objective::Largest(predicted) => {
            // from where the start is, and from the best determinant: the first alone is slow to get near, the second is the same from any start
            let other = State::of(state.problem, state.chosen.clone());
            sweeps(state, &Objective::Determinant);
            super::largest::lower(state, predicted);
            if let Some(mut other) = other {
                super::largest::lower(&mut other, predicted);
                if predicted.largest_quadratic(&other.inverse) < predicted.largest_quadratic(&state.inverse) {
                    *state = other;
                }
            }
        }
        objective => sweeps(state, objective),
    }
}

/// Sweep over the chosen blocks until none has a better partner.
fn sweeps(state: &mut State<'_>, objective: &Objective) {
    let n = state.problem.blocks.unknowns();
    let mut since_refactor = 0;
    for _ in 0..SWEEPS {
        let mut improved = false;
        for at in 0..state.chosen.len() {
            let (best, better) = match objective {
                Objective::Trace(w) => {
                    let (j, decrease) = state.best_for_trace(at, w);
                    (j, decrease > WORTH * dot(w, &state.inverse))
                }
                _ => {
                    let (j, ratio) = state.best_for_determinant(at);
                    (j, ratio > 1.0 + WORTH * n as f64)
                }
            };
            if better && best != state.chosen[at] {
                match objective {
                    Objective::Determinant if state.problem.blocks.rows() == 1 => state.exchange_single(at, best),
                    _ => state.exchange(at, best),
                }
                improved = true;
                since_refactor += 1;
                if since_refactor >= REFACTOR {
                    since_refactor = 0;
                    if state.refactor().is_none() {
                        return;
                    }
                }
            }
        }
        if !improved {
            return;
        }
    }
}
