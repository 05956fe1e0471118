//! The page of a navigation study: results, ratios, and errors against time.

use super::{Align, Figure, Page, Section, Table};
use crate::document::chart::{Chart, Curve};
use crate::error::Result;
use crate::language::{Language, say};
use crate::navigate::run::NavigationError;
use crate::navigate::study::Flown;
use crate::report::table::{significant, trimmed};
use crate::report::{ARCSEC, ErrorReport, NavigateReport};

/// Scenarios that get figures of their own; single sources beyond them are in the table and in the series.
const DRAWN: usize = 10;

/// A quantity that is drawn: its name as a key of the catalogue, its unit, and how it is read off an error.
type Quantity = (&'static str, &'static str, fn(&NavigationError) -> f64);

const QUANTITIES: [Quantity; 4] = [
    ("quantity-tilt", "arcsec", |e| e.tilt() * ARCSEC),
    ("quantity-azimuth", "arcsec", |e| e.attitude[2] * ARCSEC),
    ("quantity-velocity", "m/s", |e| e.speed()),
    ("quantity-position", "m", |e| e.distance()),
];

/// The page of a navigation report, with figures of the series that were kept.
pub fn navigate_page(report: &NavigateReport, flown: &[Flown], lang: Language) -> Result<Page> {
    let title = if report.title.is_empty() { say!(lang, "navigation-errors") } else { &report.title };
    let mut page = Page::new(title);
    page.language = lang;
    page.subtitle =
        say!(lang, "h-in-steps-of-s", duration = trimmed(report.duration_h), step = report.step_s.to_string());
    page.facts.push((say!(lang, "convention").into(), lang.name(&report.convention).into_owned()));
    page.facts.push((say!(lang, "vertical-channel-2").into(), lang.name(&report.vertical_channel).into_owned()));
    if let Some(periods) = report.periods {
        page.facts.push((say!(lang, "periods").into(), periods.in_words(lang)));
    }
    page.colophon.push(("tumble".into(), report.tumble.clone()));
    page = page
        .section(answer(report, lang))
        .section(warned(Section::new(say!(lang, "root-mean-square-errors")).table(results(report, lang)), report, lang))
        .section(Section::new(say!(lang, "against-the-first-motion")).table(ratios(report, lang)))
        .section(carried(report, lang));
    for (i, scenario) in report.scenarios.iter().enumerate().take(if flown.is_empty() { 0 } else { DRAWN }) {
        let mut figures = Vec::new();
        for (key, unit, of) in QUANTITIES {
            let what = lang.word(key);
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
                caption: format!("{what} of `{scenario}`", scenario = scenario.id),
                description: in_words(&lines, what, unit, &scenario.id, lang),
                chart: Chart::curves(&lines, what, unit, say!(lang, "time-h")),
                wide: false,
            });
        }
        page = page.section(Section::new(say!(lang, "errors-in-time", scenario = scenario.id)).figures(figures));
    }
    Ok(page)
}

/// A figure of curves for those who cannot see it.
pub(super) fn in_words(lines: &[Curve], what: &str, unit: &str, of: &str, lang: Language) -> String {
    let ends = lines.iter().map(|line| {
        let most = line.points.iter().map(|(_, y)| y.abs()).filter(|y| y.is_finite()).fold(0.0, f64::max);
        let last = line.points.last().map_or(f64::NAN, |(_, y)| *y);
        let [most, last] = [most, last].map(|size| significant(size, 3));
        say!(lang, "at-most-at-the-end", label = line.label, most, unit, last)
    });
    say!(lang, "of-against-time", what, of, ends = ends.collect::<Vec<_>>().join(lang.semicolon()))
}

/// The answer in sentences: where each motion ends, and by which error most.
fn answer(report: &NavigateReport, lang: Language) -> Section {
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
        let mut text = say!(
            lang,
            "after-h-the-position-is-off-by",
            motion = begun(motion, lang),
            time = trimmed(whole.time_h),
            position = cell(whole.position_m.last),
            position_rms = cell(whole.position_m.rms),
            azimuth = cell(whole.azimuth_arcsec.last),
            azimuth_rms = cell(whole.azimuth_arcsec.rms)
        );
        let mut parts: Vec<_> = own().filter(|r| r.scenario != whole.scenario).collect();
        parts.sort_by(|a, b| b.position_m.rms.unwrap_or(0.0).total_cmp(&a.position_m.rms.unwrap_or(0.0)));
        let most: Vec<String> =
            parts.iter().take(3).map(|r| format!("`{}` {} m", r.scenario, cell(r.position_m.rms))).collect();
        if own().count() > 1 {
            text = say!(
                lang,
                "with-most-of-it-from-position-rms",
                text,
                scenario = whole.scenario,
                sources = most.join(lang.comma())
            );
        }
        points.push(lang.sentence(&text));
    }
    Section::new(say!(lang, "the-answer")).list(points)
}

