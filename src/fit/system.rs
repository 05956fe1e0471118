//! From a design matrix and readings to the weighted system: one row for each value, then one for each prior.

use super::resolution;
use crate::campaign::{Campaign, Observation};
use crate::design::{DesignMatrix, RowOrigin};
use crate::error::{Fault, Malformed, Result};
use crate::estimate::{Group, System};
use faer::Mat;

/// What the stated standard uncertainties of the readings mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Weighting {
    /// They are the standard uncertainties; where there are none, each sensor's is estimated from its residuals.
    #[default]
    AsStated,
    /// They are relative weights; each sensor's scale is estimated from its residuals (in geodesy: a posteriori).
    Relative,
}

/// The system of a campaign at the design's reference point.
///
/// `observed = value - prediction`; `u` as stated, or `1/sqrt(n)` for a mean of `n` samples whose scatter is to be estimated, one group for
/// each sensor. A prior is the row `1 * parameter = prior - reference`. Errors: a sensor whose `u` is stated only here and there; a row of the
/// design whose reading or sensor the campaign does not have, or did not read; a design at fewer values than there are unknowns.
pub fn weigh(campaign: &Campaign, design: &DesignMatrix, weighting: Weighting) -> Result<System> {
    let unknowns = campaign.unknowns();
    stated_throughout(campaign)?;
    let mut groups: Vec<Option<usize>> = vec![None; campaign.bench.sensors.len()];
    let length = design.rows.len() + unknowns;
    let (mut observed, mut u) = (Vec::with_capacity(length), Vec::with_capacity(length));
    let mut group = Vec::with_capacity(length);
    let mut next_group = 0;
    for (origin, predicted) in design.rows.iter().zip(&design.predicted) {
        let value = read(campaign, origin)?;
        observed.push(value.value - predicted);
        u.push(value.u.unwrap_or(1.0 / value.samples.sqrt())); // relative: the scale is estimated
        let known = value.u.is_some() && weighting == Weighting::AsStated;
        let slot = groups.get_mut(origin.sensor).ok_or_else(|| unread(campaign, origin))?;
        group.push(if known {
            Group::Known
        } else {
            Group::Estimated(*slot.get_or_insert_with(|| {
                next_group += 1;
                next_group - 1
            }))
        });
    }
    if design.point.len() < unknowns {
        return Err(Malformed::new(Fault::Value, format!("a design matrix at {} values", design.point.len()))
            .expected(format!("one for each of the {unknowns} unknowns")));
    }
    let priors: Vec<(usize, f64, f64)> = priors(campaign, design).collect();
    let readings = design.rows.len();
    let mut rows = Mat::zeros(readings + priors.len(), unknowns);
    for j in 0..unknowns.min(design.jacobian.ncols()) {
        let column = rows.col_as_slice_mut(j);
        column.iter_mut().zip(design.jacobian.col_as_slice(j)).for_each(|(own, slope)| *own = *slope);
        for (own, _) in column.iter_mut().skip(readings).zip(&priors).filter(|(_, (k, _, _))| *k == j) {
            *own = 1.0;
        }
    }
    for (_, difference, prior_u) in priors {
        observed.push(difference);
        u.push(prior_u);
        group.push(Group::Known);
    }
    Ok(System { rows, observed, u, group })
}

/// How the values follow the known inputs that have an uncertainty, in independent parts of unit variance, for [`System::with_inputs`]: the
/// derivatives at the design's point, times the uncertainties and the triangle of their correlations. `None` where none is uncertain.
pub(crate) fn known_inputs(campaign: &Campaign, design: &DesignMatrix) -> Option<Mat<f64>> {
    let uncertain = campaign.uncertain().filter(|(k, _)| *k < design.jacobian.ncols());
    let (known, u): (Vec<usize>, Vec<f64>) = uncertain.map(|(k, known)| (k, known.u)).unzip();
    if known.is_empty() {
        return None;
    }
    let root = campaign.correlation_root(&known);
    Some(independent(known.iter().map(|k| design.jacobian.col_as_slice(*k)), &u, &root))
}

/// Columns of inputs with these uncertainties, and the triangle of their correlations, in independent parts of unit variance.
pub(super) fn independent<'a>(columns: impl Iterator<Item = &'a [f64]>, u: &[f64], root: &[Vec<f64>]) -> Mat<f64> {
    let columns: Vec<&[f64]> = columns.collect();
    let mut parts = Mat::zeros(columns.first().map_or(0, |own| own.len()), columns.len());
    for ((column, u), row) in columns.iter().zip(u).zip(root) {
        for (j, share) in row.iter().enumerate().filter(|(_, share)| **share != 0.0) {
            parts.col_as_slice_mut(j).iter_mut().zip(*column).for_each(|(to, by)| *to += by * u * share);
        }
    }
    parts
}

/// What [`weigh`] makes of a design but for weights and derivatives: readings minus predictions, then priors minus the point.
///
/// Errors: a row of the design whose reading or sensor the campaign does not have, or did not read.
pub(super) fn differences(campaign: &Campaign, design: &DesignMatrix) -> Result<Vec<f64>> {
    let mut differences = Vec::with_capacity(design.rows.len() + campaign.unknowns());
    for (origin, predicted) in design.rows.iter().zip(&design.predicted) {
        differences.push(read(campaign, origin)?.value - predicted);
    }
    differences.extend(priors(campaign, design).map(|(_, difference, _)| difference));
    Ok(differences)
}

