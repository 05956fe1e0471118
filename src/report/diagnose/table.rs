//! A diagnosis as a person reads it at a terminal.

use super::super::scatter;
use super::super::table::{plain, rounded, significant};
use super::super::wrap::{WIDTH, hanging};
use super::{DiagnoseReport, EffectReport, GapReport, words};
use crate::diagnosis::Verdict;
use crate::document::{Detail, terminal};
use crate::elements::Parts;
use crate::language::{Language, say};

/// Most aliases, places and positions that are listed at a terminal; the JSON report has all.
const LISTED: usize = 8;
/// More constraints than this are only counted.
const CONSTRAINTS: usize = 12;

/// The whole diagnosis.
pub fn diagnose_table(report: &DiagnoseReport, lang: Language) -> String {
    let mut text = format!("{}\n", say!(lang, "tumble-diagnosis-on", tumble = report.tumble, bench = report.bench));
    for (sensor, line) in &report.model_before {
        text.push_str(&format!("  {sensor} = {line}\n"));
    }
    text.push_str(&format!("\n{}\n", verdict(report, lang)));
    text.push_str(&constraints(report, lang));
    text.push('\n');
    if report.verdict == Verdict::NotDiagnosable {
        return text;
    }
    for effect in &report.effects {
        text.push_str(&found(report, effect, lang));
    }
    text.push_str(&repaired(report, lang));
    text.push_str(&gap(report, lang));
    text.extend(terminal::section(&scatter::section(&report.scatter, lang), Detail::Brief, lang));
    text.push_str(&steps(report, lang));
    text.push_str(&unexplained(report, lang));
    if report.verdict != Verdict::NothingMissing {
        text.push_str(&places(report, lang));
    }
    if report.parameters.iter().any(|p| p.shift.is_some_and(|s| s != 0.0) || p.remainder_u > 0.0) {
        text.push_str(&changes(report, lang));
    }
    let holdout = words::holdout(report, lang);
    if !holdout.is_empty() {
        text.push_str(&format!("\n{}\n", hanging(&holdout, 2)));
    }
    text
}

fn verdict(report: &DiagnoseReport, lang: Language) -> String {
    let label = match report.verdict {
        Verdict::EffectsFound => say!(lang, "effects-found"),
        Verdict::PartlyExplained => say!(lang, "partly-explained"),
        Verdict::NothingMissing => say!(lang, "nothing-missing"),
        Verdict::Unexplained => say!(lang, "unexplained"),
        Verdict::NotDiagnosable => say!(lang, "not-diagnosable"),
    };
    let sentence = hanging(&format!("{label}{}{}", lang.colon(), words::verdict(report, lang).replace('`', "")), 2);
    if report.verdict == Verdict::NotDiagnosable {
        let help = words::would_help(report, lang);
        return if help.is_empty() { sentence } else { format!("{sentence}{}\n{help}", lang.semicolon().trim_end()) };
    }
    format!("{sentence}\n{}", hanging(&lang.in_parentheses(&words::tried(report, lang)), 2))
}

fn constraints(report: &DiagnoseReport, lang: Language) -> String {
    let lines = words::constraints(report, lang);
    let more = lines.len().saturating_sub(CONSTRAINTS);
    let mut text: String = lines.iter().take(CONSTRAINTS).map(|line| format!("{line}\n")).collect();
    if more > 0 {
        let more = more.to_string();
        text.push_str(&format!("{}\n", say!(lang, "and-more-constraints", more)));
    }
    text
}

fn found(report: &DiagnoseReport, effect: &EffectReport, lang: Language) -> String {
    let alone = report.effects.len() == 1;
    let sensor = match &effect.sensor {
        Some(sensor) if report.model_before.len() > 1 => format!(" {}", say!(lang, "table-sensor", sensor)),
        None if report.model_before.len() > 1 && effect.regressor.starts_with("tilt:") => {
            format!(" {}", say!(lang, "seen-by-all-sensors"))
        }
        _ => String::new(),
    };
    let mut text = format!("{}  {}{sensor}\n", effect.regressor, lang.name(&effect.name));
    if let Some((value, u, expanded, unit)) = words::value(effect) {
        text.push_str(format!("  {}{}{value} {unit}", words::of(effect, lang), words::equals(effect)).trim_end());
        if let (Some(u), Some(expanded)) = (u, expanded) {
            text.push_str(&format!(", u = {u}, U = {expanded} ({})", percent(effect.level)));
        }
        text.push('\n');
    } else {
        text.push_str(&format!("  {}\n", say!(lang, "the-repaired-model-does-not-determine-its")));
    }
    for own in &effect.in_sensors {
        let u = own.u.map_or(String::new(), |u| format!(", u = {}", rounded(u, Some(u))));
        let value = own.value.map_or(say!(lang, "not-determined").into(), |v| rounded(v, own.u));
        text.push_str(&format!(
            "  in {}: {} = {value} {}{u}, t = {:.1}\n",
            own.sensor, own.coefficient, own.unit, own.t
        ));
    }
    let stated = words::against_stated(effect, lang);
    if !stated.is_empty() {
        text.push_str(&(hanging(&format!("  {stated}"), 4) + "\n"));
    }
    let share = format!("{:.1}", 100.0 * effect.explains);
    let explains = match alone {
        true => say!(lang, "explains-of-the-gap", share),
        false => say!(lang, "explains-of-the-gap-beyond-the-others", share),
    };
    text.push_str(&format!("  t = {:.1}, {}{}{explains}\n", effect.t, words::p_is(effect.p), lang.semicolon()));
    text.push_str(&format!("  {}\n", say!(lang, "table-probability", effect = words::probability(effect, lang))));
    let aliases = words::aliases(effect, lang);
    for (what, names) in [
        (say!(lang, "this-schedule-cannot-tell-it-from"), &aliases.same),
        (say!(lang, "nor-fitting-not-significantly-worse-by-so"), &aliases.near),
        (say!(lang, "nor-but-only-through-small-terms-from"), &aliases.small),
    ] {
        if !names.is_empty() {
            text.push_str(
                &(hanging(&format!("  {what}{}{}", lang.colon(), listed(names, 2 * LISTED, lang)), 4) + "\n"),
            );
        }
    }
    for line in words::separation(effect, lang) {
        text.push_str(&(hanging(&format!("  {line}"), 4) + "\n"));
    }
    for (what, words) in [(say!(lang, "why"), &effect.why), (say!(lang, "confirm"), &effect.confirm)] {
        if !words.is_empty() {
            text.push_str(&(hanging(&format!("  {what}{}{}", lang.colon(), lang.name(words)), 4) + "\n"));
        }
    }
    text.push('\n');
    text
}

