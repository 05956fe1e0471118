//! A choice among plain rows, without benches: for other programs, and for tests against full enumeration.

use super::blocks::Blocks;
use super::bound::bound;
use super::problem::{Objective, Problem};
use super::request::Progress;
use super::search::{EFFORT, Found, Limits, search};

/// A choice among plain rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// Candidates, sorted, with repeats.
    pub chosen: Vec<usize>,
    /// The objective, by a fresh factorisation: `-log det M`, `tr(W M^-1)`, the largest `x' M^-1 x`, or the largest eigenvalue.
    pub value: f64,
    /// Starts that ended there.
    pub hits: usize,
    /// How many designs there are, where all were tried: none is better.
    pub enumerated: Option<u64>,
    /// What no choice can fall short of: the approximate design's bound.
    pub bound: Option<f64>,
    /// What weights instead of repeats reach; the bound is loose by no more than the difference.
    pub weights_reach: Option<f64>,
}

/// The best choice of `count` among plain blocks of rows, each at most `most_repeats` times. The bound costs more than one start, so it is found
/// only on request. `None` where no such choice determines the unknowns, or an objective has another number of unknowns.
///
/// ```
/// use tumble::plan::{Blocks, Objective, choose};
/// // a straight line on [-1, 1]: two readings at each end, det M = 4 * 4
/// let line = Blocks::from_fn(21, 1, 2, |j, _, c| if c == 0 { 1.0 } else { j as f64 / 10.0 - 1.0 });
/// let best = choose(&line, 4, usize::MAX, &Objective::Determinant, 1, 7, true).unwrap();
/// assert_eq!(best.chosen, [0, 0, 20, 20]);
/// assert!((best.value + 16f64.ln()).abs() < 1e-12 && (best.bound.unwrap() - best.value) > -1e-4);
/// ```
pub fn choose(
    blocks: &Blocks,
    count: usize,
    most_repeats: usize,
    objective: &Objective,
    starts: usize,
    seed: u64,
    with_bound: bool,
) -> Option<Choice> {
    let n = blocks.unknowns();
    let fits = match objective {
        Objective::Determinant => true,
        Objective::Trace(w) => w.len() == n * n,
        Objective::Largest(rows) => rows.unknowns() == n,
        Objective::Eigenvalue(combinations) => combinations.fits(n),
        Objective::Volume(volume) => volume.0.fits(n),
    };
    // without a row or an unknown nothing can be determined
    if !fits || n == 0 || blocks.rows() == 0 || blocks.count() == 0 {
        return None;
    }
    let base = vec![0.0; n * n];
    let problem =
        Problem { blocks, base: &base, objective, choose: count, most_repeats, neighbours: &[], prices: None };
    let bound = if with_bound { bound(blocks, &base, objective, count as f64) } else { None };
    let progress = Progress::default();
    let limits = Limits { starts, seed, effort: EFFORT, enough: None, given: &[], progress: &progress };
    let Found { design, hits, enumerated, .. } = search(&problem, &limits, bound.as_ref())?;
    Some(Choice {
        chosen: design.chosen,
        value: design.value,
        hits,
        enumerated,
        bound: bound.as_ref().map(|b| b.value),
        weights_reach: bound.map(|b| b.reached),
    })
}
