//! The best positions: chosen anew, or added to what is kept.

use super::blocks::Blocks;
use super::bound::bound;
use super::candidates::Unit;
use super::effort::{Noise, Offer, mounting};
use super::exchange::{Design, Objective, Problem, start};
use super::judge::{Judgement, check_question, judge};
use super::order::{Order, ordered};
use super::pool::{Pool, log_det_of, whitened};
use crate::algebra::{Scratch, Tape};
use crate::campaign::{Campaign, Kind, Reading, Readings};
use crate::error::{Fault, Malformed, Result};
use crate::estimate::{self, Group, System};
use crate::fit::Separation;
use faer::Mat;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use rayon::prelude::*;

/// What the best schedule is best in.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Criterion {
    /// Smallest volume of the confidence ellipsoid of all estimated parameters.
    #[default]
    D,
    /// Smallest sum of squared uncertainties of the angles (of all parameters, each in units of what all candidates give, where none is an angle).
    A,
    /// Smallest largest uncertainty of a predicted reading, over all candidates.
    G,
    /// Smallest uncertainty of one parameter or derived quantity.
    C(String),
}

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
    /// Readings to choose.
    pub readings: usize,
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
    /// Starts that ended at the best value.
    pub hits: usize,
    /// Starts that were made.
    pub starts: usize,
    /// Criterion by a fresh QR of the final schedule against the one that the exchange had, as a relative difference.
    pub check: Option<f64>,
    /// What even all candidates together do not determine.
    pub unreachable: Vec<Separation>,
}

/// Choose the best positions; those that the offer keeps stay, and what they tell is counted.
///
/// The design maximises the information `M = M_kept + sum A_j' V_j^-1 A_j` in the sense of the criterion; exchange from many starts, then the
/// approximate design as a bound. Errors: no candidates, a number of readings that the portions or repeats do not allow, a criterion for a
/// quantity that does not exist or that even all candidates do not determine.
pub fn improve(campaign: &Campaign, offer: &Offer, request: &Request) -> Result<Improvement> {
    let Offer { kept, candidates, noise, costs } = offer;
    check_question(campaign)?;
    costs.check()?;
    let pool = Pool::new(campaign, kept, candidates, request.unit, noise, &[])?;
    let choose = portions_to_choose(&pool, request)?;
    let objective = objective(campaign, &pool, &request.criterion)?;
    let neighbours = if request.method == Method::Coordinate { pool.neighbours() } else { Vec::new() };
    let problem = Problem {
        blocks: &pool.blocks,
        base: &pool.base,
        objective: &objective,
        choose,
        most_repeats: request.most_repeats,
        neighbours: &neighbours,
    };
    let Some((design, hits)) = best_of_starts(&problem, request.starts, request.seed) else {
        return Err(too_few(&pool, request));
    };
    let efficiency = efficiency(&pool, &objective, choose, &design);
    let rows = schedule_rows(kept, &pool, &design.chosen, !noise.remount.is_empty());
    let unordered = campaign.with_readings(Readings { columns: kept.columns.clone(), rows });
    let schedule = campaign.with_readings(ordered(&unordered, noise, request.order, request.seed)?);
    let judgement = judge(&schedule, noise, costs)?;
    Ok(Improvement {
        check: check(&schedule, noise, &pool, &objective, &design)?,
        judgement,
        candidates: pool.portions.len(),
        chosen: choose * pool.portion_size(),
        efficiency,
        hits,
        starts: request.starts.max(1),
        unreachable: pool.not_estimable,
        schedule,
    })
}

/// A choice among plain rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// Candidates, sorted, with repeats.
    pub chosen: Vec<usize>,
    /// `log det M` where no weights were given, else `tr(W M^-1)`.
    pub value: f64,
    /// Starts that ended there.
    pub hits: usize,
    /// What no choice can exceed (`log det M`) or fall short of (`tr(W M^-1)`): the approximate design's bound.
    pub bound: Option<f64>,
}

