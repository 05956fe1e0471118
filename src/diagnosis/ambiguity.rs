//! What not knowing which alias it is does to the parameters.
//!
//! ```text
//! x(S) = x - A+ C_S k,    k = (C_S'^T C_S')^-1 C_S'^T r        half-width_j = max over aliases |x_j(S with the alias) - x_j(S)|
//! ```
//!
//! Aliases fit the readings alike and yet move the parameters differently, by what the model absorbs of each. Each has its probability, and the
//! variance of the parameters over them adds to their covariance (J. Hoeting, D. Madigan, A. Raftery, C. Volinsky: Bayesian model averaging,
//! Statistical Science 14 (1999), 382, eq. 3): `u^2 = u(S)^2 + sum_k P_k (x_k - x(S))^2`, about the value that is reported.

use super::candidate::Candidate;
use super::criteria::Question;
use super::evidence::Evidence;
use super::noise::Weighted;
use super::sets::Rival;
use crate::elements::Elements;
use crate::linear::Triangle;

/// Weight of each rival against the named member of its place, which has 1: `exp(-(excess + plausibility penalty - plausibility penalty of the member) / 2)`.
pub(super) fn shares(question: &Question<'_>, set: &[usize], rivals: &[Rival]) -> Vec<f64> {
    let share = |rival: &Rival| {
        let named = question.burden(set);
        let own = question.burden(&rival.replaced(set));
        // a rival that fits better by chance counts for no more than the named one
        (-0.5 * (rival.excess.max(0.0) + (own - named).max(0.0))).exp()
    };
    rivals.iter().map(share).collect()
}

/// For each unknown, `n`: the largest shift if a rival were the effect, and the standard deviation over all of them with their weights.
pub(super) fn moved_by(
    candidates: &[Candidate],
    evidence: &Evidence,
    weighted: &Weighted,
    set: &[usize],
    rivals: &[Rival],
    shares: &[f64],
) -> Vec<(f64, f64)> {
    let unknowns = weighted.estimate.unknowns.solution.len();
    let Some(named) = moved(candidates, evidence, weighted, set) else { return vec![(0.0, 0.0); unknowns] };
    let mut squares = vec![(0.0_f64, 0.0_f64); unknowns];
    for place in 0..set.len() {
        let mut own = vec![(0.0_f64, 0.0_f64); unknowns];
        let mut all = 1.0;
        for (rival, share) in rivals.iter().zip(shares).filter(|(rival, _)| rival.place == place) {
            // what only small tilts leave would need an absurd coefficient
            let small = |j: usize| candidates.get(j).is_none_or(|c| c.vanishing);
            // rivals of several members count once, at the first place
            if small(rival.candidate) || rival.with.iter().any(|j| small(*j)) || !rival.is_first() {
                continue;
            }
            let other = rival.replaced(set);
            let Some(moved) = moved(candidates, evidence, weighted, &other) else { continue };
            all += share;
            for ((own, here), named) in own.iter_mut().zip(&moved).zip(&named) {
                let shift = (here - named).abs();
                own.0 = own.0.max(shift);
                own.1 += share * shift * shift;
            }
        }
        for (sum, (widest, variance)) in squares.iter_mut().zip(own) {
            sum.0 += widest * widest;
            sum.1 += variance / all;
        }
    }
    squares.into_iter().map(|(widest, variance)| (widest.sqrt(), variance.sqrt())).collect()
}

/// What a set of effects does to the unknowns: `-A+ C_S k`.
fn moved(candidates: &[Candidate], evidence: &Evidence, weighted: &Weighted, set: &[usize]) -> Option<Vec<f64>> {
    let cosine = |a: usize, b: usize| evidence.cosines(a).at(b);
    let gram = |i: usize, k: usize| {
        set.get(i).zip(set.get(k)).map_or(f64::NAN, |(a, b)| if i == k { 1.0 } else { cosine(*a, *b) })
    };
    let scores = set.iter().map(|j| evidence.pool.scores().get(*j).copied()).collect::<Option<Vec<f64>>>()?;
    // directions of which less than a thousandth is their own are one
    let sizes = Triangle::of(set.len(), gram, |_| 1e-6)?.solve(&scores);
    let mut moved = vec![0.0; weighted.estimate.unknowns.solution.len()];
    for (member, size) in set.iter().zip(sizes) {
        let candidate = candidates.get(*member)?;
        let left = evidence.pool.visible().get(*member).copied()? * weighted.norm(&candidate.column);
        let absorbed = weighted.absorbed(&candidate.column).ok()?;
        moved.iter_mut().zip(absorbed).for_each(|(x, own)| *x -= own * (size / left));
    }
    moved.iter().all(|x| x.is_finite()).then_some(moved)
}
