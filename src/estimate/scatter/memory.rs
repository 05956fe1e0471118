//! Correlation times: the search for those that are not stated, and what a change of one does to the covariance.
#![allow(
    clippy::indexing_slicing,
    reason = "`open` holds numbers of lines, with one range, value and curvature each; `felt`, `forward` and `backward` have a line's levels, and `before` refers within them"
)]

use super::problem::Problem;
use super::reml::{FULL, Limits};
use super::{Pattern, ScatterLine};
use crate::elements::Elements;
use crate::error::Result;
use crate::estimate::{Elimination, Settings, System};
use std::borrow::Cow;

/// Lines with every correlation time set.
pub(super) struct Timed<'a> {
    pub lines: Cow<'a, [ScatterLine]>,
    /// Line, correlation time and its standard uncertainty, of those that were estimated.
    pub found: Vec<(usize, f64, Option<f64>)>,
    /// The variances found on the way; empty where nothing was searched.
    pub start: Vec<f64>,
}

/// Steps of the search itself need no more digits than the deviance has.
const SEARCH: Limits = Limits { steps: FULL.steps, settled: 1e-8 };

/// Set the correlation times of lines that have none: those `known` from a step nearby, else where the restricted likelihood is largest.
pub(super) fn with_times<'a>(
    system: &System,
    lines: &'a [ScatterLine],
    elimination: Option<&Elimination>,
    least: &[f64],
    settings: &Settings,
    known: &[f64],
) -> Result<Timed<'a>> {
    let open: Vec<usize> =
        (0..lines.len()).filter(|k| lines[*k].memory.as_ref().is_some_and(|m| m.tau.is_none())).collect();
    if open.is_empty() {
        return Ok(Timed { lines: Cow::Borrowed(lines), found: Vec::new(), start: Vec::new() });
    }
    let mut lines = lines.to_vec();
    let set = |lines: &mut [ScatterLine], logarithms: &[f64]| {
        for (k, x) in open.iter().zip(logarithms) {
            if let Some(memory) = &mut lines[*k].memory {
                memory.tau = Some(x.exp());
            }
        }
    };
    if known.len() == open.len() {
        set(&mut lines, &known.iter().map(|tau| tau.ln()).collect::<Vec<_>>());
        let found = open.iter().zip(known).map(|(k, tau)| (*k, *tau, None)).collect();
        return Ok(Timed { lines: Cow::Owned(lines), found, start: Vec::new() });
    }
    let ranges: Vec<(f64, f64)> = open.iter().map(|k| range(&lines[*k])).collect();
    let mut at: Vec<f64> = ranges.iter().map(|(low, high)| 0.5 * (low + high)).collect();
    let mut curvature = vec![None; open.len()];
    let mut start: Vec<f64> = Vec::new();
    for round in 0..if open.len() == 1 { 1 } else { 3 } {
        for j in 0..open.len() {
            let mut value = |x: f64| -> Result<f64> {
                let mut trial = at.clone();
                trial[j] = x;
                set(&mut lines, &trial);
                let mut problem = Problem::new(system, &lines, elimination, least, settings)?;
                let ended = problem.search(&start, SEARCH)?;
                // a start at zero would stay there
                let usable = ended.converged && !ended.at_floor.contains(&true) && ended.theta.iter().all(|t| *t > 0.0);
                start = if usable { ended.theta } else { Vec::new() };
                Ok(ended.point.deviance)
            };
            let (x, bend) = minimum(ranges[j], if round == 0 { 9 } else { 0 }, at[j], &mut value)?;
            at[j] = x;
            curvature[j] = bend;
        }
    }
    set(&mut lines, &at);
    let found = open.iter().zip(curvature).zip(at).map(|((k, bend), x)| {
        // -2 log L has twice the curvature of -log L
        (*k, x.exp(), bend.map(|b: f64| x.exp() * (2.0 / b).sqrt()))
    });
    Ok(Timed { found: found.collect(), lines: Cow::Owned(lines), start })
}

/// Logarithms of the shortest and longest correlation time that a line's times could show.
fn range(line: &ScatterLine) -> (f64, f64) {
    let Some(memory) = &line.memory else { return (0.0, 0.0) };
    let mut times = memory.time.clone();
    times.sort_by(f64::total_cmp);
    let whole = times.last().zip(times.first()).map_or(1.0, |(b, a)| b - a);
    let mut gaps: Vec<f64> = times.windows(2).map(|p| p[1] - p[0]).filter(|g| *g > 0.0).collect();
    gaps.sort_by(f64::total_cmp);
    let gap = gaps.get(gaps.len() / 2).copied().unwrap_or(1.0); // all at one time: any correlation time will do
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
    while b - a > 0.1 {
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
    // parabolas end what the sections have begun
    let (mut x, mut bend) = (0.5 * (a + b), 0.0);
    for h in [0.05, 0.02, 0.01] {
        if !(x - h > low && x + h < high) {
            return Ok((x, None));
        }
        let (less, here, more) = (value(x - h)?, value(x)?, value(x + h)?);
        bend = (less - 2.0 * here + more) / (h * h);
        if !(bend > 0.0) {
            return Ok((x, None));
        }
        x += (0.5 * (less - more) / (h * bend)).clamp(-0.1, 0.1);
    }
    Ok((x, Some(bend)))
}

/// `tau dV/dtau y` of a line whose deviations begin at `start`: central differences of the correlations, in two passes along each chain.
pub(super) fn lean(line: &ScatterLine, pattern: &Pattern, start: usize, variance: f64, values: &[f64]) -> Vec<f64> {
    const STEP: f64 = 1e-4;
    let mut out = vec![0.0; values.len()];
    let Some(memory) = &line.memory else { return out };
    let Some(tau) = memory.tau else { return out };
    let levels = line.levels();
    let mut felt = vec![0.0; levels];
    line.felt.iter().filter(|f| f.row < values.len()).for_each(|f| felt[f.level] += f.by * values[f.row]);
    let at = |l: usize| memory.time.at(l);
    let before = |l: usize| pattern.before[start + l].map(|d| d - start);
    let mut order: Vec<usize> = (0..levels).collect();
    // one run where none are told apart
    let run = |l: usize| memory.run.get(l).copied().unwrap_or(0);
    order.sort_by(|a, b| run(*a).cmp(&run(*b)).then(at(*a).total_cmp(&at(*b))));
    let correlated = |tau: f64| -> Vec<f64> {
        let mut sum = felt.clone();
        let left = |l: usize| before(l).map(|b| (b, (-(at(l) - at(b)).abs() / tau).exp()));
        let (mut forward, mut backward) = (felt.clone(), felt.clone());
        for l in &order {
            if let Some((b, rho)) = left(*l) {
                let came = rho * forward[b];
                forward[*l] += came;
                sum[*l] += came;
            }
        }
        for l in order.iter().rev() {
            if let Some((b, rho)) = left(*l) {
                let came = rho * backward[*l];
                backward[b] += came;
                sum[b] += came;
            }
        }
        sum
    };
    let (more, less) = (correlated(tau * STEP.exp()), correlated(tau * (-STEP).exp()));
    let slope: Vec<f64> = more.iter().zip(&less).map(|(a, b)| variance * (a - b) / (2.0 * STEP)).collect();
    line.felt.iter().filter(|f| f.row < values.len()).for_each(|f| out[f.row] += f.by * slope[f.level]);
    out
}
