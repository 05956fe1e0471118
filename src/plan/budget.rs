//! The best positions for a budget: how many mountings, and how many readings at each, when a remounting costs more than a rate change.
//!
//! Exchanges as for a fixed number, among replacements that the budget allows; the remainder is spent on the largest gains per cost; then whole
//! mountings are moved, states of a mounting replaced, mountings and states given up and their cost spent anew. From every optimum,
//! a mounting is closed or opened at random and the search continues.
#![allow(
    clippy::indexing_slicing,
    reason = "`chosen` holds numbers of the problem's candidates, of which `used` has one entry each"
)]

use super::blocks::{packed, sandwich};
use super::exchange::{improve_state, value};
use super::objective::Objective;
use super::prices::{Prices, Till};
use super::problem::{Design, Problem, WORTH, counted, information};
use super::state::State;
use crate::elements::Elements;
use crate::number;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::Rng;

/// Perturbations of the optimum of each start, from which the search continues.
const KICKS: usize = 4;
/// More rounds of exchanges and moves than this have never been needed.
const ROUNDS: usize = 60;

/// One start: a random number of mountings, then the search. `None` where no regular design is reached.
///
/// The largest of very many variances is expensive to compare, and so is an eigenvalue: mountings are chosen by the smooth criterion that approximates
/// it (the determinant, the sum of the variances); then exchanges lower the largest.
pub(super) fn start(problem: &Problem<'_>, prices: &Prices, rng: &mut Pcg64Mcg) -> Option<Design> {
    let Some(nearest) = problem.objective.nearest().filter(|_| !problem.objective.is_of_few()) else {
        return searched(problem, prices, rng);
    };
    let smooth = searched(&Problem { objective: &nearest, ..problem.clone() }, prices, rng)?;
    let mut state = State::of(problem, smooth.chosen)?;
    improve_state(&mut state);
    let (mut chosen, mut effort) = (fill(problem, prices, state.chosen), smooth.effort + state.effort);
    if let Objective::Volume(_) = problem.objective {
        // smooth itself: mountings are moved by the criterion
        let further = descend(problem, prices, chosen)?;
        chosen = further.chosen;
        effort += further.effort;
    }
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
    let mut best = descend(problem, prices, fill(problem, prices, chosen))?;
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
        let k = draw(count);
        let times_chosen = chosen.iter().filter(|j| **j == k).count();
        if times_chosen < problem.most_repeats {
            chosen.push(k);
        }
        while !prices.affords(prices.of(&chosen)) || chosen.len() > problem.choose {
            let at = draw(chosen.len().saturating_sub(1));
            chosen.swap_remove(at);
        }
        if let Some(other) = descend(problem, prices, fill(problem, prices, chosen)) {
            effort += other.effort;
            if other.value < best.value {
                best = other;
            }
        }
    }
    best.chosen.sort_unstable();
    Some(Design { effort, ..best })
}

