//! The text below a command's `--help`: examples and exit codes; `tumble completions SHELL` and `tumble man [COMMAND]`.

use super::{Cli, Outcome};
use crate::error::{Fault, Malformed, Result};
use clap::{Args, CommandFactory};

/// `--lang` for a command that has nothing to say in a language: accepted where the others have it, but not shown.
pub(super) fn no_language() -> clap::Arg {
    clap::Arg::new("lang").long("lang").hide(true).default_value("en").value_parser(super::language())
}

/// The program.
pub(super) const PROGRAM: &str = "Examples:
  tumble bench list
  tumble fit table1.campaign.json --html table1.html
  tumble diagnose table1.campaign.json
  tumble plan schedule.campaign.json --noise V=9e-4

Exit codes:
  0  done
  1  an input is malformed (a file, an option, a value), or a result cannot be written
  2  done, with a negative result: an unknown is not estimable, a global test failed, an effect is missing

Languages: --lang zh shows tables, pages, certificates and notes in Chinese. JSON is the same in every language; error messages are in
English.

No colours are used if NO_COLOR is set, TERM is dumb, or the output is not a terminal.";

pub(super) const FIT: &str = "Examples:
  tumble fit table1.campaign.json
  tumble fit table1.campaign.json --budget --readings
  tumble fit table1.campaign.json --html report.html --json report.json
  tumble fit table1.campaign.json --json - | jq .parameters
  tumble fit gyro.campaign.json --readings today.csv
  tumble fit gyro.campaign.json --by serial --readings 'runs/*.parquet' --to devices.parquet --html line.html

Exit codes: 0 done; 1 an input is malformed; 2 an unknown is not estimable or its uncertainty cannot be evaluated, the
global test failed, or conformity with a limit fails or is undecided; with many devices: one of these for at least one device, or
a malformed device.";

pub(super) const COMPARE: &str = "Examples:
  tumble compare table1.campaign.json --html compare.html
  tumble compare before.fit.json after.fit.json

Exit codes: 0 done (two calibrations: no change beyond the uncertainties); 1 an input is malformed, or this bench has no
published closed forms; 2 the unit has changed.";

pub(super) const DIAGNOSE: &str = "A mission's errors are along the body axes x right, y forward, z up; measured errors are east, north, up (navigate --help).

Examples:
  tumble diagnose table1.campaign.json
  tumble diagnose table1.campaign.json --effects mine.effects.json --html gap.html
  tumble diagnose table1.campaign.json --write-model repaired.bench.json
  tumble diagnose gyro.campaign.json --by serial --to effects.csv
  tumble diagnose sea.mission.json --measured errors.csv

Exit codes: 0 nothing is missing; 1 an input is malformed; 2 effects were found, or the residuals are unexplained.";

pub(super) const SIMULATE: &str = "Examples:
  tumble simulate schedule.campaign.json --truth unit.truth.json > measured.campaign.json
  tumble simulate schedule.campaign.json --truth unit.truth.json --seed 7 --output measured.campaign.json

Exit codes: 0 done; 1 an input is malformed, or the output exists (--force replaces it).";

pub(super) const NAVIGATE: &str = "The navigator's body axes are x right, y forward, z up: the axes of all errors in a mission, of pitch (about x, nose up) and
roll (about y, right side down). The heading is counted clockwise from north to y. The navigation frame is east, north, up.

Examples:
  tumble navigate sea.mission.json --html errors.html
  tumble navigate sea.mission.json --csv errors.csv --json report.json
  tumble navigate sea.mission.json --measured errors.csv --noise-m 5

Exit codes: 0 done; 1 an input is malformed.";

pub(super) const PLAN: &str = "Examples:
  tumble plan schedule.campaign.json --noise V=9e-4
  tumble plan schedule.campaign.json --noise V=9e-4 --add 4
  tumble plan schedule.campaign.json --noise V=9e-4 --goal 1 --cheapest --write better.campaign.json
  tumble plan schedule.campaign.json --noise V=9e-4 --separate a_S a_S^2

