//! Variances of the means of 1, 2, 4, ... rows in a series: what its noise is like at each length, from a few numbers.
//!
//! ```text
//! s^2(m) = < (mean of m rows - mean of the m rows before)^2 > / 2       over disjoint pairs
//! white: r/m      correlated: q (var - cov),   var = (m + 2 S)/m^2,  S = f (m (1 - f) - (1 - f^m))/(1 - f)^2,
//!                                              cov = f ((1 - f^m)/(1 - f))^2 / m^2,  f = exp(-dt/tau)
//! ```

use crate::estimate::Sum;

/// Noise of a sensor: the white part as a factor of the rows' relative sizes, the deviation that is correlated in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Noise {
    pub white: f64,
    pub deviation: f64,
    pub tau: f64,
}

impl Noise {
    /// White, of the rows' relative sizes.
    pub(super) const WHITE: Noise = Noise { white: 1.0, deviation: 0.0, tau: 1.0 };
}

/// Sums of blocks of rows.
#[derive(Debug, Clone, Default)]
pub(super) struct Octaves {
    levels: Vec<Level>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Level {
    /// The first block of a pair.
    held: Option<f64>,
    pairs: u64,
    squares: Sum,
}

impl Octaves {
    /// Takes the next value.
    pub(super) fn push(&mut self, value: f64) {
        let (mut sum, mut size, mut level) = (value, 1.0, 0);
        loop {
            if self.levels.len() <= level {
                self.levels.push(Level::default());
            }
            let Some(own) = self.levels.get_mut(level) else { return };
            let Some(before) = own.held.take() else {
                own.held = Some(sum);
                return;
            };
            let difference = (sum - before) / size;
            own.squares.add(difference * difference);
            own.pairs += 1;
            (sum, size, level) = (sum + before, 2.0 * size, level + 1);
        }
    }

    /// Rows in a mean, pairs of means, variance; for every length of which there are pairs.
    pub(super) fn variances(&self) -> impl Iterator<Item = (f64, u64, f64)> + '_ {
        let levels = self.levels.iter().enumerate().filter(|(_, own)| own.pairs > 0);
        levels.map(|(j, own)| {
            (f64::from(crate::number::signed(j)).exp2(), own.pairs, own.squares.value() / (2.0 * own.pairs as f64))
        })
    }
}

/// Variance of a deviation that is correlated, of unit variance, with `f` between neighbours.
fn correlated(m: f64, f: f64) -> f64 {
    let rest = 1.0 - f;
    if rest <= 0.0 {
        return 0.0;
    }
    let power = 1.0 - f.powf(m);
    let s = f * (m * rest - power) / (rest * rest);
    (m + 2.0 * s) / (m * m) - f * (power / (rest * m)).powi(2)
}

/// What is known of a noise before its search: numbers that are stated.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Stated {
    pub white: Option<f64>,
    pub deviation: Option<f64>,
    pub tau: Option<f64>,
}

/// Where the search for a noise begins: of all on a grid, the one whose variances are nearest to those of the residuals (in logarithms, by the number of pairs).
pub(super) fn start(octaves: &Octaves, step: f64, length: f64, stated: Stated) -> Noise {
    const TAUS: usize = 33;
    const RATIOS: i32 = 24;
    let seen: Vec<(f64, f64, f64)> = octaves
        .variances()
        .filter(|own| own.2 > 0.0)
        .map(|(m, pairs, variance)| (m, pairs as f64, variance.ln()))
        .collect();
    let weight = |pairs: f64| pairs / (1.0 + pairs / 1e3);
    let (shortest, longest) = (step / 3.0, length.max(step));
    let taus: Vec<f64> = match stated.tau {
        Some(tau) => vec![tau],
        None => (0..TAUS).map(|k| shortest * (longest / shortest).powf(k as f64 / (TAUS - 1) as f64)).collect(),
    };
    let mut best = (f64::INFINITY, Noise { white: 1.0, deviation: 1.0, tau: longest });
    for tau in taus {
        let f = (-step / tau).exp();
        let shapes: Vec<f64> = seen.iter().map(|(m, ..)| correlated(*m, f)).collect();
        for k in -RATIOS..=RATIOS {
            // variance of the deviation in variances of the white noise
            let ratio = 10f64.powf(0.25 * f64::from(k));
            let model = |white: f64, deviation: f64, (m, ..): &(f64, f64, f64), shape: f64| {
                (white / m + deviation * shape).ln()
            };
            let (mut sum, mut all) = (0.0, 0.0);
            for (own, shape) in seen.iter().zip(&shapes) {
                let weight = weight(own.1);
                sum += weight * (own.2 - model(1.0, ratio, own, *shape));
                all += weight;
            }
            let scale = if all > 0.0 { (sum / all).exp() } else { 1.0 };
            let white = stated.white.map_or(scale, |own| own * own);
            let deviation = match (stated.deviation, stated.white) {
                (Some(own), _) => own * own,
                (None, Some(_)) => white * ratio,
                (None, None) => scale * ratio,
            };
            let white = match (stated.white, stated.deviation) {
                (None, Some(_)) => deviation / ratio,
                _ => white,
            };
            let cost: f64 = seen
                .iter()
                .zip(&shapes)
                .map(|(own, shape)| weight(own.1) * (own.2 - model(white, deviation, own, *shape)).powi(2))
                .sum();
            if cost < best.0 {
                best = (cost, Noise { white: white.sqrt(), deviation: deviation.sqrt(), tau });
            }
        }
    }
    best.1
}
