//! The coefficients of IEEE Std 952 from Allan variances: one likelihood of their sum, with the covariance of correlated points that follows from it.
#![allow(
    clippy::indexing_slicing,
    reason = "five terms, indexed by loops over five; grams, columns and variances have one entry for each point"
)]

use super::Sums;
use super::cells::Cells;
use super::covariance::{Gram, covariance, gram};
use super::ladder::MISSING;
use crate::bench::STANDARD_GRAVITY_M_S2 as STANDARD_GRAVITY;
use crate::linear::{Triangle, dot, norm, normalise, project};
use crate::uncertainty::quantiles::{chi_square_survival, falls, normal_survival};
use crate::units::Unit;
use crate::vocabulary::vocabulary;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
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
    /// Squares of the likeliest set, with those of terms that another could stand for, and that are therefore not reported.
    pub squares: [f64; 5],
    /// How well they describe the deviations.
    pub agreement: Agreement,
}

/// A difference of neighbouring means that is no noise: the sensor moved, or its output jumped.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "ChangeReport")]
#[non_exhaustive]
pub struct Change {
    /// When, in s from the record's beginning.
    pub time_s: f64,
    /// The length of each of the two means, s.
    pub tau_s: f64,
    /// The second mean less the first, in the column's unit.
    pub by: f64,
    /// The same in standard deviations of the difference, `sqrt(2)` Allan deviations of the fitted coefficients.
    pub in_sd: f64,
}

/// Agreement of the fitted coefficients with the Allan variances.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "AgreementReport")]
pub struct Agreement {
    /// Generalized sum of squares.
    pub chi_square: f64,
    /// Degrees of freedom.
    pub dof: usize,
    /// Probability of more.
    pub p: f64,
    /// Do they describe them (a probability of at least 1 %)?
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub describes: Option<bool>,
    /// The first averaging time that they describe, s, where shorter ones are left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from_tau_s: Option<f64>,
    /// The sampling interval, s, where a rate random walk was taken as sampled at the ends of the intervals rather than averaged over each:
    /// its Allan variance is then larger by `K^2 dt^2 / (6 tau)`. Which of the two a logger does is not known; the one that needs less to be
    /// described was taken.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub walk_sampled_s: Option<f64>,
    /// The largest change, where noise of these coefficients makes one as large in fewer than 1 of 10,000 records.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub change: Option<Change>,
}

impl Agreement {
    /// Do the coefficients describe the Allan variances?
    pub(crate) fn is_good(&self) -> bool {
        self.describes != Some(false)
    }
}

impl Coefficients {
    /// The fitted Allan variance at `tau`.
    pub(crate) fn variance(&self, tau: f64) -> f64 {
        let steps = self.agreement.walk_sampled_s.map_or(0.0, |interval| sampled_walk(interval, tau));
        let more = |term: Term| if term == Term::RateRandomWalk { steps } else { 0.0 };
        Term::ALL.iter().zip(self.squares).map(|(term, square)| square * (term.variance(tau) + more(*term))).sum()
    }

