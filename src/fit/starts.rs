//! Points beside a saddle to start from, and unknowns that the model determines only away from the point where it is linearised.
//!
//! In a bilinear line, `kI*(w_I + dtheta*w_S)` with neither factor known, the derivative by one factor is the other: where both are zero no
//! reading responds to either, though another value of one brings the other into sight. The rank is a fact of a point, not of the bench.

use super::Settings;
use super::step::{self, Linear};
use crate::campaign::{Campaign, Kind, Parameter, Role};
use crate::design::{DesignMatrix, Model};
use crate::elements::Elements;
use crate::error::Result;
use crate::estimate::Coupling;

/// A start away from a point at which unknowns are out of sight.
pub(super) struct Start {
    pub design: DesignMatrix,
    /// Unknowns that were moved to get there.
    pub moved: Vec<usize>,
}

/// Starts that are tried beside a saddle: signs of the moved unknowns, by turns.
const SIGNS: [[f64; 2]; 3] = [[1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
/// By how much a tilt is moved, rad: a usual misalignment, so that products come out as they do for small angles where a factor stays free.
/// A coefficient is moved by one of its unit.
const TILT: f64 = 5e-4;
/// Readings hardly respond to a tilt where they do so by less than this share of their response once the coefficients are known: not a scale factor that
/// is a little off, but one that is missing.
const HARDLY: f64 = 0.1;
/// Where the second order is more than this share of the first within one standard uncertainty, an unknown is not determined: for a
/// derivative that grows in proportion to the distance from a saddle, that is a standard uncertainty as large as the distance.
const LINEAR: f64 = 0.5;

/// Estimated parameters to which no reading and no prior responds at a design's point.
pub(super) fn unseen(campaign: &Campaign, design: &DesignMatrix) -> Vec<usize> {
    let is_free = |k: usize| {
        campaign.parameters.get(k).is_some_and(|own| matches!(own.role, Role::Estimated { prior: None, .. }))
    };
    let is_zero = |k: usize| design.jacobian.col_as_slice(k).iter().all(|slope| *slope == 0.0);
    (0..campaign.unknowns()).filter(|k| is_free(*k) && is_zero(*k)).collect()
}

/// The coefficients that fit best while the tilts keep their values, as a start, where the readings of some sensor respond to a tilt there far more than at `design`;
/// `None` elsewhere.
///
/// In `k*a_I + kx*a_I*a_S` with nothing known of `k`, the derivatives by the tilts at `k = 0` are those of the small second term: the first step
/// would explain the readings by tilts of many degrees, and lead to another minimum.
pub(crate) fn by_coefficients(
    campaign: &Campaign,
    model: &Model,
    design: &DesignMatrix,
    settings: &Settings,
) -> Result<Option<DesignMatrix>> {
    let estimated = || campaign.estimated().iter().enumerate();
    let is_tilt = |own: &Parameter| own.kind == Kind::Tilt;
    let is_open = |own: &Parameter| matches!(own.role, Role::Estimated { start: None, prior: None });
    let tilts: Vec<usize> = estimated().filter(|(_, own)| is_tilt(own)).map(|(k, _)| k).collect();
    if tilts.is_empty() || !estimated().any(|(_, own)| !is_tilt(own) && is_open(own)) {
        return Ok(None);
    }
    let mut point = design.point.clone();
    {
        // a design of many readings is large
        let mut held = design.clone();
        tilts.iter().for_each(|k| held.jacobian.col_as_slice_mut(*k).fill(0.0));
        let alone = if campaign.scatter.is_empty() { None } else { Some(campaign.without_scatter()) };
        let step = Linear::at(alone.as_ref().unwrap_or(campaign), &held, None, settings)?;
        for (k, (value, change)) in point.iter_mut().zip(&step.change).enumerate() {
            *value += if tilts.contains(&k) { 0.0 } else { *change };
        }
    }
    let there = design.at(campaign, model, &point)?;
    let size = |of: &DesignMatrix, k: usize, sensor: usize| {
        let rows = of.jacobian.col_as_slice(k).iter().zip(&of.rows).filter(|(_, origin)| origin.sensor == sensor);
        rows.map(|(x, _)| x * x).sum::<f64>().sqrt()
    };
    let grows = |k: &usize, sensor: usize| {
        let here = size(design, *k, sensor);
        here > 0.0 && here < HARDLY * size(&there, *k, sensor)
    };
    let finite = there.predicted.iter().all(|value| value.is_finite());
    let sensors = 0..campaign.bench.sensors.len();
    Ok((finite && tilts.iter().any(|k| sensors.clone().any(|sensor| grows(k, sensor)))).then_some(there))
}

/// Starts from which readings respond to some of the unknowns that are out of sight; none where no such start is found.
pub(super) fn beside(
    campaign: &Campaign,
    model: &Model,
    design: &DesignMatrix,
    unseen: &[usize],
) -> Result<Vec<Start>> {
    let mut starts = Vec::new();
    if unseen.is_empty() {
        return Ok(starts);
    }
    for signs in SIGNS {
        let mut point = design.point.clone();
        for (i, k) in unseen.iter().enumerate() {
            let tilt = campaign.parameters.get(*k).is_some_and(|own| own.kind == Kind::Tilt);
            // sizes that differ, so that none is another's by accident
            let spread = 1.0 + 0.5 * (0.618_034 * i as f64).fract();
            let size = if tilt { TILT } else { 1.0 } * spread * signs.at(i % 2);
            if let Some(value) = point.get_mut(*k) {
                *value += size;
            }
        }
        let still = self::unseen(campaign, &design.at(campaign, model, &point)?);
        let moved: Vec<usize> = unseen.iter().copied().filter(|k| !still.contains(k)).collect();
        if moved.is_empty() {
            break;
        }
        for k in unseen.iter().filter(|k| still.contains(k)) {
            if let (Some(value), Some(before)) = (point.get_mut(*k), design.point.get(*k)) {
                *value = *before;
            }
        }
        let design = design.at(campaign, model, &point)?;
        let finite = design.predicted.iter().all(|value| value.is_finite());
        if finite {
            starts.push(Start { design, moved });
        }
    }
    Ok(starts)
}

/// Those of `asked` that the readings determine at this point only so far that the model is not linear within a standard uncertainty.
pub(super) fn weak(
    campaign: &Campaign,
    model: &Model,
    design: &DesignMatrix,
    asked: &[usize],
    moved: &[usize],
    settings: &Settings,
) -> Result<Vec<usize>> {
    let mut found: Vec<usize> = Vec::new();
    if asked.is_empty() {
        return Ok(found);
    }
    let mut held = design.clone();
    while found.len() < asked.len() {
        let step = step::solve(campaign, &held, settings)?;
        if !step.own.noise.determined {
            break;
        }
        let u = step.own.estimate.row_u(&step.system);
        let mut worst: Option<(f64, usize)> = None;
        for k in asked.iter().copied().filter(|k| !found.contains(k)) {
            let variance = if k < step.own.noise.covariance.nrows() { step.own.noise.covariance[(k, k)] } else { 0.0 };
            if !step.own.estimate.unknowns.is_estimable(k) || !(variance > 0.0) {
                continue;
            }
            let along: Vec<f64> =
                (0..campaign.unknowns()).map(|j| step.own.noise.covariance[(j, k)] / variance.sqrt()).collect();
            let curved = curvature(campaign, model, &held, &along, &u)?;
            // of two that are free together a coefficient is held rather than an angle
            let tilt = campaign.parameters.get(k).is_some_and(|own| own.kind == Kind::Tilt);
            let curved = if tilt { curved } else { curved * (1.0 + 1e-6) };
            if curved > LINEAR && worst.is_none_or(|(before, _)| curved > before) {
                worst = Some((curved, k));
            }
        }
        let Some((_, k)) = worst else { break };
        let coupling = follow(campaign, &held, k, moved.contains(&k), settings)?;
        hold(&mut held, &coupling);
        found.push(k);
    }
    Ok(found)
}

/// Share of the second order in the change of the weighted predictions along a step; infinite where a prediction leaves the numbers.
fn curvature(campaign: &Campaign, model: &Model, design: &DesignMatrix, along: &[f64], u: &[f64]) -> Result<f64> {
    let beside = |sign: f64| {
        let mut point = design.point.clone();
        point.iter_mut().zip(along).for_each(|(x, dx)| *x += sign * dx);
        design.at(campaign, model, &point)
    };
    let (up, down) = (beside(1.0)?, beside(-1.0)?);
    let (mut first, mut second) = (0.0, 0.0);
    for (i, u) in u.iter().enumerate().take(design.predicted.len()) {
        let slope: f64 = along.iter().enumerate().map(|(j, dx)| design.jacobian[(i, j)] * dx).sum();
        let (Some(up), Some(here), Some(down)) = (up.predicted.get(i), design.predicted.get(i), down.predicted.get(i))
        else {
            continue;
        };
        first += (slope / u).powi(2);
        second += ((up + down - 2.0 * here) / u).powi(2);
    }
    let share = (second / first).sqrt() / 2.0;
    Ok(if share.is_finite() { share } else { f64::INFINITY })
}

/// How the column of an unknown that is to be held follows the others: as a moved one's does here, as far as its own standard uncertainty moves another by more
/// than `LINEAR` of that one's; one that was out of sight at the reference point stays so.
pub(super) fn follow(
    campaign: &Campaign,
    design: &DesignMatrix,
    unknown: usize,
    moved: bool,
    settings: &Settings,
) -> Result<Coupling> {
    if !moved {
        return Ok(Coupling { unknown, follows: Vec::new() });
    }
    let mut others = design.clone();
    let column = others.jacobian.col_as_slice(unknown).to_vec();
    others.jacobian.col_as_slice_mut(unknown).fill(0.0);
    let step = step::solve(campaign, &others, settings)?;
    let mut observed = column;
    observed.resize(step.system.observed.len(), 0.0);
    let follows = step.own.estimate.factor.solve(&observed)?;
    // what no other unknown does tells of this one
    let own = |i: usize| -> f64 {
        observed.at(i) - follows.iter().enumerate().map(|(j, c)| c * step.system.rows[(i, j)]).sum::<f64>()
    };
    let u = step.own.estimate.row_u(&step.system);
    let told: f64 = u.iter().enumerate().map(|(i, u)| (own(i) / u).powi(2)).sum();
    let u_of = |j: usize| step.own.noise.covariance[(j, j)].max(0.0).sqrt();
    let matters = |(j, c): &(usize, f64)| {
        *j != unknown && *c != 0.0 && !(step.own.noise.determined && c.abs() <= LINEAR * u_of(*j) * told.sqrt())
    };
    let follows = follows.into_iter().enumerate().filter(matters).collect();
    Ok(Coupling { unknown, follows })
}

/// Let the column of a held unknown follow the others, so that it stays outside the basis.
pub(super) fn hold(design: &mut DesignMatrix, coupling: &Coupling) {
    for i in 0..design.jacobian.nrows() {
        design.jacobian[(i, coupling.unknown)] =
            coupling.follows.iter().map(|(j, c)| c * design.jacobian[(i, *j)]).sum();
    }
}
