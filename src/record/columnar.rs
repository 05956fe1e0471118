//! Parquet in blocks: the selected columns of one row group after the other.

use super::clock_from::FIRST;
use super::columnar_arrow;
use super::columnar_labels::{self, Pages};
use super::guard::guarded;
use super::times::Times;
use super::{As, Block, Column, Head, Labels, UNREADABLE};
use crate::error::{Fault, Malformed, Result};
use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;
use std::collections::HashMap;
use std::fs::File;

/// Rows of a block.
const ROWS: usize = 1 << 16;

/// An open Parquet file.
pub(super) struct Columnar {
    pub head: Head,
    reader: SerializedFileReader<File>,
    /// What the values of each column say.
    meanings: Vec<Meaning>,
    wanted: Vec<(usize, As)>,
    group: usize,
    open: Vec<Open>,
    /// The first time of columns of times.
    since: HashMap<usize, f64>,
}

/// What the values of a column say, by its logical type.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Meaning {
    /// What they are.
    Plain,
    /// Whole numbers without a sign.
    Unsigned,
    /// Whole numbers of this power of ten below 1.
    Decimal(i32),
    /// Floating point in two bytes.
    Half,
    /// Instants, or times of day and durations, in seconds each; `true` for instants.
    Time(f64, bool),
    /// Days since 1970.
    Date,
    /// Sixteen bytes.
    Uuid,
    /// A type that is not read.
    Unread,
}

impl Meaning {
    fn of(column: &ColumnDescriptor) -> Self {
        // lists and maps have several values in a row
        if column.max_rep_level() > 0 {
            return Meaning::Unread;
        }
        let scale = column.type_scale();
        let of_time = |unit: &TimeUnit, instant| Meaning::Time(seconds(unit), instant);
        match (column.logical_type_ref(), column.converted_type()) {
            (Some(LogicalType::Timestamp(t)), _) => of_time(&t.unit, true),
            (Some(LogicalType::Time(t)), _) => of_time(&t.unit, false),
            (Some(LogicalType::Decimal(decimal)), _) => Meaning::Decimal(decimal.scale),
            (Some(LogicalType::Float16), _) => Meaning::Half,
            (Some(LogicalType::Date), _) => Meaning::Date,
            (Some(LogicalType::Uuid), _) => Meaning::Uuid,
            (Some(LogicalType::Integer(integer)), _) if !integer.is_signed => Meaning::Unsigned,
            (
                Some(
                    LogicalType::Integer(_)
                    | LogicalType::String
                    | LogicalType::Enum
                    | LogicalType::Json
                    | LogicalType::Unknown,
                ),
                _,
            ) => Meaning::Plain,
            (None, ConvertedType::DECIMAL) => Meaning::Decimal(scale),
            (None, ConvertedType::TIMESTAMP_MILLIS) => Meaning::Time(1e-3, true),
            (None, ConvertedType::TIMESTAMP_MICROS) => Meaning::Time(1e-6, true),
            (None, ConvertedType::TIME_MILLIS) => Meaning::Time(1e-3, false),
            (None, ConvertedType::TIME_MICROS) => Meaning::Time(1e-6, false),
            (None, ConvertedType::DATE) => Meaning::Date,
            (
                None,
                ConvertedType::UINT_8 | ConvertedType::UINT_16 | ConvertedType::UINT_32 | ConvertedType::UINT_64,
            ) => Meaning::Unsigned,
            (None, ConvertedType::INTERVAL) => Meaning::Unread,
            (None, _) if column.physical_type() == Type::INT96 => Meaning::Time(1e-9, true),
            (None, _) => Meaning::Plain,
            (Some(_), _) => Meaning::Unread,
        }
    }

    /// Does it give numbers, whatever its physical type?
    fn is_number(self) -> bool {
        !matches!(self, Meaning::Plain | Meaning::Uuid | Meaning::Unread)
    }

    /// Does it give times, in seconds each?
    fn is_time(self) -> bool {
        matches!(self, Meaning::Time(..) | Meaning::Date)
    }

