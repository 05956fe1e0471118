//! Sheets of Excel and OpenDocument workbooks, as the tables of text that they would be saved as.

use super::Delimited;
use super::guard::guarded;
use super::held::SHORT;
use crate::error::{Fault, Malformed, Result};
use crate::units::Unit;
use calamine::{Data, DataRef, Reader, Sheets, open_workbook_auto_from_rs};
use std::collections::{BTreeMap, HashMap};
use std::io::Cursor;

/// Seconds of a day: dates are numbers of days there.
const DAY_S: f64 = 86_400.0;

/// Read the sheet that is meant, as a table of text whose lines are the sheet's rows.
///
/// Errors: a file that cannot be read, no sheet with numbers, several; with those found.
pub(super) fn open(name: &str, bytes: Vec<u8>, table: Option<&str>) -> Result<Delimited> {
    let broken = |error: &dyn std::fmt::Display| {
        Malformed::new(Fault::File, format!("'{name}' cannot be read as a workbook"))
            .expected("a whole .xlsx, .xls, .xlsb or .ods file; the tables of another archive (.zip) are read when they are unpacked")
            .found(error.to_string())
            .in_file(name)
    };
    // a compound file, which .xls is
    if bytes.starts_with(&[0xD0, 0xCF, 0x11, 0xE0]) && !is_sound(&bytes) {
        return Err(broken(&"a chain of sectors that comes back to itself: the file is damaged"));
    }
    if bytes.starts_with(&[0xD0, 0xCF, 0x11, 0xE0]) && !is_of_a_sheet(&bytes) {
        return Err(broken(&"a sheet that says more rows or columns than a sheet can have: the file is damaged"));
    }
    let read = || read(name, bytes, table, &broken);
    let (lines, units) = guarded(read).ok_or_else(|| broken(&"its structure is damaged"))??;
    let mut table = Delimited::open(name, Cursor::new(lines.into_bytes()))?;
    for (column, unit) in table.head.columns.iter_mut().zip(units) {
        column.unit = column.unit.take().or(unit);
    }
    Ok(table)
}

