//! What a design makes small, in the coordinates of the blocks: its value, the best replacement of a chosen block for what is not smooth.
//!
//! ```text
//! D: -log det M     A, c: tr(W M^-1)     G: max_i x_i' M^-1 x_i     E: lambda_max(T M^-1 T')     D of some unknowns: det(T M^-1 T')^(1/p)
//! ```
//!
//! (F. Pukelsheim, Optimal Design of Experiments, 1993, 6.4; D_s: A. C. Atkinson, A. N. Donev, R. D. Tobias, Optimum Experimental Designs, 2007,
//! 10.3.) The worst of several variances is not smooth in the design, so every replacement is weighed by all of them. Taking block `i` out first,
//! `Mi = M - Xi'Xi`, a replacement `j` leaves, with `S = I + Xj Mi^-1 Xj'`,
//!
//! ```text
//! r' Mi^-1 r - b' S^-1 b,  b = Xj Mi^-1 r     T Mi^-1 T' - B' S^-1 B,  B = Xj Mi^-1 T'
//! det C_j = det C_i det(I + Xj A Xj') / det S,     C = T M^-1 T',     A = Mi^-1 - Mi^-1 T' C_i^-1 T Mi^-1
//! ```
//!
//! where `A` is what deviations would scatter if the parameters were known. Along the worst direction `v` of `T Mi^-1 T'` alone the second is a
//! bound from below, so replacements are weighed in the order of their bounds until none can be better.
#![allow(
    clippy::indexing_slicing,
    reason = "`Objective::fits` has made sure of a row at least and of the unknowns in each; packed triangles and lists are made here over the rows of a block, with one entry for each candidate or replacement"
)]

use super::blocks::{Blocks, add_outer, packed, sandwich, times};
use super::state::State;
use crate::elements::Elements;
use crate::linear::{Triangle, dot};
use faer::{Mat, Side};

/// What the exchange makes small, in the coordinates of the blocks.
#[derive(Debug, Clone, PartialEq)]
pub enum Objective {
    /// `-log det M`: D.
    Determinant,
    /// `tr(W M^-1)`, `W` symmetric and row by row: A, and c with `W = c c'`.
    Trace(Vec<f64>),
    /// The largest `x' M^-1 x` over all rows of these blocks: G.
    Largest(Blocks),
    /// The largest eigenvalue of `T M^-1 T'`: E.
    Eigenvalue(Combinations),
    /// `det(T M^-1 T')^(1/p)`, p rows of T: D of some of the unknowns; best in units in which all are of one size.
    Volume(Combinations),
}

/// With so few predicted rows, the sum of their variances is near their largest.
const FEW: usize = 64;
/// Replacements that are weighed at least, and that are tried one by one where the block cannot be taken out.
const REPLACEMENTS: usize = 60;
/// Products of predicted rows, candidates and unknowns beyond which only the most informative replacements are weighed.
const ALL: usize = 20_000_000;

impl Objective {
    /// Does it speak of so many unknowns?
    pub(super) fn fits(&self, n: usize) -> bool {
        match self {
            Objective::Determinant => true,
            Objective::Trace(w) => w.len() == n * n,
            Objective::Largest(rows) => rows.unknowns() == n,
            Objective::Eigenvalue(own) | Objective::Volume(own) => {
                !own.0.is_empty() && own.0.iter().all(|row| row.len() == n)
            }
        }
    }

    /// Its value for `M^-1`, row by row; `None` for the determinant.
    pub(super) fn of(&self, inverse: &[f64]) -> Option<f64> {
        match self {
            Objective::Determinant => None,
            Objective::Trace(w) => Some(dot(w, inverse)),
            Objective::Largest(predicted) => Some(predicted.largest_quadratic(inverse)),
            Objective::Eigenvalue(own) => Some(largest_eigenvalue(&own.image(inverse))),
            Objective::Volume(own) => {
                Some(own.triangle(inverse).map_or(f64::NAN, |c| (c.log_determinant() / own.size()).exp()))
            }
        }
    }

