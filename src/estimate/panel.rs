//! Rows folded into a triangle, a panel of them at a time, in the registers of the machine.
//!
//! ```text
//! Q' [R; B] = [R'; 0],   column j by the reflection of v = (r_jj - beta, b_j)
//! ```
//!
//! The zeros of the triangle take no part (G. H. Golub, C. F. Van Loan, Matrix Computations, 6.5.3). A panel's columns lie one after the other, from
//! a boundary of a cache line on, and stay in the first-level cache; what is missing to a whole number of steps are rows of zeros, which change
//! nothing. Two reflections at a time are applied to four columns at once, so that each number is fetched once for both (R. Schreiber, C. F. Van
//! Loan, A storage-efficient WY representation, 1989): `H2 H1 x = x - v1 w1 - v2 w2`, `w1 = s1 v1'x`, `w2 = s2 (v2'x - v2'v1 w1)`. Instructions are
//! chosen at run time (`pulp`). Its products stand apart from `linear.rs`, since both factors are lines of registers already: through slices each
//! would be loaded again.
#![allow(
    clippy::indexing_slicing,
    reason = "columns of a panel are cut to one length before the loops that index them; elsewhere arrays indexed by remainders by two"
)]

use faer::{Mat, MatRef};
use pulp::{Arch, Simd, WithSimd};
use std::cell::RefCell;

/// Rows of a step: two registers of eight, four of four.
const STEP: usize = 16;
/// Bytes of a panel: it and what it is read from share a first-level cache of 32 kB.
const BYTES: usize = 24 << 10;
/// Rows of a panel: fewer cost more in the triangle than in the rows, more gain nothing.
const ROWS: std::ops::RangeInclusive<usize> = 48..=192;
/// Numbers of a cache line.
const LINE: usize = 8;

thread_local! {
    /// Room for one panel: too large for every fold to have its own.
    static ROOM: RefCell<Vec<f64>> = const { RefCell::new(Vec::new()) };
}

/// Sums of squares of which none that counts is lost or beyond the range.
const SUMMED: std::ops::RangeInclusive<f64> = 1e-280..=1e300;

/// Fold weighted rows `k x n` and observations about a point (empty for zero) into a triangle, `n + 1` square.
///
/// `None` where numbers are not finite, a standard uncertainty is not positive, or squares leave the range of a double; the triangle is then
/// worth nothing.
pub(super) fn fold(
    triangle: &mut Mat<f64>,
    rows: MatRef<'_, f64>,
    observed: &[f64],
    u: &[f64],
    about: &[f64],
) -> Option<()> {
    let (k, n) = rows.shape();
    let sound = triangle.ncols() == n + 1
        && triangle.nrows() == n + 1
        && observed.len() == k
        && u.len() == k
        && u.iter().fold(true, |sound, u| sound & (*u > 0.0) & (*u < f64::INFINITY));
    if !sound {
        return None;
    }
    let arch = Arch::new();
    let most = BYTES / (size_of::<f64>() * (n + 3));
    let panel = most.clamp(*ROWS.start(), *ROWS.end()) / STEP * STEP;
    ROOM.with_borrow_mut(|room| {
        let mut start = 0;
        while start < k {
            let count = panel.min(k - start);
            let height = count.next_multiple_of(STEP);
            let needed = (n + 3) * height;
            room.resize(room.len().max(needed + LINE), 0.0);
            let first = room.as_ptr().align_offset(LINE * size_of::<f64>()).min(LINE);
            let room = room.get_mut(first..first + needed)?;
            let mut columns = room.chunks_exact_mut(height);
            for (j, to) in (0..n).zip(&mut columns) {
                let column = rows.col(j).subrows(start, count);
                match column.try_as_col_major() {
                    Some(column) => fill(to, column.as_slice()),
                    None => fill(to, &column.iter().copied().collect::<Vec<f64>>()),
                }
            }
            let part = start..start + count;
            for (from, to) in [observed.get(part.clone())?, u.get(part)?].into_iter().zip(&mut columns) {
                fill(to, from);
            }
            arch.dispatch(Fold { triangle, room, height, n, about }).then_some(())?;
            start += count;
        }
        Some(())
    })
}

