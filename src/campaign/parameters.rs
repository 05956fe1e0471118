//! Parameters: every coefficient of a model line and every tilt of the chain, with its stated values.

use super::{Asked, Given, Inferred};
use crate::algebra::Expression;
use crate::bench::{Bench, Link};
use crate::error::{Fault, Malformed, Result};
use crate::units::{Conversion, Unit};
use crate::vocabulary::vocabulary;

vocabulary! {
    /// Coefficient of a model line or tilt of the chain.
    Kind {
        /// A small rotation of the chain, in radians.
        Tilt = "tilt",
        /// A coefficient of a model line, in the units that make its term the sensor's unit.
        Coefficient = "coefficient",
        /// An input of the bench that is known with an uncertainty: gravity, latitude, the rate of a joint.
        #[schemars(skip)]
        Input = "input",
    }
}

/// A parameter of the model.
#[derive(Debug, Clone)]
pub struct Parameter {
    /// Its name in the chain or the model line.
    pub id: String,
    /// Tilt or coefficient.
    pub kind: Kind,
    /// `rad` for tilts; for coefficients as it follows from the model line, else as given, else empty.
    pub unit: String,
    /// What it means, for a person; may be empty.
    pub meaning: String,
    /// Estimated, known or assumed zero.
    pub role: Role,
}

/// The role of a parameter in the campaign.
#[derive(Debug, Clone, PartialEq)]
pub enum Role {
    /// Unknown, to be estimated.
    Estimated {
        /// Where the estimate begins, if stated.
        start: Option<f64>,
        /// A stated prior: one more row.
        prior: Option<Prior>,
    },
    /// Known, with a Type B uncertainty.
    Known(Known),
    /// Neither known nor estimated: taken as zero, and listed.
    AssumedZero,
}

/// A prior value: the row `1 * parameter = value` with standard uncertainty `u`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prior {
    /// Prior value.
    pub value: f64,
    /// Its standard uncertainty.
    pub u: f64,
}

/// A known value and its Type B standard uncertainty (GUM 4.3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Known {
    /// Value.
    pub value: f64,
    /// Standard uncertainty; zero for an exact value.
    pub u: f64,
    /// Degrees of freedom of `u`; infinite unless stated.
    pub dof: f64,
    /// Shape of the distribution; for Monte Carlo and for the budget's column.
    pub distribution: Distribution,
}

vocabulary! {
    /// Shape of the distribution of a known value. `u` is its standard deviation whatever the shape.
    #[derive(Default)]
    Distribution {
        /// Gaussian.
        #[default]
        Normal = "normal",
        /// Rectangular: half width `u sqrt 3`.
        Rectangular = "rectangular",
        /// Triangular: half width `u sqrt 6`.
        Triangular = "triangular",
        /// Arcsine (U-shaped): half width `u sqrt 2`.
        Arcsine = "arcsine",
    }
}

/// A quantity computed from parameters.
#[derive(Debug, Clone)]
pub struct Derived {
    /// Its name.
    pub id: String,
    /// The line of algebra that gives it, in `unit`.
    pub line: Expression,
    /// Its unit; empty where a parameter in it has none, or its terms differ.
    pub unit: String,
    /// The line as it was written, where `line` converts it to a requested unit.
    pub written: Option<Expression>,
}

/// A constraint between estimated parameters; parameters by index, numbers in internal units (radians for tilts).
#[derive(Debug, Clone, PartialEq)]
pub enum Constraint {
    /// `lower <= sum c_j x_j <= upper`; equal bounds make an equality.
    Linear {
        /// Parameter index and coefficient.
        terms: Vec<(usize, f64)>,
        /// Lower bound, may be minus infinity.
        lower: f64,
        /// Upper bound, may be infinity.
        upper: f64,
    },
    /// `sqrt(sum x_j^2) <= at_most`: a cone on a total misalignment.
    Norm {
        /// Parameter indices.
        of: Vec<usize>,
        /// Largest norm.
        at_most: f64,
    },
}

