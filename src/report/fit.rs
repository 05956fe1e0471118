//! The fit report (`--json`): its keys and what they mean, and how it is made from a fit.

use super::checks::{
    self, ChecksReport, ConstraintsReport, EachParameter, MonteCarloReport, RecordReport, RobustReport,
};
use super::conformity::{self, ConformityReport};
use super::scatter::{self, ScatterReport};
use super::separation::{NotEstimableReport, not_estimable};
use super::site::{self, SiteReport};
use super::{ARCSEC, Input, VERSION, finite};
use crate::campaign::{Campaign, Derived, Distribution, Identity, Kind, Role};
use crate::correction::Calibration;
use crate::fit::{
    self, Circle, Conditional, Estimator, Fit, Iteration, ScaleFactorError, ScaleFactorFrom, Sector, State, Stop,
    VarianceFrom,
};
use crate::language::{Sentence, sentence};
use crate::number::as_stated;
use crate::report::ReportKind;
use crate::uncertainty::{Combined, Contribution};
use crate::wire::{CorrectionFile, CovarianceFile};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What `tumble fit --json` writes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "FitReport")]
#[non_exhaustive]
pub struct FitReport<R = Vec<ReadingReport>> {
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
    pub covariance: CovarianceFile,
    /// Sums over the whole fit.
    pub fit: FitSummary,
    /// What the readings leave free.
    pub not_estimable: Vec<NotEstimableReport>,
    /// What is determined of parameters that are not estimable alone, with values.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub estimable_combinations: Vec<CombinationValueReport>,
    /// Estimates that depend on the values at which something that is not estimable is held: their `U` holds only given those.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub conditional: Vec<Conditional>,
    /// Parameters whose exact and linear estimates differ by more than a tenth of their standard uncertainty, and by how many of it (exact
    /// minus linear; with `--linear`, what Gauss-Newton would change next).
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub nonlinear: BTreeMap<String, f64>,
    /// Each value that was read.
    pub readings: R,
    /// Correlations of the estimated parameters.
    pub correlation: CovarianceFile,
    /// How readings of this unit are corrected; absent where no sensor follows a rate or specific force that the fit determines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub correction: Option<CorrectionFile>,
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
pub struct ParameterReport {
    /// Name.
    pub id: String,
    /// `tilt` or `coefficient`.
    pub kind: Kind,
    /// Unit of value and uncertainties.
    pub unit: String,
    /// Estimate, in `unit`; null where it is not estimable.
    pub value: Option<f64>,
    /// Its uncertainty.
    #[serde(flatten)]
    pub combined: Uncertainty,
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
    /// `free`, `at-bound`, `fixed` (equations leave it one value) or `not-estimable`.
    pub state: State,
}

/// The uncertainty of a quantity, in its unit; null where it is not known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Uncertainty {
    /// Combined standard uncertainty, in `unit`.
    pub u: Option<f64>,
    /// Effective degrees of freedom; null for infinite.
    pub dof: Option<f64>,
    /// Coverage factor.
    pub k: Option<f64>,
    /// Expanded uncertainty, in `unit`.
    #[serde(rename = "U")]
    pub expanded: Option<f64>,
}

impl From<Option<Combined>> for Uncertainty {
    fn from(of: Option<Combined>) -> Self {
        let (u, k, expanded) = (of.map(|c| c.u), of.map(|c| c.coverage_factor), of.map(|c| c.expanded));
        Uncertainty { u, dof: of.and_then(|c| finite(c.dof)), k, expanded }
    }
}

/// A line of a budget.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BudgetReport {
    /// The contribution.
    #[serde(flatten)]
    pub of: Contribution,
    /// Share of the variance, 0 to 1; of correlated inputs also beyond, and negative.
    pub share: f64,
}

/// An angle in arcseconds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
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

impl KnownReport {
    /// Value and u as they were stated, and their unit: of tilts arcseconds.
    pub(super) fn shown(&self) -> (f64, f64, &str) {
        let (scale, unit) = if self.unit == "rad" { (ARCSEC, "arcsec") } else { (1.0, self.unit.as_str()) };
        (as_stated(self.value * scale), as_stated(self.u * scale), unit)
    }
}

