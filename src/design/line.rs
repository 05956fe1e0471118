//! A model line bound to one sensor: where each of its names comes from, and how smooth it is in each joint.

use super::{Instant, Kinematics, Smoothness, kinematics};
use crate::algebra::{Expression, NameDegree, Tape};
use crate::bench::{Bench, Link, Sensor};
use crate::campaign::{Campaign, JointState, Readings, Role};
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use nalgebra::Vector3;

/// A line of algebra bound to one sensor: where each of its names comes from, and how smooth it is in each joint.
#[derive(Debug, Clone)]
pub struct SensorModel {
    pub(super) tape: Tape,
    pub(super) slots: Vec<Slot>,
    /// Does it follow rates, and forces?
    pub(super) follows: [bool; 2],
    smoothness: Vec<Smoothness>,
}

/// Where a name's value comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Slot {
    /// Angular rate along this direction of the last frame.
    Rate(Vector3<f64>),
    /// Specific force along this direction of the last frame.
    Force(Vector3<f64>),
    /// Angle of a joint, in radians.
    Joint(usize),
    /// Numeric column of the readings.
    Column(usize),
    /// Parameter of the campaign.
    Parameter(usize),
}

impl SensorModel {
    /// Of a reading of one instant, which has one node, whatever the line: the mean of a constant.
    pub(super) const INSTANT: Smoothness = Smoothness::Trigonometric(0);

    /// Bind a line to a sensor of a campaign.
    ///
    /// Errors: `UnknownName` for a name that is neither an axis input of this sensor, a joint, a numeric column nor a parameter.
    pub fn bind(campaign: &Campaign, sensor: &Sensor, line: &Expression) -> Result<Self> {
        let names: Vec<String> = line.names().into_iter().map(str::to_string).collect();
        let slots = names
            .iter()
            .map(|name| {
                resolve(campaign, sensor, name).map_err(|error| match line.span_of(name) {
                    Some((start, len)) => error.at_span(start, len),
                    None => error,
                })
            })
            .collect::<Result<Vec<Slot>>>()?;
        let borrowed: Vec<&str> = names.iter().map(String::as_str).collect();
        let tape = Tape::compile(line, &borrowed)?;
        let joint_count = campaign.bench.joints().count();
        let slot_of = |name: &str| names.iter().position(|other| other == name).and_then(|k| slots.get(k)).copied();
        let smoothness = (0..joint_count)
            .map(|joint| {
                let degree = |name: &str| match slot_of(name) {
                    Some(Slot::Rate(_) | Slot::Force(_)) => NameDegree::Harmonic,
                    Some(Slot::Joint(k)) if k == joint => NameDegree::Angle,
                    _ => NameDegree::Constant,
                };
                let smoothness = match line.trig_degree(&degree) {
                    Some(degree) => Smoothness::Trigonometric(degree),
                    None if slots.contains(&Slot::Joint(joint)) => Smoothness::Rough,
                    None if line.is_smooth_in(&|name| !matches!(degree(name), NameDegree::Constant)) => {
                        Smoothness::Smooth
                    }
                    None => Smoothness::Rough,
                };
                modulated(campaign, joint, smoothness)
            })
            .collect();
        let follows = [
            slots.iter().any(|slot| matches!(slot, Slot::Rate(_))),
            slots.iter().any(|slot| matches!(slot, Slot::Force(_))),
        ];
        Ok(SensorModel { tape, slots, follows, smoothness })
    }

    /// The smoothness in the joint over which a reading averages, or that of a single instant.
    pub fn smoothness_for(&self, joints: &[JointState]) -> Smoothness {
        let averaged = joints.iter().position(JointState::is_averaged);
        averaged.and_then(|joint| self.smoothness.get(joint)).copied().unwrap_or(Self::INSTANT)
    }

