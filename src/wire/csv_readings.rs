//! Readings from a CSV file: the first line names the columns, which are the keys of a JSON reading.

use super::columns::{Column, columns};
use super::locate::{CsvRow, csv_place, csv_row};
use super::readings_file::{Cell, CellRows, MOST_READINGS, ReadingFile, from_cells, too_many};
use super::{Named, Source};
use crate::bench::Bench;
use crate::campaign::Readings;
use crate::error::{Fault, Malformed, Result};
use crate::number;

/// Read a CSV; empty cells are absent values, `position` is a text, every other cell that looks like a number is one.
///
/// Errors: a ragged row, a column that stands twice, a joint, sensor or uncertainty that is not a number; with the line and the column's name.
pub(super) fn read(bench: &Bench, source: &Source, map: &Named<String>) -> Result<Readings> {
    let delimiter = delimiter(&source.text);
    let headers = reader(source, delimiter).headers().map_err(|error| csv_error(&error, source))?.clone();
    if headers.is_empty() || headers.iter().all(str::is_empty) {
        return Err(Malformed::new(Fault::Missing, "the CSV file is empty")
            .expected("a first line that names the columns, for example position,alpha_deg,beta_deg,gamma_deg_s,V")
            .at_line(1, 1)
            .in_file(&source.name));
    }
    for (k, name) in headers.iter().enumerate() {
        if let Some(first) = headers.iter().take(k).position(|other| other == name) {
            return Err(Malformed::new(Fault::NameClash, format!("the column '{name}' stands twice"))
                .expected("each column once")
                .found(format!("columns {} and {}", first + 1, k + 1))
                .at_line(1, 1)
                .in_file(&source.name));
        }
    }
    let columns = columns(bench, &headers.iter().collect::<Vec<_>>(), map, &source.name)?;
    let mark = decimal_mark(&headers, delimiter, source)?;
    let rows = Rows { source, delimiter, columns: &columns, mark };
    from_cells(bench, rows).map_err(|error| at_line(error, source))
}

/// The records of a text, from the beginning.
fn reader(source: &Source, delimiter: u8) -> csv::Reader<&[u8]> {
    csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .delimiter(delimiter)
        .comment(Some(b'#'))
        .from_reader(source.text.as_bytes())
}

/// The rows of a CSV as cells, read from the text each time: the cells of a million rows are larger than their text by an order.
struct Rows<'a> {
    source: &'a Source,
    delimiter: u8,
    columns: &'a [Column],
    mark: char,
}

impl CellRows for Rows<'_> {
    fn visit(&self, see: &mut dyn FnMut(&dyn Fn() -> String, &ReadingFile) -> Result<()>) -> Result<()> {
        let Rows { source, columns, mark, .. } = *self;
        let (mut reader, mut record) = (reader(source, self.delimiter), csv::StringRecord::new());
        let mut row = Named(columns.iter().map(|column| (column.key.clone(), Cell::Nothing(()))).collect());
        let mut count = 0_usize;
        while reader.read_record(&mut record).map_err(|error| csv_error(&error, source))? {
            // a spreadsheet writes the empty rows below its table, too
            if record.iter().all(str::is_empty) {
                continue;
            }
            count += 1;
            if count as f64 > MOST_READINGS {
                return Err(too_many(count).in_file(&source.name));
            }
            for ((Column { key, conversion }, (_, cell)), text) in columns.iter().zip(&mut row.0).zip(&record) {
                *cell = match number(text, mark) {
                    _ if text.is_empty() => Cell::Nothing(()),
                    _ if key == "position" => Cell::Text(text.to_string()),
                    Some(value) => Cell::Number(conversion.map_or(value, |conversion| conversion.apply(value))),
                    None => Cell::Text(text.to_string()),
                };
            }
            see(&|| csv_place(line_of(&record, &source.text), &source.name), &row)?;
        }
        Ok(())
    }
}

/// The first cell like this beside those of the column 'position': its record, the column and the text.
///
/// Errors: a row that is none, wherever it stands.
fn find(
    headers: &csv::StringRecord,
    delimiter: u8,
    source: &Source,
    like: impl Fn(&str) -> bool,
) -> Result<Option<(csv::StringRecord, String, String)>> {
    let (mut reader, mut record) = (reader(source, delimiter), csv::StringRecord::new());
    let mut found = None;
    while reader.read_record(&mut record).map_err(|error| csv_error(&error, source))? {
        if found.is_none() {
            let mut named = headers.iter().zip(&record).filter(|(name, _)| *name != "position");
            let own = named.find(|(_, text)| like(text));
            found = own.map(|(name, text)| (record.clone(), name.to_string(), text.to_string()));
        }
    }
    Ok(found)
}

