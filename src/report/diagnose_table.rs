//! A diagnosis as a person reads it at a terminal.

use super::PositionReport;
use super::diagnose::{DiagnoseReport, EffectReport, LevelReport};
use super::table::{plain, rounded, significant};

/// Most aliases, places and positions that are listed at a terminal; the JSON report has all.
const LISTED: usize = 8;

/// The whole diagnosis.
pub fn diagnose_table(report: &DiagnoseReport) -> String {
    let mut text = format!("tumble {}: diagnosis on {}\n", report.tumble, report.bench);
    for (sensor, line) in &report.model_before {
        text.push_str(&format!("  {sensor} = {line}\n"));
    }
    text.push_str(&format!("\n{}\n\n", verdict(report)));
    if report.verdict == "not-diagnosable" {
        return text;
    }
    for effect in &report.effects {
        text.push_str(&found(effect));
    }
    if report.model_after != report.model_before {
        for (sensor, line) in &report.model_after {
            text.push_str(&format!("repaired: {sensor} = {line}\n"));
        }
        text.push('\n');
    }
    text.push_str(&gap(report));
    if let Some(unexplained) = &report.unexplained {
        text.push_str(&format!("\n{}\n", unexplained.pattern));
        if !unexplained.nearest.is_empty() {
            text.push_str(&format!(
                "nearest of the catalogue: {} would take off {:.1} % and leave more than noise: not accepted\n",
                unexplained.nearest.join(" + "),
                100.0 * unexplained.nearest_explains
            ));
        }
        let rows: Vec<Vec<String>> = unexplained
            .cells
            .iter()
            .take(2 * LISTED)
            .map(|cell| {
                vec![
                    at(&cell.at),
                    cell.sensor.clone(),
                    cell.readings.to_string(),
                    significant(cell.mean, 3),
                    format!("{:.1}", cell.z),
                ]
            })
            .collect();
        text.push_str(&format!("\n{}", plain(&["at", "sensor", "readings", "mean gap", "in sd"], &rows)));
    }
    if report.verdict != "nothing-missing" {
        text.push_str(&places(report));
    }
    if !report.parameters.is_empty() {
        text.push_str(&changes(report));
    }
    if let Some(holdout) = &report.holdout {
        let after = holdout.after.map_or(String::new(), |after| format!(", with the effects {after:.2}"));
        text.push_str(&format!(
            "\npositions left out in turn are predicted to {:.2} sd of the noise{after} ({} positions; {} cannot be left out)\n",
            holdout.before, holdout.positions, holdout.skipped
        ));
    }
    if report.constraints_left_out > 0 {
        text.push_str(&format!(
            "{} constraints were left out: the free model is diagnosed\n",
            report.constraints_left_out
        ));
    }
    text
}

fn verdict(report: &DiagnoseReport) -> String {
    let tried = format!(
        "{} effects tried, {} of them distinct here, significance {}",
        report.candidates, report.distinct_candidates, report.significance
    );
    match report.verdict.as_str() {
        "effects-found" if report.effects.len() == 1 => format!("EFFECTS FOUND: one effect is missing ({tried})"),
        "effects-found" => format!("EFFECTS FOUND: {} effects are missing ({tried})", report.effects.len()),
        "nothing-missing" => format!("NOTHING MISSING: the gap is noise ({tried})"),
        "unexplained" => format!("UNEXPLAINED: something is missing that nothing in the catalogue explains ({tried})"),
        _ => {
            let positions: Vec<String> = report.would_help.iter().map(at).collect();
            format!(
                "NOT DIAGNOSABLE: there are as many unknowns as readings, so nothing can be diagnosed{}",
                if positions.is_empty() {
                    String::new()
                } else {
                    format!("; a further reading would change that, best at {}", positions.join("; or "))
                }
            )
        }
    }
}

