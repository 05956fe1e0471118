//! Search and repair in turn, until the names settle: columns depend on the tilts, and the tilts on what is in the model.

use super::evidence::Evidence;
use super::noise::{NoiseFrom, Weighted};
use super::pass::{Outcome, Pass, Seen};
use super::repair::repaired;
use super::search::Found;
use super::settings::Settings;
use super::{Candidate, fit_exactly, stepwise, vetted};
use crate::campaign::Campaign;
use crate::elements::Elements;
use crate::error::Result;
use crate::fit::{self, Estimator, Fit};
use crate::simulate::Regressor;
use crate::uncertainty::quantiles::chi_square_survival;

/// Passes until the names must have settled.
const PASSES: usize = 6;
/// Sets whose repair may fail before the search is left as it is.
const BROKEN: usize = 8;
/// Tilts and known values that are tried in the place of one whose exact fit did not do what its column promised.
const RIVALS: usize = 6;
/// Effects that jump which are tried as the first of a set.
const JUMPS: usize = 2;

/// Tilts that are tried by themselves.
const TILTS: usize = 2;

/// Pass until the names settle; where something stays unexplained, or several effects explain it, again from where others would put the model.
///
/// A gap moves the tilts. Where a schedule hardly determines them it moves them far: the rows are then no longer straight between the given
/// model and the repaired one, and an effect that jumps with a small input (`sign(w_S)`) has another column.
pub(super) fn run(pass: &mut Pass<'_>, campaign: &Campaign, settings: &Settings) -> Result<Outcome> {
    let outcome = searched(pass, campaign, settings)?;
    vetted::vetted(pass, campaign, outcome, settings)
}

fn searched(pass: &mut Pass<'_>, campaign: &Campaign, settings: &Settings) -> Result<Outcome> {
    let home = pass.stand();
    let first = settle(pass, campaign, settings)?;
    let is_tilt = |j: &usize| first.0.candidates.get(*j).is_some_and(|c| matches!(c.kind, Regressor::Tilt(_)));
    let whole = match &first.0.found {
        // one effect that explains everything needs no other place to stand, nor one beside a tilt
        Found::Set { complete: true, set, .. } if set.len() < 2 || (set.len() == 2 && set.iter().any(is_tilt)) => {
            return Ok(first);
        }
        Found::Set { complete, .. } => *complete,
        Found::Unexplained { .. } => false,
        Found::Nothing => return Ok(first),
    };
    let mut hypotheses = tilted(&first.0);
    let strong = hypotheses.len();
    match &first.0.found {
        Found::Unexplained { approximate, .. } | Found::Set { approximate, complete: false, .. } => {
            hypotheses.extend(approximate.clone());
        }
        _ => {}
    }
    hypotheses.extend(jumping(&first.0.candidates, &first.0.evidence));
    let weighted = first.0.weighted.clone();
    let price = |outcome: &Outcome| price_in_all(outcome, &weighted, settings);
    let mut best = whole.then(|| price(&first)).flatten();
    let mut chosen = None;
    for (k, set) in hypotheses.iter().enumerate() {
        let effects = members(&first.0, set);
        let repaired = repaired(campaign, &effects)?;
        // only where to stand: one linear step says that well enough, but for a tilt that is most of the gap
        let after = match k < strong {
            true => fit_exactly(&repaired)?,
            false => fit::fit(&repaired, &fit::Settings { estimator: Estimator::Linear, ..fit::Settings::default() })?,
        };
        pass.go_back(home.clone());
        pass.stand_at(&repaired, &effects, &after);
        // from a point that only a hypothesis gave, nothing less than a complete explanation counts
        let there = pass.see()?;
        let Found::Set { complete: true, set, .. } = &there.found else { continue };
        let promised =
            super::criteria::misfit(&there.evidence, set, there.evidence.rss_of(set)) + prices(&there, set, settings);
        if whole && best.is_some_and(|best| promised >= best) {
            continue;
        }
        let again = settle(pass, campaign, settings)?;
        if again.1.is_some() && matches!(again.0.found, Found::Set { complete: true, .. }) {
            let own = price(&again);
            if best.is_none_or(|best| own.is_some_and(|own| own < best)) {
                (best, chosen) = (own, Some(again));
            }
            if !whole {
                break;
            }
        }
    }
    Ok(chosen.unwrap_or(first))
}

/// Twice the negative logarithm of an outcome's posterior probability, but for a constant: what the exact fit leaves, in these weights, and
/// the price of each effect.
fn price_in_all((seen, repaired): &Outcome, weighted: &Weighted, settings: &Settings) -> Option<f64> {
    let (_, after) = repaired.as_ref()?;
    let Found::Set { set, .. } = &seen.found else { return None };
    let rss = weighted.squares(&after.estimate.residuals);
    Some(super::criteria::misfit(&seen.evidence, set, rss) + prices(seen, set, settings))
}

