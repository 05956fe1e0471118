//! Random walks of the unit make navigation errors that follow each other in time. A Kalman filter takes that out: of a column, and of
//! the gap, it leaves innovations, which are independent and of unit variance if nothing but noise and random walks is in them.
//!
//! ```text
//! z(t) = Psi(t) Psi(s)^-1 z(s) + w,   cov w = W(t) - A W(s) A^T,   A = Psi(t) Psi(s)^-1
//! e = (y - h z) / (h P h^T + u^2)^(1/2)                                 (one channel after another)
//! ```
//!
//! A bias that walks at random (rate random walk) is a further state: its value at `s` acts until `t` as a constant bias does from `s` on, by
//! `B = S(t) - A S(s)`. Its increment in between, of variance `q (t - s)`, acts on the channels for the time that remains; over a short interval in
//! proportion, so that the channels get the covariance `q B B^T (t - s)/3`, and `q B (t - s)/2` with the bias.
//!
//! `Psi` holds the signatures of the start, `W` the covariance of the random walks ([`linear`](super::linear)). Least squares on
//! innovations is generalised least squares on the data (Kailath, Sayed and Hassibi, *Linear Estimation*, 2000, chapter 9).
#![allow(
    clippy::indexing_slicing,
    reason = "matrices and vectors over the seven channels, indexed by `from_fn` and loops over that length"
)]

use super::errors::ErrorSource;
use super::measured::{CHANNELS, Channels, Measured};
use crate::elements::Elements;
use nalgebra::SMatrix;

pub(super) type Matrix = SMatrix<f64, CHANNELS, CHANNELS>;

/// Sizes of the channels in one Schuler oscillation: radians, metres per second, metres.
pub(super) const SIZE: Channels = [1.0, 1.0, 1.0, 7.9e3, 7.9e3, 6.4e6, 6.4e6];

/// A matrix over channels of the same size.
pub(super) fn scaled(matrix: &Matrix) -> Matrix {
    Matrix::from_fn(|i, j| matrix[(i, j)] * SIZE[j] / SIZE[i])
}

/// What every source does at one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct Instant {
    /// For each of [`super::errors::ErrorSource::catalogue`], the channels per SI unit of it.
    pub signatures: Vec<Channels>,
    /// Covariance of the channels that the random walks have built up.
    pub walk: [Channels; CHANNELS],
}

impl Instant {
    /// `Psi`: the signatures of the start.
    pub(super) fn start(&self) -> Matrix {
        // they are the last of the catalogue
        let first = self.signatures.len().saturating_sub(CHANNELS);
        Matrix::from_fn(|i, j| self.signatures.get(first + j).map_or(0.0, |s| s[i]))
    }

    /// The mean of instants near one another.
    pub(super) fn mean(all: &[Instant]) -> Instant {
        let share = 1.0 / all.len().max(1) as f64;
        let mut mean = Instant { signatures: Vec::new(), walk: [[0.0; CHANNELS]; CHANNELS] };
        let add = |to: &mut Channels, from: &Channels| to.iter_mut().zip(from).for_each(|(sum, v)| *sum += share * v);
        for instant in all {
            mean.signatures.resize(instant.signatures.len(), [0.0; CHANNELS]);
            mean.signatures.iter_mut().zip(&instant.signatures).for_each(|(to, from)| add(to, from));
            mean.walk.iter_mut().zip(&instant.walk).for_each(|(to, from)| add(to, from));
        }
        mean
    }
}

/// Random walks of the unit.
#[derive(Debug, Clone, Default)]
pub(super) struct Walks {
    /// For each run and row what white noise of the instruments has built up, and the signatures; empty without random walks of any kind.
    pub instants: Vec<Vec<Instant>>,
    /// Variance per second by which each bias walks, SI: three gyros, three accelerometers. The mission has none.
    pub biases: [f64; BIASES],
}

