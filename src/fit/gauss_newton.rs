//! The exact estimator: linearise, adjust, move, repeat; with a record of every step.
//!
//! On the way only solutions are needed (`linear.rs`); the step with all its diagnostics is made once, where the iteration ends.

use super::linear::Linear;
use super::step::{self, Step};
use super::{Settings, rules, system::weigh};
use crate::campaign::{Campaign, Kind, Role};
use crate::design::{self, DesignMatrix, Model};
use crate::error::Result;
use crate::estimate::{Coupling, Estimate, Group, System};

/// What Gauss-Newton did.
#[derive(Debug, Clone, PartialEq)]
pub struct Convergence {
    /// Did the last step stop mattering?
    pub converged: bool,
    /// Why it ended.
    pub stop: Stop,
    /// Every iteration; the first is the linear estimator.
    pub iterations: Vec<Iteration>,
    /// The linear estimator's values of the estimated parameters, for comparison.
    pub linear: Vec<f64>,
    /// Parameters (by index) that the reference point does not determine, and the exact model beyond it too weakly to follow: they kept
    /// their reference values, and only their combinations with others are estimated.
    pub held: Vec<usize>,
}

/// Why Gauss-Newton ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// The last step moved no prediction by an amount that matters.
    Settled,
    /// The same, but the scales, weights or components inside the step did not settle.
    Unsettled,
    /// As many iterations as were allowed.
    Limit,
    /// Steps stay long and the fit no longer becomes better: a direction that the readings hardly determine.
    Stalled,
    /// No share of the last step makes the fit better.
    NoDescent,
    /// Beyond the last point numbers leave the range of a double.
    OutOfRange,
}

impl Stop {
    /// As reports write it.
    pub fn reason(self) -> &'static str {
        match self {
            Stop::Settled => "the last step no longer matters",
            Stop::Unsettled => "the scales inside the last step did not settle",
            Stop::Limit => "the steps did not end",
            Stop::Stalled => {
                "steps stay long while the fit no longer becomes better: the readings hardly determine some direction"
            }
            Stop::NoDescent => "no part of the last step makes the fit better",
            Stop::OutOfRange => "numbers leave the range of a double",
        }
    }
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
/// Over so many iterations the sum of squares must fall by `PROGRESS` of itself, or the steps become half as long.
const PATIENCE: usize = 20;
const PROGRESS: f64 = 1e-6;
/// An unknown that the reference point does not determine may take part in so many iterations.
const RELEASED: usize = 10;

/// One linear step, or Gauss-Newton to its fixed point. The step that comes back belongs to the design that comes back with it.
pub(super) fn run(
    campaign: &Campaign,
    model: &Model,
    design: DesignMatrix,
    settings: &Settings,
) -> Result<(DesignMatrix, Step, Option<Convergence>)> {
    if !settings.exact {
        let step = step::solve(campaign, &design, settings)?;
        return Ok((design, step, None));
    }
    let first = Linear::at(campaign, &design, None, settings)?;
    let unknowns = campaign.unknowns();
    let linear = design.point.iter().zip(&first.change).take(unknowns).map(|(x, dx)| x + dx).collect();
    let rank = first.rank;
    let couplings = if rank < unknowns && campaign.constraints.is_empty() {
        step::solve(campaign, &design, settings)?.estimate.factor.couplings()
    } else {
        Vec::new()
    };
    let mut walk = Walk { campaign, model, settings, rank, couplings, holds: false, iterations: Vec::new() };
    let reference = design.clone();
    let (mut design, mut stop) = walk.go(design, first)?;
    if stop.is_none() {
        // beyond the reference point the readings would determine more, but too weakly for steps to follow
        let mut held = reference;
        walk.holds = true;
        walk.iterations.clear();
        walk.hold(&mut held);
        let first = Linear::at(campaign, &held, None, settings)?;
        (design, stop) = walk.go(held, first)?;
    }
    let step = step::solve(campaign, &design, settings)?;
    let stop = match stop.unwrap_or(Stop::Stalled) {
        Stop::Settled if !step.settled => Stop::Unsettled,
        stop => stop,
    };
    let held = if walk.holds { walk.couplings.iter().map(|coupling| coupling.unknown).collect() } else { Vec::new() };
    let record = Convergence { converged: stop == Stop::Settled, stop, iterations: walk.iterations, linear, held };
    Ok((design, step, Some(record)))
}

/// Gauss-Newton on its way.
struct Walk<'a> {
    campaign: &'a Campaign,
    model: &'a Model,
    settings: &'a Settings,
    /// Rank at the reference point.
    rank: usize,
    /// How unknowns that the reference point does not determine follow the others there.
    couplings: Vec<Coupling>,
    /// Are those unknowns held?
    holds: bool,
    iterations: Vec<Iteration>,
}

