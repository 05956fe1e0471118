//! The page of a diagnosis of navigation errors: what is missing, the gap shrinking, what else it could be.

use crate::report::diagnose::words::tone;
use super::{Align, Figure, Page, Section, Table};
use crate::diagnosis::NoiseFrom;
use crate::document::chart::{Chart, Curve};
use crate::document::plot;
use crate::elements::Elements;
use crate::error::Result;
use crate::language::{Language, say};
use crate::navigate::diagnose::NavigationDiagnosis;
use crate::navigate::measured::{CHANNEL_NAMES, si_per_unit};
use crate::navigate::remainder::GapOverTime;
use crate::document::number::probability as p;
use crate::report::navigate_diagnose_table::{after, alias, between, grouped, runs, sentence as words, tried, unit};
use crate::report::table::{rounded, significant};
use crate::report::{GapReport, NavigateDiagnoseReport, NavigationEffectReport};

/// Titles of the channels' figures, as keys of the catalogue, and units.
const TITLES: [(&str, &str); 7] = [
    ("phi-about-east", "arcsec"),
    ("phi-about-north", "arcsec"),
    ("phi-about-up", "arcsec"),
    ("velocity-east", "m/s"),
    ("velocity-north", "m/s"),
    ("position-east", "m"),
    ("position-north", "m"),
];

fn title_of(channel: usize) -> (&'static str, &'static str) {
    TITLES.get(channel).copied().unwrap_or(("?", "")) // channels are places in this list
}

/// The page of a report, with figures of the diagnosis that it tells of.
pub fn navigate_diagnose_page(
    report: &NavigateDiagnoseReport,
    diagnosis: &NavigationDiagnosis,
    lang: Language,
) -> Result<Page> {
    let title = if report.mission.is_empty() { say!(lang, "navigation-errors") } else { &report.mission };
    let mut page = Page::new(say!(lang, "navigate-diagnose-diagnosis", title));
    page.language = lang;
    page.subtitle = say!(lang, "measured-navigation-errors", runs = runs(report, lang).join(lang.comma()));
    page.colophon.push(("tumble".into(), report.tumble.clone()));
    let mut result = Section::new(say!(lang, "result"))
        .verdict(tone(report.verdict), lang.sentence(&words(report, lang)))
        .prose(lang.sentence(&tried(report, lang)))
        .table(effects(report, lang));
    if let Some(unexplained) = &report.unexplained {
        result = result.prose(lang.name(&unexplained.pattern));
        if !unexplained.nearest.is_empty() {
            let nearest: Vec<String> = unexplained.nearest.iter().map(|id| format!("`{id}`")).collect();
            result = result.prose(say!(
                lang,
                "nearest-of-the-catalogue-would-take-off-2",
                names = nearest.join(" + "),
                share = format!("{:.2} %", 100.0 * unexplained.nearest_explains)
            ));
        }
    }
    page = page.section(result);
    for effect in &report.effects {
        page = page.section(rivals(effect, lang));
    }
    page = page.section(gap(report, lang)).section(figures(report, diagnosis, lang)?).section(cells(report, lang));
    let mut rest = Section::new(say!(lang, "where-this-comes-from"));
    let [tried, distinct, times] =
        [report.candidates, report.distinct_candidates, report.refits].map(|n| n.to_string());
    rest = rest.prose(match report.settled {
        true => say!(lang, "causes-tried-until-the-refit-settled", tried, distinct, times),
        false => say!(lang, "causes-tried-until-the-refit-was-given-up", tried, distinct, times),
    });
    if !report.invisible.is_empty() {
        rest = rest.prose(say!(lang, "these-data-cannot-show-2", sources = grouped(&report.invisible).join(", ")));
    }
    Ok(page.section(rest))
}

