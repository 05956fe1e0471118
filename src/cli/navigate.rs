//! `tumble navigate MISSION`.

use super::outputs::Stream;
use super::pages::Pages;
use super::rows::{Cell, Format, Kind, Rows, Titles};
use super::{Outcome, files};
use crate::error::{Fault, Malformed, Result};
use crate::language::Language;
use crate::navigate::measured::{CHANNEL_NAMES, CHANNELS, Measured, MeasuredRow, channels, si_per_unit};
use crate::navigate::mission::Mission;
use crate::navigate::propagation::{self, SourceCovariance};
use crate::navigate::run::{Continue, Row, Scenario};
use crate::navigate::study::{self, Progress};
use crate::number;
use crate::report::{self, ARCSEC};
use crate::wire;
use clap::Args;
use indicatif::ProgressBar;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use std::path::{Path, PathBuf};

/// What to fly and what to write.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The mission file (JSON).
    mission: PathBuf,
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
    let (file, mission, source) = files::mission(&arguments.mission)?;
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
    let [csv, parquet, measured] = [&arguments.csv, &arguments.parquet, &arguments.measured].map(Option::as_deref);
    let mut outputs = arguments.pages.outputs([csv, parquet, measured])?;
    let mut series = Vec::new();
    for (path, format) in [(csv, Format::Csv), (parquet, Format::Parquet)] {
        let Some(path) = path else { continue };
        let rows = Rows::begin(path, format, outputs.open(path)?, titles(), &[])?;
        series.push(Series { rows, waiting: Vec::new() });
    }
    let mut instruments = Instruments::new(arguments, &mission)?;

    let bar = bar("flying");
    let mut fault = None;
    let flown = study::fly(&mission, &scenarios, &mut |motion, row, progress| {
        show(&bar, progress);
        instruments.measure(motion, row);
        fault = series.iter_mut().try_for_each(|file| file.push(motion, &scenarios, row)).err();
        if fault.is_none() { Continue::Yes } else { Continue::Stop }
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
    for file in series {
        outputs.finish(file.finish()?);
    }
    if let Some(path) = &arguments.measured {
        outputs.add(path, wire::write_measured(&instruments.measured, &mission));
    }
    let document = |_| report::navigate_document(&report, Some((&mission, &flown)), lang);
    arguments.pages.finish(outputs, &report, document)
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
                return Err(Malformed::new(Fault::Value, format!("{name} is not a standard uncertainty"))
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
        let (Some(error), Some(index)) = (row.errors.first(), self.motions.iter().position(|m| m == motion)) else {
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
    super::bar(1, "{msg} {wide_bar} {percent} %, {eta} left").with_message(what.to_string())
}

fn show(bar: &ProgressBar, progress: Progress) {
    bar.set_length(progress.of);
    bar.set_position(progress.done);
}

/// The columns of a time series.
fn titles() -> Titles {
    let names = ["motion", "scenario"].map(|name| (name.to_string(), Kind::Text));
    let numbers = ["time_s"].into_iter().chain(CHANNEL_NAMES).map(|name| (name.to_string(), Kind::Exponent));
    names.into_iter().chain(numbers).collect()
}

/// Rows that are written together: a group of a columnar file, some MB of memory.
const GROUP: usize = 1 << 14;

/// The errors in time on their way out: memory does not grow with the mission.
struct Series {
    rows: Rows,
    /// Motion, scenario and numbers of the rows that wait for the others of their group.
    waiting: Vec<([String; 2], [f64; 1 + CHANNELS])>,
}

impl Series {
    /// One instant of all scenarios.
    fn push(&mut self, motion: &str, scenarios: &[Scenario], row: &Row<'_>) -> Result<()> {
        for (scenario, error) in scenarios.iter().zip(row.errors) {
            let [e, n, u] = error.attitude.map(|phi| phi * ARCSEC);
            let ([ve, vn, ..], [pe, pn, ..]) = (error.velocity, error.position);
            let values = [row.truth.time, e, n, u, ve, vn, pe, pn];
            self.waiting.push(([motion.to_string(), scenario.id.clone()], values));
        }
        if self.waiting.len() < GROUP { Ok(()) } else { self.flush() }
    }

    fn flush(&mut self) -> Result<()> {
        let cells = |(names, values): &'_ ([String; 2], [f64; 1 + CHANNELS])| {
            let names = names.clone().map(|name| Cell::Text(name.into()));
            names.into_iter().chain(values.map(Cell::Number)).collect()
        };
        self.rows.write(&std::mem::take(&mut self.waiting).iter().map(cells).collect::<Vec<_>>())
    }

    fn finish(mut self) -> Result<Stream> {
        self.flush()?;
        self.rows.finish()
    }
}

pub(super) fn check(path: &Path) -> Result<String> {
    let (file, mission, _) = files::mission(path)?;
    let names: Vec<String> = study::motions(&mission).into_iter().map(|(name, _)| name).collect();
    let (motions, sources) = (names.join(", "), mission.errors.present().len());
    Ok(format!(
        "a mission of {} h in steps of {} s; motions: {motions}; {sources} error sources",
        file.duration_h, file.step_s
    ))
}
