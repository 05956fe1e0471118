//! A calibration in use: corrections applied and exported, calibrations compared.

mod agreement;
mod correction;
mod exported;
mod records;
#[path = "../support/mod.rs"]
mod support;
