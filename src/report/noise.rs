//! The noise of a record: its report (`tumble noise --json`), its document, and the file of kalibr.

use super::provenance::begin;
use super::{Input, ReportKind, VERSION, finite};
use crate::document::chart::{Chart, DeviationPoint};
use crate::document::number::{level, percent, rounded, significant};
use crate::document::{Cell, Document, Figure, Rows, Section, Tone};
use crate::error::{Fault, Malformed, Result};
use crate::language::{Language, say};
use crate::noise::{Agreement, Analysis, Change, Point, Term, Without, field_unit, si_factor};
use crate::reduce::EventKind;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What `tumble noise --json` writes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct NoiseAnalysisReport {
    /// Version of the program that wrote it.
    pub tumble: String,
    /// Always `noise`.
    #[schemars(extend("const" = "noise"))]
    pub report: ReportKind,
    /// The record.
    pub record: String,
    /// Sampling interval, s.
    pub interval_s: f64,
    /// Where the sampling interval comes from: a column, or the rate as stated.
    pub interval_from: String,
    /// One entry for each column.
    pub columns: Vec<NoiseColumnReport>,
}

/// The noise of one column.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NoiseColumnReport {
    /// The column's name.
    pub column: String,
    /// Its unit.
    pub unit: String,
    /// Samples.
    pub samples: u64,
    /// Samples that were left out as if they were missing, by what is odd in them.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub left_out: BTreeMap<EventKind, u64>,
    /// Stretches between gaps.
    pub stretches: u64,
    /// Mean of all samples, in `unit`.
    pub mean: Option<f64>,
    /// Probability of the intervals.
    pub level: f64,
    /// Deviations.
    pub points: Vec<Point>,
    /// Coefficients of IEEE Std 952.
    pub coefficients: Vec<CoefficientReport>,
    /// Why there are none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub without: Option<Without>,
    /// How well the coefficients describe the Allan variances.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub agreement: Option<Agreement>,
    /// What a campaign may state about this sensor (its `scatter`).
    pub scatter: Vec<NoiseScatterReport>,
}

/// A coefficient of IEEE Std 952.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CoefficientReport {
    /// Its letter.
    pub id: Term,
    /// Its name.
    pub name: String,
    /// Value in `unit`; null where the record does not show it.
    pub value: Option<f64>,
    /// Standard uncertainty, in `unit`.
    pub u: Option<f64>,
    /// The field's unit.
    pub unit: String,
    /// Value in the column's unit and seconds.
    pub si_seconds: Option<f64>,
    /// Probability of as much if it were zero.
    pub p: Option<f64>,
    /// Where it is not found: what it is below (95 %), in `unit`.
    pub below: Option<f64>,
}

/// A line for a campaign's `scatter`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NoiseScatterReport {
    /// The sensor.
    pub of: String,
    /// `reading` for noise without memory.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub per: Option<String>,
    /// `time_s` for noise with memory.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub over: Option<String>,
    /// Its correlation time, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tau: Option<f64>,
    /// Standard deviation of one sample, in `unit`.
    pub u: f64,
    /// Unit.
    pub unit: String,
}

/// The name of a coefficient, of a gyro (`true`), an accelerometer (`false`) or another sensor.
fn name(term: Term, unit: &str) -> &'static str {
    let gyro = field_unit(Term::RandomWalk, unit).symbol == "deg/sqrt(h)";
    let accelerometer = field_unit(Term::RandomWalk, unit).symbol == "ug/sqrt(Hz)";
    match term {
        Term::Quantization => "quantization",
        Term::RandomWalk if gyro => "angle random walk",
        Term::RandomWalk if accelerometer => "velocity random walk",
        Term::RandomWalk => "white noise",
        Term::BiasInstability => "bias instability",
        Term::RateRandomWalk if gyro => "rate random walk",
        Term::RateRandomWalk if accelerometer => "acceleration random walk",
        Term::RateRandomWalk => "random walk",
        Term::Ramp if gyro => "rate ramp",
        Term::Ramp => "ramp",
    }
}

