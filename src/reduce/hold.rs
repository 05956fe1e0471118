//! A position that is held while samples come: the detector, the guard times and the uncertainties of a record that has ended, at any moment.
//!
//! ```text
//! rows -> trace (of what is held, in bounded memory) -> segments -> the last one, if it lasts until now -> means, u, u of a longer hold
//! ```

use super::still::newest;
use super::{
    By, LEVEL, Mean, Segment, SegmentBlocks, Segmentation, Stillness, Trace, length, mean, mean_uncertainties, segment,
    whole_turns,
};
use crate::number;

/// Most blocks of a channel: 16 s of 1 kHz as they are, and four blocks to a window of half a second for half an hour.
const BLOCKS: usize = 1 << 14;
/// Looks in the length of a window, which go through all that is held, where the newest window says nothing new. A reading is taken at a look.
const LOOKS: f64 = 2.0;
/// Samples are taken in so often, s: a glance at the newest window tells whether a look is due. What is said is then at most so old, which is half of
/// what a person notices (50 ms); a glance costs a hundredth of a look.
const GLANCE_S: f64 = 0.025;
/// Windows without standing after which what lies before them is forgotten, with no standstill among them; and after one. Stretches within the
/// second are one position with a jerk between them (see `segments.rs`).
const MOVING: f64 = 16.0;
const JERK: f64 = 4.0;
/// How much longer holds are asked about: doublings of what is held. A thousand times as
/// long makes the u of white noise 32 times smaller; what takes longer is said to be out of reach.
const DOUBLINGS: i32 = 10;

/// Samples as they come, and what is held.
#[derive(Debug, Clone)]
pub struct Hold {
    trace: Trace,
    window: f64,
    threshold: f64,
    guard: f64,
    /// Runs of a label are held, whatever the samples say.
    labelled: bool,
    interrupted: bool,
    /// Samples, of all, at the last look, and after how many more there is one at the latest.
    looked: u64,
    next: u64,
    /// The standard deviations of the still sensor that the last look judged by; none before the first one.
    judged_sd: Vec<f64>,
    /// The newest window that was glanced at, and whether it was still.
    glanced: Option<(u64, bool)>,
}

/// What the samples say now.
#[derive(Debug, Clone)]
pub enum Look {
    /// The bench stands, or turns at a constant rate.
    Standing(Box<Standing>),
    /// It stood just now, and a jerk may end as it began; or there are too few samples to tell.
    Open,
    /// It moves.
    Moving,
}

/// A position that is held until now.
#[derive(Debug, Clone)]
pub struct Standing {
    trace: Trace,
    segment: Segment,
    judged: Option<Stillness>,
    /// Its first sample, counted from the first of all.
    pub start: u64,
    /// One past its last.
    pub end: u64,
    /// Has it been held since the first sample that is kept?
    pub whole: bool,
    /// How long, guard times left out, s.
    pub seconds: f64,
    /// Time of its middle, s since the first row.
    pub middle_s: f64,
}

/// What a longer hold would give.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ahead {
    /// How much longer, s.
    pub seconds: f64,
    /// Standard uncertainty of the mean then: that of now, less by what the middling description of the noise makes it less.
    pub u: f64,
}

impl Hold {
    /// Of channels with these names and units; the first `observed` of them tell whether the bench stands. `window` and `guard` in seconds,
    /// `threshold` in variances of the still sensor, as for a record.
    pub fn new(channels: Vec<(String, String)>, observed: usize, window: f64, threshold: f64, guard: f64) -> Self {
        let mut trace = Trace::new(channels).with_blocks(BLOCKS);
        trace.observed = observed;
        let (looked, next, judged_sd, glanced) = Default::default();
        Hold { trace, window, threshold, guard, labelled: false, interrupted: false, looked, next, judged_sd, glanced }
    }

    /// Labels tell what is held: each run of one is asked for by [`Hold::restart`].
    pub(crate) fn labelled(mut self) -> Self {
        (self.labelled, self.guard) = (true, 0.0);
        self
    }

    /// Rows from one glance to the next, at a sampling interval of `interval` seconds.
    pub fn rows(&self, interval: f64) -> usize {
        number::count((GLANCE_S.min(self.window / LOOKS) / interval).round()).max(1)
    }

