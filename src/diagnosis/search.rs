//! The search: first the smallest set of effects after which nothing but noise is left; where there is none, one effect after another, each
//! beyond doubt against the noise and what is still unexplained.
//!
//! One effect that explains everything beats two, two beat three, unless the larger set is far more probable at the price of its effects. A set
//! is complete if each member is significant given the others, no candidate is significant given the set, and the global test passes where the
//! noise is known. Sets of one and two are tried exhaustively, larger ones by forward selection and exchange.

use super::criteria::{AT_ONCE, Question, cost, is_complete, leaves_nothing, outweighs};
use super::evidence::Evidence;
use super::sets::{self, Rival};
use super::stepwise;

/// What the search found.
#[derive(Debug, Clone)]
pub(super) enum Found {
    /// Nothing is missing.
    Nothing,
    /// A set, each set of the same size that fits not significantly worse, and what is not explained by it.
    Set { set: Vec<usize>, rivals: Vec<Rival>, complete: bool, nearest: Vec<usize>, approximate: Vec<Vec<usize>> },
    /// Something is missing and no set of candidates explains it; the best ones, which were not accepted.
    /// `approximate` are the best of one and of two.
    Unexplained { nearest: Vec<usize>, approximate: Vec<Vec<usize>> },
}

/// Search one body of evidence.
pub(super) fn search(evidence: &Evidence, question: &Question<'_>) -> Found {
    let settings = question.settings;
    let Some(nothing) = evidence.given(&[]) else { return Found::Nothing };
    let strongest = evidence.strongest(&nothing);
    let global = evidence.global(&nothing);
    // two effects are as much less likely by chance than one as any further one
    let hidden_pair = || {
        let pairs = sets::pairs(evidence, settings.indistinguishable);
        evidence.hidden_pair(&pairs).is_some_and(|p| p <= settings.further * settings.names())
    };
    let significant = strongest.is_some_and(|s| s.p <= settings.names()) || hidden_pair();
    if !significant && global.is_none_or(|p| p > settings.whole()) {
        return Found::Nothing;
    }
    let mut approximate: Vec<Vec<usize>> = Vec::new();
    let mut tried: Vec<Vec<(f64, Vec<usize>)>> = Vec::new();
    let mut best: Option<Vec<usize>> = None;
    for size in 1..=AT_ONCE.min(evidence.dof.saturating_sub(1)) {
        // nothing smaller before the first size
        let smaller = tried.last().map(Vec::as_slice).unwrap_or_default();
        let sets = match size {
            1 => sets::singles(evidence),
            2 => sets::pairs(evidence, settings.indistinguishable),
            _ => {
                let mut sets = sets::triples(evidence, settings.indistinguishable, question.plausibility_penalty);
                for own in sets::larger(evidence, smaller, size) {
                    if !sets.iter().any(|(_, set)| own.1.iter().all(|j| set.contains(j))) {
                        sets.push(own);
                    }
                }
                sets.sort_by(|a, b| a.0.total_cmp(&b.0));
                sets
            }
        };
        let Some((_, leader)) = sets.first() else { break };
        if size <= 2 {
            approximate.push(leader.clone());
        }
        if let Some(set) = leading(evidence, &sets, question) {
            // a further effect must outweigh its price, but two plausible effects stand before one that would need an absurd coefficient
            let replaces = best.as_ref().is_none_or(|before| {
                cost(evidence, before, question) - cost(evidence, &set, question) >= settings.outweighs
                    || (size == 2 && question.is_doubtful(before) && !question.is_doubtful(&set))
            });
            if replaces {
                best = Some(set);
            }
        }
        tried.push(sets);
    }
    if let Some(set) = best {
        let rivals = rivals(evidence, &set, &tried, question);
        return Found::Set { set, rivals, complete: true, nearest: Vec::new(), approximate: Vec::new() };
    }
    let set = stepwise::build(evidence, &[], question);
    let further = |set: &[usize]| {
        let mut longer = set.to_vec();
        while longer.len() < set.len() + AT_ONCE {
            match sets::extended(evidence, &longer) {
                Some(next) => longer = next,
                None => break,
            }
        }
        longer.split_off(set.len())
    };
    if set.is_empty() {
        let nearest = tried.last().and_then(|sets| sets.first()).map_or_else(|| further(&[]), |(_, set)| set.clone());
        return Found::Unexplained { nearest, approximate };
    }
    let complete = is_complete(evidence, &set, question);
    let nearest = if complete { Vec::new() } else { further(&set) };
    let rivals = match complete {
        true => rivals(evidence, &set, &tried, question),
        false => stepwise::rivals(evidence, &set, settings),
    };
    Found::Set { set, rivals, complete, nearest, approximate }
}

