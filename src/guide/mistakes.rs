//! Which mistake at the bench explains a reading that does not agree with the others.
//!
//! Each hypothesis is the model evaluated at the mistaken setting: its weight is the density of the readings under it, over that of the readings as they
//! were asked for. Every kind of mistake has the same odds beforehand, which its members (settings, readings, tilts, effects) share. Sizes that
//! nobody knows (of a slip, of a bad value) have the same odds in every decade.

use super::advice::{Explanation, Mistake, MistakeKind};
use super::evidence::{Predicted, predicted};
use super::seen::Seen;
use crate::campaign::{Campaign, JointState, Reading};
use crate::elements::Parts;
use crate::error::Result;
use crate::plan::Noise;

/// Decades of the size of a slip, in radians: from an arcsecond to six degrees.
const SLIPS_RAD: [f64; 5] = [1e-5, 1e-4, 1e-3, 1e-2, 1e-1];
/// Decades of a bad value, in standard deviations.
const BAD: [f64; 5] = [1e1, 1e2, 1e3, 1e4, 1e5];
/// Explanations that are shown have at least this probability.
const SHOWN: f64 = 0.01;
/// An explanation this probable is named.
pub(super) const NAMED: f64 = 0.95;
/// Settings whose probabilities differ by less than this factor are not told apart.
const ALIKE: f64 = 20.0;
/// Readings before the one that does not agree that may be the mistaken ones themselves.
pub(super) const BACK: usize = 12;

struct Hypothesis {
    kind: MistakeKind,
    reading: usize,
    what: String,
    joints: Option<Vec<JointState>>,
    /// Logarithm of the density over that of the readings as asked for.
    weight: f64,
}

/// The mistakes that could explain the readings; `newest` is the one that does not agree.
pub(super) fn mistake(
    campaign: &Campaign,
    taken: &[Reading],
    candidates: &[Reading],
    newest: usize,
    noise: &Noise,
    seen: Option<&Seen>,
) -> Result<Mistake> {
    let mut all: Vec<Hypothesis> = Vec::new();
    for j in newest.saturating_sub(BACK)..=newest {
        of_reading(campaign, taken, candidates, j, noise, &mut all)?;
    }
    if let Some(seen) = seen {
        all.extend(seen.explanations().into_iter().map(|(what, weight)| Hypothesis {
            kind: MistakeKind::MissingEffect,
            reading: newest,
            what,
            joints: None,
            weight,
        }));
    }
    Ok(weighed(all, newest))
}

fn of_reading(
    campaign: &Campaign,
    taken: &[Reading],
    candidates: &[Reading],
    j: usize,
    noise: &Noise,
    all: &mut Vec<Hypothesis>,
) -> Result<()> {
    let Some(own) = taken.get(j) else { return Ok(()) };
    let others: Vec<Reading> = taken.iter().enumerate().filter(|(k, _)| *k != j).map(|(_, r)| r.clone()).collect();
    let point = super::point_of(campaign, &others);
    let at = |reading: Reading| -> Result<Option<f64>> {
        let found = predicted(campaign, &others, &[reading], &point, noise)?;
        Ok(found.and_then(|(own, _)| own.log_density(|_, _| 0.0)))
    };
    let Some((clean, _)) = predicted(campaign, &others, std::slice::from_ref(own), &point, noise)? else {
        return Ok(());
    };
    let Some(as_asked) = clean.log_density(|_, _| 0.0) else { return Ok(()) };
    let mut push = |kind, what: String, joints: Option<Vec<JointState>>, weight: Option<f64>| {
        if let Some(weight) = weight {
            all.push(Hypothesis { kind, reading: j, what, joints, weight: weight - as_asked });
        }
    };
    for (kind, joints) in settings(campaign, own, candidates) {
        let names: Vec<&str> = campaign.bench.joints().collect();
        let moved = Reading {
            columns: campaign.readings.position(&names, own, joints.clone()).columns,
            joints: joints.clone(),
            ..own.clone()
        };
        let weight = at(moved)?;
        push(kind, setting(campaign, &joints), Some(joints), weight);
    }
    for (a, first) in own.observations.iter().enumerate() {
        for (b, second) in own.observations.iter().enumerate().skip(a + 1) {
            let (Some(one), Some(other)) =
                (campaign.bench.sensors.get(first.sensor), campaign.bench.sensors.get(second.sensor))
            else {
                continue;
            };
            if one.unit != other.unit {
                continue;
            }
            let mut exchanged = own.clone();
            let values = [second.value, first.value];
            exchanged.observations.iter_mut().skip(a).take(1).for_each(|slot| slot.value = values[0]);
            exchanged.observations.iter_mut().skip(b).take(1).for_each(|slot| slot.value = values[1]);
            let weight = at(exchanged)?;
            push(MistakeKind::ExchangedSensors, format!("{} and {}", one.id, other.id), None, weight);
        }
    }
    // an offset of this reading alone, of any size
    push(
        MistakeKind::BadReading,
        format!("reading {}", j + 1),
        None,
        mean_over(BAD, |size| clean.log_density(|a, b| if a == b { size * size } else { 0.0 })),
    );
    slips(campaign, taken, j, noise, all)
}

