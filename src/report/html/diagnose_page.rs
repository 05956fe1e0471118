//! The page of a diagnosis: the answer and its picture, what is missing, the repair, and what it rests on.

use super::diagnose_figure::{figure, named};
use super::{Align, MarkedLine, Page, PageBlock, Section, Table, Tone, cells};
use crate::campaign::{Campaign, Role};
use crate::diagnosis::Diagnosis;
use crate::diagnosis::{NoiseFrom, Verdict};
use crate::error::Result;
use crate::language::{Language, say};
use crate::report::colophon::colophon;
use crate::report::diagnose::words;
use crate::report::scatter;
use crate::report::table::significant;
use crate::report::{DiagnoseReport, EffectReport, Input};

/// More levels, positions and steps than this are not listed; the JSON report has all.
const LISTED: usize = 24;

/// The page of a diagnosis; `campaign` is the question, `inputs` are the files that it was made from.
pub fn diagnose_page(
    campaign: &Campaign,
    diagnosis: &Diagnosis,
    report: &DiagnoseReport,
    inputs: &[Input],
    lang: Language,
) -> Result<Page> {
    let bench = &campaign.bench;
    let title = if bench.title.is_empty() { &bench.id } else { &bench.title };
    let mut page = Page::new(lang.name(title).into_owned());
    page.language = lang;
    page.subtitle = say!(lang, "diagnosis-where-the-readings-and-the-model").into();
    page.facts = vec![(say!(lang, "bench").to_string(), format!("`{}`", bench.id))];
    if !bench.source.is_empty() {
        page.facts.push((say!(lang, "source").into(), lang.name(&bench.source).into_owned()));
    }
    page.facts.extend(inputs.first().map(|input| (say!(lang, "campaign").to_string(), input.name.clone())));
    page.facts.extend(campaign.identity.facts(lang));
    page.colophon = colophon(inputs, lang);
    page = page.section(answer(campaign, diagnosis, report, lang)?);
    let mut missing = Section::new(say!(lang, "what-is-missing"));
    for effect in &report.effects {
        missing = missing.block(card(report, effect, lang));
    }
    Ok(page
        .section(missing)
        .section(model(report, lang))
        .section(scatter::section(&report.scatter, lang))
        .section(unexplained(report, lang))
        .section(changes(report, lang))
        .section(places(report, lang))
        .section(search(report, lang))
        .section(assumptions(campaign, diagnosis, report, lang)))
}

/// The face of a verdict, of campaigns and of missions alike.
pub(super) fn tone(verdict: Verdict) -> Tone {
    match verdict {
        Verdict::NothingMissing => Tone::Good,
        Verdict::EffectsFound => Tone::Bad,
        Verdict::PartlyExplained | Verdict::Unexplained | Verdict::NotDiagnosable => Tone::Caution,
    }
}

/// True minus signs before numbers (an exponent keeps its own).
fn minus(text: &str) -> String {
    let text = text.replace(" -", " \u{2212}").replace("= -", "= \u{2212}");
    text.strip_prefix('-').map_or(text.clone(), |size| format!("\u{2212}{size}"))
}

fn answer(campaign: &Campaign, diagnosis: &Diagnosis, report: &DiagnoseReport, lang: Language) -> Result<Section> {
    let section =
        Section::new(say!(lang, "result")).verdict(tone(report.verdict), lang.sentence(&words::verdict(report, lang)));
    if report.verdict == Verdict::NotDiagnosable {
        let help = words::would_help(report, lang);
        return Ok(if help.is_empty() { section } else { section.prose(lang.sentence(&help)) });
    }
    let source = words::noise_source(report.gap.noise.from, lang);
    Ok(section
        .prose(summary(report, lang))
        .figures(vec![figure(campaign, diagnosis, report, lang)?])
        .table(gap(report, lang))
        .prose(say!(lang, "noise-floor-3", source, tried = lang.sentence(&words::tried(report, lang)))))
}

