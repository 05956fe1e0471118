//! Kinds of files: their JSON Schemas, generated from the wire types; and what a file is that should have been a campaign.

#[cfg(feature = "navigate")]
use super::MissionFile;
use super::{BenchFile, CampaignFile, EffectsFile, LabFile, Source, TruthFile, line_and_column, parse};
use crate::error::{Fault, Malformed};
use serde_json::{Value, json};

/// The kinds of file that have a schema.
pub(crate) const SCHEMAS: &[(&str, fn() -> schemars::Schema)] = &[
    ("bench", || schemars::schema_for!(BenchFile)),
    ("campaign", || schemars::schema_for!(CampaignFile)),
    ("effects", || schemars::schema_for!(EffectsFile)),
    ("lab", || schemars::schema_for!(LabFile)),
    #[cfg(feature = "navigate")]
    ("mission", || schemars::schema_for!(MissionFile)),
    ("truth", || schemars::schema_for!(TruthFile)),
];

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
    let (_, of) = SCHEMAS.iter().find(|(other, _)| *other == kind)?;
    let mut schema = of().to_value();
    if let Some(keys) = schema.get_mut("properties").and_then(Value::as_object_mut) {
        let about = |(key, says): (&str, &str)| (key.to_string(), json!({ "description": says, "type": "string" }));
        keys.extend(super::strict::ABOUT.map(about));
    }
    Some(identified(kind, schema))
}

/// Most characters of a first line that are quoted.
const QUOTED: usize = 40;

/// The error for a text that is no campaign at all; `None` where it may be meant as one.
pub(super) fn no_campaign(source: &Source) -> Option<Malformed> {
    let error = Malformed::new(Fault::Syntax, "this is not a campaign file").expected("a campaign file (JSON)");
    let start = source.text.len() - source.text.trim_start().len();
    let first = source.text.get(start..)?.lines().next()?.trim_end();
    if first.starts_with('{') {
        return Some(error.found(looks_like(source)?).in_file(&source.name));
    }
    let quoted: String = first.chars().take(QUOTED).collect();
    let more = if first.chars().count() > QUOTED { "..." } else { "" };
    let (line, column) = line_and_column(&source.text, start);
    let error = error.found(format!("a text that begins with '{quoted}{more}'"));
    Some(error.in_file(&source.name).at_span(start, first.len()).at_line(line, column))
}

/// The kind of a JSON file of this program, other than a campaign.
fn looks_like(source: &Source) -> Option<String> {
    let value: Value = serde_json::from_str(&source.text).ok()?;
    let keys = value.as_object().filter(|keys| !keys.is_empty())?;
    if let (Some(report), Some(_)) = (keys.get("report").and_then(Value::as_str), keys.get("tumble")) {
        return Some(format!("a report of `tumble {}`", report.chars().take(QUOTED).collect::<String>()));
    }
    let kinds = [
        ("a truth file", parse::<TruthFile>(source).is_ok()),
        ("a catalogue of effects", parse::<EffectsFile>(source).is_ok()),
        ("a bench file (its name should end in .bench.json)", parse::<BenchFile>(source).is_ok()),
        #[cfg(feature = "navigate")]
        ("a mission file (its name should end in .mission.json)", parse::<MissionFile>(source).is_ok()),
        ("a file of a laboratory's identities", parse::<LabFile>(source).is_ok()),
    ];
    kinds.into_iter().find(|(_, is)| *is).map(|(kind, _)| format!("what looks like {kind}"))
}
