//! The dialect of a table of text: what parts its cells, its decimal mark, its remarks, names and units.

use super::number::number;
use super::text::decoded;
use super::times::moment;
use super::{Column, heading};
use crate::elements::Parts;
use crate::error::{Fault, Malformed, Result};
use std::borrow::Cow;
use std::collections::HashSet;

/// How a table is written.
#[derive(Debug, Clone, PartialEq)]
pub struct Dialect {
    /// What parts cells; a space stands for any run of spaces and tabs.
    pub delimiter: u8,
    /// Decimal mark, `.` or `,`.
    pub mark: u8,
    /// Columns: by their names, or `c1`, `c2`, ... where the table has none.
    pub columns: Vec<Column>,
    /// Whether the names come from the table.
    pub named: bool,
    /// Bytes and lines before the first row of values.
    pub(super) skip: usize,
    pub(super) lines: u64,
}

/// Is a line a remark?
pub(super) fn is_remark(line: &[u8]) -> bool {
    let line = line.trim_ascii_start();
    line.starts_with(b"#") || line.starts_with(b"%") || line.starts_with(b"//")
}

/// Does a line hold nothing, or nothing but empty cells (as spreadsheets write rows below a table)?
pub(super) fn is_blank(line: &[u8], delimiter: u8) -> bool {
    line.iter().all(|b| *b == delimiter || b.is_ascii_whitespace() || *b == b'"')
}

/// One past the end of the row that `text` begins with, its line break included; a quoted cell may have several lines.
///
/// A quote opens a cell where it stands first in it. Errors: a row that does not end here; `true` where it is a quoted cell that does not.
pub(super) fn row_end(text: &[u8]) -> std::result::Result<usize, bool> {
    let (mut at, mut first) = (0, true);
    while let Some(byte) = text.get(at) {
        match byte {
            b'\n' => return Ok(at + 1),
            b'"' if first => {
                // to the quote that closes it: two of them stand for one
                loop {
                    at += 1 + text.part(at + 1..).iter().position(|b| *b == b'"').ok_or(true)?;
                    if text.get(at + 1) != Some(&b'"') {
                        break;
                    }
                    at += 1;
                }
                first = false;
            }
            b',' | b';' | b'\t' | b'|' => first = true,
            byte => first &= *byte == b' ',
        }
        at += 1;
    }
    Err(false)
}

/// The rows of a text with the number of the line in which each begins, without their line breaks.
pub(super) fn rows(mut text: &[u8]) -> Vec<(usize, &[u8])> {
    let (mut found, mut line) = (Vec::new(), 0);
    while !text.is_empty() {
        let plain = text.iter().position(|b| *b == b'\n').map_or(text.len(), |k| k + 1);
        // a quote that is never closed is a character
        let end = if is_remark(text) { Ok(plain) } else { row_end(text) };
        let end = end.unwrap_or_else(|quoted| if quoted { plain } else { text.len() });
        let (row, rest) = text.split_at(end);
        found.push((line, row.without_break()));
        line += row.iter().filter(|b| **b == b'\n').count();
        text = rest;
    }
    found
}

/// A line without its break.
pub(super) trait Line {
    /// Without `\n` or `\r\n` at its end.
    fn without_break(&self) -> &[u8];
}

impl Line for [u8] {
    fn without_break(&self) -> &[u8] {
        let line = self.strip_suffix(b"\n").unwrap_or(self);
        line.strip_suffix(b"\r").unwrap_or(line)
    }
}

/// The cells of a row; quotes keep a delimiter or a line break inside a cell, and are taken off.
pub(super) fn cells(line: &[u8], delimiter: u8) -> Vec<Cow<'_, [u8]>> {
    if delimiter == b' ' {
        return line.split(|b| matches!(b, b' ' | b'\t')).filter(|cell| !cell.is_empty()).map(unquoted).collect();
    }
    let (mut found, mut start, mut inside, mut first) = (Vec::new(), 0, false, true);
    for (k, byte) in line.iter().enumerate() {
        match byte {
            // two quotes in a quoted cell close it and open it again
            b'"' if first || inside => (inside, first) = (!inside, !first && inside),
            byte if *byte == delimiter && !inside => {
                found.push(unquoted(line.part(start..k)));
                (start, first) = (k + 1, true);
            }
            byte => first &= *byte == b' ',
        }
    }
    found.push(unquoted(line.part(start..)));
    found
}

