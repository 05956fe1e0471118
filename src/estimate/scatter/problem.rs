//! The question of the variances, prepared: which row and which deviation belongs to which component, and the adjustment at given variances.
#![allow(
    clippy::indexing_slicing,
    reason = "`theta`, `floor` and the inference have `members.count` entries, rows and deviations hold components below it, and `System::check` has compared u with the rows"
)]

use super::elimination::Whitening;
use super::inference::{Inference, LeftOut, Membership};
use super::{LineState, Pattern, ScatterLine};
use crate::error::{Fault, Malformed, Result};
use crate::estimate::{Elimination, Estimate, ScaleHints, Settings, System, adjust_on, groups};
use faer::Mat;
use faer::linalg::solvers::Solve;

/// A variance this small beside the noise of what feels it cannot be seen.
pub(super) const UNSEEN: f64 = 1e-9;
/// A component is separated from others where at least this much of its information is its own.
pub(super) const SEPARATED: f64 = 1e-8;
/// Steps that change no variance by more than this are Newton's.
const NEAR: f64 = 0.3;
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

    pub fn inference(&self, point: &Point) -> Inference {
        let found = (&point.estimate.factor.q, point.estimate.residuals.as_slice());
        Inference::new(&point.whitening, &self.members, &self.left_out, found)
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
    pub fn separated(&self, inference: &Inference) -> Vec<usize> {
        let mut kept: Vec<usize> = Vec::new();
        // what is left of each component's information when those kept are taken out (Cholesky)
        let mut rows: Vec<Vec<f64>> = Vec::new();
        let size = |g: usize| inference.s[(g, g)].max(0.0).sqrt();
        for g in 0..self.members.count {
            if !(inference.redundancy[g] > groups::NO_REDUNDANCY && size(g) > 0.0) {
                continue;
            }
            let mut row: Vec<f64> = Vec::with_capacity(kept.len() + 1);
            for (a, h) in kept.iter().enumerate() {
                let before: f64 = (0..a).map(|k| row[k] * rows[a][k]).sum();
                row.push((inference.s[(g, *h)] / (size(g) * size(*h)) - before) / rows[a][a]);
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

/// Relative changes of the free variances: Newton's where they are small, else Fisher's, else each by itself. What would leave `1 / leap` to `leap`
/// goes as far, and the others go with that: a variance that falls to nothing has an information that is lost in rounding.
pub(super) fn step(inference: &Inference, free: &[usize], leap: f64) -> Vec<f64> {
    let mut held: Vec<(usize, f64)> = Vec::new();
    loop {
        let is_held = |g: &usize| held.iter().any(|(own, _)| own == g);
        let open: Vec<usize> = free.iter().copied().filter(|g| !is_held(g)).collect();
        let change = together(inference, &open, &held);
        let bounded = |c: f64| (1.0 + c).clamp(1.0 / leap, leap) - 1.0;
        let beyond = |(g, c): (&usize, &f64)| ((1.0 + c) < 1.0 / leap || 1.0 + c > leap).then(|| (*g, bounded(*c)));
        let out: Vec<(usize, f64)> = open.iter().zip(&change).filter_map(beyond).collect();
        if out.is_empty() {
            held.extend(open.into_iter().zip(change));
            let of = |g: &usize| held.iter().find(|(own, _)| own == g).map_or(0.0, |(_, c)| *c);
            return free.iter().map(of).collect();
        }
        held.extend(out);
    }
}

/// Changes of some variances beside those that others are given.
fn together(inference: &Inference, open: &[usize], held: &[(usize, f64)]) -> Vec<f64> {
    let solve = |of: &dyn Fn(usize, usize) -> f64| -> Option<Vec<f64>> {
        let size: Vec<f64> = open.iter().map(|g| of(*g, *g).max(0.0).sqrt()).collect();
        if size.iter().any(|s| !(*s > 0.0)) {
            return None;
        }
        let given = |g: usize| held.iter().map(|(h, c)| of(g, *h) * c).sum::<f64>();
        let matrix = Mat::from_fn(open.len(), open.len(), |a, b| of(open[a], open[b]) / (size[a] * size[b]));
        let right = Mat::from_fn(open.len(), 1, |a, _| {
            let g = open[a];
            (inference.squares[g] - inference.redundancy[g] - given(g)) / size[a]
        });
        let found = matrix.llt(faer::Side::Lower).ok()?.solve(&right);
        let change: Vec<f64> = (0..open.len()).map(|a| found[(a, 0)] / size[a]).collect();
        change.iter().all(|c| c.is_finite()).then_some(change)
    };
    let near = |change: &[f64]| held.is_empty() && change.iter().all(|c| c.abs() < NEAR);
    let fisher = solve(&|g, h| inference.s[(g, h)]);
    match fisher {
        Some(fisher) if near(&fisher) => {
            let newton = solve(&|g, h| 2.0 * inference.observed[(g, h)] - inference.s[(g, h)]);
            newton.filter(|change| near(change)).unwrap_or(fisher)
        }
        Some(fisher) => fisher,
        None => open.iter().map(|g| inference.squares[*g] / inference.redundancy[*g].max(1e-12) - 1.0).collect(),
    }
}

// Variances by restricted maximum likelihood: Fisher's steps `S (t - 1) = squares - redundancy` on the factors `t` of the variances, Newton's near the end; a
// step that lowers the restricted likelihood is halved. A variance that the likelihood draws below what could be seen is zero. H. D. Patterson,
// R. Thompson 1971; the start needs no guess: a deviation as large as the noise of what feels it.
//
// A variance estimated as zero is not known to be zero. Intervals that take it for zero pool its few degrees of freedom with the many of the
// noise, and are too short wherever it is small but present. So the search then goes on below zero, as far as `V` is a covariance, and `u` and
// dof come from there: in a balanced design that is the mean square that the parameter's own comparison has, with its own degrees of freedom,
// and Student's interval is exact whatever the true variance (W. W. Stroup, R. C. Littell, "Impact of variance component estimates on fixed
// effect inference in unbalanced linear mixed models", 2002; the NOBOUND of R. C. Littell et al., SAS for Mixed Models, 2006). What is reported
// as the variance stays the restricted one.

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
        self.at(self.lines, theta)?.ok_or_else(|| {
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
                if let Some(next) = self.at(self.lines, &trial)? {
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
            match self.at(self.lines, &theta)? {
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
