//! A calibration as source code or as another program's file.
//!
//! The exported code does what [`Corrector::correct`](super::Corrector::correct) does: `q = 0`, then `q <- q + M (s - f(q))` to the fixed point, with the same constants in
//! the same order, so that the results agree to rounding; beyond a contraction it reports failure instead of Newton's steps. Each file holds
//! test samples (readings of the exact lines at known inputs) and checks itself against them.

mod c;
mod matlab;
mod python;
mod yaml;

use super::{Calibration, Corrector, InputRole};
use crate::algebra::{Function, Language};
use crate::error::{Fault, Malformed, Result};
use nalgebra::Vector3;

/// What a calibration can be exported to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// C99, double or (with `TUMBLE_FLOAT` defined) float.
    C,
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
}

/// The calibration as text of a file.
///
/// Errors: `Missing` where it corrects nothing, or where the target needs a whole vector of rates or forces that this unit does not measure.
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
    match target {
        Target::C => Ok(c::write(&Parts::new(calibration, &corrector, origin))),
        Target::Python => Ok(python::write(&Parts::new(calibration, &corrector, origin))),
        Target::Matlab => Ok(matlab::write(&Parts::new(calibration, &corrector, origin))),
        Target::Kalibr => yaml::kalibr(calibration, &corrector, origin),
        Target::Ros => yaml::ros(calibration, &corrector, origin),
    }
}

/// A test sample: inputs, what is given, and the readings of the exact lines there.
pub(super) struct Sample {
    pub(super) inputs: Vec<f64>,
    pub(super) given: Vec<f64>,
    pub(super) readings: Vec<f64>,
}

/// What every language writes.
pub(super) struct Parts<'a> {
    pub(super) calibration: &'a Calibration,
    pub(super) corrector: &'a Corrector,
    pub(super) comment: Vec<String>,
    pub(super) samples: Vec<Sample>,
    /// Rate and force vectors of one unit of each input, solved ones first.
    pub(super) vectors: Vec<(Vector3<f64>, Vector3<f64>)>,
}

impl<'a> Parts<'a> {
    fn new(calibration: &'a Calibration, corrector: &'a Corrector, origin: &Origin) -> Self {
        let solved: Vec<String> =
            calibration.solved().map(|i| format!("{} ({})", i.name, calibration.unit_of(i))).collect();
        let given: Vec<String> = calibration
            .inputs
            .iter()
            .filter(|i| i.role == InputRole::Given)
            .map(|i| format!("{} ({}; otherwise {})", i.name, calibration.unit_of(i), i.fallback))
            .collect();
        let readings: Vec<String> = calibration.lines.iter().map(|l| format!("{} ({})", l.sensor, l.unit)).collect();
        let mut comment = vec![
            "Correction of a calibrated unit: readings to rates and specific forces along the sensors' own axes."
                .to_string(),
            format!("Written by {} from {}.", origin.program, origin.report),
        ];
        comment.extend(origin.unit.iter().cloned());
        comment.push(format!("Readings, in this order: {}.", readings.join(", ")));
        comment.push(format!("Inputs, in this order: {}.", solved.join(", ")));
        if !given.is_empty() {
            comment.push(format!("Given with each sample, in this order: {}.", given.join(", ")));
        }
        for line in &calibration.lines {
            comment.push(format!("  {} = {}", line.sensor, line.model));
        }
        Parts {
            calibration,
            corrector,
            comment,
            samples: samples(calibration, corrector),
            vectors: corrector.parts().to_vec(),
        }
    }

    pub(super) fn given(&self) -> usize {
        self.calibration.inputs.len() - self.corrector.solved()
    }
}

/// Inputs spread over half of the calibration's range, in a fixed pattern.
fn samples(calibration: &Calibration, corrector: &Corrector) -> Vec<Sample> {
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
            Sample { inputs, given: given.clone(), readings }
        })
        .collect()
}

/// The shortest text that reads back as the same number, with an exponent or a point.
pub(super) fn number(value: f64) -> String {
    format!("{value:?}")
}

/// The function's name in C, Python's `math` and MATLAB where all three agree.
pub(super) fn shared_name(function: Function) -> Option<&'static str> {
    match function {
        Function::Sin
        | Function::Cos
        | Function::Tan
        | Function::Asin
        | Function::Acos
        | Function::Atan
        | Function::Sqrt
        | Function::Exp => Some(function.name()),
        _ => None,
    }
}

/// The line of every sensor in a language.
pub(super) fn lines_in(parts: &Parts<'_>, language: &Language, input: &dyn Fn(Slot<'_>) -> String) -> Vec<String> {
    let calibration = parts.calibration;
    calibration
        .lines
        .iter()
        .map(|line| {
            line.model.in_language(language, &|name| {
                if calibration.parameters.iter().any(|p| p == name) {
                    return input(Slot::Parameter(name));
                }
                if let Some((quantity, direction)) = super::bound::direction_of(line, name) {
                    return input(Slot::Axis(quantity, direction));
                }
                let given =
                    calibration.inputs.iter().filter(|i| i.role == InputRole::Given).position(|i| i.name == name);
                // `Corrector::new` has refused every other name
                input(Slot::Given(given.unwrap_or_default()))
            })
        })
        .collect()
}

/// What a name of a line is.
pub(super) enum Slot<'a> {
    Parameter(&'a str),
    Axis(super::Quantity, Vector3<f64>),
    Given(usize),
}

/// A component along a direction as a sum over `vector[0..3]`, terms of zero left out.
pub(super) fn component(vector: &str, direction: &Vector3<f64>, index: &dyn Fn(usize) -> String) -> String {
    let terms: Vec<String> = (0..3)
        .filter(|k| direction[*k] != 0.0)
        .map(|k| {
            let element = format!("{vector}{}", index(k));
            if direction[k] == 1.0 { element } else { format!("({} * {element})", signed(direction[k])) }
        })
        .collect();
    if terms.is_empty() { "0.0".into() } else { format!("({})", terms.join(" + ")) }
}

/// A number in parentheses where it is negative.
pub(super) fn signed(value: f64) -> String {
    if value < 0.0 { format!("({})", number(value)) } else { number(value) }
}

fn needs(target: &str, what: &str) -> Malformed {
    Malformed::new(Fault::Missing, format!("{target} needs {what}"))
        .expected("a calibration of three sensors of independent directions")
        .found("fewer")
}
