//! Covariances of Allan variances.

#[path = "../../src/noise/cells.rs"]
mod cells;
#[path = "../../src/noise/covariance.rs"]
mod covariance;
#[path = "../../src/noise/ladder.rs"]
mod ladder;

use cells::Cells;
use covariance::{covariance, gram};
use ladder::Sums;

/// White noise: 2/edf with edf = (3 (N - 1)/(2 m) - 2 (N - 2)/N) 4 m^2/(4 m^2 + 5), N phases (NIST SP 1065, 5.4.1).
#[test]
fn on_the_diagonal_stand_the_degrees_of_freedom() {
    let samples = 20_000_u64;
    let at = |m: u64| {
        let positions = samples + 1 - 2 * m;
        Sums { m, positions, allan: (0.0, positions), missing: [positions as f64; 5], ..Sums::default() }
    };
    let all: Vec<Sums> = (0..11).map(|k| at(1 << k)).collect();
    for m in [1_u64, 4, 16] {
        let variance = covariance(&gram(&at(m), &at(m), &all, &Cells::default()), [0.0, 1.0, 0.0, 0.0]);
        let (m, n) = (m as f64, samples as f64 + 1.0);
        let edf = (1.5 * (n - 1.0) / m - 2.0 * (n - 2.0) / n) * 4.0 * m * m / (4.0 * m * m + 5.0);
        let ours = 2.0 / (m * m * variance);
        assert!((ours / edf - 1.0).abs() < 0.01, "{m}: {ours} {edf}");
    }
}
