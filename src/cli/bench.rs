//! `tumble bench list | show ID [--svg FILE]`.

use super::outputs::Outputs;
use super::pages::picture;
use super::plan::named_number;
use super::{Outcome, files};
use crate::bench::{self, Bench};
use crate::campaign::JointState;
use crate::document::Rows;
use crate::document::chart::Chart;
use crate::document::terminal::alone;
use crate::error::{Fault, Malformed, Result};
use crate::language::Language;
use crate::report;
use crate::wire::{self, Source};
use clap::Subcommand;
use std::path::{Path, PathBuf};

/// What to do with the built-in benches.
#[derive(Debug, Subcommand)]
pub(super) enum Arguments {
    /// List the built-in benches.
    List,
    /// Print a built-in bench as a file, to start your own from; or draw a bench.
    Show {
        /// Its id, or a bench file.
        id: String,
        /// Write a drawing of it: joints, axes, gravity and Earth rate.
        #[arg(long, value_name = "FILE")]
        svg: Option<PathBuf>,
        /// With --svg: the angle of a joint, or with _deg_s its rate: beta_deg=90 or gamma_deg_s=20. Zero unless given; repeat for several.
        #[arg(long, value_name = "KEY=VALUE", requires = "svg")]
        at: Vec<String>,
    },
}

pub(super) fn run(arguments: &Arguments, lang: Language) -> Result<Outcome> {
    match arguments {
        Arguments::List => {
            let benches: Vec<Bench> = bench::built_ins().iter().map(|b| Bench::named(b.id)).collect::<Result<_>>()?;
            let sensors = |bench: &Bench| bench.sensors.iter().map(|s| s.id.as_str()).collect::<Vec<_>>().join(", ");
            let what = |bench: &Bench| format!("{} (sensors: {})", bench.title, sensors(bench));
            super::show(&alone(Rows::of(&benches).left("id", |bench| &bench.id).left("what it is", what), lang))?;
        }
        Arguments::Show { id, svg, at } => {
            let source = shown(id)?;
            match svg {
                None => super::print(&source.text)?,
                Some(path) => {
                    let mut outputs = Outputs::plan([Some(path.as_path())])?;
                    let bench = wire::read_bench(&source)?;
                    let scene = report::scene(&bench, &states(&bench, at)?);
                    outputs.add(path, picture(&Chart::Scene(scene), lang)?);
                    outputs.write()?;
                }
            }
        }
    }
    Ok(Outcome::Done)
}

/// A built-in bench by its id, or a file.
fn shown(id: &str) -> Result<Source> {
    if let Some(built_in) = bench::built_in(id) {
        return Ok(Source { name: id.into(), text: built_in.text.into() });
    }
    if Path::new(id).is_file() {
        return files::read(Path::new(id));
    }
    let ids: Vec<&str> = bench::built_ins().iter().map(|b| b.id).collect();
    Err(Malformed::new(Fault::UnknownName, format!("no built-in bench is called '{id}', and there is no such file"))
        .expected(format!("a bench file or one of {}", ids.join(", ")))
        .found(format!("'{id}'")))
}

/// States of the joints: `beta_deg=90`, `gamma_deg_s=20`; at rest at zero where nothing is said.
fn states(bench: &Bench, given: &[String]) -> Result<Vec<JointState>> {
    let joints: Vec<&str> = bench.joints().collect();
    let mut states = vec![JointState::Held { angle_deg: 0.0 }; joints.len()];
    for text in given {
        let (key, value) = named_number(text, "--at", "beta_deg=90")?;
        let (name, turns) = match key.strip_suffix("_deg_s") {
            Some(name) => (name, true),
            None => (key.strip_suffix("_deg").unwrap_or(&key), false),
        };
        let state =
            joints.iter().position(|joint| *joint == name).and_then(|k| states.get_mut(k)).ok_or_else(|| {
                Malformed::new(Fault::UnknownName, format!("the bench '{}' has no joint '{name}'", bench.id))
                    .expected(format!("one of {} with _deg or _deg_s", joints.join(", ")))
                    .found(format!("'{text}'"))
            })?;
        *state = match turns {
            true => JointState::WholeTurns { rate_deg_s: value },
            false => JointState::Held { angle_deg: value },
        };
    }
    Ok(states)
}
