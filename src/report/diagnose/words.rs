//! Sentences about a diagnosis that the terminal and the page share.

pub use super::super::table::trimmed;
use super::super::table::{rounded, significant};
use super::super::{ARCSEC, PositionReport};
use super::{AliasReport, ChangeReport, DiagnoseReport, EffectReport, LevelReport};
use crate::diagnosis::{Held, NoiseFrom, Verdict};

/// The verdict in one sentence, without a full stop.
pub fn verdict(report: &DiagnoseReport) -> String {
    let known = report.gap.noise.from != NoiseFrom::Residuals;
    let line_estimated = report.scatter.iter().any(|s| s.estimated && !s.source.starts_with("readings of "));
    match (report.verdict, report.effects.as_slice()) {
        (Verdict::EffectsFound, [one]) => format!("one effect is missing from the model: {}", named(one)),
        (Verdict::EffectsFound, several) => {
            let names: Vec<String> = several.iter().map(named).collect();
            format!("{} effects are missing from the model: {}", several.len(), names.join("; and "))
        }
        (Verdict::PartlyExplained, several) => {
            let names: Vec<String> = several.iter().map(named).collect();
            let count = if several.len() == 1 { "one effect is".into() } else { format!("{} effects are", several.len()) };
            format!("{count} missing from the model: {}; what remains is more than noise, and nothing in the catalogue explains it", names.join("; and "))
        }
        (Verdict::NothingMissing, _) if line_estimated => {
            "no effect explains more than chance; how much scatters is estimated from these readings, so that is all they can say".into()
        }
        (Verdict::NothingMissing, _) if known => "the gap is noise".into(),
        (Verdict::NothingMissing, _) => {
            "no effect explains more than chance; the noise is known from the residuals alone, so that is all they can say".into()
        }
        (Verdict::Unexplained, _) => "something is missing from the model, and nothing in the catalogue explains it".into(),
        (Verdict::NotDiagnosable, _) => {
            "nothing can be diagnosed: the readings only just determine the unknowns, and nothing is left to check them"
                .into()
        }
    }
}

/// An effect with how many others it could as well be.
fn named(effect: &EffectReport) -> String {
    let aliases = aliases(effect);
    let name = format!("{} (`{}`)", effect.name, effect.regressor);
    match aliases.same.len() + aliases.near.len() {
        0 => name,
        1 => format!("{name}, or one other that this schedule cannot tell from it"),
        n => format!("{name}, or one of {n} others that this schedule cannot tell from it"),
    }
}

/// How much was tried.
pub fn tried(report: &DiagnoseReport) -> String {
    let averaged = report.averaged_from.map_or(String::new(), |from| {
        let groups = report.residuals.iter().map(|r| r.index).max().unwrap_or(0);
        format!("; {from} readings were averaged to {groups}, each of one setting in one stretch of time")
    });
    format!(
        "{} candidates tried, {} of them distinct on this schedule; significance {}{averaged}",
        report.candidates, report.distinct_candidates, report.significance
    )
}

/// What would help where nothing can be diagnosed; empty where nothing is known to.
pub fn would_help(report: &DiagnoseReport) -> String {
    let positions: Vec<String> = report.would_help.iter().map(position).collect();
    match positions.is_empty() {
        true => String::new(),
        false => format!("one further reading would change that, best at {}", positions.join("; or ")),
    }
}

/// Where the noise floor comes from.
pub fn noise_source(from: NoiseFrom) -> &'static str {
    match from {
        NoiseFrom::Residuals => {
            "from the residuals of the finished model: nothing else tells, so completeness cannot be tested"
        }
        NoiseFrom::Stated => "as stated",
        NoiseFrom::Replicates => "from replicates",
    }
}

/// A coefficient: value, standard uncertainty, expanded uncertainty, each rounded, and their unit; `None` where it is not determined.
pub fn value(effect: &EffectReport) -> Option<(String, Option<String>, Option<String>, String)> {
    let scale = if effect.arcsec.is_some() { ARCSEC } else { 1.0 };
    let unit = if effect.arcsec.is_some() { "arcsec".to_string() } else { effect.unit.clone() };
    let u = effect.u.map(|u| u * scale);
    let expanded = effect.expanded.map(|u| u * scale);
    let text = |v: f64| rounded(v, u);
    Some((text(effect.value? * scale), u.map(text), expanded.map(text), unit))
}

