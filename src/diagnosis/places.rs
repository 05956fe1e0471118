//! Where the gap is: by position, joint angle, rate, sense, time, temperature and order; and its pattern over the joints' states.

use super::common::NoiseFrom;
use super::noise::Weighted;
use super::screen::{Indicators, Sums};
use crate::campaign::{Campaign, JointState, Reading, joint_keys};
use crate::design::DesignMatrix;
use crate::elements::{Elements, numbered};
use crate::uncertainty::quantiles::{normal_survival, student_t_two_sided};
use std::collections::BTreeMap;

/// A level: a number or a label.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "LevelReport")]
#[serde(untagged)]
pub enum Level {
    /// A number.
    Number(f64),
    /// A label.
    Text(String),
}

/// Mean residual at one level of a factor.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "PlaceReport")]
#[non_exhaustive]
pub struct Place {
    /// The factor.
    pub factor: String,
    /// The level.
    pub level: Level,
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

/// Mean residual at one state of the joints.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "CellReport")]
pub struct PlaceMean {
    /// The state.
    pub at: BTreeMap<String, f64>,
    /// The sensor.
    pub sensor: String,
    /// Readings there.
    pub readings: usize,
    /// Mean residual, in the sensor's unit.
    pub mean: f64,
    /// Its size in standard deviations.
    pub z: f64,
}

/// Parts that time, temperature and order are cut into.
const PARTS: usize = 4;
/// Most levels and cells that are listed.
const LISTED: usize = 40;
/// Factors with more levels than this are continuous.
const LEVELS: usize = 64;

/// The readings by the levels of one factor.
#[derive(Debug, Clone, PartialEq)]
pub struct Grouping {
    /// The factor.
    pub factor: String,
    /// Its levels, in order of first appearance.
    pub levels: Vec<Level>,
    /// Level of each reading of the campaign, by index; `None` where it has none.
    pub of: Vec<Option<usize>>,
}

/// Most levels of a factor by which a picture groups the readings.
const GROUPS: usize = 24;
/// A factor whose standardised means have a larger mean square than this is followed by the gap.
const FOLLOWED: f64 = 2.0;

/// The probability of a `t` as large by chance in one test; the noise is known where the degrees of freedom are infinite.
pub(super) fn by_chance(t: f64, dof: f64) -> f64 {
    let alone = if dof.is_finite() {
        if dof < 1.0 { Some(1.0) } else { student_t_two_sided(t.abs(), dof) }
    } else {
        normal_survival(t.abs()).map(|p| 2.0 * p)
    };
    // not testable: not significant
    alone.unwrap_or(1.0).clamp(0.0, 1.0)
}

/// Every level of every factor, the most significant first; by Student's t where the noise is estimated.
pub(super) fn places(campaign: &Campaign, design: &DesignMatrix, weighted: &Weighted, significance: f64) -> Vec<Place> {
    let mut places = Vec::new();
    let dof = match (weighted.from, &weighted.replicates) {
        (NoiseFrom::Stated, _) => f64::INFINITY,
        (_, Some(replicates)) => replicates.dof.max(1) as f64,
        _ => weighted.estimate.dof.max(1) as f64,
    };
    let residuals = Residuals::new(design, weighted);
    for factor in factors(campaign) {
        for sensor in 0..campaign.bench.sensors.len() {
            for (level, mean) in factor.levels.iter().zip(residuals.means(sensor, &factor)) {
                if let Some(Mean { readings, mean, z }) = mean {
                    let p = by_chance(z, dof);
                    let (factor, level) = (factor.factor.clone(), level.clone());
                    let (sensor, significant) = (campaign.sensor_id(sensor).to_string(), Some(p < significance));
                    places.push(Place { factor, level, sensor, readings, mean, z, p, significant });
                }
            }
        }
    }
    places.sort_by(|a, b| b.z.abs().total_cmp(&a.z.abs()));
    places.truncate(LISTED);
    places
}

/// The factor with few levels that the gap follows most, if it follows any; every reading has a level of it.
pub(super) fn grouping(campaign: &Campaign, design: &DesignMatrix, weighted: &Weighted) -> Option<Grouping> {
    let residuals = Residuals::new(design, weighted);
    let all = |factor: &Grouping| factor.of.iter().all(Option::is_some);
    let few = factors(campaign).into_iter().filter(|factor| factor.levels.len() <= GROUPS && all(factor));
    let scored = few.map(|factor| {
        let between = residuals.between(campaign.bench.sensors.len(), &factor);
        (between / factor.levels.len() as f64, factor)
    });
    // means of noise have squares of one
    let followed = scored.filter(|(between, _)| *between > FOLLOWED);
    let best = followed.fold(None, |best: Option<(f64, Grouping)>, next| match best {
        Some(before) if before.0 >= next.0 => Some(before),
        _ => Some(next),
    });
    best.map(|(_, factor)| factor)
}

/// Mean residual at every distinct state of the joints, the most significant first.
pub(super) fn cells(campaign: &Campaign, design: &DesignMatrix, weighted: &Weighted) -> Vec<PlaceMean> {
    let rows = &campaign.readings.rows;
    let (of, count) = numbered(rows.iter().map(|row| row.joints.iter().map(JointState::bits).collect::<Vec<_>>()));
    let mut states: Vec<&[JointState]> = Vec::new();
    for (row, number) in rows.iter().zip(&of) {
        states.extend((*number == states.len()).then_some(row.joints.as_slice()));
    }
    let levels = vec![Level::Number(0.0); count];
    let by_state = Grouping { factor: String::new(), levels, of: of.into_iter().map(Some).collect() };
    let residuals = Residuals::new(design, weighted);
    let mut cells = Vec::new();
    for sensor in 0..campaign.bench.sensors.len() {
        for (joints, mean) in states.iter().zip(residuals.means(sensor, &by_state)) {
            if let Some(Mean { readings, mean, z }) = mean {
                let at = joint_keys(campaign.bench.joints(), joints).collect();
                cells.push(PlaceMean { at, sensor: campaign.sensor_id(sensor).to_string(), readings, mean, z });
            }
        }
    }
    cells.sort_by(|a, b| b.z.abs().total_cmp(&a.z.abs()));
    cells.truncate(LISTED);
    cells
}

/// The pattern in one sentence.
pub(super) fn pattern(campaign: &Campaign, design: &DesignMatrix, weighted: &Weighted, cells: &[PlaceMean]) -> String {
    let total: f64 = weighted.rss;
    let residuals = Residuals::new(design, weighted);
    let mut shares: Vec<(f64, String)> = factors(campaign)
        .into_iter()
        .filter_map(|factor| {
            let between = residuals.between(campaign.bench.sensors.len(), &factor);
            let tests = factor.levels.len().max(2) as f64;
            (between > 3.0 * tests).then(|| ((between / total).min(1.0), factor.factor))
        })
        .collect();
    shares.sort_by(|a, b| b.0.total_cmp(&a.0));
    let by_state: f64 = cells.iter().map(|cell| cell.z * cell.z).sum::<f64>() / cells.len().max(1) as f64;
    let mut text = String::from(match by_state > 3.0 {
        true => "the residuals are reproducible at equal joint states",
        false => {
            "the residuals are not reproducible at equal joint states (time, temperature or noise larger than stated)"
        }
    });
    let named: Vec<String> = shares.iter().take(3).map(|(_, factor)| factor.clone()).collect();
    if !named.is_empty() {
        text.push_str(&format!(", and follow {}", named.join(", ")));
    }
    if let Some(cell) = cells.first() {
        let stands = |name: &str| {
            let deg = cell.at.get(&format!("{name}_deg")).map(|v| format!("{name} = {v} deg"));
            deg.or_else(|| cell.at.get(&format!("{name}_deg_s")).map(|v| format!("{name} at {v} deg/s")))
        };
        let joints: Vec<String> = campaign.bench.joints().filter_map(stands).collect();
        let sensor = campaign.bench.sensors.iter().find(|sensor| sensor.id == cell.sensor);
        let unit = sensor.map_or("", |sensor| sensor.unit.as_str());
        if !joints.is_empty() {
            text.push_str(&format!(
                "; largest at {}: {:.3e} {unit} ({:.1} sd of its mean)",
                joints.join(", "),
                cell.mean,
                cell.z
            ));
        }
    }
    text
}

/// Every factor that these readings vary.
fn factors(campaign: &Campaign) -> Vec<Grouping> {
    let rows = &campaign.readings.rows;
    let mut factors: Vec<Grouping> = Vec::new();
    let mut by = |factor: String, level: &dyn Fn(&Reading) -> Option<Level>| {
        let mut levels: Vec<Level> = Vec::new();
        let mut of = Vec::with_capacity(rows.len());
        for reading in rows {
            let Some(level) = level(reading) else {
                of.push(None);
                continue;
            };
            let place = levels.iter().position(|other| *other == level).unwrap_or(levels.len());
            if place == levels.len() {
                if place == LEVELS {
                    return;
                }
                levels.push(level);
            }
            of.push(Some(place));
        }
        if levels.len() > 1 {
            factors.push(Grouping { factor, levels, of });
        }
    };
    by("position".into(), &|reading| (!reading.position.is_empty()).then(|| Level::Text(reading.position.to_string())));
    for (k, joint) in campaign.bench.joints().enumerate() {
        let state = |reading: &Reading| reading.joints.get(k).copied();
        by(format!("{joint}_deg"), &|reading| state(reading)?.held_deg().map(Level::Number));
        let rate = |reading: &Reading| state(reading).map(|s| s.rate_deg_s()).filter(|rate| *rate != 0.0);
        by(format!("{joint}_deg_s"), &|reading| rate(reading).map(Level::Number));
        by(format!("sense_of_{joint}"), &|reading| rate(reading).map(|rate| Level::Number(rate.signum())));
    }
    for column in ["time_s", "temperature_c"] {
        if let Some(k) = campaign.readings.columns.iter().position(|c| c == column) {
            let values: Vec<Option<f64>> = rows.iter().map(|row| row.columns.get(k).copied().flatten()).collect();
            factors.extend(parts(column, &values));
        }
    }
    let order: Vec<Option<f64>> = (0..rows.len()).map(|k| Some((k + 1) as f64)).collect();
    factors.extend(parts("order", &order));
    factors
}

/// A continuous factor in parts of equal number; the level is the part's mean.
fn parts(name: &str, values: &[Option<f64>]) -> Option<Grouping> {
    let mut known: Vec<(f64, usize)> = values.iter().enumerate().filter_map(|(k, v)| v.map(|v| (v, k))).collect();
    known.sort_by(|a, b| a.0.total_cmp(&b.0));
    if known.len() < 2 * PARTS || known.first().map(|f| f.0) == known.last().map(|l| l.0) {
        return None;
    }
    let mut factor = Grouping { factor: name.to_string(), levels: Vec::new(), of: vec![None; values.len()] };
    for part in known.chunks(known.len().div_ceil(PARTS)) {
        for (_, k) in part {
            factor.of.iter_mut().skip(*k).take(1).for_each(|level| *level = Some(factor.levels.len()));
        }
        let mean = part.iter().map(|(v, _)| v).sum::<f64>() / part.len() as f64;
        factor.levels.push(Level::Number(mean));
    }
    Some(factor)
}

/// The residuals at one level.
#[derive(Debug, Clone, Copy)]
struct Mean {
    readings: usize,
    mean: f64,
    /// Standardised: all levels but this one absorbed by nothing but the model.
    z: f64,
}

/// What the readings say at levels.
struct Residuals<'a> {
    design: &'a DesignMatrix,
    weighted: &'a Weighted,
    indicators: Indicators<'a>,
}

