//! Which mistake at the bench explains a reading that does not agree with the others.
//!
//! Each hypothesis is the density of the readings under it, over that of the readings as they were asked for: the model at the mistaken setting, or
//! with a further unknown, each about its own most probable point. Every kind of mistake has the same odds beforehand, which its members (settings, readings, tilts, effects) share. Sizes
//! that nobody knows (of a slip, of a bad value) have the same odds in every decade.

use super::advice::{Explanation, Mistake, MistakeKind};
use super::evidence::{Judge, Rows, Solved, Source, Step, same_state};
use super::seen::Seen;
use crate::campaign::{Campaign, JointState, Reading};
use crate::elements::Parts;
use crate::error::Result;
use crate::number::log_sum;

/// Decades of the size of a slip, in radians: from an arcsecond to six degrees.
const SLIPS_RAD: [f64; 5] = [1e-5, 1e-4, 1e-3, 1e-2, 1e-1];
/// Decades of a bad value, in standard deviations.
const BAD: [f64; 5] = [1e1, 1e2, 1e3, 1e4, 1e5];
/// What has this probability is named, and the explanations that are listed have it together.
const NAMED: f64 = 0.95;
/// Readings before the one that does not agree that may be the mistaken ones themselves: it bounds the work (each is solved without), and is more than
/// the unknowns of a table with one sensor, after which a mistake shows.
pub(super) const BACK: usize = 12;

/// The mistakes that could explain the readings; `newest` is the one that does not agree.
///
/// Until all are weighed, the `probability` of an explanation is the logarithm of the density of the readings, then over that of the readings as asked for.
pub(super) fn mistake(
    judge: Judge,
    taken: &[Reading],
    candidates: &[Reading],
    newest: usize,
    seen: Option<&Seen>,
) -> Result<Mistake> {
    let mut all: Vec<Explanation> = Vec::new();
    let as_asked = judge.solved(taken)?.map_or(f64::NEG_INFINITY, |solved| solved.posterior.log_density);
    for j in newest.saturating_sub(BACK)..=newest {
        of_reading(judge, taken, candidates, j, &mut all)?;
        slips(judge, taken, j, &mut all)?;
    }
    all.iter_mut().for_each(|explanation| explanation.probability -= as_asked);
    let (kind, reading) = (MistakeKind::MissingEffect, newest + 1);
    let effects = seen.into_iter().flat_map(Seen::explanations);
    all.extend(effects.map(|(what, probability)| Explanation { kind, reading, what, probability, joints: None }));
    Ok(weighed(all, newest))
}

