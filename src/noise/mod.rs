//! What a sensor's noise is made of: Allan, Hadamard and modified Allan deviations of a record at rest, and the coefficients of IEEE Std 952.
//!
//! ```text
//! sigma^2(tau) = 3 Q^2/tau^2 + N^2/tau + (2 ln 2/pi) B^2 + K^2 tau/3 + R^2 tau^2/2        (IEEE 952-1997, annex C)
//! ```
//!
//! | file | subject |
//! |---|---|
//! | `ladder.rs` | overlapping deviations of a stream; memory does not grow with the record |
//! | `cells.rs` | the record in some thousand cells: its slope, its gaps, and what noise is in averages over all of it |
//! | `edf.rs` | equivalent degrees of freedom and chi-square intervals |
//! | `covariance.rs` | how deviations at different averaging times are correlated |
//! | `coefficients.rs` | Q, N, B, K, R: which of them are there by the likelihood of their sum, how large, and in which units of the field |
//!
//! Averaging times are in seconds, deviations in the record's unit. Deliberately absent: reading records (`record`), plots (`report`).

mod cells;
mod coefficients;
mod covariance;
mod edf;
mod ladder;

pub use coefficients::Term;
pub(crate) use coefficients::{Agreement, Change, Coefficients, field_unit, si_factor};
pub(crate) use edf::{Kind, equivalent_dof, interval};
pub use ladder::Ladder;
pub(crate) use ladder::{MISSING, Sums};

use crate::uncertainty::quantiles::normal_survival;
use crate::vocabulary::vocabulary;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One deviation with its chi-square interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "DeviationReport")]
#[non_exhaustive]
pub struct Deviation {
    /// The deviation, in the column's unit.
    pub value: f64,
    /// Lower end of its interval, in the same unit.
    pub low: Option<f64>,
    /// Upper end, in the same unit.
    pub high: Option<f64>,
    /// Equivalent degrees of freedom.
    pub edf: f64,
    /// Differences averaged.
    pub differences: u64,
}

/// Deviations at one averaging time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "DeviationsReport")]
#[non_exhaustive]
pub struct Point {
    /// Samples averaged.
    pub m: u64,
    /// Averaging time, s.
    #[serde(rename = "tau_s")]
    pub tau: f64,
    /// Power of the frequency in the spectral density that dominates here: 2 (quantization), 0 (white), -1 (flicker), -2 (random walk).
    pub alpha: i32,
    /// Overlapping Allan deviation.
    pub allan: Deviation,
    /// Overlapping Hadamard deviation.
    pub hadamard: Option<Deviation>,
    /// Modified Allan deviation.
    pub modified: Option<Deviation>,
    /// Allan deviation of the fitted coefficients, in the column's unit.
    pub fitted: Option<f64>,
}

/// The noise of one column of a record.
#[derive(Debug, Clone, PartialEq)]
pub struct Analysis {
    /// Samples.
    pub samples: u64,
    /// Sampling interval, s.
    pub interval: f64,
    /// Stretches between gaps.
    pub stretches: u64,
    /// Mean of all samples.
    pub mean: f64,
    /// Probability that an interval holds the deviation.
    pub level: f64,
    /// Deviations, from short to long averaging times.
    pub points: Vec<Point>,
    /// The coefficients.
    pub coefficients: Option<Coefficients>,
    /// Why there are none.
    pub without: Option<Without>,
}

vocabulary! {
    /// Why a record has no coefficients.
    Without {
        /// All samples are equal.
        Constant = "constant",
        /// There are fewer than five octaves of averaging times, each at most a fifth of the samples.
        Short = "short",
        /// No sum of the terms gives such deviations.
        Undescribed = "undescribed",
    }
}

/// What is said of fewer records of noise alone than this share: that they move, or that a filter bends their short averaging times. Tails that are not
/// normal make it ten times as many, one record in a thousand.
const BY_CHANCE: f64 = 1e-4;

/// Deviations with their intervals, and the coefficients, of what a ladder has seen.
///
/// The noise type that an interval needs is that of the fitted coefficients at its averaging time.
///
/// ```
/// use tumble::noise::{Ladder, analyse};
/// let mut ladder = Ladder::new(1);
/// // the generator of NIST SP 1065, section 12.4
/// let mut n = 1234567890_u64;
/// let samples: Vec<f64> = (0..1000).map(|_| { let y = n as f64 / 2147483647.0; n = 16807 * n % 2147483647; y }).collect();
/// ladder.push(&samples);
/// let noise = analyse(&ladder, 1.0, 0.683);
/// assert!((noise.points[0].allan.value - 0.2922319).abs() < 5e-8);
/// ```
pub fn analyse(ladder: &Ladder, interval: f64, level: f64) -> Analysis {
    let sums: Vec<Sums> = ladder.sums().into_iter().filter(|s| 5 * s.m <= ladder.samples()).collect();
    let taus: Vec<f64> = sums.iter().map(|s| s.m as f64 * interval).collect();
    // octaves carry what there is to know; more points only repeat it
    let mut thin: Vec<Sums> = Vec::new();
    for s in &sums {
        if thin.last().is_none_or(|last| s.m >= 2 * last.m) {
            thin.push(*s);
        }
    }
    let short = thin.len() < Term::ALL.len();
    let mut coefficients =
        if short || ladder.is_constant() { None } else { coefficients::coefficients(&thin, ladder.cells(), interval) };
    if let Some(found) = &mut coefficients {
        let (largest, count) = ladder.cells().largest_change(|m| found.variance(m * interval));
        let largest =
            largest.filter(|[in_sd, ..]| normal_survival(*in_sd).is_some_and(|p| 2.0 * p * (count as f64) < BY_CHANCE));
        found.agreement.change =
            largest.map(|[in_sd, start, m, by]| Change { time_s: start * interval, tau_s: m * interval, by, in_sd });
    }
    let without = match &coefficients {
        Some(_) => None,
        None if ladder.is_constant() => Some(Without::Constant),
        None if short => Some(Without::Short),
        None => Some(Without::Undescribed),
    };
    let points = sums
        .iter()
        .zip(&taus)
        .map(|(s, tau)| {
            let alpha = coefficients.as_ref().map_or(0, |c| c.alpha(*tau));
            let deviation = |kind: Kind, square: f64, differences: u64| {
                // where the formula has no value: the least that an interval can have
                let edf = equivalent_dof(kind, alpha, s.m, ladder.samples() + 1).unwrap_or(1.0);
                let value = square.max(0.0).sqrt();
                let (low, high) = self::interval(value, edf, level).unzip();
                Deviation { value, low, high, edf, differences }
            };
            Point {
                m: s.m,
                tau: *tau,
                alpha,
                allan: deviation(Kind::Allan, s.allan_variance(), s.allan.1),
                hadamard: s.hadamard_variance().map(|v| deviation(Kind::Hadamard, v, s.hadamard.1)),
                modified: s.modified_variance().map(|v| deviation(Kind::Modified, v, s.modified.1)),
                fitted: coefficients.as_ref().map(|c| c.variance(*tau).sqrt()),
            }
        })
        .collect();
    Analysis {
        samples: ladder.samples(),
        interval,
        stretches: ladder.stretches(),
        mean: ladder.mean(),
        level,
        points,
        coefficients,
        without,
    }
}
