//! The head of a fit's document: the verdicts, and the fit in a few sentences.

use super::super::fit_constraints::ConstraintsStatus;
use super::super::{FitReport, conformity, scatter};
use crate::document::number::significant;
use crate::document::{Section, Tone};
use crate::fit::{Fit, VarianceFrom};
use crate::language::{Language, say};

/// What the fit says, in verdicts.
pub(super) fn answer(report: &FitReport, lang: Language) -> Section {
    let mut section = Section::new(say!(lang, "result"));
    for (tone, text) in verdicts(report, lang) {
        section = section.verdict(tone, text);
    }
    section
}

fn verdicts(report: &FitReport, lang: Language) -> Vec<(Tone, String)> {
    let fit = &report.fit;
    let mut said = Vec::new();
    said.extend(report.conformity.as_ref().map(|own| conformity::verdict(own, lang)));
    said.extend(not_estimable(report, lang).map(|text| (Tone::Bad, text)));
    for source in report.scatter.iter().filter(|source| !source.without_u.is_empty()) {
        let note = source.note.as_ref().map_or(String::new(), |note| note.say(lang).to_string());
        let source = scatter::source_name(&source.source, lang);
        said.push((Tone::Bad, say!(lang, "source-note-sentence", source, note)));
    }
    said.extend(global_test(report, lang));
    said.extend(checks(report, lang));
    if let Some(constraints) = &report.constraints {
        let tone = if constraints.status == ConstraintsStatus::Met { Tone::Plain } else { Tone::Bad };
        said.push((tone, lang.sentence(&constraints.verdict.say(lang))));
    }
    if let Some(robust) = report.robust.as_ref().filter(|robust| !robust.converged) {
        let method = robust.method.to_string();
        said.push((Tone::Bad, say!(lang, "the-robust-estimator-did-not-settle", method)));
    }
    for circle in &fit.inconsistent_circles {
        let mean_residual_deg = significant(circle.mean_residual_deg, 4);
        let text =
            say!(lang, "inconsistent-disagrees-with-the-other-sights-by", sensor = circle.sensor, mean_residual_deg);
        said.push((Tone::Bad, text));
    }
    said.extend(fit.remarks.iter().map(|remark| (Tone::Caution, lang.sentence(&remark.say(lang)))));
    said.extend(report.site.warnings.iter().map(|warning| (Tone::Caution, lang.sentence(&warning.say(lang)))));
    said.extend(convergence(report, lang));
    for own in &report.conditional {
        let shifts: Vec<String> = own.shifts.iter().map(|(id, u)| format!("`{id}` {} u", significant(*u, 2))).collect();
        let by = format!("{} {}", significant(own.by, 3), own.unit);
        let shifts = shifts.join(lang.comma());
        said.push((
            Tone::Caution,
            say!(lang, "u-holds-only-for-as-held-another", held = own.held, by = by.trim_end(), shifts),
        ));
    }
    said
}

pub(in crate::report) fn global_test(report: &FitReport, lang: Language) -> Option<(Tone, String)> {
    let fit = &report.fit;
    match (fit.chi_square, fit.p) {
        (Some(chi_square), Some(p)) => {
            let rejected = fit.global_test_rejected == Some(true);
            let tone = if rejected { Tone::Bad } else { Tone::Good };
            let [chi_square, p] = [significant(chi_square, 4), significant(p, 3)];
            let dof = lang.count(fit.dof, "degree");
            Some((tone, say!(lang, "global-test-chi-square-with-p", rejected, chi_square, dof, p)))
        }
        _ if fit.dof == 0 => Some((Tone::Caution, say!(lang, "no-degrees-of-freedom-the-readings-just").into())),
        _ if fit.variance == VarianceFrom::Estimated && report.checks.misfit().is_none() => {
            Some((Tone::Plain, say!(lang, "the-readings-state-no-uncertainty-of-their").into()))
        }
        _ => None,
    }
}

/// What the checks found; where the model lacks something, which command finds it.
fn checks(report: &FitReport, lang: Language) -> Vec<(Tone, String)> {
    let tests = [&report.checks.lack_of_fit, &report.checks.lack_of_fit_by_position].into_iter().flatten();
    let tones = tests.map(|test| match (test.rejected, test.is_beyond_doubt()) {
        (true, true) => Tone::Bad,
        (true, false) => Tone::Caution,
        (false, _) => Tone::Good,
    });
    // of a record the sentences say what is in order, too
    let further = if report.record.is_some() { Tone::Plain } else { Tone::Caution };
    let lines = report.checks.verdict.iter().map(|line| lang.sentence(&line.say(lang)));
    let mut said: Vec<(Tone, String)> = tones.chain(std::iter::repeat(further)).zip(lines).collect();
    if report.is_misfit() {
        said.push((Tone::Plain, lang.sentence(say!(lang, "diagnose-says-what-is-missing"))));
    }
    said
}

