//! Schedules judged and found.

mod cli;
mod effects;
mod enumeration;
mod optima;
#[path = "../plan_support/mod.rs"]
mod plan_support;
mod questions;
mod schedules;
