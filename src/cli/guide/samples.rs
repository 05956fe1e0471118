//! Samples as they come: rows below a line of titles, what is held, and the reading that it becomes.
//!
//! What is said and read follows from the rows alone, not from when they come: a record that is followed again gives the same readings.

use super::lines;
use super::table::{Due, Standstills, State, Table};
use crate::campaign::JointState;
use crate::error::Result;
use crate::guide::{Held, HeldMean, Holding};
use crate::record::ClockFrom;
use crate::reduce::{Ahead, Look, Mean, Standing};
use crate::wire::{Cell, Named, ReadingFile};
use std::sync::Arc;
use std::thread::JoinHandle;

/// Shorter standstills are not read, s: as in a record.
const LEAST_S: f64 = 1.0;
/// Means are looked at again when this share of what is held has come in addition, unless they are foreseen to be wanted before: white noise makes u less by
/// three tenths, and looking costs as much as the samples of seconds.
const MORE: f64 = 1.0;
/// Windows of a position that was read after which no more of it is kept: half a minute at the default window, a bound on memory alone, since a reading changes no more.
const KEPT: f64 = 64.0;

#[derive(Default)]
pub(super) struct Samples {
    standstills: Standstills,
    table: Option<Table>,
    /// What was said of where the bench stands, and whether a standstill has it already.
    named: Option<(ReadingFile, bool)>,
    /// Does the bench stand where it was read last?
    on: bool,
    /// The last sample of what was held at the last look.
    end: u64,
    /// How long it must be held, s, before its means are looked at again.
    next_s: f64,
    /// The same, and no shorter than a standstill is.
    due_s: f64,
    said: Option<Held>,
    /// What the last look found, where it is a position that is held and not read; and the samples until then.
    held_now: Option<(Held, u64)>,
    weighing: Option<Weighing>,
    /// A reading of which several positions may be the one, and which waits for its position.
    pub open: Option<ReadingFile>,
    still_sd: Vec<f64>,
    /// Was the last row one that was looked at before?
    passing: bool,
}

/// Was this held for so long that it is worth a word that it was left?
fn is_lasting(held: &Held) -> bool {
    held.state == Holding::Held && held.held_s >= LEAST_S
}

/// Means of what was held, which take their time beside the samples that come.
struct Weighing {
    means: JoinHandle<Option<Vec<(Mean, Vec<Ahead>)>>>,
    standing: Arc<Standing>,
    /// The samples until then, and those at which they are asked for: by a count of samples, so that what is read follows from the rows alone.
    from: u64,
    due: u64,
}

/// How what is held is looked at.
enum At {
    /// While samples come.
    Ease,
    /// It is read as it is.
    Once,
    /// No more samples come.
    End,
    /// Its means are there, so many seconds later.
    Weighed(Option<Vec<(Mean, Vec<Ahead>)>>, f64),
}

pub(super) enum Step {
    Nothing,
    Said(Held),
    Read(ReadingFile),
}

impl Samples {
    pub fn new(clock: ClockFrom, window: f64, threshold: f64) -> Self {
        Samples { standstills: Standstills { clock, window, threshold }, ..Samples::default() }
    }

    /// A journal has a reading, which was judged by a still sensor of these standard deviations.
    pub fn resume(&mut self, still_sd: Vec<f64>) {
        (self.on, self.still_sd) = (true, still_sd);
    }

    /// The standard deviations of the still sensor that are known.
    pub fn still_sd(&self) -> &[f64] {
        self.table.as_ref().map_or(&[], |table| table.hold.still_sd())
    }

    /// A row below these titles. `passed`: it was looked at before, and brings nothing.
    ///
    /// Errors: titles of no sensor, cells that are no numbers, times that do not increase.
    pub fn row(&mut self, titles: &str, text: &str, passed: bool, state: State) -> Result<Step> {
        let table = match &mut self.table {
            Some(table) => table,
            None => {
                let mut table = Table::new(titles, text, &self.standstills, state.campaign)?;
                table.hold.set_still_sd(self.still_sd.clone());
                self.table.insert(table)
            }
        };
        self.passing = passed;
        match table.row(text, passed)? {
            Due::Nothing => Ok(Step::Nothing),
            Due::Glance => self.glance(state),
            due => self.look(state, false, due == Due::Ended),
        }
    }