/// Of the sets of one size that fit not significantly worse than the best: the most plausible complete one. Two members that only small tilts leave
/// build too much together.
fn leading(evidence: &Evidence, sets: &[(f64, Vec<usize>)], question: &Question<'_>) -> Option<Vec<usize>> {
    let settings = question.settings;
    let (best, leader) = sets.first()?;
    let variance = evidence.given(leader).map(|given| evidence.variance(&given))?;
    let mut near: Vec<(f64, &Vec<usize>)> = sets
        .iter()
        .take_while(|(rss, _)| rss - best <= settings.indistinguishable * variance)
        .map(|(rss, set)| ((rss - best) / variance + question.burden(set), set))
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    let stands = |set: &[usize]| {
        is_complete(evidence, set, question)
            && (set.len() == 1
                || (question.support.is_none_or(|own| own.is_enough(evidence, set))
                    && outweighs(evidence, set, settings)))
            && (!set.iter().any(|j| (question.needs_all)(*j)) || leaves_nothing(evidence, set, question))
            && !(question.is_pattern)(set)
            && set.iter().filter(|j| question.is_doubtful(&[**j])).count() < 2
    };
    near.into_iter().take(EXAMINED).map(|(_, set)| set).find(|set| stands(set)).cloned()
}

/// Sets of one size that are examined closely.
const EXAMINED: usize = 40;

/// What could stand in the place of members: sets of the same size that fit not significantly worse, and sets of one effect more, complete
/// themselves, that are not much less probable.
fn rivals(evidence: &Evidence, set: &[usize], tried: &[Vec<(f64, Vec<usize>)>], question: &Question<'_>) -> Vec<Rival> {
    let limit = question.settings.indistinguishable;
    // the empty set has no rivals of its size
    let same = set.len().checked_sub(1).and_then(|k| tried.get(k)).map(Vec::as_slice).unwrap_or_default();
    let own = evidence.rss_of(set);
    let best = same.first().map_or(own, |(rss, _)| rss.min(own));
    let Some(variance) = evidence.given(set).map(|given| evidence.variance(&given)) else { return Vec::new() };
    let mut rivals = sets::rivals(evidence, set, same, best, variance, limit);
    let base = cost(evidence, set, question);
    // none where the search ended at this size
    let longer = tried.get(set.len()).map(Vec::as_slice).unwrap_or_default();
    for (_, other) in longer.iter().take(EXAMINED) {
        let excess = cost(evidence, other, question) - base - question.burden(other) + question.burden(set);
        // a part of it is explained by the set, and what would need an absurd coefficient stands before nothing
        let nested = set.iter().all(|j| other.contains(j));
        let absurd = question.is_doubtful(other) && !question.is_doubtful(set);
        if !nested
            && !absurd
            && excess <= limit
            && is_complete(evidence, other, question)
            && !(question.is_pattern)(other)
        {
            sets::add(evidence, set, other, excess, &mut rivals);
        }
    }
    rivals.sort_by(|a, b| a.place.cmp(&b.place).then(a.excess.total_cmp(&b.excess)));
    rivals
}
