//! Records: tables of samples as loggers and spreadsheets write them, in blocks of columns.
//!
//! ```text
//! file (text in its dialects, Parquet, workbook, MATLAB, NumPy, HDF5, MCAP) -> columns by name -> blocks of numbers
//! ```
//!
//! Memory does not grow with a file of text or Parquet; of the others the table that is read is held.
//!
//! | file | subject |
//! |---|---|
//! | `text.rs` | gzip, byte order marks, UTF-16, Latin-1 |
//! | `dialect.rs`, `heading.rs` | delimiter, decimal mark, remarks, names, units |
//! | `number.rs` | decimal numbers from bytes |
//! | `delimited.rs` | a table of text in blocks |
//! | `columnar.rs` | Parquet in blocks |
//! | `columnar_arrow.rs` | what Arrow says of Parquet's columns: durations |
//! | `columnar_labels.rs` | texts of a Parquet column as numbers of labels |
//! | `workbook.rs` | sheets of Excel and OpenDocument workbooks (feature `excel`) |
//! | `matlab.rs`, `unpacked.rs`, `hdf5.rs` | MATLAB files of levels 4 and 5; HDF5, and with it level 7.3 (feature `hdf5`) |
//! | `npy.rs` | arrays of NumPy |
//! | `mcap.rs`, `bag.rs` | logs of robots, MCAP and bags of ROS 1: messages `sensor_msgs/Imu` (feature `mcap`) |
//! | `ulog.rs` | logs of PX4 |
//! | `guard.rs` | panics of foreign readers |
//! | `held.rs` | a table in memory, and which of a file's tables is meant |
//! | `times.rs` | times as people write them |
//! | `clock.rs` | times of rows; stretches between gaps |
//! | `clock_from.rs` | which column has the times |
//!
//! Deliberately absent: what the columns mean (`wire`, `reduce`).

#[cfg(feature = "mcap")]
mod bag;
mod clock;
mod clock_from;
#[cfg(feature = "parquet")]
mod columnar;
#[cfg(feature = "parquet")]
mod columnar_arrow;
#[cfg(feature = "parquet")]
mod columnar_labels;
mod delimited;
mod dialect;
#[cfg(any(feature = "excel", feature = "hdf5", feature = "parquet"))]
mod guard;
#[cfg(feature = "hdf5")]
mod hdf5;
mod heading;
mod held;
mod matlab;
#[cfg(feature = "mcap")]
mod mcap;
mod npy;
mod number;
mod text;
mod times;
mod ulog;
mod unpacked;
#[cfg(feature = "excel")]
mod workbook;

#[cfg(feature = "cli")]
pub(crate) use clock::Stretch;
pub(crate) use clock::{Clock, Counter, Jump, JumpKind, unit_of};
pub use clock_from::ClockFrom;
#[cfg(feature = "cli")]
pub(crate) use clock_from::{FIRST as FIRST_VALUES, even, times_of};
pub use heading::title;
pub use held::{Cells, Held};
pub(crate) use text::table_text;
pub(crate) use times::WrittenTimes;

#[cfg(feature = "parquet")]
use columnar::Columnar;
#[cfg(feature = "cli")]
pub(crate) use columnar::decimal;
use delimited::Delimited;
use dialect::Dialect;

