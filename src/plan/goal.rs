//! To a goal: the fewest, or the cheapest, positions that bring every uncertainty under its limit.

use super::blocks::{Blocks, dot, invert, times};
use super::bound::bound;
use super::budget::{self, Prices};
use super::candidates::frozen;
use super::criterion::weight_matrix;
use super::effort::{Costs, Offer, mounting, positions_only};
use super::exchange::{Design, Objective, Problem, best_of_starts, information};
use super::improve::{Improvement, Request, relabelled, schedule_rows};
use super::judge::{Judgement, check_question, judge};
use super::order::{Order, ordered};
use super::point::check_point;
use super::pool::Pool;
use crate::campaign::{Campaign, Reading, Readings};
use crate::error::{Fault, Malformed, Result};

/// A limit on the standard uncertainty of one estimated parameter: radians for a tilt.
#[derive(Debug, Clone, PartialEq)]
pub struct Goal {
    /// The parameter.
    pub id: String,
    /// Largest standard uncertainty.
    pub u: f64,
}

/// The schedule that reaches the goals, or the best reachable.
#[derive(Debug, Clone)]
pub struct Reached {
    /// The schedule and how well it will do.
    pub improvement: Improvement,
    /// Does every parameter keep its limit?
    pub reached: bool,
    /// Largest predicted uncertainty as a share of its limit; `None` where a limited parameter is not estimable.
    pub largest_share: Option<f64>,
    /// Is it proven (by the approximate design) that no fewer readings of these candidates reach the goals?
    pub is_fewest: bool,
    /// Was the cheapest schedule sought instead? It is the cheapest that was found; no proof goes with it.
    pub is_cheapest_found: bool,
    /// Limits on parameters that even all candidates together do not determine.
    pub impossible: Vec<String>,
}

/// Reweighting rounds: the sum of `(u/limit)^2` becomes the largest of them.
const ROUNDS: usize = 8;
/// Budgets that are tried below the cost of a schedule that reaches the goals, and starts for each.
const BUDGETS: usize = 10;
const BUDGET_STARTS: usize = 20;
/// With more candidate portions than this, one budget takes too long to be tried so often.
const MOST_PORTIONS: usize = 1500;

