//! A table that is held in memory, in blocks; and which of a file's tables is meant.

use super::clock_from::FIRST;
use super::times::{Times, WrittenTimes};
use super::{As, Block, Column, Head, Labels, UNREADABLE};
use crate::elements::Parts;
use crate::error::{Fault, Malformed, Result};
use std::collections::HashMap;
use std::sync::Arc;

/// Rows of a block.
const ROWS: usize = 1 << 16;
/// A table with less than this share of the rows of the longest is taken only by its name.
pub(super) const SHORT: usize = 10;
/// Most tables that a message lists.
const LISTED: usize = 12;

/// A numeric column of a file, and its values.
pub(super) type Numbers = (Column, Vec<f64>);

/// One of a file's tables.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Sheet {
    /// Its name within the file.
    pub name: String,
    /// Its columns, all of one length.
    pub columns: Vec<Numbers>,
}

impl Sheet {
    fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, values)| values.len())
    }

    fn told(&self) -> String {
        let titles: Vec<&str> = self.columns.iter().map(|(column, _)| column.title.as_str()).take(8).collect();
        let more = if self.columns.len() > titles.len() { ", ..." } else { "" };
        format!("'{}' ({} rows: {}{more})", self.name, self.rows(), titles.join(", "))
    }
}

/// The cells of a column in memory.
#[derive(Debug, Clone, PartialEq)]
pub enum Cells {
    /// Numbers; NaN where a cell is empty.
    Numbers(Vec<f64>),
    /// Texts; an empty one where a cell is empty.
    Texts(Vec<String>),
}

/// A table in memory; its clones share the cells.
#[derive(Debug, Clone)]
pub struct Held {
    pub(super) head: Head,
    values: Arc<[Cells]>,
    wanted: Vec<(usize, As)>,
    at: usize,
    /// The first time of columns of written times.
    since: HashMap<usize, WrittenTimes>,
}

impl Held {
    /// The table that is meant: the one that is named, or the only one that could be.
    ///
    /// `what` says what the file calls a table. Errors: no table, several, none of that name; with those found.
    pub(super) fn choose(name: &str, what: &str, sheets: Vec<Sheet>, wanted: Option<&str>) -> Result<Held> {
        let place = choose(name, what, &sheets, wanted)?;
        let sheet = sheets.into_iter().nth(place).unwrap_or_default();
        let columns = sheet.columns.into_iter().map(|(column, values)| (column, Cells::Numbers(values))).unzip();
        Held::with(name, columns)
    }

    /// A table from its columns, each with its title; a unit may stand in the title's brackets.
    ///
    /// Errors: columns of different lengths, a title that stands twice.
    ///
    /// ```
    /// use tumble::record::{As, Block, Cells, Held, Record};
    /// let table = vec![("unit".into(), Cells::Texts(vec!["A".into(), "A".into()])), ("V".into(), Cells::Numbers(vec![1.0, 2.0]))];
    /// let mut table = Record::from(Held::of("table", table)?);
    /// table.select(&[(1, As::Number), (0, As::Label)]);
    /// let mut block = Block::default();
    /// assert!(table.next(&mut block)? && block.columns == [[1.0, 2.0], [0.0, 0.0]] && table.labels() == ["A"]);
    /// # Ok::<(), tumble::error::Malformed>(())
    /// ```
    pub fn of(name: &str, columns: Vec<(String, Cells)>) -> Result<Held> {
        Held::with(name, columns.into_iter().map(|(title, cells)| (Column::titled(&title), cells)).unzip())
    }

    fn with(name: &str, (columns, values): (Vec<Column>, Vec<Cells>)) -> Result<Held> {
        let held = Held {
            head: Head::new(name, columns),
            values: values.into(),
            wanted: Vec::new(),
            at: 0,
            since: HashMap::new(),
        };
        let mut seen = std::collections::HashSet::new();
        for column in &held.head.columns {
            if !seen.insert(column.title.as_str()) {
                return Err(Malformed::new(Fault::NameClash, format!("the column '{}' stands twice", column.title))
                    .expected("each column once")
                    .in_file(name));
            }
        }
        let rows = held.rows();
        for (column, cells) in held.head.columns.iter().zip(&*held.values) {
            if cells.len() as u64 != rows {
                return Err(Malformed::new(Fault::Value, format!("the column '{}' has another length", column.title))
                    .expected(format!("{rows} cells, as the first column has"))
                    .found(cells.len().to_string())
                    .in_file(name));
            }
        }
        Ok(held)
    }

