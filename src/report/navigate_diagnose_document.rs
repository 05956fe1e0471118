//! The document of a diagnosis of navigation errors: the verdict, what was found and the gap in time, how it shrinks, what else it could be.

use super::colophon::begin;
use super::diagnose::words;
use super::navigate_document::in_words;
use super::scene::mission_figure;
use super::{GapReport, NavigateDiagnoseReport, NavigationAliasReport, NavigationEffectReport, SeparationReport};
use crate::diagnosis::{NoiseFrom, Verdict};
use crate::document::chart::{Chart, Curve};
use crate::document::number::{rounded, significant};
use crate::document::{Align, Cell, Content, Detail, Document, Figure, Section, Table, Tone};
use crate::elements::Elements;
use crate::language::{Language, say};
use crate::navigate::diagnose::NavigationDiagnosis;
use crate::navigate::measured::{CHANNEL_NAMES, si_per_unit};
use crate::navigate::mission::Mission;
use crate::navigate::remainder::ChannelGap;

/// Most aliases, added causes and values that are listed at a terminal; the JSON report has all.
const LISTED: usize = 8;

/// The document of a report; the mission and its diagnosis give the figures.
pub fn navigate_diagnose_document(
    report: &NavigateDiagnoseReport,
    of: Option<(&Mission, &NavigationDiagnosis)>,
    lang: Language,
) -> Document {
    let title = if report.mission.is_empty() { say!(lang, "navigation-errors") } else { &report.mission };
    let mut document = begin(say!(lang, "diagnosis-of", title), &[], lang);
    let runs = report.runs.iter().map(|run| say!(lang, "rows-of", n = run.rows, motion = run.motion));
    let left_out = match report.left_out {
        0 => String::new(),
        rows => say!(lang, "rows-of-other-scenarios-left-out", rows = rows.to_string()),
    };
    let measured = runs.collect::<Vec<_>>().join(lang.comma()) + &left_out;
    document.facts = vec![(say!(lang, "measured-navigation-errors").into(), measured)];
    let missing = Section::new(say!(lang, "what-is-missing"));
    let cards = report.effects.iter().filter_map(|effect| card(effect, lang));
    let missing = cards.fold(missing, Section::block);
    document
        .section(result(report, of.map(|(_, diagnosis)| diagnosis), lang))
        .section(shrinking(report, lang))
        .section(places(report, lang))
        .section(missing)
        .section(channels(report, lang))
        .section(in_time(report, of.map(|(_, diagnosis)| diagnosis), lang))
        .section(origin(report, of.map(|(mission, _)| mission), lang))
}

fn result(report: &NavigateDiagnoseReport, of: Option<&NavigationDiagnosis>, lang: Language) -> Section {
    let found = report.effects.iter().map(|effect| words::Found {
        regressor: &effect.regressor,
        quantity: lang.name(&effect.name).into_owned(),
        sensor: "",
        value: Some(effect.value),
        u: effect.u,
        expanded: None,
        unit: &effect.unit,
        t: effect.t,
        p: effect.p,
        explains: effect.explains,
    });
    let mut section = Section::new(say!(lang, "result"))
        .verdict(words::tone(report.verdict), lang.sentence(&sentence(report, lang)))
        .table(words::found(found, "", lang).at(Detail::Full, &[1]));
    if !report.effects.is_empty() {
        section = section.prose(say!(lang, "values-are-changes-of-the-missions-errors"));
    }
    if let Some(own) = &report.unexplained {
        section = section.prose(lang.sentence(&lang.name(&own.pattern)));
        section = section.prose(words::nearest(&own.nearest, own.nearest_explains, lang));
    }
    let Some((diagnosis, channel)) = of.and_then(|own| Some((own, worst(own)?))) else { return section };
    section.figures(figures_of(report, diagnosis, channel, lang))
}

/// The verdict as a sentence, without a full stop.
fn sentence(report: &NavigateDiagnoseReport, lang: Language) -> String {
    match report.verdict {
        Verdict::EffectsFound => found(report, lang),
        Verdict::PartlyExplained => say!(lang, "what-remains-is-more-than-noise", found = found(report, lang)),
        Verdict::NothingMissing => say!(lang, "nothing-is-missing", noise = "known"),
        Verdict::Unexplained => say!(lang, "unexplained").into(),
        Verdict::NotDiagnosable => say!(lang, "not-diagnosable", of = "mission"),
    }
}