    /// Is it the largest of few variances?
    pub(super) fn is_of_few(&self) -> bool {
        matches!(self, Objective::Largest(predicted) if predicted.count() * predicted.rows() <= FEW)
    }

    /// The smooth objective that is nearest, the determinant or the sum of the variances; `None` for one that exchanges follow as it is.
    pub(super) fn nearest(&self) -> Option<Objective> {
        match self {
            Objective::Determinant | Objective::Trace(_) => None,
            Objective::Largest(predicted) if self.is_of_few() => Some(Objective::Trace(predicted.sum())),
            Objective::Largest(_) | Objective::Volume(_) => Some(Objective::Determinant),
            Objective::Eigenvalue(own) => Some(Objective::Trace(own.sum())),
        }
    }

    /// The replacement that leaves the smallest value below `now`, and that value; `inverse` is that without the block at `at`.
    pub(super) fn replacement(
        &self,
        state: &mut State<'_>,
        at: usize,
        inverse: &[f64],
        now: f64,
    ) -> Option<(usize, f64)> {
        let (blocks, n, k) = (state.problem.blocks, state.problem.blocks.unknowns(), state.problem.blocks.rows());
        let count = blocks.count();
        let spread = blocks.quadratics(inverse);
        let root_of = |sums: &[Vec<f64>], j: usize| inverse_root(k, |r, s| sums[packed(r, s)][j]);
        let mut replacements = state.replacements(at);
        let mut best: Option<(usize, f64)> = None;
        match self {
            Objective::Determinant | Objective::Trace(_) => {}
            Objective::Largest(predicted) => {
                let rows = predicted.count() * predicted.rows();
                let most = (ALL / (rows * n * k).max(1)).max(REPLACEMENTS);
                if replacements.len() > most {
                    most_informative(&mut replacements, &spread, k, most);
                }
                let few = blocks.subset(&replacements);
                state.effort += (rows * few.count() * n * k) as f64 + (count * n * n * k) as f64;
                let roots: Vec<Vec<f64>> = replacements.iter().map(|j| root_of(&spread, *j)).collect();
                let mut worst = vec![0.0_f64; replacements.len()];
                let mut along = vec![vec![0.0; replacements.len()]; k];
                for p in 0..predicted.count() {
                    for q in 0..predicted.rows() {
                        let x = predicted.row(p, q);
                        let w = times(inverse, &x);
                        let own = dot(&x, &w);
                        along.iter_mut().enumerate().for_each(|(r, out)| few.along(r, &w, out));
                        for (c, worst) in worst.iter_mut().enumerate() {
                            *worst = worst.max(own - squared(&roots[c], k, |s| along[s][c]));
                        }
                    }
                }
                replacements.into_iter().zip(worst).for_each(|own| keep(&mut best, now, own));
            }
            Objective::Eigenvalue(combinations) => {
                let own = combinations.image(inverse);
                let eigen = own.self_adjoint_eigen(Side::Lower).ok()?;
                let p = own.nrows();
                // eigenvalues come in nondecreasing order
                let (worst, most) = (combinations.combined(|i| eigen.U()[(i, p - 1)]), eigen.S()[p - 1]);
                let w = times(inverse, &worst);
                let mut along = vec![vec![0.0; count]; k];
                along.iter_mut().enumerate().for_each(|(r, out)| blocks.along(r, &w, out));
                let bound = |j: usize| most - squared(&root_of(&spread, j), k, |s| along[s][j]);
                let mut bounded: Vec<(f64, usize)> = replacements.into_iter().map(|j| (bound(j), j)).collect();
                bounded.sort_by(|a, b| a.0.total_cmp(&b.0));
                state.effort += (count * (n * n + 2 * k * n) * k) as f64;
                let columns: Vec<Vec<f64>> = combinations.0.iter().map(|row| times(inverse, row)).collect();
                for (bound, j) in bounded {
                    if bound >= best.map_or(now, |(_, value)| value) {
                        break;
                    }
                    let root = root_of(&spread, j);
                    // rows of L^-1 B
                    let rows: Vec<Vec<f64>> = (0..k).map(|r| blocks.row(j, r)).collect();
                    let b: Vec<Vec<f64>> = rows.iter().map(|x| columns.iter().map(|c| dot(x, c)).collect()).collect();
                    let of_root = |r: usize, c: usize| (0..=r).map(|s| root[packed(s, r)] * b[s][c]).sum::<f64>();
                    let white: Vec<Vec<f64>> = (0..k).map(|r| (0..p).map(|c| of_root(r, c)).collect()).collect();
                    let less = |i: usize, c: usize| white.iter().map(|row| row[i] * row[c]).sum::<f64>();
                    let left = Mat::from_fn(p, p, |i, c| own[(i, c)] - less(i, c));
                    state.effort += (k * n * p + 10 * p * p * p) as f64;
                    keep(&mut best, now, (j, largest_eigenvalue(&left)));
                }
            }
            Objective::Volume(own) => {
                let (without, slopes) = own.with_slopes(inverse)?;
                let deviations: Vec<f64> = inverse.iter().zip(&slopes).map(|(all, own)| all - own).collect();
                let beside = blocks.quadratics(&deviations);
                state.effort += (2 * count * n * n * k) as f64;
                // -2 log det L^-1 = log det(I + G)
                let log_det = |sums: &[Vec<f64>], j: usize| {
                    let root = root_of(sums, j);
                    -2.0 * (0..k).map(|r| root[packed(r, r)].ln()).sum::<f64>()
                };
                for j in replacements {
                    let value = ((without + log_det(&beside, j) - log_det(&spread, j)) / own.size()).exp();
                    keep(&mut best, now, (j, value));
                }
            }
        }
        best
    }