/// A quantity as a person reads it: angles in arcseconds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shown<'a> {
    pub id: &'a str,
    pub value: Option<f64>,
    pub u: Option<f64>,
    pub expanded: Option<f64>,
    pub unit: &'a str,
    pub is_angle: bool,
    /// What the numbers of the report are multiplied by.
    pub scale: f64,
    pub dof: Option<f64>,
    pub k: Option<f64>,
    pub budget: &'a [BudgetReport],
}

impl<'a> Shown<'a> {
    fn of(
        (id, unit): (&'a str, &'a str),
        value: Option<f64>,
        Uncertainty { u, dof, k, expanded }: Uncertainty,
        budget: &'a [BudgetReport],
        is_angle: bool,
    ) -> Self {
        let (scale, unit) = if is_angle { (ARCSEC, "arcsec") } else { (1.0, unit) };
        let [value, u, expanded] = [value, u, expanded].map(|x| x.map(|x| x * scale));
        Shown { id, value, u, expanded, unit, is_angle, scale, dof, k, budget }
    }
}

impl ParameterReport {
    pub(super) fn shown(&self) -> Shown<'_> {
        Shown::of((&self.id, &self.unit), self.value, self.combined, &self.budget, self.kind == Kind::Tilt)
    }
}

impl DerivedReport {
    pub(super) fn shown(&self) -> Shown<'_> {
        Shown::of((&self.id, &self.unit), self.value, self.combined, &self.budget, self.arcsec.is_some())
    }
}

impl CombinationValueReport {
    pub(super) fn shown(&self) -> Shown<'_> {
        Shown::of((&self.text, &self.unit), Some(self.value), self.combined, &self.budget, self.arcsec.is_some())
    }
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
    pub(crate) fn is_misfit(&self) -> bool {
        self.fit.global_test_rejected == Some(true)
            || self.checks.misfit().is_some_and(|test| test.rejected)
            || self.checks.snooping.as_ref().is_some_and(|found| !found.suspects.is_empty())
            || !self.checks.follows.is_empty()
    }

    /// Parameters, then derived quantities, as a person reads them.
    pub(super) fn quantities(&self) -> impl Iterator<Item = Shown<'_>> {
        self.parameters.iter().map(ParameterReport::shown).chain(self.derived.iter().map(DerivedReport::shown))
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
    /// Its uncertainty.
    #[serde(flatten)]
    pub combined: Uncertainty,
    /// Coverage interval of an azimuth `atan2(y, x)`, in `unit`: the directions that y and x together allow; the whole circle where they may
    /// both be zero. Of other lines, with inequality constraints, that about the estimate without them, cut to what they allow. Absent where it is
    /// `value - U` to `value + U`.
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
pub struct CombinationValueReport {
    /// Coefficient of each parameter.
    pub combination: BTreeMap<String, f64>,
    /// The same as a line of text.
    pub text: String,
    /// Unit: that of the first parameter, whose coefficient is 1.
    pub unit: String,
    /// Value, in `unit`.
    pub value: f64,
    /// Its uncertainty.
    #[serde(flatten)]
    pub combined: Uncertainty,
    /// Where the uncertainty comes from.
    pub budget: Vec<BudgetReport>,
    /// The same in arcseconds, where all its parameters are tilts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arcsec: Option<ArcsecReport>,
}

/// Sums over the whole fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
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
    pub inconsistent_circles: Vec<Circle>,
    /// Largest difference between exact and linear model at the solution, in units of the readings' standard uncertainty.
    pub linearisation_error: Option<f64>,
    /// Is the answer "rejected" (rank defect, uncertainties that cannot be known, failed global test, no convergence)?
    pub rejected: bool,
}

/// One value that was read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
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
    pub iterations: Vec<Iteration>,
    /// Exact minus linear estimate of each parameter.
    pub change: BTreeMap<String, f64>,
}

/// The report of a fit.
pub fn fit_report(fit: &Fit) -> FitReport {
    with_readings(fit, readings(fit).collect())
}

/// The same without its list of readings, which takes a kilobyte for each.
pub fn fit_summary(fit: &Fit) -> FitReport {
    with_readings(fit, Vec::new())
}

/// The whole report, whose readings are made one by one as it is written.
#[cfg(feature = "cli")]
pub(crate) fn fit_to_write(fit: &Fit) -> FitReport<impl Serialize + '_> {
    with_readings(fit, Written(fit))
}

#[cfg(feature = "cli")]
struct Written<'a>(&'a Fit);

#[cfg(feature = "cli")]
impl Serialize for Written<'_> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(readings(self.0))
    }
}

