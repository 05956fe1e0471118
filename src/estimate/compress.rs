//! Each group's rows turned among themselves until a triangle says the same: `Q_g' [A_g y_g] / u = [R z; 0 rho; 0 0]`.
//!
//! An orthogonal change within a group alters neither the solution nor the group's sum of squares nor its share of the information, whatever
//! its scale. So the scales, and steps that need the solution alone, work on a few dozen rows instead of all.
#![allow(
    clippy::indexing_slicing,
    reason = "`adjust` runs `System::check` first: one observed value, u and group for each row, and `count` is above every group's number"
)]

use super::factor::Factor;
use super::fold::triangle_of;
use super::{Group, Settings, System};
use crate::error::Result;
use faer::Mat;
use std::ops::Range;

/// The rows of a system, group by group; the last group holds those of known uncertainty.
pub(super) struct Compressed {
    rows: Mat<f64>,
    pub observed: Vec<f64>,
    /// Which of the compressed rows belong to each group.
    pub range: Vec<Range<usize>>,
    /// How many rows each group had.
    pub size: Vec<usize>,
    /// `rho^2` and its degrees of freedom, what the group's own best fit leaves, where the group has more rows than columns.
    pub own: Vec<Option<(f64, usize)>>,
    /// Largest `|y / u|` of each group.
    pub magnitude: Vec<f64>,
    total: usize,
}

impl Compressed {
    /// Compresses a system with `count` estimated groups.
    pub fn new(system: &System, count: usize) -> Self {
        let (m, n) = system.shape();
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); count + 1];
        for (i, group) in system.group.iter().enumerate() {
            members[if let Group::Estimated(g) = group { *g } else { count }].push(i);
        }
        let mut blocks: Vec<(Vec<usize>, Mat<f64>)> = Vec::with_capacity(count + 1);
        let (mut size, mut own, mut magnitude) = (Vec::new(), Vec::new(), Vec::new());
        for rows in &members {
            let is_used = |j: &usize| rows.iter().any(|i| system.rows[(*i, *j)] != 0.0);
            let columns: Vec<usize> = (0..n).filter(is_used).collect();
            let k = columns.len();
            let element = |i: usize, l: usize| {
                let row = rows[i];
                columns.get(l).map_or(system.observed[row], |j| system.rows[(row, *j)]) / system.u[row]
            };
            size.push(rows.len());
            magnitude.push((0..rows.len()).fold(0.0_f64, |most, i| most.max(element(i, k).abs())));
            if rows.len() > k + 1 {
                let block = triangle_of(rows.len(), k + 1, element);
                own.push(Some((block[(k, k)].powi(2), rows.len() - k)));
                blocks.push((columns, block));
            } else {
                own.push(None);
                let block = Mat::from_fn(rows.len(), k + 1, element);
                blocks.push((columns, block));
            }
        }
        let kept = blocks.iter().map(|(_, block)| block.nrows()).sum();
        let mut compressed = Compressed {
            rows: Mat::zeros(kept, n),
            observed: vec![0.0; kept],
            range: Vec::with_capacity(count + 1),
            size,
            own,
            magnitude,
            total: m,
        };
        let mut start = 0;
        for (columns, block) in &blocks {
            let end = start + block.nrows();
            for (l, j) in columns.iter().enumerate() {
                compressed.rows.col_as_slice_mut(*j)[start..end].copy_from_slice(block.col_as_slice(l));
            }
            compressed.observed[start..end].copy_from_slice(block.col_as_slice(columns.len()));
            compressed.range.push(start..end);
            start = end;
        }
        compressed
    }

    /// Factorises the rows with these scales of the estimated groups.
    pub fn factor(&self, scale: impl Fn(usize) -> f64, settings: &Settings) -> Result<Factor> {
        let count = self.range.len() - 1;
        let mut weight = vec![1.0; self.observed.len()];
        for (g, range) in self.range.iter().enumerate().take(count) {
            weight[range.clone()].fill(1.0 / scale(g));
        }
        Factor::new(self.rows.as_ref(), weight, self.total, settings.rank_tolerance)
    }

    /// Solution and residuals of the compressed rows.
    pub fn solve(&self, factor: &Factor, refinements: usize) -> super::refine::Refined {
        super::refine::solve(factor, self.rows.as_ref(), &self.observed, refinements)
    }
}
