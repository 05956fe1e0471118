//! The best positions: chosen anew, or added to those kept; why each mounting is in a schedule.
//!
//! Angles between the candidates: chosen mountings are moved joint by joint, in halved steps, as long as the criterion improves.
//!
//! A mounting moves with all its readings, a joint within the range that the candidates have (all round where they go round), and never into a
//! forbidden zone. Steps start at half of the sweep's and end at the resolution, of which they are whole multiples.

use super::candidates::{frozen, is_forbidden};
use super::criterion::objective;
use super::effort::{Costs, Noise, Offer, grouped, mounting};
use super::judge::{Judgement, judge};
use super::objective::Objective;
use super::pool::Pool;
use super::problem::{Problem, WORTH};
use super::question::Question;
use super::request::Request;
use super::search::{Limits, Outcome, least};
use super::whitened::Independent;
use crate::campaign::{Campaign, JointState, Reading, Readings};
use crate::error::{Fault, Malformed, Result};
use crate::fit::RankDefect;
use crate::number;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Choices with smaller and smaller budgets, until the way between the positions is affordable as well.
const ROUNDS: usize = 24;

/// The best schedule of the search, and how near the optimum it is.
#[derive(Debug, Clone)]
pub struct Improvement {
    /// The kept and the chosen readings, in the order to run.
    pub schedule: Campaign,
    /// How well it will do.
    pub judgement: Judgement,
    /// Candidate portions that there were.
    pub candidates: usize,
    /// Readings chosen; the other readings of the schedule are kept.
    pub chosen: usize,
    /// Readings that were kept: the first of the schedule, in their order.
    pub kept: usize,
    /// Why each chosen mounting is there, by its label.
    pub reasons: Vec<Reason>,
    /// How it was searched, and how near the optimum it is.
    pub search: SearchRecord,
    /// Criterion from the rows of the final schedule against the one that the exchange had, as a relative difference; not where angles moved.
    pub check: Option<f64>,
    /// What even all candidates together do not determine.
    pub unreachable: Vec<RankDefect>,
    /// Columns that differ in the schedule and have one value in all candidates, with that value.
    pub frozen: Vec<(String, f64)>,
}

/// The record of a search.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SearchRecord {
    /// What the chosen ones might cost at most, where that was limited, in the unit of the costs.
    #[serde(default)]
    pub cost_limit: Option<f64>,
    /// Designs that there are, where all of them were tried: none is better.
    #[serde(default)]
    pub enumerated: Option<u64>,
    /// At least this share of the best possible choice of these candidates (within the budget, where there is one); null where no bound is
    /// known (goal, two effects).
    // `(det M / det M*)^(1/n)` for D, `tr*/tr` for A and C, `max*/max` for G
    pub efficiency: Option<f64>,
    /// How loose that bound may be, as a share; a larger shortfall means that so few portions cannot follow the best weights.
    pub bound_gap: Option<f64>,
    /// What moving the angles between the candidates brought; absent where that was not asked for. Efficiency and enumeration are those of the
    /// choice among the candidates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refined: Option<Refined>,
    /// Starts of the exchange.
    pub starts: usize,
    /// Starts that ended at this schedule's value.
    pub hits: usize,
}