/// Biases of the unit.
const BIASES: usize = 6;
/// States with the biases.
const ALL: usize = CHANNELS + BIASES;

/// Replace each column by its innovations, weighted; `u` holds the standard uncertainty of each value. Without random walks this is the division by
/// `u`. Returns for each value by how much the logarithm of its innovation's variance exceeds that without walks; nothing without walks.
pub(super) fn whiten(measured: &Measured, walks: &Walks, u: &[f64], columns: &mut [Vec<f64>]) -> Vec<f64> {
    let filter = Filter::new(measured, walks, u);
    columns.iter_mut().for_each(|column| filter.apply(column));
    filter.logs
}

/// The filter of a question: the same for every column.
pub(super) struct Filter {
    /// Standard deviation of each value's innovation, and the logarithm of its variance over that without walks.
    sd: Vec<f64>,
    logs: Vec<f64>,
    /// States: the channels, or the channels and the biases.
    states: usize,
    /// Of each row whether it is the first of its run, how many values it has, and the channels' rows of its transition.
    rows: Vec<(bool, usize)>,
    transitions: Vec<f64>,
    /// Of each value its channel and its gain.
    channel: Vec<usize>,
    gains: Vec<f64>,
}

impl Filter {
    pub fn new(measured: &Measured, walks: &Walks, u: &[f64]) -> Filter {
        let mut filter = Filter {
            sd: Vec::with_capacity(u.len()),
            logs: Vec::new(),
            states: 0,
            rows: Vec::new(),
            transitions: Vec::new(),
            channel: Vec::new(),
            gains: Vec::new(),
        };
        match walks.biases.iter().any(|q| *q > 0.0) {
            _ if walks.instants.is_empty() => filter.sd.extend(u),
            true => filter.fill::<ALL>(measured, walks, u),
            false => filter.fill::<CHANNELS>(measured, walks, u),
        }
        filter
    }

    /// A column by its innovations.
    pub fn apply(&self, column: &mut [f64]) {
        if self.states == 0 {
            column.iter_mut().zip(&self.sd).for_each(|(value, sd)| *value /= sd);
            return;
        }
        let mut state = [0.0; ALL];
        let mut values = column.iter_mut().zip(self.sd.iter().zip(&self.channel).zip(self.gains.chunks(self.states)));
        for ((first, count), transition) in self.rows.iter().zip(self.transitions.chunks(CHANNELS * self.states)) {
            let before = if *first { [0.0; ALL] } else { state };
            state = before;
            for (z, row) in state.iter_mut().zip(transition.chunks(self.states)) {
                *z = row.iter().zip(&before).map(|(a, z)| a * z).sum();
            }
            for (value, ((sd, channel), gain)) in values.by_ref().take(*count) {
                let innovation = *value - state[*channel];
                state.iter_mut().zip(gain).for_each(|(z, k)| *z += k * innovation);
                *value = innovation / sd;
            }
        }
    }

