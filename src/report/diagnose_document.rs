//! The document of a diagnosis: the verdict, what was found and the picture, how the gap shrinks, then what it rests on. What campaigns and missions share is
//! here, too: the table of what was found, and sentences.

use super::diagnose::{AssertedReport, SensorGapReport, SuspectReport};
use super::fit_document::bench_figure;
use super::provenance::begin;
use super::{ARCSEC, ChangeReport, DiagnoseReport, EffectReport, PositionReport, scatter};
use crate::campaign::{Campaign, Parameter, Role};
use crate::diagnosis::{Alias, Diagnosis, Gap, Grouping, Held, Level, NoiseFrom, Place, Verdict};
use crate::document::chart::{Chart, GapPanel, GapPoint};
use crate::document::number::{level, percent, rounded, significant, trimmed};
use crate::document::{Align, Cell, Content, Detail, Document, Figure, MarkedLine, Rows, Section, Tone};
use crate::language::{Language, code, say};
use crate::plan::grouped;

/// More aliases, levels, positions and steps than this are not listed; the JSON report has all.
const LISTED: usize = 24;
/// Levels that a terminal lists.
const BRIEF: usize = 8;

/// The document of a diagnosis; what was asked, and the diagnosis itself, give the picture and what was taken for granted.
pub fn diagnose_document(report: &DiagnoseReport, of: Option<(&Campaign, &Diagnosis)>, lang: Language) -> Document {
    let mut document = begin(say!(lang, "diagnosis-of", title = report.bench), &report.inputs, lang)
        .facts(report.identity.facts(lang))
        .section(result(report, of, lang))
        .section(shrinking(report, lang));
    document.subtitle = of.map_or_else(String::new, |(campaign, _)| lang.name(&campaign.bench.title).into_owned());
    let cards = report.effects.iter().map(|effect| card(report, effect, lang));
    let missing = cards.fold(Section::new(say!(lang, "what-is-missing")), Section::block);
    let (place, model) = (places(report, lang), model(report, lang));
    // where nothing explains the gap, its places are all that is known of it
    let [next, last] = if report.effects.is_empty() { [place, model] } else { [model, place] };
    document
        .section(missing)
        .section(pattern(report, lang))
        .section(next)
        .section(scatter::section(&report.scatter, lang))
        .section(changes(report, lang))
        .section(last)
        .section(assumptions(report, of, lang))
}

/// The verdict, what was found, and the picture.
fn result(report: &DiagnoseReport, of: Option<(&Campaign, &Diagnosis)>, lang: Language) -> Section {
    let section = Section::new(say!(lang, "result")).verdict(sound(report), lang.sentence(&verdict(report, lang)));
    if report.verdict == Verdict::NotDiagnosable {
        return section.prose(lang.sentence(&would_help(report, lang)));
    }
    let unexplained = report.unexplained.iter().flat_map(|unknown| {
        let pattern = lang.sentence(&lang.name(&unknown.pattern));
        [pattern, lang.sentence(&remainder(report, lang)), nearest(&unknown.nearest, unknown.nearest_explains, lang)]
    });
    let several = report.model_before.len() > 1;
    let rows = report.effects.iter().flat_map(|effect| {
        let (scale, unit) = scale(effect);
        let whole = Found {
            regressor: &effect.regressor,
            quantity: self::of(effect, lang),
            sensor: effect.sensor.as_deref().filter(|_| several).unwrap_or_default(),
            value: effect.value.map(|value| value * scale),
            u: effect.u.map(|u| u * scale),
            expanded: effect.expanded.map(|u| u * scale),
            unit,
            t: effect.t,
            p: effect.p,
            explains: Some(effect.explains),
        };
        // one effect in several sensors: a row each, what all of them explain in the first
        let k = effect.expanded.zip(effect.u).map(|(expanded, u)| expanded / u);
        let of_sensors = effect.in_sensors.iter().enumerate().map(move |(place, own)| Found {
            regressor: &effect.regressor,
            quantity: code(&own.coefficient),
            sensor: &own.sensor,
            value: own.value.map(|value| value * scale),
            u: own.u.map(|u| u * scale),
            expanded: own.u.zip(k).map(|(u, k)| u * k * scale),
            unit: &own.unit,
            t: own.t,
            p: own.p,
            explains: (place == 0).then_some(effect.explains),
        });
        let whole = effect.in_sensors.is_empty().then_some(whole);
        whole.into_iter().chain(of_sensors)
    });
    let rows: Vec<Found<'_>> = rows.collect();
    let level = report.effects.first().map_or(String::new(), |effect| level(effect.level));
    section
        .proses(unexplained)
        .table(found(&rows, Some(&format!("U ({level})")), lang))
        .figures(of.map(|(campaign, diagnosis)| diagnose_figure(campaign, diagnosis, report, lang)))
}

