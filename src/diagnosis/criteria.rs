//! What a search is asked, and when a set of effects is enough.

#[cfg(feature = "navigate")]
use super::evidence::Evidence;
#[cfg(feature = "navigate")]
use super::settings::Settings;
#[cfg(feature = "navigate")]
use crate::elements::Elements;

#[cfg(feature = "navigate")]
/// What a search is asked beside its evidence.
pub(super) struct Question<'a> {
    pub settings: &'a Settings,
    /// Of each candidate (in noise variances): decides among sets that fit alike.
    pub plausibility_penalty: &'a [f64],
    /// Is what is doubtful an alias at most of what is plain, however much better it fits? Terms that only small tilts leave are; what a plain
    /// effect must beat is not.
    pub doubtful_yields: bool,
    /// May several of these stand in one set? Members of a family that can build any pattern may not.
    pub is_pattern: &'a dyn Fn(&[usize]) -> bool,
}

#[cfg(feature = "navigate")]
impl Question<'_> {
    pub fn burden(&self, set: &[usize]) -> f64 {
        set.iter().map(|j| self.plausibility_penalty.at(*j)).sum()
    }

    /// Is a member of the set seen only through small tilts?
    pub fn is_doubtful(&self, set: &[usize]) -> bool {
        let small = self.settings.small_handicap();
        set.iter().any(|j| self.plausibility_penalty.get(*j).is_some_and(|h| *h >= small))
    }
}

#[cfg(feature = "navigate")]
/// Is no candidate significant, and the rest noise?
pub(super) fn leaves_noise(evidence: &Evidence, given: &super::strata::Given, settings: &Settings) -> bool {
    let global = evidence.global(given);
    evidence.strongest(given).is_none_or(|s| s.p > settings.further * settings.names())
        && global.is_none_or(|p| p > settings.whole())
}

#[cfg(feature = "navigate")]
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
