//! The section of a page on conformity: limits, probabilities, outcomes.

use super::{Align, Section, Table, Tone, cells};
use crate::fit::Conformity;
use crate::language::{Language, say};
use crate::report::FitReport;
use crate::report::conformity::percent;

/// Conformity with the limits of the campaign; an empty section where it has none.
pub(super) fn section(report: &FitReport, lang: Language) -> Section {
    let section = Section::new(say!(lang, "conformity"));
    let Some(conformity) = &report.conformity else { return section };
    let tone = |outcome: Conformity| match outcome {
        Conformity::Pass => Tone::Good,
        Conformity::Fail => Tone::Bad,
        Conformity::Undecided => Tone::Caution,
    };
    let mut table = Table::new(&[
        (say!(lang, "quantity"), Align::Left),
        (say!(lang, "lower-limit"), Align::Decimal),
        (say!(lang, "value"), Align::Decimal),
        (say!(lang, "upper-limit"), Align::Decimal),
        ("U", Align::Decimal),
        (say!(lang, "unit"), Align::Left),
        (say!(lang, "probability"), Align::Right),
        (say!(lang, "outcome"), Align::Left),
    ]);
    for q in &conformity.quantities {
        table.row(vec![
            format!("`{}`", q.id),
            cells::digits(q.lower, 6),
            cells::value(q.value, q.expanded),
            cells::digits(q.upper, 6),
            cells::digits(q.expanded, 3),
            q.unit.clone(),
            q.probability.map_or_else(cells::dash, percent),
            lang.term("outcome", &q.outcome.to_string()).into_owned(),
        ]);
    }
    table.note = say!(lang, "probability-that-the-quantity-is-inside-its").into();
    let text = match conformity.outcome {
        Conformity::Pass => say!(lang, "conformity-passes", rule = conformity.rule),
        Conformity::Fail => say!(lang, "conformity-fails", rule = conformity.rule),
        Conformity::Undecided => say!(lang, "conformity-is-undecided", rule = conformity.rule),
    };
    section.verdict(tone(conformity.outcome), text).table(table)
}
