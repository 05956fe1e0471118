//! The page of a record's noise: for each column its coefficients, its deviations drawn, and the numbers.

use super::{Align, Figure, Page, Section, Table, Tone};
use crate::error::Result;
use crate::report::noise_analysis::{NoiseAnalysisReport, NoiseColumnReport};
use crate::report::plot::{DeviationPoint, deviations};
use crate::report::table::{optional, percent, rounded, significant};
use crate::report::{Input, VERSION};

/// The page of a record's noise.
///
/// Errors: a chart that cannot be drawn.
pub fn noise_page(report: &NoiseAnalysisReport, inputs: &[Input]) -> Result<Page> {
    let mut page = Page::new("Noise of a record");
    page.subtitle = report.record.clone();
    page.facts = vec![(
        "Sampling rate".into(),
        format!("{} Hz ({})", significant(1.0 / report.interval_s, 6), report.interval_from),
    )];
    page.colophon = vec![("Program".into(), format!("tumble {VERSION}"))];
    page.colophon.extend(inputs.iter().map(|input| (input.name.clone(), format!("SHA-256 {}", input.sha256))));
    for column in &report.columns {
        page = page.section(section(column)?);
    }
    Ok(page)
}

fn section(column: &NoiseColumnReport) -> Result<Section> {
    let mut section = Section::new(column.column.clone());
    if let Some(a) = &column.agreement {
        let found: Vec<String> = column
            .coefficients
            .iter()
            .filter_map(|c| Some(format!("{} {} {}", c.name, rounded(c.value?, c.u), c.unit)))
            .collect();
        let (tone, fits) = if a.describes == Some(false) {
            (Tone::Caution, "Their sum does not describe the deviations")
        } else {
            (Tone::Good, "Their sum describes the deviations")
        };
        let numbers = format!("chi-square {}, {} dof, p {}", significant(a.chi_square, 3), a.dof, significant(a.p, 2));
        section = section.verdict(tone, format!("{}. {fits} ({numbers}).", found.join("; ")));
    }
    let mut table = Table::new(&[
        ("coefficient", Align::Left),
        ("", Align::Left),
        ("value", Align::Decimal),
        ("u", Align::Decimal),
        ("unit", Align::Left),
        ("p", Align::Decimal),
        ("below (95 %)", Align::Decimal),
    ]);
    for c in &column.coefficients {
        table.row(vec![
            c.id.to_string(),
            c.name.clone(),
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
        caption: format!(
            "Overlapping Allan deviation of {} samples with its {level} % chi-square intervals, and the fitted coefficients as a line.",
            column.samples
        ),
        description: format!(
            "Allan deviation of {} against averaging time on logarithmic axes; the table has its numbers.",
            column.column
        ),
        svg: deviations(&points, &format!("Allan deviation, {}", column.unit))?,
        wide: true,
    };
    let mut numbers = Table::new(&[
        ("tau, s", Align::Decimal),
        ("Allan", Align::Decimal),
        ("low", Align::Decimal),
        ("high", Align::Decimal),
        ("edf", Align::Decimal),
        ("Hadamard", Align::Decimal),
        ("modified", Align::Decimal),
        ("fitted", Align::Decimal),
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
