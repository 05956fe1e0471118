//! Model lines bound to a campaign: every name resolved to an input or a parameter, compiled, averaged over turns.

use super::{Instant, Kinematics, Node, Smoothness, kinematics, nodes};
use crate::algebra::{Expression, NameDegree, Scratch, Tape};
use crate::bench::{Bench, Link, Sensor};
use crate::campaign::{Campaign, JointState, Readings, Role};
use crate::error::{Fault, Malformed, Result};
use nalgebra::Vector3;

/// Every sensor's model line, ready to predict readings of one campaign and of others with the same bench, parameters and columns.
#[derive(Debug, Clone)]
pub struct Model {
    sensors: Vec<SensorModel>,
    /// Parameter index of each tilt, in chain order.
    tilts: Vec<usize>,
    parameters: usize,
}

/// A line of algebra bound to one sensor: where each of its names comes from, and how smooth it is in each joint.
#[derive(Debug, Clone)]
pub struct SensorModel {
    tape: Tape,
    slots: Vec<Slot>,
    smoothness: Vec<Smoothness>,
}

/// Where a name's value comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Slot {
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

/// Buffers that predictions reuse.
#[derive(Debug, Clone, Default)]
pub struct Workspace {
    kinematics: Kinematics,
    tilts: Vec<f64>,
    inputs: Vec<f64>,
    slopes: Vec<f64>,
    magnitude: Vec<f64>,
    scratch: Scratch,
}

impl SensorModel {
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
        let slot_of = |name: &str| names.iter().position(|own| own == name).and_then(|k| slots.get(k)).copied();
        let smoothness = (0..joint_count)
            .map(|joint| {
                let degree = |name: &str| match slot_of(name) {
                    Some(Slot::Rate(_) | Slot::Force(_)) => NameDegree::Harmonic,
                    Some(Slot::Joint(k)) if k == joint => NameDegree::Angle,
                    _ => NameDegree::Constant,
                };
                let own = match line.trig_degree(&degree) {
                    Some(degree) => Smoothness::Trigonometric(degree),
                    None if slots.contains(&Slot::Joint(joint)) => Smoothness::Rough,
                    None if line.is_smooth_in(&|name| !matches!(degree(name), NameDegree::Constant)) => {
                        Smoothness::Smooth
                    }
                    None => Smoothness::Rough,
                };
                modulated(campaign, joint, own)
            })
            .collect();
        Ok(SensorModel { tape, slots, smoothness })
    }

    /// The line at one instant, given the kinematics there.
    pub fn value_at(&self, context: &Context<'_>, work: &mut Workspace) -> f64 {
        self.fill(context, &mut work.inputs);
        self.tape.value(&work.inputs, &mut work.scratch)
    }

    /// The smoothness in the joint over which a reading averages, or that of a single instant.
    pub fn smoothness_for(&self, joints: &[JointState]) -> Smoothness {
        let averaged = joints.iter().position(JointState::is_averaged);
        averaged.and_then(|joint| self.smoothness.get(joint)).copied().unwrap_or(Smoothness::Trigonometric(0))
    }

    fn fill(&self, context: &Context<'_>, inputs: &mut Vec<f64>) {
        inputs.clear();
        inputs.extend(self.slots.iter().map(|slot| match slot {
            Slot::Rate(direction) => direction.dot(&context.kinematics.rate),
            Slot::Force(direction) => direction.dot(&context.kinematics.force),
            Slot::Joint(k) => context.instant.angle_deg.get(*k).copied().unwrap_or_default().to_radians(),
            Slot::Column(k) => context.columns.get(*k).copied().flatten().unwrap_or_default(),
            Slot::Parameter(k) => context.point.get(*k).copied().unwrap_or_default(),
        }));
    }

    /// The first column that the line uses and the reading lacks.
    fn missing_column<'a>(&self, readings: &'a Readings, reading: usize) -> Option<&'a str> {
        let row = readings.rows.get(reading)?;
        self.slots.iter().find_map(|slot| match slot {
            Slot::Column(k) if row.columns.get(*k).copied().flatten().is_none() => {
                readings.columns.get(*k).map(String::as_str)
            }
            _ => None,
        })
    }
}

/// What a line sees at one instant of one reading.
#[derive(Debug, Clone, Copy)]
pub struct Context<'a> {
    /// Rate and force at the sensor.
    pub kinematics: &'a Kinematics,
    /// Joint angles.
    pub instant: &'a Instant,
    /// The reading's numeric columns.
    pub columns: &'a [Option<f64>],
    /// Parameter values.
    pub point: &'a [f64],
}

impl Model {
    /// Bind and compile every sensor's model line.
    ///
    /// Errors: `UnknownName` for an axis input that the sensor does not have.
    pub fn new(campaign: &Campaign) -> Result<Self> {
        let sensors = campaign
            .bench
            .sensors
            .iter()
            .map(|sensor| {
                let path = format!("sensors.{}.model", sensor.id);
                SensorModel::bind(campaign, sensor, &sensor.model).map_err(|error| error.at_path(path))
            })
            .collect::<Result<_>>()?;
        let tilts = campaign.bench.tilts().filter_map(|name| campaign.parameter_index(name)).collect();
        Ok(Model { sensors, tilts, parameters: campaign.parameters.len() })
    }

