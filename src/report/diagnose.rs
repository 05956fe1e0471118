//! The report of a diagnosis (`tumble diagnose --json`).

use super::{ARCSEC, PositionReport, VERSION, position_keys};
use crate::campaign::Campaign;
use crate::diagnosis::{self, Candidate, Diagnosis, Finding, Gap, Level};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What `tumble diagnose --json` writes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DiagnoseReport {
    /// Version of the program.
    pub tumble: String,
    /// Always `diagnose`.
    pub report: String,
    /// Id of the bench.
    pub bench: String,
    /// `effects-found`, `nothing-missing`, `unexplained`, or `not-diagnosable` (no redundancy).
    pub verdict: String,
    /// Probability of reporting anything when nothing is missing.
    pub significance: f64,
    /// What is missing, the strongest first.
    pub effects: Vec<EffectReport>,
    /// Model line of each sensor as given.
    pub model_before: BTreeMap<String, String>,
    /// Model line of each sensor with the effects.
    pub model_after: BTreeMap<String, String>,
    /// The gap before and after, and the noise floor.
    pub gap: GapsReport,
    /// Where the gap is, the most significant first.
    #[serde(rename = "where")]
    pub places: Vec<PlaceReport>,
    /// What is unexplained; null unless the verdict says so.
    pub unexplained: Option<UnexplainedReport>,
    /// Leave-one-position-out prediction; null without two positions.
    pub holdout: Option<HoldoutReport>,
    /// The search's record.
    pub steps: Vec<StepReport>,
    /// How many candidates were tried.
    pub candidates: usize,
    /// How many of them are distinct on this schedule: the number of tests that every p accounts for.
    pub distinct_candidates: usize,
    /// What the repair does to each estimated parameter; empty where nothing was repaired.
    pub parameters: Vec<ChangeReport>,
    /// Residual of each reading before and after, for a picture.
    pub residuals: Vec<ResidualReport>,
    /// Positions that would make a diagnosis possible; empty where it is.
    pub would_help: Vec<PositionReport>,
    /// Constraints of the campaign that were left out, because the free model is diagnosed.
    pub constraints_left_out: usize,
}

/// A missing effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EffectReport {
    /// The appended term without its coefficient.
    pub regressor: String,
    /// Name in the field's words.
    pub name: String,
    /// Name of the coefficient in the repaired model line.
    pub coefficient: String,
    /// The sensor; null for what is common to all.
    pub sensor: Option<String>,
    /// Coefficient; null where the repaired model does not determine it.
    pub value: Option<f64>,
    /// Its standard uncertainty.
    pub u: Option<f64>,
    /// Unit; empty where the term does not tell.
    pub unit: String,
    /// The same in arcseconds, for a tilt.
    pub arcsec: Option<f64>,
    /// Student's t (z where the noise is stated), the other effects given.
    pub t: f64,
    /// Probability of evidence as strong by chance, among all that was tried.
    pub p: f64,
    /// Share of the gap's sum of squares that it takes off.
    pub explains: f64,
    /// Why it happens.
    pub why: String,
    /// How to confirm it.
    pub confirm: String,
    /// Is the term zero at these positions but for rounding?
    pub zero_but_for_rounding: bool,
    /// What else it could be on this schedule.
    pub aliases: Vec<AliasReport>,
    /// Positions that would tell them apart, best first.
    pub separate_by: Vec<PositionReport>,
}

/// Another effect that explains the same.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AliasReport {
    /// Its regressor.
    pub regressor: String,
    /// Its name.
    pub name: String,
    /// The same column exactly (true), or only a fit that is not significantly worse (false).
    pub exact: bool,
    /// How much worse it fits, in variances of the noise.
    pub excess: f64,
    /// Is its term zero at these positions but for rounding, so that it would need an absurd coefficient?
    pub zero_but_for_rounding: bool,
    /// A second effect that must then stand in the place of another finding.
    pub together_with: Option<String>,
}

/// The gap before and after.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GapsReport {
    /// With the model as given.
    pub before: GapReport,
    /// With the effects; as before where nothing was found.
    pub after: GapReport,
    /// The noise floor.
    pub noise: NoiseReport,
}

/// A gap.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GapReport {
    /// `sqrt(sum v^2 / dof)`; null without degrees of freedom.
    pub rms: Option<f64>,
    /// Largest residual by size.
    pub max: f64,
    /// `sum (v/u)^2` with the noise floor.
    pub chi_square: f64,
    /// Degrees of freedom.
    pub dof: usize,
    /// Probability of a gap as large by chance; null where only residuals tell the noise.
    pub p: Option<f64>,
}

