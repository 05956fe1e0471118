//! Positions that would tell an effect from its aliases, and positions that would make a campaign redundant.

use super::candidates::Candidate;
use crate::campaign::{Campaign, JointState};
use crate::design::{self, DesignMatrix, Model, RowOrigin};
use crate::fit::{self, Fit};
use crate::simulate::{Regressor, Table};

/// Most positions that are named.
const NAMED: usize = 4;
/// Most positions that are looked at.
const LOOKED_AT: usize = 512;
/// Predictions that differ by less than this share of the effect's own size do not tell two effects apart.
const TELLS: f64 = 0.05;

/// Positions where the aliases predict most differently from the effect, best first; empty where none would.
///
/// Each alias fits the readings at hand with its own coefficient and its own parameters, and so predicts a further position in its own way.
/// First come positions where the aliases differ most in all, then those that tell most of them apart.
pub(super) fn positions(
    campaign: &Campaign,
    design: &DesignMatrix,
    effect: &Candidate,
    aliases: &[&Candidate],
) -> Vec<Vec<JointState>> {
    let terms: Vec<&Candidate> =
        aliases.iter().copied().filter(|c| !c.rounding && !c.vanishing && only_position(campaign, c)).collect();
    if terms.is_empty() || !only_position(campaign, effect) {
        return Vec::new();
    }
    let mut further = fit::candidates(campaign);
    further.rows.truncate(LOOKED_AT);
    let schedule = campaign.with_readings(further);
    let Ok(model) = Model::new(campaign) else { return Vec::new() };
    let sensor = effect.sensor.unwrap_or_default();
    let rows: Vec<RowOrigin> = (0..schedule.readings.rows.len()).map(|reading| RowOrigin { reading, sensor }).collect();
    let mut jacobian = Vec::with_capacity(rows.len());
    let mut gradient = vec![0.0; campaign.parameters.len()];
    let mut work = model.workspace();
    for row in &rows {
        if model.predict(&schedule, row.reading, sensor, &design.point, &mut gradient, &mut work).is_err() {
            return Vec::new();
        }
        jacobian.push(gradient.clone());
    }
    let tilts = model.tilts_of(&design.point);
    let mut table = Table::new(&schedule, &tilts, &design.point);
    let unknowns = campaign.unknowns();
    let mut predicted = |own: &Candidate, scale: f64| -> Option<Vec<f64>> {
        let column = match &own.kind {
            Regressor::Term(line) => table.term(sensor, line, &rows).ok().flatten()?,
            Regressor::Tilt(k) | Regressor::Known(k) => {
                jacobian.iter().map(|row| row.get(*k).copied().unwrap_or_default()).collect()
            }
            _ => vec![0.0; rows.len()],
        };
        let absorbed = absorbed(design, &own.column, unknowns)?;
        let along = |row: &Vec<f64>| row.iter().zip(&absorbed).map(|(a, x)| a * x).sum::<f64>();
        Some(column.iter().zip(&jacobian).map(|(c, row)| scale * (c - along(row))).collect())
    };
    let Some(own) = predicted(effect, 1.0) else { return Vec::new() };
    let size = own.iter().fold(0.0_f64, |largest, v| largest.max(v.abs()));
    let others: Vec<Vec<f64>> = terms
        .iter()
        .filter_map(|alias| predicted(alias, coefficient_ratio(design, effect, alias, unknowns)?))
        .collect();
    let mut ranked: Vec<(usize, f64, usize)> = (0..rows.len())
        .map(|k| {
            let difference = |other: &Vec<f64>| match (own.get(k), other.get(k)) {
                (Some(a), Some(b)) => (a - b).abs(),
                _ => 0.0,
            };
            let told = others.iter().filter(|other| difference(other) > TELLS * size).count();
            (told, others.iter().map(difference).sum::<f64>(), k)
        })
        .filter(|(told, sum, _)| *told > 0 && sum.is_finite())
        .collect();
    ranked.sort_by(|a, b| rounded(b.1, size).total_cmp(&rounded(a.1, size)).then(b.0.cmp(&a.0)).then(a.2.cmp(&b.2)));
    distinct(ranked.into_iter().filter_map(|(_, _, k)| schedule.readings.rows.get(k)).map(|r| r.joints.clone()))
}

