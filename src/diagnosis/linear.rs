//! Small dense systems.

use faer::Mat;

/// A pivot below this says that the system is singular (systems here have diagonals near one).
const SINGULAR: f64 = 1e-6;

/// Gaussian elimination with pivoting of a small square system; `None` where it is nearly singular.
pub(super) fn solve(mut a: Mat<f64>, mut b: Vec<f64>) -> Option<Vec<f64>> {
    let n = b.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|i, j| a[(*i, k)].abs().total_cmp(&a[(*j, k)].abs()))?;
        if !(a[(pivot, k)].abs() > SINGULAR) {
            return None;
        }
        for j in 0..n {
            let held = a[(k, j)];
            a[(k, j)] = a[(pivot, j)];
            a[(pivot, j)] = held;
        }
        b.swap(k, pivot);
        for i in k + 1..n {
            let factor = a[(i, k)] / a[(k, k)];
            for j in k..n {
                a[(i, j)] -= factor * a[(k, j)];
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let rest: f64 = (k + 1..n).map(|j| a[(k, j)] * b[j]).sum();
        b[k] = (b[k] - rest) / a[(k, k)];
    }
    Some(b)
}
