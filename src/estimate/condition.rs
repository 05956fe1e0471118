//! Condition number of the scaled triangle.

use faer::Mat;

/// `sigma_max / sigma_min` in the 2-norm by one-sided Jacobi rotations; `None` for an empty matrix.
///
/// G. H. Golub, C. F. Van Loan, Matrix Computations, 8.6.3. The singular values come out to about 1e-8 relative, which is
/// more than a condition number needs.
pub(super) fn condition(r: &Mat<f64>) -> Option<f64> {
    let n = r.ncols();
    if n == 0 {
        return None;
    }
    // rows instead of columns: the same singular values, and the rows of a pivoted triangle are nearer to orthogonal
    let mut entries: Vec<f64> = (0..n).flat_map(|i| (0..n).map(move |j| r[(i, j)])).collect();
    for _ in 0..30 {
        let mut largest_cosine = 0.0_f64;
        for j in 1..n {
            let (left, right) = entries.split_at_mut(j * n);
            let Some(b) = right.get_mut(..n) else { continue };
            for a in left.chunks_exact_mut(n) {
                largest_cosine = largest_cosine.max(orthogonalise(a, b));
            }
        }
        if largest_cosine < 1e-5 {
            break;
        }
    }
    let norms = entries.chunks_exact(n).map(|column| dot(column, column).sqrt());
    let (least, most) = norms.fold((f64::INFINITY, 0.0_f64), |(least, most), s| (least.min(s), most.max(s)));
    (least > 0.0).then(|| most / least)
}

/// Rotates two columns into orthogonal ones; returns the cosine between them before.
fn orthogonalise(a: &mut [f64], b: &mut [f64]) -> f64 {
    let (aa, bb, ab) = (dot(a, a), dot(b, b), dot(a, b));
    let cosine = ab.abs() / (aa * bb).sqrt();
    if cosine.is_nan() || cosine <= 1e-9 {
        return 0.0;
    }
    let zeta = (bb - aa) / (2.0 * ab);
    // an infinite square is a rotation by nothing
    let t = zeta.signum() / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
    let c = (1.0 + t * t).sqrt().recip();
    let s = c * t;
    for (a, b) in a.iter_mut().zip(b) {
        (*a, *b) = (c * *a - s * *b, s * *a + c * *b);
    }
    cosine
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_triangle_known_in_closed_form() {
        // [[1, 1], [0, 1]]: singular values are the golden ratio and its reciprocal.
        let r = Mat::from_fn(2, 2, |i, j| if i <= j { 1.0 } else { 0.0 });
        let golden: f64 = (1.0 + 5.0_f64.sqrt()) / 2.0;
        assert!((condition(&r).unwrap() / golden.powi(2) - 1.0).abs() < 1e-9);
        assert_eq!(condition(&Mat::new()), None);
    }
}