fn unquoted(cell: &[u8]) -> Cow<'_, [u8]> {
    let cell = cell.trim_ascii();
    match cell {
        [b'"', inner @ .., b'"'] if inner.contains(&b'"') => Cow::Owned(doubled(inner)),
        [b'"', inner @ .., b'"'] => Cow::Borrowed(inner.trim_ascii()),
        _ => Cow::Borrowed(cell),
    }
}

/// With one quote for each two.
fn doubled(inner: &[u8]) -> Vec<u8> {
    let (mut own, mut open) = (Vec::with_capacity(inner.len()), false);
    for byte in inner {
        open = *byte == b'"' && !open;
        if !open {
            own.push(*byte);
        }
    }
    own
}

/// Is a cell a number or a time?
fn is_value(cell: &[u8], mark: u8) -> bool {
    number(cell, mark).is_some_and(f64::is_finite) || (cell.contains(&b':') && moment(cell).is_some())
}

impl Dialect {
    /// From the first lines of a table (`head` need not end at a line's end, unless it is the whole table).
    ///
    /// The delimiter is the first of tab, `;`, `,`, `|` and space that parts the last lines of `head` into the same number of cells, two or more, most of
    /// them numbers. With another delimiter than the comma, a comma is a decimal mark where no cell has a point. Names are the last line without numbers before the first
    /// row; a line of units below them is taken as that.
    ///
    /// Errors: nothing but remarks; no two lines that are parted alike; cells with both marks; a name twice.
    pub fn of(head: &[u8]) -> Result<Dialect> {
        let all = rows(head);
        let whole = all.len().saturating_sub(usize::from(all.len() > 3)); // the last one may be cut
        let rows: Vec<(usize, &[u8])> = all
            .iter()
            .take(whole)
            .copied()
            .filter(|(_, line)| !line.trim_ascii().is_empty() && !is_remark(line))
            .collect();
        if rows.is_empty() {
            return Err(Malformed::new(Fault::Missing, "the table is empty")
                .expected("a line of names and rows of numbers, or rows of numbers alone"));
        }
        let (delimiter, mark, width) = parted(&rows);
        let values = |line: &[u8]| {
            let cells = cells(line, delimiter);
            cells.len() == width && cells.iter().any(|cell| is_value(cell, mark))
        };
        let filled = rows.iter().filter(|(_, line)| !is_blank(line, delimiter));
        let first = filled.clone().position(|(_, line)| values(line) && mostly_numbers(line, delimiter, mark));
        let titles: Vec<&[u8]> = filled.clone().take(first.unwrap_or(usize::MAX)).map(|(_, line)| *line).collect();
        let texts = |line: &[u8]| -> Vec<String> { cells(line, delimiter).iter().map(|cell| decoded(cell)).collect() };
        let lines_before = match first {
            Some(first) => filled.clone().nth(first).map_or(0, |(k, _)| *k),
            None => head.iter().filter(|b| **b == b'\n').count() + 1,
        };
        let above = titles.clone();
        let titles: Vec<&[u8]> = titles.into_iter().filter(|line| cells(line, delimiter).len() == width).collect();
        // TOA5 (Campbell Scientific): the station, names, units, and what became of the samples
        let is_toa5 = above.first().is_some_and(|line| texts(line).first().is_some_and(|cell| cell == "TOA5"));
        let (names, units) = match (above.as_slice(), titles.as_slice()) {
            ([_, names, units, ..], _) if is_toa5 => {
                // a time stamp and the record's number have no unit
                let none = |unit: &String| matches!(unit.as_str(), "TS" | "RN");
                (
                    Some(texts(names)),
                    Some(texts(units).into_iter().map(|unit| if none(&unit) { String::new() } else { unit }).collect()),
                )
            }
            (_, []) => (remark_titles(&all, lines_before, delimiter, width), None),
            (_, [.., names, units]) if heading::is_units(&texts(units)) => (Some(texts(names)), Some(texts(units))),
            (_, [.., names]) => (Some(texts(names)), None),
        };
        let named = names.is_some();
        let mut columns: Vec<Column> = match names {
            Some(titles) => titles.iter().map(|text| Column::titled(text)).collect(),
            None => (1..=width).map(|k| Column { name: format!("c{k}"), title: format!("c{k}"), unit: None }).collect(),
        };
        for (column, unit) in columns.iter_mut().zip(units.unwrap_or_default()) {
            column.unit = column.unit.take().or_else(|| Some(heading::bare(&unit)).filter(|u| !u.is_empty()));
        }
        let mut seen = HashSet::new();
        if let Some(twice) = columns.iter().find(|own| !own.name.is_empty() && !seen.insert(own.name.as_str())) {
            return Err(Malformed::new(Fault::NameClash, format!("the column '{}' stands twice", twice.title))
                .expected("each column once"));
        }
        Ok(Dialect { delimiter, mark, columns, named, skip: after(head, lines_before), lines: lines_before as u64 })
    }
}

