//! Where simulation and measurement disagree, what is missing from the model, and the gap with it added.
//!
//! ```text
//! gap = (reading - prediction) / u,    t = b / u(b) of an effect b in the model with all that is named, given the most probable remainder (`score.rs`)
//! ```
//!
//! | file | subject |
//! |---|---|
//! | `common.rs` | the words that diagnoses of navigation errors have, too; every threshold, with its meaning and source |
//! | `catalogue.rs` | effects as data |
//! | `assumptions.rs` | priors and constraints: held, and candidates themselves |
//! | `averaged.rs` | long records |
//! | `score.rs` | the posterior of sets of effects and a remainder |
//! | `bank.rs` | remainders that know nothing of the catalogue |
//! | `factor.rs` | what of a remainder's readings deviates together |
//! | `augmented.rs` | score and exact fit in turn |
//! | `candidates.rs` | each effect as a column of this campaign, and how large it is |
//! | `noise.rs` | the noise floor: stated, replicates, residuals |
//! | `own_noise.rs` | the noise of each of several sensors that share random effects |
//! | `screen.rs` | long campaigns: which bad readings, positions and steps get a column; columns of ones at some rows, compared without being made |
//! | `remounting.rs` | positions that scatter |
//! | `finding.rs` | from a search to the answer; the gap after each effect |
//! | `repair.rs` | the effect in the model line, its value there, and what its uncertainty has beyond the noise |
//! | `separate.rs` | positions that would tell rivals apart |
//! | `foresee.rs` | what a diagnosis could find on a schedule; its columns, where nobody has measured yet |
//! | `ambiguity.rs` | what the aliases do to the parameters |
//! | `places.rs` | where the gap is: factors and levels |
//! | `holdout.rs` | leave-one-position-out prediction |
//!
//! Honesty: probabilities count everything that was tried; what the schedule cannot tell apart is one finding with aliases; a set that only
//! approximates the pattern is not named. Priors and constraints are retained while the model is diagnosed, and may be named as wrong.

mod ambiguity;
mod assumptions;
mod augmented;
mod averaged;
mod bank;
mod candidates;
mod catalogue;
mod common;
mod factor;
mod finding;
mod foresee;
mod holdout;
mod noise;
mod own_noise;
mod places;
mod remounting;
mod repair;
mod score;
mod screen;
mod separate;

pub use assumptions::Held;
pub(crate) use augmented::State;
pub use augmented::candidates;
pub use candidates::Candidate;
pub use catalogue::Effect;
pub(crate) use catalogue::{Applies, BUILT_IN, covariates};
#[cfg(feature = "navigate")]
pub(crate) use common::{DIFFERENT, LENGTHS, share_of_wave};
pub use common::{Gap, Settings, Verdict};
pub(crate) use common::{NoiseFrom, Step};
pub(crate) use finding::{Alias, GapStep};
pub use finding::{Change, Finding};
pub use foresee::foresee;
pub(crate) use foresee::{Alike, Fate, Foresight, Near, PassedOver, Prospect, Rule, directions, is_angle};
pub(crate) use holdout::Holdout;
pub(crate) use places::{Grouping, Level, Place, PlaceMean};
#[cfg(feature = "navigate")]
pub(crate) use score::{Class, Deviations, Kernel, Posterior, Priors, Problem, Score};
pub(crate) use separate::Separation;

use crate::campaign::{Campaign, JointState};
use crate::error::Result;
use crate::fit::{self, Estimator, Fit, Stop};
use crate::simulate::Regressor;

/// The noise floor.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "NoiseReport")]
#[non_exhaustive]
pub struct NoiseFloor {
    /// Standard deviation of a reading of the first sensor, in its unit; null where it is unknown.
    pub sd: Option<f64>,
    /// `replicates`, `stated` or `residuals` (of the finished model: then completeness cannot be tested).
    pub from: NoiseFrom,
}

