//! The truth of a motion, block by block: exact increments of the unit, and where the vehicle really is.
//!
//! Rates and specific forces are evaluated in closed form at the nodes of a block and integrated by
//! [`Quadrature`]; sinusoids advance from the block's start by the addition theorem and are evaluated afresh at every
//! block, so that nothing accumulates. Only the latitude and longitude of a moving vehicle are integrals.
#![allow(
    clippy::indexing_slicing,
    reason = "all arrays are over the `NODES` nodes of a rule or the steps of a block, of which `advance_smooth` takes `MAX_STEPS` at most"
)]

use super::earth::{self, Curvature};
use super::mission::{Mission, Site};
use super::motion::{Attitude, Motion, Oscillation, Path, Stage};
use super::quadrature::{MAX_STEPS, NODES, Quadrature};
use crate::number;
use std::f64::consts::TAU;
use std::sync::Arc;

/// One quantity at the nodes of a block.
pub(crate) type AtNodes = [f64; NODES];

/// What the unit's sensors see in one block, and the truth at its start.
#[derive(Debug, Clone)]
pub struct Block {
    /// Steps of this block.
    pub steps: usize,
    /// Time at the block's start, s.
    pub start: f64,
    /// Increments of each step: rows are the integrated rates x, y, z (rad) and specific forces x, y, z (m/s).
    pub increments: Box<[[f64; MAX_STEPS]; 6]>,
}

/// The true state of the vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// Time, s.
    pub time: f64,
    /// Body to east-north-up, scalar first.
    pub quaternion: [f64; 4],
    /// East, north, m/s.
    pub velocity: [f64; 2],
    /// Geodetic latitude, rad.
    pub latitude_rad: f64,
    /// Longitude, rad, not reduced to a turn.
    pub longitude_rad: f64,
}

/// Rates, specific forces and attitude at the nodes of a block; for the linear error model.
#[derive(Debug, Clone)]
pub(crate) struct NodeValues {
    /// `omega_ib^b` (rad/s) and `f^b` (m/s^2), x, y, z each.
    pub inertial: [AtNodes; 6],
    /// `C_b^n`, row by row.
    pub rotation: [AtNodes; 9],
}

/// Where a motion is in time.
#[derive(Debug, Clone)]
pub(crate) struct Trajectory {
    site: Site,
    step: f64,
    attitude: Attitude,
    schedule: Vec<Stage>,
    /// Heading at the start, rad.
    heading: f64,
    longest: usize,
    /// Parts of a step that are integrated one by one, for a motion faster than the steps.
    parts: usize,
    done: u64,
    steps: u64,
    latitude_rad: f64,
    longitude_rad: f64,
    rules: Vec<Arc<Quadrature>>,
    values: Box<NodeValues>,
    constant: bool,
}

impl Trajectory {
    /// The trajectory of one of a mission's motions.
    pub(crate) fn new(mission: &Mission, motion: &Motion) -> Trajectory {
        let end = mission.duration();
        let (schedule, heading) = match &motion.path {
            Path::Stays => (Vec::new(), 0.0),
            Path::Legs(legs) => (legs.schedule(end), legs.heading),
        };
        // A block spans a tenth of the shortest period, and 0.64 s at the most (the navigator's curvature terms
        // are linear over a block).
        let span = (0.1 * motion.shortest_period()).min(0.64);
        let longest = 2 * number::count((0.5 * span / mission.step_s).round()).clamp(1, MAX_STEPS / 2);
        // Chebyshev nodes hold half a period to rounding
        let parts = if 2.0 * mission.step_s > 0.5 * motion.shortest_period() {
            number::count((4.0 * mission.step_s / motion.shortest_period()).ceil())
        } else {
            0
        };
        let constant = schedule.is_empty() && motion.shortest_period() == f64::INFINITY;
        Trajectory {
            site: mission.site,
            step: mission.step_s,
            attitude: motion.attitude,
            schedule,
            heading,
            longest,
            parts,
            done: 0,
            steps: mission.steps,
            latitude_rad: mission.site.latitude_rad,
            longitude_rad: mission.site.longitude_rad,
            rules: Vec::new(),
            values: Box::new(NodeValues { inertial: [[0.0; NODES]; 6], rotation: [[0.0; NODES]; 9] }),
            constant,
        }
    }

