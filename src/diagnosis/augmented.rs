//! Score and exact fit in turn: every set is judged at the point, and with the rows, of the model that has it.
//!
//! A gap moves the tilts, and columns depend on them; where an effect exists only through tilts, their columns depend on it. So the set that is
//! most probable is fitted exactly, the columns are made anew at its solution, and the sets are judged again, until the set no longer changes. Sets
//! with a tilt or a known value that could stand in a member's place are tried too: they put the inputs elsewhere. Of all that were fitted the
//! most probable one, each by the columns at its solution, is kept.

use super::ambiguity::{Explanation, Rival};
use super::bank::{bank, bank_of};
use super::candidates::{Kept, build};
use super::common::{DIFFERENT, NoiseFrom};
use super::noise::{Finished, Weighted};
use super::own_noise;
use super::repair::{beyond_noise, coefficient, repaired};
use super::score::{ALIAS, Class, Deviations, Member, Posterior, Priors, Problem, RANK, Remainder, Score};
use super::screen::{Chosen, Screen};
use super::{Candidate, Effect, Settings, assumptions, fit_exactly, screen};
use crate::campaign::{Campaign, Role};
use crate::design::{self, DesignMatrix, Model};
use crate::error::Result;
use crate::fit::{self, Fit};
use crate::simulate::Regressor;
use crate::vocabulary::vocabulary;
use std::collections::{BTreeMap, HashMap};

/// Sets that are fitted first, rounds of exact fits, and fits of each round: they bound the work.
const FOLLOWED: usize = 6;
const VIEWS: usize = 6;
const RIVALS: usize = 8;
/// Least probability of a set that is judged at its solution.
const COMPETES: f64 = 0.02;
/// Factor by which the gap of the model as given may differ from point to point: beyond it an exact fit went astray.
const STRAIGHT: f64 = 2.0;
/// Cosine from which a column may be there in the place of a tilt, and tilts that are fitted by themselves first.
const RESEMBLES: f64 = 0.9;
const FIRST: usize = 3;
/// Odds against the best from which a set with another tilt is tried.
const TRIED: f64 = 1e-7;

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
    pub score: Score,
    /// The weights of the score.
    pub scored: Weighted,
    /// The most probable remainder given the named effects.
    pub remainder: Remainder,
    /// Distinct candidates, and those of long families that have no column: how many tests were made.
    pub tests: usize,
    /// With the noise of the model with what is named.
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
    /// The same beyond the effects named or suspected.
    pub unaccounted: f64,
    /// Probability of a remainder that no effect is.
    pub outside: f64,
    /// The random effects that remain, given the named effects.
    pub deviations: Deviations,
}

/// What was seen, and the repaired campaign with its exact fit if effects were named.
pub(super) type Outcome = (Seen, Option<(Campaign, Fit)>);

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
    /// Members of long families that have none.
    without_column: usize,
    score: Score,
    /// What its evidences and those of other points differ by.
    unit: f64,
    posterior: Posterior,
}

impl View {
    fn names(&self, set: &[u16]) -> Names {
        names_of(set.iter().filter_map(|j| self.candidates.get(usize::from(*j))))
    }

    /// The candidate that stands for a class.
    fn front(&self, class: &Class) -> Option<Member> {
        let name = |j: usize| self.candidates.get(j).map(|c| c.regressor.as_str());
        // what only small tilts leave never stands for a plain one
        let is_plain = |j: usize| self.candidates.get(j).is_some_and(|c| !c.vanishing);
        // of equals the one that other sensors have, too
        let others = |j: usize| {
            let has = |own: &Candidate, member: &Member| {
                let other = self.candidates.get(member.candidate);
                other.is_some_and(|other| other.regressor == own.regressor && other.sensor != own.sensor)
            };
            let with = |own: &Candidate| {
                let classes = self.posterior.classes.iter();
                classes.filter(|class| class.members.iter().any(|member| has(own, member))).count()
            };
            self.candidates.get(j).map_or(0, with)
        };
        class.front(ALIAS, is_plain, |a, b| others(b).cmp(&others(a)).then_with(|| name(a).cmp(&name(b))))
    }

    /// The candidates that stand for the classes. Each front is what stands for its class where the others are what the best set has there; of two classes that
    /// share members the two fronts may be a pair that no reading supports. So one that makes the set less probable by more than aliases may differ gives way to what the best
    /// set has in its place.
    fn fronts(&mut self) -> Vec<Option<Member>> {
        let classes = self.posterior.classes.clone();
        let mut set = self.posterior.sets.first().map(|(_, set)| set.to_vec()).unwrap_or_default();
        let least = self.score.of(&set) - ALIAS;
        let mut fronts = Vec::new();
        for (place, class) in classes.iter().enumerate() {
            let mut front = self.front(class);
            // the first classes are those of the members of the best set, in their order
            if let Some(own) = set.get(place).copied() {
                let mut with = set.clone();
                let standing = front.and_then(|front| self.score.standing(front.candidate));
                with.iter_mut().skip(place).take(1).for_each(|slot| *slot = standing.unwrap_or(own));
                let is_twice = with.iter().enumerate().any(|(k, j)| k != place && Some(*j) == standing);
                if standing == Some(own) || (!is_twice && self.score.of(&with) >= least) {
                    set = with;
                } else {
                    let is_own = |member: &&Member| self.score.standing(member.candidate) == Some(own);
                    let members = class.members.iter().filter(is_own).copied().collect();
                    front = self.front(&Class { members, probability: class.probability });
                }
            }
            fronts.push(front);
        }
        fronts
    }