/// The gap as given and after each effect, then each sensor's.
fn shrinking(report: &DiagnoseReport, lang: Language) -> Section {
    let section = Section::new(say!(lang, "the-gap"));
    if report.verdict == Verdict::NotDiagnosable {
        return section;
    }
    let several = report.gap.sensors.len() > 1;
    let one = report.gap.sensors.values().next().filter(|_| !several);
    let with_unit = |what: &str| match one.map_or("", |gaps| gaps.unit.as_str()) {
        "" => what.to_string(),
        unit => format!("{what}, {unit}"),
    };
    let tested = report.steps.iter().any(|step| step.global_p.is_some());
    let of_one = |cell: Cell| if several { "".into() } else { cell };
    let table = Rows::of(report.steps.iter().take(LISTED))
        .left(say!(lang, "in-the-model"), |step| match step.with.last() {
            Some(last) => format!("+ `{last}`"),
            None => say!(lang, "as-given").into(),
        })
        .decimal(with_unit(say!(lang, "residual-sd")), |step| of_one(Cell::digits(step.gap.rms, 4)))
        .decimal(with_unit(say!(lang, "max")), |step| of_one(Cell::Digits(step.gap.max, 4)))
        .decimal(say!(lang, "chi-square"), |step| Cell::Digits(step.gap.chi_square, 4))
        .right(say!(lang, "dof"), |step| step.gap.dof)
        .right(say!(lang, "p-of-what-is-left"), |step| if tested { Cell::p(step.global_p) } else { "".into() })
        .left(say!(lang, "strongest-further-candidate"), |step| step.strongest.as_ref().map(Cell::name))
        .at(Detail::Full)
        .decimal("t", |step| Cell::decimals(step.t, 1))
        .at(Detail::Full)
        .right("p", |step| Cell::p(step.p))
        .at(Detail::Full);
    let decision = report.steps.last().map_or(String::new(), |step| lang.sentence(&lang.name(&step.decision)));
    let sd = one.map(|g| g.sd.map_or(say!(lang, "unknown").into(), |sd| in_text(&significant(sd, 3), &g.unit)));
    let source = noise_source(report.gap.noise.from, lang);
    let noise = sd.into_iter().chain([source]).collect::<Vec<_>>().join(lang.clause());
    section
        .table(table)
        .prose(decision)
        .table(sensors(report, several, lang))
        .prose(lang.sentence(&say!(lang, "noise-floor", noise)))
        .prose(lang.sentence(&tried(report, lang)))
        .prose(lang.sentence(&untried(report, lang)))
        .prose(lang.sentence(&holdout(report, lang)))
}

/// Each sensor's gap, where there are several.
fn sensors(report: &DiagnoseReport, several: bool, lang: Language) -> Rows<(&String, &SensorGapReport)> {
    let found = !report.effects.is_empty();
    let (sd, max) = (say!(lang, "residual-sd"), say!(lang, "max"));
    let at = |what: &str, when| if found { at(what, when, lang) } else { what.to_string() };
    let after = |cell: Cell| if found { cell } else { "".into() };
    Rows::of(report.gap.sensors.iter().filter(|_| several))
        .name(say!(lang, "sensor"), |(id, _)| id)
        .left(say!(lang, "unit"), |(_, gaps)| &gaps.unit)
        .decimal(say!(lang, "noise-sd"), |(_, gaps)| Cell::digits(gaps.sd, 3))
        .decimal(at(sd, "before"), |(_, gaps)| Cell::digits(gaps.rms_before, 4))
        .decimal(at(max, "before"), |(_, gaps)| Cell::Digits(gaps.max_before, 4))
        .decimal(at(sd, "after"), |(_, gaps)| after(Cell::digits(gaps.rms_after, 4)))
        .decimal(at(max, "after"), |(_, gaps)| after(Cell::Digits(gaps.max_after, 4)))
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
    for size in &effect.in_sensors {
        let value = size.value.map_or_else(|| lang.term("not-estimable"), |v| in_text(&rounded(v, size.u), &size.unit));
        let u = size.u.map_or(String::new(), |u| format!(", u = {}", rounded(u, Some(u))));
        let name = code(&size.sensor);
        fact(&name, format!("`{}` = {value}{u}, t = {:.1}", size.coefficient, size.t));
    }
    fact(&lang.title(&lang.term("stated")), against_stated(effect, lang));
    fact(&lang.title(say!(lang, "probability")), probability(effect, lang));
    let [same, near, small] = aliases(effect, lang);
    let listed = |names: &[String]| listed(names, LISTED, lang);
    fact(&lang.title(say!(lang, "cannot-be-distinguished-from")), listed(&same));
    fact(say!(lang, "fits-not-significantly-worse"), listed(&near));
    fact(say!(lang, "only-through-small-terms"), listed(&small));
    fact(say!(lang, "discriminated-by"), separating(effect, lang));
    fact(say!(lang, "no-position-of-this-bench-tells-it"), listed(&effect.separate_never));
    fact(&lang.title(say!(lang, "probable-cause")), lang.name(&effect.why).into_owned());
    fact(say!(lang, "to-confirm"), lang.name(&effect.confirm).into_owned());
    Content::Card { heading: heading(&effect.name, &effect.regressor, lang), tone: Tone::Bad, facts }
}