/// The decimal mark of a table: a comma where commas do not part its cells, some number has one and none has a point.
///
/// Errors: a row that is none; a number with a comma where commas part the cells, or beside numbers with a point.
fn decimal_mark(headers: &csv::StringRecord, delimiter: u8, source: &Source) -> Result<char> {
    // no cell has a comma
    if !source.text.contains(if delimiter == b',' { '"' } else { ',' }) {
        return Ok('.');
    }
    let Some((record, name, text)) = find(headers, delimiter, source, is_decimal_comma)? else { return Ok('.') };
    let pointed = find(headers, delimiter, source, |text| text.contains('.') && text.parse::<f64>().is_ok())?;
    let error = Malformed::new(Fault::Value, format!("'{name}' has a decimal comma"));
    let error = match (delimiter, pointed) {
        (b',', _) => error.expected("a number with a decimal point (or a file whose cells are parted by semicolons)"),
        (_, Some((other, _, pointed))) => error.expected(format!(
            "one decimal mark in the whole file; line {} has '{pointed}'",
            line_of(&other, &source.text)
        )),
        (_, None) => return Ok(','),
    };
    let place = csv_place(line_of(&record, &source.text), &source.name);
    Err(at_line(error.found(format!("'{text}'")).at_path(format!("{place}{name}")), source))
}

/// A cell as a number with this decimal mark.
fn number(text: &str, mark: char) -> Option<f64> {
    if mark == '.' { text.parse().ok() } else { text.replace(mark, ".").parse().ok() }
}

/// Would a cell be a number with a point for its comma?
pub(super) fn is_decimal_comma(text: &str) -> bool {
    text.matches(',').count() == 1 && text.parse::<f64>().is_err() && text.replace(',', ".").parse::<f64>().is_ok()
}

/// The line of a record: its position as the reader gives it stands before the remarks and empty lines above it.
pub(super) fn line_of(record: &csv::StringRecord, text: &str) -> u64 {
    let Some(place) = record.position() else { return 0 };
    // the reader's place may lie within a character that is not of this text, then nothing stands above
    let above = text.get(number::index(place.byte())..).unwrap_or_default().split_inclusive('\n');
    place.line() + above.take_while(|line| line.starts_with('#') || line.trim().is_empty()).count() as u64
}

/// The place of a row and its column (as `from_cells` names them) to line, column and caret.
pub(super) fn at_line(error: Malformed, source: &Source) -> Malformed {
    let path = error.place().path.clone();
    let Some(CsvRow { line, column, .. }) = csv_row(&path) else { return error.in_file(&source.name) };
    let error = error.at_line(line, 1).in_file(&source.name).moved_to(column);
    // beyond the end of the file there is nothing to quote
    let text = source.text.lines().nth(line.saturating_sub(1)).unwrap_or_default();
    let header = source.text.lines().find(|l| !l.starts_with('#')).unwrap_or_default();
    let delimiter = char::from(delimiter(&source.text));
    let field = header.split(delimiter).position(|name| name.trim().trim_matches('"') == column);
    match field.and_then(|k| text.split(delimiter).nth(k)) {
        Some(cell) => {
            let base = source.text.as_ptr() as usize;
            let start = (cell.as_ptr() as usize).saturating_sub(base);
            let in_line = start.saturating_sub((text.as_ptr() as usize).saturating_sub(base));
            error.at_span(start, cell.len()).at_line(line, in_line + 1)
        }
        None => {
            let start = (text.as_ptr() as usize).saturating_sub(source.text.as_ptr() as usize);
            error.at_span(if text.is_empty() { 0 } else { start }, text.len())
        }
    }
}

/// What parts the names of the first line most often: a comma, a semicolon or a tab.
pub(super) fn delimiter(text: &str) -> u8 {
    let first = text.lines().find(|line| !line.starts_with('#')).unwrap_or_default();
    let times = |delimiter: &u8| first.bytes().filter(|b| b == delimiter).count();
    // the last of several that are as frequent is taken
    b"\t;,".iter().copied().max_by_key(times).unwrap_or(b',')
}

pub(super) fn csv_error(error: &csv::Error, source: &Source) -> Malformed {
    let line = error.position().map_or(0, |p| number::index(p.line()));
    let malformed = match error.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            Malformed::new(Fault::Syntax, "a row has another number of cells than the first line")
                .expected(format!(
                    "{expected_len} cells, as the first line names{}",
                    if len > expected_len { " (write a decimal point, not a comma)" } else { "" }
                ))
                .found(format!("{len} cells"))
        }
        _ => Malformed::new(Fault::Syntax, "this is not a CSV file")
            .expected("rows of comma-separated cells")
            .found(error.to_string()),
    };
    malformed.at_line(line, 1).in_file(&source.name)
}
