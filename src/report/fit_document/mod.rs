//! The document of a fit: the answer first, then where it comes from, then what it rests on.

mod answer;
mod checks;
mod correction;
mod estimates;
mod figures;
mod readings;

use super::colophon::begin;
use super::{CompareReport, FitReport, Input, compare_document, conformity, scatter};
use crate::document::{Document, Section};
use crate::fit::Fit;
use crate::language::{Language, say};
#[cfg(feature = "dcc")]
pub(super) use answer::{estimated, global_test, not_estimable};
pub(super) use readings::bench_figure;
use std::collections::BTreeMap;

/// Studentized residuals beyond this are marked.
const FAR: f64 = 3.0;

/// What else the document of a fit is made from, and what a reader of a terminal asked to see.
#[derive(Debug, Clone, Copy, Default)]
pub struct Asked<'a> {
    /// The fit itself, which knows the bench's words and the joints of each reading.
    pub fit: Option<&'a Fit>,
    /// The published closed forms beside it, where the bench has them.
    pub comparison: Option<&'a CompareReport>,
    /// Files that the fit was made from.
    pub inputs: &'a [Input],
    /// Each reading (`--readings`).
    pub readings: bool,
    /// The budget of each quantity and the correlations (`--budget`).
    pub budget: bool,
    /// The correction to apply (`--correction`).
    pub correction: bool,
}

/// The document of a fit.
pub fn fit_document(report: &FitReport, asked: &Asked<'_>, lang: Language) -> Document {
    let title = asked.fit.map(|fit| fit.campaign.bench.title.as_str()).filter(|title| !title.is_empty());
    let mut document =
        begin(title.map_or(report.bench.clone(), |title| lang.name(title).into_owned()), asked.inputs, lang);
    document.facts = report.identity.facts(lang);
    document.facts.push((say!(lang, "bench").into(), format!("`{}`", report.bench)));
    document.facts.extend(model_facts(&report.model, lang));
    let document = document
        .section(answer::answer(report, lang))
        .section(estimates::estimates(report, asked.fit, lang))
        .section(estimates::not_estimable(report, lang))
        .section(conformity::section(report.conformity.as_ref(), lang))
        .section(checks::monte_carlo(report, lang))
        .section(scatter::section(&report.scatter, lang))
        .section(checks::conditions(report, lang))
        .section(correction::correction(report, asked.correction, lang))
        .section(estimates::budget(report, asked.budget, lang))
        .section(residuals(report, lang))
        .section(checks::checks(report, lang))
        .section(checks::iterations(report, lang));
    let document = match asked.comparison {
        Some(comparison) => document.section(compare_document::section(comparison, lang)),
        None => document,
    };
    document.section(readings::assumptions(report, asked, lang)).section(readings::readings(
        report,
        asked.fit,
        asked.readings,
        lang,
    ))
}

/// Model lines as facts.
pub(super) fn model_facts(model: &BTreeMap<String, String>, lang: Language) -> impl Iterator<Item = (String, String)> {
    let name = move |k| if k == 0 { say!(lang, "model").into() } else { String::new() };
    model.iter().enumerate().map(move |(k, (sensor, line))| (name(k), format!("`{sensor} = {line}`")))
}

fn residuals(report: &FitReport, lang: Language) -> Section {
    Section::new(say!(lang, "residuals-and-correlations")).full().figures(figures::spread_figures(report, lang))
}
