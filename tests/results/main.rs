//! A calibration in use: corrections applied and exported, calibrations compared.

mod agreement;
mod correction;
#[path = "../draws/mod.rs"]
mod draws;
mod exported;
mod hand_held;
mod mounting;
mod programs;
mod records;
mod round_trips;
#[path = "../support/mod.rs"]
mod support;
mod trends;