    /// Steps done.
    pub(crate) fn done(&self) -> u64 {
        self.done
    }

    /// The true state after the steps done.
    pub(crate) fn truth(&self) -> Truth {
        let time = self.done as f64 * self.step;
        let (speed, _, turned, _) = self.stage(time);
        let half = |angle: f64| (0.5 * angle).sin_cos();
        let Attitude { pitch, roll, yaw } = self.attitude;
        let ((st, ct), (sg, cg), (sp, cp)) = (half(pitch.at(time)), half(roll.at(time)), half(yaw.at(time) - turned));
        // Rot(z, yaw) Rot(x, pitch) Rot(y, roll)
        let quaternion = [
            cp * ct * cg - sp * st * sg,
            cp * st * cg - sp * ct * sg,
            cp * ct * sg + sp * st * cg,
            sp * ct * cg + cp * st * sg,
        ];
        let (east, north) = (self.heading + turned).sin_cos();
        Truth {
            time,
            quaternion,
            velocity: [speed * east, speed * north],
            latitude_rad: self.latitude_rad,
            longitude_rad: self.longitude_rad,
        }
    }

    /// The increments of the step before the start (rates, then specific forces), which a navigator that has just been
    /// switched on remembers.
    pub(crate) fn before_start(&mut self) -> [f64; 6] {
        let rule = Quadrature::new(1);
        self.evaluate(&rule, -self.step, self.step);
        let mut block = Block::default();
        integrate(&rule, &self.values, self.step, &mut block);
        block.increments.each_ref().map(|row| row[0])
    }

    /// Advance by one block of at most `limit` steps (an even number) and fill `block` with its increments; a leg that ends between two
    /// samples of a pair parts the block, not the pair.
    ///
    /// Inlined into its caller, so that it is compiled for the vector instructions that are detected at run time.
    #[inline(always)]
    pub(crate) fn advance(&mut self, limit: u64, block: &mut Block) {
        self.advance_smooth(limit, block);
        while block.steps % 2 == 1 && block.steps < MAX_STEPS && self.done < self.steps {
            let room = (MAX_STEPS - block.steps) as u64;
            let mut second = Block::default();
            self.advance_smooth(limit.saturating_sub(block.steps as u64).clamp(1, room), &mut second);
            for (row, part) in block.increments.iter_mut().zip(second.increments.iter()) {
                row[block.steps..].iter_mut().zip(&part[..second.steps]).for_each(|(slot, value)| *slot = *value);
            }
            block.steps += second.steps;
        }
    }

    /// The same without pairs: a block that ends where the motion is not smooth.
    #[inline(always)]
    pub(crate) fn advance_smooth(&mut self, limit: u64, block: &mut Block) {
        crate::stop::poll();
        let start = self.done as f64 * self.step;
        let mut steps = (self.longest as u64).min(limit.max(1)).min((self.steps - self.done).max(1));
        for stage in &self.schedule {
            let edge = number::count_u64((stage.start / self.step).round());
            if edge > self.done {
                steps = steps.min(edge - self.done);
            }
        }
        let steps = number::index(steps);
        let filled = self.constant && block.steps >= steps && self.done > 0;
        block.start = start;
        self.done += steps as u64;
        if filled {
            block.steps = steps;
            return;
        }
        block.steps = steps;
        if self.parts > 0 {
            return self.fill_by_parts(start, block);
        }
        let rule = self.rule(steps);
        let span = steps as f64 * self.step;
        self.evaluate(&rule, start, span);
        integrate(&rule, &self.values, span, block);
    }

    /// The rule for so many steps, made once.
    fn rule(&mut self, steps: usize) -> Arc<Quadrature> {
        if let Some(rule) = self.rules.iter().find(|rule| rule.steps == steps) {
            return rule.clone();
        }
        let rule = Arc::new(Quadrature::new(steps));
        self.rules.push(rule.clone());
        rule
    }

