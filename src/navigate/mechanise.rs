//! The strapdown mechanisation: what a navigator makes of increments, one step for all lanes of a register.
//!
//! Local-level, east-north-up, on the ellipsoid; the vertical channel is held (no vertical velocity, the altitude of
//! the site). With `a`, `v` the increments of angle and velocity of one step as the unit reports them:
//!
//! 1. *Coning and sculling* together, as one Magnus step of the rigid motion `(omega, f)` with rates that are quadratic
//!    through this and the two steps before (`a1`, `a2`: the one before, and the one before that):
//!
//!    ```text
//!    phi = a + c1 a1 x a + c2 a2 x a + c3 a2 x a1            c1 = 121/720, c2 = -31/720, c3 = 1/720
//!    u   = v + the same combinations of (a_i x v_j + v_i x a_j)
//!    dv  = u + (1 - cos phi)/phi^2 phi x u + (phi - sin phi)/phi^3 phi x (phi x u)
//!    ```
//! 2. *Velocity* `v' = C dv - zeta/2 x C dv - h (2 w_ie + w_en) x v`, Coriolis terms at mid-step.
//! 3. *Position* by the trapezoid of old and new velocity over the radii of curvature.
//! 4. *Attitude* `q' = (1, -zeta/2) q (cos phi/2, sin(phi/2) phi/phi)`, `zeta = h (w_ie + w_en)` at mid-step.
//!
//! All of it is of fourth order in the step for a smooth motion (the Magnus step's third commutators are the first
//! thing left out); terms that hang on the position are linear over a block, and exact at its start.

use super::course::Block;
use super::earth::{EARTH_RATE, ECCENTRICITY_SQUARED, SEMI_MAJOR_AXIS};
use super::vector::{Real, Triple};
use pulp::Simd;

/// Numbers that a navigator keeps: quaternion 4, velocity 2, latitude and longitude, sine and cosine of latitude, and
/// two past increments of six.
pub const STATES: usize = 22;
/// Numbers that the errors of a unit come to: bias, matrix and square of two triads.
pub const ERRORS: usize = 30;

