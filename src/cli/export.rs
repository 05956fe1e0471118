//! `tumble export CALIBRATION --to TARGET`.

use super::outputs::Outputs;
use super::{Outcome, calibrations, files, written};
use crate::correction::export::{self, Origin, Target};
use crate::error::{Fault, Malformed, Result};
use crate::report::VERSION;
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};

/// What to export, and as what.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The calibration: a fit report (`tumble fit CAMPAIGN --json CALIBRATION`).
    calibration: PathBuf,
    /// The language or the other program's format.
    #[arg(long, value_enum)]
    to: Format,
    /// Write to a file; without it, to stdout.
    #[arg(long, short, visible_alias = "output", value_name = "FILE")]
    out: Option<PathBuf>,
    /// Prefix of the names in C and of the function in MATLAB (default 'tumble'), so that one program can hold several units.
    #[arg(long, value_name = "NAME")]
    prefix: Option<String>,
    /// For kalibr: the noise of the unit's samples, a report of `tumble noise LOG --json FILE`.
    #[arg(long, value_name = "FILE")]
    noise: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// C99 source, double or float, with a self-test; where --out ends in .c, also its header (.h).
    C,
    /// Python module without packages, with a self-test.
    Python,
    /// MATLAB or Octave function (keep it as `tumble_correct.m`), with a self-test.
    Matlab,
    /// kalibr's IMU file (YAML, inputs in SI units).
    Kalibr,
    /// Parameters of the ROS package imu_calib (YAML).
    Ros,
    /// The correction alone, as JSON.
    Json,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome> {
    let stored = calibrations::read(&arguments.calibration)?;
    for (asked, option, targets) in [
        (arguments.prefix.is_some(), "--prefix", &[Format::C, Format::Matlab][..]),
        (arguments.noise.is_some(), "--noise", &[Format::Kalibr]),
    ] {
        if asked && !targets.contains(&arguments.to) {
            return Err(Malformed::new(Fault::Value, format!("{option} has no meaning for this format"))
                .expected(if option == "--prefix" { "--to c or --to matlab" } else { "--to kalibr" }));
        }
    }
    let header = (arguments.to == Format::C)
        .then(|| arguments.out.as_ref().filter(|out| out.extension().is_some_and(|end| end == "c")))
        .flatten()
        .map(|out| out.with_extension("h"));
    let mut outputs = Outputs::plan([arguments.out.as_deref(), header.as_deref()])?;
    let target = match arguments.to {
        Format::C => Some(Target::C),
        Format::Python => Some(Target::Python),
        Format::Matlab => Some(Target::Matlab),
        Format::Kalibr => Some(Target::Kalibr),
        Format::Ros => Some(Target::Ros),
        Format::Json => None,
    };
    let text = match target {
        None => {
            let text = files::json(&stored.correction()?)?;
            // a file says what wrote it
            if arguments.out.is_some() { written::mark(&text) } else { text }
        }
        Some(target) => {
            let noise = arguments.noise.as_ref().map(|path| crate::wire::parse(&files::read(path)?));
            let origin = Origin {
                program: format!("tumble {VERSION}"),
                report: arguments.calibration.display().to_string(),
                unit: stored.identity(),
                prefix: arguments.prefix.clone(),
                noise: noise.transpose()?.map(|report| crate::report::kalibr(&report)).transpose()?,
            };
            let calibration = stored.calibration()?;
            if let Some(path) = header {
                outputs.add(&path, export::export(&calibration, Target::CHeader, &origin)?);
            }
            export::export(&calibration, target, &origin)?
        }
    };
    outputs.add(arguments.out.as_deref().unwrap_or(Path::new("-")), text);
    outputs.write()?;
    Ok(Outcome::Done)
}
