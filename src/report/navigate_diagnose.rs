//! The report of a diagnosis of measured navigation errors (`tumble diagnose MISSION --measured F --json`).

use super::navigate::error_quantities;
use super::{GapReport, GapsReport, NoiseReport, QuantityWithUnit, StepReport, VERSION};
use crate::diagnosis::{NoiseFrom, Verdict};
use crate::elements::Elements;
use crate::navigate::cause::Cause;
use crate::navigate::diagnose::{Alias, Finding, Gap, NavigationDiagnosis};
use crate::navigate::errors::ErrorSource;
use crate::navigate::measured::{CHANNEL_NAMES, Measured, si_per_unit};
use crate::navigate::mission::Mission;
use crate::navigate::separate::DiscriminatingMotion;
use crate::navigate::settings::Settings;
use crate::navigate::study;
use crate::report::ReportKind;
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
    pub gap_steps: Vec<NavigationGapStepReport>,
    /// The gap by run and channel, in the channel's own unit.
    pub channels: Vec<ChannelReport>,
    /// What is unexplained (beside what was found); null unless the verdict says so.
    pub unexplained: Option<UnexplainedNavigationReport>,
    /// Single values that noise does not explain after all that was found, the furthest first.
    pub suspects: Vec<NavigationSuspectReport>,
    /// The search's record.
    pub steps: Vec<StepReport>,
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

/// The gap with some of the causes that were found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct NavigationGapStepReport {
    /// The causes.
    pub with: Vec<String>,
    /// Single values that are left out.
    pub left_out: usize,
    /// The gap.
    pub gap: GapReport,
}

/// A run that was measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct RunReport {
    /// Name of the mission's motion.
    pub motion: String,
    /// Rows.
    pub rows: usize,
}

/// An error that the mission misses.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
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
#[non_exhaustive]
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
#[non_exhaustive]
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

/// The gap in one channel of one run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct ChannelReport {
    /// Name of the motion.
    pub motion: String,
    /// The column; its name has the unit of all numbers here.
    pub column: String,
    /// Values measured.
    pub values: usize,
    /// Root mean square before, in the column's unit.
    pub rms_before: f64,
    /// Largest by size before, in the column's unit.
    pub max_before: f64,
    /// Root mean square after, in the column's unit.
    pub rms_after: f64,
    /// Largest by size after, in the column's unit.
    pub max_after: f64,
    /// Standard uncertainty of a value, in the column's unit.
    pub u: f64,
    /// `stated` or `residuals` (then it can only come from what is left).
    pub u_from: NoiseFrom,
}

/// What nothing explains.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct UnexplainedNavigationReport {
    /// In one sentence.
    pub pattern: String,
    /// Mean gap by channel and part of a run, the most significant first.
    pub cells: Vec<NavigationCellReport>,
    /// The errors that come nearest together; they are not accepted.
    pub nearest: Vec<String>,
    /// Share of the residual sum of squares that those would remove.
    pub nearest_explains: f64,
}

/// A single value that noise does not explain.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct NavigationSuspectReport {
    /// Name of the motion.
    pub motion: String,
    /// The column.
    pub column: String,
    /// Time, s.
    pub time_s: f64,
    /// What is left of it, in standard uncertainties.
    pub z: f64,
}

/// Mean gap in a part of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct NavigationCellReport {
    /// Name of the motion.
    pub motion: String,
    /// The column.
    pub column: String,
    /// Start of the part, h.
    pub from_h: f64,
    /// End of the part, h.
    pub to_h: f64,
    /// Values there.
    pub values: usize,
    /// Mean gap, in the column's unit.
    pub mean: f64,
    /// Its size in standard deviations.
    pub z: f64,
}

