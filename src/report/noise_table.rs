//! The noise of a record as tables for a terminal, and as the IMU file of kalibr.

use super::noise_analysis::{AgreementReport, CoefficientReport, NoiseAnalysisReport, NoiseColumnReport};
use super::table::{optional, plain, rounded, significant};
use crate::error::{Fault, Malformed, Result};
use crate::language::{Language, say};
use crate::noise::{Term, Without, si_factor};

/// All columns: their coefficients, then their deviations.
pub fn noise_table(report: &NoiseAnalysisReport, deviations: bool, lang: Language) -> String {
    let rate = significant(1.0 / report.interval_s, 6);
    let mut text = format!(
        "{}\n",
        say!(lang, "samples-a-second", record = report.record, rate, from = lang.name(&report.interval_from))
    );
    for column in &report.columns {
        text.push('\n');
        text.push_str(&head(column, lang));
        let rows: Vec<Vec<String>> = column.coefficients.iter().map(|own| row(own, lang)).collect();
        if !rows.is_empty() {
            text.push('\n');
            text.push_str(&plain(
                &[
                    say!(lang, "coefficient"),
                    "",
                    say!(lang, "value"),
                    "u",
                    say!(lang, "unit"),
                    "p",
                    say!(lang, "below"),
                ],
                &rows,
            ));
        }
        if let Some(without) = column.without {
            text.push_str(&format!("{}\n", reason(without, lang)));
        }
        if let Some(a) = &column.agreement {
            text.push_str(&format!("{}{}{}\n", described(a, lang), lang.colon(), numbers(a, lang)));
            if let Some(walk) = walk(a, lang) {
                text.push_str(&super::wrap::hanging(&walk, 0));
                text.push('\n');
            }
        }
        if deviations {
            text.push('\n');
            text.push_str(&points(column, lang));
        }
    }
    text
}

/// Why there are no coefficients.
pub(super) fn reason(without: Without, lang: Language) -> &'static str {
    match without {
        Without::Constant => say!(lang, "no-coefficients-constant"),
        Without::Short => say!(lang, "no-coefficients-short"),
        Without::Undescribed => say!(lang, "no-coefficients-undescribed"),
    }
}

/// Does the sum of the coefficients describe the deviations?
pub(super) fn described(agreement: &AgreementReport, lang: Language) -> &'static str {
    match agreement.describes {
        Some(false) => say!(lang, "their-sum-does-not-describe-the-deviations"),
        _ => say!(lang, "their-sum-describes-the-deviations"),
    }
}

/// How a rate random walk was taken, where it matters.
pub(super) fn walk(agreement: &AgreementReport, lang: Language) -> Option<String> {
    let interval = agreement.walk_sampled_s?;
    Some(say!(lang, "random-walk-sampled", interval = significant(interval, 3)))
}

/// The test of that.
pub(super) fn numbers(agreement: &AgreementReport, lang: Language) -> String {
    let [chi, p] = [significant(agreement.chi_square, 3), significant(agreement.p, 2)];
    say!(lang, "chi-square-dof-p", chi, dof = agreement.dof.to_string(), p)
}

fn head(column: &NoiseColumnReport, lang: Language) -> String {
    let gaps = match column.stretches {
        0 | 1 => String::new(),
        n => format!(" {}", say!(lang, "in-stretches", n = n.to_string())),
    };
    let mean = optional(column.mean, |m| significant(m, 6));
    format!(
        "{}\n",
        say!(
            lang,
            "samples-mean",
            column = column.column,
            unit = column.unit,
            samples = column.samples.to_string(),
            gaps,
            mean
        )
    )
}

fn row(c: &CoefficientReport, lang: Language) -> Vec<String> {
    vec![
        c.id.to_string(),
        lang.name(&c.name).into_owned(),
        optional(c.value, |v| rounded(v, c.u)),
        optional(c.u, |u| significant(u, 2)),
        c.unit.clone(),
        optional(c.p, |p| if p < 1e-4 { "<0.0001".into() } else { significant(p, 2) }),
        optional(c.below, |b| significant(b, 2)),
    ]
}