Exit codes: 0 done; 1 an input is malformed; 2 an unknown is not estimable, or a goal is not reached.";

pub(super) const GUIDE: &str = "Examples:
  tumble guide schedule.campaign.json --simulate unit.truth.json --goal 1
  tumble guide schedule.campaign.json --noise V=9e-4 --goal dtheta_y2=0.5
  tumble guide schedule.campaign.json --noise V=9e-4 --readings table.csv
  tumble guide schedule.campaign.json --noise V=2e-5 --samples log.csv --rate 1000
  tumble guide schedule.campaign.json --noise V=9e-4 --json -
  tumble guide schedule.campaign.json --noise V=9e-4 --serve
  tumble guide schedule.campaign.json --noise V=9e-4 --resume

At the prompt, a line is a reading at the position asked for ({\"V\": 0.0123}, or
CSV after a line of titles), 'undo', 'undo N' or 'quit'. With --samples, a line
is a row of samples, 'position LABEL' (the position of the bench), 'take' (use
the mean so far as the reading), or one of these commands.

Exit codes: 0 every goal is met, and no effect is missing or all are named;
1 an input is malformed, or the journal cannot be written; 2 ended earlier.";

pub(super) const BENCH: &str = "Examples:
  tumble bench list
  tumble bench show gyro-turntable > mine.bench.json";

pub(super) const NEW: &str = "Examples:
  tumble new rates.csv
  tumble new rates.csv --bench gyro-rate-steps --latitude 52.1
  tumble new head.xlsx --bench own --chain 'theta:x,~mount:z' --model 'A [V] = K0 + K1*a_y'
  tumble new phone.csv --samples still --bench accelerometer-triad-norm --position norm=9.8067 --start 's_x=1'
  tumble new line.parquet --bench gyro-rate-steps --latitude 52.1 --by serial
  tumble new lab

At a terminal, missing options are asked for. No file is ever replaced.

Exit codes: 0 done; 1 an answer is missing or malformed; 2 files were written, but these readings do not determine every unknown.";

pub(super) const CHECK: &str = "Example:
  tumble check mine.bench.json table1.campaign.json

Exit codes: 0 every file is valid; 1 a file is malformed.";

pub(super) const COMPLETIONS: &str = "Examples:
  tumble completions bash > ~/.local/share/bash-completion/completions/tumble
  tumble completions zsh > ~/.zfunc/_tumble
  tumble completions fish > ~/.config/fish/completions/tumble.fish";

pub(super) const MAN: &str = "Examples:
  tumble man > ~/.local/share/man/man1/tumble.1
  tumble man fit | man -l -";

/// The shell.
#[derive(Debug, Args)]
pub(super) struct CompletionsArguments {
    /// The shell that is to complete commands and options.
    #[arg(value_enum)]
    shell: clap_complete::Shell,
}

/// The page.
#[derive(Debug, Args)]
pub(super) struct ManArguments {
    /// The command that the page is about; the whole program unless given.
    command: Option<String>,
}

pub(super) fn completions(arguments: &CompletionsArguments) -> Result<Outcome> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Cli::command(), "tumble", &mut script);
    super::print(&String::from_utf8_lossy(&script))?;
    Ok(Outcome::Done)
}

pub(super) fn man(arguments: &ManArguments) -> Result<Outcome> {
    let mut program = Cli::command();
    program.build();
    let page = match &arguments.command {
        None => program,
        Some(name) => {
            let found = program.get_subcommands().find(|command| command.get_name() == name).cloned();
            found.ok_or_else(|| {
                let names: Vec<&str> = program.get_subcommands().map(clap::Command::get_name).collect();
                Malformed::new(Fault::UnknownName, format!("there is no command '{name}'"))
                    .expected(format!("one of {}", names.join(", ")))
            })?
        }
    };
    let mut text = Vec::new();
    clap_mangen::Man::new(page)
        .render(&mut text)
        .map_err(|error| Malformed::new(Fault::Value, format!("the page cannot be laid out: {error}")))?;
    super::print(&String::from_utf8_lossy(&text))?;
    Ok(Outcome::Done)
}
