//! The fit report (`--json`): its keys and what they mean.

use super::Input;
use super::conformity::ConformityReport;
use super::fit_checks::{ChecksReport, EachParameter, RobustReport};
use super::fit_constraints::ConstraintsReport;
use super::monte_carlo::MonteCarloReport;
use super::record::RecordReport;
use super::scatter::ScatterReport;
use super::separation::NotEstimableReport;
use super::site::SiteReport;
use crate::campaign::{Distribution, Identity, Kind};
use crate::fit::{Estimator, State, Stop, VarianceFrom};
use crate::language::Sentence;
use crate::report::ReportKind;
use crate::uncertainty::{Evaluation, Shape};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What `tumble fit --json` writes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct FitReport {
    /// Version of the program that wrote it.
    pub tumble: String,
    /// Always `fit`.
    #[schemars(extend("const" = "fit"))]
    pub report: ReportKind,
    /// Id of the bench.
    pub bench: String,
    /// Model line of each sensor.
    pub model: BTreeMap<String, String>,
    /// `exact`, or `linear` with `--linear`.
    pub estimator: Estimator,
    /// The unit under test, when, where, by whom, with what.
    #[serde(default, skip_serializing_if = "Identity::is_empty")]
    pub identity: Identity,
    /// The files that the report was made from, with the SHA-256 of their bytes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inputs: Vec<Input>,
    /// Conformity with the limits of the campaign, where it has any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub conformity: Option<ConformityReport>,
    /// Latitude, Earth rate and gravity.
    pub site: SiteReport,
    /// The estimated parameters.
    pub parameters: Vec<ParameterReport>,
    /// Known parameters, as given.
    pub known: Vec<KnownReport>,
    /// Correlation coefficients of pairs of known parameters, as given; others are independent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub correlations: Vec<(String, String, f64)>,
    /// Quantities computed from parameters.
    pub derived: Vec<DerivedReport>,
    /// Parameters that the bench has and the campaign neither knows nor estimates.
    pub assumed_zero: Vec<String>,
    /// Covariance of the estimated parameters, readings and known inputs together.
    pub covariance: CovarianceReport,
    /// Sums over the whole fit.
    pub fit: FitSummary,
    /// What the readings leave free.
    pub not_estimable: Vec<NotEstimableReport>,
    /// What is determined of parameters that are not estimable alone, with values.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub estimable_combinations: Vec<CombinationValueReport>,
    /// Estimates that depend on the values at which something that is not estimable is held: their `U` holds only given those.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub conditional: Vec<ConditionalReport>,
    /// Parameters whose exact and linear estimates differ by more than a tenth of their standard uncertainty, and by how many of it (exact
    /// minus linear; with `--linear`, what Gauss-Newton would change next).
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub nonlinear: BTreeMap<String, f64>,
    /// Each value that was read.
    pub readings: Vec<ReadingReport>,
    /// Correlations of the estimated parameters.
    pub correlation: CovarianceReport,
    /// How readings of this unit are corrected; absent where no sensor follows a rate or specific force that the fit determines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub correction: Option<crate::wire::CorrectionFile>,
    /// What scatters in the readings.
    pub scatter: Vec<ScatterReport>,
    /// Do the readings agree with the model?
    pub checks: ChecksReport,
    /// The record, where its rows are the readings (`"as": "rows"`); `readings` is then a sample of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub record: Option<RecordReport>,
    /// What became of the campaign's constraints.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub constraints: Option<ConstraintsReport>,
    /// The robust estimator, with `--robust`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robust: Option<RobustReport>,
    /// Monte Carlo, with `--monte-carlo`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub monte_carlo: Option<MonteCarloReport>,
    /// The record of Gauss-Newton; absent with `--linear`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub convergence: Option<ConvergenceReport>,
}

