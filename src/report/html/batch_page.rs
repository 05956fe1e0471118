//! The page of many devices: counts, distributions, devices that stand apart, control charts.

use super::colophon::colophon;
use super::{Align, Figure, Page, Section, Table, Tone, cells};
use crate::batch::Summary;
use crate::campaign::Campaign;
use crate::error::Result;
use crate::language::{Language, say};
use crate::report::plot::{self, Control, Distribution};
use crate::report::table::{rounded, significant};
use crate::report::{BatchReport, DistributionReport, LotReport};
use std::collections::BTreeMap;

/// Quantities whose charts are drawn.
const DRAWN: usize = 40;

/// The page of many devices; `links` leads from a device to a page of its own, where there is one.
pub fn batch_page(
    campaign: &Campaign,
    report: &BatchReport,
    summary: &Summary,
    links: &BTreeMap<String, String>,
    lang: Language,
) -> Result<Page> {
    let devices = lang.count(report.devices.all, "device");
    let mut page = Page::new(say!(lang, "title-devices-by", devices, by = report.by));
    page.language = lang;
    page.subtitle = say!(lang, "distributions-devices-that-stand-apart-and-whether").into();
    page.facts = vec![
        (say!(lang, "bench").into(), format!("`{}`", report.bench)),
        (say!(lang, "one-fit-for-each").into(), format!("`{}`", report.by)),
        (say!(lang, "estimator").into(), lang.term("estimator", &report.estimator.to_string()).into_owned()),
    ];
    page.facts.extend(report.model.iter().map(|(sensor, line)| (say!(lang, "model-of", sensor), format!("`{line}`"))));
    page.facts.extend(campaign.identity.facts(lang));
    page.colophon = colophon(&report.inputs, lang);
    page = page
        .section(answer(report, lang))
        .section(not_in_order(report, links, lang))
        .section(distributions(campaign, report, summary, lang)?)
        .section(apart(report, links, lang));
    if report.lots.len() > 1 {
        page = page.section(lots(report, lang)?);
    }
    Ok(page)
}

fn answer(report: &BatchReport, lang: Language) -> Section {
    let own = &report.devices;
    let mut section = Section::new(say!(lang, "the-answer"));
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
    section = section.list(crate::report::batch::batch_reasons(report, lang));
    let differ: Vec<&str> = report
        .quantities
        .iter()
        .filter(|q| q.scattering.as_ref().is_some_and(|s| s.significant == Some(true)))
        .map(|q| q.id.as_str())
        .collect();
    section = match differ.as_slice() {
        [] => section.prose(say!(lang, "in-no-quantity-do-devices-differ-by")),
        ids => section.prose(say!(lang, "devices-differ-by-more-than-their-readings", names = cells::names(ids, lang))),
    };
    section.prose(say!(
        lang,
        "fitted-by-the-factorisation-of-a-schedule",
        common = own.common_schedule.to_string(),
        alone = own.own_fit.to_string()
    ))
}

fn distributions(campaign: &Campaign, report: &BatchReport, summary: &Summary, lang: Language) -> Result<Section> {
    let mut table = Table::new(&[
        (say!(lang, "quantity"), Align::Left),
        (say!(lang, "devices"), Align::Right),
        (say!(lang, "mean"), Align::Decimal),
        ("sd", Align::Decimal),
        ("u", Align::Decimal),
        (say!(lang, "sd-of-devices"), Align::Decimal),
        (say!(lang, "p-if-alike"), Align::Decimal),
        (say!(lang, "least"), Align::Decimal),
        (say!(lang, "most"), Align::Decimal),
        (say!(lang, "limits"), Align::Left),
        (say!(lang, "unit"), Align::Left),
    ]);
    table.small = true;
    for q in &report.quantities {
        let (excess, p) = q.scattering.as_ref().map_or((cells::dash(), cells::dash()), |s| {
            (significant(s.sd_of_devices, 3), if s.p < 1e-4 { "<0.0001".into() } else { significant(s.p, 2) })
        });
        table.row(vec![
            format!("`{}`", q.id),
            q.devices.to_string(),
            rounded(q.mean, q.sd),
            cells::digits(q.sd, 3),
            cells::digits(q.u, 3),
            excess,
            p,
            rounded(q.least, q.sd),
            rounded(q.most, q.sd),
            limits_text(q),
            q.unit.clone(),
        ]);
    }
    table.note = say!(lang, "accepted-devices-only-sd-between-devices-u").into();
    let (mut figures, ids) = (Vec::new(), crate::report::batch_quantities(campaign));
    for q in report.quantities.iter().take(DRAWN) {
        let Some(k) = ids.iter().position(|(id, _)| *id == q.id) else { continue };
        let limits = q.limits.map(|[low, high]| [low.unwrap_or(f64::NEG_INFINITY), high.unwrap_or(f64::INFINITY)]);
        let alone = q.scattering.as_ref().map(|s| [q.median, s.u]);
        let svg = plot::distribution(
            &Distribution { label: q.id.clone(), unit: q.unit.clone(), values: summary.values(k), limits, alone },
            lang,
        )?;
        figures.push(Figure {
            svg,
            caption: say!(lang, "batch-page-over", id = q.id, devices = lang.count(q.devices, "device")),
            description: match q.limits {
                Some(_) => say!(lang, "histogram-of-curve-what-the-scatter-of", id = q.id),
                None => say!(lang, "histogram-of-curve-what-the-scatter-of-2", id = q.id),
            },
            ..Figure::default()
        });
    }
    Ok(Section::new(say!(lang, "distributions"))
        .table(table)
        .prose(say!(lang, "each-histogram-shows-the-accepted-devices-the"))
        .figures(figures))
}

