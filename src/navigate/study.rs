//! All scenarios of a mission in all its motions, and what each error source does in one motion against another.
//!
//! The mission's first motion is the reference (at rest, in the papers); each other motion is compared with it by the
//! ratio of root mean squares over the mission.

use super::errors::{ErrorSource, ImuErrors};
use super::linear;
use super::mission::Mission;
use super::motion::Motion;
use super::propagation::SourceCovariance;
use super::run::{self, Continue, Flight, NavigationError, Outcome, Row, Scenario};
use crate::number;
use crate::vocabulary::vocabulary;

/// Rows kept of each motion for plots and reports, whatever the mission's duration.
pub(crate) const KEPT: u64 = 400;

/// The scenario without errors: what remains is the numerical error of the navigator, of its algorithm and rounding.
pub(crate) const PERFECT: &str = "perfect_unit";

vocabulary! {
    /// Which errors fly together.
    #[derive(Default)]
    #[schemars(rename = "ScenariosFile")]
    FlownTogether {
        /// All together in one scenario.
        Together = "together",
        /// All together, and each group (gyro bias, gyro scale factor, ...) alone.
        #[default]
        Groups = "groups",
        /// All together, each group, and each single error alone.
        Components = "components",
    }
}

/// One motion flown.
#[derive(Debug, Clone, PartialEq)]
pub struct Flown {
    /// The motion's name, numbered where two have the same.
    pub motion: String,
    /// How its scenarios ended.
    pub flight: Flight,
    /// Times of the rows kept, s.
    pub times: Vec<f64>,
    /// For each scenario, the rows kept.
    pub series: Vec<Vec<NavigationError>>,
}

/// Ratios of one scenario; null where the first motion has no such error.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "RatioReport")]
pub struct Ratio {
    /// The scenario.
    pub scenario: String,
    /// The motion compared.
    pub motion: String,
    /// The motion that it is compared with.
    pub against: String,
    /// Tilt, a ratio.
    pub tilt: Option<f64>,
    /// Azimuth, a ratio.
    pub azimuth: Option<f64>,
    /// Velocity, a ratio.
    pub velocity: Option<f64>,
    /// Position, a ratio.
    pub position: Option<f64>,
}

/// Uncertainty of the navigation errors in time, by linear covariance, and by Monte Carlo at the end.
#[derive(Debug, Clone, PartialEq)]
pub struct PropagatedCalibration {
    /// The motion's name.
    pub motion: String,
    /// Times, s.
    pub times: Vec<f64>,
    /// Linear covariance.
    pub linear: Vec<NavigationError>,
    /// Draws flown.
    pub draws: usize,
    /// Standard deviation of the draws about zero at the last row; `None` without draws.
    pub monte_carlo: Option<NavigationError>,
}

/// How far a study has come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Steps done of all motions.
    pub done: u64,
    /// Steps of all motions.
    pub of: u64,
}

/// The scenarios of a set of errors.
pub fn scenarios(errors: &ImuErrors, separation: FlownTogether) -> Vec<Scenario> {
    let mut scenarios = vec![Scenario { id: "all".into(), errors: *errors }];
    let present = errors.present();
    if separation != FlownTogether::Together {
        let mut groups: Vec<String> = Vec::new();
        for group in present.iter().map(ErrorSource::group) {
            if !groups.contains(&group) {
                groups.push(group);
            }
        }
        for id in groups {
            let errors = errors.only(|source| source.group() == id);
            scenarios.push(Scenario { id, errors });
        }
        if errors.is_noisy() {
            let mut noise = ImuErrors::default();
            noise.gyro.random_walk = errors.gyro.random_walk;
            noise.accelerometer.random_walk = errors.accelerometer.random_walk;
            scenarios.push(Scenario { id: "random_walk".into(), errors: noise });
        }
    }
    if separation == FlownTogether::Components {
        scenarios.extend(present.iter().map(|s| Scenario { id: s.id(), errors: ImuErrors::single(*s, s.of(errors)) }));
    }
    scenarios.push(Scenario { id: PERFECT.into(), errors: ImuErrors::default() });
    scenarios
}

