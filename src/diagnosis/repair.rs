//! The repair: a found effect becomes part of the model, visibly, so that any fit can use it.

use super::assumptions;
use super::candidate::Candidate;
use crate::algebra::Expression;
use crate::campaign::{Asked, Campaign, Deviating, Given, Role};
use crate::error::Result;
use crate::simulate::{Regressor, indicator};

/// The campaign with these effects in its model.
///
/// A term is appended to its sensor's line (`V0 + kI*w_I` becomes `V0 + kI*w_I + D_S*a_S`); a tilt, a known parameter or a coefficient
/// that was assumed zero is estimated; what no input says (a position, a reading, a direction of approach) becomes a column of the readings
/// and a term with it.
pub(super) fn repair(campaign: &Campaign, effects: &[&Candidate]) -> Result<Campaign> {
    let mut bench = campaign.bench.clone();
    let mut readings = campaign.readings.clone();
    let mut promoted: Vec<usize> = Vec::new();
    let mut added: Vec<String> = Vec::new();
    for effect in effects {
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
                    reading.columns.push(Some(value));
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
    let mut request = crate::campaign::Request::default();
    for (k, parameter) in campaign.parameters.iter().enumerate() {
        let unit = (!parameter.unit.is_empty()).then(|| parameter.unit.clone());
        match &parameter.role {
            Role::Estimated { start, prior } => {
                request.estimate.push((parameter.id.clone(), Asked { start: *start, prior: *prior, unit }));
            }
            Role::Known(known) if !promoted.contains(&k) => {
                request.known.push((parameter.id.clone(), Given { known: *known, unit }));
            }
            _ => {}
        }
    }
    for k in promoted {
        if let Some(parameter) = campaign.parameters.get(k) {
            let start = matches!(parameter.role, Role::Known(_)).then(|| parameter.reference());
            let unit = (!parameter.unit.is_empty()).then(|| parameter.unit.clone());
            request.estimate.push((parameter.id.clone(), Asked { start, prior: None, unit }));
        }
    }
    request.estimate.extend(added.into_iter().map(|id| (id, Asked::default())));
    let known = |name: &String| request.known.iter().any(|(id, _)| id == name);
    let stated = campaign.correlations.iter().filter(|(a, b, _)| known(a) && known(b));
    request.correlations = stated.cloned().collect();
    let mut repaired = Campaign::new(bench, request, readings)?;
    repaired.constraints = campaign.constraints.clone();
    repaired.derived = campaign.derived.clone();
    repaired.identity = campaign.identity.clone();
    for line in &campaign.scatter {
        let mut line = line.clone();
        if let Deviating::Parameter(k) = line.of {
            // parameters are in another order once some are estimated
            let id = campaign.parameters.get(k).map_or("", |p| p.id.as_str());
            match repaired.parameter_index(id) {
                Some(k) => line.of = Deviating::Parameter(k),
                None => continue,
            }
        }
        repaired.scatter.push(line);
    }
    Ok(repaired)
}

/// The campaign with these effects in its model, and without the priors and constraints that are among them.
pub(super) fn repaired(campaign: &Campaign, effects: &[&Candidate]) -> Result<Campaign> {
    let freed = assumptions::freed(campaign, effects);
    let terms: Vec<&Candidate> = effects.iter().filter(|c| !assumptions::is_assumption(c)).copied().collect();
    repair(&freed, &terms)
}
