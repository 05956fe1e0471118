//! The document of a plan: the better schedule beside the given one, where its positions lie, and what each reading contributes.

use super::colophon::begin;
use super::fit_document::{bench_figure, model_facts};
use super::foresight::{group_lines, hidden, lacking, not_exercised, rule_text};
use super::plan_better::{
    apart, cost_limit, found_with, goal_notes, mountings, moved, not_told_apart, proof, reason, shortfall,
};
use super::plan_words::{judged_at, lacking as lacking_value, nowhere, shared, through_tilts, work_of};
use super::{Effort, FindReport, ForesightReport, ImprovedReport, JudgementReport};
use super::{NotEstimableReport, PlanReport, PositionReport};
use crate::campaign::{Campaign, Kind, Readings};
use crate::document::chart::{Chart, Spot};
use crate::document::number::significant;
use crate::document::{Align, Cell, Content, Detail, Document, Figure, Section, Table, Tone};
use crate::language::{Language, say};
use crate::number;
use std::collections::BTreeMap;

/// Groups of effects, and combinations that absorb some, that a terminal lists.
const LISTED: usize = 12;

/// The document of a plan. The campaign and its candidates give the map of the positions; `listed` puts every reading before a reader of a
/// terminal.
pub fn plan_document(
    report: &PlanReport,
    drawn: Option<(&Campaign, Option<&Readings>)>,
    listed: bool,
    lang: Language,
) -> Document {
    let title = drawn.map(|(campaign, _)| campaign.bench.title.as_str()).filter(|title| !title.is_empty());
    let title = title.map_or_else(|| report.bench.clone(), |title| lang.name(title).into_owned());
    let mut document = begin(say!(lang, "plan-of", title), &[], lang);
    document.facts = vec![(say!(lang, "bench").into(), format!("`{}`", report.bench))];
    document.facts.push((say!(lang, "judged-at-2").into(), judged_at(&report.judged_at, lang)));
    if let Some(nothing) = report.improved.as_ref().and_then(|own| not_told_apart(own, lang)) {
        document = document.section(Section::new(say!(lang, "result")).verdict(Tone::Bad, nothing));
    }
    let improved = report.improved.as_ref().filter(|improved| not_told_apart(improved, lang).is_none());
    if let Some(improved) = improved {
        document = document.section(answer(improved, &report.finds, lang)).section(order(improved, lang));
    }
    let given = judged(say!(lang, "the-given-schedule"), &report.schedule, improved.is_some(), lang);
    let map = drawn.map(|(campaign, candidates)| map(campaign, report, candidates, lang));
    let map = map.unwrap_or_default();
    document = match improved {
        Some(improved) => {
            let full = judged(say!(lang, "the-better-schedule-in-full"), &improved.judgement, true, lang);
            let readings = readings(say!(lang, "readings"), &improved.judgement, listed, lang);
            document.section(given).section(map).section(full).section(readings)
        }
        None => {
            let readings = readings(say!(lang, "readings"), &report.schedule, listed, lang);
            document.section(given).section(map).section(readings)
        }
    };
    let last = improved.map_or(&report.schedule, |improved| &improved.judgement);
    if let Some(effects) = &last.effects {
        document = document.section(effects_section(effects, lang));
    }
    document.section(model(report, drawn.map(|(campaign, _)| campaign), lang))
}

/// The model and the noise that the plan was made with.
fn model(report: &PlanReport, campaign: Option<&Campaign>, lang: Language) -> Section {
    let mut facts: Vec<(String, String)> = Vec::new();
    facts.extend(model_facts(&report.model, lang));
    facts.extend(report.noise.iter().map(|(id, noise)| {
        let from = lang.in_parentheses(&lang.term(&noise.from.to_string()));
        let sd = format!("{} {} {from}", significant(noise.sd, 4), noise.unit);
        (lang.title(say!(lang, "noise-sd")), format!("`{id}`{}{sd}", lang.colon()))
    }));
    let remount = |(id, sd): (&String, &f64)| {
        lang.sentence(&say!(lang, "every-remounting-scatters-sd-rad-for-a", id, sd = significant(*sd, 3)))
    };
    let section = Section::new(say!(lang, "model-and-noise")).list(report.remount.iter().map(remount).collect());
    section.block(Content::Facts(facts)).full().figures(bench_figure(campaign, lang))
}

/// A predicted uncertainty, or what it is given for.
fn predicted(value: Option<f64>) -> Cell {
    Cell::digits(value, 3)
}

fn keys(position: &PositionReport) -> String {
    position.iter().map(|(key, value)| format!("{key} = {value}")).collect::<Vec<_>>().join(", ")
}

