//! Model lines bound to a campaign, ready to predict readings: inputs once for each reading, the lines of all its sensors, means over turns.
#![allow(
    clippy::indexing_slicing,
    reason = "vectors have three components and lanes four numbers, and the loops run over these lengths"
)]

use super::four::{FourInstants, Vectors};
use super::line::{SensorModel, Slot};
use super::mean::{Sweep, sweep};
use super::{Context, Kinematics, Smoothness, kinematics};
use crate::algebra::{Lane, Scratch};
use crate::campaign::{Campaign, Reading};
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};

/// Every sensor's model line, ready to predict readings of one campaign and of others with the same bench, parameters and columns.
#[derive(Debug, Clone)]
pub struct Model {
    sensors: Vec<SensorModel>,
    /// Parameter index of each tilt, in chain order.
    tilts: Vec<usize>,
    parameters: usize,
    /// Joints by whose angles predictions are differentiated too; 0 where nobody asks.
    joints: usize,
}

/// Buffers that predictions reuse.
#[derive(Debug, Clone, Default)]
pub struct Workspace {
    kinematics: Kinematics,
    tilts: Vec<f64>,
    pub(super) inputs: Vec<f64>,
    slopes: Vec<f64>,
    pub(super) scratch: Scratch,
    gathered: Vec<Gathered>,
    sweep: Sweep,
    four: FourInstants,
    tilts_of_four: Vec<Lane>,
    inputs_of_four: Vec<Lane>,
    slopes_of_four: Vec<Lane>,
    arch: Arch,
}

impl SensorModel {
    /// The line at one instant, given the kinematics there.
    pub fn value_at(&self, context: &Context<'_>, work: &mut Workspace) -> f64 {
        self.fill(context, &mut work.inputs);
        self.tape.value(&work.inputs, &mut work.scratch)
    }
}

/// What [`Model::gather_lanes`] is asked: the instants of a reading four at a time at one point, or one at a time at four points.
struct Lanes<'a> {
    model: &'a Model,
    campaign: &'a Campaign,
    row: &'a Reading,
    smoothness: Smoothness,
    at: Points<'a>,
    work: &'a mut Workspace,
}

/// Values of all parameters.
#[derive(Clone, Copy)]
enum Points<'a> {
    One(&'a [f64]),
    Four(&'a [Lane]),
}

impl WithSimd for Lanes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Lanes { model, campaign, row, smoothness, at, work } = self;
        let sweep = std::mem::take(&mut work.sweep);
        match at {
            Points::One(point) => {
                // where the last are fewer than four, its last one again with no weight
                let four = |stops: &[(f64, f64)]| -> (Lane, Lane) {
                    let last = stops.last().map_or(0.0, |(angle, _)| *angle);
                    let stop = |l: usize| stops.get(l).copied().unwrap_or((last, 0.0));
                    (std::array::from_fn(|l| stop(l).0), std::array::from_fn(|l| stop(l).1))
                };
                let parameter = |k: usize| [point.at(k); 4];
                model.gather_lanes(
                    campaign,
                    row,
                    smoothness,
                    (&sweep, sweep.stops.chunks(4).map(four)),
                    parameter,
                    work,
                );
            }
            Points::Four(points) => {
                let alone = [(0.0, 1.0)];
                let stops = if sweep.joint.is_some() { sweep.stops.as_slice() } else { &alone };
                let stops = stops.iter().map(|(angle, weight)| ([*angle; 4], [*weight; 4]));
                let parameter = |k: usize| points.get(k).copied().unwrap_or([f64::NAN; 4]);
                model.gather_lanes(campaign, row, smoothness, (&sweep, stops), parameter, work);
            }
        }
        work.sweep = sweep;
    }
}

