//! Each group's rows turned among themselves until a triangle says the same: `Q_g' [A_g y_g] / u = [R z; 0 rho; 0 0]`.
//!
//! An orthogonal change within a group alters neither the solution nor the group's sum of squares nor its share of the information, whatever
//! its scale. So the scales, and steps that need the solution alone, work on a few dozen rows instead of all; of a record that is streamed there are no others.
#![allow(
    clippy::indexing_slicing,
    reason = "`adjust` runs `System::check` first: one observed value, u and group for each row, and `count` is above every group's number; blocks have as many columns"
)]

use super::factor::Factor;
use super::fold::{Fold, triangle_of};
use super::refine::{self, Refined};
use super::scatter::chain::Part as NoisePart;
use super::unknowns::Unknowns;
use super::{Settings, System};
use crate::error::Result;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use std::ops::Range;

/// Rows that say the same as those of a group.
#[derive(Debug, Clone)]
pub(crate) struct Block {
    /// Derivatives by the unknowns, over the rows' standard uncertainties; columns that are carried along may follow.
    pub rows: Mat<f64>,
    pub observed: Vec<f64>,
    /// How many rows the group had.
    pub size: usize,
    /// `rho^2` and its degrees of freedom, what the group's own best fit leaves, where the group has more rows than columns.
    pub own: Option<(f64, usize)>,
    /// Largest `|y / u|`.
    pub magnitude: f64,
    /// `ln |V|` of the noise that the rows were divided by.
    pub log_determinant: f64,
}

impl Block {
    /// Single unknowns of so many columns, each with its value and the standard uncertainty of that.
    pub fn stated(columns: usize, values: &[(usize, f64, f64)]) -> Self {
        let of = |i: usize, j: usize| values.get(i).filter(|(k, ..)| *k == j).map_or(0.0, |(.., u)| 1.0 / u);
        Block {
            rows: Mat::from_fn(values.len(), columns, of),
            observed: values.iter().map(|(_, value, u)| value / u).collect(),
            size: values.len(),
            own: None,
            magnitude: 0.0,
            log_determinant: 0.0,
        }
    }

    /// The triangle of a fold, observations about its point.
    pub fn folded(fold: &Fold) -> Self {
        let (triangle, n) = (fold.triangle(), fold.unknowns());
        let last = triangle.ncols() - 1;
        let observed: Vec<f64> = triangle.col(last).iter().copied().collect();
        let dof = fold.rows().saturating_sub(n);
        let own = (dof > 0).then(|| (observed[n..].iter().map(|rho| rho * rho).sum(), dof));
        let rows = triangle.subcols(0, last).to_owned();
        Block { rows, observed, size: fold.rows(), own, magnitude: 0.0, log_determinant: 0.0 }
    }

    /// What the rows say in some directions of the unknowns, a step away.
    pub fn part(&self, directions: &Mat<f64>, step: &[f64]) -> NoisePart {
        let rows = crate::linear::turned(&self.rows, &self.observed, directions, step);
        NoisePart::white(self.size as f64, self.log_determinant, gram(&rows))
    }
}

/// The rows of a system, group by group; behind those whose scale is estimated come those of known uncertainty.
pub(crate) struct Compressed {
    rows: Mat<f64>,
    observed: Vec<f64>,
    /// Which of the rows belong to each block.
    pub range: Vec<Range<usize>>,
    pub blocks: Vec<Block>,
    /// How many groups have a scale that is estimated.
    pub groups: usize,
    total: usize,
}

/// What compressed rows say of the unknowns.
pub(crate) struct Scaled {
    pub unknowns: Unknowns,
    pub sum_of_squares: f64,
    pub factor: Factor,
    /// Scale of each estimated group, 1 where there is none to be known.
    pub scale: Vec<f64>,
    /// Redundancy of each block.
    pub redundancy: Vec<f64>,
    /// Did the scales settle?
    pub settled: bool,
}

