//! A column-pivoted Householder QR before anything is said about rank: faer's, sequential, with `Q` formed explicitly, or for few rows by plain loops. G. H. Golub,
//! C. F. Van Loan, Matrix Computations, 5.4.2.
#![allow(
    clippy::indexing_slicing,
    reason = "`order` is a permutation of places among `active`; `work` holds `k` columns of `m` rows, squares and computed have `k` entries and reflections `min(m, k)`, all made here"
)]

use crate::linear::short_dot;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::{householder, qr};
use faer::{Conj, Mat, Par};

/// A pivoted QR of some columns, before anything is said about rank.
pub(super) struct Pivoted {
    /// Thin, `m x min(m, k)`.
    pub q: Mat<f64>,
    /// Upper trapezoidal, `min(m, k) x k`; below its diagonal lies what faer keeps there.
    pub r: Mat<f64>,
    /// Columns in pivot order.
    pub order: Vec<usize>,
    /// How many leading diagonal elements stand above the tolerance.
    pub rank: usize,
}

impl Pivoted {
    pub fn new(q: Mat<f64>, r: Mat<f64>, order: Vec<usize>, tolerance: f64) -> Self {
        let size = r.nrows();
        let largest = if size > 0 { r[(0, 0)].abs() } else { 0.0 };
        // Negated, so that anything not comparable counts as dependent.
        let rank = (0..size).take_while(|&i| r[(i, i)].abs() > tolerance * largest).count();
        Pivoted { q, r, order, rank }
    }

    /// Whether a column behind the first negligible one is not negligible.
    pub fn hides_a_larger_column(&self, tolerance: f64) -> bool {
        let (size, k, rank) = (self.r.nrows(), self.r.ncols(), self.rank);
        let Some(limit) = (rank < size).then(|| tolerance * self.r[(0, 0)].abs()) else { return false };
        (rank + 1..k).any(|j| {
            let squares: f64 = (rank..size.min(j + 1)).map(|i| self.r[(i, j)].powi(2)).sum();
            squares.sqrt() > limit
        })
    }
}

/// Elements up to which plain loops are the faster way: blocks of reflections and their scratch cost more than such a factorisation itself.
const MOST: usize = 4096;
/// A column whose updated norm has lost so much of the computed one is computed again.
const LOST: f64 = 1e-6;
/// From so many rows on reflections are applied one by one: joining them into blocks would pack kilobytes for each row.
const TALL: usize = 8192;

/// Column-pivoted Householder QR of the columns `active` of `scaled`, whose norms are 1.
pub(super) fn pivoted_qr(scaled: &Mat<f64>, active: &[usize], tolerance: f64) -> Pivoted {
    let (m, k) = (scaled.nrows(), active.len());
    let size = m.min(k);
    if m * k <= MOST {
        return of_few(scaled, active, tolerance);
    }
    let mut work = Mat::zeros(m, k);
    for (l, &j) in active.iter().enumerate() {
        work.col_as_slice_mut(l).copy_from_slice(scaled.col_as_slice(j));
    }
    let block = match m > TALL {
        true => 1,
        false => qr::no_pivoting::factor::recommended_block_size::<f64>(m, k).clamp(1, size.max(1)),
    };
    let mut coefficients = Mat::zeros(block, size);
    let (mut order, mut inverse) = (vec![0_usize; k], vec![0_usize; k]);
    let needed = StackReq::any_of(&[
        qr::col_pivoting::factor::qr_in_place_scratch::<usize, f64>(m, k, block, Par::Seq, Default::default()),
        householder::apply_block_householder_sequence_on_the_left_in_place_scratch::<f64>(m, block, size),
    ]);
    let mut memory = MemBuffer::new(needed);
    let stack = MemStack::new(&mut memory);
    qr::col_pivoting::factor::qr_in_place(
        work.as_mut(),
        coefficients.as_mut(),
        &mut order,
        &mut inverse,
        Par::Seq,
        stack,
        Default::default(),
    );
    let mut q = Mat::zeros(m, size);
    q.diagonal_mut().fill(1.0);
    householder::apply_block_householder_sequence_on_the_left_in_place_with_conj(
        work.subcols(0, size),
        coefficients.as_ref(),
        Conj::No,
        q.as_mut(),
        Par::Seq,
        stack,
    );
    order.iter_mut().for_each(|l| *l = active[*l]);
    Pivoted::new(q, work.subrows(0, size).to_owned(), order, tolerance)
}

