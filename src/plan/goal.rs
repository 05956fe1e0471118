//! To a goal: the fewest, or the cheapest, positions that bring every uncertainty under its limit.
//!
//! The objective is the largest `u^2 / limit^2`; a derived quantity without a derivative at the point counts with every direction nearby.

use super::blocks::{Blocks, times};
use super::bound::bound;
use super::criterion::{gradients_of, no_result, weight_matrix};
use super::effort::Offer;
use super::exchange::value;
use super::improve::{Improvement, Question, guide};
use super::judge::{Judgement, is_angle};
use super::objective::Objective;
use super::pool::{Pool, from_coarser};
use super::prices::Prices;
use super::problem::{Problem, information};
use super::request::Request;
use super::search::{EFFORT, Limits, search};
use crate::campaign::{Campaign, Reading};
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use crate::linear::dot;
use crate::units::ARCSEC;
use std::collections::BTreeMap;

/// A limit on the standard uncertainty of one estimated parameter (radians for a tilt) or derived quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Goal {
    /// The parameter or derived quantity.
    pub id: String,
    /// Largest standard uncertainty.
    pub u: f64,
}

/// The schedule that reaches the goals, or comes nearest to them.
#[derive(Debug, Clone)]
pub struct Reached {
    /// The schedule and how well it will do.
    pub improvement: Improvement,
    /// Whether it reaches them.
    pub goal: GoalOutcome,
}

/// Whether a goal was reached.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "GoalReport")]
#[non_exhaustive]
pub struct GoalOutcome {
    /// Limit of each parameter and derived quantity that is counted, in its unit (arcsec for angles).
    pub limits: BTreeMap<String, f64>,
    /// Are all limits kept? If not, this schedule is the best reachable with so many readings.
    pub reached: bool,
    /// Largest uncertainty as a share of its limit.
    pub largest_share: Option<f64>,
    /// Is it proven that no fewer readings of these candidates reach the goal?
    pub is_fewest: bool,
    /// Was the cheapest schedule sought? It is the cheapest that was found, without a proof that none is cheaper.
    #[serde(default)]
    pub is_cheapest_found: bool,
    /// Limited quantities that even all candidates together do not determine.
    pub impossible: Vec<String>,
}

/// Reweighting rounds of the bound: the sum of `(u/limit)^2` becomes the largest of them.
const ROUNDS: usize = 8;
/// Starts and effort of one of the many searches on the way; the last ones have the request's.
const STARTS: usize = 24;
const LITTLE: f64 = EFFORT / 8.0;

