//! The field's units of the coefficients: deg/sqrt(h), deg/h, ug.

use super::Term;
use crate::bench::STANDARD_GRAVITY_M_S2 as STANDARD_GRAVITY;
use crate::units::Unit;

/// A unit of a coefficient, and what a value in the record's unit and seconds is multiplied by.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldUnit {
    /// As a person writes it.
    pub symbol: String,
    /// The factor.
    pub factor: f64,
}

/// A unit in another of its dimension.
fn size(unit: &str, one: &str) -> Option<f64> {
    Some(Unit::parse(unit).ok()?.conversion(&Unit::parse(one).ok()?)?.factor())
}

/// Degrees per second in a unit of rate.
fn rate(unit: &str) -> Option<f64> {
    size(unit, "deg/s")
}

/// m/s^2 in a unit of specific force.
fn force(unit: &str) -> Option<f64> {
    size(unit, "m/s^2")
}

/// The unit in which the field states a coefficient, for a record in `unit`.
pub fn field_unit(term: Term, unit: &str) -> FieldUnit {
    let (symbol, factor) = match (rate(unit), force(unit), term) {
        (Some(r), _, Term::Quantization) => ("arcsec".into(), 3600.0 * r),
        (Some(r), _, Term::RandomWalk) => ("deg/sqrt(h)".into(), 60.0 * r),
        (Some(r), _, Term::BiasInstability) => ("deg/h".into(), 3600.0 * r),
        (Some(r), _, Term::RateRandomWalk) => ("deg/h/sqrt(h)".into(), 216000.0 * r),
        (Some(r), _, Term::Ramp) => ("deg/h/h".into(), 3600.0 * 3600.0 * r),
        (_, Some(f), Term::Quantization) => ("m/s".into(), f),
        (_, Some(f), Term::RandomWalk) => ("ug/sqrt(Hz)".into(), 1e6 * f / STANDARD_GRAVITY),
        (_, Some(f), Term::BiasInstability) => ("ug".into(), 1e6 * f / STANDARD_GRAVITY),
        (_, Some(f), Term::RateRandomWalk) => ("ug/sqrt(h)".into(), 60e6 * f / STANDARD_GRAVITY),
        (_, Some(f), Term::Ramp) => ("ug/h".into(), 3600e6 * f / STANDARD_GRAVITY),
        (_, _, Term::Quantization) => (format!("{unit} s"), 1.0),
        (_, _, Term::RandomWalk) => (format!("{unit}/sqrt(Hz)"), 1.0),
        (_, _, Term::BiasInstability) => (unit.to_string(), 1.0),
        (_, _, Term::RateRandomWalk) => (format!("{unit}/sqrt(s)"), 1.0),
        (_, _, Term::Ramp) => (format!("{unit}/s"), 1.0),
    };
    FieldUnit { symbol, factor }
}

/// A unit of rate (`true`) in rad/s, or of specific force in m/s^2, as a factor; `None` for others.
pub(crate) fn si_factor(unit: &str) -> Option<(bool, f64)> {
    rate(unit).map(|r| (true, r * std::f64::consts::PI / 180.0)).or_else(|| force(unit).map(|f| (false, f)))
}
