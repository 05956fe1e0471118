//! A line of `tumble guide --json -`.

use super::{ReportKind, VERSION};
use crate::guide::{Advice, Held};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A line of `tumble guide --json -`: what is said after each reading and each undone one, after a line that was refused, and while a position is held.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct GuideReport {
    /// Version of the program that wrote it.
    pub tumble: String,
    /// Always `guide`.
    #[schemars(extend("const" = "guide"))]
    pub report: ReportKind,
    /// Why the last line was refused: the advice is that of before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// The position that is held, where samples come: the advice is that of before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held: Option<Held>,
    /// The advice.
    #[serde(flatten)]
    pub advice: Advice,
}

/// The line of an advice; `error` says why a line was refused after it.
pub fn guide_report(advice: &Advice, error: Option<String>) -> GuideReport {
    GuideReport { tumble: VERSION.to_string(), report: ReportKind::Guide, error, held: None, advice: advice.clone() }
}
