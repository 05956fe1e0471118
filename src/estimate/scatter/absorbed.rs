//! Variances that no residual shows, though unknowns follow them.
//!
//! ```text
//! residuals tell theta by P V(theta) P; an unknown c'x has the variance G' V(theta) G in its direction
//! P (V_c - sum_h a_h V_h) P = 0 :  the residuals do not tell theta_c from the others, a from  sum_h S_gh a_h = S_gc
//! G' (V_c - sum_h a_h V_h) G = 0 : nor do the unknowns, and the sum is enough; where it is not zero, their variance is not known
//! ```
//!
//! C. R. Rao, J. Kleffe, Estimation of Variance Components and Applications (1988), chapter 4: a linear function of the variances can be estimated
//! where it is one of those that the residuals have.
#![allow(
    clippy::indexing_slicing,
    reason = "`kept` holds components of the problem, for each of which the inference has a matrix, and `s` a row and a column"
)]

use super::problem::{Problem, SEPARATED};
use crate::error::Result;
use crate::linear::form;
use faer::{Mat, Scale};

/// What is not known of the covariance of the unknowns, for want of one variance.
#[derive(Debug, Clone)]
pub struct Absorbed {
    /// Its derivative by that variance, at a deviation as large as the noise of the rows that feel it.
    unknown: Mat<f64>,
    /// The covariance itself there.
    whole: Mat<f64>,
}

impl Absorbed {
    /// Does the variance of `along . x` follow it?
    pub(crate) fn touches(&self, along: &[f64]) -> bool {
        form(&self.unknown, along).abs() > SEPARATED.sqrt() * form(&self.whole, along)
    }

    /// Of the first `n` unknowns.
    pub(super) fn of_first(&self, n: usize) -> Self {
        let part = |whole: &Mat<f64>| whole.submatrix(0, 0, n, n).to_owned();
        Absorbed { unknown: part(&self.unknown), whole: part(&self.whole) }
    }

    /// Does the variance of this unknown?
    pub(crate) fn touches_unknown(&self, k: usize) -> bool {
        self.unknown[(k, k)].abs() > SEPARATED.sqrt() * self.whole[(k, k)]
    }
}

impl Problem<'_> {
    /// For each line, what is not known for want of its variance: of those that are not among the components `kept`.
    pub(super) fn absorbed(&self, kept: &[usize]) -> Result<Vec<Option<Absorbed>>> {
        let missing = |own: &Option<usize>| own.filter(|c| !kept.contains(c));
        let none = vec![None; self.lines.len()];
        if self.component.iter().all(|own| missing(own).is_none()) {
            return Ok(none);
        }
        let Some(point) = self.at(&self.start()?)? else { return Ok(none) };
        let inference = self.inference(&point);
        let directions = point.estimate.factor.whitened_directions();
        let whole = &directions * directions.transpose();
        // 2 S^-1
        let twice = super::restricted::spread(&inference.s, kept);
        let one = |own: &Option<usize>| {
            let c = missing(own)?;
            let mut middle = inference.gamma[c].clone();
            for h in kept {
                let share = 0.5 * kept.iter().map(|g| twice[(*h, *g)] * inference.s[(*g, c)]).sum::<f64>();
                middle -= &inference.gamma[*h] * Scale(share);
            }
            let found = Absorbed { unknown: &directions * middle * directions.transpose(), whole: whole.clone() };
            (0..whole.nrows()).any(|k| found.touches_unknown(k)).then_some(found)
        };
        Ok(self.component.iter().map(one).collect())
    }
}