    /// A set with, in the place of what only small tilts leave, the plain candidate that stands for its class: the exact fit of the former leads to a point far
    /// away, from which nothing else is seen straight.
    fn plain(&self, set: &[u16]) -> Vec<u16> {
        let front = |j: &u16| {
            let index = usize::from(*j);
            self.candidates.get(index).filter(|c| c.vanishing)?;
            let mut classes = self.posterior.classes.iter();
            let class = classes.find(|class| class.members.iter().any(|member| member.candidate == index))?;
            u16::try_from(self.front(class)?.candidate).ok()
        };
        let plain: Vec<u16> = set.iter().map(|j| front(j).unwrap_or(*j)).collect();
        let is_twice = |(k, j): (usize, &u16)| plain.iter().skip(k + 1).any(|other| other == j);
        if plain.iter().enumerate().any(is_twice) { set.to_vec() } else { plain }
    }

    fn members(&self, names: &Names) -> Option<Vec<&Candidate>> {
        names.iter().map(|name| self.candidates.get(index(&self.candidates, name)?)).collect()
    }

    /// ln odds of all that have the column of a candidate.
    fn odds(&self, j: usize) -> f64 {
        self.score.standing(j).and_then(|j| self.score.prior.get(usize::from(j))).copied().unwrap_or(f64::NEG_INFINITY)
    }

    /// The posterior with the evidence of the sets that were fitted at their solutions; of several with the same columns here the most probable counts.
    fn settle(&mut self, judged: &[(Names, Option<f64>)]) {
        let mut settled: BTreeMap<Vec<u16>, f64> = BTreeMap::new();
        // an exact fit that leads elsewhere says nothing of its set
        for (names, value) in judged.iter().filter_map(|(names, value)| Some((names, (*value)?))) {
            if let Some(set) = columns_of(&self.candidates, &self.score, names) {
                let most = settled.entry(set).or_insert(f64::NEG_INFINITY);
                *most = most.max(value);
            }
        }
        let unit = self.unit;
        self.score.overrule(settled.into_iter().map(|(set, value)| (set, value - unit)));
        self.posterior = self.score.posterior();
    }
}

fn index(candidates: &[Candidate], (regressor, sensor): &(String, Option<usize>)) -> Option<usize> {
    candidates.iter().position(|c| c.regressor == *regressor && c.sensor == *sensor)
}

fn names_of<'a>(effects: impl Iterator<Item = &'a Candidate>) -> Names {
    let mut names: Names = effects.map(|c| (c.regressor.clone(), c.sensor)).collect();
    names.sort();
    names
}

fn columns_of(candidates: &[Candidate], score: &Score, names: &Names) -> Option<Vec<u16>> {
    let place = |name| {
        let j = index(candidates, name)?;
        score.standing(j).or(u16::try_from(j).ok())
    };
    let mut set: Vec<u16> = names.iter().map(place).collect::<Option<_>>()?;
    set.sort_unstable();
    set.dedup();
    Some(set)
}

fn moves(candidate: &Candidate) -> bool {
    matches!(candidate.kind, Regressor::Tilt(_) | Regressor::Known(_))
}

/// ln odds of each candidate. Members of a family of readings, positions, times or time constants share the odds of one effect.
/// Each counts among what is expected with the share of its sizes that are not absurd.
pub(super) fn odds<'a>(
    candidates: impl Iterator<Item = &'a Candidate>,
    priors: &Priors,
    plain: impl Fn(usize) -> f64,
) -> Vec<f64> {
    let odds_of = |c: &Candidate| {
        let share = c.one_of.max(1) as f64;
        // of equals the first rank, and before it what was only asserted
        let rank = if assumptions::is_assumption(c) { -1.0 } else { f64::from(c.rank) };
        -share.ln() - RANK * rank
    };
    priors.shared(candidates.map(odds_of).collect(), plain)
}

/// Of each candidate that is one for several sensors the number of its kind, and of how many sensors.
fn kinds<'a>(of: impl Iterator<Item = &'a Candidate>, all: &[Candidate]) -> Vec<Option<(u16, u16)>> {
    let mut sensors: HashMap<&str, (u16, u16)> = HashMap::new();
    for candidate in all.iter().filter(|candidate| candidate.sensor.is_some()) {
        let next = u16::try_from(sensors.len()).unwrap_or(u16::MAX);
        sensors.entry(&candidate.regressor).or_insert((next, 0)).1 += 1;
    }
    of.map(|candidate| sensors.get(candidate.regressor.as_str()).copied().filter(|(_, sensors)| *sensors > 1)).collect()
}

