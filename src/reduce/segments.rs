//! Segments: by a column's labels, by times, or where the record stands still.

use super::trace::{Channel, Segment};
use super::{Event, EventKind, Stillness, Trace, still};
use crate::number;
use std::ops::Range;

/// A stretch that does not become a reading.
#[derive(Debug, Clone, PartialEq)]
pub struct Rejected {
    /// Its samples.
    pub samples: Range<u64>,
    /// Why.
    pub reason: String,
}

/// How segments are found.
#[derive(Debug, Clone, PartialEq)]
pub enum By {
    /// Runs of equal labels.
    Labels,
    /// Label, start and end in seconds since the first sample.
    Times(Vec<(String, f64, f64)>),
    /// Where the record stands still.
    Still {
        /// Length of a window, s.
        window: f64,
        /// Largest variance of a still window, in variances of the still sensor.
        threshold: f64,
    },
}

/// Segments and what was rejected.
#[derive(Debug, Clone, PartialEq)]
pub struct Segmentation {
    /// The segments.
    pub segments: Vec<Segment>,
    /// The rest, with reasons.
    pub rejected: Vec<Rejected>,
    /// What the detector judged by.
    pub stillness: Option<Stillness>,
}

/// Levels before and after a jerk that differ by less than this many standard deviations of a sample are one position.
const SAME: f64 = 2.0;
/// A step between them of more than so many of its standard uncertainties is said: white noise makes one in 16,000.
const STEP: f64 = 4.0;
/// Of each of them so many windows are looked at: four of the means over four windows whose second differences say how steady a drift is ([`Noise`]).
const NEAR: usize = 16;

