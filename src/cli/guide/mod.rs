//! `tumble guide CAMPAIGN`: beside the experiment, reading by reading.
//!
//! | file | subject |
//! |---|---|
//! | `journal.rs` | what was accepted and decided, written before it is shown |
//! | `lines.rs` | readings and commands, line by line |
//! | `view.rs` | the advice for a person |
//! | `serve.rs` | the page beside the table |

mod journal;
mod lines;
mod serve;
mod view;

use super::outputs::Outputs;
use super::{Outcome, catalogue, files, plan as options, session};
use crate::campaign::{Campaign, Reading, Readings};
use crate::error::{Fault, Malformed, Result};
use crate::guide::{Advice, Ending, Guide, Settings};
use crate::report::{ARCSEC, Input, guide_report};
use crate::simulate::{self, Truth};
use crate::{plan, wire};
use clap::Args;
use journal::{Entry, Journal};
use lines::{Line, Lines};
use serve::Page;
use std::net::IpAddr;
use std::path::{Path, PathBuf};

/// What to calibrate, where readings come from and where they go.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The schedule, whose positions may be asked for; readings that it has are the first.
    campaign: PathBuf,
    /// Where readings come from: a table that grows, or - for standard input (the default). One reading a line: JSON, or CSV after a line of
    /// titles; 'undo', 'undo N' and 'quit' are commands.
    #[arg(long, value_name = "FILE", default_value = "-", conflicts_with = "simulate")]
    readings: PathBuf,
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
    let readings = if truth.is_some() { None } else { Some(Lines::open(&arguments.readings)?) };
    let source = Source { lines: readings, truth, seed: arguments.seed, given: guide.taken().to_vec() };
    let page = arguments.serve.map(|port| Page::open(arguments.listen, port, &campaign.bench)).transpose()?;
    if let Some(page) = &page {
        super::note(&format!("the page: {}", page.address()));
    }
    let mut session =
        Session { guide, journal, source, campaign, ever: Vec::new(), json: arguments.json.is_some(), page };
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

fn beside(output: &Path) -> PathBuf {
    let name = output.file_name().map_or("guided".into(), |name| name.to_string_lossy().into_owned());
    let stem = name.strip_suffix(".campaign.json").or(name.strip_suffix(".json")).unwrap_or(&name).to_string();
    output.with_file_name(format!("{stem}.journal.jsonl"))
}

/// Where readings come from.
struct Source {
    lines: Option<Lines>,
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
}

impl Session {
    /// Replay what the journal has, then go on until the guide or the readings end.
    fn run(&mut self, entries: Vec<Entry>) -> Result<Option<Ending>> {
        let mut fresh = false;
        let mut replayed: Option<Advice> = None;
        for entry in entries {
            replayed = None;
            match entry {
                Entry::Reading { keys, line } => {
                    let own = lines::reading(keys, &self.campaign, &self.guide, None)?;
                    self.skip_to(line);
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
            let report = guide_report(advice, refused.map(ToString::to_string));
            let line = serde_json::to_string(&report).map_err(|error| {
                Malformed::new(Fault::Value, format!("the advice cannot be written as JSON: {error}"))
            })?;
            if let Some(page) = &self.page {
                page.publish("step", &line);
            }
            if self.json {
                return super::print(&(line + "\n"));
            }
        }
        match refused {
            Some(error) => super::show_error::show(error),
            None => super::show(&view::text(advice, session::language()))?,
        }
        Ok(())
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
        loop {
            let Some(lines) = &mut self.source.lines else { return Ok(None) };
            let (line, text) = match lines.next(&self.campaign.bench)? {
                None => return Ok(None),
                Some(own) => own,
            };
            let followed = lines.is_file().then_some(line);
            let event = match lines.parse(&text, &self.campaign.bench) {
                Ok(Line::Nothing) => continue,
                Ok(Line::Quit) => return Ok(None),
                Ok(Line::Undo(number)) => {
                    let number = number.unwrap_or(self.guide.taken().len());
                    let undone = self.guide.clone().undo(number);
                    undone.map(|()| (Entry::Undone { number, line: followed }, None))
                }
                Ok(Line::Reading(cells)) => {
                    let read = lines::reading(cells, &self.campaign, &self.guide, asked.as_ref());
                    let accepted = read.and_then(|own| self.guide.clone().accept(own.clone()).map(|()| own));
                    accepted.map(|own| (Entry::reading(&self.campaign, &own, followed), Some(own)))
                }
                Err(error) => Err(error),
            };
            match event {
                Ok((entry, reading)) => {
                    self.journal.append(&entry)?;
                    match (entry, reading) {
                        (Entry::Undone { number, .. }, _) => self.guide.undo(number)?,
                        (_, Some(own)) => {
                            self.accept(own)?;
                            return Ok(Some(true));
                        }
                        _ => {}
                    }
                    return Ok(Some(false));
                }
                // a line that is not understood is said, and the next one is waited for
                Err(error) => {
                    let refused = error.at_line(line, 1).in_file(lines.name());
                    self.show(advice, Some(&refused))?;
                }
            }
        }
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
        self.journal.append(&Entry::reading(&self.campaign, &own, None))?;
        self.accept(own)?;
        Ok(Some(true))
    }
}
