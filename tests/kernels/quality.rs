//! The tests of residuals, which those of many devices rest on.

#[path = "../../src/quality/residual_tests.rs"]
mod residual_tests;

pub(crate) use residual_tests::{NormalScores, runs};
