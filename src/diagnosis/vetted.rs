//! The last word on names: each must be probable enough, against noise and, where something is left, against that too.
//!
//! A search looks for what explains the gap; a name also says that nothing else does. A member that is not clearly more probable than every
//! other explanation is taken back, and what it explained is unexplained again. Where the rest follows the order of time, it is no noise, and
//! all names must stand against it.

use super::candidate::Candidate;
use super::criteria::{Question, without};
use super::noise::Weighted;
use super::pass::{Outcome, Pass, Seen};
use super::posterior::{self, Posterior};
use super::repair::repaired;
use super::search::Found;
use super::serial::{self, Serial};
use super::sets::Rival;
use super::settings::Settings;
use super::stepwise;
use super::support::Support;
use crate::campaign::Campaign;
use crate::design::DesignMatrix;
use crate::error::Result;

/// An outcome without the names that do not stand.
pub(super) fn vetted(
    pass: &Pass<'_>,
    campaign: &Campaign,
    (mut seen, mut repair): Outcome,
    settings: &Settings,
) -> Result<Outcome> {
    // where variances of what scatters are estimated, the search itself has compared with them
    while let (Found::Set { set, rivals, complete, nearest, approximate }, Some((_, after)), false) =
        (&seen.found, &repair, seen.evidence.has_strata())
    {
        let own: Vec<f64> = after.estimate.residuals.iter().take(after.design.rows.len()).copied().collect();
        let whole = *complete && pattern(campaign, &seen.design, &seen.weighted, &own, settings).is_none();
        let sure: Vec<usize> = probabilities(&seen, set, rivals, whole, settings)
            .into_iter()
            .zip(set)
            .filter(|(p, _)| *p >= settings.probability)
            .map(|(_, j)| *j)
            .collect();
        if sure.len() == set.len() {
            break;
        }
        let taken_back = set.iter().filter(|j| !sure.contains(j)).chain(nearest).copied().collect();
        let approximate = approximate.clone();
        if sure.is_empty() {
            seen.found = Found::Unexplained { nearest: taken_back, approximate };
            repair = None;
            break;
        }
        let members: Vec<&Candidate> = sure.iter().filter_map(|j| seen.candidates.get(*j)).collect();
        let shorter = repaired(campaign, &members)?;
        let after = pass.fit(&shorter, &seen, &sure)?;
        let rivals = stepwise::rivals(&seen.evidence, &sure, settings);
        seen.found = Found::Set { set: sure, rivals, complete: false, nearest: taken_back, approximate };
        repair = Some((shorter, after));
    }
    Ok((seen, repair))
}

/// Of each member, that it or one of its aliases is present.
fn probabilities(seen: &Seen, set: &[usize], rivals: &[Rival], whole: bool, settings: &Settings) -> Vec<f64> {
    let columns: Vec<&Vec<f64>> = seen.candidates.iter().map(|c| &c.column).collect();
    let basis = seen.weighted.estimate.factor.thin_q();
    let support = Support { weighted: &seen.weighted, basis, columns: &columns, positions: &[], hangs: settings.hangs };
    let question = Question::without_families(settings, &seen.plausibility_penalty, Some(&support));
    let own = |(place, member): (usize, &usize)| {
        let posterior = posterior::of(&seen.evidence, &without(set, place), *member, whole, &question);
        with_aliases(&posterior, *member, |j| rivals.iter().any(|own| own.place == place && own.candidate == j))
    };
    set.iter().enumerate().map(own).collect()
}

/// Probability of a member's class, as far as its aliases are listed or resemble it.
pub(super) fn with_aliases(posterior: &Posterior, member: usize, listed: impl Fn(usize) -> bool) -> f64 {
    let further: f64 = posterior.of.iter().filter(|(j, _)| *j == member || listed(*j)).map(|(_, p)| p).sum();
    posterior.probability.max(further).min(1.0)
}

/// What the residuals of the finished model follow in time, if it is significant.
pub(super) fn pattern(
    campaign: &Campaign,
    design: &DesignMatrix,
    weighted: &Weighted,
    residuals: &[f64],
    settings: &Settings,
) -> Option<Serial> {
    let standardised: Vec<f64> = match &weighted.floor {
        None => residuals.iter().zip(&weighted.weight).map(|(v, w)| v * w).collect(),
        Some(_) => weighted.whiten(residuals),
    };
    serial::serial(campaign, design, &standardised).filter(|own| own.p <= settings.serial())
}
