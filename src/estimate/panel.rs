//! Rows folded into a triangle, a panel of them at a time, in the registers of the machine.
//!
//! ```text
//! Q' [R; B] = [R'; 0],   column j by the reflection of v = (r_jj - beta, b_j)
//! ```
//!
//! The zeros of the triangle take no part (G. H. Golub, C. F. Van Loan, Matrix Computations, 6.5.3). A panel's columns lie one after the other in
//! lines of eight rows and stay in the first-level cache; what is missing to a whole pair of lines are rows of zeros, which change nothing. Each
//! reflection is applied to four columns at once. Instructions are chosen at run time (`pulp`). Its products stand apart from `linear.rs`, since both
//! factors are lines of registers already: through slices each would be loaded again.
#![allow(
    clippy::indexing_slicing,
    reason = "arrays of two registers, indexed by remainders by two and by loops over their length"
)]

use faer::{Mat, MatRef};
use pulp::{Arch, Simd, WithSimd};
use std::cell::RefCell;

/// Rows of a panel.
pub(super) const PANEL: usize = 128;
/// Rows of a line.
const LINE: usize = 8;

/// Eight rows of a column, as a register of eight wants them.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct Line([f64; LINE]);

impl Line {
    const ZERO: Line = Line([0.0; LINE]);
}

thread_local! {
    /// Room for one panel: too large for every fold to have its own.
    static ROOM: RefCell<Vec<Line>> = const { RefCell::new(Vec::new()) };
}

/// Numbers whose squares are neither lost nor beyond the range.
const SQUARED: std::ops::RangeInclusive<f64> = 1e-140..=1e150;

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
        && u.iter().all(|u| *u > 0.0 && *u < f64::INFINITY);
    if !sound {
        return None;
    }
    let arch = Arch::new();
    ROOM.with_borrow_mut(|room| {
        let mut start = 0;
        while start < k {
            let count = PANEL.min(k - start);
            let lines = count.div_ceil(2 * LINE) * 2;
            room.resize((n + 3) * lines, Line::ZERO);
            let mut columns = room.chunks_exact_mut(lines);
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
            arch.dispatch(Fold { triangle, room, lines, n, about }).then_some(())?;
            start += count;
        }
        Some(())
    })
}

/// Numbers into lines; rows that are missing are zero.
fn fill(to: &mut [Line], from: &[f64]) {
    let (whole, rest) = from.as_chunks::<LINE>();
    let (full, last) = to.split_at_mut(whole.len().min(to.len()));
    full.iter_mut().zip(whole).for_each(|(line, own)| line.0 = *own);
    last.fill(Line::ZERO);
    if let Some(line) = last.first_mut() {
        line.0.iter_mut().zip(rest).for_each(|(to, from)| *to = *from);
    }
}

/// One panel: columns of the rows, observations, standard uncertainties (zero for rows that are missing), and room for a column of errors.
struct Fold<'a> {
    triangle: &'a mut Mat<f64>,
    room: &'a mut [Line],
    lines: usize,
    n: usize,
    about: &'a [f64],
}

impl WithSimd for Fold<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Fold { triangle, room, lines, n, about } = self;
        let (panel, rest) = room.split_at_mut((n + 1) * lines);
        let (weight, low) = rest.split_at_mut(lines);
        low.fill(Line::ZERO);
        for line in weight.iter_mut() {
            line.0.iter_mut().filter(|u| **u > 0.0).for_each(|u| *u = 1.0 / *u);
        }
        if !about.is_empty() {
            let (rows, observed) = panel.split_at_mut(n * lines);
            subtract(simd, rows, (observed, low), about);
        }
        for column in panel.chunks_exact_mut(lines) {
            let largest = weigh(simd, column, weight);
            if !(largest == 0.0 || SQUARED.contains(&largest)) {
                return false;
            }
        }
        for j in 0..=n {
            let (own, after) = panel.split_at_mut((j + 1) * lines);
            let Some(own) = own.get(j * lines..) else { return false };
            let squares = dot(simd, own, own);
            let alpha = triangle[(j, j)];
            if squares == 0.0 {
                continue;
            }
            let beta = -(alpha * alpha + squares).sqrt().copysign(alpha);
            if !beta.is_finite() {
                return false;
            }
            let first = alpha - beta;
            let reflection = (first, 2.0 / (first * first + squares));
            triangle[(j, j)] = beta;
            let mut l = j + 1;
            let mut fours = after.chunks_exact_mut(4 * lines);
            for four in &mut fours {
                reflect::<S, 4>(simd, reflection, own, four, (&mut *triangle, j, l));
                l += 4;
            }
            let rest = fours.into_remainder();
            match rest.len() / lines {
                1 => reflect::<S, 1>(simd, reflection, own, rest, (&mut *triangle, j, l)),
                2 => reflect::<S, 2>(simd, reflection, own, rest, (&mut *triangle, j, l)),
                3 => reflect::<S, 3>(simd, reflection, own, rest, (&mut *triangle, j, l)),
                _ => {}
            }
        }
        true
    }
}

