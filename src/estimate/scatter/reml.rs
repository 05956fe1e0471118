//! Variances by restricted maximum likelihood, and the adjustment with them.
//!
//! Fisher's steps `S (t - 1) = squares - redundancy` on the factors `t` of the variances, Newton's near the end; a step that lowers the
//! restricted likelihood is halved. A variance that the likelihood draws below what could be seen is zero. H. D. Patterson, R. Thompson 1971;
//! the start needs no guess: a deviation as large as the noise of what feels it.

use super::cost;
use super::elimination::Whitening;
use super::inference::{Inference, Membership};
use super::{Line, Pattern};
use crate::error::Result;
use crate::estimate::{Elimination, Estimate, Group, Settings, System, adjust, adjust_on, groups};
use faer::Mat;
use faer::linalg::solvers::Solve;

/// What became of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineState {
    /// Its variance is stated.
    Stated,
    /// Estimated, and above zero.
    Estimated,
    /// Estimated: zero.
    AtZero,
    /// No row feels it.
    NotFelt,
    /// The rows do not separate it from the rows' own noise or from lines before it, which hold the sum.
    Inseparable,
}

/// A system adjusted with what scatters.
#[derive(Debug, Clone)]
pub struct Scattered {
    /// The adjustment of the whitened rows: residuals are those of whitened rows.
    pub estimate: Estimate,
    /// The whitening, for other columns.
    pub whitening: Whitening,
    /// Variance factor of each estimated group of rows; `None` without redundancy of its own.
    pub group_variance: Vec<Option<f64>>,
    /// Variance of each line.
    pub variance: Vec<f64>,
    /// For each line at zero, the standard deviation that its variance could have, one standard uncertainty above zero.
    pub could_be: Vec<Option<f64>>,
    /// Correlation time of each line that has one, and where estimated its standard uncertainty.
    pub tau: Vec<Option<(f64, Option<f64>)>>,
    /// What became of each line.
    pub state: Vec<LineState>,
    /// Covariance of the estimated variances relative to them: groups first, then lines (see `component`).
    pub spread: Mat<f64>,
    /// Where each line stands in `spread`; `None` where its variance is stated or nothing feels it.
    pub component: Vec<Option<usize>>,
    /// What the small-sample correction adds to the covariance of the unknowns, `n x n`.
    pub correction: Mat<f64>,
    /// Each line's part of the covariance of the unknowns, `n x n`.
    pub shares: Vec<Mat<f64>>,
    /// `d x / d y`, `n x m`.
    pub sensitivities: Mat<f64>,
    /// Residual of each row over the standard deviation of its own noise, deviations taken out; then each deviation over its own.
    pub standardized: Vec<f64>,
    /// Redundancy number of each row.
    pub redundancy: Vec<f64>,
    /// `-2` times the logarithm of the restricted likelihood, without constants.
    pub deviance: f64,
    /// Steps that the variances took.
    pub iterations: usize,
    /// Did they settle?
    pub converged: bool,
}

const STEPS: usize = 200;
/// Relative change of every variance at which the iteration ends.
const SETTLED: f64 = 1e-11;
/// Steps that change no variance by more than this are Newton's.
const NEAR: f64 = 0.3;
/// A variance this small beside the noise of what feels it cannot be seen.
const UNSEEN: f64 = 1e-9;
/// A component is separated from others where at least this much of its information is its own.
const SEPARATED: f64 = 1e-8;
/// Largest factor of one step.
const LEAP: f64 = 30.0;

