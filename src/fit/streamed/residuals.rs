//! What is kept of the residuals of a record: sums for tests of their order and shape, and the largest.
//!
//! Residuals are those of independent rows: innovations over their standard deviations, which are white and normal if model and noise are right.

use super::octaves::Octaves;
use crate::elements::{Elements, Parts};
use crate::estimate::Sum;
use crate::linear::dot;
use crate::number;
use crate::quality::{RunsTest, Signs};
use crate::uncertainty::quantiles;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Lags at which residuals are correlated with each other: 1, 2, 4, ...
const LAGS: usize = 11;
const LONGEST: usize = 1 << (LAGS - 1);
/// Residuals that are kept as the largest.
const KEPT: usize = 10;
/// Fewest pairs of means that a test takes.
const PAIRS: u64 = 8;

/// Residuals of independent rows (the noise that is correlated in time taken out), over their standard deviations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "RecordSensorReport")]
pub struct SensorResiduals {
    /// The sensor.
    pub sensor: String,
    /// Values read.
    #[serde(rename = "values")]
    pub rows: u64,
    /// Mean square, a pure number; 1 is expected.
    pub mean_square: f64,
    /// Skewness, a pure number; 0 for normal residuals.
    pub skewness: f64,
    /// Kurtosis less 3, a pure number; 0 for normal residuals.
    pub excess_kurtosis: f64,
    /// Correlation of residuals that are so many rows apart.
    pub lags: Vec<Lag>,
    /// Probability of so large correlations of independent residuals; null for few rows.
    pub lags_p: Option<f64>,
    /// Do means of many rows scatter as those of independent ones?
    pub means: Vec<MeansTest>,
    /// Index of the sensor.
    #[serde(skip)]
    pub index: usize,
    /// Order of the signs.
    #[serde(skip)]
    pub runs: Option<RunsTest>,
    /// The largest, first.
    pub largest: Vec<Far>,
}

/// Correlation of residuals.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "LagReport")]
pub struct Lag {
    /// Rows apart.
    pub rows: u64,
    /// Correlation, a pure number.
    pub correlation: f64,
}

/// Means of so many rows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "MeansReport")]
pub struct MeansTest {
    /// Rows in a mean.
    pub rows: u64,
    /// Pairs of neighbouring means that were compared.
    pub pairs: u64,
    /// Variance of these means over that of means of independent rows, a pure number; 1 is expected.
    pub ratio: f64,
    /// Probability of a ratio so far from 1, on either side.
    pub p: f64,
}

/// A residual that is far from zero.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "FarReport")]
pub struct Far {
    /// Number of the row, from 1.
    #[serde(rename = "row")]
    pub number: u64,
    /// Value read, in the sensor's unit.
    pub value: f64,
    /// Value minus fitted, in the sensor's unit.
    pub residual: f64,
    /// Residual of the independent row, in its standard deviations.
    pub w: f64,
    /// Probability of so large a one among all rows if none is bad.
    pub p: f64,
}

/// Residuals over the range of an input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "BinsReport")]
pub struct BinnedResiduals {
    /// The sensor.
    pub sensor: String,
    /// The input: a column of the record.
    #[serde(rename = "input")]
    pub column: String,
    /// What a step in each eighth of the input's range would explain, over the variance of the noise.
    pub chi_square: f64,
    /// Its degrees of freedom: steps that the model does not have itself.
    pub dof: usize,
    /// Probability of a larger one if the model is right.
    pub p: f64,
    /// Is the model rejected at the level, all inputs and sensors together?
    pub rejected: bool,
    /// Mean residual in each eighth of the range.
    pub bins: Vec<Bin>,
}

/// A part of the range of an input.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "BinReport")]
pub struct Bin {
    /// Its lower end, in the input's unit.
    pub low: f64,
    /// Its upper end, in the input's unit.
    pub high: f64,
    /// Rows in it.
    pub rows: u64,
    /// Mean residual, in the sensor's unit; null without rows.
    pub mean: Option<f64>,
}

/// Sums over the residuals of one sensor.
#[derive(Debug, Clone)]
pub(super) struct Residuals {
    rows: u64,
    powers: [Sum; 4],
    signs: Signs,
    /// The last [`LONGEST`] of them.
    recent: Vec<f64>,
    products: [Sum; LAGS],
    octaves: Octaves,
    largest: Vec<Far>,
}

