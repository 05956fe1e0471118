//! The strapdown navigator, its errors, and what explains measured ones.

mod diagnose;
#[path = "../draws/mod.rs"]
mod draws;
mod example;
mod files;
mod laws;
mod measured;
mod missions;
mod navigator;
mod partly;
mod random;
