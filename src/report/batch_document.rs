//! The document of many devices: counts, distributions, devices that stand apart, control charts.

use super::colophon::begin;
use super::fit_document::model_facts;
use super::{BatchReport, DistributionReport, batch_quantities};
use crate::batch::Summary;
use crate::campaign::Campaign;
use crate::document::chart::{Chart, Control, Distribution};
use crate::document::number::{level, significant};
use crate::document::{Align, Cell, Detail, Document, Figure, Section, Table, Tone};
use crate::language::{Language, say};
use std::collections::BTreeMap;

/// Quantities whose charts are drawn.
const DRAWN: usize = 40;

/// The document of many devices. What was fitted has the values that histograms show; `links` leads from a device to a page of its own, where
/// there is one.
pub fn batch_document(
    report: &BatchReport,
    fitted: Option<(&Campaign, &Summary)>,
    links: &BTreeMap<String, String>,
    lang: Language,
) -> Document {
    let devices = lang.count(report.devices.all, "device");
    let mut document = begin(say!(lang, "grouped-by", what = devices, by = report.by), &report.inputs, lang);
    document.facts = vec![
        (say!(lang, "bench").into(), format!("`{}`", report.bench)),
        (say!(lang, "estimator").into(), lang.term(&report.estimator.to_string())),
    ];
    document.facts.extend(model_facts(&report.model, lang));
    document.facts.extend(fitted.map(|(campaign, _)| campaign.identity.facts(lang)).unwrap_or_default());
    document
        .section(answer(report, lang))
        .section(reasons(report, lang))
        .section(not_in_order(report, links, lang))
        .section(distributions(report, fitted, lang))
        .section(apart(report, links, lang))
        .section(lots(report, lang))
}

fn answer(report: &BatchReport, lang: Language) -> Section {
    let own = &report.devices;
    let mut section = Section::new(say!(lang, "result"));
    let bad = own.rejected + own.malformed;
    section = match bad {
        0 => section.verdict(Tone::Good, say!(lang, "all-are-accepted", devices = lang.count(own.all, "device"))),
        _ => section.verdict(
            Tone::Bad,
            say!(
                lang,
                "of-are-not-accepted-rejected-a-rank",
                bad = bad.to_string(),
                devices = lang.count(own.all, "device"),
                rejected = own.rejected.to_string(),
                malformed = own.malformed.to_string()
            ),
        ),
    };
    if let Some(limits) = &report.conformity {
        let tone = match (limits.fail, limits.undecided) {
            (0, 0) => Tone::Good,
            (0, _) => Tone::Caution,
            _ => Tone::Bad,
        };
        section = section.verdict(
            tone,
            say!(
                lang,
                "conformity-rule-pass-undecided-fail",
                decision = limits.decision.to_string(),
                pass = limits.pass.to_string(),
                undecided = limits.undecided.to_string(),
                fail = limits.fail.to_string()
            ),
        );
    }
    let differ: Vec<&str> = report
        .quantities
        .iter()
        .filter(|q| q.scattering.as_ref().is_some_and(|s| s.significant == Some(true)))
        .map(|q| q.id.as_str())
        .collect();
    section.prose(say!(lang, "devices-differ-by-more-than-their-readings", names = lang.names(differ)))
}

/// Devices by reason, and what chance alone finds; no section where no device has a reason.
fn reasons(report: &BatchReport, lang: Language) -> Section {
    let mut table = Table::new(&[
        (say!(lang, "reason"), Align::Left),
        (say!(lang, "devices"), Align::Right),
        (say!(lang, "devices-tested"), Align::Right),
        (say!(lang, "expected-by-chance"), Align::Decimal),
        (say!(lang, "beyond-chance"), Align::Right),
    ]);
    for (reason, devices) in &report.reasons {
        let chance = report.chance.get(reason);
        table.row(vec![
            lang.term(reason.name()).into(),
            (*devices).into(),
            chance.map_or_else(Cell::absent, |own| own.tested.into()),
            Cell::digits(chance.map(|own| own.expected), 2),
            chance.map_or_else(Cell::absent, |own| own.beyond.into()),
        ]);
        let beyond = chance.is_some_and(|own| own.beyond > 0);
        table.tone(if beyond { Tone::Caution } else { Tone::Plain });
    }
    table.note = say!(lang, "chance-alone-finds", level = level(report.level));
    Section::new(say!(lang, "reasons")).table(table)
}

