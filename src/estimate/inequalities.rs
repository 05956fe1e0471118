//! Bounds, ranges and norm cones on the unknowns of an adjusted system.
//!
//! With the free estimate `x^` and `x = x^ + T v`, `T = D^-1 R^-1`, the sum of squares is that of `x^` plus `|v|^2`: the constrained
//! estimate is the point of the feasible set that is nearest to the origin of `v`. An estimate that satisfies every constraint is
//! returned as it is. Deliberately absent: constraints that would make a rank defect look determined.
#![allow(
    clippy::indexing_slicing,
    reason = "`restrict` refuses inequalities about unknowns that the estimate has not; sides are numbered by `add` itself"
)]

use crate::vocabulary::vocabulary;

use super::cone_program::{Answer, Face, nearest, polish};
use super::{Equation, Estimate, System};
use faer::Mat;

/// Something that must hold for the unknowns `x` of a system.
#[derive(Debug, Clone, PartialEq)]
pub enum Inequality {
    /// `lower <= sum c_j x_j <= upper`; infinite where there is no bound.
    Range {
        /// Unknown and coefficient.
        terms: Vec<(usize, f64)>,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// `sqrt(sum (from_j + x_j)^2) <= at_most`.
    Norm {
        /// Unknowns, each with the value from which it counts.
        of: Vec<(usize, f64)>,
        /// Largest norm.
        at_most: f64,
    },
}

impl Inequality {
    /// The equation that holds where this side is active, to first order about this solution.
    pub(crate) fn face(&self, side: Side, solution: &[f64]) -> Equation {
        match self {
            Inequality::Range { terms, lower, upper } => {
                Equation { terms: terms.clone(), value: if side == Side::Lower { *lower } else { *upper } }
            }
            Inequality::Norm { of, at_most } => {
                let normal = of.iter().map(|(j, from)| (*j, (from + solution[*j]) / at_most));
                let terms: Vec<(usize, f64)> = normal.collect();
                let value = terms.iter().map(|(j, c)| c * solution[*j]).sum();
                Equation { terms, value }
            }
        }
    }
}

vocabulary! {
    /// Which side of a constraint is active.
    Side {
        /// The lower bound.
        Lower = "lower",
        /// The upper bound.
        Upper = "upper",
        /// The surface of a norm cone.
        Norm = "norm",
    }
}

/// An active constraint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Active {
    /// Index of the inequality.
    pub inequality: usize,
    /// Which side.
    pub side: Side,
    /// Decrease of the sum of squares for each unit by which the bound gives way.
    pub multiplier: f64,
    /// By how much the sum of squares would be smaller without this constraint (the others kept).
    pub cost: f64,
}

/// The constrained estimate.
#[derive(Debug, Clone)]
pub enum Restricted {
    /// The constrained minimum.
    Found {
        /// The unknowns, `n`; those of the free estimate where nothing is active.
        solution: Vec<f64>,
        /// Active constraints.
        active: Vec<Active>,
        /// By how much the constraints raise the sum of squares.
        cost: f64,
        /// First-order covariance of the constrained estimate, `n x n`: on the active face, curvature of norm cones included.
        covariance: Mat<f64>,
    },
    /// No values satisfy all; each of these inequalities is needed for the contradiction.
    Infeasible(Vec<usize>),
    /// The readings do not determine all unknowns, a constraint is about an unknown which the estimate has not, or the solver failed: the
    /// constraints were not applied.
    NotApplied,
}

/// Restrict an estimate to inequalities; sums of squares are in the units of `system.u` with estimated scales of several groups included.
///
/// ```
/// use tumble::estimate::{Group, Inequality, Restricted, Settings, System, adjust, restrict};
/// let system = System { rows: faer::mat![[1.0], [1.0]], observed: vec![2.0, 4.0], u: vec![1.0; 2], group: vec![Group::Known; 2] };
/// let mean = adjust(&system, &Settings::default())?;
/// let bound = Inequality::Range { terms: vec![(0, 1.0)], lower: f64::NEG_INFINITY, upper: 2.5 };
/// let Restricted::Found { solution, active, cost, .. } = restrict(&system, &mean, &[bound]) else { panic!() };
/// assert_eq!(solution, vec![2.5]);
/// assert!((cost - 0.5).abs() < 1e-12 && (active[0].multiplier - 2.0).abs() < 1e-12);
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
pub fn restrict(system: &System, estimate: &Estimate, inequalities: &[Inequality]) -> Restricted {
    let free = |x: &[f64]| Restricted::Found {
        solution: x.to_vec(),
        active: Vec::new(),
        cost: 0.0,
        covariance: estimate.unknowns.covariance.clone(),
    };
    if inequalities.is_empty() {
        return free(&estimate.unknowns.solution);
    }
    let unknowns = estimate.unknowns.solution.len();
    let is_of_another = |inequality: &Inequality| match inequality {
        Inequality::Range { terms: list, .. } | Inequality::Norm { of: list, .. } => {
            list.iter().any(|(j, _)| *j >= unknowns)
        }
    };
    if !estimate.unknowns.not_estimable.is_empty() || inequalities.iter().any(is_of_another) {
        return Restricted::NotApplied;
    }
    let along = estimate.factor.whitened_directions();
    let mut problem = match Problem::new(&estimate.unknowns.solution, &along, inequalities) {
        Ok(problem) => problem,
        Err(alone) => return Restricted::Infeasible(vec![alone]),
    };
    if problem.is_met() {
        return free(&estimate.unknowns.solution);
    }
    // without degrees of freedom no violation is within the noise
    let scale_estimated = system.is_of_one_scale();
    problem.rescale(if scale_estimated { estimate.residual_sd().unwrap_or(0.0) } else { 1.0 } * 1e-6);
    problem.solve(estimate, scale_estimated)
}