/// What was found: how much, and its names.
fn found(report: &NavigateDiagnoseReport, lang: Language) -> String {
    let name = |effect: &NavigationEffectReport| {
        say!(lang, "effect-named", name = lang.name(&effect.name), regressor = effect.regressor)
    };
    let names: Vec<String> = report.effects.iter().map(name).collect();
    let names = lang.first_of(&names, LISTED, lang.semicolon());
    say!(lang, "effects-are-missing", n = report.effects.len(), names)
}

/// The gap as given and after each cause.
fn shrinking(report: &NavigateDiagnoseReport, lang: Language) -> Section {
    let mut table = Table::new(&[
        (say!(lang, "in-the-model"), Align::Left),
        (say!(lang, "rms"), Align::Decimal),
        (say!(lang, "max"), Align::Decimal),
        (say!(lang, "chi-square"), Align::Decimal),
        (say!(lang, "dof"), Align::Right),
        ("p", Align::Right),
    ]);
    table.caption = say!(lang, "gap-in-standard-uncertainties").into();
    let mut row = |name: String, gap: &GapReport| {
        let sizes = [Cell::digits(gap.rms, 4), Cell::Digits(gap.max, 4), Cell::Digits(gap.chi_square, 4)];
        table.row([vec![name.into()], sizes.into(), vec![gap.dof.into(), Cell::p(gap.p)]].concat());
    };
    row(say!(lang, "as-given").into(), &report.gap.before);
    let steps = &report.gap_steps;
    for (before, own) in steps.iter().zip(steps.iter().skip(1)) {
        let added: Vec<String> = own.with.iter().filter(|name| !before.with.contains(name)).cloned().collect();
        let added = words::listed(&added, LISTED, lang);
        let out = (own.left_out > 0).then(|| format!("{} {}", own.left_out, say!(lang, "outliers")));
        let parts = [Some(added).filter(|added| !added.is_empty()), out];
        row(format!("+ {}", parts.into_iter().flatten().collect::<Vec<_>>().join(lang.comma())), &own.gap);
    }
    if steps.len() < 2 && !report.effects.is_empty() {
        row(say!(lang, "after").into(), &report.gap.after);
    }
    let noise = words::noise_source(report.gap.noise.from, lang);
    let [candidates, distinct] = [report.candidates, report.distinct_candidates].map(|n| n.to_string());
    let significance = report.significance.to_string();
    let tried = say!(lang, "candidates-tried", candidates, distinct, significance, averaged = "");
    Section::new(say!(lang, "the-gap"))
        .table(table)
        .prose(lang.sentence(&say!(lang, "noise-floor", noise)))
        .prose(lang.sentence(&tried))
}

/// What is to be known of an error beside its size; `None` where that is nothing.
fn card(effect: &NavigationEffectReport, lang: Language) -> Option<Content> {
    let mut facts: Vec<(String, String)> = Vec::new();
    if let (Some(before), Some(after)) = (effect.before.filter(|before| *before != 0.0), effect.after) {
        // without what a unit of radians costs in the last digits
        let before: f64 = format!("{before:.9e}").parse().unwrap_or(before);
        let [before, after] = [before.to_string(), rounded(after, effect.u)];
        facts.push((say!(lang, "in-the-mission").into(), changed(&before, &after, lang)));
    }
    if !effect.aliases.is_empty() {
        let names: Vec<String> = effect.aliases.iter().map(|own| alias(own, lang)).collect();
        let names = lang.first_of(&names, LISTED, lang.semicolon());
        facts.push((lang.title(say!(lang, "cannot-be-distinguished-from")), names));
    }
    let possible = effect.aliases.iter().filter(|alias| !alias.absurd && alias.together_with.is_none()).count();
    let run = |own: &SeparationReport| {
        let [n, of] = [own.tells.len(), possible].map(|n| n.to_string());
        say!(lang, "discriminates", at = lang.name(&own.is), n, of)
    };
    if !effect.separate_by.is_empty() {
        let runs = effect.separate_by.iter().map(run).collect::<Vec<_>>().join(lang.semicolon());
        facts.push((say!(lang, "discriminated-by").into(), runs));
    }
    let name = lang.name(&effect.name);
    let heading = lang.sentence(&say!(lang, "effect-named", name, regressor = effect.regressor));
    let heading = heading.trim_end_matches(['.', '\u{3002}']).to_string();
    (!facts.is_empty()).then_some(Content::Card { heading, tone: Tone::Bad, facts })
}

