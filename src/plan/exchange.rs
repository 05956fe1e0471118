//! One start: a first design, exchanges until none is significant, and the same from perturbations of the optimum.
//!
//! Replacements of one chosen portion at a time (`state.rs`). Within a budget, what is left is spent on the largest gains per cost; then whole mountings are
//! moved, states of a mounting replaced, mountings and states given up and their cost spent anew. Every result has its value from a fresh factorisation,
//! without accumulated rounding.
#![allow(
    clippy::indexing_slicing,
    reason = "gains have an entry for each candidate, and weights, too: numbers of candidates are drawn below their count"
)]

use super::bound::Bound;
use super::effort::grouped;
use super::prices::Prices;
use super::problem::{Design, Problem, WORTH, counted};
use super::state::State;
use crate::elements::Elements;
use crate::number;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// Kinds of first designs, by the number of the start: a third at random and then the most informative candidates; all at random; the rounded
/// weights of the approximate design.
const KINDS: usize = 3;
/// Perturbations of the optimum of each start, from which the search continues.
const KICKS: usize = 4;
/// More rounds of exchanges and moves than this have never been needed.
const ROUNDS: usize = 60;
/// More portions than this are not bought, whatever the budget.
const MOST: usize = 10_000;

/// One start. `None` where no regular design is reached.
///
/// Within a budget, the largest of very many variances is expensive to compare, and so is an eigenvalue: mountings are chosen by the smooth criterion
/// that approximates it (the determinant, the sum of the variances), and the last descent is by the largest.
pub(super) fn start(problem: &Problem<'_>, seed: u64, number: usize, guide: Option<&Bound>) -> Option<Design> {
    let rng = &mut Pcg64Mcg::seed_from_u64(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(number as u64));
    let nearest = problem.prices.and_then(|_| problem.objective.nearest());
    let nearest = nearest.filter(|_| !problem.objective.is_of_few());
    let smooth = nearest.as_ref().map(|objective| Problem { objective, ..problem.clone() });
    let sought = smooth.as_ref().unwrap_or(problem);
    let mut best = descend(sought, first(sought, rng, number, guide)?)?;
    let mut effort = best.effort;
    for _ in 0..KICKS {
        if let Some(other) = kicked(sought, &best.chosen, rng).and_then(|chosen| descend(sought, chosen)) {
            effort += other.effort;
            if other.value < best.value {
                best = other;
            }
        }
    }
    if smooth.is_some() {
        best = descend(problem, best.chosen)?;
        effort += best.effort;
    }
    Some(Design { effort, ..best })
}

/// A first design.
fn first(problem: &Problem<'_>, rng: &mut Pcg64Mcg, number: usize, guide: Option<&Bound>) -> Option<Vec<usize>> {
    let count = problem.blocks.count();
    if count == 0 || (problem.prices.is_none() && problem.choose > count.saturating_mul(problem.most_repeats)) {
        return None;
    }
    let guide = guide.filter(|_| problem.prices.is_none() && (problem.has_many() || number % KINDS == 2));
    if let Some(design) = guide.and_then(|guide| rounded(problem, &guide.weights, rng)) {
        return Some(design);
    }
    let mut draw = |below: usize| number::below(rng.next_u64(), below);
    let random = match problem.prices {
        None if number % KINDS == 1 => problem.choose,
        None => problem.choose.div_ceil(3),
        Some(prices) => 1 + draw(prices.most_mountings()),
    };
    let mut state = State::unsolved(problem, Vec::new());
    while state.chosen.len() < random.min(problem.choose) {
        let j = draw(count);
        match state.room(j) {
            Some(_) => state.count_in(j),
            None if problem.prices.is_some() => break,
            None => {}
        }
    }
    full(state)
}

