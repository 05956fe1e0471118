//! A reduction of samples to readings: its report (`tumble reduce --json`), and its document: the record with its segments, the means, and where
//! their uncertainties come from.

use super::noise::events;
use super::provenance::begin;
use super::{Input, ReportKind, VERSION, finite};
use crate::document::chart::{Chart, RecordChart};
use crate::document::number::significant;
use crate::document::{Cell, Detail, Document, Figure, Rows, Section, Tone};
use crate::language::{Language, say};
use crate::record::Jump;
use crate::reduce::{EventKind, Segment, Trace};
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
    pub jumps: Vec<Jump>,
    /// Columns that change in no segment, and the resolution that is assumed for each: the last decimal place of the values, 0 where their digits show none.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub assumed_resolution: BTreeMap<String, f64>,
    /// Events of the whole record, by column and kind.
    pub events: BTreeMap<String, BTreeMap<EventKind, u64>>,
}

/// What the static detector judged by.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
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
pub struct SegmentMeanReport {
    /// The column.
    pub column: String,
    /// Its unit.
    pub unit: String,
    /// Mean of the samples, in `unit`.
    pub mean: f64,
    /// Standard uncertainty, in `unit`: 1.96 u on either side covers 95 %; what learning the noise costs is in it, noise slower than the segment is not.
    pub u: f64,
    /// What it would be for noise without memory, `s/sqrt(n)`, in `unit`.
    pub u_white: f64,
    /// With the sum of the autocorrelations, in `unit`.
    pub u_autocorrelation: f64,
    /// The Allan deviation at the segment's length, in `unit`.
    pub u_allan_floor: f64,
    /// What rounding to the channel's steps leaves in the mean (in `u`, in quadrature), in `unit`.
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

/// A stretch that did not become a reading.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
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
    let assumed = trace.channels.iter().zip(&reduction.assumed);
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
        jumps: reduced.jumps.clone(),
        assumed_resolution: assumed.filter_map(|(channel, step)| Some((channel.name.clone(), (*step)?))).collect(),
        events,
    }
}

/// The document of a reduction; `record` is its picture, `sources` puts before a reader of a terminal where each uncertainty comes from.
pub fn reduce_document(
    report: &ReduceReport,
    record: Option<RecordChart>,
    inputs: &[Input],
    sources: bool,
    lang: Language,
) -> Document {
    let rate = significant(1.0 / report.interval_s, 6);
    let grouped = say!(lang, "grouped-by", what = report.segments.len().to_string(), by = lang.name(&report.by));
    let caption = say!(lang, "the-whole-record-segments-are-shaded");
    let result = Section::new(say!(lang, "record"))
        .verdicts([verdict(report, lang)])
        .verdicts(notes(report, lang).into_iter().map(|text| (Tone::Caution, text)))
        .figures(record.map(|chart| Figure::new(caption, Chart::Record(chart), true)));
    let means = Section::new(say!(lang, "readings"));
    let means = if sources { means } else { means.table(overview(report, lang)).full() };
    let blocks = || say!(lang, "segments-begin-and-end-with-blocks-of", block = report.block.to_string());
    let means = means
        .table(table(report, lang))
        .brief()
        .prose(say!(lang, "u-on-either-side-of-a-mean"))
        .proses((report.block > 1).then(blocks));
    let rejected = Rows::of(&report.rejected)
        .decimal(say!(lang, "from-s"), |r| Cell::Decimals(r.start_s, 3))
        .decimal(say!(lang, "to-s"), |r| Cell::Decimals(r.end_s, 3))
        .left(say!(lang, "reason"), |r| lang.name(&r.reason));
    begin(say!(lang, "from-samples-to-readings"), inputs, lang)
        .fact(say!(lang, "record"), &report.record)
        .fact(say!(lang, "samples"), report.samples.to_string())
        .fact(say!(lang, "sampling-rate"), format!("{rate} Hz"))
        .fact(say!(lang, "segments"), grouped)
        .section(result)
        .section(means)
        .section(Section::new(say!(lang, "not-used-2")).table(rejected))
}

/// The picture of a record: for each step of it the smallest and largest value of each channel.
pub fn record_chart(trace: &Trace, segments: &[Segment]) -> RecordChart {
    const STEPS: usize = 820;
    let channels = trace.channels.iter().map(|channel| {
        let step = (channel.means.len() / STEPS).max(1);
        let course = channel.means.chunks(step).enumerate().flat_map(|(k, chunk)| {
            let at = trace.time((k * step * trace.block) as u64);
            let ends = chunk.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
            [Some((at, ends.0)), (chunk.len() > 1).then_some((at, ends.1))].into_iter().flatten()
        });
        let unit = if channel.unit.is_empty() { String::new() } else { format!(", {}", channel.unit) };
        (format!("{}{unit}", channel.name), course.collect())
    });
    let pieces = segments.iter().flat_map(|segment| &segment.pieces);
    RecordChart {
        channels: channels.collect(),
        segments: pieces.map(|piece| (trace.time(piece.start), trace.time(piece.end))).collect(),
        end: trace.time(trace.samples.saturating_sub(1)).max(trace.interval),
    }
}

