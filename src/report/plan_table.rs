//! A plan as a person at a terminal reads it.

use super::foresight_table::foresight_table;
use super::table::{plain, significant};
use super::wrap::hanging;
use super::{
    DiscriminationReport, Effort, FindReport, GoalReport, ImprovedReport, JudgementReport, LackingReport,
    NotEstimableReport, PlanReport, PlannedPositionReport, PointReport, PositionReport, ThroughTiltsReport, WorkReport,
};
use crate::language::{Language, say};
use crate::plan::PointSource;
use std::collections::BTreeMap;

fn number(value: Option<f64>) -> String {
    value.map_or("-".into(), |v| significant(v, 3))
}

/// A plan report as text; `with_readings` lists every value with its leverage and minimal detectable bias.
pub fn plan_table(report: &PlanReport, with_readings: bool, lang: Language) -> String {
    let mut text = format!("{}\n", say!(lang, "tumble-plan-on", tumble = report.tumble, bench = report.bench));
    for (sensor, line) in &report.model {
        text.push_str(&format!("  {sensor} = {line}\n"));
    }
    for (sensor, noise) in &report.noise {
        let sd = significant(noise.sd, 4);
        let from = lang.term("sd-from", &noise.from.to_string());
        text.push_str(&format!("  {}\n", say!(lang, "noise-of", sensor, sd, unit = noise.unit, from)));
    }
    for (id, sd) in &report.remount {
        text.push_str(&format!(
            "  {}\n",
            say!(lang, "every-remounting-scatters-sd-rad-for-a", id, sd = significant(*sd, 3))
        ));
    }
    let at = say!(lang, "judged-at", point = judged_at(&report.judged_at, lang));
    text.push_str(&format!("{}\n", hanging(&format!("  {at}"), 4)));
    text.push_str(&format!("\n{}\n\n", say!(lang, "the-schedule", work = work(&report.schedule, lang))));
    text.push_str(&judgement(&report.schedule, lang));
    if with_readings {
        text.push_str(&readings(&report.schedule, lang));
    }
    if let (Some(effects), None) = (&report.schedule.effects, &report.improved) {
        text.push_str(&foresight_table(effects, lang));
    }
    if let Some(improved) = &report.improved {
        text.push_str(&better(improved, &report.finds, lang));
        let effects = improved.judgement.effects.as_ref().filter(|_| not_told_apart(improved, lang).is_none());
        if let Some(effects) = effects {
            text.push_str(&foresight_table(effects, lang));
        }
        if with_readings && not_told_apart(improved, lang).is_none() {
            text.push_str(&readings(&improved.judgement, lang));
        }
    }
    text
}

/// The point at which schedules are judged, in words: values with their source, then what stands at zero.
pub(super) fn judged_at(point: &[PointReport], lang: Language) -> String {
    let mut parts: Vec<String> = Vec::new();
    let mut zero: Vec<&str> = Vec::new();
    for value in point {
        let (number, unit) = match value.arcsec {
            Some(arcsec) => (arcsec, "arcsec"),
            None => (value.value, value.unit.as_str()),
        };
        match value.from {
            PointSource::Zero => zero.push(&value.id),
            from => {
                let from = lang.term("point-from", &from.to_string());
                parts.push(format!("{} = {} {unit} ({from})", value.id, significant(number, 4)).replace("  ", " "));
            }
        }
    }
    match (zero.len(), parts.is_empty()) {
        (0, _) => {}
        (_, true) => parts.push(say!(lang, "zero-no-parameter-has-a-start-prior").into()),
        (1..=6, _) => parts.push(format!("{} = 0", zero.join(", "))),
        (count, _) => parts.push(say!(lang, "plan-table-others", count = count.to_string())),
    }
    parts.join(", ")
}

/// What needs a value, in one sentence.
pub(super) fn lacking(lacking: &LackingReport, lang: Language) -> String {
    let needs = lacking.needs.join(", ");
    let first = lacking.needs.first().map_or("", String::as_str);
    let untold = lacking.untold.join(", ");
    say!(lang, "uncertainty-depends-on-a-value", untold, needs, first)
}

fn work(judgement: &JudgementReport, lang: Language) -> String {
    work_of(&judgement.work, lang)
}

