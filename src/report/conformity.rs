//! Conformity: each limited quantity, its probability of conformity and the decision (JCGM 106).

use super::ARCSEC;
use super::table::{plain, rounded, significant};
use crate::campaign::Decision;
use crate::fit::{Conformity, Fit};
use crate::language::{Language, Sentence, say, sentence};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the limits of a campaign say about its results.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
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
#[non_exhaustive]
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
        .map(|own| {
            let scale = if own.is_angle { ARCSEC } else { 1.0 };
            let bound = |v: f64| Some(v * scale).filter(|bound| bound.is_finite());
            LimitedReport {
                lower: bound(own.limit.lower),
                upper: bound(own.limit.upper),
                value: own.value.map(|v| v * scale),
                expanded: own.uncertainty.map(|c| c.expanded * scale),
                probability: own.probability,
                outcome: own.outcome,
                unit: if own.is_angle { "arcsec".into() } else { own.unit },
                id: own.id,
            }
        })
        .collect();
    let percent = significant(100.0 * fit.settings.level, 3).trim_end_matches('0').trim_end_matches('.').to_string();
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

/// Conformity as a table for a terminal.
pub fn conformity_text(report: &ConformityReport, lang: Language) -> String {
    let rows: Vec<Vec<String>> = report
        .quantities
        .iter()
        .map(|q| {
            let number = |v: Option<f64>| v.map_or("-".to_string(), |v| significant(v, 6));
            vec![
                q.id.clone(),
                number(q.lower),
                q.value.map_or("-".into(), |v| rounded(v, q.expanded)),
                number(q.upper),
                q.expanded.map_or("-".into(), |u| significant(u, 3)),
                q.unit.clone(),
                q.probability.map_or("-".into(), percent),
                lang.term("outcome", &q.outcome.to_string()).into_owned(),
            ]
        })
        .collect();
    let table = plain(
        &[
            say!(lang, "conformity-2"),
            say!(lang, "lower"),
            say!(lang, "value"),
            say!(lang, "upper"),
            "U",
            say!(lang, "unit"),
            say!(lang, "probability"),
            say!(lang, "outcome"),
        ],
        &rows,
    );
    format!(
        "{table}{}\n",
        super::wrap::hanging(
            &say!(
                lang,
                "conformity-conformity",
                outcome = lang.term("outcome", &report.outcome.to_string()),
                rule = report.rule
            ),
            2
        )
    )
}

/// A probability in percent; neither 0 nor 1 where it is only near.
pub(super) fn percent(probability: f64) -> String {
    match 100.0 * probability {
        p if p >= 99.995 && probability < 1.0 => "> 99.99 %".into(),
        p if p < 0.005 && probability > 0.0 => "< 0.01 %".into(),
        p => format!("{p:.2} %"),
    }
}
