//! To a goal: the fewest, or the cheapest, positions that bring every uncertainty under its limit.
//!
//! The objective is the largest `u^2 / limit^2`; a derived quantity without a derivative at the point counts with every direction nearby.

use super::blocks::Blocks;
use super::bound::bound;
use super::criterion::{gradients_of, no_result};
use super::effort::Offer;
use super::improve::{Improvement, SearchRecord};
use super::judge::{Judgement, is_angle};
use super::objective::Objective;
use super::pool::Pool;
use super::problem::Problem;
use super::question::Question;
use super::request::Request;
use super::search::{EFFORT, Limits, Outcome, least};
use crate::campaign::{Campaign, Reading};
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use crate::number;
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

/// Starts and effort of one of the many searches on the way; the last ones have the request's.
const STARTS: usize = 24;
const LITTLE: f64 = EFFORT / 8.0;

/// The fewest readings that reach the goals; with `cheapest`, the cheapest schedule of the search.
///
/// `request.readings` is the most that may be chosen; its criterion plays no part. A goal that cannot be reached is a result: `reached` is false
/// and the schedule is the best reachable with that many readings. Errors: those of [`super::improve`], a limit that is not positive, a quantity
/// that is neither estimated nor derived.
pub fn reach(campaign: &Campaign, offer: &Offer, request: &Request, goals: &[Goal], cheapest: bool) -> Result<Reached> {
    let question = &Question::new(campaign, offer, request, &[])?;
    let (objective, impossible) = limits(campaign, &question.pool, goals)?;
    let size = question.pool.portion_size();
    let most = Search::of(question, &objective, &[]).most;
    if most == 0 {
        return Err(Malformed::new(Fault::Value, "no reading may be chosen, so no goal can be sought")
            .expected(format!("at least {size} readings allowed"))
            .found(request.readings.to_string()));
    }
    let best = |question: &Question<'_>, given: &[Vec<usize>]| {
        Some(Search::of(question, &objective, given).best(cheapest)?.0.design.chosen)
    };
    let given = question.coarser(&best);
    let search = Search::of(question, &objective, &given);
    let (mut outcome, mut is_fewest) = search.best(cheapest).ok_or_else(|| {
        Malformed::new(
            Fault::Value,
            format!("no choice of {} of these candidates determines the unknowns", most * size),
        )
        .expected("more readings, more candidates, or a prior")
    })?;
    let moved = |rows: &[Reading]| question.refined(rows, &objective, Some(1.0));
    let (mut rows, mut refined) = (question.rows(&outcome.design.chosen), None);
    // a schedule within the limits is not moved: that would raise uncertainties without limits
    if !reaches(&outcome)
        && let Some((other, what)) = moved(&rows)?
    {
        (rows, refined) = (other, Some(what));
    }
    // with angles between the candidates, fewer readings may be enough
    let fewer = |outcome: &Outcome| {
        let one_fewer = outcome.design.chosen.len().checked_sub(1).filter(|fewer| *fewer > 0 && !cheapest)?;
        Search { given: &[], ..search }.seek(one_fewer, None, true)
    };
    while let Some(less) = request.refine.as_ref().and_then(|_| fewer(&outcome)) {
        let Some((other, what)) = moved(&question.rows(&less.design.chosen))? else { break };
        if !(what.value <= 1.0) {
            break;
        }
        (outcome, is_fewest, rows, refined) = (less, false, other, Some(what));
    }
    let made = question.made(&rows)?;
    let largest_share = largest_share(&made.judgement, goals);
    let limit = |goal: &Goal| (goal.id.clone(), goal.u * if is_angle(campaign, &goal.id) { ARCSEC } else { 1.0 });
    let goal = GoalOutcome {
        limits: goals.iter().map(limit).collect(),
        reached: impossible.is_empty() && largest_share.is_some_and(|share| share <= 1.0),
        largest_share,
        // the proof is for the candidates alone, not for angles between them
        is_fewest: is_fewest && request.refine.is_none(),
        is_cheapest_found: cheapest,
        impossible,
    };
    let Outcome { hits, starts, .. } = outcome;
    let search = SearchRecord { refined, hits, starts, ..SearchRecord::default() };
    Ok(Reached { improvement: Improvement { search, ..made }, goal })
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

/// The largest `u^2 / limit^2`, and the quantities that no candidate determines.
fn limits(campaign: &Campaign, pool: &Pool, goals: &[Goal]) -> Result<(Objective, Vec<String>)> {
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
    let rows = Blocks::from_fn(limits.len(), 1, pool.blocks.unknowns(), |j, _, c| limits.at(j).at(c));
    Ok((Objective::Largest(rows), impossible))
}

/// Are all limits kept?
fn reaches(outcome: &Outcome) -> bool {
    outcome.design.value <= 1.0
}

