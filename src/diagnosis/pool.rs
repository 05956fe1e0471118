//! Columns that compete, orthogonalised against the model lazily: no column is ever copied or refitted.
//!
//! ```text
//! c' = (c - Q Q'c) / |c - Q Q'c|        score = c' . r        c'_a . c'_b = (c_a . c_b - Q'c_a . Q'c_b) / (n_a n_b)
//! ```
//!
//! `Q` is the orthonormal basis of the weighted model and `r` its weighted residuals. Only `Q'c` is kept; selecting a column appends its
//! direction to the basis and updates norms and scores by one product (updating QR in its lazy form; Å. Björck, Numerical Methods for
//! Least Squares Problems, 3.2).

use crate::elements::Elements;
use crate::linear::dot;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

/// A column is invisible when less than this share of its norm is left outside the model.
pub const VISIBLE: f64 = 1e-6;
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
    pub fn scores(&self) -> &[f64] {
        &self.score
    }

    /// Share of each column's weighted norm that the model leaves; 0 for those it leaves nothing of.
    pub fn visible(&self) -> &[f64] {
        &self.norm
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
    pub fn cosines(&self, a: usize) -> Vec<f64> {
        let (Some(&size), true) = (self.norm.get(a), a < self.columns.ncols()) else { return vec![0.0; self.len()] };
        let mut cosines = vec![0.0; self.len()];
        if size == 0.0 {
            return cosines;
        }
        let mut product = Mat::zeros(self.len(), 1);
        let (column, own) = (self.columns.as_ref().subcols(a, 1), self.along.as_ref().subcols(a, 1));
        matmul(product.as_mut(), Accum::Replace, self.columns.transpose(), column, 1.0, Par::Seq);
        matmul(product.as_mut(), Accum::Add, self.along.transpose(), own, -1.0, Par::Seq);
        for ((cosine, product), other) in cosines.iter_mut().zip(product.col_as_slice(0)).zip(&self.norm) {
            *cosine = if *other > 0.0 { product / (size * other) } else { 0.0 };
        }
        cosines
    }

    /// All cosines, `k x k`.
    pub fn all_cosines(&self) -> Mat<f64> {
        let k = self.len();
        let mut cosines = Mat::zeros(k, k);
        matmul(cosines.as_mut(), Accum::Replace, self.columns.transpose(), self.columns.as_ref(), 1.0, Par::Seq);
        matmul(cosines.as_mut(), Accum::Add, self.along.transpose(), self.along.as_ref(), -1.0, Par::Seq);
        for j in 0..k {
            let own = self.norm.at(j);
            for (value, other) in cosines.col_as_slice_mut(j).iter_mut().zip(&self.norm) {
                *value = if own > 0.0 && *other > 0.0 { *value / (own * other) } else { 0.0 };
            }
        }
        cosines
    }

    /// Forward selection: the column that explains most, then the one that explains most of what is left, and so on.
    ///
    /// Gives at most `most` indices and the drop of the sum of squares with each; stops where nothing is left to explain.
    ///
    /// ```
    /// use tumble::diagnosis::Pool;
    /// let columns = faer::mat![[1.0, 0.0], [0.0, 2.0], [0.0, 0.0]];
    /// let pool = Pool::new(columns, faer::Mat::zeros(3, 0).as_ref(), &[1.0, 3.0, 0.5]);
    /// assert_eq!(pool.forward(2), [(1, 9.0), (0, 1.0)]);
    /// ```
    pub fn forward(&self, most: usize) -> Vec<(usize, f64)> {
        let (mut left, mut score) = (vec![1.0; self.len()], self.score.clone());
        let mut basis: Vec<Vec<f64>> = Vec::new();
        let mut chosen: Vec<(usize, f64)> = Vec::new();
        while chosen.len() < most {
            crate::stop::poll();
            let gain = |j: usize| match (score.get(j), left.get(j)) {
                (Some(s), Some(n)) if *n > 1e-9 => s * s / n,
                _ => 0.0,
            };
            let best = (0..self.len()).map(|j| (j, gain(j))).fold((0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
            if !(best.1 > 0.0) {
                break;
            }
            chosen.push(best);
            if chosen.len() == most {
                break;
            }
            // the chosen column's direction against all others: one product, corrected for the directions before it
            let mut direction = self.cosines(best.0);
            for before in &basis {
                let own = before.at(best.0);
                direction.iter_mut().zip(before).for_each(|(d, b)| *d -= own * b);
            }
            let size = left.at(best.0).sqrt();
            let step = score.at(best.0) / size;
            for ((d, n), s) in direction.iter_mut().zip(&mut left).zip(&mut score) {
                *d /= size;
                *n -= *d * *d;
                *s -= *d * step;
            }
            if let Some(own) = left.get_mut(best.0) {
                *own = 0.0;
            }
            basis.push(direction);
        }
        chosen
    }
}

/// What is left of a column outside the basis, in place (twice, for orthogonality to rounding); gives its norm and scales it to that norm.
fn project(column: &mut [f64], q: MatRef<'_, f64>) -> f64 {
    for _ in 0..2 {
        for k in 0..q.ncols() {
            let basis = q.col(k);
            let along: f64 = basis.iter().zip(column.iter()).map(|(q, v)| q * v).sum();
            column.iter_mut().zip(basis.iter()).for_each(|(v, q)| *v -= along * q);
        }
    }
    dot(column, column).sqrt()
}