/// The gap before and after, in one sentence; empty where nothing was found.
fn summary(report: &DiagnoseReport, lang: Language) -> String {
    if report.effects.is_empty() {
        return String::new();
    }
    let explained: f64 = report.effects.iter().map(|e| e.explains).sum();
    let gap = match report.gap.sensors.values().next() {
        Some(own) if report.gap.sensors.len() == 1 => {
            let rms = |v: Option<f64>| v.map_or(say!(lang, "unknown").into(), |v| significant(v, 3));
            let [before, after] = [rms(own.rms_before), rms(own.rms_after)];
            say!(lang, "with-what-was-found-the-residual-standard", before, after, unit = own.unit)
        }
        _ => {
            let [before, after] = [&report.gap.before, &report.gap.after].map(|gap| significant(gap.chi_square, 4));
            say!(lang, "with-what-was-found-chi-square-goes", before, after)
        }
    };
    let share = cells::percent(explained);
    let share = match report.effects.len() {
        1 => say!(lang, "it-explains-of-the-gap", share),
        _ => String::new(),
    };
    lang.sentence(&format!("{gap}{share}"))
}

/// Each sensor's gap, and the whole.
fn gap(report: &DiagnoseReport, lang: Language) -> Table {
    let found = !report.effects.is_empty();
    let mut columns = vec![
        (say!(lang, "sensor"), Align::Left),
        (say!(lang, "unit"), Align::Left),
        (say!(lang, "noise-sd"), Align::Decimal),
    ];
    columns.extend([(if found { say!(lang, "sd-before") } else { say!(lang, "residual-sd") }, Align::Decimal)]);
    columns.extend([(if found { say!(lang, "max-before") } else { say!(lang, "max") }, Align::Decimal)]);
    if found {
        columns.extend([(say!(lang, "sd-after"), Align::Decimal), (say!(lang, "max-after"), Align::Decimal)]);
    }
    let mut table = Table::new(&columns);
    for (id, own) in &report.gap.sensors {
        let mut row = vec![format!("`{id}`"), own.unit.clone(), cells::digits(own.sd, 3)];
        row.extend([cells::digits(own.rms_before, 4), significant(own.max_before, 4)]);
        if found {
            row.extend([cells::digits(own.rms_after, 4), significant(own.max_after, 4)]);
        }
        table.row(row);
    }
    let of = |gap: &crate::report::GapReport| {
        let p = gap.p.map_or(String::new(), |p| format!(", {}", words::p_is(p)));
        let (chi_square, dof) = (significant(gap.chi_square, 4), lang.count(gap.dof, "degree"));
        say!(lang, "diagnose-page-with", chi_square, dof, p)
    };
    let before = of(&report.gap.before);
    table.note = match found {
        true => say!(lang, "chi-square-with-what-was-found", before, after = of(&report.gap.after)),
        false => say!(lang, "chi-square-2", before),
    };
    table
}

