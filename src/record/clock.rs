//! The clock of a record: a column of times or a stated rate; stretches between gaps.

use super::Column;
use crate::error::{Fault, Malformed, Result};
use std::ops::Range;

/// A step longer than this many sampling intervals is a gap.
const GAP: f64 = 1.75;

/// Rows that follow each other without a gap.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stretch {
    /// Rows of the block.
    pub rows: Range<usize>,
    /// Does a gap stand before them?
    pub after_gap: bool,
}

/// Where a record jumps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// Rows before it.
    pub row: u64,
    /// Time of the last of them, s since the first row.
    pub time: f64,
    /// How long it is, s.
    pub length: f64,
}

/// Times of rows, one block after the other.
#[derive(Debug, Clone)]
pub struct Clock {
    /// Seconds in a unit of the column; `None` where a rate was stated.
    factor: Option<f64>,
    title: String,
    file: String,
    step: f64,
    origin: Option<f64>,
    last: f64,
    rows: u64,
    /// Sum and number of the steps that are no gaps.
    steps: (f64, u64),
    /// Smallest and largest of them.
    range: (f64, f64),
    gaps: Vec<Gap>,
    gap_count: u64,
    pending_gap: bool,
}

/// Most gaps that are kept; more are counted.
const KEPT: usize = 1000;

impl Clock {
    /// Equally spaced rows.
    ///
    /// Errors: a rate that is not positive.
    pub fn rate(rate_hz: f64, file: &str) -> Result<Self> {
        if !(rate_hz > 0.0) || !rate_hz.is_finite() {
            return Err(Malformed::new(Fault::Value, "the sampling rate is not positive")
                .expected("samples a second")
                .found(rate_hz.to_string()));
        }
        Ok(Clock { step: 1.0 / rate_hz, ..Clock::empty(None, String::new(), file) })
    }

    /// Times from a column: its unit stands in its title or at the end of its name (`time_s`, `t_ms`), else they are seconds.
    ///
    /// Errors: a unit that is none of time.
    pub fn column(column: &Column, file: &str) -> Result<Self> {
        let behind = column.name.rsplit_once('_').map(|(_, unit)| unit.to_string());
        let unit = column.unit.clone().or_else(|| behind.filter(|unit| seconds(unit).is_some()));
        let factor = match unit.as_deref() {
            None => 1.0,
            Some(unit) => seconds(unit).ok_or_else(|| {
                Malformed::new(Fault::Value, format!("'{}' is not a column of times", column.title))
                    .expected("a unit of time: s, ms, us, ns, min or h")
                    .found(format!("'{unit}'"))
                    .in_file(file)
            })?,
        };
        Ok(Clock::empty(Some(factor), column.title.clone(), file))
    }

