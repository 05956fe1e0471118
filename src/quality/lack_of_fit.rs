//! Lack of fit: the residuals of the model against the scatter of replicates.
//!
//! N. R. Draper, H. Smith, Applied Regression Analysis (1998), 2.1: the residual sum of squares of readings is parted into that
//! of replicates about their own means (*pure error*) and the remainder, which only a wrong model makes larger. Where nothing is replicated, the
//! model with an offset for each position is compared with the model alone (the same F test, of the extra sum of squares, 6.1 there).
#![allow(
    clippy::indexing_slicing,
    reason = "matrices and vectors are made here with the groups' and the basis' lengths"
)]

use crate::elements::Elements;
use crate::uncertainty::quantiles;
use faer::{Mat, MatRef, Side};

/// The test for lack of fit.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "LackOfFitReport")]
pub struct LackOfFit {
    /// The sensor whose readings are tested, where the scales of several are estimated: the one with the smallest p; absent where all are tested together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensor: Option<String>,
    /// F, a pure number: `(between / between_dof) / pure_error_sd^2`.
    pub f: Option<f64>,
    /// Degrees of freedom of what the model leaves between the means.
    pub between_dof: usize,
    /// Degrees of freedom of the replicates' scatter, or of that within positions.
    pub pure_error_dof: usize,
    /// Factor by which its standard deviation differs from the weights' (1 where uncertainties are right).
    pub pure_error_sd: f64,
    /// Probability of a larger F if the model is right.
    pub p: f64,
    /// Is the model rejected: is `p` below one minus the level, which all tests of the pattern of the residuals share?
    pub rejected: bool,
}

impl LackOfFit {
    /// The test of sums of squares within and between; `total` is the whole sum. `None` where that within is rounding.
    fn of(
        within: f64,
        pure_error_dof: usize,
        between: f64,
        between_dof: usize,
        total: f64,
        level: f64,
    ) -> Option<Self> {
        let (f, p) = lack_of_fit_p(within, pure_error_dof, between, between_dof, total)?;
        let pure_error_sd = (within / pure_error_dof as f64).sqrt();
        Some(LackOfFit {
            sensor: None,
            f: f.is_finite().then_some(f),
            between_dof,
            pure_error_dof,
            pure_error_sd,
            p,
            rejected: p < 1.0 - level,
        })
    }

    /// Of the tests of several parts of the readings the one with the smallest p, which then is that of the smallest of so many, `1 - (1 - p)^n`
    /// (Z. Sidak, J. Amer. Statist. Assoc. 62, 1967).
    pub(crate) fn smallest(tests: Vec<Self>, level: f64) -> Option<Self> {
        let count = tests.len() as f64;
        let mut worst = tests.into_iter().min_by(|a, b| a.p.total_cmp(&b.p))?;
        worst.p = -(count * (-worst.p).ln_1p()).exp_m1();
        worst.rejected = worst.p < 1.0 - level;
        Some(worst)
    }

    /// Is the model wrong beyond doubt, at the significance at which a single bad reading is?
    pub(crate) fn is_beyond_doubt(&self) -> bool {
        self.p < super::ALPHA
    }

    /// Is the lack of fit smaller than the scatter allows, at that significance? Then that scatter is not noise alone.
    pub(crate) fn is_below_scatter(&self) -> bool {
        self.p > 1.0 - super::ALPHA
    }
}

/// Part the residuals `v` (with standard uncertainties `u`, absolute or relative) by `cell`: rows of one cell have the same inputs.
///
/// `dof` are the degrees of freedom of the residuals. `None` where nothing is replicated, or nothing is left to be lack of fit.
///
/// ```
/// use tumble::quality::lack_of_fit;
/// // A mean (one parameter) of two cells of two: 0, 1 and 4, 5 about 2.5.
/// let test = lack_of_fit(&[-2.5, -1.5, 1.5, 2.5], &[1.0; 4], &[0, 0, 1, 1], 3, 0.95).unwrap();
/// // sums of squares 1 within and 16 between
/// assert_eq!((test.pure_error_dof, test.pure_error_sd), (2, 0.5_f64.sqrt()));
/// assert_eq!((test.between_dof, test.f), (1, Some(32.0)));
/// ```
pub fn lack_of_fit(v: &[f64], u: &[f64], cell: &[usize], dof: usize, level: f64) -> Option<LackOfFit> {
    let cells = cell.iter().max().map_or(0, |most| most + 1);
    let mut sums = vec![(0usize, 0.0, 0.0); cells];
    for ((v, u), cell) in v.iter().zip(u).zip(cell) {
        if let Some((count, weight, sum)) = sums.get_mut(*cell) {
            *count += 1;
            *weight += 1.0 / (u * u);
            *sum += v / (u * u);
        }
    }
    let mean = |cell: &usize| sums.get(*cell).map_or(0.0, |(_, weight, sum)| sum / weight);
    let (mut pure_error, mut total) = (0.0, 0.0);
    for ((v, u), cell) in v.iter().zip(u).zip(cell) {
        pure_error += ((v - mean(cell)) / u).powi(2);
        total += (v / u).powi(2);
    }
    let pure_error_dof: usize = sums.iter().map(|(count, _, _)| count.saturating_sub(1)).sum();
    let between_dof = dof.checked_sub(pure_error_dof).filter(|dof| *dof > 0)?;
    if pure_error_dof == 0 {
        return None;
    }
    let between = sums.iter().map(|(_, weight, sum)| if *weight > 0.0 { sum * sum / weight } else { 0.0 }).sum::<f64>();
    LackOfFit::of(pure_error, pure_error_dof, between, between_dof, total, level)
}

