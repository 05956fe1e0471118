//! Planning: how well a schedule will do before anyone measures, and which positions would do better.
//!
//! ```text
//! cov x = M^-1,   M = sum over mountings of A' V^-1 A,   V = diag(u^2) + scatter of the mounting      (rows need no readings)
//! D: det M largest   A: sum of u^2 smallest   G: largest predicted u smallest   C: u of one quantity smallest
//! I: mean predicted u^2 smallest   E: u of the worst combination of angles smallest
//! ```
//!
//! | file | subject |
//! |---|---|
//! | `effort.rs` | noise of the sensors, scatter of remounting, costs |
//! | `judge.rs` | predicted uncertainties, also of derived quantities, what is not estimable, reliability, drift; known inputs, and the tilts through which they act |
//! | `point.rs` | the point at which the rows are linearised, and what vanishes there |
//! | `candidates.rs` | sweeps, forbidden zones, portions; coarser sweeps within a finer one |
//! | `whitened.rs` | rows made independent of each other, of a schedule or mounting by mounting; deviations that link positions, as unknowns after the parameters |
//! | `pool.rs` | candidates as whitened rows in good coordinates |
//! | `blocks.rs` | these rows in memory, and sums over all of them |
//! | `criterion.rs` | D, A, G, I, E and c in the coordinates of the pool; gradients of requested quantities |
//! | `objective.rs` | objectives to be minimised, their values, and the worst of several variances |
//! | `problem.rs` | an exchange problem, and its designs |
//! | `search.rs` | all designs where there are few, else many starts; the least number for which something is found |
//! | `state.rs` | a design in the making: what every candidate that comes (and a block that goes) does to the objective, and exchanges |
//! | `exchange.rs` | one start: a first design, exchanges, perturbations; within a budget mountings that move and costs spent anew |
//! | `prices.rs` | what chosen portions cost together |
//! | `bound.rs` | the approximate design: the bound of every schedule |
//! | `request.rs` | what is asked of a plan |
//! | `question.rs` | the augmented model; the question of every search (by number, budget or goal, or to discriminate), and the schedules of its answers |
//! | `improve.rs` | the best positions, chosen or added; angles between the candidates, and why each mounting is in a schedule |
//! | `goal.rs` | the fewest, and the cheapest, positions that reach a goal |
//! | `discriminate.rs` | positions that discriminate between two effects, or between one effect and many |
//! | `order.rs` | the order to run |
//!
//! Deliberately absent: readings (what was measured plays no part, except as a source of the noise), nonlinear design over unknown
//! parameter values (rows are taken at one point: stated, fitted or zero).

mod blocks;
mod bound;
mod candidates;
mod criterion;
mod discriminate;
mod effort;
mod exchange;
mod goal;
mod improve;
mod judge;
mod objective;
mod order;
mod point;
mod pool;
mod prices;
mod problem;
mod question;
mod request;
mod search;
mod state;
mod whitened;

pub use candidates::{Unit, Zone, sweep, without};
pub(crate) use candidates::{conditions_read, from_schedule, sweep_with_rates};
pub use criterion::Criterion;
pub(crate) use discriminate::{DiscriminatingPosition, Separated, separate};
pub use discriminate::{discriminate, discriminating_positions};
pub use effort::{Costs, Noise, Offer, planned, positions_only};
pub(crate) use effort::{NoiseSource, SensorNoise, Work, grouped, mounting, mountings};
pub use goal::{Goal, reach};
pub(crate) use goal::{GoalOutcome, Reached};
pub use improve::improve;
pub(crate) use improve::{Improvement, Reason, SearchRecord};
pub use judge::judge;
pub(crate) use judge::{Judgement, Predicted, PredictedDerived, ThroughTilts, gradients, is_angle, repeated};
pub use order::{Order, ordered};
pub use point::judged_at;
pub(crate) use point::{Judged, Lacking, PointSource};
pub use question::extended;
pub(crate) use request::Progress;
pub use request::{Method, Refinement, Request};
pub(crate) use whitened::Independent;
pub use whitened::Term;
