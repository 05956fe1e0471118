//! Words of a plan.

use super::{LackingReport, PointReport, SharedReport, ThroughTiltsReport, WorkReport};
use crate::document::number::significant;
use crate::language::{Language, say};
use crate::plan::PointSource;
use std::collections::BTreeMap;

/// The point at which schedules are judged, in words: values with their source, then what stands at zero.
pub(super) fn judged_at(point: &[PointReport], lang: Language) -> String {
    let mut parts: Vec<String> = Vec::new();
    let mut zero: Vec<&str> = Vec::new();
    for value in point {
        let (number, unit) = match value.arcsec {
            Some(arcsec) => (arcsec, "arcsec"),
            None => (value.value, value.unit.as_str()),
        };
        match value.from {
            PointSource::Zero => zero.push(&value.id),
            from => {
                let from = lang.term(&from.to_string());
                parts.push(format!("{} = {} {unit} ({from})", value.id, significant(number, 4)).replace("  ", " "));
            }
        }
    }
    match (zero.len(), parts.is_empty()) {
        (0, _) => {}
        (_, true) => parts.push(say!(lang, "zero-no-parameter-has-a-start-prior").into()),
        (1..=6, _) => parts.push(format!("{} = 0", zero.join(", "))),
        (count, _) => parts.push(say!(lang, "plan-table-others", count = count.to_string())),
    }
    parts.join(", ")
}

/// What needs a value, in one sentence.
pub(super) fn lacking(lacking: &LackingReport, lang: Language) -> String {
    let needs = lacking.needs.join(", ");
    let first = lacking.needs.first().map_or("", String::as_str);
    let untold = lacking.untold.join(", ");
    say!(lang, "uncertainty-depends-on-a-value", untold, needs, first)
}

pub(super) fn work_of(w: &WorkReport, lang: Language) -> String {
    say!(
        lang,
        "in-with-cost",
        readings = lang.count(w.readings, "reading"),
        mountings = w.mountings.to_string(),
        rate_changes = w.rate_changes.to_string(),
        cost = significant(w.cost, 4)
    )
}

/// What known inputs do through the tilts, in one sentence.
pub(super) fn through_tilts(through: &ThroughTiltsReport, lang: Language) -> String {
    let (u, unit) = match through.u_arcsec {
        Some(arcsec) => (arcsec, " arcsec"),
        None => (through.u, ""),
    };
    let ThroughTiltsReport { known, parameter, tilts_arcsec, .. } = through;
    let (u, tilts) = (significant(u, 2), significant(*tilts_arcsec, 3));
    match through.counted {
        true => say!(lang, "counted-above-with-tilts-of-arcsec-the", tilts, known, u, unit, parameter),
        false => say!(lang, "not-counted-the-uncertainty-of-acts-through", known, tilts, u, unit, parameter),
    }
}

/// The levels that chosen positions are planned for, where they share deviations.
pub(super) fn shared(list: &[SharedReport], lang: Language) -> Vec<String> {
    let told = |own: &SharedReport| {
        let SharedReport { line, column, levels } = own;
        say!(lang, "positions-share-deviations-planned-for", line, levels = format!("{column} = {}", levels.join(", ")))
    };
    list.iter().map(told).collect()
}

/// Why no position separates what is not estimable: none of the bench does, or the candidates hold a column at one value.
pub(super) fn nowhere(frozen: &BTreeMap<String, f64>, lang: Language) -> String {
    let held: Vec<String> = frozen.iter().map(|(column, value)| format!("{column} = {value}")).collect();
    match held.is_empty() {
        true => say!(lang, "no-position-of-this-bench-would-separate-2").into(),
        false => say!(lang, "no-candidate-would-separate-it-but-all", held = held.join(", ")),
    }
}
