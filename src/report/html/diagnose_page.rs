//! The page of a diagnosis: the answer and its picture, what is missing, the repair, and what it rests on.

use super::diagnose_figure::figure;
use super::fit_page::colophon;
use super::scatter_page;
use super::{Align, Block, MarkedLine, Page, Section, Table, Tone, cells};
use crate::campaign::{Campaign, Role};
use crate::diagnosis::Diagnosis;
use crate::diagnosis::{NoiseFrom, Verdict};
use crate::error::Result;
use crate::language::Language;
use crate::report::diagnose::words;
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
    let mut page = Page::new(if bench.title.is_empty() { bench.id.clone() } else { bench.title.clone() });
    page.subtitle = "Diagnosis: where the readings and the model disagree, and what is missing".into();
    page.facts = vec![("Bench".to_string(), format!("`{}`", bench.id))];
    if !bench.source.is_empty() {
        page.facts.push(("Source".into(), bench.source.clone()));
    }
    page.facts.extend(inputs.first().map(|input| ("Campaign".to_string(), input.name.clone())));
    page.facts.extend(campaign.identity.facts(lang));
    page.colophon = colophon(inputs, lang);
    page = page.section(answer(campaign, diagnosis, report)?);
    let mut missing = Section::new("What is missing");
    for effect in &report.effects {
        missing = missing.block(card(report, effect, lang));
    }
    Ok(page
        .section(missing)
        .section(model(report))
        .section(scatter_page::scatter(&report.scatter, lang))
        .section(unexplained(report, lang))
        .section(changes(report))
        .section(places(report))
        .section(search(report))
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

/// A text with a capital and a full stop; it must not begin with a symbol.
pub(super) fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first: String = letters.next().map(|c| c.to_uppercase().collect()).unwrap_or_default();
    format!("{first}{}.", letters.as_str())
}

/// True minus signs before numbers (an exponent keeps its own).
fn minus(text: &str) -> String {
    let text = text.replace(" -", " \u{2212}").replace("= -", "= \u{2212}");
    text.strip_prefix('-').map_or(text.clone(), |size| format!("\u{2212}{size}"))
}

fn answer(campaign: &Campaign, diagnosis: &Diagnosis, report: &DiagnoseReport) -> Result<Section> {
    let section = Section::new("Result").verdict(tone(report.verdict), sentence(&words::verdict(report)));
    if report.verdict == Verdict::NotDiagnosable {
        let help = words::would_help(report);
        return Ok(if help.is_empty() { section } else { section.prose(sentence(&help)) });
    }
    let source = words::noise_source(report.gap.noise.from);
    Ok(section
        .prose(summary(report))
        .figures(vec![figure(campaign, diagnosis, report)?])
        .table(gap(report))
        .prose(format!("Noise floor: {source}. {}.", words::tried(report))))
}

/// The gap before and after, in one sentence; empty where nothing was found.
fn summary(report: &DiagnoseReport) -> String {
    if report.effects.is_empty() {
        return String::new();
    }
    let explained: f64 = report.effects.iter().map(|e| e.explains).sum();
    let with = if report.effects.len() == 1 { "With it" } else { "With them" };
    let gap = match report.gap.sensors.values().next() {
        Some(own) if report.gap.sensors.len() == 1 => {
            let rms = |v: Option<f64>| v.map_or("unknown".into(), |v| significant(v, 3));
            format!(
                "the residual standard deviation goes from {} to {} {}",
                rms(own.rms_before),
                rms(own.rms_after),
                own.unit
            )
        }
        _ => format!(
            "chi-square goes from {} to {}",
            significant(report.gap.before.chi_square, 4),
            significant(report.gap.after.chi_square, 4)
        ),
    };
    let share = if report.effects.len() == 1 {
        format!(": it explains {} of the gap", cells::percent(explained))
    } else {
        String::new()
    };
    format!("{with} {gap}{share}.")
}

/// Each sensor's gap, and the whole.
fn gap(report: &DiagnoseReport) -> Table {
    let found = !report.effects.is_empty();
    let mut columns = vec![("sensor", Align::Left), ("unit", Align::Left), ("noise sd", Align::Decimal)];
    columns.extend([(if found { "sd before" } else { "residual sd" }, Align::Decimal)]);
    columns.extend([(if found { "max before" } else { "max" }, Align::Decimal)]);
    if found {
        columns.extend([("sd after", Align::Decimal), ("max after", Align::Decimal)]);
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
        format!("{} with {} of freedom{p}", significant(gap.chi_square, 4), cells::count(gap.dof, "degree"))
    };
    table.note = format!("Chi-square: {}", of(&report.gap.before));
    if found {
        table.note.push_str(&format!("; with what was found {}", of(&report.gap.after)));
    }
    table.note.push('.');
    table
}

