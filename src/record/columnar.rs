//! Parquet in blocks: the selected columns of one row group after the other.

use super::columnar_labels::{self, Pages};
use super::{As, Block, Column, Labels};
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use parquet::basic::{LogicalType, TimeUnit};
use parquet::column::reader::ColumnReader;
use parquet::data_type::{ByteArray, FixedLenByteArray};
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use std::fs::File;

/// Rows of a block.
const ROWS: usize = 1 << 16;

/// An open Parquet file.
pub struct Columnar {
    name: String,
    reader: SerializedFileReader<File>,
    columns: Vec<Column>,
    /// What a number of each column is multiplied by (times become seconds).
    factors: Vec<f64>,
    wanted: Vec<(usize, As)>,
    group: usize,
    open: Vec<Open>,
    labels: Labels,
    scratch: Scratch,
}

/// A column of the row group that is being read.
enum Open {
    Values(Box<ColumnReader>),
    Labels(Pages),
}

#[derive(Default)]
struct Scratch {
    levels: Vec<i16>,
    doubles: Vec<f64>,
    floats: Vec<f32>,
    ints: Vec<i32>,
    longs: Vec<i64>,
    bools: Vec<bool>,
    bytes: Vec<ByteArray>,
    fixed: Vec<FixedLenByteArray>,
}

impl std::fmt::Debug for Columnar {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Columnar").field("name", &self.name).field("columns", &self.columns).finish_non_exhaustive()
    }
}

impl Columnar {
    /// Open a file.
    ///
    /// Errors: a file that is no Parquet, or was cut off.
    pub fn open(name: &str, file: File) -> Result<Self> {
        let reader = SerializedFileReader::new(file).map_err(|error| fault(name, &error))?;
        let schema = reader.metadata().file_metadata().schema_descr();
        let columns = schema.columns().iter().map(|c| Column::titled(&c.path().string())).collect();
        let factors = schema
            .columns()
            .iter()
            .map(|column| match column.logical_type_ref() {
                Some(LogicalType::Timestamp(t)) => seconds(&t.unit),
                Some(LogicalType::Time(t)) => seconds(&t.unit),
                _ => 1.0,
            })
            .collect();
        Ok(Columnar {
            name: name.into(),
            reader,
            columns,
            factors,
            wanted: Vec::new(),
            group: 0,
            open: Vec::new(),
            labels: Labels::default(),
            scratch: Scratch::default(),
        })
    }

    /// Its columns.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Does a column hold texts, not numbers?
    pub fn is_text(&self, column: usize) -> bool {
        use parquet::basic::Type::{BYTE_ARRAY, FIXED_LEN_BYTE_ARRAY, INT96};
        let schema = self.reader.metadata().file_metadata().schema_descr();
        let kind = schema.columns().get(column).map(|own| own.physical_type());
        kind.is_some_and(|kind| matches!(kind, BYTE_ARRAY | FIXED_LEN_BYTE_ARRAY | INT96))
    }

    /// The name given to [`Columnar::open`].
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How many rows it has.
    pub fn rows(&self) -> u64 {
        self.reader.metadata().file_metadata().num_rows().max(0).unsigned_abs()
    }

    /// The labels met so far.
    pub fn labels(&self) -> &[String] {
        &self.labels.texts
    }

    /// Which columns the blocks have.
    pub fn select(&mut self, columns: &[(usize, As)]) {
        self.wanted = columns.to_vec();
    }

    /// The next rows, of one row group.
    pub fn next(&mut self, block: &mut Block) -> Result<bool> {
        block.columns.resize_with(self.wanted.len(), Vec::new);
        loop {
            block.columns.iter_mut().for_each(Vec::clear);
            let error = |error: ParquetError| fault(&self.name, &error);
            if self.open.is_empty() {
                if self.group >= self.reader.num_row_groups() || self.wanted.is_empty() {
                    return Ok(false);
                }
                let group = self.reader.get_row_group(self.group).map_err(error)?;
                let open = |(column, kind): &(usize, As)| {
                    let own = group.metadata().column(*column);
                    Ok(match kind {
                        As::Label if columnar_labels::reads(own) => {
                            let is_optional = own.column_descr().max_def_level() > 0;
                            Open::Labels(Pages::new(group.get_column_page_reader(*column)?, is_optional))
                        }
                        _ => Open::Values(Box::new(group.get_column_reader(*column)?)),
                    })
                };
                self.open = self.wanted.iter().map(open).collect::<std::result::Result<_, _>>().map_err(error)?;
                self.group += 1;
            }
            let wanted = self.wanted.iter().zip(&mut self.open).zip(&mut block.columns);
            for (((column, kind), reader), to) in wanted {
                let factor = self.factors.at(*column);
                let title = self.columns.get(*column).map_or("", |c| c.title.as_str());
                match (kind, reader) {
                    (_, Open::Labels(pages)) => pages.read(ROWS, to, &mut self.labels),
                    (As::Number | As::Cell, Open::Values(reader)) => numbers(reader, &mut self.scratch, to, factor),
                    (As::Label, Open::Values(reader)) => labels(reader, &mut self.scratch, to, &mut self.labels),
                }
                .map_err(|error| fault(&self.name, &error).at_path(title))?;
            }
            let rows = block.rows();
            if block.columns.iter().any(|column| column.len() != rows) {
                return Err(Malformed::new(Fault::Value, "columns have different numbers of values")
                    .expected("flat columns, without lists")
                    .in_file(&self.name));
            }
            if rows > 0 {
                return Ok(true);
            }
            self.open.clear();
        }
    }
}

