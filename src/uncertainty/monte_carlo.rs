//! Propagation of distributions by the Monte Carlo method (JCGM 101:2008, GUM Supplement 1; JCGM 102:2011 for several outputs).
//!
//! ```text
//! x = x^ + sum over sources sqrt(nu / chi^2_nu) F z + sum over known inputs c (p - p^),    output = f(x, p)
//! ```
//!
//! `F F'` is a source's covariance and `z` standard normal, so an estimated variance gives the scaled and shifted t distribution of
//! Supplement 1 (6.4.9). Trials are drawn in blocks with streams of their own: the same seed gives the same numbers on any machine.

use crate::algebra::{Scratch, Tape};
use crate::campaign::{Distribution, Known};
use faer::Mat;
use rand_distr::{ChiSquared, Distribution as _, StandardNormal, StandardUniform};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use rayon::prelude::*;
use std::f64::consts::PI;

/// A source of scatter in the estimated parameters.
#[derive(Debug, Clone)]
pub struct Scatter {
    /// `F`, parameters x independent variables.
    pub factor: Mat<f64>,
    /// Degrees of freedom; infinite for a normal source.
    pub dof: f64,
}

/// A known input with an uncertainty.
#[derive(Debug, Clone)]
pub struct KnownInput {
    /// Index among all parameters.
    pub parameter: usize,
    /// What is known of it.
    pub known: Known,
    /// How the estimated parameters follow it.
    pub sensitivity: Vec<f64>,
}

/// An output of the propagation.
#[derive(Debug, Clone)]
pub enum Output {
    /// An estimated parameter.
    Parameter(usize),
    /// A line over all parameters.
    Line(Tape),
}

/// Everything that is drawn.
#[derive(Debug, Clone)]
pub struct Model {
    /// Values of all parameters, the estimated ones first.
    pub point: Vec<f64>,
    /// Scatter of the estimated parameters.
    pub scatter: Vec<Scatter>,
    /// Known inputs.
    pub known: Vec<KnownInput>,
    /// What is computed from them.
    pub outputs: Vec<Output>,
}

/// Distribution of one output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Propagated {
    /// Mean of the trials.
    pub mean: f64,
    /// Standard deviation of the trials.
    pub sd: f64,
    /// Probabilistically symmetric coverage interval.
    pub symmetric: (f64, f64),
    /// Shortest coverage interval.
    pub shortest: (f64, f64),
    /// Where the two ends of the symmetric interval may lie, so many trials being no more: order statistics that hold each with a
    /// probability of 0.9999, whatever the distribution.
    pub ends: [(f64, f64); 2],
}

/// What the trials say.
#[derive(Debug, Clone, PartialEq)]
pub struct MonteCarlo {
    /// Trials that gave finite outputs.
    pub trials: usize,
    /// Trials that were asked for.
    pub asked: usize,
    /// Seed.
    pub seed: u64,
    /// One for each output.
    pub outputs: Vec<Propagated>,
    /// Covariance of the outputs, row by row.
    pub covariance: Vec<Vec<f64>>,
    /// `k_p` of the coverage ellipsoid (Supplement 2, 6.5.2.4); `None` for one output, or a singular covariance.
    pub ellipsoid_factor: Option<f64>,
}

/// Trials in a block.
const BLOCK: usize = 10_000;

