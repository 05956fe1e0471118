//! Distributions, compiled by themselves.

#[path = "../../src/uncertainty/quantiles.rs"]
pub mod quantiles;
#[path = "../../src/uncertainty/tails.rs"]
pub mod tails;
