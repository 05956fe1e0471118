//! The best positions for a budget: how many mountings, and how many readings at each, when a remounting costs more than a rate change.
//!
//! ```text
//! cost = sum over mountings [ mounting + reading * r + rate * (r - 1) ],   r readings there (no rate change where all have one state)
//! ```
//!
//! Exchanges as for a fixed number, among partners that the budget allows; then whole mountings are moved, closed and filled up again.
//! Every start has its own number of mountings, from one to as many as the budget pays for.

use super::blocks::{add_outer, dot, invert, times};
use super::bound::sandwich;
use super::effort::{Costs, mounting};
use super::exchange::{Design, Objective, Problem, WORTH, best_of, improve_state, information, value};
use super::pool::Pool;
use super::state::State;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::Rng;
use std::collections::HashMap;

/// What portions cost together.
#[derive(Debug, Clone)]
pub(super) struct Prices {
    /// What may be spent.
    pub budget: f64,
    costs: Costs,
    /// Readings of a portion.
    size: usize,
    /// Mounting of each portion, and its state within the mounting.
    place: Vec<usize>,
    state: Vec<usize>,
    /// Portion of a place and state.
    at: HashMap<(usize, usize), usize>,
    places: usize,
    states: usize,
}

impl Prices {
    /// Prices of a pool's portions; with `remounts`, every portion is a mounting of its own.
    pub fn new(pool: &Pool, costs: Costs, budget: f64, remounts: bool) -> Self {
        let mut places: HashMap<String, usize> = HashMap::new();
        let mut states: HashMap<String, usize> = HashMap::new();
        let (mut place, mut state, mut at) = (Vec::new(), Vec::new(), HashMap::new());
        for (k, portion) in pool.portions.iter().enumerate() {
            let held = portion.first().map(mounting).unwrap_or_default();
            let key = if remounts { k.to_string() } else { format!("{held:?}") };
            let next = places.len();
            let own = *places.entry(key).or_insert(next);
            let rates: Vec<Vec<f64>> =
                portion.iter().map(|r| r.joints.iter().map(|s| s.rate_deg_s()).collect()).collect();
            let next = states.len();
            let kind = *states.entry(format!("{rates:?}")).or_insert(next);
            place.push(own);
            state.push(kind);
            at.entry((own, kind)).or_insert(k);
        }
        Prices {
            budget,
            costs,
            size: pool.portion_size(),
            place,
            state,
            at,
            places: places.len(),
            states: states.len(),
        }
    }

    /// Cost of a list of portions.
    pub fn of(&self, chosen: impl Iterator<Item = usize>) -> f64 {
        let mut used: Vec<(usize, usize)> =
            chosen.filter_map(|k| Some((*self.place.get(k)?, *self.state.get(k)?))).collect();
        used.sort_unstable();
        let own = |same: &[(usize, usize)]| {
            let changes = self.size > 1 || same.first() != same.last();
            self.of_mounting(same.len(), changes)
        };
        used.chunk_by(|a, b| a.0 == b.0).map(own).sum()
    }

    /// Cost of one mounting with so many portions.
    fn of_mounting(&self, portions: usize, changes: bool) -> f64 {
        let readings = portions * self.size;
        let changed = if changes { readings.saturating_sub(1) } else { 0 };
        self.costs.mounting + self.costs.reading * readings as f64 + self.costs.rate_change * changed as f64
    }

    /// What each portion would add to the cost of a list.
    fn further(&self, chosen: &[usize]) -> Vec<f64> {
        // portions, first state and whether there is another, of each place
        let mut used: Vec<(usize, usize, bool)> = vec![(0, 0, false); self.places];
        for k in chosen {
            let (Some(state), Some(own)) = (self.state.get(*k), self.place.get(*k).and_then(|p| used.get_mut(*p)))
            else {
                continue;
            };
            *own = if own.0 == 0 { (1, *state, self.size > 1) } else { (own.0 + 1, own.1, own.2 || own.1 != *state) };
        }
        let more = |(place, state): (&usize, &usize)| match used.get(*place) {
            Some((portions, first, changes)) if *portions > 0 => {
                self.of_mounting(portions + 1, *changes || first != state) - self.of_mounting(*portions, *changes)
            }
            _ => self.of_mounting(1, self.size > 1),
        };
        self.place.iter().zip(&self.state).map(more).collect()
    }

    /// Is a list within the budget?
    pub fn allow(&self, chosen: impl Iterator<Item = usize>) -> bool {
        self.of(chosen) <= self.budget * (1.0 + 1e-12)
    }

    /// May candidate `j` replace the portion at `at`?
    pub fn allow_exchange(&self, chosen: &[usize], at: usize, j: usize) -> bool {
        self.allow(chosen.iter().enumerate().map(|(k, own)| if k == at { j } else { *own }))
    }
}

/// The best design within the budget; `None` where none determines the unknowns.
pub(super) fn best(problem: &Problem<'_>, prices: &Prices, starts: usize, seed: u64) -> Option<(Design, usize)> {
    best_of(starts, seed, |rng| start(problem, prices, rng))
}