/// Draw `trials` and summarise them at a coverage probability; the ellipsoid is that of the outputs after the first `parameters`, or
/// of those where fewer than two follow. `progress` hears how many trials each finished block had.
///
/// `None` if fewer than half of the trials, or fewer than 100, give finite outputs.
pub fn monte_carlo(
    model: &Model,
    trials: usize,
    seed: u64,
    parameters: usize,
    level: f64,
    progress: &(dyn Fn(usize) + Sync),
) -> Option<MonteCarlo> {
    let count = model.outputs.len();
    let parameters = parameters.min(count);
    let blocks = trials.div_ceil(BLOCK);
    let drawn: Vec<Vec<f64>> = (0..blocks)
        .into_par_iter()
        .map(|block| {
            let size = BLOCK.min(trials - block * BLOCK);
            let values = draw(model, size, seed, block as u64);
            progress(size);
            values
        })
        .collect();
    let mut columns: Vec<Vec<f64>> = vec![Vec::with_capacity(trials); count];
    for trial in drawn.iter().flat_map(|block| block.chunks_exact(count.max(1))) {
        if trial.iter().all(|value| value.is_finite()) {
            columns.iter_mut().zip(trial).for_each(|(column, value)| column.push(*value));
        }
    }
    drop(drawn);
    let kept = columns.first().map_or(0, Vec::len);
    if kept < 100 || 2 * kept < trials {
        return None;
    }
    let means: Vec<f64> = columns.iter().map(|c| c.iter().sum::<f64>() / kept as f64).collect();
    let covariance: Vec<Vec<f64>> = (0..count)
        .into_par_iter()
        .map(|a| {
            (0..count)
                .map(|b| {
                    let pairs = columns[a].iter().zip(&columns[b]);
                    pairs.map(|(x, y)| (x - means[a]) * (y - means[b])).sum::<f64>() / (kept as f64 - 1.0)
                })
                .collect()
        })
        .collect();
    let several = if count >= parameters + 2 { parameters..count } else { 0..parameters };
    let joint: Vec<Vec<f64>> = covariance[several.clone()].iter().map(|row| row[several.clone()].to_vec()).collect();
    let ellipsoid_factor = ellipsoid_factor(&columns[several.clone()], &means[several], &joint, level);
    let outputs = columns
        .iter_mut()
        .enumerate()
        .map(|(k, column)| {
            column.par_sort_unstable_by(f64::total_cmp);
            let (symmetric, shortest) = intervals(column, level);
            let ends = sampling(column, level);
            Propagated { mean: means[k], sd: covariance[k][k].sqrt(), symmetric, shortest, ends }
        })
        .collect();
    Some(MonteCarlo { trials: kept, asked: trials, seed, outputs, covariance, ellipsoid_factor })
}

/// One block: trials x outputs, row by row.
fn draw(model: &Model, size: usize, seed: u64, block: u64) -> Vec<f64> {
    // any odd multiplier keeps the blocks apart; this one is the golden ratio's
    let mut random = Pcg64Mcg::seed_from_u64(seed.wrapping_add(block.wrapping_mul(0x9e37_79b9_7f4a_7c15)));
    let chi_square: Vec<Option<ChiSquared<f64>>> =
        model.scatter.iter().map(|s| if s.dof.is_finite() { ChiSquared::new(s.dof).ok() } else { None }).collect();
    let known_chi: Vec<Option<ChiSquared<f64>>> = model
        .known
        .iter()
        .map(|k| if k.known.dof.is_finite() { ChiSquared::new(k.known.dof).ok() } else { None })
        .collect();
    let mut point = model.point.clone();
    let mut work = Scratch::default();
    let mut values = Vec::with_capacity(size * model.outputs.len());
    for _ in 0..size {
        point.copy_from_slice(&model.point);
        for (source, chi) in model.scatter.iter().zip(&chi_square) {
            let widen = chi.as_ref().map_or(1.0, |chi| (source.dof / chi.sample(&mut random)).sqrt());
            for k in 0..source.factor.ncols() {
                let z: f64 = StandardNormal.sample(&mut random);
                for (x, f) in point.iter_mut().zip(source.factor.col_as_slice(k)) {
                    *x += f * z * widen;
                }
            }
        }
        for (input, chi) in model.known.iter().zip(&known_chi) {
            let deviate = deviate(input.known.distribution, &mut random);
            let widen = match (chi, input.known.distribution) {
                (Some(chi), Distribution::Normal) => (input.known.dof / chi.sample(&mut random)).sqrt(),
                _ => 1.0,
            };
            let shift = input.known.u * deviate * widen;
            if let Some(value) = point.get_mut(input.parameter) {
                *value += shift;
            }
            for (x, c) in point.iter_mut().zip(&input.sensitivity) {
                *x += c * shift;
            }
        }
        for output in &model.outputs {
            values.push(match output {
                Output::Parameter(k) => point.get(*k).copied().unwrap_or(f64::NAN),
                Output::Line(tape) => tape.value(&point, &mut work),
            });
        }
    }
    values
}

