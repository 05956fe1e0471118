//! What error sources do to a navigator at one instant.

use super::measured::{CHANNELS, Channels};

/// What every source does at one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct Instant {
    /// For each of [`super::errors::ErrorSource::catalogue`], the channels per SI unit of it.
    pub signatures: Vec<Channels>,
    /// Covariance of the channels that the random walks have built up.
    pub walk: [Channels; CHANNELS],
}

impl Instant {
    /// The mean of instants near one another.
    pub(super) fn mean(all: &[Instant]) -> Instant {
        let share = 1.0 / all.len().max(1) as f64;
        let mut mean = Instant { signatures: Vec::new(), walk: [[0.0; CHANNELS]; CHANNELS] };
        let add = |to: &mut Channels, own: &Channels| to.iter_mut().zip(own).for_each(|(sum, v)| *sum += share * v);
        for own in all {
            mean.signatures.resize(own.signatures.len(), [0.0; CHANNELS]);
            mean.signatures.iter_mut().zip(&own.signatures).for_each(|(to, own)| add(to, own));
            mean.walk.iter_mut().zip(&own.walk).for_each(|(to, own)| add(to, own));
        }
        mean
    }
}
