//! A navigation study: its report (`tumble navigate --json`), and its document: where each motion ends and by which error most, the errors in time,
//! and what they are made of.

use super::provenance::begin;
use super::scene::mission_figure;
use super::{ARCSEC, ReportKind, VERSION, finite};
use crate::document::chart::{Chart, Curve};
use crate::document::number::{significant, trimmed};
use crate::document::{Cell, Document, Figure, Rows, Section, Tone};
use crate::language::{Language, code, say};
use crate::navigate::earth::EARTH_RATE;
use crate::navigate::errors::{ErrorSource, ImuErrors};
use crate::navigate::linear;
use crate::navigate::mission::Mission;
use crate::navigate::run::{NavigationError, Scenario, Summary};
use crate::navigate::study::{self, Flown, PERFECT, PropagatedCalibration, Ratio};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// What `tumble navigate --json` writes. Numbers of a navigator that ran over a pole are null.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct NavigateReport {
    /// Version of the program that wrote it.
    pub tumble: String,
    /// Always `navigate`.
    #[schemars(extend("const" = "navigate"))]
    pub report: ReportKind,
    /// The mission's title.
    pub title: String,
    /// Duration, h.
    pub duration_h: f64,
    /// Step, s.
    pub step_s: f64,
    /// What the attitude errors are.
    pub convention: String,
    /// What is held and not navigated.
    pub vertical_channel: String,
    /// Motions beyond what the navigator's step resolves.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// The periods of the error equations at rest; null where their eigenvalues cannot be found.
    pub periods: Option<PeriodsReport>,
    /// The scenarios' errors, in the unit of each.
    pub scenarios: Vec<ScenarioReport>,
    /// Each scenario in each motion.
    pub results: Vec<ResultReport>,
    /// Root mean square errors of each motion over those of the first one.
    pub ratios: Vec<Ratio>,
    /// A calibration's covariance, carried to navigation errors.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub carried: Vec<CarriedReport>,
}

/// Periods of the error equations.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PeriodsReport {
    /// Schuler's oscillation, min.
    pub schuler_min: f64,
    /// The Earth's rotation, h.
    pub earth_h: f64,
    /// The Foucault rotation of Schuler's oscillation, `2 pi / (W sin L)`, h; null at the equator, where there is none.
    pub foucault_h: Option<f64>,
}

impl PeriodsReport {
    /// In one line.
    fn in_words(&self, lang: Language) -> String {
        let foucault =
            self.foucault_h.map_or(say!(lang, "none-at-the-equator").to_string(), |hours| format!("{hours:.2} h"));
        let [schuler, earth] = [format!("{:.2}", self.schuler_min), format!("{:.3}", self.earth_h)];
        say!(lang, "schuler-earth-foucault", schuler, earth, foucault)
    }
}

/// A scenario.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ScenarioReport {
    /// Its name.
    pub id: String,
    /// What is not zero.
    pub errors: BTreeMap<String, QuantityWithUnit>,
}

/// A value with its unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct QuantityWithUnit {
    /// Value, in `unit`.
    pub value: f64,
    /// Unit.
    pub unit: String,
}

/// One scenario in one motion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ResultReport {
    /// The motion.
    pub motion: String,
    /// The scenario.
    pub scenario: String,
    /// Time of the last row, h.
    pub time_h: f64,
    /// Tilt, arcsec.
    pub tilt_arcsec: SummaryReport,
    /// Azimuth error, arcsec.
    pub azimuth_arcsec: SummaryReport,
    /// Horizontal velocity error, m/s.
    pub velocity_m_s: SummaryReport,
    /// Horizontal position error, m.
    pub position_m: SummaryReport,
    /// The last row.
    pub last: ErrorReport,
}

/// A quantity over all rows of a run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SummaryReport {
    /// At the last row, in the unit of its key.
    pub last: Option<f64>,
    /// Largest, in the unit of its key.
    pub max: Option<f64>,
    /// Root mean square, in the unit of its key.
    pub rms: Option<f64>,
}

