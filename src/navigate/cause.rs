//! Possible causes of the difference between measured and predicted navigation errors: constant errors of the unit and the start, errors that
//! change in time, random walks, faults of the reference, single values.

use super::errors::{AXES, DIRECTIONS, ErrorSource, ImuErrors, Instrument, Kind};
use super::measured::{CHANNEL_NAMES, CHANNELS, si_per_unit};
use crate::elements::Elements;
use std::f64::consts::TAU;
use std::mem::{Discriminant, discriminant};

/// Size of a difference by a time, a period or a phase, as a share of the run, of itself or in rad: the relative error of such a central difference is of the order
/// of its square, and a millionth of a derivative changes no digit of `u`; twelve digits of the difference are left.
const BESIDE: f64 = 1e-3;

/// How an error of the unit changes in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    /// `x t`.
    Ramp,
    /// `x` from this time on, s.
    Step(f64),
    /// `x exp(-t / T)`, `T` in s.
    WarmUp(f64),
    /// `x sin(2 pi t / T + phase)`: a temperature that cycles.
    Wave {
        /// `T`, s.
        period: f64,
        /// Phase at the start, rad.
        phase: f64,
    },
    /// `x` and `-x` in turn: what is switched periodically.
    Square {
        /// `T`, s.
        period: f64,
        /// A middle of `x`, s.
        middle: f64,
        /// The share of `T` in which it is `x`.
        share: f64,
    },
}

/// A possible cause.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cause {
    /// A constant error of the unit or the start: what a mission file can hold.
    Constant(ErrorSource),
    /// A bias that changes in time.
    Changing(ErrorSource, Change),
    /// A random walk of the gyros or the accelerometers, the same on each axis, that the mission does not state.
    RandomWalk(Instrument),
    /// A random walk of the biases of the gyros or the accelerometers: of one axis, or the same on each (`None`). No mission states it.
    BiasWalk(Instrument, Option<usize>),
    /// The reference is wrong in one channel: by a constant (`None`), or by what changes in time.
    Reference(usize, Option<Change>),
    /// One value is wrong: the number of its row (from 1, runs after one another), its channel, and its place among all values.
    Reading {
        /// Number of the row, from 1.
        row: usize,
        /// The channel.
        channel: usize,
        /// Place among all measured values.
        at: usize,
    },
}

impl PartialEq<ErrorSource> for Cause {
    fn eq(&self, other: &ErrorSource) -> bool {
        matches!(self, Cause::Constant(source) if source == other)
    }
}

impl Change {
    /// `f(t)`.
    pub fn at(self, time: f64) -> f64 {
        match self {
            Change::Ramp => time,
            Change::Step(start) => f64::from(u8::from(time >= start)),
            Change::WarmUp(constant) => (-time / constant).exp(),
            Change::Wave { period, phase } => (TAU * time / period + phase).sin(),
            Change::Square { period, middle, share } => {
                let turn = (time - middle) / period + 0.5 * share;
                if turn.rem_euclid(1.0) < share { 1.0 } else { -1.0 }
            }
        }
    }

    /// Changes next to it on either side, for each of its times, periods and phases; in a run that lasts so long, s.
    pub fn beside(self, last: f64) -> Vec<[Change; 2]> {
        let sides = |of: &dyn Fn(f64) -> Change| [-BESIDE, BESIDE].map(of);
        let turned = |period: f64, by: f64| 1.0 / (1.0 / period + by / last);
        match self {
            Change::Ramp => Vec::new(),
            Change::Step(start) => vec![sides(&|by| Change::Step(start + by * last))],
            Change::WarmUp(constant) => vec![sides(&|by| Change::WarmUp(constant * by.exp()))],
            Change::Wave { period, phase } => vec![
                sides(&|by| Change::Wave { period: turned(period, by), phase }),
                sides(&|by| Change::Wave { period, phase: phase + by }),
            ],
            Change::Square { period, middle, share } => vec![
                sides(&|by| Change::Square { period: turned(period, by), middle, share }),
                sides(&|by| Change::Square { period, middle: middle + by * period, share }),
                sides(&|by| Change::Square { period, middle, share: share * by.exp() }),
            ],
        }
    }

