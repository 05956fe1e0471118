//! `tumble completions SHELL` and `tumble man [COMMAND]`.

use super::{Cli, Outcome};
use crate::error::{Fault, Malformed, Result};
use clap::{Args, CommandFactory};

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