/// A navigation error, or the standard uncertainty of one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ErrorReport {
    /// `phi` about east, north, up, arcsec.
    pub phi_arcsec: [Option<f64>; 3],
    /// East, north, m/s.
    pub velocity_m_s: [Option<f64>; 2],
    /// East, north, m.
    pub position_m: [Option<f64>; 2],
}

/// A covariance carried along one motion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CarriedReport {
    /// The motion.
    pub motion: String,
    /// Standard uncertainties at the last row, linear covariance.
    pub linear: Option<ErrorReport>,
    /// Draws of the Monte Carlo run.
    pub draws: usize,
    /// Standard deviation of the draws about zero at the last row.
    pub monte_carlo: Option<ErrorReport>,
    /// Times, h.
    pub time_h: Vec<f64>,
    /// Standard uncertainty of position (east and north together), m, at these times.
    pub position_u_m: Vec<f64>,
}

/// The report of a study.
pub fn navigate_report(
    mission: &Mission,
    scenarios: &[Scenario],
    flown: &[Flown],
    carried: &[PropagatedCalibration],
) -> NavigateReport {
    NavigateReport {
        tumble: VERSION.into(),
        report: ReportKind::Navigate,
        title: mission.title.clone(),
        duration_h: mission.duration() / 3600.0,
        step_s: mission.step_s,
        convention: "phi angle: C' = (I - phi x) C, C from body to east-north-up; errors are computed minus true"
            .into(),
        vertical_channel: "held at the site's altitude, no vertical velocity".into(),
        warnings: study::unresolved(mission, flown).iter().map(|unresolved| warning(mission, unresolved)).collect(),
        periods: linear::frequencies(mission.site).map(|[earth, slow, fast]| PeriodsReport {
            schuler_min: TAU / (0.5 * (slow + fast)) / 60.0,
            earth_h: TAU / earth / 3600.0,
            foucault_h: Some(TAU / (EARTH_RATE * mission.site.latitude_rad.sin().abs()) / 3600.0).filter(|h| *h < 1e4),
        }),
        scenarios: scenarios
            .iter()
            .map(|scenario| ScenarioReport { id: scenario.id.clone(), errors: error_quantities(&scenario.errors) })
            .collect(),
        results: flown.iter().flat_map(results).collect(),
        ratios: study::ratios(mission, flown),
        carried: carried.iter().map(propagated).collect(),
    }
}

fn warning(mission: &Mission, unresolved: &study::Unresolved) -> String {
    let [tilt, azimuth, velocity, position] = unresolved.own;
    let digits = |value: f64| significant(value, 3);
    let mut text = format!(
        "in {} a unit without errors gives errors of {} arcsec (tilt), {} arcsec (azimuth), {} m/s and {} m: the error of the navigator",
        unresolved.motion,
        digits(tilt * ARCSEC),
        digits(azimuth * ARCSEC),
        digits(velocity),
        digits(position)
    );
    if unresolved.period.is_finite() {
        text.push_str(&format!(
            "; its step of {} s does not resolve a motion of {} s (a step of {} s would)",
            mission.step_s,
            unresolved.period,
            digits(unresolved.period / 25.0)
        ));
    }
    text
}

/// What is not zero of a set of errors.
pub(super) fn error_quantities(imu: &ImuErrors) -> BTreeMap<String, QuantityWithUnit> {
    let value = |value: f64, unit: &str| QuantityWithUnit { value, unit: unit.into() };
    let mut errors: BTreeMap<String, QuantityWithUnit> =
        imu.present().iter().map(|s: &ErrorSource| (s.id(), value(s.of(imu) / s.si_per_unit(), s.unit()))).collect();
    if imu.gyro.random_walk > 0.0 {
        let walk = imu.gyro.random_walk.to_degrees() * 60.0;
        errors.insert("angle_random_walk".into(), value(walk, "deg/sqrt(h)"));
    }
    if imu.accelerometer.random_walk > 0.0 {
        let walk = imu.accelerometer.random_walk * 60.0;
        errors.insert("velocity_random_walk".into(), value(walk, "(m/s)/sqrt(h)"));
    }
    errors
}

