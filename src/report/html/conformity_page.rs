//! The section of a page on conformity: limits, probabilities, outcomes.

use super::{Align, Section, Table, Tone, cells};
use crate::fit::Conformity;
use crate::language::{Language, say};
use crate::report::FitReport;
use crate::report::conformity::percent;

/// How the conformity of a report sounds, and the sentence; nothing where it has no limits.
pub(super) fn verdict(report: &FitReport, lang: Language) -> Option<(Tone, String)> {
    let conformity = report.conformity.as_ref()?;
    let rule = &conformity.rule;
    Some(match conformity.outcome {
        Conformity::Pass => (Tone::Good, say!(lang, "conformity-passes", rule)),
        Conformity::Fail => (Tone::Bad, say!(lang, "conformity-fails", rule)),
        Conformity::Undecided => (Tone::Caution, say!(lang, "conformity-is-undecided", rule)),
    })
}

/// Conformity with the limits of the campaign; an empty section where it has none.
pub(super) fn section(report: &FitReport, lang: Language) -> Section {
    let section = Section::new(say!(lang, "conformity"));
    let Some(conformity) = &report.conformity else { return section };
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
    section.table(table)
}
