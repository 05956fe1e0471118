//! Local gravity: where it comes from, and normal gravity where only latitude and altitude are known.

use super::earth::gravity_at;
use super::rotation::sin_cos_deg;

/// Where the gravity of a site comes from.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum GravityFrom {
    /// Nothing was said: standard gravity.
    #[default]
    Assumed,
    /// It was given.
    Stated,
    /// Normal gravity at the site's latitude and this altitude above the ellipsoid, in metres.
    Normal {
        /// Altitude above the ellipsoid.
        altitude_m: f64,
    },
}

/// Standard uncertainty of normal gravity as a value of local gravity, m/s^2: 50 mGal, about the root mean square of free-air anomalies on
/// land; mountains and deep basins are worse.
pub const NORMAL_GRAVITY_U_M_S2: f64 = 5e-4;

/// The formula of [`normal_gravity`], as outputs name it.
pub const NORMAL_GRAVITY_FORMULA: &str =
    "normal gravity, WGS 84: Somigliana's formula, free-air reduction to second order";

/// Normal gravity of the WGS 84 ellipsoid, in m/s^2, at a geodetic latitude and an altitude above the ellipsoid.
///
/// `gamma = gamma_e (1 + k sin^2) / sqrt(1 - e^2 sin^2)`, `times 1 - 2 h/a (1 + f + m - 2 f sin^2) + 3 h^2/a^2`
/// (NIMA TR8350.2, equations 4-1 and 4-3).
///
/// ```
/// // TR8350.2, table 3.4: 9.7803253359 on the equator, 9.8321849378 at the poles
/// assert!((tumble::bench::normal_gravity(0.0, 0.0) - 9.7803253359).abs() < 1e-10);
/// assert!((tumble::bench::normal_gravity(90.0, 0.0) - 9.8321849378).abs() < 1e-9);
/// ```
pub fn normal_gravity(latitude_deg: f64, altitude_m: f64) -> f64 {
    let (sine, _) = sin_cos_deg(latitude_deg);
    gravity_at(sine * sine, altitude_m)
}