impl Walk<'_> {
    /// Walk to the end; no reason to stop comes back where the unknowns that the reference point does not determine must be held.
    fn go(&mut self, mut design: DesignMatrix, mut step: Linear) -> Result<(DesignMatrix, Option<Stop>)> {
        while self.iterations.len() < self.settings.iterations {
            let before = step.merit(&step.system.observed);
            let moved: Vec<f64> = step.system.observed.iter().zip(&step.residuals).map(|(y, v)| y - v).collect();
            let length = step.merit(&moved).sqrt();
            let size = step.merit(&values(&design, &step.system)).sqrt();
            let noise = step.merit(&step.residuals).sqrt();
            let small = length <= NEGLIGIBLE * size || length <= INVISIBLE * noise;
            if small || !length.is_finite() {
                self.iterations.push(Iteration { sum_of_squares: before, step: length, share: 1.0 });
                return Ok((design, Some(if small { Stop::Settled } else { Stop::OutOfRange })));
            }
            let released = !self.holds && !self.couplings.is_empty() && step.rank > self.rank;
            if released && self.iterations.len() > RELEASED {
                return Ok((design, None));
            }
            if self.is_stalled(before, length) {
                return Ok((design, if released { None } else { Some(Stop::Stalled) }));
            }
            let (share, next) = self.descend(&design, &step, before, size)?;
            if released && share < 1.0 {
                return Ok((design, None));
            }
            self.iterations.push(Iteration { sum_of_squares: before, step: length, share });
            let Some(next) = next else { return Ok((design, Some(Stop::NoDescent))) };
            // derivatives beyond the range of numbers: the last good point stands
            let Ok(adjusted) = Linear::at(self.campaign, &next, Some(&step), self.settings) else {
                return Ok((design, Some(Stop::OutOfRange)));
            };
            (design, step) = (next, adjusted);
        }
        Ok((design, Some(Stop::Limit)))
    }

    /// The longest share of the step, halved as often as it takes, that makes the fit better, and the design there.
    fn descend(
        &self,
        design: &DesignMatrix,
        step: &Linear,
        before: f64,
        size: f64,
    ) -> Result<(f64, Option<DesignMatrix>)> {
        // from outside the constraints the first full step leads onto them, whatever it does to the fit
        let feasible = rules::is_feasible(self.campaign, &design.point);
        let mut share = 1.0;
        while share >= 1e-10 {
            let mut point = design.point.clone();
            for (value, dx) in point.iter_mut().zip(&step.change) {
                *value += share * dx;
            }
            within_half_a_turn(self.campaign, &mut point);
            let next = design::assemble(self.campaign, self.model, &point)?;
            let mut next = circles_within_half_a_turn(self.campaign, self.model, next)?;
            let after = step.merit(&weigh(self.campaign, &next, self.settings.weighting)?.observed);
            // rounding of a sum of squares near its minimum must not halve a good step
            let better = after <= before * (1.0 + 1e-10) + (NEGLIGIBLE * size).powi(2);
            if after.is_finite() && (better || !feasible) {
                self.hold(&mut next);
                return Ok((share, Some(next)));
            }
            share *= 0.5;
        }
        Ok((share, None))
    }

    /// Neither the fit has become better of late, nor the steps shorter.
    fn is_stalled(&self, now: f64, length: f64) -> bool {
        let Some(then) = self.iterations.len().checked_sub(PATIENCE).and_then(|k| self.iterations.get(k)) else {
            return false;
        };
        now > then.sum_of_squares * (1.0 - PROGRESS) && length > 0.5 * then.step
    }

    /// Unknowns that are held keep following the others as they do at the reference point, so that they stay outside the basis.
    fn hold(&self, design: &mut DesignMatrix) {
        if !self.holds {
            return;
        }
        for Coupling { unknown, follows } in &self.couplings {
            for i in 0..design.jacobian.nrows() {
                design.jacobian[(i, *unknown)] = follows.iter().map(|(j, c)| c * design.jacobian[(i, *j)]).sum();
            }
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

/// Of all values of a closed circle's unknown that predict the same (a turn away, or mirrored at a right angle), the smallest; one by one.
fn circles_within_half_a_turn(campaign: &Campaign, model: &Model, mut design: DesignMatrix) -> Result<DesignMatrix> {
    /// Share of a turn by which rounding moves a prediction that is the same.
    const SAME: f64 = 1e-9;
    let Some(turn) = campaign.bench.sensors.iter().find_map(|sensor| sensor.turn) else { return Ok(design) };
    for (k, parameter) in campaign.parameters.iter().enumerate() {
        let free = matches!(parameter.role, Role::Estimated { prior: None, .. }) && parameter.kind == Kind::Coefficient;
        let value = design.point.get(k).copied().unwrap_or_default();
        let within = value - turn * (value / turn).round();
        for other in [(0.5 * turn).copysign(within) - within, within] {
            let smaller = other.abs() < value.abs().min(0.5 * turn * (1.0 + SAME)) && other != value;
            if !free || value.abs() <= 0.25 * turn || !smaller {
                continue;
            }
            let mut point = design.point.clone();
            point.get_mut(k).into_iter().for_each(|slot| *slot = other);
            let moved = design::assemble(campaign, model, &point)?;
            let mut pairs = moved.predicted.iter().zip(&design.predicted);
            if pairs.all(|(a, b)| (a - b).abs() <= SAME * turn) {
                design = moved;
                break;
            }
        }
    }
    Ok(design)
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
