//! Tables for a person at a terminal: numbers with as many digits as their uncertainty carries.
//!
//! Here is what all of them share; each report has its own table in a file of its own.

pub use super::compare_table::compare;
pub use super::fit_table::fit;
use super::wrap::{self, WIDTH};
use crate::number;
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};

/// Spaces between two columns, and where the table would be too wide.
const GAPS: [usize; 2] = [2, 1];

/// A table without frame: a header, a rule, rows; columns of numbers to the right. A table wider than the line stands closer,
/// breaks its columns of text at spaces and, where that does not suffice, continues below, beside the columns that name its rows.
pub fn plain(header: &[&str], rows: &[Vec<String>]) -> String {
    let columns: Vec<Column> = header.iter().enumerate().map(|(k, title)| Column::of(k, title, rows)).collect();
    let all: Vec<usize> = (0..columns.len()).collect();
    let natural: usize = columns.iter().map(|column| column.widest).sum();
    let fits = |size: usize, gap: usize| size + gap * columns.len().saturating_sub(1) <= WIDTH;
    if let Some(gap) = GAPS.into_iter().find(|gap| fits(natural, *gap)) {
        return framed(&columns, &all, gap, header, rows);
    }
    let least: usize = columns.iter().map(|column| column.least).sum();
    if let Some(gap) = GAPS.into_iter().find(|gap| fits(least, *gap)) {
        return framed(&columns, &all, gap, header, rows);
    }
    let parts: Vec<String> =
        blocks(&columns).iter().map(|block| framed(&columns, block, GAPS[0], header, rows)).collect();
    parts.join("\n")
}

/// True when the table of [`plain`] stands in one piece within the line, no cell broken.
pub fn is_narrow(header: &[&str], rows: &[Vec<String>]) -> bool {
    let widest = |k: usize, title: &str| Column::of(k, title, rows).widest;
    let natural: usize = header.iter().enumerate().map(|(k, title)| widest(k, title)).sum();
    natural + header.len().saturating_sub(1) <= WIDTH
}

/// What a column needs.
struct Column {
    numeric: bool,
    /// Characters of its longest cell.
    widest: usize,
    /// The same where its title breaks.
    below_title: usize,
    /// Characters below which it cannot go: its longest word, or the widest number.
    least: usize,
}

impl Column {
    fn of(k: usize, title: &str, rows: &[Vec<String>]) -> Self {
        let cells = || rows.iter().filter_map(move |row| row.get(k)).map(String::as_str);
        let numeric = !rows.is_empty() && cells().all(looks_numeric);
        let size = wrap::columns;
        let word = |text: &str| wrap::pieces(text).map(size).max().unwrap_or(0);
        let widest = cells().map(size).max().unwrap_or(0).max(size(title));
        // a title breaks too, but a number does not
        let body = cells().map(|cell| if numeric { size(cell) } else { word(cell) }).max().unwrap_or(0);
        let below_title = cells().map(size).max().unwrap_or(0).max(word(title));
        Self { numeric, widest, below_title, least: body.max(word(title)) }
    }
}

/// The columns that stand beside one another; those of text before the first number name the row and stand in every block.
fn blocks(columns: &[Column]) -> Vec<Vec<usize>> {
    let texts = columns.iter().take_while(|column| !column.numeric).count();
    let widths = columns.iter().scan(0, |sum, column| {
        *sum += column.least + GAPS[0];
        Some(*sum)
    });
    let names = widths.take(texts).take_while(|sum| *sum <= WIDTH / 2).count().max(1);
    let width = |block: &[usize]| -> usize {
        block.iter().filter_map(|k| columns.get(*k)).map(|own| own.least + GAPS[0]).sum()
    };
    let mut blocks: Vec<Vec<usize>> = Vec::new();
    for (k, column) in columns.iter().enumerate() {
        match blocks.last_mut() {
            Some(block) if block.len() <= names || width(block) + column.least <= WIDTH => block.push(k),
            Some(_) => blocks.push((0..names).chain([k]).collect()),
            None => blocks.push(vec![k]),
        }
    }
    blocks
}

/// Widths within the line: titles break first, then the widest columns give way until the table fits.
fn widths(columns: &[Column], block: &[usize], gap: usize) -> Vec<usize> {
    let own: Vec<&Column> = block.iter().filter_map(|&k| columns.get(k)).collect();
    let mut widths: Vec<usize> = own.iter().map(|column| column.widest).collect();
    let room = WIDTH.saturating_sub(gap * block.len().saturating_sub(1));
    for floor in [|column: &Column| column.below_title, |column: &Column| column.least] {
        while widths.iter().sum::<usize>() > room {
            let above = widths.iter_mut().zip(&own).filter(|(width, column)| **width > floor(column));
            match above.max_by_key(|(width, _)| **width) {
                Some((width, _)) => *width -= 1,
                None => break,
            }
        }
    }
    widths
}

fn framed(columns: &[Column], block: &[usize], gap: usize, header: &[&str], rows: &[Vec<String>]) -> String {
    let widths = widths(columns, block, gap);
    // a block names columns of this table; a row may be shorter
    let within = |k: usize, cell: &str| wrap::narrow(cell, 0, widths.get(k).copied().unwrap_or(WIDTH));
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(block.iter().enumerate().map(|(k, &c)| within(k, header.get(c).copied().unwrap_or_default())));
    for row in rows {
        table.add_row(block.iter().enumerate().map(|(k, &c)| within(k, row.get(c).map_or("", String::as_str))));
    }
    for (k, column) in table.column_iter_mut().enumerate() {
        column.set_padding((if k == 0 { 0 } else { u16::try_from(gap).unwrap_or(u16::MAX).saturating_sub(1) }, 1));
        if block.get(k).and_then(|&c| columns.get(c)).is_some_and(|column| column.numeric) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    let titles = block
        .iter()
        .enumerate()
        .map(|(k, &c)| within(k, header.get(c).copied().unwrap_or_default()).lines().count())
        .max()
        .unwrap_or(1);
    let mut text = String::new();
    for (k, line) in table.to_string().lines().enumerate() {
        text.push_str(line.trim_end());
        text.push('\n');
        if k + 1 == titles {
            let width = table.lines().map(|line| wrap::columns(line.trim_end())).max().unwrap_or(0);
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
            let text = format!("{value:.*}", number::unsigned(digits));
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
        return format!("{value:.*e}", number::unsigned(digits - 1));
    }
    format!("{value:.*}", number::unsigned(digits - 1 - lead))
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
    number::whole(value.abs().log10().floor())
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
