//! Folds of parts of the rows: joined, and sent from one process to another.
#![allow(
    clippy::indexing_slicing,
    reason = "the triangle is square, so column j has more than j entries; `unpack` compares the length of what it is given with the triangle's first"
)]

use super::fold::triangle;
use super::{Fold, panel};
use crate::error::{Fault, Malformed, Result};
use crate::number;
use faer::Mat;

impl Fold {
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
            next = triangle(Mat::from_fn(2 * size, size, |i, j| match i.checked_sub(size) {
                None => self.triangle[(i, j)],
                Some(i) => below[(i, j)],
            }));
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
