//! The fit report from a fit.

use super::fit::{
    ArcsecReport, BudgetReport, CircleReport, CombinationValueReport, ConditionalReport, ConvergenceReport,
    CovarianceReport, DerivedReport, FitReport, FitSummary, IterationReport, KnownReport, ParameterReport,
    ReadingReport,
};
use super::separation::not_estimable;
use super::{ARCSEC, VERSION, finite, fit_checks, fit_constraints, record, scatter};
use crate::campaign::{Campaign, Derived, Kind, Role};
use crate::correction::Calibration;
use crate::fit::{Fit, ScaleFactorError, ScaleFactorFrom, Sector, State, VarianceFrom};
use crate::language::{Sentence, sentence};
use crate::report::ReportKind;
use crate::uncertainty::{Combined, Contribution};
use crate::wire::CorrectionFile;
use std::collections::BTreeMap;

/// The report of a fit.
pub fn fit_report(fit: &Fit) -> FitReport {
    FitReport { readings: readings(fit), ..fit_summary(fit) }
}

/// The same without its list of readings, which takes a kilobyte for each.
pub fn fit_summary(fit: &Fit) -> FitReport {
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
        model: campaign.bench.sensors.iter().map(|s| (s.id.clone(), s.model.to_string())).collect(),
        estimator: fit.settings.estimator,
        identity: campaign.identity.clone(),
        inputs: Vec::new(),
        conformity: super::conformity::conformity(fit),
        site: super::site::site(&campaign.bench),
        parameters: fit.parameters.iter().map(|p| parameter(p, fit.settings.level)).collect(),
        known: known(campaign),
        correlations: campaign.correlations.clone(),
        derived: fit
            .derived
            .iter()
            .zip(&campaign.derived)
            .map(|(d, own)| derived(d, own, fit.settings.level))
            .chain(fit.scale_factor_errors().iter().map(scale_factor_error))
            .collect(),
        assumed_zero: fit.assumed_zero().map(str::to_string).collect(),
        correlation: CovarianceReport { order: order.clone(), matrix: correlation(&matrix) },
        covariance: CovarianceReport { order, matrix },
        scatter: scatter::scatter(fit),
        checks: fit_checks::checks(fit),
        record: record::record(fit),
        constraints: fit_constraints::constraints(fit),
        robust: fit_checks::robust(fit),
        monte_carlo: None,
        fit: summary(fit),
        not_estimable: fit.not_estimable.iter().map(|separation| not_estimable(campaign, separation)).collect(),
        estimable_combinations: fit.combinations.iter().map(combination).collect(),
        conditional: fit.conditional.iter().map(|own| conditional(campaign, own)).collect(),
        nonlinear: nonlinear(fit),
        readings: Vec::new(),
        convergence: fit.convergence.as_ref().map(|record| ConvergenceReport {
            converged: record.converged,
            stop: record.stop,
            held: ids(campaign, &record.held),
            moved: ids(campaign, &record.moved),
            iterations: record
                .iterations
                .iter()
                .map(|i| IterationReport { sum_of_squares: i.sum_of_squares, step: i.step, share: i.share })
                .collect(),
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
    shares
        .filter_map(|(own, share)| Some((own.id.clone(), share.filter(|share| share.abs() > crate::fit::VISIBLE)?)))
        .collect()
}

fn combination(result: &crate::fit::CombinationResult) -> CombinationValueReport {
    let uncertainty = result.uncertainty;
    CombinationValueReport {
        combination: result.combination.terms.iter().cloned().collect(),
        text: result.combination.text.clone(),
        unit: result.unit.clone(),
        value: result.value,
        u: uncertainty.map(|c| c.u),
        dof: uncertainty.and_then(|c| finite(c.dof)),
        k: uncertainty.map(|c| c.coverage_factor),
        expanded: uncertainty.map(|c| c.expanded),
        budget: budget(&result.budget),
        arcsec: result.is_angle.then(|| arcsec(Some(result.value), uncertainty)),
    }
}

fn conditional(campaign: &Campaign, own: &crate::fit::Conditional) -> ConditionalReport {
    let parameter = |k: usize| campaign.parameters.get(k);
    let id = |k: usize| parameter(k).map_or(String::new(), |p| p.id.clone());
    let tilt = parameter(own.held).is_some_and(|p| p.kind == Kind::Tilt);
    ConditionalReport {
        held: id(own.held),
        by: own.by * if tilt { ARCSEC } else { 1.0 },
        unit: if tilt { "arcsec".into() } else { parameter(own.held).map_or(String::new(), |p| p.unit.clone()) },
        shifts: own.shifts.iter().map(|(k, share)| (id(*k), *share)).collect(),
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
        .map(|c| BudgetReport {
            source: c.source.clone(),
            evaluation: c.evaluation,
            distribution: c.distribution,
            u: c.u,
            estimate: c.estimate,
            c: c.sensitivity,
            source_u: c.source_u,
            dof: finite(c.dof),
            share: if total > 0.0 { square(c.u) / total } else { 0.0 },
        })
        .collect()
}

fn arcsec(value: Option<f64>, uncertainty: Option<Combined>) -> ArcsecReport {
    ArcsecReport {
        value: value.map(|v| v * ARCSEC),
        u: uncertainty.map(|c| c.u * ARCSEC),
        expanded: uncertainty.map(|c| c.expanded * ARCSEC),
    }
}

fn parameter(result: &crate::fit::ParameterResult, level: f64) -> ParameterReport {
    let uncertainty = result.uncertainty;
    ParameterReport {
        id: result.id.clone(),
        kind: result.kind,
        unit: result.unit.clone(),
        value: result.value,
        u: uncertainty.map(|c| c.u),
        dof: uncertainty.and_then(|c| finite(c.dof)),
        k: uncertainty.map(|c| c.coverage_factor),
        expanded: uncertainty.map(|c| c.expanded),
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

fn derived(result: &crate::fit::DerivedResult, own: &Derived, level: f64) -> DerivedReport {
    let uncertainty = result.uncertainty;
    DerivedReport {
        id: result.id.clone(),
        line: own.written.as_ref().map_or_else(|| result.line.clone(), ToString::to_string),
        unit: if result.is_angle { "rad".into() } else { own.unit.clone() },
        value: result.value,
        u: uncertainty.map(|c| c.u),
        dof: uncertainty.and_then(|c| finite(c.dof)),
        k: uncertainty.map(|c| c.coverage_factor),
        expanded: uncertainty.map(|c| c.expanded),
        interval: sector_ends(result),
        note: azimuth_note(result, level),
        budget: budget(&result.budget),
        arcsec: result.is_angle.then(|| arcsec(result.value, uncertainty)),
    }
}

fn scale_factor_error(own: &ScaleFactorError) -> DerivedReport {
    let uncertainty = own.uncertainty;
    DerivedReport {
        id: own.id.clone(),
        line: own.line.clone(),
        unit: "ppm".into(),
        value: Some(own.value),
        u: uncertainty.map(|c| c.u),
        dof: uncertainty.and_then(|c| finite(c.dof)),
        k: uncertainty.map(|c| c.coverage_factor),
        expanded: uncertainty.map(|c| c.expanded),
        interval: None,
        note: match own.from {
            ScaleFactorFrom::Largest { alike, of } if alike > 1 => Some(sentence!("largest-of-alike", of, alike)),
            ScaleFactorFrom::Runs(runs) => Some(sentence!("scatter-of-runs", runs)),
            _ => None,
        },
        budget: budget(&own.budget),
        arcsec: None,
    }
}

/// The interval of an azimuth; the whole circle about its value where that may be any.
fn sector_ends(result: &crate::fit::DerivedResult) -> Option<[f64; 2]> {
    match result.sector? {
        Sector::Between(low, high) => Some([low, high]),
        Sector::Circle => {
            let (value, half) = (result.value?, result.uncertainty?.expanded);
            Some([value - half, value + half])
        }
    }
}

/// An interval of an azimuth whose ends are off `value - U` or `value + U` by more than this share of U is told.
const OFF: f64 = 0.05;

/// What the value and U of an azimuth do not say.
fn azimuth_note(result: &crate::fit::DerivedResult, level: f64) -> Option<Sentence> {
    if result.sector? == Sector::Circle {
        return Some(sentence!("azimuth-is-any"));
    }
    let (value, expanded, [low, high]) = (result.value?, result.uncertainty?.expanded, sector_ends(result)?);
    let off = |end: f64| (end.abs() - expanded).abs() > OFF * expanded;
    if !off(high - value) && !off(value - low) {
        return None;
    }
    let (scale, unit) = if result.is_angle { (ARCSEC, "arcsec") } else { (1.0, "") };
    let end = |end: f64| crate::document::number::significant(end * scale, 5);
    Some(sentence!(
        "azimuth-interval",
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

fn circle(fit: &Fit, sensor: &str, mean_residual: f64) -> CircleReport {
    let turn = fit.campaign.bench.sensors.iter().find(|own| own.id == sensor).and_then(|own| own.turn);
    CircleReport {
        sensor: sensor.to_string(),
        mean_residual,
        mean_residual_deg: turn.map_or(0.0, |turn| 360.0 * mean_residual / turn),
    }
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
        readings: fit.streamed.as_ref().map_or(fit.design.rows.len(), |own| crate::number::index(own.values)),
        priors: fit.system.observed.len() - fit.design.rows.len(),
        rank: estimate.unknowns.rank,
        rank_tolerance: estimate.factor.tolerance(),
        dof: estimate.dof,
        residual_sd: fit.residual_sd(),
        sum_of_squares: fit.sum_of_squares(),
        chi_square: fit.global_test.map(|test| test.chi_square),
        p: fit.global_test.map(|test| test.p),
        global_test_rejected: fit.global_test.map(|test| test.rejected),
        condition: estimate.unknowns.condition.and_then(finite),
        variance: if estimated { VarianceFrom::Estimated } else { VarianceFrom::Stated },
        sensor_sd,
        at_rounding: fit.at_rounding().into_iter().map(str::to_string).collect(),
        resolution: fit
            .at_rounding()
            .into_iter()
            .filter_map(|sensor| Some((sensor.to_string(), fit.resolution_of(sensor)?)))
            .collect(),
        remarks: fit.remarks(),
        inconsistent_circles: fit
            .inconsistent_circles()
            .into_iter()
            .map(|(sensor, mean)| circle(fit, sensor, mean))
            .collect(),
        linearisation_error: fit.linearisation_error,
        rejected: fit.is_rejected(),
    }
}

fn readings(fit: &Fit) -> Vec<ReadingReport> {
    let mut reports = Vec::with_capacity(fit.design.rows.len());
    let names = fit_checks::Names::of(fit);
    for (row, ((origin, predicted), (quality, observed))) in
        fit.design.rows.iter().zip(&fit.design.predicted).zip(fit.quality.iter().zip(&fit.system.observed)).enumerate()
    {
        let reading = fit.campaign.readings.rows.get(origin.reading);
        let value = predicted + observed;
        reports.push(ReadingReport {
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
            external: fit_checks::external(fit, &names, row),
            robust_weight: fit.robust.as_ref().and_then(|record| record.weights.get(row)).copied(),
        });
    }
    reports
}
