//! Schedules judged and found.

mod cli;
#[path = "../draws/mod.rs"]
mod draws;
mod effects;
mod enumeration;
mod linked;
mod optima;
#[path = "../plan_support/mod.rs"]
mod plan_support;
mod proofs;
mod questions;
mod schedules;
