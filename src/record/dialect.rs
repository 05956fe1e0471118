//! The dialect of a table of text: what parts its cells, its decimal mark, its remarks, names and units.

use super::clock_from::FIRST;
use super::number::{leading, number};
use super::text::decoded;
use super::times::moment;
use super::{Column, heading};
use crate::elements::Parts;
use crate::error::{Fault, Malformed, Result};
use std::borrow::Cow;
use std::collections::HashSet;
use std::ops::Range;

/// How a table is written.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Dialect {
    /// What parts cells; a space stands for any run of spaces and tabs.
    pub delimiter: u8,
    /// Decimal mark, `.` or `,`.
    pub mark: u8,
    /// Columns: by their names, or `c1`, `c2`, ... where the table has none.
    pub columns: Vec<Column>,
    /// Whether the names come from the table.
    pub named: bool,
    /// Bytes and lines before the first row of values.
    pub skip: usize,
    pub lines: u64,
    /// The line of the names, from 1.
    pub titled: usize,
    /// Cells of the line of names, with those at its end that name nothing.
    pub most: usize,
    /// Columns of which no cell of the first rows is a number.
    pub texts: Vec<bool>,
    /// The first values of each column; NaN where a cell is no number.
    pub firsts: Vec<Vec<f64>>,
    /// The first cell of each column that begins as a number does and is none: `0.5 V`, `0x1F`.
    pub unread: Vec<Option<String>>,
    /// What no number of the first rows shows: whether the mark taken for a decimal mark parts thousands.
    pub doubt: Option<String>,
}

/// Is a line a remark? A semicolon begins one where it does not part cells.
pub(super) fn is_remark(line: &[u8], delimiter: u8) -> bool {
    let line = line.trim_ascii_start();
    line.starts_with(b"#")
        || line.starts_with(b"%")
        || line.starts_with(b"//")
        || (delimiter != b';' && line.starts_with(b";"))
}

/// What delimiter is taken where none is known yet: the one whose lines may begin with an empty cell.
const UNKNOWN: u8 = b';';

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
        let end = if is_remark(text.part(..plain), UNKNOWN) { Ok(plain) } else { row_end(text) };
        let end = end.unwrap_or_else(|quoted| if quoted { plain } else { text.len() });
        let (row, rest) = text.split_at(end);
        found.push((line, without_break(row)));
        line += row.iter().filter(|b| **b == b'\n').count();
        text = rest;
    }
    found
}

/// A line without `\n` or `\r\n` at its end.
pub(super) fn without_break(line: &[u8]) -> &[u8] {
    let line = line.strip_suffix(b"\n").unwrap_or(line);
    line.strip_suffix(b"\r").unwrap_or(line)
}

/// The cells of a row; quotes keep a delimiter or a line break inside a cell, and are taken off.
fn cells(line: &[u8], delimiter: u8) -> Vec<Cow<'_, [u8]>> {
    let trimmed = |cell| match cell {
        Cow::Borrowed(cell) => Cow::Borrowed(<[u8]>::trim_ascii(cell)),
        owned => owned,
    };
    written_cells(line, delimiter).into_iter().map(trimmed).collect()
}

/// The same with the blanks around each.
pub(super) fn written_cells(line: &[u8], delimiter: u8) -> Vec<Cow<'_, [u8]>> {
    let mut found = Vec::new();
    each_cell(line, delimiter, |place| found.push(unquoted(line.part(place))));
    found
}

/// Where the cells of a row stand in it.
fn each_cell(line: &[u8], delimiter: u8, mut see: impl FnMut(Range<usize>)) {
    let mut start = 0;
    if delimiter == b' ' {
        for cell in line.split(|b| matches!(b, b' ' | b'\t')) {
            if !cell.is_empty() {
                see(start..start + cell.len());
            }
            start += cell.len() + 1;
        }
        return;
    }
    let (mut inside, mut first) = (false, true);
    for (k, byte) in line.iter().enumerate() {
        match byte {
            // two quotes in a quoted cell close it and open it again
            b'"' if first || inside => (inside, first) = (!inside, !first && inside),
            byte if *byte == delimiter && !inside => {
                see(start..k);
                (start, first) = (k + 1, true);
            }
            byte => first &= *byte == b' ',
        }
    }
    see(start..line.len());
}

