//! Sections of a fit's document on what it rests on: what was assumed, and the readings one by one.

use super::super::scene::scene_figure;
use super::super::{FitReport, site};
use super::{Asked, FAR};
use crate::campaign::{Campaign, JointState};
use crate::document::{Align, Cell, Content, Detail, Figure, Section, Table, Tone};
use crate::fit::{Estimator, Fit, VarianceFrom};
use crate::language::{Language, say};

/// What the fit takes for granted.
pub(super) fn assumptions(report: &FitReport, asked: &Asked<'_>, lang: Language) -> Section {
    let mut points = Vec::new();
    if !report.assumed_zero.is_empty() {
        let assumed_zero = lang.names(&report.assumed_zero);
        points.push(say!(lang, "taken-as-zero-neither-known-nor-estimated", assumed_zero));
    }
    match report.site.latitude_deg {
        Some(latitude_deg) => points.push(say!(
            lang,
            "site-latitude-earth-rate-deg-h",
            latitude_deg,
            earth_rate_deg_h = report.site.earth_rate_deg_h,
            said = site::gravity_text(&report.site, lang)
        )),
        None if report.model.values().any(|line| reads_rotation(line)) => {
            points.push(say!(lang, "no-site-no-earth-rate-and-gravity").into());
        }
        None => {}
    }
    if !report.correlations.is_empty() {
        let list = report.correlated();
        points.push(lang.sentence(&say!(lang, "correlated-inputs", list = list.join(lang.comma()))));
    }
    let mut table = Table::new(&[
        (say!(lang, "known"), Align::Left),
        (say!(lang, "value"), Align::Decimal),
        ("u", Align::Decimal),
        (say!(lang, "distribution"), Align::Left),
        (say!(lang, "dof"), Align::Right),
        (say!(lang, "unit"), Align::Left),
    ])
    .at(Detail::Roomy, &[3, 4]);
    for known in &report.known {
        let exact = known.u <= 0.0;
        let shape = || lang.term(&known.distribution.to_string()).into();
        table.row(vec![
            Cell::name(&known.id),
            without_rounding(known.value).to_string().into(),
            if exact { say!(lang, "exact").into() } else { Cell::Digits(known.u, 3) },
            if exact { "".into() } else { shape() },
            if exact { "".into() } else { Cell::dof(known.dof, true) },
            known.unit.as_str().into(),
        ]);
    }
    let section = Section::new(say!(lang, "what-was-assumed")).list(points).table(table).full();
    let estimator = say!(lang, "rows-are-exact-derivatives", iterated = report.estimator == Estimator::Exact);
    let variance = match report.fit.variance {
        VarianceFrom::Stated => lang.sentence(&say!(lang, "noise-floor", noise = lang.term("stated"))),
        VarianceFrom::Estimated => say!(lang, "errors-are-independent").into(),
    };
    let mut origin = Vec::new();
    let source = asked.fit.map(|fit| fit.campaign.bench.source.as_str()).filter(|source| !source.is_empty());
    origin.extend(source.map(|source| (lang.title(say!(lang, "source")), lang.name(source).into_owned())));
    origin.extend(asked.inputs.first().map(|input| (lang.title(say!(lang, "campaign")), input.name.clone())));
    let section = section.list(vec![estimator, variance]);
    let section = if origin.is_empty() { section } else { section.block(Content::Facts(origin)) };
    section.figures(bench_figure(asked.fit.map(|fit| &fit.campaign), lang))
}

/// The bench as its first reading has it; none without joints.
pub(in crate::report) fn bench_figure(campaign: Option<&Campaign>, lang: Language) -> Vec<Figure> {
    let Some(campaign) = campaign.filter(|campaign| campaign.bench.joints().next().is_some()) else {
        return Vec::new();
    };
    let Some(first) = campaign.readings.rows.first() else { return Vec::new() };
    vec![scene_figure(&campaign.bench, &first.joints, say!(lang, "bench-at-first-reading").into(), lang)]
}

/// Does a model line read the rate of rotation about an axis (`w_x`, not `flow_x`)?
fn reads_rotation(line: &str) -> bool {
    line.split(|c: char| !c.is_alphanumeric() && c != '_').any(|name| name.starts_with("w_"))
}

