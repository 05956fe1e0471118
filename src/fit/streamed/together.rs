//! The triangles of several sensors in one adjustment, their open scales estimated: the top of the restricted likelihood (`estimate/scatter/restricted.rs`) of
//! the sums that the triangles have.
#![allow(
    clippy::indexing_slicing,
    reason = "a fold's triangle is square, with the unknowns' columns first and the observations last; lists over sensors are as long as the parts"
)]

use super::question::{Part, Question};
use crate::elements::Elements;
use crate::error::Result;
use crate::estimate::{Fold, Folded, Group, NO_REDUNDANCY, NoiseModel, NoisePart};
use faer::Mat;

/// An adjustment of all sensors at some noise.
pub(super) struct Together {
    pub folded: Folded,
    /// All rows in one triangle.
    pub fold: Fold,
    /// Variance factor of each sensor, 1 where it is not open.
    pub scale: Vec<f64>,
    /// Its redundancy.
    pub redundancy: Vec<f64>,
    /// Did the scales settle?
    pub settled: bool,
}

/// Adjust `parts`, one for each sensor that is read; `open` says whose scale is estimated.
pub(super) fn together(question: &Question, parts: &[Option<Part>], open: &[bool], point: &[f64]) -> Result<Together> {
    let all: u64 = parts.iter().flatten().map(|part| part.rows).sum();
    let mut settings = question.settings.adjust;
    settings.rank_tolerance.get_or_insert(32.0 * f64::EPSILON * (all.max(1) as f64).sqrt());
    let white = |s: usize| parts[s].as_ref().map_or(1.0, |part| part.white);
    let floor = |s: usize| (question.floor.at(s) / white(s)).max(f64::MIN_POSITIVE.sqrt());
    // what a sensor's own best fit leaves, where it has more rows than unknowns
    let own = |s: usize| {
        let part = parts[s].as_ref().filter(|_| open[s])?;
        let z = part.fold.triangle();
        let (n, last) = (question.unknowns, z.ncols() - 1);
        let dof = part.rows.saturating_sub(n as u64);
        let squares: f64 = (n..=last).map(|i| z[(i, last)] * z[(i, last)]).sum();
        (dof > 0).then(|| (squares / dof as f64).max(floor(s)))
    };
    let known: Vec<f64> = (0..parts.len()).filter_map(own).collect();
    let other = if known.is_empty() { 1.0 } else { known.iter().sum::<f64>() / known.len() as f64 };
    let begin = |s: usize| if open[s] { own(s).unwrap_or(other) } else { 1.0 };
    let scale: Vec<f64> = (0..parts.len()).map(begin).collect();
    let adjusted = |scale: Vec<f64>| -> Result<Together> {
        let fold = merged(question, parts, &scale, point)?;
        let folded = fold.finish(Group::Known, &settings)?;
        let redundancy = |(part, t): (&Option<Part>, &f64)| {
            let leverage = |part: &Part| leverage(part, &folded.unknowns.cofactor) / t;
            part.as_ref().map_or(0.0, |part| (part.rows as f64 - leverage(part)).max(0.0))
        };
        let redundancy = parts.iter().zip(&scale).map(redundancy).collect();
        Ok(Together { folded, fold, scale, redundancy, settled: true })
    };
    let first = adjusted(scale)?;
    let free: Vec<usize> = (0..parts.len()).filter(|s| open[*s] && first.redundancy[*s] > NO_REDUNDANCY).collect();
    if free.is_empty() {
        return Ok(first);
    }
    let directions = first.fold.directions(&settings)?;
    let sums = sums(question, parts, &directions, (point, &first.folded.unknowns.solution));
    // the priors are the last part
    let read: Vec<usize> = (0..parts.len()).filter(|s| parts[*s].is_some()).collect();
    let mut variance: Vec<f64> = read.iter().map(|s| first.scale[*s]).chain([1.0]).collect();
    let least: Vec<f64> = read.iter().map(|s| floor(*s)).chain([1.0]).collect();
    let among: Vec<usize> = (0..read.len()).filter(|p| free.contains(&read[*p])).collect();
    let top = NoiseModel::scales(&sums, &mut variance, (&among, &least), settings.group_iterations)?;
    let mut scale = first.scale;
    read.iter().zip(&variance).for_each(|(s, variance)| scale[*s] = *variance);
    Ok(Together { settled: top.converged, ..adjusted(scale)? })
}

