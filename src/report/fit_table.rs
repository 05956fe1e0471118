//! The fit report as a person reads it.

use super::FitReport;
use super::table::{count, degrees_of_freedom, is_narrow, optional, plain, rounded, significant};
use super::wrap::hanging;

/// One line of the table of estimates.
struct Line<'a> {
    id: &'a str,
    unit: &'a str,
    value: Option<f64>,
    u: Option<f64>,
    expanded: Option<f64>,
    dof: Option<f64>,
    k: Option<f64>,
    state: &'a str,
}

impl Line<'_> {
    fn cells(&self) -> Vec<String> {
        vec![
            self.id.to_string(),
            optional(self.value, |v| rounded(v, self.u)),
            optional(self.u, |u| rounded(u, Some(u))),
            optional(self.expanded, |e| rounded(e, self.u)),
            degrees_of_freedom(self.dof, self.u.is_some()),
            optional(self.k, |k| format!("{k:.2}")),
            self.unit.to_string(),
            self.state.to_string(),
        ]
    }
}

/// Column of the coverage factor in the table of estimates.
const K: usize = 5;
/// Column of the fitted value in the table of readings.
const FITTED: usize = 4;

/// A fit report as a person reads it.
pub fn fit(report: &FitReport, with_readings: bool) -> String {
    let mut text = format!("tumble {}: {} fit on {}\n", report.tumble, report.estimator, report.bench);
    for (sensor, line) in &report.model {
        text.push_str(&format!("  {sensor} = {line}\n"));
    }
    for (name, said) in report.identity.facts() {
        text.push_str(&(super::wrap::hanging(&format!("  {name}: {said}"), 4) + "\n"));
    }
    text.push('\n');
    let level = report.parameters.first().map_or(0.95, |p| p.level);
    let mut rows: Vec<Vec<String>> = Vec::new();
    for p in &report.parameters {
        let line = match p.arcsec {
            Some(a) => Line {
                id: &p.id,
                unit: "arcsec",
                value: a.value,
                u: a.u,
                expanded: a.expanded,
                dof: p.dof,
                k: p.k,
                state: p.state.name(),
            },
            None => Line {
                id: &p.id,
                unit: &p.unit,
                value: p.value,
                u: p.u,
                expanded: p.expanded,
                dof: p.dof,
                k: p.k,
                state: p.state.name(),
            },
        };
        rows.push(line.cells());
    }
    for d in &report.derived {
        let line = match d.arcsec {
            Some(a) => Line {
                id: &d.id,
                unit: "arcsec",
                value: a.value,
                u: a.u,
                expanded: a.expanded,
                dof: d.dof,
                k: d.k,
                state: "derived",
            },
            None => Line {
                id: &d.id,
                unit: &d.unit,
                value: d.value,
                u: d.u,
                expanded: d.expanded,
                dof: d.dof,
                k: d.k,
                state: "derived",
            },
        };
        rows.push(line.cells());
    }
    let expanded = format!("U ({} %)", significant(100.0 * level, 3).trim_end_matches('0').trim_end_matches('.'));
    let mut header = vec!["parameter", "estimate", "u", expanded.as_str(), "dof", "k", "unit", "state"];
    if !is_narrow(&header, &rows) {
        // k = U/u stands in the two columns before it
        header.remove(K);
        rows.iter_mut().for_each(|row| {
            row.remove(K);
        });
    }
    text.push_str(&plain(&header, &rows));
    text.push('\n');
    if let Some(conformity) = &report.conformity {
        text.push_str(&super::conformity::conformity_text(conformity));
        text.push('\n');
    }
    text.push_str(&summary(report));
    text.push_str(&super::fit_checks_table::findings(report));
    text.push_str(&super::scatter::table(&report.scatter));
    text.push_str(&defects(report));
    text.push_str(&instead(report));
    text.push_str(&estimator(report));
    if with_readings {
        text.push('\n');
        text.push_str(&readings(report));
    }
    text
}

