//! The motion of the vehicle: at rest, swinging about a fixed place, or in legs along a heading, with turns and optional swinging.
//!
//! Attitude `C_b^n = Rot(z, yaw) Rot(x, pitch) Rot(y, roll)` takes body components (x right, y forward, z up) to east,
//! north, up; yaw is counted counter-clockwise from north, so a heading is minus a yaw.

use super::earth::Curvature;
use crate::error::{Fault, Malformed, Result};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Where a mission starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Site {
    /// Geodetic latitude, rad.
    pub latitude_rad: f64,
    /// Longitude, rad.
    pub longitude_rad: f64,
    /// Altitude above the ellipsoid, m; the vertical channel is held there.
    pub altitude_m: f64,
}

/// One angle of the attitude: `mean + amplitude sin(2 pi t / period + phase)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Oscillation {
    /// Mean, rad.
    pub mean: f64,
    /// Amplitude, rad; zero for a constant angle.
    pub amplitude: f64,
    /// Period, s.
    pub period: f64,
    /// Phase at the start, rad.
    pub phase: f64,
}

impl Oscillation {
    /// A constant angle, rad.
    pub fn constant(mean: f64) -> Self {
        Oscillation { mean, amplitude: 0.0, period: 1.0, phase: 0.0 }
    }

    /// The angle at a time, rad. The phase is reduced in cycles, so that days from the start cost no digits.
    pub fn at(&self, time: f64) -> f64 {
        self.mean + self.amplitude * (TAU * (time / self.period).fract() + self.phase).sin()
    }
}

/// The three angles of the attitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attitude {
    /// About the body's x (right), positive nose up.
    pub pitch: Oscillation,
    /// About the body's y (forward).
    pub roll: Oscillation,
    /// About the vertical, counter-clockwise from north.
    pub yaw: Oscillation,
}

/// One leg along the heading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leg {
    /// Duration, s; the last leg may be infinite and ends with the mission.
    pub duration: f64,
    /// Acceleration along the heading, m/s^2.
    pub acceleration: f64,
    /// Rate of the heading, rad/s clockwise; 0 keeps it (a rhumb line). Turns are flat: the vehicle does not bank.
    pub turn: f64,
}

/// A leg at its place in the mission.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stage {
    /// When it starts, s.
    pub start: f64,
    /// Velocity along the heading there, m/s.
    pub speed: f64,
    /// How far the heading has turned until there, rad clockwise.
    pub turned: f64,
    /// The leg, ended where the mission ends.
    pub leg: Leg,
}

impl Stage {
    /// Velocity along the heading and how far it has turned, at a time, s.
    pub fn at(&self, time: f64) -> (f64, f64) {
        let since = time - self.start;
        (self.speed + self.leg.acceleration * since, self.turned + self.leg.turn * since)
    }
}

/// Legs along a heading that turns only where a leg says so.
#[derive(Debug, Clone, PartialEq)]
pub struct Legs {
    /// Heading at the start, rad clockwise from north.
    pub heading: f64,
    /// Velocity along the heading at the start, m/s.
    pub speed: f64,
    /// One leg after another.
    pub legs: Vec<Leg>,
}

/// Whether the vehicle stays or moves.
#[derive(Debug, Clone, PartialEq)]
pub enum Path {
    /// It stays at the site.
    Stays,
    /// It runs along its heading.
    Legs(Legs),
}

/// A motion: its name, attitude and path.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// What reports call it: `static`, `swing`, `legs`.
    pub name: String,
    /// The attitude in time.
    pub attitude: Attitude,
    /// The path.
    pub path: Path,
}

impl Default for Motion {
    /// At rest, level, heading north.
    fn default() -> Self {
        Motion::at_rest(0.0, 0.0, 0.0)
    }
}

