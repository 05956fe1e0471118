//! The best positions: chosen anew, or added to what is kept.

use super::blocks::{add_outer, rank};
use super::bound::{Bound, bound};
use super::candidates::{Unit, frozen};
use super::criterion::{Criterion, objective};
use super::effort::{Costs, Noise, Offer, mounting, planned};
use super::enumerate;
use super::exchange::{Design, Objective, Problem};
use super::judge::{Judgement, check_question, judge};
use super::levels::{carried, levels};
use super::order::{Order, ordered};
use super::point::check_point;
use super::pool::{Pool, log_det_of};
use super::prices::Prices;
use super::search::{Found, Limits, Progress, search};
use super::whitened::{adjusted, with_priors};
use crate::campaign::{Campaign, Reading, Readings};
use crate::error::{Fault, Malformed, Result};
use crate::estimate::Estimate;
use crate::fit::Separation;

/// How exchanges look for partners.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// All candidates (Fedorov).
    #[default]
    Fedorov,
    /// Candidates that differ in the state of one joint (coordinate exchange): for very many candidates.
    Coordinate,
}

/// What is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// Readings to choose; with a budget the most that may be chosen, and 0 for as many as it buys.
    pub readings: usize,
    /// What may be spent on what is chosen.
    pub budget: Option<f64>,
    /// May it cost more where nothing within the budget determines the unknowns?
    pub may_cost_more: bool,
    /// Best in what.
    pub criterion: Criterion,
    /// In what portions.
    pub unit: Unit,
    /// Which exchange.
    pub method: Method,
    /// How often one portion may be chosen.
    pub most_repeats: usize,
    /// Starts of the exchange.
    pub starts: usize,
    /// Seed of starts and random orders.
    pub seed: u64,
    /// Order of the result.
    pub order: Order,
    /// Who is told how far the search is.
    pub progress: Progress,
}

impl Default for Request {
    fn default() -> Self {
        Request {
            readings: 0,
            budget: None,
            may_cost_more: false,
            criterion: Criterion::D,
            unit: Unit::Reading,
            method: Method::Fedorov,
            most_repeats: usize::MAX,
            starts: 100,
            seed: 1,
            order: Order::Abba,
            progress: Progress::default(),
        }
    }
}

/// The best schedule that was found, and how near the optimum it is.
#[derive(Debug, Clone)]
pub struct Improvement {
    /// What is kept and what was chosen, in the order to run.
    pub schedule: Campaign,
    /// How well it will do.
    pub judgement: Judgement,
    /// Candidate portions that there were.
    pub candidates: usize,
    /// Readings chosen; the rest of the schedule is kept.
    pub chosen: usize,
    /// Readings that were kept: the first of the schedule, in their order.
    pub kept: usize,
    /// Why each chosen mounting is there, by its label.
    pub reasons: Vec<Reason>,
    /// What the chosen ones might cost, where that was limited.
    pub limit: Option<f64>,
    /// At least this share of what the best conceivable weights reach: `(det M / det M*)^(1/n)` for D, `tr*/tr` for A and C, `max*/max` for G.
    pub efficiency: Option<f64>,
    /// How far the bound behind it may be off, as a share: what the best weights that were found reach, less the bound. A larger shortfall means
    /// that so few readings cannot follow the weights.
    pub bound_gap: Option<f64>,
    /// Designs that there are, where all of them were tried: none is better.
    pub enumerated: Option<u64>,
    /// Starts that ended at the best value.
    pub hits: usize,
    /// Starts that were made.
    pub starts: usize,
    /// Criterion by a fresh QR of the final schedule against the one that the exchange had, as a relative difference.
    pub check: Option<f64>,
    /// What even all candidates together do not determine.
    pub unreachable: Vec<Separation>,
    /// Columns that differ in the schedule and have one value in all candidates, with that value.
    pub frozen: Vec<(String, f64)>,
}

