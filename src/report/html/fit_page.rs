//! The page of a fit: the answer first, then where it comes from, then what it rests on.

use super::fit_figures::{budget_figures, estimate_figures, residual_figures, spread_figures};
use super::{Align, Block, Page, Section, Table, Tone, cells, checks_page, compare_page};
use crate::campaign::JointState;
use crate::error::Result;
use crate::fit::Fit;
use crate::report::table::significant;
use crate::report::{ARCSEC, CompareReport, FitReport, Input, VERSION, corrections, mounting};

/// The page of a fit.
///
/// `comparison` with the published closed forms is shown where the bench has them; `inputs` are the files that the fit was made from.
pub fn fit_page(fit: &Fit, report: &FitReport, comparison: Option<&CompareReport>, inputs: &[Input]) -> Result<Page> {
    let bench = &fit.campaign.bench;
    let mut page = Page::new(if bench.title.is_empty() { bench.id.clone() } else { bench.title.clone() });
    page.subtitle = "Calibration: every angle and coefficient with its uncertainty".into();
    page.facts = facts(fit, report, inputs);
    page.colophon = colophon(inputs);
    let mut page = page
        .section(answer(fit, report))
        .section(estimates(fit, report)?)
        .section(not_estimable(report))
        .section(correction(fit, report))
        .section(budget(report)?)
        .section(checks_page::monte_carlo(report))
        .section(residuals(fit, report)?)
        .section(checks_page::checks(report))
        .section(checks_page::conditions(report));
    if let Some(comparison) = comparison {
        page = page.section(compare_page::section(comparison));
    }
    Ok(page.section(assumptions(fit, report)).section(readings(fit, report)))
}

/// The end of every page: version and inputs.
pub(super) fn colophon(inputs: &[Input]) -> Vec<(String, String)> {
    let mut list = vec![("made by".to_string(), format!("tumble {VERSION}; the same inputs give the same bytes"))];
    list.extend(inputs.iter().map(|input| (format!("SHA-256 of {}", input.name), format!("`{}`", input.sha256))));
    list
}

fn facts(fit: &Fit, report: &FitReport, inputs: &[Input]) -> Vec<(String, String)> {
    let bench = &fit.campaign.bench;
    let mut facts = vec![("Bench".to_string(), format!("`{}`", bench.id))];
    if !bench.source.is_empty() {
        facts.push(("Source".into(), bench.source.clone()));
    }
    if let Some(input) = inputs.first() {
        facts.push(("Campaign".into(), input.name.clone()));
    }
    for (k, sensor) in bench.sensors.iter().enumerate() {
        let name = if k == 0 { "Model" } else { "" };
        facts.push((name.into(), format!("`{} = {}`", sensor.id, sensor.model)));
    }
    let estimator = match report.estimator.as_str() {
        "linear" => "one least-squares step from the reference point",
        _ => "Gauss-Newton on the exact rotations",
    };
    facts.push(("Estimator".into(), format!("{}: {estimator}", report.estimator)));
    facts
}

fn answer(of: &Fit, report: &FitReport) -> Section {
    let fit = &report.fit;
    let mut section = Section::new("Result");
    for defect in &report.not_estimable {
        section =
            section.verdict(Tone::Bad, format!("Not everything is estimable: `{}` is free. See below.", defect.text));
    }
    section = match (fit.chi_square, fit.p) {
        (Some(chi_square), Some(p)) => {
            let level = report.parameters.first().map_or(0.95, |p| p.level);
            let rejected = p < 1.0 - level;
            let tone = if rejected { Tone::Bad } else { Tone::Good };
            let words = if rejected {
                "the readings scatter more than their stated uncertainties allow: the model misses something, or the uncertainties are too small"
            } else {
                "the readings scatter as their stated uncertainties say"
            };
            section.verdict(
                tone,
                format!(
                    "Global test: {words} (chi-square {} with {}, p = {}).",
                    significant(chi_square, 4),
                    cells::count(fit.dof, "degree") + " of freedom",
                    significant(p, 3)
                ),
            )
        }
        _ if fit.variance == "estimated" && fit.dof > 0 => section.verdict(
            Tone::Plain,
            if report.checks.lack_of_fit.is_some() {
                "The readings state no uncertainty of their own: their scatter is estimated from the residuals, and only their replicates test the model."
            } else {
                "The readings state no uncertainty of their own: their scatter is estimated from the residuals, so these readings alone cannot test the model."
            },
        ),
        _ if fit.dof == 0 => section.verdict(
            Tone::Caution,
            "No degrees of freedom: the readings just determine the parameters, and nothing checks them.",
        ),
        _ => section,
    };
    for (tone, text) in checks_page::verdicts(report) {
        section = section.verdict(tone, text);
    }
    if let Some(error) = fit.linearisation_error.filter(|e| *e > 0.1 && report.estimator == "linear") {
        section = section.verdict(
            Tone::Caution,
            format!(
                "The exact model differs from the linear one by up to {} standard uncertainties of a reading: fit again with `--exact`.",
                significant(error, 2)
            ),
        );
    }
    if let Some(record) = &report.convergence {
        let tone = if record.converged { Tone::Good } else { Tone::Bad };
        let word = if record.converged { "converged" } else { "did not converge" };
        let steps = cells::count(record.iterations.len(), "iteration");
        let why = if record.converged { String::new() } else { format!(": {}", record.stop) };
        section = section.verdict(tone, format!("Gauss-Newton {word} after {steps}{why}."));
        if !record.held.is_empty() {
            let what = format!(
                "The reference point does not determine {}, and the exact model beyond it too weakly: they kept their reference values.",
                cells::names(&record.held.iter().map(String::as_str).collect::<Vec<_>>())
            );
            section = section.prose(what);
        }
    }
    section.prose(summary(of, report))
}