fn alias(alias: &NavigationAliasReport, lang: Language) -> String {
    let mut text = format!("`{}`", alias.regressor);
    if let Some(value) = alias.value {
        let unit = if alias.unit == "1" { "" } else { &alias.unit };
        text.push_str(format!(" = {} {unit}", significant(value, 4)).trim_end());
    }
    if alias.absurd {
        text.push_str(&format!(" {}", say!(lang, "absurd")));
    }
    if !alias.exact {
        text.push_str(&format!(" (+{:.1})", alias.excess));
    }
    if let Some(other) = &alias.together_with {
        text.push_str(&format!(" ({})", say!(lang, "together-with", other)));
    }
    text
}

/// The gap by channel.
fn channels(report: &NavigateDiagnoseReport, lang: Language) -> Section {
    let several = report.runs.len() > 1;
    let found = !report.effects.is_empty();
    let rms = say!(lang, "rms");
    let at = |when| if found { words::at(rms, when, lang) } else { rms.to_string() };
    let mut table = Table::new(&[
        (say!(lang, "channel"), Align::Left),
        (say!(lang, "motion"), Align::Left),
        (say!(lang, "values"), Align::Right),
        (&at("before"), Align::Decimal),
        (&at("after"), Align::Decimal),
        ("u", Align::Decimal),
        ("", Align::Left),
    ]);
    for own in &report.channels {
        table.row(vec![
            Cell::name(&own.column),
            if several { own.motion.as_str().into() } else { "".into() },
            own.values.into(),
            Cell::Digits(own.rms_before, 4),
            if found { Cell::Digits(own.rms_after, 4) } else { "".into() },
            Cell::Digits(own.u, 3),
            if own.u_from == NoiseFrom::Stated { "".into() } else { lang.term(own.u_from.name()).into() },
        ]);
    }
    Section::new(say!(lang, "the-gap-by-channel")).table(table)
}

/// Where what is unexplained lies, and single values far off.
fn places(report: &NavigateDiagnoseReport, lang: Language) -> Section {
    let mut table = Table::new(&[
        (say!(lang, "channel"), Align::Left),
        (say!(lang, "motion"), Align::Left),
        (&format!("{}, h", say!(lang, "time")), Align::Left),
        (say!(lang, "values"), Align::Right),
        (say!(lang, "mean"), Align::Decimal),
        ("z", Align::Decimal),
    ]);
    for cell in report.unexplained.iter().flat_map(|own| &own.cells) {
        table.row(vec![
            Cell::name(&cell.column),
            cell.motion.as_str().into(),
            say!(lang, "from-to", a = significant(cell.from_h, 3), b = significant(cell.to_h, 3)).into(),
            cell.values.into(),
            Cell::Digits(cell.mean, 3),
            Cell::Decimals(cell.z, 1),
        ]);
    }
    let mut far = Table::new(&[
        (say!(lang, "outliers"), Align::Left),
        (say!(lang, "motion"), Align::Left),
        (&format!("{}, s", say!(lang, "time")), Align::Decimal),
        ("z", Align::Decimal),
    ]);
    for own in &report.suspects {
        let time = own.time_s.to_string();
        far.row(vec![Cell::name(&own.column), own.motion.as_str().into(), time.into(), Cell::Decimals(own.z, 1)]);
    }
    table.brief_rows = Some(LISTED);
    far.brief_rows = Some(LISTED);
    Section::new(say!(lang, "where-the-gap-is")).table(table).table(far)
}

/// How the causes were compared, what these data cannot show, and the mission.
fn origin(report: &NavigateDiagnoseReport, mission: Option<&Mission>, lang: Language) -> Section {
    let times = report.refits.to_string();
    let refits = (!report.settled).then(|| say!(lang, "refits", times));
    let mut section = Section::new(say!(lang, "what-was-assumed"));
    if !report.invisible.is_empty() {
        let sources = grouped(&report.invisible).join(lang.comma());
        section = section.prose(say!(lang, "these-data-cannot-show", sources));
    }
    section
        .full()
        .list(refits.into_iter().collect())
        .figures(mission.map(|mission| mission_figure(mission, lang)).into_iter().collect())
}

