//! The command line: the only module that reads files, writes files and prints.
//!
//! Results go to stdout, progress, notes and errors to stderr. Exit codes: 0 done; 1 the question is malformed; 2 done, and the answer is
//! "rejected" (rank defect, failed global test, missing effect).
#![deny(clippy::print_stdout, clippy::print_stderr)] // both panic where nobody listens

mod apply;
mod batch;
mod bench;
mod calibrations;
mod check;
mod compare;
mod devices;
mod diagnose;
mod export;
mod files;
mod fit;
mod guide;
mod help;
mod navigate;
mod new;
mod noise;
mod outputs;
mod pages;
mod plan;
mod reduce;
mod rows;
mod session;
mod show_error;
mod simulate;
mod written;

pub use guide::{guide_screen, guide_text};
pub use rows::write_table;
pub use session::{Printed, converse, run_embedded};
pub use show_error::explain;

use crate::error::{Fault, Malformed, Result};
use crate::language::Language;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Parser, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};
use std::process::ExitCode;

/// Calibrate inertial sensors from multi-position tests.
#[derive(Debug, Parser)]
#[command(name = "tumble", version, about, max_term_width = 80, after_help = help::PROGRAM)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Allow an output to replace an existing file that is not a report (a campaign, a bench); `new` replaces none.
    #[arg(long, global = true)]
    force: bool,
    /// Language of tables, pages, certificates and notes. JSON and error messages are in English.
    #[arg(long, global = true, value_name = "CODE", default_value = "en", value_parser = language())]
    lang: Language,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Estimate every angle and coefficient of a campaign, each with its uncertainty.
    #[command(after_help = help::FIT)]
    Fit(fit::Arguments),
    /// Compare least squares with the published closed forms; or two calibrations of one unit, or the history of many.
    #[command(after_help = help::COMPARE)]
    Compare(compare::Arguments),
    /// Correct a record with a calibration.
    Apply(apply::Arguments),
    /// Write a calibration's correction as source code, or for another program.
    Export(export::Arguments),
    /// Find where simulation and measurement disagree, identify the missing effect, and show the residuals decrease with it in the model.
    #[command(after_help = help::DIAGNOSE)]
    Diagnose(diagnose::Arguments),
    /// Readings from a schedule and a truth, with seeded noise and hidden effects.
    #[command(after_help = help::SIMULATE)]
    Simulate(simulate::Arguments),
    /// Propagate calibration errors through a strapdown navigator over hours.
    #[command(after_help = help::NAVIGATE)]
    Navigate(navigate::Arguments),
    /// Predict the uncertainties of a schedule before it is measured; find the best positions to choose or add.
    #[command(after_help = help::PLAN)]
    Plan(Box<plan::Arguments>),
    /// Guide an experiment as it runs: check each reading, propose the next position, say when to stop.
    #[command(after_help = help::GUIDE, arg = help::no_language())]
    Guide(Box<guide::Arguments>),
    /// Reduce a logger's samples to readings: segments, means, and uncertainties that are valid for correlated noise.
    Reduce(Box<reduce::Arguments>),
    /// Allan deviations of a record at rest, and its noise coefficients (IEEE Std 952) with uncertainties.
    Noise(noise::Arguments),
    /// Built-in benches: list them, or show one as a file.
    #[command(subcommand, after_help = help::BENCH, arg = help::no_language().global(true))]
    Bench(bench::Arguments),
    /// Bench and campaign for a table of readings or a logger's record; a lab file for certificates.
    #[command(after_help = help::NEW, arg = help::no_language().global(true))]
    New(Box<new::Arguments>),
    /// Check bench and campaign files without fitting anything.
    #[command(after_help = help::CHECK, arg = help::no_language())]
    Check(check::Arguments),
    /// Print the JSON Schema of a kind of file.
    #[command(arg = help::no_language())]
    Schema(check::SchemaArguments),
    /// Print a completion script for a shell.
    #[command(after_help = help::COMPLETIONS, arg = help::no_language())]
    Completions(help::CompletionsArguments),
    /// Print the manual page of the program, or of one command.
    #[command(after_help = help::MAN, arg = help::no_language())]
    Man(help::ManArguments),
}

/// How a command that could be carried out ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Outcome {
    Done,
    /// Exit code 2: the answer is "rejected".
    Rejected,
}

/// Run the program with the arguments of the process.
pub fn main() -> ExitCode {
    let code = match Cli::try_parse() {
        Ok(cli) => execute(cli).0,
        Err(error) => match (error.use_stderr(), error.print().or_else(session::reader_left)) {
            // an error that cannot be told still has its exit code
            (malformed, Ok(())) | (malformed @ true, Err(_)) => u8::from(malformed),
            (false, Err(error)) => {
                show_error::show(&not_printed(&error));
                1
            }
        },
    };
    ExitCode::from(code)
}

/// Carry out a command: its exit code, and what was malformed, which is shown.
fn execute(cli: Cli) -> (u8, Option<Malformed>) {
    session::with(|session| session.force |= cli.force);
    match run(cli.command, cli.lang) {
        Ok(Outcome::Done) => (0, None),
        Ok(Outcome::Rejected) => (2, None),
        Err(error) => {
            show_error::show(&error);
            (1, Some(error))
        }
    }
}

fn language() -> impl TypedValueParser<Value = Language> {
    one_of(Language::ALL.map(|language| (language.code(), language)))
}

