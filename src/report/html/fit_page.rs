//! The page of a fit: the answer first, then where it comes from, then what it rests on.

use super::colophon::colophon;
use super::fit_figures::{residual_figures, spread_figures};
use super::{
    Page, Section, checks_page, compare_page, conformity_page, fit_answer, fit_correction, fit_estimates, fit_readings,
    scatter_page,
};
use crate::error::Result;
use crate::fit::Estimator;
use crate::fit::Fit;
use crate::language::{Language, say};
use crate::report::{CompareReport, FitReport, Input};

/// The page of a fit.
///
/// `comparison` with the published closed forms is shown where the bench has them; `inputs` are the files that the fit was made from.
pub fn fit_page(
    fit: &Fit,
    report: &FitReport,
    comparison: Option<&CompareReport>,
    inputs: &[Input],
    lang: Language,
) -> Result<Page> {
    let bench = &fit.campaign.bench;
    let mut page =
        Page::new(if bench.title.is_empty() { bench.id.clone() } else { lang.name(&bench.title).into_owned() });
    page.language = lang;
    page.subtitle = say!(lang, "calibration-every-angle-and-coefficient-with-its").into();
    page.facts = facts(fit, report, inputs, lang);
    page.colophon = colophon(inputs, lang);
    let mut page = page
        .section(fit_answer::answer(fit, report, lang))
        .section(conformity_page::section(report, lang))
        .section(fit_estimates::estimates(fit, report, lang)?)
        .section(fit_estimates::not_estimable(report, lang))
        .section(fit_correction::correction(report, lang))
        .section(fit_estimates::budget(report, lang)?)
        .section(scatter_page::scatter(&report.scatter, lang))
        .section(checks_page::monte_carlo(report, lang))
        .section(residuals(fit, report, lang)?)
        .section(checks_page::checks(report, lang))
        .section(checks_page::conditions(report, lang));
    if let Some(comparison) = comparison {
        page = page.section(compare_page::section(comparison, lang));
    }
    Ok(page.section(fit_readings::assumptions(fit, report, lang)).section(fit_readings::readings(fit, report, lang)))
}

fn facts(fit: &Fit, report: &FitReport, inputs: &[Input], lang: Language) -> Vec<(String, String)> {
    let bench = &fit.campaign.bench;
    let mut facts = vec![(say!(lang, "bench").to_string(), format!("`{}`", bench.id))];
    if !bench.source.is_empty() {
        facts.push((say!(lang, "source").into(), lang.name(&bench.source).into_owned()));
    }
    if let Some(input) = inputs.first() {
        facts.push((say!(lang, "campaign").into(), input.name.clone()));
    }
    facts.extend(report.identity.facts(lang));
    for (k, sensor) in bench.sensors.iter().enumerate() {
        let name = if k == 0 { say!(lang, "model") } else { "" };
        facts.push((name.into(), format!("`{} = {}`", sensor.id, sensor.model)));
    }
    let estimator = match report.estimator {
        Estimator::Linear => say!(lang, "one-least-squares-step-from-the-reference"),
        Estimator::Exact => say!(lang, "gauss-newton-on-the-exact-rotations"),
    };
    facts.push((
        say!(lang, "estimator").into(),
        format!("{}{}{estimator}", lang.term("estimator", report.estimator.name()), lang.colon()),
    ));
    facts
}

fn residuals(fit: &Fit, report: &FitReport, lang: Language) -> Result<Section> {
    Ok(Section::new(say!(lang, "residuals-and-correlations"))
        .figures(residual_figures(fit, report, lang)?)
        .figures(spread_figures(report, lang)?))
}
