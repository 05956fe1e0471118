//! Random walks of the unit make navigation errors that follow each other in time. A Kalman filter takes that out: of a column, and of
//! the gap, it leaves innovations, which are independent and of unit variance if nothing but noise and random walks is in them.
//!
//! ```text
//! z(t) = Psi(t) Psi(s)^-1 z(s) + w,   cov w = W(t) - A W(s) A^T,   A = Psi(t) Psi(s)^-1
//! e = (y - h z) / (h P h^T + u^2)^(1/2)                                 (one channel after another)
//! ```
//!
//! `Psi` holds the signatures of the start, `W` the covariance of the random walks ([`linear`](super::linear)). Least squares on
//! innovations is generalised least squares on the data (Kailath, Sayed and Hassibi, *Linear Estimation*, 2000, chapter 9).
#![allow(
    clippy::indexing_slicing,
    reason = "matrices and vectors over the seven channels, indexed by `from_fn` and loops over that length"
)]

use super::errors::ErrorSource;
use super::measured::{CHANNELS, Measured};
use super::signatures::Instant;
use crate::elements::Elements;
use nalgebra::SMatrix;

type Matrix = SMatrix<f64, CHANNELS, CHANNELS>;

/// Replace each column by its innovations, weighted; `u` holds the standard uncertainty of each value. Without random walks (`walks`
/// is empty) this is the division by `u`. Returns by how much the sum of the logarithms of the innovations' variances exceeds that without walks.
pub(super) fn whiten(measured: &Measured, walks: &[Vec<Instant>], u: &[f64], columns: &mut [Vec<f64>]) -> f64 {
    if walks.is_empty() {
        for column in columns {
            column.iter_mut().zip(u).for_each(|(value, u)| *value /= u);
        }
        return 0.0;
    }
    let first_start = ErrorSource::all().len();
    let mut at = 0;
    let mut size = 0.0;
    for (run, instants) in measured.runs.iter().zip(walks) {
        let mut state = vec![[0.0; CHANNELS]; columns.len()];
        let mut p = Matrix::zeros();
        let (mut psi_before, mut walk_before) = (Matrix::identity(), Matrix::zeros());
        for (row, instant) in run.rows.iter().zip(instants) {
            let walk = Matrix::from_fn(|i, j| instant.walk[i][j]);
            let psi = Matrix::from_fn(|i, j| instant.signatures.get(first_start + j).map_or(0.0, |s| s[i]));
            let a = transition(&psi, &psi_before);
            p = a * p * a.transpose() + walk - a * walk_before * a.transpose();
            p = (p + p.transpose()) * 0.5;
            for z in &mut state {
                *z = std::array::from_fn(|i| (0..CHANNELS).map(|j| a[(i, j)] * z[j]).sum());
            }
            (psi_before, walk_before) = (psi, walk);
            for channel in (0..CHANNELS).filter(|c| row.value.get(*c).is_some_and(Option::is_some)) {
                let u = u.at(at);
                let variance = p[(channel, channel)].max(0.0) + u * u;
                size += (variance / (u * u)).ln();
                let gain = p.column(channel) / variance;
                for (column, z) in columns.iter_mut().zip(&mut state) {
                    let Some(value) = column.get_mut(at) else { continue };
                    let innovation = *value - z[channel];
                    z.iter_mut().zip(gain.iter()).for_each(|(z, k)| *z += k * innovation);
                    *value = innovation / variance.sqrt();
                }
                let row: nalgebra::RowSVector<f64, CHANNELS> = p.row(channel).into_owned();
                p -= gain * row;
                at += 1;
            }
        }
    }
    size
}

/// `Psi(t) Psi(s)^-1`, with channels scaled to a size near one another.
fn transition(psi: &Matrix, before: &Matrix) -> Matrix {
    // metres, metres per second and radians of one Schuler oscillation
    let size = [1.0, 1.0, 1.0, 7.9e3, 7.9e3, 6.4e6, 6.4e6];
    let scaled = |m: &Matrix| Matrix::from_fn(|i, j| m[(i, j)] * size[j] / size[i]);
    let ratio = scaled(before).transpose().lu().solve(&scaled(psi).transpose()).map(|x| x.transpose());
    // the first of a run has nothing before it
    let ratio = ratio.unwrap_or_else(Matrix::identity);
    Matrix::from_fn(|i, j| ratio[(i, j)] * size[i] / size[j])
}
