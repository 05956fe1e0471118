//! Rate and specific force at the sensor at one instant, and their exact derivatives with respect to every tilt and, where asked for, joint.

use crate::algebra::Scratch;
use crate::bench::{Axis, Bench, Link, Site, Units, sin_cos_deg};
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
    /// Are derivatives by the joints' angles wanted too?
    pub wants_joints: bool,
    /// d rate / d angle (rad) of each joint in chain order; empty where not wanted.
    pub rate_by_joint: Vec<Vector3<f64>>,
    /// d force / d angle (rad) of each joint in chain order; empty where not wanted.
    pub force_by_joint: Vec<Vector3<f64>>,
    ground: Ground,
    turns: Vec<Turn>,
    angles: Vec<f64>,
    scratch: Scratch,
}

/// Earth rate and specific force at a site, worked out once.
#[derive(Debug, Clone, Default)]
pub(super) struct Ground(Option<(Option<Site>, Units, [Vector3<f64>; 2])>);

impl Ground {
    pub(super) fn of(&mut self, bench: &Bench) -> [Vector3<f64>; 2] {
        match &self.0 {
            Some((site, units, vectors)) if *site == bench.site && *units == bench.units => *vectors,
            _ => {
                let vectors = [bench.earth_rate(), bench.specific_force()];
                self.0 = Some((bench.site, bench.units, vectors));
                vectors
            }
        }
    }
}

impl Kinematics {
    /// The inputs alone, without derivatives.
    pub fn inputs(&self) -> Kinematics {
        Kinematics { rate: self.rate, force: self.force, ..Kinematics::default() }
    }
}

/// One rotation of the chain as it was last: most stay where they are from one instant to the next.
#[derive(Debug, Clone, Copy)]
struct Turn {
    /// Degrees for a joint, radians for a tilt.
    angle: f64,
    in_degrees: bool,
    sin_cos: (f64, f64),
    /// The factor of a tilt.
    factor: f64,
    /// A joint's own rate, in the bench's unit.
    rate: f64,
}

impl Turn {
    const NONE: Turn = Turn { angle: 0.0, in_degrees: true, sin_cos: (0.0, 1.0), factor: 1.0, rate: 0.0 };

    fn to(&mut self, angle: f64, in_degrees: bool) {
        if angle != self.angle || in_degrees != self.in_degrees {
            let sin_cos = if in_degrees { sin_cos_deg(angle) } else { angle.sin_cos() };
            *self = Turn { angle, in_degrees, sin_cos, ..*self };
        }
    }
}

/// Carry Earth rate, specific force and joint rates through the chain.
///
/// With `v0` the ground vector and `Rk` the k-th rotation about `uk`: `v_k = Rk^T v_{k-1} + q_k u_k` for the rate (`q_k` the rate of a turning
/// joint, invariant under its own rotation) and `v_k = Rk^T v_{k-1}` for the force; the derivative by tilt k is `S_k (-u_k x v_k)`, where
/// `S_k = Rn^T ... R(k+1)^T` are all later rotations, multiplied up from the sensor back to the ground. `tilts` are in radians, in chain
/// order; missing joints or tilts count as zero. No small angles anywhere.
pub fn kinematics(bench: &Bench, tilts: &[f64], instant: &Instant, out: &mut Kinematics) {
    let Kinematics { rate, force, rate_by_tilt, force_by_tilt, ground, turns, angles, scratch, wants_joints, .. } = out;
    [*rate, *force] = ground.of(bench);
    rate_by_tilt.clear();
    force_by_tilt.clear();
    turns.resize(bench.chain.len(), Turn::NONE);
    angles.clear();
    // only tilts that follow joints, and derivatives by these, ask what the encoders show
    if *wants_joints || bench.chain.iter().any(|link| matches!(link, Link::Tilt { times: Some(_), .. })) {
        angles.extend(instant.angle_deg.iter().map(|angle| shown(*angle).to_radians()));
    }
    let per_deg_s = bench.units.rate.per_deg_s();
    let mut joint = 0;
    // from the ground to the sensor: the vectors, and what a tilt does to them in its own frame
    for (link, turn) in bench.chain.iter().zip(turns.iter_mut()) {
        match link {
            // what the caller leaves out is zero, as said above
            Link::Joint { about, .. } => {
                turn.to(instant.angle_deg.get(joint).copied().unwrap_or_default(), true);
                let turning = instant.rate_deg_s.get(joint).copied().unwrap_or_default() * per_deg_s;
                joint += 1;
                turn.rate = turning;
                *rate = about.to_inner(rate, turn.sin_cos);
                *force = about.to_inner(force, turn.sin_cos);
                if turning != 0.0 {
                    *rate += about.unit() * turning;
                }
            }
            Link::Tilt { about, times, .. } => {
                turn.factor = times.as_ref().map_or(1.0, |times| times.factor(angles, scratch));
                turn.to(turn.factor * tilts.get(rate_by_tilt.len()).copied().unwrap_or_default(), false);
                if turn.angle != 0.0 {
                    *rate = about.to_inner(rate, turn.sin_cos);
                    *force = about.to_inner(force, turn.sin_cos);
                }
                rate_by_tilt.push(about.derivative(rate) * turn.factor);
                force_by_tilt.push(about.derivative(force) * turn.factor);
            }
        }
    }
    if out.wants_joints {
        by_joints(bench, tilts, out);
    }
    let Kinematics { rate_by_tilt, force_by_tilt, turns, .. } = out;
    // from the sensor back to the ground: later rotations carry the derivatives to the sensor
    let mut later = [Vector3::x(), Vector3::y(), Vector3::z()];
    let mut derivatives = rate_by_tilt.iter_mut().zip(force_by_tilt.iter_mut()).rev();
    for (link, turn) in bench.chain.iter().zip(turns.iter()).rev() {
        let (Link::Joint { about, .. } | Link::Tilt { about, .. }) = link;
        if let Link::Tilt { .. } = link
            && let Some((rate, force)) = derivatives.next()
        {
            *rate = carried(&later, *about, rate);
            *force = carried(&later, *about, force);
        }
        if turn.angle != 0.0 {
            turn_back(&mut later, *about, turn.sin_cos);
        }
    }
}

