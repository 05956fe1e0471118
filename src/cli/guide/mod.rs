//! `tumble guide CAMPAIGN`: beside the experiment, reading by reading.
//!
//! | file | subject |
//! |---|---|
//! | `journal.rs` | what was accepted and decided, written before it is shown |
//! | `lines.rs`, `port.rs` | readings, samples and commands, line by line, and where they belong; from a serial port |
//! | `table.rs`, `samples.rs` | rows of samples; what they become: positions that are held, and their readings |
//! | `events.rs` | from line to line: what is accepted, and what is said |
//! | `view.rs`, `screen.rs` | the advice for a person: as lines, and as one screen |
//! | `serve.rs` | the page beside the table |

mod events;
mod journal;
mod lines;
#[cfg(feature = "serial")]
mod port;
mod samples;
mod screen;
mod serve;
mod table;
mod view;

use super::outputs::Outputs;
use super::{Outcome, files, plan as options};
use crate::error::{Fault, Malformed, Result};
use crate::guide::{Ending, Guide, Settings};
use crate::language::Language;
use crate::report::{ARCSEC, GuideReport, Input};
use crate::{plan, wire};
use clap::Args;
use events::{Progress, Session, Source};
use journal::Journal;
use lines::Lines;
use samples::Samples;
use screen::Screen;
pub use screen::guide_screen;
use serve::Page;
use std::net::IpAddr;
use std::path::{Path, PathBuf};

/// What to calibrate, where readings come from and where they go.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The schedule: the positions that may be proposed; readings that it contains are used as the first.
    campaign: PathBuf,
    /// Where readings come from: a table that grows, or - for standard input (the default). One reading a line: JSON, or CSV after a line of
    /// titles; 'undo', 'undo N' and 'quit' are commands.
    #[arg(long, value_name = "FILE", default_value = "-", conflicts_with = "simulate")]
    readings: PathBuf,
    /// Samples instead, as a logger writes them: a table that grows, or - for standard input; CSV after a line of titles. Standstills (also at a
    /// constant rate) become readings when u of their mean is that of the schedule or of --noise; 'position LABEL', 'take', 'undo', 'undo N'
    /// and 'quit' are commands, on standard input also if FILE is a file.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["readings", "simulate"], group = "stream")]
    samples: Option<PathBuf>,
    /// Samples from a serial port, with its bit rate (115200 unless given): /dev/ttyUSB0:57600, COM3. Commands come from standard input. If the
    /// cable is unplugged, the program waits for the port.
    #[cfg(feature = "serial")]
    #[arg(long, value_name = "PORT[:BAUD]", conflicts_with_all = ["readings", "samples", "simulate"], group = "stream")]
    serial: Option<String>,
    /// Titles of the samples' columns, where the source says none: t_s,X,Y,Z.
    #[arg(long, value_name = "TITLES", requires = "stream")]
    titles: Option<String>,
    #[command(flatten)]
    clock: files::Clock,
    /// Window of the static detector, s, and guard time at both ends of a standstill.
    #[arg(long, default_value_t = 0.5, value_name = "S", value_parser = super::reduce::positive, requires = "stream")]
    window: f64,
    /// Largest variance of a static window, as a multiple of the variance of the sensor at rest.
    #[arg(long, default_value_t = 4.0, value_name = "RATIO", value_parser = super::reduce::positive, requires = "stream")]
    threshold: f64,
    /// Without hardware: readings at the proposed positions are simulated from a truth (see `simulate`).
    #[arg(long, value_name = "TRUTH")]
    simulate: Option<PathBuf>,
    /// Seed of the simulated readings.
    #[arg(long, default_value_t = 1, value_name = "N", requires = "simulate")]
    seed: u64,
    /// Required standard uncertainty: 1 (arcsec, every estimated angle), dtheta_y2=0.5, gamma=1 for a derived angle (its unit for a
    /// coefficient).
    #[arg(long, value_name = "[NAME=]U")]
    goal: Vec<String>,
    /// Standard deviation of one sample of a sensor, in its unit, where readings state none: V=9e-4.
    #[arg(long, value_name = "SENSOR=SD")]
    noise: Vec<String>,
    /// Standard deviation in arcsec assumed for an estimated tilt without a prior or limits before the first reading; 10313 (three degrees) unless
    /// given.
    #[arg(long, value_name = "ARCSEC")]
    tilts: Option<f64>,
    /// Costs, in any unit: mounting=10, rate=1, reading=1, soak=0, degree=0.
    #[arg(long, value_name = "WHAT=COST")]
    cost: Vec<String>,
    /// Choose from a sweep of the bench's joints in steps of DEG, instead of the schedule's positions.
    #[arg(long, value_name = "DEG")]
    step: Option<f64>,
    /// A catalogue of further effects, tried in addition to the built-in ones.
    #[arg(long, value_name = "FILE")]
    effects: Option<PathBuf>,
    /// Largest number of readings.
    #[arg(long, value_name = "N", default_value_t = 200)]
    most: usize,
    /// The resulting campaign, with the SHA-256 of its journal in its note.
    #[arg(short, long, visible_alias = "out", value_name = "FILE", default_value = "guided.campaign.json")]
    output: PathBuf,
    /// File to which every reading and decision is written before it is shown; by default in the folder of the output.
    #[arg(long, value_name = "FILE")]
    journal: Option<PathBuf>,
    /// Continue from the journal of a guide that ended.
    #[arg(long)]
    resume: bool,
    /// Advice as lines of JSON on standard output, for a program that controls the table: it answers "next" with a line of --readings.
    #[arg(long, value_name = "-", value_parser = ["-"])]
    json: Option<String>,
    /// Show everything on one screen of the terminal: the bench in the position to set, the goals, the residuals and what may be missing.
    #[arg(long, conflicts_with = "json")]
    view: bool,
    /// Also show the experiment on a web page, on a port of this machine (a free one unless given); its address, with a token, is written to the terminal.
    #[arg(long, value_name = "PORT", num_args = 0..=1, default_missing_value = "0")]
    serve: Option<u16>,
    /// Make the page accessible to other machines: on this address of this machine, 0.0.0.0 for all addresses.
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1", requires = "serve")]
    listen: IpAddr,
}