fn with_readings<R>(fit: &Fit, readings: R) -> FitReport<R> {
    let campaign = &fit.campaign;
    let order: Vec<String> = campaign.estimated().iter().map(|p| p.id.clone()).collect();
    let scales_known = fit.estimate.group_scale.iter().all(Option::is_some);
    let estimable = |k: usize| scales_known && fit.parameters.get(k).is_some_and(|p| p.uncertainty.is_some());
    let matrix: Vec<Vec<Option<f64>>> = (0..order.len())
        .map(|i| (0..order.len()).map(|j| (estimable(i) && estimable(j)).then(|| fit.covariance[(i, j)])).collect())
        .collect();
    FitReport {
        correction: CorrectionFile::of(&Calibration::of(fit)),
        tumble: VERSION.into(),
        report: ReportKind::Fit,
        bench: campaign.bench.id.clone(),
        model: super::model_lines(campaign),
        estimator: fit.settings.estimator,
        identity: campaign.identity.clone(),
        inputs: Vec::new(),
        conformity: conformity::conformity(fit),
        site: site::site(&campaign.bench),
        parameters: fit.parameters.iter().map(|p| parameter(p, fit.settings.level)).collect(),
        known: known(campaign),
        correlations: campaign.correlations.clone(),
        derived: fit
            .derived
            .iter()
            .zip(&campaign.derived)
            .map(|(d, definition)| derived(d, definition, fit.settings.level))
            .chain(fit.scale_factor_errors().iter().map(scale_factor_error))
            .collect(),
        assumed_zero: fit.assumed_zero().map(str::to_string).collect(),
        correlation: CovarianceFile { order: order.clone(), matrix: correlation(&matrix) },
        covariance: CovarianceFile { order, matrix },
        scatter: scatter::scatter(fit),
        checks: checks::checks(fit),
        record: checks::record(fit),
        constraints: checks::constraints(fit),
        robust: checks::robust(fit),
        monte_carlo: None,
        fit: summary(fit),
        not_estimable: fit.not_estimable.iter().map(|separation| not_estimable(campaign, separation)).collect(),
        estimable_combinations: fit.combinations.iter().map(combination).collect(),
        conditional: fit.conditional.clone(),
        nonlinear: nonlinear(fit),
        readings,
        convergence: fit.convergence.as_ref().map(|record| ConvergenceReport {
            converged: record.converged,
            stop: record.stop,
            held: ids(campaign, &record.held),
            moved: ids(campaign, &record.moved),
            iterations: record.iterations.clone(),
            change: campaign
                .estimated()
                .iter()
                .zip(fit.point.iter().zip(&record.linear))
                .map(|(p, (exact, linear))| (p.id.clone(), exact - linear))
                .collect(),
        }),
    }
}

fn ids(campaign: &Campaign, parameters: &[usize]) -> Vec<String> {
    parameters.iter().filter_map(|k| campaign.parameters.get(*k)).map(|p| p.id.clone()).collect()
}

/// Differences of exact and linear estimates that matter.
fn nonlinear(fit: &Fit) -> BTreeMap<String, f64> {
    let shares = fit.parameters.iter().zip(&fit.nonlinearity);
    shares.filter_map(|(p, share)| Some((p.id.clone(), share.filter(|share| share.abs() > fit::VISIBLE)?))).collect()
}

fn combination(result: &fit::CombinationResult) -> CombinationValueReport {
    let uncertainty = result.uncertainty;
    CombinationValueReport {
        combination: result.combination.terms.iter().cloned().collect(),
        text: result.combination.text.clone(),
        unit: result.unit.clone(),
        value: result.value,
        combined: uncertainty.into(),
        budget: budget(&result.budget),
        arcsec: result.is_angle.then(|| arcsec(Some(result.value), uncertainty)),
    }
}

/// Correlations from covariances; 1 on the diagonal, null where a variance is zero.
fn correlation(covariance: &[Vec<Option<f64>>]) -> Vec<Vec<Option<f64>>> {
    let element = |i: usize, j: usize| covariance.get(i).and_then(|row| row.get(j)).copied().flatten();
    let one = |i: usize, j: usize| {
        let product = element(i, i)? * element(j, j)?;
        (product > 0.0)
            .then(|| if i == j { Some(1.0) } else { Some((element(i, j)? / product.sqrt()).clamp(-1.0, 1.0)) })?
    };
    (0..covariance.len()).map(|i| (0..covariance.len()).map(|j| one(i, j)).collect()).collect()
}

