//! Four instants of a reading, or one of four devices with tilts of their own, side by side: rate and specific force at the sensor, and their
//! derivatives by the tilts.
//!
//! The operations of `kinematics.rs` on four numbers each; a joint that stands, and a tilt that follows none, has one angle for all four.
#![allow(
    clippy::indexing_slicing,
    reason = "lanes have four numbers and vectors three; axes and instants are enumerated over these lengths"
)]

use super::Instant;
use super::kinematics::{Ground, shown};
use crate::algebra::{Lane, Scratch};
use crate::bench::{Axis, Bench, Link, sin_cos_deg};
use crate::elements::Elements;

/// Components of four vectors.
pub(super) type Vectors = [Lane; 3];

/// Inputs in the last frame of the chain at four instants, in the bench's units; as [`super::Kinematics`] has them at one.
#[derive(Debug, Clone, Default)]
pub(super) struct FourInstants {
    pub rate: Vectors,
    pub force: Vectors,
    pub rate_by_tilt: Vec<Vectors>,
    pub force_by_tilt: Vec<Vectors>,
    ground: Ground,
    turns: Vec<Turn>,
    angles: Vec<Lane>,
    scratch: Scratch,
}

/// One rotation of the chain as it was last.
#[derive(Debug, Clone, Copy)]
struct Turn {
    /// Degrees for a joint, radians for a tilt.
    angle: Lane,
    in_degrees: bool,
    sin: Lane,
    cos: Lane,
}

impl Turn {
    const NONE: Turn = Turn { angle: [0.0; 4], in_degrees: true, sin: [0.0; 4], cos: [1.0; 4] };

    #[inline(always)]
    fn to(&mut self, angle: Lane, in_degrees: bool) {
        if angle == self.angle && in_degrees == self.in_degrees {
            return;
        }
        (self.angle, self.in_degrees) = (angle, in_degrees);
        for l in 0..angle.len() {
            // most angles are the same for all four
            (self.sin[l], self.cos[l]) = match l.checked_sub(1) {
                Some(before) if angle[before] == angle[l] => (self.sin[before], self.cos[before]),
                _ if in_degrees => sin_cos_deg(angle[l]),
                _ => angle[l].sin_cos(),
            };
        }
    }

    #[inline(always)]
    fn turns(&self) -> bool {
        self.angle != [0.0; 4]
    }
}

#[inline(always)]
fn of(part: impl Fn(usize) -> f64) -> Lane {
    std::array::from_fn(part)
}

/// `Rot(axis, t)^T v`, see [`Axis::to_inner`].
#[inline(always)]
fn to_inner(axis: Axis, v: &mut Vectors, Turn { sin, cos, .. }: &Turn) {
    let [x, y, z] = *v;
    let (first, second) = match axis {
        Axis::X => (1, 2),
        Axis::Y => (2, 0),
        Axis::Z => (0, 1),
    };
    let (a, b) = match axis {
        Axis::X => (y, z),
        Axis::Y => (z, x),
        Axis::Z => (x, y),
    };
    v[first] = of(|l| cos[l] * a[l] + sin[l] * b[l]);
    v[second] = of(|l| cos[l] * b[l] - sin[l] * a[l]);
}

#[inline(always)]
fn turn_both(axis: Axis, turn: &Turn, vectors: [Option<&mut Vectors>; 2]) {
    vectors.into_iter().flatten().for_each(|v| to_inner(axis, v, turn));
}

/// `-unit x v`, see [`Axis::derivative`], times a factor.
#[inline(always)]
fn derivative(axis: Axis, [x, y, z]: &Vectors, factor: &Lane) -> Vectors {
    let zero = [0.0; 4];
    let plus = |a: &Lane| of(|l| a[l] * factor[l]);
    let minus = |a: &Lane| of(|l| -a[l] * factor[l]);
    match axis {
        Axis::X => [zero, plus(z), minus(y)],
        Axis::Y => [minus(z), zero, plus(x)],
        Axis::Z => [plus(y), minus(x), zero],
    }
}

/// `S v` for a `v` that has no component along the axis; `later` are the columns of `S`.
#[inline(always)]
fn carried([x, y, z]: &[Vectors; 3], axis: Axis, v: &mut Vectors) {
    let sum = |p: &Vectors, a: Lane, q: &Vectors, b: Lane| -> Vectors {
        std::array::from_fn(|i| of(|l| p[i][l] * a[l] + q[i][l] * b[l]))
    };
    let [a, b, c] = *v;
    *v = match axis {
        Axis::X => sum(y, b, z, c),
        Axis::Y => sum(x, a, z, c),
        Axis::Z => sum(x, a, y, b),
    };
}

