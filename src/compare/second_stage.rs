//! A second adjustment on the results of a first: papers solve some coefficients from others that were calibrated before.

use crate::error::{Fault, Malformed, Result};
use crate::estimate::{self, Estimate, Group, System};
use crate::fit::Fit;
use faer::Mat;

/// Generalised least squares on parameters of a fit: `y = B d + e`, `V(e) = C`, `C` the fit's full covariance of these parameters.
///
/// `C = L L'` turns it into `L^-1 y = L^-1 B d` with unit weights; a sum of squares that is large for its degrees of freedom says that
/// the second-stage model does not explain the first-stage results. Shapes: `B` is `ids x unknowns`. Errors: a parameter that the fit did
/// not estimate, or a covariance that is not positive definite.
pub fn second_stage(fit: &Fit, ids: &[&str], rows: &Mat<f64>) -> Result<Estimate> {
    let mut observed = Vec::with_capacity(ids.len());
    let mut index = Vec::with_capacity(ids.len());
    for id in ids {
        let k = fit.parameters.iter().position(|p| p.id == *id && p.value.is_some() && p.uncertainty.is_some());
        let Some((k, value)) = k.and_then(|k| Some((k, fit.parameters.get(k)?.value?))) else {
            return Err(Malformed::new(
                Fault::UnknownName,
                format!("the first stage gives no value and uncertainty for '{id}'"),
            )
            .expected("a parameter that the fit estimates")
            .found(format!("'{id}'")));
        };
        index.push(k);
        observed.push(value);
    }
    if rows.nrows() != ids.len() {
        return Err(Malformed::new(
            Fault::Value,
            "the second stage has another number of rows than of observed parameters",
        )
        .expected(ids.len().to_string())
        .found(rows.nrows().to_string()));
    }
    let lower = cholesky(&index, &fit.covariance)?;
    let mut whitened = rows.clone();
    for (i, weights) in lower.iter().enumerate() {
        let pivot = weights.get(i).copied().unwrap_or(1.0);
        for (k, weight) in weights.iter().enumerate().take(i) {
            let earlier = observed.get(k).copied().unwrap_or_default();
            if let Some(own) = observed.get_mut(i) {
                *own -= weight * earlier;
            }
            for j in 0..whitened.ncols() {
                whitened[(i, j)] -= weight * whitened[(k, j)];
            }
        }
        if let Some(own) = observed.get_mut(i) {
            *own /= pivot;
        }
        for j in 0..whitened.ncols() {
            whitened[(i, j)] /= pivot;
        }
    }
    let count = ids.len();
    let system = System { rows: whitened, observed, u: vec![1.0; count], group: vec![Group::Known; count] };
    estimate::adjust(&system, &estimate::Settings::default())
}

/// Lower triangle `L` of the chosen rows and columns of a covariance, `C = L L'`; row i has i + 1 entries.
fn cholesky(index: &[usize], covariance: &Mat<f64>) -> Result<Vec<Vec<f64>>> {
    let mut lower: Vec<Vec<f64>> = Vec::with_capacity(index.len());
    for (i, row) in index.iter().enumerate() {
        let mut own: Vec<f64> = Vec::with_capacity(i + 1);
        for (other, column) in lower.iter().zip(index) {
            let dot: f64 = own.iter().zip(other).map(|(a, b)| a * b).sum();
            let pivot = other.last().copied().unwrap_or(1.0);
            own.push((covariance[(*row, *column)] - dot) / pivot);
        }
        let square = covariance[(*row, *row)] - own.iter().map(|a| a * a).sum::<f64>();
        if !(square > 0.0) {
            return Err(Malformed::new(Fault::Value, "the first stage's covariance is not positive definite")
                .expected("parameters of which none is a combination of the others"));
        }
        own.push(square.sqrt());
        lower.push(own);
    }
    Ok(lower)
}