/// For each candidate, scaled to a largest value of one, the coefficient with which it would make as much as the largest reading of its sensor if its
/// inputs were as large as they could be: what only small tilts leave needs an absurd one.
fn plain(candidates: &[Candidate], design: &DesignMatrix) -> Vec<f64> {
    let mut largest: Vec<f64> = Vec::new();
    for (origin, value) in design.rows.iter().zip(&design.predicted) {
        largest.resize(largest.len().max(origin.sensor + 1), 0.0);
        largest.iter_mut().skip(origin.sensor).take(1).for_each(|most| *most = most.max(value.abs()));
    }
    let of = |candidate: &Candidate| {
        let all = candidate.column.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let most = candidate.column.iter().zip(&design.rows).fold(0.0_f64, |most, (v, origin)| {
            let reading = largest.get(origin.sensor).copied().filter(|size| *size > 0.0);
            reading.map_or(most, |reading| most.max(v.abs() / reading))
        });
        // what no reading of any size feels has none
        if most > 0.0 { candidate.size * all / most } else { f64::INFINITY }
    };
    candidates.iter().map(of).collect()
}

/// The rows of the augmented model: its derivatives to the tilts go through the effects too. The gap stays that of the model as given.
fn augment(campaign: &Campaign, design: &mut DesignMatrix, fit: &Fit, effects: &[&Candidate]) {
    let given = campaign.reference_point();
    let columns = fit.design.jacobian.ncols();
    for (k, parameter) in campaign.parameters.iter().enumerate().take(design.jacobian.ncols()) {
        if let Some(column) = fit.campaign.parameter_index(&parameter.id).filter(|column| *column < columns) {
            design.jacobian.col_as_slice_mut(k).copy_from_slice(fit.design.jacobian.col_as_slice(column));
        }
    }
    design.predicted.clone_from(&fit.design.predicted);
    for effect in effects {
        let index = fit.campaign.parameter_index(&effect.coefficient).filter(|column| *column < columns);
        let Some(column) = index else { continue };
        let before = campaign.parameter_index(&effect.coefficient).and_then(|k| given.get(k)).copied();
        // what the campaign does not have was zero in it
        let size = fit.design.point.get(column).map_or(0.0, |value| value - before.unwrap_or_default());
        let slopes = fit.design.jacobian.col_as_slice(column);
        design.predicted.iter_mut().zip(slopes).for_each(|(predicted, slope)| *predicted -= slope * size);
    }
}

/// A column below this share of its norm is none.
const VANISHED: f64 = 1e-6;

/// Does a column of the given model vanish at a solution? A norm with an offset may explain all readings without its triad: scale factors 0, offset = g.
fn is_trivial(given: &DesignMatrix, fit: &Fit, campaign: &Campaign) -> bool {
    let norm = |design: &DesignMatrix, k: usize| design.jacobian.col_as_slice(k).iter().map(|v| v * v).sum::<f64>();
    let unknowns = campaign.estimated().iter().enumerate().take(given.jacobian.ncols());
    let there = |id: &str| fit.campaign.parameter_index(id).filter(|column| *column < fit.design.jacobian.ncols());
    unknowns
        .filter_map(|(k, parameter)| Some((k, there(&parameter.id)?)))
        .any(|(k, column)| norm(&fit.design, column) < VANISHED * VANISHED * norm(given, k))
}

struct Search<'a> {
    question: Question<'a>,
    model: Model,
    priors: Priors,
    chosen: Chosen,
    kept: Kept,
    /// Rows of the campaign as given, once they are known: the volume of its unknowns is measured there.
    reference: Option<DesignMatrix>,
}

impl<'a> Search<'a> {
    fn new(question: Question<'a>) -> Result<Self> {
        let model = Model::new(question.campaign)?;
        let chosen = screen::chosen(question.campaign);
        let sensors = question.campaign.bench.sensors.len();
        let priors = Priors::at(question.settings.significance).for_sensors(sensors);
        Ok(Search { question, model, priors, chosen, kept: Kept::new(), reference: None })
    }

    /// What the evidences of all points and weights differ by: `ln |V^-1| / 2 - ln |A'V^-1 A| / 2`, with the derivatives `A` of the campaign as given.
    ///
    /// A prior that is flat in the unknowns would favour points at which the readings determine them badly: where a known scale factor is a tenth of what
    /// it is, five tilts that are ten times as large have `10^5` times the volume. Flat in what the readings are predicted to be
    /// (`p(x) ~ |A'A|^(1/2)`; H. Jeffreys, Proc. R. Soc. A 186 (1946), 453), it is the same at every point, whatever an unknown is measured in.
    fn unit(&self, weighted: &Weighted) -> f64 {
        let rows = match &weighted.floor {
            Some(floor) => -0.5 * floor.whitening().log_determinant(),
            None => weighted.weight.iter().map(|w| w.ln()).sum::<f64>(),
        };
        let campaign = self.question.campaign;
        let given = self.reference.as_ref().and_then(|design| weighted.log_determinant(campaign, design).ok());
        rows - 0.5 * given.unwrap_or_else(|| weighted.estimate.factor.log_determinant())
    }

