//! From candidate positions to blocks of whitened rows in coordinates in which the exchanges are well conditioned.
//!
//! One pivoted QR of all rows (kept readings, priors, candidates), `W A D^-1 = Q R`, gives coordinates `z = R D x`: there the rows of every
//! block are rows of `Q`, and a linear function `c'x` has the coordinates `T'c`, `T = D^-1 R^-1`; equations between unknowns are in `T`.
//!
//! A sweep in steps of 15 deg contains those in steps of 30, 45, 60, 90, 120 and 180.

use super::blocks::{Blocks, add_outer};
use super::candidates::{Unit, portions};
use super::effort::{Noise, grouped};
use super::objective::Objective;
use super::whitened::{Augmentation, Term, adjusted, mounted_apart, single, whitened, with_priors};
use crate::campaign::{Campaign, JointState, Reading, Readings};
use crate::design::{self, Model};
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use crate::estimate::Estimate;
use crate::fit::{self, RankDefect};
use crate::linear::normalise;
use faer::Mat;

/// Candidates, ready for exchanges.
#[derive(Debug, Clone)]
pub(super) struct Pool {
    /// Readings of each portion.
    pub portions: Vec<Vec<Reading>>,
    /// Their information in as few rows as its rank.
    pub blocks: Blocks,
    /// All their rows, not whitened with others: what is predicted there.
    pub rows: Blocks,
    /// Information of the kept readings and of priors, row by row.
    pub base: Vec<f64>,
    /// The factorisation behind the coordinates.
    pub estimate: Estimate,
    /// Unknowns after the parameters: deviations that link positions, and terms.
    pub augmentation: Augmentation,
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
        let further = mounted_apart(&portions, candidates);
        let augmentation = Augmentation::new(campaign, noise, terms, &[kept, &further]);
        let mut rows = with_priors(campaign, kept, noise, &augmentation)?;
        let fixed = rows.len();
        rows.extend(whitened(campaign, &further, noise, &augmentation, true)?);
        let total = rows.len();
        let estimate = adjusted(campaign, &rows, augmentation.columns(campaign))?;
        let rank = estimate.unknowns.rank;
        if rank <= augmentation.deviations.len() {
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
                rows: Vec::new().into(),
                point,
                predicted: Vec::new(),
                jacobian: Mat::zeros(0, 0),
                by_joint: Mat::zeros(0, 0),
                alike: [].into(),
            };
            fit::separations(&all, &model, &design, &estimate, &[])
        } else {
            Vec::new()
        };
        let directions = estimate.factor.whitened_directions();
        let rows = match noise.remount.is_empty() && campaign.scatter.is_empty() {
            true => whitened_rows.clone(),
            false => {
                // each reading by itself: nothing scatters, and deviations are zero
                let alone = Noise { remount: Vec::new(), lines: vec![0.0; noise.lines.len()], ..noise.clone() };
                let mut predicted = whitened(campaign, &further, &alone, &augmentation, true)?;
                for row in &mut predicted {
                    row.iter_mut().skip(campaign.unknowns()).take(augmentation.deviations.len()).for_each(|d| *d = 0.0);
                    *row = in_coordinates(&directions, row);
                }
                Blocks::from_fn(portions.len(), per_portion, rank, |j, r, c| {
                    // one list of coordinates for each row
                    predicted.get(j * per_portion + r).map_or(0.0, |row| row.at(c))
                })
            }
        };
        Ok(Pool {
            portions,
            blocks: whitened_rows.compressed(),
            rows,
            base,
            estimate,
            augmentation,
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
        self.blocks.unknowns().saturating_sub(self.augmentation.deviations.len())
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

    /// An objective of positions, from their own rows; `None` where they do not determine what the pool does. (Any but the determinant is a number of one
    /// meaning only where every parameter is determined.)
    pub(crate) fn value(
        &self,
        campaign: &Campaign,
        readings: &Readings,
        noise: &Noise,
        objective: &Objective,
    ) -> Result<Option<f64>> {
        if *objective != Objective::Determinant && self.determined() < campaign.unknowns() {
            return Ok(None);
        }
        let n = self.blocks.unknowns();
        let mut m = vec![0.0; n * n];
        for row in with_priors(campaign, readings, noise, &self.augmentation)? {
            add_outer(&mut m, 1.0, &in_coordinates(&self.directions, &row));
        }
        Ok(objective.value(&m, n))
    }

    /// Some of the portions, in the same coordinates.
    pub(crate) fn subset(&self, portions: &[usize]) -> Pool {
        Pool {
            portions: portions.iter().filter_map(|k| self.portions.get(*k).cloned()).collect(),
            blocks: self.blocks.subset(portions),
            ..self.clone()
        }
    }

    /// Portions with all angles on a coarser grid than all together, the coarsest first: steps of a turn, and which portions. None where the angles are on no
    /// common grid.
    pub(crate) fn coarser(&self) -> Vec<(usize, Vec<usize>)> {
        let mut states: Vec<&JointState> = Vec::new();
        for state in self.portions.iter().flatten().flat_map(|reading| &reading.joints) {
            if states.len() <= FINEST && !states.contains(&state) {
                states.push(state);
            }
        }
        let all = (1..=FINEST).find(|steps| states.iter().all(|state| is_on_grid(state, *steps)));
        let mut grids: Vec<(usize, Vec<usize>)> = Vec::new();
        for steps in (2..all.unwrap_or(0)).filter(|k| all.is_some_and(|all| all.is_multiple_of(*k))) {
            let on_grid = |reading: &Reading| reading.joints.iter().all(|state| is_on_grid(state, steps));
            let portions = self.portions.iter().enumerate().filter(|(_, portion)| portion.iter().all(on_grid));
            let list: Vec<usize> = portions.map(|(k, _)| k).collect();
            let earlier = grids.last().map_or(0, |(_, list)| list.len());
            if list.len() != earlier && list.len() < self.portions.len() {
                grids.push((steps, list));
            }
        }
        grids
    }

    /// Candidates that differ from each in the state of one joint (for coordinate exchange).
    pub(crate) fn neighbours(&self) -> Vec<Vec<usize>> {
        let mut lists: Vec<Vec<usize>> = vec![Vec::new(); self.portions.len()];
        // portions have readings
        let states = |portion: &Vec<Reading>| portion.first().map(|r| r.joints.to_vec()).unwrap_or_default();
        for joint in 0..self.portions.first().map_or(0, |portion| states(portion).len()) {
            let others = |portion: &Vec<Reading>| {
                let mut others = states(portion);
                others.remove(joint);
                format!("{others:?}")
            };
            for alike in grouped(self.portions.iter().enumerate().map(|(k, portion)| (k, others(portion)))) {
                for k in &alike {
                    lists.get_mut(*k).into_iter().for_each(|list| list.extend(&alike));
                }
            }
        }
        for list in &mut lists {
            list.sort_unstable();
            list.dedup();
        }
        lists
    }
}

/// `T'c`; a shorter `c` is padded with zeros.
pub(super) fn in_coordinates(directions: &Mat<f64>, c: &[f64]) -> Vec<f64> {
    let column = |k: usize| c.iter().enumerate().map(|(j, c)| directions[(j, k)] * c).sum();
    (0..directions.ncols()).map(column).collect()
}

/// Most steps of a turn that are taken as a sweep.
const FINEST: usize = 720;

/// Is an angle a multiple of a turn divided by `steps`? A joint that turns is on every grid.
fn is_on_grid(state: &JointState, steps: usize) -> bool {
    let Some(angle_deg) = state.held_deg() else { return true };
    let at = angle_deg / 360.0 * steps as f64;
    (at - at.round()).abs() < 1e-9
}
