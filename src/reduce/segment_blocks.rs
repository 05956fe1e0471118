//! A segment of a channel as means of blocks: what an uncertainty is estimated from.

/// One segment of one channel.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SegmentBlocks {
    /// Block means of each uninterrupted piece.
    pub pieces: Vec<Vec<f64>>,
    /// Where it begins in the record, in blocks.
    pub start: f64,
    /// Its blocks.
    pub length: f64,
    /// Mean of its samples.
    pub mean: f64,
    /// Standard deviation of its samples.
    pub sd: f64,
    /// Its samples.
    pub samples: u64,
    /// Smallest step between values of the channel.
    pub step: f64,
    /// Where a joint turns: its angle at each block of each piece, in turns. The harmonics of the turn are no noise.
    pub angles: Vec<Vec<f64>>,
    /// The highest of these harmonics.
    pub harmonics: usize,
    /// How much larger the standard deviation of the level is than that of a mean of as many samples, since parts of turns are missing; 1, or 0 where nothing turns.
    pub above: f64,
}
