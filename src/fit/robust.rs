//! Estimates that a few bad readings do not carry away: Huber, Tukey and L1.
//!
//! ```text
//! x = argmin sum rho((y - A x) / (s u)),    s from the median of |residuals| where it is not stated
//! ```
//!
//! P. J. Huber, Robust Statistics (1981), 7.6-7.10; A. E. Beaton, J. W. Tukey, Technometrics 16 (1974); the covariance is Huber's
//! `K^2 s^2 (sum psi^2 / (m - n)) / mean(psi')^2 (A' P A)^-1`, for L1 that of J. W. McKean and R. M. Schrader (1987). Priors are not
//! downweighted. Deliberately absent: throwing readings away.
#![allow(
    clippy::indexing_slicing,
    reason = "weights, residuals and leverages are those of an adjustment of this very system, and `System::check` has compared u and group with its rows"
)]

use crate::elements::{Elements, Parts};
use crate::error::Result;
use crate::estimate::{self, Estimate, Group, System, adjust, csc, solver_settings};
use crate::linear::{norm, normalise, project};
use crate::number;
use crate::uncertainty::quantiles::normal_quantile;
use crate::vocabulary::vocabulary;
use clarabel::solver::{DefaultSolver, IPSolver, SupportedConeT};
use faer::Mat;
use faer::linalg::solvers::Solve;

vocabulary! {
    /// Which estimator.
    RobustMethod {
        /// Huber's: square near zero, linear beyond 1.345 standard deviations.
        Huber = "huber",
        /// Tukey's bisquare: nothing beyond 4.685 standard deviations, begun from Huber's.
        Tukey = "tukey",
        /// Least sum of absolute residuals.
        L1 = "l1",
    }
}

/// What the robust estimator did.
#[derive(Debug, Clone, PartialEq)]
pub struct RobustRecord {
    /// Which estimator.
    pub method: RobustMethod,
    /// Weight of each row relative to its plain one, from 0 to 1.
    pub weights: Vec<f64>,
    /// Steps of reweighting.
    pub iterations: usize,
    /// Did the estimate settle?
    pub converged: bool,
}

/// The robust estimate of a system.
pub(super) struct Robust {
    /// Solution, residuals and factorisation with the final weights.
    pub weighted: Estimate,
    /// The plain estimate, whose sensitivities carry the covariance.
    pub plain: Estimate,
    /// Scale of each group (1 where stated), robustly estimated.
    pub scale: Vec<f64>,
    /// Factor of the variance over that of plain least squares with the same scale.
    pub inflation: f64,
    pub record: RobustRecord,
}

const HUBER: f64 = 1.345;
const TUKEY: f64 = 4.685;
/// Median of the absolute value of a standard normal variable.
const MAD: f64 = 0.674_489_750_196_081_7;
const STEPS: usize = 500;
/// Change of the weighted predictions, relative to the scale, that no longer matters.
const SETTLED: f64 = 1e-10;
/// A reading without weight keeps this much of it, so that it still has a row.
const LEAST_WEIGHT: f64 = 1e-12;