/// The rows of all sensors over their scales, and the priors, in one triangle.
pub(super) fn merged(question: &Question, parts: &[Option<Part>], scale: &[f64], point: &[f64]) -> Result<Fold> {
    let columns = question.carried.len();
    let mut fold = Fold::carrying(question.unknowns, columns);
    for (part, t) in parts.iter().zip(scale) {
        let Some(part) = part else { continue };
        let triangle = part.fold.triangle();
        let u = vec![t.sqrt(); triangle.nrows()];
        fold.push(triangle.subcols(0, triangle.ncols() - 1), &left(part, &[]), &u)?;
    }
    for (k, value, u) in &question.priors {
        let row = Mat::from_fn(1, question.unknowns + columns, |_, j| f64::from(u8::from(j == *k)));
        fold.push(row.as_ref(), &[value - point.at(*k)], &[*u])?;
    }
    Ok(fold)
}

/// What the triangles have in some directions of the unknowns, a step away from the point: of each sensor's rows over the noise that they were folded with,
/// then of the priors.
pub(super) fn sums(
    question: &Question,
    parts: &[Option<Part>],
    directions: &Mat<f64>,
    (point, step): (&[f64], &[f64]),
) -> Vec<NoisePart> {
    let (n, r) = directions.shape();
    let own = |part: &Part| {
        let triangle = part.fold.triangle();
        let mut rows = Mat::zeros(triangle.nrows(), r + 1);
        rows.subcols_mut(0, r).copy_from(triangle.subcols(0, n) * directions);
        rows.col_as_slice_mut(r).copy_from_slice(&left(part, step));
        NoisePart::white(part.rows as f64, part.log_determinant, rows.transpose() * &rows)
    };
    parts.iter().flatten().map(own).chain([priors(question, directions, (point, step))]).collect()
}

/// The priors in some directions of the unknowns, a step away from the point.
pub(super) fn priors(question: &Question, directions: &Mat<f64>, (point, step): (&[f64], &[f64])) -> NoisePart {
    let r = directions.ncols();
    let row = |i: usize, j: usize| {
        let (k, value, u) = question.priors[i];
        (if j < r { directions[(k, j)] } else { value - point.at(k) - step.get(k).unwrap_or(&0.0) }) / u
    };
    let rows = Mat::from_fn(question.priors.len(), r + 1, row);
    NoisePart::white(question.priors.len() as f64, 0.0, rows.transpose() * &rows)
}

/// What a step leaves of a triangle's observations; a step that is not given is none.
pub(super) fn left(part: &Part, step: &[f64]) -> Vec<f64> {
    let triangle = part.fold.triangle();
    let last = triangle.ncols() - 1;
    let about = part.fold.about();
    // observations are taken about a point
    let to = |j: usize| about.get(j).unwrap_or(&0.0) - step.get(j).unwrap_or(&0.0);
    let moved: Vec<f64> = (0..about.len().max(step.len()).min(last)).map(to).collect();
    (0..triangle.nrows())
        .map(|i| triangle[(i, last)] + moved.iter().enumerate().map(|(j, a)| triangle[(i, j)] * a).sum::<f64>())
        .collect()
}

/// `tr(R C R')` of a part's triangle.
fn leverage(part: &Part, cofactor: &Mat<f64>) -> f64 {
    let triangle = part.fold.triangle();
    let n = cofactor.ncols();
    let square = |i: usize| -> f64 {
        let moved = |j: usize| (i..n).map(|k| triangle[(i, k)] * cofactor[(k, j)]).sum::<f64>();
        (i..n).map(|j| triangle[(i, j)] * moved(j)).sum()
    };
    (0..n).map(square).sum()
}
