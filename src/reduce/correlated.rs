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
//! Segments learn from each other only where their noise is the same: those whose differences from block to block are clearly larger (a table
//! that turns beside one that stands) make a class of their own.

use super::innovations::{FLICKER_ALLAN, Process, Products, flicker, flicker_level, markov_lags, markov_mean};
use super::rounded;
use super::segment_blocks::SegmentBlocks;
use super::turning::{self, Designs, Turned};
use crate::elements::Elements;
use crate::number;
use crate::uncertainty::quantiles::{self, fisher_f_survival, normal_quantile};

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
/// A segment is noisier than the others if chance would make it so in fewer cases than this, all segments together.
const NOISIER: f64 = 1e-3;

/// Variances of differences that are further apart than this, and than chance allows (`NOISIER`), are of different noise. Differences between neighbours
/// are near enough to independent for noise of any correlation time; a quarter of their count is taken as degrees of freedom, since a logger's filter
/// may have smoothed them.
const APART: f64 = 3.0;
const FILTERED: f64 = 4.0;

enum Kind {
    White,
    Markov { tau: f64, ratio: f64 },
    Flicker { ratio: f64 },
}

struct Description {
    /// Place among those of its kind: of the correlation time, and of the ratio.
    place: (usize, usize),
    kind: Kind,
    prior: f64,
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
    fn variance(&self, start: f64, length: f64, record: f64) -> (f64, f64) {
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

/// Half the mean square difference of neighbouring blocks, not below what the edge of a step makes of it where the level lies at one, and the count of differences.
fn differences(segment: &SegmentBlocks) -> (f64, f64) {
    let (mut sum, mut count) = (0.0, 0.0);
    for piece in &segment.pieces {
        sum += piece.iter().zip(piece.iter().skip(1)).map(|(a, b)| (b - a).powi(2)).sum::<f64>();
        count += piece.len().saturating_sub(1) as f64;
    }
    ((0.5 * sum / f64::max(count, 1.0)).max(of_edge(segment)), count)
}

/// What an edge between two steps may add to the variance of a block, whatever the noise: segments that differ by less may differ in their place alone.
fn of_edge(segment: &SegmentBlocks) -> f64 {
    rounded::edge(segment) * segment.length / segment.samples.max(1) as f64
}

/// Segments whose noise is alike, by their numbers; the largest class first.
fn classes(seen: &[(f64, f64)]) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..seen.len()).filter(|k| seen.get(*k).is_some_and(|own| own.1 > 0.0)).collect();
    let value = |k: &usize| seen.get(*k).map_or(0.0, |own| own.0);
    let dof = |k: &usize| seen.get(*k).map_or(1.0, |own| (own.1 / FILTERED).max(1.0));
    order.sort_by(|a, b| value(a).total_cmp(&value(b)));
    let mut classes: Vec<Vec<usize>> = Vec::new();
    for k in order {
        let before = classes.last().and_then(|class| class.last());
        let other = before.is_some_and(|before| {
            let ratio = value(&k) / value(before);
            // a ratio that is no number separates nothing
            let chance = fisher_f_survival(ratio, dof(&k), dof(before)).unwrap_or(1.0);
            ratio > APART && chance * (seen.len() as f64) < NOISIER
        });
        match classes.last_mut().filter(|_| !other) {
            Some(class) => class.push(k),
            None => classes.push(vec![k]),
        }
    }
    // of classes of one size the calmest is first
    classes.sort_by_key(|class| std::cmp::Reverse(class.len()));
    // segments without differences say nothing of their own, and follow the others
    let silent = (0..seen.len()).filter(|k| seen.get(*k).is_none_or(|own| own.1 <= 0.0));
    match classes.first_mut() {
        Some(first) => first.extend(silent),
        None => classes.push(silent.collect()),
    }
    classes
}

