//! A calibration as source code or as another program's file.
//!
//! The exported code does what [`Corrector::correct`](super::Corrector::correct) does, step for step with the same constants, so that the results agree to
//! rounding. Each file holds test samples (readings of the exact lines at known inputs) and checks itself against them. One description of
//! the unit serves all languages (`source`); a language is how it writes numbers and lists (`languages.rs`) and a template
//! (`data/templates/export`).

mod languages;
mod yaml;

use super::bound::direction_of;
use super::solve::{CONTRACTING, ROUNDS};
use super::{CalibratedLine, Calibration, Corrector, LineInput, Quantity};
use crate::error::{Fault, Malformed, Result};
use languages::{HEADER, Language, number};
use nalgebra::{DMatrix, Vector3};

/// What a calibration can be exported to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// C99, double or (with `TUMBLE_FLOAT` defined) float; it needs no header of its own.
    C,
    /// What other C or C++ files include.
    CHeader,
    /// Python 3 without packages.
    Python,
    /// MATLAB or GNU Octave.
    Matlab,
    /// Intrinsics of kalibr's scale-misalignment model (YAML).
    Kalibr,
    /// Parameters of the ROS package imu_calib (YAML).
    Ros,
}

/// Where an export comes from; printed at its top.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Origin {
    /// Name and version of the program.
    pub program: String,
    /// The report that held the calibration.
    pub report: String,
    /// Lines about the unit (serial number, date), as they stand.
    pub unit: Vec<String>,
    /// What the names of C and the function of MATLAB begin with; `tumble` where it is not said.
    pub prefix: Option<String>,
    /// For kalibr: the noise keys of its IMU file, as `tumble noise --kalibr` writes them.
    pub noise: Option<String>,
}

/// The calibration as text of a file.
///
/// Errors: `Missing` where it corrects nothing, or where the target needs a whole vector of rates or forces that this unit does not measure;
/// `Value` for a prefix that begins no name.
///
/// ```
/// use tumble::{correction::{Calibration, export}, fit, wire};
/// let text = r#"{ "bench": { "id": "b", "chain": [ {"joint": "t", "about": "x"} ],
///       "sensors": { "V": { "axes": {"I": "z"}, "model": "V0 + k*a_I" } } },
///     "known": { "k": { "value": 2 } }, "estimate": { "V0": {} }, "readings": [ {"t_deg": 0, "V": 2.5} ] }"#;
/// let source = wire::Source { name: "b".into(), text: text.into() };
/// let campaign = wire::read_campaign(&source, &mut |_| unreachable!())?;
/// let calibration = Calibration::of(&fit::fit(&campaign, &fit::Settings::default())?);
/// let python = export::export(&calibration, export::Target::Python, &export::Origin::default())?;
/// assert!(python.contains("BIAS = [0.5]") && python.contains("MATRIX = [[0.5]]"));
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
pub fn export(calibration: &Calibration, target: Target, origin: &Origin) -> Result<String> {
    let corrector = Corrector::new(calibration)?;
    match (target, Language::of(target)) {
        (Target::Ros, _) => yaml::ros(calibration, &corrector, origin),
        (_, Some(language)) => source(calibration, &corrector, target, language, origin),
        (_, None) => yaml::kalibr(calibration, &corrector, origin),
    }
}

