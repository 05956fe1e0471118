//! JSON Schemas, generated from the wire types.

use super::{BenchFile, CampaignFile, EffectsFile, LabFile, MissionFile, TruthFile};
use serde_json::Value;

/// The kinds of file that have a schema.
pub const SCHEMAS: &[&str] = &["bench", "campaign", "effects", "lab", "mission", "truth"];

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
        "mission" => schemars::schema_for!(MissionFile),
        "truth" => schemars::schema_for!(TruthFile),
        _ => return None,
    };
    Some(schema.to_value())
}
