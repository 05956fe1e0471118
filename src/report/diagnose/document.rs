//! The document of a diagnosis: the verdict, what was found and the picture, how the gap shrinks, then what it rests on.

use super::super::colophon::begin;
use super::super::fit_document::bench_figure;
use super::super::scatter;
use super::figure::{diagnose_figure, named};
use super::{DiagnoseReport, EffectReport, words};
use crate::campaign::{Campaign, Parameter, Role};
use crate::diagnosis::{Diagnosis, Held, Verdict};
use crate::document::number::{level, rounded, significant};
use crate::document::{Align, Cell, Content, Detail, Document, MarkedLine, Section, Table, Tone};
use crate::language::{Language, say};

/// More aliases, levels, positions and steps than this are not listed; the JSON report has all.
const LISTED: usize = 24;
/// Levels that a terminal lists.
const BRIEF: usize = 8;

/// The document of a diagnosis; what was asked, and the diagnosis itself, give the picture and what was taken for granted.
pub fn diagnose_document(report: &DiagnoseReport, of: Option<(&Campaign, &Diagnosis)>, lang: Language) -> Document {
    let mut document = begin(say!(lang, "diagnosis-of", title = report.bench), &report.inputs, lang);
    document.subtitle = of.map_or_else(String::new, |(campaign, _)| lang.name(&campaign.bench.title).into_owned());
    document.facts = report.identity.facts(lang);
    let missing = Section::new(say!(lang, "what-is-missing"));
    let missing = report.effects.iter().fold(missing, |section, effect| section.block(card(report, effect, lang)));
    let document = document.section(result(report, of, lang)).section(shrinking(report, lang));
    let document = document.section(missing).section(pattern(report, lang));
    let (where_, model) = (places(report, lang), model(report, lang));
    // where nothing explains the gap, its places are all that is known of it
    let [next, last] = if report.effects.is_empty() { [where_, model] } else { [model, where_] };
    document
        .section(next)
        .section(scatter::section(&report.scatter, lang))
        .section(changes(report, lang))
        .section(last)
        .section(assumptions(report, of, lang))
}

/// The verdict, what was found, and the picture.
fn result(report: &DiagnoseReport, of: Option<(&Campaign, &Diagnosis)>, lang: Language) -> Section {
    let verdict = lang.sentence(&words::verdict(report, lang));
    let mut section = Section::new(say!(lang, "result")).verdict(words::tone(report.verdict), verdict);
    if report.verdict == Verdict::NotDiagnosable {
        return section.prose(lang.sentence(&words::would_help(report, lang)));
    }
    if let Some(own) = &report.unexplained {
        section = section
            .prose(lang.sentence(&lang.name(&own.pattern)))
            .prose(lang.sentence(&words::remainder(report, lang)))
            .prose(words::nearest(&own.nearest, own.nearest_explains, lang));
    }
    section.table(effects(report, lang)).figures(
        of.map(|(campaign, diagnosis)| diagnose_figure(campaign, diagnosis, report, lang)).into_iter().collect(),
    )
}

/// What was found, an effect a row.
fn effects(report: &DiagnoseReport, lang: Language) -> Table {
    let several = report.model_before.len() > 1;
    let found = report.effects.iter().map(|effect| {
        let (scale, unit) = words::scale(effect);
        words::Found {
            regressor: &effect.regressor,
            quantity: words::of(effect, lang),
            sensor: effect.sensor.as_deref().filter(|_| several).unwrap_or_default(),
            value: effect.value.map(|value| value * scale),
            u: effect.u.map(|u| u * scale),
            expanded: effect.expanded.map(|u| u * scale),
            unit,
            t: effect.t,
            p: effect.p,
            explains: effect.explains,
        }
    });
    let level = report.effects.first().map_or(String::new(), |effect| level(effect.level));
    // U stands for u
    words::found(found, &format!("U ({level})"), lang).at(Detail::Full, &[4])
}

