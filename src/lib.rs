//! tumble
pub mod error;
pub mod navigate;