/// Names in the last remark above the rows, where it is parted as they are: `#timestamp [ns],w_x [rad s^-1]`.
fn remark_titles(all: &[(usize, &[u8])], before: usize, delimiter: u8, width: usize) -> Option<Vec<String>> {
    let above = all.iter().take_while(|(line, _)| *line < before);
    let bare = above.filter(|(_, line)| is_remark(line)).last()?.1.trim_ascii_start();
    let bare = bare.iter().position(|b| !matches!(b, b'#' | b'%' | b'/')).map_or(&[][..], |k| bare.part(k..));
    let titles: Vec<String> = cells(bare.trim_ascii(), delimiter).iter().map(|cell| decoded(cell)).collect();
    let named = titles.iter().all(|title| title.starts_with(char::is_alphabetic));
    (width > 1 && titles.len() == width && named).then_some(titles)
}

/// Bytes of the first lines.
fn after(head: &[u8], lines: usize) -> usize {
    let mut breaks = head.iter().enumerate().filter(|(_, b)| **b == b'\n').map(|(k, _)| k + 1);
    lines.checked_sub(1).map_or(0, |k| breaks.nth(k).unwrap_or(head.len()))
}

impl Dialect {
    /// The dialect of a table whose first line is known to name the columns: readings of a campaign.
    ///
    /// Cells are parted by what parts the names most often: a comma, a semicolon or a tab. Errors as [`Dialect::of`].
    pub fn titled(head: &[u8]) -> Result<Dialect> {
        let all = rows(head);
        let is_row = |line: &[u8]| !line.trim_ascii().is_empty() && !is_remark(line);
        let Some((first, (line, title))) = all.iter().enumerate().find(|(_, (_, line))| is_row(line)) else {
            return Err(Malformed::new(Fault::Missing, "the table is empty")
                .expected("a first line that names the columns, and rows of numbers"));
        };
        let times = |delimiter: &u8| title.iter().filter(|b| *b == delimiter).count();
        // the last of several that are as frequent is taken
        let delimiter = b"\t;,".iter().copied().max_by_key(times).unwrap_or(b',');
        let columns: Vec<Column> = cells(title, delimiter).iter().map(|cell| Column::titled(&decoded(cell))).collect();
        let mut seen = HashSet::new();
        if let Some(twice) = columns.iter().find(|own| !own.title.is_empty() && !seen.insert(own.title.as_str())) {
            return Err(Malformed::new(Fault::NameClash, format!("the column '{}' stands twice", twice.title))
                .expected("each column once")
                .at_line(line + 1, 1));
        }
        // the first number with this mark beside labels of positions: its line, column and text
        let marked = |mark: u8| {
            let rest = all.iter().skip(first + 1).filter(|(_, line)| is_row(line));
            let mut of_rows = rest.flat_map(|(line, row)| {
                let cells = cells(row, delimiter).into_iter().zip(&columns);
                cells.filter(|(_, own)| own.title != "position").map(move |(cell, own)| (line + 1, own, cell))
            });
            of_rows.find(|(_, _, cell)| cell.contains(&mark) && number(cell, mark).is_some_and(f64::is_finite))
        };
        let mark = match (marked(b',').filter(|_| delimiter != b','), marked(b'.')) {
            (Some((at, own, found)), Some((other, _, pointed))) => {
                return Err(Malformed::new(Fault::Value, format!("'{}' has a decimal comma", own.title))
                    .expected(format!("one decimal mark in the whole file; line {other} has '{}'", decoded(&pointed)))
                    .found(format!("'{}'", decoded(&found)))
                    .at_line(at, 1)
                    .at_path(&own.title));
            }
            (Some(_), None) => b',',
            (None, _) => b'.',
        };
        let lines = all.get(first + 1).map_or_else(|| line + 1, |(line, _)| *line);
        let skip = if all.len() > first + 1 { after(head, lines) } else { head.len() };
        Ok(Dialect { delimiter, mark, columns, named: true, skip, lines: lines as u64 })
    }
}

