//! What each variance component contributes: squares of residuals, redundancy, information, and its part of the unknowns' covariance.
//!
//! Every deviation has a row of its own, so that a component is a group of rows, be they readings or deviations. With the orthonormal bases
//! `Q1` of the deviations and `G` of the unknowns (orthogonal to it), `P = I - Q1 Q1' - G G'` projects on the redundancy, and
//!
//! ```text
//! squares_g = v_g' v_g,   redundancy_g = tr P_gg,   S_gh = |P_gh|^2 = tr(P V_g P V_h),    G_g' G_g : the component's part of the covariance
//! ```
//!
//! W. Foerstner 1979; K.-R. Koch 1999, 3.6, in the form of pseudo-observations: the restricted likelihood is the same. Long chains have no small
//! basis: there `v_g' P v_h` stands for `S_gh`, twice the average information (A. R. Gilmour, R. Thompson, B. R. Cullis 1995).

use super::elimination::{Augmented, Whitening};
use crate::estimate::Estimate;
use faer::Mat;

/// The component that each row, and each deviation's own row, belongs to; `None` where its variance is known.
pub(super) struct Membership {
    pub rows: Vec<Option<usize>>,
    pub deviations: Vec<Option<usize>>,
    pub count: usize,
}

/// What the components contribute at the present variances, all relative to them.
pub(super) struct Inference {
    /// Columns of `G`.
    pub basis: Vec<Augmented>,
    /// Standardised residuals.
    pub residuals: Augmented,
    /// `v_g' v_g`.
    pub squares: Vec<f64>,
    /// `tr P_gg`.
    pub redundancy: Vec<f64>,
    /// `S_gh`.
    pub s: Mat<f64>,
    /// `v_g' P v_h`.
    pub observed: Mat<f64>,
    /// `G_g' G_g`.
    pub gamma: Vec<Mat<f64>>,
    /// `X_g = Q1_g' G_g`, column after column.
    seen: Vec<Vec<Vec<f64>>>,
    /// Squared norms of the rows of `Q1`.
    norms: Augmented,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Inference {
    pub fn new(whitening: &Whitening, members: &Membership, estimate: &Estimate) -> Self {
        let pattern = whitening.pattern();
        let none = || vec![0.0; pattern.deviations];
        let back = |rows: Vec<f64>| whitening.backward(Augmented { rows, deviations: none() });
        let q = estimate.factor.thin_q();
        let white_q: Vec<Vec<f64>> = (0..q.ncols()).map(|k| q.col(k).iter().copied().collect()).collect();
        let basis: Vec<Augmented> = white_q.iter().map(|column| back(column.clone())).collect();
        let residuals = back(estimate.residuals.clone());
        let count = members.count;
        let masked = |vector: &Augmented, g: usize| {
            let keep = |values: &[f64], of: &[Option<usize>]| -> Vec<f64> {
                values.iter().zip(of).map(|(v, own)| if *own == Some(g) { *v } else { 0.0 }).collect()
            };
            Augmented {
                rows: keep(&vector.rows, &members.rows),
                deviations: keep(&vector.deviations, &members.deviations),
            }
        };
        let (mut seen, mut gamma, mut projected) = (Vec::new(), Vec::new(), Vec::new());
        for g in 0..count {
            let own: Vec<Augmented> = basis.iter().map(|column| masked(column, g)).collect();
            gamma.push(Mat::from_fn(own.len(), own.len(), |a, b| {
                dot(&own[a].rows, &basis[b].rows) + dot(&own[a].deviations, &basis[b].deviations)
            }));
            seen.push(own.into_iter().map(|column| whitening.forward(column).deviations).collect::<Vec<_>>());
            let white = whitening.forward(masked(&residuals, g)).rows;
            let along: Vec<f64> = white_q.iter().map(|column| dot(column, &white)).collect();
            projected.push((white, along));
        }
        let (norms, local) = spans(whitening, members);
        let mut size = vec![0.0; count];
        let (mut squares, mut redundancy) = (vec![0.0; count], vec![0.0; count]);
        let rows = members.rows.iter().zip(&residuals.rows).zip(&norms.rows);
        let deviations = members.deviations.iter().zip(&residuals.deviations).zip(&norms.deviations);
        for ((own, v), norm) in rows.chain(deviations) {
            let Some(g) = own else { continue };
            size[*g] += 1.0;
            squares[*g] += v * v;
            redundancy[*g] += 1.0 - norm;
        }
        let trace = |m: &Mat<f64>| -> f64 { (0..m.nrows()).map(|i| m[(i, i)]).sum() };
        for (r, gamma) in redundancy.iter_mut().zip(&gamma) {
            *r -= trace(gamma);
        }
        let observed = Mat::from_fn(count, count, |g, h| {
            dot(&projected[g].0, &projected[h].0) - dot(&projected[g].1, &projected[h].1)
        });
        let mut inference =
            Inference { basis, residuals, squares, redundancy, s: observed.clone(), observed, gamma, seen, norms };
        if let Some(local) = local {
            inference.s = Mat::from_fn(count, count, |g, h| {
                let products: f64 = (0..inference.gamma[g].ncols())
                    .map(|k| dot(inference.gamma[g].col_as_slice(k), inference.gamma[h].col_as_slice(k)))
                    .sum();
                // tr K_g = size - redundancy - tr gamma
                let own = if g == h { 2.0 * inference.redundancy[g] - size[g] } else { 0.0 };
                own + local[(g, h)] + 2.0 * inference.together(g, h) + products
            });
        }
        inference
    }

    /// `tr(X_g' X_h)`.
    fn together(&self, g: usize, h: usize) -> f64 {
        self.seen[g].iter().zip(&self.seen[h]).map(|(a, b)| dot(a, b)).sum()
    }

    /// `G_g' P~_gh G_h` with `P~ = I - Q1 Q1' - G G'`: what Kenward and Roger's correction weighs.
    pub fn crossing(&self, g: usize, h: usize) -> Mat<f64> {
        let rank = self.basis.len();
        let product = &self.gamma[g] * &self.gamma[h];
        Mat::from_fn(rank, rank, |a, b| {
            let own = if g == h { self.gamma[g][(a, b)] } else { 0.0 };
            own - dot(&self.seen[g][a], &self.seen[h][b]) - product[(a, b)]
        })
    }

    /// Diagonal of `P` at the rows of readings.
    pub fn row_redundancy(&self) -> Vec<f64> {
        let used = |i: usize| self.basis.iter().map(|column| column.rows[i] * column.rows[i]).sum::<f64>();
        self.norms.rows.iter().enumerate().map(|(i, norm)| (1.0 - norm - used(i)).max(0.0)).collect()
    }
}

/// Squared norms of the rows of `Q1`, and where all blocks are small `sum over blocks tr(K_g K_h)` with `K_g = Q1_g' Q1_g`.
fn spans(whitening: &Whitening, members: &Membership) -> (Augmented, Option<Mat<f64>>) {
    let pattern = whitening.pattern();
    if !pattern.is_simple {
        return (whitening.span_norms(), None);
    }
    let mut norms = Augmented { rows: vec![0.0; pattern.rows], deviations: vec![0.0; pattern.deviations] };
    let mut local = Mat::zeros(members.count, members.count);
    whitening.spans(|rows, deviations, span| {
        let own = deviations.iter().map(|d| members.deviations[*d]).chain(rows.iter().map(|row| members.rows[*row]));
        let own: Vec<Option<usize>> = own.collect();
        let columns = span.ncols();
        let square = |i: usize| (0..columns).map(|k| span[(i, k)] * span[(i, k)]).sum::<f64>();
        deviations.iter().enumerate().for_each(|(i, d)| norms.deviations[*d] = square(i));
        rows.iter().enumerate().for_each(|(i, row)| norms.rows[*row] = square(deviations.len() + i));
        let mut grams: Vec<(usize, Vec<f64>)> = Vec::new();
        for (i, g) in own.iter().enumerate() {
            let Some(g) = g else { continue };
            let at = grams.iter().position(|(known, _)| known == g).unwrap_or_else(|| {
                grams.push((*g, vec![0.0; columns * columns]));
                grams.len() - 1
            });
            for a in 0..columns {
                for b in 0..columns {
                    grams[at].1[a * columns + b] += span[(i, a)] * span[(i, b)];
                }
            }
        }
        for (g, a) in &grams {
            for (h, b) in &grams {
                local[(*g, *h)] += dot(a, b);
            }
        }
    });
    (norms, Some(local))
}
