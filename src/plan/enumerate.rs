//! Every design there is, where there are few enough: the best of them is proven to be the best.
#![allow(clippy::indexing_slicing, reason = "`ways` has `choose + 1` entries and is indexed by 0 to `choose`")]

use super::blocks::{add_outer, rank};
use super::exchange::value;
use super::prices::Till;
use super::problem::{Design, Problem, information};
use rayon::prelude::*;

/// With fewer designs than this, all are tried.
pub(super) const MOST_DESIGNS: u64 = 100_000;
/// Lists that are looked at while designs within a budget are counted.
const MOST_NODES: u64 = 400_000;
/// Portions that a list within a budget may have while designs are counted.
const MOST_DEPTH: usize = 1000;

/// The best of all designs (`None` where none is regular) and how many there are; `None` where there are too many.
///
/// With a budget, only designs to which nothing can be added are tried: more readings are never worse.
pub(super) fn best(problem: &Problem<'_>) -> Option<(Option<Design>, u64)> {
    let n = problem.blocks.unknowns();
    // so few rows leave a defect, whatever the rounding says
    if problem.choose.saturating_mul(problem.blocks.rows()).saturating_add(rank(problem.base, n)) < n {
        return Some((None, 0));
    }
    let mut designs: Vec<Vec<(usize, usize)>> = Vec::new();
    match problem.prices {
        None => {
            let count = number(problem.blocks.count(), problem.choose, problem.most_repeats)?;
            designs.reserve(crate::number::index(count));
            all(problem.blocks.count(), problem.choose, problem.most_repeats, &mut Vec::new(), &mut designs);
        }
        Some(_) => within_budget(problem, &mut designs)?,
    }
    let evaluate = |design: &Vec<(usize, usize)>| {
        let mut m = problem.base.to_vec();
        for (j, times) in design {
            for r in 0..problem.blocks.rows() {
                add_outer(&mut m, *times as f64, &problem.blocks.row(*j, r));
            }
        }
        value(problem.objective, &m, n)
    };
    let values: Vec<Option<f64>> = designs.par_iter().map(evaluate).collect();
    // the first of equal ones, whatever the number of threads
    let mut best: Option<(f64, usize)> = None;
    for (k, value) in values.iter().enumerate() {
        if let Some(value) = value.filter(|v| v.is_finite())
            && best.is_none_or(|(before, _)| value < before - 1e-12 * before.abs())
        {
            best = Some((value, k));
        }
    }
    let found = best.and_then(|(_, k)| designs.get(k)).and_then(|design| {
        let chosen: Vec<usize> = design.iter().flat_map(|(j, times)| std::iter::repeat_n(*j, *times)).collect();
        let m = information(problem.blocks, problem.base, &chosen);
        Some(Design { value: value(problem.objective, &m, n)?, chosen, effort: 0.0 })
    });
    Some((found, designs.len() as u64))
}

/// Multisets of `choose` out of `count`, each at most `repeats` times; `None` where there are too many.
fn number(count: usize, choose: usize, repeats: usize) -> Option<u64> {
    if repeats >= choose {
        // C(count + choose - 1, choose), growing with every factor
        let small = choose.min(count.saturating_sub(1)) as u64;
        let large = (count + choose).saturating_sub(1) as u64 - small;
        let mut product = 1_u64;
        for k in 1..=small {
            product = product.checked_mul(large + k)? / k;
            if product >= MOST_DESIGNS {
                return None;
            }
        }
        return Some(product);
    }
    // ways to choose t so far
    let mut ways = vec![0_u64; choose + 1];
    ways[0] = 1;
    for _ in 0..count {
        for t in (1..=choose).rev() {
            let more: u64 = (1..=repeats.min(t)).map(|c| ways[t - c]).fold(0, u64::saturating_add);
            ways[t] = ways[t].saturating_add(more);
        }
        if ways[choose] >= MOST_DESIGNS {
            return None;
        }
    }
    Some(ways[choose])
}

/// All of them: candidates with how often each is chosen.
fn all(
    count: usize,
    choose: usize,
    repeats: usize,
    before: &mut Vec<(usize, usize)>,
    out: &mut Vec<Vec<(usize, usize)>>,
) {
    if choose == 0 {
        out.push(before.clone());
        return;
    }
    let first = before.last().map_or(0, |(j, _)| j + 1);
    for j in first..count {
        let others = (count - j - 1).saturating_mul(repeats);
        for times in 1..=repeats.min(choose) {
            if others.saturating_add(times) < choose {
                continue;
            }
            before.push((j, times));
            all(count, choose - times, repeats, before, out);
            before.pop();
        }
    }
}

/// Lists within the budget and the number, to which nothing can be added; `None` where there are too many.
fn within_budget(problem: &Problem<'_>, out: &mut Vec<Vec<(usize, usize)>>) -> Option<()> {
    let prices = problem.prices?;
    // so many portions can be paid for whichever they are: all lists of so many can be completed in some way, each way for a few of them
    let count = problem.blocks.count();
    let dearest = (0..count).map(|j| prices.alone(j)).fold(0.0, f64::max);
    let surely = crate::number::count(prices.budget / dearest).min(problem.choose);
    number(count, surely.saturating_sub(1), problem.most_repeats)?;
    let mut nodes = 0;
    grow(problem, &Till::new(prices, &[]), &mut Vec::new(), &mut nodes, out)
}

fn grow(
    problem: &Problem<'_>,
    till: &Till,
    chosen: &mut Vec<usize>,
    nodes: &mut u64,
    out: &mut Vec<Vec<(usize, usize)>>,
) -> Option<()> {
    let prices = problem.prices?;
    *nodes += 1;
    if *nodes > MOST_NODES || chosen.len() > MOST_DEPTH || out.len() as u64 >= MOST_DESIGNS {
        return None;
    }
    let taken = |chosen: &[usize], k: usize| chosen.iter().filter(|own| **own == k).count();
    let fits = |chosen: &[usize], k: usize| {
        prices.affords(till.spent + till.difference(prices, None, Some(k))) && taken(chosen, k) < problem.most_repeats
    };
    let count = problem.blocks.count();
    if chosen.len() >= problem.choose || !(0..count).any(|k| fits(chosen, k)) {
        let runs = chosen.chunk_by(|a, b| a == b).filter_map(|same| Some((*same.first()?, same.len())));
        out.push(runs.collect());
        return Some(());
    }
    // the first choice begins at the first candidate
    let first = chosen.last().copied().unwrap_or(0);
    for k in first..count {
        if fits(chosen, k) {
            let mut next = till.clone();
            next.change(prices, None, Some(k));
            chosen.push(k);
            grow(problem, &next, chosen, nodes, out)?;
            chosen.pop();
        }
    }
    Some(())
}
