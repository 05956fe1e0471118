//! Many observations of one design: their solutions by products.
#![allow(
    clippy::indexing_slicing,
    reason = "the observations are a multiple of the rows, and blocks of unknowns end where these end; both are asked before any is read"
)]

use super::Factor;
use crate::error::{Fault, Malformed, Result};
use pulp::{Arch, Simd, WithSimd};

/// Sets of observations that are worked on together.
const TOGETHER: usize = 4;
/// Unknowns of a block.
const WIDE: usize = 8;

impl Factor {
    /// Least-squares solutions, one after the other, for many sets of observations, `m` numbers each (not weighted): [`Factor::solve`] of each, but
    /// for rounding times the condition number.
    ///
    /// `x = (A' W^2 A)^-1 A' W^2 y`, the matrix worked out once. Errors: a number of observations that is no multiple of the rows.
    ///
    /// ```
    /// use tumble::estimate::{Group, Settings, System, adjust};
    /// let system = System {
    ///     rows: faer::mat![[1.0, 0.0], [1.0, 1.0], [1.0, 2.0]],
    ///     observed: vec![0.0; 3],
    ///     u: vec![1.0; 3],
    ///     group: vec![Group::Known; 3],
    /// };
    /// let factor = adjust(&system, &Settings::default())?.factor;
    /// let lines = factor.solve_many(&[1.0, 3.0, 4.0, 0.0, 1.0, 2.0])?;
    /// assert!((lines[1] - 1.5).abs() < 1e-14 && (lines[3] - 1.0).abs() < 1e-14);
    /// # Ok::<(), tumble::error::Malformed>(())
    /// ```
    pub fn solve_many(&self, observed: &[f64]) -> Result<Vec<f64>> {
        let sensitivities = self.sensitivities();
        let (n, m) = sensitivities.shape();
        if m == 0 || !observed.len().is_multiple_of(m) {
            return Err(Malformed::new(Fault::Value, "the observations do not fit the system")
                .expected(format!("a multiple of {m}"))
                .found(observed.len().to_string()));
        }
        let mut solutions = vec![0.0; observed.len() / m * n];
        for first in (0..n).step_by(WIDE) {
            let here = WIDE.min(n - first);
            let mut follow = vec![[0.0; WIDE]; m];
            for (i, row) in follow.iter_mut().enumerate() {
                row[..here].copy_from_slice(&sensitivities.col_as_slice(i)[first..first + here]);
            }
            let solutions = &mut solutions;
            Arch::new().dispatch(Products { follow: &follow, observed, solutions, n, first, here });
        }
        Ok(solutions)
    }
}

struct Products<'a> {
    follow: &'a [[f64; WIDE]],
    observed: &'a [f64],
    solutions: &'a mut [f64],
    n: usize,
    first: usize,
    here: usize,
}

impl WithSimd for Products<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Products { follow, observed, solutions, n, first, here } = self;
        let m = follow.len();
        let (rows, _) = S::as_simd_f64s(follow.as_flattened());
        let width = WIDE / S::F64_LANES;
        if width == 0 || width > WIDE {
            return;
        }
        let sets = observed.chunks(TOGETHER * m).zip(solutions.chunks_mut(TOGETHER * n));
        for (sets, to) in sets {
            let last = sets.len() / m - 1;
            let own: [&[f64]; TOGETHER] = std::array::from_fn(|d| &sets[d.min(last) * m..][..m]);
            let mut sums = [[simd.splat_f64s(0.0); WIDE]; TOGETHER];
            for (i, row) in rows.chunks_exact(width).enumerate().take(m) {
                for (sums, own) in sums.iter_mut().zip(own) {
                    let y = simd.splat_f64s(own[i]);
                    for (sum, p) in sums.iter_mut().zip(row) {
                        *sum = simd.mul_add_f64s(*p, y, *sum);
                    }
                }
            }
            for (sums, to) in sums.iter().zip(to.chunks_exact_mut(n)) {
                let mut found = [[0.0; WIDE]; 1];
                let (slots, _) = S::as_mut_simd_f64s(found.as_flattened_mut());
                slots.iter_mut().zip(sums).for_each(|(slot, sum)| *slot = *sum);
                to[first..first + here].copy_from_slice(&found[0][..here]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::estimate::{Group, Settings, System, adjust};
    use faer::Mat;

    /// Eleven sets of observations of a design with ten unknowns, one of them dependent: the solutions of each set by itself.
    #[test]
    fn many_are_each_by_itself() {
        let number = |i: usize, j: usize| ((i * i * 31 + j * 17 + i * j * 7 + 1) as f64 * 0.37).sin();
        let (m, n) = (17, 10);
        let system = System {
            rows: Mat::from_fn(m, n, |i, j| number(i, if j == 9 { 2 } else { j })),
            observed: vec![0.0; m],
            u: (0..m).map(|i| 1.0 + number(i, 5).powi(2)).collect(),
            group: vec![Group::Known; m],
        };
        let factor = adjust(&system, &Settings::default()).unwrap().factor;
        let observed: Vec<f64> = (0..11 * m).map(|k| number(k, 3)).collect();
        let found = factor.solve_many(&observed).unwrap();
        for (own, x) in observed.chunks_exact(m).zip(found.chunks_exact(n)) {
            for (a, b) in factor.solve(own).unwrap().iter().zip(x) {
                assert!((a - b).abs() < 1e-12, "{a} {b}");
            }
        }
        assert!(factor.solve_many(&observed[1..]).is_err());
        assert!(factor.solve_many(&[]).unwrap().is_empty());
    }
}
