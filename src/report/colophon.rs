//! The end of every page: which program, which inputs.

use crate::language::{Language, say};
use crate::report::{Input, VERSION};

/// The end of every page: version and inputs.
pub(super) fn colophon(inputs: &[Input], lang: Language) -> Vec<(String, String)> {
    let mut list = vec![(say!(lang, "made-by").to_string(), format!("tumble {VERSION}"))];
    list.extend(inputs.iter().map(|input| (say!(lang, "sha-of", name = input.name), format!("`{}`", input.sha256))));
    list
}
