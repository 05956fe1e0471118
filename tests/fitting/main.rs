//! A campaign fitted: published tables, simulated truths, constraints, robust estimates, coverage.

mod bilinear;
mod closed_form;
mod constraints;
mod coverage;
mod edges;
mod gum;
mod known_inputs;
mod monte_carlo;
mod published_tables;
mod rank_defect;
mod robust;
mod scatter;
mod scatter_coverage;
mod simulated;
#[path = "../support/mod.rs"]
mod support;