/// The fewest readings that reach the goals; with `cheapest`, the cheapest schedule that is found: fewer mountings are tried, then smaller budgets.
///
/// Limits are on estimated parameters; derived quantities do not count.
/// `request.readings` is the most that may be chosen; its criterion plays no part. A goal that cannot be reached is a result: `reached` is false
/// and the schedule is the best reachable with that many readings. Errors: those of [`super::improve`], a limit that is not positive, a parameter
/// that is not estimated.
pub fn reach(campaign: &Campaign, offer: &Offer, request: &Request, goals: &[Goal], cheapest: bool) -> Result<Reached> {
    let Offer { candidates, noise, costs, .. } = offer;
    let kept = &positions_only(&offer.kept);
    check_question(campaign)?;
    costs.check()?;
    check_point(campaign, kept, candidates, noise)?;
    let pool = Pool::new(campaign, kept, candidates, request.unit, noise, &[])?;
    let (limits, impossible) = limits(campaign, &pool, goals)?;
    let size = pool.portion_size();
    let most = (request.readings / size).min(pool.portions.len().saturating_mul(request.most_repeats));
    if most == 0 {
        return Err(Malformed::new(Fault::Value, "no reading may be chosen, so no goal can be sought")
            .expected(format!("at least {size} readings allowed"))
            .found(request.readings.to_string()));
    }
    let all: Vec<usize> = (0..pool.portions.len()).collect();
    let search = Search { pool: &pool, limits: &limits, request };
    let mut found = search.fewest(&all, most).ok_or_else(|| {
        Malformed::new(Fault::Value, format!("no {} of these candidates determine the unknowns", most * size))
            .expected("more readings, more candidates, or a prior")
    })?;
    let scatters = !noise.remount.is_empty();
    let run = |chosen: &[usize]| -> Result<Campaign> {
        let rows = schedule_rows(kept, &pool, chosen, scatters);
        let unordered = campaign.with_readings(Readings { columns: kept.columns.clone(), rows });
        Ok(campaign.with_readings(ordered(&unordered, noise, Order::Abba, request.seed)?))
    };
    if cheapest && found.share <= 1.0 {
        let mut cost = costs.work(&run(&found.chosen)?.readings.rows).cost;
        loop {
            let mountings = distinct_mountings(&pool, &found.chosen);
            let mut better: Option<(f64, Found)> = None;
            for dropped in 0..mountings.len() {
                let stays = |k: &usize| {
                    let own = pool.portions.get(*k).and_then(|p| p.first()).map(mounting).unwrap_or_default();
                    mountings.iter().enumerate().any(|(m, place)| m != dropped && *place == own)
                };
                let allowed: Vec<usize> = all.iter().copied().filter(stays).collect();
                let Some(other) = search.fewest(&allowed, most).filter(|other| other.share <= 1.0) else { continue };
                let other_cost = costs.work(&run(&other.chosen)?.readings.rows).cost;
                if other_cost < better.as_ref().map_or(cost, |(best, _)| *best) {
                    better = Some((other_cost, other));
                }
            }
            let Some((lower, other)) = better else { break };
            cost = lower;
            found = Found { is_fewest: false, ..other };
        }
        if let Some(cheaper) = search.within_budgets(&found, costs, most, scatters)
            && costs.work(&run(&cheaper.chosen)?.readings.rows).cost < cost
        {
            found = cheaper;
        }
    }
    let mut schedule = run(&found.chosen)?;
    if request.order != Order::Abba {
        schedule = campaign.with_readings(ordered(&schedule, noise, request.order, request.seed)?);
    }
    schedule = campaign.with_readings(relabelled(kept, schedule.readings));
    let judgement = judge(&schedule, noise, costs)?;
    let largest_share = largest_share(&judgement, goals);
    Ok(Reached {
        reached: impossible.is_empty() && largest_share.is_some_and(|share| share <= 1.0),
        largest_share,
        is_fewest: found.is_fewest,
        is_cheapest_found: cheapest,
        impossible,
        improvement: Improvement {
            schedule,
            judgement,
            candidates: pool.portions.len(),
            chosen: found.chosen.len() * size,
            efficiency: None,
            bound_gap: None,
            hits: found.hits,
            starts: request.starts.max(1),
            check: None,
            unreachable: pool.not_estimable.clone(),
            frozen: frozen(campaign, candidates),
        },
    })
}

fn largest_share(judgement: &Judgement, goals: &[Goal]) -> Option<f64> {
    goals
        .iter()
        .map(|goal| judgement.parameters.iter().find(|p| p.id == goal.id).and_then(|p| p.u).map(|u| u / goal.u))
        .try_fold(0.0_f64, |most, share| share.map(|share| most.max(share)))
}

fn distinct_mountings(pool: &Pool, chosen: &[usize]) -> Vec<Vec<Option<f64>>> {
    let mut distinct: Vec<Vec<Option<f64>>> = Vec::new();
    for place in chosen.iter().filter_map(|k| pool.portions.get(*k)?.first()).map(|r: &Reading| mounting(r)) {
        if !distinct.contains(&place) {
            distinct.push(place);
        }
    }
    distinct
}

