//! One row a device: as CSV, JSON lines or Parquet, by the extension of the file.

use super::outputs::{Stream, fault, reader_left};
use crate::batch::Row;
use crate::error::{Fault, Malformed, Result};
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
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
    /// Column that tells devices apart.
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
        let suspects: Vec<String> = row.suspects.iter().map(ToString::to_string).collect();
        cells.push(Cell::Text(suspects.join(" ").into()));
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
                let cells: Vec<Vec<Cell<'_>>> = cells.collect();
                return group(writer, &self.columns.titles(), &cells).map_err(|error| fault(&self.path, &error));
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

fn quoted(text: &str, to: &mut Vec<u8>) {
    if text.contains([',', '"', '\n', '\r']) {
        to.push(b'"');
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
        .set_key_value_metadata(Some(units));
    // numbers of devices hardly return, and looking for those that do costs more than all else
    let numbers = columns.titles().into_iter().filter(|(_, kind)| *kind == Kind::Number);
    let properties = numbers
        .fold(properties, |own, (title, _)| own.set_column_dictionary_enabled(ColumnPath::new(vec![title]), false))
        .build();
    SerializedFileWriter::new(stream, Arc::new(schema), Arc::new(properties)).map_err(unwritten)
}

/// A row group.
fn group(
    writer: &mut SerializedFileWriter<Stream>,
    titles: &[(String, Kind)],
    rows: &[Vec<Cell<'_>>],
) -> std::result::Result<(), parquet::errors::ParquetError> {
    let mut group = writer.next_row_group()?;
    for (k, (_, kind)) in titles.iter().enumerate() {
        let Some(mut column) = group.next_column()? else { break };
        let cells = || rows.iter().filter_map(|row| row.get(k));
        match kind {
            Kind::Text => {
                // most texts are those of the row before
                let mut texts: Vec<ByteArray> = Vec::with_capacity(rows.len());
                for cell in cells() {
                    let text = if let Cell::Text(text) = cell { text.as_bytes() } else { b"" };
                    let same = texts.last().filter(|last| last.data() == text).cloned();
                    texts.push(same.unwrap_or_else(|| ByteArray::from(text.to_vec())));
                }
                column.typed::<ByteArrayType>().write_batch(&texts, None, None)?;
            }
            Kind::Number => {
                let value = |cell: &Cell<'_>| if let Cell::Number(x) = cell { *x } else { f64::NAN };
                let levels: Vec<i16> = cells().map(|cell| i16::from(!value(cell).is_nan())).collect();
                let numbers: Vec<f64> = cells().map(value).filter(|x| !x.is_nan()).collect();
                column.typed::<DoubleType>().write_batch(&numbers, Some(&levels), None)?;
            }
            Kind::Count => {
                let count = |cell: &Cell<'_>| if let Cell::Count(n) = cell { *n as i64 } else { 0 };
                let counts: Vec<i64> = cells().map(count).collect();
                column.typed::<Int64Type>().write_batch(&counts, None, None)?;
            }
        }
        column.close()?;
    }
    group.close()?;
    Ok(())
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

/// One row a device: how many effects, and the regressors, values, u, probabilities and aliases of all of them, parted by semicolons.
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