/// Inequalities about unknowns, and the metric in which an estimate is carried to the nearest values that meet them.
#[derive(Debug, Clone)]
pub struct Bounds {
    /// A root of the covariance of the unknowns, unknowns x rank.
    pub along: Mat<f64>,
    /// What must hold for the unknowns.
    pub inequalities: Vec<Inequality>,
}

impl Bounds {
    /// Carry unknowns, which are the first of these values, to the nearest ones that meet all; did any bound hold them back? Not-a-number where no
    /// values were found.
    pub(crate) fn hold(&self, values: &mut [f64]) -> bool {
        let free = values.get(..self.along.nrows()).unwrap_or_default();
        let problem = Problem::new(free, &self.along, &self.inequalities).ok();
        if problem.as_ref().is_some_and(Problem::is_met) {
            return false;
        }
        let held = problem.and_then(|mut problem| {
            problem.rescale(0.0);
            let (faces, start) = (problem.faces(), vec![0.0; self.along.ncols()]);
            let found = polish(&faces, &[], &start).or_else(|| match nearest(start.len(), &faces) {
                Answer::Nearest { v, active } => polish(&faces, &active, &v),
                _ => None,
            })?;
            Some(problem.at(&found.v))
        });
        match held {
            Some(held) => values.iter_mut().zip(held).for_each(|(value, held)| *value = held),
            None => values.fill(f64::NAN),
        }
        true
    }
}

/// A face and where it comes from.
#[derive(Debug, Clone)]
struct Sided {
    inequality: usize,
    side: Side,
    /// Factor from the face's own measure to the unit of the bound.
    size: f64,
    face: Face,
}

/// The whitened question.
struct Problem<'a> {
    free: &'a [f64],
    along: &'a Mat<f64>,
    unit: f64,
    sides: Vec<Sided>,
}

impl<'a> Problem<'a> {
    /// The inequalities about an estimate; or one of them that contradicts what is fixed already.
    fn new(free: &'a [f64], along: &'a Mat<f64>, inequalities: &[Inequality]) -> Result<Self, usize> {
        let mut problem = Problem { free, along, unit: 1.0, sides: Vec::new() };
        match inequalities.iter().enumerate().find(|(k, inequality)| !problem.add(*k, inequality)) {
            Some((k, _)) => Err(k),
            None => Ok(problem),
        }
    }

    /// Does the estimate meet all?
    fn is_met(&self) -> bool {
        let origin = vec![0.0; self.along.ncols()];
        !self.sides.iter().any(|side| side.face.violation(&origin) > 0.0)
    }

    fn faces(&self) -> Vec<Face> {
        self.sides.iter().map(|side| side.face.clone()).collect()
    }

    /// The unknowns at `v`.
    fn at(&self, v: &[f64]) -> Vec<f64> {
        let mut solution = self.free.to_vec();
        for (l, v) in v.iter().enumerate() {
            for (x, t) in solution.iter_mut().zip(self.along.col_as_slice(l)) {
                *x += t * v * self.unit;
            }
        }
        solution
    }

    /// Add an inequality; false if it contradicts what is fixed already.
    fn add(&mut self, k: usize, inequality: &Inequality) -> bool {
        let rank = self.along.ncols();
        match inequality {
            Inequality::Range { terms, lower, upper } => {
                let value: f64 = terms.iter().map(|(j, c)| c * self.free[*j]).sum();
                let reach: f64 = terms.iter().map(|(j, c)| (c * self.free[*j]).abs()).sum();
                let mut normal: Vec<f64> =
                    (0..rank).map(|l| terms.iter().map(|(j, c)| c * self.along[(*j, l)]).sum()).collect();
                let parts: f64 = terms
                    .iter()
                    .map(|(j, c)| c.abs() * (0..rank).map(|l| self.along[(*j, l)].powi(2)).sum::<f64>().sqrt())
                    .sum();
                let size = normal.iter().map(|b| b * b).sum::<f64>().sqrt();
                if size <= 1e-13 * parts || size == 0.0 {
                    // fixed by the equations
                    let room = 1e-9 * reach.max(value.abs());
                    return value >= lower - room && value <= upper + room;
                }
                normal.iter_mut().for_each(|b| *b /= size);
                if upper.is_finite() {
                    let face = Face::Plane { normal: normal.clone(), limit: (upper - value) / size };
                    self.sides.push(Sided { inequality: k, side: Side::Upper, size, face });
                }
                if lower.is_finite() {
                    normal.iter_mut().for_each(|b| *b = -*b);
                    let face = Face::Plane { normal, limit: (value - lower) / size };
                    self.sides.push(Sided { inequality: k, side: Side::Lower, size, face });
                }
            }
            Inequality::Norm { of, at_most } => {
                let at = of.iter().map(|(j, from)| (from + self.free[*j]) / at_most).collect();
                let along = Mat::from_fn(of.len(), rank, |i, l| self.along[(of[i].0, l)] / at_most);
                let face = Face::Ball { along, at };
                self.sides.push(Sided { inequality: k, side: Side::Norm, size: *at_most, face });
            }
        }
        true
    }

