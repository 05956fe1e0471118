//! Errors of an inertial measurement unit as a mission file gives them.

use super::shapes::shaped;
use crate::error::{Fault, Malformed, Result};
use crate::navigate::errors::{ErrorSource, ImuErrors, Instrument, Kind};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Errors of the unit; a single number applies to all axes. The axes are those of the body: x right, y forward, z up, so that a unit whose y points to the
/// right, or whose z points down, has its errors renamed and their signs changed here.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ErrorsFile {
    /// Gyro bias, deg/h.
    #[serde(skip_serializing_if = "is_default")]
    pub gyro_bias_deg_h: AxesFile,
    /// Gyro scale factor error, a ratio.
    #[serde(skip_serializing_if = "is_default")]
    pub gyro_scale_factor: AxesFile,
    /// Gyro installation errors, arcsec.
    #[serde(skip_serializing_if = "is_default")]
    pub gyro_installation_arcsec: InstallationFile,
    /// Gyro second-order coefficients, (deg/h)/(deg/s)^2.
    #[serde(skip_serializing_if = "is_default")]
    pub gyro_second_order_deg_h_per_deg2_s2: AxesFile,
    /// Acceleration-sensitive drift of the gyros, (deg/h)/g: by gyro and axis of the specific force, or x, y, z along each one's own axis.
    #[serde(skip_serializing_if = "is_default")]
    pub gyro_acceleration_sensitive_deg_h_per_g: DriftFile,
    /// Angle random walk of the gyros, deg/sqrt(h).
    #[serde(skip_serializing_if = "is_default")]
    pub angle_random_walk_deg_sqrt_h: f64,
    /// Accelerometer bias, g.
    #[serde(skip_serializing_if = "is_default")]
    pub accelerometer_bias_g: AxesFile,
    /// Accelerometer scale factor error, a ratio.
    #[serde(skip_serializing_if = "is_default")]
    pub accelerometer_scale_factor: AxesFile,
    /// Accelerometer installation errors, arcsec.
    #[serde(skip_serializing_if = "is_default")]
    pub accelerometer_installation_arcsec: InstallationFile,
    /// Accelerometer second-order coefficients, g/g^2.
    #[serde(skip_serializing_if = "is_default")]
    pub accelerometer_second_order_g_per_g2: AxesFile,
    /// Velocity random walk of the accelerometers, (m/s)/sqrt(h).
    #[serde(skip_serializing_if = "is_default")]
    pub velocity_random_walk_m_s_sqrt_h: f64,
    /// The navigator's attitude error at the start, `phi` about east, north, up, arcsec.
    #[serde(skip_serializing_if = "is_default")]
    pub start_attitude_arcsec: [f64; 3],
    /// Its velocity error at the start, east and north, m/s.
    #[serde(skip_serializing_if = "is_default")]
    pub start_velocity_m_s: [f64; 2],
    /// Its position error at the start, east and north, m.
    #[serde(skip_serializing_if = "is_default")]
    pub start_position_m: [f64; 2],
}

/// Nothing stated: not written.
pub(super) fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// One number for each axis, or one for all.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
#[schemars(untagged)]
pub enum AxesFile {
    /// None.
    #[default]
    #[serde(skip)]
    Absent,
    /// The same for all.
    All(f64),
    /// Along the body's x (right), y (forward), z (up).
    Each([f64; 3]),
}

/// Installation errors by sensor and input, or one number for all six.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
#[schemars(untagged)]
pub enum InstallationFile {
    /// None.
    #[default]
    #[serde(skip)]
    Absent,
    /// The same for all.
    All(f64),
    /// By sensor and input.
    Each(InstallationAngles),
}

/// Acceleration-sensitive drift: a number for each gyro along its own axis, one for all three, or by gyro and specific force.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
#[schemars(untagged)]
pub enum DriftFile {
    /// None.
    #[default]
    #[serde(skip)]
    Absent,
    /// The same for all three gyros, each along its own axis.
    All(f64),
    /// x, y, z, each along its own axis.
    Own([f64; 3]),
    /// By gyro and axis of the specific force.
    Each(DriftCoefficients),
}

