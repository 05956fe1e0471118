//! Cdf, survival function and quantile of the normal, Student t, chi-square and F distributions.
//!
//! Degrees of freedom are positive numbers, not only integers (Welch-Satterthwaite), and may be infinite: Student t is then
//! the normal distribution, `d1 F` chi-square. Survival functions keep their relative accuracy in the far tail, so that
//! a p-value of 1e-40 is one. Every function returns `None` outside its domain (NaN, `p` not between 0 and 1, degrees of
//! freedom not positive) and where the answer exceeds a double.

use super::tails::{self, Tails};
use std::cell::Cell;

/// Above this Student t is expanded about the normal distribution.
const NEARLY_NORMAL: f64 = 1e6;

/// `P(Z <= z)`.
pub fn normal_cdf(z: f64) -> Option<f64> {
    let Tails { upper, .. } = normal_tails(z);
    (!z.is_nan()).then_some(if z > 0.0 { 1.0 - 0.5 * upper } else { 0.5 * upper })
}

/// `P(Z > z)`.
pub(crate) fn normal_survival(z: f64) -> Option<f64> {
    normal_cdf(-z)
}

/// `z` with `P(Z <= z) = p`.
pub(crate) fn normal_quantile(p: f64) -> Option<f64> {
    if !in_unit(p) || p == 0.5 {
        return (p == 0.5).then_some(0.0);
    }
    let q = p - 0.5;
    if q.abs() <= 0.425 {
        return Some(q * quotient(&CENTRAL, 0.180625 - q * q));
    }
    let r = (-p.min(1.0 - p).ln()).sqrt();
    let z = if r <= 5.0 { quotient(&MIDDLE, r - 1.6) } else { quotient(&FAR, r - 5.0) };
    Some(if p < 0.5 { -z } else { z })
}

/// Numerator and denominator by falling powers: M. J. Wichura, "Algorithm AS 241", Applied Statistics 37 (1988), PPND16.
type Rational = [[f64; 8]; 2];

#[rustfmt::skip]
#[allow(clippy::excessive_precision)]
const CENTRAL: Rational = [
    [2.5090809287301226727e3, 3.3430575583588128105e4, 6.7265770927008700853e4, 4.5921953931549871457e4,
     1.3731693765509461125e4, 1.9715909503065514427e3, 1.3314166789178437745e2, 3.3871328727963666080e0],
    [5.2264952788528545610e3, 2.8729085735721942674e4, 3.9307895800092710610e4, 2.1213794301586595867e4,
     5.3941960214247511077e3, 6.8718700749205790830e2, 4.2313330701600911252e1, 1.0],
];
#[rustfmt::skip]
#[allow(clippy::excessive_precision)]
const MIDDLE: Rational = [
    [7.74545014278341407640e-4, 2.27238449892691845833e-2, 2.41780725177450611770e-1, 1.27045825245236838258e0,
     3.64784832476320460504e0, 5.76949722146069140550e0, 4.63033784615654529590e0, 1.42343711074968357734e0],
    [1.05075007164441684324e-9, 5.47593808499534494600e-4, 1.51986665636164571966e-2, 1.48103976427480074590e-1,
     6.89767334985100004550e-1, 1.67638483018380384940e0, 2.05319162663775882187e0, 1.0],
];
#[rustfmt::skip]
#[allow(clippy::excessive_precision)]
const FAR: Rational = [
    [2.01033439929228813265e-7, 2.71155556874348757815e-5, 1.24266094738807843860e-3, 2.65321895265761230930e-2,
     2.96560571828504891230e-1, 1.78482653991729133580e0, 5.46378491116411436990e0, 6.65790464350110377720e0],
    [2.04426310338993978564e-15, 1.42151175831644588870e-7, 1.84631831751005468180e-5, 7.86869131145613259100e-4,
     1.48753612908506148525e-2, 1.36929880922735805310e-1, 5.99832206555887937690e-1, 1.0],
];

