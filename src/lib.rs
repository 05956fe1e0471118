//! tumble
pub mod error;
pub mod estimate;
