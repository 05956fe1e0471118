//! The document of a comparison with published closed forms, and its section in the document of a fit.

use super::colophon::begin;
use super::{CompareReport, Input, QuantityReport};
use crate::document::number::significant;
use crate::document::{Align, Cell, Document, Section, Table, Tone};
use crate::language::{Language, say};

/// The document of a comparison.
pub fn compare_document(report: &CompareReport, inputs: &[Input], lang: Language) -> Document {
    let mut document = begin(say!(lang, "comparison-with-the-published-closed-forms"), inputs, lang);
    document.facts = vec![(say!(lang, "bench").into(), format!("`{}`", report.bench))];
    document.facts.push((lang.title(say!(lang, "source")), lang.name(&report.source).into_owned()));
    document.section(section(report, lang)).section(groups(report, lang)).section(misprints(report, lang))
}

/// All readings: the mean of the closed forms beside one least-squares fit.
pub(super) fn section(report: &CompareReport, lang: Language) -> Section {
    let mut section = Section::new(say!(lang, "comparison-with-the-published-closed-forms"));
    let ignored = report.groups.iter().flat_map(|g| &g.quantities).any(|q| q.without_earth_rate.is_some());
    if let Some(difference) = report.largest_relative_difference.map(|difference| significant(difference, 2)) {
        let square = report.is_square_case();
        section = match ignored {
            true => section.verdict(
                if square { Tone::Good } else { Tone::Caution },
                say!(lang, "group-by-group-without-earth-rate", square, difference),
            ),
            false => section.verdict(
                Tone::Plain,
                lang.sentence(&say!(lang, "closed-form-and-least-squares-differ-by", difference)),
            ),
        };
    }
    let printed = report.printed.is_some();
    let closed = format!("{} {}", say!(lang, "closed-form"), lang.in_parentheses(say!(lang, "mean")));
    let mut columns = vec![
        (report.quantity(lang), Align::Left),
        (&closed, Align::Decimal),
        (say!(lang, "least-squares"), Align::Decimal),
    ];
    if printed {
        columns.push((say!(lang, "printed"), Align::Decimal));
    }
    columns.push((say!(lang, "unit"), Align::Left));
    let mut table = Table::new(&columns);
    for q in &report.all.quantities {
        let mut row = vec![Cell::name(&q.id), number(q.closed_form, q, 3), number(q.least_squares, q, 3)];
        if printed {
            row.push(number(q.printed, q, 1));
        }
        row.push(q.unit.as_str().into());
        table.row(row);
    }
    section.table(table).full().prose(lang.sentence(&lang.name(&report.source)))
}

/// Angles with so many decimals, coefficients with digits enough for any unit.
fn number(value: Option<f64>, of: &QuantityReport, decimals: usize) -> Cell {
    if of.is_angle() { Cell::decimals(value, decimals) } else { Cell::digits(value, 7) }
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
                if k == 0 { group.group.map_or(say!(lang, "all").into(), |g| g.to_string()).into() } else { "".into() },
                Cell::name(&q.id),
                number(q.closed_form, q, 3),
                number(q.without_earth_rate, q, 3),
                number(q.least_squares, q, 3),
                number(q.printed, q, 1),
                q.unit.as_str().into(),
            ]);
            table.rule(k == 0);
        }
    }
    Section::new(say!(lang, "group-by-group")).table(table)
}

fn misprints(report: &CompareReport, lang: Language) -> Section {
    let mut table = Table::new(&[
        (say!(lang, "quantity"), Align::Left),
        (say!(lang, "printed"), Align::Decimal),
        (say!(lang, "computed"), Align::Decimal),
        (say!(lang, "probable-cause"), Align::Left),
    ]);
    for m in &report.misprints {
        table.row(vec![
            m.what.say(lang).into(),
            Cell::digits(m.printed, 4),
            Cell::digits(m.computed, 4),
            m.explanation.say(lang).into(),
        ]);
    }
    Section::new(say!(lang, "misprints-found")).table(table)
}
