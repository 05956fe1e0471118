//! A reading taken while a joint turns is the mean of the model line over its turning: at which instants, with which weights.

use super::Instant;
use crate::campaign::{JointState, Reading};
use crate::number;

/// How the model line depends on the angle of the turning joint; decides how many instants its mean needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Smoothness {
    /// A trigonometric polynomial of this degree: equidistant nodes are exact.
    Trigonometric(usize),
    /// Smooth, but no trigonometric polynomial.
    Smooth,
    /// Smooth within a turn, with a jump where it closes (a tilt that grows with the angle).
    Sawtooth,
    /// With kinks or jumps (`abs`, `sign`, `step`), or in the bare angle.
    Rough,
}

/// One instant of a mean and its weight; the weights of a reading sum to 1.
#[derive(Debug, Clone, Default)]
pub struct Node {
    /// Joint angles and rates.
    pub instant: Instant,
    /// Weight in the mean.
    pub weight: f64,
}

/// Most nodes for one whole turn; at half-degree spacing a kink leaves about 1e-5 of the term's amplitude.
const ROUGH_NODES: usize = 720;
const SMOOTH_NODES: usize = 128;

/// The instants over which a reading averages: everything stands as in `base`, and one joint passes these angles.
#[derive(Debug, Clone, Default)]
pub(super) struct Sweep {
    pub base: Instant,
    pub joint: Option<usize>,
    /// Angle in degrees and weight.
    pub stops: Vec<(f64, f64)>,
}

impl Sweep {
    /// Visit every instant with its weight.
    pub(super) fn visit(&mut self, mut visit: impl FnMut(&Instant, f64)) {
        let Some(joint) = self.joint else { return visit(&self.base, 1.0) };
        for (angle, weight) in &self.stops {
            if let Some(slot) = self.base.angle_deg.get_mut(joint) {
                *slot = *angle;
            }
            visit(&self.base, *weight);
        }
    }

    /// Angles of the joint that passes them, and weights; one of no joint where everything stands.
    pub(super) fn each(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        const ALONE: [(f64, f64); 1] = [(0.0, 1.0)];
        if self.joint.is_some() { self.stops.as_slice() } else { &ALONE }.iter().copied()
    }

    /// Take the instants of a reading.
    pub(super) fn set(&mut self, reading: &Reading, smoothness: Smoothness) {
        let Sweep { base, joint, stops } = self;
        base.rate_deg_s.clear();
        base.angle_deg.clear();
        stops.clear();
        let mut averaged = None;
        for (k, state) in reading.joints.iter().enumerate() {
            base.rate_deg_s.push(state.rate_deg_s());
            base.angle_deg.push(match *state {
                JointState::Held { angle_deg } | JointState::Passing { angle_deg, .. } => angle_deg,
                JointState::WholeTurns { .. } | JointState::PartTurns { .. } => {
                    averaged = Some((k, *state));
                    0.0
                }
            });
        }
        *joint = averaged.map(|(joint, _)| joint);
        match averaged {
            None => {}
            Some((_, JointState::PartTurns { start_deg, rate_deg_s, turns })) => {
                part_turns(start_deg, rate_deg_s, turns, smoothness, stops);
            }
            // a jump where the turn closes: no equidistant nodes
            Some((_, state)) if smoothness == Smoothness::Sawtooth => {
                part_turns(0.0, state.rate_deg_s(), 1.0, smoothness, stops);
            }
            Some(_) => stops.extend(whole_turn(smoothness)),
        }
    }
}

/// The instants over which a reading averages the model line.
///
/// Whole turns: `N` equidistant angles, exact for trigonometric polynomials of degree below `N`. Part turns: whole turns first, the rest by
/// 8-point Gauss-Legendre on panels. Anything else is a single instant. Shape: weights sum to 1.
///
/// ```
/// use tumble::campaign::{JointState, Reading};
/// use tumble::design::{nodes, Smoothness};
/// let reading = Reading { joints: vec![JointState::WholeTurns { rate_deg_s: 20.0 }].into(), ..Reading::default() };
/// let nodes = nodes(&reading, Smoothness::Trigonometric(2));
/// let mean: f64 = nodes.iter().map(|n| n.weight * n.instant.angle_deg[0].to_radians().cos().powi(2)).sum();
/// assert!((mean - 0.5).abs() < 1e-15);
/// ```
pub fn nodes(reading: &Reading, smoothness: Smoothness) -> Vec<Node> {
    let mut nodes = Vec::new();
    sweep(reading, smoothness).visit(|instant, weight| nodes.push(Node { instant: instant.clone(), weight }));
    nodes
}

/// The same instants, one at a time.
pub(super) fn sweep(reading: &Reading, smoothness: Smoothness) -> Sweep {
    let mut sweep = Sweep::default();
    sweep.set(reading, smoothness);
    sweep
}

/// Angles and weights over `turns` turns from a start.
fn part_turns(start_deg: f64, rate_deg_s: f64, turns: f64, smoothness: Smoothness, stops: &mut Vec<(f64, f64)>) {
    let whole = if smoothness == Smoothness::Sawtooth { 0.0 } else { turns.trunc() };
    let part = turns - whole;
    let sense = rate_deg_s.signum();
    if whole > 0.0 {
        let turn = whole_turn(smoothness);
        stops.extend(turn.map(|(angle, weight)| (start_deg + sense * angle, weight * whole / turns)));
    }
    // panels short enough that 8 points integrate the highest harmonic to rounding
    let panel_deg = match smoothness {
        Smoothness::Trigonometric(degree) => 90.0 / degree.max(1) as f64,
        Smoothness::Sawtooth => 90.0,
        Smoothness::Smooth => 10.0,
        Smoothness::Rough => 1.0,
    };
    let panels = number::count((part * 360.0 / panel_deg).ceil().max(1.0));
    let width = part * 360.0 / panels as f64;
    for panel in 0..panels {
        for (x, weight) in GAUSS_8.iter().flat_map(|(x, w)| [(-x, *w), (*x, *w)]) {
            let angle = start_deg + sense * width * (panel as f64 + 0.5 + 0.5 * x);
            stops.push((angle, 0.5 * weight * width / (360.0 * turns)));
        }
    }
}

/// Equidistant angles of one turn and their weight. Rough lines take midpoints, which also average the bare angle to half a turn.
fn whole_turn(smoothness: Smoothness) -> impl Iterator<Item = (f64, f64)> {
    let (count, offset) = match smoothness {
        Smoothness::Trigonometric(degree) => (4 * (degree / 4 + 1), 0.0),
        Smoothness::Smooth | Smoothness::Sawtooth => (SMOOTH_NODES, 0.0),
        Smoothness::Rough => (ROUGH_NODES, 0.5),
    };
    (0..count).map(move |k| (360.0 * (k as f64 + offset) / count as f64, 1.0 / count as f64))
}

/// Positive abscissae and weights of 8-point Gauss-Legendre quadrature on [-1, 1] (Abramowitz & Stegun, table 25.4).
const GAUSS_8: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];
