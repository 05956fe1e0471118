//! A model line bound to the parameters and inputs of a calibration.

use super::calibration::{CalibratedLine, Calibration, LineInput, Quantity};
use crate::algebra::{Scratch, Tape};
use crate::elements::{Elements, OrNan};
use crate::error::{Fault, Malformed, Result};
use nalgebra::Vector3;

/// Where a name of a line takes its value from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Slot {
    Rate(Vector3<f64>),
    Force(Vector3<f64>),
    Given(usize),
    Parameter(usize),
}

/// A line bound to a calibration's parameters and inputs.
#[derive(Debug, Clone)]
pub(super) struct Bound {
    pub tape: Tape,
    pub slots: Vec<Slot>,
}

/// The direction of an axis input of a line in the last frame; `None` for a name that is none.
pub(super) fn direction_of(line: &CalibratedLine, name: &str) -> Option<(Quantity, Vector3<f64>)> {
    let (quantity, axis) = match (name.strip_prefix("w_"), name.strip_prefix("a_")) {
        (Some(axis), _) => (Quantity::Rate, axis),
        (_, Some(axis)) => (Quantity::Force, axis),
        _ => return None,
    };
    let listed = line.axes.get(axis).map(|direction| Vector3::from(*direction));
    let frame = match axis {
        "x" => Some(Vector3::x()),
        "y" => Some(Vector3::y()),
        "z" => Some(Vector3::z()),
        _ => None,
    };
    listed.or(frame).map(|direction| (quantity, direction))
}

impl Bound {
    /// Errors: a name that is neither parameter, axis input nor given input.
    pub(super) fn new(line: &CalibratedLine, calibration: &Calibration, inputs: &[LineInput]) -> Result<Self> {
        let names = line.model.names();
        let slots = names
            .iter()
            .map(|name| {
                if let Some(k) = calibration.parameters.order.iter().position(|p| p == name) {
                    return Ok(Slot::Parameter(k));
                }
                match direction_of(line, name) {
                    Some((Quantity::Rate, direction)) => return Ok(Slot::Rate(direction)),
                    Some((_, direction)) => return Ok(Slot::Force(direction)),
                    None => {}
                }
                inputs.iter().position(|i| i.name == *name).map(Slot::Given).ok_or_else(|| {
                    Malformed::new(
                        Fault::UnknownName,
                        format!("the line of {} uses '{name}', which has no value", line.sensor),
                    )
                    .expected("a parameter, an axis input or a column that the calibration lists")
                    .found(format!("'{name}'"))
                })
            })
            .collect::<Result<Vec<Slot>>>()?;
        Ok(Bound { tape: Tape::compile(&line.model, &names)?, slots })
    }

    pub(super) fn fill(&self, state: &State<'_>, values: &mut Vec<f64>) {
        values.clear();
        values.extend(self.slots.iter().map(|slot| match slot {
            Slot::Rate(direction) => direction.dot(&state.rate),
            Slot::Force(direction) => direction.dot(&state.force),
            Slot::Given(k) => state.given.or_nan(*k),
            Slot::Parameter(k) => state.parameters.at(*k),
        }));
    }

    /// Slopes with respect to rate and force at zero input, columns at their fallbacks.
    pub(super) fn slopes_at_zero(
        &self,
        calibration: &Calibration,
        inputs: &[LineInput],
    ) -> (Vector3<f64>, Vector3<f64>) {
        let given: Vec<f64> = inputs.iter().map(|input| input.fallback()).collect();
        let state = State {
            rate: Vector3::zeros(),
            force: Vector3::zeros(),
            given: &given,
            parameters: &calibration.parameters.values,
        };
        let (mut values, mut slopes) = (Vec::new(), vec![0.0; self.slots.len()]);
        self.fill(&state, &mut values);
        self.tape.gradient(&values, &mut Scratch::default(), &mut slopes);
        self.by_input(&slopes)
    }

    pub(super) fn by_input(&self, slopes: &[f64]) -> (Vector3<f64>, Vector3<f64>) {
        let (mut rate, mut force) = (Vector3::zeros(), Vector3::zeros());
        for (slot, slope) in self.slots.iter().zip(slopes) {
            match slot {
                Slot::Rate(direction) => rate += direction * *slope,
                Slot::Force(direction) => force += direction * *slope,
                Slot::Given(_) | Slot::Parameter(_) => {}
            }
        }
        (rate, force)
    }
}

pub(super) struct State<'a> {
    pub rate: Vector3<f64>,
    pub force: Vector3<f64>,
    pub given: &'a [f64],
    pub parameters: &'a [f64],
}
