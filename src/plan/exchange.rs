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
//! (1980) 315: the best replacement of one chosen block at a time). Replacements are evaluated, and `M^-1` and the sums over candidates
//! follow by rank-one updates, in `state.rs`; every start ends with a fresh factorisation, so that the result has no accumulated rounding.
#![allow(
    clippy::indexing_slicing,
    reason = "`chosen` holds numbers of the problem's candidates, of which `settled` has one entry each"
)]

use super::blocks::{add_outer, invert};
use super::bound::Bound;
use super::objective::Objective;
use super::problem::{Design, Problem, SWEEPS, WORTH, information};
use super::state::State;
use crate::linear::dot;
use crate::number;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::Rng;

/// Exchanges between fresh factorisations.
const REFACTOR: usize = 50;

/// Kinds of first designs, by the number of the start: a third at random and then the most informative candidates; all at random; the rounded
/// weights of the approximate design.
const KINDS: usize = 3;
/// Perturbations of each start: some portions of its optimum are replaced at random, and exchanges repeated.
const KICKS: usize = 3;

/// One start: a first design, exchanges until none is significant, and the same from perturbations of the optimum. `None` where no such design
/// is regular.
pub(super) fn start(problem: &Problem<'_>, rng: &mut Pcg64Mcg, number: usize, guide: Option<&Bound>) -> Option<Design> {
    let mut state = match guide {
        Some(guide) if problem.has_many() || number % KINDS == 2 => State::rounded(problem, &guide.weights, rng),
        _ => State::begin(problem, if number % KINDS == 1 { 1.0 } else { 1.0 / 3.0 }, rng),
    }
    .or_else(|| State::begin(problem, 1.0 / 3.0, rng))?;
    improve_state(&mut state);
    let mut effort = state.effort;
    let mut best = finished(problem, state.chosen)?;
    for _ in 0..KICKS {
        let mut chosen = best.chosen.clone();
        let mut draw = |below: usize| number::below(rng.next_u64(), below);
        for _ in 0..1 + draw(3.min(chosen.len())) {
            let (at, j) = (draw(chosen.len()), draw(problem.blocks.count()));
            let may_repeat = chosen.iter().filter(|k| **k == j).count() < problem.most_repeats;
            // nothing is exchanged where nothing is chosen
            if let Some(slot) = chosen.get_mut(at).filter(|_| may_repeat) {
                *slot = j;
            }
        }
        let Some(mut state) = State::of(problem, chosen) else { continue };
        improve_state(&mut state);
        effort += state.effort;
        if let Some(other) = finished(problem, state.chosen)
            && other.value < best.value
        {
            best = other;
        }
    }
    Some(Design { effort, ..best })
}

/// Exchanges from a given design.
pub(super) fn descend(problem: &Problem<'_>, chosen: Vec<usize>) -> Option<Design> {
    let mut state = State::of(problem, chosen)?;
    improve_state(&mut state);
    finished(problem, state.chosen)
}

/// A design with its value from a fresh factorisation.
pub(super) fn finished(problem: &Problem<'_>, mut chosen: Vec<usize>) -> Option<Design> {
    chosen.sort_unstable();
    let m = information(problem.blocks, problem.base, &chosen);
    let value = value(problem.objective, &m, problem.blocks.unknowns())?;
    Some(Design { chosen, value, effort: 0.0 })
}

/// Exchanges until none is significant. An objective that is not smooth is lowered from the start, and from the optimum of the smooth objective that
/// approximates it: the first alone converges slowly, the second is the same from any start.
pub(super) fn improve_state(state: &mut State<'_>) {
    let objective = state.problem.objective;
    let Some(smooth) = objective.nearest() else { return sweeps(state, objective) };
    let other = State::of(state.problem, state.chosen.clone());
    sweeps(state, &smooth);
    let reached = lower(state, objective);
    if let Some(mut other) = other {
        let further = lower(&mut other, objective);
        let effort = state.effort + other.effort;
        if further < reached {
            *state = other;
        }
        state.effort = effort;
    }
}

/// Exchanges for an objective that is not smooth, and the value that they reach.
fn lower(state: &mut State<'_>, objective: &Objective) -> f64 {
    let blocks = state.problem.blocks;
    // a singular volume has no value
    let value = |state: &State<'_>| objective.of(&state.inverse).unwrap_or(f64::NAN);
    let mut now = value(state);
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
                Some((inverse, _)) => objective.replacement(state, at, &inverse, now),
                None => objective.one_by_one(state, at, &without, now),
            };
            match best.filter(|(_, value)| *value < now * (1.0 - WORTH)) {
                Some((j, _)) => {
                    state.exchange(at, j);
                    let after = value(state);
                    improved |= after < now * (1.0 - 0.5 * WORTH);
                    now = after;
                    settled.fill(false);
                }
                None => settled[state.chosen[at]] = true,
            }
        }
        if !improved || state.refactor().is_none() {
            break;
        }
    }
    value(state)
}

/// Sweep over the chosen blocks until none has a better replacement.
fn sweeps(state: &mut State<'_>, objective: &Objective) {
    let n = state.problem.blocks.unknowns();
    let mut since_refactor = 0;
    for _ in 0..SWEEPS {
        let mut improved = false;
        // blocks without a better replacement in the present design
        let mut settled = vec![false; state.problem.blocks.count()];
        for at in 0..state.chosen.len() {
            crate::stop::poll();
            if settled[state.chosen[at]] {
                continue;
            }
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
                settled.fill(false);
                since_refactor += 1;
                if since_refactor >= REFACTOR {
                    since_refactor = 0;
                    if state.refactor().is_none() {
                        return;
                    }
                }
            } else {
                settled[state.chosen[at]] = true;
            }
        }
        if !improved {
            return;
        }
    }
}

/// The objective's value for an information matrix of `n` unknowns; `None` where it is singular.
pub(super) fn value(objective: &Objective, m: &[f64], n: usize) -> Option<f64> {
    crate::stop::poll();
    let (inverse, log_det) = invert(m, n)?;
    Some(objective.of(&inverse).unwrap_or(-log_det))
}
