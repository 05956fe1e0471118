//! The exact estimator: linearise, adjust, move, repeat; with a record of every step.
//!
//! On the way only solutions are needed (`step::Linear`); the step with all its diagnostics is made once, where the iteration ends.

use super::step::{self, Linear, Step};
use super::system::{differences, rounding};
use super::{Estimator, Settings, rules, starts};
use crate::campaign::{Campaign, Deviating, Kind, Role, Scatter};
use crate::design::{self, DesignMatrix, Model};
use crate::elements::Elements;
use crate::error::Result;
use crate::estimate::{Coupling, Estimate, Group, Scattered, System};
use crate::language::{Sentence, sentence};
use crate::number;
use crate::quality;
use crate::uncertainty::quantiles::chi_square_quantile;
use crate::vocabulary::vocabulary;

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
    /// Parameters (by index) that no reading responds to at the reference point, since all that they are multiplied by is zero there (a
    /// saddle of the sum of squares), and that were therefore started beside it.
    pub moved: Vec<usize>,
}

vocabulary! {
    /// Why Gauss-Newton ended.
    Stop {
        /// The last step moved no prediction by an amount that matters.
        Settled = "the last step no longer matters",
        /// The same, but the scales, weights or components inside the step did not settle.
        Unsettled = "the scales inside the last step did not settle",
        /// As many iterations as were allowed.
        Limit = "the steps did not end",
        /// Steps stay long and the fit no longer becomes better: a direction that the readings hardly determine.
        Stalled = "steps stay long while the fit no longer becomes better: the readings hardly determine some direction",
        /// No share of the last step makes the fit better.
        NoDescent = "no part of the last step makes the fit better",
        /// The last step moved nothing that matters, but the readings are far less likely there than by the linear model at the reference point.
        LessLikely = "the readings are far less likely at the solution than at the reference point",
        /// Beyond the last point numbers leave the range of a double.
        OutOfRange = "numbers leave the range of a double",
    }
}

impl Stop {
    /// As a person reads it.
    pub(crate) fn said(self) -> Sentence {
        match self {
            Stop::Settled => sentence!("stop-settled"),
            Stop::Unsettled => sentence!("stop-unsettled"),
            Stop::Limit => sentence!("stop-limit"),
            Stop::Stalled => sentence!("stop-stalled"),
            Stop::NoDescent => sentence!("stop-no-descent"),
            Stop::LessLikely => sentence!("stop-less-likely"),
            Stop::OutOfRange => sentence!("stop-out-of-range"),
        }
    }
}

/// One iteration.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "IterationReport")]
pub struct Iteration {
    /// Weighted sum of squares before the step, in the square of the unit of `residual_sd`.
    pub sum_of_squares: f64,
    /// Norm of the weighted change of the predictions.
    pub step: f64,
    /// Share of the step taken, 0 to 1.
    pub share: f64,
}

impl Iteration {
    /// How often the step was halved: a share of `2^-k` is the k-th half.
    fn halvings(&self) -> usize {
        number::count((-self.share.max(1e-12).log2()).round())
    }
}

/// A step is negligible when it moves no weighted prediction by more than this share of the weighted observations' norm,
pub(crate) const NEGLIGIBLE: f64 = 1e-14;
/// or by more than this share of the weighted residuals' norm: then it changes no estimate by a visible part of its uncertainty.
pub(crate) const INVISIBLE: f64 = 1e-9;
/// Or where steps no longer become shorter, and move no estimate by more than this share of its standard uncertainty (the norm of a step is that of all rows): below
/// every digit that is told, what is left of them is the rounding of the predictions, of which a mean over a turn may be the small difference of large numbers.
const ROUNDING: f64 = 1e-5;
/// Over so many trial points the sum of squares must fall by `PROGRESS` of itself, or the steps become half as long.
const PATIENCE: usize = 20;
/// So many halvings for each iteration that is allowed: what needs more hardly moves.
const HALVINGS: usize = 2;
const PROGRESS: f64 = 1e-6;
/// An unknown that the reference point does not determine may take part in so many iterations.
const RELEASED: usize = 10;

/// Where an estimator ended: the step that belongs to the design, and the record of the way there.
pub(super) struct Ended {
    pub design: DesignMatrix,
    pub step: Step,
    /// `None` for the linear estimator.
    pub record: Option<Convergence>,
    /// The point at which unknowns that are held were judged, if others than the solution.
    pub judged_at: Option<Vec<f64>>,
    /// Parameters (by index) that readings respond to, but in the second order only and within the uncertainty of what they are multiplied
    /// by, or only away from the point that was reached: no rank can be judged for them.
    pub weak: Vec<usize>,
}

