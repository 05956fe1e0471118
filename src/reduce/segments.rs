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
                notes: Vec::new(),
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
                "{name} is saturated: its noise is cut at the rail ({dead} of {all} samples), and the mean of the others is off"
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
    if matches!(by, By::Still { .. }) {
        let long = trace.dead.iter().filter(|dead| (dead.end - dead.start) as f64 * trace.interval >= least);
        rejected.extend(long.map(|dead| Rejected {
            samples: dead.clone(),
            reason: words(trace, dead.start, dead.end).into_iter().next().unwrap_or_default(),
        }));
        rejected.sort_by_key(|own| own.samples.start);
    }
    for (k, segment) in segments.iter_mut().enumerate().filter(|(_, s)| s.label.is_empty()) {
        segment.label = (k + 1).to_string();
    }
    Segmentation { segments, rejected, stillness }
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
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    for range in found {
        if let Some(last) = segments.last_mut()
            && let Some(before) = last.pieces.last().cloned()
            && trace.time(range.start) - trace.time(before.end.saturating_sub(1)) - trace.interval <= most
            && trace.dead_in(before.end, range.start).is_empty()
        {
            // near the jerk, so that a slow drift does not look like another position; or where the drifts on both sides meet, a little
            // away from it, so that its rest in the first half window does not
            let near = number::count((0.25 * most / (trace.interval * trace.block as f64)).ceil());
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
                last.notes.push(format!("a jerk of {jerk:.2} s left out"));
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
    let used = values.get(skipped..values.len().min(3 * near))?;
    if used.len() < near {
        return None;
    }
    let n = used.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let mean = used.iter().sum::<f64>() / n;
    let slope = used.iter().enumerate().map(|(k, v)| (k as f64 - middle) * (v - mean)).sum::<f64>()
        / (n * (n * n - 1.0) / 12.0);
    Some(mean - slope * (middle + skipped as f64 + before))
}
