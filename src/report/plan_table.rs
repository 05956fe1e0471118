//! A plan as a person at a terminal reads it.

use super::foresight_table::foresight_table;
use super::table::{count, plain, significant};
use super::{
    DiscriminationReport, FindReport, GoalReport, ImprovedReport, JudgementReport, LackingReport, NotEstimableReport,
    PlanReport, PlannedPositionReport, PointReport, PositionReport, ThroughTiltsReport, WorkReport,
};
use crate::plan::PointSource;
use std::collections::BTreeMap;

fn number(value: Option<f64>) -> String {
    value.map_or("-".into(), |v| significant(v, 3))
}

/// A plan report as text; `with_readings` lists every value with its leverage and minimal detectable bias.
pub fn plan_table(report: &PlanReport, with_readings: bool) -> String {
    let mut text = format!("tumble {}: plan on {}\n", report.tumble, report.bench);
    for (sensor, line) in &report.model {
        text.push_str(&format!("  {sensor} = {line}\n"));
    }
    for (sensor, noise) in &report.noise {
        let sd = significant(noise.sd, 4);
        text.push_str(&format!("  noise of {sensor}: {sd} {} ({})\n", noise.unit, noise.from));
    }
    for (id, sd) in &report.remount {
        text.push_str(&format!("  every remounting scatters {id}: sd {} (rad for a tilt)\n", significant(*sd, 3)));
    }
    text.push_str(&format!("  judged at {}\n", judged_at(&report.judged_at)));
    text.push_str(&format!("\nThe schedule: {}\n\n", work(&report.schedule)));
    text.push_str(&judgement(&report.schedule));
    if with_readings {
        text.push_str(&readings(&report.schedule));
    }
    if let (Some(effects), None) = (&report.schedule.effects, &report.improved) {
        text.push_str(&foresight_table(effects));
    }
    if let Some(improved) = &report.improved {
        text.push_str(&better(improved, &report.finds));
        let effects = improved.judgement.effects.as_ref().filter(|_| not_told_apart(improved).is_none());
        if let Some(effects) = effects {
            text.push_str(&foresight_table(effects));
        }
        if with_readings && not_told_apart(improved).is_none() {
            text.push_str(&readings(&improved.judgement));
        }
    }
    text
}

/// The point at which schedules are judged, in words: values with their source, then what stands at zero.
pub(super) fn judged_at(point: &[PointReport]) -> String {
    let mut parts: Vec<String> = Vec::new();
    let mut zero: Vec<&str> = Vec::new();
    for value in point {
        let (number, unit) = match value.arcsec {
            Some(arcsec) => (arcsec, "arcsec"),
            None => (value.value, value.unit.as_str()),
        };
        match value.from {
            PointSource::Zero => zero.push(&value.id),
            from => parts.push(format!("{} = {} {unit} ({from})", value.id, significant(number, 4)).replace("  ", " ")),
        }
    }
    match (zero.len(), parts.is_empty()) {
        (0, _) => {}
        (_, true) => parts.push("zero (no parameter has a start, prior or --at)".into()),
        (1..=6, _) => parts.push(format!("{} = 0", zero.join(", "))),
        (count, _) => parts.push(format!("{count} others = 0")),
    }
    parts.join(", ")
}

/// What needs a value, in one sentence.
pub(super) fn lacking(lacking: &LackingReport) -> String {
    let needs = lacking.needs.join(", ");
    let first = lacking.needs.first().map_or("", String::as_str);
    format!(
        "the uncertainty of {} depends on the value of {needs}, and none is stated: at zero the effect vanishes;\n  --at {first}=VALUE or a \"start\" tells it",
        lacking.untold.join(", ")
    )
}

fn work(judgement: &JudgementReport) -> String {
    work_of(&judgement.work)
}

pub(super) fn work_of(w: &WorkReport) -> String {
    format!(
        "{} in {} with {}, cost {}",
        count(w.readings, "reading"),
        count(w.mountings, "mounting"),
        count(w.rate_changes, "rate change"),
        significant(w.cost, 4)
    )
}