/// The report of a diagnosis of measured navigation errors.
pub fn navigate_diagnose_report(
    mission: &Mission,
    measured: &Measured,
    diagnosis: &NavigationDiagnosis,
    settings: &Settings,
) -> NavigateDiagnoseReport {
    let motions: Vec<String> = study::motions(mission).into_iter().map(|(name, _)| name).collect();
    let run = |run: &crate::navigate::measured::Run| RunReport {
        // runs are numbered by the motions of this mission
        motion: motions.get(run.motion).cloned().unwrap_or_default(),
        rows: run.rows.len(),
    };
    let [before, after] = diagnosis.gap.map(gap);
    NavigateDiagnoseReport {
        tumble: VERSION.into(),
        report: ReportKind::NavigateDiagnose,
        mission: mission.title.clone(),
        runs: measured.runs.iter().map(run).collect(),
        left_out: measured.left_out,
        verdict: diagnosis.verdict,
        significance: settings.common.significance,
        effects: diagnosis.findings.iter().map(|finding| effect(finding, diagnosis)).collect(),
        model_before: error_quantities(&diagnosis.before),
        model_after: error_quantities(&diagnosis.after),
        gap: GapsReport {
            before,
            after,
            sensors: BTreeMap::new(),
            noise: NoiseReport { sd: None, from: diagnosis.noise },
        },
        gap_steps: diagnosis
            .gap_steps
            .iter()
            .map(|own| NavigationGapStepReport { with: own.with.clone(), left_out: own.left_out, gap: gap(own.gap) })
            .collect(),
        channels: channels(measured, diagnosis),
        unexplained: diagnosis.unexplained.as_ref().map(|own| UnexplainedNavigationReport {
            pattern: own.pattern.clone(),
            cells: own.cells.iter().map(cell).collect(),
            nearest: own.nearest.iter().map(Cause::id).collect(),
            nearest_explains: own.nearest_explains,
        }),
        suspects: diagnosis
            .suspects
            .iter()
            .map(|own| NavigationSuspectReport {
                motion: measured
                    .runs
                    .get(own.cell.run)
                    .and_then(|run| motions.get(run.motion))
                    .cloned()
                    .unwrap_or_default(),
                column: column(own.cell.channel),
                time_s: own.cell.time,
                z: own.z,
            })
            .collect(),
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
        invisible: diagnosis.invisible.iter().map(ErrorSource::id).collect(),
        refits: diagnosis.refits.0,
        settled: diagnosis.refits.1,
    }
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
        before: source.of(&diagnosis.before).map(|own| own / unit),
        after: source.of(&diagnosis.after).map(|own| own / unit),
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

fn separation(own: &DiscriminatingMotion) -> SeparationReport {
    let motion = MotionFile::of(&own.motion);
    let is = motion.in_words();
    SeparationReport { motion, is, tells: own.tells.iter().map(ErrorSource::id).collect(), by: own.by }
}

fn gap(own: Gap) -> GapReport {
    GapReport {
        rms: (own.dof > 0).then_some(own.rms),
        max: own.max,
        chi_square: own.chi_square,
        dof: own.dof,
        p: own.p,
    }
}

fn column(channel: usize) -> String {
    CHANNEL_NAMES.at(channel).into()
}

fn channels(measured: &Measured, diagnosis: &NavigationDiagnosis) -> Vec<ChannelReport> {
    let stated = |channel: usize| measured.cells().filter(|cell| cell.channel == channel).all(|cell| cell.u.is_some());
    let one = |own: &crate::navigate::remainder::ChannelGap| {
        let unit = si_per_unit(own.channel);
        let from = if stated(own.channel) { NoiseFrom::Stated } else { NoiseFrom::Residuals };
        ChannelReport {
            motion: own.motion.clone(),
            column: column(own.channel),
            values: own.values,
            rms_before: own.before.0 / unit,
            max_before: own.before.1 / unit,
            rms_after: own.after.0 / unit,
            max_after: own.after.1 / unit,
            u: own.u / unit,
            u_from: from,
        }
    };
    diagnosis.channels.iter().map(one).collect()
}

fn cell(own: &crate::navigate::remainder::Cell) -> NavigationCellReport {
    NavigationCellReport {
        motion: own.motion.clone(),
        column: column(own.channel),
        from_h: own.span.0 / 3600.0,
        to_h: own.span.1 / 3600.0,
        values: own.values,
        mean: own.mean / si_per_unit(own.channel),
        z: own.z,
    }
}
