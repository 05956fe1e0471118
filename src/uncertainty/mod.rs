//! What is said about uncertainty: budgets, and the distributions behind coverage factors and tests.
//!
//! | file | subject |
//! |---|---|
//! | `budget.rs` | contributions to one quantity, combined as the GUM says |
//! | `monte_carlo.rs` | distributions drawn instead of propagated in first order |
//! | `quantiles.rs` | cdf, survival function and quantile of the normal, Student t, chi-square and F distributions |
//! | `tails.rs` | the incomplete beta and gamma functions that they rest on, accurate in the far tails |

mod budget;
pub mod monte_carlo;
pub mod quantiles;
mod tails;

pub use budget::{Combined, Contribution, Evaluation, Shape, combine};
pub(crate) use budget::{combine_groups, effective_dof};
