//! Search and repair in turn, until the names settle: columns depend on the tilts, and the tilts on what is in the model.

use super::evidence::Evidence;
use super::noise::NoiseFrom;
use super::pass::{Pass, Seen};
use super::search::Found;
use super::settings::Settings;
use super::{Candidate, assumptions, fit_exactly, repair};
use crate::campaign::Campaign;
use crate::error::Result;
use crate::fit::{self, Estimator, Fit};
use crate::simulate::Regressor;
use crate::uncertainty::quantiles::chi_square_survival;

/// Passes until the names must have settled.
const PASSES: usize = 6;
/// Sets whose repair may fail before the search is left as it is.
const BROKEN: usize = 8;
/// Effects that jump which are tried as the first of a set.
const JUMPS: usize = 2;

/// What a pass saw, and the repaired campaign with its exact fit if effects were found.
pub(super) type Outcome = (Seen, Option<(Campaign, Fit)>);

/// Pass until the names settle; where something stays unexplained, again from where the nearest sets would put the model.
///
/// A gap moves the tilts. Where a schedule hardly determines them it moves them far: the rows are then no longer straight between the given
/// model and the repaired one, and an effect that jumps with a small input (`sign(w_S)`) has another column.
pub(super) fn run(pass: &mut Pass<'_>, campaign: &Campaign, settings: &Settings) -> Result<Outcome> {
    let home = pass.stand();
    let first = settle(pass, campaign, settings)?;
    let mut hypotheses = match &first.0.found {
        Found::Unexplained { approximate, .. } | Found::Set { approximate, complete: false, .. } => approximate.clone(),
        _ => return Ok(first),
    };
    hypotheses.extend(jumping(&first.0.candidates, &first.0.evidence));
    for set in hypotheses {
        let effects: Vec<&Candidate> = set.iter().filter_map(|j| first.0.candidates.get(*j)).collect();
        // only where to stand: one linear step says that well enough
        let repaired = repaired(campaign, &effects)?;
        let after = fit::fit(&repaired, &fit::Settings { estimator: Estimator::Linear, ..fit::Settings::default() })?;
        pass.go_back(home.clone());
        pass.stand_at(&repaired, &effects, &after);
        // from a point that only a hypothesis gave, nothing less than a complete explanation counts
        if !matches!(pass.see()?.found, Found::Set { complete: true, .. }) {
            continue;
        }
        let again = settle(pass, campaign, settings)?;
        if again.1.is_some() && matches!(again.0.found, Found::Set { complete: true, .. }) {
            return Ok(again);
        }
    }
    Ok(first)
}

fn settle(pass: &mut Pass<'_>, campaign: &Campaign, settings: &Settings) -> Result<Outcome> {
    let mut before: Option<(Vec<String>, Seen, Campaign, Fit)> = None;
    let (mut passes, mut broken) = (0, 0);
    loop {
        let seen = pass.see()?;
        let Found::Set { set, .. } = &seen.found else {
            return Ok(match before {
                // a column that jumps may leave the place where it was found; what counts is the exact model
                Some((_, found, repaired, after)) if is_complete(&found, &after, settings) => {
                    (found, Some((repaired, after)))
                }
                _ => (seen, None),
            });
        };
        let effects: Vec<&Candidate> = set.iter().filter_map(|j| seen.candidates.get(*j)).collect();
        let mut names: Vec<String> =
            effects.iter().map(|c| format!("{} {:?} {}", c.regressor, c.sensor, c.coefficient)).collect();
        names.sort();
        if let Some((_, _, repaired, after)) = before.take_if(|(own, ..)| *own == names) {
            return Ok((seen, Some((repaired, after))));
        }
        let repaired = repaired(campaign, &effects)?;
        let after = fit_exactly(&repaired)?;
        if !pass.keeps_its_promise(&seen, set, &after) && broken < BROKEN {
            broken += 1;
            continue;
        }
        passes += 1;
        pass.stand_at(&repaired, &effects, &after);
        if passes == PASSES {
            return Ok((seen, Some((repaired, after))));
        }
        before = Some((names, seen, repaired, after));
    }
}

/// Does the exact fit with the effects leave nothing but the stated noise?
fn is_complete(seen: &Seen, after: &Fit, settings: &Settings) -> bool {
    let weighted = seen.weighted.squares(&after.estimate.residuals);
    seen.weighted.from == NoiseFrom::Stated
        && chi_square_survival(weighted, after.estimate.dof as f64).is_some_and(|p| p > settings.whole())
}

/// The strongest effects that jump where a small input changes its sign, alone and with what would then be missing.
fn jumping(candidates: &[Candidate], evidence: &Evidence) -> Vec<Vec<usize>> {
    let jumps = |c: &Candidate| match &c.kind {
        Regressor::Term(line) => {
            line.text().contains("sign(") && line.names().iter().any(|n| n.starts_with("w_") || n.starts_with("a_"))
        }
        _ => false,
    };
    let score = |j: usize| evidence.pool.scores().get(j).map_or(0.0, |s| s.abs());
    let mut jumping: Vec<usize> =
        candidates.iter().enumerate().filter(|(j, c)| jumps(c) && score(*j) > 0.0).map(|(j, _)| j).collect();
    jumping.sort_by(|a, b| score(*b).total_cmp(&score(*a)));
    let mut sets = Vec::new();
    for j in jumping.into_iter().take(JUMPS) {
        sets.push(vec![j]);
        let further = evidence.given(&[j]).and_then(|given| evidence.strongest(&given));
        sets.extend(further.map(|further| vec![j, further.index]));
    }
    sets
}

/// The campaign with these effects in its model, and without the priors and constraints that are among them.
pub(super) fn repaired(campaign: &Campaign, effects: &[&Candidate]) -> Result<Campaign> {
    let freed = assumptions::freed(campaign, effects);
    let terms: Vec<&Candidate> = effects.iter().filter(|c| !assumptions::is_assumption(c)).copied().collect();
    repair::repair(&freed, &terms)
}
