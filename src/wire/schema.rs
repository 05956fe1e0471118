//! JSON Schemas, generated from the wire types.

#[cfg(feature = "navigate")]
use super::MissionFile;
use super::{BenchFile, CampaignFile, EffectsFile, LabFile, TruthFile};
use serde_json::{Value, json};

/// The kinds of file that have a schema.
#[cfg(feature = "navigate")]
pub(crate) const SCHEMAS: &[&str] = &["bench", "campaign", "effects", "lab", "mission", "truth"];
/// The kinds of file that have a schema.
#[cfg(not(feature = "navigate"))]
pub(crate) const SCHEMAS: &[&str] = &["bench", "campaign", "effects", "lab", "truth"];

/// A schema under its identifier, `urn:tumble:KIND:VERSION`, with the version of the program whose files it describes.
pub(crate) fn identified(kind: &str, mut schema: Value) -> Value {
    if let Some(keys) = schema.as_object_mut() {
        keys.insert("$id".into(), format!("urn:tumble:{kind}:{}", env!("CARGO_PKG_VERSION")).into());
    }
    schema
}

/// The JSON Schema (draft 2020-12) of a kind of file, if there is such a kind.
///
/// ```
/// assert_eq!(tumble::wire::schema("bench").unwrap()["title"], "BenchFile");
/// ```
pub fn schema(kind: &str) -> Option<Value> {
    let schema = match kind {
        "bench" => schemars::schema_for!(BenchFile),
        "campaign" => schemars::schema_for!(CampaignFile),
        "lab" => schemars::schema_for!(LabFile),
        "effects" => schemars::schema_for!(EffectsFile),
        #[cfg(feature = "navigate")]
        "mission" => schemars::schema_for!(MissionFile),
        "truth" => schemars::schema_for!(TruthFile),
        _ => return None,
    };
    let mut schema = schema.to_value();
    if let Some(keys) = schema.get_mut("properties").and_then(Value::as_object_mut) {
        let about = |(key, says): (&str, &str)| (key.to_string(), json!({ "description": says, "type": "string" }));
        keys.extend(super::strict::ABOUT.map(about));
    }
    Some(identified(kind, schema))
}
