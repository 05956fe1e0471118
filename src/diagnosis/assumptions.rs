//! What a campaign asserts besides its model line: priors and constraints. They are retained while the model is diagnosed, and each may be wrong.
//!
//! An equation is met exactly, an inequality that holds the estimate back is held as an equation (a norm by its tangent), any other has no
//! part. Taking a prior or an equation away is a candidate like any other: its column is what it kept the parameters from doing.

use super::Candidate;
use crate::campaign::{Campaign, Constraint, Role};
use crate::design::DesignMatrix;
use crate::elements::Elements;
use crate::error::Result;
use crate::estimate::{Equation, Equations, Side};
use crate::fit::{self, Constraints, Weighting};
use crate::simulate::Regressor;
use crate::vocabulary::vocabulary;

vocabulary! {
    /// What a diagnosis did with a constraint of the campaign.
    Held {
        /// An equality: met exactly throughout.
        Equality = "equality",
        /// An inequality that holds the estimate back: taken as an equality at its limit.
        AtLimit = "at-limit",
        /// An inequality that the estimate meets by itself: it has no part.
        Inactive = "inactive",
        /// It contradicts others, or could not be applied: left out.
        LeftOut = "left-out",
        /// Found to be wrong, and taken away by the repair.
        Wrong = "wrong",
    }
}

/// A campaign whose constraints are equations only, and where each of them comes from.
pub(super) struct Assumed {
    pub campaign: Campaign,
    /// For each constraint that was asked for.
    pub held: Vec<Held>,
    /// For each equation, the constraint that was asked for.
    pub asked: Vec<usize>,
}

/// Hold what is active at the estimate, let go what is not.
pub(super) fn hold(campaign: &Campaign) -> Result<Assumed> {
    let equality = |c: &Constraint| matches!(c, Constraint::Linear { lower, upper, .. } if lower == upper);
    let mut assumed = Assumed { campaign: campaign.clone(), held: Vec::new(), asked: Vec::new() };
    if campaign.constraints.is_empty() {
        return Ok(assumed);
    }
    assumed.campaign.constraints.clear();
    let fit = super::fit_exactly(campaign, fit::tried)?;
    for (k, constraint) in campaign.constraints.iter().enumerate() {
        let (held, equation) = match &fit.constraints {
            Constraints::Contradictory(_) => (Held::LeftOut, None),
            _ if equality(constraint) => (Held::Equality, Some(constraint.clone())),
            Constraints::Met { active, .. } => match active.iter().find(|a| a.constraint == k) {
                Some(limit) => match at_limit(constraint, limit.side, &fit.point) {
                    Some(equation) => (Held::AtLimit, Some(equation)),
                    None => (Held::LeftOut, None),
                },
                None => (Held::Inactive, None),
            },
            Constraints::None | Constraints::NotApplied => (Held::LeftOut, None),
        };
        assumed.held.push(held);
        if let Some(equation) = equation {
            assumed.campaign.constraints.push(equation);
            assumed.asked.push(k);
        }
    }
    Ok(assumed)
}

/// An active inequality as an equation; a norm by its tangent, `sum (x_j / |x|) x_j = limit`.
fn at_limit(constraint: &Constraint, side: Side, point: &[f64]) -> Option<Constraint> {
    let at = |j: &usize| point.at(*j);
    match constraint {
        Constraint::Linear { terms, lower, upper } => {
            let limit = if side == Side::Lower { *lower } else { *upper };
            Some(Constraint::Linear { terms: terms.clone(), lower: limit, upper: limit })
        }
        Constraint::Norm { of, at_most } => {
            let norm = of.iter().map(|j| at(j) * at(j)).sum::<f64>().sqrt();
            let terms = of.iter().map(|j| (*j, at(j) / norm)).collect();
            (norm > 0.0).then_some(Constraint::Linear { terms, lower: *at_most, upper: *at_most })
        }
    }
}