    /// The rows at a point; with the derivatives of the model that has some effects, if they were fitted and it is to be seen by itself.
    fn rows(
        &self,
        point: &[f64],
        fit: Option<(&Fit, &[&Candidate])>,
        by_itself: bool,
    ) -> Result<(DesignMatrix, Weighted)> {
        let campaign = self.question.campaign;
        let mut design = design::assemble(campaign, &self.model, point)?;
        let mut finished = None;
        if let Some((fit, effects)) = fit {
            let same = (fit.design.jacobian.nrows(), fit.design.predicted.len())
                == (design.jacobian.nrows(), design.predicted.len());
            if by_itself && same && !effects.iter().any(|c| assumptions::is_assumption(c)) {
                augment(campaign, &mut design, fit, effects);
            } else {
                let given = campaign.reference_point();
                for index in effects.iter().filter_map(|effect| campaign.parameter_index(&effect.coefficient)) {
                    let moved = point.get(index).zip(given.get(index)).map_or(0.0, |(now, before)| now - before);
                    if index >= campaign.unknowns() && index < design.jacobian.ncols() {
                        let slopes = design.jacobian.col_as_slice(index).to_vec();
                        design.predicted.iter_mut().zip(slopes).for_each(|(p, slope)| *p -= slope * moved);
                    }
                }
            }
            let variances = match fit.campaign.scatter.is_empty() {
                true => None,
                false => fit::scattered(&fit.campaign, &fit.design).ok(),
            };
            finished = Some(Finished { scales: fit.estimate.group_scale.clone(), variances });
        }
        let columns: Vec<&Vec<f64>> = fit.iter().flat_map(|(_, effects)| effects.iter().map(|c| &c.column)).collect();
        let weighted = own_noise::weigh(campaign, &design, finished.as_ref(), &columns, self.priors)?;
        Ok((design, weighted))
    }

    /// Rows and columns at a point, and how many members of long families have none.
    fn see(
        &mut self,
        point: &[f64],
        fit: Option<(&Fit, &[&Candidate])>,
    ) -> Result<(DesignMatrix, Weighted, Vec<Candidate>, usize)> {
        let Question { campaign, asked, catalogue, .. } = self.question;
        let (design, weighted) = self.rows(point, fit, false)?;
        let given: Vec<&Vec<f64>> = fit.iter().flat_map(|(_, effects)| effects.iter().map(|c| &c.column)).collect();
        let mut without_column = 0;
        for given in [&given, &[][..]] {
            let scan = Screen::new(campaign, &design, &weighted, &self.chosen, given);
            self.chosen.add(scan.strongest(&self.chosen));
            without_column = scan.without_column(&self.chosen);
        }
        for given in [&given, &[][..]] {
            self.chosen.add(screen::exchanged(campaign, &design, &weighted, given, self.priors.most));
        }
        let rows = weighted.weight.len();
        let mut candidates = build(campaign, catalogue, &self.model, &design, rows, &self.chosen, &mut self.kept)?;
        candidates.extend(assumptions::candidates(campaign, asked, &design)?);
        candidates.truncate(usize::from(u16::MAX));
        Ok((design, weighted, candidates, without_column))
    }

    fn view(
        &mut self,
        point: &[f64],
        fit: Option<(&Fit, &[&Candidate])>,
        judged: &[(Names, Option<f64>)],
    ) -> Result<View> {
        let Question { campaign, settings, .. } = self.question;
        let (design, weighted, mut candidates, without_column) = self.see(point, fit)?;
        let columns = weighted.columns(candidates.iter().map(|c| &c.column));
        let absurd = plain(&candidates, &design);
        let counted = |j: usize| {
            let largest = absurd.get(j).map_or(f64::INFINITY, |size| size * columns.col(j).norm_l2());
            self.priors.share_below(largest)
        };
        let odds = odds(candidates.iter(), &self.priors, counted);
        let kernels = bank(campaign, &design, &weighted);
        let problem = Problem {
            residual: &weighted.residual,
            basis: weighted.estimate.factor.thin_q(),
            columns: columns.as_ref(),
            prior: &odds,
            plain: &absurd,
            fixed: &candidates.iter().map(|c| c.fixed).collect::<Vec<_>>(),
            kinds: &kinds(candidates.iter(), &candidates),
            known: weighted.from == NoiseFrom::Stated,
            kernels: &kernels,
            sharing: None,
        };
        let mut score = Score::new(&problem, self.priors);
        let starts = judged.iter().filter(|(_, value)| value.is_some());
        let starts = starts.filter_map(|(names, _)| columns_of(&candidates, &score, names));
        score.search(&starts.filter(|set| !set.is_empty()).collect::<Vec<_>>());
        let unit = self.unit(&weighted);
        for (candidate, visible) in candidates.iter_mut().zip(&score.visible) {
            candidate.visible = *visible;
            candidate.vanishing |= *visible < settings.absorbed;
        }
        // it is made once sets that were judged are settled
        let posterior = Posterior::default();
        let mut view = View { design, weighted, candidates, without_column, score, unit, posterior };
        view.settle(judged);
        Ok(view)
    }