/// An estimated parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct ParameterReport {
    /// Name.
    pub id: String,
    /// `tilt` or `coefficient`.
    pub kind: Kind,
    /// Unit of value and uncertainties.
    pub unit: String,
    /// Estimate, in `unit`; null where it is not estimable.
    pub value: Option<f64>,
    /// Combined standard uncertainty, in `unit`.
    pub u: Option<f64>,
    /// Effective degrees of freedom; null for infinite.
    pub dof: Option<f64>,
    /// Coverage factor.
    pub k: Option<f64>,
    /// Expanded uncertainty, in `unit`.
    #[serde(rename = "U")]
    pub expanded: Option<f64>,
    /// Coverage probability of the expanded uncertainty.
    pub level: f64,
    /// Coverage interval, in `unit`: `value - U` to `value + U`, but with inequality constraints about the estimate without them, cut to what they
    /// allow; null where no uncertainty is known, or where constraints and readings leave nothing.
    pub interval: Option<[f64; 2]>,
    /// Part of `u` evaluated from the scatter of the readings (or their stated uncertainties), in `unit`.
    pub type_a: Option<f64>,
    /// Part of `u` from known inputs and priors, in `unit`.
    pub type_b: Option<f64>,
    /// Where `u` comes from.
    pub budget: Vec<BudgetReport>,
    /// The same in arcseconds, for tilts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arcsec: Option<ArcsecReport>,
    /// `free`, `at-bound` or `not-estimable`.
    pub state: State,
}

/// A line of a budget.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct BudgetReport {
    /// Where it comes from.
    pub source: String,
    /// `A` or `B`.
    #[serde(rename = "type")]
    pub evaluation: Evaluation,
    /// Shape of the distribution.
    pub distribution: Shape,
    /// Contribution to the standard uncertainty, in the quantity's unit; negative for a correlated pair that takes from the variance (its square).
    pub u: f64,
    /// Estimate of the source, where it is one quantity, in the source's unit.
    pub estimate: Option<f64>,
    /// Sensitivity coefficient, where the source is one quantity, in the quantity's unit over the source's.
    pub c: Option<f64>,
    /// Standard uncertainty of the source itself, where it is one quantity, in the source's unit.
    pub source_u: Option<f64>,
    /// Degrees of freedom; null for infinite.
    pub dof: Option<f64>,
    /// Share of the variance, 0 to 1; of correlated inputs also beyond, and negative.
    pub share: f64,
}

/// An angle in arcseconds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct ArcsecReport {
    /// Estimate, arcsec.
    pub value: Option<f64>,
    /// Standard uncertainty, arcsec.
    pub u: Option<f64>,
    /// Expanded uncertainty, arcsec.
    #[serde(rename = "U")]
    pub expanded: Option<f64>,
}

/// A known parameter as the campaign gives it (tilts in radians).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct KnownReport {
    /// Name.
    pub id: String,
    /// Value, in `unit`.
    pub value: f64,
    /// Unit.
    pub unit: String,
    /// Standard uncertainty, in `unit`.
    pub u: f64,
    /// Degrees of freedom; null for infinite.
    pub dof: Option<f64>,
    /// Shape of the distribution.
    pub distribution: Distribution,
}

impl FitReport {
    /// The correlation coefficients of known parameters, as text.
    pub(super) fn correlated(&self) -> Vec<String> {
        self.correlations
            .iter()
            .map(|(a, b, r)| format!("r({a}, {b}) = {}", crate::document::number::significant(*r, 4)))
            .collect()
    }

    /// Do the readings say that the model lacks something, or that some of them are bad?
    pub fn is_misfit(&self) -> bool {
        self.fit.global_test_rejected == Some(true)
            || self.checks.misfit().is_some_and(|test| test.rejected)
            || self.checks.snooping.as_ref().is_some_and(|found| !found.suspects.is_empty())
    }

    /// Coverage probability of the expanded uncertainties.
    pub(crate) fn level(&self) -> f64 {
        self.parameters.first().map_or(0.95, |p| p.level)
    }