fn card(report: &DiagnoseReport, effect: &EffectReport, lang: Language) -> Block {
    let mut facts: Vec<(String, String)> = Vec::new();
    let mut say = |name: &str, text: String| {
        if !text.is_empty() {
            facts.push((name.to_string(), text));
        }
    };
    say("Regressor", format!("`{}`", effect.regressor));
    if report.model_before.len() > 1 {
        let all = if effect.regressor.starts_with("tilt:") { "common to all" } else { "" };
        say("Sensor", effect.sensor.as_ref().map_or(all.to_string(), |s| format!("`{s}`")));
    }
    match words::value(effect) {
        Some((value, u, expanded, unit)) => {
            let uncertainty = match (u, expanded) {
                (Some(u), Some(expanded)) => format!(", u = {u}, U = {expanded} ({})", cells::level(effect.level)),
                _ => String::new(),
            };
            let name = if effect.coefficient.is_empty() {
                sentence(&words::of(effect)).replace('.', "")
            } else {
                format!("`{}`", words::of(effect))
            };
            say(&name, minus(&format!("{value} {unit}{uncertainty}")).replace(" ,", ","));
        }
        None => say("Value", "the repaired model does not determine it".into()),
    }
    for own in &effect.in_sensors {
        let value = own.value.map_or("not determined".into(), |v| crate::report::table::rounded(v, own.u));
        let u = own.u.map_or(String::new(), |u| format!(", u = {}", significant(u, 2)));
        say(&format!("In `{}`", own.sensor), minus(&format!("{value} {}{u}, t = {:.1}", own.unit, own.t)));
    }
    say("Stated", words::against_stated(effect));
    say("Evidence", minus(&format!("t = {:.1}, {} among all that was tried", effect.t, words::p_is(effect.p))));
    say("Probability", words::probability(effect).replacen("probability ", "", 1));
    let beyond = if report.effects.len() == 1 { "" } else { " beyond the others" };
    say("Explains", format!("{} of the gap{beyond}", cells::percent(effect.explains)));
    let aliases = words::aliases(effect);
    say("Cannot be told from", cells::names(&aliases.same, lang));
    say("Fits not significantly worse", listed(&aliases.near));
    say("Only through small terms", listed(&aliases.small));
    let told = effect.separate_by.iter().zip(&effect.separate_tells);
    let positions: Vec<String> =
        told.map(|(at, n)| format!("`{}` (from {n} of {})", words::position(at), effect.separate_of)).collect();
    say("One more position would tell it", positions.join("; "));
    say("No position of this bench tells it from", cells::names(&effect.separate_never, lang));
    say("Why it happens", effect.why.clone());
    say("To confirm", effect.confirm.clone());
    Block::Card { heading: sentence(&effect.name).trim_end_matches('.').to_string(), tone: Tone::Bad, facts }
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
fn model(report: &DiagnoseReport) -> Section {
    let mut section = Section::new("The model");
    let line = |id: &str, kept: &str, added: &str| MarkedLine { kept: format!("{id} = {kept}"), added: added.into() };
    let before = report.model_before.iter().map(|(id, own)| line(id, own, ""));
    section = section.prose("As given:").block(Block::Marked(before.collect()));
    let changed: Vec<MarkedLine> = report
        .model_after
        .iter()
        .filter_map(|(id, after)| {
            let (kept, added) = words::appended(report.model_before.get(id)?, after)?;
            Some(line(id, kept, added))
        })
        .collect();
    if !changed.is_empty() {
        section = section.prose("With what was found:").block(Block::Marked(changed));
    }
    let mut repairs: Vec<String> = report.effects.iter().filter_map(words::repair).collect();
    if report.model_before == report.model_after {
        let own = report.effects.iter().filter(|e| !e.regressor.contains(':') && !e.coefficient.is_empty());
        repairs.extend(own.map(|e| format!("`{}` is estimated, no longer taken as zero", e.coefficient)));
    }
    section.list(repairs.iter().map(|text| sentence(text)).collect())
}

fn unexplained(report: &DiagnoseReport, lang: Language) -> Section {
    let section = Section::new("The pattern");
    let Some(own) = &report.unexplained else { return section };
    let mut table = Table::new(&[
        ("at", Align::Left),
        ("sensor", Align::Left),
        ("readings", Align::Right),
        ("mean gap", Align::Decimal),
        ("", Align::Bar),
        ("in sd", Align::Decimal),
    ]);
    table.caption = "Mean residual at each state of the joints, the most significant first".into();
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
        format!(
            "Nearest of the catalogue: {} would take off {} and leave more than noise, so it is not accepted.",
            cells::names(&own.nearest, lang),
            cells::percent(own.nearest_explains)
        )
    };
    section.prose(sentence(&own.pattern)).prose(nearest).table(table)
}

