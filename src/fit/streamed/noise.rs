//! From a start to the solution, and to what is free of the sensors' noise: passes of Gauss-Newton, then of both together.
//!
//! The restricted likelihood is looked at on a few points about the one at hand, all in one pass; Newton's step on the parabola through them is the next
//! one. Scales need no points: they follow from the triangles (`together.rs`).
#![allow(
    clippy::indexing_slicing,
    reason = "every list here has one entry for each sensor, and each sensor's list of points begins with the one at hand"
)]

use super::Rows;
use super::octaves::Noise;
use super::octaves::{self, Octaves, Stated};
use super::question::{Chunk, Part, Question};
use super::together::{Together, merged, remainder, together};
use crate::campaign::{Campaign, Size};
use crate::elements::Elements;
use crate::error::Result;
use crate::fit::Estimator;
use crate::fit::gauss_newton::{Convergence, Iteration, Stop};

/// Most passes of the search for the noise.
const PASSES: usize = 30;
/// A step of the noise that is smaller than this share of its standard uncertainty does not matter.
const SETTLED: f64 = 2e-3;
/// Half width of the parabola in standard uncertainties of the logarithm of a standard deviation or of a correlation time: at first, and in the end.
const AT_FIRST: f64 = 3.0;
const IN_THE_END: f64 = 0.1;
/// Least and most half width.
const WIDTHS: (f64, f64) = (1e-5, 0.25);
/// Deviances that differ by less are the same.
const SAME: f64 = 1e-3;
/// A step of Gauss-Newton is negligible where it moves no weighted prediction by more than this share of the weighted residuals' norm.
const NEGLIGIBLE: f64 = 1e-9;
/// Longest step of a logarithm.
const LONGEST: f64 = 1.5;

/// What is free of a sensor's noise, beside its scale.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Coordinate {
    White,
    Deviation,
    Tau,
}

/// Where the search ended.
pub(super) struct Found {
    pub noise: Vec<Noise>,
    pub convergence: Option<Convergence>,
    /// Did the noise settle?
    pub settled: bool,
    /// Sensors whose deviation over time was estimated as zero.
    pub at_zero: Vec<bool>,
}

impl Question {
    /// The stated numbers of a sensor's line; `None` without one.
    pub(super) fn stated(&self, s: usize, campaign: &Campaign) -> Option<Stated> {
        let (line, _) = self.sensors.get(s)?.line?;
        let own = campaign.scatter.get(line)?;
        let deviation = if let Size::Stated { sd, .. } = own.size { Some(sd) } else { None };
        let white = (!self.is_white_free(s)).then_some(1.0);
        Some(Stated { white, deviation, tau: own.over.as_ref().and_then(|over| over.tau) })
    }
}

/// What is free of a sensor's noise: its coordinates, and whether all of it has an open scale.
pub(super) fn free(stated: Option<Stated>, white_free: bool) -> (Vec<Coordinate>, bool) {
    let Some(stated) = stated else { return (Vec::new(), white_free) };
    let mut list = Vec::new();
    match (white_free, stated.deviation) {
        (_, None) => list.push(Coordinate::Deviation),
        (true, Some(_)) => list.push(Coordinate::White),
        (false, Some(_)) => {}
    }
    if stated.tau.is_none() {
        list.push(Coordinate::Tau);
    }
    (list, white_free && stated.deviation.is_none())
}

/// A noise with its coordinates moved by so much in their logarithms.
pub(super) fn moved(noise: Noise, coordinates: &[Coordinate], by: &[f64]) -> Noise {
    coordinates.iter().zip(by).fold(noise, |noise, (coordinate, x)| match coordinate {
        Coordinate::White => Noise { white: noise.white * x.exp(), ..noise },
        Coordinate::Deviation => Noise { deviation: noise.deviation * x.exp(), ..noise },
        Coordinate::Tau => Noise { tau: noise.tau * x.exp(), ..noise },
    })
}

/// Points of a parabola in none, one or two coordinates about zero, `h` of each apart.
pub(super) fn stencil(h: &[f64]) -> Vec<Vec<f64>> {
    match h {
        [] => vec![vec![]],
        [h] => vec![vec![0.0], vec![*h], vec![-h]],
        [h, k, ..] => {
            vec![vec![0.0, 0.0], vec![*h, 0.0], vec![-h, 0.0], vec![0.0, *k], vec![0.0, -k], vec![*h, *k], vec![-h, -k]]
        }
    }
}

