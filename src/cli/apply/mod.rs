//! `tumble apply CALIBRATION LOG`: a record corrected, row by row.
//!
//! In blocks of columns (`columns.rs`); of a table of text, what is not corrected stays as it was written.

mod columns;

use super::outputs::{Outputs, Stream};
use super::{Outcome, calibrations};
use crate::correction::{Calibration, Corrector, Quantity, ToMount};
use crate::document::number::significant;
use crate::error::{Fault, Malformed, Result};
use crate::record::{Column, Record};
use crate::units::Conversion;
use crate::wire;
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};

/// What to correct, and where to write it.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The calibration: a fit report (`tumble fit CAMPAIGN --json CALIBRATION`).
    calibration: PathBuf,
    /// The record, CSV with a header, Parquet, a workbook, MATLAB, HDF5 or MCAP: one column for each sensor, under its name; FILE#NAME is one of its tables. '-' reads text from stdin.
    log: PathBuf,
    /// Write to a file, Parquet if its name ends in .parquet; without it, CSV to stdout.
    #[arg(long, short, visible_alias = "output", value_name = "FILE")]
    out: Option<PathBuf>,
    /// Also write the standard uncertainty of each input from the calibration (not the noise of the sample), as <input>_u. With '--frame mount' it
    /// includes that of the tilts.
    #[arg(long)]
    u: bool,
    /// Frame of the inputs: the sensor axes, or the mounting face (rotated by the tilts after the last joint).
    #[arg(long, value_enum, default_value_t = Frame::Sensor)]
    frame: Frame,
    /// Column of a sensor, or of an input such as a temperature, in the record, if its title is neither that name nor the title in the table of the calibration; repeat for several.
    #[arg(long, visible_alias = "columns", value_name = "NAME=COLUMN", value_parser = pair)]
    column: Vec<(String, String)>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Frame {
    Sensor,
    Mount,
}

fn pair(text: &str) -> std::result::Result<(String, String), String> {
    text.split_once('=').map(|(a, b)| (a.to_string(), b.to_string())).ok_or_else(|| "expected NAME=COLUMN".into())
}

/// How a record's columns feed the correction.
struct Plan {
    /// Column of each sensor.
    sensors: Vec<usize>,
    /// From the unit of each of these columns to the sensor's.
    conversions: Vec<Option<Conversion>>,
    /// Column of each given input and the conversion to its unit; `None` where its fallback is used.
    given: Vec<Option<(usize, Conversion)>>,
    /// Columns that are copied.
    kept: Vec<usize>,
}

/// A value is beyond what the calibration covered from this multiple of it, as the noise of a record at rest alone exceeds the one g of a calibration by positions. Up to there a square
/// or a cube that the model has not is at most 1.1^2 = 1.21 or 1.1^3 = 1.33 times what the residuals of the calibration could show.
const BEYOND: f64 = 1.1;

/// What is done to every row.
struct Correction<'a> {
    arguments: &'a Arguments,
    calibration: &'a Calibration,
    corrector: &'a Corrector,
    to_mount: Option<ToMount>,
}