fn changes(report: &DiagnoseReport) -> Section {
    let mut table = Table::new(&[
        ("", Align::Left),
        ("before", Align::Decimal),
        ("u", Align::Decimal),
        ("after", Align::Decimal),
        ("u", Align::Decimal),
        ("shift", Align::Decimal),
        ("shift / u", Align::Decimal),
        ("unit", Align::Left),
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
    let note = words::after_u(report);
    // a sentence that begins with u would turn it into U, the expanded uncertainty
    table.note = if note.is_empty() { String::new() } else { format!("In this table, {note}. ") };
    table.note.push_str("Marked: shifts of more than twice their standard uncertainty.");
    Section::new("What it does to the estimates").table(table)
}

fn places(report: &DiagnoseReport) -> Section {
    if report.verdict == Verdict::NothingMissing {
        return Section::new("Where the gap is");
    }
    let mut table = Table::new(&[
        ("factor", Align::Left),
        ("level", Align::Left),
        ("sensor", Align::Left),
        ("readings", Align::Right),
        ("mean gap", Align::Decimal),
        ("", Align::Bar),
        ("in sd", Align::Decimal),
        ("p alone", Align::Right),
    ]);
    let shown: Vec<_> = report.places.iter().filter(|place| place.significant == Some(true)).take(LISTED).collect();
    let largest = shown.iter().fold(0.0_f64, |m, place| m.max(place.z.abs()));
    for place in &shown {
        table.row(vec![
            format!("`{}`", place.factor),
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
    table.note =
        "Means of the residuals with the model as given, each level by itself; bars are in standard deviations.".into();
    Section::new("Where the gap is").table(table)
}

fn search(report: &DiagnoseReport) -> Section {
    let mut table = Table::new(&[
        ("in the model", Align::Left),
        ("model line", Align::Left),
        ("residual sd", Align::Decimal),
        ("chi-square", Align::Decimal),
        ("dof", Align::Right),
        ("strongest further candidate", Align::Left),
        ("t", Align::Decimal),
        ("p", Align::Right),
        ("p of what is left", Align::Right),
    ]);
    let several = report.gap.sensors.len() > 1;
    for step in report.steps.iter().take(LISTED) {
        let with = step.with.last().map_or("as given".into(), |last| format!("+ `{last}`"));
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
    table.caption = "The gap as given, and after each effect".into();
    table.note = report.steps.last().map_or(String::new(), |step| format!("At the end: {}.", step.decision));
    let section = Section::new("The gap shrinks step by step").table(table);
    let holdout = words::holdout(report);
    if holdout.is_empty() { section } else { section.prose(sentence(&holdout)) }
}

fn assumptions(campaign: &Campaign, diagnosis: &Diagnosis, report: &DiagnoseReport, lang: Language) -> Section {
    let mut points = Vec::new();
    if !report.assumed_zero.is_empty() {
        points
            .push(format!("Taken as zero, neither known nor estimated: {}.", cells::names(&report.assumed_zero, lang)));
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
        points.push(format!("Taken as known: {}.", known.join("; ")));
    }
    let prior = |p: &&crate::campaign::Parameter| matches!(p.role, Role::Estimated { prior: Some(_), .. });
    let priors: Vec<&str> = campaign.estimated().iter().filter(prior).map(|p| p.id.as_str()).collect();
    if !priors.is_empty() {
        points.push(format!("Priors entered as rows of their own: {}.", cells::names(&priors, lang)));
    }
    points.extend(words::constraints(report).iter().map(|text| sentence(text)));
    points.push(match report.gap.noise.from {
        NoiseFrom::Residuals => "Readings of one sensor scatter alike and independently; how much, only the residuals of the finished model say.",
        NoiseFrom::Stated => "The readings scatter independently, as their stated uncertainties say.",
        NoiseFrom::Replicates => "The readings scatter independently, as their replicates say.",
    }.to_string());
    points.push(if diagnosis.before.convergence.is_some() {
        "The models are fitted exactly (Gauss-Newton); the candidates are compared at their solution.".into()
    } else {
        "Gauss-Newton does not converge here, so the linear estimator was diagnosed.".to_string()
    });
    Section::new("What was assumed").list(points)
}
