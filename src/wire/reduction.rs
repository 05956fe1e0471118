//! A recipe carried out: from a record to readings.
//!
//! ```text
//! record -> columns -> trace -> segments -> (rows of the schedule) -> whole turns -> means with their uncertainties
//! ```

use super::columns::of_title;
use super::reduced::{ReducedReading, Schedule, TOLD};
use super::samples_file::{Recipe, SegmentsBy};
use crate::elements::{Elements, Parts};
use crate::error::{Fault, Malformed, Result};
use crate::number;
use crate::record::{self, As, Block, Clock, Jump, Record};
use crate::reduce::{self, By, EventKind, Reduction, Run, Segment, Segmentation, Trace, Unwrap};
use crate::units::Conversion;

/// A record that was reduced.
#[derive(Debug)]
pub struct Reduced {
    /// The record in blocks.
    pub trace: Trace,
    /// Segments and means; none where nothing was found.
    pub reduction: Reduction,
    /// For each segment its row of the schedule.
    pub places: Vec<usize>,
    /// How segments were found, in words.
    pub by: String,
    /// Gaps in the times.
    pub gaps: u64,
    /// Other jumps of the clock.
    pub clock_jumps: u64,
    /// Gaps and jumps, the first thousand.
    pub jumps: Vec<Jump>,
    /// What should be told about the times.
    pub notes: Vec<String>,
    /// Where there is no segment: why, and what would find one.
    pub nothing: Option<Vec<String>>,
}

/// Fits until the uncertainties of computed values no longer change.
const ROUNDS: usize = 20;

impl Recipe {
    /// Carry it out; what a schedule computes from samples is computed at the solution of its readings, for which the record is read again.
    ///
    /// Errors: those of opening the record, and of [`Recipe::reduce`].
    pub(crate) fn reduce_for(
        &self,
        open: &mut dyn FnMut() -> Result<Record>,
        mut schedule: Option<&mut Schedule>,
    ) -> Result<(Record, Reduced)> {
        let mut rounds = 0..ROUNDS;
        loop {
            let mut record = open()?;
            let reduced = self.reduce(&mut record, schedule.as_deref())?;
            if rounds.next().is_none()
                || !schedule.as_mut().is_some_and(|schedule| schedule.moves(&reduced.readings(), &reduced.places))
            {
                return Ok((record, reduced));
            }
        }
    }

    /// Carry it out, with lines that a schedule computes where it stands.
    ///
    /// Errors: columns that are not there, times that are not sorted, another number of segments than of positions.
    pub fn reduce(&self, record: &mut Record, schedule: Option<&Schedule>) -> Result<Reduced> {
        let (trace, clock) = self.read(record, schedule)?;
        let by = match &self.segments {
            SegmentsBy::Column(_) => By::Labels,
            SegmentsBy::Times { list, .. } => By::Times(list.clone()),
            SegmentsBy::Still { window, threshold } => By::Still { window: *window, threshold: *threshold },
        };
        let still = matches!(by, By::Still { .. });
        let guard = self.guard.unwrap_or(if still { 0.5 } else { 0.0 });
        let least = self.least.unwrap_or(if still { 1.0 } else { 0.0 });
        let mut segmentation = reduce::segment(&trace, &by, guard, least);
        let (jumps, gaps, clock_jumps) = clock.jumps();
        let mut reduced = Reduced {
            reduction: Reduction {
                segments: Vec::new(),
                rejected: Vec::new(),
                means: Vec::new(),
                stillness: None,
                assumed: Vec::new(),
            },
            places: Vec::new(),
            by: self.segments.words(),
            gaps,
            clock_jumps,
            jumps: jumps.to_vec(),
            notes: clock.notes().into_iter().chain(incomplete(&trace)).collect(),
            nothing: None,
            trace,
        };
        let trace = &reduced.trace;
        if segmentation.segments.is_empty() {
            reduced.nothing = Some(nothing(&segmentation, &by, least));
            return Ok(reduced);
        }
        let labels = |segmentation: &Segmentation| -> Vec<String> {
            segmentation.segments.iter().map(|s| s.label.clone()).collect()
        };
        let pair = |segmentation: &Segmentation| match schedule {
            Some(schedule) => schedule.pair(&labels(segmentation)).map_err(|error| located(error, trace, segmentation)),
            None => Ok(Vec::new()),
        };
        let mut places = pair(&segmentation)?;
        segmentation.number();
        let whole: Vec<(u64, u64)> = segmentation.segments.iter().map(Segment::span).collect();
        let before = segmentation.segments.len();
        let turns = match &trace.angle {
            Some(_) => reduce::whole_turns_of(trace, &mut segmentation),
            None => {
                let none = vec![None; before];
                let of = |s: &Schedule| places.iter().map(|place| s.turn_s(*place)).collect::<Vec<_>>();
                reduce::whole_turns(trace, &mut segmentation, &schedule.map_or(none, of))
            }
        };
        if segmentation.segments.len() != before {
            if segmentation.segments.is_empty() {
                reduced.nothing = Some(nothing(&segmentation, &by, least));
                return Ok(reduced);
            }
            // a segment that is left keeps the row that it had
            let of = |segment: &Segment| {
                let (at, _) = segment.span();
                let k = whole.iter().position(|(start, end)| *start <= at && at < *end)?;
                places.get(k).copied()
            };
            places = segmentation.segments.iter().filter_map(of).collect();
        }
        reduced.reduction = reduce::reduce(trace, segmentation, &turns);
        reduced.places = places;
        Ok(reduced)
    }

