//! The same estimate from rows that come in blocks: memory depends on the unknowns, not on the readings.

use super::basis::Combination;
use super::condition::condition;
use super::factor::Factor;
use super::{Group, Settings, System, refine};
use crate::error::{Fault, Malformed, Result};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::qr::no_pivoting::factor as qr;
use faer::{Mat, MatRef, Par};

/// Rows folded into the triangle of `W [A y] = Q [R z; 0 rho]`.
///
/// ```
/// use tumble::estimate::{Fold, Group, Settings};
/// let mut fold = Fold::new(1);
/// for reading in [1.0, 2.0, 6.0] {
///     fold.push(faer::mat![[1.0]].as_ref(), &[reading], &[1.0])?;
/// }
/// let mean = fold.finish(Group::Estimated(0), &Settings::default())?;
/// assert!((mean.solution[0] - 3.0).abs() < 1e-14 && (mean.sum_of_squares - 14.0).abs() < 1e-13);
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
#[derive(Debug, Clone)]
pub struct Fold {
    triangle: Mat<f64>,
    rows: usize,
}

/// An estimate without what belongs to single rows.
#[derive(Debug, Clone)]
pub struct Folded {
    /// Estimate of the unknowns, `n`; unknowns outside the basis are zero.
    pub solution: Vec<f64>,
    /// Number of independent columns.
    pub rank: usize,
    /// Whether the readings determine the unknown by itself, `n`.
    pub estimable: Vec<bool>,
    /// `(A' P A)^-1` with `P = 1/u^2`, `n x n`; zero outside the basis.
    pub cofactor: Mat<f64>,
    /// Covariance of the solution, `n x n`, with the scale; without degrees of freedom the scale enters as 1.
    pub covariance: Mat<f64>,
    /// Standard uncertainty of each unknown, `None` where there is none.
    pub standard_uncertainty: Vec<Option<f64>>,
    /// `sum (v/u)^2`.
    pub sum_of_squares: f64,
    /// Rows folded.
    pub rows: usize,
    /// Rows minus rank.
    pub dof: usize,
    /// The estimated scale, `None` where `u` is known or there are no degrees of freedom.
    pub scale: Option<f64>,
    /// Condition number as in [`super::Estimate::condition`].
    pub condition: Option<f64>,
    /// Directions in which the unknowns are free.
    pub not_estimable: Vec<Combination>,
    /// What is determined of the unknowns that are not estimable alone.
    pub estimable_combinations: Vec<Combination>,
}

impl Fold {
    /// Nothing folded yet, for `unknowns` columns.
    pub fn new(unknowns: usize) -> Self {
        Fold { triangle: Mat::zeros(unknowns + 1, unknowns + 1), rows: 0 }
    }

    /// Folds a block of rows, `k x n`, with their observed values and standard uncertainties, `k` each.
    ///
    /// Errors as [`super::adjust`]; a refused block leaves the fold as it was. Blocks of about `4 n` rows cost least.
    pub fn push(&mut self, rows: MatRef<'_, f64>, observed: &[f64], u: &[f64]) -> Result<()> {
        let size = self.triangle.ncols();
        let (k, n) = rows.shape();
        if n + 1 != size {
            return Err(Malformed::new(Fault::Value, "a block of rows has the wrong number of columns")
                .expected((size - 1).to_string())
                .found(n.to_string()));
        }
        let group = vec![Group::Known; k];
        let block = System { rows: rows.to_owned(), observed: observed.to_vec(), u: u.to_vec(), group };
        block.check()?;
        let work = Mat::from_fn(size + k, size, |i, j| match i.checked_sub(size) {
            None => self.triangle[(i, j)],
            Some(i) if j < n => block.rows[(i, j)] / u[i],
            Some(i) => observed[i] / u[i],
        });
        let largest = (0..size).flat_map(|j| work.col_as_slice(j)).fold(0.0_f64, |most, a| most.max(a.abs()));
        if largest > 1e150 {
            return Err(Malformed::new(
                Fault::Value,
                "a folded row, divided by its standard uncertainty, is too large",
            )
            .expected("units in which numbers stay below 1e150"));
        }
        self.triangle = triangle(work);
        self.rows += k;
        Ok(())
    }

