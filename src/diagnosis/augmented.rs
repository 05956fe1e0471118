//! Score and exact fit in turn: every set is judged at the point, and with the rows, of the model that has it.
//!
//! A gap moves the tilts, and columns depend on them; where an effect exists only through tilts, their columns depend on it. So the set that is
//! most probable is fitted exactly, the columns are made anew at its solution, and the sets are judged again, until the set stands still. Sets
//! with a tilt or a known value that could stand in a member's place are tried too: they put the inputs elsewhere. Of all that were fitted the
//! most probable one, each by its own columns, is kept.

use super::bank::bank;
use super::candidates::{Kept, build};
use super::evidence::Evidence;
use super::noise::{self, Finished, NoiseFrom, Weighted};
use super::pass::{Outcome, Seen};
use super::remainder::Remainders;
use super::repair::repaired;
use super::score::{Class, Posterior, Priors, Problem, Score};
use super::screen::{Chosen, Screen};
use super::search::Found;
use super::sets::Rival;
use super::{Candidate, Effect, Settings, assumptions, fit_exactly, screen};
use crate::campaign::{Campaign, Role};
use crate::design::{self, DesignMatrix, Model};
use crate::error::Result;
use crate::estimate::Variances;
use crate::fit::{self, Fit};
use crate::simulate::Regressor;
use std::collections::HashMap;
use std::rc::Rc;

/// Sets that the others are followed from, and exact fits from each: they bound the work.
const FOLLOWED: usize = 6;
const FITS: usize = 5;
/// Odds against the best from which a set with another tilt is tried.
const TRIED: f64 = 1e-7;

/// Regressors and sensors of a set.
type Names = Vec<(String, Option<usize>)>;

/// A campaign whose effects are looked for.
pub(super) struct Question<'a> {
    pub campaign: &'a Campaign,
    /// For each equation, the constraint that was asked for.
    pub asked: &'a [usize],
    pub catalogue: &'a [Effect],
    pub settings: &'a Settings,
}

/// What was seen at one point.
struct View {
    design: DesignMatrix,
    weighted: Weighted,
    candidates: Vec<Candidate>,
    posterior: Posterior,
    /// Candidates with one column, by the one that stands for them.
    alike: Vec<Vec<u16>>,
    /// ln of each candidate's odds.
    odds: Vec<f64>,
    /// ln evidence of the set that was asked about.
    value: f64,
}

impl View {
    fn index(&self, (regressor, sensor): &(String, Option<usize>)) -> Option<usize> {
        self.candidates.iter().position(|c| c.regressor == *regressor && c.sensor == *sensor)
    }

    fn names(&self, set: &[u16]) -> Names {
        let own = |j: &u16| self.candidates.get(usize::from(*j)).map(|c| (c.regressor.clone(), c.sensor));
        let mut names: Names = set.iter().filter_map(own).collect();
        names.sort();
        names
    }

    fn members(&self, names: &Names) -> Option<Vec<&Candidate>> {
        names.iter().map(|own| self.index(own).and_then(|j| self.candidates.get(j))).collect()
    }

    /// What stands for a set in the posterior.
    fn standing(&self, names: &Names) -> Option<Vec<u16>> {
        standing(&self.candidates, &self.alike, names)
    }
}

fn standing(candidates: &[Candidate], alike: &[Vec<u16>], names: &Names) -> Option<Vec<u16>> {
    let place = |(regressor, sensor): &(String, Option<usize>)| {
        let j = candidates.iter().position(|c| c.regressor == *regressor && c.sensor == *sensor)?;
        let j = u16::try_from(j).ok()?;
        let first = alike.iter().position(|own| own.contains(&j)).and_then(|k| u16::try_from(k).ok());
        Some(first.unwrap_or(j))
    };
    let mut set: Vec<u16> = names.iter().map(place).collect::<Option<_>>()?;
    set.sort_unstable();
    set.dedup();
    Some(set)
}

fn moves(candidate: &Candidate) -> bool {
    matches!(candidate.kind, Regressor::Tilt(_) | Regressor::Known(_))
}

