//! The conditions of a measurement result: whether the item was measured as found or as left, and the environment.

use super::decimal;
use super::texts::{Texts, Xml, of_type, text, told, within};
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

/// The conditions; names of the environment are the laboratory's own. Without any, that none are stated.
pub(super) fn write(
    xml: &mut Xml,
    identity: &Identity,
    adjusted: Option<Adjusted>,
    texts: Texts<'_>,
) -> io::Result<()> {
    within(xml, "dcc:influenceConditions", |xml| {
        if let Some(adjusted) = adjusted {
            within(xml, "dcc:influenceCondition", |xml| {
                told(xml, "dcc:name", texts, |lang| lang.title(say!(lang, "state")))?;
                text(xml, "dcc:status", adjusted.status())?;
                within(xml, "dcc:data", |xml| told(xml, "dcc:text", texts, |lang| adjusted.said(lang).into()))
            })?;
        } else if identity.environment.is_empty() {
            within(xml, "dcc:influenceCondition", |xml| {
                told(xml, "dcc:name", texts, |lang| say!(lang, "identity-environment").into())?;
                within(xml, "dcc:data", |xml| told(xml, "dcc:text", texts, |lang| say!(lang, "dcc-not-stated").into()))
            })?;
        }
        identity.environment.iter().try_for_each(|(name, condition)| {
            let ref_type = ref_type(name);
            of_type(xml, "dcc:influenceCondition", ref_type, |xml| {
                texts.own(xml, "dcc:name", name)?;
                within(xml, "dcc:data", |xml| {
                    // a number without a unit of D-SI is a text
                    let quantities = match (condition, unit_of(name)) {
                        (Condition::Number(value), Some(unit)) => vec![("", *value, None, unit)],
                        (Condition::Measured { value, u }, Some(unit)) => vec![("", *value, Some(*u), unit)],
                        (Condition::Range([low, high]), Some(unit)) => {
                            vec![("Min", *low, None, unit), ("Max", *high, None, unit)]
                        }
                        (condition, _) => return texts.own(xml, "dcc:text", &condition.to_string()),
                    };
                    quantities.into_iter().try_for_each(|(which, value, u, unit)| {
                        let ref_type = ref_type.map(|own| format!("{own}{which}"));
                        of_type(xml, "dcc:quantity", ref_type.as_deref(), |xml| {
                            texts.own(xml, "dcc:name", name)?;
                            within(xml, "si:real", |xml| {
                                text(xml, "si:value", &decimal(value))?;
                                text(xml, "si:unit", unit)?;
                                let Some(u) = u else { return Ok(()) };
                                within(xml, "si:measurementUncertaintyUnivariate", |xml| {
                                    within(xml, "si:standardMU", |xml| text(xml, "si:valueStandardMU", &decimal(u)))
                                })
                            })
                        })
                    })
                })
            })
        })
    })
}

/// The type of a condition in PTB's lists of good practice, by the quantity in its name.
fn ref_type(name: &str) -> Option<&'static str> {
    name.split('_').find_map(|word| match word.to_ascii_lowercase().as_str() {
        "temperature" => Some("basic_temperature"),
        "humidity" | "rh" => Some("basic_humidityRelative"),
        "pressure" => Some("basic_pressure"),
        _ => None,
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