/// Where a cell of a row stands: lines after the row's first, its first character in its line, from 1, and how many characters it has.
pub(super) fn cell_place(row: &[u8], delimiter: u8, cell: usize) -> Option<(usize, (usize, usize))> {
    let (mut found, mut count) = (None, 0);
    each_cell(row, delimiter, |place| {
        found = found.take().or((count == cell).then_some(place));
        count += 1;
    });
    let place = found?;
    let written = row.part(place.clone());
    let start = place.start + written.len() - written.trim_ascii_start().len();
    let before = row.part(..start);
    let line = before.iter().rposition(|b| *b == b'\n').map_or(0, |k| k + 1);
    let characters = |bytes: &[u8]| decoded(bytes).chars().count();
    let line_text = written.trim_ascii().split(|b| *b == b'\n').next().unwrap_or_default();
    let lines = before.iter().filter(|b| **b == b'\n').count();
    Some((lines, (characters(before.part(line..)) + 1, characters(line_text))))
}

fn unquoted(cell: &[u8]) -> Cow<'_, [u8]> {
    match cell.trim_ascii() {
        [b'"', inner @ .., b'"'] if inner.contains(&b'"') => Cow::Owned(doubled(inner)),
        [b'"', inner @ .., b'"'] => Cow::Borrowed(inner),
        _ => Cow::Borrowed(cell),
    }
}

/// With one quote for each two.
fn doubled(inner: &[u8]) -> Vec<u8> {
    let (mut unquoted, mut open) = (Vec::with_capacity(inner.len()), false);
    for byte in inner {
        open = *byte == b'"' && !open;
        if !open {
            unquoted.push(*byte);
        }
    }
    unquoted
}

/// Is a cell a number or a time?
fn is_value(cell: &[u8], mark: u8) -> bool {
    number(cell, mark).is_some_and(f64::is_finite) || (cell.contains(&b':') && moment(cell).is_some())
}