/// Find segments; `guard` is left out at both ends, shorter ones than `least` are rejected (both in seconds).
pub fn segment(trace: &Trace, by: &By, guard: f64, least: f64) -> Segmentation {
    let mut stillness = None;
    let candidates: Vec<Segment> = match by {
        By::Labels => trace
            .runs
            .iter()
            .filter(|run| !run.label.trim().is_empty())
            .map(|run| Segment { label: run.label.clone(), pieces: one(run.start..run.end), notes: Vec::new() })
            .collect(),
        By::Times(list) => list
            .iter()
            .map(|(label, start, end)| Segment {
                label: label.clone(),
                pieces: one(trace.sample(*start)..trace.sample(*end)),
                notes: trace.cut(*start, *end).into_iter().collect(),
            })
            .collect(),
        By::Still { window, threshold } => {
            let (found, judged) = still::still(trace, *window, *threshold, least);
            let window = judged.window;
            stillness = Some(judged);
            let block = trace.block as u64;
            let found = found.into_iter().map(|(a, b)| a as u64 * block..b as u64 * block).collect();
            joined(trace, found, 4.0 * window, stillness.as_ref())
        }
    };
    let margin = number::count_u64((guard / trace.interval).round());
    let (mut segments, mut rejected): (Vec<Segment>, Vec<Rejected>) = Default::default();
    for mut segment in candidates {
        let (start, end) = segment.span();
        // samples on both sides of a gap count; what is missing is said
        let cuts: Vec<f64> = segment
            .pieces
            .iter()
            .flat_map(|p| trace.resumes_in(p.start, p.end))
            .map(|own| trace.missing(*own))
            .collect();
        if !cuts.is_empty() {
            let (n, missing) = (cuts.len(), cuts.iter().sum::<f64>());
            segment.notes.push(match n {
                1 => format!("1 gap bridged, {missing:.3} s missing"),
                n => format!("{n} gaps bridged, {missing:.3} s missing"),
            });
        }
        let pieces =
            segment.pieces.iter().map(|p| (p.start + margin).min(p.end)..p.end.saturating_sub(margin).max(p.start));
        let guarded: Vec<Range<u64>> = pieces.filter(|p| p.end > p.start).collect();
        let alive: Vec<Range<u64>> = guarded.iter().flat_map(|p| trace.alive(p.start, p.end)).collect();
        let samples = |pieces: &[Range<u64>]| pieces.iter().map(|p| p.end - p.start).sum::<u64>();
        let dead = samples(&guarded) - samples(&alive);
        segment.pieces = alive.into_iter().filter(|p| !trace.blocks(p.start, p.end).is_empty()).collect();
        // what is stuck or at a rail most of the time tells nothing of the position
        if dead > segment.samples() {
            let reason = words(trace, start, end).into_iter().next().unwrap_or_default();
            rejected.push(Rejected { samples: start..end, reason });
            continue;
        }
        let is_touched = |channel: &&Channel| {
            let own = channel.events.iter().filter(|event| event.kind == EventKind::Saturation);
            own.into_iter().any(|event| event.sample < end && event.sample + event.length > start)
        };
        let touched = trace.channels.iter().take(trace.observed).filter(is_touched);
        if let Some(channel) = touched.into_iter().find(|channel| channel.is_cut(trace, &segment)) {
            let (all, name) = (samples(&guarded), &channel.name);
            let reason = format!(
                "{name} is saturated: its noise is cut at the rail ({dead} of {all} samples), and the mean of the others is biased"
            );
            rejected.push(Rejected { samples: start..end, reason });
            continue;
        }
        if dead > 0 {
            let s = if dead == 1 { "" } else { "s" };
            segment
                .notes
                .extend(words(trace, start, end).iter().map(|why| format!("{dead} sample{s} left out: {why}")));
        }
        let left = segment.samples() as f64 * trace.interval;
        let whole = (end.saturating_sub(start)) as f64 * trace.interval;
        if let (By::Times(_), true, Some(cut)) = (by, start == end, segment.notes.first()) {
            rejected.push(Rejected { samples: start..end, reason: cut.clone() });
            continue;
        }
        if left < least || segment.pieces.is_empty() {
            let guards = if margin > 0 { format!(", {:.3} s without the guard times", left) } else { String::new() };
            rejected.push(Rejected {
                samples: start..end,
                reason: format!("{whole:.3} s long{guards}: shorter than {least} s"),
            });
            continue;
        }
        segments.push(segment);
    }
    if let Some(still) = &stillness {
        let window = number::count_u64((still.window / trace.interval).ceil());
        let spans: Vec<(u64, u64)> = segments.iter().map(Segment::span).collect();
        let judged = |dead: &Range<u64>| {
            let of = |own: &Rejected| own.samples.start < dead.end && dead.start < own.samples.end;
            spans.iter().any(|(start, end)| *start < dead.end && dead.start < *end) || rejected.iter().any(of)
        };
        let long = together(&trace.dead, window)
            .filter(|dead| (dead.end - dead.start) as f64 * trace.interval >= least && !judged(dead));
        let long: Vec<Rejected> = long
            .map(|dead| Rejected {
                reason: words(trace, dead.start, dead.end).into_iter().next().unwrap_or_default(),
                samples: dead,
            })
            .collect();
        rejected.extend(long);
        rejected.sort_by_key(|own| own.samples.start);
    }
    Segmentation { segments, rejected, stillness }
}

impl Segmentation {
    /// Segments that nothing names are called by their number.
    pub(crate) fn number(&mut self) {
        for (k, segment) in self.segments.iter_mut().enumerate().filter(|(_, s)| s.label.is_empty()) {
            segment.label = (k + 1).to_string();
        }
    }
}

/// Why samples `start..end` are left out: channels that are stuck or saturated there.
fn words(trace: &Trace, start: u64, end: u64) -> Vec<String> {
    let dead = |event: &Event| {
        matches!(event.kind, EventKind::Stuck | EventKind::Saturation)
            && event.sample < end
            && event.sample + event.length > start
    };
    let mut found: Vec<String> = Vec::new();
    for channel in trace.channels.iter().take(trace.observed) {
        let kinds = [(EventKind::Saturation, "saturated"), (EventKind::Stuck, "stuck at one value")];
        let of = |kind: EventKind| channel.events.iter().any(|event| event.kind == kind && dead(event));
        found.extend(kinds.iter().find(|(kind, _)| of(*kind)).map(|(_, word)| format!("{} is {word}", channel.name)));
    }
    found
}