/// An effect as a heading: it is no sentence, and has no full stop.
pub fn heading(name: &str, regressor: &str, lang: Language) -> String {
    let heading = lang.sentence(&say!(lang, "effect-named", name = lang.name(name), regressor));
    heading.trim_end_matches(['.', '\u{3002}']).to_string()
}

/// Mean residuals at the states of the joints, where something is unexplained.
fn pattern(report: &DiagnoseReport, lang: Language) -> Section {
    let cells = report.unexplained.iter().flat_map(|u| &u.cells).take(LISTED);
    let rows: Vec<Mean<'_>> =
        cells.map(|cell| (position(&cell.at), cell.sensor.as_str(), cell.readings, cell.mean, cell.z, None)).collect();
    let table = means(&rows, lang).note(say!(lang, "mean-residual-at-each-state-of-the")).most(2 * BRIEF);
    Section::new(say!(lang, "the-pattern")).table(table)
}

/// A mean residual: its setting, sensor, readings, size, size in standard deviations, and probability.
type Mean<'a> = (String, &'a str, usize, f64, f64, Option<f64>);

/// Mean residuals, with bars as long as they are significant.
fn means<'a>(rows: &'a [Mean<'a>], lang: Language) -> Rows<&'a Mean<'a>> {
    let largest = rows.iter().fold(0.0_f64, |most, row| most.max(row.4.abs()));
    let table = Rows::of(rows)
        .left(say!(lang, "setting"), |(setting, ..)| setting)
        .name(say!(lang, "sensor"), |(_, sensor, ..)| sensor)
        .right(say!(lang, "readings").to_lowercase(), |(_, _, readings, ..)| *readings)
        .decimal(say!(lang, "mean"), |(.., mean, _, _)| Cell::Digits(*mean, 3))
        .column("", Align::Bar, |(.., z, _)| (z / largest).to_string())
        .at(Detail::Full)
        .decimal("z", |(.., z, _)| Cell::Decimals(*z, 1))
        .right("p", |(.., p)| p.map_or("".into(), Cell::Probability));
    if rows.len() > 12 { table.small() } else { table }
}

/// Model lines, with what was appended marked, and what else the repair does.
fn model(report: &DiagnoseReport, lang: Language) -> Section {
    let line = |id: &str, kept: &str, added: &str| MarkedLine { kept: format!("{id} = {kept}"), added: added.into() };
    let before: Vec<MarkedLine> = report.model_before.iter().map(|(id, text)| line(id, text, "")).collect();
    let changed: Vec<MarkedLine> = report
        .model_after
        .iter()
        .filter_map(|(id, after)| {
            let (kept, added) = appended(report.model_before.get(id)?, after)?;
            Some(line(id, kept, added))
        })
        .collect();
    let mut repairs: Vec<String> = report.effects.iter().filter_map(|effect| repair(effect, lang)).collect();
    if changed.is_empty() {
        let all = report.effects.iter().filter(|e| !e.regressor.contains(':') && !e.coefficient.is_empty());
        repairs.extend(all.map(|e| say!(lang, "is-now-estimated", id = code(&e.coefficient), was = "tilt")));
    }
    let heads = [say!(lang, "as-given"), say!(lang, "with-what-was-found")].into_iter().zip([before, changed]);
    let lines = |section: Section, (head, lines): (&str, Vec<MarkedLine>)| {
        section.prose(format!("{}{}", lang.title(head), lang.colon().trim_end())).block(Content::Marked(lines))
    };
    let section = heads.filter(|(_, lines)| !lines.is_empty()).fold(Section::new(say!(lang, "model")), lines);
    section.list(repairs.iter().map(|text| lang.sentence(text)))
}

/// Each parameter before and after.
fn changes(report: &DiagnoseReport, lang: Language) -> Section {
    let table = Rows::of(&report.parameters)
        .name(say!(lang, "parameter"), |p| &p.id)
        .decimal(say!(lang, "before"), |p| Cell::value(p.before, p.u_before))
        .decimal("u", |p| Cell::value(p.u_before, p.u_before))
        .decimal(say!(lang, "after"), |p| Cell::value(p.after, p.u_after))
        .decimal("u", |p| Cell::value(p.u_after, p.u_after))
        .decimal(say!(lang, "shift"), |p| Cell::value(p.shift, p.u_after_as_named))
        .at(Detail::Roomy)
        .decimal(say!(lang, "shift-u"), |p| p.change_in_u.map(in_u))
        .left(say!(lang, "unit"), |p| &p.unit)
        .tone(|p| if p.change_in_u.is_some_and(|s| s.abs() > 2.0) { Tone::Caution } else { Tone::Plain })
        .note(say!(lang, "marked-shifts-of-more-than-twice-their"));
    let differs = report.parameters.iter().any(|p| p.shift.is_some_and(|s| s != 0.0) || p.remainder_u > 0.0);
    let section = Section::new(say!(lang, "what-it-does-to-the-estimates")).full_unless(differs);
    section.table(table).prose(after_u(report, lang))
}