fn results(flown: &Flown) -> impl Iterator<Item = ResultReport> {
    flown.flight.outcomes.iter().map(|outcome| ResultReport {
        motion: flown.motion.clone(),
        scenario: outcome.id.clone(),
        time_h: flown.flight.time / 3600.0,
        tilt_arcsec: summary(&outcome.tilt, ARCSEC),
        azimuth_arcsec: summary(&outcome.azimuth, ARCSEC),
        velocity_m_s: summary(&outcome.velocity, 1.0),
        position_m: summary(&outcome.position, 1.0),
        last: error(&outcome.last),
    })
}

fn propagated(carried: &PropagatedCalibration) -> CarriedReport {
    CarriedReport {
        motion: carried.motion.clone(),
        linear: carried.linear.last().map(error),
        draws: carried.draws,
        monte_carlo: carried.monte_carlo.as_ref().map(error),
        time_h: carried.times.iter().map(|time| time / 3600.0).collect(),
        position_u_m: carried.linear.iter().map(|u| u.position[0].hypot(u.position[1])).collect(),
    }
}

fn summary(summary: &Summary, unit: f64) -> SummaryReport {
    SummaryReport {
        last: finite(summary.last * unit),
        max: finite(summary.max * unit),
        rms: finite(summary.rms * unit),
    }
}

fn error(error: &NavigationError) -> ErrorReport {
    ErrorReport {
        phi_arcsec: error.attitude.map(|phi| finite(phi * ARCSEC)),
        velocity_m_s: error.velocity.map(finite),
        position_m: error.position.map(finite),
    }
}

/// Scenarios that get figures of their own; single sources beyond them are in the table and in the series.
const DRAWN: usize = 10;
/// Motions that have a sentence.
const MOTIONS: usize = 4;

/// A quantity that is drawn: its name as a key of the catalogue, its unit, and how it is read off an error.
type Quantity = (&'static str, &'static str, fn(&NavigationError) -> f64);

const QUANTITIES: [Quantity; 4] = [
    ("position", "m", |e| e.distance()),
    ("azimuth", "arcsec", |e| e.attitude[2] * ARCSEC),
    ("tilt", "arcsec", |e| e.tilt() * ARCSEC),
    ("velocity", "m/s", |e| e.speed()),
];

/// The document of a navigation report; the mission and its series that were kept give the figures.
pub fn navigate_document(report: &NavigateReport, of: Option<(&Mission, &[Flown])>, lang: Language) -> Document {
    let title = if report.title.is_empty() { say!(lang, "navigation-errors") } else { &report.title };
    let steps = say!(lang, "h-in-steps-of-s", duration = trimmed(report.duration_h), step = report.step_s.to_string());
    let whole = (0..report.scenarios.len()).max_by_key(|i| (errors(report, *i), std::cmp::Reverse(*i)));
    let flown: &[Flown] = of.map_or(&[], |(_, flown)| flown);
    let mut document = begin(title, &[], lang)
        .fact(say!(lang, "duration"), steps)
        .section(answer(report, lang).figures(whole.into_iter().flat_map(|i| in_time(report, flown, i, lang))))
        .section(root_mean_squares(report, lang))
        .section(ratios(report, lang))
        .section(carried(report, lang));
    for (i, scenario) in report.scenarios.iter().enumerate().take(DRAWN).filter(|(i, _)| Some(*i) != whole) {
        let heading = format!("{}{}{}", lang.title(say!(lang, "over-time")), lang.colon(), scenario.id);
        document = document.section(Section::new(heading).full().figures(in_time(report, flown, i, lang)));
    }
    let mut facts = vec![
        (say!(lang, "convention").into(), lang.name(&report.convention).into_owned()),
        (say!(lang, "vertical-channel").into(), lang.name(&report.vertical_channel).into_owned()),
    ];
    facts.extend(report.periods.map(|periods| (say!(lang, "periods").into(), periods.in_words(lang))));
    let drawn = of.map(|(mission, _)| mission_figure(mission, lang));
    document.section(Section::new(say!(lang, "what-was-assumed")).facts(facts).figures(drawn))
}

