//! `tumble apply CALIBRATION LOG`: a record corrected, row by row.

use super::outputs::Outputs;
use super::{Outcome, calibrations};
use crate::correction::{Calibration, Corrector, InputRole, Quantity};
use crate::error::{Fault, Malformed, Result};
use clap::{Args, ValueEnum};
use std::io::Write;
use std::path::{Path, PathBuf};

/// What to correct, and where to write it.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The calibration: a fit report (`tumble fit CAMPAIGN --json CALIBRATION`).
    calibration: PathBuf,
    /// The record: CSV with a header; one column for each sensor, under its name. '-' reads stdin.
    log: PathBuf,
    /// Write to a file; without it, CSV to stdout.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Also write the standard uncertainty of each input from the calibration (not the noise of the sample), as <input>_u.
    #[arg(long)]
    u: bool,
    /// Frame of the inputs: the sensors' own, or turned to the mounting face by the tilts after the last joint.
    #[arg(long, value_enum, default_value_t = Frame::Sensor)]
    frame: Frame,
    /// A sensor's column in the record, where it has another name; repeat for several.
    #[arg(long, value_name = "SENSOR=COLUMN", value_parser = pair)]
    column: Vec<(String, String)>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Frame {
    Sensor,
    Mount,
}

fn pair(text: &str) -> std::result::Result<(String, String), String> {
    text.split_once('=').map(|(a, b)| (a.to_string(), b.to_string())).ok_or_else(|| "expected SENSOR=COLUMN".into())
}

