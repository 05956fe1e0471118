//! The strapdown navigator, its errors, and what explains measured ones.

mod diagnose;
mod example;
mod files;
mod laws;
mod measured;
mod missions;
mod navigator;
