//! Opening a record: its file, its columns, its clock.

use crate::error::{Fault, Malformed, Result};
use crate::record::{self, Clock as Ticks, Record};
use clap::Args;
use std::path::Path;

/// Names under which a column of times is found.
const TIMES: [&str; 10] =
    ["time_s", "time", "t", "timestamp", "t_s", "time_ms", "time_us", "time_ns", "timestamp_ns", "Zeit"];

/// Where the times of the samples come from.
#[derive(Debug, Clone, Args)]
pub(super) struct Clock {
    /// The column of times (by default one that is named time_s, time, t or timestamp).
    #[arg(long, value_name = "COLUMN", conflicts_with = "rate")]
    time: Option<String>,
    /// Samples a second, where there is no column of times.
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
}

/// Open a record.
pub(super) fn open(path: &Path) -> Result<Record> {
    let name = path.display().to_string();
    if path.is_dir() {
        return Err(Malformed::new(Fault::File, format!("'{name}' is a folder")).expected("a file").in_file(name));
    }
    let file = std::fs::File::open(path).map_err(|error| {
        Malformed::new(Fault::File, format!("cannot read '{name}': {error}")).expected("a readable file")
    })?;
    super::session::reads(path);
    Record::open(&name, file)
}

impl Clock {
    /// The column of times, if there is one.
    pub(super) fn column(&self, record: &Record) -> Result<Option<usize>> {
        match (&self.time, self.rate) {
            (Some(name), _) => record.find(name).map(Some),
            (None, Some(_)) => Ok(None),
            (None, None) => Ok(TIMES.iter().find_map(|name| record::find(record.columns(), name))),
        }
    }

    /// The clock itself.
    pub(super) fn ticks(&self, record: &Record, column: Option<usize>) -> Result<Ticks> {
        match (column.and_then(|k| record.columns().get(k)), self.rate) {
            (Some(column), _) => Ticks::column(column, record.name()),
            (None, Some(rate)) => Ticks::rate(rate, record.name()),
            (None, None) => Err(Malformed::new(Fault::Missing, "the record has no column of times")
                .expected("--rate HZ, or --time COLUMN")
                .found(format!("columns {}", record::listed(record.columns())))
                .in_file(record.name())),
        }
    }
}

/// The columns that are named, or all but the times.
pub(super) fn numeric_columns(record: &Record, names: &[String], clock: &Clock) -> Result<Vec<usize>> {
    if !names.is_empty() {
        return names.iter().map(|name| record.find(name.trim())).collect();
    }
    let time = clock.column(record)?;
    Ok((0..record.columns().len()).filter(|k| Some(*k) != time).collect())
}
