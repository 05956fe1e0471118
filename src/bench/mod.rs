//! The bench: a chain of rotations from the ground to the sensor, and each sensor's error model as one line of algebra.
//!
//! ```text
//! inputs = (R1 R2 ... Rn)^T (earth rate, specific force)  +  the rates of the turning joints, carried to the sensor
//! reading = model line(inputs; coefficients)
//! ```
//!
//! A bench is data: no system that a bench file can describe needs code. Frames: ground x east, y north, z up; rotations are
//! active and take sensor components to the ground. Deliberately absent: lever arms, dynamics, file formats (`wire` knows those).

mod builtin;
pub mod earth;
mod modulation;
mod rotation;

pub use builtin::built_in;
pub(crate) use builtin::built_ins;
pub(crate) use earth::{EARTH_RATE_DEG_H, NORMAL_GRAVITY_FORMULA, NORMAL_GRAVITY_U_M_S2};
pub use earth::{GravityFrom, STANDARD_GRAVITY_M_S2, normal_gravity};
pub(crate) use modulation::Modulation;
pub use rotation::{Axis, sin_cos_deg};

use crate::algebra::{Expression, Function};
use crate::error::{Fault, Malformed, Result};
use crate::units::Unit;
use crate::vocabulary::vocabulary;
use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A bench: its site, its units, its chain of rotations and its sensors.
#[derive(Debug, Clone)]
pub struct Bench {
    /// Short name, for example `gyro-turntable`.
    pub id: String,
    /// One line for a person.
    pub title: String,
    /// The paper and its equations, or whatever the description was taken from.
    pub source: String,
    /// What a user of this bench should know: names in words, conventions.
    pub notes: Vec<String>,
    /// Latitude, Earth rate and gravity; `None` means no Earth rate and 1 g.
    pub site: Option<Site>,
    /// Units of rates and specific forces in the model lines.
    pub units: Units,
    /// Rotations from the ground (first) to the sensor (last).
    pub chain: Vec<Link>,
    /// The sensors that are read, in the file's order.
    pub sensors: Vec<Sensor>,
    /// Relative standard uncertainties of the rates of turning joints, common to all readings; none for those not listed.
    pub rate_u: Vec<(String, f64)>,
    /// Least and largest size of the rates that a joint turns at, deg/s; what lies outside is looked at, not refused.
    pub rate_range: Vec<(String, [f64; 2])>,
    /// Quantities in the field's words that every campaign derives where it estimates what they need.
    pub derived: Vec<DerivedQuantity>,
    /// What columns of the readings are when the unit is in use, as lines of algebra in `w_*` and `a_*`: rates and specific forces that no
    /// chain gives.
    pub in_use: Vec<(String, Expression)>,
}

/// A quantity that a bench derives from its parameters, for example a bias in deg/h from a voltage and a scale factor.
#[derive(Debug, Clone, PartialEq)]
pub struct DerivedQuantity {
    /// Its name.
    pub id: String,
    /// A line of algebra in the parameters.
    pub line: Expression,
    /// The unit that its value is wanted in; that of the line where there is none.
    pub unit: Option<String>,
}

/// The site of the bench.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Site {
    /// Geodetic latitude in degrees, north positive.
    pub latitude_deg: f64,
    /// Its standard uncertainty, in degrees.
    pub latitude_u_deg: f64,
    /// Rotation rate of the Earth in degrees per hour.
    pub earth_rate_deg_h: f64,
    /// Local gravity in units of standard gravity.
    pub gravity_g: f64,
    /// Its standard uncertainty, in units of standard gravity.
    pub gravity_u_g: f64,
    /// Where it comes from.
    pub gravity_from: GravityFrom,
}

/// Units of the inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "UnitsFile")]
pub struct Units {
    /// Unit of angular rates.
    #[serde(default)]
    pub rate: RateUnit,
    /// Unit of specific forces.
    #[serde(default)]
    pub force: ForceUnit,
}

vocabulary! {
    /// Unit of angular rate.
    #[derive(Default)]
    #[schemars(rename = "RateFile")]
    RateUnit {
        /// Degrees per second.
        #[default]
        DegreesPerSecond = "deg/s",
        /// Degrees per hour.
        DegreesPerHour = "deg/h",
        /// Radians per second.
        RadiansPerSecond = "rad/s",
        /// Arcseconds per second.
        ArcsecondsPerSecond = "arcsec/s",
    }
}

