//! From chosen portions to a schedule: labels, order, and the criterion once more.
//!
//! Why each mounting is in a schedule.
//!
//! Angles between the candidates: chosen mountings are moved joint by joint, in halved steps, as long as the criterion improves.
//!
//! A mounting moves with all its readings, a joint within the range that the candidates have (all round where they go round), and never into a
//! forbidden zone. Steps start at half of the sweep's and end at the resolution, of which they are whole multiples.

use super::candidates::{Zone, is_forbidden};
use super::effort::{Noise, Offer, mounting, planned};
use super::objective::Objective;
use super::order::ordered;
use super::pool::{Pool, log_det_of};
use super::problem::{Design, WORTH};
use super::request::Request;
use super::whitened::adjusted_alone;
use crate::campaign::{Campaign, JointState, Label, Reading, Readings};
use crate::elements::Elements;
use crate::error::Result;
use crate::estimate::Estimate;
use crate::number;

/// Rows of a schedule (kept, then chosen) in the order to run.
pub(super) fn scheduled(
    campaign: &Campaign,
    kept: &Readings,
    rows: Vec<Reading>,
    offer: &Offer,
    request: &Request,
) -> Result<Campaign> {
    let Offer { noise, costs, .. } = offer;
    let all = planned(campaign, &Readings { columns: kept.columns.clone(), rows });
    let run = ordered(&campaign.with_readings(all), noise, costs, request.order, request.seed, kept.rows.len())?;
    Ok(campaign.with_readings(relabelled(kept, run)))
}

/// Kept readings and chosen ones. New mountings are numbered on from the kept labels; where remounting scatters, a repeat is a new mounting.
pub(super) fn schedule_rows(kept: &Readings, pool: &Pool, chosen: &[usize], repeats_remount: bool) -> Vec<Reading> {
    let mut rows: Vec<Reading> = kept.rows.clone();
    let mut next = next_label(kept);
    let mut labels: Vec<((Vec<Option<f64>>, &str), String)> = Vec::new();
    for (portion, level) in chosen.iter().filter_map(|j| pool.portions.get(*j).zip(pool.levels.get(*j))) {
        // portions have readings
        let place = (portion.first().map(mounting).unwrap_or_default(), level.as_str());
        let known =
            labels.iter().find(|(other, _)| !repeats_remount && *other == place).map(|(_, label)| label.clone());
        let label = known.unwrap_or_else(|| {
            let label = next.to_string();
            next += 1;
            labels.push((place, label.clone()));
            label
        });
        rows.extend(portion.iter().map(|r| Reading { position: label.as_str().into(), ..r.clone() }));
    }
    rows
}

/// The number after the largest numeric label. (One of more than 32 bits is a serial number, and none that is counted on from.)
fn next_label(readings: &Readings) -> u64 {
    1 + u64::from(readings.rows.iter().filter_map(|r| r.position.parse::<u32>().ok()).max().unwrap_or(0))
}

/// New mountings numbered in the order in which they are run; labels that were kept stay.
fn relabelled(kept: &Readings, mut run: Readings) -> Readings {
    let old: Vec<&str> = kept.rows.iter().map(|r| r.position.as_str()).collect();
    let mut next = next_label(kept);
    let mut names: std::collections::HashMap<Label, Label> = std::collections::HashMap::new();
    for reading in run.rows.iter_mut().filter(|r| !old.contains(&r.position.as_str())) {
        let label = names.entry(reading.position.clone()).or_insert_with(|| {
            next += 1;
            (next - 1).to_string().into()
        });
        reading.position = label.clone();
    }
    run
}

/// The criterion from a fresh QR of the final schedule, against the value that the exchange ended with.
pub(super) fn check(
    schedule: &Campaign,
    noise: &Noise,
    pool: &Pool,
    objective: &Objective,
    design: &Design,
) -> Result<Option<f64>> {
    let n = schedule.unknowns() as f64;
    Ok(criterion_of(schedule, noise, pool, objective)?.map(|value| match objective {
        // per unknown, as a relative change of the determinant
        Objective::Determinant => (value - design.value).abs() / n,
        _ => (value / design.value - 1.0).abs(),
    }))
}