    /// The record as a trace, and its clock.
    fn read(&self, record: &mut Record, schedule: Option<&Schedule>) -> Result<(Trace, Clock)> {
        let time = self.clock.column(record)?;
        let label = match &self.segments {
            SegmentsBy::Column(name) => Some(record.find(name)?),
            _ => None,
        };
        let angle = self.encoder.as_ref().map(|encoder| record.find(&encoder.column)).transpose()?;
        // counts are those of a turn; without them the unit of the title is, and degrees where it says none
        let turn = self.encoder.as_ref().and_then(|encoder| encoder.turn);
        let titled_angle = angle.filter(|_| turn.is_none()).and_then(|k| record.columns().get(k));
        let to_degrees = titled_angle.map_or(Ok(None), |column| of_title(column, "", "deg")).map_err(|error| {
            error.expected("an angle, or the number of counts in a turn (--counts-per-turn N)").in_file(record.name())
        })?;
        let chosen = self.chosen(record, schedule, &[time, label, angle, self.clock.unused(record)])?;
        let mut titled = Vec::with_capacity(chosen.len());
        let mut conversions: Vec<Option<Conversion>> = Vec::with_capacity(chosen.len());
        for (name, k) in &chosen {
            let Some(column) = record.columns().get(*k) else { continue };
            let converted = schedule.map_or(Ok(None), |s| s.conversion(name, column));
            let converted = converted.map_err(|e| e.in_file(record.name()))?;
            let (unit, conversion) = converted.unwrap_or_else(|| (column.unit_for(None).unwrap_or_default(), None));
            titled.push((name.clone(), unit));
            conversions.push(conversion);
        }
        let names: Vec<String> = chosen.iter().map(|(name, _)| name.clone()).collect();
        let computed = schedule.map(|s| s.computed(&names)).unwrap_or_default();
        titled.extend(computed.iter().map(|c| (c.name.clone(), c.unit.clone())));
        titled.extend(angle.map(|_| ("angle".to_string(), "turns".to_string())));
        let mut trace = Trace::new(titled);
        trace.observed = chosen.len();
        let mut unwrap = Unwrap::new(turn.unwrap_or(360.0));
        let mut selected: Vec<(usize, As)> = chosen.iter().map(|(_, k)| (*k, As::Number)).collect();
        let [time_at, angle_at, label_at] =
            [(time, As::Time), (angle, As::Number), (label, As::Label)].map(|(there, kind)| {
                selected.extend(there.map(|k| (k, kind)));
                there.map(|_| selected.len() - 1)
            });
        record.select(&selected);
        let mut clock = self.clock.ticks(record, time)?;
        let (mut block, mut runs): (Block, Vec<(f64, u64, u64)>) = Default::default();
        while record.next(&mut block)? {
            let convert = |column: &mut Vec<f64>, by: Conversion| column.iter_mut().for_each(|v| *v = by.apply(*v));
            let converted = block.columns.iter_mut().zip(&conversions);
            converted.for_each(|(column, by)| by.iter().for_each(|by| convert(column, *by)));
            if let (Some(by), Some(column)) = (to_degrees, angle_at.and_then(|k| block.columns.get_mut(k))) {
                convert(column, by);
            }
            chosen.iter().zip(&block.columns).try_for_each(|((name, _), values)| record.squarable(name, values))?;
            let times = time_at.and_then(|k| block.columns.get(k)).map(Vec::as_slice);
            for stretch in clock.stretches(times, block.rows(), None, None)? {
                trace.interval = clock.step();
                if stretch.after_gap {
                    trace.interrupt();
                }
                let rows = |k: usize| {
                    let column = block.columns.at(k);
                    column.part(stretch.rows.clone())
                };
                let columns: Vec<&[f64]> = (0..chosen.len()).map(rows).collect();
                let turned = angle_at.map(|k| unwrap.turns(rows(k)));
                if let Some(labels) = label_at.map(rows) {
                    let sound = |row: usize| {
                        let all = columns.iter().copied().chain(turned.as_deref());
                        all.into_iter().all(|c| c.get(row).is_some_and(|v| v.is_finite()))
                    };
                    let taken = labels.iter().enumerate().filter(|(row, _)| sound(*row));
                    for (sample, (_, label)) in (trace.samples..).zip(taken) {
                        match runs.last_mut() {
                            _ if label.is_nan() => {}
                            Some((of, _, end)) if of == label && *end == sample => *end += 1,
                            _ => runs.push((*label, sample, sample + 1)),
                        }
                    }
                }
                let more: Vec<Vec<f64>> = computed.iter().map(|c| c.values(&columns)).collect();
                let all: Vec<&[f64]> =
                    columns.iter().copied().chain(more.iter().map(Vec::as_slice)).chain(turned.as_deref()).collect();
                trace.push(&all, clock.times().get(stretch.rows.clone()));
            }
        }
        trace.finish();
        trace.interval = clock.interval()?;
        if angle.is_some() {
            trace.angle = trace.channels.pop();
        }
        let labels = record.labels();
        trace.runs = runs
            .into_iter()
            .map(|(label, start, end)| Run {
                // a label column holds numbers of labels, and that of none is empty
                label: labels.get(number::count(label)).cloned().unwrap_or_default(),
                start,
                end,
            })
            .collect();
        Ok((trace, clock))
    }

