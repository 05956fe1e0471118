//! The best positions: chosen anew, or added to those kept.

use super::candidates::frozen;
use super::criterion::objective;
use super::effort::{Costs, Offer};
use super::judge::{Judgement, judge};
use super::objective::Objective;
use super::pool::Pool;
use super::problem::Problem;
use super::question::Question;
use super::request::Request;
use super::scheduled::{Reason, Refined, reasons};
use super::search::{Limits, Outcome, least};
use crate::campaign::{Campaign, Reading};
use crate::error::{Fault, Malformed, Result};
use crate::fit::RankDefect;

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
    /// What the chosen ones might cost, where that was limited.
    pub limit: Option<f64>,
    /// At least this share of what the best conceivable weights reach: `(det M / det M*)^(1/n)` for D, `tr*/tr` for A and C, `max*/max` for G.
    pub efficiency: Option<f64>,
    /// How far the bound behind it may be off, as a share: the criterion of the weights less the bound. A larger shortfall means
    /// that so few readings cannot follow the weights.
    pub bound_gap: Option<f64>,
    /// Designs that there are, where all of them were tried: none is better.
    pub enumerated: Option<u64>,
    /// Starts that ended at the best value.
    pub hits: usize,
    /// Starts that were made.
    pub starts: usize,
    /// What moving the angles between the candidates brought; efficiency and enumeration speak of the choice among the candidates before it.
    pub refined: Option<Refined>,
    /// Criterion from the rows of the final schedule against the one that the exchange had, as a relative difference; not where angles moved.
    pub check: Option<f64>,
    /// What even all candidates together do not determine.
    pub unreachable: Vec<RankDefect>,
    /// Columns that differ in the schedule and have one value in all candidates, with that value.
    pub frozen: Vec<(String, f64)>,
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
            return Ok(Improvement { limit: plan.limit.map(|_| budget), ..plan });
        }
        // another choice has another way: not all at once
        within = (budget - way(&plan)).clamp(0.85 * within, 0.98 * within);
        // the first proof is for the whole budget
        let Ok((next, proof_within)) = question.best(&objective, Some(within), false) else { break };
        let efficiency = proof.share_of(proof_within.value);
        let enumerated = next.enumerated.filter(|_| efficiency.is_some_and(|share| share >= 1.0));
        plan = Improvement { efficiency, bound_gap: first.bound_gap, enumerated, ..next };
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
            limit: None,
            efficiency: None,
            bound_gap: None,
            enumerated: None,
            hits: 0,
            starts: 0,
            refined: None,
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
        let improvement = match self.refined(&rows, objective, None)? {
            Some((moved, what)) => Improvement { refined: Some(what), ..self.made(&moved)? },
            None => {
                let made = self.made(&rows)?;
                let fresh = pool.value(&made.schedule, &made.schedule.readings, &self.offer.noise, objective)?;
                let check = fresh.map(|value| match objective {
                    // per unknown, as a relative change of the determinant
                    Objective::Determinant => (value - design.value).abs() / self.campaign.unknowns() as f64,
                    _ => (value / design.value - 1.0).abs(),
                });
                Improvement { check, ..made }
            }
        };
        let efficiency = proof.share_of(design.value);
        Ok((Improvement { limit, efficiency, bound_gap, enumerated, hits, starts, ..improvement }, proof))
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