    /// Values of all slots.
    pub(super) fn fill(&self, context: &Context<'_>, inputs: &mut Vec<f64>) {
        inputs.clear();
        inputs.extend(self.slots.iter().map(|slot| match slot {
            Slot::Rate(direction) => direction.dot(&context.kinematics.rate),
            Slot::Force(direction) => direction.dot(&context.kinematics.force),
            Slot::Joint(k) => context.instant.angle_deg.at(*k).to_radians(),
            // `missing_column` refuses a reading that lacks it, before
            Slot::Column(k) => context.columns.get(*k).copied().flatten().unwrap_or(f64::NAN),
            Slot::Parameter(k) => context.point.at(*k),
        }));
    }

    /// The smallest part of a line (the one that was bound) without a value at these inputs, and the inputs that stand in it.
    pub(super) fn without_value(&self, line: &Expression, inputs: &[f64]) -> Option<(String, Vec<(String, f64)>)> {
        let names = line.names();
        let value = |name: &str| names.iter().position(|other| *other == name).and_then(|k| inputs.get(k)).copied();
        let part = line.without_value(&|name| value(name).unwrap_or(f64::NAN))?; // a name without an input has no value
        let inputs = part.names().into_iter().filter_map(|name| Some((name.to_string(), value(name)?))).collect();
        Some((part.to_string(), inputs))
    }

    /// The first column that the line uses and the reading lacks.
    pub(super) fn missing_column<'a>(&self, readings: &'a Readings, reading: usize) -> Option<&'a str> {
        let row = readings.rows.get(reading)?;
        self.slots.iter().find_map(|slot| match slot {
            Slot::Column(k) if row.columns.get(*k).copied().flatten().is_none() => {
                readings.columns.get(*k).map(String::as_str)
            }
            _ => None,
        })
    }
}

/// Of each joint, an angle at which it may be taken to stand where a reading does not say: zero if no model line responds to the angle at any attitude
/// (a gyro along a vertical axis of rotation), none if one does.
///
/// A line responds if `d w/d angle` or `d f/d angle` along one of its axes is not zero at a general attitude, or if it names the joint. The derivatives are
/// analytic in angles, rates and tilts: one that is zero at a point without any relation between these is zero everywhere, and 1e-12 of the vector is rounding.
pub(crate) fn indifferent_angles(bench: &Bench) -> Vec<Option<f64>> {
    let general =
        |count: usize, size: f64| -> Vec<f64> { (0..count).map(|k| size * (1.0 + (1.7 * k as f64).sin())).collect() };
    let joints = bench.joints().count();
    let instant = Instant { angle_deg: general(joints, 50.0), rate_deg_s: general(joints, 7.0) };
    let mut there = Kinematics::default();
    there.wants_joints = true;
    kinematics(bench, &general(bench.tilts().count(), 0.01), &instant, &mut there);
    let responds = |joint: usize, direction: &Vector3<f64>, is_rate: bool| {
        let (vector, by_joint) = match is_rate {
            true => (&there.rate, &there.rate_by_joint),
            false => (&there.force, &there.force_by_joint),
        };
        by_joint.get(joint).is_none_or(|by| by.dot(direction).abs() > 1e-12 * vector.norm())
    };
    let named = |(k, name): (usize, &str)| {
        let mut inputs =
            bench.sensors.iter().flat_map(|sensor| sensor.model.names().into_iter().map(move |input| (sensor, input)));
        let responds = |(sensor, input): (&Sensor, &str)| match axis_input(bench, sensor, input) {
            Ok(Some((is_rate, direction))) => responds(k, &direction, is_rate),
            _ => input == name || input.strip_prefix(name) == Some("_deg"),
        };
        (!inputs.any(responds)).then_some(0.0)
    };
    bench.joints().enumerate().map(named).collect()
}

/// What a line sees at one instant of one reading.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Context<'a> {
    /// Rate and force at the sensor.
    pub kinematics: &'a Kinematics,
    /// Joint angles.
    pub instant: &'a Instant,
    /// The reading's numeric columns.
    pub columns: &'a [Option<f64>],
    /// Parameter values.
    pub point: &'a [f64],
}