    /// Names and columns that are reduced.
    fn chosen(
        &self,
        record: &Record,
        schedule: Option<&Schedule>,
        others: &[Option<usize>],
    ) -> Result<Vec<(String, usize)>> {
        if !self.columns.is_empty() {
            let find = |(name, title): &(String, String)| Ok((name.clone(), record.find(title)?));
            let mut chosen: Vec<(String, usize)> = self.columns.iter().map(find).collect::<Result<_>>()?;
            // where all of them have titles of their own, those that the bench reads under its names stay, as in a table of readings
            if let Some(schedule) = schedule.filter(|_| self.columns.iter().all(|(name, title)| name != title)) {
                let wanted = schedule.wanted();
                let is_free = |k: usize, column: &record::Column| {
                    let is_taken = |(name, at): &(String, usize)| *at == k || *name == column.name;
                    wanted.contains(&column.name) && !others.contains(&Some(k)) && !chosen.iter().any(is_taken)
                };
                let more = record.columns().iter().enumerate().filter(|(k, column)| is_free(*k, column));
                let more: Vec<(String, usize)> = more.map(|(k, column)| (column.name.clone(), k)).collect();
                chosen.extend(more);
            }
            return Ok(chosen);
        }
        let wanted = schedule.map(Schedule::wanted);
        let all = record.columns().iter().enumerate().filter(|(k, _)| !others.contains(&Some(*k)));
        let chosen: Vec<(String, usize)> = all
            .filter(|(k, column)| match &wanted {
                Some(names) => names.contains(&column.name),
                None => !record.is_text(*k),
            })
            .map(|(k, column)| (column.name.clone(), k))
            .collect();
        if !chosen.is_empty() {
            return Ok(chosen);
        }
        let error = match wanted {
            None => Malformed::new(Fault::Missing, "no column of the record holds numbers")
                .expected("columns of numbers, or one that is named (--columns NAME)"),
            Some(names) => Malformed::new(Fault::Missing, "no column of the record is one that the bench reads")
                .expected(format!(
                    "one of {}, or \"columns\" that say which is which (--columns NAME=TITLE)",
                    names.join(", ")
                )),
        };
        Err(error.found(record::listed(record.columns())).in_file(record.name()))
    }
}

