//! The search: first the smallest set of effects after which nothing but noise is left; where there is none, one effect after another, each
//! beyond doubt against the noise and what is still unexplained.
//!
//! One effect that explains everything beats two, two beat three. A set is complete if each member is significant given the others, no
//! candidate is significant given the set, and the global test passes where the noise is known. Sets of one and two are tried exhaustively,
//! larger ones by forward selection and exchange.

use super::evidence::Evidence;
use super::sets::{self, Rival};
use super::settings::Settings;
use super::stepwise;
use super::support::Support;

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

/// What a search is asked beside its evidence.
pub(super) struct Question<'a> {
    pub settings: &'a Settings,
    /// Of each candidate (in noise variances): decides among sets that fit alike.
    pub handicap: &'a [f64],
    pub support: &'a Support<'a>,
    /// May several of these stand in one set? Members of a family that can build any pattern may not.
    pub is_pattern: &'a dyn Fn(&[usize]) -> bool,
    /// May a candidate be named only where nothing is left unexplained?
    pub needs_all: &'a dyn Fn(usize) -> bool,
    /// The sine of a cosine that needs all, and the other way round.
    pub other_phase: &'a dyn Fn(usize) -> Option<usize>,
}

impl Question<'_> {
    pub fn burden(&self, set: &[usize]) -> f64 {
        set.iter().map(|j| self.handicap.get(*j).copied().unwrap_or_default()).sum()
    }

    /// Is a member of the set seen only through small tilts?
    pub fn is_doubtful(&self, set: &[usize]) -> bool {
        let small = self.settings.small_handicap();
        set.iter().any(|j| self.handicap.get(*j).is_some_and(|h| *h >= small))
    }
}

/// Most effects of a set that is searched for as a whole; more are found one after another.
const AT_ONCE: usize = 3;

/// Search one body of evidence.
pub(super) fn search(evidence: &Evidence, question: &Question<'_>) -> Found {
    let settings = question.settings;
    let Some(nothing) = evidence.given(&[]) else { return Found::Nothing };
    let strongest = evidence.strongest(&nothing);
    let global = evidence.global(&nothing);
    let hidden_pair = || {
        let pairs = if evidence.has_strata() { sets::pairs(evidence, settings.indistinguishable) } else { Vec::new() };
        evidence.hidden_pair(&pairs).is_some_and(|p| p <= settings.names())
    };
    let significant = strongest.is_some_and(|s| s.p <= settings.names()) || hidden_pair();
    if !significant && global.is_none_or(|p| p > settings.whole()) {
        return Found::Nothing;
    }
    let mut approximate: Vec<Vec<usize>> = Vec::new();
    let (mut tried, mut last_resort) = (Vec::new(), None);
    for size in 1..=AT_ONCE.min(evidence.dof.saturating_sub(1)) {
        tried = match size {
            1 => sets::singles(evidence),
            2 => sets::pairs(evidence, settings.indistinguishable),
            3 => {
                let mut sets = sets::triples(evidence, settings.indistinguishable, question.handicap);
                for own in sets::larger(evidence, &tried, size) {
                    if !sets.iter().any(|(_, set)| own.1.iter().all(|j| set.contains(j))) {
                        sets.push(own);
                    }
                }
                sets.sort_by(|a, b| a.0.total_cmp(&b.0));
                sets
            }
            _ => sets::larger(evidence, &tried, size),
        };
        let Some((best, leader)) = tried.first() else { break };
        if size <= 2 {
            approximate.push(leader.clone());
        }
        let Some(variance) = evidence.given(leader).map(|given| evidence.variance(&given)) else { break };
        let mut near: Vec<(f64, &Vec<usize>)> = tried
            .iter()
            .take_while(|(rss, _)| rss - best <= settings.indistinguishable * variance)
            .map(|(rss, set)| ((rss - best) / variance + question.burden(set), set))
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, set) in near.iter().take(40) {
            let stands = is_complete(evidence, set, question)
                && (size == 1 || (question.support.is_enough(evidence, set) && outweighs(evidence, set, settings)));
            let whole = !set.iter().any(|j| (question.needs_all)(*j)) || leaves_nothing(evidence, set, question);
            if stands && whole && !(question.is_pattern)(set) {
                let rivals = sets::rivals(evidence, set, &tried, *best, variance, settings.indistinguishable);
                let set = (*set).clone();
                let doubtful = question.is_doubtful(&set);
                let found = Found::Set { set, rivals, complete: true, nearest: Vec::new(), approximate: Vec::new() };
                if !doubtful {
                    return found;
                }
                // two plausible effects stand before one that would need an absurd coefficient
                last_resort = last_resort.or(Some(found));
                break;
            }
        }
        if size == 2 && last_resort.is_some() {
            break;
        }
    }
    if let Some(found) = last_resort {
        return found;
    }
    let set = stepwise::build(evidence, question);
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
        let nearest = tried.first().map_or_else(|| further(&[]), |(_, set)| set.clone());
        return Found::Unexplained { nearest, approximate };
    }
    let complete = is_complete(evidence, &set, question);
    let nearest = if complete { Vec::new() } else { further(&set) };
    let rivals = stepwise::rivals(evidence, &set, settings);
    Found::Set { set, rivals, complete, nearest, approximate }
}

