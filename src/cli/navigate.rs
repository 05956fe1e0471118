//! `tumble navigate MISSION`.

use super::outputs::{self, Outputs, Stream};
use super::pages::Pages;
use super::{Outcome, files};
use crate::error::{Fault, Malformed, Result};
use crate::language::Language;
use crate::navigate::measured::{CHANNELS, Measured, MeasuredRow, channels, si_per_unit};
use crate::navigate::mission::Mission;
use crate::navigate::propagation::{self, SourceCovariance};
use crate::navigate::run::{Continue, Row, Scenario};
use crate::navigate::study::{self, Progress};
use crate::number;
use crate::report::{self, series::Series};
use crate::wire::{self, MissionFile};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// What to fly and what to write.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The mission file (JSON).
    mission: PathBuf,
    /// Write the report as JSON to a file, or to stdout with '-'.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the errors in time as CSV.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write the errors in time as Parquet.
    #[arg(long, value_name = "FILE")]
    parquet: Option<PathBuf>,
    /// Write the errors of all sources together as if they had been measured, with the noise below (CSV, for `tumble diagnose --measured`).
    #[arg(long, value_name = "FILE")]
    measured: Option<PathBuf>,
    /// Standard uncertainty of measured attitude errors, arcsec; attitude is not measured without it.
    #[arg(long, value_name = "U", requires = "measured", allow_negative_numbers = true)]
    noise_arcsec: Option<f64>,
    /// Standard uncertainty of measured velocity errors, m/s; velocity is not measured without it.
    #[arg(long, value_name = "U", requires = "measured", allow_negative_numbers = true)]
    noise_m_s: Option<f64>,
    /// Standard uncertainty of measured position errors, m; position is not measured without it.
    #[arg(long, value_name = "U", requires = "measured", allow_negative_numbers = true)]
    noise_m: Option<f64>,
    #[command(flatten)]
    pages: Pages,
}

pub(super) fn run(arguments: &Arguments, lang: Language) -> Result<Outcome> {
    let (file, source) = files::mission(&arguments.mission)?;
    let mission = file.mission().map_err(|error| wire::locate(error, &source))?;
    let calibration = match &file.calibration {
        Some(calibration) => {
            let path = arguments.mission.with_file_name(&calibration.report);
            let found = wire::read_covariance(&files::read(&path)?)?;
            let factors = calibration.factors();
            let covariance = propagation::combine(&found.order, &found.matrix, &factors);
            Some((covariance.map_err(|error| wire::locate(error, &source))?, number::index(calibration.monte_carlo)))
        }
        None => None,
    };
    let scenarios = study::scenarios(&mission.errors, file.scenarios);
    let [json, csv] = [&arguments.json, &arguments.csv].map(Option::as_deref);
    let [parquet, measured] = [&arguments.parquet, &arguments.measured].map(Option::as_deref);
    let mut outputs = arguments.pages.outputs([json, csv, parquet, measured])?;
    let mut tables = Tables::open(arguments, &outputs, &scenarios)?;
    let mut instruments = Instruments::new(arguments, &mission)?;

    let bar = bar("flying");
    let mut fault = None;
    let flown = study::fly(&mission, &scenarios, &mut |motion, row, progress| {
        show(&bar, progress);
        instruments.measure(motion, row);
        match tables.push(motion, row) {
            Ok(()) => Continue::Yes,
            Err(error) => {
                fault = Some(error);
                Continue::Stop
            }
        }
    });
    bar.finish_and_clear();
    if let Some(error) = fault {
        return Err(error);
    }
    let carried = match &calibration {
        Some((covariance, draws)) => carried(&mission, covariance, *draws),
        None => Vec::new(),
    };
    let report = report::navigate_report(&mission, &scenarios, &flown, &carried);
    tables.finish(&mut outputs)?;
    if let Some(path) = &arguments.measured {
        outputs.add(path, wire::write_measured(&instruments.measured, &mission));
    }
    let document = report::navigate_document(&report, Some((&mission, &flown)), lang);
    outputs.extend(arguments.pages.page(&document)?);
    arguments.pages.finish(outputs, json, &report, || document)?;
    Ok(Outcome::Done)
}

fn carried(mission: &Mission, covariance: &SourceCovariance, draws: usize) -> Vec<study::PropagatedCalibration> {
    let bar = bar("carrying the covariance");
    let carried = study::propagate_calibration(mission, covariance, draws, &mut |progress| {
        show(&bar, progress);
        Continue::Yes
    });
    bar.finish_and_clear();
    carried
}

/// What measures a navigator's errors: one of stated uncertainty, or none, for each channel.
struct Instruments {
    u: [Option<f64>; CHANNELS],
    motions: Vec<String>,
    generator: Pcg64Mcg,
    measured: Measured,
}