/// What came of it, up to a fault.
#[derive(Default)]
struct Counts {
    rows: u64,
    failed: u64,
    /// Is each given input in the record?
    given: Vec<bool>,
    /// Of each corrected input: rows beyond what the calibration covered, and the largest value there.
    beyond: Vec<(u64, f64)>,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome> {
    let calibration = calibrations::read(&arguments.calibration)?.calibration()?;
    let corrector = Corrector::new(&calibration)?;
    let to_mount = match arguments.frame {
        Frame::Sensor => None,
        Frame::Mount => Some(ToMount::new(&calibration)?),
    };
    // a file of an earlier version
    if arguments.u
        && to_mount.is_some()
        && calibration.mounting.as_ref().is_some_and(|mounting| mounting.covariance.is_empty())
    {
        super::note(
            "note: the calibration does not contain the covariance of the mounting tilts: the uncertainties take the rotation to the mounting face as exact",
        );
    }
    let correction = Correction { arguments, calibration: &calibration, corrector: &corrector, to_mount };
    let mut outputs = Outputs::plan([arguments.out.as_deref()])?;
    let mut stream = outputs.open(arguments.out.as_deref().unwrap_or(Path::new("-")))?;
    let mut counts = Counts::default();
    let is_stream = arguments.log == Path::new("-");
    if arguments.out.as_deref().is_some_and(is_parquet) {
        if is_stream {
            return Err(Malformed::new(Fault::Value, "a stream of text cannot be written as Parquet")
                .expected("a record in a file, or --out with a name that ends in .csv"));
        }
        let mut open = || super::files::open(&arguments.log);
        stream = columns::to_columns(&correction, &mut open, &mut counts, stream)?;
    } else {
        let record = match is_stream {
            true => Record::of_stream("-", std::io::stdin()),
            false => super::files::open(&arguments.log),
        };
        let written = record.and_then(|record| columns::to_text(&correction, record, &mut counts, &mut stream));
        written.inspect_err(|error| {
            if arguments.out.is_none() && counts.rows > 0 && error.fault() != Fault::File {
                super::note(&format!("note: the {} rows before the fault are corrected and printed", counts.rows));
            }
        })?;
    }
    outputs.finish(stream);
    outputs.write()?;
    let notes = notes(&calibration, &counts, arguments.u);
    notes.iter().for_each(|note| super::note(&format!("note: {note}")));
    Ok(if counts.failed > 0 { Outcome::Rejected } else { Outcome::Done })
}

fn is_parquet(path: &Path) -> bool {
    path.extension().is_some_and(|end| end.eq_ignore_ascii_case("parquet") || end.eq_ignore_ascii_case("pq"))
}

/// Titles of the corrected columns.
fn titles(correction: &Correction<'_>) -> Vec<String> {
    let solved: Vec<&str> = correction.calibration.solved().map(|i| i.name.as_str()).collect();
    let mut titles: Vec<String> = solved.iter().map(|s| (*s).to_string()).collect();
    if correction.arguments.u {
        titles.extend(solved.iter().map(|s| format!("{s}_u")));
    }
    titles
}

impl Correction<'_> {
    /// The corrected inputs of a row, then their uncertainties where these are asked for; NaN and `false` where there is no solution.
    fn row(&self, readings: &[f64], given: &[f64]) -> (Vec<f64>, bool) {
        let corrected = self.corrector.correct(readings, given);
        let inputs = corrected.inputs;
        let mut values = self.to_mount.as_ref().map_or_else(|| inputs.clone(), |mount| mount.turned(&inputs));
        if self.arguments.u {
            let covariance = match &self.to_mount {
                Some(mount) => mount.covariance(self.corrector, &inputs, given),
                None => self.corrector.covariance(&inputs, given),
            };
            let n = values.len();
            values.extend((0..n).map(|k| covariance.as_ref().map_or(f64::NAN, |c| c[(k, k)].max(0.0).sqrt())));
        }
        if !corrected.converged {
            values.fill(f64::NAN);
        }
        (values, corrected.converged)
    }
}

