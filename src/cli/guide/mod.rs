//! `tumble guide CAMPAIGN`: beside the experiment, reading by reading.
//!
//! | file | subject |
//! |---|---|
//! | `journal.rs` | what was accepted and decided, written before it is shown |
//! | `lines.rs` | readings, samples and commands, line by line |
//! | `samples.rs` | what samples become: positions that are held, and their readings |
//! | `view.rs` | the advice for a person |
//! | `serve.rs` | the page beside the table |

mod journal;
mod lines;
mod samples;
mod serve;
mod view;

use super::outputs::Outputs;
use super::{Outcome, catalogue, files, log, plan as options, session};
use crate::campaign::{Campaign, Reading, Readings};
use crate::error::{Fault, Malformed, Result};
use crate::guide::{Advice, Ending, Guide, Held, Holding, Settings};
use crate::language::Language;
use crate::report::{ARCSEC, GuideReport, Input, guide_report};
use crate::simulate::{self, Truth};
use crate::{plan, wire};
use clap::Args;
use journal::{Entry, Journal};
use lines::{Line, Lines, Numbered};
use samples::{Beside, Due, Placed, Samples, Step};
use serve::Page;
use std::net::IpAddr;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// What to calibrate, where readings come from and where they go.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The schedule, whose positions may be asked for; readings that it has are the first.
    campaign: PathBuf,
    /// Where readings come from: a table that grows, or - for standard input (the default). One reading a line: JSON, or CSV after a line of
    /// titles; 'undo', 'undo N' and 'quit' are commands.
    #[arg(long, value_name = "FILE", default_value = "-", conflicts_with = "simulate")]
    readings: PathBuf,
    /// Samples instead, as a logger writes them: a table that grows, or - for standard input; CSV after a line of titles. Standstills (a constant
    /// rate is one) become readings once their mean is as certain as the schedule or --noise says; 'position LABEL', 'take', 'undo', 'undo N' and
    /// 'quit' are commands, on standard input also beside a file.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["readings", "simulate"])]
    samples: Option<PathBuf>,
    #[command(flatten)]
    clock: log::Clock,
    /// Window of the static detector, s, and guard time at both ends of a standstill.
    #[arg(long, default_value_t = 0.5, value_name = "S", value_parser = super::reduce::positive, requires = "samples")]
    window: f64,
    /// Largest variance of a still window, in variances of the still sensor.
    #[arg(long, default_value_t = 4.0, value_name = "RATIO", value_parser = super::reduce::positive, requires = "samples")]
    threshold: f64,
    /// Try it without hardware: readings at the positions asked for, made from a truth (see `simulate`).
    #[arg(long, value_name = "TRUTH")]
    simulate: Option<PathBuf>,
    /// Seed of the simulated readings.
    #[arg(long, default_value_t = 1, value_name = "N", requires = "simulate")]
    seed: u64,
    /// Standard uncertainty that is wanted: 1 (arcsec, every estimated angle), dtheta_y2=0.5, gamma=1 for a derived angle (its unit for a
    /// coefficient).
    #[arg(long, value_name = "[NAME=]U")]
    goal: Vec<String>,
    /// Standard deviation of one sample of a sensor, in its unit, where readings state none: V=9e-4.
    #[arg(long, value_name = "SENSOR=SD")]
    noise: Vec<String>,
    /// Standard deviation in arcsec that is supposed of an estimated tilt without a prior or limits before any reading; 10313 (three degrees) unless
    /// given.
    #[arg(long, value_name = "ARCSEC")]
    tilts: Option<f64>,
    /// What work costs, in any unit: mounting=10, rate=1, reading=1, soak=0, degree=0.
    #[arg(long, value_name = "WHAT=COST")]
    cost: Vec<String>,
    /// Choose from a sweep of the bench's joints in steps of DEG, instead of the schedule's positions.
    #[arg(long, value_name = "DEG")]
    step: Option<f64>,
    /// A catalogue of your own effects, tried beside the built-in ones.
    #[arg(long, value_name = "FILE")]
    effects: Option<PathBuf>,
    /// The most readings.
    #[arg(long, value_name = "N", default_value_t = 200)]
    most: usize,
    /// The campaign that comes out, with the SHA-256 of its journal in its note.
    #[arg(short, long, value_name = "FILE", default_value = "guided.campaign.json")]
    output: PathBuf,
    /// Where every reading and decision is written before it is shown; beside the output unless given.
    #[arg(long, value_name = "FILE")]
    journal: Option<PathBuf>,
    /// Go on from the journal of a guide that ended.
    #[arg(long)]
    resume: bool,
    /// Advice as lines of JSON on standard output, for a program that drives the table: its "next" is answered by a line of --readings.
    #[arg(long, value_name = "-", value_parser = ["-"])]
    json: Option<String>,
    /// Serve a page beside the table, on a port of this machine (any that is free unless given); its address, with a token, is written to the terminal.
    #[arg(long, value_name = "PORT", num_args = 0..=1, default_missing_value = "0")]
    serve: Option<u16>,
    /// Serve it to others: on this address of this machine, 0.0.0.0 for all of them.
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1", requires = "serve")]
    listen: IpAddr,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome> {
    let (campaign, source) = files::campaign(&arguments.campaign)?;
    let located = |error| wire::locate(error, &source);
    files::one_device(&campaign);
    let catalogue = catalogue::catalogue(arguments.effects.as_deref())?;
    let named = |text: &String| options::named_number(text, "--noise", "V=9e-4");
    let settings = Settings {
        goals: options::parse_goals(&arguments.goal, &campaign)?,
        noise: arguments.noise.iter().map(named).collect::<Result<_>>()?,
        costs: options::costs(&arguments.cost)?,
        most: arguments.most,
        tilts: arguments.tilts.map_or(Settings::default().tilts, |arcsec| arcsec / ARCSEC),
        ..Settings::default()
    };
    let candidates = match arguments.step {
        Some(step) => plan::sweep(&campaign, step)?,
        None => campaign.readings.clone(),
    };
    let truth = match &arguments.simulate {
        Some(path) => Some(wire::read_truth(&files::read(path)?, &campaign)?),
        None => None,
    };
    let guide = Guide::new(&campaign, &candidates, &catalogue.effects, settings).map_err(located)?;
    let digest = Input::new("", source.text.as_bytes()).sha256;
    let path = arguments.journal.clone().unwrap_or_else(|| beside(&arguments.output));
    let mut outputs = Outputs::plan([Some(arguments.output.as_path())])?;
    let (journal, entries) = Journal::open(&path, &digest, arguments.resume)?;
    let lines = match (&truth, &arguments.samples) {
        (Some(_), _) => None,
        (None, Some(path)) => Some(Lines::open(path)?.with_commands()),
        (None, None) => Some(Lines::open(&arguments.readings)?),
    };
    let clock = arguments.clock.source();
    let samples = arguments.samples.as_ref().map(|_| Samples::new(clock, arguments.window, arguments.threshold));
    let source = Source { lines, samples, truth, seed: arguments.seed, given: guide.taken().to_vec() };
    let page = arguments.serve.map(|port| Page::open(arguments.listen, port, &campaign.bench)).transpose()?;
    if let Some(page) = &page {
        super::note(&format!("the page: {}", page.address()));
    }
    let line = super::bar(0);
    if let Ok(style) = indicatif::ProgressStyle::with_template("{wide_msg}") {
        line.set_style(style);
    }
    let progress = Progress { line, told: None };
    let json = arguments.json.is_some();
    let mut session = Session { guide, journal, source, campaign, ever: Vec::new(), json, page, progress };
    let ended = session.run(entries)?;
    let mut result = session.guide.campaign();
    let bytes = std::fs::read(&path).unwrap_or_default();
    let name = path.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned());
    let sentence = format!("Taken with tumble guide; journal {name}, SHA-256 {}", Input::new("", &bytes).sha256);
    let note = result.identity.note.take().map_or(sentence.clone(), |note| format!("{note} {sentence}"));
    result.identity.note = Some(note);
    if !result.readings.rows.is_empty() {
        let file = wire::campaign_file(&result, wire::bench_ref(&result));
        outputs.add(&arguments.output, files::marked(&file)?);
        outputs.write()?;
        super::note(&format!("wrote {}", arguments.output.display()));
    }
    Ok(if ended == Some(Ending::Reached) { Outcome::Done } else { Outcome::Rejected })
}