impl Instruments {
    fn new(arguments: &Arguments, mission: &Mission) -> Result<Self> {
        let (phi, velocity, position) = (arguments.noise_arcsec, arguments.noise_m_s, arguments.noise_m);
        if arguments.measured.is_some() && [phi, velocity, position].iter().all(Option::is_none) {
            return Err(Malformed::new(Fault::Missing, "nothing is measured")
                .expected("--noise-arcsec, --noise-m-s or --noise-m with --measured"));
        }
        for (name, u) in [("--noise-arcsec", phi), ("--noise-m-s", velocity), ("--noise-m", position)] {
            if let Some(u) = u.filter(|u| !(*u > 0.0 && u.is_finite())) {
                return Err(Malformed::new(Fault::Value, format!("{name} is no standard uncertainty"))
                    .expected("a number above 0")
                    .found(u.to_string()));
            }
        }
        let mut u = [phi, phi, phi, velocity, velocity, position, position];
        for (channel, u) in u.iter_mut().enumerate() {
            *u = u.map(|u| u * si_per_unit(channel));
        }
        let motions = study::motions(mission).into_iter().map(|(name, _)| name).collect();
        // apart from the random walks' own generators
        let generator = Pcg64Mcg::seed_from_u64(mission.seed ^ 0x6d65_6173_7572_6564);
        Ok(Instruments { u, motions, generator, measured: Measured::default() })
    }

    fn measure(&mut self, motion: &str, row: &Row<'_>) {
        let (Some(error), Some(index)) = (row.errors.first(), self.motions.iter().position(|own| own == motion)) else {
            return;
        };
        if self.u.iter().all(Option::is_none) {
            return;
        }
        let truth = channels(error);
        let mut value = [None; CHANNELS];
        for ((slot, truth), u) in value.iter_mut().zip(truth).zip(self.u) {
            let unit: f64 = StandardNormal.sample(&mut self.generator);
            *slot = u.map(|u| truth + u * unit);
        }
        self.measured.push(index, MeasuredRow { time: row.truth.time, value, u: self.u });
    }
}

/// A bar on stderr, with the time left; it is not drawn where stderr is no terminal.
fn bar(what: &str) -> ProgressBar {
    let bar = super::bar(1);
    if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {percent} %, {eta} left") {
        bar.set_style(style);
    }
    bar.set_message(what.to_string());
    bar
}

fn show(bar: &ProgressBar, progress: Progress) {
    bar.set_length(progress.of);
    bar.set_position(progress.done);
}

/// A time series in the making.
struct Table {
    path: PathBuf,
    series: Series<BufWriter<Stream>>,
}

/// The time series that are asked for.
struct Tables<'a> {
    scenarios: &'a [Scenario],
    tables: Vec<Table>,
}

impl<'a> Tables<'a> {
    fn open(arguments: &Arguments, outputs: &Outputs, scenarios: &'a [Scenario]) -> Result<Self> {
        let mut tables = Vec::new();
        for (path, parquet) in [(&arguments.csv, false), (&arguments.parquet, true)] {
            let Some(path) = path else { continue };
            let to = BufWriter::new(outputs.open(path)?);
            let series = if parquet { Series::parquet(to) } else { Series::csv(to) };
            tables.push(Table { path: path.clone(), series: series.map_err(|error| outputs::fault(path, &error))? });
        }
        Ok(Tables { scenarios, tables })
    }

    fn push(&mut self, motion: &str, row: &Row<'_>) -> Result<()> {
        for table in &mut self.tables {
            let pushed = table.series.push(motion, self.scenarios, row);
            pushed.map_err(|error| outputs::fault(&table.path, &error))?;
        }
        Ok(())
    }

    fn finish(self, outputs: &mut Outputs) -> Result<()> {
        for table in self.tables {
            let whole = table.series.finish().and_then(|file| file.into_inner().map_err(|error| error.into_error()));
            outputs.finish(whole.map_err(|error| outputs::fault(&table.path, &error))?);
        }
        Ok(())
    }
}

pub(super) fn check(path: &Path) -> Result<String> {
    let (file, source) = files::mission(path)?;
    let mission = file.mission().map_err(|error| wire::locate(error, &source))?;
    let names: Vec<String> = study::motions(&mission).into_iter().map(|(name, _)| name).collect();
    Ok(describe(&file, &names.join(", "), mission.errors.present().len()))
}

fn describe(file: &MissionFile, motions: &str, sources: usize) -> String {
    format!(
        "a mission of {} h in steps of {} s; motions: {motions}; {sources} error sources",
        file.duration_h, file.step_s
    )
}
