//! `tumble diagnose CAMPAIGN`, and `tumble diagnose MISSION --measured FILE`.

use super::files::Catalogue;
use super::outputs::Outputs;
use super::pages;
use super::{Outcome, batch, devices, files};
use crate::diagnosis::{self, Diagnosis, Verdict};
use crate::document::chart::Chart;
use crate::document::wrap;
use crate::error::{Fault, Malformed, Result};
use crate::fit::Remount;
use crate::language::{Language, say};
use crate::navigate::cause::Cause;
use crate::navigate::diagnose::{NavigationDiagnosis, diagnose_with};
use crate::navigate::errors::Instrument;
use crate::navigate::settings;
use crate::number;
use crate::report;
use crate::wire::{self, BenchRef, MissionFile};
use clap::Args;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// What to diagnose and what to write.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The campaign file (JSON; standard input with '-'), or a mission file with '--measured'.
    #[arg(required_unless_present = "readings")]
    campaign: Option<PathBuf>,
    /// Measured navigation errors of a mission (CSV, with the columns of `tumble navigate --csv`, and `_u` for their standard uncertainties).
    #[arg(long, value_name = "FILE", conflicts_with = "effects")]
    measured: Option<PathBuf>,
    /// A catalogue of further effects to try with the built-in ones (`tumble schema effects` has its form).
    #[arg(long, value_name = "FILE")]
    effects: Option<PathBuf>,
    /// Probability of reporting an effect when none is missing.
    #[arg(long, default_value_t = 0.01, value_name = "P", allow_negative_numbers = true)]
    significance: f64,
    /// Random offset of each sensor at each position (set-up repeatability): 'estimate' its variance, or state its standard uncertainty in
    /// the sensor's unit. Other random effects are "scatter" lines of the campaign.
    #[arg(long, value_name = "estimate|U", value_parser = super::fit::remount, allow_negative_numbers = true, conflicts_with = "measured")]
    remount: Option<Remount>,
    /// Write the repaired bench to NAME.bench.json and the repaired campaign to NAME.campaign.json in the same folder; with '--measured' the
    /// mission with the errors added.
    #[arg(long, value_name = "NAME.bench.json")]
    write_model: Option<PathBuf>,
    /// Write the residuals before and after as a picture (SVG), or to stdout with '-'; with '--measured' the residuals over time, in the
    /// channel where they are largest.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Files of readings (CSV, Parquet, gzip; patterns with * and ?) in place of the campaign's: without '--by', each file is one device.
    /// The campaign may follow them.
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with = "measured")]
    readings: Vec<PathBuf>,
    #[command(flatten)]
    many: devices::Many,
    #[command(flatten)]
    pages: pages::Pages,
}

pub(super) fn run(arguments: &Arguments, lang: Language) -> Result<Outcome> {
    if let (Some(path), Some(measured)) = (&arguments.campaign, &arguments.measured) {
        return mission(arguments, path, measured, lang);
    }
    let (campaign, readings) = devices::behind(arguments.campaign.as_deref(), &arguments.readings)?;
    if campaign.to_string_lossy().ends_with(".mission.json") {
        return Err(Malformed::new(Fault::Missing, "a mission without measured errors cannot be diagnosed")
            .expected("--measured FILE with measured navigation errors"));
    }
    let question = devices::DeviceCampaign::read(campaign, &arguments.many, readings)?;
    let single = if question.is_of_many() { None } else { Some(question.single()?) };
    let (campaign, inputs) = single.unzip();
    let (source, mut inputs) = (&question.source, inputs.unwrap_or_default());
    let (listed, input) = arguments.effects.as_deref().map(files::read_input).transpose()?.unzip();
    inputs.extend(input);
    let catalogue = Catalogue::new(listed)?;
    let remount = arguments.remount.unwrap_or_default();
    let settings = diagnosis::Settings { remount, ..diagnosis::Settings::at(arguments.significance) };
    let Some(campaign) = campaign else {
        let single = vec![
            ("--write-model", arguments.write_model.is_some()),
            ("--svg", arguments.svg.is_some()),
            ("a page (--html and its like)", arguments.pages.is_asked_for()),
            ("--json", arguments.pages.json().is_some()),
        ];
        devices::refuse_many(single, "--to FILE for a row a device, or the readings of one device")?;
        return batch::diagnose(&question, &arguments.many, &catalogue, &settings, lang);
    };
    arguments.many.refuse_alone(&[])?;
    batch::note_repeated(&campaign);
    let model_names = arguments.write_model.as_deref().map(ModelNames::new).transpose()?;
    let [bench, repaired] = match &model_names {
        Some(names) => [Some(names.bench.as_path()), Some(names.campaign.as_path())],
        None => [None, None],
    };
    let svg = arguments.svg.as_deref();
    let mut outputs = arguments.pages.outputs([svg, bench, repaired])?;
    let diagnosis = diagnosis::diagnose(&campaign, &catalogue.effects, &settings)
        .map_err(|error| catalogue.locate(error, source))?;
    let mut report = report::diagnose_report(&campaign, &diagnosis, &settings);
    report.inputs = inputs;
    if let Some(path) = &arguments.svg {
        let figure = report::diagnose_figure(&campaign, &diagnosis, &report, lang);
        outputs.add(path, pages::picture(&figure.chart, lang)?);
    }
    if let Some(names) = &model_names {
        names.add(&mut outputs, &diagnosis)?;
    }
    let document = |_| report::diagnose_document(&report, Some((&campaign, &diagnosis)), lang);
    arguments.pages.finish(outputs, &report, document)?;
    for remark in diagnosis.before.remarks() {
        remark_note(&remark.say(lang), lang);
    }
    if let Some(names) = &model_names {
        super::note(&names.note(&diagnosis, lang));
        if let Some(note) = report::alias_note(&report, lang) {
            remark_note(&note, lang);
        }
    }
    // of a channel that is stuck nothing can be said
    let in_order = diagnosis.verdict == Verdict::NothingMissing && diagnosis.before.stuck().is_empty();
    Ok(if in_order { Outcome::Done } else { Outcome::Rejected })
}

