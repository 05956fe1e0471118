//! Samples as they come: rows below a line of titles, what is held, and the reading that it becomes.
//!
//! What is said and read follows from the rows alone, not from when they come: a record that is followed again gives the same readings.

use super::lines;
use crate::campaign::{Campaign, JointState, Reading};
use crate::elements::Parts;
use crate::error::{Fault, Malformed, Result};
use crate::guide::{Agreement, Guide, Held, HeldMean, Holding};
use crate::record::{As, Block, Clock, ClockFrom, Delimited, Record};
use crate::reduce::{Ahead, Hold, Look, Mean, Standing, Unwrap};
use crate::units::Conversion;
use crate::wire::{self, Cell, Named, ReadingFile};

/// Rows from which the step of the times is learnt.
const LEARNT: usize = 16;
/// Shorter standstills are not read, s: as in a record.
const LEAST_S: f64 = 1.0;
/// Means are looked at again when this share of what is held has come in addition: white noise makes u less by a fifth.
const MORE: f64 = 0.5;
/// Windows of a position that was read after which no more of it is kept.
const KEPT: f64 = 64.0;

/// A stream of samples.
pub(super) struct Samples {
    clock: ClockFrom,
    window: f64,
    threshold: f64,
    table: Option<Table>,
    /// What was said of where the bench stands, and whether a standstill has it already.
    named: Option<(ReadingFile, bool)>,
    /// Does the bench stand where it was read last?
    on: bool,
    /// The last sample of what was held at the last look.
    end: u64,
    /// How long it must be held, s, before its means are looked at again.
    next_s: f64,
    said: Option<Held>,
    /// A reading of which several positions may be the one.
    open: Option<ReadingFile>,
    still_sd: Vec<f64>,
    /// Was the last row one that was looked at before?
    passing: bool,
}

struct Table {
    rows: Delimited,
    block: Block,
    line: Vec<u8>,
    clock: Clock,
    fresh: Clock,
    /// Keys of the channels: sensors, columns of the campaign, joints.
    keys: Vec<String>,
    sensors: Vec<usize>,
    conversions: Vec<Option<Conversion>>,
    unwrap: Vec<Option<Unwrap>>,
    time: Option<usize>,
    label: Option<usize>,
    /// The label of the rows that were not looked at.
    run: String,
    /// Rows that were not pushed.
    columns: Vec<Vec<f64>>,
    times: Vec<f64>,
    due: usize,
    hold: Hold,
}

/// Was this held for so long that it is worth a word that it was left?
fn is_lasting(own: &Held) -> bool {
    own.state == Holding::Held && own.held_s >= LEAST_S
}

/// What a row brings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Due {
    Nothing,
    /// A look is due.
    Look,
    /// The rows before had another label.
    Ended,
}

/// What a look brings.
pub(super) enum Step {
    Nothing,
    Said(Held),
    Read(ReadingFile),
}

/// Where a reading belongs.
pub(super) enum Placed {
    Here(Reading),
    /// Several settings agree.
    Which(Vec<String>),
}

/// What samples are looked at with.
#[derive(Clone, Copy)]
pub(super) struct Beside<'a> {
    pub campaign: &'a Campaign,
    pub guide: &'a Guide,
    pub asked: Option<&'a Reading>,
    /// The reading that was accepted last.
    pub last: Option<&'a Reading>,
}

impl Samples {
    pub fn new(clock: ClockFrom, window: f64, threshold: f64) -> Self {
        Samples {
            clock,
            window,
            threshold,
            table: None,
            named: None,
            on: false,
            end: 0,
            next_s: 0.0,
            said: None,
            open: None,
            still_sd: Vec::new(),
            passing: false,
        }
    }

    /// A journal has a reading, which was judged by a still sensor of these standard deviations.
    pub fn resume(&mut self, still_sd: Vec<f64>) {
        (self.on, self.still_sd) = (true, still_sd);
    }

    /// The standard deviations of the still sensor that are known.
    pub fn still_sd(&self) -> &[f64] {
        self.table.as_ref().map_or(&[], |own| own.hold.still_sd())
    }

    /// A row below these titles. `passed`: it was looked at before.
    ///
    /// Errors: titles of no sensor, cells that are no numbers, times that do not increase.
    pub fn row(&mut self, titles: &str, text: &str, passed: bool, campaign: &Campaign) -> Result<Due> {
        let table = match &mut self.table {
            Some(own) => own,
            None => {
                let mut own = Table::new(titles, text, self, campaign)?;
                own.hold.set_still_sd(self.still_sd.clone());
                self.table.insert(own)
            }
        };
        self.passing = passed;
        table.row(text, passed)
    }

    /// Everything that was passed is behind.
    pub fn is_past(&mut self) -> Result<()> {
        match &mut self.table {
            Some(table) if std::mem::take(&mut self.passing) => table.flush(true),
            _ => Ok(()),
        }
    }