fn json(value: &impl serde::Serialize) -> Result<String> {
    serde_json::to_string(value)
        .map_err(|error| Malformed::new(Fault::Value, format!("the advice cannot be written as JSON: {error}")))
}

fn beside(output: &Path) -> PathBuf {
    let name = output.file_name().map_or("guided".into(), |name| name.to_string_lossy().into_owned());
    let stem = name.strip_suffix(".campaign.json").or(name.strip_suffix(".json")).unwrap_or(&name).to_string();
    output.with_file_name(format!("{stem}.journal.jsonl"))
}

/// What a line of `tumble guide --json -` says to a person, in English.
pub fn guide_text(report: &GuideReport) -> String {
    let text = match &report.held {
        Some(held) => view::held(held, Language::English),
        None => view::text(&report.advice, Language::English),
    };
    crate::report::wrap::lines(&text)
}

/// Where readings come from.
struct Source {
    lines: Option<Lines>,
    /// The lines are samples.
    samples: Option<Samples>,
    truth: Option<Truth>,
    seed: u64,
    /// Readings of the campaign's own file.
    given: Vec<Reading>,
}

struct Session {
    guide: Guide,
    journal: Journal,
    source: Source,
    campaign: Campaign,
    /// Every reading that was accepted, those that were undone among them: what a simulation goes on from.
    ever: Vec<Reading>,
    json: bool,
    page: Option<Page>,
    progress: Progress,
}

