//! What a fit report says of a record that was streamed: how much was read, what the residuals are like, lack of fit over the inputs.

use crate::document::number::significant;
use crate::fit::Fit;
use crate::fit::streamed::{BinnedResiduals, SensorResiduals};
use crate::language::{Sentence, sentence};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A record whose rows are the readings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct RecordReport {
    /// Rows of the record.
    pub rows: u64,
    /// Values that were read.
    pub values: u64,
    /// Passes over the record.
    pub passes: usize,
    /// Rows that the list of readings and the pictures show.
    pub shown: usize,
    /// The residuals of each sensor.
    pub sensors: Vec<RecordSensorReport>,
    /// Lack of fit over the ranges of the inputs.
    pub inputs: Vec<BinsReport>,
}

/// Residuals of independent rows (the noise that is correlated in time taken out), over their standard deviations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct RecordSensorReport {
    /// The sensor.
    pub sensor: String,
    /// Values read.
    pub values: u64,
    /// Mean square, a pure number; 1 is expected.
    pub mean_square: f64,
    /// Skewness, a pure number; 0 for normal residuals.
    pub skewness: f64,
    /// Kurtosis less 3, a pure number; 0 for normal residuals.
    pub excess_kurtosis: f64,
    /// Correlation of residuals that are so many rows apart.
    pub lags: Vec<LagReport>,
    /// Probability of so large correlations of independent residuals; null for few rows.
    pub lags_p: Option<f64>,
    /// Do means of many rows scatter as those of independent ones?
    pub means: Vec<MeansReport>,
    /// The largest, first.
    pub largest: Vec<FarReport>,
}

/// Correlation of residuals.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct LagReport {
    /// Rows apart.
    pub rows: u64,
    /// Correlation, a pure number.
    pub correlation: f64,
}

/// Means of so many rows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct MeansReport {
    /// Rows in a mean.
    pub rows: u64,
    /// Pairs of neighbouring means that were compared.
    pub pairs: u64,
    /// Variance of these means over that of means of independent rows, a pure number; 1 is expected.
    pub ratio: f64,
    /// Probability of a ratio so far from 1, on either side.
    pub p: f64,
}

/// A residual that is far from zero.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct FarReport {
    /// Number of the row, from 1.
    pub row: u64,
    /// Value read, in the sensor's unit.
    pub value: f64,
    /// Value minus fitted, in the sensor's unit.
    pub residual: f64,
    /// Residual of the independent row, in its standard deviations.
    pub w: f64,
    /// Probability of so large a one among all rows if none is bad.
    pub p: f64,
}

/// Residuals over the range of an input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct BinsReport {
    /// The sensor.
    pub sensor: String,
    /// The input: a column of the record.
    pub input: String,
    /// What a step in each eighth of the input's range would explain, over the variance of the noise.
    pub chi_square: f64,
    /// Its degrees of freedom: steps that the model does not have itself.
    pub dof: usize,
    /// Probability of a larger one if the model is right.
    pub p: f64,
    /// Is the model rejected at the level, all inputs and sensors together?
    pub rejected: bool,
    /// Mean residual in each eighth of the range.
    pub bins: Vec<BinReport>,
}

/// A part of the range of an input.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct BinReport {
    /// Its lower end, in the input's unit.
    pub low: f64,
    /// Its upper end, in the input's unit.
    pub high: f64,
    /// Rows in it.
    pub rows: u64,
    /// Mean residual, in the sensor's unit; null without rows.
    pub mean: Option<f64>,
}

/// Largest residuals that a sentence names.
const NAMED: usize = 3;

fn name(fit: &Fit, sensor: usize) -> String {
    fit.campaign.sensor_id(sensor).to_string()
}

/// The record of a fit, if it was streamed.
pub(super) fn record(fit: &Fit) -> Option<RecordReport> {
    let own = fit.streamed.as_ref()?;
    let tests = own.bins.len().max(1) as f64;
    Some(RecordReport {
        rows: own.rows,
        values: own.values,
        passes: own.passes,
        shown: own.numbers.len(),
        sensors: own.sensors.iter().map(|own| sensor(fit, own)).collect(),
        inputs: own.bins.iter().map(|own| bins(fit, own, tests)).collect(),
    })
}