/// The report of one column.
pub fn noise_column_report(column: &str, unit: &str, noise: &Analysis) -> NoiseColumnReport {
    let coefficients = noise.coefficients.iter().flat_map(|c| &c.terms).map(|c| {
        let field = field_unit(c.term, unit);
        CoefficientReport {
            id: c.term,
            name: name(c.term, unit).into(),
            value: c.value.map(|v| v * field.factor),
            u: c.u.map(|u| u * field.factor),
            unit: field.symbol,
            si_seconds: c.value,
            p: finite(c.p),
            below: c.below.map(|b| b * field.factor),
        }
    });
    NoiseColumnReport {
        column: column.into(),
        unit: unit.into(),
        samples: noise.samples,
        left_out: BTreeMap::new(),
        stretches: noise.stretches,
        mean: finite(noise.mean),
        level: noise.level,
        points: noise.points.clone(),
        coefficients: coefficients.collect(),
        without: noise.without,
        agreement: noise.coefficients.as_ref().map(|c| c.agreement.clone()),
        scatter: scatter(column, unit, noise),
    }
}

/// White noise as it is; flicker by the first-order Markov process whose Allan deviation has its summit, 0.619 sd at 1.89 correlation times, at the
/// flicker floor in the middle of the averaging times.
fn scatter(column: &str, unit: &str, noise: &Analysis) -> Vec<NoiseScatterReport> {
    let value = |term: Term| noise.coefficients.as_ref()?.get(term)?.value;
    let line = NoiseScatterReport { of: column.into(), per: None, over: None, tau: None, u: 0.0, unit: unit.into() };
    let mut lines = Vec::new();
    if let Some(n) = value(Term::RandomWalk) {
        lines.push(NoiseScatterReport { per: Some("reading".into()), u: n / noise.interval.sqrt(), ..line.clone() });
    }
    if let (Some(b), Some(last)) = (value(Term::BiasInstability), noise.points.last()) {
        let (floor, summit) = (b * Term::BiasInstability.variance(1.0).sqrt(), 1.89);
        let from = value(Term::RandomWalk).map_or(noise.interval, |n| (n / floor).powi(2));
        let to = value(Term::RateRandomWalk).map_or(last.tau, |k| 3.0 * (floor / k).powi(2));
        let tau = (from.max(noise.interval) * to.max(noise.interval)).sqrt() / summit;
        lines.push(NoiseScatterReport { over: Some("time_s".into()), tau: Some(tau), u: floor / 0.619, ..line });
    }
    lines
}

/// The report of a record.
pub fn noise_report(
    record: &str,
    interval_s: f64,
    interval_from: String,
    columns: Vec<NoiseColumnReport>,
) -> NoiseAnalysisReport {
    NoiseAnalysisReport {
        tumble: VERSION.into(),
        report: ReportKind::Noise,
        record: record.into(),
        interval_s,
        interval_from,
        columns,
    }
}

/// The document of a record's noise; `deviations` puts their numbers before a reader of a terminal too.
pub fn noise_document(report: &NoiseAnalysisReport, inputs: &[Input], deviations: bool, lang: Language) -> Document {
    let rate = significant(1.0 / report.interval_s, 6);
    let from = lang.in_parentheses(&lang.name(&report.interval_from));
    let document = begin(say!(lang, "noise-of-a-record"), inputs, lang)
        .fact(say!(lang, "record"), &report.record)
        .fact(say!(lang, "sampling-rate"), format!("{rate} Hz {from}"));
    report.columns.iter().fold(document, |document, column| document.section(section(column, deviations, lang)))
}