/// Stretches that follow each other within so many samples, as one: in a window in which samples are dead now and again nothing stands still.
pub(crate) fn together(stretches: &[Range<u64>], within: u64) -> impl Iterator<Item = Range<u64>> {
    let near = stretches.chunk_by(move |a, b| b.start <= a.end + within);
    near.filter_map(|all| Some(all.first()?.start..all.iter().map(|own| own.end).max()?))
}

/// A segment of one piece.
fn one(range: Range<u64>) -> Vec<Range<u64>> {
    std::iter::once(range).collect()
}

/// Still stretches with nothing but a jerk between them, after which every channel reads what it read before, are one position.
fn joined(trace: &Trace, found: Vec<Range<u64>>, most: f64, stillness: Option<&Stillness>) -> Vec<Segment> {
    let mut segments: Vec<Segment> = Vec::new();
    let level = |range: &Range<u64>, k: usize| {
        let blocks = trace.blocks(range.start, range.end);
        // a range beyond the trace has no blocks
        trace.channels.get(k).and_then(|c| c.means.get(blocks)).map(<[f64]>::to_vec).unwrap_or_default()
    };
    let near = number::count((0.25 * most / (trace.interval * trace.block as f64)).ceil());
    let noises: Vec<Noise> = (0..trace.observed)
        .map(|k| {
            let sd = stillness.and_then(|s| s.still_sd.get(k)).map_or(0.0, |sd| sd / (trace.block as f64).sqrt());
            Noise::new(sd, 4 * near.max(1), found.iter().map(|range| level(range, k)))
        })
        .collect();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    for range in found {
        if let Some(last) = segments.last_mut()
            && let Some(before) = last.pieces.last().cloned()
            && trace.time(range.start) - trace.time(before.end.saturating_sub(1)) - trace.interval <= most
            && trace.dead_in(before.end, range.start).is_empty()
        {
            // near the jerk, so that a slow drift does not look like another position; or where the drifts on both sides meet, a little
            // away from it, so that its rest in the first half window does not
            let apart = (range.start - before.end) as f64 / trace.block as f64;
            let same = (0..trace.observed).all(|k| {
                let (mut a, b) = (level(&before, k), level(&range, k));
                a.reverse();
                let (first, second) = (a.get(..near.min(a.len())), b.get(..near.min(b.len())));
                // not judged by stillness: alike only where equal
                let sd = stillness.and_then(|s| s.still_sd.get(k)).copied().unwrap_or(0.0);
                let alike = |a: f64, b: f64| (a - b).abs() <= SAME * sd;
                // the lengths were cut to those that there are
                alike(mean(first.unwrap_or_default()), mean(second.unwrap_or_default()))
                    || match (ahead(&a, near, 0.5 * apart), ahead(&b, near, 0.5 * apart)) {
                        (Some(a), Some(b)) => alike(a, b),
                        _ => false,
                    }
            });
            if same {
                let jerk = (range.start - before.end) as f64 * trace.interval;
                last.notes.push(format!("a disturbance of {jerk:.2} s left out"));
                for (k, (noise, channel)) in noises.iter().zip(&trace.channels).enumerate() {
                    let mut before = level(&before, k);
                    before.reverse();
                    let Some(step) = noise.step(&before, &level(&range, k), apart, near) else { continue };
                    let (column, step) = (&channel.name, format!("{step:+.2e} {}", channel.unit));
                    let step = step.trim_end();
                    last.notes
                        .push(format!("{column} changes by {step} across a disturbance: check for another position"));
                }
                last.pieces.push(range);
                continue;
            }
        }
        segments.push(Segment { label: String::new(), pieces: vec![range], notes: Vec::new() });
    }
    segments
}

