//! From a logger's file to readings: records, noise, reduction.
//!
//! Noise and reduction are compiled here once more by themselves, as kernels are in `tests/kernels`: nothing of them is public for a test's sake.
#![allow(
    dead_code,
    unused_imports,
    reason = "a file of the library stands here as a whole, and a test asks a part of it"
)]

mod allan;
#[path = "../draws/mod.rs"]
mod draws;
#[path = "../../src/elements.rs"]
mod elements;
mod faults;
mod formats;
mod hold;
mod labels;
#[path = "../../src/linear.rs"]
mod linear;
mod loggers;
#[path = "../../src/noise/mod.rs"]
mod noise;
#[path = "../../src/number.rs"]
mod number;
mod readings;
mod real;
mod records;
#[path = "../../src/reduce/mod.rs"]
mod reduce;
mod samples;
#[path = "../../src/stop.rs"]
mod stop;
#[path = "../support/mod.rs"]
mod support;
mod turning;
#[path = "../alone/uncertainty.rs"]
mod uncertainty;
#[path = "../../src/vocabulary.rs"]
mod vocabulary;
mod worked;

use tumble::{bench, units};