    /// No more rows come: what was not looked at is.
    pub fn finish(&mut self) -> Result<()> {
        match &mut self.table {
            Some(table) => table.flush(false),
            None => Ok(()),
        }
    }

    /// The bench stands at a position with these keys, or will at the next standstill; or else a reading that waits for its position, with them.
    pub fn name(&mut self, keys: ReadingFile) -> Option<ReadingFile> {
        if let Some(Named(mut cells)) = self.open.clone() {
            cells.retain(|(key, _)| keys.get(key).is_none());
            return Some(Named(keys.0.into_iter().chain(cells).collect()));
        }
        if std::mem::take(&mut self.on) {
            self.next_s = 0.0;
            self.table.iter_mut().for_each(|own| own.hold.restart());
        }
        self.named = Some((keys, false));
        None
    }

    /// A reading waits for its position, or (`None`) waits no more.
    pub fn ask(&mut self, cells: Option<ReadingFile>) {
        self.open = cells;
    }

    /// Is anything held that is not read?
    pub fn holds(&self) -> bool {
        self.open.is_none() && self.said.as_ref().is_some_and(|own| own.state == Holding::Held)
    }

    /// What is held; `at_once`: it is read as it is; `ended`: with its label, too.
    pub fn look(&mut self, beside: Beside, at_once: bool, ended: bool) -> Result<Step> {
        let Some(mut table) = self.table.take() else { return Ok(Step::Nothing) };
        let at_once = at_once || ended && table.label.is_some();
        let step = self.looked(&mut table, beside, at_once);
        if table.label.is_some() && ended {
            table.hold.restart();
            table.run = table.next_run();
            (self.on, self.next_s) = (false, 0.0);
        }
        self.table = Some(table);
        step
    }

    fn looked(&mut self, table: &mut Table, beside: Beside, at_once: bool) -> Result<Step> {
        if table.label.is_some() && table.run.is_empty() {
            table.hold.restart();
            return Ok(self.moves());
        }
        let standing = match table.hold.look() {
            Look::Standing(own) => own,
            Look::Open => return Ok(Step::Nothing),
            Look::Moving => return Ok(self.moves()),
        };
        if standing.start >= self.end && self.end > 0 {
            // another standstill
            self.left();
            if let Some(was) = self.said.take().filter(is_lasting) {
                (self.on, self.end) = (false, standing.end);
                return Ok(self.say(Held { state: Holding::Left, ..was }));
            }
        }
        self.end = standing.end;
        self.on &= standing.whole;
        if let Some((_, used)) = &mut self.named {
            *used = true;
        }
        let mut keys = self.named.as_ref().map_or(Named(Vec::new()), |(own, _)| own.clone());
        if table.label.is_some() {
            keys = Named(vec![("position".into(), Cell::Text(table.run.clone()))]);
        }
        keys.0.extend(table.joints(beside, &standing));
        let again = beside.asked.zip(beside.last).is_some_and(|(asked, last)| asked.joints == last.joints);
        let base = lines::base(&keys, beside.guide, beside.asked).or(beside.guide.candidates().first());
        let Some(base) = base else { return Ok(Step::Nothing) };
        let mut held = Held {
            position: base.position.clone(),
            setting: crate::guide::setting(beside.campaign, &base.joints),
            held_s: standing.seconds,
            ..Held::nothing(Holding::Held)
        };
        if self.on && (!again || self.open.is_some()) {
            if standing.seconds > KEPT * self.window {
                table.hold.restart();
            }
            if let Some(last) = beside.last.filter(|_| self.open.is_none()) {
                held.state = Holding::Read;
                held.position = last.position.clone();
                held.setting = crate::guide::setting(beside.campaign, &last.joints);
                return Ok(self.say(held));
            }
            return Ok(Step::Nothing);
        }
        if self.open.is_some() {
            return Ok(Step::Nothing);
        }
        self.on = false;
        let turn_s =
            base.joints.iter().map(JointState::rate_deg_s).find(|rate| *rate != 0.0).map(|rate| 360.0 / rate.abs());
        let least = turn_s.unwrap_or(0.0).max(if table.label.is_some() { 0.0 } else { LEAST_S });
        if standing.seconds < self.next_s.max(least) && !at_once {
            // as it was foreseen
            if let Some(own) = self.said.as_ref().filter(|own| own.state == Holding::Held && self.next_s > 0.0) {
                held.means = own.means.clone();
                held.wait_s = own.wait_s.map(|wait| (wait - (standing.seconds - own.held_s)).max(0.0));
            }
            return Ok(self.say(held));
        }
        let Some(means) = standing.means(table.sensors.len(), turn_s) else { return Ok(self.say(held)) };
        let mut wait = Some(0.0_f64);
        for ((mean, ahead), sensor) in means.iter().zip(&table.sensors) {
            let Some(own) = beside.campaign.bench.sensors.get(*sensor) else { continue };
            let (wanted, u) = (beside.guide.expected_u(base, *sensor), mean.uncertainty.u);
            let until = Ahead::until(standing.seconds, mean, ahead, wanted);
            wait = wait.zip(until).map(|(a, b)| a.max(b));
            held.means.push(HeldMean { sensor: own.id.clone(), mean: mean.value, u, wanted, unit: own.unit.clone() });
        }
        held.wait_s = wait;
        let more = MORE * standing.seconds;
        self.next_s = standing.seconds + wait.map_or(more, |wait| wait.min(more));
        if wait != Some(0.0) && !at_once {
            return Ok(self.say(held));
        }
        let cells = table.cells(beside.campaign, &standing, &means, keys);
        let known = standing.still_sd();
        if !known.is_empty() {
            table.hold.set_still_sd(known);
        }
        table.hold.restart();
        (self.on, self.named, self.said, self.end, self.next_s) = (true, None, None, 0, 0.0);
        Ok(Step::Read(cells))
    }

