//! From a search to a diagnosis: findings with aliases, the gap before and after, what the repair does to each parameter; the gap step by step: as given, after
//! the first effect, after the second, with the model line growing.

use super::ambiguity::{Rival, Shifts};
use super::augmented::{Seen, State};
use super::common::{NoiseFrom, Settings};
use super::noise::Weighted;
use super::places::by_chance;
use super::repair::{beyond_noise, coefficient, repaired};
use super::score::{Remainder, Score, VISIBLE};
use super::separate::Separation;
use super::{Candidate, Diagnosis, Gap, NoiseFloor, Suspect, Unexplained, Verdict};
use super::{fit_exactly, holdout, places, separate};
use crate::campaign::{Campaign, Constraint, Kind, Role};
use crate::elements::{Elements, Parts};
use crate::error::Result;
use crate::fit::{self, Fit};
use crate::linear::{dot, norm, normalise, project};
use crate::simulate::Regressor;
use crate::uncertainty::quantiles::{chi_square_survival, fisher_f_survival};
use std::collections::BTreeMap;

/// Another effect that explains the same.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "AliasReport")]
pub struct Alias {
    /// Its regressor.
    pub regressor: String,
    /// Its name.
    pub name: String,
    /// The same column exactly (true), or only a fit that is not significantly worse (false).
    pub exact: bool,
    /// How much worse it fits, in variances of the noise.
    pub excess: f64,
    /// Posterior probability that it is the effect.
    pub probability: f64,
    /// Is it seen only through small terms (it vanishes here but for small tilts, or the model has nearly all of it)?
    #[serde(rename = "only_small_terms")]
    pub vanishing: bool,
    /// Share of its column that the model as given leaves, 0 to 1.
    pub visible: f64,
    /// Largest value of its term here over what its inputs could make of it, a pure number.
    pub size: f64,
    /// A second effect that must then replace another one that was found.
    pub together_with: Option<String>,
}

/// A missing effect.
#[derive(Debug, Clone)]
pub struct Finding {
    /// The effect.
    pub effect: Candidate,
    /// Its coefficient in the repaired model; for a known parameter the change; `None` where it is not estimable.
    pub value: Option<f64>,
    /// Standard uncertainty.
    pub u: Option<f64>,
    /// Unit of the coefficient; empty where the model line does not tell.
    pub unit: String,
    /// Student's t (z where the noise is stated) given the other effects and the most probable remainder.
    pub t: f64,
    /// Family-wise probability of evidence as strong by chance.
    pub p: f64,
    /// Share of the gap's sum of squares that it takes off, the others given.
    pub explains: f64,
    /// Posterior probability that it or one of its aliases is present.
    pub probability: f64,
    /// What else it could be.
    pub aliases: Vec<Alias>,
    /// Positions that would tell the aliases apart.
    pub separation: Separation,
    /// The same effect in further sensors of the unit, by their sizes.
    pub also: Vec<Finding>,
}

/// One term in several sensors is one finding, with its size in each: the first stays, the others join it.
fn common(findings: Vec<Finding>) -> Vec<Finding> {
    let mut merged: Vec<Finding> = Vec::with_capacity(findings.len());
    for finding in findings {
        let is_term = matches!(
            finding.effect.kind,
            Regressor::Term(_) | Regressor::Approach(_) | Regressor::Change { .. } | Regressor::Position(_)
        );
        let same = |other: &&mut Finding| {
            is_term
                && other.effect.regressor == finding.effect.regressor
                && other.effect.sensor != finding.effect.sensor
        };
        match merged.iter_mut().find(same) {
            Some(first) => {
                first.explains += finding.explains;
                first.also.push(finding);
            }
            None => merged.push(finding),
        }
    }
    merged
}

/// An estimated parameter before and after the repair.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Its name.
    pub id: String,
    /// Is it a tilt (radians)?
    pub is_angle: bool,
    /// Its unit.
    pub unit: String,
    /// Value and standard uncertainty before.
    pub before: (Option<f64>, Option<f64>),
    /// Value and standard uncertainty after, if the effects are the ones named.
    pub after: (Option<f64>, Option<f64>),
    /// How far the value would move at most if an alias were the effect.
    pub alias_half_width: f64,
    /// Standard deviation of the value over the explanations that remain, each with its probability.
    pub alias_u: f64,
    /// Standard uncertainty from what is unexplained, beyond that of the noise.
    pub remainder_u: f64,
}

impl Change {
    /// Standard uncertainty after, with what is not known about the alias and about the rest: root sum of squares.
    pub(crate) fn u_in_all(&self) -> Option<f64> {
        self.after.1.map(|u| u.hypot(self.alias_u).hypot(self.remainder_u))
    }
}

