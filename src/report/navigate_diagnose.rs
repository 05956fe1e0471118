//! A diagnosis of measured navigation errors: its report (`tumble diagnose MISSION --measured F --json`), and its document: the verdict, what was found
//! and the gap in time, how it shrinks, what else it could be.

use super::diagnose::SuspectReport;
use super::diagnose_document as words;
use super::navigate::{error_quantities, in_words};
use super::provenance::begin;
use super::scene::mission_figure;
use super::{GapsReport, QuantityWithUnit, ReportKind, VERSION};
use crate::diagnosis::{Gap, NoiseFloor, NoiseFrom, State, Step, Verdict};
use crate::document::chart::{Chart, Curve};
use crate::document::number::{rounded, significant};
use crate::document::{Cell, Content, Document, Figure, Rows, Section, Tone};
use crate::elements::Elements;
use crate::language::{Language, code, say};
use crate::navigate::cause::Cause;
use crate::navigate::diagnose::{Alias, Finding, GapStep, NavigationDiagnosis, Suspect, Unexplained};
use crate::navigate::errors::ErrorSource;
use crate::navigate::measured::{CHANNEL_NAMES, Measured, Run, si_per_unit};
use crate::navigate::mission::Mission;
use crate::navigate::remainder::ChannelGap;
use crate::navigate::separate::DiscriminatingMotion;
use crate::navigate::settings::Settings;
use crate::navigate::study;
use crate::plan;
use crate::wire::MotionFile;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What `tumble diagnose MISSION --measured F --json` writes.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct NavigateDiagnoseReport {
    /// Version of the program that wrote it.
    pub tumble: String,
    /// Always `navigate-diagnose`.
    #[schemars(extend("const" = "navigate-diagnose"))]
    pub report: ReportKind,
    /// The mission's title.
    pub mission: String,
    /// The runs that were measured.
    pub runs: Vec<RunReport>,
    /// Rows of the file that belong to other scenarios and were left out.
    pub left_out: usize,
    /// `effects-found`, `partly-explained` (effects were found, and unexplained residuals remain), `nothing-missing`, `unexplained`, or `not-diagnosable` (fewer than three values).
    pub verdict: Verdict,
    /// Probability of reporting anything when nothing is missing.
    pub significance: f64,
    /// The errors that are missing from the mission, the strongest first.
    pub effects: Vec<NavigationEffectReport>,
    /// What the posterior says: `nothing` is missing, an error at least is `named`, none is and one at least is `suspected`, or what is missing is
    /// `outside` of what was tried; absent where nothing can be diagnosed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub state: Option<State>,
    /// Errors that are probable, but not enough for a name: no part of `model_after`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub suspected: Vec<SuspectReport>,
    /// The mission's errors as given.
    pub model_before: BTreeMap<String, QuantityWithUnit>,
    /// The same with what was found.
    pub model_after: BTreeMap<String, QuantityWithUnit>,
    /// The gap (measured minus predicted) before and after, in standard uncertainties (where the mission has random walks: of
    /// innovations, so that they are independent); `noise.sd` is null, `channels` has that of each.
    pub gap: GapsReport,
    /// The gap as it shrinks: before, after the cause that reduces it most, after that and the next, ..., each set fitted anew; the last with
    /// single values left out. Empty where nothing was found.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gap_steps: Vec<GapStep>,
    /// The gap by run and channel, in the channel's own unit.
    pub channels: Vec<ChannelGap>,
    /// What is unexplained (beside what was found); null unless the verdict says so.
    pub unexplained: Option<Unexplained>,
    /// Single values that noise does not explain after all that was found, the furthest first.
    pub suspects: Vec<Suspect>,
    /// The search's record.
    pub steps: Vec<Step>,
    /// How many error sources were tried.
    pub candidates: usize,
    /// How many of them are distinct in these data: the number of tests that every p accounts for.
    pub distinct_candidates: usize,
    /// Error sources that these data cannot show at any size that a navigator's unit has.
    pub invisible: Vec<String>,
    /// How often what was found was put into the full simulation and refitted.
    pub refits: usize,
    /// Whether the refits settled.
    pub settled: bool,
}

/// A run that was measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RunReport {
    /// Name of the mission's motion.
    pub motion: String,
    /// Rows.
    pub rows: usize,
}

