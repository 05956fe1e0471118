//! Tables of a document: columns, rows and typed cells.

use super::number::{probability, rounded, significant};
use super::{Detail, Tone};
use crate::language::code;

/// A table.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    /// What it shows; may be empty.
    pub caption: String,
    /// Columns.
    pub columns: Vec<Column>,
    /// Rows; a row shorter than the columns ends in empty cells.
    pub rows: Vec<Row>,
    /// A remark under it; may be empty.
    pub note: String,
    /// Set small: for long tables.
    pub small: bool,
    /// So many rows at brief detail, and how many more there are; all where it is not said.
    pub brief_rows: Option<usize>,
}

/// A column.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Column {
    /// Title.
    pub title: String,
    /// Alignment.
    pub align: Align,
    /// At which detail it appears.
    pub detail: Detail,
}

/// Alignment of a column.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Align {
    /// Words, to the left.
    #[default]
    Left,
    /// To the right.
    Right,
    /// Numbers, at the decimal point.
    Decimal,
    /// Numbers from -1 to 1 as bars about a middle line.
    Bar,
}

/// A row.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Row {
    /// Cells.
    pub cells: Vec<Cell>,
    /// How it sounds.
    pub tone: Tone,
    /// Set off from the rows before it by a rule.
    pub rule: bool,
    /// Where its first cell leads; empty for nowhere.
    pub link: String,
}

/// One cell. A number carries what rounds it, so that every output writes it alike.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Text; a pair of backticks sets a name in code type.
    Text(String),
    /// A number, and the uncertainty that says where its digits end: U where it is given beside it, else u.
    Value(f64, Option<f64>),
    /// A number with so many significant digits.
    Digits(f64, i32),
    /// A number with so many decimals.
    Decimals(f64, usize),
    /// Degrees of freedom, which may be infinite.
    Dof(f64),
    /// A probability of a test.
    Probability(f64),
    /// A share, as a percentage.
    Share(f64),
    /// What does not exist.
    Absent,
}

impl Cell {
    /// A name in code type.
    pub fn name(name: impl AsRef<str>) -> Self {
        Cell::Text(code(name.as_ref()))
    }

    /// What does not exist.
    pub fn absent() -> Self {
        Cell::Absent
    }

    /// A value with as many digits as its uncertainty carries.
    pub fn value(value: Option<f64>, u: Option<f64>) -> Self {
        value.map_or_else(Cell::absent, |v| Cell::Value(v, u))
    }

    /// A number with so many significant digits.
    pub fn digits(value: Option<f64>, digits: i32) -> Self {
        value.map_or_else(Cell::absent, |v| Cell::Digits(v, digits))
    }

    /// A number with so many decimals.
    pub(crate) fn decimals(value: Option<f64>, decimals: usize) -> Self {
        value.map_or_else(Cell::absent, |v| Cell::Decimals(v, decimals))
    }

    /// Degrees of freedom: infinite where none are given for an uncertainty that exists.
    pub fn dof(dof: Option<f64>, known: bool) -> Self {
        match dof {
            None if known => Cell::Dof(f64::INFINITY),
            None => Cell::absent(),
            Some(dof) => Cell::Dof(dof),
        }
    }

    /// A probability of a test.
    pub fn p(p: Option<f64>) -> Self {
        p.map_or_else(Cell::absent, Cell::Probability)
    }

    /// Its text in ASCII signs, as a terminal and a program read it.
    ///
    /// ```
    /// use tumble::document::Cell;
    /// assert_eq!(Cell::value(Some(-162.0687), Some(0.5987)).text(), "-162.07");
    /// assert_eq!((Cell::Dof(14.0).text(), Cell::Dof(14.26).text()), ("14".into(), "14.3".into()));
    /// assert_eq!((Cell::dof(None, true).text(), Cell::absent().text()), ("inf".into(), "-".into()));
    /// ```
    pub fn text(&self) -> String {
        match self {
            Cell::Text(text) => text.clone(),
            Cell::Value(value, u) => rounded(*value, *u),
            Cell::Digits(value, digits) => significant(*value, *digits),
            Cell::Decimals(value, decimals) => format!("{value:.decimals$}"),
            Cell::Dof(dof) => super::number::dof(*dof),
            Cell::Probability(p) => probability(*p),
            Cell::Share(share) => format!("{:.1} %", 100.0 * share),
            Cell::Absent => "-".into(),
        }
    }

    /// Its text in the signs of a printed page.
    pub(crate) fn typeset(&self) -> String {
        match self {
            Cell::Text(text) => text.clone(),
            Cell::Dof(dof) if super::number::dof(*dof) == "inf" => "\u{221e}".into(),
            Cell::Absent => "\u{2013}".into(),
            number => match number.text() {
                text if text.starts_with('-') => text.replacen('-', "\u{2212}", 1),
                text => text,
            },
        }
    }
}

macro_rules! texts {
    ($($of:ty),*) => {
        $(impl From<$of> for Cell {
            fn from(of: $of) -> Self {
                Cell::Text(of.to_string())
            }
        })*
    };
}

