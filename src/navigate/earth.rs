//! The rotating ellipsoid: WGS-84 radii of curvature, normal gravity and rates of the local-level frame.
//!
//! East-north-up frame everywhere, angles in rad, lengths in m.

/// Semi-major axis of WGS-84, m.
pub const SEMI_MAJOR_AXIS: f64 = 6_378_137.0;
/// First eccentricity squared of WGS-84.
pub const ECCENTRICITY_SQUARED: f64 = 6.694_379_990_14e-3;
/// Earth rate of WGS-84, rad/s.
pub const EARTH_RATE: f64 = 7.292_115e-5;
/// Flattening of WGS-84.
pub const FLATTENING: f64 = 1.0 / 298.257_223_563;

/// The unit in which accelerometer errors and specific forces are given (standard gravity), m/s^2.
pub const STANDARD_GRAVITY: f64 = 9.806_65;

/// Radii that turn a velocity at a latitude and an altitude into rates of latitude and longitude.
///
/// `R_M = a (1 - e^2) / (1 - e^2 sin^2 L)^(3/2)`, `R_N = a / (1 - e^2 sin^2 L)^(1/2)` (Groves, *Principles of GNSS,
/// Inertial, and Multisensor Integrated Navigation Systems*, 2nd ed., eq. 2.105 and 2.106), both plus the altitude.
///
/// ```
/// let equator = tumble::navigate::earth::Curvature::at(0.0, 0.0);
/// assert!((equator.meridian - 6_335_439.327).abs() < 1e-3);
/// assert!((equator.prime_vertical - 6_378_137.0).abs() < 1e-9);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Curvature {
    /// `R_M + h`: metres of northing for a radian of latitude.
    pub meridian: f64,
    /// `R_N + h`: metres of easting, over `cos L`, for a radian of longitude.
    pub prime_vertical: f64,
}

impl Curvature {
    /// The radii at a latitude (rad) and an altitude above the ellipsoid (m).
    pub fn at(latitude: f64, altitude: f64) -> Self {
        let sine = latitude.sin();
        let w2 = 1.0 - ECCENTRICITY_SQUARED * sine * sine;
        let prime_vertical = SEMI_MAJOR_AXIS / w2.sqrt();
        let meridian = prime_vertical * (1.0 - ECCENTRICITY_SQUARED) / w2;
        Curvature { meridian: meridian + altitude, prime_vertical: prime_vertical + altitude }
    }
}

/// Normal gravity, m/s^2, at a latitude (rad) and an altitude (m): Somigliana's formula with the second-order
/// free-air reduction (Groves eq. 2.134 and 2.139).
///
/// ```
/// use tumble::navigate::earth::normal_gravity;
/// assert!((normal_gravity(0.0, 0.0) - 9.780_325_335_9).abs() < 1e-10);
/// assert!((normal_gravity(90_f64.to_radians(), 0.0) - 9.832_184_9).abs() < 1e-6);
/// ```
pub fn normal_gravity(latitude: f64, altitude: f64) -> f64 {
    let s2 = latitude.sin().powi(2);
    let ground = 9.780_325_335_9 * (1.0 + 0.001_931_852_652_41 * s2) / (1.0 - ECCENTRICITY_SQUARED * s2).sqrt();
    let a = SEMI_MAJOR_AXIS;
    let semi_minor = a * (1.0 - FLATTENING);
    let m = EARTH_RATE * EARTH_RATE * a * a * semi_minor / 3.986_004_418e14;
    ground
        * (1.0 - 2.0 / a * (1.0 + FLATTENING * (1.0 - 2.0 * s2) + m) * altitude + 3.0 * altitude * altitude / (a * a))
}

/// Earth rate in the local-level frame, `[0, W cos L, W sin L]`, rad/s.
pub fn earth_rate(latitude: f64) -> [f64; 3] {
    let (sine, cosine) = latitude.sin_cos();
    [0.0, EARTH_RATE * cosine, EARTH_RATE * sine]
}

/// Transport rate of the local-level frame, `[-vN/(R_M+h), vE/(R_N+h), vE tan L/(R_N+h)]`, rad/s (Groves eq. 5.44,
/// turned to east-north-up).
pub fn transport_rate(latitude: f64, altitude: f64, velocity: [f64; 2]) -> [f64; 3] {
    let radii = Curvature::at(latitude, altitude);
    let [east, north] = velocity;
    [-north / radii.meridian, east / radii.prime_vertical, east * latitude.tan() / radii.prime_vertical]
}
