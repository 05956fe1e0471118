//! The page of a plan: the better schedule beside the given one, where its positions lie, and what rests on each reading.

use super::{Align, Figure, Page, PageBlock, Section, Table, Tone};
use crate::campaign::Kind;
use crate::campaign::{Campaign, Readings};
use crate::error::Result;
use crate::language::{Language, say};
use crate::number;
use crate::report::Effort;
use crate::report::foresight::{group_lines, hidden, lacking, not_exercised, rule_text};
use crate::report::foresight_table::some_of;
use crate::report::plan_better::{
    apart, cost_limit, equal_effort, goal_notes, mountings, moved, not_told_apart, proof, reason, shortfall,
};
use crate::report::plan_words::{judged_at, lacking as lacking_value, nowhere, shared, through_tilts, work_of};
use crate::report::plot::{Spot, positions};
use crate::report::table::significant;
use crate::report::{ForesightReport, ImprovedReport, JudgementReport, NotEstimableReport, PlanReport, PositionReport};
use std::collections::BTreeMap;

/// The page of a plan; `candidates` are drawn as dots.
pub fn plan_page(
    campaign: &Campaign,
    report: &PlanReport,
    candidates: Option<&Readings>,
    lang: Language,
) -> Result<Page> {
    let bench = &campaign.bench;
    let title = if bench.title.is_empty() { &bench.id } else { &bench.title };
    let mut page = Page::new(lang.name(title).into_owned());
    page.language = lang;
    page.subtitle = say!(lang, "plan-what-a-schedule-will-reach-before").into();
    page.facts = vec![(say!(lang, "bench").into(), format!("`{}`", bench.id))];
    let mut facts: Vec<(String, String)> = Vec::new();
    facts.extend(report.model.iter().map(|(id, line)| (say!(lang, "model-of-2", id), format!("`{id} = {line}`"))));
    facts.extend(report.noise.iter().map(|(id, noise)| {
        let from = lang.in_parentheses(&lang.term("sd-from", &noise.from.to_string()));
        (say!(lang, "noise-of-2", id), format!("{} {} {from}", significant(noise.sd, 4), noise.unit))
    }));
    page.facts.push((say!(lang, "judged-at-2").into(), judged_at(&report.judged_at, lang)));
    page.colophon = vec![(
        say!(lang, "made-by").into(),
        say!(lang, "tumble-the-same-inputs-give-the-same", version = report.tumble),
    )];
    if let Some(nothing) = report.improved.as_ref().and_then(|own| not_told_apart(own, lang)) {
        page = page.section(Section::new(say!(lang, "the-two-effects")).verdict(Tone::Bad, nothing));
    }
    let improved = report.improved.as_ref().filter(|improved| not_told_apart(improved, lang).is_none());
    if let Some(improved) = improved {
        page = page.section(answer(improved, lang)).section(order(improved, lang));
    }
    let given = judged(say!(lang, "the-given-schedule"), &report.schedule, lang);
    let map = map(campaign, report, candidates, lang)?;
    page = match improved {
        Some(improved) => {
            let full = judged(say!(lang, "the-better-schedule-in-full"), &improved.judgement, lang);
            page.section(map).section(given).section(full).section(readings(
                say!(lang, "its-readings"),
                &improved.judgement,
                lang,
            ))
        }
        None => page.section(given).section(map).section(readings(
            say!(lang, "what-rests-on-each-reading"),
            &report.schedule,
            lang,
        )),
    };
    let last = improved.map_or(&report.schedule, |improved| &improved.judgement);
    if let Some(effects) = &last.effects {
        page = page.section(effects_section(effects, improved.is_some(), lang));
    }
    Ok(page.section(Section::new(say!(lang, "model-and-noise")).block(PageBlock::Facts(facts))))
}

fn cell(value: Option<f64>) -> String {
    value.map_or("-".into(), |v| significant(v, 3))
}

fn keys(position: &PositionReport) -> String {
    position.iter().map(|(key, value)| format!("{key} = {value}")).collect::<Vec<_>>().join(", ")
}

