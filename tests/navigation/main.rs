//! The strapdown navigator, its errors, and what explains measured ones.
//!
//! It is compiled here once more by itself, as kernels are in `tests/kernels`: nothing of it is public for a test's sake.
#![allow(
    dead_code,
    unused_imports,
    reason = "a file of the library stands here as a whole, and a test asks a part of it"
)]

#[path = "../alone/bench.rs"]
mod bench;
mod diagnose;
#[path = "../alone/diagnosis.rs"]
mod diagnosis;
#[path = "../draws/mod.rs"]
mod draws;
#[path = "../../src/elements.rs"]
mod elements;
mod example;
mod files;
mod laws;
#[path = "../../src/linear.rs"]
mod linear;
mod measured;
mod missions;
#[path = "../../src/mix.rs"]
mod mix;
#[path = "../../src/navigate/mod.rs"]
mod navigate;
mod navigator;
#[path = "../../src/number.rs"]
mod number;
mod partly;
mod random;
#[path = "../../src/stop.rs"]
mod stop;
#[path = "../alone/uncertainty.rs"]
mod uncertainty;
#[path = "../../src/vocabulary.rs"]
mod vocabulary;
#[path = "../alone/missions.rs"]
mod wire;
mod worked;

use tumble::{error, fit, units};