/// Adjust `system` with lines of scatter, estimating what is not stated: scales of the estimated groups, variances and correlation times of
/// lines. `least` are the scales that rounding alone would give each group (as for `adjust_hinted`); may be empty.
///
/// Errors: those of [`adjust`].
pub fn adjust_scattered(
    system: &System,
    lines: &[Line],
    elimination: Option<&Elimination>,
    least: &[f64],
    settings: &Settings,
) -> Result<Scattered> {
    let mut lines = lines.to_vec();
    let open: Vec<usize> =
        (0..lines.len()).filter(|k| lines[*k].memory.as_ref().is_some_and(|m| m.tau.is_none())).collect();
    if open.is_empty() {
        return Problem::new(system, &lines, elimination, least, settings)?.solve();
    }
    let ranges: Vec<(f64, f64)> = open.iter().map(|k| range(&lines[*k])).collect();
    let mut at: Vec<f64> = ranges.iter().map(|(low, high)| 0.5 * (low + high)).collect();
    let set = |lines: &mut [Line], at: &[f64]| {
        for (k, x) in open.iter().zip(at) {
            if let Some(memory) = &mut lines[*k].memory {
                memory.tau = Some(x.exp());
            }
        }
    };
    let mut curvature = vec![None; open.len()];
    for round in 0..if open.len() == 1 { 1 } else { 3 } {
        for j in 0..open.len() {
            let mut value = |x: f64| -> Result<f64> {
                let mut trial = at.clone();
                trial[j] = x;
                set(&mut lines, &trial);
                Ok(Problem::new(system, &lines, elimination, least, settings)?.solve()?.deviance)
            };
            let (x, bend) = minimum(ranges[j], if round == 0 { 9 } else { 0 }, at[j], &mut value)?;
            at[j] = x;
            curvature[j] = bend;
        }
    }
    set(&mut lines, &at);
    let mut found = Problem::new(system, &lines, elimination, least, settings)?.solve()?;
    for ((k, bend), x) in open.iter().zip(curvature).zip(at) {
        // -2 log L has twice the curvature of -log L
        found.tau[*k] = Some((x.exp(), bend.map(|b: f64| x.exp() * (2.0 / b).sqrt())));
    }
    Ok(found)
}

/// Logarithms of the shortest and longest correlation time that a line's times could show.
fn range(line: &Line) -> (f64, f64) {
    let Some(memory) = &line.memory else { return (0.0, 0.0) };
    let mut times = memory.time.clone();
    times.sort_by(f64::total_cmp);
    let whole = times.last().zip(times.first()).map_or(1.0, |(b, a)| b - a);
    let mut gaps: Vec<f64> = times.windows(2).map(|p| p[1] - p[0]).filter(|g| *g > 0.0).collect();
    gaps.sort_by(f64::total_cmp);
    let gap = gaps.get(gaps.len() / 2).copied().unwrap_or(1.0);
    ((gap / 5.0).ln(), (whole.max(gap) * 2.0).ln())
}

/// The least value on a range: a coarse look, then golden sections; and the curvature there if it is inside.
fn minimum(
    (low, high): (f64, f64),
    coarse: usize,
    near: f64,
    value: &mut dyn FnMut(f64) -> Result<f64>,
) -> Result<(f64, Option<f64>)> {
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    let width = (high - low) / 8.0;
    let mut centre = near;
    let mut best = f64::INFINITY;
    for k in 0..coarse {
        let x = low + (high - low) * k as f64 / (coarse.max(2) - 1) as f64;
        let here = value(x)?;
        if here < best {
            (best, centre) = (here, x);
        }
    }
    let (mut a, mut b) = ((centre - width).max(low), (centre + width).min(high));
    let (mut c, mut d) = (b - ratio * (b - a), a + ratio * (b - a));
    let (mut fc, mut fd) = (value(c)?, value(d)?);
    while b - a > 1e-5 {
        if fc < fd {
            (b, d, fd) = (d, c, fc);
            c = b - ratio * (b - a);
            fc = value(c)?;
        } else {
            (a, c, fc) = (c, d, fd);
            d = a + ratio * (b - a);
            fd = value(d)?;
        }
    }
    let x = 0.5 * (a + b);
    let h = 0.05;
    let inside = x - h > low && x + h < high;
    let bend = if inside { (value(x - h)? - 2.0 * value(x)? + value(x + h)?) / (h * h) } else { 0.0 };
    Ok((x, (bend > 0.0).then_some(bend)))
}

