//! One row a device: as CSV, JSON lines or Parquet, by the extension of the file.

use super::outputs::{Stream, fault, reader_left};
use crate::batch::Row;
use crate::elements::{Elements, Parts};
use crate::error::{Fault, Malformed, Result};
use crate::report::series::WRITER;
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{ColumnPath, Type};
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

/// A cell of a row.
pub(super) enum Cell<'a> {
    Text(std::borrow::Cow<'a, str>),
    Number(f64),
    Count(usize),
}

/// What the rows have, in order.
#[derive(Debug, Clone)]
pub(super) struct Columns {
    /// Column that identifies the device.
    pub by: String,
    /// Column of dates or lots.
    pub lot: Option<String>,
    /// Estimated parameters and derived quantities with their units.
    pub quantities: Vec<(String, String)>,
    /// Has the campaign limits?
    pub limited: bool,
}

/// What kind of cells a column has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Text,
    Number,
    Count,
}

impl Columns {
    fn titles(&self) -> Vec<(String, Kind)> {
        let mut titles = vec![(self.by.clone(), Kind::Text)];
        titles.extend(self.lot.iter().map(|lot| (lot.clone(), Kind::Text)));
        titles.push(("verdict".into(), Kind::Text));
        if self.limited {
            titles.push(("conformity".into(), Kind::Text));
        }
        for (id, _) in &self.quantities {
            titles.extend(["", "_u", "_U"].map(|end| (format!("{id}{end}"), Kind::Number)));
        }
        titles.extend(["readings", "rank", "dof"].map(|name| (name.to_string(), Kind::Count)));
        let tests = ["residual_sd", "chi_square_p", "lack_of_fit_p", "runs_p", "normality_p"];
        titles.extend(tests.map(|name| (name.to_string(), Kind::Number)));
        titles.extend(["suspects", "schedule", "why"].map(|name| (name.to_string(), Kind::Text)));
        titles
    }

    /// Cells of a row, in the order of the titles.
    fn cells<'a>(&self, row: &'a Row) -> Vec<Cell<'a>> {
        let mut cells = Vec::with_capacity(12 + 3 * self.quantities.len());
        cells.push(Cell::Text(row.label.as_str().into()));
        if self.lot.is_some() {
            cells.push(Cell::Text(row.lot.as_str().into()));
        }
        cells.push(Cell::Text(row.verdict.name().into()));
        if self.limited {
            cells.push(Cell::Text(row.conformity.map_or("", |own| own.name()).into()));
        }
        for ((value, u), expanded) in row.value.iter().zip(&row.u).zip(&row.expanded) {
            cells.extend([Cell::Number(*value), Cell::Number(*u), Cell::Number(*expanded)]);
        }
        cells.extend([Cell::Count(row.readings), Cell::Count(row.rank), Cell::Count(row.dof)]);
        let tests = [row.residual_sd, row.chi_square_p, row.lack_of_fit_p, row.runs_p, row.normality_p];
        cells.extend(tests.map(Cell::Number));
        cells.push(Cell::Text(suspects(row)));
        cells.push(Cell::Text(row.solved.name().into()));
        cells.push(Cell::Text(row.why.as_str().into()));
        cells
    }
}

/// Rows on their way out.
pub(super) struct Rows {
    path: PathBuf,
    columns: Columns,
    to: To,
}

enum To {
    Csv(Vec<u8>, Stream),
    JsonLines(Vec<u8>, Stream),
    Parquet(Box<SerializedFileWriter<Stream>>),
}

impl Rows {
    pub(super) fn begin(path: &Path, stream: Stream, columns: Columns) -> Result<Self> {
        let to = match Format::of(path)? {
            Format::Csv => {
                let mut text = Vec::new();
                for (k, (title, _)) in columns.titles().iter().enumerate() {
                    if k > 0 {
                        text.push(b',');
                    }
                    quoted(title, &mut text);
                }
                text.push(b'\n');
                To::Csv(text, stream)
            }
            Format::JsonLines => To::JsonLines(Vec::new(), stream),
            Format::Parquet => To::Parquet(Box::new(parquet(path, stream, &columns)?)),
        };
        Ok(Rows { path: path.to_path_buf(), columns, to })
    }