pub(super) fn conclude(
    campaign: &Campaign,
    before: Fit,
    seen: Seen,
    repaired: Option<(Campaign, Fit)>,
    settings: &Settings,
) -> Result<Diagnosis> {
    let Seen { candidates, score, weighted, design, suspected, deviations, .. } = &seen;
    let named: Vec<usize> = seen.named.iter().map(|(j, _)| *j).collect();
    let ordered = if repaired.is_some() { order(score, &named) } else { Vec::new() };
    let set: &[usize] = &ordered;
    // standard uncertainty of each row by the noise floor
    let scale: Vec<f64> = weighted.weight.iter().map(|w| 1.0 / w).collect();
    let finished = repaired.as_ref().map_or(&before, |(_, after)| after);
    let pure = pure_error(weighted, finished, set.iter().filter_map(|j| candidates.get(*j)));
    let gap_before = gap(&before, weighted, pure);
    let gap_after = repaired.as_ref().map_or_else(|| gap_before.clone(), |(_, after)| gap(after, weighted, pure));
    let verdict = match seen.state {
        _ if weighted.estimate.dof == 0 => Verdict::NotDiagnosable,
        State::Nothing => Verdict::NothingMissing,
        // what is suspected may explain the rest, or chance; where the noise is known by itself, the residuals must not contradict chance
        State::Named
            if seen.further < settings.suspected
                || (seen.unaccounted < settings.suspected
                    && gap_after.p.is_none_or(|p| p >= settings.significance)) =>
        {
            Verdict::EffectsFound
        }
        State::Named => Verdict::PartlyExplained,
        State::Suspected | State::Outside => Verdict::Unexplained,
    };
    let is_left = matches!(verdict, Verdict::PartlyExplained | Verdict::Unexplained);
    let sd = noise_sd(weighted, finished);
    let unexplained = is_left.then(|| {
        let nearest = || suspected.iter().map(|(j, _)| *j);
        let with: Vec<usize> = set.iter().copied().chain(nearest()).collect();
        let explains = (1.0 - left_by(score, &with) / left_by(score, set)).max(0.0);
        let mut after = weighted.clone();
        // rows of priors, which a repair may be without, have no place
        after.estimate.residuals = finished.estimate.residuals.iter().take(design.rows.len()).copied().collect();
        after.residual = weighted.whiten(&after.estimate.residuals);
        after.residual.resize(weighted.weight.len(), 0.0);
        after.rss = dot(&after.residual, &after.residual);
        let cells = places::cells(campaign, design, &after);
        let pattern = places::pattern(campaign, design, &after, &cells);
        let foremost = deviations.foremost();
        let follows = foremost.and_then(|(kernel, _)| kernel.follows.clone());
        let sd = foremost.zip(sd).map(|((_, variance), sd)| sd * variance.sqrt());
        Unexplained {
            pattern,
            follows,
            sd,
            cells,
            nearest: nearest().filter_map(|j| candidates.get(j)).map(|c| c.regressor.clone()).collect(),
            nearest_explains: explains,
        }
    });
    // places are those of the order in which the effects are reported
    let place = |rival: &Rival| {
        let member = named.get(rival.place)?;
        Some(Rival { place: set.iter().position(|j| j == member)?, ..rival.clone() })
    };
    let rivals: Vec<Rival> = seen.rivals.iter().filter_map(place).collect();
    let effects = repaired.as_ref().map_or_else(Vec::new, |repaired| {
        let t = score.solved(seen.remainder, &columns(set)).map_or_else(Vec::new, |solved| solved.t);
        let effects = Effects { campaign, seen: &seen, set, rivals: &rivals, t };
        (0..set.len()).filter_map(|place| effects.finding(place, repaired)).collect()
    });
    let effects = common(effects);
    let moved = Shifts::new(candidates, score, &seen.scored).about(set, &rivals, &seen.explanations);
    let mut changes = if verdict == Verdict::NotDiagnosable { Vec::new() } else { changes(&before, finished, &moved) };
    // where nothing is missing the uncertainties of the fit are reported
    for change in changes.iter_mut().filter(|_| verdict != Verdict::NothingMissing) {
        let index = finished.campaign.estimated().iter().position(|p| p.id == change.id);
        // likewise
        change.remainder_u = index.and_then(|j| beyond_noise(finished, weighted, deviations, j)).unwrap_or(0.0);
    }
    let after = repaired.as_ref().map(|(_, fit)| fit);
    let steps = steps(campaign, (&before, after), &seen, (set, pure), settings)?;
    let holdout = holdout::holdout(campaign, &before, after, (&scale, weighted));
    let would_help =
        if verdict == Verdict::NotDiagnosable { separate::redundancy(campaign, &before) } else { Vec::new() };
    Ok(Diagnosis {
        verdict,
        effects,
        places: places::places(campaign, design, weighted, settings.significance),
        noise: NoiseFloor { sd, from: noise_from(campaign, weighted) },
        gap_before,
        gap_after,
        unexplained,
        holdout,
        steps,
        candidates: (candidates.len(), seen.tests),
        changes,
        would_help,
        row_sd: scale,
        grouping: None,
        constraints: Vec::new(),
        suspected: suspected
            .iter()
            .filter_map(|(j, p)| Some(Suspect { effect: candidates.get(*j)?.clone(), probability: *p }))
            .collect(),
        state: (verdict != Verdict::NotDiagnosable).then_some(seen.state),
        repaired: None,
        averaged: None,
        after: repaired.map(|(_, after)| after),
        before,
    })
}

