//! `tumble reduce LOG`.

use super::{Outcome, files, pages};
use crate::error::{Fault, Malformed, Result};
use crate::language::Language;
use crate::reduce::Channel;
use crate::report;
use crate::wire::{self, Encoder, Folder, Recipe, ReducedReading, Schedule, SegmentsBy};
use clap::Args;
use std::path::{Path, PathBuf};

/// What to reduce, how segments are found, and what to write.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The record: CSV in any dialect (also gzip), Parquet, a workbook, MATLAB, HDF5, or MCAP; FILE#NAME is one of its tables (a sheet, a variable, a group, a topic).
    log: PathBuf,
    /// The schedule that was run: a campaign file without sensor values; its readings are filled in.
    #[arg(long = "for", value_name = "SCHEDULE")]
    schedule: Option<PathBuf>,
    /// Where the readings go: a campaign (with --for), or a table if the name ends in .csv; '-' for stdout.
    #[arg(long, value_name = "FILE")]
    to: Option<PathBuf>,
    /// Columns to reduce, NAME or NAME=TITLE, comma-separated; by default those that the schedule's bench reads, or all numeric ones.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    columns: Vec<String>,
    #[command(flatten)]
    clock: files::Clock,
    /// Segments are runs of equal labels in this column (rows without a label belong to none).
    #[arg(long, value_name = "COLUMN", conflicts_with = "times")]
    by: Option<String>,
    /// Segments are listed in a table with the columns start_s, end_s (seconds since the first sample) and, if there is one, position.
    #[arg(long, value_name = "FILE")]
    times: Option<PathBuf>,
    /// Window of the static detector, s.
    #[arg(long, default_value_t = 0.5, value_name = "S", value_parser = positive, conflicts_with_all = ["by", "times"])]
    window: f64,
    /// Largest variance of a static window, as a multiple of the variance of the sensor at rest.
    #[arg(long, default_value_t = 4.0, value_name = "RATIO", value_parser = positive, conflicts_with_all = ["by", "times"])]
    threshold: f64,
    /// Guard time omitted at both ends of a segment, s (static segments: 0.5 s by default).
    #[arg(long, value_name = "S")]
    guard: Option<f64>,
    /// Segments shorter than this are not used, s (static segments: 1 s unless given).
    #[arg(long, value_name = "S")]
    least: Option<f64>,
    /// Turning segments are cut to whole turns by the angle in this column (an encoder's), instead of by the schedule's rates.
    #[arg(long, value_name = "COLUMN")]
    encoder: Option<String>,
    /// Encoder counts per turn; by default a turn in the unit of the title, or 360.
    #[arg(long, value_name = "N", value_parser = positive, requires = "encoder")]
    counts_per_turn: Option<f64>,
    /// Show the sources of each uncertainty.
    #[arg(long)]
    sources: bool,
    #[command(flatten)]
    pages: pages::Pages,
}

pub(super) fn positive(text: &str) -> std::result::Result<f64, String> {
    text.parse().ok().filter(|v: &f64| *v > 0.0 && v.is_finite()).ok_or_else(|| "expected a positive number".into())
}

pub(super) fn run(arguments: &Arguments, lang: Language) -> Result<Outcome> {
    let mut schedule = arguments.schedule.as_deref().map(schedule).transpose()?;
    let to_campaign = arguments.to.as_deref().is_some_and(|to| to.extension().is_none_or(|e| e != "csv"));
    if to_campaign && schedule.is_none() {
        return Err(Malformed::new(Fault::Missing, "a campaign needs the schedule that was run")
            .expected("--for SCHEDULE with --to, or a name that ends in .csv for a table of readings")
            .at_path("--to"));
    }
    let (record, reduced) = recipe(arguments)?.reduce_for(&mut || files::open(&arguments.log), schedule.as_mut())?;
    reduced.notes.iter().for_each(|note| super::note(&format!("note: {note}")));
    if let Some(why) = &reduced.nothing {
        why.iter().enumerate().for_each(|(k, line)| super::note(&format!("{}{line}", if k > 0 { "  " } else { "" })));
        return Ok(Outcome::Rejected);
    }
    let report = report::reduce_report(record.name(), &reduced);
    let mut outputs = arguments.pages.outputs([arguments.to.as_deref()])?;
    let inputs = arguments.pages.input(&arguments.log)?;
    if let Some(to) = &arguments.to {
        let readings = reduced.readings();
        let text = match schedule {
            Some(schedule) if to_campaign => files::marked(&schedule.with(&readings, &reduced.places))?.into_bytes(),
            _ => table(&readings, &reduced.trace.channels)?,
        };
        outputs.add(to, text);
    }
    let document = |page: bool| match page {
        true => {
            let picture = report::record_chart(&reduced.trace, &reduced.reduction.segments);
            report::reduce_document(&report, Some(picture), &inputs, false, lang)
        }
        false => report::reduce_document(&report, None, &[], arguments.sources, lang),
    };
    arguments.pages.finish(outputs, &report, document)
}

fn schedule(path: &Path) -> Result<Schedule> {
    let mut folder = files::Beside::new(path);
    wire::read_schedule(&files::read(path)?, &mut |name| folder.text(name))
}

fn recipe(arguments: &Arguments) -> Result<Recipe> {
    let segments = match (&arguments.by, &arguments.times) {
        (Some(column), _) => SegmentsBy::Column(column.clone()),
        (None, Some(path)) => SegmentsBy::Times {
            list: wire::times(&mut files::open(path)?)?,
            from: format!("the times in '{}'", path.display()),
        },
        (None, None) => SegmentsBy::Still { window: arguments.window, threshold: arguments.threshold },
    };
    let columns = arguments.columns.iter().map(|name| {
        let (name, title) = name.split_once('=').unwrap_or((name, name));
        (name.trim().to_string(), title.trim().to_string())
    });
    let turn = arguments.counts_per_turn;
    Ok(Recipe {
        segments,
        guard: arguments.guard,
        least: arguments.least,
        columns: columns.collect(),
        clock: arguments.clock.source(),
        encoder: arguments.encoder.clone().map(|column| Encoder { column, turn }),
    })
}

/// Readings as CSV; a column's title has its unit, where the record says one.
fn table(readings: &[ReducedReading], channels: &[Channel]) -> Result<Vec<u8>> {
    let unit = |name: &str| {
        let channel = channels.iter().find(|channel| channel.name == name).map(|channel| channel.unit.as_str());
        channel.filter(|unit| !unit.is_empty()).map_or(String::new(), |unit| format!(" ({unit})"))
    };
    let mut titles = vec!["position".to_string(), "time_s".into()];
    for (name, ..) in readings.first().iter().flat_map(|reading| &reading.values) {
        titles.extend(["", "_u"].map(|end| format!("{name}{end}{}", unit(name))));
    }
    let mut text = csv::Writer::from_writer(Vec::new());
    let rows = readings.iter().map(|reading| {
        let values = reading.values.iter().flat_map(|(_, mean, u)| [mean.to_string(), format!("{u:.4e}")]);
        [reading.position.clone(), reading.time_s.to_string()].into_iter().chain(values).collect()
    });
    let written = [titles].into_iter().chain(rows).try_for_each(|row| text.write_record(row));
    let text =
        written.map_err(std::io::Error::from).and_then(|()| text.into_inner().map_err(|error| error.into_error()));
    text.map_err(|error| Malformed::new(Fault::File, format!("the readings cannot be written: {error}")))
}
