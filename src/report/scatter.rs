//! What scatters, as a fit report says it: every source with its size, where that comes from, and its part in each parameter.

use super::finite;
use crate::campaign::{Known, Size};
use crate::document::number::{percent, significant};
use crate::document::{Cell, Rows, Section};
use crate::estimate::LineState;
use crate::fit::{Fit, VarianceFrom, VarianceSource};
use crate::language::{Language, Sentence, say, sentence};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A source of scatter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ScatterReport {
    /// As budgets name it: `readings of V`, `beta per position`, `priors`.
    pub source: String,
    /// What deviates: a sensor, joint, tilt or coefficient.
    pub of: String,
    /// How often it takes a new value: `reading`, `position`, `campaign` or a column.
    pub per: String,
    /// How many values it took; readings for a sensor's own noise.
    pub levels: usize,
    /// Its standard deviation in `unit`; a factor where uncertainties are stated with each reading; null where it cannot be determined.
    pub sd: Option<f64>,
    /// Standard uncertainty of an estimated standard deviation, in `unit`; at zero, what it could be.
    pub u_sd: Option<f64>,
    /// Unit of the standard deviation.
    pub unit: String,
    /// Degrees of freedom of the standard deviation; null for infinite.
    pub dof: Option<f64>,
    /// `stated` or `estimated`.
    pub from: VarianceFrom,
    /// Was it estimated from these readings?
    pub estimated: bool,
    /// Did its estimate come out at zero?
    pub at_zero: bool,
    /// Correlation time, where deviations are correlated in time, in the unit of the column that it is correlated over.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tau: Option<f64>,
    /// Standard uncertainty of an estimated correlation time, in the same unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_tau: Option<f64>,
    /// Estimated parameters without u, since they follow its deviations, and no residual shows how large these are.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub without_u: Vec<String>,
    /// What a person must know of it, in a sentence.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<Sentence>,
    /// Share of each parameter's variance.
    pub share: BTreeMap<String, f64>,
}

pub(super) fn scatter(fit: &Fit) -> Vec<ScatterReport> {
    let known = fit.known_sensitivities.iter().filter_map(|(k, known, _)| {
        let parameter = fit.campaign.parameters.get(*k)?;
        (known.u > 0.0).then(|| once(fit, &parameter.id, &parameter.unit, known))
    });
    fit.noise.sources.iter().map(|source| one(fit, source)).chain(known).collect()
}

/// A known input with an uncertainty: a deviation that the whole campaign shares.
fn once(fit: &Fit, id: &str, unit: &str, known: &Known) -> ScatterReport {
    ScatterReport {
        source: id.to_string(),
        of: id.to_string(),
        per: "campaign".into(),
        levels: 1,
        sd: Some(known.u),
        u_sd: None,
        unit: unit.to_string(),
        dof: finite(known.dof),
        from: VarianceFrom::Stated,
        estimated: false,
        at_zero: false,
        tau: None,
        u_tau: None,
        without_u: Vec::new(),
        note: None,
        share: shares(fit, id),
    }
}

/// Share of each parameter's variance that a source has.
fn shares(fit: &Fit, source: &str) -> BTreeMap<String, f64> {
    let share = fit.parameters.iter().filter_map(|p| {
        let total: f64 = p.budget.iter().map(|c| c.variance()).sum();
        let part: f64 = p.budget.iter().filter(|c| c.source == source).map(|c| c.variance()).sum();
        (total > 0.0).then(|| (p.id.clone(), part / total))
    });
    share.collect()
}

fn one(fit: &Fit, source: &VarianceSource) -> ScatterReport {
    let line = source.line.and_then(|k| fit.campaign.scatter.get(k));
    // a line of the campaign has another name, and its own unit
    let sensor = source.name.strip_prefix("readings of ").unwrap_or_default();
    let unit_of_sensor = || {
        let described = fit.campaign.bench.sensors.iter().find(|s| s.id == sensor);
        described.filter(|_| source.estimated).map(|s| s.unit.clone()).unwrap_or_default()
    };
    let shown = line.map_or(1.0, |line| line.shown);
    let is_estimate = match source.state {
        LineState::Inseparable | LineState::Absorbed | LineState::NotFelt => false,
        _ => line.is_some() || fit.noise.determined || !source.estimated,
    };
    let each = line.is_some_and(|line| matches!(line.size, Size::Column(_)));
    let correlation = line.is_some_and(crate::fit::is_correlation);
    let sd = (is_estimate && !each && !correlation).then(|| source.variance.sqrt() * shown);
    let has_dof = source.estimated && source.dof.is_finite() && source.dof > 0.0;
    let u_sd = match source.state {
        LineState::AtZero => source.could_be.map(|sd| sd * shown),
        _ => sd.filter(|_| has_dof).map(|sd| sd / (2.0 * source.dof).sqrt()),
    };
    ScatterReport {
        source: source.name.clone(),
        of: line.map_or_else(|| sensor.to_string(), |line| line.of_name(&fit.campaign)),
        per: line.map_or("reading".to_string(), |line| line.per.name().to_string()),
        levels: source.levels,
        sd,
        u_sd,
        unit: line.map_or_else(unit_of_sensor, |line| line.unit.clone()),
        dof: finite(source.dof),
        from: if source.estimated { VarianceFrom::Estimated } else { VarianceFrom::Stated },
        estimated: source.estimated,
        at_zero: source.state == LineState::AtZero,
        tau: source.tau.map(|(tau, _)| tau),
        u_tau: source.tau.and_then(|(_, u)| u),
        without_u: source.line.map_or(Vec::new(), |k| fit.without_u_for(k).into_iter().map(str::to_string).collect()),
        note: note(fit, source, each),
        share: shares(fit, &source.name),
    }
}