pub(super) fn work_of(w: &WorkReport, lang: Language) -> String {
    say!(
        lang,
        "in-with-cost",
        readings = lang.count(w.readings, "reading"),
        mountings = lang.count(w.mountings, "mounting"),
        rate_changes = lang.count(w.rate_changes, "rate-change"),
        cost = significant(w.cost, 4)
    )
}

fn judgement(j: &JudgementReport, lang: Language) -> String {
    let mut rows = Vec::new();
    // the strongest partner says more than a matrix; the matrix is in the JSON
    let strongest = |i: usize| {
        let row = j.correlation.matrix.get(i)?;
        let others = row.iter().enumerate().filter(|(k, _)| *k != i).filter_map(|(k, r)| r.map(|r| (k, r)));
        let (k, r) = others.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        let partner = j.correlation.order.get(k)?;
        (r.abs() >= 0.005).then(|| say!(lang, "correlation-with", r = format!("{r:+.2}"), partner))
    };
    let needs_value = |id: &String| j.lacking.as_ref().is_some_and(|l| l.untold.contains(id));
    for (i, p) in j.parameters.iter().enumerate() {
        let angle = p.u_arcsec.is_some();
        rows.push(vec![
            p.id.clone(),
            if needs_value(&p.id) {
                say!(lang, "needs-a-value").into()
            } else if p.u.is_none() {
                say!(lang, "not-estimable").into()
            } else {
                number(if angle { p.u_arcsec } else { p.u })
            },
            if angle { "arcsec".into() } else { p.unit.clone() },
            strongest(i).unwrap_or_default(),
            if p.u.is_some() { number(p.undetected_fault_arcsec.or(p.undetected_fault)) } else { "-".into() },
        ]);
    }
    for d in &j.derived {
        let note = if d.is_largest { say!(lang, "largest-near-the-reference") } else { "" };
        let unit = if d.u_arcsec.is_some() { "arcsec" } else { "" };
        rows.push(vec![d.id.clone(), number(d.u_arcsec.or(d.u)), unit.into(), note.into(), "".into()]);
    }
    let mut text = plain(
        &[
            say!(lang, "parameter"),
            say!(lang, "predicted-u"),
            say!(lang, "unit"),
            say!(lang, "strongest-correlation"),
            say!(lang, "undetected-fault"),
        ],
        &rows,
    );
    let mut rank = say!(lang, "plan-table-rank", rank = j.rank.to_string(), dof = lang.count(j.dof, "degree"));
    if let Some(condition) = j.condition {
        rank.push_str(&say!(lang, "fit-table-condition", condition = significant(condition, 3)));
    }
    if j.unchecked > 0 {
        rank.push_str(lang.semicolon());
        rank.push_str(&say!(lang, "values-checked-by-no-other", n = j.unchecked));
    }
    text.push_str(&format!("\n{}\n", hanging(&rank, 2)));
    text.push_str(&drift(j, lang));
    if let Some(through) = &j.through_tilts {
        text.push_str(&format!("{}\n", hanging(&through_tilts(through, lang), 2)));
    }
    if j.effects.is_none() && j.work.readings > 0 {
        let line = say!(lang, "so-many-values-what-a-diagnosis-could");
        text.push_str(&format!("{}\n", hanging(line, 2)));
    }
    if let Some(own) = &j.lacking {
        text.push_str(&format!("{}\n", hanging(&lacking(own, lang), 2)));
    }
    if j.bounds_not_counted > 0 {
        text.push_str(&format!("{}\n", say!(lang, "bounds-not-counted", n = j.bounds_not_counted)));
    }
    let defect = |text: &str| say!(lang, "is-not-estimable", text);
    text.push_str(&defects(&j.not_estimable, defect, &nowhere(&BTreeMap::new(), lang), lang));
    text
}

/// What a drift over the run does.
fn drift(j: &JudgementReport, lang: Language) -> String {
    j.drift.map_or(String::new(), |drift| {
        let line = say!(lang, "a-drift-of-one-standard-deviation-over", drift = significant(drift, 2));
        format!("{}\n", hanging(&line, 2))
    })
}