/// The best choice among plain blocks of rows: largest `log det M`, or smallest `tr(W M^-1)` for `weights` `W` (row by row). The bound costs more than
/// one start, so it is found only on request.
///
/// ```
/// use tumble::plan::{Blocks, choose};
/// // a straight line on [-1, 1]: two readings at each end, det M = 4 * 4
/// let line = Blocks::from_fn(21, 1, 2, |j, _, c| if c == 0 { 1.0 } else { j as f64 / 10.0 - 1.0 });
/// let best = choose(&line, 4, usize::MAX, None, 1, 7, true).unwrap();
/// assert_eq!(best.chosen, [0, 0, 20, 20]);
/// assert!((best.value - 16f64.ln()).abs() < 1e-12 && (best.bound.unwrap() - best.value) < 1e-4);
/// ```
pub fn choose(
    blocks: &Blocks,
    count: usize,
    most_repeats: usize,
    weights: Option<&[f64]>,
    starts: usize,
    seed: u64,
    with_bound: bool,
) -> Option<Choice> {
    let n = blocks.unknowns();
    if weights.is_some_and(|w| w.len() != n * n) {
        return None;
    }
    let base = vec![0.0; n * n];
    let objective = weights.map_or(Objective::Determinant, |w| Objective::Trace(w.to_vec()));
    let problem = Problem { blocks, base: &base, objective: &objective, choose: count, most_repeats, neighbours: &[] };
    let (design, hits) = best_of_starts(&problem, starts, seed)?;
    let sign = if weights.is_some() { 1.0 } else { -1.0 };
    let bound = if with_bound { bound(blocks, &base, &objective, count) } else { None };
    Some(Choice { chosen: design.chosen, value: sign * design.value, hits, bound: bound.map(|b| sign * b.value) })
}

