//! Long records: readings of one setting in one stretch of time are averaged before anything is compared.
//!
//! ```text
//! y = sum (y_i / u_i^2) / sum (1 / u_i^2),   u^2 = 1 / sum (1 / u_i^2)        columns: plain means
//! ```
//!
//! Where the model's inputs are the same, the mean is sufficient; what changes within a stretch (time, temperature) changes little there. A
//! reading far from its stretch stays by itself, so that it can be named.

use crate::campaign::{Campaign, Observation, Per, Reading, Readings, Shared};
use crate::number::median;
use crate::plan::grouped;
use std::collections::HashSet;

/// Campaigns with more readings than this are averaged,
pub(super) const LONG: usize = 8000;
/// to about so many.
const KEPT: usize = 1500;
/// A column with no more distinct values than this is a label: it is never averaged.
const LABELS: usize = 64;
/// A reading so many robust standard deviations from its stretch stays by itself (one in 5e8 of normal ones).
const APART: f64 = 6.0;
/// Fewest readings of a stretch for which that is asked.
const FEWEST: usize = 8;
/// Largest share of the readings that may stay apart: more are no outliers.
const MOST_APART: f64 = 0.01;

/// An averaged campaign.
pub(super) struct Averaged {
    pub campaign: Campaign,
    /// The first reading that each averaged one replaces.
    pub first: Vec<usize>,
}

/// The campaign with its readings averaged; `None` where it is not long.
pub(super) fn averaged(campaign: &Campaign) -> Option<Averaged> {
    let rows = &campaign.readings.rows;
    if rows.len() <= LONG {
        return None;
    }
    let labels: Vec<bool> = (0..campaign.readings.columns.len()).map(|k| is_label(rows, k)).collect();
    // a mean keeps what its readings share, and nothing that scatters anew in each of them
    if campaign.scatter.iter().any(|line| line.per == Per::Reading || line.over.is_some()) {
        return None;
    }
    let mut keys: Vec<Key<'_>> = rows.iter().map(|row| key(row, &labels)).collect();
    for line in &campaign.scatter {
        for (key, level) in keys.iter_mut().zip(line.per.levels(campaign).0) {
            key.1.push(level.map_or(u64::MAX, |level| level as u64));
        }
    }
    let states = keys.iter().collect::<HashSet<_>>().len();
    let window = (rows.len() * states).div_ceil(KEPT).max(1);
    let groups: Vec<Vec<usize>> = grouped(keys.iter().enumerate().map(|(k, key)| (k, (key, k / window))));
    let apart = apart(campaign, &groups);
    let mut merged: Vec<(usize, Reading)> = Vec::new();
    for group in &groups {
        let (alone, together): (Vec<usize>, Vec<usize>) = group.iter().partition(|k| apart.contains(k));
        merged.extend(alone.into_iter().filter_map(|k| Some((k, rows.get(k)?.clone()))));
        let members: Vec<&Reading> = together.iter().filter_map(|k| rows.get(*k)).collect();
        if let (Some(first), Some(reading)) = (together.first(), mean(&members)) {
            merged.push((*first, reading));
        }
    }
    merged.sort_by_key(|(first, _)| *first);
    let (first, rows) = merged.into_iter().unzip();
    let campaign = campaign.with_readings(Readings { columns: campaign.readings.columns.clone(), rows });
    Some(Averaged { campaign, first })
}

type Key<'a> = (&'a str, Vec<u64>);

/// Has this column only few values?
fn is_label(rows: &[Reading], column: usize) -> bool {
    let mut seen = HashSet::new();
    for row in rows {
        seen.insert(row.columns.get(column).copied().flatten().map(f64::to_bits));
        if seen.len() > LABELS {
            return false;
        }
    }
    true
}

/// What readings must share to be averaged: position, joints, labels, the columns and sensors that they have.
fn key<'a>(row: &'a Reading, labels: &[bool]) -> Key<'a> {
    let mut bits = Vec::new();
    for state in &row.joints {
        bits.extend(state.bits());
    }
    for (value, label) in row.columns.iter().zip(labels) {
        bits.push(match value {
            None => u64::MAX,
            Some(v) if *label => v.to_bits(),
            Some(_) => 0,
        });
    }
    bits.extend(row.observations.iter().map(|o| 2 * o.sensor as u64 + u64::from(o.u.is_some())));
    (row.position.as_str(), bits)
}

/// Readings far from the others of their stretch.
fn apart(campaign: &Campaign, groups: &[Vec<usize>]) -> HashSet<usize> {
    let rows = &campaign.readings.rows;
    let mut apart = HashSet::new();
    for sensor in 0..campaign.bench.sensors.len() {
        let value = |k: &usize| rows.get(*k)?.observations.iter().find(|o| o.sensor == sensor).map(|o| o.value);
        let mut spreads: Vec<f64> = Vec::new();
        let mut far: Vec<(usize, f64)> = Vec::new();
        for group in groups.iter().filter(|group| group.len() >= FEWEST) {
            let values: Vec<f64> = group.iter().filter_map(value).collect();
            let Some(middle) = median(&mut values.clone()) else { continue };
            spreads.extend(median(&mut values.iter().map(|v| (v - middle).abs()).collect::<Vec<f64>>()));
            far.extend(group.iter().filter_map(|k| Some((*k, (value(k)? - middle).abs()))));
        }
        // 1.4826: the median absolute deviation of a normal distribution
        let Some(sd) = median(&mut spreads).map(|spread| 1.4826 * spread).filter(|sd| *sd > 0.0) else { continue };
        far.retain(|(_, distance)| *distance > APART * sd);
        if (far.len() as f64) <= MOST_APART * rows.len() as f64 {
            apart.extend(far.into_iter().map(|(k, _)| k));
        }
    }
    apart
}

/// The mean of readings that share a key.
fn mean(members: &[&Reading]) -> Option<Reading> {
    let first = *members.first()?;
    if members.len() == 1 {
        return Some(first.clone());
    }
    let count = members.len() as f64;
    let column = |k: usize| {
        let values: Vec<f64> = members.iter().filter_map(|row| row.columns.get(k).copied().flatten()).collect();
        let same = values.iter().all(|v| Some(v) == values.first());
        // a value that all share stays as it is, to the last bit
        if same { values.first().copied() } else { Some(values.iter().sum::<f64>() / count) }
    };
    let observation = |place: usize| {
        let read: Vec<Observation> = members.iter().filter_map(|row| row.observations.get(place).copied()).collect();
        let sensor = read.first()?.sensor;
        let stated = read.iter().all(|o| o.u.is_some());
        let weight = |o: &Observation| o.u.map_or(o.samples, |u| 1.0 / (u * u));
        let all: f64 = read.iter().map(weight).sum();
        let value = read.iter().map(|o| weight(o) / all * o.value).sum();
        let u = stated.then(|| (1.0 / all).sqrt());
        Some(Observation { sensor, value, u, samples: read.iter().map(|o| o.samples).sum() })
    };
    Some(Reading {
        position: first.position.clone(),
        joints: first.joints.clone(),
        columns: (0..first.columns.len()).map(column).collect(),
        observations: (0..first.observations.len()).map(observation).collect::<Option<_>>()?,
        remarks: first.remarks.clone(),
        place: first.place.clone(),
        samples: members.iter().map(|row| row.samples).sum(),
        planned_u: Shared::default(),
    })
}
