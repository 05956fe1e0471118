//! The linear error equations of the same mission: what each error source does, per unit of it.
//!
//! *Phi-angle* convention: the navigator's attitude is `C' = (I - phi x) C`. With `x = [phi_E, phi_N, phi_U, dv_E, dv_N,
//! dL, dl]` (rad, m/s, rad), the vertical channel held, and `dw`, `df` what the unit adds to rates and forces:
//!
//! ```text
//! phi' = -w_in x phi + dw_in - C dw
//! dv'  = f^n x phi - (2 w_ie + w_en) x dv - (2 dw_ie + dw_en) x v + C df          (east and north)
//! dL'  = dv_N / (R_M + h)          dl' = dv_E sec L / (R_N + h) + v_E sec L tan L / (R_N + h) dL
//! ```
//!
//! (Titterton and Weston, *Strapdown Inertial Navigation Technology*, 2nd ed., section 12.3; Benson 1975 for the name.)
//! `dw` and `df` are linear in the sources, so that 39 signatures and 7 of the start, integrated once, hold every small error.
#![allow(
    clippy::indexing_slicing,
    reason = "arrays of fixed lengths: seven states, three axes, two triads, `NODES` nodes; a source's axis and input are below three by the catalogue"
)]

use super::earth::{self, Curvature, EARTH_RATE};
use super::errors::{ErrorSource, ImuErrors, Instrument, Kind, NavigationError};
use super::mission::{Mission, Site};
use super::motion::Motion;
use super::quadrature::{NODES, Quadrature};
use super::run::Continue;
use super::trajectory::{Block, NodeValues, Trajectory, Truth};

/// Number of states.
pub(crate) const STATES: usize = 7;
/// The state of the error equations.
pub(crate) type State = [f64; STATES];
/// A square matrix of the states, row by row.
pub(crate) type Square = [[f64; STATES]; STATES];

/// What every source has done by one instant.
#[derive(Debug, Clone)]
pub struct Signatures {
    /// Time, s.
    pub time: f64,
    /// For each of [`ErrorSource::catalogue`], the state per SI unit of it.
    pub states: Vec<State>,
    /// Covariance that the mission's random walks have built up.
    pub noise: Square,
    /// Metres for a radian of longitude and of latitude.
    pub metres: [f64; 2],
}

impl Signatures {
    /// A state in the units of [`NavigationError`].
    pub fn error(&self, state: &State) -> NavigationError {
        let [e, n, u, ve, vn, latitude_rad, longitude_rad] = *state;
        NavigationError {
            attitude: [e, n, u],
            velocity: [ve, vn],
            position: [longitude_rad * self.metres[0], latitude_rad * self.metres[1]],
        }
    }
}

/// The vehicle's kinematics on which the error equations hang.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kinematics {
    /// Latitude, rad.
    pub latitude_rad: f64,
    /// Altitude, m.
    pub altitude_m: f64,
    /// East, north, m/s.
    pub velocity: [f64; 2],
    /// Specific force east, north, up, m/s^2.
    pub force: [f64; 3],
}

/// The matrix `F` of `x' = F x`.
pub fn dynamics(k: &Kinematics) -> Square {
    let (sine, cosine) = k.latitude_rad.sin_cos();
    let radii = Curvature::at(k.latitude_rad, k.altitude_m);
    let (m, n) = (1.0 / radii.meridian, 1.0 / radii.prime_vertical);
    let (tangent, secant) = (sine / cosine, 1.0 / cosine);
    let [east, north] = k.velocity;
    let transport = earth::transport_rate(k.latitude_rad, k.altitude_m, k.velocity);
    let rate = [transport[0], EARTH_RATE * cosine + transport[1], EARTH_RATE * sine + transport[2]];
    let coriolis = 2.0 * EARTH_RATE * sine + transport[2];
    // d(2 w_ie + w_en)_U / dL
    let bend = 2.0 * EARTH_RATE * cosine + east * secant * secant * n;
    let [fe, fnorth, fu] = k.force;
    [
        [0.0, rate[2], -rate[1], 0.0, -m, 0.0, 0.0],
        [-rate[2], 0.0, rate[0], n, 0.0, -EARTH_RATE * sine, 0.0],
        [rate[1], -rate[0], 0.0, tangent * n, 0.0, EARTH_RATE * cosine + east * secant * secant * n, 0.0],
        [0.0, -fu, fnorth, north * tangent * n, coriolis, bend * north, 0.0],
        [fu, 0.0, -fe, -coriolis - east * tangent * n, 0.0, -bend * east, 0.0],
        [0.0, 0.0, 0.0, 0.0, m, 0.0, 0.0],
        [0.0, 0.0, 0.0, secant * n, 0.0, east * secant * tangent * n, 0.0],
    ]
}

