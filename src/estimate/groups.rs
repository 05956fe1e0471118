//! Scales of several groups of readings whose standard uncertainties are known only relative to each other.
//!
//! Helmert's estimator, iterated: `sum_h S_gh theta_h = q_g`, with `q_g = v_g' P_g v_g` and
//! `S_gh = tr(P Q_vv E_g P Q_vv E_h)`, over the groups to estimate, the known ones moved to the right. Where it leaves
//! the region of trust, Foerstner's simplification `theta_g = q_g / r_g` takes the step; near the end Newton's does. All have the same
//! fixed point, the maximum of the restricted likelihood.
//! K.-R. Koch, Parameter Estimation and Hypothesis Testing in Linear Models (1999), 3.6.
#![allow(
    clippy::indexing_slicing,
    reason = "`Compressed::new` gives ranges, sizes, own and magnitudes one entry for each group and one for the known ones; `determined` holds numbers of groups only"
)]

use super::compress::Compressed;
use super::factor::Factor;
use super::{Group, Settings, System};
use crate::elements::Elements;
use crate::error::Result;
use faer::linalg::matmul::matmul;
use faer::linalg::solvers::Solve;
use faer::{Accum, Mat, MatRef, Par};
use std::ops::Range;

/// Scales of the groups: `None` for a group without redundancy of its own, and how the iteration went.
pub(super) struct Scales {
    pub scale: Vec<Option<f64>>,
    pub iterations: usize,
    pub converged: bool,
}

/// What is known of the groups' scales beforehand, one number for each group; empty where nothing is.
#[derive(Debug, Clone, Copy, Default)]
pub struct ScaleHints<'a> {
    /// Where the iteration begins: the scales of a system like this one.
    pub start: &'a [f64],
    /// What a scale is at least: the rounding or the resolution of the observations as they were before a prediction was subtracted.
    pub least: &'a [f64],
}

/// A group with less redundancy than this has none.
pub(super) const NO_REDUNDANCY: f64 = 1e-9;
/// Relative change of every variance at which the iteration ends.
const CONVERGED: f64 = 1e-11;
/// Steps that change no variance by more than this are Newton's.
const NEAR: f64 = 0.3;
/// Residuals below this share of a group's largest observation are the rounding of the arithmetic: its scale is this share at least.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Number of groups with an estimated scale: one more than the largest number in use.
pub(super) fn count(group: &[Group]) -> usize {
    let number = |group: &Group| if let Group::Estimated(g) = group { g + 1 } else { 0 };
    group.iter().map(number).max().unwrap_or(0)
}

/// Iterates the scales, beginning with what each group's own best fit leaves,
/// or with what is said of them beforehand.
pub(super) fn estimate(rows: &Compressed, hints: &ScaleHints<'_>, settings: &Settings) -> Result<Scales> {
    let count = rows.range.len() - 1;
    let largest = rows.magnitude.iter().fold(0.0_f64, |most, y| most.max(*y));
    let least: Vec<f64> = (0..count)
        .map(|g| {
            let size = [rows.magnitude[g], f64::EPSILON * largest, f64::EPSILON];
            // the last size is above zero
            let arithmetic = ROUNDING * size.into_iter().find(|y| *y > 0.0).unwrap_or(1.0);
            let stated = hints.least.get(g).copied().unwrap_or(0.0); // no hint: no floor
            arithmetic.max(stated).powi(2).max(f64::MIN_POSITIVE)
        })
        .collect();
    let own = |g: usize| rows.own[g].filter(|(_, dof)| *dof > 0).map(|(squares, dof)| squares / dof as f64);
    let (mut sum, mut known) = (0.0, 0);
    for variance in (0..count).filter_map(own) {
        sum += variance;
        known += 1;
    }
    let other = if known > 0 && sum > 0.0 { sum / f64::from(known) } else { 1.0 };
    let begin = |g: usize| hints.start.get(g).map(|s| s * s).or_else(|| own(g)).unwrap_or(other);
    let mut variance: Vec<f64> = (0..count).map(|g| begin(g).max(least[g])).collect();
    let mut undetermined = vec![false; count];
    let (mut iterations, mut converged) = (0, false);
    while iterations < settings.group_iterations && !converged {
        iterations += 1;
        let theta = factors(rows, &rows.factor(|g| variance[g].sqrt(), settings)?);
        converged = true;
        for (g, theta) in theta.iter().enumerate() {
            undetermined[g] = theta.is_none();
            let Some(theta) = theta else {
                // nothing to go by: weights as given
                converged &= variance[g] == 1.0;
                variance[g] = 1.0;
                continue;
            };
            let next = variance[g] * theta;
            if next <= least[g] {
                converged &= variance[g] == least[g];
                variance[g] = least[g];
            } else {
                variance[g] = next;
                converged &= (theta - 1.0).abs() <= CONVERGED;
            }
        }
    }
    let scale = variance.iter().zip(&undetermined).map(|(v, undetermined)| (!undetermined).then(|| v.sqrt())).collect();
    Ok(Scales { scale, iterations, converged })
}