impl Residuals {
    pub(super) fn new() -> Self {
        Residuals {
            rows: 0,
            powers: [Sum::default(); 4],
            signs: Signs::default(),
            recent: vec![0.0; LONGEST],
            products: [Sum::default(); LAGS],
            octaves: Octaves::default(),
            largest: Vec::new(),
        }
    }

    /// Takes the residuals `w` of independent rows, in standard deviations of them, with the rows' numbers, values and residuals in the sensor's unit.
    pub(super) fn take(&mut self, numbers: &[u64], values: &[f64], residuals: &[f64], w: &[f64]) {
        for (k, w) in w.iter().enumerate() {
            self.signs.take(*w);
            self.octaves.push(*w);
            let least = self.largest.last().filter(|_| self.largest.len() >= KEPT).map_or(0.0, |far| far.w.abs());
            if w.abs() > least {
                let at = self.largest.partition_point(|far| far.w.abs() >= w.abs());
                let number = numbers.get(k).copied().unwrap_or_default(); // one number, value and residual for each row
                let far = Far { number, value: values.at(k), residual: residuals.at(k), w: *w, p: 1.0 };
                self.largest.insert(at, far);
                self.largest.truncate(KEPT);
            }
        }
        let squares: Vec<f64> = w.iter().map(|w| w * w).collect();
        let powers = [w.iter().sum(), dot(w, w), dot(w, &squares), dot(&squares, &squares)];
        self.powers.iter_mut().zip(powers).for_each(|(sum, own)| sum.add(own));
        // the last rows before these, zeros where there are none, then these
        self.recent.extend_from_slice(w);
        for (lag, sum) in self.products.iter_mut().enumerate().map(|(k, sum)| (1 << k, sum)) {
            sum.add(dot(self.recent.part(LONGEST - lag..LONGEST - lag + w.len()), w));
        }
        self.recent.drain(..w.len());
        self.rows += w.len() as u64;
    }

    /// What they say, for residuals whose mean square should be `variance`.
    pub(super) fn conclude(mut self, (index, sensor): (usize, String), variance: f64) -> SensorResiduals {
        let n = self.rows as f64;
        let [m1, m2, m3, m4] = self.powers.map(|sum| if n > 0.0 { sum.value() / n } else { 0.0 });
        let central = (m2 - m1 * m1).max(f64::MIN_POSITIVE);
        let third = m3 - 3.0 * m1 * m2 + 2.0 * m1 * m1 * m1;
        let fourth = m4 - 4.0 * m1 * m3 + 6.0 * m1 * m1 * m2 - 3.0 * m1.powi(4);
        let correlation =
            |k: usize| self.products.get(k).map_or(0.0, |sum| sum.value() / (n * m2).max(f64::MIN_POSITIVE));
        let lags: Vec<Lag> = (0..LAGS)
            .map(|k| Lag { rows: 1 << k, correlation: correlation(k) })
            .filter(|lag| lag.rows * 8 <= self.rows)
            .collect();
        let squares: f64 = lags.iter().map(|Lag { rows, correlation: r }| n * n / (n - *rows as f64) * r * r).sum();
        let means = self.octaves.variances().filter(|own| own.1 >= PAIRS);
        let means = means
            .map(|(rows, pairs, own)| {
                let ratio = own * rows / variance.max(f64::MIN_POSITIVE);
                // a count of pairs is a number of degrees of freedom, so that the quantile exists
                let above = quantiles::chi_square_survival(ratio * pairs as f64, pairs as f64).unwrap_or(f64::NAN);
                MeansTest { rows: number::count_u64(rows), pairs, ratio, p: (2.0 * above.min(1.0 - above)).min(1.0) }
            })
            .collect();
        let sd = variance.sqrt().max(f64::MIN_POSITIVE);
        for far in &mut self.largest {
            far.w /= sd;
            // a deviation is a finite number
            let single = 2.0 * quantiles::normal_survival(far.w.abs()).unwrap_or(0.5);
            far.p = -f64::exp_m1(n * f64::ln_1p(-single.min(1.0 - 1e-16)));
        }
        SensorResiduals {
            sensor,
            index,
            rows: self.rows,
            mean_square: m2 / variance.max(f64::MIN_POSITIVE),
            skewness: third / central.powf(1.5),
            excess_kurtosis: fourth / (central * central) - 3.0,
            lags_p: (!lags.is_empty()).then(|| quantiles::chi_square_survival(squares, lags.len() as f64)).flatten(),
            lags,
            means,
            runs: self.signs.test(),
            largest: self.largest,
        }
    }
}