/// An error that the mission misses.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct NavigationEffectReport {
    /// The cause: an error source as mission files name it, such a bias with its change in time (`gyro_bias_x:ramp`,
    /// `gyro_bias_x:wave(3600)`), a random walk
    /// (`angle_random_walk`, `velocity_random_walk`; of biases `rate_random_walk`, `acceleration_random_walk_x`), a fault of the reference (`reference:phi_up_arcsec:step(7200)`), or a single value (`reading:17`, the number of its row).
    pub regressor: String,
    /// Name in the field's words.
    pub name: String,
    /// What the mission has to be changed by, in `unit`.
    pub value: f64,
    /// Standard uncertainty, in `unit`.
    pub u: Option<f64>,
    /// Unit.
    pub unit: String,
    /// The mission's value before, in `unit`; null where no mission holds such a cause.
    pub before: Option<f64>,
    /// The mission's value after, in `unit`.
    pub after: Option<f64>,
    /// Student's t (normal where the noise is stated), the other effects given.
    pub t: f64,
    /// Probability of evidence as strong by chance, among all that was tried.
    pub p: f64,
    /// Probability that it, or an error that cannot be distinguished from it, is present; absent for random walks and single values.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub probability: Option<f64>,
    /// Share of the residual sum of squares that it removes.
    pub explains: f64,
    /// What else it could be.
    pub aliases: Vec<NavigationAliasReport>,
    /// Motions that would discriminate them, best first; as a mission file has them.
    pub separate_by: Vec<SeparationReport>,
}

/// Another error that explains the same.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NavigationAliasReport {
    /// The error source.
    pub regressor: String,
    /// Its name.
    pub name: String,
    /// The change of the mission that it would need, in `unit`.
    pub value: Option<f64>,
    /// Its unit.
    pub unit: String,
    /// The same column exactly (true), or only a fit that is not significantly worse (false).
    pub exact: bool,
    /// How much worse it fits, in variances of the noise.
    pub excess: f64,
    /// Would it need a size that no navigator's unit has?
    pub absurd: bool,
    /// A second error that must then replace another one that was found.
    pub together_with: Option<String>,
}

/// A motion that would discriminate an error from its aliases.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SeparationReport {
    /// The motion, as a mission file has it.
    pub motion: MotionFile,
    /// In words.
    pub is: String,
    /// The aliases that it discriminates from the error.
    pub tells: Vec<String>,
    /// By how many standard deviations at least, with as many rows and the same noise as the first run.
    pub by: f64,
}

/// The report of a diagnosis of measured navigation errors.
pub fn navigate_diagnose_report(
    mission: &Mission,
    measured: &Measured,
    diagnosis: &NavigationDiagnosis,
    settings: &Settings,
) -> NavigateDiagnoseReport {
    let motions: Vec<String> = study::motions(mission).into_iter().map(|(name, _)| name).collect();
    // runs are numbered by the motions of this mission
    let motion = |run: &Run| motions.get(run.motion).cloned().unwrap_or_default();
    let [before, after] = diagnosis.gap.clone();
    NavigateDiagnoseReport {
        tumble: VERSION.into(),
        report: ReportKind::NavigateDiagnose,
        mission: mission.title.clone(),
        runs: measured.runs.iter().map(|run| RunReport { motion: motion(run), rows: run.rows.len() }).collect(),
        left_out: measured.left_out,
        verdict: diagnosis.verdict,
        significance: settings.common.significance,
        effects: diagnosis.findings.iter().map(|finding| effect(finding, diagnosis)).collect(),
        state: state(diagnosis),
        suspected: diagnosis.suspected.iter().map(suspected).collect(),
        model_before: error_quantities(&diagnosis.before),
        model_after: error_quantities(&diagnosis.after),
        gap: GapsReport {
            before,
            after,
            sensors: BTreeMap::new(),
            noise: NoiseFloor { sd: None, from: diagnosis.noise },
        },
        gap_steps: diagnosis.gap_steps.clone(),
        channels: diagnosis.channels.clone(),
        unexplained: diagnosis.unexplained.clone(),
        suspects: diagnosis.suspects.clone(),
        steps: diagnosis.steps.clone(),
        candidates: diagnosis.candidates.0,
        distinct_candidates: diagnosis.candidates.1,
        invisible: diagnosis.invisible.iter().map(ErrorSource::id).collect(),
        refits: diagnosis.refits.0,
        settled: diagnosis.refits.1,
    }
}

