//! Where what a campaign refers to is found.

use super::{Fetch, Source};
use crate::error::{Fault, Malformed, Result};
use crate::record::Record;

/// Finds what a campaign refers to by a path of its own (relative to its file).
pub trait Folder {
    /// A text: a bench file.
    fn text(&mut self, name: &str) -> Result<Source>;
    /// A table of readings.
    fn table(&mut self, name: &str) -> Result<Record> {
        self.record(name)
    }
    /// A record of samples.
    fn record(&mut self, name: &str) -> Result<Record>;
    /// Something that was found on the way and should be told.
    fn note(&mut self, _text: String) {}
}

/// A function that fetches texts, as a folder without records.
pub(super) struct Texts<'a>(pub Fetch<'a>);

impl Folder for Texts<'_> {
    fn text(&mut self, name: &str) -> Result<Source> {
        (self.0)(name)
    }

    fn table(&mut self, name: &str) -> Result<Record> {
        let source = (self.0)(name)?;
        Record::of_text(&source.name, source.text)
    }

    fn record(&mut self, name: &str) -> Result<Record> {
        Err(Malformed::new(Fault::File, format!("'{name}' is a record of samples, and only texts are fetched here"))
            .expected("readings in the text or in a table of text (Campaign::from_path reduces records)"))
    }
}
