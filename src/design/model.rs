//! Model lines bound to a campaign, ready to predict readings: inputs once for each reading, the lines of all its sensors, means over turns.
#![allow(
    clippy::indexing_slicing,
    reason = "vectors have three components and lanes `L` numbers, and the loops run over these lengths"
)]

use super::kinematics::{Field, Instants, Vectors, Wanted};
use super::line::{SensorModel, Slot};
use super::mean::{Sweep, sweep};
use super::{Context, Kinematics, Smoothness, kinematics};
use crate::algebra::{Lane, Scratch, lanes};
use crate::bench::Bench;
use crate::campaign::{Campaign, JointState, Reading};
use crate::elements::{Elements, OrNan};
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
    pub(super) inputs: Vec<f64>,
    pub(super) scratch: Scratch,
    gathered: Vec<Gathered>,
    sweep: Sweep,
    one: Room<1>,
    four: Room<4>,
    arch: Arch,
}

/// What is summed up at `L` places side by side: instants of a reading, or devices with points of their own.
#[derive(Debug, Clone)]
pub(crate) struct Room<const L: usize> {
    tilts: Vec<Lane<L>>,
    inputs: Vec<Lane<L>>,
    slopes: Vec<Lane<L>>,
    at: Instants<L>,
    sums: Vec<Sums<L>>,
}

/// Mean of one sensor's line over a reading, and each derivative with the mean size of its terms.
#[derive(Debug, Clone)]
struct Sums<const L: usize> {
    mean: Lane<L>,
    derivatives: Vec<[Lane<L>; 2]>,
}

impl<const L: usize> Default for Room<L> {
    fn default() -> Self {
        Room { tilts: Vec::new(), inputs: Vec::new(), slopes: Vec::new(), at: Instants::default(), sums: Vec::new() }
    }
}

impl SensorModel {
    /// The line at one instant, given the kinematics there.
    pub(crate) fn value_at(&self, context: &Context<'_>, work: &mut Workspace) -> f64 {
        self.fill(context, &mut work.inputs);
        self.tape.value(&work.inputs, &mut work.scratch)
    }
}

/// What stands at `L` places side by side; every joint of the chain has a state.
trait Places<const L: usize> {
    fn angle_deg(&self, joint: usize) -> Lane<L>;
    fn rate_deg_s(&self, joint: usize) -> Lane<L>;
    /// Not a number where the reading lacks it: such a reading was refused, or its devices are.
    fn column(&self, column: usize) -> Lane<L>;
    fn parameter(&self, parameter: usize) -> Lane<L>;
}

/// One reading at `L` instants, or for `L` devices.
struct Stops<'a, P, const L: usize> {
    row: &'a Reading,
    sweep: &'a Sweep,
    /// Angles of the joint that passes them.
    angle_deg: Lane<L>,
    parameter: P,
}

impl<P: Fn(usize) -> Lane<L>, const L: usize> Places<L> for Stops<'_, P, L> {
    #[inline(always)]
    fn angle_deg(&self, joint: usize) -> Lane<L> {
        match self.sweep.joint == Some(joint) {
            true => self.angle_deg,
            false => [self.sweep.base.angle_deg.at(joint); L],
        }
    }
    #[inline(always)]
    fn rate_deg_s(&self, joint: usize) -> Lane<L> {
        [self.sweep.base.rate_deg_s.at(joint); L]
    }
    #[inline(always)]
    fn column(&self, column: usize) -> Lane<L> {
        [number(self.row, column); L]
    }
    #[inline(always)]
    fn parameter(&self, parameter: usize) -> Lane<L> {
        (self.parameter)(parameter)
    }
}

/// Places of a list that a line is evaluated at together: the registers and bars of a tape of twenty steps then take 10 kB, a third of a first-level cache, and the cost of
/// decoding a step is small compared with that of 32 numbers.
const TOGETHER: usize = 32;

/// Room for so many places.
pub(crate) type Together = Room<TOGETHER>;

/// Places of lists, from one on; where the last are fewer, the last one again. No line of columns alone follows a joint.
struct Listed<'a> {
    columns: &'a [(usize, &'a [f64])],
    start: usize,
    point: &'a [f64],
}

