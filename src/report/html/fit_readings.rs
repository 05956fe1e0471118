//! Sections of a fit's page on what it rests on: what was assumed, and the readings one by one.

use super::{Align, Section, Table, Tone, cells};
use crate::campaign::JointState;
use crate::fit::Fit;
use crate::fit::{Estimator, VarianceFrom};
use crate::report::table::significant;
use crate::report::{FitReport, gravity_text};

/// What the fit takes for granted.
pub(super) fn assumptions(fit: &Fit, report: &FitReport) -> Section {
    let mut points = Vec::new();
    if !report.assumed_zero.is_empty() {
        points.push(format!("Taken as zero, neither known nor estimated: {}.", cells::names(&report.assumed_zero)));
    }
    points.push(match fit.campaign.bench.site {
        Some(site) => {
            let said = gravity_text(&report.site).unwrap_or(format!("gravity {} g", site.gravity_g));
            format!("Site: latitude {}\u{b0}, Earth rate {} deg/h, {said}.", site.latitude_deg, site.earth_rate_deg_h)
        }
        None => "No site: no Earth rate, and gravity is 1 g.".into(),
    });
    points.extend(report.site.warnings.iter().map(|warning| format!("Warning: {warning}.")));
    points.push(match report.estimator {
        Estimator::Linear => {
            "Linear: rows are exact derivatives at the reference point, and one step is taken from it.".into()
        }
        Estimator::Exact => "Exact: rows are exact derivatives, iterated to the solution.".into(),
    });
    points.push(match report.fit.variance {
        VarianceFrom::Stated => "Uncertainties of the readings are as stated.".into(),
        VarianceFrom::Estimated => {
            "Readings of one sensor scatter alike and independently; how much, their residuals say.".into()
        }
    });
    if report.fit.priors > 0 {
        points.push(format!("{} entered as rows of their own.", cells::count(report.fit.priors, "prior")));
    }
    let mut table = Table::new(&[
        ("known", Align::Left),
        ("value", Align::Decimal),
        ("u", Align::Decimal),
        ("distribution", Align::Left),
        ("\u{3bd}", Align::Right),
        ("unit", Align::Left),
    ]);
    for known in &report.known {
        let u = if known.u > 0.0 { significant(known.u, 3) } else { "exact".into() };
        table.row(vec![
            format!("`{}`", known.id),
            known.value.to_string(),
            u,
            if known.u > 0.0 { known.distribution.to_string() } else { String::new() },
            if known.u > 0.0 { cells::dof(known.dof, true) } else { String::new() },
            known.unit.clone(),
        ]);
    }
    Section::new("What was assumed").list(points).table(table)
}

/// More readings than this are not listed one by one.
const LISTED: usize = 1000;

/// Each reading with what the fit makes of it.
pub(super) fn readings(fit: &Fit, report: &FitReport) -> Section {
    let joints: Vec<&str> = fit.campaign.bench.joints().collect();
    let states =
        |index: usize| fit.campaign.readings.rows.get(index - 1).map(|r| r.joints.as_slice()).unwrap_or_default();
    let mut keys: Vec<String> = Vec::new();
    for (name, k) in joints.iter().zip(0..) {
        for suffix in ["_deg", "_deg_s", "_turns"] {
            let used = report.readings.iter().any(|r| states(r.index).get(k).is_some_and(|s| key(s, suffix).is_some()));
            if used {
                keys.push(format!("{name}{suffix}"));
            }
        }
    }
    let mut columns: Vec<(&str, Align)> = vec![("", Align::Right), ("position", Align::Left)];
    columns.extend(keys.iter().map(|key| (key.as_str(), Align::Decimal)));
    let several = fit.campaign.bench.sensors.len() > 1;
    if several {
        columns.push(("sensor", Align::Left));
    }
    columns.extend([
        ("value", Align::Decimal),
        ("fitted", Align::Decimal),
        ("residual", Align::Decimal),
        ("studentized", Align::Decimal),
        ("redundancy", Align::Decimal),
        ("detectable", Align::Right),
    ]);
    let mut table = Table::new(&columns);
    table.small = true;
    for r in report.readings.iter().take(LISTED) {
        let mut cells = vec![r.index.to_string(), r.position.clone()];
        for (name, state) in joints.iter().zip(states(r.index)) {
            for suffix in ["_deg", "_deg_s", "_turns"] {
                if keys.contains(&format!("{name}{suffix}")) {
                    cells.push(key(state, suffix).map(|v| v.to_string()).unwrap_or_default());
                }
            }
        }
        let tenth = r.u.map(|u| u / 10.0);
        if several {
            cells.push(r.sensor.clone());
        }
        cells.extend([
            as_read(r.value, tenth),
            cells::value(Some(r.fitted), tenth),
            cells::value(Some(r.residual), tenth),
            cells::decimals(r.studentized, 2),
            cells::decimals(Some(r.redundancy), 3),
            cells::digits(r.mdb, 3),
        ]);
        table.row(cells);
        if let Some(row) = table.rows.last_mut().filter(|_| r.studentized.is_some_and(|s| s.abs() > super::FAR)) {
            row.tone = Tone::Caution;
        }
    }
    table.note = format!(
        "Redundancy: the share of a fault that shows in the reading's own residual. Detectable: the smallest fault that a test at 0.1 % finds with 80 % power. Marked: studentized beyond {}.",
        super::FAR
    );
    if report.readings.len() > LISTED {
        table.note.push_str(&format!(
            " The first {LISTED} of {} are listed; the JSON report has all.",
            report.readings.len()
        ));
    }
    Section::new("Readings").table(table)
}

/// A value as the file gives it, unless it has more digits than anyone wants to see.
fn as_read(value: f64, u: Option<f64>) -> String {
    let text = value.to_string();
    if text.len() <= 9 { text } else { cells::value(Some(value), u) }
}

fn key(state: &JointState, suffix: &str) -> Option<f64> {
    let (deg, deg_s, turns) = state.keys();
    match suffix {
        "_deg" => deg,
        "_deg_s" => deg_s,
        _ => turns,
    }
}