fn start(problem: &Problem<'_>, prices: &Prices, rng: &mut Pcg64Mcg) -> Option<Design> {
    let mut draw = |below: usize| ((u128::from(rng.next_u64()) * below.max(1) as u128) >> 64) as usize;
    let least = prices.costs.mounting + prices.costs.reading * prices.size as f64;
    let most = if least > 0.0 { (prices.budget / least).min(prices.places as f64) as usize } else { prices.places };
    let mountings = 1 + draw(most);
    let mut chosen: Vec<usize> = Vec::new();
    while chosen.len() < mountings {
        let k = draw(problem.blocks.count());
        if !prices.allow(chosen.iter().copied().chain([k])) {
            break;
        }
        chosen.push(k);
    }
    fill(problem, prices, &mut chosen);
    let mut best = regular(problem, &chosen)?;
    for _ in 0..super::exchange::SWEEPS {
        let before = best;
        let mut state = State::of(problem, chosen.clone())?;
        improve_state(&mut state);
        chosen = state.chosen;
        fill(problem, prices, &mut chosen);
        best = regular(problem, &chosen)?;
        if let Some((better, found)) = moved(problem, prices, &chosen, best) {
            (best, chosen) = (better, found);
        }
        if !(best < before - WORTH * before.abs().max(1e-300)) {
            break;
        }
    }
    chosen.sort_unstable();
    Some(Design { value: regular(problem, &chosen)?, chosen })
}

fn regular(problem: &Problem<'_>, chosen: &[usize]) -> Option<f64> {
    value(problem.objective, &information(problem.blocks, problem.base, chosen), problem.blocks.unknowns())
}

/// Add what tells most for its cost until nothing more can be paid for.
fn fill(problem: &Problem<'_>, prices: &Prices, chosen: &mut Vec<usize>) {
    let (blocks, n) = (problem.blocks, problem.blocks.unknowns());
    let mut m = information(blocks, problem.base, chosen);
    let little = 1e-6 * (0..n).filter_map(|i| m.get(i * n + i)).fold(0.0_f64, |most, d| most.max(*d)).max(1e-6);
    m.iter_mut().step_by(n + 1).for_each(|d| *d += little);
    let Some((mut inverse, _)) = invert(&m, n) else { return };
    let mut used = vec![0_usize; blocks.count()];
    chosen.iter().for_each(|k| used[*k] += 1);
    let mut spent = prices.of(chosen.iter().copied());
    // x' M^-1 x of every row of every candidate, kept by rank-one updates
    let mut work = vec![0.0; used.len()];
    let mut spread = vec![vec![0.0_f64; used.len()]; blocks.rows()];
    spread.iter_mut().enumerate().for_each(|(r, own)| blocks.quadratic(r, r, &inverse, own, &mut work));
    let mut told = vec![0.0_f64; used.len()];
    let mut effect = vec![0.0_f64; used.len()];
    // free readings without end are no design
    while chosen.len() < MOST {
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
        let further = prices.further(chosen);
        let mut best: Option<(f64, usize)> = None;
        for (k, (told, more)) in told.iter().zip(&further).enumerate() {
            let allowed = used[k] < problem.most_repeats && spent + more <= prices.budget * (1.0 + 1e-12);
            let gain = told / more.max(1e-9);
            if allowed && best.is_none_or(|(most, _)| gain > most) {
                best = Some((gain, k));
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
        spent += further[k];
        chosen.push(k);
    }
}

/// More portions than this are not chosen, whatever the budget.
const MOST: usize = 10_000;

/// The best design that differs in one mounting (moved to another place with the same rates, one rate replaced by another, or closed) or has
/// lost one portion, with what is left of the budget filled up again.
fn moved(problem: &Problem<'_>, prices: &Prices, chosen: &[usize], now: f64) -> Option<(f64, Vec<usize>)> {
    let mut open: Vec<usize> = chosen.iter().filter_map(|k| prices.place.get(*k)).copied().collect();
    open.sort_unstable();
    open.dedup();
    let mut best: Option<(f64, Vec<usize>)> = None;
    let mut consider = |design: Vec<usize>| {
        let Some(found) = regular(problem, &design) else { return };
        if found < best.as_ref().map_or(now - WORTH * now.abs(), |(value, _)| *value) {
            best = Some((found, design));
        }
    };
    let repeats_allowed = |design: &[usize]| {
        let mut sorted = design.to_vec();
        sorted.sort_unstable();
        problem.most_repeats >= design.len()
            || sorted.chunk_by(|a, b| a == b).all(|same| same.len() <= problem.most_repeats)
    };
    for place in &open {
        let mut try_map = |map: &dyn Fn(usize) -> (usize, usize)| {
            let design: Option<Vec<usize>> = chosen
                .iter()
                .map(|k| match (prices.place.get(*k), prices.state.get(*k)) {
                    (Some(own), Some(state)) if own == place => prices.at.get(&map(*state)).copied(),
                    _ => Some(*k),
                })
                .collect();
            match design {
                Some(design) if prices.allow(design.iter().copied()) && repeats_allowed(&design) => consider(design),
                _ => {}
            }
        };
        for other in (0..prices.places).filter(|other| other != place) {
            try_map(&|state| (other, state));
        }
        for from in 0..prices.states {
            for to in (0..prices.states).filter(|to| *to != from) {
                try_map(&|state| (*place, if state == from { to } else { state }));
            }
        }
        let mut closed: Vec<usize> = chosen.iter().copied().filter(|k| prices.place.get(*k) != Some(place)).collect();
        fill(problem, prices, &mut closed);
        consider(closed);
    }
    let mut distinct = chosen.to_vec();
    distinct.sort_unstable();
    distinct.dedup();
    for gone in distinct {
        let mut design = chosen.to_vec();
        if let Some(at) = design.iter().position(|k| *k == gone) {
            design.swap_remove(at);
        }
        fill(problem, prices, &mut design);
        consider(design);
    }
    best
}