/// Descent from a list of portions until no move is significant.
pub(super) fn descend(problem: &Problem<'_>, prices: &Prices, mut chosen: Vec<usize>) -> Option<Design> {
    let mut now = regular(problem, &chosen)?;
    let (blocks, n) = (problem.blocks, problem.blocks.unknowns());
    let mut effort = 0.0;
    for _ in 0..ROUNDS {
        let mut state = State::of(problem, chosen.clone())?;
        improve_state(&mut state);
        effort += state.effort;
        let further = fill(problem, prices, state.chosen);
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

/// Is `value` better than `now` by more than rounding?
fn worth(value: f64, now: f64) -> bool {
    value < now - WORTH * now.abs().max(1e-300)
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

    /// The best design in which one mounting lies elsewhere with the same states, or another state in place of one of its states.
    fn of_mountings(&self, now: f64) -> Option<(f64, Vec<usize>)> {
        let Moves { problem, prices, chosen, .. } = self;
        let (blocks, n) = (problem.blocks, problem.blocks.unknowns());
        let mut best: Option<(f64, Vec<usize>)> = None;
        let (mut m, mut x) = (Vec::new(), Vec::new());
        let mut consider = |uses: &[(usize, u32)], to: &dyn Fn(usize) -> Option<usize>| {
            // portions of the mounting that change, and their replacements
            let changed: Option<Vec<(usize, usize)>> = uses.iter().map(|(k, _)| Some((*k, to(*k)?))).collect();
            let Some(changed) = changed else { return };
            m.clone_from(&self.information);
            for ((from, to), (_, times)) in changed.iter().zip(uses).filter(|((from, to), _)| from != to) {
                for r in 0..blocks.rows() {
                    blocks.add_row(&mut m, f64::from(*times), *to, r, &mut x);
                    blocks.add_row(&mut m, -f64::from(*times), *from, r, &mut x);
                }
            }
            let Some(estimate) = value(problem.objective, &m, n) else { return };
            if !worth(estimate, best.as_ref().map_or(now, |(value, _)| *value)) {
                return;
            }
            let becomes = |k: &usize| changed.iter().find(|(from, _)| from == k).map_or(*k, |(_, to)| *to);
            let design: Vec<usize> = chosen.iter().map(becomes).collect();
            // the difference of sums may have lost digits
            if prices.affords(prices.of(&design))
                && problem.allows_repeats(&design)
                && let Some(exact) = regular(problem, &design)
                && worth(exact, best.as_ref().map_or(now, |(value, _)| *value))
            {
                best = Some((exact, design));
            }
        };
        let all = counted(chosen);
        for place in &self.open {
            let uses: Vec<(usize, u32)> = all.iter().copied().filter(|(k, _)| prices.place.at(*k) == *place).collect();
            for other in (0..prices.places).filter(|other| other != place) {
                consider(&uses, &|k| prices.at.get(&(other, prices.kind.at(k))).copied());
            }
            let mut kinds: Vec<usize> = uses.iter().map(|(k, _)| prices.kind.at(*k)).collect();
            kinds.sort_unstable();
            kinds.dedup();
            for from in kinds {
                let same: Vec<_> = uses.iter().copied().filter(|(k, _)| prices.kind.at(*k) == from).collect();
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

    /// The best design without a mounting, a portion or its repeats, and with their cost spent anew.
    fn with_spending(&self, now: f64) -> Option<(f64, Vec<usize>)> {
        let Moves { problem, prices, chosen, .. } = self;
        let mut best: Option<(f64, Vec<usize>)> = None;
        let mut whole = State::unsolved(problem, chosen.to_vec());
        let solved = whole.solve_nearly().is_some();
        let mut consider = |gone: &[(usize, u32)]| {
            let less = if solved { without(&whole, prices, gone) } else { None };
            let design = match less {
                Some(less) if less.chosen.len() < problem.choose => filled(less, prices),
                _ => fill(problem, prices, remaining(chosen, gone)),
            };
            if let Some(value) = regular(problem, &design)
                && worth(value, best.as_ref().map_or(now, |(value, _)| *value))
            {
                best = Some((value, design));
            }
        };
        let all = counted(chosen);
        for place in &self.open {
            let uses: Vec<(usize, u32)> = all.iter().copied().filter(|(k, _)| prices.place.at(*k) == *place).collect();
            consider(&uses);
        }
        for (gone, times) in all {
            if times > 1 {
                consider(&[(gone, times)]);
            }
            consider(&[(gone, 1)]);
        }
        best
    }
}

/// Add the candidate with the largest gain per cost until nothing more is affordable, or the number is reached.
fn fill(problem: &Problem<'_>, prices: &Prices, chosen: Vec<usize>) -> Vec<usize> {
    let mut state = State::unsolved(problem, chosen);
    let has_room =
        state.chosen.len() < problem.choose && (0..problem.blocks.count()).any(|k| room(&state, prices, k).is_some());
    if has_room && state.solve_nearly().is_some() {
        return filled(state, prices);
    }
    state.chosen
}

/// Cost of one more of a candidate, if it may be chosen.
fn room(state: &State<'_>, prices: &Prices, k: usize) -> Option<f64> {
    let till = state.till.as_ref().filter(|_| (state.times_chosen[k] as usize) < state.problem.most_repeats)?;
    let more = till.difference(prices, None, Some(k));
    prices.affords(till.spent + more).then_some(more)
}

/// A list without some of its portions, each so many times.
fn remaining(chosen: &[usize], gone: &[(usize, u32)]) -> Vec<usize> {
    let mut gone = gone.to_vec();
    let mut stays = |k: &usize| match gone.iter_mut().find(|(j, times)| j == k && *times > 0) {
        Some((_, times)) => {
            *times -= 1;
            false
        }
        None => true,
    };
    chosen.iter().copied().filter(|k| stays(k)).collect()
}

/// The same design without some portions, each so many times; `None` where it is nearly singular and has to be factored anew.
fn without<'a>(state: &State<'a>, prices: &Prices, gone: &[(usize, u32)]) -> Option<State<'a>> {
    let blocks = state.problem.blocks;
    let mut less = state.clone();
    for (k, times) in gone {
        for r in 0..blocks.rows() {
            let leverage = less.spread.get(packed(r, r)).map_or(f64::NAN, |spread| spread[*k]);
            if !(1.0 - f64::from(*times) * leverage > 1e-4) {
                return None;
            }
            less.update(&blocks.row(*k, r), -f64::from(*times));
        }
        for _ in 0..*times {
            less.till.iter_mut().for_each(|till| till.change(prices, Some(*k), None));
            less.times_chosen[*k] = less.times_chosen[*k].saturating_sub(1);
        }
    }
    less.chosen = remaining(&less.chosen, gone);
    Some(less)
}

/// The same, for a state with inverse and sums.
fn filled(mut state: State<'_>, prices: &Prices) -> Vec<usize> {
    let problem = state.problem;
    let (blocks, n, count) = (problem.blocks, problem.blocks.unknowns(), problem.blocks.count());
    let mut work = vec![0.0; count];
    // upper bounds on the criterion's gain by each candidate
    let mut gains = vec![0.0_f64; count];
    let mut effect = vec![0.0_f64; count];
    let least = prices.least_more().max(1e-9);
    let mut last = None;
    while state.chosen.len() < problem.choose.min(MOST) {
        let Some(till) = &state.till else { break };
        gains.fill(0.0);
        let traced = if let Objective::Trace(w) = problem.objective { Some(w.as_slice()) } else { None };
        let spread = || (0..blocks.rows()).filter_map(|r| state.spread.get(packed(r, r)));
        for (r, leverage) in spread().enumerate() {
            // decrease of tr(W M^-1) by a row alone, or increase of log det M: ln(1 + d) <= d
            if let Some(w) = traced {
                blocks.quadratic(r, r, &sandwich(&state.inverse, w, n), &mut effect, &mut work);
                gains.iter_mut().zip(leverage).zip(&effect).for_each(|((gain, d), e)| *gain += e / (1.0 + d));
            } else {
                gains.iter_mut().zip(leverage).for_each(|(gain, d)| *gain += d);
            }
        }
        let mut best: Option<(f64, usize)> = None;
        // the last one is often the best again: then the bound excludes most others
        for (k, most) in last.into_iter().chain(0..count).filter_map(|k| Some((k, *gains.get(k)?))) {
            if best.is_some_and(|(gain, _)| !(most / till.at_least(prices, k).max(least) > gain)) {
                continue;
            }
            let Some(more) = room(&state, prices, k) else { continue };
            let criterion = match traced {
                Some(_) => most,
                None => spread().filter_map(|leverage| leverage.get(k)).map(|d| d.ln_1p()).sum(),
            };
            let gain = criterion / more.max(1e-9);
            if best.is_none_or(|(most, _)| gain > most) {
                best = Some((gain, k));
            }
        }
        let Some((_, k)) = best else { break };
        state.add(k);
        last = Some(k);
    }
    state.chosen
}

/// More portions than this are not chosen, whatever the budget.
const MOST: usize = 10_000;