fn summary(fit: &Fit, report: &FitReport) -> String {
    let sums = &report.fit;
    let mut text = format!(
        "From {}{} the fit estimates {} (rank {}, {} of freedom).",
        cells::count(sums.readings, "reading"),
        if sums.priors > 0 { format!(" and {}", cells::count(sums.priors, "prior")) } else { String::new() },
        cells::count(report.parameters.len(), "parameter"),
        sums.rank,
        cells::count(sums.dof, "degree"),
    );
    let mut angles: Vec<(&str, f64)> =
        report.parameters.iter().filter_map(|p| Some((p.id.as_str(), p.arcsec.and_then(|a| a.expanded)?))).collect();
    angles.sort_by(|a, b| a.1.total_cmp(&b.1));
    let level = report.parameters.first().map_or(0.95, |p| p.level);
    if let (Some((best, low)), Some((worst, high)), true) = (angles.first(), angles.last(), angles.len() > 1) {
        let [low, high] = [low, high].map(|u| significant(*u, 2));
        text.push_str(&if low == high {
            format!(" At {}, every angle is known to {} arcsec.", cells::level(level), high)
        } else {
            format!(
                " At {}, the angles are known to between {} arcsec (`{best}`) and {} arcsec (`{worst}`).",
                cells::level(level),
                low,
                high
            )
        });
    }
    let scatter: Vec<String> = sums
        .sensor_sd
        .iter()
        .filter_map(|(sensor, sd)| Some(format!("{} for `{sensor}`", with_unit((*sd)?, &unit_of(fit, sensor)))))
        .collect();
    if !scatter.is_empty() {
        text.push_str(&format!(" Residual standard deviation: {}.", scatter.join(", ")));
    }
    if let Some(condition) = sums.condition {
        text.push_str(&format!(" The scaled design matrix has condition number {}.", significant(condition, 3)));
    }
    text
}

fn unit_of(fit: &Fit, sensor: &str) -> String {
    fit.campaign.bench.sensors.iter().find(|s| s.id == sensor).map(|s| s.unit.clone()).unwrap_or_default()
}

fn with_unit(value: f64, unit: &str) -> String {
    format!("{} {unit}", significant(value, 3)).trim_end().to_string()
}

