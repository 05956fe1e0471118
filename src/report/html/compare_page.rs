//! The page of a comparison with published closed forms, and its section on the page of a fit.

use super::fit_page::colophon;
use super::{Align, Page, Section, Table, Tone, cells};
use crate::report::table::significant;
use crate::report::{CompareReport, Input, QuantityReport};

/// The page of a comparison.
pub fn compare_page(report: &CompareReport, inputs: &[Input]) -> Page {
    let mut page = Page::new("Least squares beside the published closed forms");
    page.subtitle = report.source.clone();
    page.facts = vec![("Bench".into(), format!("`{}`", report.bench))];
    page.facts.extend(inputs.first().map(|input| ("Campaign".into(), input.name.clone())));
    page.colophon = colophon(inputs);
    page.section(section(report)).section(groups(report)).section(misprints(report))
}

/// All readings: the mean of the closed forms beside one least-squares fit.
pub(super) fn section(report: &CompareReport) -> Section {
    let mut section = Section::new("Comparison with the published closed forms").prose(format!("{}.", report.source));
    if let Some(difference) = report.largest_relative_difference {
        let difference = significant(difference, 2);
        section = if report.is_square_case() {
            section.verdict(
                Tone::Good,
                format!("Group by group and without the Earth rate, which the formulas ignore, they agree with least squares to {difference} of the value: they are its square special case."),
            )
        } else {
            section.verdict(
                Tone::Caution,
                format!("Group by group and without the Earth rate, which the formulas ignore, they differ from least squares by up to {difference} of the value: these positions are not their square case."),
            )
        };
    }
    let printed = report.printed.is_some();
    let mut columns = vec![
        (report.quantity(), Align::Left),
        ("mean of closed forms", Align::Decimal),
        ("least squares, all readings", Align::Decimal),
    ];
    if printed {
        columns.push(("printed", Align::Decimal));
    }
    columns.push(("unit", Align::Left));
    let mut table = Table::new(&columns);
    for q in &report.all.quantities {
        let mut row = vec![format!("`{}`", q.id), number(q.closed_form, q, 3), number(q.least_squares, q, 3)];
        if printed {
            row.push(number(q.printed, q, 1));
        }
        row.push(q.unit.clone());
        table.row(row);
    }
    section.table(table)
}

/// Angles with so many decimals, coefficients with digits enough for any unit.
fn number(value: Option<f64>, of: &QuantityReport, decimals: usize) -> String {
    if of.is_angle() { cells::decimals(value, decimals) } else { cells::digits(value, 7) }
}

fn groups(report: &CompareReport) -> Section {
    let mut table = Table::new(&[
        (&report.group_title, Align::Left),
        (report.quantity(), Align::Left),
        ("closed form", Align::Decimal),
        ("least squares, no Earth rate", Align::Decimal),
        ("least squares", Align::Decimal),
        ("printed", Align::Decimal),
        ("unit", Align::Left),
    ]);
    for group in &report.groups {
        for (k, q) in group.quantities.iter().enumerate() {
            table.row(vec![
                if k == 0 { group.group.map_or("all".into(), |g| g.to_string()) } else { String::new() },
                format!("`{}`", q.id),
                number(q.closed_form, q, 3),
                number(q.without_earth_rate, q, 3),
                number(q.least_squares, q, 3),
                number(q.printed, q, 1),
                q.unit.clone(),
            ]);
            if let Some(row) = table.rows.last_mut() {
                row.rule = k == 0;
            }
        }
    }
    Section::new("Group by group").table(table)
}

fn misprints(report: &CompareReport) -> Section {
    let mut table = Table::new(&[
        ("what", Align::Left),
        ("printed", Align::Decimal),
        ("computed", Align::Decimal),
        ("what seems to have happened", Align::Left),
    ]);
    for m in &report.misprints {
        table.row(vec![
            m.what.clone(),
            cells::digits(m.printed, 4),
            cells::digits(m.computed, 4),
            m.explanation.clone(),
        ]);
    }
    Section::new("Misprints found").table(table)
}
