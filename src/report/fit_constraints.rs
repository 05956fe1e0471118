//! What a fit report says of the campaign's constraints.

use crate::campaign::{Campaign, Constraint};
use crate::estimate::Side;
use crate::fit::{Constraints, Fit};
use crate::language::{Sentence, sentence};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The constraints of a campaign and what became of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ConstraintsReport {
    /// `met`, `contradictory` (none was applied) or `not-applied` (a rank defect is left, or the solver gave up).
    pub status: String,
    /// Each of them.
    pub list: Vec<ConstraintReport>,
    /// By how much the inequalities raise chi-square (the sum of squares over the estimated variance).
    pub cost: Option<f64>,
    /// Covariance of the constrained estimate on the active face (from the readings), in the order of `covariance`; null where no
    /// inequality is active. The parameters' own `u` and `interval` do not rely on it.
    pub on_face: Option<Vec<Vec<f64>>>,
    /// Probability of a larger cost if the bounds that are active were true: chi-square, or F where the variance is estimated.
    #[serde(default)]
    pub p: Option<f64>,
    /// In words.
    pub verdict: Sentence,
}

/// One constraint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ConstraintReport {
    /// Number in the file, from 1.
    pub index: usize,
    /// The constraint as a line of text.
    pub text: String,
    /// `equality`, `inactive`, `active` or `contradictory`.
    pub state: String,
    /// `lower`, `upper` or `norm` where it is active.
    pub side: Option<String>,
    /// Decrease of chi-square for each unit (radian for tilts) by which an active bound gives way.
    pub multiplier: Option<f64>,
    /// By how much chi-square would be smaller without an active bound.
    pub cost: Option<f64>,
}

/// The constraints, if the campaign has any.
pub(super) fn constraints(fit: &Fit) -> Option<ConstraintsReport> {
    let (status, contradictory): (&str, &[usize]) = match &fit.constraints {
        Constraints::None => return None,
        Constraints::Met { .. } => ("met", &[]),
        Constraints::Contradictory(named) => ("contradictory", named),
        Constraints::NotApplied => ("not-applied", &[]),
    };
    let (active, cost, on_face) = match &fit.constraints {
        Constraints::Met { active, cost, on_face, .. } => (active.as_slice(), Some(*cost), on_face.as_ref()),
        _ => (&[][..], None, None),
    };
    let list: Vec<ConstraintReport> = fit
        .campaign
        .constraints
        .iter()
        .enumerate()
        .map(|(k, constraint)| {
            let own = active.iter().find(|a| a.constraint == k);
            let equality = matches!(constraint, Constraint::Linear { lower, upper, .. } if lower == upper);
            let state = match (own, equality) {
                _ if contradictory.contains(&k) => "contradictory",
                _ if status != "met" => "not-applied",
                (Some(_), _) => "active",
                (None, true) => "equality",
                (None, false) => "inactive",
            };
            ConstraintReport {
                index: k + 1,
                text: constraint_text(&fit.campaign, constraint),
                state: state.into(),
                side: own.map(|a| match a.side {
                    Side::Lower => "lower".into(),
                    Side::Upper => "upper".into(),
                    Side::Norm => "norm".into(),
                }),
                multiplier: own.map(|a| a.multiplier),
                cost: own.map(|a| a.cost),
            }
        })
        .collect();
    let significant = |x: f64| super::table::significant(x, 3);
    let verdict = match status {
        "contradictory" => {
            let named: Vec<String> = contradictory.iter().map(|k| (k + 1).to_string()).collect();
            sentence!("no-values-meet-constraints-together-none-was", named = named.join(", "))
        }
        "not-applied" => {
            sentence!("the-constraints-were-not-applied-the-readings")
        }
        _ => {
            let mut clauses: Vec<Sentence> = list
                .iter()
                .filter_map(|c| {
                    let cost = significant(c.cost?);
                    Some(sentence!("constraint-costs-in-chi-square", index = c.index, text = c.text, cost))
                })
                .collect();
            if clauses.is_empty() {
                sentence!("no-bound-is-active-the-estimate-is")
            } else {
                let contradicted = fit.bounds_p().filter(|p| *p < 1.0 - fit.settings.level);
                clauses.extend(
                    contradicted
                        .map(|p| sentence!("rejected-the-readings-contradict-the-bounds-p", p = significant(p))),
                );
                Sentence::clauses(clauses)
            }
        }
    };
    let matrix = |m: &faer::Mat<f64>| {
        (0..m.nrows()).map(|i| (0..m.ncols()).map(|j| m[(i, j)]).collect()).collect::<Vec<Vec<f64>>>()
    };
    Some(ConstraintsReport {
        status: status.into(),
        list,
        cost,
        on_face: on_face.map(matrix),
        p: fit.bounds_p(),
        verdict,
    })
}

/// A constraint as a line of text, angles in arcseconds where all its parameters are tilts.
pub(super) fn constraint_text(campaign: &Campaign, constraint: &Constraint) -> String {
    let id = |k: &usize| campaign.parameters.get(*k).map_or("", |p| p.id.as_str());
    let tilt = |k: &usize| campaign.parameters.get(*k).is_some_and(|p| p.kind == crate::campaign::Kind::Tilt);
    let angles = |parameters: &[usize]| parameters.iter().all(tilt);
    // digits enough to tell bounds apart, without those of a change of units
    let number = |x: f64| {
        let text = super::table::significant(x, 12);
        if text.contains('.') && !text.contains('e') {
            text.trim_end_matches('0').trim_end_matches('.').to_string()
        } else {
            text
        }
    };
    match constraint {
        Constraint::Linear { terms, lower, upper } => {
            let mut sum = String::new();
            for (k, c) in terms {
                let sign = match (sum.is_empty(), *c < 0.0) {
                    (true, true) => "-",
                    (true, false) => "",
                    (false, true) => " - ",
                    (false, false) => " + ",
                };
                let factor = if c.abs() == 1.0 { String::new() } else { format!("{}*", number(c.abs())) };
                sum.push_str(&format!("{sign}{factor}{}", id(k)));
            }
            let tilts = angles(&terms.iter().map(|(k, _)| *k).collect::<Vec<usize>>());
            let (scale, unit) = if tilts { (super::ARCSEC, " arcsec") } else { (1.0, "") };
            match (lower.is_finite(), upper.is_finite()) {
                _ if lower == upper => format!("{sum} = {}{unit}", number(lower * scale)),
                (true, true) => format!("{} <= {sum} <= {}{unit}", number(lower * scale), number(upper * scale)),
                (true, false) => format!("{sum} >= {}{unit}", number(lower * scale)),
                _ => format!("{sum} <= {}{unit}", number(upper * scale)),
            }
        }
        Constraint::Norm { of, at_most } => {
            let names: Vec<&str> = of.iter().map(id).collect();
            let (scale, unit) = if angles(of) { (super::ARCSEC, " arcsec") } else { (1.0, "") };
            format!("norm of ({}) <= {}{unit}", names.join(", "), number(at_most * scale))
        }
    }
}