/// Choose the best positions; those that the offer keeps stay, and their information is counted.
///
/// The design maximises the information `M = M_kept + sum A_j' V_j^-1 A_j` in the sense of the criterion; exchange from many starts, then the
/// approximate design as a bound. Errors: no candidates, a number of readings that the portions or repeats do not allow, a criterion for a
/// quantity that does not exist or that even all candidates do not determine.
///
/// Where degrees cost something, a budget pays for the way between the positions too: the choice is made anew with what that leaves.
pub fn improve(campaign: &Campaign, offer: &Offer, request: &Request) -> Result<Improvement> {
    let costs = &offer.costs;
    let question = Question::new(campaign, offer, request, &[])?;
    if let Some(budget) = request.budget {
        check_budget(budget, costs, request)?;
    }
    let objective = objective(campaign, &question.pool, &request.criterion)?;
    let (first, proof) = question.best(&objective, request.budget, request.may_cost_more)?;
    let Some(budget) = request.budget.filter(|_| costs.index > 0.0) else { return Ok(first) };
    let without_way = Costs { index: 0.0, ..*costs };
    // the way begins at the last kept reading
    let way = |plan: &Improvement| {
        costs.of_way(plan.schedule.readings.rows.get(plan.kept.saturating_sub(1)..).unwrap_or_default())
    };
    let spent =
        |plan: &Improvement| without_way.work(plan.schedule.readings.rows.get(plan.kept..).unwrap_or_default()).cost;
    let (mut plan, mut within, mut least) = (first.clone(), budget, f64::INFINITY);
    for _ in 0..ROUNDS {
        let total = spent(&plan) + way(&plan);
        least = least.min(total);
        if total <= budget * (1.0 + 1e-12) {
            let cost_limit = plan.search.cost_limit.map(|_| budget);
            return Ok(Improvement { search: SearchRecord { cost_limit, ..plan.search }, ..plan });
        }
        // another choice has another way: not all at once
        within = (budget - way(&plan)).clamp(0.85 * within, 0.98 * within);
        // the first proof is for the whole budget
        let Ok((next, proof_within)) = question.best(&objective, Some(within), false) else { break };
        let efficiency = proof.share_of(proof_within.value);
        let enumerated = next.search.enumerated.filter(|_| efficiency.is_some_and(|share| share >= 1.0));
        let search = SearchRecord { efficiency, bound_gap: first.search.bound_gap, enumerated, ..next.search };
        plan = Improvement { search, ..next };
    }
    if request.may_cost_more {
        return Ok(plan);
    }
    let what = format!("no schedule was found that costs no more than {budget} with the way between its positions");
    Err(Malformed::new(Fault::Value, what)
        .expected(format!(
            "a budget of {} or more (the cheapest that was found), or candidates nearer to each other",
            (least * 1e3 - 1e-6).ceil() / 1e3
        ))
        .found(budget.to_string()))
}

impl Improvement {
    /// A schedule whose first `kept` readings stay: how well it will do. Results of the search are added by the caller.
    pub(super) fn of(schedule: Campaign, offer: &Offer, candidates: usize, kept: usize) -> Result<Self> {
        Ok(Improvement {
            judgement: judge(&schedule, &offer.noise, &offer.costs)?,
            candidates,
            chosen: schedule.readings.rows.len().saturating_sub(kept),
            kept,
            reasons: Vec::new(),
            search: SearchRecord::default(),
            check: None,
            unreachable: Vec::new(),
            frozen: Vec::new(),
            schedule,
        })
    }
}

/// The criterion of a choice, and its lower bound within the budget.
#[derive(Debug, Clone, Copy)]
struct Proof {
    value: f64,
    least: Option<f64>,
    /// Unknowns, where values are logarithms of determinants.
    logarithm_of: Option<f64>,
}

impl Proof {
    /// Lower limit of the efficiency of another choice within this budget.
    fn share_of(&self, value: f64) -> Option<f64> {
        let share = |least: f64| match self.logarithm_of {
            Some(n) => ((least - value) / n).exp(),
            None => least / value,
        };
        self.least.map(|least| share(least).min(1.0))
    }
}

/// Starts of a search for the least budget, which bound the work: whether it is enough is asked often, and the answer has the request's starts.
const FEW: usize = 20;

impl<'a> Question<'a> {
    /// The schedule of chosen rows: how well it will do, and why each mounting is there.
    pub(super) fn made(&self, rows: &[Reading]) -> Result<Improvement> {
        let kept = self.kept.rows.len();
        let schedule = self.scheduled(rows)?;
        Ok(Improvement {
            reasons: reasons(&schedule, &self.offer.noise, kept)?,
            unreachable: self.pool.not_estimable.clone(),
            frozen: frozen(self.campaign, &self.offer.candidates),
            ..Improvement::of(schedule, self.offer, self.pool.portions.len(), kept)?
        })
    }

