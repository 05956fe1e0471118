//! Measured navigation errors from a CSV file, with the columns that `tumble navigate --csv` writes, and back.

use super::Source;
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use crate::navigate::measured::{CHANNEL_NAMES, CHANNELS, Measured, MeasuredRow, si_per_unit};
use crate::navigate::mission::Mission;
use crate::navigate::study;
use crate::record::{self, As, Block, Record, Said};
use std::collections::HashMap;

/// What a column of the file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Column {
    Motion,
    Scenario,
    Time,
    Value(usize),
    Uncertainty(usize),
}

/// Read measured navigation errors of a mission.
///
/// Columns: `time_s`, at least one of `navigate::measured::CHANNEL_NAMES`, each with its `_u` or without; `motion` where the file holds runs of
/// several motions of the mission (else all rows are of its own motion); `scenario` where several flew (then those of `all` count).
/// Empty cells are values that were not measured.
///
/// Errors: an unknown or repeated column, no `time_s`, nothing measured, cells that are no finite number, a `u` that is not positive or
/// missing in some rows, a value measured twice at one time, a time outside the mission, an unknown motion, several scenarios without `all`; with line and column.
pub fn read_measured(source: &Source, mission: &Mission) -> Result<Measured> {
    let mut table = Record::of_text(&source.name, source.text.as_str())?;
    let columns = columns(table.columns(), &source.name, table.title_line())?;
    let headers: Vec<String> = table.columns().iter().map(|column| column.title.clone()).collect();
    let kind =
        |column: &Column| if matches!(column, Column::Motion | Column::Scenario) { As::Label } else { As::Mixed };
    table.select(&columns.iter().enumerate().map(|(k, column)| (k, kind(column))).collect::<Vec<_>>());
    let (mut records, mut block): (Vec<Row>, Block) = Default::default();
    while table.next(&mut block)? {
        for (k, line) in (0..block.rows()).zip(&block.lines) {
            let label = |label: usize| table.labels().get(label).cloned().unwrap_or_default();
            let cell = |(of, column): (&Column, &Vec<f64>)| match record::said(column.at(k)) {
                Said::Number(number) if kind(of) == As::Label => label(crate::number::count(number)),
                Said::Number(number) => number.to_string(),
                Said::Nothing => String::new(),
                Said::Text(text) => label(text),
            };
            records.push((*line, columns.iter().zip(&block.columns).map(cell).collect()));
        }
    }
    let motions: Vec<String> = study::motions(mission).into_iter().map(|(name, _)| name).collect();
    let scenario = scenario(&columns, &records, source)?;
    let mut measured = Measured::default();
    let mut lines: HashMap<(usize, u64, usize), u64> = HashMap::new();
    for (line, cells) in &records {
        let text =
            |wanted: Column| columns.iter().zip(cells).find(|(c, _)| **c == wanted).map(|(_, text)| text.as_str());
        if scenario.as_deref().is_some_and(|wanted| text(Column::Scenario) != Some(wanted)) {
            measured.left_out += 1;
            continue;
        }
        let here = |error: Malformed, name: &str| {
            error.at_line(crate::number::index(*line), 0).in_file(&source.name).moved_to(name)
        };
        let motion = match text(Column::Motion) {
            None => 0,
            Some(name) => motions.iter().position(|other| other == name).ok_or_else(|| {
                let what = format!("the mission has no motion '{name}'");
                here(Malformed::unknown(what, name, &motions), "motion")
            })?,
        };
        let mut row = MeasuredRow { time: f64::NAN, value: [None; CHANNELS], u: [None; CHANNELS] };
        for ((column, name), text) in columns.iter().zip(&headers).zip(cells) {
            let fault = |error| here(error, name);
            match column {
                Column::Motion | Column::Scenario => {}
                Column::Time => row.time = time(text, mission).map_err(fault)?,
                Column::Value(channel) if !text.is_empty() => {
                    let value = number(text, name).map_err(fault)? * si_per_unit(*channel);
                    row.value.get_mut(*channel).into_iter().for_each(|slot| *slot = Some(value));
                }
                Column::Uncertainty(channel) if !text.is_empty() => {
                    let u = number(text, name).map_err(fault)?;
                    if !(u > 0.0) {
                        return Err(fault(
                            Malformed::new(Fault::Value, "a standard uncertainty is not positive")
                                .expected("a number above 0")
                                .found(text.to_string()),
                        ));
                    }
                    row.u.get_mut(*channel).into_iter().for_each(|slot| *slot = Some(u * si_per_unit(*channel)));
                }
                _ => {}
            }
        }
        for ((name, channel), (value, u)) in CHANNEL_NAMES.iter().zip(0..).zip(row.value.iter().zip(&row.u)) {
            if value.is_some() && u.is_none() && columns.contains(&Column::Uncertainty(channel)) {
                let error = Malformed::new(Fault::Missing, format!("the value has no '{name}_u'"));
                let error = error.expected("a standard uncertainty in every row with a value, or no such column");
                return Err(here(error, &format!("{name}_u")));
            }
        }
        for (channel, name) in
            CHANNEL_NAMES.iter().enumerate().filter(|(k, _)| row.value.get(*k).is_some_and(Option::is_some))
        {
            // `+ 0.0` makes one zero of two
            let Some(first) = lines.insert((motion, (row.time + 0.0).to_bits(), channel), *line) else { continue };
            let error = Malformed::new(Fault::Value, format!("'{name}' was measured twice at {} s", row.time))
                .expected("one value for each motion and time")
                .found(format!("lines {first} and {line}"));
            return Err(here(error, "time_s"));
        }
        measured.push(motion, row);
    }
    if measured.count() == 0 {
        return Err(Malformed::new(Fault::Missing, "nothing was measured")
            .expected("rows with a time and at least one navigation error")
            .in_file(&source.name));
    }
    Ok(measured)
}

