//! Uncertainty of means of correlated samples, by innovations.

#[path = "../../src/reduce/innovations.rs"]
mod innovations;

use innovations::{FLICKER_ALLAN, Process, flicker, markov_lags, markov_mean};

/// Covariance of white noise of variance one and a Markov process of `size` times that, in means over blocks of length one: by the integral over two blocks.
fn covariance(count: usize, size: f64, tau: f64) -> Vec<f64> {
    let part = tau * (1.0 - (-1.0 / tau).exp());
    let own = 2.0 * tau - 2.0 * tau * tau * (1.0 - (-1.0 / tau).exp());
    let of =
        |lag: usize| if lag == 0 { 1.0 + size * own } else { size * part * part * (-(lag as f64 - 1.0) / tau).exp() };
    (0..count).map(of).collect()
}

#[test]
fn innovations_solve_the_covariance() {
    let values = [1.0, -1.0, 2.0, 0.5];
    // rounding, times the condition number of the covariance: 1, 5, 60 and 2e7
    for (size, tau, rounding) in [(0.0, 1.0, 1e-14), (1.0, 2.0, 1e-13), (30.0, 0.5, 1e-12), (1e5, 40.0, 1e-8)] {
        let covariance = covariance(4, size, tau);
        let matrix = faer::Mat::from_fn(4, 4, |i, j| covariance[i.abs_diff(j)]);
        let columns = faer::Mat::from_fn(4, 3, |i, j| [values[i], 1.0, i as f64][j]);
        use faer::linalg::solvers::Solve;
        let exact = columns.transpose() * matrix.partial_piv_lu().solve(&columns);
        let near = |a: f64, b: f64| assert!((a - b).abs() < rounding * (1.0 + b.abs()), "{a} {b} ({size}, {tau})");
        // by the recursion of neighbours, and by weights of each order
        for process in [Process::markov(4, size, tau).unwrap(), Process::new(&covariance).unwrap()] {
            let p = process.products(&values);
            near(p.xx, exact[(0, 0)]);
            near(p.x1, exact[(0, 1)]);
            near(p.xt, exact[(0, 2)]);
            near(p.one, exact[(1, 1)]);
            near(p.t1, exact[(1, 2)]);
            near(p.tt, exact[(2, 2)]);
            near(p.log, matrix.determinant().ln());
            assert_eq!(process.log(4), p.log);
        }
    }
}

#[test]
fn means_of_blocks_are_means_of_halves() {
    // the mean over two blocks from the blocks' covariances
    let (c, _) = markov_lags(3.0);
    assert!((0.5 * (c[0] + c[1]) - markov_mean(2.0, 3.0)).abs() < 1e-12);
    // half the variance of the difference of neighbours
    let f = flicker(2);
    assert!((f[0] - f[1] - FLICKER_ALLAN).abs() < 1e-12);
}
