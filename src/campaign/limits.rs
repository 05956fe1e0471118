//! Limits that a quantity must keep, and the rule by which it is judged.

use crate::vocabulary::vocabulary;

vocabulary! {
    /// How conformity is decided (JCGM 106:2012, ISO/IEC 17025 7.8.6).
    #[derive(Default)]
    Decision {
        /// Simple acceptance: the value inside the limits, whatever its uncertainty (JCGM 106, 8.2).
        #[default]
        Simple = "simple",
        /// Guard band w = U: pass where the value is inside by U, fail where it is outside by U (JCGM 106, 8.3).
        GuardU = "guard-u",
        /// Specific risk: pass where the probability of conformity is at least the level, fail where it is at most one minus it (JCGM 106, 7).
        Risk = "risk",
    }
}

/// A quantity that limits apply to, by index.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limited {
    /// An estimated parameter.
    Parameter(usize),
    /// A derived quantity.
    Derived(usize),
}

/// Limits of one quantity, in its internal unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// The quantity.
    pub of: Limited,
    /// Lower limit, may be minus infinity.
    pub lower: f64,
    /// Upper limit, may be infinity.
    pub upper: f64,
}
