//! `tumble reduce LOG`.

use super::outputs::Outputs;
use super::{Outcome, files, log, pages};
use crate::error::{Fault, Malformed, Result};
use crate::record::{self, As, Block, Record};
use crate::reduce::{self, By, Reduction, Run, Segmentation, Trace};
use crate::report::{self, html};
use crate::wire::{self, ReducedReading, Schedule};
use clap::Args;
use std::path::{Path, PathBuf};

/// What to reduce, how segments are found, and what to write.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The record: CSV in any dialect (also gzip), or Parquet.
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
    clock: log::Clock,
    /// Segments are runs of equal labels in this column (rows without a label belong to none).
    #[arg(long, value_name = "COLUMN", conflicts_with = "times")]
    by: Option<String>,
    /// Segments are listed in a table with the columns start_s, end_s and, if there is one, position.
    #[arg(long, value_name = "FILE")]
    times: Option<PathBuf>,
    /// Window of the static detector, s.
    #[arg(long, default_value_t = 0.5, value_name = "S", value_parser = positive, conflicts_with_all = ["by", "times"])]
    window: f64,
    /// Largest variance of a still window, in variances of the still sensor.
    #[arg(long, default_value_t = 4.0, value_name = "RATIO", value_parser = positive, conflicts_with_all = ["by", "times"])]
    threshold: f64,
    /// Left out at both ends of a segment, s (static segments: 0.5 s unless given).
    #[arg(long, value_name = "S")]
    guard: Option<f64>,
    /// Segments shorter than this are not used, s (static segments: 1 s unless given).
    #[arg(long, value_name = "S")]
    least: Option<f64>,
    /// Show where each uncertainty comes from.
    #[arg(long)]
    sources: bool,
    /// Write the report as JSON to a file, or to stdout with '-'.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    pages: pages::Pages,
}