fn judgement(j: &JudgementReport) -> String {
    let mut rows = Vec::new();
    // the strongest partner says more than a matrix; the matrix is in the JSON
    let strongest = |i: usize| {
        let row = j.correlation.matrix.get(i)?;
        let others = row.iter().enumerate().filter(|(k, _)| *k != i).filter_map(|(k, r)| r.map(|r| (k, r)));
        let (k, r) = others.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        let partner = j.correlation.order.get(k)?;
        (r.abs() >= 0.005).then(|| format!("{r:+.2} with {partner}"))
    };
    let needs_value = |id: &String| j.lacking.as_ref().is_some_and(|l| l.untold.contains(id));
    for (i, p) in j.parameters.iter().enumerate() {
        let angle = p.u_arcsec.is_some();
        rows.push(vec![
            p.id.clone(),
            if needs_value(&p.id) {
                "needs a value".into()
            } else if p.u.is_none() {
                "not estimable".into()
            } else {
                number(if angle { p.u_arcsec } else { p.u })
            },
            if angle { "arcsec".into() } else { p.unit.clone() },
            strongest(i).unwrap_or_default(),
            if p.u.is_some() { number(p.undetected_fault_arcsec.or(p.undetected_fault)) } else { "-".into() },
        ]);
    }
    for d in &j.derived {
        let note = if d.is_largest { "largest near the reference" } else { "" };
        let unit = if d.u_arcsec.is_some() { "arcsec" } else { "" };
        rows.push(vec![d.id.clone(), number(d.u_arcsec.or(d.u)), unit.into(), note.into(), "".into()]);
    }
    let mut text = plain(&["parameter", "predicted u", "unit", "strongest correlation", "undetected fault"], &rows);
    text.push_str(&format!("\nrank {}, {} degrees of freedom", j.rank, j.dof));
    if let Some(condition) = j.condition {
        text.push_str(&format!(", condition {}", significant(condition, 3)));
    }
    let unchecked = j.unchecked;
    if unchecked > 0 {
        text.push_str(&format!("; {unchecked} values are checked by no other"));
    }
    text.push('\n');
    if let Some(drift) = j.drift {
        text.push_str(&format!(
            "a drift of one standard deviation over the run shifts a parameter by at most {} of its u\n",
            significant(drift, 2)
        ));
    }
    if let Some(through) = &j.through_tilts {
        text.push_str(&format!("{}\n", through_tilts(through)));
    }
    if j.effects.is_none() && j.work.readings > 0 {
        text.push_str("so many values: what a diagnosis could find is not foreseen, and values are not listed\n");
    }
    if let Some(own) = &j.lacking {
        text.push_str(&format!("{}\n", lacking(own)));
    }
    if j.bounds_not_counted > 0 {
        text.push_str(&format!(
            "{} not counted: a bound lowers an uncertainty only where it is reached\n",
            if j.bounds_not_counted == 1 {
                "1 bound is".into()
            } else {
                format!("{} bounds are", j.bounds_not_counted)
            }
        ));
    }
    text.push_str(&defects(&j.not_estimable, "is not estimable", &nowhere(&BTreeMap::new())));
    text
}

/// What known inputs do through the tilts, in one sentence.
pub(super) fn through_tilts(through: &ThroughTiltsReport) -> String {
    let (u, unit) = match through.u_arcsec {
        Some(arcsec) => (arcsec, " arcsec"),
        None => (through.u, ""),
    };
    let ThroughTiltsReport { known, parameter, tilts_arcsec, .. } = through;
    let (u, tilts) = (significant(u, 2), significant(*tilts_arcsec, 3));
    match through.counted {
        true => format!(
            "counted above: with tilts of {tilts} arcsec, the uncertainty of {known} adds {u}{unit} to {parameter}"
        ),
        false => format!(
            "not counted: the uncertainty of {known} acts through the tilts, whose size no schedule tells;\n  tilts of {tilts} arcsec would add {u}{unit} to {parameter} (--tilts {tilts} counts it)"
        ),
    }
}

/// The positions of a schedule, one line for each mounting: its label, and its keys; the key that changes within it has several values.
pub(super) fn mountings(positions: &[PlannedPositionReport]) -> Vec<(String, String)> {
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
                format!("{key} = {}", runs(run.iter().filter_map(|p| p.at.get(key))))
            }
            _ => format!("{key} = {value}"),
        };
        let mut parts: Vec<String> = first.at.iter().map(part).collect();
        if changing.is_none() && length > 1 {
            parts.push(format!("{length} times"));
        }
        lines.push((first.position.clone(), parts.join(", ")));
        rest = left;
    }
    lines
}

/// Values in order, four and more of one in a row as `40 (4 times)`.
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
        _ => format!("{value}\u{a0}({count}\u{a0}times)"),
    };
    runs.into_iter().map(text).collect::<Vec<_>>().join(", ")
}

/// How good the choice is proven to be.
pub(super) fn proof(improved: &ImprovedReport) -> Option<String> {
    let within = if improved.cost_limit.is_some() { " at this cost" } else { "" };
    if let Some(all) = improved.enumerated {
        return Some(format!("the best: all {all} choices of these candidates{within} were tried (proven 100 %)"));
    }
    let share = percent(improved.efficiency?);
    Some(format!("proven to be at least {share} as good as the best possible choice of these candidates{within}"))
}

