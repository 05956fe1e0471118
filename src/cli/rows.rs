//! Tables that go out: rows of cells as CSV, JSON lines or Parquet, by the extension of the file.

use super::outputs::{Stream, fault};
use super::session::reader_left;
use super::written::WRITER;
use crate::error::{Fault, Malformed, Result};
use crate::record::Cells;
use crate::report::VERSION;
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties, WriterPropertiesBuilder};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{ColumnPath, Type};
use std::borrow::Cow;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// How rows are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Csv,
    JsonLines,
    Parquet,
}

impl Format {
    /// By the extension of the file; CSV for a name that has none that is known.
    pub(super) fn of(path: &Path) -> Result<Self> {
        let name = path.to_string_lossy().to_ascii_lowercase();
        match name.rsplit_once('.').map_or("", |(_, extension)| extension) {
            "csv" | "txt" => Ok(Format::Csv),
            "jsonl" | "ndjson" => Ok(Format::JsonLines),
            "parquet" | "pq" => Ok(Format::Parquet),
            _ if matches!(name.as_str(), "-" | "/dev/stdout" | "/dev/null") => Ok(Format::Csv),
            found => Err(Malformed::new(Fault::Value, format!("rows cannot be written as '.{found}'"))
                .expected("a name that ends in .csv, .jsonl (or .ndjson) or .parquet")
                .found(name.clone())),
        }
    }
}

/// What the cells of a column are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Text,
    Number,
    /// A number that text has with its exponent, by which the program knows a table of its own (`written.rs`).
    Exponent,
    Count,
}

pub(super) type Titles = Vec<(String, Kind)>;

/// A cell; a number that is none is an empty one.
#[derive(Debug, Clone)]
pub(super) enum Cell<'a> {
    Text(Cow<'a, str>),
    Number(f64),
    Count(usize),
}

pub(super) struct Rows {
    path: PathBuf,
    titles: Titles,
    to: To,
}