/// What a reader should know beside the report.
fn remark_note(remark: &str, lang: Language) {
    super::note(&wrap::hanging(&format!("{}{}{remark}", say!(lang, "note"), lang.colon()), 2));
}

struct ModelNames {
    bench: PathBuf,
    campaign: PathBuf,
    /// Name of the bench's file, as the campaign refers to it, and the part before `.bench.json`.
    name: String,
    stem: String,
}

impl ModelNames {
    /// Errors: a name that does not end in `.bench.json`.
    fn new(path: &Path) -> Result<Self> {
        let name = path.file_name().map(|name| name.to_string_lossy().to_string()).unwrap_or_default();
        let Some(stem) = name.strip_suffix(".bench.json").filter(|stem| !stem.is_empty()) else {
            return Err(Malformed::new(Fault::Value, "the repaired model needs a bench file's name")
                .expected("a name that ends in .bench.json")
                .found(format!("'{name}'")));
        };
        let campaign = path.with_file_name(format!("{stem}.campaign.json"));
        Ok(ModelNames { bench: path.to_path_buf(), campaign, stem: stem.to_string(), name })
    }

    fn add(&self, outputs: &mut Outputs, diagnosis: &Diagnosis) -> Result<()> {
        let Some(repaired) = &diagnosis.repaired else { return Ok(()) };
        let mut bench = wire::bench_file(&repaired.bench);
        bench.id = self.stem.clone();
        let added: Vec<&str> = diagnosis.effects.iter().map(|finding| finding.effect.regressor.as_str()).collect();
        bench.title = format!("{} with {}", bench.title, added.join(", ")).trim().to_string();
        let campaign = wire::campaign_file(repaired, BenchRef::Named(self.name.clone()));
        outputs.add(&self.bench, files::marked(&bench)?);
        outputs.add(&self.campaign, files::marked(&campaign)?);
        Ok(())
    }

    fn note(&self, diagnosis: &Diagnosis, lang: Language) -> String {
        match diagnosis.repaired {
            Some(_) => {
                let files = [&self.bench, &self.campaign].map(|path| path.display().to_string());
                say!(lang, "wrote", file = lang.list(&files))
            }
            None => say!(lang, "note-nothing-found", what = "effect"),
        }
    }
}

/// What a mission's measured errors say.
fn mission(arguments: &Arguments, path: &Path, measured: &Path, lang: Language) -> Result<Outcome> {
    let [svg, write_model] = [&arguments.svg, &arguments.write_model].map(|path| path.as_deref());
    let (file, mission, source) = files::mission(path)?;
    let measured = wire::read_measured(&files::read(measured)?, &mission)?;
    let mut outputs = arguments.pages.outputs([svg, write_model])?;
    let settings = settings::Settings::at(arguments.significance);
    let bar = super::bar(1000, "{spinner} {elapsed} [{bar:20}] {wide_msg}").with_message("flying the mission");
    bar.enable_steady_tick(Duration::from_millis(200));
    let found = diagnose_with(&mission, &measured, &settings, &mut |share, trying| {
        bar.set_position(number::count_u64(1000.0 * share.clamp(0.0, 1.0)));
        bar.set_message(format!("trying {trying}"));
    });
    bar.finish_and_clear();
    let diagnosis = found.map_err(|error| wire::locate(error, &source))?;
    let report = report::navigate_diagnose_report(&mission, &measured, &diagnosis, &settings);
    if let Some(path) = svg {
        let figure = report::navigate_diagnose_figure(&report, &diagnosis, lang);
        let chart = figure.map_or_else(|| Chart::curves(&[], "", "", ""), |figure| figure.chart);
        outputs.add(path, pages::picture(&chart, lang)?);
    }
    let found = matches!(diagnosis.verdict, Verdict::EffectsFound | Verdict::PartlyExplained);
    if let Some(path) = write_model.filter(|_| found) {
        outputs.add(path, files::marked(&repaired(&file, &diagnosis))?);
    }
    let document = |_| report::navigate_diagnose_document(&report, Some((&mission, &diagnosis)), lang);
    arguments.pages.finish(outputs, &report, document)?;
    match write_model {
        Some(path) if found => super::note(&say!(lang, "wrote", file = path.display().to_string())),
        Some(_) => super::note(&say!(lang, "note-nothing-found", what = "error")),
        None => {}
    }
    Ok(if diagnosis.verdict == Verdict::NothingMissing { Outcome::Done } else { Outcome::Rejected })
}

/// The mission as it was written, with the constant errors added; what changes in time or is the reference's has no place in it.
fn repaired(file: &MissionFile, diagnosis: &NavigationDiagnosis) -> MissionFile {
    let mut file = file.clone();
    for (source, value) in
        diagnosis.findings.iter().filter_map(|finding| Some((finding.source.constant()?, finding.value)))
    {
        file.errors.add(&source, value / source.si_per_unit());
    }
    for source in diagnosis.findings.iter().map(|finding| finding.source) {
        let Some(walk) = source.of(&diagnosis.after).map(|value| value / source.si_per_unit()) else { continue };
        match source {
            Cause::RandomWalk(Instrument::Gyro) => file.errors.angle_random_walk_deg_sqrt_h = walk,
            Cause::RandomWalk(_) => file.errors.velocity_random_walk_m_s_sqrt_h = walk,
            _ => {}
        }
    }
    file
}
