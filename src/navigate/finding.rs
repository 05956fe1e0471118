//! What a diagnosis of navigation errors names, and what is unexplained.

use super::cause::Cause;
use super::errors::ErrorSource;
use super::motion::Motion;
use super::remainder;
use crate::diagnosis::Gap;

/// A motion that discriminates an error from some of its aliases.
#[derive(Debug, Clone, PartialEq)]
pub struct DiscriminatingMotion {
    /// The motion.
    pub motion: Motion,
    /// Aliases that it discriminates from the error, in their order.
    pub tells: Vec<ErrorSource>,
    /// By how many standard deviations at least.
    pub by: f64,
}

/// Another error that explains the same.
#[derive(Debug, Clone, PartialEq)]
pub struct Alias {
    /// The cause.
    pub source: Cause,
    /// The change that it would need, SI; `None` where it is not estimable.
    pub value: Option<f64>,
    /// The same column exactly, or only a fit that is not significantly worse?
    pub exact: bool,
    /// How much worse it fits, in variances of the noise.
    pub excess: f64,
    /// Would it need a size that no navigator's unit has?
    pub absurd: bool,
    /// A second error that must then stand in the place of another finding.
    pub together_with: Option<Cause>,
}

/// An error that the mission misses.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The cause.
    pub source: Cause,
    /// What the mission (or the reference, or the value) has to be changed by, SI.
    pub value: f64,
    /// Its standard uncertainty, SI.
    pub u: Option<f64>,
    /// Student's t (normal where the noise is stated), the other findings given.
    pub t: f64,
    /// Family-wise probability of evidence as strong by chance.
    pub p: f64,
    /// Probability that it, or a cause that cannot be distinguished from it, is present; `None` for random walks and single values.
    pub probability: Option<f64>,
    /// Share of the gap's sum of squares that it explains, the others given.
    pub explains: f64,
    /// What else it could be.
    pub aliases: Vec<Alias>,
    /// Motions that would discriminate, best first.
    pub separate_by: Vec<DiscriminatingMotion>,
}

/// What nothing explains.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "UnexplainedNavigationReport")]
#[non_exhaustive]
pub struct Unexplained {
    /// In one sentence.
    pub pattern: String,
    /// Mean gap by channel and part of a run, the most significant first.
    pub cells: Vec<remainder::Cell>,
    /// The errors that come nearest together; they are not accepted.
    pub nearest: Vec<String>,
    /// Share of the residual sum of squares that those would remove.
    pub nearest_explains: f64,
}

/// A single value that noise does not explain.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "NavigationSuspectReport")]
#[non_exhaustive]
pub struct Suspect {
    /// Name of the motion.
    pub motion: String,
    /// The column.
    pub column: String,
    /// Time, s.
    pub time_s: f64,
    /// What is left of it, in standard uncertainties.
    pub z: f64,
}

/// The gap with some of the causes that were found.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "NavigationGapStepReport")]
pub struct GapStep {
    /// The causes.
    pub with: Vec<String>,
    /// Single values that are left out.
    pub left_out: usize,
    /// The gap.
    pub gap: Gap,
}
