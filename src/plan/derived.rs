//! Predicted uncertainties of derived quantities.

use super::judge::PredictedDerived;
use crate::algebra::{Scratch, Tape};
use crate::campaign::{Campaign, Kind};
use crate::design::DesignMatrix;
use crate::error::Result;
use crate::estimate::Estimate;
use faer::Mat;

/// Derived quantities: `u^2 = g' C g`; where the gradient does not exist at the reference point, the largest over points close by.
pub(super) fn derived(
    campaign: &Campaign,
    design: &DesignMatrix,
    covariance: &Mat<f64>,
    estimate: &Estimate,
) -> Result<Vec<PredictedDerived>> {
    let ids: Vec<&str> = campaign.parameters.iter().map(|p| p.id.as_str()).collect();
    let n = campaign.unknowns();
    let mut results = Vec::with_capacity(campaign.derived.len());
    for quantity in &campaign.derived {
        let tape = Tape::compile(&quantity.line, &ids)?;
        let mut scratch = Scratch::default();
        let mut gradient = vec![0.0; ids.len()];
        let mut u_at = |point: &[f64]| -> Option<f64> {
            tape.gradient(point, &mut scratch, &mut gradient);
            let g = gradient.get(..n)?;
            let usable = g
                .iter()
                .enumerate()
                .all(|(k, c)| c.is_finite() && (*c == 0.0 || estimate.estimable.get(k).copied().unwrap_or(false)));
            let variance: f64 =
                (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).map(|(i, j)| g[i] * g[j] * covariance[(i, j)]).sum();
            (usable && variance.is_finite()).then(|| variance.max(0.0).sqrt())
        };
        let here = u_at(&design.point).filter(|u| *u > 0.0);
        let mut is_largest = false;
        let u = match here {
            Some(u) => Some(u),
            None => {
                let used: Vec<usize> = quantity
                    .line
                    .names()
                    .iter()
                    .filter_map(|name| campaign.parameter_index(name))
                    .filter(|k| *k < n)
                    .collect();
                // along each coordinate, and all round in the plane of each two
                let step = 1e-4;
                let mut largest: Option<f64> = None;
                for (p, first) in used.iter().enumerate() {
                    for second in used.get(p..).unwrap_or_default() {
                        for direction in 0..64 {
                            let (sin, cos) = (std::f64::consts::TAU * f64::from(direction) / 64.0).sin_cos();
                            let mut point = design.point.clone();
                            point[*first] += step * cos;
                            if second != first {
                                point[*second] += step * sin;
                            }
                            largest = u_at(&point).into_iter().chain(largest).reduce(f64::max);
                        }
                    }
                }
                is_largest = largest.is_some();
                largest
            }
        };
        let angle = |name: &str| {
            let parameter = campaign.parameter_index(name).and_then(|k| campaign.parameters.get(k))?;
            if parameter.kind == Kind::Tilt { Some(1.0) } else { None }
        };
        results.push(PredictedDerived {
            id: quantity.id.clone(),
            line: quantity.line.to_string(),
            is_angle: quantity.line.angle_degree(&angle) == Some(1.0),
            u,
            is_largest,
        });
    }
    Ok(results)
}