fn quotient(of: &Rational, r: f64) -> f64 {
    let [above, below] = of.map(|powers| powers.iter().fold(0.0, |sum, c| sum * r + c));
    above / below
}

/// `P(T <= t)` for `nu` degrees of freedom.
pub(crate) fn student_t_cdf(t: f64, nu: f64) -> Option<f64> {
    student_t_survival(-t, nu)
}

/// `P(T > t)` for `nu` degrees of freedom.
pub(crate) fn student_t_survival(t: f64, nu: f64) -> Option<f64> {
    if t.is_nan() || !positive(nu) {
        return None;
    }
    let both = student_t_tails(t.abs(), nu);
    Some(if t >= 0.0 { 0.5 * both.upper } else { 1.0 - 0.5 * both.upper })
}

/// `P(|T| > |t|)`: the two-sided p-value.
pub(crate) fn student_t_two_sided(t: f64, nu: f64) -> Option<f64> {
    (!t.is_nan() && positive(nu)).then(|| student_t_tails(t.abs(), nu).upper)
}

/// `t` with `P(T <= t) = p` for `nu` degrees of freedom.
pub(crate) fn student_t_quantile(p: f64, nu: f64) -> Option<f64> {
    if !in_unit(p) || !positive(nu) {
        return None;
    }
    if nu.is_infinite() {
        return normal_quantile(p);
    }
    if p == 0.5 {
        return Some(0.0);
    }
    let one_sided = p.min(1.0 - p);
    let z = normal_quantile(one_sided)?;
    let start = match expanded(z.abs(), nu) {
        Some(t) => t.ln(),
        None => 0.5 * (nu.ln() + (z * z / nu * (1.0 + 0.5 / nu)).min(700.0).exp_m1().ln()),
    };
    let beta = tails::Beta::new(0.5, 0.5 * nu);
    let t = solve(start, two_sided_target(one_sided), |t| student_t_of(&beta, t, nu))?;
    Some(if p < 0.5 { -t } else { t })
}

/// The expansion of Student t about the normal deviate `z`, Abramowitz and Stegun 26.7.5; a start for more exact ways.
fn expanded(z: f64, nu: f64) -> Option<f64> {
    if !(nu > 4.0 && z < 0.5 * nu.sqrt() + 1.5) {
        return None;
    }
    let s = z * z;
    let terms = [
        (s + 1.0) / 4.0,
        ((5.0 * s + 16.0) * s + 3.0) / 96.0,
        (((3.0 * s + 19.0) * s + 17.0) * s - 15.0) / 384.0,
        ((((79.0 * s + 776.0) * s + 1482.0) * s - 1920.0) * s - 945.0) / 92_160.0,
    ];
    let t = z * (1.0 + terms.iter().rev().fold(0.0, |sum, term| (sum + term) / nu));
    (t > 0.0 && t.is_finite()).then_some(t)
}

/// Half of the interval about zero that holds a sum of Student distributions with the probability `level`: weight, place and scale of each, `nu` degrees of freedom
/// (infinite: normal). `None` where a number is none.
pub(crate) fn mixture_half_interval(parts: &[(f64, f64, f64)], nu: f64, level: f64) -> Option<f64> {
    let beyond = |x: f64| if nu.is_finite() { student_t_survival(x, nu) } else { normal_survival(x) };
    let outside = |half: f64| -> Option<f64> {
        let mut sum = 0.0;
        for (weight, place, scale) in parts {
            sum += weight
                * match *scale > 0.0 {
                    true if *place == 0.0 => 2.0 * beyond(half / scale)?,
                    true => beyond((half - place) / scale)? + beyond((half + place) / scale)?,
                    false => f64::from(u8::from(place.abs() > half)),
                };
        }
        Some(sum)
    };
    let widest = parts.iter().map(|(_, place, scale)| place.abs() + scale).fold(0.0, f64::max);
    falls(outside, 1.0 - level, widest, 1e-13)
}

