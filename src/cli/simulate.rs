//! `tumble simulate SCHEDULE --truth F`.

use super::outputs::Outputs;
use super::{Outcome, files};
use crate::error::Result;
use crate::simulate;
use crate::wire;
use clap::Args;
use std::path::PathBuf;

/// What to simulate and where to write it.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The schedule: a campaign file; values that it has are replaced.
    schedule: PathBuf,
    /// The truth file: true values, noise, hidden effects.
    #[arg(long, value_name = "FILE")]
    truth: PathBuf,
    /// Seed of the noise; the same seed gives the same readings.
    #[arg(long, default_value_t = 1, value_name = "N")]
    seed: u64,
    /// Write the campaign to a file; stdout unless given.
    #[arg(short, long, visible_alias = "out", value_name = "FILE", default_value = "-")]
    output: PathBuf,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome> {
    let (schedule, source, _) = files::campaign(&arguments.schedule)?;
    files::one_device(&schedule);
    let truth = wire::read_truth(&files::read(&arguments.truth)?, &schedule)?;
    let mut outputs = Outputs::plan([Some(arguments.output.as_path())])?;
    let campaign =
        simulate::simulate(&schedule, &truth, arguments.seed).map_err(|error| wire::locate(error, &source))?;
    let file = wire::campaign_file(&campaign, wire::bench_ref(&campaign));
    outputs.add(&arguments.output, files::marked(&file)?);
    outputs.write()?;
    Ok(Outcome::Done)
}
