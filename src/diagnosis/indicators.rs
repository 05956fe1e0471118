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
    /// Beside the model and some columns (not weighted, `m` each).
    pub fn new(weighted: &'a Weighted, given: &[&Vec<f64>]) -> Self {
        let q = weighted.estimate.factor.thin_q();
        let mut directions: Vec<Vec<f64>> = (0..q.ncols()).map(|k| q.col(k).iter().copied().collect()).collect();
        let mut residual = weighted.residual.clone();
        for column in given {
            let largest = column.iter().fold(f64::MIN_POSITIVE, |largest, v| largest.max(v.abs()));
            let scaled: Vec<f64> = column.iter().map(|v| v / largest).collect();
            let mut direction = weighted.whiten(&scaled);
            let before = norm(&direction);
            (0..2).for_each(|_| crate::linear::project(&mut direction, &directions));
            let size = norm(&direction);
            if size > super::VISIBLE * before {
                direction.iter_mut().for_each(|v| *v /= size);
                let along = dot(&direction, &residual);
                residual.iter_mut().zip(&direction).for_each(|(r, d)| *r -= along * d);
                directions.push(direction);
            }
        }
        let diagonal = weighted.floor.as_ref().map(|floor| {
            let whitening = floor.whitening();
            let alone = whitening.redundancies(faer::Mat::zeros(weighted.weight.len(), 0).as_ref());
            alone.iter().zip(whitening.sd()).map(|(left, sd)| left / (sd * sd)).collect()
        });
        directions.iter_mut().for_each(|direction| *direction = weighted.carry_back(direction));
        Indicators { weighted, residual: weighted.carry_back(&residual), directions, diagonal }
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

    /// Score of a column, its square the drop of the sum of squares; 0 for one that the model absorbs.
    pub fn score(&self, sums: &Sums) -> f64 {
        let square = match (&self.diagonal, sums.rows.as_slice()) {
            (None, _) => sums.square,
            (Some(diagonal), [row]) => diagonal.at(*row),
            (Some(_), rows) => {
                let mut column = vec![0.0; self.weighted.weight.len()];
                for row in rows {
                    column.iter_mut().skip(*row).take(1).for_each(|v| *v = 1.0);
                }
                self.weighted.squares(&column)
            }
        };
        let left = square - sums.along.iter().map(|a| a * a).sum::<f64>();
        if left > 1e-10 * square { sums.product / left.sqrt() } else { 0.0 }
    }
}
