//! The exact estimator: linearise, adjust, move, repeat; with a record of every step.

use super::step::{self, Step};
use super::{Settings, rules, system::weigh};
use crate::campaign::{Campaign, Kind, Role};
use crate::design::{self, DesignMatrix, Model};
use crate::error::Result;
use crate::estimate::{Estimate, Group, System};

/// What Gauss-Newton did.
#[derive(Debug, Clone, PartialEq)]
pub struct Convergence {
    /// Did the last step stop mattering?
    pub converged: bool,
    /// Every iteration; the first is the linear estimator.
    pub iterations: Vec<Iteration>,
    /// The linear estimator's values of the estimated parameters, for comparison.
    pub linear: Vec<f64>,
}

/// One iteration of Gauss-Newton.
#[derive(Debug, Clone, PartialEq)]
pub struct Iteration {
    /// `sum (v/u)^2` of the exact model before the step.
    pub sum_of_squares: f64,
    /// Norm of the step's effect on the weighted predictions, `|J dx / u|`.
    pub step: f64,
    /// Share of the step that was taken; below 1 where the full step would have made the fit worse.
    pub share: f64,
}

/// A step is negligible when it moves no weighted prediction by more than this share of the weighted observations' norm,
const NEGLIGIBLE: f64 = 1e-14;
/// or by more than this share of the weighted residuals' norm: then it changes no estimate by a visible part of its uncertainty.
const INVISIBLE: f64 = 1e-9;

/// One linear step, or Gauss-Newton to its fixed point. The step that comes back belongs to the design that comes back with it.
pub(super) fn run(
    campaign: &Campaign,
    model: &Model,
    design: DesignMatrix,
    settings: &Settings,
) -> Result<(DesignMatrix, Step, Option<Convergence>)> {
    let mut design = design;
    let mut step = step::solve(campaign, &design, settings)?;
    if !settings.exact {
        return Ok((design, step, None));
    }
    let unknowns = campaign.unknowns();
    let linear = design.point.iter().zip(&step.change).take(unknowns).map(|(x, dx)| x + dx).collect();
    let mut record = Convergence { converged: false, iterations: Vec::new(), linear };
    while record.iterations.len() < settings.iterations {
        let system = &step.system;
        let before = merit(&system.observed, &step);
        let moved: Vec<f64> = system.observed.iter().zip(&step.estimate.residuals).map(|(y, v)| y - v).collect();
        let length = merit(&moved, &step).sqrt();
        let size = merit(&values(&design, system), &step).sqrt();
        let noise = merit(&step.estimate.residuals, &step).sqrt();
        let small = length <= NEGLIGIBLE * size || length <= INVISIBLE * noise;
        if small || !length.is_finite() {
            record.converged = small && step.settled;
            record.iterations.push(Iteration { sum_of_squares: before, step: length, share: 1.0 });
            return Ok((design, step, Some(record)));
        }
        // from outside the constraints the first full step leads onto them, whatever it does to the fit
        let feasible = rules::is_feasible(campaign, &design.point);
        let mut share = 1.0;
        let taken = loop {
            let mut point = design.point.clone();
            for (value, dx) in point.iter_mut().zip(&step.change) {
                *value += share * dx;
            }
            within_half_a_turn(campaign, &mut point);
            let next = design::assemble(campaign, model, &point)?;
            let next_system = weigh(campaign, &next, settings.weighting)?;
            let after = merit(&next_system.observed, &step);
            // rounding of a sum of squares near its minimum must not halve a good step
            let better = after <= before * (1.0 + 1e-10) + (NEGLIGIBLE * size).powi(2);
            if after.is_finite() && (better || !feasible) {
                break Some(next);
            }
            share *= 0.5;
            if share < 1e-10 {
                break None;
            }
        };
        record.iterations.push(Iteration { sum_of_squares: before, step: length, share });
        let Some(next) = taken else { break };
        let adjusted = match step::solve(campaign, &next, settings) {
            Ok(adjusted) => adjusted,
            Err(_) => break, // derivatives beyond the range of numbers: the last good point stands, and the record says "not converged"
        };
        (design, step) = (next, adjusted);
    }
    Ok((design, step, Some(record)))
}

/// What the step makes smaller: the weighted sum of squares, with the whitened rows' covariance or the robust weights of this step.
fn merit(values: &[f64], step: &Step) -> f64 {
    let system = &step.system;
    let weights = step.robust.as_ref().map(|record| record.weights.as_slice());
    match &step.indicators {
        None => values
            .iter()
            .zip(&system.u)
            .enumerate()
            .map(|(i, (v, u))| {
                let own = u * scale(&step.estimate, system.group.get(i));
                (v / own).powi(2) * weights.and_then(|w| w.get(i)).copied().unwrap_or(1.0)
            })
            .sum(),
        Some(columns) => {
            let mut whitened = vec![0.0; values.len()];
            for (v, column) in values.iter().zip(columns) {
                for (row, entry) in column {
                    if let Some(sum) = whitened.get_mut(*row) {
                        *sum += entry * v;
                    }
                }
            }
            whitened.iter().map(|v| v * v).sum()
        }
    }
}

/// Take whole turns out of tilts: a long first step may end a turn away from the same rotation. A tilt with a prior keeps its value.
fn within_half_a_turn(campaign: &Campaign, point: &mut [f64]) {
    use std::f64::consts::{PI, TAU};
    for (parameter, value) in campaign.parameters.iter().zip(point) {
        let free = matches!(parameter.role, Role::Estimated { prior: None, .. });
        if parameter.kind == Kind::Tilt && free && value.abs() > PI {
            *value -= TAU * (*value / TAU).round();
        }
    }
}

/// The estimated scale of a row's group where there are several: the step minimises the squares in units of the readings' scatter.
fn scale(estimate: &Estimate, group: Option<&Group>) -> f64 {
    match group {
        Some(Group::Estimated(g)) if estimate.group_iterations > 0 => {
            estimate.group_scale.get(*g).copied().flatten().unwrap_or(1.0)
        }
        _ => 1.0,
    }
}

/// Readings (not differences), and priors, in row order: the scale against which a step is negligible.
fn values(design: &DesignMatrix, system: &System) -> Vec<f64> {
    let predicted = design.predicted.iter().copied().chain(std::iter::repeat(0.0));
    system.observed.iter().zip(predicted).map(|(difference, predicted)| difference.abs() + predicted.abs()).collect()
}

/// How far the linear model is from the exact one at the solution, in units of the readings' standard uncertainty.
pub(super) fn linearisation_error(
    at_solution: &DesignMatrix,
    design: &DesignMatrix,
    system: &System,
    estimate: &Estimate,
) -> Option<f64> {
    let mut worst: Option<f64> = None;
    for (i, (exact, reference)) in at_solution.predicted.iter().zip(&design.predicted).enumerate() {
        let at = |list: &[f64]| list.get(i).copied().unwrap_or_default();
        let linear = reference + at(&system.observed) - at(&estimate.residuals);
        let scale = match system.group.get(i) {
            Some(Group::Estimated(g)) => estimate.group_scale.get(*g).copied().flatten(),
            _ => Some(1.0),
        };
        let Some(u) = scale.map(|s| s * at(&system.u)).filter(|u| *u > 0.0) else { continue };
        worst = Some(worst.unwrap_or(0.0).max((exact - linear).abs() / u));
    }
    worst
}
