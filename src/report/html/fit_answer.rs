//! The head of a fit's page: the verdicts, and the fit in a few sentences.

use super::{Section, Tone, cells, checks_page, conformity_page};
use crate::fit::Fit;
use crate::fit::VarianceFrom;
use crate::language::{Language, say};
use crate::report::FitReport;
use crate::report::table::significant;

/// What the fit says, in verdicts and a paragraph.
pub(super) fn answer(of: &Fit, report: &FitReport, lang: Language) -> Section {
    let fit = &report.fit;
    let mut section = Section::new(say!(lang, "result"));
    if let Some((tone, text)) = conformity_page::verdict(report, lang) {
        section = section.verdict(tone, text);
    }
    for defect in &report.not_estimable {
        section = section.verdict(Tone::Bad, say!(lang, "not-everything-is-estimable-is-free-see", text = defect.text));
    }
    for source in report.scatter.iter().filter(|source| !source.without_u.is_empty()) {
        let note = source.note.as_ref().map_or(String::new(), |note| note.say(lang).to_string());
        let source = crate::report::scatter::source_name(&source.source, lang);
        section = section.verdict(Tone::Bad, say!(lang, "source-note-sentence", source, note));
    }
    section = match (fit.chi_square, fit.p) {
        (Some(chi_square), Some(p)) => {
            let rejected = fit.global_test_rejected == Some(true);
            let tone = if rejected { Tone::Bad } else { Tone::Good };
            let words = if rejected {
                say!(lang, "the-readings-scatter-more-than-their-stated")
            } else {
                say!(lang, "the-readings-scatter-as-their-stated-uncertainties")
            };
            section.verdict(
                tone,
                say!(
                    lang,
                    "global-test-chi-square-with-p",
                    words,
                    chi_square = significant(chi_square, 4),
                    dof = lang.count(fit.dof, "degree"),
                    p = significant(p, 3)
                ),
            )
        }
        _ if fit.variance == VarianceFrom::Estimated && fit.dof > 0 => section.verdict(
            Tone::Plain,
            if report.checks.misfit().is_some() {
                say!(lang, "the-readings-state-no-uncertainty-of-their")
            } else {
                say!(lang, "the-readings-state-no-uncertainty-of-their-2")
            },
        ),
        _ if fit.dof == 0 => section.verdict(Tone::Caution, say!(lang, "no-degrees-of-freedom-the-readings-just")),
        _ => section,
    };
    for (tone, text) in checks_page::verdicts(report, lang) {
        section = section.verdict(tone, text);
    }
    for remark in &fit.remarks {
        section = section.verdict(Tone::Caution, lang.sentence(&remark.say(lang)));
    }
    for (sensor, step) in &fit.resolution {
        section = section.verdict(
            Tone::Caution,
            say!(lang, "the-readings-of-scatter-no-more-than", sensor, step = significant(*step, 1)),
        );
    }
    let differ: Vec<String> =
        report.nonlinear.iter().map(|(id, share)| format!("`{id}` {} u", significant(*share, 2))).collect();
    if report.convergence.is_none() && !differ.is_empty() {
        let what = differ.join(lang.comma());
        section = section.verdict(Tone::Caution, say!(lang, "one-linear-step-is-not-enough-gauss", what));
    }
    if let Some(record) = &report.convergence {
        let tone = if record.converged { Tone::Good } else { Tone::Bad };
        let word = if record.converged { say!(lang, "converged") } else { say!(lang, "did-not-converge") };
        let steps = lang.count(record.iterations.len(), "iteration");
        let why = if record.converged { String::new() } else { say!(lang, "colon-why", why = record.stop.said()) };
        let linear = match (record.converged, differ.is_empty()) {
            (false, _) => String::new(),
            (true, true) => format!("{}{}", lang.space(), say!(lang, "the-linear-estimates-one-step-from-the")),
            (true, false) => format!(
                "{}{}",
                lang.space(),
                say!(lang, "the-linear-estimates-one-step-from-the-2", differ = differ.join(lang.comma()))
            ),
        };
        section = section.verdict(tone, say!(lang, "gauss-newton-after", word, steps, why, linear));
        if !record.moved.is_empty() {
            section = section.prose(say!(
                lang,
                "no-reading-responds-to-at-the-reference-2",
                moved = cells::names(&record.moved, lang)
            ));
        }
        if !record.held.is_empty() {
            section = section.prose(say!(
                lang,
                "held-where-the-iteration-began-since-the-2",
                held = cells::names(&record.held, lang)
            ));
        }
    }
    for own in &report.conditional {
        let shifts: Vec<String> = own.shifts.iter().map(|(id, u)| format!("`{id}` {} u", significant(*u, 2))).collect();
        section = section.verdict(
            Tone::Caution,
            say!(
                lang,
                "u-holds-only-for-as-held-another-2",
                held = own.held,
                by = with_unit(own.by, &own.unit),
                shifts = shifts.join(lang.comma())
            ),
        );
    }
    // a step that went well is no verdict on a calibration that did not
    section.without_praise();
    section.prose(summary(of, report, lang))
}

