//! A diagnosis of navigation errors as a person reads it at a terminal.

use super::GapReport;
use crate::document::number::probability;
use super::navigate_diagnose::{
    NavigateDiagnoseReport, NavigationAliasReport, NavigationEffectReport, NavigationGapStepReport,
    NavigationSuspectReport,
};
use super::table::{plain, rounded, significant};
use super::wrap::hanging;
use crate::diagnosis::{NoiseFrom, Verdict};
use crate::language::{Language, say};

/// Most aliases and cells that are listed at a terminal; the JSON report has all.
const LISTED: usize = 8;

/// The whole diagnosis.
pub fn navigate_diagnose_table(report: &NavigateDiagnoseReport, lang: Language) -> String {
    let title = if report.mission.is_empty() { say!(lang, "a-mission") } else { &report.mission };
    let left_out = match report.left_out {
        0 => String::new(),
        rows => say!(lang, "rows-of-other-scenarios-left-out", rows = rows.to_string()),
    };
    let mut text = format!("{}\n", say!(lang, "tumble-diagnosis-of-navigation-errors", tumble = report.tumble, title));
    let measured =
        say!(lang, "navigate-diagnose-table-measured", runs = runs(report, lang).join(lang.comma()), left_out);
    text.push_str(&format!("{}\n\n{}\n\n", hanging(&format!("  {measured}"), 4), verdict(report, lang)));
    for effect in &report.effects {
        text.push_str(&found(effect, report.effects.len() == 1, lang));
    }
    text.push_str(&gap(report, lang));
    text.push_str(&format!("\n{}", channels(report, lang)));
    if let Some(unexplained) = &report.unexplained {
        text.push_str(&format!("\n{}\n", lang.name(&unexplained.pattern)));
        if !unexplained.nearest.is_empty() {
            text.push_str(&format!(
                "{}\n",
                say!(
                    lang,
                    "nearest-of-the-catalogue-would-take-off",
                    nearest = unexplained.nearest.join(" + "),
                    share = format!("{:.2}", 100.0 * unexplained.nearest_explains)
                )
            ));
        }
        let rows = unexplained.cells.iter().take(LISTED).map(|cell| {
            vec![
                cell.column.clone(),
                cell.motion.clone(),
                say!(lang, "from-to", a = significant(cell.from_h, 3), b = significant(cell.to_h, 3)),
                significant(cell.mean, 3),
                format!("{:.1}", cell.z),
            ]
        });
        let rows: Vec<Vec<String>> = rows.collect();
        text.push_str(&format!(
            "\n{}",
            plain(
                &[
                    say!(lang, "where"),
                    say!(lang, "motion"),
                    say!(lang, "time-h"),
                    say!(lang, "mean-gap"),
                    say!(lang, "in-sd")
                ],
                &rows
            )
        ));
    }
    if !report.suspects.is_empty() {
        let row = |own: &NavigationSuspectReport| {
            vec![own.column.clone(), own.motion.clone(), own.time_s.to_string(), format!("{:+.1}", own.z)]
        };
        let rows: Vec<Vec<String>> = report.suspects.iter().take(LISTED).map(row).collect();
        text.push_str(&format!(
            "\n{}",
            plain(
                &[say!(lang, "single-values-far-off"), say!(lang, "motion"), say!(lang, "time-s"), say!(lang, "in-u")],
                &rows
            )
        ));
    }
    if !report.invisible.is_empty() {
        let line = say!(lang, "these-data-cannot-show", sources = grouped(&report.invisible).join(", "));
        text.push_str(&format!("\n{}\n", hanging(&line, 2)));
    }
    text
}

