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
use crate::elements::{Elements, Parts};
use crate::estimate::Bounds;
use crate::linear::{Triangle, dot};
use crate::number;
use faer::Mat;
use rand_distr::{ChiSquared, Distribution as _, StandardNormal, StandardUniform};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::sync::atomic::{AtomicBool, Ordering};

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
    /// The triangle of the correlation matrix of the known inputs, row by row; empty where they are independent.
    pub correlation: Vec<Vec<f64>>,
    /// What is computed from them.
    pub outputs: Vec<Output>,
    /// What holds the estimated parameters of each trial.
    pub bounds: Option<Bounds>,
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
    /// Did bounds hold any trial back?
    pub held: bool,
    /// One for each output.
    pub outputs: Vec<Propagated>,
    /// Covariance of the outputs, row by row.
    pub covariance: Vec<Vec<f64>>,
    /// `k_p` of the coverage ellipsoid (Supplement 2, 6.5.2.4); `None` for one output, or a singular covariance.
    pub ellipsoid_factor: Option<f64>,
}

/// Trials in a block.
const BLOCK: usize = 10_000;
/// Blocks that are drawn before their values are sorted into the tails.
const TOGETHER: usize = 16;

/// Draw `trials` and summarise them at a coverage probability; the ellipsoid is that of the outputs after the first `parameters`, or
/// of those where fewer than two follow. `progress` hears how many trials each finished block had.
///
/// Only the tails are kept that the intervals can end in; the ellipsoid, which needs the covariance first, is found from the
/// same trials drawn again. `None` if fewer than half of the trials, or fewer than 100, give finite outputs.
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
    let several = if count >= parameters + 2 { parameters..count } else { 0..parameters };
    let twice = several.len() >= 2;
    let blocks = Blocks { model, trials, seed, count, held: AtomicBool::new(false) };
    let keep = tail(trials, level);
    let mut tails: Vec<(Tail, Tail)> = vec![(Tail::new(keep), Tail::new(keep)); count];
    let mut sums = Sums::new(blocks.centre());
    blocks.visit(|drawn| {
        drawn.iter().for_each(|block| sums.add(block, count));
        tails.par_iter_mut().enumerate().for_each(|(k, (low, high))| {
            for value in drawn.iter().flat_map(|block| block.iter().skip(k).step_by(count.max(1))) {
                low.push(*value);
                high.push(-value);
            }
        });
        let size: usize = drawn.iter().map(|block| block.len() / count.max(1)).sum();
        progress(if twice { size - size / 2 } else { size });
    });
    let kept = sums.trials;
    if kept < 100 || 2 * kept < trials {
        return None;
    }
    let means = sums.means();
    let covariance = sums.covariance();
    let ellipsoid_factor = if twice {
        let (from, n) = (several.start, several.len());
        let part = |list: &[f64]| list.iter().skip(from).take(n).copied().collect::<Vec<f64>>();
        let joint: Vec<Vec<f64>> = covariance.iter().skip(from).take(n).map(|row| part(row)).collect();
        ellipsoid_factor(&blocks, from, (&part(&means), &joint), (kept, level), progress)
    } else {
        None
    };
    let outputs = tails
        .into_par_iter()
        .enumerate()
        .map(|(k, (low, high))| {
            let sorted = Sorted { low: low.sorted(), high: high.sorted(), len: kept };
            let (symmetric, shortest) = intervals(&sorted, level);
            let ends = sampling(&sorted, level);
            let mean = means.at(k);
            let variance = covariance.at(k).at(k);
            Propagated { mean, sd: variance.sqrt(), symmetric, shortest, ends }
        })
        .collect();
    let held = blocks.held.into_inner();
    Some(MonteCarlo { trials: kept, asked: trials, seed, held, outputs, covariance, ellipsoid_factor })
}