/// `y -= A a` in twice the working precision; `low` takes the errors, zero before.
#[inline(always)]
fn subtract<S: Simd>(simd: S, rows: &[Line], (observed, low): (&mut [Line], &mut [Line]), about: &[f64]) {
    let lines = observed.len();
    for (column, x) in rows.chunks_exact(lines.max(1)).zip(about) {
        let x = simd.splat_f64s(*x);
        for ((a, y), low) in column.iter().zip(observed.iter_mut()).zip(low.iter_mut()) {
            let ((a, _), (y, _)) = (S::as_simd_f64s(&a.0), S::as_mut_simd_f64s(&mut y.0));
            let (low, _) = S::as_mut_simd_f64s(&mut low.0);
            for ((a, y), low) in a.iter().zip(y).zip(low) {
                let product = simd.mul_f64s(*a, x);
                let minus = simd.neg_f64s(product);
                let below = simd.mul_add_f64s(*a, x, minus);
                let sum = simd.add_f64s(*y, minus);
                let back = simd.sub_f64s(sum, *y);
                let error = simd.add_f64s(simd.sub_f64s(*y, simd.sub_f64s(sum, back)), simd.sub_f64s(minus, back));
                *y = sum;
                *low = simd.add_f64s(*low, simd.sub_f64s(error, below));
            }
        }
    }
    for (y, low) in observed.iter_mut().zip(low) {
        y.0.iter_mut().zip(&low.0).for_each(|(y, low)| *y += low);
    }
}

/// Multiply a column by the weights; its largest size then, not a number where one of them is not finite.
#[inline(always)]
fn weigh<S: Simd>(simd: S, column: &mut [Line], weight: &[Line]) -> f64 {
    let mut largest = [simd.splat_f64s(0.0); 2];
    // a product with zero is zero, unless the other factor is not finite
    let mut finite = [simd.splat_f64s(0.0); 2];
    let zero = simd.splat_f64s(0.0);
    for (line, weight) in column.iter_mut().zip(weight) {
        let ((x, _), (w, _)) = (S::as_mut_simd_f64s(&mut line.0), S::as_simd_f64s(&weight.0));
        for (q, (x, w)) in x.iter_mut().zip(w).enumerate() {
            *x = simd.mul_f64s(*x, *w);
            largest[q % 2] = simd.max_f64s(largest[q % 2], simd.abs_f64s(*x));
            finite[q % 2] = simd.mul_add_e_f64s(*x, zero, finite[q % 2]);
        }
    }
    let largest = simd.reduce_max_f64s(simd.max_f64s(largest[0], largest[1]));
    largest + simd.reduce_sum_f64s(simd.add_f64s(finite[0], finite[1]))
}

#[inline(always)]
fn dot<S: Simd>(simd: S, a: &[Line], b: &[Line]) -> f64 {
    let mut sums = [[simd.splat_f64s(0.0); 2]; 2];
    let ((a, _), (b, _)) = (a.as_chunks::<2>(), b.as_chunks::<2>());
    for (a, b) in a.iter().zip(b) {
        for ((a, b), sums) in a.iter().zip(b).zip(&mut sums) {
            let ((a, _), (b, _)) = (S::as_simd_f64s(&a.0), S::as_simd_f64s(&b.0));
            for (q, (a, b)) in a.iter().zip(b).enumerate() {
                sums[q % 2] = simd.mul_add_e_f64s(*a, *b, sums[q % 2]);
            }
        }
    }
    let [[a, b], [c, d]] = sums;
    simd.reduce_sum_f64s(simd.add_f64s(simd.add_f64s(a, b), simd.add_f64s(c, d)))
}

/// `x -= scale v (v . x)` for `C` columns at once, `v = (first, own)`; the columns' first elements stand in row `j` of the triangle, from column `l`.
#[inline(always)]
fn reflect<S: Simd, const C: usize>(
    simd: S,
    (first, scale): (f64, f64),
    own: &[Line],
    columns: &mut [Line],
    (triangle, j, l): (&mut Mat<f64>, usize, usize),
) {
    let lines = own.len();
    let mut sums = [[simd.splat_f64s(0.0); C]; 2];
    let mut parts = columns.chunks_exact(lines);
    // the caller brings C columns; an empty one ends the loops at once
    let parts: [&[Line]; C] = std::array::from_fn(|_| parts.next().unwrap_or_default());
    for (i, own) in own.iter().enumerate() {
        let (own, _) = S::as_simd_f64s(&own.0);
        for (c, part) in parts.iter().enumerate() {
            let Some(x) = part.get(i) else { continue };
            let (x, _) = S::as_simd_f64s(&x.0);
            for (q, (x, v)) in x.iter().zip(own).enumerate() {
                sums[q % 2][c] = simd.mul_add_e_f64s(*x, *v, sums[q % 2][c]);
            }
        }
    }
    let mut along = [simd.splat_f64s(0.0); C];
    for c in 0..C {
        let sum = simd.reduce_sum_f64s(simd.add_f64s(sums[0][c], sums[1][c]));
        let top = &mut triangle[(j, l + c)];
        let own = scale * (first * *top + sum);
        *top -= own * first;
        along[c] = simd.splat_f64s(-own);
    }
    let mut parts = columns.chunks_exact_mut(lines);
    // the caller brings C columns; an empty one ends the loops at once
    let mut parts: [&mut [Line]; C] = std::array::from_fn(|_| parts.next().unwrap_or_default());
    for (i, own) in own.iter().enumerate() {
        let (own, _) = S::as_simd_f64s(&own.0);
        for (part, along) in parts.iter_mut().zip(&along) {
            let Some(x) = part.get_mut(i) else { continue };
            let (x, _) = S::as_mut_simd_f64s(&mut x.0);
            for (x, v) in x.iter_mut().zip(own) {
                *x = simd.mul_add_e_f64s(*v, *along, *x);
            }
        }
    }
}
