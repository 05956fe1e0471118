//! Rows of samples: their columns and their clock, until they go into what is held.

use crate::campaign::{Campaign, JointState, Reading};
use crate::elements::Parts;
use crate::error::{Fault, Malformed, Result};
use crate::guide::Guide;
use crate::record::{As, Block, Clock, ClockFrom, JumpKind, Record};
use crate::reduce::{Ahead, Hold, Mean, Standing, Unwrap};
use crate::units::Conversion;
use crate::wire::{self, Cell, Named, ReadingFile};

/// Rows from which the step of the times is learnt: the clock takes their median step, which seven gaps among fifteen steps leave as it is.
const LEARNT: usize = 16;

/// A table of samples that grows.
pub(super) struct Table {
    rows: Record,
    block: Block,
    line: Vec<u8>,
    clock: Clock,
    fresh: Clock,
    /// Jumps of the clock that were seen, and the window in s that finds standstills.
    jumps: usize,
    window_s: f64,
    /// Keys of the channels: sensors, columns of the campaign, joints.
    keys: Vec<String>,
    /// The sensors of the first of them, by index.
    pub sensors: Vec<usize>,
    conversions: Vec<Option<Conversion>>,
    unwrap: Vec<Option<Unwrap>>,
    time: Option<usize>,
    /// Place of the labels in a block.
    pub label: Option<usize>,
    /// The label of the rows that were not looked at.
    pub run: String,
    /// Rows that were not pushed.
    columns: Vec<Vec<f64>>,
    times: Vec<f64>,
    due: usize,
    /// What is held.
    pub hold: Hold,
}

/// What a row brings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Due {
    Nothing,
    /// A few more rows are in.
    Glance,
    /// A look is due.
    Look,
    /// The rows before had another label.
    Ended,
}

/// How standstills are found: where times come from, the window in s, and the largest variance of a still window in variances of the still sensor.
#[derive(Default)]
pub(super) struct Standstills {
    pub clock: ClockFrom,
    pub window: f64,
    pub threshold: f64,
}

/// What samples are looked at with.
#[derive(Clone, Copy)]
pub(super) struct State<'a> {
    pub campaign: &'a Campaign,
    pub guide: &'a Guide,
    pub asked: Option<&'a Reading>,
    /// The reading that was accepted last.
    pub last: Option<&'a Reading>,
}

impl Table {
    pub fn new(titles: &str, first: &str, found_by: &Standstills, campaign: &Campaign) -> Result<Self> {
        let record = Record::of_text("samples", format!("{titles}\n{first}\n"))?;
        let time = found_by.clock.column(&record)?;
        let clock = found_by.clock.ticks(&record, time)?;
        let unused = found_by.clock.unused(&record);
        let titled = wire::table_keys(&campaign.bench, &record)?;
        let mut chosen: Vec<(usize, String)> = Vec::new();
        let place =
            |key: &str| titled.iter().position(|(id, _)| id == key).filter(|k| ![time, unused].contains(&Some(*k)));
        let ids = || campaign.bench.sensors.iter().map(|s| s.id.as_str());
        let sensors: Vec<usize> = ids().enumerate().filter(|(_, id)| place(id).is_some()).map(|(k, _)| k).collect();
        chosen.extend(ids().filter_map(|id| Some((place(id)?, id.to_string()))));
        if sensors.is_empty() {
            return Err(Malformed::new(Fault::Missing, "no column of the samples is one of a sensor")
                .expected(format!("a column for {}", ids().collect::<Vec<_>>().join(", ")))
                .found(crate::record::listed(record.columns())));
        }
        let suffixes = ["_deg", "_deg_s"];
        let joints: Vec<String> =
            campaign.bench.joints().flat_map(|name| suffixes.map(|suffix| format!("{name}{suffix}"))).collect();
        let columns = campaign.readings.columns.iter().filter(|name| !joints.contains(name));
        chosen.extend(columns.filter_map(|name| Some((place(name)?, name.clone()))));
        let observed = chosen.len();
        chosen.extend(joints.iter().filter_map(|name| Some((place(name)?, name.clone()))));
        let label = place("position");
        let mut wanted: Vec<(usize, As)> = chosen.iter().map(|(k, _)| (*k, As::Number)).collect();
        wanted.extend(label.map(|k| (k, As::Label)));
        wanted.extend(time.map(|k| (k, As::Time)));
        if !record.is_of_text() {
            return Err(Malformed::new(Fault::Syntax, "the samples are no table of text"));
        }
        let mut rows = record;
        rows.select(&wanted);
        let units = |k: &usize| rows.columns().get(*k).and_then(|column| column.unit.clone()).unwrap_or_default();
        let named = chosen.iter().map(|(k, key)| (key.clone(), units(k))).collect();
        let hold = Hold::new(named, observed, found_by.window, found_by.threshold, found_by.window);
        let conversion = |(k, _): &(usize, String)| titled.get(*k).and_then(|(_, conversion)| *conversion);
        let turns =
            |(_, key): &(usize, String)| (joints.contains(key) && key.ends_with("_deg")).then(|| Unwrap::new(360.0));
        let due = time.map_or(clock.step(), |_| 0.0);
        let due = if due > 0.0 { hold.rows(due) } else { LEARNT };
        Ok(Table {
            block: Block::default(),
            line: Vec::new(),
            fresh: clock.clone(),
            clock,
            conversions: chosen.iter().map(conversion).collect(),
            unwrap: chosen.iter().map(turns).collect(),
            columns: vec![Vec::new(); chosen.len()],
            keys: chosen.into_iter().map(|(_, key)| key).collect(),
            sensors,
            time: time.map(|_| wanted.len() - 1),
            label: label.map(|_| wanted.iter().position(|(_, kind)| *kind == As::Label).unwrap_or_default()),
            run: String::new(),
            jumps: 0,
            window_s: found_by.window,
            times: Vec::new(),
            due,
            hold: if label.is_some() { hold.labelled() } else { hold },
            rows,
        })
    }

