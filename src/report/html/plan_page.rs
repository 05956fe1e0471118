//! The page of a plan: the better schedule beside the given one, where its positions lie, and what rests on each reading.

use super::{Align, Block, Figure, Page, Section, Table, Tone};
use crate::campaign::Kind;
use crate::campaign::{Campaign, Readings};
use crate::error::Result;
use crate::report::Effort;
use crate::report::foresight::{group_lines, hidden, lacking, not_exercised, rule_text};
use crate::report::foresight_table::some_of;
use crate::report::plan_table::{
    apart, cost_limit, goal_notes, judged_at, lacking as lacking_value, mountings, moved, not_told_apart, nowhere,
    proof, reason, shortfall, through_tilts, work_of,
};
use crate::report::plot::{Spot, positions};
use crate::report::table::{count, significant};
use crate::report::{ForesightReport, ImprovedReport, JudgementReport, NotEstimableReport, PlanReport, PositionReport};
use std::collections::BTreeMap;

/// The page of a plan; `candidates` are drawn as dots.
pub fn plan_page(campaign: &Campaign, report: &PlanReport, candidates: Option<&Readings>) -> Result<Page> {
    let bench = &campaign.bench;
    let mut page = Page::new(if bench.title.is_empty() { bench.id.clone() } else { bench.title.clone() });
    page.subtitle = "Plan: what a schedule will reach before anyone measures".into();
    page.facts = vec![("Bench".into(), format!("`{}`", bench.id))];
    let mut facts: Vec<(String, String)> = Vec::new();
    facts.extend(report.model.iter().map(|(id, line)| (format!("Model of {id}"), format!("`{id} = {line}`"))));
    facts.extend(report.noise.iter().map(|(id, noise)| {
        (format!("Noise of {id}"), format!("{} {} ({})", significant(noise.sd, 4), noise.unit, noise.from))
    }));
    page.facts.push(("Judged at".into(), judged_at(&report.judged_at)));
    page.colophon = vec![("made by".into(), format!("tumble {}; the same inputs give the same bytes", report.tumble))];
    if let Some(nothing) = report.improved.as_ref().and_then(not_told_apart) {
        page = page.section(Section::new("The two effects").verdict(Tone::Bad, nothing));
    }
    let improved = report.improved.as_ref().filter(|improved| not_told_apart(improved).is_none());
    if let Some(improved) = improved {
        page = page.section(answer(improved)).section(order(improved));
    }
    let given = judged("The given schedule", &report.schedule);
    let map = map(campaign, report, candidates)?;
    page = match improved {
        Some(improved) => {
            let full = judged("The better schedule in full", &improved.judgement);
            page.section(map).section(given).section(full).section(readings("Its readings", &improved.judgement))
        }
        None => page.section(given).section(map).section(readings("What rests on each reading", &report.schedule)),
    };
    let last = improved.map_or(&report.schedule, |improved| &improved.judgement);
    if let Some(effects) = &last.effects {
        let of = if improved.is_some() { "the better schedule" } else { "this schedule" };
        page = page.section(effects_section(effects, of));
    }
    Ok(page.section(Section::new("Model and noise").block(Block::Facts(facts))))
}

fn cell(value: Option<f64>) -> String {
    value.map_or("-".into(), |v| significant(v, 3))
}

fn keys(position: &PositionReport) -> String {
    position.iter().map(|(key, value)| format!("{key} = {value}")).collect::<Vec<_>>().join(", ")
}

fn answer(improved: &ImprovedReport) -> Section {
    let mut section = Section::new("The better schedule");
    if let Some(goal) = &improved.goal {
        let share = goal.largest_share.map_or("unknown".into(), |s| significant(s, 3));
        section = match goal.reached {
            true => section
                .verdict(Tone::Good, format!("The goal is reached: the largest uncertainty is {share} of its limit.")),
            false => section.verdict(
                Tone::Bad,
                format!("The goal is not reached: at best, the largest uncertainty is {share} of its limit."),
            ),
        };
    }
    if let Some(goal) = &improved.goal {
        section = goal_notes(improved, goal)
            .into_iter()
            .fold(section, |section, note| section.prose(format!("{}.", capital(&note))));
    }
    if let (Some(efficiency), Some(proof)) = (improved.efficiency, proof(improved)) {
        let text = format!("{} (criterion {}).", capital(&proof), improved.criterion);
        section = section.verdict(if efficiency >= 0.99 { Tone::Good } else { Tone::Plain }, text);
        if let Some(why) = shortfall(improved) {
            section = section.prose(format!("The rest: {why}."));
        }
    }
    if let Some(moved) = moved(improved) {
        section = section.prose(format!("{}.", capital(&moved)));
    }
    if let Some(limit) = improved.cost_limit {
        section = section.prose(format!("{}.", capital(&cost_limit(improved, limit))));
    }
    if improved.to_run != improved.judgement.work {
        section = section.prose(format!("Still to run: {}.", work_of(&improved.to_run)));
    }
    if let Some(separation) = &improved.separation {
        let tone = if separation.after.iter().all(Option::is_some) { Tone::Good } else { Tone::Bad };
        section = apart(separation).into_iter().fold(section, |section, line| section.verdict(tone, line));
    }
    let mut table = Table::new(&[
        ("Parameter", Align::Left),
        ("u given", Align::Decimal),
        (if improved.effort == Effort::Cost { "u at equal cost" } else { "u at equal effort" }, Align::Decimal),
        ("u better", Align::Decimal),
        ("gain", Align::Decimal),
        ("unit", Align::Left),
    ]);
    table.caption = "Predicted standard uncertainties".into();
    table.note =
        format!("At equal effort: the given schedule repeated, or cut, to the {} of the better one.", improved.effort);
    for c in &improved.comparison {
        let gain = c.gain.map_or("-".into(), |g| format!("{g:.2}"));
        table.row(vec![
            format!("`{}`", c.id),
            cell(c.given),
            cell(c.equal_effort),
            cell(c.better),
            gain,
            c.unit.clone(),
        ]);
    }
    let what = "cannot be determined by any choice of these candidates";
    section.table(table).list(defects(&improved.unreachable, what, &nowhere(&improved.frozen)))
}

