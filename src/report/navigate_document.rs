//! The document of a navigation study: where each motion ends and by which error most, the errors in time, and what they are made of.

use super::colophon::begin;
use super::scene::mission_figure;
use super::{ARCSEC, ErrorReport, NavigateReport};
use crate::document::chart::{Chart, Curve};
use crate::document::number::{significant, trimmed};
use crate::document::{Align, Cell, Content, Document, Figure, Section, Table, Tone};
use crate::language::{Language, say};
use crate::navigate::mission::Mission;
use crate::navigate::run::NavigationError;
use crate::navigate::study::{Flown, PERFECT};

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
    let mut document = begin(title, &[], lang);
    let steps = say!(lang, "h-in-steps-of-s", duration = trimmed(report.duration_h), step = report.step_s.to_string());
    document.facts = vec![(say!(lang, "duration").into(), steps)];
    let whole = (0..report.scenarios.len()).max_by_key(|i| (errors(report, *i), std::cmp::Reverse(*i)));
    let flown: &[Flown] = of.map_or(&[], |(_, flown)| flown);
    document = document
        .section(answer(report, lang).figures(whole.map_or_else(Vec::new, |i| in_time(report, flown, i, lang))))
        .section(results(report, lang))
        .section(ratios(report, lang))
        .section(carried(report, lang));
    for (i, scenario) in report.scenarios.iter().enumerate().take(DRAWN).filter(|(i, _)| Some(*i) != whole) {
        let section =
            Section::new(format!("{}{}{}", lang.title(say!(lang, "over-time")), lang.colon(), scenario.id)).full();
        document = document.section(section.figures(in_time(report, flown, i, lang)));
    }
    let mut facts = vec![
        (say!(lang, "convention").into(), lang.name(&report.convention).into_owned()),
        (say!(lang, "vertical-channel").into(), lang.name(&report.vertical_channel).into_owned()),
    ];
    facts.extend(report.periods.map(|periods| (say!(lang, "periods").into(), periods.in_words(lang))));
    let drawn = of.map(|(mission, _)| mission_figure(mission, lang)).into_iter().collect();
    document.section(Section::new(say!(lang, "what-was-assumed")).block(Content::Facts(facts)).figures(drawn))
}

/// How many errors a scenario has.
fn errors(report: &NavigateReport, scenario: usize) -> usize {
    report.scenarios.get(scenario).map_or(0, |own| own.errors.len())
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
        let caption = say!(lang, "curve-of", what, of = format!("`{}`", of.id));
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
        let own = || report.results.iter().filter(|r| r.motion == *motion);
        let place = |id: &str| report.scenarios.iter().position(|s| s.id == id);
        // the scenario with most errors is the unit as it is; those with one are its sources
        let count = |id: &str| place(id).map_or(0, |i| errors(report, i));
        let Some(whole) = own().max_by_key(|r| count(&r.scenario)) else { continue };
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
        let mut parts: Vec<_> = own().filter(|r| r.scenario != whole.scenario && r.scenario != PERFECT).collect();
        parts.sort_by(|a, b| b.position_m.rms.unwrap_or(0.0).total_cmp(&a.position_m.rms.unwrap_or(0.0)));
        if !parts.is_empty() {
            let most = parts.iter().take(3).map(|r| format!("`{}` {} m", r.scenario, text(r.position_m.rms)));
            let sources = most.collect::<Vec<_>>().join(lang.comma());
            said = say!(lang, "with-most-of-it-from-position-rms", text = said, scenario = whole.scenario, sources);
        }
        points.push(lang.sentence(&said));
    }
    let section = Section::new(say!(lang, "result"));
    let warnings = report.warnings.iter().map(|warning| lang.sentence(&lang.name(warning)));
    warnings.fold(section, |section, warning| section.verdict(Tone::Caution, warning)).list(points)
}

/// A size of an error to four digits; a navigator that ran over a pole has none.
fn number(value: Option<f64>) -> Cell {
    Cell::digits(value, 4)
}

/// A table of sizes under names: the titles of the names, the sizes, and one more size at the end.
fn table(names: [&str; 2], units: bool, last: Option<&str>, lang: Language) -> Table {
    let sizes = [
        (say!(lang, "tilt"), "arcsec"),
        (say!(lang, "azimuth"), "arcsec"),
        (say!(lang, "velocity"), "m/s"),
        (say!(lang, "position"), "m"),
    ];
    let sizes = sizes.map(|(what, unit)| match units {
        true => format!("{what} {}", lang.in_parentheses(unit)),
        false => what.to_string(),
    });
    let names = names.into_iter().map(|title| (title, Align::Left));
    let sizes = sizes.iter().map(String::as_str).chain(last);
    let columns: Vec<(&str, Align)> = names.chain(sizes.map(|title| (title, Align::Decimal))).collect();
    Table::new(&columns)
}

fn row<const N: usize>(names: [&str; 2], sizes: [Option<f64>; N]) -> Vec<Cell> {
    names.into_iter().map(Cell::from).chain(sizes.map(number)).collect()
}

fn results(report: &NavigateReport, lang: Language) -> Section {
    let last = say!(lang, "position-at-the-end-m");
    let mut table = table([say!(lang, "motion"), say!(lang, "scenario")], true, Some(last), lang);
    for r in &report.results {
        let sizes = [r.tilt_arcsec.rms, r.azimuth_arcsec.rms, r.velocity_m_s.rms, r.position_m.rms, r.position_m.last];
        table.row(row([&r.motion, &r.scenario], sizes));
    }
    let perfect = report.results.iter().any(|r| r.scenario == PERFECT);
    let note = if perfect { say!(lang, "perfect-unit-a-perfect-unit-the-navigators") } else { "" };
    Section::new(say!(lang, "root-mean-square-errors")).table(table).prose(note)
}

fn ratios(report: &NavigateReport, lang: Language) -> Section {
    let mut table = table([say!(lang, "scenario"), say!(lang, "motion")], false, None, lang);
    for r in &report.ratios {
        let motions = format!("{} / {}", r.motion, r.against);
        table.row(row([&r.scenario, &motions], [r.tilt, r.azimuth, r.velocity, r.position]));
    }
    let section = Section::new(say!(lang, "against-the-first-motion"));
    match table.rows.is_empty() {
        true => section,
        false => section.table(table).prose(say!(lang, "ratios-of-root-mean-squares-where-the")),
    }
}

/// Standard uncertainties at the end, by linear covariance and by Monte Carlo.
fn carried(report: &NavigateReport, lang: Language) -> Section {
    let both = |parts: [Option<f64>; 2]| Some(parts[0]?.hypot(parts[1]?));
    let mut table = table([say!(lang, "motion"), say!(lang, "carried-by")], true, None, lang);
    for own in &report.carried {
        let draws = say!(lang, "monte-carlo-draws", draws = own.draws.to_string());
        let ways: [(&str, Option<ErrorReport>); 2] =
            [(say!(lang, "linear-covariance"), own.linear), (&draws, own.monte_carlo)];
        for (by, u) in ways.into_iter().filter_map(|(by, u)| Some((by, u?))) {
            let [east, north, up] = u.phi_arcsec;
            table.row(row([&own.motion, by], [both([east, north]), up, both(u.velocity_m_s), both(u.position_m)]));
        }
    }
    Section::new(say!(lang, "what-the-calibrations-uncertainty-does")).table(table)
}
