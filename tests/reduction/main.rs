//! From a logger's file to readings: records, noise, reduction.

#[path = "../support/mod.rs"]
mod support;

mod allan;
mod readings;
mod real;
mod records;
