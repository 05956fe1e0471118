//! The strapdown mechanisation: what a navigator makes of increments, two samples of the unit at a time, in all lanes of a
//! register.
//!
//! Local-level, east-north-up, on the ellipsoid; the vertical channel is held (no vertical velocity, the altitude of
//! the site). With `a`, `v` the increments of angle and velocity of one step `h` as the unit reports them:
//!
//! 1. *Coning and sculling* together, over pairs of samples (the two-sample algorithm, one sample of the pair before,
//!    `a0`, added), as one Magnus step of the rigid motion `(omega, f)`:
//!
//!    ```text
//!    p   = 7/10 a1 - 1/30 a0,   b = a2 - a1                  (likewise pv, bv)
//!    phi = a1 + a2 + p x b
//!    u   = v1 + v2 + p x bv + pv x b
//!    dv  = u + (1 - cos phi)/phi^2 phi x u + (phi - sin phi)/phi^3 phi x (phi x u)
//!    ```
//!
//!    `p x b` is `2/3 a1 x a2 + 1/30 (a2 - a1) x (a0 - a1)`: Miller's two-sample term, right to fourth order for any
//!    smooth rate, and a term of fifth order that makes its drift in pure coning of frequency `w` wrong by `(w h)^6`
//!    only. With `H = 2 h` the time of a pair:
//! 2. *Velocity* `v' = v + C dv - zeta/2 x C dv - H (2 w_ie + w_en) x v_mid`, with `v_mid` at the middle of the pair.
//! 3. *Position* by `H v_mid` over the radii of curvature.
//! 4. *Attitude* `q' = (1, -zeta/2) q (cos phi/2, sin(phi/2) phi/phi)`, `zeta = H (w_ie + w_en)` at the middle.
//!
//! In attitude it is of fourth order in the step for a smooth motion (the Magnus step's third commutators are the first
//! neglected term); terms that depend on the position are linear over a block, and exact at its start.
#![allow(
    clippy::indexing_slicing,
    reason = "a chunk has `CHUNK` steps at most (`steps` is the smaller of that and what remains), errors and state have fixed columns, steps of a block are taken modulo its length"
)]

use super::earth::{EARTH_RATE, ECCENTRICITY_SQUARED, SEMI_MAJOR_AXIS};
use super::quadrature::MAX_STEPS;
use super::trajectory::Block;
use super::vector::{Real, Triple};
use pulp::Simd;

/// Numbers that a navigator keeps: quaternion 4, velocity 2, latitude and longitude, sine and cosine of latitude,
/// velocity with half of the last step's Coriolis terms 2.
pub(crate) const STATES: usize = 12;
/// Numbers of the errors of a unit: bias, matrix and square of two triads, acceleration-sensitive drift of the gyros.
pub const ERRORS: usize = 39;

/// What is common to all lanes and steps.
#[derive(Debug, Clone, Copy)]
pub struct Setting {
    /// Step, s.
    pub step: f64,
    /// Altitude, m.
    pub altitude_m: f64,
}

/// A triad's errors, scaled to increments: bias times step, `1 + K`, square over step.
#[derive(Clone, Copy)]
struct Triad<S: Simd> {
    bias: Triple<S>,
    rows: [Triple<S>; 3],
    square: Triple<S>,
}

impl<S: Simd> Triad<S> {
    #[inline(always)]
    fn load(simd: S, columns: &[[f64; 8]], from: usize) -> Self {
        let at = |i: usize| triple(simd, columns, i, from);
        Triad { bias: at(0), rows: [at(3), at(6), at(9)], square: at(12) }
    }

    /// What the sensors report of true increments.
    #[inline(always)]
    fn measure(&self, t: Triple<S>) -> Triple<S> {
        let [x, y, z] = self.rows;
        let axis = |row: Triple<S>, bias: Real<S>, square: Real<S>, input: Real<S>| {
            let squared = (square * input).times_plus(input, bias);
            row.x.times_plus(t.x, row.y.times_plus(t.y, row.z.times_plus(t.z, squared)))
        };
        Triple {
            x: axis(x, self.bias.x, self.square.x, t.x),
            y: axis(y, self.bias.y, self.square.y, t.y),
            z: axis(z, self.bias.z, self.square.z, t.z),
        }
    }
}

#[inline(always)]
fn triple<S: Simd>(simd: S, columns: &[[f64; 8]], i: usize, from: usize) -> Triple<S> {
    let at = |i: usize| Real::<S>::load(simd, &columns[i], from);
    Triple { x: at(i), y: at(i + 1), z: at(i + 2) }
}

