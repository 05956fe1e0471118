//! Positions that tell effects apart.
//!
//! If the truth has the term `a` with coefficient 1, the model with `b` in its place lacks
//!
//! ```text
//! T = min over x, beta of |a - A x - beta b|^2 / u^2 = 1 / [M^-1]_aa,   M the information of (A, a, b)
//! ```
//!
//! (A. C. Atkinson, V. V. Fedorov, Biometrika 62 (1975) 57: T-optimality; for linear rivals it is the c-criterion of the rival's coefficient.)
//! Which of two is true nobody knows, so both take part, each in units of what all candidates could reach.

use super::blocks::{dot, invert, times};
use super::candidates::Unit;
use super::criterion::weight_matrix;
use super::effort::{Offer, positions_only};
use super::exchange::{Objective, Problem, best_of_starts, information};
use super::improve::{Improvement, Request, schedule_rows};
use super::judge::{check_question, judge};
use super::order::ordered;
use super::pool::Pool;
use super::whitened::Term;
use crate::campaign::{Campaign, Reading, Readings};
use crate::error::Result;

/// Positions that tell two terms apart.
#[derive(Debug, Clone)]
pub struct Discrimination {
    /// Positions to add; empty where no candidate tells them apart.
    pub positions: Vec<Reading>,
    /// Standard uncertainties of the two coefficients with both in the model line, before; `None` where they are confused.
    pub before: [Option<f64>; 2],
    /// The same with the added positions.
    pub after: [Option<f64>; 2],
    /// Starts of the exchange that ended here.
    pub hits: usize,
}

/// The positions, `readings` or as many more as it takes, whose addition to those kept tells term `a` from term `b` best.
///
/// What is kept counts with the values that were read there. Errors: a term that uses what is no input here, no candidates. That nothing
/// separates them is a result.
pub fn discriminate(
    campaign: &Campaign,
    offer: &Offer,
    terms: [&Term; 2],
    readings: usize,
    starts: usize,
    seed: u64,
) -> Result<Discrimination> {
    let Offer { kept, candidates, noise, .. } = offer;
    check_question(campaign)?;
    let pool = Pool::new(campaign, kept, candidates, Unit::Reading, noise, &terms.map(Clone::clone))?;
    let n = campaign.unknowns();
    let coordinates = [n, n + 1].map(|k| {
        let unit: Vec<f64> = (0..n + 2).map(|j| f64::from(u8::from(j == k))).collect();
        pool.coordinates(&unit)
    });
    let nothing = Discrimination { positions: Vec::new(), before: [None; 2], after: [None; 2], hits: 0 };
    let [Some(a), Some(b)] = &coordinates else { return Ok(nothing) };
    let u = |m: &[f64], c: &[f64]| {
        let (inverse, _) = invert(m, pool.blocks.unknowns())?;
        Some(dot(c, &times(&inverse, c)).sqrt())
    };
    let share = |c: &Vec<f64>| (1.0 / dot(c, c), c.clone());
    let objective = Objective::Trace(weight_matrix(&[share(a), share(b)], pool.blocks.unknowns()));
    // singular with too few: one more until regular
    let most = readings.max(1) + pool.blocks.unknowns();
    let found = (readings.max(1)..=most).find_map(|choose| {
        let problem = Problem {
            blocks: &pool.blocks,
            base: &pool.base,
            objective: &objective,
            choose,
            most_repeats: usize::MAX,
            neighbours: &[],
            prices: None,
        };
        best_of_starts(&problem, starts, seed)
    });
    let Some((design, hits)) = found else { return Ok(nothing) };
    let after = information(&pool.blocks, &pool.base, &design.chosen);
    let all = schedule_rows(kept, &pool, &design.chosen, false);
    Ok(Discrimination {
        positions: all.into_iter().skip(kept.rows.len()).collect(),
        before: [u(&pool.base, a), u(&pool.base, b)],
        after: [u(&after, a), u(&after, b)],
        hits,
    })
}

/// A schedule that tells two effects apart.
#[derive(Debug, Clone)]
pub struct Separated {
    /// What was kept, then what was added; and how well it will do for the estimated parameters.
    pub improvement: Improvement,
    /// Standard uncertainties of the two coefficients before; `None` where nothing tells them apart.
    pub before: [Option<f64>; 2],
    /// The same with the added positions.
    pub after: [Option<f64>; 2],
}

/// The schedule that is kept, with `request.readings` more positions (or as many as it takes) that tell two effects apart; its criterion plays
/// no part. That nothing separates them is a result: nothing is added. Errors: those of [`discriminate`].
pub fn separate(campaign: &Campaign, offer: &Offer, terms: [&Term; 2], request: &Request) -> Result<Separated> {
    let found = discriminate(campaign, offer, terms, request.readings, request.starts, request.seed)?;
    let kept = positions_only(&offer.kept);
    let chosen = found.positions.len();
    let added = campaign.with_readings(Readings { columns: kept.columns.clone(), rows: found.positions });
    let mut rows = kept.rows;
    rows.extend(ordered(&added, &offer.noise, request.order, request.seed)?.rows);
    let schedule = campaign.with_readings(Readings { columns: kept.columns, rows });
    let judgement = judge(&schedule, &offer.noise, &offer.costs)?;
    Ok(Separated {
        before: found.before,
        after: found.after,
        improvement: Improvement {
            schedule,
            judgement,
            candidates: offer.candidates.rows.len(),
            chosen,
            efficiency: None,
            bound_gap: None,
            hits: found.hits,
            starts: request.starts.max(1),
            check: None,
            unreachable: Vec::new(),
        },
    })
}