fn effects(report: &NavigateDiagnoseReport, lang: Language) -> Table {
    let mut table = Table::new(&[
        (say!(lang, "error"), Align::default()),
        (say!(lang, "what-it-is"), Align::default()),
        (say!(lang, "value"), Align::Right),
        ("u", Align::Right),
        (say!(lang, "unit"), Align::default()),
        ("t", Align::Decimal),
        ("p", Align::Right),
        (say!(lang, "explains-2"), Align::Right),
    ]);
    for effect in &report.effects {
        table.row(vec![
            format!("`{}`", effect.regressor),
            lang.name(&effect.name).into_owned(),
            rounded(effect.value, effect.u),
            effect.u.map_or("-".into(), |u| rounded(u, Some(u))),
            unit(&effect.unit, lang).into(),
            format!("{:.1}", effect.t),
            p(effect.p),
            format!("{:.1} %", 100.0 * effect.explains),
        ]);
    }
    table.note = say!(lang, "values-are-changes-of-the-missions-errors").into();
    table
}

fn rivals(effect: &NavigationEffectReport, lang: Language) -> Section {
    let mut section = Section::new(say!(lang, "what-else-could-be", effect = effect.regressor));
    if effect.aliases.is_empty() {
        return section;
    }
    section = section.prose(say!(lang, "these-data-cannot-tell-it-from"));
    section = section
        .list(effect.aliases.iter().map(|own| format!("`{}`, {}", alias(own, lang), lang.name(&own.name))).collect());
    let tells = effect.separate_by.iter().map(|own| {
        let names: Vec<String> = own.tells.iter().map(|id| format!("`{id}`")).collect();
        let by = format!("{:.0}", own.by);
        say!(lang, "tells-it-by-standard-deviations-or-more", run = lang.name(&own.is), by, names = names.join(", "))
    });
    let tells: Vec<String> = tells.collect();
    if !tells.is_empty() {
        section = section.prose(say!(lang, "a-further-run-would-tell-best-first")).list(tells);
    }
    section
}

