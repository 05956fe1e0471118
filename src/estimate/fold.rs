//! The same estimate from rows that come in blocks: memory depends on the unknowns, not on the readings.
#![allow(
    clippy::indexing_slicing,
    reason = "`System::check` compares observed and u with the rows before they are used; the triangle has `unknowns + carried + 1` columns, square, from the constructor on; `unpack` compares the length of what it is given with it first"
)]

use super::compensated::accumulate;
use super::factor::{Factor, Unknowns};
use super::pivoted::substitute;
use super::{Group, Settings, System, panel};
use crate::error::{Fault, Malformed, Result};
use crate::linear::short_dot;
use crate::number;
use faer::{Mat, MatRef};

/// Rows folded into the triangle of `W [A C y - A a] = Q [R S z; 0 T t; 0 0 rho]`.
///
/// `C` are columns that are carried along (none, unless asked for).
/// The point `a` is what the first block (128 rows of it, evenly spread) says of the unknowns, or zero where it says too little; observations are taken
/// about it, in twice the working
/// precision, so that small residuals of large readings keep their digits. Folds of parts of the rows are joined by [`Fold::merge`].
///
/// ```
/// use tumble::estimate::{Fold, Group, Settings};
/// let mut fold = Fold::new(1);
/// for reading in [1.0, 2.0, 6.0] {
///     fold.push(faer::mat![[1.0]].as_ref(), &[reading], &[1.0])?;
/// }
/// let mean = fold.finish(Group::Estimated(0), &Settings::default())?;
/// assert!((mean.unknowns.solution[0] - 3.0).abs() < 1e-14 && (mean.sum_of_squares - 14.0).abs() < 1e-13);
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
#[derive(Debug, Clone)]
pub struct Fold {
    triangle: Mat<f64>,
    unknowns: usize,
    /// The point about which observations are taken; empty where none is known yet.
    about: Vec<f64>,
    rows: usize,
}

/// An estimate without what belongs to single rows.
#[derive(Debug, Clone)]
pub struct Folded {
    /// What the rows say of the unknowns; the covariance with the scale.
    pub unknowns: Unknowns,
    /// `sum (v/u)^2`.
    pub sum_of_squares: f64,
    /// Rows folded.
    pub rows: usize,
    /// Rows minus rank.
    pub dof: usize,
    /// The estimated scale, `None` where `u` is known or there are no degrees of freedom.
    pub scale: Option<f64>,
}

impl Fold {
    /// Nothing folded yet, for `unknowns` columns.
    pub fn new(unknowns: usize) -> Self {
        Fold::carrying(unknowns, 0)
    }

    /// The same with further columns that are carried along, behind those of the unknowns.
    pub(crate) fn carrying(unknowns: usize, columns: usize) -> Self {
        let size = unknowns + columns + 1;
        Fold { triangle: Mat::zeros(size, size), unknowns, about: Vec::new(), rows: 0 }
    }

    /// Columns that are unknowns; what is carried along follows.
    pub(super) fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Rows folded so far.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Folds a block of rows, `k x n` (and the columns that are carried along), with their observed values and standard uncertainties, `k` each.
    ///
    /// Errors as [`super::adjust`]; a refused block leaves the fold as it was. Blocks of a hundred rows and more cost least.
    pub fn push(&mut self, rows: MatRef<'_, f64>, observed: &[f64], u: &[f64]) -> Result<()> {
        let size = self.triangle.ncols();
        let (k, n) = rows.shape();
        if n + 1 != size {
            return Err(Malformed::new(Fault::Value, "a block of rows has the wrong number of columns")
                .expected((size - 1).to_string())
                .found(n.to_string()));
        }
        let point = if self.rows == 0 { sampled(rows, observed, u, self.unknowns) } else { None };
        let about = point.as_deref().unwrap_or(&self.about);
        let mut next = self.triangle.clone();
        if panel::fold(&mut next, rows, observed, u, about).is_none() {
            next = self.careful(rows, observed, u)?;
        } else if let Some(point) = point {
            self.about = point;
        }
        self.triangle = next;
        self.rows += k;
        Ok(())
    }