    /// ln p(y, S) at the solution of a set, by the rows of the model that has it: Laplace's integral.
    fn evidence(
        &mut self,
        (point, fit): (&[f64], &Fit),
        effects: &[&Candidate],
        odds: &[f64],
        remainder: (&[usize], f64),
    ) -> Result<(f64, Weighted)> {
        let Question { campaign, asked, catalogue, .. } = self.question;
        let (design, weighted) = self.rows(point, Some((fit, effects)), true)?;
        let families: Vec<Effect> =
            catalogue.iter().filter(|family| effects.iter().any(|c| c.family == family.term)).cloned().collect();
        let rows = weighted.weight.len();
        let mut candidates = build(campaign, &families, &self.model, &design, rows, &self.chosen, &mut self.kept)?;
        candidates.extend(assumptions::candidates(campaign, asked, &design)?);
        let same = |effect: &&Candidate| {
            candidates.iter().find(|c| c.regressor == effect.regressor && c.sensor == effect.sensor).cloned()
        };
        let Some(members) = effects.iter().map(same).collect::<Option<Vec<Candidate>>>() else {
            return Ok((f64::NEG_INFINITY, weighted));
        };
        let columns = weighted.columns(members.iter().map(|c| &c.column));
        let kernels = bank_of(campaign, &design, &weighted, |place, _| remainder.0.contains(&place));
        let problem = Problem {
            residual: &weighted.residual,
            basis: weighted.estimate.factor.thin_q(),
            columns: columns.as_ref(),
            prior: odds,
            plain: &plain(&members, &design),
            fixed: &members.iter().map(|c| c.fixed).collect::<Vec<_>>(),
            kinds: &kinds(members.iter(), &candidates),
            known: weighted.from == NoiseFrom::Stated,
            kernels: &kernels,
            sharing: Some(remainder.1),
        };
        let mut score = Score::new(&problem, self.priors);
        let set = columns_of(&members, &score, &names_of(members.iter())).filter(|set| set.len() == effects.len());
        let value = set.map_or(f64::NEG_INFINITY, |set| score.of(&set)) + self.unit(&weighted);
        Ok((if value.is_nan() { f64::NEG_INFINITY } else { value }, weighted))
    }

    /// The exact fit with some effects, begun from a point, and where it puts all parameters of the campaign. `None` where Gauss-Newton finds no solution, and the linear one, by
    /// the exact model, predicts other readings by more than their standard uncertainty: it is none.
    fn exact(
        &self,
        at: &View,
        effects: &[&Candidate],
        from: &[f64],
        by: fn(&Campaign, &fit::Settings) -> Result<Fit>,
    ) -> Result<Option<(Campaign, Fit, Vec<f64>)>> {
        let campaign = self.question.campaign;
        let repaired = repaired(campaign, effects)?;
        let mut relaxed = repaired.clone();
        let sizes = at.weighted.sizes_with(&at.design, campaign.unknowns(), effects.iter().map(|c| &c.column));
        let linear = effects.iter().zip(sizes.unwrap_or_default()).filter(|(c, _)| !assumptions::is_assumption(c));
        let linear = linear.map(|(c, size)| {
            let before = campaign.parameter_index(&c.coefficient).and_then(|k| campaign.parameters.get(k));
            // what the campaign does not have was zero in it
            (c.coefficient.as_str(), size + before.map_or(0.0, |p| p.reference()))
        });
        let places = campaign.parameters.iter().zip(from).map(|(p, value)| (p.id.as_str(), *value));
        for (id, value) in places.chain(linear) {
            let parameter = repaired.parameter_index(id).and_then(|k| relaxed.parameters.get_mut(k));
            if let Some(Role::Estimated { start, .. }) = parameter.map(|p| &mut p.role) {
                *start = Some(value);
            }
        }
        let mut fit = fit_exactly(&relaxed, by)?;
        fit.campaign.parameters = repaired.parameters.clone();
        let given = campaign.reference_point();
        let estimated = repaired.unknowns();
        let place = |id: &str| repaired.parameter_index(id).filter(|k| *k < estimated);
        let value_at = |(k, value): (usize, &f64)| {
            let fitted = campaign.parameters.get(k).and_then(|p| place(&p.id)).and_then(|k| fit.point.get(k));
            fitted.or_else(|| given.get(k)).copied().unwrap_or(*value)
        };
        let point = from.iter().enumerate().map(value_at).collect();
        let is_solution = fit.linearisation_error.is_none_or(|error| error <= 1.0);
        Ok(is_solution.then_some((repaired, fit, point)))
    }
}

/// The campaign as given, with what sets at their solutions are compared.
struct Home {
    design: DesignMatrix,
    weighted: Weighted,
}

/// A set at its solution.
struct FittedSet {
    value: f64,
    names: Names,
    point: Vec<f64>,
    fit: Fit,
}

