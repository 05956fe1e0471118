//! From candidate positions to blocks of whitened rows in coordinates in which the exchanges are well conditioned.
//!
//! One pivoted QR of all rows (what is kept, priors, candidates), `W A D^-1 = Q R`, gives coordinates `z = R D x`: there the rows of every
//! block are rows of `Q`, and a linear function `c'x` has the coordinates `R^-T D^-1 c`.

use super::blocks::{Blocks, add_outer};
use super::candidates::{Unit, portions};
use super::effort::{Noise, mountings};
use super::judge::priors;
use crate::campaign::{Campaign, Reading, Readings};
use crate::design::{self, Model};
use crate::error::{Fault, Malformed, Result};
use crate::estimate::{self, Estimate, Group, System};
use crate::fit::{self, Separation};
use crate::simulate::{self, Regressor};
use faer::Mat;

/// An effect that the model may lack: one more unknown, its coefficient.
#[derive(Debug, Clone, PartialEq)]
pub struct Term {
    /// The sensor that may have it; `None` for all.
    pub sensor: Option<usize>,
    /// What goes with the coefficient, for example `a_S`.
    pub regressor: Regressor,
}

/// Candidates, ready for exchanges.
#[derive(Debug, Clone)]
pub(super) struct Pool {
    /// Readings of each portion.
    pub portions: Vec<Vec<Reading>>,
    /// Their information in as few rows as it has.
    pub blocks: Blocks,
    /// All their rows: what is predicted there.
    pub rows: Blocks,
    /// Information of what is kept, and of priors, row by row.
    pub base: Vec<f64>,
    /// The factorisation behind the coordinates.
    pub estimate: Estimate,
    /// What even all candidates together do not determine.
    pub not_estimable: Vec<Separation>,
}

impl Pool {
    /// Rows of `kept` positions and of `candidates`; each of `terms` is one more unknown after the estimated parameters.
    pub fn new(
        campaign: &Campaign,
        kept: &Readings,
        candidates: &Readings,
        unit: Unit,
        noise: &Noise,
        terms: &[Term],
    ) -> Result<Pool> {
        let portions = portions(&campaign.bench.joints().collect::<Vec<_>>(), candidates, unit)?;
        let n = campaign.unknowns() + terms.len();
        let mut rows = whitened(campaign, kept, noise, terms, false)?;
        for (k, u) in priors(campaign) {
            let mut row = vec![0.0; n];
            row[k] = 1.0 / u;
            rows.push(row);
        }
        let fixed = rows.len();
        // every portion is a mounting of its own
        let flat: Vec<Reading> = portions
            .iter()
            .enumerate()
            .flat_map(|(p, portion)| {
                portion.iter().map(move |r| Reading { position: p.to_string(), observations: Vec::new(), ..r.clone() })
            })
            .collect();
        let flat = Readings { columns: candidates.columns.clone(), rows: flat };
        rows.extend(whitened(campaign, &flat, noise, terms, true)?);
        let total = rows.len();
        let matrix = Mat::from_fn(total, n, |i, j| rows[i][j]);
        let system =
            System { rows: matrix, observed: vec![0.0; total], u: vec![1.0; total], group: vec![Group::Known; total] };
        let settings = estimate::Settings { refinements: 0, ..estimate::Settings::default() };
        let estimate = estimate::adjust(&system, &settings)?;
        let rank = estimate.rank;
        if rank == 0 {
            return Err(Malformed::new(Fault::Value, "no candidate depends on what is to be estimated")
                .expected("candidates whose readings depend on the estimated parameters"));
        }
        let q = estimate.factor.thin_q();
        let per_portion = (total - fixed) / portions.len();
        let rows = Blocks::from_fn(portions.len(), per_portion, rank, |j, r, c| q[(fixed + j * per_portion + r, c)]);
        let mut base = vec![0.0; rank * rank];
        for i in 0..fixed {
            let row: Vec<f64> = (0..rank).map(|c| q[(i, c)]).collect();
            add_outer(&mut base, 1.0, &row);
        }
        let not_estimable = if terms.is_empty() && !estimate.not_estimable.is_empty() {
            let all = campaign.with_readings(candidates.clone());
            let model = Model::new(&all)?;
            let point = all.reference_point();
            let design =
                design::DesignMatrix { rows: Vec::new(), point, predicted: Vec::new(), jacobian: Mat::zeros(0, 0) };
            fit::separations(&all, &model, &design, &estimate)
        } else {
            Vec::new()
        };
        Ok(Pool { portions, blocks: rows.compressed(), rows, base, estimate, not_estimable })
    }

