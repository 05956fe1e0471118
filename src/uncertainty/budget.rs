//! The budget of one quantity: contributions, their combination and its degrees of freedom (GUM 5.1, G.4).

use super::quantiles;
use crate::campaign::Distribution;
use crate::number::or_infinite;
use crate::vocabulary::vocabulary;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

vocabulary! {
    /// How a contribution was evaluated (GUM 2.3.2, 2.3.3).
    Evaluation {
        /// From the scatter of these readings.
        TypeA = "A",
        /// From anything else: a stated uncertainty, a known coefficient, a prior.
        TypeB = "B",
    }
}

vocabulary! {
    /// Shape of the distribution of a contribution.
    Shape {
        /// Gaussian.
        Normal = "normal",
        /// Student's t.
        T = "t",
        /// Rectangular.
        Rectangular = "rectangular",
        /// Triangular.
        Triangular = "triangular",
        /// Arcsine (U-shaped).
        Arcsine = "arcsine",
    }
}

impl From<Distribution> for Shape {
    fn from(of: Distribution) -> Shape {
        match of {
            Distribution::Normal => Shape::Normal,
            Distribution::Rectangular => Shape::Rectangular,
            Distribution::Triangular => Shape::Triangular,
            Distribution::Arcsine => Shape::Arcsine,
        }
    }
}

/// One line of a budget.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Contribution {
    /// Where it comes from.
    pub source: String,
    /// `A` or `B`.
    #[serde(rename = "type")]
    pub evaluation: Evaluation,
    /// Shape of the distribution.
    pub distribution: Shape,
    /// Contribution to the standard uncertainty, in the quantity's unit; negative for a correlated pair that takes from the variance (its square).
    // `|c| u`, of a correlated pair the root of `2 c_i c_j u_i u_j |r|` (GUM eq. 13)
    pub u: f64,
    /// Estimate of the source, where it is one quantity, in the source's unit.
    pub estimate: Option<f64>,
    /// Sensitivity coefficient, where the source is one quantity, in the quantity's unit over the source's.
    #[serde(rename = "c")]
    pub sensitivity: Option<f64>,
    /// Standard uncertainty of the source itself, where it is one quantity, in the source's unit.
    pub source_u: Option<f64>,
    /// Degrees of freedom; null for infinite.
    #[serde(deserialize_with = "or_infinite")]
    #[schemars(with = "Option<f64>")]
    pub dof: f64,
}

impl Contribution {
    /// Of many readings, or a pair of inputs: of no single source with an estimate of its own.
    pub(crate) fn of_many(source: String, evaluation: Evaluation, u: f64, dof: f64) -> Self {
        let distribution = if dof.is_finite() { Shape::T } else { Shape::Normal };
        Contribution { source, evaluation, distribution, estimate: None, source_u: None, sensitivity: None, u, dof }
    }

    /// What it adds to the variance.
    pub(crate) fn variance(&self) -> f64 {
        self.u * self.u.abs()
    }
}

/// Combined standard uncertainty with its degrees of freedom and expansion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Combined {
    /// Combined standard uncertainty, `sqrt(sum u_i^2)`, covariances of correlated pairs with their signs.
    pub u: f64,
    /// Root sum of squares of the Type A contributions.
    pub type_a: f64,
    /// Root sum of squares of the Type B contributions.
    pub type_b: f64,
    /// Effective degrees of freedom; may be infinite.
    pub dof: f64,
    /// Coverage factor.
    pub coverage_factor: f64,
    /// Expanded uncertainty, `k u`.
    pub expanded: f64,
}

/// Combine contributions to one quantity.
///
/// `u^2 = sum u_i^2` (GUM eq. 11a, with correlated pairs eq. 13); `nu_eff = u^4 / sum(u_i^4 / nu_i)` (Welch-Satterthwaite, GUM eq. G.2b), not rounded down;
/// `k` the two-sided Student quantile at `level`. `None` for a level outside (0, 1) or a contribution without degrees of freedom.
///
/// ```
/// use tumble::uncertainty::{combine, Contribution, Evaluation, Shape};
/// let one = |u, dof| Contribution { source: "x".into(), evaluation: Evaluation::TypeA, distribution: Shape::Normal,
///     estimate: None, source_u: None, sensitivity: None, u, dof };
/// let combined = combine(&[one(3.0, 4.0), one(4.0, f64::INFINITY)], 0.95).unwrap();
/// assert_eq!(combined.u, 5.0);
/// assert!((combined.dof - 625.0 * 4.0 / 81.0).abs() < 1e-9);
/// ```
pub fn combine(contributions: &[Contribution], level: f64) -> Option<Combined> {
    combine_groups(contributions, &|_| None, &[], level)
}

/// `u^4 / sum(u_i^4 / nu_i)`.
pub(crate) fn effective_dof(u: f64, parts: impl Iterator<Item = (f64, f64)>) -> f64 {
    let spread: f64 =
        parts.filter(|(part, dof)| dof.is_finite() && *part > 0.0).map(|(p, dof)| (p / u).powi(4) / dof).sum();
    if u > 0.0 && spread > 0.0 { 1.0 / spread } else { f64::INFINITY }
}

/// Combine contributions of which some belong together, as `group` says for each: Welch-Satterthwaite takes those of a group as one, with the degrees
/// of freedom that `dof` has for it. `None` as for [`combine`].
pub(crate) fn combine_groups(
    contributions: &[Contribution],
    group: &dyn Fn(&Contribution) -> Option<usize>,
    dof: &[f64],
    level: f64,
) -> Option<Combined> {
    let sum = |of: &dyn Fn(&Contribution) -> bool| -> f64 {
        // an empty sum of floats is -0
        contributions.iter().filter(|c| of(c)).fold(0.0, |s, c| s + c.variance()).max(0.0).sqrt()
    };
    let u = sum(&|_| true);
    let others = contributions.iter().filter(|c| group(c).is_none()).map(|c| (c.u, c.dof));
    let groups = dof.iter().enumerate().map(|(k, dof)| (sum(&|c| group(c) == Some(k)), *dof));
    let dof = effective_dof(u, others.chain(groups));
    let coverage_factor = quantiles::coverage_factor(level, dof)?;
    let [type_a, type_b] = [Evaluation::TypeA, Evaluation::TypeB].map(|e| sum(&|c| c.evaluation == e));
    Some(Combined { u, type_a, type_b, dof, coverage_factor, expanded: coverage_factor * u })
}
