//! The unknowns over the whole restricted likelihood of the variances, where its top says nothing of some of them.
//!
//! ```text
//! p(x | y) = sum over nodes of  L_R(theta) J(theta) p(x | theta, y),      J = sqrt(det S), S_gh = tr(P V_g P V_h)
//! ```
//!
//! Below one degree of freedom Student's distribution has no mean, and what Satterthwaite, Kenward and Roger make of the top of the likelihood may
//! be of any size: mountings with unequal numbers of readings whose variance is estimated below zero, a correlation time as long as the record. The
//! sum over variances and correlation times is of the size of the errors there. Variances go as far below zero as deviations of their line alone leave
//! the rows a covariance, so that in a balanced design the sum is Student's interval of the mean square that belongs to the unknown.
//! `J` is H. Jeffreys' prior of the variances, at each correlation time, of which the logarithm is flat: without it a deviation along time that is estimated
//! as zero would keep all its weight there. A scale common to all that scatters is integrated out. G. E. P. Box, G. C.
//! Tiao, Bayesian Inference in Statistical Analysis, 1973, chapters 2 and 5. Nodes follow R. Richtmyer's sequence (square roots of primes).
#![allow(
    clippy::indexing_slicing,
    reason = "`theta`, `component` and likelihoods are over the components and lines of one problem; axes hold numbers of these"
)]

use super::condense::Condensed;
use super::problem::{Point, Problem};
use super::{remember, time};
use crate::error::{Fault, Malformed, Result};
use crate::linear::form;
use faer::linalg::solvers::Solve;
use faer::{Mat, Scale, Side};
use std::borrow::Cow;

/// Nodes of a look, along one axis and along more: first everywhere, then where the likelihood is.
const NODES: (usize, usize) = (60, 400);
/// Where fewer than this count for each axis (with five axes 400 nodes may leave the sum to a few), as many again are drawn about what was seen
/// (O. Cappe, A. Guillin, J.-M. Marin, C. Robert, Population Monte Carlo, J. Comp. Graph. Stat. 13 (2004), 907). N nodes that count leave an interval a relative error of
/// about `1/sqrt(2 N)`: 11 % with two axes, 7 % with five.
const ENOUGH: f64 = 20.0;
/// Such draws at most: each costs what the first look does, and one that brings no more nodes that count is the last.
const LOOKS: usize = 4;
/// So many nodes for each axis tell the covariance of the next ones, which has half as many numbers for each of up to seven axes.
const FEWEST: f64 = 4.0;
/// A node with less than this of the largest weight is outside.
const OUTSIDE: f64 = 1e-8;
/// From this share of the noise to this multiple, or of what was estimated: with one degree of freedom the tail falls as the root of the variance, and
/// 1e-4 of the probability is beyond.
const REACH: (f64, f64) = (1e-3, 1e8);
/// Weights below this are left out.
const SLIGHT: f64 = 1e-12;

/// A sum of distributions of the unknowns.
#[derive(Debug, Clone)]
pub struct Mixture {
    /// Each with its weight; their sum is 1.
    pub nodes: Vec<Node>,
    /// Degrees of freedom of each Student distribution; infinite for normal ones.
    pub dof: f64,
}

/// The unknowns at some variances.
#[derive(Debug, Clone)]
pub struct Node {
    /// Its probability.
    pub weight: f64,
    /// How far the solution is from the one at the top of the likelihood.
    pub shift: Vec<f64>,
    /// Covariance of the unknowns.
    pub covariance: Mat<f64>,
}

impl Node {
    /// The first `n` unknowns where those behind them are zero: the conditional distribution `x - S_xz S_zz^-1 z`, `S_xx - S_xz S_zz^-1 S_zx`.
    ///
    /// Errors: a covariance of the unknowns behind them that is none.
    pub(crate) fn given(&self, n: usize) -> Result<Node> {
        let conditional = conditional(&self.covariance, n)?;
        let shift = conditional.transpose() * Mat::from_fn(self.shift.len(), 1, |i, _| self.shift[i]);
        let covariance = conditional.transpose() * &self.covariance * &conditional;
        Ok(Node { weight: self.weight, shift: shift.col_as_slice(0).to_vec(), covariance })
    }
}