/// Gradient and second derivatives from the values on a [`stencil`].
fn parabola(values: &[f64], h: &[f64]) -> (Vec<f64>, Vec<Vec<f64>>) {
    let one = |a: usize, h: f64| {
        ((values[a] - values[a + 1]) / (2.0 * h), (values[a] - 2.0 * values[0] + values[a + 1]) / (h * h))
    };
    match h {
        [h] => {
            let (slope, bend) = one(1, *h);
            (vec![slope], vec![vec![bend]])
        }
        [h, k] => {
            let ((s1, b1), (s2, b2)) = (one(1, *h), one(3, *k));
            let cross = (values[5] + values[6] - values[1] - values[2] - values[3] - values[4] + 2.0 * values[0])
                / (2.0 * h * k);
            (vec![s1, s2], vec![vec![b1, cross], vec![cross, b2]])
        }
        _ => (Vec::new(), Vec::new()),
    }
}

/// The inverse of one number or of a symmetric 2 x 2 matrix; `None` where it is not positive definite.
fn inverse(matrix: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    match matrix {
        [row] => (row[0] > 0.0).then(|| vec![vec![1.0 / row[0]]]),
        [a, b] => {
            let determinant = a[0] * b[1] - a[1] * b[0];
            (a[0] > 0.0 && determinant > 1e-10 * a[0] * b[1].abs()).then(|| {
                vec![vec![b[1] / determinant, -a[1] / determinant], vec![-b[0] / determinant, a[0] / determinant]]
            })
        }
        _ => None,
    }
}

/// Parts at the point at hand.
fn centre(parts: &[Vec<Part>], question: &Question) -> Vec<Option<Part>> {
    parts.iter().enumerate().map(|(s, list)| list.first().filter(|_| question.is_read(s)).cloned()).collect()
}

fn as_refs(parts: &[Option<Part>]) -> Vec<Option<&Part>> {
    parts.iter().map(Option::as_ref).collect()
}

/// Squares of all rows at a point, and at the point moved by `change`.
fn merit(question: &Question, parts: &[Option<Part>], scale: &[f64], point: &[f64], change: &[f64]) -> f64 {
    let own = parts.iter().zip(scale).filter_map(|(part, t)| Some(remainder(part.as_ref()?, change) / t));
    let prior = |(k, value, u): &(usize, f64, f64)| {
        let at = |list: &[f64]| list.at(*k);
        ((value - at(point) - at(change)) / u).powi(2)
    };
    own.sum::<f64>() + question.priors.iter().map(prior).sum::<f64>()
}

/// `|J dx|`, weighted.
fn effect(question: &Question, parts: &[Option<Part>], scale: &[f64], point: &[f64], change: &[f64]) -> Result<f64> {
    let fold = merged(question, &as_refs(parts), scale, point)?;
    let triangle = fold.triangle();
    let n = question.unknowns;
    let row = |i: usize| (i..n).map(|j| triangle[(i, j)] * change[j]).sum::<f64>();
    Ok((0..n).map(|i| row(i).powi(2)).sum::<f64>().sqrt())
}