fn plan(arguments: &Arguments, calibration: &Calibration, header: &[Column]) -> Result<Plan> {
    let column = |name: &str| {
        let titled = header.iter().position(|column| column.title == name);
        titled.or_else(|| header.iter().position(|column| column.name == name))
    };
    let titles = || header.iter().map(|column| format!("'{}'", column.title)).collect::<Vec<_>>().join(", ");
    // the column that was said to be it, or one of its name, or of the title that it had in the calibration
    let found = |name: &str, what: &str| -> Result<Option<usize>> {
        let Some((_, said)) = arguments.column.iter().find(|(of, _)| of == name) else {
            return Ok(column(name).or_else(|| column(calibration.titles.get(name)?)));
        };
        let there = column(said).ok_or_else(|| {
            Malformed::new(Fault::Missing, format!("the record has no column '{said}' for {what}"))
                .expected("one of the titles in the record's first line")
                .found(titles())
        });
        there.map(Some)
    };
    let given = || calibration.inputs.iter().filter(|input| !input.solved);
    let known = calibration.lines.iter().map(|line| &line.sensor).chain(given().map(|input| &input.name));
    let known: Vec<&str> = known.map(String::as_str).collect();
    if let Some((name, _)) = arguments.column.iter().find(|(name, _)| !known.contains(&name.as_str())) {
        return Err(Malformed::new(Fault::Missing, format!("--column {name}: the correction has no '{name}'"))
            .expected(known.join(", "))
            .found(name.clone()));
    }
    let converted =
        |k: usize, name: &str, to: &str| header.get(k).map_or(Ok(None), |column| wire::of_title(column, name, to));
    let (mut sensors, mut conversions) = (Vec::new(), Vec::new());
    for line in &calibration.lines {
        let name = &line.sensor;
        let k = found(name, &format!("the sensor {name}"))?.ok_or_else(|| {
            Malformed::new(Fault::Missing, format!("the record has no column '{name}' for the sensor {name}"))
                .expected(format!("a column '{name}', or --column {name}=NAME"))
                .found(titles())
        })?;
        conversions.push(converted(k, name, &line.unit)?);
        sensors.push(k);
    }
    let of = |k: usize, name: &str, to: &str| Ok((k, converted(k, name, to)?.unwrap_or(Conversion::NONE)));
    let radian = crate::units::Unit::parse("deg")?.conversion(&crate::units::Unit::parse("rad")?);
    let given: Vec<Option<(usize, Conversion)>> = given()
        .map(|input| match (found(&input.name, &input.name)?, input.quantity, crate::units::of_column(&input.name)) {
            (Some(k), _, Some(unit)) => of(k, &input.name, &unit).map(Some),
            (Some(k), Quantity::Angle, None) => of(k, &input.name, "rad").map(Some),
            (Some(k), ..) => Ok(Some((k, Conversion::NONE))),
            (None, Quantity::Angle, _) => Ok(column(&format!("{}_deg", input.name)).zip(radian)),
            _ => Ok(None),
        })
        .collect::<Result<_>>()?;
    let solved: Vec<&str> = calibration.solved().map(|i| i.name.as_str()).collect();
    let kept = (0..header.len())
        .filter(|k| !sensors.contains(k) && header.get(*k).is_none_or(|column| !solved.contains(&column.name.as_str())))
        .collect();
    Ok(Plan { sensors, conversions, given, kept })
}

/// What was assumed, and what failed.
fn notes(calibration: &Calibration, counts: &Counts, u: bool) -> Vec<String> {
    let mut notes = Vec::new();
    let given = calibration.inputs.iter().filter(|i| !i.solved);
    for (input, _) in given.zip(&counts.given).filter(|(_, there)| !**there) {
        let unit = &input.unit;
        // nothing says how far the record's value is from that one: what the campaign covered is no statement about the record
        let exact = if u { "; the uncertainties take it as exact" } else { "" };
        let taken = format!("{} {unit}", input.fallback());
        notes.push(format!("{} is not in the record: {} was taken{exact}", input.name, taken.trim_end()));
    }
    for (sensor, why) in &calibration.left_out {
        notes.push(format!("{sensor} is left out: {why}"));
    }
    let Counts { rows, failed, .. } = counts;
    for (input, (beyond, most)) in calibration.solved().zip(&counts.beyond).filter(|(_, (beyond, _))| *beyond > 0) {
        let (range, unit) = (significant(calibration.range_of(input), 4), &input.unit);
        let (name, most) = (&input.name, significant(*most, 4));
        notes.push(format!(
            "{name} of {beyond} of {rows} rows lies beyond +-{range} {unit}, the range of the calibration (up to {most} {unit}): the correction is extrapolated there, and u does not include that"
        ));
    }
    if *failed > 0 {
        notes.push(format!(
            "{failed} of {rows} rows could not be corrected (empty cells): no number, or no solution of the exact lines"
        ));
    }
    notes
}