fn defects(list: &[NotEstimableReport], what: &str, nowhere: &str) -> Vec<String> {
    let separated = |d: &NotEstimableReport| match &d.separate_by {
        Some(position) => format!("separated by {}", keys(position)),
        None => nowhere.to_string(),
    };
    list.iter().map(|d| format!("`{}` {what}; {}", d.text, separated(d))).collect()
}

fn order(improved: &ImprovedReport) -> Section {
    let mut table = Table::new(&[
        ("mounting", Align::Left),
        ("position, values in the order to run", Align::Left),
        ("why it is there", Align::Left),
    ]);
    table.small = true;
    for (label, place) in mountings(&improved.positions) {
        let why = reason(improved, &label).unwrap_or_default();
        table.row(vec![label, place, why]);
    }
    let drift = improved.judgement.drift.map_or(String::new(), |d| {
        format!("In this order, a drift of one standard deviation over the run shifts a parameter by at most {} of its uncertainty.", significant(d, 2))
    });
    Section::new("To run, in this order").prose(drift).table(table)
}

/// Where the positions lie, over the first two joints that stand still.
fn map(campaign: &Campaign, report: &PlanReport, candidates: Option<&Readings>) -> Result<Section> {
    let section = Section::new("Where the positions lie");
    let joints: Vec<&str> = campaign.bench.joints().collect();
    let at = |position: &PositionReport, joint: &str| position.get(&format!("{joint}_deg")).copied();
    let swept: Vec<&str> = joints
        .iter()
        .copied()
        .filter(|joint| report.schedule.readings.iter().any(|r| at(&r.at, joint).is_some()))
        .take(2)
        .collect();
    let Some(across) = swept.first() else { return Ok(section) };
    let up = swept.get(1).copied().unwrap_or("");
    let spots = |list: &mut dyn Iterator<Item = PositionReport>| {
        let mut count: BTreeMap<(i64, i64), Spot> = BTreeMap::new();
        for position in list {
            let (Some(x), y) = (at(&position, across), at(&position, up).unwrap_or(0.0)) else { continue };
            let key = ((x * 1e6) as i64, (y * 1e6) as i64);
            count.entry(key).or_insert(Spot { x, y, readings: 0 }).readings += 1;
        }
        count.into_values().collect::<Vec<Spot>>()
    };
    let given = spots(&mut report.schedule.readings.iter().map(|r| r.at.clone()));
    let better = spots(&mut report.improved.iter().flat_map(|i| i.positions.iter().map(|p| p.at.clone())));
    let rows = candidates.map(|c| c.rows.as_slice()).unwrap_or_default();
    let dots = spots(&mut rows.iter().map(|r| crate::report::position_keys(campaign, &r.joints)));
    let drawn = if dots.len() > 5000 { Vec::new() } else { dots };
    let svg = positions(&drawn, &given, &better, [across, up])?;
    let caption = if better.is_empty() {
        "Squares: the schedule's positions."
    } else {
        "Dots: candidates. Squares: the given schedule. Discs with numbers: the better schedule and its readings at each position."
    };
    let places: Vec<String> =
        better.iter().map(|s| format!("{} readings at {across} {}, {up} {}", s.readings, s.x, s.y)).collect();
    let description = if places.is_empty() { caption.to_string() } else { places.join("; ") };
    Ok(section.figures(vec![Figure { caption: caption.into(), description, svg, wide: false }]))
}

