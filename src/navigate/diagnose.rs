//! Which calibration errors explain measured navigation errors, and the gap with them in the mission.
//!
//! ```text
//! gap = measured - predicted(mission),     gap = J x + noise,     J: one signature for each error source (signatures.rs)
//! ```
//!
//! Causes ([`super::cause`]) are constant errors of the unit and the start, biases that change in time (ramp, step, warm-up), faults of the
//! reference (offset, drift, step) and single values. Sets of causes have the posterior of campaigns, on the linear model at a state (`judged.rs`); the most
//! probable one is refined by Gauss-Newton on the full simulation, with derivatives by differences of it (`refine.rs`), and all are judged again from there
//! (`search.rs`). The search begins with nothing; where that does not leave noise, or the gap is far from linear, also with all biases that a unit has, and
//! with these and the attitude of the start, where the gap is large fitted to the first rows before the later ones, and with columns made anew around them.
//! Causes less probable than a name requires are removed at the end. Random walks that the mission states are whitened away (`whiten.rs`); those that it does
//! not state, white or of biases, are looked for where nothing else fits at less cost (`unstated_walk.rs`). Where no set leaves noise alone, causes that are significant against the
//! noise and the remainder are named (`partly.rs`). Known errors of the mission are the current model: a finding is a change of them.

use super::case::Case;
use super::cause::Cause;
use super::errors::{ErrorSource, ImuErrors};
pub use super::finding::Finding;
pub(crate) use super::finding::{Alias, GapStep, Suspect, Unexplained};
use super::measured::Measured;
use super::mission::Mission;
use super::refine::Search;
use super::remainder::{ChannelGap, GapOverTime};
use super::search;
use super::settings::Settings;
use crate::diagnosis::{Gap, NoiseFrom, Step, Verdict};
use crate::error::{Fault, Malformed, Result};

/// The result of a diagnosis of navigation errors.
#[derive(Debug, Clone, PartialEq)]
pub struct NavigationDiagnosis {
    /// The verdict.
    pub verdict: Verdict,
    /// The errors, the strongest first.
    pub findings: Vec<Finding>,
    /// The mission's errors as given.
    pub before: ImuErrors,
    /// The same with the findings.
    pub after: ImuErrors,
    /// Where the noise comes from.
    pub noise: NoiseFrom,
    /// The gap before and after, in standard uncertainties (of innovations, where the mission has random walks).
    pub gap: [Gap; 2],
    /// The gap as it shrinks, from the mission as given, by one cause after the other; empty without findings.
    pub gap_steps: Vec<GapStep>,
    /// The same by run and channel, in the unit of the channel.
    pub channels: Vec<ChannelGap>,
    /// The gap in time, for a picture.
    pub gaps_over_time: Vec<GapOverTime>,
    /// What is unexplained.
    pub unexplained: Option<Unexplained>,
    /// Single values that noise does not explain, with the findings in the mission, the furthest first.
    pub suspects: Vec<Suspect>,
    /// Causes that are probable, but not enough for a name, each with its probability: no part of the mission's errors after.
    pub suspected: Vec<(Cause, f64)>,
    /// The search's record.
    pub steps: Vec<Step>,
    /// How many errors were tried, and how many of them are distinct here.
    pub candidates: (usize, usize),
    /// Errors that these data cannot show at any size that a navigator's unit has.
    pub invisible: Vec<ErrorSource>,
    /// How often the full simulation was flown for a refit, and whether it settled.
    pub refits: (usize, bool),
}

/// Rounds of estimating the noise from the residuals, at most;
const ROUNDS: usize = 8;
/// it has settled when no scale moves by more than this share.
const STEADY: f64 = 0.02;

/// Diagnose measured navigation errors of a mission.
///
/// Errors: a significance outside (0, 1); random walks in the mission, but measured values without `u`; a navigator that the
/// errors of the mission carry over a pole.
pub fn diagnose(mission: &Mission, measured: &Measured, settings: &Settings) -> Result<NavigationDiagnosis> {
    diagnose_with(mission, measured, settings, &mut |_, _| {})
}

/// The same; `progress` gets the approximate share of the work that is done, and what is being tried.
pub(crate) fn diagnose_with(
    mission: &Mission,
    measured: &Measured,
    settings: &Settings,
    progress: &mut dyn FnMut(f64, &str),
) -> Result<NavigationDiagnosis> {
    let over_a_pole = || {
        Malformed::new(Fault::Value, "the errors of the mission carry its navigator over a pole")
            .at_path("errors")
            .expected("errors with which the mission can be flown")
    };
    let case = Case::new(mission, measured, settings)?;
    let gap = case.residual(&case.there);
    if gap.iter().any(|v| !v.is_finite()) {
        return Err(over_a_pole());
    }
    let mut u = case.first_u(&gap);
    for round in 0..ROUNDS {
        let tests = search::penalty(&case, &u);
        let mut tell = |share: f64, trying: &str| progress(share, trying);
        let mut search = Search::new(case.clone(), &u, tests, &mut tell);
        // where noise is estimated in rounds, each takes half of what remains
        let done = 1.0 - 0.5_f64.powf(round as f64);
        search.part = if case.from == NoiseFrom::Stated { (0.0, 0.8) } else { (done, 0.5 + 0.5 * done) };
        let state = search.run().ok_or_else(over_a_pole)?;
        if case.from == NoiseFrom::Residuals && round + 1 < ROUNDS {
            let better = case.u_of(&case.residual(&state.flown.predicted), state.set.len(), &gap);
            if !better.iter().zip(&u).all(|(a, b)| (a - b).abs() <= STEADY * b) {
                u = better;
                continue;
            }
        }
        let unstated = search.unstated_walks(&state);
        if unstated.is_empty() {
            return search.conclude(&state, &gap);
        }
        // the same question of a mission that states the random walks
        let cost = search.is_complete(&state).then(|| case.spread(&u, &state.out) - 2.0 * state.value);
        let with = search.with_walks(&case, &case.columns.walks, &unstated);
        let mut again = |share: f64, trying: &str| (search.progress)(share, trying);
        let mut other = Search::new(with.clone(), &u, tests, &mut again);
        other.part = (0.8, 0.9);
        (other.unstated, other.stated) = (unstated, case.columns.walks.clone());
        if let Some(accepted) = other.run()
            && other.is_complete(&accepted)
            && cost.is_none_or(|cost| other.score_of_all(&accepted) < cost)
        {
            let mut diagnosis = other.conclude(&accepted, &gap)?;
            let before = case.gap(&gap, &u, &[], 0);
            let [_, after] = diagnosis.gap;
            if !diagnosis.gap_steps.is_empty() {
                diagnosis.gap_steps.insert(0, GapStep { with: Vec::new(), left_out: 0, gap: before.clone() });
            }
            return Ok(NavigationDiagnosis { gap: [before, after], ..diagnosis });
        }
        return search.conclude(&state, &gap);
    }
    Err(over_a_pole())
}
