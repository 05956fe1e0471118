//! What a search is asked, and when a set of effects is enough.

use super::evidence::Evidence;
use super::noise::NoiseFrom;
use super::settings::Settings;
use super::support::Support;
use crate::elements::Elements;

/// Most effects of a set that is searched for as a whole; more are found one after another.
pub(super) const AT_ONCE: usize = 3;

/// What a search is asked beside its evidence.
pub(super) struct Question<'a> {
    pub settings: &'a Settings,
    /// Of each candidate (in noise variances): decides among sets that fit alike.
    pub plausibility_penalty: &'a [f64],
    /// Is what is doubtful an alias at most of what is plain, however much better it fits? Terms that only small tilts leave are; what a plain
    /// effect must beat is not.
    pub doubtful_yields: bool,
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
            doubtful_yields: true,
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

/// Twice the negative logarithm of a complete set's posterior probability, but for a constant: what it leaves, the price of each effect, and
/// how absurd it is. Where the noise is not stated it is estimated from what is left.
pub(super) fn cost(evidence: &Evidence, set: &[usize], question: &Question<'_>) -> f64 {
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

/// Follows nothing of what a set leaves the angles of its high harmonics: is the other phase of each absent? Where the rest is noise, all other
/// harmonics of its angle together must be no more than that. Beside an unexplained rest, which may be of any angle, a high harmonic of both
/// phases is a part of a pattern; one of a single phase, the other absent, is an effect.
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
    let mut phases = high().filter_map(|j| (question.other_phase)(j));
    phases.all(|j| if set.contains(&j) { is_noise } else { absent(j) })
        && (!is_noise
            || high().all(|j| {
                let all = (question.harmonics_of)(j);
                evidence.together(set, &all, is_noise).is_none_or(|p| p > settings.whole_pattern)
            }))
}

/// Does a set of several effects outweigh an unknown remainder? Any pattern is approximated by enough columns; each has its price.
pub(super) fn outweighs(evidence: &Evidence, set: &[usize], settings: &Settings) -> bool {
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
