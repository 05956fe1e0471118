//! `"readings": { "samples": "log.csv", "as": "rows", ... }`: every row of a record is a reading, and none of them is held.

use super::campaign_file::CampaignFile;
use super::columns::{Meaning, columns, meaning};
use super::readings_file::{Cell, ReadingFile};
use super::reduced::{Runs, assigned};
use super::samples_file::{SamplesFile, SegmentsBy};
use super::{Folder, Named, Source, locate};
use crate::bench::Bench;
use crate::campaign::{Campaign, JointState, Observation, Place, Reading, Readings, ScatterRequest};
use crate::design::indifferent_angles;
use crate::elements::{Elements, OrNan};
use crate::error::{Fault, Malformed, Result};
use crate::fit::Settings;
use crate::fit::streamed::{self, Rows, Sample};
use crate::number;
use crate::record::{As, Block, Clock, Counter, Record};
use crate::reduce::{EventKind, Odd, together};
use crate::units::Conversion;
use std::ops::Range;

/// A record whose rows are the readings of a campaign.
pub struct RecordRows<'a> {
    folder: &'a mut dyn Folder,
    path: String,
    bench: Bench,
    indifferent: Vec<Option<f64>>,
    /// Titles of all columns of the record.
    titles: Vec<String>,
    names: Vec<String>,
    read: Vec<Read>,
    patterns: Vec<Pattern>,
    segments: Segments,
    /// Column of labels among those that are read.
    label: Option<usize>,
    rate: Option<f64>,
    /// The counter that the column of times may be, and what is subtracted from it.
    counter: Counter,
    origin: Option<f64>,
    /// The first time, from which segments are counted.
    zero: Option<f64>,
    record: Option<Record>,
    /// The columns as the record gives them.
    raw: Block,
    taken: Taken,
    row: u64,
    used: u64,
    sensors: Vec<Watched>,
    /// Times of the first pass, as long as it lasts.
    times: Option<Order>,
}

/// A column of a sensor: watched in the first pass; what is odd in it is left out of the others.
#[derive(Debug)]
struct Watched {
    /// Its place among the columns that are read.
    place: usize,
    first: Option<Odd>,
    /// Samples that are left out, in their order: the numbers of those with a value.
    dead: Vec<Range<u64>>,
    /// Are samples held, so that only the first of each run is one?
    held: bool,
    /// Samples of this pass so far, and the last of them.
    samples: u64,
    last: f64,
}

/// How the times of rows follow each other.
#[derive(Debug, Default)]
struct Order {
    last: Option<f64>,
    back: u64,
    /// Before and after the first step back.
    first: Option<(f64, f64)>,
}

/// The rows of a block that are used.
#[derive(Debug, Clone, Default)]
struct Taken {
    /// Rows before the block.
    before: u64,
    /// Place of each in the block, and its pattern.
    rows: Vec<usize>,
    pattern: Vec<usize>,
    /// Angle, rate and turns of each joint, for those rows.
    joints: Vec<[Vec<f64>; 3]>,
    /// The label of the last row and its position, and the runs so far.
    run: Option<(u64, Option<usize>)>,
    runs: Runs,
}

/// The column of times, the seconds in its unit (`true` where the times themselves say it), and why it is that where its name does not.
type ColumnOfTimes = (usize, (f64, bool), Option<String>);

/// A column of the record that is read.
#[derive(Debug, Clone)]
struct Read {
    place: usize,
    meaning: Meaning,
    conversion: Option<Conversion>,
    /// Its place among the numeric columns of the readings.
    slot: Option<usize>,
    /// Seconds in its unit, where it is the clock; `true` where the times themselves say their unit.
    seconds: Option<(f64, bool)>,
}

/// What is the same in every row of a position.
#[derive(Debug, Clone, Default, PartialEq)]
struct Pattern {
    position: String,
    /// Numeric columns.
    numbers: Vec<(usize, f64)>,
    /// States of joints, values, their uncertainties and numbers of samples.
    stated: Vec<(Meaning, f64)>,
}

