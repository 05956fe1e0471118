//! Weighted, column-scaled, column-pivoted QR: `W A D^-1 P = Q R`, solutions by it, and what it says of the unknowns, whether the rows are at hand or folded.
//!
//! The factorisation is faer's, sequential: Householder reflections with column pivoting, thin `Q` formed explicitly so
//! that leverages and projections cost one pass. See G. H. Golub, C. F. Van Loan, Matrix Computations, 5.4-5.5.
#![allow(
    clippy::indexing_slicing,
    reason = "`r` and `r_inverse` are rank by rank and `basis` has rank entries below the number of columns, of which `scale` has one each; callers' columns go through `check_rows`"
)]

use super::basis::{self, Combination, Coupling, Dependence};
use super::compensated::{accumulate, compensated_dot};
use super::pivoted::substitute;
use crate::error::{Fault, Malformed, Result};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

/// The factorisation behind an estimate: `W A D^-1` restricted to independent columns equals `Q R`.
///
/// `W = diag(1/u)`, `D` = norms of the weighted columns. Column `k` of `Q` and `R` belongs to unknown `basis()[k]`.
#[derive(Debug, Clone)]
pub struct Factor {
    pub(super) q: Mat<f64>,
    pub(super) r: Mat<f64>,
    pub(super) r_inverse: Mat<f64>,
    pub(super) basis: Vec<usize>,
    pub(super) dependence: Dependence,
    pub(super) weight: Vec<f64>,
    pub(super) scale: Vec<f64>,
    pub(super) tolerance: f64,
    /// Where some unknowns were eliminated: how all follow those that were kept.
    pub(super) embedding: Option<Embedding>,
}

/// All unknowns from those that were kept: `x = offset + lift t`, the offset being in the solution.
#[derive(Debug, Clone)]
pub(super) struct Embedding {
    /// `n x kept`.
    pub lift: Mat<f64>,
    /// The basis in the user's numbering.
    pub basis: Vec<usize>,
    /// Column scales, `n`; 1 for the eliminated.
    pub scale: Vec<f64>,
}

/// `A B'` for `B` with any number of rows, block by block: a product with all rows at once would pack kilobytes for each.
pub(crate) fn product_by_rows(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let mut product = Mat::zeros(a.nrows(), b.nrows());
    let mut start = 0;
    while start < b.nrows() {
        let count = BLOCK.min(b.nrows() - start);
        let (rows, out) = (b.subrows(start, count), product.subcols_mut(start, count));
        matmul(out, Accum::Replace, a, rows.transpose(), 1.0, Par::Seq);
        start += count;
    }
    product
}

/// The share of the largest pivot below which a column depends on others, for so many rows and columns.
pub(super) fn rank_tolerance((rows, columns): (usize, usize)) -> f64 {
    32.0 * f64::EPSILON * (rows.max(columns).max(1) as f64).sqrt()
}

impl Factor {
    /// Weights, scales and factorises; `rows_total` counts rows that were folded into these.
    pub(super) fn new(
        rows: MatRef<'_, f64>,
        weight: Vec<f64>,
        rows_total: usize,
        tolerance: Option<f64>,
    ) -> Result<Self> {
        let (m, n) = rows.shape();
        let mut scaled = Mat::zeros(m, n);
        let mut scale = Vec::with_capacity(n);
        for j in 0..n {
            let to = scaled.col_as_slice_mut(j);
            match rows.col(j).try_as_col_major() {
                Some(own) => to.iter_mut().zip(own.as_slice()).zip(&weight).for_each(|((to, a), w)| *to = w * a),
                None => to.iter_mut().zip(rows.col(j).iter()).zip(&weight).for_each(|((to, a), w)| *to = w * a),
            }
            scale.push(normalise(to).ok_or_else(|| out_of_range(j))?);
        }
        let tolerance = tolerance.unwrap_or_else(|| rank_tolerance((rows_total, n)));
        let (pivoted, dependence) = basis::reveal(&scaled, tolerance);
        let rank = pivoted.rank;
        let mut r = Mat::zeros(rank, rank);
        for j in 0..rank {
            r.col_as_slice_mut(j)[..=j].copy_from_slice(&pivoted.r.col_as_slice(j)[..=j]);
        }
        let mut r_inverse = Mat::zeros(rank, rank);
        for j in 0..rank {
            let column = &mut r_inverse.col_as_slice_mut(j)[..=j];
            column[j] = 1.0;
            substitute(&r, column);
        }
        let q = if pivoted.q.ncols() == rank { pivoted.q } else { pivoted.q.subcols(0, rank).to_owned() };
        let basis = pivoted.order[..rank].to_vec();
        Ok(Factor { q, r, r_inverse, basis, dependence, weight, scale, tolerance, embedding: None })
    }