/// Prices and plausibility penalties of the members of a set.
fn prices(seen: &Seen, set: &[usize], settings: &Settings) -> f64 {
    let plausibility_penalty = |j: &usize| seen.plausibility_penalty.at(*j);
    set.iter().map(|j| super::criteria::price(&seen.evidence, *j, settings) + plausibility_penalty(j)).sum()
}

/// Tilts each of which takes off most of the gap by itself: where they stand, the inputs of everything else are others.
fn tilted(seen: &Seen) -> Vec<Vec<usize>> {
    let is_tilt = |j: &usize| seen.candidates.get(*j).is_some_and(|c| matches!(c.kind, Regressor::Tilt(_)));
    let square = |j: &usize| seen.evidence.pool.scores().get(*j).map_or(0.0, |s| s * s);
    let mut tilts: Vec<usize> = (0..seen.candidates.len()).filter(is_tilt).collect();
    tilts.retain(|j| square(j) > 0.5 * seen.evidence.rss);
    tilts.sort_by(|a, b| square(b).total_cmp(&square(a)));
    tilts.into_iter().take(TILTS).map(|j| vec![j]).collect()
}

fn settle(pass: &mut Pass<'_>, campaign: &Campaign, settings: &Settings) -> Result<Outcome> {
    let mut before: Option<(Vec<String>, Seen, Campaign, Fit)> = None;
    let (mut passes, mut broken) = (0, 0);
    loop {
        let mut seen = pass.see()?;
        let Found::Set { set, .. } = &seen.found else {
            return Ok(match before {
                // a column that jumps may leave the place where it was found; what counts is the exact model
                Some((_, found, repaired, after)) if is_complete(&found, &after, settings) => {
                    (found, Some((repaired, after)))
                }
                _ => (seen, None),
            });
        };
        let names = names(&seen, set);
        if let Some((_, _, repaired, after)) = before.take_if(|(own, ..)| *own == names) {
            return Ok((seen, Some((repaired, after))));
        }
        let effects = members(&seen, set);
        let mut repaired = repaired(campaign, &effects)?;
        let mut after = pass.fit(&repaired, &seen, set)?;
        if !pass.is_confirmed(&seen, set, &after)
            && let Some((found, other, fit)) = confirmed_rival(pass, campaign, &seen)?
        {
            (seen.found, repaired, after) = (found, other, fit);
        }
        let Found::Set { set, .. } = &seen.found else { return Ok((seen, None)) };
        if !pass.keeps_its_promise(&seen, set, &after) && broken < BROKEN {
            broken += 1;
            continue;
        }
        let (names, effects) = (self::names(&seen, set), members(&seen, set));
        passes += 1;
        pass.stand_at(&repaired, &effects, &after);
        if passes == PASSES {
            return Ok((seen, Some((repaired, after))));
        }
        before = Some((names, seen, repaired, after));
    }
}

fn members<'a>(seen: &'a Seen, set: &[usize]) -> Vec<&'a Candidate> {
    set.iter().filter_map(|j| seen.candidates.get(*j)).collect()
}

/// What tells sets apart from pass to pass.
fn names(seen: &Seen, set: &[usize]) -> Vec<String> {
    let name = |c: &&Candidate| format!("{} {:?} {}", c.regressor, c.sensor, c.coefficient);
    let mut names: Vec<String> = members(seen, set).iter().map(name).collect();
    names.sort();
    names
}

/// Tilts and known values that the readings do not tell apart linearly put the inputs in different places: of those that could stand in the
/// place of a member the first with which the exact fit does what its columns promise.
fn confirmed_rival(pass: &Pass<'_>, campaign: &Campaign, seen: &Seen) -> Result<Option<(Found, Campaign, Fit)>> {
    let Found::Set { set, rivals, complete, nearest, approximate } = &seen.found else { return Ok(None) };
    let moves =
        |j: &usize| seen.candidates.get(*j).is_some_and(|c| matches!(c.kind, Regressor::Tilt(_) | Regressor::Known(_)));
    for rival in rivals.iter().filter(|own| own.with.is_empty() && moves(&own.candidate)).take(RIVALS) {
        let other = rival.replaced(set);
        let effects = members(seen, &other);
        let repaired = repaired(campaign, &effects)?;
        let after = pass.fit(&repaired, seen, &other)?;
        if pass.is_confirmed(seen, &other, &after) {
            let found = Found::Set {
                rivals: stepwise::rivals(&seen.evidence, &other, pass.settings()),
                set: other,
                complete: *complete,
                nearest: nearest.clone(),
                approximate: approximate.clone(),
            };
            return Ok(Some((found, repaired, after)));
        }
    }
    Ok(None)
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
