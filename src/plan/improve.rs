//! The best positions: chosen anew, or added to those kept.

use super::blocks::{add_outer, rank};
use super::bound::{Bound, bound};
use super::candidates::frozen;
use super::criterion::objective;
use super::effort::{Costs, Offer, planned};
use super::judge::{Judgement, check_question, judge};
use super::objective::Objective;
use super::point::check_point;
use super::pool::{Pool, from_coarser};
use super::prices::Prices;
use super::problem::Problem;
use super::request::{Method, Request};
use super::scheduled::{Reason, Refined, check, reasons, refined, schedule_rows, scheduled};
use super::search::{Limits, Outcome, search};
use crate::campaign::{Campaign, Reading, Readings};
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
    /// Criterion by a fresh QR of the final schedule against the one that the exchange had, as a relative difference; not where angles moved.
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
    let (first, proof) = improve_within(campaign, offer, request)?;
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
        let less = Request { budget: Some(within), may_cost_more: false, ..request.clone() };
        match improve_within(campaign, offer, &less) {
            // the first proof is for the whole budget
            Ok((next, proof_within)) => {
                let efficiency = proof.share_of(proof_within.value);
                let enumerated = next.enumerated.filter(|_| efficiency.is_some_and(|share| share >= 1.0));
                plan = Improvement { efficiency, bound_gap: first.bound_gap, enumerated, ..next };
            }
            Err(_) => break,
        }
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

/// The best positions, the way between them not counted.
fn improve_within(campaign: &Campaign, offer: &Offer, request: &Request) -> Result<(Improvement, Proof)> {
    let question = Question::new(campaign, offer, request)?;
    if let Some(budget) = request.budget {
        check_budget(budget, &offer.costs, request)?;
    }
    let mut sought = question.sought(request.budget)?;
    if sought.is_none()
        && let Some(budget) = request.budget
    {
        let pool = question.pool(&offer.candidates)?;
        if request.readings > 0 && too_small(&pool, request) {
            return Err(too_few(&pool, request));
        }
        let cost_within = |more: f64| {
            let sought = question.seek(pool.clone(), Some(more), 20, &|_| Vec::new()).ok()??;
            Some(question.prices(&pool, 0.0).of(&sought.outcome.design.chosen))
        };
        let enough = least_budget(budget, cost_within);
        if let (true, Some(enough)) = (request.may_cost_more, enough) {
            sought = question.sought(Some(enough))?;
        }
        if sought.is_none() {
            return Err(too_poor(budget, &pool, enough));
        }
    }
    let Some(Sought { pool, objective, outcome, bound_gap, limit, proof }) = sought else {
        return Err(too_few(&question.pool(&offer.candidates)?, request));
    };
    let Outcome { design, hits, starts, enumerated, .. } = outcome;
    let rows = question.rows(&pool, &design.chosen);
    let improvement = match question.refined(&rows, (&pool, &objective), None)? {
        Some((moved, what)) => Improvement { refined: Some(what), ..question.made(&pool, moved)? },
        None => {
            let improvement = question.made(&pool, rows)?;
            Improvement {
                check: check(&improvement.schedule, &offer.noise, &pool, &objective, &design)?,
                ..improvement
            }
        }
    };
    let efficiency = proof.share_of(design.value);
    Ok((Improvement { limit, efficiency, bound_gap, enumerated, hits, starts, ..improvement }, proof))
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

/// The question, for any set of candidates.
pub(super) struct Question<'a> {
    campaign: &'a Campaign,
    /// What is kept, as it is planned.
    kept: Readings,
    offer: &'a Offer,
    request: &'a Request,
}

/// The result for one set of candidates.
struct Sought {
    pool: Pool,
    objective: Objective,
    outcome: Outcome,
    bound_gap: Option<f64>,
    limit: Option<f64>,
    proof: Proof,
}

impl<'a> Question<'a> {
    /// A valid question. Errors: nothing to estimate, impossible costs or resolutions, a point at which requested parameters are not estimable.
    pub fn new(campaign: &'a Campaign, offer: &'a Offer, request: &'a Request) -> Result<Self> {
        check_question(campaign)?;
        offer.costs.check()?;
        if let Some(wanted) = &request.refine {
            wanted.check()?;
        }
        let kept = planned(campaign, &offer.kept);
        check_point(campaign, &kept, &offer.candidates, &offer.noise)?;
        Ok(Question { campaign, kept, offer, request })
    }

    /// Where remounting scatters, every portion is a separate mounting.
    fn apart(&self) -> bool {
        !self.offer.noise.remount.is_empty()
    }

    pub fn pool(&self, candidates: &Readings) -> Result<Pool> {
        Pool::new(self.campaign, &self.kept, candidates, self.request.unit, &self.offer.noise, &[])
    }

    pub fn prices(&self, pool: &Pool, budget: f64) -> Prices {
        Prices::new(&pool.portions, &pool.levels, self.offer.costs, budget, self.apart())
    }

    /// What is kept, then the portions chosen of a pool.
    pub fn rows(&self, pool: &Pool, chosen: &[usize]) -> Vec<Reading> {
        schedule_rows(&self.kept, pool, chosen, self.apart())
    }

    /// These rows with their angles moved, where the request says so.
    pub fn refined(
        &self,
        rows: &[Reading],
        of: (&Pool, &Objective),
        enough: Option<f64>,
    ) -> Result<Option<(Vec<Reading>, Refined)>> {
        refined(self.campaign, rows, of, self.offer, self.request, enough)
    }

