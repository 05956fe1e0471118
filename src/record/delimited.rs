//! A table of text in blocks: each cell is read once, where it stands.

use super::dialect::{cell_place, is_blank, is_remark, row_end, without_break, written_cells};
use super::number::{leading, number, pointed};
use super::times::WrittenTimes;
use super::{As, Block, Dialect, Head, RAGGED, UNREADABLE, text};
use crate::elements::Parts;
use crate::error::{Fault, Malformed, Result};
use std::collections::HashMap;
use std::io::{BufRead, Read};

/// How much of a table its dialect is taken from; more where its first lines are longer.
pub(super) const HEAD: usize = 1 << 16;
/// Lines that it takes at least.
const LINES: usize = 8;
/// How much is read at a time.
const CHUNK: usize = 1 << 20;
/// Longest first line: a million titles of seven letters.
const LONGEST_TITLES: usize = 8 * CHUNK;
/// Longest row.
const LONGEST: usize = 32 * CHUNK;

/// An open table of text.
pub(super) struct Delimited {
    pub head: Head,
    from: Box<dyn BufRead + Send>,
    pub dialect: Dialect,
    /// For each column of the file, its place in the block.
    wanted: Vec<Option<(usize, As)>>,
    /// One past the last column that is wanted.
    needed: usize,
    selected: usize,
    /// Are lines said?
    says_lines: bool,
    /// Is a row with another number of cells one of unreadable cells?
    is_lenient: bool,
    /// Is a last row that is cut off a fault?
    is_strict: bool,
    /// What is wrong with the row below those that were given.
    failed: Option<Malformed>,
    buffer: Vec<u8>,
    ended: bool,
    line: u64,
    /// Columns of written times among readings.
    since: HashMap<usize, WrittenTimes>,
}

impl Delimited {
    /// Open a table; a gzip is unpacked.
    ///
    /// Errors as [`Dialect::of`].
    pub fn open(name: &str, from: impl Read + Send + 'static) -> Result<Self> {
        let broken = |error: std::io::Error| text::broken(name, &error);
        let mut from = text::unpacked(from).map_err(broken)?;
        let mut buffer = Vec::with_capacity(HEAD);
        loop {
            let wanted = HEAD.max(buffer.len()) as u64;
            let read = (&mut from).take(wanted).read_to_end(&mut buffer).map_err(broken)?;
            let lines = buffer.iter().filter(|byte| **byte == b'\n').count();
            if read == 0 || lines >= LINES || buffer.len() >= LONGEST {
                break;
            }
            if lines == 0 && buffer.len() >= LONGEST_TITLES {
                return Err(Malformed::new(Fault::Syntax, format!("the first line of '{name}' does not end"))
                    .expected(format!("a line of at most {} MB: rows of cells", LONGEST_TITLES / CHUNK))
                    .found(format!("{} MB without a line break", buffer.len() / CHUNK))
                    .in_file(name));
            }
        }
        if buffer.contains(&0) {
            return Err(Malformed::new(Fault::Syntax, format!("'{name}' is not a table of text"))
                .expected("CSV (also with semicolons, tabs or spaces; gzip), or Parquet")
                .found("a zero byte")
                .in_file(name));
        }
        let mut dialect = Dialect::of(&buffer).map_err(|error| error.in_file(name))?;
        let head = Head::new(name, std::mem::take(&mut dialect.columns));
        buffer.drain(..dialect.skip);
        let line = dialect.lines;
        let wanted = vec![None; head.columns.len()];
        Ok(Delimited {
            head,
            from,
            dialect,
            wanted,
            needed: 0,
            selected: 0,
            says_lines: false,
            is_lenient: false,
            is_strict: false,
            failed: None,
            buffer,
            ended: false,
            line,
            since: HashMap::new(),
        })
    }

    /// Which columns the blocks have.
    pub fn select(&mut self, columns: &[(usize, As)]) {
        self.wanted.iter_mut().for_each(|slot| *slot = None);
        for (place, (column, kind)) in columns.iter().enumerate() {
            self.wanted.iter_mut().skip(*column).take(1).for_each(|slot| *slot = Some((place, *kind)));
        }
        self.needed = self.wanted.iter().rposition(Option::is_some).map_or(0, |k| k + 1);
        self.selected = columns.len();
        let has = |of: &[As]| columns.iter().any(|(_, kind)| of.contains(kind));
        self.says_lines = has(&[As::Mixed, As::Cell]);
        self.is_strict = has(&[As::Mixed, As::Written]);
        self.is_lenient = !has(&[As::Mixed, As::Written, As::Number, As::Time]);
    }