use crate::elements::{Parts, first_odd};
use crate::error::{Fault, Malformed, Result};
use crate::units::{self, Unit};
use std::fs::File;
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};

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
    pub(crate) fn titled(text: &str) -> Self {
        let (name, unit) = title(text);
        Column { name, title: text.trim().to_string(), unit }
    }

    /// The title's unit, or else what its end says (`U_uV`, `Rate rpm`, `V, mV`); of a unit that is wanted, only what converts to it, and the whole title as well (`mV`).
    pub(crate) fn unit_for(&self, wanted: Option<&Unit>) -> Option<String> {
        let end = || units::of_column(&self.title.replace([' ', '.'], "_"));
        let Some(wanted) = wanted else { return self.unit.clone().or_else(end) };
        let fits = |unit: &String| wanted.is_said_by(unit);
        // the last word may be a quotient (`Rate deg/s`), the whole title a unit
        let last = || self.title.rsplit(' ').next().map(str::to_string).filter(fits);
        // a ratio (`mV/V`) is no quantity over its unit where it is wanted itself
        let ratio = || Some(self.title.clone()).filter(|title| title.contains('/') && fits(title));
        let over = || self.quotient().map(|(_, unit)| unit.to_string()).filter(fits);
        ratio().or_else(|| self.unit.clone()).or_else(|| last().or_else(over).or_else(|| end().filter(fits)))
    }

    /// Symbol and unit of a title that may be a quantity over its unit (ISO 80000-1), or else a unit itself: `T/K`, `A/mV`.
    pub(crate) fn quotient(&self) -> Option<(&str, &str)> {
        let (symbol, unit) = self.title.split_once('/')?;
        let (symbol, unit) = (symbol.trim(), unit.trim());
        (self.unit.is_none() && !symbol.is_empty() && Unit::parse(unit).is_ok()).then_some((symbol, unit))
    }
}

/// Rows of the selected columns; what is absent is NaN.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Block {
    /// One list for each selected column, all of the same length. A column of labels holds their numbers (see [`Record::labels`]).
    pub columns: Vec<Vec<f64>>,
    /// Lines of a table of text in which the rows begin; empty unless a column is read as [`As::Mixed`] or [`As::Cell`].
    pub lines: Vec<u64>,
    /// Cells of columns that are read as [`As::Written`].
    pub written: Written,
}

/// Cells as a table of text has them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Written {
    bytes: Vec<u8>,
    ends: Vec<usize>,
}

impl Written {
    /// A cell by its number.
    pub(crate) fn cell(&self, number: f64) -> &[u8] {
        let end = |k: usize| self.ends.get(k).copied();
        let place = crate::number::count(number);
        let start = place.checked_sub(1).and_then(end).unwrap_or(0);
        end(place).and_then(|end| self.bytes.get(start..end)).unwrap_or_default()
    }

    fn push(&mut self, cell: impl Iterator<Item = u8>) -> f64 {
        self.bytes.extend(cell);
        self.ends.push(self.bytes.len());
        (self.ends.len() - 1) as f64
    }

    fn clear(&mut self) {
        self.bytes.clear();
        self.ends.clear();
    }
}

impl Block {
    /// Without rows, for so many columns.
    fn clear(&mut self, columns: usize) {
        self.columns.resize_with(columns, Vec::new);
        self.columns.iter_mut().for_each(Vec::clear);
        self.lines.clear();
        self.written.clear();
    }

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
    /// Numbers; a cell that is none is [`UNREADABLE`] instead of a fault, and so are the numbers of a row with too many or too few cells,
    /// `RAGGED`. A table of text says the lines of its rows with them.
    Cell,
    /// Numbers, or times as people write them in seconds since 1970.
    Time,
    /// Numbers and labels, see [`said`]; a table of text says the lines of its rows with them.
    Mixed,
    /// Numbers of cells in [`Block::written`], which a table of text has, and Parquet of whole numbers of 64 bits: their digits. Of others labels.
    Written,
}

/// What a cell says that is read as [`As::Mixed`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Said {
    /// A number.
    Number(f64),
    /// Nothing.
    Nothing,
    /// A text, by its number among the labels.
    Text(usize),
}

/// The upper half of a NaN whose lower half is the number of a label.
const TEXT: u64 = 0x7FF8_0001;

/// What a cell says that was read as [`As::Mixed`].
pub fn said(cell: f64) -> Said {
    match cell.to_bits() {
        bits if bits >> 32 == TEXT => Said::Text(crate::number::index(bits & 0xFFFF_FFFF)),
        _ if cell.is_nan() => Said::Nothing,
        _ => Said::Number(cell),
    }
}

