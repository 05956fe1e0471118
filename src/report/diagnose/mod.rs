//! The report of a diagnosis (`tumble diagnose --json`), and its document.

mod document;
mod effects;
mod figure;
mod gap;
pub(super) mod words;

pub use document::diagnose_document;
pub use effects::{AliasReport, ChangeReport, EffectReport};
pub use figure::diagnose_figure;
pub use gap::{
    CellReport, GapReport, GapsReport, LevelReport, NoiseReport, PlaceReport, ResidualReport, SensorGapReport,
    UnexplainedReport,
};
pub use words::alias_note;

use super::scatter::{self, ScatterReport};
use super::{Input, PositionReport, VERSION, fit_constraints, position_keys};
use crate::campaign::{Campaign, Identity};
use crate::diagnosis::{self, Diagnosis, Held, State, Suspect, Verdict};
use crate::report::ReportKind;
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
    pub places: Vec<PlaceReport>,
    /// What scatters, the effects being in the model; empty where only the readings' own noise does.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub scatter: Vec<ScatterReport>,
    /// What is unexplained; null unless the verdict says so.
    pub unexplained: Option<UnexplainedReport>,
    /// Leave-one-position-out prediction; null where no position can be predicted from the others.
    pub holdout: Option<HoldoutReport>,
    /// The gap as given, after the first effect, after the second, and so on.
    pub steps: Vec<GapStepReport>,
    /// How many candidates were tried.
    pub candidates: usize,
    /// How many of them are distinct on this schedule: the number of tests that every p accounts for.
    pub distinct_candidates: usize,
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
#[non_exhaustive]
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
#[non_exhaustive]
pub struct AssertedReport {
    /// Number in the file, from 1.
    pub index: usize,
    /// The constraint as a line of text.
    pub text: String,
    /// `equality` (met exactly), `at-limit` (an inequality that holds the estimate back: taken as an equality), `inactive`,
    /// `left-out` (it contradicts others, or cannot be applied), `wrong` (a finding: taken away by the repair).
    pub state: Held,
}

/// Leave-one-position-out prediction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct HoldoutReport {
    /// Positions predicted from the others.
    pub positions: usize,
    /// Positions that cannot be left out, because they alone hold a parameter.
    pub skipped: usize,
    /// Root mean square prediction error before, in standard uncertainties of prediction and reading together: 1 for a true model.
    pub before: f64,
    /// The same with the effects, in the same unit.
    pub after: Option<f64>,
}

/// The evidence with some effects in the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
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

/// The gap with some effects in the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct GapStepReport {
    /// Effects in the model.
    pub with: Vec<String>,
    /// Each sensor's model line.
    pub model: BTreeMap<String, String>,
    /// The gap.
    pub gap: GapReport,
    /// The strongest further candidate.
    pub strongest: Option<String>,
    /// Its t.
    pub t: Option<f64>,
    /// Its probability by chance among all that was tried.
    pub p: Option<f64>,
    /// Probability of what is left by chance.
    pub global_p: Option<f64>,
    /// What was decided here, and why.
    pub decision: String,
}

/// The report of a diagnosis; `campaign` is the question with its constraints.
pub fn diagnose_report(campaign: &Campaign, diagnosis: &Diagnosis, settings: &diagnosis::Settings) -> DiagnoseReport {
    let model = |campaign: &Campaign| -> BTreeMap<String, String> {
        campaign.bench.sensors.iter().map(|s| (s.id.clone(), s.model.to_string())).collect()
    };
    let after = diagnosis.after.as_ref().unwrap_or(&diagnosis.before);
    DiagnoseReport {
        tumble: VERSION.into(),
        report: ReportKind::Diagnose,
        bench: campaign.bench.id.clone(),
        identity: campaign.identity.clone(),
        inputs: Vec::new(),
        verdict: diagnosis.verdict,
        significance: settings.significance,
        effects: effects::effects(campaign, diagnosis),
        state: diagnosis.state,
        suspected: diagnosis.suspected.iter().map(|own| suspect(campaign, own)).collect(),
        model_before: model(&diagnosis.before.campaign),
        model_after: model(&after.campaign),
        gap: gap::gaps(campaign, diagnosis),
        places: gap::places(campaign, diagnosis, settings.significance),
        scatter: if after.campaign.scatter.is_empty() { Vec::new() } else { scatter::scatter(after) },
        unexplained: gap::unexplained(campaign, diagnosis),
        holdout: diagnosis.holdout.as_ref().map(|own| HoldoutReport {
            positions: own.positions,
            skipped: own.skipped,
            before: own.before,
            after: own.after,
        }),
        steps: diagnosis.steps.iter().map(step).collect(),
        candidates: diagnosis.candidates.0,
        distinct_candidates: diagnosis.candidates.1,
        parameters: diagnosis.changes.iter().map(effects::change).collect(),
        averaged_from: diagnosis.averaged.map(|(from, _)| from),
        residuals: gap::residuals(campaign, diagnosis),
        would_help: diagnosis.would_help.iter().map(|joints| position_keys(campaign, joints)).collect(),
        assumed_zero: diagnosis.before.assumed_zero().map(str::to_string).collect(),
        constraints: asserted(campaign, &diagnosis.constraints),
    }
}

fn suspect(campaign: &Campaign, own: &Suspect) -> SuspectReport {
    SuspectReport {
        regressor: own.effect.regressor.clone(),
        name: own.effect.name.clone(),
        sensor: own.effect.sensor.map(|k| campaign.sensor_id(k).to_string()),
        probability: own.probability,
    }
}

fn step(step: &diagnosis::GapStep) -> GapStepReport {
    let own = &step.evidence;
    GapStepReport {
        with: own.with.clone(),
        model: step.model.iter().cloned().collect(),
        gap: gap::of_step(step),
        strongest: own.strongest.as_ref().map(|(name, _, _)| name.clone()),
        t: own.strongest.as_ref().map(|(_, t, _)| *t),
        p: own.strongest.as_ref().map(|(_, _, p)| *p),
        global_p: own.global_p,
        decision: step.decision.clone(),
    }
}

fn asserted(campaign: &Campaign, held: &[Held]) -> Vec<AssertedReport> {
    let constraints = campaign.constraints.iter().zip(held).enumerate();
    constraints
        .map(|(k, (constraint, held))| AssertedReport {
            index: k + 1,
            text: fit_constraints::constraint_text(campaign, constraint),
            state: *held,
        })
        .collect()
}