/// Does the sum of the coefficients describe the deviations?
fn described(a: &Agreement, lang: Language) -> (Tone, String) {
    let [chi, p] = [significant(a.chi_square, 3), significant(a.p, 2)];
    let test = say!(lang, "chi-square-with-degrees-of-freedom", statistic = chi, dof = a.dof.to_string());
    let test = lang.in_parentheses(&format!("{test}{}p = {p}", lang.clause()));
    let well = a.is_good();
    let tone = if well { Tone::Good } else { Tone::Caution };
    (tone, lang.sentence(&format!("{} {test}", say!(lang, "their-sum-describes", well))))
}

/// The record moves: its coefficients are not those of noise.
fn moves(change: &Change, unit: &str, lang: Language) -> (Tone, String) {
    let [by, at, tau, in_sd] = [change.by, change.time_s, change.tau_s, change.in_sd].map(|x| significant(x, 3));
    (Tone::Caution, lang.sentence(&say!(lang, "record-changes", by, unit, at, tau, in_sd)))
}

/// Odd samples by kind.
pub(super) fn events(events: &BTreeMap<EventKind, u64>, lang: Language) -> String {
    let event = |(kind, n): (&EventKind, &u64)| format!("{} {n}", lang.term(&kind.to_string()));
    events.iter().map(event).collect::<Vec<_>>().join(", ")
}

fn section(column: &NoiseColumnReport, deviations: bool, lang: Language) -> Section {
    let agreement = column.agreement.as_ref();
    let without = |why: Without| (Tone::Caution, lang.sentence(&say!(lang, "no-coefficients", why = why.name())));
    let mean = column.mean.map_or("-".into(), |mean| significant(mean, 6));
    let (samples, stretches, unit) = (column.samples, crate::number::index(column.stretches.max(1)), &column.unit);
    let coefficients = Rows::of(&column.coefficients)
        .left(say!(lang, "coefficient"), |c| c.id.to_string())
        .left("", |c| lang.name(&c.name))
        .decimal(say!(lang, "value"), |c| Cell::value(c.value, c.u))
        .decimal("u", |c| Cell::digits(c.u, 2))
        .left(say!(lang, "unit"), |c| &c.unit)
        .decimal("p", |c| Cell::p(c.p))
        .decimal(format!("{} (95 %)", say!(lang, "upper-limit")), |c| Cell::digits(c.below, 2));
    let from = agreement.and_then(|a| a.from_tau_s);
    let sampled = agreement.and_then(|a| a.walk_sampled_s);
    let remarks = [
        from.map(|from| say!(lang, "described-from", from = significant(from, 3))),
        (!column.left_out.is_empty()).then(|| say!(lang, "samples-left-out", events = events(&column.left_out, lang))),
        sampled.map(|interval| say!(lang, "random-walk-sampled", interval = significant(interval, 3))),
    ];
    let numbers = Rows::of(&column.points)
        .decimal(say!(lang, "averaging-time-s"), |p| Cell::Digits(p.tau, 4))
        .decimal(say!(lang, "allan"), |p| Cell::Digits(p.allan.value, 5))
        .right(level(column.level), |p| {
            let ends = p.allan.low.zip(p.allan.high);
            ends.map(|(a, b)| format!("{} .. {}", significant(a, 4), significant(b, 4)))
        })
        .decimal(say!(lang, "edf"), |p| Cell::Digits(p.allan.edf, 3))
        .decimal(say!(lang, "hadamard"), |p| Cell::digits(p.hadamard.as_ref().map(|d| d.value), 5))
        .decimal(say!(lang, "modified"), |p| Cell::digits(p.modified.as_ref().map(|d| d.value), 5))
        .decimal(say!(lang, "fitted"), |p| Cell::digits(p.fitted, 4))
        .small();
    Section::new(&column.column)
        .verdicts(agreement.map(|a| described(a, lang)))
        .verdicts(agreement.and_then(|a| a.change).map(|change| moves(&change, unit, lang)))
        .verdicts(column.without.map(without))
        .prose(say!(lang, "samples-mean", samples, stretches, mean, unit))
        .table(coefficients)
        .proses(remarks.into_iter().flatten().map(|remark| lang.sentence(&remark)))
        .figures([figure(column, lang)])
        .full_unless(deviations)
        .table(numbers)
}

