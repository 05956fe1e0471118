//! Sections of a fit's page on what was checked: agreement of the readings, constraints, the robust estimator, Monte Carlo.

use super::{Align, Section, Table, Tone, cells};
use crate::campaign::Kind;
use crate::report::fit_constraints::ConstraintsStatus;
use crate::report::table::{rounded, significant};
use crate::report::{ARCSEC, FitReport};

/// What the checks found, as verdicts for the head of the page.
pub(super) fn verdicts(report: &FitReport) -> Vec<(Tone, String)> {
    let mut verdicts = Vec::new();
    if let Some(constraints) = &report.constraints {
        let tone = if constraints.status == ConstraintsStatus::Met { Tone::Plain } else { Tone::Bad };
        verdicts.push((tone, sentence(&constraints.verdict)));
    }
    if let Some(test) = report.checks.lack_of_fit.as_ref().filter(|test| test.rejected) {
        let text =
            format!("Lack of fit: the model leaves more than replicates scatter (p = {}).", significant(test.p, 3));
        verdicts.push((Tone::Bad, text));
    }
    let suspects = report.checks.snooping.as_ref().map(|s| s.suspects.as_slice()).unwrap_or_default();
    if !suspects.is_empty() {
        let numbers: Vec<String> = suspects.iter().map(|s| s.index.to_string()).collect();
        let what = if suspects.len() == 1 { "reading" } else { "readings" };
        verdicts.push((Tone::Caution, format!("Suspicious: {what} {}. See the checks.", numbers.join(", "))));
    }
    if let Some(robust) = report.robust.as_ref().filter(|robust| !robust.converged) {
        verdicts.push((Tone::Bad, format!("The robust estimator ({}) did not settle.", robust.method)));
    }
    verdicts
}

/// The checks of the readings.
pub(super) fn checks(report: &FitReport) -> Section {
    let checks = &report.checks;
    let mut section = Section::new("Checks").list(checks.verdict.iter().map(|line| sentence(line)).collect());
    let mut tests = Table::new(&[("test", Align::Left), ("statistic", Align::Left), ("p", Align::Right)]);
    if let Some(test) = &checks.lack_of_fit {
        tests.row(vec![
            "lack of fit".into(),
            format!("F = {} with {} and {} \u{3bd}", cells::digits(test.f, 4), test.between_dof, test.pure_error_dof),
            significant(test.p, 3),
        ]);
    }
    for (sensor, test) in &checks.runs {
        tests.row(vec![
            format!("runs of `{sensor}`"),
            format!("{} runs, {} expected", test.runs, significant(test.expected, 3)),
            significant(test.p, 3),
        ]);
    }
    if let Some(test) = &checks.normality {
        tests.row(vec![
            "normality".into(),
            format!("Shapiro-Francia W' = {}", significant(test.w, 4)),
            significant(test.p, 3),
        ]);
    }
    section = section.table(tests);
    if let Some(snooping) = &checks.snooping {
        let mut table = Table::new(&[
            ("suspicious reading", Align::Left),
            ("position", Align::Left),
            ("sensor", Align::Left),
            ("shift", Align::Decimal),
            ("u", Align::Decimal),
            ("w", Align::Decimal),
            ("p", Align::Right),
        ]);
        for s in &snooping.suspects {
            table.row(vec![
                s.index.to_string(),
                s.position.clone(),
                s.sensor.clone(),
                rounded(s.shift, Some(s.u)),
                rounded(s.u, Some(s.u)),
                format!("{:.2}", s.w),
                significant(s.p, 3),
            ]);
        }
        table.note = format!(
            "Shift: how far the reading is off what the others say. p: over all {} readings (Sidak).",
            snooping.tested
        );
        section = section.table(table);
    }
    let without = checks.snooping.as_ref().filter(|s| !s.suspects.is_empty()).map(|s| &s.without_suspects);
    let mut columns = vec![("parameter", Align::Left), ("weakest reading", Align::Right), ("effect", Align::Right)];
    if without.is_some() {
        columns.push(("change without suspects", Align::Right));
    }
    columns.push(("unit", Align::Left));
    let mut table = Table::new(&columns);
    table.small = true;
    for p in &report.parameters {
        let Some(external) = checks.external.get(&p.id) else { continue };
        let mut row = vec![format!("`{}`", p.id), external.index.to_string(), significant(external.effect, 3)];
        if let Some(changes) = without {
            row.push(cells::digits(changes.get(&p.id).copied(), 3));
        }
        row.push(if p.kind == Kind::Tilt { "arcsec".into() } else { p.unit.clone() });
        table.row(row);
    }
    table.caption = "External reliability".into();
    table.note =
        "Effect: what the smallest detectable fault of the reading named would do to the parameter, undetected.".into();
    section.table(table)
}

