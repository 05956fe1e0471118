//! What estimates owe to the values at which something that is not estimable is held.
//!
//! To the first order nothing: no reading changes along a free direction, and an estimable parameter has no part in it. In the second order a
//! scale factor changes with a mounting angle that hides in an installation error, and its uncertainty does not contain that.

use super::parameters::ParameterResult;
use super::scatter::own_system;
use super::{Settings, State, step, weigh};
use crate::campaign::{Campaign, Kind};
use crate::design::{self, DesignMatrix, Model};
use crate::elements::Elements;
use crate::error::Result;
use crate::estimate::{self, Estimate, ScaleHints, Scattered};
use crate::units::ARCSEC;
use std::collections::BTreeMap;

/// A closed circle that disagrees with the others.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "CircleReport")]
pub struct Circle {
    /// The sensor.
    pub sensor: String,
    /// Mean residual of its readings, in its unit.
    pub mean_residual: f64,
    /// The same in degrees.
    pub mean_residual_deg: f64,
}

/// What depends on the value at which a parameter is held that is not estimable.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "ConditionalReport")]
pub struct Conditional {
    /// The parameter that is held.
    pub held: String,
    /// Another value of it was tried: so far away, in `unit`, what it hides in following.
    pub by: f64,
    /// Unit of `by`.
    pub unit: String,
    /// Which estimates change by more than a tenth of their standard uncertainty, and by how many of it.
    pub shifts: BTreeMap<String, f64>,
}

/// A tilt is moved by this, rad; where none takes part, coefficients by this share of themselves.
const MOVED: f64 = 1e-3;
/// Shifts below this share of the standard uncertainty are not listed.
const SHIFT: f64 = 0.1;
/// More directions than this, or more rows, are not tried.
const MOST: usize = 12;
const MOST_ROWS: usize = 50_000;

/// Move along each free direction both ways, fit the rest again there by one step, and see what has changed.
pub(super) fn conditional(
    campaign: &Campaign,
    model: &Model,
    point: &[f64],
    (estimate, scattered): (&Estimate, Option<&Scattered>),
    parameters: &[ParameterResult],
    settings: &Settings,
) -> Result<Vec<Conditional>> {
    let mut found = Vec::new();
    let defects = &estimate.unknowns.free_directions;
    let rows = campaign.readings.rows.len() * campaign.bench.sensors.len();
    if defects.is_empty() || defects.len() > MOST || rows > MOST_ROWS || !campaign.constraints.is_empty() {
        return Ok(found);
    }
    let basis = estimate.factor.basis();
    let outside: Vec<usize> = (0..campaign.unknowns()).filter(|k| !basis.contains(k)).collect();
    let is_tilt = |k: &usize| campaign.parameters.get(*k).is_some_and(|own| own.kind == Kind::Tilt);
    let id = |k: usize| campaign.parameter_id(k).to_string();
    for direction in defects {
        let Some(held) = direction.terms.iter().map(|(k, _)| *k).find(|k| outside.contains(k)) else { continue };
        let tilts = direction.terms.iter().filter(|(k, _)| is_tilt(k)).map(|(_, c)| c.abs());
        let steepest = tilts.fold(0.0_f64, f64::max);
        let size = |(k, c): &(usize, f64)| point.get(*k).map_or(0.0, |x| (x / c).abs());
        let length = if steepest > 0.0 {
            MOVED / steepest
        } else {
            MOVED * direction.terms.iter().map(size).filter(|x| x.is_finite()).fold(0.0_f64, f64::max)
        };
        if length == 0.0 {
            continue;
        }
        let mut shifts: BTreeMap<usize, f64> = BTreeMap::new();
        for sign in [1.0, -1.0] {
            let mut moved = point.to_vec();
            for (k, c) in &direction.terms {
                if let Some(x) = moved.get_mut(*k) {
                    *x += sign * length * c;
                }
            }
            let mut design = design::assemble(campaign, model, &moved)?;
            for k in &outside {
                design.jacobian.col_as_slice_mut(*k).fill(0.0);
            }
            let again = match scattered {
                Some(found) => with_variances(campaign, &design, found, settings),
                None => step::solve(campaign, &design, settings).map(|step| step.change),
            };
            let Ok(again) = again else { continue };
            for (k, result) in parameters.iter().enumerate().filter(|(_, own)| own.state != State::NotEstimable) {
                let Some(u) = result.uncertainty.map(|own| own.u).filter(|u| *u > 0.0) else { continue };
                let along = direction.terms.iter().find(|(j, _)| *j == k).map_or(0.0, |(_, c)| sign * length * c);
                let share = (again.at(k) + along).abs() / u;
                shifts.entry(k).and_modify(|before| *before = before.max(share)).or_insert(share);
            }
        }
        shifts.retain(|_, share| *share > SHIFT && share.is_finite());
        let by = direction.terms.iter().find(|(k, _)| *k == held).map_or(0.0, |(_, c)| (length * c).abs());
        if !shifts.is_empty() {
            let (scale, unit) = match campaign.parameters.get(held) {
                Some(own) if own.kind == Kind::Tilt => (ARCSEC, "arcsec".into()),
                _ => (1.0, campaign.parameter_unit(held).to_string()),
            };
            let shifts = shifts.into_iter().map(|(k, share)| (id(k), share)).collect();
            found.push(Conditional { held: id(held), by: by * scale, unit, shifts });
        }
    }
    Ok(found)
}

/// The step from a design with the variances as they were found: they change no more than the estimates do.
fn with_variances(
    campaign: &Campaign,
    design: &DesignMatrix,
    found: &Scattered,
    settings: &Settings,
) -> Result<Vec<f64>> {
    let weighed = weigh(campaign, design, settings.weighting)?;
    let system = own_system(campaign, design, &weighed);
    let white = found.whitening.system(&system.rows, &system.observed);
    estimate::solve(&white, &ScaleHints::default(), &settings.adjust).map(|found| found.solution)
}
