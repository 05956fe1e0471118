//! Angles between the candidates: what was chosen is moved joint by joint, in halved steps, as long as the criterion improves.
//!
//! A mounting moves with all its readings, a joint within the range that the candidates have (all round where they go round), and never into a
//! forbidden zone. Steps start at half of the sweep's and end at the resolution, of which they are whole multiples.

use super::candidates::{Zone, is_forbidden};
use super::effort::{Noise, mounting, planned};
use super::pool::Pool;
use super::problem::{Objective, WORTH};
use super::request::Progress;
use super::request::Refinement;
use super::scheduled::criterion_of;
use crate::campaign::{Campaign, JointState, Reading, Readings};
use crate::error::Result;
use crate::number;

/// What moving the angles brought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refined {
    /// Mountings with an angle that is not the chosen candidate's.
    pub moved: usize,
    /// By what share the criterion is better than that of the choice: the determinant for each unknown (D), a variance (else).
    pub gain: f64,
    /// The criterion there: `-log det M` (D), a variance, or with a goal the largest `(u / limit)^2`.
    pub value: f64,
    /// Did it end because nothing was worth a move? Else because of the effort.
    pub finished: bool,
}

/// Rows that are weighed at most: some seconds.
const EFFORT: usize = 4_000_000;

/// A joint that may move: its place in the chain, the range (degrees; `None` all round) and the step of the candidates.
struct Freedom {
    joint: usize,
    range: Option<(f64, f64)>,
    step: f64,
}

/// The rows of a schedule after the first `fixed` with their angles moved; `None` where the criterion cannot be compared. A value that is `enough`
/// is not bettered.
///
/// Errors: those of the model at the moved angles.
pub(super) fn refined(
    campaign: &Campaign,
    rows: Vec<Reading>,
    fixed: usize,
    (pool, objective): (&Pool, &Objective),
    (noise, wanted, progress): (&Noise, &Refinement, &Progress),
    enough: Option<f64>,
) -> Result<Option<(Vec<Reading>, Refined)>> {
    let resolution = wanted.resolution_deg;
    let columns = &campaign.readings.columns;
    let names: Vec<&str> = campaign.bench.joints().collect();
    let value_of = |rows: &[Reading]| {
        let all = planned(campaign, &Readings { columns: columns.clone(), rows: rows.to_vec() });
        criterion_of(&campaign.with_readings(all), noise, pool, objective)
    };
    let Some(start) = value_of(&rows)? else { return Ok(None) };
    // mountings, in the order in which they stand
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
    let (mut rows, mut now) = (rows, start);
    let given: Vec<Vec<Option<f64>>> = rows.iter().map(mounting).collect();
    let (mut effort, mut finished) = (0, true);
    let widest = freedoms.iter().map(|own| own.step).fold(0.0, f64::max);
    let mut share = 0.5;
    'levels: while widest * share >= 0.5 * resolution {
        // to and fro until nothing moves at this step
        loop {
            let mut improved = false;
            for group in &groups {
                for own in &freedoms {
                    let step = ((own.step * share / resolution).round() * resolution).max(resolution);
                    for way in [step, -step] {
                        if effort > EFFORT {
                            finished = false;
                            break 'levels;
                        }
                        let Some(moved) = moved(campaign, &names, &rows, group, own, way, &wanted.zones) else {
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
    Ok(Some((rows, Refined { moved, gain, value: now, finished })))
}

/// Joints that stand at several angles in the candidates.
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
            // the gap between the last and the first is no wider than the others: they go round
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
    own: &Freedom,
    way: f64,
    zones: &[Zone],
) -> Option<Vec<Reading>> {
    let mut moved = rows.to_vec();
    for k in group {
        let row = moved.get_mut(*k)?;
        let mut joints = row.joints.clone();
        let JointState::Held { angle_deg } = joints.get(own.joint)? else { return None };
        let angle = angle_deg + way;
        let angle = match own.range {
            Some((low, high)) if (low..=high).contains(&angle) => angle,
            Some(_) => return None,
            None => (angle.rem_euclid(360.0) * 1e9).round() / 1e9 % 360.0,
        };
        *joints.get_mut(own.joint)? = JointState::Held { angle_deg: angle };
        let there = campaign.readings.position(names, row, joints);
        if is_forbidden(names, zones, &there) {
            return None;
        }
        row.columns = there.columns;
        row.joints = there.joints;
    }
    Some(moved)
}