/// Another setting, exchanged sensors, a bad value.
fn of_reading(
    judge: Judge,
    taken: &[Reading],
    candidates: &[Reading],
    j: usize,
    all: &mut Vec<Explanation>,
) -> Result<()> {
    let campaign = judge.model;
    let Some(suspect) = taken.get(j) else { return Ok(()) };
    let with = |reading: Reading| -> Vec<Reading> {
        taken.iter().enumerate().map(|(k, other)| if k == j { reading.clone() } else { other.clone() }).collect()
    };
    let others: Vec<Reading> = taken.iter().enumerate().filter(|(k, _)| *k != j).map(|(_, r)| r.clone()).collect();
    let Some(solved) = judge.solved(&others)? else { return Ok(()) };
    let point = solved.point;
    let rows = Rows::of(campaign, judge.beliefs, taken, &point, judge.noise)?;
    let mut push = |kind, what: String, joints: Option<Vec<JointState>>, density: Option<f64>| {
        all.extend(density.map(|probability| Explanation { kind, reading: j + 1, what, probability, joints }));
    };
    for (kind, joints) in settings(campaign, suspect, candidates) {
        let names: Vec<&str> = campaign.bench.joints().collect();
        let columns = campaign.readings.position(&names, suspect, joints.clone()).columns;
        let moved = Reading { columns, joints: joints.clone().into(), ..suspect.clone() };
        // a setting at which the model lacks a column (of an angle, where the joint turns) cannot be weighed
        let density = judge.log_density(&with(moved), &point).unwrap_or(None);
        push(kind, setting(campaign, &joints), Some(joints), density);
    }
    for (a, first) in suspect.observations.iter().enumerate() {
        for (b, second) in suspect.observations.iter().enumerate().skip(a + 1) {
            let sensors = (campaign.bench.sensors.get(first.sensor), campaign.bench.sensors.get(second.sensor));
            let (Some(one), Some(other)) = sensors else { continue };
            if one.unit != other.unit {
                continue;
            }
            let mut exchanged = suspect.clone();
            exchanged.observations.iter_mut().skip(a).take(1).for_each(|slot| slot.value = second.value);
            exchanged.observations.iter_mut().skip(b).take(1).for_each(|slot| slot.value = first.value);
            let density = judge.log_density(&with(exchanged), &point)?;
            push(MistakeKind::ExchangedSensors, format!("{} and {}", one.id, other.id), None, density);
        }
    }
    // an offset of any size: of one value, and of each of them
    let rows_of_reading: Vec<usize> =
        (0..rows.sd.len()).filter(|i| rows.design.rows.get(*i).is_some_and(|o| o.reading == j)).collect();
    let bad = |values: &[usize]| {
        let density = |size: f64| {
            let one = |i: &usize| {
                let of = |(k, sd): (usize, &f64)| if k == *i { size * sd } else { 0.0 };
                rows.white(rows.sd.iter().enumerate().map(of).collect())
            };
            let columns: Vec<Vec<f64>> = values.iter().map(one).collect();
            rows.told(judge.beliefs, &point, &columns).map(|posterior| posterior.log_density)
        };
        mean_over(BAD, density)
    };
    let sensor =
        |i: &usize| campaign.bench.sensors.get(rows.design.rows.get(*i)?.sensor).map(|sensor| sensor.id.as_str());
    let named = |values: &[usize]| values.iter().filter_map(sensor).collect::<Vec<_>>().join(", ");
    let each = rows_of_reading.chunks(1).chain((rows_of_reading.len() > 1).then_some(rows_of_reading.as_slice()));
    each.for_each(|values| push(MistakeKind::BadReading, named(values), None, bad(values)));
    Ok(())
}

/// A step of one tilt from this reading on.
fn slips(judge: Judge, taken: &[Reading], j: usize, all: &mut Vec<Explanation>) -> Result<()> {
    let before = taken.part(..j);
    if before.is_empty() {
        return Ok(());
    }
    let Some(start) = judge.solved(before)? else { return Ok(()) };
    let largest = SLIPS_RAD.into_iter().fold(0.0, f64::max);
    for tilt in judge.model.bench.tilts() {
        let Some(parameter) = judge.model.parameter_index(tilt) else { continue };
        let of = |size: f64| Step { parameter, from: j, size };
        // a value near its extreme in a tilt follows it in no first derivative: the size is solved for with exact rotations
        let Some(solved) = Solved::new(judge, taken, &start.point, Some(of(largest)))? else { continue };
        if let Some(probability) = mean_over(SLIPS_RAD, |size| solved.log_density_with(judge.beliefs, of(size))) {
            let (kind, what) = (MistakeKind::SlippedMounting, tilt.to_string());
            all.push(Explanation { kind, reading: j + 1, what, probability, joints: None });
        }
    }
    Ok(())
}

/// The logarithm of the mean of densities over sizes of equal odds.
fn mean_over<const N: usize>(sizes: [f64; N], density: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    let values: Vec<f64> = sizes.into_iter().filter_map(density).collect();
    (!values.is_empty()).then(|| log_sum(&values) - (N as f64).ln())
}

