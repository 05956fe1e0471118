//! The linear algebra that stands beside faer: products of columns, projections, and Cholesky's triangle of the small matrices which searches
//! factor by the thousand.
//!
//! Large or rank-deficient matrices go through faer and [`crate::estimate`] (column-pivoted QR). Products that differ on purpose say so by their
//! names or their places, and why at their heads: `compensated_dot` (twice the precision, for refinement), the reflections of `estimate/panel.rs`,
//! `estimate/eight.rs` and `estimate/small_qr.rs`, `determinant_and_trace` and `inverse_root` of the plans (clamped pivots, many candidates side by
//! side).

use crate::elements::Parts;
use faer::Mat;

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

/// `c' M c`.
pub(crate) fn form(matrix: &Mat<f64>, along: &[f64]) -> f64 {
    let n = matrix.nrows();
    let own: Vec<(usize, f64)> = along.iter().copied().enumerate().filter(|(j, c)| *c != 0.0 && *j < n).collect();
    own.iter().map(|(i, a)| own.iter().map(|(j, b)| a * b * matrix[(*i, *j)]).sum::<f64>()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_of_all_lengths() {
        // 1^2 + ... + n^2 = n (n + 1) (2 n + 1) / 6, exact in these sizes
        for n in [0_u32, 1, 7, 8, 9, 31] {
            let a: Vec<f64> = (1..=n).map(f64::from).collect();
            assert_eq!(dot(&a, &a), f64::from(n * (n + 1) * (2 * n + 1) / 6), "{n}");
        }
        assert_eq!(dot(&[1.0, 2.0, 3.0], &[4.0, 5.0]), 14.0);
        let a: Vec<f64> = (1..=31).map(f64::from).collect();
        assert_eq!(short_dot(&a, &a), dot(&a, &a));
        assert_eq!(norm(&[3.0, 4.0]), 5.0);
    }

    #[test]
    fn a_column_of_zeros_has_no_direction() {
        let (mut zero, mut own) = ([0.0; 3], [0.0, 3.0, 4.0]);
        assert_eq!((normalise(&mut zero), zero), (0.0, [0.0; 3]));
        assert_eq!((normalise(&mut own), own), (5.0, [0.0, 0.6, 0.8]));
        let mut left = [1.0, 2.0, 3.0];
        project(&mut left, &[[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]);
        assert_eq!(left, [0.0, 0.0, 3.0]);
    }

    /// `[[25, 15, -5], [15, 18, 0], [-5, 0, 11]] = L L'` with rows (5), (3, 3), (-1, 1, 3): the usual textbook example, in whole numbers.
    #[test]
    fn cholesky_in_whole_numbers() {
        let c = [[25.0, 15.0, -5.0], [15.0, 18.0, 0.0], [-5.0, 0.0, 11.0]];
        let triangle = Triangle::of(3, |i, j| c[i][j], |_| 0.0).unwrap();
        assert_eq!(triangle.rows, [vec![5.0], vec![3.0, 3.0], vec![-1.0, 1.0, 3.0]]);
        assert!((triangle.log_determinant() - 2025_f64.ln()).abs() < 1e-14);
        // C (1, 2, 3)' = (40, 51, 28)'
        let mut x = triangle.solve(&[40.0, 51.0, 28.0]);
        x.iter_mut().zip([1.0, 2.0, 3.0]).for_each(|(x, expected)| *x -= expected);
        assert!(x.iter().all(|left| left.abs() < 1e-14), "{x:?}");
        // adjugate over the determinant
        let inverse = [[198.0, -165.0, 90.0], [-165.0, 250.0, -75.0], [90.0, -75.0, 225.0]];
        for (own, expected) in triangle.inverse().iter().flatten().zip(inverse.iter().flatten()) {
            assert!((own - expected / 2025.0).abs() < 1e-16);
        }
        let upper = Triangle::of_upper(3, |i, j| [[5.0, 3.0, -1.0], [0.0, 3.0, 1.0], [0.0, 0.0, 3.0]][i][j]);
        assert_eq!(upper.rows, triangle.rows);
    }

    #[test]
    fn a_matrix_that_is_not_positive_definite_has_no_triangle() {
        let singular = [[1.0, 1.0], [1.0, 1.0]];
        assert!(Triangle::of(2, |i, j| singular[i][j], |_| 0.0).is_none());
        assert!(Triangle::of(1, |_, _| f64::NAN, |_| 0.0).is_none());
        assert!(Triangle::of(2, |i, j| if i == j { 1.0 } else { 1.0 - 1e-9 }, |_| 1e-6).is_none());
    }

    #[cfg(feature = "navigate")]
    #[test]
    fn directions_in_the_span_of_earlier_ones_are_left_out() {
        let columns = vec![vec![2.0, 0.0, 0.0], vec![0.0; 3], vec![1.0, 0.0, 0.0], vec![1.0, 0.0, 3.0]];
        assert_eq!(orthonormal(columns, 1e-9), [vec![1.0, 0.0, 0.0], vec![0.0, 0.0, 1.0]]);
    }
}
