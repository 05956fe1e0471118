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
    /// Variances of the unknowns for a unit weight of variance 1, `n`.
    pub variance: Vec<Lane>,
    /// `sum (v/u)^2`, before any refinement.
    pub squares: Lane,
    /// At least the condition number of the scaled columns; not a number, or infinite, where there is none.
    pub condition: Lane,
    /// Observed minus fitted, `m`, in the unit of the observations; after refinement.
    pub residuals: Vec<Lane>,
    /// Leverages, `m`; after refinement.
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
        for list in [&mut self.solution, &mut self.variance, &mut self.lengths] {
            list.resize(n, zero);
        }
    }

    /// Solve: estimates, their variances and the sum of squares; with `refined` by one step of it, residuals and leverages.
    pub(crate) fn solve(&mut self, arch: Arch, refined: bool) {
        if self.m > 0 && self.n > 0 {
            arch.dispatch(Solve { eight: self, refined });
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
    refined: bool,
}

impl WithSimd for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Eight {
            m,
            n,
            rows,
            observed,
            weight,
            solution,
            variance,
            squares,
            condition,
            residuals,
            leverage,
            q,
            lengths,
            upper,
            directions,
        } = self.eight;
        let (m, n) = (*m, *n);
        let width = LANES / S::F64_LANES;
        if width == 0 {
            return;
        }
        let (rows, _) = S::as_simd_f64s(rows.as_flattened());
        let (observed, _) = S::as_simd_f64s(observed.as_flattened());
        let (weight, _) = S::as_simd_f64s(weight.as_flattened());
        let (q, _) = S::as_mut_simd_f64s(q.as_flattened_mut());
        let (lengths, _) = S::as_mut_simd_f64s(lengths.as_flattened_mut());
        let (upper, _) = S::as_mut_simd_f64s(upper.as_flattened_mut());
        let (directions, _) = S::as_mut_simd_f64s(directions.as_flattened_mut());
        let (solution, _) = S::as_mut_simd_f64s(solution.as_flattened_mut());
        let (variance, _) = S::as_mut_simd_f64s(variance.as_flattened_mut());
        let (squares, _) = S::as_mut_simd_f64s(squares.as_mut_slice());
        let (condition, _) = S::as_mut_simd_f64s(condition.as_mut_slice());
        let (residuals, _) = S::as_mut_simd_f64s(residuals.as_flattened_mut());
        let (leverage, _) = S::as_mut_simd_f64s(leverage.as_flattened_mut());
        let column = m * width;
        let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        let own = rows.chunks_exact(column).chain(std::iter::once(observed));
        for (to, from) in q.chunks_exact_mut(column).zip(own) {
            for ((to, a), w) in to.iter_mut().zip(from).zip(weight) {
                *to = simd.mul_f64s(*a, *w);
            }
        }
        // Q U, and what of the observations goes along Q
        for k in 0..n {
            let (before, after) = q.split_at_mut((k + 1) * column);
            let own = &before[k * column..];
            let mut reciprocal = [zero; LANES];
            for l in 0..width {
                let length = dot(simd, own, own, (width, l));
                lengths[k * width + l] = length;
                reciprocal[l] = simd.div_f64s(one, length);
            }
            let mut j = k + 1;
            let mut pairs = after.chunks_exact_mut(2 * column);
            for pair in &mut pairs {
                let (left, right) = pair.split_at_mut(column);
                for l in 0..width {
                    let [a, b] = project(simd, own, [left, right], reciprocal[l], (width, l));
                    upper[(j * n + k) * width + l] = a;
                    upper[((j + 1) * n + k) * width + l] = b;
                }
                j += 2;
            }
            let last = pairs.into_remainder();
            if last.len() == column {
                for l in 0..width {
                    let along = simd.mul_f64s(dot(simd, own, last, (width, l)), reciprocal[l]);
                    subtract(simd, own, last, along, (width, l));
                    upper[(j * n + k) * width + l] = along;
                }
            }
        }
        for l in 0..width {
            let at = |i: usize, j: usize| (j * n + i) * width + l;
            // U^-1, and the condition number from the lengths of the columns of A, which are those of D^1/2 U
            let mut sum_of_shares = zero;
            for j in 0..n {
                directions[at(j, j)] = one;
                for i in (0..j).rev() {
                    let mut sum = upper[at(i, j)];
                    for k in i + 1..j {
                        sum = simd.mul_add_f64s(upper[at(i, k)], directions[at(k, j)], sum);
                    }
                    directions[at(i, j)] = simd.neg_f64s(sum);
                }
                for i in j + 1..n {
                    directions[at(i, j)] = zero;
                }
            }
            for i in 0..n {
                let mut sum = upper[(n * n + i) * width + l];
                for k in i + 1..n {
                    sum = simd.mul_add_f64s(directions[at(i, k)], upper[(n * n + k) * width + l], sum);
                }
                solution[i * width + l] = sum;
            }
            for j in 0..n {
                let root = simd.div_f64s(one, simd.sqrt_f64s(lengths[j * width + l]));
                for i in 0..=j {
                    directions[at(i, j)] = simd.mul_f64s(directions[at(i, j)], root);
                }
            }
            for i in 0..n {
                let (mut own, mut norm) = (zero, lengths[i * width + l]);
                for k in i..n {
                    own = simd.mul_add_f64s(directions[at(i, k)], directions[at(i, k)], own);
                }
                for k in 0..i {
                    let part = simd.mul_f64s(upper[at(k, i)], upper[at(k, i)]);
                    norm = simd.mul_add_f64s(part, lengths[k * width + l], norm);
                }
                variance[i * width + l] = own;
                sum_of_shares = simd.mul_add_f64s(own, norm, sum_of_shares);
            }
            condition[l] = simd.sqrt_f64s(simd.mul_f64s(sum_of_shares, simd.splat_f64s(n as f64)));
            let rest = &q[n * column..];
            squares[l] = dot(simd, rest, rest, (width, l));
        }
        if !self.refined {
            return;
        }
        for l in 0..width {
            left(simd, rows, observed, solution, residuals, (n, column, width, l));
        }
        let (q, rest) = q.split_at_mut(n * column);
        for ((to, v), w) in rest.iter_mut().zip(residuals.iter()).zip(weight) {
            *to = simd.mul_f64s(*v, *w);
        }
        for l in 0..width {
            for k in 0..n {
                let own = &q[k * column..(k + 1) * column];
                let root = simd.sqrt_f64s(lengths[k * width + l]);
                let along = simd.div_f64s(dot(simd, own, rest, (width, l)), root);
                for i in 0..=k {
                    let to = &mut solution[i * width + l];
                    *to = simd.mul_add_f64s(directions[(k * n + i) * width + l], along, *to);
                }
            }
            left(simd, rows, observed, solution, residuals, (n, column, width, l));
        }
        leverage.fill(zero);
        for (k, own) in q.chunks_exact(column).enumerate() {
            let mut reciprocal = [zero; LANES];
            for l in 0..width {
                reciprocal[l] = simd.div_f64s(one, lengths[k * width + l]);
            }
            for (h, own) in leverage.chunks_exact_mut(width).zip(own.chunks_exact(width)) {
                for l in 0..width {
                    h[l] = simd.mul_add_f64s(simd.mul_f64s(own[l], own[l]), reciprocal[l], h[l]);
                }
            }
        }
    }
}