    /// Are the values of a reader numbers? (A date is a text, unless numbers are asked for.)
    fn is_number_of(self, reader: &ColumnReader) -> bool {
        let bytes =
            matches!(reader, ColumnReader::ByteArrayColumnReader(_) | ColumnReader::FixedLenByteArrayColumnReader(_));
        self != Meaning::Date && (self.is_number() || !bytes)
    }

    /// A whole number as what it says.
    fn whole(self, value: i64, as_unsigned: u64) -> f64 {
        match self {
            Meaning::Unsigned => as_unsigned as f64,
            Meaning::Decimal(scale) => value as f64 / 10_f64.powi(scale),
            Meaning::Time(seconds, _) => value as f64 * seconds,
            Meaning::Date => value as f64 * 86_400.0,
            _ => value as f64,
        }
    }

    /// The same as a text.
    fn text(self, value: i64, as_unsigned: u64) -> String {
        let at = |nanoseconds: i128, day: bool| {
            let there = jiff::Timestamp::from_nanosecond(nanoseconds).ok();
            there.map(|moment| moment.to_zoned(jiff::tz::TimeZone::UTC).datetime()).map(|moment| match day {
                true => moment.date().to_string(),
                false => moment.to_string(),
            })
        };
        let text = match self {
            Meaning::Unsigned => Some(as_unsigned.to_string()),
            Meaning::Decimal(scale) => decimal(i128::from(value), scale),
            Meaning::Time(seconds, true) => {
                at(i128::from(value) * i128::from(crate::number::whole_i64((1e9 * seconds).round())), false)
            }
            Meaning::Time(..) => Some(self.whole(value, as_unsigned).to_string()),
            Meaning::Date => at(i128::from(value) * 86_400_000_000_000, true),
            _ => None,
        };
        text.unwrap_or_else(|| value.to_string())
    }

    /// Bytes as a number; `None` where they are a text.
    fn bytes(self, bytes: &[u8]) -> Option<f64> {
        match (self, bytes) {
            (Meaning::Decimal(scale), _) => Some(whole(bytes)? as f64 / 10_f64.powi(scale)),
            (Meaning::Half, [low, high]) => Some(half(u16::from_le_bytes([*low, *high]))),
            _ => None,
        }
    }

    /// Bytes as a text.
    fn bytes_text(self, bytes: &[u8]) -> Option<String> {
        match self {
            Meaning::Decimal(scale) => decimal(whole(bytes)?, scale),
            Meaning::Half => Some(self.bytes(bytes)?.to_string()),
            Meaning::Uuid => Some(bytes.iter().map(|byte| format!("{byte:02x}")).collect()),
            _ => None,
        }
    }
}

/// Labels that are numbers become these.
fn mixed(column: &mut [f64], texts: &[String]) {
    for cell in column.iter_mut().filter(|cell| !cell.is_nan()) {
        let text = texts.get(crate::number::count(*cell)).map_or("", |text| text.trim());
        *cell = match super::number::number(text.as_bytes(), b'.') {
            _ if text.is_empty() => f64::NAN,
            Some(value) if !value.is_nan() => value,
            _ => super::text_cell(*cell),
        };
    }
}

/// A whole number in two's complement, the highest byte first; `None` beyond 128 bits.
fn whole(bytes: &[u8]) -> Option<i128> {
    let sign = if bytes.first().is_some_and(|first| first & 0x80 != 0) { -1 } else { 0 };
    let (above, low) = bytes.split_at(bytes.len().saturating_sub(16));
    // bytes above are there to fill the width of the type
    let fits = above
        .iter()
        .chain(low.first().filter(|_| !above.is_empty()))
        .all(|byte| *byte == if sign < 0 { 0xFF } else { 0 });
    fits.then(|| low.iter().fold(sign, |all, byte| (all << 8) | i128::from(*byte)))
}

