//! A derived quantity in a campaign file: a line of algebra, or the line with the unit in which it is wanted.

use schemars::JsonSchema;
use serde::de::{Deserializer, Error, MapAccess, Visitor, value};
use serde::{Deserialize, Serialize};
use std::fmt;

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

// By hand instead of untagged, so that a fault inside keeps its own line and path.
impl<'de> Deserialize<'de> for DerivedFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = DerivedFile;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a line of algebra, or { \"line\": ..., \"unit\": ... }")
            }
            fn visit_str<E: Error>(self, text: &str) -> Result<DerivedFile, E> {
                Ok(DerivedFile::Line(text.to_string()))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<DerivedFile, A::Error> {
                DerivedLine::deserialize(value::MapAccessDeserializer::new(map)).map(DerivedFile::InUnit)
            }
        }
        deserializer.deserialize_any(Either)
    }
}