/// Levels of factors with a significant mean residual.
fn places(report: &DiagnoseReport, lang: Language) -> Section {
    let some = report.verdict != Verdict::NothingMissing;
    let shown = report.places.iter().filter(|place| some && place.significant == Some(true)).take(LISTED);
    let row = |place: &'_ Place| match (place.factor.as_str(), level_said(&place.level)) {
        ("order", number) => say!(lang, "readings-near-number", number),
        (factor, level) => format!("{} {level}", named_factor(factor, lang)),
    };
    let rows: Vec<Mean<'_>> = shown.map(|p| (row(p), p.sensor.as_str(), p.readings, p.mean, p.z, Some(p.p))).collect();
    let table = means(&rows, lang).most(BRIEF).note(say!(lang, "means-of-the-residuals-with-the-model"));
    Section::new(say!(lang, "where-the-gap-is")).table(table)
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
        let all = report.constraints.iter();
        all.filter(move |c| matches!(c.state, Held::Equality | Held::Inactive) == is_kept)
            .map(|c| lang.sentence(&constraint(c, lang)))
    };
    let section = Section::new(say!(lang, "what-was-assumed"));
    let section = section.list(constraints(false)).full().list(constraints(true)).list(points);
    section.facts(facts).figures(bench_figure(of.map(|(campaign, _)| campaign), lang))
}

/// A number with its unit, in a sentence.
fn in_text(number: &str, unit: &str) -> String {
    format!("{number} {unit}").trim_end().into()
}

/// How a verdict sounds: a gap that is more than noise is not in order, whether or not it was explained.
pub fn tone(verdict: Verdict) -> Tone {
    match verdict {
        Verdict::NothingMissing => Tone::Good,
        Verdict::EffectsFound | Verdict::PartlyExplained | Verdict::Unexplained => Tone::Bad,
        Verdict::NotDiagnosable => Tone::Caution,
    }
}

/// What was found: a row of [`found`].
pub struct Found<'a> {
    /// The term.
    pub regressor: &'a str,
    /// What it is, or what the value is of.
    pub quantity: String,
    /// The sensor; empty where there is only one.
    pub sensor: &'a str,
    /// Value.
    pub value: Option<f64>,
    /// Standard uncertainty.
    pub u: Option<f64>,
    /// Expanded uncertainty.
    pub expanded: Option<f64>,
    /// Unit.
    pub unit: &'a str,
    /// Student's t.
    pub t: f64,
    /// Probability by chance.
    pub p: f64,
    /// Share of the residual sum of squares.
    pub explains: Option<f64>,
}

/// What was found, one thing a row; `expanded` is the title of the expanded uncertainties, which stand for u where there are any.
pub fn found<'a>(rows: &'a [Found<'a>], expanded: Option<&str>, lang: Language) -> Rows<&'a Found<'a>> {
    let given = |value: Option<f64>| value.map_or_else(|| "".into(), |u| Cell::Value(u, Some(u)));
    // without U the quantity repeats the effect
    let (quantity, u) = if expanded.is_some() { (Detail::Brief, Detail::Full) } else { (Detail::Full, Detail::Brief) };
    let table = Rows::of(rows)
        .name(say!(lang, "effect"), |row| row.regressor)
        .left(say!(lang, "quantity"), |row| &row.quantity)
        .at(quantity)
        .left(say!(lang, "sensor"), |row| row.sensor)
        .decimal(say!(lang, "value"), |row| Cell::value(row.value, row.expanded.or(row.u)))
        .decimal("u", |row| given(row.u))
        .at(u)
        .decimal(expanded.unwrap_or_default(), |row| given(row.expanded))
        .left(say!(lang, "unit"), |row| row.unit)
        .decimal("t", |row| Cell::Decimals(row.t, 1))
        .right("p", |row| Cell::Probability(row.p))
        .right(say!(lang, "explains"), |row| row.explains.map_or_else(|| "".into(), Cell::Share))
        .at(Detail::Roomy);
    if rows.len() > 1 { table.note(say!(lang, "explains-beyond-the-others")) } else { table }
}

/// What comes nearest of the catalogue, which is not accepted; empty for nothing.
pub fn nearest(names: &[String], explains: f64, lang: Language) -> String {
    match names.is_empty() {
        true => String::new(),
        false => {
            let names = names.iter().map(|name| code(name)).collect::<Vec<_>>().join(" + ");
            say!(lang, "nearest-of-the-catalogue-would-take-off", names, share = percent(explains))
        }
    }
}

/// Names in code type, what stands in parentheses after them as it is; of many so many.
pub fn listed(names: &[String], most: usize, lang: Language) -> String {
    let listed = |text: &String| match text.split_once(" (") {
        Some((name, detail)) => format!("`{name}` ({detail}"),
        None => code(text),
    };
    lang.first_of(&names.iter().map(listed).collect::<Vec<_>>(), most, lang.comma())
}

