//! Rate and specific force at the sensor, and their exact derivatives with respect to every tilt and, where asked for, joint: at one instant, at several
//! instants of a reading side by side, or at one of several devices with tilts of their own.
#![allow(
    clippy::indexing_slicing,
    reason = "lanes have `L` numbers and vectors three; axes, places and instants are enumerated over these lengths"
)]

use crate::algebra::{Lane, Scratch, lanes};
use crate::bench::{Axis, Bench, Link, Site, Units, sin_cos_deg};
use crate::elements::Elements;
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
    instants: Instants<1>,
}

impl Kinematics {
    /// The inputs alone, without derivatives.
    pub(crate) fn inputs(&self) -> Kinematics {
        Kinematics { rate: self.rate, force: self.force, ..Kinematics::default() }
    }
}

/// Carry Earth rate, specific force and joint rates through the chain.
///
/// With `v0` the ground vector and `Rk` the k-th rotation about `uk`: `v_k = Rk^T v_{k-1} + q_k u_k` for the rate (`q_k` the rate of a turning
/// joint, invariant under its own rotation) and `v_k = Rk^T v_{k-1}` for the force; the derivative by rotation k is `S_k (-u_k x v_k)`, where
/// `S_k = Rn^T ... R(k+1)^T` are all later rotations, multiplied up from the sensor back to the ground. `tilts` are in radians, in chain
/// order; missing joints or tilts count as zero. No small angles anywhere.
pub fn kinematics(bench: &Bench, tilts: &[f64], instant: &Instant, out: &mut Kinematics) {
    let wanted = Wanted { fields: [true; 2], joints: out.wants_joints };
    let (angle, rate) = (|k| [instant.angle_deg.at(k)], |k| [instant.rate_deg_s.at(k)]);
    out.instants.set(bench, tilts.as_chunks::<1>().0, (instant.angle_deg.len(), angle, rate), wanted);
    let one = |v: &Vectors<1>| Vector3::new(v[0][0], v[1][0], v[2][0]);
    let [rate, force] = &out.instants.fields;
    (out.rate, out.force) = (one(&rate.at), one(&force.at));
    for (to, from) in [
        (&mut out.rate_by_tilt, &rate.by_tilt),
        (&mut out.force_by_tilt, &force.by_tilt),
        (&mut out.rate_by_joint, &rate.by_joint),
        (&mut out.force_by_joint, &force.by_joint),
    ] {
        to.clear();
        to.extend(from.iter().map(one));
    }
}

/// Components of vectors at `L` places.
pub(super) type Vectors<const L: usize> = [Lane<L>; 3];

/// What is asked for; what is not wanted of rate and force is left as it is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted {
    /// The rate, and the force.
    pub fields: [bool; 2],
    /// Derivatives by the joints' angles.
    pub joints: bool,
}

/// Rate or force at `L` places.
#[derive(Debug, Clone)]
pub(super) struct Field<const L: usize> {
    pub at: Vectors<L>,
    pub by_tilt: Vec<Vectors<L>>,
    pub by_joint: Vec<Vectors<L>>,
}

/// [`Kinematics`] at `L` places.
#[derive(Debug, Clone)]
pub(super) struct Instants<const L: usize> {
    /// The rate, and the force.
    pub fields: [Field<L>; 2],
    ground: Ground,
    turns: Vec<Turn<L>>,
    angles: Vec<Lane<L>>,
    scratch: Scratch,
}

/// Earth rate and specific force at a site, worked out once.
#[derive(Debug, Clone, Default)]
struct Ground(Option<(Option<Site>, Units, [Vector3<f64>; 2])>);