/// Choose the best positions; those that the offer keeps stay, and what they tell is counted.
///
/// The design maximises the information `M = M_kept + sum A_j' V_j^-1 A_j` in the sense of the criterion; exchange from many starts, then the
/// approximate design as a bound. Errors: no candidates, a number of readings that the portions or repeats do not allow, a criterion for a
/// quantity that does not exist or that even all candidates do not determine.
pub fn improve(campaign: &Campaign, offer: &Offer, request: &Request) -> Result<Improvement> {
    let Offer { candidates, noise, costs, .. } = offer;
    let kept = &planned(campaign, &offer.kept);
    check_question(campaign)?;
    costs.check()?;
    check_point(campaign, kept, candidates, noise)?;
    if let Some(budget) = request.budget {
        check_budget(budget, costs, request)?;
    }
    let question = Question { campaign, kept, noise, costs, request };
    let mut sought = question.sought(candidates, request.budget)?;
    if sought.is_none()
        && let Some(budget) = request.budget
    {
        let pool = question.pool(candidates)?;
        if request.readings > 0 && too_small(&pool, request) {
            return Err(too_few(&pool, request));
        }
        let cost_within = |more: f64| {
            let found = question.seek(&pool, Some(more), &[], 20).ok()??;
            Some(Prices::new(&pool.portions, *costs, 0.0, question.apart()).of(&found.design.chosen))
        };
        let enough = least_budget(budget, cost_within);
        if let (true, Some(enough)) = (request.may_cost_more, enough) {
            sought = question.sought(candidates, Some(enough))?;
        }
        if sought.is_none() {
            return Err(too_poor(budget, &pool, enough));
        }
    }
    let Some(Sought { pool, objective, design, hits, starts, enumerated, efficiency, bound_gap, limit }) = sought
    else {
        return Err(too_few(&question.pool(candidates)?, request));
    };
    let schedule = scheduled(campaign, kept, &pool, &design.chosen, offer, request)?;
    let judgement = judge(&schedule, noise, costs)?;
    Ok(Improvement {
        check: check(&schedule, noise, &pool, &objective, &design)?,
        judgement,
        candidates: pool.portions.len(),
        chosen: design.chosen.len() * pool.portion_size(),
        kept: kept.rows.len(),
        reasons: reasons(&schedule, noise, kept.rows.len())?,
        limit,
        efficiency,
        bound_gap,
        enumerated,
        hits,
        starts,
        unreachable: pool.not_estimable,
        frozen: frozen(campaign, candidates),
        schedule,
    })
}

/// What is asked, of any set of candidates.
struct Question<'a> {
    campaign: &'a Campaign,
    kept: &'a Readings,
    noise: &'a Noise,
    costs: &'a Costs,
    request: &'a Request,
}

/// What was found in one set of candidates.
struct Sought {
    pool: Pool,
    objective: Objective,
    design: Design,
    hits: usize,
    starts: usize,
    enumerated: Option<u64>,
    efficiency: Option<f64>,
    bound_gap: Option<f64>,
    limit: Option<f64>,
}

