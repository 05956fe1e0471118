//! Overlapping deviations of a stream of samples.
//!
//! Averaging over m samples is a second difference of the running sum x at distance m (third, for Hadamard). Up to 2048 samples every difference
//! counts. Beyond, x is kept at every 2nd, 4th, 8th, ... sample only, so that each octave has its history of a few thousand values: differences
//! then begin every 2^L samples, at least 1024 to an averaging time, which no deviation notices. Each value that is kept is exact.
//!
//! Where samples are missing, an Allan difference is that of the means of the samples that are there, and exists where each mean has nine tenths
//! of its samples; what this makes of white noise and of quantization is kept beside the sums. Hadamard's and the modified ones need all samples.
#![allow(
    clippy::indexing_slicing,
    reason = "`x` and `s` of a level have the same length and pairs are counted from it; pieces of eight are asked with `get` before they are indexed"
)]

use super::cells::Cells;
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
/// The share of its samples that a mean may miss.
pub(crate) const MISSING: f64 = 0.1;

/// Sums of squared differences at one averaging time; each with the number of its differences.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sums {
    /// Samples averaged.
    pub m: u64,
    /// Samples at which a difference of means over `m` samples begins.
    pub positions: u64,
    /// Second differences as they are, each times its distance in `m` samples: what a ramp is seen by.
    pub signed: f64,
    /// What missing samples make of the Allan variance of Q, N, B, K and R: sums of factors, one for each difference.
    pub missing: [f64; 5],
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

    /// The Allan variance of Q, N, B, K and R in that of a complete record.
    pub(crate) fn missing_factors(&self) -> [f64; 5] {
        self.missing.map(|sum| sum / self.allan.1.max(1) as f64)
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

/// What is missing up to a sample: samples, runs of them, the sum of their places.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Lost {
    samples: f64,
    runs: f64,
    places: f64,
}

impl Lost {
    fn less(self, before: Lost) -> Lost {
        Lost {
            samples: self.samples - before.samples,
            runs: self.runs - before.runs,
            places: self.places - before.places,
        }
    }
}

#[derive(Debug, Clone, Default)]
struct Level {
    /// Running sum of the samples at every 2^L-th of them.
    x: Vec<f64>,
    /// Sum of the running sum over the 2^L samples from there.
    s: Vec<f64>,
    /// What is missing up to there.
    lost: Vec<Lost>,
    /// Samples before the first entry.
    place: f64,
    /// Entries that every difference has seen.
    seen: usize,
    /// Entries that the next level has.
    passed: usize,
    /// Distances in steps, and where their sums are.
    distances: Vec<(usize, usize)>,
    prefix: Vec<f64>,
}

/// Sums of squared differences of all samples pushed so far.
#[derive(Debug, Clone, Default)]
pub struct Ladder {
    levels: Vec<Level>,
    sums: Vec<Sums>,
    reference: Option<f64>,
    running: f64,
    lost: Lost,
    inside: bool,
    place: f64,
    cells: Cells,
    range: Option<(f64, f64)>,
    samples: u64,
    total: f64,
    stretches: u64,
    /// Has a stretch begun that goes on?
    begun: bool,
}

