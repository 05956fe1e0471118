//! A square root of a covariance, which draws correlated deviations.

use crate::elements::Elements;
use faer::{Mat, Side};

/// `F` with `F F' = covariance`, from the eigenvectors of the correlation; directions without variance are left out.
pub(super) fn covariance_root(covariance: &Mat<f64>) -> Mat<f64> {
    let n = covariance.nrows();
    let sd: Vec<f64> = (0..n).map(|k| covariance[(k, k)].max(0.0).sqrt()).collect();
    let sd_of = |i: usize| sd.at(i);
    let correlation = Mat::from_fn(n, n, |i, j| match sd_of(i) * sd_of(j) {
        product if product > 0.0 => covariance[(i, j)] / product,
        _ => 0.0,
    });
    let Ok(eigen) = correlation.self_adjoint_eigen(Side::Lower) else { return Mat::zeros(n, 0) };
    let values = eigen.S().column_vector().iter().copied().enumerate();
    let kept: Vec<(usize, f64)> = values.filter(|(_, value)| *value > 1e-14).collect();
    Mat::from_fn(n, kept.len(), |i, k| {
        kept.get(k).map_or(0.0, |(k, value)| sd_of(i) * eigen.U()[(i, *k)] * value.sqrt())
    })
}
