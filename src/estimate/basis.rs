//! Which columns depend on which: the rank decision, and the combinations of unknowns that follow from it.
//!
//! With the independent columns factorised, `A_d = A_b C` (columns scaled). Then `n' = (-C, I)` spans the null space, and
//! `z_b + C z_d` is what the readings do determine, `z = D x` being the scaled unknowns.

use super::factor::{Pivoted, pivoted_qr};
use faer::Mat;

/// Below this a coupling between scaled columns is rounding, not dependence.
const COUPLING: f64 = 1e-8;

/// A linear combination of unknowns, first coefficient 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Combination {
    /// Unknown and coefficient, in the order of the unknowns.
    pub terms: Vec<(usize, f64)>,
}

impl Combination {
    /// The combination's value at a solution.
    pub fn value(&self, solution: &[f64]) -> f64 {
        self.terms.iter().map(|&(j, c)| c * solution.get(j).copied().unwrap_or(0.0)).sum()
    }

    /// The combination's variance from a covariance matrix of the unknowns.
    pub fn variance(&self, covariance: &Mat<f64>) -> f64 {
        let inside = |i: usize, j: usize| i < covariance.nrows() && j < covariance.ncols();
        let element = |i, j| if inside(i, j) { covariance[(i, j)] } else { 0.0 };
        self.terms.iter().flat_map(|&(i, a)| self.terms.iter().map(move |&(j, b)| a * b * element(i, j))).sum()
    }
}

/// What the rank decision says about the columns that are not in the basis.
#[derive(Debug, Clone)]
pub(super) struct Dependence {
    /// Columns outside the basis, in the user's order.
    dependent: Vec<usize>,
    /// `C = R^-1 Q' A_d` of scaled columns, `rank x dependent`.
    coupling: Mat<f64>,
}

/// Factorises the scaled columns and decides which are independent; earlier unknowns are kept where there is a choice.
///
/// The factorisation that comes back has `rank` independent leading columns.
pub(super) fn reveal(scaled: &Mat<f64>, tolerance: f64) -> (Pivoted, Dependence) {
    let n = scaled.ncols();
    let is_zero = |j: &usize| scaled.col_as_slice(*j).iter().all(|a| *a == 0.0);
    let mut active: Vec<usize> = (0..n).filter(|j| !is_zero(j)).collect();
    let mut found = pivoted_qr(scaled, &active, tolerance);
    // Pivoting goes by updated norms; if a negligible column was taken before a larger one, set it aside and repeat.
    while found.hides_a_larger_column(tolerance) {
        let negligible = found.order[found.rank];
        active.retain(|j| *j != negligible);
        found = pivoted_qr(scaled, &active, tolerance);
    }
    if found.rank == n {
        return (found, Dependence { dependent: Vec::new(), coupling: Mat::new() });
    }
    let outside = |basis: &[usize]| (0..n).filter(|j| !basis.contains(j)).collect::<Vec<usize>>();
    let rank = found.rank;
    let mut dependent = outside(&found.order[..rank]);
    let mut coupling = coupling(&found, scaled, &dependent);
    let later = latest_dependent(&null_space(&found.order[..rank], &dependent, &coupling, n), n);
    if later != dependent {
        let again = pivoted_qr(scaled, &outside(&later), tolerance);
        if again.rank == rank {
            found = again;
            dependent = later;
            coupling = self::coupling(&found, scaled, &dependent);
        }
    }
    (found, Dependence { dependent, coupling })
}

impl Pivoted {
    /// Whether a column behind the first negligible one is not negligible.
    fn hides_a_larger_column(&self, tolerance: f64) -> bool {
        let (size, k, rank) = (self.r.nrows(), self.r.ncols(), self.rank);
        let Some(limit) = (rank < size).then(|| tolerance * self.r[(0, 0)].abs()) else { return false };
        (rank + 1..k).any(|j| {
            let squares: f64 = (rank..size.min(j + 1)).map(|i| self.r[(i, j)].powi(2)).sum();
            squares.sqrt() > limit
        })
    }
}