/// A cell with a text, by the number of its label.
fn text_cell(label: f64) -> f64 {
    f64::from_bits((TEXT << 32) | (crate::number::count_u64(label) & 0xFFFF_FFFF))
}

/// A NaN that stands for a cell which is neither a number nor empty.
pub const UNREADABLE: f64 = f64::from_bits(0x7FF8_0000_00C0_FFEE);

/// A NaN that stands for a number of a row which has another number of cells than the table has columns.
pub(crate) const RAGGED: f64 = f64::from_bits(0x7FF8_0000_00C0_11ED);

/// An open record.
pub struct Record(Source);

impl std::fmt::Debug for Record {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Record").field(self.head()).finish()
    }
}

enum Source {
    Text(Delimited),
    #[cfg(feature = "parquet")]
    Parquet(Columnar),
    Held(Held),
}

/// What a record of any format has.
#[derive(Debug, Clone, Default)]
struct Head {
    name: String,
    columns: Vec<Column>,
    labels: Labels,
    /// Are the labels forgotten as soon as their numbers are no longer needed?
    #[allow(dead_code, reason = "Parquet alone reads it")]
    forgets: bool,
    times: times::Times,
}

impl Head {
    fn new(name: &str, columns: Vec<Column>) -> Self {
        Head { name: name.into(), columns, ..Head::default() }
    }
}

impl From<Held> for Record {
    fn from(held: Held) -> Self {
        Record(Source::Held(held))
    }
}

/// Where the cell of a column stands in a line of a table of text: its first character, from 1, and how many it has. `None` where the text is no such table.
#[cfg(feature = "cli")]
pub(crate) fn cell_of(text: &str, line: usize, column: &str) -> Option<(usize, usize)> {
    let bytes = text.as_bytes();
    let dialect = Dialect::of(bytes.get(..delimited::HEAD).unwrap_or(bytes)).ok()?;
    let place = dialect.columns.iter().position(|other| other.title == column || other.name == column)?;
    let line = text.lines().nth(line.checked_sub(1)?)?;
    let (_, place) = dialect::cell_place(line.as_bytes(), dialect.delimiter, place)?;
    Some(place).filter(|(_, width)| *width > 0)
}

impl Record {
    /// Refuse numbers of a column that no sum of squares can hold.
    pub(crate) fn squarable(&self, column: &str, values: &[f64]) -> Result<()> {
        let is_large = |value: f64| value.is_finite() & (value.abs() > crate::number::MOST);
        match first_odd(values, is_large).and_then(|k| values.get(k)) {
            None => Ok(()),
            Some(value) => {
                Err(Malformed::new(Fault::Value, format!("a value of '{column}' is too large to be squared"))
                    .expected("units in which it lies below 1e70")
                    .found(format!("{value:e}"))
                    .in_file(self.name()))
            }
        }
    }

    /// Open a record by its first bytes, whatever its name says; `name` is for messages.
    ///
    /// Errors: an empty file, a format that is not read (named), a table without rows that are parted alike.
    pub fn open(name: &str, mut file: File) -> Result<Self> {
        let mut first = [0_u8; FIRST];
        let read = file.read(&mut first).map_err(|error| self::text::broken(name, &error))?;
        let first = first.part(..read);
        match Format::of(first) {
            #[cfg(feature = "parquet")]
            Format::Parquet => return Columnar::open(name, file).map(|table| Record(Source::Parquet(table))),
            Format::Text => {}
            other => {
                return Err(Malformed::new(Fault::Syntax, format!("'{name}' is {}", other.name()))
                    .expected("CSV (also with semicolons, tabs or spaces; gzip), Parquet, a workbook, MATLAB, NumPy, HDF5, MCAP, a bag of ROS 1 or a ULog, in a file")
                    .in_file(name));
            }
        }
        // what cannot be rewound (a pipe) is read on from behind its first bytes
        let stream: Box<dyn Read + Send> = match file.rewind() {
            Ok(()) => Box::new(file),
            Err(_) => Box::new(std::io::Cursor::new(first.to_vec()).chain(file)),
        };
        Record::of_stream(name, stream)
    }