/// Where a probability falls to `level`, to a share of the place: doubled from a first guess, then halved. `None` where the probability has no value, or stays above.
pub(crate) fn falls(probability: impl Fn(f64) -> Option<f64>, level: f64, guess: f64, share: f64) -> Option<f64> {
    let (mut low, mut high) = (0.0, guess);
    while probability(high)? > level {
        (low, high) = (high, 2.0 * high);
        if !high.is_finite() {
            return None;
        }
    }
    while high - low > share * high {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if probability(middle)? > level { low = middle } else { high = middle }
    }
    Some(0.5 * (low + high))
}

/// Coverage factor `k` for a two-sided interval of coverage `level` (GUM G.3.2): `k = t_((1+level)/2)(nu)`.
///
/// ```
/// use tumble::uncertainty::quantiles::coverage_factor;
/// // GUM Table G.2: 95.45 % and 10 degrees of freedom, k = 2.28.
/// assert!((coverage_factor(0.9545, 10.0).unwrap() - 2.28).abs() < 0.005);
/// ```
pub fn coverage_factor(level: f64, nu: f64) -> Option<f64> {
    // all quantities of a fit ask the same
    thread_local! {
        static LAST: Cell<Option<(u64, u64, Option<f64>)>> = const { Cell::new(None) };
    }
    let bits = (level.to_bits(), nu.to_bits());
    match LAST.get() {
        Some((of_level, of_nu, factor)) if (of_level, of_nu) == bits => factor,
        _ => {
            let factor = student_t_quantile(0.5 * (1.0 - level), nu).map(f64::abs);
            LAST.set(Some((bits.0, bits.1, factor)));
            factor
        }
    }
}

/// `P(chi^2 <= x)` for `nu` degrees of freedom.
pub(crate) fn chi_square_cdf(x: f64, nu: f64) -> Option<f64> {
    chi_square_tails(x, nu).map(|tails| tails.lower)
}

/// `P(chi^2 > x)` for `nu` degrees of freedom.
///
/// ```
/// use tumble::uncertainty::quantiles::chi_square_survival;
/// // Two degrees of freedom: exp(-x/2).
/// assert!((chi_square_survival(200.0, 2.0).unwrap() / (-100.0_f64).exp() - 1.0).abs() < 1e-13);
/// ```
pub fn chi_square_survival(x: f64, nu: f64) -> Option<f64> {
    chi_square_tails(x, nu).map(|tails| tails.upper)
}

/// `x` with `P(chi^2 <= x) = p` for `nu` degrees of freedom.
pub(crate) fn chi_square_quantile(p: f64, nu: f64) -> Option<f64> {
    if !in_unit(p) || !positive(nu) || nu.is_infinite() {
        return None;
    }
    // E. B. Wilson, M. M. Hilferty, PNAS 17 (1931).
    let root = 1.0 - 2.0 / (9.0 * nu) + normal_quantile(p)? * (2.0 / (9.0 * nu)).sqrt();
    let start = nu.ln() + 3.0 * root.max(1e-3).ln();
    solve(start, Target::of_smaller(p, 1.0 - p), |x| tails::gamma(0.5 * nu, 0.5 * x))
}

/// `P(F <= f)` for `d1` (numerator) and `d2` (denominator) degrees of freedom.
pub(crate) fn fisher_f_cdf(f: f64, d1: f64, d2: f64) -> Option<f64> {
    fisher_f_tails(f, d1, d2).map(|tails| tails.lower)
}

/// `P(F > f)` for `d1` (numerator) and `d2` (denominator) degrees of freedom.
pub(crate) fn fisher_f_survival(f: f64, d1: f64, d2: f64) -> Option<f64> {
    fisher_f_tails(f, d1, d2).map(|tails| tails.upper)
}

