//! Where the gap is: by position, joint angle, rate, sense, time, temperature and order; and its pattern over the joints' states.

use super::noise::Weighted;
use crate::campaign::{Campaign, JointState, Reading};
use crate::design::DesignMatrix;
use crate::uncertainty::quantiles::normal_survival;

/// A level of a factor.
#[derive(Debug, Clone, PartialEq)]
pub enum Level {
    /// A number: an angle, a rate, the middle of a part of the time.
    Number(f64),
    /// A label.
    Text(String),
}

/// The mean residual at one level of a factor.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// The factor: `alpha_deg`, `gamma_deg_s`, `position`, `sense_of_gamma`, `time_s`, `temperature_c`, `order`.
    pub factor: String,
    /// The level.
    pub level: Level,
    /// The sensor.
    pub sensor: usize,
    /// Readings at this level.
    pub readings: usize,
    /// Their mean residual, in the sensor's unit.
    pub mean: f64,
    /// Two-sided probability of a mean as large by chance, all others given.
    pub p: f64,
    /// The standardised mean behind it.
    pub z: f64,
}

/// The mean residual at one state of the joints.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// The state.
    pub joints: Vec<JointState>,
    /// The sensor.
    pub sensor: usize,
    /// Readings there.
    pub readings: usize,
    /// Mean residual, in the sensor's unit.
    pub mean: f64,
    /// Its standardised size.
    pub z: f64,
}

/// Parts that time, temperature and order are cut into.
const PARTS: usize = 4;
/// Most levels and cells that are listed.
const LISTED: usize = 40;
/// Factors with more levels than this are continuous.
const LEVELS: usize = 64;

/// Every level of every factor, the most significant first.
pub(super) fn places(campaign: &Campaign, design: &DesignMatrix, weighted: &Weighted) -> Vec<Place> {
    let mut places = Vec::new();
    for (factor, levels) in factors(campaign) {
        for sensor in 0..campaign.bench.sensors.len() {
            for (level, members) in &levels {
                if let Some((readings, mean, z)) = mean_of(design, weighted, sensor, members) {
                    let p = normal_survival(z.abs()).map_or(1.0, |p| (2.0 * p).min(1.0));
                    places.push(Place { factor: factor.clone(), level: level.clone(), sensor, readings, mean, p, z });
                }
            }
        }
    }
    places.sort_by(|a, b| b.z.abs().total_cmp(&a.z.abs()));
    places.truncate(LISTED);
    places
}

/// Mean residual at every distinct state of the joints, the most significant first.
pub(super) fn cells(campaign: &Campaign, design: &DesignMatrix, weighted: &Weighted) -> Vec<Cell> {
    let mut states: Vec<(Vec<JointState>, Vec<usize>)> = Vec::new();
    for (k, reading) in campaign.readings.rows.iter().enumerate() {
        match states.iter_mut().find(|(joints, _)| *joints == reading.joints) {
            Some((_, members)) => members.push(k),
            None => states.push((reading.joints.clone(), vec![k])),
        }
    }
    let mut cells = Vec::new();
    for sensor in 0..campaign.bench.sensors.len() {
        for (joints, members) in &states {
            if let Some((readings, mean, z)) = mean_of(design, weighted, sensor, members) {
                cells.push(Cell { joints: joints.clone(), sensor, readings, mean, z });
            }
        }
    }
    cells.sort_by(|a, b| b.z.abs().total_cmp(&a.z.abs()));
    cells.truncate(LISTED);
    cells
}