/// Error sources by group: `gyro_bias (x, y)`.
fn grouped(ids: &[String]) -> Vec<String> {
    let mut groups: Vec<(&str, Vec<&str>)> = Vec::new();
    for (group, axes) in ids.iter().filter_map(|id| id.rsplit_once('_')) {
        match groups.iter_mut().find(|(name, _)| *name == group) {
            Some((_, list)) => list.push(axes),
            None => groups.push((group, vec![axes])),
        }
    }
    groups.into_iter().map(|(group, axes)| format!("`{group}` ({})", axes.join(", "))).collect()
}

/// The gap in time, before and with what was found, in the channel where it is largest against its standard uncertainty; `None` where nothing was
/// measured.
pub fn navigate_diagnose_figure(
    report: &NavigateDiagnoseReport,
    diagnosis: &NavigationDiagnosis,
    lang: Language,
) -> Option<Figure> {
    let place = worst(diagnosis)?;
    figures_of(report, diagnosis, place, lang).into_iter().next()
}

/// The gap in one channel and, where something was found, what is left of it before the band of two u.
fn figures_of(
    report: &NavigateDiagnoseReport,
    diagnosis: &NavigationDiagnosis,
    channel: usize,
    lang: Language,
) -> Vec<Figure> {
    let (series, own) = (diagnosis.gaps_over_time.get(channel), diagnosis.channels.get(channel));
    let Some((series, channel)) = series.zip(own) else { return Vec::new() };
    let scale = 1.0 / si_per_unit(series.channel);
    let line = |label: &str, of: &dyn Fn(&(f64, f64, f64)) -> f64| Curve {
        label: label.into(),
        points: series.points.iter().map(|point| (point.0 / 3600.0, scale * of(point))).collect(),
        dashed: false,
    };
    // the name of a channel says its unit
    let name = CHANNEL_NAMES.at(series.channel);
    let chart = |lines: &[Curve]| Chart::curves(lines, name, "", &format!("{}, h", say!(lang, "time")));
    let where_ = if report.runs.len() > 1 { format!(" ({})", series.motion) } else { String::new() };
    let [size, after] = [channel.before.0, channel.after.0].map(|size| significant(scale * size, 3));
    let before = line(say!(lang, "before"), &|point| point.1);
    if report.effects.is_empty() {
        return vec![Figure::new(say!(lang, "gap-of", name, where_, size), chart(&[before]), false)];
    }
    let left = line(say!(lang, "with-what-was-found"), &|point| point.2);
    let gap = say!(lang, "gap-of", name, where_, size = changed(&size, &after, lang));
    let gap = Figure::new(gap, chart(&[before, left.clone()]), false);
    // the band of two u as a box around the time of the run
    let (first, last) = (series.points.first().map_or(0.0, |p| p.0), series.points.last().map_or(0.0, |p| p.0));
    let corners = [(first, 2.0), (last, 2.0), (last, -2.0), (first, -2.0), (first, 2.0)];
    let band = corners.map(|(time, size)| (time / 3600.0, size * scale * channel.u)).to_vec();
    let lines = [Curve { label: "2 u".into(), points: band, dashed: true }, left];
    let caption = say!(lang, "what-is-left-of-with-two-standard", name, where_);
    let description = in_words(&lines, &caption, "", lang);
    vec![gap, Figure { description, caption, chart: chart(&lines), wide: false }]
}

/// A size before and after.
fn changed(before: &str, after: &str, lang: Language) -> String {
    format!("{before} {}{}{after} {}", say!(lang, "before"), lang.clause(), say!(lang, "after"))
}

/// The place of the channel in which the gap is largest against its standard uncertainty.
fn worst(diagnosis: &NavigationDiagnosis) -> Option<usize> {
    let size = |channel: &ChannelGap| channel.before.0 / channel.u.max(f64::MIN_POSITIVE);
    let channels = diagnosis.channels.iter().enumerate().take(diagnosis.gaps_over_time.len());
    channels.max_by(|a, b| size(a.1).total_cmp(&size(b.1))).map(|(k, _)| k)
}

/// The gap of every channel against time, and what is left of it.
fn in_time(report: &NavigateDiagnoseReport, of: Option<&NavigationDiagnosis>, lang: Language) -> Section {
    let section = Section::new(lang.title(say!(lang, "over-time"))).full();
    let Some(diagnosis) = of else { return section };
    let first = worst(diagnosis);
    // the worst stands beside the verdict
    let others = (0..diagnosis.channels.len()).filter(|channel| Some(*channel) != first);
    section.figures(others.flat_map(|channel| figures_of(report, diagnosis, channel, lang)).collect())
}
