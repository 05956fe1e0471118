//! How large each candidate is here against what its inputs could make of it: what is left of small tilts alone is small, and rounding is none.

use super::candidate::Candidate;
use super::catalogue::column_values;
use crate::algebra::{Scratch, Tape};
use crate::campaign::{Campaign, Kind};
use crate::design::DesignMatrix;
use crate::simulate::Regressor;

/// Each candidate's largest value over what its inputs could make of it: gravity along the axis, the fastest rate, any angle; a tilt's largest
/// derivative over that of all tilts. Gives the size below which each is nothing but the rounding of its inputs.
///
/// A product or sum of few factors errs by few epsilon of the size of its terms; the sine of an angle by an epsilon of the angle in radians,
/// so that `sin(k*joint)` at k half turns is as large as that, and no larger.
pub(super) fn sizes(campaign: &Campaign, design: &DesignMatrix, found: &mut [Candidate], rounding: f64) -> Vec<f64> {
    let largest = |column: &[f64]| column.iter().fold(0.0_f64, |largest, v| largest.max(v.abs()));
    let tilts = campaign.parameters.iter().enumerate().filter(|(_, p)| p.kind == Kind::Tilt).map(|(k, _)| k);
    let columns = tilts.filter(|k| *k < design.jacobian.ncols()).map(|k| largest(design.jacobian.col_as_slice(k)));
    let of_tilts = columns.fold(0.0, f64::max);
    let per_deg_s = campaign.bench.units.rate.per_deg_s();
    let joints = || campaign.readings.rows.iter().flat_map(|row| row.joints.iter());
    let rate = joints().map(|s| s.rate_deg_s().abs() * per_deg_s).fold(campaign.bench.earth_rate().norm(), f64::max);
    let angle =
        joints().filter_map(|s| s.keys().0).map(|deg| deg.abs().to_radians()).fold(std::f64::consts::TAU, f64::max);
    let force = campaign.bench.specific_force().norm();
    let mut scratch = Scratch::default();
    let mut bounds = Vec::with_capacity(found.len());
    let mut known: std::collections::HashMap<String, f64> = std::collections::HashMap::new();
    let mut natural_of = |name: &str| {
        if crate::campaign::is_axis_input(&campaign.bench, name) {
            return if name.starts_with("w_") { rate } else { force };
        }
        if campaign.bench.joints().any(|joint| joint == name) {
            return 0.7; // radians: no low harmonic is small there
        }
        let values = || column_values(campaign, name).iter().fold(0.0_f64, |largest, v| largest.max(v.abs()));
        *known.entry(name.to_string()).or_insert_with(values)
    };
    for candidate in found {
        let here = largest(&candidate.column);
        let natural = match &candidate.kind {
            Regressor::Tilt(_) => of_tilts,
            Regressor::Known(k) => of_known(campaign, design, *k, of_tilts, &mut natural_of),
            Regressor::Term(line) => {
                let names = line.names();
                let inputs: Vec<f64> = names.iter().map(|name| natural_of(name)).collect();
                // of a harmonic the size is that of what stands before it
                let compiled = if candidate.harmonic > 0 { None } else { Tape::compile(line, &names).ok() };
                match compiled {
                    Some(tape) => tape.value(&inputs, &mut scratch).abs(),
                    None => names
                        .iter()
                        .zip(&inputs)
                        .filter(|(n, _)| !campaign.bench.joints().any(|j| j == **n))
                        .map(|(_, v)| *v)
                        .product(),
                }
            }
            _ => 0.0,
        };
        candidate.size = if natural > 0.0 { here / natural } else { 1.0 };
        let argument = if candidate.harmonic > 0 { candidate.harmonic as f64 * angle } else { 1.0 };
        bounds.push(rounding * argument.max(1.0));
    }
    bounds
}

/// The derivative of the model lines to a known parameter, with inputs as large as they could be: a scale factor whose input only small tilts
/// leave is as hard to see as a term of that input.
fn of_known(
    campaign: &Campaign,
    design: &DesignMatrix,
    parameter: usize,
    of_tilts: f64,
    natural_of: &mut dyn FnMut(&str) -> f64,
) -> f64 {
    let Some(own) = campaign.parameters.get(parameter) else { return 0.0 };
    if own.kind == Kind::Tilt {
        return of_tilts;
    }
    let (mut scratch, mut natural) = (Scratch::default(), 0.0_f64);
    for sensor in &campaign.bench.sensors {
        let names = sensor.model.names();
        let Some(place) = names.iter().position(|name| *name == own.id) else { continue };
        let value = |name: &str| campaign.parameter_index(name).and_then(|k| design.point.get(k)).copied();
        let inputs: Vec<f64> = names.iter().map(|name| value(name).unwrap_or_else(|| natural_of(name))).collect();
        let Ok(tape) = Tape::compile(&sensor.model, &names) else { continue };
        let mut gradient = vec![0.0; names.len()];
        tape.gradient(&inputs, &mut scratch, &mut gradient);
        natural = natural.max(gradient.get(place).map_or(0.0, |slope| slope.abs()));
    }
    if natural.is_finite() { natural } else { 0.0 }
}