/// What is said while a position is held.
struct Progress {
    /// A line of the terminal that is written again and again.
    line: indicatif::ProgressBar,
    told: Option<(Instant, Holding)>,
}

/// How often it is said at most while nothing else happens.
const OFTEN: Duration = Duration::from_millis(250);

/// What a line brought.
enum Event {
    /// Lines that are not understood, or change nothing.
    None,
    Undo(usize),
    Reading(Box<Reading>),
    End,
}

impl Session {
    /// Replay what the journal has, then go on until the guide or the readings end.
    fn run(&mut self, entries: Vec<Entry>) -> Result<Option<Ending>> {
        let mut fresh = false;
        let mut replayed: Option<Advice> = None;
        for entry in entries {
            replayed = None;
            match entry {
                Entry::Reading { keys, line, still_sd } => {
                    let own = lines::reading(keys, &self.campaign, &self.guide, None)?;
                    self.skip_to(line);
                    if let Some(samples) = &mut self.source.samples {
                        samples.resume(still_sd);
                    }
                    self.accept(own)?;
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
    fn show(&self, advice: &Advice, refused: Option<&Malformed>) -> Result<()> {
        if self.json || self.page.is_some() {
            let line = json(&guide_report(advice, refused.map(ToString::to_string)))?;
            if let Some(page) = &self.page {
                page.publish("step", &line);
            }
            if self.json {
                return super::print(&(line + "\n"));
            }
        }
        self.progress.line.suspend(|| match refused {
            Some(error) => {
                super::show_error::show(error);
                Ok(())
            }
            None => super::show(&view::text(advice, session::language())),
        })
    }

    /// The next accepted reading (true) or undone one (false); `None` at the end of the readings.
    fn event(&mut self, advice: &Advice) -> Result<Option<bool>> {
        let asked = advice.next.as_ref().and_then(|next| {
            let same =
                |own: &&Reading| own.position == next.position && view::setting(&self.campaign, own) == next.setting;
            self.guide.candidates().iter().find(same).or(self.guide.taken().last())
        });
        let asked = asked.cloned();
        if self.source.truth.is_some() {
            let Some(asked) = asked else { return Ok(None) };
            return self.simulated(asked);
        }
        let mut refused_before = false;
        loop {
            let Some(lines) = &mut self.source.lines else { return Ok(None) };
            let next = lines.next()?;
            let (line, from) = (next.as_ref().map_or(0, |own| own.number), lines.name().to_string());
            let followed = lines.is_file().then_some(line);
            let event = match next {
                Some(own) => self.line(&own, asked.as_ref(), advice),
                None => self.last(asked.as_ref(), advice),
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
                Ok(Event::Reading(own)) => {
                    self.journal.append(&Entry::reading(&self.campaign, &own, followed, still_sd))?;
                    self.accept(*own)?;
                    return Ok(Some(true));
                }
                // a line that is not understood is said, and the next one is waited for; of many in a row the first
                Err(error) if self.source.samples.is_none() || !refused_before => {
                    refused_before = true;
                    let refused = error.at_line(line, 1).in_file(&from);
                    self.show(advice, Some(&refused))?;
                }
                Err(_) => {}
            }
        }
    }

    /// What a line brings. Errors: it is not understood, or nothing can be done with it.
    fn line(&mut self, own: &Numbered, asked: Option<&Reading>, advice: &Advice) -> Result<Event> {
        let Some(lines) = &mut self.source.lines else { return Ok(Event::End) };
        let bench = &self.campaign.bench;
        let parsed = match &self.source.samples {
            Some(_) => lines.parse_sample(&own.text),
            None => lines.parse(&own.text, bench),
        };
        if let (Some(samples), false) = (&mut self.source.samples, own.passed) {
            samples.is_past()?;
        }
        let beside = Beside { campaign: &self.campaign, guide: &self.guide, asked, last: self.ever.last() };
        match (parsed, &mut self.source.samples) {
            // titles among the lines that the journal has, and rows that the clock must have seen
            (Ok(Line::Row), Some(samples)) if own.passed => {
                samples.row(lines.titles().unwrap_or_default(), &own.text, true, &self.campaign).map(|_| Event::None)
            }
            _ if own.passed => Ok(Event::None),
            (Ok(Line::Nothing), _) => Ok(Event::None),
            (Ok(Line::Quit), _) => Ok(Event::End),
            (Ok(Line::Undo(number)), _) => {
                let number = number.unwrap_or(self.guide.taken().len());
                self.guide.clone().undo(number).map(|()| Event::Undo(number))
            }
            (Ok(Line::Reading(cells)), _) => {
                lines::reading(cells, &self.campaign, &self.guide, asked).and_then(|own| self.accepted(own))
            }
            (Ok(Line::Row), Some(samples)) => {
                let titles = lines.titles().unwrap_or_default();
                match samples.row(titles, &own.text, false, &self.campaign)? {
                    Due::Nothing => Ok(Event::None),
                    due => {
                        let step = samples.look(beside, false, due == Due::Ended)?;
                        self.step(step, asked, advice)
                    }
                }
            }
            (Ok(Line::Take), Some(samples)) => {
                if !samples.holds() {
                    return Err(Malformed::new(Fault::Missing, "there is nothing to take")
                        .expected("a position that is held and is not read yet"));
                }
                let step = samples.look(beside, true, false)?;
                self.step(step, asked, advice)
            }
            (Ok(Line::Position(keys)), Some(samples)) => match samples.name(keys) {
                Some(cells) => self.step(Step::Read(cells), asked, advice),
                None => Ok(Event::None),
            },
            (Ok(Line::Row | Line::Take | Line::Position(_)), None) => Ok(Event::None),
            (Err(error), _) => Err(error),
        }
    }

    /// No more lines come: what the samples hold at their end may be enough.
    fn last(&mut self, asked: Option<&Reading>, advice: &Advice) -> Result<Event> {
        let beside = Beside { campaign: &self.campaign, guide: &self.guide, asked, last: self.ever.last() };
        let Some(samples) = &mut self.source.samples else { return Ok(Event::End) };
        samples.finish()?;
        let step = samples.look(beside, false, true)?;
        Ok(match self.step(step, asked, advice)? {
            Event::Reading(own) => Event::Reading(own),
            _ => Event::End,
        })
    }

    /// What the samples say.
    fn step(&mut self, step: Step, asked: Option<&Reading>, advice: &Advice) -> Result<Event> {
        let cells = match step {
            Step::Nothing => return Ok(Event::None),
            Step::Said(held) => return self.tell(advice, held).map(|()| Event::None),
            Step::Read(cells) => cells,
        };
        let beside = Beside { campaign: &self.campaign, guide: &self.guide, asked, last: self.ever.last() };
        let placed = samples::placed(&cells, beside)?;
        let Some(samples) = &mut self.source.samples else { return Ok(Event::None) };
        match placed {
            Placed::Here(own) => {
                samples.ask(None);
                self.accepted(own)
            }
            Placed::Which(candidates) => {
                samples.ask(Some(cells));
                let held = Held { candidates, ..Held::nothing(Holding::Which) };
                self.tell(advice, held).map(|()| Event::None)
            }
        }
    }

    /// A reading that the guide takes.
    fn accepted(&self, own: Reading) -> Result<Event> {
        self.guide.clone().accept(own.clone()).map(|()| Event::Reading(Box::new(own)))
    }

    /// What is held: on the line of the terminal, as a line of JSON, and on the page.
    fn tell(&mut self, advice: &Advice, held: Held) -> Result<()> {
        let now = Instant::now();
        let soon = |(at, state): (Instant, Holding)| state == held.state && now.duration_since(at) < OFTEN;
        if self.progress.told.is_some_and(soon) {
            return Ok(());
        }
        self.progress.told = Some((now, held.state));
        if let Some(page) = &self.page {
            page.replace("held", &json(&held)?);
        }
        if self.json {
            return super::print(&(json(&GuideReport { held: Some(held), ..guide_report(advice, None) })? + "\n"));
        }
        let text = view::held(&held, session::language());
        if matches!(held.state, Holding::Left | Holding::Which) {
            self.progress.line.suspend(|| super::show(&text))?;
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
        let mounted = Reading { position: self.guide.label(&asked), ..asked.clone() };
        let rows: Vec<Reading> = rows.chain([mounted]).collect();
        let columns = self.campaign.readings.columns.clone();
        let schedule = self.campaign.with_readings(Readings { columns, rows });
        let all = simulate::simulate(&schedule, truth, self.source.seed)?;
        let Some(own) = all.readings.rows.last().cloned() else { return Ok(None) };
        let own = Reading { position: asked.position, ..own };
        self.journal.append(&Entry::reading(&self.campaign, &own, None, &[]))?;
        self.accept(own)?;
        Ok(Some(true))
    }
}