/// Line and cells of a row of the file.
type Row = (u64, Vec<String>);

/// What each column is.
fn columns(headers: &[record::Column], file: &str, line: usize) -> Result<Vec<Column>> {
    let mut columns: Vec<Column> = Vec::new();
    let at = |error: Malformed| error.at_line(line, 0).in_file(file);
    for name in headers.iter().map(|column| column.title.as_str()) {
        let plain = name.strip_suffix("_u").unwrap_or(name);
        let channel = CHANNEL_NAMES.iter().position(|channel| *channel == plain);
        let column = match (name, channel) {
            ("motion", _) => Column::Motion,
            ("scenario", _) => Column::Scenario,
            ("time_s", _) => Column::Time,
            (_, Some(channel)) if plain == name => Column::Value(channel),
            (_, Some(channel)) => Column::Uncertainty(channel),
            _ => {
                return Err(at(Malformed::new(Fault::UnknownKey, format!("unknown column '{name}'"))
                    .expected(format!(
                        "time_s, motion, scenario, {}, or one of these with _u for its standard uncertainty",
                        CHANNEL_NAMES.join(", ")
                    ))
                    .found(format!("'{name}'"))
                    .at_path(name)));
            }
        };
        if columns.contains(&column) {
            return Err(at(Malformed::new(Fault::NameClash, format!("the column '{name}' occurs twice"))
                .expected("each column once")
                .at_path(name)));
        }
        columns.push(column);
    }
    let missing = |what: &str, expected: String| at(Malformed::new(Fault::Missing, what).expected(expected));
    if !columns.contains(&Column::Time) {
        return Err(missing("the column 'time_s' is missing", "the time since the start, s".into()));
    }
    if !columns.iter().any(|column| matches!(column, Column::Value(_))) {
        return Err(missing("no column holds a navigation error", format!("one of {}", CHANNEL_NAMES.join(", "))));
    }
    for (channel, name) in CHANNEL_NAMES.iter().enumerate() {
        if columns.contains(&Column::Uncertainty(channel)) && !columns.contains(&Column::Value(channel)) {
            return Err(missing("an uncertainty has no values", format!("a column '{name}' for '{name}_u'")));
        }
    }
    Ok(columns)
}