/// Estimate robustly; `readings` rows come first, the priors after them keep their weight.
pub(super) fn estimate(
    system: &System,
    readings: usize,
    method: RobustMethod,
    settings: &estimate::Settings,
) -> Result<Robust> {
    let plain = adjust(system, settings)?;
    let m = system.observed.len();
    let groups = plain.group_scale.len();
    let mut weights = vec![1.0; m];
    let mut weighted = plain.clone();
    let mut scale = scales(system, &plain, groups);
    let mut record = RobustRecord { method, weights: Vec::new(), iterations: 0, converged: false };
    // L1 first: it bears the most bad readings, so that the scale is right from the beginning
    let stages: &[RobustMethod] = match method {
        RobustMethod::L1 => &[RobustMethod::L1],
        RobustMethod::Huber => &[RobustMethod::L1, RobustMethod::Huber],
        RobustMethod::Tukey => &[RobustMethod::L1, RobustMethod::Huber, RobustMethod::Tukey],
    };
    for stage in stages {
        if *stage == RobustMethod::L1 {
            let (solution, converged) = least_absolute(system, &plain, readings);
            weighted.residuals = system.residuals(&solution);
            weighted.unknowns.solution = solution;
            record.converged = converged;
            scale = scales(system, &weighted, groups);
            weights = (0..m)
                .map(
                    |i| if i < readings { (1.0 / deviation(system, &weighted, &scale, i).abs()).min(1.0) } else { 1.0 },
                )
                .collect();
            continue;
        }
        record.converged = false;
        for _ in 0..STEPS {
            record.iterations += 1;
            for (i, weight) in weights.iter_mut().enumerate().take(readings) {
                *weight = weight_of(*stage, deviation(system, &weighted, &scale, i)).max(LEAST_WEIGHT);
            }
            let before = weighted.residuals.clone();
            weighted = adjust(&reweighted(system, &weights, &scale), settings)?;
            // the bisquare keeps the scale of Huber's estimate, or it could run away with its own
            if *stage == RobustMethod::Huber {
                scale = scales(system, &weighted, groups);
            }
            let moved = (0..m)
                .map(|i| (before[i] - weighted.residuals[i]).abs() / (scale_of(system, &scale, i) * system.u[i]))
                .fold(0.0_f64, |most, d| if d.is_nan() { most } else { most.max(d) });
            if moved <= SETTLED || scale.contains(&0.0) {
                record.converged = true;
                break;
            }
        }
    }
    let inflation = inflation(system, &weighted, &scale, readings, plain.unknowns.rank, method);
    record.weights = weights;
    Ok(Robust { weighted, plain, scale, inflation, record })
}

/// The system with `u / sqrt(weight)` and the scales as given.
fn reweighted(system: &System, weights: &[f64], scale: &[f64]) -> System {
    let positive = |s: f64| if s > 0.0 { s } else { 1.0 };
    let u = (0..system.u.len())
        .map(|i| system.u[i] * positive(scale_of(system, scale, i)) / weights[i].sqrt())
        .collect::<Vec<f64>>();
    System { u, group: vec![Group::Known; system.u.len()], ..system.clone() }
}

fn scale_of(system: &System, scale: &[f64], i: usize) -> f64 {
    match system.group[i] {
        Group::Known => 1.0,
        Group::Estimated(g) => scale.at(g),
    }
}

/// Residual over its standard deviation.
fn deviation(system: &System, estimate: &Estimate, scale: &[f64], i: usize) -> f64 {
    let s = scale_of(system, scale, i) * system.u[i];
    let v = estimate.residuals[i];
    if s > 0.0 {
        v / s
    } else if v == 0.0 {
        0.0
    } else {
        f64::INFINITY.copysign(v)
    }
}

/// Scale of each group: the median of absolute weighted residuals over that of the normal distribution. As many of the smallest as the
/// group spent on the unknowns are left out, since a robust fit passes through about as many readings.
fn scales(system: &System, estimate: &Estimate, groups: usize) -> Vec<f64> {
    (0..groups)
        .map(|g| {
            let rows: Vec<usize> = (0..system.u.len()).filter(|i| system.group[*i] == Group::Estimated(g)).collect();
            let mut sizes: Vec<f64> = rows.iter().map(|i| (estimate.residuals[*i] / system.u[*i]).abs()).collect();
            sizes.sort_by(f64::total_cmp);
            let spent: f64 = rows.iter().map(|i| estimate.leverage[*i]).sum();
            let kept = sizes.part(number::count(spent.round()).min(sizes.len())..);
            let middle = |k: usize| kept.get(k).copied().unwrap_or(0.0); // none is left: no scale
            let half = kept.len() / 2;
            let median =
                if kept.len() % 2 == 1 { middle(half) } else { 0.5 * (middle(half.saturating_sub(1)) + middle(half)) };
            median / MAD
        })
        .collect()
}

/// `psi(d)/d`.
fn weight_of(method: RobustMethod, deviation: f64) -> f64 {
    if deviation == 0.0 { 1.0 } else { psi(method, deviation).0 / deviation }
}