fn answer(improved: &ImprovedReport, finds: &[FindReport], lang: Language) -> Section {
    let mut section = Section::new(say!(lang, "the-better-schedule-2"));
    section = section.prose(lang.sentence(&work_of(&improved.judgement.work, lang)));
    if let Some(goal) = &improved.goal {
        let share = goal.largest_share.map_or(say!(lang, "unknown").into(), |s| significant(s, 3));
        let proof = if goal.is_fewest { say!(lang, "fewer-readings-cannot-reach-it") } else { "" };
        let tone = if goal.reached { Tone::Good } else { Tone::Bad };
        section = section.verdict(tone, say!(lang, "goal-reached", reached = goal.reached, share, proof));
    }
    if let Some(goal) = &improved.goal {
        section = goal_notes(improved, goal, lang)
            .into_iter()
            .fold(section, |section, note| section.prose(lang.sentence(&note)));
        for id in &goal.impossible {
            let text = say!(lang, "cannot-be-determined-by-any-choice", text = format!("`{id}`"));
            section = section.verdict(Tone::Bad, lang.sentence(&text));
        }
    }
    if let (Some(efficiency), Some(proof)) = (improved.efficiency, proof(improved, lang)) {
        section = section.verdict(if efficiency >= 0.99 { Tone::Good } else { Tone::Plain }, lang.sentence(&proof));
        if let Some(why) = shortfall(improved, lang) {
            section = section.prose(lang.sentence(&why));
        }
    }
    if let Some(moved) = moved(improved, lang) {
        section = section.prose(lang.sentence(&moved));
    }
    if let Some(limit) = improved.cost_limit {
        section = section.prose(lang.sentence(&cost_limit(improved, limit, lang)));
    }
    for find in finds {
        section = section.prose(lang.sentence(&found_with(find, lang)));
    }
    if improved.to_run != improved.judgement.work {
        section = section.prose(say!(lang, "still-to-run-2", work = work_of(&improved.to_run, lang)));
    }
    if let Some(separation) = &improved.separation {
        let tone = if separation.after.iter().all(Option::is_some) { Tone::Good } else { Tone::Bad };
        section = apart(separation, lang).into_iter().fold(section, |section, line| section.verdict(tone, line));
    }
    let cost = improved.effort == Effort::Cost;
    let mut table = Table::new(&[
        (&lang.title(say!(lang, "parameter")), Align::Left),
        (say!(lang, "as-given"), Align::Decimal),
        (&say!(lang, "u-at-equal-effort", cost), Align::Decimal),
        (say!(lang, "better"), Align::Decimal),
        (say!(lang, "gain"), Align::Decimal),
        (say!(lang, "unit"), Align::Left),
    ]);
    table.caption = say!(lang, "predicted-standard-uncertainties").into();
    table.note = say!(lang, "at-equal-effort", cost);
    for c in &improved.comparison {
        table.row(vec![
            Cell::name(&c.id),
            predicted(c.given),
            predicted(c.equal_effort),
            predicted(c.better),
            Cell::decimals(c.gain, 2),
            c.unit.as_str().into(),
        ]);
    }
    let what = |text: String| say!(lang, "cannot-be-determined-by-any-choice", text);
    let mut notes = shared(&improved.shared, lang);
    notes.extend(defects(&improved.unreachable, what, &nowhere(&improved.frozen, lang), lang));
    section.table(table).list(notes).full().prose(lang.sentence(&chosen(improved, lang)))
}

/// How the better schedule was found.
fn chosen(improved: &ImprovedReport, lang: Language) -> String {
    let starts = match improved.enumerated {
        Some(_) => String::new(),
        None => {
            let [hits, starts] = [improved.hits, improved.starts].map(|n| n.to_string());
            say!(lang, "seed-of-starts-ended-here", seed = improved.seed.to_string(), hits, starts)
        }
    };
    say!(
        lang,
        "of-its-readings-chosen-among-candidate-portions",
        chosen = improved.chosen.to_string(),
        candidates = improved.candidates.to_string(),
        criterion = lang.term(&improved.criterion),
        starts
    )
}

fn defects(list: &[NotEstimableReport], what: impl Fn(String) -> String, nowhere: &str, lang: Language) -> Vec<String> {
    let separated = |d: &NotEstimableReport| match &d.separate_by {
        Some(_) => d.further(lang).unwrap_or_default(),
        None => nowhere.to_string(),
    };
    let clauses = |d: &NotEstimableReport| {
        let clauses = [Some(what(format!("`{}`", d.text))), d.instead(lang), Some(separated(d))];
        lang.sentence(&clauses.into_iter().flatten().collect::<Vec<_>>().join(lang.semicolon()))
    };
    list.iter().map(clauses).collect()
}