    pub fn row(&mut self, text: &str, passed: bool) -> Result<Due> {
        self.line.clear();
        self.line.extend_from_slice(text.as_bytes());
        self.line.push(b'\n');
        self.rows.lines(&self.line, &mut self.block)?;
        if self.block.rows() == 0 {
            return Ok(Due::Nothing);
        }
        let mut due = Due::Nothing;
        if self.label.is_some() {
            let next = self.next_run();
            let is_other = next != self.run;
            if is_other && self.times.is_empty() && self.columns.iter().all(Vec::is_empty) && self.hold.is_empty() {
                self.run = next;
            } else if is_other {
                self.flush(passed)?;
                if passed {
                    self.run = next;
                } else {
                    due = Due::Ended;
                }
            }
        }
        for (k, column) in self.columns.iter_mut().enumerate() {
            let value = self.block.columns.get(k).and_then(|value| value.first()).copied().unwrap_or(f64::NAN);
            let value = self.conversions.get(k).copied().flatten().map_or(value, |conversion| conversion.apply(value));
            match self.unwrap.get_mut(k) {
                Some(Some(unwrap)) => column.extend(unwrap.turns(&[value])),
                _ => column.push(value),
            }
        }
        self.times.extend(self.time.and_then(|k| self.block.columns.get(k)).and_then(|values| values.first()));
        if due == Due::Nothing && self.columns.first().map_or(0, Vec::len) >= self.due {
            self.flush(passed)?;
            due = match self.hold.is_due() {
                _ if passed => Due::Nothing,
                true => Due::Look,
                false => Due::Glance,
            };
        }
        Ok(due)
    }

    /// The label of the row that was read last.
    pub fn next_run(&self) -> String {
        let number = self.label.and_then(|k| self.block.columns.get(k)).and_then(|values| values.first());
        let label = number.and_then(|number| self.rows.labels().get(crate::number::count(*number)));
        label.map_or(String::new(), |label| label.trim().to_string())
    }

    /// The rows that wait go into what is held, or (`passed`) are counted.
    pub fn flush(&mut self, passed: bool) -> Result<()> {
        let count = self.columns.first().map_or(0, Vec::len);
        if count == 0 {
            return Ok(());
        }
        let times = self.time.map(|_| self.times.as_slice());
        let stretches = self.clock.stretches(times, count, None, None);
        let interval = self.clock.interval().unwrap_or(self.clock.step());
        if stretches.is_ok() && interval > 0.0 {
            self.due = self.hold.rows(interval);
            for stretch in stretches.iter().flatten() {
                if stretch.after_gap {
                    self.hold.interrupt();
                }
                let columns: Vec<&[f64]> = self.columns.iter().map(|c| c.part(stretch.rows.clone())).collect();
                self.hold.push(&columns, self.clock.times().part(stretch.rows.clone()), interval);
            }
        }
        self.columns.iter_mut().for_each(Vec::clear);
        self.times.clear();
        if passed {
            self.hold.restart();
        }
        let no_step = || {
            Malformed::new(Fault::Value, "the times of the samples do not increase")
                .expected("times that increase, or a sampling rate (--rate) instead of the column")
        };
        let checked = stretches.and_then(|_| if interval > 0.0 { Ok(()) } else { Err(no_step()) });
        let jump = self.jumped().filter(|_| !passed);
        if checked.is_err() {
            // the clock begins anew behind them
            (self.clock, self.due) = (self.fresh.clone(), LEARNT);
            self.hold.interrupt();
            self.jumps = 0;
        }
        checked.and(jump.map_or(Ok(()), Err))
    }