/// One linear step, or Gauss-Newton to its fixed point.
pub(super) fn run(campaign: &Campaign, model: &Model, design: DesignMatrix, settings: &Settings) -> Result<Ended> {
    if settings.estimator == Estimator::Linear {
        let step = step::solve(campaign, &design, settings)?;
        let mut weak = starts::unseen(campaign, &design);
        if !weak.is_empty() {
            // what is known does not change
            let change = |k: usize| step.change.get(k).copied().unwrap_or_default();
            let point: Vec<f64> = design.point.iter().enumerate().map(|(k, x)| x + change(k)).collect();
            let there = design.at(campaign, model, &point)?;
            let still = starts::unseen(campaign, &there);
            let beside = starts::beside(campaign, model, &there, &still)?;
            let moved = beside.first().map_or(&[][..], |start| &start.moved);
            weak.retain(|k| !still.contains(k) || moved.contains(k));
        }
        return Ok(Ended { design, step, record: None, judged_at: None, weak });
    }
    let first = Linear::at(campaign, &design, None, settings)?;
    let linear = design.point.iter().zip(&first.change).take(campaign.unknowns()).map(|(x, dx)| x + dx).collect();
    let trip = Trip { campaign, model, settings };
    let mut found = match starts::by_coefficients(campaign, model, &design, settings)? {
        None => trip.from(design, first, &[])?,
        Some(start) => {
            let of_start = Linear::at(campaign, &start, None, settings)?;
            let found = trip.from(start, of_start, &[])?;
            let unknowns = campaign.unknowns();
            if found.stop == Stop::Settled && found.step.own.estimate.unknowns.rank == unknowns {
                found
            } else {
                let other = trip.from(design, first, &[])?;
                if found.is_better_than(&other, campaign) { found } else { other }
            }
        }
    };
    let mut moved = Vec::new();
    let unseen = starts::unseen(campaign, &found.design);
    let beside = starts::beside(campaign, model, &found.design, &unseen)?;
    let in_sight = beside.first().map_or(Vec::new(), |start| start.moved.clone());
    for start in beside {
        let first = Linear::at(campaign, &start.design, None, settings)?;
        let other = trip.from(start.design, first, &start.moved)?;
        if other.is_better_than(&found, campaign) {
            (found, moved) = (other, start.moved);
        }
    }
    if moved.is_empty() {
        found.weak.extend(in_sight);
    }
    let Found { design, step, mut stop, iterations, held, weak, judged_at } = found;
    if stop == Stop::Settled && is_less_likely(campaign, model, &step, settings)? {
        stop = Stop::LessLikely;
    }
    let record = Convergence { converged: stop == Stop::Settled, stop, iterations, linear, held, moved };
    Ok(Ended { design, step, record: Some(record), judged_at, weak })
}

/// Where deviations act through what is estimated, their size follows the unknowns; steps, which take it as it is, may settle where it hides any misfit. Is twice
/// the logarithm of the likelihood less there than by the linear model at the reference point, by more than true values of all unknowns cost once in a thousand times?
fn is_less_likely(campaign: &Campaign, model: &Model, step: &Step, settings: &Settings) -> Result<bool> {
    let follows = |line: &Scatter| matches!(line.of, Deviating::Joint(_) | Deviating::Parameter(_));
    let Some(found) = step.own.scattered.as_ref().filter(|_| campaign.scatter.iter().any(follows)) else {
        return Ok(false);
    };
    let first = step::solve(campaign, &design::assemble(campaign, model, &campaign.reference_point())?, settings)?;
    let alike = |first: &Scattered| first.estimate.unknowns.rank == found.estimate.unknowns.rank;
    let most = chi_square_quantile(1.0 - quality::ALPHA, found.estimate.unknowns.rank as f64);
    let first = first.own.scattered.filter(alike).zip(most);
    Ok(first.is_some_and(|(first, most)| found.deviance - first.deviance > most))
}

/// What leads from a start to a solution.
struct Trip<'a> {
    campaign: &'a Campaign,
    model: &'a Model,
    settings: &'a Settings,
}

/// Where Gauss-Newton ended from one start.
struct Found {
    design: DesignMatrix,
    step: Step,
    stop: Stop,
    iterations: Vec<Iteration>,
    held: Vec<usize>,
    weak: Vec<usize>,
    judged_at: Option<Vec<f64>>,
}