    /// The same where the block cannot be taken out: the most informative replacements, each with a factorisation of its own.
    pub(super) fn one_by_one(
        &self,
        state: &mut State<'_>,
        at: usize,
        without: &[f64],
        now: f64,
    ) -> Option<(usize, f64)> {
        let (blocks, n) = (state.problem.blocks, state.problem.blocks.unknowns());
        let mut replacements: Vec<usize> = (0..blocks.count()).filter(|j| state.allowed(at, *j)).collect();
        most_informative(&mut replacements, &state.spread, blocks.rows(), REPLACEMENTS);
        let mut best: Option<(usize, f64)> = None;
        for j in replacements {
            let mut m = without.to_vec();
            for r in 0..blocks.rows() {
                add_outer(&mut m, 1.0, &blocks.row(j, r));
            }
            let Some((inverse, _)) = super::blocks::invert(&m, n) else { continue };
            if let Some(value) = self.of(&inverse) {
                keep(&mut best, now, (j, value));
            }
        }
        state.effort += (REPLACEMENTS * n * n * n) as f64;
        best
    }
}

/// Keep a replacement that leaves less than `now` and than the best so far.
fn keep(best: &mut Option<(usize, f64)>, now: f64, (j, value): (usize, f64)) {
    if value < best.map_or(now, |(_, before)| before) {
        *best = Some((j, value));
    }
}

/// The candidates whose rows tell most, so many at most, by the sums over all candidates.
fn most_informative(list: &mut Vec<usize>, spread: &[Vec<f64>], k: usize, most: usize) {
    let told = |j: usize| (0..k).map(|r| spread[packed(r, r)][j]).sum::<f64>();
    list.sort_by(|a, b| told(*b).total_cmp(&told(*a)));
    list.truncate(most);
}

/// `|L^-1 b|^2`.
fn squared(root: &[f64], k: usize, b: impl Fn(usize) -> f64) -> f64 {
    (0..k).fold(0.0, |sum, r| {
        let y: f64 = (0..=r).map(|s| root[packed(s, r)] * b(s)).sum();
        sum + y * y
    })
}