/// What known inputs do through the tilts, in one sentence.
pub(super) fn through_tilts(through: &ThroughTiltsReport, lang: Language) -> String {
    let (u, unit) = match through.u_arcsec {
        Some(arcsec) => (arcsec, " arcsec"),
        None => (through.u, ""),
    };
    let ThroughTiltsReport { known, parameter, tilts_arcsec, .. } = through;
    let (u, tilts) = (significant(u, 2), significant(*tilts_arcsec, 3));
    match through.counted {
        true => say!(lang, "counted-above-with-tilts-of-arcsec-the", tilts, known, u, unit, parameter),
        false => say!(lang, "not-counted-the-uncertainty-of-acts-through", known, tilts, u, unit, parameter),
    }
}

/// The positions of a schedule, one line for each mounting: its label, and its keys; the key that changes within it has several values.
pub(super) fn mountings(positions: &[PlannedPositionReport], lang: Language) -> Vec<(String, String)> {
    let mut lines: Vec<(String, String)> = Vec::new();
    let mut rest = positions;
    while let Some(first) = rest.first() {
        // the longest run with this label in which only one key changes
        let mut changing: Option<&str> = None;
        let mut length = 1;
        for other in rest.get(1..).unwrap_or_default() {
            let same_keys = other.at.keys().eq(first.at.keys()) && other.position == first.position;
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
                format!("{key} = {}", runs(run.iter().filter_map(|p| p.at.get(key)), lang))
            }
            _ => format!("{key} = {value}"),
        };
        let mut parts: Vec<String> = first.at.iter().map(part).collect();
        if changing.is_none() && length > 1 {
            parts.push(say!(lang, "plan-table-times", length = length.to_string()));
        }
        lines.push((first.position.clone(), parts.join(", ")));
        rest = left;
    }
    lines
}

/// Values in order, four and more of one in a row as `40 (4 times)`.
fn runs<'a>(values: impl Iterator<Item = &'a f64>, lang: Language) -> String {
    let mut runs: Vec<(f64, usize)> = Vec::new();
    for value in values {
        match runs.last_mut() {
            Some((own, count)) if own == value => *count += 1,
            _ => runs.push((*value, 1)),
        }
    }
    let text = |(value, count): (f64, usize)| match count {
        1..=3 => vec![value.to_string(); count].join(", "),
        _ => say!(lang, "value-times", value = value.to_string(), count = count.to_string()).replace(' ', "\u{a0}"),
    };
    runs.into_iter().map(text).collect::<Vec<_>>().join(", ")
}

/// How good the choice is proven to be.
pub(super) fn proof(improved: &ImprovedReport, lang: Language) -> Option<String> {
    let limited = improved.cost_limit.is_some();
    if let Some(all) = improved.enumerated {
        let all = all.to_string();
        return Some(match limited {
            true => say!(lang, "the-best-all-choices-of-these-candidates", all),
            false => say!(lang, "the-best-all-choices-of-these-candidates-2", all),
        });
    }
    let share = percent(improved.efficiency?);
    Some(match limited {
        true => say!(lang, "proven-to-be-at-least-as-good", share),
        false => say!(lang, "proven-to-be-at-least-as-good-2", share),
    })
}

/// What moving the angles between the candidates brought.
pub(super) fn moved(improved: &ImprovedReport, lang: Language) -> Option<String> {
    let refined = improved.refined.as_ref()?;
    let resolution = significant(refined.resolution_deg, 3);
    if refined.moved == 0 {
        return Some(say!(lang, "no-angle-is-worth-moving", resolution));
    }
    let (mountings, gain) = (lang.count(refined.moved, "mounting"), significant(100.0 * refined.gain, 2));
    Some(match refined.finished {
        true => say!(lang, "angles-moved-off-the-candidates", mountings, resolution, gain),
        false => say!(lang, "angles-moved-as-far-as-the-effort-went", mountings, resolution, gain),
    })
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
        Some(grows) if grows > 1.0005 => {
            say!(
                lang,
                "without-it-u-of-grows-by",
                parameter = reason.parameter,
                share = significant(100.0 * (grows - 1.0), 2)
            )
        }
        Some(_) => say!(lang, "it-adds-little").into(),
    })
}