/// Drift of the first axis' gyro for each g along the second axis; x right, y forward, z up.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DriftCoefficients {
    /// Of the x gyro, for a specific force along x, deg/(h g).
    pub xx: f64,
    /// Of the x gyro, for a specific force along y, deg/(h g).
    pub xy: f64,
    /// Of the x gyro, for a specific force along z, deg/(h g).
    pub xz: f64,
    /// Of the y gyro, for a specific force along x, deg/(h g).
    pub yx: f64,
    /// Of the y gyro, for a specific force along y, deg/(h g).
    pub yy: f64,
    /// Of the y gyro, for a specific force along z, deg/(h g).
    pub yz: f64,
    /// Of the z gyro, for a specific force along x, deg/(h g).
    pub zx: f64,
    /// Of the z gyro, for a specific force along y, deg/(h g).
    pub zy: f64,
    /// Of the z gyro, for a specific force along z, deg/(h g).
    pub zz: f64,
}

impl DriftFile {
    fn each(self) -> DriftCoefficients {
        let diagonal = |[xx, yy, zz]: [f64; 3]| DriftCoefficients { xx, yy, zz, ..Default::default() };
        match self {
            DriftFile::Absent => DriftCoefficients::default(),
            DriftFile::All(value) => diagonal([value; 3]),
            DriftFile::Own(values) => diagonal(values),
            DriftFile::Each(values) => values,
        }
    }
}

impl DriftCoefficients {
    fn slot(&mut self, source: &ErrorSource) -> Option<&mut f64> {
        let DriftCoefficients { xx, xy, xz, yx, yy, yz, zx, zy, zz } = self;
        [xx, xy, xz, yx, yy, yz, zx, zy, zz].into_iter().nth(3 * source.axis + source.input)
    }
}

shaped!(
    DriftFile,
    "a number for all gyros, [x, y, z], or { \"xx\": ..., \"xz\": ... }",
    number: DriftFile::All,
    list: DriftFile::Own,
    object: DriftFile::Each
);

/// What of the second axis' input the first axis' sensor sees; x right, y forward, z up.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct InstallationAngles {
    /// Of the input along y in the x sensor, arcsec.
    pub xy: f64,
    /// Of the input along z in the x sensor, arcsec.
    pub xz: f64,
    /// Of the input along x in the y sensor, arcsec.
    pub yx: f64,
    /// Of the input along z in the y sensor, arcsec.
    pub yz: f64,
    /// Of the input along x in the z sensor, arcsec.
    pub zx: f64,
    /// Of the input along y in the z sensor, arcsec.
    pub zy: f64,
}

impl AxesFile {
    fn each(self) -> [f64; 3] {
        match self {
            AxesFile::Absent => [0.0; 3],
            AxesFile::All(value) => [value; 3],
            AxesFile::Each(values) => values,
        }
    }
}

impl InstallationFile {
    fn each(self) -> InstallationAngles {
        match self {
            InstallationFile::Absent => InstallationAngles::default(),
            InstallationFile::All(v) => InstallationAngles { xy: v, xz: v, yx: v, yz: v, zx: v, zy: v },
            InstallationFile::Each(angles) => angles,
        }
    }
}

impl InstallationAngles {
    fn slot(&mut self, source: &ErrorSource) -> Option<&mut f64> {
        let InstallationAngles { xy, xz, yx, yz, zx, zy } = self;
        // a sensor sees the inputs of the two other axes
        let other = source.input - usize::from(source.input > source.axis);
        [xy, xz, yx, yz, zx, zy].into_iter().nth(2 * source.axis + other)
    }
}

shaped!(AxesFile, "a number for all axes, or [x, y, z]", number: AxesFile::All, list: AxesFile::Each);

shaped!(
    InstallationFile,
    "a number for all six, or { \"xy\": ..., \"xz\": ... }",
    number: InstallationFile::All,
    object: InstallationFile::Each
);