/// One of a few values by its name.
fn one_of<T: Clone + Send + Sync + 'static>(
    values: impl Into<Vec<(&'static str, T)>>,
) -> impl TypedValueParser<Value = T> {
    let (names, values): (Vec<&'static str>, Vec<T>) = values.into().into_iter().unzip();
    let place = names.clone();
    // the parser before it lets no other name pass
    PossibleValuesParser::new(names).try_map(move |name| {
        let value = place.iter().position(|value| *value == name).and_then(|k| values.get(k));
        value.cloned().ok_or("no such value")
    })
}

/// The commands whose results are shown in every language.
const TRANSLATED: &str = "fit, compare, apply, export, diagnose, simulate, navigate, plan, reduce, noise";

fn run(command: Command, lang: Language) -> Result<Outcome> {
    use Command::{Bench, Check, Completions, Guide, Man, New, Schema};
    let english = matches!(command, Bench(_) | Guide(_) | New(_) | Check(_) | Schema(_) | Completions(_) | Man(_));
    if english && lang != Language::English {
        return Err(Malformed::new(Fault::Value, format!("this command has no '--lang {}'", lang.code()))
            .expected(format!("one of the commands that have it: {TRANSLATED}")));
    }
    session::with(|session| session.language = lang);
    match command {
        Command::Fit(arguments) => fit::run(&arguments, lang),
        Command::Compare(arguments) => compare::run(&arguments, lang),
        Command::Apply(arguments) => apply::run(&arguments),
        Command::Export(arguments) => export::run(&arguments),
        Command::Diagnose(arguments) => diagnose::run(&arguments, lang),
        Command::Simulate(arguments) => simulate::run(&arguments),
        Command::Navigate(arguments) => navigate::run(&arguments, lang),
        Command::Reduce(arguments) => reduce::run(&arguments, lang),
        Command::Noise(arguments) => noise::run(&arguments, lang),
        Command::Plan(arguments) => plan::run(&arguments, lang),
        Guide(arguments) => guide::run(&arguments),
        Bench(arguments) => bench::run(&arguments, lang),
        New(arguments) => new::run(&arguments),
        Check(arguments) => check::run(&arguments),
        Schema(arguments) => check::run_schema(&arguments),
        Completions(arguments) => help::completions(&arguments),
        Man(arguments) => help::man(&arguments),
    }
}

/// Print to stdout; a reader that has gone away (`tumble ... | head`) is no error, a full disk is one.
fn print(text: &str) -> Result<()> {
    use std::io::Write;
    let mut out = Visible::default();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).or_else(session::reader_left).map_err(|e| not_printed(&e))
}

/// A report for a person: lines within the width of a terminal.
fn show(text: &str) -> Result<()> {
    print(&crate::document::wrap::lines(text))
}

fn not_printed(error: &std::io::Error) -> Malformed {
    Malformed::new(Fault::File, format!("cannot write to standard output: {error}"))
        .expected("a terminal, a file or a pipe that takes the whole text")
}

/// A text without what would steer a terminal.
fn visible(text: &str) -> std::borrow::Cow<'_, str> {
    if !text.contains(|c: char| c.is_control() && !matches!(c, '\n' | '\t' | '\r')) {
        return text.into();
    }
    let mut bytes = text.as_bytes().to_vec();
    mark(&mut bytes, &mut false);
    // marks are characters
    String::from_utf8_lossy(&bytes).into_owned().into()
}

/// What would steer a terminal, a control character of a user's name, becomes a mark as long in bytes of UTF-8; `lead`: was the byte before the first of such
/// a character of two?
fn mark(bytes: &mut [u8], lead: &mut bool) {
    for byte in bytes {
        let current = *byte;
        match current {
            b'\n' | b'\t' | b'\r' => {}
            0..0x20 | 0x7f => *byte = b'?',
            0x80..0xa0 if *lead => *byte = 0xbf,
            _ => {}
        }
        *lead = current == 0xc2;
    }
}

/// Stdout, without what would steer a terminal; was the byte before the first of such a character of two?
#[derive(Default)]
struct Visible(bool);

impl std::io::Write for Visible {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let mut marked = bytes.to_vec();
        mark(&mut marked, &mut self.0);
        session::Stdout.write_all(&marked)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        session::Stdout.flush()
    }
}

/// May stderr have colours? (<https://no-color.org>)
fn colours() -> bool {
    use std::io::IsTerminal;
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    std::io::stderr().is_terminal() && !set("NO_COLOR") && !is_dumb()
}

/// A bar on stderr with what its template shows; it is not drawn where stderr is no terminal, or a dumb one.
fn bar(length: u64, template: &str) -> ProgressBar {
    let bar = if is_dumb() { ProgressBar::hidden() } else { ProgressBar::new(length) };
    match ProgressStyle::with_template(template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// Is the terminal one that knows neither colours nor a cursor?
fn is_dumb() -> bool {
    std::env::var_os("TERM").is_some_and(|term| term == "dumb")
}

/// Print a line to stderr, once. A closed stderr is ignored.
fn note(text: &str) {
    let text = crate::document::wrap::lines(&session::language().name(text));
    if session::with(|session| session.noted.insert(text.clone())) {
        note_as_it_is(&text);
    }
}

/// The same for a text whose lines must stay: an error with its place marked below the line.
fn note_as_it_is(text: &str) {
    use std::io::Write;
    if !session::notes(text) {
        let _ = writeln!(std::io::stderr().lock(), "{text}");
    }
}
