//! A random walk that a mission does not state (`unstated_walk.rs` looks for one).

use super::cause::Cause;
use super::errors::{ImuErrors, Instrument};
use super::mission::Mission;

/// Such a random walk.
#[derive(Debug, Clone)]
pub(super) struct UnstatedWalk {
    pub cause: Cause,
    /// Its density, SI.
    pub density: f64,
    pub u: f64,
    /// `-2 ln L` with it, but for the constant that it has without.
    pub deviance: f64,
    /// By how much it is less than that of none.
    pub gain: f64,
    /// Other walks, with their density and by how much their deviance is larger.
    pub others: Vec<(Cause, f64, f64)>,
}

impl UnstatedWalk {
    /// The mission with it, where a mission can state it.
    pub fn stated(&self, mission: &Mission) -> Option<Mission> {
        let Cause::RandomWalk(instrument) = self.cause else { return None };
        let mut mission = mission.clone();
        mission.errors = with(&mission.errors, instrument, self.density);
        Some(mission)
    }
}

/// The errors with a random walk of a triad.
pub(super) fn with(errors: &ImuErrors, instrument: Instrument, density: f64) -> ImuErrors {
    let mut errors = *errors;
    let triad = if instrument == Instrument::Gyro { &mut errors.gyro } else { &mut errors.accelerometer };
    triad.random_walk = triad.random_walk.hypot(density);
    errors
}