fn listed(names: &[String], most: usize, lang: Language) -> String {
    let more = names.len().saturating_sub(most);
    let shown = names.iter().take(most).cloned().collect::<Vec<_>>().join(", ");
    let more = more.to_string();
    if names.len() > most { say!(lang, "and-more", shown, more) } else { shown }
}

fn percent(level: f64) -> String {
    format!("{} %", words::trimmed(100.0 * level))
}

/// The lines that became longer, the appended terms underlined, and what else the repair changes.
fn repaired(report: &DiagnoseReport, lang: Language) -> String {
    let mut text = String::new();
    for (sensor, after) in &report.model_after {
        let Some(before) = report.model_before.get(sensor) else { continue };
        if let Some((kept, added)) = words::appended(before, after) {
            let head = say!(lang, "table-repaired", sensor, kept);
            let (start, size) = (head.chars().count(), added.chars().count());
            text.push_str(&format!("{head}{added}\n"));
            text.push_str(&match start + size <= WIDTH {
                true => format!("{}{}\n", " ".repeat(start), "^".repeat(size)),
                // a line that wraps has no place below it
                false => format!("  {}\n", say!(lang, "table-added", trim_start = added.trim_start())),
            });
        }
    }
    for line in report.effects.iter().filter_map(|effect| words::repair(effect, lang)) {
        text.push_str(&format!("{}\n", say!(lang, "table-repaired-2", line)));
    }
    let existing = |e: &&EffectReport| {
        !e.regressor.contains(':') && report.model_before == report.model_after && !e.coefficient.is_empty()
    };
    for effect in report.effects.iter().filter(existing) {
        text.push_str(&format!(
            "{}\n",
            say!(lang, "table-repaired-2", line = say!(lang, "is-estimated-no-longer-zero", id = effect.coefficient))
        ));
    }
    if !text.is_empty() {
        text.push('\n');
    }
    text
}

fn gap(report: &DiagnoseReport, lang: Language) -> String {
    let found = !report.effects.is_empty();
    let several = report.gap.sensors.len() > 1;
    let optional = |v: Option<f64>| v.map_or("-".into(), |v| significant(v, 4));
    let row = |name: &str, gap: &GapReport| {
        let mut cells = vec![name.to_string()];
        if !several {
            cells.extend([optional(gap.rms), significant(gap.max, 4)]);
        }
        cells.extend([significant(gap.chi_square, 4), gap.dof.to_string()]);
        cells.push(gap.p.map_or("-".into(), words::p));
        cells
    };
    let mut rows = vec![row(say!(lang, "before-repair"), &report.gap.before)];
    if found {
        rows.push(row(say!(lang, "after-repair"), &report.gap.after));
    }
    let header: &[&str] = if several {
        &[say!(lang, "gap"), say!(lang, "chi-square"), say!(lang, "dof"), "p"]
    } else {
        &[
            say!(lang, "gap"),
            say!(lang, "residual-sd"),
            say!(lang, "max"),
            say!(lang, "chi-square"),
            say!(lang, "dof"),
            "p",
        ]
    };
    let mut text = plain(header, &rows);
    if several {
        let rows: Vec<Vec<String>> = report
            .gap
            .sensors
            .iter()
            .map(|(id, own)| {
                let mut cells = vec![id.clone(), own.unit.clone(), own.sd.map_or("-".into(), |sd| significant(sd, 3))];
                cells.extend([optional(own.rms_before), significant(own.max_before, 4)]);
                if found {
                    cells.extend([optional(own.rms_after), significant(own.max_after, 4)]);
                }
                cells
            })
            .collect();
        let header = [
            say!(lang, "sensor"),
            say!(lang, "unit"),
            say!(lang, "noise"),
            say!(lang, "sd-before"),
            say!(lang, "max-before"),
            say!(lang, "sd-after"),
            say!(lang, "max-after"),
        ];
        text.push_str(&format!("\n{}", plain(header.part(..if found { 7 } else { 5 }), &rows)));
    }
    let source = words::noise_source(report.gap.noise.from, lang);
    let noise = match report.gap.sensors.values().next() {
        Some(one) if !several => match one.sd {
            Some(sd) => say!(lang, "noise-floor", sd = significant(sd, 3), unit = one.unit, source),
            None => say!(lang, "noise-floor-unknown").into(),
        },
        _ => say!(lang, "noise-floor-2", source),
    };
    text.push_str(&format!("{}\n", hanging(&noise.replace(" ,", ","), 2)));
    text
}