    /// Increments of a motion that is faster than the steps: each step as the sum of parts that are short against it.
    fn fill_by_parts(&mut self, start: f64, block: &mut Block) {
        let rule = self.rule(1);
        let span = self.step / self.parts as f64;
        let mut part = Block::default();
        for step in 0..block.steps {
            let mut sums = [0.0; 6];
            for k in 0..self.parts {
                self.evaluate(&rule, start + self.step * step as f64 + span * k as f64, span);
                integrate(&rule, &self.values, span, &mut part);
                sums.iter_mut().zip(part.increments.iter()).for_each(|(sum, row)| *sum += row[0]);
            }
            block.increments.iter_mut().zip(sums).for_each(|(row, sum)| row[step] = sum);
        }
    }

    /// What the last block looked like at its nodes.
    pub fn nodes(&self) -> &NodeValues {
        &self.values
    }

    /// Speed and acceleration along the heading, how far it has turned, and its rate.
    fn stage(&self, time: f64) -> (f64, f64, f64, f64) {
        let stage = self.schedule.iter().rev().find(|stage| stage.start <= time + 1e-6 * self.step);
        stage.or(self.schedule.first()).map_or((0.0, 0.0, 0.0, 0.0), |stage| {
            if time < stage.start {
                // before the start it neither speeds up nor turns
                return (stage.speed, 0.0, stage.turned, 0.0);
            }
            let (speed, turned) = stage.at(time);
            (speed, stage.leg.acceleration, turned, stage.leg.turn)
        })
    }

    #[inline(always)]
    fn evaluate(&mut self, rule: &Quadrature, start: f64, span: f64) {
        let times: AtNodes = std::array::from_fn(|j| start + span * rule.nodes[j]);
        // The frame's rate and the specific force in east-north-up.
        let mut frame = [[0.0; NODES]; 3];
        let mut force = [[0.0; NODES]; 3];
        if self.schedule.is_empty() {
            let rate = earth::earth_rate(self.site.latitude_rad);
            let gravity = earth::normal_gravity(self.site.latitude_rad, self.site.altitude_m);
            frame = [[0.0; NODES], [rate[1]; NODES], [rate[2]; NODES]];
            force[2] = [gravity; NODES];
        } else {
            self.travel(rule, start, span, &times, &mut frame, &mut force);
        }
        let (_, _, turned, turning) = self.stage(start + 0.5 * span);
        // the heading at the block's start, and its rate: clockwise, against the yaw
        let turn = (turning * 0.5 * span - turned, -turning);
        rotate_to_body(&self.attitude, turn, rule, start, span, &frame, &force, &mut self.values);
    }

