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
    /// Share of the significance that is spent on names (Bonferroni's inequality over the three tests). Default 0.5.
    pub names_share: f64,
    /// Share spent on the global test of what is left. Default 0.2: it sees what no name explains, and needs little.
    pub whole_share: f64,
    /// Share spent on serial patterns of the residuals in the order of time. Default 0.2.
    pub serial_share: f64,
    /// A further effect must be so many times less likely by chance than the first. Default 0.1: of two explanations that fit, the simpler one is preferred.
    pub further: f64,
    /// Explanations whose sums of squares differ by less, in noise variances, are not told apart. Default 9: three standard deviations of the
    /// difference of one parameter (Wilks).
    pub indistinguishable: f64,
    /// Smallest |t| of an effect against noise and remainder together where the rest is unexplained. Default 7.2: below, columns of the
    /// catalogue that merely resemble an unknown pattern reach it (largest cosine 0.55 on the gyro schedules, t = 7.2 at 120 degrees of freedom).
    pub above_remainder: f64,
    /// Least posterior probability that an effect or one of its aliases is present, for it to be named. Default 0.95.
    pub probability: f64,
    /// The same for it to be suspected, for nothing to be missing, and for a pattern outside the catalogue to be there. Default 0.5.
    pub suspected: f64,
    /// Standard deviation of an effect before the readings are seen, in its own standard uncertainties. Default 30: a plain effect; the Occam
    /// factor of each further effect is its logarithm (D. MacKay, Neural Computation 4 (1992), 415).
    pub prior_size: f64,
    /// Twice the logarithm of the odds, beforehand, that what is missing is an effect of the catalogue rather than a pattern that has no name. Default
    /// 4, odds of 7 to 1: from the seeded campaigns of one effect beside a pattern outside, where it costs no wrong name.
    pub in_catalogue: f64,
    /// Candidates whose columns have a smaller cosine are different explanations, never aliases, where the rest is unexplained. Default 0.5.
    pub alias_cosine: f64,
    /// Smallest |t| of each of three or more effects that explain the gap together. Default 5.5: weak ones approximate almost any pattern.
    pub each_of_many: f64,
    /// Plausibility penalty, in noise variances, of one rank of the catalogue among explanations that fit alike. Default 0.4: a fifth of a nat.
    pub rank_penalty: f64,
    /// Largest value of a term over what its inputs could make of it, below which only small tilts leave anything of it. Default 0.02: tilts of
    /// a degree. Such a term never stands before a plain one that fits as well.
    pub vanishing: f64,
    /// Share of a column that the model leaves, below which it is mostly absorbed and treated alike. Default 0.01.
    pub absorbed: f64,
    /// Deviances by which two kinds of scatter of the positions (remounting, setting of a joint) differ before one of them is preferred. Default 6:
    /// odds of 20.
    pub scatters_apart: f64,
    /// Fall of the sum of squares, in noise variances, from which two readings of one sensor look exchanged. Default 30: five standard deviations
    /// and a half, as pairs are many.
    pub exchanged: f64,
    /// and the largest share of the two residuals' squares that may be left after the exchange. Default 0.25: half of each.
    pub exchanged_left: f64,
    /// A column is zero where it is no larger than so many roundings of its inputs. Default 64 (N. Higham, Accuracy and Stability of Numerical
    /// Algorithms, 3.1: a product chain of n factors errs by n epsilon; chains here have at most a few dozen).
    pub roundings: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            significance: 0.01,
            remount: Remount::No,
            names_share: 0.5,
            whole_share: 0.2,
            serial_share: 0.2,
            further: 0.1,
            indistinguishable: 9.0,
            above_remainder: 7.2,
            probability: 0.95,
            suspected: 0.5,
            prior_size: 30.0,
            in_catalogue: 4.0,
            alias_cosine: 0.5,
            each_of_many: 5.5,
            rank_penalty: 0.4,
            vanishing: 0.02,
            absorbed: 0.01,
            scatters_apart: 6.0,
            exchanged: 30.0,
            exchanged_left: 0.25,
            roundings: 64.0,
        }
    }
}

impl Settings {
    /// The defaults at another significance.
    ///
    /// ```
    /// let settings = tumble::diagnosis::Settings::at(0.05);
    /// assert_eq!((settings.significance, settings.indistinguishable), (0.05, 9.0));
    /// ```
    pub fn at(significance: f64) -> Self {
        Settings { significance, ..Settings::default() }
    }

    /// Errors: a significance that is no probability between 0 and 1.
    pub fn check(&self) -> Result<()> {
        if self.significance > 0.0 && self.significance < 1.0 {
            return Ok(());
        }
        Err(Malformed::new(Fault::Value, "the significance is no probability")
            .expected("a number between 0 and 1, for example 0.01")
            .found(self.significance.to_string()))
    }

    /// Family-wise level of a name.
    pub(super) fn names(&self) -> f64 {
        self.names_share * self.significance
    }

    /// Level of the global test.
    #[cfg(feature = "navigate")]
    pub(crate) fn whole(&self) -> f64 {
        self.whole_share * self.significance
    }

    /// Level of the test for serial patterns.
    #[cfg(feature = "navigate")]
    pub(crate) fn serial(&self) -> f64 {
        self.serial_share * self.significance
    }

    /// Plausibility penalty of a term that only small tilts leave: as wide as what is not told apart, so that a plain term always stands before it.
    #[cfg(feature = "navigate")]
    pub(super) fn small_handicap(&self) -> f64 {
        self.indistinguishable
    }
}