impl Places<TOGETHER> for Listed<'_> {
    #[inline(always)]
    fn angle_deg(&self, _: usize) -> Lane<TOGETHER> {
        [0.0; TOGETHER]
    }
    #[inline(always)]
    fn rate_deg_s(&self, _: usize) -> Lane<TOGETHER> {
        [0.0; TOGETHER]
    }
    #[inline(always)]
    fn column(&self, column: usize) -> Lane<TOGETHER> {
        let list = self.columns.iter().find(|(own, _)| *own == column).map_or(&[][..], |(_, list)| list);
        match list.get(self.start..).and_then(<[f64]>::first_chunk) {
            Some(whole) => *whole,
            None => lanes(|l| list.or_nan((self.start + l).min(list.len().saturating_sub(1)))),
        }
    }
    #[inline(always)]
    fn parameter(&self, parameter: usize) -> Lane<TOGETHER> {
        [self.point.at(parameter); TOGETHER]
    }
}

fn number(row: &Reading, column: usize) -> f64 {
    row.columns.get(column).copied().flatten().unwrap_or(f64::NAN)
}

/// Sums of every sensor whose line is of this smoothness, over places with weights.
struct Gather<'a, I, const L: usize> {
    model: &'a Model,
    bench: &'a Bench,
    smoothness: Smoothness,
    gathered: &'a [Gathered],
    places: I,
    room: &'a mut Room<L>,
    scratch: &'a mut Scratch,
}

impl<I, P, const L: usize> WithSimd for Gather<'_, I, L>
where
    I: Iterator<Item = (P, Lane<L>)>,
    P: Places<L>,
{
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Gather { model, bench, smoothness, gathered, places, room, scratch } = self;
        let Room { tilts, inputs, slopes, at, sums } = room;
        let alike = |of: &&Gathered| of.smoothness == Some(smoothness);
        let follows = gathered.iter().filter(alike).filter_map(|of| model.sensors.get(of.sensor)).map(|of| of.follows);
        let fields = follows.fold([false; 2], |[rate, force], of| [rate || of[0], force || of[1]]);
        let wanted = Wanted { fields, joints: model.joints > 0 };
        sums.resize_with(gathered.len(), || Sums { mean: [0.0; L], derivatives: Vec::new() });
        let count = model.parameters + model.joints;
        for (_, sums) in gathered.iter().zip(&mut *sums).filter(|(of, _)| alike(of)) {
            sums.mean = [0.0; L];
            sums.derivatives.clear();
            sums.derivatives.resize(count, [[0.0; L]; 2]);
        }
        let joints = bench.joints().count();
        for (places, weights) in places {
            tilts.clear();
            tilts.extend(model.tilts.iter().map(|k| places.parameter(*k)));
            at.set(bench, tilts, (joints, |k| places.angle_deg(k), |k| places.rate_deg_s(k)), wanted);
            for (of, sums) in gathered.iter().zip(&mut *sums).filter(|(of, _)| alike(of)) {
                let Some(line) = model.sensors.get(of.sensor) else { continue };
                inputs.clear();
                inputs.extend(line.slots.iter().map(|slot| match slot {
                    Slot::Rate(direction) => along(direction, &at.fields[0].at),
                    Slot::Force(direction) => along(direction, &at.fields[1].at),
                    Slot::Joint(k) => places.angle_deg(*k).map(f64::to_radians),
                    Slot::Column(k) => places.column(*k),
                    Slot::Parameter(k) => places.parameter(*k),
                }));
                slopes.clear();
                slopes.resize(line.slots.len(), [0.0; L]);
                let reads = line.tape.reads();
                let values = line.tape.gradient_of(|k| inputs[reads[k]], scratch, |k, bar| slopes[reads[k]] = *bar);
                sums.add((values, &weights), (&line.slots, slopes), model, at);
            }
        }
    }
}

/// Mean of one sensor's line over a reading, and its gradient.
#[derive(Debug, Clone, Default)]
struct Gathered {
    sensor: usize,
    smoothness: Option<Smoothness>,
    mean: f64,
    gradient: Vec<f64>,
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

