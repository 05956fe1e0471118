//! Which inputs the sensors of a unit determine, and which must be given with the readings.

use super::bound::{Bound, direction_of};
use super::calibration::{CalibratedLine, Calibration, LineInput, Quantity};
use crate::campaign::Campaign;
use crate::elements::Elements;
use crate::language::sentence;
use nalgebra::{DMatrix, Vector3};

/// A direction counts as determined where it is at least this share of the largest: far above rounding, far below any cross-axis sensitivity of use.
const INDEPENDENT: f64 = 1e-6;

/// Decide the inputs of a calibration that has its lines and parameters.
///
/// A sensor whose line follows a rate to first order is a gyro, else one that follows a specific force an accelerometer. Where the gyros (or
/// accelerometers) span three directions, the whole vector along x, y, z is solved for; otherwise the component along each sensor's main axis, the
/// one of its inputs that it follows most.
pub(super) fn choose(calibration: &mut Calibration, campaign: &Campaign) {
    let mut inputs = Vec::new();
    columns(calibration, campaign, &mut inputs);
    let bound: Vec<Option<Bound>> =
        calibration.lines.iter().map(|line| Bound::new(line, calibration, &inputs).ok()).collect();
    let (mut of_rate, mut of_force) = (Vec::new(), Vec::new());
    let mut idle = Vec::new();
    for (k, bound) in bound.iter().enumerate() {
        let Some(bound) = bound else {
            idle.push((k, sentence!("its-line-does-not-bind")));
            continue;
        };
        let (rate, force) = bound.slopes_at_zero(calibration, &inputs);
        let main =
            if rate.norm() > 0.0 { Some(Quantity::Rate) } else { (force.norm() > 0.0).then_some(Quantity::Force) };
        match main {
            Some(Quantity::Rate) if rate.norm().is_finite() => of_rate.push((k, rate)),
            Some(_) if force.norm().is_finite() => of_force.push((k, force)),
            Some(_) => idle.push((k, sentence!("its-line-has-no-slope-at-zero-input"))),
            None => idle.push((k, sentence!("its-line-follows-no-rate"))),
        }
    }
    for (quantity, group) in [(Quantity::Rate, &of_rate), (Quantity::Force, &of_force)] {
        solved(calibration, quantity, group, &mut inputs);
    }
    given(calibration, &mut inputs);
    for (k, why) in idle.into_iter().rev() {
        let line = calibration.lines.remove(k);
        calibration.left_out.insert(0, (line.sensor, why));
    }
    inputs.sort_by_key(|input| !input.solved);
    calibration.inputs = inputs;
}

fn columns(calibration: &Calibration, campaign: &Campaign, inputs: &mut Vec<LineInput>) {
    for line in &calibration.lines {
        for name in line.model.names() {
            let known = calibration.parameters.order.iter().any(|p| p == name) || inputs.iter().any(|i| i.name == name);
            if known || direction_of(line, name).is_some() {
                continue;
            }
            let column = campaign.readings.columns.iter().position(|c| c == name);
            let values: Vec<f64> = column.map_or(Vec::new(), |k| {
                campaign.readings.rows.iter().filter_map(|row| row.columns.get(k).copied().flatten()).collect()
            });
            let quantity = if column.is_some() { Quantity::Column } else { Quantity::Angle };
            inputs.push(LineInput {
                name: name.to_string(),
                quantity,
                unit: calibration.unit_of(quantity).into(),
                direction: None,
                solved: false,
                otherwise: Some(if values.is_empty() { 0.0 } else { values.iter().sum::<f64>() / values.len() as f64 }),
            });
        }
    }
}

/// The inputs that a group of gyros or accelerometers determines.
fn solved(calibration: &Calibration, quantity: Quantity, group: &[(usize, Vector3<f64>)], inputs: &mut Vec<LineInput>) {
    let prefix = if quantity == Quantity::Rate { "w_" } else { "a_" };
    let unit = |v: &Vector3<f64>| v / v.norm();
    let directions = DMatrix::from_fn(group.len().max(3), 3, |i, j| {
        group.get(i).map_or(0.0, |(_, v)| unit(v).as_slice().at(j)) // rows of zeros up to three
    });
    let singular = directions.singular_values();
    if group.len() >= 3 && singular.iter().all(|s| *s > INDEPENDENT * singular.max()) {
        for (axis, direction) in [("x", Vector3::x()), ("y", Vector3::y()), ("z", Vector3::z())] {
            inputs.push(along(calibration, format!("{prefix}{axis}"), quantity, direction, true));
        }
        return;
    }
    for (k, slope) in group {
        let Some(line) = calibration.lines.get(*k) else { continue };
        let names = line.model.names();
        let candidates = names.iter().filter(|name| name.starts_with(prefix)).filter_map(|name| {
            let direction = direction_of(line, name)?.1;
            Some(((*name).to_string(), direction, slope.dot(&direction).abs()))
        });
        if let Some((name, direction, _)) = candidates.max_by(|a, b| a.2.total_cmp(&b.2)) {
            add(inputs, line, along(calibration, name, quantity, direction, true));
        }
    }
}

/// Every other rate and force of the lines: those that the solved ones do not fix are to be given.
fn given(calibration: &Calibration, inputs: &mut Vec<LineInput>) {
    for line in &calibration.lines {
        for name in line.model.names() {
            if let Some((quantity, direction)) = direction_of(line, name) {
                add(inputs, line, along(calibration, name.to_string(), quantity, direction, false));
            }
        }
    }
}

/// A rate or force along a direction.
fn along(of: &Calibration, name: String, quantity: Quantity, direction: Vector3<f64>, solved: bool) -> LineInput {
    let (unit, otherwise) = (of.unit_of(quantity).into(), (!solved).then_some(0.0));
    LineInput { name, quantity, unit, direction: Some(direction.into()), solved, otherwise }
}

/// Add an input unless those of its quantity fix it already; where another sensor's axis of the same name points elsewhere, with the sensor's name.
fn add(inputs: &mut Vec<LineInput>, line: &CalibratedLine, mut input: LineInput) {
    let mut orthogonal = input.direction();
    let mut basis: Vec<Vector3<f64>> = Vec::new();
    for other in inputs.iter().filter(|other| other.quantity == input.quantity) {
        let mut v = other.direction();
        basis.iter().for_each(|b| v -= b * b.dot(&v));
        if v.norm() > INDEPENDENT {
            basis.push(v / v.norm());
        }
    }
    basis.iter().for_each(|b| orthogonal -= b * b.dot(&orthogonal));
    if orthogonal.norm() <= INDEPENDENT {
        return;
    }
    if inputs.iter().any(|other| other.name == input.name) {
        input.name = format!("{}_{}", input.name, line.sensor);
    }
    inputs.push(input);
}
