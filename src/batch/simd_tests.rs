//! Tests of the residuals of eight devices side by side: sums, signs in their order, and the order of the residuals by size.
#![allow(
    clippy::indexing_slicing,
    reason = "a `Lane` has `LANES` numbers; places of the sorting network are asked with `get` first"
)]

use super::block::{LANES, Lane};
use crate::quality::NormalScores;

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
        Sums::of_own(residuals, weight.iter().map(|w| [*w; LANES]), gain.iter().map(|gain| [*gain; LANES]))
    }

    /// The same for devices with weights and gains of their own.
    #[inline(always)]
    pub(super) fn of_own(
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
                let own = v[l] * v[l] * gain[l];
                sums.gain[l] = if own > sums.gain[l] { own } else { sums.gain[l] };
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
            let own = x[l] - mean[l];
            product[l] += m * own;
            of_values[l] += own * own;
        });
    }
    std::array::from_fn(|l| scores.of_moments(product[l], of_values[l]).map_or(f64::NAN, |test| test.p))
}
