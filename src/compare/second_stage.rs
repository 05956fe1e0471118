//! A second adjustment on the results of a first: papers solve some coefficients from others that were calibrated before.

use crate::error::{Fault, Malformed, Result};
use crate::estimate::{self, Estimate, Group, System};
use crate::fit::Fit;
use crate::linear::Triangle;
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
    let covariance = |i: usize, j: usize| match (index.get(i), index.get(j)) {
        (Some(row), Some(column)) => fit.covariance[(*row, *column)],
        // both are below `index.len()`
        _ => f64::NAN,
    };
    let Some(lower) = Triangle::of(index.len(), covariance, |_| 0.0) else {
        return Err(Malformed::new(Fault::Value, "the first stage's covariance is not positive definite")
            .expected("parameters of which none is a combination of the others"));
    };
    lower.forward(&mut observed);
    let mut whitened = rows.clone();
    (0..whitened.ncols()).for_each(|j| lower.forward(whitened.col_as_slice_mut(j)));
    let count = ids.len();
    let system = System { rows: whitened, observed, u: vec![1.0; count], group: vec![Group::Known; count] };
    estimate::adjust(&system, &estimate::Settings::default())
}
