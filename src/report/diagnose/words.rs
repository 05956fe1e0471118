//! Sentences about a diagnosis, and the table of what was found, of campaigns and of missions alike.

use super::super::{ARCSEC, PositionReport};
use super::{AliasReport, AssertedReport, ChangeReport, DiagnoseReport, EffectReport, LevelReport};
use crate::diagnosis::{NoiseFrom, Verdict};
use crate::document::number::{percent, significant, trimmed};
use crate::document::{Align, Cell, Detail, Table, Tone};
use crate::language::{Language, say};

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
    pub explains: f64,
}

/// What was found, one thing a row; `expanded` is the title of the expanded uncertainties.
pub fn found<'a>(rows: impl Iterator<Item = Found<'a>>, expanded: &str, lang: Language) -> Table {
    let mut table = Table::new(&[
        (say!(lang, "effect"), Align::Left),
        (say!(lang, "quantity"), Align::Left),
        (say!(lang, "sensor"), Align::Left),
        (say!(lang, "value"), Align::Decimal),
        ("u", Align::Decimal),
        (expanded, Align::Decimal),
        (say!(lang, "unit"), Align::Left),
        ("t", Align::Decimal),
        ("p", Align::Right),
        (say!(lang, "explains"), Align::Right),
    ])
    .at(Detail::Roomy, &[9]);
    let given = |own: Option<f64>| own.map_or_else(|| "".into(), |u| Cell::Value(u, Some(u)));
    for own in rows {
        table.row(vec![
            Cell::name(own.regressor),
            own.quantity.into(),
            own.sensor.into(),
            Cell::value(own.value, own.expanded.or(own.u)),
            given(own.u),
            given(own.expanded),
            own.unit.into(),
            Cell::Decimals(own.t, 1),
            Cell::Probability(own.p),
            Cell::Share(own.explains),
        ]);
    }
    if table.rows.len() > 1 {
        table.note = say!(lang, "explains-beyond-the-others").into();
    }
    table
}

/// What comes nearest of the catalogue, which is not accepted; empty for nothing.
pub fn nearest(names: &[String], explains: f64, lang: Language) -> String {
    match names.is_empty() {
        true => String::new(),
        false => {
            let names = names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(" + ");
            say!(lang, "nearest-of-the-catalogue-would-take-off", names, share = percent(explains))
        }
    }
}

/// Names in code type, what stands in parentheses after them as it is; of many so many.
pub fn listed(names: &[String], most: usize, lang: Language) -> String {
    let code = |text: &String| match text.split_once(" (") {
        Some((name, rest)) => format!("`{name}` ({rest}"),
        None => format!("`{text}`"),
    };
    lang.first_of(&names.iter().map(code).collect::<Vec<_>>(), most, lang.comma())
}

/// A quantity before or after the effects are in the model, as the title of a column.
pub fn at(what: &str, when: &'static str, lang: Language) -> String {
    format!("{what}{}{}", lang.clause(), lang.word(when))
}

/// The verdict in one sentence, without a full stop.
pub fn verdict(report: &DiagnoseReport, lang: Language) -> String {
    let known = report.gap.noise.from != NoiseFrom::Residuals;
    let line_estimated = report.scatter.iter().any(|s| s.estimated && !s.source.starts_with("readings of "));
    let n = report.effects.len();
    let names = report.effects.iter().map(|effect| named(effect, lang)).collect::<Vec<_>>();
    let names = names.join(lang.semicolon());
    let suspected = suspected(report, lang);
    match report.verdict {
        Verdict::EffectsFound if report.suspected.is_empty() => say!(lang, "effects-are-missing", n, names),
        Verdict::EffectsFound => {
            let found = say!(lang, "effects-are-missing", n, names);
            say!(lang, "and-further-effects-are-suspected", found, suspected)
        }
        Verdict::PartlyExplained => {
            let found = say!(lang, "effects-are-missing", n, names);
            say!(lang, "what-remains-is-more-than-noise", found)
        }
        Verdict::Unexplained if !report.suspected.is_empty() => say!(lang, "effects-are-suspected", suspected),
        Verdict::NothingMissing if line_estimated => say!(lang, "nothing-is-missing", noise = "scatter"),
        Verdict::NothingMissing if known => say!(lang, "nothing-is-missing", noise = "known"),
        Verdict::NothingMissing => say!(lang, "nothing-is-missing", noise = "residuals"),
        Verdict::Unexplained => say!(lang, "unexplained").into(),
        Verdict::NotDiagnosable => say!(lang, "not-diagnosable", of = "campaign"),
    }
}

