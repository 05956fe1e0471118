//! `tumble noise LOG`.

use super::{Outcome, files, pages};
use crate::elements::Parts;
use crate::error::{Fault, Malformed, Result};
use crate::language::Language;
use crate::noise::{Ladder, analyse};
use crate::record::{As, Block, Clock as Ticks, Record};
use crate::reduce::{Event, EventKind, Odd};
use crate::report;
use crate::units::Unit;
use clap::Args;
use std::collections::BTreeMap;
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
    clock: files::Clock,
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
    /// Write kalibr's IMU file (YAML), or to stdout with '-'.
    #[arg(long, value_name = "FILE")]
    kalibr: Option<PathBuf>,
    #[command(flatten)]
    pages: pages::Pages,
}

fn level(text: &str) -> std::result::Result<f64, String> {
    text.parse().ok().filter(|p| *p > 0.0 && *p < 1.0).ok_or_else(|| "expected a probability between 0 and 1".into())
}

/// Fewest samples of a column that is reported: of 1, 2 and 4 samples, the averaging times up to a fifth of the record.
const FEWEST: u64 = 32;

/// The columns of a record from its beginning to its end, each as it is seen without its events.
fn seen(
    arguments: &Arguments,
    record: &mut Record,
    columns: &[usize],
    events: Vec<Vec<Event>>,
) -> Result<(Ticks, Vec<Seen>)> {
    let mut all: Vec<Seen> = events.into_iter().map(|events| Seen::new(arguments.per_octave, events)).collect();
    let from = arguments.clock.source();
    let time = from.column(record)?;
    let titles: Vec<String> = columns.iter().filter_map(|k| Some(record.columns().get(*k)?.title.clone())).collect();
    let mut selected: Vec<(usize, As)> = columns.iter().map(|k| (*k, As::Number)).collect();
    selected.extend(time.map(|k| (k, As::Time)));
    record.select(&selected);
    let mut clock = from.ticks(record, time)?;
    let mut block = Block::default();
    let mut last = f64::NAN;
    while record.next(&mut block)? {
        titles.iter().zip(&block.columns).try_for_each(|(title, values)| record.squarable(title, values))?;
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
        for (seen, values) in all.iter_mut().zip(&block.columns) {
            let mut joined: Vec<f64> = Vec::with_capacity(values.len());
            for (stretch, missing) in stretches.iter().zip(&missing) {
                match missing.map(|lost| (lost >= 0.0, crate::number::count_u64(lost))) {
                    None => {}
                    Some((true, lost)) if lost <= Ladder::BRIDGED => joined.extend((0..lost).map(|_| f64::NAN)),
                    Some((forward, lost)) => {
                        seen.push(&std::mem::take(&mut joined));
                        // a clock that was set back does not say how long the gap is
                        if forward { seen.ladder.missing(lost) } else { seen.ladder.interrupt() }
                    }
                }
                joined.extend_from_slice(values.part(stretch.rows.clone()));
            }
            seen.push(&joined);
        }
    }
    Ok((clock, all))
}

/// A column as it is seen: its deviations, what is odd in it, and the events whose samples are missing.
struct Seen {
    ladder: Ladder,
    odd: Odd,
    events: Vec<Event>,
    /// The first event that is not over, and samples so far.
    at: usize,
    samples: u64,
}

impl Seen {
    fn new(per_octave: u8, events: Vec<Event>) -> Self {
        Seen { ladder: Ladder::new(usize::from(per_octave)), odd: Odd::default(), events, at: 0, samples: 0 }
    }

    /// Samples; one that is not finite is missing.
    fn push(&mut self, samples: &[f64]) {
        if self.events.is_empty() {
            self.ladder.push(samples);
            self.odd.see(samples);
            return;
        }
        let mut left = samples.to_vec();
        for sample in left.iter_mut().filter(|sample| sample.is_finite()) {
            while self.events.get(self.at).is_some_and(|event| event.sample + event.length <= self.samples) {
                self.at += 1;
            }
            if self.events.get(self.at).is_some_and(|event| event.sample <= self.samples) {
                *sample = f64::NAN;
            }
            self.samples += 1;
        }
        self.ladder.push(&left);
    }
}

pub(super) fn run(arguments: &Arguments, lang: Language) -> Result<Outcome> {
    let mut record = files::open(&arguments.log)?;
    let columns = files::numeric_columns(&record, &arguments.columns, &arguments.clock.source())?;
    let titled: Vec<_> = columns.iter().filter_map(|k| record.columns().get(*k).cloned()).collect();
    let (clock, mut columns_seen) = seen(arguments, &mut record, &columns, vec![Vec::new(); titled.len()])?;
    let events: Vec<Vec<Event>> =
        columns_seen.iter_mut().map(|events| std::mem::take(&mut events.odd).events()).collect();
    let mut left_out: Vec<BTreeMap<EventKind, u64>> = vec![BTreeMap::new(); titled.len()];
    // what is odd is no noise: a file is read once more without it
    if events.iter().any(|events| !events.is_empty()) && crate::record::parted(&arguments.log).0.is_file() {
        for (counts, events) in left_out.iter_mut().zip(&events) {
            events.iter().for_each(|event| *counts.entry(event.kind).or_default() += event.length);
        }
        columns_seen = seen(arguments, &mut files::open(&arguments.log)?, &columns, events)?.1;
    }
    let interval = clock.interval()?;
    let mut reports = Vec::new();
    for ((column, Seen { ladder, .. }), left_out) in titled.iter().zip(&columns_seen).zip(left_out) {
        if ladder.samples() < FEWEST {
            let (what, found) =
                (format!("'{}' has too few samples for deviations", column.title), ladder.samples().to_string());
            // one of several that nobody asked for by name
            let others = columns_seen.iter().any(|other| other.ladder.samples() >= FEWEST);
            if others && arguments.columns.is_empty() {
                super::note(&format!("note: {what} ({found}; at least {FEWEST}), and is left out"));
                continue;
            }
            let expected = format!("at least {FEWEST} samples");
            return Err(Malformed::new(Fault::Missing, what).expected(expected).found(found).in_file(record.name()));
        }
        let wanted = arguments.unit.as_deref().and_then(|unit| Unit::parse(unit).ok());
        let unit = column.unit_for(wanted.as_ref()).or_else(|| arguments.unit.clone()).unwrap_or_else(|| "unit".into());
        let report = report::noise_column_report(&column.name, &unit, &analyse(ladder, interval, arguments.level));
        reports.push(report::NoiseColumnReport { left_out, ..report });
    }
    let report = report::noise_report(record.name(), interval, clock.source(), reports);
    let mut outputs = arguments.pages.outputs([arguments.kalibr.as_deref()])?;
    let inputs = arguments.pages.input(&arguments.log)?;
    if let Some(path) = &arguments.kalibr {
        outputs.add(path, report::kalibr(&report)?);
    }
    for note in clock.notes() {
        super::note(&format!("note: {note}"));
    }
    let document = |page: bool| match page {
        true => report::noise_document(&report, &inputs, true, lang),
        false => report::noise_document(&report, &[], arguments.deviations, lang),
    };
    arguments.pages.finish(outputs, &report, document)
}
