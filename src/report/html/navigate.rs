//! The page of a navigation study: results, ratios, and errors against time.

use super::{Align, Figure, Page, Section, Table};
use crate::error::Result;
use crate::navigate::run::NavigationError;
use crate::navigate::study::Flown;
use crate::report::plot::{Curve, curves};
use crate::report::table::{significant, trimmed};
use crate::report::{ARCSEC, ErrorReport, NavigateReport};

/// Scenarios that get figures of their own; single sources beyond them are in the table and in the series.
const DRAWN: usize = 10;

/// A quantity that is drawn: its name, its unit, and how it is read off an error.
type Quantity = (&'static str, &'static str, fn(&NavigationError) -> f64);

const QUANTITIES: [Quantity; 4] = [
    ("tilt", "arcsec", |e| e.tilt() * ARCSEC),
    ("azimuth error", "arcsec", |e| e.attitude[2] * ARCSEC),
    ("velocity error", "m/s", |e| e.speed()),
    ("position error", "m", |e| e.distance()),
];

/// The page of a navigation report, with figures of the series that were kept.
pub fn navigate_page(report: &NavigateReport, flown: &[Flown]) -> Result<Page> {
    let title = if report.title.is_empty() { "Navigation errors" } else { &report.title };
    let mut page = Page::new(title);
    page.subtitle = format!("{} h in steps of {} s", trimmed(report.duration_h), report.step_s);
    page.facts.push(("Convention".into(), report.convention.clone()));
    page.facts.push(("Vertical channel".into(), report.vertical_channel.clone()));
    if let Some(periods) = report.periods {
        page.facts.push(("Periods".into(), periods.in_words()));
    }
    page.colophon.push(("tumble".into(), report.tumble.clone()));
    page = page
        .section(answer(report))
        .section(warned(Section::new("Root mean square errors").table(results(report)), report))
        .section(Section::new("Against the first motion").table(ratios(report)))
        .section(carried(report));
    for (i, scenario) in report.scenarios.iter().enumerate().take(if flown.is_empty() { 0 } else { DRAWN }) {
        let mut figures = Vec::new();
        for (what, unit, of) in QUANTITIES {
            let lines: Vec<Curve> = flown
                .iter()
                .enumerate()
                .map(|(k, motion)| Curve {
                    label: motion.motion.clone(),
                    points: motion
                        .times
                        .iter()
                        .zip(motion.series.get(i).into_iter().flatten())
                        .map(|(time, error)| (time / 3600.0, of(error)))
                        .collect(),
                    dashed: k == 0 && flown.len() > 1,
                })
                .collect();
            figures.push(Figure {
                caption: format!("{what} of `{}`", scenario.id),
                description: in_words(&lines, what, unit, &scenario.id),
                svg: curves(&lines, what, unit, "time, h")?,
                wide: false,
            });
        }
        page = page.section(Section::new(format!("Errors in time: {}", scenario.id)).figures(figures));
    }
    Ok(page)
}

/// A figure of curves for those who cannot see it.
pub(super) fn in_words(lines: &[Curve], what: &str, unit: &str, of: &str) -> String {
    let ends = lines.iter().map(|line| {
        let most = line.points.iter().map(|(_, y)| y.abs()).filter(|y| y.is_finite()).fold(0.0, f64::max);
        let last = line.points.last().map_or(f64::NAN, |(_, y)| *y);
        format!("{}: at most {} {unit}, {} {unit} at the end", line.label, significant(most, 3), significant(last, 3))
    });
    format!("{what} of {of} against time; {}.", ends.collect::<Vec<_>>().join("; "))
}

