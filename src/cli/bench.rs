//! `tumble bench list | show ID`.

use super::Outcome;
use crate::bench;
use crate::error::{Fault, Malformed, Result};
use crate::report::table;
use crate::wire::{self, Source};
use clap::Subcommand;

/// What to do with the built-in benches.
#[derive(Debug, Subcommand)]
pub(super) enum Arguments {
    /// List the built-in benches.
    List,
    /// Print a built-in bench as a file, to start your own from.
    Show {
        /// Its id.
        id: String,
    },
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome> {
    match arguments {
        Arguments::List => {
            let mut rows = Vec::new();
            for built_in in bench::built_ins() {
                let bench = wire::read_bench(&Source { name: built_in.id.into(), text: built_in.text.into() })?;
                let sensors: Vec<&str> = bench.sensors.iter().map(|s| s.id.as_str()).collect();
                rows.push(vec![bench.id.clone(), format!("{} (sensors: {})", bench.title, sensors.join(", "))]);
            }
            super::show(&table::plain(&["id", "what it is"], &rows))?;
        }
        Arguments::Show { id } => match bench::built_in(id) {
            Some(built_in) => super::print(built_in.text)?,
            None => {
                let ids: Vec<&str> = bench::built_ins().iter().map(|b| b.id).collect();
                return Err(Malformed::new(Fault::UnknownName, format!("no built-in bench is called '{id}'"))
                    .expected(format!("one of {}", ids.join(", ")))
                    .found(format!("'{id}'")));
            }
        },
    }
    Ok(Outcome::Done)
}
