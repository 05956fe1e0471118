//! The rotating ellipsoid: WGS-84 radii of curvature, normal gravity and rates of the local-level frame.
//!
//! East-north-up frame everywhere, angles in rad, lengths in m. The constants are those of [`crate::bench::earth`].

pub(crate) use crate::bench::earth::{
    EARTH_RATE_RAD_S as EARTH_RATE, ECCENTRICITY_SQUARED, SEMI_MAJOR_AXIS_M as SEMI_MAJOR_AXIS,
    STANDARD_GRAVITY_M_S2 as STANDARD_GRAVITY,
};

/// Radii that turn a velocity at a latitude and an altitude into rates of latitude and longitude.
///
/// `R_M = a (1 - e^2) / (1 - e^2 sin^2 L)^(3/2)`, `R_N = a / (1 - e^2 sin^2 L)^(1/2)` (Groves, *Principles of GNSS,
/// Inertial, and Multisensor Integrated Navigation Systems*, 2nd ed., eq. 2.105 and 2.106), both plus the altitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Curvature {
    /// `R_M + h`: metres of northing for a radian of latitude.
    pub meridian: f64,
    /// `R_N + h`: metres of easting, over `cos L`, for a radian of longitude.
    pub prime_vertical: f64,
}

impl Curvature {
    /// The radii at a latitude (rad) and an altitude above the ellipsoid (m).
    pub fn at(latitude_rad: f64, altitude_m: f64) -> Self {
        let sine = latitude_rad.sin();
        let w2 = 1.0 - ECCENTRICITY_SQUARED * sine * sine;
        let prime_vertical = SEMI_MAJOR_AXIS / w2.sqrt();
        let meridian = prime_vertical * (1.0 - ECCENTRICITY_SQUARED) / w2;
        Curvature { meridian: meridian + altitude_m, prime_vertical: prime_vertical + altitude_m }
    }
}

/// Normal gravity, m/s^2, at a latitude (rad) and an altitude (m): Somigliana's formula with the second-order
/// free-air reduction (Groves eq. 2.134 and 2.139).
pub fn normal_gravity(latitude_rad: f64, altitude_m: f64) -> f64 {
    crate::bench::earth::gravity_at(latitude_rad.sin().powi(2), altitude_m)
}

/// Earth rate in the local-level frame, `[0, W cos L, W sin L]`, rad/s.
pub fn earth_rate(latitude_rad: f64) -> [f64; 3] {
    let (sine, cosine) = latitude_rad.sin_cos();
    [0.0, EARTH_RATE * cosine, EARTH_RATE * sine]
}

/// Transport rate of the local-level frame, `[-vN/(R_M+h), vE/(R_N+h), vE tan L/(R_N+h)]`, rad/s (Groves eq. 5.44,
/// turned to east-north-up).
pub fn transport_rate(latitude_rad: f64, altitude_m: f64, velocity: [f64; 2]) -> [f64; 3] {
    let radii = Curvature::at(latitude_rad, altitude_m);
    let [east, north] = velocity;
    [-north / radii.meridian, east / radii.prime_vertical, east * latitude_rad.tan() / radii.prime_vertical]
}
