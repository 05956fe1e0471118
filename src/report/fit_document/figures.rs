//! The figures of a fit, each with its caption and its words.

use super::super::{ARCSEC, BudgetReport, FitReport, ReadingReport, scatter};
use super::FAR;
use crate::campaign::Kind;
use crate::document::Figure;
use crate::document::chart::{Bar, Chart, Interval, Part, Residual};
use crate::document::number::{level, rounded, significant};
use crate::fit::{Fit, State};
use crate::language::{Language, say};
use crate::uncertainty::Evaluation;

/// More rows than this are no figure any more.
const MOST_ROWS: usize = 60;
/// More readings of a sensor than this are thinned; those far out stay.
const MOST_POINTS: usize = 1500;

/// An angle of the report, estimated or derived: name, value, expanded uncertainty, standard uncertainty, budget; in arcseconds.
struct Angle<'a> {
    id: &'a str,
    value: f64,
    expanded: f64,
    budget: &'a [BudgetReport],
    u: f64,
    /// Ends of the interval, where a bound holds it.
    at_bound: Option<[f64; 2]>,
}

fn angles(report: &FitReport) -> Vec<Angle<'_>> {
    let parameters = report.parameters.iter().map(|p| {
        let held = p.interval.filter(|_| p.state == State::AtBound).map(|ends| ends.map(|end| end * ARCSEC));
        (p.id.as_str(), p.arcsec, p.budget.as_slice(), held)
    });
    let derived = report.derived.iter().map(|d| (d.id.as_str(), d.arcsec, d.budget.as_slice(), None));
    parameters
        .chain(derived)
        .filter_map(|(id, arcsec, budget, at_bound)| {
            let a = arcsec?;
            Some(Angle { id, value: a.value?, expanded: a.expanded?, u: a.u?, budget, at_bound })
        })
        .take(MOST_ROWS)
        .collect()
}

/// Parts of a bar of length `u`: each source by its share of the variance, large ones first; the smallest together.
fn parts(budget: &[BudgetReport], u: f64, lang: Language) -> Vec<Part> {
    let mut lines: Vec<&BudgetReport> = budget.iter().filter(|line| line.share > 5e-3).collect();
    lines.sort_by(|a, b| a.evaluation.cmp(&b.evaluation).then(b.share.total_cmp(&a.share)));
    lines
        .iter()
        .map(|line| Part {
            source: scatter::source_name(&line.source, lang),
            type_b: line.evaluation == Evaluation::TypeB,
            size: u * line.share,
        })
        .collect()
}

/// Angles with error bars, and their standard uncertainties by source.
pub(super) fn estimate_figures(report: &FitReport, lang: Language) -> Vec<Figure> {
    let angles = angles(report);
    if angles.is_empty() {
        return Vec::new();
    }
    let rows: Vec<Interval> = angles
        .iter()
        .map(|a| Interval { label: a.id.into(), value: a.value, expanded: a.expanded, at_bound: a.at_bound })
        .collect();
    let bars: Vec<Bar> = angles.iter().map(|a| Bar { label: a.id.into(), parts: parts(a.budget, a.u, lang) }).collect();
    vec![
        Figure {
            caption: [
                Some(say!(lang, "angles-with-their-expanded-uncertainties", level = level(report.level()))),
                angles.iter().any(|a| a.at_bound.is_some()).then(|| say!(lang, "angles-at-bounds").to_string()),
            ]
            .into_iter()
            .flatten()
            .collect::<Vec<_>>()
            .join(lang.space()),
            description: listed(
                angles.iter().map(|a| {
                    format!("{} {} \u{b1} {} arcsec", a.id, rounded(a.value, Some(a.u)), significant(a.expanded, 3))
                }),
                lang,
            ),
            chart: Chart::Values(rows, "arcsec".into()),
            wide: false,
        },
        Figure {
            caption: say!(lang, "standard-uncertainties-divided-by-each-sources-share").into(),
            description: listed(
                bars.iter().zip(&angles).map(|(bar, a)| {
                    format!("{} u = {} arcsec{}", a.id, significant(a.u, 3), lang.in_parentheses(&shares(bar, lang)))
                }),
                lang,
            ),
            chart: Chart::Bars(bars, say!(lang, "standard-uncertainty").into(), "arcsec".into(), false),
            wide: false,
        },
    ]
}

/// Shares of the variance for coefficients, where there is more than one source.
pub(super) fn budget_figures(report: &FitReport, lang: Language) -> Vec<Figure> {
    let parameters = report.parameters.iter().filter(|p| p.kind != Kind::Tilt).map(|p| (&p.id, &p.budget));
    let derived = report.derived.iter().filter(|d| d.arcsec.is_none()).map(|d| (&d.id, &d.budget));
    let bars: Vec<Bar> = parameters
        .chain(derived)
        .filter(|(_, budget)| !budget.is_empty())
        .map(|(id, budget)| Bar { label: id.clone(), parts: parts(budget, 100.0, lang) })
        .take(MOST_ROWS)
        .collect();
    if bars.iter().all(|bar| bar.parts.len() < 2) {
        return Vec::new();
    }
    vec![Figure {
        caption: say!(lang, "coefficients-each-sources-share-of-the-variance").into(),
        description: listed(bars.iter().map(|bar| format!("{}: {}", bar.label, shares(bar, lang))), lang),
        chart: Chart::Bars(bars, say!(lang, "share").into(), "%".into(), true),
        wide: true,
    }]
}

