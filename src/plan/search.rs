//! The search: all designs where there are few, else many starts of exchanges, until their number or the effort is spent.
//!
//! Every design there is, where there are few enough: the best of them is proven to be the best.
#![allow(
    clippy::indexing_slicing,
    reason = "`ways` has `choose + 1` entries and is indexed by 0 to `choose`; `chosen` holds numbers of the problem's candidates, of which `settled` has one entry each"
)]

use super::bound::Bound;
use super::exchange::{descend, start};
use super::prices::Till;
use super::problem::{Design, Problem, information};
use super::request::Request;
use rayon::prelude::*;

/// The least number (of readings, of cost) for which something is found: bisection between one that is too small and one for which it is known, then single
/// steps in earnest until nothing is found. `within` tells for what number its result is enough.
pub(super) fn least<T>(
    mut low: f64,
    known: (f64, T),
    step: f64,
    mut within: impl FnMut(f64, &T, bool) -> Option<(f64, T)>,
) -> (f64, T) {
    let mut best = known;
    while best.0 - low > 1.5 * step {
        let middle = (0.5 * (low + best.0)).min(best.0 - step);
        match within(middle, &best.1, false) {
            Some(found) => best = found,
            None => low = middle,
        }
    }
    while let Some(found) = within(best.0 - step, &best.1, true).filter(|found| found.0 < best.0) {
        best = found;
    }
    best
}

/// The result of a search.
#[derive(Debug, Clone)]
pub(super) struct Outcome {
    /// The design.
    pub design: Design,
    /// Starts that ended at its value of the objective.
    pub hits: usize,
    /// Starts that were made.
    pub starts: usize,
    /// Designs that were tried, where that was all of them: none is better.
    pub enumerated: Option<u64>,
    /// The approximate design, where it was needed.
    pub guide: Option<Bound>,
}

/// Limits of a search.
#[derive(Clone)]
pub(super) struct Limits<'a> {
    /// Starts.
    pub starts: usize,
    /// The request: its seed, which gives the same design on any machine, and whom it tells of the progress.
    pub request: &'a Request,
    /// Multiplications after which no further starts are made.
    pub effort: f64,
    /// A value of the objective that is good enough.
    pub enough: Option<f64>,
    /// Is the approximate design wanted where starts do without it?
    pub bounded: bool,
    /// Further designs from which exchanges start.
    pub given: &'a dyn Fn() -> Vec<Vec<usize>>,
}

impl<'a> Limits<'a> {
    /// Limits of one search of a request.
    pub fn of(request: &'a Request, given: &'a dyn Fn() -> Vec<Vec<usize>>) -> Self {
        // more starts than the default: more time
        let patience = (request.starts as f64 / 100.0).clamp(1.0, 5.0);
        Limits { starts: request.starts, request, effort: EFFORT * patience, enough: None, bounded: true, given }
    }
}

/// Starts between looks at the effort.
const BATCH: usize = 8;
/// Multiplications after which no further starts are made: about a second.
pub(super) const EFFORT: f64 = 5e8;

/// The best of all designs, or of many starts. `guide`: the approximate design, whose weights some starts round. `None` where no design is
/// regular, or no start reached one.
pub(super) fn search(
    problem: &Problem<'_>,
    limits: &Limits<'_>,
    guide: impl FnOnce() -> Option<Bound>,
) -> Option<Outcome> {
    if problem.neighbours.is_empty()
        && let Some((best, designs)) = best_of_all(problem)
    {
        return best.map(|design| Outcome { design, hits: 1, starts: 1, enumerated: Some(designs), guide: None });
    }
    let (given, guide) = ((limits.given)(), guide());
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.abs().max(b.abs()).max(1e-300);
    let mut best: Option<(Design, usize)> = None;
    let keep = |best: &mut Option<(Design, usize)>, design: Design| match best {
        Some((known, hits)) if near(known.value, design.value) => *hits += 1,
        Some((known, _)) if known.value <= design.value => {}
        _ => *best = Some((design, 1)),
    };
    let (starts, Request { seed, progress, .. }) = (limits.starts.max(1), limits.request);
    let (mut made, mut effort) = (0, 0.0);
    while made < starts && effort < limits.effort {
        let batch: Vec<usize> = (made..(made + BATCH).min(starts)).collect();
        made += batch.len();
        let designs: Vec<Option<Design>> =
            batch.into_par_iter().map(|k| start(problem, *seed, k, guide.as_ref())).collect();
        for design in designs.into_iter().flatten() {
            effort += design.effort;
            keep(&mut best, design);
        }
        progress.tell("starts", made, starts);
        // no design is better than the bound, and a value that is good enough ends the search
        let value = best.as_ref().map_or(f64::INFINITY, |(design, _)| design.value);
        if guide.as_ref().is_some_and(|guide| value - guide.value <= 1e-9 * guide.value.abs())
            || limits.enough.is_some_and(|enough| value <= enough)
        {
            break;
        }
    }
    for given in given.into_iter().filter(|given| problem.allows(given)) {
        descend(problem, given).into_iter().for_each(|design| keep(&mut best, design));
    }
    best.map(|(design, hits)| Outcome { design, hits: hits.min(made), starts: made, enumerated: None, guide })
}