    /// Over the channels alone, or over the channels and the biases: `N` states.
    fn fill<const N: usize>(&mut self, measured: &Measured, walks: &Walks, u: &[f64]) {
        self.states = N;
        let places = ErrorSource::bias_indices();
        for (run, instants) in measured.runs.iter().zip(&walks.instants) {
            let mut p = SMatrix::<f64, N, N>::zeros();
            let (mut psi_before, mut walk_before) = (Matrix::identity(), Matrix::zeros());
            let mut bias_before = SMatrix::<f64, CHANNELS, BIASES>::zeros();
            let mut time_before = 0.0;
            for (k, (row, instant)) in run.rows.iter().zip(instants).enumerate() {
                let walk = Matrix::from_fn(|i, j| instant.walk[i][j]);
                let psi = instant.start();
                let across = transition(&psi, &psi_before);
                let grown = walk - across * walk_before * across.transpose();
                let mut a = SMatrix::<f64, N, N>::identity();
                let mut q = SMatrix::<f64, N, N>::zeros();
                a.view_mut((0, 0), (CHANNELS, CHANNELS)).copy_from(&across);
                q.view_mut((0, 0), (CHANNELS, CHANNELS)).copy_from(&grown);
                if N > CHANNELS {
                    let of = |j: usize, i: usize| {
                        places.get(j).and_then(|k| instant.signatures.get(*k)).map_or(0.0, |s| s[i])
                    };
                    let bias = SMatrix::<f64, CHANNELS, BIASES>::from_fn(|i, j| of(j, i));
                    let felt = bias - across * bias_before;
                    a.view_mut((0, CHANNELS), (CHANNELS, BIASES)).copy_from(&felt);
                    let span = row.time - time_before;
                    for (j, density) in walks.biases.iter().enumerate() {
                        let effect = felt.column(j).into_owned();
                        let both = effect * effect.transpose() * (density * span / 3.0);
                        let mut corner = q.view_mut((0, 0), (CHANNELS, CHANNELS));
                        corner += both;
                        for i in 0..CHANNELS {
                            let half = 0.5 * density * span * effect[i];
                            q[(i, CHANNELS + j)] += half;
                            q[(CHANNELS + j, i)] += half;
                        }
                        q[(CHANNELS + j, CHANNELS + j)] += density * span;
                    }
                    (bias_before, time_before) = (bias, row.time);
                }
                p = a * p * a.transpose() + q;
                p = (p + p.transpose()) * 0.5;
                (psi_before, walk_before) = (psi, walk);
                self.transitions.extend((0..CHANNELS).flat_map(|i| (0..N).map(move |j| a[(i, j)])));
                let first = self.sd.len();
                for channel in (0..CHANNELS).filter(|c| row.value.get(*c).is_some_and(Option::is_some)) {
                    let u = u.at(self.sd.len());
                    let variance = p[(channel, channel)].max(0.0) + u * u;
                    let gain = p.column(channel) / variance;
                    self.logs.push((variance / (u * u)).ln());
                    self.sd.push(variance.sqrt());
                    self.channel.push(channel);
                    self.gains.extend(gain.iter());
                    let row: nalgebra::RowSVector<f64, N> = p.row(channel).into_owned();
                    p -= gain * row;
                }
                self.rows.push((k == 0, self.sd.len() - first));
            }
        }
    }
}

/// Random walks along other errors than those that `old` was made for: the covariance added from row to row is the same, `Q = W(t) - A W(s) A^T`; its
/// propagation follows the signatures of `new`, which are derivatives around those errors.
pub(super) fn carried(old: &[Instant], new: &[Instant]) -> Vec<Instant> {
    let (mut before, mut moved_before) = ((Matrix::identity(), Matrix::zeros()), (Matrix::identity(), Matrix::zeros()));
    old.iter()
        .zip(new)
        .map(|(old, new)| {
            let walk = Matrix::from_fn(|i, j| old.walk[i][j]);
            let across = transition(&old.start(), &before.0);
            let grown = walk - across * before.1 * across.transpose();
            before = (old.start(), walk);
            let across = transition(&new.start(), &moved_before.0);
            let walk = across * moved_before.1 * across.transpose() + grown;
            moved_before = (new.start(), walk);
            let walk = std::array::from_fn(|i| std::array::from_fn(|j| walk[(i, j)]));
            Instant { signatures: new.signatures.clone(), walk }
        })
        .collect()
}

/// `Psi(t) Psi(s)^-1`, with channels scaled to a size near one another.
fn transition(psi: &Matrix, before: &Matrix) -> Matrix {
    let ratio = scaled(before).transpose().lu().solve(&scaled(psi).transpose()).map(|x| x.transpose());
    // the first of a run has nothing before it
    let ratio = ratio.unwrap_or_else(Matrix::identity);
    Matrix::from_fn(|i, j| ratio[(i, j)] * SIZE[i] / SIZE[j])
}