/// The uncertainty of each segment's mean; `record` is the length of the whole record in blocks. A segment without pieces is one that may be read: its
/// uncertainty is the middling one of a mean over its length, with the noise of the others.
pub fn mean_uncertainties(segments: &[SegmentBlocks], record: f64, level: f64) -> Vec<MeanUncertainty> {
    let seen: Vec<(f64, f64)> = segments.iter().map(differences).collect();
    let classes = classes(&seen);
    if classes.len() < 2 {
        return alike(segments, record, level);
    }
    let mut all = vec![MeanUncertainty::default(); segments.len()];
    let middle =
        |class: &[usize]| class.get(class.len() / 2).and_then(|k| seen.get(*k)).map_or(1.0, |own| own.0.sqrt());
    // not empty: there are at least two
    let usual = classes.first().map_or(1.0, |first| middle(first));
    for (place, class) in classes.iter().enumerate() {
        let own: Vec<SegmentBlocks> = class.iter().filter_map(|k| segments.get(*k).cloned()).collect();
        for (k, mut found) in class.iter().zip(alike(&own, record, level)) {
            if place > 0 {
                found.apart = true;
                found.noisier *= middle(class) / usual;
            }
            if let Some(slot) = all.get_mut(*k) {
                *slot = found;
            }
        }
    }
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

/// The uncertainties of means over segments of the same noise.
fn alike(segments: &[SegmentBlocks], record: f64, level: f64) -> Vec<MeanUncertainty> {
    // a segment without samples is one that is asked about, and says nothing of the noise
    let mut lengths: Vec<f64> = segments.iter().filter(|s| !s.pieces.is_empty()).map(|s| s.length).collect();
    lengths.sort_by(f64::total_cmp);
    let middling = lengths.get(lengths.len() / 2).copied().unwrap_or(1.0); // no segments, no answers
    // likewise
    let most = lengths.last().copied().unwrap_or(1.0);
    let wide = number::count((most / LONGEST as f64).ceil().min((middling / LEAST as f64).floor()).max(1.0));
    let width = wide as f64;
    // blocks of the likelihood, in pieces that it can look at
    let mut designs = Designs::default();
    let pieces: Vec<Vec<Piece>> = segments.iter().map(|segment| looked_at(segment, wide, &mut designs)).collect();
    let longest = pieces.iter().flatten().map(|piece| piece.values.len()).max().unwrap_or(0);
    let contrasts: usize = pieces.iter().flatten().map(|piece| piece.contrasts).sum();
    let is_spread = |values: &[f64]| values.iter().any(|v| Some(v) != values.first());
    let spread_out = pieces.iter().flatten().any(|piece| is_spread(&piece.values));
    let of_steps = rounded::resolutions(segments, level);
    let plain = |(segment, resolution): (&SegmentBlocks, &f64)| {
        let resolution = *resolution;
        let white = segment.above.max(1.0) * segment.sd / (segment.samples.max(1) as f64).sqrt();
        let u = white.hypot(resolution);
        MeanUncertainty { u, middling: u, white, resolution, noisier: 1.0, ..MeanUncertainty::default() }
    };
    if contrasts < 3 || !spread_out {
        return segments.iter().zip(&of_steps).map(plain).collect();
    }
    let nu = contrasts as f64;
    struct Seen {
        description: Description,
        weight: f64,
        variance: f64,
        slopes: Vec<(f64, f64)>,
        own: Vec<(f64, f64)>,
    }
    let (first, between): (Vec<Description>, Vec<Description>) =
        descriptions(middling / width).into_iter().partition(|d| d.place.0 % COARSE == 0 && d.place.1 % COARSE == 0);
    let mut seen: Vec<Seen> = Vec::new();
    let mut queue: Vec<Description> = first;
    let mut later = Some(between);
    while !queue.is_empty() {
        for description in std::mem::take(&mut queue) {
            crate::stop::poll();
            let Some(process) = description.process(longest) else { continue };
            let (mut log, mut q) = (0.0, 0.0);
            let columns = designs.innovations(&process);
            let (mut slopes, mut own) = (Vec::new(), Vec::new());
            for segment in &pieces {
                let (mut t, mut tx, mut sum, mut dof) = (0.0, 0.0, 0.0, 0.0);
                for piece in segment {
                    let p: Products = match &piece.turned {
                        None => process.products(&piece.values),
                        Some(turned) => turning::products(&process, &piece.values, turned, &columns),
                    };
                    let residual = (p.xx - p.x1 * p.x1 / p.one).max(0.0);
                    sum += residual;
                    dof += piece.contrasts as f64;
                    t += p.tt - p.t1 * p.t1 / p.one;
                    tx += p.xt - p.t1 * p.x1 / p.one;
                    log -= 0.5 * (p.log + p.one.ln());
                }
                q += sum;
                own.push((sum, dof));
                slopes.push((if t > 0.0 { tx / t } else { 0.0 }, if t > 0.0 { 1.0 / t } else { 0.0 }));
            }
            let weight = description.prior.ln() + log - 0.5 * nu * q.max(1e-300).ln();
            seen.push(Seen { description, weight, variance: q / nu, slopes, own });
        }
        let Some(between) = later.take() else { break };
        let best = seen.iter().map(|s| s.weight).fold(f64::NEG_INFINITY, f64::max);
        queue = between
            .into_iter()
            .filter(|d| {
                seen.iter().any(|s| {
                    let near = |a: usize, b: usize| a.abs_diff(b) < COARSE;
                    std::mem::discriminant(&s.description.kind) == std::mem::discriminant(&d.kind)
                        && near(s.description.place.0, d.place.0)
                        && near(s.description.place.1, d.place.1)
                        && s.weight - best > LIKELY.ln()
                })
            })
            .collect();
    }
    let best = seen.iter().map(|s| s.weight).fold(f64::NEG_INFINITY, f64::max);
    let total: f64 = seen.iter().map(|s| (s.weight - best).exp()).sum();
    seen.iter_mut().for_each(|s| s.weight = (s.weight - best).exp() / total);
    let Some(likeliest) = seen.iter().max_by(|a, b| a.weight.total_cmp(&b.weight)) else {
        return segments.iter().zip(&of_steps).map(plain).collect();
    };
    segments
        .iter()
        .zip(&of_steps)
        .enumerate()
        .map(|(k, (segment, of_steps))| {
            let mut result = plain((segment, of_steps));
            let (start, length) = (segment.start / width, segment.length / width);
            let parts: Vec<(f64, f64, f64)> = seen
                .iter()
                .filter(|s| s.weight > 1e-7)
                .map(|s| (s.weight, 0.0, (s.variance * s.description.variance(start, length, record / width).0).sqrt()))
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
                    sum += weight * s.variance * s.description.variance(start, length, record / width).1;
                    all += weight;
                }
                (sum / all.max(f64::MIN_POSITIVE)).sqrt()
            };
            result.autocorrelation = family(true);
            result.allan_floor = family(false);
            // a segment without differences tells nothing of the noise
            let (f, dof) = likeliest.own.get(k).copied().unwrap_or((0.0, 0.0));
            let ratio = if dof > 0.0 { f / dof / likeliest.variance.max(of_edge(segment) / width) } else { 1.0 };
            // a ratio that is not finite is not called noisier
            let chance = fisher_f_survival(ratio, dof.max(1.0), nu).unwrap_or(1.0);
            if segments.len() > 1 && chance * (segments.len() as f64) < NOISIER {
                result.noisier = ratio.sqrt();
            }
            // of a level that stands beside harmonics
            let larger = result.noisier * segment.above.max(1.0);
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
            let (slope, variance) = likeliest.slopes.get(k).copied().unwrap_or((0.0, 0.0));
            result.slope = (slope / width, (variance * likeliest.variance).sqrt() * result.noisier / width);
            result.lag1 = lag1(pieces.at(k));
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