    /// Names of the derived quantities that need what is not estimable, and so have no value.
    pub(crate) fn derived_without_a_value(&self) -> Vec<&str> {
        self.derived.iter().filter(|d| d.value.is_none()).map(|d| d.id.as_str()).collect()
    }
}

/// A derived quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct DerivedReport {
    /// Name.
    pub id: String,
    /// The line of algebra, as it was written (before it is brought to `unit`); for an error of a
    /// scale factor what it is: Y mean readings (`↑` from below, `↓` from above) at the rates x, a + b x their straight line (`₊`, `₋` of either
    /// sense), `‖ ‖∞` the largest size, s the standard deviation over runs.
    pub line: String,
    /// Its unit, as asked for or as the line has it; empty where a parameter in it has none.
    pub unit: String,
    /// Value, in `unit`; null where it needs what is not estimable.
    pub value: Option<f64>,
    /// Standard uncertainty, first order, in `unit`.
    pub u: Option<f64>,
    /// Effective degrees of freedom; null for infinite.
    pub dof: Option<f64>,
    /// Coverage factor.
    pub k: Option<f64>,
    /// Expanded uncertainty, in `unit`.
    #[serde(rename = "U")]
    pub expanded: Option<f64>,
    /// Coverage interval of an azimuth `atan2(y, x)`, in `unit`: the directions that y and x together allow; the whole circle where they may
    /// both be zero. Absent for other lines, whose interval is `value - U` to `value + U`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interval: Option<[f64; 2]>,
    /// What a person must know of it, in a sentence.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<Sentence>,
    /// Where `u` comes from.
    pub budget: Vec<BudgetReport>,
    /// The same in arcseconds, for angles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arcsec: Option<ArcsecReport>,
}

/// A combination of parameters that is determined where they alone are not.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct CombinationValueReport {
    /// Coefficient of each parameter.
    pub combination: BTreeMap<String, f64>,
    /// The same as a line of text.
    pub text: String,
    /// Unit: that of the first parameter, whose coefficient is 1.
    pub unit: String,
    /// Value, in `unit`.
    pub value: f64,
    /// Combined standard uncertainty, in `unit`.
    pub u: Option<f64>,
    /// Effective degrees of freedom; null for infinite.
    pub dof: Option<f64>,
    /// Coverage factor.
    pub k: Option<f64>,
    /// Expanded uncertainty, in `unit`.
    #[serde(rename = "U")]
    pub expanded: Option<f64>,
    /// Where the uncertainty comes from.
    pub budget: Vec<BudgetReport>,
    /// The same in arcseconds, where all its parameters are tilts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arcsec: Option<ArcsecReport>,
}

/// What depends on the value at which a parameter is held that is not estimable.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct ConditionalReport {
    /// The parameter that is held.
    pub held: String,
    /// Another value of it was tried: so far away, in `unit`, what it hides in following.
    pub by: f64,
    /// Unit of `by`.
    pub unit: String,
    /// Which estimates change by more than a tenth of their standard uncertainty, and by how many of it.
    pub shifts: BTreeMap<String, f64>,
}

/// A covariance matrix.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct CovarianceReport {
    /// Names of the rows and columns.
    pub order: Vec<String>,
    /// The matrix, row by row, in products of the parameters' units (tilts in rad; correlations are pure numbers); null for what is not estimable.
    pub matrix: Vec<Vec<Option<f64>>>,
}