/// The criterion of a schedule from a fresh QR; `None` where it does not determine the unknowns that the pool does.
pub(super) fn criterion_of(
    schedule: &Campaign,
    noise: &Noise,
    pool: &Pool,
    objective: &Objective,
) -> Result<Option<f64>> {
    let n = schedule.unknowns();
    let (fresh, deviations) = adjusted_alone(schedule, &schedule.readings, noise)?;
    // deviations are always determined, and the schedule may have fewer of them than the pool
    let rank = fresh.unknowns.rank.saturating_sub(deviations);
    let basis = pool.estimate.factor.basis();
    if rank != pool.determined() || fresh.factor.basis().iter().any(|j| *j < n && !basis.contains(j)) {
        return Ok(None);
    }
    Ok(match objective {
        Objective::Determinant => Some(log_det_of(&pool.estimate) - log_det_of(&fresh)),
        _ if rank < n => None,
        _ => objective.of(&in_coordinates(pool, &fresh, n)),
    })
}

/// Covariance of `z = R D x`, the pool's coordinates, row by row, from that of the first `parameters` of `x`: the others are zero.
fn in_coordinates(pool: &Pool, fresh: &Estimate, parameters: usize) -> Vec<f64> {
    let factor = &pool.estimate.factor;
    let (basis, r, scale) = (factor.basis(), factor.r(), factor.scale());
    let n = basis.len();
    let t = |i: usize, k: usize| r[(i, k)] * scale.at(basis.at(k));
    let c = |k: usize, l: usize| match (basis.get(k), basis.get(l)) {
        (Some(a), Some(b)) if *a < parameters && *b < parameters => fresh.unknowns.covariance[(*a, *b)],
        _ => 0.0,
    };
    let half: Vec<Vec<f64>> =
        (0..n).map(|i| (0..n).map(|l| (i..n).map(|k| t(i, k) * c(k, l)).sum()).collect()).collect();
    half.iter()
        .flat_map(|row| {
            (0..n).map(move |j| row.iter().enumerate().skip(j).map(|(l, half)| half * t(j, l)).sum::<f64>())
        })
        .collect()
}

/// What would be lost without one mounting.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "ReasonReport")]
#[non_exhaustive]
pub struct Reason {
    /// Label of the mounting.
    pub position: String,
    /// The parameter that would lose most.
    pub parameter: String,
    /// By what factor its uncertainty would grow; null where nothing would determine it.
    pub grows: Option<f64>,
}

/// With more mountings or readings than this, reasons are not looked for.
const MOST_REASONS: usize = 100;
const MOST_READINGS: usize = 2000;

