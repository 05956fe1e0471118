//! Overlapping deviations of a stream of samples.
//!
//! Averaging over m samples is a second difference of the running sum x at distance m (third, for Hadamard). Up to 2048 samples every difference
//! counts. Beyond, x is kept at every 2nd, 4th, 8th, ... sample only, so that each octave has its history of a few thousand values: differences
//! then begin every 2^L samples, at least 1024 to an averaging time, which no deviation notices. Each value that is kept is exact.
#![allow(
    clippy::indexing_slicing,
    reason = "`x` and `s` of a level have the same length and pairs are counted from it; pieces of eight are asked with `get` before they are indexed"
)]

use crate::elements::Parts;
use crate::number;

/// Longest distance of a difference within a level, in its own steps.
const REACH: usize = 2048;
/// What a level remembers.
const HISTORY: usize = 3 * REACH;
/// Samples taken at a time.
const CHUNK: usize = 1 << 15;
/// Most levels: 2^51 samples.
const LEVELS: usize = 40;

/// Sums of squared differences at one averaging time; each with the number of its differences.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sums {
    /// Samples averaged.
    pub m: u64,
    /// Differences at distance `m` that one stretch of all samples would have.
    pub positions: u64,
    /// Second differences of the running sum.
    pub allan: (f64, u64),
    /// Third differences.
    pub hadamard: (f64, u64),
    /// Second differences, averaged over `m` beginnings.
    pub modified: (f64, u64),
}

impl Sums {
    /// `sum (x[j+2m] - 2 x[j+m] + x[j])^2 / (2 m^2 n)` (SP 1065, equation 11).
    pub fn allan_variance(&self) -> f64 {
        let m = self.m as f64;
        self.allan.0 / (2.0 * m * m * self.allan.1.max(1) as f64)
    }

    /// `sum (x[j+3m] - 3 x[j+2m] + 3 x[j+m] - x[j])^2 / (6 m^2 n)` (SP 1065, equation 22).
    pub fn hadamard_variance(&self) -> Option<f64> {
        let m = self.m as f64;
        (self.hadamard.1 > 0).then(|| self.hadamard.0 / (6.0 * m * m * self.hadamard.1 as f64))
    }

    /// The modified Allan variance (SP 1065, equation 14).
    pub fn modified_variance(&self) -> Option<f64> {
        let m = self.m as f64;
        (self.modified.1 > 0).then(|| self.modified.0 / (2.0 * m * m * self.modified.1 as f64))
    }
}

#[derive(Debug, Clone, Default)]
struct Level {
    /// Running sum of the samples at every 2^L-th of them.
    x: Vec<f64>,
    /// Sum of the running sum over the 2^L samples from there.
    s: Vec<f64>,
    /// Entries that every difference has seen.
    seen: usize,
    /// Entries that the next level has.
    passed: usize,
    /// Distances in steps, and where their sums are.
    distances: Vec<(usize, usize)>,
    prefix: Vec<f64>,
}

/// Sums of squared differences of all samples pushed so far.
#[derive(Debug, Clone)]
pub struct Ladder {
    levels: Vec<Level>,
    sums: Vec<Sums>,
    only_allan: bool,
    reference: Option<f64>,
    running: f64,
    samples: u64,
    total: f64,
    stretches: u64,
    fresh: bool,
}

impl Ladder {
    /// Averaging times `2^(k/per_octave)` samples, rounded.
    pub fn new(per_octave: usize) -> Self {
        let per_octave = per_octave.clamp(1, 64);
        let mut levels = vec![Level::default(); LEVELS];
        let mut sums: Vec<Sums> = Vec::new();
        for k in 0..per_octave * (LEVELS + 10) {
            let wanted = number::count_u64(2f64.powf(k as f64 / per_octave as f64).round());
            // beyond 2^64 samples
            let level = (0..LEVELS).find(|level| wanted >> level <= REACH as u64).unwrap_or(LEVELS - 1);
            let distance = number::count((wanted as f64 / (1_u64 << level) as f64).round()).min(REACH);
            let m = (distance as u64) << level;
            if sums.last().is_some_and(|last| m <= last.m) {
                continue;
            }
            if let Some(level) = levels.get_mut(level) {
                level.distances.push((distance, sums.len()));
            }
            sums.push(Sums { m, ..Sums::default() });
        }
        Ladder {
            levels,
            sums,
            only_allan: false,
            reference: None,
            running: 0.0,
            samples: 0,
            total: 0.0,
            stretches: 0,
            fresh: true,
        }
    }

    /// The same without Hadamard and modified deviations.
    pub fn only_allan(mut self) -> Self {
        self.only_allan = true;
        self
    }

    /// Samples pushed.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Stretches between gaps.
    pub fn stretches(&self) -> u64 {
        self.stretches
    }

    /// Mean of all samples.
    pub fn mean(&self) -> f64 {
        self.reference.unwrap_or(0.0) + self.total / self.samples.max(1) as f64
    }

    /// What follows does not continue what came before (a gap): no difference reaches across.
    pub fn interrupt(&mut self) {
        for level in &mut self.levels {
            level.x.clear();
            level.s.clear();
            (level.seen, level.passed) = (0, 0);
        }
        self.running = 0.0;
        self.fresh = true;
    }

