//! Variances by restricted maximum likelihood.
//!
//! Fisher's steps `S (t - 1) = squares - redundancy` on the factors `t` of the variances, Newton's near the end; a step that lowers the
//! restricted likelihood is halved. A variance that the likelihood draws below what could be seen is zero. H. D. Patterson, R. Thompson 1971;
//! the start needs no guess: a deviation as large as the noise of what feels it.
//!
//! A variance estimated as zero is not known to be zero. Intervals that take it for zero pool its few degrees of freedom with the many of the
//! noise, and are too short wherever it is small but present. So the search then goes on below zero, as far as `V` is a covariance, and `u` and
//! dof come from there: in a balanced design that is the mean square that the parameter's own comparison has, with its own degrees of freedom,
//! and Student's interval is exact whatever the true variance (W. W. Stroup, R. C. Littell, "Impact of variance component estimates on fixed
//! effect inference in unbalanced linear mixed models", 2002; the NOBOUND of R. C. Littell et al., SAS for Mixed Models, 2006). What is reported
//! as the variance stays the restricted one.
#![allow(
    clippy::indexing_slicing,
    reason = "`theta`, `kept`, `at_floor`, `could_be` and the inference are all over the `members.count` components of one problem"
)]

use super::inference::Inference;
use super::problem::{Point, Problem, UNSEEN, step};
use super::{LineState, ScatterLine};
use crate::error::{Fault, Malformed, Result};

/// How far the iteration goes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    pub steps: usize,
    /// Relative change of every variance at which it ends.
    pub settled: f64,
}

/// To the last digits.
pub(super) const FULL: Limits = Limits { steps: 200, settled: 1e-11 };
/// Largest factor of one step.
const LEAP: f64 = 30.0;
/// Changes that are no longer halved, and smaller than this, are the rounding of the sums.
const ROUNDING: f64 = 1e-7;

/// Where the iteration ended.
pub(super) struct Ended {
    pub theta: Vec<f64>,
    pub point: Point,
    pub inference: Inference,
    /// Components that the rows tell apart.
    pub kept: Vec<usize>,
    /// Components that are zero, and have none of the spread of the others.
    pub at_floor: Vec<bool>,
    /// What the lines at zero are in the restricted estimate, where the search went on below.
    pub restricted: Option<Vec<f64>>,
    /// The standard deviation that each component at zero could have.
    pub could_be: Vec<Option<f64>>,
    /// The likelihood rises below zero, and the search came to where the variances are no covariance any more before a top.
    pub is_open: bool,
    pub iterations: usize,
    pub converged: bool,
}