/// The mission's motions with a name for each: the reference first.
pub(crate) fn motions(mission: &Mission) -> Vec<(String, &Motion)> {
    let mut named: Vec<(String, &Motion)> = Vec::new();
    for motion in std::iter::once(&mission.motion).chain(&mission.beside) {
        let same = named.iter().filter(|(_, other)| other.name == motion.name).count();
        let name = if same == 0 { motion.name.clone() } else { format!("{} {}", motion.name, same + 1) };
        named.push((name, motion));
    }
    named
}

/// Fly all motions of a mission; `sink` gets every row with the motion's name and may stop the study.
pub fn fly(
    mission: &Mission,
    scenarios: &[Scenario],
    sink: &mut dyn FnMut(&str, &Row<'_>, Progress) -> Continue,
) -> Vec<Flown> {
    let motions = motions(mission);
    let of = mission.steps * motions.len() as u64;
    let every = (mission.steps / mission.steps_per_row.max(1)).div_ceil(KEPT).max(1);
    let mut all = Vec::new();
    let mut stopped = false;
    for (index, (name, motion)) in motions.into_iter().enumerate() {
        if stopped {
            break;
        }
        let (mut times, mut series) = (Vec::new(), vec![Vec::new(); scenarios.len()]);
        let mut count = 0;
        let flight = run::fly(mission, motion, scenarios, &mut |row| {
            if count % every == 0 || row.truth.time >= mission.duration() {
                times.push(row.truth.time);
                for (kept, error) in series.iter_mut().zip(row.errors) {
                    kept.push(*error);
                }
            }
            count += 1;
            let steps = number::count_u64((row.truth.time / mission.step_s).round());
            let next = sink(&name, row, Progress { done: mission.steps * index as u64 + steps, of });
            stopped = next == Continue::Stop;
            next
        });
        all.push(Flown { motion: name, flight, times, series });
    }
    all
}

/// So many times the rounding of a mission, in tilt, azimuth, velocity and position: that of the attitude in every pair of steps adds up to `steps * eps` at
/// worst, and a tilt becomes `sqrt(g R)` times as much velocity and `R` times as much position.
fn rounding(mission: &Mission, times: f64) -> [f64; 4] {
    let rounding = mission.steps as f64 * f64::EPSILON;
    [1.0, 1.0, 7.9e3, 6.4e6].map(|scale| times * scale * rounding)
}

/// The least errors that a comparison can resolve: the numerical errors of the navigator (tilt, azimuth, velocity, position; SI) in a motion.
///
/// Rounding, or three times the errors with a perfect unit where these are larger.
pub(crate) fn floors(mission: &Mission, flown: &Flown) -> [f64; 4] {
    let perfect = flown.flight.outcomes.iter().find(|outcome| outcome.id == PERFECT);
    let numerical = perfect.map_or([0.0; 4], sizes);
    together(rounding(mission, 1.0), numerical, |felt, numerical| felt.max(3.0 * numerical))
}

/// Tilt, azimuth, velocity and position of two lists, one by one.
fn together<A, B, C>(a: [A; 4], b: [B; 4], of: impl Fn(A, B) -> C) -> [C; 4] {
    let ([a, c, e, g], [b, d, f, h]) = (a, b);
    [of(a, b), of(c, d), of(e, f), of(g, h)]
}

/// Root mean squares of tilt, azimuth, velocity and position.
fn sizes(outcome: &Outcome) -> [f64; 4] {
    [outcome.tilt.rms, outcome.azimuth.rms, outcome.velocity.rms, outcome.position.rms]
}

/// Every motion against the first, scenario by scenario; nothing where the error in the first motion is the numerical one of the navigator.
pub fn ratios(mission: &Mission, flown: &[Flown]) -> Vec<Ratio> {
    let Some((reference, others)) = flown.split_first() else { return Vec::new() };
    let floors = floors(mission, reference);
    let mut ratios = Vec::new();
    for (i, base) in reference.flight.outcomes.iter().enumerate().filter(|(_, base)| base.id != PERFECT) {
        for other in others {
            let Some(outcome) = other.flight.outcomes.get(i) else { continue };
            let (a, b) = (sizes(outcome), sizes(base));
            let shares = together(a, b, |a, b| a / b);
            let seen = together(b, floors, |b, floor| b > floor);
            let [tilt, azimuth, velocity, position] = together(shares, seen, |share, seen| seen.then_some(share));
            let (scenario, motion, against) = (base.id.clone(), other.motion.clone(), reference.motion.clone());
            ratios.push(Ratio { scenario, motion, against, tilt, azimuth, velocity, position });
        }
    }
    ratios
}

/// A motion in which the numerical error of the navigator is no longer small against that of its unit.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Unresolved {
    /// The motion.
    pub motion: String,
    /// Tilt, azimuth, velocity and position that a perfect unit leaves, root mean squares, SI.
    pub own: [f64; 4],
    /// The motion's shortest period, s; infinite without oscillation.
    pub period: f64,
}