    /// Number of independent columns.
    pub fn rank(&self) -> usize {
        self.basis.len()
    }

    /// The unknowns that the columns of `Q` and `R` belong to, in pivot order.
    pub(crate) fn basis(&self) -> &[usize] {
        self.embedding.as_ref().map_or(&self.basis, |embedding| &embedding.basis)
    }

    /// Thin `Q`, `m x rank`, of the weighted rows.
    pub fn thin_q(&self) -> MatRef<'_, f64> {
        self.q.as_ref()
    }

    /// Upper triangular `R`, `rank x rank`, of the weighted rows with columns scaled to unit norm.
    pub(crate) fn r(&self) -> MatRef<'_, f64> {
        self.r.as_ref()
    }

    /// Weights `1/u` of the rows, group scales included where several were estimated.
    pub fn weight(&self) -> &[f64] {
        &self.weight
    }

    /// Norms of the weighted columns (1 for a column of zeros).
    pub fn scale(&self) -> &[f64] {
        self.embedding.as_ref().map_or(&self.scale, |embedding| &embedding.scale)
    }

    /// `log det A'A` of the rows.
    pub fn log_determinant(&self) -> f64 {
        let r = self.r();
        let scale: f64 = self.basis().iter().filter_map(|j| self.scale().get(*j)).map(|scale| scale.ln()).sum();
        2.0 * ((0..r.nrows()).map(|k| r[(k, k)].abs().ln()).sum::<f64>() + scale)
    }

    /// How the columns outside the basis follow it; empty where equations eliminated some unknowns.
    pub(crate) fn couplings(&self) -> Vec<Coupling> {
        if self.embedding.is_some() {
            return Vec::new();
        }
        self.dependence.couplings(&self.basis, &self.scale)
    }

    /// Rank tolerance that was used, relative to `|R_11|`.
    pub(crate) fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Least-squares solution, `n`, for another right-hand side, `m` (not weighted); dependent unknowns stay zero.
    pub fn solve(&self, observed: &[f64]) -> Result<Vec<f64>> {
        self.check_rows(observed)?;
        let weighted: Vec<f64> = observed.iter().zip(&self.weight).map(|(y, w)| w * y).collect();
        let solution = self.spread(self.onto_basis(&weighted));
        Ok(match &self.embedding {
            None => solution,
            Some(embedding) => embedding.direction(&solution),
        })
    }

    /// What is left of a column, `m` (not weighted), when the columns of the system are projected out of it; weighted.
    pub fn project_out(&self, column: &[f64]) -> Result<Vec<f64>> {
        self.check_rows(column)?;
        let mut rest: Vec<f64> = column.iter().zip(&self.weight).map(|(y, w)| w * y).collect();
        // Twice is enough for orthogonality to working precision (W. Kahan; B. Parlett, Symmetric Eigenvalue Problem).
        for _ in 0..2 {
            let along = self.onto_basis(&rest);
            self.subtract_span(&along, &mut rest);
        }
        Ok(rest)
    }

    /// Sensitivities `d x / d y`, `n x m`: how each unknown follows each reading.
    pub fn sensitivities(&self) -> Mat<f64> {
        let directions = self.whitened_directions();
        let mut sensitivities = product_by_rows(directions.as_ref(), self.q.as_ref());
        for (i, w) in self.weight.iter().enumerate() {
            sensitivities.col_as_slice_mut(i).iter_mut().for_each(|s| *s *= w);
        }
        sensitivities
    }

    /// `T = D^-1 R^-1`, `n x rank`: a step `T v` raises the weighted sum of squares by `|v|^2` over its minimum.
    pub(crate) fn whitened_directions(&self) -> Mat<f64> {
        let rank = self.rank();
        let mut scaled = Mat::zeros(self.scale.len(), rank);
        for (a, &j) in self.basis.iter().enumerate() {
            for k in a..rank {
                scaled[(j, k)] = self.r_inverse[(a, k)] / self.scale[j];
            }
        }
        match &self.embedding {
            None => scaled,
            Some(embedding) => &embedding.lift * scaled,
        }
    }

    /// Squared norms of the rows of `Q`: the leverages.
    pub(super) fn leverages(&self) -> Vec<f64> {
        let mut leverage = vec![0.0; self.weight.len()];
        for k in 0..self.rank() {
            for (h, q) in leverage.iter_mut().zip(self.q.col_as_slice(k)) {
                *h += q * q;
            }
        }
        leverage.iter_mut().for_each(|h| *h = h.min(1.0));
        leverage
    }

    /// `(A' W^2 A)^-1` on the independent unknowns, `n x n`, zero elsewhere.
    pub(super) fn cofactor(&self) -> Mat<f64> {
        let (rank, n) = (self.rank(), self.scale.len());
        let mut cofactor = Mat::zeros(n, n);
        for (a, &i) in self.basis.iter().enumerate() {
            for (b, &j) in self.basis.iter().enumerate().take(a + 1) {
                let sum: f64 = (a..rank).map(|k| self.r_inverse[(a, k)] * self.r_inverse[(b, k)]).sum();
                let value = sum / self.scale[i] / self.scale[j];
                cofactor[(i, j)] = value;
                cofactor[(j, i)] = value;
            }
        }
        cofactor
    }

    /// `Q' y` for a weighted `y`.
    pub(super) fn onto_basis(&self, weighted: &[f64]) -> Vec<f64> {
        (0..self.rank()).map(|k| self.q.col_as_slice(k).iter().zip(weighted).map(|(q, y)| q * y).sum()).collect()
    }

    /// `y -= Q c`.
    pub(super) fn subtract_span(&self, along: &[f64], weighted: &mut [f64]) {
        for (k, c) in along.iter().enumerate() {
            for (y, q) in weighted.iter_mut().zip(self.q.col_as_slice(k)) {
                *y -= c * q;
            }
        }
    }

    /// `R^-T c`.
    pub(super) fn forward_substitute(&self, mut c: Vec<f64>) -> Vec<f64> {
        for k in 0..self.rank() {
            let column = self.r.col_as_slice(k);
            let before: f64 = column[..k].iter().zip(&c).map(|(r, c)| r * c).sum();
            c[k] = (c[k] - before) / column[k];
        }
        c
    }

    /// `D^-1 R^-1 c`, the unknowns in the user's order; zero outside the basis.
    pub(super) fn spread(&self, mut c: Vec<f64>) -> Vec<f64> {
        substitute(&self.r, &mut c);
        let mut solution = vec![0.0; self.scale.len()];
        for (z, &j) in c.iter().zip(&self.basis) {
            solution[j] = z / self.scale[j];
        }
        solution
    }

    fn check_rows(&self, column: &[f64]) -> Result<()> {
        if column.len() == self.weight.len() {
            return Ok(());
        }
        Err(Malformed::new(Fault::Value, "a column does not fit the system")
            .expected(format!("{} values, one per row", self.weight.len()))
            .found(column.len().to_string()))
    }
}

