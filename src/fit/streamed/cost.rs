//! What it costs to have estimated the noise: each source's part of the covariance, and the covariance of the estimated variances.
//!
//! Derivatives of the covariance of the unknowns and of the deviance by the logarithms of the noise's parameters are difference quotients of the triangles
//! of the last pass; degrees of freedom follow as Satterthwaite's, with the covariance of the estimated variances.
#![allow(
    clippy::indexing_slicing,
    reason = "every list here has one entry for each sensor, and each sensor's list of points begins with the one at hand"
)]

use super::noise::{Coordinate, moved, stencil};
use super::octaves::Noise as Size;
use super::question::{Part, Question};
use super::together::{Together, together};
use crate::campaign::{self, Campaign};
use crate::error::Result;
use crate::estimate::LineState;
use crate::fit::noise::{ScatterSources, StreamedSource};
use crate::uncertainty::Evaluation;
use faer::Mat;

/// Half width of the differences, in the logarithm of a standard deviation or of a correlation time.
const STEP: f64 = 0.005;

/// What the last pass gives of the noise.
pub(super) struct Uncertain {
    /// Part of the covariance that a sensor's deviation over time has.
    deviation: Vec<Option<Mat<f64>>>,
    /// Derivative of the covariance by the logarithm of a correlation time.
    lean: Vec<Option<Mat<f64>>>,
    /// Covariance of the logarithms of white sd, deviation's sd and correlation time; zero for what is stated.
    logarithms: Vec<[[f64; 3]; 3]>,
}

/// The noise of the sensors as it was found, with what is free of it.
pub(super) struct Shape {
    pub noise: Vec<Size>,
    pub coordinates: Vec<Vec<Coordinate>>,
    pub open: Vec<bool>,
}

impl Shape {
    /// The points at which a sensor's rows are folded in the last pass: the noise as it was found, then those about it.
    pub(super) fn points(&self, s: usize) -> Vec<Size> {
        let own = &self.coordinates[s];
        let about = stencil(&vec![STEP; own.len()]);
        let mut list: Vec<Size> = about.iter().map(|by| moved(self.noise[s], own, by)).collect();
        if self.noise[s].deviation > 0.0 && !own.contains(&Coordinate::Deviation) {
            list.extend([STEP, -STEP].map(|by| moved(self.noise[s], &[Coordinate::Deviation], &[by])));
        }
        list
    }
}

/// What it costs to have estimated the noise, from the points about it.
pub(super) fn uncertain(
    question: &Question,
    shape: &Shape,
    parts: &[Vec<Part>],
    middle: &[Option<&Part>],
    solved: &Together,
    point: &[f64],
) -> Result<Uncertain> {
    let sensors = parts.len();
    let none = vec![false; sensors];
    let mut found = Uncertain {
        deviation: vec![None; sensors],
        lean: vec![None; sensors],
        logarithms: vec![[[0.0; 3]; 3]; sensors],
    };
    for s in 0..sensors {
        if middle[s].is_none() {
            continue;
        }
        let list = &shape.coordinates[s];
        // all scales as they are, that of this sensor by exp(2 a)
        let of = |place: usize, a: f64| -> Result<Together> {
            let mut own = middle.to_vec();
            own[s] = parts[s].get(place).or(own[s]);
            let mut scale = solved.scale.clone();
            scale[s] *= (2.0 * a).exp();
            together(question, &own, &none, &scale, point)
        };
        let slope = |k: usize| -> Result<Mat<f64>> {
            let (more, less) = (of(k, 0.0)?, of(k + 1, 0.0)?);
            Ok((more.folded.unknowns.cofactor - less.folded.unknowns.cofactor) * faer::Scale(1.0 / (2.0 * STEP)))
        };
        let place = |coordinate: Coordinate| list.iter().position(|own| *own == coordinate).map(|k| 1 + 2 * k);
        if shape.noise[s].deviation > 0.0 {
            let appended = parts[s].len() - 2;
            // where its size is not searched for, the slopes by it were appended
            let k = place(Coordinate::Deviation).unwrap_or(appended);
            // by the variance: half of that by the standard deviation
            found.deviation[s] = Some(slope(k)? * faer::Scale(0.5));
        }
        if let Some(k) = place(Coordinate::Tau) {
            found.lean[s] = Some(slope(k)?);
        }
        found.logarithms[s] = logarithms(shape.open[s], list, &of, solved.redundancy[s])?;
    }
    Ok(found)
}