/// A decimal number as it is written.
pub(crate) fn decimal(value: i128, scale: i32) -> Option<String> {
    let places = usize::try_from(scale).ok().filter(|places| *places <= 40)?;
    let digits = format!("{:0>width$}", value.unsigned_abs(), width = places + 1);
    let (whole, part) = digits.split_at_checked(digits.len() - places)?;
    let sign = if value < 0 { "-" } else { "" };
    Some(if places == 0 { format!("{sign}{whole}") } else { format!("{sign}{whole}.{part}") })
}

/// Binary16 of IEEE 754.
fn half(bits: u16) -> f64 {
    let (exponent, fraction) = (i32::from((bits >> 10) & 0x1F), f64::from(bits & 0x3FF));
    let size = match exponent {
        0 => fraction * 2_f64.powi(-24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1.0 + fraction / 1024.0) * 2_f64.powi(exponent - 15),
    };
    if bits & 0x8000 == 0 { size } else { -size }
}

/// A column of the row group that is being read.
enum Open {
    Values(Box<ColumnReader>),
    Labels(Pages),
    /// Values of a type that is not read, where cells may be texts: so many rows, each with the name of the type.
    Unread(usize, String),
}

impl Columnar {
    /// Open a file.
    ///
    /// Errors: a file that is no Parquet, or was cut off.
    pub fn open(name: &str, file: File) -> Result<Self> {
        guarded(|| Self::opened(name, file)).unwrap_or_else(|| Err(damaged(name)))
    }

    fn opened(name: &str, file: File) -> Result<Self> {
        let reader = SerializedFileReader::new(file).map_err(|error| fault(name, &error))?;
        let schema = reader.metadata().file_metadata().schema_descr();
        let written = reader.metadata().file_metadata().key_value_metadata();
        let arrow = written
            .into_iter()
            .flatten()
            .find(|entry| entry.key == "ARROW:schema")
            .and_then(|entry| entry.value.as_ref());
        let arrow = arrow.map(|schema| columnar_arrow::said(schema)).unwrap_or_default();
        let meaning = |column: &ColumnDescriptor| match Meaning::of(column) {
            Meaning::Plain => match arrow.durations.get(&column.path().string()) {
                Some(seconds) => Meaning::Time(*seconds, false),
                None => Meaning::Plain,
            },
            other => other,
        };
        let meanings: Vec<Meaning> = schema.columns().iter().map(|column| meaning(column)).collect();
        let titled = schema.columns().iter().map(|c| Column::titled(&c.path().string()));
        // times of these types are seconds here
        let unit = |(column, meaning): (Column, &Meaning)| match meaning.is_time() {
            true => Column { unit: Some("s".into()), ..column },
            false => Column { unit: column.unit.or_else(|| arrow.units.get(&column.title).cloned()), ..column },
        };
        let columns = titled.zip(&meanings).map(unit).collect();
        Ok(Columnar {
            head: Head::new(name, columns),
            reader,
            meanings,
            wanted: Vec::new(),
            group: 0,
            open: Vec::new(),
            since: Default::default(),
        })
    }

    /// Does a column hold texts, not numbers?
    pub fn is_text(&self, column: usize) -> bool {
        let schema = self.reader.metadata().file_metadata().schema_descr();
        let kind = schema.columns().get(column).map(|descriptor| descriptor.physical_type());
        kind.is_some_and(|kind| matches!(kind, Type::BYTE_ARRAY | Type::FIXED_LEN_BYTE_ARRAY))
            && self.meanings.get(column).is_some_and(|meaning| !meaning.is_number())
    }

    /// Of a column of whole numbers of 64 bits: the decimal places of the unit that it is read in, and its type.
    #[cfg(feature = "cli")]
    pub fn whole(&self, column: usize) -> Option<(i32, Option<LogicalType>)> {
        let schema = self.reader.metadata().file_metadata().schema_descr();
        let descriptor = schema.columns().get(column).filter(|own| own.physical_type() == Type::INT64)?;
        let logical = descriptor.logical_type_ref();
        let places = match (self.meanings.get(column)?, logical) {
            (Meaning::Plain, _) => 0,
            (Meaning::Unsigned, _) => return Some((0, Some(LogicalType::integer(64, false)))),
            (Meaning::Time(seconds, _), Some(LogicalType::Timestamp(_) | LogicalType::Time(_))) => {
                crate::number::whole(-seconds.log10().round())
            }
            _ => return None,
        };
        Some((places, logical.cloned()))
    }

