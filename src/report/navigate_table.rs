//! Navigation errors as a person reads them at a terminal.

use super::table::{plain, significant};
use super::wrap::hanging;
use super::{ErrorReport, NavigateReport, ResultReport};
use crate::language::{Language, say};

/// The results, the ratios, and what a calibration's uncertainty does.
pub fn navigate_table(report: &NavigateReport, lang: Language) -> String {
    let title = if report.title.is_empty() { say!(lang, "a-mission") } else { &report.title };
    let duration = significant(report.duration_h, 6);
    let mut text = format!("{}\n", say!(lang, "tumble-navigation-errors", tumble = report.tumble, title));
    let steps = say!(lang, "h-in-steps-of-s", duration, step = report.step_s.to_string());
    text.push_str(&format!("  {steps}\n{}\n", hanging(&format!("  {}", lang.name(&report.convention)), 2)));
    text.push_str(&format!("  {}\n", say!(lang, "vertical-channel", channel = lang.name(&report.vertical_channel))));
    if let Some(periods) = report.periods {
        text.push_str(&format!("  {}\n", say!(lang, "navigate-table-periods", periods = periods.in_words(lang))));
    }
    let rows: Vec<Vec<String>> = report.results.iter().map(result).collect();
    let header = [
        say!(lang, "motion"),
        say!(lang, "scenario"),
        say!(lang, "tilt-arcsec"),
        say!(lang, "azimuth-arcsec"),
        say!(lang, "velocity-m-s"),
        say!(lang, "position-m"),
        say!(lang, "at-the-end-m"),
    ];
    let heading = say!(lang, "root-mean-square-errors-and-the-position");
    text.push_str(&format!("\n{heading}\n{}", plain(&header, &rows)));
    let is_perfect = |r: &ResultReport| r.scenario == crate::navigate::study::PERFECT;
    if report.results.iter().any(is_perfect) {
        text.push_str(&format!("{}\n", say!(lang, "perfect-unit-a-perfect-unit-the-navigators")));
    }
    for warning in &report.warnings {
        let warning = say!(lang, "navigate-table-warning", warning = lang.name(warning));
        text.push_str(&format!("{}\n", hanging(&warning, 2)));
    }
    let rows: Vec<Vec<String>> = report
        .ratios
        .iter()
        .map(|r| {
            let names = [r.scenario.clone(), format!("{} / {}", r.motion, r.against)];
            names.into_iter().chain([r.tilt, r.azimuth, r.velocity, r.position].map(cell)).collect()
        })
        .collect();
    if !rows.is_empty() {
        let header = [
            say!(lang, "scenario"),
            say!(lang, "motion"),
            say!(lang, "tilt"),
            say!(lang, "azimuth"),
            say!(lang, "velocity"),
            say!(lang, "per-position"),
        ];
        let heading = say!(lang, "against-the-first-motion-ratios-of-root");
        text.push_str(&format!("\n{heading}\n{}", plain(&header, &rows)));
    }
    let rows = carried(report, lang);
    if !rows.is_empty() {
        let header = [
            say!(lang, "motion"),
            say!(lang, "carried-by"),
            say!(lang, "tilt-arcsec"),
            say!(lang, "azimuth-arcsec"),
            say!(lang, "velocity-m-s"),
            say!(lang, "position-m"),
        ];
        let heading = say!(lang, "what-the-calibrations-uncertainty-does");
        text.push_str(&format!("\n{heading}\n{}", plain(&header, &rows)));
    }
    text
}

fn cell(value: Option<f64>) -> String {
    value.map_or_else(|| "-".into(), |value| significant(value, 4))
}

fn result(r: &ResultReport) -> Vec<String> {
    let sizes = [r.tilt_arcsec.rms, r.azimuth_arcsec.rms, r.velocity_m_s.rms, r.position_m.rms, r.position_m.last];
    [r.motion.clone(), r.scenario.clone()].into_iter().chain(sizes.map(cell)).collect()
}

/// Standard uncertainties at the end, by linear covariance and by Monte Carlo.
fn carried(report: &NavigateReport, lang: Language) -> Vec<Vec<String>> {
    let both = |parts: [Option<f64>; 2]| Some(parts[0]?.hypot(parts[1]?));
    let row = |motion: &str, by: String, u: &ErrorReport| {
        let [east, north, up] = u.phi_arcsec;
        let sizes = [both([east, north]), up, both(u.velocity_m_s), both(u.position_m)];
        [motion.to_string(), by].into_iter().chain(sizes.map(cell)).collect()
    };
    let mut rows = Vec::new();
    for own in &report.carried {
        rows.extend(own.linear.as_ref().map(|u| row(&own.motion, say!(lang, "linear-covariance").into(), u)));
        let draws = say!(lang, "monte-carlo-draws", draws = own.draws.to_string());
        rows.extend(own.monte_carlo.as_ref().map(|u| row(&own.motion, draws, u)));
    }
    rows
}
