//! From a campaign to every parameter with its uncertainty: the pipeline in one call, and its result as a value.
//!
//! ```text
//! campaign -> design matrix -> system (weights, priors as rows) -> estimate -> quality, uncertainty
//! ```
//!
//! Exact by default: Gauss-Newton on the exact rotations, to convergence. Linear on request: one least-squares step from the reference point.

mod azimuth;
mod checks;
mod conditional;
mod conformity;
mod gauss_newton;
mod names;
mod noise;
mod parameters;
mod propagate;
mod ranges;
mod remarks;
mod robust;
mod rules;
mod scale_factor;
mod scatter;
mod separate;
mod starts;
mod step;
pub mod streamed;
mod system;

pub use azimuth::{Sector, sector};
pub(crate) use checks::{Checks, cells, changes, is_all, positions, same, stuck};
pub(crate) use conditional::{Circle, Conditional};
pub use conformity::{Conformity, judge};
pub use gauss_newton::Stop;
pub(crate) use gauss_newton::{Convergence, INVISIBLE, Iteration, NEGLIGIBLE};
pub(crate) use names::{NamedCombination, sum};
pub(crate) use noise::{ScatterSources, VarianceFrom, VarianceSource, is_correlation};
pub use parameters::{Angle, ParameterResult, State};
pub(crate) use parameters::{CombinationResult, DerivedResult, SAME, moved};
pub use propagate::draw;
pub(crate) use propagate::{Drawn, MOST_TRIALS};
pub(crate) use ranges::{LEAST, MOST, check as check_ranges, check_rows};
pub use robust::RobustMethod;
pub(crate) use robust::RobustRecord;
pub use rules::{Constraints, Cost};
pub(crate) use scale_factor::{ScaleFactorError, ScaleFactorFrom};
pub use scatter::scatter_lines;
pub(crate) use scatter::{floor, own_noise, scattered, spelled_out, stated_variances, whitening};
pub(crate) use separate::{RankDefect, candidates, columns_read, separations};
pub(crate) use starts::by_coefficients;
pub(crate) use step::{adjust_meeting_equations, adjust_with_equations, contradicting_equations};
pub use system::{Weighting, weigh};
pub(crate) use system::{known_inputs, rounding_of, stated_here_and_there};

use crate::campaign::{Campaign, Known, Role};
use crate::design::{self, DesignMatrix, Model};
use crate::error::{self, Fault, Malformed, Result};
use crate::estimate::{self, Estimate, Group, System};
use crate::quality::{self, GlobalTest, RowQuality, Tested};
use crate::uncertainty::quantiles::{chi_square_survival, fisher_f_survival};
use crate::vocabulary::vocabulary;
use faer::Mat;
use parameters::{BudgetInputs, Told};
use std::borrow::Cow;

vocabulary! {
    /// How far to go from the reference point.
    #[derive(Default)]
    Estimator {
        /// Gauss-Newton on the exact model, to convergence.
        #[default]
        Exact = "exact",
        /// One least-squares step: the linear estimator of the papers, whose closed forms are its square special case.
        Linear = "linear",
    }
}

/// How to fit.
#[derive(Debug, Clone, Copy)]
pub struct Settings {
    /// To convergence on the exact model, or one linear step.
    pub estimator: Estimator,
    /// What stated standard uncertainties of readings mean.
    pub weighting: Weighting,
    /// Coverage probability of expanded uncertainties, between 0 and 1; one minus it is the significance of the global test.
    pub level: f64,
    /// Settings of the adjustment itself.
    pub adjust: estimate::Settings,
    /// Most Gauss-Newton iterations.
    pub iterations: usize,
    /// Bear bad readings instead of least squares.
    pub robust: Option<RobustMethod>,
    /// Whether readings that share a position share an offset.
    pub remount: Remount,
}

/// Whether readings that share a position share a random offset, as they do where each position was mounted anew.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Remount {
    /// Readings are independent.
    #[default]
    No,
    /// They share one; its variance is estimated with the readings' (REML).
    Estimate,
    /// They share one with this standard uncertainty, in the sensor's unit.
    Stated(f64),
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            estimator: Estimator::Exact,
            weighting: Weighting::AsStated,
            level: 0.95,
            adjust: estimate::Settings::default(),
            iterations: 100,
            robust: None,
            remount: Remount::No,
        }
    }
}

