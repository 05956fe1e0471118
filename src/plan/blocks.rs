//! Candidates as blocks of whitened rows, and the sums over all of them that the exchanges need.
#![allow(
    clippy::indexing_slicing,
    reason = "matrices are `n x n` row by row and indices run below `n`: callers give what `information`, `weighted` or a border of 2 k rows made of that size"
)]

use crate::elements::{Elements, Parts};
use crate::linear::{Triangle, dot};

/// `count` candidates, each `rows` whitened rows in `unknowns` coordinates; element (row, unknown) of all candidates lies together.
///
/// The information of a design is `M = M0 + sum over chosen j of X_j' X_j`, where `X_j` is `rows x unknowns`.
#[derive(Debug, Clone, PartialEq)]
pub struct Blocks {
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

    /// `M += s x x'` for row `r` of candidate `j`; `x` is scratch for a row.
    pub(super) fn add_row(&self, m: &mut [f64], s: f64, j: usize, r: usize, x: &mut Vec<f64>) {
        x.clear();
        x.extend((0..self.unknowns).map(|c| self.column(r, c).at(j)));
        add_outer(m, s, x);
    }

    /// Element (r, c) of every candidate.
    pub(super) fn column(&self, r: usize, c: usize) -> &[f64] {
        let start = (r * self.unknowns + c) * self.count;
        self.data.part(start..start + self.count)
    }

    /// `x_jr . w` for every candidate j, into `out`; a shorter `w` is padded with zeros.
    pub(super) fn along(&self, r: usize, w: &[f64], out: &mut [f64]) {
        // pieces that stay in the first-level cache
        const PIECE: usize = 256;
        let mut start = 0;
        for piece in out.chunks_mut(PIECE) {
            let end = start + piece.len();
            let part = |c: usize| self.column(r, c).part(start..end);
            piece.fill(0.0);
            let mut c = 0;
            loop {
                match w.get(c..) {
                    // four columns at a time: each sum is loaded and stored a quarter as often
                    Some([a, b, d, e, ..]) => {
                        let (p, q, s, t) = (part(c), part(c + 1), part(c + 2), part(c + 3));
                        for ((((out, p), q), s), t) in piece.iter_mut().zip(p).zip(q).zip(s).zip(t) {
                            *out += a * p + b * q + (d * s + e * t);
                        }
                        c += 4;
                    }
                    Some([a, ..]) => {
                        piece.iter_mut().zip(part(c)).for_each(|(out, p)| *out += a * p);
                        c += 1;
                    }
                    _ => break,
                }
            }
            start = end;
        }
    }

    /// `x_jr' B x_js` for every candidate j, into `out`; `b` is symmetric, row by row.
    pub(super) fn quadratic(&self, r: usize, s: usize, b: &[f64], out: &mut [f64], work: &mut [f64]) {
        out.fill(0.0);
        for c in 0..self.unknowns {
            let row = b.part(c * self.unknowns..(c + 1) * self.unknowns);
            self.along(s, row, work);
            for ((out, x), w) in out.iter_mut().zip(self.column(r, c)).zip(work.iter()) {
                *out += x * w;
            }
        }
    }

    /// The same for all r <= s, each at `packed(r, s)`.
    pub(super) fn all_quadratics(&self, b: &[f64], out: &mut [Vec<f64>], work: &mut [f64]) {
        for s in 0..self.rows {
            (0..=s).for_each(|r| self.quadratic(r, s, b, &mut out[packed(r, s)], work));
        }
    }

    /// The same in a new list.
    pub(super) fn quadratics(&self, b: &[f64]) -> Vec<Vec<f64>> {
        let mut out = vec![vec![0.0; self.count]; self.rows * (self.rows + 1) / 2];
        self.all_quadratics(b, &mut out, &mut vec![0.0; self.count]);
        out
    }

