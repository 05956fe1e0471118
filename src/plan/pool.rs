//! From candidate positions to blocks of whitened rows in coordinates in which the exchanges are well conditioned.
//!
//! One pivoted QR of all rows (kept readings, priors, candidates), `W A D^-1 = Q R`, gives coordinates `z = R D x`: there the rows of every
//! block are rows of `Q`, and a linear function `c'x` has the coordinates `T'c`, `T = D^-1 R^-1`; equations between unknowns are in `T`.
//!
//! Coarser sweeps within a finer one: the finer search starts from their results, so that more candidates never give a worse design.
//! A sweep in steps of 15 deg contains those in steps of 30, 45, 60, 90, 120 and 180. Each is searched as it would be alone, from the results
//! of the coarser ones within it.

use super::blocks::{Blocks, add_outer};
use super::candidates::{Unit, portions};
use super::effort::Noise;
use super::whitened::{
    Augmentation, Term, adjusted, level_of, mounted_apart, predicted, single, whitened, with_priors,
};
use crate::campaign::{Campaign, JointState, Reading, Readings};
use crate::design::{self, Model};
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use crate::estimate::Estimate;
use crate::fit::{self, RankDefect};
use crate::linear::normalise;
use faer::Mat;
use std::collections::HashMap;

/// Candidates, ready for exchanges.
#[derive(Debug, Clone)]
pub(super) struct Pool {
    /// Readings of each portion.
    pub portions: Vec<Vec<Reading>>,
    /// Level of each portion in the columns by which positions share deviations.
    pub levels: Vec<String>,
    /// Their information in as few rows as its rank.
    pub blocks: Blocks,
    /// All their rows, not whitened with others: what is predicted there.
    pub rows: Blocks,
    /// Information of the kept readings and of priors, row by row.
    pub base: Vec<f64>,
    /// The factorisation behind the coordinates.
    pub estimate: Estimate,
    /// Deviations that link positions: unknowns after the parameters.
    pub deviations: usize,
    /// The unknowns from the coordinates: `x = T z`.
    directions: Mat<f64>,
    /// Rank defects of all candidates together.
    pub not_estimable: Vec<RankDefect>,
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
        let portions = portions(campaign, candidates, unit)?;
        let first = |portion: &Vec<Reading>| portion.first().map(|r| level_of(campaign, candidates, r));
        // portions have readings
        let levels = portions.iter().map(|portion| first(portion).unwrap_or_default()).collect();
        let further = mounted_apart(&portions, candidates);
        let augmentation = Augmentation::new(campaign, noise, terms, &[kept, &further]);
        let deviations = augmentation.deviations.len();
        let mut rows = with_priors(campaign, kept, noise, &augmentation)?;
        let fixed = rows.len();
        rows.extend(whitened(campaign, &further, noise, &augmentation, true)?);
        let total = rows.len();
        let estimate = adjusted(campaign, &rows, augmentation.columns(campaign))?;
        let rank = estimate.unknowns.rank;
        if rank <= deviations {
            return Err(Malformed::new(Fault::Value, "no candidate depends on what is to be estimated")
                .expected("candidates whose readings depend on the estimated parameters"));
        }
        let q = estimate.factor.thin_q();
        let per_portion = (total - fixed) / portions.len();
        let whitened_rows =
            Blocks::from_fn(portions.len(), per_portion, rank, |j, r, c| q[(fixed + j * per_portion + r, c)]);
        let mut base = vec![0.0; rank * rank];
        for i in 0..fixed {
            let row: Vec<f64> = (0..rank).map(|c| q[(i, c)]).collect();
            add_outer(&mut base, 1.0, &row);
        }
        let not_estimable = if terms.is_empty() && !estimate.unknowns.not_estimable.is_empty() {
            let all = campaign.with_readings(candidates.clone());
            let model = Model::new(&all)?;
            let point = all.reference_point();
            let design = design::DesignMatrix {
                rows: Vec::new(),
                point,
                predicted: Vec::new(),
                jacobian: Mat::zeros(0, 0),
                by_joint: Mat::zeros(0, 0),
            };
            fit::separations(&all, &model, &design, &estimate, &[])
        } else {
            Vec::new()
        };
        let directions = estimate.factor.whitened_directions();
        let rows = match noise.remount.is_empty() && campaign.scatter.is_empty() {
            true => whitened_rows.clone(),
            false => {
                let predicted = predicted(campaign, &further, noise, &augmentation)?;
                let predicted: Vec<Vec<f64>> = predicted.iter().map(|row| in_coordinates(&directions, row)).collect();
                Blocks::from_fn(portions.len(), per_portion, rank, |j, r, c| {
                    // one list of coordinates for each row
                    predicted.get(j * per_portion + r).map_or(0.0, |row| row.at(c))
                })
            }
        };
        Ok(Pool {
            portions,
            levels,
            blocks: whitened_rows.compressed(),
            rows,
            base,
            estimate,
            deviations,
            directions,
            not_estimable,
        })
    }

    /// Readings of each portion.
    pub(crate) fn portion_size(&self) -> usize {
        self.portions.first().map_or(1, Vec::len)
    }

    /// Coordinates of a linear function of the unknowns; `None` where it takes part in a defect.
    pub(crate) fn coordinates(&self, c: &[f64]) -> Option<Vec<f64>> {
        let estimable = |k: usize| self.estimate.unknowns.is_estimable(k);
        if c.iter().enumerate().any(|(k, c)| *c != 0.0 && !estimable(k)) {
            return None;
        }
        Some(in_coordinates(&self.directions, c))
    }

    /// Parameters and terms that the candidates determine: unknowns without the deviations.
    pub(crate) fn determined(&self) -> usize {
        self.blocks.unknowns().saturating_sub(self.deviations)
    }

    /// Coordinates of every independent one of the first `parameters` unknowns, in units of what all candidates together give.
    pub(crate) fn independent(&self, parameters: usize) -> Vec<Vec<f64>> {
        let basis = self.estimate.factor.basis().iter().filter(|k| **k < parameters);
        basis
            .map(|k| {
                let mut row = in_coordinates(&self.directions, &single(k + 1, *k, 1.0));
                normalise(&mut row);
                row
            })
            .collect()
    }

    /// Candidates that differ from each in the state of one joint (for coordinate exchange).
    pub(crate) fn neighbours(&self) -> Vec<Vec<usize>> {
        let mut groups: std::collections::HashMap<(usize, String), Vec<usize>> = std::collections::HashMap::new();
        let states =
            // portions have readings
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

/// `T'c`; a shorter `c` is padded with zeros.
fn in_coordinates(directions: &Mat<f64>, c: &[f64]) -> Vec<f64> {
    let column = |k: usize| c.iter().enumerate().map(|(j, c)| directions[(j, k)] * c).sum();
    (0..directions.ncols()).map(column).collect()
}

/// `log det (A' P A)` on the independent unknowns, from the factorisation.
pub(super) fn log_det_of(estimate: &Estimate) -> f64 {
    let factor = &estimate.factor;
    let diagonal = (0..factor.rank()).map(|k| factor.r()[(k, k)].abs().ln()).sum::<f64>();
    let scales: f64 = factor.basis().iter().filter_map(|j| factor.scale().get(*j)).map(|s| s.ln()).sum();
    2.0 * (diagonal + scales)
}

/// Most steps of a turn that are taken as a sweep.
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
        let needed = (1..=FINEST).find(|k| is_on_grid(*angle_deg, *k))?;
        steps = steps / gcd(steps, needed) * needed;
        if steps > FINEST {
            return None;
        }
    }
    Some(steps)
}

