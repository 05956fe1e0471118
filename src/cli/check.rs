//! `tumble check FILE...` and `tumble schema KIND`.

use super::devices::{DeviceCampaign, Survey};
use super::{Outcome, files};
use crate::campaign::Campaign;
use crate::design::{self, Model};
use crate::error::{Malformed, Result};
use crate::fit;
use crate::wire;
use clap::Args;
use std::path::{Path, PathBuf};

/// Files to check.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Bench files (*.bench.json), campaign files and mission files (*.mission.json).
    #[arg(required = true)]
    files: Vec<PathBuf>,
}

/// Kind of schema.
#[derive(Debug, Args)]
pub(super) struct SchemaArguments {
    #[arg(help = format!("One of {}", crate::report::schemas().join(", ")))]
    kind: String,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome> {
    for path in &arguments.files {
        let line = check(path)?;
        super::show(&format!("{}: {line}\n", path.display()))?;
    }
    Ok(Outcome::Done)
}

/// One file: a bench if its name says so, else a campaign.
pub(super) fn check(path: &Path) -> Result<String> {
    if path.to_string_lossy().ends_with(".bench.json") {
        let bench = wire::read_bench(&files::read(path)?)?;
        let joints: Vec<&str> = bench.joints().collect();
        let tilts: Vec<&str> = bench.tilts().collect();
        let sensors: Vec<String> = bench.sensors.iter().map(|s| format!("{} = {}", s.id, s.model)).collect();
        return Ok(format!(
            "a bench; joints: {}; tilts: {}; {}",
            or_none(&joints.join(", ")),
            or_none(&tilts.join(", ")),
            sensors.join("; ")
        ));
    }
    if path.to_string_lossy().ends_with(".mission.json") {
        return super::navigate::check(path);
    }
    let (source, input) = files::read_input(path)?;
    let file = wire::campaign_of(&source)?;
    if file.has_rows() {
        let mut folder = files::Beside::new(path);
        let (campaign, _, sample) = wire::read_rows_of(&file, &source, &mut folder, None)?;
        usable(&campaign).map_err(|error| wire::locate(error, &source))?;
        return Ok(said("a campaign", &campaign, &format!("{} rows of a record", sample.rows)));
    }
    if file.by.is_some() {
        let Survey { first, devices, malformed } = DeviceCampaign::of(path, source)?.survey()?;
        let readings = match malformed.first() {
            None => format!("{devices} devices"),
            Some((label, error)) => {
                format!("{devices} devices, {} of them malformed (the first: '{label}', {error})", malformed.len())
            }
        };
        return Ok(said("a campaign", &first, &readings));
    }
    let (campaign, source, _) = files::campaign_in(path, (source, input))?;
    usable(&campaign).map_err(|error| wire::locate(error, &source))?;
    let what = if campaign.is_measured() { "a campaign" } else { "a schedule" };
    Ok(said(what, &campaign, &format!("{} readings", campaign.readings.rows.len())))
}

/// Errors that a fit would meet before it solves: what a model line uses and a reading lacks, uncertainties stated here and there.
fn usable(campaign: &Campaign) -> Result<()> {
    let model = Model::new(campaign)?;
    if campaign.is_measured() {
        let design = design::assemble(campaign, &model, &campaign.reference_point())?;
        fit::weigh(campaign, &design, fit::Weighting::AsStated)?;
    }
    Ok(())
}

fn said(what: &str, campaign: &Campaign, readings: &str) -> String {
    let unknowns: Vec<&str> = campaign.estimated().iter().map(|p| p.id.as_str()).collect();
    format!("{what} on {} with {readings}; to estimate: {}", campaign.bench.id, or_none(&unknowns.join(", ")))
}

fn or_none(list: &str) -> &str {
    if list.is_empty() { "none" } else { list }
}

pub(super) fn run_schema(arguments: &SchemaArguments) -> Result<Outcome> {
    let Some(schema) = crate::report::schema(&arguments.kind) else {
        let what = format!("there is no schema '{}'", arguments.kind);
        return Err(Malformed::unknown(what, &arguments.kind, crate::report::schemas()));
    };
    super::print(&files::json(&schema)?)?;
    Ok(Outcome::Done)
}