/// A stated value without what converting its unit left in the last digit.
fn without_rounding(value: f64) -> f64 {
    // a printed number is read again
    format!("{value:.14e}").parse().unwrap_or(value)
}

/// More readings than this are not listed on a page.
const LISTED: usize = 1000;

/// Each reading with what the fit makes of it; `asked` puts all of them before a reader of a terminal.
pub(super) fn readings(report: &FitReport, fit: Option<&Fit>, asked: bool, lang: Language) -> Section {
    let joints: Vec<&str> = fit.map(|fit| fit.campaign.bench.joints().collect()).unwrap_or_default();
    let states = |index: usize| -> &[JointState] {
        let place = match fit.and_then(|fit| fit.streamed.as_ref()) {
            // a reading that is not in the sample has no states to show
            Some(own) => own.numbers.binary_search(&(index as u64)).unwrap_or(usize::MAX),
            None => index - 1,
        };
        let row = fit.and_then(|fit| fit.campaign.readings.rows.get(place));
        row.map(|row| row.joints.as_slice()).unwrap_or_default()
    };
    let mut keys: Vec<(usize, &str, String)> = Vec::new();
    for (k, name) in joints.iter().enumerate() {
        for suffix in ["_deg", "_deg_s", "_turns"] {
            let used = report.readings.iter().any(|r| states(r.index).get(k).is_some_and(|s| key(s, suffix).is_some()));
            if used {
                keys.push((k, suffix, format!("{name}{suffix}")));
            }
        }
    }
    let mut columns: Vec<(&str, Align)> =
        vec![(say!(lang, "reading"), Align::Right), (say!(lang, "position"), Align::Left)];
    columns.extend(keys.iter().map(|(.., title)| (title.as_str(), Align::Decimal)));
    columns.extend([
        (say!(lang, "sensor"), Align::Left),
        (say!(lang, "value"), Align::Decimal),
        (say!(lang, "fitted"), Align::Decimal),
        (say!(lang, "residual"), Align::Decimal),
        (say!(lang, "studentized"), Align::Decimal),
        (say!(lang, "redundancy"), Align::Decimal),
        (say!(lang, "mdb"), Align::Right),
    ]);
    let joints: Vec<usize> = (2..2 + keys.len()).collect();
    let mut table = Table::new(&columns).at(Detail::Full, &joints).at(Detail::Roomy, &[4 + keys.len()]);
    table.small = true;
    let most = if asked { usize::MAX } else { LISTED };
    for r in report.readings.iter().take(most) {
        let mut cells: Vec<Cell> = vec![r.index.into(), r.position.as_str().into()];
        for (k, suffix, _) in &keys {
            let state = states(r.index).get(*k).and_then(|state| key(state, suffix));
            cells.push(state.map_or("".into(), |v| v.to_string().into()));
        }
        let tenth = r.u.map(|u| u / 10.0);
        cells.extend([
            r.sensor.as_str().into(),
            as_read(r.value, tenth),
            Cell::Value(r.fitted, tenth),
            Cell::Value(r.residual, tenth),
            Cell::decimals(r.studentized, 2),
            Cell::Decimals(r.redundancy, 3),
            Cell::digits(r.mdb, 3),
        ]);
        table.row(cells);
        table.tone(if r.studentized.is_some_and(|s| s.abs() > FAR) { Tone::Caution } else { Tone::Plain });
    }
    table.note = say!(lang, "redundancy-the-share-of-a-fault-that", limit = FAR);
    if report.readings.len() > most {
        let all = report.readings.len().to_string();
        table.note.push_str(&format!(
            "{}{}",
            lang.space(),
            say!(lang, "the-first-of-are-listed-the-json", listed = LISTED, n = all)
        ));
    }
    let section = Section::new(say!(lang, "readings"));
    if asked { section.table(table) } else { section.full().table(table) }
}

/// A value as the file gives it, unless it has more digits than anyone wants to see.
fn as_read(value: f64, u: Option<f64>) -> Cell {
    let text = value.to_string();
    if text.len() <= 9 { text.into() } else { Cell::Value(value, u) }
}

fn key(state: &JointState, suffix: &str) -> Option<f64> {
    let (deg, deg_s, turns) = state.keys();
    match suffix {
        "_deg" => deg,
        "_deg_s" => deg_s,
        _ => turns,
    }
}
