//! The best positions: chosen anew, or added to what is kept.

use super::bound::bound;
use super::budget::{self, Prices};
use super::candidates::{Unit, frozen};
use super::criterion::{Criterion, objective};
use super::effort::{Costs, Noise, Offer, mounting, positions_only};
use super::exchange::{Design, Objective, Problem, best_of_starts};
use super::judge::{Judgement, check_question, judge};
use super::order::{Order, ordered};
use super::point::check_point;
use super::pool::{Pool, log_det_of};
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
    /// Readings to choose; plays no part where there is a budget.
    pub readings: usize,
    /// What may be spent on what is chosen, instead of a number of readings.
    pub budget: Option<f64>,
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
}

impl Default for Request {
    fn default() -> Self {
        Request {
            readings: 0,
            budget: None,
            criterion: Criterion::D,
            unit: Unit::Reading,
            method: Method::Fedorov,
            most_repeats: usize::MAX,
            starts: 100,
            seed: 1,
            order: Order::Abba,
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
    /// At least this share of what the best conceivable weights reach: `(det M / det M*)^(1/n)` for D, `tr*/tr` for A and C, `max*/max` for G.
    pub efficiency: Option<f64>,
    /// How far the bound behind it may be off, as a share: what the best weights that were found reach, less the bound. A larger shortfall means
    /// that so few readings cannot follow the weights.
    pub bound_gap: Option<f64>,
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
    let kept = &positions_only(&offer.kept);
    check_question(campaign)?;
    costs.check()?;
    check_point(campaign, kept, candidates, noise)?;
    let pool = Pool::new(campaign, kept, candidates, request.unit, noise, &[])?;
    let objective = objective(campaign, &pool, &request.criterion)?;
    let neighbours = if request.method == Method::Coordinate { pool.neighbours() } else { Vec::new() };
    let remounts = !noise.remount.is_empty();
    let problem = |choose: usize| Problem {
        blocks: &pool.blocks,
        base: &pool.base,
        objective: &objective,
        choose,
        most_repeats: request.most_repeats,
        neighbours: &neighbours,
        prices: None,
    };
    let (design, hits, efficiency, bound_gap) = match request.budget {
        None => {
            let choose = portions_to_choose(&pool, request)?;
            let found = best_of_starts(&problem(choose), request.starts, request.seed);
            let (design, hits) = found.ok_or_else(|| too_few(&pool, request))?;
            let (efficiency, gap) = efficiency(&pool, &objective, choose, &design).unzip();
            (design, hits, efficiency, gap)
        }
        Some(budget) => {
            let within = |budget: f64, starts: usize| {
                let prices = Prices::new(&pool, *costs, budget, remounts);
                budget::best(&Problem { prices: Some(&prices), ..problem(0) }, &prices, starts, request.seed)
            };
            check_budget(budget, costs)?;
            let found = within(budget, request.starts);
            let (design, hits) = found.ok_or_else(|| {
                let price =
                    |design: &Design| Prices::new(&pool, *costs, 0.0, remounts).of(design.chosen.iter().copied());
                too_poor(budget, &pool, least_budget(budget, |more| within(more, 20).map(|(design, _)| price(&design))))
            })?;
            (design, hits, None, None)
        }
    };
    let rows = schedule_rows(kept, &pool, &design.chosen, remounts);
    let unordered = campaign.with_readings(Readings { columns: kept.columns.clone(), rows });
    let run = ordered(&unordered, noise, request.order, request.seed)?;
    let schedule = campaign.with_readings(relabelled(kept, run));
    let judgement = judge(&schedule, noise, costs)?;
    Ok(Improvement {
        check: check(&schedule, noise, &pool, &objective, &design)?,
        judgement,
        candidates: pool.portions.len(),
        chosen: design.chosen.len() * pool.portion_size(),
        efficiency,
        bound_gap,
        hits,
        starts: request.starts.max(1),
        unreachable: pool.not_estimable,
        frozen: frozen(campaign, candidates),
        schedule,
    })
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

fn too_few(pool: &Pool, request: &Request) -> Malformed {
    let rank = pool.blocks.unknowns();
    Malformed::new(Fault::Value, format!("no {} of these candidates determine {rank} unknowns", request.readings))
        .expected(format!(
            "at least {} readings, or more positions kept",
            rank.div_ceil(pool.blocks.rows()) * pool.portion_size()
        ))
        .found(request.readings.to_string())
}

fn check_budget(budget: f64, costs: &Costs) -> Result<()> {
    let bad = |expected: &str, found: String| {
        Err(Malformed::new(Fault::Value, "the budget is not possible").expected(expected).found(found))
    };
    if !(budget > 0.0 && budget.is_finite()) {
        return bad("a positive number, in the unit of the costs", budget.to_string());
    }
    if costs.reading == 0.0 && costs.rate_change == 0.0 {
        return bad(
            "readings or rate changes that cost something; else there is no end to them",
            "both cost nothing".into(),
        );
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

/// At least this share of the optimum, from the approximate design; and how loose that may be.
fn efficiency(pool: &Pool, objective: &Objective, choose: usize, design: &Design) -> Option<(f64, f64)> {
    let n = pool.blocks.unknowns() as f64;
    let bound = bound(&pool.blocks, &pool.base, objective, choose)?;
    let share = |better: f64, worse: f64| match objective {
        Objective::Determinant => ((better - worse) / n).exp(),
        _ => better / worse,
    };
    Some((share(bound.value, design.value).min(1.0), (1.0 - share(bound.value, bound.reached)).max(0.0)))
}

/// Kept readings and chosen ones. New mountings are numbered on from the kept labels; where remounting scatters, a repeat is a new mounting.
pub(super) fn schedule_rows(kept: &Readings, pool: &Pool, chosen: &[usize], repeats_remount: bool) -> Vec<Reading> {
    let mut rows: Vec<Reading> = kept.rows.iter().map(Reading::unread).collect();
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
