//! How far the first-order correction holds.

use super::{Calibration, Corrector};

/// How far the first-order correction is from the exact one over the range of the calibration.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "ValidityFile")]
pub struct Linearity {
    /// Half range of each solved input: what the readings of the calibration covered.
    pub range: Vec<f64>,
    /// Largest error of `matrix (readings - bias)` within that range, in the input's unit.
    pub linear_error: Vec<f64>,
    /// Largest standard uncertainty of each corrected input within that range, from the calibration alone; null where none is known.
    pub u: Option<Vec<f64>>,
    /// Share of the range within which `linear_error` stays below `u` (1: all of it); null where no uncertainty is known.
    pub linear_share: Option<f64>,
}

/// Points along each input: its ends, half-way, and zero.
const LEVELS: [f64; 5] = [-1.0, -0.5, 0.0, 0.5, 1.0];

/// The linear form against the exact lines over the range of the calibration.
///
/// With up to three inputs all combinations of the levels are tried; with more, those of the ends, and each input alone.
pub fn linearity(calibration: &Calibration, corrector: &Corrector) -> Linearity {
    let range: Vec<f64> = calibration.solved().map(|input| calibration.range_of(input)).collect();
    let points = grid(range.len());
    let given = corrector.fallbacks();
    let errors_at = |share: f64| {
        let mut errors = vec![0.0_f64; range.len()];
        for point in &points {
            let inputs: Vec<f64> = point.iter().zip(&range).map(|(level, range)| level * range * share).collect();
            let linear = corrector.linear(&corrector.readings(&inputs, &given));
            for ((error, linear), input) in errors.iter_mut().zip(&linear).zip(&inputs) {
                *error = error.max((linear - input).abs());
            }
        }
        errors
    };
    let linear_error = errors_at(1.0);
    let mut u: Option<Vec<f64>> = None;
    for point in &points {
        let inputs: Vec<f64> = point.iter().zip(&range).map(|(level, range)| level * range).collect();
        let Some(covariance) = corrector.covariance(&inputs, &given) else { continue };
        let largest = u.get_or_insert_with(|| vec![0.0; range.len()]);
        for (most, variance) in largest.iter_mut().zip(covariance.diagonal().iter()) {
            *most = most.max(variance.max(0.0).sqrt());
        }
    }
    let linear_share = u.as_ref().map(|u| {
        // rounding of the readings is no error of the form
        let holds =
            |errors: &[f64]| errors.iter().zip(u).zip(&range).all(|((error, u), range)| *error <= u.max(1e-12 * range));
        if holds(&linear_error) {
            return 1.0;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..24 {
            let middle = 0.5 * (low + high);
            if holds(&errors_at(middle)) { low = middle } else { high = middle }
        }
        low
    });
    Linearity { range, linear_error, u, linear_share }
}

fn grid(inputs: usize) -> Vec<Vec<f64>> {
    let levels: &[f64] = if inputs <= 3 { &LEVELS } else { &[-1.0, 1.0] };
    let mut points = vec![Vec::new()];
    for _ in 0..inputs.min(8) {
        points = points
            .iter()
            .flat_map(|point: &Vec<f64>| levels.iter().map(move |level| [point.as_slice(), &[*level]].concat()))
            .collect();
    }
    points.iter_mut().for_each(|point| point.resize(inputs, 0.0));
    if inputs > 3 {
        for k in 0..inputs {
            for level in LEVELS {
                points.push((0..inputs).map(|i| if i == k { level } else { 0.0 }).collect());
            }
        }
    }
    points
}