/// Which rows are used.
#[derive(Debug, Clone)]
enum Segments {
    All,
    Labels,
    /// Position, start and end, s.
    Times(Vec<(usize, f64, f64)>),
}

/// A campaign whose readings are the rows of a record, with a sample of them; and the record. With the settings of the fit that is to come, rows
/// are folded on the way where that fit waits for nothing.
///
/// Errors: those of a campaign; readings that are no samples as rows; keys that are of means; columns that the model needs and the record has not.
pub(crate) fn read_rows_of<'a>(
    file: &CampaignFile,
    source: &Source,
    folder: &'a mut dyn Folder,
    settings: Option<&Settings>,
) -> Result<(Campaign, RecordRows<'a>, Sample)> {
    let at = |error: Malformed| locate(error, source);
    let (bench, samples) = file.rows(folder).map_err(at)?;
    let mut rows = RecordRows::new(bench.clone(), file, samples, folder).map_err(at)?;
    let campaign = |readings: &Readings| file.clone().with(bench.clone(), readings.clone()).map_err(at);
    let look = |rows: &mut RecordRows<'_>| match settings {
        Some(settings) => streamed::sample_and_fold(rows, &campaign, settings),
        None => streamed::sample(rows),
    };
    let mut sample = look(&mut rows).map_err(at)?;
    if rows.leaves_out() {
        sample = look(&mut rows).map_err(at)?;
    }
    if sample.rows == 0 {
        return Err(at(Malformed::new(Fault::Missing, format!("no row of '{}' is used", samples.samples))
            .expected("rows in the segments that the campaign names")
            .found(format!("{} rows outside of them", rows.row))
            .at_path("readings")));
    }
    let unused = rows.row - rows.used;
    if unused > 0 {
        rows.folder.note(format!(
            "{}: {unused} of {} rows lie outside the segments and are not used",
            samples.samples, rows.row
        ));
    }
    let campaign = campaign(&sample.readings)?;
    campaign.refuse_unread(rows.titles.iter().map(String::as_str)).map_err(at)?;
    Ok((campaign, rows, sample))
}

impl<'a> RecordRows<'a> {
    fn new(bench: Bench, file: &CampaignFile, samples: &SamplesFile, folder: &'a mut dyn Folder) -> Result<Self> {
        let source = samples.segments_of_rows(folder).map_err(|e| e.under("readings"))?;
        let path = samples.samples.clone();
        let record = folder.record(&path).map_err(|e| e.at_path("readings.samples"))?;
        let map = if samples.columns.is_empty() { &file.columns } else { &samples.columns };
        let used_by_scatter = |key: &str| ScatterRequest::use_key(&file.scatter, key);
        let keys = columns(&bench, record.columns(), map, &used_by_scatter, record.name())?;
        let used: Vec<String> =
            bench.sensors.iter().flat_map(|sensor| sensor.model.names().into_iter().map(str::to_string)).collect();
        let mut rows = RecordRows {
            folder,
            path,
            names: Vec::new(),
            read: Vec::new(),
            patterns: Vec::new(),
            segments: Segments::All,
            label: None,
            titles: record.columns().iter().map(|column| column.title.clone()).collect(),
            rate: samples.rate_hz,
            counter: Counter::default(),
            origin: None,
            zero: None,
            record: None,
            raw: Block::default(),
            taken: Taken::default(),
            row: 0,
            used: 0,
            sensors: Vec::new(),
            times: Some(Order::default()),
            indifferent: indifferent_angles(&bench),
            bench,
        };
        // written times are those of a clock
        let mut numbers = keys.iter().enumerate().filter(|(place, _)| !record.is_text(*place));
        let has_time_s = numbers.any(|(_, (key, _))| key == "time_s");
        let is_read = |place: usize| {
            let key = keys.get(place).map_or("", |(key, _)| key.as_str());
            meaning(&rows.bench, key) != Meaning::Column || used.iter().any(|name| name == key)
        };
        let clock =
            rows.clock(&record, samples, has_time_s)?.filter(|(column, _, why)| why.is_none() || !is_read(*column));
        let said = clock.iter().filter_map(|(.., why)| why.clone());
        said.for_each(|why| rows.folder.note(format!("{}: {why}", rows.path)));
        let clock = clock.map(|(column, seconds, _)| (column, seconds));
        for (place, (key, conversion)) in keys.into_iter().enumerate() {
            let is_clock = clock.is_some_and(|(column, _)| column == place);
            let key = if is_clock { "time_s".to_string() } else { key };
            if !is_clock && key == "time_s" && clock.is_some() {
                continue;
            }
            let kind = meaning(&rows.bench, &key);
            let wanted = match kind {
                Meaning::Position => false,
                Meaning::Column => key == "time_s" || used_by_scatter(&key) || used.contains(&key),
                _ => true,
            };
            if !wanted {
                continue;
            }
            let slot = rows.slot(kind, &key);
            let seconds = clock.filter(|_| is_clock).map(|(_, seconds)| seconds);
            rows.read.push(Read { place, meaning: kind, conversion, slot, seconds });
        }
        if rows.rate.is_some() && clock.is_none() {
            rows.slot(Meaning::Column, "time_s");
        }
        if let SegmentsBy::Column(name) = &source {
            rows.label = Some(record.find(name)?);
        }
        rows.positions(&samples.positions, &source)?;
        rows.complete(&record)?;
        let read = rows.read.iter().enumerate();
        let of_sensors = read.filter(|(_, read)| matches!(read.meaning, Meaning::Sensor(_)));
        rows.sensors = of_sensors.map(|(place, _)| Watched::new(place)).collect();
        Ok(rows)
    }

