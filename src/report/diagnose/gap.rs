//! The gap, as the report of a diagnosis has it: how large, where, and what of it is unexplained.

use super::super::{PositionReport, position_keys};
use crate::campaign::Campaign;
use crate::diagnosis::{Candidate, Diagnosis, Gap, Level, NoiseFrom};
use crate::fit::Fit;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The gap before and after.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct GapsReport {
    /// With the model as given.
    pub before: GapReport,
    /// With the effects; as before where nothing was found.
    pub after: GapReport,
    /// The noise floor.
    pub noise: NoiseReport,
    /// The same for each sensor by itself, in its unit.
    pub sensors: BTreeMap<String, SensorGapReport>,
}

/// A gap.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct GapReport {
    /// `sqrt(sum v^2 / dof)`; null without degrees of freedom. With sensors of several units it has none: see `sensors`.
    pub rms: Option<f64>,
    /// Largest residual by size, in the first sensor's unit (of navigation errors: in standard uncertainties).
    pub max: f64,
    /// `sum (v/u)^2` with the noise floor, a pure number.
    pub chi_square: f64,
    /// Degrees of freedom.
    pub dof: usize,
    /// Probability of a gap as large by chance; null where the noise is known from the residuals only.
    pub p: Option<f64>,
}

/// The gap of one sensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
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

/// The noise floor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct NoiseReport {
    /// Standard deviation of a reading of the first sensor, in its unit; null where it is unknown.
    pub sd: Option<f64>,
    /// `replicates`, `stated` or `residuals` (of the finished model: then completeness cannot be tested).
    pub from: NoiseFrom,
}

/// Mean residual at one level of a factor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct PlaceReport {
    /// The factor.
    pub factor: String,
    /// The level.
    pub level: LevelReport,
    /// The sensor.
    pub sensor: String,
    /// Readings there.
    pub readings: usize,
    /// Mean residual before, in the sensor's unit.
    pub mean: f64,
    /// Its size in standard deviations.
    pub z: f64,
    /// Probability of a mean as large by chance, this level alone.
    pub p: f64,
    /// Is that below the significance of the diagnosis?
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub significant: Option<bool>,
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
#[non_exhaustive]
pub struct UnexplainedReport {
    /// In one sentence.
    pub pattern: String,
    /// What readings share that share their deviation (the setting, a joint, a stretch of time); null where each has its own.
    pub follows: Option<String>,
    /// Standard deviation of what is unexplained, in the unit of the first sensor; null where the noise is unknown.
    pub sd: Option<f64>,
    /// Mean residual at each state of the joints.
    pub cells: Vec<CellReport>,
    /// The candidates that come nearest together; they are not accepted.
    pub nearest: Vec<String>,
    /// Share of the residual sum of squares that those would remove.
    pub nearest_explains: f64,
}

/// Mean residual at one state of the joints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct CellReport {
    /// The state.
    pub at: PositionReport,
    /// The sensor.
    pub sensor: String,
    /// Readings there.
    pub readings: usize,
    /// Mean residual, in the sensor's unit.
    pub mean: f64,
    /// Its size in standard deviations.
    pub z: f64,
}

/// A reading's residual before and after.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
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

pub(super) fn gaps(campaign: &Campaign, diagnosis: &Diagnosis) -> GapsReport {
    GapsReport {
        before: gap(&diagnosis.gap_before),
        after: gap(&diagnosis.gap_after),
        noise: NoiseReport { sd: diagnosis.noise.sd, from: diagnosis.noise.from },
        sensors: sensors(campaign, diagnosis),
    }
}

fn gap(own: &Gap) -> GapReport {
    GapReport { rms: own.rms, max: own.max, chi_square: own.chi_square, dof: own.dof, p: own.p }
}

/// The gap of a step.
pub(super) fn of_step(own: &crate::diagnosis::GapStep) -> GapReport {
    GapReport { rms: own.rms, max: own.max, chi_square: own.chi_square, dof: own.dof, p: own.evidence.global_p }
}

/// Is there a noise floor? Without a degree of freedom, and no stated uncertainty, there is none.
fn noise_is_known(diagnosis: &Diagnosis) -> bool {
    diagnosis.noise.sd.is_some()
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
            sd: noise_is_known(diagnosis).then(|| (variance / rows.len() as f64).sqrt()),
        };
        sensors.insert(sensor.id.clone(), report);
    }
    sensors
}

pub(super) fn places(campaign: &Campaign, diagnosis: &Diagnosis, significance: f64) -> Vec<PlaceReport> {
    let report = |place: &crate::diagnosis::Place| PlaceReport {
        factor: place.factor.clone(),
        level: match &place.level {
            Level::Number(v) => LevelReport::Number(*v),
            Level::Text(text) => LevelReport::Text(text.clone()),
        },
        sensor: sensor(campaign, place.sensor),
        readings: place.readings,
        mean: place.mean,
        z: place.z,
        p: place.p,
        significant: Some(place.p < significance),
    };
    diagnosis.places.iter().map(report).collect()
}

fn sensor(campaign: &Campaign, k: usize) -> String {
    campaign.sensor_id(k).to_string()
}

pub(super) fn unexplained(campaign: &Campaign, diagnosis: &Diagnosis) -> Option<UnexplainedReport> {
    let own = diagnosis.unexplained.as_ref()?;
    let cell = |cell: &crate::diagnosis::PlaceMean| CellReport {
        at: position_keys(campaign, &cell.joints),
        sensor: sensor(campaign, cell.sensor),
        readings: cell.readings,
        mean: cell.mean,
        z: cell.z,
    };
    Some(UnexplainedReport {
        pattern: own.pattern.clone(),
        follows: own.follows.clone(),
        sd: own.sd,
        cells: own.cells.iter().map(cell).collect(),
        nearest: own.nearest.iter().map(|c: &Candidate| c.regressor.clone()).collect(),
        nearest_explains: own.nearest_explains,
    })
}

pub(super) fn residuals(campaign: &Campaign, diagnosis: &Diagnosis) -> Vec<ResidualReport> {
    let rows = diagnosis.before.design.rows.iter().enumerate();
    rows.zip(diagnosis.gap_before.residuals.iter().zip(&diagnosis.gap_after.residuals))
        .map(|((i, origin), (before, after))| ResidualReport {
            index: origin.reading + 1,
            position: campaign.position_of(origin.reading).to_string(),
            sensor: sensor(campaign, origin.sensor),
            before: *before,
            after: *after,
            sd: diagnosis.row_sd.get(i).copied().filter(|sd| sd.is_finite() && noise_is_known(diagnosis)),
        })
        .collect()
}
