//! The picture of a diagnosis: residuals before and after, grouped by the factor that the gap follows.

use super::DiagnoseReport;
use super::gap::SensorGapReport;
use crate::campaign::Campaign;
use crate::diagnosis::{Diagnosis, Grouping, Level};
use crate::document::Figure;
use crate::document::chart::{Chart, GapPanel, GapPoint};
use crate::document::number::trimmed;
use crate::language::{Language, say};

/// Most sensors in one picture.
const PANELS: usize = 6;
/// More points than this in one picture are thinned; those far out stay.
const POINTS: usize = 2400;

/// Residuals before and after, as the page of a diagnosis has them.
pub fn diagnose_figure(campaign: &Campaign, diagnosis: &Diagnosis, report: &DiagnoseReport, lang: Language) -> Figure {
    let sensors = shown(campaign, diagnosis, report);
    let total: usize = sensors.iter().filter_map(|k| gap_of(campaign, report, *k)).map(|own| own.readings).sum();
    let every = total.div_ceil(POINTS).max(1);
    let panels: Vec<GapPanel> =
        sensors.iter().map(|k| panel(campaign, diagnosis, report, *k, (every, sensors.len()), lang)).collect();
    let factor = diagnosis.grouping.as_ref().map_or("", |g| g.factor.as_str());
    let mut caption = vec![match report.effects.is_empty() {
        true => say!(lang, "each-reading-minus-the-model-as-given").to_string(),
        false => say!(lang, "each-reading-minus-the-model-circles-with").to_string(),
    }];
    if !factor.is_empty() {
        caption.push(say!(lang, "readings-are-grouped-by-which-the-gap", factor = named(factor, lang)));
    }
    if every > 1 {
        let every = every.to_string();
        caption.push(say!(lang, "one-reading-in-is-drawn", every));
    }
    let left = campaign.bench.sensors.len() - sensors.len();
    if left > 0 {
        caption.push(say!(lang, "further-sensors-are-not-drawn", n = left));
    }
    let caption = caption.join(lang.space());
    Figure::new(caption, Chart::Gap(panels, factor.into()), true)
}

fn gap_of<'a>(campaign: &Campaign, report: &'a DiagnoseReport, sensor: usize) -> Option<&'a SensorGapReport> {
    report.gap.sensors.get(&campaign.bench.sensors.get(sensor)?.id)
}

/// The sensors of the picture, in the bench's order: those with an effect first, then those whose gap is largest against their noise.
fn shown(campaign: &Campaign, diagnosis: &Diagnosis, report: &DiagnoseReport) -> Vec<usize> {
    let size = |k: usize| {
        let own = gap_of(campaign, report, k)?;
        let named = diagnosis.effects.iter().any(|finding| finding.effect.sensor == Some(k));
        let relative = own.rms_before.zip(own.sd).map_or(0.0, |(rms, sd)| rms / sd);
        Some((k, named, relative))
    };
    let mut sensors: Vec<(usize, bool, f64)> = (0..campaign.bench.sensors.len()).filter_map(size).collect();
    sensors.sort_by(|a, b| b.1.cmp(&a.1).then(b.2.total_cmp(&a.2)));
    let mut shown: Vec<usize> = sensors.into_iter().take(PANELS).map(|(k, ..)| k).collect();
    shown.sort_unstable();
    shown
}

fn panel(
    campaign: &Campaign,
    diagnosis: &Diagnosis,
    report: &DiagnoseReport,
    sensor: usize,
    (every, panels): (usize, usize),
    lang: Language,
) -> GapPanel {
    let (id, unit) = campaign.bench.sensors.get(sensor).map_or(("", ""), |s| (s.id.as_str(), s.unit.as_str()));
    let repaired = diagnosis.after.is_some();
    let levels = diagnosis.grouping.as_ref().map(ordered).unwrap_or_default();
    let level = |reading: usize| diagnosis.grouping.as_ref().and_then(|g| g.of.get(reading).copied().flatten());
    let mut rows: Vec<(usize, GapPoint)> = Vec::new();
    for (k, own) in report.residuals.iter().filter(|own| own.sensor == id).enumerate() {
        let band = own.sd.map(|sd| 2.0 * sd);
        let far = band.is_some_and(|band| own.before.abs() > 2.0 * band || own.after.abs() > 2.0 * band);
        if k % every != 0 && !far {
            continue;
        }
        let place = level(own.index - 1).and_then(|level| levels.iter().position(|(own, _)| *own == level));
        let group = place.and_then(|place| levels.get(place)).map_or(String::new(), |(_, label)| label.clone());
        let after = repaired.then_some(own.after);
        rows.push((place.unwrap_or(levels.len()), GapPoint { group, before: own.before, after, band }));
    }
    rows.sort_by_key(|(place, _)| *place);
    // the title of a low panel has little room
    let title = if panels > 2 { id.to_string() } else { format!("{id} {}", say!(lang, "residual")) };
    GapPanel { title, unit: unit.into(), points: rows.into_iter().map(|(_, p)| p).collect() }
}

/// Levels with their labels: numbers from small to large, labels as they come.
fn ordered(grouping: &Grouping) -> Vec<(usize, String)> {
    let mut levels: Vec<(usize, Option<f64>, String)> = grouping
        .levels
        .iter()
        .enumerate()
        .map(|(k, level)| match level {
            Level::Number(v) => (k, Some(*v), trimmed(*v)),
            Level::Text(text) => (k, None, text.clone()),
        })
        .collect();
    levels.sort_by(|a, b| a.1.unwrap_or(0.0).total_cmp(&b.1.unwrap_or(0.0)));
    levels.into_iter().map(|(k, _, label)| (k, label)).collect()
}

/// A factor: a column of the campaign in code type, anything else in words.
pub(super) fn named(name: &str, lang: Language) -> String {
    match lang.name(name) {
        std::borrow::Cow::Borrowed(name) => format!("`{name}`"),
        std::borrow::Cow::Owned(name) => name,
    }
}
