//! The conditions of a measurement result: whether the item was measured as found or as left, and the environment.

use super::{Xml, content, decimal, named, text, told, within};
use crate::campaign::{Condition, Identity};
use crate::language::{Language, say};
use std::io;

/// Was the item measured before or after it was adjusted?
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Adjusted {
    /// As found.
    Before,
    /// As left.
    After,
}

impl Adjusted {
    fn status(self) -> &'static str {
        match self {
            Adjusted::Before => "beforeAdjustment",
            Adjusted::After => "afterAdjustment",
        }
    }

    /// In words.
    pub(super) fn said(self, lang: Language) -> &'static str {
        match self {
            Adjusted::Before => say!(lang, "dcc-as-found"),
            Adjusted::After => say!(lang, "dcc-as-left"),
        }
    }
}

/// The conditions, where there are any; names of the environment are the laboratory's own.
pub(super) fn write(
    xml: &mut Xml,
    identity: &Identity,
    adjusted: Option<Adjusted>,
    language: &str,
    lang: Language,
) -> io::Result<()> {
    if identity.environment.is_empty() && adjusted.is_none() {
        return Ok(());
    }
    within(xml, "dcc:influenceConditions", |xml| {
        if let Some(adjusted) = adjusted {
            within(xml, "dcc:influenceCondition", |xml| {
                told(xml, "dcc:name", lang, |lang| say!(lang, "dcc-state-of-item").into())?;
                text(xml, "dcc:status", adjusted.status())?;
                within(xml, "dcc:data", |xml| told(xml, "dcc:text", lang, |lang| adjusted.said(lang).into()))
            })?;
        }
        identity.environment.iter().try_for_each(|(name, condition)| {
            within(xml, "dcc:influenceCondition", |xml| {
                named(xml, "dcc:name", name, language)?;
                within(xml, "dcc:data", |xml| match (condition, unit_of(name)) {
                    (Condition::Number(value), Some(unit)) => within(xml, "dcc:quantity", |xml| {
                        named(xml, "dcc:name", name, language)?;
                        within(xml, "si:real", |xml| {
                            text(xml, "si:value", &decimal(*value))?;
                            text(xml, "si:unit", unit)
                        })
                    }),
                    (Condition::Number(value), None) => {
                        within(xml, "dcc:text", |xml| content(xml, &value.to_string(), language))
                    }
                    (Condition::Text(words), _) => within(xml, "dcc:text", |xml| content(xml, words, language)),
                })
            })
        })
    })
}

/// The unit at the end of a condition's name, in the notation of D-SI.
fn unit_of(name: &str) -> Option<&'static str> {
    let end = name.rsplit('_').next()?.to_ascii_lowercase();
    Some(match end.as_str() {
        "c" | "degc" | "celsius" => "\\degreecelsius",
        "k" => "\\kelvin",
        "percent" | "rh" => "\\percent",
        "pa" => "\\pascal",
        "hpa" | "mbar" => "\\hecto\\pascal",
        "kpa" => "\\kilo\\pascal",
        "v" => "\\volt",
        "s" => "\\second",
        "h" => "\\hour",
        _ => return None,
    })
}
