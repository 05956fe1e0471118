//! From line to line: what is accepted, and what is said.

use super::journal::{Entry, Journal};
use super::lines::{self, Line, Lines, Next, Numbered, Placed, placed};
use super::samples::{Samples, Step};
use super::screen::Screen;
use super::serve::Page;
use super::table::State;
use super::{json, view};
use crate::campaign::{Campaign, Reading, Readings};
use crate::cli;
use crate::cli::session;
use crate::error::{Fault, Malformed, Result};
use crate::guide::{Advice, Ending, Guide, Held, Holding};
#[cfg(feature = "serial")]
use crate::language::say;
use crate::report::guide_report;
use crate::simulate::{self, Truth};
use std::time::{Duration, Instant};

pub(super) struct Source {
    pub lines: Option<Lines>,
    /// The lines are samples.
    pub samples: Option<Samples>,
    pub truth: Option<Truth>,
    pub seed: u64,
    /// Readings of the campaign's own file.
    pub given: Vec<Reading>,
}

pub(super) struct Session {
    pub guide: Guide,
    pub journal: Journal,
    pub source: Source,
    pub campaign: Campaign,
    /// Every reading that was accepted, those that were undone among them: what a simulation goes on from.
    pub ever: Vec<Reading>,
    pub json: bool,
    pub page: Option<Page>,
    /// The view of the terminal, in the place of lines.
    pub screen: Option<Screen>,
    pub progress: Progress,
}

/// What is said while a position is held.
pub(super) struct Progress {
    /// A line of the terminal that is written again and again.
    pub line: indicatif::ProgressBar,
    pub shown: Option<(Instant, Holding)>,
    /// The advice as a line of JSON: each line beside it has the same one.
    pub line_of_advice: String,
}

/// How often it is said at most while nothing else happens: as often as samples are taken in (`hold.rs`) where they come in time; a record that is read
/// faster is not said row by row.
const OFTEN: Duration = Duration::from_millis(20);

enum Event {
    /// Lines that are not understood, or change nothing.
    None,
    Undo(usize),
    Reading(Box<Reading>),
    End,
}

impl Session {
    /// Replay what the journal has, then go on until the guide or the readings end.
    pub fn run(&mut self, entries: Vec<Entry>) -> Result<Option<Ending>> {
        let mut fresh = false;
        let mut replayed: Option<Advice> = None;
        for entry in entries {
            replayed = None;
            match entry {
                Entry::Reading { keys, line, still_sd } => {
                    let reading = lines::reading(keys, &self.campaign, &self.guide, None)?;
                    self.skip_to(line);
                    if let Some(samples) = &mut self.source.samples {
                        samples.resume(still_sd);
                    }
                    self.accept(reading)?;
                    fresh = true;
                }
                Entry::Undone { number, line } => {
                    self.skip_to(line);
                    self.guide.undo(number)?;
                    fresh = false;
                }
                // what is open between steps follows from the advice of each
                Entry::Next(_) => replayed = Some(self.guide.advise(fresh)?),
            }
        }
        loop {
            let advice = match replayed.take() {
                Some(advice) => advice,
                None => {
                    let advice = self.guide.advise(fresh)?;
                    self.journal.append(&Entry::Next(advice.next.as_ref().map(|next| next.set.clone())))?;
                    advice
                }
            };
            self.show(&advice, None)?;
            if advice.ended.is_some() {
                return Ok(advice.ended);
            }
            match self.event(&advice)? {
                None => return Ok(None),
                Some(was_reading) => fresh = was_reading,
            }
        }
    }

    /// The journal has the lines of the followed file up to this one.
    fn skip_to(&mut self, line: Option<usize>) {
        if let (Some(lines), Some(line)) = (&mut self.source.lines, line) {
            lines.skip_to(line);
        }
    }

    fn accept(&mut self, reading: Reading) -> Result<()> {
        self.guide.accept(reading)?;
        self.ever.extend(self.guide.taken().last().cloned());
        Ok(())
    }

    /// The advice; with an error, that the last line was refused.
    fn show(&mut self, advice: &Advice, refused: Option<&Malformed>) -> Result<()> {
        let report = guide_report(advice, refused.map(ToString::to_string));
        if self.json || self.page.is_some() {
            let line = json(&report)?;
            if refused.is_none() {
                self.progress.line_of_advice.clone_from(&line);
            }
            if let Some(page) = &self.page {
                page.publish("step", &line);
            }
            if self.json {
                return cli::print(&(line + "\n"));
            }
        }
        let asked = self.asked(advice);
        if let Some(screen) = &mut self.screen {
            return screen.step(report, asked.as_ref());
        }
        self.progress.line.suspend(|| match refused {
            Some(error) => {
                cli::show_error::show(error);
                Ok(())
            }
            None => cli::show(&view::text(advice, session::language())),
        })
    }