impl Dialect {
    /// From the first lines of a table (`head` need not end at a line's end, unless it is the whole table).
    ///
    /// The delimiter is the first of tab, `;`, `,`, `|` and space that parts the last lines of `head` into the same number of cells, two or more, most of
    /// them numbers. With another delimiter than the comma, a comma is the decimal mark where columns have it. Names are the last line without numbers and empty cells
    /// before the first row; a line of units below them is taken as that. Lines with empty cells above the first line of texts without any are a preamble.
    /// Empty cells at the end of every row, and of the names, are none: a delimiter stands behind each cell there.
    ///
    /// Errors: nothing but remarks; no two lines that are parted alike; cells with both marks; a name twice.
    pub fn of(head: &[u8]) -> Result<Dialect> {
        let all = rows(head);
        let whole = all.len().saturating_sub(usize::from(all.len() > 3)); // the last one may be cut
        let mut rows: Vec<(usize, &[u8])> = all
            .iter()
            .take(whole)
            .copied()
            .filter(|(_, line)| !line.trim_ascii().is_empty() && !is_remark(line, UNKNOWN))
            .collect();
        if rows.is_empty() {
            return Err(Malformed::new(Fault::Missing, "the table is empty")
                .expected("a line of names and rows of numbers, or rows of numbers alone"));
        }
        let (delimiter, mark, width) = parted(&rows);
        rows.retain(|(_, line)| !is_remark(line, delimiter));
        let values = |line: &[u8]| {
            let cells = cells(line, delimiter);
            cells.len() == width && cells.iter().any(|cell| is_value(cell, mark))
        };
        let filled: Vec<(usize, &[u8])> = rows.iter().copied().filter(|(_, line)| !is_blank(line, delimiter)).collect();
        let is_row = |line: &[u8]| values(line) && mostly_numbers(line, delimiter, mark);
        let is_full = |line: &[u8]| cells(line, delimiter).iter().filter(|cell| !cell.is_empty()).count() >= width;
        let names_alone = filled.iter().take_while(|(_, line)| !is_full(line)).count();
        let preamble = filled.get(names_alone).map_or(0, |(_, line)| if values(line) { 0 } else { names_alone });
        let preamble = tagged(&filled, width, &|line| cells(line, delimiter), mark).unwrap_or(preamble);
        // a row of readings may have more texts than numbers, a table of labels none at all
        let below = || filled.iter().enumerate().skip(preamble);
        let first = match below().find(|(_, (_, line))| is_row(line)) {
            Some((first, _)) => {
                let above = filled.iter().take(first).skip(preamble).rev();
                first - above.take_while(|(_, line)| values(line)).count()
            }
            None => below().find(|(_, (_, line))| values(line)).map_or(preamble + 1, |(k, _)| k),
        };
        // what a delimiter at the end of every line leaves is no column
        let used = |line: &[u8]| cells(line, delimiter).iter().rposition(|cell| !cell.is_empty()).map_or(0, |k| k + 1);
        let width = filled.iter().map(|(_, line)| used(line)).filter(|used| *used <= width).max().unwrap_or(width);
        let texts = |line: &[u8]| -> Vec<String> {
            let mut row: Vec<String> = cells(line, delimiter).iter().map(|cell| decoded(cell)).collect();
            while row.len() > width && row.last().is_some_and(String::is_empty) {
                row.pop();
            }
            // a name behind the others is that of remarks, of which no row has any; a comma or a blank may stand in a name
            if row.len() == width + 1 && !matches!(delimiter, b',' | b' ') {
                row.pop();
            }
            row
        };
        let above: Vec<Vec<String>> = filled.iter().take(first).map(|(_, line)| texts(line)).collect();
        // TOA5 (Campbell Scientific): the station, names, units, and what became of the samples
        let is_toa5 = above.first().and_then(|line| line.first()).is_some_and(|cell| cell == "TOA5");
        let is_wide = |line: &&Vec<String>| line.len() == width;
        let is_units = |line: &&Vec<String>| is_wide(line) && heading::is_units(line);
        let units =
            above.last().filter(|line| is_units(line) && above.iter().skip(preamble).filter(is_wide).count() > 1);
        let titles = above.iter().take(above.len() - usize::from(units.is_some())).filter(is_wide);
        // what has no number and empty cells is a row below the names
        let is_full = |line: &&Vec<String>| line.iter().all(|cell| !cell.is_empty());
        let before = filled.get(first).map_or(0, |(k, _)| *k);
        let remarked = || remark_titles(&all, before, delimiter, width);
        // units below names that stand in a remark
        let only = above.last().filter(|line| is_units(line) && above.iter().filter(is_wide).count() == 1);
        let (names, units, first) =
            match (above.as_slice(), titles.clone().rfind(is_full).or(titles.clone().next_back())) {
                _ if only.is_some() && remarked().is_some() => (remarked(), only.cloned(), first),
                ([_, names, units, ..], _) if is_toa5 => {
                    // a time stamp and the record's number have no unit
                    let of =
                        |unit: &String| if matches!(unit.as_str(), "TS" | "RN") { String::new() } else { unit.clone() };
                    (Some(names.clone()), Some(units.iter().map(of).collect()), first)
                }
                (_, Some(names)) => {
                    let place = above.iter().rposition(|line| line == names);
                    let below = place.map_or(first, |k| k + 1);
                    // units may stand above the names, too
                    let before = place.and_then(|k| above.get(k.checked_sub(1)?));
                    let before = before.filter(|line| is_units(line) && !heading::is_units(names));
                    (Some(names.clone()), units.or(before).cloned(), if units.is_some() { first } else { below })
                }
                (_, None) => (remarked(), None, first),
            };
        // the line of the names, from 1
        let is_names = |line: &[u8]| names.as_ref().is_some_and(|names| texts(line) == *names);
        let names_line = filled.iter().take(first).rfind(|(_, line)| is_names(line));
        let titled = names_line.map_or(1, |(k, _)| k + 1);
        let most = names_line.map_or(width, |(_, line)| cells(line, delimiter).len());
        let lines_before = match filled.get(first) {
            Some((k, _)) => *k,
            None => head.iter().filter(|b| **b == b'\n').count() + 1,
        };
        let named = names.is_some();
        let mut texts_of = vec![(false, false); width];
        let (mut written_times, mut firsts) = (vec![false; width], vec![Vec::new(); width]);
        let mut unread: Vec<Option<String>> = vec![None; width];
        // a semicolon parts the cells where commas are decimal marks, and points part thousands
        let (mut is_shown, mut doubtful) = (delimiter == b',' || (mark == b'.' && delimiter != b';'), None);
        for (_, line) in filled.iter().skip(first) {
            let columns = texts_of.iter_mut().zip(&mut written_times).zip(&mut firsts).zip(&mut unread);
            for (k, (((((text, number), time), firsts), unread), cell)) in
                columns.zip(cells(line, delimiter)).enumerate()
            {
                let value = self::number(&cell, mark);
                // what is absent is neither
                *text |= value.is_none();
                *number |= value.is_some_and(|value| !value.is_nan());
                *time |= cell.contains(&b':') && moment(&cell).is_some();
                if unread.is_none() && value.is_none() && leading(&cell, mark).is_some() && moment(&cell).is_none() {
                    *unread = Some(decoded(&cell));
                }
                if !is_shown && cell.contains(&mark) && value.is_some() {
                    is_shown = !is_thousands(&cell, mark);
                    doubtful.get_or_insert_with(|| (k, decoded(&cell)));
                }
                if firsts.len() < FIRST {
                    firsts.push(value.unwrap_or(f64::NAN));
                }
            }
        }
        let mut columns: Vec<Column> = match names {
            Some(titles) => titles.iter().map(|text| Column::titled(text)).collect(),
            None => (1..=width).map(|k| Column { name: format!("c{k}"), title: format!("c{k}"), unit: None }).collect(),
        };
        for (column, unit) in columns.iter_mut().zip(units.unwrap_or_default()) {
            column.unit = column.unit.take().or_else(|| Some(heading::bare(&unit)).filter(|u| !u.is_empty()));
        }
        // a written time is one in seconds, whatever its steps are, and whatever the title says of how it is written
        for (column, _) in columns.iter_mut().zip(written_times).filter(|(_, written)| *written) {
            column.unit = Some("s".into());
        }
        let doubt = doubtful.filter(|_| !is_shown).map(|(k, cell)| {
            let (title, sign) = (columns.get(k).map_or("", |column| &column.title), char::from(mark));
            format!("'{sign}' in '{cell}' of the column '{title}' is read as the decimal mark; no number of the first rows shows that it does not part thousands")
        });
        let mut seen = HashSet::new();
        if let Some(twice) =
            columns.iter().find(|column| !column.title.is_empty() && !seen.insert(column.title.as_str()))
        {
            return Err(Malformed::new(Fault::NameClash, format!("the column '{}' stands twice", twice.title))
                .expected("each column once")
                .at_path(twice.title.as_str())
                .at_line(titled, 0));
        }
        Ok(Dialect {
            delimiter,
            mark,
            columns,
            named,
            skip: after(head, lines_before),
            lines: lines_before as u64,
            titled,
            most,
            texts: texts_of.into_iter().map(|(text, number)| text && !number).collect(),
            firsts,
            unread,
            doubt,
        })
    }
}

