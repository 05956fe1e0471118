//! The `correction` of a fit report: written by `fit`, read by `apply` and `export`.

use crate::bench::{ForceUnit, RateUnit};
use crate::correction::{
    CalibratedLine, Calibration, Corrector, LineInput, Linearity, Mounting, Parameters, Quantity, Span, linearity,
};
use crate::error::{Fault, Malformed, Result};
use crate::language::Sentence;
use nalgebra::DMatrix;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How readings of the unit are corrected: to first order `inputs = matrix (readings - bias)`, exactly by the lines in `sensors`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CorrectionFile {
    /// Frame of the inputs: the last frame of the bench's chain.
    pub frame: String,
    /// Unit of rates: `deg/s`, `deg/h`, `rad/s` or `arcsec/s`.
    #[schemars(with = "String")]
    pub rate_unit: RateUnit,
    /// Unit of specific forces: `g` or `m/s^2`.
    #[schemars(with = "String")]
    pub force_unit: ForceUnit,
    /// The sensors that take part, in the order of `bias` and of the columns of `matrix`.
    pub sensors: Vec<CalibratedLine>,
    /// Sensors that cannot be corrected, each with the reason.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub left_out: BTreeMap<String, Sentence>,
    /// What the sensors determine, in the order of the rows of `matrix`; then what must be given with the readings.
    pub inputs: Vec<LineInput>,
    /// Readings at zero input, one for each sensor, in the sensor's unit.
    pub bias: Vec<f64>,
    /// Inputs by sensors, at zero input: the inverse of `sensitivity` (least squares where there are more sensors).
    pub matrix: Vec<Vec<f64>>,
    /// Derivative of each reading (row) by each input (column), at zero input, in the sensor's unit over the input's.
    pub sensitivity: Vec<Vec<f64>>,
    /// Where the first order holds.
    pub validity: Linearity,
    /// Values of the parameters that the lines use, and their covariance.
    pub parameters: Parameters,
    /// The rotation from the sensors' frame to the mounting face, where tilts after the last joint are known or estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mounting: Option<Mounting>,
    /// Titles that sensors and inputs had in the table of the calibration, where they are not their names.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub columns: BTreeMap<String, String>,
}

impl CorrectionFile {
    /// A calibration as a report writes it; `None` where it corrects nothing.
    pub fn of(calibration: &Calibration) -> Option<Self> {
        let corrector = Corrector::new(calibration).ok()?;
        let rows = |m: &DMatrix<f64>| m.row_iter().map(|row| row.iter().copied().collect()).collect();
        Some(CorrectionFile {
            frame: "the last frame of the bench's chain (sensor frame)".into(),
            rate_unit: calibration.rate_unit,
            force_unit: calibration.force_unit,
            sensors: calibration.lines.clone(),
            left_out: calibration.left_out.iter().cloned().collect(),
            inputs: calibration.inputs.clone(),
            bias: corrector.bias().to_vec(),
            matrix: rows(corrector.matrix()),
            sensitivity: rows(corrector.sensitivity()),
            validity: linearity(calibration, &corrector),
            parameters: calibration.parameters.clone(),
            mounting: calibration.mounting.clone(),
            columns: calibration.titles.clone(),
        })
    }

    /// The calibration that a report holds.
    ///
    /// Errors: sizes that do not agree; with the path below `correction`.
    pub fn into_calibration(self) -> Result<Calibration> {
        let Parameters { order, values, covariance } = &self.parameters;
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
        let largest = |quantity: Quantity| {
            let solved = self.inputs.iter().filter(|i| i.solved);
            let ranges = solved.zip(&self.validity.range).filter(|(i, _)| i.quantity == quantity);
            ranges.map(|(_, range)| *range).fold(0.0, f64::max)
        };
        let span = Span { rate: largest(Quantity::Rate), force: largest(Quantity::Force) };
        Ok(Calibration {
            rate_unit: self.rate_unit,
            force_unit: self.force_unit,
            lines: self.sensors,
            left_out: self.left_out.into_iter().collect(),
            span,
            inputs: self.inputs,
            parameters: self.parameters,
            mounting: self.mounting,
            titles: self.columns,
        })
    }
}
