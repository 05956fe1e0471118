//! Eight devices side by side: estimates and residuals by one matrix for all of them.
//!
//! ```text
//! x = P r,   v = r - A x in twice the working precision,   x += P v
//! ```
//!
//! `P = (A' W A)^-1 A' W` comes from the QR factorisation. A step of refinement takes the error of the first product down to
//! the rounding of the residuals. Instructions are chosen at run time (`pulp`).
#![allow(
    clippy::indexing_slicing,
    reason = "`j < n` and `q < width`, and the chunk of unknowns has `n * width` registers"
)]

use pulp::{Arch, Simd, WithSimd};

/// Devices side by side, and one number of each.
pub(super) use crate::estimate::eight::{LANES, Lane};

/// What all devices share.
#[derive(Debug, Clone)]
pub(super) struct Kernel {
    /// Rows of the design, one after the other, `m x n`.
    pub a: Vec<f64>,
    /// How the unknowns follow the rows, one row after the other, `m x n`.
    pub p: Vec<f64>,
    /// Rows.
    pub m: usize,
    /// Unknowns.
    pub n: usize,
    /// Steps of refinement.
    pub passes: usize,
}

impl Kernel {
    /// Groups of eight devices: `observed` has `m` lanes for each group, `unknowns` gets `n`, `residuals` `m`.
    pub(super) fn solve(&self, arch: Arch, observed: &[Lane], unknowns: &mut [Lane], residuals: &mut [Lane]) {
        arch.dispatch(Solve { kernel: self, observed, unknowns, residuals });
    }
}

struct Solve<'a> {
    kernel: &'a Kernel,
    observed: &'a [Lane],
    unknowns: &'a mut [Lane],
    residuals: &'a mut [Lane],
}

impl WithSimd for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Kernel { a, p, m, n, passes } = self.kernel;
        let (m, n) = (*m, *n);
        let width = LANES / S::F64_LANES;
        if m == 0 || n == 0 || width == 0 {
            return;
        }
        let (observed, _) = S::as_simd_f64s(self.observed.as_flattened());
        let (unknowns, _) = S::as_mut_simd_f64s(self.unknowns.as_flattened_mut());
        let (residuals, _) = S::as_mut_simd_f64s(self.residuals.as_flattened_mut());
        let groups = observed.chunks_exact(m * width).zip(unknowns.chunks_exact_mut(n * width));
        for ((y, x), v) in groups.zip(residuals.chunks_exact_mut(m * width)) {
            for q in 0..width {
                for j in 0..n {
                    x[j * width + q] = simd.splat_f64s(0.0);
                }
                add(simd, p, y, x, (n, width, q));
                for _ in 0..*passes {
                    rest(simd, a, y, x, v, (n, width, q));
                    add(simd, p, v, x, (n, width, q));
                }
                rest(simd, a, y, x, v, (n, width, q));
            }
        }
    }
}

/// `x += P y`, for the vectors at `q` of `width`.
#[inline(always)]
fn add<S: Simd>(simd: S, p: &[f64], y: &[S::f64s], x: &mut [S::f64s], (n, width, q): (usize, usize, usize)) {
    for (row, y) in p.chunks_exact(n).zip(y.iter().skip(q).step_by(width)) {
        for (p, x) in row.iter().zip(x.iter_mut().skip(q).step_by(width)) {
            *x = simd.mul_add_f64s(simd.splat_f64s(*p), *y, *x);
        }
    }
}

/// `v = y - A x`, accumulated as high + low, for the vectors at `q` of `width`.
#[inline(always)]
fn rest<S: Simd>(
    simd: S,
    a: &[f64],
    y: &[S::f64s],
    x: &[S::f64s],
    v: &mut [S::f64s],
    (n, width, q): (usize, usize, usize),
) {
    let rows = a.chunks_exact(n).zip(y.iter().skip(q).step_by(width));
    for ((row, y), v) in rows.zip(v.iter_mut().skip(q).step_by(width)) {
        let (mut high, mut low) = (*y, simd.splat_f64s(0.0));
        for (a, x) in row.iter().zip(x.iter().skip(q).step_by(width)) {
            let a = simd.splat_f64s(*a);
            let product = simd.mul_f64s(a, *x);
            let minus = simd.neg_f64s(product);
            let below = simd.mul_add_f64s(a, *x, minus);
            let sum = simd.add_f64s(high, minus);
            let back = simd.sub_f64s(sum, high);
            let error = simd.add_f64s(simd.sub_f64s(high, simd.sub_f64s(sum, back)), simd.sub_f64s(minus, back));
            high = sum;
            low = simd.add_f64s(low, simd.sub_f64s(error, below));
        }
        *v = simd.add_f64s(high, low);
    }
}