    /// Buffers for [`Model::predict`].
    pub fn workspace(&self) -> Workspace {
        Workspace::default()
    }

    /// The tilts of the chain among the values of all parameters, in chain order.
    pub fn tilts_of(&self, point: &[f64]) -> Vec<f64> {
        self.tilts.iter().map(|k| point.get(*k).copied().unwrap_or_default()).collect()
    }

    /// Mean of the model line over a reading, and its gradient with respect to every parameter (overwritten).
    ///
    /// `reading = mean over nodes of f`; `d/d coefficient = mean of df/dc`; `d/d tilt = mean of sum over inputs df/d input * d input/d tilt`.
    /// A derivative whose mean is only the rounding of terms that cancel (below 8 epsilon of their mean size) is zero.
    pub fn predict(
        &self,
        campaign: &Campaign,
        reading: usize,
        sensor: usize,
        point: &[f64],
        gradient: &mut [f64],
        work: &mut Workspace,
    ) -> Result<f64> {
        gradient.fill(0.0);
        let (Some(model), Some(row)) = (self.sensors.get(sensor), campaign.readings.rows.get(reading)) else {
            return Ok(0.0);
        };
        if let Some(column) = model.missing_column(&campaign.readings, reading) {
            return Err(Malformed::new(
                Fault::Missing,
                format!("the model line uses the column '{column}', and a reading lacks it"),
            )
            .expected(format!("a number for {column} in every reading"))
            .at_path(row.place.clone()));
        }
        work.tilts.clear();
        work.tilts.extend(self.tilts.iter().map(|k| point.get(*k).copied().unwrap_or_default()));
        work.slopes.resize(model.slots.len(), 0.0);
        work.magnitude.clear();
        work.magnitude.resize(self.parameters, 0.0);
        let mut mean = 0.0;
        for Node { instant, weight } in nodes(row, model.smoothness_for(&row.joints)) {
            kinematics(&campaign.bench, &work.tilts, &instant, &mut work.kinematics);
            let context = Context { kinematics: &work.kinematics, instant: &instant, columns: &row.columns, point };
            model.fill(&context, &mut work.inputs);
            mean += weight * model.tape.gradient(&work.inputs, &mut work.scratch, &mut work.slopes);
            let mut add = |parameter: usize, derivative: f64| {
                if let (Some(sum), Some(size)) = (gradient.get_mut(parameter), work.magnitude.get_mut(parameter)) {
                    *sum += weight * derivative;
                    *size += weight * derivative.abs();
                }
            };
            for (slot, slope) in model.slots.iter().zip(&work.slopes) {
                let (direction, by_tilt) = match slot {
                    Slot::Parameter(k) => {
                        add(*k, *slope);
                        continue;
                    }
                    Slot::Rate(direction) => (direction, &work.kinematics.rate_by_tilt),
                    Slot::Force(direction) => (direction, &work.kinematics.force_by_tilt),
                    Slot::Joint(_) | Slot::Column(_) => continue,
                };
                if *slope != 0.0 {
                    for (parameter, derivative) in self.tilts.iter().zip(by_tilt) {
                        add(*parameter, slope * direction.dot(derivative));
                    }
                }
            }
        }
        for (sum, size) in gradient.iter_mut().zip(&work.magnitude) {
            if sum.abs() <= 8.0 * f64::EPSILON * size {
                *sum = 0.0;
            }
        }
        Ok(mean)
    }

    /// The bound line of a sensor.
    pub fn sensor(&self, sensor: usize) -> Option<&SensorModel> {
        self.sensors.get(sensor)
    }
}

/// The smoothness of a line in a joint once the tilts that follow this joint take part (those assumed zero do not).
fn modulated(campaign: &Campaign, joint: usize, own: Smoothness) -> Smoothness {
    /// Powers of such a tilt that count: a tilt of 1e-2 rad to this power is below rounding.
    const ORDERS: usize = 8;
    let Some(joint) = campaign.bench.joints().nth(joint) else { return own };
    let mut smoothness = own;
    for link in &campaign.bench.chain {
        let Link::Tilt { name, times: Some(times), .. } = link else { continue };
        let parameter = campaign.parameter_index(name).and_then(|k| campaign.parameters.get(k));
        if parameter.is_none_or(|p| p.role == Role::AssumedZero) {
            continue;
        }
        let degree = |name: &str| if name == joint { NameDegree::Angle } else { NameDegree::Constant };
        smoothness = match (smoothness, times.line().trig_degree(&degree)) {
            (same, Some(0)) => same,
            (Smoothness::Trigonometric(own), Some(degree)) => Smoothness::Trigonometric(own + ORDERS * degree),
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
    Err(Malformed::new(Fault::UnknownName, format!("'{name}' is no input, column or parameter here"))
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
    let own = sensor.axes.iter().find(|(id, _)| id == axis).map(|(_, direction)| *direction);
    let direction = match (own, axis) {
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