/// The fewest readings that reach the goals; with `cheapest`, the cheapest schedule of the search.
///
/// `request.readings` is the most that may be chosen; its criterion plays no part. A goal that cannot be reached is a result: `reached` is false
/// and the schedule is the best reachable with that many readings. Errors: those of [`super::improve`], a limit that is not positive, a quantity
/// that is neither estimated nor derived.
pub fn reach(campaign: &Campaign, offer: &Offer, request: &Request, goals: &[Goal], cheapest: bool) -> Result<Reached> {
    let question = &Question::new(campaign, offer, request)?;
    let pool = question.pool(&offer.candidates)?;
    let (rows, impossible) = limits(campaign, &pool, goals)?;
    let size = pool.portion_size();
    let most = request.readings / size;
    let search = Search::new(question, &pool, rows, request, most);
    if search.most == 0 {
        return Err(Malformed::new(Fault::Value, "no reading may be chosen, so no goal can be sought")
            .expected(format!("at least {size} readings allowed"))
            .found(request.readings.to_string()));
    }
    // the search starts from the results of coarser sweeps within this one
    let best = |pool: &Pool, given: &[Vec<usize>]| {
        let (rows, missing) = limits(campaign, pool, goals).ok()?;
        let search = Search::new(question, pool, rows, request, most);
        Some((missing == impossible).then(|| search.best(given, cheapest)).flatten()?.chosen)
    };
    let given = from_coarser(&offer.candidates, &pool, |readings| question.pool(readings), best);
    let mut result = search.best(&given, cheapest).ok_or_else(|| {
        Malformed::new(Fault::Value, format!("no {} of these candidates determine the unknowns", search.most * size))
            .expected("more readings, more candidates, or a prior")
    })?;
    let moved = |rows: &[Reading]| question.refined(rows, (&pool, &search.objective), Some(1.0));
    let (mut rows, mut refined) = (question.rows(&pool, &result.chosen), None);
    // a schedule within the limits is not moved: that would raise uncertainties without limits
    if !result.reaches()
        && let Some((other, what)) = moved(&rows)?
    {
        (rows, refined) = (other, Some(what));
    }
    // with angles between the candidates, fewer readings may be enough
    let fewer = |result: &Reach| if cheapest || result.chosen.len() < 2 { None } else { search.one_fewer(result) };
    while let Some(fewer) = request.refine.as_ref().and_then(|_| fewer(&result)) {
        let Some((other, what)) = moved(&question.rows(&pool, &fewer.chosen))? else { break };
        if !(what.value <= 1.0) {
            break;
        }
        (result, rows, refined) = (Reach { is_fewest: false, ..fewer }, other, Some(what));
    }
    let made = question.made(&pool, rows)?;
    let largest_share = largest_share(&made.judgement, goals);
    let limit = |goal: &Goal| (goal.id.clone(), goal.u * if is_angle(campaign, &goal.id) { ARCSEC } else { 1.0 });
    let goal = GoalOutcome {
        limits: goals.iter().map(limit).collect(),
        reached: impossible.is_empty() && largest_share.is_some_and(|share| share <= 1.0),
        largest_share,
        // the proof is for the candidates alone, not for angles between them
        is_fewest: result.is_fewest && request.refine.is_none(),
        is_cheapest_found: cheapest,
        impossible,
    };
    Ok(Reached { improvement: Improvement { refined, hits: result.hits, starts: result.starts, ..made }, goal })
}

fn largest_share(judgement: &Judgement, goals: &[Goal]) -> Option<f64> {
    let u = |id: &str| {
        let parameter = judgement.parameters.iter().find(|p| p.id == id).map(|p| p.u);
        parameter.or_else(|| judgement.derived.iter().find(|d| d.id == id).map(|d| d.u)).flatten()
    };
    goals
        .iter()
        .map(|goal| u(&goal.id).map(|u| u / goal.u))
        .try_fold(0.0_f64, |most, share| share.map(|share| most.max(share)))
}

/// Coordinates of each limited quantity divided by its limit, and the quantities that no candidate determines.
fn limits(campaign: &Campaign, pool: &Pool, goals: &[Goal]) -> Result<(Vec<Vec<f64>>, Vec<String>)> {
    let (mut limits, mut impossible) = (Vec::new(), Vec::new());
    for goal in goals {
        let Some(rows) = gradients_of(campaign, &goal.id)? else {
            let what = format!("a goal is set for '{}', which is neither estimated nor derived", goal.id);
            return Err(no_result(campaign, what, "", &goal.id));
        };
        if !(goal.u > 0.0 && goal.u.is_finite()) {
            return Err(Malformed::new(Fault::Value, format!("the goal for '{}' is not positive", goal.id))
                .expected("a positive standard uncertainty")
                .found(goal.u.to_string()));
        }
        let coordinates: Option<Vec<Vec<f64>>> =
            rows.iter().map(|row| pool.coordinates(&row.iter().map(|c| c / goal.u).collect::<Vec<f64>>())).collect();
        match coordinates.filter(|coordinates| !coordinates.is_empty()) {
            Some(coordinates) => limits.extend(coordinates),
            None => impossible.push(goal.id.clone()),
        }
    }
    if goals.is_empty() || limits.is_empty() {
        let error = Malformed::new(Fault::Value, "no goal can be sought");
        return Err(match impossible.is_empty() {
            true => error.expected("a limit on at least one angle, parameter or derived quantity"),
            false => error
                .expected("a limit on a quantity that the candidates determine")
                .found(format!("{}: even all candidates together do not determine it", impossible.join(", "))),
        });
    }
    Ok((limits, impossible))
}

