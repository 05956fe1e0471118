//! The advice for a person at the table.

use crate::campaign::{Campaign, Reading};
use crate::document::number::{rounded, trimmed};
use crate::guide::{Advice, Agreement, Ending, Explanation, Held, Holding, Mistake, Newest, Next, Progress, Why};
use crate::language::{Language, say};
use crate::report::ARCSEC;

/// Explanations that are listed.
const LISTED: usize = 8;

/// A setting as the advice writes it.
pub(super) fn setting(campaign: &Campaign, reading: &Reading) -> String {
    crate::guide::setting(campaign, &reading.joints)
}

/// Everything that is said after a step, line by line.
pub(super) fn text(advice: &Advice, lang: Language) -> String {
    let mut lines: Vec<String> = Vec::new();
    lines.extend(advice.newest.iter().flat_map(|own| newest(own, lang)));
    lines.extend(advice.mistake.iter().flat_map(|own| mistake(own, lang)));
    lines.extend(advice.goals.iter().map(|own| goal(own, lang)));
    if let Some(own) = &advice.diagnosis {
        let verdict = lang.term(own.verdict.name());
        lines.push(say!(lang, "guide-diagnosis", verdict));
        lines.extend(own.effects.iter().map(|effect| {
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
    lines.extend(advice.next.iter().map(|own| next(own, lang)));
    lines.extend(advice.ended.map(|own| ending(own, advice, lang)));
    lines.iter().map(|line| format!("{line}\n")).collect()
}

pub(super) fn ending(own: Ending, advice: &Advice, lang: Language) -> String {
    let (readings, cost) = (advice.readings.to_string(), advice.cost.to_string());
    match own {
        Ending::Reached => say!(lang, "guide-reached", readings, cost),
        Ending::NothingToGain => say!(lang, "guide-nothing-to-gain", readings, cost),
        Ending::MostReadings => say!(lang, "guide-most-readings", readings, cost),
    }
}

/// What is said while a position is held.
pub(super) fn held(own: &Held, lang: Language) -> String {
    let place = position(&own.position, &own.setting, lang);
    let seconds = format!("{:.1}", own.held_s);
    let mean = |own: &crate::guide::HeldMean| {
        let (u, wanted) = (rounded(own.u, Some(own.u)), trimmed(own.wanted));
        say!(lang, "guide-held-mean", sensor = own.sensor, u, wanted, unit = own.unit).to_string()
    };
    let means = own.means.iter().map(mean).collect::<String>();
    let line = match (own.state, own.wait_s) {
        (Holding::Moving, _) => say!(lang, "guide-moving").to_string(),
        (Holding::Held, Some(wait)) => {
            say!(lang, "guide-held-wait", place, seconds, means, wait = format!("{wait:.1}")).to_string()
        }
        (Holding::Held, None) if own.means.is_empty() => say!(lang, "guide-held", place, seconds).to_string(),
        (Holding::Held, None) => say!(lang, "guide-held-never", place, seconds, means).to_string(),
        (Holding::Read, _) => say!(lang, "guide-read", place).to_string(),
        (Holding::Left, _) => say!(lang, "guide-left", place, seconds, means).to_string(),
        (Holding::Which, _) => say!(lang, "guide-which", candidates = own.candidates.join("\n  ")).to_string(),
    };
    line + "\n"
}

fn position(label: &str, setting: &str, lang: Language) -> String {
    match label {
        "" => setting.to_string(),
        label => say!(lang, "guide-position", label, setting),
    }
}

pub(super) fn newest(own: &Newest, lang: Language) -> Vec<String> {
    let (reading, sd) = (own.reading.to_string(), format!("{:.1}", tenths(own.deviation.unwrap_or(0.0))));
    let place = position(&own.position, &own.setting, lang);
    let said = match own.agreement {
        Agreement::NotPredicted => say!(lang, "guide-not-predicted", reading, place),
        Agreement::Agrees => say!(lang, "guide-agrees", reading, place, sd),
        Agreement::Disagrees => say!(lang, "guide-disagrees", reading, place, sd),
    };
    [said].into_iter().chain(own.remarks.iter().map(|remark| format!("  {}", remark.say(lang)))).collect()
}

/// To tenths, without a zero that is negative.
fn tenths(value: f64) -> f64 {
    (10.0 * value).round() / 10.0 + 0.0
}

pub(super) fn mistake(own: &Mistake, lang: Language) -> Vec<String> {
    let first = match (own.named, own.at) {
        (Some(named), at) => {
            let at = at.map_or(String::new(), |at| format!("{}{} {at}", lang.clause(), say!(lang, "reading")));
            say!(lang, "guide-likely", kind = format!("{}{at}", lang.term(named.name())))
        }
        _ => say!(lang, "guide-not-told").to_string(),
    };
    // what is to be done about it
    let undo = match own.culprit() {
        Some((reading, probability)) => {
            say!(lang, "guide-undo", reading = reading.to_string(), probability = format!("{probability:.3}"))
        }
        None => say!(lang, "guide-undo-any").to_string(),
    };
    let one = |own: &Explanation| {
        let what = lang.name(&own.what).to_string();
        let (probability, reading) = (format!("{:.3}", own.probability), own.reading.to_string());
        say!(lang, "guide-explanation", probability, kind = lang.term(own.kind.name()), reading, what)
    };
    let more = own.explanations.len().saturating_sub(LISTED);
    let more = (more > 0).then(|| format!("    ... + {more}"));
    [first, undo].into_iter().chain(own.explanations.iter().take(LISTED).map(one)).chain(more).collect()
}

/// The factor to the unit in which a value is shown, and that.
pub(super) fn shown_in(unit: &str) -> (f64, &str) {
    if unit == "rad" { (ARCSEC, "arcsec") } else { (1.0, unit) }
}

pub(super) fn goal(own: &Progress, lang: Language) -> String {
    let (scale, unit) = shown_in(&own.unit);
    let (id, goal) = (&own.id, trimmed(own.goal * scale));
    match own.value.zip(own.u) {
        None => say!(lang, "guide-goal-open", id, goal, unit),
        Some((value, u)) => {
            let (value, u) = (value * scale, u * scale);
            let (value, u) = (rounded(value, Some(u)), rounded(u, Some(u)));
            say!(lang, "guide-goal", id, value, u, goal, unit, met = own.met)
        }
    }
}

pub(super) fn next(own: &Next, lang: Language) -> String {
    let place = position(&own.position, &own.setting, lang);
    match (own.why, own.information) {
        (Why::Information, Some(nats)) => {
            say!(lang, "guide-next", place, nats = format!("{nats:.2}"), cost = own.cost.to_string())
        }
        (Why::Discriminates, _) => say!(lang, "guide-next-apart", place, between = own.between.join(" | ")),
        _ => say!(lang, "guide-next-again", place),
    }
}