/// The effects that are suspected, each with its probability.
pub fn suspected(report: &DiagnoseReport, lang: Language) -> String {
    let own = |own: &super::SuspectReport| {
        let name = say!(lang, "effect-named", name = lang.name(&own.name), regressor = own.regressor);
        say!(lang, "effect-with-probability", name, p = format!("{:.0} %", 100.0 * own.probability))
    };
    report.suspected.iter().map(own).collect::<Vec<_>>().join(lang.semicolon())
}

/// An effect with how many others it could as well be.
fn named(effect: &EffectReport, lang: Language) -> String {
    let aliases = aliases(effect, lang);
    let name = say!(lang, "effect-named", name = lang.name(&effect.name), regressor = effect.regressor);
    match aliases.same.len() + aliases.near.len() {
        0 => name,
        n => say!(lang, "effect-or-others", name, n),
    }
}

/// How much was tried.
pub fn tried(report: &DiagnoseReport, lang: Language) -> String {
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

/// What would help where nothing can be diagnosed; empty where nothing is known to.
pub fn would_help(report: &DiagnoseReport, lang: Language) -> String {
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
pub fn scale(effect: &EffectReport) -> (f64, &str) {
    if effect.arcsec.is_some() { (ARCSEC, "arcsec") } else { (1.0, &effect.unit) }
}

/// What the value is of: the coefficient, or the error of what was stated.
pub fn of(effect: &EffectReport, lang: Language) -> String {
    match effect.regressor.split_once(':') {
        Some(("known", id)) => say!(lang, "error-of", id),
        Some(("prior", id)) => say!(lang, "error-of-the-prior-of", id),
        Some(("constraint", _)) => say!(lang, "it-misses-by").into(),
        _ if effect.coefficient.is_empty() => String::new(),
        _ => format!("`{}`", effect.coefficient),
    }
}

/// Whether the error of something stated is within what was stated; empty for anything else.
pub fn against_stated(effect: &EffectReport, lang: Language) -> String {
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
pub fn repair(effect: &EffectReport, lang: Language) -> Option<String> {
    let id = &effect.coefficient;
    Some(match effect.regressor.split_once(':') {
        Some((was @ ("tilt" | "known"), _)) => say!(lang, "is-now-estimated", id, was),
        Some((was @ "prior", parameter)) => say!(lang, "is-now-estimated", id = parameter, was),
        Some(("constraint", number)) => say!(lang, "constraint-is-taken-away", number),
        _ => return None,
    })
}

/// The model line with effects: what stood there, and what was appended; `None` where it is as it was.
pub fn appended<'a>(before: &str, after: &'a str) -> Option<(&'a str, &'a str)> {
    let added = after.strip_prefix(before).filter(|added| !added.is_empty())?;
    let term = added.trim_start_matches([' ', '+']);
    let kept = after.get(..after.len() - term.len())?;
    Some((kept, term))
}

/// Aliases by what sets them apart.
#[derive(Debug, Default)]
pub struct Aliases {
    /// The same column.
    pub same: Vec<String>,
    /// They fit not significantly worse; each with how much.
    pub near: Vec<String>,
    /// Seen only through small terms; each with the share of its column.
    pub small: Vec<String>,
}

/// The aliases of an effect.
pub fn aliases(effect: &EffectReport, lang: Language) -> Aliases {
    let mut sorted = Aliases::default();
    for alias in &effect.aliases {
        let with = alias.together_with.as_ref();
        let with = with.map_or(String::new(), |other| format!(" ({})", say!(lang, "together-with", other)));
        let name = format!("{}{with}", alias.regressor);
        if alias.only_small_terms {
            sorted.small.push(format!("{name} ({})", seen(alias, lang)));
        } else if alias.exact {
            sorted.same.push(name);
        } else {
            sorted.near.push(format!("{name} (+{:.1})", alias.excess));
        }
    }
    sorted
}

/// The positions that would tell an effect from its aliases, each with how many of them; empty for none.
pub fn separating(effect: &EffectReport, lang: Language) -> String {
    let told = effect.separate_by.iter().zip(&effect.separate_tells);
    let one = |(own, n): (&PositionReport, &usize)| {
        let [n, of] = [*n, effect.separate_of].map(|count| count.to_string());
        say!(lang, "discriminates", at = format!("`{}`", position(own)), n, of)
    };
    told.map(one).collect::<Vec<String>>().join(lang.semicolon())
}

/// What an alias with small terms only is seen by.
fn seen(alias: &AliasReport, lang: Language) -> String {
    if alias.visible < alias.size {
        say!(lang, "the-model-has-all-but", share = share(alias.visible))
    } else {
        say!(lang, "of-its-full-size", share = share(alias.size))
    }
}

/// A share in percent, two digits.
pub fn share(share: f64) -> String {
    format!("{} %", significant(100.0 * share, 2))
}

/// A position as its keys and values.
pub fn position(position: &PositionReport) -> String {
    position.iter().map(|(key, value)| format!("{key} {value}")).collect::<Vec<_>>().join(", ")
}

/// A level of a factor.
pub fn level(level: &LevelReport) -> String {
    match level {
        LevelReport::Number(v) => trimmed(*v),
        LevelReport::Text(text) => text.clone(),
    }
}

/// A shift in standard uncertainties, one decimal, never a negative zero.
pub fn in_u(shift: f64) -> String {
    format!("{:+.1}", if shift.abs() < 0.05 { 0.0 } else { shift })
}

/// What the standard uncertainties after are of; empty where they are those of the fit.
pub fn after_u(report: &DiagnoseReport, lang: Language) -> String {
    let aliases = report.parameters.iter().any(|p| p.alias_u > 0.0);
    let rest = report.parameters.iter().any(|p| p.remainder_u > 0.0);
    let what = match (aliases, rest) {
        (true, true) => "both",
        (true, false) => "aliases",
        (false, true) => "remainder",
        (false, false) => return String::new(),
    };
    say!(lang, "u-after-includes", what)
}

/// What is unexplained in one sentence: what it follows and how large it is.
pub fn remainder(report: &DiagnoseReport, lang: Language) -> String {
    let Some(own) = &report.unexplained else { return String::new() };
    let follows = match &own.follows {
        Some(name) => say!(lang, "what-is-unexplained-follows", name = lang.name(name)),
        None => say!(lang, "what-is-unexplained-differs").into(),
    };
    let unit = report.gap.sensors.values().next().map_or("", |s| s.unit.as_str());
    match own.sd.filter(|sd| *sd > 0.0) {
        Some(sd) if report.gap.sensors.len() == 1 => {
            say!(lang, "with-a-standard-deviation-of", follows, sd = significant(sd, 2), unit)
        }
        _ => follows,
    }
}

/// The probability of an effect; empty where there is none to speak of.
pub fn probability(effect: &EffectReport, lang: Language) -> String {
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

/// What was done with a constraint.
pub fn constraint(constraint: &AssertedReport, lang: Language) -> String {
    let state = lang.term(constraint.state.name());
    say!(lang, "constraint-state", index = constraint.index.to_string(), text = constraint.text, state)
}

/// The holdout in one sentence; empty where there is none.
pub fn holdout(report: &DiagnoseReport, lang: Language) -> String {
    let Some(own) = &report.holdout else { return String::new() };
    let after = own.after.map(|after| format!("{after:.2}"));
    let after = after.map_or(String::new(), |after| say!(lang, "holdout-after", after));
    let skipped = match own.skipped {
        0 => String::new(),
        n => say!(lang, "holdout-skipped", n),
    };
    say!(lang, "holdout", n = own.positions, before = format!("{:.2}", own.before), after, skipped)
}
