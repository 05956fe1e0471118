//! The report of a diagnosis (`tumble diagnose --json`): effects, their aliases, what the repair does to each parameter; how large the gap is, where, and
//! what of it is unexplained.

use super::scatter::{self, ScatterReport};
use super::{ARCSEC, Input, PositionReport, ReportKind, VERSION, checks, model_lines, position_keys};
use crate::campaign::{Campaign, Identity, JointState, Role};
use crate::diagnosis::{
    self, Alias, Change, Diagnosis, Finding, Gap, GapStep, Held, Holdout, NoiseFloor, Place, State, Suspect,
    Unexplained, Verdict,
};
use crate::fit::Fit;
use crate::simulate::Regressor;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What `tumble diagnose --json` writes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct DiagnoseReport {
    /// Version of the program that wrote it.
    pub tumble: String,
    /// Always `diagnose`.
    #[schemars(extend("const" = "diagnose"))]
    pub report: ReportKind,
    /// Id of the bench.
    pub bench: String,
    /// The unit under test, when, where, by whom, with what.
    #[serde(default, skip_serializing_if = "Identity::is_empty")]
    pub identity: Identity,
    /// The files that the report was made from, with the SHA-256 of their bytes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inputs: Vec<Input>,
    /// `effects-found`, `partly-explained`, `nothing-missing`, `unexplained`, or `not-diagnosable` (no redundancy).
    pub verdict: Verdict,
    /// Probability of reporting anything when nothing is missing.
    pub significance: f64,
    /// What is missing, in the order in which it reduces the residuals.
    pub effects: Vec<EffectReport>,
    /// What the posterior says: `nothing` is missing, an effect at least is `named`, none is and one at least is `suspected`, or what is missing is
    /// `outside` the catalogue; absent where nothing can be diagnosed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub state: Option<State>,
    /// Effects that are probable, but not enough for a name: they are no part of the repaired model.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub suspected: Vec<SuspectReport>,
    /// Model line of each sensor as given.
    pub model_before: BTreeMap<String, String>,
    /// Model line of each sensor with the effects.
    pub model_after: BTreeMap<String, String>,
    /// The gap before and after, and the noise floor.
    pub gap: GapsReport,
    /// Where the gap is, the most significant first.
    #[serde(rename = "where")]
    pub places: Vec<Place>,
    /// What scatters, the effects being in the model; empty where only the readings' own noise does.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub scatter: Vec<ScatterReport>,
    /// What is unexplained; null unless the verdict says so.
    pub unexplained: Option<Unexplained>,
    /// Leave-one-position-out prediction; null where no position can be predicted from the others.
    pub holdout: Option<Holdout>,
    /// The gap as given, after the first effect, after the second, and so on.
    pub steps: Vec<GapStep>,
    /// How many candidates were tried.
    pub candidates: usize,
    /// How many of them are distinct on this schedule: the number of tests that every p accounts for.
    pub distinct_candidates: usize,
    /// Columns of the readings that were not tried, because their titles are no names of the algebra; `columns` can give them one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub untried_columns: Vec<String>,
    /// Each estimated parameter before and after, its uncertainty including possible aliases and unexplained residuals.
    pub parameters: Vec<ChangeReport>,
    /// Readings of a long record, which were averaged; null where each was compared by itself.
    pub averaged_from: Option<usize>,
    /// Residual of each reading (of each average in a long record) before and after, for a picture.
    pub residuals: Vec<ResidualReport>,
    /// Positions that would make a diagnosis possible; empty where it is.
    pub would_help: Vec<PositionReport>,
    /// Parameters of the bench that are taken as zero.
    pub assumed_zero: Vec<String>,
    /// What was done with each constraint of the campaign.
    pub constraints: Vec<AssertedReport>,
}

