//! The clock of a record: a column of times or a stated rate; stretches between gaps. Which column that is: `clock_from.rs`.

use super::Column;
use crate::elements::Parts;
use crate::error::{Fault, Malformed, Result};
use crate::number;
use crate::units::Unit;
use crate::vocabulary::vocabulary;
use std::ops::Range;

/// A step longer than this many sampling intervals may be a gap ([`Clock::lacks`] says whether).
const GAP: f64 = 1.75;

/// Rows on both sides of a long step that say whether rows are missing there. That all those behind it are late by chance, of times that scatter about an even row, has the probability
/// 1/C(2 n, n) = 2e-9 (F. Wilcoxon 1945: ranks that are parted), once in 500 records of a million steps that are all long. Fewer rows say it where they are nearer to one row
/// that is missing than to none: half an interval.
const NEAR: usize = 16;

/// Rows that follow each other without a gap.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stretch {
    /// Rows of the block.
    pub rows: Range<usize>,
    /// Does a gap stand before them?
    pub after_gap: bool,
}

/// A step of the times that is none from one sample to the next.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "JumpReport")]
pub struct Jump {
    /// What it looks like.
    pub kind: JumpKind,
    /// Rows before it.
    pub row: u64,
    /// Time of the last of them, s since the first.
    #[serde(rename = "time_s")]
    pub time: f64,
    /// The step, s.
    #[serde(rename = "step_s")]
    pub step: f64,
}

vocabulary! {
    /// What a step of the times looks like, against the median step.
    JumpKind {
        /// Back by more than 1.75 median steps: the clock was set back.
        Back = "back",
        /// Longer than 1.75 median steps: samples are missing, or the clock was set forward; times alone cannot tell.
        Gap = "gap",
        /// Forward by less than a quarter of the median step, none at all, or back by no more than 1.75 of it: two times changed places, or are one.
        Short = "short",
    }
}

/// A step shorter than this share of the median is a jump.
const SHORT: f64 = 0.25;
/// Steps back in more than one of so many rows: not a clock that was set, but rows that are not sorted.
const RARE: u64 = 100;

/// Words that make a name one of times where the values rise: `seconds_elapsed`, `TimeUS`, `__time`, `loggingTime`.
const WORDS: [&str; 17] = [
    "time",
    "times",
    "timestamp",
    "stamp",
    "datetime",
    "elapsed",
    "clock",
    "epoch",
    "seconds",
    "millis",
    "micros",
    "zeit",
    "zeitstempel",
    "uhrzeit",
    "temps",
    "horodatage",
    "tiempo",
];

/// The unit of time at the end of a column's name: `time_ms`.
pub(super) fn behind(name: &str) -> Option<&str> {
    let (_, unit) = name.rsplit_once('_')?;
    crate::units::of_column(name).and_then(|unit| seconds(&unit)).map(|_| unit)
}

/// The unit of time that a column says: in its title, at the end of its name, or as a word of a name of times (`seconds_elapsed`, `TimeUS`).
fn unit_of_times(column: &Column) -> Option<String> {
    let said = column.unit.clone().or_else(|| behind(&column.name).map(str::to_string));
    said.or_else(|| {
        let words = words(&column.name);
        let is_unit = |word: &&String| word.len() > 1 && seconds(word).is_some();
        words.iter().rev().find(is_unit).filter(|_| speaks_of_time(&column.name)).cloned()
    })
}

/// Is a word of the name one of times?
pub(super) fn speaks_of_time(name: &str) -> bool {
    words(name).iter().any(|word| WORDS.contains(&word.as_str()))
}

/// The words of a name in small letters: parted by signs, and where a capital follows a small letter, or begins a word behind capitals (`UTCTime`).
fn words(name: &str) -> Vec<String> {
    let letters: Vec<char> = name.chars().collect();
    let mut found = vec![String::new()];
    for (k, letter) in letters.iter().enumerate() {
        let before = k.checked_sub(1).and_then(|k| letters.get(k)).copied().unwrap_or(' ');
        let is_small = |at: usize| letters.get(at).is_some_and(|c| c.is_lowercase());
        let begins = letter.is_uppercase() && (before.is_lowercase() || (before.is_uppercase() && is_small(k + 1)));
        if begins || !letter.is_alphanumeric() || before.is_ascii_digit() != letter.is_ascii_digit() {
            found.push(String::new());
        }
        if let Some(last) = found.last_mut().filter(|_| letter.is_alphanumeric()) {
            last.extend(letter.to_lowercase());
        }
    }
    found.retain(|word| !word.is_empty());
    found
}