/// Mean of one sensor's line over a reading, and its gradient, while they are summed up.
#[derive(Debug, Clone, Default)]
struct Gathered {
    sensor: usize,
    smoothness: Option<Smoothness>,
    mean: f64,
    gradient: Vec<f64>,
    /// Mean size of the terms of each derivative.
    magnitude: Vec<f64>,
    /// The same sums, four instants side by side: the mean, then each derivative with the size of its terms.
    mean_of_four: Lane,
    of_four: Vec<[Lane; 2]>,
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
        let deviates = campaign.scatter.iter().any(|line| line.is_of_a_joint());
        let joints = if deviates { campaign.bench.joints().count() } else { 0 };
        Ok(Model { sensors, tilts, parameters: campaign.parameters.len(), joints })
    }

    /// The same, with derivatives by the angles of all joints.
    pub fn with_joints(campaign: &Campaign) -> Result<Self> {
        Ok(Model { joints: campaign.bench.joints().count(), ..Model::new(campaign)? })
    }

    /// How many derivatives by joints' angles follow those by parameters in a gradient: all joints, or none.
    pub fn joint_derivatives(&self) -> usize {
        self.joints
    }

    /// Buffers for [`Model::predict`].
    pub fn workspace(&self) -> Workspace {
        let mut work = Workspace::default();
        work.kinematics.wants_joints = self.joints > 0;
        work
    }

    /// The tilts of the chain among the values of all parameters, in chain order.
    pub fn tilts_of(&self, point: &[f64]) -> Vec<f64> {
        self.tilts.iter().map(|k| point.at(*k)).collect()
    }

    /// Mean of the model line over a reading, and its gradient with respect to every parameter (overwritten).
    ///
    /// `reading = mean over nodes of f`; `d/d coefficient = mean of df/dc`; `d/d tilt = mean of sum over inputs df/d input * d input/d tilt`.
    /// A derivative whose mean is only the rounding of terms that cancel (below 8 epsilon of their mean size) is zero.
    /// Errors: `Missing` for a column that the line uses and the reading lacks; `Value` for a reading, sensor or parameter beyond those that there are.
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
        let mut mean = 0.0;
        self.predict_all(campaign, reading, &[sensor], point, work, |_, value, slopes| {
            mean = value;
            gradient.iter_mut().zip(slopes).for_each(|(own, slope)| *own = *slope);
        })?;
        Ok(mean)
    }

    /// The same for several sensors of one reading, which share the inputs: `visit(place in sensors, mean, gradient)`; where wanted, derivatives
    /// by the joints' angles (rad) follow those by the parameters.
    pub fn predict_all(
        &self,
        campaign: &Campaign,
        reading: usize,
        sensors: &[usize],
        point: &[f64],
        work: &mut Workspace,
        mut visit: impl FnMut(usize, f64, &[f64]),
    ) -> Result<()> {
        let row = campaign.readings.rows.get(reading);
        let row = row.ok_or_else(|| beyond("readings", reading, campaign.readings.rows.len()))?;
        if point.len() < self.parameters {
            return Err(beyond("parameters' values", self.parameters - 1, point.len()));
        }
        work.tilts.clear();
        work.tilts.extend(self.tilts.iter().map(|k| point.at(*k)));
        work.gathered.resize_with(sensors.len(), Gathered::default);
        for (gathered, sensor) in work.gathered.iter_mut().zip(sensors) {
            let model = self.sensors.get(*sensor).ok_or_else(|| beyond("sensors", *sensor, self.sensors.len()))?;
            if let Some(column) = model.missing_column(&campaign.readings, reading) {
                return Err(missing_column(column).at_path(row.place.clone()));
            }
            gathered.restart(*sensor, model.smoothness_for(&row.joints), self.parameters + self.joints);
        }
        for first in 0..sensors.len() {
            // sensors of one smoothness average over the same instants
            let smoothness = work.gathered.get(first).and_then(|g| g.smoothness);
            let done = work.gathered.iter().take(first).any(|g| g.smoothness == smoothness);
            if let Some(smoothness) = smoothness.filter(|_| !done) {
                self.gather(campaign, row, smoothness, point, work);
            }
        }
        for (place, gathered) in work.gathered.iter_mut().enumerate() {
            gathered.drop_rounding();
            visit(place, gathered.mean, &gathered.gradient);
        }
        Ok(())
    }

    /// Do two readings give the model lines the same inputs: joints, and the columns that stand in them?
    pub(super) fn takes_same_inputs(&self, a: &Reading, b: &Reading) -> bool {
        let column = |slot: &Slot| match slot {
            Slot::Column(k) => a.columns.get(*k) == b.columns.get(*k),
            _ => true,
        };
        a.joints == b.joints && self.sensors.iter().all(|sensor| sensor.slots.iter().all(column))
    }

    /// Sum up every sensor of this smoothness over the reading's instants.
    fn gather(&self, campaign: &Campaign, row: &Reading, smoothness: Smoothness, point: &[f64], work: &mut Workspace) {
        work.sweep.set(row, smoothness);
        if work.sweep.joint.is_some() && self.joints == 0 && work.sweep.stops.len() > 1 {
            work.tilts_of_four.clear();
            work.tilts_of_four.extend(work.tilts.iter().map(|tilt| [*tilt; 4]));
            let arch = work.arch;
            arch.dispatch(Lanes { model: self, campaign, row, smoothness, at: Points::One(point), work });
            let own = work.gathered.iter_mut().filter(|own| own.smoothness == Some(smoothness));
            return own.for_each(Gathered::join_fours);
        }
        let Workspace { kinematics: at, tilts, inputs, slopes, scratch, gathered, sweep, .. } = work;
        sweep.visit(|instant, weight| {
            kinematics(&campaign.bench, tilts, instant, at);
            let context = Context { kinematics: at, instant, columns: &row.columns, point };
            for own in gathered.iter_mut().filter(|own| own.smoothness == Some(smoothness)) {
                let Some(model) = self.sensors.get(own.sensor) else { continue };
                model.fill(&context, inputs);
                slopes.resize(model.slots.len(), 0.0);
                own.mean += weight * model.tape.gradient(inputs, scratch, slopes);
                own.add(&model.slots, slopes, (&self.tilts, self.parameters), at, weight);
            }
        });
    }

    /// The same, four numbers at a time and by the widest instructions that there are.
    #[inline(always)]
    fn gather_lanes(
        &self,
        campaign: &Campaign,
        row: &Reading,
        smoothness: Smoothness,
        (sweep, stops): (&Sweep, impl Iterator<Item = (Lane, Lane)>),
        parameter: impl Fn(usize) -> Lane,
        work: &mut Workspace,
    ) {
        let Workspace {
            tilts_of_four: tilts,
            scratch,
            gathered,
            four,
            inputs_of_four: inputs,
            slopes_of_four: slopes,
            ..
        } = work;
        let of = |own: &&Gathered| own.smoothness == Some(smoothness);
        let follows = gathered.iter().filter(of).filter_map(|own| self.sensors.get(own.sensor)).map(|own| own.follows);
        let wanted = follows.fold([false; 2], |[rate, force], own| [rate || own[0], force || own[1]]);
        // no joint has the place behind all
        let joint = sweep.joint.unwrap_or(sweep.base.angle_deg.len());
        for (angles, weights) in stops {
            four.set(&campaign.bench, tilts, &sweep.base, (joint, angles), wanted);
            for own in gathered.iter_mut().filter(|own| own.smoothness == Some(smoothness)) {
                let Some(model) = self.sensors.get(own.sensor) else { continue };
                inputs.clear();
                inputs.extend(model.slots.iter().map(|slot| match slot {
                    Slot::Rate(direction) => along(direction, &four.rate),
                    Slot::Force(direction) => along(direction, &four.force),
                    Slot::Joint(k) if *k == joint => angles.map(f64::to_radians),
                    Slot::Joint(k) => [sweep.base.angle_deg.at(*k).to_radians(); 4],
                    Slot::Column(k) => [row.columns.get(*k).copied().flatten().unwrap_or(f64::NAN); 4],
                    Slot::Parameter(k) => parameter(*k),
                }));
                slopes.resize(model.slots.len(), [0.0; 4]);
                let values = model.tape.gradient_of_four(inputs, scratch, slopes);
                own.add_four((values, &weights), &model.slots, slopes, &self.tilts, four);
            }
        }
    }

    /// [`Model::predict_all`] at four points of the parameters: `visit(place in sensors, values, gradient)`. A column that the reading lacks is no number.
    pub(crate) fn predict_four(
        &self,
        campaign: &Campaign,
        row: &Reading,
        sensors: &[usize],
        points: &[Lane],
        work: &mut Workspace,
        mut visit: impl FnMut(usize, &Lane, &[Lane]),
    ) {
        work.tilts_of_four.clear();
        work.tilts_of_four.extend(self.tilts.iter().map(|k| points.get(*k).copied().unwrap_or_default()));
        work.gathered.resize_with(sensors.len(), Gathered::default);
        for (gathered, sensor) in work.gathered.iter_mut().zip(sensors) {
            let smoothness = self.sensors.get(*sensor).map(|own| own.smoothness_for(&row.joints));
            gathered.restart(*sensor, smoothness.unwrap_or(Smoothness::Rough), self.parameters);
        }
        for first in 0..sensors.len() {
            let smoothness = work.gathered.get(first).and_then(|g| g.smoothness);
            let done = work.gathered.iter().take(first).any(|g| g.smoothness == smoothness);
            if let Some(smoothness) = smoothness.filter(|_| !done) {
                work.sweep.set(row, smoothness);
                let (arch, at) = (work.arch, Points::Four(points));
                arch.dispatch(Lanes { model: self, campaign, row, smoothness, at, work });
            }
        }
        for (place, own) in work.gathered.iter().enumerate() {
            work.slopes_of_four.clear();
            work.slopes_of_four.extend(own.of_four.iter().map(|[sums, sizes]| {
                std::array::from_fn(|l| if is_rounding(sums[l], sizes[l]) { 0.0 } else { sums[l] })
            }));
            visit(place, &own.mean_of_four, &work.slopes_of_four);
        }
    }

    /// The smallest part of a sensor's line that has no value at some instant of a reading, and the inputs that stand in it.
    pub fn without_value(
        &self,
        campaign: &Campaign,
        reading: usize,
        sensor: usize,
        point: &[f64],
    ) -> Option<(String, Vec<(String, f64)>)> {
        let (row, model) = (campaign.readings.rows.get(reading)?, self.sensors.get(sensor)?);
        let line = &campaign.bench.sensors.get(sensor)?.model;
        let tilts = self.tilts_of(point);
        let (mut at, mut inputs, mut found) = (Kinematics::default(), Vec::new(), None);
        sweep(row, model.smoothness_for(&row.joints)).visit(|instant, _| {
            if found.is_none() {
                kinematics(&campaign.bench, &tilts, instant, &mut at);
                model.fill(&Context { kinematics: &at, instant, columns: &row.columns, point }, &mut inputs);
                found = model.without_value(line, &inputs);
            }
        });
        found
    }

    /// The bound line of a sensor.
    pub fn sensor(&self, sensor: usize) -> Option<&SensorModel> {
        self.sensors.get(sensor)
    }
}