/// What moving the angles between the candidates brought.
pub(super) fn moved(improved: &ImprovedReport) -> Option<String> {
    let refined = improved.refined.as_ref()?;
    let resolution = significant(refined.resolution_deg, 3);
    if refined.moved == 0 {
        return Some(format!("no angle is worth moving off the candidates, in steps down to {resolution} deg"));
    }
    let mountings = if refined.moved == 1 { "1 mounting" } else { &format!("{} mountings", refined.moved) };
    let gain = significant(100.0 * refined.gain, 2);
    let end = if refined.finished { "" } else { " (not finished)" };
    Some(format!(
        "angles of {mountings} moved off the candidates, in steps down to {resolution} deg: {gain} % better than the choice{end}"
    ))
}

/// Why the efficiency is below 0.99: the bound, or the few portions.
pub(super) fn shortfall(improved: &ImprovedReport) -> Option<String> {
    let (efficiency, gap) = (improved.efficiency?, improved.bound_gap?);
    let short = 1.0 - efficiency;
    (short > 0.01).then(|| match gap < 0.1 * short {
        true if improved.cost_limit.is_some() => {
            "the bound allows more mountings than the cost does, so the choice may well be the best".into()
        }
        true => "so few portions cannot follow the best weights; more of them, or smaller ones, come nearer".into(),
        false => format!("the bound itself may be {} too high", significant(gap, 2)),
    })
}

/// The limit of the cost, and where it comes from.
pub(super) fn cost_limit(improved: &ImprovedReport, limit: f64) -> String {
    let cost = significant(limit, 4);
    match improved.budget {
        Some(_) => format!("within a budget of {cost} for what was chosen"),
        None => format!("at no more cost than the given schedule, {cost} for so many readings (--any-cost: at any)"),
    }
}

/// Why a mounting is there, in words.
pub(super) fn reason(improved: &ImprovedReport, label: &str) -> Option<String> {
    let reason = improved.reasons.iter().find(|r| r.position == label)?;
    Some(match reason.grows {
        None => format!("without it nothing determines {}", reason.parameter),
        Some(grows) if grows > 1.0005 => {
            format!("without it u of {} grows by {} %", reason.parameter, significant(100.0 * (grows - 1.0), 2))
        }
        Some(_) => "it adds little".into(),
    })
}

/// How well two effects are told apart, before and after.
pub(super) fn apart(separation: &DiscriminationReport) -> Vec<String> {
    let [a, b] = &separation.effects;
    let known = |u: &[Option<f64>; 2]| match u {
        [Some(p), Some(q)] => format!("u of their coefficients {} and {}", significant(*p, 3), significant(*q, 3)),
        _ => "nothing tells them apart".into(),
    };
    let mut lines = vec![format!("{a} and {b}, both in the model: before, {}", known(&separation.before))];
    lines.push(match separation.after {
        [Some(_), Some(_)] => format!("with the added positions, {}", known(&separation.after)),
        _ => "no candidate tells them apart, so nothing is added".into(),
    });
    lines
}

/// Why no position separates what is not estimable: none of the bench does, or the candidates hold a column at one value.
pub(super) fn nowhere(frozen: &BTreeMap<String, f64>) -> String {
    let held: Vec<String> = frozen.iter().map(|(column, value)| format!("{column} = {value}")).collect();
    match held.is_empty() {
        true => "no position of this bench would separate it".into(),
        false => format!(
            "no candidate would separate it, but all candidates have {} only (--candidates FILE takes others)",
            held.join(", ")
        ),
    }
}

/// A share that something has at least: cut, not rounded up.
pub(super) fn percent(share: f64) -> String {
    format!("{:.2} %", (share * 1e4 + 1e-2).floor() / 100.0)
}

/// What an effect that is to be found asks of the schedule.
fn found_with(find: &FindReport) -> String {
    format!(
        "{} of {} is found with probability {} where the u of its coefficient {} is at most {}",
        find.effect,
        significant(find.size, 3),
        find.power,
        find.coefficient,
        significant(find.u, 3)
    )
}

/// What a goal counts, and what is known of its cost.
pub(super) fn goal_notes(improved: &ImprovedReport, goal: &GoalReport) -> Vec<String> {
    let counted = goal.limits.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
    let derived = improved.judgement.derived.iter().map(|d| d.id.as_str());
    let derived: Vec<&str> = derived.filter(|id| !goal.limits.contains_key(*id)).collect();
    let mut notes = vec![match derived.is_empty() {
        true => format!("the goal counts {counted}"),
        false => format!("the goal counts {counted}, but not {}", derived.join(", ")),
    }];
    if goal.is_cheapest_found && goal.reached {
        notes.push("this is the cheapest schedule that was found; that none is cheaper is not proven".into());
    }
    notes
}

