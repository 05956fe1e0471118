//! Candidates as blocks of whitened rows, and the sums over all of them that the exchanges need.
#![allow(
    clippy::indexing_slicing,
    reason = "matrices are `n x n` row by row and indices run below `n`: callers give what `information` or `weighted` made of that size; packed matrices side by side have an entry for each pair of rows"
)]

use crate::elements::{Elements, Parts};
use crate::linear::{Triangle, dot};
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

/// `count` candidates, each `rows` whitened rows in `unknowns` coordinates; element (row, unknown) of all candidates lies together.
///
/// The information of a design is `M = M0 + sum over chosen j of X_j' X_j`, where `X_j` is `rows x unknowns`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Blocks {
    unknowns: usize,
    rows: usize,
    count: usize,
    /// Element (r, c) of candidate j at `(r * unknowns + c) * count + j`.
    data: Vec<f64>,
}

impl Blocks {
    /// Blocks from a function of candidate, row and unknown.
    pub fn from_fn(count: usize, rows: usize, unknowns: usize, element: impl Fn(usize, usize, usize) -> f64) -> Self {
        let mut data = Vec::with_capacity(count * rows * unknowns);
        for r in 0..rows {
            for c in 0..unknowns {
                data.extend((0..count).map(|j| element(j, r, c)));
            }
        }
        Blocks { unknowns, rows, count, data }
    }

    /// Some of the candidates.
    pub(super) fn subset(&self, chosen: &[usize]) -> Blocks {
        let element = |j: usize, r: usize, c: usize| {
            // `from_fn` asks within these bounds
            chosen.get(j).and_then(|j| self.column(r, c).get(*j)).copied().unwrap_or_default()
        };
        Blocks::from_fn(chosen.len(), self.rows, self.unknowns, element)
    }

    /// Number of candidates.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Rows of each candidate.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Coordinates.
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Row `r` of candidate `j`.
    pub fn row(&self, j: usize, r: usize) -> Vec<f64> {
        (0..self.unknowns).map(|c| self.column(r, c).at(j)).collect()
    }

    /// `M += s X_j'X_j`.
    pub(super) fn add(&self, m: &mut [f64], s: f64, j: usize) {
        (0..self.rows).for_each(|r| add_outer(m, s, &self.row(j, r)));
    }

    /// Element (r, c) of every candidate.
    pub(super) fn column(&self, r: usize, c: usize) -> &[f64] {
        let start = (r * self.unknowns + c) * self.count;
        self.data.part(start..start + self.count)
    }

    /// `x_jr . w` for every candidate j, for each row r.
    pub(super) fn products(&self, w: &[f64]) -> Vec<Vec<f64>> {
        (0..self.rows).map(|r| self.along(r, w)).collect()
    }

    /// `x_jr . w` for every candidate j; a shorter `w` is padded with zeros.
    fn along(&self, r: usize, w: &[f64]) -> Vec<f64> {
        // pieces that stay in the first-level cache
        const PIECE: usize = 256;
        let mut out = vec![0.0; self.count];
        for (start, piece) in (0..).step_by(PIECE).zip(out.chunks_mut(PIECE)) {
            let end = start + piece.len();
            let part = |c: usize| self.column(r, c).part(start..end);
            for (c, weights) in (0..).step_by(4).zip(w.chunks(4)) {
                match weights {
                    // four columns at a time: each sum is loaded and stored a quarter as often
                    [a, b, d, e] => {
                        let (p, q, s, t) = (part(c), part(c + 1), part(c + 2), part(c + 3));
                        for ((((out, p), q), s), t) in piece.iter_mut().zip(p).zip(q).zip(s).zip(t) {
                            *out += a * p + b * q + (d * s + e * t);
                        }
                    }
                    rest => {
                        for (a, c) in rest.iter().zip(c..) {
                            piece.iter_mut().zip(part(c)).for_each(|(out, p)| *out += a * p);
                        }
                    }
                }
            }
        }
        out
    }

    /// `x_jr' B x_js`, r <= s, of every candidate j at `packed(r, s)`; `b` is symmetric, row by row.
    pub(super) fn quadratics(&self, b: &[f64]) -> Vec<Vec<f64>> {
        let mut sums = vec![vec![0.0; self.count]; self.rows * (self.rows + 1) / 2];
        for s in 0..self.rows {
            for (c, row) in b.chunks_exact(self.unknowns.max(1)).enumerate() {
                let along = self.along(s, row);
                for r in 0..=s {
                    let terms = self.column(r, c).iter().zip(&along);
                    sums[packed(r, s)].iter_mut().zip(terms).for_each(|(sum, (x, w))| *sum += x * w);
                }
            }
        }
        sums
    }