    /// Mean of `f` between two times, `int_a^b f dt / (b - a)`.
    pub fn mean(self, a: f64, b: f64) -> f64 {
        if !(b > a) {
            return self.at(a);
        }
        match self {
            Change::Ramp => 0.5 * (a + b),
            Change::Step(start) => ((b - start) / (b - a)).clamp(0.0, 1.0),
            Change::WarmUp(constant) => constant * ((-a / constant).exp() - (-b / constant).exp()) / (b - a),
            Change::Wave { period, phase } => {
                // the difference of two cosines as a product: no digits are lost where the time between them is short
                let half = 0.5 * TAU * (b - a) / period;
                (0.5 * TAU * (a + b) / period + phase).sin() * sinc(half)
            }
            Change::Square { period, middle, share } => {
                // the time at x since a beginning of x
                let at_x = |time: f64| {
                    let turn = (time - middle) / period + 0.5 * share;
                    period * (turn.floor() * share + turn.rem_euclid(1.0).min(share))
                };
                2.0 * (at_x(b) - at_x(a)) / (b - a) - 1.0
            }
        }
    }

    fn id(self) -> String {
        match self {
            Change::Ramp => "ramp".into(),
            Change::Step(start) => format!("step({start:.0})"),
            Change::WarmUp(constant) => format!("warm-up({constant:.0})"),
            Change::Wave { period, .. } => format!("wave({period:.0})"),
            Change::Square { period, .. } => format!("square-wave({period:.0})"),
        }
    }

    fn in_words(self) -> String {
        match self {
            Change::Ramp => "growing with time".into(),
            Change::Step(start) => format!("from {:.2} h on", start / 3600.0),
            Change::WarmUp(constant) => format!("dying away in {:.2} h", constant / 3600.0),
            Change::Wave { period, phase } => format!("as sin(2 pi t/({:.3} h) {phase:+.2})", period / 3600.0),
            Change::Square { period, share, .. } => {
                format!("as a square wave of {:.3} h, {share:.2} of it at this value", period / 3600.0)
            }
        }
    }
}

/// `sin(x)/x`; by its series where six terms are exact to the last digit.
fn sinc(x: f64) -> f64 {
    let s = x * x;
    match s < 0.04 {
        true => 1.0 - s / 6.0 * (1.0 - s / 20.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0 * (1.0 - s / 110.0)))),
        false => x.sin() / x,
    }
}

impl Cause {
    /// Its name: `gyro_bias_x`, `gyro_bias_x:ramp`, `reference:phi_up_arcsec`, `reference:position_east_m:step(7200)`, `rate_random_walk_x`,
    /// `reading:17`.
    pub fn id(&self) -> String {
        match self {
            Cause::Constant(source) => source.id(),
            Cause::Changing(source, change) => format!("{}:{}", source.id(), change.id()),
            Cause::RandomWalk(Instrument::Gyro) => "angle_random_walk".into(),
            Cause::RandomWalk(_) => "velocity_random_walk".into(),
            Cause::BiasWalk(instrument, axis) => {
                let walk =
                    if *instrument == Instrument::Gyro { "rate_random_walk" } else { "acceleration_random_walk" };
                axis.map_or(walk.into(), |axis| format!("{walk}_{}", AXES.at(axis)))
            }
            Cause::Reference(channel, None) => format!("reference:{}", column(*channel)),
            Cause::Reference(channel, Some(change)) => format!("reference:{}:{}", column(*channel), change.id()),
            Cause::Reading { row, .. } => format!("reading:{row}"),
        }
    }

    /// Its name in the field's words.
    pub fn name(&self) -> String {
        match self {
            Cause::Constant(source) => name(source),
            Cause::Changing(source, change) => format!("{}, {}", name(source), change.in_words()),
            Cause::RandomWalk(Instrument::Gyro) => "angle random walk of the gyros, the same on each axis".into(),
            Cause::RandomWalk(_) => "velocity random walk of the accelerometers, the same on each axis".into(),
            Cause::BiasWalk(Instrument::Gyro, None) => "rate random walk of the gyros, the same on each axis".into(),
            Cause::BiasWalk(Instrument::Gyro, Some(axis)) => {
                format!("rate random walk of the {} gyro", AXES.at(*axis))
            }
            Cause::BiasWalk(_, None) => "acceleration random walk of the accelerometers, the same on each axis".into(),
            Cause::BiasWalk(_, Some(axis)) => {
                format!("acceleration random walk of the {} accelerometer", AXES.at(*axis))
            }
            Cause::Reference(2, None) => "heading offset of the reference".into(),
            Cause::Reference(channel, None) => format!("offset of the reference in {}", column(*channel)),
            Cause::Reference(channel, Some(Change::Ramp)) => format!("drift of the reference in {}", column(*channel)),
            Cause::Reference(channel, Some(change)) => {
                format!("offset of the reference in {}, {}", column(*channel), change.in_words())
            }
            Cause::Reading { row, channel, .. } => format!("{} of row {row}, a single value", column(*channel)),
        }
    }