/// `(psi, psi')`.
fn psi(method: RobustMethod, d: f64) -> (f64, f64) {
    match method {
        RobustMethod::Tukey if d.abs() >= TUKEY => (0.0, 0.0),
        RobustMethod::Tukey => {
            let t = (d / TUKEY).powi(2);
            (d * (1.0 - t).powi(2), (1.0 - t) * (1.0 - 5.0 * t))
        }
        _ if d.abs() <= HUBER => (d, 1.0),
        _ => (HUBER.copysign(d), 0.0),
    }
}

/// Variance over that of least squares with the same scale.
fn inflation(
    system: &System,
    estimate: &Estimate,
    scale: &[f64],
    readings: usize,
    rank: usize,
    method: RobustMethod,
) -> f64 {
    let m = readings as f64;
    let free = (m - rank as f64).max(1.0);
    let deviations: Vec<f64> = (0..readings).map(|i| deviation(system, estimate, scale, i)).collect();
    if method == RobustMethod::L1 {
        return least_absolute_spread(&deviations, rank).powi(2) * m / free;
    }
    let (values, slopes): (Vec<f64>, Vec<f64>) = deviations.into_iter().map(|d| psi(method, d)).unzip();
    let squares: f64 = values.iter().map(|value| value * value).sum();
    let mean = (slopes.iter().sum::<f64>() / m).max(1e-3);
    let spread = slopes.iter().map(|slope| (slope - mean).powi(2)).sum::<f64>() / m;
    let small_sample = 1.0 + rank as f64 / m * spread / (mean * mean);
    small_sample.powi(2) * squares / free / (mean * mean)
}

/// Standard error of a median in units of the scale, times `sqrt m`: the distance of two order statistics (McKean, Schrader).
fn least_absolute_spread(deviations: &[f64], rank: usize) -> f64 {
    let mut sorted: Vec<f64> = deviations.to_vec();
    // the fit passes through `rank` readings
    sorted.sort_by(|a, b| b.abs().total_cmp(&a.abs()));
    sorted.truncate(deviations.len().saturating_sub(rank).max(2));
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    // the quantile exists
    let z = normal_quantile(0.975).unwrap_or(1.96);
    let lower = number::count(((n + 1.0) / 2.0 - z * (n / 4.0).sqrt()).round().max(1.0));
    let at = |k: usize| sorted.get(k.min(sorted.len().saturating_sub(1))).copied().unwrap_or_default(); // no rows: no width
    let width = at(sorted.len().saturating_sub(lower)) - at(lower - 1);
    n.sqrt() * width / (2.0 * z)
}

/// Covariance of the unknowns: the plain cofactor with robust scales, times the inflation.
pub(super) fn covariance(robust: &Robust, system: &System) -> Mat<f64> {
    let sensitivities = robust.plain.factor.sensitivities();
    let (n, m) = (sensitivities.nrows(), sensitivities.ncols());
    let scaled = Mat::from_fn(n, m, |j, i| {
        let s = scale_of(system, &robust.scale, i) * system.u[i];
        sensitivities[(j, i)] * s * robust.inflation.sqrt()
    });
    &scaled * scaled.transpose()
}

