//! What an effect rests on: one that a single position carries cannot be told from that position's remounting.

use super::evidence::Evidence;
use super::noise::{NoiseFrom, Weighted};
use crate::elements::Elements;
use crate::linear::dot;

/// What is needed to leave a position out.
pub(super) struct Support<'a> {
    pub weighted: &'a Weighted,
    /// Orthonormal basis of the model's rows, each by its weight alone.
    pub basis: faer::MatRef<'a, f64>,
    /// Columns of all candidates, not weighted.
    pub columns: &'a [&'a Vec<f64>],
    /// Position of each row.
    pub positions: &'a [usize],
    /// Share of its norm below which a column hangs on what was left out.
    pub hangs: f64,
}

impl Support<'_> {
    /// May a set of several effects be named? Where only the residuals tell the noise, at most one of them may hang on one position alone:
    /// readings of one position share what its mounting did, and the residuals cannot tell.
    pub fn is_enough(&self, evidence: &Evidence, set: &[usize]) -> bool {
        if evidence.from != NoiseFrom::Residuals {
            return true;
        }
        let hanging = (0..set.len()).filter(|place| self.hangs(set, *place)).count();
        hanging <= 1
    }

    /// Does a member become undetermined when some position is left out?
    fn hangs(&self, set: &[usize], place: usize) -> bool {
        let count = self.positions.iter().max().map_or(0, |p| p + 1);
        let full = self.left(set, place, None);
        (0..count).any(|position| self.left(set, place, Some(position)) < self.hangs * full)
    }

    /// Norm of a member's column outside the model and the other members, without the rows of one position.
    fn left(&self, set: &[usize], place: usize, without: Option<usize>) -> f64 {
        let q = self.basis;
        let kept = |i: usize| self.positions.get(i).copied() != without || without.is_none();
        let masked = |values: &mut dyn Iterator<Item = f64>| -> Vec<f64> {
            values.enumerate().map(|(i, v)| if kept(i) { v } else { 0.0 }).collect()
        };
        let column = |j: usize| {
            let own = self.columns.at(j);
            let largest = own.iter().fold(f64::MIN_POSITIVE, |largest, v| largest.max(v.abs()));
            masked(&mut own.iter().zip(&self.weighted.weight).map(|(v, w)| v / largest * w))
        };
        let mut basis: Vec<Vec<f64>> = Vec::new();
        let mut push = |mut vector: Vec<f64>| -> f64 {
            let size = dot(&vector, &vector).sqrt();
            for _ in 0..2 {
                for before in &basis {
                    let along = dot(before, &vector);
                    vector.iter_mut().zip(before).for_each(|(v, b)| *v -= along * b);
                }
            }
            let left = dot(&vector, &vector).sqrt();
            if left > 1e-9 * size {
                vector.iter_mut().for_each(|v| *v /= left);
                basis.push(vector);
            }
            left
        };
        for k in 0..q.ncols() {
            push(masked(&mut q.col(k).iter().copied()));
        }
        for (_, member) in set.iter().enumerate().filter(|(k, _)| *k != place) {
            push(column(*member));
        }
        set.get(place).map_or(0.0, |member| push(column(*member)))
    }
}
