//! Random walks that a mission does not state (`unstated_walk.rs` looks for them).

use super::cause::Cause;
use super::errors::{ImuErrors, Instrument};

/// One of them.
#[derive(Debug, Clone)]
pub(super) struct UnstatedWalk {
    pub cause: Cause,
    /// Its density, SI.
    pub density: f64,
    pub u: f64,
    /// By how much `-2 ln L` is less than without it, the densities of the others fitted anew.
    pub gain: f64,
    /// Other walks in its place, with their density and by how much `-2 ln L` is larger.
    pub others: Vec<(Cause, f64, f64)>,
}

/// The errors with those among these walks that a mission can state: white noise of the gyros or the accelerometers.
pub(super) fn stated(errors: &ImuErrors, walks: &[UnstatedWalk]) -> ImuErrors {
    walks.iter().fold(*errors, |errors, walk| match walk.cause {
        Cause::RandomWalk(instrument) => with(&errors, instrument, walk.density),
        _ => errors,
    })
}

/// The errors with a random walk of a triad.
pub(super) fn with(errors: &ImuErrors, instrument: Instrument, density: f64) -> ImuErrors {
    let mut errors = *errors;
    let triad = if instrument == Instrument::Gyro { &mut errors.gyro } else { &mut errors.accelerometer };
    triad.random_walk = triad.random_walk.hypot(density);
    errors
}