fn distributions(report: &BatchReport, fitted: Option<(&Campaign, &Summary)>, lang: Language) -> Section {
    let mut table = Table::new(&[
        (say!(lang, "quantity"), Align::Left),
        (say!(lang, "devices"), Align::Right),
        (say!(lang, "mean"), Align::Decimal),
        ("sd", Align::Decimal),
        ("u", Align::Decimal),
        (say!(lang, "sd-of-devices"), Align::Decimal),
        (say!(lang, "p-if-alike"), Align::Right),
        (say!(lang, "min"), Align::Decimal),
        (say!(lang, "max"), Align::Decimal),
        (say!(lang, "limits"), Align::Left),
        (say!(lang, "unit"), Align::Left),
    ])
    .at(Detail::Roomy, &[1, 9])
    .at(Detail::Full, &[7, 8]);
    table.small = true;
    for q in &report.quantities {
        table.row(vec![
            Cell::name(&q.id),
            q.devices.into(),
            Cell::Value(q.mean, q.sd),
            Cell::digits(q.sd, 3),
            Cell::digits(q.u, 3),
            Cell::digits(q.scattering.as_ref().map(|s| s.sd_of_devices), 3),
            Cell::p(q.scattering.as_ref().map(|s| s.p)),
            Cell::Value(q.least, q.sd),
            Cell::Value(q.most, q.sd),
            limits_text(q),
            q.unit.as_str().into(),
        ]);
    }
    table.note = say!(lang, "accepted-devices-only-sd-between-devices-u").into();
    let mut figures = Vec::new();
    let ids = fitted.map(|(campaign, _)| batch_quantities(campaign)).unwrap_or_default();
    for q in report.quantities.iter().take(DRAWN) {
        let place = ids.iter().position(|(id, _)| *id == q.id);
        let Some((k, (_, summary))) = place.zip(fitted) else { continue };
        let limits = q.limits.map(|[low, high]| [low.unwrap_or(f64::NEG_INFINITY), high.unwrap_or(f64::INFINITY)]);
        let alone = q.scattering.as_ref().map(|s| [q.median, s.u]);
        let chart =
            Distribution { label: q.id.clone(), unit: q.unit.clone(), values: summary.values(k), limits, alone };
        let caption = format!("{}{}{}", q.id, lang.colon(), lang.count(q.devices, "device"));
        figures.push(Figure::new(caption, Chart::Distribution(chart), false));
    }
    let section = Section::new(say!(lang, "distributions")).table(table).full();
    match figures.is_empty() {
        true => section,
        false => section.prose(say!(lang, "each-histogram-shows-the-accepted-devices-the")).figures(figures),
    }
}

fn limits_text(q: &DistributionReport) -> Cell {
    let bound = |bound: Option<f64>| bound.map_or(String::new(), |x| significant(x, 4));
    match q.limits {
        None => Cell::absent(),
        Some([low, high]) => format!("{}\u{a0}..\u{a0}{}", bound(low), bound(high)).into(),
    }
}

/// Devices that are not accepted or outside a limit; no section where there is none.
fn not_in_order(report: &BatchReport, links: &BTreeMap<String, String>, lang: Language) -> Section {
    let mut section = Section::new(say!(lang, "devices-that-are-not-in-order"));
    let listed = report.not_in_order.len();
    if listed == 0 {
        return section;
    }
    let fails = report.conformity.as_ref().map_or(0, |own| own.fail);
    let all = (report.devices.rejected + report.devices.malformed).max(fails);
    if listed < all {
        let [listed, n] = [listed, all].map(|n| n.to_string());
        section = section.prose(say!(lang, "the-first-of-are-listed-the-json", listed, n));
    }
    let mut columns = vec![(report.by.as_str(), Align::Left), (say!(lang, "verdict"), Align::Left)];
    if report.conformity.is_some() {
        columns.push((say!(lang, "limits"), Align::Left));
    }
    columns.push((say!(lang, "reason"), Align::Left));
    let mut table = Table::new(&columns);
    table.small = true;
    for own in &report.not_in_order {
        let mut cells = vec![own.device.as_str().into(), Cell::from(lang.term(own.verdict.name()))];
        if report.conformity.is_some() {
            cells.push(own.conformity.map_or_else(Cell::absent, |own| lang.term(own.name()).into()));
        }
        cells.push(lang.name(&own.why).into());
        table.row(cells);
        table.link(links.get(&own.device));
    }
    section.table(table)
}

