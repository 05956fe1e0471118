//! The figures of a fit, each with its caption and its words.

use super::fit::Shown;
use super::{ARCSEC, BudgetReport, FitReport, ReadingReport, scatter};
use crate::document::Figure;
use crate::document::chart::{Bar, Chart, Interval, Part, Residual};
use crate::document::number::{level, rounded, significant};
use crate::fit::{Fit, State};
use crate::language::{Language, say};
use crate::uncertainty::Evaluation;
use crate::wire::CovarianceFile;

/// Studentized residuals beyond this are marked.
pub(super) const FAR: f64 = 3.0;

/// More rows than this are no figure any more.
const MOST_ROWS: usize = 60;
/// More readings of a sensor than this are thinned; those far out stay.
const MOST_POINTS: usize = 1500;

/// Parts of a bar of length `u`: each source by its share of the variance, large ones first; the smallest together.
fn parts(budget: &[BudgetReport], u: f64, lang: Language) -> Vec<Part> {
    let mut lines: Vec<&BudgetReport> = budget.iter().filter(|line| line.share > 5e-3).collect();
    lines.sort_by(|a, b| a.of.evaluation.cmp(&b.of.evaluation).then(b.share.total_cmp(&a.share)));
    lines
        .iter()
        .map(|line| Part {
            source: scatter::source_name(&line.of.source, lang),
            type_b: line.of.evaluation == Evaluation::TypeB,
            size: u * line.share,
        })
        .collect()
}

/// Angles with error bars, and their standard uncertainties by source.
pub(super) fn estimate_figures(report: &FitReport, lang: Language) -> Vec<Figure> {
    let angles = report.quantities().filter(|q| q.is_angle);
    let angles = angles.filter_map(|q| Some((q, q.value?, q.u?, q.expanded?))).take(MOST_ROWS);
    let angles: Vec<(Shown<'_>, f64, f64, f64)> = angles.collect();
    if angles.is_empty() {
        return Vec::new();
    }
    let at_bound = |id: &str| {
        let parameter = report.parameters.iter().find(|p| p.id == id && p.state == State::AtBound)?;
        parameter.interval.map(|ends| ends.map(|end| end * ARCSEC))
    };
    let interval = |(q, value, _, expanded): &(Shown<'_>, f64, f64, f64)| Interval {
        label: q.id.into(),
        value: *value,
        expanded: *expanded,
        at_bound: at_bound(q.id),
    };
    let rows: Vec<Interval> = angles.iter().map(interval).collect();
    let bars = angles.iter().map(|(q, _, u, _)| Bar { label: q.id.into(), parts: parts(q.budget, *u, lang) });
    let bars: Vec<Bar> = bars.collect();
    let held = rows.iter().any(|row| row.at_bound.is_some()).then(|| say!(lang, "angles-at-bounds").to_string());
    let caption = say!(lang, "angles-with-their-expanded-uncertainties", level = level(report.level()));
    let values = angles.iter().map(|(q, value, u, expanded)| {
        format!("{} {} \u{b1} {} arcsec", q.id, rounded(*value, Some(*u)), significant(*expanded, 3))
    });
    let sizes = bars.iter().zip(&angles).map(|(bar, (q, _, u, _))| {
        format!("{} u = {} arcsec{}", q.id, significant(*u, 3), lang.in_parentheses(&shares(bar, lang)))
    });
    let [values, sizes] = [listed(values, lang), listed(sizes, lang)];
    let caption = [Some(caption), held].into_iter().flatten().collect::<Vec<_>>().join(lang.space());
    let divided = say!(lang, "standard-uncertainties-divided-by-each-sources-share");
    let bars = Chart::Bars(bars, say!(lang, "standard-uncertainty").into(), "arcsec".into(), false);
    vec![
        Figure::new(caption, Chart::Values(rows, "arcsec".into()), false).described(values),
        Figure::new(divided, bars, false).described(sizes),
    ]
}

/// Shares of the variance for coefficients, where there is more than one source.
pub(super) fn budget_figures(report: &FitReport, lang: Language) -> Vec<Figure> {
    let bars: Vec<Bar> = report
        .quantities()
        .filter(|quantity| !quantity.is_angle && !quantity.budget.is_empty())
        .map(|quantity| Bar { label: quantity.id.into(), parts: parts(quantity.budget, 100.0, lang) })
        .take(MOST_ROWS)
        .collect();
    if bars.iter().all(|bar| bar.parts.len() < 2) {
        return Vec::new();
    }
    let caption = say!(lang, "coefficients-each-sources-share-of-the-variance");
    let said = listed(bars.iter().map(|bar| format!("{}: {}", bar.label, shares(bar, lang))), lang);
    let chart = Chart::Bars(bars, say!(lang, "share").into(), "%".into(), true);
    vec![Figure::new(caption, chart, true).described(said)]
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
        let readings: Vec<_> = report.readings.iter().filter(|r| r.sensor == sensor.id).collect();
        if readings.is_empty() {
            continue;
        }
        let every = readings.len().div_ceil(MOST_POINTS).max(1);
        let is_far = |s: Option<f64>| s.is_some_and(|s| s.abs() > FAR);
        let rows: Vec<Residual> = readings
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
        let far: Vec<String> = readings.iter().filter(|r| is_far(r.studentized)).map(|r| r.index.to_string()).collect();
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

pub(super) fn spread_figures(report: &FitReport, lang: Language) -> Vec<Figure> {
    let mut figures = Vec::new();
    let studentized: Vec<f64> = report.readings.iter().filter_map(|r| r.studentized).collect();
    if studentized.len() > 2 {
        let caption = say!(lang, "normal-plot-of-the-studentized-residuals-with");
        figures.push(Figure::new(caption, Chart::Normal(studentized), false));
    }
    let CovarianceFile { order, matrix } = &report.correlation;
    if (2..=MOST_ROWS).contains(&order.len()) {
        let caption = say!(lang, "correlations-of-the-estimates-in-hundredths-blue");
        let chart = Chart::Correlation(order.clone(), matrix.clone());
        figures.push(Figure::new(caption, chart, order.len() > 14).described(strongest(order, matrix, lang)));
    }
    figures
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
fn strongest(order: &[String], matrix: &[Vec<Option<f64>>], lang: Language) -> String {
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