    /// Power of the frequency of what dominates at `tau`.
    pub(super) fn alpha(&self, tau: f64) -> i32 {
        let size = |term: Term| self.squares[term as usize] * term.variance(tau);
        Term::ALL.into_iter().max_by(|a, b| size(*a).total_cmp(&size(*b))).map_or(0, Term::alpha)
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

/// How seldom chance makes one of the five terms, all together.
const FAMILY: f64 = 0.01;
/// What one more term must take off `-2 ln L`: the square of the normal quantile at a fifth of that.
const TERM: f64 = 8.2838;
/// What one more term must take off `-2 ln L` to be as likely as not beside those of the set: the square of the normal quantile at `FAMILY`.
const ALIKE: f64 = 5.4119;
/// Octaves that are left out beyond those where the test sees that a filter bends the deviations: what it just does not see halves with each.
const MORE: usize = 1;
const ROUNDS: usize = 30;
/// Squares that change by less than this share of theirs have settled.
const SETTLED: f64 = 1e-6;
/// Share of the variance of the other terms that a filter takes at the first averaging time which is kept, at most: what a mean over `L` takes of white noise at its own
/// length, `s^2 = N^2/tau (1 - L/2 tau)` for `tau >= L`. A low-pass filter of first order, `1 - (T/2 tau)(3 - 4 e^(-tau/T) + e^(-2 tau/T))`, takes 0.47 at three time
/// constants.
const FILTERED: f64 = 0.5;
/// How exactly [`falls`] finds a value: u is said to two digits; and what lies outside of an interval, or above a limit: intervals are of 95 %.
const FALLS: f64 = 0.01;
const OUTSIDE: f64 = 0.05;
/// Logarithms of the least and largest variance of `e` that no sum of the terms describes: a part in a thousand of a deviation, and a factor of 10^5.
const APART: (f64, f64) = (-14.0, 7.0);
/// Of the distributions that the model's neighbours give, those less likely than this do not count.
const LIKELY: f64 = 1e-3;

/// What the fit works on; the unit of time is a sample.
#[derive(Clone)]
struct Points {
    /// Averaging times.
    m: Vec<f64>,
    /// Allan variances about the record's slope.
    variances: Vec<f64>,
    /// The record's slope.
    slope: f64,
    /// Covariances of the slope (first) and of the mean differences at each averaging time, for squares of Q, N, B, K of one.
    means: Vec<Vec<[f64; 4]>>,
    /// The Allan variances for such squares, less what the slope took.
    columns: [Vec<f64>; 4],
    /// The white noise that each averaging time has of a square of Q of one, where runs of missing samples leave ends of sums.
    ends: Vec<f64>,
    /// Row i has the points up to i.
    grams: Vec<Vec<Gram>>,
    /// Is the part that falls as quantization does free in its sign? What a filter takes of white noise falls so.
    is_filtered: bool,
    /// Variance of each `e` beside that of the sum of terms.
    apart: f64,
}

/// At some squares: residuals and columns, white, and `-2 ln L`.
struct White {
    residuals: Vec<f64>,
    columns: [Vec<f64>; 4],
    cost: f64,
}

/// A set of terms, the squares of Q, N, B, K, and how likely they are.
#[derive(Debug, Clone)]
struct Fitted {
    active: [bool; 5],
    /// Is a random walk sampled?
    sampled: bool,
    squares: [f64; 4],
    ramp: f64,
    chi_square: f64,
    cost: f64,
}

impl Fitted {
    fn count(&self) -> usize {
        self.active.iter().filter(|a| **a).count()
    }

    /// Has it all terms that the other one has?
    fn contains(&self, other: &Fitted) -> bool {
        (0..5).all(|k| self.active[k] || !other.active[k])
    }

    /// `-2 ln L`, each term counted as so much.
    fn penalized(&self, term: f64) -> f64 {
        self.cost + term * self.count() as f64
    }

    /// A coefficient; one that a filter makes negative is none.
    fn value(&self, k: usize) -> f64 {
        self.squares.get(k).map_or(self.ramp, |square| square.max(0.0).sqrt())
    }

    fn noises(&self) -> Vec<usize> {
        (0..4).filter(|k| self.active[*k]).collect()
    }

    /// Squares as white noise and a walk that is averaged.
    fn averaged(&self, squares: &[f64; 4]) -> [f64; 4] {
        let [q, n, b, k] = *squares;
        [q, n + if self.sampled { k / 6.0 } else { 0.0 }, b, k]
    }
}

/// Least squares in white columns: the solution, and its covariance; `None` where columns are dependent.
fn least_squares(columns: &[&Vec<f64>], y: &[f64]) -> Option<(Vec<f64>, Vec<Vec<f64>>)> {
    let (mut basis, mut upper): (Vec<Vec<f64>>, Vec<Vec<f64>>) = Default::default();
    for column in columns {
        let mut own = (*column).clone();
        project(&mut own, &basis);
        project(&mut own, &basis);
        let mut row: Vec<f64> = basis.iter().map(|b| dot(b, column)).collect();
        let left = normalise(&mut own);
        if !(left > 1e-9 * norm(column)) {
            return None;
        }
        row.push(left);
        basis.push(own);
        upper.push(row);
    }
    let triangle = Triangle::of_upper(columns.len(), |i, j| upper[j][i]);
    let mut x: Vec<f64> = basis.iter().map(|b| dot(b, y)).collect();
    triangle.backward(&mut x);
    Some((x, triangle.inverse()))
}

/// The coefficients from sums of squared differences at octaves of averaging times.
///
/// The data are the record's slope, and the Allan variances `v` about it. Those have the expectation `m` of the sum of terms and a relative covariance `C` that
/// follows from the same sum. Their cube roots are near to normal however few the degrees of freedom (Wilson and Hilferty):
/// `e = 3 ((v/m)^(1/3) - 1 + C_ii/9)` has covariance `C`. The slope is normal with the variance that the sum of terms gives, about zero or about a ramp. For
/// each set of terms the squares solve the weighted least squares of `e`, renewed until they hold; the set is the likeliest, each term
/// taken for as much as chance gives in one record of a hundred. u is such that 1.96 u covers 95 %, over that set and those with more terms, as
/// likely as they are. `None` for fewer than five averaging times, or where nothing varies.
///
/// Where no sum of the terms describes all averaging times by far, a filter or a logger that holds its samples bends the shortest. Beyond its own length it takes from the
/// Allan variance of white noise what falls as `1/tau^2`: the term of quantization is then free in its sign, and none of the answer. The shortest averaging
/// times are left out until such a sum describes the others. Where none does, or chance may be the cause, each `e` has a further variance of its own, as large as
/// brings chi-square down to its degrees of freedom (J. Mandel, R. C. Paule, Anal. Chem. 42 (1970), 1194): what the terms leave open is in u, p and the limits.
pub(super) fn coefficients(sums: &[Sums], cells: &Cells, interval: f64) -> Option<Coefficients> {
    let all = Described::new(Points::new(sums, cells)?, interval)?;
    if all.agreement.is_good() {
        return Some(all.coefficients());
    }
    let from = |k: usize| {
        let own = sums.get(k..)?;
        let points = Points { is_filtered: true, ..Points::new(own, cells)? };
        let mut found = Described::new(points, interval)?;
        found.agreement.from_tau_s = Some(own.first()?.m as f64 * interval);
        Some(found).filter(|found| found.agreement.is_good())
    };
    let bent = all.agreement.p < super::BY_CHANCE;
    if let Some(k) = (1..sums.len()).filter(|_| bent).find(|k| from(*k).is_some()) {
        return (k..=k + MORE).rev().find_map(from).map(|found| found.coefficients());
    }
    let dof = all.agreement.dof as f64;
    let apart = |own: f64| Described::new(Points { apart: own.exp(), ..all.points.clone() }, interval);
    let (mut low, mut high) = APART;
    while high - low > 0.1 {
        let middle = 0.5 * (low + high);
        if apart(middle)?.agreement.chi_square > dof { low = middle } else { high = middle }
    }
    let mut found = apart(high)?;
    let Agreement { chi_square, dof, p, describes, .. } = all.agreement;
    found.agreement = Agreement { chi_square, dof, p, describes, ..found.agreement };
    Some(found.coefficients())
}

/// Points with the sets of terms that could be theirs.
struct Described {
    points: Points,
    /// The sampling interval, s.
    interval: f64,
    fits: Vec<Fitted>,
    best: Fitted,
    agreement: Agreement,
}

impl Described {
    fn new(points: Points, interval: f64) -> Option<Self> {
        let set = |set: usize| -> [bool; 5] { std::array::from_fn(|k| set >> k & 1 == 1) };
        // whether a logger takes values or means of a random walk is not known
        let tried = (1..32).flat_map(|number| [(set(number), false), (set(number), true)]);
        let fits: Vec<Fitted> = tried
            .filter(|(active, sampled)| active[..4].contains(&true) && (active[3] || !sampled))
            .filter(|(active, _)| !points.is_filtered || (active[0] && active[1..4].contains(&true)))
            .filter_map(|(active, sampled)| points.fit(active, sampled).filter(|fit| points.is_beyond_filter(fit)))
            .collect();
        let best = fits.iter().min_by(|a, b| a.penalized(TERM).total_cmp(&b.penalized(TERM)))?.clone();
        let dof = (points.m.len() + 1).saturating_sub(best.count());
        // so large a chi-square with a probability below 1 % describes nothing; one that is not finite has none
        let p = chi_square_survival(best.chi_square, dof.max(1) as f64).unwrap_or(0.0);
        let describes = Some(!(p < 0.01));
        let walk_sampled_s = (best.sampled && best.active[3]).then_some(interval);
        let agreement = Agreement {
            chi_square: best.chi_square,
            dof,
            p,
            describes,
            from_tau_s: None,
            walk_sampled_s,
            change: None,
        };
        Some(Described { points, interval, fits, best, agreement })
    }

    /// The probability of a term by chance: beside sets within its own by the likelihood's drop, as a normal variable's square; beside others of no
    /// more terms by Markov's inequality, that a likelihood ratio exceeds 1/p with p at most. And that normal variable.
    fn chance(&self, k: usize) -> (f64, f64) {
        let mut with = self.best.active;
        with[k] = true;
        let own = self.fits.iter().filter(|fit| fit.active == with);
        let Some(with) = own.min_by(|a, b| a.cost.total_cmp(&b.cost)) else { return (1.0, 0.0) };
        let others = self.fits.iter().filter(|fit| !fit.active[k] && fit.count() <= with.count());
        others.fold((0.0, f64::INFINITY), |(p, z), fit| {
            let gain = (fit.cost - with.cost).max(0.0);
            if with.contains(fit) {
                // not finite: as far as can be
                (normal_survival(gain.sqrt()).unwrap_or(0.0).max(p), gain.sqrt().min(z))
            } else {
                (((-0.5 * gain).exp() / 5.0).max(p), z)
            }
        })
    }

    fn coefficients(&self) -> Coefficients {
        let (best, interval) = (&self.best, self.interval);
        let units = [interval, interval.sqrt(), 1.0, interval.sqrt().recip(), interval.recip()];
        let terms = std::array::from_fn(|k| {
            let (term, unit) = (Term::ALL[k], units[k]);
            if k == 0 && self.points.is_filtered {
                return Coefficient { term, value: None, u: None, p: 1.0, below: None };
            }
            let (p, z) = self.chance(k);
            let beyond = Beyond::new(self, k, best.active[k] && p < FAMILY / 5.0, z);
            if !beyond.is_found {
                return Coefficient { term, value: None, u: None, p, below: beyond.limit().map(|limit| limit * unit) };
            }
            let value = best.value(k);
            let u = beyond.half_interval(value).map(|half| half * unit / 1.96);
            Coefficient { term, value: Some(value * unit), u, p, below: None }
        });
        let square = |k: usize| if best.active[k] { (best.value(k) * units[k]).powi(2) } else { 0.0 };
        Coefficients { terms, squares: std::array::from_fn(square), agreement: self.agreement.clone() }
    }
}

impl Points {
    fn new(sums: &[Sums], cells: &Cells) -> Option<Self> {
        if sums.len() < Term::ALL.len() {
            return None;
        }
        let n = sums.len();
        let grams: Vec<Vec<Gram>> =
            (0..n).map(|i| (0..=i).map(|j| gram(&sums[j], &sums[i], sums, cells)).collect()).collect();
        let m: Vec<f64> = sums.iter().map(|s| s.m as f64).collect();
        let (slope, _, _) = cells.slope();
        let about = |s: &Sums, m: f64| {
            let ramp = slope * m * m;
            (s.allan.0 - 2.0 * ramp * s.signed + ramp * ramp * s.missing[4]) / (2.0 * m * m * s.allan.1 as f64)
        };
        let variances: Vec<f64> = sums.iter().zip(&m).map(|(s, m)| about(s, *m)).collect();
        if variances.iter().any(|v| !(*v > 0.0) || !v.is_finite()) {
            return None;
        }
        let means = cells.means(&m, MISSING);
        let ends = sums.iter().zip(&m).map(|(s, m)| 3.0 * (s.missing_factors()[0] - 1.0).max(0.0) / m).collect();
        let mut points = Points {
            m,
            variances,
            slope,
            means,
            columns: Default::default(),
            ends,
            grams,
            is_filtered: false,
            apart: 0.0,
        };
        points.columns = std::array::from_fn(|k| {
            let own = |(i, s): (usize, &Sums)| {
                let mut one = [0.0; 4];
                one[k] = 1.0;
                let taken = points.taken(i, i, &one) / (2.0 * points.m[i].powi(2));
                s.missing_factors()[k] * Term::ALL[k].variance(points.m[i]) - taken
            };
            sums.iter().enumerate().map(own).collect()
        });
        Some(points)
    }

    /// What the slope takes of the covariance of differences at two averaging times.
    fn taken(&self, i: usize, j: usize, squares: &[f64; 4]) -> f64 {
        let (a, b) = (self.m[i].powi(2), self.m[j].powi(2));
        let part = |k: usize| {
            let [of_slope, first, second] = [0, i + 1, j + 1].map(|place| self.means[0][place][k]);
            a * second + b * first - a * b * of_slope
        };
        // cells are too long for short averaging times, of which the slope takes next to nothing
        let seen = [i, j].iter().all(|i| self.means[0][i + 1] != [0.0; 4]);
        if seen { (0..4).map(|k| squares[k] * part(k)).sum() } else { 0.0 }
    }

    /// Residuals and columns at these squares.
    fn white(&self, squares: &[f64; 4], fit: &Fitted) -> Option<White> {
        let n = self.m.len();
        let mut own = fit.averaged(squares);
        own[0] = own[0].max(0.0);
        let column = |k: usize, i: usize| {
            let steps = if k == 3 && fit.sampled { self.columns[1][i] / 6.0 } else { 0.0 };
            self.columns[k][i] + steps
        };
        let fitted: Vec<f64> = (0..n).map(|i| (0..4).map(|k| column(k, i) * squares[k]).sum::<f64>()).collect();
        let relative = |i: usize, j: usize| {
            let gram = &self.grams[i][j];
            let means: f64 = self.means[i + 1][j + 1].iter().zip(own).map(|(c, s)| c * s).sum();
            let taken = self.taken(i, j, &own);
            let [q, n, b, k] = own;
            let own = [q, n + q * (self.ends[i] * self.ends[j]).sqrt(), b, k];
            let less = taken * (taken - 2.0 * means) / (2.0 * (self.m[i] * self.m[j]).powi(2));
            (covariance(gram, own) + less) / (fitted[i] * fitted[j])
        };
        let relative: Vec<Vec<f64>> = (0..n).map(|i| (0..=i).map(|j| relative(i, j)).collect()).collect();
        // pairs of differences across gaps are counted nearly: a smaller correlation keeps the matrix definite
        let mut shrink = 1.0;
        let triangle = loop {
            let entry = |i: usize, j: usize| if i == j { relative[i][j] + self.apart } else { shrink * relative[i][j] };
            match Triangle::of(n, entry, |i| 1e-6 * relative[i][i]) {
                Some(triangle) => break triangle,
                None if shrink > 0.5 => shrink *= 0.98,
                None => return None,
            }
        };
        let mut residuals: Vec<f64> =
            (0..n).map(|i| 3.0 * ((self.variances[i] / fitted[i]).cbrt() - 1.0) + relative[i][i] / 3.0).collect();
        triangle.forward(&mut residuals);
        let mut columns: [Vec<f64>; 4] = std::array::from_fn(|k| {
            let mut own: Vec<f64> = (0..n).map(|i| column(k, i) / fitted[i]).collect();
            triangle.forward(&mut own);
            own
        });
        // the slope tells of the noise where there is no ramp
        let slope = self.means[0][0];
        let of_slope = |k: usize| slope[k] + if k == 3 && fit.sampled { slope[1] / 6.0 } else { 0.0 };
        let variance: f64 = (0..4).map(|k| of_slope(k) * squares[k]).sum();
        let square = (self.slope.abs() - fit.ramp).powi(2) / variance;
        let scale: f64 = fitted.iter().map(|m| m.ln()).sum();
        let misfit = dot(&residuals, &residuals);
        let cost = misfit + triangle.log_determinant() + 2.0 / 3.0 * scale + square + variance.ln();
        if square > 0.0 {
            residuals.push((square - 1.0) / 2f64.sqrt());
            (0..4).for_each(|k| columns[k].push(of_slope(k) / variance / 2f64.sqrt()));
        }
        cost.is_finite().then_some(White { residuals, columns, cost })
    }

    /// The largest square of a term that touches the variances from below: a first guess.
    fn touch(&self, k: usize) -> f64 {
        let above = |(m, v): (&f64, &f64)| v / Term::ALL[k].variance(*m);
        self.m.iter().zip(&self.variances).map(above).fold(f64::INFINITY, f64::min)
    }

    /// The squares for a set of terms; `None` where it is no better than a smaller one.
    fn fit(&self, active: [bool; 5], sampled: bool) -> Option<Fitted> {
        let squares = std::array::from_fn(|k| if active[k] && !self.is_free(k) { self.touch(k) } else { 0.0 });
        let ramp = if active[4] { self.slope.abs() } else { 0.0 };
        let fit = self.settled(Fitted { active, sampled, squares, ramp, chi_square: 0.0, cost: 0.0 }, None, SETTLED)?;
        let share = |k: usize| {
            let own = (0..self.m.len()).map(|i| self.columns[k][i] * fit.squares[k] / self.variances[i]);
            own.fold(0.0, f64::max)
        };
        let is_felt = |k: usize| self.is_free(k) || share(k) > 1e-9;
        fit.noises().into_iter().all(is_felt).then_some(fit)
    }

    /// The same with one coefficient (not squared) held, from a solution nearby; as exact as [`falls`] is.
    fn held(&self, near: &Fitted, (k, value): (usize, f64)) -> Option<Fitted> {
        let mut fit = near.clone();
        match fit.squares.get_mut(k) {
            Some(square) => *square = value * value,
            None => fit.ramp = value,
        }
        self.settled(fit, Some(k), 1e-2 * FALLS)
    }

    /// Is the first averaging time beyond the length of the filter?
    fn is_beyond_filter(&self, fit: &Fitted) -> bool {
        let part = |k: usize| self.columns[k].first().map_or(0.0, |column| column * fit.squares[k]);
        -part(0) <= FILTERED * (1..4).map(part).sum::<f64>()
    }

    /// Is this the term that a filter leaves free in its sign?
    fn is_free(&self, k: usize) -> bool {
        self.is_filtered && k == 0
    }

    /// The squares from a start, all but one that is held, until they change by less than a share of theirs.
    fn settled(&self, mut fit: Fitted, held: Option<usize>, settled: f64) -> Option<Fitted> {
        let is_free = |k: usize| self.is_free(k);
        let is_held = |k: usize| held == Some(k);
        let mut white = self.white(&fit.squares, &fit)?;
        let free: Vec<usize> = fit.noises().into_iter().filter(|k| !is_held(*k)).collect();
        for round in 0..if free.is_empty() { 0 } else { ROUNDS } {
            let before = fit.squares;
            let y: Vec<f64> = (0..white.residuals.len())
                .map(|i| white.residuals[i] + free.iter().map(|k| white.columns[*k][i] * before[*k]).sum::<f64>())
                .collect();
            let mut which = free.clone();
            let next: [f64; 4] = loop {
                let columns: Vec<&Vec<f64>> = which.iter().map(|k| &white.columns[*k]).collect();
                let (x, covariance) = least_squares(&columns, &y)?;
                let z = |i: usize| x[i] / covariance[i][i].sqrt();
                match (0..x.len()).filter(|i| x[*i] < 0.0 && !is_free(which[*i])).min_by(|a, b| z(*a).total_cmp(&z(*b)))
                {
                    Some(i) if which.len() > 1 => drop(which.remove(i)),
                    _ => {
                        break std::array::from_fn(|k| {
                            which
                                .iter()
                                .position(|w| *w == k)
                                .map_or(0.0, |i| if is_free(k) { x[i] } else { x[i].max(0.0) })
                        });
                    }
                }
            };
            // later rounds halve the step: sets that come and go settle
            let step = if round < ROUNDS / 3 { 1.0 } else { 0.5 };
            free.iter().for_each(|k| fit.squares[*k] = before[*k] + step * (next[*k] - before[*k]));
            white = self.white(&fit.squares, &fit)?;
            if (0..4).all(|k| (fit.squares[k] - before[k]).abs() <= settled * fit.squares[k].abs().max(before[k].abs()))
            {
                break;
            }
        }
        (fit.chi_square, fit.cost) = (dot(&white.residuals, &white.residuals), white.cost);
        Some(fit)
    }
}

/// How probable it is that a coefficient lies beyond a value, over the sets that have it.
///
/// In one set the likelihood's drop at a value is the square of a normal variable `a`: how many standard deviations the value is away. A coefficient that is found is seen only where the root `z`
/// of the drop without it is above the test's threshold, one that is not found only where it is below: the normal variable is cut there. Without this, one that is just found has too small a
/// `u`, and one that is just missed too low a limit. Each set counts by its likelihood, and a term as [`ALIKE`]: what dropped terms could be is in the interval, and whether a logger takes means or values.
struct Beyond<'a> {
    points: &'a Points,
    k: usize,
    /// Sets with their weights.
    sets: Vec<(f64, Fitted)>,
    /// `z` above its threshold.
    margin: f64,
    is_found: bool,
}

impl<'a> Beyond<'a> {
    fn new(of: &'a Described, k: usize, is_found: bool, z: f64) -> Self {
        let has = |fit: &Fitted| of.fits.iter().any(|own| own.active == fit.active && own.sampled == fit.sampled);
        let with = |fit: &Fitted| {
            let mut with = fit.clone();
            with.active[k] = true;
            // a set that is no better with the term has it at zero
            (fit.active[k] || !has(&with)).then_some(with)
        };
        let all: Vec<Fitted> = of.fits.iter().filter_map(with).collect();
        let best = all.iter().map(|fit| fit.penalized(ALIKE)).fold(f64::INFINITY, f64::min);
        let weighed = all.into_iter().map(|fit| ((0.5 * (best - fit.penalized(ALIKE))).exp(), fit));
        let sets: Vec<(f64, Fitted)> = weighed.filter(|(weight, _)| *weight > LIKELY).collect();
        // one that another could stand for has passed this test, and nothing is cut
        let margin = if !is_found && z > TERM.sqrt() { f64::NEG_INFINITY } else { z - TERM.sqrt() };
        Beyond { points: &of.points, k, sets, margin, is_found }
    }