/// Every mounting after the first `kept` readings, left out in turn.
pub(super) fn reasons(schedule: &Campaign, noise: &Noise, kept: usize) -> Result<Vec<Reason>> {
    let rows = &schedule.readings.rows;
    let mut labels: Vec<&str> = Vec::new();
    for row in rows.iter().skip(kept) {
        if !labels.contains(&row.position.as_str()) {
            labels.push(&row.position);
        }
    }
    if labels.len() > MOST_REASONS || rows.len() > MOST_READINGS {
        return Ok(Vec::new());
    }
    let n = schedule.unknowns();
    let u = |readings: &Readings| -> Result<Vec<Option<f64>>> {
        let (estimate, _) = adjusted_alone(schedule, readings, noise)?;
        let known = |k: usize| estimate.unknowns.is_estimable(k);
        Ok((0..n).map(|k| known(k).then(|| estimate.unknowns.covariance[(k, k)].sqrt())).collect())
    };
    let with = u(&schedule.readings)?;
    let mut reasons = Vec::with_capacity(labels.len());
    for label in labels {
        let remaining =
            rows.iter().enumerate().filter(|(k, row)| *k < kept || row.position != label).map(|(_, row)| row.clone());
        let remaining = Readings { columns: schedule.readings.columns.clone(), rows: remaining.collect() };
        let without = if remaining.rows.is_empty() { vec![None; n] } else { u(&remaining)? };
        let growth = |k: usize| match (with.get(k).copied().flatten(), without.get(k).copied().flatten()) {
            (Some(with), Some(without)) if with > 0.0 => without / with,
            (Some(_), None) => f64::INFINITY,
            _ => 1.0,
        };
        let most = (0..n).max_by(|a, b| growth(*a).total_cmp(&growth(*b)).then(b.cmp(a)));
        if let Some(parameter) = most {
            let grows = Some(growth(parameter)).filter(|g| g.is_finite());
            let parameter = schedule.parameter_id(parameter).to_string();
            reasons.push(Reason { position: label.to_string(), parameter, grows });
        }
    }
    Ok(reasons)
}

/// Angles moved between the candidates.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "RefinedReport")]
#[non_exhaustive]
pub struct Refined {
    /// Angles were moved in multiples of this, in degrees.
    pub resolution_deg: f64,
    /// Mountings with an angle that no candidate has.
    pub moved: usize,
    /// By what share the criterion is better: the determinant for each unknown (D), a variance (else).
    pub gain: f64,
    /// The criterion there: `-log det M` (D), a variance, or with a goal the largest `(u / limit)^2`.
    #[serde(skip)]
    pub value: f64,
    /// Did it end because no move was worth it? Else because of the effort.
    pub finished: bool,
}

/// Rows that are evaluated at most: some seconds.
const EFFORT: usize = 4_000_000;

/// A joint that may move: its place in the chain, the range (degrees; `None` all round) and the step of the candidates.
struct Freedom {
    joint: usize,
    range: Option<(f64, f64)>,
    step: f64,
}

/// The rows of a schedule after those that are kept with their angles moved; `None` without such a request, or where the criterion cannot be compared.
/// A value of `enough` ends the search.
///
/// Errors: those of the model at the moved angles.
pub(super) fn refined(
    campaign: &Campaign,
    rows: &[Reading],
    (pool, objective): (&Pool, &Objective),
    offer: &Offer,
    request: &Request,
    enough: Option<f64>,
) -> Result<Option<(Vec<Reading>, Refined)>> {
    let Some(wanted) = &request.refine else { return Ok(None) };
    let (fixed, noise, progress) = (offer.kept.rows.len(), &offer.noise, &request.progress);
    let resolution = wanted.resolution_deg;
    let columns = &campaign.readings.columns;
    let names: Vec<&str> = campaign.bench.joints().collect();
    let value_of = |rows: &[Reading]| {
        let all = planned(campaign, &Readings { columns: columns.clone(), rows: rows.to_vec() });
        criterion_of(&campaign.with_readings(all), noise, pool, objective)
    };
    let Some(start) = value_of(rows)? else { return Ok(None) };
    // mountings, in the order of the rows
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (i, row) in rows.iter().enumerate().skip(fixed) {
        let same = |group: &&mut Vec<usize>| {
            let first = group.first().and_then(|k| rows.get(*k));
            first.is_some_and(|f| f.position == row.position && mounting(f) == mounting(row))
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.push(i),
            None => groups.push(vec![i]),
        }
    }
    let freedoms = freedoms(pool, names.len());
    let (mut rows, mut now) = (rows.to_vec(), start);
    let given: Vec<Vec<Option<f64>>> = rows.iter().map(mounting).collect();
    let (mut effort, mut finished) = (0, true);
    let widest = freedoms.iter().map(|f| f.step).fold(0.0, f64::max);
    let mut share = 0.5;
    'levels: while widest * share >= 0.5 * resolution {
        // both senses until nothing moves at this step
        loop {
            let mut improved = false;
            for group in &groups {
                for freedom in &freedoms {
                    let step = ((freedom.step * share / resolution).round() * resolution).max(resolution);
                    for way in [step, -step] {
                        if effort > EFFORT {
                            finished = false;
                            break 'levels;
                        }
                        let Some(moved) = moved(campaign, &names, &rows, group, freedom, way, &wanted.zones) else {
                            continue;
                        };
                        effort += rows.len();
                        if let Some(value) = value_of(&moved)?
                            && value < now - WORTH * now.abs().max(1.0)
                        {
                            (rows, now, improved) = (moved, value, true);
                            if enough.is_some_and(|enough| now <= enough) {
                                break 'levels;
                            }
                            break;
                        }
                    }
                }
            }
            if !improved {
                break;
            }
        }
        share /= 2.0;
        progress.tell("degrees of resolution", 0, number::count((widest * share).ceil()));
    }
    let n = pool.blocks.unknowns().max(1) as f64;
    let gain = match objective {
        Objective::Determinant => ((start - now) / n).exp_m1(),
        _ => start / now - 1.0,
    };
    let changed = |group: &&Vec<usize>| {
        // groups have members
        let first = group.first().copied().unwrap_or_default();
        rows.get(first).map(mounting) != given.get(first).cloned()
    };
    let moved = groups.iter().filter(changed).count();
    Ok(Some((rows, Refined { resolution_deg: resolution, moved, gain, value: now, finished })))
}

