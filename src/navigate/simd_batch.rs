//! Many scenarios of one motion side by side: eight navigators to a group, as many to a register as the machine has.
//!
//! The motion is common to all lanes, so its increments are made once per block; every lane then applies its errors
//! and mechanises. Which instructions are used is decided at run time (`pulp`): a portable binary runs AVX2 and FMA
//! where they exist, and plain arithmetic elsewhere. One thread; the groups of a block run one after another while its
//! increments are in the first-level cache.
#![allow(clippy::indexing_slicing, reason = "a group has `GROUP` lanes, and axes and inputs run over arrays of three")]

use super::earth::Curvature;
use super::errors::{ImuErrors, NavigationError, TriadErrors};
use super::mechanise::{self, CHUNK, ERRORS, Memory, STATES, Setting};
use super::mission::Mission;
use super::quadrature::MAX_STEPS;
use super::trajectory::{Block, Trajectory, Truth};
use pulp::{Arch, Simd, WithSimd};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;

/// Lanes of a group.
pub const GROUP: usize = 8;

/// Eight scenarios.
#[derive(Debug, Clone)]
struct Group {
    used: usize,
    memory: Box<Memory>,
    /// Standard deviation of one increment, gyro and accelerometer, and the generator, of each noisy lane.
    noise: Vec<(usize, f64, f64, Pcg64Mcg)>,
    drawn: Vec<[[f64; GROUP]; 6]>,
}

/// The navigators of one mission and motion.
#[derive(Debug, Clone)]
pub struct Fleet {
    groups: Vec<Group>,
    setting: Setting,
    block: Block,
    arch: Arch,
}

impl Fleet {
    /// Navigators that start from the truth but for their errors of the start, one for each set of errors; lane `k` of noise is seeded by `seed` and `k`.
    pub fn new(mission: &Mission, trajectory: &mut Trajectory, errors: &[ImuErrors], seed: u64) -> Fleet {
        let truth = trajectory.truth();
        let past = trajectory.before_start();
        let setting = Setting { step: mission.step_s, altitude_m: mission.site.altitude_m };
        let groups = errors
            .chunks(GROUP)
            .enumerate()
            .map(|(g, chunk)| Group::new(chunk, setting, &truth, &past, seed, g * GROUP))
            .collect();
        Fleet { groups, setting, block: Block::default(), arch: Arch::new() }
    }

    /// Advance all navigators by one block of at most `limit` steps of their trajectory; the block's steps are returned.
    pub(crate) fn advance(&mut self, trajectory: &mut Trajectory, limit: u64) -> usize {
        self.arch.dispatch(Advance { fleet: self, trajectory, limit });
        self.block.steps
    }

    /// What navigator `index` believes, by its states.
    pub(crate) fn belief(&self, index: usize) -> Option<[f64; STATES]> {
        let group = self.groups.get(index / GROUP)?;
        let lane = index % GROUP;
        (lane < group.used).then(|| group.memory.state.map(|lanes| lanes[lane]))
    }
}

struct Advance<'a> {
    fleet: &'a mut Fleet,
    trajectory: &'a mut Trajectory,
    limit: u64,
}

impl WithSimd for Advance<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Advance { fleet: Fleet { groups, setting, block, .. }, trajectory, limit } = self;
        trajectory.advance(limit, block);
        for group in groups {
            group.draw(block.steps);
            let Group { used, memory, drawn, .. } = group;
            for register in 0..used.div_ceil(S::F64_LANES) {
                mechanise::fly(simd, *setting, block, memory, drawn, register);
            }
        }
    }
}

