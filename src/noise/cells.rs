//! A record in some thousand cells, which double in length as it grows: the sums of its samples, and how many are missing. They give the record's slope,
//! where differences of means exist, and how much noise is in averages over the whole record.
#![allow(
    clippy::indexing_slicing,
    reason = "a list of cells is as long as `reach` makes it; weights and covariances have one entry for each edge of a cell, and one more row than averaging times"
)]

use crate::number;
use std::f64::consts::PI;

/// Most cells, and most of those by which slow noise is followed.
const MOST: usize = 4096;
const COARSE: usize = 256;
/// An averaging time of so many cells is seen.
const SEEN: f64 = 4.0;

/// Missing samples and sums of the others.
#[derive(Debug, Clone)]
pub(super) struct Cells {
    length: u64,
    cells: Vec<(f64, f64)>,
    /// Samples so far, those that are missing among them.
    places: u64,
    /// Where the last cell ends.
    end: u64,
}

impl Default for Cells {
    fn default() -> Self {
        Cells { length: 1, cells: Vec::new(), places: 0, end: 0 }
    }
}

impl Cells {
    /// One more sample, or `None`.
    pub fn push(&mut self, sample: Option<f64>) {
        if self.places >= self.end {
            self.reach(self.places);
            self.end = (self.places / self.length + 1) * self.length;
        }
        self.places += 1;
        let Some(cell) = self.cells.last_mut() else { return };
        match sample {
            Some(sample) => cell.1 += sample,
            None => cell.0 += 1.0,
        }
    }

    /// So many samples are missing.
    pub(crate) fn skip(&mut self, count: u64) {
        // numbers of samples that floats hold
        let end = self.places.saturating_add(count).min(1 << 53).max(self.places);
        self.reach(end.saturating_sub(1));
        while self.places < end {
            let next = ((self.places / self.length + 1) * self.length).min(end);
            let lost = (next - self.places) as f64;
            self.reach(self.places).0 += lost;
            self.places = next;
        }
        self.end = 0;
    }

    /// No difference reaches across this place.
    pub fn part(&mut self) {
        if let Some(last) = self.cells.last_mut() {
            last.0 = f64::INFINITY;
        }
    }

    fn reach(&mut self, place: u64) -> &mut (f64, f64) {
        while place / self.length >= MOST as u64 {
            self.cells = self.pairs();
            self.length *= 2;
        }
        let place = number::index(place / self.length);
        if place >= self.cells.len() {
            self.cells.resize(place + 1, (0.0, 0.0));
        }
        &mut self.cells[place]
    }

