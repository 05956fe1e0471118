//! Opening a record: its file, its columns, its clock.

use crate::error::Result;
use crate::record::{self, ClockFrom, Record};
use clap::Args;
use std::path::Path;

/// Where the times of the samples come from.
#[derive(Debug, Clone, Args)]
pub(super) struct Clock {
    /// The column of times (by default one that is named time_s, time, t or timestamp).
    #[arg(long, value_name = "COLUMN", conflicts_with = "rate")]
    time: Option<String>,
    /// Sampling rate in Hz, if there is no column of times.
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
}

/// Open a record; `FILE#NAME` is one table of a file that has several.
pub(super) fn open(path: &Path) -> Result<Record> {
    let record = Record::at(path)?;
    super::session::reads(&record::parted(path).0);
    Ok(record)
}

impl Clock {
    pub(super) fn source(&self) -> ClockFrom {
        ClockFrom { time: self.time.clone(), rate: self.rate }
    }
}

/// The columns that are named, or all of numbers but the times.
pub(super) fn numeric_columns(record: &Record, names: &[String], clock: &ClockFrom) -> Result<Vec<usize>> {
    if !names.is_empty() {
        return names.iter().map(|name| record.find(name.trim())).collect();
    }
    let time = clock.column(record)?;
    let unused = clock.unused(record);
    let is_sensor = |k: &usize| ![time, unused].contains(&Some(*k)) && !record.is_text(*k);
    Ok((0..record.columns().len()).filter(is_sensor).collect())
}
