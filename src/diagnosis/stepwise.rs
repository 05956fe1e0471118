//! One effect after another, where no set explains the gap down to the noise.
//!
//! An effect is named if it is significant against noise and remainder together, plain above them, and its class of aliases far more
//! probable than every other explanation. What hides behind another effect is looked for in pairs and triples. At the end each member must
//! stand beside the others, in whatever order they were found.

use super::criteria::{Question, leaves_noise, without};
use super::evidence::Evidence;
use super::posterior;
use crate::elements::Elements;

/// Leaders that are tried as the first of a pair.
const FIRST: usize = 12;
/// Rounds of exchange.
const ROUNDS: usize = 4;

/// The set of effects that stand; from `start`, where all of that stands together, else from nothing.
pub(super) fn build(evidence: &Evidence, start: &[usize], question: &Question<'_>) -> Vec<usize> {
    let mut set: Vec<usize> = start.to_vec();
    if !set.is_empty() && !all_stand(evidence, &set, question) {
        set.clear();
    }
    // half of the degrees of freedom are left to the remainder
    let most = evidence.dof / 2;
    while set.len() < most {
        let Some(given) = evidence.given(&set) else { break };
        if !set.is_empty() && leaves_noise(evidence, &given, question.settings) {
            break;
        }
        let next = (1..=3.min(most - set.len())).find_map(|count| further(evidence, &set, count, question));
        let Some(next) = next else { break };
        let exchanged = exchange(evidence, &next, question);
        let stands = |set: &[usize]| all_stand(evidence, set, question);
        let longer = if stands(&exchanged) { exchanged } else { next };
        if longer.len() <= set.len() {
            break;
        }
        set = longer;
    }
    set
}

/// The set with so many further effects that all stand, if there is one.
fn further(evidence: &Evidence, set: &[usize], count: usize, question: &Question<'_>) -> Option<Vec<usize>> {
    let given = evidence.given(set)?;
    let size = |j: usize| given.score.get(j).map_or(0.0, |s| s.abs());
    let mut ranked: Vec<usize> = (0..evidence.pool.len()).filter(|j| size(*j) > 0.0).collect();
    ranked.sort_by(|a, b| size(*b).total_cmp(&size(*a)));
    let mut sets: Vec<(f64, Vec<usize>)> = Vec::new();
    // alone: the strongest, and the strongest plain one
    let plain = ranked.iter().find(|j| !question.is_doubtful(&[**j])).copied();
    let leaders: Vec<usize> = match count {
        1 => ranked.first().copied().into_iter().chain(plain.filter(|j| ranked.first() != Some(j))).collect(),
        _ => ranked.iter().take(FIRST).copied().collect(),
    };
    for first in &leaders {
        let mut longer: Vec<usize> = set.iter().copied().chain([*first]).collect();
        while longer.len() < set.len() + count {
            longer = extended(evidence, &longer)?;
        }
        for place in (set.len()..longer.len()).rev().filter(|_| count > 1) {
            let better =
                extended(evidence, &without(&longer, place)).filter(|b| evidence.rss_of(b) < evidence.rss_of(&longer));
            longer = better.unwrap_or(longer);
        }
        let mut sorted = longer.clone();
        sorted.sort_unstable();
        let rss = evidence.rss_of(&longer);
        let known = |(_, own): &(f64, Vec<usize>)| {
            let mut own = own.clone();
            own.sort_unstable();
            own == sorted
        };
        if rss.is_finite() && !sets.iter().any(known) {
            sets.push((rss, longer));
        }
    }
    sets.sort_by(|a, b| a.0.total_cmp(&b.0));
    let plain = |set: &Vec<usize>| most_plausible(evidence, set, question);
    sets.iter().take(2).map(|(_, set)| plain(set)).find(|set| all_stand(evidence, set, question))
}