/// `L^-1` of `I + G`, `L L' = I + G`; element (r, s), s <= r, at `packed(s, r)`.
fn inverse_root(k: usize, g: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let mut l = vec![0.0; k * (k + 1) / 2];
    for r in 0..k {
        for c in 0..=r {
            let sum: f64 = (0..c).map(|m| l[packed(m, r)] * l[packed(m, c)]).sum();
            let own = g(c, r) + f64::from(u8::from(r == c)) - sum;
            l[packed(c, r)] = if r == c { own.max(1e-300).sqrt() } else { own / l[packed(c, c)] };
        }
    }
    let mut inverse = vec![0.0; k * (k + 1) / 2];
    for c in 0..k {
        for r in c..k {
            let sum: f64 = (c..r).map(|m| l[packed(m, r)] * inverse[packed(c, m)]).sum();
            inverse[packed(c, r)] = (f64::from(u8::from(r == c)) - sum) / l[packed(r, r)];
        }
    }
    inverse
}

/// What is asked for: rows of `T`, in the coordinates of the blocks.
#[derive(Debug, Clone, PartialEq)]
pub struct Combinations(pub(super) Vec<Vec<f64>>);

impl Combinations {
    /// Each row one function of the unknowns.
    pub fn new(rows: Vec<Vec<f64>>) -> Self {
        Combinations(rows)
    }

    /// How many functions.
    pub(super) fn size(&self) -> f64 {
        self.0.len().max(1) as f64
    }

    /// `T'T`: the smooth criterion that is nearest, the sum of the variances.
    fn sum(&self) -> Vec<f64> {
        let n = self.0.first().map_or(0, Vec::len);
        let mut sum = vec![0.0; n * n];
        self.0.iter().for_each(|row| add_outer(&mut sum, 1.0, row));
        sum
    }

    /// `T A T'` for symmetric `A`, row by row.
    pub(super) fn image(&self, a: &[f64]) -> Mat<f64> {
        let along: Vec<Vec<f64>> = self.0.iter().map(|row| times(a, row)).collect();
        Mat::from_fn(self.0.len(), self.0.len(), |i, j| dot(&self.0[i], &along[j]))
    }

    /// Combination `T'v`.
    fn combined(&self, v: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut sum = vec![0.0; self.0.first().map_or(0, Vec::len)];
        for (k, row) in self.0.iter().enumerate() {
            let by = v(k);
            sum.iter_mut().zip(row).for_each(|(sum, x)| *sum += by * x);
        }
        sum
    }

    /// `T' Z T`, row by row, for symmetric `Z`.
    pub(super) fn weighted(&self, z: impl Fn(usize, usize) -> f64) -> Vec<f64> {
        let n = self.0.first().map_or(0, Vec::len);
        let mut w = vec![0.0; n * n];
        for (i, row) in self.0.iter().enumerate() {
            let other = self.combined(|k| z(i, k));
            for (out, x) in w.chunks_exact_mut(n.max(1)).zip(row) {
                out.iter_mut().zip(&other).for_each(|(out, y)| *out += x * y);
            }
        }
        w
    }

    /// `log det C`, and `M^-1 T' C^-1 T M^-1` row by row, whose quadratic forms are the slopes; `None` where `C` is singular.
    pub(super) fn with_slopes(&self, inverse: &[f64]) -> Option<(f64, Vec<f64>)> {
        let c = self.triangle(inverse)?;
        let weights = c.inverse();
        let w = self.weighted(|i, k| weights[i].at(k));
        Some((c.log_determinant(), sandwich(inverse, &w, self.0.first().map_or(0, Vec::len))))
    }

    /// `C`, factored.
    fn triangle(&self, inverse: &[f64]) -> Option<Triangle> {
        let c = self.image(inverse);
        Triangle::of(c.nrows(), |i, j| c[(i, j)], |i| 1e-14 * c[(i, i)])
    }
}

/// Largest eigenvalue of a symmetric matrix; not a number where there is none.
fn largest_eigenvalue(matrix: &Mat<f64>) -> f64 {
    match matrix.self_adjoint_eigenvalues(Side::Lower) {
        Ok(values) => values.into_iter().fold(f64::NEG_INFINITY, f64::max),
        Err(_) => f64::NAN,
    }
}
