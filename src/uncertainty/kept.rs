//! What a Monte Carlo keeps of its trials: the ends of each sequence, and sums.

use crate::elements::Elements;
use crate::number;

/// How many of the smallest values an interval's lower end can be among: the shortest interval leaves `1 - level` on one side alone.
pub(super) fn tail(trials: usize, level: f64) -> usize {
    let m = trials as f64;
    let p = 0.5 * (1.0 - level);
    let shortest = m - (level * m + 0.5).floor();
    number::count(shortest.max(m * p + reach(m, p))).saturating_add(3).min(trials)
}

pub(super) fn slack(keep: usize) -> usize {
    keep / 4 + 1024
}

/// The smallest values of a sequence.
#[derive(Debug, Clone)]
pub(super) struct Tail {
    pub keep: usize,
    /// Nothing from here on is among them.
    pub below: f64,
    pub values: Vec<f64>,
}

impl Tail {
    pub fn new(keep: usize) -> Self {
        Tail { keep, below: f64::INFINITY, values: Vec::new() }
    }

    pub fn push(&mut self, value: f64) {
        if value < self.below {
            self.values.push(value);
            if self.values.len() >= self.keep + slack(self.keep) {
                self.cut();
            }
        }
    }

    pub fn cut(&mut self) {
        if let Some(last) = self.keep.checked_sub(1).filter(|last| *last < self.values.len()) {
            let (_, most, _) = self.values.select_nth_unstable_by(last, f64::total_cmp);
            self.below = *most;
            self.values.truncate(self.keep);
        }
    }

    pub fn sorted(mut self) -> Vec<f64> {
        self.cut();
        self.values.sort_unstable_by(f64::total_cmp);
        self.values
    }
}

/// A sorted sequence of which only the ends are known.
pub(super) struct Sorted {
    pub low: Vec<f64>,
    /// With the other sign.
    pub high: Vec<f64>,
    pub len: usize,
}

impl Sorted {
    pub fn at(&self, k: usize) -> f64 {
        let k = k.min(self.len.saturating_sub(1));
        let from_above = self.len.saturating_sub(1) - k;
        // between the two ends that are kept nothing is known
        self.low.get(k).copied().or_else(|| self.high.get(from_above).map(|v| -v)).unwrap_or(f64::NAN)
    }
}

/// Sums over trials of deviations from a centre, so that nothing cancels.
pub(super) struct Sums {
    pub centre: Vec<f64>,
    pub trials: usize,
    pub first: Vec<f64>,
    /// Row by row, lower triangle.
    pub second: Vec<f64>,
}

impl Sums {
    pub(crate) fn new(centre: Vec<f64>) -> Self {
        let n = centre.len();
        Sums { centre, trials: 0, first: vec![0.0; n], second: vec![0.0; n * n] }
    }

    /// Sums of a block are formed by themselves, so that rounding grows with the number of blocks only.
    pub(crate) fn add(&mut self, block: &[f64], count: usize) {
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

    pub(crate) fn means(&self) -> Vec<f64> {
        self.centre.iter().zip(&self.first).map(|(c, sum)| c + sum / self.trials as f64).collect()
    }

    pub fn covariance(&self) -> Vec<Vec<f64>> {
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
pub(super) fn reach(m: f64, p: f64) -> f64 {
    /// Two-sided probability 1e-4 of the normal distribution.
    const DEVIATE: f64 = 3.9;
    1.0 + DEVIATE * (m * p * (1.0 - p)).sqrt()
}
