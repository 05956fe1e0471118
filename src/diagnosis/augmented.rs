//! Score and exact fit in turn: every set is judged at the point, and with the rows, of the model that has it.
//!
//! A gap moves the tilts, and columns depend on them; where an effect exists only through tilts, their columns depend on it. So the set that is
//! most probable is fitted exactly, the columns are made anew at its solution, and the sets are judged again, until the set stands still. Sets
//! with a tilt or a known value that could stand in a member's place are tried too: they put the inputs elsewhere. Of all that were fitted the
//! most probable one, each by its own columns, is kept.

use super::ambiguity::{Explanation, Rival};
use super::bank::bank;
use super::candidates::{Kept, build};
use super::evidence::Evidence;
use super::noise::{self, Finished, NoiseFrom, Weighted};
use super::pool::Pool;
use super::remainder::Remainders;
use super::repair::repaired;
use super::score::{Class, Posterior, Priors, Problem, Score};
use super::screen::{Chosen, Screen};
use super::{Candidate, Effect, Settings, assumptions, fit_exactly, screen};
use crate::campaign::{Campaign, Role};
use crate::design::{self, DesignMatrix, Model};
use crate::error::Result;
use crate::estimate::Variances;
use crate::fit::{self, Fit};
use crate::simulate::Regressor;
use crate::vocabulary::vocabulary;
use std::cmp::Ordering;
use std::collections::HashMap;
use std::rc::Rc;

/// Sets that the others are followed from, and exact fits from each: they bound the work.
const FOLLOWED: usize = 6;
const FITS: usize = 5;
/// Factor by which the gap of the model as given may differ from point to point: beyond it an exact fit went astray.
const STRAIGHT: f64 = 2.0;
/// Odds against the best from which a set with another tilt is tried.
const TRIED: f64 = 1e-7;

/// Members of a class are as probable as the best but for this factor: their own odds decide which one stands for them.
const NEAR: f64 = 3.0;
/// Odds and probabilities of members of a class that differ by a smaller share are equal.
const EQUAL: f64 = 1e-6;

/// Regressors and sensors of a set.
type Names = Vec<(String, Option<usize>)>;

vocabulary! {
    /// What the posterior says of a campaign.
    State {
        /// Nothing is missing.
        Nothing = "nothing",
        /// One effect at least is named.
        Named = "named",
        /// No effect is probable enough for a name, and one at least is suspected.
        Suspected = "suspected",
        /// Something is missing, and no effect is probable.
        Outside = "outside",
    }
}

/// What the readings say of one model at one point.
pub(super) struct Seen {
    pub candidates: Vec<Candidate>,
    pub evidence: Evidence,
    pub weighted: Weighted,
    pub design: DesignMatrix,
    /// Effects, each with the probability that it or one of its aliases is there.
    pub named: Vec<(usize, f64)>,
    pub suspected: Vec<(usize, f64)>,
    /// What could stand in the place of a named one.
    pub rivals: Vec<Rival>,
    /// What is probable in all.
    pub explanations: Vec<Explanation>,
    pub state: State,
    /// Probability that anything is missing beyond the effects named.
    pub further: f64,
    /// Probability of a remainder that no effect is.
    pub outside: f64,
}

/// What was seen, and the repaired campaign with its exact fit if effects were named.
pub(super) type Outcome = (Seen, Option<(Campaign, Fit)>);

/// Columns at one point.
struct Seeing {
    design: DesignMatrix,
    weighted: Weighted,
    candidates: Vec<Candidate>,
    /// Members of long families that have none.
    without_column: usize,
}

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
    without_column: usize,
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