/// A counter that begins anew at a power of two.
#[derive(Debug, Clone, Default)]
pub(crate) struct Counter {
    last: Option<f64>,
    added: f64,
    /// The last step forward.
    step: f64,
    /// How often it began anew, and at which power the last time.
    anew: (u64, i32),
}

impl Counter {
    /// Counts that go on where the counter begins anew: from below a power of two to the lowest number that it has, 0 or, with a sign, half of that, by a step that is none of a gap.
    pub fn onward(&mut self, counts: &mut [f64]) {
        for count in counts {
            let step = self.last.map_or(0.0, |last| *count - last);
            let is_step = |step: f64| (0.0..=GAP * self.step).contains(&step);
            let is_anew = |power: &i32| {
                let all = 2.0_f64.powi(*power);
                is_step(all + step) && [0.0, -0.5 * all].into_iter().any(|lowest| is_step(*count - lowest))
            };
            if step < 0.0
                && count.fract() == 0.0
                && let Some(power) = [16, 24, 32].into_iter().find(is_anew)
            {
                self.added += 2.0_f64.powi(power);
                self.anew = (self.anew.0 + 1, power);
            } else if step > 0.0 {
                self.step = step;
            }
            self.last = Some(*count);
            *count += self.added;
        }
    }

    /// What is to be said of it.
    fn note(&self, title: &str) -> Option<String> {
        let (times, power) = self.anew;
        let s = if times == 1 { "" } else { "s" };
        (times > 0)
            .then(|| format!("the counter in '{title}' begins anew at 2^{power} {times} time{s}; times go on there"))
    }
}

/// Times of rows, one block after the other.
#[derive(Debug, Clone, Default)]
pub struct Clock {
    /// Seconds in a unit of the column; `None` where a rate was stated.
    factor: Option<f64>,
    /// Does the column say no unit? Then its times do.
    bare: bool,
    /// What was taken that the column does not say: that it is one of times, its unit.
    taken: Vec<String>,
    /// Resolution of the times, where several rows have one time: their step; else 0.
    tick: f64,
    /// The step to which times are rounded, where it is not much shorter than that of the rows; else 0.
    rounding: f64,
    /// By how much the last step was shorter than usual, s, where it was a short one: the next may be longer by that.
    owed: f64,
    /// Rows since the time last changed, where several rows have one; `None` before it does.
    still: Option<u64>,
    /// Times of the block's rows, s since the first row; the last of those before; and rows since the last gap.
    times: Vec<f64>,
    before: Vec<f64>,
    unbroken: usize,
    title: String,
    file: String,
    step: f64,
    origin: Option<f64>,
    last: f64,
    rows: u64,
    /// Sum and number of the steps that are no gaps.
    steps: (f64, u64),
    /// Smallest and largest of them.
    range: Option<(f64, f64)>,
    jumps: Vec<Jump>,
    /// Steps back, gaps and short steps, all of them.
    counts: [u64; 3],
    /// What is missing in all gaps, s.
    lost: f64,
    /// What steps back have taken from the times, s.
    set_back: f64,
    pending_gap: bool,
    counter: Counter,
}

/// Most gaps that are kept; more are counted.
const KEPT: usize = 1000;

impl Clock {
    /// Equally spaced rows, whatever the column `unused` says.
    ///
    /// Errors: a rate that is not positive.
    pub(crate) fn rate(rate_hz: f64, unused: &str, file: &str) -> Result<Self> {
        if !(rate_hz > 0.0) || !rate_hz.is_finite() {
            return Err(Malformed::new(Fault::Value, "the sampling rate is not positive")
                .expected("samples a second")
                .found(rate_hz.to_string()));
        }
        Ok(Clock { step: 1.0 / rate_hz, title: unused.into(), file: file.into(), ..Clock::default() })
    }