/// A model line follows a column that a reading does not have.
pub(crate) fn missing_column(column: &str) -> Malformed {
    Malformed::new(Fault::Missing, format!("the model line uses the column '{column}', and a reading lacks it"))
        .expected(format!("a number for {column} in every reading"))
}

/// A model asked for what its campaign does not have; counted from 1.
fn beyond(what: &str, k: usize, count: usize) -> Malformed {
    Malformed::new(Fault::Value, format!("a prediction was asked for number {} of the {what}", k + 1))
        .expected(format!("one of the {count} that there are"))
}

impl Gathered {
    fn restart(&mut self, sensor: usize, smoothness: Smoothness, parameters: usize) {
        (self.sensor, self.smoothness, self.mean) = (sensor, Some(smoothness), 0.0);
        for list in [&mut self.gradient, &mut self.magnitude] {
            list.clear();
            list.resize(parameters, 0.0);
        }
        self.mean_of_four = [0.0; 4];
        self.of_four.clear();
        self.of_four.resize(parameters, [[0.0; 4]; 2]);
    }

    /// [`Gathered::add`] for four instants.
    #[inline(always)]
    fn add_four(
        &mut self,
        (values, weights): (Lane, &Lane),
        slots: &[Slot],
        slopes: &[Lane],
        tilts: &[usize],
        at: &FourInstants,
    ) {
        plus(&mut self.mean_of_four, weights, &values);
        let mut add = |parameter: usize, derivative: &Lane, size: &Lane| {
            if let Some([sum, sizes]) = self.of_four.get_mut(parameter) {
                plus(sum, weights, derivative);
                plus(sizes, weights, size);
            }
        };
        let (mut by_rate, mut by_force) = ([[[0.0; 4]; 3]; 2], [[[0.0; 4]; 3]; 2]);
        for (slot, slope) in slots.iter().zip(slopes) {
            match slot {
                Slot::Parameter(k) => add(*k, slope, &slope.map(f64::abs)),
                Slot::Rate(direction) => steepen(&mut by_rate, direction, slope),
                Slot::Force(direction) => steepen(&mut by_force, direction, slope),
                Slot::Joint(_) | Slot::Column(_) => {}
            }
        }
        for ([sum, size], by_tilt) in [(by_rate, &at.rate_by_tilt), (by_force, &at.force_by_tilt)] {
            if size != [[0.0; 4]; 3] {
                for (parameter, derivative) in tilts.iter().zip(by_tilt) {
                    let sizes = derivative.map(|part| part.map(f64::abs));
                    add(*parameter, &dot(&sum, derivative), &dot(&size, &sizes));
                }
            }
        }
    }

