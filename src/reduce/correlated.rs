//! The standard uncertainty of the mean of samples whose noise has a memory.
//!
//! Three descriptions of the noise are held side by side: white; white and a first-order Markov process (correlation times from half a block to
//! the length of a segment); white and flicker. The contrasts of block means within all segments of a channel, free of the segments' levels,
//! tell how probable each is (restricted likelihood, its scale integrated out). Each gives the variance of a mean over the segment:
//! that of white noise and of the Markov process about zero, that of flicker, which has no mean of its own, about the level of the whole record, and never below the
//! Allan variance at the segment's length. The mean's error is then a mixture of Student distributions, one for each description, and
//! u is its half interval divided by the normal factor, so that `1.96 u` covers 95 % however few the samples: what learning the noise
//! costs is in u, and no degrees of freedom need to be carried. What the rounding of a quantized channel leaves ([`super::rounded`]) is added to it in quadrature.
//!
//! Segments learn from each other only where their noise is the same, in size and in spectrum: a table that turns beside one that stands, a hand that trembles across gravity and not along it.
//!
//! The probability of the contrasts of a class is the integral of their restricted likelihood over the descriptions and over the size of the noise,
//!
//! ```text
//! p(class) = sum_d prior(d) prod |V_d|^-1/2 Gamma(nu/2) (pi Q_d)^(-nu/2) / ln(range)
//! ```
//!
//! the variance of the noise being alike in equal ratios over its range. The prior of a partition is that of C. E. Antoniak, Annals of Statistics 2 (1974), 1152, with the
//! parameter 1: `(n - 1)!` for each class of `n`. All segments are one class at first. A class is parted where two that follow each other in the order of their noise
//! are more probable, and single segments move where that is.

use super::innovations::{FLICKER_ALLAN, Process, Products, flicker, flicker_level, markov_lags, markov_mean};
use super::rounded;
use super::trace::SegmentBlocks;
use super::turning::{self, Designs, Turned};
use crate::elements::Elements;
use crate::number;
use crate::uncertainty::quantiles::{self, ln_gamma, normal_quantile};

/// The uncertainty of a mean and what it rests on.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct MeanUncertainty {
    /// Standard uncertainty: half of the interval of the level, divided by the normal factor.
    pub u: f64,
    /// What it would be for the middling description of the noise, of which it is known without doubt: half of their probability lies below.
    pub middling: f64,
    /// What it would be for noise without memory: `s/sqrt(n)`.
    pub white: f64,
    /// With the sum of the autocorrelations (white noise and a Markov process).
    pub autocorrelation: f64,
    /// The Allan deviation at the segment's length (white noise and flicker).
    pub allan_floor: f64,
    /// What the rounding of a quantized channel to its steps leaves in the mean (in `u`, in quadrature): `q/sqrt(12)` without noise, nothing with noise of half a step.
    pub resolution: f64,
    /// Degrees of freedom that the variance of the mean is known with (already in `u`).
    pub dof: f64,
    /// Correlation of neighbouring blocks within the segment.
    pub lag1: f64,
    /// Samples in such a block, in blocks of the trace.
    pub lag_blocks: f64,
    /// Slope per block of the trace, and its standard uncertainty with the noise as found.
    pub slope: (f64, f64),
    /// How much noisier than the others the segment is, as a ratio of standard deviations; 1 where it is not.
    pub noisier: f64,
    /// Is its noise so different that `u` rests on it alone, or on those like it, and not on all segments?
    pub apart: bool,
}

