//! What a campaign was made of, for reports and certificates: the unit under test, when, where, by whom, with what.

use crate::language::{Language, say};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// The identity of a campaign; everything in it is text for people, except the environment's numbers.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Identity {
    /// The unit under test.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<UnitUnderTest>,
    /// Date of the measurement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
    /// Place of the measurement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
    /// Who measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub operator: Option<String>,
    /// Instruments and their traceability.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub instruments: Vec<Instrument>,
    /// The procedure that was followed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub procedure: Option<String>,
    /// Conditions, for example `"temperature_c": 23.1`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub environment: BTreeMap<String, Condition>,
    /// A remark.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

/// The day, `YYYY-MM-DD`, that a text begins with.
pub fn day(text: &str) -> Option<&str> {
    let (day, after) = text.trim().split_at_checked(10)?;
    let date: jiff::civil::Date = day.parse().ok()?;
    (date.to_string() == day && date.year() > 0 && !after.starts_with(|c: char| c.is_ascii_digit())).then_some(day)
}

/// The unit under test.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UnitUnderTest {
    /// Serial number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub serial: Option<String>,
    /// Type or model.
    #[serde(default, rename = "type", skip_serializing_if = "Option::is_none")]
    pub kind: Option<String>,
    /// Manufacturer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub manufacturer: Option<String>,
}

/// An instrument.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Instrument {
    /// What it is.
    pub name: String,
    /// Number of its calibration certificate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub certificate: Option<String>,
    /// The day until which that is valid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub valid_to: Option<String>,
    /// What the certificate is traceable to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub traceable_to: Option<String>,
}

/// A condition of the environment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a number, { \"value\", \"u\" }, a range [lowest, highest] or a text")]
pub enum Condition {
    /// A number; the unit is the end of its name.
    Number(f64),
    /// A number with its standard uncertainty, both in that unit.
    Measured {
        /// The number, in the unit at the end of the condition's name.
        value: f64,
        /// Its standard uncertainty, in the same unit.
        u: f64,
    },
    /// The lowest and the highest number.
    Range([f64; 2]),
    /// A text.
    Text(String),
}

impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Condition::Number(value) => write!(f, "{value}"),
            Condition::Measured { value, u } => write!(f, "{value} (u {u})"),
            Condition::Range([low, high]) => write!(f, "{low} ... {high}"),
            Condition::Text(text) => f.write_str(text),
        }
    }
}

impl Identity {
    /// Is nothing stated?
    pub(crate) fn is_empty(&self) -> bool {
        *self == Identity::default()
    }

    /// Instruments whose certificate was no longer valid on the day of the measurement, with both days.
    pub(crate) fn expired(&self) -> impl Iterator<Item = (&Instrument, &str, &str)> {
        let date = self.date.as_deref().and_then(day);
        self.instruments.iter().filter_map(move |instrument| {
            let (valid_to, date) = (instrument.valid_to.as_deref().and_then(day)?, date?);
            (valid_to < date).then_some((instrument, valid_to, date))
        })
    }

    /// Name and text of everything that is stated, in the order of the fields.
    pub fn facts(&self, lang: Language) -> Vec<(String, String)> {
        let mut facts = Vec::new();
        let mut add = |name: &str, text: Option<String>| {
            if let Some(text) = text.filter(|text| !text.trim().is_empty()) {
                facts.push((name.to_string(), text));
            }
        };
        if let Some(unit) = &self.unit {
            let serial = unit.serial.as_ref().map(|serial| format!("{} {serial}", say!(lang, "serial")));
            let words: Vec<String> =
                [unit.manufacturer.clone(), unit.kind.clone(), serial].into_iter().flatten().collect();
            add(say!(lang, "identity-unit"), Some(words.join(lang.comma())));
        }
        add(&lang.title(say!(lang, "date")), self.date.clone());
        add(say!(lang, "identity-place"), self.place.clone());
        add(say!(lang, "identity-operator"), self.operator.clone());
        for instrument in &self.instruments {
            let with = |word: &str, text: &Option<String>| text.as_ref().map(|text| format!("{word} {text}"));
            let words: Vec<String> = [
                Some(instrument.name.clone()),
                with(say!(lang, "calibration-certificate"), &instrument.certificate),
                with(say!(lang, "identity-valid-to"), &instrument.valid_to),
                with(say!(lang, "identity-traceable-to"), &instrument.traceable_to),
            ]
            .into_iter()
            .flatten()
            .collect();
            add(say!(lang, "identity-instrument"), Some(words.join(lang.comma())));
        }
        add(say!(lang, "identity-procedure"), self.procedure.clone());
        let conditions: Vec<String> =
            self.environment.iter().map(|(name, condition)| format!("{name} {condition}")).collect();
        add(say!(lang, "identity-environment"), Some(conditions.join(lang.comma())));
        add(say!(lang, "note"), self.note.clone());
        facts
    }
}