/// A direction of the unknowns that lies in the span of the groups to this much is no further one.
const SAME: f64 = 1e-10;

/// The model with an offset for each group against the model alone: what residuals of one schedule share.
#[derive(Debug, Clone)]
pub struct Offsets {
    /// Group of each row, and what a weighted residual has of the group's offset at unit norm.
    rows: Vec<Option<(usize, f64)>>,
    weight: Vec<f64>,
    /// What each direction of the unknowns has of the groups, over the root of what of it lies outside of them.
    directions: Vec<Vec<f64>>,
    groups: usize,
    pure_error_dof: usize,
    between_dof: usize,
}

impl Offsets {
    /// `weight` are the rows' `1/u`, `q` the orthonormal basis of the weighted rows, `dof` the degrees of freedom of the residuals; a row without a
    /// group has no offset. `None` where no offset is beside the model, or where nothing is left.
    pub(crate) fn new(weight: &[f64], q: MatRef<'_, f64>, group: &[Option<usize>], dof: usize) -> Option<Self> {
        let groups = group.iter().flatten().max().map_or(0, |most| most + 1);
        // the offsets' columns at unit norm
        let mut norm = vec![0.0; groups];
        for (g, w) in group.iter().zip(weight).filter_map(|(group, w)| Some(((*group)?, w))) {
            norm.get_mut(g).into_iter().for_each(|norm| *norm += w * w);
        }
        let used = norm.iter().filter(|norm| **norm > 0.0).count();
        // offsets of so many groups leave nothing, whatever the unknowns are
        if used == 0 || used >= dof + q.ncols() {
            return None;
        }
        let share = |(group, w): (&Option<usize>, &f64)| group.map(|g| (g, w / norm.at(g).sqrt()));
        let rows: Vec<Option<(usize, f64)>> = group.iter().zip(weight).map(share).collect();
        let mut of_basis = Mat::<f64>::zeros(groups, q.ncols());
        for (i, (g, share)) in rows.iter().enumerate().filter_map(|(i, row)| Some((i, (*row)?))) {
            for k in 0..q.ncols() {
                of_basis[(g, k)] += share * q[(i, k)];
            }
        }
        let gram = of_basis.transpose() * &of_basis;
        let eigen = gram.self_adjoint_eigen(Side::Lower).ok()?;
        let mut directions = Vec::new();
        for k in 0..q.ncols() {
            let outside = 1.0 - eigen.S()[k];
            if outside >= SAME {
                let direction = &of_basis * eigen.U().col(k);
                directions.push((0..groups).map(|g| direction[g] / outside.sqrt()).collect());
            }
        }
        let between_dof = used.checked_sub(q.ncols() - directions.len()).filter(|dof| *dof > 0)?;
        let pure_error_dof = dof.checked_sub(between_dof).filter(|dof| *dof > 0)?;
        Some(Offsets { rows, weight: weight.to_vec(), directions, groups, pure_error_dof, between_dof })
    }

    /// The test of residuals of least squares: `between` is what the offsets explain, the *pure error* is what is left.
    pub fn test(&self, v: &[f64], level: f64) -> Option<LackOfFit> {
        let mut of_residuals = vec![0.0; self.groups];
        let mut total = 0.0;
        for ((row, weight), v) in self.rows.iter().zip(&self.weight).zip(v) {
            let standard = weight * v;
            total += standard * standard;
            if let Some((g, share)) = row {
                of_residuals.get_mut(*g).into_iter().for_each(|sum| *sum += share * standard);
            }
        }
        let along = |direction: &Vec<f64>| direction.iter().zip(&of_residuals).map(|(d, s)| d * s).sum::<f64>();
        let between = of_residuals.iter().map(|s| s * s).sum::<f64>()
            + self.directions.iter().map(|direction| along(direction).powi(2)).sum::<f64>();
        let (pure_error_dof, between_dof) = (self.pure_error_dof, self.between_dof);
        let pure_error = (total - between).max(0.0);
        LackOfFit::of(pure_error, pure_error_dof, between, between_dof, total, level)
    }
}

/// The F statistic and its probability from sums of squares and their degrees of freedom; `total` is the whole sum. `None` where replicates agree exactly: rows
/// that were entered more than once do so, too, and neither shows how much readings scatter.
pub(crate) fn lack_of_fit_p(
    pure_error: f64,
    pure_error_dof: usize,
    between: f64,
    between_dof: usize,
    total: f64,
) -> Option<(f64, f64)> {
    // rounding of identical readings is no scatter
    let none = 64.0 * f64::EPSILON * f64::EPSILON * total;
    if !(pure_error > none) {
        return None;
    }
    let f = between / between_dof as f64 / (pure_error / pure_error_dof as f64);
    Some((f, quantiles::fisher_f_survival(f, between_dof as f64, pure_error_dof as f64)?))
}
