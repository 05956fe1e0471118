//! What estimating several scales costs: their covariance, and what it adds to that of the unknowns.
#![allow(
    clippy::indexing_slicing,
    reason = "groups are numbered below `count`, and each has its members and its gram matrix"
)]

use super::groups::{Information, count, gram};
use super::{Estimate, Group, System, scatter};
use faer::Mat;

/// What estimated scales cost beyond the covariance that takes them as known.
#[derive(Debug, Clone)]
pub struct ScaleUncertainty {
    /// Covariance of the groups' variances, each relative to its estimate.
    pub relative: Mat<f64>,
    /// Addition to the covariance of the unknowns, `n x n` (M. G. Kenward, J. H. Roger, Biometrics 53 (1997), 983-997).
    pub correction: Mat<f64>,
}

impl Estimate {
    /// How uncertain the scales of several groups are, and what that adds to the covariance of the unknowns; `None` where no scale was
    /// estimated beside others (one group alone leaves the weights as they are, and Student's distribution says the rest).
    ///
    /// With `G_g = Q_g' Q_g` and `W = 2 S^-1`, the covariance of the relative variances, the addition is
    /// `2 T (sum_g W_gg G_g - sum_gh W_gh G_g G_h) T'`, `T T'` being the covariance with known scales: Kenward and Roger's formula for
    /// `V = diag(s_g^2 u^2)` (`scatter/cost.rs`).
    pub fn scale_uncertainty(&self, system: &System) -> Option<ScaleUncertainty> {
        let count = count(&system.group);
        if self.group_iterations == 0 || count == 0 {
            return None;
        }
        let q = &self.factor.q;
        let index = |group: &Group| if let Group::Estimated(g) = group { *g } else { count };
        let members = |g: usize| -> Vec<usize> {
            (0..system.group.len().min(q.nrows())).filter(|i| index(&system.group[*i]) == g).collect()
        };
        let members: Vec<Vec<usize>> = (0..=count).map(members).collect();
        let block = |rows: &Vec<usize>| gram(Mat::from_fn(rows.len(), q.ncols(), |i, k| q[(rows[i], k)]).as_ref());
        let size: Vec<usize> = members.iter().map(Vec::len).collect();
        let information = Information::new(members.iter().map(block).collect(), &size);
        let determined = information.determined();
        let mut s = information.s.clone();
        s.resize_with(count, count, |_, _| 0.0);
        let relative = scatter::spread(&s, &determined);
        let directions = self.factor.whitened_directions();
        let gram = &information.gram;
        let crossing = |g: usize, h: usize| {
            let product = &gram[g] * &gram[h];
            if g == h { &gram[g] - product } else { product * faer::Scale(-1.0) }
        };
        let correction = scatter::correction(&directions, &relative, crossing);
        let finite =
            |matrix: &Mat<f64>| (0..matrix.ncols()).flat_map(|j| matrix.col_as_slice(j)).all(|value| value.is_finite());
        (finite(&relative) && finite(&correction)).then_some(ScaleUncertainty { relative, correction })
    }
}