/// An effect that is suspected.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SuspectReport {
    /// The appended term without its coefficient.
    pub regressor: String,
    /// Name in the field's words.
    pub name: String,
    /// The sensor; null for what is common to all.
    pub sensor: Option<String>,
    /// Posterior probability that it or one of its aliases is present, 0.5 to 0.95.
    pub probability: f64,
}

/// A constraint of the campaign in a diagnosis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AssertedReport {
    /// Number in the file, from 1.
    pub index: usize,
    /// The constraint as a line of text.
    pub text: String,
    /// `equality` (met exactly), `at-limit` (an inequality that holds the estimate back: taken as an equality), `inactive`,
    /// `left-out` (it contradicts others, or cannot be applied), `wrong` (a finding: taken away by the repair).
    pub state: Held,
}

/// The report of a diagnosis; `campaign` is the question with its constraints.
pub fn diagnose_report(campaign: &Campaign, diagnosis: &Diagnosis, settings: &diagnosis::Settings) -> DiagnoseReport {
    let after = diagnosis.after.as_ref().unwrap_or(&diagnosis.before);
    DiagnoseReport {
        tumble: VERSION.into(),
        report: ReportKind::Diagnose,
        bench: campaign.bench.id.clone(),
        identity: campaign.identity.clone(),
        inputs: Vec::new(),
        verdict: diagnosis.verdict,
        significance: settings.significance,
        effects: diagnosis.effects.iter().map(|finding| effect(campaign, diagnosis, finding)).collect(),
        state: diagnosis.state,
        suspected: diagnosis.suspected.iter().map(|suspected| suspect(campaign, suspected)).collect(),
        model_before: model_lines(&diagnosis.before.campaign),
        model_after: model_lines(&after.campaign),
        gap: GapsReport {
            before: diagnosis.gap_before.clone(),
            after: diagnosis.gap_after.clone(),
            noise: diagnosis.noise,
            sensors: sensors(campaign, diagnosis),
        },
        places: diagnosis.places.clone(),
        scatter: if after.campaign.scatter.is_empty() { Vec::new() } else { scatter::scatter(after) },
        unexplained: diagnosis.unexplained.clone(),
        holdout: diagnosis.holdout.clone(),
        steps: diagnosis.steps.clone(),
        candidates: diagnosis.candidates.0,
        distinct_candidates: diagnosis.candidates.1,
        untried_columns: diagnosis::covariates(campaign).1,
        parameters: diagnosis.changes.iter().map(change).collect(),
        averaged_from: diagnosis.averaged.map(|(from, _)| from),
        residuals: residuals(campaign, diagnosis),
        would_help: diagnosis.would_help.iter().map(|joints| position_keys(campaign, joints)).collect(),
        assumed_zero: diagnosis.before.assumed_zero().map(str::to_string).collect(),
        constraints: {
            let constraints = campaign.constraints.iter().zip(&diagnosis.constraints).enumerate();
            let asserted = |(k, (constraint, held)): (usize, (_, &Held))| AssertedReport {
                index: k + 1,
                text: checks::constraint_text(campaign, constraint),
                state: *held,
            };
            constraints.map(asserted).collect()
        },
    }
}

fn suspect(campaign: &Campaign, suspected: &Suspect) -> SuspectReport {
    SuspectReport {
        regressor: suspected.effect.regressor.clone(),
        name: suspected.effect.name.clone(),
        sensor: sensor(campaign, suspected.effect.sensor),
        probability: suspected.probability,
    }
}

/// A missing effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
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
    pub gap_after: Option<Gap>,
    /// Share of its column that the model as given leaves, 0 to 1: what it is seen by.
    pub visible: f64,
    /// Its size in each sensor, where several have it; empty where one does, or all share it.
    pub in_sensors: Vec<SensorSizeReport>,
    /// What else it could be on this schedule.
    pub aliases: Vec<Alias>,
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

/// A parameter before and after the repair.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
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

