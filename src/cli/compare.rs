//! `tumble compare CAMPAIGN`.

use super::outputs::Outputs;
use super::{Outcome, files, pages};
use crate::compare;
use crate::error::Result;
use crate::fit;
use crate::report::{self, html};
use crate::wire;
use clap::Args;
use std::path::PathBuf;

/// What to compare and what to write.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The campaign file (JSON), on a bench whose closed forms are published.
    campaign: PathBuf,
    /// Write the report as JSON to a file, or to stdout with '-'.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    pages: pages::Pages,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome> {
    let (campaign, source, inputs) = files::campaign_and_inputs(&arguments.campaign)?;
    let [html, md] = arguments.pages.paths();
    let mut outputs = Outputs::plan([html, md, arguments.json.as_deref()])?;
    let forms = compare::closed_forms(&campaign.bench.id)?;
    let comparison =
        compare::compare(&campaign, &forms, &fit::Settings::default()).map_err(|error| wire::locate(error, &source))?;
    let report = report::compare_report(&comparison);
    outputs.extend(arguments.pages.page(&html::compare_page(&report, &inputs))?);
    if let Some(path) = &arguments.json {
        outputs.add(path, files::json(&report)?);
    }
    let to_stdout = outputs.to_stdout();
    outputs.write()?;
    if !to_stdout {
        super::print(&report::table::compare(&report))?;
    }
    Ok(Outcome::Done)
}