fn estimates(fit: &Fit, report: &FitReport) -> Result<Section> {
    let level = report.parameters.first().map_or(0.95, |p| p.level);
    let expanded = format!("U ({})", cells::level(level));
    let columns = |what: &'static str| {
        Table::new(&[
            (what, Align::Left),
            ("estimate", Align::Decimal),
            ("u", Align::Decimal),
            (&expanded, Align::Decimal),
            ("\u{3bd}", Align::Right),
            ("k", Align::Right),
            ("unit", Align::Left),
            ("", Align::Left),
        ])
    };
    let (mut angles, mut coefficients) = (columns("angle"), columns("coefficient"));
    for (p, result) in report.parameters.iter().zip(&fit.parameters) {
        let remark = match p.state.as_str() {
            "free" => result.meaning.clone(),
            "not-estimable" => "not estimable".into(),
            other => {
                let scale = if p.kind == "tilt" { ARCSEC } else { 1.0 };
                let interval =
                    p.interval.map(|ends| ends.map(|end| cells::value(Some(end * scale), p.u.map(|u| u * scale))));
                let between = interval.map_or(String::new(), |[a, b]| format!(", interval {a} to {b}"));
                format!("{other}{between}. {}", result.meaning)
            }
        };
        let (value, u, expanded, unit) = match p.arcsec {
            Some(a) => (a.value, a.u, a.expanded, "arcsec"),
            None => (p.value, p.u, p.expanded, if p.kind == "tilt" { "arcsec" } else { &p.unit }),
        };
        let table = if p.kind == "tilt" { &mut angles } else { &mut coefficients };
        table.row(row(&p.id, value, (u, expanded), p.dof, p.k, unit, remark));
        if let Some(last) = table.rows.last_mut().filter(|_| p.state == "not-estimable") {
            last.tone = Tone::Bad;
        }
    }
    for d in &report.derived {
        let (value, u, expanded, unit) = match d.arcsec {
            Some(a) => (a.value, a.u, a.expanded, "arcsec"),
            None => (d.value, d.u, d.expanded, d.unit.as_str()),
        };
        let table = if d.arcsec.is_some() { &mut angles } else { &mut coefficients };
        table.row(row(&d.id, value, (u, expanded), d.dof, d.k, unit, format!("= `{}`", d.line)));
    }
    coefficients.note = format!(
        "u: combined standard uncertainty; {expanded} = k u: expanded uncertainty, k from Student's t with \u{3bd} effective degrees of freedom."
    );
    if coefficients.rows.is_empty() {
        angles.note = std::mem::take(&mut coefficients.note);
    }
    Ok(Section::new("Estimates").table(angles).figures(estimate_figures(report)?).table(coefficients))
}

fn row(
    id: &str,
    value: Option<f64>,
    (u, expanded): (Option<f64>, Option<f64>),
    dof: Option<f64>,
    k: Option<f64>,
    unit: &str,
    remark: String,
) -> Vec<String> {
    vec![
        format!("`{id}`"),
        cells::value(value, u),
        cells::value(u, u),
        cells::value(expanded, u),
        cells::dof(dof, u.is_some()),
        cells::decimals(k, 2),
        unit.to_string(),
        remark,
    ]
}

fn not_estimable(report: &FitReport) -> Section {
    let mut section = Section::new("Not estimable from these readings");
    for defect in &report.not_estimable {
        let only: Vec<&str> = defect.estimable.iter().map(|c| c.text.as_str()).collect();
        let instead = if only.is_empty() {
            "no reading responds to it".to_string()
        } else {
            format!("only {} {} determined", cells::names(&only), if only.len() == 1 { "is" } else { "are" })
        };
        section = section
            .prose(format!("The parameters can move along `{}` and no reading changes; {instead}.", defect.text));
        section = match &defect.separate_by {
            Some(position) => {
                let keys: Vec<String> = position.iter().map(|(key, value)| format!("{key} = {value}")).collect();
                section.prose(format!("What would separate it: a further reading at {}.", cells::names(&keys)))
            }
            None => {
                section.prose("No position of this bench would separate it: it takes another bench, or a known value.")
            }
        };
    }
    section
}

fn correction(fit: &Fit, report: &FitReport) -> Section {
    let mut section = Section::new("The correction to apply");
    let corrections = corrections(fit);
    let symbolic: Vec<String> = corrections.iter().map(|c| c.symbolic.clone()).collect();
    let numeric: Vec<String> = corrections.iter().filter_map(|c| c.numeric.clone()).collect();
    if !symbolic.is_empty() {
        section = section.prose("The model line solved for its input:").block(Block::Formula(symbolic));
    }
    if !numeric.is_empty() {
        section = section
            .prose("With the numbers of this calibration, two digits beyond their uncertainty:")
            .block(Block::Formula(numeric));
    }
    for c in corrections.iter().filter(|c| !c.missing.is_empty()) {
        section = section.verdict(
            Tone::Caution,
            format!("`{}` cannot be corrected by itself: {} not estimable here.", c.sensor, is_or_are(&c.missing)),
        );
    }
    if corrections.iter().any(|c| c.iterate) {
        section = section.prose("Where the input stands on the right too, begin with zero there and repeat; two or three rounds are enough for small nonlinear terms.");
    }
    let shared = corrections
        .iter()
        .any(|c| c.symbolic.matches("w_").count() + c.symbolic.matches("a_").count() > 1 && !c.iterate);
    if shared {
        section = section.prose("Other rates and forces on the right come from the other sensors: correct all, then repeat with the corrected values.");
    }
    if let Some(mounting) = mounting(fit) {
        let tilts = cells::names(&mounting.tilts);
        if mounting.missing.is_empty() && !mounting.directions.is_empty() {
            let mut table = Table::new(&[
                ("input", Align::Left),
                ("x", Align::Decimal),
                ("y", Align::Decimal),
                ("z", Align::Decimal),
            ]);
            for d in &mounting.directions {
                let mut row = vec![format!("`{}` of `{}`", d.input, d.sensor)];
                row.extend(d.cosines.iter().map(|c| format!("{c:.9}")));
                table.row(row);
            }
            table.caption = "Direction cosines of the corrected inputs on the mounting face".into();
            section = section
                .prose(format!("The corrected input points along the sensor's own axis. On the mounting face (the frame after the last joint) that axis is turned by {tilts}; a rate or force known there has this component along it:"))
                .table(table);
        } else if !mounting.missing.is_empty() {
            section = section.prose(format!(
                "The rotation from the sensor's axis to the mounting face needs {tilts}; {} not estimable here.",
                is_or_are(&mounting.missing)
            ));
        }
        let others: Vec<&str> = report
            .parameters
            .iter()
            .filter(|p| p.kind == "tilt" && !mounting.tilts.contains(&p.id))
            .map(|p| p.id.as_str())
            .collect();
        if !others.is_empty() {
            let verb =
                if others.len() == 1 { "belongs to the bench and stays" } else { "belong to the bench and stay" };
            section = section.prose(format!("{} {verb} there.", cells::names(&others)));
        }
    }
    section
}

