//! The `correction` of a fit report: written by `fit`, read by `apply` and `export`.

use crate::algebra::Expression;
use crate::bench::{ForceUnit, RateUnit};
use crate::correction::{
    CalibratedLine, Calibration, Corrector, InputRole, LineInput, Linearity, Mounting, Quantity, Span, linearity,
};
use crate::error::{Fault, Malformed, Result};
use crate::language::Sentence;
use nalgebra::{DMatrix, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How readings of the unit are corrected: to first order `inputs = matrix (readings - bias)`, exactly by the lines in `sensors`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CorrectionFile {
    /// Frame of the inputs: the last frame of the bench's chain.
    pub frame: String,
    /// Unit of rates: `deg/s`, `deg/h`, `rad/s` or `arcsec/s`.
    pub rate_unit: String,
    /// Unit of specific forces: `g` or `m/s^2`.
    pub force_unit: String,
    /// The sensors that take part, in the order of `bias` and of the columns of `matrix`.
    pub sensors: Vec<CorrectedSensorFile>,
    /// Sensors that cannot be corrected, each with the reason.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub left_out: BTreeMap<String, Sentence>,
    /// What the sensors determine, in the order of the rows of `matrix`; then what must be given with the readings.
    pub inputs: Vec<InputFile>,
    /// Readings at zero input, one for each sensor, in the sensor's unit.
    pub bias: Vec<f64>,
    /// Inputs by sensors, at zero input: the inverse of `sensitivity` (least squares where there are more sensors).
    pub matrix: Vec<Vec<f64>>,
    /// Derivative of each reading (row) by each input (column), at zero input, in the sensor's unit over the input's.
    pub sensitivity: Vec<Vec<f64>>,
    /// Where the first order holds.
    pub validity: Linearity,
    /// Values of the parameters that the lines use, and their covariance.
    pub parameters: CorrectionParametersFile,
    /// The rotation from the sensors' frame to the mounting face, where tilts after the last joint are known or estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mounting: Option<Mounting>,
}

/// A sensor of a correction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CorrectedSensorFile {
    /// Its name.
    pub id: String,
    /// Unit of its readings.
    pub unit: String,
    /// Its named axes, as direction cosines in the frame of the inputs.
    pub axes: BTreeMap<String, [f64; 3]>,
    /// Its model line.
    pub model: String,
}

/// An input of a correction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct InputFile {
    /// Its name, for example `w_x`.
    pub id: String,
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

/// Parameters of a correction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CorrectionParametersFile {
    /// Their names, also of the rows and columns of `covariance`.
    pub order: Vec<String>,
    /// Their values (tilts in rad).
    pub values: Vec<f64>,
    /// Their covariance, estimated and known inputs together, in products of their units; empty where no uncertainty is known.
    pub covariance: Vec<Vec<f64>>,
}

impl CorrectionFile {
    /// A calibration as a report writes it; `None` where it corrects nothing.
    pub fn of(calibration: &Calibration) -> Option<Self> {
        let corrector = Corrector::new(calibration).ok()?;
        let rows = |m: &DMatrix<f64>| m.row_iter().map(|row| row.iter().copied().collect()).collect();
        let input = |input: &LineInput| InputFile {
            id: input.name.clone(),
            quantity: input.quantity,
            unit: calibration.unit_of(input).into(),
            direction: matches!(input.quantity, Quantity::Rate | Quantity::Force)
                .then(|| [input.direction.x, input.direction.y, input.direction.z]),
            solved: input.role == InputRole::Solved,
            otherwise: (input.role == InputRole::Given).then_some(input.fallback),
        };
        let sensor = |line: &CalibratedLine| CorrectedSensorFile {
            id: line.sensor.clone(),
            unit: line.unit.clone(),
            axes: line.axes.iter().map(|(axis, d)| (axis.clone(), [d.x, d.y, d.z])).collect(),
            model: line.model.to_string(),
        };
        Some(CorrectionFile {
            frame: "the last frame of the bench's chain (sensor frame)".into(),
            rate_unit: calibration.rate_unit.name().into(),
            force_unit: calibration.force_unit.name().into(),
            sensors: calibration.lines.iter().map(sensor).collect(),
            left_out: calibration.left_out.iter().cloned().collect(),
            inputs: calibration.inputs.iter().map(input).collect(),
            bias: corrector.bias().to_vec(),
            matrix: rows(corrector.matrix()),
            sensitivity: rows(corrector.sensitivity()),
            validity: linearity(calibration, &corrector),
            parameters: CorrectionParametersFile {
                order: calibration.parameters.clone(),
                values: calibration.values.clone(),
                covariance: calibration.covariance.clone(),
            },
            mounting: calibration.mounting.clone(),
        })
    }

