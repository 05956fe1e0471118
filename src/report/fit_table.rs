//! The fit report as a person reads it.

use super::FitReport;
use super::table::{degrees_of_freedom, is_narrow, optional, plain, rounded, significant};
use super::wrap::hanging;
use crate::language::{Language, say};
use std::borrow::Cow;

/// One line of the table of estimates.
struct Line<'a> {
    id: &'a str,
    unit: &'a str,
    value: Option<f64>,
    u: Option<f64>,
    expanded: Option<f64>,
    dof: Option<f64>,
    k: Option<f64>,
    state: Cow<'static, str>,
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
/// Columns of the degrees of freedom and of the unit there, without k.
const DOF: usize = 4;
const UNIT: usize = 5;
/// Column of the fitted value in the table of readings.
const FITTED: usize = 4;

/// A fit report as a person reads it.
pub fn fit(report: &FitReport, with_readings: bool, lang: Language) -> String {
    let mut text = format!(
        "{}\n",
        say!(
            lang,
            "tumble-fit-on",
            tumble = report.tumble,
            estimator = lang.term("estimator", report.estimator.name()),
            bench = report.bench
        )
    );
    for (sensor, line) in &report.model {
        text.push_str(&format!("  {sensor} = {line}\n"));
    }
    for (name, said) in report.identity.facts(lang) {
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
                state: lang.term("state", p.state.name()),
            },
            None => Line {
                id: &p.id,
                unit: &p.unit,
                value: p.value,
                u: p.u,
                expanded: p.expanded,
                dof: p.dof,
                k: p.k,
                state: lang.term("state", p.state.name()),
            },
        };
        rows.push(line.cells());
    }
    for d in report.derived.iter().filter(|d| d.value.is_some()) {
        let line = match d.arcsec {
            Some(a) => Line {
                id: &d.id,
                unit: "arcsec",
                value: a.value,
                u: a.u,
                expanded: a.expanded,
                dof: d.dof,
                k: d.k,
                state: say!(lang, "derived").into(),
            },
            None => Line {
                id: &d.id,
                unit: &d.unit,
                value: d.value,
                u: d.u,
                expanded: d.expanded,
                dof: d.dof,
                k: d.k,
                state: say!(lang, "derived").into(),
            },
        };
        rows.push(line.cells());
    }
    let expanded = format!("U ({} %)", significant(100.0 * level, 3).trim_end_matches('0').trim_end_matches('.'));
    let mut header = vec![
        say!(lang, "parameter"),
        say!(lang, "estimate"),
        "u",
        expanded.as_str(),
        say!(lang, "dof"),
        "k",
        say!(lang, "unit"),
        say!(lang, "state"),
    ];
    if !is_narrow(&header, &rows) {
        // k = U/u stands in the two columns before it
        header.remove(K);
        rows.iter_mut().for_each(|row| {
            row.remove(K);
        });
        if !is_narrow(&header, &rows) {
            // what continues below are the degrees of freedom, not the unit
            header.swap(DOF, UNIT);
            rows.iter_mut().filter(|row| row.len() > UNIT).for_each(|row| row.swap(DOF, UNIT));
        }
    }
    text.push_str(&plain(&header, &rows));
    text.push('\n');
    for (d, note) in report.derived.iter().filter_map(|d| Some((d, d.note.as_ref()?))) {
        text.push_str(&(hanging(&say!(lang, "source-note", source = d.id, note), 2) + "\n"));
    }
    let without = report.derived_without_a_value();
    if !without.is_empty() {
        text.push_str(&(hanging(&say!(lang, "derived-without-a-value", names = without.join(", ")), 2) + "\n"));
    }
    if let Some(conformity) = &report.conformity {
        text.push_str(&super::conformity::conformity_text(conformity, lang));
        text.push('\n');
    }
    text.push_str(&summary(report, lang));
    text.push_str(&super::record_table::text(report, lang));
    text.push_str(&super::fit_checks_table::findings(report, lang));
    text.push_str(&super::scatter::table(&report.scatter, lang));
    text.push_str(&defects(report, lang));
    text.push_str(&instead(report, lang));
    text.push_str(&estimator(report, lang));
    if report.is_misfit() {
        text.push_str(&(hanging(say!(lang, "diagnose-says-what-is-missing"), 2) + "\n"));
    }
    if with_readings {
        text.push('\n');
        text.push_str(&readings(report, lang));
    }
    text
}