impl Question<'_> {
    /// Where remounting scatters, every portion is a mounting of its own.
    fn apart(&self) -> bool {
        !self.noise.remount.is_empty()
    }

    fn pool(&self, candidates: &Readings) -> Result<Pool> {
        Pool::new(self.campaign, self.kept, candidates, self.request.unit, self.noise, &[])
    }

    /// The best of these candidates, with what coarser sweeps within them have found; `None` where nothing determines the unknowns.
    fn sought(&self, candidates: &Readings, limit: Option<f64>) -> Result<Option<Sought>> {
        let pool = self.pool(candidates)?;
        let objective = objective(self.campaign, &pool, &self.request.criterion)?;
        // where all designs can be tried, nothing else is needed
        if let Some(found) = self.all(&pool, &objective, limit)? {
            return self.with_bound(pool, objective, found, None, limit).map(Some);
        }
        let mut found: Vec<Option<(Pool, Vec<usize>)>> = Vec::new();
        let levels = levels(candidates);
        for (readings, within) in levels.iter().take(levels.len().saturating_sub(1)) {
            // a coarser sweep may lack what this question needs
            let own = self.pool(readings).ok().filter(|own| own.blocks.unknowns() == pool.blocks.unknowns());
            let design = own.as_ref().and_then(|own| {
                let given = carried_to(own, within, &found);
                self.seek(own, limit, &given, self.request.starts).ok()?
            });
            found.push(own.zip(design.map(|sought| sought.design.chosen)));
        }
        let within: Vec<usize> = (0..found.len()).collect();
        let given = carried_to(&pool, &within, &found);
        self.seek(&pool, limit, &given, self.request.starts)
    }

    fn all(&self, pool: &Pool, objective: &Objective, limit: Option<f64>) -> Result<Option<Found>> {
        let (choose, prices) = self.wanted(pool, limit)?;
        let problem = self.problem(pool, objective, choose, prices.as_ref(), &[]);
        let found = if self.request.method == Method::Coordinate { None } else { enumerate::best(&problem) };
        Ok(found
            .and_then(|(design, count)| Some(Found { design: design?, hits: 1, starts: 1, enumerated: Some(count) })))
    }

    /// The best of one pool.
    fn seek(&self, pool: &Pool, limit: Option<f64>, given: &[Vec<usize>], starts: usize) -> Result<Option<Sought>> {
        let objective = objective(self.campaign, pool, &self.request.criterion)?;
        let (choose, prices) = self.wanted(pool, limit)?;
        let neighbours = if self.request.method == Method::Coordinate { pool.neighbours() } else { Vec::new() };
        let problem = self.problem(pool, &objective, choose, prices.as_ref(), &neighbours);
        let guide = guide(&problem);
        let limits = Limits { starts, ..Limits::of(self.request, given) };
        let Some(found) = search(&problem, &limits, guide.as_ref()) else { return Ok(None) };
        self.with_bound(pool.clone(), objective.clone(), found, guide, limit).map(Some)
    }

    fn wanted(&self, pool: &Pool, limit: Option<f64>) -> Result<(usize, Option<Prices>)> {
        let prices = limit.map(|limit| Prices::new(&pool.portions, *self.costs, limit, self.apart()));
        let choose = match (limit, self.request.readings) {
            (Some(_), 0) => usize::MAX,
            _ => portions_to_choose(pool, self.request)?,
        };
        // a limit that no choice of so many can reach is none
        let dearest = |prices: &Prices| (0..pool.portions.len()).map(|j| prices.alone(j)).fold(0.0, f64::max);
        let prices = prices.filter(|prices| !prices.affords(choose as f64 * dearest(prices)));
        Ok((choose, prices))
    }

    fn problem<'p>(
        &self,
        pool: &'p Pool,
        objective: &'p Objective,
        choose: usize,
        prices: Option<&'p Prices>,
        neighbours: &'p [Vec<usize>],
    ) -> Problem<'p> {
        let most_repeats = self.request.most_repeats;
        Problem { blocks: &pool.blocks, base: &pool.base, objective, choose, most_repeats, neighbours, prices }
    }

    fn with_bound(
        &self,
        pool: Pool,
        objective: Objective,
        found: Found,
        guide: Option<Bound>,
        limit: Option<f64>,
    ) -> Result<Sought> {
        let Found { design, hits, starts, enumerated } = found;
        let n = pool.blocks.unknowns() as f64;
        let share = |better: f64, worse: f64| match objective {
            Objective::Determinant => ((better - worse) / n).exp(),
            _ => better / worse,
        };
        let (efficiency, bound_gap) = match (enumerated, guide) {
            (Some(_), _) => (Some(1.0), Some(0.0)),
            (None, Some(bound)) => (
                Some(share(bound.value, design.value).min(1.0)),
                Some((1.0 - share(bound.value, bound.reached)).max(0.0)),
            ),
            (None, None) => (None, None),
        };
        Ok(Sought { pool, objective, design, hits, starts, enumerated, efficiency, bound_gap, limit })
    }
}

/// What coarser levels have found, in the portions of a finer pool.
fn carried_to(pool: &Pool, within: &[usize], found: &[Option<(Pool, Vec<usize>)>]) -> Vec<Vec<usize>> {
    let coarser = within.iter().filter_map(|k| found.get(*k)?.as_ref());
    coarser.filter_map(|(own, chosen)| carried(own, chosen, pool)).collect()
}

