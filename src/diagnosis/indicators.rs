//! Columns of ones at some rows (a bad reading, the rows of a label, a tail in time) compared with the model without being made.
//!
//! ```text
//! c = sum of e_i over rows R,   c' . r = sum b_i,   |c'|^2 = c'V^-1 c - |sum a_i|^2        b = W'r,  a_i: row i of W'Q, of independent rows W = diag(w)
//! ```

use super::noise::Weighted;
use crate::elements::Elements;
use crate::linear::{dot, norm};

/// A model, and further directions, as sensitivities of its readings.
pub(super) struct Indicators<'a> {
    weighted: &'a Weighted,
    /// Orthonormal, of independent rows, and what is left of the readings there.
    white: Vec<Vec<f64>>,
    left: Vec<f64>,
    directions: Vec<Vec<f64>>,
    residual: Vec<f64>,
    /// Diagonal of `V^-1`, where rows are not independent.
    diagonal: Option<Vec<f64>>,
}

/// The sums over the rows of one column.
#[derive(Clone)]
pub(super) struct Sums {
    square: f64,
    product: f64,
    along: Vec<f64>,
    /// The rows, where they are not independent.
    rows: Vec<usize>,
}

impl<'a> Indicators<'a> {
    /// With the model, and some columns (not weighted, `m` each).
    pub fn new(weighted: &'a Weighted, given: &[&Vec<f64>]) -> Self {
        let q = weighted.estimate.factor.thin_q();
        let white: Vec<Vec<f64>> = (0..q.ncols()).map(|k| q.col(k).iter().copied().collect()).collect();
        let diagonal = weighted.floor.as_ref().map(|floor| {
            let whitening = floor.whitening();
            let alone = whitening.redundancies(faer::Mat::zeros(weighted.weight.len(), 0).as_ref());
            alone.iter().zip(whitening.sd()).map(|(left, sd)| left / (sd * sd)).collect()
        });
        let directions = white.iter().map(|direction| weighted.carry_back(direction)).collect();
        let left = weighted.residual.clone();
        let residual = weighted.carry_back(&left);
        let mut indicators = Indicators { weighted, white, left, directions, residual, diagonal };
        given.iter().for_each(|column| indicators.give(column));
        indicators
    }

    /// One column more (not weighted, `m`) in the model.
    pub fn give(&mut self, column: &[f64]) {
        let largest = column.iter().fold(f64::MIN_POSITIVE, |largest, v| largest.max(v.abs()));
        let scaled: Vec<f64> = column.iter().map(|v| v / largest).collect();
        let mut direction = self.weighted.whiten(&scaled);
        let before = norm(&direction);
        (0..2).for_each(|_| crate::linear::project(&mut direction, &self.white));
        let size = norm(&direction);
        if size > super::VISIBLE * before {
            direction.iter_mut().for_each(|v| *v /= size);
            let along = dot(&direction, &self.left);
            self.left.iter_mut().zip(&direction).for_each(|(r, d)| *r -= along * d);
            self.residual = self.weighted.carry_back(&self.left);
            self.directions.push(self.weighted.carry_back(&direction));
            self.white.push(direction);
        }
    }

    /// A column of no rows.
    pub fn none(&self) -> Sums {
        Sums { square: 0.0, product: 0.0, along: vec![0.0; self.directions.len()], rows: Vec::new() }
    }

    /// One row more.
    pub fn add(&self, i: usize, sums: &mut Sums) {
        match self.diagonal {
            Some(_) => sums.rows.push(i),
            None => sums.square += self.weighted.weight.at(i) * self.weighted.weight.at(i),
        }
        sums.product += self.residual.at(i);
        for (sum, direction) in sums.along.iter_mut().zip(&self.directions) {
            *sum += direction.at(i);
        }
    }

    /// What `size` times the difference of two single rows takes off the sum of squares: `2 s c'r - s^2 |c'|^2`. Rows that are not independent count
    /// as if they were.
    pub fn fall_with(&self, one: &Sums, two: &Sums, size: f64) -> f64 {
        let along: f64 = one.along.iter().zip(&two.along).map(|(a, b)| (a - b) * (a - b)).sum();
        let left = (self.square(one) + self.square(two) - along).max(0.0);
        2.0 * size * (one.product - two.product) - size * size * left
    }

    /// Score of a column, its square the drop of the sum of squares; 0 for one that the model absorbs.
    pub fn score(&self, sums: &Sums) -> f64 {
        let square = self.square(sums);
        let left = square - sums.along.iter().map(|a| a * a).sum::<f64>();
        if left > 1e-10 * square { sums.product / left.sqrt() } else { 0.0 }
    }

    /// `c' V^-1 c`.
    fn square(&self, sums: &Sums) -> f64 {
        match (&self.diagonal, sums.rows.as_slice()) {
            (None, _) => sums.square,
            (Some(diagonal), [row]) => diagonal.at(*row),
            (Some(_), rows) => {
                let mut column = vec![0.0; self.weighted.weight.len()];
                for row in rows {
                    column.iter_mut().skip(*row).take(1).for_each(|v| *v = 1.0);
                }
                self.weighted.squares(&column)
            }
        }
    }
}
