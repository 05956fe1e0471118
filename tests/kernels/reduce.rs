//! Uncertainty of means of correlated samples, by innovations.

#[path = "../../src/reduce/innovations.rs"]
mod innovations;

use innovations::{FLICKER_ALLAN, Process, flicker, markov, markov_mean};

#[test]
fn innovations_solve_the_covariance() {
    let covariance = markov(4, 2.0);
    let process = Process::new(&covariance).unwrap();
    let p = process.products(&[1.0, -1.0, 2.0, 0.5]);
    let matrix = faer::Mat::from_fn(4, 4, |i, j| covariance[i.abs_diff(j)]);
    let x = faer::mat![[1.0], [-1.0], [2.0], [0.5]];
    use faer::linalg::solvers::Solve;
    let solved = matrix.partial_piv_lu().solve(&x);
    let exact: f64 = (0..4).map(|i| x[(i, 0)] * solved[(i, 0)]).sum();
    assert!((p.xx - exact).abs() < 1e-12 * exact.abs());
    assert!((p.log - matrix.determinant().ln()).abs() < 1e-12);
}

#[test]
fn means_of_blocks_are_means_of_halves() {
    // the mean over two blocks from the blocks' covariances
    let c = markov(2, 3.0);
    assert!((0.5 * (c[0] + c[1]) - markov_mean(2.0, 3.0)).abs() < 1e-12);
    // half the variance of the difference of neighbours
    let f = flicker(2);
    assert!((f[0] - f[1] - FLICKER_ALLAN).abs() < 1e-12);
}
