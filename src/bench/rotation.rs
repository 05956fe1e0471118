//! Rotations about the coordinate axes, exact at multiples of 90 degrees.

use crate::number;
use crate::vocabulary::vocabulary;
use nalgebra::Vector3;

vocabulary! {
    /// A coordinate axis.
    #[schemars(rename = "AxisFile")]
    Axis {
        /// First axis.
        X = "x",
        /// Second axis.
        Y = "y",
        /// Third axis.
        Z = "z",
    }
}

impl Axis {
    /// The unit vector along this axis.
    pub fn unit(self) -> Vector3<f64> {
        match self {
            Axis::X => Vector3::x(),
            Axis::Y => Vector3::y(),
            Axis::Z => Vector3::z(),
        }
    }
}

/// Sine and cosine of an angle in degrees, exact at every multiple of 90 degrees.
///
/// The angle is first reduced to within 45 degrees of a quarter turn, which is exact in binary floating point; so `cos 90` is 0, not 6e-17,
/// and a column of the design matrix that vanishes in algebra vanishes in the computer.
///
/// ```
/// assert_eq!(tumble::bench::sin_cos_deg(270.0), (-1.0, 0.0));
/// ```
pub fn sin_cos_deg(angle_deg: f64) -> (f64, f64) {
    let turn = angle_deg % 360.0;
    let quarter = (turn / 90.0).round();
    let (sin, cos) = (turn - 90.0 * quarter).to_radians().sin_cos();
    match number::whole_i64(quarter) {
        -3 | 1 => (cos, -sin),
        -2 | 2 => (-sin, -cos),
        -1 | 3 => (-cos, sin),
        _ => (sin, cos),
    }
}
