//! Constants of the Earth.

use crate::bench::earth::{
    CENTRIFUGAL_RATIO, EARTH_RATE_DEG_H, EARTH_RATE_RAD_S, ECCENTRICITY_SQUARED, FLATTENING, SEMI_MAJOR_AXIS_M,
};

/// What follows from the defining constants agrees with the table to its last digit; GM = 3.986004418e14 m^3/s^2 (TR8350.2, table 3.1).
#[test]
fn derived_constants_follow_from_the_defining_ones() {
    assert!((FLATTENING * (2.0 - FLATTENING) - ECCENTRICITY_SQUARED).abs() < 0.5e-14);
    let semi_minor = SEMI_MAJOR_AXIS_M * (1.0 - FLATTENING);
    let ratio = EARTH_RATE_RAD_S.powi(2) * SEMI_MAJOR_AXIS_M.powi(2) * semi_minor / 3.986_004_418e14;
    assert!((ratio - CENTRIFUGAL_RATIO).abs() < 0.5e-14, "{ratio}");
    assert!((EARTH_RATE_RAD_S.to_degrees() * 3600.0 - EARTH_RATE_DEG_H).abs() < 0.5e-6);
}