    /// Sums of four instants as those of all, in the order of the instants.
    #[inline(always)]
    fn join_fours(&mut self) {
        let sum = |four: &Lane| four.iter().fold(0.0, |sum, own| sum + own);
        self.mean += sum(&self.mean_of_four);
        for (([sums, sizes], gradient), magnitude) in
            self.of_four.iter().zip(&mut self.gradient).zip(&mut self.magnitude)
        {
            *gradient += sum(sums);
            *magnitude += sum(sizes);
        }
    }

    /// Add one instant: slopes by parameters as they are, slopes by inputs through the inputs' derivatives by the tilts.
    fn add(
        &mut self,
        slots: &[Slot],
        slopes: &[f64],
        (tilts, parameters): (&[usize], usize),
        at: &Kinematics,
        weight: f64,
    ) {
        let mut add = |parameter: usize, derivative: f64, size: f64| {
            if let (Some(sum), Some(sizes)) = (self.gradient.get_mut(parameter), self.magnitude.get_mut(parameter)) {
                *sum += weight * derivative;
                *sizes += weight * size;
            }
        };
        // df/d rate and df/d force, with the sizes of their terms
        let (mut by_rate, mut by_force) = ([Vector3::<f64>::zeros(); 2], [Vector3::<f64>::zeros(); 2]);
        for (slot, slope) in slots.iter().zip(slopes) {
            match slot {
                Slot::Parameter(k) => add(*k, *slope, slope.abs()),
                Slot::Rate(direction) => accumulate(&mut by_rate, direction, *slope),
                Slot::Force(direction) => accumulate(&mut by_force, direction, *slope),
                // without derivatives by joints there is no such place, and nothing is added
                Slot::Joint(k) => add(parameters + k, *slope, slope.abs()),
                Slot::Column(_) => {}
            }
        }
        let by_rate = (by_rate, &at.rate_by_tilt, &at.rate_by_joint);
        let by_force = (by_force, &at.force_by_tilt, &at.force_by_joint);
        for ([sum, size], by_tilt, by_joint) in [by_rate, by_force] {
            if size != Vector3::zeros() {
                for (parameter, derivative) in tilts.iter().zip(by_tilt) {
                    add(*parameter, sum.dot(derivative), size.dot(&derivative.abs()));
                }
                for (joint, derivative) in by_joint.iter().enumerate() {
                    add(parameters + joint, sum.dot(derivative), size.dot(&derivative.abs()));
                }
            }
        }
    }