fn each(report: &ReduceReport) -> impl Iterator<Item = (&str, &SegmentMeanReport)> {
    report.segments.iter().flat_map(|s| s.means.iter().map(|m| (s.position.as_str(), m)))
}

/// Segments, what was left out, slopes and odd samples, in one sentence.
fn verdict(report: &ReduceReport, lang: Language) -> (Tone, String) {
    let all = each(report).count();
    let sloping = each(report).filter(|(_, m)| m.sloping == Some(true)).count();
    // what is absent is in no mean
    let events = each(report).flat_map(|(_, m)| &m.events);
    let odd: u64 = events.filter(|(kind, _)| **kind != EventKind::Absent).map(|(_, count)| count).sum();
    let tone = match report.segments.is_empty() {
        true => Tone::Bad,
        false if odd > 0 || sloping * 20 > all => Tone::Caution,
        false => Tone::Good,
    };
    let sentence = say!(
        lang,
        "not-used-of-means-have-a-slope",
        segments = report.segments.len().to_string(),
        stretches = report.rejected.len().to_string(),
        sloping = sloping.to_string(),
        all = all.to_string(),
        odd = odd.to_string()
    );
    (tone, sentence)
}

/// What a reader should know of columns and of single segments.
fn notes(report: &ReduceReport, lang: Language) -> Vec<String> {
    let mut notes = Vec::new();
    for m in report.segments.first().into_iter().flat_map(|segment| &segment.means) {
        if let Some(step) = report.assumed_resolution.get(&m.column) {
            let (assumed, step) = (*step > 0.0, step.to_string());
            notes.push(say!(lang, "column-of-set-values", assumed, column = m.column, step));
        }
    }
    for column in report.segments.first().into_iter().flat_map(|segment| &segment.means).map(|m| &m.column) {
        let of_column = || each(report).filter(|(_, m)| m.column == *column && m.noisier > 1.0);
        let Some((segment, most)) = of_column().max_by(|(_, a), (_, b)| a.noisier.total_cmp(&b.noisier)) else {
            continue;
        };
        let (count, times) = (of_column().count(), significant(most.noisier, 2));
        notes.push(say!(lang, "noisier-segments", column, count, segment, times));
    }
    for segment in report.segments.iter().filter(|s| !s.notes.is_empty()) {
        let said: Vec<_> = segment.notes.iter().map(|note| lang.name(note)).collect();
        let notes_of = say!(lang, "reduction-segment", segment = segment.position, notes = said.join(lang.semicolon()));
        notes.push(notes_of);
    }
    notes
}

/// A row for each segment, its means beside one another.
fn overview(report: &ReduceReport, lang: Language) -> Rows<&SegmentReport> {
    let table = Rows::of(&report.segments)
        .left(say!(lang, "position"), |s| &s.position)
        .decimal(say!(lang, "from-s"), |s| Cell::Decimals(s.start_s, 2))
        .decimal(say!(lang, "to-s"), |s| Cell::Decimals(s.end_s, 2));
    let column = |table: Rows<_>, (k, mean): (usize, &SegmentMeanReport)| {
        let of_mean = |s: &SegmentReport, cell: fn(&SegmentMeanReport) -> Cell| s.means.get(k).map_or("".into(), cell);
        let table = table.decimal(&mean.column, |s| of_mean(s, |m| Cell::Value(m.mean, Some(m.u))));
        table.decimal("u", |s| of_mean(s, |m| Cell::Digits(m.u, 2)))
    };
    report.segments.first().into_iter().flat_map(|s| &s.means).enumerate().fold(table, column)
}

/// A row for each mean, with what its uncertainty would be in other ways.
fn table(report: &ReduceReport, lang: Language) -> Rows<(bool, &SegmentReport, &SegmentMeanReport)> {
    let rows = report.segments.iter().flat_map(|s| s.means.iter().enumerate().map(move |(k, m)| (k == 0, s, m)));
    Rows::of(rows)
        .left(say!(lang, "position"), |(first, s, _)| if first { &s.position } else { "" })
        .name(say!(lang, "column"), |(.., m)| &m.column)
        .right("n", |(first, s, _)| if first { s.n.to_string() } else { String::new() })
        .decimal(say!(lang, "mean"), |(.., m)| Cell::Value(m.mean, Some(m.u)))
        .decimal("u", |(.., m)| Cell::Digits(m.u, 2))
        .decimal(say!(lang, "white"), |(.., m)| Cell::Digits(m.u_white, 2))
        .decimal(say!(lang, "autocorr"), |(.., m)| Cell::Digits(m.u_autocorrelation, 2))
        .decimal(say!(lang, "allan"), |(.., m)| Cell::Digits(m.u_allan_floor, 2))
        .decimal(say!(lang, "n-eff"), |(.., m)| Cell::Digits(m.effective_n, 2))
        .decimal(say!(lang, "lag"), |(.., m)| Cell::Decimals(m.lag1, 2))
        .decimal(say!(lang, "slope-p"), |(.., m)| Cell::Probability(m.slope_p))
        .left(say!(lang, "odd"), |(.., m)| events(&m.events, lang))
        .at(Detail::Full)
        .rule(|(first, ..)| first)
        .small()
}