/// A step of one tilt from this reading on.
fn slips(campaign: &Campaign, taken: &[Reading], j: usize, noise: &Noise, all: &mut Vec<Hypothesis>) -> Result<()> {
    let (before, after) = (taken.part(..j), taken.part(j..));
    if before.is_empty() {
        return Ok(());
    }
    let point = super::point_of(campaign, before);
    let Some((own, rows)) = predicted(campaign, before, after, &point, noise)? else { return Ok(()) };
    let Some(as_asked) = own.log_density(|_, _| 0.0) else { return Ok(()) };
    let first = rows.origins.iter().take_while(|origin| origin.reading < j).count();
    for tilt in campaign.bench.tilts() {
        let Some(k) = campaign.parameter_index(tilt) else { continue };
        let column =
            (0..rows.origins.len()).map(|i| if i < first { 0.0 } else { rows.design.jacobian[(i, k)] }).collect();
        let felt = rows.white(column);
        let felt = felt.part(first..);
        if felt.iter().all(|value| *value == 0.0) {
            continue;
        }
        let density = |size: f64| own.log_density(|a, b| size * size * product(felt, a, b));
        if let Some(weight) = mean_over(SLIPS_RAD, density) {
            all.push(Hypothesis {
                kind: MistakeKind::SlippedMounting,
                reading: j,
                what: tilt.to_string(),
                joints: None,
                weight: weight - as_asked,
            });
        }
    }
    Ok(())
}

fn product(column: &[f64], a: usize, b: usize) -> f64 {
    column.get(a).zip(column.get(b)).map_or(0.0, |(a, b)| a * b)
}

/// The logarithm of the mean of densities over sizes of equal odds.
fn mean_over<const N: usize>(sizes: [f64; N], density: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    let own: Vec<f64> = sizes.into_iter().filter_map(density).collect();
    (!own.is_empty()).then(|| log_sum(own.iter().copied()) - (N as f64).ln())
}

fn log_sum(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let most = values.clone().fold(f64::NEG_INFINITY, f64::max);
    if most == f64::NEG_INFINITY { most } else { most + values.map(|v| (v - most).exp()).sum::<f64>().ln() }
}

/// The settings that a person could have made instead, each once.
fn settings(campaign: &Campaign, own: &Reading, candidates: &[Reading]) -> Vec<(MistakeKind, Vec<JointState>)> {
    let names: Vec<&str> = campaign.bench.joints().collect();
    let mut found: Vec<(MistakeKind, Vec<JointState>)> = Vec::new();
    let mut push = |kind, joints: Vec<JointState>| {
        let alike = |other: &[JointState]| other.iter().zip(&joints).all(|(a, b)| same_state(a, b));
        let possible = Reading { joints: joints.clone(), ..own.clone() }.check_turning(&names).is_ok();
        if possible && !alike(&own.joints) && !found.iter().any(|(_, other)| alike(other)) {
            found.push((kind, joints));
        }
    };
    let with = |k: usize, state: JointState| {
        own.joints.iter().enumerate().map(|(i, s)| if i == k { state } else { *s }).collect::<Vec<_>>()
    };
    for (k, state) in own.joints.iter().enumerate() {
        if state.rate_deg_s() != 0.0 {
            push(MistakeKind::WrongSense, with(k, state.reversed()));
        }
        if let JointState::Held { angle_deg } = state {
            push(MistakeKind::Turned, with(k, JointState::Held { angle_deg: (angle_deg + 180.0).rem_euclid(360.0) }));
        }
    }
    for a in 0..own.joints.len() {
        for b in a + 1..own.joints.len() {
            let mut joints = own.joints.clone();
            joints.swap(a, b);
            push(MistakeKind::ExchangedAxes, joints);
        }
    }
    for candidate in candidates {
        // another face, turned as asked
        let joints = own.joints.iter().zip(&candidate.joints).map(|(state, other)| match (state, other) {
            (JointState::Held { .. }, JointState::Held { .. }) => *other,
            _ => *state,
        });
        push(MistakeKind::OtherPosition, joints.collect());
    }
    found
}

