//! Sections of a fit's document on its numbers: the estimates, what is not estimable, where the uncertainty comes from.

use super::super::{ARCSEC, FitReport, scatter};
use super::answer;
use super::figures::{budget_figures, estimate_figures, residual_figures};
use crate::campaign::Kind;
use crate::document::number::{level, rounded};
use crate::document::{Align, Cell, Detail, Section, Table, Tone};
use crate::fit::{Fit, State};
use crate::language::{Language, say};

/// Value, u, U and unit as a person reads them: angles in arcseconds.
type Shown<'a> = (Option<f64>, Option<f64>, Option<f64>, &'a str);

/// Every angle and coefficient with its uncertainty, and the residuals drawn.
pub(super) fn estimates(report: &FitReport, fit: Option<&Fit>, lang: Language) -> Section {
    let expanded = format!("U ({})", level(report.level()));
    let mut table = Table::new(&[
        (say!(lang, "parameter"), Align::Left),
        (say!(lang, "estimate"), Align::Decimal),
        ("u", Align::Decimal),
        (&expanded, Align::Decimal),
        (say!(lang, "unit"), Align::Left),
        (say!(lang, "dof"), Align::Right),
        ("k", Align::Right),
        (say!(lang, "state"), Align::Left),
        (say!(lang, "meaning"), Align::Left),
    ])
    .at(Detail::Roomy, &[6])
    .at(Detail::Full, &[8]);
    let mut notes = Vec::new();
    for (k, p) in report.parameters.iter().enumerate() {
        let shown: Shown<'_> = match p.arcsec {
            Some(a) => (a.value, a.u, a.expanded, "arcsec"),
            None => (p.value, p.u, p.expanded, if p.kind == Kind::Tilt { "arcsec" } else { &p.unit }),
        };
        let meaning = fit.and_then(|fit| fit.parameters.get(k)).map(|own| lang.name(&own.meaning).into_owned());
        let state = if p.state == State::Free { "".into() } else { lang.term(p.state.name()).into() };
        table.row(row(&p.id, shown, (p.dof, p.k), state, meaning.unwrap_or_default()));
        table.tone(if p.state == State::NotEstimable { Tone::Bad } else { Tone::Plain });
        if p.state == State::AtBound && p.u.is_some() {
            let (scale, unit) = if p.kind == Kind::Tilt { (ARCSEC, "arcsec") } else { (1.0, p.unit.as_str()) };
            let (id, level) = (&p.id, level(p.level));
            let end = |end: f64| rounded(end * scale, p.u.map(|u| u * scale));
            notes.push(match p.interval {
                Some([low, high]) => {
                    say!(lang, "is-at-a-bound-interval-to-of", id, level, low = end(low), high = end(high), unit)
                }
                None => say!(lang, "is-at-a-bound-and-the-whole", id, level),
            });
        }
    }
    for d in report.derived.iter().filter(|d| d.value.is_some()) {
        let shown: Shown<'_> = match d.arcsec {
            Some(a) => (a.value, a.u, a.expanded, "arcsec"),
            None => (d.value, d.u, d.expanded, d.unit.as_str()),
        };
        table.row(row(&d.id, shown, (d.dof, d.k), say!(lang, "derived").into(), format!("= `{}`", d.line)));
        table.tone(if d.note.is_some() { Tone::Caution } else { Tone::Plain });
        notes.extend(d.note.as_ref().map(|note| say!(lang, "source-note-sentence", source = d.id, note)));
    }
    table.note = say!(lang, "u-combined-standard-uncertainty-k-u-expanded", expanded);
    let without = report.derived_without_a_value();
    if !without.is_empty() {
        let names = lang.names(&without);
        notes.push(lang.sentence(&say!(lang, "derived-without-a-value", names)));
    }
    let drawn = fit.map(|fit| residual_figures(fit, report, lang)).unwrap_or_default();
    Section::new(say!(lang, "estimates"))
        .table(table)
        .list(notes)
        .figures(drawn)
        .prose(answer::summary(report, fit, lang))
        .full()
        .figures(estimate_figures(report, lang))
}

fn row(
    id: &str,
    (value, u, expanded, unit): Shown<'_>,
    (dof, k): (Option<f64>, Option<f64>),
    state: Cell,
    meaning: String,
) -> Vec<Cell> {
    vec![
        Cell::name(id),
        Cell::value(value, expanded.or(u)),
        Cell::value(u, u),
        Cell::value(expanded, expanded),
        unit.into(),
        Cell::dof(dof, u.is_some()),
        Cell::decimals(k, 2),
        state,
        meaning.into(),
    ]
}