fn answer(improved: &ImprovedReport, lang: Language) -> Section {
    let mut section = Section::new(say!(lang, "the-better-schedule-2"));
    if let Some(goal) = &improved.goal {
        let share = goal.largest_share.map_or(say!(lang, "unknown").into(), |s| significant(s, 3));
        section = match goal.reached {
            true => section.verdict(Tone::Good, say!(lang, "the-goal-is-reached-the-largest-uncertainty-2", share)),
            false => section.verdict(Tone::Bad, say!(lang, "the-goal-is-not-reached-at-best-2", share)),
        };
    }
    if let Some(goal) = &improved.goal {
        section = goal_notes(improved, goal, lang)
            .into_iter()
            .fold(section, |section, note| section.prose(lang.sentence(&note)));
    }
    if let (Some(efficiency), Some(proof)) = (improved.efficiency, proof(improved, lang)) {
        let criterion = lang.term("criterion", &improved.criterion);
        let text = lang.sentence(&say!(lang, "with-criterion", proof, criterion));
        section = section.verdict(if efficiency >= 0.99 { Tone::Good } else { Tone::Plain }, text);
        if let Some(why) = shortfall(improved, lang) {
            section = section.prose(say!(lang, "the-rest", why));
        }
    }
    if let Some(moved) = moved(improved, lang) {
        section = section.prose(lang.sentence(&moved));
    }
    if let Some(limit) = improved.cost_limit {
        section = section.prose(lang.sentence(&cost_limit(improved, limit, lang)));
    }
    if improved.to_run != improved.judgement.work {
        section = section.prose(say!(lang, "still-to-run-2", work = work_of(&improved.to_run, lang)));
    }
    if let Some(separation) = &improved.separation {
        let tone = if separation.after.iter().all(Option::is_some) { Tone::Good } else { Tone::Bad };
        section = apart(separation, lang).into_iter().fold(section, |section, line| section.verdict(tone, line));
    }
    let mut table = Table::new(&[
        (say!(lang, "title-parameter"), Align::Left),
        (say!(lang, "u-given"), Align::Decimal),
        (equal_effort(improved.effort, lang), Align::Decimal),
        (say!(lang, "u-better"), Align::Decimal),
        (say!(lang, "gain"), Align::Decimal),
        (say!(lang, "unit"), Align::Left),
    ]);
    table.caption = say!(lang, "predicted-standard-uncertainties").into();
    table.note = match improved.effort {
        Effort::Readings => say!(lang, "at-equal-effort-the-given-schedule-repeated"),
        Effort::Cost => say!(lang, "at-equal-effort-the-given-schedule-repeated-2"),
    }
    .into();
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
    let what = |text: String| say!(lang, "cannot-be-determined-by-any-choice", text);
    let mut notes = shared(&improved.shared, lang);
    notes.extend(defects(&improved.unreachable, what, &nowhere(&improved.frozen, lang), lang));
    section.table(table).list(notes)
}

fn defects(list: &[NotEstimableReport], what: impl Fn(String) -> String, nowhere: &str, lang: Language) -> Vec<String> {
    let separated = |d: &NotEstimableReport| match &d.separate_by {
        Some(_) if d.separate_sensor.is_some() => d.further(lang).unwrap_or_default(),
        Some(position) => say!(lang, "separated-by", position = keys(position)),
        None => nowhere.to_string(),
    };
    list.iter().map(|d| [what(format!("`{}`", d.text)), separated(d)].join(lang.semicolon())).collect()
}

fn order(improved: &ImprovedReport, lang: Language) -> Section {
    let mut table = Table::new(&[
        (say!(lang, "mounting"), Align::Left),
        (say!(lang, "position-values-in-the-order-to-run"), Align::Left),
        (say!(lang, "why-it-is-there"), Align::Left),
    ]);
    table.small = true;
    for (label, place) in mountings(&improved.positions, lang) {
        let why = reason(improved, &label, lang).unwrap_or_default();
        table.row(vec![label, place, why]);
    }
    let drift = improved
        .judgement
        .drift
        .map_or(String::new(), |d| say!(lang, "in-this-order-a-drift-of-one", share = significant(d, 2)));
    Section::new(say!(lang, "to-run-in-this-order")).prose(drift).table(table)
}