    /// Times from a column: its unit stands in its title or at the end of its name (`time_s`, `t_ms`), else they are seconds, or what their size and their steps say.
    ///
    /// Errors: a unit that is none of time.
    pub fn column(column: &Column, file: &str) -> Result<Self> {
        let unit = unit_of_times(column);
        let factor = match unit.as_deref() {
            None => 1.0,
            Some(unit) => seconds(unit).ok_or_else(|| {
                Malformed::new(Fault::Value, format!("'{}' is not a column of times", column.title))
                    .expected("a unit of time: s, ms, us, ns, min or h")
                    .found(format!("'{unit}'"))
                    .in_file(file)
            })?,
        };
        let (bare, factor, title) = (unit.is_none(), Some(factor), column.title.clone());
        Ok(Clock { bare, factor, title, file: file.into(), ..Clock::default() })
    }

    /// The same, with what else is to be said of it.
    pub(crate) fn with_notes(mut self, notes: impl IntoIterator<Item = String>) -> Self {
        self.taken.extend(notes);
        self
    }

    /// Seconds in a unit of the column; 1 where a rate was stated.
    pub(crate) fn seconds_per_unit(&self) -> f64 {
        self.factor.unwrap_or(1.0)
    }

    /// Does the column say no unit? Then its times do.
    pub(crate) fn is_bare(&self) -> bool {
        self.bare
    }

    /// Where the next `count` rows stand; `times` is their column. Rows outside `from` to `to` (s since the first row) are left out.
    ///
    /// Errors: times that are not sorted, or not numbers; with the row.
    pub fn stretches(
        &mut self,
        times: Option<&[f64]>,
        count: usize,
        from: Option<f64>,
        to: Option<f64>,
    ) -> Result<Vec<Stretch>> {
        let (from, to) = (from.unwrap_or(f64::NEG_INFINITY), to.unwrap_or(f64::INFINITY));
        if !(from < to) {
            return Err(Malformed::new(Fault::Value, "the part of the record that is asked for has no length")
                .expected("--from before --to, in seconds")
                .found(format!("from {from} to {to}")));
        }
        let mut found: Vec<Stretch> = Vec::new();
        self.before.append(&mut self.times);
        self.before.drain(..self.before.len().saturating_sub(NEAR));
        let (Some(_), Some(times)) = (self.factor, times) else {
            let start = self.rows as f64 * self.step;
            let place = |t: f64| number::count(((t - start) / self.step).ceil()).min(count);
            let rows = place(from)..place(to);
            self.times.extend((0..count).map(|k| (self.rows + k as u64) as f64 * self.step));
            self.rows += count as u64;
            if !rows.is_empty() {
                found.push(Stretch { rows, after_gap: false });
            }
            return Ok(found);
        };
        let mut counted = times.to_vec();
        self.counter.onward(&mut counted);
        let times = counted.as_slice();
        if self.bare && times.len() > 1 && times.iter().all(|time| is_compact(*time)) {
            let first = times.first().copied().unwrap_or(f64::NAN);
            return Err(Malformed::new(Fault::Value, "dates without separators are numbers here")
                .expected("dates as 2026-11-20T09:14:03, or times in a unit that the title says, for example time (s)")
                .found(first.to_string())
                .at_path(&self.title)
                .in_file(&self.file));
        }
        if std::mem::take(&mut self.bare)
            && let Some(unit) = unit_of(&self.title, times)
        {
            self.learn(times, unit.seconds);
            self.taken.extend(unit.said(&self.title, &self.file, self.step)?);
            self.factor = Some(unit.seconds);
        }
        let factor = self.factor.unwrap_or(1.0);
        if self.step == 0.0 {
            self.learn(times, factor);
        }
        let mut inside = false;
        for (k, raw) in times.iter().enumerate() {
            let origin = *self.origin.get_or_insert(raw * factor);
            let mut time = raw * factor - origin + self.set_back;
            if !time.is_finite() {
                return Err(self.unsorted("a row has no time", *raw, factor));
            }
            let step = time - self.last;
            let usual = self.step.max(self.tick);
            let kind = match self.rows {
                0 => None,
                _ if !(step > -GAP * usual) => Some(JumpKind::Back),
                _ if step - self.owed > GAP * usual && self.lacks(times.part(k..), time - raw * factor) => {
                    Some(JumpKind::Gap)
                }
                _ if self.tick == 0.0 && step < SHORT * self.step => Some(JumpKind::Short),
                _ => None,
            };
            self.owed = if kind == Some(JumpKind::Short) { usual - step } else { 0.0 };
            if let Some(kind) = kind {
                let [back, gaps, short] = &mut self.counts;
                let count = match kind {
                    JumpKind::Back => back,
                    JumpKind::Gap => gaps,
                    JumpKind::Short => short,
                };
                *count += 1;
                if kind == JumpKind::Gap {
                    self.lost += step - usual;
                }
                if kind == JumpKind::Back {
                    if *count * RARE > self.rows {
                        return Err(self.unsorted("the times are not sorted", *raw, factor));
                    }
                    // the record goes on one step later
                    self.set_back += usual - step;
                    time = self.last + usual;
                }
                if self.jumps.len() < KEPT {
                    self.jumps.push(Jump { kind, row: self.rows, time: self.last, step });
                }
            }
            let gap = matches!(kind, Some(JumpKind::Gap | JumpKind::Back));
            if gap {
                self.still = None;
                self.unbroken = 0;
                self.pending_gap = true;
            } else if self.rows > 0 {
                self.count(step.max(0.0));
                let (least, most) = self.range.unwrap_or((step, step));
                self.range = Some((step.min(least), step.max(most)));
            }
            // times that changed places do not go back
            self.last = self.last.max(time);
            self.times.push(self.last);
            self.unbroken += 1;
            self.rows += 1;
            let wanted = time >= from && time <= to;
            inside &= wanted && !gap;
            match found.last_mut().filter(|_| inside) {
                Some(stretch) => stretch.rows.end = k + 1,
                None if wanted => {
                    found.push(Stretch { rows: k..k + 1, after_gap: std::mem::take(&mut self.pending_gap) });
                    inside = true;
                }
                None => {}
            }
        }
        Ok(found)
    }

