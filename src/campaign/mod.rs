//! The campaign: which unknowns are estimated, what is known, and the readings. A schedule is a campaign without sensor values.
//!
//! Everything here is checked once, when it is made: names resolve, every joint of every reading has a state, numbers are finite.
//! Tilts are in radians, joints in degrees (exact at quarter turns), rates in degrees per second. Deliberately absent: file formats
//! (`wire`), rows (`design`).

mod correlations;
mod identity;
mod inputs;
mod limits;
mod missing;
mod parameters;
mod readings;
mod scatter;
mod shared;
mod units;

pub(crate) use identity::{Condition, Identity, Instrument, UnitUnderTest, day};
pub(crate) use limits::ScaleFactor;
pub use limits::{Decision, Limit, Limited};
pub use parameters::{Constraint, Distribution, Kind, Known, Role};
pub(crate) use parameters::{Derived, Parameter, not_finite};
pub(crate) use readings::joint_keys;
pub use readings::{JointState, Observation, Place, Reading, Readings};
pub(crate) use scatter::{Deviating, NumberOrEstimate, OneOrSeveral, Per, Scatter};
pub use scatter::{ScatterRequest, Size};
pub(crate) use shared::Pool;
pub use shared::{Label, Shared};
pub use units::{Inferred, coefficient_unit};

use crate::algebra::Expression;
use crate::bench::Bench;
use crate::elements::Parts;
use crate::error::{Fault, Malformed, Result};
use crate::units::Unit;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A bench, its parameters and its readings: the whole question.
#[derive(Debug, Clone)]
pub struct Campaign {
    /// The bench on which was measured.
    pub bench: Bench,
    /// Units of the coefficients, as they follow from the model lines.
    pub units: Inferred,
    /// Every coefficient and tilt: the estimated first (in the campaign's order), then the known, then those assumed zero.
    pub parameters: Vec<Parameter>,
    /// Correlation coefficients of pairs of known parameters; others are independent.
    pub correlations: Vec<(String, String, f64)>,
    /// Constraints between estimated parameters.
    pub constraints: Vec<Constraint>,
    /// Quantities computed from parameters.
    pub derived: Vec<Derived>,
    /// Random effects beyond the noise of the readings.
    pub scatter: Vec<Scatter>,
    /// The readings, or the positions of a schedule.
    pub readings: Readings,
    /// The unit under test, when, where, by whom, with what.
    pub identity: Identity,
    /// Limits that results are judged by.
    pub limits: Vec<Limit>,
    /// The rule of that judgement.
    pub decision: Decision,
    /// The column of the readings that identifies the device, if they are of many devices.
    pub by: Option<String>,
    /// Titles of columns, by the names that they have here, where the table has others.
    pub titles: BTreeMap<String, String>,
}

/// What a campaign asks for, before it is matched with the bench's names.
#[derive(Debug, Clone, Default)]
pub struct Request {
    /// Estimated parameters, in order.
    pub estimate: Vec<(String, Asked)>,
    /// Known parameters, in order.
    pub known: Vec<(String, Given)>,
    /// Correlation coefficients of pairs of known parameters; others are independent.
    pub correlations: Vec<(String, String, f64)>,
}

/// An estimated parameter.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "EstimateFile")]
pub struct Asked {
    /// Where the estimate begins; needed where the model line is nonlinear in the coefficients.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<f64>,
    /// Prior value: one more row, with `prior_u` as its standard uncertainty.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prior: Option<f64>,
    /// Standard uncertainty of the prior.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prior_u: Option<f64>,
    /// Unit of these numbers; without one a tilt is in radians, a coefficient in the unit that follows from the model line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
}

/// A known parameter.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "KnownFile")]
pub struct Given {
    /// Value, in `unit`.
    pub value: f64,
    /// Unit; without one a tilt is in radians, a coefficient in the unit that follows from the model line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Type B standard uncertainty, in `unit`; 0 for an exact value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u: Option<f64>,
    /// Degrees of freedom of `u`; infinite unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dof: Option<f64>,
    /// Shape of the distribution; `u` is its standard deviation whatever the shape.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distribution: Option<Distribution>,
}