    /// Does a column hold texts, not numbers?
    pub(super) fn is_text(&self, column: usize) -> bool {
        matches!(self.values.get(column), Some(Cells::Texts(_)))
    }

    /// The first values of a column; NaN where a cell is no number.
    pub(super) fn first_values(&self, column: usize) -> Vec<f64> {
        let end = FIRST.min(crate::number::index(self.rows()));
        match self.values.get(column) {
            Some(Cells::Numbers(cells)) => cells.part(..end).to_vec(),
            Some(Cells::Texts(cells)) => {
                cells.part(..end).iter().map(|cell| cell.trim().parse().unwrap_or(f64::NAN)).collect()
            }
            None => Vec::new(),
        }
    }

    /// How many rows it has.
    pub(super) fn rows(&self) -> u64 {
        self.values.first().map_or(0, |cells| cells.len() as u64)
    }

    /// Which columns the blocks have.
    pub(super) fn select(&mut self, columns: &[(usize, As)]) {
        self.wanted = columns.to_vec();
    }

    /// The next rows.
    pub(super) fn next(&mut self, block: &mut Block) -> Result<bool> {
        block.clear(self.wanted.len());
        let end = (self.at + ROWS).min(crate::number::index(self.rows()));
        if self.at >= end || self.wanted.is_empty() {
            return Ok(false);
        }
        for ((column, kind), to) in self.wanted.iter().zip(&mut block.columns) {
            match self.values.get(*column) {
                Some(Cells::Numbers(cells)) => numbers(cells.part(self.at..end), *kind, to, &mut self.head.labels),
                Some(Cells::Texts(cells)) => {
                    let cells = cells.part(self.at..end);
                    let times = (&mut self.head.times, self.since.entry(*column).or_default());
                    texts(cells, *kind, to, &mut self.head.labels, times).map_err(|text| {
                        let title = self.head.columns.get(*column).map_or("", |column| column.title.as_str());
                        Malformed::new(Fault::Value, format!("a cell of the column '{title}' is not a number"))
                            .expected("a number")
                            .found(format!("'{text}'"))
                            .in_file(&self.head.name)
                    })?;
                }
                None => {}
            }
        }
        self.at = end;
        Ok(true)
    }
}

impl Cells {
    fn len(&self) -> usize {
        match self {
            Cells::Numbers(cells) => cells.len(),
            Cells::Texts(cells) => cells.len(),
        }
    }
}

fn numbers(cells: &[f64], kind: As, to: &mut Vec<f64>, labels: &mut Labels) {
    match kind {
        As::Number | As::Cell | As::Time | As::Mixed => to.extend_from_slice(cells),
        As::Label | As::Written => to.extend(cells.iter().map(|value| match value.is_nan() {
            true => f64::NAN,
            false => labels.number(value.to_string().as_bytes()),
        })),
    }
}

/// Errors: the first text that is no number, where numbers are wanted.
fn texts<'a>(
    cells: &'a [String],
    kind: As,
    to: &mut Vec<f64>,
    labels: &mut Labels,
    (times, since): (&mut Times, &mut WrittenTimes),
) -> std::result::Result<(), &'a str> {
    for text in cells {
        to.push(match (text.trim(), kind) {
            ("", _) => f64::NAN,
            (_, As::Label | As::Written) => labels.number(text.as_bytes()),
            (cell, As::Mixed) => labels.mixed(cell.as_bytes(), b'.'),
            // a written time since the first, as of a table of text
            (cell, As::Cell) => cell.parse().ok().or_else(|| since.since_first(cell)).unwrap_or(UNREADABLE),
            (cell, As::Number) => cell.parse().map_err(|_| text.as_str())?,
            (cell, As::Time) => cell.parse().ok().or_else(|| times.seconds(cell.as_bytes())).ok_or(text.as_str())?,
        });
    }
    Ok(())
}