/// The solution and the noise; `point` is where it begins and ends, `first` what was folded there already.
pub(super) fn search(
    question: &mut Question,
    rows: &mut dyn Rows,
    point: &mut [f64],
    lines: &[Option<Stated>],
    mut first: Option<Vec<Vec<Part>>>,
) -> Result<Found> {
    let sensors = question.sensors.len();
    let n = question.unknowns;
    let linear_only = question.settings.estimator == Estimator::Linear;
    // the noise of the first passes: what is stated, white where something is to be estimated
    let mut noise: Vec<Noise> = vec![Noise::WHITE; sensors];
    for (own, stated) in noise.iter_mut().zip(lines) {
        if let Some(Stated { deviation: Some(deviation), tau: Some(tau), white: Some(_) }) = stated {
            *own = Noise { white: 1.0, deviation: *deviation, tau: *tau };
        }
    }
    let open_at_first: Vec<bool> = (0..sensors).map(|s| noise[s].deviation == 0.0).collect();
    let mut iterations: Vec<Iteration> = Vec::new();
    let mut octaves = vec![(Octaves::default(), 0_u64, f64::NAN, f64::NAN); sensors];
    let mut stop = Stop::Limit;
    let mut before: Option<(f64, Vec<f64>, Vec<f64>, f64)> = None;
    let mut white = f64::INFINITY;
    for _ in 0..question.settings.iterations.max(1) {
        octaves.iter_mut().for_each(|own| *own = (Octaves::default(), 0, f64::NAN, f64::NAN));
        let lists: Vec<Vec<Noise>> = noise.iter().map(|own| vec![*own]).collect();
        let mut look = |s: usize, chunk: &Chunk<'_>| {
            let last = chunk.rows.ncols() - 1;
            let (series, count, first, end) = &mut octaves[s];
            for ((y, relative), time) in chunk.rows.col_as_slice(last).iter().zip(chunk.relative).zip(chunk.time) {
                series.push(y / relative);
                *count += 1;
                if first.is_nan() {
                    *first = *time;
                }
                *end = *time;
            }
        };
        let parts = match first.take() {
            Some(parts) => parts,
            None => question.fold(rows, point, &lists, &mut look)?,
        };
        let parts = centre(&parts, question);
        let open: Vec<bool> = (0..sensors).map(|s| question.is_white_free(s) && open_at_first[s]).collect();
        let found = together(question, &as_refs(&parts), &open, &vec![1.0; sensors], point)?;
        let change = found.folded.unknowns.solution.clone();
        let here = merit(question, &parts, &found.scale, point, &vec![0.0; n]);
        if let Some((merit_before, from, step, share)) = before.take()
            && here > merit_before * (1.0 + 1e-9)
            && share > 1e-6
            && iterations.len() > 1
        {
            // too far: half of the step from where it came
            let share = 0.5 * share;
            for ((x, from), dx) in point.iter_mut().zip(&from).zip(&step) {
                *x = from + share * dx;
            }
            if let Some(last) = iterations.last_mut() {
                last.share = share;
            }
            before = Some((merit_before, from, step, share));
            continue;
        }
        let length = effect(question, &parts, &found.scale, point, &change)?;
        iterations.push(Iteration { sum_of_squares: here, step: length, share: 1.0 });
        white = found.deviance;
        for (s, own) in noise.iter_mut().enumerate().filter(|(s, _)| open[*s]) {
            own.white = found.scale[s].sqrt();
        }
        let rest = found.folded.sum_of_squares.sqrt();
        if linear_only || length <= NEGLIGIBLE * rest || length <= 1e-13 * (here.sqrt() + size(point)) {
            stop = Stop::Settled;
            break;
        }
        before = Some((here, point.to_vec(), change.clone(), 1.0));
        point.iter_mut().zip(&change).for_each(|(x, dx)| *x += dx);
        if question.is_linear {
            // the step is the whole way
            stop = Stop::Settled;
            break;
        }
    }
    let mut state = Search { question, rows, point, noise, at_zero: vec![false; sensors], white, linear_only };
    let settled = state.run(lines, &octaves)?;
    let Search { noise, at_zero, .. } = state;
    let converged = stop == Stop::Settled;
    let convergence = (!linear_only).then(|| Convergence {
        converged,
        stop,
        iterations,
        linear: point.iter().copied().take(n).collect(),
        held: Vec::new(),
        moved: Vec::new(),
    });
    Ok(Found { noise, convergence, settled, at_zero })
}

fn size(point: &[f64]) -> f64 {
    point.iter().map(|x| x * x).sum::<f64>().sqrt() * f64::EPSILON
}

/// The search for the noise.
struct Search<'a> {
    question: &'a mut Question,
    rows: &'a mut dyn Rows,
    point: &'a mut [f64],
    noise: Vec<Noise>,
    at_zero: Vec<bool>,
    /// Deviance without any deviation over time.
    white: f64,
    linear_only: bool,
}