/// The same of few rows by plain loops, with the same pivots and signs; of columns with one norm the first is taken.
fn of_few(scaled: &Mat<f64>, active: &[usize], tolerance: f64) -> Pivoted {
    let (m, k) = (scaled.nrows(), active.len());
    let size = m.min(k);
    let mut work = Vec::with_capacity(m * k);
    active.iter().for_each(|j| work.extend_from_slice(scaled.col_as_slice(*j)));
    let mut order = active.to_vec();
    let mut squares: Vec<f64> = work.chunks_exact(m.max(1)).map(|column| short_dot(column, column)).collect();
    squares.resize(k, 0.0);
    let mut computed = squares.clone();
    // first element of each reflection, and twice the reciprocal of its squared norm
    let mut reflections = vec![(0.0, 0.0); size];
    for s in 0..size {
        let pivot = (s + 1..k).fold(s, |best, l| if squares[l] > squares[best] { l } else { best });
        if pivot != s {
            order.swap(s, pivot);
            squares.swap(s, pivot);
            computed.swap(s, pivot);
            let (left, right) = work.split_at_mut(pivot * m);
            left[s * m..(s + 1) * m].swap_with_slice(&mut right[..m]);
        }
        let (before, after) = work.split_at_mut((s + 1) * m);
        let (top, own) = before[s * m + s..].split_at_mut(1);
        let below = short_dot(own, own);
        if below > 0.0 {
            let beta = -(top[0] * top[0] + below).sqrt().copysign(top[0]);
            let first = top[0] - beta;
            top[0] = beta;
            reflections[s] = (first, 2.0 / (first * first + below));
        }
        let (first, scale) = reflections[s];
        for (l, column) in after.chunks_exact_mut(m).enumerate() {
            let (head, rest) = column[s..].split_at_mut(1);
            reflect((first, own, scale), &mut head[0], rest);
            let (left, reference) = (&mut squares[s + 1 + l], &mut computed[s + 1 + l]);
            *left -= head[0] * head[0];
            if !(*left > LOST * *reference) {
                *left = short_dot(rest, rest);
                *reference = *left;
            }
        }
    }
    let mut q = Mat::zeros(m, size);
    for s in (0..size).rev() {
        let own = &work[s * m + s + 1..(s + 1) * m];
        let (first, scale) = reflections[s];
        q[(s, s)] = 1.0;
        for l in s..size {
            let (head, rest) = q.col_as_slice_mut(l)[s..].split_at_mut(1);
            reflect((first, own, scale), &mut head[0], rest);
        }
    }
    let mut r = Mat::zeros(size, k);
    for (j, column) in work.chunks_exact(m.max(1)).enumerate() {
        let count = size.min(j + 1);
        r.col_as_slice_mut(j)[..count].copy_from_slice(&column[..count]);
    }
    Pivoted::new(q, r, order, tolerance)
}

/// `x -= scale v (v . x)` with `v = (first, own)`.
fn reflect((first, own, scale): (f64, &[f64], f64), head: &mut f64, rest: &mut [f64]) {
    let along = scale * (first * *head + short_dot(own, rest));
    *head -= along * first;
    rest.iter_mut().zip(own).for_each(|(x, v)| *x -= along * v);
}

/// `R^-1 c` in place, by the leading part of an upper triangle that `c` is as long as.
pub(super) fn substitute(r: &Mat<f64>, c: &mut [f64]) {
    for k in (0..c.len()).rev() {
        let column = r.col_as_slice(k);
        let x = c[k] / column[k];
        c[k] = x;
        c[..k].iter_mut().zip(column).for_each(|(c, r)| *c -= x * r);
    }
}