    /// The bench moves.
    fn moves(&mut self) -> Step {
        (self.on, self.end) = (false, 0);
        let was = self.said.clone().filter(is_lasting);
        self.left();
        let state = if was.is_some() { Holding::Left } else { Holding::Moving };
        let held = was.map_or_else(|| Held::nothing(state), |own| Held { state, ..own });
        self.say(held)
    }

    /// What was held is so no more.
    fn left(&mut self) {
        self.next_s = 0.0;
        self.named = self.named.take().filter(|(_, used)| !used);
    }

    fn say(&mut self, held: Held) -> Step {
        // of what moves, or was left, nothing more is to be said
        let quiet = |own: &Held| matches!(own.state, Holding::Moving | Holding::Left);
        let told = self.said.as_ref().is_some_and(|own| {
            own.state == held.state && held.state != Holding::Held || quiet(own) && held.state == Holding::Moving
        });
        match told {
            true => Step::Nothing,
            false => {
                self.said = Some(held.clone());
                Step::Said(held)
            }
        }
    }
}

impl Table {
    fn new(titles: &str, first: &str, samples: &Samples, campaign: &Campaign) -> Result<Self> {
        let record = Record::of_text("samples", format!("{titles}\n{first}\n"))?;
        let time = samples.clock.column(&record)?;
        let clock = samples.clock.ticks(&record, time)?;
        let unused = samples.clock.unused(&record);
        let titled = wire::table_keys(&campaign.bench, &record)?;
        let mut chosen: Vec<(usize, String)> = Vec::new();
        let place =
            |key: &str| titled.iter().position(|(own, _)| own == key).filter(|k| ![time, unused].contains(&Some(*k)));
        let ids = || campaign.bench.sensors.iter().map(|own| own.id.as_str());
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
        let Record::Delimited(mut rows) = record else {
            return Err(Malformed::new(Fault::Syntax, "the samples are no table of text"));
        };
        rows.select(&wanted);
        let units = |k: &usize| rows.dialect().columns.get(*k).and_then(|own| own.unit.clone()).unwrap_or_default();
        let named = chosen.iter().map(|(k, key)| (key.clone(), units(k))).collect();
        let hold = Hold::new(named, observed, samples.window, samples.threshold, samples.window);
        let conversion = |(k, _): &(usize, String)| titled.get(*k).and_then(|(_, own)| *own);
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
            times: Vec::new(),
            due,
            hold: if label.is_some() { hold.labelled() } else { hold },
            rows,
        })
    }

    fn row(&mut self, text: &str, passed: bool) -> Result<Due> {
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
            let own = self.block.columns.get(k).and_then(|own| own.first()).copied().unwrap_or(f64::NAN);
            let own = self.conversions.get(k).copied().flatten().map_or(own, |conversion| conversion.apply(own));
            match self.unwrap.get_mut(k) {
                Some(Some(unwrap)) => column.extend(unwrap.turns(&[own])),
                _ => column.push(own),
            }
        }
        self.times.extend(self.time.and_then(|k| self.block.columns.get(k)).and_then(|own| own.first()));
        if due == Due::Nothing && self.columns.first().map_or(0, Vec::len) >= self.due {
            self.flush(passed)?;
            due = if passed { Due::Nothing } else { Due::Look };
        }
        Ok(due)
    }

    /// The label of the row that was read last.
    fn next_run(&self) -> String {
        let number = self.label.and_then(|k| self.block.columns.get(k)).and_then(|own| own.first());
        let label = number.and_then(|number| self.rows.labels().get(crate::number::count(*number)));
        label.map_or(String::new(), |label| label.trim().to_string())
    }

    /// The rows that wait go into what is held, or (`passed`) are counted.
    fn flush(&mut self, passed: bool) -> Result<()> {
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
                let columns: Vec<&[f64]> = self.columns.iter().map(|own| own.part(stretch.rows.clone())).collect();
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
        let told = stretches.and_then(|_| if interval > 0.0 { Ok(()) } else { Err(no_step()) });
        if told.is_err() {
            // the clock begins anew behind them
            (self.clock, self.due) = (self.fresh.clone(), LEARNT);
            self.hold.interrupt();
        }
        told
    }

    /// How the joints stand, where columns say it. The angle of a joint that turns says nothing here.
    fn joints(&self, beside: Beside, standing: &Standing) -> Vec<(String, Cell)> {
        let value = |key: String| self.keys.iter().position(|own| *own == key).and_then(|k| standing.value(k));
        let joint = |(j, name): (usize, &str)| {
            let (turns, rate) = (value(format!("{name}_deg")), value(format!("{name}_deg_s")));
            let states = beside.guide.candidates().iter().filter_map(|own| own.joints.get(j).copied());
            let found = match (turns, rate.map(rounded)) {
                (_, Some(rate)) if rate != 0.0 => return Some((format!("{name}_deg_s"), Cell::Number(rate))),
                (Some(turns), _) => rounded((360.0 * turns).rem_euclid(360.0)),
                _ => return None,
            };
            let turning = |own: JointState| own.rate_deg_s() != 0.0;
            if rate.is_none() && beside.asked.and_then(|own| own.joints.get(j).copied()).is_some_and(turning) {
                return None;
            }
            // as the schedule writes the same angle
            let apart = |own: f64| (own - found + 180.0).rem_euclid(360.0) - 180.0;
            let alike = |own: JointState| match own {
                JointState::Held { angle_deg } if apart(angle_deg).abs() < DIGIT_DEG => Some(angle_deg),
                _ => None,
            };
            let written = states.filter_map(alike).next().unwrap_or(found);
            Some((format!("{name}_deg"), Cell::Number(written)))
        };
        beside.campaign.bench.joints().enumerate().filter_map(joint).collect()
    }

    /// The reading of what is held.
    fn cells(
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
            if campaign.readings.columns.contains(key) && !cells.iter().any(|(own, _)| own == key) {
                cells.extend(standing.value(k).map(|value| (key.clone(), Cell::Number(value))));
            }
        }
        if campaign.readings.columns.iter().any(|own| own == "time_s") {
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

/// The position of a reading: what its keys say, else the one that was asked for, unless its values do not agree with that one and another does.
///
/// Errors: those of a reading.
pub(super) fn placed(cells: &ReadingFile, beside: Beside) -> Result<Placed> {
    let Beside { campaign, guide, asked, .. } = beside;
    let joints = campaign.bench.joints();
    let says =
        |joint: &str| cells.0.iter().any(|(key, _)| key.strip_prefix(joint).is_some_and(|own| own.starts_with("_deg")));
    let by_joints = joints.filter(|joint| says(joint)).count() > 0;
    let named = lines::label(cells);
    let is_named = |own: &&Reading| named.as_ref().is_none_or(|label| own.position == *label);
    let settings: Vec<&Reading> = guide.candidates().iter().filter(is_named).collect();
    let told = by_joints || named.is_some() && settings.len() < 2;
    if told || asked.is_none() && named.is_none() {
        return lines::reading(cells.clone(), campaign, guide, asked).map(Placed::Here);
    }
    let at = |own: &Reading| lines::reading(cells.clone(), campaign, guide, Some(own));
    if let Some(own) = asked.filter(is_named) {
        let own = at(own)?;
        if guide.would_agree(&own)? != Agreement::Disagrees {
            return Ok(Placed::Here(own));
        }
    }
    let mut possible: Vec<(Reading, Agreement)> = Vec::new();
    for own in settings {
        // a setting at which the model lacks a column cannot be compared
        if let Ok(own) = at(own)
            && let Ok(found) = guide.would_agree(&own)
            && found != Agreement::Disagrees
        {
            possible.push((own, found));
        }
    }
    let agrees = possible.iter().any(|(_, found)| *found == Agreement::Agrees);
    match (possible.as_slice(), asked.filter(is_named)) {
        ([(own, _)], _) if agrees => Ok(Placed::Here(own.clone())),
        (several, _) if agrees => {
            let one = |(own, _): &(Reading, Agreement)| {
                format!("{}: {}", own.position, crate::guide::setting(campaign, &own.joints))
            };
            Ok(Placed::Which(several.iter().map(one).collect()))
        }
        (_, Some(asked)) => at(asked).map(Placed::Here),
        _ => lines::reading(cells.clone(), campaign, guide, asked).map(Placed::Here),
    }
}
