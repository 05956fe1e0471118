//! Incomplete beta and gamma functions, both tails at once, accurate in relative terms down to 1e-300.
//!
//! statrs has both, but takes its leading factor as a difference of log-gammas and stops its continued fraction after 140
//! terms, so that large parameters lose digits. Here the factor is a saddle-point form (C. Loader, "Fast and accurate
//! computation of binomial probabilities", 2000), and as many terms are taken as are needed.

use crate::number;
use std::f64::consts::TAU;

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

/// Above this the gamma distribution is expanded about the normal one.
const NEARLY_NORMAL: f64 = 1e10;
/// More terms than any continued fraction or series needs for parameters up to 1e10.
const TERMS: usize = 1_000_000;

/// `I_x(a, b)` (lower) and `I_y(b, a)` (upper) with `y = 1 - x` given for its own accuracy; `density = x^a y^b / B(a, b)`.
pub(super) fn beta(a: f64, b: f64, x: f64, y: f64) -> Tails {
    Beta::new(a, b).tails(x, y)
}

/// The same for many arguments: what depends on the parameters alone is worked out once.
#[derive(Debug, Clone, Copy)]
pub(super) struct Beta {
    a: f64,
    b: f64,
    /// What Stirling's formula leaves of `1 / B(a, b)`, logarithm.
    errors: f64,
    front: f64,
}

impl Beta {
    pub(super) fn new(a: f64, b: f64) -> Self {
        let n = a + b;
        let errors = stirling_error(n) - stirling_error(a) - stirling_error(b);
        Beta { a, b, errors, front: (a * b / n / TAU).sqrt() }
    }

    pub(super) fn tails(&self, x: f64, y: f64) -> Tails {
        // How far x lies below the mean, a - (a + b) x, without its cancellation.
        let below = self.a * y - self.b * x;
        if below < 0.0 {
            let swapped = Beta { a: self.b, b: self.a, ..*self };
            beta_below(&swapped, y, x, -below).swapped()
        } else {
            beta_below(self, x, y, below)
        }
    }
}

/// Continued fraction for `x` below the mean: A. R. DiDonato, A. H. Morris, "Algorithm 708", ACM TOMS 18 (1992), BFRAC.
fn beta_below(&Beta { a, b, errors, front }: &Beta, x: f64, y: f64, below: f64) -> Tails {
    let n = a + b;
    let exponent = errors - deviance(a, n * x, below) - deviance(b, n * y, -below);
    let density = front * exponent.exp();
    let denominator = |k: f64| {
        k + k * (b - k) * x / (a + 2.0 * k - 1.0) + (a + k) / (a + 2.0 * k + 1.0) * (below + 1.0 + k * (1.0 + y))
    };
    let first = a / (a + 1.0) * (below + 1.0);
    let numerator = |k: f64| {
        let width = a + 2.0 * k - 1.0;
        (a + k - 1.0) / width * ((n + k - 1.0) / width) * (k * (b - k)) * (x * x)
    };
    let lower = density * continued_fraction(first, numerator, denominator);
    Tails { lower, upper: 1.0 - lower, density }
}

/// `1/(b_0 + a_1/(b_1 + a_2/(b_2 + ...)))` by Lentz's method.
fn continued_fraction(first: f64, numerator: impl Fn(f64) -> f64, denominator: impl Fn(f64) -> f64) -> f64 {
    let guard = |value: f64| if value.abs() < 1e-290 { 1e-290 } else { value };
    let mut value = guard(first);
    let (mut c, mut d) = (value, 0.0);
    for k in 1..TERMS {
        let (a, b) = (numerator(k as f64), denominator(k as f64));
        d = 1.0 / guard(b + a * d);
        c = guard(b + a / c);
        value *= c * d;
        if (c * d - 1.0).abs() <= f64::EPSILON {
            break;
        }
    }
    1.0 / value
}