impl Motion {
    /// At rest with the given pitch, roll and yaw, rad.
    pub fn at_rest(pitch: f64, roll: f64, yaw: f64) -> Self {
        let attitude = Attitude {
            pitch: Oscillation::constant(pitch),
            roll: Oscillation::constant(roll),
            yaw: Oscillation::constant(yaw),
        };
        Motion { name: "static".into(), attitude, path: Path::Stays }
    }

    /// Swinging about a fixed place; periods in s, angles in rad.
    ///
    /// Errors: a period that is not positive, an amplitude of a right angle or more, a pitch that passes the vertical.
    pub fn swing(attitude: Attitude) -> Result<Self> {
        Motion::check_swing(attitude)?;
        Ok(Motion { name: "swing".into(), attitude, path: Path::Stays })
    }

    /// Legs with a swing about the heading (its yaw counts from minus the heading). Errors: as [`Motion::swing`].
    pub(crate) fn swinging_legs(legs: Legs, mut attitude: Attitude) -> Result<Self> {
        Motion::check_swing(attitude)?;
        attitude.yaw.mean -= legs.heading;
        Ok(Motion { name: "legs".into(), attitude, path: Path::Legs(legs) })
    }

    fn check_swing(attitude: Attitude) -> Result<()> {
        for (name, angle) in [("pitch", attitude.pitch), ("roll", attitude.roll), ("yaw", attitude.yaw)] {
            let wrong = |key: &str, expected: &str, found: f64| {
                Malformed::new(Fault::Value, format!("the swing in {name} is not possible"))
                    .at_path(format!("swing.{name}.{key}"))
                    .expected(expected)
                    .found(format!("{found}"))
            };
            if !(angle.period > 0.0 && angle.period.is_finite()) {
                return Err(wrong("period_s", "a period above 0 s", angle.period));
            }
            if !(angle.amplitude.abs() < FRAC_PI_2) {
                return Err(wrong("amplitude_deg", "less than 90 degrees", angle.amplitude.to_degrees()));
            }
            if !(angle.phase.is_finite() && angle.mean.is_finite()) {
                return Err(wrong("phase_deg", "a finite angle", angle.phase.to_degrees()));
            }
            if name == "pitch" && !(angle.mean.abs() + angle.amplitude.abs() < FRAC_PI_2) {
                let found = (angle.mean.abs() + angle.amplitude.abs()).to_degrees();
                return Err(wrong("amplitude_deg", "a pitch that stays below 90 degrees", found));
            }
        }
        Ok(())
    }

    /// Level along a constant heading.
    pub(crate) fn legs(legs: Legs) -> Self {
        let attitude = Motion::at_rest(0.0, 0.0, -legs.heading).attitude;
        Motion { name: "legs".into(), attitude, path: Path::Legs(legs) }
    }

    /// Upper bound of the body's rate of rotation, rad/s, without the Earth's.
    pub(crate) fn fastest_rate(&self) -> f64 {
        let Attitude { pitch, roll, yaw } = self.attitude;
        let turning = match &self.path {
            Path::Stays => 0.0,
            Path::Legs(legs) => legs.legs.iter().fold(0.0_f64, |most, leg| most.max(leg.turn.abs())),
        };
        turning + [pitch, roll, yaw].iter().map(|angle| angle.amplitude.abs() * TAU / angle.period).sum::<f64>()
    }

    /// The shortest period of the motion, s; infinite for one without oscillation.
    pub(crate) fn shortest_period(&self) -> f64 {
        let Attitude { pitch, roll, yaw } = self.attitude;
        let moving = [pitch, roll, yaw].into_iter().filter(|angle| angle.amplitude != 0.0);
        moving.map(|angle| angle.period).fold(f64::INFINITY, f64::min)
    }
}