    /// Is a look due: has the newest window become still, or is it so no more; is a question that was open decided by now; or is the last look
    /// half a window ago?
    pub fn is_due(&mut self) -> bool {
        let known = if self.judged_sd.is_empty() { &self.trace.still_sd } else { &self.judged_sd };
        let before = self.glanced;
        if !known.is_empty() && !self.labelled {
            let found = newest(&self.trace, self.window, self.threshold, known);
            self.glanced = found.or(before);
        }
        let has_turned = before.zip(self.glanced).is_some_and(|((_, before), (_, now))| before != now);
        has_turned || self.since() >= self.next
    }

    /// Samples since the last look.
    fn since(&self) -> u64 {
        self.count() - self.looked
    }

    /// Samples so far, those that are not kept among them.
    pub fn count(&self) -> u64 {
        self.trace.before + self.trace.samples
    }

    /// How long so many samples take, s.
    pub(crate) fn seconds(&self, samples: u64) -> f64 {
        samples as f64 * self.trace.interval
    }

    /// Samples of half a window.
    pub(crate) fn half_window(&self) -> u64 {
        number::count_u64((self.window / LOOKS / self.trace.interval).round()).max(1)
    }

    /// Time of the newest sample, s since the first row.
    pub(crate) fn now_s(&self) -> f64 {
        self.trace.samples.checked_sub(1).map_or(0.0, |last| self.trace.time(last))
    }

    /// Further rows, at these times (s since the first row of all), spaced by `interval`. At once at most [`Hold::rows`] of them.
    pub fn push(&mut self, columns: &[&[f64]], times: &[f64], interval: f64) {
        self.trace.interval = interval;
        if let (0, Some(first)) = (self.trace.samples, times.first()) {
            self.trace.resumes = vec![(0, *first)];
            self.interrupted = false;
        }
        if std::mem::take(&mut self.interrupted) {
            self.trace.interrupt();
        }
        self.trace.push(columns, Some(times));
    }

    /// Are no samples kept?
    pub(crate) fn is_empty(&self) -> bool {
        self.trace.samples == 0
    }

    /// The next row does not follow the last one.
    pub(crate) fn interrupt(&mut self) {
        self.interrupted = true;
    }

    /// Begin anew, with what is known of the still sensor; the samples count as passed.
    pub fn restart(&mut self) {
        let old = &self.trace;
        let titles = old.channels.iter().map(|own| (own.name.clone(), own.unit.clone())).collect();
        let mut trace = Trace::new(titles).with_blocks(BLOCKS);
        trace.observed = old.observed;
        trace.interval = old.interval;
        trace.before = old.before + old.samples;
        trace.still_sd = old.still_sd.clone();
        self.trace = trace;
        self.judged_sd.clear();
        self.glanced = None;
        self.is_looked_at(f64::INFINITY);
    }

    /// It was looked at; what is open then is decided in so many seconds.
    fn is_looked_at(&mut self, decided_s: f64) {
        self.looked = self.count();
        let seconds = (self.window / LOOKS).min(decided_s.max(0.0));
        self.next = number::count_u64((seconds / self.trace.interval).round()).max(1);
    }

    /// The standard deviations of the still sensor that are known, one for each channel.
    pub(crate) fn still_sd(&self) -> &[f64] {
        &self.trace.still_sd
    }

    /// Know them from before.
    pub fn set_still_sd(&mut self, known: Vec<f64>) {
        self.trace.still_sd = known;
    }

    /// What the samples say now; what is long past is forgotten.
    pub fn look(&mut self) -> Look {
        let mut trace = self.trace.clone();
        trace.finish();
        let seconds = |samples: u64| samples as f64 * trace.interval;
        let by = match self.labelled {
            true => {
                let (label, start, end) = ("held".to_string(), 0, trace.samples);
                trace.runs = vec![super::Run { label, start, end }];
                By::Labels
            }
            false => By::Still { window: self.window, threshold: self.threshold },
        };
        let mut found = segment(&trace, &by, self.guard, 0.0);
        self.judged_sd = found.stillness.as_ref().map_or(Vec::new(), |own| own.still_sd.clone());
        self.is_looked_at(f64::INFINITY);
        // windows begin eight times in the length of one, and none ends within a block
        let window = self.window.max(4.0 * seconds(trace.block as u64));
        let slack = 0.25 * window + seconds(2 * trace.block as u64);
        let Some(last) = found.segments.pop() else {
            let kept = seconds(trace.samples);
            let shows = window + 2.0 * self.guard + slack;
            if kept <= shows {
                // a standstill could not have shown yet
                self.is_looked_at(shows - kept + trace.interval);
                return Look::Open;
            }
            if kept > MOVING * self.window {
                self.restart();
            }
            return Look::Moving;
        };
        let (start, end) = last.span();
        let ago = seconds(trace.samples - end.min(trace.samples)) - self.guard - slack;
        if ago > JERK * self.window {
            self.restart();
            return Look::Moving;
        }
        if ago > 0.0 && !self.labelled {
            self.is_looked_at(JERK * self.window - ago + trace.interval);
            return Look::Open;
        }
        let whole = seconds(start) <= self.guard + slack;
        let held = seconds(last.samples());
        let middle_s = 0.5 * (trace.time(start) + trace.time(end));
        let judged = found.stillness;
        let (start, end) = (trace.before + start, trace.before + end);
        Look::Standing(Box::new(Standing { trace, segment: last, judged, start, end, whole, seconds: held, middle_s }))
    }
}