/// Longest piece that a likelihood looks at, in its blocks.
const LONGEST: usize = 256;
/// Least blocks of a middling segment.
const LEAST: usize = 64;
/// Weight of noise without memory before anything is seen; the other two kinds share the rest. Correlation times, in equal ratios, weigh inversely as
/// their roots: what covers 95 % from a hundredth to a third of a segment, by the seeded experiment of `tests/reduction/readings.rs`.
const PLAIN: f64 = 0.5;
const TIMES: usize = 28;
const RATIOS: usize = 31;
/// Largest variance of the process in variances of a white block: beyond what sampling a smooth process leaves of white noise.
const SMOOTH: f64 = 1e5;
const FLOORS: usize = 25;
/// Of the descriptions every third in each direction is tried first; those between are tried where a neighbour is likelier than this.
const COARSE: usize = 3;
const LIKELY: f64 = 1e-4;
#[derive(Debug, Clone, Copy)]
enum Kind {
    White,
    Markov { tau: f64, ratio: f64 },
    Flicker { ratio: f64 },
}

#[derive(Debug, Clone, Copy)]
struct Description {
    /// Place among those of its kind: of the correlation time, and of the ratio.
    place: (usize, usize),
    kind: Kind,
    pub prior: f64,
}

impl Description {
    /// The process at so many blocks, in variances of a white block. `None` where rounding leaves it no positive variance.
    fn process(&self, blocks: usize) -> Option<Process> {
        match self.kind {
            Kind::White => Process::markov(blocks, 0.0, 1.0),
            Kind::Markov { tau, ratio } => Process::markov(blocks, ratio, tau),
            Kind::Flicker { ratio } => {
                let white = std::iter::once(1.0).chain(std::iter::repeat(0.0));
                Process::new(&flicker(blocks).iter().zip(white).map(|(c, own)| ratio * c + own).collect::<Vec<f64>>())
            }
        }
    }

    /// Variance of a mean over `length` from `start` in a record of `record` blocks, in variances of a white block; and with flicker at its Allan floor.
    pub fn variance(&self, start: f64, length: f64, record: f64) -> (f64, f64) {
        let white = 1.0 / length;
        match self.kind {
            Kind::White => (white, white),
            Kind::Markov { tau, ratio } => {
                let v = white + ratio * markov_mean(length, tau);
                (v, v)
            }
            Kind::Flicker { ratio } => {
                (white + ratio * flicker_level(start, length, record), white + ratio * FLICKER_ALLAN)
            }
        }
    }
}

/// `from` to `to` in equal ratios.
fn spread(from: f64, to: f64, count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |k| from * (to / from).powf(k as f64 / (count.max(2) - 1) as f64))
}

fn descriptions(typical: f64) -> Vec<Description> {
    let mut all = vec![Description { place: (0, 0), kind: Kind::White, prior: PLAIN }];
    let with_memory = 0.5 * (1.0 - PLAIN);
    let taus: Vec<f64> = spread(0.5, typical.max(2.0), TIMES).collect();
    let roots: f64 = taus.iter().map(|tau| 1.0 / tau.sqrt()).sum();
    for (i, tau) in taus.into_iter().enumerate() {
        let ([block, _], _) = markov_lags(tau);
        let prior = with_memory / (tau.sqrt() * roots * RATIOS as f64);
        for (j, ratio) in spread(0.1, SMOOTH, RATIOS).enumerate() {
            all.push(Description { place: (i, j), kind: Kind::Markov { tau, ratio: ratio / block }, prior });
        }
    }
    let prior = with_memory / FLOORS as f64;
    let floors = spread(0.003, 30.0, FLOORS).enumerate();
    all.extend(floors.map(|(j, ratio)| Description { place: (0, j), kind: Kind::Flicker { ratio }, prior }));
    all
}

/// Part of a segment that a likelihood looks at.
struct Piece {
    /// Means of its blocks.
    values: Vec<f64>,
    /// The harmonics of the turn in it.
    turned: Option<Turned>,
    /// What it tells of the noise: its values less what is free in it.
    contrasts: usize,
}