/// Where the names stand below a head of tagged lines (`Delta_X 0.01 0.01`): the last full line without numbers, where each line of numbers above it has a
/// text in a column that otherwise has numbers.
fn tagged<'a>(
    filled: &[(usize, &'a [u8])],
    width: usize,
    cells: &dyn Fn(&'a [u8]) -> Vec<Cow<'a, [u8]>>,
    mark: u8,
) -> Option<usize> {
    let numbers = |line: &'a [u8]| {
        cells(line).iter().map(|cell| (number(cell, mark).is_some(), is_value(cell, mark))).collect::<Vec<_>>()
    };
    let has_values = |line: &[(bool, bool)]| line.iter().any(|(_, value)| *value);
    let rows: Vec<Vec<(bool, bool)>> = filled.iter().map(|(_, line)| numbers(line)).collect();
    let names = rows.iter().zip(filled).rposition(|(row, (_, line))| {
        let filled = cells(line).iter().filter(|cell| !cell.is_empty()).count();
        !has_values(row) && (width..=width + 1).contains(&filled)
    })?;
    let below: Vec<&Vec<(bool, bool)>> =
        rows.iter().skip(names + 1).filter(|row| row.len() == width && has_values(row)).collect();
    let most = |k: usize| 2 * below.iter().filter(|row| row.get(k).is_some_and(|cell| cell.1)).count() > below.len();
    let is_tagged =
        |row: &Vec<(bool, bool)>| row.iter().take(width).enumerate().any(|(k, (number, _))| !number && most(k));
    let above: Vec<&Vec<(bool, bool)>> = rows.iter().take(names).filter(|row| has_values(row)).collect();
    (!above.is_empty() && !below.is_empty() && above.into_iter().all(is_tagged)).then_some(names)
}

/// Names in the last remark above the rows, where it is parted as they are: `#timestamp [ns],w_x [rad s^-1]`; or, behind what the remark is about, as they
/// are: `;Headers, time, Ax`.
fn remark_titles(all: &[(usize, &[u8])], before: usize, delimiter: u8, width: usize) -> Option<Vec<String>> {
    let above = all.iter().take_while(|(line, _)| *line < before);
    let bare = above.filter(|(_, line)| is_remark(line, delimiter)).last()?.1.trim_ascii_start();
    let is_mark = |b: &u8| matches!(b, b'#' | b'%' | b'/' | b';') && *b != delimiter;
    let bare = bare.iter().position(|b| !is_mark(b)).map_or(&[][..], |k| bare.part(k..));
    let mut titles: Vec<String> = cells(bare, delimiter).iter().map(|cell| decoded(cell)).collect();
    while titles.len() > width && titles.last().is_some_and(String::is_empty) {
        titles.pop();
    }
    if titles.len() == width + 1 {
        titles.remove(0);
    }
    // the mark itself is the name of numbers of rows
    if let Some(first) = titles.first_mut().filter(|first| first.is_empty()) {
        *first = "No".into();
    }
    let named = titles.iter().all(|title| title.starts_with(char::is_alphabetic));
    (width > 1 && titles.len() == width && named).then_some(titles)
}

/// Bytes of the first lines.
fn after(head: &[u8], lines: usize) -> usize {
    let mut breaks = head.iter().enumerate().filter(|(_, b)| **b == b'\n').map(|(k, _)| k + 1);
    lines.checked_sub(1).map_or(0, |k| breaks.nth(k).unwrap_or(head.len()))
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
        // a delimiter may stand behind the cells of some lines
        let used = |line: &[u8]| cells(line, delimiter).iter().rposition(|cell| !cell.is_empty()).map_or(0, |k| k + 1);
        let most = last.iter().map(|line| used(line)).filter(|used| *used <= width).max().unwrap_or(width);
        let alike = last.iter().filter(|line| (most..=width).contains(&cells(line, delimiter).len())).count();
        let mark = decimal_mark(rows, delimiter);
        let numbers = last.iter().filter(|line| mostly_numbers(line, delimiter, mark)).count();
        let score = alike + 2 * numbers;
        if best.is_none_or(|(most, ..)| score > most) {
            best = Some((score, delimiter, mark, width));
        }
    }
    // a single column: the delimiter is a byte that no text has
    let (_, delimiter, mark, width) = best.unwrap_or_else(|| (0, 0x1F, decimal_mark(rows, 0x1F), 1));
    (delimiter, mark, width)
}

