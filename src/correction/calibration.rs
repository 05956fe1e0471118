//! A calibration as a value: model lines with their inputs, parameters with their covariance, and how the sensors sit.

use crate::algebra::Expression;
use crate::bench::{ForceUnit, RateUnit};
use crate::language::Sentence;
use crate::vocabulary::vocabulary;
use nalgebra::Vector3;

/// What is needed to correct readings of a calibrated unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// Unit of rates.
    pub rate_unit: RateUnit,
    /// Unit of specific forces.
    pub force_unit: ForceUnit,
    /// The sensors that take part, with their lines.
    pub lines: Vec<CalibratedLine>,
    /// Sensors that cannot be corrected, each with the reason.
    pub left_out: Vec<(String, Sentence)>,
    /// What the lines determine, and what must be given with the readings.
    pub inputs: Vec<LineInput>,
    /// Names of the parameters that the lines use.
    pub parameters: Vec<String>,
    /// Their values, in the bench's units (tilts in rad).
    pub values: Vec<f64>,
    /// Their covariance, row by row; empty where no uncertainty is known.
    pub covariance: Vec<Vec<f64>>,
    /// The rotation from the last frame (the sensors' own) to the mounting face; `None` where no tilt after the last joint is known or estimated.
    pub mounting: Option<Mounting>,
    /// The largest inputs that the readings of the calibration covered.
    pub span: Span,
}

/// One sensor and its model line.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibratedLine {
    /// The sensor.
    pub sensor: String,
    /// Unit of its readings.
    pub unit: String,
    /// Its named axes as direction cosines in the last frame.
    pub axes: Vec<(String, Vector3<f64>)>,
    /// `reading = model`.
    pub model: Expression,
}

vocabulary! {
    /// What an input is.
    #[schemars(rename = "QuantityFile")]
    Quantity {
        /// Angular rate.
        Rate = "rate",
        /// Specific force.
        Force = "force",
        /// A numeric column of the readings.
        Column = "column",
        /// The angle of a joint, in rad.
        Angle = "angle",
    }
}

/// How a corrected record comes by an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InputRole {
    /// The sensors determine it.
    Solved,
    /// It must be given with the readings, or else counts as `fallback`.
    Given,
}

/// An input of the model lines.
#[derive(Debug, Clone, PartialEq)]
pub struct LineInput {
    /// Its name in the lines, for example `w_x`.
    pub name: String,
    /// What it is.
    pub quantity: Quantity,
    /// Direction in the last frame, for rates and forces.
    pub direction: Vector3<f64>,
    /// Solved for, or given.
    pub role: InputRole,
    /// The value that is used where none is given: zero for rates and forces, the mean of the calibration's readings for columns.
    pub fallback: f64,
}

/// How the sensors' frame is turned against the mounting face.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "MountingFile")]
pub struct Mounting {
    /// The tilts, in chain order.
    pub tilts: Vec<String>,
    /// Those of them that are not estimable; the rotation holds them at their reference.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub missing: Vec<String>,
    /// `v_mount = rotation v_sensor`, row by row, a pure number.
    pub rotation: [[f64; 3]; 3],
    /// Derivative of `rotation` by each tilt, per rad. Files of earlier versions have none: the rotation then counts as exact.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub by_tilt: Vec<[[f64; 3]; 3]>,
    /// Covariance of the tilts (rows) with the parameters of `parameters.order` and then with the tilts themselves, in products of their units; empty where it
    /// is not known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub covariance: Vec<Vec<f64>>,
}

/// The largest rate and specific force of a calibration's positions, in the bench's units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Sum of the joints' rates and the Earth's, largest over the readings.
    pub rate: f64,
    /// Specific force at rest.
    pub force: f64,
}

impl Calibration {
    /// The unit of an input; empty where only its name tells.
    pub(crate) fn unit_of(&self, input: &LineInput) -> &'static str {
        match input.quantity {
            Quantity::Rate => self.rate_unit.name(),
            Quantity::Force => self.force_unit.name(),
            Quantity::Column => "",
            Quantity::Angle => "rad",
        }
    }

    /// What the calibration covered of a rate or force.
    pub(crate) fn range_of(&self, input: &LineInput) -> f64 {
        if input.quantity == Quantity::Rate { self.span.rate } else { self.span.force }
    }

    /// The inputs that are solved for, in order.
    pub(crate) fn solved(&self) -> impl Iterator<Item = &LineInput> {
        self.inputs.iter().filter(|input| input.role == InputRole::Solved)
    }
}
