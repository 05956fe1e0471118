//! Patterns of the residuals in the order of time: runs, correlation of neighbours, differences between stretches of readings, and waves.
//!
//! ```text
//! P(k) = |sum v_i exp(-2 pi i k i / n)|^2 / (n/2 sum v_i^2),    p = (1 - P)^((n - 3) / 2)    A. Schuster 1898; R. Fisher, Proc. R. Soc. A 125 (1929), 54
//! ```

use super::remainder::in_time;
use crate::campaign::Campaign;
use crate::design::DesignMatrix;
use crate::quality::runs;
use crate::uncertainty::quantiles::{fisher_f_survival, normal_survival};

/// Fewest readings of a sensor for which anything is said.
const FEWEST: usize = 12;
/// Lengths of the stretches whose means are compared.
const STRETCHES: [usize; 3] = [4, 8, 16];

/// With more readings no waves are tried: the stretches see what is slow.
const LONGEST: usize = 4000;

/// The most significant pattern of any sensor.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Serial {
    /// What it is, in words.
    pub what: String,
    /// Probability of anything so strong by chance, over all sensors and tests (Bonferroni).
    pub p: f64,
}

/// Test standardised residuals, one for each row.
pub(super) fn serial(campaign: &Campaign, design: &DesignMatrix, residual: &[f64]) -> Option<Serial> {
    let mut tests: Vec<(f64, String)> = Vec::new();
    for (k, sensor) in campaign.bench.sensors.iter().enumerate() {
        let rows = in_time(campaign, design, k);
        let values: Vec<f64> = rows.iter().filter_map(|row| residual.get(*row).copied()).collect();
        let square: f64 = values.iter().map(|v| v * v).sum();
        if values.len() < FEWEST || !(square > 0.0) {
            continue;
        }
        let of = |what: &str| {
            let own = if campaign.bench.sensors.len() > 1 { format!(" of {}", sensor.id) } else { String::new() };
            format!("{what}{own}")
        };
        if let Some(test) = runs(&values).filter(|test| (test.runs as f64) < test.expected) {
            let what =
                format!("the residuals{} keep their sign: {} runs, {:.0} expected", of(""), test.runs, test.expected);
            tests.push((test.p, what));
        }
        let lag = values.windows(2).map(|pair| pair.iter().product::<f64>()).sum::<f64>() / square;
        if let Some(p) = normal_survival(lag * (values.len() as f64).sqrt()) {
            tests.push((p, format!("the residuals{} follow their neighbours: correlation {lag:.2}", of(""))));
        }
        if let Some((period, p)) = wave(&values, square) {
            tests.push((p, format!("the residuals{} have a wave of {period:.1} readings", of(""))));
        }
        for length in STRETCHES.into_iter().filter(|length| values.len() >= 3 * length) {
            let (mut between, mut stretches) = (0.0, 0_usize);
            for stretch in values.chunks(length) {
                between += stretch.iter().sum::<f64>().powi(2) / stretch.len() as f64;
                stretches += 1;
            }
            let (a, b) = (stretches as f64, (values.len() - stretches) as f64);
            let ratio = between / a / ((square - between).max(f64::MIN_POSITIVE) / b);
            if let Some(p) = fisher_f_survival(ratio, a, b) {
                tests.push((p, format!("the residuals{} differ between stretches of {length} readings", of(""))));
            }
        }
    }
    let count = tests.len() as f64;
    let best = tests.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Serial { what: best.1, p: (best.0 * count).min(1.0) })
}

/// The strongest wave: its period in readings, and the probability of one as strong by chance among all that were tried.
///
/// Frequencies stand half a cycle per record apart, so that no wave falls between two of them.
fn wave(values: &[f64], square: f64) -> Option<(f64, f64)> {
    if values.len() > LONGEST {
        return None;
    }
    let n = values.len() as f64;
    let mut best = (0.0_f64, 1.0);
    let count = values.len().saturating_sub(3);
    for k in 2..=count {
        let (sine, cosine) = (0.5 * k as f64 * std::f64::consts::TAU / n).sin_cos();
        let (mut real, mut imaginary, mut x, mut y) = (0.0, 0.0, 1.0, 0.0);
        for v in values {
            (real, imaginary) = (real + v * x, imaginary + v * y);
            (x, y) = (x * cosine - y * sine, x * sine + y * cosine);
        }
        let power = (real * real + imaginary * imaginary) / (0.5 * n * square);
        if power > best.0 {
            best = (power, 2.0 * n / k as f64);
        }
    }
    let alone = (1.0 - best.0.min(1.0)).powf(0.5 * (n - 3.0));
    Some((best.1, (alone * count as f64).min(1.0)))
}