    /// Open the record at a path; `FILE#NAME` is the table `NAME` of a file that has several: a sheet, a variable, a group, a topic.
    ///
    /// Errors: a file that cannot be read, several tables and none named, and those of [`Record::open`].
    pub fn at(path: &Path) -> Result<Self> {
        let (path, table) = parted(path);
        let (name, table) = (path.display().to_string(), table.as_deref());
        let mut file = opened(&path)?;
        let mut first = Vec::new();
        let whole = |file: &mut File| {
            let mut bytes = Vec::new();
            file.rewind().and_then(|()| file.read_to_end(&mut bytes)).map(|_| bytes)
        };
        let format = match file.metadata().is_ok_and(|there| there.is_file()) {
            true => {
                let read = file.by_ref().take(FIRST as u64).read_to_end(&mut first);
                read.and_then(|_| file.rewind()).map_err(|error| self::text::broken(&name, &error))?;
                Format::of(&first)
            }
            // a pipe has one table, and its first bytes can be read once only
            false => Format::Text,
        };
        let unread = |error: std::io::Error| self::text::broken(&name, &error);
        match (format, table) {
            (Format::Text | Format::Parquet | Format::Unread(_), None) => Record::open(&name, file),
            (Format::Text | Format::Parquet | Format::Npy | Format::Unread(_), Some(table)) => {
                Err(Malformed::new(Fault::File, format!("'{name}' is one table, and has none by name"))
                    .expected("the file's name without '#' and what follows it")
                    .found(format!("'#{table}'"))
                    .in_file(name))
            }
            (Format::Matlab, table) => matlab::open(&name, &whole(&mut file).map_err(unread)?, table).map(Record::from),
            (Format::Npy, None) => npy::open(&name, &whole(&mut file).map_err(unread)?).map(Record::from),
            (Format::Ulog, table) => ulog::open(&name, &whole(&mut file).map_err(unread)?, table).map(Record::from),
            #[cfg(feature = "excel")]
            (Format::Workbook, table) => {
                workbook::open(&name, whole(&mut file).map_err(unread)?, table).map(|table| Record(Source::Text(table)))
            }
            #[cfg(feature = "hdf5")]
            (Format::Hdf5, table) => hdf5::open(&name, &path, table).map(Record::from),
            #[cfg(feature = "mcap")]
            (Format::Mcap, table) => mcap::open(&name, std::io::BufReader::new(file), table).map(Record::from),
            #[cfg(feature = "mcap")]
            (Format::Bag, table) => bag::open(&name, std::io::BufReader::new(file), table).map(Record::from),
            #[allow(unreachable_patterns, reason = "a program without some of the features")]
            (other, _) => Err(Malformed::new(Fault::File, format!("'{name}' is {}", other.name()))
                .expected("a format that this program was built for (Cargo features excel, hdf5, mcap, parquet)")
                .in_file(name)),
        }
    }

    /// A table of text.
    ///
    /// Errors: those of [`Record::open`].
    pub fn of_text(name: &str, text: impl Into<Vec<u8>>) -> Result<Self> {
        Record::of_stream(name, std::io::Cursor::new(text.into()))
    }

    /// The same of a stream, which is read as its rows are asked for.
    pub fn of_stream(name: &str, from: impl Read + Send + 'static) -> Result<Self> {
        Delimited::open(name, from).map(|table| Record(Source::Text(table)))
    }

    fn head(&self) -> &Head {
        match &self.0 {
            Source::Text(table) => &table.head,
            #[cfg(feature = "parquet")]
            Source::Parquet(table) => &table.head,
            Source::Held(table) => &table.head,
        }
    }