    fn pairs(&self) -> Vec<(f64, f64)> {
        self.cells.chunks(2).map(|two| two.iter().fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1))).collect()
    }

    /// Samples of a cell.
    pub(crate) fn length(&self) -> f64 {
        self.length as f64
    }

    /// Samples of a cell that are there, with the place of its middle.
    fn present(&self) -> Vec<(f64, f64)> {
        let length = self.length();
        let of = |k: usize| {
            let start = k as f64 * length;
            (length.min(self.places as f64 - start), start)
        };
        let all = self.cells.iter().enumerate();
        all.map(|(k, cell)| ((of(k).0 - cell.0).max(0.0), of(k).1 + 0.5 * of(k).0)).collect()
    }

    /// The slope of the record for each sample by least squares, its weights for the means of the cells, and its variance for white noise of one.
    pub(crate) fn slope(&self) -> (f64, Vec<f64>, f64) {
        let present = self.present();
        let all: f64 = present.iter().map(|(n, _)| n).sum();
        let middle = present.iter().map(|(n, t)| n * t).sum::<f64>() / all;
        let square: f64 = present.iter().map(|(n, t)| n * (t - middle).powi(2)).sum();
        let weights: Vec<f64> = present.iter().map(|(n, t)| n * (t - middle) / square).collect();
        let slope = present.iter().zip(&self.cells).map(|((_, t), cell)| cell.1 * (t - middle) / square).sum();
        (slope, weights, 1.0 / square)
    }

    /// The largest difference of neighbouring means in its standard deviations, those of the Allan variance at so many samples; where it begins its
    /// second mean, over how many samples, by how much, and how many differences there are. Means are over as many samples as make them normal, twice
    /// as many, and so on.
    pub(crate) fn largest_change(&self, variance: impl Fn(f64) -> f64) -> (Option<[f64; 4]>, usize) {
        /// The difference of two means over `n` samples of excess kurtosis `k` exceeds `z` standard deviations about `exp(k z^4 / 48 n)` times as often as a
        /// normal variable (its fourth cumulant): with Laplace's noise (3), at `z = 5`, 11 times.
        const NORMAL: u64 = 16;
        let mut cells = self.clone();
        let (mut largest, mut count): (Option<[f64; 4]>, usize) = (None, 0);
        // averaging times of a fifth of the record, as everywhere; the last cell may not be full
        while cells.cells.len() > 5 {
            let length = cells.length();
            let sd = (2.0 * variance(length)).sqrt();
            let pairs = cells.cells.windows(2).take(cells.cells.len() - 2).enumerate();
            for (k, pair) in pairs.filter(|(_, pair)| pair.iter().all(|cell| cell.0 == 0.0)) {
                if cells.length < NORMAL || !(sd > 0.0) {
                    break;
                }
                count += 1;
                let by = (pair[1].1 - pair[0].1) / length;
                if largest.is_none_or(|[most, ..]| by.abs() > most * sd) {
                    largest = Some([by.abs() / sd, (k + 1) as f64 * length, length, by]);
                }
            }
            cells.cells = cells.pairs();
            cells.length *= 2;
        }
        (largest, count)
    }

    /// Where differences of means over `m` samples begin, each of which has all but `share` of its samples, in cells.
    fn begins(&self, m: f64, share: f64) -> Vec<bool> {
        let reach = m / self.length();
        let mut sums = vec![0.0];
        let mut sum = 0.0;
        // an interruption counts as a whole averaging time
        sums.extend(self.cells.iter().map(|(lost, _)| {
            sum += lost.min(m);
            sum
        }));
        let before = |place: f64| {
            let at = number::count(place);
            let [a, b] = [at, at + 1].map(|k| sums.get(k).copied().unwrap_or(sum));
            a + (b - a) * (place - at as f64)
        };
        let last = self.places as f64 / self.length() - 2.0 * reach;
        let begins = |k: usize| {
            let [a, b, c] = [0.0, reach, 2.0 * reach].map(|d| before(k as f64 + d));
            k as f64 <= last && (b - a).max(c - b) <= share * m
        };
        (0..self.cells.len()).map(begins).collect()
    }

    /// The same, to count pairs; `None` where no sample is missing, or cells are too long to see.
    pub(crate) fn differences(&self, m: f64, share: f64) -> Option<Begins> {
        if !(m >= SEEN * self.length()) || self.cells.iter().all(|cell| cell.0 == 0.0) {
            return None;
        }
        let word = |bits: &[bool]| bits.iter().rev().fold(0_u64, |word, bit| word << 1 | u64::from(*bit));
        let words = self.begins(m, share).chunks(64).map(word).collect();
        Some(Begins { words, cell: self.length() }).filter(|begins| begins.count() > 0.0)
    }

    /// Covariances of the slope and of the mean differences over `m` samples, for each of the parts Q, N, B, K: the slope stands first. What cells are too
    /// long for is zero.
    pub(crate) fn means(&self, m: &[f64], share: f64) -> Vec<Vec<[f64; 4]>> {
        let mut coarse = self.clone();
        while coarse.cells.len() > COARSE {
            coarse.cells = coarse.pairs();
            coarse.length *= 2;
        }
        let length = coarse.length();
        let (_, slope, white) = coarse.slope();
        let points = coarse.cells.len() + 1;
        let mut weights: Vec<Option<Vec<f64>>> = vec![Some(vec![0.0; points])];
        if let Some(Some(own)) = weights.first_mut() {
            for (k, w) in slope.iter().enumerate() {
                own[k] -= w / length;
                own[k + 1] += w / length;
            }
        }
        for m in m {
            let reach = m / length;
            let begins = if reach >= SEEN { coarse.begins(*m, share) } else { Vec::new() };
            let count = begins.iter().filter(|b| **b).count() as f64;
            let mut own = vec![0.0; points];
            for k in (0..begins.len()).filter(|k| begins[*k]) {
                for (away, c) in [(0.0, 1.0), (reach, -2.0), (2.0 * reach, 1.0)] {
                    let place = k as f64 + away;
                    let (at, part) = (number::count(place), place.fract());
                    own[at.min(points - 1)] += c * (1.0 - part) / count;
                    own[(at + 1).min(points - 1)] += c * part / count;
                }
            }
            weights.push((count > 0.0).then_some(own));
        }
        let gamma: Vec<[f64; 4]> = (0..points)
            .map(|lag| {
                let (t, log) = (lag as f64 * length, (lag.max(1) as f64).ln());
                [f64::from(u8::from(lag == 0)), -0.5 * t, t * t * log / (2.0 * PI), t * t * t / 12.0]
            })
            .collect();
        let spread = |own: &Vec<f64>| -> Vec<[f64; 4]> {
            let at = |a: usize| {
                let mut sum = [0.0; 4];
                for (b, w) in own.iter().enumerate() {
                    sum.iter_mut().zip(gamma[a.abs_diff(b)]).for_each(|(sum, g)| *sum += w * g);
                }
                sum
            };
            (0..points).map(at).collect()
        };
        let spreads: Vec<Option<Vec<[f64; 4]>>> = weights.iter().map(|own| own.as_ref().map(spread)).collect();
        let product = |a: &Option<Vec<f64>>, b: &Option<Vec<[f64; 4]>>| {
            let mut sum = [0.0; 4];
            for (w, g) in a.iter().flatten().zip(b.iter().flatten()) {
                sum.iter_mut().zip(g).for_each(|(sum, g)| *sum += w * g);
            }
            sum
        };
        let mut all: Vec<Vec<[f64; 4]>> =
            weights.iter().map(|a| spreads.iter().map(|b| product(a, b)).collect()).collect();
        all[0][0][1] = white;
        all
    }
}

/// Cells in which differences begin.
pub(super) struct Begins {
    words: Vec<u64>,
    cell: f64,
}

impl Begins {
    /// How many cells.
    pub fn count(&self) -> f64 {
        self.words.iter().map(|word| f64::from(word.count_ones())).sum()
    }

    /// Pairs of cells, one of `other` by `lag` samples later.
    pub fn pairs(&self, other: &Begins, lag: f64) -> f64 {
        let (cells, at) = (lag / self.cell, (lag / self.cell).floor());
        let by = number::whole_i64(at);
        let part = cells - at;
        self.shifted(other, by) * (1.0 - part) + if part > 0.0 { self.shifted(other, by + 1) * part } else { 0.0 }
    }

    fn shifted(&self, other: &Begins, by: i64) -> f64 {
        let (words, bits) = (by.div_euclid(64), by.rem_euclid(64));
        let word = |k: i64| usize::try_from(k).ok().and_then(|k| other.words.get(k)).copied().unwrap_or(0);
        let joined = |k: i64| word(k) >> bits | if bits > 0 { word(k + 1) << (64 - bits) } else { 0 };
        self.words.iter().zip(words..).map(|(own, k)| f64::from((own & joined(k)).count_ones())).sum()
    }
}