/// The most numbers that [`monte_carlo`] holds at once: both tails of each output, and the blocks being drawn.
#[cfg(feature = "cli")]
pub(crate) fn values_kept(trials: usize, outputs: usize, level: f64) -> usize {
    let tail = tail(trials, level);
    let drawn = (TOGETHER * BLOCK).min(trials.next_multiple_of(BLOCK));
    outputs.saturating_mul(2 * (tail + slack(tail)) + drawn)
}

/// All trials, a few blocks at a time.
struct Blocks<'a> {
    model: &'a Model,
    trials: usize,
    seed: u64,
    count: usize,
    held: AtomicBool,
}

impl Blocks<'_> {
    /// The finite trials of some blocks after the other, in order.
    fn visit(&self, mut visit: impl FnMut(&[Vec<f64>])) {
        let blocks = self.trials.div_ceil(BLOCK);
        for start in (0..blocks).step_by(TOGETHER) {
            let drawn: Vec<Vec<f64>> = (start..blocks.min(start + TOGETHER))
                .into_par_iter()
                .map(|block| {
                    let size = BLOCK.min(self.trials - block * BLOCK);
                    let mut values = draw(self.model, size, self.seed, block as u64, &self.held);
                    drop_infinite(&mut values, self.count);
                    values
                })
                .collect();
            visit(&drawn);
        }
    }

    /// The outputs of the first finite trial, near enough to the mean.
    fn centre(&self) -> Vec<f64> {
        let mut values = draw(self.model, BLOCK.min(self.trials).min(100), self.seed, 0, &self.held);
        drop_infinite(&mut values, self.count);
        values.chunks_exact(self.count.max(1)).next().map_or(vec![0.0; self.count], <[f64]>::to_vec)
    }
}

fn drop_infinite(values: &mut Vec<f64>, count: usize) {
    if values.iter().all(|value| value.is_finite()) {
        return;
    }
    let finite = values.chunks_exact(count.max(1)).filter(|trial| trial.iter().all(|value| value.is_finite()));
    *values = finite.flatten().copied().collect();
}