fn figure(column: &NoiseColumnReport, lang: Language) -> Figure {
    let points = column.points.iter().map(|p| DeviationPoint {
        tau: p.tau,
        value: p.allan.value,
        interval: p.allan.low.zip(p.allan.high),
        fitted: p.fitted,
    });
    let found = column
        .coefficients
        .iter()
        .filter_map(|c| Some(format!("{} {} {}", lang.name(&c.name), rounded(c.value?, c.u), c.unit)));
    let found = lang.sentence(&found.collect::<Vec<_>>().join(lang.semicolon()));
    let (samples, level) = (column.samples.to_string(), percent(column.level));
    let caption = say!(lang, "overlapping-allan-deviation-of-samples-with-its", samples, level);
    Figure {
        description: format!("{caption}{}{found}", lang.space()),
        caption,
        chart: Chart::Deviations(points.collect(), say!(lang, "allan-deviation", unit = column.unit)),
        wide: true,
    }
}

/// The IMU file of kalibr: densities in rad/s/sqrt(Hz), m/s^2/sqrt(Hz), random walks in rad/s^2/sqrt(Hz), m/s^3/sqrt(Hz); the largest of each kind of sensor.
///
/// Errors: no column in a unit of rate or specific force; a kind without white noise.
pub fn kalibr(report: &NoiseAnalysisReport) -> Result<String> {
    let largest = |gyro: bool, id: Term, bound: bool| {
        let value = |column: &NoiseColumnReport| {
            let (_, factor) = si_factor(&column.unit).filter(|(is_gyro, _)| *is_gyro == gyro)?;
            let c = column.coefficients.iter().find(|c| c.id == id)?;
            let in_unit = field_unit(id, &column.unit).factor;
            let value = if bound { c.below.map(|b| b / in_unit) } else { c.si_seconds };
            Some((value? * factor, column.column.clone()))
        };
        report.columns.iter().filter_map(value).max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let mut text = format!("# Written by tumble {VERSION}\n#Accelerometers\n");
    let mut kinds = 0;
    for (gyro, title, words) in [
        (false, "accelerometer", ("m/s^2/sqrt(Hz)", "m/s^3/sqrt(Hz)")),
        (true, "gyroscope", ("rad/s/sqrt(Hz)", "rad/s^2/sqrt(Hz)")),
    ] {
        if gyro {
            text.push_str("\n#Gyroscopes\n");
        }
        let Some((density, from)) = largest(gyro, Term::RandomWalk, false) else { continue };
        kinds += 1;
        text.push_str(&format!("{title}_noise_density: {density:.6e}   # {}, N of {from}\n", words.0));
        match (largest(gyro, Term::RateRandomWalk, false), largest(gyro, Term::RateRandomWalk, true)) {
            (Some((walk, from)), _) => {
                text.push_str(&format!("{title}_random_walk: {walk:.6e}   # {}, K of {from}\n", words.1));
            }
            (None, Some((walk, from))) => text.push_str(&format!(
                "{title}_random_walk: {walk:.6e}   # {}, not found in this record: what K of {from} is below (95 %)\n",
                words.1
            )),
            (None, None) => {}
        }
    }
    if kinds == 0 {
        return Err(Malformed::new(Fault::Value, "kalibr's file holds gyros and accelerometers, and no column is one")
            .expected("columns in a unit of rate (deg/s, rad/s, deg/h) or of specific force (g, mg, m/s^2)")
            .found(
                report.columns.iter().map(|c| format!("{} in {}", c.column, c.unit)).collect::<Vec<_>>().join(", "),
            ));
    }
    text.push_str(&format!("\nrostopic: /imu0\nupdate_rate: {}\n", significant(1.0 / report.interval_s, 6)));
    Ok(text)
}
