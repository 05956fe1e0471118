//! The guided calibration: closed loops on benches drawn at random, mistakes at the table, and the program with its journal.

mod bench;
mod closed_loop;
#[path = "../draws/mod.rs"]
mod draws;
mod journal;
mod mistakes;
mod samples;
#[cfg(feature = "serial")]
mod serial;
mod view;