fn limits_text(q: &DistributionReport) -> String {
    let bound = |bound: Option<f64>| bound.map_or(String::new(), |x| significant(x, 4));
    match q.limits {
        None => cells::dash(),
        Some([low, high]) => format!("{}\u{a0}..\u{a0}{}", bound(low), bound(high)),
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
    if listed < (report.devices.rejected + report.devices.malformed).max(fails) {
        section = section.prose(say!(lang, "the-first-devices-that-are-not-in-order", listed = listed.to_string()));
    }
    let mut columns = vec![(report.by.as_str(), Align::Left), (say!(lang, "verdict"), Align::Left)];
    if report.conformity.is_some() {
        columns.push((say!(lang, "limits"), Align::Left));
    }
    columns.push((say!(lang, "why"), Align::Left));
    let mut table = Table::new(&columns);
    table.small = true;
    for own in &report.not_in_order {
        let mut cells = vec![own.device.clone(), lang.term("verdict", own.verdict.name()).into_owned()];
        if report.conformity.is_some() {
            cells.push(own.conformity.map_or(cells::dash(), |own| lang.term("outcome", own.name()).into_owned()));
        }
        cells.push(lang.name(&own.why).into_owned());
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
            own.device.clone(),
            format!("`{}`", own.id),
            rounded(own.value, q.and_then(|q| q.u)),
            cells::decimals(Some(own.z), 1),
            q.map_or(String::new(), |q| q.unit.clone()),
        ]);
        table.link(links.get(&own.device));
    }
    table.note = say!(lang, "z-value-median-mad-beyond-what-a").into();
    section.table(table)
}

fn lots(report: &BatchReport, lang: Language) -> Result<Section> {
    let mut figures = Vec::new();
    let mut beyond: Vec<String> = Vec::new();
    for q in report.quantities.iter().take(DRAWN) {
        let Some(within) = within(&report.lots, &q.id) else { continue };
        let lots: Vec<(String, f64, f64)> = report
            .lots
            .iter()
            .filter_map(|lot| {
                let n = *lot.devices.get(&q.id)? as f64;
                Some((lot.name.clone(), *lot.mean.get(&q.id)?, 3.0 * within / n.sqrt()))
            })
            .collect();
        let out = lots.iter().filter(|(_, mean, by)| (mean - q.mean).abs() > *by).map(|(name, ..)| name.clone());
        let out: Vec<String> = out.collect();
        if !out.is_empty() {
            let more = if out.len() > 8 { ", ..." } else { "" };
            beyond.push(format!("`{}`: {}{more}", q.id, out.iter().take(8).cloned().collect::<Vec<_>>().join(", ")));
        }
        let chart = Control { label: q.id.clone(), unit: q.unit.clone(), lots, mean: q.mean };
        figures.push(Figure {
            svg: plot::control(&chart)?,
            caption: say!(lang, "by-lot", id = q.id),
            description: say!(lang, "mean-of-in-each-lot-line-mean", id = q.id),
            ..Figure::default()
        });
    }
    let mut section = Section::new(say!(lang, "control-charts"));
    section = match beyond.is_empty() {
        true => section.verdict(Tone::Good, say!(lang, "no-lot-lies-beyond-its-control-limits")),
        false => section.verdict(Tone::Caution, say!(lang, "lots-beyond-their-control-limits")).list(beyond),
    };
    Ok(section.prose(say!(lang, "points-are-means-of-lots-the-line")).figures(figures))
}

/// Standard deviation within lots, pooled; for lots of single devices from the moving range (W. A. Shewhart).
fn within(lots: &[LotReport], id: &str) -> Option<f64> {
    let (mut squares, mut dof) = (0.0, 0.0);
    for lot in lots {
        if let (Some(n), Some(Some(sd))) = (lot.devices.get(id), lot.sd.get(id)) {
            squares += sd * sd * (*n as f64 - 1.0);
            dof += *n as f64 - 1.0;
        }
    }
    if dof > 0.0 {
        return Some((squares / dof).sqrt()).filter(|sd| *sd > 0.0);
    }
    // mean of |difference| of two normal values, 2/sqrt(pi) of their sd
    let means: Vec<f64> = lots.iter().filter_map(|lot| lot.mean.get(id).copied()).collect();
    let ranges: Vec<f64> =
        means.windows(2).map(|pair| pair.iter().copied().reduce(|a, b| b - a).unwrap_or(0.0).abs()).collect();
    let mean = ranges.iter().sum::<f64>() / ranges.len().max(1) as f64;
    Some(mean * std::f64::consts::PI.sqrt() / 2.0).filter(|sd| *sd > 0.0)
}