/// `1 / (s_g u)` for every row.
pub(super) fn weights(system: &System, scale: &[f64]) -> Vec<f64> {
    let scale_of = |group: &Group| match group {
        Group::Known => 1.0,
        Group::Estimated(g) => scale.at(*g),
    };
    system.u.iter().zip(&system.group).map(|(u, group)| 1.0 / (u * scale_of(group))).collect()
}

/// What the groups' shares of the information come to; the last group holds the rows of known uncertainty.
pub(super) struct Information {
    /// `Q_g' Q_g`.
    pub(super) gram: Vec<Mat<f64>>,
    /// `tr(P Q_vv E_g) = n_g - tr(Q_g' Q_g)`.
    redundancy: Vec<f64>,
    /// `S_gh`.
    pub(super) s: Mat<f64>,
}

impl Information {
    pub(super) fn new(gram: Vec<Mat<f64>>, size: &[usize]) -> Self {
        let trace = |gram: &Mat<f64>| -> f64 { (0..gram.ncols()).map(|k| gram[(k, k)]).sum() };
        let redundancy: Vec<f64> = gram.iter().zip(size).map(|(gram, n)| *n as f64 - trace(gram)).collect();
        // each gram matrix as one column: their products are one matrix product
        let rank = gram.first().map_or(0, |gram| gram.ncols());
        let mut columns = Mat::zeros(rank * rank, gram.len());
        for (g, gram) in gram.iter().enumerate() {
            for (k, part) in columns.col_as_slice_mut(g).chunks_exact_mut(rank.max(1)).enumerate() {
                part.copy_from_slice(gram.col_as_slice(k));
            }
        }
        let mut s = self::gram(columns.as_ref());
        for (g, gram) in gram.iter().enumerate() {
            s[(g, g)] += size[g] as f64 - 2.0 * trace(gram);
        }
        Information { gram, redundancy, s }
    }

    /// The estimated groups that have redundancy of their own.
    pub(super) fn determined(&self) -> Vec<usize> {
        (0..self.gram.len() - 1).filter(|g| self.redundancy[*g] > NO_REDUNDANCY).collect()
    }

    /// `S` among some groups.
    fn among(&self, groups: &[usize]) -> Mat<f64> {
        Mat::from_fn(groups.len(), groups.len(), |a, b| self.s[(groups[a], groups[b])])
    }
}

/// `Q_g' Q_g` of some rows of `Q`.
pub(super) fn gram(q: MatRef<'_, f64>) -> Mat<f64> {
    let mut gram = Mat::zeros(q.ncols(), q.ncols());
    matmul(&mut gram, Accum::Replace, q.transpose(), q, 1.0, Par::Seq);
    gram
}

