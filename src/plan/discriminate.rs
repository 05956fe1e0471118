//! Positions that tell two effects apart.
//!
//! If the truth has the term `a` with coefficient 1, the model with `b` in its place lacks
//!
//! ```text
//! T = min over x, beta of |a - A x - beta b|^2 / u^2 = 1 / [M^-1]_aa,   M the information of (A, a, b)
//! ```
//!
//! (A. C. Atkinson, V. V. Fedorov, Biometrika 62 (1975) 57: T-optimality; for linear rivals it is the c-criterion of the rival's coefficient.)

use super::candidates::Unit;
use super::effort::Offer;
use super::exchange::{Objective, Problem, information};
use super::improve::{best_of_starts, schedule_rows, weight_matrix};
use super::judge::check_question;
use super::pool::{Pool, Term};
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
}

/// The positions, `readings` or as many more as it takes, whose addition to those kept tells term `a` from term `b` best.
///
/// Errors: a term that uses what is no input here, no candidates. That nothing separates them is a result.
pub fn discriminate(campaign: &Campaign, offer: &Offer, terms: [&Term; 2], readings: usize) -> Result<Discrimination> {
    let Offer { kept, candidates, noise, .. } = offer;
    check_question(campaign)?;
    let pool = Pool::new(campaign, kept, candidates, Unit::Reading, noise, &terms.map(Clone::clone))?;
    let n = campaign.unknowns();
    let coordinates = [n, n + 1].map(|k| {
        let unit: Vec<f64> = (0..n + 2).map(|j| f64::from(u8::from(j == k))).collect();
        pool.coordinates(&unit)
    });
    let nothing = Discrimination { positions: Vec::new(), before: [None; 2], after: [None; 2] };
    let [Some(a), Some(b)] = &coordinates else { return Ok(nothing) };
    let u = |m: &[f64], c: &[f64]| {
        let (inverse, _) = super::blocks::invert(m, pool.blocks.unknowns())?;
        Some(super::blocks::dot(c, &super::blocks::times(&inverse, c)).sqrt())
    };
    let share = |c: &Vec<f64>| (1.0 / super::blocks::dot(c, c), c.clone());
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
        };
        best_of_starts(&problem, 20, 1)
    });
    let Some((design, _)) = found else { return Ok(nothing) };
    let after = information(&pool.blocks, &pool.base, &design.chosen);
    let none = Readings { columns: candidates.columns.clone(), rows: Vec::new() };
    Ok(Discrimination {
        positions: schedule_rows(&none, &pool, &design.chosen, false),
        before: [u(&pool.base, a), u(&pool.base, b)],
        after: [u(&after, a), u(&after, b)],
    })
}
