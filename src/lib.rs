//! tumble
pub mod error;
pub mod estimate;
pub mod uncertainty;