/// The pieces of a segment that tell something, in blocks of `wide` means.
fn looked_at(segment: &SegmentBlocks, wide: usize, designs: &mut Designs) -> Vec<Piece> {
    let mut found = Vec::new();
    for (place, piece) in segment.pieces.iter().enumerate() {
        let angles = segment.angles.get(place).map(|own| own.chunks(LONGEST * wide));
        let mut angles = angles.into_iter().flatten();
        for blocks in piece.chunks(LONGEST * wide) {
            let values: Vec<f64> = blocks.chunks_exact(wide).map(|c| c.iter().sum::<f64>() / wide as f64).collect();
            let turned = angles.next().map(|own| designs.of(own, segment.harmonics, wide));
            let contrasts = turned.as_ref().map_or(values.len().saturating_sub(1), |own| own.contrasts(values.len()));
            if contrasts > 0 {
                found.push(Piece { values, turned, contrasts });
            }
        }
    }
    found
}

/// What the contrasts of a segment say of a description.
#[derive(Debug, Clone, Copy, Default)]
struct Own {
    /// Half of the logarithm of their determinant, negative.
    pub log: f64,
    /// Their weighted sum of squares, in variances of a white block.
    pub sum: f64,
    slope: f64,
    slope_variance: f64,
}

/// A description, and what each segment says of it.
struct Told {
    pub description: Description,
    pub own: Vec<Own>,
}

/// The segments of a channel in blocks of the likelihood, in pieces that it can look at.
struct Looked<'a> {
    pub segments: &'a [SegmentBlocks],
    /// Blocks of the trace in one of the likelihood.
    pub width: f64,
    pieces: Vec<Vec<Piece>>,
    /// What each segment tells of the noise.
    pub contrasts: Vec<f64>,
    designs: Designs,
    longest: usize,
    /// Of the rounding to steps.
    resolutions: Vec<f64>,
    record: f64,
    level: f64,
}

impl Looked<'_> {
    /// What so many of the segments say of a description; `None` where rounding leaves its process no positive variance.
    fn told(&self, description: Description, segments: &[usize]) -> Option<Told> {
        crate::stop::poll();
        let process = description.process(self.longest)?;
        let columns = self.designs.innovations(&process);
        let of = |pieces: &Vec<Piece>| {
            let (mut own, mut t, mut tx) = (Own::default(), 0.0, 0.0);
            for piece in pieces {
                let p: Products = match &piece.turned {
                    None => process.products(&piece.values),
                    Some(turned) => turning::products(&process, &piece.values, turned, &columns),
                };
                own.sum += (p.xx - p.x1 * p.x1 / p.one).max(0.0);
                own.log -= 0.5 * (p.log + p.one.ln());
                t += p.tt - p.t1 * p.t1 / p.one;
                tx += p.xt - p.t1 * p.x1 / p.one;
            }
            if t > 0.0 {
                (own.slope, own.slope_variance) = (tx / t, 1.0 / t);
            }
            own
        };
        let own = segments.iter().filter_map(|k| self.pieces.get(*k)).map(of).collect();
        Some(Told { description, own })
    }

    /// The middling standard deviation of the samples of a class.
    pub fn spread(&self, class: &[usize]) -> f64 {
        let mut all: Vec<f64> = class.iter().filter_map(|k| self.segments.get(*k)).map(|own| own.sd).collect();
        number::median(&mut all).unwrap_or(0.0) // no class is empty
    }

    /// Of noise without memory: what is known where nothing tells more.
    fn plain(&self, k: usize) -> MeanUncertainty {
        let Some(segment) = self.segments.get(k) else { return MeanUncertainty::default() };
        let resolution = self.resolutions.at(k);
        let white = segment.above.max(1.0) * segment.sd / (segment.samples.max(1) as f64).sqrt();
        let u = white.hypot(resolution);
        MeanUncertainty { u, middling: u, white, resolution, noisier: 1.0, ..MeanUncertainty::default() }
    }
}