fn summary(report: &FitReport) -> String {
    let fit = &report.fit;
    let priors = if fit.priors > 0 { format!(" + {}", count(fit.priors, "prior")) } else { String::new() };
    let mut text = format!(
        "{}{priors}, rank {} of {}, {} degrees of freedom",
        count(fit.readings, "reading"),
        fit.rank,
        report.parameters.len(),
        fit.dof
    );
    if let Some(condition) = fit.condition {
        text.push_str(&format!(", condition {}", significant(condition, 3)));
    }
    text.push('\n');
    match (fit.chi_square, fit.p, fit.residual_sd) {
        (Some(chi_square), Some(p), Some(sd)) => {
            let verdict = if fit.global_test_rejected == Some(true) {
                "REJECTED: the readings scatter more than their stated uncertainties allow"
            } else {
                "accepted"
            };
            text.push_str(&format!(
                "global test: chi-square {} with {} degrees of freedom, p = {}, factor {}: {verdict}\n",
                significant(chi_square, 4),
                fit.dof,
                significant(p, 3),
                significant(sd, 3)
            ));
        }
        _ => {
            for (sensor, sd) in &fit.sensor_sd {
                match sd {
                    Some(sd) => {
                        let how = match fit.resolution.get(sensor) {
                            Some(step) => format!(
                                "that of rounding to {} (its last digit, over sqrt 12): its readings scatter no more",
                                significant(*step, 1)
                            ),
                            None if fit.at_rounding.contains(sensor) => {
                                "the rounding of its readings, which show no scatter".into()
                            }
                            None => "estimated from these readings".to_string(),
                        };
                        text.push_str(&format!("residual sd of {sensor}: {}, {how}\n", significant(*sd, 4)));
                    }
                    None => text.push_str(&format!(
                        "residual sd of {sensor}: none (no degrees of freedom), so no uncertainty can be given\n"
                    )),
                }
            }
        }
    }
    for circle in &fit.inconsistent_circles {
        text.push_str(&format!(
            "INCONSISTENT: {} disagrees with the other sights by {} deg on average (another side of the target? a point sighted wrongly? \
             a start too far away?)\n",
            circle.sensor,
            significant(circle.mean_residual_deg, 4)
        ));
    }
    for remark in &fit.remarks {
        text.push_str(&(hanging(&format!("note: {remark}"), 2) + "\n"));
    }
    if !report.known.is_empty() {
        let known: Vec<String> = report.known.iter().map(known_text).collect();
        text.push_str(&format!("known: {}\n", known.join(", ")));
    }
    text.push_str(&super::site::site_text(&report.site));
    if !report.assumed_zero.is_empty() {
        text.push_str(&format!("assumed zero: {}\n", report.assumed_zero.join(", ")));
    }
    text
}

fn known_text(known: &super::KnownReport) -> String {
    let u = if known.u > 0.0 { format!(" (u {})", significant(known.u, 2)) } else { String::new() };
    format!(
        "{} = {}{}{u}",
        known.id,
        without_rounding(known.value),
        if known.unit.is_empty() { String::new() } else { format!(" {}", known.unit) }
    )
}

/// A stated value without what converting its unit left in the last digit.
fn without_rounding(value: f64) -> f64 {
    format!("{value:.14e}").parse().unwrap_or(value)
}

/// How far the estimator went, and what it changed.
fn estimator(report: &FitReport) -> String {
    let mut text = String::new();
    let differ: Vec<String> =
        report.nonlinear.iter().map(|(id, share)| format!("{id} {} u", significant(*share, 2))).collect();
    let Some(record) = &report.convergence else {
        if !differ.is_empty() {
            let line = format!(
                "note: one linear step is not enough here: Gauss-Newton would go on by more than 0.1 u in {}; fit without --linear",
                differ.join(", ")
            );
            text.push_str(&(hanging(&line, 2) + "\n"));
        }
        return text;
    };
    if !record.moved.is_empty() {
        let line = format!(
            "no reading responds to {} at the reference point, where all that they are multiplied by is zero: started beside it",
            record.moved.join(", ")
        );
        text.push_str(&(hanging(&line, 2) + "\n"));
    }
    if !record.held.is_empty() {
        let line = format!(
            "held where the iteration began, since the exact model determines them too weakly beyond it: {}",
            record.held.join(", ")
        );
        text.push_str(&(hanging(&line, 2) + "\n"));
    }
    let steps = count(record.iterations.len(), "iteration");
    let line = if record.converged {
        let linear = if differ.is_empty() {
            "the linear estimates (--linear) are the same within 0.1 u".to_string()
        } else {
            format!(
                "the linear estimates (--linear) differ by more than 0.1 u (exact minus linear): {}",
                differ.join(", ")
            )
        };
        format!("Gauss-Newton converged after {steps}; {linear}")
    } else {
        format!("Gauss-Newton NOT converged after {steps} ({})", record.stop)
    };
    text.push_str(&(hanging(&line, 2) + "\n"));
    text
}

