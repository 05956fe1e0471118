//! The better schedule of a plan in words: how it was found, how good it is, its positions and why each is there.

use super::{DiscriminationReport, FindReport, GoalReport, ImprovedReport, PlannedPositionReport};
use crate::document::number::significant;
use crate::elements::Parts;
use crate::language::{Language, say};

/// The positions of a schedule, one line for each mounting: its label, and its keys; the key that changes within it has several values.
pub(super) fn mountings(positions: &[PlannedPositionReport]) -> Vec<(String, String)> {
    let mut lines: Vec<(String, String)> = Vec::new();
    let mut rest = positions;
    while let Some(first) = rest.first() {
        // the longest run with this label in which only one key changes
        let mut changing: Option<&str> = None;
        let mut length = 1;
        for other in rest.part(1..) {
            let same_keys =
                other.at.keys().eq(first.at.keys()) && other.position == first.position && other.levels == first.levels;
            let different: Vec<&str> =
                first.at.iter().filter(|(k, v)| other.at.get(*k) != Some(v)).map(|(k, _)| k.as_str()).collect();
            match different.as_slice() {
                [] if same_keys => {}
                [one] if same_keys && changing.is_none_or(|own| own == *one) => changing = Some(one),
                _ => break,
            }
            length += 1;
        }
        let (run, left) = rest.split_at(length);
        let part = |(key, value): (&String, &f64)| match changing {
            Some(own) if own == key => {
                format!("{key} = {}", runs(run.iter().filter_map(|p| p.at.get(key))))
            }
            _ => format!("{key} = {value}"),
        };
        let mut parts: Vec<String> = first.at.iter().map(part).collect();
        if changing.is_none() && length > 1 {
            parts.push(format!("\u{d7} {length}"));
        }
        parts.extend(first.levels.iter().map(|(column, level)| format!("{column} = {level}")));
        lines.push((first.position.clone(), parts.join(", ")));
        rest = left;
    }
    lines
}

/// Values in order, four and more of one in a row as `40 × 4`.
fn runs<'a>(values: impl Iterator<Item = &'a f64>) -> String {
    let mut runs: Vec<(f64, usize)> = Vec::new();
    for value in values {
        match runs.last_mut() {
            Some((own, count)) if own == value => *count += 1,
            _ => runs.push((*value, 1)),
        }
    }
    let text = |(value, count): (f64, usize)| match count {
        1..=3 => vec![value.to_string(); count].join(", "),
        _ => format!("{value}\u{a0}\u{d7}\u{a0}{count}"),
    };
    runs.into_iter().map(text).collect::<Vec<_>>().join(", ")
}

/// How good the choice is proven to be.
pub(super) fn proof(improved: &ImprovedReport, lang: Language) -> Option<String> {
    if let Some(all) = improved.enumerated {
        return Some(say!(lang, "best-of-all-choices", all = all.to_string()));
    }
    Some(say!(lang, "proven-efficiency", share = percent(improved.efficiency?)))
}

/// What moving the angles between the candidates brought.
pub(super) fn moved(improved: &ImprovedReport, lang: Language) -> Option<String> {
    let refined = improved.refined.as_ref()?;
    let resolution = significant(refined.resolution_deg, 3);
    if refined.moved == 0 {
        return Some(say!(lang, "no-angle-is-worth-moving", resolution));
    }
    let (mountings, gain) = (refined.moved.to_string(), significant(100.0 * refined.gain, 2));
    Some(say!(lang, "angles-moved", finished = refined.finished, mountings, resolution, gain))
}

/// Why the efficiency is below 0.99: the bound, or the few portions.
pub(super) fn shortfall(improved: &ImprovedReport, lang: Language) -> Option<String> {
    let (efficiency, gap) = (improved.efficiency?, improved.bound_gap?);
    let short = 1.0 - efficiency;
    (short > 0.01).then(|| match gap < 0.1 * short {
        true if improved.cost_limit.is_some() => say!(lang, "the-bound-allows-more-mountings-than-the").into(),
        true => say!(lang, "so-few-portions-cannot-follow-the-best").into(),
        false => say!(lang, "the-bound-itself-may-be-too-high", gap = significant(gap, 2)),
    })
}

/// The limit of the cost, and where it comes from.
pub(super) fn cost_limit(improved: &ImprovedReport, limit: f64, lang: Language) -> String {
    let cost = significant(limit, 4);
    match improved.budget {
        Some(_) => say!(lang, "within-a-budget-of-for-what-was", cost),
        None => say!(lang, "at-no-more-cost-than-the-given", cost),
    }
}

/// Why a mounting is there, in words.
pub(super) fn reason(improved: &ImprovedReport, label: &str, lang: Language) -> Option<String> {
    let reason = improved.reasons.iter().find(|r| r.position == label)?;
    Some(match reason.grows {
        None => say!(lang, "without-it-nothing-determines", parameter = reason.parameter),
        Some(grows) => {
            let share = significant(100.0 * (grows - 1.0).max(0.0), 2);
            say!(lang, "without-it-u-of-grows-by", parameter = reason.parameter, share)
        }
    })
}

/// How well two effects are told apart, before and after.
pub(super) fn apart(separation: &DiscriminationReport, lang: Language) -> Vec<String> {
    let [a, b] = &separation.effects;
    let known = |u: &[Option<f64>; 2]| match u {
        [Some(p), Some(q)] => say!(lang, "u-of-their-coefficients-and", p = significant(*p, 3), q = significant(*q, 3)),
        _ => lang.term("not-estimable"),
    };
    let mut lines = vec![say!(lang, "and-both-in-the-model-before", a, b, before = known(&separation.before))];
    lines.push(match separation.after {
        [Some(_), Some(_)] => say!(lang, "with-the-added-positions", after = known(&separation.after)),
        _ => say!(lang, "no-candidate-discriminates", a, b),
    });
    lines
}

/// A share that something has at least: cut, not rounded up.
fn percent(share: f64) -> String {
    format!("{:.2} %", (share * 1e4 + 1e-2).floor() / 100.0)
}

/// What an effect that is to be found asks of the schedule.
pub(super) fn found_with(find: &FindReport, lang: Language) -> String {
    say!(
        lang,
        "of-is-found-with-probability-where-the",
        effect = find.effect,
        size = significant(find.size, 3),
        power = find.power.to_string(),
        coefficient = find.coefficient,
        u = significant(find.u, 3)
    )
}

/// What a goal counts, and what is known of its cost.
pub(super) fn goal_notes(improved: &ImprovedReport, goal: &GoalReport, lang: Language) -> Vec<String> {
    let counted = goal.limits.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
    let derived = improved.judgement.derived.iter().map(|d| d.id.as_str());
    let derived: Vec<&str> = derived.filter(|id| !goal.limits.contains_key(*id)).collect();
    let some = !derived.is_empty();
    let mut notes = vec![say!(lang, "the-goal-counts", counted, some, derived = derived.join(", "))];
    if goal.is_cheapest_found && goal.reached {
        notes.push(say!(lang, "this-is-the-cheapest-schedule-that-was").into());
    }
    notes
}

/// Two effects that no candidate tells apart: there is no better schedule to show.
pub(super) fn not_told_apart(improved: &ImprovedReport, lang: Language) -> Option<String> {
    let separation = improved.separation.as_ref()?;
    let [a, b] = &separation.effects;
    let none = separation.after.iter().any(Option::is_none);
    none.then(|| say!(lang, "no-candidate-discriminates", a, b))
}
