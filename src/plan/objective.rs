//! Objectives that a design minimises, in the coordinates of the blocks, and their values.
//!
//! ```text
//! D: -log det M     A, c: tr(W M^-1)     G: max_i x_i' M^-1 x_i     E: lambda_max(T M^-1 T')     D of some unknowns: det(T M^-1 T')^(1/p)
//! ```
//!
//! (F. Pukelsheim, Optimal Design of Experiments, 1993, 6.4; D_s: A. C. Atkinson, A. N. Donev, R. D. Tobias, Optimum Experimental Designs, 2007, 10.3.)
#![allow(
    clippy::indexing_slicing,
    reason = "`Objective::fits` has made sure of a row at least and of the unknowns in each; packed triangles and lists are made here over the rows of a block, with one entry for each candidate or replacement"
)]

use super::blocks::{Blocks, add_outer, sandwich, times};
use crate::elements::Elements;
use crate::linear::{Triangle, dot};
use faer::{Mat, Side};

/// The objective that the exchange minimises, in the coordinates of the blocks.
#[derive(Debug, Clone, PartialEq)]
pub enum Objective {
    /// `-log det M`: D.
    Determinant,
    /// `tr(W M^-1)`, `W` symmetric and row by row: A, and c with `W = c c'`.
    Trace(Vec<f64>),
    /// The largest `x' M^-1 x` over all rows of these blocks: G.
    Largest(Blocks),
    /// The largest eigenvalue of `T M^-1 T'`: E.
    Eigenvalue(Combinations),
    /// `det(T M^-1 T')^(1/p)`, p rows of T: D of some of the unknowns; best in units in which all are of one size.
    Volume(Combinations),
}

/// Up to so many predicted rows, the sum of their variances approximates their largest.
const FEW: usize = 64;
impl Objective {
    /// Is it a function of `n` unknowns?
    pub(super) fn fits(&self, n: usize) -> bool {
        match self {
            Objective::Determinant => true,
            Objective::Trace(w) => w.len() == n * n,
            Objective::Largest(rows) => rows.unknowns() == n,
            Objective::Eigenvalue(functions) | Objective::Volume(functions) => {
                !functions.0.is_empty() && functions.0.iter().all(|row| row.len() == n)
            }
        }
    }

    /// Its value for `M^-1`, row by row; `None` for the determinant.
    pub(super) fn of(&self, inverse: &[f64]) -> Option<f64> {
        match self {
            Objective::Determinant => None,
            Objective::Trace(w) => Some(dot(w, inverse)),
            Objective::Largest(predicted) => Some(predicted.largest_quadratic(inverse)),
            Objective::Eigenvalue(functions) => Some(largest_eigenvalue(&functions.image(inverse))),
            Objective::Volume(functions) => {
                Some(functions.triangle(inverse).map_or(f64::NAN, |c| (c.log_determinant() / functions.size()).exp()))
            }
        }
    }

    /// Is it the largest of few variances?
    pub(super) fn is_of_few(&self) -> bool {
        matches!(self, Objective::Largest(predicted) if predicted.count() * predicted.rows() <= FEW)
    }

    /// The smooth objective that approximates it, the determinant or the sum of the variances; `None` for one that is smooth itself.
    pub(super) fn nearest(&self) -> Option<Objective> {
        match self {
            Objective::Determinant | Objective::Trace(_) => None,
            Objective::Largest(predicted) if self.is_of_few() => Some(Objective::Trace(predicted.sum())),
            Objective::Largest(_) | Objective::Volume(_) => Some(Objective::Determinant),
            Objective::Eigenvalue(functions) => Some(Objective::Trace(functions.sum())),
        }
    }
}

/// Linear functions of the unknowns: rows of `T`, in the coordinates of the blocks.
#[derive(Debug, Clone, PartialEq)]
pub struct Combinations(pub(super) Vec<Vec<f64>>);

impl Combinations {
    /// Each row is one function of the unknowns.
    pub fn new(rows: Vec<Vec<f64>>) -> Self {
        Combinations(rows)
    }

    /// How many functions.
    pub(super) fn size(&self) -> f64 {
        self.0.len().max(1) as f64
    }

    /// `T'T`: the weights of the sum of the variances.
    fn sum(&self) -> Vec<f64> {
        let n = self.0.first().map_or(0, Vec::len);
        let mut sum = vec![0.0; n * n];
        self.0.iter().for_each(|row| add_outer(&mut sum, 1.0, row));
        sum
    }

    /// `T A T'` for symmetric `A`, row by row.
    pub(super) fn image(&self, a: &[f64]) -> Mat<f64> {
        let along: Vec<Vec<f64>> = self.0.iter().map(|row| times(a, row)).collect();
        Mat::from_fn(self.0.len(), self.0.len(), |i, j| dot(&self.0[i], &along[j]))
    }

    /// Combination `T'v`.
    pub(super) fn combined(&self, v: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut sum = vec![0.0; self.0.first().map_or(0, Vec::len)];
        for (k, row) in self.0.iter().enumerate() {
            let by = v(k);
            sum.iter_mut().zip(row).for_each(|(sum, x)| *sum += by * x);
        }
        sum
    }

    /// `T' Z T`, row by row, for symmetric `Z`.
    pub(super) fn weighted(&self, z: impl Fn(usize, usize) -> f64) -> Vec<f64> {
        let n = self.0.first().map_or(0, Vec::len);
        let mut w = vec![0.0; n * n];
        for (i, row) in self.0.iter().enumerate() {
            let other = self.combined(|k| z(i, k));
            for (out, x) in w.chunks_exact_mut(n.max(1)).zip(row) {
                out.iter_mut().zip(&other).for_each(|(out, y)| *out += x * y);
            }
        }
        w
    }

    /// `log det C`, and `M^-1 T' C^-1 T M^-1` row by row, whose quadratic forms are the slopes; `None` where `C` is singular.
    pub(super) fn with_slopes(&self, inverse: &[f64]) -> Option<(f64, Vec<f64>)> {
        let c = self.triangle(inverse)?;
        let weights = c.inverse();
        let w = self.weighted(|i, k| weights[i].at(k));
        Some((c.log_determinant(), sandwich(inverse, &w, self.0.first().map_or(0, Vec::len))))
    }

    /// `C`, factored.
    fn triangle(&self, inverse: &[f64]) -> Option<Triangle> {
        let c = self.image(inverse);
        Triangle::of(c.nrows(), |i, j| c[(i, j)], |i| 1e-14 * c[(i, i)])
    }
}

/// Largest eigenvalue of a symmetric matrix; not a number where there is none.
pub(super) fn largest_eigenvalue(matrix: &Mat<f64>) -> f64 {
    match matrix.self_adjoint_eigenvalues(Side::Lower) {
        Ok(values) => values.into_iter().fold(f64::NEG_INFINITY, f64::max),
        Err(_) => f64::NAN,
    }
}
