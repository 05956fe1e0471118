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
//! basis: there `v_g' P v_h` stands for `S_gh`, twice the average information (A. R. Gilmour, R. Thompson, B. R. Cullis 1995). Rows of negative
//! deviations count with the sign -1 in every product: the formulas are those of an imaginary standard deviation.
#![allow(
    clippy::indexing_slicing,
    reason = "members, fronts and norms have the pattern's rows and deviations; per-component lists have `members.count` entries or were added to together (`add`); `among` holds numbers of components"
)]

use super::elimination::{Augmented, Whitening};
use crate::linear::{dot, project};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

/// The component that each row, and each deviation's own row, belongs to; `None` where its variance is known.
pub(super) struct Membership {
    pub rows: Vec<Option<usize>>,
    pub deviations: Vec<Option<usize>>,
    pub count: usize,
}

/// What the components contribute at the present variances, all relative to them.
pub(super) struct Inference {
    /// `G` at the rows of readings, one column for each independent unknown.
    pub basis: Mat<f64>,
    /// `G` at the deviations' own rows.
    pub felt: Mat<f64>,
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
    /// What the component's covariance makes of `V^-1 A`, in whitened rows and projected on the redundancy: column after column.
    turned: Vec<Mat<f64>>,
    /// The same of the residuals.
    moved: Vec<Vec<f64>>,
}

/// `A' B`, added to what is there.
fn add_product(to: &mut Mat<f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    matmul(to, Accum::Add, a.transpose(), b, 1.0, Par::Seq);
}

/// Rows that others stand for (`condense.rs`): what rows of zeros say.
#[derive(Debug, Clone, Default)]
pub(super) struct LeftOut {
    /// How many belong to each component; none where the list ends.
    pub rows: Vec<f64>,
    /// `log det` of their covariance at variances of one.
    pub log_determinant: f64,
}

impl Inference {
    /// `q` is the orthonormal basis of the whitened rows, and `residuals` are those of whitened least squares.
    pub fn new(
        whitening: &Whitening,
        members: &Membership,
        left_out: &LeftOut,
        (q, residuals): (&Mat<f64>, &[f64]),
    ) -> Self {
        let pattern = whitening.pattern();
        let rank = q.ncols();
        let back = |rows: &[f64]| whitening.backward(whitening.of_rows(rows.to_vec()));
        let (mut basis, mut felt) = (Mat::zeros(pattern.rows, rank), Mat::zeros(pattern.deviations, rank));
        for k in 0..rank {
            let column = back(q.col_as_slice(k));
            basis.col_as_slice_mut(k).copy_from_slice(&column.rows);
            felt.col_as_slice_mut(k).copy_from_slice(&column.deviations);
        }
        let residuals = back(residuals);
        let count = members.count;
        let masked = |rows: &[f64], deviations: &[f64], g: usize| {
            let keep = |values: &[f64], of: &[Option<usize>]| -> Vec<f64> {
                values.iter().zip(of).map(|(v, own)| if *own == Some(g) { *v } else { 0.0 }).collect()
            };
            Augmented { rows: keep(rows, &members.rows), deviations: keep(deviations, &members.deviations) }
        };
        let (mut gamma, mut turned, mut moved) = (Vec::new(), Vec::new(), Vec::new());
        for g in 0..count {
            let mut white = Mat::zeros(pattern.rows, rank);
            for k in 0..rank {
                let own = masked(basis.col_as_slice(k), felt.col_as_slice(k), g);
                white.col_as_slice_mut(k).copy_from_slice(&whitening.forward(own).rows);
            }
            let left = whitening.forward(masked(&residuals.rows, &residuals.deviations, g)).rows;
            let (own, white, left) = projected(q, white, left);
            gamma.push(own);
            turned.push(white);
            moved.push(left);
        }
        let (norms, local) = spans(whitening, members);
        // a row of zeros is redundant
        let mut size: Vec<f64> = (0..count).map(|g| left_out.rows.get(g).copied().unwrap_or(0.0)).collect();
        let (mut squares, mut redundancy) = (vec![0.0; count], size.clone());
        let rows = members.rows.iter().zip(&residuals.rows).zip(&norms.rows).map(|own| (own, 1.0));
        let deviations = members.deviations.iter().zip(&residuals.deviations).zip(&norms.deviations);
        let deviations = deviations.enumerate().map(|(d, own)| (own, whitening.sign(d)));
        for (((own, v), norm), sign) in rows.chain(deviations) {
            let Some(g) = own else { continue };
            size[*g] += 1.0;
            squares[*g] += sign * v * v;
            redundancy[*g] += 1.0 - norm;
        }
        let trace = |m: &Mat<f64>| -> f64 { (0..m.nrows()).map(|i| m[(i, i)]).sum() };
        for (r, gamma) in redundancy.iter_mut().zip(&gamma) {
            *r -= trace(gamma);
        }
        let observed = Mat::from_fn(count, count, |g, h| dot(&moved[g], &moved[h]));
        let s = observed.clone();
        let mut inference =
            Inference { basis, felt, residuals, squares, redundancy, s, observed, gamma, turned, moved };
        if let Some(local) = local {
            inference.s = Mat::from_fn(count, count, |g, h| {
                let products = inner(&inference.gamma[g], &inference.gamma[h]);
                // tr K_g = size - redundancy - tr gamma; tr(X_g' X_h) from G_g' (P + G G')_gh G_h
                let own = if g == h {
                    2.0 * inference.redundancy[g] - size[g] + 2.0 * trace(&inference.gamma[g])
                } else {
                    0.0
                };
                own + local[(g, h)] - 2.0 * inner(&inference.turned[g], &inference.turned[h]) - products
            });
        }
        inference
    }