/// What the readings leave free, and what would separate it.
pub(super) fn not_estimable(report: &FitReport, lang: Language) -> Section {
    let mut section = Section::new(say!(lang, "not-estimable-from-these-readings"));
    for defect in &report.not_estimable {
        let instead = defect.instead(lang).unwrap_or_else(|| say!(lang, "no-reading-responds", here = defect.weak));
        let mut said = say!(lang, "the-parameters-can-move-along-and-no", text = defect.text, instead);
        if let Some(hides) = &defect.hides {
            said.push_str(&format!("{}{}", lang.space(), lang.sentence(&hides.say(lang))));
        }
        let further = defect.further(lang).unwrap_or_else(|| defect.nowhere().say(lang).to_string());
        section = section.prose(format!("{said}{}{}", lang.space(), lang.sentence(&further)));
    }
    let mut table = Table::new(&[
        (say!(lang, "determined-instead"), Align::Left),
        (say!(lang, "estimate"), Align::Decimal),
        ("u", Align::Decimal),
        ("U", Align::Decimal),
        (say!(lang, "unit"), Align::Left),
    ]);
    for own in &report.estimable_combinations {
        let (value, u, expanded, unit) = match own.arcsec {
            Some(a) => (a.value, a.u, a.expanded, "arcsec"),
            None => (Some(own.value), own.u, own.expanded, own.unit.as_str()),
        };
        table.row(vec![
            Cell::name(&own.text),
            Cell::value(value, expanded.or(u)),
            Cell::value(u, u),
            Cell::value(expanded, expanded),
            unit.into(),
        ]);
    }
    section.table(table)
}

/// A share of the variance below this is left out of the table of a page.
const SMALL: f64 = 5e-4;

/// The budget of each quantity; `asked` puts all of it, and the correlations, before a reader of a terminal.
pub(super) fn budget(report: &FitReport, asked: bool, lang: Language) -> Section {
    let mut table = Table::new(&[
        (say!(lang, "quantity"), Align::Left),
        (say!(lang, "source"), Align::Left),
        (say!(lang, "estimate"), Align::Right),
        (say!(lang, "type"), Align::Left),
        (say!(lang, "distribution"), Align::Left),
        (say!(lang, "u-of-source"), Align::Right),
        ("c", Align::Right),
        (say!(lang, "dof"), Align::Right),
        (say!(lang, "contribution"), Align::Right),
        (say!(lang, "share"), Align::Right),
    ])
    .at(Detail::Roomy, &[2, 4]);
    table.small = true;
    let parameters = report.parameters.iter().map(|p| (p.id.as_str(), p.u, p.dof, p.budget.as_slice()));
    let derived = report.derived.iter().map(|d| (d.id.as_str(), d.u, d.dof, d.budget.as_slice()));
    let mut hidden = 0_usize;
    for (id, u, dof, budget) in parameters.chain(derived) {
        let mut first = true;
        for line in budget {
            if !asked && line.share.abs() < SMALL {
                hidden += 1;
                continue;
            }
            table.row(vec![
                if first { Cell::name(id) } else { "".into() },
                scatter::source_name(&line.source, lang).into(),
                Cell::digits(line.estimate, 6),
                line.evaluation.to_string().into(),
                lang.term(&line.distribution.to_string()).into(),
                Cell::digits(line.source_u, 3),
                Cell::digits(line.c, 4),
                Cell::dof(line.dof, true),
                Cell::Digits(line.u, 3),
                Cell::Share(line.share),
            ]);
            table.rule(first);
            first = false;
        }
        if let (Some(u), false) = (u, budget.is_empty()) {
            let empty = || Cell::from("");
            let mut total = vec![empty(), say!(lang, "combined").into(), empty(), empty(), empty(), empty(), empty()];
            total.extend([Cell::dof(dof, true), Cell::Digits(u, 3), Cell::Share(1.0)]);
            table.row(total);
        }
    }
    table.note = say!(lang, "angles-in-radians-c-sensitivity-coefficient-of").into();
    if hidden > 0 {
        let left_out = say!(lang, "below-of-the-variance-left-out", hidden = hidden.to_string());
        table.note.push_str(&format!("{}{left_out}", lang.space()));
    }
    let section = Section::new(say!(lang, "where-the-uncertainty-comes-from"));
    if !asked {
        return section.full().figures(budget_figures(report, lang)).table(table);
    }
    section.table(table).table(correlations(report, lang)).full().figures(budget_figures(report, lang))
}

fn correlations(report: &FitReport, lang: Language) -> Table {
    let order = &report.correlation.order;
    let mut columns = vec![(say!(lang, "correlation"), Align::Left)];
    columns.extend(order.iter().map(|id| (id.as_str(), Align::Decimal)));
    let mut table = Table::new(&columns);
    for (id, row) in order.iter().zip(&report.correlation.matrix).filter(|_| order.len() > 1) {
        table.row(std::iter::once(Cell::name(id)).chain(row.iter().map(|r| Cell::decimals(*r, 3))).collect::<Vec<_>>());
    }
    table
}