    /// The table, where it is one of text.
    #[allow(dead_code, reason = "some features alone use it")]
    fn text(&self) -> Option<&Delimited> {
        if let Source::Text(table) = &self.0 { Some(table) } else { None }
    }

    /// Its columns.
    pub fn columns(&self) -> &[Column] {
        &self.head().columns
    }

    /// Is it a table of text?
    #[cfg(feature = "cli")]
    pub(crate) fn is_of_text(&self) -> bool {
        self.text().is_some()
    }

    /// Have the columns names of their own?
    pub(crate) fn is_named(&self) -> bool {
        self.text().is_none_or(|table| table.dialect.named)
    }

    /// The line of the titles, from 1.
    #[cfg(feature = "navigate")]
    pub(crate) fn title_line(&self) -> usize {
        self.text().map_or(1, |table| table.dialect.titled)
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
        match &mut self.0 {
            Source::Text(table) => table.select(columns),
            #[cfg(feature = "parquet")]
            Source::Parquet(table) => table.select(columns),
            Source::Held(table) => table.select(columns),
        }
    }

    /// The next rows into `block` (what it held is gone); `false` at the end.
    ///
    /// Errors: cells that are no numbers, rows of another length, a file that was cut off; with line and column.
    pub fn next(&mut self, block: &mut Block) -> Result<bool> {
        crate::stop::poll();
        match &mut self.0 {
            Source::Text(table) => table.next(block),
            #[cfg(feature = "parquet")]
            Source::Parquet(table) => table.next(block),
            Source::Held(table) => table.next(block),
        }
    }

    /// The rows of further lines, of a table of text that grows somewhere else: nothing is read from where this one was opened.
    ///
    /// Errors: those of [`Record::next`].
    #[cfg(feature = "cli")]
    pub(crate) fn lines(&mut self, text: &[u8], block: &mut Block) -> Result<()> {
        match &mut self.0 {
            Source::Text(table) => table.lines(text, block),
            // its rows are all there
            _ => Ok(()),
        }
    }

    /// The labels met so far, by number.
    pub fn labels(&self) -> &[String] {
        &self.head().labels.texts
    }

    /// Forget the labels, where their numbers are no longer needed: those of the next block begin anew where the format allows it.
    pub(crate) fn forget_labels(&mut self) {
        match &mut self.0 {
            Source::Text(table) => table.head.labels = Labels::default(),
            // dictionaries have their numbers until the next row group begins
            #[cfg(feature = "parquet")]
            Source::Parquet(table) => table.head.forgets = true,
            // it is held whole as it is
            Source::Held(_) => {}
        }
    }

    /// Numbers of labels that stand in a table of text with different blanks around them: it reads them as one.
    pub(crate) fn blanks_differ(&self) -> &[usize] {
        &self.head().labels.blanks_differ
    }

    /// Does a column hold texts, no numbers? Of a table of text as its first rows have it.
    pub(crate) fn is_text(&self, column: usize) -> bool {
        match &self.0 {
            Source::Text(table) => table.dialect.texts.get(column) == Some(&true),
            #[cfg(feature = "parquet")]
            Source::Parquet(table) => table.is_text(column),
            Source::Held(table) => table.is_text(column),
        }
    }

    /// What a reader should know of how numbers are taken.
    #[cfg(feature = "cli")]
    pub(crate) fn doubt(&self) -> Option<&str> {
        self.text().and_then(|table| table.dialect.doubt.as_deref())
    }

    /// A cell of a column of texts that begins as a number does.
    #[cfg(feature = "cli")]
    pub(crate) fn unread(&self, column: usize) -> Option<&str> {
        self.text().filter(|_| self.is_text(column)).and_then(|table| table.dialect.unread.get(column)?.as_deref())
    }