impl Search<'_> {
    /// A set at its solution, fitted from a point; `None` where its exact fit leads elsewhere.
    fn fit_set(&mut self, home: &Home, at: &mut View, names: &Names, from: &[f64]) -> Result<Option<FittedSet>> {
        let set = columns_of(&at.candidates, &at.score, names);
        let kernels = set.map(|set| at.score.kernels_given(&set)).unwrap_or_default();
        let sharing = at.score.sharing;
        let at = &*at;
        let Some(effects) = at.members(names) else { return Ok(None) };
        let odds: Vec<f64> = names.iter().filter_map(|name| Some(at.odds(index(&at.candidates, name)?))).collect();
        let Ok(Some((_, fit, point))) = self.exact(at, &effects, from, fit::tried) else { return Ok(None) };
        if is_trivial(&home.design, &fit, self.question.campaign) {
            return Ok(None);
        }
        let (value, weighted) = self.evidence((&point, &fit), &effects, &odds, (&kernels, sharing))?;
        // at a jump of a term the model may leave other directions open: its evidence cannot be compared with that of other sets
        if weighted.estimate.factor.rank() != home.weighted.estimate.factor.rank() {
            return Ok(None);
        }
        let gap = home.weighted.squares(&weighted.estimate.residuals) / home.weighted.rss;
        // what the model as given misses is the same from every point from which it is seen straight
        let straight = gap > 1.0 / STRAIGHT && gap < STRAIGHT;
        Ok(straight.then(|| FittedSet { value, names: names.clone(), point, fit }))
    }
}

/// Sets that were judged, and the best of them.
struct Judged {
    nothing: f64,
    values: Vec<(Names, Option<f64>)>,
    best: Option<FittedSet>,
}

impl Judged {
    fn knows(&self, names: &Names) -> bool {
        self.values.iter().any(|(known, _)| known == names)
    }

    /// Each set at its solution, fitted from a point of which there is a view.
    fn judge(
        &mut self,
        search: &mut Search<'_>,
        home: &Home,
        (at, from): (&mut View, &[f64]),
        wanted: Vec<Names>,
    ) -> Result<()> {
        for names in wanted {
            if self.knows(&names) {
                continue;
            }
            let set_fit = search.fit_set(home, at, &names, from)?;
            self.values.push((names, set_fit.as_ref().map(|judged| judged.value)));
            let least = self.best.as_ref().map_or(self.nothing, |judged| judged.value);
            self.best = set_fit.filter(|judged| judged.value > least).or(self.best.take());
        }
        Ok(())
    }

    /// Sets of a view that are probable and not judged.
    fn open(&self, view: &View) -> Vec<Names> {
        let likely = view.posterior.sets.iter().take_while(|(p, _)| *p >= COMPETES);
        let likely = likely.map(|(_, set)| view.names(&view.plain(set)));
        likely.filter(|names| !self.knows(names)).take(RIVALS).collect()
    }
}

/// The effects of a campaign that was fitted at a point.
pub(super) fn run(question: Question<'_>, home: &[f64]) -> Result<Outcome> {
    let mut search = Search::new(question)?;
    let mut first = search.view(home, None, &[])?;
    search.reference = Some(first.design.clone());
    let base = &Home { design: first.design.clone(), weighted: first.weighted.clone() };
    let nothing = first.score.of(&[]) + first.unit;
    let mut judged = Judged { nothing, values: vec![(Names::new(), Some(nothing))], best: None };
    let is_judged = first.weighted.estimate.dof > 0;
    if is_judged {
        let wanted = hypotheses(&first);
        judged.judge(&mut search, base, (&mut first, home), wanted)?;
        // a large tilt changes the columns of the other effects: they are evaluated at the solution with the tilt alone
        for names in movers(&first) {
            let Some(set_fit) = search.fit_set(base, &mut first, &names, home)? else { continue };
            let fitted = first.members(&names).unwrap_or_default();
            let mut view = search.view(&set_fit.point, Some((&set_fit.fit, &fitted)), &judged.values)?;
            let wanted = judged.open(&view);
            judged.judge(&mut search, base, (&mut view, &set_fit.point), wanted)?;
        }
    }
    let mut there: Option<(Names, View)> = None;
    for _ in 0..VIEWS {
        match (&judged.best, &mut there) {
            (Some(best), Some((names, view))) if *names == best.names => view.settle(&judged.values),
            (Some(best), _) => {
                let at = there.as_ref().map_or(&first, |(_, view)| view);
                let fitted = at.members(&best.names).unwrap_or_default();
                let view = search.view(&best.point, Some((&best.fit, &fitted)), &judged.values)?;
                there = Some((best.names.clone(), view));
            }
            (None, _) => first.settle(&judged.values),
        }
        let wanted = judged.open(there.as_ref().map_or(&first, |(_, view)| view));
        if wanted.is_empty() || !is_judged {
            break;
        }
        let from = judged.best.as_ref().map_or(home, |best| &best.point).to_vec();
        let at = there.as_mut().map_or(&mut first, |(_, view)| view);
        judged.judge(&mut search, base, (at, &from), wanted)?;
    }
    let point = judged.best.as_ref().map_or(home, |best| &best.point);
    let (names, view) = there.unwrap_or((Names::new(), first));
    outcome(&search, &names, view, point, &[])
}

