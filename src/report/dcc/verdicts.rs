//! Conformity with limits, beside the quantity that it is about.

use super::texts::{Texts, Xml, of_type, text, told, within};
use super::{decimal, units};
use crate::fit::Conformity;
use crate::language::{Language, say};
use crate::report::conformity::{ConformityReport, LimitedReport, percent};
use std::io;

/// The conformity of a quantity as its metadata; nothing where it has no limits.
pub(super) fn of_quantity(
    xml: &mut Xml,
    conformity: Option<&ConformityReport>,
    id: &str,
    texts: Texts<'_>,
) -> io::Result<()> {
    let found = conformity.and_then(|own| Some((own, own.quantities.iter().find(|q| q.id == id)?)));
    let Some((conformity, limited)) = found else { return Ok(()) };
    within(xml, "dcc:measurementMetaData", |xml| {
        of_type(xml, "dcc:metaData", Some("basic_conformity"), |xml| {
            told(xml, "dcc:declaration", texts, |lang| declaration(conformity, limited, lang))?;
            text(xml, "dcc:conformity", status(limited))?;
            within(xml, "dcc:data", |xml| {
                for (limit, lower) in [(limited.lower, true), (limited.upper, false)] {
                    let Some(limit) = limit else { continue };
                    within(xml, "dcc:quantity", |xml| {
                        told(xml, "dcc:name", texts, |lang| {
                            if lower { say!(lang, "lower-limit") } else { say!(lang, "upper-limit") }.into()
                        })?;
                        within(xml, "si:real", |xml| {
                            text(xml, "si:value", &decimal(limit))?;
                            text(xml, "si:unit", &units::d_si(&[&limited.unit]))
                        })
                    })?;
                }
                Ok(())
            })
        })
    })
}

/// The outcome in words, with the rule and the probability that it rests on.
fn declaration(conformity: &ConformityReport, limited: &LimitedReport, lang: Language) -> String {
    let outcome = lang.term(limited.outcome.name());
    let mut said = say!(lang, "conformity-is", outcome, rule = conformity.rule);
    if let Some(probability) = limited.probability {
        said.push_str(lang.space());
        let probability = format!("{}{}{}", say!(lang, "probability"), lang.colon(), percent(probability));
        said.push_str(&lang.sentence(&lang.title(&probability)));
    }
    said
}

/// The schema's word: an undecided quantity is a conditional pass where its estimate is inside the limits, else a conditional fail.
fn status(limited: &LimitedReport) -> &'static str {
    let inside = limited.value.is_some_and(|value| {
        limited.lower.is_none_or(|low| value >= low) && limited.upper.is_none_or(|high| value <= high)
    });
    match (limited.outcome, inside) {
        (Conformity::Pass, _) => "pass",
        (Conformity::Fail, _) => "fail",
        (Conformity::Undecided, true) => "conditionalPass",
        (Conformity::Undecided, false) => "conditionalFail",
    }
}
