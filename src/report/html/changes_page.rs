//! The pages of two calibrations of one unit, and of the history of many.

use super::{Align, Figure, Page, Section, Table, Tone, cells};
use crate::error::Result;
use crate::language::{Language, say};
use crate::report::plot::{self, History, Interval};
use crate::report::table::{rounded, significant};
use crate::report::{CalibratedReport, ChangesReport, HistoryReport, VERSION, date_of};

/// The page of two calibrations.
pub fn changes_page(report: &ChangesReport, lang: Language) -> Result<Page> {
    let mut page = Page::new(say!(lang, "two-calibrations-of-one-unit"));
    page.language = lang;
    page.subtitle = say!(lang, "what-changed-by-more-than-the-uncertainties").into();
    page.facts = vec![
        (say!(lang, "title-before").into(), who(&report.before, lang)),
        (say!(lang, "title-after").into(), who(&report.after, lang)),
    ];
    page.colophon =
        vec![(say!(lang, "made-by").into(), say!(lang, "tumble-the-same-inputs-give-the-same", version = VERSION))];
    let mut answer = Section::new(say!(lang, "the-answer"));
    let changed: Vec<&str> =
        report.changes.iter().filter(|c| c.significant == Some(true)).map(|c| c.id.as_str()).collect();
    answer = match (changed.as_slice(), report.together) {
        ([], Some(t)) if t.significant => answer
            .verdict(Tone::Bad, say!(lang, "the-unit-has-changed-all-parameters-together", p = significant(t.p, 2))),
        ([], _) => answer.verdict(Tone::Good, say!(lang, "no-quantity-changed-by-more-than-the")),
        (ids, _) => answer.verdict(
            Tone::Bad,
            say!(lang, "changed-by-more-than-the-uncertainties-allow", ids = cells::names(ids, lang)),
        ),
    };
    for doubt in crate::report::changes::doubts(report, lang) {
        answer = answer.prose(lang.sentence(&doubt));
    }
    answer = answer.prose(match report.shared.as_slice() {
        [] => say!(lang, "no-input-is-shared-both-calibrations-count").to_string(),
        shared => {
            say!(lang, "shared-by-both-calibrations-and-therefore-not", shared = cells::names(shared, lang))
        }
    });
    let level = cells::level(report.level);
    let mut table = Table::new(&[
        (say!(lang, "quantity"), Align::Left),
        (say!(lang, "before"), Align::Decimal),
        (say!(lang, "after"), Align::Decimal),
        (say!(lang, "difference"), Align::Decimal),
        (&format!("U ({level})"), Align::Decimal),
        ("E_n", Align::Decimal),
        (say!(lang, "per-day"), Align::Decimal),
        (say!(lang, "unit"), Align::Left),
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
    table.note = say!(lang, "u-expanded-uncertainty-of-the-difference-e-2").into();
    let bars: Vec<Interval> = report
        .changes
        .iter()
        .filter_map(|c| Some(Interval { label: c.id.clone(), value: c.e_n?, expanded: 1.0, at_bound: None }))
        .collect();
    let figure = Figure {
        svg: plot::values(&bars, say!(lang, "difference-over-u-bars-u"), lang)?,
        caption: say!(lang, "differences-of-the-two-calibrations-over-their").into(),
        description: say!(lang, "each-difference-over-its-expanded-uncertainty-a").into(),
        ..Figure::default()
    };
    let mut combined = Table::new(&[
        (say!(lang, "quantity"), Align::Left),
        (say!(lang, "combined"), Align::Decimal),
        ("u", Align::Decimal),
        (say!(lang, "birge-ratio"), Align::Decimal),
        (say!(lang, "unit"), Align::Left),
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
    combined.note = say!(lang, "the-weighted-mean-of-both-its-u").into();
    Ok(page
        .section(answer.table(table).figures(vec![figure]))
        .section(Section::new(say!(lang, "combined-estimate")).table(combined)))
}

fn who(c: &CalibratedReport, lang: Language) -> String {
    let serial = c.serial.as_ref().map(|serial| say!(lang, "identity-serial", serial));
    [serial, c.date.clone(), Some(c.file.clone())].into_iter().flatten().collect::<Vec<_>>().join(lang.clause())
}

/// The page of many calibrations.
pub fn history_page(report: &HistoryReport, lang: Language) -> Result<Page> {
    let mut page = Page::new(say!(lang, "history-of-calibrations", calibrations = report.calibrations.len()));
    page.language = lang;
    page.subtitle = say!(lang, "each-quantity-over-time-with-its-trend").into();
    page.facts = report.calibrations.iter().map(|c| (c.date.clone().unwrap_or_default(), who(c, lang))).collect();
    page.colophon =
        vec![(say!(lang, "made-by").into(), say!(lang, "tumble-the-same-inputs-give-the-same", version = VERSION))];
    let mut answer = Section::new(say!(lang, "the-answer"));
    let drifts: Vec<&str> =
        report.trends.iter().filter(|t| t.significant == Some(true)).map(|t| t.id.as_str()).collect();
    answer = if drifts.is_empty() {
        answer.verdict(Tone::Good, say!(lang, "no-quantity-drifts-by-more-than-its"))
    } else {
        answer.verdict(
            Tone::Caution,
            say!(lang, "drift-beyond-the-scatter-of-the-calibrations", drifts = cells::names(&drifts, lang)),
        )
    };
    for t in &report.trends {
        if let Some(day) = t.leaves {
            // a line says where a quantity goes; whether it conforms, each calibration says
            let (id, day) = (&t.id, date_of(day));
            let text = match t.has_left() {
                true => say!(lang, "left-its-limits-about-2", id, day),
                false => say!(lang, "leaves-its-limits-about-2", id, day),
            };
            answer = answer.verdict(Tone::Caution, text);
        }
    }
    let year = 365.2425;
    let mut table = Table::new(&[
        (say!(lang, "quantity"), Align::Left),
        ("n", Align::Right),
        (say!(lang, "last"), Align::Decimal),
        (say!(lang, "per-year"), Align::Decimal),
        ("u", Align::Decimal),
        (say!(lang, "birge-ratio"), Align::Decimal),
        (say!(lang, "unit"), Align::Left),
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
            svg: plot::history(
                &History { label: t.id.clone(), unit: t.unit.clone(), points, trend, limits: t.limits },
                lang,
            )?,
            caption: say!(lang, "over-time", id = t.id),
            description: say!(lang, "with-bars-of-u-dashed-limits-line", id = t.id),
            ..Figure::default()
        });
    }
    Ok(page.section(answer.table(table)).section(Section::new(say!(lang, "over-time-2")).figures(figures)))
}