    fn asked(&self, advice: &Advice) -> Option<Reading> {
        let next = advice.next.as_ref()?;
        let same = |r: &&Reading| {
            r.position == next.position && crate::guide::setting(&self.campaign, &r.joints) == next.setting
        };
        self.guide.candidates().iter().find(same).or(self.guide.taken().last()).cloned()
    }

    /// The next accepted reading (true) or undone one (false); `None` at the end of the readings.
    fn event(&mut self, advice: &Advice) -> Result<Option<bool>> {
        let asked = self.asked(advice);
        if self.source.truth.is_some() {
            let Some(asked) = asked else { return Ok(None) };
            return self.simulated(asked);
        }
        let mut refused_before = false;
        loop {
            let Some(lines) = &mut self.source.lines else { return Ok(None) };
            let next = match lines.next()? {
                Next::Line(line) => Some(line),
                Next::End => None,
                #[cfg(feature = "serial")]
                Next::Away(error) => {
                    self.show(advice, Some(&error))?;
                    continue;
                }
                #[cfg(feature = "serial")]
                Next::Back => {
                    self.is_back(advice)?;
                    continue;
                }
            };
            let Some(lines) = &self.source.lines else { return Ok(None) };
            let (line, from) = (next.as_ref().map_or(0, |line| line.number), lines.name.clone());
            let followed = lines.is_file().then_some(line);
            let event = match next {
                Some(line) => self.line(&line, asked.as_ref()),
                None => self.last(asked.as_ref()),
            };
            let still_sd = self.source.samples.as_ref().map_or(&[] as &[f64], Samples::still_sd);
            match event {
                Ok(Event::None) => refused_before = false,
                Ok(Event::End) => return Ok(None),
                Ok(Event::Undo(number)) => {
                    self.journal.append(&Entry::Undone { number, line: followed })?;
                    self.guide.undo(number)?;
                    return Ok(Some(false));
                }
                Ok(Event::Reading(reading)) => {
                    self.journal.append(&Entry::reading(&self.campaign, &reading, followed, still_sd))?;
                    self.accept(*reading)?;
                    return Ok(Some(true));
                }
                // a line that is not understood is said, and the next one is waited for; of many in a row the first
                Err(error) if self.source.samples.is_none() || !refused_before => {
                    refused_before = true;
                    let refused = error.at_line(line, 0).in_file(&from);
                    self.show(advice, Some(&refused))?;
                }
                Err(_) => {}
            }
        }
    }

    /// A source that was away is there again: what it said in between is missing.
    #[cfg(feature = "serial")]
    fn is_back(&mut self, advice: &Advice) -> Result<()> {
        self.source.samples.iter_mut().try_for_each(Samples::interrupt)?;
        let name = self.source.lines.as_ref().map_or("", |lines| &lines.name).to_string();
        let said = say!(session::language(), "guide-port-is-back", name).to_string();
        self.progress.line.suspend(|| cli::note_as_it_is(&said));
        self.show(advice, None)
    }

    /// What a line brings. Errors: it is not understood, or nothing can be done with it.
    fn line(&mut self, read: &Numbered, asked: Option<&Reading>) -> Result<Event> {
        let Some(lines) = &mut self.source.lines else { return Ok(Event::End) };
        let parsed = lines.parse(&read.text, self.source.samples.is_some(), &self.campaign.bench);
        if let (Some(samples), false) = (&mut self.source.samples, read.passed) {
            samples.is_past()?;
        }
        let state = State { campaign: &self.campaign, guide: &self.guide, asked, last: self.ever.last() };
        match (parsed, &mut self.source.samples) {
            // titles among the lines that the journal has, and rows that the clock must have seen
            (Ok(Line::Row), Some(samples)) => {
                let titles = lines.titles.as_deref().unwrap_or_default();
                let step = samples.row(titles, &read.text, read.passed, state)?;
                self.step(step, asked)
            }
            _ if read.passed => Ok(Event::None),
            (Ok(Line::Nothing), _) => Ok(Event::None),
            (Ok(Line::Quit), _) => Ok(Event::End),
            (Ok(Line::Undo(number)), _) => {
                let number = number.unwrap_or(self.guide.taken().len());
                self.guide.clone().undo(number).map(|()| Event::Undo(number))
            }
            (Ok(Line::Keys(cells)), None) => {
                lines::reading(cells, &self.campaign, &self.guide, asked).and_then(|reading| self.accepted(reading))
            }
            (Ok(Line::Take), Some(samples)) => {
                if !samples.holds() {
                    return Err(Malformed::new(Fault::Missing, "there is nothing to take")
                        .expected("a position that is held and is not read yet"));
                }
                let step = samples.look(state, true, false)?;
                self.step(step, asked)
            }
            (Ok(Line::Keys(keys)), Some(samples)) => match samples.name(keys) {
                Some(cells) => self.step(Step::Read(cells), asked),
                None => Ok(Event::None),
            },
            (Ok(Line::Row | Line::Take), None) => Ok(Event::None),
            (Err(error), _) => Err(error),
        }
    }