/// What the first `n` of normal variables are where those behind them are zero, as a combination `P' x` of all: `P' = [I, -S_xz S_zz^-1]`.
///
/// Errors: a covariance of the variables behind them that is none.
pub(super) fn conditional(covariance: &Mat<f64>, n: usize) -> Result<Mat<f64>> {
    let k = covariance.nrows().saturating_sub(n);
    let behind = covariance.submatrix(n, n, k, k).llt(Side::Lower);
    let behind = behind.map_err(|_| Malformed::new(Fault::Value, "the known inputs have no covariance"))?;
    let by = behind.solve(covariance.submatrix(n, 0, k, n));
    Ok(Mat::from_fn(n + k, n, |i, j| if i < n { f64::from(u8::from(i == j)) } else { -by[(i - n, j)] }))
}

/// What the sum runs along.
enum Axis {
    /// `ln(theta + below)` of a component.
    Component { component: usize, below: f64, range: (f64, f64) },
    /// Logarithm of the correlation time of a line.
    Time { line: usize, range: (f64, f64) },
}

/// A node that was looked at: the logarithm of its weight, and where it is on each axis, from 0 to 1.
struct Seen {
    weight: f64,
    place: Vec<f64>,
    node: Node,
}

impl Axis {
    fn at(&self, share: f64) -> f64 {
        let (Axis::Component { range, .. } | Axis::Time { range, .. }) = self;
        range.0 + share * (range.1 - range.0)
    }
}

/// Where the nodes of a look are.
enum Draw {
    /// Evenly in a part of each axis.
    Box(Vec<(f64, f64)>),
    /// About a mean, in directions of the covariance of what was seen: logistic, whose tails are longer than those of a normal distribution.
    About { mean: Vec<f64>, root: Mat<f64> },
}

impl Draw {
    /// About the nodes that were seen: their weights to the power at which `FEWEST` of each axis count.
    fn about(seen: &[Seen], axes: usize) -> Option<Draw> {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..30 {
            let middle = 0.5 * (low + high);
            if effective(seen, middle) > FEWEST * axes as f64 { low = middle } else { high = middle }
        }
        let most = heaviest(seen);
        let weights: Vec<f64> = seen.iter().map(|own| (low * (own.weight - most)).exp()).collect();
        let all: f64 = weights.iter().sum();
        let average = |of: &dyn Fn(&Seen) -> f64| -> f64 {
            seen.iter().zip(&weights).map(|(own, weight)| weight * of(own)).sum::<f64>() / all
        };
        let mean: Vec<f64> = (0..axes).map(|a| average(&|own| own.place[a])).collect();
        let spread = Mat::from_fn(axes, axes, |a, b| {
            average(&|own| (own.place[a] - mean[a]) * (own.place[b] - mean[b])) * if a == b { 1.0 + 1e-6 } else { 1.0 }
        });
        let root = spread.llt(Side::Lower).ok()?.L().to_owned();
        // of unit variance: the logistic distribution has that of pi^2/3
        Some(Draw::About { mean, root: root * Scale(3.0_f64.sqrt() / std::f64::consts::PI) })
    }

    /// The place of a point of the unit cube, and the logarithm of the density there.
    fn at(&self, cube: &[f64]) -> (Vec<f64>, f64) {
        match self {
            Draw::Box(within) => {
                (within.iter().zip(cube).map(|((low, high), u)| low + (high - low) * u).collect(), 0.0)
            }
            Draw::About { mean, root } => {
                let logistic: Vec<f64> = cube.iter().map(|u| (u / (1.0 - u)).ln()).collect();
                let place = mean.iter().enumerate().map(|(a, mean)| {
                    mean + logistic.iter().take(a + 1).enumerate().map(|(b, z)| root[(a, b)] * z).sum::<f64>()
                });
                let density = cube.iter().map(|u| (u * (1.0 - u)).ln()).sum();
                (place.collect(), density)
            }
        }
    }
}

fn heaviest(seen: &[Seen]) -> f64 {
    seen.iter().fold(f64::NEG_INFINITY, |most, own| most.max(own.weight))
}

/// How many nodes of equal weight would tell as much, of weights to a power.
fn effective(seen: &[Seen], power: f64) -> f64 {
    let most = heaviest(seen);
    let weights = seen.iter().map(|own| (power * (own.weight - most)).exp());
    let (once, twice) = weights.fold((0.0, 0.0), |(once, twice), w| (once + w, twice + w * w));
    if twice > 0.0 { once * once / twice } else { 0.0 }
}

/// The prime number that so many are before, 2 the first, counted from 1.
fn prime(number: usize) -> f64 {
    let is_prime = |p: &u32| (2..*p).all(|d| !p.is_multiple_of(d));
    (2_u32..).filter(is_prime).nth(number.saturating_sub(1)).map_or(2.0, f64::from)
}

