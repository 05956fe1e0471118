//! The L1 estimate: a linear programme through clarabel, then the readings that it passes through, solved exactly.
#![allow(
    clippy::indexing_slicing,
    reason = "`plain` is the adjustment of this very system, whose `check` has compared u with the rows: weights, residuals and moved rows are as many"
)]

use crate::estimate::{Estimate, System, solver_settings};
use crate::linear::{norm, normalise, project};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSolver, IPSolver, SupportedConeT};
use faer::Mat;
use faer::linalg::solvers::Solve;

/// `argmin sum |y - A x| / u` over the readings, priors as squares; the second says whether the programme was solved.
///
/// In `x = x^ + T v` (whitened about the plain estimate) with `-t <= W (y - A x) <= t`: `min sum t`.
pub(super) fn solve(system: &System, plain: &Estimate, readings: usize) -> (Vec<f64>, bool) {
    let directions = plain.factor.whitened_directions();
    let moved = &system.rows * &directions;
    let (m, rank) = (system.observed.len(), directions.ncols());
    let weight = |i: usize| 1.0 / system.u[i];
    let unit = {
        let sum: f64 = (0..m).map(|i| (plain.residuals[i] * weight(i)).abs()).sum();
        if sum > 0.0 { sum / m as f64 } else { return (plain.unknowns.solution.clone(), true) }
    };
    // columns: v (in `unit`s), then t of each reading
    let (mut start, mut index, mut value) = (vec![0], Vec::new(), Vec::new());
    for k in 0..rank {
        for i in 0..readings {
            let a = weight(i) * moved[(i, k)];
            if a != 0.0 {
                index.extend([2 * i, 2 * i + 1]);
                value.extend([-a, a]);
            }
        }
        start.push(index.len());
    }
    for i in 0..readings {
        index.extend([2 * i, 2 * i + 1]);
        value.extend([-1.0, -1.0]);
        start.push(index.len());
    }
    let constraints = CscMatrix::new(2 * readings, rank + readings, start, index, value);
    let bounds: Vec<f64> = (0..readings)
        .flat_map(|i| {
            let v = weight(i) * plain.residuals[i] / unit;
            [-v, v]
        })
        .collect();
    // priors: half their squares, from their own residuals
    let mut quadratic = Mat::<f64>::zeros(rank, rank);
    let mut linear = vec![0.0; rank + readings];
    for i in readings..m {
        for a in 0..rank {
            linear[a] -= weight(i).powi(2) * moved[(i, a)] * plain.residuals[i] / unit;
            for b in 0..rank {
                quadratic[(a, b)] += weight(i).powi(2) * moved[(i, a)] * moved[(i, b)];
            }
        }
    }
    linear.iter_mut().skip(rank).for_each(|c| *c = 1.0);
    let (mut start, mut index, mut value) = (vec![0], Vec::new(), Vec::new());
    for b in 0..rank + readings {
        for a in 0..=b.min(rank.saturating_sub(1)) {
            if b < rank && quadratic[(a, b)] != 0.0 {
                index.push(a);
                value.push(quadratic[(a, b)]);
            }
        }
        start.push(index.len());
    }
    let quadratic = CscMatrix::new(rank + readings, rank + readings, start, index, value);
    let settings = solver_settings(300);
    let cones = [SupportedConeT::NonnegativeConeT(2 * readings)];
    let Ok(mut solver) = DefaultSolver::new(&quadratic, &linear, &constraints, &bounds, &cones, settings) else {
        return (plain.unknowns.solution.clone(), false);
    };
    solver.solve();
    let v: Vec<f64> = solver.solution.x.iter().take(rank).map(|v| v * unit).collect();
    if v.len() < rank || v.iter().any(|v| !v.is_finite()) {
        return (plain.unknowns.solution.clone(), false);
    }
    let v = if readings == m { vertex(&moved, plain, &weight, &v) } else { v };
    let mut solution = plain.unknowns.solution.clone();
    for (k, v) in v.iter().enumerate() {
        solution.iter_mut().zip(directions.col_as_slice(k)).for_each(|(x, t)| *x += t * v);
    }
    (solution, true)
}

/// The vertex next to `v`: through the readings with the smallest residuals that are independent, if that is no worse.
fn vertex(moved: &Mat<f64>, plain: &Estimate, weight: &dyn Fn(usize) -> f64, v: &[f64]) -> Vec<f64> {
    let rank = v.len();
    let residual =
        |i: usize, v: &[f64]| plain.residuals[i] - v.iter().enumerate().map(|(k, v)| moved[(i, k)] * v).sum::<f64>();
    let total = |v: &[f64]| (0..moved.nrows()).map(|i| (weight(i) * residual(i, v)).abs()).sum::<f64>();
    let mut order: Vec<usize> = (0..moved.nrows()).collect();
    order.sort_by(|a, b| (weight(*a) * residual(*a, v)).abs().total_cmp(&(weight(*b) * residual(*b, v)).abs()));
    let mut span: Vec<Vec<f64>> = Vec::new();
    let mut chosen = Vec::new();
    for i in order {
        let mut rest: Vec<f64> = (0..rank).map(|k| weight(i) * moved[(i, k)]).collect();
        let whole = norm(&rest);
        project(&mut rest, &span);
        if normalise(&mut rest) > 1e-7 * whole {
            span.push(rest);
            chosen.push(i);
        }
        if chosen.len() == rank {
            break;
        }
    }
    if chosen.len() < rank {
        return v.to_vec();
    }
    let a = Mat::from_fn(rank, rank, |i, k| weight(chosen[i]) * moved[(chosen[i], k)]);
    let b = Mat::from_fn(rank, 1, |i, _| weight(chosen[i]) * plain.residuals[chosen[i]]);
    let found = a.full_piv_lu().solve(b);
    let found: Vec<f64> = (0..rank).map(|k| found[(k, 0)]).collect();
    if found.iter().all(|x| x.is_finite()) && total(&found) <= total(v) * (1.0 + 1e-9) { found } else { v.to_vec() }
}
