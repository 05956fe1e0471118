//! Iterative refinement of solution and residuals together, with right-hand sides in twice the working precision.
//!
//! The augmented system `v + A x = y`, `A' W^2 v = 0` is solved for corrections with the factorisation at hand: A. Bjorck,
//! "Iterative refinement of linear least squares solutions I", BIT 7 (1967). It makes the error of the solution nearly
//! independent of the condition number, and of the size of the residuals.
#![allow(
    clippy::indexing_slicing,
    reason = "the factor's basis holds columns of the system, and solution and scale have one entry for each column"
)]

use super::compensated::{accumulate, compensated_dot};
use super::factor::Factor;
use faer::MatRef;

/// Solution and residuals (`observed - fitted`, not weighted) as refined, and how many steps it took.
pub(super) struct Refined {
    pub solution: Vec<f64>,
    pub residuals: Vec<f64>,
    pub steps: usize,
}

/// A step that changes the scaled solution by less than this share is the last: the next would change its square.
const ENOUGH: f64 = 1e-12;
/// The same for each unknown by itself, which weights of very different size may leave far behind the whole.
const ENOUGH_EACH: f64 = 1e-10;

/// Solves by the factorisation, then refines until it no longer matters, at most `limit` steps.
pub(super) fn solve(factor: &Factor, rows: MatRef<'_, f64>, observed: &[f64], limit: usize) -> Refined {
    let weight = &factor.weight;
    let mut rest: Vec<f64> = observed.iter().zip(weight).map(|(y, w)| w * y).collect();
    let along = factor.onto_basis(&rest);
    factor.subtract_span(&along, &mut rest);
    let solution = factor.spread(along);
    let residuals = rest.iter().zip(weight).map(|(v, w)| v / w).collect();
    let mut best = Refined { solution, residuals, steps: 0 };
    let mut last_change = f64::INFINITY;
    while best.steps < limit {
        let Some((next, change)) = step(factor, rows, observed, &best) else { break };
        if change.is_nan() || change >= last_change {
            break;
        }
        let each = next.solution.iter().zip(&best.solution).all(|(x, y)| (x - y).abs() <= ENOUGH_EACH * x.abs());
        best = next;
        last_change = change / 4.0;
        if change <= ENOUGH && each {
            break;
        }
    }
    best
}

/// One correction, and its size relative to the scaled solution; `None` where numbers leave the range of a double.
fn step(factor: &Factor, rows: MatRef<'_, f64>, observed: &[f64], now: &Refined) -> Option<(Refined, f64)> {
    let weight = &factor.weight;
    // f = W (y - A x - v), accumulated as high + low.
    let (mut high, mut low) = (observed.to_vec(), vec![0.0; observed.len()]);
    for &j in &factor.basis {
        accumulate(&mut high, &mut low, -now.solution[j], column(rows, j)?);
    }
    accumulate(&mut high, &mut low, -1.0, &now.residuals);
    let mut f: Vec<f64> = high.iter().zip(&low).zip(weight).map(|((high, low), w)| w * (high + low)).collect();
    // g = -D^-1 A' W^2 v.
    let pulled: Vec<f64> = now.residuals.iter().zip(weight).map(|(v, w)| w * (w * v)).collect();
    let mut g = Vec::with_capacity(factor.rank());
    for &j in &factor.basis {
        g.push(-compensated_dot(column(rows, j)?, &pulled) / factor.scale[j]);
    }
    let mut along = factor.onto_basis(&f);
    let shift = factor.forward_substitute(g);
    along.iter_mut().zip(&shift).for_each(|(c, h)| *c -= h);
    factor.subtract_span(&along, &mut f);
    let correction = factor.spread(along);
    let solution: Vec<f64> = now.solution.iter().zip(&correction).map(|(x, dx)| x + dx).collect();
    let residuals: Vec<f64> = now.residuals.iter().zip(f.iter().zip(weight)).map(|(v, (f, w))| v + f / w).collect();
    if !solution.iter().chain(&residuals).all(|value| value.is_finite()) {
        return None;
    }
    let largest = |x: &[f64]| x.iter().zip(&factor.scale).fold(0.0_f64, |most, (x, d)| most.max((x * d).abs()));
    let size = largest(&solution);
    let change = if size > 0.0 { largest(&correction) / size } else { 0.0 };
    Some((Refined { solution, residuals, steps: now.steps + 1 }, change))
}

fn column(rows: MatRef<'_, f64>, j: usize) -> Option<&[f64]> {
    rows.col(j).try_as_col_major().map(|column| column.as_slice())
}