#[derive(Debug, Clone)]
struct Reach {
    chosen: Vec<usize>,
    /// Largest `u / limit`.
    share: f64,
    is_fewest: bool,
    /// Were all designs of this size tried?
    all_tried: bool,
    hits: usize,
    starts: usize,
}

impl Reach {
    fn reaches(&self) -> bool {
        self.share <= 1.0
    }
}

struct Search<'a> {
    pool: &'a Pool,
    rows: Vec<Vec<f64>>,
    objective: Objective,
    request: &'a Request,
    prices: Prices,
    /// Portions that may be chosen.
    most: usize,
}

impl<'a> Search<'a> {
    fn new(question: &Question<'_>, pool: &'a Pool, rows: Vec<Vec<f64>>, request: &'a Request, most: usize) -> Self {
        let n = pool.blocks.unknowns();
        let limited = Blocks::from_fn(rows.len(), 1, n, |j, _, c| rows.at(j).at(c));
        let (objective, prices) = (Objective::Largest(limited), question.prices(pool, 0.0));
        let most = most.min(pool.portions.len().saturating_mul(request.most_repeats));
        Search { pool, rows, objective, request, prices, most }
    }

    fn best(&self, given: &[Vec<usize>], cheapest: bool) -> Option<Reach> {
        let fewest = self.fewest(given)?;
        if !cheapest || !fewest.reaches() {
            return Some(fewest);
        }
        Some(self.cheapest(fewest, given))
    }

    /// The best with one portion fewer, which need not keep the limits.
    fn one_fewer(&self, result: &Reach) -> Option<Reach> {
        self.seek(&self.problem(result.chosen.len().checked_sub(1)?, None), &[], true)
    }

    fn problem<'p>(&'p self, choose: usize, prices: Option<&'p Prices>) -> Problem<'p> {
        let most_repeats = self.request.most_repeats;
        Problem { choose, most_repeats, prices, ..Problem::of(&self.pool.blocks, &self.pool.base, &self.objective) }
    }

    /// The design whose largest `u / limit` is smallest; with little effort unless it matters.
    fn seek(&self, problem: &Problem<'_>, given: &[Vec<usize>], earnest: bool) -> Option<Reach> {
        let given = || given.to_vec();
        let all = Limits::of(self.request, &given);
        let limits = match earnest {
            true => Limits { enough: Some(1.0), ..all },
            false => Limits { enough: Some(1.0), starts: STARTS.min(self.request.starts), effort: LITTLE, ..all },
        };
        let many = problem.prices.is_none() && problem.has_many();
        let outcome = search(problem, &limits, || many.then(|| guide(problem)).flatten())?;
        Some(Reach {
            chosen: outcome.design.chosen,
            share: outcome.design.value.max(0.0).sqrt(),
            is_fewest: false,
            all_tried: outcome.enumerated.is_some(),
            hits: outcome.hits,
            starts: outcome.starts,
        })
    }