/// The uncertainty of each segment's mean; `record` is the length of the whole record in blocks. A segment without pieces is one that may be read: its
/// uncertainty is the middling one of a mean over its length, with the noise of the others.
pub fn mean_uncertainties(segments: &[SegmentBlocks], record: f64, level: f64) -> Vec<MeanUncertainty> {
    // a segment without samples is one that is asked about, and says nothing of the noise
    let mut lengths: Vec<f64> = segments.iter().filter(|s| !s.pieces.is_empty()).map(|s| s.length).collect();
    lengths.sort_by(f64::total_cmp);
    let middling = lengths.get(lengths.len() / 2).copied().unwrap_or(1.0); // no segments, no answers
    // likewise
    let most = lengths.last().copied().unwrap_or(1.0);
    let wide = number::count((most / LONGEST as f64).ceil().min((middling / LEAST as f64).floor()).max(1.0));
    let mut designs = Designs::default();
    let pieces: Vec<Vec<Piece>> = segments.iter().map(|segment| looked_at(segment, wide, &mut designs)).collect();
    let contrasts = |own: &Vec<Piece>| own.iter().map(|piece| piece.contrasts).sum::<usize>() as f64;
    let looked = Looked {
        segments,
        width: wide as f64,
        contrasts: pieces.iter().map(contrasts).collect(),
        longest: pieces.iter().flatten().map(|piece| piece.values.len()).max().unwrap_or(0),
        pieces,
        designs,
        resolutions: rounded::resolutions(segments, level),
        record,
        level,
    };
    let is_spread = |values: &[f64]| values.iter().any(|v| Some(v) != values.first());
    let spread_out = looked.pieces.iter().flatten().any(|piece| is_spread(&piece.values));
    let mut all: Vec<MeanUncertainty> = (0..segments.len()).map(|k| looked.plain(k)).collect();
    if looked.contrasts.iter().sum::<f64>() < 3.0 || !spread_out {
        return all;
    }
    let (first, between): (Vec<Description>, Vec<Description>) = descriptions(middling / looked.width)
        .into_iter()
        .partition(|d| d.place.0 % COARSE == 0 && d.place.1 % COARSE == 0);
    let every: Vec<usize> = (0..segments.len()).collect();
    let told: Vec<Told> = first.into_iter().filter_map(|description| looked.told(description, &every)).collect();
    let classes = classes_of(&looked, &told);
    // not empty: there are contrasts
    let usual = classes.first().map_or(1.0, |first| looked.spread(first));
    for (place, class) in classes.iter().enumerate() {
        let apart = place > 0;
        let noisier = if apart { looked.spread(class) / usual } else { 1.0 };
        for (k, found) in class.iter().zip(alike(&looked, class, &told, &between)) {
            if let Some(slot) = all.get_mut(*k) {
                *slot = MeanUncertainty { apart, noisier, ..found };
            }
        }
    }
    all
}