/// The search for a design; it ends with one, and whether it is proven that no smaller one keeps the limits.
#[derive(Clone, Copy)]
struct Search<'a> {
    question: &'a Question<'a>,
    objective: &'a Objective,
    /// Designs from which exchanges start.
    given: &'a [Vec<usize>],
    /// Portions that may be chosen.
    most: usize,
}

impl<'a> Search<'a> {
    fn of(question: &'a Question<'_>, objective: &'a Objective, given: &'a [Vec<usize>]) -> Self {
        let Question { pool, request, .. } = question;
        let most = pool.portions.len().saturating_mul(request.most_repeats);
        Search { question, objective, given, most: most.min(request.readings / pool.portion_size()) }
    }

    fn best(&self, cheapest: bool) -> Option<(Outcome, bool)> {
        let (fewest, is_fewest) = self.fewest()?;
        Some(if cheapest && reaches(&fewest) { (self.cheapest(fewest), false) } else { (fewest, is_fewest) })
    }

    /// The design whose largest `u / limit` is smallest; with little effort unless it matters.
    fn seek(&self, choose: usize, budget: Option<f64>, earnest: bool) -> Option<Outcome> {
        let given = || self.given.to_vec();
        let all = Limits { enough: Some(1.0), bounded: false, ..Limits::of(self.question.request, &given) };
        let limits = match earnest {
            true => all,
            false => Limits { starts: STARTS.min(all.starts), effort: LITTLE, ..all },
        };
        self.question.seek(self.objective, choose, budget, &limits)
    }

    /// The fewest portions, at most `most`, that keep every limit; if none do, the best with `most`.
    fn fewest(&self) -> Option<(Outcome, bool)> {
        let blocks = &self.question.pool.blocks;
        let known = self.given.iter().map(Vec::len).filter(|count| *count <= self.most).min();
        let least_regular = blocks.unknowns().div_ceil(blocks.rows().max(1)).clamp(1, self.most.max(1));
        // the kept readings may be enough
        let (mut low, mut high) = (0, 0);
        let first = loop {
            match self.seek(high, None, high >= self.most) {
                Some(outcome) if reaches(&outcome) => break outcome,
                outcome if high >= self.most => return outcome.map(|outcome| (outcome, false)),
                _ => {
                    low = high;
                    // a coarser sweep may have reached the limits with so many
                    let known = known.filter(|known| *known > low).unwrap_or(self.most);
                    high = if low == 0 { least_regular } else { (2 * high).min(self.most).min(known) };
                }
            }
        };
        let mut proven = false;
        let (fewest, outcome) = least(low as f64, (high as f64, first), 1.0, |portions, _, earnest| {
            let portions = number::count(portions);
            let outcome = if portions > 0 { self.seek(portions, None, earnest)? } else { return None };
            proven |= earnest && !reaches(&outcome) && outcome.enumerated.is_some();
            reaches(&outcome).then_some((portions as f64, outcome))
        });
        Some((outcome, proven || fewest <= 1.0 || self.too_few(fewest - 1.0)))
    }

    /// The cheapest below the cost of one that keeps every limit.
    fn cheapest(&self, fewest: Outcome) -> Outcome {
        let Question { pool, prices, .. } = self.question;
        let problem = Problem::of(&pool.blocks, &pool.base, self.objective);
        let cost = |outcome: &Outcome| prices.of(&outcome.design.chosen);
        let given = self.given.iter().filter(|given| given.len() <= self.most);
        let designs = given.filter_map(|given| problem.design(given.clone()));
        let first = designs.map(|design| Outcome { design, ..fewest.clone() }).filter(reaches);
        let first = first.fold(fewest.clone(), |best, other| if cost(&other) < cost(&best) { other } else { best });
        let high = cost(&first);
        // all cost alike: one step
        let step = prices.least_step().unwrap_or(high);
        // nothing costs less than one portion
        let low = prices.cheapest().min(high) - step;
        let (_, cheapest) = least(low, (high, first), step, |budget, best, earnest| {
            let given: Vec<Vec<usize>> = self.given.iter().chain([&best.design.chosen]).cloned().collect();
            let within = Search { given: &given, ..*self };
            let outcome = if budget > 0.0 { within.seek(self.most, Some(budget), earnest)? } else { return None };
            reaches(&outcome).then(|| (cost(&outcome), outcome))
        });
        cheapest
    }

    /// Do even the best weights of so many portions exceed a limit?
    fn too_few(&self, portions: f64) -> bool {
        let Pool { blocks, base, .. } = &self.question.pool;
        let determined = portions * blocks.rows() as f64 >= blocks.unknowns() as f64 || base.iter().any(|b| *b != 0.0);
        let best = bound(blocks, base, self.objective, portions);
        !determined || best.is_some_and(|best| best.value > 1.0 + 1e-9)
    }
}
