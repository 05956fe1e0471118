//! Constants of the Earth, each with its source: the one table that benches, sites and the navigator use.
//!
//! | constant | value | source |
//! |---|---|---|
//! | semi-major axis | 6 378 137.0 m | NIMA TR8350.2 (WGS 84), 3rd ed., table 3.1 |
//! | flattening | 1/298.257 223 563 | the same |
//! | Earth rate | 7.292 115e-5 rad/s | the same; 15.041 067 deg/h is this, rounded to seven digits, as the papers of the benches write it |
//! | first eccentricity squared | 6.694 379 990 14e-3 | TR8350.2, table 3.3 |
//! | normal gravity on the equator | 9.780 325 335 9 m/s^2 | TR8350.2, table 3.4 |
//! | `k` of Somigliana's formula | 0.001 931 852 652 41 | the same |
//! | `m = w^2 a^2 b / GM` | 0.003 449 786 506 84 | the same |
//! | standard gravity | 9.806 65 m/s^2 | 3rd CGPM (1901); the unit `g` |

use super::rotation::sin_cos_deg;
pub use crate::units::STANDARD_GRAVITY_M_S2;

/// Semi-major axis of WGS 84, m.
pub(crate) const SEMI_MAJOR_AXIS_M: f64 = 6_378_137.0;
/// Flattening of WGS 84.
pub(crate) const FLATTENING: f64 = 1.0 / 298.257_223_563;
/// First eccentricity squared of WGS 84.
pub(crate) const ECCENTRICITY_SQUARED: f64 = 6.694_379_990_14e-3;
/// Earth rate of WGS 84, rad/s.
pub(crate) const EARTH_RATE_RAD_S: f64 = 7.292_115e-5;
/// The same in degrees per hour, rounded to seven digits.
pub(crate) const EARTH_RATE_DEG_H: f64 = 15.041067;
/// Normal gravity on the equator, m/s^2.
pub(crate) const EQUATORIAL_GRAVITY_M_S2: f64 = 9.780_325_335_9;
/// `k` of Somigliana's formula.
pub(crate) const SOMIGLIANA: f64 = 0.001_931_852_652_41;
/// Centrifugal force over gravity on the equator, `m = w^2 a^2 b / GM`.
pub(crate) const CENTRIFUGAL_RATIO: f64 = 0.003_449_786_506_84;

/// Normal gravity, m/s^2, from the squared sine of the geodetic latitude and the altitude above the ellipsoid: Somigliana's formula with the
/// free-air reduction to second order (TR8350.2, equations 4-1 and 4-3).
pub(crate) fn gravity_at(sine_squared: f64, altitude_m: f64) -> f64 {
    let on_ellipsoid = EQUATORIAL_GRAVITY_M_S2 * (1.0 + SOMIGLIANA * sine_squared)
        / (1.0 - ECCENTRICITY_SQUARED * sine_squared).sqrt();
    let ratio = altitude_m / SEMI_MAJOR_AXIS_M;
    let reduction = 1.0 + FLATTENING + CENTRIFUGAL_RATIO - 2.0 * FLATTENING * sine_squared;
    on_ellipsoid * (1.0 - 2.0 * ratio * reduction + 3.0 * ratio * ratio)
}

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
pub(crate) const NORMAL_GRAVITY_U_M_S2: f64 = 5e-4;

/// The formula of [`normal_gravity`], as outputs name it.
pub(crate) const NORMAL_GRAVITY_FORMULA: &str =
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