fn errors(report: &NavigateReport, scenario: usize) -> usize {
    report.scenarios.get(scenario).map_or(0, |s| s.errors.len())
}

/// One scenario against time: a figure a quantity, a curve a motion.
fn in_time(report: &NavigateReport, flown: &[Flown], scenario: usize, lang: Language) -> Vec<Figure> {
    let Some(of) = report.scenarios.get(scenario).filter(|_| !flown.is_empty()) else { return Vec::new() };
    let figure = |(key, unit, size): &Quantity| {
        let what = lang.word(key);
        let lines: Vec<Curve> = flown
            .iter()
            .enumerate()
            .map(|(k, motion)| {
                let errors = motion.series.get(scenario).into_iter().flatten();
                let points = motion.times.iter().zip(errors).map(|(time, error)| (time / 3600.0, size(error)));
                Curve { label: motion.motion.clone(), points: points.collect(), dashed: k == 0 && flown.len() > 1 }
            })
            .collect();
        let caption = say!(lang, "curve-of", what, of = code(&of.id));
        Figure {
            description: in_words(&lines, &caption, unit, lang),
            caption,
            chart: Chart::curves(&lines, what, unit, &format!("{}, h", say!(lang, "time"))),
            wide: false,
        }
    };
    QUANTITIES.iter().map(figure).collect()
}

/// A figure of curves for those who cannot see it.
pub(super) fn in_words(lines: &[Curve], caption: &str, unit: &str, lang: Language) -> String {
    let ends = lines.iter().map(|line| {
        let most = line.points.iter().map(|(_, y)| y.abs()).filter(|y| y.is_finite()).fold(0.0, f64::max);
        let last = line.points.last().map_or(f64::NAN, |(_, y)| *y);
        let [most, last] = [most, last].map(|size| format!("{} {unit}", significant(size, 3)).trim_end().to_string());
        say!(lang, "at-most-at-the-end", label = line.label, most, last)
    });
    format!("{caption}{}{}", lang.semicolon(), ends.collect::<Vec<_>>().join(lang.semicolon()))
}

/// The answer in sentences: where each motion ends, and by which error most; what a reader must know of the numbers first.
fn answer(report: &NavigateReport, lang: Language) -> Section {
    let mut motions: Vec<&str> = Vec::new();
    for result in &report.results {
        if !motions.contains(&result.motion.as_str()) {
            motions.push(&result.motion);
        }
    }
    let text = |value: Option<f64>| number(value).text();
    let mut points = Vec::new();
    for motion in motions.iter().take(MOTIONS) {
        let of_motion = || report.results.iter().filter(|r| r.motion == *motion);
        let place = |id: &str| report.scenarios.iter().position(|s| s.id == id);
        // the scenario with most errors is the unit as it is; those with one are its sources
        let count = |id: &str| place(id).map_or(0, |i| errors(report, i));
        let Some(whole) = of_motion().max_by_key(|r| count(&r.scenario)) else { continue };
        let mut said = say!(
            lang,
            "after-h-the-position-is-off-by",
            motion,
            time = trimmed(whole.time_h),
            position = text(whole.position_m.last),
            position_rms = text(whole.position_m.rms),
            azimuth = text(whole.azimuth_arcsec.last),
            azimuth_rms = text(whole.azimuth_arcsec.rms)
        );
        let mut parts: Vec<_> = of_motion().filter(|r| r.scenario != whole.scenario && r.scenario != PERFECT).collect();
        parts.sort_by(|a, b| b.position_m.rms.unwrap_or(0.0).total_cmp(&a.position_m.rms.unwrap_or(0.0)));
        if !parts.is_empty() {
            let most = parts.iter().take(3).map(|r| format!("`{}` {} m", r.scenario, text(r.position_m.rms)));
            let sources = most.collect::<Vec<_>>().join(lang.comma());
            said = say!(lang, "with-most-of-it-from-position-rms", text = said, scenario = whole.scenario, sources);
        }
        points.push(lang.sentence(&said));
    }
    let warnings = report.warnings.iter().map(|warning| (Tone::Caution, lang.sentence(&lang.name(warning))));
    Section::new(say!(lang, "result")).verdicts(warnings).list(points)
}

