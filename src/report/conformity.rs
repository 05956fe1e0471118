//! Conformity: each limited quantity, its probability of conformity and the decision (JCGM 106).

use super::ARCSEC;
use crate::campaign::Decision;
use crate::document::number::level_in_percent;
use crate::document::{Cell, Rows, Section, Tone};
use crate::fit::{Conformity, Fit};
use crate::language::{Language, Sentence, say, sentence};
use crate::number::as_stated;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the limits of a campaign say about its results.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ConformityReport {
    /// `simple`, `guard-u` or `risk`.
    pub decision: Decision,
    /// The rule in words.
    pub rule: Sentence,
    /// The worst outcome: `fail` before `undecided` before `pass`.
    pub outcome: Conformity,
    /// Each quantity.
    pub quantities: Vec<LimitedReport>,
}

/// A quantity and its limits, in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LimitedReport {
    /// Name.
    pub id: String,
    /// Unit of all its numbers: arcsec for angles.
    pub unit: String,
    /// Lower limit, in `unit`; null for none.
    pub lower: Option<f64>,
    /// Upper limit, in `unit`; null for none.
    pub upper: Option<f64>,
    /// Estimate, in `unit`; null where it is not estimable.
    pub value: Option<f64>,
    /// Expanded uncertainty, in `unit`.
    #[serde(rename = "U")]
    pub expanded: Option<f64>,
    /// Probability that the quantity is inside the limits, by Student's t about the estimate; null where no uncertainty is known.
    pub probability: Option<f64>,
    /// `pass`, `fail` or `undecided`.
    pub outcome: Conformity,
}

/// Judge the results of a fit by the limits of its campaign; `None` where there are none.
pub fn conformity(fit: &Fit) -> Option<ConformityReport> {
    let campaign = &fit.campaign;
    if campaign.limits.is_empty() {
        return None;
    }
    let quantities: Vec<LimitedReport> = fit
        .judged()
        .into_iter()
        .map(|quantity| {
            let scale = if quantity.is_angle { ARCSEC } else { 1.0 };
            let bound = |v: f64| Some(as_stated(v * scale)).filter(|bound| bound.is_finite());
            LimitedReport {
                lower: bound(quantity.limit.lower),
                upper: bound(quantity.limit.upper),
                value: quantity.value.map(|v| v * scale),
                expanded: quantity.uncertainty.map(|c| c.expanded * scale),
                probability: quantity.probability,
                outcome: quantity.outcome,
                unit: if quantity.is_angle { "arcsec".into() } else { quantity.unit },
                id: quantity.id,
            }
        })
        .collect();
    let percent = level_in_percent(fit.settings.level);
    let rule = match campaign.decision {
        Decision::Simple => sentence!("simple-acceptance-the-estimate-inside-the-limits"),
        Decision::GuardU => {
            sentence!("guard-band-w-u-pass-inside-by", percent)
        }
        Decision::Risk => {
            sentence!("specific-risk-pass-where-conformity-is-at", percent)
        }
    };
    Some(ConformityReport {
        decision: campaign.decision,
        rule,
        outcome: quantities.iter().map(|q| q.outcome).max().unwrap_or(Conformity::Pass),
        quantities,
    })
}

/// How the conformity of a report sounds, and the sentence.
pub(super) fn verdict(conformity: &ConformityReport, lang: Language) -> (Tone, String) {
    let rule = &conformity.rule;
    let tone = match conformity.outcome {
        Conformity::Pass => Tone::Good,
        Conformity::Fail => Tone::Bad,
        Conformity::Undecided => Tone::Caution,
    };
    (tone, say!(lang, "conformity-is", outcome = lang.term(conformity.outcome.name()), rule))
}

/// Conformity with the limits of the campaign; an empty section where it has none.
pub(super) fn section(report: Option<&ConformityReport>, lang: Language) -> Section {
    let table = Rows::of(report.iter().flat_map(|checked| &checked.quantities))
        .name(say!(lang, "quantity"), |q| &q.id)
        .decimal(say!(lang, "lower-limit"), |q| Cell::digits(q.lower, 6))
        .decimal(say!(lang, "value"), |q| Cell::value(q.value, q.expanded))
        .decimal(say!(lang, "upper-limit"), |q| Cell::digits(q.upper, 6))
        .decimal("U", |q| Cell::value(q.expanded, q.expanded))
        .left(say!(lang, "unit"), |q| &q.unit)
        .right(say!(lang, "probability"), |q| q.probability.map(percent))
        .left(say!(lang, "verdict"), |q| lang.term(q.outcome.name()))
        .tone(|q| match q.outcome {
            Conformity::Pass => Tone::Plain,
            Conformity::Undecided => Tone::Caution,
            Conformity::Fail => Tone::Bad,
        })
        .note(say!(lang, "probability-that-the-quantity-is-inside-its"));
    Section::new(say!(lang, "conformity")).table(table)
}

/// A probability in percent; neither 0 nor 1 where it is only near.
pub(super) fn percent(probability: f64) -> String {
    match 100.0 * probability {
        p if p >= 99.995 && probability < 1.0 => "> 99.99 %".into(),
        p if p < 0.005 && probability > 0.0 => "< 0.01 %".into(),
        p => format!("{p:.2} %"),
    }
}