/// The question, prepared.
struct Problem<'a> {
    system: &'a System,
    lines: &'a [Line],
    elimination: Option<&'a Elimination>,
    settings: &'a Settings,
    pattern: Pattern,
    /// Estimated groups, then estimated lines.
    groups: usize,
    /// Component of each line.
    component: Vec<Option<usize>>,
    members: Membership,
    /// What each line's deviations would tell of themselves if the rows had unit variance factors.
    floor: Vec<f64>,
    state: Vec<LineState>,
}

/// The adjustment at some variances.
struct Point {
    whitening: Whitening,
    estimate: Estimate,
    deviance: f64,
    basis: Vec<usize>,
}

impl<'a> Problem<'a> {
    fn new(
        system: &'a System,
        lines: &'a [Line],
        elimination: Option<&'a Elimination>,
        least: &[f64],
        settings: &'a Settings,
    ) -> Result<Self> {
        system.check()?;
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
        let rows = system.group.iter().map(|group| if let Group::Estimated(g) = group { Some(*g) } else { None });
        let mut deviations = vec![None; pattern.deviations];
        for ((line, start), own) in lines.iter().zip(&pattern.first).zip(&component) {
            deviations[*start..start + line.levels()].fill(*own);
        }
        let members = Membership { rows: rows.collect(), deviations, count };
        let rounding = |g: usize| least.get(g).copied().unwrap_or(0.0).powi(2);
        let floor = (0..groups).map(rounding).collect();
        Ok(Problem { system, lines, elimination, settings, pattern, groups, component, members, floor, state })
    }

    fn adjust(&self, system: &System) -> Result<Estimate> {
        match self.elimination {
            Some(elimination) => adjust_on(system, elimination, self.settings),
            None => adjust(system, self.settings),
        }
    }

    /// The adjustment at these variances of the components.
    fn at(&self, theta: &[f64]) -> Result<Point> {
        let sd: Vec<f64> = self
            .system
            .u
            .iter()
            .zip(&self.members.rows)
            .map(|(u, own)| u * own.map_or(1.0, |g| theta[g].sqrt()))
            .collect();
        let whitening = Whitening::new(&self.pattern, &sd, self.lines, &self.variances(theta));
        let m = sd.len();
        let white = System {
            rows: whitening.whiten_columns(&self.system.rows),
            observed: whitening.whiten(&self.system.observed),
            u: vec![1.0; m],
            group: vec![Group::Known; m],
        };
        let estimate = self.adjust(&white)?;
        let factor = &estimate.factor;
        let mut deviance = whitening.log_determinant() + estimate.sum_of_squares;
        let r = factor.r();
        deviance += 2.0 * (0..r.nrows()).map(|k| r[(k, k)].abs().ln()).sum::<f64>();
        deviance += 2.0 * factor.basis().iter().map(|j| factor.scale()[*j].ln()).sum::<f64>();
        let mut basis = factor.basis().to_vec();
        basis.sort_unstable();
        Ok(Point { whitening, estimate, deviance, basis })
    }

    fn variances(&self, theta: &[f64]) -> Vec<f64> {
        let own =
            |(line, component): (&Line, &Option<usize>)| line.variance.or(component.map(|c| theta[c])).unwrap_or(0.0);
        self.lines.iter().zip(&self.component).map(own).collect()
    }