    /// Does a column hold times, in seconds each?
    #[cfg(feature = "cli")]
    pub fn is_of_times(&self, column: usize) -> bool {
        self.meanings.get(column).is_some_and(|meaning| meaning.is_time())
    }

    /// The first values of a column; NaN where a cell is no number, and none of a file that is damaged there.
    pub fn first_values(&self, column: usize) -> Vec<f64> {
        let read = || {
            let mut reader = self.reader.get_row_group(0).ok()?.get_column_reader(column).ok()?;
            let meaning = self.meanings.get(column).copied().filter(|meaning| *meaning != Meaning::Unread)?;
            let (mut found, mut times) = (Vec::new(), Times::default());
            numbers(&mut reader, &mut found, meaning, As::Cell, &mut times, &mut None).ok()?;
            found.truncate(FIRST);
            Some(found)
        };
        guarded(read).flatten().unwrap_or_default()
    }

    /// How many rows it has.
    pub fn rows(&self) -> u64 {
        self.reader.metadata().file_metadata().num_rows().max(0).unsigned_abs()
    }

    /// Which columns the blocks have.
    pub fn select(&mut self, columns: &[(usize, As)]) {
        self.wanted = columns.to_vec();
    }

    /// The next rows, of one row group.
    pub fn next(&mut self, block: &mut Block) -> Result<bool> {
        let read = guarded(|| self.following(block));
        read.unwrap_or_else(|| Err(damaged(&self.head.name)))
    }

