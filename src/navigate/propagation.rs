//! A calibration carried to navigation: the covariance of its parameters becomes one of the unit's errors, and that one
//! of navigation errors, by the linear signatures, and by Monte Carlo for comparison.
#![allow(
    clippy::indexing_slicing,
    reason = "`combine` has compared the matrix with its order; the sources' covariance is square over `sources`, with one scale and one eigenvalue each"
)]

use super::errors::{ErrorSource, ImuErrors, NavigationError};
use super::linear::{STATES, Signatures, Square};
use super::run::Scenario;
use crate::error::{Fault, Malformed, Result};
use nalgebra::DMatrix;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;

/// Covariance of some error sources, SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct SourceCovariance {
    /// Rows and columns.
    pub sources: Vec<ErrorSource>,
    /// The matrix.
    pub matrix: DMatrix<f64>,
}

/// Combine a report's parameters to error sources: `Sigma_sources = A Sigma_report A^T`.
///
/// `order` and `matrix` are the report's covariance; `carry` has for each source the parameters and their factors,
/// in the unit of the error source per parameter unit.
///
/// Errors: an unknown source or parameter, a covariance that is not square, a parameter without a covariance.
pub fn combine(
    order: &[String],
    matrix: &[Vec<Option<f64>>],
    carry: &[(String, Vec<(String, f64)>)],
) -> Result<SourceCovariance> {
    let n = order.len();
    if matrix.len() != n || matrix.iter().any(|row| row.len() != n) {
        return Err(Malformed::new(Fault::Value, "the report's covariance is not a square of its parameters")
            .at_path("calibration.report")
            .expected(format!("{n} rows of {n} numbers"))
            .found(format!("{} rows", matrix.len())));
    }
    check_covariance(order, matrix)?;
    let mut sources = Vec::new();
    let mut factors: DMatrix<f64> = DMatrix::zeros(carry.len(), n);
    for (i, (id, parameters)) in carry.iter().enumerate() {
        let path = format!("calibration.carry.{id}");
        let source = ErrorSource::named(id).ok_or_else(|| {
            let known: Vec<String> = ErrorSource::catalogue().iter().map(ErrorSource::id).collect();
            Malformed::new(Fault::UnknownName, format!("no error source is called '{id}'"))
                .at_path(&path)
                .expected(format!("one of {}", known.join(", ")))
                .found(format!("'{id}'"))
        })?;
        for (parameter, factor) in parameters {
            let path = format!("{path}.{parameter}");
            let column = order.iter().position(|name| name == parameter).ok_or_else(|| {
                Malformed::new(Fault::UnknownName, format!("the report estimates no parameter '{parameter}'"))
                    .at_path(&path)
                    .expected(format!("one of {}", order.join(", ")))
                    .found(format!("'{parameter}'"))
            })?;
            if !factor.is_finite() {
                return Err(Malformed::new(Fault::Value, "not a factor").at_path(&path).expected("a finite number"));
            }
            let defined = matrix.get(column).is_some_and(|row| row.get(column).is_some_and(Option::is_some));
            if !defined {
                return Err(Malformed::new(Fault::Missing, format!("'{parameter}' is not estimable in the report"))
                    .at_path(&path)
                    .expected("a parameter with a covariance"));
            }
            factors[(i, column)] += factor * source.si_per_unit();
        }
        sources.push(source);
    }
    let sigma: DMatrix<f64> =
        // `null` where a parameter is not estimable: its source was refused above
        DMatrix::from_fn(n, n, |i, j| matrix.get(i).and_then(|row| row.get(j).copied().flatten()).unwrap_or_default());
    Ok(SourceCovariance { sources, matrix: &factors * sigma * factors.transpose() })
}