/// A deviate with mean 0 and standard deviation 1 (JCGM 101, 6.4).
fn deviate(distribution: Distribution, random: &mut Pcg64Mcg) -> f64 {
    let uniform = |random: &mut Pcg64Mcg| -> f64 { StandardUniform.sample(random) };
    match distribution {
        Distribution::Normal => StandardNormal.sample(random),
        Distribution::Rectangular => 3f64.sqrt() * (2.0 * uniform(random) - 1.0),
        Distribution::Triangular => 6f64.sqrt() * (uniform(random) - uniform(random)),
        Distribution::Arcsine => 2f64.sqrt() * (2.0 * PI * uniform(random)).sin(),
    }
}

/// Symmetric and shortest intervals of sorted values (JCGM 101, 7.7).
fn intervals(sorted: &[f64], level: f64) -> ((f64, f64), (f64, f64)) {
    let m = sorted.len();
    let q = ((level * m as f64 + 0.5).floor() as usize).clamp(1, m.saturating_sub(1).max(1));
    let at = |k: usize| sorted.get(k.min(m.saturating_sub(1))).copied().unwrap_or_default();
    let first = (m - q).div_ceil(2).saturating_sub(1);
    let symmetric = (at(first), at(first + q));
    let mut shortest = symmetric;
    for k in 0..m.saturating_sub(q) {
        let (low, high) = (at(k), at(k + q));
        if high - low < shortest.1 - shortest.0 {
            shortest = (low, high);
        }
    }
    (symmetric, shortest)
}

/// Where the ends of the symmetric interval may lie: the number of trials below a quantile is binomial, so its standard deviation is
/// `sqrt(m p (1 - p))` places in the order (the sampling error that JCGM 101, 7.9 is about).
fn sampling(sorted: &[f64], level: f64) -> [(f64, f64); 2] {
    /// Two-sided probability 1e-4 of the normal distribution.
    const DEVIATE: f64 = 3.9;
    let m = sorted.len() as f64;
    let at = |place: f64| {
        sorted.get((place.max(0.0) as usize).min(sorted.len().saturating_sub(1))).copied().unwrap_or_default()
    };
    let end = |p: f64| {
        let reach = 1.0 + DEVIATE * (m * p * (1.0 - p)).sqrt();
        (at((m * p - reach).floor()), at((m * p + reach).ceil()))
    };
    [end(0.5 * (1.0 - level)), end(0.5 * (1.0 + level))]
}

/// The `level` quantile of `sqrt((y - mean)' C^-1 (y - mean))`.
fn ellipsoid_factor(columns: &[Vec<f64>], means: &[f64], covariance: &[Vec<f64>], level: f64) -> Option<f64> {
    let n = means.len();
    if n < 2 {
        return None;
    }
    let sd: Vec<f64> = (0..n).map(|k| covariance[k][k].sqrt()).collect();
    let mut lower = vec![vec![0.0; n]; n];
    for j in 0..n {
        let own = 1.0 - (0..j).map(|k| lower[j][k] * lower[j][k]).sum::<f64>();
        if !(own > 1e-10) {
            return None;
        }
        lower[j][j] = own.sqrt();
        for i in j + 1..n {
            let sum: f64 = (0..j).map(|k| lower[i][k] * lower[j][k]).sum();
            lower[i][j] = (covariance[i][j] / (sd[i] * sd[j]) - sum) / lower[j][j];
        }
    }
    let trials = columns.first().map_or(0, Vec::len);
    let mut distances: Vec<f64> = (0..trials)
        .into_par_iter()
        .map(|t| {
            let mut white = [0.0; 32];
            let mut buffer = Vec::new();
            let white: &mut [f64] = if n <= 32 {
                &mut white[..n]
            } else {
                buffer.resize(n, 0.0);
                &mut buffer
            };
            let mut square = 0.0;
            for i in 0..n {
                let own = (columns[i][t] - means[i]) / sd[i];
                let before: f64 = (0..i).map(|k| lower[i][k] * white[k]).sum();
                white[i] = (own - before) / lower[i][i];
                square += white[i] * white[i];
            }
            square
        })
        .collect();
    let at = ((level * trials as f64).ceil() as usize).clamp(1, trials) - 1;
    let (_, square, _) = distances.select_nth_unstable_by(at, f64::total_cmp);
    Some(square.sqrt())
}