/// What a diagnosis could find.
fn effects_section(effects: &ForesightReport, of: &str) -> Section {
    let mut table = Table::new(&[
        ("Effect", Align::Left),
        ("shows from", Align::Decimal),
        ("unit", Align::Left),
        ("then at a reading, in its u", Align::Decimal),
        ("and shifts", Align::Left),
        ("cannot be told from", Align::Left),
    ]);
    table.small = true;
    table.caption = format!("Effects that would show on {of}, one line for each direction");
    table.note = format!(
        "{}. Nearly alike: cosine beside the model, and the size from which the first is not taken for the other.",
        capital(&rule_text(effects))
    );
    for line in group_lines(effects) {
        let mut alike: Vec<String> = line.alike.iter().map(|name| format!("`{name}`")).collect();
        alike.extend(line.near.iter().map(|near| format!("nearly {near}")));
        table.row(vec![
            format!("`{}` {}", line.effect, line.name),
            significant(line.minimal, 3),
            line.unit,
            significant(line.at_a_reading, 2),
            line.moves,
            some_of(&alike, 4),
        ]);
    }
    let mut never = Table::new(&[("Effects", Align::Left), ("taken up by", Align::Left)]);
    never.small = true;
    never.caption = "Effects that never show: estimated parameters take them up, and are wrong by them".into();
    let places = hidden(effects);
    for (place, list) in &places {
        never.row(vec![list.iter().map(|r| format!("`{r}`")).collect::<Vec<_>>().join(", "), place.clone()]);
    }
    let mut notes = Vec::new();
    let zero = not_exercised(effects);
    if !zero.is_empty() {
        notes.push(format!(
            "Zero at every position: {}",
            zero.iter().map(|r| format!("`{r}`")).collect::<Vec<_>>().join(", ")
        ));
    }
    for (column, families) in lacking(effects) {
        notes.push(format!("Not tried without a column `{column}`: {families} kinds of effect"));
    }
    let tried = format!(
        "{} effects of the catalogue were tried on {of}, in {} distinct directions beside the model.",
        effects.effects.len(),
        effects.rule.tests
    );
    let section = Section::new("What a diagnosis could find").prose(tried).table(table);
    let section = if places.is_empty() { section } else { section.table(never) };
    section.list(notes)
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}

fn judged(heading: &str, j: &JudgementReport) -> Section {
    let mut table = Table::new(&[("Parameter", Align::Left), ("predicted u", Align::Decimal), ("unit", Align::Left)]);
    for p in &j.parameters {
        let u = p.u_arcsec.or(p.u);
        let unit = if p.kind == Kind::Tilt { "arcsec".to_string() } else { p.unit.clone() };
        let needs_value = j.lacking.as_ref().is_some_and(|own| own.untold.contains(&p.id));
        let instead = if needs_value { "needs a value" } else { "not estimable" };
        table.row(vec![format!("`{}`", p.id), u.map_or(instead.into(), |u| significant(u, 3)), unit]);
    }
    for d in &j.derived {
        let unit = if d.u_arcsec.is_some() { "arcsec" } else { "" };
        table.row(vec![format!("`{}`", d.id), cell(d.u_arcsec.or(d.u)), unit.to_string()]);
    }
    let w = &j.work;
    let work = format!(
        "{} in {} with {}, cost {}; rank {}, {} degrees of freedom.",
        count(w.readings, "reading"),
        count(w.mountings, "mounting"),
        count(w.rate_changes, "rate change"),
        significant(w.cost, 4),
        j.rank,
        j.dof
    );
    let through = j.through_tilts.as_ref().map(|t| capital(&through_tilts(t))).unwrap_or_default();
    let angles = j.parameters.iter().filter_map(|p| Some((p.id.as_str(), p.u_arcsec?)));
    let (tone, verdict) = match (j.not_estimable.len(), angles.max_by(|a, b| a.1.total_cmp(&b.1))) {
        (0, _) if j.lacking.is_some() => {
            (Tone::Caution, "Not every unknown has a predicted uncertainty at the point that was judged.".into())
        }
        (0, Some((id, u))) => (
            Tone::Good,
            format!(
                "Every unknown can be estimated; the least certain angle is `{id}` with u = {} arcsec.",
                significant(u, 3)
            ),
        ),
        (0, None) => (Tone::Good, "Every unknown can be estimated.".into()),
        (n, _) => (Tone::Bad, format!("{} cannot be estimated.", count(n, "combination of unknowns"))),
    };
    Section::new(heading)
        .verdict(tone, verdict)
        .prose(work)
        .prose(through)
        .prose(j.lacking.as_ref().map(|own| format!("{}.", capital(&lacking_value(own)))).unwrap_or_default())
        .list(defects(&j.not_estimable, "is not estimable", &nowhere(&BTreeMap::new())))
        .table(table)
}

/// What rests on each reading.
fn readings(heading: &str, j: &JudgementReport) -> Section {
    let mut readings = Table::new(&[
        ("#", Align::Right),
        ("position", Align::Left),
        ("sensor", Align::Left),
        ("leverage", Align::Decimal),
        ("mdb", Align::Decimal),
        ("its largest effect on an angle", Align::Left),
    ]);
    readings.caption =
        "Each value: leverage, minimal detectable bias (0.1 %, 80 %), and what it does undetected".into();
    readings.small = true;
    for r in &j.readings {
        let worst = r.effect_arcsec.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        let effect = worst.map_or(String::new(), |(id, e)| format!("{} arcsec of `{id}`", significant(*e, 3)));
        let leverage = format!("{:.3}", r.leverage);
        readings.row(vec![r.index.to_string(), keys(&r.at), r.sensor.clone(), leverage, cell(r.mdb), effect]);
    }
    Section::new(heading).table(readings)
}