impl Campaign {
    /// Match a request with the names of the bench: every tilt of the chain and every coefficient of the model lines becomes a parameter.
    ///
    /// A name in a model line is, in this order: an axis input (`w_I`, `a_x`), a joint, a numeric column of the readings, and otherwise a
    /// coefficient (or a tilt). Errors: `UnknownName` for a parameter that the bench does not have, `NameClash` for one that is also an
    /// input, or both known and estimated.
    pub fn new(bench: Bench, request: Request, readings: Readings) -> Result<Self> {
        let names = parameter_names(&bench, &readings);
        let inputs = Parameter::inputs(&bench);
        let check = |section: &str, name: &str| -> Result<()> {
            if names.iter().any(|(known, _)| known == name)
                || inputs.iter().any(|input| section == "known" && input.id == name)
            {
                return Ok(());
            }
            let path = format!("{section}.{name}");
            if is_input(&bench, &readings, name) {
                return Err(Malformed::new(
                    Fault::NameClash,
                    format!("'{name}' is an input here, so it cannot be a parameter"),
                )
                .expected("a coefficient or tilt whose name is not also a joint, axis input or column of the readings")
                .found(input_description(&bench, &readings, name))
                .at_path(path));
            }
            let known = names.iter().map(|(name, _)| name);
            let what = format!("the bench '{}' has no parameter '{name}'", bench.id);
            Err(Malformed::unknown(what, name, known).at_path(path))
        };
        for (name, _) in &request.estimate {
            check("estimate", name)?;
        }
        for (name, _) in &request.known {
            check("known", name)?;
            if request.estimate.iter().any(|(other, _)| other == name) {
                return Err(Malformed::new(Fault::NameClash, format!("'{name}' is both known and estimated"))
                    .expected("one of the two; a value that is known only roughly is a prior: \"estimate\": { name: { \"prior\": v, \"prior_u\": u } }")
                    .at_path(format!("known.{name}")));
            }
        }
        let kind_of =
            |name: &str| names.iter().find(|(other, _)| other == name).map_or(Kind::Coefficient, |(_, kind)| *kind);
        let units = inferred(&bench, &request, &readings)?;
        let mut parameters = Vec::with_capacity(names.len());
        for (name, asked) in request.estimate {
            parameters.push(Parameter::estimated(&bench, &units, &name, kind_of(&name), asked)?);
        }
        // an input of the bench has its value from the bench
        for (name, given) in request.known.into_iter().filter(|(name, _)| !inputs.iter().any(|p| p.id == *name)) {
            parameters.push(Parameter::known(&bench, &units, &name, kind_of(&name), given)?);
        }
        parameters.extend(inputs);
        for (name, kind) in &names {
            if !parameters.iter().any(|p| p.id == *name) {
                missing::refuse_meant(&bench, &readings.columns, name)?;
                parameters.push(Parameter::assumed_zero(&bench, &units, name, *kind));
            }
        }
        missing::refuse_without_factor(&bench, &parameters)?;
        correlations::check(&parameters, &request.correlations)?;
        Ok(Campaign {
            bench,
            units,
            parameters,
            correlations: request.correlations,
            constraints: Vec::new(),
            derived: Vec::new(),
            readings,
            identity: Identity::default(),
            limits: Vec::new(),
            decision: Decision::default(),
            scatter: Vec::new(),
            by: None,
            titles: BTreeMap::new(),
        })
    }

