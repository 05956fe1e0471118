//! Deviations taken out of the rows by Householder reflections, front by front.
//!
//! ```text
//! Q' [R^-1/2 Z S; L] = [T; 0],      Q2' [R^-1/2 y; 0] = W y,      W' W = V^-1
//! ```
//!
//! `S` are the standard deviations, so that every deviation has unit variance, and `L` holds the deviations' own rows: ones, or the steps of a
//! chain. Rows are exchanged so that the largest element is the pivot, which keeps small rows accurate beside large ones (A. J. Cox,
//! N. J. Higham, "Stability of Householder QR factorization for weighted least squares problems", 1998). The reflections are kept: backwards
//! they give sensitivities, predicted deviations and redundancies without a difference of large numbers.
//!
//! A variance may be negative as long as `V` is positive definite: its deviations' own rows then count with the sign -1, and reflections keep
//! `sum s_i y_i^2` instead of the length. Negative deviations come last and their pivots are rows of their own sign, so that readings stay
//! readings.
#![allow(
    clippy::indexing_slicing,
    reason = "fronts hold deviations and rows of the pattern, and vectors over both have the pattern's lengths: whoever gives values from outside has them filled up first (`whiten`, `carry_back`)"
)]

use super::pattern::{ByRow, Front};
use super::{Pattern, ScatterLine};
use crate::elements::Elements;
use crate::estimate::System;
use faer::{Mat, MatRef};

/// Everything known: standard deviations of the rows, and variances of the lines.
#[derive(Debug, Clone)]
pub struct Whitening {
    pattern: Pattern,
    /// Standard deviation of each row's own noise.
    sd: Vec<f64>,
    parts: Vec<Part>,
    /// `sum log` of the diagonal of `T`, less that of `L`.
    log_diagonal: f64,
    /// Sign of each deviation's own row; empty where all are positive.
    sign: Vec<f64>,
    /// Is `V` positive definite?
    is_positive: bool,
}

/// The reflections of one front.
#[derive(Debug, Clone)]
struct Part {
    /// Rows that come from the front before.
    carried: usize,
    /// All rows.
    rows: usize,
    /// Reflections below and on the diagonal, `T` above it; column by column.
    matrix: Vec<f64>,
    /// Diagonal of `T`.
    diagonal: Vec<f64>,
    /// `2 / v'v` of each reflection.
    beta: Vec<f64>,
    /// With which row each row was exchanged.
    exchanged: Vec<usize>,
    /// Sign of each row; empty where all are positive. Exchanges are among rows of one sign.
    sign: Vec<f64>,
}

/// A vector in the rows and the deviations' own rows.
#[derive(Debug, Clone)]
pub(super) struct Augmented {
    pub rows: Vec<f64>,
    pub deviations: Vec<f64>,
}

impl Part {
    fn reflect(&self, values: &mut [f64]) {
        for (j, beta) in self.beta.iter().enumerate() {
            values.swap(j, self.exchanged[j]);
            self.apply(j, *beta, values);
        }
    }

    fn reflect_back(&self, values: &mut [f64]) {
        for (j, beta) in self.beta.iter().enumerate().rev() {
            self.apply(j, *beta, values);
            values.swap(j, self.exchanged[j]);
        }
    }

    fn apply(&self, j: usize, beta: f64, values: &mut [f64]) {
        let v = &self.matrix[j * self.rows + j..(j + 1) * self.rows];
        let values = &mut values[j..];
        let along = self.product(j, v, values) * beta;
        values.iter_mut().zip(v).for_each(|(y, v)| *y -= along * v);
    }

    /// `sum s_i a_i b_i` over the rows from `j` on.
    fn product(&self, j: usize, a: &[f64], b: &[f64]) -> f64 {
        let plain = a.iter().zip(b).map(|(a, b)| a * b);
        match self.sign.get(j..) {
            Some(sign) if !sign.is_empty() => plain.zip(sign).map(|(ab, s)| ab * s).sum(),
            _ => plain.sum(),
        }
    }

