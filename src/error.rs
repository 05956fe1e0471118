//! One error type: the question is malformed.
//!
//! `Malformed` says *where* (file, line, column, JSON path), *what was expected* and *what was found*. Outcomes of a
//! well-posed question (rank defect, failed test, active bound, no convergence) are never errors: they are parts of a
//! result. Deliberately absent: wrapped types of dependencies, error codes, a variant per message.

use std::fmt;

/// What sort of fault a [`Malformed`] question has; programs branch on this, people read the sentence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Fault {
    /// The text is not JSON, CSV or a model line at all.
    Syntax,
    /// A key, column or option that the format does not have.
    UnknownKey,
    /// A name that nothing defines (a parameter, joint, sensor, axis, bench).
    UnknownName,
    /// Two things share one name.
    NameClash,
    /// Something required is absent.
    Missing,
    /// A value is outside what the question allows (NaN, negative uncertainty, wrong type).
    Value,
    /// A file cannot be read or written.
    File,
}

/// A place in a file of the user's.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Place {
    /// The file's name as the user gave it; empty for text that came from no file.
    pub file: String,
    /// JSON path or CSV column, for example `estimate.dtheta_y9` or `readings[3].V`.
    pub path: String,
    /// Line, counted from 1; 0 where it is not known.
    pub line: usize,
    /// Column in characters, counted from 1; 0 where it is not known.
    pub column: usize,
    /// Characters from there on that are meant; 0 where that is not known.
    pub width: usize,
    /// Bytes from the start of the text, and how many bytes the caret underlines.
    pub span: Option<(usize, usize)>,
}

/// The question is malformed: what is wrong, where, what was expected and what was found.
///
/// ```
/// use tumble::error::{Fault, Malformed};
/// let error = Malformed::new(Fault::UnknownName, "no bench is called 'gyro-turntabel'")
///     .expected("a built-in id (gyro-turntable, ...) or a path to a bench file")
///     .at_path("bench");
/// assert_eq!(error.fault(), Fault::UnknownName);
/// assert!(error.to_string().contains("expected: a built-in id"));
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Malformed(Box<Parts>);

#[derive(Debug, Clone, PartialEq, Eq)]
struct Parts {
    fault: Fault,
    what: String,
    expected: Option<String>,
    found: Option<String>,
    argument: Option<(&'static str, String)>,
    place: Place,
}

impl Malformed {
    /// A fault and the sentence that says what is wrong.
    pub fn new(fault: Fault, what: impl Into<String>) -> Self {
        Malformed(Box::new(Parts {
            fault,
            what: what.into(),
            expected: None,
            found: None,
            argument: None,
            place: Place::default(),
        }))
    }

    /// A name that nothing has here, and the names that there are.
    pub(crate) fn unknown(
        what: impl Into<String>,
        name: &str,
        known: impl IntoIterator<Item = impl AsRef<str>>,
    ) -> Self {
        let known: Vec<String> = known.into_iter().map(|known| known.as_ref().to_string()).collect();
        Malformed::new(Fault::UnknownName, what)
            .expected(format!("one of {}", known.join(", ")))
            .found(format!("'{name}'"))
    }

    /// What would have been right here.
    pub fn expected(mut self, expected: impl Into<String>) -> Self {
        self.0.expected = Some(expected.into());
        self
    }

    /// What stood here instead.
    pub fn found(mut self, found: impl Into<String>) -> Self {
        self.0.found = Some(found.into());
        self
    }

    /// The argument of the call that would set it right, by its name, with an example of its value (may be empty).
    pub(crate) fn argument(mut self, name: &'static str, example: impl Into<String>) -> Self {
        self.0.argument = Some((name, example.into()));
        self
    }

    /// The JSON path or column of the fault, kept if one is there already.
    pub fn at_path(mut self, path: impl Into<String>) -> Self {
        if self.0.place.path.is_empty() {
            self.0.place.path = path.into();
        }
        self
    }

