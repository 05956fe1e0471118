//! What not knowing which explanation it is does to the parameters.
//!
//! ```text
//! x(S) = x - A+ C_S k,    k = (C_S'^T C_S')^-1 C_S'^T r        half-width_j = max over aliases |x_j(S with the alias) - x_j(S)|
//! ```
//!
//! Explanations fit the readings alike and yet move the parameters differently, by what the model absorbs of each. Each has its posterior
//! probability, and the variance of the parameters over them adds to their covariance (J. Hoeting, D. Madigan, A. Raftery, C. Volinsky: Bayesian
//! model averaging, Statistical Science 14 (1999), 382, eq. 3): `u^2 = u(S)^2 + sum_k P_k (x_k - x(S))^2`, about the value that is reported.

use super::candidates::Candidate;
use super::noise::Weighted;
use super::score::Score;
use crate::elements::Elements;
use crate::linear::Triangle;
use std::collections::HashMap;

/// What could stand in the place of a named effect.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rival {
    /// The named effect, by place.
    pub place: usize,
    /// The candidate that could stand there.
    pub candidate: usize,
    /// Its probability over that of the named effect.
    pub share: f64,
    /// How much worse it fits, in noise variances.
    pub excess: f64,
}

/// A set of effects with its probability: for each effect the candidates of its column, with their shares.
#[derive(Debug, Clone)]
pub(super) struct Explanation {
    pub probability: f64,
    pub members: Vec<Vec<(usize, f64)>>,
}

/// What effects do to the unknowns, computed once for each candidate.
pub(super) struct Shifts<'a> {
    candidates: &'a [Candidate],
    score: &'a Score,
    weighted: &'a Weighted,
    unknowns: usize,
    of: HashMap<usize, Option<Vec<f64>>>,
}

impl<'a> Shifts<'a> {
    pub fn new(candidates: &'a [Candidate], score: &'a Score, weighted: &'a Weighted) -> Self {
        let unknowns = weighted.estimate.unknowns.solution.len();
        Shifts { candidates, score, weighted, unknowns, of: HashMap::new() }
    }

    /// `-A+ c` for a column that the model leaves with norm one; `None` where it leaves next to nothing.
    fn unit(&mut self, index: usize) -> Option<Vec<f64>> {
        let (candidates, score, weighted) = (self.candidates, self.score, self.weighted);
        let computed = || {
            let candidate = candidates.get(index)?;
            let left = score.visible.get(index).copied()? * weighted.norm(&candidate.column);
            let absorbed = weighted.absorbed(&candidate.column).ok()?;
            let shift: Vec<f64> = absorbed.iter().map(|x| -x / left).collect();
            shift.iter().all(|x| x.is_finite()).then_some(shift)
        };
        self.of.entry(index).or_insert_with(computed).clone()
    }

    /// Mean and variance of the shift of every unknown by a set, each effect being one of the candidates of its column.
    fn of(&mut self, members: &[Vec<(usize, f64)>]) -> Option<(Vec<f64>, Vec<f64>)> {
        let first: Vec<usize> = members.iter().map(|of| of.first().map(|(j, _)| *j)).collect::<Option<_>>()?;
        let cosine = |a: usize, b: usize| self.score.cosines(a).at(b);
        let gram = |i: usize, k: usize| {
            if i == k { 1.0 } else { first.get(i).zip(first.get(k)).map_or(f64::NAN, |(a, b)| cosine(*a, *b)) }
        };
        let scores = first.iter().map(|j| self.score.along().get(*j).copied()).collect::<Option<Vec<f64>>>()?;
        // directions that differ by less than a thousandth are taken as one
        let sizes = Triangle::of(first.len(), gram, |_| 1e-6)?.solve(&scores);
        let (mut mean, mut variance) = (vec![0.0; self.unknowns], vec![0.0; self.unknowns]);
        for ((alternatives, first), size) in members.iter().zip(&first).zip(sizes) {
            let all: f64 = alternatives.iter().map(|(_, share)| share).sum();
            let (mut one, mut two) = (vec![0.0; self.unknowns], vec![0.0; self.unknowns]);
            for (j, share) in alternatives {
                let signed = size * self.score.cosines(*first).get(*j).map_or(1.0, |g| g.signum());
                let unit = self.unit(*j)?;
                for ((one, two), x) in one.iter_mut().zip(&mut two).zip(&unit) {
                    *one += share / all * signed * x;
                    *two += share / all * (signed * x) * (signed * x);
                }
            }
            for (((mean, variance), one), two) in mean.iter_mut().zip(&mut variance).zip(one).zip(two) {
                *mean += one;
                *variance += (two - one * one).max(0.0);
            }
        }
        Some((mean, variance))
    }

    /// For each unknown: the largest shift if a rival were the effect, and the standard deviation over all explanations with their probabilities.
    pub fn about(&mut self, set: &[usize], rivals: &[Rival], explanations: &[Explanation]) -> Vec<(f64, f64)> {
        let alone = |set: &[usize]| -> Vec<Vec<(usize, f64)>> { set.iter().map(|j| vec![(*j, 1.0)]).collect() };
        let mut moved_by = vec![(0.0_f64, 0.0_f64); self.unknowns];
        let Some((named, _)) = self.of(&alone(set)) else { return moved_by };
        for place in 0..set.len() {
            let mut widest = vec![0.0_f64; self.unknowns];
            // what only small tilts leave would need an absurd coefficient
            let plain = |rival: &&Rival| {
                rival.place == place && self.candidates.get(rival.candidate).is_some_and(|c| !c.vanishing)
            };
            let plain: Vec<usize> = rivals.iter().filter(plain).map(|rival| rival.candidate).collect();
            for candidate in plain {
                let mut other = set.to_vec();
                other.iter_mut().skip(place).take(1).for_each(|replaced| *replaced = candidate);
                let Some((moved, _)) = self.of(&alone(&other)) else { continue };
                widest.iter_mut().zip(moved.iter().zip(&named)).for_each(|(w, (a, b))| *w = w.max((a - b).abs()));
            }
            moved_by.iter_mut().zip(widest).for_each(|(by, w)| by.0 = by.0.hypot(w));
        }
        let mut all = 0.0;
        let mut square = vec![0.0; self.unknowns];
        for explanation in explanations {
            let Some((mean, variance)) = self.of(&explanation.members) else { continue };
            all += explanation.probability;
            for (slot, ((mean, variance), named)) in square.iter_mut().zip(mean.iter().zip(variance).zip(&named)) {
                *slot += explanation.probability * ((mean - named) * (mean - named) + variance);
            }
        }
        if all > 0.0 {
            moved_by.iter_mut().zip(square).for_each(|(by, square)| by.1 = (square / all).sqrt());
        }
        moved_by
    }
}
