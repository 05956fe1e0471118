//! The question of every search (by number, budget or goal, or to discriminate), the designs that answer it, and their schedules:
//! labels and order.
//!
//! The augmented model: a campaign with effects as further unknowns. With the effect's column `c` in the model, `u = 1 / |c'|` is the standard uncertainty of
//! its coefficient, `c'` being the residual of `c` after projection on the other columns: a limit on `u` is a limit on the size that a diagnosis detects, and
//! with a second effect in the model on the size that is discriminated from it.

use super::blocks::roots;
use super::bound::{Bound, bound};
use super::effort::{Offer, mounting, planned};
use super::judge::check_question;
use super::objective::Objective;
use super::order::ordered;
use super::point::check_point;
use super::pool::Pool;
use super::prices::Prices;
use super::problem::Problem;
use super::request::{Method, Request};
use super::search::{Limits, Outcome, search};
use super::whitened::{Term, level_of};
use crate::algebra::Expression;
use crate::campaign::{Campaign, Label, Reading, Readings, Role};
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use crate::simulate::Regressor;
use std::collections::HashMap;

/// The question: the candidates, what is kept, and how to search.
pub(super) struct Question<'a> {
    pub campaign: &'a Campaign,
    /// What is kept, as it is planned.
    pub kept: Readings,
    pub offer: &'a Offer,
    pub request: &'a Request,
    /// The candidates.
    pub pool: Pool,
    /// What they cost; the budget is that of each search.
    pub prices: Prices,
}

impl<'a> Question<'a> {
    /// A valid question; `terms` are further unknowns. Errors: nothing to estimate, impossible costs or resolutions, a point at which requested parameters
    /// are not estimable, candidates that do not form portions.
    pub fn new(campaign: &'a Campaign, offer: &'a Offer, request: &'a Request, terms: &[Term]) -> Result<Self> {
        check_question(campaign)?;
        offer.costs.check()?;
        if let Some(wanted) = &request.refine {
            wanted.check()?;
        }
        let kept = planned(campaign, &offer.kept);
        check_point(campaign, &kept, &offer.candidates, &offer.noise)?;
        let pool = Pool::new(campaign, &kept, &offer.candidates, request.unit, &offer.noise, terms)?;
        Ok(Question { campaign, kept, offer, request, prices: prices(campaign, offer, &pool), pool })
    }

    /// The same question with some of the candidates.
    fn subset(&self, portions: &[usize]) -> Self {
        let pool = self.pool.subset(portions);
        Question { kept: self.kept.clone(), prices: prices(self.campaign, self.offer, &pool), pool, ..*self }
    }

    /// Kept readings, then the portions chosen. New mountings are numbered on from the kept labels; where remounting scatters, a repeat is a new mounting.
    pub fn rows(&self, chosen: &[usize]) -> Vec<Reading> {
        let Question { campaign, kept, offer, pool, .. } = self;
        let mut rows: Vec<Reading> = kept.rows.clone();
        let (first, mut labels): (u64, HashMap<String, u64>) = (next_label(kept), HashMap::new());
        for (k, portion) in chosen.iter().filter_map(|j| pool.portions.get(*j)).enumerate() {
            let place = if is_apart(offer) { k.to_string() } else { mounting_of(campaign, offer, portion) };
            let next = first + labels.len() as u64;
            let label: Label = labels.entry(place).or_insert(next).to_string().into();
            rows.extend(portion.iter().map(|r| Reading { position: label.clone(), ..r.clone() }));
        }
        rows
    }

    /// A campaign with such rows, every one to be read.
    pub fn with_rows(&self, rows: &[Reading]) -> Campaign {
        let readings = Readings { columns: self.kept.columns.clone(), rows: rows.to_vec() };
        self.campaign.with_readings(planned(self.campaign, &readings))
    }

    /// The schedule of such rows in the order to run. New mountings are numbered in this order; labels that were kept stay.
    pub fn scheduled(&self, rows: &[Reading]) -> Result<Campaign> {
        let Question { campaign, kept, offer: Offer { noise, costs, .. }, request, .. } = self;
        let mut run = ordered(&self.with_rows(rows), noise, costs, request.order, request.seed, kept.rows.len())?;
        let old: Vec<&str> = kept.rows.iter().map(|r| r.position.as_str()).collect();
        let (first, mut names): (u64, HashMap<Label, u64>) = (next_label(kept), HashMap::new());
        for reading in run.rows.iter_mut().filter(|r| !old.contains(&r.position.as_str())) {
            let next = first + names.len() as u64;
            reading.position = names.entry(reading.position.clone()).or_insert(next).to_string().into();
        }
        Ok(campaign.with_readings(run))
    }

    /// The best design of so many portions, or within a budget; `None` where none determines the unknowns.
    pub fn seek(
        &self,
        objective: &Objective,
        choose: usize,
        budget: Option<f64>,
        limits: &Limits<'_>,
    ) -> Option<Outcome> {
        let Question { pool, request, .. } = self;
        // a budget above the cost of every choice is left out
        let prices = budget.map(|budget| self.prices.with_budget(budget));
        let prices = prices.filter(|prices| !prices.affords(choose as f64 * prices.dearest()));
        let neighbours = if request.method == Method::Coordinate { pool.neighbours() } else { Vec::new() };
        let problem = Problem {
            choose,
            most_repeats: request.most_repeats,
            neighbours: &neighbours,
            prices: prices.as_ref(),
            ..Problem::of(&pool.blocks, &pool.base, objective)
        };
        let guided = limits.bounded || (problem.prices.is_none() && problem.has_many());
        search(&problem, limits, || guided.then(|| guide(&problem)).flatten())
    }