/// The approximate design of a problem; within a budget, of as many portions as the fewest mountings that tell all unknowns could hold.
pub(super) fn guide(problem: &Problem<'_>) -> Option<Bound> {
    let total = match problem.prices {
        None => problem.choose as f64,
        Some(prices) => prices.most_portions(fewest_mountings(problem, prices)).min(problem.choose as f64),
    };
    (total >= 1.0).then(|| bound(problem.blocks, problem.base, problem.objective, total)).flatten()
}

/// No fewer mountings tell all unknowns, since each tells no more than its rows have dimensions.
fn fewest_mountings(problem: &Problem<'_>, prices: &Prices) -> usize {
    let (blocks, n) = (problem.blocks, problem.blocks.unknowns());
    let mut told = vec![vec![0.0; n * n]; prices.places];
    for (j, place) in prices.place.iter().enumerate() {
        if let Some(m) = told.get_mut(*place) {
            (0..blocks.rows()).for_each(|r| add_outer(m, 1.0, &blocks.row(j, r)));
        }
    }
    let most = told.iter().map(|m| rank(m, n)).max().unwrap_or(1).max(1);
    n.saturating_sub(rank(problem.base, n)).div_ceil(most).max(1)
}

/// Why a mounting is in a schedule: what would be lost without it.
#[derive(Debug, Clone, PartialEq)]
pub struct Reason {
    /// Its label.
    pub position: String,
    /// The estimated parameter (by index) that would lose most.
    pub parameter: usize,
    /// By what factor its uncertainty would grow; `None` where it would not be determined.
    pub grows: Option<f64>,
}

/// With more mountings or readings than this, reasons are not looked for.
const MOST_REASONS: usize = 100;
const MOST_READINGS: usize = 2000;

/// Every mounting after the first `kept` readings, left out in turn.
pub(super) fn reasons(schedule: &Campaign, noise: &Noise, kept: usize) -> Result<Vec<Reason>> {
    let rows = &schedule.readings.rows;
    let mut labels: Vec<&str> = Vec::new();
    for row in rows.iter().skip(kept) {
        if !labels.contains(&row.position.as_str()) {
            labels.push(&row.position);
        }
    }
    if labels.len() > MOST_REASONS || rows.len() > MOST_READINGS {
        return Ok(Vec::new());
    }
    let n = schedule.unknowns();
    let u = |readings: &Readings| -> Result<Vec<Option<f64>>> {
        let estimate = adjusted(schedule, &with_priors(schedule, readings, noise, &[])?, n)?;
        let known = |k: usize| estimate.estimable.get(k).copied().unwrap_or(false);
        Ok((0..n).map(|k| known(k).then(|| estimate.covariance[(k, k)].sqrt())).collect())
    };
    let with = u(&schedule.readings)?;
    let mut reasons = Vec::with_capacity(labels.len());
    for label in labels {
        let left =
            rows.iter().enumerate().filter(|(k, row)| *k < kept || row.position != label).map(|(_, row)| row.clone());
        let left = Readings { columns: schedule.readings.columns.clone(), rows: left.collect() };
        let without = if left.rows.is_empty() { vec![None; n] } else { u(&left)? };
        let growth = |k: usize| match (with.get(k).copied().flatten(), without.get(k).copied().flatten()) {
            (Some(with), Some(without)) if with > 0.0 => without / with,
            (Some(_), None) => f64::INFINITY,
            _ => 1.0,
        };
        let most = (0..n).max_by(|a, b| growth(*a).total_cmp(&growth(*b)).then(b.cmp(a)));
        if let Some(parameter) = most {
            let grows = Some(growth(parameter)).filter(|g| g.is_finite());
            reasons.push(Reason { position: label.to_string(), parameter, grows });
        }
    }
    Ok(reasons)
}

