//! The figures of a fit, each with its caption and its words.

use super::{FAR, Figure, cells};
use crate::campaign::Kind;
use crate::error::Result;
use crate::fit::Fit;
use crate::report::plot::{self, Bar, Interval, Part, Residual};
use crate::report::table::{rounded, significant};
use crate::report::{BudgetReport, FitReport};
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
}

fn angles(report: &FitReport) -> Vec<Angle<'_>> {
    let parameters = report.parameters.iter().map(|p| (p.id.as_str(), p.arcsec, p.budget.as_slice()));
    let derived = report.derived.iter().map(|d| (d.id.as_str(), d.arcsec, d.budget.as_slice()));
    parameters
        .chain(derived)
        .filter_map(|(id, arcsec, budget)| {
            let a = arcsec?;
            Some(Angle { id, value: a.value?, expanded: a.expanded?, u: a.u?, budget })
        })
        .take(MOST_ROWS)
        .collect()
}

/// Parts of a bar of length `u`: each source by its share of the variance, large ones first; the smallest together.
fn parts(budget: &[BudgetReport], u: f64) -> Vec<Part> {
    let mut lines: Vec<&BudgetReport> = budget.iter().filter(|line| line.share > 5e-3).collect();
    lines.sort_by(|a, b| a.evaluation.cmp(&b.evaluation).then(b.share.total_cmp(&a.share)));
    lines
        .iter()
        .map(|line| Part {
            source: line.source.clone(),
            type_b: line.evaluation == Evaluation::TypeB,
            size: u * line.share,
        })
        .collect()
}

/// Angles with error bars, and their standard uncertainties by source.
pub(super) fn estimate_figures(report: &FitReport) -> Result<Vec<Figure>> {
    let angles = angles(report);
    if angles.is_empty() {
        return Ok(Vec::new());
    }
    let rows: Vec<Interval> =
        angles.iter().map(|a| Interval { label: a.id.into(), value: a.value, expanded: a.expanded }).collect();
    let bars: Vec<Bar> = angles.iter().map(|a| Bar { label: a.id.into(), parts: parts(a.budget, a.u) }).collect();
    let level = report.parameters.first().map_or(0.95, |p| p.level);
    Ok(vec![
        Figure {
            caption: format!("Angles with their expanded uncertainties ({}).", cells::level(level)),
            description: listed(
                angles.iter().map(|a| {
                    format!("{} {} +- {} arcsec", a.id, rounded(a.value, Some(a.u)), significant(a.expanded, 3))
                }),
            ),
            svg: plot::values(&rows, "arcsec")?,
            wide: false,
        },
        Figure {
            caption: "Standard uncertainties, divided by each source's share of the variance.".into(),
            description: listed(
                bars.iter()
                    .zip(&angles)
                    .map(|(bar, a)| format!("{}: u {} arcsec, {}", a.id, significant(a.u, 3), shares(bar))),
            ),
            svg: plot::bars(&bars, ("standard uncertainty", "arcsec"), plot::HALF)?,
            wide: false,
        },
    ])
}

/// Shares of the variance for coefficients, where there is more than one source.
pub(super) fn budget_figures(report: &FitReport) -> Result<Vec<Figure>> {
    let parameters = report.parameters.iter().filter(|p| p.kind != Kind::Tilt).map(|p| (&p.id, &p.budget));
    let derived = report.derived.iter().filter(|d| d.arcsec.is_none()).map(|d| (&d.id, &d.budget));
    let bars: Vec<Bar> = parameters
        .chain(derived)
        .filter(|(_, budget)| !budget.is_empty())
        .map(|(id, budget)| Bar { label: id.clone(), parts: parts(budget, 100.0) })
        .take(MOST_ROWS)
        .collect();
    if bars.iter().all(|bar| bar.parts.len() < 2) {
        return Ok(Vec::new());
    }
    Ok(vec![Figure {
        caption: "Coefficients: each source's share of the variance. Sources below 0.5 % are left white.".into(),
        description: listed(bars.iter().map(|bar| format!("{}: {}", bar.label, shares(bar)))),
        svg: plot::bars(&bars, ("share of the variance", "%"), plot::WIDE)?,
        wide: true,
    }])
}

