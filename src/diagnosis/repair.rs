//! The augmented model: a named effect becomes a term of the model, so that any fit can use it; the effect's coefficient there, and what an estimate's
//! uncertainty has beyond the noise.

use super::assumptions;
use super::candidates::Candidate;
use super::noise::Weighted;
use super::score::Deviations;
use crate::algebra::Expression;
use crate::campaign::{Campaign, Kind, Parameter, coefficient_unit};
use crate::design::RowOrigin;
use crate::error::Result;
use crate::fit::Fit;
use crate::simulate::{Regressor, indicator};

/// The campaign with these effects in its model, and without the priors and constraints that are among them.
///
/// A term is appended to its sensor's line (`V0 + kI*w_I` becomes `V0 + kI*w_I + D_S*a_S`); a tilt, a known parameter or a coefficient
/// that was assumed zero is estimated; what no input says (a position, a reading, a direction of approach) becomes a column of the readings
/// and a term with it.
pub(super) fn repaired(campaign: &Campaign, effects: &[&Candidate]) -> Result<Campaign> {
    let campaign = &assumptions::freed(campaign, effects);
    let mut bench = campaign.bench.clone();
    let mut readings = campaign.readings.clone();
    let mut promoted: Vec<usize> = Vec::new();
    let mut added: Vec<String> = Vec::new();
    for effect in effects.iter().filter(|c| !assumptions::is_assumption(c)) {
        let term = match (&effect.kind, effect.existing) {
            (Regressor::Tilt(k) | Regressor::Known(k), _) => {
                promoted.push(*k);
                continue;
            }
            (_, Some(k)) => {
                promoted.push(k);
                continue;
            }
            (Regressor::Term(line), None) => line.clone(),
            (other, _) => {
                let column = format!("{}_here", effect.coefficient);
                // only what is in all sensors alike has none; its indicator is that of any
                let sensor = effect.sensor.unwrap_or_default();
                let rows: Vec<RowOrigin> =
                    (0..readings.rows.len()).map(|reading| RowOrigin { reading, sensor }).collect();
                let values = indicator(campaign, &rows, other, sensor);
                readings.columns.push(column.clone());
                for (reading, value) in readings.rows.iter_mut().zip(values) {
                    reading.columns = reading.columns.iter().copied().chain([Some(value)]).collect();
                }
                Expression::parse(&column)?
            }
        };
        if let Some(sensor) = effect.sensor.and_then(|k| bench.sensors.get_mut(k)) {
            let coefficient = Expression::parse(&effect.coefficient)?;
            sensor.model = sensor.model.plus(&coefficient.times(&term));
            added.push(effect.coefficient.clone());
        }
    }
    campaign.extended(bench, readings, &promoted, added)
}

/// Value, standard uncertainty and unit of an effect's coefficient, as the difference from a stated value where it has one.
pub(super) fn coefficient(
    campaign: &Campaign,
    repaired: &Campaign,
    after: &Fit,
    effect: &Candidate,
) -> (Option<f64>, Option<f64>, String) {
    let Some(result) = after.parameters.iter().find(|p| p.id == effect.coefficient) else {
        return (None, None, String::new());
    };
    let stated = campaign.parameter_index(&effect.coefficient).and_then(|k| campaign.parameters.get(k));
    let stated = stated.map_or(0.0, Parameter::reference);
    let unit = if result.kind == Kind::Tilt {
        "rad".to_string()
    } else if result.unit.is_empty() {
        let unit = coefficient_unit(&repaired.bench, &repaired.readings.columns, &effect.coefficient);
        // a line that leaves the unit open
        unit.unwrap_or_default()
    } else {
        result.unit.clone()
    };
    (result.value.map(|v| v - stated), result.uncertainty.as_ref().map(|c| c.u), unit)
}

/// Standard uncertainty of an estimate from what deviates beyond the noise that its covariance `C` has: `l = W^-1 R^-1 A C e_j` combines the
/// weighted rows as the fit does whose readings have the covariance `R`; `E[l'V l] - e_j' C A' R^-1 A C e_j` over all that may deviate.
pub(super) fn beyond_noise(fit: &Fit, weighted: &Weighted, deviations: &Deviations, index: usize) -> Option<f64> {
    let n = fit.covariance.nrows();
    if index >= n {
        return None;
    }
    let mut column = vec![0.0; weighted.weight.len()];
    for k in 0..n.min(fit.design.jacobian.ncols()) {
        let jacobian = fit.design.jacobian.col_as_slice(k);
        column.iter_mut().zip(jacobian).for_each(|(l, a)| *l += a * fit.covariance[(k, index)]);
    }
    let mut combination = weighted.whiten(&column);
    let mut counted = combination.iter().map(|l| l * l).sum();
    // noise that is not stated is not the same in the fit, where what deviates is noise, and in the score
    if weighted.floor.is_none() {
        let sd = fit.system.scaled_u(|g| fit.estimate.scale_or_one(g));
        counted = 0.0;
        for ((l, weight), sd) in combination.iter_mut().zip(&weighted.weight).zip(sd) {
            let whitened = *l / (weight * sd);
            counted += whitened * whitened;
            *l = whitened / (weight * sd);
        }
    }
    let extra = deviations.variance_of(&combination) - counted;
    (extra > 0.0 && extra.is_finite()).then(|| extra.sqrt())
}