fn apart(report: &BatchReport, links: &BTreeMap<String, String>, lang: Language) -> Section {
    let section = Section::new(say!(lang, "devices-that-stand-apart"));
    if report.outlying.is_empty() {
        return section.prose(say!(lang, "no-accepted-device-stands-apart-from-the"));
    }
    let mut table = Table::new(&[
        (report.by.as_str(), Align::Left),
        (say!(lang, "quantity"), Align::Left),
        (say!(lang, "value"), Align::Decimal),
        ("z", Align::Decimal),
        (say!(lang, "unit"), Align::Left),
    ]);
    for own in &report.outlying {
        let q = report.quantities.iter().find(|q| q.id == own.id);
        table.row(vec![
            own.device.as_str().into(),
            Cell::name(&own.id),
            Cell::Value(own.value, q.and_then(|q| q.u)),
            Cell::Decimals(own.z, 1),
            q.map_or("", |q| q.unit.as_str()).into(),
        ]);
        table.link(links.get(&own.device));
    }
    table.note = say!(lang, "z-value-median-mad-beyond-what-a").into();
    section.table(table)
}

/// Control charts: means of lots against their limits; no section where there are no limits.
fn lots(report: &BatchReport, lang: Language) -> Section {
    let section = Section::new(say!(lang, "control-charts"));
    let limited = |id: &str| report.lots.iter().any(|lot| lot.control.contains_key(id));
    let drawn = report.quantities.iter().filter(|q| limited(&q.id)).take(DRAWN);
    let (mut figures, mut table) = (
        Vec::new(),
        Table::new(&[
            (say!(lang, "quantity"), Align::Left),
            (say!(lang, "lot"), Align::Left),
            (say!(lang, "devices"), Align::Right),
            (say!(lang, "mean"), Align::Decimal),
            (say!(lang, "control-limits"), Align::Left),
            (say!(lang, "unit"), Align::Left),
        ]),
    );
    for q in drawn {
        let mut lots = Vec::new();
        for lot in &report.lots {
            let (Some(mean), Some(by)) = (lot.mean.get(&q.id), lot.control.get(&q.id)) else { continue };
            lots.push((lot.name.clone(), *mean, *by));
            if lot.is_beyond(q) {
                let [low, high] = [q.mean - by, q.mean + by].map(|limit| Cell::Value(limit, Some(*by)).text());
                table.row(vec![
                    Cell::name(&q.id),
                    lot.name.as_str().into(),
                    lot.devices.get(&q.id).copied().unwrap_or_default().into(),
                    Cell::Value(*mean, Some(*by)),
                    format!("{low} .. {high}").into(),
                    q.unit.as_str().into(),
                ]);
            }
        }
        let caption = say!(lang, "grouped-by", what = q.id, by = say!(lang, "lot"));
        let control = Control { label: q.id.clone(), unit: q.unit.clone(), lots, mean: q.mean };
        figures.push(Figure::new(caption, Chart::Control(control), false));
    }
    let section = match (figures.is_empty(), table.rows.is_empty()) {
        (true, _) => return section,
        (_, true) => {
            section.verdict(Tone::Good, say!(lang, "lots-beyond-their-control-limits", lots = say!(lang, "none")))
        }
        (_, false) => {
            let lots = table.rows.len().to_string();
            section.verdict(Tone::Caution, say!(lang, "lots-beyond-their-control-limits", lots)).table(table)
        }
    };
    section.full().prose(say!(lang, "points-are-means-of-lots-the-line")).figures(figures)
}