/// What the value is of: the coefficient, or the error of what was stated.
pub fn of(effect: &EffectReport) -> String {
    match effect.regressor.split_once(':') {
        Some(("known", id)) => format!("error of {id}"),
        Some(("prior", id)) => format!("error of the prior of {id}"),
        Some(("constraint", _)) => "it misses by".into(),
        _ => effect.coefficient.clone(),
    }
}

/// Whether the error of something stated is within what was stated; empty for anything else.
pub fn against_stated(effect: &EffectReport) -> String {
    let (Some(stated), Some(value)) = (effect.stated_u, effect.value) else { return String::new() };
    if !(stated > 0.0) {
        return "it was stated as exact".into();
    }
    let times = value.abs() / stated;
    if times <= 2.0 {
        return format!(
            "that is {times:.1} times its stated standard uncertainty: no mistake, but the readings know it better; estimate it, with what was stated as a prior"
        );
    }
    format!("that is {} times its stated standard uncertainty: what was stated is wrong", significant(times, 2))
}

/// What the repair does to the question besides a longer model line.
pub fn repair(effect: &EffectReport) -> Option<String> {
    let id = &effect.coefficient;
    Some(match effect.regressor.split_once(':') {
        Some(("tilt", _)) => format!("{id} is estimated, no longer taken as zero"),
        Some(("known", _)) => format!("{id} is estimated, no longer taken as known"),
        Some(("prior", parameter)) => format!("{parameter} is estimated without its prior"),
        Some(("constraint", number)) => format!("constraint {number} is taken away"),
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
pub fn aliases(effect: &EffectReport) -> Aliases {
    let mut sorted = Aliases::default();
    for alias in &effect.aliases {
        let with = alias.together_with.as_ref().map_or(String::new(), |other| format!(" (with {other})"));
        let name = format!("{}{with}", alias.regressor);
        if alias.only_small_terms {
            sorted.small.push(format!("{name} ({})", seen(alias)));
        } else if alias.exact {
            sorted.same.push(name);
        } else {
            sorted.near.push(format!("{name} (+{:.1})", alias.excess));
        }
    }
    sorted
}

/// What one more position would tell, and what none would.
pub fn separation(effect: &EffectReport) -> Vec<String> {
    let mut lines = Vec::new();
    let told = effect.separate_by.iter().zip(&effect.separate_tells);
    let positions: Vec<String> =
        told.map(|(own, n)| format!("{} (from {n} of {})", position(own), effect.separate_of)).collect();
    if !positions.is_empty() {
        lines.push(format!("one more position would tell it: {}", positions.join("; ")));
    }
    if !effect.separate_never.is_empty() {
        lines.push(format!("no position of this bench tells it from: {}", effect.separate_never.join(", ")));
    }
    lines
}

/// What an alias with small terms only is seen by.
fn seen(alias: &AliasReport) -> String {
    if alias.visible < alias.size {
        format!("the model has all but {} of it", share(alias.visible))
    } else {
        format!("{} of its full size", share(alias.size))
    }
}

/// A probability as `p = 0.01`.
pub fn p_is(value: f64) -> String {
    let text = p(value);
    if text.starts_with('<') { format!("p {}", text.replace('<', "< ")) } else { format!("p = {text}") }
}

/// A probability; one that is too small to be a number says so.
pub fn p(p: f64) -> String {
    if p < 1e-99 { "<1e-99".into() } else { significant(p, 2) }
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
pub fn in_u(shift: Option<f64>) -> String {
    shift.map_or("-".into(), |s| format!("{:+.1}", if s.abs() < 0.05 { 0.0 } else { s }))
}

/// A shift with as many digits as its uncertainty carries.
pub fn shift(shift: Option<f64>, u: Option<f64>) -> String {
    shift.map_or("-".into(), |v| rounded(v, u))
}

/// What the standard uncertainties after are of; empty where they are those of the fit.
pub fn after_u(report: &DiagnoseReport) -> &'static str {
    let aliases = report.parameters.iter().any(|p| p.alias_u > 0.0);
    let rest = report.parameters.iter().any(|p| p.remainder_u > 0.0);
    match (aliases, rest) {
        (true, true) => {
            "u after includes that an alias could be the effect (aliases move the estimates differently, each has its probability), and what is unexplained; the shift is over u without these"
        }
        (true, false) => {
            "u after includes that an alias could be the effect (aliases move the estimates differently, each has its probability); the shift is over u without that"
        }
        (false, true) => "u after includes what is unexplained; the shift is over u without that",
        (false, false) => "",
    }
}

/// What is unexplained in one sentence: what it follows and how large it is.
pub fn remainder(report: &DiagnoseReport) -> String {
    let Some(own) = &report.unexplained else { return String::new() };
    let follows = match &own.follows {
        Some(name) => format!("what is unexplained follows {name}"),
        None => "what is unexplained differs from reading to reading".into(),
    };
    let unit = report.gap.sensors.values().next().map_or("", |s| s.unit.as_str());
    match own.sd.filter(|sd| *sd > 0.0) {
        Some(sd) if report.gap.sensors.len() == 1 => {
            format!("{follows}, with a standard deviation of {} {unit}", significant(sd, 2))
        }
        _ => follows,
    }
}

/// The probability of an effect; empty where there is none to speak of.
pub fn probability(effect: &EffectReport) -> String {
    let percent = |p: f64| if p > 0.999 { "> 99.9 %".to_string() } else { format!("{:.1} %", 100.0 * p) };
    if effect.aliases.is_empty() {
        return format!("probability {}", percent(effect.probability));
    }
    format!(
        "probability {} that it or an alias is present, {} as named",
        percent(effect.probability),
        percent(effect.probability_as_named)
    )
}

/// What a fit of the repaired model leaves out: that the effect could be one of its aliases; `None` where that moves nothing.
pub fn alias_note(report: &DiagnoseReport) -> Option<String> {
    let times = |p: &ChangeReport| p.u_after_as_named.filter(|u| *u > 0.0).map(|u| p.alias_half_width / u);
    let moved = report.parameters.iter().filter(|p| p.alias_half_width > 0.0);
    let most = moved.max_by(|a, b| times(a).unwrap_or(0.0).total_cmp(&times(b).unwrap_or(0.0)))?;
    let named: Vec<&str> =
        report.effects.iter().filter(|e| !e.aliases.is_empty()).map(|e| e.regressor.as_str()).collect();
    Some(format!(
        "fit of this campaign takes the effect as named ({}); were it one of its aliases, the estimates would move, at most {} by {} {} (u = {} as named); u_after of the diagnosis counts that",
        named.join(", "),
        most.id,
        significant(most.alias_half_width, 2),
        most.unit,
        most.u_after_as_named.map_or("-".into(), |u| significant(u, 2))
    ))
}

/// What was done with the constraints, one sentence each.
pub fn constraints(report: &DiagnoseReport) -> Vec<String> {
    let words = |state: Held| match state {
        Held::Equality => "kept as an equality",
        Held::AtLimit => "holds the estimate back: kept as an equality at its limit",
        Held::Inactive => "met without effort: it has no part",
        Held::Wrong => "found wrong: taken away by the repair",
        Held::LeftOut => "left out: it contradicts others, or cannot be applied",
    };
    report.constraints.iter().map(|c| format!("constraint {}, {}: {}", c.index, c.text, words(c.state))).collect()
}

/// The holdout in one sentence; empty where there is none.
pub fn holdout(report: &DiagnoseReport) -> String {
    let Some(own) = &report.holdout else { return String::new() };
    let after = own.after.map_or(String::new(), |after| format!(", with what was found by {after:.2}"));
    let skipped = match own.skipped {
        0 => String::new(),
        1 => "; 1 cannot be left out, it alone determines a parameter".into(),
        n => format!("; {n} cannot be left out, each alone determines a parameter"),
    };
    let positions = if own.positions == 1 { "1 position".into() } else { format!("{} positions", own.positions) };
    format!(
        "left out in turn and predicted from the others, {positions} miss by {:.2} of their standard uncertainties (rms; 1 is expected){after}{skipped}",
        own.before
    )
}
