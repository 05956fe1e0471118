//! From a logger's file to readings: records, noise, reduction.

#[path = "../draws/mod.rs"]
mod draws;
#[path = "../support/mod.rs"]
mod support;

mod allan;
mod clocks;
mod faults;
mod formats;
mod hold;
mod labels;
mod readings;
mod real;
mod records;
mod samples;
mod turning;