    /// No more lines come: what the samples hold at their end may be enough.
    fn last(&mut self, asked: Option<&Reading>) -> Result<Event> {
        let state = State { campaign: &self.campaign, guide: &self.guide, asked, last: self.ever.last() };
        let Some(samples) = &mut self.source.samples else { return Ok(Event::End) };
        samples.finish()?;
        let step = samples.look(state, false, true)?;
        Ok(match self.step(step, asked)? {
            Event::Reading(reading) => Event::Reading(reading),
            _ => Event::End,
        })
    }

    fn step(&mut self, step: Step, asked: Option<&Reading>) -> Result<Event> {
        let cells = match step {
            Step::Nothing => return Ok(Event::None),
            Step::Said(held) => return self.tell(held).map(|()| Event::None),
            Step::Read(cells) => cells,
        };
        let state = State { campaign: &self.campaign, guide: &self.guide, asked, last: self.ever.last() };
        let placed = placed(&cells, state)?;
        let Some(samples) = &mut self.source.samples else { return Ok(Event::None) };
        match placed {
            Placed::Here(reading) => {
                samples.open = None;
                self.accepted(reading)
            }
            Placed::Which(candidates) => {
                samples.open = Some(cells);
                let held = Held { candidates, ..Held::nothing(Holding::Which) };
                self.tell(held).map(|()| Event::None)
            }
        }
    }

    fn accepted(&self, reading: Reading) -> Result<Event> {
        self.guide.clone().accept(reading.clone()).map(|()| Event::Reading(Box::new(reading)))
    }

    /// What is held: on the line of the terminal, as a line of JSON, and on the page.
    fn tell(&mut self, held: Held) -> Result<()> {
        let now = Instant::now();
        let soon = |(at, state): (Instant, Holding)| state == held.state && now.duration_since(at) < OFTEN;
        if self.progress.shown.is_some_and(soon) {
            return Ok(());
        }
        self.progress.shown = Some((now, held.state));
        if let Some(page) = &self.page {
            page.replace("held", &json(&held)?);
        }
        if self.json {
            let line = self.progress.line_of_advice.strip_suffix('}').unwrap_or_default();
            return cli::print(&format!("{line},\"held\":{}}}\n", json(&held)?));
        }
        if let Some(screen) = &mut self.screen {
            return screen.held(&held);
        }
        let text = view::held(&held, session::language());
        if matches!(held.state, Holding::Left | Holding::Which) {
            self.progress.line.suspend(|| cli::show(&text))?;
        } else {
            self.progress.line.set_message(text.trim_end().to_string());
            self.progress.line.tick();
        }
        Ok(())
    }

    fn simulated(&mut self, asked: Reading) -> Result<Option<bool>> {
        let Some(truth) = &self.source.truth else { return Ok(None) };
        // all of them from the start: noise and deviations go on where they were
        let rows = self.source.given.iter().chain(&self.ever).map(Reading::unread);
        let mounted = Reading { position: self.guide.label(&asked).into(), ..asked.clone() };
        let rows: Vec<Reading> = rows.chain([mounted]).collect();
        let columns = self.campaign.readings.columns.clone();
        let schedule = self.campaign.with_readings(Readings { columns, rows });
        let all = simulate::simulate(&schedule, truth, self.source.seed)?;
        let Some(reading) = all.readings.rows.last().cloned() else { return Ok(None) };
        let reading = Reading { position: asked.position, ..reading };
        self.journal.append(&Entry::reading(&self.campaign, &reading, None, &[]))?;
        self.accept(reading)?;
        Ok(Some(true))
    }
}
