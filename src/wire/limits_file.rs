//! Limits in a campaign file.

use super::Named;
use super::shapes::shapes;
use crate::campaign::{Campaign, Kind, Limit, Limited};
use crate::error::{Fault, Malformed, Result};
use crate::units::Conversion;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

/// Lower and upper limit, null for none; with a unit as an object.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum LimitFile {
    /// In the quantity's own unit (a tilt in radians).
    Bare([Option<f64>; 2]),
    /// In a unit.
    InUnit(LimitInUnit),
}

/// Limits in a unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimitInUnit {
    /// Lower and upper limit; null for none.
    pub between: [Option<f64>; 2],
    /// Their unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
}

impl<'de> Deserialize<'de> for LimitFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        let shapes = shapes("[lower, upper], or { \"between\": [lower, upper], \"unit\": ... }");
        shapes.list(LimitFile::Bare).object(LimitFile::InUnit).read(deserializer)
    }
}

/// Limits as files write them, in the internal units of their quantities.
pub(super) fn limits_file(campaign: &Campaign) -> Named<LimitFile> {
    let file = |limit: &Limit| {
        let (id, unit) = match limit.of {
            Limited::Parameter(k) => campaign.parameters.get(k).map(|p| (p.id.clone(), p.unit.clone()))?,
            Limited::Derived(k) => campaign.derived.get(k).map(|d| (d.id.clone(), d.unit.clone()))?,
            Limited::ScaleFactor(k) => campaign.scale_factor_errors().get(k).map(|id| (id.clone(), "ppm".into()))?,
        };
        let bound = |value: f64| value.is_finite().then_some(value);
        let unit = (!unit.is_empty()).then_some(unit);
        Some((id, LimitFile::InUnit(LimitInUnit { between: [bound(limit.lower), bound(limit.upper)], unit })))
    };
    Named(campaign.limits.iter().filter_map(file).collect())
}

/// Limits of a campaign.
///
/// Errors: a quantity that is no result, bounds that bound nothing or are the wrong way round, a unit of another
/// dimension, limits of an angle that can only be meant in another unit than radians.
pub(super) fn limits(campaign: &Campaign, file: Named<LimitFile>) -> Result<Vec<Limit>> {
    file.0
        .into_iter()
        .map(|(id, limit)| one(campaign, &id, limit).map_err(|e| e.under(&format!("limits.{id}"))))
        .collect()
}

fn one(campaign: &Campaign, id: &str, file: LimitFile) -> Result<Limit> {
    let parameter = campaign.estimated().iter().position(|p| p.id == id);
    let derived = campaign.derived.iter().position(|d| d.id == id);
    let errors = campaign.scale_factor_errors();
    let error = errors.iter().position(|error| error == id);
    let (of, own_unit, is_angle) = match (parameter, derived, error) {
        (Some(k), ..) => {
            let tilt = campaign.estimated().get(k).is_some_and(|p| p.kind == Kind::Tilt);
            (Limited::Parameter(k), campaign.estimated().get(k).map_or("", |p| p.unit.as_str()), tilt)
        }
        (None, Some(k), _) => {
            let unit = campaign.derived.get(k).map_or("", |d| d.unit.as_str());
            (Limited::Derived(k), unit, unit == "rad")
        }
        (None, None, Some(k)) => (Limited::ScaleFactor(k), "ppm", false),
        (None, None, None) => {
            let names = campaign.estimated().iter().map(|p| p.id.as_str());
            let names = names.chain(campaign.derived.iter().map(|d| d.id.as_str()));
            let names: Vec<&str> = names.chain(errors.iter().map(String::as_str)).collect();
            return Err(Malformed::new(
                Fault::UnknownName,
                format!("limits are given for '{id}', which is not a result"),
            )
            .expected(format!("an estimated parameter or derived quantity: {}", names.join(", ")))
            .found(format!("'{id}'")));
        }
    };
    let ([lower, upper], unit) = match file {
        LimitFile::Bare(between) => (between, None),
        LimitFile::InUnit(limit) => (limit.between, limit.unit),
    };
    let to = match &unit {
        Some(unit) => campaign.conversion(unit, own_unit, &format!("'{id}'")).map_err(|e| e.at_path("unit"))?,
        None => Conversion::NONE,
    };
    let lower = lower.map_or(f64::NEG_INFINITY, |v| to.apply(v));
    let upper = upper.map_or(f64::INFINITY, |v| to.apply(v));
    if !(lower < upper) || (lower == f64::NEG_INFINITY && upper == f64::INFINITY) {
        return Err(Malformed::new(Fault::Value, format!("the limits of '{id}' admit no value, or every value"))
            .expected("[lower, upper] with lower below upper; null for a side without limit")
            .found(format!("[{lower}, {upper}]")));
    }
    let largest = [lower, upper].into_iter().filter(|v| v.is_finite()).fold(0.0_f64, |max, v| max.max(v.abs()));
    if is_angle && unit.is_none() && largest > std::f64::consts::TAU {
        return Err(Malformed::new(Fault::Missing, format!("the limits of '{id}' are no angles in radians"))
            .expected("{ \"between\": [lower, upper], \"unit\": \"arcsec\" }")
            .found(format!("[{lower}, {upper}] without a unit")));
    }
    Ok(Limit { of, lower, upper })
}
