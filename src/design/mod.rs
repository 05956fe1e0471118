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
pub(crate) use model::{Room, Together, Workspace, missing_column};

use crate::campaign::{Campaign, JointState, Kind, Shared};
use crate::elements::Elements;
use crate::error::Result;
use crate::mix::Mix;
use faer::Mat;
use std::hash::{BuildHasher, BuildHasherDefault};
use std::sync::Arc;

/// Predictions and their derivatives with respect to *every* parameter of the campaign (estimated, known, assumed zero).
#[derive(Debug, Clone)]
pub struct DesignMatrix {
    /// Which value each row stands for; designs of one campaign at several points share the list.
    pub rows: Shared<RowOrigin>,
    /// The reference point, one value for each parameter, in [`Campaign::parameters`] order.
    pub point: Vec<f64>,
    /// Model line at the reference point, one for each row.
    pub predicted: Vec<f64>,
    /// rows x parameters; the first columns belong to the estimated parameters.
    pub jacobian: Mat<f64>,
    /// rows x joints, by the joints' angles in radians; without columns where the model was not asked for them.
    pub by_joint: Mat<f64>,
    /// For each row the first that is alike ([`alike`]).
    pub(crate) alike: Arc<[usize]>,
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
    let rows = rows(campaign);
    let alike = alike(campaign, &rows).into();
    assemble_rows(campaign, model, point, (rows.into(), alike))
}

impl DesignMatrix {
    /// The same rows at another point. Errors: those of [`assemble`].
    pub(crate) fn at(&self, campaign: &Campaign, model: &Model, point: &[f64]) -> Result<DesignMatrix> {
        assemble_rows(campaign, model, point, (self.rows.clone(), self.alike.clone()))
    }
}

fn assemble_rows(
    campaign: &Campaign,
    model: &Model,
    point: &[f64],
    (rows, alike): (Shared<RowOrigin>, Arc<[usize]>),
) -> Result<DesignMatrix> {
    crate::stop::poll();
    let mut design = DesignMatrix {
        point: point.to_vec(),
        predicted: vec![0.0; rows.len()],
        jacobian: Mat::zeros(rows.len(), campaign.parameters.len()),
        by_joint: Mat::zeros(rows.len(), model.joint_derivatives()),
        rows: rows.clone(),
        alike: alike.clone(),
    };
    let (mut work, mut sensors, mut next) = (model.workspace(), Vec::new(), 0);
    // a campaign of many readings has few settings, and what one of them predicts is worked out once, wherever its readings stand; but a closed circle is predicted on the
    // turn of what was read, which every reading has of its own
    let turns = campaign.bench.sensors.iter().any(|sensor| sensor.turn.is_some());
    for of_reading in rows.chunk_by(|a, b| a.reading == b.reading) {
        let own = next..next + of_reading.len();
        next = own.end;
        if !turns && own.clone().all(|row| alike.at(row) < own.start) {
            own.for_each(|row| design.copy(alike.at(row), row));
            continue;
        }
        sensors.clear();
        sensors.extend(of_reading.iter().map(|origin| origin.sensor));
        let reading = of_reading.first().map_or(0, |origin| origin.reading);
        model.predict_all(campaign, reading, &sensors, point, &mut work, |place, value, gradient| {
            design.put(campaign, own.start + place, value, gradient);
        })?;
    }
    by_inputs(campaign, model, point, (&rows, &alike), &mut design.jacobian)?;
    Ok(design)
}

impl DesignMatrix {
    fn put(&mut self, campaign: &Campaign, row: usize, value: f64, slopes: &[f64]) {
        let value = nearest_turn(campaign, self.rows.get(row), value);
        self.predicted.get_mut(row).into_iter().for_each(|slot| *slot = value);
        let parameters = self.jacobian.ncols();
        for (j, slope) in slopes.iter().enumerate() {
            match j.checked_sub(parameters) {
                None => self.jacobian[(row, j)] = *slope,
                Some(joint) => self.by_joint[(row, joint)] = *slope,
            }
        }
    }

    fn copy(&mut self, from: usize, to: usize) {
        let value = self.predicted.at(from);
        self.predicted.get_mut(to).into_iter().for_each(|slot| *slot = value);
        (0..self.jacobian.ncols()).for_each(|j| self.jacobian[(to, j)] = self.jacobian[(from, j)]);
        (0..self.by_joint.ncols()).for_each(|j| self.by_joint[(to, j)] = self.by_joint[(from, j)]);
    }
}

/// Derivatives of the readings by the inputs of the bench (gravity, latitude, rates of joints), by central differences.
///
/// The model lines are low powers of rates and forces: with steps of 1e-4 the third order leaves 1e-8 of the derivative, which is used for
/// uncertainties only.
fn by_inputs(
    campaign: &Campaign,
    model: &Model,
    point: &[f64],
    (rows, alike): (&[RowOrigin], &[usize]),
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
            for (i, (origin, first)) in rows.iter().zip(alike).enumerate() {
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

/// For each row the first with the same sensor, joint states and columns that the model line uses.
fn alike(campaign: &Campaign, rows: &[RowOrigin]) -> Vec<usize> {
    let used: Vec<Vec<usize>> = (0..campaign.bench.sensors.len()).map(|sensor| used_by(campaign, sensor)).collect();
    let write = |row: usize, key: &mut Vec<u64>| {
        key.clear();
        rows.get(row).into_iter().for_each(|origin| write_key(campaign, used.at(origin.sensor), origin, key));
    };
    let (mut key, mut other) = (Vec::new(), Vec::new());
    let hash = |row: usize| {
        write(row, &mut key);
        (BuildHasherDefault::<Mix>::default().hash_one(&key), row)
    };
    // in order of their hashes, which for readings without replicates takes half the memory of a table of them
    let mut hashes: Vec<(u64, usize)> = (0..rows.len()).map(hash).collect();
    hashes.sort_unstable();
    let mut alike: Vec<usize> = (0..rows.len()).collect();
    for same in hashes.chunk_by(|a, b| a.0 == b.0) {
        for (_, row) in same.iter().skip(1) {
            write(*row, &mut key);
            // but for a rare accident it is the first of its hash; the row itself ends the search
            let first = same.iter().map(|(_, first)| *first).find(|first| {
                write(*first, &mut other);
                key == other
            });
            alike.get_mut(*row).into_iter().for_each(|slot| *slot = first.unwrap_or(*row));
        }
    }
    alike
}

/// Columns that a sensor's line uses.
pub(crate) fn used_by(campaign: &Campaign, sensor: usize) -> Vec<usize> {
    // rows are of sensors that the bench has
    let names = campaign.bench.sensors.get(sensor).map(|own| own.model.names()).unwrap_or_default();
    let columns = campaign.readings.columns.iter().enumerate();
    columns.filter(|(_, column)| names.contains(&column.as_str())).map(|(k, _)| k).collect()
}

fn write_key(campaign: &Campaign, used: &[usize], origin: &RowOrigin, key: &mut Vec<u64>) {
    key.push(origin.sensor as u64);
    let Some(reading) = campaign.readings.rows.get(origin.reading) else { return };
    key.extend(reading.joints.iter().flat_map(JointState::bits));
    for k in used {
        // readings that both lack it are alike in it
        let value = reading.columns.get(*k).copied().flatten().unwrap_or(f64::NAN);
        key.push((value + 0.0).to_bits());
    }
}