    /// The best of all candidates, started from the results of coarser sweeps.
    fn sought(&self, objective: &Objective, choose: usize, budget: Option<f64>) -> Option<Outcome> {
        let best = |question: &Question<'a>, given: &[Vec<usize>]| {
            let given = || given.to_vec();
            Some(question.seek(objective, choose, budget, &Limits::of(self.request, &given))?.design.chosen)
        };
        self.seek(objective, choose, budget, &Limits::of(self.request, &|| self.coarser(&best)))
    }

    /// The best positions, the way between them not counted.
    fn best(&self, objective: &Objective, budget: Option<f64>, may_cost_more: bool) -> Result<(Improvement, Proof)> {
        let Question { pool, request, .. } = self;
        let choose = match (budget, request.readings) {
            (Some(_), 0) => usize::MAX,
            _ => portions_to_choose(pool, request)?,
        };
        let (mut limit, mut outcome) = (budget, self.sought(objective, choose, budget));
        if let (None, Some(budget)) = (&outcome, budget) {
            // so few do not, whatever they cost
            if (Problem { choose, ..Problem::of(&pool.blocks, &pool.base, objective) }).is_short() {
                return Err(too_few(pool, request));
            }
            let cost_within = |more: f64| {
                let limits = Limits { starts: FEW, bounded: false, ..Limits::of(request, &Vec::new) };
                let outcome = self.seek(objective, choose, Some(more), &limits)?;
                Some((self.prices.of(&outcome.design.chosen), ()))
            };
            // a quarter apart, then to a hundredth
            let first = (1..40).map(|k| budget * 1.25_f64.powi(k)).find_map(cost_within);
            let enough = first.map(|first| least(budget, first, 0.01 * first.0, |cost, (), _| cost_within(cost)).0);
            limit = enough.filter(|_| may_cost_more);
            outcome = limit.and_then(|limit| self.sought(objective, choose, Some(limit)));
            if outcome.is_none() {
                return Err(too_poor(budget, pool, enough));
            }
        }
        let Some(Outcome { design, hits, starts, enumerated, guide }) = outcome else {
            return Err(too_few(pool, request));
        };
        let proof = Proof {
            value: design.value,
            least: enumerated.map(|_| design.value).or(guide.as_ref().map(|bound| bound.value)),
            logarithm_of: (*objective == Objective::Determinant).then_some(pool.blocks.unknowns() as f64),
        };
        let bound_gap = match enumerated {
            Some(_) => Some(0.0),
            None => guide.as_ref().and_then(|bound| Some(1.0 - proof.share_of(bound.reached)?)),
        };
        let rows = self.rows(&design.chosen);
        let (improvement, refined) = match self.refined(&rows, objective, None)? {
            Some((moved, what)) => (self.made(&moved)?, Some(what)),
            None => {
                let made = self.made(&rows)?;
                let fresh = pool.value(&made.schedule, &made.schedule.readings, &self.offer.noise, objective)?;
                let check = fresh.map(|value| match objective {
                    // per unknown, as a relative change of the determinant
                    Objective::Determinant => (value - design.value).abs() / self.campaign.unknowns() as f64,
                    _ => (value / design.value - 1.0).abs(),
                });
                (Improvement { check, ..made }, None)
            }
        };
        let (cost_limit, efficiency) = (limit, proof.share_of(design.value));
        let search = SearchRecord { cost_limit, enumerated, efficiency, bound_gap, refined, starts, hits };
        Ok((Improvement { search, ..improvement }, proof))
    }
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
    let rank = pool.determined();
    Malformed::new(
        Fault::Value,
        format!("no choice of {} of these candidates determines {rank} unknowns", request.readings),
    )
    .expected(format!(
        "at least {} readings, or more positions kept",
        rank.div_ceil(pool.blocks.rows()) * pool.portion_size()
    ))
    .found(request.readings.to_string())
}

fn check_budget(budget: f64, costs: &Costs, request: &Request) -> Result<()> {
    let bad = |expected: &str, value: &str| {
        Malformed::new(Fault::Value, "the budget is not valid").expected(expected).found(value)
    };
    if !(budget > 0.0 && budget.is_finite()) {
        return Err(bad("a positive number, in the unit of the costs", &budget.to_string()));
    }
    if costs.reading == 0.0 && request.readings == 0 && request.most_repeats == usize::MAX {
        let expected = "readings that cost something, or a limit on repeats; else there is no end to them";
        return Err(bad(expected, "free readings").argument("repeats", "N"));
    }
    Ok(())
}

fn too_poor(budget: f64, pool: &Pool, enough: Option<f64>) -> Malformed {
    let rank = pool.determined();
    let error = Malformed::new(Fault::Value, format!("no schedule for {budget} determines {rank} unknowns"));
    error.found(budget.to_string()).expected(match enough {
        Some(enough) => format!(
            "a budget of {} or more (the cheapest choice that was found to determine them), or positions that are kept",
            (enough * 1e3 - 1e-6).ceil() / 1e3
        ),
        None => "a larger budget, or positions that are kept".into(),
    })
    .argument("keep", "")
}

