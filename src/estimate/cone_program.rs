//! The nearest point of a convex set, as clarabel takes it: `min |v|^2 / 2` subject to planes and balls.
//!
//! P. J. Goulart, Y. Chen, "Clarabel: an interior-point solver for conic programs with quadratic objectives" (2024). Its answer is good to
//! some nine digits and says which constraints are active; `active_set.rs` carries it to the last digit.
#![allow(
    clippy::indexing_slicing,
    reason = "`dual` and `slack` have one entry for each face, and owners are numbers of faces"
)]

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use faer::Mat;

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
    let matrix = csc(&rows, size);
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

/// Rows of a sparse matrix, as compressed columns.
fn csc(rows: &[(Vec<f64>, f64)], columns: usize) -> CscMatrix<f64> {
    let (mut start, mut index, mut value) = (vec![0], Vec::new(), Vec::new());
    for j in 0..columns {
        for (i, (row, _)) in rows.iter().enumerate() {
            if let Some(entry) = row.get(j).filter(|entry| **entry != 0.0) {
                index.push(i);
                value.push(*entry);
            }
        }
        start.push(index.len());
    }
    CscMatrix::new(rows.len(), columns, start, index, value)
}
