//! Commands of the program, the tables that they read and write, and simulated readings.

use crate::fit::numbers;
use crate::question::Question;
use crate::work::{interruptible, raised};
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyBytes};
use std::path::PathBuf;
use tumble::cli;
use tumble::record::{As, Block, Record};
use tumble::wire::{self, Source};

/// A command as in a shell: exit code, stdout, stderr. With `raise_malformed` a malformed question is an exception.
#[pyfunction]
#[pyo3(signature = (arguments, raise_malformed=false))]
pub fn run<'py>(
    py: Python<'py>,
    arguments: Vec<String>,
    raise_malformed: bool,
) -> PyResult<(u8, Bound<'py, PyBytes>, String)> {
    let printed = interruptible(py, move || cli::run_embedded(arguments))?;
    match printed.error {
        Some(error) if raise_malformed => Err(raised(py, &error, None)),
        _ => Ok((printed.exit_code, PyBytes::new(py, &printed.stdout), printed.stderr)),
    }
}

/// The readings of a schedule from a truth, as the text of a campaign.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn simulate(
    py: Python<'_>,
    schedule: Bound<'_, PyAny>,
    name: String,
    folder: PathBuf,
    truth: Bound<'_, PyAny>,
    truth_name: String,
    seed: u64,
    dumps: Bound<'_, PyAny>,
) -> PyResult<String> {
    let question = Question::new(schedule, name, folder.clone(), dumps.clone());
    let (schedule, source) = question.campaign(None)?;
    let truth_source = Question::new(truth, truth_name, folder, dumps).source()?;
    let truth = wire::read_truth(&truth_source, &schedule)
        .map_err(|error| raised(py, &error, Some(truth_source.text.as_str())))?;
    let found = interruptible(py, move || {
        let found = tumble::simulate(&schedule, &truth, seed)?;
        Ok(serde_json::to_string(&wire::campaign_file(&found, wire::bench_ref(&found))))
    })?;
    let source: Option<Source> = source;
    let text = found.map_err(|error| question.raised(py, error, source.as_ref()))?;
    text.map_err(|error| PyOSError::new_err(error.to_string()))
}

/// Write a table as Parquet, in which nothing is guessed.
#[pyfunction]
pub fn write_table(py: Python<'_>, table: Bound<'_, PyAny>, path: PathBuf) -> PyResult<()> {
    let columns = crate::table::columns(&table)?;
    // the same is asked of it as of a table that stays in memory
    let write = || crate::table::held("table", columns.clone()).and_then(|_| cli::write_table(&columns, &path));
    py.detach(write).map_err(|error| raised(py, &error, None))
}

/// The numbers of columns of a file; of columns with one title the last.
#[pyfunction]
pub fn read_numbers<'py>(
    py: Python<'py>,
    path: PathBuf,
    titles: Vec<String>,
) -> PyResult<Vec<Bound<'py, PyByteArray>>> {
    let read = || {
        let mut record = Record::at(&path)?;
        let place = |title: &String| match record.columns().iter().rposition(|column| column.title == *title) {
            Some(place) => Ok((place, As::Number)),
            None => record.find(title).map(|place| (place, As::Number)),
        };
        let wanted = titles.iter().map(place).collect::<tumble::Result<Vec<_>>>()?;
        record.select(&wanted);
        let (mut all, mut block) = (vec![Vec::new(); wanted.len()], Block::default());
        while record.next(&mut block)? {
            all.iter_mut().zip(&block.columns).for_each(|(all, part)| all.extend_from_slice(part));
        }
        Ok(all)
    };
    let all: Vec<Vec<f64>> = py.detach(read).map_err(|error| raised(py, &error, None))?;
    all.iter().map(|own| numbers(py, own.len(), |k| own.get(k).copied().unwrap_or(f64::NAN))).collect()
}