pub use crate::number::resolution;
#[cfg(feature = "cli")]
pub(crate) use remarks::STEEP;

/// Everything that a fit found.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The question.
    pub campaign: Campaign,
    /// How it was answered.
    pub settings: Settings,
    /// The design matrix at the point of linearisation.
    pub design: DesignMatrix,
    /// The weighted system; rows of the design first, then one row for each prior.
    pub system: System,
    /// The adjustment, a bound that is active being an equation.
    pub estimate: Estimate,
    /// Estimated values, all parameters in campaign order (those not estimable at their reference).
    pub point: Vec<f64>,
    /// Results for the estimated parameters.
    pub parameters: Vec<ParameterResult>,
    /// Full covariance of the estimated parameters: readings and known inputs.
    pub covariance: Mat<f64>,
    /// Results for derived quantities.
    pub derived: Vec<DerivedResult>,
    /// What is determined of parameters that are not estimable alone.
    pub combinations: Vec<CombinationResult>,
    /// Along each free direction, which estimates depend on the values at which it is held.
    pub conditional: Vec<Conditional>,
    /// What scatters in the readings, and how the estimates follow each of them.
    pub noise: ScatterSources,
    /// Known inputs with an uncertainty (parameter index), and how the estimated parameters follow each.
    pub known_sensitivities: Vec<(usize, Known, Vec<f64>)>,
    /// What became of the constraints.
    pub constraints: Constraints,
    /// What the robust estimator did, where one was asked for.
    pub robust: Option<RobustRecord>,
    /// Did scales, variance components and robust weights settle?
    pub settled: bool,
    /// Do the readings agree with the model: replicates, order and shape of the residuals, suspicious readings.
    pub checks: Checks,
    /// What the quality of rows comes from beside the estimate.
    pub(crate) tested: Option<Tested>,
    /// The global test, where every uncertainty is stated.
    pub global_test: Option<GlobalTest>,
    /// What only combinations of parameters determine.
    pub not_estimable: Vec<RankDefect>,
    /// The record of Gauss-Newton; `None` for the linear estimator.
    pub convergence: Option<Convergence>,
    /// Largest difference, over the readings and in units of their standard uncertainty, between the exact model at the solution and the
    /// linear one; `None` where no uncertainty is known.
    pub linearisation_error: Option<f64>,
    /// Exact minus linear estimate of each estimated parameter, in units of its standard uncertainty; for the linear estimator what
    /// Gauss-Newton would change next. `None` where no uncertainty is known.
    pub nonlinearity: Vec<Option<f64>>,
    /// Where the readings are a sample of a record that was streamed: what is known of all of it.
    pub streamed: Option<streamed::Streamed>,
}