/// The pattern in one sentence.
pub(super) fn pattern(campaign: &Campaign, design: &DesignMatrix, weighted: &Weighted, cells: &[Cell]) -> String {
    let total: f64 = weighted.rss;
    let mut shares: Vec<(f64, String)> = factors(campaign)
        .into_iter()
        .filter_map(|(factor, levels)| {
            let between: f64 = (0..campaign.bench.sensors.len())
                .flat_map(|sensor| {
                    levels.iter().filter_map(move |(_, members)| mean_of(design, weighted, sensor, members))
                })
                .map(|(_, _, z)| z * z)
                .sum();
            let tests = levels.len().max(2) as f64;
            (between > 3.0 * tests).then(|| ((between / total).min(1.0), factor))
        })
        .collect();
    shares.sort_by(|a, b| b.0.total_cmp(&a.0));
    let by_state: f64 = cells.iter().map(|cell| cell.z * cell.z).sum::<f64>() / cells.len().max(1) as f64;
    let mut text = String::from("residuals are larger than the noise");
    if by_state > 3.0 {
        text.push_str(", repeat with the joints' states");
    } else {
        text.push_str(", and do not repeat with the joints' states (time, temperature or a noise larger than stated)");
    }
    let named: Vec<String> = shares.iter().take(3).map(|(_, factor)| factor.clone()).collect();
    if !named.is_empty() {
        text.push_str(&format!(", and follow {}", named.join(", ")));
    }
    if let Some(cell) = cells.first() {
        let joints: Vec<String> = campaign
            .bench
            .joints()
            .zip(&cell.joints)
            .filter_map(|(name, state)| {
                let (deg, deg_s, _) = state.keys();
                deg.map(|v| format!("{name} = {v} deg")).or(deg_s.map(|v| format!("{name} at {v} deg/s")))
            })
            .collect();
        let unit = campaign.bench.sensors.get(cell.sensor).map_or("", |s| s.unit.as_str());
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

/// A factor and the readings at each of its levels.
type Factor = (String, Vec<(Level, Vec<usize>)>);

fn factors(campaign: &Campaign) -> Vec<Factor> {
    let rows = &campaign.readings.rows;
    let mut factors: Vec<Factor> = Vec::new();
    let mut by = |name: String, level: &dyn Fn(&Reading) -> Option<Level>| {
        let mut levels: Vec<(Level, Vec<usize>)> = Vec::new();
        for (k, reading) in rows.iter().enumerate() {
            let Some(level) = level(reading) else { continue };
            match levels.iter().position(|(own, _)| *own == level) {
                Some(place) => levels.get_mut(place).into_iter().for_each(|(_, members)| members.push(k)),
                None if levels.len() < LEVELS => levels.push((level, vec![k])),
                None => return,
            }
        }
        if levels.len() > 1 {
            factors.push((name, levels));
        }
    };
    by("position".into(), &|reading| (!reading.position.is_empty()).then(|| Level::Text(reading.position.clone())));
    for (k, joint) in campaign.bench.joints().enumerate() {
        let state = |reading: &Reading| reading.joints.get(k).copied();
        by(format!("{joint}_deg"), &|reading| match state(reading) {
            Some(JointState::Held { angle_deg }) => Some(Level::Number(angle_deg)),
            _ => None,
        });
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
fn parts(name: &str, values: &[Option<f64>]) -> Option<Factor> {
    let mut known: Vec<(f64, usize)> = values.iter().enumerate().filter_map(|(k, v)| v.map(|v| (v, k))).collect();
    known.sort_by(|a, b| a.0.total_cmp(&b.0));
    if known.len() < 2 * PARTS || known.first().map(|f| f.0) == known.last().map(|l| l.0) {
        return None;
    }
    let size = known.len().div_ceil(PARTS);
    let levels = known
        .chunks(size)
        .map(|part| {
            let mean = part.iter().map(|(v, _)| v).sum::<f64>() / part.len() as f64;
            (Level::Number(mean), part.iter().map(|(_, k)| *k).collect())
        })
        .collect();
    Some((name.to_string(), levels))
}

/// Number of rows, mean residual and its standardised size, for the rows of some readings of one sensor; `None` without any, or where the
/// model absorbs them.
fn mean_of(design: &DesignMatrix, weighted: &Weighted, sensor: usize, readings: &[usize]) -> Option<(usize, f64, f64)> {
    let wanted: std::collections::HashSet<usize> = readings.iter().copied().collect();
    let rows = design.rows.iter().enumerate();
    let members: Vec<usize> =
        rows.filter(|(_, o)| o.sensor == sensor && wanted.contains(&o.reading)).map(|(i, _)| i).collect();
    if members.is_empty() {
        return None;
    }
    let q = weighted.estimate.factor.thin_q();
    let (mut along, mut square, mut product, mut mean) = (vec![0.0; q.ncols()], 0.0, 0.0, 0.0);
    for &i in &members {
        let (Some(w), Some(r), Some(v)) =
            (weighted.weight.get(i), weighted.residual.get(i), weighted.estimate.residuals.get(i))
        else {
            continue;
        };
        square += w * w;
        product += w * r;
        mean += v;
        for (k, slot) in along.iter_mut().enumerate() {
            *slot += q[(i, k)] * w;
        }
    }
    let left = square - along.iter().map(|a| a * a).sum::<f64>();
    let z = if left > 1e-9 * square { product / left.sqrt() } else { 0.0 };
    Some((members.len(), mean / members.len() as f64, z))
}