/// A quantity before or after the effects are in the model, as the title of a column.
pub fn at(what: &str, when: &'static str, lang: Language) -> String {
    format!("{what}{}{}", lang.clause(), lang.word(when))
}

/// The probability of the residuals by chance where nothing is suspected, and a fit would call it lack of fit.
fn contradicting(report: &DiagnoseReport) -> Option<f64> {
    let tested = 1.0 - crate::fit::Settings::default().level;
    report.gap.after.p.filter(|p| report.verdict == Verdict::NothingMissing && *p < tested.max(report.significance))
}

/// How the result sounds.
fn sound(report: &DiagnoseReport) -> Tone {
    contradicting(report).map_or_else(|| tone(report.verdict), |_| Tone::Caution)
}

/// The verdict in one sentence, without a full stop.
fn verdict(report: &DiagnoseReport, lang: Language) -> String {
    let line_estimated = report.scatter.iter().any(|s| s.estimated && !s.source.starts_with("readings of "));
    let n = report.effects.len();
    let names = report.effects.iter().map(|effect| with_others(report, effect, lang)).collect::<Vec<_>>();
    let names = names.join(lang.semicolon());
    let noise = match report.gap.noise.from {
        _ if line_estimated => "scatter",
        NoiseFrom::Residuals => "residuals",
        _ => "known",
    };
    if let Some(p) = contradicting(report).filter(|_| noise == "known") {
        return say!(lang, "nothing-is-probable", p = significant(p, 2));
    }
    let found = say!(lang, "effects-are-missing", n, names);
    let suspected = suspected(&report.suspected, report.model_before.len() > 1, lang);
    said(report.verdict, (found, suspected), exceeds(&report.gap.after), noise, "campaign", lang)
}

/// A verdict in one sentence: with what was found and is suspected (empty for nothing), whether the residuals are more than noise, and what of.
pub fn said(
    verdict: Verdict,
    (found, suspected): (String, String),
    more: bool,
    noise: &'static str,
    of: &'static str,
    lang: Language,
) -> String {
    match verdict {
        Verdict::EffectsFound | Verdict::PartlyExplained if !suspected.is_empty() => {
            say!(lang, "and-further-effects-are-suspected", found, suspected)
        }
        Verdict::EffectsFound => found,
        Verdict::PartlyExplained => say!(lang, "what-remains-is-more-than-noise", found, more),
        Verdict::NothingMissing => say!(lang, "nothing-is-missing", noise),
        Verdict::Unexplained if !suspected.is_empty() => say!(lang, "effects-are-suspected", more, suspected),
        Verdict::Unexplained => say!(lang, "unexplained", more),
        Verdict::NotDiagnosable => say!(lang, "not-diagnosable", of),
    }
}

/// Do residuals exceed the noise? Their order and shape say something, whatever their size.
pub fn exceeds(gap: &Gap) -> bool {
    gap.p.is_none_or(|p| p < 1.0 - crate::fit::Settings::default().level)
}

/// An effect with the sensors that have it, where there are several.
fn in_sensors(name: String, several: bool, mut sensors: Vec<&str>, lang: Language) -> String {
    sensors.sort_unstable();
    match sensors.is_empty() || !several {
        true => name,
        false => say!(lang, "effect-in-sensors", name, sensors = sensors.join(lang.comma())),
    }
}

/// The effects that are suspected, each with its probability; those of several sensors together.
pub fn suspected(suspected: &[SuspectReport], several: bool, lang: Language) -> String {
    let groups = grouped(suspected.iter().map(|suspect| (suspect, &suspect.regressor)));
    let suspected = |group: &Vec<&SuspectReport>| {
        let first = group.first()?;
        let name = say!(lang, "effect-named", name = lang.name(&first.name), regressor = first.regressor);
        let sensors: Vec<&str> = group.iter().filter_map(|own| own.sensor.as_deref()).collect();
        let name = in_sensors(name, several, sensors, lang);
        let mut each: Vec<String> = group.iter().map(|own| format!("{:.0} %", 100.0 * own.probability)).collect();
        each.dedup();
        Some(say!(lang, "effect-with-probability", name, p = each.join(lang.comma())))
    };
    groups.iter().filter_map(suspected).collect::<Vec<_>>().join(lang.semicolon())
}

/// An effect with how many others it could as well be.
fn with_others(report: &DiagnoseReport, effect: &EffectReport, lang: Language) -> String {
    let [same, near, _] = aliases(effect, lang);
    let name = say!(lang, "effect-named", name = lang.name(&effect.name), regressor = effect.regressor);
    let several = effect.in_sensors.iter().map(|own| own.sensor.as_str());
    let sensors: Vec<&str> = effect.sensor.as_deref().into_iter().chain(several).collect();
    let name = in_sensors(name, report.model_before.len() > 1, sensors, lang);
    match same.len() + near.len() {
        0 => name,
        n => say!(lang, "effect-or-others", name, n),
    }
}