impl ErrorsFile {
    /// The errors in SI units. Errors: a value that is not finite, a negative random walk, a ratio or angle that is no
    /// small one.
    pub fn errors(&self) -> Result<ImuErrors> {
        let (mut errors, mut read) = (ImuErrors::default(), self.clone());
        for source in ErrorSource::catalogue() {
            let (key, value) = read.changed(&source, 0.0);
            let (si, limit) = (value * source.si_per_unit(), source.limit());
            if !(si.abs() <= limit) {
                return Err(Malformed::new(
                    Fault::Value,
                    format!("{} is not an error of a navigator's unit", source.id()),
                )
                .at_path(key)
                .expected(format!("at most {:.4e} {}", limit / source.si_per_unit(), source.unit()))
                .found(format!("{value}")));
            }
            source.set(&mut errors, si);
        }
        let walks = [
            ("angle_random_walk_deg_sqrt_h", self.angle_random_walk_deg_sqrt_h),
            ("velocity_random_walk_m_s_sqrt_h", self.velocity_random_walk_m_s_sqrt_h),
        ];
        for (key, value) in walks {
            if !(0.0..=1e3).contains(&value) {
                return Err(Malformed::new(Fault::Value, "not a random walk")
                    .at_path(key)
                    .expected("0 to 1000")
                    .found(format!("{value}")));
            }
        }
        errors.gyro.random_walk = self.angle_random_walk_deg_sqrt_h.to_radians() / 60.0;
        errors.accelerometer.random_walk = self.velocity_random_walk_m_s_sqrt_h / 60.0;
        Ok(errors)
    }

    /// Change one source by a value in [`ErrorSource::unit`]; everything else stays as it was written.
    pub(crate) fn add(&mut self, source: &ErrorSource, change: f64) {
        self.changed(source, change);
    }

    /// The key of a source and its value, changed by so much.
    fn changed(&mut self, source: &ErrorSource, change: f64) -> (&'static str, f64) {
        let added = |value: &mut f64| {
            *value += change;
            *value
        };
        // a source has an axis of three
        let at = |values: &mut [f64]| values.get_mut(source.axis).map_or(f64::NAN, added);
        let axes = |file: &mut AxesFile| {
            let mut each = file.each();
            let value = at(&mut each);
            *file = AxesFile::Each(each);
            value
        };
        let installation = |file: &mut InstallationFile| {
            let mut each = file.each();
            let value = each.slot(source).map_or(f64::NAN, added);
            *file = InstallationFile::Each(each);
            value
        };
        let drift = |file: &mut DriftFile| {
            let mut each = file.each();
            let value = each.slot(source).map_or(f64::NAN, added);
            *file = DriftFile::Each(each);
            value
        };
        match (source.instrument, source.kind) {
            (Instrument::Gyro, Kind::Bias) => ("gyro_bias_deg_h", axes(&mut self.gyro_bias_deg_h)),
            (Instrument::Gyro, Kind::ScaleFactor) => ("gyro_scale_factor", axes(&mut self.gyro_scale_factor)),
            (Instrument::Gyro, Kind::Installation) => {
                ("gyro_installation_arcsec", installation(&mut self.gyro_installation_arcsec))
            }
            (Instrument::Gyro, Kind::SecondOrder) => {
                ("gyro_second_order_deg_h_per_deg2_s2", axes(&mut self.gyro_second_order_deg_h_per_deg2_s2))
            }
            (_, Kind::AccelerationSensitive) => {
                ("gyro_acceleration_sensitive_deg_h_per_g", drift(&mut self.gyro_acceleration_sensitive_deg_h_per_g))
            }
            (_, Kind::Bias) => ("accelerometer_bias_g", axes(&mut self.accelerometer_bias_g)),
            (_, Kind::ScaleFactor) => ("accelerometer_scale_factor", axes(&mut self.accelerometer_scale_factor)),
            (_, Kind::Installation) => {
                ("accelerometer_installation_arcsec", installation(&mut self.accelerometer_installation_arcsec))
            }
            (_, Kind::SecondOrder) => {
                ("accelerometer_second_order_g_per_g2", axes(&mut self.accelerometer_second_order_g_per_g2))
            }
            (_, Kind::Attitude) => ("start_attitude_arcsec", at(&mut self.start_attitude_arcsec)),
            (_, Kind::Velocity) => ("start_velocity_m_s", at(&mut self.start_velocity_m_s)),
            (_, Kind::Position) => ("start_position_m", at(&mut self.start_position_m)),
        }
    }
}
