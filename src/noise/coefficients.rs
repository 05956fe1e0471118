//! The coefficients of IEEE Std 952 by weighted least squares on Allan variances, with the covariance of correlated points.
#![allow(
    clippy::indexing_slicing,
    reason = "five terms, indexed by loops over five; gram matrices refer to points by number, and columns and variances have one entry for each point"
)]

use super::covariance::{Gram, covariance, gram};
use crate::linear::Triangle;
use crate::uncertainty::quantiles::chi_square_survival;
use crate::vocabulary::vocabulary;
use faer::{Mat, Side};
use std::f64::consts::{LN_2, PI};

vocabulary! {
    /// A coefficient's kind, by its letter in IEEE Std 952, from short to long averaging times.
    Term {
        /// Q, quantization: slope -1 of the deviation.
        Quantization = "Q",
        /// N, angle or velocity random walk (white noise): slope -1/2.
        RandomWalk = "N",
        /// B, bias instability (flicker): slope 0.
        BiasInstability = "B",
        /// K, rate or acceleration random walk: slope +1/2.
        RateRandomWalk = "K",
        /// R, rate or acceleration ramp: slope +1.
        Ramp = "R",
    }
}

impl Term {
    /// The letter of IEEE Std 952.
    pub fn letter(self) -> &'static str {
        self.name()
    }

    /// Allan variance at `tau` for a coefficient of one.
    pub fn variance(self, tau: f64) -> f64 {
        match self {
            Term::Quantization => 3.0 / (tau * tau),
            Term::RandomWalk => 1.0 / tau,
            Term::BiasInstability => 2.0 * LN_2 / PI,
            Term::RateRandomWalk => tau / 3.0,
            Term::Ramp => 0.5 * tau * tau,
        }
    }

    /// Power of the frequency in the spectral density (a ramp is taken as the steepest that a deviation bears).
    fn alpha(self) -> i32 {
        match self {
            Term::Quantization => 2,
            Term::RandomWalk => 0,
            Term::BiasInstability => -1,
            Term::RateRandomWalk | Term::Ramp => -2,
        }
    }
}

/// One coefficient, in the record's unit and seconds (Q: unit s; N: unit sqrt(s); B: unit; K: unit/sqrt(s); R: unit/s).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficient {
    /// Which.
    pub term: Term,
    /// Its value; `None` where the test does not find it.
    pub value: Option<f64>,
    /// Standard uncertainty of the value.
    pub u: Option<f64>,
    /// Probability of a square as large if it were zero.
    pub p: f64,
    /// Where it is not found, what it could be at most (95 %).
    pub below: Option<f64>,
}

/// All five coefficients, and how well they describe the deviations.
#[derive(Debug, Clone, PartialEq)]
pub struct Coefficients {
    /// In the order of [`Term::ALL`].
    pub terms: [Coefficient; 5],
    /// Generalized sum of squares of the deviations from the fitted line.
    pub chi_square: f64,
    /// Averaging times less coefficients.
    pub dof: usize,
    /// Probability of so large a sum of squares if the line holds.
    pub p: f64,
    /// The sampling interval where a rate random walk fits better as a walk that is sampled than as one averaged over each interval, s.
    pub walk_sampled: Option<f64>,
}

impl Coefficients {
    /// Does their sum describe the Allan variances? Not where so large a chi-square has a probability below 1 %.
    pub fn describes(&self) -> bool {
        !(self.p < 0.01)
    }
}

impl Coefficients {
    /// The fitted Allan variance at `tau`.
    pub fn variance(&self, tau: f64) -> f64 {
        let steps = self.walk_sampled.map_or(0.0, |interval| sampled_walk(interval, tau));
        let more = |term: Term| if term == Term::RateRandomWalk { steps } else { 0.0 };
        self.terms.iter().map(|c| c.value.map_or(0.0, |v| v * v * (c.term.variance(tau) + more(c.term)))).sum()
    }

    /// Power of the frequency of what dominates at `tau`.
    pub(super) fn alpha(&self, tau: f64) -> i32 {
        let size = |c: &Coefficient| c.value.map_or(0.0, |v| v * v * c.term.variance(tau));
        self.terms.iter().max_by(|a, b| size(a).total_cmp(&size(b))).map_or(0, |c| c.term.alpha())
    }