    /// The rows of the next megabyte.
    pub fn next(&mut self, block: &mut Block) -> Result<bool> {
        block.clear(self.selected);
        if let Some(error) = self.failed.take() {
            return Err(error);
        }
        while block.rows() == 0 {
            if self.ended && self.buffer.is_empty() {
                return Ok(false);
            }
            self.fill()?;
            let whole = if self.ended {
                self.buffer.len()
            } else {
                self.buffer.iter().rposition(|b| *b == b'\n').map_or(0, |k| k + 1)
            };
            let buffer = std::mem::take(&mut self.buffer);
            let result = self.rows(buffer.part(..whole), block);
            self.buffer = buffer;
            // a row that does not end here waits for more
            let left = match result {
                Ok(left) => left,
                Err(error) if block.rows() > 0 => {
                    // the rows before come first
                    self.failed = Some(error);
                    return Ok(true);
                }
                Err(error) => return Err(error),
            };
            self.buffer.drain(..whole - left);
        }
        Ok(true)
    }

    /// The rows of further lines, of a table that grows somewhere else: nothing is read from where this one was opened.
    ///
    /// Errors: those of [`Delimited::next`].
    #[allow(dead_code, reason = "the command line alone reads lines that arrive")]
    pub fn lines(&mut self, text: &[u8], block: &mut Block) -> Result<()> {
        block.clear(self.selected);
        self.ended = true;
        self.rows(text, block).map(|_| ())
    }

    fn fill(&mut self) -> Result<()> {
        let most = (CHUNK.saturating_sub(self.buffer.len())).max(CHUNK / 4) as u64;
        let read = (&mut self.from).take(most).read_to_end(&mut self.buffer);
        match read {
            Ok(n) => self.ended = (n as u64) < most,
            Err(error) => {
                return Err(text::broken(&self.head.name, &error).at_line(crate::number::index(self.line) + 1, 0));
            }
        }
        if self.buffer.len() > 64 * CHUNK {
            return Err(Malformed::new(Fault::Syntax, "a line is longer than 64 MB")
                .expected("rows of cells")
                .in_file(&self.head.name));
        }
        Ok(())
    }

    /// Rows of whole lines; gives the number of bytes that are left, of a row that does not end.
    fn rows(&mut self, text: &[u8], block: &mut Block) -> Result<usize> {
        let (delimiter, mark) = (self.dialect.delimiter, self.dialect.mark);
        let mut rest = text;
        while !rest.is_empty() {
            let rows = block.rows();
            if let Some(length) = self.fast(rest, block, delimiter, mark) {
                self.line += 1;
                if self.says_lines {
                    block.lines.push(self.line);
                }
                rest = rest.part(length..);
                continue;
            }
            // what the quick way does not take: remarks, blank lines, quotes, absent values, faults
            block.columns.iter_mut().for_each(|column| column.truncate(rows));
            let plain = rest.iter().position(|b| *b == b'\n').map(|k| k + 1);
            let is_remark = is_remark(rest.part(..plain.unwrap_or(rest.len())), self.dialect.delimiter);
            let end = if is_remark { plain.ok_or(false) } else { row_end(rest) };
            if end.is_err() && !self.ended && rest.len() < LONGEST {
                return Ok(rest.len());
            }
            // a quote that is never closed is a character
            let end = end.or_else(|quoted| plain.filter(|_| quoted).ok_or(quoted));
            let row = rest.part(..end.unwrap_or(rest.len()));
            self.line += 1;
            self.slow(without_break(row), block, end.is_err())?;
            self.line += row.iter().filter(|b| **b == b'\n').count().saturating_sub(1) as u64;
            rest = rest.part(row.len()..);
        }
        Ok(0)
    }

