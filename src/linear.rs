//! The linear algebra that stands beside faer: products of columns, projections, and Cholesky's triangle of the small matrices which searches
//! factor by the thousand.
//!
//! Large or rank-deficient matrices go through faer and [`crate::estimate`] (column-pivoted QR). Products that differ on purpose say so by their
//! names or their places, and why at their heads: `compensated_dot` (twice the precision, for refinement), the reflections of `estimate/panel.rs`,
//! `estimate/eight.rs` and `estimate/pivoted.rs`, `eliminate` and `roots` of the plans (many candidates side by side; pivots in order of size).

use crate::elements::Parts;
use faer::{Mat, MatRef};

/// Scalar product, in eight sums side by side (in order below eight elements); of columns of two lengths, the shorter counts.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        sums.iter_mut().zip(a.iter().zip(b)).for_each(|(sum, (a, b))| *sum += a * b);
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

/// The same in four sums: for columns of some tens of elements (triangles of unknowns), where eight would mostly be remainder.
pub(crate) fn short_dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let mut sums = [0.0; 4];
    for (a, b) in a.iter().zip(b) {
        sums.iter_mut().zip(a.iter().zip(b)).for_each(|(sum, (a, b))| *sum += a * b);
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    let [a, b, c, d] = sums;
    (a + b) + (c + d) + rest
}

/// Euclidean norm.
pub(crate) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// Divides a column by its norm, which comes back; a column of zeros stays.
pub(crate) fn normalise(column: &mut [f64]) -> f64 {
    let norm = norm(column);
    if norm > 0.0 {
        column.iter_mut().for_each(|v| *v /= norm);
    }
    norm
}

/// Takes the part along each direction (of unit norm, orthogonal to each other) out of a column; twice gives orthogonality to rounding.
pub(crate) fn project<D: AsRef<[f64]>>(column: &mut [f64], directions: &[D]) {
    for direction in directions {
        let along = dot(direction.as_ref(), column);
        column.iter_mut().zip(direction.as_ref()).for_each(|(v, d)| *v -= along * d);
    }
}

/// Takes out of a column what an orthonormal basis has of it, twice for orthogonality to rounding; each product in one sum.
pub(crate) fn project_out(column: &mut [f64], basis: MatRef<'_, f64>) {
    for direction in basis.col_iter().chain(basis.col_iter()) {
        let along: f64 = direction.iter().zip(column.iter()).map(|(q, v)| q * v).sum();
        column.iter_mut().zip(direction.iter()).for_each(|(v, q)| *v -= along * q);
    }
}

/// Orthonormal directions of the span of columns, one after the other, each projected twice; those whose squared norm outside the span of the
/// earlier ones is at most `least` of their own are left out.
#[cfg(feature = "navigate")]
pub(crate) fn orthonormal(columns: impl IntoIterator<Item = Vec<f64>>, least: f64) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for mut column in columns {
        let before = normalise(&mut column);
        project(&mut column, &basis);
        let left = normalise(&mut column);
        if before > 0.0 && left * left > least {
            project(&mut column, &basis);
            normalise(&mut column);
            basis.push(column);
        }
    }
    basis
}

/// Cholesky's lower triangle of a symmetric positive definite matrix, `C = L L'`; also from the `R` of a QR, `L = R'`.
#[derive(Debug, Clone)]
pub(crate) struct Triangle {
    /// Row i has i + 1 entries, the pivot last.
    rows: Vec<Vec<f64>>,
}

impl Triangle {
    /// Of the matrix `n x n` whose element (i, j), j <= i, is `entry(i, j)`; `None` where a squared pivot is not above `least(i)`.
    pub fn of(n: usize, entry: impl Fn(usize, usize) -> f64, least: impl Fn(usize) -> f64) -> Option<Self> {
        let mut rows: Vec<Vec<f64>> = Vec::with_capacity(n);
        for i in 0..n {
            let mut own: Vec<f64> = Vec::with_capacity(i + 1);
            for (j, earlier) in rows.iter().enumerate() {
                let (pivot, before) = earlier.split_last()?;
                own.push((entry(i, j) - dot(before, &own)) / pivot);
            }
            let square = entry(i, i) - dot(&own, &own);
            if !(square > least(i)) {
                return None;
            }
            own.push(square.sqrt());
            rows.push(own);
        }
        Some(Triangle { rows })
    }