/// What is kept as it is, then what was chosen, in the order to run.
pub(super) fn scheduled(
    campaign: &Campaign,
    kept: &Readings,
    pool: &Pool,
    chosen: &[usize],
    offer: &Offer,
    request: &Request,
) -> Result<Campaign> {
    let Offer { noise, costs, .. } = offer;
    let rows = schedule_rows(kept, pool, chosen, !noise.remount.is_empty());
    let all = planned(campaign, &Readings { columns: kept.columns.clone(), rows });
    let run = ordered(&campaign.with_readings(all), noise, costs, request.order, request.seed, kept.rows.len())?;
    Ok(campaign.with_readings(relabelled(kept, run)))
}

fn portions_to_choose(pool: &Pool, request: &Request) -> Result<usize> {
    let size = pool.portion_size();
    let wrong = |expected: String| {
        Malformed::new(Fault::Value, format!("{} readings cannot be chosen", request.readings)).expected(expected)
    };
    if request.readings == 0 || !request.readings.is_multiple_of(size) {
        let what = if size == 1 {
            "a positive number".to_string()
        } else {
            format!("a multiple of {size}, the readings of one portion")
        };
        return Err(wrong(what).found(request.readings.to_string()));
    }
    let choose = request.readings / size;
    let most = pool.portions.len().saturating_mul(request.most_repeats);
    if choose > most {
        return Err(wrong(format!(
            "at most {} readings: {} candidates, each at most {} times",
            most.saturating_mul(size),
            pool.portions.len(),
            request.most_repeats
        ))
        .found(request.readings.to_string()));
    }
    if choose > 100_000 {
        return Err(wrong("at most 100,000 portions".into()).found(choose.to_string()));
    }
    Ok(choose)
}

/// Can so few readings not determine the unknowns, whatever they cost?
fn too_small(pool: &Pool, request: &Request) -> bool {
    let n = pool.blocks.unknowns();
    request.readings / pool.portion_size() * pool.blocks.rows() + rank(&pool.base, n) < n
}

fn too_few(pool: &Pool, request: &Request) -> Malformed {
    let rank = pool.blocks.unknowns();
    Malformed::new(Fault::Value, format!("no {} of these candidates determine {rank} unknowns", request.readings))
        .expected(format!(
            "at least {} readings, or more positions kept",
            rank.div_ceil(pool.blocks.rows()) * pool.portion_size()
        ))
        .found(request.readings.to_string())
}

fn check_budget(budget: f64, costs: &Costs, request: &Request) -> Result<()> {
    let bad = |expected: &str, found: String| {
        Err(Malformed::new(Fault::Value, "the budget is not possible").expected(expected).found(found))
    };
    if !(budget > 0.0 && budget.is_finite()) {
        return bad("a positive number, in the unit of the costs", budget.to_string());
    }
    if costs.reading == 0.0 && request.readings == 0 && request.most_repeats == usize::MAX {
        return bad("readings that cost something, or --repeats; else there is no end to them", "free readings".into());
    }
    Ok(())
}

fn too_poor(budget: f64, pool: &Pool, enough: Option<f64>) -> Malformed {
    let rank = pool.blocks.unknowns();
    let error = Malformed::new(Fault::Value, format!("no schedule for {budget} determines {rank} unknowns"));
    error.found(budget.to_string()).expected(match enough {
        Some(enough) => format!(
            "a budget of {} or more (the cheapest choice that was found to determine them), or positions kept with --keep",
            (enough * 1e3 - 1e-6).ceil() / 1e3
        ),
        None => "a larger budget, or positions kept with --keep".into(),
    })
}

/// The least cost above `poor` of a choice that determines the unknowns, as far as one is found: by growth, then by bisection.
fn least_budget(poor: f64, cost_within: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    let mut high = (1..40).map(|k| poor * 1.25_f64.powi(k)).find_map(&cost_within)?;
    let mut low = poor;
    for _ in 0..12 {
        // to a hundredth
        if high - low <= 0.01 * high {
            break;
        }
        let middle = (low + high) / 2.0;
        match cost_within(middle) {
            Some(cost) => high = cost,
            None => low = middle,
        }
    }
    Some(high)
}

