//! Eight systems of one shape side by side: each number of a vector register belongs to another system.
//!
//! ```text
//! W [A y] = Q [U c; 0 1],   x = U^-1 c,   r = y - A x in twice the working precision,   x += U^-1 D^-1 Q' W r,   D = Q'Q
//! ```
//!
//! `U` has ones on its diagonal; `Q` by modified Gram-Schmidt with the observations carried along, which is as stable for least squares as
//! reflections are (A. Bjorck, Solving linear least squares problems by Gram-Schmidt orthogonalization, BIT 7 (1967)), and needs neither
//! roots nor columns of length 1. No columns are exchanged: what is not far from any rank defect is told by the condition number, and
//! everything else is for `adjust`. Instructions are chosen at run time (`pulp`).
#![allow(
    clippy::indexing_slicing,
    reason = "`shape` makes every list as long as `m` and `n` say, in lanes of eight; indices run below `m`, `n` and the registers of a lane"
)]

use pulp::{Arch, Simd, WithSimd};

/// Systems side by side.
pub(crate) const LANES: usize = 8;
/// One number of each system.
pub(crate) type Lane = [f64; LANES];

/// Systems with `m` rows in `n` unknowns, and what was found of them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Eight {
    m: usize,
    n: usize,
    /// Columns one after the other, `n x m`.
    pub rows: Vec<Lane>,
    /// `m`.
    pub observed: Vec<Lane>,
    /// Reciprocals of the rows' standard uncertainties, `m`.
    pub weight: Vec<Lane>,
    /// `n`.
    pub solution: Vec<Lane>,
    /// At least the condition number of the scaled columns; not a number, or infinite, where there is none.
    pub condition: Lane,
    /// Observed minus fitted, `m`, in the unit of the observations.
    pub residuals: Vec<Lane>,
    /// Leverages, `m`.
    pub leverage: Vec<Lane>,
    /// Orthogonal columns and the weighted residuals, one after the other, `(n + 1) x m`.
    q: Vec<Lane>,
    /// Squared lengths of the columns, `n`.
    lengths: Vec<Lane>,
    /// `U` with `c`, column by column, `(n + 1) x n`.
    upper: Vec<Lane>,
    /// `U^-1 D^-1/2`, column by column, `n x n`; zero below the diagonal.
    directions: Vec<Lane>,
}

impl Eight {
    /// Room for systems of this shape; rows, observations and weights are those of before.
    pub(crate) fn shape(&mut self, m: usize, n: usize) {
        let zero = [0.0; LANES];
        (self.m, self.n) = (m, n);
        self.rows.resize(n * m, zero);
        self.q.resize((n + 1) * m, zero);
        for list in [&mut self.observed, &mut self.weight, &mut self.residuals, &mut self.leverage] {
            list.resize(m, zero);
        }
        self.upper.resize((n + 1) * n, zero);
        self.directions.resize(n * n, zero);
        for list in [&mut self.solution, &mut self.lengths] {
            list.resize(n, zero);
        }
    }

    /// Solve, and refine by one step.
    pub(crate) fn solve(&mut self, arch: Arch) {
        if self.m > 0 && self.n > 0 {
            arch.dispatch(Solve { eight: self });
        }
    }

    /// Covariance of two unknowns for a unit weight of variance 1.
    pub(crate) fn cofactor(&self, i: usize, j: usize, lane: usize) -> f64 {
        let at = |i: usize, k: usize| self.directions.get(k * self.n + i).map_or(0.0, |own| own[lane]);
        (i.max(j)..self.n).map(|k| at(i, k) * at(j, k)).sum()
    }

    /// A number of the orthonormal columns.
    pub(crate) fn orthonormal(&self, row: usize, column: usize, lane: usize) -> f64 {
        let length = self.lengths.get(column).map_or(f64::NAN, |own| own[lane].sqrt());
        self.q.get(column * self.m + row).map_or(0.0, |own| own[lane] / length)
    }
}

struct Solve<'a> {
    eight: &'a mut Eight,
}