    /// Everything that was passed is behind.
    pub fn is_past(&mut self) -> Result<()> {
        match &mut self.table {
            Some(table) if std::mem::take(&mut self.passing) => table.flush(true),
            _ => Ok(()),
        }
    }

    /// Rows are missing before the next one.
    #[cfg(feature = "serial")]
    pub fn interrupt(&mut self) -> Result<()> {
        self.finish()?;
        self.table.iter_mut().for_each(|table| table.hold.interrupt());
        Ok(())
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
        self.weighing = None;
        if std::mem::take(&mut self.on) {
            self.next_s = 0.0;
            self.table.iter_mut().for_each(|table| table.hold.restart());
        }
        self.named = Some((keys, false));
        None
    }

    /// Is anything held that is not read?
    pub fn holds(&self) -> bool {
        self.open.is_none() && self.said.as_ref().is_some_and(|held| held.state == Holding::Held)
    }

    /// A few more rows came: what is held is so for as much longer, until its means are due.
    fn glance(&mut self, state: State) -> Result<Step> {
        let Some(hold) = self.table.as_ref().map(|table| &table.hold) else { return Ok(Step::Nothing) };
        if self.weighing.as_ref().is_some_and(|weighing| hold.count() >= weighing.due) {
            return self.look(state, false, false);
        }
        let Some((held, at)) = &self.held_now else { return Ok(Step::Nothing) };
        let by = hold.seconds(hold.count() - at);
        let held = Held {
            held_s: held.held_s + by,
            wait_s: held.wait_s.map(|wait| (wait - by).max(0.0)),
            until_s: hold.now_s(),
            ..held.clone()
        };
        let is_due = held.held_s >= self.due_s && self.weighing.is_none();
        if is_due { self.look(state, false, false) } else { Ok(Step::Said(held)) }
    }

    /// What is held; `at_once`: it is read as it is; `ended`: with its label, too.
    pub fn look(&mut self, state: State, at_once: bool, ended: bool) -> Result<Step> {
        let Some(mut table) = self.table.take() else { return Ok(Step::Nothing) };
        let at_once = at_once || ended && table.label.is_some();
        let until_s = table.hold.now_s();
        self.held_now = None;
        let step = self.looked(&mut table, state, at_once, ended).map(|step| match step {
            Step::Said(held) => Step::Said(Held { until_s, ..held }),
            other => other,
        });
        if let Ok(Step::Said(held)) = &step {
            self.held_now = Some((held.clone(), table.hold.count())).filter(|(h, _)| h.state == Holding::Held);
        }
        if table.label.is_some() && ended {
            table.hold.restart();
            table.run = table.next_run();
            (self.on, self.next_s) = (false, 0.0);
        }
        self.table = Some(table);
        step
    }

