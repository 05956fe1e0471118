//! The search: first the smallest set of effects after which nothing but noise is left; where there is none, one effect after another, each
//! beyond doubt against the noise and what is still unexplained.
//!
//! One effect that explains everything beats two, two beat three, unless the larger set is far more probable at the price of its effects. A set
//! is complete if each member is significant given the others, no candidate is significant given the set, and the global test passes where the
//! noise is known. Sets of one and two are tried exhaustively, larger ones by forward selection and exchange.

use super::evidence::Evidence;
use super::noise::NoiseFrom;
use super::sets::{self, Rival};
use super::settings::Settings;
use super::stepwise;
use super::support::Support;
use crate::elements::Elements;

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
    pub plausibility_penalty: &'a [f64],
    /// What a set rests on; `None` where no position carries anything.
    pub support: Option<&'a Support<'a>>,
    /// May several of these stand in one set? Members of a family that can build any pattern may not.
    pub is_pattern: &'a dyn Fn(&[usize]) -> bool,
    /// May a candidate be named only where nothing is left unexplained?
    pub needs_all: &'a dyn Fn(usize) -> bool,
    /// The sine of a cosine that needs all, and the other way round.
    pub other_phase: &'a dyn Fn(usize) -> Option<usize>,
    /// All harmonics of its angle.
    pub harmonics_of: &'a dyn Fn(usize) -> Vec<usize>,
}

impl<'a> Question<'a> {
    /// For what has been found: probabilities ask for no families.
    pub fn without_families(
        settings: &'a Settings,
        plausibility_penalty: &'a [f64],
        support: Option<&'a Support<'a>>,
    ) -> Self {
        Question {
            settings,
            plausibility_penalty,
            support,
            is_pattern: &|_| false,
            needs_all: &|_| false,
            other_phase: &|_| None,
            harmonics_of: &|_| Vec::new(),
        }
    }

    pub fn burden(&self, set: &[usize]) -> f64 {
        set.iter().map(|j| self.plausibility_penalty.at(*j)).sum()
    }

    /// Is a member of the set seen only through small tilts?
    pub fn is_doubtful(&self, set: &[usize]) -> bool {
        let small = self.settings.small_handicap();
        set.iter().any(|j| self.plausibility_penalty.get(*j).is_some_and(|h| *h >= small))
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

/// Of the sets of one size that fit not significantly worse than the best: the most plausible complete one.
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

/// Twice the negative logarithm of a complete set's posterior probability, but for a constant: what it leaves, the price of each effect, and
/// how absurd it is. Where the noise is not stated it is estimated from what is left.
fn cost(evidence: &Evidence, set: &[usize], question: &Question<'_>) -> f64 {
    let price: f64 = set.iter().map(|j| price(evidence, *j, question.settings)).sum();
    misfit(evidence, set, evidence.rss_of(set)) + price + question.burden(set)
}

/// Twice the negative logarithm of the likelihood of a set that leaves this sum of squares, all of it noise, but for a constant; where
/// variances of what scatters are estimated, of the set on the straight model.
pub(super) fn misfit(evidence: &Evidence, set: &[usize], rss: f64) -> f64 {
    if let Some(gain) = evidence.gain(set) {
        return -gain;
    }
    match evidence.from {
        NoiseFrom::Stated => rss,
        _ => evidence.dof.saturating_sub(AT_ONCE).max(1) as f64 * rss.max(f64::MIN_POSITIVE).ln(),
    }
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
pub(super) fn leaves_noise(evidence: &Evidence, given: &super::strata::Given, settings: &Settings) -> bool {
    let global = evidence.global(given);
    evidence.strongest(given).is_none_or(|s| s.p > settings.further * settings.names())
        && global.is_none_or(|p| p > settings.whole())
}

/// For a set with members that can build any pattern: is the rest noise, and follows none of it their angles?
pub(super) fn leaves_nothing(evidence: &Evidence, set: &[usize], question: &Question<'_>) -> bool {
    let Some(given) = evidence.given(set) else { return false };
    leaves_noise(evidence, &given, question.settings) && leaves_no_pattern(evidence, set, question)
}

/// Follows nothing of what a set leaves the angles of its high harmonics: is the other phase of each absent, and are all other harmonics of
/// its angle together no more than noise, or than the rest where that is more?
pub(super) fn leaves_no_pattern(evidence: &Evidence, set: &[usize], question: &Question<'_>) -> bool {
    let settings = question.settings;
    let Some(given) = evidence.given(set) else { return false };
    let is_noise = leaves_noise(evidence, &given, settings);
    let high = || set.iter().copied().filter(|j| (question.needs_all)(*j));
    let scale = evidence.variance(&given).max(if is_noise { 0.0 } else { given.rss / given.dof.max(1) as f64 }).sqrt();
    let absent = |j: usize| {
        let score = given.score.at(j);
        let dof = if evidence.from == NoiseFrom::Stated && is_noise { f64::INFINITY } else { given.dof as f64 };
        evidence.alone(score / scale, dof) > settings.other_phase
    };
    let phases = high().filter_map(|j| (question.other_phase)(j)).filter(|j| !set.contains(j));
    phases.into_iter().all(absent)
        && high().all(|j| {
            let all = (question.harmonics_of)(j);
            evidence.together(set, &all, is_noise).is_none_or(|p| p > settings.whole_pattern)
        })
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
    // no count of its own: as one of all
    let tests = evidence.multiplicity.get(index).copied().unwrap_or(evidence.tests as f64).max(1.0);
    2.0 * settings.prior_size.ln() + 2.0 * tests.ln()
}

/// A set without the member at a place.
pub(super) fn without(set: &[usize], place: usize) -> Vec<usize> {
    set.iter().enumerate().filter(|(k, _)| *k != place).map(|(_, j)| *j).collect()
}
