//! The command line: the only room that reads files, writes files and prints.
//!
//! Results go to stdout, progress, notes and errors to stderr. Exit codes: 0 done; 1 the question is malformed; 2 done, and the answer is
//! "rejected" (rank defect, failed global test, missing effect).
#![deny(clippy::print_stdout, clippy::print_stderr)] // both panic where nobody listens

mod bench;
mod check;
mod compare;
mod diagnose;
mod files;
mod fit;
mod navigate;
mod navigate_diagnose;
mod outputs;
mod pages;
mod plan;
mod session;
mod show_error;
mod simulate;

use crate::error::{Fault, Malformed, Result};
use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Calibrate inertial sensors from multi-position tests.
#[derive(Debug, Parser)]
#[command(name = "tumble", version, about, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Let an output replace an existing campaign, bench or other file that is no report.
    #[arg(long, global = true)]
    force: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Estimate every angle and coefficient of a campaign, each with its uncertainty.
    Fit(fit::Arguments),
    /// The same angles by the published closed forms, side by side with least squares and the printed table.
    Compare(compare::Arguments),
    /// Find where simulation and measurement disagree, name the missing effect, add it, show the gap shrink.
    Diagnose(diagnose::Arguments),
    /// Readings from a schedule and a truth, with seeded noise and hidden effects.
    Simulate(simulate::Arguments),
    /// What calibration errors do to a strapdown navigator over hours.
    Navigate(navigate::Arguments),
    /// How well a schedule will do before anyone measures, and the best positions to choose or add.
    Plan(Box<plan::Arguments>),
    /// Built-in benches: list them, or show one as a file.
    #[command(subcommand)]
    Bench(bench::Arguments),
    /// Check bench and campaign files without fitting anything.
    Check(check::Arguments),
    /// Print the JSON Schema of a kind of file.
    Schema(check::SchemaArguments),
}

/// How a command that could be carried out ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Outcome {
    /// Exit code 0.
    Done,
    /// Exit code 2: the answer is "rejected".
    Rejected,
}

/// Run the program with the arguments of the process.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            let malformed = error.use_stderr();
            // printing can fail only where there is no terminal left to tell
            let _ = error.print();
            return ExitCode::from(u8::from(malformed));
        }
    };
    if cli.force {
        session::allow_replacing();
    }
    match run(cli.command) {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Rejected) => ExitCode::from(2),
        Err(error) => {
            show_error::show(&error);
            ExitCode::from(1)
        }
    }
}

fn run(command: Command) -> Result<Outcome> {
    match command {
        Command::Fit(arguments) => fit::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Diagnose(arguments) => diagnose::run(&arguments),
        Command::Simulate(arguments) => simulate::run(&arguments),
        Command::Navigate(arguments) => navigate::run(&arguments),
        Command::Plan(arguments) => plan::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Schema(arguments) => check::run_schema(&arguments),
    }
}

/// Print to stdout; a reader that has gone away (`tumble ... | head`) is no error, a full disk is one.
fn print(text: &str) -> Result<()> {
    use std::io::Write;
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).or_else(outputs::reader_left).map_err(|error| {
        Malformed::new(Fault::File, format!("cannot write to standard output: {error}"))
            .expected("a terminal, a file or a pipe that takes the whole text")
    })
}

/// Print a line to stderr; where nobody listens there is nobody to tell.
fn note(text: &str) {
    use std::io::Write;
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}
