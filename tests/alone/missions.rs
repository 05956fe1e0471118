//! The files of missions, compiled by themselves.

#[path = "../../src/wire/imu_errors_file.rs"]
mod imu_errors_file;
#[path = "../../src/wire/mission_file.rs"]
mod mission_file;
#[path = "../../src/wire/motion_file.rs"]
mod motion_file;
#[path = "../../src/wire/shapes.rs"]
mod shapes;

use imu_errors_file::ErrorsFile;
pub use mission_file::{MissionFile, read_covariance};
pub use motion_file::MotionFile;
pub use tumble::wire::{Named, Source, locate, parse};

/// Any JSON: what a covariance is made of is asked elsewhere.
type CovarianceFile = serde_json::Value;