    /// The triangle with a block of rows whose numbers are no plain ones: refused, or by the general factorisation, which scales them.
    fn careful(&self, rows: MatRef<'_, f64>, observed: &[f64], u: &[f64]) -> Result<Mat<f64>> {
        let (k, size) = (rows.nrows(), self.triangle.ncols());
        // said with the place and in the words of a system
        let system = System::known(rows.to_owned(), observed.to_vec(), u.to_vec());
        system.check()?;
        let System { observed, u, .. } = system;
        let observed = about(rows, &observed, &self.about);
        let below = |i: usize, j: usize| match i.checked_sub(size) {
            None => self.triangle[(i, j)],
            Some(i) if j + 1 < size => rows[(i, j)] / u[i],
            Some(i) => observed[i] / u[i],
        };
        let all = (0..size).flat_map(|j| (0..size + k).map(move |i| (i, j)));
        let largest = all.fold(0.0_f64, |most, (i, j)| most.max(below(i, j).abs()));
        if largest > 1e150 {
            return Err(Malformed::new(
                Fault::Value,
                "a folded row, divided by its standard uncertainty, is too large",
            )
            .expected("units in which numbers stay below 1e150"));
        }
        Ok(triangle_of(size + k, size, below))
    }

    /// A point near which the observations of the triangle lie: its solution, unless terms of that cancel.
    fn point(&self) -> Option<Vec<f64>> {
        let (n, last) = (self.unknowns, self.triangle.ncols() - 1);
        let observed = self.triangle.col_as_slice(last);
        let point = match self.substituted() {
            Some(point) => point,
            // columns that depend on others: the solution of those that do not
            None => self.finish(Group::Known, &Settings::default()).ok()?.unknowns.solution,
        };
        let size = short_dot(observed, observed).sqrt();
        let small = |(j, x): (usize, &f64)| {
            let column = &self.triangle.col_as_slice(j)[..n];
            x.abs() * short_dot(column, column).sqrt() <= MOST_TERM * size
        };
        point.iter().enumerate().all(small).then_some(point)
    }

    /// The solution of the triangle by substitution, where no column is nearly one of those before it.
    fn substituted(&self) -> Option<Vec<f64>> {
        let (n, last) = (self.unknowns, self.triangle.ncols() - 1);
        let stands_out = |k: usize| {
            let column = &self.triangle.col_as_slice(k)[..=k];
            let own = column[k].abs();
            own > 1e-6 * column.iter().fold(own, |most, r| most.max(r.abs()))
        };
        let mut point = (0..n).all(stands_out).then(|| self.triangle.col_as_slice(last)[..n].to_vec())?;
        substitute(&self.triangle, &mut point);
        point.iter().all(|x| x.is_finite()).then_some(point)
    }