impl Reduced {
    /// The readings of the segments.
    pub fn readings(&self) -> Vec<ReducedReading> {
        let trace = &self.trace;
        let each = self.reduction.segments.iter().zip(&self.reduction.means);
        each.map(|(segment, means)| {
            let (start, end) = segment.span();
            let values =
                trace.channels.iter().zip(means).map(|(c, m)| (c.name.clone(), m.value, m.uncertainty.u)).collect();
            let time_s: f64 = 0.5 * (trace.time(start) + trace.time(end));
            ReducedReading { position: segment.label.clone(), time_s: (time_s * 1e6).round() / 1e6, values }
        })
        .collect()
    }
}

/// An error about the number of segments, with the stretches that were not used.
fn located(error: Malformed, trace: &Trace, segmentation: &Segmentation) -> Malformed {
    let rejected: Vec<String> = segmentation
        .rejected
        .iter()
        .take(TOLD)
        .map(|r| {
            let (from, to) = (trace.time(r.samples.start), trace.time(r.samples.end));
            format!("{from:.2} s to {to:.2} s ({})", r.reason)
        })
        .collect();
    if rejected.is_empty() {
        return error;
    }
    let found = error.finding().unwrap_or_default().to_string();
    error.found(format!("{found}; not used: {}", rejected.join(", ")))
}

/// Why there is no segment.
fn nothing(segmentation: &Segmentation, by: &By, least: f64) -> Vec<String> {
    let mut lines = Vec::new();
    match (&segmentation.stillness, by) {
        (Some(judged), By::Still { threshold, .. }) => {
            let advice = match judged.would_find {
                Some(ratio) => format!(
                    "the stillest {least} s have {ratio:.3} times that variance: use a threshold of {:.3}",
                    1.01 * ratio
                ),
                None => format!("no threshold gives a segment of {least} s"),
            };
            lines.push(format!(
                "no static segment of {least} s with a variance below {threshold} times that of the sensor at rest; {advice}"
            ));
        }
        _ => lines.push("no segment is left".to_string()),
    }
    lines.extend(segmentation.rejected.iter().take(TOLD).map(|rejected| format!("not used: {}", rejected.reason)));
    lines
}

/// Rows that count in no channel, as one of them has no value there.
fn incomplete(trace: &Trace) -> Option<String> {
    let (rows, left_out) = (trace.rows, trace.rows - trace.samples.min(trace.rows));
    let mut each = Vec::new();
    for channel in &trace.channels {
        let events = channel.events.iter().filter(|event| event.kind == EventKind::Absent);
        let absent: u64 = events.map(|event| event.length).sum();
        if absent > 0 {
            each.push(format!("{}: {absent}", channel.name));
        }
    }
    // of one channel its own events say it
    (left_out > 0 && trace.channels.len() > 1).then(|| {
        format!(
            "{left_out} of {rows} rows have no value in one of the columns ({}) and are left out of all of them; --columns reduces columns by themselves",
            each.join(", ")
        )
    })
}