fn summary(fit: &Fit, report: &FitReport, lang: Language) -> String {
    let sums = &report.fit;
    let readings = lang.count(sums.readings, "reading");
    let priors = (sums.priors > 0).then(|| lang.count(sums.priors, "prior"));
    let mut text = say!(
        lang,
        "from-the-fit-estimates-rank-of-freedom",
        from = lang.list(&[vec![readings], priors.into_iter().collect()].concat()),
        parameters = lang.count(report.parameters.len(), "parameter"),
        rank = sums.rank.to_string(),
        dof = lang.count(sums.dof, "degree")
    );
    let mut angles: Vec<(&str, f64)> =
        report.parameters.iter().filter_map(|p| Some((p.id.as_str(), p.arcsec.and_then(|a| a.expanded)?))).collect();
    angles.sort_by(|a, b| a.1.total_cmp(&b.1));
    let level = report.parameters.first().map_or(0.95, |p| p.level);
    if let (Some((best, low)), Some((worst, high)), true) = (angles.first(), angles.last(), angles.len() > 1) {
        let [low, high] = [low, high].map(|u| significant(*u, 2));
        text.push_str(&if low == high {
            format!(
                "{}{}",
                lang.space(),
                say!(lang, "at-every-angle-is-known-to-arcsec", level = cells::level(level), high)
            )
        } else {
            format!(
                "{}{}",
                lang.space(),
                say!(lang, "at-the-angles-are-known-to-between", level = cells::level(level), low, best, high, worst)
            )
        });
    }
    let scatter: Vec<String> = sums
        .sensor_sd
        .iter()
        .filter_map(|(sensor, sd)| {
            Some(say!(lang, "fit-answer-for", sd = with_unit((*sd)?, &unit_of(fit, sensor)), sensor))
        })
        .collect();
    if !scatter.is_empty() {
        text.push_str(&format!(
            "{}{}",
            lang.space(),
            say!(lang, "residual-standard-deviation", scatter = scatter.join(lang.comma()))
        ));
    }
    if let Some(condition) = sums.condition {
        text.push_str(&format!(
            "{}{}",
            lang.space(),
            say!(lang, "the-scaled-design-matrix-has-condition-number", condition = significant(condition, 3))
        ));
    }
    text
}

fn unit_of(fit: &Fit, sensor: &str) -> String {
    // sensors of a report are those of its bench
    fit.campaign.bench.sensors.iter().find(|s| s.id == sensor).map(|s| s.unit.clone()).unwrap_or_default()
}

fn with_unit(value: f64, unit: &str) -> String {
    format!("{} {unit}", significant(value, 3)).trim_end().to_string()
}