/// What would be lost without one mounting.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "ReasonReport")]
pub struct Reason {
    /// Label of the mounting.
    pub position: String,
    /// The parameter that would lose most.
    pub parameter: String,
    /// By what factor its uncertainty would grow; null where nothing would determine it.
    pub grows: Option<f64>,
}

/// With more mountings or readings than this, reasons are not looked for.
const MOST_REASONS: usize = 100;
const MOST_READINGS: usize = 2000;

/// Every mounting after the first `kept` readings, left out in turn.
fn reasons(schedule: &Campaign, noise: &Noise, kept: usize) -> Result<Vec<Reason>> {
    let rows = &schedule.readings.rows;
    let mountings = grouped(rows.iter().skip(kept).map(|row| (row.position.as_str(), row.position.as_str())));
    if mountings.len() > MOST_REASONS || rows.len() > MOST_READINGS {
        return Ok(Vec::new());
    }
    let n = schedule.unknowns();
    let u = |readings: &Readings| -> Result<Vec<Option<f64>>> {
        let there = schedule.with_readings(readings.clone());
        let (_, _, estimate) = Independent::at(&there, &there.reference_point(), noise)?;
        let known = |k: usize| estimate.unknowns.is_estimable(k);
        Ok((0..n).map(|k| known(k).then(|| estimate.unknowns.covariance[(k, k)].sqrt())).collect())
    };
    let with = u(&schedule.readings)?;
    let mut reasons = Vec::with_capacity(mountings.len());
    for label in mountings.iter().filter_map(|mounting| mounting.first().copied()) {
        let remaining =
            rows.iter().enumerate().filter(|(k, row)| *k < kept || row.position != label).map(|(_, row)| row.clone());
        let remaining = Readings { columns: schedule.readings.columns.clone(), rows: remaining.collect() };
        let without = if remaining.rows.is_empty() { vec![None; n] } else { u(&remaining)? };
        let growth = |k: usize| match (with.get(k).copied().flatten(), without.get(k).copied().flatten()) {
            (Some(with), Some(without)) if with > 0.0 => without / with,
            (Some(_), None) => f64::INFINITY,
            _ => 1.0,
        };
        let most = (0..n).max_by(|a, b| growth(*a).total_cmp(&growth(*b)).then(b.cmp(a)));
        if let Some(parameter) = most {
            let grows = Some(growth(parameter)).filter(|g| g.is_finite());
            let parameter = schedule.parameter_id(parameter).to_string();
            reasons.push(Reason { position: label.to_string(), parameter, grows });
        }
    }
    Ok(reasons)
}

/// Angles moved between the candidates.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "RefinedReport")]
pub struct Refined {
    /// Angles were moved in multiples of this, in degrees.
    pub resolution_deg: f64,
    /// Mountings with an angle that no candidate has.
    pub moved: usize,
    /// By what share the criterion is better: the determinant for each unknown (D), a variance (else).
    pub gain: f64,
    /// The criterion there: `-log det M` (D), a variance, or with a goal the largest `(u / limit)^2`.
    #[serde(skip)]
    pub value: f64,
    /// Did it end because no move was worth it? Else because of the effort.
    pub finished: bool,
}

/// Rows that are evaluated at most: some seconds.
const EFFORT: usize = 4_000_000;

/// A joint that may move: its place in the chain, the range (degrees; `None` all round) and the step of the candidates.
struct Freedom {
    joint: usize,
    range: Option<(f64, f64)>,
    step: f64,
}