fn positive(text: &str) -> std::result::Result<f64, String> {
    text.parse().ok().filter(|v: &f64| *v > 0.0 && v.is_finite()).ok_or_else(|| "expected a positive number".into())
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome> {
    let schedule = arguments.schedule.as_deref().map(schedule).transpose()?;
    let to_campaign = arguments.to.as_deref().is_some_and(|to| to.extension().is_none_or(|e| e != "csv"));
    if to_campaign && schedule.is_none() {
        return Err(Malformed::new(Fault::Missing, "a campaign needs the schedule that was run")
            .expected("--for SCHEDULE beside --to, or a name that ends in .csv for a table of readings")
            .at_path("--to"));
    }
    let mut record = log::open(&arguments.log)?;
    let (trace, gaps, notes) = read(arguments, &mut record, schedule.as_ref())?;
    let still = arguments.by.is_none() && arguments.times.is_none();
    let (by, words) = by(arguments)?;
    let guard = arguments.guard.unwrap_or(if still { 0.5 } else { 0.0 });
    let least = arguments.least.unwrap_or(if still { 1.0 } else { 0.0 });
    let mut segmentation = reduce::segment(&trace, &by, guard, least);
    notes.iter().for_each(|note| super::note(&format!("note: {note}")));
    if segmentation.segments.is_empty() {
        return Ok(nothing(&segmentation, &by, least));
    }
    let labels: Vec<String> = segmentation.segments.iter().map(|s| s.label.clone()).collect();
    let (mut places, mut turns) = (Vec::new(), vec![None; labels.len()]);
    if let Some(schedule) = &schedule {
        places = match schedule.pair(&labels) {
            Ok(places) => places,
            Err(error) => {
                segmentation.rejected.iter().for_each(|r| {
                    let (from, to) = (trace.time(r.samples.start), trace.time(r.samples.end));
                    super::note(&format!("note: not used, {from:.2} s to {to:.2} s: {}", r.reason));
                });
                return Err(error);
            }
        };
        let all: Vec<Option<f64>> = places.iter().map(|place| schedule.turn_s(*place)).collect();
        let before = segmentation.segments.len();
        turns = reduce::whole_turns(&trace, &mut segmentation, &all);
        if segmentation.segments.len() != before {
            places = schedule.pair(&segmentation.segments.iter().map(|s| s.label.clone()).collect::<Vec<_>>())?;
        }
    }
    let reduction = reduce::reduce(&trace, segmentation, &turns);
    let report = report::reduce_report(record.name(), &trace, &words, gaps, &reduction);
    let [html, md] = arguments.pages.paths();
    let mut outputs = Outputs::plan([html, md, arguments.json.as_deref(), arguments.to.as_deref()])?;
    if arguments.pages.is_asked_for() {
        let inputs = vec![files::input(&arguments.log)?];
        outputs.extend(arguments.pages.page(&html::reduce_page(&report, &trace, &reduction.segments, &inputs)?)?);
    }
    if let Some(to) = &arguments.to {
        let readings = readings(&trace, &reduction);
        let text = match schedule {
            Some(schedule) if to_campaign => files::json(&schedule.with(&readings, &places))?,
            _ => table(&readings),
        };
        outputs.add(to, text);
    }
    if let Some(path) = &arguments.json {
        outputs.add(path, files::json(&report)?);
    }
    let to_stdout = outputs.to_stdout();
    outputs.write()?;
    if !to_stdout {
        super::show(&report::reduce_table(&report, arguments.sources))?;
    }
    Ok(Outcome::Done)
}

fn schedule(path: &Path) -> Result<Schedule> {
    let source = files::read(path)?;
    let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
    wire::read_schedule(&source, &mut |name| files::read(&folder.join(name)))
}

/// The record as a trace, the number of its gaps, and what to say about its times.
fn read(arguments: &Arguments, record: &mut Record, schedule: Option<&Schedule>) -> Result<(Trace, u64, Vec<String>)> {
    let time = arguments.clock.column(record)?;
    let label = arguments.by.as_deref().map(|name| record.find(name)).transpose()?;
    let mut chosen: Vec<(String, usize)> = Vec::new();
    for name in &arguments.columns {
        let (name, title) = name.split_once('=').unwrap_or((name, name));
        chosen.push((name.trim().to_string(), record.find(title.trim())?));
    }
    if chosen.is_empty() {
        let wanted = schedule.map(Schedule::wanted);
        let all = record.columns().iter().enumerate().filter(|(k, _)| Some(*k) != time && Some(*k) != label);
        chosen = all
            .filter(|(_, column)| wanted.as_ref().is_none_or(|names| names.contains(&column.name)))
            .map(|(k, column)| (column.name.clone(), k))
            .collect();
    }
    if chosen.is_empty() {
        return Err(Malformed::new(Fault::Missing, "no column of the record is one that the bench reads")
            .expected(format!(
                "one of {}, or --columns NAME=TITLE",
                schedule.map(Schedule::wanted).unwrap_or_default().join(", ")
            ))
            .found(record::listed(record.columns()))
            .in_file(record.name()));
    }
    let unit = |k: usize| record.columns().get(k).and_then(|c| c.unit.clone()).unwrap_or_default();
    let names: Vec<String> = chosen.iter().map(|(name, _)| name.clone()).collect();
    let computed = schedule.map(|s| s.computed(&names)).unwrap_or_default();
    let read = chosen.iter().map(|(name, k)| (name.clone(), unit(*k)));
    let mut trace = Trace::new(read.chain(computed.iter().map(|c| (c.name.clone(), c.unit.clone()))).collect());
    trace.observed = chosen.len();
    let mut selected: Vec<(usize, As)> = chosen.iter().map(|(_, k)| (*k, As::Number)).collect();
    selected.extend(time.map(|k| (k, As::Number)));
    selected.extend(label.map(|k| (k, As::Label)));
    record.select(&selected);
    let mut clock = arguments.clock.ticks(record, time)?;
    let (mut block, mut runs): (Block, Vec<(f64, u64, u64)>) = Default::default();
    let mut gaps = 0;
    while record.next(&mut block)? {
        let times = time.and_then(|_| block.columns.get(chosen.len())).map(Vec::as_slice);
        for stretch in clock.stretches(times, block.rows(), None, None)? {
            trace.interval = clock.step();
            if stretch.after_gap {
                let resumed = clock.gaps().0.get(gaps).map_or(0.0, |gap| gap.time + gap.length);
                trace.resumes.push((trace.samples, resumed));
                gaps += 1;
            }
            let columns: Vec<&[f64]> = block
                .columns
                .iter()
                .take(chosen.len())
                .map(|c| c.get(stretch.rows.clone()).unwrap_or_default())
                .collect();
            if let (Some(_), Some(labels)) = (label, block.columns.last()) {
                let mut sample = trace.samples;
                for (row, label) in labels.get(stretch.rows.clone()).unwrap_or_default().iter().enumerate() {
                    if columns.iter().any(|c| c.get(row).is_none_or(|v| !v.is_finite())) {
                        continue;
                    }
                    match runs.last_mut() {
                        Some((own, _, end)) if own == label && *end == sample => *end += 1,
                        _ => runs.push((*label, sample, sample + 1)),
                    }
                    sample += 1;
                }
            }
            let more: Vec<Vec<f64>> = computed.iter().map(|c| c.values(&columns)).collect();
            let all: Vec<&[f64]> = columns.iter().copied().chain(more.iter().map(Vec::as_slice)).collect();
            trace.push(&all);
        }
    }
    trace.finish();
    trace.interval = clock.interval()?;
    let labels = record.labels();
    trace.runs = runs
        .into_iter()
        .map(|(label, start, end)| Run { label: labels.get(label as usize).cloned().unwrap_or_default(), start, end })
        .collect();
    Ok((trace, clock.gaps().1, clock.notes()))
}

/// How segments are found, and the same in words.
fn by(arguments: &Arguments) -> Result<(By, String)> {
    if let Some(column) = &arguments.by {
        return Ok((By::Labels, format!("the column '{column}'")));
    }
    let Some(path) = &arguments.times else {
        let words = format!(
            "stillness (variance in {} s below {} of the still sensor's)",
            arguments.window, arguments.threshold
        );
        return Ok((By::Still { window: arguments.window, threshold: arguments.threshold }, words));
    };
    let mut table = log::open(path)?;
    let (start, end) = (table.find("start_s")?, table.find("end_s")?);
    let position = record::find(table.columns(), "position");
    let mut selected = vec![(start, As::Number), (end, As::Number)];
    selected.extend(position.map(|k| (k, As::Label)));
    table.select(&selected);
    let (mut list, mut block) = (Vec::new(), Block::default());
    while table.next(&mut block)? {
        for k in 0..block.rows() {
            let number = |column: usize| block.columns.get(column).and_then(|c| c.get(k)).copied().unwrap_or(f64::NAN);
            if !(number(1) > number(0)) {
                return Err(Malformed::new(Fault::Value, "a segment does not end after it starts")
                    .expected("end_s above start_s")
                    .found(format!("{} and {} in row {}", number(0), number(1), list.len() + 1))
                    .in_file(table.name()));
            }
            let label = position.and_then(|_| table.labels().get(number(2) as usize)).cloned().unwrap_or_default();
            list.push((label, number(0), number(1)));
        }
    }
    Ok((By::Times(list), format!("the times in '{}'", path.display())))
}

fn nothing(segmentation: &Segmentation, by: &By, least: f64) -> Outcome {
    match (&segmentation.stillness, by) {
        (Some(judged), By::Still { threshold, .. }) => {
            let advice = match judged.would_find {
                Some(ratio) => format!(
                    "the stillest stretch of {least} s has {ratio:.3} times the variance: --threshold {:.3} would find it",
                    1.01 * ratio
                ),
                None => format!("no threshold finds a stretch of {least} s"),
            };
            super::note(&format!(
                "no static stretch of {least} s within {threshold} times the variance of the still sensor; {advice}"
            ));
        }
        _ => super::note("no segment is left"),
    }
    for rejected in segmentation.rejected.iter().take(10) {
        super::note(&format!("  not used: {}", rejected.reason));
    }
    Outcome::Rejected
}

fn readings(trace: &Trace, reduction: &Reduction) -> Vec<ReducedReading> {
    let each = reduction.segments.iter().zip(&reduction.means);
    each.map(|(segment, means)| {
        let (start, end) = segment.span();
        let values =
            trace.channels.iter().zip(means).map(|(c, m)| (c.name.clone(), m.value, m.uncertainty.u)).collect();
        let time_s = 0.5 * (trace.time(start) + trace.time(end));
        ReducedReading { position: segment.label.clone(), time_s: (time_s * 1e6).round() / 1e6, values }
    })
    .collect()
}

/// Readings as CSV.
fn table(readings: &[ReducedReading]) -> String {
    let names = readings.first().map(|r| r.values.iter().map(|(name, ..)| name.as_str()).collect::<Vec<_>>());
    let mut text = String::from("position,time_s");
    names.unwrap_or_default().iter().for_each(|name| text.push_str(&format!(",{name},{name}_u")));
    text.push('\n');
    for reading in readings {
        let quoted = reading.position.contains([',', '"', '\n']);
        let label =
            if quoted { format!("\"{}\"", reading.position.replace('"', "\"\"")) } else { reading.position.clone() };
        text.push_str(&format!("{label},{}", reading.time_s));
        reading.values.iter().for_each(|(_, mean, u)| text.push_str(&format!(",{mean},{u:.4e}")));
        text.push('\n');
    }
    text
}
