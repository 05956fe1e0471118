//! Conformity: each limited quantity, its probability of conformity and the decision (JCGM 106).

use super::ARCSEC;
use super::table::{plain, rounded, significant};
use crate::campaign::{Decision, Limited};
use crate::fit::Fit;
use crate::uncertainty::Combined;
use crate::uncertainty::quantiles::student_t_cdf;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the limits of a campaign say about its results.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ConformityReport {
    /// `simple`, `guard-u` or `risk`.
    pub decision: String,
    /// The rule in words.
    pub rule: String,
    /// The worst outcome: `fail` before `undecided` before `pass`.
    pub outcome: String,
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
    /// Lower limit; null for none.
    pub lower: Option<f64>,
    /// Upper limit; null for none.
    pub upper: Option<f64>,
    /// Estimate; null where it is not estimable.
    pub value: Option<f64>,
    /// Expanded uncertainty.
    #[serde(rename = "U")]
    pub expanded: Option<f64>,
    /// Probability that the quantity is inside the limits, by Student's t about the estimate; null where no uncertainty is known.
    pub probability: Option<f64>,
    /// `pass`, `fail` or `undecided`.
    pub outcome: String,
}

/// Judge the results of a fit by the limits of its campaign; `None` where there are none.
pub fn conformity(fit: &Fit) -> Option<ConformityReport> {
    let campaign = &fit.campaign;
    if campaign.limits.is_empty() {
        return None;
    }
    let mut quantities = Vec::new();
    for limit in &campaign.limits {
        let (id, unit, is_angle, value, uncertainty) = match limit.of {
            Limited::Parameter(k) => {
                let Some(p) = fit.parameters.get(k) else { continue };
                (&p.id, &p.unit, p.kind == crate::campaign::Kind::Tilt, p.value, p.uncertainty)
            }
            Limited::Derived(k) => {
                let (Some(d), Some(own)) = (fit.derived.get(k), campaign.derived.get(k)) else { continue };
                (&d.id, &own.unit, d.is_angle, d.value, d.uncertainty)
            }
        };
        let scale = if is_angle { ARCSEC } else { 1.0 };
        let probability = value.zip(uncertainty).and_then(|(v, c)| probability(v, &c, limit.lower, limit.upper));
        let outcome = decide(campaign.decision, value, uncertainty.as_ref(), probability, fit.settings.level, limit);
        let bound = |v: f64| v.is_finite().then_some(v * scale);
        quantities.push(LimitedReport {
            id: id.clone(),
            unit: if is_angle { "arcsec".into() } else { unit.clone() },
            lower: bound(limit.lower),
            upper: bound(limit.upper),
            value: value.map(|v| v * scale),
            expanded: uncertainty.map(|c| c.expanded * scale),
            probability,
            outcome: outcome.into(),
        });
    }
    let worst = ["fail", "undecided"].into_iter().find(|word| quantities.iter().any(|q| q.outcome == *word));
    let percent = significant(100.0 * fit.settings.level, 3).trim_end_matches('0').trim_end_matches('.').to_string();
    let rule = match campaign.decision {
        Decision::Simple => "simple acceptance: the estimate inside the limits (JCGM 106, 8.2)".to_string(),
        Decision::GuardU => {
            format!("guard band w = U ({percent} %): pass inside by U, fail outside by U (JCGM 106, 8.3)")
        }
        Decision::Risk => {
            format!(
                "specific risk: pass where conformity is at least {percent} % probable, fail where non-conformity is (JCGM 106, 7)"
            )
        }
    };
    Some(ConformityReport {
        decision: campaign.decision.name().into(),
        rule,
        outcome: worst.unwrap_or("pass").into(),
        quantities,
    })
}

/// `P(lower <= Y <= upper)` for `Y = value + u t`, t with the effective degrees of freedom (JCGM 106, 7.3).
fn probability(value: f64, combined: &Combined, lower: f64, upper: f64) -> Option<f64> {
    if !(combined.u > 0.0) {
        return Some(f64::from(u8::from(lower <= value && value <= upper)));
    }
    let below = |bound: f64| match bound {
        f64::INFINITY => Some(1.0),
        f64::NEG_INFINITY => Some(0.0),
        bound => student_t_cdf((bound - value) / combined.u, combined.dof),
    };
    Some((below(upper)? - below(lower)?).clamp(0.0, 1.0))
}

fn decide(
    decision: Decision,
    value: Option<f64>,
    uncertainty: Option<&Combined>,
    probability: Option<f64>,
    level: f64,
    limit: &crate::campaign::Limit,
) -> &'static str {
    let Some(value) = value else { return "undecided" };
    let inside = |by: f64| limit.lower + by <= value && value <= limit.upper - by;
    match (decision, uncertainty, probability) {
        (Decision::Simple, ..) => {
            if inside(0.0) {
                "pass"
            } else {
                "fail"
            }
        }
        (Decision::GuardU, Some(combined), _) => match combined.expanded {
            guard if inside(guard) => "pass",
            guard if !inside(-guard) => "fail",
            _ => "undecided",
        },
        (Decision::Risk, _, Some(probability)) => match probability {
            p if p >= level => "pass",
            p if p <= 1.0 - level => "fail",
            _ => "undecided",
        },
        _ => "undecided",
    }
}

/// Conformity as a table for a terminal.
pub fn conformity_text(report: &ConformityReport) -> String {
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
                q.outcome.clone(),
            ]
        })
        .collect();
    let table = plain(&["conformity", "lower", "value", "upper", "U", "unit", "probability", "outcome"], &rows);
    format!("{table}{}\n", super::wrap::hanging(&format!("conformity: {}; {}", report.outcome, report.rule), 2))
}

/// A probability in percent; neither 0 nor 1 where it is only near.
pub(super) fn percent(probability: f64) -> String {
    match 100.0 * probability {
        p if p >= 99.995 && probability < 1.0 => "> 99.99 %".into(),
        p if p < 0.005 && probability > 0.0 => "< 0.01 %".into(),
        p => format!("{p:.2} %"),
    }
}