/// The beginning of a sentence: a capital where the language has them.
fn begun(text: &str, lang: Language) -> String {
    if lang == Language::Chinese {
        return text.to_string();
    }
    let mut letters = text.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}

/// What a reader of the table must know.
fn warned(mut section: Section, report: &NavigateReport, lang: Language) -> Section {
    section = section.prose(say!(lang, "perfect-unit-a-perfect-unit-the-navigators-2"));
    for warning in &report.warnings {
        section = section.prose(say!(lang, "fit-readings-warning", warning = lang.name(warning)));
    }
    section
}

fn cell(value: Option<f64>) -> String {
    value.map_or_else(|| "-".into(), |value| significant(value, 4))
}

fn results(report: &NavigateReport, lang: Language) -> Table {
    let mut table = Table::new(&[
        (say!(lang, "motion"), Align::default()),
        (say!(lang, "scenario"), Align::default()),
        (say!(lang, "tilt-arcsec-2"), Align::Decimal),
        (say!(lang, "azimuth-arcsec-2"), Align::Decimal),
        (say!(lang, "velocity-m-s-2"), Align::Decimal),
        (say!(lang, "position-m-2"), Align::Decimal),
        (say!(lang, "position-at-the-end-m"), Align::Decimal),
    ]);
    for r in &report.results {
        let sizes = [r.tilt_arcsec.rms, r.azimuth_arcsec.rms, r.velocity_m_s.rms, r.position_m.rms, r.position_m.last];
        let names = [r.motion.clone(), r.scenario.clone()];
        table.row(names.into_iter().chain(sizes.map(cell)).collect());
    }
    table
}

fn ratios(report: &NavigateReport, lang: Language) -> Table {
    let mut table = Table::new(&[
        (say!(lang, "scenario"), Align::default()),
        (say!(lang, "motion"), Align::default()),
        (say!(lang, "tilt"), Align::Decimal),
        (say!(lang, "azimuth"), Align::Decimal),
        (say!(lang, "velocity"), Align::Decimal),
        (say!(lang, "per-position"), Align::Decimal),
    ]);
    for r in &report.ratios {
        let names = [r.scenario.clone(), format!("{} / {}", r.motion, r.against)];
        table.row(names.into_iter().chain([r.tilt, r.azimuth, r.velocity, r.position].map(cell)).collect());
    }
    table.note = say!(lang, "ratios-of-root-mean-squares-where-the").into();
    table
}

fn carried(report: &NavigateReport, lang: Language) -> Section {
    let mut table = Table::new(&[
        (say!(lang, "motion"), Align::default()),
        (say!(lang, "carried-by"), Align::default()),
        (say!(lang, "tilt-arcsec-2"), Align::Decimal),
        (say!(lang, "azimuth-arcsec-2"), Align::Decimal),
        (say!(lang, "velocity-m-s-2"), Align::Decimal),
        (say!(lang, "position-m-2"), Align::Decimal),
    ]);
    let both = |parts: [Option<f64>; 2]| Some(parts[0]?.hypot(parts[1]?));
    for motion in &report.carried {
        let monte_carlo = say!(lang, "monte-carlo-draws", draws = motion.draws.to_string());
        let ways: [(&str, Option<ErrorReport>); 2] =
            [(say!(lang, "linear-covariance"), motion.linear), (&monte_carlo, motion.monte_carlo)];
        for (by, u) in ways {
            let Some(u) = u else { continue };
            let [e, n, up] = u.phi_arcsec;
            let sizes = [both([e, n]), up, both(u.velocity_m_s), both(u.position_m)];
            let names = [motion.motion.clone(), by.to_string()];
            table.row(names.into_iter().chain(sizes.map(cell)).collect());
        }
    }
    Section::new(say!(lang, "what-the-calibrations-uncertainty-does")).table(table)
}