    /// Take the columns to a triangle; `false` where `V` is not positive definite.
    fn factorise(&mut self, columns: usize) -> bool {
        let m = self.rows;
        // no signs are kept where all are positive
        let sign_of = |sign: &[f64], i: usize| sign.get(i).copied().unwrap_or(1.0);
        let mut is_positive = true;
        for j in 0..columns {
            let column = &self.matrix[j * m..(j + 1) * m];
            let own = sign_of(&self.sign, j);
            let eligible = (j..m).filter(|i| sign_of(&self.sign, *i) == own);
            // row j itself is eligible
            let pivot = eligible.max_by(|a, b| column[*a].abs().total_cmp(&column[*b].abs())).unwrap_or(j);
            (0..columns).for_each(|k| self.matrix.swap(k * m + j, k * m + pivot));
            // reflections that were made keep their rows: the exchange belongs to what comes after
            (0..j).for_each(|k| self.matrix.swap(k * m + j, k * m + pivot));
            let column = &self.matrix[j * m + j..(j + 1) * m];
            let square = own * self.product(j, column, column);
            is_positive &= own > 0.0 || square > 0.0;
            let norm = square.abs().sqrt();
            let column = &mut self.matrix[j * m..(j + 1) * m];
            let head = column[j];
            let diagonal = if head > 0.0 { -norm } else { norm };
            column[j] = head - diagonal;
            let column = &self.matrix[j * m + j..(j + 1) * m];
            let square = self.product(j, column, column);
            let beta = if square != 0.0 { 2.0 / square } else { 0.0 };
            self.exchanged.push(pivot);
            self.beta.push(beta);
            self.diagonal.push(diagonal);
            let mut matrix = std::mem::take(&mut self.matrix);
            let (done, rest) = matrix.split_at_mut((j + 1) * m);
            let v = &done[j * m + j..];
            for k in 0..columns - j - 1 {
                let other = &mut rest[k * m + j..(k + 1) * m];
                let along = self.product(j, v, other) * beta;
                other.iter_mut().zip(v).for_each(|(y, v)| *y -= along * v);
            }
            self.matrix = matrix;
        }
        is_positive
    }
}

