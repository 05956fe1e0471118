//! A table of text, corrected row by row: the cells that stay are copied as they stand.

use super::{Correction, Counts, plan, titles};
use crate::error::{Fault, Malformed, Result};
use crate::number;
use crate::record::Column;
use std::borrow::Cow;
use std::io::{Read, Write};

/// Is this the beginning of CSV with commas between its cells and UTF-8 in its first line, as far as that shows?
pub(super) fn is_plain(beginning: &[u8]) -> bool {
    // remarks and blank lines stand before the titles
    let first = beginning.split(|b| *b == b'\n').find(|line| {
        let line = line.trim_ascii_start();
        !line.is_empty() && !line.starts_with(b"#")
    });
    let text = std::str::from_utf8(first.unwrap_or_default());
    text.is_ok_and(|text| !text.contains([';', '\t', '\u{feff}', '\0'])) && !beginning.starts_with(&[0x1f, 0x8b])
}

/// Rows on their way out; the titles go before the first of them, or before the end, so that a fault in the first row finds nothing written.
pub(super) struct Table<W: Write> {
    titles: Option<Vec<String>>,
    writer: csv::Writer<std::io::BufWriter<W>>,
}

impl<W: Write> Table<W> {
    pub(super) fn new(titles: Vec<String>, output: W) -> Self {
        let writer = csv::Writer::from_writer(std::io::BufWriter::with_capacity(1 << 16, output));
        Table { titles: Some(titles), writer }
    }

    pub(super) fn row(&mut self, cells: impl Iterator<Item = impl AsRef<[u8]>>) -> Result<()> {
        self.begin()?;
        self.writer.write_record(cells).map_err(|e| unwritten(&e))
    }

    pub(super) fn finish(mut self) -> Result<()> {
        self.begin()?;
        self.writer.flush().map_err(|e| unwritten(&e))
    }

    fn begin(&mut self) -> Result<()> {
        self.titles.take().map_or(Ok(()), |titles| self.writer.write_record(&titles).map_err(|e| unwritten(&e)))
    }
}

pub(super) fn correct(
    correction: &Correction<'_>,
    input: impl Read,
    counts: &mut Counts,
    output: impl Write,
) -> Result<()> {
    let name = correction.arguments.log.display().to_string();
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(input);
    let fault = |error: csv::Error| {
        let line = error.position().map_or(0, |p| number::index(p.line()));
        Malformed::new(Fault::Syntax, format!("the record cannot be read: {error}"))
            .expected("CSV with one header line and as many cells in every row, or a Parquet file")
            .at_line(line, 1)
            .in_file(&name)
    };
    let header: Vec<String> = reader.headers().map_err(fault)?.iter().map(str::to_string).collect();
    let titled: Vec<Column> = header.iter().map(|text| Column::titled(text)).collect();
    let plan = plan(correction.arguments, correction.calibration, &titled)
        .map_err(|error| error.at_line(1, 1).in_file(&name))?;
    let mut header_out: Vec<String> = plan.kept.iter().filter_map(|k| header.get(*k).cloned()).collect();
    header_out.extend(titles(correction));
    let mut writer = Table::new(header_out, output);
    let mut row = csv::StringRecord::new();
    let (mut readings, mut given) = (vec![0.0; plan.sensors.len()], correction.corrector.fallbacks());
    counts.given = plan.given.iter().map(Option::is_some).collect();
    while reader.read_record(&mut row).map_err(fault)? {
        let number = |column: usize| -> Result<f64> {
            // a short row ends in empty cells
            let cell = row.get(column).unwrap_or_default();
            if cell.is_empty() || cell.eq_ignore_ascii_case("nan") {
                return Ok(f64::NAN);
            }
            cell.parse::<f64>().map_err(|_| {
                Malformed::new(Fault::Value, format!("'{cell}' is no number"))
                    .expected("a number with a decimal point, or an empty cell")
                    .found(format!("'{cell}'"))
                    .at_path(header.get(column).cloned().unwrap_or_default())
                    .at_line(row.position().map_or(0, |p| number::index(p.line())), 1)
                    .in_file(&name)
            })
        };
        for ((reading, column), conversion) in readings.iter_mut().zip(&plan.sensors).zip(&plan.conversions) {
            *reading = number(*column)?;
            if let Some(conversion) = conversion {
                *reading = conversion.apply(*reading);
            }
        }
        for (value, from) in given.iter_mut().zip(&plan.given) {
            if let Some((column, conversion)) = from {
                *value = conversion.apply(number(*column)?);
            }
        }
        let (values, converged) = correction.row(&readings, &given);
        counts.rows += 1;
        counts.failed += u64::from(!converged);
        let kept = plan.kept.iter().map(|k| Cow::Borrowed(row.get(*k).unwrap_or_default().as_bytes()));
        writer.row(kept.chain(values.iter().map(|value| Cow::Owned(cell(*value).into_bytes()))))?;
    }
    writer.finish()
}

/// A number, or an empty cell where there is none.
pub(super) fn cell(value: f64) -> String {
    if value.is_finite() { value.to_string() } else { String::new() }
}

pub(super) fn unwritten(error: &dyn std::fmt::Display) -> Malformed {
    Malformed::new(Fault::File, format!("the corrected record cannot be written: {error}")).expected("room to write to")
}
