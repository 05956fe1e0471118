//! What is asked for: functions of the unknowns, whose variances a plan makes small.

use super::blocks::{add_outer, sandwich, times};
use crate::elements::Elements;
use crate::linear::{Triangle, dot};
use faer::{Mat, Side};

/// What is asked for: rows of `T`, in the coordinates of the blocks.
#[derive(Debug, Clone, PartialEq)]
pub struct Combinations(pub(super) Vec<Vec<f64>>);

impl Combinations {
    /// Each row one function of the unknowns.
    pub fn new(rows: Vec<Vec<f64>>) -> Self {
        Combinations(rows)
    }

    /// Has every row so many elements, and is there one?
    pub(super) fn fits(&self, unknowns: usize) -> bool {
        !self.0.is_empty() && self.0.iter().all(|row| row.len() == unknowns)
    }

    /// `T'T`: the smooth criterion that is nearest, the sum of the variances.
    pub(super) fn sum(&self) -> Vec<f64> {
        let n = self.0.first().map_or(0, Vec::len);
        let mut sum = vec![0.0; n * n];
        self.0.iter().for_each(|row| add_outer(&mut sum, 1.0, row));
        sum
    }

    /// `T A T'` for symmetric `A`, row by row.
    pub(super) fn image(&self, a: &[f64]) -> Mat<f64> {
        let along: Vec<Vec<f64>> = self.0.iter().map(|row| times(a, row)).collect();
        let element = |i: usize, j: usize| along.get(j).zip(self.0.get(i)).map_or(0.0, |(w, row)| dot(row, w));
        Mat::from_fn(self.0.len(), self.0.len(), element)
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
}

/// Functions of the unknowns whose common volume is made small.
#[derive(Debug, Clone, PartialEq)]
pub struct Volume(pub(super) Combinations);

impl Volume {
    /// Each row one function of the unknowns; best in units in which all are of one size.
    pub fn new(rows: Vec<Vec<f64>>) -> Self {
        Volume(Combinations::new(rows))
    }

    /// How many functions.
    pub(super) fn size(&self) -> f64 {
        self.0.0.len().max(1) as f64
    }

    /// `log det C`, and `M^-1 T' C^-1 T M^-1` row by row, whose quadratic forms are the slopes; `None` where `C` is singular.
    pub(super) fn with_slopes(&self, inverse: &[f64]) -> Option<(f64, Vec<f64>)> {
        let c = self.triangle(inverse)?;
        let n = self.0.0.first().map_or(0, Vec::len);
        let mut w = vec![0.0; n * n];
        for (row, weights) in self.0.0.iter().zip(c.inverse()) {
            let other = self.0.combined(|k| weights.at(k));
            for (out, v) in w.chunks_exact_mut(n.max(1)).zip(row) {
                out.iter_mut().zip(&other).for_each(|(out, o)| *out += v * o);
            }
        }
        Some((c.log_determinant(), sandwich(inverse, &w, n)))
    }

    /// `C`, factored.
    pub(super) fn triangle(&self, inverse: &[f64]) -> Option<Triangle> {
        let c = self.0.image(inverse);
        let p = c.nrows();
        Triangle::of(p, |i, j| c[(i, j)], |i| 1e-14 * c[(i, i)])
    }
}

/// Largest eigenvalue of a symmetric matrix; not a number where there is none.
pub(super) fn largest_eigenvalue(matrix: &Mat<f64>) -> f64 {
    match matrix.self_adjoint_eigenvalues(Side::Lower) {
        Ok(values) => values.into_iter().fold(f64::NEG_INFINITY, f64::max),
        Err(_) => f64::NAN,
    }
}
