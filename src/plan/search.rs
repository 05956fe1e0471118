//! The search: all designs where there are few, else many starts of exchanges, until their number or the effort is spent.

use super::bound::Bound;
use super::budget;
use super::enumerate;
use super::exchange::{self};
use super::problem::{Design, Problem};
use super::request::Progress;
use super::request::Request;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use rayon::prelude::*;

/// The best design that was found.
#[derive(Debug, Clone)]
pub(super) struct Found {
    /// The design.
    pub design: Design,
    /// Starts that ended at its value.
    pub hits: usize,
    /// Starts that were made.
    pub starts: usize,
    /// Designs that were tried, where that was all of them: none is better.
    pub enumerated: Option<u64>,
}

/// How long to search.
#[derive(Debug, Clone)]
pub(super) struct Limits<'a> {
    /// Starts.
    pub starts: usize,
    /// Seed; the same gives the same design on any machine.
    pub seed: u64,
    /// Multiplications after which no further starts are made.
    pub effort: f64,
    /// A value of the objective that is good enough.
    pub enough: Option<f64>,
    /// Designs from which the search goes on besides.
    pub given: &'a [Vec<usize>],
    /// Told after every batch of starts.
    pub progress: &'a Progress,
}

impl<'a> Limits<'a> {
    /// Limits of one search of a request.
    pub fn of(request: &'a Request, given: &'a [Vec<usize>]) -> Self {
        // who asks for more starts than usual is ready to wait for them
        let patience = (request.starts as f64 / 100.0).clamp(1.0, 5.0);
        let Request { starts, seed, progress, .. } = request;
        Limits { starts: *starts, seed: *seed, effort: EFFORT * patience, enough: None, given, progress }
    }
}

/// Starts between looks at the effort.
const BATCH: usize = 8;
/// Multiplications after which no further starts are made: about a second.
pub(super) const EFFORT: f64 = 5e8;

/// The best of all designs, or of many starts. `guide`: the approximate design, whose weights some starts round. `None` where no design is
/// regular, or none was found.
pub(super) fn search(problem: &Problem<'_>, limits: &Limits<'_>, guide: Option<&Bound>) -> Option<Found> {
    if problem.neighbours.is_empty()
        && let Some((best, designs)) = enumerate::best(problem)
    {
        return best.map(|design| Found { design, hits: 1, starts: 1, enumerated: Some(designs) });
    }
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.abs().max(b.abs()).max(1e-300);
    let mut best: Option<(Design, usize)> = None;
    let keep = |best: &mut Option<(Design, usize)>, design: Design| match best {
        Some((known, hits)) if near(known.value, design.value) => *hits += 1,
        Some((known, _)) if known.value <= design.value => {}
        _ => *best = Some((design, 1)),
    };
    let starts = limits.starts.max(1);
    let (mut made, mut effort) = (0, 0.0);
    while made < starts && effort < limits.effort {
        let batch: Vec<usize> = (made..(made + BATCH).min(starts)).collect();
        made += batch.len();
        let designs: Vec<Option<Design>> = batch.into_par_iter().map(|k| one(problem, limits.seed, k, guide)).collect();
        for design in designs.into_iter().flatten() {
            effort += design.effort;
            keep(&mut best, design);
        }
        limits.progress.tell("starts", made, starts);
        // nothing can be better than the bound, and what is enough is enough
        let value = best.as_ref().map_or(f64::INFINITY, |(design, _)| design.value);
        if guide.is_some_and(|guide| value - guide.value <= 1e-9 * guide.value.abs())
            || limits.enough.is_some_and(|enough| value <= enough)
        {
            break;
        }
    }
    for given in limits.given.iter().filter(|given| fits(problem, given)) {
        let further = match problem.prices {
            Some(prices) => budget::descend(problem, prices, given.clone()),
            None => exchange::descend(problem, given.clone()),
        };
        for design in further.into_iter().chain(exchange::finished(problem, given.clone())) {
            keep(&mut best, design);
        }
    }
    best.map(|(mut design, hits)| {
        design.chosen.sort_unstable();
        Found { design, hits: hits.min(made), starts: made, enumerated: None }
    })
}

/// Is a design one of those that are asked for?
fn fits(problem: &Problem<'_>, given: &[usize]) -> bool {
    let mut sorted = given.to_vec();
    sorted.sort_unstable();
    let repeats = sorted.chunk_by(|a, b| a == b).all(|same| same.len() <= problem.most_repeats);
    repeats
        && match problem.prices {
            Some(prices) => prices.affords(prices.of(given)) && given.len() <= problem.choose,
            None => given.len() == problem.choose,
        }
}

fn one(problem: &Problem<'_>, seed: u64, k: usize, guide: Option<&Bound>) -> Option<Design> {
    let mut rng = Pcg64Mcg::seed_from_u64(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(k as u64));
    match problem.prices {
        Some(prices) => budget::start(problem, prices, &mut rng),
        None => exchange::start(problem, &mut rng, k, guide),
    }
}
