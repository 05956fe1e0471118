//! What error sources do to a navigator at one instant.
#![allow(
    clippy::indexing_slicing,
    reason = "matrices and arrays over the seven channels, indexed by `from_fn` over that length"
)]

use super::measured::{CHANNELS, Channels};
use nalgebra::SMatrix;

pub(super) type Matrix = SMatrix<f64, CHANNELS, CHANNELS>;

/// Sizes of the channels in one Schuler oscillation: radians, metres per second, metres.
pub(super) const SIZE: Channels = [1.0, 1.0, 1.0, 7.9e3, 7.9e3, 6.4e6, 6.4e6];

/// A matrix over channels of the same size.
pub(super) fn scaled(matrix: &Matrix) -> Matrix {
    Matrix::from_fn(|i, j| matrix[(i, j)] * SIZE[j] / SIZE[i])
}

/// What every source does at one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct Instant {
    /// For each of [`super::errors::ErrorSource::catalogue`], the channels per SI unit of it.
    pub signatures: Vec<Channels>,
    /// Covariance of the channels that the random walks have built up.
    pub walk: [Channels; CHANNELS],
}

impl Instant {
    /// `Psi`: the signatures of the start.
    pub(super) fn start(&self) -> Matrix {
        // they are the last of the catalogue
        let first = self.signatures.len().saturating_sub(CHANNELS);
        Matrix::from_fn(|i, j| self.signatures.get(first + j).map_or(0.0, |s| s[i]))
    }

    /// The mean of instants near one another.
    pub(super) fn mean(all: &[Instant]) -> Instant {
        let share = 1.0 / all.len().max(1) as f64;
        let mut mean = Instant { signatures: Vec::new(), walk: [[0.0; CHANNELS]; CHANNELS] };
        let add = |to: &mut Channels, from: &Channels| to.iter_mut().zip(from).for_each(|(sum, v)| *sum += share * v);
        for instant in all {
            mean.signatures.resize(instant.signatures.len(), [0.0; CHANNELS]);
            mean.signatures.iter_mut().zip(&instant.signatures).for_each(|(to, from)| add(to, from));
            mean.walk.iter_mut().zip(&instant.walk).for_each(|(to, from)| add(to, from));
        }
        mean
    }
}
