//! Navigation errors as a person reads them at a terminal.

use super::table::{plain, significant};
use super::{ErrorReport, NavigateReport, ResultReport};

/// The results, the ratios, and what a calibration's uncertainty does.
pub fn navigate_table(report: &NavigateReport) -> String {
    let title = if report.title.is_empty() { "a mission" } else { &report.title };
    let duration = significant(report.duration_h, 6);
    let mut text = format!("tumble {}: navigation errors, {title}\n", report.tumble);
    text.push_str(&format!("  {duration} h in steps of {} s\n  {}\n", report.step_s, report.convention));
    text.push_str(&format!("  vertical channel: {}\n", report.vertical_channel));
    if let Some(periods) = report.periods {
        text.push_str(&format!("  periods: {}\n", periods.in_words()));
    }
    let rows: Vec<Vec<String>> = report.results.iter().map(result).collect();
    let header =
        ["motion", "scenario", "tilt (arcsec)", "azimuth (arcsec)", "velocity (m/s)", "position (m)", "at the end (m)"];
    text.push_str(&format!("\nRoot mean square errors, and the position error at the end\n{}", plain(&header, &rows)));
    let is_perfect = |r: &ResultReport| r.scenario == crate::navigate::study::PERFECT;
    if report.results.iter().any(is_perfect) {
        text.push_str("perfect_unit: a perfect unit, the navigator's own error\n");
    }
    for warning in &report.warnings {
        text.push_str(&format!("{}\n", super::wrap::hanging(&format!("WARNING: {warning}"), 2)));
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
        let header = ["scenario", "motion", "tilt", "azimuth", "velocity", "position"];
        text.push_str(&format!("\nAgainst the first motion (ratios of root mean squares)\n{}", plain(&header, &rows)));
    }
    let rows = carried(report);
    if !rows.is_empty() {
        let header = ["motion", "by", "tilt (arcsec)", "azimuth (arcsec)", "velocity (m/s)", "position (m)"];
        text.push_str(&format!("\nWhat the calibration's uncertainty does\n{}", plain(&header, &rows)));
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
fn carried(report: &NavigateReport) -> Vec<Vec<String>> {
    let both = |parts: [Option<f64>; 2]| Some(parts[0]?.hypot(parts[1]?));
    let row = |motion: &str, by: String, u: &ErrorReport| {
        let [east, north, up] = u.phi_arcsec;
        let sizes = [both([east, north]), up, both(u.velocity_m_s), both(u.position_m)];
        [motion.to_string(), by].into_iter().chain(sizes.map(cell)).collect()
    };
    let mut rows = Vec::new();
    for own in &report.carried {
        rows.extend(own.linear.as_ref().map(|u| row(&own.motion, "linear covariance".into(), u)));
        let draws = format!("Monte Carlo, {} draws", own.draws);
        rows.extend(own.monte_carlo.as_ref().map(|u| row(&own.motion, draws, u)));
    }
    rows
}