/// Where the variance of single readings is known from, whatever else scatters.
fn noise_from(campaign: &Campaign, weighted: &Weighted) -> NoiseFrom {
    let mut observations = campaign.readings.rows.iter().flat_map(|r| &r.observations);
    let stated = weighted.floor.is_some() && observations.all(|o| o.u.is_some());
    if stated { NoiseFrom::Stated } else { weighted.from }
}

fn noise_sd(weighted: &Weighted, finished: &Fit) -> Option<f64> {
    let readings = finished.design.rows.len();
    if weighted.from == NoiseFrom::Residuals && weighted.floor.is_none() {
        // of the finished model: the scale of the first group, for a reading of one sample
        return finished.estimate.group_scale.first().copied().flatten();
    }
    let first = |i: &usize| finished.design.rows.get(*i).is_some_and(|origin| origin.sensor == 0);
    let rows: Vec<usize> = (0..readings).filter(first).collect();
    let square: f64 = rows.iter().filter_map(|i| weighted.own_weight.get(*i)).map(|w| 1.0 / (w * w)).sum();
    (!rows.is_empty()).then(|| (square / rows.len() as f64).sqrt())
}

/// The gap of a fit, with its probability by chance; `pure` is the error of replicates, where these tell the noise.
fn gap(fit: &Fit, weighted: &Weighted, pure: Option<(f64, usize)>) -> Gap {
    let readings = fit.design.rows.len();
    let residuals: Vec<f64> = fit.estimate.residuals.iter().take(readings).copied().collect();
    let dof = fit.estimate.dof;
    let square: f64 = residuals.iter().map(|v| v * v).sum();
    let max = residuals.iter().fold(0.0_f64, |max, v| max.max(v.abs()));
    // residuals of rows that are weighed without it are not the least beside an uncertain input
    let beside = fit.global_test.filter(|_| fit::known_inputs(&fit.campaign, &fit.design).is_some());
    let chi_square = beside.map_or_else(|| weighted.squares(&fit.estimate.residuals), |test| test.chi_square);
    let p = match (weighted.from, pure) {
        (NoiseFrom::Stated, _) if dof > 0 => chi_square_survival(chi_square, dof as f64),
        (NoiseFrom::Replicates, Some((sum, within))) if within > 0 && sum > 0.0 => {
            let between = dof.checked_sub(within).filter(|d| *d > 0).map(|d| d as f64);
            let ratio = |between: f64| (chi_square - sum).max(0.0) / between / (sum / within as f64);
            between.and_then(|between| fisher_f_survival(ratio(between), between, within as f64))
        }
        _ => None,
    };
    Gap { rms: (dof > 0).then(|| (square / dof as f64).sqrt()), max, chi_square, dof, p, residuals }
}

/// Sum of squares and degrees of freedom within replicates with all that is found in the model: what changes from one to the next (a temperature) is no noise.
fn pure_error<'a>(
    weighted: &Weighted,
    finished: &Fit,
    effects: impl Iterator<Item = &'a Candidate>,
) -> Option<(f64, usize)> {
    let replicates = weighted.replicates.as_ref()?;
    // only the noise of single readings scatters there
    let weigh = |column: &[f64]| -> Vec<f64> { column.iter().zip(&weighted.own_weight).map(|(v, w)| v * w).collect() };
    let mut residual = replicates.within(&weigh(&finished.estimate.residuals), &weighted.own_weight);
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for effect in effects {
        let column = weigh(&effect.column);
        let mut direction = replicates.within(&column, &weighted.own_weight);
        project(&mut direction, &basis);
        if normalise(&mut direction) > VISIBLE * norm(&column) {
            project(&mut residual, std::slice::from_ref(&direction));
            basis.push(direction);
        }
    }
    Some((dot(&residual, &residual), replicates.dof.saturating_sub(basis.len())))
}