    fn drop_rounding(&mut self) {
        for (sum, size) in self.gradient.iter_mut().zip(&self.magnitude) {
            if is_rounding(*sum, *size) {
                *sum = 0.0;
            }
        }
    }
}

/// Is a derivative only the rounding of terms of this mean size that cancel?
#[inline(always)]
fn is_rounding(sum: f64, size: f64) -> bool {
    sum.abs() <= 8.0 * f64::EPSILON * size
}

fn accumulate([sum, size]: &mut [Vector3<f64>; 2], direction: &Vector3<f64>, slope: f64) {
    *sum += direction * slope;
    *size += direction.abs() * slope.abs();
}

/// `sums += weights * parts`.
#[inline(always)]
fn plus(sums: &mut Lane, weights: &Lane, parts: &Lane) {
    for ((sum, weight), part) in sums.iter_mut().zip(weights).zip(parts) {
        *sum += weight * part;
    }
}

/// [`accumulate`] at four instants.
#[inline(always)]
fn steepen([sum, size]: &mut [Vectors; 2], direction: &Vector3<f64>, slope: &Lane) {
    for (i, part) in direction.iter().enumerate() {
        for ((sum, size), slope) in sum[i].iter_mut().zip(&mut size[i]).zip(slope) {
            *sum += part * slope;
            *size += part.abs() * slope.abs();
        }
    }
}

#[inline(always)]
fn dot(a: &Vectors, b: &Vectors) -> Lane {
    std::array::from_fn(|l| a[0][l] * b[0][l] + a[1][l] * b[1][l] + a[2][l] * b[2][l])
}

#[inline(always)]
fn along(direction: &Vector3<f64>, v: &Vectors) -> Lane {
    std::array::from_fn(|l| direction.x * v[0][l] + direction.y * v[1][l] + direction.z * v[2][l])
}