fn defects(list: &[NotEstimableReport], what: &str, nowhere: &str) -> String {
    let mut text = String::new();
    for defect in list {
        text.push_str(&format!("{} {what}", defect.text));
        let instead: Vec<&str> = defect.estimable.iter().map(|c| c.text.as_str()).collect();
        if !instead.is_empty() {
            text.push_str(&format!("; determined instead: {}", instead.join(", ")));
        }
        match &defect.separate_by {
            Some(position) => text.push_str(&format!("; separated by {}\n", keys(position))),
            None => text.push_str(&format!("; {nowhere}\n")),
        }
    }
    text
}

fn keys(position: &PositionReport) -> String {
    position.iter().map(|(key, value)| format!("{key} = {value}")).collect::<Vec<_>>().join(", ")
}

fn readings(j: &JudgementReport) -> String {
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
                worst.map_or(String::new(), |(id, e)| format!("{} arcsec of {id}", significant(*e, 3))),
            ]
        })
        .collect();
    let header = ["#", "position", "at", "sensor", "leverage", "mdb", "its largest effect on an angle"];
    format!("\n{}", plain(&header, &rows))
}

/// Two effects that no candidate tells apart: there is no better schedule to show.
pub(super) fn not_told_apart(improved: &ImprovedReport) -> Option<String> {
    let separation = improved.separation.as_ref()?;
    let [a, b] = &separation.effects;
    let none = separation.after.iter().any(Option::is_none);
    none.then(|| format!("No candidate tells {a} and {b} apart, so nothing is added."))
}

fn better(improved: &ImprovedReport, finds: &[FindReport]) -> String {
    if let Some(nothing) = not_told_apart(improved) {
        return format!("\n{nothing}\n");
    }
    let mut text = format!("\nThe better schedule: {}\n", work(&improved.judgement));
    if improved.to_run != improved.judgement.work {
        text.push_str(&format!("  still to run: {}\n", work_of(&improved.to_run)));
    }
    let starts = match improved.enumerated {
        Some(_) => String::new(),
        None => format!(", seed {}, {} of {} starts ended here", improved.seed, improved.hits, improved.starts),
    };
    text.push_str(&format!(
        "  {} of its readings chosen among {} candidate portions, criterion {}{starts}\n",
        improved.chosen, improved.candidates, improved.criterion
    ));
    if let Some(proof) = proof(improved) {
        text.push_str(&format!("  {proof}\n"));
        if let Some(why) = shortfall(improved) {
            text.push_str(&format!("  {why}\n"));
        }
    }
    if let Some(moved) = moved(improved) {
        text.push_str(&format!("  {moved}\n"));
    }
    if let Some(limit) = improved.cost_limit {
        text.push_str(&format!("  {}\n", cost_limit(improved, limit)));
    }
    if let Some(separation) = &improved.separation {
        for line in apart(separation) {
            text.push_str(&format!("  {line}\n"));
        }
    }
    for find in finds {
        text.push_str(&format!("  {}\n", found_with(find)));
    }
    if let Some(goal) = &improved.goal {
        let share = goal.largest_share.map_or("unknown".into(), |s| significant(s, 3));
        let proof = if goal.is_fewest { "; fewer readings cannot reach it" } else { "" };
        text.push_str(&match goal.reached {
            true => format!("  the goal is reached: the largest uncertainty is {share} of its limit{proof}\n"),
            false => format!("  the goal is NOT reached: at best, the largest uncertainty is {share} of its limit\n"),
        });
        for note in goal_notes(improved, goal) {
            text.push_str(&format!("  {note}\n"));
        }
        for id in &goal.impossible {
            text.push_str(&format!("  {id}: even all candidates together do not determine it\n"));
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
    let equal = format!("u at equal {}", improved.effort);
    text.push_str(&plain(&["parameter", "u given", &equal, "u better", "gain", "unit"], &rows));
    let what = "cannot be determined by any choice of these candidates";
    text.push_str(&defects(&improved.unreachable, what, &nowhere(&improved.frozen)));
    text.push_str("\nTo run, in this order:\n");
    let mut told: Option<String> = None;
    for (label, place) in mountings(&improved.positions) {
        text.push_str(&format!("  {label:>4}  {place}\n"));
        if told.as_ref() != Some(&label)
            && let Some(why) = reason(improved, &label)
        {
            text.push_str(&format!("        {why}\n"));
        }
        told = Some(label);
    }
    if let Some(drift) = improved.judgement.drift {
        text.push_str(&format!(
            "a drift of one standard deviation over the run shifts a parameter by at most {} of its u\n",
            significant(drift, 2)
        ));
    }
    text
}
