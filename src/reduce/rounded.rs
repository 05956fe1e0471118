//! What the rounding of a channel to its steps leaves in a mean, however many samples it has.
//!
//! A value at the place `c` in a step `q`, with normal noise of standard deviation s, is rounded in the mean with the error
//! `e(c) = q/pi sum_k (-1)^k/k exp(-2 pi^2 k^2 s^2/q^2) sin(2 pi k c/q)`. Over places that are as likely everywhere it has the variance
//!
//! ```text
//! u^2(s) = q^2/(2 pi^2) sum_k exp(-4 pi^2 k^2 s^2/q^2)/k^2          q^2/12 where s is 0
//! ```
//!
//! (B. Widrow, I. Kollar, *Quantization Noise*, Cambridge University Press 2008). What is known of the place is in the variance of a segment's samples: `V(c, s)`, from 0 in the middle of a
//! step to about `q^2/4` at its end, and on the mean over all places `s^2 + q^2/12 - u^2(s)`. The likelihood of each s is the product over segments of the probability density of
//! their variances, all places alike, with the prior `1/s` of a standard deviation. For each segment it gives the places, and their errors, that its variance allows: `u` is their root mean
//! square, or more where 1.96 of it would not hold 95 %. One segment, two or many, of one level or of several: there is no other rule. A step that no two values show is the last decimal place of the value.

use super::trace::SegmentBlocks;
use crate::uncertainty::quantiles::{normal_quantile, normal_survival};
use std::sync::LazyLock;

/// Standard deviations of the noise on the grid, from where it reaches an edge from the last hundredth of a step only, up to one step, where `u(s)` is 1e-9 of a step; it falls by at most
/// 0.0152 of a step, a twentieth of its largest, from one to the next. And places in half a step (the other half is its mirror).
const NOISES: usize = 64;
const PLACES: usize = 32;

/// Less likely noises do not count: what they add is below the resolution of a place.
const LIKELY: f64 = 1e-4;

/// Variance of the samples at a place, of a variance from one sample, how far they spread in the place (uniform from one end to the other), and the error of their mean, in steps.
struct Place {
    variance: f64,
    scatter: f64,
    apart: f64,
    error: f64,
}

/// The places with a noise.
type Noise = Vec<Place>;

static NOISE: LazyLock<Vec<Noise>> = LazyLock::new(|| (0..NOISES).map(noise).collect());

fn noise(k: usize) -> Noise {
    let sd = (k as f64 + 0.5) / NOISES as f64;
    let moments = |place: usize| {
        let c = 0.5 * place as f64 / PLACES as f64;
        // the lower edges of levels, six standard deviations about the place at the largest noise: beyond lie 1e-9
        let below = |level: i32| normal_survival((c - f64::from(level) + 0.5) / sd).unwrap_or(0.0);
        let levels: Vec<(f64, f64)> = (-6..=7).map(|k| (f64::from(k), below(k + 1) - below(k))).collect();
        let mean: f64 = levels.iter().map(|(level, p)| level * p).sum();
        let about = |power: i32| levels.iter().map(|(level, p)| p * (level - mean).powi(power)).sum::<f64>();
        let variance = about(2);
        (variance, (about(4) - variance * variance).max(0.0), (mean - c).abs())
    };
    let own: Vec<(f64, f64, f64)> = (0..=PLACES).map(moments).collect();
    let between = |(a, b): (&(f64, f64, f64), &(f64, f64, f64))| Place {
        variance: 0.5 * (a.0 + b.0),
        scatter: 0.5 * (a.1 + b.1),
        apart: (b.0 - a.0).abs() / 12f64.sqrt(),
        error: a.2.max(b.2),
    };
    own.iter().zip(own.iter().skip(1)).map(between).collect()
}

/// Probability density of a segment's variance at each place; a variance has the resolution of one sample in all.
fn densities(noise: &Noise, segment: &SegmentBlocks) -> Vec<f64> {
    let (variance, samples) = ((segment.sd / segment.step).powi(2), segment.samples.max(1) as f64);
    let each = |place: &Place| {
        let square = place.scatter / samples + samples.powi(-2) + place.apart.powi(2);
        (-0.5 * (variance - place.variance).powi(2) / square).exp() / square.sqrt()
    };
    noise.iter().map(each).collect()
}

/// Do a segment's samples lie within few steps: is their variance below that of the largest noise that is tried? One whose samples drift
/// or turn over more takes all places, and its mean has no such error.
pub(super) fn is_rounded(segment: &SegmentBlocks) -> bool {
    segment.step > 0.0 && segment.sd.powi(2) < (1.0 + 1.0 / 12.0) * segment.step.powi(2)
}

/// The largest variance that samples on the two sides of an edge have, whatever the noise: below it, variances may differ by the place alone.
pub(super) fn edge(segment: &SegmentBlocks) -> f64 {
    0.25 * segment.step.powi(2)
}

/// The standard uncertainty that rounding leaves in the mean of each segment of one channel with one noise. One without pieces is asked about, and tells nothing of the noise.
pub(super) fn resolutions(segments: &[SegmentBlocks], level: f64) -> Vec<f64> {
    let seen = || segments.iter().filter(|own| !own.pieces.is_empty() && is_rounded(own));
    let log = |(k, noise): (usize, &Noise)| -> f64 {
        let prior = -(k as f64 + 0.5).ln();
        // so far from all places that a double has no density
        let one = |own| (densities(noise, own).iter().sum::<f64>() / PLACES as f64).max(f64::MIN_POSITIVE).ln();
        prior + seen().map(one).sum::<f64>()
    };
    let logs: Vec<f64> = NOISE.iter().enumerate().map(log).collect();
    let best = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weighed = NOISE.iter().zip(&logs).map(|(noise, own)| (noise, (own - best).exp()));
    let likely: Vec<(&Noise, f64)> = weighed.filter(|(_, weight)| *weight > LIKELY).collect();
    // levels lie between 0 and 1
    let factor = normal_quantile(0.5 + 0.5 * level).unwrap_or(1.96);
    let one = |segment: &SegmentBlocks| {
        if !is_rounded(segment) {
            return 0.0;
        }
        let mut errors: Vec<(f64, f64)> = Vec::new();
        for (noise, weight) in &likely {
            let own = densities(noise, segment);
            let all = own.iter().sum::<f64>().max(f64::MIN_POSITIVE);
            errors.extend(noise.iter().zip(own).map(|(place, own)| (place.error, weight * own / all)));
        }
        errors.sort_by(|a, b| b.0.total_cmp(&a.0));
        let all: f64 = errors.iter().map(|own| own.1).sum();
        let square = errors.iter().map(|(error, weight)| error * error * weight).sum::<f64>() / all;
        let mut beyond = 0.0;
        let half = errors.iter().find(|(_, weight)| {
            beyond += weight;
            beyond > (1.0 - level) * all
        });
        // nothing likely: nothing known
        let half = half.map_or(0.5, |own| own.0);
        segment.step * if all > 0.0 { square.sqrt().max(half / factor) } else { 12f64.sqrt().recip() }
    };
    segments.iter().map(one).collect()
}