impl Standing {
    /// The standard deviations of the still sensor that it was judged by; empty where labels told.
    pub(crate) fn still_sd(&self) -> Vec<f64> {
        self.judged.as_ref().map_or(Vec::new(), |own| own.still_sd.clone())
    }

    /// The mean of a channel.
    pub(crate) fn value(&self, channel: usize) -> Option<f64> {
        self.trace.channels.get(channel).map(|own| own.block(&self.trace, &self.segment, None).mean)
    }

    /// The means of the first `channels` channels with their uncertainties, each with what longer holds would give; over whole turns where a
    /// joint turns once in `turn_s`. `None` before a whole turn.
    pub fn means(&self, channels: usize, turn_s: Option<f64>) -> Option<Vec<(Mean, Vec<Ahead>)>> {
        let mut own = Segmentation { segments: vec![self.segment.clone()], rejected: Vec::new(), stillness: None };
        whole_turns(&self.trace, &mut own, &[turn_s]);
        let segment = own.segments.first()?;
        let trace = &self.trace;
        let seconds = trace.block as f64 * trace.interval;
        let one = |(k, channel): (usize, &super::Channel)| {
            let block = channel.block(trace, segment, turn_s);
            let longer = |k: i32| {
                let times = 2.0_f64.powi(k);
                let samples = number::count_u64(block.samples as f64 * times);
                let (length, start, sd, step) = (block.length * times, block.start, block.sd, block.step);
                SegmentBlocks { start, length, mean: block.mean, sd, samples, step, ..SegmentBlocks::default() }
            };
            let all: Vec<SegmentBlocks> = std::iter::once(block.clone()).chain((1..=DOUBLINGS).map(longer)).collect();
            let mut found = mean_uncertainties(&all, length(trace), LEVEL).into_iter();
            let uncertainty = found.next().unwrap_or_default();
            // u itself has in it what is not known of the noise yet, and that a longer hold tells
            let now = uncertainty.middling.max(f64::MIN_POSITIVE);
            let ahead = found.zip(all.iter().skip(1)).map(|(found, own)| Ahead {
                seconds: (own.length - block.length) * seconds,
                u: uncertainty.u * found.middling / now,
            });
            (mean(trace, k, segment, &block, uncertainty), ahead.collect())
        };
        use rayon::prelude::*;
        let channels: Vec<(usize, &super::Channel)> = trace.channels.iter().take(channels).enumerate().collect();
        Some(channels.into_par_iter().map(one).collect())
    }
}

impl Ahead {
    /// How much longer until `wanted` is reached: 0 where it is, `None` where a thousand times as long does not reach it.
    ///
    /// Between two lengths u is taken as a power of the length.
    pub fn until(held_s: f64, mean: &Mean, ahead: &[Ahead], wanted: f64) -> Option<f64> {
        let mut before = Ahead { seconds: 0.0, u: mean.uncertainty.u };
        if before.u <= wanted {
            return Some(0.0);
        }
        for own in ahead {
            if own.u <= wanted {
                let whole = |own: &Ahead| (held_s + own.seconds).max(f64::MIN_POSITIVE).ln();
                let share = (before.u / wanted).ln() / (before.u / own.u).ln();
                return Some((whole(&before) + share * (whole(own) - whole(&before))).exp() - held_s);
            }
            before = *own;
        }
        None
    }
}