impl Arguments {
    fn stream(&self) -> Result<Option<Lines>> {
        #[cfg(feature = "serial")]
        if let Some(port) = &self.serial {
            return Lines::port(port).map(Some);
        }
        self.samples.as_deref().map(Lines::open).transpose()
    }
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome> {
    let (campaign, source, _) = files::campaign(&arguments.campaign)?;
    // before anything is written
    let screen = arguments.view.then(|| Screen::open(&campaign.bench)).transpose()?;
    let located = |error| wire::locate(error, &source);
    files::one_device(&campaign);
    let catalogue = files::catalogue(arguments.effects.as_deref())?;
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
    let truth = arguments.simulate.as_ref().map(|path| wire::read_truth(&files::read(path)?, &campaign)).transpose()?;
    let guide = Guide::new(&campaign, &candidates, &catalogue.effects, settings).map_err(located)?;
    let digest = Input::new("", source.text.as_bytes()).sha256;
    let path = arguments.journal.clone().unwrap_or_else(|| journal_of(&arguments.output));
    // a source that cannot be had leaves no journal behind
    let stream = arguments.stream()?;
    let mut outputs = Outputs::plan([Some(arguments.output.as_path())])?;
    let (journal, entries) = Journal::open(&path, &digest, arguments.resume)?;
    let (clock, is_stream) = (arguments.clock.source(), stream.is_some());
    let lines = match (&truth, stream) {
        (Some(_), _) => None,
        (None, Some(mut lines)) => {
            lines.titles.clone_from(&arguments.titles);
            Some(lines.with_commands())
        }
        (None, None) => Some(Lines::open(&arguments.readings)?),
    };
    let samples = is_stream.then(|| Samples::new(clock, arguments.window, arguments.threshold));
    let source = Source { lines, samples, truth, seed: arguments.seed, given: guide.taken().to_vec() };
    let page = arguments.serve.map(|port| Page::open(arguments.listen, port, &campaign.bench)).transpose()?;
    if let Some(page) = &page {
        super::note(&format!("the page: {}", page.address));
    }
    let line = super::bar(0, "{wide_msg}");
    if !line.is_hidden() {
        line.set_draw_target(indicatif::ProgressDrawTarget::stderr_with_hz(50));
    }
    let progress = Progress { line, shown: None, line_of_advice: String::new() };
    let json = arguments.json.is_some();
    let mut session = Session { guide, journal, source, campaign, ever: Vec::new(), json, page, screen, progress };
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

fn journal_of(output: &Path) -> PathBuf {
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
    crate::document::wrap::lines(&text)
}
