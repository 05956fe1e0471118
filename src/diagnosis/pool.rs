//! Columns that compete, orthogonalised against the model lazily: no column is ever copied or refitted.
//!
//! ```text
//! c' = (c - Q Q'c) / |c - Q Q'c|        score = c' . r        c'_a . c'_b = (c_a . c_b - Q'c_a . Q'c_b) / (n_a n_b)
//! ```
//!
//! `Q` is the orthonormal basis of the weighted model and `r` its weighted residuals. Only `Q'c` is kept
//! (QR in its lazy form; Å. Björck, Numerical Methods for Least Squares Problems, 3.2).

use crate::elements::Elements;
use crate::linear::{dot, project_out};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

/// A column is invisible when less than this share of its norm is left outside the model.
pub(crate) const VISIBLE: f64 = 1e-6;
/// Columns with less left than this are projected explicitly, so that cancellation costs no digits.
const CANCELLING: f64 = 1e-3;

/// Competing columns against one model.
#[derive(Debug, Clone)]
pub struct Pool {
    columns: Mat<f64>,
    along: Mat<f64>,
    norm: Vec<f64>,
    score: Vec<f64>,
}

impl Pool {
    /// Weighted columns, `m x k` (any norm), against the basis `q`, `m x r`, and the residuals, `m`.
    pub fn new(mut columns: Mat<f64>, q: MatRef<'_, f64>, residual: &[f64]) -> Self {
        let k = columns.ncols();
        for j in 0..k {
            let column = columns.col_as_slice_mut(j);
            let largest = column.iter().fold(0.0_f64, |largest, v| largest.max(v.abs()));
            if largest > 0.0 && largest.is_finite() {
                column.iter_mut().for_each(|v| *v /= largest);
                let norm = dot(column, column).sqrt();
                column.iter_mut().for_each(|v| *v /= norm);
            } else {
                column.fill(0.0);
            }
        }
        let mut along = Mat::zeros(q.ncols(), k);
        matmul(along.as_mut(), Accum::Replace, q.transpose(), columns.as_ref(), 1.0, Par::Seq);
        let mut norm = Vec::with_capacity(k);
        let mut score = Vec::with_capacity(k);
        for j in 0..k {
            let left = 1.0 - dot(along.col_as_slice(j), along.col_as_slice(j));
            let mut size = left.max(0.0).sqrt();
            if size < CANCELLING {
                size = project(columns.col_as_slice_mut(j), q);
                along.col_as_slice_mut(j).fill(0.0);
            }
            let visible = size > VISIBLE && columns.col_as_slice(j).iter().any(|v| *v != 0.0);
            norm.push(if visible { size } else { 0.0 });
            score.push(if visible { dot(columns.col_as_slice(j), residual) / size } else { 0.0 });
        }
        Pool { columns, along, norm, score }
    }

    /// How many columns compete.
    pub fn len(&self) -> usize {
        self.norm.len()
    }

    /// Is there none?
    pub fn is_empty(&self) -> bool {
        self.norm.is_empty()
    }

    /// Scores against the model alone: the drop of the sum of squares is the square.
    ///
    /// ```
    /// use tumble::diagnosis::Pool;
    /// let columns = faer::mat![[1.0, 0.0], [0.0, 2.0], [0.0, 0.0]];
    /// let pool = Pool::new(columns, faer::Mat::zeros(3, 0).as_ref(), &[1.0, 3.0, 0.5]);
    /// assert_eq!(pool.scores(), [1.0, 3.0]);
    /// ```
    pub fn scores(&self) -> &[f64] {
        &self.score
    }

    /// Share of each column's weighted norm that the model leaves; 0 for those it leaves nothing of.
    pub(crate) fn visible(&self) -> &[f64] {
        &self.norm
    }

    /// How many directions are distinct, by their scores: columns of one direction have one, and chance does not repeat nine digits.
    pub(super) fn distinct(&self) -> usize {
        let visible = self.score.iter().zip(&self.norm).filter(|(_, left)| **left > 0.0);
        let mut sizes: Vec<f64> = visible.map(|(score, _)| score.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        sizes.dedup_by(|a, b| (*a - *b).abs() <= 1e-9 * a.abs().max(b.abs()));
        sizes.len()
    }

    /// Column `a` outside the model, of norm one; zero where the model leaves nothing of it.
    pub(super) fn direction(&self, a: usize, q: MatRef<'_, f64>) -> Vec<f64> {
        let Some(&size) = self.norm.get(a).filter(|size| **size > 0.0) else { return vec![0.0; self.columns.nrows()] };
        let mut direction = self.columns.col_as_slice(a).to_vec();
        for (k, along) in self.along.col_as_slice(a).iter().enumerate().take(q.ncols()) {
            direction.iter_mut().zip(q.col(k).iter()).for_each(|(v, q)| *v -= along * q);
        }
        direction.iter_mut().for_each(|v| *v /= size);
        direction
    }

    /// Cosines between column `a` and all columns, both orthogonalised.
    pub(crate) fn cosines(&self, a: usize) -> Vec<f64> {
        let (Some(&size), true) = (self.norm.get(a), a < self.columns.ncols()) else { return vec![0.0; self.len()] };
        let mut cosines = vec![0.0; self.len()];
        if size == 0.0 {
            return cosines;
        }
        let mut product = Mat::zeros(self.len(), 1);
        let (column, along) = (self.columns.as_ref().subcols(a, 1), self.along.as_ref().subcols(a, 1));
        matmul(product.as_mut(), Accum::Replace, self.columns.transpose(), column, 1.0, Par::Seq);
        matmul(product.as_mut(), Accum::Add, self.along.transpose(), along, -1.0, Par::Seq);
        for ((cosine, product), other) in cosines.iter_mut().zip(product.col_as_slice(0)).zip(&self.norm) {
            *cosine = if *other > 0.0 { product / (size * other) } else { 0.0 };
        }
        cosines
    }

    /// All cosines, `k x k`.
    pub(crate) fn all_cosines(&self) -> Mat<f64> {
        let k = self.len();
        let mut cosines = Mat::zeros(k, k);
        matmul(cosines.as_mut(), Accum::Replace, self.columns.transpose(), self.columns.as_ref(), 1.0, Par::Seq);
        matmul(cosines.as_mut(), Accum::Add, self.along.transpose(), self.along.as_ref(), -1.0, Par::Seq);
        for j in 0..k {
            let norm = self.norm.at(j);
            for (value, other) in cosines.col_as_slice_mut(j).iter_mut().zip(&self.norm) {
                *value = if norm > 0.0 && *other > 0.0 { *value / (norm * other) } else { 0.0 };
            }
        }
        cosines
    }
}

/// What is left of a column outside the basis, in place (twice, for orthogonality to rounding); gives its norm and scales it to that norm.
fn project(column: &mut [f64], q: MatRef<'_, f64>) -> f64 {
    project_out(column, q);
    dot(column, column).sqrt()
}