/// Coordinates of each limited parameter divided by its limit, and the parameters that no candidate determines.
fn limits(campaign: &Campaign, pool: &Pool, goals: &[Goal]) -> Result<(Vec<Vec<f64>>, Vec<String>)> {
    let n = campaign.unknowns();
    let (mut limits, mut impossible) = (Vec::new(), Vec::new());
    for goal in goals {
        let Some(k) = campaign.parameter_index(&goal.id).filter(|k| *k < n) else {
            let names: Vec<&str> = campaign.estimated().iter().map(|p| p.id.as_str()).collect();
            return Err(Malformed::new(
                Fault::UnknownName,
                format!("a goal is set for '{}', which is not estimated", goal.id),
            )
            .expected(format!("one of {}", names.join(", ")))
            .found(format!("'{}'", goal.id)));
        };
        if !(goal.u > 0.0 && goal.u.is_finite()) {
            return Err(Malformed::new(Fault::Value, format!("the goal for '{}' is not positive", goal.id))
                .expected("a positive standard uncertainty")
                .found(goal.u.to_string()));
        }
        let unit: Vec<f64> = (0..n).map(|j| if j == k { 1.0 / goal.u } else { 0.0 }).collect();
        match pool.coordinates(&unit) {
            Some(c) => limits.push(c),
            None => impossible.push(goal.id.clone()),
        }
    }
    if goals.is_empty() || limits.is_empty() {
        let error = Malformed::new(Fault::Value, "no goal can be sought");
        return Err(match impossible.is_empty() {
            true => error.expected("a limit on at least one angle or parameter"),
            false => error
                .expected("a limit on a parameter that the candidates determine")
                .found(format!("{}: even all candidates together do not determine it", impossible.join(", "))),
        });
    }
    Ok((limits, impossible))
}

#[derive(Debug, Clone)]
struct Found {
    chosen: Vec<usize>,
    /// Largest `u / limit`.
    share: f64,
    is_fewest: bool,
    hits: usize,
}

struct Search<'a> {
    pool: &'a Pool,
    limits: &'a [Vec<f64>],
    request: &'a Request,
}