/// Each member by the most plausible of those that fit alike in its place.
fn most_plausible(evidence: &Evidence, set: &[usize], question: &Question<'_>) -> Vec<usize> {
    let mut plain = set.to_vec();
    for place in 0..set.len() {
        let others = without(&plain, place);
        let Some(given) = evidence.given(&others) else { continue };
        let square = |j: usize| given.score.get(j).map_or(0.0, |s| s * s);
        let rss = evidence.rss_of(&plain);
        let variance = scale(evidence, rss, plain.len());
        // what only small tilts leave takes the place of nothing plain
        let is_plain = question.doubtful_yields && set.get(place).is_some_and(|own| !question.is_doubtful(&[*own]));
        let may = |j: &usize| !is_plain || !question.is_doubtful(&[*j]);
        let best = (0..evidence.pool.len()).filter(may).map(square).fold(0.0, f64::max);
        let near = (0..evidence.pool.len()).filter(|j| {
            !others.contains(j)
                && may(j)
                && square(*j) > 0.0
                && (best - square(*j)) / variance <= question.settings.indistinguishable
        });
        let order = |j: usize| (best - square(j)) / variance + question.burden(&[j]);
        let own = near.min_by(|a, b| order(*a).total_cmp(&order(*b)));
        if let (Some(slot), Some(own)) = (plain.get_mut(place), own) {
            *slot = own;
        }
    }
    plain
}

/// Variance of noise and remainder together, each reading by itself.
fn scale(evidence: &Evidence, rss: f64, members: usize) -> f64 {
    let left = rss / evidence.dof.saturating_sub(members).max(1) as f64;
    if evidence.from == super::noise::NoiseFrom::Stated { left.max(1.0) } else { left }
}

/// Another candidate in the place of a member, wherever that leaves less.
fn exchange(evidence: &Evidence, set: &[usize], question: &Question<'_>) -> Vec<usize> {
    let mut best = set.to_vec();
    for _ in 0..ROUNDS {
        let before = evidence.rss_of(&best);
        for place in 0..best.len() {
            let others = without(&best, place);
            let better =
                extended(evidence, &others).filter(|b| evidence.rss_of(b) < evidence.rss_of(&best) * (1.0 - 1e-9));
            best = better.unwrap_or(best);
        }
        if evidence.rss_of(&best) >= before * (1.0 - 1e-9) {
            break;
        }
    }
    most_plausible(evidence, &best, question)
}

/// Does every member stand beside the others?
fn all_stand(evidence: &Evidence, set: &[usize], question: &Question<'_>) -> bool {
    let complete = evidence.given(set).is_some_and(|given| leaves_noise(evidence, &given, question.settings));
    if (question.is_pattern)(set) {
        return false;
    }
    (0..set.len()).all(|place| stands(evidence, set, place, complete, question))
}

/// Does a member stand beside the others, against noise and remainder, and clearly ahead of every other explanation?
fn stands(evidence: &Evidence, set: &[usize], place: usize, complete: bool, question: &Question<'_>) -> bool {
    let settings = question.settings;
    let others = without(set, place);
    let (Some(member), Some(given)) = (set.get(place).copied(), evidence.given(&others)) else { return false };
    // one after another nothing is named that only small tilts leave: several of these build any pattern, and the fit of one moves the tilts far.
    // Nor is, beside an unexplained rest, what the others absorb but for a little
    let seen = evidence.pool.visible().at(member);
    let apart = given.left.get(member).map_or(0.0, |left| left.max(0.0).sqrt());
    if question.is_doubtful(&[member]) || (!complete && seen * apart < settings.absorbed) {
        return false;
    }
    let Some(standing) = evidence.standing(&others, member) else { return false };
    let score = given.score.get(member).map_or(0.0, |s| s.abs());
    let above = score / scale(evidence, evidence.rss_of(set), set.len()).sqrt();
    let needed = if complete { settings.each_of_many } else { settings.above_remainder };
    if above < needed {
        return false;
    }
    let level = if set.len() > 1 { settings.further * settings.names() } else { settings.names() };
    if evidence.family_wise(standing.t, standing.dof, member) > level {
        return false;
    }
    let posterior = posterior::of(evidence, &others, member, complete, question);
    posterior.probability >= settings.probability
}

/// A set with the candidate that takes off most beside it.
pub(super) fn extended(evidence: &Evidence, set: &[usize]) -> Option<Vec<usize>> {
    let given = evidence.given(set)?;
    let size = |j: usize| given.score.get(j).map_or(0.0, |s| s.abs());
    let best = (0..evidence.pool.len()).max_by(|a, b| size(*a).total_cmp(&size(*b)))?;
    (size(best) > 0.0).then(|| set.iter().copied().chain([best]).collect())
}
