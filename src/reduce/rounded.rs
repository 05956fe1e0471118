//! What the rounding of a channel to its steps leaves in a mean, however many samples it has.
//!
//! A value at the place `c` in a step `q`, with normal noise of standard deviation s, is rounded in the mean with the error
//! `e(c) = q/pi sum_k (-1)^k/k exp(-2 pi^2 k^2 s^2/q^2) sin(2 pi k c/q)`. Over places that are as likely everywhere it has the variance
//!
//! ```text
//! u^2(s) = q^2/(2 pi^2) sum_k exp(-4 pi^2 k^2 s^2/q^2)/k^2          q^2/12 where s is 0
//! ```
//!
//! (B. Widrow, I. Kollar, *Quantization Noise*, Cambridge University Press 2008). The noise s is estimated from the variances of the samples in several segments: at a place the
//! variance is `V(c, s)`, from 0 in the middle of a step to about `q^2/4` at its end, and on the mean over all places `s^2 + q^2/12 - u^2(s)`. The likelihood of each s is the
//! product over segments of the probability density of their variances, with their places unknown. With a flat prior of s it gives a mixture of normal distributions of
//! standard deviations `u(s)`; the half interval of this mixture, divided by the normal factor, is the result.

use super::segment_blocks::SegmentBlocks;
use crate::uncertainty::quantiles::{mixture_half_interval, normal_quantile, normal_survival};
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Standard deviations of the noise on the grid, up to one step, where `u(s)` is 1e-9 of a step: it falls by at most 0.0152 of a step, a twentieth of its largest, from one to the
/// next. And places in half a step (the other half is its mirror).
const NOISES: usize = 64;
const PLACES: usize = 32;

/// Variance of the samples at a place, of a variance from one sample, and how far apart the variances of neighbouring places are.
struct Place {
    variance: f64,
    scatter: f64,
    apart: f64,
}

/// A noise, in steps.
struct Noise {
    /// The standard deviation of the error of rounded means.
    u: f64,
    places: Vec<Place>,
}

static NOISE: LazyLock<Vec<Noise>> = LazyLock::new(|| (0..NOISES).map(noise).collect());

fn noise(k: usize) -> Noise {
    let sd = (k as f64 + 0.5) / NOISES as f64;
    // terms beyond are below 1e-9: exp(-4 pi^2 k^2 sd^2) at the least sd, and 1/k^2
    let terms = (1..500).map(|k| f64::from(k).powi(2)).map(|square| (-4.0 * PI * PI * square * sd * sd).exp() / square);
    let moments = |place: usize| {
        let c = 0.5 * place as f64 / PLACES as f64;
        // the lower edges of levels, six standard deviations about the place at the largest noise: beyond lie 1e-9
        let below = |level: i32| normal_survival((c - f64::from(level) + 0.5) / sd).unwrap_or(0.0);
        let levels: Vec<(f64, f64)> = (-6..=7).map(|k| (f64::from(k), below(k + 1) - below(k))).collect();
        let mean: f64 = levels.iter().map(|(level, p)| level * p).sum();
        let about = |power: i32| levels.iter().map(|(level, p)| p * (level - mean).powi(power)).sum::<f64>();
        let variance = about(2);
        (variance, (about(4) - variance * variance).max(0.0))
    };
    let own: Vec<(f64, f64)> = (0..=PLACES).map(moments).collect();
    let between = |(a, b): (&(f64, f64), &(f64, f64))| Place {
        variance: 0.5 * (a.0 + b.0),
        scatter: 0.5 * (a.1 + b.1),
        apart: (b.0 - a.0).abs(),
    };
    let places = own.iter().zip(own.iter().skip(1)).map(between).collect();
    Noise { u: (terms.sum::<f64>() / (2.0 * PI * PI)).sqrt(), places }
}

impl Noise {
    /// Logarithm of the probability density of a variance of so many samples, the place unknown.
    fn log_density(&self, variance: f64, samples: f64) -> f64 {
        let each = |place: &Place| {
            // a variance has the resolution of one sample in all
            let square = place.scatter / samples + samples.powi(-2) + place.apart.powi(2);
            -0.5 * ((variance - place.variance).powi(2) / square + square.ln())
        };
        let all: Vec<f64> = self.places.iter().map(each).collect();
        let best = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        best + (all.iter().map(|own| (own - best).exp()).sum::<f64>() / PLACES as f64).ln()
    }
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

/// The standard uncertainty that rounding leaves in the means of the rounded segments of one channel with one noise. Where the noise cannot be estimated (no segment has
/// two levels, or a single segment has no more than two) it is that without noise, `q/sqrt(12)`.
pub(super) fn resolution(segments: &[SegmentBlocks], level: f64) -> f64 {
    let seen: Vec<&SegmentBlocks> = segments.iter().filter(|own| !own.pieces.is_empty() && is_rounded(own)).collect();
    let step = segments.iter().map(|own| own.step).fold(0.0, f64::max);
    let silent = step / 12f64.sqrt();
    let two = |own: &SegmentBlocks| own.sd.powi(2) * (own.samples.max(2) - 1) as f64 <= edge(own) * own.samples as f64;
    if !seen.iter().any(|own| own.sd > 0.0) || matches!(seen.as_slice(), [own] if two(own)) {
        return silent;
    }
    let log = |noise: &Noise| -> f64 {
        seen.iter().map(|own| noise.log_density((own.sd / own.step).powi(2), own.samples.max(1) as f64)).sum()
    };
    let logs: Vec<f64> = NOISE.iter().map(log).collect();
    let best = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let all: f64 = logs.iter().map(|own| (own - best).exp()).sum();
    let parts: Vec<(f64, f64, f64)> =
        NOISE.iter().zip(&logs).map(|(noise, own)| ((own - best).exp() / all, 0.0, noise.u)).collect();
    // plain numbers: a mixture has an interval, and levels lie between 0 and 1
    let half = mixture_half_interval(&parts, f64::INFINITY, level).zip(normal_quantile(0.5 + 0.5 * level));
    half.map_or(silent, |(half, factor)| (step * half / factor).min(silent))
}