    /// The schedule of rows chosen of a pool: how well it will do, and why each mounting is there.
    pub fn made(&self, pool: &Pool, rows: Vec<Reading>) -> Result<Improvement> {
        let kept = self.kept.rows.len();
        let schedule = scheduled(self.campaign, &self.kept, rows, self.offer, self.request)?;
        Ok(Improvement {
            reasons: reasons(&schedule, &self.offer.noise, kept)?,
            unreachable: pool.not_estimable.clone(),
            frozen: frozen(self.campaign, &self.offer.candidates),
            ..Improvement::of(schedule, self.offer, pool.portions.len(), kept)?
        })
    }

    /// The best of all candidates, started from the results of coarser sweeps within them; `None` where no choice determines the unknowns.
    fn sought(&self, limit: Option<f64>) -> Result<Option<Sought>> {
        let (candidates, starts) = (&self.offer.candidates, self.request.starts);
        let best = |pool: &Pool, given: &[Vec<usize>]| {
            Some(self.seek(pool.clone(), limit, starts, &|_| given.to_vec()).ok()??.outcome.design.chosen)
        };
        let coarser = |pool: &Pool| from_coarser(candidates, pool, |readings| self.pool(readings), best);
        self.seek(self.pool(candidates)?, limit, starts, &coarser)
    }

    /// The best of one pool; `given` are further designs from which exchanges start, unless all designs are tried.
    fn seek(
        &self,
        pool: Pool,
        limit: Option<f64>,
        starts: usize,
        given: &dyn Fn(&Pool) -> Vec<Vec<usize>>,
    ) -> Result<Option<Sought>> {
        let objective = objective(self.campaign, &pool, &self.request.criterion)?;
        let (choose, prices) = self.wanted(&pool, limit)?;
        let neighbours = if self.request.method == Method::Coordinate { pool.neighbours() } else { Vec::new() };
        let problem = Problem {
            choose,
            most_repeats: self.request.most_repeats,
            neighbours: &neighbours,
            prices: prices.as_ref(),
            ..Problem::of(&pool.blocks, &pool.base, &objective)
        };
        let given = || given(&pool);
        let limits = Limits { starts, ..Limits::of(self.request, &given) };
        let Some(outcome) = search(&problem, &limits, || guide(&problem)) else { return Ok(None) };
        let (value, guide, n) = (outcome.design.value, &outcome.guide, pool.blocks.unknowns() as f64);
        let proof = Proof {
            value,
            least: outcome.enumerated.map(|_| value).or(guide.as_ref().map(|bound| bound.value)),
            logarithm_of: (objective == Objective::Determinant).then_some(n),
        };
        let bound_gap = match outcome.enumerated {
            Some(_) => Some(0.0),
            None => guide.as_ref().and_then(|bound| Some(1.0 - proof.share_of(bound.reached)?)),
        };
        Ok(Some(Sought { pool, objective, outcome, bound_gap, limit, proof }))
    }

    fn wanted(&self, pool: &Pool, limit: Option<f64>) -> Result<(usize, Option<Prices>)> {
        let choose = match (limit, self.request.readings) {
            (Some(_), 0) => usize::MAX,
            _ => portions_to_choose(pool, self.request)?,
        };
        // a limit above the cost of every choice is left out
        let dearest = |prices: &Prices| (0..pool.portions.len()).map(|j| prices.alone(j)).fold(0.0, f64::max);
        let prices = limit.map(|limit| self.prices(pool, limit));
        Ok((choose, prices.filter(|prices| !prices.affords(choose as f64 * dearest(prices)))))
    }
}

/// The approximate design of a problem; within a budget, of as many portions as the fewest mountings that determine all unknowns could hold.
pub(super) fn guide(problem: &Problem<'_>) -> Option<Bound> {
    let total = match problem.prices {
        None => problem.choose as f64,
        Some(prices) => prices.most_portions(fewest_mountings(problem, prices)).min(problem.choose as f64),
    };
    (total >= 1.0).then(|| bound(problem.blocks, problem.base, problem.objective, total)).flatten()
}

/// No fewer mountings determine all unknowns, since each has at most the rank of its rows.
fn fewest_mountings(problem: &Problem<'_>, prices: &Prices) -> usize {
    let (blocks, n) = (problem.blocks, problem.blocks.unknowns());
    let mut information = vec![vec![0.0; n * n]; prices.places];
    for (j, place) in prices.place.iter().enumerate() {
        if let Some(m) = information.get_mut(*place) {
            (0..blocks.rows()).for_each(|r| add_outer(m, 1.0, &blocks.row(j, r)));
        }
    }
    let most = information.iter().map(|m| rank(m, n)).max().unwrap_or(1).max(1);
    n.saturating_sub(rank(problem.base, n)).div_ceil(most).max(1)
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
    let rank = pool.determined();
    Malformed::new(Fault::Value, format!("no {} of these candidates determine {rank} unknowns", request.readings))
        .expected(format!(
            "at least {} readings, or more positions kept",
            rank.div_ceil(pool.blocks.rows()) * pool.portion_size()
        ))
        .found(request.readings.to_string())
}

fn check_budget(budget: f64, costs: &Costs, request: &Request) -> Result<()> {
    let bad = |expected: &str, value: String| {
        Err(Malformed::new(Fault::Value, "the budget is not possible").expected(expected).found(value))
    };
    if !(budget > 0.0 && budget.is_finite()) {
        return bad("a positive number, in the unit of the costs", budget.to_string());
    }
    if costs.reading == 0.0 && request.readings == 0 && request.most_repeats == usize::MAX {
        return bad(
            "readings that cost something, or a limit on repeats; else there is no end to them",
            "free readings".into(),
        )
        .map_err(|error: Malformed| error.argument("repeats", "N"));
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

/// The least cost above `poor` at which the search gives a choice that determines the unknowns: by growth, then by bisection.
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