    /// A row of plain numbers, and how many bytes it takes; `None` leaves columns of unequal length where it gives up.
    #[inline]
    fn fast(&mut self, text: &[u8], block: &mut Block, delimiter: u8, mark: u8) -> Option<usize> {
        // what may be a remark is looked at more closely
        if matches!(text.trim_ascii_start().first(), Some(b'#' | b'%' | b'/' | b';')) {
            return None;
        }
        let mut at = 0;
        let width = self.wanted.len();
        // a cell that no quote stands in
        let cell_at = |at: usize| {
            let rest = text.get(at..)?;
            let length = rest.iter().position(|b| *b == delimiter || matches!(*b, b'\n' | b'"'))?;
            rest.get(..length).filter(|_| rest.get(length) != Some(&b'"'))
        };
        for (column, wanted) in self.wanted.iter().take(self.needed).enumerate() {
            let begin = at;
            while text.get(at) == Some(&b' ') {
                at += 1;
            }
            let ahead = match wanted {
                Some((_, As::Number | As::Cell | As::Time | As::Mixed)) => leading(text.get(at..)?, mark),
                _ => None,
            };
            match (wanted, ahead) {
                (Some((place, As::Number | As::Cell)), ahead) => {
                    let (value, length) = ahead?;
                    block.columns.get_mut(*place)?.push(value);
                    at += length;
                }
                // a time, or what may be a text, that is a number
                (Some((place, As::Time | As::Mixed)), Some((value, length)))
                    if text.get(at + length).is_some_and(|b| *b == delimiter || matches!(*b, b'\n' | b'\r')) =>
                {
                    block.columns.get_mut(*place)?.push(value);
                    at += length;
                }
                (Some((place, As::Label | As::Time | As::Mixed | As::Written)), _) => {
                    let cell = cell_at(at)?;
                    let (cell, length) = (cell.trim_ascii(), cell.len());
                    let value = match wanted {
                        Some((_, As::Time)) => match leading(cell, mark) {
                            Some((value, length)) if length == cell.len() => value,
                            _ => self.head.times.seconds(cell)?,
                        },
                        Some((_, As::Mixed)) => self.head.labels.mixed(cell, mark),
                        Some((_, As::Written)) => written(&mut block.written, cell, mark),
                        _ => {
                            let written = text.get(begin..at + length)?;
                            self.head.labels.trimmed(written.strip_suffix(b"\r").unwrap_or(written))
                        }
                    };
                    block.columns.get_mut(*place)?.push(value);
                    at += length;
                }
                (None, _) => at += cell_at(at)?.len(),
            }
            let more = column + 1 < width;
            // empty cells behind the last column are none
            while !more && text.get(at) == Some(&delimiter) {
                at += 1;
            }
            match text.get(at)? {
                byte if more && *byte == delimiter => at += 1,
                b'\r' if !more && text.get(at + 1) == Some(&b'\n') => return Some(at + 2),
                b'\n' if !more => return Some(at + 1),
                _ => return None,
            }
        }
        // the columns behind the last one wanted are counted, not read
        let rest = text.get(at..)?;
        let (mut delimiters, mut filled, left) = (0, 0, width - self.needed);
        for (k, byte) in rest.iter().enumerate() {
            match byte {
                b'\n' => return (delimiters + 1 >= left && filled < left).then_some(at + k + 1),
                b'"' => return None,
                byte if *byte == delimiter => delimiters += 1,
                byte if byte.is_ascii_whitespace() => {}
                _ => filled = delimiters,
            }
        }
        None
    }