/// Values of what is determined where single parameters are not, and which estimates hold only given what is held.
fn instead(report: &FitReport) -> String {
    let mut text = String::new();
    if !report.estimable_combinations.is_empty() {
        let rows: Vec<Vec<String>> = report
            .estimable_combinations
            .iter()
            .map(|own| {
                let (value, u, expanded, unit) = match own.arcsec {
                    Some(a) => (a.value, a.u, a.expanded, "arcsec"),
                    None => (Some(own.value), own.u, own.expanded, own.unit.as_str()),
                };
                vec![
                    own.text.clone(),
                    optional(value, |v| rounded(v, u)),
                    optional(u, |u| rounded(u, Some(u))),
                    optional(expanded, |e| rounded(e, u)),
                    unit.to_string(),
                ]
            })
            .collect();
        text.push_str(&plain(&["estimable combination", "estimate", "u", "U", "unit"], &rows));
    }
    for own in &report.conditional {
        let shifts: Vec<String> = own.shifts.iter().map(|(id, u)| format!("{id} {} u", significant(*u, 2))).collect();
        let line = format!(
            "U holds only for {} as held: another value of it, {} {} away, changes {}",
            own.held,
            significant(own.by, 3),
            own.unit,
            shifts.join(", ")
        );
        text.push_str(&(hanging(&line.replace("  ", " "), 2) + "\n"));
    }
    text
}

fn defects(report: &FitReport) -> String {
    let mut text = String::new();
    for defect in &report.not_estimable {
        text.push_str(&format!("NOT ESTIMABLE: {} is free;", defect.text));
        if let Some(hides) = &defect.hides {
            text.push_str(&format!(" {hides};"));
        }
        let only: Vec<&str> = defect.estimable.iter().map(|c| c.text.as_str()).collect();
        if only.is_empty() {
            text.push_str(if defect.weak {
                " no reading responds to it at this point"
            } else {
                " no reading responds to it"
            });
        } else {
            let verb = if only.len() == 1 { "is" } else { "are" };
            text.push_str(&format!(" only {} {verb} estimable here", only.join(" and ")));
        }
        match &defect.separate_by {
            Some(position) => {
                let keys: Vec<String> = position.iter().map(|(key, value)| format!("{key} = {value}")).collect();
                text.push_str(&format!("\n  a reading at {} would separate it\n", keys.join(", ")));
            }
            None => text.push_str(&format!("\n  {}\n", defect.nowhere())),
        }
    }
    text
}

fn readings(report: &FitReport) -> String {
    let mut rows: Vec<Vec<String>> = report
        .readings
        .iter()
        .map(|r| {
            vec![
                r.index.to_string(),
                r.position.clone(),
                r.sensor.clone(),
                significant(r.value, 6),
                significant(r.fitted, 6),
                significant(r.residual, 3),
                optional(r.studentized, |s| format!("{s:.2}")),
                format!("{:.3}", r.redundancy),
                optional(r.mdb, |m| significant(m, 3)),
            ]
        })
        .collect();
    let mut header =
        vec!["reading", "position", "sensor", "value", "fitted", "residual", "studentized", "redundancy", "mdb"];
    if !is_narrow(&header, &rows) {
        // fitted = value - residual stands in the columns beside it
        header.remove(FITTED);
        rows.iter_mut().for_each(|row| {
            row.remove(FITTED);
        });
    }
    plain(&header, &rows)
}
