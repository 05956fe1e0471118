//! The page of a diagnosis of navigation errors: what is missing, the gap shrinking, what else it could be.

use super::diagnose_page::{sentence, tone};
use super::{Align, Figure, Page, Section, Table};
use crate::diagnosis::NoiseFrom;
use crate::error::Result;
use crate::navigate::diagnose::NavigationDiagnosis;
use crate::navigate::measured::{CHANNEL_NAMES, si_per_unit};
use crate::navigate::remainder::Course;
use crate::report::diagnose::words::p;
use crate::report::navigate_diagnose_table::{alias, grouped, sentence as words, tried, unit};
use crate::report::plot::{Curve, curves};
use crate::report::table::{rounded, significant};
use crate::report::{GapReport, NavigateDiagnoseReport, NavigationEffectReport};

/// Titles and units of the channels' figures.
const TITLES: [(&str, &str); 7] = [
    ("phi about east", "arcsec"),
    ("phi about north", "arcsec"),
    ("phi about up", "arcsec"),
    ("velocity east", "m/s"),
    ("velocity north", "m/s"),
    ("position east", "m"),
    ("position north", "m"),
];

/// The page of a report, with figures of the diagnosis that it tells of.
pub fn navigate_diagnose_page(report: &NavigateDiagnoseReport, diagnosis: &NavigationDiagnosis) -> Result<Page> {
    let title = if report.mission.is_empty() { "Navigation errors" } else { &report.mission };
    let mut page = Page::new(format!("{title}: diagnosis"));
    let runs: Vec<String> = report.runs.iter().map(|run| format!("{} rows of {}", run.rows, run.motion)).collect();
    page.subtitle = format!("Measured navigation errors: {}", runs.join(", "));
    page.colophon.push(("tumble".into(), report.tumble.clone()));
    let mut result = Section::new("Result")
        .verdict(tone(report.verdict), sentence(&words(report)))
        .prose(format!("{}.", tried(report)))
        .table(effects(report));
    if let Some(unexplained) = &report.unexplained {
        result = result.prose(unexplained.pattern.clone());
        if !unexplained.nearest.is_empty() {
            let nearest: Vec<String> = unexplained.nearest.iter().map(|id| format!("`{id}`")).collect();
            result = result.prose(format!(
                "Nearest of the catalogue: {} would take off {:.2} % and leave more than noise, so nothing was accepted.",
                nearest.join(" + "),
                100.0 * unexplained.nearest_explains
            ));
        }
    }
    page = page.section(result);
    for effect in &report.effects {
        page = page.section(rivals(effect));
    }
    page = page.section(gap(report)).section(figures(report, diagnosis)?).section(cells(report));
    let mut rest = Section::new("Where this comes from");
    rest = rest.prose(format!(
        "{} causes were tried, {} of them distinct in these data; every p accounts for that. The full simulation was flown {} times for it, \
         until the refit {}.",
        report.candidates,
        report.distinct_candidates,
        report.refits,
        if report.settled { "settled" } else { "was given up" }
    ));
    if !report.invisible.is_empty() {
        rest = rest.prose(format!("These data cannot show {}.", grouped(&report.invisible).join(", ")));
    }
    Ok(page.section(rest))
}

fn effects(report: &NavigateDiagnoseReport) -> Table {
    let mut table = Table::new(&[
        ("error", Align::default()),
        ("what it is", Align::default()),
        ("value", Align::Right),
        ("u", Align::Right),
        ("unit", Align::default()),
        ("t", Align::Decimal),
        ("p", Align::Right),
        ("explains", Align::Right),
    ]);
    for effect in &report.effects {
        table.row(vec![
            format!("`{}`", effect.regressor),
            effect.name.clone(),
            rounded(effect.value, effect.u),
            effect.u.map_or("-".into(), |u| rounded(u, Some(u))),
            unit(&effect.unit).into(),
            format!("{:.1}", effect.t),
            p(effect.p),
            format!("{:.1} %", 100.0 * effect.explains),
        ]);
    }
    table.note = "Values are changes of the mission's errors.".into();
    table
}

fn rivals(effect: &NavigationEffectReport) -> Section {
    let mut section = Section::new(format!("What else {} could be", effect.regressor));
    if effect.aliases.is_empty() {
        return section;
    }
    section = section.prose("These data cannot tell it from:");
    section = section.list(effect.aliases.iter().map(|own| format!("`{}`, {}", alias(own), own.name)).collect());
    let tells = effect.separate_by.iter().map(|own| {
        let names: Vec<String> = own.tells.iter().map(|id| format!("`{id}`")).collect();
        format!("{}: tells it by {:.0} standard deviations or more from {}", own.is, own.by, names.join(", "))
    });
    let tells: Vec<String> = tells.collect();
    if !tells.is_empty() {
        section = section.prose("A further run would tell, best first:").list(tells);
    }
    section
}