/// The same setting, whole turns apart or not.
pub(super) fn same_state(a: &JointState, b: &JointState) -> bool {
    match (a, b) {
        (JointState::Held { angle_deg: a }, JointState::Held { angle_deg: b }) => {
            let apart = (a - b).rem_euclid(360.0);
            apart.min(360.0 - apart) < 1e-9
        }
        _ => a == b,
    }
}

/// A setting as a person reads it: `alpha 90 deg, gamma 20 deg/s`.
pub(crate) fn setting(campaign: &Campaign, joints: &[JointState]) -> String {
    let one = |(name, state): (&str, &JointState)| match state.keys() {
        (Some(deg), None, _) => format!("{name} {deg} deg"),
        (None, Some(rate), _) => format!("{name} {rate} deg/s"),
        (Some(deg), Some(rate), None) => format!("{name} {rate} deg/s through {deg} deg"),
        (Some(deg), Some(rate), Some(turns)) => format!("{name} {turns} turns from {deg} deg at {rate} deg/s"),
        (None, None, _) => name.to_string(),
    };
    campaign.bench.joints().zip(joints).map(one).collect::<Vec<_>>().join(", ")
}

fn weighed(mut all: Vec<Hypothesis>, newest: usize) -> Mistake {
    let count = |kind: MistakeKind| all.iter().filter(|own| own.kind == kind).count().max(1) as f64;
    let shares: Vec<f64> = all.iter().map(|own| count(own.kind).ln()).collect();
    all.iter_mut().zip(shares).for_each(|(own, share)| own.weight -= share);
    // and that it is chance
    let total = log_sum(all.iter().map(|own| own.weight).chain([0.0]));
    let mut explanations: Vec<Explanation> = all
        .into_iter()
        .map(|own| Explanation {
            kind: own.kind,
            reading: own.reading + 1,
            what: own.what,
            probability: (own.weight - total).exp(),
            joints: own.joints,
        })
        .collect();
    explanations.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    let of = |kind: MistakeKind, reading: usize| {
        let same = explanations.iter().filter(|own| own.kind == kind && own.reading == reading);
        same.map(|own| own.probability).sum::<f64>()
    };
    let first = explanations.first();
    let named = first.map(|own| (own.kind, own.reading)).filter(|(kind, reading)| of(*kind, *reading) >= NAMED);
    let kind = named.map(|(kind, _)| kind);
    let least = first.map_or(SHOWN, |own| (own.probability / ALIKE).min(SHOWN));
    let alike = |own: &&Explanation| first.is_some_and(|first| own.probability * ALIKE > first.probability);
    let cannot_be_told = explanations.iter().filter(alike).count() > 1;
    explanations.retain(|own| own.probability >= least);
    explanations.truncate(MOST_SHOWN);
    Mistake { reading: newest + 1, named: kind, at: named.map(|(_, reading)| reading), cannot_be_told, explanations }
}

/// Explanations that are shown at most.
const MOST_SHOWN: usize = 8;

/// Does a reading agree with those that predict it: the statistic, its degrees of freedom, the largest difference in standard deviations.
pub(super) fn agreement(own: &Predicted) -> Option<(f64, usize, f64)> {
    let told = own.told();
    let count = told.difference.len();
    let square = told.square().filter(|_| count > 0)?;
    let largest = told
        .difference
        .iter()
        .enumerate()
        .map(|(i, d)| d / told.covariance.get(i).and_then(|row| row.get(i)).map_or(f64::NAN, |v| v.sqrt()))
        .fold(0.0_f64, |most, own| if own.abs() > most.abs() { own } else { most });
    Some((square, count, largest))
}
