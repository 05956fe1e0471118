//! The documents of two calibrations of one unit, and of the history of many.

use super::colophon::begin;
use super::{CalibratedReport, ChangesReport, HistoryReport, changes, date_of};
use crate::compare::calibrations::Together;
use crate::document::chart::{Chart, History, Interval};
use crate::document::number::{dof, level, significant};
use crate::document::{Align, Cell, Detail, Document, Figure, Section, Table, Tone};
use crate::language::{Language, say};

/// The document of two calibrations.
pub fn changes_document(report: &ChangesReport, lang: Language) -> Document {
    let mut document = begin(say!(lang, "two-calibrations-of-one-unit"), &[], lang);
    document.facts = vec![
        (lang.title(say!(lang, "before")), who(&report.before, lang)),
        (lang.title(say!(lang, "after")), who(&report.after, lang)),
    ];
    let mut answer = Section::new(say!(lang, "result"));
    let changed: Vec<&str> =
        report.changes.iter().filter(|c| c.significant == Some(true)).map(|c| c.id.as_str()).collect();
    answer = match changed.as_slice() {
        [] if report.is_changed() => answer,
        ids => {
            let tone = if ids.is_empty() { Tone::Good } else { Tone::Bad };
            answer.verdict(tone, say!(lang, "changed-by-more-than-the-uncertainties-allow", ids = lang.names(ids)))
        }
    };
    if let Some(together) = report.together {
        let tone = if together.significant { Tone::Bad } else { Tone::Plain };
        answer = answer.verdict(tone, all_together(&together, lang));
    }
    for doubt in changes::doubts(report, lang) {
        answer = answer.verdict(Tone::Caution, lang.sentence(&doubt));
    }
    let shared = lang.names(&report.shared);
    answer = answer.prose(say!(lang, "shared-by-both-calibrations-and-therefore-not", shared));
    let mut table = Table::new(&[
        (say!(lang, "quantity"), Align::Left),
        (say!(lang, "before"), Align::Decimal),
        (say!(lang, "after"), Align::Decimal),
        (say!(lang, "difference"), Align::Decimal),
        (&format!("U ({})", level(report.level)), Align::Decimal),
        ("E_n", Align::Decimal),
        (say!(lang, "per-day"), Align::Decimal),
        (say!(lang, "unit"), Align::Left),
    ])
    .at(Detail::Roomy, &[6]);
    for c in &report.changes {
        table.row(vec![
            Cell::name(&c.id),
            Cell::Value(c.before, c.u_before),
            Cell::Value(c.after, c.u_after),
            Cell::Value(c.difference, c.expanded.or(c.u)),
            Cell::value(c.expanded, c.expanded),
            Cell::decimals(c.e_n, 2),
            Cell::digits(c.per_day, 3),
            c.unit.as_str().into(),
        ]);
        table.tone(if c.significant == Some(true) { Tone::Bad } else { Tone::Plain });
    }
    table.note = say!(lang, "u-expanded-uncertainty-of-the-difference-e-2").into();
    let bars: Vec<Interval> = report
        .changes
        .iter()
        .filter_map(|c| Some(Interval { label: c.id.clone(), value: c.e_n?, expanded: 1.0, at_bound: None }))
        .collect();
    let caption = say!(lang, "differences-of-the-two-calibrations-over-their");
    let figure = Figure::new(caption, Chart::Values(bars, "E_n".into()), false);
    let mut combined = Table::new(&[
        (say!(lang, "quantity"), Align::Left),
        (say!(lang, "combined"), Align::Decimal),
        ("u", Align::Decimal),
        (say!(lang, "birge-ratio"), Align::Decimal),
        (say!(lang, "unit"), Align::Left),
    ]);
    for c in &report.changes {
        combined.row(vec![
            Cell::name(&c.id),
            Cell::value(c.combined, c.u_combined),
            Cell::value(c.u_combined, c.u_combined),
            Cell::decimals(c.birge, 2),
            c.unit.as_str().into(),
        ]);
    }
    let mut left_out = Vec::new();
    for (ids, which) in [(&report.only_before, say!(lang, "before")), (&report.only_after, say!(lang, "after"))] {
        if !ids.is_empty() {
            left_out.push(say!(lang, "changes-only", which, ids = ids.join(lang.comma())));
        }
    }
    document.section(answer.table(table).list(left_out).figures(vec![figure])).section(
        Section::new(lang.title(say!(lang, "combined")))
            .table(combined)
            .prose(say!(lang, "the-weighted-mean-of-both-its-u")),
    )
}

/// The test of all parameters together.
fn all_together(t: &Together, lang: Language) -> String {
    let test = match t.scatter_dof {
        Some(scatter) => {
            let f = significant(t.statistic / t.dof as f64, 3);
            say!(lang, "f-test", f, between_dof = t.dof, pure_error_dof = dof(scatter))
        }
        None => say!(lang, "chi-square-with-degrees-of-freedom", statistic = significant(t.statistic, 4), dof = t.dof),
    };
    say!(lang, "all-parameters-together-p", test, p = significant(t.p, 2), changed = t.significant)
}

fn who(c: &CalibratedReport, lang: Language) -> String {
    let serial = c.serial.as_ref().map(|serial| format!("{} {serial}", say!(lang, "serial")));
    [serial, c.date.clone(), Some(c.file.clone())].into_iter().flatten().collect::<Vec<_>>().join(lang.clause())
}

/// The document of many calibrations.
pub fn history_document(report: &HistoryReport, lang: Language) -> Document {
    let mut document =
        begin(say!(lang, "history-of-calibrations", calibrations = report.calibrations.len()), &[], lang);
    document.facts = report.calibrations.iter().map(|c| (c.date.clone().unwrap_or_default(), who(c, lang))).collect();
    let mut answer = Section::new(say!(lang, "result"));
    let drifts: Vec<&str> =
        report.trends.iter().filter(|t| t.significant == Some(true)).map(|t| t.id.as_str()).collect();
    let tone = if drifts.is_empty() { Tone::Good } else { Tone::Caution };
    let drifts = lang.names(drifts);
    answer = answer.verdict(tone, say!(lang, "drift-beyond-the-scatter-of-the-calibrations", drifts));
    for t in &report.trends {
        if let Some(day) = t.leaves {
            // a line says where a quantity goes; whether it conforms, each calibration says
            let (id, day) = (&t.id, date_of(day));
            answer = answer.verdict(Tone::Caution, say!(lang, "leaves-its-limits", past = t.has_left(), id, day));
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
            Cell::name(&t.id),
            t.points.len().into(),
            last.map_or_else(Cell::absent, |(_, v, u)| Cell::Value(*v, *u)),
            Cell::value(t.per_day.map(|d| d * year), u),
            Cell::value(u, u),
            Cell::decimals(t.birge, 2),
            t.unit.as_str().into(),
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
        let caption = format!("{}{}{}", t.id, lang.colon(), say!(lang, "over-time"));
        let history = History { label: t.id.clone(), unit: t.unit.clone(), points, trend, limits: t.limits };
        figures.push(Figure::new(caption, Chart::History(history), false));
    }
    let figures = Section::new(lang.title(say!(lang, "over-time")))
        .full()
        .prose(say!(lang, "bars-limits-and-trend"))
        .figures(figures);
    document.section(answer.table(table)).section(figures)
}