/// Where the positions lie, over the first two joints that stand still.
fn map(campaign: &Campaign, report: &PlanReport, candidates: Option<&Readings>, lang: Language) -> Result<Section> {
    let section = Section::new(say!(lang, "where-the-positions-lie"));
    let joints: Vec<&str> = campaign.bench.joints().collect();
    let at = |position: &PositionReport, joint: &str| position.get(&format!("{joint}_deg")).copied();
    let swept: Vec<&str> = joints
        .iter()
        .copied()
        .filter(|joint| report.schedule.readings.iter().any(|r| at(&r.at, joint).is_some()))
        .take(2)
        .collect();
    let Some(across) = swept.first() else { return Ok(section) };
    let up = swept.get(1).copied().unwrap_or(""); // one joint alone: no second axis
    let spots = |list: &mut dyn Iterator<Item = PositionReport>| {
        let mut count: BTreeMap<(i64, i64), Spot> = BTreeMap::new();
        for position in list {
            // one joint alone: all on a line
            let (Some(x), y) = (at(&position, across), at(&position, up).unwrap_or(0.0)) else { continue };
            let key = (number::whole_i64(x * 1e6), number::whole_i64(y * 1e6));
            count.entry(key).or_insert(Spot { x, y, readings: 0 }).readings += 1;
        }
        count.into_values().collect::<Vec<Spot>>()
    };
    let given = spots(&mut report.schedule.readings.iter().map(|r| r.at.clone()));
    let better = spots(&mut report.improved.iter().flat_map(|i| i.positions.iter().map(|p| p.at.clone())));
    let rows = candidates.map(|c| c.rows.as_slice()).unwrap_or_default();
    let dots = spots(&mut rows.iter().map(|r| crate::report::position_keys(campaign, &r.joints)));
    let drawn = if dots.len() > 5000 { Vec::new() } else { dots };
    let svg = positions(&drawn, &given, &better, [across, up], lang)?;
    let caption = if better.is_empty() {
        say!(lang, "squares-the-schedules-positions")
    } else {
        say!(lang, "dots-candidates-squares-the-given-schedule-discs")
    };
    let places: Vec<String> = better
        .iter()
        .map(|s| {
            say!(
                lang,
                "readings-at-a-spot",
                n = lang.count(s.readings, "reading"),
                across,
                x = s.x.to_string(),
                up,
                y = s.y.to_string()
            )
        })
        .collect();
    let description = if places.is_empty() { caption.to_string() } else { places.join(lang.semicolon()) };
    Ok(section.figures(vec![Figure { caption: caption.into(), description, svg, wide: false }]))
}

/// What a diagnosis could find.
fn effects_section(effects: &ForesightReport, better: bool, lang: Language) -> Section {
    let mut table = Table::new(&[
        (say!(lang, "title-effect"), Align::Left),
        (say!(lang, "shows-from"), Align::Decimal),
        (say!(lang, "unit"), Align::Left),
        (say!(lang, "then-at-a-reading-in-its-u"), Align::Decimal),
        (say!(lang, "and-shifts"), Align::Left),
        (say!(lang, "cannot-be-told-from-2"), Align::Left),
    ]);
    table.small = true;
    table.caption = match better {
        true => say!(lang, "effects-that-would-show-on-the-better").into(),
        false => say!(lang, "effects-that-would-show-on-this-schedule").into(),
    };
    table.note =
        say!(lang, "nearly-alike-cosine-beside-the-model-and", rule = lang.sentence(&rule_text(effects, lang)));
    for line in group_lines(effects, lang) {
        let mut alike: Vec<String> = line.alike.iter().map(|name| format!("`{name}`")).collect();
        alike.extend(line.near.iter().map(|near| say!(lang, "plan-page-nearly", near)));
        table.row(vec![
            format!("`{}` {}", line.effect, line.name),
            significant(line.minimal, 3),
            line.unit,
            significant(line.at_a_reading, 2),
            line.moves,
            some_of(&alike, 4, lang),
        ]);
    }
    let mut never = Table::new(&[(say!(lang, "title-effects"), Align::Left), (say!(lang, "taken-up-by"), Align::Left)]);
    never.small = true;
    never.caption = say!(lang, "effects-that-never-show-estimated-parameters-take").into();
    let places = hidden(effects, lang);
    for (place, list) in &places {
        never.row(vec![list.iter().map(|r| format!("`{r}`")).collect::<Vec<_>>().join(", "), place.clone()]);
    }
    let mut notes = Vec::new();
    let zero = not_exercised(effects);
    if !zero.is_empty() {
        notes.push(say!(
            lang,
            "zero-at-every-position",
            effects = zero.iter().map(|r| format!("`{r}`")).collect::<Vec<_>>().join(", ")
        ));
    }
    for (column, families) in lacking(effects) {
        notes.push(say!(
            lang,
            "not-tried-without-a-column-kinds-of-2",
            column,
            families = lang.count(families, "kind")
        ));
    }
    let [tried, distinct] = [effects.effects.len(), effects.rule.tests].map(|n| n.to_string());
    let tried = say!(lang, "effects-of-the-catalogue-were-tried-in", tried, distinct);
    let section = Section::new(say!(lang, "what-a-diagnosis-could-find")).prose(tried).table(table);
    let section = if places.is_empty() { section } else { section.table(never) };
    section.list(notes)
}

