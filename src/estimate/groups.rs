//! Scales of several groups of readings whose standard uncertainties are known only relative to each other.
//!
//! Helmert's estimator, iterated: `sum_h S_gh theta_h = q_g`, with `q_g = v_g' P_g v_g` and
//! `S_gh = tr(P Q_vv E_g P Q_vv E_h)`, over the groups to estimate, the known ones moved to the right. Where it leaves
//! the region of trust, Foerstner's simplification `theta_g = q_g / r_g` takes the step; both have the same fixed point.
//! K.-R. Koch, Parameter Estimation and Hypothesis Testing in Linear Models (1999), 3.6.

use super::factor::Factor;
use super::refine;
use super::{Group, Settings, System};
use crate::error::Result;
use faer::linalg::matmul::matmul;
use faer::linalg::solvers::Solve;
use faer::{Accum, Mat, Par};

/// Scales of the groups: `None` for a group without redundancy of its own, and how the iteration went.
pub(super) struct Scales {
    pub scale: Vec<Option<f64>>,
    pub iterations: usize,
    pub converged: bool,
}

/// A group with less redundancy than this has none.
pub(super) const NO_REDUNDANCY: f64 = 1e-9;
/// Relative change of every variance at which the iteration ends.
const CONVERGED: f64 = 1e-11;
/// Smallest variance of a group, relative to what it was at first: below, its residuals vanish.
const VANISHED: f64 = 1e-24;

/// Number of groups with an estimated scale: one more than the largest number in use.
pub(super) fn count(group: &[Group]) -> usize {
    let number = |group: &Group| if let Group::Estimated(g) = group { g + 1 } else { 0 };
    group.iter().map(number).max().unwrap_or(0)
}

/// Iterates the scales of `count` groups.
pub(super) fn estimate(system: &System, count: usize, settings: &Settings) -> Result<Scales> {
    let mut variance = vec![1.0; count];
    let mut undetermined = vec![false; count];
    let (mut iterations, mut converged) = (0, false);
    while iterations < settings.group_iterations && !converged {
        iterations += 1;
        let scale: Vec<f64> = variance.iter().map(|v: &f64| v.sqrt()).collect();
        let factor = Factor::new(system.rows.as_ref(), weights(system, &scale), 0, settings.rank_tolerance)?;
        let theta = factors(system, &factor, count);
        converged = true;
        for ((theta, variance), undetermined) in theta.iter().zip(&mut variance).zip(&mut undetermined) {
            *undetermined = theta.is_none();
            let Some(theta) = theta else { continue };
            let next = *variance * theta;
            if next < VANISHED {
                continue;
            }
            *variance = next;
            converged &= (theta - 1.0).abs() <= CONVERGED;
        }
    }
    let scale = variance.iter().zip(&undetermined).map(|(v, undetermined)| (!undetermined).then(|| v.sqrt())).collect();
    Ok(Scales { scale, iterations, converged })
}

/// `1 / (s_g u)` for every row.
pub(super) fn weights(system: &System, scale: &[f64]) -> Vec<f64> {
    let scale_of = |group: &Group| match group {
        Group::Known => 1.0,
        Group::Estimated(g) => scale.get(*g).copied().unwrap_or(1.0),
    };
    system.u.iter().zip(&system.group).map(|(u, group)| 1.0 / (u * scale_of(group))).collect()
}

/// By which factor each group's variance should change; `None` where the group has no redundancy.
fn factors(system: &System, factor: &Factor, count: usize) -> Vec<Option<f64>> {
    let fit = refine::solve(factor, system.rows.as_ref(), &system.observed, 1);
    let leverage = factor.leverages();
    // Index `count` holds the rows of known uncertainty.
    let index = |group: &Group| if let Group::Estimated(g) = group { *g } else { count };
    let (mut size, mut trace) = (vec![0.0; count + 1], vec![0.0; count + 1]);
    let mut squares = vec![0.0; count + 1];
    for (i, group) in system.group.iter().enumerate() {
        let g = index(group);
        size[g] += 1.0;
        trace[g] += leverage[i];
        squares[g] += (fit.residuals[i] * factor.weight[i]).powi(2);
    }
    let redundancy: Vec<f64> = size.iter().zip(&trace).map(|(n, h)| n - h).collect();
    let simple: Vec<Option<f64>> =
        (0..count).map(|g| (redundancy[g] > NO_REDUNDANCY).then(|| squares[g] / redundancy[g])).collect();
    helmert(system, factor, &simple, &size, &trace, &squares).unwrap_or(simple)
}

/// The full step, if every factor stays within a factor of ten of one.
fn helmert(
    system: &System,
    factor: &Factor,
    simple: &[Option<f64>],
    size: &[f64],
    trace: &[f64],
    squares: &[f64],
) -> Option<Vec<Option<f64>>> {
    let count = simple.len();
    let determined: Vec<usize> = (0..count).filter(|&g| simple[g].is_some()).collect();
    let gram: Vec<Mat<f64>> = (0..=count).map(|g| gram(system, factor, g, count)).collect();
    let product = |g: usize, h: usize| -> f64 {
        let pairs = (0..factor.rank()).flat_map(|k| gram[g].col_as_slice(k).iter().zip(gram[h].col_as_slice(k)));
        pairs.map(|(a, b)| a * b).sum()
    };
    let own = |g: usize| size[g] - 2.0 * trace[g];
    let fixed = |g: usize| (0..=count).filter(|h| !determined.contains(h)).map(|h| product(g, h)).sum::<f64>();
    let s = Mat::from_fn(determined.len(), determined.len(), |a, b| {
        let (g, h) = (determined[a], determined[b]);
        product(g, h) + if a == b { own(g) } else { 0.0 }
    });
    let q = Mat::from_fn(determined.len(), 1, |a, _| squares[determined[a]] - fixed(determined[a]));
    let theta = s.col_piv_qr().solve(&q);
    let mut factors = vec![None; count];
    for (a, &g) in determined.iter().enumerate() {
        let value = theta[(a, 0)];
        if !(0.1..=10.0).contains(&value) {
            return None;
        }
        factors[g] = Some(value);
    }
    Some(factors)
}

/// `Q_g' Q_g` over the rows of one group (`count` for those of known uncertainty).
fn gram(system: &System, factor: &Factor, g: usize, count: usize) -> Mat<f64> {
    let member = |group: &Group| if let Group::Estimated(h) = group { *h == g } else { g == count };
    let rows: Vec<usize> = (0..system.group.len()).filter(|&i| member(&system.group[i])).collect();
    let q = &factor.q;
    let own = Mat::from_fn(rows.len(), factor.rank(), |i, k| q[(rows[i], k)]);
    let mut gram = Mat::zeros(factor.rank(), factor.rank());
    matmul(&mut gram, Accum::Replace, own.transpose(), &own, 1.0, Par::Seq);
    gram
}