/// Sum of squares that a set leaves beside the model, of that which the model leaves; infinite for one that is not independent.
fn left_by(score: &Score, set: &[usize]) -> f64 {
    let all = score.solved(Remainder::default(), &[]).map_or(0.0, |none| none.squares);
    let left = score.solved(Remainder::default(), &columns(set)).map_or(f64::INFINITY, |solved| solved.squares);
    if all > 0.0 { left / all } else { 0.0 }
}

/// Candidates are no more than these count.
fn columns(set: &[usize]) -> Vec<u16> {
    set.iter().filter_map(|j| u16::try_from(*j).ok()).collect()
}

/// The probability of a `t` as large by chance, anywhere among so many tests (Sidak).
pub(super) fn of_all(alone: f64, tests: f64) -> f64 {
    -f64::exp_m1(tests * f64::ln_1p(-alone))
}

/// What the findings are made from.
struct Effects<'a> {
    campaign: &'a Campaign,
    seen: &'a Seen,
    set: &'a [usize],
    rivals: &'a [Rival],
    /// The t of each.
    t: Vec<f64>,
}

impl Effects<'_> {
    fn finding(&self, place: usize, (repaired, after): &(Campaign, Fit)) -> Option<Finding> {
        let Seen { candidates, score, weighted, design, deviations, .. } = self.seen;
        let member = self.set.get(place)?;
        let effect = candidates.get(*member)?;
        let others: Vec<usize> = self.set.iter().copied().filter(|j| j != member).collect();
        let t = self.t.get(place).copied().unwrap_or_default();
        let (value, u, unit) = coefficient(self.campaign, repaired, after, effect);
        let index = repaired.estimated().iter().position(|p| p.id == effect.coefficient);
        let extra = index.and_then(|j| beyond_noise(after, weighted, deviations, j));
        // what the repaired model does not estimate has no further uncertainty
        let u = u.map(|u| u.hypot(extra.unwrap_or(0.0)));
        let cosines = score.cosines(*member);
        let at_place = || self.rivals.iter().filter(|rival| rival.place == place);
        let named = self.seen.named.iter().position(|(j, _)| j == member);
        let probability = named.and_then(|k| self.seen.named.get(k)).map_or(0.0, |(_, p)| *p);
        let all = 1.0 + at_place().map(|rival| rival.share).sum::<f64>();
        let mut aliases: Vec<(u32, f64, usize, Alias)> = at_place()
            .filter_map(|rival| {
                let other = candidates.get(rival.candidate)?;
                let cosine = cosines.get(rival.candidate).map_or(0.0, |g| g.abs());
                let alias = Alias {
                    regressor: other.regressor.clone(),
                    name: other.name.clone(),
                    exact: 1.0 - cosine < 1e-6,
                    excess: rival.excess.max(0.0),
                    probability: probability * rival.share / all,
                    vanishing: other.vanishing,
                    visible: other.visible,
                    size: other.size,
                    together_with: None,
                };
                let order = u32::from(other.rank);
                let order = order + if other.vanishing { 300 } else { 0 };
                let order = order + if alias.exact { 0 } else { 100 };
                Some((order, alias.excess, rival.candidate, alias))
            })
            .collect();
        // excesses that differ by rounding are equal: then they stand as in the catalogue
        let excess = |alias: &(u32, f64, usize, Alias)| (alias.1 * 1e6).round();
        aliases.sort_by(|a, b| a.0.cmp(&b.0).then(excess(a).total_cmp(&excess(b))).then(a.2.cmp(&b.2)));
        let columns: Vec<&Candidate> = aliases.iter().filter_map(|(_, _, j, _)| candidates.get(*j)).collect();
        let separation = separate::positions(self.campaign, design, effect, &columns);
        Some(Finding {
            effect: effect.clone(),
            value,
            u,
            unit,
            t,
            p: of_all(by_chance(t, score.dof(self.set.len())), self.seen.tests as f64),
            explains: left_by(score, &others) - left_by(score, self.set),
            probability,
            aliases: aliases.into_iter().map(|(_, _, _, alias)| alias).collect(),
            separation,
            also: Vec::new(),
        })
    }
}