/// Every start from its own seed; the best value, and how many starts reached it. The same seed gives the same design on any machine.
pub(super) fn best_of_starts(problem: &Problem<'_>, starts: usize, seed: u64) -> Option<(Design, usize)> {
    let one = |k: u64| {
        let own = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(k);
        start(problem, &mut Pcg64Mcg::seed_from_u64(own))
    };
    let designs: Vec<Option<Design>> = match starts {
        0 | 1 => vec![one(0)],
        _ => (0..starts as u64).into_par_iter().map(one).collect(),
    };
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.abs().max(b.abs()).max(1e-300);
    let mut best: Option<(Design, usize)> = None;
    for design in designs.into_iter().flatten() {
        match &mut best {
            Some((known, hits)) if near(known.value, design.value) => *hits += 1,
            Some((known, _)) if known.value <= design.value => {}
            _ => best = Some((design, 1)),
        }
    }
    best
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

/// The criterion in the coordinates of the pool. Errors: a quantity that does not exist or that the candidates do not determine.
fn objective(campaign: &Campaign, pool: &Pool, criterion: &Criterion) -> Result<Objective> {
    let n = campaign.unknowns();
    let unit = |k: usize| (0..n).map(|j| f64::from(u8::from(j == k))).collect::<Vec<f64>>();
    match criterion {
        Criterion::D => Ok(Objective::Determinant),
        Criterion::G => Ok(Objective::Largest),
        Criterion::A => {
            let is_tilt = |k: &usize| campaign.parameters.get(*k).is_some_and(|p| p.kind == Kind::Tilt);
            let some_tilt = (0..n).any(|k| is_tilt(&k));
            let terms = (0..n)
                .filter(|k| !some_tilt || is_tilt(k))
                .filter_map(|k| pool.coordinates(&unit(k)))
                .map(|c| (if some_tilt { 1.0 } else { 1.0 / c.iter().map(|c| c * c).sum::<f64>() }, c));
            let terms: Vec<(f64, Vec<f64>)> = terms.collect();
            if terms.is_empty() {
                return Err(not_determined("an angle"));
            }
            Ok(Objective::Trace(weight_matrix(&terms, pool.blocks.unknowns())))
        }
        Criterion::C(id) => {
            let c = match campaign.parameter_index(id).filter(|k| *k < n) {
                Some(k) => unit(k),
                None => gradient_of(campaign, id)?,
            };
            let c = pool.coordinates(&c).ok_or_else(|| not_determined(&format!("'{id}'")))?;
            Ok(Objective::Trace(weight_matrix(&[(1.0, c)], pool.blocks.unknowns())))
        }
    }
}

fn not_determined(what: &str) -> Malformed {
    Malformed::new(Fault::Value, format!("even all candidates together do not determine {what}"))
        .expected("candidates that separate it from the other parameters, or a prior")
}

/// Gradient of a derived quantity by the estimated parameters at the reference point.
fn gradient_of(campaign: &Campaign, id: &str) -> Result<Vec<f64>> {
    let Some(quantity) = campaign.derived.iter().find(|d| d.id == id) else {
        let mut names: Vec<&str> = campaign.estimated().iter().map(|p| p.id.as_str()).collect();
        names.extend(campaign.derived.iter().map(|d| d.id.as_str()));
        return Err(Malformed::new(
            Fault::UnknownName,
            format!("the best set for '{id}' cannot be found: it is not estimated here"),
        )
        .expected(format!("one of {}", names.join(", ")))
        .found(format!("'{id}'")));
    };
    let ids: Vec<&str> = campaign.parameters.iter().map(|p| p.id.as_str()).collect();
    let tape = Tape::compile(&quantity.line, &ids)?;
    let mut gradient = vec![0.0; ids.len()];
    tape.gradient(&campaign.reference_point(), &mut Scratch::default(), &mut gradient);
    gradient.truncate(campaign.unknowns());
    if gradient.iter().any(|g| !g.is_finite()) || gradient.iter().all(|g| *g == 0.0) {
        return Err(Malformed::new(Fault::Value, format!("'{id}' has no derivative at the reference point"))
            .expected("a quantity that is smooth there, or \"start\" values at which it is")
            .found(quantity.line.to_string()));
    }
    Ok(gradient)
}

/// `sum w c c'`, row by row.
pub(super) fn weight_matrix(terms: &[(f64, Vec<f64>)], n: usize) -> Vec<f64> {
    let mut w = vec![0.0; n * n];
    for (weight, c) in terms {
        super::blocks::add_outer(&mut w, *weight, c);
    }
    w
}

/// At least this share of the optimum, from the approximate design.
fn efficiency(pool: &Pool, objective: &Objective, choose: usize, design: &Design) -> Option<f64> {
    let n = pool.blocks.unknowns() as f64;
    let efficiency = match objective {
        Objective::Determinant => {
            ((bound(&pool.blocks, &pool.base, objective, choose)?.value - design.value) / n).exp()
        }
        Objective::Trace(_) => bound(&pool.blocks, &pool.base, objective, choose)?.value / design.value,
        // sum w_j tr(Xj M^-1 Xj') = n / N, so the largest of all rows is at least n / (N rows)
        Objective::Largest if pool.base.iter().all(|b| *b == 0.0) => {
            n / (choose * pool.blocks.rows()) as f64 / design.value
        }
        Objective::Largest => return None,
    };
    Some(efficiency.min(1.0))
}

/// Kept readings and chosen ones. New mountings are numbered on from the kept labels; where remounting scatters, a repeat is a new mounting.
pub(super) fn schedule_rows(kept: &Readings, pool: &Pool, chosen: &[usize], repeats_remount: bool) -> Vec<Reading> {
    let mut rows: Vec<Reading> = kept.rows.iter().map(|r| Reading { observations: Vec::new(), ..r.clone() }).collect();
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

/// The criterion from a fresh QR of the final schedule, against the value that the exchange ended with.
fn check(
    schedule: &Campaign,
    noise: &Noise,
    pool: &Pool,
    objective: &Objective,
    design: &Design,
) -> Result<Option<f64>> {
    let mut rows = whitened(schedule, &schedule.readings, noise, &[])?;
    let n = schedule.unknowns();
    for (k, u) in super::judge::priors(schedule) {
        rows.push((0..n).map(|j| if j == k { 1.0 / u } else { 0.0 }).collect());
    }
    let m = rows.len();
    let system = System {
        rows: Mat::from_fn(m, n, |i, j| rows[i][j]),
        observed: vec![0.0; m],
        u: vec![1.0; m],
        group: vec![Group::Known; m],
    };
    let fresh = estimate::adjust(&system, &estimate::Settings { refinements: 0, ..estimate::Settings::default() })?;
    if fresh.rank != pool.blocks.unknowns()
        || fresh.factor.basis().iter().any(|j| !pool.estimate.factor.basis().contains(j))
    {
        return Ok(None);
    }
    Ok(match objective {
        // per unknown, as a relative change of the determinant
        Objective::Determinant => Some((log_det_of(&fresh) - pool.log_det_in_units(-design.value)).abs() / n as f64),
        _ => None,
    })
}