    /// The largest `x' B x` over all rows of all candidates.
    pub(super) fn largest_quadratic(&self, b: &[f64]) -> f64 {
        let (mut out, mut work) = (vec![0.0; self.count], vec![0.0; self.count]);
        let mut most = 0.0_f64;
        for r in 0..self.rows {
            self.quadratic(r, r, b, &mut out, &mut work);
            most = out.iter().fold(most, |most, d| most.max(*d));
        }
        most
    }

    /// The largest square of any element.
    pub(super) fn largest_square(&self) -> f64 {
        self.data.iter().fold(0.0_f64, |most, v| most.max(v * v))
    }

    /// Sum of `x x'` over all rows of all candidates, row by row.
    pub(super) fn sum(&self) -> Vec<f64> {
        let mut sum = vec![0.0; self.unknowns * self.unknowns];
        for j in 0..self.count {
            for r in 0..self.rows {
                add_outer(&mut sum, 1.0, &self.row(j, r));
            }
        }
        sum
    }

    /// The same information in as few rows as it has: `R'R = X'X` for each candidate, by Gram-Schmidt with column pivots.
    ///
    /// The rates of one mounting differ in size only, so that six readings of it may need no more than three rows.
    pub(super) fn compressed(&self) -> Blocks {
        let reduced: Vec<Vec<Vec<f64>>> = (0..self.count).map(|j| self.reduced(j)).collect();
        let rows = reduced.iter().map(Vec::len).max().unwrap_or(0).max(1);
        if rows >= self.rows {
            return self.clone();
        }
        let element = |j: usize, r: usize, c: usize| {
            // a portion of fewer rows is padded with rows of zeros, which have no information
            reduced.get(j).and_then(|rows| rows.get(r)?.get(c)).copied().unwrap_or_default()
        };
        Blocks::from_fn(self.count, rows, self.unknowns, element)
    }

    /// Rows of `R` for one candidate.
    fn reduced(&self, j: usize) -> Vec<Vec<f64>> {
        let mut columns: Vec<Vec<f64>> =
            (0..self.unknowns).map(|c| (0..self.rows).map(|r| self.column(r, c).at(j)).collect()).collect();
        let mut rows: Vec<Vec<f64>> = Vec::new();
        let mut first = 0.0_f64;
        while rows.len() < self.rows.min(self.unknowns) {
            let squares: Vec<f64> = columns.iter().map(|c| dot(c, c)).collect();
            let (pivot, square) = largest(&squares);
            first = first.max(square);
            if !(square > 1e-28 * first) {
                break;
            }
            let size = square.sqrt();
            let direction: Vec<f64> = columns.get(pivot).into_iter().flatten().map(|v| v / size).collect();
            let row: Vec<f64> = columns.iter().map(|c| dot(c, &direction)).collect();
            for (column, along) in columns.iter_mut().zip(&row) {
                column.iter_mut().zip(&direction).for_each(|(v, d)| *v -= along * d);
            }
            rows.push(row);
        }
        rows
    }

    /// `|L^-1 x_jr|^2` for every candidate j, into `out`; `root` is the lower triangle `L^-1`, row by row.
    pub(super) fn squares(&self, r: usize, root: &[f64], out: &mut [f64], work: &mut [f64]) {
        out.fill(0.0);
        for (k, row) in root.chunks_exact(self.unknowns.max(1)).enumerate() {
            self.along(r, row.part(..=k), work);
            out.iter_mut().zip(work.iter()).for_each(|(out, w)| *out += w * w);
        }
    }
}

/// Position of (r, s), r <= s, in a packed triangle.
pub(super) fn packed(r: usize, s: usize) -> usize {
    s * (s + 1) / 2 + r
}

/// The largest number of a list and its place; NaN is smaller than any number.
pub(super) fn largest(list: &[f64]) -> (usize, f64) {
    let mut lanes = [f64::NEG_INFINITY; 8];
    for piece in list.chunks(8) {
        lanes.iter_mut().zip(piece).for_each(|(most, v)| *most = if *v > *most { *v } else { *most });
    }
    let most = lanes.into_iter().fold(f64::NEG_INFINITY, f64::max);
    // the greatest of an empty list, or of not-a-numbers: minus infinity, which nobody takes
    (list.iter().position(|v| *v == most).unwrap_or(0), most)
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
    let product = |p: &[f64], q: &[f64]| {
        let mut out = vec![0.0; n * n];
        for i in 0..n {
            for k in 0..n {
                let factor = p[i * n + k];
                for j in 0..n {
                    out[i * n + j] += factor * q[k * n + j];
                }
            }
        }
        out
    };
    product(&product(a, w), a)
}

