//! Condition number of the scaled triangle.

use crate::linear::short_dot;
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
    // rows instead of columns: the same singular values, and the rows of a pivoted triangle are nearer to orthogonal; filled up with zeros
    let width = n.next_multiple_of(4);
    let mut entries = vec![0.0; n * width];
    for (i, row) in entries.chunks_exact_mut(width).enumerate() {
        row.iter_mut().enumerate().take(n).skip(i).for_each(|(j, entry)| *entry = r[(i, j)]);
    }
    let mut squares = vec![0.0; n];
    for _ in 0..30 {
        let mut largest_cosine = 0.0_f64;
        // rotations change them by what is known; in every sweep they are computed again
        for (square, row) in squares.iter_mut().zip(entries.chunks_exact(width)) {
            *square = short_dot(row, row);
        }
        for j in 1..n {
            let (left, right) = entries.split_at_mut(j * width);
            let (before, after) = squares.split_at_mut(j);
            let (Some(b), Some(bb)) = (right.get_mut(..width), after.first_mut()) else { continue };
            for (a, aa) in left.chunks_exact_mut(width).zip(before) {
                largest_cosine = largest_cosine.max(orthogonalise((a, aa), (&mut *b, &mut *bb)));
            }
        }
        if largest_cosine < 1e-5 {
            break;
        }
    }
    let norms = entries.chunks_exact(width).map(|column| short_dot(column, column).sqrt());
    let (least, most) = norms.fold((f64::INFINITY, 0.0_f64), |(least, most), s| (least.min(s), most.max(s)));
    (least > 0.0).then(|| most / least)
}

/// Rotates two rows into orthogonal ones, and their squared norms with them; returns the cosine between them before.
fn orthogonalise((a, aa): (&mut [f64], &mut f64), (b, bb): (&mut [f64], &mut f64)) -> f64 {
    let ab = short_dot(a, b);
    let square = ab * ab / (*aa * *bb);
    if !(square > 1e-18) {
        return 0.0;
    }
    let zeta = (*bb - *aa) / (2.0 * ab);
    // an infinite square is a rotation by nothing
    let t = zeta.signum() / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
    let c = (1.0 + t * t).sqrt().recip();
    let s = c * t;
    for (a, b) in a.iter_mut().zip(b) {
        (*a, *b) = (c * *a - s * *b, s * *a + c * *b);
    }
    (*aa, *bb) = (*aa - t * ab, *bb + t * ab);
    square.sqrt()
}