/// ln odds of each candidate. Members of a family that stands for readings, positions, times or time constants share the odds of one effect.
pub(super) fn odds<'a>(candidates: impl Iterator<Item = &'a Candidate> + Clone, priors: &Priors) -> Vec<f64> {
    let shared = |c: &Candidate| {
        ["{reading}", "{position}", "{break}", "{tau}", "{other}"].iter().any(|own| c.family.contains(own))
    };
    let mut members: HashMap<(&str, Option<usize>), f64> = HashMap::new();
    for candidate in candidates.clone().filter(|c| shared(c)) {
        *members.entry((candidate.family.as_str(), candidate.sensor)).or_default() += 1.0;
    }
    let own = |c: &Candidate| {
        // what is not shared is one
        let share = members.get(&(c.family.as_str(), c.sensor)).filter(|_| shared(c)).copied().unwrap_or(1.0);
        // of equals the first rank, and before it what was only asserted
        let rank = if assumptions::is_assumption(c) { -1.0 } else { f64::from(c.rank) };
        c.size.clamp(priors.vanishing, 1.0).ln() - share.ln() - priors.rank * rank
    };
    let plain: Vec<f64> = candidates.map(own).collect();
    let all: f64 = plain.iter().map(|own| own.exp()).sum();
    // so many are expected in all where anything is missing
    plain.into_iter().map(|own| own + (priors.expected / all.max(f64::MIN_POSITIVE)).ln()).collect()
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

/// A column below this share of its norm is none.
const VANISHED: f64 = 1e-6;

/// Does a column of the given model vanish at a solution? A norm with an offset may explain all readings without its triad: scale factors 0, offset = g.
fn is_trivial(given: &DesignMatrix, fit: &Fit, campaign: &Campaign) -> bool {
    let norm = |design: &DesignMatrix, k: usize| design.jacobian.col_as_slice(k).iter().map(|v| v * v).sum::<f64>();
    let unknowns = campaign.estimated().iter().enumerate().take(given.jacobian.ncols());
    let there = |id: &str| fit.campaign.parameter_index(id).filter(|own| *own < fit.design.jacobian.ncols());
    unknowns
        .filter_map(|(k, own)| Some((k, there(&own.id)?)))
        .any(|(k, own)| norm(&fit.design, own) < VANISHED * VANISHED * norm(given, k))
}

struct Search<'a> {
    question: Question<'a>,
    model: Model,
    priors: Priors,
    chosen: Chosen,
    kept: Kept,
}

impl<'a> Search<'a> {
    fn new(question: Question<'a>) -> Result<Self> {
        let model = Model::new(question.campaign)?;
        let chosen = screen::chosen(question.campaign);
        let priors = Priors::at(question.settings.significance);
        Ok(Search { question, model, priors, chosen, kept: Kept::new() })
    }

    fn see(&mut self, point: &[f64], fit: Option<(&Fit, &[&Candidate])>) -> Result<Seeing> {
        let Question { campaign, asked, catalogue, settings } = self.question;
        let mut design = design::assemble(campaign, &self.model, point)?;
        let mut finished = None;
        if let Some((fit, effects)) = fit {
            let same = (fit.design.jacobian.nrows(), fit.design.predicted.len())
                == (design.jacobian.nrows(), design.predicted.len());
            if same && !effects.iter().any(|c| assumptions::is_assumption(c)) {
                augment(campaign, &mut design, fit, effects);
            }
            let variances = match fit.campaign.scatter.is_empty() {
                true => None,
                false => fit::scattered(&fit.campaign, &fit.design).ok().map(|found| Variances::from(&found)),
            };
            finished = Some(Finished { scales: fit.estimate.group_scale.clone(), variances });
        }
        let weighted = noise::weigh(campaign, &design, finished.as_ref())?;
        let given: Vec<&Vec<f64>> = fit.iter().flat_map(|(_, effects)| effects.iter().map(|c| &c.column)).collect();
        let mut without_column = 0;
        for given in [&given, &[][..]] {
            let scan = Screen::new(campaign, &design, &weighted, &self.chosen, given);
            self.chosen.add(scan.strongest(&self.chosen).into_iter().map(|(member, _)| member));
            without_column = scan.without_column(&self.chosen);
        }
        self.chosen.add(screen::exchanged(campaign, &design, &weighted, settings));
        let rows = weighted.weight.len();
        let mut candidates = build(campaign, catalogue, &self.model, &design, rows, &self.chosen, &mut self.kept)?;
        candidates.extend(assumptions::candidates(campaign, asked, &design)?);
        candidates.truncate(usize::from(u16::MAX));
        Ok(Seeing { design, weighted, candidates, without_column })
    }