fn summary(report: &FitReport, lang: Language) -> String {
    let fit = &report.fit;
    let priors = if fit.priors > 0 { format!(" + {}", lang.count(fit.priors, "prior")) } else { String::new() };
    let mut text = say!(
        lang,
        "rank-of-degrees-of-freedom",
        reading = lang.count(fit.readings, "reading"),
        priors,
        rank = fit.rank,
        parameters = report.parameters.len(),
        dof = fit.dof
    );
    if let Some(condition) = fit.condition {
        text.push_str(&say!(lang, "fit-table-condition", condition = significant(condition, 3)));
    }
    text.push('\n');
    match (fit.chi_square, fit.p, fit.residual_sd) {
        (Some(chi_square), Some(p), Some(sd)) => {
            let verdict = if fit.global_test_rejected == Some(true) {
                say!(lang, "rejected-the-readings-scatter-more-than-their")
            } else {
                say!(lang, "accepted")
            };
            text.push_str(&format!(
                "{}\n",
                say!(
                    lang,
                    "global-test-chi-square-with-degrees-of",
                    chi_square = significant(chi_square, 4),
                    dof = fit.dof,
                    p = significant(p, 3),
                    sd = significant(sd, 3),
                    verdict
                )
            ));
        }
        _ => {
            for (sensor, sd) in &fit.sensor_sd {
                match sd {
                    Some(sd) => {
                        let how = match fit.resolution.get(sensor) {
                            Some(step) => {
                                say!(lang, "that-of-rounding-to-its-last-digit", step = significant(*step, 1))
                            }
                            None if fit.at_rounding.contains(sensor) => {
                                say!(lang, "the-rounding-of-its-readings-which-show").into()
                            }
                            None => say!(lang, "estimated-from-these-readings").to_string(),
                        };
                        text.push_str(&format!(
                            "{}\n",
                            say!(lang, "residual-sd-of", sensor, sd = significant(*sd, 4), how)
                        ));
                    }
                    None => text.push_str(&format!("{}\n", say!(lang, "residual-sd-of-none-no-degrees-of", sensor))),
                }
            }
        }
    }
    for circle in &fit.inconsistent_circles {
        text.push_str(&format!(
            "{}\n",
            say!(
                lang,
                "inconsistent-disagrees-with-the-other-sights-by",
                sensor = circle.sensor,
                mean_residual_deg = significant(circle.mean_residual_deg, 4)
            )
        ));
    }
    for remark in &fit.remarks {
        text.push_str(&(hanging(&say!(lang, "fit-table-note", remark), 2) + "\n"));
    }
    if !report.known.is_empty() {
        let known: Vec<String> = report.known.iter().map(known_text).collect();
        text.push_str(&format!("{}\n", say!(lang, "fit-table-known", known = known.join(lang.comma()))));
    }
    if !report.correlations.is_empty() {
        let list = report.correlated();
        text.push_str(&(hanging(&say!(lang, "correlated-inputs", list = list.join(lang.comma())), 2) + "\n"));
    }
    text.push_str(&super::site::site_text(&report.site, lang));
    if report.site.latitude_deg.is_none() && report.model.values().any(|line| reads_rotation(line)) {
        text.push_str(&format!("{}\n", say!(lang, "no-site-no-earth-rate-and-gravity")));
    }
    if !report.assumed_zero.is_empty() {
        text.push_str(&format!(
            "{}\n",
            say!(lang, "assumed-zero", assumed_zero = report.assumed_zero.join(lang.comma()))
        ));
    }
    text
}

/// Does a model line read the rate of rotation about an axis (`w_x`, not `flow_x`)?
fn reads_rotation(line: &str) -> bool {
    line.split(|c: char| !c.is_alphanumeric() && c != '_').any(|name| name.starts_with("w_"))
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
    // a printed number is read again
    format!("{value:.14e}").parse().unwrap_or(value)
}