/// How a record's columns feed the correction.
struct Plan {
    /// Column of each sensor.
    sensors: Vec<usize>,
    /// Column of each given input and the factor to its unit; `None` where its fallback stands.
    given: Vec<Option<(usize, f64)>>,
    /// Columns that are copied.
    kept: Vec<usize>,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome> {
    let calibration = calibrations::read(&arguments.calibration)?.calibration()?;
    let corrector = Corrector::new(&calibration)?;
    let rotation = match arguments.frame {
        Frame::Sensor => None,
        Frame::Mount => Some(to_mount(&calibration)?),
    };
    let input: Box<dyn std::io::Read> = if arguments.log == Path::new("-") {
        Box::new(std::io::stdin().lock())
    } else {
        let name = arguments.log.display();
        super::session::reads(&arguments.log);
        Box::new(std::fs::File::open(&arguments.log).map_err(|error| {
            Malformed::new(Fault::File, format!("cannot read '{name}': {error}")).expected("a readable record (CSV)")
        })?)
    };
    let mut outputs = Outputs::plan([arguments.out.as_deref()])?;
    match &arguments.out {
        None => {
            let out = super::embedded::Stdout;
            correct(arguments, &calibration, &corrector, rotation.as_ref(), input, out)
        }
        Some(path) => {
            let mut stream = outputs.open(path)?;
            let outcome = correct(arguments, &calibration, &corrector, rotation.as_ref(), input, &mut stream)?;
            outputs.finish(stream);
            outputs.write()?;
            Ok(outcome)
        }
    }
}

/// Rotations of the solved rates and forces to the mounting face.
///
/// Errors: no tilts after the last joint, a tilt that is not estimable, a vector of which not all three components are solved for.
fn to_mount(calibration: &Calibration) -> Result<nalgebra::Matrix3<f64>> {
    let fault = |found: String| {
        Malformed::new(Fault::Missing, "the inputs cannot be turned to the mounting face")
            .expected(
                "tilts after the last joint that are known or estimable, and all three components of a rate or force",
            )
            .found(found)
    };
    let Some(mounting) = &calibration.mounting else { return Err(fault("no tilt after the last joint".into())) };
    if !mounting.missing.is_empty() {
        return Err(fault(format!("not estimable: {}", mounting.missing.join(", "))));
    }
    for quantity in [Quantity::Rate, Quantity::Force] {
        let solved: Vec<&str> =
            calibration.solved().filter(|i| i.quantity == quantity).map(|i| i.name.as_str()).collect();
        if !matches!(solved.len(), 0 | 3) {
            return Err(fault(format!("only {}", solved.join(", "))));
        }
    }
    Ok(mounting.rotation)
}

fn correct(
    arguments: &Arguments,
    calibration: &Calibration,
    corrector: &Corrector,
    rotation: Option<&nalgebra::Matrix3<f64>>,
    input: impl std::io::Read,
    output: impl Write,
) -> Result<Outcome> {
    let name = arguments.log.display().to_string();
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(input);
    let fault = |error: csv::Error| {
        let line = error.position().map_or(0, |p| p.line() as usize);
        Malformed::new(Fault::Syntax, format!("the record cannot be read: {error}"))
            .expected("CSV with one header line and as many cells in every row")
            .at_line(line, 1)
            .in_file(&name)
    };
    let header: Vec<String> = reader.headers().map_err(fault)?.iter().map(str::to_string).collect();
    let plan = plan(arguments, calibration, &header).map_err(|error| error.at_line(1, 1).in_file(&name))?;
    let solved: Vec<&str> = calibration.solved().map(|i| i.name.as_str()).collect();
    let mut writer = csv::Writer::from_writer(std::io::BufWriter::with_capacity(1 << 16, output));
    let unwritten = |error: &dyn std::fmt::Display| {
        Malformed::new(Fault::File, format!("the corrected record cannot be written: {error}"))
            .expected("room to write to")
    };
    let mut titles: Vec<String> = plan.kept.iter().filter_map(|k| header.get(*k).cloned()).collect();
    titles.extend(solved.iter().map(|s| (*s).to_string()));
    if arguments.u {
        titles.extend(solved.iter().map(|s| format!("{s}_u")));
    }
    writer.write_record(&titles).map_err(|e| unwritten(&e))?;
    let mut row = csv::StringRecord::new();
    let (mut readings, mut given) = (vec![0.0; plan.sensors.len()], corrector.fallbacks());
    let (mut count, mut failed) = (0_u64, 0_u64);
    while reader.read_record(&mut row).map_err(fault)? {
        count += 1;
        let number = |column: usize| -> Result<f64> {
            let cell = row.get(column).unwrap_or_default();
            if cell.is_empty() || cell.eq_ignore_ascii_case("nan") {
                return Ok(f64::NAN);
            }
            cell.parse::<f64>().map_err(|_| {
                Malformed::new(Fault::Value, format!("'{cell}' is no number"))
                    .expected("a number with a decimal point, or an empty cell")
                    .found(format!("'{cell}'"))
                    .at_path(header.get(column).cloned().unwrap_or_default())
                    .at_line(row.position().map_or(0, |p| p.line() as usize), 1)
                    .in_file(&name)
            })
        };
        for (reading, column) in readings.iter_mut().zip(&plan.sensors) {
            *reading = number(*column)?;
        }
        for (value, from) in given.iter_mut().zip(&plan.given) {
            if let Some((column, factor)) = from {
                *value = number(*column)? * factor;
            }
        }
        for k in &plan.kept {
            writer.write_field(row.get(*k).unwrap_or_default()).map_err(|e| unwritten(&e))?;
        }
        let corrected = corrector.correct(&readings, &given);
        failed += u64::from(!corrected.converged);
        let covariance = if arguments.u { corrector.covariance(&corrected.inputs, &given) } else { None };
        let (inputs, covariance) = turned(calibration, rotation, &corrected.inputs, covariance);
        let cell =
            |value: f64| if value.is_finite() && corrected.converged { value.to_string() } else { String::new() };
        for value in &inputs {
            writer.write_field(cell(*value)).map_err(|e| unwritten(&e))?;
        }
        if arguments.u {
            for k in 0..inputs.len() {
                let u = covariance.as_ref().map_or(f64::NAN, |c| c[(k, k)].max(0.0).sqrt());
                writer.write_field(cell(u)).map_err(|e| unwritten(&e))?;
            }
        }
        writer.write_record(None::<&[u8]>).map_err(|e| unwritten(&e))?;
    }
    writer.flush().map_err(|e| unwritten(&e))?;
    let notes = notes(calibration, &plan, count, failed);
    notes.iter().for_each(|note| super::note(&format!("note: {note}")));
    Ok(if failed > 0 { Outcome::Rejected } else { Outcome::Done })
}

/// The inputs in the frame asked for.
fn turned(
    calibration: &Calibration,
    rotation: Option<&nalgebra::Matrix3<f64>>,
    inputs: &[f64],
    covariance: Option<nalgebra::DMatrix<f64>>,
) -> (Vec<f64>, Option<nalgebra::DMatrix<f64>>) {
    let Some(rotation) = rotation else { return (inputs.to_vec(), covariance) };
    let n = inputs.len();
    let mut all = nalgebra::DMatrix::identity(n, n);
    let quantities: Vec<Quantity> = calibration.solved().map(|i| i.quantity).collect();
    for quantity in [Quantity::Rate, Quantity::Force] {
        let places: Vec<usize> = (0..n).filter(|k| quantities.get(*k) == Some(&quantity)).collect();
        if places.len() == 3 {
            for (i, row) in places.iter().enumerate() {
                for (j, column) in places.iter().enumerate() {
                    all[(*row, *column)] = rotation[(i, j)];
                }
            }
        }
    }
    let vector = nalgebra::DVector::from_column_slice(inputs);
    ((&all * vector).as_slice().to_vec(), covariance.map(|c| &all * c * all.transpose()))
}

fn plan(arguments: &Arguments, calibration: &Calibration, header: &[String]) -> Result<Plan> {
    let column = |name: &str| header.iter().position(|own| own == name);
    let mut sensors = Vec::new();
    for line in &calibration.lines {
        let renamed =
            arguments.column.iter().find(|(sensor, _)| *sensor == line.sensor).map(|(_, column)| column.as_str());
        let name = renamed.unwrap_or(&line.sensor);
        sensors.push(column(name).ok_or_else(|| {
            Malformed::new(Fault::Missing, format!("the record has no column '{name}' for the sensor {}", line.sensor))
                .expected(format!("a column '{name}', or --column {}=NAME", line.sensor))
                .found(format!("the columns {}", header.join(", ")))
        })?);
    }
    let given: Vec<Option<(usize, f64)>> = calibration
        .inputs
        .iter()
        .filter(|input| input.role == InputRole::Given)
        .map(|input| match (column(&input.name), input.quantity) {
            (Some(k), _) => Some((k, 1.0)),
            (None, Quantity::Angle) => {
                column(&format!("{}_deg", input.name)).map(|k| (k, std::f64::consts::PI / 180.0))
            }
            _ => None,
        })
        .collect();
    let solved: Vec<&str> = calibration.solved().map(|i| i.name.as_str()).collect();
    let kept = (0..header.len())
        .filter(|k| !sensors.contains(k) && header.get(*k).is_none_or(|name| !solved.contains(&name.as_str())))
        .collect();
    Ok(Plan { sensors, given, kept })
}

/// What was assumed, and what failed.
fn notes(calibration: &Calibration, plan: &Plan, count: u64, failed: u64) -> Vec<String> {
    let mut notes = Vec::new();
    let given = calibration.inputs.iter().filter(|i| i.role == InputRole::Given);
    for (input, _) in given.zip(&plan.given).filter(|(_, from)| from.is_none()) {
        let unit = calibration.unit_of(input);
        notes.push(
            format!("{} is not in the record: {} {unit} was taken", input.name, input.fallback)
                .trim_end()
                .replace("  ", " "),
        );
    }
    for (sensor, why) in &calibration.left_out {
        notes.push(format!("{sensor} is left out: {why}"));
    }
    if failed > 0 {
        notes.push(format!("{failed} of {count} rows could not be corrected (empty cells): no number, or no solution of the exact lines"));
    }
    notes
}