    /// The unit in which reports give it.
    pub fn unit(&self) -> String {
        let unit = match self {
            Cause::Constant(source) | Cause::Changing(source, _) => source.unit(),
            Cause::RandomWalk(Instrument::Gyro) => "deg/sqrt(h)",
            Cause::RandomWalk(_) => "(m/s)/sqrt(h)",
            Cause::BiasWalk(Instrument::Gyro, _) => "(deg/h)/sqrt(h)",
            Cause::BiasWalk(..) => "g/sqrt(h)",
            Cause::Reference(channel, _) | Cause::Reading { channel, .. } => channel_unit(*channel),
        };
        match self.change() {
            Some(Change::Ramp) if unit.contains('/') => format!("({unit})/h"),
            Some(Change::Ramp) => format!("{unit}/h"),
            _ => unit.into(),
        }
    }

    /// SI value of one of [`Cause::unit`].
    pub fn si_per_unit(&self) -> f64 {
        let si = match self {
            Cause::Constant(source) | Cause::Changing(source, _) => source.si_per_unit(),
            Cause::RandomWalk(Instrument::Gyro) => 1f64.to_radians() / 60.0,
            Cause::RandomWalk(_) => 1.0 / 60.0,
            Cause::BiasWalk(Instrument::Gyro, _) => 1f64.to_radians() / 3600.0 / 60.0,
            Cause::BiasWalk(..) => super::earth::STANDARD_GRAVITY / 60.0,
            Cause::Reference(channel, _) | Cause::Reading { channel, .. } => si_per_unit(*channel),
        };
        if self.change() == Some(Change::Ramp) { si / 3600.0 } else { si }
    }

    /// The largest size, SI, that is plausible.
    pub(crate) fn limit(&self) -> f64 {
        match self {
            Cause::Constant(source) => source.limit(),
            // over an hour
            Cause::Changing(source, Change::Ramp) => source.limit() / 3600.0,
            Cause::Changing(source, _) => source.limit(),
            Cause::RandomWalk(_) | Cause::BiasWalk(..) | Cause::Reference(..) | Cause::Reading { .. } => f64::INFINITY,
        }
    }

    /// The error of a mission file, where it is one.
    pub fn constant(&self) -> Option<ErrorSource> {
        match self {
            Cause::Constant(source) => Some(*source),
            _ => None,
        }
    }

    /// Its value in the errors of a mission, SI; `None` where those do not hold it.
    pub fn of(&self, errors: &ImuErrors) -> Option<f64> {
        match self {
            Cause::Constant(source) => Some(source.of(errors)),
            Cause::RandomWalk(Instrument::Gyro) => Some(errors.gyro.random_walk),
            Cause::RandomWalk(_) => Some(errors.accelerometer.random_walk),
            _ => None,
        }
    }

    /// Order among causes that the data cannot distinguish: the most common first.
    pub fn rank(&self) -> f64 {
        match self {
            Cause::Constant(source) => match source.kind {
                Kind::Bias => 0.0,
                Kind::ScaleFactor | Kind::Installation => 1.0,
                Kind::Attitude | Kind::AccelerationSensitive => 2.0,
                Kind::Velocity | Kind::Position => 3.0,
                Kind::SecondOrder => 4.0,
            },
            Cause::Reference(_, None) => 3.5,
            Cause::Changing(_, Change::Ramp) | Cause::Reference(_, Some(Change::Ramp)) => 4.0,
            // its period and its phase are fitted too
            Cause::Changing(_, Change::Wave { .. } | Change::Square { .. })
            | Cause::Reference(_, Some(Change::Wave { .. } | Change::Square { .. })) => 6.0,
            Cause::Changing(..) | Cause::Reference(..) => 5.0,
            Cause::RandomWalk(_) | Cause::BiasWalk(..) => 4.0,
            Cause::Reading { .. } => 0.0,
        }
    }