    /// The triangle of all rows so far, square: it has the inner products of the weighted columns, and of the observations about [`Fold::about`].
    pub(crate) fn triangle(&self) -> MatRef<'_, f64> {
        self.triangle.as_ref()
    }

    /// The point about which observations are taken; empty for zero.
    pub(crate) fn about(&self) -> &[f64] {
        &self.about
    }

    /// The estimate from all rows so far; `group` says whether their uncertainties are known or relative.
    pub fn finish(&self, group: Group, settings: &Settings) -> Result<Folded> {
        let (n, last) = (self.unknowns, self.triangle.ncols() - 1);
        let rows = self.triangle.get(..n, ..n);
        let observed = self.triangle.col_as_slice(last);
        let z = observed[..n].to_vec();
        let factor = Factor::new(rows, vec![1.0; n], self.rows, settings.rank_tolerance)?;
        let mut fit = factor.refined(rows, &z, settings.refinements);
        let rest = observed[n..].iter().chain(&fit.residuals);
        let sum_of_squares = rest.map(|v| v * v).sum::<f64>();
        fit.solution.iter_mut().zip(&self.about).for_each(|(x, about)| *x += about);
        let dof = self.rows.saturating_sub(factor.rank());
        let scale = match group {
            Group::Estimated(_) if dof > 0 => Some((sum_of_squares / dof as f64).sqrt()),
            _ => None,
        };
        let variance = if scale.is_some() { sum_of_squares / dof as f64 } else { 1.0 };
        let determined = group == Group::Known || scale.is_some();
        Ok(Folded {
            unknowns: Unknowns::new(&factor, fit.solution, variance, |_| determined),
            sum_of_squares,
            rows: self.rows,
            dof,
            scale,
        })
    }

    /// Joins the rows that another fold has taken: a QR of one triangle above the other.
    ///
    /// Errors: a fold of other columns.
    ///
    /// ```
    /// use tumble::estimate::{Fold, Group, Settings};
    /// let (mut one, mut other) = (Fold::new(1), Fold::new(1));
    /// one.push(faer::mat![[1.0], [1.0]].as_ref(), &[1.0, 2.0], &[1.0; 2])?;
    /// other.push(faer::mat![[1.0]].as_ref(), &[6.0], &[1.0])?;
    /// one.merge(&Fold::unpack(1, 0, &other.pack())?)?;
    /// let mean = one.finish(Group::Estimated(0), &Settings::default())?;
    /// assert!((mean.unknowns.solution[0] - 3.0).abs() < 1e-14 && (mean.sum_of_squares - 14.0).abs() < 1e-13);
    /// # Ok::<(), tumble::error::Malformed>(())
    /// ```
    pub fn merge(&mut self, other: &Fold) -> Result<()> {
        let (size, n) = (self.triangle.ncols(), self.unknowns);
        if other.triangle.ncols() != size || other.unknowns != n {
            return Err(Malformed::new(Fault::Value, "folds of other columns cannot be joined")
                .expected(format!("{n} unknowns, {} columns", size - 1))
                .found(format!("{} unknowns, {} columns", other.unknowns, other.triangle.ncols() - 1)));
        }
        if other.rows == 0 {
            return Ok(());
        }
        if self.rows == 0 {
            *self = other.clone();
            return Ok(());
        }
        if self.about.is_empty() && !other.about.is_empty() {
            shift(&mut self.triangle, &vec![0.0; n], &other.about);
            self.about.clone_from(&other.about);
        }
        let mut below = other.triangle.clone();
        if !self.about.is_empty() {
            let zero = vec![0.0; n];
            shift(&mut below, if other.about.is_empty() { &zero } else { &other.about }, &self.about);
        }
        let (columns, observed) = (below.subcols(0, size - 1), below.col_as_slice(size - 1));
        let mut next = self.triangle.clone();
        if panel::fold(&mut next, columns, observed, &vec![1.0; size], &[]).is_none() {
            next = triangle_of(2 * size, size, |i, j| match i.checked_sub(size) {
                None => self.triangle[(i, j)],
                Some(i) => below[(i, j)],
            });
        }
        self.triangle = next;
        self.rows += other.rows;
        Ok(())
    }

    /// The fold as numbers, for [`Fold::unpack`]: rows, the point (its length first), the triangle column by column without what is below its diagonal.
    pub fn pack(&self) -> Vec<f64> {
        let size = self.triangle.ncols();
        let mut numbers = Vec::with_capacity(2 + self.about.len() + size * (size + 1) / 2);
        numbers.extend([self.rows as f64, self.about.len() as f64]);
        numbers.extend_from_slice(&self.about);
        (0..size).for_each(|j| numbers.extend_from_slice(&self.triangle.col_as_slice(j)[..=j]));
        numbers
    }

    /// The fold that was packed, with as many unknowns and carried columns. Errors: numbers that are no such fold.
    pub fn unpack(unknowns: usize, columns: usize, packed: &[f64]) -> Result<Fold> {
        let mut fold = Fold::carrying(unknowns, columns);
        let size = unknowns + columns + 1;
        // too short: no parts, refused below
        let (head, rest) = packed.split_at_checked(2).unwrap_or_default();
        let point = head.get(1).map_or(0, |length| number::count(*length));
        let whole = rest.len() == point.saturating_add(size * (size + 1) / 2) && (point == 0 || point == unknowns);
        if !whole || !packed.iter().all(|x| x.is_finite()) || !head.iter().all(|x| *x >= 0.0) {
            return Err(Malformed::new(Fault::Value, "these numbers are no packed fold")
                .expected(format!("finite numbers: rows, the point, a triangle of {size} columns"))
                .found(format!("{} numbers", packed.len())));
        }
        let (about, mut rest) = rest.split_at(point);
        fold.about = about.to_vec();
        fold.rows = head.first().map_or(0, |rows| number::count(*rows));
        for j in 0..size {
            let (own, after) = rest.split_at(j + 1);
            fold.triangle.col_as_slice_mut(j)[..=j].copy_from_slice(own);
            rest = after;
        }
        Ok(fold)
    }
}

