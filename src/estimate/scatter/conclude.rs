//! From the variances to what an adjustment reports.
#![allow(
    clippy::indexing_slicing,
    reason = "lists over lines, groups and components have the lengths that `Problem::new` gave them; components in `kept` and `free` are below `members.count` or were added here"
)]

use super::condense::Condensed;
use super::problem::{Ended, FULL, Problem, SEPARATED};
use super::restricted::Limits;
use super::time::{self, Along};
use super::{LineState, Memory, ScatterLine, Scattered, Stepped, Whitening, mixture};
use crate::error::Result;
use crate::estimate::factor::{product_by_rows, rank_tolerance};
use crate::estimate::{Elimination, ScaleHints, Settings, System, solve};
use crate::linear::form;
use faer::{Mat, Scale};

/// Below one degree of freedom Student's distribution has no mean; less the rounding of a design in which an unknown has exactly one.
const FEWEST: f64 = 1.0 - 1e-6;

/// Adjust `system` with lines of scatter, estimating what is not stated: scales of the estimated groups, variances and correlation times of
/// lines. `least` are the scales that rounding alone would give each group (as for `adjust_hinted`); may be empty.
///
/// Errors: those of [`adjust`](crate::estimate::adjust).
pub fn adjust_scattered(
    system: &System,
    lines: &[ScatterLine],
    elimination: Option<&Elimination>,
    least: &[f64],
    settings: &Settings,
) -> Result<Scattered> {
    scattered((system, lines), elimination, least, settings, true)
}

/// The same; `sums`: with the unknowns over the whole likelihood, where its top says too little, which what asks of variances alone has no use for.
///
/// Errors: those of [`adjust`](crate::estimate::adjust).
pub(crate) fn scattered(
    (system, lines): (&System, &[ScatterLine]),
    elimination: Option<&Elimination>,
    least: &[f64],
    settings: &Settings,
    sums: bool,
) -> Result<Scattered> {
    let problem = Problem::new(system, lines, elimination, least, settings)?;
    let timed = time::with_times(&problem, &[], &[])?;
    let mut problem = if let Some(lines) = &timed.lines { problem.again(system, lines)? } else { problem };
    let along = match &timed.along {
        Some(along) => problem.ended_along(along, &timed.start)?,
        None => None,
    };
    let (ended, along) = match along {
        Some(ended) => (ended, timed.along.as_ref()),
        None => (problem.solve_all(&timed.start, FULL)?, None),
    };
    let mut found = conclude(problem, ended, (&timed, sums), along)?;
    for (k, tau, u) in timed.found {
        found.tau[k] = Some((tau, u));
    }
    Ok(found)
}

/// The same rows, and the variances and what they are worth from elsewhere: `told` is an adjustment of them beside further unknowns behind these, whose
/// values are stated to be zero.
///
/// Errors: those of [`adjust`](crate::estimate::adjust).
pub(crate) fn scattered_with(
    (system, lines): (&System, &[ScatterLine]),
    elimination: Option<&Elimination>,
    told: &Scattered,
    settings: &Settings,
) -> Result<Scattered> {
    let n = system.rows.ncols();
    let weighed = system.with_u(system.scaled_u(|g| told.weighed_with[g].sqrt()));
    let stated = |(k, line): (usize, &ScatterLine)| ScatterLine {
        variance: Some(told.weighed_lines[k]),
        memory: line.memory.clone().map(|memory| Memory { tau: told.tau[k].map(|(tau, _)| tau), ..memory }),
        felt: line.felt.clone(),
    };
    let lines: Vec<ScatterLine> = lines.iter().enumerate().map(stated).collect();
    let own = scattered((&weighed, &lines), elimination, &[], settings, false)?;
    let part = |whole: &Mat<f64>| whole.submatrix(0, 0, n, n).to_owned();
    let conditional = mixture::conditional(&told.estimate.unknowns.covariance, n)?;
    let as_stated = |whole: &Mat<f64>| conditional.transpose() * whole * &conditional;
    let solution = &own.estimate.unknowns.solution;
    let mixture = told.mixture.as_ref().map(|all| all.of_first(&told.estimate.unknowns.solution, solution));
    Ok(Scattered {
        correction: part(&told.correction),
        leans: told.leans.iter().map(|own| own.as_ref().map(|(c, lean)| (*c, as_stated(lean)))).collect(),
        absorbed: told.absorbed.iter().map(|own| own.as_ref().map(|own| own.of_first(n))).collect(),
        estimate: own.estimate,
        whitening: own.whitening,
        shares: own.shares,
        sensitivities: own.sensitivities,
        standardized: own.standardized,
        redundancy: own.redundancy,
        alone: own.alone,
        mixture: mixture.transpose()?,
        ..told.clone()
    })
}

