//! The page of a record's noise: for each column its coefficients, its deviations drawn, and the numbers.

use super::{Align, Figure, Page, Section, Table, Tone};
use crate::error::Result;
use crate::language::{Language, say};
use crate::report::noise_analysis::{NoiseAnalysisReport, NoiseColumnReport};
use crate::report::noise_table::{described, numbers, reason, walk};
use crate::report::plot::{DeviationPoint, deviations};
use crate::report::table::{optional, percent, rounded, significant};
use crate::report::{Input, VERSION};

/// The page of a record's noise.
///
/// Errors: a chart that cannot be drawn.
pub fn noise_page(report: &NoiseAnalysisReport, inputs: &[Input], lang: Language) -> Result<Page> {
    let mut page = Page::new(say!(lang, "noise-of-a-record"));
    page.language = lang;
    page.subtitle = report.record.clone();
    page.facts = vec![(
        say!(lang, "sampling-rate").into(),
        format!(
            "{} Hz {}",
            significant(1.0 / report.interval_s, 6),
            lang.in_parentheses(&lang.name(&report.interval_from))
        ),
    )];
    page.colophon = vec![(say!(lang, "program").into(), format!("tumble {VERSION}"))];
    page.colophon.extend(inputs.iter().map(|input| (input.name.clone(), format!("SHA-256 {}", input.sha256))));
    for column in &report.columns {
        page = page.section(section(column, lang)?);
    }
    Ok(page)
}

fn section(column: &NoiseColumnReport, lang: Language) -> Result<Section> {
    let mut section = Section::new(column.column.clone());
    if let Some(without) = column.without {
        section = section.verdict(Tone::Caution, lang.sentence(reason(without, lang)));
    }
    if let Some(a) = &column.agreement {
        let found: Vec<String> = column
            .coefficients
            .iter()
            .filter_map(|c| Some(format!("{} {} {}", lang.name(&c.name), rounded(c.value?, c.u), c.unit)))
            .collect();
        let tone = if a.describes == Some(false) { Tone::Caution } else { Tone::Good };
        let fits = format!("{} {}", described(a, lang), lang.in_parentheses(&numbers(a, lang)));
        let said = [Some(found.join(lang.semicolon())), Some(fits), walk(a, lang)];
        let text = said.into_iter().flatten().map(|text| lang.sentence(&text)).collect::<Vec<_>>().join(lang.space());
        section = section.verdict(tone, text);
    }
    let mut table = Table::new(&[
        (say!(lang, "coefficient"), Align::Left),
        ("", Align::Left),
        (say!(lang, "value"), Align::Decimal),
        ("u", Align::Decimal),
        (say!(lang, "unit"), Align::Left),
        ("p", Align::Decimal),
        (say!(lang, "below"), Align::Decimal),
    ]);
    for c in &column.coefficients {
        table.row(vec![
            c.id.to_string(),
            lang.name(&c.name).into_owned(),
            optional(c.value, |v| rounded(v, c.u)),
            optional(c.u, |u| significant(u, 2)),
            c.unit.clone(),
            optional(c.p, |p| significant(p, 2)),
            optional(c.below, |b| significant(b, 2)),
        ]);
    }
    let points: Vec<DeviationPoint> = column
        .points
        .iter()
        .map(|p| DeviationPoint {
            tau: p.tau_s,
            value: p.allan.value,
            interval: p.allan.low.zip(p.allan.high),
            fitted: p.fitted,
        })
        .collect();
    let level = percent(column.level);
    let figure = Figure {
        caption: say!(
            lang,
            "overlapping-allan-deviation-of-samples-with-its",
            samples = column.samples.to_string(),
            level
        ),
        description: say!(lang, "allan-deviation-of-against-averaging-time-on", column = column.column),
        svg: deviations(&points, &say!(lang, "allan-deviation", unit = column.unit), lang)?,
        wide: true,
    };
    let mut numbers = Table::new(&[
        (say!(lang, "tau-s"), Align::Decimal),
        (say!(lang, "allan"), Align::Decimal),
        (say!(lang, "low"), Align::Decimal),
        (say!(lang, "high"), Align::Decimal),
        (say!(lang, "edf"), Align::Decimal),
        (say!(lang, "hadamard"), Align::Decimal),
        (say!(lang, "modified"), Align::Decimal),
        (say!(lang, "fitted"), Align::Decimal),
    ]);
    numbers.small = true;
    let number = |v: Option<f64>| optional(v, |v| significant(v, 5));
    for p in &column.points {
        numbers.row(vec![
            significant(p.tau_s, 4),
            number(Some(p.allan.value)),
            number(p.allan.low),
            number(p.allan.high),
            significant(p.allan.edf, 3),
            number(p.hadamard.as_ref().map(|d| d.value)),
            number(p.modified.as_ref().map(|d| d.value)),
            number(p.fitted),
        ]);
    }
    Ok(section.table(table).figures(vec![figure]).table(numbers))
}
