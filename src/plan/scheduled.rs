//! Why each mounting is in a schedule.
//!
//! Angles between the candidates: chosen mountings are moved joint by joint, in halved steps, as long as the criterion improves.
//!
//! A mounting moves with all its readings, a joint within the range that the candidates have (all round where they go round), and never into a
//! forbidden zone. Steps start at half of the sweep's and end at the resolution, of which they are whole multiples.

use super::candidates::is_forbidden;
use super::effort::{Noise, grouped, mounting};
use super::objective::Objective;
use super::pool::Pool;
use super::problem::WORTH;
use super::question::Question;
use super::whitened::Independent;
use crate::campaign::{Campaign, JointState, Reading, Readings};
use crate::error::Result;
use crate::number;

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
    let mountings = grouped(rows.iter().skip(kept).map(|row| (row.position.as_str(), row.position.as_str())));
    if mountings.len() > MOST_REASONS || rows.len() > MOST_READINGS {
        return Ok(Vec::new());
    }
    let n = schedule.unknowns();
    let u = |readings: &Readings| -> Result<Vec<Option<f64>>> {
        let there = schedule.with_readings(readings.clone());
        let (_, _, estimate) = Independent::at(&there, &there.reference_point(), noise)?;
        let known = |k: usize| estimate.unknowns.is_estimable(k);
        Ok((0..n).map(|k| known(k).then(|| estimate.unknowns.covariance[(k, k)].sqrt())).collect())
    };
    let with = u(&schedule.readings)?;
    let mut reasons = Vec::with_capacity(mountings.len());
    for label in mountings.iter().filter_map(|mounting| mounting.first().copied()) {
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

impl Question<'_> {
    /// The rows of a schedule after those that are kept with their angles moved; `None` without such a request, or where the criterion cannot be compared.
    /// A value of `enough` ends the search.
    ///
    /// Errors: those of the model at the moved angles.
    pub(super) fn refined(
        &self,
        before: &[Reading],
        objective: &Objective,
        enough: Option<f64>,
    ) -> Result<Option<(Vec<Reading>, Refined)>> {
        let Question { campaign, pool, offer, request, .. } = self;
        let Some(wanted) = &request.refine else { return Ok(None) };
        let resolution = wanted.resolution_deg;
        let names: Vec<&str> = campaign.bench.joints().collect();
        let value_of = |rows: &[Reading]| pool.value(campaign, &self.with_rows(rows).readings, &offer.noise, objective);
        let Some(start) = value_of(before)? else { return Ok(None) };
        // the rows with one joint of a mounting moved; none where it may not be, or turns
        let moved = |rows: &[Reading], group: &[usize], freedom: &Freedom, way: f64| {
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
                let there = campaign.readings.position(&names, row, joints);
                if is_forbidden(&names, &wanted.zones, &there) {
                    return None;
                }
                row.columns = there.columns;
                row.joints = there.joints;
            }
            Some(moved)
        };
        // mountings, in the order of the rows
        let to_move = before.iter().enumerate().skip(offer.kept.rows.len());
        let groups = grouped(to_move.map(|(i, row)| (i, format!("{} {:?}", row.position, mounting(row)))));
        let freedoms = freedoms(pool, names.len());
        let (mut rows, mut now) = (before.to_vec(), start);
        let (mut effort, mut finished) = (0, true);
        let widest = freedoms.iter().map(|f| f.step).fold(0.0, f64::max);
        let mut share = 0.5;
        'levels: while widest * share >= 0.5 * resolution {
            // both senses until nothing moves at this step
            loop {
                let mut improved = false;
                for (group, freedom) in groups.iter().flat_map(|group| freedoms.iter().map(move |own| (group, own))) {
                    let step = ((freedom.step * share / resolution).round() * resolution).max(resolution);
                    for way in [step, -step] {
                        if effort > EFFORT {
                            finished = false;
                            break 'levels;
                        }
                        let Some(moved) = moved(&rows, group, freedom, way) else { continue };
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
                if !improved {
                    break;
                }
            }
            share /= 2.0;
            request.progress.tell("degrees of resolution", 0, number::count((widest * share).ceil()));
        }
        let n = pool.blocks.unknowns().max(1) as f64;
        let gain = match objective {
            Objective::Determinant => ((start - now) / n).exp_m1(),
            _ => start / now - 1.0,
        };
        let changed = |group: &&Vec<usize>| {
            group.first().is_some_and(|k| rows.get(*k).map(mounting) != before.get(*k).map(mounting))
        };
        let moved = groups.iter().filter(changed).count();
        Ok(Some((rows, Refined { resolution_deg: resolution, moved, gain, value: now, finished })))
    }
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
