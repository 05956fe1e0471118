//! The nearest point of a convex set, as clarabel takes it: `min |v|^2 / 2` subject to planes and balls.
//!
//! P. J. Goulart, Y. Chen, "Clarabel: an interior-point solver for conic programs with quadratic objectives" (2024). Its answer is good to
//! some nine digits and says which constraints are active; `polish` carries it to the last digit.
#![allow(
    clippy::indexing_slicing,
    reason = "`dual` and `slack` have one entry for each face, owners are numbers of faces; active faces are numbers below `faces.len()` that `polish` chooses itself, with a multiplier each"
)]

use crate::linear::{norm, normalise, project};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use faer::Mat;
use faer::linalg::solvers::{Solve, SolveLstsq};

/// One side of a constraint in the whitened space of `v`.
#[derive(Debug, Clone)]
pub(super) enum Face {
    /// `normal . v <= limit`, the normal of unit length.
    Plane { normal: Vec<f64>, limit: f64 },
    /// `|at + along v| <= 1`.
    Ball { along: Mat<f64>, at: Vec<f64> },
}

impl Face {
    /// How far `v` is outside; negative inside.
    pub fn violation(&self, v: &[f64]) -> f64 {
        match self {
            Face::Plane { normal, limit } => normal.iter().zip(v).map(|(b, v)| b * v).sum::<f64>() - limit,
            Face::Ball { .. } => self.point(v).iter().map(|x| x * x).sum::<f64>().sqrt() - 1.0,
        }
    }

    /// `at + along v` of a ball; empty for a plane.
    pub fn point(&self, v: &[f64]) -> Vec<f64> {
        match self {
            Face::Plane { .. } => Vec::new(),
            Face::Ball { along, at } => (0..at.len())
                .map(|i| at[i] + v.iter().enumerate().take(along.ncols()).map(|(k, v)| along[(i, k)] * v).sum::<f64>())
                .collect(),
        }
    }

    /// Rows in clarabel's order `row . v + s = value`, `s` in the cone.
    fn rows(&self) -> Vec<(Vec<f64>, f64)> {
        match self {
            Face::Plane { normal, limit } => vec![(normal.clone(), *limit)],
            Face::Ball { along, at } => {
                let mut rows = vec![(vec![0.0; along.ncols()], 1.0)];
                for (i, at) in at.iter().enumerate() {
                    rows.push(((0..along.ncols()).map(|k| -along[(i, k)]).collect(), *at));
                }
                rows
            }
        }
    }
}

/// What clarabel found.
pub(super) enum Answer {
    /// The nearest point, and which faces hold it there.
    Nearest { v: Vec<f64>, active: Vec<usize> },
    /// No point satisfies all; these faces carry the certificate.
    Infeasible(Vec<usize>),
    /// Neither a point nor a certificate was found.
    Unsolved,
}

/// How clarabel is asked wherever this crate asks it: silently, on one thread, with nothing presolved, and with a gap near its last digits.
pub(crate) fn solver_settings(iterations: u32) -> DefaultSettings<f64> {
    DefaultSettings {
        verbose: false,
        max_iter: iterations,
        tol_gap_abs: 1e-11,
        tol_gap_rel: 1e-11,
        tol_feas: 1e-11,
        presolve_enable: false,
        max_threads: 1,
        ..DefaultSettings::default()
    }
}

/// Solve for the point of the faces' intersection that is nearest to the origin of `size` coordinates.
pub(super) fn nearest(size: usize, faces: &[Face]) -> Answer {
    let mut cones = Vec::new();
    let mut owner = Vec::new();
    let mut rows = Vec::new();
    for (k, face) in faces.iter().enumerate() {
        let own = face.rows();
        cones.push(match face {
            Face::Plane { .. } => SupportedConeT::NonnegativeConeT(1),
            Face::Ball { .. } => SupportedConeT::SecondOrderConeT(own.len()),
        });
        owner.extend(std::iter::repeat_n(k, own.len()));
        rows.extend(own);
    }
    let quadratic = CscMatrix::identity(size);
    let column = |j: usize| rows.iter().enumerate().map(move |(i, (row, _))| (i, row[j]));
    let matrix = csc(rows.len(), (0..size).map(column));
    let values: Vec<f64> = rows.iter().map(|(_, value)| *value).collect();
    let settings = solver_settings(200);
    let linear = vec![0.0; size];
    let Ok(mut solver) = DefaultSolver::new(&quadratic, &linear, &matrix, &values, &cones, settings) else {
        return Answer::Unsolved;
    };
    solver.solve();
    let solution = &solver.solution;
    let mut dual = vec![0.0_f64; faces.len()];
    let mut slack = vec![f64::INFINITY; faces.len()];
    for ((k, z), s) in owner.iter().zip(&solution.z).zip(&solution.s) {
        if dual[*k] == 0.0 && slack[*k].is_infinite() {
            slack[*k] = *s;
        }
        dual[*k] = dual[*k].max(z.abs());
    }
    match solution.status {
        SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => {
            let largest = dual.iter().fold(0.0_f64, |most, z| most.max(*z));
            Answer::Infeasible((0..faces.len()).filter(|k| dual[*k] > 1e-6 * largest).collect())
        }
        _ if solution.x.iter().all(|x| x.is_finite()) && !matches!(solution.status, SolverStatus::Unsolved) => {
            let v = solution.x.clone();
            // at the solution of a strictly complementary problem one of the two vanishes
            let tight = |k: &usize| match &faces[*k] {
                Face::Plane { .. } => dual[*k] > slack[*k],
                face => dual[*k] > -face.violation(&v),
            };
            Answer::Nearest { active: (0..faces.len()).filter(tight).collect(), v }
        }
        _ => Answer::Unsolved,
    }
}

/// A sparse matrix of so many rows from its columns: row and element, in the order of the rows.
pub(crate) fn csc<C: IntoIterator<Item = (usize, f64)>>(
    rows: usize,
    columns: impl Iterator<Item = C>,
) -> CscMatrix<f64> {
    let (mut start, mut index, mut value) = (vec![0], Vec::new(), Vec::new());
    for column in columns {
        let (own, elements): (Vec<usize>, Vec<f64>) = column.into_iter().filter(|(_, own)| *own != 0.0).unzip();
        index.extend(own);
        value.extend(elements);
        start.push(index.len());
    }
    CscMatrix::new(rows, start.len() - 1, start, index, value)
}

// From a good guess of the active constraints to the last digit: Newton's method on the Lagrange conditions, and a check of every sign.
//
//     v + sum l_i b_i + sum m_k T_k' (p_k + T_k v) = 0,    b_i v = limit_i,    |p_k + T_k v| = 1
//
// With planes only the first step is exact (a projection on their intersection); on balls it converges quadratically. A constraint whose
// multiplier comes out negative is let go, one that is violated is taken up, until none is left.

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
