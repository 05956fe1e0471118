//! Sheets of Excel and OpenDocument workbooks, as the tables of text that they would be saved as.

use super::Delimited;
use super::guard::guarded;
use crate::error::{Fault, Malformed, Result};
use calamine::{Data, Range, Reader, open_workbook_auto_from_rs};
use std::io::{Cursor, Read};

/// Seconds of a day: dates are numbers of days there.
const DAY_S: f64 = 86_400.0;

/// Read the sheet that is meant, as a table of text whose lines are the sheet's rows.
///
/// Errors: a file that cannot be read, no sheet with numbers, several; with those found.
pub(super) fn open(
    name: &str,
    bytes: Vec<u8>,
    table: Option<&str>,
    text: impl Fn(&str, Box<dyn Read + Send>) -> Result<Delimited>,
) -> Result<Delimited> {
    let broken = |error: &dyn std::fmt::Display| {
        Malformed::new(Fault::File, format!("'{name}' cannot be read as a workbook"))
            .expected("a whole .xlsx, .xls, .xlsb or .ods file")
            .found(error.to_string())
            .in_file(name)
    };
    let read = || read(name, bytes, table, &broken);
    let lines = guarded(read).ok_or_else(|| broken(&"its structure is damaged"))??;
    text(name, Box::new(Cursor::new(lines.into_bytes())))
}

/// The sheet that is meant, as lines.
fn read(
    name: &str,
    bytes: Vec<u8>,
    table: Option<&str>,
    broken: &dyn Fn(&dyn std::fmt::Display) -> Malformed,
) -> Result<String> {
    let mut book = open_workbook_auto_from_rs(Cursor::new(bytes)).map_err(|error| broken(&error))?;
    let all = book.sheet_names();
    let list = |names: &[String]| names.iter().map(|own| format!("'{own}'")).collect::<Vec<_>>().join(", ");
    let names: Vec<String> = match table {
        Some(wanted) => {
            let one = all.iter().find(|own| *own == wanted).ok_or_else(|| {
                Malformed::new(Fault::UnknownName, format!("'{name}' has no sheet '{wanted}'"))
                    .expected("one of its sheets, behind a '#'")
                    .found(list(&all))
                    .in_file(name)
            })?;
            vec![one.clone()]
        }
        None => all.clone(),
    };
    let mut found = Vec::new();
    for own in names {
        let range = book.worksheet_range(&own).map_err(|error| broken(&error))?;
        let numbers =
            range.used_cells().any(|(_, _, cell)| matches!(cell, Data::Int(_) | Data::Float(_) | Data::DateTime(_)));
        // numbers may be written as texts
        if numbers || (table.is_some() && !range.is_empty()) {
            found.push((own, range));
        }
    }
    let names: Vec<String> = found.iter().map(|(own, _)| own.clone()).collect();
    match (found.pop(), found.is_empty()) {
        (Some((_, range)), true) => Ok(lines(&range)),
        (None, _) => Err(Malformed::new(Fault::Missing, format!("'{name}' has no sheet with numbers"))
            .expected("a sheet whose first row names the columns, with numbers below")
            .found(list(&all))
            .in_file(name)),
        _ => Err(Malformed::new(Fault::Value, format!("'{name}' has more than one sheet with numbers"))
            .expected(format!("one of them by its name: {name}#{}", names.first().map_or("", String::as_str)))
            .found(list(&names))
            .in_file(name)),
    }
}

/// A sheet as text: cells parted by tabs, a line for each row, from the first row of the sheet on.
fn lines(range: &Range<Data>) -> String {
    use std::fmt::Write;
    let mut text = "\n".repeat(range.start().map_or(0, |(row, _)| row as usize));
    for row in range.rows() {
        for (k, cell) in row.iter().enumerate() {
            if k > 0 {
                text.push('\t');
            }
            // writing to memory does not fail
            let _ = match cell {
                Data::Int(value) => write!(text, "{value}"),
                Data::Float(value) => write!(text, "{value}"),
                Data::DateTime(value) => write!(text, "{}", value.as_f64() * DAY_S),
                Data::Bool(value) => write!(text, "{}", u8::from(*value)),
                Data::String(own) | Data::DateTimeIso(own) | Data::DurationIso(own) => {
                    let own = own.replace(['\t', '\r', '\n'], " ");
                    match own.contains('"') {
                        true => write!(text, "\"{}\"", own.replace('"', "\"\"")),
                        false => write!(text, "{own}"),
                    }
                }
                Data::Error(_) | Data::Empty => Ok(()),
            };
        }
        text.push('\n');
    }
    text
}