fn points(column: &NoiseColumnReport, lang: Language) -> String {
    let interval = |low: Option<f64>, high: Option<f64>| match (low, high) {
        (Some(low), Some(high)) => format!("{} .. {}", significant(low, 4), significant(high, 4)),
        _ => "-".into(),
    };
    let rows: Vec<Vec<String>> = column
        .points
        .iter()
        .map(|p| {
            vec![
                significant(p.tau_s, 4),
                significant(p.allan.value, 5),
                interval(p.allan.low, p.allan.high),
                significant(p.allan.edf, 3),
                optional(p.hadamard.as_ref().map(|d| d.value), |v| significant(v, 5)),
                optional(p.modified.as_ref().map(|d| d.value), |v| significant(v, 5)),
                optional(p.fitted, |v| significant(v, 4)),
            ]
        })
        .collect();
    let percent = format!("{} %", super::table::percent(column.level));
    plain(
        &[
            say!(lang, "tau-s"),
            say!(lang, "allan"),
            &percent,
            say!(lang, "edf"),
            say!(lang, "hadamard"),
            say!(lang, "modified"),
            say!(lang, "fitted"),
        ],
        &rows,
    )
}

/// The IMU file of kalibr: densities in rad/s/sqrt(Hz), m/s^2/sqrt(Hz), random walks in rad/s^2/sqrt(Hz), m/s^3/sqrt(Hz); the largest of each kind of sensor.
///
/// Errors: no column in a unit of rate or specific force; a kind without white noise.
pub fn kalibr(report: &NoiseAnalysisReport) -> Result<String> {
    let largest = |gyro: bool, id: Term, bound: bool| {
        report
            .columns
            .iter()
            .filter_map(|column| {
                let (is_gyro, factor) = si_factor(&column.unit).filter(|(is_gyro, _)| *is_gyro == gyro)?;
                let c = column.coefficients.iter().find(|c| c.id == id)?;
                let in_unit = crate::noise::field_unit(id, &column.unit).factor;
                let value = if bound { c.below.map(|b| b / in_unit) } else { c.si_seconds };
                let _ = is_gyro;
                value.map(|v| (v * factor, column.column.clone()))
            })
            .max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let mut text = String::from("#Accelerometers\n");
    let mut kinds = 0;
    for (gyro, title, words) in [
        (false, "accelerometer", ("m/s^2/sqrt(Hz)", "m/s^3/sqrt(Hz)")),
        (true, "gyroscope", ("rad/s/sqrt(Hz)", "rad/s^2/sqrt(Hz)")),
    ] {
        if gyro {
            text.push_str("\n#Gyroscopes\n");
        }
        let Some((density, from)) = largest(gyro, Term::RandomWalk, false) else { continue };
        kinds += 1;
        text.push_str(&format!("{title}_noise_density: {density:.6e}   # {}, N of {from}\n", words.0));
        match (largest(gyro, Term::RateRandomWalk, false), largest(gyro, Term::RateRandomWalk, true)) {
            (Some((walk, from)), _) => {
                text.push_str(&format!("{title}_random_walk: {walk:.6e}   # {}, K of {from}\n", words.1));
            }
            (None, Some((walk, from))) => text.push_str(&format!(
                "{title}_random_walk: {walk:.6e}   # {}, not found in this record: what K of {from} is below (95 %)\n",
                words.1
            )),
            (None, None) => {}
        }
    }
    if kinds == 0 {
        return Err(Malformed::new(Fault::Value, "kalibr's file holds gyros and accelerometers, and no column is one")
            .expected("columns in a unit of rate (deg/s, rad/s, deg/h) or of specific force (g, mg, m/s^2)")
            .found(
                report.columns.iter().map(|c| format!("{} in {}", c.column, c.unit)).collect::<Vec<_>>().join(", "),
            ));
    }
    text.push_str(&format!("\nrostopic: /imu0\nupdate_rate: {}\n", significant(1.0 / report.interval_s, 6)));
    Ok(text)
}