pub(super) fn changes(before: &Fit, after: &Fit, moved: &[(f64, f64)]) -> Vec<Change> {
    let unknown = |id: &str| before.campaign.estimated().iter().position(|parameter| parameter.id == id);
    let of = |p: &fit::ParameterResult| (p.value, p.uncertainty.as_ref().map(|c| c.u));
    before
        .parameters
        .iter()
        .filter_map(|earlier| {
            let then = after.parameters.iter().find(|p| p.id == earlier.id)?;
            // what is known, or not estimated in this model, is not moved
            let (widest, sd) = unknown(&earlier.id).and_then(|j| moved.get(j)).copied().unwrap_or_default();
            Some(Change {
                id: earlier.id.clone(),
                is_angle: earlier.kind == Kind::Tilt,
                unit: earlier.unit.clone(),
                before: of(earlier),
                after: of(then),
                alias_half_width: widest,
                alias_u: sd,
                remainder_u: 0.0,
            })
        })
        .collect()
}

/// By how much a prior or an equation misses, with its standard uncertainty: in the parameter's unit (radians for tilts).
pub(super) fn missed(campaign: &Campaign, after: &Fit, finding: &mut Finding) {
    let at = |j: usize| after.point.at(j);
    let unit = |j: usize| campaign.parameter_unit(j).to_string();
    let n = after.covariance.nrows();
    let along = |terms: &[(usize, f64)]| {
        let inside = || terms.iter().filter(|(j, _)| *j < n);
        inside().map(|(j, a)| inside().map(|(k, b)| a * b * after.covariance[(*j, *k)]).sum::<f64>()).sum::<f64>()
    };
    match finding.effect.kind {
        Regressor::Prior(k) => {
            let Some(Role::Estimated { prior: Some(prior), .. }) = campaign.parameters.get(k).map(|p| &p.role) else {
                return;
            };
            finding.value = Some(at(k) - prior.value);
            finding.u = Some((along(&[(k, 1.0)]) + prior.u * prior.u).sqrt());
            finding.unit = unit(k);
        }
        Regressor::Constraint(k) => {
            let Some(Constraint::Linear { terms, lower, .. }) = campaign.constraints.get(k) else { return };
            finding.value = Some(terms.iter().map(|(j, c)| c * at(*j)).sum::<f64>() - lower);
            finding.u = Some(along(terms).max(0.0).sqrt());
            finding.unit = terms.first().map_or(String::new(), |(j, _)| unit(*j));
        }
        _ => {}
    }
}

/// The gap with some effects in the model.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "GapStepReport")]
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
fn steps(
    campaign: &Campaign,
    (before, after): (&Fit, Option<&Fit>),
    seen: &Seen,
    (set, pure): (&[usize], Option<(f64, usize)>),
    settings: &Settings,
) -> Result<Vec<GapStep>> {
    let Seen { candidates, score, weighted, .. } = seen;
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
    let mut steps = Vec::with_capacity(set.len() + 1);
    for count in 0..=set.len() {
        let members = set.part(..count);
        let between;
        let fit = match (count, after) {
            (0, _) => before,
            (_, Some(after)) if count == set.len() => after,
            _ => {
                let effects: Vec<&Candidate> = members.iter().filter_map(|j| candidates.get(*j)).collect();
                between = fit_exactly(&repaired(campaign, &effects)?, fit::tried)?;
                &between
            }
        };
        let plain = |j: usize| candidates.get(j).is_some_and(|c| !c.vanishing);
        let strongest = score.strongest(seen.remainder, &columns(members), plain);
        let by_chance = |t: f64| of_all(by_chance(t, score.dof(count + 1)), seen.tests as f64);
        let (t, p) = strongest.map(|(_, t)| (t, by_chance(t))).unzip();
        let model = fit.campaign.bench.sensors.iter().map(|s| (s.id.clone(), s.model.to_string())).collect();
        let decision = match set.get(count) {
            Some(next) => format!("{} is added", name(*next)),
            None => last(seen, settings, name),
        };
        let with = members.iter().map(|j| name(*j)).collect();
        let strongest = strongest.map(|(j, _)| name(j));
        let gap = Gap { residuals: Vec::new(), ..gap(fit, weighted, pure) };
        let global_p = gap.p;
        steps.push(GapStep { with, model, gap, strongest, t, p, global_p, decision });
    }
    Ok(steps)
}

/// The order in which effects take off most, one after another.
fn order(score: &Score, set: &[usize]) -> Vec<usize> {
    let mut ordered: Vec<usize> = Vec::with_capacity(set.len());
    while ordered.len() < set.len() {
        let left = |j: &usize| {
            let longer: Vec<usize> = ordered.iter().copied().chain([*j]).collect();
            left_by(score, &longer)
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