/// Derivatives by the joints' angles, once `turns` are those of this instant: a joint turns what comes to it, and through the factors of
/// tilts also what comes to those.
fn by_joints(bench: &Bench, tilts: &[f64], out: &mut Kinematics) {
    let Kinematics { rate, force, rate_by_joint, force_by_joint, turns, angles, scratch, .. } = out;
    for list in [&mut *rate_by_joint, &mut *force_by_joint] {
        list.clear();
        list.resize(angles.len(), Vector3::zeros());
    }
    // in the sensor's frame a rotation about `axis` at some place of the chain changes v by -(S axis) x v_there, carried by S; and the
    // rotations' own rates that enter later are not turned: so from the sensor back, undoing what each link has done
    let (mut rate, mut force) = (*rate, *force);
    let mut later = [Vector3::x(), Vector3::y(), Vector3::z()];
    let (mut joint, mut tilt) = (angles.len(), tilts.len());
    for (link, turn) in bench.chain.iter().zip(turns.iter()).rev() {
        let (Link::Joint { about, .. } | Link::Tilt { about, .. }) = link;
        let [x, y, z] = &later;
        let to_sensor = |v: &Vector3<f64>| x * v.x + y * v.y + z * v.z;
        let turned = |v: &Vector3<f64>| to_sensor(&about.derivative(v));
        match link {
            Link::Joint { .. } => {
                joint = joint.saturating_sub(1);
                if let (Some(by_rate), Some(by_force)) = (rate_by_joint.get_mut(joint), force_by_joint.get_mut(joint)) {
                    *by_rate += turned(&rate);
                    *by_force += turned(&force);
                }
            }
            Link::Tilt { times, .. } => {
                tilt = tilt.saturating_sub(1);
                let size = tilts.get(tilt).copied().unwrap_or_default();
                if let Some(times) = times.as_ref().filter(|_| size != 0.0) {
                    let slopes = times.slopes(angles, scratch);
                    for ((slope, by_rate), by_force) in
                        slopes.iter().zip(rate_by_joint.iter_mut()).zip(force_by_joint.iter_mut())
                    {
                        *by_rate += turned(&rate) * (size * slope);
                        *by_force += turned(&force) * (size * slope);
                    }
                }
            }
        }
        // back into the frame before this link
        let (sin, cos) = turn.sin_cos;
        if turn.angle != 0.0 {
            rate = about.to_inner(&rate, (-sin, cos));
            force = about.to_inner(&force, (-sin, cos));
            turn_back(&mut later, *about, turn.sin_cos);
        }
        rate -= about.unit() * turn.rate;
    }
}

/// What the encoder of a joint shows, degrees: from 0 to below 360.
pub(super) fn shown(angle_deg: f64) -> f64 {
    let shown = angle_deg.rem_euclid(360.0);
    // a hair below zero is rounded up to a whole turn
    if shown < 360.0 { shown } else { 0.0 }
}

/// `S v` for a `v` that has no component along the axis.
fn carried(later: &[Vector3<f64>; 3], about: Axis, v: &Vector3<f64>) -> Vector3<f64> {
    let [x, y, z] = later;
    match about {
        Axis::X => y * v.y + z * v.z,
        Axis::Y => x * v.x + z * v.z,
        Axis::Z => x * v.x + y * v.y,
    }
}

/// `S <- S R^T`, by columns.
fn turn_back(later: &mut [Vector3<f64>; 3], about: Axis, (sin, cos): (f64, f64)) {
    let [x, y, z] = *later;
    *later = match about {
        Axis::X => [x, y * cos - z * sin, y * sin + z * cos],
        Axis::Y => [x * cos + z * sin, y, z * cos - x * sin],
        Axis::Z => [x * cos - y * sin, x * sin + y * cos, z],
    };
}
