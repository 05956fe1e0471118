//! Tables for a person at a terminal: numbers with as many digits as their uncertainty carries.
//!
//! Here is what all of them share; each report has its own table in a file of its own.

pub use super::compare_table::compare;
pub use super::fit_table::fit;
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};

/// A table without frame: a header, a rule, rows; columns of numbers to the right.
pub fn plain(header: &[&str], rows: &[Vec<String>]) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(header.to_vec());
    for row in rows {
        table.add_row(row.clone());
    }
    for (k, column) in table.column_iter_mut().enumerate() {
        column.set_padding((if k == 0 { 0 } else { 1 }, 1));
        let numeric = !rows.is_empty() && rows.iter().filter_map(|row| row.get(k)).all(|cell| looks_numeric(cell));
        if numeric {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    let mut text = String::new();
    for (k, line) in table.to_string().lines().enumerate() {
        text.push_str(line.trim_end());
        text.push('\n');
        if k == 0 {
            let width = table.lines().map(|line| line.trim_end().chars().count()).max().unwrap_or(0);
            text.push_str(&"-".repeat(width));
            text.push('\n');
        }
    }
    text
}

fn looks_numeric(cell: &str) -> bool {
    cell.is_empty()
        || cell == "-"
        || cell == "inf"
        || cell.trim_start_matches('<').trim_end_matches(" %").parse::<f64>().is_ok()
}

/// A value rounded where its uncertainty ends: at the second significant digit of `u`, the third where `u` begins with 1 or 2,
/// so that rounding changes no `u` by more than 2 % (GUM 7.2.6: two usually suffice).
///
/// ```
/// use tumble::report::table::rounded;
/// assert_eq!(rounded(-162.0687, Some(0.5987)), "-162.07");
/// assert_eq!(rounded(0.001234567, None), "0.00123457");
/// ```
pub fn rounded(value: f64, uncertainty: Option<f64>) -> String {
    match uncertainty.filter(|u| *u > 0.0 && u.is_finite()) {
        Some(u) => {
            let lead = leading_digit(u);
            let digits = if u < 3.0 * 10f64.powi(lead) { 2 - lead } else { 1 - lead };
            if !(-6..=12).contains(&digits) {
                return format!("{value:.6e}");
            }
            let text = format!("{value:.*}", digits.max(0) as usize);
            let zero = text.trim_start_matches('-').chars().all(|c| matches!(c, '0' | '.'));
            if zero { text.trim_start_matches('-').to_string() } else { text }
        }
        None => significant(value, 6),
    }
}

/// A number with so many significant digits, plain where it is readable, else with an exponent.
pub fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return value.to_string();
    }
    let lead = leading_digit(value);
    if !(-5..9).contains(&lead) {
        return format!("{value:.*e}", (digits - 1).max(0) as usize);
    }
    format!("{value:.*}", (digits - 1 - lead).max(0) as usize)
}

/// Six digits at most, no idle zeros.
pub fn trimmed(value: f64) -> String {
    let text = significant(value, 6);
    if text.contains('.') && !text.contains('e') {
        return text.trim_end_matches('0').trim_end_matches('.').to_string();
    }
    text
}

/// Exponent of the leading digit.
fn leading_digit(value: f64) -> i32 {
    value.abs().log10().floor() as i32
}

/// A number, or a dash where there is none.
pub(super) fn optional(value: Option<f64>, format: impl Fn(f64) -> String) -> String {
    value.map_or("-".into(), format)
}

/// A probability in percent, without idle zeros.
pub(super) fn percent(p: f64) -> String {
    significant(100.0 * p, 4).trim_end_matches('0').trim_end_matches('.').to_string()
}

/// From here on a t distribution is the normal one to any printed digit.
const MANY: f64 = 1e6;

/// Degrees of freedom: whole ones (to rounding) without a point, infinite ones as `inf`.
pub(super) fn degrees_of_freedom(dof: Option<f64>, known: bool) -> String {
    match dof {
        None if known => "inf".into(),
        None => "-".into(),
        Some(dof) if dof > MANY => "inf".into(),
        Some(dof) if (dof - dof.round()).abs() < 1e-6 => format!("{dof:.0}"),
        Some(dof) => format!("{dof:.1}"),
    }
}

/// `1 reading`, `30 readings`.
pub(super) fn count(n: usize, what: &str) -> String {
    if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") }
}