impl RateUnit {
    /// How many of this unit make one degree per second.
    ///
    /// ```
    /// assert_eq!(tumble::bench::RateUnit::DegreesPerHour.per_deg_s(), 3600.0);
    /// ```
    pub fn per_deg_s(self) -> f64 {
        match self {
            RateUnit::DegreesPerSecond => 1.0,
            RateUnit::DegreesPerHour | RateUnit::ArcsecondsPerSecond => 3600.0,
            RateUnit::RadiansPerSecond => std::f64::consts::PI / 180.0,
        }
    }
}

vocabulary! {
    /// Unit of specific force.
    #[derive(Default)]
    #[schemars(rename = "ForceFile")]
    ForceUnit {
        /// Standard gravity, 9.80665 m/s^2.
        #[default]
        StandardGravity = "g",
        /// Metres per second squared.
        MetresPerSecondSquared = "m/s^2",
    }
}

impl ForceUnit {
    /// How many of this unit make one g.
    pub(crate) fn per_g(self) -> f64 {
        match self {
            ForceUnit::StandardGravity => 1.0,
            ForceUnit::MetresPerSecondSquared => STANDARD_GRAVITY_M_S2,
        }
    }
}

/// One rotation of the chain.
#[derive(Debug, Clone, PartialEq)]
pub enum Link {
    /// A commanded joint: each reading says its angle or its rate.
    Joint {
        /// Name; a reading's keys are `<name>_deg`, `<name>_deg_s`, `<name>_turns`.
        name: String,
        /// The axis it turns about, in the frame before it.
        about: Axis,
        /// What it is, for a person; may be empty.
        meaning: String,
    },
    /// A small unknown rotation: a parameter, in radians. Where it follows a joint's angle, the parameter times a factor; its
    /// rate `tilt * d factor/dt` is left out (over whole turns a positioning error closes).
    Tilt {
        /// Name of the parameter.
        name: String,
        /// The axis it turns about, in the frame before it.
        about: Axis,
        /// What is tilted against what, for a person.
        meaning: String,
        /// The factor by which it follows the joints' angles; `None` for a constant tilt.
        times: Option<Modulation>,
    },
}

impl Link {
    /// The joint's or tilt's name.
    pub(crate) fn name(&self) -> &str {
        match self {
            Link::Joint { name, .. } | Link::Tilt { name, .. } => name,
        }
    }
}

/// A sensor: its axes in the last frame of the chain, and its model line.
#[derive(Debug, Clone)]
pub struct Sensor {
    /// Name; the key of its readings.
    pub id: String,
    /// Unit of its readings, for example `V`.
    pub unit: String,
    /// Named axes as direction cosines in the last frame; inputs are `w_<name>` and `a_<name>`.
    pub axes: Vec<(String, Vector3<f64>)>,
    /// Full turn of a closed circle, in the sensor's unit: readings that differ by whole turns are the same. `None` for any other sensor.
    pub turn: Option<f64>,
    /// The axis whose rate the sensor measures, by name: one of `axes`, or `x`, `y`, `z` of the last frame. Where readings step the rate about
    /// it, fits report the errors of the scale factor.
    pub input_axis: Option<String>,
    /// reading = this line.
    pub model: Expression,
}

impl Sensor {
    /// Is its value a reference, which its line compares with columns, and no reading: the norm of a vector? It is exact, or has one error in all rows; digits of its own would show
    /// in the residuals.
    pub(crate) fn is_reference(&self) -> bool {
        self.model.as_norm().is_some()
    }

    /// The direction of an axis by name.
    fn axis(&self, name: &str) -> Option<Vector3<f64>> {
        let axis = self.axes.iter().find(|(axis, _)| axis == name).map(|(_, direction)| *direction);
        axis.or_else(|| frame_axis(name))
    }

    /// The direction of the input axis, in the last frame of the chain.
    pub fn input(&self) -> Option<Vector3<f64>> {
        self.axis(self.input_axis.as_deref()?)
    }
}

/// An axis of the last frame by its name.
fn frame_axis(name: &str) -> Option<Vector3<f64>> {
    Axis::ALL.into_iter().find(|axis| axis.name() == name).map(Axis::unit)
}

