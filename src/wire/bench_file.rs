//! The bench file (`*.bench.json`).

use super::shapes::shaped;
use super::{Named, SiteFile};
use crate::algebra::Expression;
use crate::bench::{Axis, Bench, DerivedQuantity, Link, Modulation, Sensor, Units};
use crate::error::{Fault, Malformed, Result};
use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A bench: the chain of rotations from the ground to the sensor, and each sensor's error model as one line of algebra.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BenchFile {
    /// Short name that campaigns use, for example `gyro-turntable`.
    pub id: String,
    /// One line for a person.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub title: String,
    /// The paper and equation numbers.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub source: String,
    /// What a user of this bench should know: names in words, conventions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Latitude, Earth rate, gravity. Without it there is no Earth rate, and gravity is 1 g.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub site: Option<SiteFile>,
    /// Units of the inputs `w_*` and `a_*` in the model lines.
    #[serde(default)]
    pub units: Units,
    /// Rotations from the ground (first) to the sensor (last). May be empty: then the model line alone is the row.
    #[serde(default)]
    pub chain: Vec<LinkFile>,
    /// The sensors, by the key that readings use.
    pub sensors: Named<SensorFile>,
    /// Relative standard uncertainties of the rates of turning joints in ppm: one error of the table, common to all readings.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub rate_u_ppm: Named<f64>,
    /// Least and largest size of the rates that a joint of the table turns at, deg/s; a fit remarks on readings outside.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub rate_range_deg_s: Named<[f64; 2]>,
    /// Quantities that every campaign derives where it estimates or knows what their lines need; a campaign's own line of the same name takes
    /// the place of the bench's.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub derived: Named<DerivedFile>,
    /// For sensors without a chain: what columns of the readings are when the unit is in use, each a line of algebra in the rates `w_x`,
    /// `w_y`, `w_z` and specific forces `a_x`, `a_y`, `a_z`, in `units`; for example `"f_x": "a_x"`. By it readings can be corrected.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub in_use: Named<String>,
}

/// One rotation: either a commanded `joint` or an unknown small `tilt`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LinkFile {
    /// Name of a commanded joint; readings give `<joint>_deg` or `<joint>_deg_s`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint: Option<String>,
    /// Name of a small unknown rotation, a parameter in radians.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tilt: Option<String>,
    /// The axis, in the frame before this rotation.
    pub about: Axis,
    /// What it is, for a person.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub is: String,
    /// For a tilt that follows a joint (a linear positioning error, a wobble): the factor, a line of algebra in the joints' names (the
    /// angles that their encoders show, 0 to 360 deg, in rad: what is linear in them jumps where the encoder starts anew). The rotation is
    /// then tilt times factor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub times: Option<String>,
}

/// A direction in the last frame of the chain: an axis, or three direction cosines.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "\"x\", \"y\", \"z\" or three direction cosines [c, c, c]")]
pub enum DirectionFile {
    /// Along a frame axis.
    Axis(Axis),
    /// Three direction cosines.
    Cosines([f64; 3]),
}

/// A sensor of the bench.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SensorFile {
    /// Unit of the reading, for example `V`.
    #[serde(default)]
    pub unit: String,
    /// Named axes; the model line's inputs are `w_<name>` and `a_<name>`.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub axes: Named<DirectionFile>,
    /// For the reading of a closed circle: its full turn, in the sensor's unit (360 where that is degrees). Readings that differ by whole
    /// turns are then the same reading.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turn: Option<f64>,
    /// The axis whose rate the sensor measures: one of `axes`, or `x`, `y`, `z`. Where readings step the rate of a joint about it, a fit reports
    /// nonlinearity, asymmetry, hysteresis and repeatability of the scale factor, in ppm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input_axis: Option<String>,
    /// The error model, one line of algebra, for example `V0 + kI*w_I + kII*w_I^2`.
    pub model: String,
}

/// A derived quantity.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum DerivedFile {
    /// A line of algebra in the parameters; its unit follows from theirs.
    Line(String),
    /// A line, and the unit that its value is wanted in.
    InUnit(DerivedLine),
}

/// A line of algebra in the parameters with its unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DerivedLine {
    /// The line of algebra.
    pub line: String,
    /// The unit that its value is wanted in, for example `ppm`, `ug`, `arcsec`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
}

impl DerivedFile {
    pub(super) fn of(line: String, unit: Option<String>) -> Self {
        match unit {
            None => DerivedFile::Line(line),
            unit => DerivedFile::InUnit(DerivedLine { line, unit }),
        }
    }

