//! `tumble diagnose CAMPAIGN`, and `tumble diagnose MISSION --measured FILE` (`navigate_diagnose.rs`).

use super::{Outcome, files};
use crate::diagnosis::{self, Diagnosis, Effect, Verdict};
use crate::error::{Fault, Malformed, Result};
use crate::report;
use crate::wire::{self, BenchRef, Source};
use clap::Args;
use std::path::{Path, PathBuf};

/// What to diagnose and what to write.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The campaign file (JSON), or a mission file with '--measured'.
    campaign: PathBuf,
    /// Measured navigation errors of a mission (CSV, with the columns of `tumble navigate --csv` and `_u` beside them).
    #[arg(long, value_name = "FILE", conflicts_with = "effects")]
    measured: Option<PathBuf>,
    /// A catalogue of your own effects, tried beside the built-in ones (`tumble schema effects` has its form).
    #[arg(long, value_name = "FILE")]
    effects: Option<PathBuf>,
    /// Probability of reporting anything when nothing is missing.
    #[arg(long, default_value_t = 0.01, value_name = "P")]
    significance: f64,
    /// Write the repaired bench to NAME.bench.json and, beside it, the repaired campaign to NAME.campaign.json; with '--measured' the
    /// mission with the errors added.
    #[arg(long, value_name = "NAME.bench.json")]
    write_model: Option<PathBuf>,
    /// Write the report as JSON to a file, or to stdout with '-'.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    pages: super::pages::Pages,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome> {
    if let Some(measured) = &arguments.measured {
        return super::navigate_diagnose::run(&super::navigate_diagnose::Question {
            mission: &arguments.campaign,
            measured,
            significance: arguments.significance,
            write_model: arguments.write_model.as_deref(),
            json: arguments.json.as_deref(),
            pages: &arguments.pages,
        });
    }
    if arguments.campaign.to_string_lossy().ends_with(".mission.json") {
        return Err(Malformed::new(Fault::Missing, "a mission alone has nothing to be diagnosed")
            .expected("--measured FILE with measured navigation errors"));
    }
    let (campaign, source) = files::campaign(&arguments.campaign)?;
    let own = match &arguments.effects {
        Some(path) => Some(files::read(path)?),
        None => None,
    };
    let catalogue = catalogue(own.as_ref())?;
    let settings = diagnosis::Settings { significance: arguments.significance };
    let diagnosis = diagnosis::diagnose(&campaign, &catalogue, &settings).map_err(|error| match &own {
        Some(effects) if error.place().path.starts_with("effects[") => wire::locate(error, effects),
        _ => wire::locate(error, &source),
    })?;
    let report = report::diagnose_report(&campaign, &diagnosis, &settings);
    let lines = report::diagnose_table(&report).lines().map(str::to_string).collect();
    let section = report::html::Section::new("Diagnosis").block(report::html::Block::Formula(lines));
    arguments.pages.page(&report::html::Page::new(&campaign.bench.id).section(section))?.write()?;
    let to_stdout = arguments.json.as_deref().is_some_and(|path| path.as_os_str() == "-");
    if let Some(path) = &arguments.json {
        files::write_or_print(path, &files::json(&report)?)?;
    }
    if !to_stdout {
        super::print(&report::diagnose_table(&report));
    }
    if let Some(path) = &arguments.write_model {
        write_model(path, &diagnosis)?;
    }
    Ok(if diagnosis.verdict == Verdict::NothingMissing { Outcome::Done } else { Outcome::Rejected })
}

/// The user's effects first, so that their names stand where both have the same term.
fn catalogue(own: Option<&Source>) -> Result<Vec<Effect>> {
    let mut effects = match own {
        Some(source) => wire::read_effects(source)?,
        None => Vec::new(),
    };
    effects.extend(wire::built_in_effects()?);
    Ok(effects)
}

fn write_model(path: &Path, diagnosis: &Diagnosis) -> Result<()> {
    let Some(after) = &diagnosis.after else {
        eprintln!("note: no effect was found, so no repaired model is written");
        return Ok(());
    };
    let name = path.file_name().map(|name| name.to_string_lossy().to_string()).unwrap_or_default();
    let Some(stem) = name.strip_suffix(".bench.json").filter(|stem| !stem.is_empty()) else {
        return Err(Malformed::new(Fault::Value, "the repaired model needs a bench file's name")
            .expected("a name that ends in .bench.json")
            .found(format!("'{name}'")));
    };
    let mut bench = wire::bench_file(&after.campaign.bench);
    bench.id = stem.to_string();
    let added: Vec<&str> = diagnosis.effects.iter().map(|finding| finding.effect.regressor.as_str()).collect();
    bench.title = format!("{} with {}", bench.title, added.join(", ")).trim().to_string();
    let campaign = wire::campaign_file(&after.campaign, BenchRef::Named(name.clone()));
    let beside = path.with_file_name(format!("{stem}.campaign.json"));
    files::write(path, &files::json(&bench)?)?;
    files::write(&beside, &files::json(&campaign)?)?;
    eprintln!("wrote {} and {}", path.display(), beside.display());
    Ok(())
}
