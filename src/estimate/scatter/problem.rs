//! The question of the variances, prepared: which row and which deviation belongs to which component, and the adjustment at given variances.
#![allow(
    clippy::indexing_slicing,
    reason = "`theta` and `floor` have `members.count` entries, likelihoods one more for each of `times`, rows and deviations hold components below it, and `System::check` has compared u with the rows"
)]

use super::elimination::Whitening;
use super::inference::{self, Carried, LeftOut, Membership};
use super::restricted::{AT_END, Climbed, Hill, Likelihood, Limits, no_covariance};
use super::{LineState, Pattern, ScatterLine, remember};
use crate::error::{Fault, Malformed, Result};
use crate::estimate::{Elimination, Estimate, ScaleHints, Settings, System, adjust_on, groups};
use std::borrow::Cow;

/// A variance this small beside the noise of what feels it cannot be seen.
pub(super) const UNSEEN: f64 = 1e-9;
/// This many times the least variance is seen: the square of its share of the noise is a hundred million epsilons, and it changes what others tell by a ten-thousandth.
const SEEN: f64 = 1e5;
/// A component is separated from others where at least this much of its information is its own.
pub(super) const SEPARATED: f64 = 1e-8;
/// Levels of all lines together, at most.
const MOST_LEVELS: usize = 1 << 24;

/// The question, prepared.
pub(super) struct Problem<'a> {
    pub system: &'a System,
    pub lines: &'a [ScatterLine],
    pub elimination: Option<&'a Elimination>,
    pub settings: &'a Settings,
    pub pattern: Pattern,
    /// Estimated groups, then estimated lines.
    pub groups: usize,
    /// Component of each line.
    pub component: Vec<Option<usize>>,
    pub members: Membership,
    /// Lines whose correlation times are sought with the variances, from where they are; behind the components.
    pub times: Vec<usize>,
    /// The least variance factor of each group.
    pub(super) floor: Vec<f64>,
    pub state: Vec<LineState>,
    /// Rows that these stand for beside themselves.
    pub(super) left_out: LeftOut,
    /// Variance factors of the groups as if nothing else scattered, where they are known from the rows that these stand for.
    pub(super) plain: Option<Vec<f64>>,
}

/// The adjustment at some variances.
pub(super) struct Point {
    pub whitening: Whitening,
    pub estimate: Estimate,
    pub deviance: f64,
    pub basis: Vec<usize>,
}

impl<'a> Problem<'a> {
    pub fn new(
        system: &'a System,
        lines: &'a [ScatterLine],
        elimination: Option<&'a Elimination>,
        least: &[f64],
        settings: &'a Settings,
    ) -> Result<Self> {
        system.check()?;
        let levels = lines.iter().map(ScatterLine::levels).fold(0_usize, usize::saturating_add);
        if levels > MOST_LEVELS {
            return Err(Malformed::new(Fault::Value, "the lines of scatter have too many levels")
                .at_path("lines")
                .expected(format!("{MOST_LEVELS} levels at most, numbered from 0 in each line"))
                .found(levels.to_string()));
        }
        let m = system.observed.len();
        let pattern = Pattern::new(m, lines);
        let groups = groups::count(&system.group);
        let mut count = groups;
        let mut state = Vec::with_capacity(lines.len());
        let mut component = Vec::with_capacity(lines.len());
        for line in lines {
            let felt = line.felt.iter().any(|felt| felt.by != 0.0 && felt.row < m);
            state.push(match (felt, line.variance) {
                (false, _) => LineState::NotFelt,
                (true, Some(_)) => LineState::Stated,
                (true, None) => LineState::Estimated,
            });
            let estimated = felt && line.variance.is_none();
            component.push(estimated.then(|| {
                count += 1;
                count - 1
            }));
        }
        let rows = system.group.iter().map(|group| group.estimated());
        let mut deviations = vec![None; pattern.deviations];
        for ((line, start), own) in lines.iter().zip(&pattern.first).zip(&component) {
            deviations[*start..start + line.levels()].fill(*own);
        }
        let members = Membership { rows: rows.collect(), deviations, count };
        // no hint, no floor
        let rounding = |g: usize| least.get(g).copied().unwrap_or(0.0).powi(2);
        let floor = (0..groups).map(rounding).collect();
        Ok(Problem {
            system,
            lines,
            elimination,
            settings,
            pattern,
            groups,
            component,
            members,
            times: Vec::new(),
            floor,
            state,
            left_out: LeftOut::default(),
            plain: None,
        })
    }

