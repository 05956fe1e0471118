//! What estimated variances cost: their own covariance, and M. G. Kenward and J. H. Roger's addition to the covariance of the unknowns, "Small
//! sample inference for fixed effects from restricted maximum likelihood", Biometrics 53 (1997), 983-997. In this form where variances are told by
//! gram matrices of rows; from derivatives of the covariance: `restricted.rs`.
#![allow(
    clippy::indexing_slicing,
    reason = "`among` holds numbers of components, for which `s` has a row and a column each: its callers filter them from `0..s.nrows()`"
)]

use faer::Mat;
use faer::linalg::solvers::Solve;

/// `2 S^-1` over some components: the covariance of the estimated variances, each relative to its estimate; zero for the others.
pub(super) fn spread(s: &Mat<f64>, among: &[usize]) -> Mat<f64> {
    let mut all = Mat::zeros(s.nrows(), s.nrows());
    if among.is_empty() {
        return all;
    }
    let size = |g: usize| s[(g, g)].max(f64::MIN_POSITIVE).sqrt();
    let part =
        Mat::from_fn(among.len(), among.len(), |a, b| s[(among[a], among[b])] / (size(among[a]) * size(among[b])));
    let inverse = part.col_piv_qr().solve(Mat::<f64>::identity(among.len(), among.len()));
    for (a, g) in among.iter().enumerate() {
        for (b, h) in among.iter().enumerate() {
            all[(*g, *h)] = 2.0 * inverse[(a, b)] / (size(*g) * size(*h));
        }
    }
    all
}

/// `2 T {sum W_gh (Q_gh - P_g P_h)} T'`: `crossing(g, h)` is what stands in braces, `W` the relative covariance of the variances.
///
/// `T` are the whitened directions of the unknowns (`T T'` is their covariance with known variances).
pub(super) fn correction(
    directions: &Mat<f64>,
    spread: &Mat<f64>,
    crossing: impl Fn(usize, usize) -> Mat<f64>,
) -> Mat<f64> {
    let rank = directions.ncols();
    let mut middle = Mat::<f64>::zeros(rank, rank);
    for g in 0..spread.nrows() {
        for h in 0..spread.nrows() {
            let weight = spread[(g, h)];
            if weight != 0.0 && weight.is_finite() {
                middle += crossing(g, h) * faer::Scale(2.0 * weight);
            }
        }
    }
    directions * middle * directions.transpose()
}