/// Product of two columns, for the vectors at `l` of `width`, in four sums.
#[inline(always)]
fn dot<S: Simd>(simd: S, a: &[S::f64s], b: &[S::f64s], (width, l): (usize, usize)) -> S::f64s {
    let mut sums = [simd.splat_f64s(0.0); 4];
    let (fours, others) = (a.chunks_exact(4 * width), b.chunks_exact(4 * width));
    let (rest, of_others) = (fours.remainder(), others.remainder());
    for (a, b) in fours.zip(others) {
        for (t, sum) in sums.iter_mut().enumerate() {
            *sum = simd.mul_add_f64s(a[t * width + l], b[t * width + l], *sum);
        }
    }
    for (a, b) in rest.chunks_exact(width).zip(of_others.chunks_exact(width)) {
        sums[0] = simd.mul_add_f64s(a[l], b[l], sums[0]);
    }
    simd.add_f64s(simd.add_f64s(sums[0], sums[1]), simd.add_f64s(sums[2], sums[3]))
}

/// `along = q'x / q'q`, `x -= q along`, for two columns at once.
#[inline(always)]
fn project<S: Simd>(
    simd: S,
    q: &[S::f64s],
    [x, y]: [&mut [S::f64s]; 2],
    reciprocal: S::f64s,
    (width, l): (usize, usize),
) -> [S::f64s; 2] {
    let zero = simd.splat_f64s(0.0);
    let (mut a, mut b) = ([zero; 2], [zero; 2]);
    let twos = q.chunks_exact(2 * width).zip(x.chunks_exact(2 * width)).zip(y.chunks_exact(2 * width));
    for ((q, x), y) in twos {
        for t in 0..2 {
            let own = q[t * width + l];
            a[t] = simd.mul_add_f64s(own, x[t * width + l], a[t]);
            b[t] = simd.mul_add_f64s(own, y[t * width + l], b[t]);
        }
    }
    let whole = q.len() / (2 * width) * (2 * width);
    for ((q, x), y) in
        q[whole..].chunks_exact(width).zip(x[whole..].chunks_exact(width)).zip(y[whole..].chunks_exact(width))
    {
        a[0] = simd.mul_add_f64s(q[l], x[l], a[0]);
        b[0] = simd.mul_add_f64s(q[l], y[l], b[0]);
    }
    let along = [a, b].map(|[even, odd]| simd.mul_f64s(simd.add_f64s(even, odd), reciprocal));
    let minus = along.map(|along| simd.neg_f64s(along));
    let rows = q.chunks_exact(width).zip(x.chunks_exact_mut(width)).zip(y.chunks_exact_mut(width));
    for ((q, x), y) in rows {
        x[l] = simd.mul_add_f64s(q[l], minus[0], x[l]);
        y[l] = simd.mul_add_f64s(q[l], minus[1], y[l]);
    }
    along
}