    /// The same question of other rows, or with other correlation times.
    pub(super) fn again<'b>(&self, system: &'b System, lines: &'b [ScatterLine]) -> Result<Problem<'b>>
    where
        'a: 'b,
    {
        let own = Problem::new(system, lines, self.elimination, &[], self.settings)?;
        Ok(Problem { floor: self.floor.clone(), ..own })
    }

    pub(super) fn adjust(&self, system: &System) -> Result<Estimate> {
        adjust_on(system, self.elimination, &ScaleHints::default(), self.settings)
    }

    /// The rows made independent at these variances of the components; `lines` are the problem's, or those with other correlation times.
    pub fn whitening(&self, lines: &[ScatterLine], theta: &[f64]) -> Whitening {
        let sd = self.system.scaled_u(|g| theta[g].sqrt());
        Whitening::new(&self.pattern, &sd, lines, &self.variances(theta))
    }

    /// The adjustment at these variances of the components; `None` where they are no covariance.
    pub fn at(&self, lines: &[ScatterLine], theta: &[f64]) -> Result<Option<Point>> {
        let whitening = self.whitening(lines, theta);
        if !whitening.is_positive() {
            return Ok(None);
        }
        let estimate = self.adjust(&whitening.system(&self.system.rows, &self.system.observed))?;
        let factor = &estimate.factor;
        let mut deviance = whitening.log_determinant() + estimate.sum_of_squares;
        let gone = self.left_out.rows.iter().zip(theta).filter(|(count, _)| **count > 0.0);
        deviance += self.left_out.log_determinant + gone.map(|(count, theta)| count * theta.ln()).sum::<f64>();
        deviance += factor.log_determinant();
        let mut basis = factor.basis().to_vec();
        basis.sort_unstable();
        Ok(Some(Point { whitening, estimate, deviance, basis }))
    }

    /// The restricted likelihood there, with its derivatives by the components and by the correlation times that are sought.
    ///
    /// Errors: none, unless numbers leave their range.
    pub fn likelihood(&self, lines: &[ScatterLine], point: &Point, theta: &[f64]) -> Result<Likelihood> {
        let found = (&point.estimate.factor.q, point.estimate.residuals.as_slice());
        let (mut sums, mut turned) = inference::sums(&point.whitening, &self.members, &self.left_out, found);
        // the basis of the unknowns is orthonormal at every place
        sums.logarithm = point.deviance - point.estimate.sum_of_squares;
        for line in &self.times {
            self.lean(lines, point, *line, theta, (&mut sums, &mut turned));
        }
        Likelihood::of(sums).ok_or_else(no_covariance)
    }

    /// The unknowns' basis and the residuals, at the rows and at the deviations.
    pub fn carried(&self, point: &Point) -> Carried {
        Carried::new(&point.whitening, (&point.estimate.factor.q, &point.estimate.residuals))
    }

    /// Variance of each line.
    pub fn variances(&self, theta: &[f64]) -> Vec<f64> {
        let own =
            // neither stated nor a component: an estimated line that no row feels has no variance
            |(line, component): (&ScatterLine, &Option<usize>)| line.variance.or(component.map(|c| theta[c])).unwrap_or(0.0);
        self.lines.iter().zip(&self.component).map(own).collect()
    }

    /// Variance of a line's deviations that is as large as the noise of the rows that feel one of them.
    pub fn natural(&self, line: &ScatterLine, theta: &[f64]) -> f64 {
        let own = |row: usize| {
            let factor = self.members.rows[row].map_or(1.0, |g| theta[g]);
            self.system.u[row] * self.system.u[row] * factor
        };
        let felt = line.felt.iter().filter(|f| f.row < self.system.u.len());
        let told: f64 = felt.map(|f| f.by * f.by / own(f.row)).sum();
        let levels = line.levels().max(1) as f64;
        if told > 0.0 && told.is_finite() { levels / told } else { 1.0 }
    }

    /// Where the iteration begins: the scales of the rows as if nothing else scattered.
    pub fn start(&self) -> Result<Vec<f64>> {
        let mut theta = vec![1.0; self.members.count];
        let plain = if let Some(known) = &self.plain { known.clone() } else { self.plain()? };
        for (g, (slot, variance)) in theta.iter_mut().zip(plain).enumerate() {
            *slot = variance.max(self.floor[g]).max(f64::MIN_POSITIVE);
        }
        for (line, component) in self.lines.iter().zip(&self.component) {
            if let Some(c) = component {
                theta[*c] = self.natural(line, &theta);
            }
        }
        Ok(theta)
    }