/// Most joints of a chain: positions that discriminate unknowns are sought over all of them.
const MOST_JOINTS: usize = 64;
/// Most joints and tilts together.
const MOST_LINKS: usize = 512;

impl Bench {
    /// Check what no single entry can know: repeated names, axes that clash, direction cosines that are none.
    ///
    /// Errors: `NameClash` for a joint, tilt, sensor or axis that repeats; `Value` for numbers out of range.
    pub(crate) fn checked(self) -> Result<Self> {
        let joints = self.joints().count();
        for (what, count, most) in [("joints", joints, MOST_JOINTS), ("joints and tilts", self.chain.len(), MOST_LINKS)]
        {
            if count > most {
                return Err(Malformed::new(Fault::Value, format!("the chain has too many {what}"))
                    .expected(format!("at most {most}"))
                    .found(count.to_string())
                    .at_path("chain"));
            }
        }
        for (k, link) in self.chain.iter().enumerate() {
            let path = format!("chain[{k}]");
            identifier(link.name()).map_err(|e| e.at_path(&path))?;
            if let Some(first) = self.chain.iter().take(k).position(|other| other.name() == link.name()) {
                let is_tilt = |at: usize| matches!(self.chain.get(at), Some(Link::Tilt { .. }));
                // a joint's name is in every reading, so of the two it is the tilt that should be renamed
                let (at, what) = match (is_tilt(first), is_tilt(k)) {
                    (true, false) => (first, format!("the tilt '{}' has the name of a joint", link.name())),
                    (false, true) => (k, format!("the tilt '{}' has the name of a joint", link.name())),
                    _ => (k, format!("the chain has '{}' twice", link.name())),
                };
                return Err(Malformed::new(Fault::NameClash, what)
                    .expected("each joint and tilt once; two rotations need two names")
                    .found(format!("chain[{first}] and chain[{k}]"))
                    .at_path(format!("chain[{at}]")));
            }
        }
        if self.sensors.is_empty() {
            return Err(Malformed::new(Fault::Missing, "the bench has no sensor")
                .expected("at least one entry, for example \"V\": { \"unit\": \"V\", \"model\": \"V0 + k*x\" }")
                .at_path("sensors"));
        }
        for sensor in &self.sensors {
            let path = format!("sensors.{}", sensor.id);
            identifier(&sensor.id).map_err(|e| e.at_path(&path))?;
            if let Some(k) = self.chain.iter().position(|link| link.name() == sensor.id) {
                let what = format!("a link of the chain has the name of the sensor '{}'", sensor.id);
                return Err(Malformed::new(Fault::NameClash, what)
                    .expected("different names for both")
                    .found(format!("chain[{k}] and sensors.{}", sensor.id))
                    .at_path(format!("chain[{k}]")));
            }
            Unit::parse_any(&sensor.unit).map(|_| ()).or_else(|e| {
                if sensor.unit.trim().is_empty() { Ok(()) } else { Err(e.at_path(format!("{path}.unit"))) }
            })?;
            if let Some(axis) = sensor.input_axis.as_deref().filter(|axis| sensor.axis(axis).is_none()) {
                return Err(Malformed::new(
                    Fault::UnknownName,
                    format!("the sensor '{}' has no axis '{axis}'", sensor.id),
                )
                .expected("x, y, z or one of the sensor's \"axes\"")
                .found(format!("'{axis}'"))
                .at_path(format!("{path}.input_axis")));
            }
            for (axis, direction) in &sensor.axes {
                let path = format!("sensors.{}.axes.{axis}", sensor.id);
                let norm = direction.norm();
                if !norm.is_finite() || (norm - 1.0).abs() > 1e-3 {
                    return Err(Malformed::new(Fault::Value, format!("axis {axis} is not a direction"))
                        .expected("three direction cosines whose squares sum to 1 (within 1e-3)")
                        .found(format!("length {norm}"))
                        .at_path(path));
                }
                if frame_axis(axis).is_some_and(|unit| unit != *direction) {
                    return Err(Malformed::new(Fault::NameClash, format!("axis {axis} of {} is not the frame's {axis}", sensor.id))
                        .expected("w_x, w_y, w_z, a_x, a_y, a_z belong to the last frame of the chain; give the axis another name")
                        .at_path(path));
                }
            }
        }
        if let Some(site) = self.site.filter(|site| !(site.latitude_deg.abs() <= 90.0)) {
            return Err(Malformed::new(Fault::Value, "the latitude is not on Earth")
                .expected("-90 to 90")
                .found(site.latitude_deg.to_string())
                .at_path("site.latitude_deg"));
        }
        for (joint, [least, most]) in &self.rate_range {
            let path = format!("rate_range_deg_s.{joint}");
            if !self.joints().any(|name| name == joint) {
                return Err(Malformed::new(Fault::UnknownName, format!("the bench has no joint '{joint}'"))
                    .expected(format!("one of {}", self.joints().collect::<Vec<_>>().join(", ")))
                    .at_path(path));
            }
            if !(*least >= 0.0 && least <= most && most.is_finite()) {
                return Err(Malformed::new(Fault::Value, format!("the rates of '{joint}' have no range"))
                    .expected("the least and the largest size of its rates, deg/s, for example [0.1, 400]")
                    .found(format!("{least} to {most}"))
                    .at_path(path));
            }
        }
        for (joint, u) in &self.rate_u {
            let path = format!("rate_u_ppm.{joint}");
            if !self.joints().any(|name| name == joint) {
                let joints: Vec<&str> = self.joints().collect();
                return Err(Malformed::new(Fault::UnknownName, format!("the chain has no joint '{joint}'"))
                    .expected(format!("a joint of the chain: {}", joints.join(", ")))
                    .found(format!("'{joint}'"))
                    .at_path(path));
            }
            if !(*u >= 0.0 && u.is_finite()) {
                return Err(Malformed::new(
                    Fault::Value,
                    format!("the uncertainty of the rate of '{joint}' cannot be used"),
                )
                .expected("zero or a positive number of ppm")
                .at_path(path));
            }
        }
        Ok(self)
    }

