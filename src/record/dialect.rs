//! The dialect of a table of text: what parts its cells, its decimal mark, its remarks, names and units.

use super::number::number;
use super::text::decoded;
use super::{Column, heading};
use crate::elements::Parts;
use crate::error::{Fault, Malformed, Result};

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

/// The cells of a line; quotes keep a delimiter inside a cell, and are taken off.
pub(super) fn cells(line: &[u8], delimiter: u8) -> Vec<&[u8]> {
    if delimiter == b' ' {
        return line.split(|b| matches!(b, b' ' | b'\t')).filter(|cell| !cell.is_empty()).map(unquoted).collect();
    }
    let (mut found, mut start, mut inside) = (Vec::new(), 0, false);
    for (k, byte) in line.iter().enumerate() {
        if *byte == b'"' {
            inside = !inside;
        } else if *byte == delimiter && !inside {
            found.push(unquoted(line.part(start..k)));
            start = k + 1;
        }
    }
    found.push(unquoted(line.part(start..)));
    found
}

fn unquoted(cell: &[u8]) -> &[u8] {
    let cell = cell.trim_ascii();
    match cell {
        [b'"', inner @ .., b'"'] => inner.trim_ascii(),
        _ => cell,
    }
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
        let lines: Vec<&[u8]> = head.split(|b| *b == b'\n').collect();
        let whole = lines.len().saturating_sub(usize::from(lines.len() > 3)); // the last one may be cut
        let rows: Vec<(usize, &[u8])> = lines
            .iter()
            .take(whole)
            .enumerate()
            .map(|(k, line)| (k, line.strip_suffix(b"\r").unwrap_or(line)))
            .filter(|(_, line)| !line.trim_ascii().is_empty() && !is_remark(line))
            .collect();
        if rows.is_empty() {
            return Err(Malformed::new(Fault::Missing, "the table is empty")
                .expected("a line of names and rows of numbers, or rows of numbers alone"));
        }
        let (delimiter, mark, width) = parted(&rows);
        let values = |line: &[u8]| {
            let cells = cells(line, delimiter);
            cells.len() == width && cells.iter().any(|cell| number(cell, mark).is_some_and(f64::is_finite))
        };
        let filled = rows.iter().filter(|(_, line)| !is_blank(line, delimiter));
        let first = filled.clone().position(|(_, line)| values(line) && mostly_numbers(line, delimiter, mark));
        let titles: Vec<&(usize, &[u8])> = filled.clone().take(first.unwrap_or(usize::MAX)).collect();
        let titles: Vec<&(usize, &[u8])> =
            titles.into_iter().filter(|(_, line)| cells(line, delimiter).len() == width).collect();
        let texts = |line: &[u8]| -> Vec<String> { cells(line, delimiter).into_iter().map(decoded).collect() };
        let (names, units) = match titles.as_slice() {
            [] => (None, None),
            [.., names, units] if heading::is_units(&texts(units.1)) => (Some(names.1), Some(units.1)),
            [.., names] => (Some(names.1), None),
        };
        let named = names.is_some();
        let mut columns: Vec<Column> = match names {
            Some(line) => texts(line).iter().map(|text| Column::titled(text)).collect(),
            None => (1..=width).map(|k| Column { name: format!("c{k}"), title: format!("c{k}"), unit: None }).collect(),
        };
        if let Some(line) = units {
            for (column, unit) in columns.iter_mut().zip(texts(line)) {
                column.unit = column.unit.take().or_else(|| Some(heading::bare(&unit)).filter(|u| !u.is_empty()));
            }
        }
        for (k, column) in columns.iter().enumerate() {
            let twice = columns.iter().take(k).any(|other| other.name == column.name);
            if twice && !column.name.is_empty() {
                return Err(Malformed::new(Fault::NameClash, format!("the column '{}' stands twice", column.title))
                    .expected("each column once"));
            }
        }
        let lines_before = filled.clone().nth(first.unwrap_or(0)).map_or(0, |(k, _)| *k);
        let lines_before = if first.is_none() { lines.len() } else { lines_before };
        let skip = lines.iter().take(lines_before).map(|line| line.len() + 1).sum::<usize>().min(head.len());
        Ok(Dialect { delimiter, mark, columns, named, skip, lines: lines_before as u64 })
    }
}

impl Dialect {
    /// The dialect of a table whose first line is known to name the columns: readings of a campaign.
    ///
    /// Cells are parted by what parts the names most often: a comma, a semicolon or a tab. Errors as [`Dialect::of`].
    pub fn titled(head: &[u8]) -> Result<Dialect> {
        let lines: Vec<&[u8]> = head.split(|b| *b == b'\n').collect();
        let is_row = |line: &[u8]| !line.trim_ascii().is_empty() && !is_remark(line);
        let Some((first, title)) = lines.iter().enumerate().find(|(_, line)| is_row(line)) else {
            return Err(Malformed::new(Fault::Missing, "the table is empty")
                .expected("a first line that names the columns, and rows of numbers"));
        };
        let title = title.strip_suffix(b"\r").unwrap_or(title); // as it is where no such end stands
        let times = |delimiter: &u8| title.iter().filter(|b| *b == delimiter).count();
        // the last of several that are as frequent is taken
        let delimiter = b"\t;,".iter().copied().max_by_key(times).unwrap_or(b',');
        let columns: Vec<Column> =
            cells(title, delimiter).into_iter().map(|cell| Column::titled(&decoded(cell))).collect();
        for (k, column) in columns.iter().enumerate() {
            if !column.title.is_empty() && columns.iter().take(k).any(|other| other.title == column.title) {
                return Err(Malformed::new(Fault::NameClash, format!("the column '{}' stands twice", column.title))
                    .expected("each column once"));
            }
        }
        let rows = || lines.iter().skip(first + 1).filter(|line| is_row(line)).flat_map(|line| cells(line, delimiter));
        let comma = |cell: &[u8]| cell.contains(&b',') && number(cell, b',').is_some_and(f64::is_finite);
        let point = |cell: &[u8]| cell.contains(&b'.') && number(cell, b'.').is_some_and(f64::is_finite);
        let commas = delimiter != b',' && rows().any(comma) && !rows().any(point);
        let skip = lines.iter().take(first + 1).map(|line| line.len() + 1).sum::<usize>().min(head.len());
        let mark = if commas { b',' } else { b'.' };
        Ok(Dialect { delimiter, mark, columns, named: true, skip, lines: first as u64 + 1 })
    }
}

/// Are at least half of the filled cells of a line numbers?
fn mostly_numbers(line: &[u8], delimiter: u8, mark: u8) -> bool {
    let cells = cells(line, delimiter);
    let filled = cells.iter().filter(|cell| !cell.is_empty()).count();
    let numbers = cells.iter().filter(|cell| number(cell, mark).is_some_and(f64::is_finite)).count();
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
        let comma = delimiter != b',' && all().any(|c| c.contains(&b',')) && !all().any(is_pointed);
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