/// Differences that are equal but for the small tilts must not order positions.
fn rounded(value: f64, size: f64) -> f64 {
    (value / size * 1e2).round()
}

/// Positions with different angles of the held joints (a rate more or less is no other position).
fn distinct(positions: impl Iterator<Item = Vec<JointState>>) -> Vec<Vec<JointState>> {
    let held = |joints: &[JointState]| -> Vec<Option<u64>> {
        let angle = |state: &JointState| match state {
            JointState::Held { angle_deg } => Some(angle_deg.to_bits()),
            _ => None,
        };
        joints.iter().map(angle).collect()
    };

    let mut named: Vec<Vec<JointState>> = Vec::new();
    for joints in positions {
        if !named.iter().any(|own| held(own) == held(&joints)) {
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
            let joint_key = |name: &str| {
                campaign.bench.joints().any(|joint| {
                    name.strip_prefix(joint).is_some_and(|end| matches!(end, "_deg" | "_deg_s" | "_turns"))
                })
            };
            let column = |name: &str| campaign.readings.columns.iter().any(|c| c == name);
            line.names().iter().all(|name| !column(name) || joint_key(name))
        }
        Regressor::Tilt(_) | Regressor::Known(_) | Regressor::Position(_) => true,
        Regressor::Reading(_) | Regressor::Approach(_) | Regressor::Prior(_) | Regressor::Constraint(_) => false,
    }
}

/// The part of the parameters that a column moves when it is fitted away: least squares of the column on the model.
fn absorbed(design: &DesignMatrix, column: &[f64], unknowns: usize) -> Option<Vec<f64>> {
    let readings = design.rows.len();
    let rows = faer::Mat::from_fn(readings, unknowns, |i, j| design.jacobian[(i, j)]);
    let observed: Vec<f64> = column.iter().take(readings).copied().collect();
    let system = crate::estimate::System {
        rows,
        observed,
        u: vec![1.0; readings],
        group: vec![crate::estimate::Group::Known; readings],
    };
    let estimate = crate::estimate::adjust(&system, &crate::estimate::Settings::default()).ok()?;
    Some(estimate.solution)
}

/// How large the alias's coefficient is when the effect's is one.
fn coefficient_ratio(design: &DesignMatrix, effect: &Candidate, alias: &Candidate, unknowns: usize) -> Option<f64> {
    let rest = |candidate: &Candidate| -> Option<Vec<f64>> {
        let x = absorbed(design, &candidate.column, unknowns)?;
        let along = |i: usize| x.iter().enumerate().map(|(j, x)| design.jacobian[(i, j)] * x).sum::<f64>();
        Some(candidate.column.iter().take(design.rows.len()).enumerate().map(|(i, c)| c - along(i)).collect())
    };
    let (own, other) = (rest(effect)?, rest(alias)?);
    let product: f64 = own.iter().zip(&other).map(|(a, b)| a * b).sum();
    let square: f64 = other.iter().map(|b| b * b).sum();
    let ratio = product / square;
    ratio.is_finite().then_some(ratio)
}

/// Positions that a campaign without redundancy lacks: those whose reading the model predicts best, so that it can be checked.
pub(super) fn redundancy(campaign: &Campaign, fit: &Fit) -> Vec<Vec<JointState>> {
    let schedule = campaign.with_readings(fit::candidates(campaign));
    let Ok(model) = Model::new(campaign) else { return Vec::new() };
    let Ok(further) = design::assemble(&schedule, &model, &fit.design.point) else { return Vec::new() };
    let cofactor = &fit.estimate.cofactor;
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
    distinct(ranked.into_iter().filter_map(|(_, k)| schedule.readings.rows.get(k)).map(|r| r.joints.clone()))
}
