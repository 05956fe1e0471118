//! The Earth, compiled by itself.

#[path = "../../src/bench/earth.rs"]
pub mod earth;
#[path = "../../src/bench/rotation.rs"]
mod rotation;