    /// The same question on another bench and with other readings, where these parameters (by index) and these new coefficients are estimated as well.
    /// Limits, and the column of devices, are left out.
    pub(crate) fn extended(
        &self,
        bench: Bench,
        readings: Readings,
        promoted: &[usize],
        fresh: Vec<String>,
    ) -> Result<Self> {
        let mut request = Request::default();
        for (k, parameter) in self.parameters.iter().enumerate() {
            match &parameter.role {
                Role::Known(known) if !promoted.contains(&k) => {
                    request.known.push((parameter.id.clone(), known.given(parameter.stated_unit())));
                }
                _ => request.estimate.extend(parameter.asked().map(|asked| (parameter.id.clone(), asked))),
            }
        }
        for parameter in promoted.iter().filter_map(|k| self.parameters.get(*k)) {
            let start = matches!(parameter.role, Role::Known(_)).then(|| parameter.reference());
            let asked = Asked { start, unit: parameter.stated_unit(), ..Asked::default() };
            request.estimate.push((parameter.id.clone(), asked));
        }
        request.estimate.extend(fresh.into_iter().map(|id| (id, Asked::default())));
        let known = |name: &String| request.known.iter().any(|(id, _)| id == name);
        let stated = self.correlations.iter().filter(|(a, b, _)| known(a) && known(b));
        request.correlations = stated.cloned().collect();
        let mut longer = Campaign::new(bench, request, readings)?;
        longer.constraints = self.constraints.clone();
        longer.derived = self.derived.clone();
        longer.identity = self.identity.clone();
        longer.titles = self.titles.clone();
        for line in &self.scatter {
            let of = match &line.of {
                // parameters have other indices in the longer campaign
                Deviating::Parameter(k) => match longer.parameter_index(self.parameter_id(*k)) {
                    Some(k) => Deviating::Parameter(k),
                    None => continue,
                },
                other => other.clone(),
            };
            longer.scatter.push(Scatter { of, ..line.clone() });
        }
        Ok(longer)
    }

    /// How many parameters are estimated; they are the first of [`Campaign::parameters`].
    pub fn unknowns(&self) -> usize {
        self.parameters.iter().take_while(|p| matches!(p.role, Role::Estimated { .. })).count()
    }

    /// The estimated parameters, in order.
    pub fn estimated(&self) -> &[Parameter] {
        self.parameters.part(..self.unknowns())
    }

    /// The index of a parameter.
    pub fn parameter_index(&self, id: &str) -> Option<usize> {
        self.parameters.iter().position(|p| p.id == id)
    }

    /// The stated reference point: every parameter's start, prior, known value or zero.
    pub fn reference_point(&self) -> Vec<f64> {
        self.parameters.iter().map(Parameter::reference).collect()
    }

    /// Priors: the unknown, its value and the standard uncertainty of that.
    pub(crate) fn priors(&self) -> impl Iterator<Item = (usize, f64, f64)> + '_ {
        self.estimated().iter().enumerate().filter_map(|(k, own)| match &own.role {
            Role::Estimated { prior: Some(prior), .. } => Some((k, prior.value, prior.u)),
            _ => None,
        })
    }

    /// Known inputs that have an uncertainty: the parameter, and what is known of it.
    pub(crate) fn uncertain(&self) -> impl Iterator<Item = (usize, Known)> + '_ {
        self.parameters.iter().enumerate().filter_map(|(k, own)| match own.role {
            Role::Known(known) if known.u != 0.0 => Some((k, known)),
            _ => None,
        })
    }

    /// Is every sensor's line affine in the unknowns, and no unknown an angle of the chain?
    pub(crate) fn is_linear(&self) -> bool {
        let names: Vec<&str> = self.estimated().iter().map(|p| p.id.as_str()).collect();
        self.estimated().iter().all(|p| p.kind != Kind::Tilt)
            && self.bench.sensors.iter().all(|sensor| sensor.model.linear_in(&names))
    }

    /// The same question without readings, whose numeric columns are those named.
    pub(crate) fn without_readings(&self, columns: &[String]) -> Self {
        self.with_readings(Readings { columns: columns.to_vec(), rows: Vec::new() })
    }

    /// The same without random effects beyond the noise of the readings.
    pub(crate) fn without_scatter(&self) -> Self {
        Campaign { scatter: Vec::new(), ..self.clone() }
    }

    /// The same question about other readings.
    pub fn with_readings(&self, readings: Readings) -> Self {
        // field by field, without a copy of the present readings
        Campaign {
            readings,
            bench: self.bench.clone(),
            units: self.units.clone(),
            parameters: self.parameters.clone(),
            correlations: self.correlations.clone(),
            constraints: self.constraints.clone(),
            derived: self.derived.clone(),
            scatter: self.scatter.clone(),
            identity: self.identity.clone(),
            limits: self.limits.clone(),
            decision: self.decision,
            by: self.by.clone(),
            titles: self.titles.clone(),
        }
    }

    /// Does the schedule carry any sensor value? Without one it is a schedule, to be simulated or planned.
    pub(crate) fn is_measured(&self) -> bool {
        self.readings.rows.iter().any(|reading| !reading.observations.is_empty())
    }
}

