//! What the rows say of each variance component, by whitened rows: the sums of the restricted likelihood (`restricted.rs`) with their derivatives.
//!
//! Every deviation has a row of its own, so that a component is a group of rows, be they readings or deviations. With the orthonormal bases
//! `Q1` of the deviations and `G` of the unknowns (orthogonal to it), residuals `v` and `C = [G v]`, all relative to the present variances,
//!
//! ```text
//! M = [1 0; 0 v'v],   M_g = -C_g' C_g,   M_gh = 2 C_g' (1 - Q1 Q1')_gh C_h,   tr V^-1 V_g = rows_g - |Q1_g|^2,   tr V^-1 V_g V^-1 V_h = |(1 - Q1 Q1')_gh|^2
//! ```
//!
//! W. Foerstner 1979; K.-R. Koch 1999, 3.6, in the form of pseudo-observations: the restricted likelihood is the same. Long chains have no small
//! basis: there the last trace is not known, and the average information stands for the expected one. Rows of negative
//! deviations count with the sign -1 in every product: the formulas are those of an imaginary standard deviation.
#![allow(
    clippy::indexing_slicing,
    reason = "members, fronts and norms have the pattern's rows and deviations; per-component lists have `members.count` entries, and one more for each that was added"
)]

use super::elimination::{Augmented, Whitening};
use super::restricted::Sums;
use crate::linear::dot;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par, Scale};

/// The component that each row, and each deviation's own row, belongs to; `None` where its variance is known.
pub(super) struct Membership {
    pub rows: Vec<Option<usize>>,
    pub deviations: Vec<Option<usize>>,
    pub count: usize,
}

/// Rows that others stand for (`condense.rs`): what rows of zeros say.
#[derive(Debug, Clone, Default)]
pub(super) struct LeftOut {
    /// How many belong to each component; none where the list ends.
    pub rows: Vec<f64>,
    /// `log det` of their covariance at variances of one.
    pub log_determinant: f64,
}

/// `C` at the rows of readings and at the deviations' own rows: one column for each independent unknown, and the residuals.
pub(super) struct Carried {
    pub rows: Mat<f64>,
    pub deviations: Mat<f64>,
}

impl Carried {
    /// `q` is the orthonormal basis of the whitened rows, and `residuals` are those of whitened least squares.
    pub fn new(whitening: &Whitening, (q, residuals): (&Mat<f64>, &[f64])) -> Self {
        let (pattern, rank) = (whitening.pattern(), q.ncols());
        let mut all =
            Carried { rows: Mat::zeros(pattern.rows, rank + 1), deviations: Mat::zeros(pattern.deviations, rank + 1) };
        for k in 0..=rank {
            let white = if k < rank { q.col_as_slice(k) } else { residuals };
            let own = whitening.backward(whitening.of_rows(white.to_vec()));
            all.rows.col_as_slice_mut(k).copy_from_slice(&own.rows);
            all.deviations.col_as_slice_mut(k).copy_from_slice(&own.deviations);
        }
        all
    }
}

/// `A' B`.
fn product(a: &Mat<f64>, b: &Mat<f64>) -> Mat<f64> {
    let mut product = Mat::zeros(a.ncols(), b.ncols());
    matmul(&mut product, Accum::Replace, a.transpose(), b.as_ref(), 1.0, Par::Seq);
    product
}

/// The sums of the components, and what the covariance of each makes of `C`, in whitened rows. `(q, residuals)` as for [`Carried::new`].
pub(super) fn sums(
    whitening: &Whitening,
    members: &Membership,
    left_out: &LeftOut,
    (q, residuals): (&Mat<f64>, &[f64]),
) -> (Sums, Vec<Mat<f64>>) {
    let carried = Carried::new(whitening, (q, residuals));
    let (count, columns) = (members.count, carried.rows.ncols());
    let mut whole = Mat::identity(columns, columns);
    whole[(columns - 1, columns - 1)] = dot(residuals, residuals);
    let mut sums = Sums::of(whole);
    let mut turned: Vec<Mat<f64>> = Vec::with_capacity(count);
    let (norms, local) = spans(whitening, members);
    // a row of zeros is redundant
    let left_out = |g: usize| left_out.rows.get(g).copied().unwrap_or(0.0);
    for g in 0..count {
        let keep = |values: &[f64], of: &[Option<usize>]| -> Vec<f64> {
            values.iter().zip(of).map(|(v, own)| if *own == Some(g) { *v } else { 0.0 }).collect()
        };
        let (mut white, mut gram) = (Mat::zeros(q.nrows(), columns), Mat::zeros(columns, columns));
        for a in 0..columns {
            let own = Augmented {
                rows: keep(carried.rows.col_as_slice(a), &members.rows),
                deviations: keep(carried.deviations.col_as_slice(a), &members.deviations),
            };
            for b in 0..=a {
                let deviations = carried.deviations.col_as_slice(b);
                let felt = whitening.product(0..deviations.len(), &own.deviations, deviations);
                let value = -dot(&own.rows, carried.rows.col_as_slice(b)) - felt;
                (gram[(a, b)], gram[(b, a)]) = (value, value);
            }
            white.col_as_slice_mut(a).copy_from_slice(&whitening.forward(own).rows);
        }
        let (mut size, mut spanned) = (left_out(g), 0.0);
        for (own, norm) in members.rows.iter().zip(&norms.rows).chain(members.deviations.iter().zip(&norms.deviations))
        {
            if *own == Some(g) {
                (size, spanned) = (size + 1.0, spanned + norm);
            }
        }
        let slope = size - spanned;
        let second = |h: usize| {
            let same = if g == h { slope - (size - 2.0 * spanned) } else { 0.0 };
            local.as_ref().map(|local| same - local[(g, h)])
        };
        let log_second = (0..=g).map(second).collect();
        add(&mut sums, &mut turned, (gram, white), slope, log_second);
    }
    (sums, turned)
}

/// One more parameter: `M_k`, what its derivative of `V` makes of `C` in whitened rows, and the derivatives of `log|V|` as far as they are known.
pub(super) fn add(
    sums: &mut Sums,
    turned: &mut Vec<Mat<f64>>,
    (first, white): (Mat<f64>, Mat<f64>),
    slope: f64,
    log_second: Vec<Option<f64>>,
) {
    let mut second: Vec<Mat<f64>> = turned.iter().map(|other| product(&white, other) * Scale(2.0)).collect();
    second.push(product(&white, &white) * Scale(2.0) + &first);
    // C' V^-1 V_k V^-1 V_h V^-1 C and its transpose
    let symmetric = second.into_iter().map(|own| Some((&own + own.transpose()) * Scale(0.5))).collect();
    turned.push(white);
    sums.first.push(first);
    sums.second.push(symmetric);
    sums.log_first.push(slope);
    sums.log_second.push(log_second);
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
