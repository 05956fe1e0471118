//! The advice for a person at the table.

use crate::document::number::{rounded, trimmed};
use crate::guide::{Advice, Ending, Explanation, Held, Holding, Mistake, Newest, Next, Progress};
use crate::language::{Language, say};
use crate::report::ARCSEC;

/// Explanations that are listed.
const LISTED: usize = 8;

/// Everything that is said after a step, line by line.
pub(super) fn text(advice: &Advice, lang: Language) -> String {
    let mut lines: Vec<String> = Vec::new();
    lines.extend(advice.newest.iter().flat_map(|n| newest(n, lang)));
    lines.extend(advice.mistake.iter().flat_map(|m| mistake(m, lang)));
    lines.extend(advice.goals.iter().map(|progress| goal(progress, lang)));
    if let Some(diagnosis) = &advice.diagnosis {
        let verdict = lang.term(diagnosis.verdict.name());
        lines.push(say!(lang, "guide-diagnosis", verdict));
        lines.extend(diagnosis.effects.iter().map(|effect| {
            let size = effect.value.zip(effect.u).map_or(String::new(), |(value, u)| {
                let (value, u, comma) = (rounded(value, Some(u)), rounded(u, Some(u)), lang.clause());
                format!("{comma}{value} {}{comma}u = {u}", effect.unit)
            });
            let terms: Vec<&str> = [&effect.regressor].into_iter().chain(&effect.aliases).map(String::as_str).collect();
            let (name, probability) = (lang.name(&effect.name).to_string(), format!("{:.3}", effect.probability));
            say!(lang, "guide-effect", name, terms = terms.join(" | "), size, probability)
        }));
    }
    if advice.readings > 0 {
        let probability = format!("{:.3}", advice.nothing_missing_or_named);
        lines.push(say!(lang, "guide-nothing-missing", probability, unseen = advice.unseen_effects.to_string()));
    }
    lines.extend(advice.unreachable.iter().map(|id| say!(lang, "guide-unreachable", id)));
    lines.extend(advice.next.iter().map(|step| next(step, lang)));
    lines.extend(advice.ended.map(|by| ending(by, advice, lang)));
    lines.iter().map(|line| format!("{line}\n")).collect()
}

pub(super) fn ending(ending: Ending, advice: &Advice, lang: Language) -> String {
    let (readings, cost) = (advice.readings.to_string(), advice.cost.to_string());
    say!(lang, "guide-ended", by = ending.name(), readings, cost)
}

/// What is said while a position is held.
pub(super) fn held(held: &Held, lang: Language) -> String {
    let place = position(&held.position, &held.setting, lang);
    let seconds = format!("{:.1}", held.held_s);
    let mean = |mean: &crate::guide::HeldMean| {
        let (u, wanted) = (rounded(mean.u, Some(mean.u)), trimmed(mean.wanted));
        say!(lang, "guide-held-mean", sensor = mean.sensor, u, wanted, unit = mean.unit).to_string()
    };
    let means = held.means.iter().map(mean).collect::<String>();
    let line = match (held.state, held.wait_s) {
        (Holding::Moving, _) => say!(lang, "guide-moving").to_string(),
        (Holding::Held, Some(wait)) => {
            say!(lang, "guide-held-wait", place, seconds, means, wait = format!("{wait:.1}")).to_string()
        }
        (Holding::Held, None) if held.means.is_empty() => say!(lang, "guide-held", place, seconds).to_string(),
        (Holding::Held, None) => say!(lang, "guide-held-never", place, seconds, means).to_string(),
        (Holding::Read, _) => say!(lang, "guide-read", place).to_string(),
        (Holding::Left, _) => say!(lang, "guide-left", place, seconds, means).to_string(),
        (Holding::Which, _) => say!(lang, "guide-which", candidates = held.candidates.join("\n  ")).to_string(),
    };
    line + "\n"
}

fn position(label: &str, setting: &str, lang: Language) -> String {
    match label {
        "" => setting.to_string(),
        label => say!(lang, "guide-position", label, setting),
    }
}

pub(super) fn newest(newest: &Newest, lang: Language) -> Vec<String> {
    let (reading, sd) = (newest.reading.to_string(), format!("{:.1}", tenths(newest.deviation.unwrap_or(0.0))));
    let place = position(&newest.position, &newest.setting, lang);
    let said = say!(lang, "guide-newest", agreement = newest.agreement.name(), reading, place, sd);
    [said].into_iter().chain(newest.remarks.iter().map(|remark| format!("  {}", remark.say(lang)))).collect()
}

/// To tenths, without a zero that is negative.
fn tenths(value: f64) -> f64 {
    (10.0 * value).round() / 10.0 + 0.0
}

pub(super) fn mistake(mistake: &Mistake, lang: Language) -> Vec<String> {
    let first = match (mistake.named, mistake.at) {
        (Some(named), at) => {
            let at = at.map_or(String::new(), |at| format!("{}{} {at}", lang.clause(), say!(lang, "reading")));
            say!(lang, "guide-likely", kind = format!("{}{at}", lang.term(named.name())))
        }
        _ => say!(lang, "guide-not-told").to_string(),
    };
    // what is to be done about it
    let wrong = mistake.culprit().map(|(reading, probability)| (reading.to_string(), format!("{probability:.3}")));
    let (culprit, (reading, probability)) = (wrong.is_some(), wrong.unwrap_or_default());
    let undo = say!(lang, "guide-undo", culprit, reading, probability);
    let one = |explanation: &Explanation| {
        let what = lang.name(&explanation.what).to_string();
        let (probability, reading) = (format!("{:.3}", explanation.probability), explanation.reading.to_string());
        say!(lang, "guide-explanation", probability, kind = lang.term(explanation.kind.name()), reading, what)
    };
    let more = mistake.explanations.len().saturating_sub(LISTED);
    let more = (more > 0).then(|| format!("    ... + {more}"));
    [first, undo].into_iter().chain(mistake.explanations.iter().take(LISTED).map(one)).chain(more).collect()
}

/// The factor to the unit in which a value is shown, and that.
pub(super) fn shown_in(unit: &str) -> (f64, &str) {
    if unit == "rad" { (ARCSEC, "arcsec") } else { (1.0, unit) }
}

pub(super) fn goal(progress: &Progress, lang: Language) -> String {
    let (scale, unit) = shown_in(&progress.unit);
    let (id, goal) = (&progress.id, trimmed(progress.goal * scale));
    match progress.value.zip(progress.u) {
        None => say!(lang, "guide-goal-open", id, goal, unit),
        Some((value, u)) => {
            let (value, u) = (value * scale, u * scale);
            let (value, u) = (rounded(value, Some(u)), rounded(u, Some(u)));
            say!(lang, "guide-goal", id, value, u, goal, unit, met = progress.met)
        }
    }
}

pub(super) fn next(next: &Next, lang: Language) -> String {
    let (place, why) = (position(&next.position, &next.setting, lang), next.why.name());
    let nats = next.information.map_or(String::new(), |nats| format!("{nats:.2}"));
    say!(lang, "guide-next", place, why, nats, cost = next.cost.to_string(), between = next.between.join(" | "))
}