    /// One coefficient.
    pub fn get(&self, term: Term) -> Option<&Coefficient> {
        self.terms.iter().find(|c| c.term == term)
    }
}

/// What the Allan variance of a random walk of coefficient one has beside `tau/3` where its samples are values, not means over their interval:
/// `(2 m^2 + 1) dt/(6 m) - tau/3` with `m = tau/dt`.
fn sampled_walk(interval: f64, tau: f64) -> f64 {
    interval * interval / (6.0 * tau)
}

/// A coefficient is there if its square would be so large by chance less often than this.
const PRESENT: f64 = 0.001;
/// What one more coefficient must take off the sum of squares: the square of the normal quantile at that probability.
const TERM: f64 = 9.55;
const ROUNDS: usize = 12;

/// What the fit works on.
struct Points {
    variances: Vec<f64>,
    /// Variance at each averaging time for a square of one, in units of the observed variances.
    columns: [Vec<f64>; 5],
    grams: Vec<(usize, usize, Gram)>,
    interval: f64,
}

/// Squares of the coefficients that are in, their covariance, and the sum of squares.
struct Fitted {
    squares: [f64; 5],
    covariance: [[f64; 5]; 5],
    /// Skewness of each square's estimate: at the longest averaging times few differences are independent.
    skewness: [f64; 5],
    chi_square: f64,
}

/// Probability that an estimate of mean zero lies more than `z` standard deviations above it: a chi-square shifted to that mean, with the same
/// skewness `sqrt(8/nu)` (Pearson's type III), or the normal distribution where there is none.
fn beyond(z: f64, skewness: f64) -> f64 {
    let nu = 8.0 / (skewness * skewness);
    if skewness > 0.0 && nu < 1e4 {
        // what is not finite is far beyond
        return chi_square_survival((nu + z * (2.0 * nu).sqrt()).max(0.0), nu).unwrap_or(0.0);
    }
    0.5 * chi_square_survival(z * z, 1.0).unwrap_or(0.0)
}

/// The coefficients from Allan variances at averaging times `taus` (s); `shapes` has the samples averaged and the number of differences.
///
/// Weighted least squares on variances with their full covariance, which follows from the coefficients themselves and is renewed until it stands; squares are
/// not negative. A coefficient is there if leaving it out raises the generalized sum of squares (with the covariance that holds without it) beyond
/// what chance does in one case of a thousand. `None` for fewer averaging times than coefficients, or where nothing varies.
pub fn coefficients(taus: &[f64], variances: &[f64], shapes: &[(u64, u64)], interval: f64) -> Option<Coefficients> {
    if taus.len() < Term::ALL.len() || variances.iter().any(|v| !(*v > 0.0) || !v.is_finite()) {
        return None;
    }
    let mut grams = Vec::new();
    for (i, first) in shapes.iter().enumerate() {
        for (j, second) in shapes.iter().enumerate().skip(i) {
            grams.extend(gram(*first, *second).map(|gram| (i, j, gram)));
        }
    }
    let column = |term: Term, more: &dyn Fn(f64) -> f64| -> Vec<f64> {
        taus.iter().zip(variances).map(|(tau, v)| (term.variance(*tau) + more(*tau)) / v).collect()
    };
    let columns = Term::ALL.map(|term| column(term, &|_| 0.0));
    let mut points = Points { variances: variances.to_vec(), columns, grams, interval };
    let averaged = selected(&points)?;
    if averaged.get(Term::RateRandomWalk).is_none_or(|walk| walk.value.is_none()) {
        return Some(averaged);
    }
    // whether a logger takes values or means is not known: the one that needs less to be described
    points.columns[3] = column(Term::RateRandomWalk, &|tau| sampled_walk(interval, tau));
    let sampled = selected(&points).map(|own| Coefficients { walk_sampled: Some(interval), ..own });
    let cost = |own: &Coefficients| {
        own.chi_square + TERM * own.terms.iter().filter(|term| term.value.is_some()).count() as f64
    };
    Some(sampled.filter(|own| cost(own) < cost(&averaged)).unwrap_or(averaged))
}