fn choose(name: &str, what: &str, sheets: &[Sheet], wanted: Option<&str>) -> Result<usize> {
    let listed = |sheets: &mut dyn Iterator<Item = &Sheet>| {
        let all: Vec<String> = sheets.map(Sheet::told).collect();
        let more = if all.len() > LISTED { ", ..." } else { "" };
        format!("{}{more}", all.iter().take(LISTED).cloned().collect::<Vec<_>>().join(", "))
    };
    if let Some(wanted) = wanted {
        let bare = |text: &str| text.trim_matches('/').to_string();
        let place = sheets.iter().position(|sheet| sheet.name == wanted);
        return place.or_else(|| sheets.iter().position(|sheet| bare(&sheet.name) == bare(wanted))).ok_or_else(|| {
            Malformed::new(Fault::UnknownName, format!("'{name}' has no {what} '{wanted}' of numbers"))
                .expected("one of those found, behind a '#'")
                .found(if sheets.is_empty() { "none".to_string() } else { listed(&mut sheets.iter()) })
                .in_file(name)
        });
    }
    let longest = sheets.iter().map(Sheet::rows).max().unwrap_or(0);
    let mut candidates =
        sheets.iter().enumerate().filter(|(_, sheet)| sheet.rows() * SHORT >= longest && sheet.rows() > 1);
    match (candidates.next(), candidates.next()) {
        (Some((place, _)), None) => Ok(place),
        (Some((_, first)), Some(_)) => {
            Err(Malformed::new(Fault::Value, format!("'{name}' has more than one {what} that could be meant"))
                .expected(format!("one of them by its name: {name}#{}", first.name.trim_start_matches('/')))
                .found(listed(&mut sheets.iter()))
                .in_file(name))
        }
        _ => Err(Malformed::new(Fault::Missing, format!("'{name}' has no {what} of numbers"))
            .expected("columns of numbers, one row for each sample or reading")
            .found(if sheets.is_empty() { "none".to_string() } else { listed(&mut sheets.iter()) })
            .in_file(name)),
    }
}

/// An array of a file: values column by column.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Array {
    /// The group, struct or file that it stands in; empty for the file.
    pub group: String,
    /// Its name there.
    pub name: String,
    /// Its unit, where the file says one.
    pub unit: Option<String>,
    /// Rows and columns.
    pub shape: (usize, usize),
    /// Values, one column after the other.
    pub values: Vec<f64>,
}

/// Arrays as tables: in each group those of one length are one table; an array of several columns gives each a number, from 1.
///
/// An array lies down where its longer side does: samples are more than channels. Single numbers are no columns.
pub(super) fn tables(arrays: Vec<Array>) -> Vec<Sheet> {
    let mut groups: Vec<(String, Vec<Array>)> = Vec::new();
    for array in arrays {
        match groups.iter_mut().find(|(group, _)| *group == array.group) {
            Some((_, group)) => group.push(array),
            None => groups.push((array.group.clone(), vec![array])),
        }
    }
    let mut sheets = Vec::new();
    for (group, arrays) in groups {
        let mut lengths: Vec<usize> =
            arrays.iter().map(|array| array.shape.0.max(array.shape.1)).filter(|n| *n > 1).collect();
        lengths.sort_unstable_by(|a, b| b.cmp(a));
        lengths.dedup();
        for (k, length) in lengths.iter().enumerate() {
            let alike: Vec<&Array> =
                arrays.iter().filter(|array| array.shape.0.max(array.shape.1) == *length).collect();
            let path = |name: &str| if group.is_empty() { name.to_string() } else { format!("{group}/{name}") };
            let name = match (alike.as_slice(), k) {
                ([one], _) => path(&one.name),
                (_, 0) if !group.is_empty() => group.clone(),
                (several, _) => path(several.first().map_or("", |first| first.name.as_str())),
            };
            sheets.push(Sheet { name, columns: alike.into_iter().flat_map(|array| columns(array, *length)).collect() });
        }
    }
    sheets
}

fn columns(array: &Array, length: usize) -> Vec<Numbers> {
    let (rows, count) = array.shape;
    let upright = rows == length;
    let width = if upright { count } else { rows };
    let column = |k: usize| {
        let name = if width == 1 { array.name.clone() } else { format!("{}_{}", array.name, k + 1) };
        let values = match upright {
            // a matrix has rows times columns: `Array` is made of as many values
            true => array.values.get(k * length..(k + 1) * length).map(<[f64]>::to_vec).unwrap_or_default(),
            false => array.values.iter().skip(k).step_by(width.max(1)).copied().collect(),
        };
        (Column { title: name.clone(), name, unit: array.unit.clone() }, values)
    };
    (0..width).map(column).collect()
}
