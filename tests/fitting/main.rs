//! A campaign fitted: published tables, simulated truths, constraints, robust estimates, coverage.

mod absorbed;
mod azimuth;
mod batch;
mod bilinear;
mod closed_form;
mod conformity;
mod constraints;
mod coverage;
#[path = "../draws/mod.rs"]
mod draws;
mod edges;
mod gum;
mod known_inputs;
mod monte_carlo;
mod parts;
mod published_tables;
mod rank_defect;
mod remarks;
mod robust;
mod scale_factor;
mod scatter;
mod scatter_coverage;
mod simulated;
mod site;
mod streamed;
#[path = "../support/mod.rs"]
mod support;