/// Observations of a triangle from one point to another: `z + R (from - to)`.
fn shift(triangle: &mut Mat<f64>, from: &[f64], to: &[f64]) {
    let last = triangle.ncols() - 1;
    for (j, (from, to)) in from.iter().zip(to).enumerate() {
        for i in 0..=j {
            let change = triangle[(i, j)] * (from - to);
            triangle[(i, last)] += change;
        }
    }
}

/// Rows that say near which point the observations lie.
const SAMPLE: usize = 128;

/// What the first rows say of the unknowns, evenly spread over the block they come in; `None` where that is too little.
fn sampled(rows: MatRef<'_, f64>, observed: &[f64], u: &[f64], unknowns: usize) -> Option<Vec<f64>> {
    let (k, n) = rows.shape();
    let mut fold = Fold::carrying(unknowns, n - unknowns);
    if k <= SAMPLE {
        panel::fold(&mut fold.triangle, rows, observed, u, &[])?;
        fold.rows = k;
    } else {
        fold.rows = SAMPLE;
        let at = |i: usize| i * k / SAMPLE;
        let of = |from: &[f64]| -> Option<Vec<f64>> { (0..SAMPLE).map(|i| from.get(at(i)).copied()).collect() };
        let few = Mat::from_fn(SAMPLE, n, |i, j| rows[(at(i), j)]);
        panel::fold(&mut fold.triangle, few.as_ref(), &of(observed)?, &of(u)?, &[])?;
    }
    fold.point()
}

/// Observed values about a point: `y - A a` in twice the working precision.
fn about(rows: MatRef<'_, f64>, observed: &[f64], point: &[f64]) -> Vec<f64> {
    let (mut high, mut low) = (observed.to_vec(), vec![0.0; observed.len()]);
    let mut copied = Vec::new();
    for (j, x) in point.iter().enumerate() {
        let column = rows.col(j);
        let column = match column.try_as_col_major() {
            Some(column) => column.as_slice(),
            None => {
                copied.clear();
                copied.extend(column.iter());
                &copied
            }
        };
        accumulate(&mut high, &mut low, -x, column);
    }
    high.iter().zip(&low).map(|(high, low)| high + low).collect()
}

/// Terms of a point about which observations are taken are at most so many times as large as the observations.
const MOST_TERM: f64 = 8.0;

/// Rows that are made and folded at a time.
const BLOCK: usize = 1024;
/// Numbers below this share of the largest of their column add nothing to any sum of squares: their own squares are 1e-260 of its. They are zero, so that no
/// product of two of them falls among the numbers below 1e-308, which lose their digits.
const NOTHING: f64 = 1e-130;

/// The upper triangle `R`, `n x n`, of `m` rows that are made as they are needed, `[rows] = Q R`.
///
/// Columns whose squares would leave the range of a double are scaled by powers of two, which rounds nothing.
pub(super) fn triangle_of(m: usize, n: usize, element: impl Fn(usize, usize) -> f64) -> Mat<f64> {
    fn folded(m: usize, n: usize, element: impl Fn(usize, usize) -> f64) -> Option<Mat<f64>> {
        let (mut triangle, unit) = (Mat::zeros(n, n), vec![1.0; BLOCK.min(m)]);
        for start in (0..m).step_by(BLOCK) {
            let count = BLOCK.min(m - start);
            let rows = Mat::from_fn(count, n, |i, j| element(start + i, j));
            panel::fold(&mut triangle, rows.subcols(0, n - 1), rows.col_as_slice(n - 1), &unit[..count], &[])?;
        }
        Some(triangle)
    }
    if let Some(triangle) = folded(m, n, &element) {
        return triangle;
    }
    let largest = |j: usize| (0..m).fold(0.0_f64, |most, i| most.max(element(i, j).abs()));
    let size = |largest: f64| if largest > 0.0 { largest.log2().floor().exp2() } else { 1.0 };
    let sizes: Vec<f64> = (0..n).map(|j| size(largest(j))).collect();
    let scaled = |i: usize, j: usize| match element(i, j) / sizes[j] {
        share if share.abs() < NOTHING => 0.0,
        share => share,
    };
    // what is not finite has no triangle
    let triangle = folded(m, n, scaled).unwrap_or_else(|| Mat::from_fn(n, n, |_, _| f64::NAN));
    Mat::from_fn(n, n, |i, j| triangle[(i, j)] * sizes[j])
}