/// Residuals of each sensor in order, with the band in which each should lie.
pub(super) fn residual_figures(fit: &Fit, report: &FitReport) -> Result<Vec<Figure>> {
    let mut figures = Vec::new();
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
                value: r.residual,
                band: r.u.map(|u| 2.0 * u * r.redundancy.max(0.0).sqrt()),
                far: is_far(r.studentized),
            })
            .collect();
        let far: Vec<String> = own.iter().filter(|r| is_far(r.studentized)).map(|r| r.index.to_string()).collect();
        let beyond = match far.len() {
            0 => format!("None lies beyond {FAR} standard deviations."),
            1..=12 => format!("Diamonds lie beyond {FAR} standard deviations: reading {}.", far.join(", ")),
            n => format!("Diamonds, {n} of them, lie beyond {FAR} standard deviations."),
        };
        let thinned = if every > 1 { format!(" One reading in {every} is drawn.") } else { String::new() };
        figures.push(Figure {
            caption: format!("Residuals of {} before bands of two standard deviations. {beyond}{thinned}", sensor.id),
            description: format!("Residuals of {}: {beyond}", sensor.id),
            svg: plot::residuals(&rows, &format!("{} residual", sensor.id), &sensor.unit)?,
            wide: true,
        });
    }
    Ok(figures)
}

/// The normal plot and the correlation map.
pub(super) fn spread_figures(report: &FitReport) -> Result<Vec<Figure>> {
    let mut figures = Vec::new();
    let studentized: Vec<f64> = report.readings.iter().filter_map(|r| r.studentized).collect();
    if studentized.len() > 2 {
        figures.push(Figure {
            caption: "Normal plot of the studentized residuals with its pointwise 95 % band: normal residuals follow the line.".into(),
            description: farthest(&studentized),
            svg: plot::normal(&studentized)?,
            wide: false,
        });
    }
    let order: Vec<&str> = report.covariance.order.iter().map(String::as_str).collect();
    if (2..=MOST_ROWS).contains(&order.len()) {
        let matrix = correlations(report);
        figures.push(Figure {
            caption: "Correlations of the estimates, in hundredths: blue positive, orange negative, crosses where not estimable."
                .into(),
            description: strongest(&order, &matrix),
            svg: plot::correlation(&order, &matrix)?,
            wide: order.len() > 14,
        });
    }
    Ok(figures)
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
fn listed(lines: impl Iterator<Item = String>) -> String {
    const MOST: usize = 12;
    let lines: Vec<String> = lines.collect();
    let mut text = lines.iter().take(MOST).cloned().collect::<Vec<_>>().join("; ");
    if lines.len() > MOST {
        text.push_str(&format!("; and {} more, as in the table", lines.len() - MOST));
    }
    text + "."
}

/// The parts of a bar, in words.
fn shares(bar: &Bar) -> String {
    let whole: f64 = bar.parts.iter().map(|part| part.size).sum();
    let part = |part: &Part| format!("{} {:.0} %", part.source, 100.0 * part.size / whole.max(f64::MIN_POSITIVE));
    bar.parts.iter().map(part).collect::<Vec<_>>().join(", ")
}

/// The residuals of a normal plot, in words.
fn farthest(studentized: &[f64]) -> String {
    let (low, high) = studentized.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let n = studentized.len();
    format!("{n} studentized residuals, from {} to {}.", significant(low, 3), significant(high, 3))
}

/// The largest correlation, in words.
fn strongest(order: &[&str], matrix: &[Vec<Option<f64>>]) -> String {
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
    best.map_or("No correlation.".into(), |(r, a, b)| format!("Strongest correlation: {r:.2} between {a} and {b}."))
}
