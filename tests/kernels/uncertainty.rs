//! Incomplete beta and gamma functions.

#[path = "../../src/uncertainty/quantiles.rs"]
pub(crate) mod quantiles;
#[path = "../../src/uncertainty/tails.rs"]
mod tails;

use tails::{beta, gamma};

#[test]
fn closed_forms() {
    // I_x(1, b) = 1 - (1 - x)^b; P(1, x) = 1 - exp(-x); both tails, near and far.
    for (b, x) in [(1.0_f64, 0.3_f64), (7.5, 0.01), (7.5, 0.9), (3e5, 1e-5), (3e5, 1e-3)] {
        let tails = beta(1.0, b, x, 1.0 - x);
        let upper = (b * (-x).ln_1p()).exp();
        assert!((tails.upper / upper - 1.0).abs() < 1e-12 || upper < 1e-300, "{b} {x}: {tails:?}");
        assert!((tails.lower / -(b * (-x).ln_1p()).exp_m1() - 1.0).abs() < 1e-12, "{b} {x}: {tails:?}");
    }
    for x in [1e-9, 0.5, 1.9, 2.1, 30.0, 600.0_f64] {
        let tails = gamma(1.0, x);
        assert!((tails.upper / (-x).exp() - 1.0).abs() < 1e-13 * x.max(1.0), "{x}: {tails:?}");
        assert!((tails.lower / -(-x).exp_m1() - 1.0).abs() < 1e-14, "{x}: {tails:?}");
    }
}
