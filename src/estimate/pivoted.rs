//! A pivoted QR before anything is said about rank: faer's, or for few rows that of `small_qr.rs`.

use faer::Mat;

/// A pivoted QR of some columns, before anything is said about rank.
pub(super) struct Pivoted {
    /// Thin, `m x min(m, k)`.
    pub q: Mat<f64>,
    /// Upper trapezoidal, `min(m, k) x k`; below its diagonal lies what faer keeps there.
    pub r: Mat<f64>,
    /// Columns in pivot order.
    pub order: Vec<usize>,
    /// How many leading diagonal elements stand above the tolerance.
    pub rank: usize,
}

impl Pivoted {
    /// Whether a column behind the first negligible one is not negligible.
    pub fn hides_a_larger_column(&self, tolerance: f64) -> bool {
        let (size, k, rank) = (self.r.nrows(), self.r.ncols(), self.rank);
        let Some(limit) = (rank < size).then(|| tolerance * self.r[(0, 0)].abs()) else { return false };
        (rank + 1..k).any(|j| {
            let squares: f64 = (rank..size.min(j + 1)).map(|i| self.r[(i, j)].powi(2)).sum();
            squares.sqrt() > limit
        })
    }
}