impl Whitening {
    /// Take the deviations of `lines` out of rows whose own noise has the standard deviations `sd`; `variance` is that of each line's
    /// deviations. A line without a variance, or of variance zero, changes nothing. A negative variance is taken as it is where every block
    /// is small and the deviations have no memory, and as zero elsewhere.
    ///
    /// ```
    /// use tumble::estimate::{Felt, ScatterLine, Pattern, Whitening};
    /// // two readings of unit noise share an offset of variance 3: V = [4 3; 3 4], and y' V^-1 y = 2/7 for y = (1, 1)
    /// let felt = vec![Felt { row: 0, level: 0, by: 1.0 }, Felt { row: 1, level: 0, by: 1.0 }];
    /// let lines = [ScatterLine { felt, variance: Some(3.0), memory: None }];
    /// let whitening = Whitening::new(&Pattern::new(2, &lines), &[1.0, 1.0], &lines, &[3.0]);
    /// let white = whitening.whiten(&[1.0, 1.0]);
    /// assert!((white.iter().map(|v| v * v).sum::<f64>() - 2.0 / 7.0).abs() < 1e-15);
    /// ```
    pub fn new(pattern: &Pattern, sd: &[f64], lines: &[ScatterLine], variance: &[f64]) -> Self {
        // the deviation's own row: its coefficient, and that of the one before in its chain
        let mut chain = vec![(1.0, 0.0); pattern.deviations];
        let negative = |line: &ScatterLine, variance: f64| variance < 0.0 && pattern.is_simple && line.memory.is_none();
        let mut sign: Vec<f64> = Vec::new();
        let mut sizes = Vec::with_capacity(lines.len());
        for ((line, start), variance) in lines.iter().zip(&pattern.first).zip(variance) {
            let size = if negative(line, *variance) {
                sign.resize(pattern.deviations, 1.0);
                sign.iter_mut().skip(*start).take(line.levels()).for_each(|sign| *sign = -1.0);
                -variance
            } else {
                variance.max(0.0)
            };
            let size = size.sqrt();
            sizes.push(size);
            let Some(memory) = &line.memory else { continue };
            // no time constant yet: independent
            let tau = memory.tau.unwrap_or(0.0);
            for level in 0..line.levels() {
                let before = pattern.before.get(start + level).copied().flatten();
                let (Some(from), Some(own)) = (before, chain.get_mut(start + level)) else { continue };
                let at = |l: usize| memory.time.at(l);
                let dt = (at(level) - at(from.saturating_sub(*start))).abs() / tau;
                let left = (-(-2.0 * dt).exp_m1()).max(f64::MIN_POSITIVE).sqrt();
                *own = if dt < 40.0 { (1.0 / left, -(-dt).exp() / left) } else { (1.0, 0.0) };
            }
        }
        let pairs = lines.iter().zip(&pattern.first).zip(&sizes).flat_map(|((line, start), size)| {
            let known = line.felt.iter().filter_map(|own| Some((own, sd.get(own.row)?)));
            known.map(move |(own, sd)| (own.row, (start.saturating_add(own.level), own.by * size / sd)))
        });
        let felt = ByRow::new(pattern.rows, pairs);
        let mut pattern = pattern.clone();
        if !sign.is_empty() {
            for front in &mut pattern.fronts {
                front.columns.sort_by(|a, b| sign[*b].total_cmp(&sign[*a]));
                front.entering.clone_from(&front.columns);
            }
        }
        let mut is_positive = true;
        let mut parts: Vec<Part> = Vec::with_capacity(pattern.fronts.len());
        let mut place = vec![usize::MAX; pattern.deviations];
        let mut log_diagonal = 0.0;
        for (f, front) in pattern.fronts.iter().enumerate() {
            let last = if front.begins {
                None
            } else {
                f.checked_sub(1).and_then(|b| parts.last().zip(pattern.fronts.get(b)))
            };
            let carried = last.map_or(0, |(_, before)| before.columns.len() - before.leaving);
            let columns = front.columns.len();
            let rows = carried + front.entering.len() + front.rows.len();
            let mut matrix = vec![0.0; rows * columns];
            front.columns.iter().enumerate().for_each(|(k, d)| place[*d] = k);
            if let Some((part, before)) = last {
                let from = before.leaving;
                for a in from..before.columns.len() {
                    let column = place[before.columns[a]];
                    for i in from..=a {
                        let value = if i == a { part.diagonal[a] } else { part.matrix[a * part.rows + i] };
                        matrix[column * rows + i - from] = value;
                    }
                }
            }
            for (i, d) in front.entering.iter().enumerate() {
                let (own, from) = chain[*d];
                matrix[place[*d] * rows + carried + i] = own;
                log_diagonal -= own.ln();
                if let Some(other) = pattern.before[*d].filter(|_| from != 0.0) {
                    matrix[place[other] * rows + carried + i] = from;
                }
            }
            for (i, row) in front.rows.iter().enumerate() {
                for (d, value) in felt.of(*row) {
                    // lines that are not the pattern's may name deviations which it has not, or not in this front
                    let column = place.get(*d).filter(|column| **column < columns);
                    if let Some(slot) =
                        column.and_then(|k| matrix.get_mut(k * rows + carried + front.entering.len() + i))
                    {
                        *slot += value;
                    }
                }
            }
            let mut own: Vec<f64> = Vec::new();
            if front.entering.iter().any(|d| sign.get(*d).is_some_and(|s| *s < 0.0)) {
                own.extend(front.entering.iter().map(|d| sign[*d]));
                own.resize(rows, 1.0);
            }
            let mut part = Part { carried, rows, matrix, diagonal: vec![], beta: vec![], exchanged: vec![], sign: own };
            is_positive &= part.factorise(columns);
            log_diagonal += part.diagonal.iter().take(front.leaving).map(|d| d.abs().ln()).sum::<f64>();
            parts.push(part);
        }
        Whitening { pattern, sd: sd.to_vec(), parts, log_diagonal, sign, is_positive }
    }

    /// Is `V` positive definite? Only negative variances can make it otherwise.
    pub(super) fn is_positive(&self) -> bool {
        self.is_positive
    }

    /// Sign with which a deviation's own row counts.
    pub(super) fn sign(&self, deviation: usize) -> f64 {
        self.sign.get(deviation).copied().unwrap_or(1.0) // none are kept where all are positive
    }

    /// `sum s_i a_i b_i` over some deviations.
    pub(super) fn product(&self, among: std::ops::Range<usize>, a: &[f64], b: &[f64]) -> f64 {
        let plain = a[among.clone()].iter().zip(&b[among.clone()]).map(|(a, b)| a * b);
        if self.sign.is_empty() { plain.sum() } else { plain.zip(&self.sign[among]).map(|(ab, s)| ab * s).sum() }
    }

    /// Values of the rows, as many as the pattern has: what is lacking is not a number.
    pub(super) fn of_rows(&self, mut rows: Vec<f64>) -> Augmented {
        rows.resize(self.pattern.rows, f64::NAN);
        Augmented { rows, deviations: vec![0.0; self.pattern.deviations] }
    }

