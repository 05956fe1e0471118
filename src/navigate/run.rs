//! A mission flown: rows of navigation errors as they come, and the outcome of each scenario at the end.
//!
//! Rows go to a sink one at a time, so that memory does not depend on the duration.

use super::errors::ImuErrors;
pub use super::errors::NavigationError;
use super::mechanise::STATES;
use super::mission::Mission;
use super::motion::Motion;
use super::simd_batch::Fleet;
use super::trajectory::{Trajectory, Truth, metres};
use crate::elements::Elements;

/// One set of errors with a name.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// Its name in reports: `all`, `gyro_bias`, `gyro_bias_x`, ...
    pub id: String,
    /// The unit's errors.
    pub errors: ImuErrors,
}

/// One instant of output.
#[derive(Debug)]
pub struct Row<'a> {
    /// The true state.
    pub truth: Truth,
    /// One for each scenario, in their order.
    pub errors: &'a [NavigationError],
}

/// Whether a run should go on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Continue {
    /// Go on.
    Yes,
    /// Stop here; the results so far are returned.
    Stop,
}

/// One quantity of a scenario over the rows of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Summary {
    /// At the last row.
    pub last: f64,
    /// Largest of all rows.
    pub max: f64,
    /// Root mean square over all rows.
    pub rms: f64,
}

/// The outcome of one scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The scenario's name.
    pub id: String,
    /// The error at the last row.
    pub last: NavigationError,
    /// Tilt `(phi_E^2 + phi_N^2)^(1/2)`, rad.
    pub tilt: Summary,
    /// Azimuth error `|phi_U|`, rad.
    pub azimuth: Summary,
    /// Horizontal velocity error, m/s.
    pub velocity: Summary,
    /// Horizontal position error, m.
    pub position: Summary,
}

/// The end of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Flight {
    /// Time of the last row, s.
    pub time: f64,
    /// Rows given to the sink.
    pub rows: u64,
    /// One for each scenario.
    pub outcomes: Vec<Outcome>,
}

impl NavigationError {
    /// A navigator's belief, by its states, against the truth.
    pub fn of(belief: &[f64; STATES], truth: &Truth, altitude_m: f64) -> Self {
        // C' C^T as a quaternion: its vector part is -phi/2.
        let [w, x, y, z, east, north, latitude_rad, longitude_rad, ..] = *belief;
        let [tw, tx, ty, tz] = truth.quaternion;
        let scalar = w * tw + x * tx + y * ty + z * tz;
        let vector = [
            -w * tx + x * tw - y * tz + z * ty,
            -w * ty + x * tz + y * tw - z * tx,
            -w * tz - x * ty + y * tx + z * tw,
        ];
        let length = vector.iter().map(|v| v * v).sum::<f64>().sqrt();
        // The rotation vector from the quaternion; for a small one the ratio is 2.
        let ratio = if length > 0.0 { 2.0 * length.atan2(scalar.abs()) / length } else { 2.0 };
        let sign = if scalar < 0.0 { 1.0 } else { -1.0 };
        NavigationError {
            attitude: vector.map(|v| sign * ratio * v),
            velocity: [east - truth.velocity[0], north - truth.velocity[1]],
            position: metres(truth, altitude_m, latitude_rad, longitude_rad),
        }
    }

    /// Tilt, rad.
    pub fn tilt(&self) -> f64 {
        self.attitude[0].hypot(self.attitude[1])
    }

    /// Horizontal velocity error, m/s.
    pub(crate) fn speed(&self) -> f64 {
        self.velocity[0].hypot(self.velocity[1])
    }

    /// Horizontal position error, m.
    pub(crate) fn distance(&self) -> f64 {
        self.position[0].hypot(self.position[1])
    }
}

/// Fly one motion of a mission with all scenarios at once.
///
/// A row is given to `sink` at the start, after every `steps_per_row` steps and at the end. Nothing here fails: a
/// navigator whose errors carry it over a pole goes on as NaN.
pub fn fly(
    mission: &Mission,
    motion: &Motion,
    scenarios: &[Scenario],
    sink: &mut dyn FnMut(&Row<'_>) -> Continue,
) -> Flight {
    fly_to(mission, motion, scenarios, &mut |done| done + mission.steps_per_row, sink)
}

/// The same with rows at any steps: `next` gives the next row's step, from that of the row before (an even
/// number, as the navigator takes samples in pairs).
pub fn fly_to(
    mission: &Mission,
    motion: &Motion,
    scenarios: &[Scenario],
    next_row: &mut dyn FnMut(u64) -> u64,
    sink: &mut dyn FnMut(&Row<'_>) -> Continue,
) -> Flight {
    let mut trajectory = Trajectory::new(mission, motion);
    let errors: Vec<ImuErrors> = scenarios.iter().map(|scenario| scenario.errors).collect();
    let mut fleet = Fleet::new(mission, &mut trajectory, &errors, mission.seed);
    let mut tallies = vec![Tally::default(); scenarios.len()];
    let mut now = vec![NavigationError::default(); scenarios.len()];
    let mut rows = 0;
    let mut next = 0;
    loop {
        if trajectory.done() >= next {
            let truth = trajectory.truth();
            for (i, error) in now.iter_mut().enumerate() {
                if let Some(belief) = fleet.belief(i) {
                    *error = NavigationError::of(&belief, &truth, mission.site.altitude_m);
                }
            }
            for (tally, error) in tallies.iter_mut().zip(&now) {
                tally.add(error);
            }
            rows += 1;
            if sink(&Row { truth, errors: &now }) == Continue::Stop || trajectory.done() >= mission.steps {
                break;
            }
            next = next_row(trajectory.done()).clamp(trajectory.done() + 1, mission.steps);
        }
        let steps = next - trajectory.done();
        fleet.advance(&mut trajectory, steps);
    }
    let outcomes = scenarios.iter().zip(&tallies).zip(&now).map(|((scenario, tally), last)| Outcome {
        id: scenario.id.clone(),
        last: *last,
        tilt: tally.summary(0, rows),
        azimuth: tally.summary(1, rows),
        velocity: tally.summary(2, rows),
        position: tally.summary(3, rows),
    });
    Flight { time: trajectory.truth().time, rows, outcomes: outcomes.collect() }
}

/// Last, largest and sum of squares of tilt, azimuth, velocity, position.
#[derive(Debug, Clone, Copy, Default)]
struct Tally([[f64; 3]; 4]);

impl Tally {
    fn add(&mut self, error: &NavigationError) {
        let values = [error.tilt(), error.attitude[2].abs(), error.speed(), error.distance()];
        for ([last, max, squares], value) in self.0.iter_mut().zip(values) {
            *last = value;
            *max = if value.is_nan() { value } else { max.max(value) };
            *squares += value * value;
        }
    }

    fn summary(&self, quantity: usize, rows: u64) -> Summary {
        let [last, max, squares] = self.0.at(quantity);
        Summary { last, max, rms: (squares / rows.max(1) as f64).sqrt() }
    }
}
