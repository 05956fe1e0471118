//! Where a mission starts.

/// Where a mission starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Site {
    /// Geodetic latitude, rad.
    pub latitude_rad: f64,
    /// Longitude, rad.
    pub longitude_rad: f64,
    /// Altitude above the ellipsoid, m; the vertical channel is held there.
    pub altitude_m: f64,
}
