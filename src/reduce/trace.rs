//! A record in bounded memory: block means with the spread inside each block; blocks double in length as the record grows.

use super::events::{Event, EventKind, Watch};
use super::turning;
use crate::elements::{Parts, first_odd};
use crate::number;
use crate::uncertainty::quantiles::normal_survival;
use std::ops::Range;

/// Most blocks of a channel.
const MOST: usize = 1 << 21;

/// One channel of a trace.
#[derive(Debug, Clone, Default)]
pub struct Channel {
    /// Its column.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Mean of each whole block.
    pub means: Vec<f64>,
    /// Sum of squared deviations within each block; empty while a block is one sample.
    pub squares: Vec<f64>,
    /// What is odd in it, in the order of time.
    pub events: Vec<Event>,
    open: (f64, f64, usize),
    watch: Watch,
}

/// Samples in a row that carry one label.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The label.
    pub label: String,
    /// Its first sample.
    pub start: u64,
    /// One past its last.
    pub end: u64,
}

/// A record: channels of equally long blocks.
#[derive(Debug, Clone)]
pub struct Trace {
    /// The channels.
    pub channels: Vec<Channel>,
    /// How many of them were read; those behind were computed from them, and do not tell whether the record stands still.
    pub observed: usize,
    /// Samples in a block.
    pub block: usize,
    /// Seconds between samples.
    pub interval: f64,
    /// Samples of each channel.
    pub samples: u64,
    /// Where the record goes on after samples that are absent, or a gap: the sample, and its time in seconds since the first row.
    pub resumes: Vec<(u64, f64)>,
    /// Samples that are left out: dead stretches of a channel that was read, in the order of time.
    pub dead: Vec<Range<u64>>,
    /// Rows, those that are left out among them.
    pub rows: u64,
    resumed: bool,
    /// Runs of labels, where a column has some.
    pub runs: Vec<Run>,
    /// The angle of an encoder in turns, where there is one: no channel that is reduced.
    pub angle: Option<Channel>,
    /// Samples that came before its first one, and are not kept: they count where noise without a level of its own is judged.
    pub before: u64,
    /// Standard deviations of the still sensor that are known already, one for each channel; empty where none is.
    pub still_sd: Vec<f64>,
    most: usize,
}

impl Trace {
    /// An empty trace of channels with these names and units.
    pub fn new(channels: Vec<(String, String)>) -> Self {
        let observed = channels.len();
        let channels: Vec<Channel> =
            channels.into_iter().map(|(name, unit)| Channel { name, unit, ..Channel::default() }).collect();
        let resumes = vec![(0, 0.0)];
        Trace {
            channels,
            observed,
            block: 1,
            interval: 1.0,
            samples: 0,
            resumes,
            dead: Vec::new(),
            rows: 0,
            resumed: false,
            runs: Vec::new(),
            angle: None,
            before: 0,
            still_sd: Vec::new(),
            most: MOST,
        }
    }

    /// The same with at most so many blocks.
    pub fn with_blocks(mut self, most: usize) -> Self {
        self.most = most.max(16);
        self
    }

    /// The next row does not follow the last one: a gap stands between them.
    pub(crate) fn interrupt(&mut self) {
        self.resumed = true;
    }

    /// Further rows, one slice for each channel, all of one length, and their times, s since the first row (equally spaced without). A row with a value
    /// that is not finite is left out, and is an event.
    pub fn push(&mut self, columns: &[&[f64]], times: Option<&[f64]>) {
        let rows = columns.iter().map(|c| c.len()).min().unwrap_or(0);
        let mut start = 0;
        while start < rows {
            let absent = |column: &&[f64]| first_odd(column.part(start..rows), |v| !v.is_finite());
            let end = columns.iter().filter_map(absent).min().map_or(rows, |k| start + k);
            if end > start && std::mem::take(&mut self.resumed) {
                let time = times.and_then(|times| times.get(start).copied());
                let time = time.unwrap_or((self.rows + start as u64) as f64 * self.interval);
                self.resumes.push((self.samples, time));
            }
            self.sound(columns, start, end);
            if end < rows {
                self.resumed = true;
                for (channel, column) in self.channels.iter_mut().zip(columns) {
                    if column.get(end).is_some_and(|v| !v.is_finite()) {
                        channel.events.push(Event { kind: EventKind::Absent, sample: self.samples, length: 1 });
                    }
                }
            }
            start = end + 1;
        }
        self.rows += rows as u64;
    }