    /// Are rows missing before these times, which are `shift` off? Then all that follow are late against all before them, each less its number of intervals; the scatter of one time
    /// is gone with the next. Where fewer rows say so, they are late by half an interval at least. Of times that are coarser than the samples a long step says it alone.
    fn lacks(&self, times: &[f64], shift: f64) -> bool {
        let (step, factor) = (self.step, self.factor.unwrap_or(1.0));
        let is_forward = |(now, next): &(&f64, &f64)| (**next - **now) * factor > -GAP * step;
        // up to where the clock is set back
        let behind = times.iter().zip(times.iter().skip(1)).take(NEAR - 1).take_while(is_forward).count() + 1;
        let late = times.iter().take(behind).zip(0..).map(|(raw, k)| raw * factor + shift - f64::from(k) * step);
        let ahead = NEAR.min(self.unbroken);
        let before = self.times.iter().rev().chain(self.before.iter().rev()).take(ahead);
        let even = before.zip(1..).map(|(time, k)| time + f64::from(k) * step);
        let least = if behind.min(ahead) < NEAR { 0.5 * step } else { 0.0 };
        // a time that is rounded may be off by as much
        let least = least.max(self.rounding * (1.0 + ALIKE));
        self.tick > 0.0 || late.fold(f64::INFINITY, f64::min) - even.fold(f64::NEG_INFINITY, f64::max) > least
    }

