//! Objectives that a design minimises, in the coordinates of the blocks, and their values.
//!
//! ```text
//! D: -log det M     A, c: tr(W M^-1)     G: max_i x_i' M^-1 x_i     E: lambda_max(T M^-1 T')     D of some unknowns: det(T M^-1 T')^(1/p)
//! ```
//!
//! (F. Pukelsheim, Optimal Design of Experiments, 1993, 6.4; D_s: A. C. Atkinson, A. N. Donev, R. D. Tobias, Optimum Experimental Designs, 2007, 10.3.)
#![allow(
    clippy::indexing_slicing,
    reason = "criteria and goals have a row at least, each in the coordinates of the pool; packed triangles and lists are made here over the rows of a block, with one entry for each candidate or replacement"
)]

use super::blocks::{Blocks, invert, largest, packed, sandwich, square};
use crate::linear::{Triangle, dot};
use faer::{Mat, Side};

/// The objective that the exchange minimises, in the coordinates of the blocks.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Objective {
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
pub(super) const FEW: usize = 64;

impl Objective {
    /// Its value for an information matrix of `n` unknowns; `None` where that is singular.
    pub(super) fn value(&self, m: &[f64], n: usize) -> Option<f64> {
        crate::stop::poll();
        let (inverse, log_det) = invert(m, n)?;
        Some(match self {
            Objective::Determinant => -log_det,
            Objective::Trace(w) => dot(w, &inverse),
            Objective::Largest(_) | Objective::Eigenvalue(_) => self.worst(&inverse).map_or(f64::NAN, |(most, _)| most),
            Objective::Volume(functions) => {
                functions.triangle(&inverse).map_or(f64::NAN, |c| (c.log_determinant() / functions.size()).exp())
            }
        })
    }

    /// The largest of several variances, and the function of the unknowns that has it; `None` for another objective, and where nothing is finite.
    pub(super) fn worst(&self, inverse: &[f64]) -> Option<(f64, Vec<f64>)> {
        match self {
            Objective::Largest(predicted) => {
                let sums = predicted.quadratics(inverse);
                let of_row = |r: usize| (largest(&sums[packed(r, r)]), r);
                let ((j, most), r) = (0..predicted.rows()).map(of_row).max_by(|a, b| a.0.1.total_cmp(&b.0.1))?;
                Some((most, predicted.row(j, r)))
            }
            Objective::Eigenvalue(functions) => {
                let eigen = functions.image(inverse).self_adjoint_eigen(Side::Lower).ok()?;
                // eigenvalues come in nondecreasing order
                let last = functions.0.nrows() - 1;
                let direction = functions.0.transpose() * eigen.U().col(last);
                Some((eigen.S()[last], direction.iter().copied().collect()))
            }
            _ => None,
        }
    }

    /// The matrix whose quadratic forms, beside those of `M^-1`, say what a row changes: `M^-1 W M^-1`, or the covariance of the other unknowns for known
    /// functions; `None` for another objective, and where a volume is singular.
    pub(super) fn second(&self, inverse: &[f64]) -> Option<Vec<f64>> {
        match self {
            Objective::Trace(w) => Some(sandwich(inverse, w, w.len().isqrt())),
            Objective::Volume(functions) => {
                let (_, slopes) = functions.with_slopes(inverse)?;
                Some(inverse.iter().zip(&slopes).map(|(all, part)| all - part).collect())
            }
            _ => None,
        }
    }

    /// How many variances it is the largest of.
    pub(super) fn size(&self) -> usize {
        match self {
            Objective::Largest(predicted) => predicted.count() * predicted.rows(),
            Objective::Eigenvalue(functions) => functions.0.nrows(),
            _ => 1,
        }
    }

    /// Is it the largest of few variances?
    pub(super) fn is_of_few(&self) -> bool {
        matches!(self, Objective::Largest(_)) && self.size() <= FEW
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
pub(super) struct Combinations(pub(super) Mat<f64>);

impl Combinations {
    /// Each row is one function of the unknowns.
    pub fn new(rows: Vec<Vec<f64>>) -> Self {
        Combinations(Mat::from_fn(rows.len(), rows.first().map_or(0, Vec::len), |i, j| rows[i][j]))
    }

    /// How many functions.
    pub(super) fn size(&self) -> f64 {
        self.0.nrows().max(1) as f64
    }

    /// `T'T`: the weights of the sum of the variances.
    pub(super) fn sum(&self) -> Vec<f64> {
        self.weighted(&Mat::identity(self.0.nrows(), self.0.nrows()))
    }

    /// `T A T'` for symmetric `A`, row by row.
    pub(super) fn image(&self, a: &[f64]) -> Mat<f64> {
        &self.0 * square(a, self.0.ncols()) * self.0.transpose()
    }

    /// `T' Z T`, row by row, for symmetric `Z`.
    pub(super) fn weighted(&self, z: &Mat<f64>) -> Vec<f64> {
        let w = self.0.transpose() * z * &self.0;
        w.col_iter().flat_map(|column| column.iter().copied()).collect()
    }

    /// `log det C`, and `M^-1 T' C^-1 T M^-1` row by row, whose quadratic forms are the slopes; `None` where `C` is singular.
    pub(super) fn with_slopes(&self, inverse: &[f64]) -> Option<(f64, Vec<f64>)> {
        let c = self.triangle(inverse)?;
        let weights = c.inverse();
        let w = self.weighted(&Mat::from_fn(weights.len(), weights.len(), |i, k| weights[i][k]));
        Some((c.log_determinant(), sandwich(inverse, &w, self.0.ncols())))
    }

    /// `C`, factored.
    fn triangle(&self, inverse: &[f64]) -> Option<Triangle> {
        let c = self.image(inverse);
        Triangle::of(c.nrows(), |i, j| c[(i, j)], |i| 1e-14 * c[(i, i)])
    }
}
