//! A derived quantity in a campaign file: a line of algebra, or the line with the unit in which it is wanted.

use super::shapes::shapes;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

/// A derived quantity.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum DerivedFile {
    /// A line of algebra in the parameters; its unit follows from theirs.
    Line(String),
    /// A line, and the unit that its value is wanted in.
    InUnit(DerivedLine),
}

/// A line of algebra in the parameters with its unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DerivedLine {
    /// The line of algebra.
    pub line: String,
    /// The unit that its value is wanted in, for example `ppm`, `ug`, `arcsec`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
}

impl DerivedFile {
    /// The line, the path of the line below the quantity's own, and the unit.
    pub(super) fn parts(self) -> (String, &'static str, Option<String>) {
        match self {
            DerivedFile::Line(line) => (line, "", None),
            DerivedFile::InUnit(own) => (own.line, ".line", own.unit),
        }
    }
}

impl<'de> Deserialize<'de> for DerivedFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let shapes = shapes("a line of algebra, or { \"line\": ..., \"unit\": ... }");
        shapes.text(DerivedFile::Line).object(DerivedFile::InUnit).read(deserializer)
    }
}