/// Covariance of the logarithms of white sd, deviation's sd and correlation time, from second differences of the deviance.
fn logarithms(
    open: bool,
    list: &[Coordinate],
    of: &dyn Fn(usize, f64) -> Result<Together>,
    redundancy: f64,
) -> Result<[[f64; 3]; 3]> {
    let mut out = [[0.0; 3]; 3];
    if list.is_empty() {
        if open && redundancy > 0.0 {
            // ln s of a variance with so many degrees of freedom
            out[0][0] = 1.0 / (2.0 * redundancy);
        }
        return Ok(out);
    }
    let h = STEP;
    let here = of(0, 0.0)?.deviance;
    let deviance = |place: usize, a: f64| Ok::<f64, crate::error::Malformed>(of(place, a)?.deviance - here);
    let size = list.len() + usize::from(open);
    let mut bend = nalgebra::DMatrix::<f64>::zeros(size, size);
    let first = usize::from(open);
    let mut single = vec![(0.0, 0.0); size];
    if open {
        single[0] = (deviance(0, h)?, deviance(0, -h)?);
    }
    for k in 0..list.len() {
        single[first + k] = (deviance(1 + 2 * k, 0.0)?, deviance(2 + 2 * k, 0.0)?);
    }
    for (k, (more, less)) in single.iter().enumerate() {
        bend[(k, k)] = (more + less) / (h * h);
    }
    for a in 0..size {
        for b in 0..a {
            let (more, less) = match (open, b) {
                // the scale and a coordinate
                (true, 0) => (deviance(1 + 2 * (a - 1), h)?, deviance(2 + 2 * (a - 1), -h)?),
                _ => (deviance(5, 0.0)?, deviance(6, 0.0)?),
            };
            let sum = single[a].0 + single[a].1 + single[b].0 + single[b].1;
            let cross = (more + less - sum) / (2.0 * h * h);
            bend[(a, b)] = cross;
            bend[(b, a)] = cross;
        }
    }
    let Some(cholesky) = nalgebra::Cholesky::new(bend) else { return Ok([[f64::NAN; 3]; 3]) };
    let covariance = cholesky.inverse() * 2.0;
    // how each logarithm follows the coordinates
    let mut follows = nalgebra::DMatrix::<f64>::zeros(3, size);
    if open {
        (follows[(0, 0)], follows[(1, 0)]) = (1.0, 1.0);
    }
    for (k, coordinate) in list.iter().enumerate() {
        let row = match coordinate {
            Coordinate::White => 0,
            Coordinate::Deviation => 1,
            Coordinate::Tau => 2,
        };
        follows[(row, first + k)] = 1.0;
    }
    let all = &follows * covariance * follows.transpose();
    for (i, row) in out.iter_mut().enumerate() {
        for (j, slot) in row.iter_mut().enumerate() {
            *slot = all[(i, j)];
        }
    }
    Ok(out)
}