/// The uncertainties of means over segments of the same noise.
fn alike(looked: &Looked<'_>, class: &[usize], coarse: &[Told], between: &[Description]) -> Vec<MeanUncertainty> {
    let (width, level) = (looked.width, looked.level);
    let nu: f64 = class.iter().map(|k| looked.contrasts.at(*k)).sum();
    if nu < 1.0 {
        return class.iter().map(|k| looked.plain(*k)).collect();
    }
    struct Seen {
        description: Description,
        weight: f64,
        variance: f64,
        own: Vec<Own>,
    }
    let together = |description: Description, own: Vec<Own>| {
        let log: f64 = own.iter().map(|own| own.log).sum();
        let q: f64 = own.iter().map(|own| own.sum).sum();
        let weight = description.prior.ln() + log - 0.5 * nu * q.max(1e-300).ln();
        Seen { description, weight, variance: q / nu, own }
    };
    let of_class = |told: &Told| class.iter().map(|k| told.own.get(*k).copied().unwrap_or_default()).collect();
    let mut seen: Vec<Seen> = coarse.iter().map(|told| together(told.description, of_class(told))).collect();
    let best = seen.iter().map(|s| s.weight).fold(f64::NEG_INFINITY, f64::max);
    let is_likely = |d: &&Description| {
        let near = |a: usize, b: usize| a.abs_diff(b) < COARSE;
        seen.iter().any(|s| {
            std::mem::discriminant(&s.description.kind) == std::mem::discriminant(&d.kind)
                && near(s.description.place.0, d.place.0)
                && near(s.description.place.1, d.place.1)
                && s.weight - best > LIKELY.ln()
        })
    };
    let finer: Vec<Description> = between.iter().filter(is_likely).copied().collect();
    let finer = finer.into_iter().filter_map(|description| looked.told(description, class));
    seen.extend(finer.map(|told| together(told.description, told.own)));
    let best = seen.iter().map(|s| s.weight).fold(f64::NEG_INFINITY, f64::max);
    let total: f64 = seen.iter().map(|s| (s.weight - best).exp()).sum();
    seen.iter_mut().for_each(|s| s.weight = (s.weight - best).exp() / total);
    let Some(likeliest) = seen.iter().max_by(|a, b| a.weight.total_cmp(&b.weight)) else {
        return class.iter().map(|k| looked.plain(*k)).collect();
    };
    class
        .iter()
        .enumerate()
        .map(|(place, k)| {
            let mut result = looked.plain(*k);
            let Some(segment) = looked.segments.get(*k) else { return result };
            let (start, length, record) = (segment.start / width, segment.length / width, looked.record / width);
            let parts: Vec<(f64, f64, f64)> = seen
                .iter()
                .filter(|s| s.weight > 1e-7)
                .map(|s| (s.weight, 0.0, (s.variance * s.description.variance(start, length, record).0).sqrt()))
                .collect();
            let family = |markov: bool| {
                let of = seen.iter().filter(|s| match s.description.kind {
                    Kind::Markov { .. } => markov,
                    Kind::Flicker { .. } => !markov,
                    Kind::White => false,
                });
                let (mut sum, mut all) = (0.0, 0.0);
                // relative to the likeliest of its kind, which may be far from likely
                let top = of.clone().map(|s| s.weight).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
                for s in of {
                    let weight = s.weight / top;
                    sum += weight * s.variance * s.description.variance(start, length, record).1;
                    all += weight;
                }
                (sum / all.max(f64::MIN_POSITIVE)).sqrt()
            };
            result.autocorrelation = family(true);
            result.allan_floor = family(false);
            // of a level that stands beside harmonics
            let larger = segment.above.max(1.0);
            result.middling = (weighted_median(&parts) * larger).hypot(result.resolution);
            // a mixture of plain numbers has an interval; it is the costly part, and of one that is asked about not wanted
            let asked = segment.pieces.is_empty().then_some(0.0);
            let half = asked.or_else(|| quantiles::mixture_half_interval(&parts, nu, level));
            let half = half.unwrap_or(0.0) * larger;
            // levels lie between 0 and 1
            let factor = normal_quantile(0.5 + 0.5 * level).unwrap_or(1.96);
            result.u = if asked.is_some() { result.middling } else { (half / factor).hypot(result.resolution) };
            let first: f64 = parts.iter().map(|(w, _, s)| w * s * s).sum();
            let second: f64 = parts.iter().map(|(w, _, s)| w * s.powi(4) * (1.0 + 2.0 / nu)).sum();
            result.dof = 2.0 * first * first / (second - first * first).max(1e-12 * second);
            // a segment without a slope of its own
            let own = likeliest.own.get(place).copied().unwrap_or_default();
            result.slope = (own.slope / width, (own.slope_variance * likeliest.variance).sqrt() / width);
            result.lag1 = lag1(looked.pieces.at(*k));
            result.lag_blocks = width;
            result
        })
        .collect()
}