fn state(diagnosis: &NavigationDiagnosis) -> Option<State> {
    match diagnosis.verdict {
        Verdict::EffectsFound | Verdict::PartlyExplained => Some(State::Named),
        Verdict::NothingMissing => Some(State::Nothing),
        Verdict::Unexplained if diagnosis.suspected.is_empty() => Some(State::Outside),
        Verdict::Unexplained => Some(State::Suspected),
        Verdict::NotDiagnosable => None,
    }
}

fn suspected((cause, probability): &(Cause, f64)) -> SuspectReport {
    SuspectReport { regressor: cause.id(), name: cause.name(), sensor: None, probability: *probability }
}

fn effect(finding: &Finding, diagnosis: &NavigationDiagnosis) -> NavigationEffectReport {
    let source = &finding.source;
    let unit = source.si_per_unit();
    NavigationEffectReport {
        regressor: source.id(),
        name: source.name(),
        value: finding.value / unit,
        u: finding.u.map(|u| u / unit),
        unit: source.unit(),
        before: source.of(&diagnosis.before).map(|size| size / unit),
        after: source.of(&diagnosis.after).map(|size| size / unit),
        t: finding.t,
        p: finding.p,
        probability: finding.probability,
        explains: finding.explains,
        aliases: finding.aliases.iter().map(alias).collect(),
        separate_by: finding.separate_by.iter().map(separation).collect(),
    }
}

fn alias(alias: &Alias) -> NavigationAliasReport {
    NavigationAliasReport {
        regressor: alias.source.id(),
        name: alias.source.name(),
        value: alias.value.map(|value| value / alias.source.si_per_unit()),
        unit: alias.source.unit(),
        exact: alias.exact,
        excess: alias.excess,
        absurd: alias.absurd,
        together_with: alias.together_with.as_ref().map(Cause::id),
    }
}

fn separation(run: &DiscriminatingMotion) -> SeparationReport {
    let motion = MotionFile::of(&run.motion);
    let is = motion.in_words();
    SeparationReport { motion, is, tells: run.tells.iter().map(ErrorSource::id).collect(), by: run.by }
}

/// Most aliases, added causes and values that are listed at a terminal; the JSON report has all.
const LISTED: usize = 8;

/// The document of a report; the mission and its diagnosis give the figures.
pub fn navigate_diagnose_document(
    report: &NavigateDiagnoseReport,
    of: Option<(&Mission, &NavigationDiagnosis)>,
    lang: Language,
) -> Document {
    let title = if report.mission.is_empty() { say!(lang, "navigation-errors") } else { &report.mission };
    let runs = report.runs.iter().map(|run| say!(lang, "rows-of", n = run.rows, motion = run.motion));
    let left_out = match report.left_out {
        0 => String::new(),
        rows => say!(lang, "rows-of-other-scenarios-left-out", rows = rows.to_string()),
    };
    let measured = runs.collect::<Vec<_>>().join(lang.comma()) + &left_out;
    let cards = report.effects.iter().filter_map(|effect| card(effect, lang));
    let diagnosis = of.map(|(_, diagnosis)| diagnosis);
    begin(say!(lang, "diagnosis-of", title), &[], lang)
        .fact(say!(lang, "measured-navigation-errors"), measured)
        .section(result(report, diagnosis, lang))
        .section(shrinking(report, lang))
        .section(places(report, lang))
        .section(cards.fold(Section::new(say!(lang, "what-is-missing")), Section::block))
        .section(channels_section(report, lang))
        .section(in_time(report, diagnosis, lang))
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
        explains: Some(effect.explains),
    });
    let found: Vec<words::Found<'_>> = found.collect();
    let changes = if found.is_empty() { "" } else { say!(lang, "values-are-changes-of-the-missions-errors") };
    let unexplained = report.unexplained.iter().flat_map(|unknown| {
        [lang.sentence(&lang.name(&unknown.pattern)), words::nearest(&unknown.nearest, unknown.nearest_explains, lang)]
    });
    let drawn = of.and_then(|diagnosis| Some((diagnosis, worst(diagnosis)?)));
    Section::new(say!(lang, "result"))
        .verdict(words::tone(report.verdict), lang.sentence(&sentence(report, lang)))
        .table(words::found(&found, None, lang))
        .prose(changes)
        .proses(unexplained)
        .figures(drawn.into_iter().flat_map(|(diagnosis, channel)| figures_of(report, diagnosis, channel, lang)))
}