fn tried(report: &DiagnoseReport, lang: Language) -> String {
    let averaged = report.averaged_from.map_or(String::new(), |from| {
        let groups = report.residuals.iter().map(|r| r.index).max().unwrap_or(0);
        say!(lang, "readings-were-averaged", from, groups)
    });
    let significance = report.significance.to_string();
    say!(
        lang,
        "candidates-tried",
        candidates = report.candidates.to_string(),
        distinct = report.distinct_candidates.to_string(),
        significance,
        averaged
    )
}

/// Columns without a name; empty where all have one.
fn untried(report: &DiagnoseReport, lang: Language) -> String {
    let titles: Vec<String> = report.untried_columns.iter().map(|title| format!("'{title}'")).collect();
    match titles.is_empty() {
        true => String::new(),
        false => say!(lang, "columns-not-tried", n = titles.len(), columns = titles.join(lang.comma())),
    }
}

/// What would help where nothing can be diagnosed; empty where nothing is known to.
fn would_help(report: &DiagnoseReport, lang: Language) -> String {
    let positions: Vec<String> = report.would_help.iter().map(position).collect();
    match positions.is_empty() {
        true => String::new(),
        false => say!(lang, "one-further-reading-would-help", positions = positions.join(lang.semicolon())),
    }
}

/// Where the noise floor comes from.
pub fn noise_source(from: NoiseFrom, lang: Language) -> String {
    say!(lang, "noise-from", from = from.name())
}

/// What the numbers of an effect are multiplied by, and the unit that they then have.
fn scale(effect: &EffectReport) -> (f64, &str) {
    if effect.arcsec.is_some() { (ARCSEC, "arcsec") } else { (1.0, &effect.unit) }
}

/// What the value is of: the coefficient, or the error of what was stated.
fn of(effect: &EffectReport, lang: Language) -> String {
    match effect.regressor.split_once(':') {
        Some(("known", id)) => say!(lang, "error-of", id),
        Some(("prior", id)) => say!(lang, "error-of-the-prior-of", id),
        Some(("constraint", _)) => say!(lang, "it-misses-by").into(),
        _ if effect.coefficient.is_empty() => String::new(),
        _ => code(&effect.coefficient),
    }
}

/// Whether the error of something stated is within what was stated; empty for anything else.
fn against_stated(effect: &EffectReport, lang: Language) -> String {
    let (Some(stated), Some(value)) = (effect.stated_u, effect.value) else { return String::new() };
    if !(stated > 0.0) {
        return say!(lang, "exact").into();
    }
    let times = value.abs() / stated;
    let within = times <= 2.0;
    let times = if within { format!("{times:.1}") } else { significant(times, 2) };
    say!(lang, "against-its-stated-uncertainty", within, times)
}

/// What the repair does to the question besides a longer model line.
fn repair(effect: &EffectReport, lang: Language) -> Option<String> {
    let id = &effect.coefficient;
    Some(match effect.regressor.split_once(':') {
        Some((was @ ("tilt" | "known"), _)) => say!(lang, "is-now-estimated", id, was),
        Some((was @ "prior", parameter)) => say!(lang, "is-now-estimated", id = parameter, was),
        Some(("constraint", number)) => say!(lang, "constraint-is-taken-away", number),
        _ => return None,
    })
}

/// The model line with effects: what stood there, and what was appended; `None` where it is as it was.
fn appended<'a>(before: &str, after: &'a str) -> Option<(&'a str, &'a str)> {
    let added = after.strip_prefix(before).filter(|added| !added.is_empty())?;
    let term = added.trim_start_matches([' ', '+']);
    let kept = after.get(..after.len() - term.len())?;
    Some((kept, term))
}

/// Aliases by what sets them apart: the same column; fits that are not significantly worse, each with how much; those seen only through small terms, each
/// with the share of its column.
fn aliases(effect: &EffectReport, lang: Language) -> [Vec<String>; 3] {
    let [mut same, mut near, mut small] = [const { Vec::new() }; 3];
    for alias in &effect.aliases {
        let with = alias.together_with.as_ref();
        let with = with.map_or(String::new(), |other| format!(" ({})", say!(lang, "together-with", other)));
        let name = format!("{}{with}", alias.regressor);
        if alias.vanishing {
            small.push(format!("{name} ({})", seen(alias, lang)));
        } else if alias.exact {
            same.push(name);
        } else {
            near.push(format!("{name} (+{:.1})", alias.excess));
        }
    }
    [same, near, small]
}

/// The positions that would tell an effect from its aliases, each with how many of them; empty for none.
fn separating(effect: &EffectReport, lang: Language) -> String {
    let places = effect.separate_by.iter().zip(&effect.separate_tells);
    let one = |(place, n): (&PositionReport, &usize)| {
        let [n, of] = [*n, effect.separate_of].map(|count| count.to_string());
        say!(lang, "discriminates", at = format!("`{}`", position(place)), n, of)
    };
    places.map(one).collect::<Vec<String>>().join(lang.semicolon())
}