impl Trip<'_> {
    /// Walk from a design; `moved` are unknowns that were moved off zero to get there.
    ///
    /// Unknowns that the design does not determine, or that come into sight only on the way, take part as long as that leads to a solution
    /// at which the model is near enough to linear within their uncertainty; else they are held.
    fn from(&self, mut design: DesignMatrix, mut first: Linear, moved: &[usize]) -> Result<Found> {
        let Trip { campaign, model, settings } = *self;
        let unknowns = campaign.unknowns();
        let holdable = campaign.constraints.is_empty();
        let mut walk =
            Walk { campaign, model, settings, rank: 0, couplings: Vec::new(), holds: false, iterations: Vec::new() };
        // a factor that the first steps find brings what it multiplies into sight: the rank is judged from there
        let mut late: Vec<usize> = moved.to_vec();
        let mut unseen = starts::unseen(campaign, &design);
        while !unseen.is_empty() && holdable {
            let size = first.merit(&values(&design, &first.system)).sqrt();
            let before = first.merit(&first.system.observed);
            let (share, Some(next)) = walk.descend(&design, &first, before, size)? else { break };
            let now = starts::unseen(campaign, &next);
            if now.len() >= unseen.len() {
                break;
            }
            let Ok(adjusted) = Linear::at(campaign, &next, Some(&first), settings) else { break };
            walk.iterations.push(Iteration { sum_of_squares: before, step: first.length(), share });
            late.extend(unseen.iter().filter(|k| !now.contains(k) && !moved.contains(k)));
            (design, first, unseen) = (next, adjusted, now);
        }
        // made anew where the walk comes back to it: of many readings a second design is large
        let reference = design.point.clone();
        let before_walk = walk.iterations.clone();
        walk.rank = first.rank;
        if walk.rank < unknowns && holdable {
            walk.couplings = step::solve(campaign, &design, settings)?.own.estimate.factor.couplings();
        }
        let (mut design, mut stop) = walk.go(design, first)?;
        let settled = stop == Some(Stop::Settled);
        let (mut judged_at, mut too_weak) = (None, Vec::new());
        if holdable {
            let mut asked = late;
            if settled {
                asked.extend(walk.couplings.iter().map(|own| own.unknown));
            }
            let back = if settled { None } else { Some(design.at(campaign, model, &reference)?) };
            let at = back.as_ref().unwrap_or(&design);
            let weak = starts::weak(campaign, model, at, &asked, moved, settings)?;
            if !weak.is_empty() || stop.is_none() {
                // beyond the reference point the readings would determine more, but too weakly
                walk.couplings.retain(|own| !settled || unseen.contains(&own.unknown) || weak.contains(&own.unknown));
                for k in weak {
                    if walk.couplings.iter().all(|own| own.unknown != k) {
                        too_weak.push(k);
                        // its column is none on the way, so that steps leave it where it is
                        walk.couplings.push(Coupling { unknown: k, follows: Vec::new() });
                    }
                }
                (walk.holds, walk.iterations) = (true, before_walk);
                let mut held = design.at(campaign, model, &reference)?;
                judged_at = Some(held.point.clone());
                walk.hold(&mut held);
                let first = Linear::at(campaign, &held, None, settings)?;
                (design, stop) = walk.go(held, first)?;
            }
        }
        for k in too_weak.iter().filter(|k| moved.contains(k)) {
            // which of the others it goes with is seen at the solution
            let full = design.at(campaign, model, &design.point)?;
            let column = full.jacobian.col_as_slice(*k);
            design.jacobian.col_as_slice_mut(*k).copy_from_slice(column);
            let coupling = starts::follow(campaign, &design, *k, true, settings)?;
            starts::hold(&mut design, &coupling);
        }
        let mut step = step::solve(campaign, &design, settings)?;
        // on the way scales follow the steps, and may stay where they were far away: what is solved here leads on then
        while stop == Some(Stop::Settled) && moves(&step) && walk.iterations.len() < settings.iterations {
            let first = Linear::after(campaign, &design, step);
            (design, stop) = walk.go(design, first)?;
            step = step::solve(campaign, &design, settings)?;
        }
        // nothing else ended the walk
        let stop = match stop.unwrap_or(Stop::Stalled) {
            Stop::Settled if !step.own.settled => Stop::Unsettled,
            stop => stop,
        };
        let held = walk.couplings.iter().map(|own| own.unknown).filter(|k| walk.holds && !unseen.contains(k)).collect();
        Ok(Found { design, step, stop, iterations: walk.iterations, held, weak: too_weak, judged_at })
    }
}

/// Does a step with scales of its own move an estimate by more than its uncertainty? (Where scales have two optima near one another it moves by less, to and fro.)
fn moves(step: &Step) -> bool {
    let several = step.own.scattered.is_none() && step.own.estimate.group_iterations > 0;
    let variance =
        |k: usize| if k < step.own.noise.covariance.nrows() { step.own.noise.covariance[(k, k)] } else { 0.0 };
    several && step.change.iter().enumerate().any(|(k, dx)| variance(k) > 0.0 && dx * dx > variance(k))
}

