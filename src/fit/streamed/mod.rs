//! Samples as rows: the fit of one device to a record of any length, in memory that depends on the unknowns and not on the rows.
//!
//! ```text
//! record -> blocks of columns -> a sample of the rows -> start
//! record -> blocks -> rows of the design -> made independent -> folded   (a pass for each step of Gauss-Newton and of the noise)
//! record -> residuals: order, shape, lack of fit, largest            (the last pass)
//! ```
//!
//! Where the model is linear in its unknowns and the noise is white, no step waits for another: the pass that takes the sample folds the rows, and the last
//! one is the second.
//!
//! Where means of standstills will not do (rotations with changing rate, temperature sweeps), every sample is a reading. Their noise is white, or white and
//! correlated in time (a line of scatter `over` a column of times); [`crate::estimate::Sequential`] makes the rows independent as they come, and
//! [`crate::estimate::Fold`] keeps a triangle of them. What is not stated of the noise is estimated by restricted maximum likelihood.
//!
//! | file | subject |
//! |---|---|
//! | `rows.rs` | what a record is: blocks of rows, column by column, that can be read again; the first look: how many rows, which ranges, a sample of them |
//! | `question.rs` | what can be asked of a record; one pass over it |
//! | `noise.rs` | the triangles of several sensors in one adjustment; what is free of their noise, and its search |
//! | `octaves.rs` | variances of means of 1, 2, 4, ... rows; where the search starts |
//! | `residuals.rs` | what is kept of the residuals |
//! | `bins.rs` | lack of fit over the ranges of the inputs |
//! | `conclude.rs` | the result, as that of any fit, with each source's part of the covariance and what it costs to have estimated the noise |
//!
//! Deliberately absent: what needs all readings at hand (robust weights, constraints, deviations per position, a diagnosis).

mod bins;
mod conclude;
mod noise;
mod octaves;
mod question;
mod residuals;
mod rows;

pub(crate) use residuals::{BinnedResiduals, SensorResiduals};
pub use rows::{Block, Held, Rows, sample};
pub(crate) use rows::{Observed, Sample};

use super::{Estimator, Fit, Settings};
use crate::campaign::{Campaign, Readings};
use crate::error::Result;
use crate::estimate::Group;
use octaves::Noise;
use question::{Folding, Part, Question};

/// Additional results of a streamed fit: its rows are not in memory, and the readings of the campaign are a sample of them.
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
    /// Of each row of the sample: standard uncertainty, and studentized residual of the independent row.
    pub(crate) quality: Vec<(f64, Option<f64>)>,
}

/// Rows that were folded while the sample was taken.
#[derive(Debug, Clone)]
pub(crate) struct First {
    point: Vec<f64>,
    parts: Vec<Option<Part>>,
    /// Whether each sensor's uncertainties are stated; the sample may lack a sensor.
    stated: Vec<Option<bool>>,
}

/// [`sample`], with the rows folded in the same pass where no step of the fit waits for another; `campaign` is that of some readings of the record.
///
/// Errors: those of reading the record, and of its rows.
pub(crate) fn sample_and_fold(
    rows: &mut dyn Rows,
    campaign: &dyn Fn(&Readings) -> Result<Campaign>,
    settings: &Settings,
) -> Result<Sample> {
    let columns = rows.columns().to_vec();
    // what is wrong with the question is said by the fit
    sampled(rows, &mut |first| campaign(first).ok().and_then(|own| begun(&own, settings, &columns)))
}

/// What is folded while a sample is taken: the question, its point and the rows of each sensor.
type Begun = (Question, Vec<f64>, Vec<Folding>);

/// A sample; `begin` gets the readings of the first block.
fn sampled(rows: &mut dyn Rows, begin: &mut dyn FnMut(&Readings) -> Option<Begun>) -> Result<Sample> {
    rows.rewind()?;
    let (mut found, mut block) = (Sample::new(rows.columns()), Block::default());
    let mut folding: Option<Begun> = None;
    while rows.next(&mut block)? {
        let (is_first, before) = (found.rows == 0, found.rows);
        found.take(rows, &block)?;
        if is_first {
            folding = begin(&found.readings);
        }
        if let Some((question, point, folding)) = &mut folding {
            question.chunks((&*rows, &block), point, &[], before, &mut |s, chunk| {
                folding.get_mut(s).map_or(Ok(()), |own| own.push(chunk.rows, chunk.time, chunk.relative).map(drop))
            })?;
        }
    }
    found.first = folding.map(|(question, point, folding)| {
        let stated = question.sensors.iter().map(|own| own.stated).collect();
        First { point, parts: question.parts(folding), stated }
    });
    Ok(found)
}

/// A fit that has all that it needs before its rows are read: linear, with white noise.
fn begun(campaign: &Campaign, settings: &Settings, columns: &[String]) -> Option<Begun> {
    question::check(campaign, settings).ok()?;
    let question = Question::new(campaign, settings, columns).ok()?;
    let folding = || Folding::new(question.unknowns, question.carried.len(), Noise::WHITE);
    let list = (question.is_linear && campaign.scatter.is_empty())
        .then(|| campaign.bench.sensors.iter().map(|_| folding()).collect())?;
    Some((question, campaign.reference_point(), list))
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
    let first = sample.first.clone();
    if let Some(First { point: own, stated, .. }) = &first {
        point.clone_from(own);
        question.sensors.iter_mut().zip(stated).for_each(|(sensor, stated)| sensor.stated = *stated);
    }
    let least = super::system::rounding(&campaign, &start.design, &start.system);
    for (origin, group) in start.design.rows.iter().zip(&start.system.group) {
        if let (Group::Estimated(g), Some(floor)) = (group, question.floor.get_mut(origin.sensor)) {
            // no hint, no floor
            *floor = least.get(*g).map_or(0.0, |least| least * least);
        }
    }
    let found = noise::search(&mut question, rows, &mut point, &lines, first.map(|own| own.parts))?;
    conclude::conclude(campaign, question, rows, sample, start, found, point)
}
