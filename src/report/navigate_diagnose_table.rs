//! A diagnosis of navigation errors as a person reads it at a terminal.

use super::GapReport;
use super::diagnose::words;
use super::navigate_diagnose::{
    NavigateDiagnoseReport, NavigationAliasReport, NavigationEffectReport, NavigationSuspectReport,
};
use super::table::{plain, rounded, significant};
use super::wrap::hanging;
use crate::diagnosis::{NoiseFrom, Verdict};

/// Most aliases and cells that are listed at a terminal; the JSON report has all.
const LISTED: usize = 8;

/// The whole diagnosis.
pub fn navigate_diagnose_table(report: &NavigateDiagnoseReport) -> String {
    let title = if report.mission.is_empty() { "a mission" } else { &report.mission };
    let runs: Vec<String> = report.runs.iter().map(|run| format!("{} rows of {}", run.rows, run.motion)).collect();
    let left_out = match report.left_out {
        0 => String::new(),
        rows => format!("; {rows} rows of other scenarios left out"),
    };
    let mut text = format!("tumble {}: diagnosis of navigation errors, {title}\n", report.tumble);
    text.push_str(&format!("  measured: {}{left_out}\n\n{}\n\n", runs.join(", "), verdict(report)));
    for effect in &report.effects {
        text.push_str(&found(effect, report.effects.len() == 1));
    }
    text.push_str(&gap(report));
    text.push_str(&format!("\n{}", channels(report)));
    if let Some(unexplained) = &report.unexplained {
        text.push_str(&format!("\n{}\n", unexplained.pattern));
        if !unexplained.nearest.is_empty() {
            text.push_str(&format!(
                "nearest of the catalogue: {} would take off {:.2} % and leave more than noise: not accepted\n",
                unexplained.nearest.join(" + "),
                100.0 * unexplained.nearest_explains
            ));
        }
        let rows = unexplained.cells.iter().take(LISTED).map(|cell| {
            vec![
                cell.column.clone(),
                cell.motion.clone(),
                format!("{} to {}", significant(cell.from_h, 3), significant(cell.to_h, 3)),
                significant(cell.mean, 3),
                format!("{:.1}", cell.z),
            ]
        });
        let rows: Vec<Vec<String>> = rows.collect();
        text.push_str(&format!("\n{}", plain(&["where", "motion", "time, h", "mean gap", "in sd"], &rows)));
    }
    if !report.suspects.is_empty() {
        let row = |own: &NavigationSuspectReport| {
            vec![own.column.clone(), own.motion.clone(), own.time_s.to_string(), format!("{:+.1}", own.z)]
        };
        let rows: Vec<Vec<String>> = report.suspects.iter().take(LISTED).map(row).collect();
        text.push_str(&format!("\n{}", plain(&["single values far off", "motion", "time, s", "in u"], &rows)));
    }
    if !report.invisible.is_empty() {
        let line = format!("these data cannot show: {}", grouped(&report.invisible).join(", "));
        text.push_str(&format!("\n{}\n", hanging(&line, 2)));
    }
    text
}

/// Error sources by group: `gyro_bias (x, y)`.
pub(super) fn grouped(ids: &[String]) -> Vec<String> {
    let mut groups: Vec<(&str, Vec<&str>)> = Vec::new();
    for (group, axes) in ids.iter().filter_map(|id| id.rsplit_once('_')) {
        match groups.iter_mut().find(|(name, _)| *name == group) {
            Some((_, list)) => list.push(axes),
            None => groups.push((group, vec![axes])),
        }
    }
    groups.into_iter().map(|(group, axes)| format!("{group} ({})", axes.join(", "))).collect()
}

/// The verdict as a sentence, without a full stop.
pub(super) fn sentence(report: &NavigateDiagnoseReport) -> String {
    match (report.verdict, report.effects.len()) {
        (Verdict::EffectsFound | Verdict::PartlyExplained, count) => found_in_words(report, count),
        (Verdict::NothingMissing, _) => "the gap is noise".into(),
        (Verdict::Unexplained, _) => {
            "something is missing that no error of the unit, the start or the reference explains".into()
        }
        (Verdict::NotDiagnosable, _) => "nothing can be diagnosed: fewer than three values were measured".into(),
    }
}

/// How many errors of the mission, faults of the reference and single values were found.
fn found_in_words(report: &NavigateDiagnoseReport, count: usize) -> String {
    let begins = |start: &str| report.effects.iter().filter(|effect| effect.regressor.starts_with(start)).count();
    let (reference, readings) = (begins("reference:"), begins("reading:"));
    let mission = count - reference - readings;
    let number = |count: usize, one: &str, many: &str| match count {
        0 => None,
        1 => Some(format!("one {one}")),
        count => Some(format!("{count} {many}")),
    };
    let missing = number(mission, "error is missing from the mission", "errors are missing from the mission");
    let parts = [
        missing,
        number(reference, "fault of the reference", "faults of the reference"),
        number(readings, "single wrong value", "single wrong values"),
    ];
    parts.into_iter().flatten().collect::<Vec<String>>().join(", ")
}