/// Inverse and logarithm of the determinant of a symmetric positive definite matrix, row by row, by Cholesky; `None` where it is singular.
pub(super) fn invert(m: &[f64], n: usize) -> Option<(Vec<f64>, f64)> {
    let triangle = triangle(m, n)?;
    Some((triangle.inverse().concat(), triangle.log_determinant()))
}

/// The same with `L^-1`, `M = L L'`.
pub(super) fn inverse_and_root(m: &[f64], n: usize) -> Option<(Vec<f64>, Vec<f64>, f64)> {
    let triangle = triangle(m, n)?;
    let columns = triangle.inverse_columns();
    let root = (0..n).flat_map(|i| columns.iter().map(move |column| column.at(i)));
    Some((triangle.inverse().concat(), root.collect(), triangle.log_determinant()))
}

/// Cholesky's triangle of a matrix whose smallest pivot is above 1e-12 of its largest diagonal element.
fn triangle(m: &[f64], n: usize) -> Option<Triangle> {
    let entry = |i: usize, j: usize| m.at(i * n + j);
    let largest = (0..n).fold(0.0_f64, |most, i| most.max(entry(i, i)));
    Triangle::of(n, entry, |_| 1e-12 * largest)
}

/// Determinant of `t` and trace of `t^-1 f`, both `n x n` row by row, by elimination with row pivots; `t` and `f` are overwritten.
pub(super) fn determinant_and_trace(t: &mut [f64], f: &mut [f64], n: usize) -> (f64, f64) {
    let mut determinant = 1.0;
    for k in 0..n {
        // k itself is among them
        let pivot = (k..n).max_by(|&a, &b| t[a * n + k].abs().total_cmp(&t[b * n + k].abs())).unwrap_or(k);
        if pivot != k {
            determinant = -determinant;
            for c in 0..n {
                t.swap(k * n + c, pivot * n + c);
                f.swap(k * n + c, pivot * n + c);
            }
        }
        let d = t[k * n + k];
        determinant *= d;
        if d == 0.0 {
            return (0.0, 0.0);
        }
        for i in k + 1..n {
            let factor = t[i * n + k] / d;
            if factor != 0.0 {
                for c in k..n {
                    t[i * n + c] -= factor * t[k * n + c];
                }
                for c in 0..n {
                    f[i * n + c] -= factor * f[k * n + c];
                }
            }
        }
    }
    // back substitution column by column; only the diagonal of the solution is needed
    let mut trace = 0.0;
    let mut z = vec![0.0; n];
    for c in 0..n {
        for i in (c..n).rev() {
            let sum: f64 = (i + 1..n).map(|k| t[i * n + k] * z[k]).sum();
            z[i] = (f[i * n + c] - sum) / t[i * n + i];
        }
        trace += z[c];
    }
    (determinant, trace)
}

/// Rank of a symmetric positive semidefinite matrix, row by row, by Cholesky with pivots.
pub(super) fn rank(m: &[f64], n: usize) -> usize {
    let mut remainder = m.to_vec();
    let diagonal = |remainder: &[f64]| (0..n).map(|i| remainder[i * n + i]).collect::<Vec<f64>>();
    let first = largest(&diagonal(&remainder)).1;
    let mut rank = 0;
    while rank < n {
        let (pivot, square) = largest(&diagonal(&remainder));
        if !(square > 1e-11 * first) || !(first > 0.0) {
            break;
        }
        let column: Vec<f64> = (0..n).map(|i| remainder[i * n + pivot] / square.sqrt()).collect();
        add_outer(&mut remainder, -1.0, &column);
        rank += 1;
    }
    rank
}