/// Is an angle a multiple of a turn divided by `steps`?
fn is_on_grid(angle_deg: f64, steps: usize) -> bool {
    let at = angle_deg / 360.0 * steps as f64;
    (at - at.round()).abs() < 1e-9
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Results of coarser sweeps, each started from those within it, as designs of `pool`, which has all candidates.
pub(super) fn from_coarser(
    candidates: &Readings,
    pool: &Pool,
    pool_of: impl Fn(&Readings) -> Result<Pool>,
    best: impl Fn(&Pool, &[Vec<usize>]) -> Option<Vec<usize>>,
) -> Vec<Vec<usize>> {
    let mut results: Vec<Option<(Pool, Vec<usize>)>> = Vec::new();
    let mut given = Vec::new();
    let levels = levels(candidates);
    for (k, (readings, within)) in levels.iter().enumerate() {
        let coarse = (k + 1 < levels.len()).then_some(readings);
        // a coarser sweep may determine fewer unknowns
        let coarser_pool = coarse
            .and_then(|readings| pool_of(readings).ok())
            .filter(|p| p.blocks.unknowns() == pool.blocks.unknowns());
        let coarser = within.iter().filter_map(|k| results.get(*k)?.as_ref());
        let to = coarser_pool.as_ref().unwrap_or(pool);
        given = coarser.filter_map(|(from, chosen)| carried(from, chosen, to)).collect();
        let chosen = coarser_pool.as_ref().and_then(|p| best(p, &given));
        results.push(coarser_pool.zip(chosen));
    }
    given
}

/// Candidates on each coarser grid, the coarsest first, and which of the earlier ones each contains; the last is all candidates.
fn levels(candidates: &Readings) -> Vec<(Readings, Vec<usize>)> {
    // angles on no common grid: one level
    let all = steps(candidates).unwrap_or(1);
    let mut levels: Vec<(usize, Readings)> = Vec::new();
    for steps in (2..all).filter(|k| all.is_multiple_of(*k)) {
        let on_grid = |state: &JointState| match state {
            JointState::Held { angle_deg } => is_on_grid(*angle_deg, steps),
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
    let within = |level: usize| {
        let all = grids.at(level);
        let coarser = grids.iter().enumerate().take(level);
        coarser.filter(|(_, grid)| all.is_multiple_of(**grid)).map(|(k, _)| k).collect::<Vec<usize>>()
    };
    levels.into_iter().enumerate().map(|(k, (_, readings))| (readings, within(k))).collect()
}

/// Portions of one pool by their number in another that contains them; `None` where one is missing.
fn carried(from: &Pool, chosen: &[usize], to: &Pool) -> Option<Vec<usize>> {
    let key = |pool: &Pool, k: usize| {
        pool.portions.get(k).map(|p| format!("{:?}", p.iter().map(|r| (&r.joints, &r.columns)).collect::<Vec<_>>()))
    };
    let places: HashMap<String, usize> = (0..to.portions.len()).filter_map(|k| Some((key(to, k)?, k))).collect();
    chosen.iter().map(|k| places.get(&key(from, *k)?).copied()).collect()
}