/// By which factor each group's variance should change; `None` where the group has no redundancy.
fn factors(rows: &Compressed, factor: &Factor) -> Vec<Option<f64>> {
    let count = rows.range.len() - 1;
    let fit = rows.solve(factor, 1);
    let blocks = rows.range.iter().map(|range| gram(factor.q.subrows(range.start, range.len())));
    let information = Information::new(blocks.collect(), &rows.size);
    let whitened: Vec<f64> = fit.residuals.iter().zip(&factor.weight).map(|(v, w)| v * w).collect();
    let weighted = |range: &Range<usize>| -> f64 { whitened[range.clone()].iter().map(|v| v * v).sum() };
    let squares: Vec<f64> = rows.range.iter().map(weighted).collect();
    let determined = information.determined();
    let mut simple = vec![None; count];
    for &g in &determined {
        simple[g] = Some(squares[g] / information.redundancy[g]);
    }
    let scoring = full_step(&information, &determined, &squares);
    let near = |step: &[Option<f64>]| step.iter().flatten().all(|theta| (theta - 1.0).abs() < NEAR);
    match scoring {
        Some(step) if near(&step) => newton_step(&information, &determined, &squares, rows, factor, &whitened)
            .filter(|s| near(s))
            .unwrap_or(step),
        Some(step) => step,
        None => simple,
    }
}

/// Newton's step on the restricted likelihood, which ends what scoring has begun: `H (theta - 1) = (q - r) / 2` with the observed
/// information `H_gh = v' E_g P E_h v - S_gh / 2`. The same fixed point; only the way there is shorter.
fn newton_step(
    information: &Information,
    determined: &[usize],
    squares: &[f64],
    rows: &Compressed,
    factor: &Factor,
    whitened: &[f64],
) -> Option<Vec<Option<f64>>> {
    let along: Vec<Vec<f64>> = determined
        .iter()
        .map(|g| {
            let range = rows.range[*g].clone();
            let project = |k: usize| -> f64 {
                factor.q.col_as_slice(k)[range.clone()].iter().zip(&whitened[range.clone()]).map(|(q, v)| q * v).sum()
            };
            (0..factor.rank()).map(project).collect()
        })
        .collect();
    let observed = Mat::from_fn(determined.len(), determined.len(), |a, b| {
        let (g, h) = (determined[a], determined[b]);
        let shared: f64 = along[a].iter().zip(&along[b]).map(|(x, y)| x * y).sum();
        let own = if a == b { squares[g] } else { 0.0 };
        own - shared - 0.5 * information.s[(g, h)]
    });
    let slope = |a: usize| 0.5 * (squares[determined[a]] - information.redundancy[determined[a]]);
    let change = observed.llt(faer::Side::Lower).ok()?.solve(Mat::from_fn(determined.len(), 1, |a, _| slope(a)));
    let mut factors = vec![None; information.gram.len() - 1];
    for (a, &g) in determined.iter().enumerate() {
        factors[g] = Some(1.0 + change[(a, 0)]);
    }
    Some(factors)
}

/// Helmert's step, if every factor stays within a factor of ten of one.
fn full_step(information: &Information, determined: &[usize], squares: &[f64]) -> Option<Vec<Option<f64>>> {
    let all = information.gram.len();
    let fixed = |g: usize| (0..all).filter(|h| !determined.contains(h)).map(|h| information.s[(g, h)]).sum::<f64>();
    let q = Mat::from_fn(determined.len(), 1, |a, _| squares[determined[a]] - fixed(determined[a]));
    let theta = information.among(determined).col_piv_qr().solve(&q);
    let mut factors = vec![None; all - 1];
    for (a, &g) in determined.iter().enumerate() {
        let value = theta[(a, 0)];
        if !(0.1..=10.0).contains(&value) {
            return None;
        }
        factors[g] = Some(value);
    }
    Some(factors)
}
