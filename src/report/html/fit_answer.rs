//! The head of a fit's page: the verdicts, and the fit in a few sentences.

use super::{Section, Tone, cells, checks_page};
use crate::fit::Fit;
use crate::fit::VarianceFrom;
use crate::report::FitReport;
use crate::report::table::significant;

/// What the fit says, in verdicts and a paragraph.
pub(super) fn answer(of: &Fit, report: &FitReport) -> Section {
    let fit = &report.fit;
    let mut section = Section::new("Result");
    for defect in &report.not_estimable {
        section =
            section.verdict(Tone::Bad, format!("Not everything is estimable: `{}` is free. See below.", defect.text));
    }
    section = match (fit.chi_square, fit.p) {
        (Some(chi_square), Some(p)) => {
            let rejected = fit.global_test_rejected == Some(true);
            let tone = if rejected { Tone::Bad } else { Tone::Good };
            let words = if rejected {
                "the readings scatter more than their stated uncertainties allow: the model misses something, or the uncertainties are too small"
            } else {
                "the readings scatter as their stated uncertainties say"
            };
            section.verdict(
                tone,
                format!(
                    "Global test: {words} (chi-square {} with {}, p = {}).",
                    significant(chi_square, 4),
                    cells::count(fit.dof, "degree") + " of freedom",
                    significant(p, 3)
                ),
            )
        }
        _ if fit.variance == VarianceFrom::Estimated && fit.dof > 0 => section.verdict(
            Tone::Plain,
            if report.checks.lack_of_fit.is_some() {
                "The readings state no uncertainty of their own: their scatter is estimated from the residuals, and only their replicates test the model."
            } else {
                "The readings state no uncertainty of their own: their scatter is estimated from the residuals, so these readings alone cannot test the model."
            },
        ),
        _ if fit.dof == 0 => section.verdict(
            Tone::Caution,
            "No degrees of freedom: the readings just determine the parameters, and nothing checks them.",
        ),
        _ => section,
    };
    for (tone, text) in checks_page::verdicts(report) {
        section = section.verdict(tone, text);
    }
    for remark in &fit.remarks {
        section = section.verdict(Tone::Caution, format!("{remark}."));
    }
    for (sensor, step) in &fit.resolution {
        section = section.verdict(
            Tone::Caution,
            format!(
                "The readings of `{sensor}` scatter no more than their last digit shows: u is that of rounding to {}.",
                significant(*step, 1)
            ),
        );
    }
    let differ: Vec<String> =
        report.nonlinear.iter().map(|(id, share)| format!("`{id}` {} u", significant(*share, 2))).collect();
    if report.convergence.is_none() && !differ.is_empty() {
        let what = differ.join(", ");
        section = section.verdict(
            Tone::Caution,
            format!("One linear step is not enough: Gauss-Newton would go on by more than 0.1 u in {what}. Fit without `--linear`."),
        );
    }
    if let Some(record) = &report.convergence {
        let tone = if record.converged { Tone::Good } else { Tone::Bad };
        let word = if record.converged { "converged" } else { "did not converge" };
        let steps = cells::count(record.iterations.len(), "iteration");
        let why = if record.converged { String::new() } else { format!(": {}", record.stop) };
        let linear = match (record.converged, differ.is_empty()) {
            (false, _) => String::new(),
            (true, true) => {
                " The linear estimates (one step from the reference point) are the same within 0.1 u.".into()
            }
            (true, false) => format!(
                " The linear estimates (one step from the reference point) differ by more than 0.1 u (exact minus linear): {}.",
                differ.join(", ")
            ),
        };
        section = section.verdict(tone, format!("Gauss-Newton {word} after {steps}{why}.{linear}"));
        if !record.moved.is_empty() {
            section = section.prose(format!(
                "No reading responds to {} at the reference point, where all that they are multiplied by is zero: the fit started beside it.",
                cells::names(&record.moved)
            ));
        }
        if !record.held.is_empty() {
            section = section.prose(format!(
                "Held where the iteration began, since the exact model determines them too weakly beyond it: {}.",
                cells::names(&record.held)
            ));
        }
    }
    for own in &report.conditional {
        let shifts: Vec<String> = own.shifts.iter().map(|(id, u)| format!("`{id}` {} u", significant(*u, 2))).collect();
        section = section.verdict(
            Tone::Caution,
            format!(
                "U holds only for `{}` as held: another value of it, {} away, changes {}.",
                own.held,
                with_unit(own.by, &own.unit),
                shifts.join(", ")
            ),
        );
    }
    section.prose(summary(of, report))
}

fn summary(fit: &Fit, report: &FitReport) -> String {
    let sums = &report.fit;
    let mut text = format!(
        "From {}{} the fit estimates {} (rank {}, {} of freedom).",
        cells::count(sums.readings, "reading"),
        if sums.priors > 0 { format!(" and {}", cells::count(sums.priors, "prior")) } else { String::new() },
        cells::count(report.parameters.len(), "parameter"),
        sums.rank,
        cells::count(sums.dof, "degree"),
    );
    let mut angles: Vec<(&str, f64)> =
        report.parameters.iter().filter_map(|p| Some((p.id.as_str(), p.arcsec.and_then(|a| a.expanded)?))).collect();
    angles.sort_by(|a, b| a.1.total_cmp(&b.1));
    let level = report.parameters.first().map_or(0.95, |p| p.level);
    if let (Some((best, low)), Some((worst, high)), true) = (angles.first(), angles.last(), angles.len() > 1) {
        let [low, high] = [low, high].map(|u| significant(*u, 2));
        text.push_str(&if low == high {
            format!(" At {}, every angle is known to {} arcsec.", cells::level(level), high)
        } else {
            format!(
                " At {}, the angles are known to between {} arcsec (`{best}`) and {} arcsec (`{worst}`).",
                cells::level(level),
                low,
                high
            )
        });
    }
    let scatter: Vec<String> = sums
        .sensor_sd
        .iter()
        .filter_map(|(sensor, sd)| Some(format!("{} for `{sensor}`", with_unit((*sd)?, &unit_of(fit, sensor)))))
        .collect();
    if !scatter.is_empty() {
        text.push_str(&format!(" Residual standard deviation: {}.", scatter.join(", ")));
    }
    if let Some(condition) = sums.condition {
        text.push_str(&format!(" The scaled design matrix has condition number {}.", significant(condition, 3)));
    }
    text
}

fn unit_of(fit: &Fit, sensor: &str) -> String {
    fit.campaign.bench.sensors.iter().find(|s| s.id == sensor).map(|s| s.unit.clone()).unwrap_or_default()
}

fn with_unit(value: f64, unit: &str) -> String {
    format!("{} {unit}", significant(value, 3)).trim_end().to_string()
}