    /// The calibration that a report holds.
    ///
    /// Errors: an unknown unit, a line that is no algebra, sizes that do not agree; with the path below `correction`.
    pub fn into_calibration(self) -> Result<Calibration> {
        let unit = |path: &str, found: &str, expected: &str| {
            Malformed::new(Fault::Value, format!("'{found}' is not a unit here"))
                .expected(expected)
                .found(found)
                .at_path(path)
        };
        let rate_unit = RateUnit::ALL.into_iter().find(|unit| unit.name() == self.rate_unit);
        let rate_unit = rate_unit
            .ok_or_else(|| unit("correction.rate_unit", &self.rate_unit, "deg/s, deg/h, rad/s or arcsec/s"))?;
        let force_unit = ForceUnit::ALL.into_iter().find(|unit| unit.name() == self.force_unit);
        let force_unit = force_unit.ok_or_else(|| unit("correction.force_unit", &self.force_unit, "g or m/s^2"))?;
        let lines = self
            .sensors
            .into_iter()
            .enumerate()
            .map(|(k, sensor)| {
                let model = Expression::parse(&sensor.model)
                    .map_err(|error| error.moved_to(format!("correction.sensors[{k}].model")))?;
                let axes = sensor.axes.into_iter().map(|(axis, d)| (axis, Vector3::from(d))).collect();
                Ok(CalibratedLine { sensor: sensor.id, unit: sensor.unit, axes, model })
            })
            .collect::<Result<Vec<CalibratedLine>>>()?;
        let CorrectionParametersFile { order, values, covariance } = self.parameters;
        let n = order.len();
        let square = covariance.is_empty() || (covariance.len() == n && covariance.iter().all(|row| row.len() == n));
        if values.len() != n || !square {
            return Err(Malformed::new(Fault::Value, "the correction's parameters do not agree in number")
                .expected(format!("{n} values, and {n} x {n} covariances or none"))
                .found(format!("{} values, {} rows of covariances", values.len(), covariance.len()))
                .at_path("correction.parameters"));
        }
        if let Some(Mounting { tilts, by_tilt, covariance, .. }) = &self.mounting {
            let (t, rows) = (tilts.len(), covariance.len());
            let sizes = (rows == 0 || rows == t) && covariance.iter().all(|row| row.len() == n + t);
            if !sizes || (by_tilt.len() != t && !(by_tilt.is_empty() && rows == 0)) {
                return Err(Malformed::new(Fault::Value, "the mounting's tilts do not agree in number")
                    .expected(format!("{t} derivatives, and {t} x {} covariances or none", n + t))
                    .found(format!("{} derivatives, {rows} rows of covariances", by_tilt.len()))
                    .at_path("correction.mounting"));
            }
        }
        let inputs = self
            .inputs
            .into_iter()
            .map(|input| LineInput {
                name: input.id,
                quantity: input.quantity,
                direction: input.direction.map_or(Vector3::zeros(), Vector3::from),
                role: if input.solved { InputRole::Solved } else { InputRole::Given },
                fallback: input.otherwise.unwrap_or_default(),
            })
            .collect::<Vec<LineInput>>();
        let largest = |quantity: Quantity| {
            let solved = inputs.iter().filter(|i| i.role == InputRole::Solved);
            let ranges = solved.zip(&self.validity.range).filter(|(i, _)| i.quantity == quantity);
            ranges.map(|(_, range)| *range).fold(0.0, f64::max)
        };
        let span = Span { rate: largest(Quantity::Rate), force: largest(Quantity::Force) };
        Ok(Calibration {
            rate_unit,
            force_unit,
            lines,
            left_out: self.left_out.into_iter().collect(),
            span,
            inputs,
            parameters: order,
            values,
            covariance,
            mounting: self.mounting,
        })
    }
}