/// `S <- S R^T`, by columns.
#[inline(always)]
fn turn_back(later: &mut [Vectors; 3], axis: Axis, Turn { sin, cos, .. }: &Turn) {
    let [x, y, z] = *later;
    let less = |p: &Vectors, q: &Vectors| std::array::from_fn(|i| of(|l| p[i][l] * cos[l] - q[i][l] * sin[l]));
    let more = |p: &Vectors, q: &Vectors| std::array::from_fn(|i| of(|l| p[i][l] * sin[l] + q[i][l] * cos[l]));
    *later = match axis {
        Axis::X => [x, less(&y, &z), more(&y, &z)],
        Axis::Y => [std::array::from_fn(|i| of(|l| x[i][l] * cos[l] + z[i][l] * sin[l])), y, less(&z, &x)],
        Axis::Z => [less(&x, &y), more(&x, &y), z],
    };
}

impl FourInstants {
    /// Carry Earth rate, specific force and joint rates through the chain: everything stands as in `base` but for a joint that passes four angles
    /// (none where there is no such joint).
    /// What is not wanted of rate and force is left as it is.
    #[inline(always)]
    pub(super) fn set(
        &mut self,
        bench: &Bench,
        tilts: &[Lane],
        base: &Instant,
        (joint, stops): (usize, Lane),
        [wants_rate, wants_force]: [bool; 2],
    ) {
        let FourInstants { rate, force, rate_by_tilt, force_by_tilt, ground, turns, angles, scratch } = self;
        [*rate, *force] = ground.of(bench).map(|v| [[v.x; 4], [v.y; 4], [v.z; 4]]);
        rate_by_tilt.clear();
        force_by_tilt.clear();
        turns.resize(bench.chain.len(), Turn::NONE);
        let at = |k: usize, angle: f64| if k == joint { stops } else { [angle; 4] };
        let modulated = bench.chain.iter().any(|link| matches!(link, Link::Tilt { times: Some(_), .. }));
        angles.clear();
        if modulated {
            let radians = |(k, angle): (usize, &f64)| at(k, *angle).map(|angle| shown(angle).to_radians());
            angles.extend(base.angle_deg.iter().enumerate().map(radians));
        }
        let per_deg_s = bench.units.rate.per_deg_s();
        let mut k = 0;
        for (link, turn) in bench.chain.iter().zip(turns.iter_mut()) {
            match link {
                Link::Joint { about, .. } => {
                    turn.to(at(k, base.angle_deg.at(k)), true);
                    let turning = base.rate_deg_s.at(k) * per_deg_s;
                    k += 1;
                    if turn.turns() {
                        turn_both(*about, turn, [wants_rate.then_some(&mut *rate), wants_force.then_some(&mut *force)]);
                    }
                    if turning != 0.0 {
                        rate[*about as usize].iter_mut().for_each(|q| *q += turning);
                    }
                }
                Link::Tilt { about, times, .. } => {
                    let factor = match times {
                        None => [1.0; 4],
                        Some(times) => {
                            let mut here = Vec::with_capacity(angles.len());
                            std::array::from_fn(|l| {
                                here.clear();
                                here.extend(angles.iter().map(|own| own[l]));
                                times.factor(&here, scratch)
                            })
                        }
                    };
                    // what the caller leaves out is zero
                    let tilt = tilts.get(rate_by_tilt.len()).copied().unwrap_or_default();
                    turn.to(of(|l| factor[l] * tilt[l]), false);
                    if turn.turns() {
                        turn_both(*about, turn, [wants_rate.then_some(&mut *rate), wants_force.then_some(&mut *force)]);
                    }
                    let zero = [[0.0; 4]; 3];
                    rate_by_tilt.push(if wants_rate { derivative(*about, rate, &factor) } else { zero });
                    force_by_tilt.push(if wants_force { derivative(*about, force, &factor) } else { zero });
                }
            }
        }
        // from the sensor back to the ground: later rotations carry the derivatives to the sensor
        let (zero, one) = ([0.0; 4], [1.0; 4]);
        let mut later = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
        let mut derivatives = rate_by_tilt.iter_mut().zip(force_by_tilt.iter_mut()).rev();
        for (link, turn) in bench.chain.iter().zip(turns.iter()).rev() {
            let (Link::Joint { about, .. } | Link::Tilt { about, .. }) = link;
            if let Link::Tilt { .. } = link
                && let Some((rate, force)) = derivatives.next()
            {
                if wants_rate {
                    carried(&later, *about, rate);
                }
                if wants_force {
                    carried(&later, *about, force);
                }
            }
            if turn.turns() {
                turn_back(&mut later, *about, turn);
            }
        }
    }
}