    /// The column of times, the seconds in its unit, and why it is that where its name does not say it; `None` where numbers of a column `time_s` are taken as they are, or a rate is stated.
    fn clock(&self, record: &Record, samples: &SamplesFile, has_time_s: bool) -> Result<Option<ColumnOfTimes>> {
        let from = crate::record::ClockFrom { time: samples.time.clone(), rate: samples.rate_hz };
        if from.time.is_none() && (has_time_s || from.rate.is_some()) {
            return Ok(None);
        }
        let Some(column) = from.column(record)? else { return Ok(None) };
        let Some(titled) = record.columns().get(column) else { return Ok(None) };
        match Clock::column(titled, record.name()) {
            Ok(clock) => Ok(Some((column, (clock.seconds_per_unit(), clock.is_bare()), from.taken(record)))),
            // a column that is called so by chance
            Err(_) if from.time.is_none() => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// The place of an input among the numeric columns.
    fn slot(&mut self, kind: Meaning, key: &str) -> Option<usize> {
        if !kind.is_input() {
            return None;
        }
        let found = self.names.iter().position(|name| name == key);
        Some(found.unwrap_or_else(|| {
            self.names.push(key.to_string());
            self.names.len() - 1
        }))
    }

    /// What the positions of the campaign say of the rows.
    fn positions(&mut self, list: &[ReadingFile], source: &SegmentsBy) -> Result<()> {
        if list.len() > 1 && matches!(source, SegmentsBy::Still { .. }) {
            return Err(Malformed::new(
                Fault::Missing,
                "several positions, and nothing says which rows belong to which",
            )
            .expected("\"by\": a column of labels, or \"times\"; or one position for all rows")
            .found(format!("{} positions", list.len()))
            .at_path("readings.positions"));
        }
        let empty = Named::default();
        let all = if list.is_empty() { std::slice::from_ref(&empty) } else { list };
        for (k, row) in all.iter().enumerate() {
            let pattern = self.pattern(row, &format!("readings.positions[{k}]"))?;
            self.patterns.push(pattern);
        }
        let positions: Vec<String> = self.patterns.iter().map(|pattern| pattern.position.clone()).collect();
        let same = |a: usize, b: usize| self.patterns.get(a) == self.patterns.get(b);
        if let SegmentsBy::Column(_) = source {
            self.taken.runs = Runs::of(&positions, &same);
        }
        self.segments = match source {
            SegmentsBy::Still { .. } => Segments::All,
            SegmentsBy::Column(_) => Segments::Labels,
            SegmentsBy::Times { list: times, .. } => {
                let labels: Vec<String> = times.iter().map(|(label, ..)| label.clone()).collect();
                let places = assigned(&positions, &same, &labels).map_err(|error| error.at_path("readings.times"))?;
                let found = places.iter().zip(times).map(|(i, (_, start, end))| (*i, *start, *end)).collect();
                Segments::Times(found)
            }
        };
        Ok(())
    }

    fn pattern(&mut self, row: &ReadingFile, place: &str) -> Result<Pattern> {
        let mut pattern = Pattern::default();
        for (key, cell) in &row.0 {
            let kind = meaning(&self.bench, key);
            let number = match cell {
                Cell::Text(_) | Cell::Number(_) if kind == Meaning::Position => {
                    pattern.position = cell.written();
                    continue;
                }
                Cell::Number(x) if x.is_finite() => *x,
                Cell::Nothing(()) => continue,
                _ => {
                    return Err(Malformed::new(Fault::Value, format!("{key} is not a number"))
                        .expected("what is the same in every row of the position")
                        .at_path(format!("{place}.{key}")));
                }
            };
            if let Some(slot) = self.slot(kind, key) {
                pattern.numbers.push((slot, number));
            }
            pattern.stated.push((kind, number));
        }
        Ok(pattern)
    }

    /// Errors: a joint, or an input of a model line, that neither the record nor the positions have.
    fn complete(&self, record: &Record) -> Result<()> {
        let stated = self.patterns.first().into_iter().flat_map(|pattern| &pattern.stated).map(|(meaning, _)| meaning);
        let read = self.read.iter().map(|read| &read.meaning).chain(stated);
        let has = |wanted: &dyn Fn(&Meaning) -> bool| read.clone().any(wanted);
        let missing = |what: String, expected: String| {
            let found = format!("columns {}", crate::record::listed(record.columns()));
            Err(Malformed::new(Fault::Missing, what).expected(expected).found(found).in_file(record.name()))
        };
        for (k, joint) in self.bench.joints().enumerate() {
            if !has(&|meaning| matches!(meaning, Meaning::Angle(j) | Meaning::Rate(j) if *j == k)) {
                let expected = format!(
                    "a column {joint}_deg (its angle) or {joint}_deg_s (its rate), or the same in \"positions\": [{{ ... }}]"
                );
                return missing(format!("the joint '{joint}' has no state"), expected);
            }
        }
        let sensors: Vec<&str> = self.bench.sensors.iter().map(|sensor| sensor.id.as_str()).collect();
        if !has(&|meaning| matches!(meaning, Meaning::Sensor(_))) {
            let first = sensors.first().unwrap_or(&"");
            let expected = format!("a column {} (or \"columns\": {{ \"{first}\": its title }})", sensors.join(" or "));
            return missing("no column of the record is a sensor".into(), expected);
        }
        Ok(())
    }

    /// Which rows of the block are used, and what is the same in all rows of their positions. Errors: segments of times, and no times.
    fn take(&mut self, record: &Record, time: Option<&[f64]>) -> Result<()> {
        let Taken { rows, pattern, run, runs, .. } = &mut self.taken;
        let count = self.raw.rows();
        rows.clear();
        pattern.clear();
        let mut take = |k: usize, i: Option<usize>| {
            if let Some(i) = i {
                rows.push(k);
                pattern.push(i);
            }
        };
        let is_one = self.patterns.len() == 1 && self.patterns.iter().all(|p| p.position.is_empty());
        match &self.segments {
            Segments::Labels if !is_one => {
                let labels = self.raw.columns.get(self.read.len()).map_or(&[][..], Vec::as_slice);
                for (k, label) in labels.iter().enumerate() {
                    if run.is_none_or(|(last, _)| last != label.to_bits()) {
                        let name = if label.is_nan() { None } else { record.labels().get(number::count(*label)) };
                        let name = name.map_or("", String::as_str);
                        // rows whose label is no position are left out
                        *run = Some((label.to_bits(), runs.next(name)));
                    }
                    take(k, run.and_then(|(_, found)| found));
                }
            }
            Segments::Times(list) => {
                let time = time.ok_or_else(|| {
                    Malformed::new(Fault::Missing, "segments are given by their times, and the record has none")
                        .expected("a column of times (\"time\": its title), or \"rate_hz\"")
                        .in_file(record.name())
                })?;
                let first = time.iter().copied().find(|t| !t.is_nan());
                let zero = self.zero.or(first).unwrap_or(f64::NAN); // no time at all so far
                self.zero = self.zero.or(first);
                for (k, t) in time.iter().map(|t| t - zero).enumerate() {
                    take(k, list.iter().find(|(_, start, end)| t >= *start && t <= *end).map(|(i, ..)| *i));
                }
            }
            Segments::All | Segments::Labels => {
                rows.extend(0..count);
                pattern.resize(count, 0);
            }
        }
        Ok(())
    }

    /// After the first pass: is something left out of those that follow? It is said, and so are times that go back.
    fn leaves_out(&mut self) -> bool {
        let Order { back, first, .. } = self.times.take().unwrap_or_default();
        if let Some((before, after)) = first.filter(|_| back * RARE <= self.row) {
            let times = if back == 1 { "once" } else { "several times" };
            self.folder.note(format!(
                "{}: the times go back {times} (first from {before} s to {after} s); rows are taken at the times that they have",
                self.path
            ));
        }
        let mut any = false;
        for own in &mut self.sensors {
            let Some(odd) = own.first.take() else { continue };
            own.held = odd.is_held();
            let events = odd.events();
            let dead = |kind: EventKind| {
                let of = events.iter().filter(move |event| event.kind == kind);
                let ranges: Vec<Range<u64>> = of.map(|event| event.sample..event.sample + event.length).collect();
                match kind {
                    EventKind::Saturation => cut(&ranges),
                    _ => ranges,
                }
            };
            let title =
                self.read.get(own.place).and_then(|read| self.titles.get(read.place)).map_or("", String::as_str);
            for (kind, what) in [(EventKind::Saturation, "saturated"), (EventKind::Stuck, "stuck at one value")] {
                let count: u64 = dead(kind).iter().map(|range| range.end - range.start).sum();
                if count > 0 {
                    self.folder.note(format!(
                        "{}: {count} of {} samples of '{title}' are left out: {what}",
                        self.path, own.samples
                    ));
                }
            }
            if own.held {
                self.folder.note(format!(
                    "{}: '{title}' keeps each value for several rows: rows that repeat it are left out, a sample counts once",
                    self.path
                ));
            }
            own.dead = dead(EventKind::Saturation);
            own.dead.extend(dead(EventKind::Stuck));
            own.dead.sort_by_key(|range| range.start);
            own.dead = together(&own.dead, 0).collect();
            any |= own.held || !own.dead.is_empty();
        }
        any
    }

    /// Times of all rows of the block, where it has any.
    fn row_times(&mut self) -> Option<Vec<f64>> {
        let slot = self.names.iter().position(|name| name == "time_s")?;
        let mut time =
            self.rate.map(|rate| (0..self.raw.rows()).map(|k| (self.row + k as u64) as f64 / rate).collect());
        for (read, raw) in self.read.iter().zip(&self.raw.columns).filter(|(read, _)| read.slot == Some(slot)) {
            if read.seconds.is_some() && self.origin.is_none() {
                self.origin = raw.iter().copied().find(|x| !x.is_nan());
            }
            let origin = self.origin.unwrap_or(f64::NAN); // no time at all so far
            let converted = raw.iter().map(|x| match read.seconds {
                Some((seconds, _)) => (x - origin) * seconds,
                None => read.converted(*x),
            });
            over(time.get_or_insert_default(), converted);
        }
        time
    }

    /// The rows that are used, column by column, in the units of the readings. Errors: uncertainties and numbers of samples that are not positive.
    fn columns_of(&mut self, file: &str, time: Option<&[f64]>, block: &mut streamed::Block) -> Result<()> {
        let Taken { before, rows, pattern, joints, .. } = &mut self.taken;
        let count = rows.len();
        block.clear(self.names.len(), self.bench.sensors.len());
        block.rows = count;
        joints.resize_with(self.bench.joints().count(), Default::default);
        joints.iter_mut().flatten().for_each(Vec::clear);
        let mut samples = Vec::new();
        let time_slot = self.names.iter().position(|name| name == "time_s");
        if let Some((to, time)) = time_slot.and_then(|slot| block.columns.get_mut(slot)).zip(time) {
            to.extend(rows.iter().map(|k| time.at(*k)));
        }
        for (read, raw) in self.read.iter().zip(&self.raw.columns) {
            if read.slot.is_some() && read.slot == time_slot {
                continue;
            }
            let converted = || rows.iter().map(|k| read.converted(raw.at(*k)));
            let column = read.slot.and_then(|slot| block.columns.get_mut(slot));
            let target = read.meaning.list(&mut block.sensors, joints, &mut samples);
            column.into_iter().chain(target).for_each(|to| over(to, converted()));
        }
        for (p, stated_once) in self.patterns.iter().enumerate() {
            let fill = |to: &mut Vec<f64>, number: f64| {
                if to.is_empty() {
                    to.resize(count, f64::NAN);
                }
                let of = to.iter_mut().zip(pattern.iter()).filter(|(to, of)| **of == p && to.is_nan());
                of.for_each(|(to, _)| *to = number);
            };
            for (slot, number) in &stated_once.numbers {
                block.columns.get_mut(*slot).into_iter().for_each(|to| fill(to, *number));
            }
            for (meaning, number) in &stated_once.stated {
                meaning.list(&mut block.sensors, joints, &mut samples).into_iter().for_each(|to| fill(to, *number));
            }
        }
        // one sample where nothing says how many
        samples.iter_mut().filter(|n| n.is_nan()).for_each(|n| *n = 1.0);
        for sensor in &mut block.sensors {
            sensor.samples.clone_from(&samples);
            let read = |k: usize| !sensor.values.or_nan(k).is_nan();
            let bad = |list: &[f64]| list.iter().enumerate().find(|(k, x)| **x <= 0.0 && read(*k)).map(|(k, _)| k);
            if let Some(k) = bad(&sensor.u).or_else(|| bad(&samples)) {
                return Err(Malformed::new(
                    Fault::Value,
                    "a standard uncertainty or a number of samples is not positive",
                )
                .expected("positive numbers (leave them out where they are not known)")
                .at_path(&Place::Row {
                    is_text: false,
                    number: *before + rows.at(k) as u64 + 1,
                    file: file.into(),
                }));
            }
        }
        Ok(())
    }
}

/// Samples between two that are saturated are left out with them, as long as these are no rarer: of one in a thousand the mean of the others is off by 0.003 of the standard deviation.
const CUT: u64 = 1000;

/// What is left out where noise is cut at a rail, since what is left of it lies on one side: all between samples at the rail, and before and after them ten times the mean distance: of noise at that level so many samples off the rail follow each other with the probability e^-10.
fn cut(at_rail: &[Range<u64>]) -> Vec<Range<u64>> {
    let spans = together(at_rail, CUT).map(|span| {
        let inside = at_rail.iter().filter(|own| span.start <= own.start && own.end <= span.end);
        let (runs, samples) = inside.fold((0, 0), |(n, sum), own| (n + 1, sum + own.end - own.start));
        let before = if runs > 1 { 10 * (span.end - span.start - samples) / (runs - 1) } else { 0 };
        span.start.saturating_sub(before)..span.end + before
    });
    together(&spans.collect::<Vec<_>>(), 0).collect()
}

/// Steps back in more than one of so many rows: rows that are in no order of time.
const RARE: u64 = 100;

impl Order {
    fn see(&mut self, times: &[f64]) {
        for time in times.iter().copied().filter(|time| !time.is_nan()) {
            if let Some(last) = self.last.filter(|last| time < *last) {
                self.back += 1;
                self.first.get_or_insert((last, time));
            }
            self.last = Some(time);
        }
    }
}

impl Watched {
    fn new(place: usize) -> Self {
        Watched { place, first: Some(Odd::default()), dead: Vec::new(), held: false, samples: 0, last: f64::NAN }
    }

    /// Samples of a block: watched, or without those that are left out.
    fn see(&mut self, values: &mut [f64]) {
        if let Some(odd) = &mut self.first {
            odd.see_runs(values);
            self.samples += values.iter().filter(|value| value.is_finite()).count() as u64;
            return;
        }
        if self.dead.is_empty() && !self.held {
            return;
        }
        let mut next = self.dead.partition_point(|range| range.end <= self.samples);
        for value in values.iter_mut().filter(|value| value.is_finite()) {
            while self.dead.get(next).is_some_and(|range| range.end <= self.samples) {
                next += 1;
            }
            let is_dead = self.dead.get(next).is_some_and(|range| range.contains(&self.samples));
            let repeats = self.held && *value == self.last;
            (self.last, self.samples) = (*value, self.samples + 1);
            if is_dead || repeats {
                *value = f64::NAN;
            }
        }
    }
}

impl Read {
    /// A number of the column in the unit of the readings.
    fn converted(&self, x: f64) -> f64 {
        self.conversion.map_or(x, |conversion| conversion.apply(x))
    }
}

/// Numbers over those of a list; what is absent leaves what is there.
fn over(to: &mut Vec<f64>, from: impl Iterator<Item = f64>) {
    if to.is_empty() {
        to.extend(from);
    } else {
        to.iter_mut().zip(from).filter(|(_, x)| !x.is_nan()).for_each(|(to, x)| *to = x);
    }
}

impl Meaning {
    /// The list of a block that a key's numbers stand in; `None` for a position or a column that is nothing else.
    fn list<'b>(
        self,
        sensors: &'b mut [streamed::Observed],
        joints: &'b mut [[Vec<f64>; 3]],
        samples: &'b mut Vec<f64>,
    ) -> Option<&'b mut Vec<f64>> {
        match self {
            Meaning::Angle(k) => joints.get_mut(k).map(|state| &mut state[0]),
            Meaning::Rate(k) => joints.get_mut(k).map(|state| &mut state[1]),
            Meaning::Turns(k) => joints.get_mut(k).map(|state| &mut state[2]),
            Meaning::Sensor(k) => sensors.get_mut(k).map(|sensor| &mut sensor.values),
            Meaning::SensorU(k) => sensors.get_mut(k).map(|sensor| &mut sensor.u),
            Meaning::Samples => Some(samples),
            Meaning::Position | Meaning::Column => None,
        }
    }
}