/// How well two effects are told apart, before and after.
pub(super) fn apart(separation: &DiscriminationReport, lang: Language) -> Vec<String> {
    let [a, b] = &separation.effects;
    let known = |u: &[Option<f64>; 2]| match u {
        [Some(p), Some(q)] => say!(lang, "u-of-their-coefficients-and", p = significant(*p, 3), q = significant(*q, 3)),
        _ => say!(lang, "nothing-tells-them-apart").into(),
    };
    let mut lines = vec![say!(lang, "and-both-in-the-model-before", a, b, before = known(&separation.before))];
    lines.push(match separation.after {
        [Some(_), Some(_)] => say!(lang, "with-the-added-positions", after = known(&separation.after)),
        _ => say!(lang, "no-candidate-tells-them-apart-so-nothing").into(),
    });
    lines
}

/// Why no position separates what is not estimable: none of the bench does, or the candidates hold a column at one value.
pub(super) fn nowhere(frozen: &BTreeMap<String, f64>, lang: Language) -> String {
    let held: Vec<String> = frozen.iter().map(|(column, value)| format!("{column} = {value}")).collect();
    match held.is_empty() {
        true => say!(lang, "no-position-of-this-bench-would-separate-2").into(),
        false => say!(lang, "no-candidate-would-separate-it-but-all", held = held.join(", ")),
    }
}

/// A share that something has at least: cut, not rounded up.
pub(super) fn percent(share: f64) -> String {
    format!("{:.2} %", (share * 1e4 + 1e-2).floor() / 100.0)
}

/// What an effect that is to be found asks of the schedule.
fn found_with(find: &FindReport, lang: Language) -> String {
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
    let mut notes = vec![match derived.is_empty() {
        true => say!(lang, "the-goal-counts", counted),
        false => say!(lang, "the-goal-counts-but-not", counted, derived = derived.join(", ")),
    }];
    if goal.is_cheapest_found && goal.reached {
        notes.push(say!(lang, "this-is-the-cheapest-schedule-that-was").into());
    }
    notes
}

fn defects(list: &[NotEstimableReport], what: impl Fn(&str) -> String, nowhere: &str, lang: Language) -> String {
    let mut text = String::new();
    for defect in list {
        let mut clauses = vec![what(&defect.text)];
        let instead: Vec<&str> = defect.estimable.iter().map(|c| c.text.as_str()).collect();
        if !instead.is_empty() {
            clauses.push(say!(lang, "determined-instead-2", instead = instead.join(", ")));
        }
        clauses.push(match &defect.separate_by {
            Some(position) => say!(lang, "separated-by", position = keys(position)),
            None => nowhere.to_string(),
        });
        text.push_str(&format!("{}\n", hanging(&clauses.join(lang.semicolon()), 2)));
    }
    text
}

fn keys(position: &PositionReport) -> String {
    position.iter().map(|(key, value)| format!("{key} = {value}")).collect::<Vec<_>>().join(", ")
}

fn readings(j: &JudgementReport, lang: Language) -> String {
    let rows: Vec<Vec<String>> = j
        .readings
        .iter()
        .map(|r| {
            let worst = r.effect_arcsec.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
            vec![
                r.index.to_string(),
                r.position.clone(),
                keys(&r.at),
                r.sensor.clone(),
                format!("{:.3}", r.leverage),
                number(r.mdb),
                worst.map_or(String::new(), |(id, e)| say!(lang, "arcsec-of", e = significant(*e, 3), id)),
            ]
        })
        .collect();
    let header = [
        "#",
        say!(lang, "per-position"),
        say!(lang, "gap-at"),
        say!(lang, "sensor"),
        say!(lang, "leverage"),
        say!(lang, "mdb"),
        say!(lang, "its-largest-effect-on-an-angle"),
    ];
    format!("\n{}", plain(&header, &rows))
}

/// Two effects that no candidate tells apart: there is no better schedule to show.
pub(super) fn not_told_apart(improved: &ImprovedReport, lang: Language) -> Option<String> {
    let separation = improved.separation.as_ref()?;
    let [a, b] = &separation.effects;
    let none = separation.after.iter().any(Option::is_none);
    none.then(|| say!(lang, "no-candidate-tells-and-apart-so-nothing", a, b))
}

/// The given schedule with as many readings, or at the cost, of the better one.
pub(super) fn equal_effort(effort: Effort, lang: Language) -> &'static str {
    match effort {
        Effort::Readings => say!(lang, "u-at-equal-readings"),
        Effort::Cost => say!(lang, "u-at-equal-cost"),
    }
}

