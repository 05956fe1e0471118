//! `tumble noise LOG`.

use super::{Outcome, files, log, pages};
use crate::elements::Parts;
use crate::error::{Fault, Malformed, Result};
use crate::language::Language;
use crate::noise::{Ladder, analyse};
use crate::record::{As, Block};
use crate::report;
use clap::Args;
use std::path::PathBuf;

/// What to analyse and what to write.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The record: CSV in any dialect (also gzip), Parquet, a workbook, MATLAB, HDF5, or MCAP; FILE#NAME is one of its tables (a sheet, a variable, a group, a topic).
    log: PathBuf,
    /// Columns to analyse, by name, comma-separated; all numeric ones but the time unless given.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    columns: Vec<String>,
    /// Unit of the columns, where their titles have none (deg/s, rad/s, g, m/s^2, ...).
    #[arg(long, value_name = "UNIT")]
    unit: Option<String>,
    #[command(flatten)]
    clock: log::Clock,
    /// Analyse from this time on, s.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    from: Option<f64>,
    /// Analyse up to this time, s.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    to: Option<f64>,
    /// Averaging times in each octave.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=32))]
    per_octave: u8,
    /// Coverage probability of the intervals.
    #[arg(long, default_value_t = 0.95, value_name = "P", value_parser = level)]
    level: f64,
    /// Also list the deviations at every averaging time.
    #[arg(long)]
    deviations: bool,
    /// Write the report as JSON to a file, or to stdout with '-'.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write kalibr's IMU file (YAML), or to stdout with '-'.
    #[arg(long, value_name = "FILE")]
    kalibr: Option<PathBuf>,
    #[command(flatten)]
    pages: pages::Pages,
}

fn level(text: &str) -> std::result::Result<f64, String> {
    text.parse().ok().filter(|p| *p > 0.0 && *p < 1.0).ok_or_else(|| "expected a probability between 0 and 1".into())
}

pub(super) fn run(arguments: &Arguments, lang: Language) -> Result<Outcome> {
    let mut record = log::open(&arguments.log)?;
    let columns = log::numeric_columns(&record, &arguments.columns, &arguments.clock)?;
    let time = arguments.clock.column(&record)?;
    let titled: Vec<_> = columns.iter().filter_map(|k| record.columns().get(*k).cloned()).collect();
    let mut selected: Vec<(usize, As)> = columns.iter().map(|k| (*k, As::Number)).collect();
    selected.extend(time.map(|k| (k, As::Time)));
    record.select(&selected);
    let mut ladders: Vec<Ladder> = titled.iter().map(|_| Ladder::new(usize::from(arguments.per_octave))).collect();
    let mut clock = arguments.clock.ticks(&record, time)?;
    let mut block = Block::default();
    let mut last = f64::NAN;
    while record.next(&mut block)? {
        titled.iter().zip(&block.columns).try_for_each(|(own, values)| record.squarable(&own.title, values))?;
        let times = time.and_then(|_| block.columns.last());
        let stretches = clock.stretches(times.map(Vec::as_slice), block.rows(), arguments.from, arguments.to)?;
        // samples that a gap before a stretch left out
        let steps = clock.seconds_per_unit() / clock.step();
        let time = |row: usize| times.and_then(|times| times.get(row)).copied();
        let missing: Vec<Option<f64>> = stretches
            .iter()
            .map(|stretch| {
                let before = stretch.rows.start.checked_sub(1).and_then(time).unwrap_or(last);
                let lost = time(stretch.rows.start).map(|now| ((now - before) * steps).round() - 1.0);
                lost.filter(|_| stretch.after_gap)
            })
            .collect();
        last = times.and_then(|times| times.last()).copied().unwrap_or(last);
        for (ladder, values) in ladders.iter_mut().zip(&block.columns) {
            let mut joined: Vec<f64> = Vec::with_capacity(values.len());
            for (stretch, missing) in stretches.iter().zip(&missing) {
                match missing.map(|lost| (lost >= 0.0, crate::number::count_u64(lost))) {
                    None => {}
                    Some((true, lost)) if lost <= Ladder::BRIDGED => joined.extend((0..lost).map(|_| f64::NAN)),
                    Some((forward, lost)) => {
                        ladder.push(&std::mem::take(&mut joined));
                        // a clock that was set back does not say how long the gap is
                        if forward { ladder.missing(lost) } else { ladder.interrupt() }
                    }
                }
                joined.extend_from_slice(values.part(stretch.rows.clone()));
            }
            ladder.push(&joined);
        }
    }
    let interval = clock.interval()?;
    let mut reports = Vec::new();
    for (column, ladder) in titled.iter().zip(&ladders) {
        if ladder.samples() < 32 {
            return Err(Malformed::new(
                Fault::Missing,
                format!("'{}' has too few samples for deviations", column.title),
            )
            .expected("at least 32 samples")
            .found(format!("{}", ladder.samples()))
            .in_file(record.name()));
        }
        let unit = column.unit.clone().or_else(|| arguments.unit.clone()).unwrap_or_else(|| "unit".into());
        reports.push(report::noise_column_report(&column.name, &unit, &analyse(ladder, interval, arguments.level)));
    }
    let report = report::noise_report(record.name(), interval, clock.source(), reports);
    let mut outputs = arguments.pages.outputs([arguments.json.as_deref(), arguments.kalibr.as_deref()])?;
    if arguments.pages.is_asked_for() {
        let inputs = vec![files::input(&crate::record::parted(&arguments.log).0)?];
        outputs.extend(arguments.pages.page(&report::noise_document(&report, &inputs, true, lang))?);
    }
    if let Some(path) = &arguments.kalibr {
        outputs.add(path, report::kalibr(&report)?);
    }
    if let Some(path) = &arguments.json {
        outputs.add(path, files::json(&report)?);
    }
    let to_stdout = outputs.to_stdout();
    outputs.write()?;
    for note in clock.notes() {
        super::note(&format!("note: {note}"));
    }
    if !to_stdout {
        arguments.pages.print(&report::noise_document(&report, &[], arguments.deviations, lang))?;
    }
    Ok(Outcome::Done)
}