/// Constraints, the robust estimator and remounting, where the fit has them.
pub(super) fn conditions(report: &FitReport) -> Section {
    let mut section = Section::new("Constraints and weights");
    if let Some(constraints) = &report.constraints {
        let mut table = Table::new(&[
            ("constraint", Align::Right),
            ("", Align::Left),
            ("state", Align::Left),
            ("side", Align::Left),
            ("cost in chi-square", Align::Right),
        ]);
        for c in &constraints.list {
            table.row(vec![
                c.index.to_string(),
                format!("`{}`", c.text),
                c.state.to_string(),
                c.side.map_or(String::new(), |side| side.to_string()),
                cells::digits(c.cost, 3),
            ]);
        }
        section = section.prose(sentence(&constraints.verdict)).table(table);
    }
    if let Some(robust) = &report.robust {
        let low: Vec<String> = robust.downweighted.iter().map(usize::to_string).collect();
        let down = if low.is_empty() {
            "No reading lost more than half of its weight.".to_string()
        } else {
            format!("Less than half of their weight: readings {}.", low.join(", "))
        };
        let steps = cells::count(robust.iterations, "step");
        section = section.prose(format!("Robust estimator: {}, {steps} of reweighting. {down}", robust.method));
    }
    section
}

/// Monte Carlo beside the first order.
pub(super) fn monte_carlo(report: &FitReport) -> Section {
    let Some(drawn) = &report.monte_carlo else { return Section::new("Monte Carlo") };
    let level = report.parameters.first().map_or(0.95, |p| p.level);
    let interval = format!("interval ({})", cells::level(level));
    let mut table = Table::new(&[
        ("quantity", Align::Left),
        ("mean", Align::Decimal),
        ("u", Align::Decimal),
        (&interval, Align::Right),
        ("shortest", Align::Right),
        ("first order", Align::Right),
        ("unit", Align::Left),
    ]);
    for output in &drawn.outputs {
        let parameter = report.parameters.iter().find(|p| p.id == output.id);
        let derived = report.derived.iter().find(|d| d.id == output.id);
        let angle = parameter.is_some_and(|p| p.kind == Kind::Tilt) || derived.is_some_and(|d| d.arcsec.is_some());
        let (scale, unit) = match (angle, parameter) {
            (true, _) => (ARCSEC, "arcsec"),
            (false, Some(p)) => (1.0, p.unit.as_str()),
            (false, None) => (1.0, ""),
        };
        let u = Some(output.u * scale);
        let pair = |[a, b]: [f64; 2]| format!("{} to {}", rounded(a * scale, u), rounded(b * scale, u));
        table.row(vec![
            format!("`{}`", output.id),
            rounded(output.mean * scale, u),
            cells::value(u, u),
            pair(output.interval),
            pair(output.shortest),
            output.first_order.map_or_else(cells::dash, pair),
            unit.to_string(),
        ]);
        if let Some(row) = table.rows.last_mut().filter(|_| output.first_order_agrees == Some(false)) {
            row.tone = Tone::Caution;
        }
    }
    let trials = format!("{} of {} trials, seed {}.", drawn.trials, drawn.asked, drawn.seed);
    table.note = format!("{trials} Marked: the first order is not good to two digits of the uncertainty.");
    Section::new("Monte Carlo").list(drawn.verdict.iter().map(|line| sentence(line)).collect()).table(table)
}

/// A clause as a sentence: capital letter and full stop.
fn sentence(clause: &str) -> String {
    let mut letters = clause.chars();
    let first: String = letters.next().map(|c| c.to_uppercase().collect()).unwrap_or_default();
    let stop = if clause.ends_with(['.', '!', '?']) { "" } else { "." };
    format!("{first}{}{stop}", letters.as_str())
}