/// The kinematics of a vehicle at rest.
pub fn at_rest(site: Site) -> Kinematics {
    let gravity = earth::normal_gravity(site.latitude_rad, site.altitude_m);
    Kinematics {
        latitude_rad: site.latitude_rad,
        altitude_m: site.altitude_m,
        velocity: [0.0, 0.0],
        force: [0.0, 0.0, gravity],
    }
}

/// Angular frequencies, rad/s, of the error equations at rest, in rising order: the Earth's, and the two of Schuler's
/// oscillation as the Foucault rotation parts them; `None` where the eigenvalue iteration does not converge.
pub fn frequencies(site: Site) -> Option<[f64; 3]> {
    // Velocities in units of the orbital one, so that all numbers are of the size of Schuler's frequency.
    let scale = [1.0, 1.0, 1.0, 7900.0, 7900.0, 1.0, 1.0];
    let f = dynamics(&at_rest(site));
    let scaled = nalgebra::SMatrix::<f64, STATES, STATES>::from_fn(|i, j| f[i][j] * scale[j] / scale[i]) * 1000.0;
    let schur = nalgebra::linalg::Schur::try_new(scaled, 1e-15, 10_000)?;
    let mut frequencies: Vec<f64> =
        schur.complex_eigenvalues().iter().map(|value| value.im / 1000.0).filter(|value| *value > 1e-9).collect();
    frequencies.sort_by(f64::total_cmp);
    <[f64; 3]>::try_from(frequencies).ok()
}

/// Propagate all signatures along one motion of a mission; one call of `sink` for each row, as in a full run.
pub fn propagate(mission: &Mission, motion: &Motion, sink: &mut dyn FnMut(&Signatures) -> Continue) {
    propagate_to(mission, motion, &mut |done| done + mission.steps_per_row, sink);
}

/// The same with rows at any steps: `next` gives the next row's step, from that of the row before.
pub(crate) fn propagate_to(
    mission: &Mission,
    motion: &Motion,
    next_row: &mut dyn FnMut(u64) -> u64,
    sink: &mut dyn FnMut(&Signatures) -> Continue,
) {
    let sources = ErrorSource::catalogue();
    // Weights of the mean over a block and of its moment about the middle, on the same nodes for any number of steps.
    let rule = Quadrature::new(1);
    let mean = rule.whole;
    let moment: [f64; NODES] = std::array::from_fn(|j| rule.whole[j] * (0.5 - rule.nodes[j]));
    let mut trajectory = Trajectory::new(mission, motion);
    let mut block = Block::default();
    let mut signatures = Signatures {
        time: 0.0,
        states: vec![[0.0; STATES]; sources.len()],
        noise: [[0.0; STATES]; STATES],
        metres: [0.0; 2],
    };
    let metres_at = |place: &Truth| {
        let radii = Curvature::at(place.latitude_rad, mission.site.altitude_m);
        [radii.prime_vertical * place.latitude_rad.cos(), radii.meridian]
    };
    let metres = metres_at(&trajectory.truth());
    for (source, state) in sources.iter().zip(&mut signatures.states) {
        *state = at_start(source, metres);
    }
    let mut next = 0;
    loop {
        if trajectory.done() >= next {
            let truth = trajectory.truth();
            (signatures.time, signatures.metres) = (truth.time, metres_at(&truth));
            if sink(&signatures) == Continue::Stop || trajectory.done() >= mission.steps {
                return;
            }
            next = next_row(trajectory.done()).clamp(trajectory.done() + 1, mission.steps);
        }
        let before = trajectory.truth();
        let steps = next - trajectory.done();
        trajectory.advance_smooth(steps, &mut block);
        let span = block.steps as f64 * mission.step_s;
        let after = trajectory.truth();
        let drive = Drive::over(trajectory.nodes(), &mean, span);
        let lever = Drive::over(trajectory.nodes(), &moment, span * span);
        let kinematics = Kinematics {
            latitude_rad: 0.5 * (before.latitude_rad + after.latitude_rad),
            altitude_m: mission.site.altitude_m,
            velocity: [0, 1].map(|i| 0.5 * (before.velocity[i] + after.velocity[i])),
            force: drive.force,
        };
        let f = dynamics(&kinematics);
        let whole = transition(&f, span);
        let half = transition(&f, 0.5 * span);
        for (source, state) in sources.iter().zip(&mut signatures.states) {
            // exp(F T) x + int exp(F (T - t)) G dt, the latter by mean and moment
            let parts = [apply(&whole, state), apply(&half, &drive.of(source)), apply(&f, &lever.of(source))];
            *state = std::array::from_fn(|i| parts[0][i] + parts[1][i] + parts[2][i]);
        }
        signatures.noise = grow(&signatures.noise, &whole, &mission.errors, span);
    }
}

