//! The effects of the catalogue on a schedule, as a person at a terminal reads them.

use super::ForesightReport;
use super::foresight::{group_lines, hidden, lacking, not_exercised, rule_text};
use super::table::{plain, significant};
use super::wrap::hanging;
use crate::language::{Language, say};

/// Groups that are listed; the rest are in the JSON and on the page.
const LISTED: usize = 12;
/// Names that are listed on one line.
const NAMED: usize = 8;

/// The first names of a list, and how many more there are.
pub(super) fn some_of(list: &[String], most: usize, lang: Language) -> String {
    let mut text = list.iter().take(most).cloned().collect::<Vec<_>>().join(", ");
    if list.len() > most {
        let more = (list.len() - most).to_string();
        text = say!(lang, "and-more", shown = text, more);
    }
    text
}

/// The table.
pub(super) fn foresight_table(report: &ForesightReport, lang: Language) -> String {
    let lines = group_lines(report, lang);
    let mut text = format!(
        "\n{}\n",
        say!(lang, "what-a-diagnosis-could-find-effects-tried", count = report.effects.len().to_string())
    );
    text.push_str(&format!("{}\n\n", hanging(&format!("  {}", rule_text(report, lang)), 4)));
    let rows: Vec<Vec<String>> = lines
        .iter()
        .take(LISTED)
        .map(|line| {
            let alike = match &line.nearest {
                Some(nearest) if line.alike.is_empty() => nearest.clone(),
                _ => some_of(&line.alike, 2, lang),
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
        let then_at = say!(lang, "then-at-a-reading");
        let header = [
            say!(lang, "effect-2"),
            say!(lang, "shows-from"),
            say!(lang, "unit"),
            then_at,
            say!(lang, "and-shifts"),
            say!(lang, "title-cannot-be-told-from"),
        ];
        text.push_str(&plain(&header, &rows));
    }
    if lines.len() > LISTED {
        text.push_str(&format!(
            "{}\n",
            say!(lang, "and-less-plain-directions-json-html", more = (lines.len() - LISTED).to_string())
        ));
    }
    let places = hidden(report, lang);
    if !places.is_empty() {
        text.push_str(&format!("\n{}\n", say!(lang, "never-shows")));
        for (place, list) in places.iter().take(NAMED) {
            text.push_str(
                &(hanging(&format!("  {}", say!(lang, "hides-in", effects = some_of(list, NAMED, lang), place)), 4)
                    + "\n"),
            );
        }
        if places.len() > NAMED {
            text.push_str(&format!(
                "  {}\n",
                say!(lang, "and-effects-in-other-combinations", more = (places.len() - NAMED).to_string())
            ));
        }
    }
    let zero = not_exercised(report);
    if !zero.is_empty() {
        let line = say!(lang, "zero-at-every-position-of-this-schedule", effects = some_of(&zero, NAMED, lang));
        text.push_str(&(hanging(&line, 2) + "\n"));
    }
    for (column, families) in lacking(report) {
        text.push_str(&format!(
            "{}\n",
            say!(lang, "not-tried-without-a-column-kinds-of", column, families = lang.count(families, "kind"))
        ));
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
