//! Schedules judged and found.

mod cli;
mod effects;
mod enumeration;
#[path = "../plan_support/mod.rs"]
mod plan_support;
mod questions;
mod schedules;
