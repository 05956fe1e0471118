//! What is missing, as the report of a diagnosis has it: effects, their aliases, and what the repair does to each parameter.

use super::super::{ARCSEC, PositionReport, position_keys};
use super::gap::GapReport;
use crate::campaign::{Campaign, JointState, Role};
use crate::diagnosis::{Change, Diagnosis, Finding};
use crate::simulate::Regressor;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A missing effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct EffectReport {
    /// The appended term without its coefficient.
    pub regressor: String,
    /// Name in the field's words.
    pub name: String,
    /// Name of the coefficient in the repaired model line; empty for a prior or a constraint that is wrong.
    pub coefficient: String,
    /// The sensor; null for what is common to all.
    pub sensor: Option<String>,
    /// Coefficient, in `unit`; for a known parameter, a prior or a constraint its error; null where the repaired model does not determine it.
    pub value: Option<f64>,
    /// Its standard uncertainty, in `unit`.
    pub u: Option<f64>,
    /// Its expanded uncertainty, in `unit`.
    #[serde(rename = "U")]
    pub expanded: Option<f64>,
    /// Coverage probability of the expanded uncertainty.
    pub level: f64,
    /// Unit; empty where the term does not determine it.
    pub unit: String,
    /// The value in arcseconds, for an angle.
    pub arcsec: Option<f64>,
    /// Standard uncertainty that was stated for a known parameter or a prior which is found wrong, in `unit`; null for anything else.
    pub stated_u: Option<f64>,
    /// Student's t (z where the noise is stated), the other effects given.
    pub t: f64,
    /// Probability of evidence as strong by chance, among all that was tried.
    pub p: f64,
    /// Share of the residual sum of squares that it removes.
    pub explains: f64,
    /// Why it happens.
    pub why: String,
    /// How to confirm it.
    pub confirm: String,
    /// Posterior probability that it or one of its aliases is present.
    pub probability: f64,
    /// Posterior probability that it is the effect, rather than an alias.
    pub probability_as_named: f64,
    /// The gap with this effect and those before it in the model.
    pub gap_after: Option<GapReport>,
    /// Share of its column that the model as given leaves, 0 to 1: what it is seen by.
    pub visible: f64,
    /// Its size in each sensor, where several have it; empty where one does, or all share it.
    pub in_sensors: Vec<SensorSizeReport>,
    /// What else it could be on this schedule.
    pub aliases: Vec<AliasReport>,
    /// Positions that would discriminate them, best first.
    pub separate_by: Vec<PositionReport>,
    /// How many aliases each of these positions discriminates,
    pub separate_tells: Vec<usize>,
    /// of the number that a position could discriminate in principle.
    pub separate_of: usize,
    /// Aliases among them that no position of this bench discriminates.
    pub separate_never: Vec<String>,
}

/// The size of an effect in one sensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct SensorSizeReport {
    /// The sensor.
    pub sensor: String,
    /// Name of its coefficient in the repaired model line.
    pub coefficient: String,
    /// The coefficient, in `unit`.
    pub value: Option<f64>,
    /// Its standard uncertainty, in `unit`.
    pub u: Option<f64>,
    /// Unit.
    pub unit: String,
    /// Student's t (z where the noise is stated), the other effects given.
    pub t: f64,
    /// Probability of evidence as strong by chance, among all that was tried.
    pub p: f64,
    /// Posterior probability that it or one of its aliases is present there.
    pub probability: f64,
}

/// Another effect that explains the same.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct AliasReport {
    /// Its regressor.
    pub regressor: String,
    /// Its name.
    pub name: String,
    /// The same column exactly (true), or only a fit that is not significantly worse (false).
    pub exact: bool,
    /// How much worse it fits, in variances of the noise.
    pub excess: f64,
    /// Posterior probability that it is the effect.
    pub probability: f64,
    /// Is it seen only through small terms (it vanishes here but for small tilts, or the model has nearly all of it)?
    pub only_small_terms: bool,
    /// Share of its column that the model as given leaves, 0 to 1.
    pub visible: f64,
    /// Largest value of its term here over what its inputs could make of it, a pure number.
    pub size: f64,
    /// A second effect that must then replace another one that was found.
    pub together_with: Option<String>,
}

/// A parameter before and after the repair.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct ChangeReport {
    /// Name.
    pub id: String,
    /// Unit of the numbers: `arcsec` for tilts.
    pub unit: String,
    /// Before, in `unit`.
    pub before: Option<f64>,
    /// Standard uncertainty before, in `unit`.
    pub u_before: Option<f64>,
    /// After, in `unit`.
    pub after: Option<f64>,
    /// Standard uncertainty after, with what is not known about which alias it is, and what is unexplained, in `unit`.
    pub u_after: Option<f64>,
    /// Standard uncertainty after, if the effects are the ones named, in `unit`.
    pub u_after_as_named: Option<f64>,
    /// How far the value would move at most if an alias were the effect, in `unit`.
    pub alias_half_width: f64,
    /// Standard deviation of the value over the explanations that remain, each with its probability (part of `u_after`), in `unit`.
    pub alias_u: f64,
    /// Standard uncertainty from what is unexplained, beyond that of the noise (part of `u_after`), in `unit`.
    pub remainder_u: f64,
    /// After minus before, in `unit`.
    pub shift: Option<f64>,
    /// After minus before, over the standard uncertainty after as named, a ratio.
    pub change_in_u: Option<f64>,
}

pub(super) fn effects(campaign: &Campaign, diagnosis: &Diagnosis) -> Vec<EffectReport> {
    diagnosis.effects.iter().map(|finding| effect(campaign, diagnosis, finding)).collect()
}

