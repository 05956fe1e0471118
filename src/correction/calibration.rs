//! A calibration as a value: model lines with their inputs, parameters with their covariance, and how the sensors sit.

use crate::algebra::Expression;
use crate::bench::{ForceUnit, RateUnit};
use crate::language::Sentence;
use crate::vocabulary::vocabulary;
use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

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
    /// The parameters that the lines use.
    pub parameters: Parameters,
    /// The rotation from the last frame (the sensors' own) to the mounting face; `None` where no tilt after the last joint is known or estimated.
    pub mounting: Option<Mounting>,
    /// The largest inputs that the readings of the calibration covered.
    pub span: Span,
    /// Titles that sensors and inputs had in the table of the calibration, where they are not their names.
    pub titles: BTreeMap<String, String>,
}

/// Parameters of a correction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "CorrectionParametersFile")]
pub struct Parameters {
    /// Their names, also of the rows and columns of `covariance`.
    pub order: Vec<String>,
    /// Their values (tilts in rad).
    pub values: Vec<f64>,
    /// Their covariance, estimated and known inputs together, in products of their units; empty where no uncertainty is known.
    pub covariance: Vec<Vec<f64>>,
}

/// A sensor of a correction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "CorrectedSensorFile")]
pub struct CalibratedLine {
    /// Its name.
    #[serde(rename = "id")]
    pub sensor: String,
    /// Unit of its readings.
    pub unit: String,
    /// Its named axes, as direction cosines in the frame of the inputs.
    pub axes: BTreeMap<String, [f64; 3]>,
    /// Its model line.
    #[schemars(with = "String")]
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

/// An input of a correction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "InputFile")]
pub struct LineInput {
    /// Its name, for example `w_x`.
    #[serde(rename = "id")]
    pub name: String,
    /// `rate`, `force`, `column` or `angle`.
    pub quantity: Quantity,
    /// Unit.
    pub unit: String,
    /// Direction of a rate or force in the frame of the inputs, pure numbers whose squares sum to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<[f64; 3]>,
    /// Is it solved for? Otherwise it is given with the readings.
    pub solved: bool,
    /// Value of a given input where the readings do not give it, in the input's unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub otherwise: Option<f64>,
}

impl LineInput {
    /// Its direction; zero for what has none.
    pub fn direction(&self) -> Vector3<f64> {
        self.direction.map_or(Vector3::zeros(), Vector3::from)
    }

    /// Its value where the readings do not give it.
    pub(crate) fn fallback(&self) -> f64 {
        self.otherwise.unwrap_or_default()
    }
}

/// How the sensors' frame is turned against the mounting face.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
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
    pub(super) fn unit_of(&self, quantity: Quantity) -> &'static str {
        match quantity {
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
        self.inputs.iter().filter(|input| input.solved)
    }
}
