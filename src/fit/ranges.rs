//! Numbers that squares of numbers would carry out of the range of a double, and model lines without a value: refused, with the place.

use crate::campaign::{Campaign, JointState, Place, Role, joint_keys};
use crate::design::{DesignMatrix, Model};
use crate::error::{Fault, Malformed, Result};

pub(crate) use crate::number::{LEAST, MOST};

/// Refuse readings, stated uncertainties, columns and parameters beyond the range in which a fit can be computed.
pub(crate) fn check(campaign: &Campaign) -> Result<()> {
    let too_large = |x: f64| x.abs() > MOST;
    let beyond = |what: String, value: f64, place: &dyn std::fmt::Display| {
        Err(Malformed::new(Fault::Value, format!("{what} is beyond the numbers that a fit can square"))
            .expected("units in which it lies between 1e-70 and 1e70")
            .found(format!("{value:e}"))
            .at_path(place.to_string()))
    };
    for (s, sensor) in campaign.bench.sensors.iter().enumerate() {
        let mut largest: Option<(f64, &Place)> = None;
        for reading in &campaign.readings.rows {
            for own in reading.observations.iter().filter(|own| own.sensor == s) {
                if too_large(own.value) {
                    return beyond(format!("a reading of {}", sensor.id), own.value, &reading.place);
                }
                if let Some(u) = own.u.filter(|u| too_large(*u) || (*u > 0.0 && *u < LEAST)) {
                    return beyond(format!("{}_u", sensor.id), u, &reading.place);
                }
                if largest.is_none_or(|(before, _)| own.value.abs() > before) {
                    largest = Some((own.value.abs(), &reading.place));
                }
            }
        }
        if let Some((value, place)) = largest.filter(|(value, _)| *value > 0.0 && *value < LEAST) {
            return beyond(format!("the largest reading of {}", sensor.id), value, place);
        }
    }
    for (k, column) in campaign.readings.columns.iter().enumerate() {
        let of = |reading: &crate::campaign::Reading| reading.columns.get(k).copied().flatten();
        if let Some(reading) = campaign.readings.rows.iter().find(|reading| of(reading).is_some_and(too_large)) {
            // it has the value that was found too large
            return beyond(format!("the column {column}"), of(reading).unwrap_or_default(), &reading.place);
        }
    }
    for reading in &campaign.readings.rows {
        for (joint, state) in campaign.bench.joints().zip(&reading.joints) {
            if let Some((_, value)) = state.given().find(|(_, x)| too_large(*x)) {
                return beyond(format!("the state of the joint {joint}"), value, &reading.place);
            }
        }
    }
    for parameter in &campaign.parameters {
        let values = match &parameter.role {
            Role::Known(known) => [Some(known.value), Some(known.u)],
            Role::Estimated { start, prior } => [*start, prior.as_ref().map(|prior| prior.value)],
            Role::AssumedZero => [None, None],
        };
        if let Some(value) = values.into_iter().flatten().find(|x| too_large(*x)) {
            let list = if matches!(parameter.role, Role::Known(_)) { "known" } else { "estimate" };
            return beyond(format!("the value of '{}'", parameter.id), value, &format!("{list}.{}", parameter.id));
        }
    }
    Ok(())
}

/// Refuse a model line that has no value, or no derivative, at the point where the fit begins: which reading, which term, of which inputs.
pub(crate) fn check_rows(campaign: &Campaign, model: &Model, design: &DesignMatrix) -> Result<()> {
    for (i, (origin, predicted)) in design.rows.iter().zip(&design.predicted).enumerate() {
        let bad = (0..campaign.parameters.len()).find(|k| !design.jacobian[(i, *k)].is_finite());
        if predicted.is_finite() && bad.is_none() {
            continue;
        }
        let Some(reading) = campaign.readings.rows.get(origin.reading) else { continue };
        let sensor = campaign.sensor_id(origin.sensor);
        let at = position(campaign, &reading.joints);
        if predicted.is_finite() {
            let id = bad.and_then(|k| campaign.parameters.get(k)).map_or("", |own| own.id.as_str());
            return Err(Malformed::new(
                Fault::Value,
                format!("the model line of {sensor} has no finite derivative by '{id}' at this reading{at}"),
            )
            .expected(format!("a \"start\" for '{id}' at which it has one (of tumble new: --start {id}=VALUE)"))
            .at_path(&reading.place));
        }
        let error =
            Malformed::new(Fault::Value, format!("the model line of {sensor} has no value at this reading{at}"));
        let error = match model.without_value(campaign, origin.reading, origin.sensor, &design.point) {
            None => error.expected("inputs for which every term is a finite number"),
            Some((term, inputs)) => {
                let inputs: Vec<String> = inputs.iter().map(|(name, value)| format!("{name} = {value}")).collect();
                error.expected("a finite number from every term").found(format!("{term} with {}", inputs.join(", ")))
            }
        };
        return Err(error.at_path(&reading.place));
    }
    Ok(())
}

/// An error that names no place gets that of the reading with the largest value.
pub(super) fn name_reading(campaign: &Campaign, error: Malformed) -> Malformed {
    if !error.place().path.is_empty() {
        return error;
    }
    let values =
        campaign.readings.rows.iter().flat_map(|reading| reading.observations.iter().map(move |own| (reading, own)));
    let Some((reading, own)) = values.max_by(|a, b| a.1.value.abs().total_cmp(&b.1.value.abs())) else { return error };
    let sensor = campaign.sensor_id(own.sensor);
    error.found(format!("a largest reading {sensor} = {:e}", own.value)).at_path(&reading.place)
}

/// `, alpha_deg = 90`: where the joints are.
fn position(campaign: &Campaign, joints: &[JointState]) -> String {
    joint_keys(campaign.bench.joints(), joints).map(|(key, value)| format!(", {key} = {value}")).collect()
}