fn gap(report: &NavigateDiagnoseReport) -> Section {
    let mut table = Table::new(&[
        ("gap, in standard uncertainties", Align::default()),
        ("rms", Align::Decimal),
        ("largest", Align::Decimal),
        ("chi-square", Align::Decimal),
        ("dof", Align::Right),
        ("p", Align::Right),
    ]);
    let row = |name: &str, gap: &GapReport| {
        let p = gap.p.map_or("-".into(), p);
        let rms = gap.rms.map_or("-".into(), |v| significant(v, 4));
        vec![name.into(), rms, significant(gap.max, 4), significant(gap.chi_square, 4), gap.dof.to_string(), p]
    };
    table.row(row("before", &report.gap.before));
    if !report.effects.is_empty() {
        table.row(row("after", &report.gap.after));
    }
    let mut channels = Table::new(&[
        ("channel", Align::default()),
        ("motion", Align::default()),
        ("values", Align::Right),
        ("rms before", Align::Decimal),
        ("rms after", Align::Decimal),
        ("u", Align::Decimal),
    ]);
    for own in &report.channels {
        channels.row(vec![
            format!("`{}`", own.column),
            own.motion.clone(),
            own.values.to_string(),
            significant(own.rms_before, 4),
            significant(own.rms_after, 4),
            significant(own.u, 3),
        ]);
    }
    if report.gap.noise.from == NoiseFrom::Residuals {
        channels.note =
            "No standard uncertainties are stated for some channels: theirs can only come from what is left, so that \
                         completeness cannot be tested."
                .into();
    }
    Section::new("The gap: measured minus predicted").table(table).table(channels)
}

/// The gap in time, before and with what was found, in the channel where it is largest against its standard uncertainty.
pub fn navigate_diagnose_svg(report: &NavigateDiagnoseReport, diagnosis: &NavigationDiagnosis) -> Result<String> {
    let found = !report.effects.is_empty();
    let pairs = diagnosis.courses.iter().zip(&diagnosis.channels);
    let size = |channel: &crate::navigate::remainder::ChannelGap| channel.before.0 / channel.u.max(f64::MIN_POSITIVE);
    let worst = pairs.max_by(|a, b| size(a.1).total_cmp(&size(b.1)));
    let Some((course, _)) = worst else { return curves(&[], "gap", "", "time, h") };
    let (what, unit) = TITLES.get(course.channel).copied().unwrap_or_default();
    let title = format!("{what} ({}), measured minus predicted", course.motion);
    curves(&lines(course, found), &title, unit, "time, h")
}

/// The gap in one channel, before and with what was found.
fn lines(course: &Course, found: bool) -> Vec<Curve> {
    let scale = 1.0 / si_per_unit(course.channel);
    let line = |label: &str, of: &dyn Fn(&(f64, f64, f64)) -> f64| Curve {
        label: label.into(),
        points: course.points.iter().map(|point| (point.0 / 3600.0, scale * of(point))).collect(),
        dashed: false,
    };
    let mut lines = vec![line("before", &|point| point.1)];
    if found {
        lines.push(line("with what was found", &|point| point.2));
    }
    lines
}

fn figures(report: &NavigateDiagnoseReport, diagnosis: &NavigationDiagnosis) -> Result<Section> {
    let found = !report.effects.is_empty();
    let several = report.runs.len() > 1;
    let mut figures = Vec::new();
    for (course, channel) in diagnosis.courses.iter().zip(&diagnosis.channels) {
        let (what, unit) = TITLES.get(course.channel).copied().unwrap_or_default();
        let name = CHANNEL_NAMES.get(course.channel).copied().unwrap_or_default();
        let scale = 1.0 / si_per_unit(course.channel);
        let where_ = if several { format!(" ({})", course.motion) } else { String::new() };
        figures.push(Figure {
            caption: format!("Gap of `{name}`{where_}"),
            description: format!(
                "Gap of {name}{where_}: root mean square {} before, {} after",
                significant(scale * channel.before.0, 3),
                significant(scale * channel.after.0, 3)
            ),
            svg: curves(&lines(course, found), what, unit, "time, h")?,
            wide: false,
        });
        if found {
            // the band of two u as a box around the time of the run
            let (first, last) = (course.points.first().map_or(0.0, |p| p.0), course.points.last().map_or(0.0, |p| p.0));
            let corners = [(first, 2.0), (last, 2.0), (last, -2.0), (first, -2.0), (first, 2.0)];
            let band = corners.map(|(time, size)| (time / 3600.0, size * scale * channel.u)).to_vec();
            let left = course.points.iter().map(|point| (point.0 / 3600.0, scale * point.2)).collect();
            let lines = [
                Curve { label: "two u".into(), points: band, dashed: true },
                Curve { label: "what is left".into(), points: left, dashed: false },
            ];
            figures.push(Figure {
                caption: format!("What is left of `{name}`{where_}, with two standard uncertainties"),
                description: super::navigate::in_words(&lines, what, unit, "what was found"),
                svg: curves(&lines, what, unit, "time, h")?,
                wide: false,
            });
        }
    }
    Ok(Section::new("In time").figures(figures))
}

fn cells(report: &NavigateDiagnoseReport) -> Section {
    let mut table = Table::new(&[
        ("channel", Align::default()),
        ("motion", Align::default()),
        ("time, h", Align::default()),
        ("values", Align::Right),
        ("mean gap", Align::Decimal),
        ("in standard deviations", Align::Decimal),
    ]);
    for cell in report.unexplained.iter().flat_map(|own| &own.cells) {
        table.row(vec![
            format!("`{}`", cell.column),
            cell.motion.clone(),
            format!("{} to {}", significant(cell.from_h, 3), significant(cell.to_h, 3)),
            cell.values.to_string(),
            significant(cell.mean, 3),
            format!("{:.1}", cell.z),
        ]);
    }
    let mut far = Table::new(&[
        ("single values far off", Align::default()),
        ("motion", Align::default()),
        ("time, s", Align::Decimal),
        ("in standard uncertainties", Align::Decimal),
    ]);
    for own in &report.suspects {
        far.row(vec![format!("`{}`", own.column), own.motion.clone(), own.time_s.to_string(), format!("{:.1}", own.z)]);
    }
    Section::new("Where it is").table(table).table(far)
}
