//! Measured navigation errors: the errors of a navigator at some times, against a reference.
//!
//! Seven channels, each measured or not at any row: `phi` about east, north and up, velocity and position east and north,
//! computed minus true, in the conventions of [`NavigationError`]. One file may hold runs of several motions of a mission.

use super::errors::NavigationError;

/// Number of channels.
pub(crate) const CHANNELS: usize = 7;

/// Names of the channels, with the unit of the numbers that files and reports give.
pub const CHANNEL_NAMES: [&str; CHANNELS] = [
    "phi_east_arcsec",
    "phi_north_arcsec",
    "phi_up_arcsec",
    "velocity_east_m_s",
    "velocity_north_m_s",
    "position_east_m",
    "position_north_m",
];

/// SI value of one of the unit in a channel's name.
pub fn si_per_unit(channel: usize) -> f64 {
    if channel < 3 { 1f64.to_radians() / 3600.0 } else { 1.0 }
}

/// One value in each channel, SI units (rad, m/s, m): `phi` east, north, up; velocity east, north; position east, north.
pub type Channels = [f64; CHANNELS];

/// A navigation error by channels.
pub fn channels(error: &NavigationError) -> Channels {
    let [e, n, u] = error.attitude;
    [e, n, u, error.velocity[0], error.velocity[1], error.position[0], error.position[1]]
}

/// What was measured at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredRow {
    /// Time since the start, s.
    pub time: f64,
    /// The error in each channel, SI; `None` where it was not measured.
    pub value: [Option<f64>; CHANNELS],
    /// Its standard uncertainty, SI; `None` where it is not stated (then nowhere in that channel).
    pub u: [Option<f64>; CHANNELS],
}

/// One run: a motion of the mission, and what was measured on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Index of the motion: 0 is that of the mission, then those to compare with it.
    pub motion: usize,
    /// Rows by time.
    pub rows: Vec<MeasuredRow>,
}

/// Measured navigation errors.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Measured {
    /// Runs, in the order of the mission's motions.
    pub runs: Vec<Run>,
    /// Rows of the file that belong to other scenarios and were left out.
    pub left_out: usize,
}

impl Measured {
    /// Add a row to the run of a motion.
    pub fn push(&mut self, motion: usize, row: MeasuredRow) {
        let place = self.runs.partition_point(|run| run.motion < motion);
        if self.runs.get(place).is_none_or(|run| run.motion != motion) {
            self.runs.insert(place, Run { motion, rows: Vec::new() });
        }
        if let Some(run) = self.runs.get_mut(place) {
            let at = run.rows.partition_point(|other| other.time <= row.time);
            run.rows.insert(at, row);
        }
    }

    /// How many values were measured.
    pub fn count(&self) -> usize {
        self.cells().count()
    }

    /// Rows of the longest run.
    pub(super) fn longest_run(&self) -> usize {
        self.runs.iter().map(|run| run.rows.len()).max().unwrap_or_default() // no run, no row
    }

    /// Time of the last row of all runs, s.
    pub(super) fn last_time(&self) -> f64 {
        self.cells().fold(0.0_f64, |last, cell| last.max(cell.time))
    }

    /// All values: run, row, channel, value and its standard uncertainty.
    pub fn cells(&self) -> impl Iterator<Item = Cell> + '_ {
        self.runs.iter().enumerate().flat_map(|(run, series)| {
            series.rows.iter().enumerate().flat_map(move |(row, measured)| {
                let pairs = measured.value.iter().zip(&measured.u).enumerate();
                pairs.filter_map(move |(channel, (value, u))| {
                    value.map(|value| Cell { run, row, channel, time: measured.time, value, u: *u })
                })
            })
        })
    }
}

/// One measured value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// Index of the run.
    pub run: usize,
    /// Index of the row in the run.
    pub row: usize,
    /// The channel.
    pub channel: usize,
    /// Time, s.
    pub time: f64,
    /// The error, SI.
    pub value: f64,
    /// Its standard uncertainty, SI.
    pub u: Option<f64>,
}
