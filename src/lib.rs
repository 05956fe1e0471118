//! tumble
pub mod error;
