//! Tables as files on the way to and from a command: Parquet, in which nothing is guessed.

use crate::fit::numbers;
use crate::table::{columns, length};
use crate::work::{MalformedError, raised};
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::types::PyByteArray;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tumble::record::{As, Block, Cells, Record};

/// Write a table as Parquet: numbers as doubles, texts as texts; what is absent has no value.
#[pyfunction]
pub fn write_table(py: Python<'_>, table: Bound<'_, PyAny>, path: PathBuf) -> PyResult<()> {
    let columns = columns(&table)?;
    let rows = columns.first().map_or(0, |(_, cells)| length(cells));
    if let Some((title, cells)) = columns.iter().find(|(_, cells)| length(cells) != rows) {
        return Err(MalformedError::new_err(format!(
            "the column '{title}' has another length: expected {rows} cells, as the first column has; found {}",
            length(cells)
        )));
    }
    py.detach(|| written(&columns, &path)).map_err(|error| PyOSError::new_err(error.to_string()))
}

fn written(columns: &[(String, Cells)], path: &Path) -> Result<(), ParquetError> {
    let field = |(title, cells): &(String, Cells)| {
        let (physical, logical) = match cells {
            Cells::Numbers(_) => (Physical::DOUBLE, None),
            Cells::Texts(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let builder = Type::primitive_type_builder(title, physical).with_logical_type(logical);
        builder.with_repetition(Repetition::OPTIONAL).build().map(Arc::new)
    };
    let fields = columns.iter().map(field).collect::<Result<_, _>>()?;
    let schema = Arc::new(Type::group_type_builder("table").with_fields(fields).build()?);
    let mut file = SerializedFileWriter::new(File::create(path)?, schema, Arc::new(WriterProperties::default()))?;
    let mut group = file.next_row_group()?;
    for (_, cells) in columns {
        let Some(mut to) = group.next_column()? else { break };
        match cells {
            Cells::Numbers(own) => {
                let levels: Vec<i16> = own.iter().map(|value| i16::from(!value.is_nan())).collect();
                let there: Vec<f64> = own.iter().copied().filter(|value| !value.is_nan()).collect();
                to.typed::<DoubleType>().write_batch(&there, Some(&levels), None)?;
            }
            Cells::Texts(own) => {
                // blanks alone are an empty cell, as in a table in memory
                let is_there = |text: &&String| !text.trim().is_empty();
                let levels: Vec<i16> = own.iter().map(|text| i16::from(is_there(&text))).collect();
                let there: Vec<ByteArray> = own.iter().filter(is_there).map(|text| text.as_str().into()).collect();
                to.typed::<ByteArrayType>().write_batch(&there, Some(&levels), None)?;
            }
        }
        to.close()?;
    }
    group.close()?;
    file.close().map(drop)
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