fn gap(report: &NavigateDiagnoseReport, lang: Language) -> Section {
    let mut table = Table::new(&[
        (say!(lang, "gap-in-standard-uncertainties"), Align::default()),
        (say!(lang, "rms"), Align::Decimal),
        (say!(lang, "largest"), Align::Decimal),
        (say!(lang, "chi-square"), Align::Decimal),
        (say!(lang, "dof"), Align::Right),
        ("p", Align::Right),
    ]);
    let row = |name: &str, gap: &GapReport| {
        let p = gap.p.map_or("-".into(), p);
        let rms = gap.rms.map_or("-".into(), |v| significant(v, 4));
        vec![name.into(), rms, significant(gap.max, 4), significant(gap.chi_square, 4), gap.dof.to_string(), p]
    };
    table.row(row(say!(lang, "before-repair"), &report.gap.before));
    for (name, gap) in between(report) {
        table.row(row(&name, &gap));
    }
    if !report.effects.is_empty() {
        table.row(row(&after(report, lang), &report.gap.after));
    }
    let mut channels = Table::new(&[
        (say!(lang, "channel"), Align::default()),
        (say!(lang, "motion"), Align::default()),
        (say!(lang, "values"), Align::Right),
        (say!(lang, "rms-before"), Align::Decimal),
        (say!(lang, "rms-after"), Align::Decimal),
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
        channels.note = say!(lang, "no-standard-uncertainties-are-stated-for-some").into();
    }
    Section::new(say!(lang, "the-gap-measured-minus-predicted")).table(table).table(channels)
}

/// The gap in time, before and with what was found, in the channel where it is largest against its standard uncertainty.
pub fn navigate_diagnose_svg(
    report: &NavigateDiagnoseReport,
    diagnosis: &NavigationDiagnosis,
    lang: Language,
) -> Result<String> {
    let found = !report.effects.is_empty();
    let pairs = diagnosis.gaps_over_time.iter().zip(&diagnosis.channels);
    let size = |channel: &crate::navigate::remainder::ChannelGap| channel.before.0 / channel.u.max(f64::MIN_POSITIVE);
    let worst = pairs.max_by(|a, b| size(a.1).total_cmp(&size(b.1)));
    let Some((series, _)) = worst else {
        return plot::draw(&Chart::curves(&[], say!(lang, "gap"), "", say!(lang, "time-h")), lang);
    };
    let (what, unit) = title_of(series.channel);
    let what = lang.word(what);
    let title = say!(lang, "measured-minus-predicted", what, motion = series.motion);
    plot::draw(&Chart::curves(&lines(series, found, lang), &title, unit, say!(lang, "time-h")), lang)
}

/// The gap in one channel, before and with what was found.
fn lines(series: &GapOverTime, found: bool, lang: Language) -> Vec<Curve> {
    let scale = 1.0 / si_per_unit(series.channel);
    let line = |label: &str, of: &dyn Fn(&(f64, f64, f64)) -> f64| Curve {
        label: label.into(),
        points: series.points.iter().map(|point| (point.0 / 3600.0, scale * of(point))).collect(),
        dashed: false,
    };
    let mut lines = vec![line(say!(lang, "before-repair"), &|point| point.1)];
    if found {
        lines.push(line(say!(lang, "with-what-was-found-2"), &|point| point.2));
    }
    lines
}

fn figures(report: &NavigateDiagnoseReport, diagnosis: &NavigationDiagnosis, lang: Language) -> Result<Section> {
    let found = !report.effects.is_empty();
    let several = report.runs.len() > 1;
    let mut figures = Vec::new();
    for (series, channel) in diagnosis.gaps_over_time.iter().zip(&diagnosis.channels) {
        let (what, unit) = title_of(series.channel);
        let what = lang.word(what);
        let name = CHANNEL_NAMES.at(series.channel);
        let scale = 1.0 / si_per_unit(series.channel);
        let where_ = if several { format!(" ({})", series.motion) } else { String::new() };
        figures.push(Figure {
            caption: say!(lang, "gap-of", name, where_),
            description: say!(
                lang,
                "gap-of-root-mean-square-before-after",
                name,
                where_,
                before = significant(scale * channel.before.0, 3),
                after = significant(scale * channel.after.0, 3)
            ),
            chart: Chart::curves(&lines(series, found, lang), what, unit, say!(lang, "time-h")),
            wide: false,
        });
        if found {
            // the band of two u as a box around the time of the run
            let (first, last) = (series.points.first().map_or(0.0, |p| p.0), series.points.last().map_or(0.0, |p| p.0));
            let corners = [(first, 2.0), (last, 2.0), (last, -2.0), (first, -2.0), (first, 2.0)];
            let band = corners.map(|(time, size)| (time / 3600.0, size * scale * channel.u)).to_vec();
            let left = series.points.iter().map(|point| (point.0 / 3600.0, scale * point.2)).collect();
            let lines = [
                Curve { label: say!(lang, "two-u").into(), points: band, dashed: true },
                Curve { label: say!(lang, "what-is-left").into(), points: left, dashed: false },
            ];
            figures.push(Figure {
                caption: say!(lang, "what-is-left-of-with-two-standard", name, where_),
                description: super::navigate::in_words(&lines, what, unit, say!(lang, "what-was-found"), lang),
                chart: Chart::curves(&lines, what, unit, say!(lang, "time-h")),
                wide: false,
            });
        }
    }
    Ok(Section::new(say!(lang, "in-time")).figures(figures))
}

fn cells(report: &NavigateDiagnoseReport, lang: Language) -> Section {
    let mut table = Table::new(&[
        (say!(lang, "channel"), Align::default()),
        (say!(lang, "motion"), Align::default()),
        (say!(lang, "time-h"), Align::default()),
        (say!(lang, "values"), Align::Right),
        (say!(lang, "mean-gap"), Align::Decimal),
        (say!(lang, "in-standard-deviations"), Align::Decimal),
    ]);
    for cell in report.unexplained.iter().flat_map(|own| &own.cells) {
        table.row(vec![
            format!("`{}`", cell.column),
            cell.motion.clone(),
            say!(lang, "from-to", a = significant(cell.from_h, 3), b = significant(cell.to_h, 3)),
            cell.values.to_string(),
            significant(cell.mean, 3),
            format!("{:.1}", cell.z),
        ]);
    }
    let mut far = Table::new(&[
        (say!(lang, "single-values-far-off"), Align::default()),
        (say!(lang, "motion"), Align::default()),
        (say!(lang, "time-s"), Align::Decimal),
        (say!(lang, "in-standard-uncertainties"), Align::Decimal),
    ]);
    for own in &report.suspects {
        far.row(vec![format!("`{}`", own.column), own.motion.clone(), own.time_s.to_string(), format!("{:.1}", own.z)]);
    }
    Section::new(say!(lang, "where-it-is")).table(table).table(far)
}