impl Group {
    fn new(chunk: &[ImuErrors], setting: Setting, truth: &Truth, past: &[f64; 6], seed: u64, first: usize) -> Group {
        let Setting { step, altitude_m } = setting;
        let mut group = Group {
            used: chunk.len(),
            memory: Box::new(Memory {
                errors: [[0.0; GROUP]; ERRORS],
                state: [[0.0; GROUP]; STATES],
                reported: [[[0.0; GROUP]; 6]; CHUNK + 1],
                track: [[[0.0; GROUP]; 7]; CHUNK / 2],
            }),
            noise: Vec::new(),
            drawn: Vec::new(),
        };
        for lane in 0..GROUP {
            let errors = chunk.get(lane).copied().unwrap_or_default(); // fewer units than lanes: a perfect one, which nobody reads
            let start_state = believed(truth, &errors.start, altitude_m);
            let triads = [scaled(&errors.gyro, step), scaled(&errors.accelerometer, step)].concat();
            // an increment of velocity times the drift is an increment of angle
            let columns = triads.into_iter().chain(errors.drift.iter().flatten().copied());
            for (slot, value) in group.memory.errors.iter_mut().zip(columns) {
                slot[lane] = value;
            }
            // The navigator remembers what its unit reported before the start.
            let past = measured(&errors, past, step);
            for (slot, value) in group.memory.state.iter_mut().zip(start_state) {
                slot[lane] = value;
            }
            for (slot, value) in group.memory.reported[0].iter_mut().zip(past) {
                slot[lane] = value;
            }
            if errors.is_noisy() && lane < chunk.len() {
                let root = step.sqrt();
                let generator = Pcg64Mcg::seed_from_u64(seed.wrapping_add(0x9e37_79b9 * (first + lane) as u64));
                group.noise.push((
                    lane,
                    errors.gyro.random_walk * root,
                    errors.accelerometer.random_walk * root,
                    generator,
                ));
            }
        }
        group
    }

    /// Noise of every step of a block, where there is any.
    fn draw(&mut self, steps: usize) {
        if self.noise.is_empty() {
            return;
        }
        self.drawn.resize(MAX_STEPS, [[0.0; GROUP]; 6]);
        for (lane, gyro, accelerometer, generator) in &mut self.noise {
            for step in self.drawn.iter_mut().take(steps) {
                for (axis, slot) in step.iter_mut().enumerate() {
                    let unit: f64 = StandardNormal.sample(generator);
                    slot[*lane] = unit * if axis < 3 { *gyro } else { *accelerometer };
                }
            }
        }
    }
}

/// What a navigator believes when it starts, as its states: the truth, turned by `-phi` and shifted.
fn believed(truth: &Truth, start: &NavigationError, altitude_m: f64) -> [f64; STATES] {
    let [tw, tx, ty, tz] = truth.quaternion;
    let angle = start.attitude.iter().map(|phi| phi * phi).sum::<f64>().sqrt();
    let part = if angle > 0.0 { -(0.5 * angle).sin() / angle } else { -0.5 };
    let (w, [x, y, z]) = ((0.5 * angle).cos(), start.attitude.map(|phi| part * phi));
    let quaternion = [
        w * tw - x * tx - y * ty - z * tz,
        w * tx + x * tw + y * tz - z * ty,
        w * ty - x * tz + y * tw + z * tx,
        w * tz + x * ty - y * tx + z * tw,
    ];
    let radii = Curvature::at(truth.latitude_rad, altitude_m);
    let latitude_rad = truth.latitude_rad + start.position[1] / radii.meridian;
    let longitude_rad = truth.longitude_rad + start.position[0] / (radii.prime_vertical * truth.latitude_rad.cos());
    let [east, north] = [0, 1].map(|i| truth.velocity[i] + start.velocity[i]);
    let (sine, cosine) = latitude_rad.sin_cos();
    let [w, x, y, z] = quaternion;
    [w, x, y, z, east, north, latitude_rad, longitude_rad, sine, cosine, east, north]
}

/// A triad's errors for increments over a step.
fn scaled(errors: &TriadErrors, step: f64) -> [f64; 15] {
    let mut columns = [0.0; 15];
    for axis in 0..3 {
        columns[axis] = errors.bias[axis] * step;
        for input in 0..3 {
            columns[3 + 3 * axis + input] = errors.matrix[axis][input] + f64::from(u8::from(axis == input));
        }
        columns[12 + axis] = errors.square[axis] / step;
    }
    columns
}

/// What a unit with these errors and no noise reports of true increments (rates x, y, z, then specific forces).
pub fn measured(errors: &ImuErrors, increments: &[f64; 6], step: f64) -> [f64; 6] {
    let triad = |errors: &TriadErrors, t: [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|axis| {
            let row = &errors.matrix[axis];
            let squared = errors.square[axis] * t[axis] * t[axis] / step;
            t[axis] + errors.bias[axis] * step + row[0] * t[0] + row[1] * t[1] + row[2] * t[2] + squared
        })
    };
    let [a, b, c, d, e, f] = *increments;
    let drift = errors.drift.map(|row| row[0] * d + row[1] * e + row[2] * f);
    let ([a, b, c], [d, e, f]) = (triad(&errors.gyro, [a, b, c]), triad(&errors.accelerometer, [d, e, f]));
    [a + drift[0], b + drift[1], c + drift[2], d, e, f]
}