fn order(improved: &ImprovedReport, lang: Language) -> Section {
    let mut table = Table::new(&[
        (say!(lang, "mounting"), Align::Left),
        (say!(lang, "setting"), Align::Left),
        (say!(lang, "reason"), Align::Left),
    ]);
    table.small = true;
    let mut said: Option<String> = None;
    for (label, place) in mountings(&improved.positions) {
        let why = reason(improved, &label, lang).filter(|_| said.as_ref() != Some(&label)).unwrap_or_default();
        table.row(vec![label.clone(), place, why]);
        said = Some(label);
    }
    Section::new(say!(lang, "to-run-in-this-order")).table(table)
}

/// Where the positions lie, over the first two joints that stand still.
fn map(campaign: &Campaign, report: &PlanReport, candidates: Option<&Readings>, lang: Language) -> Section {
    let section = Section::new(say!(lang, "where-the-positions-lie")).full();
    let joints: Vec<&str> = campaign.bench.joints().collect();
    let at = |position: &PositionReport, joint: &str| position.get(&format!("{joint}_deg")).copied();
    let swept: Vec<&str> = joints
        .iter()
        .copied()
        .filter(|joint| report.schedule.readings.iter().any(|r| at(&r.at, joint).is_some()))
        .take(2)
        .collect();
    let Some(across) = swept.first() else { return section };
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
    let dots = spots(&mut rows.iter().map(|r| super::position_keys(campaign, &r.joints)));
    let drawn = if dots.len() > 5000 { Vec::new() } else { dots };
    let caption = if better.is_empty() {
        say!(lang, "squares-the-schedules-positions")
    } else {
        say!(lang, "dots-candidates-squares-the-given-schedule-discs")
    };
    let places: Vec<String> = better
        .iter()
        .map(|s| {
            let up = if up.is_empty() { String::new() } else { format!(", {up} {}", s.y) };
            format!("{across} {}{up}{}{}", s.x, lang.colon(), lang.count(s.readings, "reading"))
        })
        .collect();
    let description = if places.is_empty() { caption.to_string() } else { places.join(lang.semicolon()) };
    let chart = Chart::Positions([drawn, given, better], [across, up].map(String::from));
    section.figures(vec![Figure { caption: caption.into(), description, chart, wide: false }])
}

/// What a diagnosis could find.
fn effects_section(effects: &ForesightReport, lang: Language) -> Section {
    let mut table = Table::new(&[
        (&lang.title(say!(lang, "effect")), Align::Left),
        (say!(lang, "meaning"), Align::Left),
        (say!(lang, "shows-from"), Align::Decimal),
        (say!(lang, "unit"), Align::Left),
        (say!(lang, "then-at-a-reading-in-its-u"), Align::Decimal),
        (say!(lang, "and-shifts"), Align::Left),
        (say!(lang, "cannot-be-distinguished-from"), Align::Left),
        (say!(lang, "nearly-alike"), Align::Left),
    ])
    .at(Detail::Full, &[1, 7]);
    table.small = true;
    table.brief_rows = Some(LISTED);
    table.caption = say!(lang, "effects-that-would-show").into();
    table.note = say!(lang, "nearly-alike-cosine-beside-the-model-and").into();
    for line in group_lines(effects, lang) {
        let alike: Vec<String> = line.alike.iter().map(|name| format!("`{name}`")).collect();
        let alike = match line.nearest {
            Some(nearest) if alike.is_empty() => nearest,
            _ => lang.first_of(&alike, 4, lang.comma()),
        };
        table.row(vec![
            Cell::name(&line.effect),
            line.name.into(),
            Cell::Digits(line.minimal, 3),
            line.unit.into(),
            Cell::Digits(line.at_a_reading, 2),
            line.moves.into(),
            alike.into(),
            lang.first_of(&line.near, 4, lang.comma()).into(),
        ]);
    }
    let mut never = Table::new(&[(say!(lang, "effect"), Align::Left), (say!(lang, "taken-up-by"), Align::Left)]);
    never.small = true;
    never.brief_rows = Some(LISTED);
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
        notes.push(say!(lang, "not-tried-without-a-column-kinds-of-2", column, families = families.to_string()));
    }
    let [tried, distinct] = [effects.effects.len(), effects.rule.tests].map(|n| n.to_string());
    let tried = say!(lang, "effects-of-the-catalogue-were-tried-in", tried, distinct);
    let section = Section::new(say!(lang, "what-a-diagnosis-could-find"))
        .prose(tried)
        .prose(lang.sentence(&rule_text(effects, lang)))
        .table(table);
    let section = if places.is_empty() { section } else { section.table(never) };
    section.list(notes)
}