/// `f` with `P(F <= f) = p` for `d1` (numerator) and `d2` (denominator) degrees of freedom.
pub(crate) fn fisher_f_quantile(p: f64, d1: f64, d2: f64) -> Option<f64> {
    if !in_unit(p) || !positive(d1) || !positive(d2) {
        return None;
    }
    if d1.is_infinite() && d2.is_infinite() {
        return Some(1.0);
    }
    let start = normal_quantile(p)? * (2.0 / d1 + 2.0 / d2).sqrt();
    solve(start, Target::of_smaller(p, 1.0 - p), |f| fisher_f_pair(f, d1, d2))
}

fn positive(nu: f64) -> bool {
    nu > 0.0
}

fn in_unit(p: f64) -> bool {
    p > 0.0 && p < 1.0
}

/// `P(|Z| <= |z|)` and `P(|Z| > |z|)`; statrs's `erfc` has ten digits only.
fn normal_tails(z: f64) -> Tails {
    if z.is_infinite() {
        return Tails { lower: 1.0, upper: 0.0, density: 0.0 };
    }
    let Tails { lower, upper, density } = tails::gamma(0.5, 0.5 * z * z);
    Tails { lower, upper, density: 2.0 * density }
}

/// `P(|T| <= t)` and `P(|T| > t)`, `t` not negative.
fn student_t_tails(t: f64, nu: f64) -> Tails {
    student_t_of(&tails::Beta::new(0.5, 0.5 * nu.min(NEARLY_NORMAL)), t, nu)
}

/// The same with the distribution of `1/(1 + t^2/nu)` at hand.
fn student_t_of(beta: &tails::Beta, t: f64, nu: f64) -> Tails {
    if nu > NEARLY_NORMAL {
        return normal_tails(normal_deviate(t, nu));
    }
    // x = 1/(1 + t^2/nu), and y = 1 - x from the same quotient.
    let ratio = t / nu.sqrt() * (t / nu.sqrt());
    let (x, y) = if ratio.is_finite() { (1.0 / (1.0 + ratio), ratio / (1.0 + ratio)) } else { (0.0, 1.0) };
    let Tails { lower, upper, density } = beta.tails(y, x);
    Tails { lower, upper, density: 2.0 * density }
}

/// The normal deviate with the same tail as `t`: G. W. Hill, "Algorithm 395: Student's t-distribution", CACM 13 (1970).
fn normal_deviate(t: f64, nu: f64) -> f64 {
    if nu.is_infinite() {
        return t;
    }
    let a = nu - 0.5;
    let b = 48.0 * a * a;
    let s = a * (t / nu.sqrt() * (t / nu.sqrt())).ln_1p();
    let z = s.sqrt();
    z + z * (s + 3.0) / b - z * (((4.0 * s + 33.0) * s + 240.0) * s + 855.0) / (10.0 * b * (b + 0.8 * s * s + 100.0))
}

fn chi_square_tails(x: f64, nu: f64) -> Option<Tails> {
    let tails = |x: f64| of_positive(x, |x| tails::gamma(0.5 * nu, 0.5 * x));
    if positive(nu) && nu.is_finite() { tails(x) } else { None }
}

fn fisher_f_tails(f: f64, d1: f64, d2: f64) -> Option<Tails> {
    if positive(d1) && positive(d2) { of_positive(f, |f| fisher_f_pair(f, d1, d2)) } else { None }
}

/// The tails of a variable that is above zero, `tails` those at such a number; `None` for what is no number.
fn of_positive(x: f64, tails: impl FnOnce(f64) -> Tails) -> Option<Tails> {
    Some(match x {
        x if x.is_nan() => return None,
        x if x <= 0.0 => Tails { lower: 0.0, upper: 1.0, density: 0.0 },
        f64::INFINITY => Tails { lower: 1.0, upper: 0.0, density: 0.0 },
        x => tails(x),
    })
}