#[inline(always)]
fn keep<S: Simd>(value: Triple<S>, columns: &mut [[f64; 8]], i: usize, from: usize) {
    value.x.store(&mut columns[i], from);
    value.y.store(&mut columns[i + 1], from);
    value.z.store(&mut columns[i + 2], from);
}

/// Steps whose increments are made in one go before the navigator takes them; an even number.
pub const CHUNK: usize = 16;
/// Increments of each pair of steps in all lanes: velocity 3, vector part of the turn 3, its scalar part.
pub type Track = [[[f64; 8]; 7]; CHUNK / 2];

/// A group's memory: the errors of its units, its navigators' states, and room for increments.
#[derive(Debug, Clone)]
pub struct Memory {
    /// Scaled errors of the units.
    pub errors: [[f64; 8]; ERRORS],
    /// The navigators.
    pub state: [[f64; 8]; STATES],
    /// What the units report: one past step, then the steps of a chunk.
    pub reported: [[[f64; 8]; 6]; CHUNK + 1],
    /// Increments from the units to the navigators.
    pub track: Track,
}

/// Fly one block with one register of a group's eight lanes.
///
/// Increments of a chunk of steps first, which do not depend on each other, then the steps of each navigator, which do. `noise` holds, for each step and lane, six increments of
/// noise; it is empty where there is none.
#[inline(always)]
pub fn fly<S: Simd>(
    simd: S,
    setting: Setting,
    block: &Block,
    memory: &mut Memory,
    noise: &[[[f64; 8]; 6]],
    register: usize,
) {
    let Memory { errors, state, reported, track } = memory;
    let mut navigator = Navigator::<S>::load(simd, setting, state, register);
    let mut done = 0;
    while done < block.steps {
        let steps = CHUNK.min(block.steps - done);
        let noise = noise.get(done..).unwrap_or(&[]); // a quiet unit has none
        measure::<S>(simd, block, done, errors, noise, register, &mut reported[1..1 + steps]);
        let pairs = steps / 2;
        for (pair, slot) in track[..pairs].iter_mut().enumerate() {
            if let Some(three) = reported[2 * pair..].first_chunk::<3>() {
                compensate::<S>(simd, three, register, slot);
            }
        }
        for increment in &track[..pairs] {
            navigator.step(simd, increment, register);
        }
        let last = reported[steps];
        for (slot, value) in reported[0].iter_mut().zip(&last) {
            Real::<S>::load(simd, value, register).store(slot, register);
        }
        done += steps;
    }
    navigator.store(simd, state, register);
}

/// What the units report in a chunk of steps.
#[inline(always)]
fn measure<S: Simd>(
    simd: S,
    block: &Block,
    done: usize,
    errors: &[[f64; 8]; ERRORS],
    noise: &[[[f64; 8]; 6]],
    lane: usize,
    reported: &mut [[[f64; 8]; 6]],
) {
    let gyro = Triad::<S>::load(simd, &errors[..15], lane);
    let accelerometer = Triad::<S>::load(simd, &errors[15..30], lane);
    let drifts = errors[30..].iter().flatten().any(|value| *value != 0.0);
    let drift = [30, 33, 36].map(|i| triple::<S>(simd, errors, i, lane));
    let columns: &[[f64; MAX_STEPS]; 6] = &block.increments;
    for (i, slot) in reported.iter_mut().enumerate() {
        let seen = |axis: usize| Real::<S>::splat(simd, columns[axis][(done + i) % MAX_STEPS]);
        let force = Triple { x: seen(3), y: seen(4), z: seen(5) };
        let mut turn = gyro.measure(Triple { x: seen(0), y: seen(1), z: seen(2) });
        if drifts {
            let along = |row: Triple<S>, rate: Real<S>| {
                row.x.times_plus(force.x, row.y.times_plus(force.y, row.z.times_plus(force.z, rate)))
            };
            turn = Triple { x: along(drift[0], turn.x), y: along(drift[1], turn.y), z: along(drift[2], turn.z) };
        }
        keep(turn, slot, 0, lane);
        keep(accelerometer.measure(force), slot, 3, lane);
    }
    for (slot, noise) in reported.iter_mut().zip(noise) {
        for (value, noise) in slot.iter_mut().zip(noise) {
            (Real::<S>::load(simd, value, lane) + Real::<S>::load(simd, noise, lane)).store(value, lane);
        }
    }
}