fn card(report: &DiagnoseReport, effect: &EffectReport, lang: Language) -> PageBlock {
    let mut facts: Vec<(String, String)> = Vec::new();
    let mut fact = |name: &str, text: String| {
        if !text.is_empty() {
            facts.push((name.to_string(), text));
        }
    };
    fact(say!(lang, "regressor"), format!("`{}`", effect.regressor));
    if report.model_before.len() > 1 {
        let all = if effect.regressor.starts_with("tilt:") { say!(lang, "common-to-all") } else { "" };
        fact(say!(lang, "title-sensor"), effect.sensor.as_ref().map_or(all.to_string(), |s| format!("`{s}`")));
    }
    match words::value(effect) {
        Some((value, u, expanded, unit)) => {
            let uncertainty = match (u, expanded) {
                (Some(u), Some(expanded)) => format!(", u = {u}, U = {expanded} ({})", cells::level(effect.level)),
                _ => String::new(),
            };
            let name = if effect.coefficient.is_empty() {
                begun(&words::of(effect, lang), lang)
            } else {
                format!("`{}`", words::of(effect, lang))
            };
            fact(&name, minus(&format!("{value} {unit}{uncertainty}")).replace(" ,", ","));
        }
        None => fact(say!(lang, "title-value"), say!(lang, "the-repaired-model-does-not-determine-it").into()),
    }
    for own in &effect.in_sensors {
        let value = own.value.map_or(say!(lang, "not-determined").into(), |v| crate::report::table::rounded(v, own.u));
        let u = own.u.map_or(String::new(), |u| format!(", u = {}", significant(u, 2)));
        fact(
            &say!(lang, "in-sensor", sensor = own.sensor),
            minus(&format!("{value} {}{u}, t = {:.1}", own.unit, own.t)),
        );
    }
    fact(say!(lang, "stated-2"), words::against_stated(effect, lang));
    let (t, p) = (format!("{:.1}", effect.t), words::p_is(effect.p));
    fact(say!(lang, "evidence"), minus(&say!(lang, "t-among-all-that-was-tried", t, p)));
    fact(say!(lang, "title-probability"), words::probability(effect, lang));
    let share = cells::percent(effect.explains);
    fact(
        say!(lang, "explains"),
        match report.effects.len() {
            1 => say!(lang, "of-the-gap", share),
            _ => say!(lang, "of-the-gap-beyond-the-others", share),
        },
    );
    let aliases = words::aliases(effect, lang);
    fact(say!(lang, "cannot-be-told-from"), cells::names(&aliases.same, lang));
    fact(say!(lang, "fits-not-significantly-worse"), listed(&aliases.near));
    fact(say!(lang, "only-through-small-terms"), listed(&aliases.small));
    fact(say!(lang, "title-one-more-position-would-tell-it"), words::separating(effect, lang, |at| format!("`{at}`")));
    fact(say!(lang, "no-position-of-this-bench-tells-it"), cells::names(&effect.separate_never, lang));
    fact(say!(lang, "why-it-happens"), lang.name(&effect.why).into_owned());
    fact(say!(lang, "to-confirm"), lang.name(&effect.confirm).into_owned());
    PageBlock::Card { heading: begun(&lang.name(&effect.name), lang), tone: Tone::Bad, facts }
}

/// A heading: a capital letter where the language has them, no full stop.
fn begun(text: &str, lang: Language) -> String {
    lang.sentence(text).trim_end_matches(['.', '\u{3002}']).to_string()
}

/// Names in code type, what stands in parentheses after them as it is.
fn listed(names: &[String]) -> String {
    let code = |text: &String| match text.split_once(" (") {
        Some((name, rest)) => format!("`{name}` ({rest}"),
        None => format!("`{text}`"),
    };
    names.iter().map(code).collect::<Vec<_>>().join(", ")
}

/// Model lines, with what was appended marked, and what else the repair does.
fn model(report: &DiagnoseReport, lang: Language) -> Section {
    let mut section = Section::new(say!(lang, "the-model"));
    let line = |id: &str, kept: &str, added: &str| MarkedLine { kept: format!("{id} = {kept}"), added: added.into() };
    let before = report.model_before.iter().map(|(id, own)| line(id, own, ""));
    section = section.prose(say!(lang, "as-given-2")).block(PageBlock::Marked(before.collect()));
    let changed: Vec<MarkedLine> = report
        .model_after
        .iter()
        .filter_map(|(id, after)| {
            let (kept, added) = words::appended(report.model_before.get(id)?, after)?;
            Some(line(id, kept, added))
        })
        .collect();
    if !changed.is_empty() {
        section = section.prose(say!(lang, "with-what-was-found")).block(PageBlock::Marked(changed));
    }
    let mut repairs: Vec<String> = report.effects.iter().filter_map(|effect| words::repair(effect, lang)).collect();
    if report.model_before == report.model_after {
        let own = report.effects.iter().filter(|e| !e.regressor.contains(':') && !e.coefficient.is_empty());
        repairs.extend(own.map(|e| say!(lang, "is-estimated-no-longer-zero", id = format!("`{}`", e.coefficient))));
    }
    section.list(repairs.iter().map(|text| lang.sentence(text)).collect())
}

