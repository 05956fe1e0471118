//! The document of a plan: the better schedule beside the given one, where its positions lie, and what each reading contributes; how the better one was
//! found, how good it is, and why each of its positions is there.

use super::fit_document::{bench_figure, model_facts};
use super::provenance::begin;
use super::separation::NotEstimableReport;
use super::{ARCSEC, DiscriminationReport, Effort, FindReport, ImprovedReport, JudgementReport, PlanReport};
use super::{PlannedPositionReport, PointReport, PositionReport, SharedReport, foresight};
use crate::campaign::{Campaign, Kind, Readings};
use crate::document::chart::{Chart, Spot};
use crate::document::number::significant;
use crate::document::{Cell, Document, Figure, Rows, Section, Tone};
use crate::elements::Parts;
use crate::language::{Language, code, say};
use crate::number;
use crate::plan::{GoalOutcome, Lacking, PointSource, ThroughTilts, Work};
use std::collections::BTreeMap;

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
    let nothing = report.improved.as_ref().and_then(|improved| not_told_apart(improved, lang));
    let improved = report.improved.as_ref().filter(|_| nothing.is_none());
    let mut document = begin(say!(lang, "plan-of", title), &[], lang)
        .fact(say!(lang, "bench"), code(&report.bench))
        .fact(say!(lang, "judged-at-2"), judged_at(&report.judged_at, lang))
        .section(Section::new(say!(lang, "result")).verdicts(nothing.map(|nothing| (Tone::Bad, nothing))));
    if let Some(improved) = improved {
        document = document.section(answer(improved, &report.finds, lang)).section(order(improved, lang));
    }
    document = document
        .section(judged(say!(lang, "the-given-schedule"), &report.schedule, improved.is_some(), lang))
        .section(drawn.map(|(campaign, candidates)| map(campaign, report, candidates, lang)).unwrap_or_default());
    if let Some(improved) = improved {
        let heading = say!(lang, "the-better-schedule-in-full");
        document = document.section(judged(heading, &improved.judgement, true, lang));
    }
    let last = improved.map_or(&report.schedule, |improved| &improved.judgement);
    document
        .section(readings(last, listed, lang))
        .section(last.effects.as_ref().map(|effects| foresight::section(effects, lang)).unwrap_or_default())
        .section(model(report, drawn.map(|(campaign, _)| campaign), lang))
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
    let section = Section::new(say!(lang, "model-and-noise")).list(report.remount.iter().map(remount));
    section.facts(facts).full().figures(bench_figure(campaign, lang))
}

fn keys(position: &BTreeMap<String, f64>) -> String {
    position.iter().map(|(key, value)| format!("{key} = {value}")).collect::<Vec<_>>().join(", ")
}

fn answer(improved: &ImprovedReport, finds: &[FindReport], lang: Language) -> Section {
    let goal = improved.goal.as_ref();
    let reached = goal.map(|goal| {
        let Some(share) = goal.largest_share else {
            return (Tone::Bad, say!(lang, "goal-not-determined").to_string());
        };
        let share = significant(share, 3);
        let proof = if goal.is_fewest { say!(lang, "fewer-readings-cannot-reach-it") } else { "" };
        let tone = if goal.reached { Tone::Good } else { Tone::Bad };
        (tone, say!(lang, "goal-reached", reached = goal.reached, share, proof))
    });
    let impossible = goal.into_iter().flat_map(|goal| &goal.impossible).map(|id| {
        let text = say!(lang, "cannot-be-determined-by-any-choice", text = code(id));
        (Tone::Bad, lang.sentence(&text))
    });
    let proven = improved.search.efficiency.zip(proof(improved, lang)).map(|(efficiency, proof)| {
        let is_good = efficiency >= 0.99 && improved.unreachable.is_empty();
        (if is_good { Tone::Good } else { Tone::Plain }, lang.sentence(&proof))
    });
    let what = |text: String| say!(lang, "cannot-be-determined-by-any-choice", text);
    let defects = defects(&improved.unreachable, what, &nowhere(&improved.frozen, lang), lang);
    let defects = defects.into_iter().map(|text| (Tone::Bad, text));
    let limit = improved.search.cost_limit.map(|limit| cost_limit(improved, limit, lang));
    let said =
        shortfall(improved, lang).filter(|_| proven.is_some()).into_iter().chain(moved(improved, lang)).chain(limit);
    let said = said.chain(finds.iter().map(|find| found_with(find, improved, lang))).map(|said| lang.sentence(&said));
    let to_run = (improved.to_run != improved.judgement.work).then(|| work_of(&improved.to_run, lang));
    let apart = improved.separation.iter().flat_map(|separation| {
        let tone = if separation.after.iter().all(Option::is_some) { Tone::Good } else { Tone::Bad };
        apart(separation, lang).into_iter().map(move |line| (tone, line))
    });
    let cost = improved.effort == Effort::Cost;
    let table = Rows::of(&improved.comparison)
        .name(lang.title(say!(lang, "parameter")), |c| &c.id)
        .decimal(say!(lang, "as-given"), |c| Cell::digits(c.given, 3))
        .decimal(say!(lang, "u-at-equal-effort", cost), |c| Cell::digits(c.equal_effort, 3))
        .decimal(say!(lang, "better"), |c| Cell::digits(c.better, 3))
        .decimal(say!(lang, "gain"), |c| Cell::decimals(c.gain, 2))
        .left(say!(lang, "unit"), |c| &c.unit)
        .caption(say!(lang, "predicted-standard-uncertainties"))
        .note(say!(lang, "at-equal-effort", cost));
    let mut notes = shared(&improved.shared, lang);
    if !improved.frozen.is_empty() && improved.unreachable.is_empty() {
        notes.push(say!(lang, "planned-with-columns", held = keys(&improved.frozen)));
    }
    Section::new(say!(lang, "the-better-schedule-2"))
        .prose(lang.sentence(&work_of(&improved.judgement.work, lang)))
        .verdicts(reached)
        .proses(goal.into_iter().flat_map(|goal| goal_notes(improved, goal, lang)).map(|note| lang.sentence(&note)))
        .verdicts(impossible)
        .verdicts(defects)
        .verdicts(proven)
        .proses(said)
        .proses(to_run.map(|work| say!(lang, "still-to-run-2", work)))
        .verdicts(apart)
        .table(table)
        .list(notes)
        .full()
        .prose(lang.sentence(&chosen(improved, lang)))
}

