//! What not knowing which alias it is does to the parameters.
//!
//! ```text
//! x(S) = x - A+ C_S k,    k = (C_S'^T C_S')^-1 C_S'^T r        half-width_j = max over aliases |x_j(S with the alias) - x_j(S)|
//! ```
//!
//! Aliases fit the readings alike and yet move the parameters differently, by what the model absorbs of each. The correction is then known
//! only to lie between those of the aliases: a rectangular distribution, `u = half-width / sqrt 3` (GUM 4.3.7), on top of the covariance.

use super::arena::Arena;
use super::candidates::Candidate;
use super::linear::solve;
use super::noise::Weighted;
use super::search::Rival;

/// Half-width for each unknown, `n`: over the aliases of one finding the largest, over several findings the root sum of squares.
///
/// Aliases whose term is zero at these positions but for rounding or small tilts are left out: they would need an absurd coefficient.
pub(super) fn half_widths(
    candidates: &[Candidate],
    arena: &Arena,
    weighted: &Weighted,
    set: &[usize],
    rivals: &[Rival],
) -> Vec<f64> {
    let unknowns = weighted.estimate.solution.len();
    let Some(named) = moved(candidates, arena, weighted, set) else { return vec![0.0; unknowns] };
    let plausible = |j: usize| candidates.get(j).is_some_and(|c| !c.rounding && !c.vanishing);
    let mut squares = vec![0.0_f64; unknowns];
    for place in 0..set.len() {
        let mut widest = vec![0.0_f64; unknowns];
        for rival in rivals.iter().filter(|rival| rival.place == place && plausible(rival.candidate)) {
            let mut other = set.to_vec();
            if let Some(slot) = other.get_mut(place) {
                *slot = rival.candidate;
            }
            if let Some(together) = rival.together {
                // the pair counts once, at its first place
                if place > 0 || !plausible(together) {
                    continue;
                }
                other.iter_mut().skip(1).take(1).for_each(|slot| *slot = together);
            }
            let Some(moved) = moved(candidates, arena, weighted, &other) else { continue };
            for ((widest, here), named) in widest.iter_mut().zip(&moved).zip(&named) {
                *widest = widest.max((here - named).abs());
            }
        }
        squares.iter_mut().zip(widest).for_each(|(sum, width)| *sum += width * width);
    }
    squares.into_iter().map(f64::sqrt).collect()
}

/// What a set of effects does to the unknowns: `-A+ C_S k`.
fn moved(candidates: &[Candidate], arena: &Arena, weighted: &Weighted, set: &[usize]) -> Option<Vec<f64>> {
    let cosine = |a: usize, b: usize| arena.cosines.col_as_slice(a).get(b).copied().unwrap_or_default();
    if set.iter().any(|j| *j >= arena.cosines.ncols()) {
        return None;
    }
    let gram = faer::Mat::from_fn(set.len(), set.len(), |i, k| {
        set.get(i).zip(set.get(k)).map_or(0.0, |(a, b)| if i == k { 1.0 } else { cosine(*a, *b) })
    });
    let scores = set.iter().map(|j| arena.pool.scores().get(*j).copied()).collect::<Option<Vec<f64>>>()?;
    let sizes = solve(gram, scores)?;
    let mut moved = vec![0.0; weighted.estimate.solution.len()];
    for (member, size) in set.iter().zip(sizes) {
        let candidate = candidates.get(*member)?;
        let left = arena.pool.visible().get(*member).copied()? * norm(&candidate.column, &weighted.weight);
        let absorbed = weighted.estimate.factor.solve(&candidate.column).ok()?;
        moved.iter_mut().zip(absorbed).for_each(|(x, own)| *x -= own * (size / left));
    }
    moved.iter().all(|x| x.is_finite()).then_some(moved)
}

/// Weighted norm of a column, scaled first so that no square overflows.
fn norm(column: &[f64], weight: &[f64]) -> f64 {
    let largest = column.iter().fold(0.0_f64, |largest, v| largest.max(v.abs()));
    let scale = if largest > 0.0 { largest } else { 1.0 };
    column.iter().zip(weight).map(|(v, w)| (v / scale * w).powi(2)).sum::<f64>().sqrt() * scale
}
