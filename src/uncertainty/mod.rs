//! What is said about uncertainty: the distributions behind coverage factors and tests.
//!
//! | file | subject |
//! |---|---|
//! | `quantiles.rs` | cdf, survival function and quantile of the normal, Student t, chi-square and F distributions |
//! | `tails.rs` | the incomplete beta and gamma functions that they rest on, accurate in the far tails |

pub mod quantiles;
mod tails;