    /// What estimated variances add to the covariance of the unknowns: M. G. Kenward and J. H. Roger, "Small sample inference for fixed effects from restricted
    /// maximum likelihood", Biometrics 53 (1997), 983-997, `2 T {sum W_gh (Q_gh - P_g P_h)} T'`: what stands in braces is `G_g' P_gh G_h`, `W` the relative covariance
    /// of the variances. In this form where variances are told by gram matrices of rows; from derivatives of the covariance: `restricted.rs`.
    ///
    /// `T` are the whitened directions of the unknowns (`T T'` is their covariance with known variances).
    pub fn correction(&self, directions: &Mat<f64>, spread: &Mat<f64>) -> Mat<f64> {
        let rank = directions.ncols();
        let mut middle = Mat::<f64>::zeros(rank, rank);
        for g in 0..spread.nrows() {
            for h in 0..spread.nrows() {
                let weight = spread[(g, h)];
                if weight != 0.0 && weight.is_finite() {
                    let mut crossing = Mat::zeros(rank, rank);
                    add_product(&mut crossing, self.turned[g].as_ref(), self.turned[h].as_ref());
                    middle += crossing * faer::Scale(2.0 * weight);
                }
            }
        }
        directions * middle * directions.transpose()
    }

    /// One more component, by what its derivative of `V` makes of `V^-1 A` and of the residuals, both in whitened rows.
    pub fn add(&mut self, q: &Mat<f64>, white: Mat<f64>, residual: Vec<f64>) {
        let (own, white, left) = projected(q, white, residual);
        self.gamma.push(own);
        self.turned.push(white);
        self.moved.push(left);
        let count = self.gamma.len();
        let grown = |old: &Mat<f64>| {
            Mat::from_fn(count, count, |g, h| {
                if g + 1 < count && h + 1 < count { old[(g, h)] } else { dot(&self.moved[g], &self.moved[h]) }
            })
        };
        (self.s, self.observed) = (grown(&self.s), grown(&self.observed));
    }
}

/// Sum of the products of elements.
fn inner(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    (0..a.ncols()).map(|k| dot(a.col_as_slice(k), b.col_as_slice(k))).sum()
}

/// Squared norms of the rows of `Q1`, and where all blocks are small `sum over blocks tr(K_g K_h)` with `K_g = Q1_g' Q1_g`.
fn spans(whitening: &Whitening, members: &Membership) -> (Augmented, Option<Mat<f64>>) {
    let is_simple = whitening.pattern().is_simple;
    let mut local = Mat::zeros(members.count, members.count);
    let norms = whitening.norms(|front, columns| {
        if !is_simple || members.count == 0 {
            return;
        }
        let sign = |i: usize| front.entering.get(i).map_or(1.0, |d| whitening.sign(*d));
        let size = columns.len();
        let mut grams: Vec<(usize, Vec<f64>)> = Vec::new();
        let deviations = front.entering.iter().map(|d| members.deviations[*d]);
        for (i, g) in deviations.chain(front.rows.iter().map(|row| members.rows[*row])).enumerate() {
            let Some(g) = g else { continue };
            let at = grams.iter().position(|(known, _)| *known == g).unwrap_or_else(|| {
                grams.push((g, vec![0.0; size * size]));
                grams.len() - 1
            });
            for (a, one) in columns.iter().enumerate() {
                for (b, other) in columns.iter().enumerate() {
                    grams[at].1[a * size + b] += sign(i) * one[i] * other[i];
                }
            }
        }
        for (g, a) in &grams {
            for (h, b) in &grams {
                let pairs = a.iter().zip(b).enumerate();
                local[(*g, *h)] += pairs.map(|(k, (a, b))| sign(k / size) * sign(k % size) * a * b).sum::<f64>();
            }
        }
    });
    (norms, is_simple.then_some(local))
}

/// What a component's covariance makes of `V^-1 A` and of the residuals, both in whitened rows: its part of the unknowns' covariance, and the rest of both in the
/// redundancy.
fn projected(q: &Mat<f64>, mut white: Mat<f64>, mut residual: Vec<f64>) -> (Mat<f64>, Mat<f64>, Vec<f64>) {
    let rank = q.ncols();
    // G' W' W V_g W' W G = G_g' G_g
    let mut own = Mat::zeros(rank, rank);
    add_product(&mut own, q.as_ref(), white.as_ref());
    matmul(&mut white, Accum::Add, q.as_ref(), own.as_ref(), -1.0, Par::Seq);
    project(&mut residual, &(0..rank).map(|k| q.col_as_slice(k)).collect::<Vec<_>>());
    (Mat::from_fn(rank, rank, |a, b| 0.5 * (own[(a, b)] + own[(b, a)])), white, residual)
}