    /// Variance of a line's deviations that is as large as the noise of the rows that feel one of them.
    fn natural(&self, line: &Line, theta: &[f64]) -> f64 {
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
    fn start(&self) -> Result<Vec<f64>> {
        let mut theta = vec![1.0; self.members.count];
        if self.groups > 0 {
            let plain = self.adjust(self.system)?;
            for (g, slot) in theta.iter_mut().enumerate().take(self.groups) {
                let scale = plain.group_scale.get(g).copied().flatten().unwrap_or(1.0);
                *slot = (scale * scale).max(self.floor[g]).max(f64::MIN_POSITIVE);
            }
        }
        for (line, component) in self.lines.iter().zip(&self.component) {
            if let Some(c) = component {
                theta[*c] = self.natural(line, &theta);
            }
        }
        Ok(theta)
    }

    /// Which of the components the rows tell apart, in order; the others leave their share to those before them.
    fn separated(&self, inference: &Inference) -> Vec<usize> {
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

    fn solve(mut self) -> Result<Scattered> {
        let mut theta = self.start()?;
        let mut point = self.at(&theta)?;
        let mut inference = Inference::new(&point.whitening, &self.members, &point.estimate);
        let kept = self.separated(&inference);
        for (component, state) in self.component.iter().zip(&mut self.state) {
            if let Some(c) = component.filter(|c| !kept.contains(c)) {
                theta[c] = 0.0;
                *state = LineState::Inseparable;
            }
        }
        let undetermined: Vec<bool> = (0..self.groups).map(|g| !kept.contains(&g)).collect();
        for (g, _) in undetermined.iter().enumerate().filter(|(_, u)| **u) {
            theta[g] = 1.0;
        }
        if kept.len() < self.members.count {
            point = self.at(&theta)?;
            inference = Inference::new(&point.whitening, &self.members, &point.estimate);
        }
        let (mut iterations, mut converged) = (0, kept.is_empty());
        let mut at_floor = vec![false; self.members.count];
        while !converged && iterations < STEPS {
            iterations += 1;
            let floor = self.floors(&theta);
            for g in &kept {
                // a floor may rise with the noise of the rows; released where the likelihood grows upwards
                at_floor[*g] =
                    theta[*g] <= floor[*g] * (1.0 + 1e-9) && inference.squares[*g] <= inference.redundancy[*g];
            }
            let free: Vec<usize> = kept.iter().copied().filter(|g| !at_floor[*g]).collect();
            let change = step(&inference, &free);
            let largest = change.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
            if largest <= SETTLED || free.is_empty() {
                converged = true;
                break;
            }
            // shares of a step on the scale of logarithms
            let factor: Vec<f64> = change.iter().map(|c| (1.0 + c).clamp(1.0 / LEAP, LEAP)).collect();
            let mut share = 1.0;
            loop {
                let mut trial = theta.clone();
                for (g, t) in free.iter().zip(&factor) {
                    trial[*g] = (theta[*g] * t.powf(share)).max(floor[*g]).max(f64::MIN_POSITIVE);
                }
                let next = self.at(&trial)?;
                let room = 1e-10 * (1.0 + point.deviance.abs());
                let better = next.deviance <= point.deviance + room || next.basis != point.basis;
                if better || share < 1e-3 || !next.deviance.is_finite() {
                    (theta, point) = (trial, next);
                    break;
                }
                share *= 0.5;
            }
            inference = Inference::new(&point.whitening, &self.members, &point.estimate);
        }
        for (component, state) in self.component.iter().zip(&mut self.state) {
            if component.is_some_and(|c| at_floor[c]) {
                *state = LineState::AtZero;
            }
        }
        let free: Vec<usize> = kept.iter().copied().filter(|g| !at_floor[*g] || *g < self.groups).collect();
        Ok(self.conclude(theta, point, inference, &free, &at_floor, &undetermined, iterations, converged))
    }

    /// The least variance of each component.
    fn floors(&self, theta: &[f64]) -> Vec<f64> {
        let mut floor = self.floor.clone();
        floor.resize(self.members.count, 0.0);
        for (line, component) in self.lines.iter().zip(&self.component) {
            if let Some(c) = component {
                floor[*c] = UNSEEN * self.natural(line, theta);
            }
        }
        floor
    }

    #[allow(clippy::too_many_arguments)]
    fn conclude(
        self,
        theta: Vec<f64>,
        point: Point,
        inference: Inference,
        free: &[usize],
        at_floor: &[bool],
        undetermined: &[bool],
        iterations: usize,
        converged: bool,
    ) -> Scattered {
        let directions = point.estimate.factor.whitened_directions();
        let spread = cost::spread(&inference.s, free);
        let correction = cost::correction(&directions, &spread, |g, h| inference.crossing(g, h));
        let rank = inference.basis.len();
        let (n, m) = (directions.nrows(), self.system.observed.len());
        let mut sensitivities = Mat::zeros(n, m);
        for (k, column) in inference.basis.iter().enumerate() {
            for (i, (g, sd)) in column.rows.iter().zip(point.whitening.sd()).enumerate() {
                for j in 0..n {
                    sensitivities[(j, i)] += directions[(j, k)] * g / sd;
                }
            }
        }
        let share = |(line, start): (&Line, &usize)| {
            let own = *start..start + line.levels();
            let gram = Mat::from_fn(rank, rank, |a, b| {
                let (a, b) = (&inference.basis[a].deviations, &inference.basis[b].deviations);
                a[own.clone()].iter().zip(&b[own.clone()]).map(|(a, b)| a * b).sum::<f64>()
            });
            &directions * gram * directions.transpose()
        };
        let shares = self.lines.iter().zip(&self.pattern.first).map(share).collect();
        let mut variance = self.variances(&theta);
        for (v, component) in variance.iter_mut().zip(&self.component) {
            if component.is_some_and(|c| at_floor[c]) {
                *v = 0.0;
            }
        }
        let could_be = self.component.iter().map(|component| {
            let c = component.filter(|c| at_floor[*c])?;
            Some((theta[c] * (2.0 / inference.s[(c, c)]).sqrt()).sqrt()).filter(|sd| sd.is_finite())
        });
        let could_be = could_be.collect();
        let group = |g: usize| (!undetermined[g]).then(|| theta[g]);
        Scattered {
            group_variance: (0..self.groups).map(group).collect(),
            variance,
            could_be,
            tau: self.lines.iter().map(|line| Some((line.memory.as_ref()?.tau?, None))).collect(),
            state: self.state,
            component: self.component,
            spread,
            correction,
            shares,
            sensitivities,
            standardized: [inference.residuals.rows.as_slice(), &inference.residuals.deviations].concat(),
            redundancy: inference.row_redundancy(),
            deviance: point.deviance,
            estimate: point.estimate,
            whitening: point.whitening,
            iterations,
            converged,
        }
    }
}

/// Relative changes of the free variances: Newton's where they are small, else Fisher's, else each by itself.
fn step(inference: &Inference, free: &[usize]) -> Vec<f64> {
    let rest = |g: usize| inference.squares[g] - inference.redundancy[g];
    let right = Mat::from_fn(free.len(), 1, |a, _| rest(free[a]));
    let solve = |of: &dyn Fn(usize, usize) -> f64| -> Option<Vec<f64>> {
        let size: Vec<f64> = free.iter().map(|g| of(*g, *g).max(0.0).sqrt()).collect();
        if size.iter().any(|s| !(*s > 0.0)) {
            return None;
        }
        let matrix = Mat::from_fn(free.len(), free.len(), |a, b| of(free[a], free[b]) / (size[a] * size[b]));
        let right = Mat::from_fn(free.len(), 1, |a, _| right[(a, 0)] / size[a]);
        let found = matrix.llt(faer::Side::Lower).ok()?.solve(&right);
        let change: Vec<f64> = (0..free.len()).map(|a| found[(a, 0)] / size[a]).collect();
        change.iter().all(|c| c.is_finite()).then_some(change)
    };
    let near = |change: &[f64]| change.iter().all(|c| c.abs() < NEAR);
    let fisher = solve(&|g, h| inference.s[(g, h)]);
    match fisher {
        Some(fisher) if near(&fisher) => {
            let newton = solve(&|g, h| 2.0 * inference.observed[(g, h)] - inference.s[(g, h)]);
            newton.filter(|change| near(change)).unwrap_or(fisher)
        }
        Some(fisher) => fisher,
        None => free.iter().map(|g| inference.squares[*g] / inference.redundancy[*g].max(1e-12) - 1.0).collect(),
    }
}