/// Numbers into a column; rows that are missing are zero.
fn fill(to: &mut [f64], from: &[f64]) {
    let (whole, rest) = to.split_at_mut(from.len().min(to.len()));
    whole.copy_from_slice(from);
    rest.fill(0.0);
}

/// The registers of a column.
#[inline(always)]
fn lanes<S: Simd>(column: &[f64]) -> &[S::f64s] {
    S::as_simd_f64s(column).0
}

#[inline(always)]
fn lanes_mut<S: Simd>(column: &mut [f64]) -> &mut [S::f64s] {
    S::as_mut_simd_f64s(column).0
}

/// One panel: columns of the rows, observations, standard uncertainties (zero for rows that are missing), and room for a column of residuals.
struct Fold<'a> {
    triangle: &'a mut Mat<f64>,
    room: &'a mut [f64],
    height: usize,
    n: usize,
    about: &'a [f64],
}

impl WithSimd for Fold<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Fold { triangle, room, height, n, about } = self;
        let (panel, rest) = room.split_at_mut((n + 1) * height);
        let (weight, plain) = rest.split_at_mut(height);
        for u in weight.iter_mut().filter(|u| **u > 0.0) {
            *u = 1.0 / *u;
        }
        if !about.is_empty() {
            let (rows, observed) = panel.split_at_mut(n * height);
            if plainly(simd, rows, (observed, plain), weight, about) {
                observed.copy_from_slice(plain);
            } else {
                subtract(simd, rows, observed, about);
            }
        }
        for column in panel.chunks_exact_mut(height) {
            let squares = weigh(simd, column, weight);
            // squares that are lost leave a sum of zero
            if !(SUMMED.contains(&squares) || column.iter().all(|x| *x == 0.0)) {
                return false;
            }
        }
        let mut j = 0;
        while j <= n {
            let (_, from) = panel.split_at_mut(j * height);
            let (first, rest) = from.split_at_mut(height);
            let Some(one) = reflection(&mut triangle[(j, j)], dot(simd, first, first)) else { return false };
            if j == n {
                break;
            }
            let (second, after) = rest.split_at_mut(height);
            let (squares, across) = next(simd, one, (first, second), &mut triangle[(j, j + 1)]);
            let Some(two) = reflection(&mut triangle[(j + 1, j + 1)], squares) else { return false };
            let pair = Pair { one, two, across, first, second };
            let mut l = j + 2;
            let mut fours = after.chunks_exact_mut(4 * height);
            for four in &mut fours {
                pair.reflect::<S, 4>(simd, four, (&mut *triangle, j, l));
                l += 4;
            }
            let rest = fours.into_remainder();
            match rest.len() / height {
                1 => pair.reflect::<S, 1>(simd, rest, (&mut *triangle, j, l)),
                2 => pair.reflect::<S, 2>(simd, rest, (&mut *triangle, j, l)),
                3 => pair.reflect::<S, 3>(simd, rest, (&mut *triangle, j, l)),
                _ => {}
            }
            j += 2;
        }
        true
    }
}

/// The reflection of `(alpha, b)` with `b'b = squares` to `(beta, 0)`: the first element of its vector `(alpha - beta, b)` and the factor of its product;
/// zeros where nothing is to be reflected, `None` beyond the range of a double. Writes `beta` over `alpha`.
#[inline(always)]
fn reflection(alpha: &mut f64, squares: f64) -> Option<(f64, f64)> {
    if squares == 0.0 {
        return Some((0.0, 0.0));
    }
    let beta = -(*alpha * *alpha + squares).sqrt().copysign(*alpha);
    let first = *alpha - beta;
    *alpha = beta;
    beta.is_finite().then_some((first, 2.0 / (first * first + squares)))
}

/// Terms of at most this size, relative to the residuals, leave them thirteen digits in plain arithmetic.
const PLAIN: f64 = 64.0;

