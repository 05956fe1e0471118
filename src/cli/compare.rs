//! `tumble compare CAMPAIGN` (published closed forms), `tumble compare A B ...` (calibrations of one unit).

use super::{Outcome, calibrations, files, pages};
use crate::compare::{self, calibrations::changes, calibrations::trends};
use crate::error::{Fault, Malformed, Result};
use crate::fit;
use crate::language::Language;
use crate::report;
use crate::wire;
use clap::Args;
use std::path::{Path, PathBuf};

/// What to compare and what to write.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// A campaign on a bench whose closed forms are published; or two or more fit reports (`tumble fit --json`) of one unit.
    #[arg(required = true, value_name = "CAMPAIGN|REPORT")]
    files: Vec<PathBuf>,
    /// Coverage probability of expanded uncertainties, for calibrations.
    #[arg(long, default_value_t = 0.95, value_name = "P")]
    level: f64,
    /// Take inputs that two calibrations share (a reference standard) as independent.
    #[arg(long)]
    independent: bool,
    #[command(flatten)]
    pages: pages::Pages,
}

pub(super) fn run(arguments: &Arguments, lang: Language) -> Result<Outcome> {
    match arguments.files.as_slice() {
        [campaign] => closed_forms(arguments, campaign, lang),
        [before, after] => two(arguments, before, after, lang),
        several => history(arguments, several, lang),
    }
}

fn closed_forms(arguments: &Arguments, path: &Path, lang: Language) -> Result<Outcome> {
    let read = files::read_input(path)?;
    if calibrations::is_report(&read.0) {
        return Err(Malformed::new(Fault::Missing, "only one calibration is given")
            .expected("a second fit report: tumble compare BEFORE AFTER")
            .in_file(path.display().to_string()));
    }
    let (campaign, source, inputs) = files::campaign_in(path, read)?;
    if let Some(by) = &campaign.by {
        return Err(wire::locate(
            Malformed::new(Fault::Value, "closed forms are compared for one device, and this campaign is of many")
                .expected("the readings of one device, and no \"by\"; or tumble fit, which takes each device by itself")
                .found(format!("\"by\": \"{by}\""))
                .at_path("by"),
            &source,
        ));
    }
    let outputs = arguments.pages.outputs([])?;
    let forms = compare::closed_forms(&campaign.bench.id)?;
    let comparison =
        compare::compare(&campaign, &forms, &fit::Settings::default()).map_err(|error| wire::locate(error, &source))?;
    let mut report = report::compare_report(&comparison);
    report.inputs = inputs.clone();
    let document = |_| report::compare_document(&report, &inputs, lang);
    arguments.pages.finish(outputs, &report, document)
}

fn two(arguments: &Arguments, before: &Path, after: &Path, lang: Language) -> Result<Outcome> {
    fit::check_level(arguments.level)?;
    let (before, after) = (calibrations::read(before)?, calibrations::read(after)?);
    calibrations::of_other_readings(&before, &after)?;
    let outputs = arguments.pages.outputs([])?;
    let found = changes(&before.determination(), &after.determination(), arguments.level, !arguments.independent);
    if found.changes.is_empty() {
        return Err(Malformed::new(Fault::Value, "the two calibrations have no quantity in common")
            .expected("two fits of the same bench")
            .found(format!("benches {} and {}", before.report.bench, after.report.bench)));
    }
    let report = report::changes_report(&found, before.summary(), after.summary());
    let document = |_| report::changes_document(&report, lang);
    arguments.pages.finish(outputs, &report, document)?;
    Ok(if report.is_changed() { Outcome::Rejected } else { Outcome::Done })
}

fn history(arguments: &Arguments, paths: &[PathBuf], lang: Language) -> Result<Outcome> {
    fit::check_level(arguments.level)?;
    let mut stored = paths.iter().map(|path| calibrations::read(path)).collect::<Result<Vec<_>>>()?;
    if let Some(undated) = stored.iter().find(|report| report.day().is_none()) {
        return Err(Malformed::new(Fault::Missing, "a history needs the date of each calibration")
            .expected("\"date\": \"YYYY-MM-DD\" in each campaign")
            .found(format!("no date in {}", undated.summary().file)));
    }
    let outputs = arguments.pages.outputs([])?;
    // each has a day: asked above
    stored.sort_by(|a, b| a.day().unwrap_or_default().total_cmp(&b.day().unwrap_or_default()));
    for (k, after) in stored.iter().enumerate() {
        stored.iter().take(k).try_for_each(|before| calibrations::of_other_readings(before, after))?;
    }
    let all: Vec<_> = stored.iter().map(|report| report.determination()).collect();
    let last = stored.last();
    let limits = |id: &str| last.and_then(|report| report.limits(id));
    let summaries = stored.iter().map(|report| report.summary()).collect();
    let report = report::history_report(summaries, trends(&all, arguments.level, &limits), arguments.level);
    let document = |_| report::history_document(&report, lang);
    arguments.pages.finish(outputs, &report, document)
}