fn seconds(unit: &TimeUnit) -> f64 {
    match unit {
        TimeUnit::MILLIS => 1e-3,
        TimeUnit::MICROS => 1e-6,
        TimeUnit::NANOS => 1e-9,
    }
}

fn fault(name: &str, error: &ParquetError) -> Malformed {
    Malformed::new(Fault::File, format!("'{name}' cannot be read as Parquet"))
        .expected("a whole file, uncompressed or compressed by snappy, gzip or zstd")
        .found(error.to_string())
        .in_file(name)
}

type Read = std::result::Result<(), ParquetError>;

/// Values to their rows; rows without one are NaN.
fn place<T>(values: &[T], levels: &[i16], highest: i16, to: &mut Vec<f64>, number: impl Fn(&T) -> f64) {
    if values.len() == levels.len() || levels.is_empty() {
        to.extend(values.iter().map(number));
        return;
    }
    let mut values = values.iter();
    to.extend(levels.iter().map(|l| if *l == highest { values.next().map_or(f64::NAN, &number) } else { f64::NAN }));
}

macro_rules! read {
    ($reader:expr, $buffer:expr, $levels:expr, $to:expr, $number:expr) => {{
        $buffer.clear();
        $levels.clear();
        $reader.read_records(ROWS, Some(&mut $levels), None, &mut $buffer)?;
        let highest = $levels.iter().copied().max().unwrap_or(0).max(1);
        place(&$buffer, &$levels, highest, $to, $number);
        Ok(())
    }};
}

fn numbers(reader: &mut ColumnReader, scratch: &mut Scratch, to: &mut Vec<f64>, factor: f64) -> Read {
    let Scratch { levels, doubles, floats, ints, longs, bools, .. } = scratch;
    match reader {
        ColumnReader::DoubleColumnReader(r) => {
            doubles.clear();
            levels.clear();
            r.read_records(ROWS, Some(levels), None, doubles)?;
            if doubles.len() == levels.len() || levels.is_empty() {
                // no row is without a value: the column is handed over as it is
                std::mem::swap(to, doubles);
            } else {
                place(doubles, levels, levels.iter().copied().max().unwrap_or(1).max(1), to, |v| *v);
            }
            Ok(())
        }
        ColumnReader::FloatColumnReader(r) => read!(r, *floats, *levels, to, |v: &f32| f64::from(*v)),
        ColumnReader::Int32ColumnReader(r) => read!(r, *ints, *levels, to, |v: &i32| f64::from(*v) * factor),
        ColumnReader::Int64ColumnReader(r) => read!(r, *longs, *levels, to, |v: &i64| *v as f64 * factor),
        ColumnReader::BoolColumnReader(r) => read!(r, *bools, *levels, to, |v: &bool| f64::from(u8::from(*v))),
        _ => Err(ParquetError::General("a column of texts, where numbers are expected".into())),
    }
}

fn labels(reader: &mut ColumnReader, scratch: &mut Scratch, to: &mut Vec<f64>, labels: &mut Labels) -> Read {
    let names = std::cell::RefCell::new(labels);
    let Scratch { levels, bytes, fixed, .. } = scratch;
    match reader {
        ColumnReader::ByteArrayColumnReader(r) => {
            // rows of one dictionary entry lie at one place, as long as they are read together
            let last = std::cell::Cell::new((std::ptr::null(), 0, f64::NAN));
            read!(r, *bytes, *levels, to, |v: &ByteArray| {
                let (place, length, number) = last.get();
                if place == v.data().as_ptr() && length == v.len() {
                    return number;
                }
                let number = names.borrow_mut().number(v.data());
                last.set((v.data().as_ptr(), v.len(), number));
                number
            })
        }
        ColumnReader::FixedLenByteArrayColumnReader(r) => {
            read!(r, *fixed, *levels, to, |v: &FixedLenByteArray| names.borrow_mut().number(v.data()))
        }
        _ => {
            let mut values = Vec::new();
            numbers(reader, scratch, &mut values, 1.0)?;
            to.extend(values.iter().map(|v| names.borrow_mut().number(v.to_string().as_bytes())));
            Ok(())
        }
    }
}
