//! The begin and the end of every page: its title and language, which program, which inputs.

use crate::document::Document;
use crate::language::{Language, say};
use crate::report::{Input, VERSION};

/// A document without sections, with version and inputs at its end.
pub(super) fn begin(title: impl Into<String>, inputs: &[Input], lang: Language) -> Document {
    let digest = |input: &Input| (say!(lang, "sha-of", name = input.name), format!("`{}`", input.sha256));
    let version = (say!(lang, "made-by").to_string(), format!("tumble {VERSION}"));
    let colophon = [version].into_iter().chain(inputs.iter().map(digest)).collect();
    Document { title: title.into(), language: lang, colophon, ..Document::default() }
}
