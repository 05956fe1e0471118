//! Hidden effects found and named, or not.

mod campaigns;
#[path = "../draws/mod.rs"]
mod draws;
mod examples;
mod exchanged;
mod files;
mod hidden;
#[path = "../markup/mod.rs"]
mod markup;
mod promised;
mod questions;
mod scatter;
mod schedules;
mod serial;
mod steps;
#[path = "../support/mod.rs"]
mod support;