fn verdict(report: &NavigateDiagnoseReport) -> String {
    let label = match report.verdict {
        Verdict::EffectsFound => "EFFECTS FOUND",
        Verdict::NothingMissing => "NOTHING MISSING",
        Verdict::PartlyExplained => "PARTLY EXPLAINED",
        Verdict::Unexplained => "UNEXPLAINED",
        Verdict::NotDiagnosable => return format!("NOT DIAGNOSABLE: {}", sentence(report)),
    };
    format!("{label}: {}\n({})", sentence(report), tried(report))
}

/// How much was tried.
pub(super) fn tried(report: &NavigateDiagnoseReport) -> String {
    format!(
        "{} causes tried, {} of them distinct here; significance {}",
        report.candidates, report.distinct_candidates, report.significance
    )
}

fn found(effect: &NavigationEffectReport, alone: bool) -> String {
    let mut text = format!("{}  {}\n", effect.regressor, effect.name);
    text.push_str(&format!("  = {} {}", rounded(effect.value, effect.u), unit(&effect.unit)));
    if let Some(u) = effect.u {
        text.push_str(&format!(", u = {}", rounded(u, Some(u))));
    }
    text.push_str(&format!("; t = {:.1}, {}", effect.t, words::p_is(effect.p)));
    let beyond = if alone { "" } else { " beyond the others" };
    text.push_str(&format!("; explains {:.1} % of the gap{beyond}\n", 100.0 * effect.explains));
    if let (Some(before), Some(after)) = (effect.before.filter(|before| *before != 0.0), effect.after) {
        // without what a unit of radians costs in the last digits
        let before: f64 = format!("{before:.9e}").parse().unwrap_or(before);
        text.push_str(&format!("  the mission had {before}, and has {} with it\n", rounded(after, effect.u)));
    }
    if !effect.aliases.is_empty() {
        let names: Vec<String> = effect.aliases.iter().take(LISTED).map(alias).collect();
        let more = effect.aliases.len().saturating_sub(names.len());
        let more = if more > 0 { format!("\n    and {more} more") } else { String::new() };
        text.push_str(&format!("  cannot be told here from:\n    {}{more}\n", names.join("\n    ")));
    }
    let possible = effect.aliases.iter().filter(|alias| !alias.absurd && alias.together_with.is_none()).count();
    for (k, separation) in effect.separate_by.iter().enumerate() {
        let lead = if k == 0 { "would tell, best first:" } else { "                    or:" };
        text.push_str(&format!(
            "  {lead} {} ({} of {possible}, by {:.0} sd)\n",
            separation.is,
            separation.tells.len(),
            separation.by
        ));
    }
    text.push('\n');
    text
}

pub(super) fn unit(unit: &str) -> &str {
    if unit == "1" { "(ratio)" } else { unit }
}

pub(super) fn alias(alias: &NavigationAliasReport) -> String {
    let mut text = alias.regressor.clone();
    if let Some(value) = alias.value {
        text.push_str(&format!(" = {} {}", significant(value, 4), unit(&alias.unit)));
    }
    if alias.absurd {
        text.push_str(" (absurd)");
    }
    if !alias.exact {
        text.push_str(&format!(" (+{:.1})", alias.excess));
    }
    if let Some(other) = &alias.together_with {
        text.push_str(&format!(" (with {other})"));
    }
    text
}

fn gap(report: &NavigateDiagnoseReport) -> String {
    let row = |name: &str, gap: &GapReport| {
        vec![
            name.to_string(),
            gap.rms.map_or("-".into(), |v| significant(v, 4)),
            significant(gap.max, 4),
            significant(gap.chi_square, 4),
            gap.dof.to_string(),
            gap.p.map_or("-".into(), words::p),
        ]
    };
    let mut rows = vec![row("before", &report.gap.before)];
    if !report.effects.is_empty() {
        rows.push(row("after", &report.gap.after));
    }
    format!(
        "{}noise: {}\n",
        plain(&["gap, in u", "rms", "max", "chi-square", "dof", "p"], &rows),
        match report.gap.noise.from {
            NoiseFrom::Residuals =>
                "u is not stated everywhere, so it comes from what is left of each channel (completeness cannot be tested)",
            _ => "the stated standard uncertainties",
        }
    )
}

fn channels(report: &NavigateDiagnoseReport) -> String {
    let several = report.runs.len() > 1;
    let found = !report.effects.is_empty();
    let mut titles = vec!["gap, rms"];
    titles.extend(several.then_some("motion"));
    titles.push("before");
    titles.extend(found.then_some("after"));
    titles.push("u");
    let rows: Vec<Vec<String>> = report
        .channels
        .iter()
        .map(|own| {
            let mut row = vec![own.column.clone()];
            row.extend(several.then(|| own.motion.clone()));
            row.push(significant(own.rms_before, 4));
            row.extend(found.then(|| significant(own.rms_after, 4)));
            row.push(significant(own.u, 3) + if own.u_from == NoiseFrom::Stated { "" } else { " (from residuals)" });
            row
        })
        .collect();
    plain(&titles, &rows)
}
