//! Every threshold of a diagnosis: what it means, its default, and where that comes from.

use crate::error::{Fault, Malformed, Result};
use crate::fit::Remount;

/// How to diagnose. The defaults were calibrated by the seeded campaigns of `tests/diagnosis/campaigns.rs`, which print their table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Probability of reporting anything when nothing is missing; between 0 and 1. Default 0.01: one false alarm in a hundred calibrations.
    pub significance: f64,
    /// Offset of each sensor at each position: a shorthand for lines of scatter. Default: none.
    pub remount: Remount,
    /// Least posterior probability that an effect or one of its aliases is present, for it to be named. Default 0.95.
    pub probability: f64,
    /// The same for it to be suspected, for nothing to be missing, and for a pattern outside the catalogue to be there. Default 0.5.
    pub suspected: f64,
    /// Largest value of a term over what its inputs could make of it, below which only small tilts leave anything of it. Default 0.02: tilts of
    /// a degree. Such a term never stands before a plain one that fits as well.
    pub vanishing: f64,
    /// Share of a column that the model leaves, below which it is mostly absorbed and treated alike. Default 0.01.
    pub absorbed: f64,
    /// A column is zero where it is no larger than so many roundings of its inputs. Default 64 (N. Higham, Accuracy and Stability of Numerical
    /// Algorithms, 3.1: a product chain of n factors errs by n epsilon; chains here have at most a few dozen).
    pub roundings: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            significance: 0.01,
            remount: Remount::No,
            probability: 0.95,
            suspected: 0.5,
            vanishing: 0.02,
            absorbed: 0.01,
            roundings: 64.0,
        }
    }
}

impl Settings {
    /// The defaults at another significance.
    ///
    /// ```
    /// let settings = tumble::diagnosis::Settings::at(0.05);
    /// assert_eq!((settings.significance, settings.probability), (0.05, 0.95));
    /// ```
    pub fn at(significance: f64) -> Self {
        Settings { significance, ..Settings::default() }
    }

    /// Errors: a significance that is no probability between 0 and 1.
    pub(crate) fn check(&self) -> Result<()> {
        if self.significance > 0.0 && self.significance < 1.0 {
            return Ok(());
        }
        Err(Malformed::new(Fault::Value, "the significance is not a probability")
            .expected("a number between 0 and 1, for example 0.01")
            .found(self.significance.to_string()))
    }
}
