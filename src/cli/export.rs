//! `tumble export CALIBRATION --to TARGET`.

use super::outputs::Outputs;
use super::{Outcome, calibrations, files};
use crate::correction::export::{self, Origin, Target};
use crate::error::Result;
use crate::report::VERSION;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// What to export, and as what.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The calibration: a fit report (`tumble fit CAMPAIGN --json CALIBRATION`).
    calibration: PathBuf,
    /// The language or the other program's format.
    #[arg(long, value_enum)]
    to: Format,
    /// Write to a file; without it, to stdout.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// C99 source, double or float, with a self-test.
    C,
    /// Python module without packages, with a self-test.
    Python,
    /// MATLAB or Octave function `tumble_correct.m`, with a self-test.
    Matlab,
    /// kalibr's scale-misalignment intrinsics (YAML, inputs in SI units).
    Kalibr,
    /// Parameters of the ROS package imu_calib (YAML).
    Ros,
    /// The correction alone, as JSON.
    Json,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome> {
    let stored = calibrations::read(&arguments.calibration)?;
    let outputs = Outputs::plan([arguments.out.as_deref()])?;
    let target = match arguments.to {
        Format::C => Target::C,
        Format::Python => Target::Python,
        Format::Matlab => Target::Matlab,
        Format::Kalibr => Target::Kalibr,
        Format::Ros => Target::Ros,
        Format::Json => {
            let text = files::json(&stored.correction()?)?;
            return finish(outputs, arguments, text);
        }
    };
    let origin = Origin {
        program: format!("tumble {VERSION}"),
        report: arguments.calibration.display().to_string(),
        unit: stored.identity(),
    };
    let text = export::export(&stored.calibration()?, target, &origin)?;
    finish(outputs, arguments, text)
}

fn finish(outputs: Outputs, arguments: &Arguments, text: String) -> Result<Outcome> {
    match &arguments.out {
        Some(path) => {
            let mut outputs = outputs;
            outputs.add(path, text);
            outputs.write()?;
        }
        None => super::print(&text)?,
    }
    Ok(Outcome::Done)
}