/// One block: trials x outputs, row by row.
fn draw(model: &Model, size: usize, seed: u64, block: u64, held: &AtomicBool) -> Vec<f64> {
    // any odd multiplier keeps the blocks apart; this one is the golden ratio's
    let mut random = Pcg64Mcg::seed_from_u64(seed.wrapping_add(block.wrapping_mul(0x9e37_79b9_7f4a_7c15)));
    let of = |dof: f64| if dof.is_finite() { ChiSquared::new(dof).ok() } else { None };
    let chi_square: Vec<Option<ChiSquared<f64>>> = model.scatter.iter().map(|line| of(line.dof)).collect();
    let known_chi: Vec<Option<ChiSquared<f64>>> = model.known.iter().map(|line| of(line.known.dof)).collect();
    let mut point = model.point.clone();
    let mut work = Scratch::default();
    let mut values = Vec::with_capacity(size * model.outputs.len());
    crate::stop::poll();
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
        let drawn: Vec<(f64, f64)> = (model.known.iter().zip(&known_chi))
            .map(|(input, chi)| {
                let deviate = deviate(input.known.distribution, &mut random);
                let widen = match (chi, input.known.distribution) {
                    (Some(chi), Distribution::Normal) => (input.known.dof / chi.sample(&mut random)).sqrt(),
                    _ => 1.0,
                };
                (deviate, widen)
            })
            .collect();
        for (k, (input, (deviate, widen))) in model.known.iter().zip(&drawn).enumerate() {
            let deviate = match model.correlation.get(k) {
                Some(row) => row.iter().zip(&drawn).map(|(share, (value, _))| share * value).sum(),
                None => *deviate,
            };
            let shift = input.known.u * deviate * widen;
            if let Some(value) = point.get_mut(input.parameter) {
                *value += shift;
            }
            for (x, c) in point.iter_mut().zip(&input.sensitivity) {
                *x += c * shift;
            }
        }
        if model.bounds.as_ref().is_some_and(|bounds| bounds.hold(&mut point)) {
            held.store(true, Ordering::Relaxed);
        }
        for output in &model.outputs {
            values.push(match output {
                Output::Parameter(k) => point.at(*k),
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
fn intervals(sorted: &Sorted, level: f64) -> ((f64, f64), (f64, f64)) {
    let m = sorted.len;
    let q = number::count(level * m as f64 + 0.5).clamp(1, m.saturating_sub(1).max(1));
    let first = (m - q).div_ceil(2).saturating_sub(1);
    let symmetric = (sorted.at(first), sorted.at(first + q));
    let mut shortest = symmetric;
    for k in 0..m.saturating_sub(q) {
        let (low, high) = (sorted.at(k), sorted.at(k + q));
        if high - low < shortest.1 - shortest.0 {
            shortest = (low, high);
        }
    }
    (symmetric, shortest)
}

/// Where the ends of the symmetric interval may lie: the number of trials below a quantile is binomial, so its standard deviation is
/// `sqrt(m p (1 - p))` places in the order (the sampling error that JCGM 101, 7.9 is about).
fn sampling(sorted: &Sorted, level: f64) -> [(f64, f64); 2] {
    let m = sorted.len as f64;
    let at = |place: f64| sorted.at(number::count(place));
    let end = |p: f64| {
        let reach = reach(m, p);
        (at((m * p - reach).floor()), at((m * p + reach).ceil()))
    };
    [end(0.5 * (1.0 - level)), end(0.5 * (1.0 + level))]
}

/// The `level` quantile of `sqrt((y - mean)' C^-1 (y - mean))` over the trials, for outputs from `first` on.
fn ellipsoid_factor(
    blocks: &Blocks<'_>,
    first: usize,
    (means, covariance): (&[f64], &[Vec<f64>]),
    (trials, level): (usize, f64),
    progress: &(dyn Fn(usize) + Sync),
) -> Option<f64> {
    let n = means.len();
    let sd: Vec<f64> = covariance.iter().enumerate().map(|(k, row)| row.at(k).sqrt()).collect();
    let correlation = |i: usize, j: usize| {
        let entry = covariance.get(i).and_then(|row| row.get(j)).zip(sd.get(i).zip(sd.get(j)));
        entry.map_or(f64::NAN, |(covariance, (a, b))| if i == j { 1.0 } else { covariance / (a * b) })
    };
    let lower = Triangle::of(n, correlation, |_| 1e-10)?;
    let distance = |trial: &[f64], white: &mut [f64]| {
        let further = trial.part(first..);
        for (white, ((y, mean), sd)) in white.iter_mut().zip(further.iter().zip(means).zip(&sd)) {
            *white = (y - mean) / sd;
        }
        lower.forward(white);
        dot(white, white)
    };
    let at = number::count((level * trials as f64).ceil()).clamp(1, trials) - 1;
    let mut farthest = Tail::new(trials - at);
    blocks.visit(|drawn| {
        let squares: Vec<Vec<f64>> = drawn
            .par_iter()
            .map(|block| {
                let mut white = vec![0.0; n];
                block.chunks_exact(blocks.count.max(1)).map(|trial| distance(trial, &mut white)).collect()
            })
            .collect();
        squares.iter().flatten().for_each(|square| farthest.push(-square));
        progress(squares.iter().map(Vec::len).sum::<usize>() / 2);
    });
    farthest.sorted().last().map(|square| (-square).sqrt())
}

// What is kept of the trials: the ends of each sequence, and sums.

/// How many of the smallest values an interval's lower end can be among: the shortest interval leaves `1 - level` on one side alone.
fn tail(trials: usize, level: f64) -> usize {
    let m = trials as f64;
    let p = 0.5 * (1.0 - level);
    let shortest = m - (level * m + 0.5).floor();
    number::count(shortest.max(m * p + reach(m, p))).saturating_add(3).min(trials)
}

fn slack(keep: usize) -> usize {
    keep / 4 + 1024
}

/// The smallest values of a sequence.
#[derive(Debug, Clone)]
struct Tail {
    keep: usize,
    /// Nothing from here on is among them.
    below: f64,
    values: Vec<f64>,
}

impl Tail {
    fn new(keep: usize) -> Self {
        Tail { keep, below: f64::INFINITY, values: Vec::new() }
    }

    fn push(&mut self, value: f64) {
        if value < self.below {
            self.values.push(value);
            if self.values.len() >= self.keep + slack(self.keep) {
                self.cut();
            }
        }
    }

    fn cut(&mut self) {
        if let Some(last) = self.keep.checked_sub(1).filter(|last| *last < self.values.len()) {
            let (_, most, _) = self.values.select_nth_unstable_by(last, f64::total_cmp);
            self.below = *most;
            self.values.truncate(self.keep);
        }
    }

    fn sorted(mut self) -> Vec<f64> {
        self.cut();
        self.values.sort_unstable_by(f64::total_cmp);
        self.values
    }
}

/// A sorted sequence of which only the ends are known.
struct Sorted {
    low: Vec<f64>,
    /// With the other sign.
    high: Vec<f64>,
    len: usize,
}

impl Sorted {
    fn at(&self, k: usize) -> f64 {
        let k = k.min(self.len.saturating_sub(1));
        let from_above = self.len.saturating_sub(1) - k;
        // between the two ends that are kept nothing is known
        self.low.get(k).copied().or_else(|| self.high.get(from_above).map(|v| -v)).unwrap_or(f64::NAN)
    }
}

/// Sums over trials of deviations from a centre, so that nothing cancels.
struct Sums {
    centre: Vec<f64>,
    trials: usize,
    first: Vec<f64>,
    /// Row by row, lower triangle.
    second: Vec<f64>,
}

impl Sums {
    fn new(centre: Vec<f64>) -> Self {
        let n = centre.len();
        Sums { centre, trials: 0, first: vec![0.0; n], second: vec![0.0; n * n] }
    }

    /// Sums of a block are formed by themselves, so that rounding grows with the number of blocks only.
    fn add(&mut self, block: &[f64], count: usize) {
        let n = self.centre.len();
        let (mut first, mut second) = (vec![0.0; n], vec![0.0; n * n]);
        let mut off = vec![0.0; n];
        for trial in block.chunks_exact(count.max(1)) {
            self.trials += 1;
            off.iter_mut().zip(trial.iter().zip(&self.centre)).for_each(|(off, (x, c))| *off = x - c);
            first.iter_mut().zip(&off).for_each(|(sum, x)| *sum += x);
            // rows of the lower triangle
            for (i, (x, row)) in off.iter().zip(second.chunks_exact_mut(n)).enumerate() {
                row.iter_mut().zip(&off).take(i + 1).for_each(|(sum, y)| *sum += x * y);
            }
        }
        self.first.iter_mut().zip(first).for_each(|(sum, add)| *sum += add);
        self.second.iter_mut().zip(second).for_each(|(sum, add)| *sum += add);
    }

    fn means(&self) -> Vec<f64> {
        self.centre.iter().zip(&self.first).map(|(c, sum)| c + sum / self.trials as f64).collect()
    }

    fn covariance(&self) -> Vec<Vec<f64>> {
        let (n, m) = (self.centre.len(), self.trials as f64);
        let at = |list: &[f64], k: usize| list.at(k);
        let of = |i: usize, j: usize| {
            let (i, j) = (i.max(j), i.min(j));
            (at(&self.second, i * n + j) - at(&self.first, i) * at(&self.first, j) / m) / (m - 1.0)
        };
        (0..n).map(|i| (0..n).map(|j| if i == j { of(i, i).max(0.0) } else { of(i, j) }).collect()).collect()
    }
}

/// So many places in the order a quantile may be off.
fn reach(m: f64, p: f64) -> f64 {
    /// Two-sided probability 1e-4 of the normal distribution.
    const DEVIATE: f64 = 3.9;
    1.0 + DEVIATE * (m * p * (1.0 - p)).sqrt()
}