impl Ladder {
    /// Differences of means reach across so many missing samples at most.
    pub(crate) const BRIDGED: u64 = REACH as u64;

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
        Ladder { levels, sums, ..Ladder::default() }
    }

    /// Samples pushed.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Stretches between gaps.
    pub(crate) fn stretches(&self) -> u64 {
        self.stretches
    }

    /// Are all samples equal?
    pub(crate) fn is_constant(&self) -> bool {
        !self.range.is_some_and(|(least, most)| least < most)
    }

    /// Mean of all samples.
    pub fn mean(&self) -> f64 {
        self.reference.unwrap_or(0.0) + self.total / self.samples.max(1) as f64
    }

    /// What follows does not continue what came before (a gap): no difference reaches across.
    pub(crate) fn interrupt(&mut self) {
        self.forget();
        self.cells.part();
    }

    fn forget(&mut self) {
        for level in &mut self.levels {
            level.x.clear();
            level.s.clear();
            level.lost.clear();
            (level.seen, level.passed, level.place) = (0, 0, 0.0);
        }
        (self.running, self.lost, self.place) = (0.0, Lost::default(), 0.0);
        self.begun = false;
    }

    /// So many samples are missing.
    pub(crate) fn missing(&mut self, count: u64) {
        if count > Self::BRIDGED {
            self.forget();
            self.cells.skip(if self.samples > 0 { count } else { 0 });
        } else {
            self.push(&vec![f64::NAN; number::index(count)]);
        }
    }

    /// Further samples. One that is not finite is missing; more in a row than the longest distance within an octave interrupt.
    pub fn push(&mut self, samples: &[f64]) {
        let (mut start, mut end) = (0, 0);
        for run in samples.chunk_by(|a, b| a.is_finite() == b.is_finite()) {
            let before = end;
            end += run.len();
            if run.len() > REACH && run.first().is_some_and(|v| !v.is_finite()) {
                self.chunks(samples.part(start..before));
                self.missing(run.len() as u64);
                start = end;
            }
        }
        self.chunks(samples.part(start..));
    }

    fn chunks(&mut self, samples: &[f64]) {
        // nothing is missing before the first
        let start = if self.samples == 0 { samples.iter().take_while(|v| !v.is_finite()).count() } else { 0 };
        samples.part(start..).chunks(CHUNK).for_each(|chunk| self.chunk(chunk));
    }

    fn chunk(&mut self, samples: &[f64]) {
        let sound = || samples.iter().filter(|v| v.is_finite());
        let count = sound().count();
        // near zero the running sum stays small, and its differences exact
        let reference = *self.reference.get_or_insert_with(|| sound().sum::<f64>() / count.max(1) as f64);
        let Some(first) = self.levels.first_mut() else { return };
        if !std::mem::replace(&mut self.begun, true) {
            first.x.push(0.0);
            first.s.push(0.0);
            first.lost.push(self.lost);
            self.stretches += 1;
        }
        let before = self.running;
        for y in samples {
            if y.is_finite() {
                self.running += y - reference;
                let (least, most) = self.range.unwrap_or((*y, *y));
                self.range = Some((y.min(least), y.max(most)));
            } else {
                self.lost.samples += 1.0;
                self.lost.runs += f64::from(u8::from(!self.inside));
                self.lost.places += self.place;
            }
            self.inside = !y.is_finite();
            self.place += 1.0;
            self.cells.push(Some(y - reference).filter(|_| !self.inside));
            first.x.push(self.running);
            first.lost.push(self.lost);
        }
        first.s.extend_from_slice(first.x.part(first.s.len()..));
        self.total += self.running - before;
        self.samples += count as u64;
        let mut carried: (Vec<f64>, Vec<f64>, Vec<Lost>) = Default::default();
        for (steps, level) in self.levels.iter_mut().enumerate() {
            level.x.append(&mut carried.0);
            level.s.append(&mut carried.1);
            level.lost.append(&mut carried.2);
            if level.x.len() == level.seen {
                break;
            }
            level.differences(&mut self.sums, (1_u64 << steps) as f64);
            let pairs = (level.x.len() - level.passed) / 2;
            for k in (level.passed..).step_by(2).take(pairs) {
                carried.0.push(level.x[k]);
                carried.1.push(level.s[k] + level.s[k + 1]);
                carried.2.push(level.lost[k]);
            }
            level.passed += 2 * pairs;
            let drop = level.x.len().saturating_sub(HISTORY + 1).min(level.passed);
            level.x.drain(..drop);
            level.s.drain(..drop);
            level.lost.drain(..drop);
            level.place += drop as f64 * (1_u64 << steps) as f64;
            level.seen -= drop;
            level.passed -= drop;
        }
    }

    /// The record in cells.
    pub(super) fn cells(&self) -> &Cells {
        &self.cells
    }

    /// The sums at all averaging times with a difference.
    pub fn sums(&self) -> Vec<Sums> {
        self.sums.iter().filter(|s| s.allan.1 > 0).copied().collect()
    }
}