/// A step on the way to a solution: no more of it than where it leads. `before` is a step from a point nearby.
///
/// Errors: those of [`adjust`](crate::estimate::adjust).
pub(crate) fn step_scattered(
    system: &System,
    lines: &[ScatterLine],
    least: &[f64],
    before: Option<&Stepped>,
    settings: &Settings,
) -> Result<Stepped> {
    let (start, times) = before.map_or((&[][..], &[][..]), |step| (&step.theta, &step.times));
    let problem = Problem::new(system, lines, None, least, settings)?;
    let timed = time::with_times(&problem, start, times)?;
    let start = &timed.start[..];
    let mut problem = if let Some(lines) = &timed.lines { problem.again(system, lines)? } else { problem };
    let (theta, whitening, found) = match Condensed::new(&problem) {
        None => {
            let (theta, whitening) = match timed.along {
                Some(_) => (start.to_vec(), problem.whitening(problem.lines, start)),
                None => problem.walk(start)?,
            };
            let found = solve(&whitening.system(&system.rows, &system.observed), &ScaleHints::default(), settings)?;
            (theta, whitening, found)
        }
        Some(fewer) => {
            let mut small = problem.on(&fewer, start.len() != problem.members.count)?;
            let (theta, whitening) = small.walk(start)?;
            // ranks are judged as those of all rows
            let tolerance = settings.rank_tolerance.unwrap_or_else(|| rank_tolerance(system.shape()));
            let settings = Settings { rank_tolerance: Some(tolerance), ..*settings };
            let found = solve(
                &whitening.system(&small.system.rows, &small.system.observed),
                &ScaleHints::default(),
                &settings,
            )?;
            let whitening = problem.whitening(problem.lines, &theta);
            (theta, whitening, found)
        }
    };
    let times = timed.found.iter().map(|(_, tau, _)| *tau).collect();
    Ok(Stepped { solution: found.solution, rank: found.rank, whitening, theta, times })
}

impl Problem<'_> {
    /// Variances as a step on the way needs them: they need not settle, they go on from step to step, and the last step settles them.
    fn walk(&mut self, start: &[f64]) -> Result<(Vec<f64>, Whitening)> {
        if self.members.count == 0 {
            return Ok((Vec::new(), self.whitening(self.lines, &[])));
        }
        let steps = if start.is_empty() { 30 } else { 3 };
        let ended = self.solve(start, Limits { steps, settled: 1e-6 })?;
        Ok((ended.theta, ended.point.whitening))
    }
}

