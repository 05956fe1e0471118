//! Where simulation and measurement disagree, what is missing from the model, and the gap with it added.
//!
//! ```text
//! gap = (reading - prediction) / u,    r = (1 - Q Q') gap,    evidence of c = ((c' . r) / |c'|)^2,  c' = (1 - Q Q') c
//! ```
//!
//! | file | subject |
//! |---|---|
//! | `catalogue.rs` | effects as data |
//! | `candidates.rs` | each effect as a column of this campaign |
//! | `noise.rs` | the noise floor: stated, replicates, residuals |
//! | `pool.rs` | lazy orthogonalisation of many columns |
//! | `arena.rs` | evidence given a set, family-wise probabilities, the global test |
//! | `search.rs` | the smallest complete set, and its rivals |
//! | `support.rs` | effects that hang on one position alone |
//! | `repair.rs` | the effect in the model line |
//! | `separate.rs` | positions that would tell rivals apart |
//! | `foresee.rs` | what a diagnosis could find on a schedule |
//! | `places.rs` | where the gap is: factors and levels |
//! | `holdout.rs` | leave-one-position-out prediction |
//!
//! Honesty: probabilities count everything that was tried; what the schedule cannot tell apart is one finding with aliases; a set that only
//! approximates the pattern is not named. Constraints are left out: the free model is diagnosed.

mod arena;
mod candidates;
mod catalogue;
mod finding;
mod foresee;
mod holdout;
mod noise;
mod places;
mod pool;
mod repair;
mod search;
mod separate;
mod support;

pub use candidates::Candidate;
pub use catalogue::{Applies, BUILT_IN, Effect};
pub use finding::{Alias, Change, Finding};
pub use foresee::{Alike, Fate, Foresight, Near, Prospect, Rule, foresee, is_angle};
pub use holdout::Holdout;
pub use noise::NoiseFrom;
pub use places::{Cell, Level, Place};
pub use pool::{Pool, VISIBLE};

use crate::campaign::{Campaign, JointState};
use crate::design::{self, Model};
use crate::error::{Fault, Malformed, Result};
use crate::fit::{self, Fit};
use arena::Arena;
use noise::Weighted;
use search::{Found, Levels};
use support::Support;

/// How to diagnose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Probability of reporting anything when nothing is missing; between 0 and 1.
    pub significance: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Settings { significance: 0.01 }
    }
}

/// The verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The effects named explain the gap down to the noise.
    EffectsFound,
    /// The gap is noise.
    NothingMissing,
    /// Something is missing that nothing in the catalogue explains.
    Unexplained,
    /// There is no redundancy: nothing can be diagnosed.
    NotDiagnosable,
}

impl Verdict {
    /// As reports write it.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::EffectsFound => "effects-found",
            Verdict::NothingMissing => "nothing-missing",
            Verdict::Unexplained => "unexplained",
            Verdict::NotDiagnosable => "not-diagnosable",
        }
    }
}

/// The gap between readings and predictions.
#[derive(Debug, Clone, PartialEq)]
pub struct Gap {
    /// Root mean square of the residuals, `sqrt(sum v^2 / dof)`, in the sensor's unit; `None` without degrees of freedom.
    pub rms: Option<f64>,
    /// Largest residual by size.
    pub max: f64,
    /// `sum (v/u)^2` with the noise of the report.
    pub chi_square: f64,
    /// Degrees of freedom.
    pub dof: usize,
    /// Probability of a chi-square (or lack-of-fit F) as large by chance; `None` where only residuals tell the noise.
    pub p: Option<f64>,
    /// Residual of each row, in the sensor's unit.
    pub residuals: Vec<f64>,
}

/// The noise floor of the first sensor, and where it comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseFloor {
    /// Standard deviation of a reading, in the sensor's unit (root mean square where readings differ); `None` where nothing tells.
    pub sd: Option<f64>,
    /// Where it comes from.
    pub from: NoiseFrom,
}