/// A straight line through values from half a window to three windows (`near` values each) from where they begin, at `before` values before it.
fn ahead(values: &[f64], near: usize, before: f64) -> Option<f64> {
    let skipped = near / 2;
    let used = values.get(skipped..values.len().min(3 * near)).filter(|used| used.len() >= near)?;
    let line = Line::of(used, skipped as f64);
    Some(line.mean - line.products / line.squares * (line.middle + before))
}

/// The noise of a channel at rest.
struct Noise {
    /// Variance of a block.
    white: f64,
    /// By how much the difference of neighbouring means of one position varies beyond white noise and a steady drift: slow noise, settling.
    slow: f64,
}

impl Noise {
    /// From the standard deviation of a block, and stretches at rest in means of so many blocks: of three means in a row the second difference is free of a drift.
    fn new(sd: f64, blocks: usize, stretches: impl Iterator<Item = Vec<f64>>) -> Self {
        let (mut squares, mut count) = (0.0, 0.0);
        for stretch in stretches {
            let means: Vec<f64> =
                stretch.chunks_exact(blocks).map(|own| own.iter().sum::<f64>() / blocks as f64).collect();
            for (a, (b, c)) in means.iter().zip(means.iter().skip(1).zip(means.iter().skip(2))) {
                squares += (a - 2.0 * b + c) * (a - 2.0 * b + c);
                count += 1.0;
            }
        }
        let white = sd * sd;
        let slow = if count > 0.0 { squares / count / 3.0 - 2.0 * white / blocks as f64 } else { 0.0 };
        Noise { white, slow: slow.max(0.0) }
    }

    /// The step between two stretches, where it is more than noise explains beside a drift that they share. `before` runs backwards from the jerk, `after` forwards, `apart` blocks lie between them.
    ///
    /// Least squares of a line through both with a step between them: `step = m_b - m_a - s (t_b - t_a)`, `u^2 = white (1/n_a + 1/n_b + (t_b - t_a)^2 / (S_a + S_b)) + slow`, with the means `m`, the
    /// middle times `t`, the sums of squared times `S` and the common slope `s`. Only what is near the jerk is taken, without the half window in which it comes to rest.
    fn step(&self, before: &[f64], after: &[f64], apart: f64, window: usize) -> Option<f64> {
        let [a, b] = [before, after].map(|own| {
            let rest = if own.len() > 2 * window { window / 2 } else { 0 };
            Line::of(own.get(rest..own.len().min(NEAR * window)).unwrap_or_default(), rest as f64)
        });
        let squares = a.squares + b.squares;
        // backwards: the slope of the time that runs on is the negative one
        let slope = if squares > 0.0 { (b.products - a.products) / squares } else { 0.0 };
        let way = a.middle + b.middle + apart + 1.0;
        let step = b.mean - a.mean - slope * way;
        let lever = if squares > 0.0 { way * way / squares } else { 0.0 };
        let variance = self.white * (1.0 / a.count + 1.0 / b.count + lever) + self.slow;
        (step * step > STEP * STEP * variance).then_some(step)
    }
}

/// Values at times 0, 1, 2, ... after some: their mean, its time, and sums about both.
struct Line {
    count: f64,
    mean: f64,
    middle: f64,
    squares: f64,
    products: f64,
}

impl Line {
    fn of(values: &[f64], from: f64) -> Self {
        let count = values.len().max(1) as f64;
        let (mean, middle) = (values.iter().sum::<f64>() / count, 0.5 * (count - 1.0));
        let products = values.iter().zip(0..).map(|(v, k)| (f64::from(k) - middle) * (v - mean)).sum();
        Line { count, mean, middle: from + middle, squares: count * (count * count - 1.0) / 12.0, products }
    }
}
