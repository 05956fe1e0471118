//! Inputs of the model lines of a unit.

use crate::vocabulary::vocabulary;
use nalgebra::Vector3;

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