fn budget(contributions: &[Contribution]) -> Vec<BudgetReport> {
    let most = contributions.iter().map(|c| c.u.abs()).fold(0.0_f64, f64::max);
    let square = |u: f64| if most > 0.0 { (u / most) * (u / most).abs() } else { 0.0 };
    let total: f64 = contributions.iter().map(|c| square(c.u)).sum();
    contributions
        .iter()
        .map(|c| BudgetReport { of: c.clone(), share: if total > 0.0 { square(c.u) / total } else { 0.0 } })
        .collect()
}

fn arcsec(value: Option<f64>, uncertainty: Option<Combined>) -> ArcsecReport {
    ArcsecReport {
        value: value.map(|v| v * ARCSEC),
        u: uncertainty.map(|c| c.u * ARCSEC),
        expanded: uncertainty.map(|c| c.expanded * ARCSEC),
    }
}

fn parameter(result: &fit::ParameterResult, level: f64) -> ParameterReport {
    let uncertainty = result.uncertainty;
    ParameterReport {
        id: result.id.clone(),
        kind: result.kind,
        unit: result.unit.clone(),
        value: result.value,
        combined: uncertainty.into(),
        level,
        interval: result.interval.map(|(low, high)| [low, high]),
        type_a: uncertainty.map(|c| c.type_a),
        type_b: uncertainty.map(|c| c.type_b),
        budget: budget(&result.budget),
        arcsec: (result.kind == Kind::Tilt && result.state != State::NotEstimable)
            .then(|| arcsec(result.value, uncertainty)),
        state: result.state,
    }
}

fn derived(result: &fit::DerivedResult, definition: &Derived, level: f64) -> DerivedReport {
    let uncertainty = result.uncertainty;
    let symmetric = result.value.zip(uncertainty).map(|(value, own)| (value - own.expanded, value + own.expanded));
    let bounded = result.interval.filter(|own| Some(*own) != symmetric).map(<[f64; 2]>::from);
    DerivedReport {
        id: result.id.clone(),
        line: definition.written.as_ref().map_or_else(|| result.line.clone(), ToString::to_string),
        unit: if result.is_angle { "rad".into() } else { definition.unit.clone() },
        value: result.value,
        combined: uncertainty.into(),
        interval: sector_ends(result).or(bounded),
        note: azimuth_note(result, level).or_else(|| {
            let (numbers, unit) = ((result.value?, uncertainty?.expanded), definition.unit.as_str());
            interval_note(
                numbers,
                bounded?,
                if result.is_angle { (ARCSEC, "arcsec") } else { (1.0, unit) },
                level,
                true,
            )
        }),
        budget: budget(&result.budget),
        arcsec: result.is_angle.then(|| arcsec(result.value, uncertainty)),
    }
}

fn scale_factor_error(error: &ScaleFactorError) -> DerivedReport {
    let uncertainty = error.uncertainty;
    DerivedReport {
        id: error.id.clone(),
        line: error.line.clone(),
        unit: "ppm".into(),
        value: Some(error.value),
        combined: uncertainty.into(),
        interval: None,
        note: match error.from {
            ScaleFactorFrom::Largest { alike, of } if alike > 1 => Some(sentence!("largest-of-alike", of, alike)),
            ScaleFactorFrom::Runs(runs) => Some(sentence!("scatter-of-runs", runs)),
            _ => None,
        },
        budget: budget(&error.budget),
        arcsec: None,
    }
}

/// The interval of an azimuth; the whole circle about its value where that may be any.
fn sector_ends(result: &fit::DerivedResult) -> Option<[f64; 2]> {
    match result.sector? {
        Sector::Between(low, high) => Some([low, high]),
        Sector::Circle => {
            let (value, half) = (result.value?, result.uncertainty?.expanded);
            Some([value - half, value + half])
        }
    }
}

/// An interval whose ends are off `value - U` or `value + U` by more than this share of U is told.
const OFF: f64 = 0.05;

/// What the value and U of an azimuth do not say.
fn azimuth_note(result: &fit::DerivedResult, level: f64) -> Option<Sentence> {
    if result.sector? == Sector::Circle {
        return Some(sentence!("azimuth-is-any"));
    }
    let scaled = if result.is_angle { (ARCSEC, "arcsec") } else { (1.0, "") };
    interval_note((result.value?, result.uncertainty?.expanded), sector_ends(result)?, scaled, level, false)
}