/// Is each member significant given the others, no candidate given the set, and the rest noise?
pub(super) fn is_complete(evidence: &Evidence, set: &[usize], question: &Question<'_>) -> bool {
    let settings = question.settings;
    let Some(given) = evidence.given(set) else { return false };
    for (place, member) in set.iter().enumerate() {
        let others = without(set, place);
        let Some(rest) = evidence.given(&others) else { return false };
        let (t, dof) = evidence.t(&rest, *member);
        let needed = if set.len() > 1 { settings.further * settings.names() } else { settings.names() };
        if evidence.family_wise(t, dof, *member) > needed || (set.len() > 2 && t.abs() < settings.each_of_many) {
            return false;
        }
    }
    leaves_noise(evidence, &given, settings)
}

/// Is no candidate significant, and the rest noise?
pub(super) fn leaves_noise(evidence: &Evidence, given: &super::evidence::Given, settings: &Settings) -> bool {
    let global = evidence.global(given);
    evidence.strongest(given).is_none_or(|s| s.p > settings.further * settings.names())
        && global.is_none_or(|p| p > settings.whole())
}

/// For a set with members that can build any pattern: is the rest noise without any doubt, and the other phase of each harmonic absent?
pub(super) fn leaves_nothing(evidence: &Evidence, set: &[usize], question: &Question<'_>) -> bool {
    let settings = question.settings;
    let Some(given) = evidence.given(set) else { return false };
    let whole = evidence.global(&given).is_none_or(|p| p > settings.whole_pattern);
    let phases = set.iter().filter_map(|j| (question.other_phase)(*j)).filter(|j| !set.contains(j));
    let absent = |j: usize| {
        let (t, dof) = evidence.t(&given, j);
        evidence.alone(t, dof) > settings.other_phase
    };
    leaves_noise(evidence, &given, settings) && whole && phases.into_iter().all(absent)
}

/// Does a set of several effects outweigh an unknown remainder? Any pattern is approximated by enough columns; each has its price.
fn outweighs(evidence: &Evidence, set: &[usize], settings: &Settings) -> bool {
    let cost = |set: &[usize]| {
        let (directions, residual) = evidence.directions(set)?;
        let left = evidence.remainders.left(&directions, &residual, evidence.rss_of(set));
        let price: f64 = set.iter().map(|j| price(evidence, *j, settings)).sum();
        Some(left.deviance + price)
    };
    if evidence.has_strata() {
        // the remainder is what scatters
        let price: f64 = set.iter().map(|j| price(evidence, *j, settings)).sum();
        return evidence.gain(set).is_some_and(|gain| gain - price >= settings.outweighs);
    }
    match (cost(&[]), cost(set)) {
        (Some(nothing), Some(own)) => nothing - own >= settings.outweighs,
        _ => false,
    }
}

/// What a further effect costs in twice the logarithm of the odds: its Occam factor, and its share of all that was tried.
pub(super) fn price(evidence: &Evidence, index: usize, settings: &Settings) -> f64 {
    let tests = evidence.multiplicity.get(index).copied().unwrap_or(evidence.tests as f64).max(1.0);
    2.0 * settings.prior_size.ln() + 2.0 * tests.ln()
}

/// A set without the member at a place.
pub(super) fn without(set: &[usize], place: usize) -> Vec<usize> {
    set.iter().enumerate().filter(|(k, _)| *k != place).map(|(_, j)| *j).collect()
}
