//! Rows whose noise is correlated in time, made independent as they come.
//!
//! ```text
//! y_i = a_i x + d_i + e_i,   cov(d_i, d_j) = q exp(-|t_i - t_j|/tau),   var e_i = r_i
//! ```
//!
//! The deviation `d` is a Markov process, so that a Kalman filter with this one state predicts each row from those before it. Every column of the
//! design and the observations go through the same filter; the innovations over their standard deviation are `L^-1 [A y]` with `V = L L'`: least
//! squares of them is generalised least squares of the rows, one row at a time, and the logarithms of the innovations' variances add up to `log |V|`.
//! (R. E. Kalman 1960; A. C. Harvey, "Forecasting, structural time series models and the Kalman filter", 1989, section 3.4.)

use super::compensated::Sum;
use crate::error::{Fault, Malformed, Result};
use faer::Mat;
use std::borrow::Cow;

/// Noise of a sensor along a record: a white part whose size comes with the rows, and one that is correlated in time.
///
/// ```
/// use tumble::estimate::Sequential;
/// // two rows a time tau apart, q = 3, r = 1: V = [[4, 3/e], [3/e, 4]]
/// let mut filter = Sequential::new(1, 3.0, 2.0);
/// let mut block = faer::mat![[1.0], [1.0]];
/// filter.whiten(&mut block, &[0.0, 2.0], &[1.0, 1.0])?;
/// let (v, c) = (4.0, 3.0 / std::f64::consts::E);
/// let exact = 2.0 / (v + c); // 1' V^-1 1
/// assert!((block[(0, 0)].powi(2) + block[(1, 0)].powi(2) - exact).abs() < 1e-15);
/// assert!((filter.log_determinant() - (v * v - c * c).ln()).abs() < 1e-15);
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
#[derive(Debug, Clone)]
pub struct Sequential {
    variance: f64,
    tau: f64,
    /// Variance of the deviation given the rows so far, and its mean for each column.
    spread: f64,
    mean: Vec<f64>,
    last: Option<f64>,
    logarithms: Sum,
    /// For each row of a block: what the mean keeps on its way to the row, the gain, one over the innovation's standard deviation.
    gains: Vec<[f64; 3]>,
}

impl Sequential {
    /// A filter for so many columns (unknowns, further columns, observations); `variance` 0 is white noise alone.
    pub fn new(columns: usize, variance: f64, tau: f64) -> Self {
        Sequential {
            variance,
            tau,
            spread: variance,
            mean: vec![0.0; columns],
            last: None,
            logarithms: Sum::default(),
            gains: Vec::new(),
        }
    }

    /// Replaces a block of rows, `k x columns`, by independent rows of unit variance; `time` and `sd` of the white part are `k` each.
    ///
    /// Errors: times that do not rise (equal ones are taken where there is white noise), lengths that disagree, a row without any noise.
    pub fn whiten(&mut self, block: &mut Mat<f64>, time: &[f64], sd: &[f64]) -> Result<()> {
        if !self.take(block.shape(), time, sd)? {
            self.turn(block);
        }
        Ok(())
    }

    /// A block by the gains that were found for it.
    fn turn(&mut self, block: &mut Mat<f64>) {
        let correlated = self.variance > 0.0;
        for (j, mean) in self.mean.iter_mut().enumerate() {
            let mut own = *mean;
            for (y, [keeps, gain, over]) in block.col_as_slice_mut(j).iter_mut().zip(&self.gains) {
                if correlated {
                    own *= keeps;
                    let innovation = *y - own;
                    own += gain * innovation;
                    *y = innovation * over;
                } else {
                    *y *= over;
                }
            }
            *mean = own;
        }
    }

    /// The same with a block that stays as it is; white rows of unit variance are not copied. Errors: those of [`Sequential::whiten`].
    pub(crate) fn whitened<'a>(&mut self, block: &'a Mat<f64>, time: &[f64], sd: &[f64]) -> Result<Cow<'a, Mat<f64>>> {
        if self.take(block.shape(), time, sd)? {
            return Ok(Cow::Borrowed(block));
        }
        let mut own = block.clone();
        self.turn(&mut own);
        Ok(Cow::Owned(own))
    }

    /// Counts the rows of a block and finds their gains; `true` where they are white and of unit variance.
    fn take(&mut self, (k, n): (usize, usize), time: &[f64], sd: &[f64]) -> Result<bool> {
        if n != self.mean.len() || time.len() != k || sd.len() != k {
            return Err(Malformed::new(
                Fault::Value,
                "a block of rows, its times and its noise are of different sizes",
            )
            .expected(format!("{} columns, {k} times, {k} standard deviations", self.mean.len()))
            .found(format!("{n}, {} and {}", time.len(), sd.len())));
        }
        self.gains.clear();
        if self.variance == 0.0 && sd.iter().all(|sd| *sd == 1.0) {
            return Ok(true);
        }
        self.gains(time, sd)?;
        Ok(false)
    }

    /// `log |V|` of all rows so far.
    pub fn log_determinant(&self) -> f64 {
        self.logarithms.value()
    }

    /// Of row `i` of the last block: what the mean of a column keeps on its way to the row, the gain, one over the innovation's standard deviation.
    pub(crate) fn gain(&self, i: usize) -> [f64; 3] {
        // white rows of unit variance have none
        self.gains.get(i).copied().unwrap_or([0.0, 0.0, 1.0])
    }

    /// Is there noise that is correlated in time?
    pub(crate) fn is_correlated(&self) -> bool {
        self.variance > 0.0
    }

    fn gains(&mut self, time: &[f64], sd: &[f64]) -> Result<()> {
        let (mut step, mut keeps) = (f64::NAN, 0.0);
        // logarithms of products: one logarithm for several rows
        let mut product = 1.0_f64;
        for (i, (t, sd)) in time.iter().zip(sd).enumerate() {
            let own = sd * sd;
            if self.variance > 0.0 {
                let passed = self.last.map_or(f64::INFINITY, |last| t - last);
                if !(passed >= 0.0) {
                    return Err(backwards(*t, self.last.unwrap_or(f64::NAN)).at_path(format!("rows[{i}]")));
                }
                if passed != step {
                    (step, keeps) = (passed, (-passed / self.tau).exp());
                }
                self.last = Some(*t);
            }
            let before = self.variance + keeps * keeps * (self.spread - self.variance);
            let whole = before + own;
            if !(whole > 0.0 && whole.is_finite()) {
                return Err(Malformed::new(Fault::Value, "a row has no noise to weight it by")
                    .expected("a positive standard uncertainty")
                    .found(sd.to_string())
                    .at_path(format!("rows[{i}]")));
            }
            let gain = before / whole;
            self.spread = gain * own;
            self.gains.push([keeps, gain, 1.0 / whole.sqrt()]);
            let next = product * whole;
            if (1e-200..1e200).contains(&next) {
                product = next;
            } else {
                self.logarithms.add(product.ln());
                product = whole;
            }
        }
        self.logarithms.add(product.ln());
        Ok(())
    }
}

/// A row that was read before the one in front of it, where noise is correlated over time.
pub(crate) fn backwards(at: f64, last: f64) -> Malformed {
    Malformed::new(Fault::Value, "the times of the rows do not rise")
        .expected("rows in the order of time, for noise that is correlated over it")
        .found(format!("{at} after {last}"))
}
