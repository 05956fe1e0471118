//! The gap step by step: as given, after the first effect, after the second, with the model line growing.

use super::augmented::{Seen, State};
use super::common::Step;
use super::evidence::Evidence;
use super::settings::Settings;
use super::{Candidate, Gap, fit_exactly, repair};
use crate::campaign::Campaign;
use crate::elements::Parts;
use crate::error::Result;
use crate::fit::Fit;
use std::collections::BTreeMap;

/// The gap with some effects in the model.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "GapStepReport")]
#[non_exhaustive]
pub struct GapStep {
    /// Effects in the model.
    pub with: Vec<String>,
    /// Each sensor's model line.
    pub model: BTreeMap<String, String>,
    /// The gap.
    pub gap: Gap,
    /// The strongest further candidate.
    pub strongest: Option<String>,
    /// Its t.
    pub t: Option<f64>,
    /// Its probability by chance among all that was tried.
    pub p: Option<f64>,
    /// Probability of what is left by chance.
    pub global_p: Option<f64>,
    /// What was decided here, and why.
    pub decision: String,
}

/// Why nothing is added after the last effect, from what the posterior says once all that is named is in the model.
fn last(seen: &Seen, settings: &Settings, name: impl Fn(usize) -> String) -> String {
    let (further, outside) = (short(seen.further), short(seen.outside));
    let probable = seen.suspected.iter().reduce(|best, next| if next.1 > best.1 { next } else { best });
    match (seen.state, probable) {
        (_, Some((j, p))) if *p >= settings.probability => {
            format!(
                "{} is suspected: its value is not significantly different from zero, with the unexplained residuals in its uncertainty",
                name(*j)
            )
        }
        (_, Some((j, p))) => {
            // cut, not rounded: 0.9497 is below 0.95
            let (level, p) = (settings.probability, (1e3 * p).floor() / 1e3);
            format!("{} is suspected: its probability is {p}; an effect is named from {level}", name(*j))
        }
        _ if seen.outside >= settings.suspected => format!(
            "with probability {outside} the residuals follow a pattern that no candidate has, and no further candidate is probable"
        ),
        (State::Outside, _) => format!("an effect is missing with probability {further}, but no candidate is probable"),
        _ => format!("no further effect is added: the probability that another effect is missing is {further}"),
    }
}

/// One step for each effect in this order, and one before them.
pub(super) fn steps(
    campaign: &Campaign,
    (before, after): (&Fit, Option<&Fit>),
    seen: &Seen,
    set: &[usize],
    settings: &Settings,
) -> Result<Vec<GapStep>> {
    let Seen { candidates, evidence, weighted, .. } = seen;
    // one effect in several sensors is added to one after the other
    let several = |c: &Candidate| {
        set.iter().filter_map(|j| candidates.get(*j)).filter(|other| other.regressor == c.regressor).count() > 1
    };
    let name = |j: usize| {
        candidates.get(j).map_or(String::new(), |c| match c.sensor.filter(|_| several(c)) {
            Some(sensor) => format!("{} of {}", c.regressor, campaign.sensor_id(sensor)),
            None => c.regressor.clone(),
        })
    };
    let found = evidence.given(set);
    let mut steps = Vec::with_capacity(set.len() + 1);
    for count in 0..=set.len() {
        let members = set.part(..count);
        let between;
        let fit = match (count, after) {
            (0, _) => before,
            (_, Some(after)) if count == set.len() => after,
            _ => {
                let effects: Vec<&Candidate> = members.iter().filter_map(|j| candidates.get(*j)).collect();
                between = fit_exactly(&repair::repaired(campaign, &effects)?)?;
                &between
            }
        };
        let given = evidence.given(members);
        let plain = |j: usize| candidates.get(j).is_some_and(|c| !c.vanishing);
        let strongest = given.as_ref().and_then(|given| evidence.strongest_of(given, plain));
        let global_p = given.as_ref().zip(found.as_ref()).and_then(|(given, found)| evidence.global(given, found));
        let residuals = || fit.estimate.residuals.iter().take(fit.design.rows.len());
        let square: f64 = residuals().map(|v| v * v).sum();
        let dof = fit.estimate.dof;
        let model = fit.campaign.bench.sensors.iter().map(|s| (s.id.clone(), s.model.to_string())).collect();
        let decision = match set.get(count) {
            Some(next) => format!("{} is added", name(*next)),
            None => last(seen, settings, name),
        };
        let with = members.iter().map(|j| name(*j)).collect();
        let Step { with, strongest, t, p, global_p } =
            Step::new(with, strongest.map(|(j, t, p)| (name(j), t, p)), global_p);
        let gap = Gap {
            rms: (dof > 0).then(|| (square / dof as f64).sqrt()),
            max: residuals().fold(0.0_f64, |max, v| max.max(v.abs())),
            chi_square: weighted.squares(&fit.estimate.residuals),
            dof,
            p: global_p,
            residuals: Vec::new(),
        };
        steps.push(GapStep { with, model, gap, strongest, t, p, global_p, decision });
    }
    Ok(steps)
}

/// The order in which effects take off most, one after another.
pub(super) fn order(evidence: &Evidence, set: &[usize]) -> Vec<usize> {
    let mut ordered: Vec<usize> = Vec::with_capacity(set.len());
    while ordered.len() < set.len() {
        let left = |j: &usize| {
            let longer: Vec<usize> = ordered.iter().copied().chain([*j]).collect();
            evidence.rss_of(&longer)
        };
        let remaining = set.iter().filter(|j| !ordered.contains(j));
        match remaining.min_by(|a, b| left(a).total_cmp(&left(b))) {
            Some(next) => ordered.push(*next),
            None => break,
        }
    }
    ordered
}

fn short(p: f64) -> String {
    match p {
        p if p < 0.01 => format!("{p:.1e}"),
        p if p > 0.99 => "above 0.99".to_string(),
        p => format!("{p:.2}"),
    }
}