/// Coning and sculling: the body's turn and velocity increment in a pair of steps, from its increments and a past one.
#[inline(always)]
fn compensate<S: Simd>(simd: S, reported: &[[[f64; 8]; 6]; 3], lane: usize, slot: &mut [[f64; 8]; 7]) {
    let number = |value: f64| Real::<S>::splat(simd, value);
    let [past, first, second] = reported;
    let (a0, v0) = (triple(simd, past, 0, lane), triple(simd, past, 3, lane));
    let (a1, v1) = (triple(simd, first, 0, lane), triple(simd, first, 3, lane));
    let (a2, v2) = (triple(simd, second, 0, lane), triple(simd, second, 3, lane));
    let (c0, c1) = (number(-1.0 / 30.0), number(0.7));
    let (p, b) = (a1.scaled_plus(c1, a0.scaled(c0)), a2.minus(a1));
    let (pv, bv) = (v1.scaled_plus(c1, v0.scaled(c0)), v2.minus(v1));
    let phi = p.cross_plus(b, a1.plus(a2));
    let u = pv.cross_plus(b, p.cross_plus(bv, v1.plus(v2)));

    let half = number(0.5);
    let square = phi.dot(phi);
    let first = square.times_plus(number(-1.0 / 24.0), half);
    let second = square.times_plus(number(-1.0 / 120.0), number(1.0 / 6.0));
    let turned = phi.cross(u);
    let sine = square.times_plus(square.times_plus(number(1.0 / 3840.0), number(-1.0 / 48.0)), half);
    let cosine = square.times_plus(square.times_plus(number(1.0 / 384.0), number(-0.125)), number(1.0));
    keep(phi.cross(turned).scaled_plus(second, turned.scaled_plus(first, u)), slot, 0, lane);
    keep(phi.scaled(sine), slot, 3, lane);
    cosine.store(&mut slot[6], lane);
}

/// A value that depends on the latitude: at the block's start, and its slope.
#[derive(Clone, Copy)]
struct Slope<S: Simd>(Real<S>, Real<S>);

impl<S: Simd> Slope<S> {
    #[inline(always)]
    fn at(self, latitude_rad: Real<S>) -> Real<S> {
        self.1.times_plus(latitude_rad, self.0)
    }
}

/// One register of navigators during a block; angles of the Earth times the step.
#[derive(Clone, Copy)]
struct Navigator<S: Simd> {
    w: Real<S>,
    q: Triple<S>,
    east: Real<S>,
    north: Real<S>,
    /// The same, and half of the last step's Coriolis and frame terms.
    east_ahead: Real<S>,
    north_ahead: Real<S>,
    sine: Real<S>,
    cosine: Real<S>,
    /// Since the block's start.
    latitude_rad: Real<S>,
    longitude_rad: Real<S>,
    /// `h/(R_M + h)`, `h/(R_N + h)`, and the latter times the latitude's tangent and secant.
    meridian: Slope<S>,
    prime: Slope<S>,
    tangent: Slope<S>,
    secant: Slope<S>,
    /// Earth rate times the step, north and up.
    level: Slope<S>,
    vertical: Slope<S>,
}

impl<S: Simd> Navigator<S> {
    #[inline(always)]
    fn load(simd: S, setting: Setting, state: &[[f64; 8]; STATES], from: usize) -> Self {
        let number = |value: f64| Real::<S>::splat(simd, value);
        let at = |i: usize| Real::<S>::load(simd, &state[i], from);
        let (sine, cosine) = (at(8), at(9));
        let (one, h) = (number(1.0), number(2.0 * setting.step));
        let altitude_m = number(setting.altitude_m);
        let e2 = number(ECCENTRICITY_SQUARED);
        let root = (sine * sine).times_from(e2, one).reciprocal_root();
        let prime = number(SEMI_MAJOR_AXIS) * root;
        let meridian = prime * root * root * number(1.0 - ECCENTRICITY_SQUARED);
        // dR_N/dL = R_N e2 s c / w2, dR_M/dL = 3 R_M e2 s c / w2
        let bend = e2 * sine * cosine * root * root;
        let secant = cosine.reciprocal();
        let tangent = sine * secant;
        let m = (meridian + altitude_m).reciprocal();
        let n = (prime + altitude_m).reciprocal();
        let dn = -(prime * bend * n * n);
        let rate = h * number(EARTH_RATE);
        let (level, vertical) = (rate * cosine, rate * sine);
        Navigator {
            w: at(0),
            q: triple(simd, &state[..], 1, from),
            east: at(4),
            north: at(5),
            east_ahead: at(10),
            north_ahead: at(11),
            sine,
            cosine,
            latitude_rad: number(0.0),
            longitude_rad: number(0.0),
            meridian: Slope(h * m, -(h * number(3.0) * meridian * bend * m * m)),
            prime: Slope(h * n, h * dn),
            tangent: Slope(h * tangent * n, h * (tangent * dn + secant * secant * n)),
            secant: Slope(h * secant * n, h * (secant * dn + secant * tangent * n)),
            level: Slope(level, -vertical),
            vertical: Slope(vertical, level),
        }
    }