impl Embedding {
    /// A change of the kept unknowns as a change of all.
    pub fn direction(&self, kept: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; self.lift.nrows()];
        for (k, t) in kept.iter().enumerate().take(self.lift.ncols()) {
            for (x, l) in all.iter_mut().zip(self.lift.col_as_slice(k)) {
                *x += l * t;
            }
        }
        all
    }
}

/// Scales a column to unit norm and returns the norm, 1 for a column of zeros, `None` if it cannot be represented.
fn normalise(column: &mut [f64]) -> Option<f64> {
    let squares: f64 = column.iter().map(|a| a * a).sum();
    let norm = if squares > 1e-280 && squares < 1e280 {
        squares.sqrt()
    } else {
        let largest = column.iter().fold(0.0_f64, |largest, a| largest.max(a.abs()));
        if largest == 0.0 {
            return Some(1.0);
        }
        let reduced: f64 = column.iter().map(|a| (a / largest) * (a / largest)).sum();
        largest * reduced.sqrt()
    };
    if !(norm.is_finite() && norm >= f64::MIN_POSITIVE) {
        return None;
    }
    let reciprocal = norm.recip();
    if reciprocal.is_normal() {
        column.iter_mut().for_each(|a| *a *= reciprocal);
    } else {
        column.iter_mut().for_each(|a| *a /= norm);
    }
    Some(norm)
}

fn out_of_range(j: usize) -> Malformed {
    Malformed::new(
        Fault::Value,
        "a column, divided by its standard uncertainties, is too large or too small for a double",
    )
    .at_path(format!("rows[..][{j}]"))
    .expected("units in which numbers lie between 1e-300 and 1e300")
}