fn unexplained(report: &DiagnoseReport, lang: Language) -> Section {
    let section = Section::new(say!(lang, "the-pattern"));
    let Some(own) = &report.unexplained else { return section };
    let mut table = Table::new(&[
        (say!(lang, "gap-at"), Align::Left),
        (say!(lang, "sensor"), Align::Left),
        (say!(lang, "readings-2"), Align::Right),
        (say!(lang, "mean-gap"), Align::Decimal),
        ("", Align::Bar),
        (say!(lang, "in-sd"), Align::Decimal),
    ]);
    table.caption = say!(lang, "mean-residual-at-each-state-of-the").into();
    table.small = own.cells.len() > 12;
    let largest = own.cells.iter().take(LISTED).fold(0.0_f64, |m, cell| m.max(cell.z.abs()));
    for cell in own.cells.iter().take(LISTED) {
        table.row(vec![
            words::position(&cell.at),
            format!("`{}`", cell.sensor),
            cell.readings.to_string(),
            significant(cell.mean, 3),
            (cell.z / largest).to_string(),
            format!("{:.1}", cell.z),
        ]);
    }
    let nearest = if own.nearest.is_empty() {
        String::new()
    } else {
        say!(
            lang,
            "nearest-of-the-catalogue-would-take-off-2",
            names = cells::names(&own.nearest, lang),
            share = cells::percent(own.nearest_explains)
        )
    };
    section.prose(lang.sentence(&lang.name(&own.pattern))).prose(nearest).table(table)
}

fn changes(report: &DiagnoseReport, lang: Language) -> Section {
    let mut table = Table::new(&[
        ("", Align::Left),
        (say!(lang, "before-repair"), Align::Decimal),
        ("u", Align::Decimal),
        (say!(lang, "after-repair"), Align::Decimal),
        ("u", Align::Decimal),
        (say!(lang, "repair-shift"), Align::Decimal),
        (say!(lang, "shift-u-2"), Align::Decimal),
        (say!(lang, "unit"), Align::Left),
    ]);
    for p in &report.parameters {
        table.row(vec![
            format!("`{}`", p.id),
            cells::value(p.before, p.u_before),
            cells::value(p.u_before, p.u_before),
            cells::value(p.after, p.u_after),
            cells::value(p.u_after, p.u_after),
            words::shift(p.shift, p.u_after_as_named),
            words::in_u(p.change_in_u),
            p.unit.clone(),
        ]);
        if let Some(row) = table.rows.last_mut().filter(|_| p.change_in_u.is_some_and(|s| s.abs() > 2.0)) {
            row.tone = Tone::Caution;
        }
    }
    let note = words::after_u(report, lang);
    let marked = say!(lang, "marked-shifts-of-more-than-twice-their");
    // a sentence that begins with u would turn it into U, the expanded uncertainty
    table.note = match note.is_empty() {
        true => marked.to_string(),
        false => say!(lang, "in-this-table", note, marked),
    };
    Section::new(say!(lang, "what-it-does-to-the-estimates")).table(table)
}

fn places(report: &DiagnoseReport, lang: Language) -> Section {
    if report.verdict == Verdict::NothingMissing {
        return Section::new(say!(lang, "where-the-gap-is"));
    }
    let mut table = Table::new(&[
        (say!(lang, "factor"), Align::Left),
        (say!(lang, "level"), Align::Left),
        (say!(lang, "sensor"), Align::Left),
        (say!(lang, "readings-2"), Align::Right),
        (say!(lang, "mean-gap"), Align::Decimal),
        ("", Align::Bar),
        (say!(lang, "in-sd"), Align::Decimal),
        (say!(lang, "p-alone"), Align::Right),
    ]);
    let shown: Vec<_> = report.places.iter().filter(|place| place.significant == Some(true)).take(LISTED).collect();
    let largest = shown.iter().fold(0.0_f64, |m, place| m.max(place.z.abs()));
    for place in &shown {
        table.row(vec![
            named(&place.factor, lang),
            words::level(&place.level),
            format!("`{}`", place.sensor),
            place.readings.to_string(),
            significant(place.mean, 3),
            (place.z / largest).to_string(),
            format!("{:.1}", place.z),
            words::p(place.p),
        ]);
    }
    table.small = shown.len() > 12;
    table.note = say!(lang, "means-of-the-residuals-with-the-model").into();
    Section::new(say!(lang, "where-the-gap-is")).table(table)
}