/// The standard deviation below which half of the weight lies.
fn weighted_median(parts: &[(f64, f64, f64)]) -> f64 {
    let mut sorted: Vec<(f64, f64)> = parts.iter().map(|(weight, _, sd)| (*sd, *weight)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * sorted.iter().map(|own| own.1).sum::<f64>();
    let mut below = 0.0;
    let middle = sorted.iter().find(|own| {
        below += own.1;
        below >= half
    });
    // there is a likeliest description
    middle.map_or(0.0, |own| own.0)
}

/// Correlation of neighbouring values.
fn lag1(pieces: &[Piece]) -> f64 {
    let count: usize = pieces.iter().map(|piece| piece.values.len()).sum();
    let mean = pieces.iter().flat_map(|piece| &piece.values).sum::<f64>() / count.max(1) as f64;
    let (mut cross, mut own) = (0.0, 0.0);
    for Piece { values: piece, .. } in pieces {
        own += piece.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
        cross += piece.iter().zip(piece.iter().skip(1)).map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>();
    }
    if own > 0.0 { cross / own } else { 0.0 }
}

/// The logarithm of the range of a variance: from the last bit of a double to its first, each squared.
const RANGE: f64 = 2.0 * 52.0 * std::f64::consts::LN_2;
/// Below this share of what was taken away, a sum is what rounding leaves; probabilities whose logarithms differ by less of them are equal.
const LOST: f64 = 1e-9;

/// Segments of the same noise, and what they say together of each description: half of the logarithm of their determinant and the sum of their squares.
#[derive(Debug, Clone, Default)]
struct Class {
    count: usize,
    sums: Vec<(f64, f64)>,
    contrasts: f64,
    /// Logarithm of its probability.
    evidence: f64,
}

/// Classes, and the number of that to which each segment belongs; none for those that say nothing.
struct Partition {
    classes: Vec<Class>,
    of: Vec<Option<usize>>,
}

impl Partition {
    fn members(&self, class: usize) -> impl Iterator<Item = usize> {
        self.of.iter().enumerate().filter(move |(_, own)| **own == Some(class)).map(|(k, _)| k)
    }

    /// Takes out a class; those behind it move up.
    fn remove(&mut self, class: usize) {
        self.classes.remove(class);
        self.of.iter_mut().flatten().filter(|own| **own > class).for_each(|own| *own -= 1);
    }

    fn push(&mut self, class: Class, members: &[usize]) {
        for k in members {
            self.of.get_mut(*k).into_iter().for_each(|own| *own = Some(self.classes.len()));
        }
        self.classes.push(class);
    }
}

struct Parted<'a> {
    looked: &'a Looked<'a>,
    told: &'a [Told],
    /// Logarithm of each description's weight before anything is seen.
    priors: Vec<f64>,
    /// What the edges of steps may add to the variance of a block in each segment: those that differ by less may differ in their place in a step alone.
    edges: Vec<f64>,
}