/// What is unexplained.
#[derive(Debug, Clone)]
pub struct Unexplained {
    /// In one sentence.
    pub pattern: String,
    /// Mean residual at each distinct state of the joints, the most significant first.
    pub cells: Vec<Cell>,
    /// Candidates that come nearest, with the share of the sum of squares that they take off together: not accepted.
    pub nearest: Vec<Candidate>,
    /// That share.
    pub nearest_explains: f64,
}

/// One look at the evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// Regressors in the model beyond the given one.
    pub with: Vec<String>,
    /// The strongest further candidate, its t and its family-wise p.
    pub strongest: Option<(String, f64, f64)>,
    /// The global test of what is left.
    pub global_p: Option<f64>,
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
    /// What is unexplained.
    pub unexplained: Option<Unexplained>,
    /// Leave-one-position-out prediction.
    pub holdout: Option<Holdout>,
    /// The search's record.
    pub steps: Vec<Step>,
    /// How many candidates, and how many distinct ones among them.
    pub candidates: (usize, usize),
    /// Estimated parameters before and after.
    pub changes: Vec<Change>,
    /// Positions that would make a diagnosis possible, best first.
    pub would_help: Vec<Vec<JointState>>,
}

/// Candidates that are mostly in the model already are the less plausible the less of them is left.
const MOSTLY_ABSORBED: f64 = 1e-2;
/// Passes of search and repair: columns that depend on the tilts follow the repaired ones.
const PASSES: usize = 3;

/// Diagnose a campaign with a catalogue (see `wire::built_in_effects`).
///
/// Errors: those of [`fit::fit`]; a significance outside (0, 1); a catalogue's term with a name that this campaign does not have.
pub fn diagnose(campaign: &Campaign, catalogue: &[Effect], settings: &Settings) -> Result<Diagnosis> {
    if !(settings.significance > 0.0 && settings.significance < 1.0) {
        return Err(Malformed::new(Fault::Value, "the significance is no probability")
            .expected("a number between 0 and 1, for example 0.01")
            .found(settings.significance.to_string()));
    }
    let mut free = campaign.clone();
    free.constraints.clear();
    let campaign = &free;
    let before = fit_exactly(campaign)?;
    let model = Model::new(campaign)?;
    let levels = Levels::of(settings.significance);
    let mut point = before.design.point.clone();
    let mut scales: Option<Vec<Option<f64>>> = None;
    let mut steps = Vec::new();
    let mut result: Option<(Look, Option<(Campaign, Fit)>)> = None;
    let mut named: Option<Vec<String>> = None;
    for _ in 0..PASSES {
        let look = look(campaign, catalogue, &model, &point, scales.as_deref(), levels, &mut steps)?;
        let Found::Set { set, .. } = &look.found else {
            result = Some((look, None));
            break;
        };
        let effects: Vec<&Candidate> = set.iter().filter_map(|j| look.candidates.get(*j)).collect();
        let names: Vec<String> = effects.iter().map(|c| c.regressor.clone()).collect();
        let repaired = repair::repair(campaign, &effects)?;
        let after = fit_exactly(&repaired)?;
        for (value, parameter) in point.iter_mut().zip(campaign.estimated()) {
            if let Some(found) = repaired.parameter_index(&parameter.id).and_then(|k| after.point.get(k)) {
                *value = *found;
            }
        }
        scales = Some(after.estimate.group_scale.clone());
        let settled = named.as_ref() == Some(&names);
        named = Some(names);
        result = Some((look, Some((repaired, after))));
        if settled {
            break;
        }
    }
    let Some((look, repaired)) = result else {
        return Err(Malformed::new(Fault::Value, "the search made no pass"));
    };
    finding::conclude(campaign, before, look, repaired, steps)
}

/// One pass at one point: candidates, their arena, what was found.
pub(crate) struct Look {
    candidates: Vec<Candidate>,
    arena: Arena,
    weighted: Weighted,
    design: design::DesignMatrix,
    found: Found,
}

