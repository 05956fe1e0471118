//! Evidence where the variances of what scatters are estimated: a candidate is compared with the scatter in its own direction, and with the
//! degrees of freedom from which that is known.
//!
//! ```text
//! g = shares of the estimated variances in a candidate's direction,   nu = 2 / (g' S g),   o(j) = nu g_j' S g / 2
//! t^2 = s^2 (nu - n) / (nu - lost - s^2),     n = 1 + sum o(j),  lost = sum o(j) step_j^2 over the effects already in
//! ```
//!
//! The variances were estimated with the candidate's own effect among what scatters; what it takes off is taken off them. For a single variance
//! that is Student's t with the residuals' own sum of squares, in a balanced design the t of each stratum. Where the variances come from a model
//! with some effects in it, those count the other way.

use super::noise::Weighted;
use super::pool::Pool;
use crate::elements::Elements;
use faer::Mat;

/// What is left of a stratum is not taken for less than the noise of the readings in it, nor than this.
const LEAST: f64 = 1e-3;

/// Everything given that some candidates are in the model.
pub(super) struct Given {
    /// Score of each candidate; its square is the further drop of the sum of squares.
    pub score: Vec<f64>,
    /// Squared sine of each candidate with the set.
    pub left: Vec<f64>,
    pub rss: f64,
    pub dof: usize,
    pub(super) pure: Option<(f64, usize, Vec<f64>)>,
    /// The members, and what each takes off the sum of squares in this order.
    pub(super) steps: Vec<(usize, f64)>,
}

/// The estimated variances, as candidates feel them.
pub(super) struct Strata {
    /// Of each candidate.
    shares: Vec<Vec<f64>>,
    /// Share of the readings' own noise in each candidate's direction.
    noise: Vec<f64>,
    spread: Mat<f64>,
    /// Effects in the model from which the variances come.
    reference: Vec<(usize, f64)>,
}

impl Strata {
    /// `None` where every variance is stated.
    pub fn new(weighted: &Weighted, pool: &Pool) -> Option<Self> {
        let floor = weighted.floor.as_ref().filter(|own| own.spread().nrows() > 0)?;
        let q = weighted.estimate.factor.thin_q();
        let own = |j: usize| match pool.visible().get(j) {
            Some(visible) if *visible > 0.0 => floor.shares(&pool.direction(j, q)),
            _ => Vec::new(),
        };
        let shares: Vec<Vec<f64>> = (0..pool.len()).map(own).collect();
        let of_lines = |own: &Vec<f64>| own.iter().skip(floor.groups()).sum::<f64>();
        Some(Strata {
            noise: shares.iter().map(|own| (1.0 - of_lines(own)).clamp(LEAST, 1.0)).collect(),
            shares,
            spread: floor.spread().clone(),
            reference: Vec::new(),
        })
    }

    pub fn found_with(&mut self, steps: Vec<(usize, f64)>) {
        self.reference = steps;
    }

    /// `g_a' S g_b`.
    fn product(&self, a: usize, b: usize) -> f64 {
        let (Some(own), Some(other)) = (self.shares.get(a), self.shares.get(b)) else { return 0.0 };
        let mut sum = 0.0;
        for (k, x) in own.iter().enumerate() {
            for (l, y) in other.iter().enumerate() {
                sum += x * self.spread[(k, l)] * y;
            }
        }
        sum
    }

    /// Sum of squares and degrees of freedom of what scatters in a candidate's direction, given some effects; `None` where it is all stated.
    fn left(&self, given: &Given, index: usize) -> Option<(f64, f64)> {
        let square = self.product(index, index);
        if !(square > 1e-9) {
            return None;
        }
        let nu = 2.0 / square;
        let overlap = |j: usize| (nu * 0.5 * self.product(j, index)).clamp(0.0, 1.0);
        let (mut sum, mut dof) = (nu, nu);
        for (own, sign) in given.steps.iter().map(|s| (s, -1.0)).chain(self.reference.iter().map(|s| (s, 1.0))) {
            let part = sign * overlap(own.0);
            sum += part * own.1;
            dof += part;
        }
        Some((sum.max(self.least(index) * dof), dof))
    }

    fn least(&self, index: usize) -> f64 {
        self.noise.at(index)
    }

    /// Student's t and its degrees of freedom.
    pub fn t(&self, given: &Given, index: usize, score: f64) -> (f64, f64) {
        let Some((sum, dof)) = self.left(given, index) else { return (score, f64::INFINITY) };
        let dof = dof - 1.0;
        if dof < 1.0 {
            return (0.0, 0.0);
        }
        let rest = (sum - score * score).max(self.least(index) * dof);
        (score / (rest / dof).sqrt(), dof)
    }
}
