//! The site in a bench or campaign file: latitude, Earth rate, gravity, and how well they are known.

use crate::bench::{EARTH_RATE_DEG_H, GravityFrom, NORMAL_GRAVITY_U_M_S2, STANDARD_GRAVITY_M_S2, Site, normal_gravity};
use crate::error::{Fault, Malformed, Result};
use crate::units::Unit;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The site of the bench. Keys of a campaign's site replace those of the bench's.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SiteFile {
    /// Geodetic latitude in degrees, north positive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub latitude_deg: Option<f64>,
    /// Standard uncertainty of the latitude, in degrees; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub latitude_u_deg: Option<f64>,
    /// Earth rate in degrees per hour; 15.041067 unless given. 0 switches the Earth-rate correction off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub earth_rate_deg_h: Option<f64>,
    /// Local gravity in units of standard gravity; see also `gravity`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gravity_g: Option<f64>,
    /// Local gravity with its unit and standard uncertainty.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity: Option<GravityFile>,
    /// Altitude above the ellipsoid in metres: gravity is then normal gravity at this latitude and altitude (WGS 84), u = 5e-4 m/s^2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub altitude_m: Option<f64>,
}

/// Local gravity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GravityFile {
    /// Value, in `unit`.
    pub value: f64,
    /// Unit, for example `m/s^2`, `mGal`, `g`.
    pub unit: String,
    /// Standard uncertainty, in `unit`; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u: Option<f64>,
}

impl SiteFile {
    /// The file of a site.
    pub(super) fn of(site: &Site) -> Self {
        let mut file = SiteFile {
            latitude_deg: Some(site.latitude_deg),
            latitude_u_deg: (site.latitude_u_deg > 0.0).then_some(site.latitude_u_deg),
            earth_rate_deg_h: Some(site.earth_rate_deg_h),
            ..SiteFile::default()
        };
        match site.gravity_from {
            GravityFrom::Assumed => {}
            GravityFrom::Normal { altitude_m } => file.altitude_m = Some(altitude_m),
            GravityFrom::Stated if site.gravity_u_g == 0.0 => file.gravity_g = Some(site.gravity_g),
            GravityFrom::Stated => {
                let u = Some(site.gravity_u_g);
                file.gravity = Some(GravityFile { value: site.gravity_g, unit: "g".into(), u });
            }
        }
        file
    }

    /// This site, with what it does not say taken from another.
    pub(super) fn over(self, other: Option<&Site>) -> Self {
        let Some(other) = other.map(SiteFile::of) else { return self };
        let says_gravity = self.gravity.is_some() || self.gravity_g.is_some() || self.altitude_m.is_some();
        let other =
            if says_gravity { SiteFile { gravity: None, gravity_g: None, altitude_m: None, ..other } } else { other };
        SiteFile {
            latitude_deg: self.latitude_deg.or(other.latitude_deg),
            latitude_u_deg: self.latitude_u_deg.or(other.latitude_u_deg),
            earth_rate_deg_h: self.earth_rate_deg_h.or(other.earth_rate_deg_h),
            gravity_g: self.gravity_g.or(other.gravity_g),
            gravity: self.gravity.or(other.gravity),
            altitude_m: self.altitude_m.or(other.altitude_m),
        }
    }

    pub(super) fn into_site(self) -> Result<Site> {
        let earth_rate_deg_h = match (self.latitude_deg, self.earth_rate_deg_h) {
            (None, None) => 0.0,
            (None, Some(rate)) if rate != 0.0 => {
                return Err(Malformed::new(Fault::Missing, "an Earth rate needs a latitude")
                    .expected("latitude_deg with earth_rate_deg_h")
                    .at_path("site"));
            }
            (_, Some(rate)) => rate,
            (Some(_), None) => EARTH_RATE_DEG_H,
        };
        let latitude_u_deg = self.latitude_u_deg.unwrap_or(0.0);
        let checked = |key: &str, value: f64| {
            if value >= 0.0 && value.is_finite() {
                return Ok(());
            }
            Err(Malformed::new(Fault::Value, format!("{key} cannot be used"))
                .expected("zero or a positive number")
                .found(value.to_string())
                .at_path(format!("site.{key}")))
        };
        checked("earth_rate_deg_h", earth_rate_deg_h)?;
        // on Earth, where it is 0.996 to 1.003 g, with room for a rounded value and none for another unit; or left out of the model
        let of_earth = |path: &str, gravity_g: f64| {
            if gravity_g == 0.0 || (0.9..=1.1).contains(&gravity_g) {
                return Ok(gravity_g);
            }
            Err(Malformed::new(Fault::Value, "the gravity is that of no laboratory")
                .expected("0.9 to 1.1 g (9.8 m/s^2), or 0")
                .found(format!("{gravity_g} g"))
                .at_path(path))
        };
        checked("latitude_u_deg", latitude_u_deg)?;
        let latitude_deg = self.latitude_deg.unwrap_or(0.0);
        let (gravity_g, gravity_u_g, gravity_from) = match (self.gravity_g, &self.gravity, self.altitude_m) {
            (None, None, None) => (1.0, 0.0, GravityFrom::Assumed),
            (Some(gravity_g), None, None) => {
                checked("gravity_g", gravity_g)?;
                (of_earth("site.gravity_g", gravity_g)?, 0.0, GravityFrom::Stated)
            }
            (None, Some(gravity), None) => {
                let at = |key: &'static str| move |error: Malformed| error.at_path(format!("site.gravity.{key}"));
                let unit = Unit::parse(&gravity.unit).map_err(at("unit"))?;
                let to = unit.conversion_for(&Unit::parse("g")?, "gravity").map_err(at("unit"))?;
                let u = gravity.u.unwrap_or(0.0);
                checked("gravity.value", gravity.value)?;
                checked("gravity.u", u)?;
                (of_earth("site.gravity.value", to.apply(gravity.value))?, to.apply(u), GravityFrom::Stated)
            }
            (None, None, Some(altitude_m)) => {
                if self.latitude_deg.is_none() {
                    return Err(Malformed::new(Fault::Missing, "normal gravity needs a latitude")
                        .expected("latitude_deg with altitude_m")
                        .at_path("site"));
                }
                if !(-12e3..=100e3).contains(&altitude_m) {
                    return Err(Malformed::new(Fault::Value, "the altitude is that of no laboratory")
                        .expected("-12000 to 100000 m")
                        .found(altitude_m.to_string())
                        .at_path("site.altitude_m"));
                }
                let gravity = normal_gravity(latitude_deg, altitude_m) / STANDARD_GRAVITY_M_S2;
                (gravity, NORMAL_GRAVITY_U_M_S2 / STANDARD_GRAVITY_M_S2, GravityFrom::Normal { altitude_m })
            }
            _ => {
                return Err(Malformed::new(Fault::Value, "gravity is said more than once")
                    .expected("one of gravity, gravity_g and altitude_m")
                    .at_path("site"));
            }
        };
        Ok(Site { latitude_deg, latitude_u_deg, earth_rate_deg_h, gravity_g, gravity_u_g, gravity_from })
    }
}