/// `along` is the likelihood along time, where the variances are those at its top.
fn conclude(
    mut problem: Problem<'_>,
    ended: Ended,
    (timed, sums): (&time::Timed, bool),
    along: Option<&Along>,
) -> Result<Scattered> {
    let Ended {
        theta, point, likelihood, kept, at_floor, restricted, could_be, is_open, iterations, converged, ..
    } = ended;
    let absorbed = problem.absorbed(&kept)?;
    for (state, _) in problem.state.iter_mut().zip(&absorbed).filter(|(_, own)| own.is_some()) {
        *state = LineState::Absorbed;
    }
    let reported = restricted.as_ref().unwrap_or(&theta);
    let groups = problem.groups;
    let mut free: Vec<usize> = kept.iter().copied().filter(|g| !at_floor[*g] || *g < groups).collect();
    // a correlation time that was estimated costs what a variance costs
    let mut leaning = vec![None; problem.lines.len()];
    for (k, ..) in &timed.found {
        if problem.component[*k].is_none_or(|c| at_floor[c] || !kept.contains(&c))
            && problem.lines[*k].variance.is_none()
        {
            continue;
        }
        let place = problem.members.count + problem.times.len();
        problem.times.push(*k);
        leaning[*k] = Some(place);
        free.push(place);
    }
    let likelihood = match problem.times.is_empty() {
        true => likelihood,
        false => problem.likelihood(problem.lines, &point, &theta)?,
    };
    problem.times.clear();
    let directions = point.estimate.factor.whitened_directions();
    let (spread, correction) = match along {
        Some(along) => along.costs(likelihood.gradient.len(), &leaning),
        None => {
            let (spread, correction) = likelihood.costs(None, &free);
            (spread, &directions * correction * directions.transpose())
        }
    };
    let carried = problem.carried(&point);
    let rank = directions.ncols();
    let mut sensitivities = product_by_rows(directions.as_ref(), carried.rows.subcols(0, rank));
    for (i, sd) in point.whitening.sd().iter().enumerate() {
        sensitivities.col_as_slice_mut(i).iter_mut().for_each(|s| *s /= sd);
    }
    let around = |middle: &Mat<f64>| &directions * middle * directions.transpose();
    let share = |(line, start): (&ScatterLine, &usize)| {
        let own = *start..start + line.levels();
        let felt = &carried.deviations;
        let gram = Mat::from_fn(rank, rank, |a, b| match b <= a {
            true => point.whitening.product(own.clone(), felt.col_as_slice(a), felt.col_as_slice(b)),
            false => 0.0,
        });
        around(&Mat::from_fn(rank, rank, |a, b| gram[(a.max(b), a.min(b))]))
    };
    let shares = problem.lines.iter().zip(&problem.pattern.first).map(share).collect();
    let is_zero = |c: usize| at_floor[c] || (restricted.is_some() && theta[c] < 0.0);
    let mut variance = problem.variances(reported);
    for (v, component) in variance.iter_mut().zip(&problem.component) {
        if component.is_some_and(is_zero) {
            *v = 0.0;
        }
    }
    let component = &problem.component;
    let covariance = &point.estimate.unknowns.covariance;
    let by_component: Vec<Mat<f64>> = free.iter().map(|g| around(&likelihood.slope(*g))).collect();
    let dof = |j: usize| {
        let parts: Vec<(usize, f64)> = free.iter().zip(&by_component).map(|(g, own)| (*g, own[(j, j)])).collect();
        satterthwaite(covariance[(j, j)], &parts, &spread)
    };
    let follows = |j: usize| absorbed.iter().flatten().any(|own| own.touches_unknown(j));
    let mut judged = (0..covariance.nrows()).filter(|j| point.estimate.unknowns.is_estimable(*j) && !follows(*j));
    // a line along time that is estimated as zero is no more than it could be, its standard uncertainty: what that adds to the variance v of an unknown, a, is
    // the standard uncertainty of v, with 2 (v/a)^2 degrees of freedom (Satterthwaite)
    let at_zero = |j: usize| {
        let along: Vec<f64> = (0..sensitivities.ncols()).map(|i| sensitivities[(j, i)]).collect();
        let more = problem.lines.iter().zip(component).filter_map(|(line, c)| {
            let tau = line.memory.as_ref()?.tau?;
            Some(line.variance_of(&along, Some(tau)) * could_be[(*c).filter(|c| is_zero(*c))?]?.powi(2))
        });
        2.0 * (covariance[(j, j)] / more.sum::<f64>()).powi(2)
    };
    let few = |j: usize| dof(j) < FEWEST || at_zero(j) < FEWEST;
    let mixture = match sums && (is_open || judged.any(few)) {
        true => problem.summed(&point, &theta, &kept, timed)?,
        false => None,
    };
    let leans = leaning.iter().map(|own| own.map(|c: usize| (c, around(&likelihood.slope(c))))).collect();
    Ok(Scattered {
        group_variance: (0..groups).map(|g| kept.contains(&g).then(|| reported[g])).collect(),
        weighed_with: theta[..groups].to_vec(),
        weighed_lines: problem.variances(&theta),
        variance,
        could_be: component.iter().map(|own| could_be[(*own)?].filter(|_| own.is_some_and(is_zero))).collect(),
        group_could_be: could_be[..groups].to_vec(),
        tau: problem.lines.iter().map(|line| Some((line.memory.as_ref()?.tau?, None))).collect(),
        component: component.iter().map(|own| own.filter(|c| free.contains(c))).collect(),
        leans,
        absorbed,
        spread,
        correction,
        mixture,
        shares,
        sensitivities,
        standardized: [carried.rows.col_as_slice(rank), carried.deviations.col_as_slice(rank)].concat(),
        redundancy: point.whitening.redundancies(point.estimate.factor.thin_q()),
        alone: problem.alone(&point.whitening, &theta),
        deviance: point.deviance,
        estimate: point.estimate,
        whitening: point.whitening,
        iterations,
        converged,
        state: problem.state,
    })
}

/// Degrees of freedom of a variance that is a sum of parts with estimated factors, `2 v^2/sum_gh a_g a_h S_gh`: `parts` are the factors' indices and what `v` has
/// of each, `spread` the relative covariance of the factors. Infinite where nothing of it is estimated.
///
/// F. E. Satterthwaite, An approximate distribution of estimates of variance components, Biometrics Bulletin 2 (1946), 110.
pub(crate) fn satterthwaite(variance: f64, parts: &[(usize, f64)], spread: &Mat<f64>) -> f64 {
    let inside = || parts.iter().filter(|(g, _)| *g < spread.nrows());
    let of_variance: f64 = inside().map(|(g, a)| inside().map(|(h, b)| a * b * spread[(*g, *h)]).sum::<f64>()).sum();
    if of_variance > 0.0 { 2.0 * variance * variance / of_variance } else { f64::INFINITY }
}