    /// Does a column hold times by its type, which are numbers of seconds since 1970 or of a day?
    #[cfg(feature = "cli")]
    pub(crate) fn is_of_times(&self, column: usize) -> bool {
        if let Source::Parquet(table) = &self.0 { table.is_of_times(column) } else { false }
    }

    /// The first values of a column, as a table that is open has them before it is read on; NaN where a cell is no number.
    fn first_values(&self, column: usize) -> Vec<f64> {
        match &self.0 {
            Source::Text(table) => table.dialect.firsts.get(column).cloned().unwrap_or_default(), // no such column
            #[cfg(feature = "parquet")]
            Source::Parquet(table) => table.first_values(column),
            Source::Held(table) => table.first_values(column),
        }
    }

    /// Of a column of whole numbers of 64 bits, of which doubles keep 53: the decimal places of the unit that it is read in, and its type.
    #[cfg(feature = "cli")]
    pub(crate) fn whole(&self, column: usize) -> Option<(i32, Option<parquet::basic::LogicalType>)> {
        if let Source::Parquet(table) = &self.0 { table.whole(column) } else { None }
    }

    /// How many rows it has, where the file says so.
    pub fn rows(&self) -> Option<u64> {
        match &self.0 {
            Source::Text(_) => None,
            #[cfg(feature = "parquet")]
            Source::Parquet(table) => Some(table.rows()),
            Source::Held(table) => Some(table.rows()),
        }
    }

    /// The file's name.
    pub fn name(&self) -> &str {
        &self.head().name
    }
}

/// A file, and the name of one of its tables behind a `#`; a file that has the whole name comes first.
pub(crate) fn parted(path: &Path) -> (PathBuf, Option<String>) {
    let text = path.to_string_lossy();
    match text.rsplit_once('#') {
        Some((file, table)) if !file.is_empty() && !path.exists() && Path::new(file).exists() => {
            (PathBuf::from(file), Some(table.to_string()))
        }
        _ => (path.to_path_buf(), None),
    }
}

/// Open a file to read.
fn opened(path: &Path) -> Result<File> {
    let name = path.display();
    if path.is_dir() {
        return Err(Malformed::new(Fault::File, format!("'{name}' is a folder"))
            .expected("a file")
            .in_file(name.to_string()));
    }
    File::open(path).map_err(|error| {
        Malformed::new(Fault::File, format!("cannot read '{name}': {error}")).expected("a readable file")
    })
}