/// Weights of the candidates, rounded: whole parts first, then the largest remainders, ties at random.
fn rounded(problem: &Problem<'_>, weights: &[f64], rng: &mut Pcg64Mcg) -> Option<Vec<usize>> {
    let total = problem.choose as f64;
    let mut chosen: Vec<usize> = Vec::with_capacity(problem.choose);
    let mut remainders: Vec<(f64, usize)> = Vec::with_capacity(weights.len());
    for (j, w) in weights.iter().enumerate() {
        let times = (w * total).floor().min(problem.most_repeats as f64);
        chosen.extend(std::iter::repeat_n(j, number::count(times)));
        if number::count(times) < problem.most_repeats {
            let jitter = (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
            remainders.push((w * total - times + 0.3 * jitter, j));
        }
    }
    remainders.sort_by(|a, b| b.0.total_cmp(&a.0));
    chosen.truncate(problem.choose);
    let lacking = problem.choose - chosen.len();
    chosen.extend(remainders.iter().take(lacking).map(|(_, j)| *j));
    problem.design(chosen).filter(|design| design.chosen.len() == problem.choose).map(|design| design.chosen)
}

/// A design with some portions, or a mounting, replaced at random, and filled up.
fn kicked(problem: &Problem<'_>, chosen: &[usize], rng: &mut Pcg64Mcg) -> Option<Vec<usize>> {
    let mut draw = |below: usize| number::below(rng.next_u64(), below);
    let mut state = State::unsolved(problem, chosen.to_vec());
    let one = chosen.get(draw(chosen.len()));
    match problem.prices.zip(one).filter(|_| draw(2) == 0) {
        Some((prices, one)) => {
            let gone = |k: &usize| prices.place.at(*k) == prices.place.at(*one);
            while let Some(at) = state.chosen.iter().position(gone) {
                state.count_out(at);
            }
        }
        None => (0..1 + draw(3)).for_each(|_| state.count_out(draw(state.chosen.len()))),
    }
    let coming = if problem.prices.is_some() { 1 } else { problem.choose.saturating_sub(state.chosen.len()) };
    for j in (0..coming).map(|_| draw(problem.blocks.count())).collect::<Vec<_>>() {
        // others go until it is affordable
        while problem.prices.is_some() && state.room(j).is_none() && !state.chosen.is_empty() {
            state.count_out(draw(state.chosen.len()));
        }
        if state.room(j).is_some() {
            state.count_in(j);
        }
    }
    full(state)
}

/// A design with as many portions as may be chosen; without a budget, `None` where there are fewer.
fn full(state: State<'_>) -> Option<Vec<usize>> {
    let problem = state.problem;
    let chosen = filled(state).chosen;
    (problem.prices.is_some() || chosen.len() == problem.choose).then_some(chosen)
}

/// The candidate with the largest gain per cost is added until nothing more is affordable, or the number is reached.
fn filled(mut state: State<'_>) -> State<'_> {
    let problem = state.problem;
    let most = if problem.prices.is_some() { problem.choose.min(MOST) } else { problem.choose };
    while state.chosen.len() < most && (0..problem.blocks.count()).any(|k| state.room(k).is_some()) {
        if !state.is_solved() && state.solve_nearly().is_none() {
            break;
        }
        let gains = state.gains(None);
        let better = |best: Option<(usize, f64)>, k: usize| {
            let least = best.map_or(f64::NEG_INFINITY, |(_, gain)| gain);
            // of equal ones the first
            let gain = gains[k] / state.room(k)?.max(1e-9);
            (gain > least).then_some((k, gain))
        };
        let best = (0..gains.len()).fold(None, |best, k| better(best, k).or(best));
        let Some((best, _)) = best else { break };
        state.add(best);
    }
    state
}

/// Descent from a design until no exchange, and within a budget no move, is significant; `None` where it is singular.
pub(super) fn descend(problem: &Problem<'_>, chosen: Vec<usize>) -> Option<Design> {
    let mut best = problem.design(chosen)?;
    let mut effort = 0.0;
    for _ in 0..ROUNDS {
        let exchanged = exchanged(problem, best.chosen.clone())?;
        effort += exchanged.effort;
        let further = problem.design(filled(State::unsolved(problem, exchanged.chosen)).chosen);
        best = further.filter(|other| other.betters(&best)).unwrap_or(best);
        let Some(prices) = problem.prices else { break };
        let moves = Moves { problem, prices, from: &best };
        match moves.of_mountings(&mut effort).or_else(|| moves.with_spending(&mut effort)) {
            Some(better) => best = better,
            None => break,
        }
    }
    Some(Design { effort, ..best })
}

/// Exchanges until none is significant. An objective that is not smooth is lowered from the start, and from the optimum of the smooth objective that
/// approximates it: the first alone converges slowly, the second is the same from any start.
fn exchanged(problem: &Problem<'_>, chosen: Vec<usize>) -> Option<Design> {
    let swept = |problem: &Problem<'_>, chosen: Vec<usize>| {
        let state = State::of(problem, chosen)?.swept();
        let effort = state.effort;
        problem.design(state.chosen).map(|design| Design { effort, ..design })
    };
    let own = swept(problem, chosen.clone())?;
    let Some(nearest) = problem.objective.nearest() else { return Some(own) };
    let Some(near) = swept(&Problem { objective: &nearest, ..problem.clone() }, chosen) else { return Some(own) };
    let Some(other) = swept(problem, near.chosen) else { return Some(own) };
    let effort = own.effort + near.effort + other.effort;
    Some(Design { effort, ..if other.value < own.value { other } else { own } })
}

impl Design {
    /// Is it better by more than rounding?
    fn betters(&self, other: &Design) -> bool {
        self.value < other.value - WORTH * other.value.abs().max(1e-300)
    }
}

/// Designs that differ from one in a mounting or a state.
struct Moves<'a> {
    problem: &'a Problem<'a>,
    prices: &'a Prices,
    from: &'a Design,
}