    fn following(&mut self, block: &mut Block) -> Result<bool> {
        loop {
            block.clear(self.wanted.len());
            let error = |error: ParquetError| fault(&self.head.name, &error);
            if self.open.is_empty() {
                if self.group >= self.reader.num_row_groups() || self.wanted.is_empty() {
                    return Ok(false);
                }
                if std::mem::take(&mut self.head.forgets) {
                    self.head.labels = Labels::default();
                }
                let group = self.reader.get_row_group(self.group).map_err(error)?;
                let rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
                let open = |(column, kind): &(usize, As)| {
                    let chunk = group.metadata().column(*column);
                    let is_unread = self.meanings.get(*column) == Some(&Meaning::Unread);
                    Ok(match kind {
                        As::Number | As::Time if is_unread => {
                            let title = self.head.columns.get(*column).map_or("", |c| c.title.as_str());
                            return Err(Malformed::new(Fault::Value, format!("the column '{title}' is not read"))
                                .expected("numbers, one in a row; or other columns than this one")
                                .found(values_of(chunk.column_descr()))
                                .in_file(&self.head.name)
                                .at_path(title));
                        }
                        _ if is_unread => Open::Unread(rows, values_of(chunk.column_descr())),
                        As::Label | As::Written | As::Mixed
                            if columnar_labels::reads(chunk) && self.meanings.get(*column) == Some(&Meaning::Plain) =>
                        {
                            let is_optional = chunk.column_descr().max_def_level() > 0;
                            let pages = group.get_column_page_reader(*column).map_err(error)?;
                            Open::Labels(Pages::new(pages, is_optional))
                        }
                        _ => Open::Values(Box::new(group.get_column_reader(*column).map_err(error)?)),
                    })
                };
                self.open = self.wanted.iter().map(open).collect::<Result<_>>()?;
                self.group += 1;
            }
            let wanted = self.wanted.iter().zip(&mut self.open).zip(&mut block.columns);
            for (((column, kind), reader), to) in wanted {
                let meaning = self.meanings.get(*column).copied().unwrap_or(Meaning::Plain);
                let title = self.head.columns.get(*column).map_or("", |c| c.title.as_str());
                // a text that was met where numbers are expected
                let mut no_number: Option<String> = None;
                match (kind, reader) {
                    (kind, Open::Unread(rows, values)) => {
                        let count = (*rows).min(ROWS);
                        *rows -= count;
                        let label = self.head.labels.number(values.as_bytes());
                        to.resize(
                            count,
                            match kind {
                                As::Cell => UNREADABLE,
                                As::Mixed => super::text_cell(label),
                                _ => label,
                            },
                        );
                        Ok(())
                    }
                    (kind, Open::Labels(pages)) => pages.read(ROWS, to, &mut self.head.labels).map(|()| {
                        if *kind == As::Mixed {
                            mixed(to, &self.head.labels.texts);
                        }
                    }),
                    (As::Mixed, Open::Values(reader)) if !meaning.is_number_of(reader) => {
                        labels(reader, to, meaning, &mut self.head.labels).map(|()| mixed(to, &self.head.labels.texts))
                    }
                    (As::Written, Open::Values(reader)) if matches!(**reader, ColumnReader::Int64ColumnReader(_)) => {
                        let written = &mut block.written;
                        values(reader, to, |value| match value {
                            Value::Whole(_, bits) if meaning == Meaning::Unsigned => {
                                written.push(bits.to_string().bytes())
                            }
                            Value::Whole(value, _) => written.push(value.to_string().bytes()),
                            _ => f64::NAN,
                        })
                    }
                    (As::Label | As::Written, Open::Values(reader)) => {
                        labels(reader, to, meaning, &mut self.head.labels)
                    }
                    (_, Open::Values(reader)) => {
                        let times = &mut self.head.times;
                        let read = numbers(reader, to, meaning, *kind, times, &mut no_number);
                        // readings have times since the first, as of a table of text
                        if matches!(kind, As::Mixed | As::Cell) && meaning.is_time() {
                            let first = to.iter().copied().find(|time| !time.is_nan());
                            let since = self.since.get(column).copied().or(first);
                            self.since.extend(since.map(|since| (*column, since)));
                            to.iter_mut().for_each(|time| *time -= since.unwrap_or(0.0)); // no time at all so far
                        }
                        read
                    }
                }
                .map_err(|error| fault(&self.head.name, &error).at_path(title))?;
                if let Some(text) = no_number {
                    return Err(Malformed::new(
                        Fault::Value,
                        format!("a cell of the column '{title}' is not a number"),
                    )
                    .expected("a number")
                    .found(format!("'{text}'"))
                    .in_file(&self.head.name));
                }
            }
            let rows = block.rows();
            if block.columns.iter().any(|column| column.len() != rows) {
                return Err(Malformed::new(Fault::Value, "columns have different numbers of values")
                    .expected("flat columns, without lists")
                    .in_file(&self.head.name));
            }
            if rows > 0 {
                return Ok(true);
            }
            self.open.clear();
        }
    }
}

/// What the values of a column are whose type is not read.
fn values_of(column: &ColumnDescriptor) -> String {
    let name = match column.logical_type_ref() {
        _ if column.max_rep_level() > 0 => "LIST or MAP (several values in a row)".into(),
        Some(logical) => format!("{logical:?}"),
        None => column.converted_type().to_string(),
    };
    format!("values of the type {name}")
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
        .expected("a whole file, uncompressed or compressed by snappy, gzip, brotli, lz4 or zstd")
        .found(error.to_string())
        .in_file(name)
}

/// Its reader panicked.
fn damaged(name: &str) -> Malformed {
    fault(name, &ParquetError::General("its structure is damaged".into()))
}

type Read = std::result::Result<(), ParquetError>;