    fn looked(&mut self, table: &mut Table, state: State, at_once: bool, ended: bool) -> Result<Step> {
        if table.label.is_some() && table.run.is_empty() {
            table.hold.restart();
            return Ok(self.moves());
        }
        let count = table.hold.count();
        let due = |weighing: &mut Weighing| at_once || ended || count >= weighing.due;
        if let Some(weighing) = self.weighing.take_if(due).filter(|_| !at_once) {
            let later_s = table.hold.seconds(count - weighing.from);
            // a thread that was lost found nothing
            let means = weighing.means.join().unwrap_or_default();
            let step = self.weighed(table, state, &weighing.standing, At::Weighed(means, later_s))?;
            if !ended || matches!(step, Step::Read(_)) {
                return Ok(step);
            }
        }
        let standing = match table.hold.look() {
            Look::Standing(standing) => standing,
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
        let at = match (at_once, ended) {
            (true, _) => At::Once,
            (_, true) => At::End,
            _ => At::Ease,
        };
        self.weighed(table, state, &Arc::from(standing), at)
    }

    /// What is said of a position that is held, and whether it is read.
    fn weighed(&mut self, table: &mut Table, state: State, standing: &Arc<Standing>, at: At) -> Result<Step> {
        let mut keys = self.named.as_ref().map_or(Named(Vec::new()), |(named, _)| named.clone());
        if table.label.is_some() {
            keys = Named(vec![("position".into(), Cell::Text(table.run.clone()))]);
        }
        keys.0.extend(table.joints(state, standing));
        let again = state.asked.zip(state.last).is_some_and(|(asked, last)| asked.joints == last.joints);
        let base = lines::base(&keys, state.guide, state.asked).or(state.guide.candidates().first());
        let Some(base) = base else { return Ok(Step::Nothing) };
        let mut held = Held {
            position: base.position.to_string(),
            setting: crate::guide::setting(state.campaign, &base.joints),
            held_s: standing.seconds,
            ..Held::nothing(Holding::Held)
        };
        if self.on && (!again || self.open.is_some()) {
            if standing.seconds > KEPT * self.standstills.window {
                table.hold.restart();
            }
            if let Some(last) = state.last.filter(|_| self.open.is_none()) {
                held.state = Holding::Read;
                held.position = last.position.to_string();
                held.setting = crate::guide::setting(state.campaign, &last.joints);
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
        self.due_s = self.next_s.max(least);
        let is_due = standing.seconds >= self.due_s && self.weighing.is_none();
        let (means, at_once, later_s) = match at {
            At::Weighed(means, later_s) => (means, false, later_s),
            At::Once => (standing.means(table.sensors.len(), turn_s), true, 0.0),
            At::End if is_due => (standing.means(table.sensors.len(), turn_s), false, 0.0),
            At::Ease | At::End => {
                if is_due {
                    let (stretch, channels) = (standing.clone(), table.sensors.len());
                    let means = std::thread::spawn(move || stretch.means(channels, turn_s));
                    let from = table.hold.count();
                    let due = from + table.hold.half_window();
                    self.weighing = Some(Weighing { means, standing: standing.clone(), from, due });
                }
                // as it was foreseen
                if let Some(said) = self.said.as_ref().filter(|said| said.state == Holding::Held && self.next_s > 0.0) {
                    held.means = said.means.clone();
                    held.wait_s = said.wait_s.map(|wait| (wait - (standing.seconds - said.held_s)).max(0.0));
                }
                return Ok(self.say(held));
            }
        };
        held.held_s += later_s;
        let Some(means) = means else { return Ok(self.say(held)) };
        let mut wait = Some(0.0_f64);
        let all_wanted = state.guide.wanted_u(base)?;
        for ((mean, ahead), sensor) in means.iter().zip(&table.sensors) {
            let sensors = &state.campaign.bench.sensors;
            let Some((s, wanted)) = sensors.get(*sensor).zip(all_wanted.get(*sensor).copied()) else { continue };
            let u = mean.uncertainty.u;
            let until = Ahead::until(standing.seconds, mean, ahead, wanted);
            wait = wait.zip(until).map(|(a, b)| a.max(b));
            held.means.push(HeldMean { sensor: s.id.clone(), mean: mean.value, u, wanted, unit: s.unit.clone() });
        }
        held.wait_s = wait.map(|wait| (wait - later_s).max(0.0));
        let more = MORE * standing.seconds;
        self.next_s = standing.seconds + wait.map_or(more, |wait| wait.min(more));
        self.due_s = self.next_s.max(least);
        if wait != Some(0.0) && !at_once {
            return Ok(self.say(held));
        }
        let cells = table.cells(state.campaign, standing, &means, keys);
        let known = standing.still_sd();
        if !known.is_empty() {
            table.hold.set_still_sd(known);
        }
        table.hold.restart();
        (self.on, self.named, self.said, self.end, self.next_s) = (true, None, None, 0, 0.0);
        self.weighing = None;
        Ok(Step::Read(cells))
    }

    fn moves(&mut self) -> Step {
        (self.on, self.end) = (false, 0);
        let was = self.said.clone().filter(is_lasting);
        self.left();
        let state = if was.is_some() { Holding::Left } else { Holding::Moving };
        let held = was.map_or_else(|| Held::nothing(state), |was| Held { state, ..was });
        self.say(held)
    }

    fn left(&mut self) {
        self.next_s = 0.0;
        self.weighing = None;
        self.named = self.named.take().filter(|(_, used)| !used);
    }

    fn say(&mut self, held: Held) -> Step {
        // of what moves, or was left, nothing more is to be said
        let quiet = |h: &Held| matches!(h.state, Holding::Moving | Holding::Left);
        let is_known = self.said.as_ref().is_some_and(|h| {
            h.state == held.state && held.state != Holding::Held || quiet(h) && held.state == Holding::Moving
        });
        match is_known {
            true => Step::Nothing,
            false => {
                self.said = Some(held.clone());
                Step::Said(held)
            }
        }
    }
}
