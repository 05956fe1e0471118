//! Covariances of block means, and what each block brings that the blocks before it did not foretell.

use crate::linear::dot;

/// A stationary process of block means, up to a common factor and (where contrasts are all that counts) a common constant: how each value is foretold by
/// those before it, and what does not depend on the values.
pub(super) struct Process {
    foretold: Foretold,
    /// Variance of what is not foretold, for each value.
    variances: Vec<f64>,
    /// Innovations of a constant and of a ramp.
    constant: Vec<f64>,
    ramp: Vec<f64>,
    /// Over the first values: their logarithms of variances, and the weighted products of these innovations.
    sums: Vec<Sums>,
}

enum Foretold {
    /// By weights of each order, from the first value to the one before: any covariance.
    Weights(Vec<Vec<f64>>),
    /// Covariances that fall in one ratio from the first lag on. A value less that multiple of the one before is correlated with its neighbours alone,
    /// and foretold by the innovation before, with this weight (Brockwell and Davis, Time Series, 5.3, for ARMA(1,1)).
    Neighbour { ratio: f64, weights: Vec<f64> },
}

#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    log: f64,
    one: f64,
    tt: f64,
    t1: f64,
}

/// Sums of products of innovations over one piece.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Products {
    pub xx: f64,
    pub x1: f64,
    pub xt: f64,
    pub one: f64,
    pub tt: f64,
    pub t1: f64,
    pub log: f64,
}

impl Process {
    /// From its covariance at each lag, by Durbin's and Levinson's recursion. `None` where it is not positive definite.
    pub fn new(covariance: &[f64]) -> Option<Self> {
        let n = covariance.len();
        let (mut weights, mut variances): (Vec<Vec<f64>>, Vec<f64>) = (Vec::with_capacity(n), Vec::with_capacity(n));
        let mut now: Vec<f64> = Vec::new();
        let mut variance = *covariance.first()?;
        for t in 0..n {
            if !(variance > 0.0) {
                return None;
            }
            weights.push(now.iter().rev().copied().collect());
            variances.push(variance);
            let Some(next) = covariance.get(t + 1) else { break };
            let known: f64 = now.iter().zip(covariance.iter().skip(1).take(t).rev()).map(|(w, c)| w * c).sum();
            let reflection = (next - known) / variance;
            let back: Vec<f64> = now.iter().rev().map(|w| reflection * w).collect();
            now.iter_mut().zip(back).for_each(|(w, b)| *w -= b);
            now.push(reflection);
            variance *= 1.0 - reflection * reflection;
        }
        Some(Self::of(Foretold::Weights(weights), variances))
    }

    /// White noise of variance one and a first-order Markov process of `size` times that variance and correlation time `tau`, at `count` blocks of length
    /// one: `n` steps for `n` values.
    pub fn markov(count: usize, size: f64, tau: f64) -> Option<Self> {
        let ([own, next], ratio) = markov_lags(tau);
        let (own, next) = (1.0 + size * own, size * next);
        // of a value less `ratio` of the one before: its variance, and its covariance with the one before
        let (apart, beside) = (own * (1.0 + ratio * ratio) - 2.0 * ratio * next, next - ratio * own);
        let (mut weights, mut variances): (Vec<f64>, Vec<f64>) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for t in 0..count {
            let weight = variances.last().map_or(0.0, |before| beside / before);
            let variance = if t == 0 { own } else { apart - weight * beside };
            if !(variance > 0.0) {
                return None;
            }
            weights.push(weight);
            variances.push(variance);
        }
        Some(Self::of(Foretold::Neighbour { ratio, weights }, variances))
    }

    fn of(foretold: Foretold, variances: Vec<f64>) -> Self {
        let n = variances.len();
        let mut process = Process { foretold, variances, constant: Vec::new(), ramp: Vec::new(), sums: Vec::new() };
        process.constant = process.innovations(&vec![1.0; n]);
        process.ramp = process.innovations(&(0..n).map(|k| k as f64).collect::<Vec<_>>());
        let lines = process.constant.iter().zip(&process.ramp).zip(&process.variances);
        process.sums = lines
            .scan(Sums::default(), |sums, ((one, t), variance)| {
                sums.log += variance.ln();
                sums.one += one * one / variance;
                sums.tt += t * t / variance;
                sums.t1 += t * one / variance;
                Some(*sums)
            })
            .collect();
        process
    }