/// The verdict as a sentence, without a full stop.
fn sentence(report: &NavigateDiagnoseReport, lang: Language) -> String {
    let suspected = words::suspected(&report.suspected, false, lang);
    let more = report.suspected.is_empty() || words::exceeds(&report.gap.after);
    let noise = if report.gap.noise.from == NoiseFrom::Residuals { "residuals" } else { "known" };
    let name = |effect: &NavigationEffectReport| {
        say!(lang, "effect-named", name = lang.name(&effect.name), regressor = effect.regressor)
    };
    let names: Vec<String> = report.effects.iter().map(name).collect();
    let names = lang.first_of(&names, LISTED, lang.semicolon());
    let found = say!(lang, "effects-are-missing", n = report.effects.len(), names);
    words::said(report.verdict, (found, suspected), more, noise, "mission", lang)
}

/// The gap as given and after each cause.
fn shrinking(report: &NavigateDiagnoseReport, lang: Language) -> Section {
    let steps = &report.gap_steps;
    let mut rows: Vec<(String, &Gap)> = vec![(say!(lang, "as-given").into(), &report.gap.before)];
    for (before, step) in steps.iter().zip(steps.iter().skip(1)) {
        let added: Vec<String> = step.with.iter().filter(|name| !before.with.contains(name)).cloned().collect();
        let added = words::listed(&added, LISTED, lang);
        let out = (step.left_out > 0).then(|| format!("{} {}", step.left_out, say!(lang, "outliers")));
        let parts = [Some(added).filter(|added| !added.is_empty()), out];
        rows.push((format!("+ {}", parts.into_iter().flatten().collect::<Vec<_>>().join(lang.comma())), &step.gap));
    }
    if steps.len() < 2 && !report.effects.is_empty() {
        rows.push((say!(lang, "after").into(), &report.gap.after));
    }
    let table = Rows::of(&rows)
        .left(say!(lang, "in-the-model"), |(name, _)| name)
        .decimal(say!(lang, "rms"), |(_, gap)| Cell::digits(gap.rms, 4))
        .decimal(say!(lang, "max"), |(_, gap)| Cell::Digits(gap.max, 4))
        .decimal(say!(lang, "chi-square"), |(_, gap)| Cell::Digits(gap.chi_square, 4))
        .right(say!(lang, "dof"), |(_, gap)| gap.dof)
        .right("p", |(_, gap)| Cell::p(gap.p))
        .caption(say!(lang, "gap-in-standard-uncertainties"));
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
        let names: Vec<String> = effect.aliases.iter().map(|alias| alias_said(alias, lang)).collect();
        let names = lang.first_of(&names, LISTED, lang.semicolon());
        facts.push((lang.title(say!(lang, "cannot-be-distinguished-from")), names));
    }
    let possible = effect.aliases.iter().filter(|alias| !alias.absurd && alias.together_with.is_none()).count();
    let run = |separation: &SeparationReport| {
        let [n, of] = [separation.tells.len(), possible].map(|n| n.to_string());
        say!(lang, "discriminates", at = lang.name(&separation.is), n, of)
    };
    if !effect.separate_by.is_empty() {
        let runs = effect.separate_by.iter().map(run).collect::<Vec<_>>().join(lang.semicolon());
        facts.push((say!(lang, "discriminated-by").into(), runs));
    }
    let heading = words::heading(&effect.name, &effect.regressor, lang);
    (!facts.is_empty()).then_some(Content::Card { heading, tone: Tone::Bad, facts })
}