/// `r = y - A a` in plain arithmetic; false where `sum w^2 (|y| + |A| |a|)^2` is so large beside `sum w^2 r^2` that the residuals lose digits.
#[inline(always)]
fn plainly<S: Simd>(
    simd: S,
    rows: &[f64],
    (observed, rest): (&[f64], &mut [f64]),
    weight: &[f64],
    about: &[f64],
) -> bool {
    let (rows, weight) = (lanes::<S>(rows), lanes::<S>(weight));
    let (observed, rest) = (lanes::<S>(observed), lanes_mut::<S>(rest));
    let height = observed.len();
    let zero = simd.splat_f64s(0.0);
    let (mut squares, mut terms) = ([zero; 4], [zero; 4]);
    for i in (0..height).step_by(4).take_while(|i| i + 4 <= height) {
        let (mut left, mut size) = ([zero; 4], [zero; 4]);
        for q in 0..4 {
            left[q] = observed[i + q];
            size[q] = simd.abs_f64s(left[q]);
        }
        for (j, x) in about.iter().enumerate() {
            let x = simd.splat_f64s(-x);
            for q in 0..4 {
                let own = simd.mul_f64s(rows[j * height + i + q], x);
                left[q] = simd.add_f64s(left[q], own);
                size[q] = simd.add_f64s(size[q], simd.abs_f64s(own));
            }
        }
        for q in 0..4 {
            rest[i + q] = left[q];
            let (left, size) = (simd.mul_f64s(weight[i + q], left[q]), simd.mul_f64s(weight[i + q], size[q]));
            squares[q] = simd.mul_add_e_f64s(left, left, squares[q]);
            terms[q] = simd.mul_add_e_f64s(size, size, terms[q]);
        }
    }
    sum(simd, terms) <= PLAIN * PLAIN * sum(simd, squares)
}

/// The sum of all numbers of some registers.
#[inline(always)]
fn sum<S: Simd, const N: usize>(simd: S, registers: [S::f64s; N]) -> f64 {
    let mut sum = simd.splat_f64s(0.0);
    for own in registers {
        sum = simd.add_f64s(sum, own);
    }
    simd.reduce_sum_f64s(sum)
}

/// `y -= A a` in twice the working precision.
#[inline(always)]
fn subtract<S: Simd>(simd: S, rows: &[f64], observed: &mut [f64], about: &[f64]) {
    let (rows, observed) = (lanes::<S>(rows), lanes_mut::<S>(observed));
    let height = observed.len();
    for i in (0..height).step_by(2).take_while(|i| i + 2 <= height) {
        let mut high = [observed[i], observed[i + 1]];
        let mut low = [simd.splat_f64s(0.0); 2];
        for (j, x) in about.iter().enumerate() {
            let x = simd.splat_f64s(-x);
            for q in 0..2 {
                let (a, y) = (rows[j * height + i + q], high[q]);
                let product = simd.mul_f64s(a, x);
                let below = simd.mul_add_f64s(a, x, simd.neg_f64s(product));
                let sum = simd.add_f64s(y, product);
                let back = simd.sub_f64s(sum, y);
                let error = simd.add_f64s(simd.sub_f64s(y, simd.sub_f64s(sum, back)), simd.sub_f64s(product, back));
                high[q] = sum;
                low[q] = simd.add_f64s(low[q], simd.add_f64s(error, below));
            }
        }
        for q in 0..2 {
            observed[i + q] = simd.add_f64s(high[q], low[q]);
        }
    }
}

/// Multiply a column by the weights; the sum of its squares then, not finite where one of its numbers is not.
#[inline(always)]
fn weigh<S: Simd>(simd: S, column: &mut [f64], weight: &[f64]) -> f64 {
    let mut squares = [simd.splat_f64s(0.0); 2];
    let (column, _) = lanes_mut::<S>(column).as_chunks_mut::<2>();
    let (weight, _) = lanes::<S>(weight).as_chunks::<2>();
    for (x, w) in column.iter_mut().zip(weight) {
        for q in 0..2 {
            x[q] = simd.mul_f64s(x[q], w[q]);
            squares[q] = simd.mul_add_e_f64s(x[q], x[q], squares[q]);
        }
    }
    sum(simd, squares)
}

