//! What rows say of the unknowns, whether all of them are at hand or only their triangle.
#![allow(
    clippy::indexing_slicing,
    reason = "`Factor` makes the cofactor square and the list of estimable unknowns as long as its columns"
)]

use super::basis::Combination;
use super::factor::Factor;
use faer::Mat;

/// The part of an estimate that belongs to the unknowns: of [`super::Estimate`] and of [`super::Folded`].
#[derive(Debug, Clone)]
pub struct Unknowns {
    /// Best linear unbiased estimate, `n`. Unknowns outside the basis are zero (a basic solution); of a [`super::Folded`], what its first block left
    /// them at.
    pub solution: Vec<f64>,
    /// Number of independent columns.
    pub rank: usize,
    /// Whether the readings determine the unknown by itself, `n`.
    pub estimable: Vec<bool>,
    /// `(A' P A)^-1` with `P = 1/u^2` (`1/(s_g u)^2` where several scales were estimated), `n x n`; zero outside the basis.
    pub cofactor: Mat<f64>,
    /// Covariance of the solution, `n x n`; a scale that is not determined enters as 1, so see `standard_uncertainty`.
    pub covariance: Mat<f64>,
    /// Standard uncertainty of each unknown; `None` where it is not estimable, or depends on a scale that is not determined.
    pub standard_uncertainty: Vec<Option<f64>>,
    /// The triangle of the weighted, column-scaled basis.
    pub(crate) triangle: Mat<f64>,
    /// What the readings leave free, one combination of few unknowns per rank defect.
    pub not_estimable: Vec<Combination>,
    /// Along which direction it is free: unknowns may move along it and no reading changes. In the same order.
    pub free_directions: Vec<Combination>,
    /// What is determined of the unknowns that are not estimable alone.
    pub estimable_combinations: Vec<Combination>,
}

impl Unknowns {
    /// From a factorisation, the solution by it, the common variance factor and whose uncertainties are determined.
    pub(super) fn new(
        factor: &Factor,
        solution: Vec<f64>,
        variance: f64,
        has_uncertainty: impl Fn(usize) -> bool,
    ) -> Unknowns {
        let (n, cofactor) = (solution.len(), factor.cofactor());
        let covariance = &cofactor * faer::Scale(variance);
        let estimable = factor.dependence.estimable(&factor.basis, n);
        let standard_uncertainty =
            (0..n).map(|j| (estimable[j] && has_uncertainty(j)).then(|| covariance[(j, j)].sqrt())).collect();
        Unknowns {
            solution,
            rank: factor.rank(),
            estimable,
            cofactor,
            covariance,
            standard_uncertainty,
            triangle: factor.r.clone(),
            not_estimable: factor.dependence.not_estimable(&factor.basis, &factor.scale),
            free_directions: factor.dependence.directions(&factor.basis, &factor.scale),
            estimable_combinations: factor.dependence.estimable_combinations(&factor.basis, &factor.scale),
        }
    }

    /// Condition number in the 2-norm of the weighted, column-scaled basis; `None` if it is empty.
    pub fn condition(&self) -> Option<f64> {
        crate::linear::condition(&self.triangle)
    }

    /// Is this unknown determined by the rows? Nothing beyond the unknowns is.
    pub(crate) fn is_estimable(&self, unknown: usize) -> bool {
        self.estimable.get(unknown) == Some(&true)
    }

    /// Is every number finite?
    pub(super) fn is_finite(&self) -> bool {
        let matrices = [&self.cofactor, &self.covariance];
        let entries = matrices.into_iter().flat_map(|matrix| (0..matrix.ncols()).flat_map(|j| matrix.col_as_slice(j)));
        self.solution.iter().chain(entries).all(|value| value.is_finite())
    }
}