impl Parted<'_> {
    /// What a segment says of each description.
    fn own(&self, k: usize) -> impl Iterator<Item = (f64, f64)> {
        let least = self.looked.contrasts.at(k) * self.edges.at(k);
        self.told.iter().map(move |told| {
            let own = told.own.get(k).copied().unwrap_or_default();
            (own.log, own.sum.max(least))
        })
    }

    /// The logarithm of the probability of so many segments that say this together, of so many contrasts.
    fn evidence(&self, sums: impl Iterator<Item = (f64, f64)>, count: usize, nu: f64) -> f64 {
        if count == 0 {
            return 0.0;
        }
        let of = |((log, sum), prior): ((f64, f64), &f64)| prior + log - 0.5 * nu * sum.max(f64::MIN_POSITIVE).ln();
        let logs: Vec<f64> = sums.zip(&self.priors).map(of).collect();
        number::log_sum(&logs) + ln_gamma(0.5 * nu) - RANGE.ln() + ln_gamma(count as f64)
    }

    fn class(&self, members: impl IntoIterator<Item = usize>) -> Class {
        let mut class = Class { sums: vec![(0.0, 0.0); self.told.len()], ..Class::default() };
        members.into_iter().for_each(|k| self.join(&mut class, k));
        class.evidence = self.evidence(class.sums.iter().copied(), class.count, class.contrasts);
        class
    }

    /// A segment in a class, whose evidence is for others to say.
    fn join(&self, class: &mut Class, k: usize) {
        class.count += 1;
        class.contrasts += self.looked.contrasts.at(k);
        class.sums.iter_mut().zip(self.own(k)).for_each(|(sum, own)| *sum = (sum.0 + own.0, sum.1 + own.1));
    }

    /// The class of one of the segments without it.
    fn without(&self, all: &Partition, class: usize, k: usize, own: &[(f64, f64)]) -> Option<Class> {
        let whole = all.classes.get(class)?;
        let sums: Vec<(f64, f64)> =
            whole.sums.iter().zip(own).map(|(sum, own)| (sum.0 - own.0, sum.1 - own.1)).collect();
        if sums.iter().zip(own).any(|(sum, own)| sum.1 < LOST * own.1) {
            let rest = all.members(class).filter(|other| *other != k).take(whole.count - 1);
            return Some(self.class(rest));
        }
        let (count, contrasts) = (whole.count - 1, whole.contrasts - self.looked.contrasts.at(k));
        let evidence = self.evidence(sums.iter().copied(), count, contrasts);
        Some(Class { count, sums, contrasts, evidence })
    }

    /// The size of a segment's noise: of a block as if it were white, and of a mean over a length by its likeliest description.
    fn sizes(&self, k: usize, length: f64) -> [f64; 2] {
        let nu = self.looked.contrasts.at(k);
        let of = |(told, (log, sum)): (&Told, (f64, f64))| {
            let weight = told.description.prior.ln() + log - 0.5 * nu * sum.max(f64::MIN_POSITIVE).ln();
            (weight, sum / nu, sum / nu * told.description.variance(0.0, length, length).1)
        };
        let all = || self.told.iter().zip(self.own(k)).map(of);
        // there are descriptions, the first of white noise
        let likeliest = all().max_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |own| own.2);
        [all().next().map_or(0.0, |own| own.1), likeliest]
    }

    /// The most probable two parts of a class of those that follow each other in the order of one of their sizes, if they are more probable than the class.
    fn cut(&self, all: &Partition, class: usize, sizes: &[[f64; 2]]) -> Option<[Vec<usize>; 2]> {
        let own = all.classes.get(class)?;
        let mut best = own.evidence + LOST * own.evidence.abs();
        let mut found = None;
        for key in 0..2 {
            let size = |k: &usize| sizes.get(*k).and_then(|own| own.get(key)).copied().unwrap_or(0.0);
            let mut order: Vec<usize> = all.members(class).collect();
            order.sort_by(|a, b| size(a).total_cmp(&size(b)));
            let ends = |order: &mut dyn Iterator<Item = usize>| -> Vec<f64> {
                let mut part = self.class([]);
                let grown = order.map(|k| {
                    self.join(&mut part, k);
                    self.evidence(part.sums.iter().copied(), part.count, part.contrasts)
                });
                grown.collect()
            };
            let (below, above) = (ends(&mut order.iter().copied()), ends(&mut order.iter().rev().copied()));
            let mut at = None;
            for (k, (below, above)) in below.iter().zip(above.iter().rev().skip(1)).enumerate() {
                if below + above > best {
                    (best, at) = (below + above, Some(k + 1));
                }
            }
            found = at.map(|at| (order, at)).or(found);
        }
        let (mut order, at) = found?;
        let rest = order.split_off(at);
        Some([order, rest])
    }

    /// Single segments to where they are most probable, until none moves.
    fn moved(&self, all: &mut Partition) {
        let mut moves = true;
        while moves {
            moves = false;
            for k in 0..all.of.len() {
                let Some(from) = all.of.get(k).copied().flatten() else { continue };
                crate::stop::poll();
                let own: Vec<(f64, f64)> = self.own(k).collect();
                let Some(rest) = self.without(all, from, k, &own) else { continue };
                let whole = all.classes.get(from).map_or(0.0, |class| class.evidence);
                let stays = whole - rest.evidence + LOST * whole.abs();
                let new = self.class([]);
                let others = all.classes.iter().chain([&new]).enumerate().filter(|(to, _)| *to != from);
                let gains = others.map(|(to, class)| {
                    let sums = class.sums.iter().zip(&own).map(|(sum, own)| (sum.0 + own.0, sum.1 + own.1));
                    let contrasts = class.contrasts + self.looked.contrasts.at(k);
                    let evidence = self.evidence(sums, class.count + 1, contrasts);
                    (evidence - class.evidence, to, evidence)
                });
                // of gains that are equal but for rounding the segment stays
                let best = gains.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|own| own.0 > stays);
                let Some((_, to, evidence)) = best else { continue };
                moves = true;
                if to == all.classes.len() {
                    all.push(new, &[]);
                }
                if let Some(class) = all.classes.get_mut(to) {
                    self.join(class, k);
                    class.evidence = evidence;
                }
                all.of.get_mut(k).into_iter().for_each(|own| *own = Some(to));
                let is_empty = rest.count == 0;
                all.classes.get_mut(from).into_iter().for_each(|slot| slot.clone_from(&rest));
                if is_empty {
                    all.remove(from);
                }
            }
        }
    }
}