/// The noise floor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NoiseReport {
    /// Standard deviation of a reading of the first sensor; null where nothing tells.
    pub sd: Option<f64>,
    /// `replicates`, `stated` or `residuals` (of the finished model: then completeness cannot be tested).
    pub from: String,
}

/// Mean residual at one level of a factor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PlaceReport {
    /// The factor.
    pub factor: String,
    /// The level.
    pub level: LevelReport,
    /// The sensor.
    pub sensor: String,
    /// Readings there.
    pub readings: usize,
    /// Mean residual before.
    pub mean: f64,
    /// Probability of a mean as large by chance, this level alone.
    pub p: f64,
}

/// A level: a number or a label.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum LevelReport {
    /// A number.
    Number(f64),
    /// A label.
    Text(String),
}

/// What is unexplained.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct UnexplainedReport {
    /// In one sentence.
    pub pattern: String,
    /// Mean residual at each state of the joints.
    pub cells: Vec<CellReport>,
    /// The candidates that come nearest together; they are not accepted.
    pub nearest: Vec<String>,
    /// Share of the gap's sum of squares that those would take off.
    pub nearest_explains: f64,
}

/// Mean residual at one state of the joints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CellReport {
    /// The state.
    pub at: PositionReport,
    /// The sensor.
    pub sensor: String,
    /// Readings there.
    pub readings: usize,
    /// Mean residual.
    pub mean: f64,
    /// Its size in standard deviations.
    pub z: f64,
}

/// Leave-one-position-out prediction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HoldoutReport {
    /// Positions predicted from the others.
    pub positions: usize,
    /// Positions that cannot be left out, because they alone hold a parameter.
    pub skipped: usize,
    /// Root mean square prediction error before, in standard deviations of the noise.
    pub before: f64,
    /// The same with the effects.
    pub after: Option<f64>,
}

/// One look at the evidence.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StepReport {
    /// Effects in the model.
    pub with: Vec<String>,
    /// The strongest further candidate.
    pub strongest: Option<String>,
    /// Its t.
    pub t: Option<f64>,
    /// Its probability by chance among all that was tried.
    pub p: Option<f64>,
    /// Probability of what is left by chance.
    pub global_p: Option<f64>,
}

/// A parameter before and after the repair.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChangeReport {
    /// Name.
    pub id: String,
    /// Unit of the numbers: `arcsec` for tilts.
    pub unit: String,
    /// Before.
    pub before: Option<f64>,
    /// Standard uncertainty before.
    pub u_before: Option<f64>,
    /// After.
    pub after: Option<f64>,
    /// Standard uncertainty after, with what is not known about which alias it is.
    pub u_after: Option<f64>,
    /// Standard uncertainty after, if the effects are the ones named.
    pub u_after_as_named: Option<f64>,
    /// How far the value would move at most if an alias were the effect (rectangular half-width; part of `u_after`).
    pub alias_half_width: f64,
    /// After minus before, over the standard uncertainty after as named.
    pub change_in_u: Option<f64>,
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
    /// Before.
    pub before: f64,
    /// After.
    pub after: f64,
}

