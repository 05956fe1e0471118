//! The page of a comparison with published closed forms, and its section on the page of a fit.

use super::colophon::colophon;
use super::{Align, Page, Section, Table, Tone, cells};
use crate::language::{Language, say};
use crate::report::table::significant;
use crate::report::{CompareReport, Input, QuantityReport};

/// The page of a comparison.
pub fn compare_page(report: &CompareReport, inputs: &[Input], lang: Language) -> Page {
    let mut page = Page::new(say!(lang, "least-squares-beside-the-published-closed-forms"));
    page.language = lang;
    page.subtitle = lang.name(&report.source).into_owned();
    page.facts = vec![(say!(lang, "bench").into(), format!("`{}`", report.bench))];
    page.facts.extend(inputs.first().map(|input| (say!(lang, "campaign").into(), input.name.clone())));
    page.colophon = colophon(inputs, lang);
    page.section(section(report, lang)).section(groups(report, lang)).section(misprints(report, lang))
}

/// All readings: the mean of the closed forms beside one least-squares fit.
pub(super) fn section(report: &CompareReport, lang: Language) -> Section {
    let mut section = Section::new(say!(lang, "comparison-with-the-published-closed-forms"))
        .prose(lang.sentence(&lang.name(&report.source)));
    if let Some(difference) = report.largest_relative_difference {
        let difference = significant(difference, 2);
        section = if report.is_square_case() {
            section.verdict(Tone::Good, say!(lang, "group-by-group-and-without-the-earth", difference))
        } else {
            section.verdict(Tone::Caution, say!(lang, "group-by-group-and-without-the-earth-2", difference))
        };
    }
    let printed = report.printed.is_some();
    let mut columns = vec![
        (report.quantity(lang), Align::Left),
        (say!(lang, "mean-of-closed-forms"), Align::Decimal),
        (say!(lang, "least-squares-all-readings"), Align::Decimal),
    ];
    if printed {
        columns.push((say!(lang, "printed"), Align::Decimal));
    }
    columns.push((say!(lang, "unit"), Align::Left));
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

fn groups(report: &CompareReport, lang: Language) -> Section {
    let mut table = Table::new(&[
        (&lang.name(&report.group_title), Align::Left),
        (report.quantity(lang), Align::Left),
        (say!(lang, "closed-form"), Align::Decimal),
        (say!(lang, "least-squares-no-earth-rate"), Align::Decimal),
        (say!(lang, "least-squares"), Align::Decimal),
        (say!(lang, "printed"), Align::Decimal),
        (say!(lang, "unit"), Align::Left),
    ]);
    for group in &report.groups {
        for (k, q) in group.quantities.iter().enumerate() {
            table.row(vec![
                if k == 0 { group.group.map_or(say!(lang, "all").into(), |g| g.to_string()) } else { String::new() },
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
    Section::new(say!(lang, "group-by-group")).table(table)
}

fn misprints(report: &CompareReport, lang: Language) -> Section {
    let mut table = Table::new(&[
        (say!(lang, "what"), Align::Left),
        (say!(lang, "printed"), Align::Decimal),
        (say!(lang, "computed"), Align::Decimal),
        (say!(lang, "what-seems-to-have-happened"), Align::Left),
    ]);
    for m in &report.misprints {
        table.row(vec![
            m.what.say(lang),
            cells::digits(m.printed, 4),
            cells::digits(m.computed, 4),
            m.explanation.say(lang),
        ]);
    }
    Section::new(say!(lang, "misprints-found")).table(table)
}
