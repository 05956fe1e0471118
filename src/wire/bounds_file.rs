//! Limits of results, and lines of `"constraints"`, in a campaign file: what must hold between estimated parameters.

use super::Named;
use super::shapes::shaped;
use crate::campaign::{Campaign, Constraint, Kind, Limit, Limited, Role, not_finite};
use crate::error::{Fault, Malformed, Result};
use crate::units::Conversion;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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

shaped!(
    LimitFile,
    "[lower, upper], or { \"between\": [lower, upper], \"unit\": ... }",
    list: LimitFile::Bare,
    object: LimitFile::InUnit
);

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

/// A constraint: `of` with `equals` or `between`, or `norm_of` with `at_most`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConstraintFile {
    /// A combination of estimated parameters, each with its factor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of: Option<Named<f64>>,
    /// Estimated parameters whose root sum of squares is bounded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub norm_of: Option<Vec<String>>,
    /// Lower and upper bound of `of`; null for none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub between: Option<[Option<f64>; 2]>,
    /// The value of `of`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub equals: Option<f64>,
    /// The largest value of `norm_of`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_most: Option<f64>,
    /// Unit of the bounds; without one tilts are in radians, coefficients in the unit that follows from the model line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
}

impl ConstraintFile {
    pub(super) fn into_constraint(self, campaign: &Campaign) -> Result<Constraint> {
        let index = |id: &str| -> Result<usize> {
            match campaign.parameter_index(id) {
                Some(k) if matches!(campaign.parameters.get(k).map(|p| &p.role), Some(Role::Estimated { .. })) => Ok(k),
                found => {
                    let list: Vec<&str> = campaign.estimated().iter().map(|p| p.id.as_str()).collect();
                    Err(Malformed::new(
                        Fault::UnknownName,
                        format!("a constraint names '{id}', which is not estimated"),
                    )
                    .expected(format!("estimated parameters: {}", list.join(", ")))
                    .found(if found.is_some() {
                        "a known or assumed parameter"
                    } else {
                        "no such parameter"
                    }))
                }
            }
        };
        // numbers of the constraint to internal ones: of a term, and of the bounds, which are carried in the first term's unit
        let converted = |members: &[usize]| -> Result<(Conversion, Vec<f64>)> {
            let Some(unit) = self.unit.as_deref() else { return Ok((Conversion::NONE, vec![1.0; members.len()])) };
            let conversion = |k: &usize| campaign.parameter_conversion(*k, unit).map_err(|e| e.at_path("unit"));
            let all: Vec<Conversion> = members.iter().map(conversion).collect::<Result<_>>()?;
            // without terms there is nothing to convert
            let first = all.first().copied().unwrap_or(Conversion::NONE);
            Ok((first, all.iter().map(|other| first.factor() / other.factor()).collect()))
        };
        let finite = |value: f64, key: &str| if value.is_finite() { Ok(value) } else { Err(not_finite(key, value)) };
        match (self.of, self.norm_of, self.between, self.equals, self.at_most) {
            (Some(of), None, between, equals, None) if between.is_some() != equals.is_some() => {
                if of.is_empty() || of.0.iter().any(|(_, factor)| !factor.is_finite()) {
                    return Err(Malformed::new(
                        Fault::Value,
                        "a constraint needs at least one parameter with a finite factor",
                    )
                    .expected("for example { \"dtheta_y2\": 1 }")
                    .at_path("of"));
                }
                let mut terms: Vec<(usize, f64)> =
                    of.0.iter()
                        .map(|(id, factor)| Ok((index(id).map_err(|e| e.at_path(format!("of.{id}")))?, *factor)))
                        .collect::<Result<_>>()?;
                let (to, factors) = converted(&terms.iter().map(|(k, _)| *k).collect::<Vec<_>>())?;
                terms.iter_mut().zip(&factors).for_each(|((_, factor), by)| *factor *= by);
                let (lower, upper) = match (between, equals) {
                    (Some([lower, upper]), _) => (lower.unwrap_or(f64::NEG_INFINITY), upper.unwrap_or(f64::INFINITY)),
                    // without "between" there is "equals": one of both, by the guard
                    (None, value) => {
                        let value = finite(value.unwrap_or(f64::NAN), "equals")?;
                        (value, value)
                    }
                };
                if lower == f64::NEG_INFINITY && upper == f64::INFINITY {
                    return Err(Malformed::new(Fault::Value, "this constraint bounds nothing")
                        .expected("a lower or an upper bound that is a number")
                        .found("[null, null]")
                        .at_path("between"));
                }
                if !(lower <= upper) {
                    return Err(Malformed::new(Fault::Value, "the lower bound is above the upper")
                        .expected("[lower, upper]")
                        .found(format!("[{lower}, {upper}]"))
                        .at_path("between"));
                }
                Ok(Constraint::Linear { terms, lower: to.apply(lower), upper: to.apply(upper) })
            }
            (None, Some(names), None, None, Some(at_most)) => {
                let of: Vec<usize> = names
                    .iter()
                    .enumerate()
                    .map(|(k, id)| index(id).map_err(|e| e.at_path(format!("norm_of[{k}]"))))
                    .collect::<Result<_>>()?;
                if of.is_empty() || !(finite(at_most, "at_most")? > 0.0) {
                    return Err(Malformed::new(
                        Fault::Value,
                        "a norm constraint bounds at least one parameter by a positive number",
                    )
                    .expected("\"norm_of\": [names], \"at_most\": a positive number")
                    .found(format!("{} parameters, at_most {at_most}", of.len()))
                    .at_path("at_most"));
                }
                let (to, factors) = converted(&of)?;
                if factors.iter().any(|factor| (factor - 1.0).abs() > 1e-12) {
                    return Err(Malformed::new(Fault::Value, "a norm is of parameters in one unit")
                        .expected("parameters that the model line carries in the same unit")
                        .at_path("norm_of"));
                }
                Ok(Constraint::Norm { of, at_most: to.apply(at_most) })
            }
            _ => Err(Malformed::new(Fault::Value, "this is not a constraint")
                .expected("\"of\" with either \"between\" or \"equals\", or \"norm_of\" with \"at_most\"")),
        }
    }
}