    /// `M + sum w_j X_j'X_j`.
    pub(super) fn weighted(&self, base: &[f64], weights: &[f64]) -> Vec<f64> {
        let n = self.unknowns;
        let mut m = base.to_vec();
        for r in 0..self.rows {
            let scale = |c: usize| self.column(r, c).iter().zip(weights).map(|(x, w)| x * w);
            let scaled: Vec<f64> = (0..n).flat_map(scale).collect();
            let scaled = MatRef::from_column_major_slice(&scaled, self.count, n);
            let face = self.data.part(r * n * self.count..(r + 1) * n * self.count);
            let face = MatRef::from_column_major_slice(face, self.count, n);
            let sum = MatMut::from_column_major_slice_mut(&mut m, n, n);
            matmul(sum, Accum::Add, scaled.transpose(), face, 1.0, Par::Seq);
        }
        m
    }

    /// Sum of `x x'` over all rows of all candidates, row by row.
    pub(super) fn sum(&self) -> Vec<f64> {
        self.weighted(&vec![0.0; self.unknowns * self.unknowns], &vec![1.0; self.count])
    }

    /// The same information in as few rows as it has: `R'R = X'X` for each candidate.
    ///
    /// The rates of one mounting differ in size only, so that six readings of it may need no more than three rows.
    pub(super) fn compressed(&self) -> Blocks {
        let own = |j: usize| {
            let mut m = vec![0.0; self.unknowns * self.unknowns];
            self.add(&mut m, 1.0, j);
            roots(m, self.unknowns)
        };
        let reduced: Vec<Vec<Vec<f64>>> = (0..self.count).filter(|_| self.rows > 1).map(own).collect();
        let rows = reduced.iter().map(Vec::len).max().unwrap_or(self.rows).max(1);
        if rows >= self.rows {
            return self.clone();
        }
        let element = |j: usize, r: usize, c: usize| {
            // a portion of fewer rows is padded with rows of zeros, which have no information
            reduced.get(j).and_then(|rows| rows.get(r)?.get(c)).copied().unwrap_or_default()
        };
        Blocks::from_fn(self.count, rows, self.unknowns, element)
    }
}

/// Position of (r, s), r <= s, in a packed triangle.
pub(super) fn packed(r: usize, s: usize) -> usize {
    s * (s + 1) / 2 + r
}

/// The largest number of a list and its place, the first of equal ones; NaN is smaller than any number.
pub(super) fn largest(list: &[f64]) -> (usize, f64) {
    // the greatest of an empty list, or of not-a-numbers: minus infinity, which nobody takes
    let larger = |most: (usize, f64), (k, v): (usize, &f64)| if *v > most.1 { (k, *v) } else { most };
    list.iter().enumerate().fold((0, f64::NEG_INFINITY), larger)
}

/// A symmetric matrix that is stored row by row.
pub(super) fn square(a: &[f64], n: usize) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(a, n, n)
}

/// `A B`, column by column, on this thread: searches run side by side.
fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Vec<f64> {
    let (rows, columns) = (a.nrows(), b.ncols());
    let mut out = vec![0.0; rows * columns];
    matmul(MatMut::from_column_major_slice_mut(&mut out, rows, columns), Accum::Replace, a, b, 1.0, Par::Seq);
    out
}

/// `A v` for a square matrix stored row by row.
pub(super) fn times(a: &[f64], v: &[f64]) -> Vec<f64> {
    a.chunks_exact(v.len().max(1)).map(|row| dot(row, v)).collect()
}

/// `A += s v v'`.
pub(super) fn add_outer(a: &mut [f64], s: f64, v: &[f64]) {
    for (row, vi) in a.chunks_exact_mut(v.len().max(1)).zip(v) {
        let factor = s * vi;
        row.iter_mut().zip(v).for_each(|(a, vj)| *a += factor * vj);
    }
}

/// `A W A` for symmetric `A` and `W`.
pub(super) fn sandwich(a: &[f64], w: &[f64], n: usize) -> Vec<f64> {
    product(MatRef::from_column_major_slice(&product(square(a, n), square(w, n)), n, n), square(a, n))
}

