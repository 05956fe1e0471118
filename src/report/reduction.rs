//! The report of a reduction (`tumble reduce --json`).

use super::{VERSION, finite};
use crate::record::JumpKind;
use crate::reduce::EventKind;
use crate::report::ReportKind;
use crate::wire::Reduced;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What `tumble reduce --json` writes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct ReduceReport {
    /// Version of the program that wrote it.
    pub tumble: String,
    /// Always `reduce`.
    #[schemars(extend("const" = "reduce"))]
    pub report: ReportKind,
    /// The record.
    pub record: String,
    /// Samples of each column.
    pub samples: u64,
    /// Sampling interval, s.
    pub interval_s: f64,
    /// Samples to a block; segments begin and end with blocks.
    pub block: u64,
    /// How segments were found, in words.
    pub by: String,
    /// What the static detector judged by.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub detector: Option<DetectorReport>,
    /// Segments that became readings.
    pub segments: Vec<SegmentReport>,
    /// Stretches that did not.
    pub rejected: Vec<RejectedReport>,
    /// Gaps in the times.
    pub gaps: u64,
    /// Other jumps of the clock: steps back, and steps much shorter than the sampling interval.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clock_jumps: Option<u64>,
    /// Gaps and jumps one by one, the first thousand.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub jumps: Vec<JumpReport>,
    /// Events of the whole record, by column and kind.
    pub events: BTreeMap<String, BTreeMap<EventKind, u64>>,
}

/// What the static detector judged by.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct DetectorReport {
    /// Length of a window, s.
    pub window_s: f64,
    /// Largest variance of a still window, in variances of the still sensor.
    pub threshold: f64,
    /// Standard deviation of the still sensor, by column.
    pub still_sd: BTreeMap<String, Option<f64>>,
    /// Where nothing was found: the threshold that would find the first stretch, in the same variances.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub would_find: Option<f64>,
}

/// A segment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct SegmentReport {
    /// Its label; the position of its reading.
    pub position: String,
    /// Its first sample, s since the first of the record.
    pub start_s: f64,
    /// Its end.
    pub end_s: f64,
    /// Samples.
    pub n: u64,
    /// What a reader should know.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// The mean of each column.
    pub means: Vec<SegmentMeanReport>,
}

/// A mean.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct SegmentMeanReport {
    /// The column.
    pub column: String,
    /// Its unit.
    pub unit: String,
    /// Mean of the samples, in `unit`.
    pub mean: f64,
    /// Standard uncertainty, in `unit`: 1.96 u on either side covers 95 %; what learning the noise costs is in it.
    pub u: f64,
    /// What it would be for noise without memory, `s/sqrt(n)`, in `unit`.
    pub u_white: f64,
    /// With the sum of the autocorrelations, in `unit`.
    pub u_autocorrelation: f64,
    /// The Allan deviation at the segment's length, in `unit`.
    pub u_allan_floor: f64,
    /// From the resolution of the channel, where the noise does not exceed it, in `unit`.
    pub u_resolution: f64,
    /// Degrees of freedom that the variance of the mean is known with.
    pub dof: Option<f64>,
    /// Standard deviation of the samples, in `unit`.
    pub sd: f64,
    /// Samples without memory that would have the same uncertainty, a number of samples.
    pub effective_n: f64,
    /// Correlation of neighbouring blocks of `lag_s`, -1 to 1.
    pub lag1: f64,
    /// Length of such a block, s.
    pub lag_s: f64,
    /// Slope within the segment, per second, in `unit`.
    pub slope_per_s: f64,
    /// Its standard uncertainty, in the same unit.
    pub slope_u: f64,
    /// Probability of so large a slope by chance, with the noise as found.
    pub slope_p: f64,
    /// Is that below 1 %?
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sloping: Option<bool>,
    /// How much noisier than the other segments, as a ratio of standard deviations (1: not).
    pub noisier: f64,
    /// Is its noise so different that u rests on it alone, or on segments like it? Absent where it is not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub apart: Option<bool>,
    /// Events within the segment, by kind.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub events: BTreeMap<EventKind, u64>,
}

/// A step of the times that is none from one sample to the next.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct JumpReport {
    /// What it looks like.
    pub kind: JumpKind,
    /// Rows before it.
    pub row: u64,
    /// Time of the last of them, s since the first.
    pub time_s: f64,
    /// The step, s.
    pub step_s: f64,
}

/// A stretch that did not become a reading.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct RejectedReport {
    /// Its first sample, s.
    pub start_s: f64,
    /// Its end.
    pub end_s: f64,
    /// Why.
    pub reason: String,
}

/// The report of a reduction.
pub fn reduce_report(record: &str, reduced: &Reduced) -> ReduceReport {
    let Reduced { trace, reduction, .. } = reduced;
    let named = |values: &[f64]| {
        trace.channels.iter().zip(values).map(|(c, v)| (c.name.clone(), finite(*v))).collect::<BTreeMap<_, _>>()
    };
    let segments = reduction.segments.iter().zip(&reduction.means).map(|(segment, means)| {
        let (start, end) = segment.span();
        let means = trace.channels.iter().zip(means).map(|(channel, mean)| {
            let u = &mean.uncertainty;
            SegmentMeanReport {
                column: channel.name.clone(),
                unit: channel.unit.clone(),
                mean: mean.value,
                u: u.u,
                u_white: u.white,
                u_autocorrelation: u.autocorrelation,
                u_allan_floor: u.allan_floor,
                u_resolution: u.resolution,
                dof: finite(u.dof),
                sd: mean.sd,
                effective_n: mean.effective_n,
                lag1: u.lag1,
                lag_s: u.lag_blocks * trace.block as f64 * trace.interval,
                slope_per_s: mean.slope.0,
                slope_u: mean.slope.1,
                slope_p: mean.slope.2,
                sloping: Some(mean.is_sloping()),
                noisier: u.noisier,
                apart: u.apart.then_some(true),
                events: mean.events.iter().map(|(kind, n)| (*kind, *n)).collect(),
            }
        });
        SegmentReport {
            position: segment.label.clone(),
            start_s: trace.time(start),
            end_s: trace.time(end.saturating_sub(1)) + trace.interval,
            n: means.clone().next().map_or(0, |_| segment.samples()),
            notes: segment.notes.clone(),
            means: means.collect(),
        }
    });
    let mut events: BTreeMap<String, BTreeMap<EventKind, u64>> = BTreeMap::new();
    for channel in &trace.channels {
        for event in &channel.events {
            *events.entry(channel.name.clone()).or_default().entry(event.kind).or_default() += 1;
        }
    }
    ReduceReport {
        tumble: VERSION.into(),
        report: ReportKind::Reduce,
        record: record.into(),
        samples: trace.samples,
        interval_s: trace.interval,
        block: trace.block as u64,
        by: reduced.by.clone(),
        detector: reduction.stillness.as_ref().map(|s| DetectorReport {
            window_s: s.window,
            threshold: s.threshold,
            still_sd: named(&s.still_sd),
            would_find: s.would_find,
        }),
        segments: segments.collect(),
        rejected: reduction
            .rejected
            .iter()
            .map(|r| RejectedReport {
                start_s: trace.time(r.samples.start),
                end_s: trace.time(r.samples.end.saturating_sub(1)) + trace.interval,
                reason: r.reason.clone(),
            })
            .collect(),
        gaps: reduced.gaps,
        clock_jumps: Some(reduced.clock_jumps),
        jumps: reduced
            .jumps
            .iter()
            .map(|j| JumpReport { kind: j.kind, row: j.row, time_s: j.time, step_s: j.step })
            .collect(),
        events,
    }
}