    fn view(&mut self, point: &[f64], fit: Option<(&Fit, &[&Candidate])>, names: &Names) -> Result<View> {
        let Question { campaign, settings, .. } = self.question;
        let Seeing { design, weighted, mut candidates, without_column } = self.see(point, fit)?;
        let rows = weighted.weight.len();
        let columns = weighted.columns(candidates.iter().map(|c| &c.column).collect::<Vec<_>>().into_iter());
        let odds = odds(candidates.iter(), &self.priors);
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
        let unit = match &weighted.floor {
            // variances that the set itself made are compared by the restricted likelihood
            Some(floor) => -0.5 * (floor.whitening().log_determinant() + weighted.estimate.factor.log_determinant()),
            None if problem.known => 0.0,
            None => dof * weighted.weight.iter().map(|w| w.ln()).sum::<f64>() / rows.max(1) as f64,
        };
        let value = set.as_ref().map_or(f64::NEG_INFINITY, |set| score.of(set)) + unit;
        let (posterior, alike) = (score.posterior(), std::mem::take(&mut score.alike));
        for (candidate, visible) in candidates.iter_mut().zip(&score.visible) {
            candidate.visible = *visible;
            candidate.vanishing |= *visible < settings.absorbed;
        }
        drop(score);
        Ok(View { design, weighted, candidates, without_column, posterior, alike, odds, value })
    }

