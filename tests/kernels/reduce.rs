//! Uncertainty of means of correlated samples, by innovations.

#[path = "../../src/reduce/innovations.rs"]
mod innovations;

use innovations::{Levelless, Process, markov, markov_mean};

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
    for own in [Levelless::Flicker, Levelless::Walk] {
        let c = own.covariance(2);
        assert!((c[0] - c[1] - own.allan(1.0)).abs() < 1e-12, "{own:?}");
    }
    // a walk, its mean over [1, 3] less that over [0, 4]: the integral of the squared weights of its steps, 1/48 + 2/48 + 1/48; its Allan variance at two
    // blocks is more, 2/3. Over [0, 1] less [0, 4]: 3/16 + 9/16
    assert!((Levelless::Walk.level(1.0, 2.0, 4.0) - 2.0 / 3.0).abs() < 1e-12);
    assert!((Levelless::Walk.level(0.0, 1.0, 4.0) - 0.75).abs() < 1e-12);
}
