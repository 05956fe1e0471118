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
