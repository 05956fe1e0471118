//! A table of text, corrected row by row: the cells that stay are copied as they stand.

use super::{Correction, Counts, plan, titles};
use crate::error::{Fault, Malformed, Result};
use crate::number;
use crate::record::Column;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;

/// Is a file CSV with commas between its cells and UTF-8 in its first line, as far as that shows?
pub(super) fn is_plain(path: &Path) -> bool {
    let mut first = Vec::new();
    let Ok(file) = std::fs::File::open(path) else { return true };
    let mut lines = BufReader::new(file).take(1 << 20);
    while lines.read_until(b'\n', &mut first).is_ok_and(|read| read > 0) {
        // remarks and blank lines stand before the titles
        if !first.trim_ascii_start().is_empty() && !first.trim_ascii_start().starts_with(b"#") {
            break;
        }
        first.clear();
    }
    let text = std::str::from_utf8(&first);
    text.is_ok_and(|text| !text.contains([';', '\t', '\u{feff}']) && !first.contains(&0))
}

pub(super) fn correct(correction: &Correction<'_>, input: impl Read, output: impl Write) -> Result<Counts> {
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
    let mut writer = csv::Writer::from_writer(std::io::BufWriter::with_capacity(1 << 16, output));
    let mut header_out: Vec<String> = plan.kept.iter().filter_map(|k| header.get(*k).cloned()).collect();
    header_out.extend(titles(correction));
    writer.write_record(&header_out).map_err(|e| unwritten(&e))?;
    let mut row = csv::StringRecord::new();
    let (mut readings, mut given) = (vec![0.0; plan.sensors.len()], correction.corrector.fallbacks());
    let mut counts = Counts { rows: 0, failed: 0, given: plan.given.iter().map(Option::is_some).collect() };
    while reader.read_record(&mut row).map_err(fault)? {
        counts.rows += 1;
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
        for k in &plan.kept {
            writer.write_field(row.get(*k).unwrap_or_default()).map_err(|e| unwritten(&e))?;
        }
        let (values, converged) = correction.row(&readings, &given);
        counts.failed += u64::from(!converged);
        for value in &values {
            writer.write_field(cell(*value)).map_err(|e| unwritten(&e))?;
        }
        writer.write_record(None::<&[u8]>).map_err(|e| unwritten(&e))?;
    }
    writer.flush().map_err(|e| unwritten(&e))?;
    Ok(counts)
}

/// A number, or an empty cell where there is none.
pub(super) fn cell(value: f64) -> String {
    if value.is_finite() { value.to_string() } else { String::new() }
}

pub(super) fn unwritten(error: &dyn std::fmt::Display) -> Malformed {
    Malformed::new(Fault::File, format!("the corrected record cannot be written: {error}")).expected("room to write to")
}