/// A schedule judged; where a better one stands before it, a terminal leaves it out.
fn judged(heading: &str, j: &JudgementReport, beside: bool, lang: Language) -> Section {
    let mut table = Table::new(&[
        (&lang.title(say!(lang, "parameter")), Align::Left),
        ("u", Align::Decimal),
        (say!(lang, "unit"), Align::Left),
        (say!(lang, "strongest-correlation"), Align::Left),
        (say!(lang, "undetected-fault"), Align::Decimal),
    ]);
    for (k, p) in j.parameters.iter().enumerate() {
        let u = p.u_arcsec.or(p.u);
        let unit = if p.kind == Kind::Tilt { "arcsec".to_string() } else { p.unit.clone() };
        let needs_value = j.lacking.as_ref().is_some_and(|own| own.untold.contains(&p.id));
        let instead = if needs_value { say!(lang, "needs-a-value").into() } else { lang.term("not-estimable") };
        let fault = p.u.and(p.undetected_fault_arcsec.or(p.undetected_fault));
        table.row(vec![
            Cell::name(&p.id),
            u.map_or_else(|| instead.as_str().into(), |u| Cell::Digits(u, 3)),
            unit.into(),
            strongest(j, k).unwrap_or_default().into(),
            predicted(fault),
        ]);
    }
    for d in &j.derived {
        let unit = if d.u_arcsec.is_some() { "arcsec" } else { d.unit.as_str() };
        let note = if d.is_largest { say!(lang, "largest-near-the-reference") } else { "" };
        table.row(vec![Cell::name(&d.id), predicted(d.u_arcsec.or(d.u)), unit.into(), note.into(), "".into()]);
    }
    let w = &j.work;
    let rank = say!(lang, "plan-rank", rank = j.rank.to_string(), dof = lang.count(j.dof, "degree"));
    let mut clauses = vec![work_of(w, lang), rank];
    clauses.extend((j.unchecked > 0).then(|| say!(lang, "values-checked-by-no-other", n = j.unchecked)));
    let work = lang.sentence(&clauses.join(lang.semicolon()));
    let mut notes = Vec::new();
    notes.extend(j.drift.map(|d| say!(lang, "in-this-order-a-drift-of-one", share = significant(d, 2))));
    if j.effects.is_none() && w.readings > 0 {
        notes.push(lang.sentence(say!(lang, "so-many-values-what-a-diagnosis-could")));
    }
    if j.bounds_not_counted > 0 {
        notes.push(lang.sentence(&say!(lang, "bounds-not-counted", n = j.bounds_not_counted)));
    }
    let through = j.through_tilts.as_ref().map(|t| lang.sentence(&through_tilts(t, lang))).unwrap_or_default();
    let (tone, verdict) = match j.not_estimable.len() {
        0 if j.lacking.is_some() => (Tone::Caution, say!(lang, "not-every-unknown-has-a-predicted-uncertainty").into()),
        0 => (Tone::Good, say!(lang, "every-unknown-can-be-estimated").into()),
        n => (Tone::Bad, say!(lang, "combinations-cannot-be-estimated", n)),
    };
    let section = if beside { Section::new(heading).full() } else { Section::new(heading) };
    section
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
        .list(notes)
}

/// The strongest correlation of a parameter says more than a matrix; the matrix is in the JSON.
fn strongest(j: &JudgementReport, k: usize) -> Option<String> {
    let row = j.correlation.matrix.get(k)?;
    let others = row.iter().enumerate().filter(|(other, _)| *other != k).filter_map(|(k, r)| r.map(|r| (k, r)));
    let (other, r) = others.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let partner = j.correlation.order.get(other)?;
    (r.abs() >= 0.005).then(|| format!("{partner} {r:+.2}"))
}

/// What each reading contributes.
fn readings(heading: &str, j: &JudgementReport, listed: bool, lang: Language) -> Section {
    let mut readings = Table::new(&[
        ("#", Align::Right),
        (say!(lang, "position"), Align::Left),
        (say!(lang, "setting"), Align::Left),
        (say!(lang, "sensor"), Align::Left),
        (say!(lang, "leverage"), Align::Decimal),
        (say!(lang, "mdb"), Align::Decimal),
        (say!(lang, "undetected-fault"), Align::Left),
    ]);
    readings.caption = say!(lang, "each-value-leverage-minimal-detectable-bias-and").into();
    readings.small = true;
    for r in &j.readings {
        let worst = r.effect_arcsec.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        let effect = worst.map_or(String::new(), |(id, e)| format!("`{id}` {} arcsec", significant(*e, 3)));
        readings.row(vec![
            r.index.into(),
            r.position.as_str().into(),
            keys(&r.at).into(),
            r.sensor.as_str().into(),
            Cell::Decimals(r.leverage, 3),
            predicted(r.mdb),
            effect.into(),
        ]);
    }
    let section = Section::new(heading);
    if listed { section.table(readings) } else { section.full().table(readings) }
}