impl Compressed {
    /// Compresses a system with `count` estimated groups.
    pub fn new(system: &System, count: usize) -> Self {
        let n = system.rows.ncols();
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); count + 1];
        for (i, group) in system.group.iter().enumerate() {
            members[group.estimated().unwrap_or(count)].push(i);
        }
        let block = |rows: Vec<usize>| {
            let is_used = |j: &usize| rows.iter().any(|i| system.rows[(*i, *j)] != 0.0);
            let columns: Vec<usize> = (0..n).filter(is_used).collect();
            let k = columns.len();
            let element = |i: usize, l: usize| {
                let row = rows[i];
                columns.get(l).map_or(system.observed[row], |j| system.rows[(row, *j)]) / system.u[row]
            };
            let magnitude = (0..rows.len()).fold(0.0_f64, |most, i| most.max(element(i, k).abs()));
            let (folded, own) = match rows.len() > k + 1 {
                true => {
                    let folded = triangle_of(rows.len(), k + 1, element);
                    let own = (folded[(k, k)].powi(2), rows.len() - k);
                    (folded, Some(own))
                }
                false => (Mat::from_fn(rows.len(), k + 1, element), None),
            };
            let mut all = Mat::zeros(folded.nrows(), n);
            for (l, j) in columns.iter().enumerate() {
                all.col_as_slice_mut(*j).copy_from_slice(folded.col_as_slice(l));
            }
            let observed = folded.col_as_slice(k).to_vec();
            Block { rows: all, observed, size: rows.len(), own, magnitude, log_determinant: 0.0 }
        };
        Compressed::of(members.into_iter().map(block).collect(), n, count)
    }

    /// Of blocks in `n` unknowns, the first of which have a scale that is estimated.
    pub fn of(blocks: Vec<Block>, n: usize, groups: usize) -> Self {
        let kept = blocks.iter().map(|block| block.rows.nrows()).sum();
        let (mut rows, mut observed, mut range) = (Mat::zeros(kept, n), Vec::with_capacity(kept), Vec::new());
        for block in &blocks {
            let own = observed.len()..observed.len() + block.rows.nrows();
            rows.subrows_mut(own.start, own.len()).copy_from(block.rows.subcols(0, n));
            observed.extend(&block.observed);
            range.push(own);
        }
        let total = blocks.iter().map(|block| block.size).sum();
        Compressed { rows, observed, range, blocks, groups, total }
    }

    /// Factorises the rows with these scales of the estimated groups.
    pub(super) fn factor(&self, scale: impl Fn(usize) -> f64, settings: &Settings) -> Result<Factor> {
        let mut weight = vec![1.0; self.observed.len()];
        for (g, range) in self.range.iter().enumerate().take(self.groups) {
            weight[range.clone()].fill(1.0 / scale(g));
        }
        Factor::new(self.rows.as_ref(), weight, self.total, settings.rank_tolerance)
    }

    /// Solution and residuals of the compressed rows.
    pub(super) fn solve(&self, factor: &Factor, refinements: usize) -> Refined {
        refine::solve(factor, self.rows.as_ref(), &self.observed, refinements)
    }

    /// Norm of the weighted observations, and that of what a step makes of the weighted predictions.
    pub fn norms(&self, factor: &Factor, step: &[f64]) -> (f64, f64) {
        let norm = |values: &[f64]| values.iter().zip(&factor.weight).map(|(v, w)| (v * w).powi(2)).sum::<f64>().sqrt();
        let mut moved = vec![0.0; self.observed.len()];
        crate::linear::subtract(&mut moved, &self.rows, step);
        (norm(&self.observed), norm(&moved))
    }

    /// How the unknowns follow a column that is carried along, as if it had been observed. Errors: those of [`Factor::solve`].
    pub fn follow(&self, factor: &Factor, column: usize) -> Result<Vec<f64>> {
        let carried = |block: &Block| block.rows.col_as_slice(self.rows.ncols() + column).to_vec();
        factor.solve(&self.blocks.iter().flat_map(carried).collect::<Vec<f64>>())
    }
}

/// `A' A`.
pub(super) fn gram(rows: &Mat<f64>) -> Mat<f64> {
    let mut gram = Mat::zeros(rows.ncols(), rows.ncols());
    matmul(&mut gram, Accum::Replace, rows.transpose(), rows, 1.0, Par::Seq);
    gram
}
