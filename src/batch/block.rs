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
    reason = "`a` has `m` rows of `n` numbers; a `Lane` has `LANES` numbers; places of the sorting network are asked with `get` first"
)]

use crate::estimate::eight::{left, plus};
use crate::quality::NormalScores;
use pulp::{Arch, Simd, WithSimd};

/// Devices side by side, and one number of each.
pub(super) use crate::estimate::eight::{LANES, Lane};

/// The numbers of one of them.
pub(super) fn lane(of: &[Lane], l: usize) -> impl Iterator<Item = f64> + '_ {
    of.iter().map(move |lanes| lanes[l])
}

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
    fn with_simd<S: Simd>(self, _: S) {
        let Kernel { a, p, m, n, passes } = self.kernel;
        let (m, n) = (*m, *n);
        if m == 0 || n == 0 {
            return;
        }
        let groups = self.observed.chunks_exact(m).zip(self.unknowns.chunks_exact_mut(n));
        for ((y, x), v) in groups.zip(self.residuals.chunks_exact_mut(m)) {
            x.fill([0.0; LANES]);
            add(p, y, x);
            for _ in 0..*passes {
                left(|i, j| [a[i * n + j]; LANES], y, x, v);
                add(p, v, x);
            }
            left(|i, j| [a[i * n + j]; LANES], y, x, v);
        }
    }
}

/// `x += P y`.
#[inline(always)]
fn add(p: &[f64], y: &[Lane], x: &mut [Lane]) {
    for (row, y) in p.chunks_exact(x.len()).zip(y) {
        row.iter().zip(&mut *x).for_each(|(p, x)| plus(x, &[*p; LANES], y));
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