/// The classes of segments of the same noise, by their numbers: the largest first, of classes of one size the calmest.
fn classes_of(looked: &Looked<'_>, told: &[Told]) -> Vec<Vec<usize>> {
    let count = looked.segments.len();
    let edge = |own: &SegmentBlocks| rounded::edge(own) * own.length / own.samples.max(1) as f64 / looked.width;
    let parted = Parted {
        looked,
        told,
        priors: told.iter().map(|told| told.description.prior.ln()).collect(),
        edges: looked.segments.iter().map(edge).collect(),
    };
    let (telling, silent): (Vec<usize>, Vec<usize>) = (0..count).partition(|k| looked.contrasts.at(*k) > 0.0);
    // of no segments: nothing to part
    let middling = |all: &mut Vec<f64>| number::median(all).unwrap_or(1.0);
    let length = middling(&mut telling.iter().map(|k| 1.0 + looked.contrasts.at(*k)).collect());
    let sizes: Vec<[f64; 2]> =
        (0..count).map(|k| if looked.contrasts.at(k) > 0.0 { parted.sizes(k, length) } else { [0.0; 2] }).collect();
    let mut all = Partition { classes: Vec::new(), of: vec![None; count] };
    all.push(parted.class(telling.iter().copied()), &telling);
    parted.moved(&mut all);
    while let Some((at, parts)) = (0..all.classes.len()).find_map(|at| Some((at, parted.cut(&all, at, &sizes)?))) {
        all.remove(at);
        parts.iter().for_each(|part| all.push(parted.class(part.iter().copied()), part));
        parted.moved(&mut all);
    }
    let mut classes: Vec<Vec<usize>> = vec![Vec::new(); all.classes.len()];
    let placed = all.of.iter().enumerate().filter_map(|(k, own)| Some((k, (*own)?)));
    placed.for_each(|(k, own)| classes.get_mut(own).into_iter().for_each(|class| class.push(k)));
    classes.sort_by(|a, b| b.len().cmp(&a.len()).then(looked.spread(a).total_cmp(&looked.spread(b))));
    // segments without contrasts say nothing of their own, and follow the others
    match classes.first_mut() {
        Some(first) => first.extend(silent),
        None => classes.push(silent),
    }
    classes
}
