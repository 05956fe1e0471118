//! Planning: how well a schedule will do before anyone measures, and which positions would do better.
//!
//! ```text
//! cov x = M^-1,   M = sum over mountings of A' V^-1 A,   V = diag(u^2) + scatter of the mounting      (rows need no readings)
//! D: det M largest   A: sum of u^2 smallest   G: largest predicted u smallest   C: u of one quantity smallest
//! ```
//!
//! | file | subject |
//! |---|---|
//! | `effort.rs` | noise of the sensors, scatter of remounting, costs |
//! | `judge.rs` | predicted uncertainties, what is not estimable, reliability, drift |
//! | `candidates.rs` | sweeps, forbidden zones, portions |
//! | `pool.rs` | candidates as whitened rows in good coordinates |
//! | `blocks.rs` | these rows in memory, and sums over all of them |
//! | `exchange.rs` | Fedorov and coordinate exchange with rank-one updates |
//! | `bound.rs` | the approximate design: what no schedule can beat |
//! | `improve.rs` | the best positions, chosen or added |
//! | `goal.rs` | the fewest, and the cheapest, positions that reach a goal |
//! | `discriminate.rs` | positions that tell two effects apart |
//! | `order.rs` | the order to run |
//!
//! Deliberately absent: readings (what was measured plays no part, except as a source of the noise), nonlinear design over unknown
//! parameter values (rows are taken at the campaign's reference point).

mod blocks;
mod bound;
mod candidates;
mod discriminate;
mod effort;
mod exchange;
mod goal;
mod improve;
mod judge;
mod order;
mod pool;

pub use blocks::Blocks;
pub use candidates::{Unit, Zone, from_schedule, sweep, without};
pub use discriminate::{Discrimination, discriminate};
pub use effort::{Costs, Noise, NoiseSource, Offer, SensorNoise, Work, mountings};
pub use goal::{Goal, Reached, reach};
pub use improve::{Choice, Criterion, Improvement, Method, Request, choose, improve};
pub use judge::{Judgement, Predicted, PredictedDerived, PredictedReading, judge};
pub use order::{Order, ordered};
pub use pool::Term;