/// Names and units by the indices in parts of the campaign (rows of a design, terms of a combination, lines of scatter).
impl Campaign {
    /// Identifier of parameter `k`.
    pub(crate) fn parameter_id(&self, k: usize) -> &str {
        name_of(&self.parameters, k, |p| &p.id)
    }

    /// Unit of parameter `k`.
    pub(crate) fn parameter_unit(&self, k: usize) -> &str {
        name_of(&self.parameters, k, |p| &p.unit)
    }

    /// Identifier of the bench's sensor `k`.
    pub(crate) fn sensor_id(&self, k: usize) -> &str {
        name_of(&self.bench.sensors, k, |s| &s.id)
    }

    /// Unit of the bench's sensor `k`.
    pub(crate) fn sensor_unit(&self, k: usize) -> &str {
        name_of(&self.bench.sensors, k, |s| &s.unit)
    }

    /// Label of the position of reading `k`.
    pub(crate) fn position_of(&self, k: usize) -> &str {
        name_of(&self.readings.rows, k, |r| &r.position)
    }

    /// Place of reading `k` in its file.
    pub(crate) fn place_of(&self, k: usize) -> String {
        self.readings.rows.get(k).map_or(String::new(), |r| r.place.to_string())
    }
}

/// The name at an index of a list; an index outside shows as `?`, never as another name or an empty one.
#[track_caller]
fn name_of<'a, T>(list: &'a [T], k: usize, name: impl Fn(&'a T) -> &'a str) -> &'a str {
    debug_assert!(k < list.len(), "name {k} of {}", list.len());
    list.get(k).map_or("?", name)
}

/// Units from the model lines, with those that the request states where the lines do not determine one.
fn inferred(bench: &Bench, request: &Request, readings: &Readings) -> Result<Inferred> {
    let plain = Inferred::new(bench, &readings.columns, &[]);
    let estimated = request.estimate.iter().map(|(id, asked)| ("estimate", id, &asked.unit));
    let known = request.known.iter().map(|(id, given)| ("known", id, &given.unit));
    let mut stated = Vec::new();
    for (section, id, unit) in known.chain(estimated) {
        if let Some(text) = unit.as_deref().filter(|_| plain.unit(id).is_none() && !bench.tilts().any(|t| t == id)) {
            stated.push((id.clone(), plain.parse(text).map_err(|e| e.at_path(format!("{section}.{id}.unit")))?));
        }
    }
    Ok(if stated.is_empty() { plain } else { Inferred::new(bench, &readings.columns, &stated) })
}

/// Every parameter that the bench has with these readings: tilts in chain order, then coefficients in the order of the model lines.
fn parameter_names(bench: &Bench, readings: &Readings) -> Vec<(String, Kind)> {
    let mut names: Vec<(String, Kind)> = bench.tilts().map(|name| (name.to_string(), Kind::Tilt)).collect();
    for sensor in &bench.sensors {
        for name in sensor.model.names() {
            if !is_input(bench, readings, name) && !names.iter().any(|(other, _)| other == name) {
                names.push((name.to_string(), Kind::Coefficient));
            }
        }
    }
    names
}

/// Is this name an input (of any sensor's line) rather than a parameter?
fn is_input(bench: &Bench, readings: &Readings, name: &str) -> bool {
    is_axis_input(bench, name)
        || bench.joints().any(|joint| joint == name)
        || readings.columns.iter().any(|c| c == name)
}