/// What is unexplained.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "UnexplainedReport")]
#[non_exhaustive]
pub struct Unexplained {
    /// In one sentence.
    pub pattern: String,
    /// What readings share that share their deviation (the setting, a joint, a stretch of time); null where each has its own.
    pub follows: Option<String>,
    /// Standard deviation of what is unexplained, in the unit of the first sensor; null where the noise is unknown.
    pub sd: Option<f64>,
    /// Mean residual at each state of the joints.
    pub cells: Vec<PlaceMean>,
    /// The candidates that come nearest together; they are not accepted.
    pub nearest: Vec<String>,
    /// Share of the residual sum of squares that those would remove.
    pub nearest_explains: f64,
}

/// An effect that is suspected.
#[derive(Debug, Clone)]
pub struct Suspect {
    /// The effect.
    pub effect: Candidate,
    /// Posterior probability that it or one of its aliases is present.
    pub probability: f64,
}

/// Everything that a diagnosis found.
#[derive(Debug, Clone)]
pub struct Diagnosis {
    /// The verdict.
    pub verdict: Verdict,
    /// The effects, one for each that is missing.
    pub effects: Vec<Finding>,
    /// The exact fit of the model as given (linear where the exact one does not converge).
    pub before: Fit,
    /// The exact fit with the effects.
    pub after: Option<Fit>,
    /// The gap before.
    pub gap_before: Gap,
    /// The gap after; as before where nothing was found.
    pub gap_after: Gap,
    /// The noise floor.
    pub noise: NoiseFloor,
    /// Where the gap is, the most significant first.
    pub places: Vec<Place>,
    /// The readings by the factor with few levels that the gap follows most, for a picture.
    pub grouping: Option<Grouping>,
    /// What is unexplained.
    pub unexplained: Option<Unexplained>,
    /// Leave-one-position-out prediction.
    pub holdout: Option<Holdout>,
    /// The gap as given, after the first effect, after the second, and so on.
    pub steps: Vec<GapStep>,
    /// How many candidates, and how many distinct ones among them.
    pub candidates: (usize, usize),
    /// Estimated parameters before and after.
    pub changes: Vec<Change>,
    /// Positions that would make a diagnosis possible, best first.
    pub would_help: Vec<Vec<JointState>>,
    /// Standard deviation that the noise floor gives each row, in the sensor's unit; readings first, then priors.
    pub row_sd: Vec<f64>,
    /// What was done with each constraint.
    pub constraints: Vec<Held>,
    /// Effects that are probable, but not enough for a name: no part of the repaired model.
    pub suspected: Vec<Suspect>,
    /// What the posterior says; `None` where nothing can be diagnosed.
    pub state: Option<State>,
    /// The repaired question with its constraints as they were asked for, without those found wrong; `None` where nothing was found.
    pub repaired: Option<Campaign>,
    /// Of a long record: readings, and how many averages of them were compared.
    pub averaged: Option<(usize, usize)>,
}

/// Diagnose a campaign with a catalogue (see `wire::built_in_effects`).
///
/// Errors: those of [`fit::fit`]; a significance outside (0, 1); a catalogue's term with a name that this campaign does not have.
pub fn diagnose(campaign: &Campaign, catalogue: &[Effect], settings: &Settings) -> Result<Diagnosis> {
    settings.check()?;
    let spelled_out = fit::spelled_out(campaign, settings.remount)?;
    let counted = catalogue::with_order(&spelled_out);
    let mut diagnosis = diagnose_long(&counted, catalogue, settings)?;
    diagnosis.repaired = diagnosis.repaired.map(|repaired| catalogue::without_order(repaired, &spelled_out));
    Ok(diagnosis)
}

