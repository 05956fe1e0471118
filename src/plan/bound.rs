//! The approximate design: weights instead of whole repeats. No exact design can be better, so it says how near the optimum an exact one is.
//!
//! ```text
//! maximise log det M(w)  or minimise tr(W M(w)^-1),   M(w) = M0 + N sum w_j Xj'Xj,   w >= 0, sum w = 1
//! ```
//!
//! Multiplicative weights (S. D. Silvey, D. M. Titterington, B. Torsney, Comm. Statist. A 7 (1978) 1379). The bound that is returned is not
//! the value that the iteration has reached but the tangent's: both objectives are convex in `w`, so it holds however early one stops.

use super::blocks::{Blocks, dot, invert};
use super::exchange::Objective;

/// What weights instead of repeats could reach.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Bound {
    /// No exact design has a smaller value of the objective.
    pub value: f64,
    /// Weight of each candidate, summing to 1.
    pub weights: Vec<f64>,
    /// Iterations that were made.
    pub iterations: usize,
}

const ITERATIONS: usize = 3000;
/// Stop when the bound is this near the value reached (relative, for one unknown).
const NEAR: f64 = 1e-5;

/// Bound on designs of `choose` candidates; `None` where even all candidates together leave a defect.
pub(super) fn bound(blocks: &Blocks, base: &[f64], objective: &Objective, choose: usize) -> Option<Bound> {
    let (n, count) = (blocks.unknowns(), blocks.count());
    let total = choose as f64;
    let mut weights = vec![1.0 / count as f64; count];
    let mut best: Option<Bound> = None;
    let (mut gain, mut sums, mut work) = (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
    for iteration in 1..=ITERATIONS {
        let (inverse, log_det) = invert(&weighted(blocks, base, total, &weights), n)?;
        let (weight_matrix, value) = match objective {
            Objective::Trace(w) => (sandwich(&inverse, w, n), dot(w, &inverse)),
            Objective::Determinant | Objective::Largest => (inverse.clone(), -log_det),
        };
        gain.fill(0.0);
        for r in 0..blocks.rows() {
            blocks.quadratic(r, r, &weight_matrix, &mut sums, &mut work);
            gain.iter_mut().zip(&sums).for_each(|(g, d)| *g += d);
        }
        let most = gain.iter().copied().fold(0.0, f64::max);
        let mean = dot(&gain, &weights);
        let lower = match objective {
            // tr(W M^-1)^2 <= tr(W M*^-1) tr(M* M^-1 W M^-1) by Cauchy and Schwarz, for every M*
            Objective::Trace(_) => value * value / (value + total * (most - mean)),
            _ => value - total * (most - mean),
        };
        if best.as_ref().is_none_or(|b| lower > b.value) {
            best = Some(Bound { value: lower, weights: weights.clone(), iterations: iteration });
        }
        let near = match objective {
            Objective::Trace(_) => NEAR * value.abs(),
            _ => NEAR * n as f64,
        };
        if best.as_ref().is_some_and(|b| value - b.value <= near) || !(mean > 0.0) {
            break;
        }
        let power = if matches!(objective, Objective::Trace(_)) { 0.5 } else { 1.0 };
        weights.iter_mut().zip(&gain).for_each(|(w, g)| *w *= (g / mean).powf(power));
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|w| *w /= sum);
    }
    best
}

/// `M(w)`.
fn weighted(blocks: &Blocks, base: &[f64], total: f64, weights: &[f64]) -> Vec<f64> {
    let n = blocks.unknowns();
    let mut m = base.to_vec();
    for r in 0..blocks.rows() {
        for a in 0..n {
            let scaled: Vec<f64> = blocks.column(r, a).iter().zip(weights).map(|(x, w)| total * x * w).collect();
            for b in 0..=a {
                let sum = dot(&scaled, blocks.column(r, b));
                m[a * n + b] += sum;
                if a != b {
                    m[b * n + a] += sum;
                }
            }
        }
    }
    m
}

/// `A W A` for symmetric `A` and `W`.
fn sandwich(a: &[f64], w: &[f64], n: usize) -> Vec<f64> {
    let product = |p: &[f64], q: &[f64]| {
        let mut out = vec![0.0; n * n];
        for i in 0..n {
            for k in 0..n {
                let factor = p[i * n + k];
                for j in 0..n {
                    out[i * n + j] += factor * q[k * n + j];
                }
            }
        }
        out
    };
    product(&product(a, w), a)
}

/// `M(w)^-1` of an approximate design.
pub(super) fn inverse(blocks: &Blocks, base: &[f64], choose: usize, bound: &Bound) -> Option<Vec<f64>> {
    invert(&weighted(blocks, base, choose as f64, &bound.weights), blocks.unknowns()).map(|(inverse, _)| inverse)
}
