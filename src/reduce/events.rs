//! What is odd in a channel, named and counted: spikes, stuck values, saturation, absent values. What is stuck or saturated is left out of means.

use crate::elements::{OrNan, Parts, TOGETHER};
use crate::number;
use crate::vocabulary::vocabulary;
use std::ops::Range;

vocabulary! {
    /// A kind of event.
    EventKind {
        /// A row without a number here.
        Absent = "absent",
        /// The largest or smallest value of the record, where it stands several times in a row somewhere.
        Saturation = "saturation",
        /// Samples, up to ten in a row, far from those before and after.
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

/// What is odd in samples that come in parts; those that are not finite have no number.
#[derive(Debug, Clone, Default)]
pub(crate) struct Odd {
    watch: Watch,
    events: Vec<Event>,
    samples: u64,
}

impl Odd {
    /// Further samples.
    #[cfg(feature = "cli")]
    pub(crate) fn see(&mut self, samples: &[f64]) {
        self.each(samples, |watch, run, first, events| watch.see(run, first, events));
    }

    /// The same, but for spikes.
    pub(crate) fn see_runs(&mut self, samples: &[f64]) {
        self.each(samples, |watch, run, first, _| watch.runs(run, first));
    }

    fn each(&mut self, samples: &[f64], see: impl Fn(&mut Watch, &[f64], u64, &mut Vec<Event>)) {
        for run in samples
            .chunk_by(|a, b| a.is_finite() == b.is_finite())
            .filter(|run| run.first().is_some_and(|v| v.is_finite()))
        {
            see(&mut self.watch, run, self.samples, &mut self.events);
            self.samples += run.len() as u64;
        }
    }

    /// All of them, in the order of time.
    pub(crate) fn events(mut self) -> Vec<Event> {
        self.watch.finish(&mut self.events);
        self.events
    }

    /// Are samples held, or rows repeated: do values nearly always stay, and then change by more than a step of the resolution?
    pub(crate) fn is_held(&self) -> bool {
        let (stays, changes) = self.watch.stays();
        changes && stays >= HELD && self.watch.count.0 > WINDOW as u64
    }
}

/// Most events that are kept of a channel.
const KEPT: usize = 10_000;
/// A spike is so many robust standard deviations away from the median of its neighbourhood,
const FAR: f64 = 8.0;
/// which are so many samples before it and after it: of a window of twice as many those that are odd are fewer than half, and as many that are equal are stuck.
const REACH: usize = 10;
/// Values in a row that may be stuck or saturated.
const LEAST_STUCK: u64 = REACH as u64;
const LEAST_SATURATED: u64 = 3;
/// Values that stay with this probability and more are held.
const HELD: f64 = 0.9;
const WINDOW: usize = 128;
/// Of the windows of a piece so many say what is usual: a median of 128 differences is known to 11 %, the quartile of 32 of them to 3 %.
const WINDOWS: usize = 32;

/// Watches one channel as it passes.
#[derive(Debug, Clone, Default)]
pub(super) struct Watch {
    before: Vec<f64>,
    /// How many of those before are judged, and the number of the sample that follows them.
    judged: usize,
    next: u64,
    /// A sample is odd so far from its neighbourhood; none as long as the noise is not known.
    limit: Option<f64>,
    /// The value that repeats, its first sample, how often.
    run: (f64, u64, u64),
    /// Runs of equal values: all, and those of one sample.
    count: (u64, u64),
    /// Ends of runs of two samples and more, where the sensor did not move: all, and those at which the value changes by more than one step.
    ends: (u64, u64),
    /// Long ones: sample and length.
    long: Vec<(u64, u64)>,
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
    /// The extreme so far.
    fn size(&self) -> f64 {
        // before the first value
        self.value.unwrap_or(f64::NEG_INFINITY)
    }

    /// A run of equal values; `size` grows towards the extreme.
    fn see(&mut self, size: f64, sample: u64, length: u64) {
        if self.value.is_none_or(|most| size > most) {
            self.value = Some(size);
            self.runs.clear();
        }
        if self.value == Some(size) && self.runs.len() < KEPT {
            self.runs.push((sample, length));
        }
    }

    /// Is it a rail: do samples stay at it?
    fn is_rail(&self) -> bool {
        self.runs.iter().any(|(_, length)| *length >= LEAST_SATURATED)
    }
}

impl Watch {
    /// The smallest step between two values: the resolution of a quantized channel. 0 where nothing changes.
    pub(super) fn step(&self) -> f64 {
        self.step
    }

    /// The largest and the smallest value, where samples stay at it.
    pub(super) fn rails(&self) -> impl Iterator<Item = f64> {
        let [high, low] = [&self.high, &self.low].map(|end| end.value.filter(|_| end.is_rail()));
        high.into_iter().chain(low.map(|size| -size))
    }

    pub(super) fn see(&mut self, values: &[f64], first: u64, events: &mut Vec<Event>) {
        self.runs(values, first);
        self.spikes(values, first, events);
    }

    /// Runs of equal values, the extremes and the smallest step.
    fn runs(&mut self, values: &[f64], first: u64) {
        let (mut value, mut start, mut length) = self.run;
        let (mut high, mut low) = (self.high.size(), -self.low.size());
        let ((mut all, mut single), (mut ends, mut far)) = (self.count, self.ends);
        let mut least = if self.step == 0.0 { f64::INFINITY } else { self.step };
        for (k, v) in values.iter().enumerate() {
            if length > 0 && *v == value {
                length += 1;
                continue;
            }
            if length > 0 {
                let step = (v - value).abs();
                all += 1;
                single += u64::from(length == 1);
                ends += u64::from(length > 1);
                // of a step that is not known yet: 1.5 leaves room for rounding
                far += u64::from(length > 1 && step > 1.5 * least);
                least = least.min(step);
                // a short run matters where it is an extreme
                if length >= LEAST_SATURATED || value >= high || value <= low {
                    self.run = (value, start, length);
                    self.close();
                    (high, low) = (self.high.size(), -self.low.size());
                }
            }
            (value, start, length) = (*v, first + k as u64, 1);
        }
        self.run = (value, start, length);
        (self.count, self.ends) = ((all, single), (ends, far));
        self.step = if least == f64::INFINITY { 0.0 } else { least };
    }

    /// Spikes among these values and those before them; what is too near to the end waits for what follows.
    fn spikes(&mut self, values: &[f64], first: u64, events: &mut Vec<Event>) {
        let carried = self.before.len();
        let mut all = std::mem::take(&mut self.before);
        all.extend_from_slice(values);
        self.look(&all, values.len());
        let (first, last) = (first - carried as u64, all.len().saturating_sub(REACH));
        self.judge(&all, first, self.judged..last.max(self.judged), events);
        let kept = all.len().saturating_sub(2 * REACH);
        self.judged = last.max(self.judged) - kept;
        self.next = first + all.len() as u64;
        all.drain(..kept);
        self.before = all;
    }

    /// How far from its neighbourhood a sample is odd: the noise from second differences, of the quieter windows among those that end in `new` values.
    fn look(&mut self, all: &[f64], new: usize) {
        // sizes as the bits of numbers without a sign, which have their order
        let size = |w: &[f64]| match w {
            [a, b, c] => (b - 0.5 * (a + c)).abs().to_bits(),
            _ => 0,
        };
        let all = all.part(all.len().saturating_sub(new + 2)..);
        let sizes = all.len().saturating_sub(2);
        let apart = WINDOW * sizes.div_ceil(WINDOW).div_ceil(WINDOWS).max(1);
        let mut own = Vec::with_capacity(WINDOW);
        let mut scales: Vec<f64> = Vec::with_capacity(WINDOWS);
        for start in (0..sizes).step_by(apart) {
            own.clear();
            own.extend(all.part(start..(start + WINDOW + 2).min(all.len())).windows(3).map(size));
            if own.len() >= 16 {
                let middle = own.len() / 2;
                // of white noise a second difference has 3/2 of its variance
                scales.push(f64::from_bits(*own.select_nth_unstable(middle).1) / 0.6745 / 1.5_f64.sqrt());
            }
        }
        // windows in which nothing changes say nothing of the noise, where others do
        if scales.iter().any(|scale| *scale > 0.0) {
            scales.retain(|scale| *scale > 0.0);
        }
        scales.sort_by(f64::total_cmp);
        // of few values the limit is that of those before; before all it is none: nothing is a spike
        if let Some(scale) = scales.get(scales.len() / 4) {
            self.limit = Some(FAR * scale.max(self.step));
        }
    }

    /// Samples of `range` that are far from the median of their neighbourhood, in its noise and in that of the record (F. R. Hampel 1974): up to `REACH` in a
    /// row, and any share of a neighbourhood below half.
    fn judge(&self, all: &[f64], first: u64, range: Range<usize>, events: &mut Vec<Event>) {
        let Some(limit) = self.limit else { return };
        // without a jump nearby nothing is far
        let before = range.start.saturating_sub(REACH + 1);
        let near = all.part(before..(range.end + REACH).min(all.len()));
        let (mut next, mut from) = (range.start, 0);
        let (mut around, mut apart) = (Vec::with_capacity(2 * REACH + 1), Vec::with_capacity(2 * REACH + 1));
        while let Some(step) = first_jump(near.part(from..), 0.5 * limit) {
            from += step;
            let jump = before + from;
            let near = next.max(jump.saturating_sub(REACH))..(jump + REACH + 1).min(range.end);
            next = near.end.max(next);
            // in values that lie this close together none is far
            let among = all.part(near.start.saturating_sub(REACH)..(near.end.max(near.start) + REACH).min(all.len()));
            let ends = (f64::INFINITY, f64::NEG_INFINITY);
            let (least, most) = among.iter().fold(ends, |(low, high), v| (low.min(*v), high.max(*v)));
            if !(most - least > limit) {
                continue;
            }
            near.for_each(|k| Self::far(all, (k, first), limit, (&mut around, &mut apart), events));
        }
    }

    /// Sample `k`, if it is far from its neighbourhood.
    fn far(
        all: &[f64],
        (k, first): (usize, u64),
        limit: f64,
        (around, apart): (&mut Vec<f64>, &mut Vec<f64>),
        events: &mut Vec<Event>,
    ) {
        let near = all.part(k.saturating_sub(REACH)..(k + REACH + 1).min(all.len()));
        let value = all.or_nan(k);
        // beyond the limit from the median: from those in the middle and all on one side of it
        let middle = near.len() / 2;
        let below = near.iter().filter(|other| value - **other > limit).count();
        let above = near.iter().filter(|other| **other - value > limit).count();
        if below <= middle && above < near.len() - middle {
            return;
        }
        around.clear();
        around.extend_from_slice(near);
        let middle = number::median(around).unwrap_or(0.0);
        apart.clear();
        apart.extend(around.iter().map(|other| (other - middle).abs()));
        if around.len() < REACH || (value - middle).abs() <= FAR * number::median(apart).unwrap_or(0.0) / 0.6745 {
            return;
        }
        let sample = first + k as u64;
        let full = events.len() >= KEPT;
        match events.iter_mut().rev().find(|event| event.kind == EventKind::Spike) {
            Some(own) if own.sample + own.length == sample => own.length += 1,
            _ if full => {}
            _ => events.push(Event { kind: EventKind::Spike, sample, length: 1 }),
        }
    }

    fn close(&mut self) {
        let (value, sample, length) = self.run;
        if length == 0 {
            return;
        }
        self.high.see(value, sample, length);
        self.low.see(-value, sample, length);
        if length >= LEAST_STUCK && self.long.len() < KEPT {
            self.long.push((sample, length));
        }
    }

    /// The probability that a value stays for another sample, and whether values mostly change by more than one step of the resolution.
    fn stays(&self) -> (f64, bool) {
        let ((all, single), (ends, far)) = (self.count, self.ends);
        // runs end by chance: the share of those of one sample says how soon, and few that are stuck do not change it
        ((1.0 - single as f64 / all.max(1) as f64).clamp(1e-3, 1.0), 2 * far > ends)
    }

    pub(super) fn finish(&mut self, events: &mut Vec<Event>) {
        self.close();
        self.run.2 = 0;
        let all = std::mem::take(&mut self.before);
        self.judge(&all, self.next - all.len() as u64, self.judged..all.len(), events);
        let (stays, changes) = self.stays();
        // where values mostly change by one step of the resolution, or are held, they stay while what is measured does
        if changes && stays < HELD {
            // so long a run by chance once in a thousand million samples
            let chance = number::count_u64((-20.7 / stays.ln()).ceil());
            let stuck = self.long.iter().filter(|(_, length)| *length >= chance);
            events.extend(stuck.map(|(sample, length)| Event {
                kind: EventKind::Stuck,
                sample: *sample,
                length: *length,
            }));
            for (sample, length) in
                [&self.high, &self.low].into_iter().filter(|end| end.is_rail()).flat_map(|end| &end.runs)
            {
                events.push(Event { kind: EventKind::Saturation, sample: *sample, length: *length });
            }
        }
        // what stays the same is no spike
        let (dead, spikes): (Vec<Event>, Vec<Event>) =
            events.drain(..).partition(|event| event.kind != EventKind::Spike);
        let inside = |own: &Event| {
            let within = |event: &Event| event.sample <= own.sample && own.sample < event.sample + event.length;
            dead.iter().any(|event| event.kind != EventKind::Absent && within(event))
        };
        events.extend(spikes.into_iter().filter(|own| !inside(own)));
        events.extend(dead);
        events.sort_by_key(|event| event.sample);
    }
}

/// The place of the first value that is further from the one before it than `least`.
fn first_jump(values: &[f64], least: f64) -> Option<usize> {
    let is_jump = |(before, own): (&f64, &f64)| (own - before).abs() > least;
    let pairs = |from: usize, to: usize| {
        values.get(from..to).into_iter().flatten().zip(values.get(from + 1..).into_iter().flatten())
    };
    for from in (0..values.len()).step_by(TOGETHER) {
        let to = (from + TOGETHER).min(values.len());
        if pairs(from, to).fold(false, |any, pair| any | is_jump(pair)) {
            return pairs(from, to).position(is_jump).map(|k| from + k + 1);
        }
    }
    None
}