/// The value that a row of the design predicts.
fn read<'a>(campaign: &'a Campaign, origin: &RowOrigin) -> Result<&'a Observation> {
    let reading = campaign.readings.rows.get(origin.reading);
    let value = reading.and_then(|r| r.observations.iter().find(|o| o.sensor == origin.sensor));
    value.ok_or_else(|| unread(campaign, origin))
}

/// Priors: the unknown, how far its prior lies from the design's point, and its standard uncertainty.
fn priors(campaign: &Campaign, design: &DesignMatrix) -> impl Iterator<Item = (usize, f64, f64)> {
    campaign.priors().filter_map(|(k, value, u)| Some((k, value - design.point.get(k)?, u)))
}

/// The scale that the rounding of readings alone would have: two epsilons of the largest in units of its relative uncertainty, or where they have a last
/// decimal place `a/sqrt 3` of half a unit `a` of it (JCGM 100, F.2.2.1), over the largest of these uncertainties.
pub(crate) fn rounding_of(step: Option<f64>, (largest_in_u, largest_u): (f64, f64)) -> f64 {
    step.map_or(0.0, |step| step / 12f64.sqrt() / largest_u).max(2.0 * f64::EPSILON * largest_in_u)
}

/// For each estimated group, the scale that the rounding of its readings alone would have.
///
/// A campaign without noise has residuals of that size or none at all, and nothing better can be said of its scatter.
pub(super) fn rounding(campaign: &Campaign, design: &DesignMatrix, system: &System) -> Vec<f64> {
    // a sensor's rows are of one group
    let mut sensors: Vec<Option<(usize, f64, f64)>> = vec![None; campaign.bench.sensors.len()];
    for ((origin, group), u) in design.rows.iter().zip(&system.group).zip(&system.u) {
        if let (Group::Estimated(g), Some(slot)) = (group, sensors.get_mut(origin.sensor)) {
            let value = read(campaign, origin).map_or(0.0, |o| o.value.abs());
            let (_, value_in_u, largest) = slot.get_or_insert((*g, 0.0, 0.0));
            (*value_in_u, *largest) = (value_in_u.max(value / u), largest.max(*u));
        }
    }
    let mut least: Vec<f64> = Vec::new();
    for (s, (g, value_in_u, largest)) in sensors.iter().enumerate().filter_map(|(s, own)| Some((s, (*own)?))) {
        least.resize(least.len().max(g + 1), 0.0);
        let own = rounding_of(sensor_resolution(campaign, s), (value_in_u, largest));
        least.get_mut(g).into_iter().for_each(|least| *least = own);
    }
    least
}

/// The last decimal place of a sensor's readings; a reference is not rounded in each row.
pub(super) fn sensor_resolution(campaign: &Campaign, sensor: usize) -> Option<f64> {
    if campaign.bench.sensors.get(sensor)?.is_reference() {
        return None;
    }
    let readings = campaign.readings.rows.iter();
    resolution(readings.flat_map(|r| r.observations.iter().filter(|o| o.sensor == sensor).map(|o| o.value)))
}

/// A row of the design without a value in the campaign.
fn unread(campaign: &Campaign, origin: &RowOrigin) -> Malformed {
    let reading = campaign.readings.rows.get(origin.reading);
    let sensor = campaign.bench.sensors.get(origin.sensor).map_or("a sensor that the bench lacks", |s| s.id.as_str());
    Malformed::new(Fault::Missing, format!("a row of the design has no value of {sensor}"))
        .expected("a value for every row: the campaign that the design was assembled of")
        .found(format!("nothing in reading {} of {}", origin.reading + 1, campaign.readings.rows.len()))
        .at_path(reading.map_or(String::new(), |r| r.place.to_string()))
}

/// A sensor whose uncertainties are stated in some of its readings only.
pub(crate) fn stated_here_and_there(id: &str) -> Malformed {
    Malformed::new(Fault::Missing, format!("some readings of {id} have a stated uncertainty and some have none"))
        .expected(format!("{id}_u in every reading of {id}, or in none (then it is estimated from the residuals)"))
}

/// Are the uncertainties of each sensor stated in all of its readings, or in none?
fn stated_throughout(campaign: &Campaign) -> Result<()> {
    let mut stated: Vec<Option<bool>> = vec![None; campaign.bench.sensors.len()];
    for reading in &campaign.readings.rows {
        for observation in &reading.observations {
            let Some(slot) = stated.get_mut(observation.sensor) else { continue };
            let here = observation.u.is_some();
            if slot.is_some_and(|before| before != here) {
                let id = campaign.sensor_id(observation.sensor);
                return Err(stated_here_and_there(id)
                    .found(if here { format!("{id}_u here, and none before") } else { format!("no {id}_u here") })
                    .at_path(&reading.place));
            }
            *slot = Some(here);
        }
    }
    Ok(())
}