enum To {
    Text(Stream, fn(&Titles, &[Cell<'_>], &mut Vec<u8>)),
    Parquet(Box<Columnar<Stream>>),
}

impl Rows {
    /// `units` of columns go into a file that has a place for them.
    pub(super) fn begin(
        path: &Path,
        format: Format,
        stream: Stream,
        titles: Titles,
        units: &[(String, String)],
    ) -> Result<Self> {
        let to = match format {
            Format::Csv => To::Text(stream, csv_line),
            Format::JsonLines => To::Text(stream, json_line),
            Format::Parquet => {
                To::Parquet(Box::new(columnar(stream, &titles, units).map_err(|error| fault(path, &error))?))
            }
        };
        let header: Vec<Cell<'_>> = titles.iter().map(|(title, _)| Cell::Text(title.clone().into())).collect();
        let mut rows = Rows { path: path.to_path_buf(), titles, to };
        if format == Format::Csv {
            rows.write(&[header])?;
        }
        Ok(rows)
    }

    pub(super) fn write(&mut self, rows: &[Vec<Cell<'_>>]) -> Result<()> {
        let written = match &mut self.to {
            To::Text(stream, line) => {
                let mut text = Vec::new();
                rows.iter().for_each(|cells| line(&self.titles, cells, &mut text));
                stream.write_all(&text).or_else(reader_left)
            }
            To::Parquet(file) => {
                let columns = self.titles.iter().enumerate().map(|(k, (_, kind))| column(*kind, rows, k));
                file.group(columns).map_err(std::io::Error::other)
            }
        };
        written.map_err(|error| fault(&self.path, &error))
    }

    pub(super) fn finish(self) -> Result<Stream> {
        let whole = match self.to {
            To::Text(mut stream, _) => stream.flush().or_else(reader_left).map(|()| stream),
            To::Parquet(file) => file.finish().map_err(std::io::Error::other),
        };
        whole.map_err(|error| fault(&self.path, &error))
    }
}

/// A text as a cell. What a spreadsheet would take for a formula gets a leading apostrophe, so that it is shown as text.
fn quoted(text: &str, to: &mut Vec<u8>) {
    let formula = text.starts_with(['=', '+', '-', '@', '\t']) && text.parse::<f64>().is_err();
    if formula || text.contains([',', '"', '\n', '\r']) {
        to.push(b'"');
        to.extend(formula.then_some(b'\''));
        to.extend_from_slice(text.replace('"', "\"\"").as_bytes());
        to.push(b'"');
    } else {
        to.extend_from_slice(text.as_bytes());
    }
}

// writing to memory does not fail
fn csv_line(titles: &Titles, cells: &[Cell<'_>], to: &mut Vec<u8>) {
    for (k, cell) in cells.iter().enumerate() {
        to.extend((k > 0).then_some(b','));
        match cell {
            Cell::Text(text) => quoted(text, to),
            Cell::Number(x) if x.is_nan() => {}
            Cell::Number(x) if titles.get(k).is_some_and(|(_, kind)| *kind == Kind::Exponent) => {
                drop(write!(to, "{x:e}"));
            }
            Cell::Number(x) => drop(write!(to, "{}", Shortest(*x))),
            Cell::Count(n) => drop(write!(to, "{n}")),
        }
    }
    to.push(b'\n');
}

fn json_line(titles: &Titles, cells: &[Cell<'_>], to: &mut Vec<u8>) {
    for (k, ((title, _), cell)) in titles.iter().zip(cells).enumerate() {
        to.push(if k == 0 { b'{' } else { b',' });
        drop(serde_json::to_writer(&mut *to, title));
        to.push(b':');
        match cell {
            Cell::Text(text) => drop(serde_json::to_writer(&mut *to, text.as_ref())),
            Cell::Number(x) if !x.is_finite() => to.extend_from_slice(b"null"),
            Cell::Number(x) => drop(write!(to, "{}", Shortest(*x))),
            Cell::Count(n) => drop(write!(to, "{n}")),
        }
    }
    to.extend_from_slice(b"}\n");
}

/// The shortest text that is read back as this number.
pub(super) struct Shortest(pub f64);

impl std::fmt::Display for Shortest {
    fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (x, size) = (self.0, self.0.abs());
        if size != 0.0 && !(1e-5..1e16).contains(&size) { write!(to, "{x:e}") } else { write!(to, "{x}") }
    }
}

pub(super) struct Columnar<W: Write + Send>(SerializedFileWriter<W>);

/// Title, cells, whether some are missing, and what whole numbers say, where that is more than a count.
pub(super) type Field = (String, Kind, Repetition, Option<LogicalType>);

/// The cells of a column in a group of rows.
pub(super) enum Column {
    Texts(Vec<ByteArray>),
    Numbers(Vec<f64>),
    Counts(Vec<i64>),
}

/// The same, with a level for each row, 0 where it has none, for a column that may miss some.
pub(super) type Levelled = (Column, Option<Vec<i16>>);

impl<W: Write + Send> Columnar<W> {
    pub(super) fn begin(
        to: W,
        name: &str,
        fields: impl IntoIterator<Item = Field>,
        properties: WriterPropertiesBuilder,
    ) -> std::result::Result<Self, ParquetError> {
        let field = |(title, kind, repetition, logical): Field| {
            let (physical, logical) = match kind {
                Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
                Kind::Number | Kind::Exponent => (Physical::DOUBLE, None),
                Kind::Count => (Physical::INT64, logical),
            };
            let builder = Type::primitive_type_builder(&title, physical).with_logical_type(logical);
            builder.with_repetition(repetition).build().map(Arc::new)
        };
        let fields = fields.into_iter().map(field).collect::<std::result::Result<_, _>>()?;
        let schema = Type::group_type_builder(name).with_fields(fields).build()?;
        let properties = properties.set_created_by(format!("{WRITER}{VERSION}")).build();
        SerializedFileWriter::new(to, Arc::new(schema), Arc::new(properties)).map(Columnar)
    }

    /// One more group of rows, in the order of the fields.
    pub(super) fn group(
        &mut self,
        columns: impl IntoIterator<Item = Levelled>,
    ) -> std::result::Result<(), ParquetError> {
        let mut group = self.0.next_row_group()?;
        for (column, levels) in columns {
            let (Some(mut to), levels) = (group.next_column()?, levels.as_deref()) else { break };
            match column {
                Column::Texts(cells) => to.typed::<ByteArrayType>().write_batch(&cells, levels, None)?,
                Column::Numbers(cells) => to.typed::<DoubleType>().write_batch(&cells, levels, None)?,
                Column::Counts(cells) => to.typed::<Int64Type>().write_batch(&cells, levels, None)?,
            };
            to.close()?;
        }
        group.close().map(drop)
    }

    pub(super) fn finish(self) -> std::result::Result<W, ParquetError> {
        self.0.into_inner()
    }
}

/// Numbers of which those that are none are missing.
pub(super) fn numbers(all: impl Iterator<Item = f64>) -> Levelled {
    let (mut cells, mut levels) = (Vec::new(), Vec::new());
    for x in all {
        levels.push(i16::from(!x.is_nan()));
        cells.extend((!x.is_nan()).then_some(x));
    }
    (Column::Numbers(cells), Some(levels))
}

fn column(kind: Kind, rows: &[Vec<Cell<'_>>], k: usize) -> Levelled {
    let cells = rows.iter().filter_map(|row| row.get(k));
    match kind {
        Kind::Number | Kind::Exponent => {
            numbers(cells.map(|cell| if let Cell::Number(x) = cell { *x } else { f64::NAN }))
        }
        Kind::Count => {
            let counts = cells.map(|cell| if let Cell::Count(n) = cell { *n as i64 } else { 0 });
            (Column::Counts(counts.collect()), None)
        }
        Kind::Text => {
            let mut texts: Vec<ByteArray> = Vec::with_capacity(rows.len());
            for cell in cells {
                let text = if let Cell::Text(text) = cell { text.as_ref() } else { "" };
                // most are those of the row before
                let before = texts.last().filter(|last| last.data() == text.as_bytes()).cloned();
                texts.push(before.unwrap_or_else(|| ByteArray::from(text)));
            }
            (Column::Texts(texts), None)
        }
    }
}

/// A table in memory as a Parquet file: numbers as doubles, texts as texts; what is absent has no value.
///
/// Errors: a place that cannot be written to, columns of different lengths.
pub fn write_table(columns: &[(String, Cells)], path: &Path) -> Result<()> {
    let field = |(title, cells): &(String, Cells)| {
        let kind = if matches!(cells, Cells::Texts(_)) { Kind::Text } else { Kind::Number };
        (title.clone(), kind, Repetition::OPTIONAL, None)
    };
    let levelled = |(_, cells): &(String, Cells)| match cells {
        Cells::Numbers(own) => numbers(own.iter().copied()),
        Cells::Texts(own) => {
            // blanks alone are an empty cell, as where the table is read in memory
            let is_there = |text: &&String| !text.trim().is_empty();
            let levels = own.iter().map(|text| i16::from(is_there(&text))).collect();
            (Column::Texts(own.iter().filter(is_there).map(|text| text.as_str().into()).collect()), Some(levels))
        }
    };
    let write = || {
        let file = std::fs::File::create(path)?;
        let mut file = Columnar::begin(file, "table", columns.iter().map(field), WriterProperties::builder())?;
        file.group(columns.iter().map(levelled))?;
        file.finish()
    };
    write().map(drop).map_err(|error| fault(path, &error))
}

fn columnar(
    stream: Stream,
    titles: &Titles,
    units: &[(String, String)],
) -> std::result::Result<Columnar<Stream>, ParquetError> {
    let units = units.iter().filter(|(_, unit)| !unit.is_empty());
    let units = units.map(|(id, unit)| KeyValue::new(format!("unit:{id}"), unit.clone())).collect();
    let mut properties = WriterProperties::builder()
        .set_compression(parquet::basic::Compression::SNAPPY)
        .set_key_value_metadata(Some(units));
    // numbers and names of devices (or motions) hardly return, and looking for those that do costs more than all else; nor is anything found by the least
    // and the largest of texts but of the devices' own
    for (k, (title, kind)) in titles.iter().enumerate() {
        let path = ColumnPath::new(vec![title.clone()]);
        properties = match kind {
            Kind::Text if k > 0 => properties.set_column_statistics_enabled(path, EnabledStatistics::None),
            Kind::Text | Kind::Number | Kind::Exponent => properties.set_column_dictionary_enabled(path, false),
            Kind::Count => properties,
        };
    }
    let field = |(title, kind): &(String, Kind)| {
        let may_miss = matches!(kind, Kind::Number | Kind::Exponent);
        let repetition = if may_miss { Repetition::OPTIONAL } else { Repetition::REQUIRED };
        (title.clone(), *kind, repetition, None)
    };
    Columnar::begin(stream, "rows", titles.iter().map(field), properties)
}