/// Every source of scatter with its part of the covariance.
pub(super) fn noise(
    campaign: &Campaign,
    question: &Question,
    shape: &Shape,
    uncertain: &Uncertain,
    solved: &Together,
    (at_zero, rows): (&[bool], &[u64]),
) -> ScatterSources {
    let n = question.unknowns;
    let mut sources: Vec<StreamedSource> = Vec::new();
    // places in the covariance of estimated variances: sensor and which of its logarithms
    let mut components: Vec<(usize, usize)> = Vec::new();
    let mut leans = Vec::new();
    let mut determined = true;
    let mut over = Vec::new();
    for (s, own) in question.sensors.iter().enumerate().filter(|(s, _)| question.is_read(*s)) {
        let (size, t) = (shape.noise[s], solved.scale[s]);
        let levels = crate::number::index(rows[s]);
        let white_free = question.is_white_free(s);
        let mut component = |free: bool, which: usize| {
            free.then(|| {
                components.push((s, which));
                components.len() - 1
            })
        };
        let whole = solved.shares[s].clone();
        let white = match &uncertain.deviation[s] {
            Some(deviation) => &whole - deviation,
            None => whole,
        };
        determined &= !white_free || solved.redundancy[s] > 0.0;
        sources.push(StreamedSource {
            name: format!("readings of {}", campaign.bench.sensors.get(s).map_or("", |own| own.id.as_str())),
            evaluation: Evaluation::TypeA,
            variance: if white_free { size.white * size.white * t } else { 1.0 },
            share: white,
            line: None,
            state: if white_free { LineState::Estimated } else { LineState::Stated },
            tau: None,
            levels,
            dof: f64::INFINITY,
            component: component(white_free, 0),
        });
        let Some((line, _)) = own.line else { continue };
        let deviation_free = shape.coordinates[s].contains(&Coordinate::Deviation);
        let tau_free = shape.coordinates[s].contains(&Coordinate::Tau);
        let is_stated = !matches!(campaign.scatter.get(line).map(|own| &own.size), Some(campaign::Size::Estimated));
        let dof = match campaign.scatter.get(line).map(|own| &own.size) {
            Some(campaign::Size::Stated { dof, .. }) => *dof,
            _ => f64::INFINITY,
        };
        let u_tau = (uncertain.logarithms[s][2][2]).sqrt() * size.tau;
        over.push(StreamedSource {
            name: campaign.scatter.get(line).map_or(String::new(), |own| own.name(campaign)),
            evaluation: if is_stated { Evaluation::TypeB } else { Evaluation::TypeA },
            variance: size.deviation * size.deviation * if shape.open[s] { t } else { 1.0 },
            share: uncertain.deviation[s].clone().unwrap_or_else(|| Mat::zeros(n, n)),
            line: Some(line),
            state: if at_zero[s] {
                LineState::AtZero
            } else if is_stated {
                LineState::Stated
            } else {
                LineState::Estimated
            },
            tau: (!at_zero[s]).then_some((size.tau, (tau_free && u_tau.is_finite()).then_some(u_tau))),
            levels,
            dof,
            component: component(deviation_free, 1),
        });
        if let (true, Some(lean)) = (tau_free, &uncertain.lean[s]) {
            components.push((s, 2));
            leans.push((components.len() - 1, lean.clone()));
        }
    }
    if !question.priors.is_empty() {
        let c = &solved.folded.unknowns.cofactor;
        let mut share = Mat::zeros(n, n);
        for (k, _, u) in &question.priors {
            for i in 0..n {
                for j in 0..n {
                    share[(i, j)] += c[(i, *k)] * c[(*k, j)] / (u * u);
                }
            }
        }
        sources.push(StreamedSource {
            name: "priors".into(),
            evaluation: Evaluation::TypeB,
            variance: 1.0,
            share,
            line: None,
            state: LineState::Stated,
            tau: None,
            levels: question.priors.len(),
            dof: f64::INFINITY,
            component: None,
        });
    }
    sources.extend(over);
    // a variance is the square of a standard deviation: twice its logarithm
    let by = |which: usize| if which == 2 { 1.0 } else { 2.0 };
    let spread = Mat::from_fn(components.len(), components.len(), |a, b| {
        let ((s, i), (r, j)) = (components[a], components[b]);
        if s == r { by(i) * by(j) * uncertain.logarithms[s][i][j] } else { 0.0 }
    });
    ScatterSources::streamed(sources, solved.folded.unknowns.cofactor.clone(), spread, leans, determined)
}