    #[inline(always)]
    fn step(&mut self, simd: S, increment: &[[f64; 8]; 7], from: usize) {
        let half = Real::<S>::splat(simd, 0.5);
        let (w, q) = (self.w, self.q);
        let dv = triple(simd, increment, 0, from);
        let turn = triple(simd, increment, 3, from);
        let cosine = Real::<S>::load(simd, &increment[6], from);
        let twice = q.cross(dv);
        let twice = Triple { x: twice.x + twice.x, y: twice.y + twice.y, z: twice.z + twice.z };
        let dv = q.cross_plus(twice, twice.scaled_plus(w, dv));

        // Velocity at mid-step: half of this step's increment, and half of the last one's Coriolis and frame terms.
        let (east_mid, north_mid) = (dv.x.times_plus(half, self.east_ahead), dv.y.times_plus(half, self.north_ahead));
        let middle = (half * self.meridian.0).times_plus(self.north, self.latitude_rad);
        let (level, vertical) = (self.level.at(middle), self.vertical.at(middle));
        // The frame's turn in the step is zeta = (-zx, zy, zz).
        let zx = north_mid * self.meridian.at(middle);
        let zy = east_mid.times_plus(self.prime.at(middle), level);
        let zz = east_mid.times_plus(self.tangent.at(middle), vertical);
        let coriolis = zz + vertical;
        let east_turn = half.times_from(zz.times_from(dv.y, zy * dv.z), coriolis * north_mid);
        let north_turn = -half.times_plus(zx.times_plus(dv.z, zz * dv.x), coriolis * east_mid);
        self.east = self.east + dv.x + east_turn;
        self.north = self.north + dv.y + north_turn;
        self.east_ahead = half.times_plus(east_turn, self.east);
        self.north_ahead = half.times_plus(north_turn, self.north);
        self.latitude_rad = self.latitude_rad + zx;
        self.longitude_rad = east_mid.times_plus(self.secant.at(middle), self.longitude_rad);

        let minus_half = Real::<S>::splat(simd, -0.5);
        let zeta = Triple { x: half * zx, y: minus_half * zy, z: minus_half * zz };
        let w_body = q.z.times_from(turn.z, q.y.times_from(turn.y, q.x.times_from(turn.x, w * cosine)));
        let q_body = q.cross_plus(turn, turn.scaled_plus(w, q.scaled(cosine)));
        self.w = zeta.z.times_from(q_body.z, zeta.y.times_from(q_body.y, zeta.x.times_from(q_body.x, w_body)));
        self.q = zeta.cross_plus(q_body, zeta.scaled_plus(w_body, q_body));
    }

    /// Unit length again, by one Newton step of the reciprocal root; sine and cosine follow the latitude.
    #[inline(always)]
    fn store(self, simd: S, state: &mut [[f64; 8]; STATES], from: usize) {
        let number = |value: f64| Real::<S>::splat(simd, value);
        let (half, three_halves) = (number(0.5), number(1.5));
        let scale = half.times_from(self.w.times_plus(self.w, self.q.dot(self.q)), three_halves);
        let d = self.latitude_rad;
        let d2 = d * d;
        let sd = d * d2.times_from(number(1.0 / 6.0), number(1.0));
        let cd = d2.times_plus(d2.times_plus(number(1.0 / 24.0), number(-0.5)), number(1.0));
        let sine = self.sine * cd + self.cosine * sd;
        let cosine = self.cosine * cd - self.sine * sd;
        let unit = half.times_from(sine * sine + cosine * cosine, three_halves);
        let old = |i: usize, state: &[[f64; 8]; STATES]| Real::<S>::load(simd, &state[i], from);
        let (latitude_rad, longitude_rad) = (old(6, state) + d, old(7, state) + self.longitude_rad);
        (self.w * scale).store(&mut state[0], from);
        keep(self.q.scaled(scale), &mut state[..], 1, from);
        let values = [self.east, self.north, latitude_rad, longitude_rad, sine * unit, cosine * unit];
        self.east_ahead.store(&mut state[10], from);
        self.north_ahead.store(&mut state[11], from);
        for (value, slot) in values.into_iter().zip(&mut state[4..10]) {
            value.store(slot, from);
        }
    }
}