fn search(report: &DiagnoseReport, lang: Language) -> Section {
    let mut table = Table::new(&[
        (say!(lang, "in-the-model"), Align::Left),
        (say!(lang, "model-line"), Align::Left),
        (say!(lang, "residual-sd"), Align::Decimal),
        (say!(lang, "chi-square"), Align::Decimal),
        (say!(lang, "dof"), Align::Right),
        (say!(lang, "strongest-further-candidate"), Align::Left),
        ("t", Align::Decimal),
        ("p", Align::Right),
        (say!(lang, "p-of-what-is-left"), Align::Right),
    ]);
    let several = report.gap.sensors.len() > 1;
    for step in report.steps.iter().take(LISTED) {
        let with = step.with.last().map_or(say!(lang, "as-given").into(), |last| format!("+ `{last}`"));
        let lines: Vec<String> = step
            .model
            .iter()
            .filter(|(id, line)| !several || report.model_before.get(*id) != Some(*line))
            .map(|(_, line)| format!("`{line}`"))
            .collect();
        let lines = if lines.is_empty() { cells::dash() } else { lines.join(", ") };
        table.row(vec![
            with,
            lines,
            step.gap.rms.filter(|_| !several).map_or_else(cells::dash, |v| significant(v, 4)),
            significant(step.gap.chi_square, 4),
            step.gap.dof.to_string(),
            step.strongest.as_ref().map_or(cells::dash(), |name| format!("`{name}`")),
            step.t.map_or_else(cells::dash, |t| format!("{t:.1}")),
            step.p.map_or_else(cells::dash, words::p),
            step.global_p.map_or_else(cells::dash, words::p),
        ]);
    }
    table.caption = say!(lang, "the-gap-as-given-and-after-each").into();
    table.note = report
        .steps
        .last()
        .map_or(String::new(), |step| say!(lang, "at-the-end", decision = lang.name(&step.decision)));
    let section = Section::new(say!(lang, "the-gap-shrinks-step-by-step")).table(table);
    let holdout = words::holdout(report, lang);
    if holdout.is_empty() { section } else { section.prose(lang.sentence(&holdout)) }
}

fn assumptions(campaign: &Campaign, diagnosis: &Diagnosis, report: &DiagnoseReport, lang: Language) -> Section {
    let mut points = Vec::new();
    if !report.assumed_zero.is_empty() {
        points.push(say!(
            lang,
            "taken-as-zero-neither-known-nor-estimated",
            assumed_zero = cells::names(&report.assumed_zero, lang)
        ));
    }
    let known = campaign.parameters.iter().filter_map(|p| match &p.role {
        Role::Known(known) => {
            let u = if known.u > 0.0 { format!(", u = {}", significant(known.u, 3)) } else { String::new() };
            Some(format!("`{}` = {} {}{u}", p.id, known.value, p.unit).replace(" ,", ","))
        }
        _ => None,
    });
    let known: Vec<String> = known.collect();
    if !known.is_empty() {
        points.push(say!(lang, "taken-as-known", known = known.join("; ")));
    }
    let prior = |p: &&crate::campaign::Parameter| matches!(p.role, Role::Estimated { prior: Some(_), .. });
    let priors: Vec<&str> = campaign.estimated().iter().filter(prior).map(|p| p.id.as_str()).collect();
    if !priors.is_empty() {
        points.push(say!(lang, "priors-entered-as-rows-of-their-own", priors = cells::names(&priors, lang)));
    }
    points.extend(words::constraints(report, lang).iter().map(|text| lang.sentence(text)));
    points.push(
        match report.gap.noise.from {
            NoiseFrom::Residuals => say!(lang, "readings-of-one-sensor-scatter-alike-and-2"),
            NoiseFrom::Stated => say!(lang, "the-readings-scatter-independently-as-their-stated"),
            NoiseFrom::Replicates => say!(lang, "the-readings-scatter-independently-as-their-replicates"),
        }
        .to_string(),
    );
    points.push(if diagnosis.before.convergence.is_some() {
        say!(lang, "the-models-are-fitted-exactly-gauss-newton").into()
    } else {
        say!(lang, "gauss-newton-does-not-converge-here-so").to_string()
    });
    Section::new(say!(lang, "what-was-assumed")).list(points)
}
