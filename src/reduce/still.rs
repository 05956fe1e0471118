//! Where a record stands still: windows whose variance is that of the still sensor.

use super::Trace;
use crate::number;

/// What the detector judged by.
#[derive(Debug, Clone, PartialEq)]
pub struct Stillness {
    /// Length of a window, s.
    pub window: f64,
    /// Largest variance of a still window, in variances of the still sensor.
    pub threshold: f64,
    /// Standard deviation of the still sensor, for each channel.
    pub still_sd: Vec<f64>,
    /// The threshold at which the first stretch of the least length would be still; where none was found.
    pub would_find: Option<f64>,
}

/// Which quantile of the windows' variances stands for the still sensor, and what it is of its variance.
const QUANTILE: f64 = 0.1;
const OF_STILL: f64 = 0.9;
/// Windows begin so often in the length of one.
const STRIDE: usize = 8;

/// Blocks of a window, and from where one begins to where the next one does.
fn windows(trace: &Trace, window: f64) -> (usize, usize) {
    let length = number::count((window / (trace.block as f64 * trace.interval)).round()).max(4);
    (length, (length / STRIDE).max(1))
}

/// The newest window that is whole: the sample at which it begins, counted from the first of all, and whether it is still by these standard
/// deviations of the still sensor.
pub(super) fn newest(trace: &Trace, window: f64, threshold: f64, still_sd: &[f64]) -> Option<(u64, bool)> {
    let (length, stride) = windows(trace, window);
    let blocks = trace.channels.first().map_or(0, |c| c.means.len());
    let start = blocks.checked_sub(length)? / stride * stride;
    let n = length as f64;
    let is_still = trace.channels.iter().zip(still_sd).take(trace.observed).all(|(channel, sd)| {
        let range = start..start + length;
        // a channel in blocks of one sample keeps no squares
        let inside = channel.squares.get(range.clone()).unwrap_or_default().iter().sum::<f64>() / trace.block as f64;
        let Some(own) = channel.means.get(range) else { return false };
        let mean = own.iter().sum::<f64>() / n;
        let square = own.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() + inside;
        !(*sd > 0.0) || square / (n - 1.0) <= threshold * sd * sd
    });
    Some((trace.before + (start * trace.block) as u64, is_still))
}

/// Still stretches in blocks, and what they were judged by. `window` and `least` in seconds.
pub(super) fn still(trace: &Trace, window: f64, threshold: f64, least: f64) -> (Vec<(usize, usize)>, Stillness) {
    let seconds = trace.block as f64 * trace.interval;
    let (length, stride) = windows(trace, window);
    let blocks = trace.channels.first().map_or(0, |c| c.means.len());
    let starts: Vec<usize> = (0..).map(|k| k * stride).take_while(|start| start + length <= blocks).collect();
    // short gaps are bridged: what moved in one shows in the window's variance; samples that are missing for as long as a window end it
    let lost: Vec<u64> = trace.resumes.iter().filter(|own| trace.missing(**own) >= window).map(|(at, _)| *at).collect();
    let broken = |start: usize| {
        let (from, to) = ((start * trace.block) as u64, ((start + length) * trace.block) as u64);
        let next = lost.partition_point(|sample| *sample <= from);
        !trace.dead_in(from, to).is_empty() || lost.get(next).is_some_and(|sample| *sample < to)
    };
    let is_broken: Vec<bool> = starts.iter().map(|start| broken(*start)).collect();
    let mut ratios = vec![0.0_f64; starts.len()];
    let mut still_sd = Vec::new();
    for (place, channel) in trace.channels.iter().enumerate() {
        // prefix sums about a middle value, so that squares keep their digits
        let middle = channel.means.get(blocks / 2).copied().unwrap_or(0.0); // a record shorter than a block has none
        let (mut sum, mut square) = (0.0, 0.0);
        let mut sums = vec![(0.0, 0.0)];
        for (k, v) in channel.means.iter().enumerate() {
            let d = v - middle;
            // a channel in blocks of one sample keeps no squares
            let inside = channel.squares.get(k).copied().unwrap_or(0.0) / trace.block as f64;
            (sum, square) = (sum + d, square + d * d + inside);
            sums.push((sum, square));
        }
        let variances: Vec<f64> = starts
            .iter()
            .map(|start| {
                let n = length as f64;
                // every channel has `blocks` blocks; a window that did not fit would be no number, and never still
                let (Some(from), Some(to)) = (sums.get(*start), sums.get(start + length)) else { return f64::NAN };
                let (s, q) = (to.0 - from.0, to.1 - from.1);
                ((q - s * s / n) / (n - 1.0)).max(0.0)
            })
            .collect();
        let whole = variances.iter().zip(&is_broken).step_by(STRIDE).filter(|(_, broken)| !**broken);
        let mut apart: Vec<f64> = whole.map(|(variance, _)| *variance).collect();
        apart.sort_by(f64::total_cmp);
        let step = channel.resolution();
        // none in a record shorter than a window
        let quantile = apart.get(number::count(apart.len() as f64 * QUANTILE)).copied().unwrap_or(0.0);
        let seen = (quantile / OF_STILL).max(step * step / 12.0);
        // what is known stands until the record is so much calmer that it would be told from what moves
        let known = trace.still_sd.get(place).map(|sd| sd * sd).filter(|known| *known > 0.0);
        let variance = known.filter(|known| *known <= threshold * seen).unwrap_or(seen);
        still_sd.push(variance.sqrt());
        if variance > 0.0 && place < trace.observed {
            ratios.iter_mut().zip(&variances).for_each(|(ratio, v)| *ratio = ratio.max(v / variance));
        }
    }
    let stretches = |threshold: f64| {
        let mut found: Vec<(usize, usize)> = Vec::new();
        for ((start, ratio), broken) in starts.iter().zip(&ratios).zip(&is_broken) {
            if *ratio > threshold || *broken {
                continue;
            }
            match found.last_mut() {
                Some((_, end)) if *start < *end => *end = start + length,
                _ => found.push((*start, start + length)),
            }
        }
        found
    };
    let found = stretches(threshold);
    let long = |found: &[(usize, usize)]| found.iter().any(|(a, b)| (b - a) as f64 * seconds >= least);
    let mut would_find = None;
    if !long(&found) {
        let (mut low, mut high) = (threshold, ratios.iter().copied().fold(threshold, f64::max) * 1.01);
        if long(&stretches(high)) {
            for _ in 0..40 {
                let middle = (low * high).sqrt();
                if long(&stretches(middle)) { high = middle } else { low = middle }
            }
            would_find = Some(high);
        }
    }
    (found, Stillness { window, threshold, still_sd, would_find })
}