/// A size of an error to four digits; a navigator that ran over a pole has none.
fn number(value: Option<f64>) -> Cell {
    Cell::digits(value, 4)
}

/// The columns of sizes: tilt, azimuth, velocity and position.
fn sizes<T: Copy>(table: Rows<T>, units: bool, of: impl Fn(T) -> [Option<f64>; 4], lang: Language) -> Rows<T> {
    let sizes = [
        (say!(lang, "tilt"), "arcsec"),
        (say!(lang, "azimuth"), "arcsec"),
        (say!(lang, "velocity"), "m/s"),
        (say!(lang, "position"), "m"),
    ];
    let column = |table: Rows<T>, (k, (what, unit)): (usize, (&str, &str))| {
        let title = if units { format!("{what} {}", lang.in_parentheses(unit)) } else { what.to_string() };
        table.decimal(title, |row| number(of(row).get(k).copied().flatten()))
    };
    sizes.into_iter().enumerate().fold(table, column)
}

fn root_mean_squares(report: &NavigateReport, lang: Language) -> Section {
    let table = Rows::of(&report.results)
        .left(say!(lang, "motion"), |r| &r.motion)
        .left(say!(lang, "scenario"), |r| &r.scenario);
    let rms = |r: &ResultReport| [r.tilt_arcsec.rms, r.azimuth_arcsec.rms, r.velocity_m_s.rms, r.position_m.rms];
    let table =
        sizes(table, true, rms, lang).decimal(say!(lang, "position-at-the-end-m"), |r| number(r.position_m.last));
    let perfect = report.results.iter().any(|r| r.scenario == PERFECT);
    let note = if perfect { say!(lang, "perfect-unit-a-perfect-unit-the-navigators") } else { "" };
    Section::new(say!(lang, "root-mean-square-errors")).table(table).prose(note)
}

fn ratios(report: &NavigateReport, lang: Language) -> Section {
    let table = Rows::of(&report.ratios)
        .left(say!(lang, "scenario"), |r| &r.scenario)
        .left(say!(lang, "motion"), |r| format!("{} / {}", r.motion, r.against));
    let table = sizes(table, false, |r| [r.tilt, r.azimuth, r.velocity, r.position], lang);
    let note = if report.ratios.is_empty() { "" } else { say!(lang, "ratios-of-root-mean-squares-where-the") };
    Section::new(say!(lang, "against-the-first-motion")).table(table).prose(note)
}

/// Standard uncertainties at the end, by linear covariance and by Monte Carlo.
fn carried(report: &NavigateReport, lang: Language) -> Section {
    let both = |parts: [Option<f64>; 2]| Some(parts[0]?.hypot(parts[1]?));
    let rows = report.carried.iter().flat_map(|carried| {
        let ways = [(carried.linear, None), (carried.monte_carlo, Some(carried.draws))];
        ways.into_iter().filter_map(|(u, draws)| Some((&carried.motion, draws, u?)))
    });
    let table = Rows::of(rows).left(say!(lang, "motion"), |(motion, ..)| motion).left(
        say!(lang, "carried-by"),
        |(_, draws, _): (_, Option<usize>, _)| match draws {
            None => say!(lang, "linear-covariance").to_string(),
            Some(draws) => say!(lang, "monte-carlo-draws", draws = draws.to_string()),
        },
    );
    let size =
        |(_, _, ErrorReport { phi_arcsec: [east, north, up], velocity_m_s, position_m }): (_, _, ErrorReport)| {
            [both([east, north]), up, both(velocity_m_s), both(position_m)]
        };
    Section::new(say!(lang, "what-the-calibrations-uncertainty-does")).table(sizes(table, true, size, lang))
}