/// `R^-1 Q' A_d`.
fn coupling(found: &Pivoted, scaled: &Mat<f64>, dependent: &[usize]) -> Mat<f64> {
    let rank = found.rank;
    let mut coupling = Mat::zeros(rank, dependent.len());
    for (d, &j) in dependent.iter().enumerate() {
        let column = scaled.col_as_slice(j);
        let coupled = coupling.col_as_slice_mut(d);
        for (k, c) in coupled.iter_mut().enumerate() {
            *c = found.q.col_as_slice(k).iter().zip(column).map(|(q, a)| q * a).sum();
        }
        for k in (0..rank).rev() {
            let z = coupled[k] / found.r[(k, k)];
            coupled[k] = z;
            for (i, c) in coupled[..k].iter_mut().enumerate() {
                *c -= z * found.r[(i, k)];
            }
        }
    }
    coupling
}

/// Null vectors of the scaled columns, one per dependent column, each of length `n`.
fn null_space(basis: &[usize], dependent: &[usize], coupling: &Mat<f64>, n: usize) -> Vec<Vec<f64>> {
    let vector = |(d, &j): (usize, &usize)| {
        let mut vector = vec![0.0; n];
        vector[j] = 1.0;
        for (&b, c) in basis.iter().zip(coupling.col_as_slice(d)) {
            vector[b] = -c;
        }
        vector
    };
    dependent.iter().enumerate().map(vector).collect()
}

/// The last columns, in the user's order, that the others can stand for: elimination on the null space from the last
/// unknown backwards, with pivots of at least a tenth of their vector's largest element.
fn latest_dependent(null_space: &[Vec<f64>], n: usize) -> Vec<usize> {
    let mut open = null_space.to_vec();
    let mut dependent = Vec::with_capacity(open.len());
    for j in (0..n).rev() {
        let share = |vector: &Vec<f64>| vector[j].abs() / vector.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let best = (0..open.len()).max_by(|&a, &b| share(&open[a]).total_cmp(&share(&open[b])));
        let Some(best) = best.filter(|&row| share(&open[row]) > 0.1) else { continue };
        let pivot = open.swap_remove(best);
        for vector in &mut open {
            let factor = vector[j] / pivot[j];
            vector.iter_mut().zip(&pivot).for_each(|(v, p)| *v -= factor * p);
        }
        dependent.push(j);
    }
    dependent.sort_unstable();
    dependent
}

impl Dependence {
    /// Which unknowns the readings determine, `n`.
    pub(super) fn estimable(&self, basis: &[usize], n: usize) -> Vec<bool> {
        let mut estimable = vec![true; n];
        for (d, &j) in self.dependent.iter().enumerate() {
            estimable[j] = false;
            for (&b, c) in basis.iter().zip(self.coupling.col_as_slice(d)) {
                estimable[b] &= c.abs() <= COUPLING;
            }
        }
        estimable
    }

    /// The directions in which the readings leave the unknowns free: `sum n'_j D_j x_j`.
    pub(super) fn not_estimable(&self, basis: &[usize], scale: &[f64]) -> Vec<Combination> {
        let combine = |(d, &j): (usize, &usize)| {
            let coupled = basis.iter().zip(self.coupling.col_as_slice(d)).map(|(&b, c)| (b, -c));
            let terms = coupled.filter(|(_, c)| c.abs() > COUPLING).chain([(j, 1.0)]);
            let mut terms: Vec<(usize, f64)> = terms.map(|(j, c)| (j, c * scale[j])).collect();
            terms.sort_unstable_by_key(|(j, _)| *j);
            let first = terms[0].1;
            terms.iter_mut().for_each(|(_, c)| *c /= first);
            Combination { terms }
        };
        self.dependent.iter().enumerate().map(combine).collect()
    }

    /// What the readings do determine of unknowns that are not estimable alone: `x_b + sum C_bd x_d`.
    pub(super) fn estimable_combinations(&self, basis: &[usize], scale: &[f64]) -> Vec<Combination> {
        let mut combinations = Vec::new();
        for (k, &b) in basis.iter().enumerate() {
            let coupled = self.dependent.iter().enumerate().map(|(d, &j)| (j, self.coupling[(k, d)]));
            let mut terms: Vec<(usize, f64)> =
                coupled.filter(|(_, c)| c.abs() > COUPLING).map(|(j, c)| (j, c * scale[j] / scale[b])).collect();
            if terms.is_empty() {
                continue;
            }
            terms.push((b, 1.0));
            terms.sort_unstable_by_key(|(j, _)| *j);
            let first = terms[0].1;
            terms.iter_mut().for_each(|(_, c)| *c /= first);
            combinations.push(Combination { terms });
        }
        combinations.sort_by_key(|combination| combination.terms[0].0);
        combinations
    }
}