fn judged(heading: &str, j: &JudgementReport, lang: Language) -> Section {
    let mut table = Table::new(&[
        (say!(lang, "title-parameter"), Align::Left),
        (say!(lang, "predicted-u"), Align::Decimal),
        (say!(lang, "unit"), Align::Left),
    ]);
    for p in &j.parameters {
        let u = p.u_arcsec.or(p.u);
        let unit = if p.kind == Kind::Tilt { "arcsec".to_string() } else { p.unit.clone() };
        let needs_value = j.lacking.as_ref().is_some_and(|own| own.untold.contains(&p.id));
        let instead = if needs_value { say!(lang, "needs-a-value") } else { say!(lang, "not-estimable") };
        table.row(vec![format!("`{}`", p.id), u.map_or(instead.into(), |u| significant(u, 3)), unit]);
    }
    for d in &j.derived {
        let unit = if d.u_arcsec.is_some() { "arcsec" } else { d.unit.as_str() };
        table.row(vec![format!("`{}`", d.id), cell(d.u_arcsec.or(d.u)), unit.to_string()]);
    }
    let w = &j.work;
    let rank = say!(lang, "plan-rank", rank = j.rank.to_string(), dof = lang.count(j.dof, "degree"));
    let work = lang.sentence(&[work_of(w, lang), rank].join(lang.semicolon()));
    let through = j.through_tilts.as_ref().map(|t| lang.sentence(&through_tilts(t, lang))).unwrap_or_default();
    let angles = j.parameters.iter().filter_map(|p| Some((p.id.as_str(), p.u_arcsec?)));
    let (tone, verdict) = match (j.not_estimable.len(), angles.max_by(|a, b| a.1.total_cmp(&b.1))) {
        (0, _) if j.lacking.is_some() => {
            (Tone::Caution, say!(lang, "not-every-unknown-has-a-predicted-uncertainty").into())
        }
        (0, Some((id, u))) => {
            (Tone::Good, say!(lang, "every-unknown-can-be-estimated-the-least", id, u = significant(u, 3)))
        }
        (0, None) => (Tone::Good, say!(lang, "every-unknown-can-be-estimated").into()),
        (n, _) => (Tone::Bad, say!(lang, "combinations-cannot-be-estimated", n)),
    };
    Section::new(heading)
        .verdict(tone, verdict)
        .prose(work)
        .prose(through)
        .prose(j.lacking.as_ref().map(|own| lang.sentence(&lacking_value(own, lang))).unwrap_or_default())
        .list(defects(
            &j.not_estimable,
            |text| say!(lang, "is-not-estimable", text),
            &nowhere(&BTreeMap::new(), lang),
            lang,
        ))
        .table(table)
}

/// What rests on each reading.
fn readings(heading: &str, j: &JudgementReport, lang: Language) -> Section {
    let mut readings = Table::new(&[
        ("#", Align::Right),
        (say!(lang, "per-position"), Align::Left),
        (say!(lang, "sensor"), Align::Left),
        (say!(lang, "leverage"), Align::Decimal),
        (say!(lang, "mdb"), Align::Decimal),
        (say!(lang, "its-largest-effect-on-an-angle"), Align::Left),
    ]);
    readings.caption = say!(lang, "each-value-leverage-minimal-detectable-bias-and").into();
    readings.small = true;
    for r in &j.readings {
        let worst = r.effect_arcsec.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        let effect = worst
            .map_or(String::new(), |(id, e)| say!(lang, "arcsec-of", e = significant(*e, 3), id = format!("`{id}`")));
        let leverage = format!("{:.3}", r.leverage);
        readings.row(vec![r.index.to_string(), keys(&r.at), r.sensor.clone(), leverage, cell(r.mdb), effect]);
    }
    Section::new(heading).table(readings)
}