    fn sound(&mut self, columns: &[&[f64]], start: usize, end: usize) {
        // pieces short enough that blocks double in between
        for from in (start..end).step_by(1 << 16) {
            let to = (from + (1 << 16)).min(end);
            for (channel, column) in self.channels.iter_mut().zip(columns) {
                let values = column.part(from..to);
                channel.watch.see(values, self.samples, &mut channel.events);
                channel.push(values, self.block);
            }
            self.samples += (to - from) as u64;
            while self.channels.iter().any(|c| c.means.len() > self.most) {
                self.channels.iter_mut().for_each(|channel| channel.halve(self.block));
                self.block *= 2;
            }
        }
    }

    /// No more rows follow.
    pub fn finish(&mut self) {
        self.channels.iter_mut().for_each(|channel| channel.watch.finish(&mut channel.events));
        let dead = |event: &&Event| matches!(event.kind, EventKind::Stuck | EventKind::Saturation);
        let observed = self.channels.iter().take(self.observed).flat_map(|channel| channel.events.iter().filter(dead));
        let mut found: Vec<Range<u64>> = observed.map(|event| event.sample..event.sample + event.length).collect();
        found.sort_by_key(|range| range.start);
        for range in found {
            match self.dead.last_mut() {
                Some(last) if range.start <= last.end => last.end = last.end.max(range.end),
                _ => self.dead.push(range),
            }
        }
    }

    /// The dead stretches that overlap samples `start..end`.
    pub(crate) fn dead_in(&self, start: u64, end: u64) -> &[Range<u64>] {
        let from = self.dead.partition_point(|range| range.end <= start);
        let to = self.dead.partition_point(|range| range.start < end);
        self.dead.get(from..to.max(from)).unwrap_or_default()
    }

    /// The parts of samples `start..end` that are not dead.
    pub(crate) fn alive(&self, start: u64, end: u64) -> Vec<Range<u64>> {
        let (mut from, mut parts) = (start, Vec::new());
        for dead in self.dead_in(start, end) {
            parts.push(from..dead.start.max(from));
            from = dead.end.min(end);
        }
        parts.push(from..end);
        parts.retain(|part| part.end > part.start);
        parts
    }

    /// Where the record goes on within samples `start..end`, the first left aside.
    pub(crate) fn resumes_in(&self, start: u64, end: u64) -> &[(u64, f64)] {
        let from = self.resumes.partition_point(|(sample, _)| *sample <= start);
        let to = self.resumes.partition_point(|(sample, _)| *sample < end);
        self.resumes.get(from..to.max(from)).unwrap_or_default()
    }

    /// Time of a sample, s since the first row.
    pub fn time(&self, sample: u64) -> f64 {
        let place = self.resumes.partition_point(|(from, _)| *from <= sample);
        // before the first gap: from the start
        let (from, time) = place.checked_sub(1).and_then(|k| self.resumes.get(k)).copied().unwrap_or((0, 0.0));
        time + (sample - from) as f64 * self.interval
    }

    /// What is missing before a sample at which the record goes on, s.
    pub(crate) fn missing(&self, (sample, time): (u64, f64)) -> f64 {
        let before = sample.checked_sub(1).map_or(0.0, |before| self.time(before));
        (time - before - self.interval).max(0.0)
    }

    /// The first sample that is not before a time.
    pub(crate) fn sample(&self, time: f64) -> u64 {
        let place = self.resumes.partition_point(|(_, t)| *t <= time);
        // before the first gap: from the start
        let (from, start) = place.checked_sub(1).and_then(|k| self.resumes.get(k)).copied().unwrap_or((0, 0.0));
        let next = self.resumes.get(place).map(|(sample, _)| *sample);
        let sample = from.saturating_add(number::count_u64(((time - start) / self.interval - 1e-6).ceil()));
        sample.min(next.unwrap_or(self.samples)).min(self.samples)
    }