/// What an alias with small terms only is seen by.
fn seen(alias: &Alias, lang: Language) -> String {
    if alias.visible < alias.size {
        say!(lang, "the-model-has-all-but", share = share(alias.visible))
    } else {
        say!(lang, "of-its-full-size", share = share(alias.size))
    }
}

/// A share in percent, two digits.
fn share(share: f64) -> String {
    format!("{} %", significant(100.0 * share, 2))
}

fn position(position: &PositionReport) -> String {
    position.iter().map(|(key, value)| format!("{key} {value}")).collect::<Vec<_>>().join(", ")
}

fn level_said(level: &Level) -> String {
    match level {
        Level::Number(v) => trimmed(*v),
        Level::Text(text) => text.clone(),
    }
}

/// A shift in standard uncertainties, one decimal, never a negative zero.
fn in_u(shift: f64) -> String {
    format!("{:+.1}", if shift.abs() < 0.05 { 0.0 } else { shift })
}

/// What the standard uncertainties after are of; empty where they are those of the fit.
fn after_u(report: &DiagnoseReport, lang: Language) -> String {
    let aliases = report.parameters.iter().any(|p| p.alias_u > 0.0);
    let has_remainder = report.parameters.iter().any(|p| p.remainder_u > 0.0);
    let what = match (aliases, has_remainder) {
        (true, true) => "both",
        (true, false) => "aliases",
        (false, true) => "remainder",
        (false, false) => return String::new(),
    };
    say!(lang, "u-after-includes", what)
}

/// What is unexplained in one sentence: what it follows and how large it is.
fn remainder(report: &DiagnoseReport, lang: Language) -> String {
    let Some(unexplained) = &report.unexplained else { return String::new() };
    let follows = match &unexplained.follows {
        Some(name) => say!(lang, "what-is-unexplained-follows", name = lang.name(name)),
        None => say!(lang, "what-is-unexplained-differs").into(),
    };
    let unit = report.gap.sensors.values().next().map_or("", |s| s.unit.as_str());
    match unexplained.sd.filter(|sd| *sd > 0.0) {
        Some(sd) if report.gap.sensors.len() == 1 => {
            say!(lang, "with-a-standard-deviation-of", follows, sd = significant(sd, 2), unit)
        }
        _ => follows,
    }
}

/// The probability of an effect; empty where there is none to speak of.
fn probability(effect: &EffectReport, lang: Language) -> String {
    let percent = |p: f64| if p > 0.999 { "> 99.9 %".to_string() } else { format!("{:.1} %", 100.0 * p) };
    let p = percent(effect.probability);
    if effect.aliases.is_empty() {
        return p;
    }
    say!(lang, "probability-of-it-or-an-alias", p, named = percent(effect.probability_as_named))
}

/// What a fit of the repaired model leaves out: that the effect could be one of its aliases; `None` where that moves nothing.
pub fn alias_note(report: &DiagnoseReport, lang: Language) -> Option<String> {
    let times = |p: &ChangeReport| p.u_after_as_named.filter(|u| *u > 0.0).map(|u| p.alias_half_width / u);
    let moved = report.parameters.iter().filter(|p| p.alias_half_width > 0.0);
    let most = moved.max_by(|a, b| times(a).unwrap_or(0.0).total_cmp(&times(b).unwrap_or(0.0)))?;
    let named: Vec<&str> =
        report.effects.iter().filter(|e| !e.aliases.is_empty()).map(|e| e.regressor.as_str()).collect();
    Some(say!(
        lang,
        "fit-takes-the-effect-as-named",
        named = named.join(", "),
        id = most.id,
        by = significant(most.alias_half_width, 2),
        unit = most.unit,
        u = most.u_after_as_named.map_or("-".into(), |u| significant(u, 2))
    ))
}

fn constraint(constraint: &AssertedReport, lang: Language) -> String {
    let state = lang.term(constraint.state.name());
    say!(lang, "constraint-state", index = constraint.index.to_string(), text = constraint.text, state)
}

/// The holdout in one sentence; empty where there is none.
fn holdout(report: &DiagnoseReport, lang: Language) -> String {
    let Some(holdout) = &report.holdout else { return String::new() };
    let two = |x: f64| format!("{x:.2}");
    let (found, after) = (holdout.after.is_some(), holdout.after.map_or(String::new(), two));
    say!(lang, "holdout", n = holdout.positions, before = two(holdout.before), found, after, skipped = holdout.skipped)
}

/// Most sensors in one picture.
const PANELS: usize = 6;
/// More points than this in one picture are thinned; those far out stay.
const POINTS: usize = 2400;

