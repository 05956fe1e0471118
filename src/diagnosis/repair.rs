//! The augmented model: a named effect becomes a term of the model, so that any fit can use it.

use super::assumptions;
use super::candidates::Candidate;
use crate::algebra::Expression;
use crate::campaign::Campaign;
use crate::error::Result;
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
                let rows: Vec<crate::design::RowOrigin> =
                    (0..readings.rows.len()).map(|reading| crate::design::RowOrigin { reading, sensor }).collect();
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
