//! Segments in which a joint turned, cut to whole turns: by the time that a turn takes, or by the angle of an encoder.

use super::{Rejected, Segmentation, Trace};
use std::ops::Range;

/// Shorten segments in which a joint turned to whole turns, in their middle; `turn_s` has the duration of a turn. Those without one are rejected.
/// What is left out of a segment, and what is absent, takes its time.
pub fn whole_turns(trace: &Trace, segmentation: &mut Segmentation, turn_s: &[Option<f64>]) -> Vec<Option<f64>> {
    let mut kept = Vec::new();
    let mut turns = Vec::new();
    for (segment, turn) in std::mem::take(&mut segmentation.segments).into_iter().zip(turn_s) {
        let mut segment = segment;
        if let Some(turn) = turn {
            let (start, end) = segment.span();
            let begins = trace.time(start);
            let lasting = trace.time(end.saturating_sub(1)) + trace.interval - begins;
            let whole = (lasting / turn + 1e-9).floor();
            if whole < 1.0 {
                let reason = format!("{lasting:.3} s long: less than a turn of {turn:.3} s");
                segmentation.rejected.push(Rejected { samples: start..end, reason });
                continue;
            }
            // the samples nearest to where the turns begin and end
            let nearest = |time: f64| trace.sample(time - 0.5 * trace.interval);
            let from = nearest(begins + 0.5 * (lasting - whole * turn));
            let to = nearest(trace.time(from) + whole * turn).max(from + 1).min(end);
            segment.pieces = within(&segment.pieces, from, to);
            segment.notes.push(format!("{whole} whole turns"));
        }
        kept.push(segment);
        turns.push(*turn);
    }
    segmentation.segments = kept;
    turns
}

/// The parts of pieces from a sample to another.
fn within(pieces: &[Range<u64>], from: u64, to: u64) -> Vec<Range<u64>> {
    pieces.iter().map(|own| own.start.max(from)..own.end.min(to)).filter(|own| own.start < own.end).collect()
}

/// An angle that moves by less than this share of a turn within a segment stands still.
const STILL: f64 = 0.02;

/// Shorten segments in which the encoder turned to whole turns of its angle, in their middle; those with less than one are rejected. Segments in
/// which it stood still stay as they are. Gives the mean duration of a turn, s.
///
/// A segment begins at the first sample at or above one angle and ends before the first at or above the angle a whole number of turns further.
pub(crate) fn whole_turns_of(trace: &Trace, segmentation: &mut Segmentation) -> Vec<Option<f64>> {
    let mut kept = Vec::new();
    let mut durations = Vec::new();
    // no angle: no turns
    let angles = trace.angle.as_ref().map(|channel| channel.means.as_slice()).unwrap_or_default();
    let sample = |block: usize| (block * trace.block) as u64;
    for mut segment in std::mem::take(&mut segmentation.segments) {
        let (start, end) = segment.span();
        let blocks = trace.blocks(start, end);
        let (first, length) = (blocks.start, blocks.len());
        // beyond the trace: no turns
        let own = angles.get(blocks).unwrap_or_default();
        let (Some(a), Some(b)) = (own.first(), own.last()) else {
            kept.push(segment);
            durations.push(None);
            continue;
        };
        // one sampling interval more than from the first sample to the last
        let moved = (b - a) * length as f64 / (length.max(2) - 1) as f64;
        if moved.abs() < STILL {
            kept.push(segment);
            durations.push(None);
            continue;
        }
        let whole = (moved.abs() + 1e-6).floor();
        if whole < 1.0 {
            let reason = format!("{:.3} turns by the encoder: less than one", moved.abs());
            segmentation.rejected.push(Rejected { samples: start..end, reason });
            continue;
        }
        let forward = |angle: &f64| (angle - a) * moved.signum();
        let rest = 0.5 * (moved.abs() - whole).max(0.0);
        // an encoder that stays short of an angle by rounding reaches it at the end
        let at = |angle: f64| own.iter().position(|v| forward(v) >= angle - 1e-9).unwrap_or(length);
        let (from, to) = (at(rest), at(rest + whole));
        segment.pieces = within(&segment.pieces, sample(first + from), sample(first + to).min(end));
        segment.notes.push(format!("{whole} whole turns by the encoder"));
        durations.push(Some((to - from) as f64 * trace.block as f64 * trace.interval / whole));
        kept.push(segment);
    }
    segmentation.segments = kept;
    durations
}

/// The angle of an encoder as it goes on from turn to turn, in turns.
#[derive(Debug, Clone)]
pub struct Unwrap {
    turn: f64,
    last: Option<f64>,
    turns: f64,
}

impl Unwrap {
    /// `turn` is what the encoder reads more after a turn: 360, or its counts.
    pub fn new(turn: f64) -> Self {
        Unwrap { turn, last: None, turns: 0.0 }
    }

    /// Further readings; between two the joint turns by less than half a turn. One that is no number is passed on as it is.
    pub fn turns(&mut self, readings: &[f64]) -> Vec<f64> {
        let next = |reading: &f64| {
            let now = reading / self.turn;
            if !now.is_finite() {
                return f64::NAN;
            }
            // the first step is from zero
            let step = now - self.last.unwrap_or(0.0);
            self.turns += if self.last.is_some() { step - step.round() } else { step };
            self.last = Some(now);
            self.turns
        };
        readings.iter().map(next).collect()
    }
}