    /// The path, whatever was there before.
    pub(crate) fn moved_to(mut self, path: impl Into<String>) -> Self {
        self.0.place.path = path.into();
        self
    }

    /// Put `prefix` before the path, as an error rises from a part to the whole.
    pub fn under(mut self, prefix: &str) -> Self {
        let path = &mut self.0.place.path;
        *path = match (path.is_empty(), path.starts_with('[')) {
            (true, _) => prefix.to_string(),
            (false, true) => format!("{prefix}{path}"),
            (false, false) => format!("{prefix}.{path}"),
        };
        self
    }

    /// The file, kept if one is there already.
    pub fn in_file(mut self, file: impl Into<String>) -> Self {
        if self.0.place.file.is_empty() {
            self.0.place.file = file.into();
        }
        self
    }

    /// Bytes that the caret should underline, from the start of the text in question.
    pub fn at_span(mut self, start: usize, len: usize) -> Self {
        self.0.place.span = Some((start, len.max(1)));
        self
    }

    /// Line and column, counted from 1; the column is 0 where it is not known.
    pub fn at_line(mut self, line: usize, column: usize) -> Self {
        self.0.place.line = line;
        self.0.place.column = column;
        self
    }

    /// A cell of a table: its line, its first character in that line, and how many it has.
    pub(crate) fn at_cell(self, line: usize, (column, width): (usize, usize)) -> Self {
        let mut own = self.at_line(line, column);
        own.0.place.width = width;
        own
    }

    /// What sort of fault this is.
    pub fn fault(&self) -> Fault {
        self.0.fault
    }

    /// The sentence that says what is wrong, without place or expectation.
    pub fn what(&self) -> &str {
        &self.0.what
    }

    /// Where the fault is.
    pub fn place(&self) -> &Place {
        &self.0.place
    }

    /// What would have been right, if it can be said.
    pub fn expectation(&self) -> Option<&str> {
        self.0.expected.as_deref()
    }

    /// The argument that would set it right and an example of its value, where an argument of the call would.
    pub fn remedy(&self) -> Option<(&'static str, &str)> {
        self.0.argument.as_ref().map(|(name, example)| (*name, example.as_str()))
    }

    /// What stood there instead, if it can be said.
    pub fn finding(&self) -> Option<&str> {
        self.0.found.as_deref()
    }
}

/// Errors: a value of the question that must be a probability and is none.
pub(crate) fn probability(what: &str, value: f64, example: &str) -> Result<()> {
    if value > 0.0 && value < 1.0 {
        return Ok(());
    }
    Err(Malformed::new(Fault::Value, format!("the {what} is not a probability"))
        .expected(format!("a number between 0 and 1, for example {example}"))
        .found(value.to_string()))
}

impl Place {
    /// The path as a person reads it: a row's ends with a bar, behind which a column is named.
    pub(crate) fn path_said(&self) -> String {
        self.path.replacen("|.", ", ", 1).trim_end_matches('|').to_string()
    }
}

impl fmt::Display for Malformed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Place { file, path, line, column, .. } = &self.0.place;
        if !file.is_empty() {
            write!(f, "{file}")?;
            if *line > 0 {
                write!(f, ":{line}")?;
            }
            if *column > 0 {
                write!(f, ":{column}")?;
            }
            write!(f, ": ")?;
        } else if *line > 0 {
            write!(f, "line {line}")?;
            if *column > 0 {
                write!(f, ", column {column}")?;
            }
            write!(f, ": ")?;
        }
        write!(f, "{}", self.0.what)?;
        if !path.is_empty() {
            write!(f, " (at {})", self.0.place.path_said())?;
        }
        if let Some(expected) = &self.0.expected {
            write!(f, "; expected: {expected}")?;
        }
        if let Some(found) = &self.0.found {
            write!(f, "; found: {found}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Malformed {}

/// Shorthand used throughout the crate.
pub type Result<T> = std::result::Result<T, Malformed>;