/// Sums over the whole fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct FitSummary {
    /// Values read (rows), without priors.
    pub readings: usize,
    /// Prior rows.
    pub priors: usize,
    /// Rank of the design matrix.
    pub rank: usize,
    /// Rank tolerance, relative to the largest diagonal element of R.
    pub rank_tolerance: f64,
    /// Degrees of freedom.
    pub dof: usize,
    /// `sqrt(sum_of_squares / dof)`: in the sensor's unit where no uncertainty is stated, else a pure number that should be near 1.
    pub residual_sd: Option<f64>,
    /// Weighted sum of squared residuals, in the square of the unit of `residual_sd`.
    pub sum_of_squares: f64,
    /// The same where all uncertainties are stated: chi-square.
    pub chi_square: Option<f64>,
    /// Probability of a larger chi-square if the model is right.
    pub p: Option<f64>,
    /// Is `p` below one minus the level, so that the model or the uncertainties are rejected? Absent where there is no such test.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub global_test_rejected: Option<bool>,
    /// Condition number of the scaled design matrix.
    pub condition: Option<f64>,
    /// `stated` (uncertainties as given) or `estimated` (from the residuals).
    pub variance: VarianceFrom,
    /// Estimated standard deviation of each sensor whose scatter was estimated.
    pub sensor_sd: BTreeMap<String, Option<f64>>,
    /// Sensors whose readings scatter by no more than the rounding of their numbers; their standard deviation is that rounding.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub at_rounding: Vec<String>,
    /// The last decimal place of their readings, for those whose standard deviation is that of rounding to it, `step/sqrt 12`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub resolution: BTreeMap<String, f64>,
    /// What a person should look at: angles that may be radians, an absurd condition number.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub remarks: Vec<Sentence>,
    /// Closed circles whose readings disagree with all others by degrees: mean of what is left, in the sensor's unit; the worst first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inconsistent_circles: Vec<CircleReport>,
    /// Largest difference between exact and linear model at the solution, in units of the readings' standard uncertainty.
    pub linearisation_error: Option<f64>,
    /// Is the answer "rejected" (rank defect, uncertainties that cannot be known, failed global test, no convergence)?
    pub rejected: bool,
}

/// A closed circle that disagrees with the others.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct CircleReport {
    /// The sensor.
    pub sensor: String,
    /// Mean residual of its readings, in its unit.
    pub mean_residual: f64,
    /// The same in degrees.
    pub mean_residual_deg: f64,
}

/// One value that was read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct ReadingReport {
    /// Number of the reading in the file, from 1.
    pub index: usize,
    /// Its position label.
    pub position: String,
    /// The sensor.
    pub sensor: String,
    /// Value read, in the sensor's unit.
    pub value: f64,
    /// Value of the fitted model, in the sensor's unit.
    pub fitted: f64,
    /// Value minus fitted, in the sensor's unit.
    pub residual: f64,
    /// Standard uncertainty that the adjustment used, in the sensor's unit.
    pub u: Option<f64>,
    /// Diagonal of the hat matrix, 0 to 1.
    pub leverage: f64,
    /// Redundancy number, 0 to 1.
    pub redundancy: f64,
    /// Internally studentized residual, a pure number.
    pub studentized: Option<f64>,
    /// Minimal detectable bias, in the sensor's unit.
    pub mdb: Option<f64>,
    /// What a fault of that size would do to each parameter, undetected (external reliability); tilts in arcseconds.
    #[schemars(with = "Option<BTreeMap<String, f64>>")]
    pub external: Option<EachParameter>,
    /// Weight of the robust estimator, 0 to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robust_weight: Option<f64>,
}

/// The record of Gauss-Newton.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct ConvergenceReport {
    /// Did it converge?
    pub converged: bool,
    /// Why it ended.
    pub stop: Stop,
    /// Parameters that the reference point does not determine and that kept their reference values.
    pub held: Vec<String>,
    /// Parameters that no reading responds to at the reference point, where their factor is zero: the iteration started from a point nearby.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub moved: Vec<String>,
    /// Each iteration.
    pub iterations: Vec<IterationReport>,
    /// Exact minus linear estimate of each parameter.
    pub change: BTreeMap<String, f64>,
}

/// One iteration.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct IterationReport {
    /// Weighted sum of squares before the step, in the square of the unit of `residual_sd`.
    pub sum_of_squares: f64,
    /// Norm of the weighted change of the predictions.
    pub step: f64,
    /// Share of the step taken, 0 to 1.
    pub share: f64,
}
