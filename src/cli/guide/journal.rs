//! The journal: one JSON line for each accepted reading, undone reading and decision, on the disk before it is shown.

use crate::campaign::{Campaign, Reading, Readings};
use crate::error::{Fault, Malformed, Result};
use crate::wire::{self, BenchRef, Named, ReadingFile, ReadingsRef};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// A line of a journal.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Entry {
    /// What was read, and in which line of the file that is followed.
    Reading {
        /// Its keys.
        keys: ReadingFile,
        /// The line.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        line: Option<usize>,
        /// Of samples: standard deviations of the still sensor, by which standstills are found.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        still_sd: Vec<f64>,
    },
    /// A reading that was taken back, by its number then, and in which line of the file that is followed.
    Undone {
        /// The number.
        number: usize,
        /// The line.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        line: Option<usize>,
    },
    /// The setting that was asked for; none at the end.
    Next(Option<BTreeMap<String, f64>>),
}

impl Entry {
    pub fn reading(campaign: &Campaign, reading: &Reading, line: Option<usize>, still_sd: &[f64]) -> Self {
        let columns = campaign.readings.columns.clone();
        let one = campaign.with_readings(Readings { columns, rows: vec![reading.clone()] });
        let file = wire::campaign_file(&one, BenchRef::Named(campaign.bench.id.clone()));
        let cells = match file.readings {
            ReadingsRef::Inline(rows) => rows.into_iter().next(),
            _ => None,
        };
        Entry::Reading { keys: cells.unwrap_or(Named(Vec::new())), line, still_sd: still_sd.to_vec() }
    }
}

#[derive(Debug, Serialize, Deserialize)]
struct Header {
    guide: u32,
    campaign: String,
}

const VERSION: u32 = 1;

/// A journal that is open, and nobody else's.
pub(super) struct Journal {
    file: File,
    path: PathBuf,
}

impl Journal {
    /// Begin a journal, or go on with one. A last line that is not whole was not shown, and is dropped.
    ///
    /// Errors: one that is there already (without `resume`), or is not there (with it); another campaign's; another guide that writes it.
    pub fn open(path: &Path, campaign: &str, resume: bool) -> Result<(Self, Vec<Entry>)> {
        let fault = |error: std::io::Error| {
            Malformed::new(Fault::File, format!("cannot use the journal '{}': {error}", path.display()))
        };
        if resume && !path.exists() {
            return Err(Malformed::new(Fault::File, format!("there is no journal '{}' to go on with", path.display()))
                .expected("the journal of a guide that ended, or no --resume"));
        }
        let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path).map_err(fault)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(Malformed::new(
                    Fault::File,
                    format!("another guide writes the journal '{}'", path.display()),
                )
                .expected("one guide at a time, or another --journal"));
            }
            Err(TryLockError::Error(error)) => return Err(fault(error)),
        }
        let mut journal = Journal { file, path: path.to_path_buf() };
        let mut text = String::new();
        if journal.is_regular() {
            journal.file.read_to_string(&mut text).map_err(fault)?;
        }
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        if whole > 0 && !resume {
            return Err(Malformed::new(Fault::File, format!("the journal '{}' is there already", path.display()))
                .expected("--resume to go on with it, or another --journal"));
        }
        if whole < text.len() {
            journal.file.set_len(whole as u64).map_err(fault)?;
        }
        journal
            .file
            .seek(SeekFrom::Start(whole as u64))
            .or_else(|e| if journal.is_regular() { Err(fault(e)) } else { Ok(0) })?;
        let mut lines = text.get(..whole).unwrap_or_default().lines();
        let malformed = |line: usize, error: String| {
            Malformed::new(Fault::Syntax, format!("the journal is not as a guide wrote it: {error}"))
                .at_line(line, 0)
                .in_file(path.display().to_string())
        };
        let Some(first) = lines.next() else {
            let header = Header { guide: VERSION, campaign: campaign.to_string() };
            journal.append(&header)?;
            return Ok((journal, Vec::new()));
        };
        let header: Header = serde_json::from_str(first).map_err(|error| malformed(1, error.to_string()))?;
        if header.guide != VERSION || header.campaign != campaign {
            return Err(Malformed::new(
                Fault::Value,
                format!("the journal '{}' belongs to another campaign", path.display()),
            )
            .expected("the campaign file as it was when the guide began")
            .found(format!("SHA-256 {}, and now {campaign}", header.campaign)));
        }
        let entry =
            |(k, line): (usize, &str)| serde_json::from_str(line).map_err(|error| malformed(k + 2, error.to_string()));
        let entries = lines.enumerate().map(entry).collect::<Result<_>>()?;
        Ok((journal, entries))
    }

    fn is_regular(&self) -> bool {
        self.file.metadata().is_ok_and(|metadata| metadata.is_file())
    }

    /// One more line, on the disk when this returns.
    pub fn append(&mut self, value: &impl Serialize) -> Result<()> {
        let fault = |error: String| {
            Malformed::new(Fault::File, format!("cannot write the journal '{}': {error}", self.path.display()))
                .expected("room for one more line; what was shown is in it, and --resume goes on from there")
        };
        let line = serde_json::to_string(value).map_err(|error| fault(error.to_string()))? + "\n";
        self.file.write_all(line.as_bytes()).map_err(|error| fault(error.to_string()))?;
        let regular = self.is_regular();
        self.file.sync_data().or_else(|error| if regular { Err(fault(error.to_string())) } else { Ok(()) })
    }
}