    /// What a stretch of time is short of, where it reaches beyond the record.
    pub(crate) fn cut(&self, start: f64, end: f64) -> Option<String> {
        let last = self.time(self.samples.saturating_sub(1));
        // a time that is rounded is not beyond
        let beyond = |by: f64| by > 1.5 * self.interval;
        (beyond(-start) || beyond(end - last))
            .then(|| format!("{start} s to {end} s reaches beyond the record, which is from 0 s to {last:.3} s (since the first sample)"))
    }

    /// Whole blocks inside samples `start..end`.
    pub fn blocks(&self, start: u64, end: u64) -> std::ops::Range<usize> {
        let block = self.block as u64;
        let most = self.channels.first().map_or(0, |c| c.means.len());
        let (first, last) = (number::index(start.div_ceil(block)), number::index(end / block));
        first.min(most)..last.min(most).max(first.min(most))
    }

    /// The angle at each block of a piece in turns: by the encoder, or by the time that a turn takes.
    fn turned(&self, piece: &Range<u64>, turn_s: f64) -> Vec<f64> {
        let encoder = self.angle.as_ref().map(|channel| channel.means.as_slice()).unwrap_or_default();
        let by_time = |k: usize| self.time((k * self.block) as u64) / turn_s;
        self.blocks(piece.start, piece.end).map(|k| encoder.get(k).copied().unwrap_or_else(|| by_time(k))).collect()
    }

    /// Events of a channel within a segment, by kind.
    pub(crate) fn count_events(&self, channel: usize, segment: &Segment) -> Vec<(EventKind, u64)> {
        let mut counts: Vec<(EventKind, u64)> = Vec::new();
        // a channel that is not watched has no events
        let events = self.channels.get(channel).map(|c| c.events.as_slice()).unwrap_or_default();
        for event in events.iter().filter(|e| segment.pieces.iter().any(|p| p.contains(&e.sample))) {
            match counts.iter_mut().find(|(kind, _)| *kind == event.kind) {
                Some((_, n)) => *n += 1,
                None => counts.push((event.kind, 1)),
            }
        }
        counts
    }
}

impl Channel {
    fn push(&mut self, values: &[f64], block: usize) {
        if block == 1 {
            self.means.extend_from_slice(values);
            return;
        }
        let missing = if self.open.2 == 0 { 0 } else { block - self.open.2 };
        let (first, rest) = values.split_at(missing.min(values.len()));
        self.complete(first, block);
        let whole = rest.chunks_exact(block);
        let last = whole.remainder();
        for own in whole {
            let mean = own.iter().sum::<f64>() / block as f64;
            self.means.push(mean);
            self.squares.push(own.iter().map(|v| (v - mean) * (v - mean)).sum());
        }
        self.complete(last, block);
    }

    /// Values of the open block.
    fn complete(&mut self, values: &[f64], block: usize) {
        for v in values {
            let (mean, square, n) = self.open;
            let n = n + 1;
            let step = v - mean;
            let mean = mean + step / n as f64;
            let square = square + step * (v - mean);
            self.open = (mean, square, n);
            if n == block {
                self.means.push(mean);
                self.squares.push(square);
                self.open = (0.0, 0.0, 0);
            }
        }
    }

    /// The smallest step between two of its values.
    pub(crate) fn resolution(&self) -> f64 {
        self.watch.step()
    }

    /// Two blocks become one.
    fn halve(&mut self, block: usize) {
        if self.squares.len() != self.means.len() {
            self.squares = vec![0.0; self.means.len()];
        }
        if let ([mean], [square]) = (self.means.as_chunks::<2>().1, self.squares.as_chunks::<2>().1) {
            // the last block waits for its partner, together with what is open
            let (open, open_square, n) = self.open;
            let all = (block + n) as f64;
            let apart = open - mean;
            let joined = square + open_square + apart * apart * block as f64 * n as f64 / all;
            self.open = (mean + apart * n as f64 / all, joined, block + n);
        }
        let squares = self.squares.as_chunks::<2>().0.iter().zip(self.means.as_chunks::<2>().0);
        let joined = |([p, q], [a, b]): (&[f64; 2], &[f64; 2])| p + q + 0.5 * block as f64 * (a - b) * (a - b);
        self.squares = squares.map(joined).collect();
        self.means = self.means.as_chunks::<2>().0.iter().map(|[a, b]| 0.5 * (a + b)).collect();
    }

