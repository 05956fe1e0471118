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

    /// `Rot(axis, t)^T v`: components of `v` in the frame after an active rotation by `t`, given sine and cosine of `t`.
    ///
    /// `Rot(x,t) = [[1,0,0],[0,cos t,-sin t],[0,sin t,cos t]]`, and cyclically.
    ///
    /// ```
    /// use tumble::bench::Axis;
    /// use nalgebra::Vector3;
    /// // a sensor turned +90 deg about z sees ground north (y) along its own x
    /// assert_eq!(Axis::Z.to_inner(&Vector3::y(), (1.0, 0.0)), Vector3::x());
    /// ```
    pub fn to_inner(self, v: &Vector3<f64>, (sin, cos): (f64, f64)) -> Vector3<f64> {
        match self {
            Axis::X => Vector3::new(v.x, cos * v.y + sin * v.z, cos * v.z - sin * v.y),
            Axis::Y => Vector3::new(cos * v.x - sin * v.z, v.y, cos * v.z + sin * v.x),
            Axis::Z => Vector3::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z),
        }
    }

    /// `d/dt Rot(axis, t)^T v = -unit x (Rot(axis, t)^T v)`, given the already rotated `inner = Rot^T v`.
    pub fn derivative(self, inner: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Axis::X => Vector3::new(0.0, inner.z, -inner.y),
            Axis::Y => Vector3::new(-inner.z, 0.0, inner.x),
            Axis::Z => Vector3::new(inner.y, -inner.x, 0.0),
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