impl Legs {
    /// Each leg at its place, until the mission's end.
    pub(crate) fn schedule(&self, end: f64) -> Vec<Stage> {
        let (mut start, mut speed, mut turned) = (0.0, self.speed, 0.0);
        let mut schedule = Vec::with_capacity(self.legs.len());
        for leg in &self.legs {
            let duration = leg.duration.min((end - start).max(0.0));
            let stage = Stage { start, speed, turned, leg: Leg { duration, ..*leg } };
            schedule.push(stage);
            start += duration;
            (speed, turned) = stage.at(start);
        }
        schedule
    }

    /// The legs fill the mission, start on steps, keep a possible speed and do not run over a pole.
    pub(crate) fn check(&self, site: Site, step: f64, end: f64) -> Result<()> {
        let wrong = |what: &str, path: String, expected: &str, found: String| {
            Err(Malformed::new(Fault::Value, what).at_path(path).expected(expected).found(found))
        };
        if !(self.heading.is_finite() && self.speed.is_finite()) {
            return wrong("not a heading and speed", "legs".into(), "finite numbers", format!("{}", self.speed));
        }
        let (mut time, mut speed) = (0.0, self.speed);
        for (i, leg) in self.legs.iter().enumerate() {
            let path = |key: &str| format!("legs.legs[{i}].{key}");
            let open = leg.duration == f64::INFINITY;
            if open && i + 1 < self.legs.len() {
                let expected = "a duration for every leg but the last";
                return wrong("a leg without end has others after it", path("duration_s"), expected, "none".into());
            }
            if !(leg.duration > 0.0) || !leg.acceleration.is_finite() || !leg.turn.is_finite() {
                let found = format!("{} s at {} m/s^2", leg.duration, leg.acceleration);
                return wrong("not a leg", path("duration_s"), "a duration above 0 s and finite numbers", found);
            }
            let duration = if open { end - time } else { leg.duration };
            if !(duration > 0.5 * step) || time + duration > end + step {
                let found = format!("the leg starts at {time} s of {end} s and needs {} s", leg.duration);
                return wrong("the legs leave no time", path("duration_s"), "legs that end with the mission", found);
            }
            let steps = duration / step;
            if (steps - steps.round()).abs() > 1e-6 * steps.max(1.0) {
                let (found, expected) = (format!("{steps} steps of {step} s"), "a whole number of steps");
                return wrong("a leg ends within a step", path("duration_s"), expected, found);
            }
            time += duration;
            speed += leg.acceleration * duration;
            if !(speed.abs() <= 3000.0) {
                let found = format!("{speed} m/s after this leg");
                return wrong("the legs reach an impossible speed", path("acceleration_m_s2"), "below 3 km/s", found);
            }
        }
        if self.legs.is_empty() || time < end - step {
            let found = format!("{time} s of legs in {end} s");
            return wrong("the legs end before the mission", "legs.legs".into(), "a last leg without duration", found);
        }
        let highest = self.highest_latitude(site, end).to_degrees();
        if !(highest <= 89.0 + 1e-9) {
            let found = format!("{highest:.2} degrees");
            return wrong("the legs run towards a pole", "legs".into(), "latitudes from -89 to 89 degrees", found);
        }
        Ok(())
    }

    /// The largest latitude by size that the legs reach, rad: northing over the smallest radius of curvature, in small parts.
    fn highest_latitude(&self, site: Site, end: f64) -> f64 {
        const PARTS: usize = 1000;
        let radius = Curvature::at(0.0, site.altitude_m).meridian;
        let (mut latitude_rad, mut highest) = (site.latitude_rad, site.latitude_rad.abs());
        for stage in self.schedule(end) {
            let span = stage.leg.duration / PARTS as f64;
            for part in 0..PARTS {
                let (speed, turned) = stage.at(stage.start + (part as f64 + 0.5) * span);
                let north = (self.heading + turned).cos();
                // due east and west stay on their parallel: a cosine of rounding is none
                latitude_rad += if north.abs() < 1e-12 { 0.0 } else { speed * north * span / radius };
                highest = highest.max(latitude_rad.abs());
            }
        }
        highest
    }
}
