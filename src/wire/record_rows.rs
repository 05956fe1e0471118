//! `"readings": { "samples": "log.csv", "as": "rows", ... }`: every row of a record is a reading, and none of them is held.

use super::campaign_file::CampaignFile;
use super::columns::columns;
use super::locate::table_place;
use super::readings_file::{Cell, Meaning, ReadingFile, meaning};
use super::samples_file::{SamplesFile, SegmentSource};
use super::{Folder, Named, ScatterFile, Source, locate};
use crate::bench::Bench;
use crate::campaign::{Campaign, JointState, Observation, Reading};
use crate::error::{Fault, Malformed, Result};
use crate::fit::streamed::{self, Rows, Sample};
use crate::number;
use crate::record::{As, Block, Clock, Record};
use crate::units::Conversion;

/// A record that a campaign takes row by row.
pub struct RecordRows<'a> {
    folder: &'a mut dyn Folder,
    path: String,
    bench: Bench,
    /// Titles of all columns of the record.
    titles: Vec<String>,
    names: Vec<String>,
    read: Vec<Read>,
    patterns: Vec<Pattern>,
    segments: Segments,
    /// Column of labels among those that are read.
    label: Option<usize>,
    rate: Option<f64>,
    /// What is subtracted from the column of times.
    origin: Option<f64>,
    record: Option<Record>,
    block: Block,
    values: Vec<(Option<f64>, Option<f64>)>,
    row: u64,
    used: u64,
}

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
#[derive(Debug, Clone, Default)]
struct Pattern {
    position: String,
    numbers: Vec<(usize, f64)>,
    states: Vec<[Option<f64>; 3]>,
    values: Vec<(Option<f64>, Option<f64>)>,
    samples: Option<f64>,
}

/// Which rows are used.
#[derive(Debug, Clone)]
enum Segments {
    All,
    Labels,
    /// Position, start and end, s.
    Times(Vec<(usize, f64, f64)>),
}

/// A campaign whose readings are the rows of a record, with a sample of them; and the record.
///
/// Errors: those of a campaign; readings that are no samples as rows; keys that are of means; columns that the model needs and the record has not.
pub fn read_rows_of<'a>(
    file: &CampaignFile,
    source: &Source,
    folder: &'a mut dyn Folder,
) -> Result<(Campaign, RecordRows<'a>, Sample)> {
    let at = |error: Malformed| if error.place().file.is_empty() { locate(error, source) } else { error };
    let (bench, samples) = file.rows(folder).map_err(at)?;
    let mut rows = RecordRows::new(bench.clone(), file, samples, folder).map_err(at)?;
    let sample = streamed::sample(&mut rows)?;
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
    let campaign = file.clone().with(bench, sample.readings.clone()).map_err(at)?;
    campaign.refuse_unread(rows.titles.iter().map(String::as_str)).map_err(at)?;
    Ok((campaign, rows, sample))
}

impl<'a> RecordRows<'a> {
    fn new(bench: Bench, file: &CampaignFile, samples: &SamplesFile, folder: &'a mut dyn Folder) -> Result<Self> {
        let source = samples.segments_of_rows(folder).map_err(|e| e.under("readings"))?;
        let path = samples.samples.clone();
        let record = folder.record(&path).map_err(|e| e.at_path("readings.samples"))?;
        let map = if samples.columns.is_empty() { &file.columns } else { &samples.columns };
        let used_by_scatter = |key: &str| ScatterFile::use_key(&file.scatter, key);
        let keys = columns(&bench, record.columns(), map, &used_by_scatter, record.name())?;
        let used: Vec<String> =
            bench.sensors.iter().flat_map(|own| own.model.names().into_iter().map(str::to_string)).collect();
        let mut rows = RecordRows {
            folder,
            path,
            names: Vec::new(),
            read: Vec::new(),
            patterns: Vec::new(),
            segments: Segments::All,
            label: None,
            titles: record.columns().iter().map(|own| own.title.clone()).collect(),
            rate: samples.rate_hz,
            origin: None,
            record: None,
            block: Block::default(),
            values: Vec::new(),
            row: 0,
            used: 0,
            bench,
        };
        let clock = rows.clock(&record, samples, keys.iter().any(|own| own.key == "time_s"))?;
        for (place, own) in keys.into_iter().enumerate() {
            let is_clock = clock.is_some_and(|(column, _)| column == place);
            let key = if is_clock { "time_s".to_string() } else { own.key };
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
            rows.read.push(Read { place, meaning: kind, conversion: own.conversion, slot, seconds });
        }
        if rows.rate.is_some() && clock.is_none() {
            rows.slot(Meaning::Column, "time_s");
        }
        if let SegmentSource::Column(name) = &source {
            rows.label = Some(record.find(name)?);
        }
        rows.positions(&samples.positions, &source)?;
        rows.complete(&record)?;
        Ok(rows)
    }

