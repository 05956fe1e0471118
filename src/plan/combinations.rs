//! What is asked for: functions of the unknowns, whose variances a plan makes small.

use super::blocks::add_outer;
use super::blocks::times;
use crate::linear::dot;
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

/// Largest eigenvalue of a symmetric matrix; not a number where there is none.
pub(super) fn largest_eigenvalue(matrix: &Mat<f64>) -> f64 {
    match matrix.self_adjoint_eigenvalues(Side::Lower) {
        Ok(values) => values.into_iter().fold(f64::NEG_INFINITY, f64::max),
        Err(_) => f64::NAN,
    }
}
