//! Results as people and programs read them: a table, CSV, Parquet, JSON lines. Answers are written as one column for each of their fields.

use crate::error::{Error, Result};
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use datafusion::arrow::array::{Array, ArrayRef, AsArray, RecordBatch};
use datafusion::arrow::csv::WriterBuilder;
use datafusion::arrow::datatypes::{DataType, Field, Float64Type, Schema, SchemaRef};
use datafusion::arrow::json::LineDelimitedWriter;
use datafusion::arrow::util::display::array_value_to_string;
use datafusion::parquet::arrow::ArrowWriter;
use datafusion::parquet::basic::Compression;
use datafusion::parquet::file::properties::WriterProperties;
use std::io::Write;
use std::sync::Arc;

/// How results are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Comma-separated values with a header.
    Csv,
    /// One JSON object a line.
    JsonLines,
    /// Parquet.
    Parquet,
}

impl Format {
    /// By the extension of a name.
    ///
    /// # Errors
    ///
    /// An extension that is none of them.
    pub fn of(name: &str) -> Result<Self> {
        match name.to_ascii_lowercase().rsplit_once('.').map_or("", |(_, extension)| extension) {
            "csv" | "txt" => Ok(Format::Csv),
            "jsonl" | "ndjson" => Ok(Format::JsonLines),
            "parquet" | "pq" => Ok(Format::Parquet),
            found => Err(Error::Question(format!(
                "rows cannot be written as '.{found}'; expected: a name that ends in .csv, .jsonl (or .ndjson) or .parquet; found: {name}"
            ))),
        }
    }
}

/// Every field of a struct as a column of its own: by its name, or where two would be alike by `column.name`.
///
/// # Errors
///
/// Those of Arrow.
pub fn flat(batches: &[RecordBatch], schema: &SchemaRef) -> Result<(SchemaRef, Vec<RecordBatch>)> {
    // f[K1] is called K1
    let plain = |name: &str| -> String {
        let inner = name.strip_suffix(']').and_then(|name| name.split_once('['));
        inner.map_or(name, |(_, inner)| inner).to_string()
    };
    let names = |field: &Field| -> Vec<String> {
        match field.data_type() {
            DataType::Struct(fields) => fields.iter().map(|own| own.name().clone()).collect(),
            _ => vec![plain(field.name())],
        }
    };
    let all: Vec<String> = schema.fields().iter().flat_map(|field| names(field)).collect();
    let once = |name: &str| all.iter().filter(|own| *own == name).count() == 1;
    let mut fields = Vec::new();
    for field in schema.fields() {
        match field.data_type() {
            DataType::Struct(own) => fields.extend(own.iter().map(|inner| {
                let name = inner.name();
                let name = if once(name) { name.clone() } else { format!("{}.{name}", field.name()) };
                Field::new(name, inner.data_type().clone(), true)
            })),
            _ if once(&plain(field.name())) => fields.push(field.as_ref().clone().with_name(plain(field.name()))),
            _ => fields.push(field.as_ref().clone()),
        }
    }
    let flat = Arc::new(Schema::new(fields));
    let spread = |batch: &RecordBatch| {
        let mut columns: Vec<ArrayRef> = Vec::new();
        for column in batch.columns() {
            match column.as_struct_opt() {
                Some(own) => columns.extend(own.columns().iter().cloned()),
                None => columns.push(Arc::clone(column)),
            }
        }
        RecordBatch::try_new(Arc::clone(&flat), columns).map_err(arrow)
    };
    let batches = batches.iter().map(spread).collect::<Result<Vec<_>>>()?;
    Ok((flat, batches))
}

/// Write flat results.
///
/// # Errors
///
/// What cannot be written.
pub fn write(to: impl Write + Send, format: Format, schema: &SchemaRef, batches: &[RecordBatch]) -> Result<()> {
    match format {
        Format::Csv => {
            let mut writer = WriterBuilder::new().with_header(true).build(to);
            if batches.is_empty() {
                writer.write(&RecordBatch::new_empty(Arc::clone(schema))).map_err(arrow)?;
            }
            batches.iter().try_for_each(|batch| writer.write(batch)).map_err(arrow)
        }
        Format::JsonLines => {
            let mut writer = LineDelimitedWriter::new(to);
            batches.iter().try_for_each(|batch| writer.write(batch)).map_err(arrow)?;
            writer.finish().map_err(arrow)
        }
        Format::Parquet => {
            let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
            let parquet = |error: datafusion::parquet::errors::ParquetError| Error::Question(error.to_string());
            let mut writer = ArrowWriter::try_new(to, Arc::clone(schema), Some(properties)).map_err(parquet)?;
            batches.iter().try_for_each(|batch| writer.write(batch)).map_err(parquet)?;
            writer.close().map(drop).map_err(parquet)
        }
    }
}

