//! How good each reading is, and whether all of them agree with the model.
//!
//! Words of geodetic adjustment: a reading's *redundancy number* `r` is the share of a fault that shows in its own residual; the *minimal
//! detectable bias* is the fault that a test at significance 0.1 % finds with 80 % power (Baarda). Deliberately absent: removing readings.
//!
//! | file | subject |
//! |---|---|
//! | `rows.rs` | residual, redundancy, detectable fault of each reading; the global test |
//! | `snooping.rs` | which readings are suspicious (Baarda), and what an undetected fault would do to each parameter |
//! | `lack_of_fit.rs` | pure error from replicates against what the model leaves, positions against the readings of each (F tests) |
//! | `repeated.rs` | rows that were probably entered more than once |
//! | `residual_tests.rs` | are the residuals in random order (runs), are they normal (Shapiro-Francia) |

mod lack_of_fit;
mod repeated;
mod residual_tests;
mod rows;
mod snooping;

pub use lack_of_fit::lack_of_fit;
pub(crate) use lack_of_fit::{LackOfFit, Offsets, lack_of_fit_p};
pub(crate) use repeated::{Repeated, repeated};
pub use residual_tests::runs;
pub(crate) use residual_tests::{NormalScores, NormalityTest, RunsTest, Signs, normality, runs_of};
pub use rows::baarda_delta;
pub(crate) use rows::{ALPHA, GlobalTest, RowQuality, Tested, UNCHECKED, global_test};
pub(crate) use snooping::{Snooping, Whitened, is_rounding, snoop};