fn better(improved: &ImprovedReport, finds: &[FindReport], lang: Language) -> String {
    if let Some(nothing) = not_told_apart(improved, lang) {
        return format!("\n{nothing}\n");
    }
    let mut text = format!("\n{}\n", say!(lang, "the-better-schedule", work = work(&improved.judgement, lang)));
    if improved.to_run != improved.judgement.work {
        text.push_str(&format!("  {}\n", say!(lang, "still-to-run", work = work_of(&improved.to_run, lang))));
    }
    let starts = match improved.enumerated {
        Some(_) => String::new(),
        None => {
            let [hits, starts] = [improved.hits, improved.starts].map(|n| n.to_string());
            say!(lang, "seed-of-starts-ended-here", seed = improved.seed.to_string(), hits, starts)
        }
    };
    let chosen = say!(
        lang,
        "of-its-readings-chosen-among-candidate-portions",
        chosen = improved.chosen.to_string(),
        candidates = improved.candidates.to_string(),
        criterion = lang.term("criterion", &improved.criterion),
        starts
    );
    text.push_str(&format!("{}\n", hanging(&format!("  {chosen}"), 4)));
    if let Some(proof) = proof(improved, lang) {
        text.push_str(&format!("{}\n", hanging(&format!("  {proof}"), 4)));
        if let Some(why) = shortfall(improved, lang) {
            text.push_str(&format!("{}\n", hanging(&format!("  {why}"), 4)));
        }
    }
    if let Some(moved) = moved(improved, lang) {
        text.push_str(&format!("{}\n", hanging(&format!("  {moved}"), 4)));
    }
    if let Some(limit) = improved.cost_limit {
        text.push_str(&format!("{}\n", hanging(&format!("  {}", cost_limit(improved, limit, lang)), 4)));
    }
    if let Some(separation) = &improved.separation {
        for line in apart(separation, lang) {
            text.push_str(&format!("{}\n", hanging(&format!("  {line}"), 4)));
        }
    }
    for find in finds {
        text.push_str(&format!("{}\n", hanging(&format!("  {}", found_with(find, lang)), 4)));
    }
    if let Some(goal) = &improved.goal {
        let share = goal.largest_share.map_or(say!(lang, "unknown").into(), |s| significant(s, 3));
        let proof = if goal.is_fewest { say!(lang, "fewer-readings-cannot-reach-it") } else { "" };
        let reached = match goal.reached {
            true => say!(lang, "the-goal-is-reached-the-largest-uncertainty", share, proof),
            false => say!(lang, "the-goal-is-not-reached-at-best", share),
        };
        text.push_str(&format!("{}\n", hanging(&format!("  {reached}"), 4)));
        for note in goal_notes(improved, goal, lang) {
            text.push_str(&format!("{}\n", hanging(&format!("  {note}"), 4)));
        }
        for id in &goal.impossible {
            text.push_str(&format!("  {}\n", say!(lang, "even-all-candidates-together-do-not-determine", id)));
        }
    }
    text.push('\n');
    let rows: Vec<Vec<String>> = improved
        .comparison
        .iter()
        .map(|c| {
            let gain = c.gain.map_or("-".into(), |g| format!("{g:.2}"));
            vec![c.id.clone(), number(c.given), number(c.equal_effort), number(c.better), gain, c.unit.clone()]
        })
        .collect();
    let equal = equal_effort(improved.effort, lang);
    text.push_str(&plain(
        &[
            say!(lang, "parameter"),
            say!(lang, "u-given"),
            equal,
            say!(lang, "u-better"),
            say!(lang, "gain"),
            say!(lang, "unit"),
        ],
        &rows,
    ));
    let what = |text: &str| say!(lang, "cannot-be-determined-by-any-choice", text);
    text.push_str(&defects(&improved.unreachable, what, &nowhere(&improved.frozen, lang), lang));
    text.push_str(&format!("\n{}\n", say!(lang, "to-run-in-this-order")));
    let mut told: Option<String> = None;
    for (label, place) in mountings(&improved.positions, lang) {
        text.push_str(&format!("  {label:>4}  {place}\n"));
        if told.as_ref() != Some(&label)
            && let Some(why) = reason(improved, &label, lang)
        {
            text.push_str(&format!("        {why}\n"));
        }
        told = Some(label);
    }
    text.push_str(&drift(&improved.judgement, lang));
    text
}