    /// Is the noise of a segment cut at a rail? It is where more than one sample is expected beyond the rail, by the mean and the standard deviation of those that are left: their
    /// mean is not that of the channel then.
    pub(super) fn is_cut(&self, trace: &Trace, segment: &Segment) -> bool {
        let own = self.block(trace, segment, None);
        // samples that do not scatter are cut nowhere
        let share = |rail: f64| normal_survival((rail - own.mean).abs() / own.sd).unwrap_or(0.0);
        self.watch.rails().any(|rail| own.samples as f64 * share(rail) > 1.0)
    }

    /// The blocks of a segment, what repeats with a turn (of so many seconds; where an encoder tells the angle, of that) taken out.
    pub fn block(&self, trace: &Trace, segment: &Segment, turn_s: Option<f64>) -> SegmentBlocks {
        let mut block = SegmentBlocks { start: 0.0, length: 0.0, ..SegmentBlocks::default() };
        let (mut sum, mut within) = (0.0, 0.0);
        let mut count = 0;
        // about one of its values: the mean of equal values is that value, to the last digit
        let mut about = None;
        for piece in &segment.pieces {
            let range = trace.blocks(piece.start, piece.end);
            if count == 0 {
                block.start = range.start as f64 + trace.before as f64 / trace.block as f64;
            }
            // a range beyond the trace adds nothing
            let means = self.means.get(range.clone()).unwrap_or_default();
            let about = *about.get_or_insert(means.first().copied().unwrap_or(0.0)); // of no means: nothing is summed
            sum += means.iter().map(|v| v - about).sum::<f64>();
            within += self.squares.get(range).unwrap_or_default().iter().sum::<f64>();
            count += means.len();
            block.pieces.push(means.to_vec());
        }
        let mean = about.unwrap_or(0.0) + sum / count.max(1) as f64;
        let between: f64 = block.pieces.iter().flatten().map(|v| (v - mean) * (v - mean)).sum();
        block.samples = (count * trace.block) as u64;
        block.length = count as f64;
        block.mean = mean;
        block.sd = ((within + between * trace.block as f64) / (block.samples.max(2) - 1) as f64).sqrt();
        if let Some(turn) = turn_s {
            block.angles = segment.pieces.iter().map(|piece| trace.turned(piece, turn)).collect();
            (block.mean, block.above, block.harmonics) = turning::without_turn(&mut block.pieces, &block.angles);
        }
        block.step = self.watch.step();
        if block.step == 0.0 {
            // digits of a computation show no step
            block.step = number::resolution(std::iter::once(block.mean)).unwrap_or(0.0);
        }
        block
    }
}

/// A segment that becomes a reading.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    /// Its label.
    pub label: String,
    /// Its samples; more than one range where something in between was left out.
    pub pieces: Vec<Range<u64>>,
    /// What a reader should know about it.
    pub notes: Vec<String>,
}

impl Segment {
    /// First sample and one past the last.
    pub fn span(&self) -> (u64, u64) {
        (self.pieces.first().map_or(0, |p| p.start), self.pieces.last().map_or(0, |p| p.end))
    }

    /// Samples in it.
    pub fn samples(&self) -> u64 {
        self.pieces.iter().map(|p| p.end - p.start).sum()
    }
}

/// A segment of one channel as means of blocks: what an uncertainty is estimated from.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SegmentBlocks {
    /// Block means of each uninterrupted piece.
    pub pieces: Vec<Vec<f64>>,
    /// Where it begins in the record, in blocks.
    pub start: f64,
    /// Its blocks.
    pub length: f64,
    /// Mean of its samples.
    pub mean: f64,
    /// Standard deviation of its samples.
    pub sd: f64,
    /// Its samples.
    pub samples: u64,
    /// Smallest step between values of the channel.
    pub step: f64,
    /// Where a joint turns: its angle at each block of each piece, in turns. The harmonics of the turn are no noise.
    pub angles: Vec<Vec<f64>>,
    /// The highest of these harmonics.
    pub harmonics: usize,
    /// How much larger the standard deviation of the level is than that of a mean of as many samples, since parts of turns are missing; 1, or 0 where nothing turns.
    pub above: f64,
}