/// The gap as given and after each effect, then each sensor's.
fn shrinking(report: &DiagnoseReport, lang: Language) -> Section {
    let section = Section::new(say!(lang, "the-gap"));
    if report.verdict == Verdict::NotDiagnosable {
        return section;
    }
    let several = report.gap.sensors.len() > 1;
    let one = report.gap.sensors.values().next().filter(|_| !several);
    let with_unit = |what: &str| one.map_or(what.to_string(), |own| in_unit(what, &own.unit));
    let (sd, max) = (with_unit(say!(lang, "residual-sd")), with_unit(say!(lang, "max")));
    let mut table = Table::new(&[
        (say!(lang, "in-the-model"), Align::Left),
        (&sd, Align::Decimal),
        (&max, Align::Decimal),
        (say!(lang, "chi-square"), Align::Decimal),
        (say!(lang, "dof"), Align::Right),
        (say!(lang, "p-of-what-is-left"), Align::Right),
        (say!(lang, "strongest-further-candidate"), Align::Left),
        ("t", Align::Decimal),
        ("p", Align::Right),
    ])
    .at(Detail::Full, &[6, 7, 8]);
    let tested = report.steps.iter().any(|step| step.global_p.is_some());
    let of_one = |cell: Cell| if several { "".into() } else { cell };
    for step in report.steps.iter().take(LISTED) {
        let with = step.with.last().map_or(say!(lang, "as-given").into(), |last| format!("+ `{last}`"));
        table.row(vec![
            with.into(),
            of_one(Cell::digits(step.gap.rms, 4)),
            of_one(Cell::Digits(step.gap.max, 4)),
            Cell::Digits(step.gap.chi_square, 4),
            step.gap.dof.into(),
            if tested { Cell::p(step.global_p) } else { "".into() },
            step.strongest.as_ref().map_or_else(Cell::absent, Cell::name),
            Cell::decimals(step.t, 1),
            Cell::p(step.p),
        ]);
    }
    let decision = report.steps.last().map_or(String::new(), |step| lang.sentence(&lang.name(&step.decision)));
    let sd = one.map(|own| own.sd.map_or(say!(lang, "unknown").into(), |sd| in_text(&significant(sd, 3), &own.unit)));
    let source = words::noise_source(report.gap.noise.from, lang).to_string();
    let noise = sd.into_iter().chain([source]).collect::<Vec<_>>().join(lang.clause());
    section
        .table(table)
        .prose(decision)
        .table(if several { sensors(report, lang) } else { Table::default() })
        .prose(lang.sentence(&say!(lang, "noise-floor", noise)))
        .prose(lang.sentence(&words::tried(report, lang)))
        .prose(lang.sentence(&words::holdout(report, lang)))
}

/// Each sensor's gap.
fn sensors(report: &DiagnoseReport, lang: Language) -> Table {
    let found = !report.effects.is_empty();
    let (sd, max) = (say!(lang, "residual-sd"), say!(lang, "max"));
    let at = |what: &str, when| if found { words::at(what, when, lang) } else { what.to_string() };
    let mut table = Table::new(&[
        (say!(lang, "sensor"), Align::Left),
        (say!(lang, "unit"), Align::Left),
        (say!(lang, "noise-sd"), Align::Decimal),
        (&at(sd, "before"), Align::Decimal),
        (&at(max, "before"), Align::Decimal),
        (&at(sd, "after"), Align::Decimal),
        (&at(max, "after"), Align::Decimal),
    ]);
    for (id, own) in &report.gap.sensors {
        let after = |cell: Cell| if found { cell } else { "".into() };
        table.row(vec![
            Cell::name(id),
            own.unit.as_str().into(),
            Cell::digits(own.sd, 3),
            Cell::digits(own.rms_before, 4),
            Cell::Digits(own.max_before, 4),
            after(Cell::digits(own.rms_after, 4)),
            after(Cell::Digits(own.max_after, 4)),
        ]);
    }
    table
}

/// What is to be known of an effect beside its size.
fn card(report: &DiagnoseReport, effect: &EffectReport, lang: Language) -> Content {
    let mut facts: Vec<(String, String)> = Vec::new();
    let mut fact = |name: &str, text: String| {
        if !text.is_empty() {
            facts.push((name.to_string(), text));
        }
    };
    if effect.value.is_none() {
        fact(&lang.title(say!(lang, "value")), lang.term("not-estimable"));
    }
    if report.model_before.len() > 1 && effect.sensor.is_none() && effect.in_sensors.is_empty() {
        fact(&lang.title(say!(lang, "sensor")), say!(lang, "all").into());
    }
    for own in &effect.in_sensors {
        let value = own.value.map_or_else(|| lang.term("not-estimable"), |v| in_text(&rounded(v, own.u), &own.unit));
        let u = own.u.map_or(String::new(), |u| format!(", u = {}", rounded(u, Some(u))));
        let name = format!("`{}`", own.sensor);
        fact(&name, format!("`{}` = {value}{u}, t = {:.1}", own.coefficient, own.t));
    }
    fact(&lang.title(&lang.term("stated")), words::against_stated(effect, lang));
    fact(&lang.title(say!(lang, "probability")), words::probability(effect, lang));
    let aliases = words::aliases(effect, lang);
    let listed = |names: &[String]| words::listed(names, LISTED, lang);
    fact(&lang.title(say!(lang, "cannot-be-distinguished-from")), listed(&aliases.same));
    fact(say!(lang, "fits-not-significantly-worse"), listed(&aliases.near));
    fact(say!(lang, "only-through-small-terms"), listed(&aliases.small));
    fact(say!(lang, "discriminated-by"), words::separating(effect, lang));
    fact(say!(lang, "no-position-of-this-bench-tells-it"), listed(&effect.separate_never));
    fact(&lang.title(say!(lang, "probable-cause")), lang.name(&effect.why).into_owned());
    fact(say!(lang, "to-confirm"), lang.name(&effect.confirm).into_owned());
    let heading = say!(lang, "effect-named", name = lang.name(&effect.name), regressor = effect.regressor);
    // a heading is no sentence: it has no full stop
    let heading = lang.sentence(&heading).trim_end_matches(['.', '\u{3002}']).to_string();
    Content::Card { heading, tone: Tone::Bad, facts }
}