fn found(effect: &EffectReport) -> String {
    let sensor = effect.sensor.as_ref().map_or("all sensors".to_string(), |s| format!("sensor {s}"));
    let mut text = format!("{}  {} ({sensor})\n", effect.regressor, effect.name);
    if let Some(value) = effect.value {
        let (value, u, unit) = match effect.arcsec {
            Some(arcsec) => (arcsec, effect.u.map(|u| u * super::ARCSEC), "arcsec".to_string()),
            None => (value, effect.u, effect.unit.clone()),
        };
        text.push_str(&format!("  {} = {} {unit}", effect.coefficient, rounded(value, u)));
        if let Some(u) = u {
            text.push_str(&format!(", u = {}", rounded(u, Some(u))));
        }
        text.push_str(&format!("; t = {:.1}, p = {}", effect.t, significant(effect.p, 2)));
    }
    text.push_str(&format!("; explains {:.1} % of the gap\n", 100.0 * effect.explains));
    if effect.zero_but_for_rounding {
        text.push_str("  zero at these positions but for rounding: the coefficient is absurd\n");
    }
    if !effect.aliases.is_empty() {
        let name = |alias: &super::diagnose::AliasReport| {
            let mut text = alias.regressor.clone();
            if !alias.exact {
                text.push_str(&format!(" (+{:.1})", alias.excess));
            }
            if alias.zero_but_for_rounding {
                text.push_str(" (zero but for rounding)");
            }
            if let Some(other) = &alias.together_with {
                text.push_str(&format!(" (with {other})"));
            }
            text
        };
        let names: Vec<String> = effect.aliases.iter().take(2 * LISTED).map(name).collect();
        let more = effect.aliases.len().saturating_sub(names.len());
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        text.push_str(&format!("  cannot be told here from: {}{more}\n", names.join(", ")));
    }
    if !effect.separate_by.is_empty() {
        let positions: Vec<String> = effect.separate_by.iter().map(at).collect();
        text.push_str(&format!("  one more position would tell, best first: {}\n", positions.join("; ")));
    }
    if !effect.why.is_empty() {
        text.push_str(&format!("  why: {}\n", effect.why));
    }
    if !effect.confirm.is_empty() {
        text.push_str(&format!("  confirm: {}\n", effect.confirm));
    }
    text.push('\n');
    text
}

fn at(position: &PositionReport) -> String {
    let keys: Vec<String> = position.iter().map(|(key, value)| format!("{key} {value}")).collect();
    keys.join(", ")
}

fn gap(report: &DiagnoseReport) -> String {
    let row = |name: &str, gap: &super::diagnose::GapReport| {
        vec![
            name.to_string(),
            gap.rms.map_or("-".into(), |v| significant(v, 4)),
            significant(gap.max, 4),
            significant(gap.chi_square, 4),
            gap.dof.to_string(),
            gap.p.map_or("-".into(), |p| significant(p, 2)),
        ]
    };
    let mut rows = vec![row("before", &report.gap.before)];
    if !report.effects.is_empty() {
        rows.push(row("after", &report.gap.after));
    }
    let sd = report.gap.noise.sd.map_or("unknown".into(), |sd| significant(sd, 3));
    format!(
        "{}noise floor: sd {sd}, from {}\n",
        plain(&["gap", "rms", "max", "chi-square", "dof", "p"], &rows),
        match report.gap.noise.from.as_str() {
            "residuals" => "the residuals of the finished model (nothing else tells; completeness cannot be tested)",
            "stated" => "the stated uncertainties",
            _ => "replicates",
        }
    )
}

fn places(report: &DiagnoseReport) -> String {
    let rows: Vec<Vec<String>> = report
        .places
        .iter()
        .filter(|place| place.p < report.significance)
        .take(LISTED)
        .map(|place| {
            let level = match &place.level {
                LevelReport::Number(v) => significant(*v, 5).trim_end_matches(".0000").to_string(),
                LevelReport::Text(text) => text.clone(),
            };
            vec![
                place.factor.clone(),
                level,
                place.sensor.clone(),
                place.readings.to_string(),
                significant(place.mean, 3),
                significant(place.p, 2),
            ]
        })
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    format!("\n{}", plain(&["where the gap was", "level", "sensor", "readings", "mean gap", "p alone"], &rows))
}

fn changes(report: &DiagnoseReport) -> String {
    let number = |value: Option<f64>, u: Option<f64>| value.map_or("-".into(), |v| rounded(v, u));
    let rows: Vec<Vec<String>> = report
        .parameters
        .iter()
        .map(|p| {
            vec![
                p.id.clone(),
                number(p.before, p.u_before),
                number(p.u_before, p.u_before),
                number(p.after, p.u_after),
                number(p.u_after, p.u_after),
                p.unit.clone(),
                p.change_in_u.map_or("-".into(), |c| format!("{c:+.1}")),
            ]
        })
        .collect();
    format!("\n{}", plain(&["what it does to", "before", "u", "after", "u", "unit", "change in u"], &rows))
}
