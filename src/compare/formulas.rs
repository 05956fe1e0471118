//! The formulas on one group of readings: symbols first, then each formula with the results of those before it.

use super::closed_forms::{ClosedForms, Criterion, Symbol, column};
use crate::algebra::{Scratch, Tape};
use crate::campaign::{Campaign, JointState, Reading, Readings, Role};
use crate::error::Result;

/// Every formula's value on the readings of one group, in the order of the formulas; `None` where a position that it needs was not read.
///
/// Formulas may use the symbols, the group's value, the known parameters, `g` (specific force at rest), `earth_north`,
/// `earth_up` (Earth rate), in the bench's units, and the formulas before them. A quantity that the campaign knows or assumes to be zero is not computed: the formulas after it use that value.
pub fn evaluate(
    campaign: &Campaign,
    forms: &ClosedForms,
    group: Option<f64>,
    subset: &Readings,
) -> Result<Vec<Option<f64>>> {
    let earth = campaign.bench.earth_rate();
    let mut names: Vec<String> = ["g", "earth_north", "earth_up"].map(String::from).into();
    let mut values: Vec<Option<f64>> = [campaign.bench.specific_force().norm(), earth.y, earth.z].map(Some).into();
    if let Some(grouping) = &forms.group {
        names.push(grouping.symbol.clone());
        values.push(group);
    }
    for symbol in &forms.symbols {
        names.push(symbol.name.clone());
        values.push(mean(campaign, symbol, subset)?);
    }
    let mut given: Vec<&str> = Vec::new();
    for parameter in &campaign.parameters {
        let value = match parameter.role {
            Role::Known(known) => known.value,
            Role::AssumedZero => 0.0,
            Role::Estimated { .. } => continue,
        };
        given.push(&parameter.id);
        names.push(parameter.id.clone());
        values.push(Some(value));
    }
    let mut results = Vec::new();
    for (id, formula) in &forms.formulas {
        if given.contains(&id.as_str()) {
            results.push(None);
            continue;
        }
        let borrowed: Vec<&str> = names.iter().map(String::as_str).collect();
        let usable = formula
            .names()
            .iter()
            .all(|name| names.iter().position(|n| n == name).and_then(|k| values.get(k)).is_some_and(Option::is_some));
        let value = if usable {
            // those that the formula uses have values, see above
            let inputs: Vec<f64> = values.iter().map(|v| v.unwrap_or_default()).collect();
            let value = Tape::compile(formula, &borrowed)?.value(&inputs, &mut Scratch::default());
            value.is_finite().then_some(value)
        } else {
            None
        };
        results.push(value);
        names.push(id.clone());
        values.push(value);
    }
    Ok(results)
}

/// The mean of a symbol's line over the readings that match it; `None` where none does.
fn mean(campaign: &Campaign, symbol: &Symbol, subset: &Readings) -> Result<Option<f64>> {
    let names = symbol.mean_of.names();
    let tape = Tape::compile(&symbol.mean_of, &names)?;
    let mut scratch = Scratch::default();
    let (mut sum, mut count) = (0.0, 0.0);
    for reading in &subset.rows {
        if !symbol.criteria.iter().all(|(key, criterion)| matches(campaign, reading, key, *criterion)) {
            continue;
        }
        let inputs: Option<Vec<f64>> = names.iter().map(|name| input(campaign, reading, name)).collect();
        if let Some(inputs) = inputs {
            sum += tape.value(&inputs, &mut scratch);
            count += 1.0;
        }
    }
    Ok((count > 0.0).then(|| sum / count))
}

/// What a name means at a reading: a sensor's value, a held joint's angle in radians, or a numeric column.
fn input(campaign: &Campaign, reading: &Reading, name: &str) -> Option<f64> {
    if let Some(sensor) = campaign.bench.sensors.iter().position(|s| s.id == name) {
        return reading.observations.iter().find(|o| o.sensor == sensor).map(|o| o.value);
    }
    if let Some(joint) = campaign.bench.joints().position(|joint| joint == name) {
        return match reading.joints.get(joint)? {
            JointState::Held { angle_deg } => Some(angle_deg.to_radians()),
            _ => None,
        };
    }
    column(campaign, reading, name)
}

fn matches(campaign: &Campaign, reading: &Reading, key: &str, criterion: Criterion) -> bool {
    match (column(campaign, reading, key), criterion) {
        (value, Criterion::Absent) => value.is_none(),
        (None, _) => false,
        (Some(value), Criterion::Positive) => value > 0.0,
        (Some(value), Criterion::Negative) => value < 0.0,
        (Some(value), Criterion::Equal(wanted)) => {
            let difference = value - wanted;
            let turn = if key.ends_with("_deg") { (difference / 360.0).round() * 360.0 } else { 0.0 };
            (difference - turn).abs() < 1e-9
        }
    }
}
