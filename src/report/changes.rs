//! Two calibrations of one unit side by side, and the history of many (`tumble compare A B`): their reports and documents.

use super::fit::Shown;
use super::provenance::begin;
use super::{BudgetReport, FitReport, ReportKind, VERSION};
use crate::compare::calibrations::{Change, Changes, Determination, InputShare, Quantity, Together, Trend};
use crate::document::chart::{Chart, History, Interval};
use crate::document::number::{dof, level, significant};
use crate::document::{Cell, Detail, Document, Figure, Rows, Section, Tone};
use crate::language::{Language, say};
use crate::number;
use nalgebra::DMatrix;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What `tumble compare A B --json` writes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct ChangesReport {
    /// Version of the program that wrote it.
    pub tumble: String,
    /// Always `compare-calibrations`.
    #[schemars(extend("const" = "compare-calibrations"))]
    pub report: ReportKind,
    /// The earlier calibration.
    pub before: CalibratedReport,
    /// The later one.
    pub after: CalibratedReport,
    /// What changed.
    #[serde(flatten)]
    pub found: Changes,
}

/// A calibration that was compared.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CalibratedReport {
    /// Its file.
    pub file: String,
    /// Its bench.
    pub bench: String,
    /// Its date (`YYYY-MM-DD`).
    pub date: Option<String>,
    /// Serial number of the unit.
    pub serial: Option<String>,
}

/// A calibration's results, ready to be compared: angles in arcsec.
pub fn determination(name: &str, report: &FitReport, day: Option<f64>) -> Determination {
    let known = |source: &BudgetReport, scale: f64| {
        Some(InputShare {
            id: source.of.source.clone(),
            estimate: source.of.estimate?,
            u: source.of.source_u?,
            c: source.of.sensitivity? * scale,
        })
    };
    let quantity = |shown: &Shown<'_>| {
        Some(Quantity {
            id: shown.id.into(),
            unit: shown.unit.into(),
            value: shown.value?,
            u: shown.u,
            dof: shown.dof.unwrap_or(f64::INFINITY),
            inputs: shown.budget.iter().filter_map(|source| known(source, shown.scale)).collect(),
        })
    };
    let all: Vec<Shown<'_>> = report.quantities().filter(|shown| shown.value.is_some()).collect();
    // derived quantities have no covariance, and none has the name of a parameter
    let place = |shown: &Shown<'_>| report.covariance.order.iter().position(|id| id == shown.id);
    let element = |i: usize, j: usize| {
        let (a, b) = (all.get(i)?, all.get(j)?);
        let value = (*report.covariance.matrix.get(place(a)?)?.get(place(b)?)?)?;
        Some(value * a.scale * b.scale)
    };
    let n = all.len();
    let covariance = DMatrix::from_fn(n, n, |i, j| element(i, j).unwrap_or(f64::NAN));
    let quantities = all.iter().filter_map(quantity).collect();
    Determination { name: name.into(), day, quantities, covariance, correlations: report.correlations.clone() }
}

/// The report of two calibrations.
pub fn changes_report(changes: &Changes, before: CalibratedReport, after: CalibratedReport) -> ChangesReport {
    let (tumble, report) = (VERSION.into(), ReportKind::CompareCalibrations);
    ChangesReport { tumble, report, before, after, found: changes.clone() }
}

impl ChangesReport {
    /// Did anything change by more than the uncertainties allow?
    pub(crate) fn is_changed(&self) -> bool {
        let Changes { together, changes, .. } = &self.found;
        together.is_some_and(|t| t.significant) || changes.iter().any(|c| c.significant == Some(true))
    }
}

/// What the reports say of themselves that two calibrations of one unit, one after the other, would not.
fn doubts(report: &ChangesReport, lang: Language) -> Vec<String> {
    let (before, after) = (&report.before, &report.after);
    let units = before.serial.as_ref().zip(after.serial.as_ref()).filter(|(first, second)| first != second);
    let dates = before.date.as_ref().zip(after.date.as_ref()).filter(|(first, second)| first > second);
    let units = units.map(|(first, second)| say!(lang, "reports-are-of-two-units", first, second));
    let dates = dates.map(|(first, second)| say!(lang, "first-report-is-the-later-one", first, second));
    units.into_iter().chain(dates).collect()
}