/// How many rows were measured of each motion.
pub(super) fn runs(report: &NavigateDiagnoseReport, lang: Language) -> Vec<String> {
    let one = |run: &super::navigate_diagnose::RunReport| say!(lang, "rows-of", n = run.rows, motion = run.motion);
    report.runs.iter().map(one).collect()
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
pub(super) fn sentence(report: &NavigateDiagnoseReport, lang: Language) -> String {
    match (report.verdict, report.effects.len()) {
        (Verdict::EffectsFound, count) => found_in_words(report, count, lang),
        (Verdict::PartlyExplained, count) => {
            say!(lang, "what-remains-is-more-than-noise", found = found_in_words(report, count, lang))
        }
        (Verdict::NothingMissing, _) => say!(lang, "the-gap-is-noise").into(),
        (Verdict::Unexplained, _) => say!(lang, "something-is-missing-that-no-error-of").into(),
        (Verdict::NotDiagnosable, _) => say!(lang, "nothing-can-be-diagnosed-fewer-than-three").into(),
    }
}

/// How many errors of the mission, faults of the reference and single values were found.
fn found_in_words(report: &NavigateDiagnoseReport, count: usize, lang: Language) -> String {
    let begins = |start: &str| report.effects.iter().filter(|effect| effect.regressor.starts_with(start)).count();
    let (reference, readings) = (begins("reference:"), begins("reading:"));
    let mission = count - reference - readings;
    let parts = [
        (mission > 0).then(|| say!(lang, "errors-are-missing-from-the-mission", n = mission)),
        (reference > 0).then(|| say!(lang, "faults-of-the-reference", n = reference)),
        (readings > 0).then(|| say!(lang, "single-wrong-values", n = readings)),
    ];
    parts.into_iter().flatten().collect::<Vec<String>>().join(lang.clause())
}

fn verdict(report: &NavigateDiagnoseReport, lang: Language) -> String {
    let label = match report.verdict {
        Verdict::EffectsFound => say!(lang, "effects-found"),
        Verdict::NothingMissing => say!(lang, "nothing-missing"),
        Verdict::PartlyExplained => say!(lang, "partly-explained"),
        Verdict::Unexplained => say!(lang, "unexplained"),
        Verdict::NotDiagnosable => {
            return format!("{}{}{}", say!(lang, "not-diagnosable"), lang.colon(), sentence(report, lang));
        }
    };
    format!("{label}{}{}\n{}", lang.colon(), sentence(report, lang), lang.in_parentheses(&tried(report, lang)))
}

/// How much was tried.
pub(super) fn tried(report: &NavigateDiagnoseReport, lang: Language) -> String {
    say!(
        lang,
        "causes-tried-of-them-distinct-here-significance",
        candidates = report.candidates.to_string(),
        distinct = report.distinct_candidates.to_string(),
        significance = report.significance
    )
}

fn found(effect: &NavigationEffectReport, alone: bool, lang: Language) -> String {
    let mut text = format!("{}  {}\n", effect.regressor, lang.name(&effect.name));
    text.push_str(&format!("  = {} {}", rounded(effect.value, effect.u), unit(&effect.unit, lang)));
    if let Some(u) = effect.u {
        text.push_str(&format!(", u = {}", rounded(u, Some(u))));
    }
    text.push_str(&format!("{}t = {:.1}, p = {}", lang.semicolon(), effect.t, probability(effect.p)));
    let share = format!("{:.1}", 100.0 * effect.explains);
    let explains = match alone {
        true => say!(lang, "explains-of-the-gap", share),
        false => say!(lang, "explains-of-the-gap-beyond-the-others", share),
    };
    text.push_str(&format!("{}{explains}\n", lang.semicolon()));
    if let (Some(before), Some(after)) = (effect.before.filter(|before| *before != 0.0), effect.after) {
        // without what a unit of radians costs in the last digits
        let before: f64 = format!("{before:.9e}").parse().unwrap_or(before);
        text.push_str(&format!(
            "  {}\n",
            say!(
                lang,
                "the-mission-had-and-has-with-it",
                before = before.to_string(),
                after = rounded(after, effect.u)
            )
        ));
    }
    if !effect.aliases.is_empty() {
        let names: Vec<String> = effect.aliases.iter().take(LISTED).map(|own| alias(own, lang)).collect();
        let more = effect.aliases.len().saturating_sub(names.len());
        let more = if more > 0 {
            format!("\n    {}", say!(lang, "and-more-2", more = more.to_string()))
        } else {
            String::new()
        };
        text.push_str(&format!("  {}\n    {}{more}\n", say!(lang, "cannot-be-told-here-from"), names.join("\n    ")));
    }
    let possible = effect.aliases.iter().filter(|alias| !alias.absurd && alias.together_with.is_none()).count();
    for (k, separation) in effect.separate_by.iter().enumerate() {
        if k == 0 {
            text.push_str(&format!("  {}\n", say!(lang, "would-tell-best-first")));
        }
        let [tells, possible] = [separation.tells.len(), possible].map(|n| n.to_string());
        let by = format!("{:.0}", separation.by);
        let line = say!(lang, "run-tells-of", motion = lang.name(&separation.is), tells, possible, by);
        text.push_str(&format!("{}\n", hanging(&format!("    {line}"), 6)));
    }
    text.push('\n');
    text
}

pub(super) fn unit(unit: &str, lang: Language) -> &str {
    if unit == "1" { say!(lang, "ratio-unit") } else { unit }
}

pub(super) fn alias(alias: &NavigationAliasReport, lang: Language) -> String {
    let mut text = alias.regressor.clone();
    if let Some(value) = alias.value {
        text.push_str(&format!(" = {} {}", significant(value, 4), unit(&alias.unit, lang)));
    }
    if alias.absurd {
        text.push_str(&format!(" {}", say!(lang, "absurd")));
    }
    if !alias.exact {
        text.push_str(&format!(" (+{:.1})", alias.excess));
    }
    if let Some(other) = &alias.together_with {
        text.push_str(&format!(" ({})", say!(lang, "together-with", other)));
    }
    text
}

/// The gap between before and after, by the cause that is added: of several causes only, as the last step is what is after.
pub(super) fn between(report: &NavigateDiagnoseReport) -> Vec<(String, GapReport)> {
    let steps = &report.gap_steps;
    let inner = steps.iter().skip(1).take(steps.len().saturating_sub(2));
    let added =
        |own: &NavigationGapStepReport| (format!("+ {}", own.with.last().map_or("", String::as_str)), own.gap.clone());
    inner.map(added).collect()
}

/// What the last gap is called: after all, with the cause that was added last where several were.
pub(super) fn after(report: &NavigateDiagnoseReport, lang: Language) -> String {
    let after = say!(lang, "after-repair");
    match report.gap_steps.as_slice() {
        [_, .., before, last] if before.with != last.with => {
            format!("+ {}, {after}", last.with.last().map_or("", String::as_str))
        }
        _ => after.to_string(),
    }
}

fn gap(report: &NavigateDiagnoseReport, lang: Language) -> String {
    let row = |name: &str, gap: &GapReport| {
        vec![
            name.to_string(),
            gap.rms.map_or("-".into(), |v| significant(v, 4)),
            significant(gap.max, 4),
            significant(gap.chi_square, 4),
            gap.dof.to_string(),
            gap.p.map_or("-".into(), probability),
        ]
    };
    let mut rows = vec![row(say!(lang, "before-repair"), &report.gap.before)];
    rows.extend(between(report).iter().map(|(name, gap)| row(name, gap)));
    if !report.effects.is_empty() {
        rows.push(row(&after(report, lang), &report.gap.after));
    }
    format!(
        "{}{}\n",
        plain(
            &[
                say!(lang, "gap-in-u"),
                say!(lang, "rms"),
                say!(lang, "max"),
                say!(lang, "chi-square"),
                say!(lang, "dof"),
                "p"
            ],
            &rows
        ),
        match report.gap.noise.from {
            NoiseFrom::Residuals => say!(lang, "noise-u-is-not-stated-everywhere-so"),
            _ => say!(lang, "noise-the-stated-standard-uncertainties"),
        }
    )
}

fn channels(report: &NavigateDiagnoseReport, lang: Language) -> String {
    let several = report.runs.len() > 1;
    let found = !report.effects.is_empty();
    let mut titles = vec![say!(lang, "gap-rms")];
    titles.extend(several.then_some(say!(lang, "motion")));
    titles.push(say!(lang, "before-repair"));
    titles.extend(found.then_some(say!(lang, "after-repair")));
    titles.push("u");
    let rows: Vec<Vec<String>> = report
        .channels
        .iter()
        .map(|own| {
            let mut row = vec![own.column.clone()];
            row.extend(several.then(|| own.motion.clone()));
            row.push(significant(own.rms_before, 4));
            row.extend(found.then(|| significant(own.rms_after, 4)));
            row.push(match own.u_from {
                NoiseFrom::Stated => significant(own.u, 3),
                _ => format!("{} {}", significant(own.u, 3), say!(lang, "from-residuals")),
            });
            row
        })
        .collect();
    plain(&titles, &rows)
}