#[inline(always)]
fn dot<S: Simd>(simd: S, a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [simd.splat_f64s(0.0); 2];
    let ((a, _), (b, _)) = (lanes::<S>(a).as_chunks::<2>(), lanes::<S>(b).as_chunks::<2>());
    for (a, b) in a.iter().zip(b) {
        for q in 0..2 {
            sums[q] = simd.mul_add_e_f64s(a[q], b[q], sums[q]);
        }
    }
    sum(simd, sums)
}

/// Apply a reflection to the column that comes next; the sum of its squares then, and its product with the reflection's vector.
#[inline(always)]
fn next<S: Simd>(
    simd: S,
    (first, scale): (f64, f64),
    (own, column): (&[f64], &mut [f64]),
    top: &mut f64,
) -> (f64, f64) {
    let along = scale * (first * *top + dot(simd, own, column));
    *top -= along * first;
    let along = simd.splat_f64s(-along);
    let mut squares = [simd.splat_f64s(0.0); 2];
    let mut across = [simd.splat_f64s(0.0); 2];
    let (own, _) = lanes::<S>(own).as_chunks::<2>();
    let (column, _) = lanes_mut::<S>(column).as_chunks_mut::<2>();
    for (own, x) in own.iter().zip(column) {
        for q in 0..2 {
            x[q] = simd.mul_add_e_f64s(own[q], along, x[q]);
            squares[q] = simd.mul_add_e_f64s(x[q], x[q], squares[q]);
            across[q] = simd.mul_add_e_f64s(x[q], own[q], across[q]);
        }
    }
    (sum(simd, squares), sum(simd, across))
}

/// Two reflections, one after the other: first elements and factors, the product of their vectors, the vectors below the triangle.
struct Pair<'a> {
    one: (f64, f64),
    two: (f64, f64),
    across: f64,
    first: &'a [f64],
    second: &'a [f64],
}

impl Pair<'_> {
    /// Both for `C` columns at once; the columns' first elements stand in rows `j` and `j + 1` of the triangle, from column `l`.
    #[inline(always)]
    fn reflect<S: Simd, const C: usize>(
        &self,
        simd: S,
        columns: &mut [f64],
        (triangle, j, l): (&mut Mat<f64>, usize, usize),
    ) {
        let (first, second) = (lanes::<S>(self.first), lanes::<S>(self.second));
        let height = first.len();
        let (second, columns) = (&second[..height], &mut lanes_mut::<S>(columns)[..C * height]);
        let zero = simd.splat_f64s(0.0);
        let mut sums = [[zero; 2]; C];
        {
            let parts: [&[S::f64s]; C] = std::array::from_fn(|c| &columns[c * height..][..height]);
            for i in 0..height {
                let (v, w) = (first[i], second[i]);
                for c in 0..C {
                    let x = parts[c][i];
                    sums[c][0] = simd.mul_add_e_f64s(x, v, sums[c][0]);
                    sums[c][1] = simd.mul_add_e_f64s(x, w, sums[c][1]);
                }
            }
        }
        let mut along = [[zero; 2]; C];
        for c in 0..C {
            let (one, two) = (simd.reduce_sum_f64s(sums[c][0]), simd.reduce_sum_f64s(sums[c][1]));
            let top = &mut triangle.col_as_slice_mut(l + c)[j..=j + 1];
            let one = self.one.1 * (self.one.0 * top[0] + one);
            let two = self.two.1 * (self.two.0 * top[1] + two - self.across * one);
            top[0] -= one * self.one.0;
            top[1] -= two * self.two.0;
            along[c] = [simd.splat_f64s(-one), simd.splat_f64s(-two)];
        }
        let mut parts = columns.chunks_exact_mut(height);
        // C columns were cut above
        let parts: [&mut [S::f64s]; C] =
            std::array::from_fn(|_| parts.next().map_or(&mut [][..], |own| &mut own[..height]));
        for i in 0..height {
            let (v, w) = (first[i], second[i]);
            for c in 0..C {
                parts[c][i] = simd.mul_add_e_f64s(w, along[c][1], simd.mul_add_e_f64s(v, along[c][0], parts[c][i]));
            }
        }
    }
}