    /// Measure `v` in the largest violation, and no less than this.
    fn rescale(&mut self, least: f64) {
        let violation = |side: &Sided| match &side.face {
            Face::Plane { limit, .. } => (-limit).max(0.0),
            // from outside a ball, the distance in v is not known; a length that brings its coordinates to order one
            Face::Ball { along, at } => {
                let steepest = along.col_iter().map(|c| c.norm_l2()).fold(0.0_f64, f64::max);
                let norm = at.iter().map(|x| x * x).sum::<f64>().sqrt();
                if steepest > 0.0 { (norm - 1.0).max(0.0) / steepest } else { 0.0 }
            }
        };
        let unit = self.sides.iter().map(violation).fold(least, f64::max);
        self.unit = unit;
        for side in &mut self.sides {
            match &mut side.face {
                Face::Plane { limit, .. } => *limit /= unit,
                Face::Ball { along, .. } => *along *= faer::Scale(unit),
            }
        }
    }

    fn solve(&self, estimate: &Estimate, scale_estimated: bool) -> Restricted {
        let size = self.along.ncols();
        let faces = self.faces();
        let (start, guess) = match nearest(size, &faces) {
            Answer::Nearest { v, active } => (v, active),
            Answer::Infeasible(involved) => return self.infeasible(&involved),
            Answer::Unsolved => (vec![0.0; size], Vec::new()),
        };
        let Some(polished) = polish(&faces, &guess, &start) else { return Restricted::NotApplied };
        let square = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>();
        let cost = square(&polished.v) * self.unit * self.unit;
        let solution = self.at(&polished.v);
        let mut active = Vec::new();
        for (k, multiplier) in &polished.active {
            let side = &self.sides[*k];
            let others: Vec<Face> =
                self.sides.iter().filter(|s| s.inequality != side.inequality).map(|s| s.face.clone()).collect();
            let without = if polished.active.len() == 1 {
                0.0
            } else {
                match nearest(size, &others) {
                    Answer::Nearest { v, active } => polish(&others, &active, &v).map_or(square(&v), |p| square(&p.v)),
                    _ => 0.0,
                }
            };
            let multiplier = match side.side {
                // d(|v|^2)/d limit; a ball's limit is its radius, of which `size` is one
                Side::Norm => 2.0 * multiplier * self.unit * self.unit / side.size,
                _ => 2.0 * multiplier * self.unit / side.size,
            };
            let cost = (cost - without * self.unit * self.unit).max(0.0);
            active.push(Active { inequality: side.inequality, side: side.side, multiplier, cost });
        }
        active.sort_by_key(|a| a.inequality);
        let moved = self.along * &polished.follows;
        let mut covariance = &moved * moved.transpose();
        if scale_estimated {
            // without degrees of freedom the cofactor stays: no u is told then
            covariance *= faer::Scale(estimate.residual_sd().unwrap_or(1.0).powi(2));
        }
        Restricted::Found { solution, active, cost, covariance }
    }

    /// The smallest contradiction among the faces that carry the certificate: each in turn is left out if the rest still contradict.
    fn infeasible(&self, involved: &[usize]) -> Restricted {
        let contradict = |kept: &[usize]| {
            let faces: Vec<Face> = kept.iter().map(|k| self.sides[*k].face.clone()).collect();
            matches!(nearest(self.along.ncols(), &faces), Answer::Infeasible(_))
        };
        let all: Vec<usize> = (0..self.sides.len()).collect();
        let mut kept = if contradict(involved) { involved.to_vec() } else { all };
        let mut at = 0;
        while at < kept.len() {
            let mut fewer = kept.clone();
            fewer.remove(at);
            if contradict(&fewer) {
                kept = fewer;
            } else {
                at += 1;
            }
        }
        let mut named: Vec<usize> = kept.iter().map(|k| self.sides[*k].inequality).collect();
        named.sort_unstable();
        named.dedup();
        Restricted::Infeasible(named)
    }
}
