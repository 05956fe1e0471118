//! Posterior probabilities: of an effect or one of its aliases, and of each alias.
//!
//! ```text
//! P(k | readings) ~ exp(-(deviance_k + price_k + handicap_k) / 2)      over all candidates for one place, and over none of them
//! ```
//!
//! The deviance is that of the restricted likelihood with the remainder estimated anew for each candidate; the price is the Occam factor and
//! the share of all that was tried (see `Settings`). Candidates compete for one place beside the other members of a set; a candidate that does
//! not resemble the member may also stand beside it, and the two together count for the member (inclusion probability: M. Barbieri, J. Berger,
//! Annals of Statistics 32 (2004), 870).

use super::criteria::{Question, price};
use super::evidence::Evidence;

/// Candidates whose deviance is computed; the others are too far behind to count.
const COMPARED: usize = 48;
/// Odds against the member from which a candidate is also tried beside it.
const COUNTS: f64 = 1e-3;

/// What could stand in one place.
#[derive(Debug, Clone, Default)]
pub(super) struct Posterior {
    /// That the member, or one that the readings cannot tell from it, is there.
    pub probability: f64,
}

/// For the place of `member` beside the others; `whole` where the rest is noise, which has no remainder.
pub(super) fn of(
    evidence: &Evidence,
    others: &[usize],
    member: usize,
    whole: bool,
    question: &Question<'_>,
) -> Posterior {
    let settings = question.settings;
    let own = || {
        let given = evidence.given(others)?;
        let (directions, residual) = evidence.directions(others)?;
        let rss = evidence.rss_of(others);
        let (first, _) = evidence.further(&directions, member)?;
        // of what stands, with one direction more
        let deviance = |beside: &[Vec<f64>], direction: Vec<f64>, grouping: Option<Option<usize>>| {
            let mut all = beside.to_vec();
            all.push(direction);
            let (mut left, mut rest) = (residual.clone(), rss);
            for direction in all.iter().skip(directions.len()) {
                let score: f64 = direction.iter().zip(&left).map(|(d, r)| d * r).sum();
                left.iter_mut().zip(direction).for_each(|(r, d)| *r -= score * d);
                rest = (rest - score * score).max(0.0);
            }
            match grouping {
                _ if whole => evidence.remainders.left_by(None, &all, &left, rest),
                None => evidence.remainders.left(&all, &left, rest),
                Some(grouping) => evidence.remainders.left_by(grouping, &all, &left, rest),
            }
        };
        let leading = deviance(&directions, first.clone(), None);
        let nothing = match whole {
            true => evidence.remainders.left_by(None, &directions, &residual, rss),
            false => evidence.remainders.left(&directions, &residual, rss),
        };
        // without an effect all of the gap is a pattern that has no name
        let unnamed = if nothing.grouping.is_some() { settings.in_catalogue } else { 0.0 };
        let none = nothing.deviance + unnamed
            - leading.deviance
            - price(evidence, member, settings)
            - question.burden(&[member]);
        let size = |j: usize| given.score.get(j).map_or(0.0, |s| s.abs());
        let mut ranked: Vec<usize> =
            (0..evidence.pool.len()).filter(|j| *j != member && size(*j) > 0.0 && !others.contains(j)).collect();
        ranked.sort_by(|a, b| size(*b).total_cmp(&size(*a)));
        let mut weights = vec![(member, 1.0, 1.0)];
        let mut together = 0.0;
        let base = price(evidence, member, settings) + question.burden(&[member]);
        for j in ranked.into_iter().take(COMPARED) {
            let Some((direction, _)) = evidence.further(&directions, j) else { continue };
            let cosine: f64 = direction.iter().zip(&first).map(|(a, b)| a * b).sum::<f64>().abs();
            let own = match 1.0 - cosine < 1e-9 {
                true => leading,
                false => deviance(&directions, direction.clone(), Some(leading.grouping)),
            };
            let mut further = own.deviance - leading.deviance;
            // what only small tilts leave never stands before a plain term
            if question.is_doubtful(&[j]) && !question.is_doubtful(&[member]) {
                further = further.max(0.0);
            }
            let behind = further + price(evidence, j, settings) + question.burden(&[j]) - base;
            let weight = (-0.5 * behind).exp();
            // another effect in its place may be there beside it: then it is no argument against it
            if cosine < settings.alias_cosine && weight > COUNTS {
                let beside: Vec<Vec<f64>> = directions.iter().cloned().chain([direction]).collect();
                if let Some((own, _)) = evidence.further(&beside, member) {
                    let both = deviance(&beside, own, Some(leading.grouping)).deviance - leading.deviance;
                    together += (-0.5 * (both + price(evidence, j, settings) + question.burden(&[j]))).exp();
                }
            }
            weights.push((j, weight, cosine));
        }
        let all: f64 = weights.iter().map(|(_, w, _)| w).sum::<f64>() + (-0.5 * none).exp() + together;
        let class = weights.iter().filter(|(_, _, cosine)| *cosine >= settings.alias_cosine);
        let probability = (class.map(|(_, w, _)| w).sum::<f64>() + together) / all;
        Some(Posterior { probability: if probability.is_finite() { probability } else { 0.0 } })
    };
    // a probability of zero: dependent columns give no support
    own().unwrap_or_default()
}
