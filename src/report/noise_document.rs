//! The document of a record's noise: for each column its coefficients, its deviations drawn, and the numbers.

use super::Input;
use super::colophon::begin;
use super::noise_analysis::{AgreementReport, NoiseAnalysisReport, NoiseColumnReport};
use crate::document::chart::{Chart, DeviationPoint};
use crate::document::number::{level, percent, rounded, significant};
use crate::document::{Align, Cell, Document, Figure, Section, Table, Tone};
use crate::language::{Language, say};
use crate::noise::Without;
use crate::reduce::EventKind;

/// The document of a record's noise; `deviations` puts their numbers before a reader of a terminal too.
pub fn noise_document(report: &NoiseAnalysisReport, inputs: &[Input], deviations: bool, lang: Language) -> Document {
    let mut document = begin(say!(lang, "noise-of-a-record"), inputs, lang);
    let rate = significant(1.0 / report.interval_s, 6);
    document.facts = vec![
        (say!(lang, "record").into(), report.record.clone()),
        (
            say!(lang, "sampling-rate").into(),
            format!("{rate} Hz {}", lang.in_parentheses(&lang.name(&report.interval_from))),
        ),
    ];
    report.columns.iter().fold(document, |document, column| document.section(section(column, deviations, lang)))
}

/// Why there are no coefficients.
fn reason(without: Without, lang: Language) -> String {
    say!(lang, "no-coefficients", why = without.name())
}

/// Does the sum of the coefficients describe the deviations?
fn described(a: &AgreementReport, lang: Language) -> (Tone, String) {
    let [chi, p] = [significant(a.chi_square, 3), significant(a.p, 2)];
    let test = say!(lang, "chi-square-with-degrees-of-freedom", statistic = chi, dof = a.dof.to_string());
    let test = lang.in_parentheses(&format!("{test}{}p = {p}", lang.clause()));
    let well = a.describes != Some(false);
    let tone = if well { Tone::Good } else { Tone::Caution };
    (tone, format!("{} {test}", say!(lang, "their-sum-describes", well)))
}

fn section(column: &NoiseColumnReport, deviations: bool, lang: Language) -> Section {
    let mut section = Section::new(&column.column);
    if let Some(a) = &column.agreement {
        let (tone, text) = described(a, lang);
        section = section.verdict(tone, lang.sentence(&text));
    }
    if let Some(without) = column.without {
        section = section.verdict(Tone::Caution, lang.sentence(&reason(without, lang)));
    }
    let mean = column.mean.map_or("-".into(), |mean| significant(mean, 6));
    section = section
        .prose(say!(
            lang,
            "samples-mean",
            samples = column.samples,
            stretches = column.stretches.max(1),
            mean,
            unit = column.unit
        ))
        .table(coefficients(column, lang));
    if let Some(from) = column.agreement.as_ref().and_then(|a| a.from_tau_s) {
        section = section.prose(lang.sentence(&say!(lang, "described-from", from = significant(from, 3))));
    }
    if !column.left_out.is_empty() {
        let event = |(kind, n): (&EventKind, &u64)| format!("{} {n}", lang.term(&kind.to_string()));
        let events = column.left_out.iter().map(event).collect::<Vec<_>>().join(", ");
        section = section.prose(lang.sentence(&say!(lang, "samples-left-out", events)));
    }
    if let Some(interval) = column.agreement.as_ref().and_then(|a| a.walk_sampled_s) {
        section = section.prose(lang.sentence(&say!(lang, "random-walk-sampled", interval = significant(interval, 3))));
    }
    section = section.figures(vec![figure(column, lang)]);
    let numbers = numbers(column, lang);
    if deviations { section.table(numbers) } else { section.full().table(numbers) }
}

fn coefficients(column: &NoiseColumnReport, lang: Language) -> Table {
    let mut table = Table::new(&[
        (say!(lang, "coefficient"), Align::Left),
        ("", Align::Left),
        (say!(lang, "value"), Align::Decimal),
        ("u", Align::Decimal),
        (say!(lang, "unit"), Align::Left),
        ("p", Align::Decimal),
        (&format!("{} (95 %)", say!(lang, "upper-limit")), Align::Decimal),
    ]);
    for c in &column.coefficients {
        table.row(vec![
            c.id.to_string().into(),
            lang.name(&c.name).into(),
            Cell::value(c.value, c.u),
            Cell::digits(c.u, 2),
            c.unit.as_str().into(),
            Cell::p(c.p),
            Cell::digits(c.below, 2),
        ]);
    }
    table
}

fn figure(column: &NoiseColumnReport, lang: Language) -> Figure {
    let points = column.points.iter().map(|p| DeviationPoint {
        tau: p.tau_s,
        value: p.allan.value,
        interval: p.allan.low.zip(p.allan.high),
        fitted: p.fitted,
    });
    let found = column
        .coefficients
        .iter()
        .filter_map(|c| Some(format!("{} {} {}", lang.name(&c.name), rounded(c.value?, c.u), c.unit)));
    let found = lang.sentence(&found.collect::<Vec<_>>().join(lang.semicolon()));
    let (samples, level) = (column.samples.to_string(), percent(column.level));
    let caption = say!(lang, "overlapping-allan-deviation-of-samples-with-its", samples, level);
    Figure {
        description: format!("{caption}{}{found}", lang.space()),
        caption,
        chart: Chart::Deviations(points.collect(), say!(lang, "allan-deviation", unit = column.unit)),
        wide: true,
    }
}

fn numbers(column: &NoiseColumnReport, lang: Language) -> Table {
    let interval = level(column.level);
    let mut table = Table::new(&[
        (say!(lang, "averaging-time-s"), Align::Decimal),
        (say!(lang, "allan"), Align::Decimal),
        (&interval, Align::Right),
        (say!(lang, "edf"), Align::Decimal),
        (say!(lang, "hadamard"), Align::Decimal),
        (say!(lang, "modified"), Align::Decimal),
        (say!(lang, "fitted"), Align::Decimal),
    ]);
    table.small = true;
    for p in &column.points {
        let ends = p.allan.low.zip(p.allan.high);
        table.row(vec![
            Cell::Digits(p.tau_s, 4),
            Cell::Digits(p.allan.value, 5),
            ends.map_or_else(Cell::absent, |(a, b)| format!("{} .. {}", significant(a, 4), significant(b, 4)).into()),
            Cell::Digits(p.allan.edf, 3),
            Cell::digits(p.hadamard.as_ref().map(|d| d.value), 5),
            Cell::digits(p.modified.as_ref().map(|d| d.value), 5),
            Cell::digits(p.fitted, 4),
        ]);
    }
    table
}
