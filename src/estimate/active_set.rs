//! From a good guess of the active constraints to the last digit: Newton's method on the Lagrange conditions, and a check of every sign.
//!
//! ```text
//! v + sum l_i b_i + sum m_k T_k' (p_k + T_k v) = 0,    b_i v = limit_i,    |p_k + T_k v| = 1
//! ```
//!
//! With planes only the first step is exact (a projection on their intersection); on balls it converges quadratically. A constraint whose
//! multiplier comes out negative is let go, one that is violated is taken up, until none is left.
#![allow(
    clippy::indexing_slicing,
    reason = "active faces are numbers below `faces.len()` that `polish` chooses itself; multipliers have one entry for each"
)]

use super::cone_program::Face;
use crate::linear::{norm, normalise, project};
use faer::Mat;
use faer::linalg::solvers::{Solve, SolveLstsq};

/// A point that satisfies the Lagrange conditions.
pub(super) struct Polished {
    /// The point.
    pub v: Vec<f64>,
    /// Active faces with their multipliers, all positive.
    pub active: Vec<(usize, f64)>,
    /// `d v / d origin`: how the point follows the free estimate.
    pub follows: Mat<f64>,
}

/// What rounding may leave of a constraint or a multiplier.
const ROUNDING: f64 = 1e-13;
/// Most steps of Newton's method, and most exchanges of constraints.
const STEPS: usize = 50;

/// Polish; `None` if no active set can be confirmed.
pub(super) fn polish(faces: &[Face], guess: &[usize], start: &[f64]) -> Option<Polished> {
    let mut active: Vec<usize> = Vec::new();
    for &k in guess {
        if !depends(faces, &active, k, start) {
            active.push(k);
        }
    }
    let mut v = start.to_vec();
    for _ in 0..STEPS.max(4 * faces.len()) {
        let Some((next, multipliers, follows)) = lagrange(faces, &active, &v) else {
            // a constraint too many: let the last one go
            active.pop()?;
            continue;
        };
        let size = multipliers.iter().fold(0.0_f64, |most, m| most.max(m.abs()));
        let least = multipliers.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
        if let Some((at, _)) = least.filter(|(_, m)| **m < -ROUNDING * size) {
            active.remove(at);
            continue;
        }
        v = next;
        let outside = |k: &usize| {
            let room = match &faces[*k] {
                Face::Plane { limit, .. } => 1.0 + limit.abs(),
                Face::Ball { .. } => 1.0,
            };
            faces[*k].violation(&v) / room
        };
        let open = (0..faces.len()).filter(|k| !active.contains(k));
        match open.map(|k| (k, outside(&k))).filter(|(_, out)| *out > ROUNDING).max_by(|a, b| a.1.total_cmp(&b.1)) {
            None => return Some(Polished { v, active: active.into_iter().zip(multipliers).collect(), follows }),
            Some((k, _)) if depends(faces, &active, k, &v) => {
                // exchange it for the one with the smallest multiplier
                let smallest = (0..active.len()).min_by(|a, b| multipliers[*a].total_cmp(&multipliers[*b]))?;
                active[smallest] = k;
            }
            Some((k, _)) => active.push(k),
        }
    }
    None
}

/// Gradient of a face at `v`.
fn gradient(face: &Face, v: &[f64]) -> Vec<f64> {
    match face {
        Face::Plane { normal, .. } => normal.clone(),
        Face::Ball { along, .. } => {
            let point = face.point(v);
            (0..along.ncols()).map(|k| point.iter().enumerate().map(|(i, x)| along[(i, k)] * x).sum()).collect()
        }
    }
}

/// Is the gradient of face `k` in the span of the active ones?
fn depends(faces: &[Face], active: &[usize], k: usize, v: &[f64]) -> bool {
    let mut span: Vec<Vec<f64>> = Vec::new();
    for other in active.iter().chain([&k]) {
        let mut rest = gradient(&faces[*other], v);
        let whole = norm(&rest);
        project(&mut rest, &span);
        project(&mut rest, &span);
        let left = normalise(&mut rest);
        if !(left > 1e-9 * whole) {
            if *other == k {
                return true;
            }
            continue;
        }
        span.push(rest);
    }
    false
}

