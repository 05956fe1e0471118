//! Corrected inputs on the mounting face, with the uncertainty of how the sensors sit on it.

use super::{Calibration, Corrector, LineInput, Mounting, Quantity};
use crate::elements::{Elements, OrNan};
use crate::error::{Fault, Malformed, Result};
use nalgebra::{DMatrix, DVector};

/// The rotation of all solved rates and forces to the mounting face: `q_mount = R q`.
#[derive(Debug, Clone)]
pub struct ToMount {
    rotation: DMatrix<f64>,
    /// `dR/dt`, one for each tilt.
    by_tilt: Vec<DMatrix<f64>>,
    /// Of the calibration's parameters, then of the tilts; `None` where that of the parameters is not known.
    covariance: Option<DMatrix<f64>>,
}

impl ToMount {
    /// Errors: no tilts after the last joint, a tilt that is not estimable, a vector of which not all three components are solved for.
    pub fn new(calibration: &Calibration) -> Result<Self> {
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
        let solved: Vec<&LineInput> = calibration.solved().collect();
        for quantity in [Quantity::Rate, Quantity::Force] {
            let names: Vec<&str> =
                solved.iter().filter(|i| i.quantity == quantity).map(|input| input.name.as_str()).collect();
            if !matches!(names.len(), 0 | 3) {
                return Err(fault(format!("only {}", names.join(", "))));
            }
        }
        // a block for the rates, one for the forces: each lists its x, y and z in this order
        let place = |k: usize| {
            let quantity = solved.get(k).map(|input| input.quantity);
            (quantity, solved.iter().take(k).filter(|input| Some(input.quantity) == quantity).count())
        };
        let blocks = |matrix: &[[f64; 3]; 3]| {
            DMatrix::from_fn(solved.len(), solved.len(), |i, j| match (place(i), place(j)) {
                // three of each, see above
                ((one, i), (other, j)) if one == other => matrix.get(i).map_or(f64::NAN, |row| row.or_nan(j)),
                _ => 0.0,
            })
        };
        Ok(ToMount {
            rotation: blocks(&mounting.rotation),
            by_tilt: mounting.by_tilt.iter().map(blocks).collect(),
            covariance: (!calibration.parameters.covariance.is_empty()).then(|| joint(calibration, mounting)),
        })
    }

    /// Solved inputs as components on the mounting face.
    pub fn turned(&self, inputs: &[f64]) -> Vec<f64> {
        (&self.rotation * DVector::from_column_slice(inputs)).as_slice().to_vec()
    }

    /// Covariance of the turned inputs from the calibration alone (not the noise of the sample): `J C J'` with `J = (R dq/dp, dR/dt q)`; `None` where no
    /// uncertainty is known.
    pub fn covariance(&self, corrector: &Corrector, inputs: &[f64], given: &[f64]) -> Option<DMatrix<f64>> {
        let joint = self.covariance.as_ref()?;
        let by_parameter = &self.rotation * corrector.inputs_by_parameter(inputs, given)?;
        let q = DVector::from_column_slice(inputs);
        let by_tilt: Vec<DVector<f64>> = self.by_tilt.iter().map(|moved| moved * &q).collect();
        let n = by_parameter.ncols();
        let slopes = DMatrix::from_fn(inputs.len(), joint.ncols(), |i, j| match j.checked_sub(n) {
            // as many columns as the joint covariance has: those of the parameters, then of the tilts
            None => by_parameter.get((i, j)).copied().unwrap_or(f64::NAN),
            Some(tilt) => by_tilt.get(tilt).map_or(f64::NAN, |moved| moved.as_slice().or_nan(i)),
        });
        let covariance = &slopes * joint * slopes.transpose();
        covariance.iter().all(|v| v.is_finite()).then_some(covariance)
    }
}

/// The covariance of parameters and tilts; of the parameters alone where that of the tilts is not known (the rotation then counts as exact).
fn joint(calibration: &Calibration, mounting: &Mounting) -> DMatrix<f64> {
    let n = calibration.parameters.order.len();
    let (terms, tilts) = (calibration.parameters.covariance.as_slice(), mounting.covariance.as_slice());
    DMatrix::from_fn(n + tilts.len(), n + tilts.len(), |i, j| match (i.checked_sub(n), j.checked_sub(n)) {
        (None, None) => terms.at(i).at(j),
        (Some(i), _) => tilts.at(i).at(j),
        (None, Some(j)) => tilts.at(j).at(i),
    })
}