impl Search<'_> {
    /// The fewest of the `allowed` portions, at most `most`, that keep every limit; if none do, the best with `most`.
    fn fewest(&self, allowed: &[usize], most: usize) -> Option<Found> {
        let blocks = self.pool.blocks.subset(allowed);
        let most = most.min(allowed.len().saturating_mul(self.request.most_repeats));
        let mut low = 0; // too few
        let mut high = blocks.unknowns().div_ceil(blocks.rows().max(1)).clamp(1, most.max(1));
        let mut best = loop {
            match self.best_with(&blocks, high) {
                Some(found) if found.share <= 1.0 => break found,
                found if high >= most => return found.map(|found| self.in_pool(found, allowed)),
                _ => {
                    low = high;
                    high = (2 * high).min(most);
                }
            }
        };
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            match self.best_with(&blocks, middle) {
                Some(found) if found.share <= 1.0 => {
                    high = middle;
                    best = found;
                }
                _ => low = middle,
            }
        }
        best.is_fewest = high == 1 || self.too_few(&blocks, high - 1);
        Some(self.in_pool(best, allowed))
    }

    fn in_pool(&self, found: Found, allowed: &[usize]) -> Found {
        Found { chosen: found.chosen.iter().filter_map(|k| allowed.get(*k)).copied().collect(), ..found }
    }

    /// The design of `choose` portions whose largest `u / limit` is smallest, by reweighting the sum of squares.
    fn best_with(&self, blocks: &Blocks, choose: usize) -> Option<Found> {
        self.reweighted(blocks, |objective| {
            let problem = self.problem(blocks, objective, choose, None);
            best_of_starts(&problem, self.request.starts.min(20), self.request.seed)
        })
    }

    /// Smaller and smaller budgets below the cost of `found`, by bisection; `None` where none of them keeps every limit.
    fn within_budgets(&self, found: &Found, costs: &Costs, most: usize, remounts: bool) -> Option<Found> {
        // free readings have no end
        if self.pool.portions.len() > MOST_PORTIONS || costs.reading + costs.rate_change <= 0.0 {
            return None;
        }
        let blocks = &self.pool.blocks;
        let prices = |budget: f64| Prices::new(self.pool, *costs, budget, remounts);
        let mut high = prices(0.0).of(found.chosen.iter().copied());
        // costs are sums of these, so that nothing lies between two costs that are nearer
        let step = [costs.reading, costs.rate_change, costs.mounting].into_iter().filter(|c| *c > 0.0);
        let step = step.fold(high, f64::min);
        let (mut low, mut best) = (0.0, None);
        for _ in 0..BUDGETS {
            if high - low <= step {
                break;
            }
            let prices = prices((low + high) / 2.0);
            let cheaper = self.reweighted(blocks, |objective| {
                let problem = self.problem(blocks, objective, 0, Some(&prices));
                budget::best(&problem, &prices, self.request.starts.min(BUDGET_STARTS), self.request.seed)
            });
            match cheaper.filter(|cheaper| cheaper.share <= 1.0 && cheaper.chosen.len() <= most) {
                Some(cheaper) => {
                    high = prices.of(cheaper.chosen.iter().copied());
                    best = Some(cheaper);
                }
                None => low = prices.budget,
            }
        }
        best
    }

    fn problem<'p>(
        &'p self,
        blocks: &'p Blocks,
        objective: &'p Objective,
        choose: usize,
        prices: Option<&'p Prices>,
    ) -> Problem<'p> {
        let (base, most_repeats) = (&self.pool.base, self.request.most_repeats);
        Problem { blocks, base, objective, choose, most_repeats, neighbours: &[], prices }
    }

    /// The design whose largest `u / limit` is smallest, among those that `find` returns for reweighted sums of squares.
    fn reweighted(&self, blocks: &Blocks, find: impl Fn(&Objective) -> Option<(Design, usize)>) -> Option<Found> {
        let mut weights = vec![1.0; self.limits.len()];
        let mut best: Option<Found> = None;
        for _ in 0..ROUNDS {
            let terms: Vec<(f64, Vec<f64>)> = weights.iter().copied().zip(self.limits.iter().cloned()).collect();
            let objective = Objective::Trace(weight_matrix(&terms, blocks.unknowns()));
            let (design, hits) = find(&objective)?;
            let (inverse, _) = invert(&information(blocks, &self.pool.base, &design.chosen), blocks.unknowns())?;
            let squares: Vec<f64> = self.limits.iter().map(|c| dot(c, &times(&inverse, c))).collect();
            let share = squares.iter().copied().fold(0.0, f64::max).sqrt();
            if best.as_ref().is_none_or(|b| share < b.share) {
                best = Some(Found { chosen: design.chosen, share, is_fewest: false, hits });
            }
            if share <= 1.0 {
                break;
            }
            let mean = squares.iter().sum::<f64>() / squares.len() as f64;
            weights.iter_mut().zip(&squares).for_each(|(w, s)| *w *= s / mean);
        }
        best
    }

    /// Can even the best weights of `choose` portions not keep all limits? `sum l u^2/limit^2 > sum l` for some weights `l` says so.
    fn too_few(&self, blocks: &Blocks, choose: usize) -> bool {
        let fewest = blocks.unknowns().div_ceil(blocks.rows().max(1));
        if self.pool.base.iter().all(|b| *b == 0.0) && choose < fewest {
            return true;
        }
        let mut weights = vec![1.0; self.limits.len()];
        for _ in 0..ROUNDS {
            let terms: Vec<(f64, Vec<f64>)> = weights.iter().copied().zip(self.limits.iter().cloned()).collect();
            let objective = Objective::Trace(weight_matrix(&terms, blocks.unknowns()));
            let Some(best) = bound(blocks, &self.pool.base, &objective, choose) else { return false };
            if best.value > weights.iter().sum::<f64>() * (1.0 + 1e-9) {
                return true;
            }
            let Some(inverse) = super::bound::inverse(blocks, &self.pool.base, choose, &best) else { return false };
            let squares: Vec<f64> = self.limits.iter().map(|c| dot(c, &times(&inverse, c))).collect();
            let mean = squares.iter().sum::<f64>() / squares.len() as f64;
            weights.iter_mut().zip(&squares).for_each(|(w, s)| *w *= s / mean);
        }
        false
    }
}