    /// `W y`: as many independent values of unit variance; none is a number where `y` is shorter than the rows.
    pub fn whiten(&self, values: &[f64]) -> Vec<f64> {
        let rows: Vec<f64> = values.iter().zip(&self.sd).map(|(y, sd)| y / sd).collect();
        self.forward(self.of_rows(rows)).rows
    }

    /// `W A`, column by column.
    pub(crate) fn whiten_columns(&self, columns: &Mat<f64>) -> Mat<f64> {
        let mut out = Mat::zeros(self.pattern.rows, columns.ncols());
        for j in 0..out.ncols() {
            let white = self.whiten(columns.col_as_slice(j));
            out.col_as_slice_mut(j).copy_from_slice(&white);
        }
        out
    }

    /// A system of rows and observations, made independent.
    pub(crate) fn system(&self, rows: &Mat<f64>, observed: &[f64]) -> System {
        System::known(self.whiten_columns(rows), self.whiten(observed), vec![1.0; self.pattern.rows])
    }

    /// `W' w`: a vector of whitened rows carried back to the readings, `W' W y = V^-1 y`.
    pub fn carry_back(&self, white: &[f64]) -> Vec<f64> {
        let back = self.backward(self.of_rows(white.to_vec()));
        back.rows.iter().zip(&self.sd).map(|(v, sd)| v / sd).collect()
    }

    /// What a unit error of a row, or of a deviation behind the rows, in units of its own noise leaves of itself when the deviations and an orthonormal basis `q` of
    /// the whitened rows are taken out: rows first, then deviations.
    pub(crate) fn remainder(&self, place: usize, q: MatRef<'_, f64>) -> Vec<f64> {
        let mut unit = self.of_rows(vec![0.0; self.pattern.rows]);
        let slot = match place.checked_sub(self.pattern.rows) {
            Some(deviation) => unit.deviations.get_mut(deviation),
            None => unit.rows.get_mut(place),
        };
        slot.into_iter().for_each(|own| *own = 1.0);
        let mut white = self.forward(unit).rows;
        crate::linear::project_out(&mut white, q);
        let back = self.backward(self.of_rows(white));
        [back.rows, back.deviations].concat()
    }

    /// Redundancy number of each row, then of each deviation, beside an orthonormal basis `q` of the whitened rows, deviations being unknowns with a row of their own.
    pub(crate) fn redundancies(&self, q: MatRef<'_, f64>) -> Vec<f64> {
        let norms = self.norms(|_, _| {});
        let mut left: Vec<f64> = norms.rows.iter().chain(&norms.deviations).map(|norm| 1.0 - norm).collect();
        for k in 0..q.ncols() {
            let back = self.backward(self.of_rows(q.col(k).iter().copied().collect()));
            let deviations = back.deviations.iter().enumerate().map(|(d, g)| self.sign(d) * g * g);
            let all = back.rows.iter().map(|g| g * g).chain(deviations);
            left.iter_mut().zip(all).for_each(|(left, own)| *left -= own);
        }
        left.iter_mut().for_each(|left| *left = left.max(0.0));
        left
    }

    /// Standard deviation of each row's own noise.
    pub(crate) fn sd(&self) -> &[f64] {
        &self.sd
    }

    /// `log det V`.
    pub fn log_determinant(&self) -> f64 {
        2.0 * (self.log_diagonal + self.sd.iter().map(|sd| sd.ln()).sum::<f64>())
    }

    /// Rows.
    pub fn rows(&self) -> usize {
        self.pattern.rows
    }

    pub(super) fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// `Q' v`: what leaves with the deviations, and the whitened rows.
    pub(super) fn forward(&self, mut vector: Augmented) -> Augmented {
        let mut carried: Vec<f64> = Vec::new();
        let mut local: Vec<f64> = Vec::new();
        for (front, part) in self.pattern.fronts.iter().zip(&self.parts) {
            local.clear();
            if part.carried > 0 {
                local.extend(&carried);
            }
            local.extend(front.entering.iter().map(|d| vector.deviations[*d]));
            local.extend(front.rows.iter().map(|row| vector.rows[*row]));
            part.reflect(&mut local);
            let (leaving, columns) = (front.leaving, front.columns.len());
            // an entering deviation's slot was read already, one that left is never read again
            front.columns.iter().zip(&local).take(leaving).for_each(|(d, v)| vector.deviations[*d] = *v);
            carried.clear();
            carried.extend(&local[leaving..columns]);
            front.rows.iter().zip(&local[columns..]).for_each(|(row, v)| vector.rows[*row] = *v);
        }
        vector
    }

