//! The section of a page on conformity: limits, probabilities, outcomes.

use super::{Align, Section, Table, Tone, cells};
use crate::fit::Conformity;
use crate::report::FitReport;
use crate::report::conformity::percent;

/// Conformity with the limits of the campaign; an empty section where it has none.
pub(super) fn section(report: &FitReport) -> Section {
    let section = Section::new("Conformity");
    let Some(conformity) = &report.conformity else { return section };
    let tone = |outcome: Conformity| match outcome {
        Conformity::Pass => Tone::Good,
        Conformity::Fail => Tone::Bad,
        Conformity::Undecided => Tone::Caution,
    };
    let mut table = Table::new(&[
        ("quantity", Align::Left),
        ("lower limit", Align::Decimal),
        ("value", Align::Decimal),
        ("upper limit", Align::Decimal),
        ("U", Align::Decimal),
        ("unit", Align::Left),
        ("probability", Align::Right),
        ("outcome", Align::Left),
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
            q.outcome.to_string(),
        ]);
    }
    table.note =
        "Probability: that the quantity is inside its limits, by Student's t about the estimate (JCGM 106, 7.3)."
            .into();
    let words = match conformity.outcome {
        Conformity::Pass => "Pass",
        Conformity::Fail => "Fail",
        Conformity::Undecided => "Undecided",
    };
    section.verdict(tone(conformity.outcome), format!("{words}, by {}.", conformity.rule)).table(table)
}