/// How far the estimator went, and what it changed.
fn convergence(report: &FitReport, lang: Language) -> Vec<(Tone, String)> {
    let differ: Vec<String> =
        report.nonlinear.iter().map(|(id, share)| format!("`{id}` {} u", significant(*share, 2))).collect();
    let what = differ.join(lang.comma());
    let Some(record) = &report.convergence else {
        let enough = differ.is_empty();
        let said = (!enough).then(|| (Tone::Caution, say!(lang, "one-linear-step-is-not-enough-gauss", what)));
        return said.into_iter().collect();
    };
    let steps = lang.count(record.iterations.len(), "iteration");
    let mut said = vec![match (record.converged, differ.is_empty()) {
        (false, _) => (Tone::Bad, say!(lang, "gauss-newton-did-not-converge-after", steps, stop = record.stop.said())),
        (true, true) => (Tone::Good, say!(lang, "gauss-newton-converged-after", steps)),
        (true, false) => (Tone::Plain, say!(lang, "gauss-newton-converged-and-differs", steps, what)),
    }];
    if !record.moved.is_empty() {
        said.push((
            Tone::Plain,
            say!(lang, "no-reading-responds-to-at-the-reference", moved = lang.names(&record.moved)),
        ));
    }
    if !record.held.is_empty() {
        said.push((
            Tone::Plain,
            say!(lang, "held-where-the-iteration-began-since-the", held = lang.names(&record.held)),
        ));
    }
    said
}

/// What is not estimable, in a sentence.
pub(in crate::report) fn not_estimable(report: &FitReport, lang: Language) -> Option<String> {
    let what = say!(lang, "not-estimable-from-these-readings");
    let names = lang.names(report.not_estimable.iter().map(|defect| &defect.text));
    (!report.not_estimable.is_empty()).then(|| lang.sentence(&format!("{what}{}{names}", lang.colon())))
}

/// How many readings gave how many parameters.
pub(in crate::report) fn estimated(report: &FitReport, lang: Language) -> String {
    let sums = &report.fit;
    let readings = lang.count(sums.readings, "reading");
    let priors = (sums.priors > 0).then(|| lang.count(sums.priors, "prior"));
    say!(
        lang,
        "from-the-fit-estimates-rank-of-freedom",
        from = lang.list(&[vec![readings], priors.into_iter().collect()].concat()),
        parameters = lang.count(report.parameters.len(), "parameter"),
        rank = sums.rank.to_string(),
        dof = lang.count(sums.dof, "degree")
    )
}

/// The fit in a few sentences.
pub(super) fn summary(report: &FitReport, of: Option<&Fit>, lang: Language) -> String {
    let sums = &report.fit;
    let mut said = vec![estimated(report, lang)];
    for (sensor, sd) in &sums.sensor_sd {
        // sensors of a report are those of its bench
        let unit = of.and_then(|fit| fit.campaign.bench.sensors.iter().find(|s| s.id == *sensor));
        let size = sd.map(|sd| format!("{} {}", significant(sd, 3), unit.map_or("", |s| s.unit.as_str())));
        let at_zero = report.scatter.iter().any(|own| own.at_zero && own.per == "reading" && own.of == *sensor);
        let size = size.filter(|_| !at_zero);
        let how = match (sd, sums.resolution.get(sensor)) {
            _ if at_zero => Some(say!(lang, "estimated-as-zero", below = false)),
            (None, _) => Some(say!(lang, "no-degrees-of-freedom-are-left-to").into()),
            (_, Some(step)) => Some(say!(lang, "that-of-rounding-to-its-last-digit", step = significant(*step, 1))),
            _ if sums.at_rounding.contains(sensor) => {
                Some(say!(lang, "the-rounding-of-its-readings-which-show").into())
            }
            _ => None,
        };
        let said_of = [size.map(|size| size.trim_end().to_string()), how].into_iter().flatten().collect::<Vec<_>>();
        said.push(say!(lang, "residual-sd-of", sensor, sd = said_of.join(lang.clause())));
    }
    if let Some(condition) = sums.condition {
        said.push(say!(lang, "the-scaled-design-matrix-has-condition-number", condition = significant(condition, 3)));
    }
    said.join(lang.space())
}