/// The scenario whose rows count; `None` where there is no such column.
fn scenario(columns: &[Column], records: &[Row], source: &Source) -> Result<Option<String>> {
    let Some(place) = columns.iter().position(|column| *column == Column::Scenario) else { return Ok(None) };
    let mut names: Vec<&str> = records.iter().filter_map(|(_, cells)| cells.get(place)).map(String::as_str).collect();
    names.sort_unstable();
    names.dedup();
    match names.as_slice() {
        [] => Ok(None),
        [one] => Ok(Some((*one).to_string())),
        names if names.contains(&"all") => Ok(Some("all".into())),
        names => Err(Malformed::new(Fault::Value, "the file holds several scenarios")
            .at_path("scenario")
            .expected("one scenario, or rows of the scenario 'all'")
            .found(names.join(", "))
            .in_file(&source.name)),
    }
}

fn number(text: &str, name: &str) -> Result<f64> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(Malformed::new(Fault::Value, format!("'{name}' is not a number"))
            .expected("a finite number with a decimal point")
            .found(format!("'{text}'"))),
    }
}

fn time(text: &str, mission: &Mission) -> Result<f64> {
    let time = number(text, "time_s")?;
    let end = mission.duration();
    if !(-1e-6..=end + 1e-6).contains(&time) {
        return Err(Malformed::new(Fault::Value, "the time is outside the mission")
            .expected(format!("0 to {end} s"))
            .found(format!("{time} s")));
    }
    Ok(time.clamp(0.0, end))
}

/// Measured navigation errors as CSV text: what [`read_measured`] reads, with digits down to a hundredth of each `u`.
pub fn write_measured(measured: &Measured, mission: &Mission) -> String {
    let motions: Vec<String> = study::motions(mission).into_iter().map(|(name, _)| name).collect();
    let several = measured.runs.len() > 1 || measured.runs.iter().any(|run| run.motion != 0);
    let channels: Vec<usize> =
        (0..CHANNELS).filter(|channel| measured.cells().any(|cell| cell.channel == *channel)).collect();
    let stated = |channel: usize| measured.cells().any(|cell| cell.channel == channel && cell.u.is_some());
    let mut header: Vec<String> = several.then(|| "motion".to_string()).into_iter().collect();
    header.push("time_s".into());
    for channel in &channels {
        let name = CHANNEL_NAMES.at(*channel);
        header.push(name.into());
        header.extend(stated(*channel).then(|| format!("{name}_u")));
    }
    let mut text = header.join(",") + "\n";
    for run in &measured.runs {
        for row in &run.rows {
            let mut cells: Vec<String> = Vec::new();
            cells.extend(several.then(|| motions.get(run.motion).cloned().unwrap_or_default()));
            cells.push(row.time.to_string());
            for channel in &channels {
                let unit = si_per_unit(*channel);
                let value = row.value.get(*channel).copied().flatten().map(|value| value / unit);
                let u = row.u.get(*channel).copied().flatten().map(|u| u / unit);
                let digits = u.map_or(9, |u| crate::number::count((2.0 - u.log10().floor()).clamp(0.0, 15.0)));
                cells.push(value.map_or(String::new(), |value| format!("{value:.digits$}")));
                cells.extend(stated(*channel).then(|| u.map_or(String::new(), |u| format!("{:e}", significant(u)))));
            }
            text.push_str(&(cells.join(",") + "\n"));
        }
    }
    text
}

/// Without what a unit of radians costs in the last digits.
fn significant(value: f64) -> f64 {
    // a printed number is read again
    format!("{value:.9e}").parse().unwrap_or(value)
}