    /// The column of times and the seconds in its unit; `None` where a column `time_s` is taken as it is, or a rate is stated.
    fn clock(&self, record: &Record, samples: &SamplesFile, has_time_s: bool) -> Result<Option<(usize, (f64, bool))>> {
        let from = crate::record::ClockFrom { time: samples.time.clone(), rate: samples.rate_hz };
        if from.time.is_none() && (has_time_s || from.rate.is_some()) {
            return Ok(None);
        }
        let Some(column) = from.column(record)? else { return Ok(None) };
        let Some(own) = record.columns().get(column) else { return Ok(None) };
        match Clock::column(own, record.name()) {
            Ok(clock) => Ok(Some((column, (clock.seconds_per_unit(), clock.is_bare())))),
            // a column that is called so by chance
            Err(_) if from.time.is_none() => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// The place of an input among the numeric columns.
    fn slot(&mut self, kind: Meaning, key: &str) -> Option<usize> {
        if !matches!(kind, Meaning::Column | Meaning::Angle(_) | Meaning::Rate(_) | Meaning::Turns(_)) {
            return None;
        }
        let found = self.names.iter().position(|name| name == key);
        Some(found.unwrap_or_else(|| {
            self.names.push(key.to_string());
            self.names.len() - 1
        }))
    }

    /// What the positions of the campaign say of the rows.
    fn positions(&mut self, list: &[ReadingFile], source: &SegmentSource) -> Result<()> {
        if list.len() > 1 && matches!(source, SegmentSource::All) {
            return Err(Malformed::new(
                Fault::Missing,
                "several positions, and nothing says which rows belong to which",
            )
            .expected("\"by\": a column of labels, or \"times\"; or one position that stands for all rows")
            .found(format!("{} positions", list.len()))
            .at_path("readings.positions"));
        }
        let empty = Named(Vec::new());
        let all = if list.is_empty() { std::slice::from_ref(&empty) } else { list };
        for (k, row) in all.iter().enumerate() {
            let pattern = self.pattern(row, &format!("readings.positions[{k}]"))?;
            self.patterns.push(pattern);
        }
        self.segments = match source {
            SegmentSource::All => Segments::All,
            SegmentSource::Column(_) => Segments::Labels,
            SegmentSource::Times(times) => {
                let by_label = |label: &str| self.patterns.iter().position(|own| own.position == label);
                let in_order = times.len() == self.patterns.len();
                let mut found = Vec::with_capacity(times.len());
                for (k, (label, start, end)) in times.iter().enumerate() {
                    let pattern = match by_label(label).filter(|_| !label.is_empty()) {
                        _ if self.patterns.len() == 1 => 0,
                        Some(own) => own,
                        None if in_order => k,
                        None => {
                            return Err(Malformed::new(Fault::Value, "a segment belongs to none of the positions")
                                .expected(
                                    "one position, as many as segments, or segments labelled as the positions are",
                                )
                                .found(format!("segment {} '{label}', {} positions", k + 1, self.patterns.len()))
                                .at_path("readings.times"));
                        }
                    };
                    found.push((pattern, *start, *end));
                }
                Segments::Times(found)
            }
        };
        Ok(())
    }

    fn pattern(&mut self, row: &ReadingFile, place: &str) -> Result<Pattern> {
        let mut own = Pattern {
            states: vec![[None; 3]; self.bench.joints().count()],
            values: vec![(None, None); self.bench.sensors.len()],
            ..Pattern::default()
        };
        for (key, cell) in &row.0 {
            let kind = meaning(&self.bench, key);
            let number = match cell {
                Cell::Text(text) if matches!(kind, Meaning::Position) => {
                    own.position.clone_from(text);
                    continue;
                }
                Cell::Number(x) if matches!(kind, Meaning::Position) => {
                    own.position = x.to_string();
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
                own.numbers.push((slot, number));
            }
            set(&mut own.states, &mut own.values, &mut own.samples, kind, number);
        }
        Ok(own)
    }

    /// Errors: a joint, or an input of a model line, that neither the record nor the positions have.
    fn complete(&self, record: &Record) -> Result<()> {
        let first = self.patterns.first();
        let has = |wanted: &dyn Fn(&Meaning) -> bool| self.read.iter().any(|own| wanted(&own.meaning));
        for (k, joint) in self.bench.joints().enumerate() {
            let stated =
                first.and_then(|own| own.states.get(k)).is_some_and(|own| own[0].is_some() || own[1].is_some());
            let read = has(&|own| matches!(own, Meaning::Angle(j) | Meaning::Rate(j) if *j == k));
            if !stated && !read {
                return Err(Malformed::new(Fault::Missing, format!("the joint '{joint}' has no state"))
                    .expected(format!(
                        "a column {joint}_deg (its angle) or {joint}_deg_s (its rate), or the same in \"positions\": [{{ ... }}]"
                    ))
                    .found(format!("columns {}", crate::record::listed(record.columns())))
                    .in_file(record.name()));
            }
        }
        let sensors: Vec<&str> = self.bench.sensors.iter().map(|own| own.id.as_str()).collect();
        let stated = first.is_some_and(|own| own.values.iter().any(|(value, _)| value.is_some()));
        if !stated && !has(&|own| matches!(own, Meaning::Sensor(_))) {
            return Err(Malformed::new(Fault::Missing, "no column of the record is a sensor")
                .expected(format!(
                    "a column {} (or \"columns\": {{ \"{}\": its title }})",
                    sensors.join(" or "),
                    sensors.first().unwrap_or(&"")
                ))
                .found(format!("columns {}", crate::record::listed(record.columns())))
                .in_file(record.name()));
        }
        Ok(())
    }

    /// Row `k` of the block as a reading; `false` where it is not used.
    fn fill(&mut self, k: usize, number: u64, file: &str, labels: &[String], into: &mut Reading) -> Result<bool> {
        // a row of the block: `k` is below its count
        let cell =
            |column: usize| self.block.columns.get(column).and_then(|own| own.get(k)).copied().unwrap_or(f64::NAN);
        let time_slot = self.names.iter().position(|name| name == "time_s");
        into.columns.clear();
        into.columns.resize(self.names.len(), None);
        let mut states = [[None; 3]; MOST_JOINTS];
        let mut values = std::mem::take(&mut self.values);
        values.clear();
        values.resize(self.bench.sensors.len(), (None, None));
        let mut samples = None;
        let mut time = None;
        if let (Some(rate), Some(slot)) = (self.rate, time_slot) {
            let own = (number - 1) as f64 / rate;
            time = Some(own);
            into.columns.get_mut(slot).into_iter().for_each(|to| *to = Some(own));
        }
        for (place, own) in self.read.iter().enumerate() {
            let raw = cell(place);
            if raw.is_nan() {
                continue;
            }
            let value = match own.seconds {
                Some((seconds, _)) => (raw - *self.origin.get_or_insert(raw)) * seconds,
                None => own.conversion.map_or(raw, |conversion| conversion.apply(raw)),
            };
            if own.slot.is_some() && own.slot == time_slot {
                time = Some(value);
            }
            if let Some(to) = own.slot.and_then(|slot| into.columns.get_mut(slot)) {
                *to = Some(value);
            }
            set(&mut states, &mut values, &mut samples, own.meaning, value);
        }
        let label = self.label.map(|_| cell(self.read.len())).filter(|x| !x.is_nan());
        let label = label.and_then(|x| labels.get(number::count(x))).map_or("", String::as_str);
        let pattern = match &self.segments {
            Segments::All => Some(0),
            Segments::Labels if self.patterns.len() == 1 && self.patterns.iter().all(|own| own.position.is_empty()) => {
                Some(0)
            }
            Segments::Labels => self.patterns.iter().position(|own| own.position == label),
            Segments::Times(list) => match time {
                Some(t) => list.iter().find(|(_, start, end)| t >= *start && t <= *end).map(|(own, ..)| *own),
                None => {
                    return Err(Malformed::new(
                        Fault::Missing,
                        "segments are given by their times, and the record has none",
                    )
                    .expected("a column of times (\"time\": its title), or \"rate_hz\"")
                    .in_file(file));
                }
            },
        };
        let Some(pattern) = pattern.and_then(|own| self.patterns.get(own)) else { return Ok(false) };
        for (slot, number) in &pattern.numbers {
            if let Some(to @ None) = into.columns.get_mut(*slot) {
                *to = Some(*number);
            }
        }
        into.position.clear();
        into.position.push_str(if label.is_empty() { &pattern.position } else { label });
        into.place = table_place(number::index(number), file);
        into.joints.clear();
        for (joint, (own, stated)) in self.bench.joints().zip(states.iter().zip(&pattern.states)) {
            let of = |k: usize| own.get(k).copied().flatten().or_else(|| stated.get(k).copied().flatten());
            let state = JointState::from_keys(joint, of(0), of(1), of(2)).map_err(|error| error.under(&into.place))?;
            into.joints.push(state);
        }
        into.samples = samples.or(pattern.samples).unwrap_or(1.0);
        into.observations.clear();
        for (sensor, ((value, u), (stated, stated_u))) in values.iter().zip(&pattern.values).enumerate() {
            let Some(value) = value.or(*stated) else { continue };
            let u = u.or(*stated_u);
            if u.is_some_and(|u| !(u > 0.0)) || !(into.samples > 0.0) {
                return Err(Malformed::new(
                    Fault::Value,
                    "a standard uncertainty or a number of samples is not positive",
                )
                .expected("positive numbers (leave them out where they are not known)")
                .at_path(into.place.clone()));
            }
            into.observations.push(Observation { sensor, value, u, samples: into.samples });
        }
        self.values = values;
        Ok(true)
    }
}

/// Joints of a bench that rows are read for.
const MOST_JOINTS: usize = 16;

fn set(
    states: &mut [[Option<f64>; 3]],
    values: &mut [(Option<f64>, Option<f64>)],
    samples: &mut Option<f64>,
    kind: Meaning,
    number: f64,
) {
    match kind {
        Meaning::Angle(k) => states.get_mut(k).into_iter().for_each(|own| own[0] = Some(number)),
        Meaning::Rate(k) => states.get_mut(k).into_iter().for_each(|own| own[1] = Some(number)),
        Meaning::Turns(k) => states.get_mut(k).into_iter().for_each(|own| own[2] = Some(number)),
        Meaning::Sensor(k) => values.get_mut(k).into_iter().for_each(|own| own.0 = Some(number)),
        Meaning::SensorU(k) => values.get_mut(k).into_iter().for_each(|own| own.1 = Some(number)),
        Meaning::Samples => *samples = Some(number),
        Meaning::Position | Meaning::Column => {}
    }
}

impl Rows for RecordRows<'_> {
    fn columns(&self) -> &[String] {
        &self.names
    }

    fn rewind(&mut self) -> Result<()> {
        let mut record = self.folder.record(&self.path).map_err(|e| e.at_path("readings.samples"))?;
        let kind = |own: &Read| if own.seconds.is_some() { As::Time } else { As::Number };
        let mut selected: Vec<(usize, As)> = self.read.iter().map(|own| (own.place, kind(own))).collect();
        selected.extend(self.label.map(|column| (column, As::Label)));
        record.select(&selected);
        (self.record, self.row, self.used, self.origin) = (Some(record), 0, 0, None);
        Ok(())
    }

    fn next(&mut self, readings: &mut Vec<Reading>) -> Result<bool> {
        loop {
            let Some(mut record) = self.record.take() else { return Ok(false) };
            let mut block = std::mem::take(&mut self.block);
            let more = record.next(&mut block);
            self.block = block;
            if !more? {
                readings.clear();
                return Ok(false);
            }
            for (own, times) in self.read.iter_mut().zip(&self.block.columns) {
                if let Some((seconds, bare @ true)) = &mut own.seconds
                    && let Some((_, found)) = crate::record::unit_of(times)
                {
                    (*seconds, *bare) = (found, false);
                }
            }
            let count = self.block.rows();
            let mut used = 0;
            for k in 0..count {
                self.row += 1;
                if readings.len() <= used {
                    readings.push(empty());
                }
                let Some(into) = readings.get_mut(used) else { break };
                if self.fill(k, self.row, record.name(), record.labels(), into)? {
                    used += 1;
                }
            }
            readings.truncate(used);
            self.used += used as u64;
            self.record = Some(record);
            if used > 0 {
                return Ok(true);
            }
        }
    }
}

fn empty() -> Reading {
    Reading {
        position: String::new(),
        joints: Vec::new(),
        columns: Vec::new(),
        observations: Vec::new(),
        samples: 1.0,
        planned_u: Vec::new(),
        remarks: Vec::new(),
        place: String::new(),
    }
}

impl std::fmt::Debug for RecordRows<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RecordRows").field("path", &self.path).field("columns", &self.names).finish_non_exhaustive()
    }
}