/// The state at the start per SI unit of a source, with the metres of a radian of longitude and latitude there.
fn at_start(source: &ErrorSource, metres: [f64; 2]) -> State {
    let mut state = [0.0; STATES];
    // longitude follows latitude
    let (place, value) = match (source.kind, source.axis) {
        (Kind::Attitude, axis) => (axis, 1.0),
        (Kind::Velocity, axis) => (3 + axis, 1.0),
        (Kind::Position, 0) => (6, 1.0 / metres[0]),
        (Kind::Position, _) => (5, 1.0 / metres[1]),
        _ => return state,
    };
    if let Some(slot) = state.get_mut(place) {
        *slot = value;
    }
    state
}

/// What a block adds per unit of each source: integrals of `C`, `C omega`, `C omega^2`, and the same of `f`.
struct Drive {
    bias: [[f64; 3]; 3],
    matrix: [[[[f64; 3]; 3]; 3]; 2],
    square: [[[f64; 3]; 3]; 2],
    force: [f64; 3],
}

impl Drive {
    fn over(values: &NodeValues, weights: &[f64; NODES], span: f64) -> Drive {
        let mut drive =
            Drive { bias: [[0.0; 3]; 3], matrix: [[[[0.0; 3]; 3]; 3]; 2], square: [[[0.0; 3]; 3]; 2], force: [0.0; 3] };
        for (j, weight) in weights.iter().enumerate() {
            for row in 0..3 {
                for axis in 0..3 {
                    let c = values.rotation[3 * row + axis][j] * weight * span;
                    drive.bias[row][axis] += c;
                    drive.force[row] += c / span * values.inertial[3 + axis][j];
                    for triad in 0..2 {
                        for input in 0..3 {
                            drive.matrix[triad][row][axis][input] += c * values.inertial[3 * triad + input][j];
                        }
                        drive.square[triad][row][axis] += c * values.inertial[3 * triad + axis][j].powi(2);
                    }
                }
            }
        }
        drive
    }

    /// The integral of `G` for one source: `-C dw` into the attitude, `C df` into the velocity.
    fn of(&self, source: &ErrorSource) -> State {
        let mut state = [0.0; STATES];
        let (triad, sign, rows, first) = match source.instrument {
            Instrument::Gyro => (0, -1.0, 3, 0),
            Instrument::Accelerometer => (1, 1.0, 2, 3),
            Instrument::Start => return state,
        };
        for row in 0..rows {
            state[first + row] = sign
                * match source.kind {
                    Kind::Bias => self.bias[row][source.axis],
                    Kind::ScaleFactor | Kind::Installation => self.matrix[triad][row][source.axis][source.input],
                    Kind::SecondOrder => self.square[triad][row][source.axis],
                    // of a gyro's axis, driven by the specific force
                    Kind::AccelerationSensitive => self.matrix[1][row][source.axis][source.input],
                    Kind::Attitude | Kind::Velocity | Kind::Position => 0.0,
                };
        }
        state
    }
}

/// `exp(F t)` to the third power of `t`; `t` is a second at most, `F` of the size of Schuler's frequency.
fn transition(f: &Square, t: f64) -> Square {
    let mut sum: Square = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    let mut power = sum;
    for order in 1..=3 {
        power = product(&power, f).map(|row| row.map(|value| value * t / f64::from(order)));
        for (total, part) in sum.iter_mut().flatten().zip(power.iter().flatten()) {
            *total += part;
        }
    }
    sum
}

fn product(a: &Square, b: &Square) -> Square {
    let mut c = [[0.0; STATES]; STATES];
    for (row, out) in a.iter().zip(&mut c) {
        for (value, inner) in row.iter().zip(b) {
            for (slot, factor) in out.iter_mut().zip(inner) {
                *slot += value * factor;
            }
        }
    }
    c
}

fn apply(a: &Square, x: &State) -> State {
    a.map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum())
}

/// `P' = Phi P Phi^T + Q t` with the white noise of both triads.
fn grow(p: &Square, phi: &Square, errors: &ImuErrors, span: f64) -> Square {
    if !errors.is_noisy() {
        return *p;
    }
    let transposed: Square = std::array::from_fn(|i| std::array::from_fn(|j| phi[j][i]));
    let mut grown = product(&product(phi, p), &transposed);
    let (gyro, accelerometer) = (errors.gyro.random_walk, errors.accelerometer.random_walk);
    for (i, density) in [gyro, gyro, gyro, accelerometer, accelerometer].into_iter().enumerate() {
        grown[i][i] += density * density * span;
    }
    grown
}