/// That an interval is not the value and U, where it is not; one that bounds cut, or that of an azimuth.
pub(super) fn interval_note(
    (value, expanded): (f64, f64),
    [low, high]: [f64; 2],
    (scale, unit): (f64, &str),
    level: f64,
    bounded: bool,
) -> Option<Sentence> {
    let off = |end: f64| (end.abs() - expanded).abs() > OFF * expanded;
    if !off(high - value) && !off(value - low) {
        return None;
    }
    let end = |end: f64| crate::document::number::significant(end * scale, 5);
    Some(sentence!(
        "azimuth-interval",
        bounded,
        level = crate::document::number::percent(level),
        low = end(low),
        high = end(high),
        unit = if unit.is_empty() { String::new() } else { format!(" {unit}") }
    ))
}

fn known(campaign: &Campaign) -> Vec<KnownReport> {
    campaign
        .parameters
        .iter()
        .filter_map(|parameter| match parameter.role {
            Role::Known(known) => Some(KnownReport {
                id: parameter.id.clone(),
                value: known.value,
                unit: parameter.unit.clone(),
                u: known.u,
                dof: finite(known.dof),
                distribution: known.distribution,
            }),
            _ => None,
        })
        .collect()
}

fn summary(fit: &Fit) -> FitSummary {
    let estimate = &fit.estimate;
    let estimated = fit.system.group.iter().any(|g| matches!(g, crate::estimate::Group::Estimated(_)));
    let mut sensor_sd = BTreeMap::new();
    for (origin, group) in fit.design.rows.iter().zip(&fit.system.group) {
        if let (crate::estimate::Group::Estimated(g), Some(sensor)) =
            (group, fit.campaign.bench.sensors.get(origin.sensor))
        {
            sensor_sd.entry(sensor.id.clone()).or_insert_with(|| estimate.group_scale.get(*g).copied().flatten());
        }
    }
    FitSummary {
        readings: fit.streamed.as_ref().map_or(fit.design.rows.len(), |streamed| crate::number::index(streamed.values)),
        priors: fit.system.observed.len() - fit.design.rows.len(),
        rank: estimate.unknowns.rank,
        rank_tolerance: estimate.factor.tolerance(),
        dof: estimate.dof,
        residual_sd: fit.residual_sd(),
        sum_of_squares: fit.sum_of_squares(),
        chi_square: fit.global_test.map(|test| test.chi_square),
        p: fit.global_test.map(|test| test.p),
        global_test_rejected: fit.global_test.map(|test| test.rejected),
        condition: estimate.unknowns.condition().and_then(finite),
        variance: if estimated { VarianceFrom::Estimated } else { VarianceFrom::Stated },
        sensor_sd,
        at_rounding: fit.at_rounding().into_iter().map(str::to_string).collect(),
        resolution: fit
            .at_rounding()
            .into_iter()
            .filter_map(|sensor| Some((sensor.to_string(), fit.resolution_of(sensor)?)))
            .collect(),
        remarks: fit.remarks(),
        inconsistent_circles: fit.inconsistent_circles(),
        linearisation_error: fit.linearisation_error,
        rejected: fit.is_rejected(),
    }
}

fn readings(fit: &Fit) -> impl Iterator<Item = ReadingReport> + '_ {
    let names = checks::Names::of(fit);
    let rows = fit.design.rows.iter().zip(&fit.design.predicted).zip(fit.quality().zip(&fit.system.observed));
    rows.enumerate().map(move |(row, ((origin, predicted), (quality, observed)))| {
        let reading = fit.campaign.readings.rows.get(origin.reading);
        let value = predicted + observed;
        ReadingReport {
            index: fit.number(origin.reading),
            position: fit.campaign.position_of(origin.reading).to_string(),
            sensor: fit.campaign.sensor_id(origin.sensor).to_string(),
            value: reading
                .and_then(|r| r.observations.iter().find(|o| o.sensor == origin.sensor))
                .map_or(value, |observation| observation.value),
            fitted: value - quality.residual,
            residual: quality.residual,
            u: quality.u,
            leverage: quality.leverage,
            redundancy: quality.redundancy,
            studentized: quality.studentized,
            mdb: fit.checks.detectable.get(row).copied().flatten().or(quality.mdb),
            external: checks::external(fit, &names, row),
            robust_weight: fit.robust.as_ref().and_then(|record| record.weights.get(row)).copied(),
        }
    })
}