/// The smoothness of a line in a joint once the tilts that follow this joint take part; of those assumed zero only the derivative does.
fn modulated(campaign: &Campaign, joint: usize, of_line: Smoothness) -> Smoothness {
    /// Powers of such a tilt that count: a tilt of 1e-2 rad to this power is below rounding.
    const ORDERS: usize = 8;
    let Some(joint) = campaign.bench.joints().nth(joint) else { return of_line };
    let mut smoothness = of_line;
    for link in &campaign.bench.chain {
        let Link::Tilt { name, times: Some(times), .. } = link else { continue };
        let parameter = campaign.parameter_index(name).and_then(|k| campaign.parameters.get(k));
        let Some(parameter) = parameter else { continue };
        let orders = if parameter.role == Role::AssumedZero { 1 } else { ORDERS };
        let degree = |name: &str| if name == joint { NameDegree::Angle } else { NameDegree::Constant };
        smoothness = match (smoothness, times.line().trig_degree(&degree)) {
            (same, Some(0)) => same,
            (Smoothness::Trigonometric(order), Some(degree)) => Smoothness::Trigonometric(order + orders * degree),
            (Smoothness::Trigonometric(_), None) => Smoothness::Sawtooth,
            (same, _) => same,
        };
    }
    smoothness
}

/// What a name of a model line means for this sensor.
fn resolve(campaign: &Campaign, sensor: &Sensor, name: &str) -> Result<Slot> {
    if let Some((is_rate, direction)) = axis_input(&campaign.bench, sensor, name)? {
        return Ok(if is_rate { Slot::Rate(direction) } else { Slot::Force(direction) });
    }
    if let Some(k) = campaign.bench.joints().position(|joint| joint == name) {
        return Ok(Slot::Joint(k));
    }
    if let Some(k) = campaign.readings.columns.iter().position(|column| column == name) {
        return Ok(Slot::Column(k));
    }
    if let Some(k) = campaign.parameter_index(name) {
        return Ok(Slot::Parameter(k));
    }
    Err(Malformed::new(Fault::UnknownName, format!("'{name}' is not an input, column or parameter here"))
        .expected(format!("{}, a joint's name, a numeric column of the readings, or a parameter", axis_names(sensor)))
        .found(format!("'{name}'")))
}

/// `w_I` or `a_I`: whether it is a rate, and the axis's direction. `None` where the name has another form.
fn axis_input(bench: &Bench, sensor: &Sensor, name: &str) -> Result<Option<(bool, Vector3<f64>)>> {
    let (is_rate, axis) = match (name.strip_prefix("w_"), name.strip_prefix("a_")) {
        (Some(axis), _) => (true, axis),
        (_, Some(axis)) => (false, axis),
        _ => return Ok(None),
    };
    let listed = sensor.axes.iter().find(|(id, _)| id == axis).map(|(_, direction)| *direction);
    let direction = match (listed, axis) {
        (Some(direction), _) => direction,
        (None, "x") => Vector3::x(),
        (None, "y") => Vector3::y(),
        (None, "z") => Vector3::z(),
        (None, _) if bench.sensors.iter().any(|other| other.axes.iter().any(|(id, _)| id == axis)) => {
            return Err(Malformed::new(Fault::UnknownName, format!("sensor {} has no axis '{axis}'", sensor.id))
                .expected(axis_names(sensor))
                .found(format!("'{name}', an axis of another sensor")));
        }
        (None, _) => return Ok(None),
    };
    Ok(Some((is_rate, direction)))
}

fn axis_names(sensor: &Sensor) -> String {
    let mut names: Vec<String> =
        sensor.axes.iter().flat_map(|(axis, _)| [format!("w_{axis}"), format!("a_{axis}")]).collect();
    names.extend(["w_x", "w_y", "w_z", "a_x", "a_y", "a_z"].map(str::to_string));
    names.join(", ")
}