/// `x -= q along`.
#[inline(always)]
fn subtract<S: Simd>(simd: S, q: &[S::f64s], x: &mut [S::f64s], along: S::f64s, (width, l): (usize, usize)) {
    let minus = simd.neg_f64s(along);
    for (x, q) in x.chunks_exact_mut(width).zip(q.chunks_exact(width)) {
        x[l] = simd.mul_add_f64s(q[l], minus, x[l]);
    }
}

/// `v = y - A x`, accumulated as high + low, for the vectors at `l` of `width`.
#[inline(always)]
fn left<S: Simd>(
    simd: S,
    rows: &[S::f64s],
    observed: &[S::f64s],
    x: &[S::f64s],
    v: &mut [S::f64s],
    (n, column, width, l): (usize, usize, usize, usize),
) {
    let mut i = l;
    while i < column {
        let (mut high, mut low) = (observed[i], simd.splat_f64s(0.0));
        for j in 0..n {
            let (a, x) = (rows[j * column + i], x[j * width + l]);
            let product = simd.mul_f64s(a, x);
            let minus = simd.neg_f64s(product);
            let below = simd.mul_add_f64s(a, x, minus);
            let sum = simd.add_f64s(high, minus);
            let back = simd.sub_f64s(sum, high);
            let error = simd.add_f64s(simd.sub_f64s(high, simd.sub_f64s(sum, back)), simd.sub_f64s(minus, back));
            high = sum;
            low = simd.add_f64s(low, simd.sub_f64s(error, below));
        }
        v[i] = simd.add_f64s(high, low);
        i += width;
    }
}