/// Are at least half of the filled cells of a line numbers?
fn mostly_numbers(line: &[u8], delimiter: u8, mark: u8) -> bool {
    let cells = cells(line, delimiter);
    let filled = cells.iter().filter(|cell| !cell.is_empty()).count();
    let numbers = cells.iter().filter(|cell| is_value(cell, mark)).count();
    2 * numbers >= filled && numbers > 0
}

/// Delimiter, decimal mark and number of cells.
fn parted(rows: &[(usize, &[u8])]) -> (u8, u8, usize) {
    let last: Vec<&[u8]> = rows.iter().rev().take(50).map(|(_, line)| *line).collect();
    let mut best: Option<(usize, u8, u8, usize)> = None;
    for delimiter in *b"\t;,| " {
        let last: Vec<&[u8]> = last.iter().copied().filter(|line| !is_blank(line, delimiter)).collect();
        // the most frequent number of cells
        let widths: Vec<usize> = last.iter().map(|line| cells(line, delimiter).len()).collect();
        let often = |width: &usize| widths.iter().filter(|other| *other == width).count();
        let Some(width) = widths.iter().copied().max_by_key(often).filter(|width| *width > 1) else { continue };
        // one name above rows with one comma each: a single column of numbers with decimal commas
        let first = rows.iter().position(|(_, line)| mostly_numbers(line, delimiter, b'.'));
        let title = first.and_then(|k| k.checked_sub(1)).and_then(|k| rows.get(k));
        if delimiter == b',' && width == 2 && title.is_some_and(|(_, line)| !line.contains(&b',')) {
            continue;
        }
        let alike = last.iter().filter(|line| cells(line, delimiter).len() == width).count();
        let all = || last.iter().flat_map(|line| cells(line, delimiter));
        let comma = delimiter != b',' && all().any(|c| c.contains(&b',')) && !all().any(|c| is_pointed(&c));
        let mark = if comma { b',' } else { b'.' };
        let numbers = last.iter().filter(|line| mostly_numbers(line, delimiter, mark)).count();
        let score = alike + 2 * numbers;
        if best.is_none_or(|(most, ..)| score > most) {
            best = Some((score, delimiter, mark, width));
        }
    }
    let (_, delimiter, mark, width) = best.unwrap_or_else(|| {
        let comma = last.iter().any(|line| number(line, b',').is_some()) && !last.iter().any(|line| is_pointed(line));
        // a single column: the delimiter is a byte that no text has
        (0, 0x1F, if comma { b',' } else { b'.' }, 1)
    });
    (delimiter, mark, width)
}

/// Is a cell a number with a decimal point?
fn is_pointed(cell: &[u8]) -> bool {
    cell.contains(&b'.') && number(cell, b'.').is_some_and(f64::is_finite)
}