/// What the numbers alone do not say.
fn note(fit: &Fit, source: &VarianceSource, each: bool) -> Option<Sentence> {
    let text = match source.state {
        LineState::AtZero => sentence!("estimated-as-zero", below = source.is_below_zero()),
        LineState::NotFelt => sentence!("no-reading-feels-it-here"),
        LineState::Inseparable => {
            let is_estimated = |other: &&VarianceSource| other.estimated && other.state == LineState::Estimated;
            let others = fit.noise.sources.iter().filter(is_estimated).map(|other| source_sentence(&other.name));
            let others = others.reduce(|before, last| sentence!("list-and", before, last));
            let (named, others) = (others.is_some(), others.unwrap_or_else(|| Sentence::text("")));
            sentence!("these-readings-cannot-tell-it-from-their", named, others)
        }
        LineState::Absorbed => absorbed(fit, source)?,
        _ if source.line.is_none() && source.estimated && !fit.noise.determined => {
            sentence!("no-degrees-of-freedom-are-left-to")
        }
        _ if each => sentence!("in-each-reading-as-stated"),
        _ => return None,
    };
    Some(text)
}

/// The unknowns take up its deviations: what is not known for that, and how much more is to be measured.
fn absorbed(fit: &Fit, source: &VarianceSource) -> Option<Sentence> {
    let line = source.line?;
    let per = |k: usize| fit.campaign.scatter.get(k).map(|line| &line.per);
    // a level that repeats an earlier one leaves one residual; each variance needs its own
    let more = fit.noise.absorbed.iter().filter(|(k, _)| per(*k) == per(line)).count();
    let levels = sentence!("more-levels", more, per = per(line)?.name());
    let names = fit.without_u_for(line);
    // of many the first few
    let listed = names.iter().take(6).copied().collect::<Vec<_>>().join(", ");
    let names = if names.len() > 6 { listed + ", ..." } else { listed };
    Some(sentence!("the-unknowns-take-up-its-deviations", count = source.levels, names, levels))
}

/// Is there more to say than the readings' own noise?
pub(super) fn is_worth_a_table(sources: &[ScatterReport]) -> bool {
    // known inputs alone have a table of their own
    sources.iter().any(|s| !s.source.starts_with("readings of ") && s.source != "priors" && s.source != s.of)
}

/// The name of a source as a person reads it; JSON and `--by` have the name itself.
pub(super) fn source_name(source: &str, lang: Language) -> String {
    source_sentence(source).say(lang)
}

fn source_sentence(source: &str) -> Sentence {
    if let Some(sensor) = source.strip_prefix("readings of ") {
        return sentence!("source-readings-of", sensor);
    }
    match source {
        "priors" => return sentence!("source-priors"),
        "estimated weights (Kenward-Roger)" => return sentence!("source-weights"),
        _ => {}
    }
    let Some((of, per)) = source.rsplit_once(" per ") else { return Sentence::text(source) };
    let per = match per {
        "reading" => sentence!("reading"),
        "position" => sentence!("position"),
        "campaign" => sentence!("campaign"),
        column => Sentence::text(column),
    };
    match of.split_once(" over ") {
        Some((of, over)) => sentence!("source-over-per", of, over, per),
        None => sentence!("source-per", of, per),
    }
}

/// What scatters: every source with its size and where that comes from; empty where there is only the readings' own noise.
pub(super) fn section(sources: &[ScatterReport], lang: Language) -> Section {
    let section = Section::new(say!(lang, "what-scatters"));
    if !is_worth_a_table(sources) {
        return section;
    }
    let sd = |source: &ScatterReport| {
        let text = format!("{} {}", significant(source.sd?, 3), source.unit);
        Some(match source.tau {
            None => text.trim_end().to_string(),
            Some(tau) => format!("{}{}\u{3c4} = {}", text.trim_end(), lang.clause(), significant(tau, 3)),
        })
    };
    let largest = |source: &ScatterReport| {
        let (id, share) = source.share.iter().max_by(|a, b| a.1.total_cmp(b.1)).filter(|(_, share)| **share > 0.0)?;
        Some(format!("{id} {} %", percent(*share)))
    };
    let table = Rows::of(sources)
        .left(say!(lang, "source"), |source| source_name(&source.source, lang))
        .right("sd", sd)
        .right("u(sd)", |source| Cell::digits(source.u_sd, 2))
        .left(say!(lang, "state"), |source| lang.term(&source.from.to_string()))
        .right(say!(lang, "values"), |source| source.levels)
        .left(say!(lang, "scatter-largest-share"), largest)
        .small()
        .note(say!(lang, "sd-standard-deviation-of-one-deviation-a"));
    let notes = sources.iter().filter_map(|source| {
        let (source, note) = (source_name(&source.source, lang), source.note.as_ref()?);
        Some(say!(lang, "source-note-sentence", source, note))
    });
    section.table(table).list(notes)
}