/// What is common to all lanes and steps.
#[derive(Debug, Clone, Copy)]
pub struct Setting {
    /// Step, s.
    pub step: f64,
    /// Altitude, m.
    pub altitude: f64,
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
        let axis = |row: Triple<S>, bias: Real<S>, square: Real<S>, own: Real<S>| {
            let squared = (square * own).times_plus(own, bias);
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
    let at = |i: usize| Real::load(simd, &columns[i][from..]);
    Triple { x: at(i), y: at(i + 1), z: at(i + 2) }
}

#[inline(always)]
fn keep<S: Simd>(value: Triple<S>, columns: &mut [[f64; 8]], i: usize, from: usize) {
    value.x.store(&mut columns[i][from..]);
    value.y.store(&mut columns[i + 1][from..]);
    value.z.store(&mut columns[i + 2][from..]);
}

/// Fly one block with the lanes `from..from + width` of a group of eight.
///
/// `noise` holds, for each step and lane, six increments of noise; it is empty where there is none.
#[inline(always)]
pub fn fly<S: Simd>(
    simd: S,
    setting: Setting,
    block: &Block,
    errors: &[[f64; 8]; ERRORS],
    state: &mut [[f64; 8]; STATES],
    noise: &[[[f64; 8]; 6]],
    from: usize,
) {
    let number = |value: f64| Real::splat(simd, value);
    let at = |state: &[[f64; 8]; STATES], i: usize| Real::load(simd, &state[i][from..]);
    let gyro = Triad::load(simd, &errors[..15], from);
    let accelerometer = Triad::load(simd, &errors[15..], from);

    let mut w = at(state, 0);
    let mut q = triple(simd, &state[..], 1, from);
    let (mut east, mut north) = (at(state, 4), at(state, 5));
    let (sine, cosine) = (at(state, 8), at(state, 9));
    let mut a1 = triple(simd, &state[..], 10, from);
    let mut v1 = triple(simd, &state[..], 13, from);
    let mut a2 = triple(simd, &state[..], 16, from);
    let mut v2 = triple(simd, &state[..], 19, from);

    // Everything that hangs on the latitude, as value and slope at the block's start.
    let one = number(1.0);
    let altitude = number(setting.altitude);
    let e2 = number(ECCENTRICITY_SQUARED);
    let root = (sine * sine).times_from(e2, one).reciprocal_root();
    let prime = number(SEMI_MAJOR_AXIS) * root;
    let meridian = prime * root * root * number(1.0 - ECCENTRICITY_SQUARED);
    // dR_N/dL = R_N e2 s c / w2, dR_M/dL = 3 R_M e2 s c / w2
    let bend = e2 * sine * cosine * root * root;
    let m0 = (meridian + altitude).reciprocal();
    let m1 = -(number(3.0) * meridian * bend * m0 * m0);
    let n0 = (prime + altitude).reciprocal();
    let n1 = -(prime * bend * n0 * n0);
    let secant = cosine.reciprocal();
    let tangent = sine * secant;
    let t0 = tangent * n0;
    let t1 = tangent * n1 + secant * secant * n0;
    let s0 = secant * n0;
    let s1 = secant * n1 + secant * tangent * n0;
    let rate = number(EARTH_RATE);
    let (level, vertical) = (rate * cosine, rate * sine);

    let h = number(setting.step);
    let half = number(0.5);
    let half_h = number(0.5 * setting.step);
    let (c1, c2, c3) = (number(121.0 / 720.0), number(-31.0 / 720.0), number(1.0 / 720.0));
    let two = number(2.0);
    let mut latitude = number(0.0);
    let mut longitude = number(0.0);

    for i in 0..block.steps {
        let seen = |axis: usize| number(block.increments[axis][i]);
        let mut a = gyro.measure(Triple { x: seen(0), y: seen(1), z: seen(2) });
        let mut v = accelerometer.measure(Triple { x: seen(3), y: seen(4), z: seen(5) });
        if let Some(noise) = noise.get(i) {
            let n = |axis: usize| Real::load(simd, &noise[axis][from..]);
            a = Triple { x: a.x + n(0), y: a.y + n(1), z: a.z + n(2) };
            v = Triple { x: v.x + n(3), y: v.y + n(4), z: v.z + n(5) };
        }

        // Coning and sculling.
        let pa = a1.scaled_plus(c1, a2.scaled(c2));
        let pv = v1.scaled_plus(c1, v2.scaled(c2));
        let (k2a, k2v) = (a2.scaled(c3), v2.scaled(c3));
        let phi = k2a.cross_plus(a1, pa.cross_plus(a, a));
        let u = k2v.cross_plus(a1, k2a.cross_plus(v1, pv.cross_plus(a, pa.cross_plus(v, v))));
        (a2, v2, a1, v1) = (a1, v1, a, v);

        // Velocity increment in the body at the step's start, then in east-north-up.
        let square = phi.dot(phi);
        let first = square.times_plus(square.times_from(number(-1.0 / 720.0), number(-1.0 / 24.0)), half);
        let second = square.times_from(number(1.0 / 120.0), number(1.0 / 6.0));
        let turned = phi.cross(u);
        let dv = phi.cross(turned).scaled_plus(second, turned.scaled_plus(first, u));
        let twice = q.cross(dv).scaled(two);
        let dn = q.cross_plus(twice, twice.scaled_plus(w, dv));

        // Rates of the frame at mid-step, from the velocity expected there.
        let (east_mid, north_mid) = (dn.x.times_plus(half, east), dn.y.times_plus(half, north));
        let lat_mid = (half_h * m0).times_plus(north_mid, latitude);
        let w_north = lat_mid.times_from(vertical, level);
        let w_up = lat_mid.times_plus(level, vertical);
        let m = m1.times_plus(lat_mid, m0);
        let n = n1.times_plus(lat_mid, n0);
        let t = t1.times_plus(lat_mid, t0);
        let transport_up = east_mid * t;
        let zx = -(h * north_mid * m);
        let zy = h * east_mid.times_plus(n, w_north);
        let zz = h * (w_up + transport_up);
        let coriolis = h * two.times_plus(w_up, transport_up);
        let east_new = coriolis.times_plus(north_mid, east + dn.x) - half * zz.times_from(dn.y, zy * dn.z);
        let north_new = coriolis.times_from(east_mid, north + dn.y) - half * zx.times_from(dn.z, zz * dn.x);

        // Position and the frame's turn, with the mean of old and new velocity.
        let east_mean = half * (east + east_new);
        let north_mean = half * (north + north_new);
        (east, north) = (east_new, north_new);
        let north_turn = h * north_mean * m;
        latitude = latitude + north_turn;
        longitude = (h * east_mean).times_plus(s1.times_plus(lat_mid, s0), longitude);
        let zeta = Triple {
            x: half * north_turn,
            y: -(half_h * east_mean.times_plus(n, w_north)),
            z: -(half_h * east_mean.times_plus(t, w_up)),
        };

        // Attitude.
        let sinc = square.times_plus(square.times_plus(number(1.0 / 3840.0), number(-1.0 / 48.0)), half);
        let cos = square.times_plus(
            square.times_plus(square.times_plus(number(-1.0 / 46080.0), number(1.0 / 384.0)), number(-0.125)),
            one,
        );
        let turn = phi.scaled(sinc);
        let w_body = w * cos - q.dot(turn);
        let q_body = q.cross_plus(turn, turn.scaled_plus(w, q.scaled(cos)));
        w = w_body - zeta.dot(q_body);
        q = zeta.cross_plus(q_body, zeta.scaled_plus(w_body, q_body));
    }

    // Unit length again, by one Newton step of the reciprocal root; the sine and cosine follow the latitude.
    let length = q.dot(q) + w * w;
    let scale = half.times_from(length, number(1.5));
    let d2 = latitude * latitude;
    let (sd, cd) = (
        latitude * d2.times_from(number(1.0 / 6.0), one),
        d2.times_plus(d2.times_plus(number(1.0 / 24.0), number(-0.5)), one),
    );
    let new_sine = sine * cd + cosine * sd;
    let new_cosine = cosine * cd - sine * sd;
    let unit = half.times_from(new_sine * new_sine + new_cosine * new_cosine, number(1.5));

    (w * scale).store(&mut state[0][from..]);
    keep(q.scaled(scale), &mut state[..], 1, from);
    east.store(&mut state[4][from..]);
    north.store(&mut state[5][from..]);
    (at(state, 6) + latitude).store(&mut state[6][from..]);
    (at(state, 7) + longitude).store(&mut state[7][from..]);
    (new_sine * unit).store(&mut state[8][from..]);
    (new_cosine * unit).store(&mut state[9][from..]);
    keep(a1, &mut state[..], 10, from);
    keep(v1, &mut state[..], 13, from);
    keep(a2, &mut state[..], 16, from);
    keep(v2, &mut state[..], 19, from);
}