impl Moves<'_> {
    /// Every portion in use, how often, and with those of its mounting.
    fn places(&self) -> Vec<Vec<(usize, u32)>> {
        grouped(counted(&self.from.chosen).into_iter().map(|(k, times)| ((k, times), self.prices.place.at(k))))
    }

    /// The best design of those that are allowed and better.
    fn best(&self, effort: &mut f64, designs: impl Iterator<Item = Vec<usize>>) -> Option<Design> {
        let mut best: Option<Design> = None;
        let n = self.problem.blocks.unknowns();
        for chosen in designs.filter(|chosen| self.problem.allows(chosen)) {
            *effort += (n * n * (n + chosen.len())) as f64;
            let design = self.problem.design(chosen);
            best = design.filter(|design| design.betters(best.as_ref().unwrap_or(self.from))).or(best);
        }
        best
    }

    /// One mounting lies elsewhere with the same states, or another state in place of one of its states. (A state of another mounting is an exchange.)
    fn of_mountings(&self, effort: &mut f64) -> Option<Design> {
        let Moves { problem, prices, from } = self;
        let becoming = |pairs: &[(usize, usize)]| {
            let becomes = |k: &usize| pairs.iter().find(|(from, _)| from == k).map_or(*k, |(_, to)| *to);
            from.chosen.iter().map(becomes).collect::<Vec<usize>>()
        };
        let mut designs = Vec::new();
        for uses in self.places() {
            let place = uses.first().map_or(usize::MAX, |(k, _)| prices.place.at(*k));
            for other in (0..prices.places).filter(|other| *other != place) {
                let there = |k: usize| prices.at.get(&(other, prices.kind.at(k))).copied();
                let pairs: Option<Vec<(usize, usize)>> = uses.iter().map(|(k, _)| Some((*k, there(*k)?))).collect();
                designs.extend(pairs.map(|pairs| becoming(&pairs)));
            }
            let here = (0..problem.blocks.count()).filter(|j| prices.place.at(*j) == place);
            for to in here {
                designs.extend(uses.iter().filter(|(k, _)| *k != to).map(|(k, _)| becoming(&[(*k, to)])));
            }
        }
        self.best(effort, designs.into_iter())
    }

    /// A mounting, a portion or its repeats given up, and what they cost spent anew.
    fn with_spending(&self, effort: &mut f64) -> Option<Design> {
        let mut whole = State::unsolved(self.problem, self.from.chosen.clone());
        whole.solve_nearly()?;
        let places = self.places();
        let mut gone = places.clone();
        for (k, times) in places.into_iter().flatten() {
            gone.push(vec![(k, 1)]);
            gone.extend((times > 1).then(|| vec![(k, times)]));
        }
        let spent = |gone: Vec<(usize, u32)>| {
            let mut less = whole.clone();
            gone.iter().for_each(|(k, times)| (0..*times).for_each(|_| less.remove(*k)));
            filled(less)
        };
        let designs: Vec<State<'_>> = gone.into_iter().map(spent).collect();
        *effort += designs.iter().map(|state| state.effort).sum::<f64>();
        self.best(effort, designs.into_iter().map(|state| state.chosen))
    }
}
