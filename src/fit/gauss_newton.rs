//! The exact estimator: linearise, adjust, move, repeat; with a record of every step.

use super::{Settings, system::weigh};
use crate::campaign::Campaign;
use crate::design::{self, DesignMatrix, Model};
use crate::error::Result;
use crate::estimate::{self, Estimate, Group, System};

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

/// One linear step, or Gauss-Newton to its fixed point. The estimate that comes back belongs to the design that comes back with it.
pub(super) fn run(
    campaign: &Campaign,
    model: &Model,
    design: DesignMatrix,
    settings: &Settings,
) -> Result<(DesignMatrix, System, Estimate, Option<Convergence>)> {
    let mut design = design;
    let mut system = weigh(campaign, &design, settings.weighting)?;
    let mut estimate = estimate::adjust(&system, &settings.adjust)?;
    if !settings.exact {
        return Ok((design, system, estimate, None));
    }
    let unknowns = campaign.unknowns();
    let linear = design.point.iter().zip(&estimate.solution).take(unknowns).map(|(x, dx)| x + dx).collect();
    let mut record = Convergence { converged: false, iterations: Vec::new(), linear };
    while record.iterations.len() < settings.iterations {
        // the step minimises the squares in units of the readings' scatter, so these, not those in units of the u given, must fall
        let u = scattered(&system, &estimate);
        let before = weighted_square(&system.observed, &u);
        let moved: Vec<f64> = system.observed.iter().zip(&estimate.residuals).map(|(y, v)| y - v).collect();
        let step = weighted_square(&moved, &u).sqrt();
        let size = weighted_square(&values(&design, &system), &u).sqrt();
        let noise = weighted_square(&estimate.residuals, &u).sqrt();
        let small = step <= NEGLIGIBLE * size || step <= INVISIBLE * noise;
        if small || !step.is_finite() {
            record.converged = small;
            record.iterations.push(Iteration { sum_of_squares: before, step, share: 1.0 });
            return Ok((design, system, estimate, Some(record)));
        }
        let mut share = 1.0;
        let taken = loop {
            let mut point = design.point.clone();
            for (value, dx) in point.iter_mut().zip(&estimate.solution) {
                *value += share * dx;
            }
            let next = design::assemble(campaign, model, &point)?;
            let next_system = weigh(campaign, &next, settings.weighting)?;
            let after = weighted_square(&next_system.observed, &u);
            // rounding of a sum of squares near its minimum must not halve a good step
            if after.is_finite() && after <= before * (1.0 + 1e-10) + (NEGLIGIBLE * size).powi(2) {
                break Some((next, next_system));
            }
            share *= 0.5;
            if share < 1e-10 {
                break None;
            }
        };
        record.iterations.push(Iteration { sum_of_squares: before, step, share });
        let Some((next, next_system)) = taken else { break };
        let adjusted = match estimate::adjust(&next_system, &settings.adjust) {
            Ok(adjusted) => adjusted,
            Err(_) => break, // derivatives beyond the range of numbers: the last good point stands, and the record says "not converged"
        };
        (design, system, estimate) = (next, next_system, adjusted);
    }
    Ok((design, system, estimate, Some(record)))
}

/// Readings (not differences), and priors, in row order: the scale against which a step is negligible.
fn values(design: &DesignMatrix, system: &System) -> Vec<f64> {
    let predicted = design.predicted.iter().copied().chain(std::iter::repeat(0.0));
    system.observed.iter().zip(predicted).map(|(difference, predicted)| difference.abs() + predicted.abs()).collect()
}

/// `s_g u` of each row, the scale of its group included where there are several; one group alone needs none.
fn scattered(system: &System, estimate: &Estimate) -> Vec<f64> {
    let scale = |group: &Group| match group {
        Group::Estimated(g) if estimate.group_iterations > 0 => estimate.group_scale.get(*g).copied().flatten(),
        _ => None,
    };
    system.u.iter().zip(&system.group).map(|(u, group)| u * scale(group).unwrap_or(1.0)).collect()
}

fn weighted_square(values: &[f64], u: &[f64]) -> f64 {
    values.iter().zip(u).map(|(v, u)| (v / u) * (v / u)).sum()
}

/// How far the linear model is from the exact one at the solution, in units of the readings' standard uncertainty.
pub(super) fn linearisation_error(
    campaign: &Campaign,
    model: &Model,
    design: &DesignMatrix,
    system: &System,
    estimate: &Estimate,
    point: &[f64],
) -> Result<Option<f64>> {
    let exact = design::assemble(campaign, model, point)?;
    let mut worst: Option<f64> = None;
    for (i, (exact, reference)) in exact.predicted.iter().zip(&design.predicted).enumerate() {
        let at = |list: &[f64]| list.get(i).copied().unwrap_or_default();
        let linear = reference + at(&system.observed) - at(&estimate.residuals);
        let scale = match system.group.get(i) {
            Some(Group::Estimated(g)) => estimate.group_scale.get(*g).copied().flatten(),
            _ => Some(1.0),
        };
        let Some(u) = scale.map(|s| s * at(&system.u)).filter(|u| *u > 0.0) else { continue };
        worst = Some(worst.unwrap_or(0.0).max((exact - linear).abs() / u));
    }
    Ok(worst)
}