/// Is this the name of a rate or specific force along an axis, `w_<axis>` or `a_<axis>`, of any sensor or of the last frame?
pub(crate) fn is_axis_input(bench: &Bench, name: &str) -> bool {
    let Some(axis) = name.strip_prefix("w_").or_else(|| name.strip_prefix("a_")) else { return false };
    matches!(axis, "x" | "y" | "z") || bench.sensors.iter().any(|sensor| sensor.axes.iter().any(|(a, _)| a == axis))
}

/// Is this a column of a joint, `<joint>_...`?
fn is_of_joint(bench: &Bench, column: &str) -> bool {
    bench.joints().any(|joint| column.strip_prefix(joint).is_some_and(|suffix| suffix.starts_with('_')))
}

/// The input along an axis whose name differs from this one by case and underscores alone (`aI`, `W_I`).
fn input_meant(bench: &Bench, name: &str) -> Option<String> {
    let plain = |name: &str| name.replace('_', "").to_lowercase();
    let axes = bench.sensors.iter().flat_map(|sensor| sensor.axes.iter().map(|(axis, _)| axis.as_str()));
    let frame = ["x", "y", "z"].into_iter().filter(|_| !bench.chain.is_empty());
    axes.chain(frame)
        .flat_map(|axis| [format!("w_{axis}"), format!("a_{axis}")])
        .find(|input| input != name && plain(input) == plain(name))
}

fn input_description(bench: &Bench, readings: &Readings, name: &str) -> String {
    if is_axis_input(bench, name) {
        format!("{name}, a rate or specific force along an axis")
    } else if readings.columns.iter().any(|c| c == name) {
        format!("{name}, a numeric column of the readings")
    } else {
        format!("{name}, a joint of the chain")
    }
}

/// A derived quantity, in the requested unit, else in that of its line.
///
/// Errors: names that are no parameters, the name of a parameter, a unit of another dimension than the line's.
pub(crate) fn derived(campaign: &Campaign, id: &str, line: Expression, unit: Option<&str>) -> Result<Derived> {
    for name in line.names() {
        if campaign.parameter_index(name).is_none() {
            let list: Vec<&str> = campaign.parameters.iter().map(|p| p.id.as_str()).collect();
            return Err(Malformed::new(
                Fault::UnknownName,
                format!("the derived quantity '{id}' uses '{name}', which is not a parameter"),
            )
            .expected(format!("parameters of this bench: {}", list.join(", ")))
            .found(format!("'{name}'")));
        }
    }
    if campaign.parameter_index(id).is_some() {
        return Err(Malformed::new(
            Fault::NameClash,
            format!("the derived quantity '{id}' has the name of a parameter"),
        )
        .expected("a different name"));
    }
    let of_line = campaign.unit_of(&line);
    let symbol = |unit: &Unit| unit.symbol().to_string();
    let Some(text) = unit else {
        return Ok(Derived {
            id: id.to_string(),
            line,
            unit: of_line.as_ref().map_or(String::new(), symbol),
            written: None,
        });
    };
    let wanted = campaign.units.parse(text).map_err(|e| e.at_path("unit"))?;
    // K/1.299 - 1 is a pure number whatever the unit of K: that of 1.299 is K's
    let of_line = if line.is_less_one() && wanted.dimension().is_number() { Some(Unit::one()) } else { of_line };
    let to = match &of_line {
        Some(of_line) => of_line.conversion(&wanted).ok_or_else(|| {
            Malformed::new(Fault::Value, format!("the unit of the derived quantity '{id}' has another dimension"))
                .expected(format!("{}, or a unit that converts to it", of_line.symbol()))
                .found(format!("'{text}'"))
                .at_path("unit")
        })?,
        None => {
            return Err(Malformed::new(Fault::Value, format!("the unit of the derived quantity '{id}' is not known"))
                .expected("a line of parameters that all have a unit, and whose terms agree; or no \"unit\" here")
                .found(format!("'{text}'"))
                .at_path("unit"));
        }
    };
    let converted = if to.is_none() { line.clone() } else { line.times(&Expression::number(to.factor())?) };
    Ok(Derived { id: id.to_string(), line: converted, unit: symbol(&wanted), written: Some(line) })
}