    fn innovations(&self, values: &[f64]) -> Vec<f64> {
        match &self.foretold {
            Foretold::Weights(weights) => {
                let foretold = |t: usize, weights: &[f64]| values.get(..t).map_or(0.0, |before| dot(weights, before));
                values.iter().zip(weights).enumerate().map(|(t, (v, weights))| v - foretold(t, weights)).collect()
            }
            Foretold::Neighbour { ratio, weights } => {
                let (mut before, mut innovation) = (0.0, 0.0);
                let next = |(v, weight): (&f64, &f64)| {
                    innovation = v - ratio * before - weight * innovation;
                    before = *v;
                    innovation
                };
                values.iter().zip(weights).map(next).collect()
            }
        }
    }

    /// Innovations of values, each in its standard deviation.
    pub fn whitened(&self, values: &[f64]) -> Vec<f64> {
        self.in_deviations(&self.innovations(values), values.len())
    }

    /// The same of a constant and of a ramp over the first `count` places.
    pub fn whitened_line(&self, count: usize) -> (Vec<f64>, Vec<f64>) {
        (self.in_deviations(&self.constant, count), self.in_deviations(&self.ramp, count))
    }

    fn in_deviations(&self, innovations: &[f64], count: usize) -> Vec<f64> {
        innovations.iter().zip(&self.variances).take(count).map(|(v, variance)| v / variance.sqrt()).collect()
    }

    /// What the first `count` places say whatever the values; of none: nothing.
    fn sums(&self, count: usize) -> Sums {
        count.checked_sub(1).and_then(|last| self.sums.get(last)).copied().unwrap_or_default()
    }

    /// The logarithm of the determinant of the covariance of the first `count` values.
    pub fn log(&self, count: usize) -> f64 {
        self.sums(count).log
    }

    /// The sums of one piece.
    pub fn products(&self, values: &[f64]) -> Products {
        let Sums { log, one, tt, t1 } = self.sums(values.len());
        let mut p = Products { log, one, tt, t1, ..Products::default() };
        let parts = self.innovations(values).into_iter().zip(&self.constant).zip(&self.ramp).zip(&self.variances);
        for (((x, one), t), variance) in parts {
            let weighted = x / variance;
            p.xx += weighted * x;
            p.x1 += weighted * one;
            p.xt += weighted * t;
        }
        p
    }
}

/// Covariances, at lags 0 and 1, of means over neighbouring blocks of length one of a first-order Markov process of variance one, and the ratio in which they
/// fall from there on.
pub(super) fn markov_lags(tau: f64) -> ([f64; 2], f64) {
    let stay = (-1.0 / tau).exp();
    let part = tau * (1.0 - stay);
    ([markov_mean(1.0, tau), part * part], stay)
}

/// Variance of the mean of a first-order Markov process of variance one over `length`.
pub(super) fn markov_mean(length: f64, tau: f64) -> f64 {
    let x = length / tau;
    if x < 1e-4 {
        return 1.0 - x / 3.0;
    }
    2.0 / x * (1.0 - (1.0 - (-x).exp()) / x)
}

/// `F` with `F'' = -ln t`.
fn integral(t: f64) -> f64 {
    let t = t.abs();
    if t == 0.0 { 0.0 } else { -(0.5 * t * t * t.ln() - 0.75 * t * t) }
}

/// Generalized covariance of block means of flicker noise with spectral density `1/f`: that of contrasts is exact.
pub(super) fn flicker(count: usize) -> Vec<f64> {
    let constant = (4.0 * count as f64).ln() + 3.0;
    (0..count)
        .map(|lag| {
            let t = lag as f64;
            constant + integral(t + 1.0) + integral(t - 1.0) - 2.0 * integral(t)
        })
        .collect()
}

/// Variance of flicker noise `1/f` averaged from `start` over `length`, less its mean from 0 to `record`; not below half of that of the
/// difference of two neighbours (the Allan variance, `2 ln 2`).
pub(super) fn flicker_level(start: f64, length: f64, record: f64) -> f64 {
    let double = |a: f64, b: f64, c: f64, d: f64| integral(d - a) + integral(c - b) - integral(c - a) - integral(d - b);
    let (a, b) = (start, start + length);
    let own = double(a, b, a, b) / (length * length);
    let cross = double(a, b, 0.0, record) / (length * record);
    let all = double(0.0, record, 0.0, record) / (record * record);
    (own - 2.0 * cross + all).max(FLICKER_ALLAN)
}

/// Allan variance of flicker noise `1/f`.
pub(super) const FLICKER_ALLAN: f64 = 2.0 * std::f64::consts::LN_2;
