//! What the estimator stands on: algebra, adjustment, quantiles, and reference sets with exact answers.

mod estimate;
mod estimate_properties;
mod kinematics;
mod misfits;
mod nist_strd;
mod properties;
mod reference_sets;
mod scatter;
mod small_angle_rows;
#[path = "../support/mod.rs"]
mod support;
mod units;
mod variance_components;