fn fisher_f_pair(f: f64, d1: f64, d2: f64) -> Tails {
    if d1.is_infinite() && d2.is_infinite() {
        let lower = if f >= 1.0 { 1.0 } else { 0.0 };
        return Tails { lower, upper: 1.0 - lower, density: 0.0 };
    }
    if nearly_infinite(d2, d1) {
        return nearly_chi_square(f, d1, d2);
    }
    if nearly_infinite(d1, d2) {
        let Tails { lower, upper, density } = nearly_chi_square(1.0 / f, d2, d1);
        return Tails { lower: upper, upper: lower, density };
    }
    let odds = d1 * f / d2;
    let (x, y) = if odds.is_finite() { (odds / (1.0 + odds), 1.0 / (1.0 + odds)) } else { (1.0, 0.0) };
    tails::beta(0.5 * d1, 0.5 * d2, x, y)
}

/// Whether what [`nearly_chi_square`] leaves is beyond a double's digits.
fn nearly_infinite(large: f64, small: f64) -> bool {
    large > 1e8 && (small.powi(3) < 1e-12 * large * large)
}

/// F with a denominator that is nearly infinite: leading term of the expansion of A. R. DiDonato, A. H. Morris, "Algorithm
/// 708", ACM TOMS 18 (1992), `I_x(a, b) ~ Q(b, -(a + (b-1)/2) ln x)`; what it leaves is of order `d1^3 / d2^2`.
fn nearly_chi_square(f: f64, d1: f64, d2: f64) -> Tails {
    let (a, b) = (0.5 * d2, 0.5 * d1);
    let argument = if d2.is_infinite() { b * f } else { (a + 0.5 * (b - 1.0)) * (b * f / a).ln_1p() };
    tails::gamma(b, argument)
}

/// A two-sided target from the smaller one-sided probability: `1 - 2 p` is exact above one quarter.
fn two_sided_target(p: f64) -> Target {
    Target::of_smaller(1.0 - 2.0 * p, 2.0 * p)
}

/// Which of two complementary probabilities a quantile is sought by, and its logarithm.
enum Target {
    Lower(f64),
    Upper(f64),
}

impl Target {
    /// The smaller one, because its logarithm says more.
    fn of_smaller(lower: f64, upper: f64) -> Self {
        if lower < upper { Target::Lower(lower.ln()) } else { Target::Upper(upper.ln()) }
    }
}

/// `x > 0` where the tails meet the target: Newton's method on the logarithms of both, bracketed; `start` is `ln x`.
fn solve(start: f64, target: Target, tails: impl Fn(f64) -> Tails) -> Option<f64> {
    const LEAST: f64 = 1e-307;
    const MOST: f64 = 1e307;
    const SETTLED: f64 = 1e-10;
    let (mut low, mut high) = (LEAST, MOST);
    let mut x = start.exp();
    if !(x > low && x < high) {
        x = 1.0;
    }
    for _ in 0..200 {
        let Tails { lower, upper, density } = tails(x);
        let (excess, slope) = match target {
            Target::Lower(target) => (lower.ln() - target, density / lower),
            Target::Upper(target) => (target - upper.ln(), density / upper),
        };
        if excess > 0.0 {
            high = x
        } else {
            low = x
        }
        let change = (-excess / slope).exp_m1();
        let newton = x + x * change;
        // the step after such a one would be its square times the curvature
        if change.abs() <= SETTLED && newton > LEAST && newton < MOST {
            x = newton;
            break;
        }
        let next = if newton > low && newton < high { newton } else { low.sqrt() * high.sqrt() };
        let settled = (next / x - 1.0).abs() <= 2.0 * f64::EPSILON;
        x = next;
        if settled {
            break;
        }
    }
    (x > 10.0 * LEAST && x < 0.1 * MOST).then_some(x)
}

/// Logarithm of the gamma function of a positive number: Stirling's series from 8 on.
pub(crate) fn ln_gamma(x: f64) -> f64 {
    let (mut x, mut s) = (x, 0.0);
    while x < 8.0 {
        s -= x.ln();
        x += 1.0;
    }
    s + (x - 0.5) * x.ln() - x + 0.918_938_533_204_672_8 + 1.0 / (12.0 * x) - 1.0 / (360.0 * x.powi(3))
        + 1.0 / (1260.0 * x.powi(5))
}