/// The terms that are there.
fn selected(points: &Points) -> Option<Coefficients> {
    let mut active = [true; 5];
    let mut p = [1.0; 5];
    let mut fitted = points.fit(active)?;
    loop {
        // out with what is at zero, then with the least significant
        let at_zero = (0..5).find(|k| active[*k] && fitted.squares[*k] <= 0.0);
        let count = active.iter().filter(|a| **a).count();
        let mut weakest: Option<(usize, f64, Fitted)> = None;
        if at_zero.is_none() && count > 1 {
            for k in (0..5).filter(|k| active[*k]) {
                let mut without = active;
                without[k] = false;
                let Some(less) = points.fit(without) else { continue };
                let more = points.with_covariance_of(active, &less.squares)?;
                let drop = (less.chi_square - more.chi_square).max(0.0);
                let chance = beyond(drop.sqrt(), more.skewness[k]);
                p[k] = chance;
                if chance > PRESENT && weakest.as_ref().is_none_or(|(_, most, _)| chance > *most) {
                    weakest = Some((k, chance, less));
                }
            }
        }
        match (at_zero, weakest) {
            (Some(k), _) if count > 1 => {
                active[k] = false;
                p[k] = 1.0;
                fitted = points.fit(active)?;
            }
            (_, Some((k, _, less))) => {
                active[k] = false;
                fitted = less;
            }
            _ => break,
        }
    }
    let dof = points.variances.len().saturating_sub(active.iter().filter(|a| **a).count());
    let terms = std::array::from_fn(|k| {
        // five terms, five places
        let term = Term::ALL.get(k).copied().unwrap_or(Term::RandomWalk);
        if active[k] {
            let value = fitted.squares[k].sqrt();
            let u = fitted.covariance[k][k].max(0.0).sqrt() / (2.0 * value);
            let alone = active.iter().filter(|a| **a).count() == 1;
            return Coefficient {
                term,
                value: Some(value),
                u: Some(u).filter(|u| u.is_finite()),
                p: if alone { 0.0 } else { p[k] },
                below: None,
            };
        }
        let mut with = active;
        with[k] = true;
        let below = points.free(with, &fitted.squares).and_then(|more| {
            let most = more.squares[k].max(0.0) + 1.645 * more.covariance[k][k].max(0.0).sqrt();
            Some(most.sqrt()).filter(|v| v.is_finite())
        });
        Coefficient { term, value: None, u: None, p: p[k], below }
    });
    // a misfit that is not finite is rejected
    let p = chi_square_survival(fitted.chi_square, dof.max(1) as f64).unwrap_or(0.0);
    Some(Coefficients { terms, chi_square: fitted.chi_square, dof, p, walk_sampled: None })
}

impl Points {
    /// Fit with a covariance that follows from the fit itself.
    fn fit(&self, active: [bool; 5]) -> Option<Fitted> {
        // a first guess: each term touches the deviations from below
        let mut squares: [f64; 5] = std::array::from_fn(|k| {
            let column = self.columns.get(k).map_or(&[][..], Vec::as_slice);
            let most = column.iter().copied().fold(0.0, f64::max);
            if active[k] && most > 0.0 { 1.0 / most } else { 0.0 }
        });
        let mut fitted = None;
        for _ in 0..ROUNDS {
            let next = self.with_covariance_of(active, &squares)?;
            let change =
                (0..5).map(|k| (next.squares[k] - squares[k]).abs() / (next.squares[k] + squares[k]).max(1e-300));
            let largest = change.fold(0.0, f64::max);
            squares = next.squares;
            fitted = Some(next);
            if largest < 1e-6 {
                break;
            }
        }
        fitted
    }

    /// One generalized least-squares step with the covariance that `squares` give; squares that would be negative are set to zero.
    fn with_covariance_of(&self, active: [bool; 5], squares: &[f64; 5]) -> Option<Fitted> {
        let mut active = active;
        loop {
            let fitted = self.free(active, squares)?;
            let most_negative = (0..5).filter(|k| active[*k] && fitted.squares[*k] < 0.0).min_by(|a, b| {
                let z = |k: usize| fitted.squares[k] / fitted.covariance[k][k].sqrt();
                z(*a).total_cmp(&z(*b))
            });
            match most_negative {
                Some(k) if active.iter().filter(|a| **a).count() > 1 => active[k] = false,
                _ => return Some(fitted),
            }
        }
    }