/// Members of a family that stands for readings, positions, times or time constants share the odds of one effect.
fn odds(candidates: &[Candidate], priors: &Priors, settings: &Settings) -> Vec<f64> {
    let shared = |c: &Candidate| ["{reading}", "{position}", "{break}", "{tau}", "{other}"].iter().any(|own| c.family.contains(own));
    let mut members: HashMap<(&str, Option<usize>), f64> = HashMap::new();
    for candidate in candidates.iter().filter(|c| shared(c)) {
        *members.entry((candidate.family.as_str(), candidate.sensor)).or_default() += 1.0;
    }
    let own = |c: &Candidate| {
        let share = members.get(&(c.family.as_str(), c.sensor)).filter(|_| shared(c)).copied().unwrap_or(1.0);
        // among equals the first rank, and what was only asserted
        let asserted = if assumptions::is_assumption(c) { settings.asserted } else { 0.0 };
        let plain = 0.5 * (asserted - settings.rank_penalty * f64::from(c.rank));
        priors.odds.ln() - share.ln() + c.size.clamp(priors.vanishing, 1.0).ln() + plain
    };
    candidates.iter().map(own).collect()
}

/// The rows of the augmented model: its derivatives to the tilts go through the effects too. The gap stays that of the model as given.
fn augment(campaign: &Campaign, design: &mut DesignMatrix, fit: &Fit, effects: &[&Candidate]) {
    let given = campaign.reference_point();
    let columns = fit.design.jacobian.ncols();
    for (k, parameter) in campaign.parameters.iter().enumerate().take(design.jacobian.ncols()) {
        if let Some(own) = fit.campaign.parameter_index(&parameter.id).filter(|own| *own < columns) {
            design.jacobian.col_as_slice_mut(k).copy_from_slice(fit.design.jacobian.col_as_slice(own));
        }
    }
    design.predicted.clone_from(&fit.design.predicted);
    for effect in effects {
        let index = fit.campaign.parameter_index(&effect.coefficient).filter(|own| *own < columns);
        let Some(own) = index else { continue };
        let before = campaign.parameter_index(&effect.coefficient).and_then(|k| given.get(k)).copied();
        // what the campaign does not have was zero in it
        let size = fit.design.point.get(own).map_or(0.0, |value| value - before.unwrap_or_default());
        let slopes = fit.design.jacobian.col_as_slice(own);
        design.predicted.iter_mut().zip(slopes).for_each(|(predicted, slope)| *predicted -= slope * size);
    }
}

struct Search<'a> {
    question: Question<'a>,
    model: Model,
    priors: Priors,
    chosen: Chosen,
    kept: Kept,
}

