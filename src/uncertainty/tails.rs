//! Incomplete beta and gamma functions, both tails at once, accurate in relative terms down to 1e-300.
//!
//! statrs has both, but takes its leading factor as a difference of log-gammas and stops its continued fraction after 140
//! terms, so that large parameters lose digits. Here the factor is a saddle-point form (C. Loader, "Fast and accurate
//! computation of binomial probabilities", 2000), and as many terms are taken as are needed.

use statrs::function::gamma::ln_gamma;
use std::f64::consts::{PI, TAU};

/// Two complementary probabilities, and the density on a logarithmic scale, `x d(lower)/dx` up to sign.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tails {
    pub lower: f64,
    pub upper: f64,
    pub density: f64,
}

impl Tails {
    fn swapped(self) -> Self {
        Tails { lower: self.upper, upper: self.lower, density: self.density }
    }
}

/// More terms than any continued fraction or series needs for parameters up to 1e10.
const TERMS: usize = 1_000_000;

/// `I_x(a, b)` (lower) and `I_y(b, a)` (upper) with `y = 1 - x` given for its own accuracy; `density = x^a y^b / B(a, b)`.
pub(super) fn beta(a: f64, b: f64, x: f64, y: f64) -> Tails {
    if x > (a + 1.0) / (a + b + 2.0) {
        return beta_small(b, a, y, x).swapped();
    }
    beta_small(a, b, x, y)
}

/// Continued fraction DLMF 8.17.22, for `x` below the mean, by Lentz's method.
fn beta_small(a: f64, b: f64, x: f64, y: f64) -> Tails {
    let n = a + b;
    let exponent = stirling_error(n) - stirling_error(a) - stirling_error(b) - deviance(a, n * x) - deviance(b, n * y);
    let density = (a * b / n / TAU).sqrt() * exponent.exp();
    let mut d = 1.0 / guard(1.0 - n * x / (a + 1.0));
    let (mut c, mut fraction) = (1.0, d);
    for k in 1..TERMS {
        let k = k as f64;
        let even = k * (b - k) * x / ((a + 2.0 * k - 1.0) * (a + 2.0 * k));
        d = 1.0 / guard(1.0 + even * d);
        c = guard(1.0 + even / c);
        fraction *= d * c;
        let odd = -(a + k) * (n + k) * x / ((a + 2.0 * k) * (a + 2.0 * k + 1.0));
        d = 1.0 / guard(1.0 + odd * d);
        c = guard(1.0 + odd / c);
        fraction *= d * c;
        if (d * c - 1.0).abs() <= f64::EPSILON {
            break;
        }
    }
    let lower = density * fraction / a;
    Tails { lower, upper: 1.0 - lower, density }
}

/// `P(a, x)` (lower) and `Q(a, x)` (upper); `density = x^a e^-x / Gamma(a)`.
pub(super) fn gamma(a: f64, x: f64) -> Tails {
    let density = (a / TAU).sqrt() * (-stirling_error(a) - deviance(a, x)).exp();
    if x < a + 1.0 {
        // Power series DLMF 8.7.1.
        let (mut term, mut sum) = (1.0, 1.0);
        for k in 1..TERMS {
            term *= x / (a + k as f64);
            sum += term;
            if term <= sum * f64::EPSILON {
                break;
            }
        }
        let lower = density / a * sum;
        return Tails { lower, upper: 1.0 - lower, density };
    }
    // Continued fraction DLMF 8.9.2 by Lentz's method.
    let mut b = x + 1.0 - a;
    let mut d = 1.0 / guard(b);
    let (mut c, mut fraction) = (1.0 / f64::MIN_POSITIVE, d);
    for k in 1..TERMS {
        let k = k as f64;
        let numerator = -k * (k - a);
        b += 2.0;
        d = 1.0 / guard(numerator * d + b);
        c = guard(b + numerator / c);
        fraction *= d * c;
        if (d * c - 1.0).abs() <= f64::EPSILON {
            break;
        }
    }
    let upper = density * fraction;
    Tails { lower: 1.0 - upper, upper, density }
}

/// Lentz's guard against a vanishing denominator.
fn guard(value: f64) -> f64 {
    if value.abs() < 1e-290 { 1e-290 } else { value }
}

/// `ln Gamma(z + 1) - (z + 1/2) ln z + z - ln(2 pi)/2`: what Stirling's formula leaves (DLMF 5.11.1).
fn stirling_error(z: f64) -> f64 {
    if z < 16.0 {
        return ln_gamma(z + 1.0) - (z + 0.5) * z.ln() + z - 0.5 * (2.0 * PI).ln();
    }
    let s = 1.0 / (z * z);
    (1.0 / 12.0 - (1.0 / 360.0 - (1.0 / 1260.0 - (1.0 / 1680.0 - (1.0 / 1188.0) * s) * s) * s) * s) / z
}

/// `x ln(x/m) + m - x` without cancellation where `x` is near `m` (Loader's deviance).
fn deviance(x: f64, m: f64) -> f64 {
    let difference = x - m;
    if difference.abs() >= 0.1 * (x + m) {
        return x * (x / m).ln() - difference;
    }
    let v = difference / (x + m);
    let mut sum = difference * v;
    let mut term = 2.0 * x * v;
    for k in 1..1000 {
        term *= v * v;
        let next = sum + term / (2 * k + 1) as f64;
        if next == sum {
            break;
        }
        sum = next;
    }
    sum
}