    /// How many derivatives by joints' angles follow those by parameters in a gradient: all joints, or none.
    pub(crate) fn joint_derivatives(&self) -> usize {
        self.joints
    }

    /// Buffers for [`Model::predict`].
    pub fn workspace(&self) -> Workspace {
        Workspace::default()
    }

    /// The tilts of the chain among the values of all parameters, in chain order.
    pub(crate) fn tilts_of(&self, point: &[f64]) -> Vec<f64> {
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
            gradient.iter_mut().zip(slopes).for_each(|(slot, slope)| *slot = *slope);
        })?;
        Ok(mean)
    }

    /// The same for several sensors of one reading, which share the inputs: `visit(place in sensors, mean, gradient)`; where wanted, derivatives
    /// by the joints' angles (rad) follow those by the parameters.
    pub(crate) fn predict_all(
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
        for sensor in sensors {
            let model = self.sensors.get(*sensor).ok_or_else(|| beyond("sensors", *sensor, self.sensors.len()))?;
            if let Some(column) = model.missing_column(&campaign.readings, reading) {
                return Err(missing_column(column).at_path(&row.place));
            }
        }
        work.ask(self, sensors, &row.joints);
        for first in 0..sensors.len() {
            if let Some(smoothness) = new_smoothness(&work.gathered, first) {
                self.gather(campaign, row, smoothness, point, work);
            }
        }
        for (place, gathered) in work.gathered.iter().enumerate() {
            visit(place, gathered.mean, &gathered.gradient);
        }
        Ok(())
    }

    /// Sum up every sensor of this smoothness over the reading's instants, by the widest instructions that there are: one at a time, or where there are several four at a
    /// time.
    fn gather(&self, campaign: &Campaign, row: &Reading, smoothness: Smoothness, point: &[f64], work: &mut Workspace) {
        work.sweep.set(row, smoothness);
        let Workspace { scratch, gathered, sweep, one, four, arch, .. } = work;
        let (model, bench, asked) = (self, &campaign.bench, &*gathered);
        if sweep.joint.is_some() && sweep.stops.len() > 1 {
            // where the last are fewer than four, its last one again with no weight
            let places = sweep.stops.chunks(4).map(|stops| {
                let last = stops.last().map_or(0.0, |(angle, _)| *angle);
                let stop = |l: usize| stops.get(l).copied().unwrap_or((last, 0.0));
                let parameter = |k| [point.at(k); 4];
                (Stops { row, sweep, angle_deg: lanes(|l| stop(l).0), parameter }, lanes(|l| stop(l).1))
            });
            arch.dispatch(Gather { model, bench, smoothness, gathered: asked, places, room: &mut *four, scratch });
            return join(&four.sums, smoothness, gathered);
        }
        let parameter = |k| [point.at(k)];
        let places =
            sweep.each().map(|(angle, weight)| (Stops { row, sweep, angle_deg: [angle], parameter }, [weight]));
        arch.dispatch(Gather { model, bench, smoothness, gathered: asked, places, room: &mut *one, scratch });
        join(&one.sums, smoothness, gathered);
    }

    /// [`Model::predict_all`] at points of `L` devices side by side: `visit(place in sensors, values, gradient)`. A column that the reading lacks is no number.
    pub(crate) fn predict_lanes<const L: usize>(
        &self,
        campaign: &Campaign,
        row: &Reading,
        sensors: &[usize],
        points: &[Lane<L>],
        (work, room): (&mut Workspace, &mut Room<L>),
        visit: impl FnMut(usize, &Lane<L>, &[Lane<L>]),
    ) {
        work.ask(self, sensors, &row.joints);
        for first in 0..sensors.len() {
            let Some(smoothness) = new_smoothness(&work.gathered, first) else { continue };
            work.sweep.set(row, smoothness);
            let Workspace { scratch, gathered, sweep, arch, .. } = &mut *work;
            let (sweep, parameter) = (&*sweep, |k: usize| points.get(k).copied().unwrap_or([f64::NAN; L]));
            let stops = |(angle, weight)| (Stops { row, sweep, angle_deg: [angle; L], parameter }, [weight; L]);
            let (model, bench, places) = (self, &campaign.bench, sweep.each().map(stops));
            arch.dispatch(Gather { model, bench, smoothness, gathered, places, room: &mut *room, scratch });
        }
        self.give(sensors.len(), room, visit);
    }

    /// The line of a sensor that follows columns alone ([`Model::columns_alone`]) at `places` places, of which the columns are lists: `visit(first place, values, gradient)` for some
    /// of them at a time.
    pub(crate) fn predict_lists(
        &self,
        bench: &Bench,
        sensor: usize,
        (columns, places): (&[(usize, &[f64])], usize),
        point: &[f64],
        (work, room): (&mut Workspace, &mut Together),
        mut visit: impl FnMut(usize, &[f64], &[Lane<TOGETHER>]),
    ) {
        work.ask(self, &[sensor], &[]);
        for start in (0..places).step_by(TOGETHER) {
            let Workspace { scratch, gathered, arch, .. } = &mut *work;
            let here = std::iter::once((Listed { columns, start, point }, [1.0; TOGETHER]));
            let (model, smoothness, room) = (self, SensorModel::INSTANT, &mut *room);
            arch.dispatch(Gather { model, bench, smoothness, gathered, places: here, room: &mut *room, scratch });
            let count = TOGETHER.min(places - start);
            self.give(1, room, |_, values, slopes| visit(start, &values[..count], slopes));
        }
    }

    /// What was summed up of so many sensors; what is only rounding is zero.
    fn give<const L: usize>(
        &self,
        sensors: usize,
        room: &mut Room<L>,
        mut visit: impl FnMut(usize, &Lane<L>, &[Lane<L>]),
    ) {
        let Room { sums, slopes, .. } = room;
        for (place, sums) in sums.iter().take(sensors).enumerate() {
            slopes.clear();
            slopes.extend(
                sums.derivatives
                    .iter()
                    .map(|[sums, sizes]| lanes(|l| if is_rounding(sums[l], sizes[l]) { 0.0 } else { sums[l] })),
            );
            visit(place, &sums.mean, slopes);
        }
    }

    /// The smallest part of a sensor's line that has no value at some instant of a reading, and the inputs that stand in it.
    pub(crate) fn without_value(
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

impl Model {
    /// The columns that the line of a sensor follows, where it follows columns and parameters alone; `None` for one of rates, forces or joints.
    pub(crate) fn columns_alone(&self, sensor: usize) -> Option<Vec<usize>> {
        let column = |slot: &Slot| match slot {
            Slot::Column(k) => Some(Some(*k)),
            Slot::Parameter(_) => Some(None),
            Slot::Rate(_) | Slot::Force(_) | Slot::Joint(_) => None,
        };
        let all: Vec<Option<usize>> = self.sensor(sensor)?.slots.iter().map(column).collect::<Option<_>>()?;
        Some(all.into_iter().flatten().collect())
    }
}

impl Workspace {
    /// Takes in what is asked: the mean of these sensors' lines over a reading with such joints.
    fn ask(&mut self, model: &Model, sensors: &[usize], joints: &[JointState]) {
        self.gathered.resize_with(sensors.len(), Gathered::default);
        for (gathered, sensor) in self.gathered.iter_mut().zip(sensors) {
            let smoothness =
                model.sensors.get(*sensor).map_or(Smoothness::Rough, |sensor| sensor.smoothness_for(joints));
            (gathered.sensor, gathered.smoothness) = (*sensor, Some(smoothness));
        }
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

/// The smoothness of a place, unless one before it has the same: sensors of one smoothness average over the same instants.
fn new_smoothness(gathered: &[Gathered], place: usize) -> Option<Smoothness> {
    let smoothness = gathered.get(place)?.smoothness;
    smoothness.filter(|_| gathered.iter().take(place).all(|before| before.smoothness != smoothness))
}

/// Sums of several instants as those of all, in the order of the instants; what is only rounding is zero.
fn join<const L: usize>(sums: &[Sums<L>], smoothness: Smoothness, gathered: &mut [Gathered]) {
    let whole = |lanes: &Lane<L>| lanes.iter().fold(0.0, |sum, lane| sum + lane);
    for (sums, row) in sums.iter().zip(gathered).filter(|(_, row)| row.smoothness == Some(smoothness)) {
        row.mean = whole(&sums.mean);
        row.gradient.clear();
        row.gradient.extend(sums.derivatives.iter().map(|[sum, size]| {
            let sum = whole(sum);
            if is_rounding(sum, whole(size)) { 0.0 } else { sum }
        }));
    }
}

impl<const L: usize> Sums<L> {
    /// Add instants: slopes by parameters as they are, slopes by inputs through the inputs' derivatives by the tilts and joints.
    #[inline(always)]
    fn add(
        &mut self,
        (values, weights): (Lane<L>, &Lane<L>),
        (slots, slopes): (&[Slot], &[Lane<L>]),
        model: &Model,
        at: &Instants<L>,
    ) {
        plus(&mut self.mean, weights, &values);
        let mut add = |parameter: usize, derivative: &Lane<L>, size: &Lane<L>| {
            if let Some([sum, sizes]) = self.derivatives.get_mut(parameter) {
                plus(sum, weights, derivative);
                plus(sizes, weights, size);
            }
        };
        // df/d rate and df/d force, with the sizes of their terms
        let (mut by_rate, mut by_force) = ([[[0.0; L]; 3]; 2], [[[0.0; L]; 3]; 2]);
        for (slot, slope) in slots.iter().zip(slopes) {
            match slot {
                Slot::Parameter(k) => add(*k, slope, &sizes(slope)),
                Slot::Rate(direction) => steepen(&mut by_rate, direction, slope),
                Slot::Force(direction) => steepen(&mut by_force, direction, slope),
                // without derivatives by joints there is no such place, and nothing is added
                Slot::Joint(k) => add(model.parameters + k, slope, &sizes(slope)),
                Slot::Column(_) => {}
            }
        }
        for ([sum, size], Field { by_tilt, by_joint, .. }) in [by_rate, by_force].into_iter().zip(&at.fields) {
            if size == [[0.0; L]; 3] {
                continue;
            }
            let joints = by_joint.iter().take(model.joints).enumerate().map(|(k, by)| (model.parameters + k, by));
            for (parameter, derivative) in model.tilts.iter().copied().zip(by_tilt).chain(joints) {
                let [x, y, z] = derivative;
                add(parameter, &dot(&sum, derivative), &dot(&size, &[sizes(x), sizes(y), sizes(z)]));
            }
        }
    }
}

/// Is a derivative only the rounding of terms of this mean size that cancel? An infinite one is none.
#[inline(always)]
fn is_rounding(sum: f64, size: f64) -> bool {
    sum.is_finite() && sum.abs() <= 8.0 * f64::EPSILON * size
}

/// `sums += weights * parts`.
#[inline(always)]
fn plus<const L: usize>(sums: &mut Lane<L>, weights: &Lane<L>, parts: &Lane<L>) {
    for ((sum, weight), part) in sums.iter_mut().zip(weights).zip(parts) {
        *sum += weight * part;
    }
}

/// Adds a slope along a direction, and its size.
#[inline(always)]
fn steepen<const L: usize>([sum, size]: &mut [Vectors<L>; 2], direction: &Vector3<f64>, slope: &Lane<L>) {
    for (i, part) in direction.iter().enumerate() {
        for ((sum, size), slope) in sum[i].iter_mut().zip(&mut size[i]).zip(slope) {
            *sum += part * slope;
            *size += part.abs() * slope.abs();
        }
    }
}

#[inline(always)]
fn dot<const L: usize>(a: &Vectors<L>, b: &Vectors<L>) -> Lane<L> {
    lanes(|l| a[0][l] * b[0][l] + a[1][l] * b[1][l] + a[2][l] * b[2][l])
}

#[inline(always)]
fn along<const L: usize>(direction: &Vector3<f64>, v: &Vectors<L>) -> Lane<L> {
    lanes(|l| direction.x * v[0][l] + direction.y * v[1][l] + direction.z * v[2][l])
}

#[inline(always)]
fn sizes<const L: usize>(numbers: &Lane<L>) -> Lane<L> {
    lanes(|l| numbers[l].abs())
}
