//! How far measured and predicted navigation errors are apart, cause by cause.

use crate::diagnosis::Gap;

/// The gap with some of the causes that were found.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "NavigationGapStepReport")]
#[non_exhaustive]
pub struct GapStep {
    /// The causes.
    pub with: Vec<String>,
    /// Single values that are left out.
    pub left_out: usize,
    /// The gap.
    pub gap: Gap,
}