/// `argmin sum |y - A x| / u` over the readings, priors as squares; the second says whether the programme was solved.
///
/// In `x = x^ + T v` (whitened about the plain estimate) with `-t <= W (y - A x) <= t`: `min sum t`.
fn least_absolute(system: &System, plain: &Estimate, readings: usize) -> (Vec<f64>, bool) {
    let directions = plain.factor.whitened_directions();
    let moved = &system.rows * &directions;
    let (m, rank) = (system.observed.len(), directions.ncols());
    let weight = |i: usize| 1.0 / system.u[i];
    let unit = {
        let sum: f64 = (0..m).map(|i| (plain.residuals[i] * weight(i)).abs()).sum();
        if sum > 0.0 { sum / m as f64 } else { return (plain.unknowns.solution.clone(), true) }
    };
    // columns: v (in `unit`s), then t of each reading
    let pair = |i: usize, [below, above]: [f64; 2]| [(2 * i, below), (2 * i + 1, above)];
    let of_v = |k: usize| -> Vec<(usize, f64)> {
        let one = |i: usize| weight(i) * moved[(i, k)];
        (0..readings).flat_map(|i| pair(i, [-one(i), one(i)])).collect()
    };
    let of_t = |i: usize| pair(i, [-1.0, -1.0]).to_vec();
    let constraints = csc(2 * readings, (0..rank).map(of_v).chain((0..readings).map(of_t)));
    let bounds: Vec<f64> = (0..readings)
        .flat_map(|i| {
            let v = weight(i) * plain.residuals[i] / unit;
            [-v, v]
        })
        .collect();
    // priors: half their squares, from their own residuals
    let mut quadratic = Mat::<f64>::zeros(rank, rank);
    let mut linear = vec![0.0; rank + readings];
    for i in readings..m {
        for a in 0..rank {
            linear[a] -= weight(i).powi(2) * moved[(i, a)] * plain.residuals[i] / unit;
            for b in 0..rank {
                quadratic[(a, b)] += weight(i).powi(2) * moved[(i, a)] * moved[(i, b)];
            }
        }
    }
    linear.iter_mut().skip(rank).for_each(|c| *c = 1.0);
    let upper = |b: usize| (0..if b < rank { b + 1 } else { 0 }).map(|a| (a, quadratic[(a, b)])).collect::<Vec<_>>();
    let quadratic = csc(rank + readings, (0..rank + readings).map(upper));
    let settings = solver_settings(300);
    let cones = [SupportedConeT::NonnegativeConeT(2 * readings)];
    let Ok(mut solver) = DefaultSolver::new(&quadratic, &linear, &constraints, &bounds, &cones, settings) else {
        return (plain.unknowns.solution.clone(), false);
    };
    solver.solve();
    let v: Vec<f64> = solver.solution.x.iter().take(rank).map(|v| v * unit).collect();
    if v.len() < rank || v.iter().any(|v| !v.is_finite()) {
        return (plain.unknowns.solution.clone(), false);
    }
    let v = if readings == m { vertex(&moved, plain, &weight, &v) } else { v };
    let mut solution = plain.unknowns.solution.clone();
    for (k, v) in v.iter().enumerate() {
        solution.iter_mut().zip(directions.col_as_slice(k)).for_each(|(x, t)| *x += t * v);
    }
    (solution, true)
}

/// The vertex next to `v`: through the readings with the smallest residuals that are independent, if that is no worse.
fn vertex(moved: &Mat<f64>, plain: &Estimate, weight: &dyn Fn(usize) -> f64, v: &[f64]) -> Vec<f64> {
    let rank = v.len();
    let residual =
        |i: usize, v: &[f64]| plain.residuals[i] - v.iter().enumerate().map(|(k, v)| moved[(i, k)] * v).sum::<f64>();
    let total = |v: &[f64]| (0..moved.nrows()).map(|i| (weight(i) * residual(i, v)).abs()).sum::<f64>();
    let mut order: Vec<usize> = (0..moved.nrows()).collect();
    order.sort_by(|a, b| (weight(*a) * residual(*a, v)).abs().total_cmp(&(weight(*b) * residual(*b, v)).abs()));
    let mut span: Vec<Vec<f64>> = Vec::new();
    let mut chosen = Vec::new();
    for i in order {
        let mut rest: Vec<f64> = (0..rank).map(|k| weight(i) * moved[(i, k)]).collect();
        let whole = norm(&rest);
        project(&mut rest, &span);
        if normalise(&mut rest) > 1e-7 * whole {
            span.push(rest);
            chosen.push(i);
        }
        if chosen.len() == rank {
            break;
        }
    }
    if chosen.len() < rank {
        return v.to_vec();
    }
    let a = Mat::from_fn(rank, rank, |i, k| weight(chosen[i]) * moved[(chosen[i], k)]);
    let b = Mat::from_fn(rank, 1, |i, _| weight(chosen[i]) * plain.residuals[chosen[i]]);
    let found = a.full_piv_lu().solve(b);
    let found: Vec<f64> = (0..rank).map(|k| found[(k, 0)]).collect();
    if found.iter().all(|x| x.is_finite()) && total(&found) <= total(v) * (1.0 + 1e-9) { found } else { v.to_vec() }
}
