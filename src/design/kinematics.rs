//! Rate and specific force at the sensor at one instant, and their exact derivatives with respect to every tilt.

use crate::algebra::Scratch;
use crate::bench::{Bench, Link, sin_cos_deg};
use nalgebra::Vector3;

/// Where each joint stands and how fast it turns at one instant.
#[derive(Debug, Clone, Default)]
pub struct Instant {
    /// Joint angles in degrees, in chain order.
    pub angle_deg: Vec<f64>,
    /// Joint rates in degrees per second, in chain order.
    pub rate_deg_s: Vec<f64>,
}

/// Inputs in the last frame of the chain, in the bench's units.
#[derive(Debug, Clone, Default)]
pub struct Kinematics {
    /// Angular rate with respect to inertial space.
    pub rate: Vector3<f64>,
    /// Specific force.
    pub force: Vector3<f64>,
    /// d rate / d tilt, for each tilt in chain order.
    pub rate_by_tilt: Vec<Vector3<f64>>,
    /// d force / d tilt, for each tilt in chain order.
    pub force_by_tilt: Vec<Vector3<f64>>,
    angles: Vec<f64>,
    scratch: Scratch,
}

/// Carry Earth rate, specific force and joint rates through the chain.
///
/// With `v0` the ground vector and `Rk` the k-th rotation about `uk`: `v_k = Rk^T v_{k-1} + q_k u_k` for the rate (`q_k` the rate of a turning
/// joint, invariant under its own rotation) and `v_k = Rk^T v_{k-1}` for the force; the derivative by tilt k starts as `-u_k x v_k` and is
/// carried by all later rotations. `tilts` are in radians, in chain order; missing joints or tilts count as zero. No small angles anywhere.
pub fn kinematics(bench: &Bench, tilts: &[f64], instant: &Instant, out: &mut Kinematics) {
    out.rate = bench.earth_rate();
    out.force = bench.specific_force();
    out.rate_by_tilt.clear();
    out.force_by_tilt.clear();
    let per_deg_s = bench.units.rate.per_deg_s();
    let mut joint = 0;
    for link in &bench.chain {
        match link {
            Link::Joint { about, .. } => {
                let turn = sin_cos_deg(instant.angle_deg.get(joint).copied().unwrap_or_default());
                let turning = instant.rate_deg_s.get(joint).copied().unwrap_or_default() * per_deg_s;
                joint += 1;
                out.rotate(*about, turn);
                out.rate += about.unit() * turning;
            }
            Link::Tilt { about, times, .. } => {
                let factor =
                    times.as_ref().map_or(1.0, |t| t.factor(&instant.angle_deg, &mut out.angles, &mut out.scratch));
                let tilt = factor * tilts.get(out.rate_by_tilt.len()).copied().unwrap_or_default();
                if tilt != 0.0 {
                    out.rotate(*about, tilt.sin_cos());
                }
                out.rate_by_tilt.push(about.derivative(&out.rate) * factor);
                out.force_by_tilt.push(about.derivative(&out.force) * factor);
            }
        }
    }
}

impl Kinematics {
    fn rotate(&mut self, about: crate::bench::Axis, turn: (f64, f64)) {
        self.rate = about.to_inner(&self.rate, turn);
        self.force = about.to_inner(&self.force, turn);
        for derivative in self.rate_by_tilt.iter_mut().chain(self.force_by_tilt.iter_mut()) {
            *derivative = about.to_inner(derivative, turn);
        }
    }
}