/// Motions beyond what the navigator's step resolves: a perfect unit leaves more than a tenth of what all errors together do, and more than
/// rounding.
pub(crate) fn unresolved(mission: &Mission, flown: &[Flown]) -> Vec<Unresolved> {
    let periods: Vec<f64> = motions(mission).into_iter().map(|(_, motion)| motion.shortest_period()).collect();
    let mut unresolved = Vec::new();
    for (motion, period) in flown.iter().zip(periods) {
        let of = |id: &str| motion.flight.outcomes.iter().find(|outcome| outcome.id == id).map(sizes);
        let (Some(perfect), Some(all)) = (of(PERFECT), of("all")) else { continue };
        let beyond = together(perfect, rounding(mission, 10.0), |perfect, felt| perfect > felt);
        let counts = together(perfect, all, |perfect, all| !(perfect <= 0.1 * all));
        if together(beyond, counts, |a, b| a && b).contains(&true) {
            unresolved.push(Unresolved { motion: motion.motion.clone(), own: perfect, period });
        }
    }
    unresolved
}

/// Carry a covariance of error sources along each motion of a mission.
///
/// The draws of the Monte Carlo run are flown with the full simulation, eight and eight in lanes.
pub fn propagate_calibration(
    mission: &Mission,
    covariance: &SourceCovariance,
    draws: usize,
    sink: &mut dyn FnMut(Progress) -> Continue,
) -> Vec<PropagatedCalibration> {
    let motions = motions(mission);
    let of = 2 * mission.steps * motions.len() as u64;
    let every = (mission.steps / mission.steps_per_row.max(1)).div_ceil(KEPT).max(1);
    let mut all = Vec::new();
    let mut before = 0;
    for (name, motion) in motions {
        let (mut times, mut linear, mut count) = (Vec::new(), Vec::new(), 0);
        let steps = |time: f64| number::count_u64((time / mission.step_s).round());
        let mut stopped = false;
        linear::propagate(mission, motion, &mut |signatures| {
            if count % every == 0 || signatures.time >= mission.duration() {
                times.push(signatures.time);
                linear.push(covariance.propagate(signatures));
            }
            count += 1;
            let next = sink(Progress { done: before + steps(signatures.time), of });
            stopped = next == Continue::Stop;
            next
        });
        let mut monte_carlo = None;
        if draws > 0 && !stopped {
            let scenarios = covariance.draw(&mission.errors, draws, mission.seed);
            let flight = run::fly(mission, motion, &scenarios, &mut |row| {
                let next = sink(Progress { done: before + mission.steps + steps(row.truth.time), of });
                stopped = next == Continue::Stop;
                next
            });
            monte_carlo = Some(deviation(&flight.outcomes));
        }
        before += 2 * mission.steps;
        all.push(PropagatedCalibration { motion: name, times, linear, draws, monte_carlo });
        if stopped {
            break;
        }
    }
    all
}

fn deviation(outcomes: &[Outcome]) -> NavigationError {
    let rms = |of: &dyn Fn(&NavigationError) -> f64| {
        let squares: f64 = outcomes.iter().map(|outcome| of(&outcome.last).powi(2)).sum();
        (squares / outcomes.len().max(1) as f64).sqrt()
    };
    NavigationError {
        attitude: [rms(&|e| e.attitude[0]), rms(&|e| e.attitude[1]), rms(&|e| e.attitude[2])],
        velocity: [rms(&|e| e.velocity[0]), rms(&|e| e.velocity[1])],
        position: [rms(&|e| e.position[0]), rms(&|e| e.position[1])],
    }
}