/// Inverse and logarithm of the determinant of a symmetric positive definite matrix, row by row, by Cholesky; `None` where its smallest pivot is not
/// above 1e-12 of its largest diagonal element.
pub(super) fn invert(m: &[f64], n: usize) -> Option<(Vec<f64>, f64)> {
    let entry = |i: usize, j: usize| m.at(i * n + j);
    let largest = (0..n).fold(0.0_f64, |most, i| most.max(entry(i, i)));
    let triangle = Triangle::of(n, entry, |_| 1e-12 * largest)?;
    Some((triangle.inverse().concat(), triangle.log_determinant()))
}

/// Pivots below this share of the first are rounding: 2e-16 for each of some hundred unknowns.
const ROUNDING: f64 = 1e-13;

/// Rows of `R`, `R'R = M`, of a symmetric positive semidefinite matrix, row by row, by Cholesky with pivots: as many as its rank.
pub(super) fn roots(mut m: Vec<f64>, n: usize) -> Vec<Vec<f64>> {
    let mut rows: Vec<Vec<f64>> = Vec::new();
    let mut first = 0.0_f64;
    while rows.len() < n {
        let (pivot, square) = largest(&(0..n).map(|i| m[i * n + i]).collect::<Vec<f64>>());
        first = first.max(square);
        if !(square > ROUNDING * first) {
            break;
        }
        let row: Vec<f64> = m.part(pivot * n..(pivot + 1) * n).iter().map(|v| v / square.sqrt()).collect();
        add_outer(&mut m, -1.0, &row);
        rows.push(row);
    }
    rows
}

/// Rows of packed symmetric matrices.
pub(super) fn size(packed_sums: &[Vec<f64>]) -> usize {
    (0..).find(|m| packed(0, *m) >= packed_sums.len()).unwrap_or(0)
}

/// `T = L D L'` of symmetric matrices side by side, in place: pivots on the diagonal, `L` beside them; and `E <- L^-1 E L^-T` of others, if any.
pub(super) fn eliminate(t: &mut [Vec<f64>], e: &mut [Vec<f64>]) {
    let m = size(t);
    for c in 0..m {
        let shares: Vec<Vec<f64>> = (c + 1..m)
            .map(|s| t[packed(c, s)].iter().zip(&t[packed(c, c)]).map(|(t, pivot)| t / pivot).collect())
            .collect();
        let of = |s: usize| &shares[s - c - 1];
        for (r, s) in (c + 1..m).flat_map(|s| (c + 1..=s).map(move |r| (r, s))) {
            let mut own = std::mem::take(&mut t[packed(r, s)]);
            let terms = t[packed(c, r)].iter().zip(of(s));
            own.iter_mut().zip(terms).for_each(|(own, (t, f))| *own -= t * f);
            t[packed(r, s)] = own;
            if e.is_empty() {
                continue;
            }
            let mut own = std::mem::take(&mut e[packed(r, s)]);
            let first = e[packed(c, c)].iter().zip(&e[packed(c, r)]).zip(&e[packed(c, s)]);
            for ((own, ((cc, cr), cs)), (fr, fs)) in own.iter_mut().zip(first).zip(of(r).iter().zip(of(s))) {
                *own -= fr * cs + fs * cr - fr * fs * cc;
            }
            e[packed(r, s)] = own;
        }
        shares.into_iter().zip(c + 1..m).for_each(|(share, s)| t[packed(c, s)] = share);
    }
}

/// `|det T|` of every candidate, from pivots of which those after the first `k` are negative; zero where rounding has made them positive.
pub(super) fn shares(t: &[Vec<f64>], k: usize, count: usize) -> Vec<f64> {
    let mut shares = vec![1.0; count];
    for r in 0..size(t) {
        let sign = if r < k { 1.0 } else { -1.0 };
        shares.iter_mut().zip(&t[packed(r, r)]).for_each(|(share, pivot)| *share *= (sign * pivot).max(0.0));
    }
    shares
}

/// `y' D^-1 y` of every candidate, `L y = b`.
pub(super) fn squares(t: &[Vec<f64>], mut b: Vec<Vec<f64>>) -> Vec<f64> {
    let mut sum = vec![0.0; b.first().map_or(0, Vec::len)];
    for c in 0..b.len() {
        let (before, after) = b.split_at_mut(c + 1);
        let own = before.at(c);
        let terms = own.iter().zip(&t[packed(c, c)]);
        sum.iter_mut().zip(terms).for_each(|(sum, (y, pivot))| *sum += y * y / pivot);
        for (later, s) in after.iter_mut().zip(c + 1..) {
            later.iter_mut().zip(own.iter().zip(&t[packed(c, s)])).for_each(|(b, (y, l))| *b -= y * l);
        }
    }
    sum
}
