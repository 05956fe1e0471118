//! The page of a fit: the answer first, then where it comes from, then what it rests on.

use super::fit_figures::{residual_figures, spread_figures};
use super::{
    Page, Section, checks_page, compare_page, conformity_page, fit_answer, fit_correction, fit_estimates, fit_readings,
    scatter_page,
};
use crate::error::Result;
use crate::fit::Estimator;
use crate::fit::Fit;
use crate::report::{CompareReport, FitReport, Input, VERSION};

/// The page of a fit.
///
/// `comparison` with the published closed forms is shown where the bench has them; `inputs` are the files that the fit was made from.
pub fn fit_page(fit: &Fit, report: &FitReport, comparison: Option<&CompareReport>, inputs: &[Input]) -> Result<Page> {
    let bench = &fit.campaign.bench;
    let mut page = Page::new(if bench.title.is_empty() { bench.id.clone() } else { bench.title.clone() });
    page.subtitle = "Calibration: every angle and coefficient with its uncertainty".into();
    page.facts = facts(fit, report, inputs);
    page.colophon = colophon(inputs);
    let mut page = page
        .section(fit_answer::answer(fit, report))
        .section(conformity_page::section(report))
        .section(fit_estimates::estimates(fit, report)?)
        .section(fit_estimates::not_estimable(report))
        .section(fit_correction::correction(report))
        .section(fit_estimates::budget(report)?)
        .section(scatter_page::scatter(&report.scatter))
        .section(checks_page::monte_carlo(report))
        .section(residuals(fit, report)?)
        .section(checks_page::checks(report))
        .section(checks_page::conditions(report));
    if let Some(comparison) = comparison {
        page = page.section(compare_page::section(comparison));
    }
    Ok(page.section(fit_readings::assumptions(fit, report)).section(fit_readings::readings(fit, report)))
}

/// The end of every page: version and inputs.
pub(super) fn colophon(inputs: &[Input]) -> Vec<(String, String)> {
    let mut list = vec![("made by".to_string(), format!("tumble {VERSION}; the same inputs give the same bytes"))];
    list.extend(inputs.iter().map(|input| (format!("SHA-256 of {}", input.name), format!("`{}`", input.sha256))));
    list
}

fn facts(fit: &Fit, report: &FitReport, inputs: &[Input]) -> Vec<(String, String)> {
    let bench = &fit.campaign.bench;
    let mut facts = vec![("Bench".to_string(), format!("`{}`", bench.id))];
    if !bench.source.is_empty() {
        facts.push(("Source".into(), bench.source.clone()));
    }
    if let Some(input) = inputs.first() {
        facts.push(("Campaign".into(), input.name.clone()));
    }
    facts.extend(report.identity.facts());
    for (k, sensor) in bench.sensors.iter().enumerate() {
        let name = if k == 0 { "Model" } else { "" };
        facts.push((name.into(), format!("`{} = {}`", sensor.id, sensor.model)));
    }
    let estimator = match report.estimator {
        Estimator::Linear => "one least-squares step from the reference point",
        Estimator::Exact => "Gauss-Newton on the exact rotations",
    };
    facts.push(("Estimator".into(), format!("{}: {estimator}", report.estimator)));
    facts
}

fn residuals(fit: &Fit, report: &FitReport) -> Result<Section> {
    Ok(Section::new("Residuals and correlations")
        .figures(residual_figures(fit, report)?)
        .figures(spread_figures(report)?))
}