    /// The exact fit with some effects, begun from a point, and where it puts all parameters of the campaign.
    fn exact(&self, at: &View, effects: &[&Candidate], from: &[f64]) -> Result<(Campaign, Fit, Vec<f64>)> {
        let campaign = self.question.campaign;
        let repaired = repaired(campaign, effects)?;
        let mut beside = repaired.clone();
        let sizes = at.weighted.sizes_with(&at.design, campaign.unknowns(), effects.iter().map(|c| &c.column));
        let linear = effects.iter().zip(sizes.unwrap_or_default()).filter(|(c, _)| !assumptions::is_assumption(c));
        let linear = linear.map(|(c, size)| {
            let before = campaign.parameter_index(&c.coefficient).and_then(|k| campaign.parameters.get(k));
            // what the campaign does not have was zero in it
            (c.coefficient.as_str(), size + before.map_or(0.0, |p| p.reference()))
        });
        let places = campaign.parameters.iter().zip(from).map(|(p, value)| (p.id.as_str(), *value));
        for (id, value) in places.chain(linear) {
            let own = repaired.parameter_index(id).and_then(|k| beside.parameters.get_mut(k));
            if let Some(Role::Estimated { start, .. }) = own.map(|p| &mut p.role) {
                *start = Some(value);
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

/// What an exact fit of a set led to.
struct Stood {
    value: f64,
    names: Names,
    point: Vec<f64>,
    view: Rc<View>,
}

impl Search<'_> {
    /// A set at its own solution, fitted from a point; `None` where its exact fit leads elsewhere.
    fn stand(&mut self, home: &[f64], first: &View, at: &View, names: &Names, from: &[f64]) -> Result<Option<Stood>> {
        let Some(effects) = at.members(names) else { return Ok(None) };
        let (point, view) = if effects.is_empty() {
            (home.to_vec(), self.view(home, None, names)?)
        } else {
            let Ok((_, fit, point)) = self.exact(at, &effects, from) else { return Ok(None) };
            if is_trivial(&first.design, &fit, self.question.campaign) {
                return Ok(None);
            }
            let view = self.view(&point, Some((&fit, &effects)), names)?;
            let gap = first.weighted.squares(&view.weighted.estimate.residuals) / first.weighted.rss;
            // what the model as given misses is the same from every point from which it is seen straight
            if !(gap > 1.0 / STRAIGHT && gap < STRAIGHT) {
                return Ok(None);
            }
            (point, view)
        };
        let value = if view.value.is_nan() { f64::NEG_INFINITY } else { view.value };
        Ok(Some(Stood { value, names: names.clone(), point, view: Rc::new(view) }))
    }
}

/// The effects of a campaign that stands fitted at a point.
pub(super) fn run(question: Question<'_>, home: &[f64]) -> Result<Outcome> {
    let mut search = Search::new(question)?;
    let first = Rc::new(search.view(home, None, &Names::new())?);
    let nothing = (f64::NEG_INFINITY, Names::new());
    let mut best = Stood { value: nothing.0, names: nothing.1, point: home.to_vec(), view: first.clone() };
    let mut judged: Vec<Names> = Vec::new();
    if first.weighted.estimate.dof > 0 {
        for start in hypotheses(&first) {
            let (mut wanted, mut at, mut here) = (start, first.clone(), home.to_vec());
            for _ in 0..FITS {
                if judged.contains(&wanted) {
                    break;
                }
                judged.push(wanted.clone());
                let Some(next) = search.stand(home, &first, &at, &wanted, &here)? else { break };
                let view = next.view.clone();
                here.clone_from(&next.point);
                if next.value > best.value {
                    best = next;
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
    // what is estimated to scatter hides effects until they are in the model
    if view.weighted.floor.is_some() && view.weighted.from == NoiseFrom::Residuals {
        let best = |size: usize| view.posterior.sets.iter().find(|(_, set)| set.len() == size);
        wanted.extend([1, 2].into_iter().filter_map(best).map(|(_, set)| view.names(set)));
    }
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

/// Explanations that count where the parameters are told, and their least probability.
const EXPLANATIONS: (usize, f64) = (64, 1e-3);

/// What is named, what could stand in its place, and the model with it.
fn outcome(search: &Search<'_>, Stood { names: stood, point, view, .. }: Stood) -> Result<Outcome> {
    let settings = search.question.settings;
    let posterior = &view.posterior;
    // of all that are nearly as probable in a place as any the one with the best odds by itself; of equals the more probable, then by name
    let odds = |j: usize| view.odds.get(j).copied().unwrap_or(f64::NEG_INFINITY);
    let front = |class: &Class| {
        let name = |j: usize| view.candidates.get(j).map_or("", |c| c.regressor.as_str());
        let most = class.members.iter().fold(0.0_f64, |most, (_, p)| most.max(*p));
        let order = |a: f64, b: f64| if (a - b).abs() <= EQUAL { Ordering::Equal } else { a.total_cmp(&b) };
        let near = class.members.iter().filter(|(_, p)| *p * NEAR >= most);
        let best = near.max_by(|(a, p), (b, q)| {
            order(odds(*a), odds(*b)).then(order(p / most, q / most)).then_with(|| name(*b).cmp(name(*a)))
        });
        best.map(|(j, _)| *j)
    };
    let mut named: Vec<(usize, &Class)> = Vec::new();
    let mut suspected: Vec<(usize, &Class)> = Vec::new();
    for class in &posterior.classes {
        let Some(own) = front(class) else { continue };
        match class.probability {
            p if p >= settings.probability => named.push((own, class)),
            p if p >= settings.suspected => suspected.push((own, class)),
            _ => {}
        }
    }
    let mut rivals: Vec<Rival> = Vec::new();
    for (place, (member, class)) in named.iter().enumerate() {
        // the member itself is one of its class
        let own = class.members.iter().find(|(j, _)| j == member).map_or(1.0, |(_, p)| *p);
        for (candidate, p) in class.members.iter().copied().filter(|(j, _)| j != member) {
            let excess = -2.0 * ((p / own).ln() - odds(candidate) + odds(*member));
            rivals.push(Rival { place, candidate, share: p / own, excess });
        }
    }
    rivals.sort_by(|a, b| a.place.cmp(&b.place).then(a.excess.total_cmp(&b.excess)));
    let effects: Vec<&Candidate> = named.iter().filter_map(|(j, _)| view.candidates.get(*j)).collect();
    let repair = match effects.is_empty() {
        true => None,
        false => search.exact(&view, &effects, &point).ok().map(|(repaired, fit, _)| (repaired, fit)),
    };
    let repair = match repair {
        Some((_, fit)) if is_trivial(&view.design, &fit, search.question.campaign) => None,
        other => other,
    };
    let state = match (repair.is_some(), suspected.is_empty()) {
        (true, _) => State::Named,
        _ if posterior.nothing >= settings.suspected => State::Nothing,
        (_, false) => State::Suspected,
        _ => State::Outside,
    };
    let shares = |j: &u16| {
        let prior = |own: &u16| (usize::from(*own), odds(usize::from(*own)).exp());
        // columns of which next to nothing is left tell nothing of the parameters
        let seen = |own: &&u16| view.candidates.get(usize::from(**own)).is_some_and(|c| c.visible >= settings.absorbed);
        view.alike.get(usize::from(*j)).into_iter().flatten().filter(seen).map(prior).collect::<Vec<_>>()
    };
    let likely = posterior.sets.iter().take(EXPLANATIONS.0).filter(|(p, _)| *p >= EXPLANATIONS.1);
    let explanations = likely
        .filter(|_| state != State::Nothing)
        .map(|(probability, set)| Explanation { probability: *probability, members: set.iter().map(shares).collect() })
        .collect();
    let columns: Vec<&Vec<f64>> = view.candidates.iter().map(|c| &c.column).collect();
    let remainders = Remainders::new(search.question.campaign, &view.design, &view.weighted);
    let mut evidence = Evidence::new(&view.weighted, &columns, remainders);
    evidence.tests += view.without_column;
    evidence.found_with(&stood.iter().filter_map(|own| view.index(own)).collect::<Vec<_>>());
    // what is there beyond the effects named
    let further = 1.0 - posterior.alone.iter().take(named.len() + 1).sum::<f64>();
    let probable = |own: &[(usize, &Class)]| own.iter().map(|(j, class)| (*j, class.probability)).collect();
    let seen = Seen {
        candidates: view.candidates.clone(),
        evidence,
        weighted: view.weighted.clone(),
        design: view.design.clone(),
        named: probable(&named),
        suspected: probable(&suspected),
        rivals,
        explanations,
        state,
        further: further.clamp(0.0, 1.0),
        outside: posterior.outside,
    };
    Ok((seen, repair))
}

/// Every candidate for this campaign at its fitted model, with the standard uncertainty that its coefficient would have in it.
///
/// What a schedule can see: an effect of less than five of these hides in the noise. Infinite where the model absorbs it.
/// Errors: as [`super::diagnose`].
pub fn candidates(campaign: &Campaign, catalogue: &[Effect]) -> Result<Vec<(Candidate, f64)>> {
    let assumed = assumptions::hold(campaign)?;
    let fit = fit_exactly(&assumed.campaign)?;
    let settings = Settings::default();
    let question = Question { campaign: &assumed.campaign, asked: &assumed.asked, catalogue, settings: &settings };
    let point: Vec<f64> = fit.point.iter().take(fit.design.point.len()).copied().collect();
    let Seeing { weighted, mut candidates, .. } = Search::new(question)?.see(&point, None)?;
    let columns = weighted.columns(candidates.iter().map(|c| &c.column).collect::<Vec<_>>().into_iter());
    let visible = Pool::new(columns, weighted.estimate.factor.thin_q(), &weighted.residual);
    for (candidate, visible) in candidates.iter_mut().zip(visible.visible()) {
        candidate.visible = *visible;
        candidate.vanishing |= *visible < settings.absorbed;
    }
    let with_u = |candidate: Candidate| {
        let u = 1.0 / (weighted.norm(&candidate.column) * candidate.visible);
        (candidate, u)
    };
    Ok(candidates.into_iter().map(with_u).collect())
}