    /// How it changes in time.
    pub(super) fn change(&self) -> Option<Change> {
        match self {
            Cause::Changing(_, change) | Cause::Reference(_, Some(change)) => Some(*change),
            _ => None,
        }
    }

    /// The same bias or channel with this change; `None` for what is neither.
    pub(super) fn with_change(&self, change: Change) -> Option<Cause> {
        match self {
            Cause::Changing(source, _) => Some(Cause::Changing(*source, change)),
            Cause::Reference(channel, _) => Some(Cause::Reference(*channel, Some(change))),
            _ => None,
        }
    }

    /// The same for causes that differ only in the time, the period or the phase of their change.
    pub(super) fn family(&self) -> (Cause, Option<Discriminant<Change>>) {
        (self.with_change(Change::Ramp).unwrap_or(*self), self.change().as_ref().map(discriminant))
    }

    /// Does it change in time as a ramp, a step, a warm-up, a wave or a square wave?
    pub(crate) fn is_course(&self) -> bool {
        self.change().is_some()
    }

    /// Is it a constant error of the unit or the start?
    pub(crate) fn is_constant(&self) -> bool {
        matches!(self, Cause::Constant(_))
    }

    /// A constant bias of a sensor?
    pub(super) fn is_bias(&self) -> bool {
        self.constant().is_some_and(|source| source.kind == Kind::Bias && source.instrument != Instrument::Start)
    }
}

/// All causes but single values, waves and square waves (`periodic.rs` looks for these): constants as in [`ErrorSource::catalogue`], then faults of the reference in the channels that are measured, then
/// biases that change, with steps at so many times of a run of this duration (s).
pub(super) fn catalogue(measured: &[bool; CHANNELS], duration: f64, steps: usize) -> Vec<Cause> {
    let mut causes: Vec<Cause> = ErrorSource::catalogue().into_iter().map(Cause::Constant).collect();
    let times: Vec<f64> = (1..steps).map(|k| duration * k as f64 / steps as f64).collect();
    let channels = || measured.iter().enumerate().filter(|(_, is)| **is).map(|(channel, _)| channel);
    causes.extend(channels().map(|channel| Cause::Reference(channel, None)));
    causes.extend(channels().map(|channel| Cause::Reference(channel, Some(Change::Ramp))));
    let mut changes = vec![Change::Ramp];
    changes.extend([0.03, 0.1, 0.3].map(|share| Change::WarmUp(share * duration)));
    changes.extend(times.iter().map(|time| Change::Step(*time)));
    for bias in ErrorSource::biases() {
        causes.extend(changes.iter().map(|change| Cause::Changing(bias, *change)));
    }
    for channel in channels() {
        causes.extend(times.iter().map(|time| Cause::Reference(channel, Some(Change::Step(*time)))));
    }
    causes
}

fn column(channel: usize) -> &'static str {
    CHANNEL_NAMES.at(channel)
}

fn channel_unit(channel: usize) -> &'static str {
    match channel {
        0..3 => "arcsec",
        3 | 4 => "m/s",
        _ => "m",
    }
}

/// An error source in the field's words.
fn name(source: &ErrorSource) -> String {
    let (sensor_axis, direction) = (AXES.at(source.axis), DIRECTIONS.at(source.axis));
    let instrument = source.instrument;
    match source.kind {
        Kind::Bias => format!("bias of the {sensor_axis} {instrument}"),
        Kind::ScaleFactor => format!("scale factor error of the {sensor_axis} {instrument}"),
        Kind::Installation => {
            format!("installation error of the {sensor_axis} {instrument} towards {}", AXES.at(source.input))
        }
        Kind::SecondOrder => format!("second-order coefficient of the {sensor_axis} {instrument}"),
        Kind::AccelerationSensitive => {
            format!("acceleration-sensitive drift of the {sensor_axis} gyro along {}", AXES.at(source.input))
        }
        Kind::Attitude if source.axis == 2 => "azimuth error at the start".into(),
        Kind::Attitude => format!("tilt about {direction} at the start"),
        Kind::Velocity => format!("{direction} velocity error at the start"),
        Kind::Position => format!("{direction} position error at the start"),
    }
}