fn chosen(improved: &ImprovedReport, lang: Language) -> String {
    let starts = match improved.search.enumerated {
        Some(_) => String::new(),
        None => {
            let [hits, starts] = [improved.search.hits, improved.search.starts].map(|n| n.to_string());
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
        let clauses = [Some(what(code(&d.text))), d.instead(lang), Some(separated(d))];
        lang.sentence(&clauses.into_iter().flatten().collect::<Vec<_>>().join(lang.semicolon()))
    };
    list.iter().map(clauses).collect()
}

fn order(improved: &ImprovedReport, lang: Language) -> Section {
    let rows = mountings(&improved.positions);
    let before = std::iter::once(None).chain(rows.iter().map(|(label, _)| Some(label)));
    let table = Rows::of(rows.iter().zip(before))
        .left(say!(lang, "mounting"), |((label, _), _)| label)
        .left(say!(lang, "setting"), |((_, place), _)| place)
        .left(say!(lang, "reason"), |((label, _), before)| {
            reason(improved, label, lang).filter(|_| before != Some(label)).unwrap_or_default()
        });
    Section::new(say!(lang, "to-run-in-this-order")).table(table.small())
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
    section.figures([Figure { caption: caption.into(), description, chart, wide: false }])
}

/// A schedule judged; where a better one stands before it, a terminal leaves it out.
fn judged(heading: &str, j: &JudgementReport, is_second: bool, lang: Language) -> Section {
    let mut rows: Vec<(&str, Cell, &str, String, Cell)> = Vec::new();
    for (k, p) in j.parameters.iter().enumerate() {
        let unit = if p.kind == Kind::Tilt { "arcsec" } else { &p.unit };
        let needs_value = j.lacking.as_ref().is_some_and(|lacking| lacking.untold.contains(&p.id));
        let instead = if needs_value { say!(lang, "needs-a-value").into() } else { lang.term("not-estimable") };
        let u = p.u_arcsec.or(p.u).map_or(Cell::Text(instead), |u| Cell::Digits(u, 3));
        let fault = p.u.and(p.undetected_fault_arcsec.or(p.undetected_fault));
        rows.push((&p.id, u, unit, strongest(j, k).unwrap_or_default(), Cell::digits(fault, 3)));
    }
    for d in &j.derived {
        let unit = if d.u_arcsec.is_some() { "arcsec" } else { d.unit.as_str() };
        let note = if d.is_largest { say!(lang, "largest-near-the-reference") } else { "" };
        // all that it is made of is estimable, but not where it is judged
        let estimable = |name: &str| j.parameters.iter().all(|p| p.id != name || p.u.is_some());
        let names = crate::algebra::Expression::parse(&d.line)
            .map_or(Vec::new(), |line| line.names().iter().map(|n| n.to_string()).collect());
        let u = match d.u_arcsec.or(d.u) {
            None if names.iter().all(|name| estimable(name)) => Cell::Text(say!(lang, "needs-a-value").into()),
            u => Cell::digits(u, 3),
        };
        rows.push((&d.id, u, unit, note.into(), "".into()));
    }
    let table = Rows::of(&rows)
        .name(lang.title(say!(lang, "parameter")), |(id, ..)| id)
        .decimal("u", |(_, u, ..)| u.clone())
        .left(say!(lang, "unit"), |(_, _, unit, ..)| *unit)
        .left(say!(lang, "strongest-correlation"), |(.., strongest, _)| strongest)
        .decimal(say!(lang, "undetected-fault"), |(.., fault)| fault.clone());
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
    let verdict = match j.not_estimable.len() {
        0 if j.lacking.is_some() => (Tone::Caution, say!(lang, "not-every-unknown-has-a-predicted-uncertainty").into()),
        0 => (Tone::Good, say!(lang, "every-unknown-can-be-estimated").into()),
        n => (Tone::Bad, say!(lang, "combinations-cannot-be-estimated", n)),
    };
    let what = |text| say!(lang, "is-not-estimable", text);
    let further =
        [j.through_tilts.as_ref().map(|t| through_tilts(t, lang)), j.lacking.as_ref().map(|l| lacking(l, lang))];
    Section::new(heading)
        .full_unless(!is_second)
        .verdicts([verdict])
        .prose(work)
        .proses(further.into_iter().flatten().map(|said| lang.sentence(&said)))
        .list(defects(&j.not_estimable, what, &nowhere(&BTreeMap::new(), lang), lang))
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

fn readings(j: &JudgementReport, listed: bool, lang: Language) -> Section {
    let table = Rows::of(&j.readings)
        .right("#", |r| r.index)
        .left(say!(lang, "position"), |r| &r.position)
        .left(say!(lang, "setting"), |r| keys(&r.at))
        .left(say!(lang, "sensor"), |r| &r.sensor)
        .decimal(say!(lang, "leverage"), |r| Cell::Decimals(r.leverage, 3))
        .decimal(say!(lang, "mdb"), |r| Cell::digits(r.mdb, 3))
        .left(say!(lang, "undetected-fault"), |r| {
            let worst = r.effect_arcsec.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
            worst.map_or(String::new(), |(id, e)| format!("`{id}` {} arcsec", significant(*e, 3)))
        })
        .caption(say!(lang, "each-value-leverage-minimal-detectable-bias-and"))
        .small();
    Section::new(say!(lang, "readings")).full_unless(listed).table(table)
}

/// The positions of a schedule, one line for each mounting: its label, and its keys; the key that changes within it has several values.
fn mountings(positions: &[PlannedPositionReport]) -> Vec<(String, String)> {
    let mut lines: Vec<(String, String)> = Vec::new();
    let mut remaining = positions;
    while let Some(first) = remaining.first() {
        // the longest run with this label in which only one key changes
        let mut changing: Option<&str> = None;
        let belongs = |other: &&PlannedPositionReport| {
            let same_keys =
                other.at.keys().eq(first.at.keys()) && other.position == first.position && other.levels == first.levels;
            let mut different = first.at.iter().filter(|(k, v)| other.at.get(*k) != Some(v)).map(|(k, _)| k.as_str());
            let one = different.next();
            let alone = different.next().is_none() && (one.is_none() || changing.is_none() || changing == one);
            changing = changing.or(one.filter(|_| same_keys && alone));
            same_keys && alone
        };
        let length = 1 + remaining.part(1..).iter().take_while(belongs).count();
        let (run, left) = remaining.split_at(length);
        let part = |(key, value): (&String, &f64)| match changing {
            Some(known) if known == key => {
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
        remaining = left;
    }
    lines
}

/// Values in order, four and more of one in a row as `40 × 4`.
fn runs<'a>(values: impl Iterator<Item = &'a f64>) -> String {
    let values: Vec<f64> = values.copied().collect();
    let text = |run: &[f64]| match (run.first()?, run.len()) {
        (value, count @ 1..=3) => Some(vec![value.to_string(); count].join(", ")),
        (value, count) => Some(format!("{value}\u{a0}\u{d7}\u{a0}{count}")),
    };
    values.chunk_by(|a, b| a == b).filter_map(text).collect::<Vec<_>>().join(", ")
}

/// How good the choice is proven to be.
fn proof(improved: &ImprovedReport, lang: Language) -> Option<String> {
    if let Some(all) = improved.search.enumerated {
        return Some(say!(lang, "best-of-all-choices", all = all.to_string()));
    }
    Some(say!(lang, "proven-efficiency", share = percent(improved.search.efficiency?)))
}

/// What moving the angles between the candidates brought.
fn moved(improved: &ImprovedReport, lang: Language) -> Option<String> {
    let refined = improved.search.refined.as_ref()?;
    let resolution = significant(refined.resolution_deg, 3);
    if refined.moved == 0 {
        return Some(say!(lang, "no-angle-is-worth-moving", resolution));
    }
    let (mountings, gain) = (refined.moved.to_string(), significant(100.0 * refined.gain, 2));
    Some(say!(lang, "angles-moved", finished = refined.finished, mountings, resolution, gain))
}

/// Why the efficiency is below 0.99: the bound, or the few portions.
fn shortfall(improved: &ImprovedReport, lang: Language) -> Option<String> {
    let (efficiency, gap) = (improved.search.efficiency?, improved.search.bound_gap?);
    let short = 1.0 - efficiency;
    (short > 0.01).then(|| match gap < 0.1 * short {
        true if improved.search.cost_limit.is_some() => say!(lang, "the-bound-allows-more-mountings-than-the").into(),
        true => say!(lang, "so-few-portions-cannot-follow-the-best").into(),
        false => say!(lang, "the-bound-itself-may-be-too-high", gap = significant(gap, 2)),
    })
}

/// The limit of the cost, and where it comes from.
fn cost_limit(improved: &ImprovedReport, limit: f64, lang: Language) -> String {
    say!(lang, "cost-limit-of-the-search", budget = improved.budget.is_some(), cost = significant(limit, 4))
}

/// Why a mounting is there, in words.
fn reason(improved: &ImprovedReport, label: &str, lang: Language) -> Option<String> {
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
fn apart(separation: &DiscriminationReport, lang: Language) -> Vec<String> {
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
fn found_with(find: &FindReport, improved: &ImprovedReport, lang: Language) -> String {
    let unit = improved.comparison.iter().find(|own| own.id == find.coefficient).map_or("", |own| own.unit.as_str());
    let number = |x: f64| format!("{} {unit}", significant(if unit == "arcsec" { x * ARCSEC } else { x }, 3));
    say!(
        lang,
        "of-is-found-with-probability-where-the",
        effect = find.effect,
        size = number(find.size).trim_end(),
        power = find.power.to_string(),
        coefficient = find.coefficient,
        u = number(find.u).trim_end()
    )
}

/// What a goal counts, and what is known of its cost.
fn goal_notes(improved: &ImprovedReport, goal: &GoalOutcome, lang: Language) -> Vec<String> {
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
fn not_told_apart(improved: &ImprovedReport, lang: Language) -> Option<String> {
    let separation = improved.separation.as_ref()?;
    let [a, b] = &separation.effects;
    let none = separation.after.iter().any(Option::is_none);
    none.then(|| say!(lang, "no-candidate-discriminates", a, b))
}

/// The point at which schedules are judged, in words: values with their source, then what stands at zero.
fn judged_at(point: &[PointReport], lang: Language) -> String {
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
                let from = lang.term(&from.to_string());
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

fn lacking(lacking: &Lacking, lang: Language) -> String {
    let needs = lacking.needs.join(", ");
    let first = lacking.needs.first().map_or("", String::as_str);
    let untold = lacking.untold.join(", ");
    say!(lang, "uncertainty-depends-on-a-value", untold, needs, first)
}

fn work_of(w: &Work, lang: Language) -> String {
    say!(
        lang,
        "in-with-cost",
        readings = lang.count(w.readings, "reading"),
        mountings = w.mountings.to_string(),
        rate_changes = w.rate_changes.to_string(),
        cost = significant(w.cost, 4)
    )
}

/// What known inputs do through the tilts, in one sentence.
fn through_tilts(through: &ThroughTilts, lang: Language) -> String {
    let (u, unit) = match through.u_arcsec {
        Some(arcsec) => (arcsec, " arcsec"),
        None => (through.u, ""),
    };
    let ThroughTilts { known, parameter, tilts_arcsec, counted, .. } = through;
    let (u, tilts) = (significant(u, 2), significant(*tilts_arcsec, 3));
    say!(lang, "uncertainty-through-tilts", counted, tilts, known, u, unit, parameter)
}

/// The levels that chosen positions are planned for, where they share deviations.
fn shared(list: &[SharedReport], lang: Language) -> Vec<String> {
    let sentence = |shared: &SharedReport| {
        let SharedReport { line, column, levels } = shared;
        say!(lang, "positions-share-deviations-planned-for", line, levels = format!("{column} = {}", levels.join(", ")))
    };
    list.iter().map(sentence).collect()
}

/// Why no position separates what is not estimable: none of the bench does, or the candidates hold a column at one value.
fn nowhere(frozen: &BTreeMap<String, f64>, lang: Language) -> String {
    match frozen.is_empty() {
        true => say!(lang, "no-position-of-this-bench-would-separate-2").into(),
        false => say!(lang, "no-candidate-would-separate-it-but-all", held = keys(frozen)),
    }
}