/// With fewer designs than this, all are tried.
const MOST_DESIGNS: u64 = 100_000;
/// Lists that are looked at while designs within a budget are counted.
const MOST_NODES: u64 = 400_000;
/// Different portions that a list may have while designs are counted.
const MOST_DEPTH: usize = 1000;

/// The best of all designs (`None` where none is regular) and how many there are; `None` where there are too many.
///
/// With a budget, only designs to which nothing can be added are tried: more readings are never worse.
fn best_of_all(problem: &Problem<'_>) -> Option<(Option<Design>, u64)> {
    if problem.is_short() {
        return Some((None, 0));
    }
    let count = problem.blocks.count();
    let surely = match problem.prices {
        None => problem.choose,
        Some(prices) => {
            // so many portions are affordable whichever they are: every list of one portion fewer has a completion, and a completion few such lists
            crate::number::count(prices.budget / prices.dearest()).min(problem.choose).saturating_sub(1)
        }
    };
    // with repeats as often as one likes; else at least those without any
    number(if problem.most_repeats >= surely { (count + surely).saturating_sub(1) } else { count }, surely)?;
    let mut designs: Vec<Vec<(usize, u32)>> = Vec::new();
    let till = problem.prices.map(|prices| Till::new(prices, &[]));
    grow(problem, till, &mut Vec::new(), &mut 0, &mut designs)?;
    let evaluate = |design: &Vec<(usize, u32)>| {
        problem.objective.value(&information(problem.blocks, problem.base, design), problem.blocks.unknowns())
    };
    let values: Vec<Option<f64>> = designs.par_iter().map(evaluate).collect();
    // the first of equal ones, whatever the number of threads
    let finite =
        values.into_iter().zip(&designs).filter_map(|(value, design)| Some((value.filter(|v| v.is_finite())?, design)));
    let best = finite.reduce(|best, next| if next.0 < best.0 - 1e-12 * best.0.abs() { next } else { best });
    let best = best.and_then(|(_, design)| {
        problem.design(design.iter().flat_map(|(j, times)| std::iter::repeat_n(*j, *times as usize)).collect())
    });
    Some((best, designs.len() as u64))
}

/// Choices of `choose` out of `of`; `None` where there are too many.
fn number(of: usize, choose: usize) -> Option<u64> {
    // growing with every factor
    let small = choose.min(of.saturating_sub(choose)) as u64;
    let mut product = 1_u64;
    for k in 1..=small {
        product = product.checked_mul(of as u64 - small + k)? / k;
        if product >= MOST_DESIGNS {
            return None;
        }
    }
    Some(product)
}

/// Designs that begin with those chosen, each as candidates with how often; nothing can be added to any. `None` where there are too many.
fn grow(
    problem: &Problem<'_>,
    till: Option<Till<'_>>,
    chosen: &mut Vec<(usize, u32)>,
    nodes: &mut u64,
    out: &mut Vec<Vec<(usize, u32)>>,
) -> Option<()> {
    *nodes += 1;
    let (count, repeats) = (problem.blocks.count(), problem.most_repeats);
    let taken: usize = chosen.iter().map(|(_, times)| *times as usize).sum();
    if *nodes > MOST_NODES || chosen.len() > MOST_DEPTH || out.len() as u64 >= MOST_DESIGNS {
        return None;
    }
    let affords = |till: &Option<Till<'_>>, k: usize| till.as_ref().is_none_or(|till| till.room(None, k).is_some());
    let times_of = |k: usize| chosen.iter().find(|(j, _)| *j == k).map_or(0, |(_, times)| *times as usize);
    if taken >= problem.choose || !(0..count).any(|k| times_of(k) < repeats && affords(&till, k)) {
        out.push(chosen.clone());
        return Some(());
    }
    // the first choice begins at the first candidate
    for k in chosen.last().map_or(0, |(last, _)| last + 1)..count {
        let mut next = till.clone();
        let further = (count - k - 1).saturating_mul(repeats);
        for (times, all) in (1..=u32::MAX).zip(taken + 1..=problem.choose).take(repeats) {
            if !affords(&next, k) {
                break;
            }
            next.iter_mut().for_each(|till| till.change(None, Some(k)));
            // without a budget, every design has its number
            if problem.prices.is_some() || further.saturating_add(all) >= problem.choose {
                chosen.push((k, times));
                grow(problem, next.clone(), chosen, nodes, out)?;
                chosen.pop();
            }
        }
    }
    Some(())
}
