//! Numbers as cells: `report::table`'s rounding, and words for what does not exist.

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

/// A number with so many decimals; a dash where there is none.
pub(super) fn decimals(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(dash, |v| format!("{v:.decimals$}"))
}

/// Degrees of freedom: infinite where none are given for an uncertainty that exists.
pub(super) fn dof(dof: Option<f64>, known: bool) -> String {
    match dof {
        None if known => "\u{221e}".into(),
        None => dash(),
        Some(dof) if (dof - dof.round()).abs() < 0.05 => format!("{dof:.0}"),
        Some(dof) => format!("{dof:.1}"),
    }
}

/// A share as a percentage.
pub(super) fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

/// A level as a person writes it: `95 %`.
pub(super) fn level(level: f64) -> String {
    let text = significant(100.0 * level, 5);
    let short = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    format!("{short} %")
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