    /// Write some rows.
    pub(super) fn write(&mut self, rows: &[Row]) -> Result<()> {
        let cells = rows.iter().map(|row| self.columns.cells(row));
        let written = match &mut self.to {
            To::Csv(text, stream) => {
                cells.for_each(|cells| csv_line(&cells, text));
                let written = stream.write_all(text);
                text.clear();
                written
            }
            To::JsonLines(text, stream) => {
                let titles = self.columns.titles();
                cells.for_each(|cells| json_line(&titles, &cells, text));
                let written = stream.write_all(text);
                text.clear();
                written
            }
            To::Parquet(writer) => {
                return group(writer, &self.columns, rows).map_err(|error| fault(&self.path, &error));
            }
        };
        written.or_else(reader_left).map_err(|error| fault(&self.path, &error))
    }

    /// The file, whole.
    pub(super) fn finish(self) -> Result<Stream> {
        let unwritten = |error: std::io::Error| fault(&self.path, &error);
        match self.to {
            To::Csv(text, mut stream) | To::JsonLines(text, mut stream) => {
                stream.write_all(&text).and_then(|()| stream.flush()).or_else(reader_left).map_err(unwritten)?;
                Ok(stream)
            }
            To::Parquet(writer) => writer.into_inner().map_err(|error| fault(&self.path, &error)),
        }
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

fn csv_line(cells: &[Cell<'_>], to: &mut Vec<u8>) {
    for (k, cell) in cells.iter().enumerate() {
        if k > 0 {
            to.push(b',');
        }
        match cell {
            Cell::Text(text) => quoted(text, to),
            Cell::Number(x) if x.is_nan() => {}
            Cell::Number(x) => number(*x, to),
            // writing to memory does not fail
            Cell::Count(n) => drop(write!(to, "{n}")),
        }
    }
    to.push(b'\n');
}

/// The shortest text that is read back as this number.
fn number(x: f64, to: &mut Vec<u8>) {
    let size = x.abs();
    let written = if size != 0.0 && !(1e-5..1e16).contains(&size) { write!(to, "{x:e}") } else { write!(to, "{x}") };
    drop(written);
}

fn json_line(titles: &[(String, Kind)], cells: &[Cell<'_>], to: &mut Vec<u8>) {
    for (k, ((title, _), cell)) in titles.iter().zip(cells).enumerate() {
        to.push(if k == 0 { b'{' } else { b',' });
        // writing to memory does not fail
        drop(serde_json::to_writer(&mut *to, title));
        to.push(b':');
        match cell {
            Cell::Text(text) => drop(serde_json::to_writer(&mut *to, text.as_ref())),
            Cell::Number(x) if !x.is_finite() => to.extend_from_slice(b"null"),
            Cell::Number(x) => number(*x, to),
            Cell::Count(n) => drop(write!(to, "{n}")),
        }
    }
    to.extend_from_slice(b"}\n");
}

fn parquet(path: &Path, stream: Stream, columns: &Columns) -> Result<SerializedFileWriter<Stream>> {
    let unwritten = |error: parquet::errors::ParquetError| fault(path, &error);
    let field = |(title, kind): (String, Kind)| {
        let builder = match kind {
            Kind::Text => Type::primitive_type_builder(&title, Physical::BYTE_ARRAY)
                .with_logical_type(Some(LogicalType::String))
                .with_repetition(Repetition::REQUIRED),
            Kind::Number => {
                Type::primitive_type_builder(&title, Physical::DOUBLE).with_repetition(Repetition::OPTIONAL)
            }
            Kind::Count => Type::primitive_type_builder(&title, Physical::INT64).with_repetition(Repetition::REQUIRED),
        };
        builder.build().map(Arc::new)
    };
    let fields = columns.titles().into_iter().map(field).collect::<std::result::Result<_, _>>().map_err(unwritten)?;
    let schema = Type::group_type_builder("devices").with_fields(fields).build().map_err(unwritten)?;
    let units = columns.quantities.iter().filter(|(_, unit)| !unit.is_empty());
    let units = units.map(|(id, unit)| KeyValue::new(format!("unit:{id}"), unit.clone())).collect();
    let properties = WriterProperties::builder()
        .set_compression(parquet::basic::Compression::SNAPPY)
        .set_key_value_metadata(Some(units))
        .set_created_by(format!("{WRITER}{}", crate::report::VERSION));
    // numbers and names of devices hardly return, and looking for those that do costs more than all else; nor is anything found by the least
    // and the largest of texts but of the devices' own
    let properties = columns
        .titles()
        .into_iter()
        .enumerate()
        .fold(properties, |own, (k, (title, kind))| {
            let path = ColumnPath::new(vec![title]);
            match kind {
                Kind::Text if k > 0 => own.set_column_statistics_enabled(path, EnabledStatistics::None),
                Kind::Text | Kind::Number => own.set_column_dictionary_enabled(path, false),
                Kind::Count => own,
            }
        })
        .build();
    SerializedFileWriter::new(stream, Arc::new(schema), Arc::new(properties)).map_err(unwritten)
}

/// A row group, column by column from the rows as they are.
fn group(
    writer: &mut SerializedFileWriter<Stream>,
    columns: &Columns,
    rows: &[Row],
) -> std::result::Result<(), parquet::errors::ParquetError> {
    let mut group = Group { group: writer.next_row_group()?, rows, numbers: Vec::new(), levels: Vec::new() };
    group.texts(|row| row.label.as_str().into())?;
    if columns.lot.is_some() {
        group.texts(|row| row.lot.as_str().into())?;
    }
    group.texts(|row| row.verdict.name().into())?;
    if columns.limited {
        group.texts(|row| row.conformity.map_or("", |own| own.name()).into())?;
    }
    for k in 0..columns.quantities.len() {
        let at = |list: &[f64]| list.at(k);
        group.numbers(|row| at(&row.value))?;
        group.numbers(|row| at(&row.u))?;
        group.numbers(|row| at(&row.expanded))?;
    }
    group.counts(|row| row.readings)?;
    group.counts(|row| row.rank)?;
    group.counts(|row| row.dof)?;
    group.numbers(|row| row.residual_sd)?;
    group.numbers(|row| row.chi_square_p)?;
    group.numbers(|row| row.lack_of_fit_p)?;
    group.numbers(|row| row.runs_p)?;
    group.numbers(|row| row.normality_p)?;
    group.texts(suspects)?;
    group.texts(|row| row.solved.name().into())?;
    group.texts(|row| row.why.as_str().into())?;
    group.group.close()?;
    Ok(())
}

/// Suspicious readings as a text.
fn suspects(row: &Row) -> std::borrow::Cow<'_, str> {
    match row.suspects.as_slice() {
        [] => "".into(),
        several => several.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ").into(),
    }
}

/// A row group on its way, in the order of the titles.
struct Group<'a> {
    group: SerializedRowGroupWriter<'a, Stream>,
    rows: &'a [Row],
    numbers: Vec<f64>,
    levels: Vec<i16>,
}

type Written = std::result::Result<(), parquet::errors::ParquetError>;

impl<'a> Group<'a> {
    fn texts(&mut self, of: impl Fn(&'a Row) -> std::borrow::Cow<'a, str>) -> Written {
        let Some(mut column) = self.group.next_column()? else { return Ok(()) };
        // all texts in one piece of memory; most are those of the row before
        let (mut all, mut places) = (Vec::new(), Vec::with_capacity(self.rows.len()));
        let mut last = (0, 0);
        for row in self.rows {
            let text = of(row);
            let before = all.part(last.0..last.0 + last.1);
            if places.is_empty() || before != text.as_bytes() {
                last = (all.len(), text.len());
                all.extend_from_slice(text.as_bytes());
            }
            places.push(last);
        }
        let all = ByteArray::from(all);
        let texts: Vec<ByteArray> = places.into_iter().map(|(start, length)| all.slice(start, length)).collect();
        column.typed::<ByteArrayType>().write_batch(&texts, None, None)?;
        column.close()
    }

    fn numbers(&mut self, of: impl Fn(&Row) -> f64) -> Written {
        let Some(mut column) = self.group.next_column()? else { return Ok(()) };
        self.levels.clear();
        self.numbers.clear();
        for x in self.rows.iter().map(of) {
            self.levels.push(i16::from(!x.is_nan()));
            if !x.is_nan() {
                self.numbers.push(x);
            }
        }
        column.typed::<DoubleType>().write_batch(&self.numbers, Some(&self.levels), None)?;
        column.close()
    }

    fn counts(&mut self, of: impl Fn(&Row) -> usize) -> Written {
        let Some(mut column) = self.group.next_column()? else { return Ok(()) };
        let counts: Vec<i64> = self.rows.iter().map(|row| of(row) as i64).collect();
        column.typed::<Int64Type>().write_batch(&counts, None, None)?;
        column.close()
    }
}

/// What a diagnosis found in one device.
pub(super) struct DiagnosedRow {
    pub label: String,
    pub verdict: String,
    pub effects: Vec<EffectColumn>,
    pub why: String,
}

/// An effect of a device.
pub(super) struct EffectColumn {
    pub regressor: String,
    pub name: String,
    pub value: Option<f64>,
    pub u: Option<f64>,
    pub unit: String,
    pub p: f64,
    pub aliases: Vec<String>,
}

/// One row for each device: how many effects, and the regressors, values, u, probabilities and aliases of all of them, parted by semicolons.
pub(super) fn diagnosed(by: &str, rows: &[DiagnosedRow], format: Format) -> Vec<u8> {
    let names = ["verdict", "effects", "regressors", "names", "values", "u", "units", "p", "aliases", "why"];
    let kind = |name: &str| if name == "effects" { Kind::Count } else { Kind::Text };
    let mut titles = vec![(by.to_string(), Kind::Text)];
    titles.extend(names.map(|name| (name.to_string(), kind(name))));
    let mut text = Vec::new();
    if format == Format::Csv {
        let header: Vec<Cell<'_>> = titles.iter().map(|(title, _)| Cell::Text(title.as_str().into())).collect();
        csv_line(&header, &mut text);
    }
    for row in rows {
        let all = |of: &dyn Fn(&EffectColumn) -> String| -> Cell<'static> {
            Cell::Text(row.effects.iter().map(of).collect::<Vec<_>>().join("; ").into())
        };
        let optional = |x: Option<f64>| {
            let mut text = Vec::new();
            x.into_iter().for_each(|x| number(x, &mut text));
            // written just above, in ASCII
            String::from_utf8(text).unwrap_or_default()
        };
        let cells = [
            Cell::Text(row.label.as_str().into()),
            Cell::Text(row.verdict.as_str().into()),
            Cell::Count(row.effects.len()),
            all(&|own| own.regressor.clone()),
            all(&|own| own.name.clone()),
            all(&|own| optional(own.value)),
            all(&|own| optional(own.u)),
            all(&|own| own.unit.clone()),
            all(&|own| optional(Some(own.p))),
            all(&|own| own.aliases.join(" or ")),
            Cell::Text(row.why.as_str().into()),
        ];
        match format {
            Format::JsonLines => json_line(&titles, &cells, &mut text),
            _ => csv_line(&cells, &mut text),
        }
    }
    text
}