impl Rows for RecordRows<'_> {
    fn columns(&self) -> &[String] {
        &self.names
    }

    fn rewind(&mut self) -> Result<()> {
        let mut record = self.folder.record(&self.path).map_err(|e| e.at_path("readings.samples"))?;
        let kind = |read: &Read| if read.seconds.is_some() { As::Time } else { As::Number };
        let mut selected: Vec<(usize, As)> = self.read.iter().map(|read| (read.place, kind(read))).collect();
        selected.extend(self.label.map(|column| (column, As::Label)));
        record.select(&selected);
        (self.record, self.row, self.used, self.origin, self.zero) = (Some(record), 0, 0, None, None);
        self.counter = Counter::default();
        self.taken.run = None;
        self.taken.runs.restart();
        self.sensors.iter_mut().for_each(|own| (own.samples, own.last) = (0, f64::NAN));
        Ok(())
    }

    fn next(&mut self, block: &mut streamed::Block) -> Result<bool> {
        loop {
            let Some(mut record) = self.record.take() else { return Ok(false) };
            if !record.next(&mut self.raw)? {
                self.taken.runs.ended("runs of rows").map_err(|error| error.in_file(record.name()))?;
                return Ok(false);
            }
            let clock = self.read.iter_mut().zip(&mut self.raw.columns);
            for (read, times) in clock.filter(|(read, _)| read.seconds.is_some()) {
                self.counter.onward(times);
                let title = self.titles.get(read.place).map_or("", String::as_str);
                if let Some((seconds, bare @ true)) = &mut read.seconds
                    && let Some(unit) = crate::record::unit_of(title, times)
                {
                    (*seconds, *bare) = (unit.seconds, false);
                    unit.said(title, record.name(), unit.step)?.into_iter().for_each(|note| self.folder.note(note));
                }
            }
            for own in &mut self.sensors {
                self.raw.columns.get_mut(own.place).into_iter().for_each(|values| own.see(values));
            }
            self.taken.before = self.row;
            let time = self.row_times();
            if let (Some(order), Some(time)) = (&mut self.times, &time) {
                order.see(time);
            }
            self.take(&record, time.as_deref())?;
            self.columns_of(record.name(), time.as_deref(), block)?;
            self.row += self.raw.rows() as u64;
            self.used += block.rows as u64;
            self.record = Some(record);
            if block.rows > 0 {
                return Ok(true);
            }
        }
    }

    fn reading(&self, block: &streamed::Block, k: usize, into: &mut Reading) -> Result<()> {
        let number = |list: &Vec<f64>| list.get(k).copied().filter(|x| !x.is_nan());
        let pattern = self.taken.pattern.get(k).and_then(|i| self.patterns.get(*i));
        let labels = self.label.and_then(|_| self.raw.columns.get(self.read.len()));
        let label =
            labels.zip(self.taken.rows.get(k)).and_then(|(labels, row)| labels.get(*row)).filter(|x| !x.is_nan());
        let texts = self.record.as_ref().map_or(&[][..], Record::labels);
        let label = label.and_then(|x| texts.get(number::count(*x))).filter(|text| !text.is_empty());
        let label = label.or(pattern.map(|pattern| &pattern.position)).map_or("", String::as_str);
        if *into.position != *label {
            into.position = label.into();
        }
        into.columns.refill(block.columns.len(), block.columns.iter().map(|column| Ok(number(column))))?;
        let joints = self.bench.joints().zip(&self.indifferent).zip(&self.taken.joints);
        let joints = joints.map(|((joint, indifferent), [angle, rate, turns])| {
            let deg = number(angle).or(indifferent.filter(|_| number(rate) == Some(0.0)));
            let state = JointState::from_keys(joint, deg, number(rate), number(turns));
            state.map_err(|error| error.under(&self.place(k).to_string()))
        });
        into.joints.refill(self.taken.joints.len(), joints)?;
        into.samples = block.sensors.first().and_then(|values| number(&values.samples)).unwrap_or(1.0);
        let (samples, sensors) = (into.samples, block.sensors.iter().enumerate());
        let observation = |(sensor, values): (usize, &streamed::Observed)| {
            number(&values.values).map(|value| Ok(Observation { sensor, value, u: number(&values.u), samples }))
        };
        into.observations.refill(sensors.clone().filter_map(observation).count(), sensors.filter_map(observation))
    }

    fn place(&self, k: usize) -> Place {
        let row = self.taken.rows.get(k).copied().unwrap_or_default(); // a row of the block
        let file = self.record.as_ref().map_or("", Record::name);
        Place::Row { is_text: false, number: self.taken.before + row as u64 + 1, file: file.into() }
    }
}
