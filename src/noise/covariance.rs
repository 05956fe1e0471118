//! Covariance of overlapping Allan variances of one record at different averaging times.
//!
//! Both are means of squares of differences `z` of the same running sum; for a normal process `cov(z1^2, z2^2) = 2 r^2` with
//! `r(lag) = sum c_a c_b gamma(lag + a m2 - b m1)`, `c = (1, -2, 1)`, and gamma the generalized covariance of the running sum: `Q^2 delta(t)`,
//! `-N^2 |t|/2`, `B^2 t^2 ln|t|/(2 pi)`, `K^2 |t|^3/12`. r is linear in the squares of the coefficients, so the sums over lags are kept once. How many
//! pairs of differences a record with gaps has at a lag is counted in its cells; below their resolution it is as many as it would have differences over
//! the time that both take.

use super::Sums;
use super::cells::Cells;
use super::ladder::MISSING;
use std::f64::consts::PI;

/// Lags to an averaging time, and by how much they widen far from where the covariance has a bend.
const FINE: f64 = 16.0;
const WIDER: f64 = 1.15;
const C: [f64; 3] = [1.0, -2.0, 1.0];

/// Sums over lags of products of covariances of the parts Q, N, B, K, for one pair of averaging times; the time unit is a sample.
pub(super) type Gram = [[f64; 4]; 4];

/// How many differences over `2 m` samples begin in a record: between the averaging times that were counted a straight line.
fn existing(sums: &[Sums], m: f64) -> f64 {
    let at = sums.partition_point(|s| (s.m as f64) < m).clamp(1, sums.len().max(2) - 1);
    let (Some(a), Some(b)) = (sums.get(at - 1), sums.get(at)) else {
        return sums.first().map_or(0.0, |s| s.positions as f64);
    };
    let slope = (b.positions as f64 - a.positions as f64) / (b.m as f64 - a.m as f64);
    (a.positions as f64 + slope * (m - a.m as f64)).max(0.0)
}

/// Lags from `-2 second` - some to `2 first` + some, with the lags that each stands for: every one, or a sixteenth of an averaging time, near the bends.
fn lags(first: f64, second: f64) -> Vec<(f64, f64)> {
    let (from, to) = (-4.0 * second - 2.0 * first, 2.0 * second + 4.0 * first);
    let step = (first / FINE).max(1.0);
    let mut nodes: Vec<f64> = vec![from, to];
    for bend in [0.0, -second, -2.0 * second] {
        let (mut away, mut by) = (0.0, step);
        while away < to - from {
            nodes.extend([bend + first - away, bend + first + away].map(f64::round));
            if away > 2.0 * first {
                by = (by * WIDER).min(second / FINE).max(step);
            }
            away += by;
        }
    }
    nodes.retain(|lag| (from..=to).contains(lag));
    nodes.sort_by(f64::total_cmp);
    nodes.dedup();
    let half = |a: Option<&f64>, b: Option<&f64>| a.zip(b).map_or(0.0, |(a, b)| 0.5 * (b - a));
    let weight = |k: usize| {
        half(nodes.get(k), nodes.get(k + 1)) + k.checked_sub(1).map_or(0.0, |j| half(nodes.get(j), nodes.get(k)))
    };
    nodes.iter().enumerate().map(|(k, lag)| (*lag, weight(k))).collect()
}

/// The sums for two averaging times, the shorter one first; `all` has the differences that the record has at each.
pub(super) fn gram(one: &Sums, two: &Sums, all: &[Sums], cells: &Cells) -> Gram {
    let (first, second) = (one.m as f64, two.m as f64);
    let (n1, n2) = (one.positions as f64, two.positions as f64);
    let white = (one.missing_factors()[1] * two.missing_factors()[1]).sqrt();
    let seen = cells.differences(first, MISSING).zip(cells.differences(second, MISSING));
    let pairs = |lag: f64| {
        if let Some((a, b)) = &seen {
            return a.pairs(b, lag) * n1 * n2 / (a.count() * b.count() * cells.length());
        }
        let span = (2.0 * first).max(lag + 2.0 * second) - lag.min(0.0);
        existing(all, 0.5 * span).min(n1).min(n2)
    };
    let mut gram = [[0.0; 4]; 4];
    let mut add = |lag: f64, weight: f64, sharp: f64| {
        let mut r = [sharp, 0.0, 0.0, 0.0];
        for (a, ca) in C.iter().enumerate() {
            for (b, cb) in C.iter().enumerate() {
                let t = ((lag + a as f64 * second - b as f64 * first) / first).abs();
                let log = if t > 0.0 { t.ln() } else { 0.0 };
                let c = ca * cb;
                r[1] -= c * 0.5 * t * first * white;
                r[2] += c * t * t * log * first * first / (2.0 * PI);
                r[3] += c * t * t * t * first.powi(3) / 12.0;
            }
        }
        let only = sharp != 0.0;
        for (i, (row, a)) in gram.iter_mut().zip(r).enumerate() {
            for (j, (cell, b)) in row.iter_mut().zip(r).enumerate() {
                // lags of the quantization are single ones, all others stand for those near them
                if (i == 0 || j == 0) == only {
                    *cell += weight * a * b;
                }
            }
        }
    };
    for (lag, weight) in lags(first, second) {
        let pairs = pairs(lag);
        if pairs > 0.0 {
            add(lag, pairs * weight, 0.0);
        }
    }
    let mut sharp: Vec<(i64, f64)> = Vec::new();
    for (a, ca) in C.iter().enumerate() {
        for (b, cb) in C.iter().enumerate() {
            let lag = b as i64 * one.m as i64 - a as i64 * two.m as i64;
            match sharp.iter_mut().find(|(other, _)| *other == lag) {
                Some((_, sum)) => *sum += ca * cb,
                None => sharp.push((lag, ca * cb)),
            }
        }
    }
    for (lag, sum) in sharp.into_iter().filter(|(_, sum)| *sum != 0.0) {
        add(lag as f64, pairs(lag as f64), sum);
    }
    let scale = 2.0 / (4.0 * (first * second).powi(2) * n1 * n2);
    gram.iter_mut().flatten().for_each(|cell| *cell *= scale);
    gram
}

/// `cov` for squares `(Q^2, N^2, B^2, K^2)` of the coefficients in units of a sample.
pub(super) fn covariance(gram: &Gram, squares: [f64; 4]) -> f64 {
    gram.iter().zip(squares).map(|(row, a)| a * row.iter().zip(squares).map(|(g, b)| g * b).sum::<f64>()).sum()
}
