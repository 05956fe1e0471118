//! Sections of a fit's page on what it rests on: what was assumed, and the readings one by one.

use super::{Align, Section, Table, Tone, cells};
use crate::campaign::JointState;
use crate::fit::Fit;
use crate::fit::{Estimator, VarianceFrom};
use crate::language::{Language, say};
use crate::report::table::significant;
use crate::report::{FitReport, gravity_text};

/// What the fit takes for granted.
pub(super) fn assumptions(fit: &Fit, report: &FitReport, lang: Language) -> Section {
    let mut points = Vec::new();
    if !report.assumed_zero.is_empty() {
        points.push(say!(
            lang,
            "taken-as-zero-neither-known-nor-estimated",
            assumed_zero = cells::names(&report.assumed_zero, lang)
        ));
    }
    points.push(match fit.campaign.bench.site {
        Some(site) => {
            let said = gravity_text(&report.site, lang).unwrap_or(say!(lang, "gravity-g", gravity_g = site.gravity_g));
            say!(
                lang,
                "site-latitude-earth-rate-deg-h",
                latitude_deg = site.latitude_deg,
                earth_rate_deg_h = site.earth_rate_deg_h,
                said
            )
        }
        None => say!(lang, "no-site-no-earth-rate-and-gravity").into(),
    });
    points.extend(report.site.warnings.iter().map(|warning| say!(lang, "fit-readings-warning", warning)));
    points.push(match report.estimator {
        Estimator::Linear => say!(lang, "linear-rows-are-exact-derivatives-at-the").into(),
        Estimator::Exact => say!(lang, "exact-rows-are-exact-derivatives-iterated-to").into(),
    });
    points.push(match report.fit.variance {
        VarianceFrom::Stated => say!(lang, "uncertainties-of-the-readings-are-as-stated").into(),
        VarianceFrom::Estimated if fit.campaign.scatter.is_empty() => {
            say!(lang, "readings-of-one-sensor-scatter-alike-and").into()
        }
        VarianceFrom::Estimated => say!(lang, "beside-what-scatters-readings-scatter-alike").into(),
    });
    if report.fit.priors > 0 {
        points.push(say!(lang, "entered-as-rows-of-their-own", prior = lang.count(report.fit.priors, "prior")));
    }
    if !report.correlations.is_empty() {
        let one = |(a, b, r): &(String, String, f64)| format!("`{a}`, `{b}`: {}", significant(*r, 4));
        let pairs: Vec<String> = report.correlations.iter().map(one).collect();
        points.push(say!(lang, "known-inputs-are-correlated", pairs = pairs.join("; ")));
    }
    let mut table = Table::new(&[
        (say!(lang, "known"), Align::Left),
        (say!(lang, "value"), Align::Decimal),
        ("u", Align::Decimal),
        (say!(lang, "distribution"), Align::Left),
        ("\u{3bd}", Align::Right),
        (say!(lang, "unit"), Align::Left),
    ]);
    for known in &report.known {
        let u = if known.u > 0.0 { significant(known.u, 3) } else { say!(lang, "exact").into() };
        table.row(vec![
            format!("`{}`", known.id),
            known.value.to_string(),
            u,
            if known.u > 0.0 {
                lang.term("distribution", &known.distribution.to_string()).into_owned()
            } else {
                String::new()
            },
            if known.u > 0.0 { cells::dof(known.dof, true) } else { String::new() },
            known.unit.clone(),
        ]);
    }
    Section::new(say!(lang, "what-was-assumed")).list(points).table(table)
}

/// More readings than this are not listed one by one.
const LISTED: usize = 1000;

/// Each reading with what the fit makes of it.
pub(super) fn readings(fit: &Fit, report: &FitReport, lang: Language) -> Section {
    let joints: Vec<&str> = fit.campaign.bench.joints().collect();
    let states = |index: usize| {
        let place = match &fit.streamed {
            // a reading that is not in the sample has no states to show
            Some(own) => own.numbers.binary_search(&(index as u64)).unwrap_or(usize::MAX),
            None => index - 1,
        };
        fit.campaign.readings.rows.get(place).map(|r| r.joints.as_slice()).unwrap_or_default()
    };
    let mut keys: Vec<String> = Vec::new();
    for (name, k) in joints.iter().zip(0..) {
        for suffix in ["_deg", "_deg_s", "_turns"] {
            let used = report.readings.iter().any(|r| states(r.index).get(k).is_some_and(|s| key(s, suffix).is_some()));
            if used {
                keys.push(format!("{name}{suffix}"));
            }
        }
    }
    let mut columns: Vec<(&str, Align)> = vec![("", Align::Right), (say!(lang, "position"), Align::Left)];
    columns.extend(keys.iter().map(|key| (key.as_str(), Align::Decimal)));
    let several = fit.campaign.bench.sensors.len() > 1;
    if several {
        columns.push((say!(lang, "sensor"), Align::Left));
    }
    columns.extend([
        (say!(lang, "value"), Align::Decimal),
        (say!(lang, "fitted"), Align::Decimal),
        (say!(lang, "residual"), Align::Decimal),
        (say!(lang, "studentized"), Align::Decimal),
        (say!(lang, "redundancy"), Align::Decimal),
        (say!(lang, "detectable"), Align::Right),
    ]);
    let mut table = Table::new(&columns);
    table.small = true;
    for r in report.readings.iter().take(LISTED) {
        let mut cells = vec![r.index.to_string(), r.position.clone()];
        for (name, state) in joints.iter().zip(states(r.index)) {
            for suffix in ["_deg", "_deg_s", "_turns"] {
                if keys.contains(&format!("{name}{suffix}")) {
                    cells.push(key(state, suffix).map(|v| v.to_string()).unwrap_or_default());
                }
            }
        }
        let tenth = r.u.map(|u| u / 10.0);
        if several {
            cells.push(r.sensor.clone());
        }
        cells.extend([
            as_read(r.value, tenth),
            cells::value(Some(r.fitted), tenth),
            cells::value(Some(r.residual), tenth),
            cells::decimals(r.studentized, 2),
            cells::decimals(Some(r.redundancy), 3),
            cells::digits(r.mdb, 3),
        ]);
        table.row(cells);
        if let Some(row) = table.rows.last_mut().filter(|_| r.studentized.is_some_and(|s| s.abs() > super::FAR)) {
            row.tone = Tone::Caution;
        }
    }
    table.note = say!(lang, "redundancy-the-share-of-a-fault-that", limit = super::FAR);
    if report.readings.len() > LISTED {
        table.note.push_str(&format!(
            "{}{}",
            lang.space(),
            say!(lang, "the-first-of-are-listed-the-json", listed = LISTED, n = report.readings.len().to_string())
        ));
    }
    Section::new(say!(lang, "readings")).table(table)
}

/// A value as the file gives it, unless it has more digits than anyone wants to see.
fn as_read(value: f64, u: Option<f64>) -> String {
    let text = value.to_string();
    if text.len() <= 9 { text } else { cells::value(Some(value), u) }
}

fn key(state: &JointState, suffix: &str) -> Option<f64> {
    let (deg, deg_s, turns) = state.keys();
    match suffix {
        "_deg" => deg,
        "_deg_s" => deg_s,
        _ => turns,
    }
}