    /// Readings of each portion.
    pub fn portion_size(&self) -> usize {
        self.portions.first().map_or(1, Vec::len)
    }

    /// Coordinates of a linear function of the unknowns; `None` where it takes part in a defect.
    pub fn coordinates(&self, c: &[f64]) -> Option<Vec<f64>> {
        let estimable = |k: usize| self.estimate.estimable.get(k).copied().unwrap_or(false);
        if c.iter().enumerate().any(|(k, c)| *c != 0.0 && !estimable(k)) {
            return None;
        }
        let factor = &self.estimate.factor;
        let (r, scale) = (factor.r(), factor.scale());
        let mut z: Vec<f64> = Vec::with_capacity(factor.rank());
        for (k, j) in factor.basis().iter().enumerate() {
            let own = c.get(*j).copied().unwrap_or_default() / scale.get(*j).copied().unwrap_or(1.0);
            let before: f64 = z.iter().enumerate().map(|(i, zi)| r[(i, k)] * zi).sum();
            z.push((own - before) / r[(k, k)]);
        }
        Some(z)
    }

    /// `log det` of an information matrix in the unknowns' own units, from its value in these coordinates.
    pub fn log_det_in_units(&self, log_det: f64) -> f64 {
        log_det + log_det_of(&self.estimate)
    }

    /// Candidates that differ from each in the state of one joint (for coordinate exchange).
    pub fn neighbours(&self) -> Vec<Vec<usize>> {
        let mut groups: std::collections::HashMap<(usize, String), Vec<usize>> = std::collections::HashMap::new();
        let states =
            |k: usize| self.portions.get(k).and_then(|p| p.first()).map(|r| r.joints.clone()).unwrap_or_default();
        let key = |k: usize, joint: usize| {
            let mut others = states(k);
            if joint < others.len() {
                others.remove(joint);
            }
            (joint, format!("{others:?}"))
        };
        for k in 0..self.portions.len() {
            for joint in 0..states(k).len() {
                groups.entry(key(k, joint)).or_default().push(k);
            }
        }
        let list = |k: usize| {
            let mut all: Vec<usize> =
                (0..states(k).len()).filter_map(|joint| groups.get(&key(k, joint))).flatten().copied().collect();
            all.sort_unstable();
            all.dedup();
            all
        };
        (0..self.portions.len()).map(list).collect()
    }
}

/// `log det (A' P A)` on the independent unknowns, from the factorisation.
pub(super) fn log_det_of(estimate: &Estimate) -> f64 {
    let factor = &estimate.factor;
    let diagonal = (0..factor.rank()).map(|k| factor.r()[(k, k)].abs().ln()).sum::<f64>();
    let scales: f64 = factor.basis().iter().filter_map(|j| factor.scale().get(*j)).map(|s| s.ln()).sum();
    2.0 * (diagonal + scales)
}