fn sensor(fit: &Fit, own: &SensorResiduals) -> RecordSensorReport {
    RecordSensorReport {
        sensor: name(fit, own.sensor),
        values: own.rows,
        mean_square: own.mean_square,
        skewness: own.skewness,
        excess_kurtosis: own.excess_kurtosis,
        lags: own.lags.iter().map(|(rows, correlation)| LagReport { rows: *rows, correlation: *correlation }).collect(),
        lags_p: own.lags_p,
        means: own
            .means
            .iter()
            .map(|own| MeansReport {
                rows: crate::number::count_u64(own.rows),
                pairs: own.pairs,
                ratio: own.ratio,
                p: own.p,
            })
            .collect(),
        largest: own
            .largest
            .iter()
            .map(|own| FarReport { row: own.number, value: own.value, residual: own.residual, w: own.w, p: own.p })
            .collect(),
    }
}

fn bins(fit: &Fit, own: &BinnedResiduals, tests: f64) -> BinsReport {
    BinsReport {
        sensor: name(fit, own.sensor),
        input: own.column.clone(),
        chi_square: own.chi_square,
        dof: own.dof,
        p: own.p,
        rejected: own.p * tests < 1.0 - fit.settings.level,
        bins: own
            .bins
            .iter()
            .map(|bin| BinReport {
                low: bin.low,
                high: bin.high,
                rows: bin.rows,
                mean: (bin.rows > 0).then_some(bin.mean),
            })
            .collect(),
    }
}

/// What the residuals of a record say, in sentences.
pub(super) fn verdict(fit: &Fit) -> Vec<Sentence> {
    let Some(record) = record(fit) else { return Vec::new() };
    let level = 1.0 - fit.settings.level;
    let short = |x: f64| significant(x, 3);
    let mut found = Vec::new();
    for own in &record.sensors {
        let all = own.means.len().max(1) as f64;
        let worst = own
            .means
            .iter()
            .filter(|test| test.p * all < level)
            .max_by(|a, b| a.ratio.ln().abs().total_cmp(&b.ratio.ln().abs()));
        let rejected: Vec<&BinsReport> =
            record.inputs.iter().filter(|input| input.rejected && input.sensor == own.sensor).collect();
        let is_correlated = worst.is_some_and(|test| test.ratio > 1.0);
        for input in rejected.iter().filter(|_| !is_correlated) {
            found.push(sentence!(
                "lack-of-fit-over-an-input",
                sensor = input.sensor,
                input = input.input,
                chi_square = short(input.chi_square),
                dof = input.dof,
                p = short(input.p)
            ));
        }
        match worst {
            Some(test) if test.ratio > 1.0 => found.push(sentence!(
                "means-of-rows-scatter-too-much",
                sensor = own.sensor,
                rows = test.rows.to_string(),
                ratio = short(test.ratio.sqrt()),
                p = short(test.p)
            )),
            Some(test) => found.push(sentence!(
                "means-of-rows-scatter-too-little",
                sensor = own.sensor,
                rows = test.rows.to_string(),
                ratio = short(test.ratio.sqrt()),
                p = short(test.p)
            )),
            None => {
                if let Some(p) = own.lags_p.filter(|p| *p < level) {
                    let lag = own.lags.iter().max_by(|a, b| a.correlation.abs().total_cmp(&b.correlation.abs()));
                    found.push(sentence!(
                        "residuals-are-correlated",
                        sensor = own.sensor,
                        correlation = lag.map_or(String::new(), |lag| short(lag.correlation)),
                        rows = lag.map_or(String::new(), |lag| lag.rows.to_string()),
                        p = short(p)
                    ));
                }
            }
        }
        if is_correlated && !rejected.is_empty() {
            let inputs: Vec<&str> = rejected.iter().map(|input| input.input.as_str()).collect();
            found.push(sentence!("lack-of-fit-or-correlation", sensor = own.sensor, inputs = inputs.join(", ")));
        }
        for far in own.largest.iter().filter(|far| far.p < level).take(NAMED) {
            found.push(sentence!(
                "row-is-far-from-the-model",
                sensor = own.sensor,
                row = far.row.to_string(),
                residual = short(far.residual),
                w = short(far.w),
                p = short(far.p)
            ));
        }
    }
    found
}
