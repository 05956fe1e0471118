//! Two calibrations of one unit side by side, and the history of many (`tumble compare A B`).

use super::{ARCSEC, FitReport, VERSION};
use crate::compare::calibrations::{Change, Changes, Determination, InputShare, Quantity, Together, Trend};
use crate::language::{Language, say};
use crate::number;
use crate::report::ReportKind;
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
    /// Coverage probability of expanded uncertainties.
    pub level: f64,
    /// Each quantity that both have (angles in arcsec).
    pub changes: Vec<Change>,
    /// Known inputs that both share: they moved both results alike and do not count twice.
    pub shared: Vec<String>,
    /// All changes of parameters together.
    pub together: Option<Together>,
    /// Quantities that only the earlier one has.
    pub only_before: Vec<String>,
    /// Quantities that only the later one has.
    pub only_after: Vec<String>,
}

/// A calibration that was compared.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
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
    let known = |source: &super::BudgetReport, scale: f64| {
        Some(InputShare {
            id: source.source.clone(),
            estimate: source.estimate?,
            u: source.source_u?,
            c: source.c? * scale,
        })
    };
    let (mut quantities, mut scales, mut places) = (Vec::new(), Vec::new(), Vec::new());
    for p in &report.parameters {
        let Some(value) = p.value else { continue };
        let (scale, unit) = if p.arcsec.is_some() { (ARCSEC, "arcsec") } else { (1.0, p.unit.as_str()) };
        quantities.push(Quantity {
            id: p.id.clone(),
            unit: unit.into(),
            value: value * scale,
            u: p.u.map(|u| u * scale),
            dof: p.dof.unwrap_or(f64::INFINITY),
            inputs: p.budget.iter().filter_map(|source| known(source, scale)).collect(),
        });
        scales.push(scale);
        places.push(report.covariance.order.iter().position(|id| *id == p.id));
    }
    for d in &report.derived {
        let Some(value) = d.value else { continue };
        let (scale, unit) = if d.arcsec.is_some() { (ARCSEC, "arcsec") } else { (1.0, d.unit.as_str()) };
        quantities.push(Quantity {
            id: d.id.clone(),
            unit: unit.into(),
            value: value * scale,
            u: d.u.map(|u| u * scale),
            dof: d.dof.unwrap_or(f64::INFINITY),
            inputs: d.budget.iter().filter_map(|source| known(source, scale)).collect(),
        });
        scales.push(scale);
        places.push(None);
    }
    let element = |i: usize, j: usize| {
        let (row, column) = (*places.get(i)?, *places.get(j)?);
        let value = (*report.covariance.matrix.get(row?)?.get(column?)?)?;
        Some(value * scales.get(i)? * scales.get(j)?)
    };
    let n = quantities.len();
    let covariance = DMatrix::from_fn(n, n, |i, j| element(i, j).unwrap_or(f64::NAN));
    Determination { name: name.into(), day, quantities, covariance, correlations: report.correlations.clone() }
}

/// The report of two calibrations.
pub fn changes_report(changes: &Changes, before: CalibratedReport, after: CalibratedReport) -> ChangesReport {
    ChangesReport {
        tumble: VERSION.into(),
        report: ReportKind::CompareCalibrations,
        before,
        after,
        level: changes.level,
        changes: changes.changes.clone(),
        shared: changes.shared.clone(),
        together: changes.together,
        only_before: changes.only_in.0.clone(),
        only_after: changes.only_in.1.clone(),
    }
}

impl ChangesReport {
    /// Did anything change by more than the uncertainties allow?
    pub fn is_changed(&self) -> bool {
        self.together.is_some_and(|t| t.significant) || self.changes.iter().any(|c| c.significant == Some(true))
    }
}

/// What the reports say of themselves that two calibrations of one unit, one after the other, would not.
pub(super) fn doubts(report: &ChangesReport, lang: Language) -> Vec<String> {
    let (before, after) = (&report.before, &report.after);
    let mut found = Vec::new();
    if let (Some(first), Some(second)) = (&before.serial, &after.serial)
        && first != second
    {
        found.push(say!(lang, "reports-are-of-two-units", first, second));
    }
    if let (Some(first), Some(second)) = (&before.date, &after.date)
        && first > second
    {
        found.push(say!(lang, "first-report-is-the-later-one", first, second));
    }
    found
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
    pub trends: Vec<TrendReport>,
}

/// A quantity over time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct TrendReport {
    /// Its name.
    pub id: String,
    /// Unit of values.
    pub unit: String,
    /// Each calibration's day (from 1970-01-01), value and standard uncertainty.
    pub points: Vec<(f64, f64, Option<f64>)>,
    /// Slope per day of a straight line, in `unit` per day; null with fewer than three days.
    pub per_day: Option<f64>,
    /// Its standard uncertainty, in `unit` per day.
    pub u_per_day: Option<f64>,
    /// Is the slope significant?
    pub significant: Option<bool>,
    /// Birge ratio of the points about the line.
    pub birge: Option<f64>,
    /// Limits, where the last calibration states them.
    pub limits: Option<[f64; 2]>,
    /// Day on which the line leaves its limits, in days from 1970-01-01; before the last calibration where it has left them. Null where it does
    /// not, or where no slope is significant.
    pub leaves: Option<f64>,
}

impl TrendReport {
    /// Did the line leave its limits before the last calibration?
    pub fn has_left(&self) -> bool {
        self.leaves.zip(self.points.last()).is_some_and(|(day, last)| day < last.0)
    }
}

/// The report of many calibrations; `limits` gives each quantity's, if any.
pub fn history_report(
    calibrations: Vec<CalibratedReport>,
    trends: &[Trend],
    level: f64,
    limits: &dyn Fn(&str) -> Option<[f64; 2]>,
) -> HistoryReport {
    let trend = |t: &Trend| {
        let limits = limits(&t.id);
        TrendReport {
            id: t.id.clone(),
            unit: t.unit.clone(),
            points: t.points.clone(),
            per_day: t.line.map(|l| l.slope),
            u_per_day: t.line.map(|l| l.slope_u),
            significant: t.line.map(|l| l.significant),
            birge: t.line.map(|l| l.birge),
            limits,
            leaves: t.line.zip(limits).and_then(|(line, [low, high])| line.leaves((low, high))),
        }
    };
    HistoryReport {
        tumble: VERSION.into(),
        report: ReportKind::CompareHistory,
        calibrations,
        level,
        trends: trends.iter().map(trend).collect(),
    }
}

/// The date of a day counted from 1970-01-01.
pub fn date_of(day: f64) -> String {
    let shifted = number::whole_i64(day.floor()) + 719_468;
    let era = shifted.div_euclid(146_097);
    let of_era = shifted.rem_euclid(146_097);
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    format!("{:04}-{month:02}-{day:02}", year_of_era + 400 * era + next)
}
