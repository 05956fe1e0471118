//! The pages of two calibrations of one unit, and of the history of many.

use super::{Align, Figure, Page, Section, Table, Tone, cells};
use crate::error::Result;
use crate::report::plot::{self, History, Interval};
use crate::report::table::{rounded, significant};
use crate::report::{CalibratedReport, ChangesReport, HistoryReport, VERSION, date_of};

/// The page of two calibrations.
pub fn changes_page(report: &ChangesReport) -> Result<Page> {
    let mut page = Page::new("Two calibrations of one unit");
    page.subtitle = "What changed, by more than the uncertainties allow".into();
    page.facts = vec![("Before".into(), who(&report.before)), ("After".into(), who(&report.after))];
    page.colophon = vec![("made by".into(), format!("tumble {VERSION}; the same inputs give the same bytes"))];
    let mut answer = Section::new("The answer");
    let changed: Vec<&str> =
        report.changes.iter().filter(|c| c.significant == Some(true)).map(|c| c.id.as_str()).collect();
    answer = match (changed.as_slice(), report.together) {
        ([], Some(t)) if t.significant => answer.verdict(Tone::Bad, format!("The unit has changed: all parameters together differ with p = {}, though no single one is beyond doubt.", significant(t.p, 2))),
        ([], _) => answer.verdict(Tone::Good, "No quantity changed by more than the uncertainties of the two calibrations allow."),
        (ids, _) => answer.verdict(Tone::Bad, format!("Changed by more than the uncertainties allow: {}.", cells::names(ids))),
    };
    answer = answer.prose(match report.shared.as_slice() {
        [] => "No input is shared: both calibrations count as independent.".to_string(),
        shared => format!("Shared by both calibrations, and therefore not counted twice: {}.", cells::names(shared)),
    });
    let level = cells::level(report.level);
    let mut table = Table::new(&[
        ("quantity", Align::Left),
        ("before", Align::Decimal),
        ("after", Align::Decimal),
        ("difference", Align::Decimal),
        (&format!("U ({level})"), Align::Decimal),
        ("E_n", Align::Decimal),
        ("per day", Align::Decimal),
        ("unit", Align::Left),
    ]);
    for c in &report.changes {
        table.row(vec![
            format!("`{}`", c.id),
            rounded(c.before, c.u_before),
            rounded(c.after, c.u_after),
            rounded(c.difference, c.u),
            cells::value(c.expanded, c.u),
            cells::decimals(c.e_n, 2),
            cells::digits(c.per_day, 3),
            c.unit.clone(),
        ]);
        if let Some(row) = table.rows.last_mut().filter(|_| c.significant == Some(true)) {
            row.tone = Tone::Bad;
        }
    }
    table.note = "U: expanded uncertainty of the difference; E_n = difference/U. Marked: significant with all quantities tested together (Holm).".into();
    let bars: Vec<Interval> = report
        .changes
        .iter()
        .filter_map(|c| Some(Interval { label: c.id.clone(), value: c.e_n?, expanded: 1.0 }))
        .collect();
    let figure = Figure {
        svg: plot::values(&bars, "difference over U (bars: U)")?,
        caption: "Differences of the two calibrations over their expanded uncertainties".into(),
        description: "Each difference over its expanded uncertainty: a bar that misses zero is a change.".into(),
        ..Figure::default()
    };
    let mut combined = Table::new(&[
        ("quantity", Align::Left),
        ("combined", Align::Decimal),
        ("u", Align::Decimal),
        ("Birge ratio", Align::Decimal),
        ("unit", Align::Left),
    ]);
    for c in &report.changes {
        combined.row(vec![
            format!("`{}`", c.id),
            cells::value(c.combined, c.u_combined),
            cells::value(c.u_combined, c.u_combined),
            cells::decimals(c.birge, 2),
            c.unit.clone(),
        ]);
    }
    combined.note =
        "The weighted mean of both; its u holds where both agree, that is, where the Birge ratio is not well above 1."
            .into();
    Ok(page
        .section(answer.table(table).figures(vec![figure]))
        .section(Section::new("Combined estimate").table(combined)))
}

fn who(c: &CalibratedReport) -> String {
    let serial = c.serial.as_deref().map(|s| format!("serial {s}, ")).unwrap_or_default();
    let date = c.date.as_deref().map(|d| format!("{d}, ")).unwrap_or_default();
    format!("{serial}{date}{}", c.file)
}

/// The page of many calibrations.
pub fn history_page(report: &HistoryReport) -> Result<Page> {
    let mut page = Page::new(format!("History of {} calibrations", report.calibrations.len()));
    page.subtitle = "Each quantity over time, with its trend and its limits".into();
    page.facts = report.calibrations.iter().map(|c| (c.date.clone().unwrap_or_default(), who(c))).collect();
    page.colophon = vec![("made by".into(), format!("tumble {VERSION}; the same inputs give the same bytes"))];
    let mut answer = Section::new("The answer");
    let drifts: Vec<&str> =
        report.trends.iter().filter(|t| t.significant == Some(true)).map(|t| t.id.as_str()).collect();
    answer = if drifts.is_empty() {
        answer.verdict(Tone::Good, "No quantity drifts by more than its calibrations scatter.")
    } else {
        answer
            .verdict(Tone::Caution, format!("Drift beyond the scatter of the calibrations: {}.", cells::names(&drifts)))
    };
    for t in &report.trends {
        if let Some(day) = t.leaves {
            answer = answer.verdict(Tone::Bad, format!("`{}` leaves its limits about {}.", t.id, date_of(day)));
        }
    }
    let year = 365.2425;
    let mut table = Table::new(&[
        ("quantity", Align::Left),
        ("n", Align::Right),
        ("last", Align::Decimal),
        ("per year", Align::Decimal),
        ("u", Align::Decimal),
        ("Birge ratio", Align::Decimal),
        ("unit", Align::Left),
    ]);
    let mut figures = Vec::new();
    for t in &report.trends {
        let u = t.u_per_day.map(|u| u * year);
        let last = t.points.last();
        table.row(vec![
            format!("`{}`", t.id),
            t.points.len().to_string(),
            last.map_or_else(cells::dash, |(_, v, u)| rounded(*v, *u)),
            cells::value(t.per_day.map(|d| d * year), u),
            cells::value(u, u),
            cells::decimals(t.birge, 2),
            t.unit.clone(),
        ]);
        let calendar = |day: f64| 1970.0 + day / year;
        let trend = t.per_day.zip(t.points.first()).zip(last).filter(|_| t.significant == Some(true)).map(
            |((slope, first), last)| {
                let middle = t.points.iter().map(|p| p.0).sum::<f64>() / t.points.len() as f64;
                let mean = t.points.iter().map(|p| p.1).sum::<f64>() / t.points.len() as f64;
                [first.0, last.0].map(|day| (calendar(day), mean + slope * (day - middle)))
            },
        );
        let points = t.points.iter().map(|(day, v, u)| (calendar(*day), *v, 2.0 * u.unwrap_or(0.0))).collect();
        figures.push(Figure {
            svg: plot::history(&History {
                label: t.id.clone(),
                unit: t.unit.clone(),
                points,
                trend,
                limits: t.limits,
            })?,
            caption: format!("{} over time", t.id),
            description: format!("`{}` with bars of 2 u; dashed: limits; line: trend where it is significant.", t.id),
            ..Figure::default()
        });
    }
    Ok(page.section(answer.table(table)).section(Section::new("Over time").figures(figures)))
}
