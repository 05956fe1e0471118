//! Motions that would discriminate an error from its aliases: the signatures under other motions, in addition to those of the data.
//!
//! If the error has the estimated size, and its alias is fitted to the present data and to a further run together, the norm of the residuals is
//!
//! ```text
//! D = |x| * |(1 - P_{others, alias}) c|,     c: the error's weighted column of both runs
//! ```
//!
//! standard deviations. A motion discriminates where `D` is five or more.

use super::cause::Cause;
use super::errors::ErrorSource;
pub(crate) use super::finding::DiscriminatingMotion;
use super::finding::Finding;
use super::measured::{CHANNELS, Measured, MeasuredRow};
use super::mission::Mission;
use super::motion::{Attitude, Leg, Legs, Motion, Oscillation, Path};
use super::signatures::system;
use super::study;
use super::whiten::whiten;
use crate::error::Result;
use crate::linear::{norm, orthonormal, project};
use crate::number;
use std::f64::consts::FRAC_PI_2;

/// Most motions that are named.
const NAMED: usize = 4;
/// Rows of a further run that are computed; more are counted by their number.
const ROWS: usize = 120;

/// Step for motions at rest, s.
const AT_REST: f64 = 2.0;

/// A motion, and the columns of a further run of it.
struct Alternative {
    motion: Motion,
    columns: Vec<Vec<f64>>,
}

/// Find the motions for each finding that has aliases.
pub(super) fn separate(
    mission: &Mission,
    measured: &Measured,
    u: &[f64],
    present: &dyn Fn(&Cause) -> Vec<f64>,
    set: &[Cause],
    tells: f64,
    findings: &mut [Finding],
) -> Result<()> {
    if findings.iter().all(|finding| finding.aliases.is_empty()) {
        return Ok(());
    }
    let sources = ErrorSource::catalogue();
    let index = |source: &ErrorSource| sources.iter().position(|other| other == source);
    let alternatives = alternatives(mission, measured, u)?;
    for finding in findings {
        let Some(error) = finding.source.constant() else { continue };
        let others: Vec<Cause> = set.iter().copied().filter(|cause| *cause != error).collect();
        let aliases: Vec<ErrorSource> = finding
            .aliases
            .iter()
            .filter(|alias| !alias.absurd && alias.together_with.is_none())
            .filter_map(|alias| alias.source.constant())
            .collect();
        for alternative in &alternatives {
            // changes in time and faults of the reference need not recur in a further run
            let column = |cause: &Cause| -> Vec<f64> {
                let rows = alternative.columns.first().map_or(0, Vec::len);
                let further = cause.constant().and_then(|source| index(&source));
                let further = further.and_then(|j| alternative.columns.get(j)).cloned();
                present(cause).into_iter().chain(further.unwrap_or_else(|| vec![0.0; rows])).collect()
            };
            let discriminated: Vec<(ErrorSource, f64)> = aliases
                .iter()
                .map(|source| {
                    let alias = Cause::Constant(*source);
                    let basis: Vec<Vec<f64>> = others.iter().chain([&alias]).map(column).collect();
                    (*source, finding.value.abs() * norm_outside(column(&Cause::Constant(error)), basis))
                })
                .filter(|(_, sigmas)| *sigmas >= tells)
                .collect();
            if !discriminated.is_empty() {
                finding.separate_by.push(DiscriminatingMotion {
                    motion: alternative.motion.clone(),
                    by: discriminated.iter().fold(f64::INFINITY, |least, (_, sigmas)| least.min(*sigmas)),
                    tells: discriminated.into_iter().map(|(source, _)| source).collect(),
                });
            }
        }
        finding.separate_by.sort_by(|a, b| b.tells.len().cmp(&a.tells.len()).then(b.by.total_cmp(&a.by)));
        finding.separate_by.truncate(NAMED);
    }
    Ok(())
}

/// Norm of a column outside the span of others.
fn norm_outside(mut column: Vec<f64>, others: Vec<Vec<f64>>) -> f64 {
    let basis = orthonormal(others, 1e-18);
    project(&mut column, &basis);
    project(&mut column, &basis);
    norm(&column)
}

