//! Numbers as cells: `report::table`'s rounding, and words for what does not exist.

pub(super) use crate::document::number::level;
use crate::language::Language;
use crate::report::table::{rounded, significant};

/// A value with as many digits as its uncertainty carries; a dash where there is none.
pub(super) fn value(value: Option<f64>, u: Option<f64>) -> String {
    value.map_or_else(dash, |v| rounded(v, u))
}

/// A number with so many significant digits; a dash where there is none.
pub(super) fn digits(value: Option<f64>, digits: i32) -> String {
    value.map_or_else(dash, |v| significant(v, digits))
}

/// A share as a percentage.
pub(super) fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

/// What stands where there is nothing.
pub(super) fn dash() -> String {
    "\u{2013}".into()
}

/// A list as prose: `a, b and c`, each in code type.
pub(super) fn names<T: AsRef<str>>(names: &[T], lang: Language) -> String {
    let code: Vec<String> = names.iter().map(|n| format!("`{}`", n.as_ref())).collect();
    lang.list(&code)
}
