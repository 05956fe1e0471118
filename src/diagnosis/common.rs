//! What diagnoses of campaigns and of navigation errors have in common.

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
#[non_exhaustive]
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