    /// The last jump of the clock that was not said yet: back, or forward by more than the window that finds standstills.
    fn jumped(&mut self) -> Option<Malformed> {
        let (jumps, ..) = self.clock.jumps();
        let new = jumps.get(self.jumps..).unwrap_or_default();
        self.jumps = jumps.len();
        let jump = new.iter().rev().find(|jump| match jump.kind {
            JumpKind::Back => true,
            JumpKind::Gap => jump.step > self.window_s,
            JumpKind::Short => false,
        })?;
        let what = if jump.kind == JumpKind::Back { "goes back" } else { "jumps forward" };
        let then = match jump.kind {
            JumpKind::Back => "times that increase; they go on by one sampling interval",
            _ => "times without a gap; samples are missing, or the clock was set: what is held begins anew",
        };
        Some(
            Malformed::new(Fault::Value, format!("the clock of the samples {what}"))
                .expected(then)
                .found(format!("a step of {:.3} s", jump.step)),
        )
    }

    /// How the joints stand, where columns say it. The angle of a joint that turns says nothing here.
    pub fn joints(&self, state: State, standing: &Standing) -> Vec<(String, Cell)> {
        let value = |key: String| self.keys.iter().position(|k| *k == key).and_then(|k| standing.value(k));
        let joint = |(j, name): (usize, &str)| {
            let (turns, rate) = (value(format!("{name}_deg")), value(format!("{name}_deg_s")));
            let states = state.guide.candidates().iter().filter_map(|candidate| candidate.joints.get(j).copied());
            let found = match (turns, rate.map(rounded)) {
                (_, Some(rate)) if rate != 0.0 => return Some((format!("{name}_deg_s"), Cell::Number(rate))),
                (Some(turns), _) => rounded((360.0 * turns).rem_euclid(360.0)),
                _ => return None,
            };
            let turning = |state: JointState| state.rate_deg_s() != 0.0;
            if rate.is_none() && state.asked.and_then(|reading| reading.joints.get(j).copied()).is_some_and(turning) {
                return None;
            }
            // as the schedule writes the same angle
            let apart = |deg: f64| (deg - found + 180.0).rem_euclid(360.0) - 180.0;
            let alike = |state: JointState| match state {
                JointState::Held { angle_deg } if apart(angle_deg).abs() < DIGIT_DEG => Some(angle_deg),
                _ => None,
            };
            let written = states.filter_map(alike).next().unwrap_or(found);
            Some((format!("{name}_deg"), Cell::Number(written)))
        };
        state.campaign.bench.joints().enumerate().filter_map(joint).collect()
    }

    /// The reading of what is held.
    pub fn cells(
        &self,
        campaign: &Campaign,
        standing: &Standing,
        means: &[(Mean, Vec<Ahead>)],
        keys: ReadingFile,
    ) -> ReadingFile {
        let Named(mut cells) = keys;
        for (key, (mean, _)) in self.keys.iter().zip(means) {
            cells.push((key.clone(), Cell::Number(mean.value)));
            if mean.uncertainty.u > 0.0 {
                cells.push((format!("{key}_u"), Cell::Number(mean.uncertainty.u)));
            }
        }
        for (k, key) in self.keys.iter().enumerate().skip(means.len()) {
            if campaign.readings.columns.contains(key) && !cells.iter().any(|(present, _)| present == key) {
                cells.extend(standing.value(k).map(|value| (key.clone(), Cell::Number(value))));
            }
        }
        if campaign.readings.columns.iter().any(|name| name == "time_s") {
            cells.push(("time_s".into(), Cell::Number(rounded(standing.middle_s))));
        }
        Named(cells)
    }
}

/// Angles nearer than this are one: finer than any encoder, and coarser than rounding.
const DIGIT_DEG: f64 = 1e-6;

fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}