impl Search<'_> {
    fn run(&mut self, lines: &[Option<Stated>], octaves: &[(Octaves, u64, f64, f64)]) -> Result<bool> {
        let sensors = self.noise.len();
        let mut coordinates: Vec<Vec<Coordinate>> = Vec::with_capacity(sensors);
        let mut open: Vec<bool> = Vec::with_capacity(sensors);
        let mut ranges: Vec<(f64, f64)> = Vec::with_capacity(sensors);
        for (s, stated) in lines.iter().enumerate() {
            let (list, is_open) = free(*stated, self.question.is_white_free(s));
            let list = if self.question.is_read(s) { list } else { Vec::new() };
            let (series, count, first, last) = &octaves[s];
            let step = (last - first) / (*count as f64 - 1.0).max(1.0);
            let length = last - first;
            ranges.push((step / 5.0, 2.0 * length));
            if let Some(stated) = stated.filter(|_| !list.is_empty()) {
                self.noise[s] = octaves::start(series, step, length, stated);
            }
            coordinates.push(list);
            open.push(is_open);
        }
        if coordinates.iter().all(Vec::is_empty) {
            return Ok(true);
        }
        let mut widths: Vec<Vec<f64>> = coordinates
            .iter()
            .enumerate()
            .map(|(s, list)| {
                let (_, count, first, last) = &octaves[s];
                let of = |coordinate: &Coordinate| match coordinate {
                    Coordinate::White => (0.5 / *count as f64).sqrt(),
                    // so many independent stretches
                    Coordinate::Deviation | Coordinate::Tau => (2.0 * self.noise[s].tau / (last - first)).sqrt(),
                };
                list.iter().map(|own| width(AT_FIRST * of(own))).collect()
            })
            .collect();
        let mut last: Option<(f64, Vec<Noise>)> = None;
        for _ in 0..PASSES {
            let points: Vec<Vec<Vec<f64>>> = widths.iter().map(|h| stencil(h)).collect();
            let lists: Vec<Vec<Noise>> = (0..sensors)
                .map(|s| points[s].iter().map(|by| moved(self.noise[s], &coordinates[s], by)).collect())
                .collect();
            let parts = self.question.fold(self.rows, self.point, &lists, &mut |_, _| {})?;
            let middle = centre(&parts, self.question);
            let ones = vec![1.0; sensors];
            let found = together(self.question, &as_refs(&middle), &open, &ones, self.point)?;
            if let Some((deviance, noise)) = &last
                && found.deviance > deviance + SAME
            {
                // too far: half of the way back, in logarithms
                for (own, before) in self.noise.iter_mut().zip(noise) {
                    let half = |a: f64, b: f64| if a > 0.0 && b > 0.0 { (a * b).sqrt() } else { a };
                    *own = Noise {
                        white: half(own.white, before.white),
                        deviation: half(own.deviation, before.deviation),
                        tau: half(own.tau, before.tau),
                    };
                }
                widths.iter_mut().flatten().for_each(|h| *h = width(0.5 * *h));
                continue;
            }
            if !self.linear_only {
                self.point.iter_mut().zip(&found.folded.unknowns.solution).for_each(|(x, dx)| *x += dx);
            }
            last = Some((found.deviance, self.noise.clone()));
            let mut far = 0.0_f64;
            for s in 0..sensors {
                if open[s] {
                    self.noise[s].white *= found.scale[s].sqrt();
                    self.noise[s].deviation *= found.scale[s].sqrt();
                }
                if coordinates[s].is_empty() {
                    continue;
                }
                let values = self.values(&parts, &middle, s, &open, &found)?;
                let (by, u) = newton(&values, &widths[s]);
                for ((h, x), u) in widths[s].iter_mut().zip(&by).zip(&u) {
                    far = far.max(x.abs() / u);
                    *h = width(x.abs().max(IN_THE_END * u).min(*h));
                }
                self.noise[s] = moved(self.noise[s], &coordinates[s], &by);
                let (low, high) = ranges[s];
                if coordinates[s].contains(&Coordinate::Tau) && low < high {
                    self.noise[s].tau = self.noise[s].tau.clamp(low, high);
                }
            }
            if far <= SETTLED {
                return Ok(true);
            }
            if self.vanishes(&coordinates, found.deviance) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Deviance on the points of one sensor, the others as they are.
    fn values(
        &self,
        parts: &[Vec<Part>],
        middle: &[Option<Part>],
        s: usize,
        open: &[bool],
        found: &Together,
    ) -> Result<Vec<f64>> {
        let mut values = vec![found.deviance];
        let ones = vec![1.0; parts.len()];
        for part in parts[s].iter().skip(1) {
            let mut own = as_refs(middle);
            own[s] = Some(part);
            values.push(together(self.question, &own, open, &ones, self.point)?.deviance);
        }
        Ok(values)
    }

    /// Is a deviation over time so small that the rows do not need it? Then it is zero.
    fn vanishes(&mut self, coordinates: &[Vec<Coordinate>], deviance: f64) -> bool {
        let alone = coordinates.iter().filter(|list| !list.is_empty()).count() == 1;
        let mut any = false;
        for (s, list) in coordinates.iter().enumerate() {
            let own = &mut self.noise[s];
            let tiny = own.deviation < 1e-3 * own.white && alone && deviance > self.white - 1e-2;
            if list.contains(&Coordinate::Deviation) && (tiny || own.deviation < 1e-7 * own.white) {
                own.deviation = 0.0;
                self.at_zero[s] = true;
                any = true;
            }
        }
        any
    }
}

fn width(h: f64) -> f64 {
    if h > WIDTHS.0 { h.min(WIDTHS.1) } else { WIDTHS.0 }
}

/// Newton's step from the values on a stencil, and the standard uncertainty of each coordinate.
fn newton(values: &[f64], h: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (slope, bend) = parabola(values, h);
    match inverse(&bend) {
        Some(inverse) => {
            let by: Vec<f64> = inverse
                .iter()
                .map(|row| -row.iter().zip(&slope).map(|(a, g)| a * g).sum::<f64>())
                .map(|x| x.clamp(-LONGEST, LONGEST))
                .collect();
            let u = inverse.iter().enumerate().map(|(k, row)| (2.0 * row[k]).sqrt()).collect();
            (by, u)
        }
        // no parabola with a bottom: downhill
        None => (slope.iter().map(|g| -0.5 * g.signum()).collect(), vec![0.1; slope.len()]),
    }
}