    fn empty(factor: Option<f64>, title: String, file: &str) -> Self {
        Clock {
            factor,
            title,
            file: file.into(),
            step: 0.0,
            origin: None,
            last: 0.0,
            rows: 0,
            steps: (0.0, 0),
            range: (f64::INFINITY, 0.0),
            gaps: Vec::new(),
            gap_count: 0,
            pending_gap: false,
        }
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
        let mut found: Vec<Stretch> = Vec::new();
        let (Some(factor), Some(times)) = (self.factor, times) else {
            let start = self.rows as f64 * self.step;
            let place = |t: f64| (((t - start) / self.step).ceil().max(0.0) as usize).min(count);
            let rows = place(from)..place(to);
            self.rows += count as u64;
            if !rows.is_empty() {
                found.push(Stretch { rows, after_gap: false });
            }
            return Ok(found);
        };
        if self.step == 0.0 {
            let mut steps: Vec<f64> = times.windows(2).take(4001).map(|w| (w[1] - w[0]) * factor).collect();
            steps.retain(|step| *step > 0.0);
            steps.sort_by(f64::total_cmp);
            self.step = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
        }
        let mut start = 0;
        let mut inside = false;
        for (k, raw) in times.iter().enumerate() {
            let origin = *self.origin.get_or_insert(raw * factor);
            let time = raw * factor - origin;
            if !time.is_finite() || (self.rows > 0 && !(time > self.last)) {
                let what = if time.is_finite() { "the times are not sorted" } else { "a row has no time" };
                return Err(Malformed::new(Fault::Value, what)
                    .expected("times that increase (or a sampling rate instead of the column)")
                    .found(format!("{raw} in row {} after {}", self.rows + 1, (self.last + origin) / factor))
                    .at_path(&self.title)
                    .in_file(&self.file));
            }
            let step = time - self.last;
            let gap = self.rows > 0 && step > GAP * self.step;
            if gap {
                self.gap_count += 1;
                if self.gaps.len() < KEPT {
                    self.gaps.push(Gap { row: self.rows, time: self.last, length: step });
                }
                self.pending_gap = true;
            } else if self.rows > 0 {
                self.steps = (self.steps.0 + step, self.steps.1 + 1);
                self.range = (self.range.0.min(step), self.range.1.max(step));
            }
            self.last = time;
            self.rows += 1;
            let wanted = time >= from && time <= to;
            if inside && (gap || !wanted) {
                found.push(Stretch { rows: start..k, after_gap: false });
                inside = false;
            }
            if wanted && !inside {
                start = k;
                inside = true;
                found.push(Stretch { rows: k..k, after_gap: self.pending_gap });
                self.pending_gap = false;
            }
        }
        if inside {
            found.push(Stretch { rows: start..times.len(), after_gap: false });
        }
        // an opening and its end were noted apart
        let mut merged: Vec<Stretch> = Vec::with_capacity(found.len() / 2 + 1);
        for stretch in found {
            match merged.last_mut() {
                Some(open) if open.rows.is_empty() && open.rows.start == stretch.rows.start => open.rows = stretch.rows,
                _ => merged.push(stretch),
            }
        }
        merged.retain(|stretch| !stretch.rows.is_empty());
        Ok(merged)
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
    pub fn step(&self) -> f64 {
        self.step
    }

    /// Rows so far.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// Where the times come from.
    pub fn source(&self) -> String {
        if self.factor.is_none() { "rate as stated".into() } else { format!("from '{}'", self.title) }
    }

    /// Gaps met so far (the first thousand), and how many there are.
    pub fn gaps(&self) -> (&[Gap], u64) {
        (&self.gaps, self.gap_count)
    }

    /// What a reader of the result should know about the times.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if let (Some(gap), n) = (self.gaps.first(), self.gap_count)
            && n > 0
        {
            let lost = self.gaps.iter().map(|gap| gap.length).sum::<f64>();
            notes.push(format!(
                "{n} gap{} in '{}' ({lost:.3} s in all); the first is of {:.3} s, {:.3} s after the start",
                if n == 1 { "" } else { "s" },
                self.title,
                gap.length,
                gap.time
            ));
        }
        let mean = if self.steps.1 > 0 { self.steps.0 / self.steps.1 as f64 } else { 0.0 };
        if mean > 0.0 && (self.range.1 - self.range.0) > 0.2 * mean {
            notes.push(format!(
                "the sampling interval varies from {:.6} s to {:.6} s; samples are taken as equally spaced at {mean:.6} s",
                self.range.0, self.range.1
            ));
        }
        notes
    }
}

/// Seconds in a unit of time.
fn seconds(unit: &str) -> Option<f64> {
    Some(match unit.trim() {
        "s" | "sec" | "seconds" | "Sekunden" => 1.0,
        "ms" => 1e-3,
        "us" | "µs" | "μs" => 1e-6,
        "ns" => 1e-9,
        "min" => 60.0,
        "h" => 3600.0,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stretches_end_at_gaps_also_between_blocks() {
        let column = Column { name: "t".into(), title: "t [ms]".into(), unit: Some("ms".into()) };
        let mut clock = Clock::column(&column, "log.csv").expect("times");
        let found = clock.stretches(Some(&[0.0, 10.0, 20.0, 50.0, 60.0]), 5, None, None).expect("sorted");
        assert_eq!(found, [Stretch { rows: 0..3, after_gap: false }, Stretch { rows: 3..5, after_gap: true }]);
        let found = clock.stretches(Some(&[200.0, 210.0]), 2, None, Some(0.205)).expect("sorted");
        assert_eq!(found, [Stretch { rows: 0..1, after_gap: true }]);
        assert!((clock.interval().expect("steps") - 0.01).abs() < 1e-12 && clock.gaps().1 == 2);
        assert!(clock.stretches(Some(&[100.0]), 1, None, None).is_err());
    }
}