    /// `L = R'` of an upper triangle whose element (i, j), i <= j, is `entry(i, j)`.
    pub fn of_upper(n: usize, entry: impl Fn(usize, usize) -> f64) -> Self {
        Triangle { rows: (0..n).map(|i| (0..=i).map(|j| entry(j, i)).collect()).collect() }
    }

    /// `L^-1 x`, in place; elements before `first` are known to be zero.
    fn forward_from(&self, first: usize, x: &mut [f64]) {
        for (i, row) in self.rows.iter().enumerate().skip(first) {
            let (before, own) = x.split_at_mut(i.min(x.len()));
            if let (Some((pivot, row)), Some(own)) = (row.split_last(), own.first_mut()) {
                let among = row.part(first..);
                *own = (*own - dot(among, before.part(first..))) / pivot;
            }
        }
    }

    /// `L^-1 x`, in place.
    pub fn forward(&self, x: &mut [f64]) {
        self.forward_from(0, x);
    }

    /// `L^-T x`, in place.
    pub fn backward(&self, x: &mut [f64]) {
        for (i, row) in self.rows.iter().enumerate().rev() {
            let (before, own) = x.split_at_mut(i.min(x.len()));
            if let (Some((pivot, row)), Some(own)) = (row.split_last(), own.first_mut()) {
                *own /= pivot;
                before.iter_mut().zip(row).for_each(|(x, l)| *x -= *own * l);
            }
        }
    }

    /// `C^-1 x`.
    pub fn solve(&self, x: &[f64]) -> Vec<f64> {
        let mut x = x.to_vec();
        self.forward(&mut x);
        self.backward(&mut x);
        x
    }

    /// Columns of `L^-1`.
    pub fn inverse_columns(&self) -> Vec<Vec<f64>> {
        let n = self.rows.len();
        let column = |j: usize| {
            let mut unit: Vec<f64> = (0..n).map(|i| f64::from(u8::from(i == j))).collect();
            self.forward_from(j, &mut unit);
            unit
        };
        (0..n).map(column).collect()
    }

    /// `C^-1 = L^-T L^-1`, row by row.
    pub fn inverse(&self) -> Vec<Vec<f64>> {
        let columns = self.inverse_columns();
        // both columns are zero before the later of their pivots
        let product = |(i, a): (usize, &Vec<f64>), (j, b): (usize, &Vec<f64>)| {
            let from = i.max(j);
            dot(a.part(from..), b.part(from..))
        };
        columns.iter().enumerate().map(|a| columns.iter().enumerate().map(|b| product(a, b)).collect()).collect()
    }

    /// `ln det C`.
    pub fn log_determinant(&self) -> f64 {
        self.rows.iter().filter_map(|row| row.last()).map(|pivot| 2.0 * pivot.ln()).sum()
    }
}

/// `y - A x`, for the first columns of `rows`, in place.
pub(crate) fn subtract(observed: &mut [f64], rows: &Mat<f64>, x: &[f64]) {
    for (j, x) in x.iter().enumerate().take(rows.ncols()).filter(|(_, x)| **x != 0.0) {
        observed.iter_mut().zip(rows.col_as_slice(j)).for_each(|(v, a)| *v -= a * x);
    }
}

/// The first columns of `rows` in some directions, and behind them what a step leaves of the observations.
pub(crate) fn turned(rows: &Mat<f64>, observed: &[f64], directions: &Mat<f64>, step: &[f64]) -> Mat<f64> {
    let (n, r) = directions.shape();
    let mut out = Mat::zeros(rows.nrows(), r + 1);
    out.subcols_mut(0, r).copy_from(rows.subcols(0, n) * directions);
    out.col_as_slice_mut(r).copy_from_slice(observed);
    subtract(out.col_as_slice_mut(r), rows, step);
    out
}

/// Condition number in the 2-norm, `sigma_max / sigma_min`; `None` for an empty matrix, and for one that is singular.
pub(crate) fn condition(matrix: &Mat<f64>) -> Option<f64> {
    let values = matrix.singular_values().ok()?;
    // the largest is the first
    let (most, least) = values.first().zip(values.last())?;
    (*least > 0.0).then(|| most / least)
}

/// `c' M c`.
pub(crate) fn form(matrix: &Mat<f64>, along: &[f64]) -> f64 {
    let n = matrix.nrows();
    let own: Vec<(usize, f64)> = along.iter().copied().enumerate().filter(|(j, c)| *c != 0.0 && *j < n).collect();
    own.iter().map(|(i, a)| own.iter().map(|(j, b)| a * b * matrix[(*i, *j)]).sum::<f64>()).sum()
}