/// Is the matrix a covariance: no negative variance, symmetric, no correlation beyond 1, and none of any combination?
fn check_covariance(order: &[String], matrix: &[Vec<Option<f64>>]) -> Result<()> {
    /// What the rounding of a report's numbers may do.
    const ROUNDING: f64 = 1e-6;
    let name = |i: usize| order.get(i).map_or("?", String::as_str);
    let at = |i: usize, j: usize| matrix.get(i).and_then(|row| row.get(j).copied().flatten());
    let wrong = |what: String, i: usize, j: usize, expected: &str, found: String| {
        Err(Malformed::new(Fault::Value, what)
            .at_path(format!("calibration.report.covariance.matrix[{i}][{j}]"))
            .expected(expected)
            .found(found))
    };
    let defined: Vec<usize> = (0..order.len()).filter(|i| at(*i, *i).is_some()).collect();
    for &i in &defined {
        // `defined` are those that have one
        let variance = at(i, i).unwrap_or_default();
        if !(variance >= 0.0 && variance.is_finite()) {
            let what = format!("the report's covariance is not valid: the variance of '{}' is negative", name(i));
            return wrong(what, i, i, "a finite variance, zero or positive", variance.to_string());
        }
    }
    let mut correlation = DMatrix::identity(defined.len(), defined.len());
    for (k, &i) in defined.iter().enumerate() {
        for (l, &j) in defined.iter().enumerate() {
            // likewise
            let (a, b) = (at(i, j).unwrap_or_default(), at(j, i).unwrap_or_default());
            let size = (at(i, i).unwrap_or_default() * at(j, j).unwrap_or_default()).sqrt();
            if !((a - b).abs() <= ROUNDING * size.max(a.abs())) {
                let what = format!(
                    "the report's covariance is not valid: it is not symmetric in '{}' and '{}'",
                    name(i),
                    name(j)
                );
                return wrong(what, i, j, &format!("the same number in both places, {b}"), a.to_string());
            }
            if !(a.abs() <= size * (1.0 + ROUNDING)) {
                let what =
                    format!("the report's covariance is not valid: '{}' and '{}' correlate beyond 1", name(i), name(j));
                return wrong(what, i, j, &format!("at most {size:.6e} by size"), a.to_string());
            }
            if k != l && size > 0.0 {
                correlation[(k, l)] = a / size;
            }
        }
    }
    let smallest = correlation.symmetric_eigenvalues().iter().copied().fold(0.0, f64::min);
    if smallest < -ROUNDING * defined.len() as f64 {
        return Err(Malformed::new(
            Fault::Value,
            "the report's covariance is not valid: some combination would have a negative variance",
        )
        .at_path("calibration.report.covariance")
        .expected("a positive semidefinite matrix")
        .found(format!("an eigenvalue {smallest:.3e} of the correlations")));
    }
    Ok(())
}

impl SourceCovariance {
    /// Standard uncertainties of the navigation errors by the signatures: `P = S Sigma S^T`, and that of the noise.
    pub(crate) fn propagate(&self, signatures: &Signatures) -> NavigationError {
        let all = ErrorSource::catalogue();
        let columns: Vec<_> = self
            .sources
            .iter()
            .map(|source| {
                let index = all.iter().position(|other| other == source);
                // the catalogue has every source
                index.and_then(|i| signatures.states.get(i)).copied().unwrap_or([0.0; STATES])
            })
            .collect();
        let mut covariance: Square = signatures.noise;
        for (i, a) in columns.iter().enumerate() {
            for (j, b) in columns.iter().enumerate() {
                let sigma = self.matrix[(i, j)];
                for (row, x) in covariance.iter_mut().zip(a) {
                    for (slot, y) in row.iter_mut().zip(b) {
                        *slot += sigma * x * y;
                    }
                }
            }
        }
        signatures.error(&std::array::from_fn(|i| covariance[i][i].max(0.0).sqrt()))
    }

    /// Scenarios drawn from the covariance (seeded), with the noise of `base`.
    pub(crate) fn draw(&self, base: &ImuErrors, draws: usize, seed: u64) -> Vec<Scenario> {
        let size = self.sources.len();
        // Sources of one covariance differ by many orders of size: scale to correlations before the eigenvectors.
        let scale: Vec<f64> = (0..size).map(|i| self.matrix[(i, i)].max(0.0).sqrt()).collect();
        let correlation = DMatrix::from_fn(size, size, |i, j| match scale[i] * scale[j] {
            0.0 => 0.0,
            product => self.matrix[(i, j)] / product,
        });
        let eigen = correlation.symmetric_eigen();
        let mut generator = Pcg64Mcg::seed_from_u64(seed);
        (0..draws)
            .map(|index| {
                let unit: Vec<f64> = (0..size)
                    .map(|k| {
                        let normal: f64 = StandardNormal.sample(&mut generator);
                        normal * eigen.eigenvalues[k].max(0.0).sqrt()
                    })
                    .collect();
                let mut errors = ImuErrors::default();
                errors.gyro.random_walk = base.gyro.random_walk;
                errors.accelerometer.random_walk = base.accelerometer.random_walk;
                for (i, source) in self.sources.iter().enumerate() {
                    let value: f64 = unit.iter().enumerate().map(|(k, u)| eigen.eigenvectors[(i, k)] * u).sum();
                    source.set(&mut errors, value * scale[i]);
                }
                Scenario { id: format!("draw {}", index + 1), errors }
            })
            .collect()
    }
}