impl Found {
    /// Is this the solution rather than the other: one where the other is none, or a better fit?
    fn is_better_than(&self, other: &Found, campaign: &Campaign) -> bool {
        /// A difference of twice the log likelihood that is not rounding.
        const MATTERS: f64 = 1e-3;
        let (own, others) = (self.stop == Stop::Settled, other.stop == Stop::Settled);
        if own != others {
            return own;
        }
        let (fit, before) = (self.misfit(campaign), other.misfit(campaign));
        let rank = (self.step.own.estimate.unknowns.rank, other.step.own.estimate.unknowns.rank);
        fit < before - MATTERS || (rank.0 > rank.1 && fit <= before + MATTERS)
    }

    /// Twice the negative logarithm of the likelihood, but for a constant; residuals of the size of rounding are none.
    fn misfit(&self, campaign: &Campaign) -> f64 {
        let system = &self.step.system;
        let least = rounding(campaign, &self.design, system);
        let mut known = 0.0;
        let mut groups: Vec<(f64, f64)> = vec![(0.0, 0.0); least.len()];
        for ((v, u), group) in self.step.own.estimate.residuals.iter().zip(&system.u).zip(&system.group) {
            let square = (v / u) * (v / u);
            match group {
                Group::Known => known += square,
                Group::Estimated(g) => {
                    if let Some(own) = groups.get_mut(*g) {
                        *own = (own.0 + 1.0, own.1 + square);
                    }
                }
            }
        }
        let of =
            |((n, sum), least): (&(f64, f64), &f64)| n * sum.max(4.0 * n * least * least).max(f64::MIN_POSITIVE).ln();
        known + groups.iter().zip(&least).map(of).sum::<f64>()
    }
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
        while self.iterations.len() < self.settings.iterations && self.halvings() < HALVINGS * self.settings.iterations
        {
            let before = step.merit(&step.system.observed);
            let length = step.length();
            let size = step.merit(&values(&design, &step.system)).sqrt();
            let noise = step.merit(&step.residuals).sqrt();
            let rows = (step.residuals.len().max(1) as f64).sqrt();
            let rounding = length <= ROUNDING * noise / rows
                && self.iterations.last().is_some_and(|own| own.share == 1.0 && length > 0.5 * own.step);
            let small = length <= NEGLIGIBLE * size || length <= INVISIBLE * noise || rounding;
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
            let next = design.at(self.campaign, self.model, &point)?;
            let mut next = circles_within_half_a_turn(self.campaign, self.model, next)?;
            let after = step.merit(&differences(self.campaign, &next)?);
            // rounding of a sum of squares near its minimum must not halve a good step
            let better = after <= before * (1.0 + 1e-10) + (NEGLIGIBLE * size).powi(2);
            if after.is_finite() && (better || !feasible) {
                self.hold(&mut next);
                return Ok((share, Some(next)));
            }
            // a long way to go is gone in long steps: every trial predicts all readings
            share *= if share > 0.05 { 0.5 } else { 0.1 };
        }
        Ok((share, None))
    }

    /// How often steps were halved so far.
    fn halvings(&self) -> usize {
        self.iterations.iter().map(Iteration::halvings).sum()
    }

    /// Neither the fit has become better of late, nor the steps shorter.
    fn is_stalled(&self, now: f64, length: f64) -> bool {
        let mut spent = 0;
        let long_ago = self.iterations.iter().rev().find(|own| {
            spent += 1 + own.halvings();
            spent >= PATIENCE
        });
        let Some(then) = long_ago else { return false };
        now > then.sum_of_squares * (1.0 - PROGRESS) && length > 0.5 * then.step
    }

    /// Unknowns that are held keep following the others as they do at the reference point, so that they stay outside the basis.
    fn hold(&self, design: &mut DesignMatrix) {
        if !self.holds {
            return;
        }
        self.couplings.iter().for_each(|coupling| starts::hold(design, coupling));
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
        let value = design.point.at(k);
        let within = value - turn * (value / turn).round();
        for other in [(0.5 * turn).copysign(within) - within, within] {
            let smaller = other.abs() < value.abs().min(0.5 * turn * (1.0 + SAME)) && other != value;
            if !free || value.abs() <= 0.25 * turn || !smaller {
                continue;
            }
            let mut point = design.point.clone();
            point.get_mut(k).into_iter().for_each(|slot| *slot = other);
            let moved = design.at(campaign, model, &point)?;
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
        let at = |list: &[f64]| list.at(i);
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