    /// `Q v`, the inverse of [`Whitening::forward`].
    pub(super) fn backward(&self, mut vector: Augmented) -> Augmented {
        let mut passed: Vec<f64> = Vec::new();
        let mut local: Vec<f64> = Vec::new();
        let mut own = vec![0.0; self.pattern.deviations];
        for (front, part) in self.pattern.fronts.iter().zip(&self.parts).rev() {
            local.clear();
            local.extend(front.columns.iter().take(front.leaving).map(|d| vector.deviations[*d]));
            if front.columns.len() > front.leaving {
                local.extend(&passed);
            }
            local.extend(front.rows.iter().map(|row| vector.rows[*row]));
            part.reflect_back(&mut local);
            passed.clear();
            passed.extend(&local[..part.carried]);
            let entering = front.entering.len();
            front.entering.iter().zip(&local[part.carried..]).for_each(|(d, v)| own[*d] = *v);
            front.rows.iter().zip(&local[part.carried + entering..]).for_each(|(row, v)| vector.rows[*row] = *v);
        }
        vector.deviations = own;
        vector
    }

    /// Squared norms of the rows of the orthonormal basis `Q1` that the deviations span, by the covariance of each front's deviations, from the last
    /// front of a block to its first. `visit` gets each front with the columns of `Q1` in its rows: carried ones, the deviations' own, readings.
    pub(super) fn norms(&self, mut visit: impl FnMut(&Front, &[Vec<f64>])) -> Augmented {
        let mut norms = self.of_rows(vec![0.0; self.pattern.rows]);
        let fronts: Vec<(&Front, &Part)> = self.pattern.fronts.iter().zip(&self.parts).collect();
        for block in fronts.chunk_by(|_, (next, _)| !next.begins) {
            let mut staying: Vec<Vec<f64>> = Vec::new();
            for (front, part) in block.iter().rev() {
                // rows of `part` times F, with F F' the covariance in the basis of T
                let mut columns = self.front_factor(front.columns.len(), front.leaving, &staying);
                for column in &mut columns {
                    column.resize(part.rows, 0.0);
                    part.reflect_back(column);
                }
                let signs: Vec<f64> = front.columns.iter().map(|d| self.sign(*d)).collect();
                let square = |i: usize| columns.iter().zip(&signs).map(|(c, sign)| sign * c[i] * c[i]).sum::<f64>();
                let own = front.entering.iter().enumerate();
                own.for_each(|(i, d)| norms.deviations[*d] = self.sign(*d) * square(part.carried + i));
                let after = part.carried + front.entering.len();
                front.rows.iter().enumerate().for_each(|(i, row)| norms.rows[*row] = square(after + i));
                // the Gram matrix of the carried rows goes to the front before
                let gram = |a: usize, b: usize| columns.iter().map(|c| c[a] * c[b]).sum();
                staying = (0..part.carried).map(|a| (0..part.carried).map(|b| gram(a, b)).collect()).collect();
                visit(front, &columns);
            }
        }
        norms
    }

    /// Columns whose Gram matrix is the identity for what leaves and `staying` for what stays.
    fn front_factor(&self, n: usize, leaving: usize, staying: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut columns: Vec<Vec<f64>> =
            (0..leaving).map(|j| (0..n).map(|i| f64::from(u8::from(i == j))).collect()).collect();
        let k = staying.len();
        let mut lower = vec![vec![0.0; k]; k];
        for j in 0..k {
            let own: f64 = staying[j][j] - (0..j).map(|c| lower[j][c] * lower[j][c]).sum::<f64>();
            lower[j][j] = own.max(0.0).sqrt();
            for i in j + 1..k {
                let rest = staying[i][j] - (0..j).map(|c| lower[i][c] * lower[j][c]).sum::<f64>();
                lower[i][j] = if lower[j][j] > 0.0 { rest / lower[j][j] } else { 0.0 };
            }
        }
        columns.extend((0..k).map(|j| {
            let mut column = vec![0.0; n];
            column[leaving..].iter_mut().zip(&lower).for_each(|(slot, row)| *slot = row[j]);
            column
        }));
        columns
    }
}