    /// The usual step, and whether several rows have one time.
    fn learn(&mut self, times: &[f64], factor: f64) {
        let mut steps: Vec<f64> = pairs(times).map(|(before, time)| (time - before) * factor).collect();
        let equal = steps.iter().filter(|step| **step == 0.0).count();
        steps.retain(|step| *step > 0.0);
        steps.sort_by(f64::total_cmp);
        let mut median = steps.get(steps.len() / 2).copied().unwrap_or(0.0); // no step forward
        let is_even = |step: &&f64| (*step - median).abs() <= SHORT * median;
        // times that scatter by the interval itself: over more rows than one they are better than a single step, which has no symmetric distribution where they were sorted
        if equal < steps.len() && 2 * steps.iter().filter(is_even).count() <= steps.len() {
            let apart = times.iter().zip(times.iter().skip(NEAR)).take(PAIRS);
            let mut apart: Vec<f64> = apart.map(|(before, time)| (time - before) * factor / NEAR as f64).collect();
            median = number::median(&mut apart).filter(|step| *step > 0.0).unwrap_or(median);
        }
        // half of the rows and more share their time with the row before: the times are coarser than the samples
        let coarse = equal >= steps.len();
        self.tick = if coarse { median } else { 0.0 };
        // coarse times: rows between the first change and the last
        let changed = |pair: (&f64, &f64)| pair.0 < pair.1;
        let (first, last) = (pairs(times).position(changed), pairs(times).rposition(changed));
        let rows = last.unwrap_or(0) - first.unwrap_or(0);
        let changes = steps.len().saturating_sub(1);
        self.step = if coarse && rows > 0 { median * changes as f64 / rows as f64 } else { median };
        if let Some((step, rounding)) = rounded(times, &steps, factor).filter(|_| equal == 0) {
            (self.step, self.rounding) = (step, rounding);
        }
    }

    /// A step that is no gap. Where several rows have one time, the steps between the first change and the last are spread over the rows between.
    fn count(&mut self, step: f64) {
        if self.tick == 0.0 {
            self.steps = (self.steps.0 + step, self.steps.1 + 1);
        } else if step == 0.0 {
            self.still = self.still.map(|rows| rows + 1);
        } else if let Some(rows) = self.still.replace(0) {
            self.steps = (self.steps.0 + step, self.steps.1 + rows + 1);
        }
    }

    /// Times of the rows of the last block, s since the first row; times that changed places or were set back never go back here.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Mean sampling interval, s, without the gaps.
    ///
    /// Errors: fewer than two rows.
    pub fn interval(&self) -> Result<f64> {
        if self.factor.is_none() {
            return Ok(self.step);
        }
        match self.steps {
            (sum, n) if n > 0 => Ok(sum / n as f64),
            _ => Err(Malformed::new(Fault::Missing, "the record has fewer than two rows")
                .expected("at least two rows with times")
                .in_file(&self.file)),
        }
    }

    /// The sampling interval that gaps are judged by; 0 before the first block.
    pub(crate) fn step(&self) -> f64 {
        self.step
    }

    /// Rows so far.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// Where the times come from.
    pub fn source(&self) -> String {
        match (self.factor, self.title.as_str()) {
            (Some(_), title) => format!("from '{title}'"),
            (None, "") => "rate as stated".into(),
            (None, title) => format!("rate as stated, not from '{title}'"),
        }
    }

    fn unsorted(&self, what: &str, raw: f64, factor: f64) -> Malformed {
        let before = (self.last - self.set_back + self.origin.unwrap_or(0.0)) / factor;
        Malformed::new(Fault::Value, what)
            .expected("times that increase (or a sampling rate instead of the column)")
            .found(format!("{raw} in row {} after {before}", self.rows + 1))
            .at_path(&self.title)
            .in_file(&self.file)
    }

    /// Jumps met so far (the first thousand), how many of them are gaps, and how many are not.
    pub fn jumps(&self) -> (&[Jump], u64, u64) {
        let [back, gaps, short] = self.counts;
        (&self.jumps, gaps, back + short)
    }