/// Joints that are held at several angles in the candidates.
fn freedoms(pool: &Pool, joints: usize) -> Vec<Freedom> {
    let angles = |joint: usize| {
        let states = pool.portions.iter().flatten().filter_map(|reading| reading.joints.get(joint));
        let mut angles: Vec<f64> = states
            .filter_map(|state| match state {
                JointState::Held { angle_deg } => Some(*angle_deg),
                _ => None,
            })
            .collect();
        angles.sort_by(f64::total_cmp);
        angles.dedup();
        angles
    };
    (0..joints)
        .filter_map(|joint| {
            let angles = angles(joint);
            let (low, high) = (*angles.first()?, *angles.last()?);
            let steps = || angles.iter().zip(angles.iter().skip(1)).map(|(before, angle)| angle - before);
            let step = steps().fold(f64::INFINITY, f64::min);
            let widest = steps().fold(0.0, f64::max);
            if !(step.is_finite() && step > 0.0) {
                return None;
            }
            // the step from the last to the first is no wider than the others: all round
            let round = low + 360.0 - high <= widest * (1.0 + 1e-9);
            Some(Freedom { joint, range: (!round).then_some((low, high)), step })
        })
        .collect()
}

/// The rows with one joint of a mounting moved; `None` where it may not be, or turns.
fn moved(
    campaign: &Campaign,
    names: &[&str],
    rows: &[Reading],
    group: &[usize],
    freedom: &Freedom,
    way: f64,
    zones: &[Zone],
) -> Option<Vec<Reading>> {
    let mut moved = rows.to_vec();
    for k in group {
        let row = moved.get_mut(*k)?;
        let mut joints = row.joints.clone();
        let JointState::Held { angle_deg } = joints.get(freedom.joint)? else { return None };
        let angle = angle_deg + way;
        let angle = match freedom.range {
            Some((low, high)) if (low..=high).contains(&angle) => angle,
            Some(_) => return None,
            None => (angle.rem_euclid(360.0) * 1e9).round() / 1e9 % 360.0,
        };
        *joints.get_mut(freedom.joint)? = JointState::Held { angle_deg: angle };
        let there = campaign.readings.position(names, row, joints);
        if is_forbidden(names, zones, &there) {
            return None;
        }
        row.columns = there.columns;
        row.joints = there.joints;
    }
    Some(moved)
}