    /// Variance factors of the groups as if nothing else scattered.
    pub(super) fn plain(&self) -> Result<Vec<f64>> {
        if self.groups == 0 {
            return Ok(Vec::new());
        }
        let plain = self.adjust(self.system)?;
        Ok((0..self.groups).map(|g| plain.scale_or_one(g).powi(2)).collect())
    }

    /// Which of the components the rows tell apart, in order; the others leave their share to those before them.
    pub fn separated(&self, likelihood: &Likelihood) -> Vec<usize> {
        let mut kept: Vec<usize> = Vec::new();
        // what is left of each component's information when those kept are taken out (Cholesky)
        let mut rows: Vec<Vec<f64>> = Vec::new();
        let size = |g: usize| likelihood.expected[(g, g)].max(0.0).sqrt();
        for g in 0..self.members.count {
            if !(likelihood.redundancy[g] > groups::NO_REDUNDANCY && size(g) > 0.0) {
                continue;
            }
            let mut row: Vec<f64> = Vec::with_capacity(kept.len() + 1);
            for (a, h) in kept.iter().enumerate() {
                let before: f64 = (0..a).map(|k| row[k] * rows[a][k]).sum();
                row.push((likelihood.expected[(g, *h)] / (size(g) * size(*h)) - before) / rows[a][a]);
            }
            let left = 1.0 - row.iter().map(|x| x * x).sum::<f64>();
            if left > SEPARATED {
                row.push(left.sqrt());
                rows.push(row);
                kept.push(g);
            }
        }
        kept
    }

    /// The least variance of each component.
    pub fn floors(&self, theta: &[f64]) -> Vec<f64> {
        let mut floor = self.floor.clone();
        floor.resize(self.members.count, 0.0);
        for (line, component) in self.lines.iter().zip(&self.component) {
            if let Some(c) = component {
                floor[*c] = UNSEEN * self.natural(line, theta);
            }
        }
        floor
    }
}

// Variances by restricted maximum likelihood (`restricted.rs`). A variance that the likelihood draws below what could be seen is zero. H. D. Patterson,
// R. Thompson 1971; the start needs no guess: a deviation as large as the noise of what feels it.
//
// A variance estimated as zero is not known to be zero. Intervals that take it for zero pool its few degrees of freedom with the many of the
// noise, and are too short wherever it is small but present. So the search then goes on below zero, as far as `V` is a covariance, and `u` and
// dof come from there: in a balanced design that is the mean square that the parameter's own comparison has, with its own degrees of freedom,
// and Student's interval is exact whatever the true variance (W. W. Stroup, R. C. Littell, "Impact of variance component estimates on fixed
// effect inference in unbalanced linear mixed models", 2002; the NOBOUND of R. C. Littell et al., SAS for Mixed Models, 2006). What is reported
// as the variance stays the restricted one.

