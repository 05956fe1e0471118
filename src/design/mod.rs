//! The design matrix: one row for each value read, from exact derivatives of the exact rotation chain and of the model line.
//!
//! ```text
//! row = d reading / d parameters   at the stated reference point
//! ```
//!
//! Nobody hand-derives rows: the papers' small-angle rows fall out, because at zero tilts the exact derivative *is* the small-angle
//! coefficient. Deliberately absent: weights and solving (`estimate`), opinions about what is estimable.

mod kinematics;
mod line;
mod mean;
mod model;

pub use kinematics::{Instant, Kinematics, kinematics};
pub(crate) use line::{Context, SensorModel, indifferent_angles};
pub(crate) use mean::Node;
pub use mean::{Smoothness, nodes};
pub use model::Model;
pub(crate) use model::{ColumnLine, Read, Room, Workspace, missing_column};

use crate::campaign::{Campaign, JointState, Kind};
use crate::elements::{Elements, Parts};
use crate::error::Result;
use crate::mix::{Mix, Numbers};
use faer::Mat;
use std::hash::{BuildHasher, BuildHasherDefault};

/// Predictions and their derivatives with respect to *every* parameter of the campaign (estimated, known, assumed zero).
#[derive(Debug, Clone)]
pub struct DesignMatrix {
    /// Which value each row stands for.
    pub rows: Vec<RowOrigin>,
    /// The reference point, one value for each parameter, in [`Campaign::parameters`] order.
    pub point: Vec<f64>,
    /// Model line at the reference point, one for each row.
    pub predicted: Vec<f64>,
    /// rows x parameters; the first columns belong to the estimated parameters.
    pub jacobian: Mat<f64>,
    /// rows x joints, by the joints' angles in radians; without columns where the model was not asked for them.
    pub by_joint: Mat<f64>,
}

/// The value that a row predicts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RowOrigin {
    /// Index of the reading.
    pub reading: usize,
    /// Index of the sensor in the bench.
    pub sensor: usize,
}

/// The rows of a campaign: one for each value that was read; for a schedule, one for each reading and sensor.
///
/// Errors: a model line that uses a column which a reading does not have.
pub(crate) fn rows(campaign: &Campaign) -> Vec<RowOrigin> {
    let measured = campaign.is_measured();
    let mut rows = Vec::new();
    for (reading, row) in campaign.readings.rows.iter().enumerate() {
        if measured {
            rows.extend(row.observations.iter().map(|o| RowOrigin { reading, sensor: o.sensor }));
        } else {
            rows.extend((0..campaign.bench.sensors.len()).map(|sensor| RowOrigin { reading, sensor }));
        }
    }
    rows
}

/// Of all predictions of a closed circle that differ by whole turns, the one nearest to what was read.
fn nearest_turn(campaign: &Campaign, origin: Option<&RowOrigin>, value: f64) -> f64 {
    let turn = origin.and_then(|o| campaign.bench.sensors.get(o.sensor)?.turn);
    let Some((turn, origin)) = turn.zip(origin) else { return value };
    let reading = campaign.readings.rows.get(origin.reading);
    let read = reading.and_then(|row| row.observations.iter().find(|o| o.sensor == origin.sensor));
    read.map_or(value, |read| value + turn * ((read.value - value) / turn).round())
}

/// Predict every reading at `point` and differentiate it there.
///
/// Errors: `Missing` for a column that a model line uses and a reading lacks, with the reading's place.
pub fn assemble(campaign: &Campaign, model: &Model, point: &[f64]) -> Result<DesignMatrix> {
    crate::stop::poll();
    let rows = rows(campaign);
    let parameters = campaign.parameters.len();
    let mut jacobian = Mat::zeros(rows.len(), parameters);
    let mut by_joint = Mat::zeros(rows.len(), model.joint_derivatives());
    let mut predicted = vec![0.0; rows.len()];
    let mut work = model.workspace();
    let mut sensors = Vec::new();
    let mut start = 0;
    let firsts = firsts(campaign, &rows);
    for of_reading in rows.chunk_by(|a, b| a.reading == b.reading) {
        let own = start..start + of_reading.len();
        if firsts.part(own.clone()).iter().all(|first| *first < start) {
            for to in own {
                let from = firsts.at(to);
                let before = predicted.at(from);
                predicted.get_mut(to).into_iter().for_each(|slot| *slot = before);
                (0..parameters).for_each(|j| jacobian[(to, j)] = jacobian[(from, j)]);
                (0..by_joint.ncols()).for_each(|j| by_joint[(to, j)] = by_joint[(from, j)]);
            }
            start += of_reading.len();
            continue;
        }
        sensors.clear();
        sensors.extend(of_reading.iter().map(|origin| origin.sensor));
        let reading = of_reading.first().map_or(0, |origin| origin.reading);
        model.predict_all(campaign, reading, &sensors, point, &mut work, |place, value, gradient| {
            let i = start + place;
            if let Some(slot) = predicted.get_mut(i) {
                *slot = nearest_turn(campaign, of_reading.get(place), value);
            }
            for (j, derivative) in gradient.iter().enumerate() {
                match j.checked_sub(parameters) {
                    None => jacobian[(i, j)] = *derivative,
                    Some(joint) => by_joint[(i, joint)] = *derivative,
                }
            }
        })?;
        start += of_reading.len();
    }
    by_inputs(campaign, model, point, (&rows, &firsts), &mut jacobian)?;
    Ok(DesignMatrix { rows, point: point.to_vec(), predicted, jacobian, by_joint })
}