    /// What a reader of the result should know about the times.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let of = |kind: JumpKind| self.jumps.iter().filter(move |jump| jump.kind == kind);
        let s = |n: u64| if n == 1 { "" } else { "s" };
        let [back, gaps, short] = self.counts;
        notes.extend_from_slice(&self.taken);
        notes.extend(self.counter.note(&self.title));
        if self.tick > 0.0 {
            notes.push(format!(
                "several rows have one time in '{}', whose steps are {:.6} s; samples are taken as equally spaced",
                self.title, self.tick
            ));
        }
        if self.rounding > 0.0 {
            notes.push(format!(
                "the times in '{}' are rounded to {:.6} s, of samples {:.6} s apart; samples are taken as equally spaced",
                self.title, self.rounding, self.step
            ));
        }
        if let Some(gap) = of(JumpKind::Gap).next() {
            notes.push(format!(
                "{gaps} gap{} in '{}' ({:.3} s are missing in all, or the clock was set forward); the first is of {:.3} s, {:.3} s after the start",
                s(gaps), self.title, self.lost, gap.step, gap.time
            ));
        }
        if let Some(jump) = of(JumpKind::Back).next() {
            notes.push(format!(
                "the clock goes back {back} time{} in '{}'; the first time by {:.3} s, {:.3} s after the start; times go on from there by one sampling interval",
                s(back), self.title, -jump.step, jump.time
            ));
        }
        if let Some(jump) = of(JumpKind::Short).next() {
            notes.push(format!(
                "{short} step{} in '{}' {} shorter than a quarter of the sampling interval, or back by less than two (equal times, times that changed places, a clock set back by less than an interval); the first is of {:.6} s, {:.3} s after the start",
                s(short), self.title, if short == 1 { "is" } else { "are" }, jump.step, jump.time
            ));
        }
        let mean = if self.steps.1 > 0 { self.steps.0 / self.steps.1 as f64 } else { 0.0 };
        if let Some((least, most)) = self.range
            && mean > 0.0
            && self.tick == 0.0
            && self.rounding == 0.0
            && most - least > 0.2 * mean
        {
            notes.push(format!(
                "the sampling interval varies from {least:.6} s to {most:.6} s; samples are taken as equally spaced at {mean:.6} s"
            ));
        }
        notes
    }
}

/// So many of the first times say what is usual.
const PAIRS: usize = 4001;

/// A relative difference between steps that is their own rounding, as of single-precision numbers that are written with three decimals.
const ALIKE: f64 = 0.15;

/// The step of even rows and that to which their times are rounded, s, where the first is less than twice the second: steps are then one and two of the rounding, and a long one looks like a row
/// that is missing. But of even rows the time of `SPAN` of them has two values, one rounding apart, or three where halves are rounded either way; rows that are missing at random, one of a hundred and
/// more, leave seven and more (of a Poisson distribution of 2.6).
fn rounded(times: &[f64], steps: &[f64], factor: f64) -> Option<(f64, f64)> {
    const SPAN: usize = 256;
    let least = *steps.first()?;
    let short = steps.partition_point(|step| *step < 1.5 * least);
    let tick = *steps.get(short / 2)?;
    let of = |k: f64| steps.iter().filter(|step| (*step - k * tick).abs() <= ALIKE * k * tick).count();
    let (once, twice) = (of(1.0), of(2.0));
    // one long step in a hundred and more, as the spans below can tell from rows that are missing; gaps now and again, which are neither, lie in the fortieth that is trimmed at either end of the spans
    if 100 * twice < steps.len() || 100 * (once + twice) < 97 * steps.len() {
        return None;
    }
    let mut spans: Vec<f64> =
        times.iter().zip(times.iter().skip(SPAN)).take(PAIRS).map(|(a, b)| (b - a) * factor).collect();
    if spans.len() < SPAN {
        return None;
    }
    spans.sort_by(f64::total_cmp);
    let trimmed = spans.get(spans.len() / 40..spans.len() - spans.len() / 40)?;
    let (low, high) = (trimmed.first()?, trimmed.last()?);
    let mean = trimmed.iter().sum::<f64>() / trimmed.len() as f64 / SPAN as f64;
    (high - low <= (2.0 + ALIKE) * tick).then_some((mean, tick))
}

/// Neighbouring times, of the first few thousand.
fn pairs(times: &[f64]) -> impl DoubleEndedIterator<Item = (&f64, &f64)> + ExactSizeIterator {
    times.iter().zip(times.iter().skip(1)).take(PAIRS)
}

/// Unix time from 2001 to 2103.
const SINCE_1970: std::ops::Range<f64> = 1e9..4.2e9;
/// Days of spreadsheets (since the end of 1899) and of MATLAB (since the year 0), from 2000 to 2100.
const DAYS: [std::ops::Range<f64>; 2] = [36_526.0..73_051.0, 730_486.0..767_011.0];

