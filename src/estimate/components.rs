//! Variance components: readings that share an offset, and groups whose scatter is unknown, in one generalised least squares.
//!
//! ```text
//! y = A x + e + offsets,   V = sum theta_h V_h,   V_h = diag(u^2) over a group's rows, or 1 1' over rows that share an offset
//! ```
//!
//! The rows are whitened by the Cholesky factors of V's blocks and adjusted by QR. Components come from Helmert's equations
//! `sum_h tr(P V_g P V_h) theta_h = y' P V_g P y`, iterated: at the fixed point REML (K.-R. Koch 1999, 3.6; H. D. Patterson, R. Thompson
//! 1971). The variance of an offset may come out negative as long as V stays positive definite: cutting it at zero would make the intervals
//! of what offsets dominate too long and those of the rest too short. The covariance of the solution carries the small-sample correction of M. G. Kenward and
//! J. H. Roger, "Small sample inference for fixed effects from restricted maximum likelihood", Biometrics 53 (1997).

use super::helmert::Normal;
use super::whitening::{Whitening, blocks};
use super::{Elimination, Estimate, Group, Settings, System, adjust, adjust_on};
use crate::error::Result;
use faer::Mat;

/// One variance component.
#[derive(Debug, Clone, PartialEq)]
pub struct Component {
    /// Rows, each with the standard deviation that a component of 1 gives it.
    pub rows: Vec<(usize, f64)>,
    /// The shared offset that each of `rows` has a part in; empty where errors are independent.
    pub offset: Vec<usize>,
    /// The variance if it is known.
    pub known: Option<f64>,
}

/// A system adjusted with its variance components.
#[derive(Debug, Clone)]
pub struct Components {
    /// Variance of each component.
    pub variance: Vec<f64>,
    /// Covariance of the estimated variances (rows and columns of all components; zero for known ones).
    pub spread: Mat<f64>,
    /// What the small-sample correction adds to the covariance of the unknowns, `n x n`.
    pub correction: Mat<f64>,
    /// The adjustment of the whitened rows: residuals, leverages and redundancies are those of whitened rows.
    pub estimate: Estimate,
    /// `d x / d y`, `n x m`, for the readings as they are.
    pub sensitivities: Mat<f64>,
    /// For each row of the system, a unit error of it in the whitened rows (row and value).
    pub indicators: Vec<Vec<(usize, f64)>>,
    /// Steps that the components took; whether they settled.
    pub iterations: usize,
    /// Did they settle?
    pub converged: bool,
}

/// Steps to the components at most.
const STEPS: usize = 200;
/// Steps that keep every variance positive, before those that converge quickly.
const SAFE_STEPS: usize = 4;
/// Relative change of the variances that no longer matters.
const SETTLED: f64 = 1e-11;

/// Adjust `system` (its `u` and `group` are not used) with the components' covariance, estimating those that are not known.
///
/// Every row must be in an independent component, so that V can be inverted. Errors: those of [`adjust`].
pub fn adjust_components(
    system: &System,
    components: &[Component],
    elimination: Option<&Elimination>,
    settings: &Settings,
) -> Result<Components> {
    let m = system.observed.len();
    let start = start(system, components, elimination, settings)?;
    let mut variance: Vec<f64> = components.iter().map(|c| c.known.unwrap_or(start)).collect();
    let estimated: Vec<usize> = (0..components.len()).filter(|k| components[*k].known.is_none()).collect();
    let blocks = blocks(m, components);
    let (mut iterations, mut converged) = (0, estimated.is_empty());
    loop {
        let whitening = Whitening::new(&blocks, components, &variance);
        let whitened = whitening.system(system);
        let estimate = solve(&whitened, elimination, settings)?;
        let normal = Normal::new(&whitening, components, &estimate);
        if converged || iterations == STEPS {
            let spread = normal.spread(&estimated);
            let correction = normal.correction(&estimate, &spread);
            let mut sensitivities = estimate.factor.sensitivities();
            whitening.transform_columns(&mut sensitivities);
            return Ok(Components {
                variance,
                spread,
                correction,
                estimate,
                sensitivities,
                indicators: whitening.indicators(),
                iterations,
                converged,
            });
        }
        // the first steps stay positive; then Fisher's, shortened until V is positive definite
        let mut next = normal.safe_step(&estimated, &variance);
        if iterations >= SAFE_STEPS {
            let full = normal.step(&estimated, &variance);
            let mut share = 1.0;
            while share > 1e-3 {
                let trial: Vec<f64> = variance.iter().zip(&full).map(|(v, f)| v + share * (f - v)).collect();
                let independent = |k: &usize| !components[*k].offset.is_empty() || trial[*k] > 1e-3 * variance[*k];
                if estimated.iter().all(independent) && Whitening::new(&blocks, components, &trial).is_definite() {
                    next = trial;
                    break;
                }
                share *= 0.5;
            }
        }
        let size = next.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        converged = next.iter().zip(&variance).all(|(a, b)| (a - b).abs() <= SETTLED * (size * 1e-3 + b.abs()));
        variance = next;
        iterations += 1;
    }
}

fn solve(whitened: &System, elimination: Option<&Elimination>, settings: &Settings) -> Result<Estimate> {
    match elimination {
        Some(elimination) => adjust_on(whitened, elimination, settings),
        None => adjust(whitened, settings),
    }
}

/// A variance to begin with: that of the ordinary residuals.
fn start(
    system: &System,
    components: &[Component],
    elimination: Option<&Elimination>,
    settings: &Settings,
) -> Result<f64> {
    if components.iter().all(|c| c.known.is_some()) {
        return Ok(1.0);
    }
    let mut plain = System { group: vec![Group::Estimated(0); system.observed.len()], ..system.clone() };
    for component in components.iter().filter(|c| c.offset.is_empty()) {
        for (row, u) in &component.rows {
            plain.u[*row] = *u * component.known.unwrap_or(1.0).sqrt();
        }
    }
    let sd = solve(&plain, elimination, settings)?.residual_sd().unwrap_or(1.0);
    Ok(if sd > 0.0 { 0.5 * sd * sd } else { 1.0 })
}
