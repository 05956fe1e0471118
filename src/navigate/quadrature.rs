//! Increments of a smooth signal over many equal steps, exact to rounding, from a few samples of it.
//!
//! Over one block the signal is its Chebyshev interpolant on `NODES` points, and every step's integral of that
//! interpolant is one fixed row of weights: `increments = weights * samples`. A block is kept so short (a tenth of the
//! motion's shortest period) that the interpolation error is below rounding: an analytic signal of angular frequency
//! `w` leaves `(w T/2)^16 / (2^15 16!)` of its amplitude, 1e-26 at `w T/2 = 0.3`.
#![allow(
    clippy::indexing_slicing,
    reason = "polynomials have `NODES + 1` values and edges `MAX_STEPS + 1`; `steps` is clamped to `MAX_STEPS`"
)]

use std::f64::consts::PI;

/// Samples of a block.
pub(crate) const NODES: usize = 16;
/// The most steps that a block may have.
pub(crate) const MAX_STEPS: usize = 64;

/// Weights that turn samples at the block's nodes into integrals over its steps.
#[derive(Debug, Clone)]
pub struct Quadrature {
    /// Steps of the block, at most `MAX_STEPS`.
    pub steps: usize,
    /// Places of the samples, as a fraction of the block from 0 to 1.
    pub nodes: [f64; NODES],
    /// `weights[j][i]`: what sample `j` adds to the integral over step `i`, in units of the block's duration.
    pub weights: Box<[[f64; MAX_STEPS]; NODES]>,
    /// What sample `j` adds to the integral over the whole block, in units of the block's duration.
    pub whole: [f64; NODES],
    /// `running[k][j]`: what sample `j` adds to the integral from the start of the block to node `k`.
    pub running: [[f64; NODES]; NODES],
}

impl Quadrature {
    /// Weights for a block of so many equal steps (held between 1 and `MAX_STEPS`).
    pub fn new(steps: usize) -> Self {
        let steps = steps.clamp(1, MAX_STEPS);
        // Chebyshev points of the first kind on [-1, 1], in rising order.
        let points: [f64; NODES] = std::array::from_fn(|j| -((2 * j + 1) as f64 * PI / (2 * NODES) as f64).cos());
        let of_points = points.map(chebyshev);
        let edges: [Polynomials; MAX_STEPS + 1] =
            std::array::from_fn(|i| chebyshev(if i > steps { 1.0 } else { -1.0 + 2.0 * i as f64 / steps as f64 }));
        let (first, last) = (chebyshev(-1.0), chebyshev(1.0));
        let mut weights = Box::new([[0.0; MAX_STEPS]; NODES]);
        let mut running = [[0.0; NODES]; NODES];
        let mut whole = [0.0; NODES];
        for (j, point) in of_points.iter().enumerate() {
            let start = cardinal_antiderivative(point, &first);
            let at_edges = edges.map(|edge| cardinal_antiderivative(point, &edge));
            for (i, weight) in weights[j].iter_mut().take(steps).enumerate() {
                *weight = 0.5 * (at_edges[i + 1] - at_edges[i]);
            }
            for (row, end) in running.iter_mut().zip(&of_points) {
                row[j] = 0.5 * (cardinal_antiderivative(point, end) - start);
            }
            whole[j] = 0.5 * (cardinal_antiderivative(point, &last) - start);
        }
        Quadrature { steps, nodes: points.map(|x| 0.5 * (1.0 + x)), weights, whole, running }
    }
}

/// A place from -1 to 1, and `T_0` to `T_NODES` there.
type Polynomials = (f64, [f64; NODES + 1]);

fn chebyshev(x: f64) -> Polynomials {
    let angle = x.clamp(-1.0, 1.0).acos();
    (x, std::array::from_fn(|k| (k as f64 * angle).cos()))
}

/// Antiderivative at `x` of the cardinal polynomial of the Chebyshev point `point`:
/// `l(x) = (1/n) [1 + 2 sum_k T_k(point) T_k(x)]`, and `2 int T_k = T_{k+1}/(k+1) - T_{k-1}/(k-1)`.
fn cardinal_antiderivative((_, of_point): &Polynomials, (x, of_x): &Polynomials) -> f64 {
    let mut sum = x + of_point[1] * x * x;
    for k in 2..NODES {
        let integral = of_x[k + 1] / (k + 1) as f64 - of_x[k - 1] / (k - 1) as f64;
        sum += of_point[k] * integral;
    }
    sum / NODES as f64
}