    /// Results of coarser sweeps, each started from those within it: from them the finer search starts, so that more candidates never give a worse design.
    pub fn coarser(&self, best: &dyn Fn(&Question<'a>, &[Vec<usize>]) -> Option<Vec<usize>>) -> Vec<Vec<usize>> {
        let mut results: Vec<(usize, Vec<usize>)> = Vec::new();
        for (steps, list) in self.pool.coarser() {
            let within = results.iter().filter(|(coarser, _)| steps.is_multiple_of(*coarser));
            let places = |chosen: &Vec<usize>| chosen.iter().map(|k| list.binary_search(k).ok()).collect();
            let given: Vec<Vec<usize>> = within.filter_map(|(_, chosen)| places(chosen)).collect();
            let found = best(&self.subset(&list), &given);
            results.extend(found.map(|chosen| (steps, chosen.iter().map(|k| list.at(*k)).collect())));
        }
        results.into_iter().map(|(_, chosen)| chosen).collect()
    }
}

/// The number after the largest numeric label. (One of more than 32 bits is a serial number, and none that is counted on from.)
fn next_label(readings: &Readings) -> u64 {
    1 + u64::from(readings.rows.iter().filter_map(|r| r.position.parse::<u32>().ok()).max().unwrap_or(0))
}

/// Where remounting scatters, every portion is a separate mounting.
fn is_apart(offer: &Offer) -> bool {
    !offer.noise.remount.is_empty()
}

/// The mounting of a portion: its angles, and its level in the columns by which positions share deviations.
fn mounting_of(campaign: &Campaign, offer: &Offer, portion: &[Reading]) -> String {
    let first = portion.first().map(|r| format!("{:?} {}", mounting(r), level_of(campaign, &offer.candidates, r)));
    // portions have readings
    first.unwrap_or_default()
}

fn prices(campaign: &Campaign, offer: &Offer, pool: &Pool) -> Prices {
    let mounting = |portion: &[Reading]| mounting_of(campaign, offer, portion);
    Prices::new(&pool.portions, mounting, offer.costs, is_apart(offer))
}

/// The approximate design of a problem; within a budget, of as many portions as the fewest mountings that determine all unknowns could hold.
fn guide(problem: &Problem<'_>) -> Option<Bound> {
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
            blocks.add(m, 1.0, j);
        }
    }
    let most = information.into_iter().map(|m| roots(m, n).len()).max().unwrap_or(1).max(1);
    n.saturating_sub(roots(problem.base.to_vec(), n).len()).div_ceil(most).max(1)
}

/// The campaign with these effects as further unknowns, and the names of their coefficients.
///
/// A term is appended to its sensor's model line with its coefficient (`c_a_S*a_S`); a tilt assumed zero or a known parameter is
/// estimated. Errors: an effect of single readings or positions, one that is estimated already.
pub fn extended(campaign: &Campaign, terms: &[Term]) -> Result<(Campaign, Vec<String>)> {
    let mut bench = campaign.bench.clone();
    let mut names: Vec<String> = Vec::new();
    let mut promoted: Vec<usize> = Vec::new();
    for term in terms {
        match (&term.regressor, term.sensor) {
            (Regressor::Tilt(k) | Regressor::Known(k), _) => {
                let parameter = campaign.parameters.get(*k);
                let id = parameter.map_or(String::new(), |p| p.id.clone());
                if parameter.is_none_or(|p| matches!(p.role, Role::Estimated { .. })) {
                    return Err(Malformed::new(
                        Fault::Value,
                        format!("'{id}' is estimated here, so it cannot be a missing effect"),
                    )
                    .expected("a goal, for a limit on its uncertainty")
                    .argument("goal", format!("{id}=U"))
                    .found(format!("'{id}'")));
                }
                promoted.push(*k);
                names.push(id);
            }
            (Regressor::Term(line), Some(sensor)) => {
                let name = coefficient(campaign, &names, &line.to_string());
                if let Some(sensor) = bench.sensors.get_mut(sensor) {
                    sensor.model = sensor.model.plus(&Expression::parse(&name)?.times(line));
                }
                names.push(name);
            }
            _ => {
                return Err(Malformed::new(Fault::Value, "this effect cannot become an unknown of a plan")
                    .expected("a term of the inputs (a_S, w_I^2, sin(2*beta)), tilt:NAME or known:NAME"));
            }
        }
    }
    let fresh = names.iter().filter(|name| campaign.parameter_index(name).is_none()).cloned().collect();
    let longer = campaign.extended(bench, campaign.readings.clone(), &promoted, fresh)?;
    Ok((longer, names))
}

/// An unused name for a term's coefficient: `c_sin_2_beta` for `sin(2*beta)`.
fn coefficient(campaign: &Campaign, taken: &[String], term: &str) -> String {
    let words: Vec<&str> = term.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|w| !w.is_empty()).collect();
    let plain = format!("c_{}", words.join("_"));
    let is_taken = |name: &String| campaign.parameter_index(name).is_some() || taken.contains(name);
    (2..1000)
        .map(|k| format!("{plain}_{k}"))
        .fold(plain.clone(), |name, next| if is_taken(&name) { next } else { name })
}
