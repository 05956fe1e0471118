//! What a fit report says of the campaign's constraints.

use crate::campaign::{Campaign, Constraint};
use crate::estimate::Side;
use crate::fit::{Constraints, Fit};
use crate::language::{Sentence, sentence};
use crate::vocabulary::vocabulary;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

vocabulary! {
    /// What became of a campaign's constraints.
    ConstraintsStatus {
        /// The estimate meets them.
        Met = "met",
        /// No values meet them together; none was applied.
        Contradictory = "contradictory",
        /// None was applied: a rank defect is left, or the solver gave up.
        NotApplied = "not-applied",
    }
}

vocabulary! {
    /// What became of one constraint.
    ConstraintState {
        /// An equation, met exactly.
        Equality = "equality",
        /// Met without it.
        Inactive = "inactive",
        /// An inequality that holds the estimate back.
        Active = "active",
        /// Together with others no values meet it.
        Contradictory = "contradictory",
        /// Not applied: a rank defect is left, or the solver gave up.
        NotApplied = "not-applied",
    }
}

/// The constraints of a campaign and what became of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct ConstraintsReport {
    /// `met`, `contradictory` (none was applied) or `not-applied` (a rank defect is left, or the solver gave up).
    pub status: ConstraintsStatus,
    /// Each of them.
    pub list: Vec<ConstraintReport>,
    /// By how much the inequalities raise chi-square (the sum of squares over the estimated variance), a pure number.
    pub cost: Option<f64>,
    /// Covariance of the constrained estimate on the active face (from the readings), in the order of `covariance`; null where no
    /// inequality is active. The parameters' own `u` and `interval` do not rely on it.
    pub on_face: Option<Vec<Vec<f64>>>,
    /// Probability of a larger cost if the bounds that are active were true: chi-square, or F where the variance is estimated.
    #[serde(default)]
    pub p: Option<f64>,
    /// Is it below one minus the level?
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rejected: Option<bool>,
    /// In words.
    pub verdict: Sentence,
}

/// One constraint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct ConstraintReport {
    /// Number in the file, from 1.
    pub index: usize,
    /// The constraint as a line of text.
    pub text: String,
    /// `equality`, `inactive`, `active` or `contradictory`.
    pub state: ConstraintState,
    /// `lower`, `upper` or `norm` where it is active.
    pub side: Option<Side>,
    /// Decrease of chi-square for each unit (radian for tilts) by which an active bound gives way.
    pub multiplier: Option<f64>,
    /// By how much chi-square, a pure number, would be smaller without an active bound.
    pub cost: Option<f64>,
}

/// The constraints, if the campaign has any.
pub(super) fn constraints(fit: &Fit) -> Option<ConstraintsReport> {
    let (status, contradictory): (ConstraintsStatus, &[usize]) = match &fit.constraints {
        Constraints::None => return None,
        Constraints::Met { .. } => (ConstraintsStatus::Met, &[]),
        Constraints::Contradictory(named) => (ConstraintsStatus::Contradictory, named),
        Constraints::NotApplied => (ConstraintsStatus::NotApplied, &[]),
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
                _ if contradictory.contains(&k) => ConstraintState::Contradictory,
                _ if status != ConstraintsStatus::Met => ConstraintState::NotApplied,
                (Some(_), _) => ConstraintState::Active,
                (None, true) => ConstraintState::Equality,
                (None, false) => ConstraintState::Inactive,
            };
            ConstraintReport {
                index: k + 1,
                text: constraint_text(&fit.campaign, constraint),
                state,
                side: own.map(|a| a.side),
                multiplier: own.map(|a| a.multiplier),
                cost: own.map(|a| a.cost),
            }
        })
        .collect();
    let significant = |x: f64| crate::document::number::significant(x, 3);
    let verdict = match status {
        ConstraintsStatus::Contradictory => {
            let named: Vec<String> = contradictory.iter().map(|k| (k + 1).to_string()).collect();
            sentence!("no-values-meet-constraints-together-none-was", named = named.join(", "))
        }
        ConstraintsStatus::NotApplied => {
            sentence!("the-constraints-were-not-applied-the-readings")
        }
        ConstraintsStatus::Met => {
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
                let contradicted = fit.bounds_p().filter(|_| fit.bounds_are_rejected() == Some(true));
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
        status,
        list,
        cost,
        on_face: on_face.map(matrix),
        p: fit.bounds_p(),
        rejected: fit.bounds_are_rejected(),
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
        let text = crate::document::number::significant(x, 12);
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
