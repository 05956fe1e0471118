//! `tumble diagnose MISSION --measured FILE`.

use super::diagnose::Arguments;
use super::pages::picture;
use super::{Outcome, files};
use crate::diagnosis::Verdict;
use crate::document::chart::Chart;
use crate::error::Result;
use crate::language::{Language, say};
use crate::navigate::cause::Cause;
use crate::navigate::diagnose::{self, NavigationDiagnosis};
use crate::navigate::errors::Instrument;
use crate::navigate::settings::Settings;
use crate::number;
use crate::report;
use crate::wire::{self, MissionFile};
use std::path::Path;
use std::time::Duration;

pub(super) fn run(arguments: &Arguments, mission: &Path, measured: &Path, lang: Language) -> Result<Outcome> {
    let [json, svg, write_model] =
        [&arguments.json, &arguments.svg, &arguments.write_model].map(|path| path.as_deref());
    let (file, mission, source) = files::mission(mission)?;
    let measured = wire::read_measured(&files::read(measured)?, &mission)?;
    let mut outputs = arguments.pages.outputs([json, svg, write_model])?;
    let settings = Settings::at(arguments.significance);
    let bar = super::bar(1000, "{spinner} {elapsed} [{bar:20}] {wide_msg}").with_message("flying the mission");
    bar.enable_steady_tick(Duration::from_millis(200));
    let found = diagnose::diagnose_with(&mission, &measured, &settings, &mut |share, trying| {
        bar.set_position(number::count_u64(1000.0 * share.clamp(0.0, 1.0)));
        bar.set_message(format!("trying {trying}"));
    });
    bar.finish_and_clear();
    let diagnosis = found.map_err(|error| wire::locate(error, &source))?;
    let report = report::navigate_diagnose_report(&mission, &measured, &diagnosis, &settings);
    if let Some(path) = svg {
        let figure = report::navigate_diagnose_figure(&report, &diagnosis, lang);
        let chart = figure.map_or_else(|| Chart::curves(&[], "", "", ""), |figure| figure.chart);
        outputs.add(path, picture(&chart, lang)?);
    }
    let found = matches!(diagnosis.verdict, Verdict::EffectsFound | Verdict::PartlyExplained);
    if let Some(path) = write_model.filter(|_| found) {
        outputs.add(path, files::marked(&repaired(&file, &diagnosis))?);
    }
    let document = |_| report::navigate_diagnose_document(&report, Some((&mission, &diagnosis)), lang);
    arguments.pages.finish(outputs, json, &report, document)?;
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