fn alias_said(alias: &NavigationAliasReport, lang: Language) -> String {
    let mut text = code(&alias.regressor);
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

fn channels_section(report: &NavigateDiagnoseReport, lang: Language) -> Section {
    let several = report.runs.len() > 1;
    let found = !report.effects.is_empty();
    let rms = say!(lang, "rms");
    let at = |when| if found { words::at(rms, when, lang) } else { rms.to_string() };
    let table = Rows::of(&report.channels)
        .name(say!(lang, "channel"), |channel| &channel.column)
        .left(say!(lang, "motion"), |channel| if several { channel.motion.as_str() } else { "" })
        .right(say!(lang, "values"), |channel| channel.values)
        .decimal(at("before"), |channel| Cell::Digits(channel.rms_before, 4))
        .decimal(at("after"), |channel| if found { Cell::Digits(channel.rms_after, 4) } else { "".into() })
        .decimal("u", |channel| Cell::Digits(channel.u, 3))
        .left("", |channel| match channel.u_from {
            NoiseFrom::Stated => String::new(),
            from => lang.term(from.name()),
        });
    Section::new(say!(lang, "the-gap-by-channel")).table(table)
}

/// Where what is unexplained lies, and single values far off.
fn places(report: &NavigateDiagnoseReport, lang: Language) -> Section {
    let table = Rows::of(report.unexplained.iter().flat_map(|unexplained| &unexplained.cells))
        .name(say!(lang, "channel"), |cell| &cell.column)
        .left(say!(lang, "motion"), |cell| &cell.motion)
        .left(format!("{}, h", say!(lang, "time")), |cell| {
            say!(lang, "from-to", a = significant(cell.from_h, 3), b = significant(cell.to_h, 3))
        })
        .right(say!(lang, "values"), |cell| cell.values)
        .decimal(say!(lang, "mean"), |cell| Cell::Digits(cell.mean, 3))
        .decimal("z", |cell| Cell::Decimals(cell.z, 1))
        .most(LISTED);
    let far = Rows::of(&report.suspects)
        .name(say!(lang, "outliers"), |outlier| &outlier.column)
        .left(say!(lang, "motion"), |outlier| &outlier.motion)
        .decimal(format!("{}, s", say!(lang, "time")), |outlier| outlier.time_s.to_string())
        .decimal("z", |outlier| Cell::Decimals(outlier.z, 1))
        .most(LISTED);
    Section::new(say!(lang, "where-the-gap-is")).table(table).table(far)
}

/// How the causes were compared, what these data cannot show, and the mission.
fn origin(report: &NavigateDiagnoseReport, mission: Option<&Mission>, lang: Language) -> Section {
    let times = report.refits.to_string();
    let refits = (!report.settled).then(|| say!(lang, "refits", times));
    let invisible = grouped(&report.invisible).join(lang.comma());
    let invisible = (!invisible.is_empty()).then(|| say!(lang, "these-data-cannot-show", sources = invisible));
    Section::new(say!(lang, "what-was-assumed"))
        .proses(invisible)
        .full()
        .list(refits)
        .figures(mission.map(|mission| mission_figure(mission, lang)))
}

/// Error sources by group: `gyro_bias (x, y)`.
fn grouped(ids: &[String]) -> Vec<String> {
    let parts = ids.iter().filter_map(|id| id.rsplit_once('_'));
    let said = |group: Vec<(&str, &str)>| {
        let axes: Vec<&str> = group.iter().map(|(_, axis)| *axis).collect();
        Some(format!("`{}` ({})", group.first()?.0, axes.join(", ")))
    };
    plan::grouped(parts.map(|(group, axis)| ((group, axis), group))).into_iter().filter_map(said).collect()
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
    let (series, details) = (diagnosis.gaps_over_time.get(channel), diagnosis.channels.get(channel));
    let Some((series, channel)) = series.zip(details) else { return Vec::new() };
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
    let [size, after] = [channel.rms_before, channel.rms_after].map(|size| significant(size, 3));
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
    let band = corners.map(|(time, size)| (time / 3600.0, size * channel.u)).to_vec();
    let lines = [Curve { label: "2 u".into(), points: band, dashed: true }, left];
    let caption = say!(lang, "what-is-left-of-with-two-standard", name, where_);
    let description = in_words(&lines, &caption, "", lang);
    vec![gap, Figure { description, caption, chart: chart(&lines), wide: false }]
}

fn changed(before: &str, after: &str, lang: Language) -> String {
    format!("{before} {}{}{after} {}", say!(lang, "before"), lang.clause(), say!(lang, "after"))
}

/// The place of the channel in which the gap is largest against its standard uncertainty.
fn worst(diagnosis: &NavigationDiagnosis) -> Option<usize> {
    let size = |channel: &ChannelGap| channel.rms_before / channel.u.max(f64::MIN_POSITIVE);
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
    section.figures(others.flat_map(|channel| figures_of(report, diagnosis, channel, lang)))
}
