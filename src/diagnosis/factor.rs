//! Factors `F` of kernels `F F'`: columns, or where thousands of places deviate each by itself, the few rows of each.
//!
//! ```text
//! V^-1 beside the model = W - W Q (Q'W Q)^-1 Q'W,   W = (I + t^2 F F')^-1 = I - U S U',   s = t^2 l/(1 + t^2 l)
//! x'V^-1 y = x'y - a'S b - (A'S a)' M^-1 (A'S b),   M = I - A'S A,   a = U'x,  b = U'y,  A = U'Q,   x, y orthogonal to Q
//! ln |V| = sum ln(1 + t^2 l) + ln |M|
//! ```
//!
//! Columns without a common row are orthogonal as they are: they need no decomposition, where those of smooth kernels are projected first (`A = 0`).
#![allow(clippy::indexing_slicing, reason = "rows are those of the system that the factor was made for")]

use crate::linear::{Triangle, dot};
use faer::{Mat, MatRef};

/// More columns than this, no two of which have a row in common, are kept by their rows. A choice of speed: both ways say the same (`tests/kernels/navigate.rs`), and to decompose
/// `k` columns takes some `10 k^3` operations, a tenth of a second at 300.
pub(super) const MANY: usize = 300;

/// A factor.
#[derive(Clone)]
pub(crate) enum Factor {
    /// Columns of all rows.
    Dense(Mat<f64>),
    /// Of each column the rows that it has, with their values; no two columns have a row in common.
    Apart(Vec<Vec<(usize, f64)>>),
}

impl From<Mat<f64>> for Factor {
    fn from(columns: Mat<f64>) -> Self {
        Factor::Dense(columns)
    }
}

impl Factor {
    /// Every column in full.
    pub fn dense(self, rows: usize) -> Mat<f64> {
        match self {
            Factor::Dense(columns) => columns,
            Factor::Apart(columns) => {
                let mut all = Mat::zeros(rows, columns.len());
                columns.iter().enumerate().for_each(|(j, column)| column.iter().for_each(|(i, v)| all[(*i, j)] = *v));
                all
            }
        }
    }

    /// Those rows of it, in this order.
    pub fn of_rows(&self, rows: &[usize]) -> Factor {
        match self {
            Factor::Dense(columns) => {
                Factor::Dense(Mat::from_fn(rows.len(), columns.ncols(), |i, j| columns[(rows[i], j)]))
            }
            Factor::Apart(columns) => {
                let place: std::collections::HashMap<usize, usize> =
                    rows.iter().enumerate().map(|(i, row)| (*row, i)).collect();
                let part = |column: &Vec<(usize, f64)>| -> Vec<(usize, f64)> {
                    column.iter().filter_map(|(i, v)| Some((*place.get(i)?, *v))).collect()
                };
                Factor::Apart(columns.iter().map(part).filter(|column| !column.is_empty()).collect())
            }
        }
    }

    /// `x'F F'x`.
    pub fn form(&self, x: &[f64]) -> f64 {
        match self {
            Factor::Dense(columns) => (0..columns.ncols()).map(|j| dot(columns.col_as_slice(j), x).powi(2)).sum(),
            Factor::Apart(columns) => columns.iter().map(|column| sparse(column, x).powi(2)).sum(),
        }
    }
}

/// Product of a column with rows of its own and one of all rows.
pub(super) fn sparse(column: &[(usize, f64)], x: &[f64]) -> f64 {
    column.iter().map(|(i, v)| v * x[*i]).sum()
}

/// The directions of a factor of columns apart: its eigenvalues, and `U'x` of any columns.
pub(super) struct Apart<'a> {
    columns: &'a [Vec<(usize, f64)>],
    rows: usize,
    /// Has each column one row, so that `U` is a part of the identity, up to signs?
    single: bool,
}

impl<'a> Apart<'a> {
    pub fn new(columns: &'a [Vec<(usize, f64)>], rows: usize) -> Self {
        Apart { columns, rows, single: columns.iter().all(|column| column.len() == 1) }
    }

    /// Where each column has one row: nothing is multiplied, and the directions are all rows.
    pub fn is_single(&self) -> bool {
        self.single
    }

    pub fn eigenvalues(&self) -> Vec<f64> {
        let squares = self.columns.iter().map(|column| column.iter().map(|(_, v)| v * v).sum::<f64>());
        if !self.single {
            return squares.collect();
        }
        let mut all = vec![0.0; self.rows];
        self.columns.iter().flatten().zip(squares).for_each(|((i, _), square)| all[*i] = square);
        all
    }

    /// `U'x`.
    pub fn along(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        if self.single {
            return x.to_owned();
        }
        let norms: Vec<f64> = self.eigenvalues().into_iter().map(|l| l.max(f64::MIN_POSITIVE).sqrt()).collect();
        let of = |g: usize, j: usize| self.columns[g].iter().map(|(i, v)| v * x[(*i, j)]).sum::<f64>() / norms[g];
        Mat::from_fn(self.columns.len(), x.ncols(), of)
    }

    /// `F F'x`.
    pub fn twice(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        let mut all = Mat::zeros(self.rows, x.ncols());
        for j in 0..x.ncols() {
            for column in self.columns {
                let along: f64 = column.iter().map(|(i, v)| v * x[(*i, j)]).sum();
                column.iter().for_each(|(i, v)| all[(*i, j)] = along * v);
            }
        }
        all
    }
}

/// What the model takes of directions that are not projected, at one size.
pub(super) struct Reach {
    /// `S A`.
    shrunk: Mat<f64>,
    lower: Triangle,
}

impl Reach {
    /// `None` where the model takes all of it.
    pub fn new(along_q: &Mat<f64>, shrink: &[f64]) -> Option<Self> {
        let p = along_q.ncols();
        let shrunk = Mat::from_fn(along_q.nrows(), p, |i, j| shrink[i] * along_q[(i, j)]);
        let entry =
            |i: usize, j: usize| f64::from(u8::from(i == j)) - dot(shrunk.col_as_slice(i), along_q.col_as_slice(j));
        let lower = Triangle::of(p, entry, |_| 0.0)?;
        Some(Reach { shrunk, lower })
    }

    /// `L^-1 A'S a`, `M = L L'`: the products of these are what is taken off.
    pub fn of(&self, along: &[f64]) -> Vec<f64> {
        let mut taken: Vec<f64> = (0..self.shrunk.ncols()).map(|j| dot(self.shrunk.col_as_slice(j), along)).collect();
        self.lower.forward(&mut taken);
        taken
    }

    pub fn log_determinant(&self) -> f64 {
        self.lower.log_determinant()
    }
}