/// Tilts and known values that resemble a member of a probable set of several, each by itself: the most probable sets first.
fn movers(view: &View) -> Vec<Names> {
    let mut moving: Vec<Names> = Vec::new();
    let candidates = || (0_u16..).zip(&view.candidates).filter(|(_, c)| moves(c));
    let likely = view.posterior.sets.iter().take_while(|(p, _)| *p >= COMPETES);
    for (_, set) in likely.filter(|(_, set)| set.len() > 1) {
        for member in set.iter() {
            let others: Vec<u16> = set.iter().copied().filter(|j| j != member).collect();
            let alike = view.score.alike.get(usize::from(*member));
            let near = |j: u16| {
                alike.is_some_and(|same| same.contains(&j)) || view.score.cosine(&others, *member, j) >= RESEMBLES
            };
            for (j, _) in candidates().filter(|(j, _)| near(*j)) {
                let names = view.names(&[j]);
                if !moving.contains(&names) {
                    moving.push(names);
                }
            }
        }
    }
    moving.truncate(FIRST);
    moving
}

/// The most probable set, and those in which a tilt or a known value replaces a member.
fn hypotheses(view: &View) -> Vec<Names> {
    let sets = &view.posterior.sets;
    let names = |set: &[u16]| view.names(&view.plain(set));
    let mut wanted: Vec<Names> = sets.iter().take(1).map(|(_, set)| names(set)).collect();
    // what is estimated to scatter hides effects until they are in the model
    if view.weighted.floor.is_some() && view.weighted.from == NoiseFrom::Residuals {
        let best = |size: usize| sets.iter().find(|(_, set)| set.len() == size);
        wanted.extend([1, 2].into_iter().filter_map(best).map(|(_, set)| names(set)));
    }
    let mut seen: Vec<u16> = Vec::new();
    for (probability, set) in sets {
        if wanted.len() >= FOLLOWED || *probability < TRIED {
            break;
        }
        for (place, member) in set.iter().enumerate() {
            for other in view.score.alike.get(usize::from(*member)).into_iter().flatten() {
                if view.candidates.get(usize::from(*other)).is_some_and(moves) && !seen.contains(other) {
                    seen.push(*other);
                    let mut with = view.plain(set);
                    with.iter_mut().skip(place).take(1).for_each(|slot| *slot = *other);
                    wanted.push(view.names(&with));
                }
            }
        }
    }
    wanted.truncate(FOLLOWED);
    wanted
}

/// Explanations that count in the reported parameters, and their least probability.
const EXPLANATIONS: (usize, f64) = (64, 1e-3);

/// The one of the named effects whose value is the least in its standard uncertainty, what remains included, if it is not different from zero.
fn indifferent(
    named: &[&Candidate],
    view: &View,
    model: &(Campaign, Fit),
    deviations: &Deviations,
    of: &Campaign,
) -> Option<usize> {
    let (repaired, fit) = model;
    let size = |effect: &&Candidate| -> f64 {
        let (value, u, _) = coefficient(of, repaired, fit, effect);
        let index = repaired.estimated().iter().position(|p| p.id == effect.coefficient);
        let beyond = index.and_then(|j| beyond_noise(fit, &view.weighted, deviations, j));
        // what is not estimated by itself is not compared
        value.zip(u).map_or(f64::INFINITY, |(value, u)| value.abs() / u.hypot(beyond.unwrap_or_default()))
    };
    let sizes = named.iter().map(size).enumerate();
    sizes.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, size)| *size < DIFFERENT).map(|(place, _)| place)
}