/// The gap after each effect, with the model line growing.
fn steps(report: &DiagnoseReport, lang: Language) -> String {
    let rows: Vec<Vec<String>> = report
        .steps
        .iter()
        .map(|step| {
            let with = match step.with.last() {
                None => say!(lang, "as-given").to_string(),
                Some(last) => format!("+ {last}"),
            };
            let mut cells = vec![with];
            if report.gap.sensors.len() < 2 {
                cells.push(step.gap.rms.map_or("-".into(), |v| significant(v, 4)));
            }
            cells.extend([significant(step.gap.chi_square, 4), step.gap.dof.to_string()]);
            cells.push(step.strongest.clone().unwrap_or("-".into()));
            cells.push(step.t.map_or("-".into(), |t| format!("{t:.1}")));
            cells.push(step.p.map_or("-".into(), words::p));
            cells
        })
        .collect();
    let mut header = vec![
        say!(lang, "the-gap-shrinks"),
        say!(lang, "residual-sd"),
        say!(lang, "chi-square"),
        say!(lang, "dof"),
        say!(lang, "strongest-further"),
        "t",
        "p",
    ];
    if report.gap.sensors.len() > 1 {
        header.remove(1);
    }
    let last = report.steps.last().map_or(String::new(), |step| hanging(&lang.name(&step.decision), 2) + "\n");
    format!("\n{}{last}", plain(&header, &rows))
}

fn unexplained(report: &DiagnoseReport, lang: Language) -> String {
    let Some(own) = &report.unexplained else { return String::new() };
    let mut text =
        format!("\n{}\n{}\n", hanging(&lang.name(&own.pattern), 2), hanging(&words::remainder(report, lang), 2));
    if !own.nearest.is_empty() {
        text.push_str(&format!(
            "{}\n",
            say!(
                lang,
                "nearest-of-the-catalogue-would-take-off",
                nearest = own.nearest.join(" + "),
                share = format!("{:.1}", 100.0 * own.nearest_explains)
            )
        ));
    }
    let rows: Vec<Vec<String>> = own
        .cells
        .iter()
        .take(2 * LISTED)
        .map(|cell| {
            let size = [significant(cell.mean, 3), format!("{:.1}", cell.z)];
            let who = [words::position(&cell.at), cell.sensor.clone(), cell.readings.to_string()];
            who.into_iter().chain(size).collect()
        })
        .collect();
    text.push_str(&format!(
        "\n{}",
        plain(
            &[
                say!(lang, "gap-at"),
                say!(lang, "sensor"),
                say!(lang, "readings-2"),
                say!(lang, "mean-gap"),
                say!(lang, "in-sd")
            ],
            &rows
        )
    ));
    text
}

fn places(report: &DiagnoseReport, lang: Language) -> String {
    let rows: Vec<Vec<String>> = report
        .places
        .iter()
        .filter(|place| place.significant == Some(true))
        .take(LISTED)
        .map(|place| {
            vec![
                lang.name(&place.factor).into_owned(),
                words::level(&place.level),
                place.sensor.clone(),
                place.readings.to_string(),
                significant(place.mean, 3),
                words::p(place.p),
            ]
        })
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    format!(
        "\n{}",
        plain(
            &[
                say!(lang, "where-the-gap-was"),
                say!(lang, "level"),
                say!(lang, "sensor"),
                say!(lang, "readings-2"),
                say!(lang, "mean-gap"),
                say!(lang, "p-alone")
            ],
            &rows
        )
    )
}

fn changes(report: &DiagnoseReport, lang: Language) -> String {
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
                words::shift(p.shift, p.u_after_as_named),
                words::in_u(p.change_in_u),
                p.unit.clone(),
            ]
        })
        .collect();
    let header = [
        say!(lang, "what-it-does-to"),
        say!(lang, "before-repair"),
        "u",
        say!(lang, "after-repair"),
        "u",
        say!(lang, "repair-shift"),
        say!(lang, "shift-u"),
        say!(lang, "unit"),
    ];
    let note = words::after_u(report, lang);
    let note = if note.is_empty() { String::new() } else { hanging(note, 2) + "\n" };
    format!("\n{}{note}", plain(&header, &rows))
}
