//! Helmert's equations for variance components, the steps that they give, and what estimated weights cost a small sample.

use super::Estimate;
use super::components::Component;
use super::whitening::Whitening;
use faer::Mat;
use faer::linalg::solvers::Solve;

/// Helmert's normal equations at the present components.
pub(super) struct Normal {
    /// `tr(P V_g P V_h)`.
    s: Mat<f64>,
    /// `y' P V_g P y`.
    q: Vec<f64>,
    /// `tr(P V_g)`.
    trace: Vec<f64>,
    /// `V~_h Q`, `m x rank`.
    seen: Vec<Mat<f64>>,
    /// `Q' V~_h Q`.
    inner: Vec<Mat<f64>>,
}

impl Normal {
    pub(super) fn new(whitening: &Whitening<'_>, components: &[Component], estimate: &Estimate) -> Self {
        let q = estimate.factor.thin_q();
        let (m, rank) = (q.nrows(), q.ncols());
        let parts: Vec<Vec<Mat<f64>>> = components.iter().map(|c| whitening.whiten(c)).collect();
        let times = |parts: &[Mat<f64>], column: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let mut out = vec![0.0; m];
            for (block, part) in whitening.blocks.iter().zip(parts) {
                for (i, row) in block.iter().enumerate() {
                    out[*row] = block.iter().enumerate().map(|(j, other)| part[(i, j)] * column(*other)).sum();
                }
            }
            out
        };
        let mut seen = Vec::with_capacity(parts.len());
        let mut squares = Vec::with_capacity(parts.len());
        for parts in &parts {
            let mut all = Mat::zeros(m, rank);
            for k in 0..rank {
                all.col_as_slice_mut(k).copy_from_slice(&times(parts, &|i| q[(i, k)]));
            }
            seen.push(all);
            let moved = times(parts, &|i| estimate.residuals[i]);
            squares.push(moved.iter().zip(&estimate.residuals).map(|(a, b)| a * b).sum());
        }
        let inner: Vec<Mat<f64>> = seen.iter().map(|seen| q.transpose() * seen).collect();
        let dot = |a: &Mat<f64>, b: &Mat<f64>| -> f64 {
            (0..a.ncols()).flat_map(|k| a.col_as_slice(k).iter().zip(b.col_as_slice(k))).map(|(a, b)| a * b).sum()
        };
        let s = Mat::from_fn(parts.len(), parts.len(), |g, h| {
            let whole: f64 = parts[g].iter().zip(&parts[h]).map(|(a, b)| dot(a, b)).sum();
            whole - 2.0 * dot(&seen[g], &seen[h]) + dot(&inner[g], &inner[h])
        });
        let diagonal = |a: &Mat<f64>| -> f64 { (0..a.nrows()).map(|i| a[(i, i)]).sum() };
        let trace = parts
            .iter()
            .zip(&inner)
            .map(|(parts, inner)| parts.iter().map(diagonal).sum::<f64>() - diagonal(inner))
            .collect();
        Normal { s, q: squares, trace, seen, inner }
    }

    /// Fisher's step, `S theta = q` over the variances to estimate.
    pub(super) fn step(&self, estimated: &[usize], now: &[f64]) -> Vec<f64> {
        let s = Mat::from_fn(estimated.len(), estimated.len(), |a, b| self.s[(estimated[a], estimated[b])]);
        let fixed = |g: usize| -> f64 {
            (0..now.len()).filter(|h| !estimated.contains(h)).map(|h| self.s[(g, h)] * now[h]).sum()
        };
        let q = Mat::from_fn(estimated.len(), 1, |a, _| self.q[estimated[a]] - fixed(estimated[a]));
        let found = s.col_piv_qr().solve(&q);
        let mut next = now.to_vec();
        for (a, k) in estimated.iter().enumerate() {
            next[*k] = found[(a, 0)];
        }
        next
    }

    /// A step that keeps every variance positive and never lowers the likelihood: `theta *= sqrt(y'P V_h P y / tr P V_h)`
    /// (H. Zhou, L. Hu, J. Zhou, K. Lange, "MM algorithms for variance components models", J. Comp. Graph. Stat. 28 (2019)).
    pub(super) fn safe_step(&self, estimated: &[usize], now: &[f64]) -> Vec<f64> {
        let mut next = now.to_vec();
        for k in estimated {
            let ratio = self.q[*k] / self.trace[*k];
            if ratio > 0.0 && ratio.is_finite() {
                next[*k] *= ratio.sqrt();
            }
        }
        next
    }

    /// Covariance of the estimated variances, `2 S^-1`.
    pub(super) fn spread(&self, estimated: &[usize]) -> Mat<f64> {
        let count = self.q.len();
        let mut spread = Mat::zeros(count, count);
        if estimated.is_empty() {
            return spread;
        }
        let s = Mat::from_fn(estimated.len(), estimated.len(), |a, b| self.s[(estimated[a], estimated[b])]);
        let inverse = s.col_piv_qr().solve(Mat::<f64>::identity(estimated.len(), estimated.len()));
        for (a, g) in estimated.iter().enumerate() {
            for (b, h) in estimated.iter().enumerate() {
                spread[(*g, *h)] = 2.0 * inverse[(a, b)];
            }
        }
        spread
    }

    /// Kenward and Roger's correction `2 T {sum W_ij (W_i'W_j - A_i A_j)} T'`.
    pub(super) fn correction(&self, estimate: &Estimate, spread: &Mat<f64>) -> Mat<f64> {
        let rank = estimate.factor.rank();
        let mut middle = Mat::<f64>::zeros(rank, rank);
        for i in 0..self.q.len() {
            for j in 0..self.q.len() {
                if spread[(i, j)] == 0.0 || !spread[(i, j)].is_finite() {
                    continue;
                }
                let part = self.seen[i].transpose() * &self.seen[j] - &self.inner[i] * &self.inner[j];
                middle += part * faer::Scale(2.0 * spread[(i, j)]);
            }
        }
        let directions = estimate.factor.whitened_directions();
        &directions * middle * directions.transpose()
    }
}
