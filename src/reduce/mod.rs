//! From samples to readings: segments of a record, their means, and the uncertainty of a mean of correlated samples.
//!
//! ```text
//! samples -> trace (block means, events) -> segments -> mean, u, slope of each segment and channel
//! ```
//!
//! | file | subject |
//! |---|---|
//! | `trace.rs` | a record in bounded memory, and what is odd in it |
//! | `events.rs` | spikes, stuck values, saturation, absent values |
//! | `still.rs` | where a record stands still |
//! | `segments.rs` | segments by a column, a list of times or the static detector |
//! | `turning.rs` | what repeats with a turn, apart from the noise |
//! | `turns.rs` | whole turns, by a stated rate or an encoder's angle |
//! | `correlated.rs` | the uncertainty of means, from all segments of one noise together |
//! | `innovations.rs` | its arithmetic: covariances of block means, their innovations |
//! | `rounded.rs` | what the steps of a channel leave in a mean |
//! | `hold.rs` | the same while samples come: what is held now, and how long still |
//!
//! Deliberately absent: corrections of any sample. Nothing is dropped unless the result says so.

mod correlated;
mod events;
mod hold;
mod innovations;
mod rounded;
mod segments;
mod still;
mod trace;
mod turning;
mod turns;

pub use correlated::{MeanUncertainty, mean_uncertainties};
pub(crate) use events::Event;
pub use events::EventKind;
pub(crate) use events::Odd;
pub(crate) use hold::Standing;
pub use hold::{Ahead, Hold, Look};
pub use segments::{By, Rejected, segment};
pub(crate) use segments::{Segmentation, together};
pub(crate) use still::Stillness;
pub(crate) use trace::{Channel, Run};
pub use trace::{Segment, SegmentBlocks, Trace};
pub(crate) use turns::whole_turns_of;
pub use turns::{Unwrap, whole_turns};

use crate::number;
use crate::uncertainty::quantiles::student_t_two_sided;

/// The mean of one channel over one segment.
#[derive(Debug, Clone, PartialEq)]
pub struct Mean {
    /// The mean of all its samples.
    pub value: f64,
    /// Standard deviation of the samples.
    pub sd: f64,
    /// Samples.
    pub n: u64,
    /// The uncertainty and where it comes from.
    pub uncertainty: MeanUncertainty,
    /// Samples without memory that would have the same uncertainty.
    pub effective_n: f64,
    /// Slope within the segment, per second, its standard uncertainty, and the probability of so large a slope by chance.
    pub slope: (f64, f64, f64),
    /// Events within the segment.
    pub events: Vec<(EventKind, u64)>,
}

impl Mean {
    /// Is there a slope that the noise does not explain: is one so large by chance less probable than 1 %?
    pub(crate) fn is_sloping(&self) -> bool {
        self.slope.2 < 0.01
    }
}

/// Readings of a record.
#[derive(Debug, Clone, PartialEq)]
pub struct Reduction {
    /// Segments that became readings, in the order of time.
    pub segments: Vec<Segment>,
    /// Stretches that did not, with the reason.
    pub rejected: Vec<Rejected>,
    /// For each segment the mean of each channel.
    pub means: Vec<Vec<Mean>>,
    /// What the detector judged by, where it was asked.
    pub stillness: Option<Stillness>,
    /// The resolution that is assumed of each channel whose samples show none; 0 where its digits show none either.
    pub assumed: Vec<Option<f64>>,
}

/// Probability with which the uncertainties are made to cover: 1.96 u on either side.
pub(crate) const LEVEL: f64 = 0.95;

/// Means over segments with their uncertainties.
///
/// The noise of a channel is learnt from all segments together in which it is most probably the same. `turn_s` has the duration of a turn for segments in which a joint turned: what repeats with the turn is no noise.
pub fn reduce(trace: &Trace, segmentation: Segmentation, turn_s: &[Option<f64>]) -> Reduction {
    let Segmentation { segments, rejected, stillness } = segmentation;
    let mut assumed = Vec::new();
    let per_channel: Vec<Vec<Mean>> = trace
        .channels
        .iter()
        .enumerate()
        .map(|(k, channel)| {
            let mut blocks: Vec<SegmentBlocks> = segments
                .iter()
                .enumerate()
                .map(|(i, segment)| channel.block(trace, segment, turn_s.get(i).copied().flatten()))
                .collect();
            assumed.push(assumed_resolution(channel, &blocks));
            if let Some(step) = assumed.last().copied().flatten() {
                blocks.iter_mut().for_each(|block| block.step = step);
            }
            let uncertainties = mean_uncertainties(&blocks, length(trace), LEVEL);
            segments
                .iter()
                .zip(&blocks)
                .zip(uncertainties)
                .map(|((segment, block), uncertainty)| mean(trace, k, segment, block, uncertainty))
                .collect()
        })
        .collect();
    let means = (0..segments.len()).map(|i| per_channel.iter().filter_map(|c| c.get(i).cloned()).collect()).collect();
    Reduction { segments, rejected, means, stillness, assumed }
}

/// The last decimal place of a channel that changes in no segment and is nowhere between the segments' values, as one that was set: its samples
/// show no step of its own. `None` for others.
fn assumed_resolution(channel: &Channel, blocks: &[SegmentBlocks]) -> Option<f64> {
    let mut levels: Vec<f64> = blocks.iter().map(|block| block.mean).collect();
    levels.sort_by(f64::total_cmp);
    let apart = levels.iter().zip(levels.iter().skip(1)).map(|(a, b)| b - a).filter(|apart| *apart > 0.0);
    let (least, step) = (apart.fold(f64::INFINITY, f64::min), channel.resolution());
    let is_set = step == 0.0 || step > 0.999 * least; // differences of decimals are rounded
    (is_set && blocks.iter().all(|block| block.sd == 0.0))
        .then(|| number::resolution(levels.into_iter()).unwrap_or(0.0))
}

/// How long the record is, in blocks.
fn length(trace: &Trace) -> f64 {
    (trace.before + trace.samples) as f64 / trace.block as f64
}

/// The mean of a channel over a segment, whose uncertainty is known.
fn mean(trace: &Trace, channel: usize, segment: &Segment, block: &SegmentBlocks, uncertainty: MeanUncertainty) -> Mean {
    let (slope, slope_u) = uncertainty.slope;
    let seconds = trace.block as f64 * trace.interval;
    let t = if slope_u > 0.0 { slope / slope_u } else { 0.0 };
    // not testable: no slope
    let p = student_t_two_sided(t, uncertainty.dof.max(1.0)).unwrap_or(1.0);
    let effective_n = if uncertainty.u > 0.0 { (block.sd / uncertainty.u).powi(2) } else { 1.0 };
    Mean {
        value: block.mean,
        sd: block.sd,
        n: block.samples,
        effective_n: effective_n.min(block.samples as f64),
        slope: (slope / seconds, slope_u / seconds, p),
        events: trace.count_events(channel, segment),
        uncertainty,
    }
}