impl<'a> Residuals<'a> {
    fn new(design: &'a DesignMatrix, weighted: &'a Weighted) -> Self {
        Residuals { design, weighted, indicators: Indicators::new(weighted, &[]) }
    }

    /// The mean residual of one sensor at each level; `None` at levels without a reading.
    fn means(&self, sensor: usize, factor: &Grouping) -> Vec<Option<Mean>> {
        let mut levels = vec![(0, 0.0, self.indicators.none()); factor.levels.len()];
        for (i, origin) in self.design.rows.iter().enumerate().filter(|(_, origin)| origin.sensor == sensor) {
            let level = factor.of.get(origin.reading).copied().flatten();
            if let Some((readings, sum, sums)) = level.and_then(|level| levels.get_mut(level)) {
                *readings += 1;
                *sum += self.weighted.estimate.residuals.at(i);
                self.indicators.add(i, sums);
            }
        }
        let mean = |(readings, sum, sums): (usize, f64, Sums)| {
            let z = self.indicators.score(&sums);
            (readings > 0).then(|| Mean { readings, mean: sum / readings as f64, z })
        };
        levels.into_iter().map(mean).collect()
    }

    /// Sum of the squares of the standardised means of all sensors at the levels of a factor.
    fn between(&self, sensors: usize, factor: &Grouping) -> f64 {
        let means = (0..sensors).flat_map(|sensor| self.means(sensor, factor));
        means.flatten().map(|mean| mean.z * mean.z).sum()
    }
}