/// What is named, what could stand in its place, and the model with it; some candidates are not different from zero and only suspected.
fn outcome(
    search: &Search<'_>,
    fitted_names: &Names,
    mut view: View,
    point: &[f64],
    zero: &[usize],
) -> Result<Outcome> {
    let settings = search.question.settings;
    let fronts = view.fronts();
    let posterior = view.posterior.clone();
    let mut named: Vec<(Member, &Class)> = Vec::new();
    let mut suspected: Vec<(Member, &Class)> = Vec::new();
    for (class, front) in posterior.classes.iter().zip(fronts) {
        let Some(front) = front else { continue };
        match class.probability {
            p if p >= settings.probability && !zero.contains(&front.candidate) => named.push((front, class)),
            p if p >= settings.suspected => suspected.push((front, class)),
            _ => {}
        }
    }
    let mut rivals: Vec<Rival> = Vec::new();
    for (place, (member, class)) in named.iter().enumerate() {
        for other in class.members.iter().filter(|rival| rival.candidate != member.candidate) {
            let share = other.probability / member.probability;
            let excess = -2.0 * (share / (other.odds / member.odds)).ln();
            // a rival that needs another effect is present as well, but replaces the member with no more than this share
            if excess <= 2.0 * ALIAS {
                rivals.push(Rival { place, candidate: other.candidate, share, excess });
            }
        }
    }
    let effects: Vec<&Candidate> = named.iter().filter_map(|(front, _)| view.candidates.get(front.candidate)).collect();
    let repair = match effects.is_empty() {
        true => None,
        false => {
            search.exact(&view, &effects, point, fit::fit).ok().flatten().map(|(repaired, fit, _)| (repaired, fit))
        }
    };
    let repair = match repair {
        Some((_, fit)) if is_trivial(&view.design, &fit, search.question.campaign) => None,
        other => other,
    };
    let names = names_of(effects.iter().copied());
    let set = columns_of(&view.candidates, &view.score, &names).unwrap_or_default();
    let each = view.score.deviations(&set);
    // made anew: views of long campaigns do not all keep theirs
    let kernels = bank(search.question.campaign, &view.design, &view.weighted);
    let mut deviations = Deviations { each, kernels };
    let least =
        repair.as_ref().and_then(|model| indifferent(&effects, &view, model, &deviations, search.question.campaign));
    if let Some((front, _)) = least.and_then(|place| named.get(place)) {
        let zero = [zero, &[front.candidate]].concat();
        return outcome(search, fitted_names, view, point, &zero);
    }
    let state = match (repair.is_some(), suspected.is_empty()) {
        (true, _) => State::Named,
        _ if posterior.nothing >= settings.suspected => State::Nothing,
        (_, false) => State::Suspected,
        _ => State::Outside,
    };
    // columns of which next to nothing is left tell nothing of the parameters
    let seen = |j: usize| view.candidates.get(j).is_some_and(|c| c.visible >= settings.absorbed);
    let likely = posterior.sets.iter().take(EXPLANATIONS.0).filter(|(p, _)| *p >= EXPLANATIONS.1);
    let mut explanations = Vec::new();
    for (probability, set) in likely.filter(|_| state != State::Nothing) {
        let members = view.score.shares(set).into_iter();
        let members = members.map(|shares| shares.into_iter().filter(|(j, _)| seen(*j)).collect()).collect();
        explanations.push(Explanation { probability: *probability, members });
    }
    // what is there beyond the effects named, and beyond those that are suspected too
    let beyond = |effects: &[&(Member, &Class)]| {
        let columns = effects.iter().filter_map(|(member, _)| view.score.standing(member.candidate));
        let count = view.score.effects(&columns.collect::<Vec<_>>());
        1.0 - posterior.alone.iter().take(count + 1).sum::<f64>()
    };
    let further = beyond(&named.iter().collect::<Vec<_>>());
    let unaccounted = beyond(&named.iter().chain(&suspected).collect::<Vec<_>>());
    let probable =
        |classes: &[(Member, &Class)]| classes.iter().map(|(j, class)| (j.candidate, class.probability)).collect();
    let (named, suspected): (Vec<(usize, f64)>, Vec<(usize, f64)>) = (probable(&named), probable(&suspected));
    let remainder = view.score.foremost(&set);
    let View { candidates, weighted: scored, design, without_column, score, .. } = view;
    let mut weighted = scored.clone();
    // noise that is not stated is that of the model with what is named, not with what is suspected
    if weighted.from != NoiseFrom::Stated && weighted.floor.is_none() && names != *fitted_names {
        let scales = repair.as_ref().map(|(_, fit)| fit.estimate.group_scale.clone());
        let finished = scales.map(|scales| Finished { scales, variances: None });
        let columns: Vec<&Vec<f64>> = named.iter().filter_map(|(j, _)| candidates.get(*j)).map(|c| &c.column).collect();
        let anew = own_noise::weigh(search.question.campaign, &design, finished.as_ref(), &columns, search.priors)?;
        let square = |at: &Weighted| at.weight.iter().map(|w| w * w).sum::<f64>();
        let ratio = square(&anew) / square(&weighted);
        deviations.each.iter_mut().for_each(|deviation| deviation.variance *= ratio);
        weighted = anew;
    }
    let tests = score.distinct() + without_column;
    let outside = posterior.outside;
    let further = further.clamp(0.0, 1.0);
    let seen = Seen {
        candidates,
        score,
        scored,
        remainder,
        tests,
        weighted,
        design,
        named,
        suspected,
        rivals,
        explanations,
        state,
        further,
        unaccounted,
        outside,
        deviations,
    };
    Ok((seen, repair))
}

/// Every candidate for this campaign at its fitted model, with the standard uncertainty that its coefficient would have in it.
///
/// What a schedule can see: an effect of less than five of these hides in the noise. Infinite where the model absorbs it.
/// Errors: as [`super::diagnose`].
pub fn candidates(campaign: &Campaign, catalogue: &[Effect]) -> Result<Vec<(Candidate, f64)>> {
    let assumed = assumptions::hold(campaign)?;
    let fit = fit_exactly(&assumed.campaign, fit::tried)?;
    let settings = Settings::default();
    let question = Question { campaign: &assumed.campaign, asked: &assumed.asked, catalogue, settings: &settings };
    let point: Vec<f64> = fit.point.iter().take(fit.design.point.len()).copied().collect();
    let (_, weighted, mut candidates, _) = Search::new(question)?.see(&point, None)?;
    let columns = weighted.columns(candidates.iter().map(|c| &c.column));
    let score = Score::of_columns(columns.as_ref(), weighted.estimate.factor.thin_q(), &weighted.residual);
    for (candidate, visible) in candidates.iter_mut().zip(&score.visible) {
        candidate.visible = *visible;
        candidate.vanishing |= *visible < settings.absorbed;
    }
    let with_u = |candidate: Candidate| {
        let u = 1.0 / (weighted.norm(&candidate.column) * candidate.visible);
        (candidate, u)
    };
    Ok(candidates.into_iter().map(with_u).collect())
}