impl Search<'_> {
    fn view(&mut self, point: &[f64], fit: Option<(&Fit, &[&Candidate])>, names: &Names) -> Result<View> {
        let Question { campaign, asked, catalogue, settings } = self.question;
        let mut design = design::assemble(campaign, &self.model, point)?;
        let mut finished = None;
        if let Some((fit, effects)) = fit {
            let same = (fit.design.jacobian.nrows(), fit.design.predicted.len()) == (design.jacobian.nrows(), design.predicted.len());
            if same && !effects.iter().any(|c| assumptions::is_assumption(c)) {
                augment(campaign, &mut design, fit, effects);
            }
            let variances = match fit.campaign.scatter.is_empty() {
                true => None,
                false => fit::scattered(&fit.campaign, &fit.design).ok().map(|found| Variances::from(&found)),
            };
            finished = Some(Finished { scales: fit.estimate.group_scale.clone(), variances, with: names.clone() });
        }
        let weighted = noise::weigh(campaign, &design, finished.as_ref())?;
        let given: Vec<&Vec<f64>> = fit.iter().flat_map(|(_, effects)| effects.iter().map(|c| &c.column)).collect();
        for given in [&[][..], &given] {
            let scan = Screen::new(campaign, &design, &weighted, &self.chosen, given);
            self.chosen.add(scan.strongest(&self.chosen).into_iter().map(|(member, _)| member));
        }
        self.chosen.add(screen::exchanged(campaign, &design, &weighted, settings));
        let rows = weighted.weight.len();
        let mut candidates = build(campaign, catalogue, &self.model, &design, rows, &self.chosen, &mut self.kept)?;
        candidates.extend(assumptions::candidates(campaign, asked, &design)?);
        candidates.truncate(usize::from(u16::MAX));
        let columns = weighted.columns(candidates.iter().map(|c| &c.column).collect::<Vec<_>>().into_iter());
        let odds = odds(&candidates, &self.priors, settings);
        let kernels = bank(campaign, &design, &weighted);
        let problem = Problem {
            residual: &weighted.residual,
            basis: weighted.estimate.factor.thin_q(),
            columns: columns.as_ref(),
            prior: &odds,
            known: weighted.from == NoiseFrom::Stated,
            kernels: &kernels,
        };
        let mut score = Score::new(&problem, self.priors);
        let set = standing(&candidates, &score.alike, names);
        score.search(&set.iter().filter(|own| !own.is_empty()).cloned().collect::<Vec<_>>());
        // the evidence of a noise that is not known has the unit of the weights
        let dof = (rows - weighted.estimate.factor.thin_q().ncols().min(rows)) as f64;
        let unit = match problem.known {
            true => 0.0,
            false => dof * weighted.weight.iter().map(|w| w.ln()).sum::<f64>() / rows.max(1) as f64,
        };
        let value = set.map_or(f64::NEG_INFINITY, |set| score.of(&set)) + unit;
        let (posterior, alike) = (score.posterior(), std::mem::take(&mut score.alike));
        for (candidate, visible) in candidates.iter_mut().zip(&score.visible) {
            candidate.visible = *visible;
            candidate.vanishing |= *visible < settings.absorbed;
        }
        drop(score);
        Ok(View { design, weighted, candidates, posterior, alike, odds, value })
    }

    /// The exact fit with some effects, begun from a point, and where it puts all parameters of the campaign.
    fn exact(&self, effects: &[&Candidate], from: &[f64]) -> Result<(Campaign, Fit, Vec<f64>)> {
        let campaign = self.question.campaign;
        let repaired = repaired(campaign, effects)?;
        let mut beside = repaired.clone();
        for (parameter, value) in campaign.parameters.iter().zip(from) {
            let own = repaired.parameter_index(&parameter.id).and_then(|k| beside.parameters.get_mut(k));
            if let Some(Role::Estimated { start, .. }) = own.map(|p| &mut p.role) {
                *start = Some(*value);
            }
        }
        let mut fit = fit_exactly(&beside)?;
        fit.campaign.parameters = repaired.parameters.clone();
        let given = campaign.reference_point();
        let estimated = repaired.unknowns();
        let place = |id: &str| repaired.parameter_index(id).filter(|k| *k < estimated);
        let own = |(k, value): (usize, &f64)| {
            let found = campaign.parameters.get(k).and_then(|p| place(&p.id)).and_then(|k| fit.point.get(k));
            found.or_else(|| given.get(k)).copied().unwrap_or(*value)
        };
        let point = from.iter().enumerate().map(own).collect();
        Ok((repaired, fit, point))
    }
}

/// The effects of a campaign that stands fitted at a point.
pub(super) fn run(question: Question<'_>, home: &[f64]) -> Result<Outcome> {
    let model = Model::new(question.campaign)?;
    let chosen = screen::chosen(question.campaign);
    let mut search = Search { question, model, priors: Priors::default(), chosen, kept: Kept::new() };
    let first = Rc::new(search.view(home, None, &Names::new())?);
    let mut best: (f64, Names, Vec<f64>, Rc<View>) = (f64::NEG_INFINITY, Names::new(), home.to_vec(), first.clone());
    let mut tried: Vec<Names> = Vec::new();
    if first.weighted.estimate.dof > 0 {
        for start in hypotheses(&first) {
            let (mut wanted, mut at, mut here) = (start, first.clone(), home.to_vec());
            for _ in 0..FITS {
                if tried.contains(&wanted) {
                    break;
                }
                tried.push(wanted.clone());
                let Some(effects) = at.members(&wanted) else { break };
                let next = if effects.is_empty() {
                    (home.to_vec(), search.view(home, None, &wanted)?)
                } else {
                    let Ok((_, fit, point)) = search.exact(&effects, &here) else { break };
                    let view = search.view(&point, Some((&fit, &effects)), &wanted)?;
                    (point, view)
                };
                let view = Rc::new(next.1);
                here = next.0;
                if view.value > best.0 {
                    best = (view.value, wanted.clone(), here.clone(), view.clone());
                }
                let Some((top, set)) = view.posterior.sets.first() else { break };
                let own = view.standing(&wanted);
                let share = view.posterior.sets.iter().find(|(_, s)| Some(s) == own.as_ref()).map_or(0.0, |(p, _)| *p);
                // another column of the same direction is no other set
                if share >= 0.9 * top {
                    break;
                }
                wanted = view.names(set);
                at = view;
            }
        }
    }
    outcome(&search, best)
}