    /// The same without bounds.
    fn free(&self, active: [bool; 5], squares: &[f64; 5]) -> Option<Fitted> {
        let n = self.variances.len();
        let dt = self.interval;
        // coefficients in units of a sample: the running sum is in unit x sample
        let [q, nn, b, k, _] = *squares;
        let own = [q / (dt * dt), nn / dt, b, k * dt];
        let mut c = Mat::<f64>::zeros(n, n);
        for (i, j, gram) in &self.grams {
            let value = covariance(gram, own) / (self.variances[*i] * self.variances[*j]);
            c[(*i, *j)] = value;
            c[(*j, *i)] = value;
        }
        // pairs that are far apart were left out: a little on the diagonal keeps the matrix definite
        for i in 0..n {
            c[(i, i)] *= 1.0 + 1e-6;
        }
        let factor = match c.llt(Side::Lower) {
            Ok(factor) => factor,
            Err(_) => {
                for i in 0..n {
                    for j in 0..n {
                        if i != j {
                            c[(i, j)] *= 0.9;
                        }
                    }
                }
                c.llt(Side::Lower).ok()?
            }
        };
        let which: Vec<usize> = (0..5).filter(|k| active[*k]).collect();
        let scales: Vec<f64> =
            which.iter().map(|k| self.columns[*k].iter().map(|v| v * v).sum::<f64>().sqrt().max(1e-300)).collect();
        let a = Mat::from_fn(n, which.len(), |i, j| self.columns[which[j]][i] / scales[j]);
        let y = Mat::from_fn(n, 1, |_, _| 1.0);
        let l = factor.L();
        let white = |m: &Mat<f64>| {
            let mut w = m.clone();
            faer::linalg::triangular_solve::solve_lower_triangular_in_place(l, w.as_mut(), faer::Par::Seq);
            w
        };
        let (a, y) = (white(&a), white(&y));
        let qr = a.col_piv_qr();
        // A P = Q R: (A'A)^-1 = P (R'R)^-1 P'
        let (r, order) = (qr.R(), qr.P().arrays().0);
        let least = f64::EPSILON * n as f64 * r[(0, 0)].abs();
        if !(0..which.len()).all(|k| r[(k, k)].abs() > least) {
            return None;
        }
        let pivoted = Triangle::of_upper(which.len(), |i, j| r[(i, j)]).inverse();
        let x = {
            use faer::linalg::solvers::SolveLstsq;
            qr.solve_lstsq(&y)
        };
        let residual = &y - &a * &x;
        let chi_square: f64 = (0..n).map(|i| residual[(i, 0)].powi(2)).sum();
        let mut squares = [0.0; 5];
        let mut covariance = [[0.0; 5]; 5];
        for (i, k) in which.iter().enumerate() {
            squares[*k] = x[(i, 0)] / scales[i];
        }
        for (i, row) in order.iter().zip(&pivoted) {
            for (j, value) in order.iter().zip(row) {
                covariance[which[*i]][which[*j]] = value / (scales[*i] * scales[*j]);
            }
        }
        // weights of the estimates, in the given points: L^-T of those in the white ones
        let mut weights = Mat::from_fn(n, 5, |i, k| {
            which.iter().enumerate().map(|(j, m)| a[(i, j)] * scales[j] * covariance[k][*m]).sum::<f64>()
        });
        faer::linalg::triangular_solve::solve_upper_triangular_in_place(
            l.transpose(),
            weights.as_mut(),
            faer::Par::Seq,
        );
        let skewness = std::array::from_fn(|k| {
            // a variance with nu degrees of freedom: relative variance 2/nu, third cumulant 8/nu^2
            let third: f64 = (0..n).map(|i| weights[(i, k)].powi(3) * 2.0 * c[(i, i)].powi(2)).sum();
            third / covariance[k][k].powf(1.5)
        });
        chi_square.is_finite().then_some(Fitted { squares, covariance, skewness, chi_square })
    }
}
