//! What is odd in a channel, named and counted: spikes, stuck values, saturation, absent values. Nothing is changed.

use crate::number;
use crate::vocabulary::vocabulary;

vocabulary! {
    /// A kind of event.
    EventKind {
        /// A row without a number here.
        Absent = "absent",
        /// The largest or smallest value of the record several times in a row.
        Saturation = "saturation",
        /// One sample far from both of its neighbours.
        Spike = "spike",
        /// The same value again and again where it otherwise changes.
        Stuck = "stuck",
    }
}

/// An event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Event {
    /// What.
    pub kind: EventKind,
    /// Its first sample.
    pub sample: u64,
    /// How many samples it lasts.
    pub length: u64,
}

/// Most events that are kept of a channel.
const KEPT: usize = 10_000;
/// A spike is so many robust standard deviations away from the mean of its neighbours.
const FAR: f64 = 8.0;
/// Values in a row that may be stuck or saturated.
const LEAST_STUCK: u64 = 10;
const LEAST_SATURATED: u64 = 3;
const WINDOW: usize = 128;

/// Watches one channel as it passes.
#[derive(Debug, Clone, Default)]
pub(super) struct Watch {
    before: Vec<f64>,
    /// The value that repeats, its first sample, how often.
    run: (f64, u64, u64),
    /// Share of samples that repeat their neighbour.
    repeats: (u64, u64),
    high: Extreme,
    low: Extreme,
    /// Smallest difference between neighbours that differ.
    step: f64,
}

#[derive(Debug, Clone, Default)]
struct Extreme {
    value: Option<f64>,
    runs: Vec<(u64, u64)>,
}

impl Extreme {
    /// A run of equal values; `size` grows towards the extreme.
    fn see(&mut self, size: f64, sample: u64, length: u64) {
        if self.value.is_none_or(|most| size > most) {
            self.value = Some(size);
            self.runs.clear();
        }
        if self.value == Some(size) && length >= LEAST_SATURATED && self.runs.len() < KEPT {
            self.runs.push((sample, length));
        }
    }
}

impl Watch {
    /// The smallest step between two values: the resolution of a quantized channel. 0 where nothing changes.
    pub(super) fn step(&self) -> f64 {
        self.step
    }

    pub(super) fn see(&mut self, values: &[f64], first: u64, events: &mut Vec<Event>) {
        for (k, v) in values.iter().enumerate() {
            if self.run.2 > 0 && *v == self.run.0 {
                self.run.2 += 1;
                self.repeats.0 += 1;
            } else {
                if self.run.2 > 0 {
                    let step = (v - self.run.0).abs();
                    if self.step == 0.0 || step < self.step {
                        self.step = step;
                    }
                }
                self.close(events);
                self.run = (*v, first + k as u64, 1);
            }
            self.repeats.1 += 1;
        }
        // spikes among these values, with the two before them
        let carried = self.before.len();
        let mut all = std::mem::take(&mut self.before);
        all.extend_from_slice(values);
        let at = |k: usize| all.get(k).copied().unwrap_or(f64::NAN);
        let odd = |k: usize| at(k) - 0.5 * (at(k - 1) + at(k + 1));
        let last = all.len().saturating_sub(1);
        let mut scales: Vec<f64> = Vec::new();
        for start in (1..last).step_by(WINDOW) {
            let mut sizes: Vec<f64> = (start..(start + WINDOW).min(last)).map(|k| odd(k).abs()).collect();
            if sizes.len() >= 16 {
                let middle = sizes.len() / 2;
                sizes.select_nth_unstable_by(middle, f64::total_cmp);
                scales.push(sizes.get(middle).copied().unwrap_or_default() / 0.6745);
            }
        }
        scales.sort_by(f64::total_cmp);
        let scale = scales.get(scales.len() / 4).copied().unwrap_or(f64::INFINITY).max(self.step);
        for k in 1..last {
            let size = odd(k).abs();
            let alone = size > FAR * scale
                && (k < 2 || odd(k - 1).abs() < 0.8 * size)
                && (k + 2 > last || odd(k + 1).abs() < 0.8 * size);
            // a step or a bend has neighbours on one side only: a spike comes back
            let back = (at(k + 1) - at(k - 1)).abs() < 0.5 * size;
            if alone && back && events.len() < KEPT {
                events.push(Event { kind: EventKind::Spike, sample: first + k as u64 - carried as u64, length: 1 });
            }
        }
        self.before = all.get(all.len().saturating_sub(2)..).unwrap_or_default().to_vec();
    }

    fn close(&mut self, events: &mut Vec<Event>) {
        let (value, sample, length) = self.run;
        if length == 0 {
            return;
        }
        self.high.see(value, sample, length);
        self.low.see(-value, sample, length);
        let share = (self.repeats.0 as f64 / self.repeats.1.max(1) as f64).clamp(1e-3, 1.0);
        // so long a run by chance once in a thousand million samples
        let chance = if share < 0.9 { number::count_u64((-20.7 / share.ln()).ceil()) } else { u64::MAX };
        if length >= LEAST_STUCK.max(chance) && events.len() < KEPT {
            events.push(Event { kind: EventKind::Stuck, sample, length });
        }
    }

    pub(super) fn finish(&mut self, _samples: u64, events: &mut Vec<Event>) {
        self.close(events);
        self.run.2 = 0;
        let coarse = self.repeats.0 * 2 > self.repeats.1;
        for extreme in [&self.high, &self.low] {
            for (sample, length) in extreme.runs.iter().filter(|_| !coarse) {
                events.push(Event { kind: EventKind::Saturation, sample: *sample, length: *length });
            }
        }
        events.sort_by_key(|event| event.sample);
    }
}
