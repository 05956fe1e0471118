//! Records: tables of samples as loggers and spreadsheets write them, in blocks of columns.
//!
//! ```text
//! file (CSV in its dialects, gzip, Parquet) -> columns by name -> blocks of numbers; memory does not grow with the file
//! ```
//!
//! | file | subject |
//! |---|---|
//! | `text.rs` | gzip, byte order marks, UTF-16, Latin-1 |
//! | `dialect.rs`, `heading.rs` | delimiter, decimal mark, remarks, names, units |
//! | `number.rs` | decimal numbers from bytes |
//! | `delimited.rs` | a table of text in blocks |
//! | `columnar.rs` | Parquet in blocks |
//! | `clock.rs` | times of rows; stretches between gaps |
//!
//! Deliberately absent: what the columns mean (`wire`, `reduce`), opening files (`cli`).

mod clock;
#[cfg_attr(not(feature = "parquet"), path = "columnar_absent.rs")]
mod columnar;
mod delimited;
mod dialect;
mod heading;
mod number;
mod text;

pub use clock::{Clock, Gap, Stretch};
pub use columnar::Columnar;
pub use delimited::Delimited;
pub use dialect::Dialect;
pub use heading::title;
pub use text::table_text;

use crate::error::{Fault, Malformed, Result};
use std::io::{Read, Seek};

/// A column as the file titles it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Name without the unit.
    pub name: String,
    /// The whole title.
    pub title: String,
    /// Unit in the title's brackets, or in a line of its own.
    pub unit: Option<String>,
}

impl Column {
    pub(super) fn titled(text: &str) -> Self {
        let (name, unit) = title(text);
        Column { name, title: text.trim().to_string(), unit }
    }
}

/// Rows of the selected columns; what is absent is NaN.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Block {
    /// One list for each selected column, all of the same length. A column of labels holds their numbers (see [`Record::labels`]).
    pub columns: Vec<Vec<f64>>,
}

impl Block {
    /// How many rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }
}

/// What a column is read as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum As {
    /// Numbers.
    Number,
    /// Labels, numbered in the order in which they first stand in the file.
    Label,
    /// Numbers; a cell that is none is [`UNREADABLE`] instead of a fault.
    Cell,
}

/// A NaN that stands for a cell which is neither a number nor empty.
pub const UNREADABLE: f64 = f64::from_bits(0x7FF8_0000_00C0_FFEE);

/// An open record.
#[derive(Debug)]
pub enum Record {
    /// A table of text.
    Delimited(Delimited),
    /// Parquet.
    Columnar(Columnar),
}

impl Record {
    /// Open a record by its first bytes, whatever its name says; `name` is for messages.
    ///
    /// Errors: an empty file, a format that is not read (named), a table without rows that are parted alike.
    pub fn open(name: &str, file: std::fs::File) -> Result<Self> {
        Record::opened(name, file, Delimited::open)
    }

    /// The same where the first line of a table of text is known to name the columns.
    pub fn open_titled(name: &str, file: std::fs::File) -> Result<Self> {
        Record::opened(name, file, Delimited::open_titled)
    }

    fn opened(
        name: &str,
        mut file: std::fs::File,
        text: impl Fn(&str, Box<dyn Read + Send>) -> Result<Delimited>,
    ) -> Result<Self> {
        let mut first = [0_u8; 8];
        let read = file.read(&mut first).map_err(|error| self::text::broken(name, &error))?;
        let first = first.get(..read).unwrap_or_default();
        if first.starts_with(b"PAR1") {
            return Columnar::open(name, file).map(Record::Columnar);
        }
        if let Some(format) = unread(first) {
            return Err(Malformed::new(Fault::Syntax, format!("'{name}' is {format}"))
                .expected("CSV (also with semicolons, tabs or spaces; gzip), or Parquet")
                .in_file(name));
        }
        // what cannot be rewound (a pipe) is read on from behind its first bytes
        let stream: Box<dyn Read + Send> = match file.rewind() {
            Ok(()) => Box::new(file),
            Err(_) => Box::new(std::io::Cursor::new(first.to_vec()).chain(file)),
        };
        text(name, stream).map(Record::Delimited)
    }