impl Level {
    fn differences(&mut self, sums: &mut [Sums], step: f64) {
        let (x, from) = (&self.x, self.seen);
        // is a sample missing between two entries?
        let complete = |a: usize, b: usize| self.lost[a].samples == self.lost[b].samples;
        let all = self.lost.last() == self.lost.first();
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
        for (q, place) in &self.distances {
            let (q, Some(sums)) = (*q, sums.get_mut(*place)) else { continue };
            let (sum, signed, count, missing) = if all {
                let (sum, signed, count) = squares(x, from.max(2 * q), [0, q, 2 * q, 0], [1.0, -2.0, 1.0, 0.0]);
                (sum, signed, count, [count as f64; 5])
            } else {
                self.allan(q, from.max(2 * q), step)
            };
            sums.allan.0 += sum;
            sums.allan.1 += count;
            sums.signed += signed;
            sums.positions += count * number::count_u64(step);
            sums.missing.iter_mut().zip(missing).for_each(|(sum, part)| *sum += part);
            let third = |x: &[f64], from: usize, lag: usize| {
                if all {
                    let (sum, _, count) = squares(x, from, [0, q, 2 * q, 3 * q], [1.0, -3.0, 3.0, -1.0]);
                    return (sum, count);
                }
                let whole = (from..x.len()).filter(|j| complete(j - lag, j - 3 * q));
                let difference = |j: usize| x[j] - 3.0 * (x[j - q] - x[j - 2 * q]) - x[j - 3 * q];
                whole.fold((0.0, 0), |(sum, count), j| (sum + difference(j).powi(2), count + 1))
            };
            let (sum, count) = third(x, from.max(3 * q), 0);
            sums.hadamard.0 += sum;
            sums.hadamard.1 += count;
            let (sum, count) = third(&self.prefix, (from + 1).max(3 * q), 1);
            // prefix sums are over 2^L samples a step, so the mean is over m of them
            let mean = 1.0 / sums.m as f64;
            sums.modified.0 += sum * mean * mean;
            sums.modified.1 += count;
        }
        self.seen = self.x.len();
    }

    /// Squares of the differences of means over `q` entries of what is there, those differences, their number, and the factors of what is missing.
    fn allan(&self, q: usize, from: usize, step: f64) -> (f64, f64, u64, [f64; 5]) {
        let m = q as f64 * step;
        let (mut sum, mut signed, mut count, mut factors) = (0.0, 0.0, 0, [0.0; 5]);
        for j in from..self.x.len() {
            let [a, b, c] = [j - 2 * q, j - q, j];
            let (first, second) = (self.lost[b].less(self.lost[a]), self.lost[c].less(self.lost[b]));
            if first.samples.max(second.samples) > MISSING * m {
                continue;
            }
            let (one, two) = (m / (m - first.samples), m / (m - second.samples));
            let difference = (self.x[c] - self.x[b]) * two - (self.x[b] - self.x[a]) * one;
            sum += difference * difference;
            count += 1;
            // sums of increments have two ends for each run of samples that are there; neighbouring sums share one
            let at = |k: usize| if step == 1.0 { self.lost[k + 1].less(self.lost[k]) } else { Lost::default() };
            let ends =
                |from: usize, to: usize, lost: Lost| 2.0 * (1.0 + lost.runs - at(to - 1).samples - at(from).runs);
            let shared = if at(b - 1).samples + at(b).samples > 0.0 { 0.0 } else { 2.0 * one * two };
            factors[0] += (ends(a, b, first) * one * one + ends(b, c, second) * two * two + shared) / 6.0;
            factors[1] += 0.5 * (one + two);
            // how far apart the middles of what is there are, by m
            let shift = |from: usize, lost: Lost| {
                let middle = self.place + from as f64 * step + 0.5 * (m - 1.0);
                (lost.samples * middle - lost.places) / (m - lost.samples) / m
            };
            let apart = 1.0 + shift(b, second) - shift(a, first);
            signed += difference * apart;
            factors[2] += 1.0;
            factors[3] += 1.0 + 1.5 * (apart - 1.0);
            factors[4] += apart * apart;
        }
        (sum, signed, count, factors)
    }
}

/// `sum (c0 x[j - d0] + c1 x[j - d1] + ...)^2` over `j` from `from`, the same without squares, and the number of terms.
fn squares(x: &[f64], from: usize, back: [usize; 4], c: [f64; 4]) -> (f64, f64, u64) {
    let count = x.len().saturating_sub(from);
    // too few samples for this distance: no terms
    let part = |d: usize| x.get(from.saturating_sub(d)..).and_then(|x| x.get(..count)).unwrap_or_default();
    let [a, b, e, f] = back.map(part);
    const LANES: usize = 8;
    let (mut lanes, mut signed) = ([0.0; LANES], [0.0; LANES]);
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
            signed[k] += d;
        }
    }
    let (mut sum, mut plain): (f64, f64) = (lanes.iter().sum(), signed.iter().sum());
    for k in whole..count {
        let d = c[0] * a[k] + c[1] * b[k] + c[2] * e[k] + c[3] * f[k];
        sum += d * d;
        plain += d;
    }
    (sum, plain, count as u64)
}