/// A table for people: a value that has an uncertainty is rounded to two digits of it; at most `rows` rows. Where the columns do not stand
/// side by side in the terminal, each row is a list.
pub fn table(schema: &SchemaRef, batches: &[RecordBatch], rows: usize) -> String {
    let place = |name: &str| schema.fields().iter().position(|field| field.name() == name);
    let uncertain = |name: &str| place(&format!("{name}_u"));
    let of_another =
        |name: &str| ["_u", "_U"].iter().any(|end| name.strip_suffix(end).is_some_and(|own| place(own).is_some()));
    let shown: Vec<usize> = (0..schema.fields().len())
        .filter(|k| schema.fields().get(*k).is_some_and(|field| !of_another(field.name())))
        .collect();
    let title = |k: &usize| schema.fields().get(*k).map_or(String::new(), |field| field.name().clone());
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(shown.iter().map(title));
    let mut left = rows;
    let mut list = String::new();
    for batch in batches {
        for row in 0..batch.num_rows().min(left) {
            let number = |k: usize| -> Option<f64> {
                let column = batch.columns().get(k)?.as_primitive_opt::<Float64Type>()?;
                column.is_valid(row).then(|| column.value(row))
            };
            let cell = |k: &usize| match (number(*k), uncertain(&title(k)).and_then(number)) {
                (Some(value), Some(u)) => with_uncertainty(value, u),
                (Some(value), None) => format!("{}", significant(value)),
                (None, _) => {
                    batch.columns().get(*k).and_then(|c| array_value_to_string(c, row).ok()).unwrap_or_default()
                }
            };
            let cells: Vec<String> = shown.iter().map(cell).collect();
            let longest = shown.iter().map(|k| title(k).chars().count()).max().unwrap_or_default();
            for (k, cell) in shown.iter().zip(&cells).filter(|(_, cell)| !cell.is_empty()) {
                list.push_str(&format!("{:longest$}  {cell}\n", title(k)));
            }
            list.push('\n');
            table.add_row(cells);
        }
        left = left.saturating_sub(batch.num_rows());
    }
    for (k, own) in shown.iter().enumerate() {
        if let (Some(field), Some(column)) = (schema.fields().get(*own), table.column_mut(k))
            && field.data_type().is_numeric()
        {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    let total: usize = batches.iter().map(RecordBatch::num_rows).sum();
    let more = if total > rows {
        format!("\n{} more rows; --to FILE writes all of them", total - rows)
    } else {
        String::new()
    };
    let width = table.lines().map(|line| line.chars().count()).max().unwrap_or_default();
    match table.width() {
        Some(terminal) if width > usize::from(terminal) => format!("{}{more}", list.trim_end()),
        _ => format!("{table}{more}"),
    }
}

/// `1.2346 ± 0.0012`: two digits of the uncertainty, and as many places of the value.
fn with_uncertainty(value: f64, u: f64) -> String {
    if !(u > 0.0 && u.is_finite()) {
        return format!("{} ± {}", significant(value), significant(u));
    }
    let places = 1 - u.log10().floor() as i32;
    if (0..=9).contains(&places) {
        let places = places as usize;
        return format!("{value:.places$} ± {u:.places$}");
    }
    // in powers of ten of the value
    let exponent = value.abs().max(u).log10().floor() as i32;
    let scale = 10f64.powi(exponent);
    let places = (exponent + places).clamp(0, 17) as usize;
    format!("({:.places$} ± {:.places$})e{exponent}", value / scale, u / scale)
}

/// Four digits are enough for what has no uncertainty.
fn significant(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

fn arrow(error: datafusion::arrow::error::ArrowError) -> Error {
    Error::DataFusion(error.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_have_the_digits_of_their_uncertainty() {
        assert_eq!(with_uncertainty(1.234567, 0.00123), "1.2346 ± 0.0012");
        assert_eq!(with_uncertainty(-7.858e-4, 2.9e-6), "-0.0007858 ± 0.0000029");
        assert_eq!(with_uncertainty(1.5e-12, 2.0e-14), "(1.500 ± 0.020)e-12");
        assert_eq!(with_uncertainty(123456.0, 1234.0), "(1.235 ± 0.012)e5");
        assert_eq!(with_uncertainty(3.0, 0.0), "3 ± 0");
        assert_eq!(significant(0.123456), 0.1235);
    }

    #[test]
    fn extensions_say_the_format() {
        assert_eq!(Format::of("a/b.PARQUET").ok(), Some(Format::Parquet));
        assert!(Format::of("rows.xlsx").is_err_and(|error| error.to_string().contains(".xlsx")));
    }
}
