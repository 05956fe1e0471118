//! The best positions for a budget: how many mountings, and how many readings at each, when a remounting costs more than a rate change.
//!
//! Exchanges as for a fixed number, among replacements that the budget allows; what is left is spent on what tells most for its cost; then whole
//! mountings are moved, states of a mounting replaced, mountings and states given up and the money spent anew. From every optimum that is
//! found, a mounting is closed or opened at random and the search goes on from there.
#![allow(
    clippy::indexing_slicing,
    reason = "`chosen` holds numbers of the problem's candidates, of which `used` has one entry each"
)]

use super::blocks::{add_outer, invert, times};
use super::bound::sandwich;
use super::exchange::value;
use super::exchange::{FEW, improve_state};
use super::prices::{Prices, Till};
use super::problem::{Design, Objective, Problem, WORTH, information};
use super::state::State;
use crate::elements::Elements;
use crate::linear::dot;
use crate::number;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::Rng;

/// Optima from which the search goes on, for each start.
const KICKS: usize = 4;
/// More rounds of exchanges and moves than this have never been needed.
const ROUNDS: usize = 60;

/// One start: a random number of mountings, then the search. `None` where nothing regular was found.
///
/// The largest of very many variances is dear to compare, and so is an eigenvalue: mountings are found by the smooth criterion that is nearest (the
/// determinant, the sum of the variances), and exchanges lower what is largest then.
pub(super) fn start(problem: &Problem<'_>, prices: &Prices, rng: &mut Pcg64Mcg) -> Option<Design> {
    let nearest = match problem.objective {
        Objective::Largest(rows) if rows.count() * rows.rows() > FEW => Objective::Determinant,
        Objective::Eigenvalue(combinations) => Objective::Trace(combinations.sum()),
        _ => return searched(problem, prices, rng),
    };
    let smooth = searched(&Problem { objective: &nearest, ..problem.clone() }, prices, rng)?;
    let mut state = State::of(problem, smooth.chosen)?;
    improve_state(&mut state);
    let (mut chosen, effort) = (state.chosen, smooth.effort + state.effort);
    fill(problem, prices, &mut chosen);
    chosen.sort_unstable();
    Some(Design { value: regular(problem, &chosen)?, chosen, effort })
}

fn searched(problem: &Problem<'_>, prices: &Prices, rng: &mut Pcg64Mcg) -> Option<Design> {
    let mut draw = |below: usize| number::below(rng.next_u64(), below);
    let count = problem.blocks.count();
    let least = (0..count).map(|j| prices.alone(j)).fold(f64::INFINITY, f64::min);
    let most =
        if least > 0.0 { number::count((prices.budget / least).min(prices.places as f64)) } else { prices.places };
    let mountings = 1 + draw(most);
    let mut chosen: Vec<usize> = Vec::new();
    let mut till = Till::new(prices, &[]);
    while chosen.len() < mountings.min(problem.choose) {
        let k = draw(count);
        if !prices.affords(till.spent + till.difference(prices, None, Some(k))) {
            break;
        }
        till.change(prices, None, Some(k));
        chosen.push(k);
    }
    fill(problem, prices, &mut chosen);
    let mut best = descend(problem, prices, chosen)?;
    let mut effort = best.effort;
    for _ in 0..KICKS {
        let mut chosen = best.chosen.clone();
        let gone = chosen.get(draw(chosen.len())).and_then(|k| prices.place.get(*k)).copied();
        if draw(2) == 0 {
            chosen.retain(|k| prices.place.get(*k).copied() != gone);
        } else {
            let at = draw(chosen.len());
            chosen.swap_remove(at.min(chosen.len().saturating_sub(1)));
        }
        let spent = |chosen: &[usize]| prices.of(chosen);
        let k = draw(count);
        let times_chosen = chosen.iter().filter(|own| **own == k).count();
        if times_chosen < problem.most_repeats {
            chosen.push(k);
        }
        while !prices.affords(spent(&chosen)) || chosen.len() > problem.choose {
            let at = draw(chosen.len().saturating_sub(1));
            chosen.swap_remove(at);
        }
        fill(problem, prices, &mut chosen);
        if let Some(other) = descend(problem, prices, chosen) {
            effort += other.effort;
            if other.value < best.value {
                best = other;
            }
        }
    }
    best.chosen.sort_unstable();
    Some(Design { effort, ..best })
}

