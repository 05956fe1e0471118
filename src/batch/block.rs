//! Eight devices side by side: estimates and residuals by one matrix for all of them, and what is summed and sorted for tests of the residuals.
//!
//! ```text
//! x = P r,   v = r - A x in twice the working precision,   x += P v
//! ```
//!
//! `P = (A' W A)^-1 A' W` comes from the QR factorisation. A step of refinement takes the error of the first product down to
//! the rounding of the residuals. Instructions are chosen at run time (`pulp`).
#![allow(
    clippy::indexing_slicing,
    reason = "`j < n` and `q < width`, and the chunk of unknowns has `n * width` registers; a `Lane` has `LANES` numbers; places of the sorting network are asked with `get` first"
)]

use crate::quality::NormalScores;
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

/// What is summed of the residuals of eight devices.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sums {
    /// `sum (v/u)^2`.
    pub squares: Lane,
    /// The largest `v^2` times a row's gain.
    pub gain: Lane,
    /// How many residuals are positive, how many zero, and how many follow one of the other sign.
    pub positive: Lane,
    pub zero: Lane,
    pub changes: Lane,
}

impl Sums {
    /// Over the rows of the residuals; `weight` are the reciprocals of the rows' standard uncertainties, `gain` that of each reading. Signs are
    /// those of the readings.
    pub(super) fn of(residuals: &[Lane], weight: &[f64], gain: &[f64]) -> Sums {
        Sums::weighted(residuals, weight.iter().map(|w| [*w; LANES]), gain.iter().map(|gain| [*gain; LANES]))
    }

    /// The same for devices with weights and gains of their own.
    #[inline(always)]
    pub(super) fn weighted(
        residuals: &[Lane],
        weight: impl Iterator<Item = Lane>,
        gain: impl Iterator<Item = Lane>,
    ) -> Sums {
        let zero = [0.0; LANES];
        let mut sums = Sums { squares: zero, gain: zero, positive: zero, zero, changes: zero };
        for (v, w) in residuals.iter().zip(weight) {
            for ((sum, v), w) in sums.squares.iter_mut().zip(v).zip(w) {
                *sum += (v * w) * (v * w);
            }
        }
        let mut before = zero;
        for (k, (v, gain)) in residuals.iter().zip(gain).enumerate() {
            (0..LANES).for_each(|l| {
                let square = v[l] * v[l] * gain[l];
                sums.gain[l] = if square > sums.gain[l] { square } else { sums.gain[l] };
                let positive = if v[l] > 0.0 { 1.0 } else { 0.0 };
                let change: f64 = positive - before[l];
                sums.positive[l] += positive;
                sums.zero[l] += if v[l] == 0.0 { 1.0 } else { 0.0 };
                sums.changes[l] += if k > 0 { change.abs() } else { 0.0 };
                before[l] = positive;
            });
        }
        sums
    }
}

/// Pairs of places whose values are exchanged where they are out of order, one pair after the other, to sort `count` values whatever they are:
/// Batcher's merge exchange (D. E. Knuth, The Art of Computer Programming 3, 5.2.2, algorithm M).
pub(super) fn network(count: usize) -> Vec<(usize, usize)> {
    let mut pairs = Vec::new();
    let top = count.next_power_of_two() / 2;
    let mut p = top;
    while p > 0 {
        let (mut q, mut r, mut d) = (top, 0, p);
        loop {
            pairs.extend((0..count.saturating_sub(d)).filter(|i| i & p == r).map(|i| (i, i + d)));
            if q == p {
                break;
            }
            (d, q, r) = (q - p, q / 2, p);
        }
        p /= 2;
    }
    pairs
}

/// Probabilities of the test of normality for eight devices; NaN where there is none. The values are sorted by `network`.
#[inline(always)]
pub(super) fn normality(scores: &NormalScores, network: &[(usize, usize)], values: &mut [Lane]) -> Lane {
    for (i, j) in network {
        let (Some(a), Some(b)) = (values.get(*i).copied(), values.get(*j).copied()) else { continue };
        values[*i] = std::array::from_fn(|l| if a[l] < b[l] { a[l] } else { b[l] });
        values[*j] = std::array::from_fn(|l| if a[l] < b[l] { b[l] } else { a[l] });
    }
    let (mut mean, mut product, mut of_values) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
    let count = values.len() as f64;
    for x in values.iter() {
        (0..LANES).for_each(|l| mean[l] += x[l]);
    }
    mean = mean.map(|sum| sum / count);
    for (m, x) in scores.scores().iter().zip(values.iter()) {
        (0..LANES).for_each(|l| {
            let deviation = x[l] - mean[l];
            product[l] += m * deviation;
            of_values[l] += deviation * deviation;
        });
    }
    std::array::from_fn(|l| scores.of_moments(product[l], of_values[l]).map_or(f64::NAN, |test| test.p))
}