/// The most probable set, and those in which a tilt or a known value stands in a member's place.
fn hypotheses(view: &View) -> Vec<Names> {
    let mut wanted: Vec<Names> = view.posterior.sets.iter().take(1).map(|(_, set)| view.names(set)).collect();
    let mut seen: Vec<u16> = Vec::new();
    for (probability, set) in &view.posterior.sets {
        if wanted.len() >= FOLLOWED || *probability < TRIED {
            break;
        }
        for (place, member) in set.iter().enumerate() {
            for other in view.alike.get(usize::from(*member)).into_iter().flatten() {
                if view.candidates.get(usize::from(*other)).is_some_and(moves) && !seen.contains(other) {
                    seen.push(*other);
                    let mut with = set.clone();
                    with.iter_mut().skip(place).take(1).for_each(|slot| *slot = *other);
                    wanted.push(view.names(&with));
                }
            }
        }
    }
    wanted.truncate(FOLLOWED);
    wanted
}

/// What is named, what could stand in its place, and the model with it.
fn outcome(search: &Search<'_>, (_, stood, point, view): (f64, Names, Vec<f64>, Rc<View>)) -> Result<Outcome> {
    let settings = search.question.settings;
    let posterior = &view.posterior;
    // of all that could stand in a place the most probable by itself; among equals the one that was fitted
    let front = |class: &Class| {
        let fitted = |j: usize| view.candidates.get(j).is_some_and(|c| stood.contains(&(c.regressor.clone(), c.sensor)));
        let all = class.aliases.iter().copied().chain([(class.member, class.own)]);
        let best = all.max_by(|a, b| {
            let weight = |(j, p): &(usize, f64)| if fitted(*j) { p * (1.0 + 1e-6) } else { *p };
            weight(a).total_cmp(&weight(b))
        });
        best.map_or(class.member, |(j, _)| j)
    };
    let named: Vec<(usize, &Class)> = posterior
        .classes
        .iter()
        .filter(|class| class.probability >= settings.probability)
        .map(|class| (front(class), class))
        .collect();
    let nearest: Vec<usize> =
        posterior.classes.iter().filter(|class| class.probability < settings.probability).map(front).collect();
    let odds = |j: usize| view.odds.get(j).copied().unwrap_or(f64::NEG_INFINITY);
    let mut rivals: Vec<Rival> = Vec::new();
    for (place, (member, class)) in named.iter().enumerate() {
        let all = class.aliases.iter().copied().chain([(class.member, class.own)]);
        let own = all.clone().find(|(j, _)| j == member).map_or(class.own, |(_, p)| p);
        for (candidate, p) in all.filter(|(j, _)| j != member) {
            let excess = -2.0 * ((p / own).ln() - odds(candidate) + odds(*member));
            rivals.push(Rival { place, candidate, instead: Vec::new(), with: Vec::new(), excess });
        }
    }
    rivals.sort_by(|a, b| a.place.cmp(&b.place).then(a.excess.total_cmp(&b.excess)));
    let set: Vec<usize> = named.iter().map(|(j, _)| *j).collect();
    let found = if set.is_empty() {
        match posterior.nothing >= 0.5 {
            true => Found::Nothing,
            false => Found::Unexplained { nearest, approximate: Vec::new() },
        }
    } else {
        let complete = posterior.outside < 0.5 && nearest.is_empty();
        Found::Set { set: set.clone(), rivals, complete, nearest, approximate: Vec::new() }
    };
    let effects: Vec<&Candidate> = set.iter().filter_map(|j| view.candidates.get(*j)).collect();
    let repair = match effects.is_empty() {
        true => None,
        false => search.exact(&effects, &point).ok().map(|(repaired, fit, _)| (repaired, fit)),
    };
    let probabilities = named.iter().map(|(j, class)| (*j, class.probability)).collect();
    let columns: Vec<&Vec<f64>> = view.candidates.iter().map(|c| &c.column).collect();
    let remainders = Remainders::new(search.question.campaign, &view.design, &view.weighted);
    let evidence = Evidence::new(&view.weighted, &columns, remainders);
    let plausibility_penalty = view.odds.iter().map(|own| -2.0 * own).collect();
    let seen = Seen {
        candidates: view.candidates.clone(),
        evidence,
        weighted: view.weighted.clone(),
        design: view.design.clone(),
        plausibility_penalty,
        found,
        probabilities,
    };
    Ok((seen, repair))
}