fn look(
    campaign: &Campaign,
    catalogue: &[Effect],
    model: &Model,
    point: &[f64],
    scales: Option<&[Option<f64>]>,
    levels: Levels,
    record: &mut Vec<Step>,
) -> Result<Look> {
    let design = design::assemble(campaign, model, point)?;
    let weighted = noise::weigh(campaign, &design, scales)?;
    let mut candidates = candidates::build(campaign, catalogue, model, &design, weighted.weight.len())?;
    let mut arena = {
        let columns: Vec<&Vec<f64>> = candidates.iter().map(|c| &c.column).collect();
        Arena::new(&weighted, &columns)
    };
    for (candidate, visible) in candidates.iter_mut().zip(arena.pool.visible()) {
        candidate.vanishing |= *visible < MOSTLY_ABSORBED;
    }
    let columns: Vec<&Vec<f64>> = candidates.iter().map(|c| &c.column).collect();
    let handicap: Vec<f64> = candidates
        .iter()
        .map(|candidate| {
            let small = if candidate.vanishing { 5.0 } else { 0.0 };
            let rounding = if candidate.rounding { 5.0 } else { 0.0 };
            0.4 * f64::from(candidate.rank) + small + rounding
        })
        .collect();
    let mut steps = Vec::new();
    let found = if weighted.estimate.dof == 0 {
        Found::Nothing
    } else {
        let positions = noise::positions(campaign, &design, weighted.weight.len());
        let support = Support { weighted: &weighted, columns: &columns, positions: &positions };
        search::search(&mut arena, levels, &handicap, &support, &mut steps)
    };
    let name = |j: usize| candidates.get(j).map_or(String::new(), |c: &Candidate| c.regressor.clone());
    record.clear();
    record.extend(steps.iter().map(|step| Step {
        with: step.set.iter().map(|j| name(*j)).collect(),
        strongest: step.strongest.map(|(j, t, p)| (name(j), t, p)),
        global_p: step.global,
    }));
    Ok(Look { candidates, arena, weighted, design, found })
}

/// Every candidate for this campaign at its fitted model, with the standard uncertainty that its coefficient would have in it.
///
/// What a schedule can see: an effect of less than five of these hides in the noise. Infinite where the model absorbs it.
/// Errors: as [`diagnose`].
pub fn candidates(campaign: &Campaign, catalogue: &[Effect]) -> Result<Vec<(Candidate, f64)>> {
    let fit = fit_exactly(campaign)?;
    let model = Model::new(campaign)?;
    let mut point = fit.point.clone();
    point.truncate(fit.design.point.len());
    let design = design::assemble(campaign, &model, &point)?;
    let weighted = noise::weigh(campaign, &design, None)?;
    let mut candidates = candidates::build(campaign, catalogue, &model, &design, weighted.weight.len())?;
    let arena = {
        let columns: Vec<&Vec<f64>> = candidates.iter().map(|c| &c.column).collect();
        Arena::new(&weighted, &columns)
    };
    for (candidate, visible) in candidates.iter_mut().zip(arena.pool.visible()) {
        candidate.vanishing |= *visible < MOSTLY_ABSORBED;
    }
    let norm = |candidate: &Candidate| {
        let largest = candidate.column.iter().fold(0.0_f64, |largest, v| largest.max(v.abs()));
        let square = |(v, w): (&f64, &f64)| (v / largest * w) * (v / largest * w);
        candidate.column.iter().zip(&weighted.weight).map(square).sum::<f64>().sqrt() * largest
    };
    let u: Vec<f64> =
        candidates.iter().zip(arena.pool.visible()).map(|(c, visible)| 1.0 / (norm(c) * visible)).collect();
    Ok(candidates.into_iter().zip(u).collect())
}

/// Gauss-Newton to the exact model, or the linear estimator where that does not converge.
fn fit_exactly(campaign: &Campaign) -> Result<Fit> {
    let exact = fit::fit(campaign, &fit::Settings { exact: true, ..fit::Settings::default() })?;
    if exact.convergence.as_ref().is_some_and(|record| record.converged) {
        return Ok(exact);
    }
    fit::fit(campaign, &fit::Settings::default())
}
