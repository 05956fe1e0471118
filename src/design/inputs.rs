//! Derivatives of the readings by the inputs of the bench (gravity, latitude, rates of joints), by central differences.
//!
//! The model lines are low powers of rates and forces: with steps of 1e-4 the third order leaves 1e-8 of the derivative, which is used for
//! uncertainties only.

use super::{Model, RowOrigin};
use crate::campaign::{Campaign, Kind};
use crate::error::Result;
use faer::Mat;

/// Fill the columns of the inputs.
pub(super) fn fill(
    campaign: &Campaign,
    model: &Model,
    point: &[f64],
    rows: &[RowOrigin],
    jacobian: &mut Mat<f64>,
) -> Result<()> {
    let inputs = campaign.parameters.iter().enumerate().filter(|(_, p)| p.kind == Kind::Input);
    let mut gradient = vec![0.0; campaign.parameters.len()];
    let mut work = model.workspace();
    for (k, parameter) in inputs {
        let step = 1e-4 * parameter.reference().abs().clamp(1e-1, 1e2);
        for side in [-1.0, 1.0] {
            let mut moved = campaign.clone();
            moved.shift_input(&parameter.id, side * step);
            for (i, origin) in rows.iter().enumerate() {
                let value = model.predict(&moved, origin.reading, origin.sensor, point, &mut gradient, &mut work)?;
                jacobian[(i, k)] += side * value / (2.0 * step);
            }
        }
    }
    Ok(())
}