// Variances that no residual shows, though unknowns follow them.
//
//     residuals tell theta by P V(theta) P; an unknown c'x has the variance G' V(theta) G in its direction
//     P (V_c - sum_h a_h V_h) P = 0 :  the residuals do not tell theta_c from the others, a from  sum_h S_gh a_h = S_gc
//     G' (V_c - sum_h a_h V_h) G = 0 : nor do the unknowns, and the sum is enough; where it is not zero, their variance is not known
//
// C. R. Rao, J. Kleffe, Estimation of Variance Components and Applications (1988), chapter 4: a linear function of the variances can be estimated
// where it is one of those that the residuals have.

/// What is not known of the covariance of the unknowns, for want of one variance.
#[derive(Debug, Clone)]
pub struct Absorbed {
    /// Its derivative by that variance, at a deviation as large as the noise of the rows that feel it.
    unknown: Mat<f64>,
    /// The covariance itself there.
    whole: Mat<f64>,
}

impl Absorbed {
    /// Does the variance of `along . x` follow it?
    pub(crate) fn touches(&self, along: &[f64]) -> bool {
        form(&self.unknown, along).abs() > SEPARATED.sqrt() * form(&self.whole, along)
    }

    /// Of the first `n` unknowns.
    pub(super) fn of_first(&self, n: usize) -> Self {
        let part = |whole: &Mat<f64>| whole.submatrix(0, 0, n, n).to_owned();
        Absorbed { unknown: part(&self.unknown), whole: part(&self.whole) }
    }

    /// Does the variance of this unknown?
    pub(crate) fn touches_unknown(&self, k: usize) -> bool {
        self.unknown[(k, k)].abs() > SEPARATED.sqrt() * self.whole[(k, k)]
    }
}

impl Problem<'_> {
    /// See [`Scattered::alone`].
    fn alone(&self, whitening: &Whitening, theta: &[f64]) -> Vec<(usize, f64)> {
        let mut alone: Vec<(usize, f64)> = whitening.sd().iter().copied().enumerate().collect();
        let lines = self.lines.iter().zip(&self.pattern.first).zip(self.variances(theta));
        for ((line, start), variance) in lines.filter(|((line, _), variance)| line.memory.is_none() && *variance > 0.0)
        {
            let mut rows = vec![0_usize; line.levels()];
            line.felt.iter().for_each(|felt| rows[felt.level] += 1);
            for felt in line.felt.iter().filter(|felt| rows[felt.level] == 1) {
                // its own row has 0 - d: what adds to the row takes off there
                let own = (whitening.rows() + start + felt.level, -felt.by * variance.sqrt());
                alone
                    .get_mut(felt.row)
                    .into_iter()
                    .filter(|slot| slot.1.abs() < own.1.abs())
                    .for_each(|slot| *slot = own);
            }
        }
        alone
    }

    /// For each line, what is not known for want of its variance: of those that are not among the components `kept`.
    pub(super) fn absorbed(&self, kept: &[usize]) -> Result<Vec<Option<Absorbed>>> {
        let missing = |own: &Option<usize>| own.filter(|c| !kept.contains(c));
        let none = vec![None; self.lines.len()];
        if self.component.iter().all(|own| missing(own).is_none()) {
            return Ok(none);
        }
        let start = self.start()?;
        let Some(point) = self.at(self.lines, &start)? else { return Ok(none) };
        let likelihood = self.likelihood(self.lines, &point, &start)?;
        let directions = point.estimate.factor.whitened_directions();
        let whole = &directions * directions.transpose();
        // 2 S^-1
        let twice = super::restricted::spread(&likelihood.expected, kept);
        let one = |own: &Option<usize>| {
            let c = missing(own)?;
            let mut middle = likelihood.slope(c);
            for h in kept {
                let share = 0.5 * kept.iter().map(|g| twice[(*h, *g)] * likelihood.expected[(*g, c)]).sum::<f64>();
                middle -= likelihood.slope(*h) * Scale(share);
            }
            let found = Absorbed { unknown: &directions * middle * directions.transpose(), whole: whole.clone() };
            (0..whole.nrows()).any(|k| found.touches_unknown(k)).then_some(found)
        };
        Ok(self.component.iter().map(one).collect())
    }
}
