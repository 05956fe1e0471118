//! Residuals beside inputs that are known only to their uncertainty, where these add a few directions to a factorisation that is shared.
//!
//! ```text
//! cov r = s I + C C'      C: what inputs of unit variance leave in the residuals,    C'C = E diag(g) E',   d_j = C e_j / sqrt g_j,   b_j = d_j' r
//! s r' (s I + C C')^-1 r = r'r - sum_j b_j^2 g_j/(s + g_j)                     the sum of squares of the system of `System::with_inputs`
//! -2 ln L(s) = (dof - k) ln s + (r'r - sum b_j^2)/s + sum_j [ln(s + g_j) + b_j^2/(s + g_j)]          the restricted likelihood of the scale
//! ```

use super::groups::NO_REDUNDANCY;
use crate::linear::{dot, norm};
use faer::{Mat, Side};

/// What is left of a column by a projection is rounding below this share of it: a few epsilons.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// What known inputs leave in weighted residuals.
#[derive(Debug, Clone)]
pub(crate) struct Beside {
    /// `g_j` and `d_j`.
    parts: Vec<(f64, Vec<f64>)>,
}

impl Beside {
    /// `columns` are the inputs' weighted columns, each of unit variance, with the unknowns' columns projected out; `before` is the largest norm of one
    /// before that.
    pub fn new(columns: &Mat<f64>, before: f64) -> Option<Self> {
        let gram = columns.transpose() * columns;
        let eigen = gram.self_adjoint_eigen(Side::Lower).ok()?;
        let part = |j: usize| {
            let along = columns * eigen.U().col(j);
            let direction: Vec<f64> = along.iter().copied().collect();
            let size = norm(&direction);
            (size > ROUNDING * before).then(|| (size * size, direction.iter().map(|d| d / size).collect()))
        };
        Some(Beside { parts: (0..columns.ncols()).filter_map(part).collect() })
    }

    /// How many directions of the residuals they have.
    pub fn count(&self) -> usize {
        self.parts.len()
    }

    /// `b_j` of weighted residuals.
    pub fn along(&self, residuals: &[f64]) -> Vec<f64> {
        self.parts.iter().map(|(_, direction)| dot(direction, residuals)).collect()
    }

    /// The share `g_j/(s + g_j)` of each direction.
    fn shares(&self, scale: f64) -> impl Iterator<Item = (f64, &Vec<f64>)> {
        self.parts.iter().map(move |(gain, direction)| (gain / (scale + gain), direction))
    }

    /// `s r' (s I + C C')^-1 r`, where `squares` is `r'r`.
    pub fn squares(&self, squares: f64, along: &[f64], scale: f64) -> f64 {
        squares - self.shares(scale).zip(along).map(|((share, _), b)| b * b * share).sum::<f64>()
    }

    /// Redundancy of the rows: degrees of freedom less what the inputs' directions have of them; never zero, so that noise of which nothing is left counts for
    /// nothing in effective degrees of freedom.
    pub fn redundancy(&self, dof: usize, scale: f64) -> f64 {
        (dof as f64 - self.shares(scale).map(|(share, _)| share).sum::<f64>()).max(NO_REDUNDANCY)
    }

    /// The square `s` of the scale at the top of the restricted likelihood, zero where the inputs explain all; `None` without degrees of freedom.
    pub fn scale(&self, squares: f64, along: &[f64], dof: usize) -> Option<f64> {
        let free = dof.checked_sub(self.count()).filter(|_| dof > 0)? as f64;
        let rest = if free > 0.0 { (squares - along.iter().map(|b| b * b).sum::<f64>()).max(0.0) } else { 0.0 };
        let slope = |s: f64| {
            let parts = self.parts.iter().zip(along).map(|((g, _), b)| (1.0 - b * b / (s + g)) / (s + g));
            (free - rest / s) / s + parts.sum::<f64>()
        };
        // beyond the largest of what each part alone would have it be, and below the least of these, the slope has one sign
        let each = || self.parts.iter().zip(along).map(|((g, _), b)| b * b - g);
        let mut high = each().fold(if free > 0.0 { rest / free } else { 0.0 }, f64::max);
        let least = each().fold(if free > 0.0 { rest / free } else { high }, f64::min);
        // a scale of which nothing is left beside rounding is zero
        let mut low = least.max(f64::EPSILON * f64::EPSILON * high);
        if !(low > 0.0 && high.is_finite()) {
            return Some(0.0);
        }
        while high > low * (1.0 + 4.0 * f64::EPSILON) {
            let middle = (low * high).sqrt();
            if !(middle > low && middle < high) {
                break;
            }
            if slope(middle) < 0.0 { low = middle } else { high = middle }
        }
        Some(high)
    }

    /// The inputs, each over its uncertainty, as the residuals estimate them, and weighted residuals less these.
    pub fn left(&self, residuals: &mut [f64], along: &[f64], scale: f64) -> Vec<f64> {
        let mut found = Vec::with_capacity(self.count());
        for ((gain, direction), b) in self.parts.iter().zip(along) {
            found.push(b * gain.sqrt() / (scale + gain));
            let share = b * gain / (scale + gain);
            residuals.iter_mut().zip(direction).for_each(|(v, d)| *v -= share * d);
        }
        found
    }

    /// What the directions take of the redundancy of a row.
    pub fn taken(&self, row: usize, scale: f64) -> f64 {
        // a row of the columns
        self.shares(scale).map(|(share, direction)| share * direction.get(row).map_or(0.0, |d| d * d)).sum()
    }
}
