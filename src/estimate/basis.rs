//! Which columns depend on which: the rank decision, and the combinations of unknowns that follow from it.
//!
//! With the independent columns factorised, `A_d = A_b C` (columns scaled). Then `n' = (-C, I)` spans the null space, and
//! `z_b + C z_d` is what the readings do determine, `z = D x` being the scaled unknowns.
#![allow(
    clippy::indexing_slicing,
    reason = "columns are numbers below `scaled.ncols()` that the factorisation has ordered; every vector of the null space has as many entries"
)]

use super::pivoted::{Pivoted, pivoted_qr, substitute};
use crate::elements::Elements;
use faer::Mat;

/// Below this a coupling between scaled columns is rounding, not dependence.
const COUPLING: f64 = 1e-8;

/// An unknown has a part in a direction where its scaled entry is at least this share of the largest.
const PARTNER: f64 = 0.1;

/// A linear combination of unknowns, first coefficient 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Combination {
    /// Unknown and coefficient, in the order of the unknowns.
    pub terms: Vec<(usize, f64)>,
}

impl Combination {
    /// The combination's value at a solution.
    pub(crate) fn value(&self, solution: &[f64]) -> f64 {
        self.terms.iter().map(|&(j, c)| c * solution.at(j)).sum()
    }
}

/// How the column of an unknown outside the basis follows those of the basis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Coupling {
    /// The unknown.
    pub unknown: usize,
    /// `A_unknown = sum c A_b`: unknowns of the basis and their coefficients.
    pub follows: Vec<(usize, f64)>,
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
        substitute(&found.r, coupled);
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
        let Some(best) = best.filter(|&row| share(&open[row]) > PARTNER) else { continue };
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

    /// Null vectors of the scaled columns with as few terms as subtracting one from another gives; each keeps its own dependent unknown.
    fn sparse_null_space(&self, basis: &[usize], n: usize) -> Vec<Vec<f64>> {
        let mut vectors = null_space(basis, &self.dependent, &self.coupling, n);
        let clean = |vector: &mut Vec<f64>| {
            let largest = vector.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
            vector.iter_mut().filter(|v| v.abs() <= COUPLING * largest).for_each(|v| *v = 0.0);
        };
        let terms = |vector: &[f64]| vector.iter().filter(|v| **v != 0.0).count();
        vectors.iter_mut().for_each(clean);
        let mut improved = true;
        while improved {
            improved = false;
            for i in 0..vectors.len() {
                for j in (0..vectors.len()).filter(|j| *j != i) {
                    let own = terms(&vectors[i]);
                    let mut best: Option<Vec<f64>> = None;
                    for k in (0..n).filter(|k| vectors[i][*k] != 0.0 && vectors[j][*k] != 0.0) {
                        let factor = vectors[i][k] / vectors[j][k];
                        let mut trial: Vec<f64> =
                            vectors[i].iter().zip(&vectors[j]).map(|(a, b)| a - factor * b).collect();
                        trial[k] = 0.0;
                        clean(&mut trial);
                        if trial[self.dependent[i]] != 0.0 && terms(&trial) < best.as_deref().map_or(own, terms) {
                            best = Some(trial);
                        }
                    }
                    if let Some(best) = best {
                        vectors[i] = best;
                        improved = true;
                    }
                }
            }
        }
        vectors
    }

    /// The directions in which the readings leave the unknowns free, in the user's unknowns: `x_j = n'_j / D_j`.
    pub(super) fn directions(&self, basis: &[usize], scale: &[f64]) -> Vec<Combination> {
        let direction = |vector: Vec<f64>| {
            let scaled = vector.iter().zip(scale).enumerate().filter(|(_, (v, _))| **v != 0.0);
            first_is_one(scaled.map(|(j, (v, d))| (j, v / d)).collect())
        };
        self.sparse_null_space(basis, scale.len()).into_iter().map(direction).collect()
    }

    /// What is not estimable, in as few unknowns as will do: along a direction `e` with its own unknown `d` and another `a`, the readings see
    /// `x_a - (e_a / e_d) x_d` at most, and never `x_a + (e_a / e_d) x_d`. The other is the first of those that have a part in it: a column that
    /// is hardly in the direction says little of what hides in what.
    pub(super) fn not_estimable(&self, basis: &[usize], scale: &[f64]) -> Vec<Combination> {
        let combine = |(direction, d): (Combination, &usize)| {
            let own = direction.terms.iter().find(|(j, _)| j == d).map_or(1.0, |(_, e)| *e);
            let others = || direction.terms.iter().filter(|(j, _)| j != d);
            let part = |(j, e): &(usize, f64)| (e * scale[*j]).abs();
            let most = others().map(part).fold(0.0, f64::max);
            match others().find(|own| part(own) >= PARTNER * most) {
                Some((a, e)) => first_is_one(vec![(*a, 1.0), (*d, e / own)]),
                None => Combination { terms: vec![(*d, 1.0)] },
            }
        };
        self.directions(basis, scale).into_iter().zip(&self.dependent).map(combine).collect()
    }

    /// How each dependent column follows the columns of the basis, not scaled: `A_d = sum A_b c_b`.
    pub(super) fn couplings(&self, basis: &[usize], scale: &[f64]) -> Vec<Coupling> {
        let of = |(d, &j): (usize, &usize)| {
            let terms = basis.iter().zip(self.coupling.col_as_slice(d));
            Coupling { unknown: j, follows: terms.map(|(&b, c)| (b, c * scale[j] / scale[b])).collect() }
        };
        self.dependent.iter().enumerate().map(of).collect()
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
            combinations.push(first_is_one(terms));
        }
        combinations.sort_by_key(|combination| combination.terms[0].0);
        combinations
    }
}

/// Terms in the user's order, divided by the first coefficient.
fn first_is_one(mut terms: Vec<(usize, f64)>) -> Combination {
    terms.sort_unstable_by_key(|(j, _)| *j);
    let first = terms.first().map_or(1.0, |(_, c)| *c);
    terms.iter_mut().for_each(|(_, c)| *c /= first);
    Combination { terms }
}