/// Residuals before and after, as the page of a diagnosis has them.
pub fn diagnose_figure(campaign: &Campaign, diagnosis: &Diagnosis, report: &DiagnoseReport, lang: Language) -> Figure {
    let sensors = drawn_sensors(campaign, diagnosis, report);
    let total: usize = sensors.iter().filter_map(|k| gap_of(campaign, report, *k)).map(|gap| gap.readings).sum();
    let every = total.div_ceil(POINTS).max(1);
    let panels: Vec<GapPanel> =
        sensors.iter().map(|k| panel(campaign, diagnosis, report, *k, (every, sensors.len()), lang)).collect();
    let factor = diagnosis.grouping.as_ref().map_or("", |g| g.factor.as_str());
    let mut caption = vec![say!(lang, "each-reading-minus-the-model", found = !report.effects.is_empty())];
    if !factor.is_empty() {
        caption.push(say!(lang, "readings-are-grouped-by-which-the-gap", factor = named_factor(factor, lang)));
    }
    if every > 1 {
        let every = every.to_string();
        caption.push(say!(lang, "one-reading-in-is-drawn", every));
    }
    let left = campaign.bench.sensors.len() - sensors.len();
    if left > 0 {
        caption.push(say!(lang, "further-sensors-are-not-drawn", n = left));
    }
    let caption = caption.join(lang.space());
    Figure::new(caption, Chart::Gap(panels, factor.into()), true)
}

fn gap_of<'a>(campaign: &Campaign, report: &'a DiagnoseReport, sensor: usize) -> Option<&'a SensorGapReport> {
    report.gap.sensors.get(&campaign.bench.sensors.get(sensor)?.id)
}

/// The sensors of the picture, in the bench's order: those with an effect first, then those whose gap is largest against their noise.
fn drawn_sensors(campaign: &Campaign, diagnosis: &Diagnosis, report: &DiagnoseReport) -> Vec<usize> {
    let size = |k: usize| {
        let gap = gap_of(campaign, report, k)?;
        let named = diagnosis.effects.iter().any(|finding| finding.effect.sensor == Some(k));
        let relative = gap.rms_before.zip(gap.sd).map_or(0.0, |(rms, sd)| rms / sd);
        Some((k, named, relative))
    };
    let mut sensors: Vec<(usize, bool, f64)> = (0..campaign.bench.sensors.len()).filter_map(size).collect();
    sensors.sort_by(|a, b| b.1.cmp(&a.1).then(b.2.total_cmp(&a.2)));
    let mut shown: Vec<usize> = sensors.into_iter().take(PANELS).map(|(k, ..)| k).collect();
    shown.sort_unstable();
    shown
}

fn panel(
    campaign: &Campaign,
    diagnosis: &Diagnosis,
    report: &DiagnoseReport,
    sensor: usize,
    (every, panels): (usize, usize),
    lang: Language,
) -> GapPanel {
    let (id, unit) = campaign.bench.sensors.get(sensor).map_or(("", ""), |s| (s.id.as_str(), s.unit.as_str()));
    let repaired = diagnosis.after.is_some();
    let levels = diagnosis.grouping.as_ref().map(ordered).unwrap_or_default();
    let level = |reading: usize| diagnosis.grouping.as_ref().and_then(|g| g.of.get(reading).copied().flatten());
    let mut rows: Vec<(usize, GapPoint)> = Vec::new();
    for (k, residual) in report.residuals.iter().filter(|residual| residual.sensor == id).enumerate() {
        let band = residual.sd.map(|sd| 2.0 * sd);
        let far = band.is_some_and(|band| residual.before.abs() > 2.0 * band || residual.after.abs() > 2.0 * band);
        if k % every != 0 && !far {
            continue;
        }
        let place = level(residual.index - 1).and_then(|level| levels.iter().position(|(known, _)| *known == level));
        let group = place.and_then(|place| levels.get(place)).map_or(String::new(), |(_, label)| label.clone());
        let after = repaired.then_some(residual.after);
        rows.push((place.unwrap_or(levels.len()), GapPoint { group, before: residual.before, after, band }));
    }
    rows.sort_by_key(|(place, _)| *place);
    // the title of a low panel has little room
    let title = if panels > 2 { id.to_string() } else { format!("{id} {}", say!(lang, "residual")) };
    GapPanel { title, unit: unit.into(), points: rows.into_iter().map(|(_, p)| p).collect() }
}

/// Levels with their labels: numbers from small to large, labels as they come.
fn ordered(grouping: &Grouping) -> Vec<(usize, String)> {
    let size = |level: &Level| if let Level::Number(v) = level { *v } else { 0.0 };
    let mut levels: Vec<(usize, &Level)> = grouping.levels.iter().enumerate().collect();
    levels.sort_by(|a, b| size(a.1).total_cmp(&size(b.1)));
    levels.into_iter().map(|(k, level)| (k, level_said(level))).collect()
}

/// A factor: a column of the campaign in code type, anything else in words.
fn named_factor(name: &str, lang: Language) -> String {
    match lang.name(name) {
        std::borrow::Cow::Borrowed(name) => code(name),
        std::borrow::Cow::Owned(name) => name,
    }
}