impl Known {
    /// It as a campaign gives it, in this unit.
    pub(crate) fn given(&self, unit: Option<String>) -> Given {
        let dof = self.dof.is_finite().then_some(self.dof);
        let distribution = Some(self.distribution).filter(|d| *d != Distribution::Normal);
        Given { value: self.value, unit, u: Some(self.u), dof, distribution }
    }
}

impl Parameter {
    pub(super) fn estimated(bench: &Bench, units: &Inferred, id: &str, kind: Kind, asked: Asked) -> Result<Self> {
        let path = format!("estimate.{id}");
        let (to, unit) = conversion(units, id, kind, asked.unit.as_deref(), &path)?;
        let finite = |value: Option<f64>, key: &str| match value {
            Some(v) if !v.is_finite() => Err(not_finite(&format!("{path}.{key}"), v)),
            other => Ok(other.map(|v| to.apply(v))),
        };
        let stated = asked.start.into_iter().chain(asked.prior);
        stated.into_iter().try_for_each(|value| in_radians(id, kind, asked.unit.as_deref(), value, &path))?;
        let start = finite(asked.start, "start")?;
        let prior = match (asked.prior, asked.prior_u) {
            (None, None) => None,
            (Some(value), Some(u)) => {
                if !(u > 0.0 && u.is_finite()) {
                    return Err(Malformed::new(Fault::Value, format!("the prior of '{id}' has no usable uncertainty"))
                        .expected("prior_u above zero; a value known exactly belongs in \"known\"")
                        .found(u.to_string())
                        .at_path(format!("{path}.prior_u")));
                }
                // `Some` gives `Some`
                let value = finite(Some(value), "prior")?.unwrap_or_default();
                Some(Prior { value, u: to.of_differences().apply(u) })
            }
            (value, _) => {
                let (here, missing) = if value.is_some() { ("prior", "prior_u") } else { ("prior_u", "prior") };
                return Err(Malformed::new(Fault::Missing, format!("'{id}' has {here} but no {missing}"))
                    .expected("a prior is a row: its value (prior) and its standard uncertainty (prior_u)")
                    .at_path(path));
            }
        };
        Ok(Parameter { id: id.into(), kind, unit, meaning: meaning(bench, id), role: Role::Estimated { start, prior } })
    }

    pub(super) fn known(bench: &Bench, units: &Inferred, id: &str, kind: Kind, given: Given) -> Result<Self> {
        let path = format!("known.{id}");
        let (to, unit) = conversion(units, id, kind, given.unit.as_deref(), &path)?;
        let (value, distribution) = (given.value, given.distribution.unwrap_or_default());
        let (u, dof) = (given.u.unwrap_or(0.0), given.dof.unwrap_or(f64::INFINITY));
        if !value.is_finite() {
            return Err(not_finite(&format!("{path}.value"), value));
        }
        in_radians(id, kind, given.unit.as_deref(), value, &path)?;
        if !(u >= 0.0 && u.is_finite()) {
            return Err(Malformed::new(Fault::Value, format!("the standard uncertainty of '{id}' cannot be used"))
                .expected("zero (exact) or a positive number")
                .found(u.to_string())
                .at_path(format!("{path}.u")));
        }
        if !(dof > 0.0) {
            return Err(Malformed::new(Fault::Value, format!("the degrees of freedom of '{id}' cannot be used"))
                .expected("a positive number")
                .found(dof.to_string())
                .at_path(format!("{path}.dof")));
        }
        let known = Known { value: to.apply(value), u: to.of_differences().apply(u), dof, distribution };
        Ok(Parameter { id: id.into(), kind, unit, meaning: meaning(bench, id), role: Role::Known(known) })
    }

    pub(super) fn assumed_zero(bench: &Bench, units: &Inferred, id: &str, kind: Kind) -> Self {
        let unit = internal_unit(units, id, kind).map_or(String::new(), |unit| unit.symbol().to_string());
        Parameter { id: id.into(), kind, unit, meaning: meaning(bench, id), role: Role::AssumedZero }
    }