fn effect(campaign: &Campaign, diagnosis: &Diagnosis, finding: &Finding) -> EffectReport {
    let effect = &finding.effect;
    let keys = |list: &[Vec<JointState>]| list.iter().map(|joints| position_keys(campaign, joints)).collect();
    let after = diagnosis.after.as_ref().unwrap_or(&diagnosis.before);
    let results = || after.parameters.iter();
    let combined = |p: &crate::fit::ParameterResult| p.uncertainty;
    // what has no parameter of its own (a prior, a constraint) is covered like the others
    let coverage = results()
        .find(|p| !effect.coefficient.is_empty() && p.id == effect.coefficient)
        .and_then(combined)
        .or_else(|| results().find_map(combined))
        .map(|c| c.coverage_factor);
    let constraint = constraint_number(&effect.regressor).filter(|_| matches!(effect.kind, Regressor::Constraint(_)));
    let name = constraint.and_then(|k| campaign.constraints.get(k));
    let name = name.map(|c| format!("the constraint {} does not hold", checks::constraint_text(campaign, c)));
    let step = diagnosis.steps.iter().find(|step| step.with.last() == Some(&effect.regressor));
    EffectReport {
        regressor: effect.regressor.clone(),
        name: name.unwrap_or_else(|| effect.name.clone()),
        coefficient: effect.coefficient.clone(),
        sensor: sensor(campaign, effect.sensor).filter(|_| finding.also.is_empty()),
        in_sensors: in_sensors(campaign, finding),
        value: finding.value,
        u: finding.u,
        expanded: finding.u.zip(coverage).map(|(u, k)| k * u),
        level: after.settings.level,
        unit: finding.unit.clone(),
        arcsec: finding.value.filter(|_| finding.unit == "rad").map(|v| v * ARCSEC),
        stated_u: stated_u(campaign, &effect.kind),
        t: finding.t,
        p: finding.p,
        explains: finding.explains,
        why: effect.why.clone(),
        confirm: effect.confirm.clone(),
        probability: finding.probability,
        probability_as_named: (finding.probability - finding.aliases.iter().map(|a| a.probability).sum::<f64>())
            .max(0.0),
        gap_after: step.map(|step| step.gap.clone()),
        visible: effect.visible,
        aliases: finding.aliases.clone(),
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
    let size = |own: &Finding| SensorSizeReport {
        sensor: sensor(campaign, own.effect.sensor).unwrap_or_default(),
        coefficient: own.effect.coefficient.clone(),
        value: own.value,
        u: own.u,
        unit: own.unit.clone(),
        t: own.t,
        p: own.p,
        probability: own.probability,
    };
    std::iter::once(finding).chain(&finding.also).map(size).collect()
}

/// The name of a sensor; none for what is common to all.
fn sensor(campaign: &Campaign, sensor: Option<usize>) -> Option<String> {
    sensor.and_then(|k| campaign.bench.sensors.get(k)).map(|sensor| sensor.id.clone())
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

fn change(change: &Change) -> ChangeReport {
    let scale = if change.is_angle { ARCSEC } else { 1.0 };
    let scaled = |v: Option<f64>| v.map(|v| v * scale);
    let shift = change.before.0.zip(change.after.0).map(|(before, after)| after - before);
    let change_in_u = match (shift, change.after.1) {
        (Some(shift), Some(u)) if u > 0.0 => Some(shift / u),
        _ => None,
    };
    ChangeReport {
        id: change.id.clone(),
        unit: if change.is_angle { "arcsec".into() } else { change.unit.clone() },
        before: scaled(change.before.0),
        u_before: scaled(change.before.1),
        after: scaled(change.after.0),
        u_after: scaled(change.u_in_all()),
        u_after_as_named: scaled(change.after.1),
        alias_half_width: scale * change.alias_half_width,
        alias_u: scale * change.alias_u,
        remainder_u: scale * change.remainder_u,
        shift: scaled(shift),
        change_in_u,
    }
}

/// The gap before and after.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GapsReport {
    /// With the model as given.
    pub before: Gap,
    /// With the effects; as before where nothing was found.
    pub after: Gap,
    /// The noise floor.
    pub noise: NoiseFloor,
    /// The same for each sensor by itself, in its unit.
    pub sensors: BTreeMap<String, SensorGapReport>,
}

/// The gap of one sensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SensorGapReport {
    /// Its unit.
    pub unit: String,
    /// How many values it gave.
    pub readings: usize,
    /// `sqrt(sum v^2 / r)` before, `r` the sum of its redundancy numbers, in `unit`; null where that is zero.
    pub rms_before: Option<f64>,
    /// The same with the effects, in `unit`.
    pub rms_after: Option<f64>,
    /// Largest residual before, in `unit`.
    pub max_before: f64,
    /// Largest residual after, in `unit`.
    pub max_after: f64,
    /// Standard deviation of a reading by the noise floor (root mean square where readings differ), in `unit`.
    pub sd: Option<f64>,
}