    /// Further samples. One that is not finite interrupts.
    pub fn push(&mut self, samples: &[f64]) {
        for stretch in samples.split_inclusive(|v| !v.is_finite()) {
            let (stretch, ends) = match stretch {
                [before @ .., last] if !last.is_finite() => (before, true),
                all => (all, false),
            };
            for chunk in stretch.chunks(CHUNK) {
                self.chunk(chunk);
            }
            if ends {
                self.interrupt();
            }
        }
    }

    fn chunk(&mut self, samples: &[f64]) {
        // near zero the running sum stays small, and its differences exact
        let reference =
            *self.reference.get_or_insert_with(|| samples.iter().sum::<f64>() / samples.len().max(1) as f64);
        let Some(first) = self.levels.first_mut() else { return };
        if self.fresh {
            first.x.push(0.0);
            first.s.push(0.0);
            self.stretches += 1;
            self.fresh = false;
        }
        let before = self.running;
        let mut running = before;
        first.x.extend(samples.iter().map(|y| {
            running += y - reference;
            running
        }));
        first.s.extend_from_slice(first.x.part(first.s.len()..));
        self.total += running - before;
        self.running = running;
        self.samples += samples.len() as u64;
        let mut carried: (Vec<f64>, Vec<f64>) = Default::default();
        for level in &mut self.levels {
            level.x.append(&mut carried.0);
            level.s.append(&mut carried.1);
            if level.x.len() == level.seen {
                break;
            }
            level.differences(&mut self.sums, self.only_allan);
            let pairs = (level.x.len() - level.passed) / 2;
            for k in (level.passed..).step_by(2).take(pairs) {
                carried.0.push(level.x[k]);
                carried.1.push(level.s[k] + level.s[k + 1]);
            }
            level.passed += 2 * pairs;
            let drop = level.x.len().saturating_sub(HISTORY + 1).min(level.passed);
            level.x.drain(..drop);
            level.s.drain(..drop);
            level.seen -= drop;
            level.passed -= drop;
        }
    }

    /// The sums at all averaging times with a difference.
    pub fn sums(&self) -> Vec<Sums> {
        let points = self.samples + 1;
        let with = |s: &Sums| Sums { positions: points.saturating_sub(2 * s.m).max(1), ..*s };
        self.sums.iter().filter(|s| s.allan.1 > 0).map(with).collect()
    }
}

impl Level {
    fn differences(&mut self, sums: &mut [Sums], only_allan: bool) {
        let (x, from) = (&self.x, self.seen);
        if !only_allan {
            // a third difference of the prefix sums does not notice a constant or linear part, so both are left out
            // no samples, no sums
            let anchor = self.s.first().copied().unwrap_or(0.0);
            self.prefix.clear();
            self.prefix.push(0.0);
            let mut sum = 0.0;
            self.prefix.extend(self.s.iter().map(|s| {
                sum += s - anchor;
                sum
            }));
        }
        for (q, place) in &self.distances {
            let (q, Some(sums)) = (*q, sums.get_mut(*place)) else { continue };
            let (sum, count) = squares(x, from.max(2 * q), [0, q, 2 * q, 0], [1.0, -2.0, 1.0, 0.0]);
            sums.allan.0 += sum;
            sums.allan.1 += count;
            if only_allan {
                continue;
            }
            let (sum, count) = squares(x, from.max(3 * q), [0, q, 2 * q, 3 * q], [1.0, -3.0, 3.0, -1.0]);
            sums.hadamard.0 += sum;
            sums.hadamard.1 += count;
            let start = (from + 1).max(3 * q);
            let (sum, count) = squares(&self.prefix, start, [0, q, 2 * q, 3 * q], [1.0, -3.0, 3.0, -1.0]);
            // prefix sums are over 2^L samples a step, so the mean is over m of them
            let mean = 1.0 / sums.m as f64;
            sums.modified.0 += sum * mean * mean;
            sums.modified.1 += count;
        }
        self.seen = self.x.len();
    }
}

/// `sum (c0 x[j - d0] + c1 x[j - d1] + ...)^2` over `j` from `from`, and the number of terms.
fn squares(x: &[f64], from: usize, back: [usize; 4], c: [f64; 4]) -> (f64, u64) {
    let count = x.len().saturating_sub(from);
    // too few samples for this distance: no terms
    let part = |d: usize| x.get(from.saturating_sub(d)..).and_then(|x| x.get(..count)).unwrap_or_default();
    let [a, b, e, f] = back.map(part);
    const LANES: usize = 8;
    let mut lanes = [0.0; LANES];
    let whole = count - count % LANES;
    let four = |c: usize| (a.get(c..c + LANES), b.get(c..c + LANES), e.get(c..c + LANES), f.get(c..c + LANES));
    for start in (0..whole).step_by(LANES) {
        let (Some(a), Some(b), Some(e), Some(f)) = four(start) else { continue };
        for k in 0..LANES {
            let d = if c[3] == 0.0 {
                c[0] * a[k] + c[1] * b[k] + c[2] * e[k]
            } else {
                a[k] + c[1] * b[k] + c[2] * e[k] - f[k]
            };
            lanes[k] += d * d;
        }
    }
    let mut sum: f64 = lanes.iter().sum();
    for k in whole..count {
        let d = c[0] * a[k] + c[1] * b[k] + c[2] * e[k] + c[3] * f[k];
        sum += d * d;
    }
    (sum, count as u64)
}
