//! The order in which a schedule is run: as few remountings as there are mountings, and drift spread over all parameters.

use super::effort::{Noise, mounting};
use super::judge::drift_of;
use crate::campaign::{Campaign, Reading, Readings};
use crate::error::Result;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// How readings follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Order {
    /// As they come.
    AsGiven,
    /// Senses within a mounting in the pattern + - - + - + + -, which a linear (four readings) or quadratic (eight) drift passes through;
    /// neighbouring mountings differ as little as possible.
    #[default]
    Abba,
    /// Mountings and the readings within them in random order; of 200 orders, the one that a linear drift harms least.
    Random,
}

const TRIES: usize = 200;

/// Put the readings of a schedule in order. Readings of one mounting (same label, same angles at rest) stay together.
///
/// Errors: those of [`super::judge`].
pub fn ordered(campaign: &Campaign, noise: &Noise, order: Order, seed: u64) -> Result<Readings> {
    let groups = by_mounting(&campaign.readings.rows);
    let columns = campaign.readings.columns.clone();
    match order {
        Order::AsGiven => Ok(campaign.readings.clone()),
        Order::Abba => {
            let rows = nearest(groups).into_iter().flat_map(abba).collect();
            Ok(Readings { columns, rows })
        }
        Order::Random => {
            let mut rng = Pcg64Mcg::seed_from_u64(seed);
            let mut best: Option<(f64, Readings)> = None;
            for _ in 0..TRIES {
                let mut shuffled = groups.clone();
                shuffle(&mut shuffled, &mut rng);
                shuffled.iter_mut().for_each(|group| shuffle(group, &mut rng));
                let readings = Readings { columns: columns.clone(), rows: shuffled.into_iter().flatten().collect() };
                let drift = drift_of(&campaign.with_readings(readings.clone()), noise)?.unwrap_or(0.0);
                if best.as_ref().is_none_or(|(before, _)| drift < *before) {
                    best = Some((drift, readings));
                }
            }
            Ok(best.map(|(_, readings)| readings).unwrap_or_default())
        }
    }
}

fn shuffle<T>(list: &mut [T], rng: &mut Pcg64Mcg) {
    for k in (1..list.len()).rev() {
        let j = ((u128::from(rng.next_u64()) * (k as u128 + 1)) >> 64) as usize;
        list.swap(k, j);
    }
}

fn by_mounting(readings: &[Reading]) -> Vec<Vec<Reading>> {
    let mut groups: Vec<Vec<Reading>> = Vec::new();
    for reading in readings {
        let fellow = |group: &&mut Vec<Reading>| {
            group.first().is_some_and(|f| f.position == reading.position && mounting(f) == mounting(reading))
        };
        match groups.iter_mut().find(fellow) {
            Some(group) => group.push(reading.clone()),
            None => groups.push(vec![reading.clone()]),
        }
    }
    groups
}

/// Each mounting is followed by the nearest that is left: fewest joints moved, then the smallest sum of angles.
fn nearest(mut groups: Vec<Vec<Reading>>) -> Vec<Vec<Reading>> {
    let mut sorted: Vec<Vec<Reading>> = Vec::with_capacity(groups.len());
    let way = |a: &[Reading], b: &[Reading]| {
        let (Some(a), Some(b)) = (a.first(), b.first()) else { return (0, 0.0) };
        let turn = |(a, b): (Option<f64>, Option<f64>)| match (a, b) {
            (Some(a), Some(b)) => ((a - b + 180.0).rem_euclid(360.0) - 180.0).abs(),
            _ => 0.0,
        };
        let turns: Vec<f64> = mounting(a).into_iter().zip(mounting(b)).map(turn).collect();
        (turns.iter().filter(|t| **t > 0.0).count(), turns.iter().sum::<f64>())
    };
    while !groups.is_empty() {
        let next = match sorted.last() {
            None => 0,
            Some(last) => (0..groups.len())
                .min_by(|&a, &b| {
                    let (wa, wb) = (way(last, &groups[a]), way(last, &groups[b]));
                    wa.0.cmp(&wb.0).then(wa.1.total_cmp(&wb.1))
                })
                .unwrap_or(0),
        };
        sorted.push(groups.remove(next));
    }
    sorted
}

/// Readings of one mounting, senses in the Thue-Morse pattern.
fn abba(group: Vec<Reading>) -> Vec<Reading> {
    let sense = |r: &Reading| r.joints.iter().map(|s| s.rate_deg_s()).find(|rate| *rate != 0.0).unwrap_or(0.0);
    let (mut plus, mut minus): (Vec<Reading>, Vec<Reading>) = group.into_iter().partition(|r| sense(r) >= 0.0);
    let size = |a: &Reading, b: &Reading| sense(a).abs().total_cmp(&sense(b).abs());
    plus.sort_by(size);
    minus.sort_by(size);
    let (mut plus, mut minus) = (plus.into_iter().peekable(), minus.into_iter().peekable());
    let mut rows = Vec::new();
    for k in 0_u32.. {
        let (first, second) =
            if k.count_ones().is_multiple_of(2) { (&mut plus, &mut minus) } else { (&mut minus, &mut plus) };
        match first.next().or_else(|| second.next()) {
            Some(reading) => rows.push(reading),
            None => break,
        }
    }
    rows
}