/// Further runs with the channels, the times and the noise of the first run of the data.
fn alternatives(mission: &Mission, measured: &Measured, u: &[f64]) -> Result<Vec<Alternative>> {
    let Some(first) = measured.runs.first() else { return Ok(Vec::new()) };
    let mut noise = [None; CHANNELS];
    for (cell, u) in measured.cells().zip(u) {
        if let Some(slot) = noise.get_mut(cell.channel).filter(|slot| slot.is_none()) {
            *slot = Some(*u);
        }
    }
    let every = first.rows.len().div_ceil(ROWS).max(1);
    // fewer rows, each as precise as the mean of those that it represents; random walks do not average out so
    let counts = if mission.errors.is_noisy() { 1.0 } else { (every as f64).sqrt() };
    let noise = noise.map(|u| u.map(|u: f64| u / counts));
    let mut alternatives = Vec::new();
    for motion in motions(mission, measured) {
        let mut flown = mission.clone();
        flown.motion = motion.clone();
        if motion.path == Path::Stays && motion.fastest_rate() == 0.0 {
            // at rest nothing is faster than Schuler's oscillation, against which seconds are short
            flown.step_s = mission.step_s.max(AT_REST);
            flown.steps = 2 * number::count_u64((0.5 * mission.duration() / flown.step_s).ceil());
        }
        let mut run = Measured::default();
        for row in first.rows.iter().step_by(every) {
            run.push(0, MeasuredRow { time: row.time, value: noise.map(|u| u.map(|_| 0.0)), u: noise });
        }
        // without stated uncertainties all rows of a channel weigh alike
        let row_u: Vec<f64> = run.cells().map(|cell| cell.u.unwrap_or(1.0)).collect();
        let (mut columns, walks) = system(&flown, &run);
        whiten(&run, &walks, &row_u, &mut columns);
        alternatives.push(Alternative { motion, columns });
    }
    Ok(alternatives)
}

/// Motions worth trying, the simplest first: those of the mission that are not in the data, turned headings, tilts, a swing, legs.
fn motions(mission: &Mission, measured: &Measured) -> Vec<Motion> {
    let present: Vec<&Motion> =
        measured.runs.iter().map(|run| super::signatures::motion(mission, run.motion)).collect();
    let yaw = mission.motion.attitude.yaw.mean;
    let angle = |mean: f64, degrees: f64, period: f64, phase: f64| Oscillation {
        mean,
        amplitude: degrees.to_radians(),
        period,
        phase: phase.to_radians(),
    };
    let swing = Attitude {
        pitch: angle(0.0, 7.0, 6.0, 0.0),
        roll: angle(0.0, 10.0, 8.0, 0.0),
        yaw: angle(yaw, 5.0, 10.0, 45.0),
    };
    let pair = 2.0 * mission.step_s;
    let whole = |time: f64| (time / pair).round().max(1.0) * pair;
    let legs = Legs {
        heading: -yaw,
        speed: 0.0,
        legs: vec![
            Leg { duration: whole(0.2 * mission.duration()), acceleration: 0.0, turn: 0.0 },
            Leg { duration: whole(200f64.min(0.1 * mission.duration())), acceleration: 0.05, turn: 0.0 },
            Leg { duration: f64::INFINITY, acceleration: 0.0, turn: 0.0 },
        ],
    };
    let turned = |quarters: f64| Motion::at_rest(0.0, 0.0, wrapped(yaw - quarters * FRAC_PI_2));
    let mut tried: Vec<Motion> = study::motions(mission).into_iter().map(|(_, motion)| motion.clone()).collect();
    tried.extend([turned(1.0), turned(2.0)]);
    tried.extend([Motion::at_rest(FRAC_PI_2 / 3.0, 0.0, yaw), Motion::at_rest(0.0, FRAC_PI_2 / 3.0, yaw)]);
    tried.extend(Motion::swing(swing).ok());
    tried.push(Motion::legs(legs));
    let mut kept: Vec<Motion> = Vec::new();
    for motion in tried {
        let new = !present.contains(&&motion) && !kept.contains(&motion);
        if new && mission.clone().beside(motion.clone()).is_ok() {
            kept.push(motion);
        }
    }
    kept
}

/// A yaw within half a turn.
fn wrapped(yaw: f64) -> f64 {
    let turn = 4.0 * FRAC_PI_2;
    yaw - turn * (yaw / turn).round()
}
