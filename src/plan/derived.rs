//! Predicted uncertainties of derived quantities.

use crate::algebra::{Scratch, Tape};
use crate::campaign::{Campaign, Derived, Kind};
use crate::design::DesignMatrix;
use crate::elements::Parts;
use crate::error::Result;
use crate::estimate::Estimate;
use faer::Mat;

/// Prediction for a derived quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct PredictedDerived {
    /// Its name.
    pub id: String,
    /// Its line of algebra.
    pub line: String,
    /// Is it an angle?
    pub is_angle: bool,
    /// Its unit, as asked for or as the line has it; empty where a parameter in it has none.
    pub unit: String,
    /// Standard uncertainty at the reference point, or the largest in its neighbourhood where it has no derivative there (`sqrt` at 0).
    pub u: Option<f64>,
    /// Has it no derivative at the reference point?
    pub is_largest: bool,
}

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
            let usable =
                g.iter().enumerate().all(|(k, c)| c.is_finite() && (*c == 0.0 || estimate.unknowns.is_estimable(k)));
            let variance: f64 = g
                .iter()
                .enumerate()
                .flat_map(|(i, a)| g.iter().enumerate().map(move |(j, b)| a * b * covariance[(i, j)]))
                .sum();
            (usable && variance.is_finite()).then(|| variance.max(0.0).sqrt())
        };
        let here = u_at(&design.point).filter(|u| *u > 0.0);
        let mut is_largest = false;
        let u = match here {
            Some(u) => Some(u),
            // the uncertainty of a direction of next to nothing depends on how much that is
            None if quantity.line.as_azimuth().is_some() => None,
            None => {
                let largest =
                    nearby(campaign, quantity, &design.point).iter().filter_map(|point| u_at(point)).reduce(f64::max);
                is_largest = largest.is_some();
                largest
            }
        };
        results.push(PredictedDerived {
            id: quantity.id.clone(),
            line: quantity.line.to_string(),
            is_angle: is_angle(campaign, &quantity.id),
            unit: quantity.unit.clone(),
            u,
            is_largest,
        });
    }
    Ok(results)
}

/// Points close to one at which a quantity has no derivative: all round in the plane of each two of its parameters.
fn nearby(campaign: &Campaign, quantity: &Derived, point: &[f64]) -> Vec<Vec<f64>> {
    const STEP: f64 = 1e-4;
    // opposite directions have opposite gradients
    const DIRECTIONS: u32 = 32;
    let n = campaign.unknowns();
    let names = quantity.line.names();
    let used: Vec<usize> = names.iter().filter_map(|name| campaign.parameter_index(name)).filter(|k| *k < n).collect();
    let moved = |along: &[(usize, f64)]| {
        let mut there = point.to_vec();
        for (k, step) in along {
            if let Some(slot) = there.get_mut(*k) {
                *slot += step;
            }
        }
        there
    };
    if let [only] = used.as_slice() {
        return vec![moved(&[(*only, STEP)]), moved(&[(*only, -STEP)])];
    }
    let mut points = Vec::new();
    for (p, first) in used.iter().enumerate() {
        for second in used.part(p + 1..) {
            for direction in 0..DIRECTIONS {
                let (sin, cos) = (std::f64::consts::PI * f64::from(direction) / f64::from(DIRECTIONS)).sin_cos();
                points.push(moved(&[(*first, STEP * cos), (*second, STEP * sin)]));
            }
        }
    }
    points
}

/// Gradients of a derived quantity by the estimated parameters: one at the reference point, or those of points nearby where it has none there.
/// Empty where it has none at all. Errors: a line that does not compile.
pub(crate) fn gradients(campaign: &Campaign, quantity: &Derived) -> Result<Vec<Vec<f64>>> {
    let ids: Vec<&str> = campaign.parameters.iter().map(|p| p.id.as_str()).collect();
    let tape = Tape::compile(&quantity.line, &ids)?;
    let mut scratch = Scratch::default();
    let mut at = |point: &[f64]| {
        let mut gradient = vec![0.0; ids.len()];
        tape.gradient(point, &mut scratch, &mut gradient);
        gradient.truncate(campaign.unknowns());
        (gradient.iter().all(|g| g.is_finite()) && gradient.iter().any(|g| *g != 0.0)).then_some(gradient)
    };
    let point = campaign.reference_point();
    Ok(match at(&point) {
        Some(gradient) => vec![gradient],
        None => nearby(campaign, quantity, &point).iter().filter_map(|point| at(point)).collect(),
    })
}

/// Is a parameter or derived quantity an angle without a unit of its own? Limits and uncertainties of it are in radians then.
pub fn is_angle(campaign: &Campaign, id: &str) -> bool {
    let tilt = |name: &str| {
        let parameter = campaign.parameter_index(name).and_then(|k| campaign.parameters.get(k));
        parameter.is_some_and(|p| p.kind == Kind::Tilt)
    };
    let quantity = campaign.derived.iter().find(|d| d.id == id);
    // with a unit asked for, the line has its factor in it
    let in_radians = |own: &Derived| {
        matches!(own.unit.as_str(), "" | "rad")
            && own.line.angle_degree(&|name: &str| tilt(name).then_some(1.0)) == Some(1.0)
    };
    tilt(id) || quantity.is_some_and(in_radians)
}
