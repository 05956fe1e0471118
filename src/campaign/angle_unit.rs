//! Units in which a person may give an angle.

/// A unit of plane angle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AngleUnit {
    /// Radian.
    Radian,
    /// Milliradian.
    Milliradian,
    /// Microradian.
    Microradian,
    /// Degree.
    Degree,
    /// Arcminute.
    Arcminute,
    /// Arcsecond.
    Arcsecond,
}

impl AngleUnit {
    /// The unit that a file names, if it names one of angle.
    pub fn named(symbol: &str) -> Option<Self> {
        Some(match symbol {
            "rad" => AngleUnit::Radian,
            "mrad" => AngleUnit::Milliradian,
            "urad" => AngleUnit::Microradian,
            "deg" => AngleUnit::Degree,
            "arcmin" => AngleUnit::Arcminute,
            "arcsec" => AngleUnit::Arcsecond,
            _ => return None,
        })
    }

    /// One of this unit, in radians.
    ///
    /// ```
    /// let arcsec = tumble::campaign::AngleUnit::Arcsecond.radians();
    /// assert!((arcsec * 206264.80624709636 - 1.0).abs() < 1e-15);
    /// ```
    pub fn radians(self) -> f64 {
        let degree = std::f64::consts::PI / 180.0;
        match self {
            AngleUnit::Radian => 1.0,
            AngleUnit::Milliradian => 1e-3,
            AngleUnit::Microradian => 1e-6,
            AngleUnit::Degree => degree,
            AngleUnit::Arcminute => degree / 60.0,
            AngleUnit::Arcsecond => degree / 3600.0,
        }
    }

    /// The names that a file may use.
    pub const NAMES: &'static str = "rad, mrad, urad, deg, arcmin, arcsec";
}