impl Ground {
    fn of(&mut self, bench: &Bench) -> [Vector3<f64>; 2] {
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

/// One rotation of the chain as it was last: most stay where they are from one instant to the next.
#[derive(Debug, Clone, Copy)]
struct Turn<const L: usize> {
    /// Degrees for a joint, radians for a tilt.
    angle: Lane<L>,
    in_degrees: bool,
    sin: Lane<L>,
    cos: Lane<L>,
    /// A joint's own rate, in the bench's unit.
    rate: Lane<L>,
    /// A tilt's factor, where it follows joints.
    factor: Lane<L>,
}

impl<const L: usize> Turn<L> {
    const NONE: Self =
        Turn { angle: [0.0; L], in_degrees: true, sin: [0.0; L], cos: [1.0; L], rate: [0.0; L], factor: [1.0; L] };

    #[inline(always)]
    fn to(&mut self, angle: Lane<L>, in_degrees: bool) {
        if angle == self.angle && in_degrees == self.in_degrees {
            return;
        }
        (self.angle, self.in_degrees) = (angle, in_degrees);
        for l in 0..L {
            // most angles are the same at all places
            (self.sin[l], self.cos[l]) = match l.checked_sub(1) {
                Some(before) if angle[before] == angle[l] => (self.sin[before], self.cos[before]),
                _ if in_degrees => sin_cos_deg(angle[l]),
                _ => angle[l].sin_cos(),
            };
        }
    }

    #[inline(always)]
    fn turns(&self) -> bool {
        self.angle != [0.0; L]
    }

    /// `v <- Rot(axis, t)^T v`: components in the frame after an active rotation by `t`, `Rot(x,t) = [[1,0,0],[0,cos t,-sin t],[0,sin t,cos t]]`, and cyclically.
    #[inline(always)]
    fn apply(&self, axis: Axis, v: &mut Vectors<L>) {
        if !self.turns() {
            return;
        }
        let (first, second) = plane(axis);
        for (l, (cos, sin)) in self.cos.iter().zip(&self.sin).enumerate() {
            let (a, b) = (v[first][l], v[second][l]);
            v[first][l] = cos * a + sin * b;
            v[second][l] = cos * b - sin * a;
        }
    }
}

/// Each component of a vector.
#[inline(always)]
fn each<const L: usize>(part: impl Fn(usize, usize) -> f64) -> Vectors<L> {
    [lanes(|l| part(0, l)), lanes(|l| part(1, l)), lanes(|l| part(2, l))]
}

/// The other two axes, in the sense of the rotation.
#[inline(always)]
fn plane(axis: Axis) -> (usize, usize) {
    match axis {
        Axis::X => (1, 2),
        Axis::Y => (2, 0),
        Axis::Z => (0, 1),
    }
}

/// `d/dt Rot(axis, t)^T v = -unit x v` of the already rotated `v`.
#[inline(always)]
fn derivative<const L: usize>(axis: Axis, [x, y, z]: &Vectors<L>) -> Vectors<L> {
    let zero = [0.0; L];
    let minus = |a: &Lane<L>| lanes(|l| -a[l]);
    match axis {
        Axis::X => [zero, *z, minus(y)],
        Axis::Y => [minus(z), zero, *x],
        Axis::Z => [*y, minus(x), zero],
    }
}

/// All rotations later than some place of the chain, by columns: they carry what is found there to the sensor.
struct Later<const L: usize>([Vectors<L>; 3]);

impl<const L: usize> Later<L> {
    fn none() -> Self {
        let (zero, one) = ([0.0; L], [1.0; L]);
        Later([[one, zero, zero], [zero, one, zero], [zero, zero, one]])
    }

    /// `S v` for a `v` that has no component along the axis.
    #[inline(always)]
    fn carry(&self, axis: Axis, v: &mut Vectors<L>) {
        let Later([x, y, z]) = self;
        let sum = |p: &Vectors<L>, a: Lane<L>, q: &Vectors<L>, b: Lane<L>| each(|i, l| p[i][l] * a[l] + q[i][l] * b[l]);
        let [a, b, c] = *v;
        *v = match axis {
            Axis::X => sum(y, b, z, c),
            Axis::Y => sum(x, a, z, c),
            Axis::Z => sum(x, a, y, b),
        };
    }

    /// `S <- S R^T`.
    #[inline(always)]
    fn turn(&mut self, axis: Axis, turn: &Turn<L>) {
        if !turn.turns() {
            return;
        }
        let Turn { sin, cos, .. } = turn;
        let (first, second) = plane(axis);
        for i in 0..3 {
            for l in 0..L {
                let (a, b) = (self.0[first][i][l], self.0[second][i][l]);
                self.0[first][i][l] = a * cos[l] - b * sin[l];
                self.0[second][i][l] = a * sin[l] + b * cos[l];
            }
        }
    }
}

impl<const L: usize> Default for Instants<L> {
    fn default() -> Self {
        let none = || Field { at: [[0.0; L]; 3], by_tilt: Vec::new(), by_joint: Vec::new() };
        Instants {
            fields: [none(), none()],
            ground: Ground::default(),
            turns: Vec::new(),
            angles: Vec::new(),
            scratch: Scratch::default(),
        }
    }
}

impl<const L: usize> Instants<L> {
    /// As [`kinematics`] says, of so many joints with these angles and rates.
    #[inline(always)]
    pub(super) fn set(
        &mut self,
        bench: &Bench,
        tilts: &[Lane<L>],
        (joints, angle_deg, rate_deg_s): (usize, impl Fn(usize) -> Lane<L>, impl Fn(usize) -> Lane<L>),
        wanted: Wanted,
    ) {
        let Instants { fields, ground, turns, angles, scratch } = self;
        for (field, v) in fields.iter_mut().zip(ground.of(bench)) {
            field.at = [[v.x; L], [v.y; L], [v.z; L]];
            field.by_tilt.clear();
            field.by_joint.clear();
        }
        turns.resize(bench.chain.len(), Turn::NONE);
        angles.clear();
        // only tilts that follow joints ask what the encoders show
        if bench.chain.iter().any(|link| matches!(link, Link::Tilt { times: Some(_), .. })) {
            angles.extend((0..joints).map(|k| lanes(|l| shown(angle_deg(k)[l]).to_radians())));
        }
        let per_deg_s = bench.units.rate.per_deg_s();
        let (mut k, mut tilt) = (0, 0);
        // from the ground to the sensor: the vectors, and what a tilt or a joint does to them in its own frame
        for (link, turn) in bench.chain.iter().zip(turns.iter_mut()) {
            let (Link::Joint { about, .. } | Link::Tilt { about, .. }) = link;
            match link {
                Link::Joint { .. } => {
                    turn.to(angle_deg(k), true);
                    turn.rate = rate_deg_s(k).map(|rate| rate * per_deg_s);
                    k += 1;
                }
                Link::Tilt { times, .. } => {
                    turn.factor = match times {
                        Some(times) => factors(angles, |here| times.factor(here, scratch)),
                        None => [1.0; L],
                    };
                    // what the caller leaves out is zero
                    let size = tilts.get(tilt).copied().unwrap_or([0.0; L]);
                    turn.to(lanes(|l| turn.factor[l] * size[l]), false);
                    turn.rate = [0.0; L];
                    tilt += 1;
                }
            }
            for ((field, wanted_here), own) in fields.iter_mut().zip(wanted.fields).zip([turn.rate, [0.0; L]]) {
                if wanted_here {
                    turn.apply(*about, &mut field.at);
                }
                if own != [0.0; L] {
                    field.at[*about as usize].iter_mut().zip(own).for_each(|(q, own)| *q += own);
                }
                let by = match link {
                    Link::Tilt { .. } => &mut field.by_tilt,
                    Link::Joint { .. } if wanted.joints => &mut field.by_joint,
                    Link::Joint { .. } => continue,
                };
                by.push(if wanted_here { derivative(*about, &field.at) } else { [[0.0; L]; 3] });
            }
        }
        // from the sensor back to the ground: later rotations carry the derivatives to the sensor
        let mut later = Later::none();
        for (link, turn) in bench.chain.iter().zip(turns.iter()).rev() {
            let (Link::Joint { about, .. } | Link::Tilt { about, .. }) = link;
            match link {
                Link::Joint { .. } => k -= 1,
                Link::Tilt { .. } => tilt -= 1,
            }
            for (field, _) in fields.iter_mut().zip(wanted.fields).filter(|(_, wanted)| *wanted) {
                let slope = match link {
                    Link::Joint { .. } => field.by_joint.get_mut(k),
                    Link::Tilt { .. } => field.by_tilt.get_mut(tilt),
                };
                slope.into_iter().for_each(|slope| later.carry(*about, slope));
            }
            later.turn(*about, turn);
        }
        // a tilt that follows joints is turned by them, too
        let tilting = bench.chain.iter().zip(turns.iter()).filter_map(|(link, turn)| match link {
            Link::Tilt { times, .. } => Some((times.as_ref(), turn.factor)),
            Link::Joint { .. } => None,
        });
        for (k, (times, factor)) in tilting.enumerate() {
            let Some(times) = times else { continue };
            let size = tilts.get(k).copied().unwrap_or([0.0; L]);
            for Field { by_tilt, by_joint, .. } in fields.iter_mut() {
                let Some(parts) = by_tilt.get_mut(k) else { continue };
                for (j, by) in by_joint.iter_mut().enumerate().filter(|_| size != [0.0; L]) {
                    let slope = factors(angles, |here| times.slopes(here, scratch).at(j));
                    (0..3).for_each(|i| (0..L).for_each(|l| by[i][l] += size[l] * slope[l] * parts[i][l]));
                }
                parts.iter_mut().for_each(|part| *part = lanes(|l| part[l] * factor[l]));
            }
        }
    }
}

/// What a tilt's factor is at every place, from the joints' angles there.
fn factors<const L: usize>(angles: &[Lane<L>], mut of: impl FnMut(&[f64]) -> f64) -> Lane<L> {
    let mut here = Vec::with_capacity(angles.len());
    std::array::from_fn(|l| {
        here.clear();
        here.extend(angles.iter().map(|lanes| lanes[l]));
        of(&here)
    })
}

/// What the encoder of a joint shows, degrees: from 0 to below 360.
fn shown(angle_deg: f64) -> f64 {
    let shown = angle_deg.rem_euclid(360.0);
    // a hair below zero is rounded up to a whole turn
    if shown < 360.0 { shown } else { 0.0 }
}
