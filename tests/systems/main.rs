//! The systems of the source papers, end to end: noiseless truth comes back, closed forms agree, intervals hold what they promise, rank
//! defects are named, malformed questions are refused, and the pictures and tables of `examples/2*` are what the program computes.

mod cube_mirror;
mod dividing_head;
#[path = "../draws/mod.rs"]
mod draws;
mod imu_table;
mod independent;
mod input_axes;
mod ready;
mod refusals;
mod skew_triad;
mod support;