/// Place of a column by its whole title, else by its name, else by its name without regard to case.
pub(crate) fn find(columns: &[Column], name: &str) -> Option<usize> {
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
#[derive(Debug, Clone, Default)]
struct Labels {
    texts: Vec<String>,
    /// By their bytes.
    numbers: std::collections::HashMap<Vec<u8>, usize, std::hash::BuildHasherDefault<crate::mix::Mix>>,
    /// Blanks before and behind each label where it was met first.
    blanks: Vec<[usize; 2]>,
    /// Labels that were met with others.
    blanks_differ: Vec<usize>,
}

impl Labels {
    /// The number of a cell as it stands, blanks around it included, which are no part of the label.
    fn trimmed(&mut self, cell: &[u8]) -> f64 {
        let (from, label) = (cell.trim_ascii_start(), cell.trim_ascii());
        let number = self.number(label);
        let (place, blanks) = (crate::number::count(number), [cell.len() - from.len(), from.len() - label.len()]);
        self.blanks.resize(self.blanks.len().max(self.texts.len()), blanks);
        if self.blanks.get(place).is_some_and(|first| *first != blanks) && !self.blanks_differ.contains(&place) {
            self.blanks_differ.push(place);
        }
        number
    }

    /// A number, or else a text; a word that says that nothing was read is a text.
    fn mixed(&mut self, cell: &[u8], mark: u8) -> f64 {
        match number::number(cell, mark) {
            _ if cell.is_empty() => f64::NAN,
            Some(value) if !value.is_nan() => value,
            _ => text_cell(self.number(cell)),
        }
    }

    fn number(&mut self, cell: &[u8]) -> f64 {
        if let Some(number) = self.numbers.get(cell) {
            return *number as f64;
        }
        // the same text may stand in another encoding
        let text = text::decoded(cell);
        let next = self.texts.len();
        let number = *self.numbers.entry(text.clone().into_bytes()).or_insert(next);
        if number == next {
            self.texts.push(text);
        }
        number as f64
    }
}

/// Bytes that a format is told by.
const FIRST: usize = matlab::HEAD_4;

/// Formats by their first bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Text,
    Parquet,
    Workbook,
    Matlab,
    Npy,
    Hdf5,
    Mcap,
    Bag,
    Ulog,
    /// Recognised and not read; its name.
    Unread(&'static str),
}

impl Format {
    fn of(first: &[u8]) -> Self {
        match first {
            [] => Format::Unread("empty"),
            [b'P', b'A', b'R', b'1', ..] => Format::Parquet,
            [b'A', b'R', b'R', b'O', b'W', b'1', ..] | [b'F', b'E', b'A', b'1', ..] => {
                Format::Unread("an Arrow (Feather) file, which is saved as Parquet instead")
            }
            [b'{', ..] | [b'[', b'{', ..] => Format::Unread("JSON, which is saved as CSV or Parquet instead"),
            // .xlsx, .xlsb and .ods are archives; .xls is a compound file
            [b'P', b'K', 3, 4, ..] | [0xD0, 0xCF, 0x11, 0xE0, ..] => Format::Workbook,
            // level 7.3 is HDF5 behind 512 bytes of its own
            [0x89, b'H', b'D', b'F', ..] | [b'M', b'A', b'T', b'L', b'A', b'B', b' ', b'7', ..] => Format::Hdf5,
            [b'M', b'A', b'T', b'L', b'A', b'B', ..] => Format::Matlab,
            [0x89, b'M', b'C', b'A', b'P', ..] => Format::Mcap,
            [0x28, 0xB5, 0x2F, 0xFD, ..] => Format::Unread("compressed by zstd"),
            [b'#', b'R', b'O', b'S', b'B', b'A', b'G', ..] => Format::Bag,
            [b'S', b'Q', b'L', b'i', b't', b'e', b' ', b'f', ..] => {
                Format::Unread("an SQLite database (a rosbag2 .db3?), which `ros2 bag convert` makes an MCAP log of")
            }
            [b'U', b'L', b'o', b'g', 0x01, ..] => Format::Ulog,
            [b'T', b'D', b'S', b'm', ..] => Format::Unread("a TDMS file of LabVIEW, which is exported as CSV or HDF5"),
            [0xFD, b'7', b'z', b'X', b'Z', 0, ..] => Format::Unread("compressed by xz"),
            [b'B', b'Z', b'h', b'1'..=b'9', b'1', b'A', b'Y', b'&', ..] => Format::Unread("compressed by bzip2"),
            [b'C', b'D', b'F', 1 | 2 | 5, ..] => {
                Format::Unread("a NetCDF file of the classic format, which `nccopy -k netCDF-4` makes an HDF5 file of")
            }
            [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => Format::Npy,
            first if matlab::is_level_4(first) => Format::Matlab,
            _ => Format::Text,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Format::Text => "a table of text",
            Format::Parquet => "Parquet",
            Format::Workbook => "a workbook (.xlsx, .xls, .ods), or another archive",
            Format::Matlab => "a MATLAB file",
            Format::Npy => "an array of NumPy",
            Format::Hdf5 => "an HDF5 file (or a MATLAB file of level 7.3)",
            Format::Mcap => "an MCAP log",
            Format::Bag => "a bag of ROS 1",
            Format::Ulog => "a ULog of PX4",
            Format::Unread(name) => name,
        }
    }
}
