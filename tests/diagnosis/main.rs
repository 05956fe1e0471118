//! Hidden effects found and named, or not.

mod campaigns;
mod examples;
mod files;
mod hidden;
#[path = "../markup/mod.rs"]
mod markup;
mod questions;
#[path = "../support/mod.rs"]
mod support;