impl Mixture {
    /// Weight, shift and standard deviation of a linear function of the unknowns.
    pub(crate) fn along(&self, along: &[f64]) -> Vec<(f64, f64, f64)> {
        let one = |node: &Node| {
            let shift: f64 = node.shift.iter().zip(along).map(|(x, c)| x * c).sum();
            (node.weight, shift, form(&node.covariance, along).max(0.0).sqrt())
        };
        self.nodes.iter().map(one).collect()
    }

    /// Of the first unknowns where those behind them are zero, as stated. `top` are all unknowns at the top of the likelihood, `own` the first of them
    /// where the others are zero there. Errors: those of [`Node::given`].
    pub(super) fn of_first(&self, top: &[f64], own: &[f64]) -> Result<Mixture> {
        let of = |node: &Node| -> Result<Node> {
            let shift = top.iter().zip(&node.shift).map(|(x, shift)| x + shift).collect();
            let mut found = Node { shift, ..node.clone() }.given(own.len())?;
            found.shift.iter_mut().zip(own).for_each(|(x, own)| *x -= own);
            Ok(found)
        };
        Ok(Mixture { nodes: self.nodes.iter().map(of).collect::<Result<_>>()?, dof: self.dof })
    }

    /// Mean covariance of the unknowns, with what their solutions differ.
    pub fn covariance(&self) -> Mat<f64> {
        let size = self.nodes.first().map_or(0, |node| node.covariance.nrows());
        let mut sum = Mat::zeros(size, size);
        for node in &self.nodes {
            let own = Mat::from_fn(size, size, |i, j| node.covariance[(i, j)] + node.shift[i] * node.shift[j]);
            sum += own * Scale(node.weight);
        }
        sum
    }
}

