//! Patterns of the residuals in the order of time: runs, correlation of neighbours, and differences between stretches of readings.

use super::remainder::in_time;
use crate::campaign::Campaign;
use crate::design::DesignMatrix;
use crate::quality::runs;
use crate::uncertainty::quantiles::{fisher_f_survival, normal_survival};

/// Fewest readings of a sensor for which anything is said.
const FEWEST: usize = 12;
/// Lengths of the stretches whose means are compared.
const STRETCHES: [usize; 3] = [4, 8, 16];

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