    /// Its unit, as a file names it; `None` where it has none.
    pub(crate) fn stated_unit(&self) -> Option<String> {
        Some(self.unit.clone()).filter(|unit| !unit.is_empty())
    }

    /// An estimated parameter as it was requested.
    pub(crate) fn asked(&self) -> Option<Asked> {
        let Role::Estimated { start, prior } = self.role else { return None };
        let (prior, prior_u) = (prior.map(|prior| prior.value), prior.map(|prior| prior.u));
        Some(Asked { start, prior, prior_u, unit: self.stated_unit() })
    }

    /// The value at which the model is linearised: start, else prior, else known value, else zero.
    pub fn reference(&self) -> f64 {
        match &self.role {
            Role::Estimated { start: Some(start), .. } => *start,
            Role::Estimated { start: None, prior: Some(prior) } => prior.value,
            Role::Estimated { .. } | Role::AssumedZero => 0.0,
            Role::Known(known) => known.value,
        }
    }
}

fn meaning(bench: &Bench, id: &str) -> String {
    bench
        .chain
        .iter()
        .find_map(|link| match link {
            Link::Tilt { name, meaning, .. } if name == id => Some(meaning.clone()),
            _ => None,
        })
        .unwrap_or_default()
}

/// The unit of a parameter in computations: radians, or the unit that follows from the model line; `None` where it leaves the unit open.
pub(super) fn internal_unit(units: &Inferred, id: &str, kind: Kind) -> Option<Unit> {
    match kind {
        Kind::Tilt => Unit::parse("rad").ok(),
        Kind::Coefficient | Kind::Input => units.unit(id).cloned(),
    }
}

/// From the unit that a file names to the internal one, and the internal one's name.
///
/// Errors: no unit, or one of another dimension, with the unit that was expected.
fn conversion(units: &Inferred, id: &str, kind: Kind, unit: Option<&str>, path: &str) -> Result<(Conversion, String)> {
    let internal = internal_unit(units, id, kind);
    let symbol = internal.as_ref().map_or(String::new(), |unit| unit.symbol().to_string());
    let Some(text) = unit else { return Ok((Conversion::NONE, symbol)) };
    let path = format!("{path}.unit");
    let given = units.parse(text).map_err(|e| e.at_path(&path))?;
    let Some(internal) = internal else { return Ok((Conversion::NONE, given.symbol().to_string())) };
    let what = match kind {
        Kind::Tilt => format!("'{id}' (a tilt is an angle)"),
        Kind::Coefficient | Kind::Input => format!("'{id}'"),
    };
    let to = given.conversion_for(&internal, &what).map_err(|e| e.at_path(&path))?;
    // the same size: as the user writes it
    let symbol = if to.is_none() && kind == Kind::Coefficient { given.symbol().to_string() } else { symbol };
    Ok((if to.is_none() { Conversion::NONE } else { to }, symbol))
}

/// A tilt without a unit is in radians: more than a turn is an angle in another unit. Errors: such a value.
fn in_radians(id: &str, kind: Kind, unit: Option<&str>, value: f64, path: &str) -> Result<()> {
    if kind != Kind::Tilt || unit.is_some() || !(value.abs() > std::f64::consts::TAU) {
        return Ok(());
    }
    Err(Malformed::new(Fault::Missing, format!("'{id}' (a tilt) has no unit, and is not an angle in radians"))
        .expected("a \"unit\", for example \"arcsec\"; radians without one")
        .found(format!("{value} without a unit"))
        .at_path(path))
}

/// The error for a number that is none.
pub(crate) fn not_finite(path: &str, value: f64) -> Malformed {
    Malformed::new(Fault::Value, "not a finite number")
        .expected("a finite number")
        .found(value.to_string())
        .at_path(path)
}