/// How far the estimator went, and what it changed.
fn estimator(report: &FitReport, lang: Language) -> String {
    let mut text = String::new();
    let differ: Vec<String> =
        report.nonlinear.iter().map(|(id, share)| format!("{id} {} u", significant(*share, 2))).collect();
    let Some(record) = &report.convergence else {
        if !differ.is_empty() {
            let line = say!(lang, "note-one-linear-step-is-not-enough", differ = differ.join(lang.comma()));
            text.push_str(&(hanging(&line, 2) + "\n"));
        }
        return text;
    };
    if !record.moved.is_empty() {
        let line = say!(lang, "no-reading-responds-to-at-the-reference", moved = record.moved.join(lang.comma()));
        text.push_str(&(hanging(&line, 2) + "\n"));
    }
    if !record.held.is_empty() {
        let line = say!(lang, "held-where-the-iteration-began-since-the", held = record.held.join(lang.comma()));
        text.push_str(&(hanging(&line, 2) + "\n"));
    }
    let steps = lang.count(record.iterations.len(), "iteration");
    let line = if record.converged {
        let linear = if differ.is_empty() {
            say!(lang, "the-linear-estimates-linear-are-the-same").to_string()
        } else {
            say!(lang, "the-linear-estimates-linear-differ-by-more", differ = differ.join(lang.comma()))
        };
        say!(lang, "gauss-newton-converged-after", steps, linear)
    } else {
        say!(lang, "gauss-newton-not-converged-after", steps, stop = record.stop.said())
    };
    text.push_str(&(hanging(&line, 2) + "\n"));
    text
}

/// Values of what is determined where single parameters are not, and which estimates hold only given what is held.
fn instead(report: &FitReport, lang: Language) -> String {
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
        text.push_str(&plain(
            &[say!(lang, "estimable-combination"), say!(lang, "estimate"), "u", "U", say!(lang, "unit")],
            &rows,
        ));
    }
    for own in &report.conditional {
        let shifts: Vec<String> = own.shifts.iter().map(|(id, u)| format!("{id} {} u", significant(*u, 2))).collect();
        let line = say!(
            lang,
            "u-holds-only-for-as-held-another",
            held = own.held,
            by = significant(own.by, 3),
            unit = own.unit,
            shifts = shifts.join(lang.comma())
        );
        text.push_str(&(hanging(&line.replace("  ", " "), 2) + "\n"));
    }
    text
}

fn defects(report: &FitReport, lang: Language) -> String {
    let mut text = String::new();
    for defect in &report.not_estimable {
        let mut clauses = vec![say!(lang, "not-estimable-is-free", text = defect.text)];
        clauses.extend(defect.hides.as_ref().map(|hides| hides.say(lang)));
        let only: Vec<&str> = defect.estimable.iter().map(|c| c.text.as_str()).collect();
        clauses.push(match (only.is_empty(), defect.weak) {
            (true, true) => say!(lang, "no-reading-responds-to-it-at-this").to_string(),
            (true, false) => say!(lang, "no-reading-responds-to-it").to_string(),
            _ => say!(lang, "only-estimable-here", only = only.join(say!(lang, "joined-by-and")), n = only.len()),
        });
        text.push_str(&clauses.join(lang.semicolon()));
        let where_to = defect.further(lang).unwrap_or_else(|| defect.nowhere().say(lang).to_string());
        text.push_str(&format!("\n  {where_to}\n"));
    }
    text
}

fn readings(report: &FitReport, lang: Language) -> String {
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
    let mut header = vec![
        say!(lang, "reading"),
        say!(lang, "position"),
        say!(lang, "sensor"),
        say!(lang, "value"),
        say!(lang, "fitted"),
        say!(lang, "residual"),
        say!(lang, "studentized"),
        say!(lang, "redundancy"),
        say!(lang, "mdb"),
    ];
    if !is_narrow(&header, &rows) {
        // fitted = value - residual stands in the columns beside it
        header.remove(FITTED);
        rows.iter_mut().for_each(|row| {
            row.remove(FITTED);
        });
    }
    plain(&header, &rows)
}