    fn slow(&mut self, line: &[u8], block: &mut Block, unended: bool) -> Result<()> {
        let Dialect { delimiter, mark, .. } = self.dialect;
        if is_blank(line, delimiter) || is_remark(line, delimiter) {
            return Ok(());
        }
        let mut found = written_cells(line, delimiter);
        let width = self.wanted.len();
        // a cell below no name stands beside the table
        let most = self.dialect.most.max(width);
        while found.len() > width
            && (found.len() <= most || found.last().is_some_and(|cell| cell.trim_ascii().is_empty()))
        {
            found.pop();
        }
        // a word alone below or between rows of numbers (`End of file`)
        let is_filled = |cell: &std::borrow::Cow<'_, [u8]>| !cell.trim_ascii().is_empty();
        let place = found.iter().position(is_filled).unwrap_or(width);
        let is_alone = delimiter == b' ' || found.iter().filter(|cell| is_filled(cell)).count() == 1;
        let is_word = found.iter().all(|cell| leading(cell.trim_ascii(), mark).is_none_or(|(value, _)| value.is_nan()));
        // of a column of texts it is a cell, and the rest of its row is missing
        let is_cell = self.dialect.texts.get(place) != Some(&false);
        if is_alone && is_word && !is_cell && !unended && width > 1 && self.dialect.texts.contains(&false) {
            return Ok(());
        }
        let is_ragged = found.len() != width && self.is_lenient;
        if found.len() < width && unended && !self.is_strict && !self.is_lenient {
            return Ok(());
        }
        if found.len() != width && !is_ragged {
            return Err(Malformed::new(Fault::Syntax, "a row has another number of cells than the rows before it")
                .expected(format!("{width} cells"))
                .found(format!("{} cells", found.len()))
                .at_line(crate::number::index(self.line), 0)
                .in_file(&self.head.name));
        }
        let mut values = vec![if is_ragged { RAGGED } else { 0.0 }; self.selected];
        for (k, written_cell) in found.into_iter().enumerate() {
            let Some(Some((place, kind))) = self.wanted.get(k) else { continue };
            let cell = written_cell.trim_ascii();
            let value = match kind {
                As::Label => self.head.labels.trimmed(&written_cell),
                _ if is_ragged => continue,
                As::Number => number(cell, mark).ok_or_else(|| self.no_number(k, cell, line))?,
                As::Mixed => self.head.labels.mixed(cell, mark),
                As::Written => written(&mut block.written, cell, mark),
                As::Time => match number(cell, mark) {
                    Some(value) => value,
                    None => self.head.times.seconds(cell).ok_or_else(|| self.no_time(k, cell, line))?,
                },
                As::Cell => match number(cell, mark) {
                    // an empty cell says that nothing was read; a word for it is no number
                    Some(value) if value.is_nan() && !cell.trim_ascii().is_empty() => UNREADABLE,
                    Some(value) => value,
                    // a column of written times, since the first of them
                    None if self.dialect.texts.get(k) == Some(&true) => {
                        self.since.entry(k).or_default().since_first(&text::decoded(cell)).unwrap_or(UNREADABLE)
                    }
                    None => UNREADABLE,
                },
            };
            values.iter_mut().skip(*place).take(1).for_each(|slot| *slot = value);
        }
        block.columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        if self.says_lines {
            block.lines.push(self.line);
        }
        Ok(())
    }

    fn no_time(&self, column: usize, cell: &[u8], row: &[u8]) -> Malformed {
        self.unread(column, cell, row, "a time")
            .expected("a number, or a time such as 2026-11-20T09:14:03.25, 20.11.2026 09:14:03 or 14:03:01.25 (of 05/11/2026 either number may be the day: two such dates that differ in one number show it)")
    }

    fn no_number(&self, column: usize, cell: &[u8], row: &[u8]) -> Malformed {
        let other = if self.dialect.mark == b',' { b'.' } else { b',' };
        let swapped = number(cell, other).is_some_and(f64::is_finite);
        self.unread(column, cell, row, "a number").expected(if swapped {
            format!("a number with the decimal mark '{}', as in the rows before", char::from(self.dialect.mark))
        } else {
            "a number; an empty cell or NaN where nothing was read".into()
        })
    }

    /// A cell of a row is not what it must be.
    fn unread(&self, column: usize, cell: &[u8], row: &[u8], what: &str) -> Malformed {
        let title = self.head.columns.get(column).map_or("", |c| c.title.as_str());
        // of a cell that was found
        let (lines, place) = cell_place(row, self.dialect.delimiter, column).unwrap_or_default();
        Malformed::new(Fault::Value, format!("'{title}' is not {what}"))
            .found(format!("'{}'", text::decoded(cell).chars().take(40).collect::<String>()))
            .at_cell(crate::number::index(self.line) + lines, place)
            .at_path(title)
            .in_file(&self.head.name)
    }
}

/// A cell as it stands, but for a number with another decimal mark than the point.
fn written(to: &mut super::Written, cell: &[u8], mark: u8) -> f64 {
    match mark != b'.' && number(cell, mark).is_some_and(f64::is_finite) {
        true => to.push(pointed(cell, mark).into_iter()),
        false => to.push(cell.iter().copied()),
    }
}
