//! What the diagnosis of navigation errors takes from that of campaigns, compiled by itself.

#[path = "../../src/diagnosis/common.rs"]
mod common;
#[path = "../../src/diagnosis/factor.rs"]
mod factor;
#[path = "../../src/diagnosis/score.rs"]
mod score;

pub use common::Settings;
pub(crate) use common::{DIFFERENT, Gap, LENGTHS, NoiseFrom, Step, Verdict, share_of_wave};
pub(crate) use score::{Class, Deviations, Kernel, Posterior, Priors, Problem, Score};