/// What `tumble compare A B C ... --json` writes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct HistoryReport {
    /// Version of the program that wrote it.
    pub tumble: String,
    /// Always `compare-history`.
    #[schemars(extend("const" = "compare-history"))]
    pub report: ReportKind,
    /// The calibrations, by date.
    pub calibrations: Vec<CalibratedReport>,
    /// Coverage probability.
    pub level: f64,
    /// Each quantity over time (angles in arcsec).
    pub trends: Vec<Trend>,
}

/// The report of many calibrations.
pub fn history_report(calibrations: Vec<CalibratedReport>, trends: Vec<Trend>, level: f64) -> HistoryReport {
    HistoryReport { tumble: VERSION.into(), report: ReportKind::CompareHistory, calibrations, level, trends }
}

/// The date of a day counted from 1970-01-01; beyond the year 9999 the year alone.
pub fn date_of(day: f64) -> String {
    let days = jiff::Span::new().try_days(number::whole_i64(day.floor()));
    let date = days.and_then(|days| jiff::civil::date(1970, 1, 1).checked_add(days));
    date.map_or_else(|_| format!("{:.0}", 1970.0 + day / YEAR), |date| date.to_string())
}

/// Mean year of the Gregorian calendar, days.
const YEAR: f64 = 365.2425;

/// The document of two calibrations.
pub fn changes_document(report: &ChangesReport, lang: Language) -> Document {
    let found = &report.found;
    let changed = found.changes.iter().filter(|c| c.significant == Some(true)).map(|c| c.id.as_str());
    let changed: Vec<&str> = changed.collect();
    let alone = found.changes.iter().filter(|c| c.significant == Some(false) && c.e_n.is_some_and(|e| e.abs() > 1.0));
    let alone: Vec<&str> = alone.map(|c| c.id.as_str()).collect();
    let beyond = (!alone.is_empty()).then(|| {
        let tested = found.changes.iter().filter(|c| c.significant.is_some()).count();
        (Tone::Caution, say!(lang, "beyond-u-but-not-together", ids = lang.names(alone), tested))
    });
    let single = match changed.as_slice() {
        [] if report.is_changed() || beyond.is_some() => None,
        ids => {
            let tone = if ids.is_empty() { Tone::Good } else { Tone::Bad };
            Some((tone, say!(lang, "changed-by-more-than-the-uncertainties-allow", ids = lang.names(ids))))
        }
    };
    let together = found.together.map(|together| {
        let tone = if together.significant { Tone::Bad } else { Tone::Plain };
        (tone, all_together(&together, lang))
    });
    let table = Rows::of(&found.changes)
        .name(say!(lang, "quantity"), |c| &c.id)
        .decimal(say!(lang, "before"), |c| Cell::Value(c.before, c.u_before))
        .decimal(say!(lang, "after"), |c| Cell::Value(c.after, c.u_after))
        .decimal(say!(lang, "difference"), |c| Cell::Value(c.difference, c.expanded.or(c.u)))
        .decimal(format!("U ({})", level(found.level)), |c| Cell::value(c.expanded, c.expanded))
        .decimal("E_n", |c| Cell::decimals(c.e_n, 2))
        .decimal(say!(lang, "per-day"), |c| Cell::digits(c.per_day, 3))
        .at(Detail::Roomy)
        .left(say!(lang, "unit"), |c| &c.unit)
        .tone(|c| if c.significant == Some(true) { Tone::Bad } else { Tone::Plain })
        .note(say!(lang, "u-expanded-uncertainty-of-the-difference-e-2"));
    let bar = |c: &Change| Some(Interval { label: c.id.clone(), value: c.e_n?, expanded: 1.0, at_bound: None });
    let bars = Chart::Values(found.changes.iter().filter_map(bar).collect(), "E_n".into());
    let caption = say!(lang, "differences-of-the-two-calibrations-over-their");
    let combined = Rows::of(&found.changes)
        .name(say!(lang, "quantity"), |c| &c.id)
        .decimal(say!(lang, "combined"), |c| Cell::value(c.combined, c.u_combined))
        .decimal("u", |c| Cell::value(c.u_combined, c.u_combined))
        .decimal(say!(lang, "birge-ratio"), |c| Cell::decimals(c.birge, 2))
        .left(say!(lang, "unit"), |c| &c.unit);
    let only = [(&found.only_before, say!(lang, "before")), (&found.only_after, say!(lang, "after"))];
    let only = only.into_iter().filter(|(ids, _)| !ids.is_empty());
    let answer = Section::new(say!(lang, "result"))
        .verdicts(single)
        .verdicts(beyond)
        .verdicts(together)
        .verdicts(doubts(report, lang).into_iter().map(|doubt| (Tone::Caution, lang.sentence(&doubt))))
        .prose(say!(lang, "shared-by-both-calibrations-and-therefore-not", shared = lang.names(&found.shared)))
        .table(table)
        .list(only.map(|(ids, which)| say!(lang, "changes-only", which, ids = ids.join(lang.comma()))))
        .figures([Figure::new(caption, bars, false)]);
    let mean = Section::new(lang.title(say!(lang, "combined")));
    begin(say!(lang, "two-calibrations-of-one-unit"), &[], lang)
        .fact(lang.title(say!(lang, "before")), who(&report.before, lang))
        .fact(lang.title(say!(lang, "after")), who(&report.after, lang))
        .section(answer)
        .section(mean.table(combined).prose(say!(lang, "the-weighted-mean-of-both-its-u")))
}