    /// Probability that the coefficient is larger (`up`) or smaller than `value`.
    fn probability(&self, value: f64, up: bool) -> Option<f64> {
        let cdf = |z: f64| normal_survival(-z);
        let one = |fit: &Fitted| {
            let held = self.points.held(fit, (self.k, value))?;
            let away = (held.cost - fit.cost).max(0.0).sqrt();
            let a = if (value > fit.value(self.k)) == up { away } else { -away };
            let d = self.margin;
            let (part, of) = match (self.is_found, up) {
                (true, true) => (cdf(-a)? - cdf(-d - a)?, cdf(d + a)?),
                (true, false) => (cdf(-a)?, cdf(d - a)?),
                (false, _) => (cdf(-a)?, cdf(-d - a)?),
            };
            Some(if of > 0.0 { part / of } else { 0.0 })
        };
        let all: f64 = self.sets.iter().map(|(weight, _)| weight).sum();
        self.sets.iter().map(|(weight, fit)| Some(weight / all * one(fit)?)).sum()
    }

    /// Half of the interval about `value` that leaves 5 % outside.
    fn half_interval(&self, value: f64) -> Option<f64> {
        let outside = |half: f64| {
            let down = if half < value { self.probability(value - half, false)? } else { 0.0 };
            Some(self.probability(value + half, true)? + down)
        };
        falls(outside, OUTSIDE, 1e-3 * value, FALLS)
    }