/// The unit of times that say none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Unsaid {
    name: &'static str,
    /// Its seconds.
    pub seconds: f64,
    /// The median step of the times, s.
    pub step: f64,
}

impl Unsaid {
    /// That it was taken, where it could be another one.
    ///
    /// Errors: steps that are those of no logger in seconds, where times could be hours or days.
    pub fn said(&self, title: &str, file: &str, step: f64) -> Result<Option<String>> {
        if self.name == "s" && step < FASTEST {
            return Err(Malformed::new(
                Fault::Missing,
                format!("'{title}' has no unit, and its steps are too short for seconds"),
            )
            .expected("its unit in the title: time (h), time (d), time_s")
            .found(format!("steps of {step:.3e}, as seconds {:.3e} samples a second", 1.0 / step))
            .at_path(title)
            .in_file(file));
        }
        // steps of a second and more, were they of milliseconds, would be those of a logger as well, and very short ones those of minutes and hours
        let is_sure = (FAST..1.0).contains(&step);
        Ok(match self.name {
            "s" if is_sure => None,
            "s" => Some(format!(
                "'{title}' has no unit and is read as seconds, with steps of {step}; a title such as time_ms says another unit"
            )),
            unit => {
                Some(format!("'{title}' has no unit; its steps are those of a logger in {unit}, and it is read so"))
            }
        })
    }
}

/// Shorter steps than this, s, may be those of another unit: a logger at 10 Hz in hours has steps of 2.8e-5,
const FAST: f64 = 1e-4;
/// and no inertial sensor is logged as fast as this, 100 kHz; one at 100 Hz has steps of 2.8e-6 in hours, of 1.2e-7 in days.
const FASTEST: f64 = 1e-5;

/// The unit of times whose title says none; `None` where fewer than two are there.
///
/// Unix time tells its unit by its size, from 2001 to 2103; days do where as seconds they would be those of more than 10,000 samples a second. Of other
/// times a step of 1000 s and more is none of a logger of inertial sensors: below 10^6 it is counted in microseconds, above in nanoseconds.
pub(crate) fn unit_of(title: &str, times: &[f64]) -> Option<Unsaid> {
    const UNITS: [(&str, f64); 4] = [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)];
    const SLOW: f64 = 1e3;
    let first = *times.first()?;
    let mut steps: Vec<f64> = pairs(times).map(|(a, b)| b - a).collect();
    steps.retain(|step| *step > 0.0);
    let median = number::median(&mut steps)?;
    let of = |(name, seconds): (&'static str, f64)| Unsaid { name, seconds, step: median * seconds };
    // Xsens gives one name to two clocks: the MTi counts 10 kHz, of which half a second and more is no sampling interval; the DOT, with 120 Hz at most, microseconds
    if words(title).concat() == "sampletimefine" {
        return Some(of(if median < 5000.0 { ("ticks of 0.1 ms", 1e-4) } else { ("us", 1e-6) }));
    }
    let unix = |(_, seconds): &&(&str, f64)| SINCE_1970.contains(&(first * seconds)) && median * seconds < SLOW;
    if median < FAST && DAYS.iter().any(|days| days.contains(&first)) {
        return Some(of(("days", 86_400.0)));
    }
    let [second, _, micro, nano] = UNITS;
    let by_steps = if median < SLOW {
        second
    } else if median < 1e6 {
        micro
    } else {
        nano
    };
    Some(of(UNITS.iter().find(unix).copied().unwrap_or(by_steps)))
}

/// Is it a date and a time written together, `20261120091403`?
fn is_compact(time: f64) -> bool {
    (19_700_101e6..21_010_101e6).contains(&time)
        && time.fract() == 0.0
        && jiff::civil::DateTime::strptime("%Y%m%d%H%M%S", format!("{time:.0}")).is_ok()
}

/// Seconds in a unit of time.
pub(super) fn seconds(unit: &str) -> Option<f64> {
    let (unit, second) = (Unit::parse(unit.trim()).ok()?, Unit::parse("s").ok()?);
    // a pure number is none of time
    Some(unit.conversion(&second)?.apply(1.0))
}
