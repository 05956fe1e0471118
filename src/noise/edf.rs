//! Equivalent degrees of freedom of a deviation's square, and its chi-square interval.
//!
//! Greenhall and Riley, "Uncertainty of stability variances based on finite differences", PTTI 2003; NIST SP 1065, section 5.4.1. Its
//! notation is kept: `d` order of the differences, `alpha` power of the frequency in the spectral density, `F` filter factor, `S` stride factor.

use crate::number;
use crate::uncertainty::quantiles::chi_square_quantile;

/// Which deviation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Overlapping Allan.
    Allan,
    /// Overlapping Hadamard.
    Hadamard,
    /// Modified Allan.
    Modified,
    /// Allan without overlap.
    Separate,
}

/// Most terms that are summed; beyond, the paper's asymptotic form.
const MOST: f64 = 100.0;

/// Equivalent degrees of freedom for `m` samples averaged out of a record with `phases` values of the running sum.
///
/// `None` where the record is too short for one difference.
pub fn equivalent_dof(kind: Kind, alpha: i32, m: u64, phases: u64) -> Option<f64> {
    let d = if kind == Kind::Hadamard { 3.0 } else { 2.0 };
    let alpha = alpha.clamp(if kind == Kind::Hadamard { -4 } else { -2 }, 2);
    let (m, n) = (m as f64, phases as f64);
    let modified = kind == Kind::Modified;
    let f = if modified { 1.0 } else { m };
    let s = if kind == Kind::Separate { 1.0 } else { m };
    let length = m / f + m * d;
    let count = 1.0 + (s * (n - length) / m).floor();
    if !(count >= 1.0) {
        return None;
    }
    let terms = count.min((d + 1.0) * s);
    let r = count / s;
    let inverse = if !modified && alpha == 2 {
        if r.ceil() > d {
            let (a0, a1) = if d == 2.0 { (35.0 / 18.0, 1.0) } else { (231.0 / 100.0, 1.5) };
            (a0 - a1 / r) / count
        } else {
            // few averaging times: the sum itself, for the noise of one step shorter memory
            basic_sum(terms.min(MOST), count.min(MOST), s.min(MOST / r), f.min(MOST), 1, d)
        }
    } else if terms <= MOST {
        let f = if modified || m * (d + 1.0) <= MOST || alpha == 1 { f } else { f64::INFINITY };
        basic_sum(terms, count, s, f, alpha, d)
    } else if r > d + 1.0 {
        let (a0, a1) = asymptote(modified, alpha, number::count(d));
        let log = if !modified && alpha == 1 { logarithm(d, m) } else { 1.0 };
        (a0 - a1 / r) / (r * log)
    } else {
        let stride = MOST / r;
        match (modified, alpha) {
            (true, _) => basic_sum(MOST, MOST, stride, 1.0, alpha, d),
            (false, 1) => {
                let zero = sz(0.0, stride, 1, d).powi(2);
                basic_sum(MOST, MOST, stride, stride, 1, d) * zero / logarithm(d, m)
            }
            (false, _) => basic_sum(MOST, MOST, stride, f64::INFINITY, alpha, d),
        }
    };
    Some(1.0 / inverse).filter(|edf| edf.is_finite() && *edf > 0.0)
}

/// Ends of the interval that holds the deviation with probability `level`: `sigma sqrt(edf/chi2)`.
pub fn interval(deviation: f64, edf: f64, level: f64) -> Option<(f64, f64)> {
    let end = |p: f64| Some(deviation * (edf / chi_square_quantile(p, edf)?).sqrt());
    Some((end(0.5 + 0.5 * level)?, end(0.5 - 0.5 * level)?))
}

/// `(b0 + b1 ln m)^2` of the paper's table III: flicker of phase, order of differences `d`.
fn logarithm(d: f64, m: f64) -> f64 {
    let (b0, b1) = if d == 2.0 { (15.23, 12.0) } else { (47.8, 40.0) };
    (b0 + b1 * m.ln()).powi(2)
}

/// `a0`, `a1` of the paper's tables I (modified) and II.
fn asymptote(modified: bool, alpha: i32, d: usize) -> (f64, f64) {
    match (modified, alpha, d) {
        (true, 2, 2) => (7.0 / 9.0, 0.5),
        (true, 1, 2) => (0.997, 0.616),
        (true, 0, 2) => (1.033, 0.607),
        (true, -1, 2) => (1.048, 0.534),
        (true, _, 2) => (1.302, 0.535),
        (true, _, _) => (1.184, 0.848),
        (false, 1, 2) => (790.0, 410.0),
        (false, 0, 2) => (2.0 / 3.0, 1.0 / 3.0),
        (false, -1, 2) => (0.852, 0.375),
        (false, _, 2) => (1.079, 0.368),
        (false, 1, _) => (9950.0, 6520.0),
        (false, 0, _) => (7.0 / 9.0, 0.5),
        (false, -1, _) => (0.997, 0.617),
        (false, -2, _) => (1.033, 0.607),
        (false, -3, _) => (1.053, 0.553),
        (false, _, _) => (1.302, 0.535),
    }
}

/// `1/edf = BasicSum(J, M, S, F, alpha, d) / (sz(0)^2 M)`.
fn basic_sum(terms: f64, count: f64, s: f64, f: f64, alpha: i32, d: f64) -> f64 {
    let at = |j: f64| sz(j / s, f, alpha, d).powi(2);
    let mut sum = at(0.0) + (1.0 - terms / count) * at(terms);
    let mut j = 1.0;
    while j < terms {
        sum += 2.0 * (1.0 - j / count) * at(j);
        j += 1.0;
    }
    sum / (at(0.0) * count)
}

/// Autocovariance of the `d`-th differences.
fn sz(t: f64, f: f64, alpha: i32, d: f64) -> f64 {
    let binomials: &[f64] = if d == 2.0 { &[6.0, -4.0, 1.0] } else { &[20.0, -15.0, 6.0, -1.0] };
    binomials
        .iter()
        .enumerate()
        .map(|(k, c)| {
            let k = k as f64;
            if k == 0.0 { c * sx(t, f, alpha) } else { c * (sx(t - k, f, alpha) + sx(t + k, f, alpha)) }
        })
        .sum()
}

fn sx(t: f64, f: f64, alpha: i32) -> f64 {
    if f.is_infinite() {
        return sw(t, alpha + 2);
    }
    f * f * (2.0 * sw(t, alpha) - sw(t - 1.0 / f, alpha) - sw(t + 1.0 / f, alpha))
}

/// Generalized autocovariance of the running sum's own running sum.
fn sw(t: f64, alpha: i32) -> f64 {
    let size = t.abs();
    let log = if size == 0.0 { 0.0 } else { size.ln() };
    match alpha {
        4.. => 0.0,
        3 => -log,
        2 => -size,
        1 => size.powi(2) * log,
        0 => size.powi(3),
        -1 => -size.powi(4) * log,
        -2 => -size.powi(5),
        -3 => size.powi(6) * log,
        _ => size.powi(7),
    }
}