impl Fit {
    /// Quality of each row of the system: of many readings a list of it would be as large as their design.
    pub fn quality(&self) -> impl Iterator<Item = RowQuality> + '_ {
        let delta = quality::baarda_delta();
        // of a record that was streamed they are those of its independent rows
        let streamed = self.streamed.as_ref().map(|own| &own.quality);
        (0..self.system.observed.len()).map(move |row| {
            let own = RowQuality::of(&self.system, &self.estimate, self.tested.as_ref(), delta, row);
            match streamed.and_then(|list| list.get(row)) {
                Some((u, studentized)) => RowQuality { u: Some(*u), studentized: *studentized, mdb: None, ..own },
                None => own,
            }
        })
    }

    /// Is the answer "rejected": a rank defect, a stuck channel, uncertainties that cannot be known, a failed global test, or no convergence?
    pub fn is_rejected(&self) -> bool {
        !self.not_estimable.is_empty()
            || self.global_test.is_some_and(|test| test.rejected)
            || matches!(self.constraints, Constraints::Contradictory(_) | Constraints::NotApplied)
            || self.bounds_are_rejected() == Some(true)
            || self.equations_are_rejected() == Some(true)
            || !self.settled
            || !self.stuck().is_empty()
            || !self.noise.absorbed.is_empty()
            || !self.inconsistent_circles().is_empty()
            || self.convergence.as_ref().is_some_and(|convergence| !convergence.converged)
    }

    /// Estimated parameters whose uncertainty cannot be known, since they follow deviations of this line of the campaign's scatter, and nothing
    /// else shows these.
    pub(crate) fn without_u_for(&self, line: usize) -> Vec<&str> {
        let Some((_, own)) = self.noise.absorbed.iter().find(|(k, _)| *k == line) else { return Vec::new() };
        let touched = |k: usize| self.estimate.unknowns.is_estimable(k) && own.touches_unknown(k);
        self.parameters.iter().enumerate().filter(|(k, _)| touched(*k)).map(|(_, own)| own.id.as_str()).collect()
    }

    /// Sum of squared residuals in units of their weights. Where all readings are of one scale that is estimated, it is in the square of the sensor's
    /// unit, whatever else scatters.
    pub fn sum_of_squares(&self) -> f64 {
        let alone = self.system.is_of_one_scale();
        if self.campaign.scatter.is_empty() || !alone || self.streamed.is_some() {
            return self.estimate.sum_of_squares;
        }
        self.estimate.residuals.iter().zip(&self.system.u).map(|(v, u)| (v / u).powi(2)).sum()
    }

    /// Residual standard deviation, `sqrt(sum_of_squares / dof)`; `None` without degrees of freedom.
    pub fn residual_sd(&self) -> Option<f64> {
        (self.estimate.dof > 0).then(|| (self.sum_of_squares() / self.estimate.dof as f64).sqrt())
    }

    /// Do the readings contradict the bounds that are active, at the level? `None` where none is active.
    pub(crate) fn bounds_are_rejected(&self) -> Option<bool> {
        self.bounds_p().map(|p| p < 1.0 - self.settings.level)
    }

    /// Probability that bounds which are true cost as much as the active ones do; `None` where none is active. An inequality that is true costs less than
    /// an equation.
    pub(crate) fn bounds_p(&self) -> Option<f64> {
        let Constraints::Met { active, cost, .. } = &self.constraints else { return None };
        // each active bound is an equation of the adjustment
        let dof = self.estimate.dof.saturating_sub(active.len());
        self.cost_p(Cost { chi_square: *cost, count: active.len(), dof })
    }

    /// Do the readings contradict the equations, at the level? `None` where there are none, or where they take nothing that the readings tell.
    pub(crate) fn equations_are_rejected(&self) -> Option<bool> {
        self.equations_p().map(|p| p < 1.0 - self.settings.level)
    }

    /// Probability that equations which are true cost as much.
    pub(crate) fn equations_p(&self) -> Option<f64> {
        let Constraints::Met { equations, .. } = &self.constraints else { return None };
        self.cost_p((*equations)?)
    }

    /// The cost of `k` equations that are true is `chi^2_k`, or `k F(k, dof)` where the variance is estimated.
    fn cost_p(&self, Cost { chi_square, count, dof }: Cost) -> Option<f64> {
        if count == 0 || !chi_square.is_finite() {
            return None;
        }
        let estimated = self.system.group.iter().all(|group| matches!(group, Group::Estimated(_)));
        match estimated {
            true if dof == 0 => None,
            true => fisher_f_survival(chi_square / count as f64, count as f64, dof as f64),
            false => chi_square_survival(chi_square, count as f64),
        }
    }

    /// Closed circles whose readings no attitude makes agree with the others, the worst first. A target on another side, a point sighted wrongly or a start too far away leaves degrees, not noise.
    pub(crate) fn inconsistent_circles(&self) -> Vec<Circle> {
        /// Share of a turn that no noise reaches.
        const FAR: f64 = 1.0 / 360.0;
        let mut found: Vec<(Circle, f64)> = Vec::new();
        for (s, sensor) in self.campaign.bench.sensors.iter().enumerate() {
            let Some(turn) = sensor.turn else { continue };
            let rows = self.design.rows.iter().zip(&self.estimate.residuals).filter(|(origin, _)| origin.sensor == s);
            let (count, sum, size) =
                rows.fold((0.0, 0.0, 0.0), |(n, sum, size), (_, v)| (n + 1.0, sum + v, size + v.abs()));
            if count > 0.0 && size / count > FAR * turn {
                let (sensor, mean_residual) = (sensor.id.clone(), sum / count);
                let mean_residual_deg = 360.0 * mean_residual / turn;
                found.push((Circle { sensor, mean_residual, mean_residual_deg }, size / count));
            }
        }
        found.sort_by(|a, b| b.1.total_cmp(&a.1));
        found.into_iter().map(|(circle, _)| circle).collect()
    }

    /// What the smallest fault of a row that a test at 0.1 % finds with 80 % power would do to an estimated parameter (by index) if nobody found
    /// it: external reliability; `None` where no such fault is known.
    pub(crate) fn external(&self, row: usize, parameter: usize) -> Option<f64> {
        let fault = self.checks.detectable.get(row).copied().flatten()?;
        let felt = parameter < self.noise.sensitivities.nrows() && row < self.noise.sensitivities.ncols();
        felt.then(|| self.noise.sensitivities[(parameter, row)] * fault)
    }

    /// Sensors whose estimated scatter is no more than the rounding of their readings: a campaign without noise.
    pub(crate) fn at_rounding(&self) -> Vec<&str> {
        let least = system::rounding(&self.campaign, &self.design, &self.system);
        let mut found = Vec::new();
        for (origin, group) in self.design.rows.iter().zip(&self.system.group) {
            let Group::Estimated(g) = *group else { continue };
            let scale = self.estimate.group_scale.get(g).copied().flatten();
            let own = scale.zip(least.get(g)).is_some_and(|(scale, least)| scale <= least * (1.0 + 1e-9));
            if let Some(sensor) = self.campaign.bench.sensors.get(origin.sensor).filter(|_| own)
                && !found.contains(&sensor.id.as_str())
            {
                found.push(sensor.id.as_str());
            }
        }
        found
    }

    /// The last decimal place of a sensor's readings, where their scatter is taken to be that of rounding to it.
    pub(crate) fn resolution_of(&self, sensor: &str) -> Option<f64> {
        let k = self.campaign.bench.sensors.iter().position(|own| own.id == sensor)?;
        self.at_rounding().contains(&sensor).then(|| system::sensor_resolution(&self.campaign, k))?
    }

    /// Number (from 1) of a reading in the file or record that it comes from.
    pub fn number(&self, reading: usize) -> usize {
        let number = self.streamed.as_ref().and_then(|own| own.numbers.get(reading));
        number.map_or(reading + 1, |number| crate::number::index(*number))
    }

    /// What a person should look at: angles that may be radians, a condition number beyond what units explain.
    pub fn remarks(&self) -> Vec<crate::language::Sentence> {
        remarks::remarks(self)
    }

    /// Parameters of the bench that are taken as zero.
    pub(crate) fn assumed_zero(&self) -> impl Iterator<Item = &str> {
        self.campaign.parameters.iter().filter(|p| p.role == Role::AssumedZero).map(|p| p.id.as_str())
    }
}