/// To the last digits.
pub(super) const FULL: Limits = Limits { steps: 200, settled: 1e-11 };
/// Where the iteration ended.
pub(super) struct Ended {
    pub theta: Vec<f64>,
    /// Correlation times that were sought.
    pub times: Vec<f64>,
    pub point: Point,
    pub likelihood: Likelihood,
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
        let mut likelihood = self.likelihood(self.lines, &point, &theta)?;
        let mut kept = self.separated(&likelihood);
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
            likelihood = self.likelihood(self.lines, &point, &theta)?;
        }
        // those that are sought were set
        let tau = |line: &usize| self.lines[*line].memory.as_ref().and_then(|memory| memory.tau).unwrap_or(1.0);
        let ended = Ended {
            theta,
            times: self.times.iter().map(tau).collect(),
            point,
            likelihood,
            kept,
            at_floor: vec![false; self.members.count],
            restricted: None,
            could_be: vec![None; self.members.count],
            is_open: false,
            iterations: 0,
            converged: false,
        };
        let mut ended = self.iterate(ended, limits)?;
        let zero: Vec<usize> = self.component.iter().flatten().copied().filter(|c| ended.at_floor[*c]).collect();
        if !zero.is_empty() {
            // what is told of a variance at its floor is less than rounding
            let mut above = ended.theta.clone();
            zero.iter().for_each(|c| above[*c] *= SEEN);
            let expected = self.likelihood(self.lines, &self.at_or_fail(&above)?, &above)?.expected;
            for c in &zero {
                let sd = (above[*c].abs() * (2.0 / expected[(*c, *c)]).sqrt()).sqrt();
                ended.could_be[*c] = Some(sd).filter(|sd| sd.is_finite());
            }
        }
        if !zero.is_empty() && ended.converged && self.pattern.is_simple {
            ended = self.below_zero(ended, &zero, limits)?;
        }
        for (component, state) in self.component.iter().zip(&mut self.state) {
            if component.is_some_and(|c| zero.contains(&c) || ended.at_floor[c]) {
                *state = LineState::AtZero;
            }
        }
        Ok(ended)
    }

    pub(super) fn at_or_fail(&self, theta: &[f64]) -> Result<Point> {
        self.at(self.lines, theta)?.ok_or_else(no_covariance)
    }

    /// To the top from where `ended` is; a component keeps its sign.
    fn iterate(&self, ended: Ended, limits: Limits) -> Result<Ended> {
        let count = self.members.count;
        let sign: Vec<f64> = ended.theta.iter().map(|theta| theta.signum()).collect();
        let theta = |at: &[f64]| -> Vec<f64> { at.iter().zip(&sign).map(|(x, sign)| sign * x.exp()).collect() };
        let times: Vec<(f64, f64)> = self.times.iter().map(|line| self.lines[*line].tau_range()).collect();
        let range = |at: &[f64]| -> Vec<(f64, f64)> {
            let floors =
                self.floors(&theta(at)).into_iter().map(|floor| (floor.max(f64::MIN_POSITIVE).ln(), f64::INFINITY));
            floors.chain(times.iter().copied()).collect()
        };
        let mut look = |at: &[f64]| -> Result<Option<(Likelihood, Point)>> {
            let (theta, mut lines) = (theta(at), Cow::Borrowed(self.lines));
            self.times.iter().zip(&at[count..]).for_each(|(line, x)| remember(lines.to_mut(), *line, x.exp()));
            let Some(point) = self.at(&lines, &theta)? else { return Ok(None) };
            Ok(Some((self.likelihood(&lines, &point, &theta)?, point)))
        };
        let movable: Vec<usize> = ended.kept.iter().copied().chain(count..count + self.times.len()).collect();
        let start = ended.theta.iter().map(|theta| theta.abs().ln()).chain(ended.times.iter().map(|tau| tau.ln()));
        let found = (ended.likelihood, ended.point);
        let alike = |a: &Point, b: &Point| a.basis == b.basis;
        let scoring = self.times.is_empty();
        let mut hill = Hill { range: &range, look: &mut look, alike: &alike, scoring, limits };
        let Climbed { at, found: (likelihood, point), iterations, converged } =
            hill.climb(start.collect(), found, &movable)?;
        let floors = range(&at);
        // released where the likelihood grows upwards
        let is_at_floor = |g: usize| {
            let is_low = at[g] <= floors[g].0 + AT_END || (g >= self.groups && likelihood.is_unseen(g));
            is_low && likelihood.gradient[g] >= 0.0
        };
        let at_floor = (0..count).map(|g| ended.kept.contains(&g) && is_at_floor(g)).collect();
        let times = at[count..].iter().map(|x| x.exp()).collect();
        Ok(Ended { theta: theta(&at), times, point, likelihood, at_floor, iterations, converged, ..ended })
    }

    /// Go on below zero with components that the restricted likelihood leaves there.
    fn below_zero(&self, ended: Ended, zero: &[usize], limits: Limits) -> Result<Ended> {
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
            match self.at(self.lines, &theta)? {
                Some(point) if point.deviance < ended.point.deviance => break (theta, point),
                _ if open.is_empty() || share < 10.0 * UNSEEN => return Ok(ended),
                _ => share *= 0.2,
            }
        };
        let likelihood = self.likelihood(self.lines, &point, &theta)?;
        let below = Ended {
            theta,
            times: Vec::new(),
            point,
            likelihood,
            kept: ended.kept.clone(),
            at_floor: ended.at_floor.clone(),
            restricted: Some(ended.theta.clone()),
            could_be: ended.could_be.clone(),
            is_open: false,
            iterations: 0,
            converged: false,
        };
        let further = self.iterate(below, limits)?;
        Ok(match further.converged {
            true => Ended { iterations: ended.iterations + further.iterations, ..further },
            false => Ended { is_open: true, ..ended },
        })
    }
}