/// Derivatives of the readings by the inputs of the bench (gravity, latitude, rates of joints), by central differences.
///
/// The model lines are low powers of rates and forces: with steps of 1e-4 the third order leaves 1e-8 of the derivative, which is used for
/// uncertainties only.
fn by_inputs(
    campaign: &Campaign,
    model: &Model,
    point: &[f64],
    (rows, firsts): (&[RowOrigin], &[usize]),
    jacobian: &mut Mat<f64>,
) -> Result<()> {
    let inputs = campaign.parameters.iter().enumerate().filter(|(_, p)| p.kind == Kind::Input);
    let mut gradient = vec![0.0; campaign.parameters.len()];
    let mut work = model.workspace();
    for (k, parameter) in inputs {
        let step = 1e-4 * parameter.reference().abs().clamp(1e-1, 1e2);
        for side in [-1.0, 1.0] {
            let mut moved = campaign.clone();
            moved.shift_input(&parameter.id, side * step);
            let mut changes: Vec<f64> = Vec::with_capacity(rows.len());
            for (i, (origin, first)) in rows.iter().zip(firsts).enumerate() {
                let change = match changes.get(*first) {
                    Some(change) => *change,
                    None => {
                        let place = (origin.reading, origin.sensor);
                        let value = model.predict(&moved, place.0, place.1, point, &mut gradient, &mut work)?;
                        side * value / (2.0 * step)
                    }
                };
                changes.push(change);
                jacobian[(i, k)] += change;
            }
        }
    }
    Ok(())
}

/// For each row the first that predicts the same: a campaign of many readings has few settings, and what one of them predicts is worked out once, wherever its readings
/// stand. A closed circle is predicted on the turn of what was read, which every reading has of its own.
fn firsts(campaign: &Campaign, rows: &[RowOrigin]) -> Vec<usize> {
    match campaign.bench.sensors.iter().any(|sensor| sensor.turn.is_some()) {
        true => (0..rows.len()).collect(),
        false => cells(campaign, rows).into_iter().map(|(_, first)| first).collect(),
    }
}

/// The cell of each row, and the first row of the cell: rows of one cell have the same sensor, joint states and columns that the model line uses.
pub(crate) fn cells(campaign: &Campaign, rows: &[RowOrigin]) -> Vec<(usize, usize)> {
    let used: Vec<Vec<usize>> = (0..campaign.bench.sensors.len()).map(|sensor| used_by(campaign, sensor)).collect();
    let mut numbers: Numbers<usize> = Numbers::default();
    let (mut key, mut other) = (Vec::new(), Vec::new());
    let cell = |(row, origin): (usize, &RowOrigin)| {
        write_key(campaign, used.at(origin.sensor), origin, &mut key);
        let hash = BuildHasherDefault::<Mix>::default().hash_one(&key);
        numbers.of(hash, row, |first| {
            let Some(first) = rows.get(first) else { return false };
            write_key(campaign, used.at(first.sensor), first, &mut other);
            key == other
        })
    };
    rows.iter().enumerate().map(cell).collect()
}

/// Columns that a sensor's line uses.
pub(crate) fn used_by(campaign: &Campaign, sensor: usize) -> Vec<usize> {
    // rows are of sensors that the bench has
    let names = campaign.bench.sensors.get(sensor).map(|own| own.model.names()).unwrap_or_default();
    let columns = campaign.readings.columns.iter().enumerate();
    columns.filter(|(_, column)| names.contains(&column.as_str())).map(|(k, _)| k).collect()
}

fn write_key(campaign: &Campaign, used: &[usize], origin: &RowOrigin, key: &mut Vec<u64>) {
    key.clear();
    key.push(origin.sensor as u64);
    let Some(reading) = campaign.readings.rows.get(origin.reading) else { return };
    key.extend(reading.joints.iter().flat_map(JointState::bits));
    for k in used {
        // readings that both lack it are alike in it
        let value = reading.columns.get(*k).copied().flatten().unwrap_or(f64::NAN);
        key.push((value + 0.0).to_bits());
    }
}
