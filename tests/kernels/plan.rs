//! Small matrices of the search for positions.

#[path = "../../src/plan/blocks.rs"]
mod blocks;

use blocks::{determinant_and_trace, invert};

#[test]
fn inverse_and_trace_of_small_matrices() {
    let (inverse, log_det) = invert(&[4.0, 2.0, 2.0, 3.0], 2).unwrap();
    for (found, expected) in inverse.iter().zip([0.375, -0.25, -0.25, 0.5]) {
        assert!((found - expected).abs() < 1e-15);
    }
    assert!((log_det - 8.0_f64.ln()).abs() < 1e-15);
    assert!(invert(&[1.0, 1.0, 1.0, 1.0], 2).is_none());
    // t^-1 = [[-2, 1], [1.5, -0.5]], so the trace of t^-1 f with f = [[1, 0], [2, 1]] is (-2 + 2) + (-0.5)
    let (det, trace) = determinant_and_trace(&mut [1.0, 2.0, 3.0, 4.0], &mut [1.0, 0.0, 2.0, 1.0], 2);
    assert!((det + 2.0).abs() < 1e-14 && (trace + 0.5).abs() < 1e-14);
}