texts!(String, &str, &String, usize, std::borrow::Cow<'_, str>);

impl<C: Into<Cell>> From<Option<C>> for Cell {
    fn from(value: Option<C>) -> Self {
        value.map_or_else(Cell::absent, Into::into)
    }
}

/// A table with a row for each item. A column is its title, how it stands, and its cell of an item.
///
/// ```
/// use tumble::document::{Cell, Detail, Rows, Table};
/// let rows = Rows::of([("V0", 1.58203), ("kI", 2.0)]).name("parameter", |(id, _)| id).decimal("estimate", |(_, v)| Cell::Digits(v, 3));
/// let table: Table = rows.right("k", |_| "2").at(Detail::Full).into();
/// assert_eq!(table.rows[0].cells[1].text(), "1.58");
/// ```
#[derive(Debug, Clone)]
pub struct Rows<T> {
    items: Vec<T>,
    table: Table,
}

impl<T: Copy> Rows<T> {
    /// A table of these items, without columns yet.
    pub fn of(items: impl IntoIterator<Item = T>) -> Self {
        let items: Vec<T> = items.into_iter().collect();
        let table = Table { rows: vec![Row::default(); items.len()], ..Table::default() };
        Rows { items, table }
    }

    /// A column.
    pub fn column<C: Into<Cell>>(mut self, title: impl Into<String>, align: Align, cell: impl Fn(T) -> C) -> Self {
        self.table.columns.push(Column { title: title.into(), align, detail: Detail::Brief });
        self.each(|row, item| row.cells.push(cell(item).into()))
    }

    /// A column of words.
    pub fn left<C: Into<Cell>>(self, title: impl Into<String>, cell: impl Fn(T) -> C) -> Self {
        self.column(title, Align::Left, cell)
    }

    /// A column of names in code type.
    pub fn name<C: AsRef<str>>(self, title: impl Into<String>, name: impl Fn(T) -> C) -> Self {
        self.column(title, Align::Left, |item| Cell::name(name(item)))
    }

    /// A column to the right.
    pub fn right<C: Into<Cell>>(self, title: impl Into<String>, cell: impl Fn(T) -> C) -> Self {
        self.column(title, Align::Right, cell)
    }

    /// A column of numbers, at the decimal point.
    pub fn decimal<C: Into<Cell>>(self, title: impl Into<String>, cell: impl Fn(T) -> C) -> Self {
        self.column(title, Align::Decimal, cell)
    }

    /// At which detail the last column appears.
    pub fn at(mut self, detail: Detail) -> Self {
        self.table.columns.last_mut().into_iter().for_each(|column| column.detail = detail);
        self
    }

    /// How each row sounds.
    pub(crate) fn tone(self, tone: impl Fn(T) -> Tone) -> Self {
        self.each(|row, item| row.tone = tone(item))
    }

    /// Which rows begin a group: a rule is set before them.
    pub(crate) fn rule(self, begins: impl Fn(T) -> bool) -> Self {
        self.each(|row, item| row.rule = begins(item))
    }

    /// Where the first cell of each row leads.
    pub(crate) fn link<'a>(self, to: impl Fn(T) -> Option<&'a String>) -> Self {
        self.each(|row, item| row.link = to(item).cloned().unwrap_or_default())
    }

    fn each(mut self, change: impl Fn(&mut Row, T)) -> Self {
        self.table.rows.iter_mut().zip(&self.items).for_each(|(row, item)| change(row, *item));
        self
    }

    /// What it shows.
    pub(crate) fn caption(mut self, caption: impl Into<String>) -> Self {
        self.table.caption = caption.into();
        self
    }

    /// A remark under it.
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.table.note = note.into();
        self
    }

    /// Set small: for long tables.
    pub(crate) fn small(mut self) -> Self {
        self.table.small = true;
        self
    }

    /// So many rows at brief detail.
    pub fn most(mut self, rows: usize) -> Self {
        self.table.brief_rows = Some(rows);
        self
    }
}

impl<T> From<Rows<T>> for Table {
    fn from(rows: Rows<T>) -> Self {
        rows.table
    }
}

impl Table {
    /// Without columns in which no row has anything.
    pub(super) fn settle(&mut self) {
        let is_empty =
            |cell: Option<&Cell>| cell.is_none_or(|cell| matches!(cell, Cell::Text(text) if text.is_empty()));
        for k in (0..self.columns.len()).rev() {
            if !self.rows.is_empty() && self.rows.iter().all(|row| is_empty(row.cells.get(k))) {
                self.columns.remove(k);
                self.rows.iter_mut().filter(|row| k < row.cells.len()).for_each(|row| drop(row.cells.remove(k)));
            }
        }
    }

    /// The cells typeset; those of a decimal column padded with figure spaces, so that they stand point under point.
    #[cfg(feature = "html")]
    pub(super) fn typeset(&mut self) {
        const FIGURE_SPACE: char = '\u{2007}';
        const POINT_SPACE: char = '\u{2008}';
        for (k, column) in self.columns.iter().enumerate() {
            let decimals = |cell: &str| cell.split_once('.').map_or(0, |(_, digits)| digits.chars().count());
            let mut texts: Vec<String> = Vec::with_capacity(self.rows.len());
            for cell in self.rows.iter().map(|row| row.cells.get(k)) {
                let text = cell.map(Cell::typeset).unwrap_or_default();
                let negative = !matches!(column.align, Align::Left | Align::Bar)
                    && text.strip_prefix('-').is_some_and(|size| size.starts_with(|c: char| c.is_ascii_digit()));
                texts.push(if negative { text.replacen('-', "\u{2212}", 1) } else { text });
            }
            if column.align == Align::Decimal {
                let deepest = texts.iter().map(|text| decimals(text)).max().unwrap_or(0);
                for text in texts.iter_mut().filter(|text| text.contains(|c: char| c.is_ascii_digit())) {
                    let digits = decimals(text);
                    if digits == 0 && deepest > 0 {
                        text.push(POINT_SPACE);
                    }
                    text.extend(std::iter::repeat_n(FIGURE_SPACE, deepest - digits));
                }
            }
            for (row, text) in self.rows.iter_mut().zip(texts) {
                row.cells.get_mut(k).into_iter().for_each(|cell| *cell = Cell::Text(text.clone()));
            }
        }
    }
}