/// What is left of a reading when deviations that it shares with others are taken out.
fn own_residual(reading: &ReadingReport, shared: bool) -> f64 {
    match (reading.studentized, reading.u) {
        (Some(s), Some(u)) if shared => s * u * reading.redundancy.max(0.0).sqrt(),
        _ => reading.residual,
    }
}

/// Residuals of each sensor in order, with the band in which each should lie.
pub(super) fn residual_figures(fit: &Fit, report: &FitReport, lang: Language) -> Vec<Figure> {
    let mut figures = Vec::new();
    let shared = !fit.campaign.scatter.is_empty();
    let sensors = &fit.campaign.bench.sensors;
    for sensor in sensors {
        let own: Vec<_> = report.readings.iter().filter(|r| r.sensor == sensor.id).collect();
        if own.is_empty() {
            continue;
        }
        let every = own.len().div_ceil(MOST_POINTS).max(1);
        let is_far = |s: Option<f64>| s.is_some_and(|s| s.abs() > FAR);
        let rows: Vec<Residual> = own
            .iter()
            .enumerate()
            .filter(|(k, r)| k % every == 0 || is_far(r.studentized))
            .map(|(_, r)| Residual {
                number: r.index,
                group: r.position.clone(),
                value: own_residual(r, shared),
                band: r.u.map(|u| 2.0 * u * r.redundancy.max(0.0).sqrt()),
                far: is_far(r.studentized),
            })
            .collect();
        let far: Vec<String> = own.iter().filter(|r| is_far(r.studentized)).map(|r| r.index.to_string()).collect();
        let far = match far.len() {
            0 => say!(lang, "none").into(),
            1..=12 => far.join(lang.comma()),
            n => lang.count(n, "reading"),
        };
        let mut caption = say!(lang, "residuals-of-figure", shared, id = sensor.id, limit = FAR, far);
        if every > 1 {
            caption.push_str(&format!("{}{}", lang.space(), say!(lang, "one-reading-in-is-drawn", every)));
        }
        let title = format!("{} {}", sensor.id, say!(lang, "residual"));
        figures.push(Figure::new(caption, Chart::Residuals(rows, title, sensor.unit.clone()), true));
    }
    figures
}

/// The normal plot and the correlation map.
pub(super) fn spread_figures(report: &FitReport, lang: Language) -> Vec<Figure> {
    let mut figures = Vec::new();
    let studentized: Vec<f64> = report.readings.iter().filter_map(|r| r.studentized).collect();
    if studentized.len() > 2 {
        let caption = say!(lang, "normal-plot-of-the-studentized-residuals-with");
        figures.push(Figure::new(caption, Chart::Normal(studentized), false));
    }
    let order: Vec<&str> = report.covariance.order.iter().map(String::as_str).collect();
    if (2..=MOST_ROWS).contains(&order.len()) {
        let matrix = correlations(report);
        figures.push(Figure {
            caption: say!(lang, "correlations-of-the-estimates-in-hundredths-blue").into(),
            description: strongest(&order, &matrix, lang),
            wide: order.len() > 14,
            chart: Chart::Correlation(order.into_iter().map(String::from).collect(), matrix),
        });
    }
    figures
}

fn correlations(report: &FitReport) -> Vec<Vec<Option<f64>>> {
    let matrix = &report.covariance.matrix;
    let at = |i: usize, j: usize| matrix.get(i).and_then(|row| row.get(j)).copied().flatten();
    (0..matrix.len())
        .map(|i| {
            (0..matrix.len())
                .map(|j| {
                    let scale = (at(i, i)? * at(j, j)?).sqrt();
                    Some(if scale > 0.0 { at(i, j)? / scale } else { 0.0 })
                })
                .collect()
        })
        .collect()
}

/// What a figure lists, in words; long lists are cut.
fn listed(lines: impl Iterator<Item = String>, lang: Language) -> String {
    const MOST: usize = 12;
    lang.sentence(&lang.first_of(&lines.collect::<Vec<_>>(), MOST, lang.semicolon()))
}

/// The parts of a bar, in words.
fn shares(bar: &Bar, lang: Language) -> String {
    let whole: f64 = bar.parts.iter().map(|part| part.size).sum();
    let part = |part: &Part| format!("{} {:.0} %", part.source, 100.0 * part.size / whole.max(f64::MIN_POSITIVE));
    bar.parts.iter().map(part).collect::<Vec<_>>().join(lang.comma())
}

/// The largest correlation, in words.
fn strongest(order: &[&str], matrix: &[Vec<Option<f64>>], lang: Language) -> String {
    let mut best: Option<(f64, &str, &str)> = None;
    for (i, row) in matrix.iter().enumerate() {
        for (j, r) in row.iter().enumerate().take(i) {
            if let (Some(r), Some(a), Some(b)) = (r, order.get(j), order.get(i))
                && best.is_none_or(|(before, ..)| r.abs() > before.abs())
            {
                best = Some((*r, a, b));
            }
        }
    }
    let best = best.map_or(say!(lang, "none").into(), |(r, a, b)| format!("r({a}, {b}) = {r:.2}"));
    lang.title(&format!("{}{}{best}", say!(lang, "strongest-correlation"), lang.colon()))
}