    /// The triangle `[R z; 0 rho]` of all rows so far, `n + 1` square: it has the inner products of the weighted columns and observations.
    pub fn triangle(&self) -> MatRef<'_, f64> {
        self.triangle.as_ref()
    }

    /// The estimate from all rows so far; `group` says whether their uncertainties are known or relative.
    pub fn finish(&self, group: Group, settings: &Settings) -> Result<Folded> {
        let n = self.triangle.ncols() - 1;
        let rows = self.triangle.get(..n, ..n);
        let z: Vec<f64> = (0..n).map(|i| self.triangle[(i, n)]).collect();
        let factor = Factor::new(rows, vec![1.0; n], self.rows, settings.rank_tolerance)?;
        let fit = refine::solve(&factor, rows, &z, settings.refinements);
        let rest = self.triangle[(n, n)];
        let sum_of_squares = rest * rest + fit.residuals.iter().map(|v| v * v).sum::<f64>();
        let rank = factor.rank();
        let dof = self.rows.saturating_sub(rank);
        let cofactor = factor.cofactor();
        let mut covariance = cofactor.clone();
        let mut scale = None;
        if let Group::Estimated(_) = group
            && dof > 0
        {
            let variance = sum_of_squares / dof as f64;
            covariance *= faer::Scale(variance);
            scale = Some(variance.sqrt());
        }
        let estimable = factor.dependence.estimable(&factor.basis, n);
        let determined = group == Group::Known || scale.is_some();
        let standard_uncertainty =
            (0..n).map(|j| (estimable[j] && determined).then(|| covariance[(j, j)].sqrt())).collect();
        Ok(Folded {
            solution: fit.solution,
            rank,
            cofactor,
            covariance,
            standard_uncertainty,
            sum_of_squares,
            rows: self.rows,
            dof,
            scale,
            condition: condition(&factor.r),
            not_estimable: factor.dependence.not_estimable(&factor.basis, &factor.scale),
            estimable_combinations: factor.dependence.estimable_combinations(&factor.basis, &factor.scale),
            estimable,
        })
    }
}

/// From so many rows on a triangle is folded block by block: a factorisation of all rows at once would pack kilobytes for each.
const TALL: usize = 4096;
const BLOCK: usize = 1024;

/// The upper triangle `R` of `work = Q R`, `n x n`, for `work` with at least as many rows as columns.
///
/// Many rows go block by block, `[R; block] = Q' R'`: the same triangle but for signs of rows.
pub(super) fn triangle(work: Mat<f64>) -> Mat<f64> {
    let (m, n) = work.shape();
    if m <= TALL.max(8 * n) {
        return factorised(work);
    }
    let size = BLOCK.max(4 * n);
    let mut folded = factorised(work.subrows(0, size).to_owned());
    let mut start = size;
    while start < m {
        let count = size.min(m - start);
        let rows = work.subrows(start, count);
        folded = factorised(Mat::from_fn(n + count, n, |i, j| match i.checked_sub(n) {
            None => folded[(i, j)],
            Some(i) => rows[(i, j)],
        }));
        start += count;
    }
    folded
}

fn factorised(mut work: Mat<f64>) -> Mat<f64> {
    let (m, n) = work.shape();
    let block = qr::recommended_block_size::<f64>(m, n).clamp(1, n.max(1));
    let mut coefficients = Mat::zeros(block, n);
    let needed = qr::qr_in_place_scratch::<f64>(m, n, block, Par::Seq, Default::default());
    let mut memory = MemBuffer::new(needed);
    let stack = MemStack::new(&mut memory);
    qr::qr_in_place(work.as_mut(), coefficients.as_mut(), Par::Seq, stack, Default::default());
    Mat::from_fn(n, n, |i, j| if i <= j { work[(i, j)] } else { 0.0 })
}
