//! The triangles of several sensors in one adjustment, their open scales estimated.
//!
//! ```text
//! t_s = v_s' v_s / (rows_s - tr(R_s C R_s')/t_s),   C = (sum_s R_s' R_s / t_s)^-1
//! ```
//!
//! That is restricted maximum likelihood for the scales (the estimator of Helmert and of Foerstner at its fixed point), from triangles alone.
#![allow(
    clippy::indexing_slicing,
    reason = "a fold's triangle is square, with the unknowns' columns first and the observations last"
)]

use super::question::{Part, Question};
use crate::elements::Elements;
use crate::error::Result;
use crate::estimate::{Fold, Folded, Group};
use faer::Mat;

/// Most steps to the scales.
const STEPS: usize = 60;

/// An adjustment of all sensors at some noise.
pub(super) struct Together {
    pub folded: Folded,
    /// All rows in one triangle.
    pub fold: Fold,
    /// Variance factor of each sensor, 1 where it is not open.
    pub scale: Vec<f64>,
    /// Its redundancy.
    pub redundancy: Vec<f64>,
    /// `C R_s' R_s C / t_s`: the part of the covariance that comes from each sensor's rows.
    pub shares: Vec<Mat<f64>>,
    /// `-2` times the logarithm of the restricted likelihood, without constants.
    pub deviance: f64,
}

/// Adjust `parts`, one for each sensor that is read; `open` says whose scale is estimated, the others have the scale in `fixed`.
pub(super) fn together(
    question: &Question,
    parts: &[Option<&Part>],
    open: &[bool],
    fixed: &[f64],
    point: &[f64],
) -> Result<Together> {
    let at = |list: &[f64], s: usize| list.at(s);
    let is_open = |s: usize| open.get(s) == Some(&true);
    let rows = |s: usize| parts.get(s).copied().flatten().map_or(0, |part| part.rows);
    let all: u64 = (0..parts.len()).map(rows).sum();
    let mut settings = question.settings.adjust;
    settings.rank_tolerance.get_or_insert(32.0 * f64::EPSILON * (all.max(1) as f64).sqrt());
    let mut scale: Vec<f64> = (0..parts.len())
        .map(|s| match parts.get(s).copied().flatten() {
            Some(part) if is_open(s) => {
                let z = part.fold.triangle();
                let last = z.ncols() - 1;
                let own: f64 = (question.unknowns..=last).map(|i| z[(i, last)] * z[(i, last)]).sum();
                let least = f64::MIN_POSITIVE.sqrt();
                (own / part.rows.max(1) as f64).max(least)
            }
            _ => at(fixed, s),
        })
        .collect();
    let mut step = 0;
    loop {
        let fold = merged(question, parts, &scale, point)?;
        let folded = fold.finish(Group::Known, &settings)?;
        let (mut squares, mut redundancy, mut shares) = (Vec::new(), Vec::new(), Vec::new());
        for (s, part) in parts.iter().enumerate() {
            let Some(part) = part else {
                squares.push(0.0);
                redundancy.push(0.0);
                shares.push(Mat::new());
                continue;
            };
            let t = at(&scale, s);
            let moved = influence(part, &folded.unknowns.cofactor);
            let leverage: f64 = inner(part, &moved) / t;
            squares.push(remainder(part, &folded.unknowns.solution) / t);
            redundancy.push((part.rows as f64 - leverage).max(0.0));
            shares.push(Mat::from_fn(moved.ncols(), moved.ncols(), |i, j| {
                (0..moved.nrows()).map(|k| moved[(k, i)] * moved[(k, j)]).sum::<f64>() / t
            }));
        }
        step += 1;
        let mut change = 0.0_f64;
        let mut next = scale.clone();
        for (s, own) in next.iter_mut().enumerate().filter(|(s, _)| is_open(*s)) {
            let factor = at(&squares, s) / redundancy.at(s);
            if factor.is_finite() && factor > 0.0 {
                change = change.max((factor - 1.0).abs());
                *own *= factor;
            }
        }
        if change <= 1e-13 || step == STEPS {
            let logarithms: f64 = (0..parts.len())
                .filter_map(|s| {
                    let part = parts.get(s).copied().flatten()?;
                    Some(part.log_determinant + part.rows as f64 * at(&scale, s).ln())
                })
                .sum();
            let deviance = logarithms + folded.sum_of_squares + folded.log_determinant;
            return Ok(Together { folded, fold, scale, redundancy, shares, deviance });
        }
        scale = next;
    }
}

/// The rows of all sensors over their scales, and the priors, in one triangle.
pub(super) fn merged(question: &Question, parts: &[Option<&Part>], scale: &[f64], point: &[f64]) -> Result<Fold> {
    let columns = question.carried.len();
    let mut fold = Fold::carrying(question.unknowns, columns);
    for (part, t) in parts.iter().zip(scale) {
        let Some(part) = part else { continue };
        let triangle = part.fold.triangle();
        let u = vec![t.sqrt(); triangle.nrows()];
        fold.push(triangle.subcols(0, triangle.ncols() - 1), &observed(part), &u)?;
    }
    for (k, value, u) in &question.priors {
        let row = Mat::from_fn(1, question.unknowns + columns, |_, j| f64::from(u8::from(j == *k)));
        fold.push(row.as_ref(), &[value - point.at(*k)], &[*u])?;
    }
    Ok(fold)
}

/// The observations of a triangle, about zero.
pub(super) fn observed(part: &Part) -> Vec<f64> {
    let triangle = part.fold.triangle();
    let last = triangle.ncols() - 1;
    let about = part.fold.about();
    (0..triangle.nrows())
        .map(|i| triangle[(i, last)] + about.iter().enumerate().map(|(j, a)| triangle[(i, j)] * a).sum::<f64>())
        .collect()
}

/// Squares of a part's rows at a solution.
pub(super) fn remainder(part: &Part, solution: &[f64]) -> f64 {
    let triangle = part.fold.triangle();
    let row = |(i, z): (usize, f64)| z - solution.iter().enumerate().map(|(j, x)| triangle[(i, j)] * x).sum::<f64>();
    observed(part).into_iter().enumerate().map(|own| row(own).powi(2)).sum()
}

/// `R_s C`, as many rows as unknowns.
fn influence(part: &Part, cofactor: &Mat<f64>) -> Mat<f64> {
    let triangle = part.fold.triangle();
    let n = cofactor.ncols();
    Mat::from_fn(n, n, |i, j| (i..n).map(|k| triangle[(i, k)] * cofactor[(k, j)]).sum())
}

/// `tr(R_s' R_s C)`.
fn inner(part: &Part, influence: &Mat<f64>) -> f64 {
    let triangle = part.fold.triangle();
    let n = influence.ncols();
    (0..n).map(|i| (i..n).map(|j| triangle[(i, j)] * influence[(i, j)]).sum::<f64>()).sum()
}
