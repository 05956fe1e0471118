//! The design matrix: one row for each value read, from exact derivatives of the exact rotation chain and of the model line.
//!
//! ```text
//! row = d reading / d parameters   at the stated reference point
//! ```
//!
//! Nobody hand-derives rows: the papers' small-angle rows fall out, because at zero tilts the exact derivative *is* the small-angle
//! coefficient. Deliberately absent: weights and solving (`estimate`), opinions about what is estimable.

mod columns;
mod kinematics;
mod line;
mod mean;
mod model;

pub(crate) use columns::{ColumnLine, Read};
pub use kinematics::{Instant, Kinematics, kinematics};
pub(crate) use line::{Context, SensorModel, indifferent_angles};
pub(crate) use mean::Node;
pub use mean::{Smoothness, nodes};
pub use model::Model;
pub(crate) use model::{Room, Workspace, missing_column};

use crate::campaign::{Campaign, JointState, Kind};
use crate::elements::Elements;
use crate::error::Result;
use crate::mix::Mix;
use faer::Mat;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

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
    let mut predicted_before = Predicted::new(campaign);
    for of_reading in rows.chunk_by(|a, b| a.reading == b.reading) {
        sensors.clear();
        sensors.extend(of_reading.iter().map(|origin| origin.sensor));
        let reading = of_reading.first().map_or(0, |origin| origin.reading);
        if let Some(from) = predicted_before.like(campaign, model, &rows, start, sensors.len()) {
            for (from, to) in (from..).zip(start..start + sensors.len()) {
                // rows before this one
                let before = predicted.at(from);
                predicted.get_mut(to).into_iter().for_each(|slot| *slot = before);
                (0..parameters).for_each(|j| jacobian[(to, j)] = jacobian[(from, j)]);
                (0..by_joint.ncols()).for_each(|j| by_joint[(to, j)] = by_joint[(from, j)]);
            }
            start += sensors.len();
            continue;
        }
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
    by_inputs(campaign, model, point, &rows, &mut jacobian)?;
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
    rows: &[RowOrigin],
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
            let (mut before, mut changes) = (Predicted::new(campaign), vec![0.0; rows.len()]);
            for (i, origin) in rows.iter().enumerate() {
                let change = match before.like(campaign, model, rows, i, 1) {
                    Some(from) => changes.at(from),
                    None => {
                        let place = (origin.reading, origin.sensor);
                        let value = model.predict(&moved, place.0, place.1, point, &mut gradient, &mut work)?;
                        side * value / (2.0 * step)
                    }
                };
                changes.get_mut(i).into_iter().for_each(|slot| *slot = change);
                jacobian[(i, k)] += change;
            }
        }
    }
    Ok(())
}

/// Readings that were predicted, by a hash of their inputs: a campaign of many readings has few settings, and what one of them predicts is worked out once,
/// wherever its readings stand.
struct Predicted {
    /// Reading and first row of the first of each hash.
    first: HashMap<u64, (usize, usize), BuildHasherDefault<Mix>>,
    /// A closed circle is predicted on the turn of what was read, which every reading has of its own.
    closed: bool,
}

impl Predicted {
    fn new(campaign: &Campaign) -> Self {
        let closed = campaign.bench.sensors.iter().any(|sensor| sensor.turn.is_some());
        Predicted { first: HashMap::default(), closed }
    }

    /// The first row of an earlier reading that predicts the same in these rows; if there is none, later ones find this one.
    fn like(
        &mut self,
        campaign: &Campaign,
        model: &Model,
        rows: &[RowOrigin],
        start: usize,
        count: usize,
    ) -> Option<usize> {
        if self.closed {
            return None;
        }
        let of = |from: usize| rows.get(from..from + count);
        let own = of(start)?;
        let reading = own.first()?.reading;
        let asked = campaign.readings.rows.get(reading)?;
        let mut hash = Mix::default();
        own.iter().for_each(|origin| hash.write_usize(origin.sensor));
        asked.joints.iter().flat_map(JointState::bits).for_each(|word| hash.write_u64(word));
        model.columns_of(asked).for_each(|value| hash.write_u64(value.map_or(u64::MAX, f64::to_bits)));
        let (before, from) = *self.first.entry(hash.finish()).or_insert((reading, start));
        let other = campaign.readings.rows.get(before).filter(|_| before != reading)?;
        let is_same = |(a, b): (&RowOrigin, &RowOrigin)| a.reading == before && a.sensor == b.sensor;
        (of(from)?.iter().zip(own).all(is_same) && model.takes_same_inputs(asked, other)).then_some(from)
    }
}