impl Question<'_> {
    /// The rows of a schedule after those that are kept with their angles moved; `None` without such a request, or where the criterion cannot be compared.
    /// A value of `enough` ends the search.
    ///
    /// Errors: those of the model at the moved angles.
    pub(super) fn refined(
        &self,
        before: &[Reading],
        objective: &Objective,
        enough: Option<f64>,
    ) -> Result<Option<(Vec<Reading>, Refined)>> {
        let Question { campaign, pool, offer, request, .. } = self;
        let Some(wanted) = &request.refine else { return Ok(None) };
        let resolution = wanted.resolution_deg;
        let names: Vec<&str> = campaign.bench.joints().collect();
        let value_of = |rows: &[Reading]| pool.value(campaign, &self.with_rows(rows).readings, &offer.noise, objective);
        let Some(start) = value_of(before)? else { return Ok(None) };
        // the rows with one joint of a mounting moved; none where it may not be, or turns
        let moved = |rows: &[Reading], group: &[usize], freedom: &Freedom, way: f64| {
            let mut moved = rows.to_vec();
            for k in group {
                let row = moved.get_mut(*k)?;
                let mut joints = row.joints.clone();
                let angle = joints.get(freedom.joint)?.held_deg()? + way;
                let angle = match freedom.range {
                    Some((low, high)) if (low..=high).contains(&angle) => angle,
                    Some(_) => return None,
                    None => (angle.rem_euclid(360.0) * 1e9).round() / 1e9 % 360.0,
                };
                *joints.get_mut(freedom.joint)? = JointState::Held { angle_deg: angle };
                let there = campaign.readings.position(&names, row, joints);
                if is_forbidden(&names, &wanted.zones, &there) {
                    return None;
                }
                row.columns = there.columns;
                row.joints = there.joints;
            }
            Some(moved)
        };
        // mountings, in the order of the rows
        let to_move = before.iter().enumerate().skip(offer.kept.rows.len());
        let groups = grouped(to_move.map(|(i, row)| (i, format!("{} {:?}", row.position, mounting(row)))));
        let freedoms = freedoms(pool, names.len());
        let (mut rows, mut now) = (before.to_vec(), start);
        let (mut effort, mut finished) = (0, true);
        let widest = freedoms.iter().map(|f| f.step).fold(0.0, f64::max);
        let mut share = 0.5;
        'levels: while widest * share >= 0.5 * resolution {
            // both senses until nothing moves at this step
            loop {
                let mut improved = false;
                for (group, freedom) in groups.iter().flat_map(|group| freedoms.iter().map(move |own| (group, own))) {
                    let step = ((freedom.step * share / resolution).round() * resolution).max(resolution);
                    for way in [step, -step] {
                        if effort > EFFORT {
                            finished = false;
                            break 'levels;
                        }
                        let Some(moved) = moved(&rows, group, freedom, way) else { continue };
                        effort += rows.len();
                        if let Some(value) = value_of(&moved)?
                            && value < now - WORTH * now.abs().max(1.0)
                        {
                            (rows, now, improved) = (moved, value, true);
                            if enough.is_some_and(|enough| now <= enough) {
                                break 'levels;
                            }
                            break;
                        }
                    }
                }
                if !improved {
                    break;
                }
            }
            share /= 2.0;
            request.progress.tell("degrees of resolution", 0, number::count((widest * share).ceil()));
        }
        let n = pool.blocks.unknowns().max(1) as f64;
        let gain = match objective {
            Objective::Determinant => ((start - now) / n).exp_m1(),
            _ => start / now - 1.0,
        };
        let changed = |group: &&Vec<usize>| {
            group.first().is_some_and(|k| rows.get(*k).map(mounting) != before.get(*k).map(mounting))
        };
        let moved = groups.iter().filter(changed).count();
        Ok(Some((rows, Refined { resolution_deg: resolution, moved, gain, value: now, finished })))
    }
}

/// Joints that are held at several angles in the candidates.
fn freedoms(pool: &Pool, joints: usize) -> Vec<Freedom> {
    let angles = |joint: usize| {
        let held = pool.portions.iter().flatten().filter_map(|reading| reading.joints.get(joint)?.held_deg());
        let mut angles: Vec<f64> = held.collect();
        angles.sort_by(f64::total_cmp);
        angles.dedup();
        angles
    };
    (0..joints)
        .filter_map(|joint| {
            let angles = angles(joint);
            let (low, high) = (*angles.first()?, *angles.last()?);
            let steps = || angles.iter().zip(angles.iter().skip(1)).map(|(before, angle)| angle - before);
            let step = steps().fold(f64::INFINITY, f64::min);
            let widest = steps().fold(0.0, f64::max);
            if !(step.is_finite() && step > 0.0) {
                return None;
            }
            // the step from the last to the first is no wider than the others: all round
            let round = low + 360.0 - high <= widest * (1.0 + 1e-9);
            Some(Freedom { joint, range: (!round).then_some((low, high)), step })
        })
        .collect()
}