/// The unit in a language: its lines and their slopes over components `x` along distinct axes, each a sum of inputs.
fn source(
    calibration: &Calibration,
    corrector: &Corrector,
    target: Target,
    language: &Language,
    origin: &Origin,
) -> Result<String> {
    let prefix = prefix(origin)?;
    // how a language calls each input: the solved ones are elements of q, the others of given
    let named = |(k, input): (usize, &LineInput)| {
        let before = calibration.inputs.iter().take(k).filter(|other| other.solved == input.solved).count();
        (language.element)(if input.solved { "q" } else { "given" }, before)
    };
    let inputs: Vec<String> = calibration.inputs.iter().enumerate().map(named).collect();
    let mut axes: Vec<(Quantity, Vector3<f64>)> = Vec::new();
    for axis in calibration.lines.iter().flat_map(|line| axes_of(line, calibration)).map(|(_, axis)| axis) {
        if !axes.contains(&axis) {
            axes.push(axis);
        }
    }
    // what one unit of input k adds along an axis
    let share = |axis: &(Quantity, Vector3<f64>), k: usize| {
        let part = corrector.parts().get(k);
        part.map_or(0.0, |(rate, force)| axis.1.dot(if axis.0 == Quantity::Rate { rate } else { force }))
    };
    let term = |factor: f64, what: &str| match factor {
        1.0 => what.to_string(),
        factor => format!("({} * {what})", signed(language, factor)),
    };
    let sum = |terms: Vec<String>| match terms.as_slice() {
        [] => (language.algebra.number)(0.0),
        terms => terms.join(" + "),
    };
    let name_in = |line: &CalibratedLine, name: &str| {
        if calibration.parameters.order.iter().any(|p| p == name) {
            return (language.parameter)(name);
        }
        let axis = direction_of(line, name).and_then(|axis| axes.iter().position(|other| *other == axis));
        // `Corrector::new` has refused every name that is no input either
        let given = || calibration.inputs.iter().position(|i| i.name == name).and_then(|k| inputs.get(k).cloned());
        axis.map_or_else(|| given().unwrap_or_default(), |k| (language.element)("x", k))
    };
    let (mut components, mut lines, mut slopes) = (String::new(), String::new(), String::new());
    for (k, axis) in axes.iter().enumerate() {
        let terms = inputs.iter().enumerate().filter(|(input, _)| share(axis, *input) != 0.0);
        let terms = terms.map(|(input, name)| term(share(axis, input), name)).collect();
        components += &(language.assignment)(&(language.element)("x", k), &sum(terms));
    }
    let solved: Vec<usize> =
        (0..inputs.len()).filter(|k| calibration.inputs.get(*k).is_some_and(|i| i.solved)).collect();
    for (i, line) in calibration.lines.iter().enumerate() {
        let name = |name: &str| name_in(line, name);
        let value = line.model.in_language(&language.algebra, &name);
        lines += &(language.assignment)(&(language.element)("s", i), &value);
        for (j, input) in solved.iter().enumerate() {
            let along = axes_of(line, calibration).filter(|(_, axis)| share(axis, *input) != 0.0);
            let terms: Vec<String> = along
                .filter_map(|(by, axis)| {
                    Some(term(share(&axis, *input), &line.model.slope_in_language(&language.algebra, &name, by)?))
                })
                .collect();
            if !terms.is_empty() {
                slopes += &(language.assignment)(&(language.element_of_rows)("d", i, j), &sum(terms));
            }
        }
    }
    let used = |name: &str| calibration.lines.iter().any(|line| line.model.names().contains(&name));
    let parameters =
        calibration.parameters.order.iter().zip(&calibration.parameters.values).filter(|(name, _)| used(name));
    let parameters: String =
        parameters.map(|(p, value)| (language.constant)(&(language.parameter)(p), &signed(language, *value))).collect();
    let samples = samples(calibration, corrector);
    let given = corrector.fallbacks();
    let all_given: Vec<Vec<f64>> = samples.iter().map(|_| given.clone()).collect();
    let (tested, readings): (Vec<_>, Vec<_>) = samples.into_iter().unzip();
    let template = if target == Target::CHeader { HEADER } else { language.template };
    let code = filled(
        &template.replace("@header@", HEADER),
        &[
            ("sensors", &calibration.lines.len().to_string()),
            ("inputs", &solved.len().to_string()),
            ("given", &given.len().to_string()),
            ("count", &axes.len().to_string()),
            ("rounds", &ROUNDS.to_string()),
            ("contracting", &CONTRACTING.to_string()),
            ("samples", &tested.len().to_string()),
            ("parameters", &parameters),
            ("bias", &(language.list)(corrector.bias())),
            ("matrix", &(language.rows)(&rows(corrector.matrix()))),
            ("otherwise", &(language.list)(&given)),
            ("axes", &components),
            ("lines", &lines),
            ("slopes", &slopes),
            ("test_readings", &(language.rows)(&readings)),
            ("test_given", &(language.rows)(&all_given)),
            ("test_inputs", &(language.rows)(&tested)),
        ],
    );
    let comment: String = comment(calibration, origin)
        .iter()
        .map(|line| format!("{}{}\n", language.comment, line.replace("*/", "* /").replace("/*", "/ *")))
        .collect();
    // last: what users wrote is not looked into
    Ok(filled(&code, &[("prefix", &prefix), ("PREFIX", &prefix.to_ascii_uppercase()), ("comment", &comment)]))
}

/// Names of a line that are rates or forces, with their axes.
fn axes_of<'a>(
    line: &'a CalibratedLine,
    calibration: &'a Calibration,
) -> impl Iterator<Item = (&'a str, (Quantity, Vector3<f64>))> {
    let names = line.model.names().into_iter().filter(|name| !calibration.parameters.order.iter().any(|p| p == name));
    names.filter_map(|name| Some((name, direction_of(line, name)?)))
}