/// The answer in sentences: where each motion ends, and by which error most.
fn answer(report: &NavigateReport) -> Section {
    const MOTIONS: usize = 4;
    let mut motions: Vec<&str> = Vec::new();
    for result in &report.results {
        if !motions.contains(&result.motion.as_str()) {
            motions.push(&result.motion);
        }
    }
    let mut points = Vec::new();
    for motion in motions.iter().take(MOTIONS) {
        let own = || report.results.iter().filter(|r| r.motion == *motion);
        let errors = |id: &str| report.scenarios.iter().find(|s| s.id == id).map_or(0, |s| s.errors.len());
        // the scenario with most errors is the unit as it is; those with one are its sources
        let Some(whole) = own().max_by_key(|r| errors(&r.scenario)) else { continue };
        let mut text = format!(
            "{}: after {} h the position is off by {} m (rms {} m), the azimuth by {} arcsec (rms {})",
            capital(motion),
            trimmed(whole.time_h),
            cell(whole.position_m.last),
            cell(whole.position_m.rms),
            cell(whole.azimuth_arcsec.last),
            cell(whole.azimuth_arcsec.rms),
        );
        let mut parts: Vec<_> = own().filter(|r| r.scenario != whole.scenario).collect();
        parts.sort_by(|a, b| b.position_m.rms.unwrap_or(0.0).total_cmp(&a.position_m.rms.unwrap_or(0.0)));
        let most: Vec<String> =
            parts.iter().take(3).map(|r| format!("`{}` {} m", r.scenario, cell(r.position_m.rms))).collect();
        if own().count() > 1 {
            text.push_str(&format!(" with `{}`; most of it from {} (position, rms)", whole.scenario, most.join(", ")));
        }
        points.push(text + ".");
    }
    Section::new("The answer").list(points)
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}

/// What a reader of the table must know.
fn warned(mut section: Section, report: &NavigateReport) -> Section {
    section = section.prose("`perfect_unit`: a perfect unit, the navigator's own error.");
    for warning in &report.warnings {
        section = section.prose(format!("Warning: {warning}."));
    }
    section
}

fn cell(value: Option<f64>) -> String {
    value.map_or_else(|| "-".into(), |value| significant(value, 4))
}

fn results(report: &NavigateReport) -> Table {
    let mut table = Table::new(&[
        ("motion", Align::default()),
        ("scenario", Align::default()),
        ("tilt, arcsec", Align::Decimal),
        ("azimuth, arcsec", Align::Decimal),
        ("velocity, m/s", Align::Decimal),
        ("position, m", Align::Decimal),
        ("position at the end, m", Align::Decimal),
    ]);
    for r in &report.results {
        let sizes = [r.tilt_arcsec.rms, r.azimuth_arcsec.rms, r.velocity_m_s.rms, r.position_m.rms, r.position_m.last];
        let names = [r.motion.clone(), r.scenario.clone()];
        table.row(names.into_iter().chain(sizes.map(cell)).collect());
    }
    table
}

fn ratios(report: &NavigateReport) -> Table {
    let mut table = Table::new(&[
        ("scenario", Align::default()),
        ("motion", Align::default()),
        ("tilt", Align::Decimal),
        ("azimuth", Align::Decimal),
        ("velocity", Align::Decimal),
        ("position", Align::Decimal),
    ]);
    for r in &report.ratios {
        let names = [r.scenario.clone(), format!("{} / {}", r.motion, r.against)];
        table.row(names.into_iter().chain([r.tilt, r.azimuth, r.velocity, r.position].map(cell)).collect());
    }
    table.note =
        "Ratios of root mean squares; - where the first motion has no such error beyond the navigator's own.".into();
    table
}

fn carried(report: &NavigateReport) -> Section {
    let mut table = Table::new(&[
        ("motion", Align::default()),
        ("by", Align::default()),
        ("tilt, arcsec", Align::Decimal),
        ("azimuth, arcsec", Align::Decimal),
        ("velocity, m/s", Align::Decimal),
        ("position, m", Align::Decimal),
    ]);
    let both = |parts: [Option<f64>; 2]| Some(parts[0]?.hypot(parts[1]?));
    for motion in &report.carried {
        let monte_carlo = format!("Monte Carlo, {} draws", motion.draws);
        let ways: [(&str, Option<ErrorReport>); 2] =
            [("linear covariance", motion.linear), (&monte_carlo, motion.monte_carlo)];
        for (by, u) in ways {
            let Some(u) = u else { continue };
            let [e, n, up] = u.phi_arcsec;
            let sizes = [both([e, n]), up, both(u.velocity_m_s), both(u.position_m)];
            let names = [motion.motion.clone(), by.to_string()];
            table.row(names.into_iter().chain(sizes.map(cell)).collect());
        }
    }
    Section::new("What the calibration's uncertainty does").table(table)
}
