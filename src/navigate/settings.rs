//! Every threshold of a diagnosis of measured navigation errors: what it means, its default, and where that comes from.

use crate::diagnosis;

/// How to diagnose measured navigation errors.
///
/// The defaults were calibrated by the seeded experiments of `tests/navigation`, which print their tables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Significance, and the probabilities from which a cause is named and suspected: as for a campaign.
    pub common: diagnosis::Settings,
    /// Share of the significance that is spent on the global test of the residuals: it detects what no cause explains. Default 0.2; what the search needs
    /// to add a cause is counted in its penalty.
    pub whole_share: f64,
    /// Share spent on serial patterns in the innovations of a random walk. Default 0.2.
    pub serial_share: f64,
    /// Explanations whose sums of squares differ by less, in variances of the noise, are not distinguished. Default 9: three standard deviations of the
    /// difference of one parameter (Wilks).
    pub indistinguishable: f64,
    /// Plausibility penalty of one rank of the causes, in variances of the noise. Default 2: a nat; biases come before scale factors, these before
    /// what changes in time.
    pub rank_penalty: f64,
    /// An error that even at its largest size stays below so many standard deviations cannot be seen, and is no candidate. Default 5.
    pub unseen: f64,
    /// Causes of a set at most. Default 16: all biases, the start and a few more.
    pub causes: usize,
    /// of them such as change in time or are the reference's. Default 3: more of them build any course of time.
    pub changing: usize,
    /// Largest share of the rows that single wrong values may make up. Default 0.05.
    pub singles: f64,
    /// Additional penalty of a single wrong value to that of a cause, in variances of the noise. Default 4.
    pub single_penalty: f64,
    /// Share of the significance at which single values are rejected: by their standard uncertainties where noise alone remains, else by how they stand out. Default 0.1.
    pub single_share: f64,
    /// Standard deviations by which the variance of a channel's innovations, or their serial correlation, may differ from white noise. Default
    /// 4.5: none of some hundred tests in a hundred diagnoses.
    pub white: f64,
    /// A motion discriminates a cause from its alias where so many standard deviations of the cause remain. Default 5.
    pub tells: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            common: diagnosis::Settings::default(),
            whole_share: 0.2,
            serial_share: 0.2,
            indistinguishable: 9.0,
            rank_penalty: 2.0,
            unseen: 5.0,
            causes: 16,
            changing: 3,
            singles: 0.05,
            single_penalty: 4.0,
            single_share: 0.1,
            white: 4.5,
            tells: 5.0,
        }
    }
}

impl Settings {
    /// The defaults at another significance.
    pub fn at(significance: f64) -> Self {
        Settings { common: diagnosis::Settings::at(significance), ..Settings::default() }
    }

    /// Level of the global test of the residuals.
    pub(super) fn whole(&self) -> f64 {
        self.whole_share * self.common.significance
    }

    /// Level of the test for serial patterns.
    pub(super) fn serial(&self) -> f64 {
        self.serial_share * self.common.significance
    }
}