/// The report of a diagnosis; `campaign` is the question with its constraints.
pub fn diagnose_report(campaign: &Campaign, diagnosis: &Diagnosis, settings: &diagnosis::Settings) -> DiagnoseReport {
    let model = |campaign: &Campaign| -> BTreeMap<String, String> {
        campaign.bench.sensors.iter().map(|s| (s.id.clone(), s.model.to_string())).collect()
    };
    let sensor = |k: usize| campaign.bench.sensors.get(k).map(|s| s.id.clone()).unwrap_or_default();
    let keys = |list: &[Vec<crate::campaign::JointState>]| -> Vec<PositionReport> {
        list.iter().map(|joints| position_keys(campaign, joints)).collect()
    };
    let after = diagnosis.after.as_ref().unwrap_or(&diagnosis.before);
    DiagnoseReport {
        tumble: VERSION.into(),
        report: "diagnose".into(),
        bench: campaign.bench.id.clone(),
        verdict: diagnosis.verdict.name().into(),
        significance: settings.significance,
        effects: diagnosis.effects.iter().map(|finding| effect(finding, &sensor, &keys)).collect(),
        model_before: model(&diagnosis.before.campaign),
        model_after: model(&after.campaign),
        gap: GapsReport {
            before: gap(&diagnosis.gap_before),
            after: gap(&diagnosis.gap_after),
            noise: NoiseReport { sd: diagnosis.noise.sd, from: diagnosis.noise.from.name().into() },
        },
        places: diagnosis
            .places
            .iter()
            .map(|place| PlaceReport {
                factor: place.factor.clone(),
                level: match &place.level {
                    Level::Number(v) => LevelReport::Number(*v),
                    Level::Text(text) => LevelReport::Text(text.clone()),
                },
                sensor: sensor(place.sensor),
                readings: place.readings,
                mean: place.mean,
                p: place.p,
            })
            .collect(),
        unexplained: diagnosis.unexplained.as_ref().map(|own| UnexplainedReport {
            pattern: own.pattern.clone(),
            cells: own
                .cells
                .iter()
                .map(|cell| CellReport {
                    at: position_keys(campaign, &cell.joints),
                    sensor: sensor(cell.sensor),
                    readings: cell.readings,
                    mean: cell.mean,
                    z: cell.z,
                })
                .collect(),
            nearest: own.nearest.iter().map(|c: &Candidate| c.regressor.clone()).collect(),
            nearest_explains: own.nearest_explains,
        }),
        holdout: diagnosis.holdout.as_ref().map(|own| HoldoutReport {
            positions: own.positions,
            skipped: own.skipped,
            before: own.before,
            after: own.after,
        }),
        steps: diagnosis
            .steps
            .iter()
            .map(|step| StepReport {
                with: step.with.clone(),
                strongest: step.strongest.as_ref().map(|(name, _, _)| name.clone()),
                t: step.strongest.as_ref().map(|(_, t, _)| *t),
                p: step.strongest.as_ref().map(|(_, _, p)| *p),
                global_p: step.global_p,
            })
            .collect(),
        candidates: diagnosis.candidates.0,
        distinct_candidates: diagnosis.candidates.1,
        parameters: diagnosis.changes.iter().map(change).collect(),
        residuals: residuals(campaign, diagnosis),
        would_help: keys(&diagnosis.would_help),
        constraints_left_out: campaign.constraints.len(),
    }
}

fn effect(
    finding: &Finding,
    sensor: &dyn Fn(usize) -> String,
    keys: &dyn Fn(&[Vec<crate::campaign::JointState>]) -> Vec<PositionReport>,
) -> EffectReport {
    let own = &finding.effect;
    EffectReport {
        regressor: own.regressor.clone(),
        name: own.name.clone(),
        coefficient: own.coefficient.clone(),
        sensor: own.sensor.map(sensor),
        value: finding.value,
        u: finding.u,
        unit: finding.unit.clone(),
        arcsec: finding.value.filter(|_| finding.unit == "rad").map(|v| v * ARCSEC),
        t: finding.t,
        p: finding.p,
        explains: finding.explains,
        why: own.why.clone(),
        confirm: own.confirm.clone(),
        zero_but_for_rounding: own.rounding,
        aliases: finding
            .aliases
            .iter()
            .map(|alias| AliasReport {
                regressor: alias.regressor.clone(),
                name: alias.name.clone(),
                exact: alias.exact,
                excess: alias.excess,
                zero_but_for_rounding: alias.rounding,
                together_with: alias.together_with.clone(),
            })
            .collect(),
        separate_by: keys(&finding.separate_by),
    }
}

fn gap(own: &Gap) -> GapReport {
    GapReport { rms: own.rms, max: own.max, chi_square: own.chi_square, dof: own.dof, p: own.p }
}

fn change(own: &diagnosis::Change) -> ChangeReport {
    let scale = if own.is_angle { ARCSEC } else { 1.0 };
    let scaled = |v: Option<f64>| v.map(|v| v * scale);
    let change_in_u = match (own.before.0, own.after) {
        (Some(before), (Some(after), Some(u))) if u > 0.0 => Some((after - before) / u),
        _ => None,
    };
    ChangeReport {
        id: own.id.clone(),
        unit: if own.is_angle { "arcsec".into() } else { own.unit.clone() },
        before: scaled(own.before.0),
        u_before: scaled(own.before.1),
        after: scaled(own.after.0),
        u_after: scaled(own.u_with_aliases()),
        u_after_as_named: scaled(own.after.1),
        alias_half_width: scale * own.alias_half_width,
        change_in_u,
    }
}

fn residuals(campaign: &Campaign, diagnosis: &Diagnosis) -> Vec<ResidualReport> {
    let rows = diagnosis.before.design.rows.iter();
    rows.zip(diagnosis.gap_before.residuals.iter().zip(&diagnosis.gap_after.residuals))
        .map(|(origin, (before, after))| ResidualReport {
            index: origin.reading + 1,
            position: campaign.readings.rows.get(origin.reading).map(|r| r.position.clone()).unwrap_or_default(),
            sensor: campaign.bench.sensors.get(origin.sensor).map(|s| s.id.clone()).unwrap_or_default(),
            before: *before,
            after: *after,
        })
        .collect()
}