/// Fit a campaign.
///
/// `x = argmin sum ((y - f(x)) / u)^2`: the fixed point of `x0 + argmin sum ((y - f(x0) - J (x - x0)) / u)^2`, which is the linear estimator.
/// Errors: no readings, nothing to estimate, a level outside (0, 1), a sensor whose readings have a stated uncertainty only here and there,
/// a model line that uses what a reading lacks. Rank defects, failed tests and non-convergence are part of the result.
///
/// ```
/// use tumble::{fit, wire};
/// let text = r#"{ "bench": { "id": "line", "sensors": { "y": { "model": "a + b*x" } } },
///     "estimate": { "a": {}, "b": {} },
///     "readings": [ {"x": 0, "y": 1}, {"x": 1, "y": 3}, {"x": 2, "y": 4} ] }"#;
/// let source = wire::Source { name: "line".into(), text: text.into() };
/// let campaign = wire::read_campaign(&source, &mut |_| unreachable!())?;
/// let fit = fit::fit(&campaign, &fit::Settings::default())?;
/// assert!((fit.point[1] - 1.5).abs() < 1e-15);
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
pub fn fit(campaign: &Campaign, settings: &Settings) -> Result<Fit> {
    of(Cow::Borrowed(campaign), settings, true)
}

/// The same without a second copy of the readings. Errors: those of [`fit`].
pub fn fit_owned(campaign: Campaign, settings: &Settings) -> Result<Fit> {
    of(Cow::Owned(campaign), settings, true)
}

/// The same without what is only said of it where something is not estimable: for one of many that are tried. Errors: those of [`fit`].
pub(crate) fn tried(campaign: &Campaign, settings: &Settings) -> Result<Fit> {
    of(Cow::Borrowed(campaign), settings, false)
}