/// Rows divided by the Cholesky factor of their covariance, mounting by mounting, in the order of the mountings; then the columns of terms.
///
/// `further`: positions that are still to be taken. Where no reading has a value, every sensor is read at each.
pub(super) fn whitened(
    campaign: &Campaign,
    readings: &Readings,
    noise: &Noise,
    terms: &[Term],
    further: bool,
) -> Result<Vec<Vec<f64>>> {
    if readings.rows.is_empty() {
        return Ok(Vec::new());
    }
    let schedule = campaign.with_readings(readings.clone());
    let model = Model::new(&schedule)?;
    let point = schedule.reference_point();
    let design = design::assemble(&schedule, &model, &point)?;
    let n = campaign.unknowns();
    let columns = term_columns(&schedule, &model, &design, terms, further)?;
    let mounting_of = mountings(&readings.rows);
    let count = mounting_of.iter().max().map_or(0, |last| last + 1);
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); count];
    for (i, origin) in design.rows.iter().enumerate() {
        if let Some(list) = mounting_of.get(origin.reading).and_then(|m| members.get_mut(*m)) {
            list.push(i);
        }
    }
    let mut all = Vec::with_capacity(design.rows.len());
    for list in members {
        let own: Vec<Vec<f64>> = list
            .iter()
            .map(|&i| (0..n).map(|j| design.jacobian[(i, j)]).chain(columns.iter().map(|c| c[i])).collect())
            .collect();
        let u: Vec<f64> = list
            .iter()
            .map(|&i| {
                let origin = design.rows[i];
                readings.rows.get(origin.reading).map_or(1.0, |reading| noise.u(reading, origin.sensor))
            })
            .collect();
        let scatter: Vec<Vec<f64>> =
            noise.remount.iter().map(|(k, sd)| list.iter().map(|&i| sd * design.jacobian[(i, *k)]).collect()).collect();
        all.extend(divide_by_root(own, &u, &scatter));
    }
    Ok(all)
}

/// `L^-1 A` with `L L' = diag(u^2) + sum s s'`.
fn divide_by_root(mut rows: Vec<Vec<f64>>, u: &[f64], scatter: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let k = rows.len();
    let mut l = vec![0.0; k * k];
    for i in 0..k {
        for j in 0..=i {
            let own = if i == j { u[i] * u[i] } else { 0.0 };
            let v = own + scatter.iter().map(|s| s[i] * s[j]).sum::<f64>();
            let sum: f64 = (0..j).map(|c| l[i * k + c] * l[j * k + c]).sum();
            l[i * k + j] = if i == j { (v - sum).max(own * 1e-12).sqrt() } else { (v - sum) / l[j * k + j] };
        }
        let (done, rest) = rows.split_at_mut(i);
        if let Some(row) = rest.first_mut() {
            for (j, before) in done.iter().enumerate() {
                row.iter_mut().zip(before).for_each(|(a, b)| *a -= l[i * k + j] * b);
            }
            row.iter_mut().for_each(|a| *a /= l[i * k + i]);
        }
    }
    rows
}

/// Columns of effects at the rows of a schedule. At further positions, what hangs on a reading already taken (one bad reading, a remounting,
/// the way of approach) is zero.
fn term_columns(
    schedule: &Campaign,
    model: &Model,
    design: &design::DesignMatrix,
    terms: &[Term],
    further: bool,
) -> Result<Vec<Vec<f64>>> {
    let tilts = model.tilts_of(&design.point);
    let at_readings =
        |r: &Regressor| matches!(r, Regressor::Reading(_) | Regressor::Position(_) | Regressor::Approach(_));
    let wanted: Vec<(&Regressor, Option<usize>)> = terms.iter().map(|term| (&term.regressor, term.sensor)).collect();
    let mut columns = simulate::columns(schedule, &design.rows, &tilts, &design.point, &wanted)?;
    for (column, term) in columns.iter_mut().zip(terms) {
        match &term.regressor {
            Regressor::Tilt(k) | Regressor::Known(k) if *k < design.jacobian.ncols() => {
                column.iter_mut().zip(design.jacobian.col(*k).iter()).for_each(|(slot, v)| *slot = *v);
            }
            other if further && at_readings(other) => column.fill(0.0),
            _ => {}
        }
    }
    Ok(columns)
}