/// A reading's residual before and after.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ResidualReport {
    /// Number of the reading, from 1.
    pub index: usize,
    /// Its position.
    pub position: String,
    /// The sensor.
    pub sensor: String,
    /// Before, in the sensor's unit.
    pub before: f64,
    /// After, in the sensor's unit.
    pub after: f64,
    /// Standard deviation of the reading by the noise floor, in the sensor's unit; null where it is unknown.
    pub sd: Option<f64>,
}

fn sensors(campaign: &Campaign, diagnosis: &Diagnosis) -> BTreeMap<String, SensorGapReport> {
    let after = diagnosis.after.as_ref().unwrap_or(&diagnosis.before);
    let mut sensors = BTreeMap::new();
    for (k, sensor) in campaign.bench.sensors.iter().enumerate() {
        let origins = diagnosis.before.design.rows.iter().enumerate();
        let rows: Vec<usize> = origins.filter(|(_, origin)| origin.sensor == k).map(|(i, _)| i).collect();
        if rows.is_empty() {
            continue;
        }
        let rms = |fit: &Fit, gap: &Gap| {
            let square: f64 = rows.iter().filter_map(|i| gap.residuals.get(*i)).map(|v| v * v).sum();
            let redundancy: f64 = rows.iter().filter_map(|i| fit.estimate.redundancy.get(*i)).sum();
            (redundancy > 1e-9).then(|| (square / redundancy).sqrt())
        };
        let max = |gap: &Gap| rows.iter().filter_map(|i| gap.residuals.get(*i)).fold(0.0_f64, |m, v| m.max(v.abs()));
        let variance: f64 = rows.iter().filter_map(|i| diagnosis.row_sd.get(*i)).map(|u| u * u).sum();
        let report = SensorGapReport {
            unit: sensor.unit.clone(),
            readings: rows.len(),
            rms_before: rms(&diagnosis.before, &diagnosis.gap_before),
            rms_after: rms(after, &diagnosis.gap_after),
            max_before: max(&diagnosis.gap_before),
            max_after: max(&diagnosis.gap_after),
            // without a degree of freedom, and no stated uncertainty, there is no noise floor
            sd: diagnosis.noise.sd.is_some().then(|| (variance / rows.len() as f64).sqrt()),
        };
        sensors.insert(sensor.id.clone(), report);
    }
    sensors
}

fn residuals(campaign: &Campaign, diagnosis: &Diagnosis) -> Vec<ResidualReport> {
    let rows = diagnosis.before.design.rows.iter().enumerate();
    rows.zip(diagnosis.gap_before.residuals.iter().zip(&diagnosis.gap_after.residuals))
        .map(|((i, origin), (before, after))| ResidualReport {
            index: origin.reading + 1,
            position: campaign.position_of(origin.reading).to_string(),
            sensor: campaign.sensor_id(origin.sensor).to_string(),
            before: *before,
            after: *after,
            sd: diagnosis.row_sd.get(i).copied().filter(|sd| sd.is_finite() && diagnosis.noise.sd.is_some()),
        })
        .collect()
}