/// A template with each `@key@` replaced; what is put in is not looked into again.
fn filled(template: &str, values: &[(&str, &str)]) -> String {
    let mut pieces = template.split('@');
    let mut text = pieces.next().unwrap_or_default().to_string();
    let mut open = true; // could the next piece be a key?
    for piece in pieces {
        match values.iter().find(|(key, _)| open && *key == piece) {
            Some((_, value)) => {
                text.push_str(value);
                open = false;
            }
            None => {
                if open {
                    text.push('@');
                }
                text.push_str(piece);
                open = true;
            }
        }
    }
    text
}

fn prefix(origin: &Origin) -> Result<String> {
    let prefix = origin.prefix.clone().unwrap_or_else(|| "tumble".into());
    let sound = prefix.starts_with(|c: char| c.is_ascii_alphabetic())
        && prefix.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if sound {
        return Ok(prefix);
    }
    Err(Malformed::new(Fault::Value, "the prefix begins no name in C or MATLAB")
        .expected("a letter, then letters, digits and underscores")
        .found(format!("'{prefix}'")))
}

/// What stands at the top: where the file comes from, the order of readings and inputs, the lines.
fn comment(calibration: &Calibration, origin: &Origin) -> Vec<String> {
    let inputs = |solved: bool| {
        let listed = calibration.inputs.iter().filter(|input| input.solved == solved);
        listed
            .map(|i| match (i.otherwise, i.unit.as_str()) {
                (None, unit) => format!("{} ({unit})", i.name),
                (Some(otherwise), "") => format!("{} (otherwise {otherwise})", i.name),
                (Some(otherwise), unit) => format!("{} ({unit}; otherwise {otherwise})", i.name),
            })
            .collect::<Vec<_>>()
            .join(", ")
    };
    let readings: Vec<String> = calibration.lines.iter().map(|l| format!("{} ({})", l.sensor, l.unit)).collect();
    let mut comment =
        vec!["Correction of a calibrated unit: readings to rates and specific forces along the sensor axes.".into()];
    comment.extend(origin_lines(origin));
    comment.push(format!("Readings, in this order: {}.", readings.join(", ")));
    comment.push(format!("Inputs, in this order: {}.", inputs(true)));
    if calibration.inputs.iter().any(|input| !input.solved) {
        comment.push(format!("Given with each sample, in this order: {}.", inputs(false)));
    }
    comment.extend(calibration.lines.iter().map(|line| format!("  {} = {}", line.sensor, line.model)));
    comment.iter().map(|line| one_line(line)).collect()
}

fn origin_lines(origin: &Origin) -> Vec<String> {
    let mut lines = vec![format!("Written by {} from {}.", origin.program, origin.report)];
    lines.extend(origin.unit.iter().cloned());
    lines
}

/// A text without what ends a line or turns its direction: a comment stays one.
fn one_line(text: &str) -> String {
    let turns = |c: char| matches!(c, '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    text.chars().map(|c| if c.is_control() || turns(c) { ' ' } else { c }).collect()
}

/// Inputs spread over half of the calibration's range, in a fixed pattern, and the readings of the exact lines there.
fn samples(calibration: &Calibration, corrector: &Corrector) -> Vec<(Vec<f64>, Vec<f64>)> {
    let given = corrector.fallbacks();
    (0..4)
        .map(|k| {
            let inputs: Vec<f64> = calibration
                .solved()
                .enumerate()
                .map(|(j, input)| {
                    let range = calibration.range_of(input);
                    // golden-ratio steps: no two samples or inputs alike
                    let share = ((k * 5 + j * 3 + 1) as f64 * 0.618_033_988_749_894_9).fract() - 0.5;
                    range * share
                })
                .collect();
            let readings = corrector.readings(&inputs, &given);
            (inputs, readings)
        })
        .collect()
}

fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}

/// A number in parentheses where it is negative.
fn signed(language: &Language, value: f64) -> String {
    let size = (language.algebra.number)(value.abs());
    if value < 0.0 { format!("(-{size})") } else { size }
}

fn needs(target: &str, what: &str, calibration: &Calibration) -> Malformed {
    let sensors: Vec<&str> = calibration.lines.iter().map(|line| line.sensor.as_str()).collect();
    Malformed::new(Fault::Missing, format!("{target} needs {what}"))
        .expected("a calibration of three sensors, no more, of independent directions")
        .found(sensors.join(", "))
}