/// The next values of a column in their rows; rows without one are NaN.
fn rows<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    to: &mut Vec<f64>,
    mut number: impl FnMut(&T::T) -> f64,
) -> Read {
    let (mut levels, mut values) = (Vec::new(), Vec::new());
    reader.read_records(ROWS, Some(&mut levels), None, &mut values)?;
    if values.len() == levels.len() || levels.is_empty() {
        to.extend(values.iter().map(number));
        return Ok(());
    }
    let (highest, mut values) = (levels.iter().copied().max().unwrap_or(0).max(1), values.iter());
    to.extend(
        levels.iter().map(|l| if *l == highest { values.next().map_or(f64::NAN, &mut number) } else { f64::NAN }),
    );
    Ok(())
}

/// A value as it is stored.
enum Value<'a> {
    /// A whole number, and its bits.
    Whole(i64, u64),
    Real(f64),
    /// Nanoseconds since 1970.
    Nanoseconds(i64),
    Bytes(&'a [u8]),
}

/// The next values of a column as numbers.
fn values(reader: &mut ColumnReader, to: &mut Vec<f64>, mut number: impl FnMut(Value<'_>) -> f64) -> Read {
    match reader {
        ColumnReader::DoubleColumnReader(r) => rows(r, to, |v| number(Value::Real(*v))),
        ColumnReader::FloatColumnReader(r) => rows(r, to, |v| number(Value::Real(f64::from(*v)))),
        ColumnReader::Int32ColumnReader(r) => {
            rows(r, to, |v| number(Value::Whole(i64::from(*v), u64::from(v.cast_unsigned()))))
        }
        ColumnReader::Int64ColumnReader(r) => rows(r, to, |v| number(Value::Whole(*v, v.cast_unsigned()))),
        ColumnReader::BoolColumnReader(r) => rows(r, to, |v| number(Value::Whole(i64::from(*v), u64::from(*v)))),
        ColumnReader::Int96ColumnReader(r) => rows(r, to, |v| number(Value::Nanoseconds(v.to_nanos()))),
        ColumnReader::ByteArrayColumnReader(r) => rows(r, to, |v| number(Value::Bytes(v.data()))),
        ColumnReader::FixedLenByteArrayColumnReader(r) => rows(r, to, |v| number(Value::Bytes(v.data()))),
    }
}

fn numbers(
    reader: &mut ColumnReader,
    to: &mut Vec<f64>,
    meaning: Meaning,
    kind: As,
    times: &mut Times,
    no_number: &mut Option<String>,
) -> Read {
    values(reader, to, |value| match value {
        Value::Whole(value, bits) => meaning.whole(value, bits),
        Value::Real(value) => value,
        Value::Nanoseconds(value) => value as f64 / 1e9,
        Value::Bytes(data) => {
            let text = || std::str::from_utf8(data).unwrap_or_default().trim();
            let written = || match kind {
                As::Time => super::number::number(data, b'.').or_else(|| times.seconds(data)),
                _ => super::number::number(data, b'.'),
            };
            meaning.bytes(data).or_else(written).unwrap_or_else(|| {
                // what is no number is a fault, but in a cell
                if kind != As::Cell {
                    no_number.get_or_insert_with(|| text().chars().take(40).collect());
                }
                UNREADABLE
            })
        }
    })
}

fn labels(reader: &mut ColumnReader, to: &mut Vec<f64>, meaning: Meaning, labels: &mut Labels) -> Read {
    // a value that repeats is written once
    let mut last: Option<(u64, f64)> = None;
    let mut label = |key: u64, text: &dyn Fn() -> String, labels: &mut Labels| match last {
        Some((known, number)) if known == key => number,
        _ => {
            let number = labels.number(text().as_bytes());
            last = Some((key, number));
            number
        }
    };
    values(reader, to, |value| match value {
        Value::Whole(value, bits) => label(bits, &|| meaning.text(value, bits), labels),
        Value::Real(value) => label(value.to_bits(), &|| value.to_string(), labels),
        Value::Nanoseconds(value) => label(value.cast_unsigned(), &|| meaning.text(value, 0), labels),
        Value::Bytes(data) => match meaning.bytes_text(data) {
            Some(text) => labels.number(text.as_bytes()),
            None => labels.number(data),
        },
    })
}