/// The sheet that is meant, as lines, and the units of its columns.
fn read(
    name: &str,
    bytes: Vec<u8>,
    table: Option<&str>,
    broken: &dyn Fn(&dyn std::fmt::Display) -> Malformed,
) -> Result<(String, Vec<Option<String>>)> {
    let mut book = open_workbook_auto_from_rs(Cursor::new(bytes)).map_err(|error| broken(&error))?;
    let all = book.sheet_names();
    let list = |names: &[String]| names.iter().map(|name| format!("'{name}'")).collect::<Vec<_>>().join(", ");
    let names: Vec<String> = match table {
        Some(wanted) => {
            let one = all.iter().find(|name| *name == wanted).ok_or_else(|| {
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
    for name in names {
        let sheet = used(&mut book, &name).map_err(|error| broken(&error))?;
        let is_number = |(_, cell): &(Place, Data)| is_plain(cell) || matches!(cell, Data::DateTime(_));
        // numbers may be written as texts
        if sheet.iter().any(is_number) || (table.is_some() && !sheet.is_empty()) {
            found.push((name, sheet));
        }
    }
    // a sheet with few rows beside another is taken only by its name
    let rows = |sheet: &[(Place, Data)]| sheet.chunk_by(|((a, _), _), ((b, _), _)| a == b).count();
    let longest = found.iter().map(|(_, sheet)| rows(sheet)).max().unwrap_or(0);
    found.retain(|(_, sheet)| rows(sheet) * SHORT >= longest);
    let names: Vec<String> = found.iter().map(|(name, _)| name.clone()).collect();
    match (found.pop(), found.is_empty()) {
        (Some((sheet_name, sheet)), true) => {
            let wide = || {
                Malformed::new(Fault::Value, format!("the sheet '{sheet_name}' is too wide for its rows"))
                    .expected(format!("at most {MOST_CELLS} cells, rows times columns with a cell"))
                    .in_file(&sheet_name)
            };
            let lines = lines(&sheet).ok_or_else(wide)?;
            let shown = shown(&mut book, &sheet_name).map_err(|error| broken(&error))?;
            let units = units(&sheet, &shown).map_err(|(place, found)| {
                Malformed::new(Fault::Value, format!("the cells of column {} are shown in different units", place + 1))
                    .expected("one unit in a column")
                    .found(found)
                    .in_file(name)
            })?;
            Ok((lines, units))
        }
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

/// Row and column, from 0.
type Place = (u32, u32);

/// The cells of a sheet that hold something, row by row. Of .xlsx and .xlsb only those are read that the file has: one cell in the last corner of a sheet is
/// one cell.
fn used(book: &mut Sheets<Cursor<Vec<u8>>>, name: &str) -> std::result::Result<Vec<(Place, Data)>, calamine::Error> {
    let mut cells: Vec<(Place, Data)> = Vec::new();
    match book {
        Sheets::Xlsx(book) => {
            let mut reader = book.worksheet_cells_reader(name)?;
            while let Some(cell) = reader.next_cell_with_formula()? {
                // programs that write workbooks leave the results of formulas to Excel
                let value = match (cell.value, cell.formula) {
                    (DataRef::Empty, Some(formula)) => {
                        Data::String(format!("={formula}, a formula without a saved value"))
                    }
                    (value, _) => Data::from(value),
                };
                cells.push((cell.pos, value));
            }
        }
        Sheets::Xlsb(book) => {
            let mut reader = book.worksheet_cells_reader(name)?;
            while let Some(cell) = reader.next_cell()? {
                cells.push((cell.get_position(), Data::from(cell.get_value().clone())));
            }
        }
        book => {
            let range = book.worksheet_range(name)?;
            let (row, column) = range.start().unwrap_or_default();
            let place = |(i, k, cell): (usize, usize, &Data)| ((row + low(i), column + low(k)), cell.clone());
            cells.extend(range.used_cells().map(place));
        }
    }
    let is_blank = |cell: &Data| {
        matches!(cell, Data::String(text) if text.trim().is_empty()) || matches!(cell, Data::Empty | Data::Error(_))
    };
    cells.retain(|(_, cell)| !is_blank(cell));
    cells.sort_by_key(|(place, _)| *place);
    Ok(cells)
}

/// Is it a number that is no date?
fn is_plain(cell: &Data) -> bool {
    matches!(cell, Data::Int(_) | Data::Float(_))
}

/// The units that the number formats of a sheet of .xlsx show, by their places.
fn shown(
    book: &mut Sheets<Cursor<Vec<u8>>>,
    name: &str,
) -> std::result::Result<HashMap<Place, String>, calamine::Error> {
    let mut found = HashMap::new();
    let Sheets::Xlsx(book) = book else { return Ok(found) };
    let mut reader = book.worksheet_cells_reader(name)?;
    let format = |style: &calamine::Style| unit_shown(&style.number_format.as_ref()?.format_code);
    let units: Vec<Option<String>> = reader.styles().iter().map(format).collect();
    while let Some((row, column, style)) =
        if units.iter().any(Option::is_some) { reader.next_style_id()? } else { None }
    {
        found.extend(units.get(style).cloned().flatten().map(|unit| ((row, column), unit)));
    }
    Ok(found)
}

/// The unit behind the digits of a number format: `0.00" °C"`, `0.0\ \V`.
fn unit_shown(format: &str) -> Option<String> {
    let (mut literal, mut begun, mut quoted) = (String::new(), false, false);
    let mut signs = format.chars();
    while let Some(sign) = signs.next() {
        match sign {
            '"' => quoted = !quoted,
            sign if quoted => literal.push(sign),
            // of positive numbers
            ';' => break,
            '\\' => literal.extend(signs.next()),
            // a blank as wide as a sign, a sign that fills the cell
            '_' | '*' => drop(signs.next()),
            '[' => drop(signs.by_ref().find(|sign| *sign == ']')),
            '0' | '#' | '?' if !begun => {
                begun = true;
                literal.clear();
            }
            sign if !sign.is_ascii() => literal.push(sign),
            _ => {}
        }
    }
    let unit = literal.trim();
    Unit::parse(unit).ok().filter(|parsed| begun && !parsed.dimension().is_number()).map(|_| unit.to_string())
}

/// The unit of each column with a cell, as its numbers are shown. Errors: a column that has two, and which.
fn units(
    cells: &[(Place, Data)],
    shown: &HashMap<Place, String>,
) -> std::result::Result<Vec<Option<String>>, (u32, String)> {
    let mut found: BTreeMap<u32, Option<&String>> = BTreeMap::new();
    for (place, cell) in cells {
        let unit = found.entry(place.1).or_default();
        let own = shown.get(place).filter(|_| is_plain(cell));
        match (*unit, own) {
            (Some(unit), Some(own)) if unit != own => return Err((place.1, format!("'{unit}' and '{own}'"))),
            _ => *unit = unit.or(own),
        }
    }
    Ok(found.into_values().map(|unit| unit.cloned()).collect())
}

/// A row or column of a sheet: below 2^20.
fn low(place: usize) -> u32 {
    u32::try_from(place).unwrap_or(u32::MAX)
}

/// Most cells that the rows of a table have, the empty ones with them.
const MOST_CELLS: usize = 1 << 27;

/// A sheet as text: cells parted by tabs, a line for each row, from the first row of the sheet on; columns without a cell are left out. `None` where that
/// is too much.
fn lines(cells: &[(Place, Data)]) -> Option<String> {
    use std::fmt::Write;
    let mut columns: Vec<u32> = cells.iter().map(|((_, column), _)| *column).collect();
    columns.sort_unstable();
    columns.dedup();
    let rows = cells.chunk_by(|((a, _), _), ((b, _), _)| a == b);
    if rows.clone().count().saturating_mul(columns.len()) > MOST_CELLS {
        return None;
    }
    // a column of whole days is one of dates
    let times: std::collections::HashSet<u32> = cells
        .iter()
        .filter(|(_, cell)| matches!(cell, Data::DateTime(value) if !(value.is_datetime() && value.as_f64().fract() == 0.0)))
        .map(|((_, column), _)| *column)
        .collect();
    let (mut text, mut line) = (String::new(), 0);
    for row in rows {
        let number = row.first().map_or(line, |((number, _), _)| *number);
        text.extend(std::iter::repeat_n('\n', (number - line) as usize));
        let mut left = row.iter().peekable();
        for (k, column) in columns.iter().enumerate() {
            if k > 0 {
                text.push('\t');
            }
            let Some((_, cell)) = left.next_if(|((_, place), _)| place == column) else { continue };
            // writing to memory does not fail
            let _ = match cell {
                Data::Int(value) => write!(text, "{value}"),
                Data::Float(value) => write!(text, "{value}"),
                Data::DateTime(value) => {
                    let seconds = seconds(value);
                    // what a cell shows as an instant or a date is written as one; a time of day or a duration is its seconds
                    let at = jiff::Timestamp::from_microsecond(crate::number::whole_i64((seconds * 1e6).round())).ok();
                    let at = at.filter(|_| value.is_datetime() && value.as_f64() >= 1.0);
                    match at.map(|at| at.to_zoned(jiff::tz::TimeZone::UTC).datetime()) {
                        Some(at) if times.contains(column) => write!(text, "{at}"),
                        Some(at) => write!(text, "{}", at.date()),
                        None => write!(text, "{seconds}"),
                    }
                }
                Data::Bool(value) => write!(text, "{}", u8::from(*value)),
                Data::String(cell_text) | Data::DateTimeIso(cell_text) | Data::DurationIso(cell_text) => {
                    let cell_text = cell_text.replace(['\t', '\r', '\n'], " ");
                    match cell_text.contains('"') {
                        true => write!(text, "\"{}\"", cell_text.replace('"', "\"\"")),
                        false => write!(text, "{cell_text}"),
                    }
                }
                Data::Error(_) | Data::Empty => Ok(()),
            };
        }
        text.push('\n');
        line = number + 1;
    }
    Some(text)
}

/// Seconds since 1970 of a date; of a time of day or a duration, its seconds.
fn seconds(value: &calamine::ExcelDateTime) -> f64 {
    let days = value.as_f64();
    // 1970 began 25,569 days after the day 0 of these numbers, 24,107 after that of workbooks of early Macs, whose years are four more
    // the year that the cell shows is that of the first kind or four more: two parts them
    let year = 1900 + crate::number::whole_i64(days / 365.25);
    let epoch = if i64::from(value.to_ymd_hms_milli().0) - year > 2 { 24_107.0 } else { 25_569.0 };
    if value.is_datetime() && days >= 1.0 { ((days - epoch) * DAY_S * 1e6).round() / 1e6 } else { days * DAY_S }
}

/// Are the chains of sectors of a compound file (.xls) without a loop? Its reader follows them until memory ends.
fn is_sound(bytes: &[u8]) -> bool {
    let word = |at: usize| Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk::<4>()?));
    let Some(shift) = bytes.get(0x1E).copied().filter(|shift| (7..=16).contains(shift)) else { return false };
    let size = 1_usize << shift;
    let sector = |k: u32| (k as usize + 1).saturating_mul(size);
    let words = |k: u32, count: usize| (0..count).filter_map(move |n| word(sector(k).saturating_add(4 * n)));
    let most = bytes.len() / size + 1;
    // the sectors of the table of sectors: in the head, then in a chain of their own
    let mut tables: Vec<u32> = (0..109).filter_map(|k| word(0x4C + 4 * k)).collect();
    let (mut next, mut seen) = (word(0x44).unwrap_or(u32::MAX), 0);
    while (next as usize) < most {
        tables.extend(words(next, size / 4 - 1));
        next = words(next, size / 4).next_back().unwrap_or(u32::MAX);
        seen += 1;
        if seen > most {
            return false;
        }
    }
    let next: Vec<u32> =
        tables.into_iter().filter(|k| (*k as usize) < most).take(most).flat_map(|k| words(k, size / 4)).collect();
    if has_loop(&next) {
        return false;
    }
    // the table of small sectors is a stream itself
    let (mut at, mut small) = (word(0x3C).unwrap_or(u32::MAX), Vec::new());
    while (at as usize) < next.len().min(most) {
        small.extend(words(at, size / 4));
        at = next.get(at as usize).copied().unwrap_or(u32::MAX);
    }
    !has_loop(&small)
}

/// Do records of dimensions (MS-XLS 2.4.90: first row, last row, first column, last column, zero) say no more than 65,536 rows and 256 columns? Their reader asks for
/// memory for all of them.
fn is_of_a_sheet(bytes: &[u8]) -> bool {
    let word = |record: &[u8], at: usize| {
        record.get(at..).and_then(|record| record.first_chunk::<4>()).map(|record| u32::from_le_bytes(*record))
    };
    let is_record = |record: &&[u8]| matches!(record.first_chunk::<4>(), Some([0x00, 0x02, 0x0E | 0x10, 0x00]));
    (0..bytes.len()).filter_map(|at| bytes.get(at..)).filter(is_record).all(|record| {
        let (Some(rows), Some(columns), Some(rest)) = (word(record, 8), word(record, 12), word(record, 14)) else {
            return true;
        };
        // what is not followed by zero is no such record
        rest >> 16 != 0 || (rows <= 65_536 && columns >> 16 <= 256)
    })
}

/// Does a chain of a table of followers come back to where it was?
fn has_loop(next: &[u32]) -> bool {
    let mut walk = vec![0_usize; next.len()];
    (0..next.len()).any(|start| {
        let mut at = start;
        while let (Some(step), Some(follower)) = (walk.get_mut(at), next.get(at)) {
            match *step {
                0 => *step = start + 1,
                step => return step == start + 1,
            }
            at = *follower as usize;
        }
        false
    })
}
