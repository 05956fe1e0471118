//! The angle of a point whose coordinates are uncertain, with an interval that holds near the origin too.
//!
//! Of `atan2(y, x)` the first order says `u^2 = (x^2 u_y^2 + y^2 u_x^2 - 2 x y u_xy)/(x^2 + y^2)^2`, which grows without bound where both
//! coordinates are near zero. The directions that the coordinates do not contradict are those in which a ray from the origin meets their
//! ellipse of coverage: `(n . m)^2 <= k^2 n' S n` with `n` square to the ray (Fieller's theorem), `m` the point, `S` its covariance.
//! Where the origin lies inside the joint ellipse, `m' S^-1 m <= 2 F(level; 2, nu)`, they are the whole circle.
//!
//! Deliberately absent: covariances of more than two quantities.

use crate::uncertainty::quantiles;
use std::f64::consts::{FRAC_PI_2, PI};

/// The directions that coordinates and their covariance allow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sector {
    /// All of them: nothing is known of the angle.
    Circle,
    /// From the first to the second angle, in radians, counter-clockwise; the angle of the point lies between.
    Between(f64, f64),
}

/// The sector of `atan2(y, x)` for the point `(x, y)` with `covariance = [u_x^2, u_xy, u_y^2]` of so many degrees of freedom.
///
/// `None` for a level outside (0, 1) or numbers that are not finite.
///
/// ```
/// use tumble::fit::{Sector, sector};
/// let round = |u: f64| [u * u, 0.0, u * u];
/// // far from the origin: value and k u, here asin(1.96 u/r)
/// let Some(Sector::Between(low, high)) = sector((3.0, 4.0), round(0.1), f64::INFINITY, 0.95) else { panic!() };
/// assert!((0.5 * (low + high) - 4f64.atan2(3.0)).abs() < 1e-12 && (high - low - 2.0 * (0.1959964_f64 / 5.0).asin()).abs() < 1e-8);
/// assert_eq!(sector((0.1, 0.1), round(0.1), f64::INFINITY, 0.95), Some(Sector::Circle));
/// ```
pub fn sector((x, y): (f64, f64), covariance: [f64; 3], dof: f64, level: f64) -> Option<Sector> {
    let [xx, xy, yy] = covariance;
    if ![x, y, xx, xy, yy].iter().all(|v| v.is_finite()) {
        return None;
    }
    let single = quantiles::coverage_factor(level, dof)?.powi(2);
    let joint = match dof.is_finite() {
        true => 2.0 * quantiles::fisher_f_quantile(level, 2.0, dof)?,
        false => quantiles::chi_square_quantile(level, 2.0)?,
    };
    // n'(m m' - k^2 S) n = a + b cos 2t + c sin 2t for n = (-sin t, cos t)
    let form = |square: f64| {
        let (mxx, mxy, myy) = (x * x - square * xx, x * y - square * xy, y * y - square * yy);
        (0.5 * (mxx + myy), 0.5 * (myy - mxx), -mxy)
    };
    let (a, b, c) = form(joint);
    if a <= -b.hypot(c) {
        return Some(Sector::Circle);
    }
    let (a, b, c) = form(single);
    let (size, value) = (b.hypot(c), y.atan2(x));
    if size == 0.0 {
        return Some(Sector::Circle);
    }
    // the form is negative within half of `acos(a/size)` about its least value
    let half = 0.5 * (a / size).clamp(-1.0, 1.0).acos();
    let centre = 0.5 * c.atan2(b) + FRAC_PI_2;
    // of the two opposite sectors, the one of the point
    let turns = ((value - centre) / PI).round();
    let centre = centre + turns * PI;
    Some(Sector::Between(centre - half, centre + half))
}
