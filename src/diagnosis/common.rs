//! What diagnoses of campaigns and of navigation errors have in common: their words, and every threshold with its meaning, its default and where that comes
//! from.

use crate::error::{Fault, Malformed, Result};
use crate::fit::Remount;
use crate::vocabulary::vocabulary;

vocabulary! {
    /// The verdict.
    Verdict {
        /// The effects named explain the gap down to the noise.
        EffectsFound = "effects-found",
        /// The effects named stand; what remains is more than noise, and nothing in the catalogue explains it.
        PartlyExplained = "partly-explained",
        /// The gap is noise.
        NothingMissing = "nothing-missing",
        /// Something is missing that nothing in the catalogue explains.
        Unexplained = "unexplained",
        /// There is no redundancy: nothing can be diagnosed.
        NotDiagnosable = "not-diagnosable",
    }
}

vocabulary! {
    /// Where the noise floor comes from.
    NoiseFrom {
        /// Stated standard uncertainties of the readings.
        Stated = "stated",
        /// Scatter of readings with the same joint states and model inputs.
        Replicates = "replicates",
        /// Residuals of the finished model: nothing else tells, so completeness cannot be tested against it.
        Residuals = "residuals",
    }
}

/// A gap.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "GapReport")]
#[non_exhaustive]
pub struct Gap {
    /// `sqrt(sum v^2 / dof)`; null without degrees of freedom. With sensors of several units it has none: see `sensors`.
    pub rms: Option<f64>,
    /// Largest residual by size, in the first sensor's unit (of navigation errors: in standard uncertainties).
    pub max: f64,
    /// `sum (v/u)^2` with the noise floor, a pure number.
    pub chi_square: f64,
    /// Degrees of freedom.
    pub dof: usize,
    /// Probability of a gap as large by chance; null where the noise is known from the residuals only.
    pub p: Option<f64>,
    /// Residual of each row, in the sensor's unit.
    #[serde(skip)]
    pub residuals: Vec<f64>,
}

/// The evidence with some effects in the model.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "StepReport")]
pub struct Step {
    /// Effects in the model.
    pub with: Vec<String>,
    /// The strongest further candidate.
    pub strongest: Option<String>,
    /// Its t.
    pub t: Option<f64>,
    /// Its probability by chance among all that was tried.
    pub p: Option<f64>,
    /// Probability of what is left by chance.
    pub global_p: Option<f64>,
}

impl Step {
    /// `strongest` is the strongest further candidate, its t and its family-wise p.
    pub(crate) fn new(with: Vec<String>, strongest: Option<(String, f64, f64)>, global_p: Option<f64>) -> Self {
        let (t, p) = strongest.as_ref().map(|(_, t, p)| (*t, *p)).unzip();
        Step { with, strongest: strongest.map(|(name, ..)| name), t, p, global_p }
    }
}

/// Standard uncertainties from which a value is different from zero, at 95 %.
pub(crate) const DIFFERENT: f64 = 1.96;

/// Lengths of what goes with time, smoothly or not: shares of the whole time, from a slow course to what forgets within a few readings: a factor of 3 to 10
/// apart; choices, not derived.
pub(crate) const LENGTHS: [(bool, f64); 5] = [(true, 0.3), (true, 0.1), (false, 1.0), (false, 0.1), (false, 0.02)];

/// What a kernel of such a length has of the wave `cos(pi h t)`, `t` from 0 to 1: the root of its spectrum.
pub(crate) fn share_of_wave(h: f64, (is_smooth, length): (bool, f64)) -> f64 {
    let f = std::f64::consts::PI * h * length;
    if is_smooth { (-0.25 * f * f).exp() } else { (1.0 / (1.0 + f * f)).sqrt() }
}

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
