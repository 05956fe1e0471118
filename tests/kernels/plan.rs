//! Small matrices of the search for positions.

#[path = "../../src/plan/blocks.rs"]
mod blocks;

use blocks::{eliminate, invert, shares};

#[test]
fn inverse_and_trace_of_small_matrices() {
    let (inverse, log_det) = invert(&[4.0, 2.0, 2.0, 3.0], 2).unwrap();
    for (found, expected) in inverse.iter().zip([0.375, -0.25, -0.25, 0.5]) {
        assert!((found - expected).abs() < 1e-15);
    }
    assert!((log_det - 8.0_f64.ln()).abs() < 1e-15);
    assert!(invert(&[1.0, 1.0, 1.0, 1.0], 2).is_none());
    // t^-1 = [[-3, 2], [2, -1]], so the trace of t^-1 f with f = [[1, 2], [2, 7]] is (-3 + 4) + (4 - 7); packed by columns
    let (mut t, mut f) = ([1.0, 2.0, 3.0].map(|v| vec![v]), [1.0, 2.0, 7.0].map(|v| vec![v]));
    eliminate(&mut t, &mut f);
    let trace = f[0][0] / t[0][0] + f[2][0] / t[2][0];
    // the determinant is -1, with one negative pivot
    assert!((shares(&t, 1, 1)[0] - 1.0).abs() < 1e-14 && (trace + 2.0).abs() < 1e-14);
}
