//! `tumble fit CAMPAIGN`.

use super::{Outcome, files, pages};
use crate::error::Result;
use crate::fit::{self, Weighting};
use crate::report;
use crate::wire;
use clap::Args;
use std::path::PathBuf;

/// What to fit and what to write.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The campaign file (JSON).
    campaign: PathBuf,
    /// Iterate Gauss-Newton on the exact rotations instead of one linear step, and report what changed.
    #[arg(long)]
    exact: bool,
    /// Take stated uncertainties of readings as relative weights, and estimate their scale from the residuals.
    #[arg(long)]
    relative: bool,
    /// Coverage probability of expanded uncertainties.
    #[arg(long, default_value_t = 0.95, value_name = "P")]
    level: f64,
    /// Write the report as JSON to a file, or to stdout with '-'.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Also list every reading with its residual, redundancy and minimal detectable bias.
    #[arg(long)]
    readings: bool,
    #[command(flatten)]
    pages: pages::Pages,
    #[command(flatten)]
    certificate: pages::Certificate,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome> {
    let (campaign, source, inputs) = files::campaign_and_inputs(&arguments.campaign)?;
    let weighting = if arguments.relative { Weighting::Relative } else { Weighting::AsStated };
    let settings =
        fit::Settings { exact: arguments.exact, level: arguments.level, weighting, ..fit::Settings::default() };
    let fit = fit::fit(&campaign, &settings).map_err(|error| wire::locate(error, &source))?;
    let report = report::fit_report(&fit);
    let pages = arguments.pages.fit(&fit, &report, &inputs)?.and(arguments.certificate.make(&fit, &report, &source)?);
    let to_stdout = arguments.json.as_deref().is_some_and(|path| path.as_os_str() == "-") || pages.to_stdout();
    pages.write()?;
    if let Some(path) = &arguments.json {
        files::write_or_print(path, &files::json(&report)?)?;
    }
    if !to_stdout {
        super::print(&report::table::fit(&report, arguments.readings));
    }
    Ok(if fit.is_rejected() { Outcome::Rejected } else { Outcome::Done })
}