/// A long record by its averages.
fn diagnose_long(campaign: &Campaign, catalogue: &[Effect], settings: &Settings) -> Result<Diagnosis> {
    let Some(long) = averaged::averaged(campaign) else { return diagnose_readings(campaign, catalogue, settings) };
    let mut diagnosis = diagnose_readings(&long.campaign, catalogue, settings)?;
    diagnosis.averaged = Some((campaign.readings.rows.len(), long.campaign.readings.rows.len()));
    // those that were not merged stand for themselves
    let first = |k: usize| long.first.get(k).copied().unwrap_or(k);
    for finding in &mut diagnosis.effects {
        let effect = &mut finding.effect;
        match effect.kind {
            Regressor::Reading(k) => {
                (effect.kind, effect.regressor) = (Regressor::Reading(first(k)), format!("reading:{}", first(k) + 1));
            }
            Regressor::Exchange(a, b) => {
                effect.kind = Regressor::Exchange(first(a), first(b));
                effect.regressor = format!("exchange:{}:{}", first(a) + 1, first(b) + 1);
            }
            _ => {}
        }
    }
    if diagnosis.repaired.is_some() {
        let all = diagnosis
            .effects
            .iter()
            .flat_map(|finding| [&finding.effect].into_iter().chain(finding.also.iter().map(|o| &o.effect)));
        let effects: Vec<&Candidate> = all.collect();
        diagnosis.repaired = Some(repair::repaired(campaign, &effects)?);
    }
    Ok(diagnosis)
}

fn diagnose_readings(campaign: &Campaign, catalogue: &[Effect], settings: &Settings) -> Result<Diagnosis> {
    let first = given(campaign, catalogue, settings)?;
    remounting::diagnose(campaign, catalogue, settings, first)
}

/// With what scatters as the campaign says it.
fn given(
    campaign: &Campaign,
    catalogue: &[Effect],
    settings: &Settings,
) -> Result<(Diagnosis, Option<remounting::Scattering>)> {
    let assumed = assumptions::hold(campaign)?;
    let question = campaign;
    let campaign = &assumed.campaign;
    let before = fit_exactly(campaign, fit::fit)?;
    let asking = augmented::Question { campaign, asked: &assumed.asked, catalogue, settings };
    let (seen, repaired) = augmented::run(asking, &before.design.point)?;
    let grouping = places::grouping(campaign, &seen.design, &seen.weighted);
    let scattering = remounting::scattering(campaign, &seen, settings);
    let mut diagnosis = finding::conclude(campaign, before, seen, repaired, settings)?;
    if let Some(after) = &diagnosis.after {
        for finding in &mut diagnosis.effects {
            finding::missed(campaign, after, finding);
        }
    }
    diagnosis.grouping = grouping;
    diagnosis.constraints = assumed.held;
    let wrong = diagnosis.effects.iter().filter_map(|finding| assumptions::constraint_of(&finding.effect));
    for k in wrong.filter_map(|k| assumed.asked.get(k)) {
        diagnosis.constraints.iter_mut().skip(*k).take(1).for_each(|held| *held = Held::Wrong);
    }
    diagnosis.repaired = diagnosis.after.as_ref().map(|after| {
        let mut repaired = after.campaign.clone();
        let asked = question.constraints.iter().zip(&diagnosis.constraints);
        repaired.constraints = asked.filter(|(_, held)| **held != Held::Wrong).map(|(c, _)| c.clone()).collect();
        repaired
    });
    Ok((diagnosis, scattering))
}

/// Gauss-Newton iterations of one fit: lines with kinks or jumps never settle to rounding, since what they average moves in steps.
const ITERATIONS: usize = 15;
/// A fit whose last step moved the predictions by less than this, in standard uncertainties of all readings together, is as good as settled.
const SMALL_STEP: f64 = 0.05;

/// Gauss-Newton to the exact model as far as it goes, or the linear estimator where it goes astray.
///
/// At a jump (`sign` of an input that a tilt makes positive or negative) it ends with no descent, next to the jump: as near as there is.
fn fit_exactly(campaign: &Campaign, fit: fn(&Campaign, &fit::Settings) -> Result<Fit>) -> Result<Fit> {
    let exact = fit(campaign, &fit::Settings { iterations: ITERATIONS, ..fit::Settings::default() })?;
    let usable = exact.convergence.as_ref().is_some_and(|record| {
        let small = record.iterations.last().is_some_and(|last| last.step < SMALL_STEP);
        record.converged || record.stop == Stop::NoDescent || (record.stop != Stop::OutOfRange && small)
    });
    if usable {
        Ok(exact)
    } else {
        fit(campaign, &fit::Settings { estimator: Estimator::Linear, ..fit::Settings::default() })
    }
}