/// Down from a list of portions until no move is worth it.
pub(super) fn descend(problem: &Problem<'_>, prices: &Prices, mut chosen: Vec<usize>) -> Option<Design> {
    let mut now = regular(problem, &chosen)?;
    let (blocks, n) = (problem.blocks, problem.blocks.unknowns());
    let mut effort = 0.0;
    for _ in 0..ROUNDS {
        let mut state = State::of(problem, chosen.clone())?;
        improve_state(&mut state);
        effort += state.effort;
        let mut further = state.chosen;
        fill(problem, prices, &mut further);
        if let Some(value) = regular(problem, &further).filter(|v| worth(*v, now)) {
            (now, chosen) = (value, further);
        }
        let moves = Moves::new(problem, prices, &chosen);
        effort +=
            (moves.open.len() * (2 * prices.places * n * n * n + 150 * blocks.count() * blocks.rows() * n)) as f64;
        match moves.of_mountings(now).or_else(|| moves.with_spending(now)) {
            Some((value, better)) => (now, chosen) = (value, better),
            None => break,
        }
    }
    Some(Design { value: now, chosen, effort })
}

/// Is `found` better than `now` by more than rounding?
fn worth(found: f64, now: f64) -> bool {
    found < now - WORTH * now.abs().max(1e-300)
}

fn regular(problem: &Problem<'_>, chosen: &[usize]) -> Option<f64> {
    value(problem.objective, &information(problem.blocks, problem.base, chosen), problem.blocks.unknowns())
}

/// Designs that differ from one in a mounting or a state.
struct Moves<'a> {
    problem: &'a Problem<'a>,
    prices: &'a Prices,
    chosen: &'a [usize],
    /// Mountings in use.
    open: Vec<usize>,
    information: Vec<f64>,
}

impl<'a> Moves<'a> {
    fn new(problem: &'a Problem<'a>, prices: &'a Prices, chosen: &'a [usize]) -> Self {
        let mut open: Vec<usize> = chosen.iter().filter_map(|k| prices.place.get(*k)).copied().collect();
        open.sort_unstable();
        open.dedup();
        Moves { problem, prices, chosen, open, information: information(problem.blocks, problem.base, chosen) }
    }

    fn place(&self, k: usize) -> usize {
        self.prices.place.at(k)
    }

    fn kind(&self, k: usize) -> usize {
        self.prices.kind.at(k)
    }

    fn repeats_allowed(&self, design: &[usize]) -> bool {
        if self.problem.most_repeats >= design.len() {
            return true;
        }
        let mut sorted = design.to_vec();
        sorted.sort_unstable();
        sorted.chunk_by(|a, b| a == b).all(|same| same.len() <= self.problem.most_repeats)
    }

    /// The best design in which one mounting lies elsewhere with the same states, or has another state in place of one of its own.
    fn of_mountings(&self, now: f64) -> Option<(f64, Vec<usize>)> {
        let Moves { problem, prices, chosen, .. } = self;
        let (blocks, n) = (problem.blocks, problem.blocks.unknowns());
        let mut best: Option<(f64, Vec<usize>)> = None;
        let mut consider = |own: &[usize], to: &dyn Fn(usize) -> Option<usize>| {
            // portions of the mounting that change, and what they become
            let changed: Option<Vec<(usize, usize)>> = own.iter().map(|k| Some((*k, to(*k)?))).collect();
            let Some(changed) = changed else { return };
            let mut m = self.information.clone();
            for (from, to) in changed.iter().filter(|(from, to)| from != to) {
                for r in 0..blocks.rows() {
                    add_outer(&mut m, 1.0, &blocks.row(*to, r));
                    add_outer(&mut m, -1.0, &blocks.row(*from, r));
                }
            }
            let Some(found) = value(problem.objective, &m, n) else { return };
            if !worth(found, best.as_ref().map_or(now, |(value, _)| *value)) {
                return;
            }
            let mut left = changed;
            let design: Vec<usize> = chosen
                .iter()
                .map(|k| match left.iter().position(|(from, _)| from == k) {
                    Some(at) => left.swap_remove(at).1,
                    None => *k,
                })
                .collect();
            // the difference of sums may have lost digits
            if prices.affords(prices.of(&design))
                && self.repeats_allowed(&design)
                && let Some(exact) = regular(problem, &design)
                && worth(exact, best.as_ref().map_or(now, |(value, _)| *value))
            {
                best = Some((exact, design));
            }
        };
        for place in &self.open {
            let own: Vec<usize> = chosen.iter().copied().filter(|k| self.place(*k) == *place).collect();
            for other in (0..prices.places).filter(|other| other != place) {
                consider(&own, &|k| prices.at.get(&(other, self.kind(k))).copied());
            }
            let mut kinds: Vec<usize> = own.iter().map(|k| self.kind(*k)).collect();
            kinds.sort_unstable();
            kinds.dedup();
            for from in kinds {
                let same: Vec<usize> = own.iter().copied().filter(|k| self.kind(*k) == from).collect();
                // another state here; a state of another mounting is an exchange
                for to in prices
                    .at
                    .keys()
                    .filter(|(at, kind)| at == place && *kind != from)
                    .map(|(_, kind)| *kind)
                    .collect::<std::collections::BTreeSet<_>>()
                {
                    consider(&same, &|_| prices.at.get(&(*place, to)).copied());
                }
            }
        }
        best
    }