/// Mean residuals at the states of the joints, where something is unexplained.
fn pattern(report: &DiagnoseReport, lang: Language) -> Section {
    let cells = report.unexplained.iter().flat_map(|own| &own.cells).take(LISTED);
    let rows = cells.map(|own| (words::position(&own.at), own.sensor.clone(), own.readings, own.mean, own.z, None));
    let mut table = means(rows.collect(), lang);
    table.note = say!(lang, "mean-residual-at-each-state-of-the").into();
    table.brief_rows = Some(2 * BRIEF);
    Section::new(say!(lang, "the-pattern")).table(table)
}

/// A mean residual: its setting, sensor, readings, size, size in standard deviations, and probability.
type Mean = (String, String, usize, f64, f64, Option<f64>);

/// Mean residuals, with bars as long as they are significant.
fn means(rows: Vec<Mean>, lang: Language) -> Table {
    let mut table = Table::new(&[
        (say!(lang, "setting"), Align::Left),
        (say!(lang, "sensor"), Align::Left),
        (say!(lang, "readings").to_lowercase().as_str(), Align::Right),
        (say!(lang, "mean"), Align::Decimal),
        ("", Align::Bar),
        ("z", Align::Decimal),
        ("p", Align::Right),
    ])
    .at(Detail::Full, &[4]);
    let largest = rows.iter().fold(0.0_f64, |most, own| most.max(own.4.abs()));
    table.small = rows.len() > 12;
    for (setting, sensor, readings, mean, z, p) in rows {
        table.row(vec![
            setting.into(),
            Cell::name(sensor),
            readings.into(),
            Cell::Digits(mean, 3),
            (z / largest).to_string().into(),
            Cell::Decimals(z, 1),
            p.map_or("".into(), Cell::Probability),
        ]);
    }
    table
}

/// Model lines, with what was appended marked, and what else the repair does.
fn model(report: &DiagnoseReport, lang: Language) -> Section {
    let line = |id: &str, kept: &str, added: &str| MarkedLine { kept: format!("{id} = {kept}"), added: added.into() };
    let before: Vec<MarkedLine> = report.model_before.iter().map(|(id, own)| line(id, own, "")).collect();
    let changed: Vec<MarkedLine> = report
        .model_after
        .iter()
        .filter_map(|(id, after)| {
            let (kept, added) = words::appended(report.model_before.get(id)?, after)?;
            Some(line(id, kept, added))
        })
        .collect();
    let mut repairs: Vec<String> = report.effects.iter().filter_map(|effect| words::repair(effect, lang)).collect();
    if changed.is_empty() {
        let own = report.effects.iter().filter(|e| !e.regressor.contains(':') && !e.coefficient.is_empty());
        repairs.extend(own.map(|e| say!(lang, "is-now-estimated", id = format!("`{}`", e.coefficient), was = "tilt")));
    }
    let section = Section::new(say!(lang, "model"))
        .prose(format!("{}{}", lang.title(say!(lang, "as-given")), lang.colon().trim_end()))
        .block(Content::Marked(before));
    let section = match changed.is_empty() {
        true => section,
        false => section
            .prose(format!("{}{}", lang.title(say!(lang, "with-what-was-found")), lang.colon().trim_end()))
            .block(Content::Marked(changed)),
    };
    section.list(repairs.iter().map(|text| lang.sentence(text)).collect())
}