/// Rows of a block of a product.
const BLOCK: usize = 512;

// Iterative refinement of solution and residuals together, with right-hand sides in twice the working precision.
//
// The augmented system `v + A x = y`, `A' W^2 v = 0` is solved for corrections with the factorisation at hand: A. Bjorck,
// "Iterative refinement of linear least squares solutions I", BIT 7 (1967). It makes the error of the solution nearly
// independent of the condition number, and of the size of the residuals.

/// Solution and residuals (`observed - fitted`, not weighted) as refined, and how many steps it took.
pub(super) struct Refined {
    pub solution: Vec<f64>,
    pub residuals: Vec<f64>,
    pub steps: usize,
}

/// A step that changes the scaled solution by less than this share is the last: the next would change its square.
const ENOUGH: f64 = 1e-12;
/// The same for each unknown by itself, which weights of very different size may leave far behind the whole.
const ENOUGH_EACH: f64 = 1e-10;

impl Factor {
    /// Solves by the factorisation, then refines until it no longer matters, at most `limit` steps.
    pub(super) fn refined(&self, rows: MatRef<'_, f64>, observed: &[f64], limit: usize) -> Refined {
        let weight = &self.weight;
        let mut rest: Vec<f64> = observed.iter().zip(weight).map(|(y, w)| w * y).collect();
        let along = self.onto_basis(&rest);
        self.subtract_span(&along, &mut rest);
        let solution = self.spread(along);
        let residuals = rest.iter().zip(weight).map(|(v, w)| v / w).collect();
        let mut best = Refined { solution, residuals, steps: 0 };
        let mut last_change = f64::INFINITY;
        while best.steps < limit {
            let Some((next, change)) = self.correction(rows, observed, &best) else { break };
            if change.is_nan() || change >= last_change {
                break;
            }
            let each = next.solution.iter().zip(&best.solution).all(|(x, y)| (x - y).abs() <= ENOUGH_EACH * x.abs());
            best = next;
            last_change = change / 4.0;
            if change <= ENOUGH && each {
                break;
            }
        }
        best
    }

    /// One correction, and its size relative to the scaled solution; `None` where numbers leave the range of a double.
    fn correction(&self, rows: MatRef<'_, f64>, observed: &[f64], now: &Refined) -> Option<(Refined, f64)> {
        let weight = &self.weight;
        // f = W (y - A x - v), accumulated as high + low.
        let (mut high, mut low) = (observed.to_vec(), vec![0.0; observed.len()]);
        for &j in &self.basis {
            accumulate(&mut high, &mut low, -now.solution[j], column(rows, j)?);
        }
        accumulate(&mut high, &mut low, -1.0, &now.residuals);
        let mut f: Vec<f64> = high.iter().zip(&low).zip(weight).map(|((high, low), w)| w * (high + low)).collect();
        // g = -D^-1 A' W^2 v.
        let pulled: Vec<f64> = now.residuals.iter().zip(weight).map(|(v, w)| w * (w * v)).collect();
        let mut g = Vec::with_capacity(self.rank());
        for &j in &self.basis {
            g.push(-compensated_dot(column(rows, j)?, &pulled) / self.scale[j]);
        }
        let mut along = self.onto_basis(&f);
        let shift = self.forward_substitute(g);
        along.iter_mut().zip(&shift).for_each(|(c, h)| *c -= h);
        self.subtract_span(&along, &mut f);
        let correction = self.spread(along);
        let solution: Vec<f64> = now.solution.iter().zip(&correction).map(|(x, dx)| x + dx).collect();
        let residuals: Vec<f64> = now.residuals.iter().zip(f.iter().zip(weight)).map(|(v, (f, w))| v + f / w).collect();
        if !solution.iter().chain(&residuals).all(|value| value.is_finite()) {
            return None;
        }
        let largest = |x: &[f64]| x.iter().zip(&self.scale).fold(0.0_f64, |most, (x, d)| most.max((x * d).abs()));
        let size = largest(&solution);
        let change = if size > 0.0 { largest(&correction) / size } else { 0.0 };
        Some((Refined { solution, residuals, steps: now.steps + 1 }, change))
    }
}

fn column(rows: MatRef<'_, f64>, j: usize) -> Option<&[f64]> {
    rows.col(j).try_as_col_major().map(|column| column.as_slice())
}

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