/// Solve the Lagrange conditions for an active set: the point, its multipliers, and how it follows the origin.
fn lagrange(faces: &[Face], active: &[usize], start: &[f64]) -> Option<(Vec<f64>, Vec<f64>, Mat<f64>)> {
    let n = start.len();
    let size = n + active.len();
    let mut v = start.to_vec();
    let mut multipliers = least_squares_multipliers(faces, active, &v);
    let mut best = f64::INFINITY;
    for step in 0..STEPS {
        let matrix = jacobian(faces, active, &v, &multipliers);
        let mut rest = vec![0.0; size];
        for (k, v) in v.iter().enumerate() {
            rest[k] = *v;
        }
        for (a, (&k, m)) in active.iter().zip(&multipliers).enumerate() {
            for (slot, g) in rest.iter_mut().zip(gradient(&faces[k], &v)) {
                *slot += m * g;
            }
            rest[n + a] = match &faces[k] {
                Face::Plane { .. } => faces[k].violation(&v),
                face => 0.5 * (face.point(&v).iter().map(|x| x * x).sum::<f64>() - 1.0),
            };
        }
        let lu = matrix.full_piv_lu();
        let change = lu.solve(Mat::from_fn(size, 1, |i, _| -rest[i]));
        let moved = (0..size).fold(0.0_f64, |most, i| most.max(change[(i, 0)].abs()));
        if !moved.is_finite() {
            return None;
        }
        v.iter_mut().enumerate().for_each(|(k, v)| *v += change[(k, 0)]);
        multipliers.iter_mut().enumerate().for_each(|(a, m)| *m += change[(n + a, 0)]);
        let large = v.iter().chain(&multipliers).fold(1.0_f64, |most, x| most.max(x.abs()));
        let settled = moved <= 4.0 * f64::EPSILON * large || (step > 4 && moved >= best && moved < 1e-10 * large);
        best = best.min(moved);
        if settled {
            let unit = Mat::from_fn(size, n, |i, j| if i == j { 1.0 } else { 0.0 });
            let follows = jacobian(faces, active, &v, &multipliers).full_piv_lu().solve(unit);
            let follows = follows.subrows(0, n).to_owned();
            return Some((v, multipliers, follows));
        }
    }
    None
}

/// Multipliers that come nearest to the Lagrange conditions at `v`.
fn least_squares_multipliers(faces: &[Face], active: &[usize], v: &[f64]) -> Vec<f64> {
    if active.is_empty() {
        return Vec::new();
    }
    let gradients: Vec<Vec<f64>> = active.iter().map(|k| gradient(&faces[*k], v)).collect();
    let a = Mat::from_fn(v.len(), active.len(), |i, k| gradients[k][i]);
    let b = Mat::from_fn(v.len(), 1, |i, _| -v[i]);
    if a.nrows() < a.ncols() {
        // gradients that `depends` let in are independent and so no more than unknowns; were there more, Newton starts from zeros
        return vec![0.0; active.len()];
    }
    let found = a.col_piv_qr().solve_lstsq(b);
    (0..active.len()).map(|k| if found[(k, 0)].is_finite() { found[(k, 0)] } else { 0.0 }).collect()
}

/// Derivative of the Lagrange conditions by the point and the multipliers.
fn jacobian(faces: &[Face], active: &[usize], v: &[f64], multipliers: &[f64]) -> Mat<f64> {
    let n = v.len();
    let mut matrix = Mat::identity(n + active.len(), n + active.len());
    for (a, (&k, m)) in active.iter().zip(multipliers).enumerate() {
        matrix[(n + a, n + a)] = 0.0;
        for (j, g) in gradient(&faces[k], v).into_iter().enumerate() {
            matrix[(j, n + a)] = g;
            matrix[(n + a, j)] = g;
        }
        if let Face::Ball { along, .. } = &faces[k] {
            for i in 0..n {
                for j in 0..n {
                    let curve: f64 = (0..along.nrows()).map(|l| along[(l, i)] * along[(l, j)]).sum();
                    matrix[(i, j)] += m * curve;
                }
            }
        }
    }
    matrix
}