/// `P(a, x)` (lower) and `Q(a, x)` (upper); `density = x^a e^-x / Gamma(a)`.
pub(super) fn gamma(a: f64, x: f64) -> Tails {
    let density = (a / TAU).sqrt() * (-stirling_error(a) - deviance(a, x, a - x)).exp();
    if a > NEARLY_NORMAL {
        return gamma_nearly_normal(a, x, density);
    }
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
    // Continued fraction DLMF 8.9.2.
    let upper = density * continued_fraction(x + 1.0 - a, |k| k * (a - k), |k| x + 1.0 - a + 2.0 * k);
    Tails { lower: 1.0 - upper, upper, density }
}

/// N. M. Temme's uniform expansion, DLMF 8.12.3, whose first correction leaves `1/a`.
fn gamma_nearly_normal(a: f64, x: f64, density: f64) -> Tails {
    let eta = (2.0 * deviance(a, x, a - x) / a).sqrt().copysign(x - a);
    let Tails { lower, upper, .. } = gamma(0.5, 0.5 * a * eta * eta);
    let correction = density / a * (eta / 12.0 - 1.0 / 3.0);
    let tails = if eta < 0.0 { (0.5 * upper, 0.5 + 0.5 * lower) } else { (0.5 + 0.5 * lower, 0.5 * upper) };
    Tails { lower: tails.0 - correction, upper: tails.1 + correction, density }
}

/// [`stirling_error`] of 1/2, 1, 3/2 to 31/2, from its definition in 40 digits.
#[allow(clippy::excessive_precision)]
const STIRLING_OF_HALVES: [f64; 31] = [
    0.153_426_409_720_027_345,
    0.081_061_466_795_327_258_2,
    0.054_814_121_051_917_653_9,
    0.041_340_695_955_409_294_1,
    0.033_162_873_519_936_287_5,
    0.027_677_925_684_998_339_1,
    0.023_746_163_656_297_496,
    0.020_790_672_103_765_093_1,
    0.018_488_450_532_673_185_2,
    0.016_644_691_189_821_192_2,
    0.015_134_973_221_917_378_9,
    0.013_876_128_823_070_748,
    0.012_810_465_242_920_226_9,
    0.011_896_709_945_891_770_1,
    0.011_104_559_758_206_917_3,
    0.010_411_265_261_972_096_5,
    0.009_799_416_126_158_803_3,
    0.009_255_462_182_712_732_92,
    0.008_768_700_134_139_385_46,
    0.008_330_563_433_362_871_26,
    0.007_934_114_564_314_020_55,
    0.007_573_675_487_951_840_79,
    0.007_244_554_301_320_383_18,
    0.006_942_840_107_209_529_87,
    0.006_665_247_032_707_682_44,
    0.006_408_994_188_004_207_07,
    0.006_171_712_263_039_457_65,
    0.005_951_370_112_758_847_74,
    0.005_746_216_513_010_115_68,
    0.005_554_733_551_962_801_37,
    0.005_375_599_032_926_834_49,
];

/// `ln Gamma(z + 1) - (z + 1/2) ln z + z - ln(2 pi)/2`: what Stirling's formula leaves (DLMF 5.11.1).
fn stirling_error(z: f64) -> f64 {
    // half the degrees of freedom of anything counted
    let halves = 2.0 * z;
    if halves < 32.0 && halves.fract() == 0.0 {
        let known = number::count(halves).checked_sub(1).and_then(|k| STIRLING_OF_HALVES.get(k));
        if let Some(error) = known {
            return *error;
        }
    }
    // Upwards by ln Gamma(z + 2) = ln(z + 1) + ln Gamma(z + 1) until five terms are enough.
    let (mut z, mut below) = (z, 0.0);
    while z < 16.0 {
        below += (z + 0.5) * (1.0 / z).ln_1p() - 1.0;
        z += 1.0;
    }
    let s = 1.0 / (z * z);
    below + (1.0 / 12.0 - (1.0 / 360.0 - (1.0 / 1260.0 - (1.0 / 1680.0 - (1.0 / 1188.0) * s) * s) * s) * s) / z
}

/// `x ln(x/m) + m - x` without cancellation where `x` is near `m` (Loader's deviance); `difference = x - m`.
fn deviance(x: f64, m: f64, difference: f64) -> f64 {
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
