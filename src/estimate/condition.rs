//! Condition number of the scaled triangle.

use faer::Mat;

/// `sigma_max / sigma_min` in the 2-norm; `None` for an empty matrix, and for one that is singular.
pub(super) fn condition(r: &Mat<f64>) -> Option<f64> {
    let values = r.singular_values().ok()?;
    // the largest is the first
    let (most, least) = values.first().zip(values.last())?;
    (*least > 0.0).then(|| most / least)
}
