//! Samples as rows: the fit of one device to a record of any length, in memory that depends on the unknowns and not on the rows.
//!
//! ```text
//! record -> a sample of its rows -> start
//! record -> rows of the design -> made independent -> folded        (a pass for each step of Gauss-Newton and of the noise)
//! record -> residuals: order, shape, lack of fit, largest            (the last pass)
//! ```
//!
//! Where means of standstills will not do (rotations with changing rate, temperature sweeps), every sample is a reading. Their noise is white, or white and
//! correlated in time (a line of scatter `over` a column of times); [`crate::estimate::Sequential`] makes the rows independent as they come, and
//! [`crate::estimate::Fold`] keeps a triangle of them. What is not stated of the noise is estimated by restricted maximum likelihood.
//!
//! | file | subject |
//! |---|---|
//! | `rows.rs` | what a record is: rows that can be read again |
//! | `sample.rs` | the first look: how many rows, which ranges, a sample of them |
//! | `question.rs` | what can be asked of a record; one pass over it |
//! | `together.rs` | the triangles of several sensors in one adjustment |
//! | `noise.rs` | what is free of the sensors' noise, and its search |
//! | `octaves.rs` | variances of means of 1, 2, 4, ... rows; where the search starts |
//! | `residuals.rs` | what is kept of the residuals |
//! | `bins.rs` | lack of fit over the ranges of the inputs |
//! | `cost.rs` | each source's part of the covariance, and what it costs to have estimated the noise |
//! | `conclude.rs` | the result, as that of any fit |
//!
//! Deliberately absent: what needs all readings at hand (robust weights, constraints, deviations per position, a diagnosis).

mod bins;
mod conclude;
mod cost;
mod noise;
mod octaves;
mod question;
mod residuals;
mod rows;
mod sample;
mod together;

pub use residuals::{Bin, BinnedResiduals, Far, MeansTest, SensorResiduals};
pub use rows::{Held, Rows};
pub use sample::{Sample, sample};

use super::{Estimator, Fit, Settings};
use crate::campaign::Campaign;
use crate::error::Result;
use question::Question;

/// What a fit of a record has beside what every fit has: its rows are not at hand, the readings of the campaign are a sample of them.
#[derive(Debug, Clone)]
pub struct Streamed {
    /// Rows of the record.
    pub rows: u64,
    /// Values that were read.
    pub values: u64,
    /// Passes over the record.
    pub passes: usize,
    /// Number of the row (from 1) of each reading of the sample.
    pub numbers: Vec<u64>,
    /// Degrees of freedom.
    pub dof: u64,
    /// What the residuals of each sensor are like.
    pub sensors: Vec<SensorResiduals>,
    /// Lack of fit over the ranges of the inputs.
    pub bins: Vec<BinnedResiduals>,
}

/// Fit a record. `campaign` has the readings of `sample`, which is [`sample`] of the same rows.
///
/// Generalised least squares with `V = r I + q exp(-|t_i - t_j|/tau)` for each sensor, iterated on the exact model; the same numbers as [`super::fit`] of the same
/// readings. Errors: those of [`super::fit`]; what needs all readings at hand; times that do not rise where noise is correlated over them.
///
/// ```
/// use tumble::fit::streamed;
/// use tumble::{fit, Campaign};
/// let campaign = Campaign::from_json(r#"{ "bench": { "id": "line", "sensors": { "y": { "model": "a + b*x" } } },
///     "estimate": { "a": {}, "b": {} },
///     "readings": [ {"x": 0, "y": 1}, {"x": 1, "y": 3}, {"x": 2, "y": 4} ] }"#)?;
/// let mut rows = streamed::Held::new(campaign.readings.clone());
/// let sample = streamed::sample(&mut rows)?;
/// let line = streamed::fit(campaign, &mut rows, &sample, &fit::Settings::default())?;
/// assert!((line.point[1] - 1.5).abs() < 1e-14);
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
pub fn fit(campaign: Campaign, rows: &mut dyn Rows, sample: &Sample, settings: &Settings) -> Result<Fit> {
    question::check(&campaign, settings)?;
    let start = super::fit(&campaign.without_scatter(), settings)?;
    let mut question = Question::new(&campaign, settings, rows.columns())?;
    let mut point = match settings.estimator {
        Estimator::Exact => start.point.clone(),
        Estimator::Linear => campaign.reference_point(),
    };
    let lines: Vec<_> = (0..campaign.bench.sensors.len()).map(|s| question.stated(s, &campaign)).collect();
    let found = noise::search(&mut question, rows, &mut point, &lines)?;
    conclude::conclude(campaign, question, rows, sample, start, found, (point, &lines))
}
