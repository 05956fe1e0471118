//! Are the residuals what random errors leave: in random order, and normal?
//!
//! Residuals of a fit are slightly correlated, so both tests are close, not exact; with fewer than eight residuals they say nothing.

use crate::elements::Elements;
use crate::uncertainty::quantiles;

/// Fewest residuals that these tests take.
const FEWEST: usize = 8;
/// Up to this many the distribution of runs is summed exactly.
const SUMMED: usize = 1000;

/// The runs test.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "RunsReport")]
pub struct RunsTest {
    /// Runs of equal sign.
    pub runs: usize,
    /// Mean number of runs to be expected.
    pub expected: f64,
    /// Two-sided probability.
    pub p: f64,
    /// Is it below one minus the level, which all tests of the pattern of the residuals share?
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rejected: Option<bool>,
}

impl RunsTest {
    /// Is `p` below one minus the level?
    pub(crate) fn is_rejected(&self, level: f64) -> bool {
        self.p < 1.0 - level
    }
}

/// The runs test (A. Wald, J. Wolfowitz 1940) on the signs of residuals in the order of the readings; zero residuals are left out. `None` with fewer than eight residuals, or all of one sign.
///
/// ```
/// let alternating: Vec<f64> = (0..10).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
/// let test = tumble::quality::runs(&alternating).unwrap();
/// assert_eq!((test.runs, test.expected), (10, 6.0));
/// assert!((test.p - 4.0 / 252.0).abs() < 1e-12); // two such orders of 252, and two with two runs
/// ```
pub fn runs(residuals: &[f64]) -> Option<RunsTest> {
    let mut signs = Signs::default();
    residuals.iter().for_each(|v| signs.take(*v));
    signs.test()
}

/// Signs of residuals as they come, and in how many runs; zeros have none.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Signs {
    pub positive: usize,
    pub negative: usize,
    pub runs: usize,
    last: Option<bool>,
}

impl Signs {
    /// One more residual.
    pub(crate) fn take(&mut self, v: f64) {
        if v == 0.0 || !v.is_finite() {
            return;
        }
        let sign = v > 0.0;
        *(if sign { &mut self.positive } else { &mut self.negative }) += 1;
        self.runs += usize::from(self.last != Some(sign));
        self.last = Some(sign);
    }

    /// The runs test.
    pub(crate) fn test(&self) -> Option<RunsTest> {
        runs_of(self.positive, self.negative, self.runs)
    }
}

/// The runs test of so many residuals of either sign in so many runs. `None` with fewer than eight residuals, or all of one sign.
pub(crate) fn runs_of(positive: usize, negative: usize, runs: usize) -> Option<RunsTest> {
    let all = positive + negative;
    if all < FEWEST || positive == 0 || negative == 0 {
        return None;
    }
    let (a, b) = (positive as f64, negative as f64);
    let n = a + b;
    let expected = 1.0 + 2.0 * a * b / n;
    let p = if all <= SUMMED {
        // ln n! of 0 to all
        let sums = (1..=all).scan(0.0, |sum: &mut f64, n| {
            *sum += (n as f64).ln();
            Some(*sum)
        });
        let factorials: Vec<f64> = std::iter::once(0.0).chain(sums).collect();
        let of = |n: usize| factorials.at(n);
        // ln C(n, k)
        let choose = |n: usize, k: usize| of(n) - of(k) - of(n.saturating_sub(k));
        let ways = choose(all, positive);
        let probability = |r: usize| -> f64 {
            let (k, odd) = (r / 2, r % 2 == 1);
            let way = |i: usize, j: usize| match (i.checked_sub(1), j.checked_sub(1)) {
                (Some(i), Some(j)) if i < positive && j < negative => {
                    (choose(positive - 1, i) + choose(negative - 1, j) - ways).exp()
                }
                _ => 0.0,
            };
            if odd { way(k + 1, k) + way(k, k + 1) } else { 2.0 * way(k, k) }
        };
        let observed = probability(runs);
        (2..=all).map(probability).filter(|q| *q <= observed * (1.0 + 1e-9)).sum::<f64>().min(1.0)
    } else {
        let variance = (expected - 1.0) * (expected - 2.0) / (n - 1.0);
        2.0 * quantiles::normal_survival((runs as f64 - expected).abs() / variance.sqrt())?
    };
    Some(RunsTest { runs, expected, p, rejected: None })
}

/// The test of normality.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "NormalityReport")]
pub struct NormalityTest {
    /// Shapiro-Francia W'.
    pub w: f64,
    /// Probability of a smaller one for normal errors.
    pub p: f64,
    /// Is it below one minus the level, which all tests of the pattern of the residuals share?
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rejected: Option<bool>,
}

impl NormalityTest {
    /// Is `p` below one minus the level?
    pub(crate) fn is_rejected(&self, level: f64) -> bool {
        self.p < 1.0 - level
    }
}

/// Shapiro-Francia `W'` of studentized residuals; its p-value by P. Royston, "A pocket-calculator algorithm for the Shapiro-Francia test for
/// non-normality", Statistics in Medicine 12 (1993), for 5 to 5000 values. `None` with fewer than eight, or without any scatter.
pub fn normality(studentized: &[f64]) -> Option<NormalityTest> {
    let mut values: Vec<f64> = studentized.iter().copied().filter(|v| v.is_finite()).collect();
    NormalScores::new(values.len())?.test(&mut values)
}

/// What tests of normality of equally many values share.
#[derive(Debug, Clone)]
pub struct NormalScores {
    scores: Vec<f64>,
    /// Sum of their squares.
    squares: f64,
    center: f64,
    spread: f64,
}

impl NormalScores {
    /// Normal scores (G. Blom 1958) of so many values; `None` for a number that is not tested.
    pub(crate) fn new(n: usize) -> Option<Self> {
        if !(FEWEST..=5000).contains(&n) {
            return None;
        }
        let score = |i: usize| quantiles::normal_quantile((i as f64 - 0.375) / (n as f64 + 0.25));
        let scores: Vec<f64> = (1..=n).map(score).collect::<Option<_>>()?;
        let ln_n = (n as f64).ln();
        let ln_ln_n = ln_n.ln();
        Some(NormalScores {
            squares: scores.iter().map(|m| m * m).sum(),
            scores,
            center: -1.2725 + 1.0521 * (ln_ln_n - ln_n),
            spread: 1.0308 - 0.26758 * (ln_ln_n + 2.0 / ln_n),
        })
    }

    /// The test of as many finite values, which it sorts.
    pub fn test(&self, values: &mut [f64]) -> Option<NormalityTest> {
        let n = values.len();
        if n != self.scores.len() {
            return None;
        }
        values.sort_unstable_by(f64::total_cmp);
        let mean = values.iter().sum::<f64>() / n as f64;
        let product: f64 = self.scores.iter().zip(values.iter()).map(|(m, x)| m * (x - mean)).sum();
        let of_values: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
        self.of_moments(product, of_values)
    }

    /// The scores, one for each value in ascending order.
    pub(crate) fn scores(&self) -> &[f64] {
        &self.scores
    }

    /// The test from the sums over ordered values, less their mean, of their products with the scores and of their squares.
    pub(crate) fn of_moments(&self, product: f64, of_values: f64) -> Option<NormalityTest> {
        if !(of_values > 0.0) {
            return None;
        }
        let w = (product * product / (self.squares * of_values)).min(1.0);
        let z = ((1.0 - w).max(f64::MIN_POSITIVE).ln() - self.center) / self.spread;
        Some(NormalityTest { w, p: quantiles::normal_survival(z)?, rejected: None })
    }
}