fn is_or_are(names: &[String]) -> String {
    format!("{} {}", cells::names(names), if names.len() == 1 { "is" } else { "are" })
}

fn budget(report: &FitReport) -> Result<Section> {
    let mut section = Section::new("Where the uncertainty comes from").figures(budget_figures(report)?);
    let mut table = Table::new(&[
        ("quantity", Align::Left),
        ("source", Align::Left),
        ("type", Align::Left),
        ("distribution", Align::Left),
        ("u of source", Align::Right),
        ("c", Align::Right),
        ("\u{3bd}", Align::Right),
        ("contribution", Align::Right),
        ("share", Align::Right),
    ]);
    table.small = true;
    let parameters = report.parameters.iter().map(|p| (&p.id, &p.budget));
    let derived = report.derived.iter().map(|d| (&d.id, &d.budget));
    let mut hidden = 0;
    for (id, budget) in parameters.chain(derived) {
        let mut first = true;
        for line in budget {
            if line.share < 5e-4 {
                hidden += 1;
                continue;
            }
            table.row(vec![
                if first { format!("`{id}`") } else { String::new() },
                line.source.clone(),
                line.evaluation.clone(),
                line.distribution.clone(),
                cells::digits(line.source_u, 3),
                cells::digits(line.c, 4),
                cells::dof(line.dof, true),
                significant(line.u, 3),
                cells::percent(line.share),
            ]);
            if let Some(row) = table.rows.last_mut() {
                row.rule = first;
            }
            first = false;
        }
    }
    table.note = "Angles in radians. c: sensitivity coefficient of a single source; \u{3bd}: degrees of freedom; share: part of the variance.".into();
    if hidden > 0 {
        table
            .note
            .push_str(&format!(" {} below 0.05 % of the variance left out.", cells::count(hidden, "contribution")));
    }
    section = section.table(table);
    Ok(section)
}

fn residuals(fit: &Fit, report: &FitReport) -> Result<Section> {
    Ok(Section::new("Residuals and correlations")
        .figures(residual_figures(fit, report)?)
        .figures(spread_figures(report)?))
}

fn assumptions(fit: &Fit, report: &FitReport) -> Section {
    let mut points = Vec::new();
    if !report.assumed_zero.is_empty() {
        points.push(format!("Taken as zero, neither known nor estimated: {}.", cells::names(&report.assumed_zero)));
    }
    points.push(match fit.campaign.bench.site {
        Some(site) => format!(
            "Site: latitude {}\u{b0}, Earth rate {} deg/h, gravity {} g.",
            site.latitude_deg, site.earth_rate_deg_h, site.gravity_g
        ),
        None => "No site: no Earth rate, and gravity is 1 g.".into(),
    });
    points.push(match report.estimator.as_str() {
        "linear" => "Linear: rows are exact derivatives at the reference point, and one step is taken from it.".into(),
        _ => "Exact: rows are exact derivatives, iterated to the solution.".into(),
    });
    points.push(match report.fit.variance.as_str() {
        "stated" => "Uncertainties of the readings are as stated.".into(),
        _ => "Readings of one sensor scatter alike and independently; how much, their residuals say.".into(),
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
            if known.u > 0.0 { known.distribution.clone() } else { String::new() },
            if known.u > 0.0 { cells::dof(known.dof, true) } else { String::new() },
            known.unit.clone(),
        ]);
    }
    Section::new("What was assumed").list(points).table(table)
}

/// More readings than this are not listed one by one.
const LISTED: usize = 1000;

fn readings(fit: &Fit, report: &FitReport) -> Section {
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
