//! Covariance of overlapping Allan variances of one record at different averaging times.
//!
//! Both are means of squares of differences `z` of the same running sum; for a normal process `cov(z1^2, z2^2) = 2 R^2` with
//! `R(lag) = sum c_a c_b gamma(lag + a m2 - b m1)`, `c = (1, -2, 1)`, and gamma the generalized covariance of the running sum: `Q^2 delta(t)`,
//! `-N^2 |t|/2`, `B^2 t^2 ln|t|/(2 pi)`, `K^2 |t|^3/12`. R is linear in the squares of the coefficients, so the sums over lags are kept once.

use std::f64::consts::PI;

/// Averaging times further apart than this are taken as uncorrelated (the correlation is below one per cent).
const FAR: u64 = 32;
/// Lags to an averaging time.
const FINE: f64 = 16.0;
const C: [f64; 3] = [1.0, -2.0, 1.0];

/// Sums over lags of products of covariances of the parts Q, N, B, K, for one pair of averaging times; the time unit is a sample.
pub(super) type Gram = [[f64; 4]; 4];

/// The sums for averaging over `m1 <= m2` samples with `n1`, `n2` differences each; `None` where they are far apart.
pub(super) fn gram((m1, n1): (u64, u64), (m2, n2): (u64, u64)) -> Option<Gram> {
    if m2 > FAR * m1 {
        return None;
    }
    let (first, second, n1, n2) = (m1 as f64, m2 as f64, n1 as f64, n2 as f64);
    // pairs of differences whose beginnings are so far apart
    let pairs = |lag: f64| (n1.min(n2 - lag) - (-lag).max(0.0)).max(0.0);
    let mut gram = [[0.0; 4]; 4];
    let mut add = |lag: f64, weight: f64, quantization: f64| {
        let mut r = [quantization, 0.0, 0.0, 0.0];
        for (a, ca) in C.iter().enumerate() {
            for (b, cb) in C.iter().enumerate() {
                let t = ((lag + a as f64 * second - b as f64 * first) / first).abs();
                let log = if t > 0.0 { t.ln() } else { 0.0 };
                let c = ca * cb;
                r[1] -= c * 0.5 * t * first;
                r[2] += c * t * t * log * first * first / (2.0 * PI);
                r[3] += c * t * t * t * first.powi(3) / 12.0;
            }
        }
        let only = quantization != 0.0;
        for (i, row) in gram.iter_mut().enumerate() {
            for (j, cell) in row.iter_mut().enumerate() {
                // lags of the quantization are single ones, all others stand for a step
                if (i == 0 || j == 0) == only
                    && let (Some(a), Some(b)) = (r.get(i), r.get(j))
                {
                    *cell += weight * a * b;
                }
            }
        }
    };
    let step = (first / FINE).floor().max(1.0);
    let mut lag = -(4.0 * second / step).ceil() * step;
    while lag <= 2.0 * first + 4.0 * second {
        add(lag, pairs(lag) * step, 0.0);
        lag += step;
    }
    let mut lags: Vec<(i64, f64)> = Vec::new();
    for (a, ca) in C.iter().enumerate() {
        for (b, cb) in C.iter().enumerate() {
            let lag = b as i64 * m1 as i64 - a as i64 * m2 as i64;
            match lags.iter_mut().find(|(other, _)| *other == lag) {
                Some((_, sum)) => *sum += ca * cb,
                None => lags.push((lag, ca * cb)),
            }
        }
    }
    for (lag, sum) in lags.into_iter().filter(|(_, sum)| *sum != 0.0) {
        add(lag as f64, pairs(lag as f64), sum);
    }
    let scale = 2.0 / (4.0 * (first * second).powi(2) * n1 * n2);
    gram.iter_mut().flatten().for_each(|cell| *cell *= scale);
    Some(gram)
}

/// `cov` for squares `(Q^2, N^2, B^2, K^2)` of the coefficients in units of a sample.
pub(super) fn covariance(gram: &Gram, squares: [f64; 4]) -> f64 {
    gram.iter().zip(squares).map(|(row, a)| a * row.iter().zip(squares).map(|(g, b)| g * b).sum::<f64>()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// White noise: 2/edf with edf = (3 (N - 1)/(2 m) - 2 (N - 2)/N) 4 m^2/(4 m^2 + 5), N phases (NIST SP 1065, 5.4.1).
    #[test]
    fn on_the_diagonal_stand_the_degrees_of_freedom() {
        let samples = 20_000_u64;
        for m in [1_u64, 4, 16] {
            let variance =
                covariance(&gram((m, samples + 1 - 2 * m), (m, samples + 1 - 2 * m)).unwrap(), [0.0, 1.0, 0.0, 0.0]);
            let (m, n) = (m as f64, samples as f64 + 1.0);
            let edf = (1.5 * (n - 1.0) / m - 2.0 * (n - 2.0) / n) * 4.0 * m * m / (4.0 * m * m + 5.0);
            let ours = 2.0 / (m * m * variance);
            assert!((ours / edf - 1.0).abs() < 0.01, "{m}: {ours} {edf}");
        }
    }
}
