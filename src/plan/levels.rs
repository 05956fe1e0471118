//! Coarser sweeps within a finer one: what they find is where the finer search goes on from, so that more candidates never give a worse answer.
//!
//! A sweep in steps of 15 deg holds those in steps of 30, 45, 60, 90, 120 and 180. Each is searched just as it would be alone, from what the
//! coarser ones within it have found.

use super::pool::Pool;
use crate::campaign::{JointState, Readings};
use crate::elements::Elements;
use std::collections::HashMap;

/// Steps finer than this are no sweep.
const FINEST: usize = 720;

/// Steps of a turn on which all angles of joints at rest lie; `None` where they lie on no grid.
fn steps(candidates: &Readings) -> Option<usize> {
    let mut steps = 1_usize;
    let mut seen: Vec<u64> = Vec::new();
    for state in candidates.rows.iter().flat_map(|r| &r.joints) {
        let JointState::Held { angle_deg } = state else { continue };
        if seen.contains(&angle_deg.to_bits()) {
            continue;
        }
        if seen.len() > 4 * FINEST {
            return None;
        }
        seen.push(angle_deg.to_bits());
        let own = (1..=FINEST).find(|k| {
            let at = angle_deg / 360.0 * *k as f64;
            (at - at.round()).abs() < 1e-9
        })?;
        steps = steps / gcd(steps, own) * own;
        if steps > FINEST {
            return None;
        }
    }
    Some(steps)
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Candidates on each coarser grid, the coarsest first, and which of the earlier ones each holds; the last is all candidates.
pub(super) fn levels(candidates: &Readings) -> Vec<(Readings, Vec<usize>)> {
    // angles on no common grid: one level
    let all = steps(candidates).unwrap_or(1);
    let mut levels: Vec<(usize, Readings)> = Vec::new();
    for steps in (2..all).filter(|k| all.is_multiple_of(*k)) {
        let on_grid = |state: &JointState| match state {
            JointState::Held { angle_deg } => {
                let at = angle_deg / 360.0 * steps as f64;
                (at - at.round()).abs() < 1e-9
            }
            _ => true,
        };
        let rows: Vec<_> = candidates.rows.iter().filter(|r| r.joints.iter().all(on_grid)).cloned().collect();
        if !rows.is_empty()
            && rows.len() < candidates.rows.len()
            && levels.last().is_none_or(|(_, l)| l.rows.len() != rows.len())
        {
            levels.push((steps, Readings { columns: candidates.columns.clone(), rows }));
        }
    }
    levels.push((all, candidates.clone()));
    let grids: Vec<usize> = levels.iter().map(|(steps, _)| *steps).collect();
    let within = |own: usize| {
        let all = grids.at(own);
        let coarser = grids.iter().enumerate().take(own);
        coarser.filter(|(_, grid)| all.is_multiple_of(**grid)).map(|(k, _)| k).collect::<Vec<usize>>()
    };
    levels.into_iter().enumerate().map(|(own, (_, readings))| (readings, within(own))).collect()
}

/// Portions of one pool by their number in another that holds them; `None` where one is missing.
pub(super) fn carried(from: &Pool, chosen: &[usize], to: &Pool) -> Option<Vec<usize>> {
    let key = |pool: &Pool, k: usize| {
        pool.portions.get(k).map(|p| format!("{:?}", p.iter().map(|r| (&r.joints, &r.columns)).collect::<Vec<_>>()))
    };
    let places: HashMap<String, usize> = (0..to.portions.len()).filter_map(|k| Some((key(to, k)?, k))).collect();
    chosen.iter().map(|k| places.get(&key(from, *k)?).copied()).collect()
}