    /// Along the heading: latitude at the nodes by Picard iteration on its integral, then rates and forces.
    fn travel(
        &mut self,
        rule: &Quadrature,
        start: f64,
        span: f64,
        times: &AtNodes,
        frame: &mut [AtNodes; 3],
        force: &mut [AtNodes; 3],
    ) {
        let altitude_m = self.site.altitude_m;
        let (speed, acceleration, turned, turning) = self.stage(start + 0.5 * span);
        let since = times.map(|time| time - start - 0.5 * span);
        let speeds: AtNodes = since.map(|since| speed + acceleration * since);
        let headings: [(f64, f64); NODES] = since.map(|since| (self.heading + turned + turning * since).sin_cos());
        let mut latitudes = [self.latitude_rad; NODES];
        let mut rates = [0.0; NODES];
        for _ in 0..4 {
            for (j, rate) in rates.iter_mut().enumerate() {
                *rate = speeds[j] * headings[j].1 / Curvature::at(latitudes[j], altitude_m).meridian;
            }
            for (latitude_rad, weights) in latitudes.iter_mut().zip(&rule.running) {
                *latitude_rad = self.latitude_rad + span * dot(weights, &rates);
            }
        }
        let mut turns = [0.0; NODES];
        for (j, (latitude_rad, speed)) in latitudes.iter().zip(&speeds).enumerate() {
            let (east, north) = headings[j];
            let velocity = [speed * east, speed * north];
            let transport = earth::transport_rate(*latitude_rad, altitude_m, velocity);
            let earth = earth::earth_rate(*latitude_rad);
            let coriolis: [f64; 3] = std::array::from_fn(|i| 2.0 * earth[i] + transport[i]);
            frame[0][j] = transport[0];
            frame[1][j] = earth[1] + transport[1];
            frame[2][j] = earth[2] + transport[2];
            // f = dv/dt + (2 w_ie + w_en) x v + g up; a turn adds the centripetal acceleration
            force[0][j] = acceleration * east + speed * turning * north - coriolis[2] * velocity[1];
            force[1][j] = acceleration * north - speed * turning * east + coriolis[2] * velocity[0];
            force[2][j] = coriolis[0] * velocity[1] - coriolis[1] * velocity[0]
                + earth::normal_gravity(*latitude_rad, altitude_m);
            turns[j] = velocity[0] / (Curvature::at(*latitude_rad, altitude_m).prime_vertical * latitude_rad.cos());
        }
        if start >= 0.0 {
            self.latitude_rad += span * dot(&rule.whole, &rates);
            self.longitude_rad += span * dot(&rule.whole, &turns);
        }
    }
}

impl Default for Block {
    fn default() -> Self {
        Block { steps: 0, start: 0.0, increments: Box::new([[0.0; MAX_STEPS]; 6]) }
    }
}

/// `1 / (k (k + 1))` of the sine's series for `k = 2, 4 ... 20`; the next term is below 1e-17 at a right angle.
const SINE: [f64; 10] = reciprocals(1.0);
/// `1 / (k (k - 1))` of the cosine's.
const COSINE: [f64; 10] = reciprocals(-1.0);

const fn reciprocals(offset: f64) -> [f64; 10] {
    let mut terms = [0.0; 10];
    let mut i = 0;
    while i < 10 {
        let k = 2.0 * (i + 1) as f64;
        terms[i] = 1.0 / (k * (k + offset));
        i += 1;
    }
    terms
}

/// Sine and cosine of each, by the power series; the arguments are below a right angle.
#[inline(always)]
fn sine_cosine(angles: &AtNodes) -> (AtNodes, AtNodes) {
    let (mut sine, mut cosine) = ([0.0; NODES], [0.0; NODES]);
    for j in 0..NODES {
        let x2 = angles[j] * angles[j];
        let (mut s, mut c) = (1.0, 1.0);
        for i in (0..10).rev() {
            s = 1.0 - x2 * SINE[i] * s;
            c = 1.0 - x2 * COSINE[i] * c;
        }
        (sine[j], cosine[j]) = (angles[j] * s, c);
    }
    (sine, cosine)
}

/// An angle's sine, cosine and rate at the nodes.
#[inline(always)]
fn oscillate(angle: &Oscillation, rule: &Quadrature, start: f64, span: f64) -> (AtNodes, AtNodes, AtNodes) {
    let (sine_mean, cosine_mean) = angle.mean.sin_cos();
    if angle.amplitude == 0.0 {
        return ([sine_mean; NODES], [cosine_mean; NODES], [0.0; NODES]);
    }
    let speed = TAU / angle.period;
    let (s0, c0) = (TAU * (start / angle.period).fract() + angle.phase).sin_cos();
    let advance = rule.nodes.map(|node| speed * span * node);
    // A block spans a tenth of a period, so that the advance stays below a right angle, or is a single step.
    let (sa, ca) =
        if speed * span < 1.5 { sine_cosine(&advance) } else { (advance.map(f64::sin), advance.map(f64::cos)) };
    let (mut swing, mut rate) = ([0.0; NODES], [0.0; NODES]);
    for j in 0..NODES {
        swing[j] = angle.amplitude * (s0 * ca[j] + c0 * sa[j]);
        rate[j] = angle.amplitude * speed * (c0 * ca[j] - s0 * sa[j]);
    }
    let (s, c) = sine_cosine(&swing);
    let (mut sine, mut cosine) = ([0.0; NODES], [0.0; NODES]);
    for j in 0..NODES {
        sine[j] = sine_mean * c[j] + cosine_mean * s[j];
        cosine[j] = cosine_mean * c[j] - sine_mean * s[j];
    }
    (sine, cosine, rate)
}