/// The settings that a person could have made instead, each once.
fn settings(campaign: &Campaign, reading: &Reading, candidates: &[Reading]) -> Vec<(MistakeKind, Vec<JointState>)> {
    let names: Vec<&str> = campaign.bench.joints().collect();
    let mut settings: Vec<(MistakeKind, Vec<JointState>)> = Vec::new();
    let mut push = |kind, joints: Vec<JointState>| {
        let alike = |other: &[JointState]| other.iter().zip(&joints).all(|(a, b)| same_state(a, b));
        let possible = Reading::check_turning(&joints, &names).is_ok();
        if possible && !alike(&reading.joints) && !settings.iter().any(|(_, other)| alike(other)) {
            settings.push((kind, joints));
        }
    };
    let with = |k: usize, state: JointState| {
        reading.joints.iter().enumerate().map(|(i, s)| if i == k { state } else { *s }).collect::<Vec<_>>()
    };
    for (k, state) in reading.joints.iter().enumerate() {
        if state.rate_deg_s() != 0.0 {
            push(MistakeKind::WrongSense, with(k, state.reversed()));
        }
        if let JointState::Held { angle_deg } = state {
            push(MistakeKind::Turned, with(k, JointState::Held { angle_deg: (angle_deg + 180.0).rem_euclid(360.0) }));
        }
    }
    for a in 0..reading.joints.len() {
        for b in a + 1..reading.joints.len() {
            let mut joints = reading.joints.to_vec();
            joints.swap(a, b);
            push(MistakeKind::ExchangedAxes, joints);
        }
    }
    for candidate in candidates {
        // another face, turned as asked
        let joints = reading.joints.iter().zip(&candidate.joints).map(|(state, other)| match (state, other) {
            (JointState::Held { .. }, JointState::Held { .. }) => *other,
            _ => *state,
        });
        push(MistakeKind::OtherPosition, joints.collect());
    }
    settings
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

fn weighed(mut explanations: Vec<Explanation>, newest: usize) -> Mistake {
    let count = |kind: MistakeKind| explanations.iter().filter(|e| e.kind == kind).count().max(1) as f64;
    let shares: Vec<f64> = explanations.iter().map(|e| count(e.kind).ln()).collect();
    explanations.iter_mut().zip(shares).for_each(|(e, share)| e.probability -= share);
    // and that it is chance
    let total = log_sum(&explanations.iter().map(|e| e.probability).chain([0.0]).collect::<Vec<f64>>());
    explanations.iter_mut().for_each(|e| e.probability = (e.probability - total).exp());
    explanations.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    let of = |is: &dyn Fn(&Explanation) -> bool| {
        explanations.iter().filter(|e| is(e)).map(|e| e.probability).sum::<f64>() >= NAMED
    };
    let first = explanations.first();
    let named = first.map(|e| e.kind).filter(|kind| of(&|e| e.kind == *kind));
    let at = first.map(|e| e.reading).filter(|reading| of(&|e| e.reading == *reading));
    let mut together = 0.0;
    explanations.retain(|explanation| {
        let wanted = together < NAMED;
        together += explanation.probability;
        wanted
    });
    Mistake { reading: newest + 1, named, at, chance: (-total).exp(), explanations }
}

/// A reading against what the others predict.
pub(super) struct Agreement {
    /// What the reading adds to the least sum of squares.
    pub square: f64,
    /// Values of it that the others predict, or what is supposed of the tilts.
    pub predicted: usize,
    /// Those that the others alone predict.
    pub told: usize,
    /// Is the value that is furthest off below what was predicted?
    pub is_below: bool,
}

/// Does a reading agree with the others? `None` where nothing can be said.
pub(super) fn agreement(judge: Judge, others: &[Reading], newest: &Reading) -> Result<Option<Agreement>> {
    let Some(before) = judge.solved(others)? else { return Ok(None) };
    let all: Vec<Reading> = others.iter().chain([newest]).cloned().collect();
    let Some(after) = Solved::new(judge, &all, &before.point, None)? else { return Ok(None) };
    let rows = Rows::of(judge.model, judge.beliefs, std::slice::from_ref(newest), &before.point, judge.noise)?;
    let without = |sources: &[Source]| {
        let is_predicted = |row: &&Vec<f64>| {
            let (variance, open) = before.posterior.variance_from(judge.beliefs, row, sources);
            open < 0.5 * (1.0 + variance)
        };
        rows.slopes.iter().filter(is_predicted).count()
    };
    let (predicted, told) = (without(&[Source::Nothing]), without(&[Source::Nothing, Source::Supposed]));
    // what is left when all readings have their say has the sign of what the others alone predict, also where slopes at their point do not reach so far
    let mut left: Vec<f64> = after
        .rows
        .design
        .rows
        .iter()
        .zip(&after.rows.residual)
        .zip(&after.rows.sd)
        .filter_map(|((origin, residual), sd)| (origin.reading == others.len()).then_some(residual / sd))
        .collect();
    left.sort_by(|a, b| b.abs().total_cmp(&a.abs()));
    let is_below = left.first().is_some_and(|residual| *residual < 0.0);
    Ok(Some(Agreement { square: after.posterior.target - before.posterior.target, predicted, told, is_below }))
}
