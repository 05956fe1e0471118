//! What is not estimable, by name, and which further position would separate it.

use super::names::{NamedCombination, describe};
use crate::campaign::{Campaign, JointState, Readings};
use crate::design::{DesignMatrix, Model};
use crate::estimate::Estimate;

/// One rank defect.
#[derive(Debug, Clone, PartialEq)]
pub struct Separation {
    /// The combination that the readings leave free: parameters can move along it and no reading changes.
    pub free: NamedCombination,
    /// The direction along which it is free: parameters may move in these proportions and no reading changes.
    pub direction: NamedCombination,
    /// What is determined instead, of the parameters that take part.
    pub estimable: Vec<NamedCombination>,
    /// The further position that would separate it best, as joint states in chain order; `None` if none of this bench would.
    pub separate_by: Option<Vec<JointState>>,
}

/// A candidate separates when its row along the free direction is at least this share of the row's size.
const SEPARATES: f64 = 1e-3;
/// Above this share a position is good enough that positions with more joints moved are not tried.
const SEPARATES_WELL: f64 = 0.1;
const STEP_DEG: usize = 45;
/// More joints than this make the full sweep too long; the rest stay where the first reading has them.
const SWEPT_JOINTS: usize = 4;
/// Four joints in steps of 45 degrees.
const MOST_POSITIONS: usize = 4096;

/// Name every rank defect of an estimate and look for the position that would end it.
pub(crate) fn separations(
    campaign: &Campaign,
    model: &Model,
    design: &DesignMatrix,
    estimate: &Estimate,
) -> Vec<Separation> {
    if estimate.not_estimable.is_empty() {
        return Vec::new();
    }
    let schedule = campaign.with_readings(candidates(campaign));
    let unknowns = campaign.unknowns();
    let mut gradient = vec![0.0; campaign.parameters.len()];
    let mut work = model.workspace();
    estimate
        .not_estimable
        .iter()
        .zip(&estimate.free_directions)
        .map(|(combination, free)| {
            let mut direction = vec![0.0; unknowns];
            for (k, c) in &free.terms {
                if let Some(d) = direction.get_mut(*k) {
                    *d = *c;
                }
            }
            let mut best: Option<(f64, f64, usize)> = None;
            let mut moved = 0;
            for (reading, row) in schedule.readings.rows.iter().enumerate() {
                // positions come with the fewest joints moved first; more are tried only while none separates well
                let moves = joints_moved(&row.joints, campaign);
                if moves > moved && best.is_some_and(|(_, share, _)| share > SEPARATES_WELL) {
                    break;
                }
                moved = moves;
                for sensor in 0..campaign.bench.sensors.len() {
                    if model.predict(&schedule, reading, sensor, &design.point, &mut gradient, &mut work).is_err() {
                        continue;
                    }
                    let along = gradient.iter().zip(&direction).map(|(g, d)| g * d).sum::<f64>().abs();
                    let size: f64 = gradient.iter().zip(&direction).map(|(g, d)| (g * d).abs()).sum();
                    if along > SEPARATES * size && best.is_none_or(|(before, ..)| along > before * (1.0 + 1e-9)) {
                        best = Some((along, along / size, reading));
                    }
                }
            }
            let involved: Vec<usize> = free.terms.iter().map(|(k, _)| *k).collect();
            Separation {
                free: describe(campaign, combination),
                direction: describe(campaign, free),
                estimable: estimate
                    .estimable_combinations
                    .iter()
                    .filter(|c| c.terms.iter().any(|(k, _)| involved.contains(k)))
                    .map(|c| describe(campaign, c))
                    .collect(),
                separate_by: best.and_then(|(.., k)| schedule.readings.rows.get(k)).map(|r| r.joints.clone()),
            }
        })
        .collect()
}

/// Positions that this bench could take: every joint that the schedule holds still, in steps of 45 degrees; every joint that it turns, with
/// the states that the schedule has, and those with the sense of the rate reversed. Columns are those of the first reading. Simplest first: fewer joints away from the first reading's state.
pub fn candidates(campaign: &Campaign) -> Readings {
    let Some(first) = campaign.readings.rows.first() else { return Readings::default() };
    let rows = &campaign.readings.rows;
    let mut states: Vec<Vec<JointState>> = Vec::new();
    for joint in 0..first.joints.len() {
        let mut seen: Vec<JointState> = Vec::new();
        for state in rows.iter().filter_map(|r| r.joints.get(joint)) {
            if seen.len() < 16 && !seen.contains(state) {
                seen.push(*state);
            }
        }
        for state in seen.clone() {
            let reversed = state.reversed();
            if !seen.contains(&reversed) {
                seen.push(reversed);
            }
        }
        let held = seen.iter().all(|state| matches!(state, JointState::Held { .. }));
        if held && joint < SWEPT_JOINTS {
            for angle in (0..360).step_by(STEP_DEG) {
                let state = JointState::Held { angle_deg: angle as f64 };
                if !seen.contains(&state) {
                    seen.push(state);
                }
            }
        }
        states.push(seen);
    }
    let mut combinations: Vec<Vec<JointState>> = vec![Vec::new()];
    for options in &states {
        combinations = combinations
            .iter()
            .flat_map(|before| {
                options.iter().map(move |state| {
                    let mut next = before.clone();
                    next.push(*state);
                    next
                })
            })
            .take(MOST_POSITIONS)
            .collect();
    }
    combinations.sort_by_key(|joints| joints_moved(joints, campaign));
    let names: Vec<&str> = campaign.bench.joints().collect();
    let rows = combinations.into_iter().map(|joints| campaign.readings.position(&names, first, joints)).collect();
    Readings { columns: campaign.readings.columns.clone(), rows }
}

/// How many joints stand or turn otherwise than in the first reading.
fn joints_moved(joints: &[JointState], campaign: &Campaign) -> usize {
    let first = campaign.readings.rows.first().map_or(&[][..], |reading| &reading.joints);
    joints.iter().zip(first).filter(|(own, first)| own != first).count()
}
