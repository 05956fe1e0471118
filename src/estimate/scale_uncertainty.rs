//! How uncertain estimated scales are, and what that costs the unknowns.
#![allow(
    clippy::indexing_slicing,
    reason = "rows are numbered within the system's, whose lists `System::check` has made of one length; the likelihood has an entry for each group"
)]

use super::groups::{NO_REDUNDANCY, count, sums};
use super::scatter::chain::Part as NoisePart;
use super::scatter::restricted::{NoiseModel, PartNoise, Slot};
use super::{Estimate, Group, System};
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
    /// `V = diag(s_g^2 u^2)` (`scatter/restricted.rs`).
    pub fn scale_uncertainty(&self, system: &System) -> Option<ScaleUncertainty> {
        let count = count(&system.group);
        if self.group_iterations == 0 || count == 0 {
            return None;
        }
        let index = |group: &Group| if let Group::Estimated(g) = group { *g } else { count };
        let part = |g: usize| {
            let all = 0..system.group.len().min(self.residuals.len());
            let rows: Vec<usize> = all.filter(|i| index(&system.group[*i]) == g).collect();
            NoisePart::white(rows.len() as f64, 0.0, sums(&self.factor, &self.residuals, &rows))
        };
        let parts: Vec<NoisePart> = (0..=count).map(part).collect();
        // the rows have their weights
        let white = |g: usize| if g < count { Slot::Free(g) } else { Slot::Stated(1.0) };
        let model = NoiseModel {
            parts: (0..=count).map(|g| PartNoise { white: white(g), deviation: None }).collect(),
            range: vec![(f64::NEG_INFINITY, f64::INFINITY); count],
            columns: self.factor.rank(),
        };
        let found = model.likelihood(&vec![0.0; count], &parts)?;
        let among: Vec<usize> = (0..count).filter(|g| found.redundancy[*g] > NO_REDUNDANCY).collect();
        let (relative, correction) = found.costs(&model, &among);
        let directions = self.factor.whitened_directions();
        let correction = &directions * correction * directions.transpose();
        let finite =
            |matrix: &Mat<f64>| (0..matrix.ncols()).flat_map(|j| matrix.col_as_slice(j)).all(|value| value.is_finite());
        (finite(&relative) && finite(&correction)).then_some(ScaleUncertainty { relative, correction })
    }
}