    /// The joints' names, in chain order.
    pub fn joints(&self) -> impl Iterator<Item = &str> {
        self.chain.iter().filter_map(|link| match link {
            Link::Joint { name, .. } => Some(name.as_str()),
            Link::Tilt { .. } => None,
        })
    }

    /// Is this key of a reading one of a joint: `<joint>_deg`, `<joint>_deg_s`, `<joint>_turns`?
    pub(crate) fn is_of_joint(&self, key: &str) -> bool {
        self.joints().any(|joint| matches!(key.strip_prefix(joint), Some("_deg" | "_deg_s" | "_turns")))
    }

    /// The tilts' names, in chain order.
    pub fn tilts(&self) -> impl Iterator<Item = &str> {
        self.chain.iter().filter_map(|link| match link {
            Link::Tilt { name, .. } => Some(name.as_str()),
            Link::Joint { .. } => None,
        })
    }

    /// Earth rate in the ground frame, `[0, W cos(lat), W sin(lat)]`, in the bench's rate unit.
    pub fn earth_rate(&self) -> Vector3<f64> {
        match self.site {
            None => Vector3::zeros(),
            Some(site) => {
                let (sin, cos) = sin_cos_deg(site.latitude_deg);
                let rate = site.earth_rate_deg_h / 3600.0 * self.units.rate.per_deg_s();
                Vector3::new(0.0, rate * cos, rate * sin)
            }
        }
    }

    /// Specific force at rest in the ground frame, `[0, 0, +g]`, in the bench's force unit.
    pub fn specific_force(&self) -> Vector3<f64> {
        let gravity_g = self.site.map_or(1.0, |site| site.gravity_g);
        Vector3::new(0.0, 0.0, gravity_g * self.units.force.per_g())
    }
}

/// Is `name` one that a model line can use?
pub(crate) fn identifier(name: &str) -> Result<()> {
    let mut letters = name.chars();
    let good = letters.next().is_some_and(|c| c.is_ascii_alphabetic() || c == '_')
        && letters.all(|c| c.is_ascii_alphanumeric() || c == '_');
    if good && (name == "pi" || name == "atan2" || Function::from_name(name).is_some()) {
        return Err(Malformed::new(Fault::NameClash, format!("'{name}' is a function or constant of the algebra"))
            .expected("another name")
            .found(format!("'{name}'")));
    }
    if good {
        return Ok(());
    }
    Err(Malformed::new(Fault::Value, format!("'{name}' cannot be a name"))
        .expected("a letter or underscore, then letters, digits or underscores")
        .found(format!("'{name}'")))
}