/// The test of all parameters together.
fn all_together(t: &Together, lang: Language) -> String {
    let test = match t.scatter_dof {
        Some(scatter) => {
            let f = significant(t.statistic / t.dof as f64, 3);
            say!(lang, "f-test", is_of = false, sensor = "", f, between_dof = t.dof, pure_error_dof = dof(scatter))
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
    let calibrations = &report.calibrations;
    let drifts = report.trends.iter().filter(|t| t.significant == Some(true)).map(|t| t.id.as_str());
    let drifts: Vec<&str> = drifts.collect();
    let tone = if drifts.is_empty() { Tone::Good } else { Tone::Caution };
    let drifts = say!(lang, "drift-beyond-the-scatter-of-the-calibrations", drifts = lang.names(drifts));
    // a line says where a quantity goes; whether it conforms, each calibration says
    let left = report.trends.iter().filter_map(|t| {
        let (id, day) = (&t.id, date_of(t.leaves?));
        Some((Tone::Caution, say!(lang, "leaves-its-limits", past = t.has_left(), id, day)))
    });
    let u = |t: &Trend| t.u_per_day.map(|u| u * YEAR);
    let table = Rows::of(&report.trends)
        .name(say!(lang, "quantity"), |t| &t.id)
        .right("n", |t| t.points.len())
        .decimal(say!(lang, "last"), |t| t.points.last().map(|(_, v, u)| Cell::Value(*v, *u)))
        .decimal(say!(lang, "per-year"), |t| Cell::value(t.per_day.map(|d| d * YEAR), u(t)))
        .decimal("u", |t| Cell::value(u(t), u(t)))
        .decimal(say!(lang, "birge-ratio"), |t| Cell::decimals(t.birge, 2))
        .left(say!(lang, "unit"), |t| &t.unit);
    let figure = |t: &Trend| {
        let calendar = |day: f64| 1970.0 + day / YEAR;
        let slope = t.per_day.filter(|_| t.significant == Some(true));
        let trend = slope.zip(t.points.first()).zip(t.points.last()).map(|((slope, first), last)| {
            let mean =
                |of: fn(&(f64, f64, Option<f64>)) -> f64| t.points.iter().map(of).sum::<f64>() / t.points.len() as f64;
            let (middle, mean) = (mean(|p| p.0), mean(|p| p.1));
            [first.0, last.0].map(|day| (calendar(day), mean + slope * (day - middle)))
        });
        let points = t.points.iter().map(|(day, v, u)| (calendar(*day), *v, 2.0 * u.unwrap_or(0.0))).collect();
        let caption = format!("{}{}{}", t.id, lang.colon(), say!(lang, "over-time"));
        let history = History { label: t.id.clone(), unit: t.unit.clone(), points, trend, limits: t.limits };
        Figure::new(caption, Chart::History(history), false)
    };
    let figures = Section::new(lang.title(say!(lang, "over-time"))).full().prose(say!(lang, "bars-limits-and-trend"));
    begin(say!(lang, "history-of-calibrations", calibrations = calibrations.len()), &[], lang)
        .facts(calibrations.iter().map(|c| (c.date.clone().unwrap_or_default(), who(c, lang))))
        .section(Section::new(say!(lang, "result")).verdict(tone, drifts).verdicts(left).table(table))
        .section(figures.figures(report.trends.iter().map(figure)))
}