    /// Its columns.
    pub fn columns(&self) -> &[Column] {
        match self {
            Record::Delimited(table) => &table.dialect().columns,
            Record::Columnar(table) => table.columns(),
        }
    }

    /// The place of a column by its name or whole title.
    ///
    /// Errors: `UnknownName`, with the columns found.
    pub fn find(&self, name: &str) -> Result<usize> {
        find(self.columns(), name).ok_or_else(|| {
            Malformed::new(Fault::UnknownName, format!("the record has no column '{name}'"))
                .expected(format!("one of {}", listed(self.columns())))
                .found(format!("'{name}'"))
                .in_file(self.name())
        })
    }

    /// Which columns the blocks have, in this order. To be called once, before the first block.
    pub fn select(&mut self, columns: &[(usize, As)]) {
        match self {
            Record::Delimited(table) => table.select(columns),
            Record::Columnar(table) => table.select(columns),
        }
    }

    /// The next rows into `block` (what it held is gone); `false` at the end.
    ///
    /// Errors: cells that are no numbers, rows of another length, a file that was cut off; with line and column.
    pub fn next(&mut self, block: &mut Block) -> Result<bool> {
        match self {
            Record::Delimited(table) => table.next(block),
            Record::Columnar(table) => table.next(block),
        }
    }

    /// The labels met so far, by number.
    pub fn labels(&self) -> &[String] {
        match self {
            Record::Delimited(table) => table.labels(),
            Record::Columnar(table) => table.labels(),
        }
    }

    /// How many rows it has, where the file says so.
    pub fn rows(&self) -> Option<u64> {
        match self {
            Record::Delimited(_) => None,
            Record::Columnar(table) => Some(table.rows()),
        }
    }

    /// The file's name.
    pub fn name(&self) -> &str {
        match self {
            Record::Delimited(table) => table.name(),
            Record::Columnar(table) => table.name(),
        }
    }
}

/// Place of a column by its whole title, else by its name, else by its name without regard to case.
pub fn find(columns: &[Column], name: &str) -> Option<usize> {
    let by = |same: &dyn Fn(&Column) -> bool| columns.iter().position(same);
    by(&|c| c.title == name).or_else(|| by(&|c| c.name == name)).or_else(|| {
        let alike = |c: &Column| c.name.eq_ignore_ascii_case(name);
        by(&alike).filter(|_| columns.iter().filter(|c| alike(c)).count() == 1)
    })
}

/// Titles of columns for a message, the first thirty.
pub fn listed(columns: &[Column]) -> String {
    let mut titles: Vec<&str> = columns.iter().map(|c| c.title.as_str()).take(30).collect();
    if columns.len() > titles.len() {
        titles.push("...");
    }
    titles.join(", ")
}

/// Labels with their numbers.
#[derive(Debug, Default)]
struct Labels {
    texts: Vec<String>,
    numbers: std::collections::HashMap<String, usize>,
    last: Option<(Vec<u8>, f64)>,
}

impl Labels {
    fn number(&mut self, cell: &[u8]) -> f64 {
        if let Some((text, number)) = &self.last
            && text == cell
        {
            return *number;
        }
        let text = text::decoded(cell);
        let next = self.texts.len();
        let number = *self.numbers.entry(text.clone()).or_insert(next);
        if number == next {
            self.texts.push(text);
        }
        self.last = Some((cell.to_vec(), number as f64));
        number as f64
    }
}

/// The name of a format that is recognised and not read.
fn unread(first: &[u8]) -> Option<&'static str> {
    match first {
        [] => Some("empty"),
        [b'P', b'K', 3, 4, ..] => Some("a ZIP archive (an Excel workbook? save the sheet as CSV)"),
        [0x89, b'H', b'D', b'F', ..] => Some("an HDF5 file (or a MATLAB file of version 7.3)"),
        [b'M', b'A', b'T', b'L', b'A', b'B', ..] => Some("a MATLAB file"),
        [0x89, b'M', b'C', b'A', b'P', ..] => Some("an MCAP log"),
        [0xD0, 0xCF, 0x11, 0xE0, ..] => Some("an old Excel workbook"),
        [0x28, 0xB5, 0x2F, 0xFD, ..] => Some("compressed by zstd"),
        _ => None,
    }
}
