//! Positions that would tell an effect from its aliases, and positions that would make a campaign redundant.

use super::candidates::Candidate;
use crate::campaign::{Campaign, JointState, Role};
use crate::design::{self, DesignMatrix, Model};
use crate::fit::{self, Fit};
use crate::plan::{self, Costs, DiscriminatingPosition, Noise, NoiseSource, Offer, SensorNoise, Term};
use crate::simulate::Regressor;
use std::collections::HashSet;

/// Most positions that are named.
const NAMED: usize = 4;
/// Most positions that are looked at.
const LOOKED_AT: usize = 512;

/// What one more position could tell.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Separation {
    /// Positions, best first.
    pub positions: Vec<Vec<JointState>>,
    /// How many of the aliases each of them tells.
    pub told: Vec<usize>,
    /// Aliases that a position could tell in principle: not those that only small terms or rounding show.
    pub of: usize,
    /// Those among them that no position of this bench tells.
    pub never: Vec<String>,
}

/// Positions that tell the effect from its aliases when one of them is added to the readings at hand.
///
/// The first discriminates best between all aliases, the second best between those that the first discriminates least, and so on. T-optimal: against each alias,
/// with its coefficient and parameters fitted, see [`plan::discriminating_positions`]. Rows are evaluated at the estimate.
pub(super) fn positions(
    campaign: &Campaign,
    design: &DesignMatrix,
    effect: &Candidate,
    aliases: &[&Candidate],
) -> Separation {
    let term = |c: &Candidate| Term { sensor: c.sensor, regressor: c.kind.clone() };
    let rivals: Vec<&Candidate> =
        aliases.iter().copied().filter(|c| !c.vanishing && only_position(campaign, c)).collect();
    if rivals.is_empty() || !only_position(campaign, effect) {
        return Separation::default();
    }
    let mut there = campaign.clone();
    for (parameter, value) in there.parameters.iter_mut().zip(&design.point) {
        if let Role::Estimated { start, .. } = &mut parameter.role {
            *start = Some(*value);
        }
    }
    let mut candidates = fit::candidates(campaign);
    candidates.rows.truncate(LOOKED_AT);
    let sd = |sensor| SensorNoise { sd: sd(campaign, sensor), from: NoiseSource::Stated };
    let noise = Noise {
        sensors: (0..campaign.bench.sensors.len()).map(sd).collect(),
        remount: Vec::new(),
        lines: Vec::new(),
        tilts: None,
    };
    let offer = Offer { kept: campaign.readings.clone(), candidates, noise, costs: Costs::default() };
    let terms: Vec<Term> = rivals.iter().map(|c| term(c)).collect();
    // where no positions can be weighed none is offered, and all rivals are listed as never discriminated
    let least = plan::discriminating_positions(&there, &offer, &term(effect), &terms).unwrap_or_default();
    let discriminated: HashSet<usize> = least.iter().flat_map(|t| t.told.iter().copied()).collect();
    let never = rivals.iter().enumerate().filter(|(k, _)| !discriminated.contains(k)).map(|(_, c)| c.regressor.clone());
    let never: Vec<String> = never.collect();
    let is_new = |t: &DiscriminatingPosition| !campaign.readings.rows.iter().any(|row| row.joints == t.position.joints);
    let least: Vec<DiscriminatingPosition> = least.into_iter().filter(|t| !t.told.is_empty() && is_new(t)).collect();
    let mut mean = least.clone();
    let rounded = |v: f64| (v * 1e3).round();
    mean.sort_by(|a, b| rounded(b.mean).total_cmp(&rounded(a.mean)));
    let in_turn: Vec<DiscriminatingPosition> = mean.into_iter().zip(least).flat_map(|(a, b)| [a, b]).collect();
    let positions = distinct(in_turn.iter().map(|t| t.position.joints.to_vec()));
    let count =
        |joints: &Vec<JointState>| in_turn.iter().find(|t| *t.position.joints == **joints).map(|t| t.told.len());
    let counts = positions.iter().filter_map(count).collect();
    Separation { positions, told: counts, of: rivals.len(), never }
}

/// Standard uncertainty of a further reading: as the readings state theirs, else a common unknown one.
fn sd(campaign: &Campaign, sensor: usize) -> f64 {
    let stated = campaign.readings.rows.iter().flat_map(|r| &r.observations).filter(|o| o.sensor == sensor);
    let squares: Vec<f64> = stated.filter_map(|o| o.u).map(|u| u * u).collect();
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    if mean > 0.0 && mean.is_finite() { mean.sqrt() } else { 1.0 }
}

/// Positions with different angles of the held joints (a rate more or less is no other position).
fn distinct(positions: impl Iterator<Item = Vec<JointState>>) -> Vec<Vec<JointState>> {
    let held = |joints: &[JointState]| -> Vec<Option<u64>> {
        joints.iter().map(|state| state.held_deg().map(f64::to_bits)).collect()
    };
    let mut named: Vec<Vec<JointState>> = Vec::new();
    for joints in positions {
        if !named.iter().any(|other| held(other) == held(&joints)) {
            named.push(joints);
        }
        if named.len() == NAMED {
            break;
        }
    }
    named
}

/// Does the effect depend on the position alone, so that a further position says something about it?
fn only_position(campaign: &Campaign, candidate: &Candidate) -> bool {
    match &candidate.kind {
        Regressor::Term(line) => {
            let column = |name: &str| campaign.readings.columns.iter().any(|c| c == name);
            line.names().iter().all(|name| !column(name) || campaign.bench.is_of_joint(name))
        }
        Regressor::Tilt(_) | Regressor::Known(_) | Regressor::Position(_) => true,
        Regressor::Reading(_)
        | Regressor::Exchange(..)
        | Regressor::Change { .. }
        | Regressor::Approach(_)
        | Regressor::Prior(_)
        | Regressor::Constraint(_)
        | Regressor::Scatter => false,
    }
}

/// Positions that a campaign without redundancy lacks: those whose reading the model predicts best, so that it can be checked.
pub(super) fn redundancy(campaign: &Campaign, fit: &Fit) -> Vec<Vec<JointState>> {
    let schedule = campaign.with_readings(fit::candidates(campaign));
    let Ok(model) = Model::new(campaign) else { return Vec::new() };
    let Ok(further) = design::assemble(&schedule, &model, &fit.design.point) else { return Vec::new() };
    let cofactor = &fit.estimate.unknowns.cofactor;
    let n = cofactor.nrows();
    let mut ranked: Vec<(f64, usize)> = Vec::new();
    for (i, origin) in further.rows.iter().enumerate() {
        let seen = schedule.readings.rows.get(origin.reading).map(|r| &r.joints);
        if campaign.readings.rows.iter().any(|reading| Some(&reading.joints) == seen) {
            continue;
        }
        let a = |j: usize| further.jacobian[(i, j)];
        let variance: f64 = (0..n).map(|j| (0..n).map(|k| a(j) * cofactor[(j, k)] * a(k)).sum::<f64>()).sum();
        ranked.push((variance, origin.reading));
    }
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    distinct(ranked.into_iter().filter_map(|(_, k)| schedule.readings.rows.get(k)).map(|r| r.joints.to_vec()))
}