    /// The value that it exceeds with a probability of 5 %.
    fn limit(&self) -> Option<f64> {
        let most = self.sets.iter().map(|(_, fit)| fit.value(self.k)).fold(0.0, f64::max);
        let guess = 1e-3 * most.max(self.points.touch(self.k).sqrt());
        falls(|value| self.probability(value, true), OUTSIDE, guess, FALLS)
    }
}

// The field's units of the coefficients: deg/sqrt(h), deg/h, ug.

/// A unit of a coefficient, and what a value in the record's unit and seconds is multiplied by.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldUnit {
    /// As a person writes it.
    pub symbol: String,
    /// The factor.
    pub factor: f64,
}

/// A unit in another of its dimension.
fn size(unit: &str, one: &str) -> Option<f64> {
    Some(Unit::parse(unit).ok()?.conversion(&Unit::parse(one).ok()?)?.factor())
}

/// Degrees per second in a unit of rate.
fn rate(unit: &str) -> Option<f64> {
    size(unit, "deg/s")
}

/// m/s^2 in a unit of specific force.
fn force(unit: &str) -> Option<f64> {
    size(unit, "m/s^2")
}

/// The unit in which the field states a coefficient, for a record in `unit`.
pub fn field_unit(term: Term, unit: &str) -> FieldUnit {
    let (symbol, factor) = match (rate(unit), force(unit), term) {
        (Some(r), _, Term::Quantization) => ("arcsec".into(), 3600.0 * r),
        (Some(r), _, Term::RandomWalk) => ("deg/sqrt(h)".into(), 60.0 * r),
        (Some(r), _, Term::BiasInstability) => ("deg/h".into(), 3600.0 * r),
        (Some(r), _, Term::RateRandomWalk) => ("deg/h/sqrt(h)".into(), 216000.0 * r),
        (Some(r), _, Term::Ramp) => ("deg/h/h".into(), 3600.0 * 3600.0 * r),
        (_, Some(f), Term::Quantization) => ("m/s".into(), f),
        (_, Some(f), Term::RandomWalk) => ("ug/sqrt(Hz)".into(), 1e6 * f / STANDARD_GRAVITY),
        (_, Some(f), Term::BiasInstability) => ("ug".into(), 1e6 * f / STANDARD_GRAVITY),
        (_, Some(f), Term::RateRandomWalk) => ("ug/sqrt(h)".into(), 60e6 * f / STANDARD_GRAVITY),
        (_, Some(f), Term::Ramp) => ("ug/h".into(), 3600e6 * f / STANDARD_GRAVITY),
        (_, _, Term::Quantization) => (format!("{unit} s"), 1.0),
        (_, _, Term::RandomWalk) => (format!("{unit}/sqrt(Hz)"), 1.0),
        (_, _, Term::BiasInstability) => (unit.to_string(), 1.0),
        (_, _, Term::RateRandomWalk) => (format!("{unit}/sqrt(s)"), 1.0),
        (_, _, Term::Ramp) => (format!("{unit}/s"), 1.0),
    };
    FieldUnit { symbol, factor }
}

/// A unit of rate (`true`) in rad/s, or of specific force in m/s^2, as a factor; `None` for others.
pub(crate) fn si_factor(unit: &str) -> Option<(bool, f64)> {
    rate(unit).map(|r| (true, r * std::f64::consts::PI / 180.0)).or_else(|| force(unit).map(|f| (false, f)))
}
