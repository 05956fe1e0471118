//! The effects of the catalogue on a schedule, as a person at a terminal reads them.

use super::ForesightReport;
use super::foresight::{group_lines, hidden, lacking, not_exercised, rule_text};
use super::table::{plain, significant};
use super::wrap::hanging;

/// Groups that are listed; the rest are in the JSON and on the page.
const LISTED: usize = 12;
/// Names that are listed on one line.
const NAMED: usize = 8;

/// The first names of a list, and how many more there are.
pub(super) fn some_of(list: &[String], most: usize) -> String {
    let mut text = list.iter().take(most).cloned().collect::<Vec<_>>().join(", ");
    if list.len() > most {
        text.push_str(&format!(" and {} more", list.len() - most));
    }
    text
}

/// The table.
pub(super) fn foresight_table(report: &ForesightReport) -> String {
    let lines = group_lines(report);
    let mut text = format!("\nWhat a diagnosis could find ({} effects tried):\n", report.effects.len());
    text.push_str(&format!("{}\n\n", hanging(&format!("  {}", rule_text(report)), 4)));
    let rows: Vec<Vec<String>> = lines
        .iter()
        .take(LISTED)
        .map(|line| {
            let alike = match &line.nearest {
                Some(nearest) if line.alike.is_empty() => nearest.clone(),
                _ => some_of(&line.alike, 2),
            };
            vec![
                line.effect.clone(),
                significant(line.minimal, 3),
                line.unit.clone(),
                format!("{} u", significant(line.at_a_reading, 2)),
                kept_together(&line.moves),
                alike,
            ]
        })
        .collect();
    if !rows.is_empty() {
        let header =
            ["effect", "shows from", "unit", "then at\u{a0}a\u{a0}reading", "and shifts", "cannot be told from"];
        text.push_str(&plain(&header, &rows));
    }
    if lines.len() > LISTED {
        text.push_str(&format!("and {} less plain directions (--json, --html)\n", lines.len() - LISTED));
    }
    let places = hidden(report);
    if !places.is_empty() {
        text.push_str("\nNever shows, because estimated parameters take it up:\n");
        for (place, list) in places.iter().take(NAMED) {
            text.push_str(&(hanging(&format!("  {} (hides in {place})", some_of(list, NAMED)), 4) + "\n"));
        }
        if places.len() > NAMED {
            text.push_str(&format!("  and effects in {} other combinations\n", places.len() - NAMED));
        }
    }
    let zero = not_exercised(report);
    if !zero.is_empty() {
        let line = format!("Zero at every position of this schedule: {}", some_of(&zero, NAMED));
        text.push_str(&(hanging(&line, 2) + "\n"));
    }
    for (column, families) in lacking(report) {
        text.push_str(&format!("Not tried without a column {column}: {families} kinds of effect\n"));
    }
    text
}

/// A line that breaks only before the number: `V0 by` above `5.0 u`.
fn kept_together(moves: &str) -> String {
    let moves = moves.replacen(" by ", "\u{a0}by ", 1);
    match moves.strip_suffix(" u") {
        Some(number) => format!("{number}\u{a0}u"),
        None => moves,
    }
}