    /// The best design in which a mounting or a state of a mounting is given up, or one portion, and what it cost is spent anew.
    fn with_spending(&self, now: f64) -> Option<(f64, Vec<usize>)> {
        let Moves { problem, prices, chosen, .. } = self;
        let mut best: Option<(f64, Vec<usize>)> = None;
        let mut consider = |mut design: Vec<usize>| {
            fill(problem, prices, &mut design);
            if let Some(found) = regular(problem, &design)
                && worth(found, best.as_ref().map_or(now, |(value, _)| *value))
            {
                best = Some((found, design));
            }
        };
        for place in &self.open {
            consider(chosen.iter().copied().filter(|k| self.place(*k) != *place).collect());
        }
        let mut distinct = chosen.to_vec();
        distinct.sort_unstable();
        distinct.dedup();
        for gone in distinct {
            if chosen.iter().filter(|k| **k == gone).count() > 1 {
                consider(chosen.iter().copied().filter(|k| *k != gone).collect());
            }
            let mut design = chosen.to_vec();
            if let Some(at) = design.iter().position(|k| *k == gone) {
                design.swap_remove(at);
            }
            consider(design);
        }
        best
    }
}

/// Add what tells most for its cost until nothing more can be paid for, or the number is reached.
pub(super) fn fill(problem: &Problem<'_>, prices: &Prices, chosen: &mut Vec<usize>) {
    let (blocks, n) = (problem.blocks, problem.blocks.unknowns());
    let count = blocks.count();
    let mut till = Till::new(prices, chosen);
    let mut used = vec![0_usize; count];
    chosen.iter().for_each(|k| used[*k] += 1);
    let room = |till: &Till, used: &[usize], k: usize| {
        let more = till.difference(prices, None, Some(k));
        (used[k] < problem.most_repeats && prices.affords(till.spent + more)).then_some(more)
    };
    if chosen.len() >= problem.choose || !(0..count).any(|k| room(&till, &used, k).is_some()) {
        return;
    }
    let mut m = information(blocks, problem.base, chosen);
    let little = 1e-6 * (0..n).filter_map(|i| m.get(i * n + i)).fold(0.0_f64, |most, d| most.max(*d)).max(1e-6);
    m.iter_mut().step_by(n + 1).for_each(|d| *d += little);
    let Some((mut inverse, _)) = invert(&m, n) else { return };
    // x' M^-1 x of every row of every candidate, kept by rank-one updates
    let mut work = vec![0.0; count];
    let mut spread = vec![vec![0.0_f64; count]; blocks.rows()];
    spread.iter_mut().enumerate().for_each(|(r, own)| blocks.quadratic(r, r, &inverse, own, &mut work));
    let mut told = vec![0.0_f64; count];
    let mut effect = vec![0.0_f64; count];
    while chosen.len() < problem.choose.min(MOST) {
        told.fill(0.0);
        for (r, own) in spread.iter().enumerate() {
            // what a row alone adds to log det M, or takes from tr(W M^-1)
            if let Objective::Trace(w) = problem.objective {
                blocks.quadratic(r, r, &sandwich(&inverse, w, n), &mut effect, &mut work);
                told.iter_mut().zip(own).zip(&effect).for_each(|((told, d), e)| *told += e / (1.0 + d));
            } else {
                told.iter_mut().zip(own).for_each(|(told, d)| *told += d.ln_1p());
            }
        }
        let mut best: Option<(f64, usize)> = None;
        for (k, told) in told.iter().enumerate() {
            if let Some(more) = room(&till, &used, k) {
                let gain = told / more.max(1e-9);
                if best.is_none_or(|(most, _)| gain > most) {
                    best = Some((gain, k));
                }
            }
        }
        let Some((_, k)) = best else { break };
        for r in 0..blocks.rows() {
            let x = blocks.row(k, r);
            let w = times(&inverse, &x);
            let factor = -1.0 / (1.0 + dot(&x, &w));
            add_outer(&mut inverse, factor, &w);
            for (s, own) in spread.iter_mut().enumerate() {
                blocks.along(s, &w, &mut work);
                own.iter_mut().zip(&work).for_each(|(d, t)| *d += factor * t * t);
            }
        }
        used[k] += 1;
        till.change(prices, None, Some(k));
        chosen.push(k);
    }
}

/// More portions than this are not chosen, whatever the budget.
const MOST: usize = 10_000;