impl Problem<'_> {
    /// Over the components in `kept` and the correlation times that `timed` estimated; `top` is the adjustment at the variances `theta`.
    ///
    /// `None` where there is nothing to sum over, or no node has a likelihood.
    pub(super) fn summed(
        &self,
        top: &Point,
        theta: &[f64],
        kept: &[usize],
        timed: &time::Timed,
    ) -> Result<Option<Mixture>> {
        if (0..self.groups).any(|g| !kept.contains(&g)) {
            return Ok(None);
        }
        let fewer = if timed.found.is_empty() { Condensed::new(self) } else { None };
        let small = fewer.as_ref().map(|fewer| self.on(fewer, false)).transpose()?;
        let problem = small.as_ref().unwrap_or(self);
        // one scale for all that scatters
        let grouped = self.members.rows.iter().all(Option::is_some);
        let common = self.groups > 0 && grouped && self.lines.iter().all(|line| line.variance.is_none());
        let axes = self.axes(theta, &kept[usize::from(common)..], timed);
        if axes.is_empty() {
            return Ok(None);
        }
        let left_out: f64 = problem.left_out.rows.iter().sum();
        let dof = problem.system.observed.len() as f64 + left_out - top.basis.len() as f64;
        let count = if axes.len() == 1 { NODES.0 } else { NODES.1 };
        let look = |draw: &Draw| problem.nodes(&axes, draw, count, (top, theta), kept, common.then_some(dof));
        let first = look(&Draw::Box(vec![(0.0, 1.0); axes.len()]))?;
        let most = heaviest(&first);
        // the box of what counts, and a step more on each side
        let step = 1.0 / (count as f64).powf(1.0 / axes.len() as f64);
        let within = |a: usize| {
            let inside = first.iter().filter(|own| (own.weight - most).exp() > OUTSIDE).map(|own| own.place[a]);
            let (low, high) = inside.fold((1.0_f64, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
            ((low - step).max(0.0), (high + step).min(1.0))
        };
        let mut found = look(&Draw::Box((0..axes.len()).map(within).collect()))?;
        for _ in 0..LOOKS {
            // along one axis equal steps are a quadrature of all digits
            if axes.len() == 1 || effective(&found, 1.0) >= ENOUGH * axes.len() as f64 {
                break;
            }
            let Some(draw) = Draw::about(&found, axes.len()) else { break };
            let next = look(&draw)?;
            if effective(&next, 1.0) <= effective(&found, 1.0) {
                break;
            }
            found = next;
        }
        let most = heaviest(&found);
        let sum: f64 = found.iter().map(|own| (own.weight - most).exp()).sum();
        let nodes = found.into_iter().map(|own| Node { weight: (own.weight - most).exp() / sum, ..own.node });
        let nodes: Vec<Node> = nodes.filter(|node| node.weight > SLIGHT).collect();
        let dof = if common { dof } else { f64::INFINITY };
        Ok((!nodes.is_empty() && dof > 0.0).then_some(Mixture { nodes, dof }))
    }

    /// Nodes in a part of the axes, each with the logarithm of its weight; `dof` where a common scale is integrated out.
    fn nodes(
        &self,
        axes: &[Axis],
        draw: &Draw,
        count: usize,
        (top, theta): (&Point, &[f64]),
        kept: &[usize],
        dof: Option<f64>,
    ) -> Result<Vec<Seen>> {
        let mut found = Vec::with_capacity(count);
        for k in 0..count {
            crate::stop::poll();
            let mut theta = theta.to_vec();
            let mut lines = Cow::Borrowed(self.lines);
            let mut weight = 0.0;
            // the first axis in equal steps, the others in steps that share no period with it
            let step = |a: usize| match a {
                0 => (k as f64 + 0.5) / count as f64,
                _ => (k as f64 * prime(a).sqrt() + 0.5).fract(),
            };
            let (place, density) = draw.at(&(0..axes.len()).map(step).collect::<Vec<_>>());
            if place.iter().any(|x| !(0.0..=1.0).contains(x)) {
                continue;
            }
            for (axis, place) in axes.iter().zip(&place) {
                let at = axis.at(*place);
                match axis {
                    Axis::Component { component, below, .. } => {
                        theta[*component] = at.exp() - below;
                        weight += at - theta[*component].abs().ln();
                    }
                    Axis::Time { line, .. } => remember(lines.to_mut(), *line, at.exp()),
                }
            }
            let point = self.at(&lines, &theta)?.filter(|point| point.basis == top.basis);
            let Some(point) = point else { continue };
            let expected = self.likelihood(&lines, &point, &theta)?.expected;
            let part = Mat::from_fn(kept.len(), kept.len(), |a, b| expected[(kept[a], kept[b])]);
            let Ok(root) = part.llt(Side::Lower) else { continue };
            weight += (0..kept.len()).map(|a| root.L()[(a, a)].ln()).sum::<f64>();
            let estimate = &point.estimate;
            let (scale, squares) = match dof {
                Some(dof) => (estimate.sum_of_squares / dof, dof * estimate.sum_of_squares.ln()),
                None => (1.0, estimate.sum_of_squares),
            };
            weight -= 0.5 * (point.deviance - estimate.sum_of_squares + squares);
            let solutions = estimate.unknowns.solution.iter().zip(&top.estimate.unknowns.solution);
            let shift: Vec<f64> = solutions.map(|(x, top)| x - top).collect();
            let covariance = &estimate.unknowns.covariance * Scale(scale);
            let weight = weight - density;
            if weight.is_finite() {
                found.push(Seen { weight, place, node: Node { weight: 0.0, shift, covariance } });
            }
        }
        Ok(found)
    }

    fn axes(&self, theta: &[f64], components: &[usize], timed: &time::Timed) -> Vec<Axis> {
        let line_of = |c: usize| self.lines.iter().zip(&self.component).position(|(_, own)| *own == Some(c));
        let component = |c: &usize| {
            let (below, unit) = match line_of(*c) {
                None => (0.0, theta[*c]),
                Some(k) => {
                    let (smallest, natural) = (self.smallest(k, theta), self.natural(&self.lines[k], theta));
                    let open = self.pattern.is_simple && self.lines[k].memory.is_none();
                    if open { (smallest, smallest) } else { (0.0, natural) }
                }
            };
            let (low, high) = (unit.min(theta[*c].abs().max(f64::MIN_POSITIVE)), unit.max(theta[*c]));
            let low = if below > 0.0 { unit } else { low };
            Axis::Component { component: *c, below, range: ((REACH.0 * low).ln(), (REACH.1 * high).ln()) }
        };
        let times =
            timed.found.iter().map(|(line, ..)| Axis::Time { line: *line, range: self.lines[*line].tau_range() });
        components.iter().map(component).chain(times).collect()
    }

    /// Variance of a line's deviation that is as large as what the rows of the level with most readings leave unknown of it.
    fn smallest(&self, line: usize, theta: &[f64]) -> f64 {
        let line = &self.lines[line];
        let mut told = vec![0.0; line.levels()];
        for felt in line.felt.iter().filter(|felt| felt.row < self.system.u.len()) {
            let factor = self.members.rows[felt.row].map_or(1.0, |g| theta[g]);
            told[felt.level] += felt.by * felt.by / (self.system.u[felt.row] * self.system.u[felt.row] * factor);
        }
        1.0 / told.iter().fold(f64::MIN_POSITIVE, |most, own| most.max(*own))
    }
}