impl WithSimd for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Eight { m, n, rows, observed, weight, solution, condition, residuals, .. } = self.eight;
        let Eight { leverage, q, lengths, upper, directions, .. } = self.eight;
        let (m, n) = (*m, *n);
        for (to, from) in q.chunks_exact_mut(m).zip(rows.chunks_exact(m).chain([observed.as_slice()])) {
            to.iter_mut().zip(from).zip(&*weight).for_each(|((to, a), w)| *to = times(a, w));
        }
        // Q U, and what of the observations goes along Q
        for k in 0..n {
            let (before, after) = q.split_at_mut((k + 1) * m);
            let own = &before[k * m..];
            lengths[k] = dot(own, own);
            let reciprocal = each(|l| 1.0 / lengths[k][l]);
            for (j, x) in (k + 1..).zip(after.chunks_exact_mut(m)) {
                let along = times(&dot(own, x), &reciprocal);
                x.iter_mut().zip(own).for_each(|(x, q)| *x = each(|l| q[l].mul_add(-along[l], x[l])));
                upper[j * n + k] = along;
            }
        }
        let at = |i: usize, j: usize| j * n + i;
        // U^-1, and the condition number from the lengths of the columns of A, which are those of D^1/2 U
        let mut sum_of_shares = ZERO;
        for j in 0..n {
            directions[at(j, j)] = [1.0; LANES];
            for i in (0..j).rev() {
                let mut sum = upper[at(i, j)];
                (i + 1..j).for_each(|k| plus(&mut sum, &upper[at(i, k)], &directions[at(k, j)]));
                directions[at(i, j)] = each(|l| -sum[l]);
            }
            (j + 1..n).for_each(|i| directions[at(i, j)] = ZERO);
        }
        for i in 0..n {
            let mut sum = upper[at(i, n)];
            (i + 1..n).for_each(|k| plus(&mut sum, &directions[at(i, k)], &upper[at(k, n)]));
            solution[i] = sum;
        }
        for j in 0..n {
            let root = each(|l| 1.0 / lengths[j][l].sqrt());
            (0..=j).for_each(|i| directions[at(i, j)] = times(&directions[at(i, j)], &root));
        }
        for i in 0..n {
            let (mut own, mut norm) = (ZERO, lengths[i]);
            (i..n).for_each(|k| plus(&mut own, &directions[at(i, k)], &directions[at(i, k)]));
            (0..i).for_each(|k| plus(&mut norm, &times(&upper[at(k, i)], &upper[at(k, i)]), &lengths[k]));
            plus(&mut sum_of_shares, &own, &norm);
        }
        *condition = each(|l| (sum_of_shares[l] * n as f64).sqrt());
        let (q, rest) = q.split_at_mut(n * m);
        left(|i, j| rows[j * m + i], observed, solution, residuals);
        rest.iter_mut().zip(&*residuals).zip(&*weight).for_each(|((to, v), w)| *to = times(v, w));
        leverage.fill(ZERO);
        for (k, own) in q.chunks_exact(m).enumerate() {
            let along = dot(own, rest);
            let along = each(|l| along[l] / lengths[k][l].sqrt());
            (0..=k).for_each(|i| plus(&mut solution[i], &directions[at(i, k)], &along));
            let reciprocal = each(|l| 1.0 / lengths[k][l]);
            leverage.iter_mut().zip(own).for_each(|(h, q)| plus(h, &times(q, q), &reciprocal));
        }
        left(|i, j| rows[j * m + i], observed, solution, residuals);
    }
}

const ZERO: Lane = [0.0; LANES];

/// Each number of a lane.
#[inline(always)]
fn each(part: impl Fn(usize) -> f64) -> Lane {
    let mut all = ZERO;
    (0..LANES).for_each(|l| all[l] = part(l));
    all
}

#[inline(always)]
fn times(a: &Lane, b: &Lane) -> Lane {
    each(|l| a[l] * b[l])
}

/// `sum += a b`.
#[inline(always)]
pub(crate) fn plus(sum: &mut Lane, a: &Lane, b: &Lane) {
    *sum = each(|l| a[l].mul_add(b[l], sum[l]));
}

/// Product of two columns, in two sums.
#[inline(always)]
fn dot(a: &[Lane], b: &[Lane]) -> Lane {
    let ((twos, rest), (others, of_others)) = (a.as_chunks::<2>(), b.as_chunks::<2>());
    let (mut even, mut odd) = (ZERO, ZERO);
    for ([a, c], [b, d]) in twos.iter().zip(others) {
        plus(&mut even, a, b);
        plus(&mut odd, c, d);
    }
    rest.iter().zip(of_others).for_each(|(a, b)| plus(&mut even, a, b));
    each(|l| even[l] + odd[l])
}

/// `v = y - A x`, accumulated as high + low; `a` has the numbers of a row and an unknown.
#[inline(always)]
pub(crate) fn left(a: impl Fn(usize, usize) -> Lane, observed: &[Lane], x: &[Lane], v: &mut [Lane]) {
    for (i, v) in v.iter_mut().enumerate() {
        let (mut high, mut low) = (observed[i], ZERO);
        for (j, x) in x.iter().enumerate() {
            let a = a(i, j);
            for l in 0..LANES {
                let product = a[l] * x[l];
                let below = a[l].mul_add(x[l], -product);
                let sum = high[l] - product;
                let back = sum - high[l];
                let error = (high[l] - (sum - back)) + (-product - back);
                high[l] = sum;
                low[l] += error - below;
            }
        }
        *v = each(|l| high[l] + low[l]);
    }
}
