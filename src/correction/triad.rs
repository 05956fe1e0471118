//! A triad known by its norm: held by hand in attitudes that nobody knows, its line predicts the length of gravity from the readings.
//!
//! ```text
//! norm = |g(s)|,  g affine in the readings s:  g = L s + g0
//! s = b + K a,    K = L^-1,  b = -K g0,        a the vector along the axes in which the norm is written
//! ```
#![allow(
    clippy::indexing_slicing,
    reason = "matrices are made of the counts of readings and parameters that the loops run over, in the same function"
)]

use super::calibration::CalibratedLine;
use crate::algebra::{Expression, Scratch, Tape};
use crate::bench::{Bench, ForceUnit, RateUnit, Sensor};
use crate::elements::{Elements, OrNan};
use crate::error::Result;
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeMap;

/// What a norm says of its readings: a line for each, its parameters with their slopes by the calibrated ones.
pub(super) struct Triad {
    pub(super) lines: Vec<CalibratedLine>,
    pub(super) names: Vec<String>,
    pub(super) values: Vec<f64>,
    /// New parameters x calibrated ones.
    pub(super) slopes: DMatrix<f64>,
}

const AXES: [&str; 3] = ["x", "y", "z"];

impl Triad {
    /// `None` where the line is no norm of as many components as it has readings, each affine in them, in a unit of rate or specific force.
    pub(super) fn of(sensor: &Sensor, bench: &Bench, parameters: &[String], values: &[f64]) -> Option<Self> {
        let components = sensor.model.as_norm()?;
        let (letter, factor) = input(&sensor.unit, bench)?;
        let names = sensor.model.names();
        let columns: Vec<&str> = names.into_iter().filter(|name| !parameters.iter().any(|p| p == name)).collect();
        let n = columns.len();
        if components.len() != n || n > AXES.len() || !components.iter().all(|component| component.linear_in(&columns))
        {
            return None;
        }
        let names: Vec<&str> = columns.iter().copied().chain(parameters.iter().map(String::as_str)).collect();
        let tapes: Vec<Tape> =
            components.iter().map(|component| Tape::compile(component, &names)).collect::<Result<_>>().ok()?;
        // values and slopes of the components where one column is 1, or none
        let mut scratch = Scratch::default();
        let mut at = |one: Option<usize>| {
            let mut inputs: Vec<f64> = (0..n).map(|j| if Some(j) == one { 1.0 } else { 0.0 }).collect();
            inputs.extend_from_slice(values);
            let mut gradient = DMatrix::zeros(n, names.len());
            let mut slopes = vec![0.0; names.len()];
            let found = tapes.iter().enumerate().map(|(k, tape)| {
                let value = tape.gradient(&inputs, &mut scratch, &mut slopes);
                slopes.iter().enumerate().for_each(|(j, slope)| gradient[(k, j)] = factor * slope);
                factor * value
            });
            (DVector::from_vec(found.collect()), gradient)
        };
        let (origin, slopes) = at(None);
        let gain = slopes.columns(0, n).into_owned().try_inverse()?;
        let bias = -(&gain * &origin);
        let by_parameter: Vec<DMatrix<f64>> =
            (0..n).map(|j| (at(Some(j)).1 - &slopes).columns(n, parameters.len()).into_owned()).collect();
        let mut all = DMatrix::zeros(n + n * n, parameters.len());
        for p in 0..parameters.len() {
            let turned = DMatrix::from_fn(n, n, |i, j| by_parameter.get(j).map_or(f64::NAN, |change| change[(i, p)]));
            let by_gain = -(&gain * turned * &gain);
            let by_bias = -(&by_gain * &origin + &gain * slopes.column(n + p));
            for i in 0..n {
                all[(i * (n + 1), p)] = by_bias[i];
                (0..n).for_each(|j| all[(i * (n + 1) + 1 + j, p)] = by_gain[(i, j)]);
            }
        }
        let (mut lines, mut new, mut numbers) = (Vec::new(), Vec::new(), Vec::new());
        for (i, column) in columns.iter().enumerate() {
            new.push(format!("bias_{column}"));
            numbers.push(bias.as_slice().at(i));
            let mut line = format!("bias_{column}");
            for (j, axis) in AXES.iter().take(n).enumerate() {
                new.push(format!("gain_{column}_{axis}"));
                numbers.push(gain.row(i).transpose().as_slice().or_nan(j));
                line += &format!(" + gain_{column}_{axis}*{letter}_{axis}");
            }
            lines.push(CalibratedLine {
                sensor: (*column).to_string(),
                unit: String::new(),
                axes: BTreeMap::new(),
                model: Expression::parse(&line).ok()?,
            });
        }
        Some(Triad { lines, names: new, values: numbers, slopes: all })
    }
}

/// What a norm in this unit is of (`w` or `a`), and the bench's unit in it.
fn input(unit: &str, bench: &Bench) -> Option<(&'static str, f64)> {
    let rate = RateUnit::ALL.into_iter().find(|known| known.name() == unit);
    let force = ForceUnit::ALL.into_iter().find(|known| known.name() == unit);
    rate.map(|known| ("w", bench.units.rate.per_deg_s() / known.per_deg_s()))
        .or_else(|| force.map(|known| ("a", bench.units.force.per_g() / known.per_g())))
}