fn of(given: Cow<'_, Campaign>, settings: &Settings, is_told: bool) -> Result<Fit> {
    let campaign: &Campaign = &given;
    check_level(settings.level)?;
    check_combination(campaign, settings)?;
    askable(campaign)?;
    let spelled_out = match scatter::spelled_out(campaign, settings.remount)? {
        Cow::Owned(longer) => Some(longer),
        Cow::Borrowed(_) => None,
    };
    let given = spelled_out.map_or(given, Cow::Owned);
    let campaign: &Campaign = &given;
    let model = Model::new(campaign)?;
    let reference = campaign.reference_point();
    let design = design::assemble(campaign, &model, &reference)?;
    ranges::check_rows(campaign, &model, &design)?;
    // at the reference point
    let unseen = starts::unseen(campaign, &design);
    let gauss_newton::Ended { design, step, record: convergence, judged_at, weak } =
        gauss_newton::run(campaign, &model, design, settings).map_err(|error| ranges::name_reading(campaign, error))?;
    let mut point = design.point.clone();
    for (value, change) in point.iter_mut().zip(&step.change) {
        *value += change;
    }
    rules::snap(campaign, &step.constraints, &mut point);
    // where Gauss-Newton has settled, the solution is the point of linearisation
    let settled_there = convergence.as_ref().is_some_and(|record| record.converged);
    let assembled = if settled_there { None } else { Some(design.at(campaign, &model, &point)?) };
    let at_solution = assembled.as_ref().unwrap_or(&design);
    let linearisation_error = gauss_newton::linearisation_error(at_solution, &design, &step.system, &step.own.estimate);
    let checks = checks::checks(campaign, &design, &step, settings.level);
    let (tested, adjusted, _) = step.tested();
    // with an estimated variance among them, chi-square is what that variance makes it
    let stated = step.own.noise.sources.iter().all(|source| !source.estimated);
    let global_test = quality::global_test(tested, adjusted, settings.level).filter(|_| stated);
    let tested = step.tested_beside();
    let step::Step { system, own, on_face, constraints, .. } = step;
    let step::Adjusted { estimate, mut noise, robust, settled, scattered, .. } = own;
    let known = parameters::known_inputs(campaign, at_solution, &noise);
    let budgets = BudgetInputs {
        campaign,
        estimate: &estimate,
        noise: &noise,
        known,
        level: settings.level,
        weak: &weak,
        judged_at: judged_at.as_deref(),
    };
    let free = if let Constraints::Met { free, .. } = &constraints { free } else { &point };
    let Told { parameters, covariance, derived, combinations, known: known_sensitivities } =
        budgets.told(&point, free, &constraints)?;
    // budgets are those of the estimate without bounds, what a fault does is that of the one with them
    noise.sensitivities = on_face.unwrap_or(noise.sensitivities);
    let (mut not_estimable, mut conditional) = (Vec::new(), Vec::new());
    if is_told && !estimate.unknowns.not_estimable.is_empty() {
        let judged = judged_at.map(|point| design.at(campaign, &model, &point)).transpose()?;
        not_estimable = separate::separations(campaign, &model, judged.as_ref().unwrap_or(&design), &estimate, &weak);
        conditional =
            conditional::conditional(campaign, &model, &point, (&estimate, scattered.as_ref()), &parameters, settings)?;
    }
    let nonlinearity =
        nonlinearity(campaign, &parameters, &point, at_solution, settings, convergence.as_ref(), &unseen);
    Ok(Fit {
        campaign: given.into_owned(),
        // the campaign has what it stands for
        settings: Settings { remount: Remount::No, ..*settings },
        design,
        system,
        estimate,
        point,
        parameters,
        covariance,
        derived,
        combinations,
        conditional,
        noise,
        known_sensitivities,
        constraints,
        robust,
        settled,
        checks,
        tested,
        global_test,
        not_estimable,
        convergence,
        linearisation_error,
        nonlinearity,
        streamed: None,
    })
}

/// Refuse a level that is no probability.
pub(crate) fn check_level(level: f64) -> Result<()> {
    error::probability("level", level, "0.95")
}