    /// The line, the path of the line below the quantity's own, and the unit.
    pub(super) fn parts(self) -> (String, &'static str, Option<String>) {
        match self {
            DerivedFile::Line(line) => (line, "", None),
            DerivedFile::InUnit(file) => (file.line, ".line", file.unit),
        }
    }
}

shaped!(
    DerivedFile,
    "a line of algebra, or { \"line\": ..., \"unit\": ... }",
    text: DerivedFile::Line,
    object: DerivedFile::InUnit
);

impl BenchFile {
    /// Turn the file into a checked bench. Errors carry the path inside the file.
    pub fn into_bench(self) -> Result<Bench> {
        let site = self.site.map(SiteFile::into_site).transpose()?;
        let joints: Vec<String> = self.chain.iter().filter_map(|link| link.joint.clone()).collect();
        let joints: Vec<&str> = joints.iter().map(String::as_str).collect();
        let chain =
            self.chain.into_iter().enumerate().map(|(k, link)| link.into_link(k, &joints)).collect::<Result<_>>()?;
        let sensors = self
            .sensors
            .0
            .into_iter()
            .map(|(id, sensor)| {
                let model = Expression::parse(&sensor.model).map_err(|e| e.at_path(format!("sensors.{id}.model")))?;
                let axes = sensor.axes.0.into_iter().map(|(name, direction)| (name, direction.vector())).collect();
                if let Some(turn) = sensor.turn.filter(|turn| !(*turn > 0.0 && turn.is_finite())) {
                    return Err(Malformed::new(Fault::Value, "a full turn of the circle cannot be used")
                        .expected("a positive number in the sensor's unit, for example 360 for degrees")
                        .found(turn.to_string())
                        .at_path(format!("sensors.{id}.turn")));
                }
                Ok(Sensor { id, unit: sensor.unit, axes, turn: sensor.turn, input_axis: sensor.input_axis, model })
            })
            .collect::<Result<_>>()?;
        let rate_u = self.rate_u_ppm.0.into_iter().map(|(joint, ppm)| (joint, ppm * 1e-6)).collect();
        let derived = self.derived.0.into_iter().map(|(id, file)| derived_quantity(id, file)).collect::<Result<_>>()?;
        let in_use = self.in_use.0.into_iter().map(|(column, line)| {
            let line = Expression::parse(&line).map_err(|e| e.at_path(format!("in_use.{column}")))?;
            Ok((column, line))
        });
        let in_use = in_use.collect::<Result<_>>()?;
        let (id, title, source, notes, units) = (self.id, self.title, self.source, self.notes, self.units);
        let rate_range = self.rate_range_deg_s.0;
        Bench { in_use, derived, rate_u, rate_range, id, title, source, notes, site, units, chain, sensors }.checked()
    }
}

fn derived_quantity(id: String, file: DerivedFile) -> Result<DerivedQuantity> {
    let (text, below, unit) = file.parts();
    let line = Expression::parse(&text).map_err(|e| e.at_path(format!("derived.{id}{below}")))?;
    Ok(DerivedQuantity { id, line, unit })
}

impl LinkFile {
    fn into_link(self, k: usize, joints: &[&str]) -> Result<Link> {
        let times = match (self.times, self.tilt.is_some()) {
            (None, _) => None,
            (Some(text), true) => {
                let modulation = Expression::parse(&text).and_then(|line| Modulation::new(line, joints));
                Some(modulation.map_err(|e| e.at_path(format!("chain[{k}].times")))?)
            }
            (Some(_), false) => {
                return Err(Malformed::new(Fault::Value, "only a tilt can follow a joint's angle")
                    .expected("\"times\" together with \"tilt\", or a joint without it")
                    .at_path(format!("chain[{k}].times")));
            }
        };
        match (self.joint, self.tilt) {
            (Some(name), None) => Ok(Link::Joint { name, about: self.about, meaning: self.is }),
            (None, Some(name)) => Ok(Link::Tilt { name, about: self.about, meaning: self.is, times }),
            (joint, tilt) => Err(Malformed::new(Fault::Value, "a link of the chain is one rotation")
                .expected("either \"joint\": name (commanded) or \"tilt\": name (a small unknown), with \"about\"")
                .found(if joint.is_some() && tilt.is_some() { "both" } else { "neither" })
                .at_path(format!("chain[{k}]"))),
        }
    }
}

impl DirectionFile {
    fn vector(self) -> Vector3<f64> {
        match self {
            DirectionFile::Axis(axis) => axis.unit(),
            DirectionFile::Cosines([x, y, z]) => Vector3::new(x, y, z),
        }
    }
}