/// Rates and forces in the body: `omega_ib^b = C_n^b omega_in^n + omega_nb^b`, `f^b = C_n^b f^n`; `turn` adds an angle at the start and a
/// rate to the yaw.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn rotate_to_body(
    attitude: &Attitude,
    turn: (f64, f64),
    rule: &Quadrature,
    start: f64,
    span: f64,
    frame: &[AtNodes; 3],
    force: &[AtNodes; 3],
    values: &mut NodeValues,
) {
    let (st, ct, pitch_rate) = oscillate(&attitude.pitch, rule, start, span);
    let (sg, cg, roll_rate) = oscillate(&attitude.roll, rule, start, span);
    let (mut sp, mut cp, mut yaw_rate) = oscillate(&attitude.yaw, rule, start, span);
    if turn != (0.0, 0.0) {
        for j in 0..NODES {
            let (s, c) = (turn.0 + turn.1 * span * rule.nodes[j]).sin_cos();
            (sp[j], cp[j]) = (sp[j] * c + cp[j] * s, cp[j] * c - sp[j] * s);
            yaw_rate[j] += turn.1;
        }
    }
    let NodeValues { inertial, rotation } = values;
    for j in 0..NODES {
        let (st, ct, sg, cg, sp, cp) = (st[j], ct[j], sg[j], cg[j], sp[j], cp[j]);
        let c = [
            cp * cg - sp * st * sg,
            -sp * ct,
            cp * sg + sp * st * cg,
            sp * cg + cp * st * sg,
            cp * ct,
            sp * sg - cp * st * cg,
            -ct * sg,
            st,
            ct * cg,
        ];
        for i in 0..9 {
            rotation[i][j] = c[i];
        }
        for i in 0..3 {
            inertial[i][j] = c[i] * frame[0][j] + c[3 + i] * frame[1][j] + c[6 + i] * frame[2][j];
            inertial[3 + i][j] = c[i] * force[0][j] + c[3 + i] * force[1][j] + c[6 + i] * force[2][j];
        }
        inertial[0][j] += cg * pitch_rate[j] - sg * ct * yaw_rate[j];
        inertial[1][j] += roll_rate[j] + st * yaw_rate[j];
        inertial[2][j] += sg * pitch_rate[j] + cg * ct * yaw_rate[j];
    }
}

/// Every step's integral of all six.
#[inline(always)]
fn integrate(rule: &Quadrature, values: &NodeValues, span: f64, block: &mut Block) {
    let full = rule.steps.next_multiple_of(8).min(MAX_STEPS);
    for (row, samples) in block.increments.iter_mut().zip(&values.inertial) {
        for chunk in 0..full / 8 {
            let mut sums = [0.0; 8];
            for (weights, sample) in rule.weights.iter().zip(samples) {
                for (sum, weight) in sums.iter_mut().zip(&weights[8 * chunk..8 * chunk + 8]) {
                    *sum += weight * (sample * span);
                }
            }
            row[8 * chunk..8 * chunk + 8].copy_from_slice(&sums);
        }
    }
}

fn dot(a: &AtNodes, b: &AtNodes) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Metres east and north of a small difference in longitude and latitude, rad.
pub(crate) fn metres(truth: &Truth, altitude_m: f64, latitude_rad: f64, longitude_rad: f64) -> [f64; 2] {
    let radii = Curvature::at(truth.latitude_rad, altitude_m);
    [
        (longitude_rad - truth.longitude_rad) * radii.prime_vertical * truth.latitude_rad.cos(),
        (latitude_rad - truth.latitude_rad) * radii.meridian,
    ]
}