impl Problem<'_> {
    /// From a start (empty: none) to the variances.
    pub fn solve(&mut self, start: &[f64], limits: Limits) -> Result<Ended> {
        let cold = start.len() != self.members.count;
        let mut theta = if cold { self.start()? } else { start.to_vec() };
        let mut point = self.at_or_fail(&theta)?;
        let mut inference = self.inference(&point);
        let mut kept = self.separated(&inference);
        // what the start had found inseparable stays so
        kept.retain(|g| cold || theta[*g] != 0.0);
        for (component, state) in self.component.iter().zip(&mut self.state) {
            if let Some(c) = component.filter(|c| !kept.contains(c)) {
                theta[c] = 0.0;
                *state = LineState::Inseparable;
            }
        }
        for g in (0..self.groups).filter(|g| !kept.contains(g)) {
            theta[g] = 1.0;
        }
        if kept.len() < self.members.count {
            point = self.at_or_fail(&theta)?;
            inference = self.inference(&point);
        }
        let at_floor = vec![false; self.members.count];
        let could_be = vec![None; self.members.count];
        let mut ended = Ended {
            theta,
            point,
            inference,
            kept,
            at_floor,
            restricted: None,
            could_be,
            is_open: false,
            iterations: 0,
            converged: false,
        };
        self.iterate(&mut ended, limits)?;
        let zero: Vec<usize> = self.component.iter().flatten().copied().filter(|c| ended.at_floor[*c]).collect();
        for c in &zero {
            let spread = (2.0 / ended.inference.s[(*c, *c)]).sqrt();
            ended.could_be[*c] = Some((ended.theta[*c].abs() * spread).sqrt()).filter(|sd| sd.is_finite());
        }
        if !zero.is_empty() && ended.converged && self.pattern.is_simple {
            self.below_zero(&mut ended, &zero, limits)?;
        }
        for (component, state) in self.component.iter().zip(&mut self.state) {
            if component.is_some_and(|c| zero.contains(&c) || ended.at_floor[c]) {
                *state = LineState::AtZero;
            }
        }
        Ok(ended)
    }

    pub(super) fn at_or_fail(&self, theta: &[f64]) -> Result<Point> {
        self.at(theta)?.ok_or_else(|| {
            Malformed::new(Fault::Value, "the variances of the random effects are not a covariance matrix")
        })
    }

    /// Steps from where `ended` is; a component keeps its sign.
    fn iterate(&self, ended: &mut Ended, limits: Limits) -> Result<()> {
        let Ended { theta, point, inference, kept, at_floor, iterations, converged, .. } = ended;
        (*iterations, *converged) = (0, kept.is_empty());
        let mut before = f64::INFINITY;
        while !*converged && *iterations < limits.steps {
            crate::stop::poll();
            *iterations += 1;
            let floor = self.floors(theta);
            for g in kept.iter() {
                // a floor may rise with the noise of the rows; released where the likelihood grows upwards
                at_floor[*g] =
                    theta[*g].abs() <= floor[*g] * (1.0 + 1e-9) && inference.squares[*g] <= inference.redundancy[*g];
            }
            let free: Vec<usize> = kept.iter().copied().filter(|g| !at_floor[*g]).collect();
            let change = step(inference, &free, LEAP);
            let largest = change.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
            let rounding = largest < ROUNDING && largest > 0.5 * before;
            before = largest;
            if largest <= limits.settled || rounding || free.is_empty() {
                *converged = true;
                break;
            }
            // shares of a step on the scale of logarithms
            let factor: Vec<f64> = change.iter().map(|c| 1.0 + c).collect();
            let mut share = 1.0;
            loop {
                let mut trial = theta.clone();
                for (g, t) in free.iter().zip(&factor) {
                    let size = (theta[*g].abs() * t.powf(share)).max(floor[*g]).max(f64::MIN_POSITIVE);
                    trial[*g] = size.copysign(theta[*g]);
                }
                if let Some(next) = self.at(&trial)? {
                    let room = 1e-10 * (1.0 + point.deviance.abs());
                    let better = next.deviance <= point.deviance + room || next.basis != point.basis;
                    if better || share < 1e-3 || !next.deviance.is_finite() {
                        (*theta, *point) = (trial, next);
                        break;
                    }
                } else if share < 1e-6 {
                    return Ok(());
                }
                share *= 0.5;
            }
            *inference = self.inference(point);
        }
        Ok(())
    }

    /// Go on below zero with components that the restricted likelihood leaves there.
    fn below_zero(&self, ended: &mut Ended, zero: &[usize], limits: Limits) -> Result<()> {
        let memory = |c: &usize| {
            let own = |(line, own): (&ScatterLine, &Option<usize>)| *own == Some(*c) && line.memory.is_none();
            self.lines.iter().zip(&self.component).any(own)
        };
        let open: Vec<usize> = zero.iter().copied().filter(memory).collect();
        let mut share = 0.1;
        let (theta, point) = loop {
            let mut theta = ended.theta.clone();
            for (line, component) in self.lines.iter().zip(&self.component) {
                if let Some(c) = component.filter(|c| open.contains(c)) {
                    theta[c] = -share * self.natural(line, &ended.theta);
                }
            }
            match self.at(&theta)? {
                Some(point) if point.deviance < ended.point.deviance => break (theta, point),
                _ if open.is_empty() || share < 10.0 * UNSEEN => return Ok(()),
                _ => share *= 0.2,
            }
        };
        let inference = self.inference(&point);
        let mut further = Ended {
            theta,
            point,
            inference,
            kept: ended.kept.clone(),
            at_floor: ended.at_floor.clone(),
            restricted: Some(ended.theta.clone()),
            could_be: ended.could_be.clone(),
            is_open: false,
            iterations: 0,
            converged: false,
        };
        self.iterate(&mut further, limits)?;
        further.iterations += ended.iterations;
        match further.converged {
            true => *ended = further,
            false => ended.is_open = true,
        }
        Ok(())
    }
}