/// Each prior and each equation as a candidate: the column of what it forbids. `asked` numbers the equations as the campaign's file does.
pub(super) fn candidates(campaign: &Campaign, asked: &[usize], design: &DesignMatrix) -> Result<Vec<Candidate>> {
    let mut candidates = Vec::new();
    let system = fit::weigh(campaign, design, Weighting::AsStated)?;
    let rows = system.observed.len();
    let mut row = design.rows.len();
    for (k, parameter) in campaign.estimated().iter().enumerate() {
        if let Role::Estimated { prior: Some(_), .. } = parameter.role {
            let mut column = vec![0.0; rows];
            column.iter_mut().skip(row).take(1).for_each(|value| *value = 1.0);
            row += 1;
            candidates.push(Candidate {
                regressor: format!("prior:{}", parameter.id),
                name: format!("error of the prior of {}", parameter.id),
                why: "the prior value does not apply to this campaign".into(),
                confirm: "leave the prior out, or measure at positions that determine the parameter without it".into(),
                ..Candidate::new(Regressor::Prior(k), column)
            });
        }
    }
    for (k, column) in equation_columns(campaign, &system.rows) {
        let number = asked.get(k).map_or(k, |index| index + 1);
        candidates.push(Candidate {
            regressor: format!("constraint:{number}"),
            name: format!("constraint {number} does not hold"),
            why: "the constraint between the parameters does not hold in this campaign".into(),
            confirm: "leave the constraint out and compare the estimates with it".into(),
            ..Candidate::new(Regressor::Constraint(k), column)
        });
    }
    Ok(candidates)
}

/// For each equation that the others do not imply: `A d` with `b_k d = 1` and `b_l d = 0` for the others.
fn equation_columns(campaign: &Campaign, rows: &faer::Mat<f64>) -> Vec<(usize, Vec<f64>)> {
    let linear = |constraint: &Constraint| match constraint {
        Constraint::Linear { terms, .. } => terms.clone(),
        Constraint::Norm { .. } => Vec::new(),
    };
    let terms: Vec<Vec<(usize, f64)>> = campaign.constraints.iter().map(linear).collect();
    let mut columns = Vec::new();
    for k in 0..terms.len() {
        let value = |l: usize| f64::from(u8::from(l == k));
        let equations: Vec<Equation> =
            terms.iter().enumerate().map(|(l, terms)| Equation { terms: terms.clone(), value: value(l) }).collect();
        if let Equations::Consistent(elimination) = Equations::new(rows.ncols(), &[], &equations) {
            let mut column = vec![0.0; rows.nrows()];
            for (j, d) in elimination.offset().iter().enumerate().take(rows.ncols()) {
                column.iter_mut().zip(rows.col_as_slice(j)).for_each(|(sum, a)| *sum += a * d);
            }
            columns.push((k, column));
        }
    }
    columns
}

/// The campaign without the priors and equations among these effects.
pub(super) fn freed(campaign: &Campaign, effects: &[&Candidate]) -> Campaign {
    let mut freed = campaign.clone();
    let wrong: Vec<usize> = effects.iter().filter_map(|c| constraint_of(c)).collect();
    let kept = freed.constraints.iter().enumerate().filter(|(k, _)| !wrong.contains(k)).map(|(_, c)| c.clone());
    freed.constraints = kept.collect();
    for effect in effects {
        if let Regressor::Prior(k) = effect.kind
            && let Some(parameter) = freed.parameters.get_mut(k)
        {
            // the estimate still starts from the prior value
            let start = Some(parameter.reference());
            parameter.role = Role::Estimated { start, prior: None };
        }
    }
    freed
}

/// Is this an effect that no model line has: a prior or a constraint that is wrong?
pub(super) fn is_assumption(candidate: &Candidate) -> bool {
    matches!(candidate.kind, Regressor::Prior(_) | Regressor::Constraint(_))
}

/// The equation that a candidate takes away.
pub(super) fn constraint_of(candidate: &Candidate) -> Option<usize> {
    match candidate.kind {
        Regressor::Constraint(k) => Some(k),
        _ => None,
    }
}