/// The decimal mark: a comma where as many columns have numbers with no other mark as have numbers with a point. But commas may part thousands: where they part the cells too and such numbers stand in
/// quotes, as in `"1,234"`, and where whole numbers without a comma stand in the same column. There some number must show that they do not.
fn decimal_mark(rows: &[(usize, &[u8])], delimiter: u8) -> u8 {
    let mut columns: Vec<Marks> = Vec::new();
    for (_, line) in rows {
        let cells = cells(line, delimiter);
        columns.resize_with(columns.len().max(cells.len()), Marks::default);
        for (own, cell) in columns.iter_mut().zip(&cells) {
            let comma = is_marked(cell, b',');
            own.comma |= comma;
            own.point |= is_marked(cell, b'.');
            own.whole |= !cell.is_empty() && cell.trim_ascii().iter().all(|b| b.is_ascii_digit() || *b == b'-');
            own.shown |= comma && !is_thousands(cell, b',');
        }
    }
    let commas = columns.iter().filter(|own| own.comma && !own.point).count();
    let points = columns.iter().filter(|own| own.point).count();
    let shown = |own: &Marks| own.shown || (delimiter != b',' && own.comma && !own.whole);
    if commas > 0 && commas >= points && columns.iter().any(shown) { b',' } else { b'.' }
}

/// Which numbers a column has: with a comma, with a point, whole ones, and with a comma that parts no thousands.
#[derive(Default)]
struct Marks {
    comma: bool,
    point: bool,
    whole: bool,
    shown: bool,
}

/// May the mark of a number part its thousands?
fn is_thousands(cell: &[u8], mark: u8) -> bool {
    let mut parts = cell.trim_ascii().split(|b| *b == mark);
    let digits = |part: &[u8]| part.iter().all(u8::is_ascii_digit);
    let sign = |part: &[u8]| part.strip_prefix(b"-").unwrap_or(part).to_vec();
    parts.next().map(sign).is_some_and(|first| first != b"0" && first.len() <= 3 && digits(&first))
        && parts.all(|part| part.len() == 3 && digits(part))
}

/// Is a cell a number with this decimal mark, and none with the other one?
fn is_marked(cell: &[u8], mark: u8) -> bool {
    let other = if mark == b',' { b'.' } else { b',' };
    cell.iter().any(|byte| matches!(byte, b',' | b'.'))
        && number(cell, mark).is_some_and(f64::is_finite)
        && number(cell, other).is_none()
}