/// Each parameter before and after.
fn changes(report: &DiagnoseReport, lang: Language) -> Section {
    let mut table = Table::new(&[
        (say!(lang, "parameter"), Align::Left),
        (say!(lang, "before"), Align::Decimal),
        ("u", Align::Decimal),
        (say!(lang, "after"), Align::Decimal),
        ("u", Align::Decimal),
        (say!(lang, "shift"), Align::Decimal),
        (say!(lang, "shift-u"), Align::Decimal),
        (say!(lang, "unit"), Align::Left),
    ])
    .at(Detail::Roomy, &[5]);
    for p in &report.parameters {
        table.row(vec![
            Cell::name(&p.id),
            Cell::value(p.before, p.u_before),
            Cell::value(p.u_before, p.u_before),
            Cell::value(p.after, p.u_after),
            Cell::value(p.u_after, p.u_after),
            Cell::value(p.shift, p.u_after_as_named),
            p.change_in_u.map_or_else(Cell::absent, |s| words::in_u(s).into()),
            p.unit.as_str().into(),
        ]);
        table.tone(if p.change_in_u.is_some_and(|s| s.abs() > 2.0) { Tone::Caution } else { Tone::Plain });
    }
    table.note = say!(lang, "marked-shifts-of-more-than-twice-their").into();
    let section = Section::new(say!(lang, "what-it-does-to-the-estimates"));
    let differs = report.parameters.iter().any(|p| p.shift.is_some_and(|s| s != 0.0) || p.remainder_u > 0.0);
    let section = if differs { section } else { section.full() };
    section.table(table).prose(words::after_u(report, lang))
}

/// Levels of factors with a significant mean residual.
fn places(report: &DiagnoseReport, lang: Language) -> Section {
    let section = Section::new(say!(lang, "where-the-gap-is"));
    if report.verdict == Verdict::NothingMissing {
        return section;
    }
    let shown = report.places.iter().filter(|place| place.significant == Some(true)).take(LISTED);
    let row = |own: &super::PlaceReport| {
        let setting = format!("{} {}", named(&own.factor, lang), words::level(&own.level));
        (setting, own.sensor.clone(), own.readings, own.mean, own.z, Some(own.p))
    };
    let mut table = means(shown.map(row).collect(), lang);
    table.brief_rows = Some(BRIEF);
    table.note = say!(lang, "means-of-the-residuals-with-the-model").into();
    section.table(table)
}

/// What was taken for granted, and where it comes from.
fn assumptions(report: &DiagnoseReport, of: Option<(&Campaign, &Diagnosis)>, lang: Language) -> Section {
    let mut points = Vec::new();
    if !report.assumed_zero.is_empty() {
        let assumed_zero = lang.names(&report.assumed_zero);
        points.push(say!(lang, "taken-as-zero-neither-known-nor-estimated", assumed_zero));
    }
    let mut facts = Vec::new();
    if let Some((campaign, diagnosis)) = of {
        let known = campaign.parameters.iter().filter_map(|p| match &p.role {
            Role::Known(known) => {
                let u = if known.u > 0.0 { format!(", u = {}", significant(known.u, 3)) } else { String::new() };
                Some(format!("`{}` = {}{u}", p.id, in_text(&known.value.to_string(), &p.unit)))
            }
            _ => None,
        });
        let known: Vec<String> = known.collect();
        if !known.is_empty() {
            points.push(say!(lang, "taken-as-known", known = known.join("; ")));
        }
        let prior = |p: &&Parameter| matches!(p.role, Role::Estimated { prior: Some(_), .. });
        let priors: Vec<&str> = campaign.estimated().iter().filter(prior).map(|p| p.id.as_str()).collect();
        if !priors.is_empty() {
            points.push(say!(lang, "priors-entered-as-rows-of-their-own", priors = lang.names(&priors)));
        }
        if diagnosis.before.convergence.is_none() {
            points.push(say!(lang, "gauss-newton-does-not-converge-here-so").into());
        }
        let source = Some(lang.name(&campaign.bench.source).into_owned()).filter(|source| !source.is_empty());
        facts.extend(source.map(|source| (lang.title(say!(lang, "source")), source)));
    }
    facts.extend(report.inputs.first().map(|input| (lang.title(say!(lang, "campaign")), input.name.clone())));
    let constraints = |is_kept: bool| {
        let own = report.constraints.iter();
        own.filter(|c| matches!(c.state, Held::Equality | Held::Inactive) == is_kept)
            .map(|c| lang.sentence(&words::constraint(c, lang)))
            .collect::<Vec<_>>()
    };
    let section = Section::new(say!(lang, "what-was-assumed"));
    let section = section.list(constraints(false)).full().list(constraints(true)).list(points);
    let section = if facts.is_empty() { section } else { section.block(Content::Facts(facts)) };
    section.figures(bench_figure(of.map(|(campaign, _)| campaign), lang))
}

/// A title with the unit of its numbers.
fn in_unit(what: &str, unit: &str) -> String {
    if unit.is_empty() { what.into() } else { format!("{what}, {unit}") }
}

/// A number with its unit, in a sentence.
fn in_text(number: &str, unit: &str) -> String {
    format!("{number} {unit}").trim_end().into()
}