/// Refuse a campaign that asks nothing, or whose numbers no fit can square.
pub(crate) fn askable(campaign: &Campaign) -> Result<()> {
    ranges::check(campaign)?;
    if campaign.unknowns() == 0 {
        return Err(Malformed::new(Fault::Missing, "nothing is to be estimated")
            .expected("at least one parameter in \"estimate\", for example { \"V0\": {} }")
            .at_path("estimate"));
    }
    if !campaign.is_measured() {
        let sensors: Vec<&str> = campaign.bench.sensors.iter().map(|s| s.id.as_str()).collect();
        let what =
            if campaign.readings.rows.is_empty() { "there are no readings" } else { "no reading has a sensor value" };
        if let Some((sensor, column)) = campaign.meant_for_a_sensor() {
            return Err(Malformed::new(
                Fault::Missing,
                format!("{what}: is the column '{column}' meant for '{sensor}'?"),
            )
            .expected(format!("a column '{sensor}' (\"columns\": {{ \"{sensor}\": \"{column}\" }} names it)"))
            .at_path("readings"));
        }
        return Err(Malformed::new(Fault::Missing, what)
            .expected(format!("readings with a value for {}", sensors.join(" or ")))
            .found(match campaign.readings.columns.join(", ") {
                _ if campaign.readings.rows.is_empty() => "an empty list".into(),
                none if none.is_empty() => "a schedule (positions without values)".into(),
                columns => format!("a schedule (positions without values), or their title is one of {columns}"),
            })
            .at_path("readings"));
    }
    Ok(())
}

/// Differences below this share of u are told of no one.
pub(crate) const VISIBLE: f64 = 0.1;

/// Exact minus linear estimate of each parameter in units of its standard uncertainty. The linear estimator does not know the exact one: there
/// it is the step that Gauss-Newton would take next.
fn nonlinearity(
    campaign: &Campaign,
    parameters: &[ParameterResult],
    point: &[f64],
    at_solution: &DesignMatrix,
    settings: &Settings,
    record: Option<&Convergence>,
    unseen: &[usize],
) -> Vec<Option<f64>> {
    let mut change: Vec<f64> = match record {
        Some(record) => point.iter().zip(&record.linear).map(|(exact, linear)| exact - linear).collect(),
        None => match step::solve(campaign, at_solution, settings) {
            Ok(next) => next.change,
            Err(_) => Vec::new(),
        },
    };
    // of readings without scatter the difference is the rounding of the arithmetic
    let DesignMatrix { jacobian, predicted, .. } = at_solution;
    let moved = |i: usize| change.iter().enumerate().take(jacobian.ncols()).map(|(k, c)| c * jacobian[(i, k)]).sum();
    let squares = (0..predicted.len()).map(|i| f64::powi(moved(i), 2)).sum();
    let largest = predicted.iter().fold(0.0_f64, |most, y| most.max(y.abs()));
    if quality::is_rounding(squares, predicted.len(), largest) {
        change.fill(0.0);
    }
    let mut found = in_uncertainties(parameters, &change);
    if record.is_some() && found.iter().flatten().any(|share| share.abs() > VISIBLE) {
        // what the reference point does not determine has no linear estimate
        for k in unseen {
            found.get_mut(*k).into_iter().for_each(|slot| *slot = None);
        }
    }
    found
}

/// Changes of the parameters in units of their standard uncertainties.
fn in_uncertainties(parameters: &[ParameterResult], change: &[f64]) -> Vec<Option<f64>> {
    let of = |(k, result): (usize, &ParameterResult)| {
        let u = result.uncertainty.map(|combined| combined.u).filter(|u| *u > 0.0)?;
        change.get(k).map(|change| change / u).filter(|share| share.is_finite())
    };
    parameters.iter().enumerate().map(of).collect()
}

/// Robust estimation is supported neither with constraints nor with shared deviations.
fn check_combination(campaign: &Campaign, settings: &Settings) -> Result<()> {
    if let Remount::Stated(u) = settings.remount
        && !(u > 0.0 && u.is_finite())
    {
        return Err(Malformed::new(Fault::Value, "the standard uncertainty of remounting cannot be used")
            .expected("a positive number in the sensor's unit, or 'estimate'")
            .found(u.to_string()));
    }
    if settings.robust.is_none() {
        return Ok(());
    }
    if !campaign.constraints.is_empty() {
        return Err(Malformed::new(Fault::Value, "robust estimation with constraints is not supported")
            .expected("constraints with least squares, or a robust estimate without constraints")
            .at_path("constraints"));
    }
    if settings.remount != Remount::No || !campaign.scatter.is_empty() {
        return Err(Malformed::new(
            Fault::Value,
            "robust estimation with random effects of several readings is not supported: the weight of one reading does not show which of \
             them is bad",
        )
        .expected("a robust estimate without \"scatter\" and remounting, or least squares with them"));
    }
    Ok(())
}