    /// The fewest portions, at most `most`, that keep every limit; if none do, the best with `most`.
    fn fewest(&self, given: &[Vec<usize>]) -> Option<Reach> {
        let blocks = &self.pool.blocks;
        let with = |choose: usize, earnest: bool| self.seek(&self.problem(choose, None), given, earnest);
        // the kept readings may be enough
        let kept = value(&self.objective, &information(blocks, &self.pool.base, &[]), blocks.unknowns());
        if let Some(share) = kept.map(|value| value.max(0.0).sqrt()).filter(|share| *share <= 1.0) {
            return Some(Reach { chosen: Vec::new(), share, is_fewest: true, all_tried: true, hits: 1, starts: 1 });
        }
        let known = given.iter().map(Vec::len).filter(|count| *count <= self.most).min();
        let mut low = 0; // too few
        let mut high = blocks.unknowns().div_ceil(blocks.rows().max(1)).clamp(1, self.most.max(1));
        let mut best = loop {
            match with(high, high >= self.most) {
                Some(result) if result.reaches() => break result,
                result if high >= self.most => return result,
                _ => {
                    low = high;
                    high = (2 * high).min(self.most);
                    // a coarser sweep may have reached the limits with so many
                    if let Some(known) = known.filter(|known| *known > low) {
                        high = high.min(known);
                    }
                }
            }
        };
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            match with(middle, false) {
                Some(result) if result.reaches() => (high, best) = (middle, result),
                _ => low = middle,
            }
        }
        // one fewer with the full effort, until the limits are missed
        let mut proven = high == 1;
        while high > 1 {
            match with(high - 1, true) {
                Some(result) if result.reaches() => (high, best) = (high - 1, result),
                Some(result) if result.all_tried => {
                    proven = true;
                    break;
                }
                _ => break,
            }
        }
        best.is_fewest = proven || high == 1 || self.too_few(high - 1);
        Some(best)
    }

    /// The cheapest below the cost of one that keeps every limit: by bisection, then by single steps of the cost.
    fn cheapest(&self, fewest: Reach, given: &[Vec<usize>]) -> Reach {
        let cost = |chosen: &[usize]| self.prices.of(chosen);
        let blocks = &self.pool.blocks;
        let reaches = |chosen: &Vec<usize>| {
            let m = information(blocks, &self.pool.base, chosen);
            let value = value(&self.objective, &m, blocks.unknowns());
            value.is_some_and(|value| value <= 1.0) && chosen.len() <= self.most
        };
        let mut best = Reach { is_fewest: false, ..fewest };
        for chosen in given.iter().filter(|chosen| reaches(chosen)) {
            if cost(chosen) < cost(&best.chosen) {
                best.chosen.clone_from(chosen);
            }
        }
        let mut high = cost(&best.chosen);
        // all cost alike: one step
        let step = self.prices.least_step().unwrap_or(high);
        let within = |budget: f64, best: &Reach, earnest: bool| {
            let prices = self.prices.with_budget(budget);
            let all: Vec<Vec<usize>> = given.iter().chain([&best.chosen]).cloned().collect();
            self.seek(&self.problem(self.most, Some(&prices)), &all, earnest).filter(Reach::reaches)
        };
        // nothing costs less than one portion
        let mut low = (0..self.pool.portions.len()).map(|j| self.prices.alone(j)).fold(high, f64::min) - step;
        while high - low > 1.5 * step {
            let middle = (0.5 * (low + high)).min(high - step);
            match within(middle, &best, false) {
                Some(result) => {
                    high = cost(&result.chosen);
                    best = result;
                }
                None => low = middle,
            }
        }
        while high > step {
            match within(high - step, &best, true) {
                Some(result) if cost(&result.chosen) < high => {
                    high = cost(&result.chosen);
                    best = result;
                }
                _ => break,
            }
        }
        best
    }

    /// Do even the best weights of `choose` portions exceed a limit? They do if `sum l u^2/limit^2 > sum l` for some weights `l`.
    fn too_few(&self, choose: usize) -> bool {
        let blocks = &self.pool.blocks;
        let fewest = blocks.unknowns().div_ceil(blocks.rows().max(1));
        if self.pool.base.iter().all(|b| *b == 0.0) && choose < fewest {
            return true;
        }
        let mut weights = vec![1.0; self.rows.len()];
        for _ in 0..ROUNDS {
            let terms: Vec<(f64, Vec<f64>)> = weights.iter().copied().zip(self.rows.iter().cloned()).collect();
            let objective = Objective::Trace(weight_matrix(&terms, blocks.unknowns()));
            let Some(best) = bound(blocks, &self.pool.base, &objective, choose as f64) else { return false };
            if best.value > weights.iter().sum::<f64>() * (1.0 + 1e-9) {
                return true;
            }
            let Some(inverse) = best.inverse(blocks, &self.pool.base, choose as f64) else { return false };
            let squares: Vec<f64> = self.rows.iter().map(|c| dot(c, &times(&inverse, c))).collect();
            let mean = squares.iter().sum::<f64>() / squares.len() as f64;
            weights.iter_mut().zip(&squares).for_each(|(w, s)| *w *= s / mean);
        }
        false
    }
}