/// Kept readings and chosen ones. New mountings are numbered on from the kept labels; where remounting scatters, a repeat is a new mounting.
pub(super) fn schedule_rows(kept: &Readings, pool: &Pool, chosen: &[usize], repeats_remount: bool) -> Vec<Reading> {
    let mut rows: Vec<Reading> = kept.rows.clone();
    let mut next = 1 + kept.rows.iter().filter_map(|r| r.position.parse::<usize>().ok()).max().unwrap_or(0);
    let mut labels: Vec<(Vec<Option<f64>>, String)> = Vec::new();
    for portion in chosen.iter().filter_map(|j| pool.portions.get(*j)) {
        let place = portion.first().map(mounting).unwrap_or_default();
        let known =
            labels.iter().find(|(other, _)| !repeats_remount && *other == place).map(|(_, label)| label.clone());
        let label = known.unwrap_or_else(|| {
            let label = next.to_string();
            next += 1;
            labels.push((place, label.clone()));
            label
        });
        rows.extend(portion.iter().map(|r| Reading { position: label.clone(), ..r.clone() }));
    }
    rows
}

/// New mountings numbered in the order in which they are run; labels that were kept stay.
pub(super) fn relabelled(kept: &Readings, mut run: Readings) -> Readings {
    let old: Vec<&str> = kept.rows.iter().map(|r| r.position.as_str()).collect();
    let mut next = 1 + old.iter().filter_map(|label| label.parse::<usize>().ok()).max().unwrap_or(0);
    let mut names: std::collections::HashMap<String, String> = std::collections::HashMap::new();
    for reading in run.rows.iter_mut().filter(|r| !old.contains(&r.position.as_str())) {
        let label = names.entry(reading.position.clone()).or_insert_with(|| {
            next += 1;
            (next - 1).to_string()
        });
        reading.position.clone_from(label);
    }
    run
}

/// The criterion from a fresh QR of the final schedule, against the value that the exchange ended with.
fn check(
    schedule: &Campaign,
    noise: &Noise,
    pool: &Pool,
    objective: &Objective,
    design: &Design,
) -> Result<Option<f64>> {
    let n = schedule.unknowns();
    let fresh = adjusted(schedule, &with_priors(schedule, &schedule.readings, noise, &[])?, n)?;
    let basis = pool.estimate.factor.basis();
    if fresh.rank != pool.blocks.unknowns() || fresh.factor.basis().iter().any(|j| !basis.contains(j)) {
        return Ok(None);
    }
    let relative = |found: f64| (found / design.value - 1.0).abs();
    Ok(match objective {
        // per unknown, as a relative change of the determinant
        Objective::Determinant => Some((log_det_of(&fresh) - pool.log_det_in_units(-design.value)).abs() / n as f64),
        _ if fresh.rank < n => None,
        Objective::Trace(w) => Some(relative(super::blocks::dot(w, &in_coordinates(pool, &fresh)))),
        Objective::Largest(rows) => Some(relative(rows.largest_quadratic(&in_coordinates(pool, &fresh)))),
    })
}

/// Covariance of `z = R D x`, the pool's coordinates, row by row, from that of `x`.
fn in_coordinates(pool: &Pool, fresh: &Estimate) -> Vec<f64> {
    let factor = &pool.estimate.factor;
    let (basis, r, scale) = (factor.basis(), factor.r(), factor.scale());
    let n = basis.len();
    let t = |i: usize, k: usize| r[(i, k)] * basis.get(k).and_then(|j| scale.get(*j)).copied().unwrap_or_default();
    let c = |k: usize, l: usize| match (basis.get(k), basis.get(l)) {
        (Some(a), Some(b)) => fresh.covariance[(*a, *b)],
        _ => 0.0,
    };
    let half: Vec<Vec<f64>> =
        (0..n).map(|i| (0..n).map(|l| (i..n).map(|k| t(i, k) * c(k, l)).sum()).collect()).collect();
    half.iter().flat_map(|row| (0..n).map(move |j| (j..n).map(|l| row[l] * t(j, l)).sum::<f64>())).collect()
}