fn effect(campaign: &Campaign, diagnosis: &Diagnosis, finding: &Finding) -> EffectReport {
    let own = &finding.effect;
    let sensor = |k: usize| campaign.sensor_id(k).to_string();
    let keys = |list: &[Vec<JointState>]| list.iter().map(|joints| position_keys(campaign, joints)).collect();
    let after = diagnosis.after.as_ref().unwrap_or(&diagnosis.before);
    let results = || after.parameters.iter();
    let combined = |p: &crate::fit::ParameterResult| p.uncertainty;
    // what has no parameter of its own (a prior, a constraint) is covered like the others
    let coverage = results()
        .find(|p| !own.coefficient.is_empty() && p.id == own.coefficient)
        .and_then(combined)
        .or_else(|| results().find_map(combined))
        .map(|c| c.coverage_factor);
    let name = match own.kind {
        Regressor::Constraint(_) => {
            constraint_number(&own.regressor).and_then(|k| campaign.constraints.get(k)).map(|c| {
                format!("the constraint {} does not hold", super::super::fit_constraints::constraint_text(campaign, c))
            })
        }
        _ => None,
    };
    EffectReport {
        regressor: own.regressor.clone(),
        name: name.unwrap_or_else(|| own.name.clone()),
        coefficient: own.coefficient.clone(),
        sensor: own.sensor.filter(|_| finding.also.is_empty()).map(sensor),
        in_sensors: in_sensors(campaign, finding),
        value: finding.value,
        u: finding.u,
        expanded: finding.u.zip(coverage).map(|(u, k)| k * u),
        level: after.settings.level,
        unit: finding.unit.clone(),
        arcsec: finding.value.filter(|_| finding.unit == "rad").map(|v| v * ARCSEC),
        stated_u: stated_u(campaign, &own.kind),
        t: finding.t,
        p: finding.p,
        explains: finding.explains,
        why: own.why.clone(),
        confirm: own.confirm.clone(),
        probability: finding.probability,
        probability_as_named: (finding.probability - finding.aliases.iter().map(|a| a.probability).sum::<f64>())
            .max(0.0),
        gap_after: diagnosis
            .steps
            .iter()
            .find(|step| step.evidence.with.last() == Some(&own.regressor))
            .map(super::gap::of_step),
        visible: own.visible,
        aliases: finding
            .aliases
            .iter()
            .map(|alias| AliasReport {
                regressor: alias.regressor.clone(),
                name: alias.name.clone(),
                exact: alias.exact,
                excess: alias.excess,
                probability: alias.probability,
                only_small_terms: alias.vanishing,
                visible: alias.visible,
                size: alias.size,
                together_with: alias.together_with.clone(),
            })
            .collect(),
        separate_by: keys(&finding.separation.positions),
        separate_tells: finding.separation.told.clone(),
        separate_of: finding.separation.of,
        separate_never: finding.separation.never.clone(),
    }
}

fn in_sensors(campaign: &Campaign, finding: &Finding) -> Vec<SensorSizeReport> {
    if finding.also.is_empty() {
        return Vec::new();
    }
    let id = |sensor: Option<usize>| {
        sensor.and_then(|k| campaign.bench.sensors.get(k)).map_or(String::new(), |s| s.id.clone())
    };
    let mut sizes = vec![SensorSizeReport {
        sensor: id(finding.effect.sensor),
        coefficient: finding.effect.coefficient.clone(),
        value: finding.value,
        u: finding.u,
        unit: finding.unit.clone(),
        t: finding.t,
        p: finding.p,
        probability: finding.probability,
    }];
    sizes.extend(finding.also.iter().map(|own| SensorSizeReport {
        sensor: id(own.effect.sensor),
        coefficient: own.effect.coefficient.clone(),
        value: own.value,
        u: own.u,
        unit: own.unit.clone(),
        t: own.t,
        p: own.p,
        probability: own.probability,
    }));
    sizes
}

/// Index of the constraint that a regressor `constraint:N` names.
fn constraint_number(regressor: &str) -> Option<usize> {
    regressor.strip_prefix("constraint:")?.parse::<usize>().ok()?.checked_sub(1)
}

/// The standard uncertainty that the campaign states for a known parameter or a prior.
fn stated_u(campaign: &Campaign, kind: &Regressor) -> Option<f64> {
    let (Regressor::Known(k) | Regressor::Prior(k)) = kind else { return None };
    match campaign.parameters.get(*k).map(|p| &p.role) {
        Some(Role::Known(known)) => Some(known.u),
        Some(Role::Estimated { prior, .. }) => prior.map(|p| p.u),
        _ => None,
    }
}

pub(super) fn change(own: &Change) -> ChangeReport {
    let scale = if own.is_angle { ARCSEC } else { 1.0 };
    let scaled = |v: Option<f64>| v.map(|v| v * scale);
    let shift = own.before.0.zip(own.after.0).map(|(before, after)| after - before);
    let change_in_u = match (shift, own.after.1) {
        (Some(shift), Some(u)) if u > 0.0 => Some(shift / u),
        _ => None,
    };
    ChangeReport {
        id: own.id.clone(),
        unit: if own.is_angle { "arcsec".into() } else { own.unit.clone() },
        before: scaled(own.before.0),
        u_before: scaled(own.before.1),
        after: scaled(own.after.0),
        u_after: scaled(own.u_in_all()),
        u_after_as_named: scaled(own.after.1),
        alias_half_width: scale * own.alias_half_width,
        alias_u: scale * own.alias_u,
        remainder_u: scale * own.remainder_u,
        shift: scaled(shift),
        change_in_u,
    }
}
