//! The page of many devices: counts, distributions, devices that stand apart, control charts.

use super::fit_page::colophon;
use super::{Align, Figure, Page, Section, Table, Tone, cells};
use crate::batch::Summary;
use crate::campaign::Campaign;
use crate::error::Result;
use crate::language::Language;
use crate::report::plot::{self, Control, Distribution};
use crate::report::table::{count, rounded, significant};
use crate::report::{BatchReport, DistributionReport, LotReport};

/// Quantities whose charts are drawn.
const DRAWN: usize = 40;

/// The page of many devices.
pub fn batch_page(campaign: &Campaign, report: &BatchReport, summary: &Summary, lang: Language) -> Result<Page> {
    let mut page = Page::new(format!("{} by {}", count(report.devices.all, "device"), report.by));
    page.subtitle =
        "Distributions, devices that stand apart, and whether devices differ more than they are measured".into();
    page.facts = vec![
        ("Bench".into(), format!("`{}`", report.bench)),
        ("One fit for each".into(), format!("`{}`", report.by)),
        ("Estimator".into(), report.estimator.to_string()),
    ];
    page.facts.extend(report.model.iter().map(|(sensor, line)| (format!("Model of {sensor}"), format!("`{line}`"))));
    page.facts.extend(campaign.identity.facts(lang));
    page.colophon = colophon(&report.inputs, lang);
    page = page.section(answer(report, lang)).section(distributions(campaign, report, summary)?).section(apart(report));
    if report.lots.len() > 1 {
        page = page.section(lots(report)?);
    }
    Ok(page)
}

fn answer(report: &BatchReport, lang: Language) -> Section {
    let own = &report.devices;
    let mut section = Section::new("The answer");
    let bad = own.rejected + own.malformed;
    section = match bad {
        0 => section.verdict(Tone::Good, format!("All {} are accepted.", count(own.all, "device"))),
        _ => section.verdict(
            Tone::Bad,
            format!(
                "{} of {} are not accepted: {} rejected (a rank defect, a failed global test, no convergence), {} whose readings are no readings of this campaign.",
                bad, count(own.all, "device"), own.rejected, own.malformed
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
            format!(
                "Conformity (rule `{}`): {} pass, {} undecided, {} fail.",
                limits.decision, limits.pass, limits.undecided, limits.fail
            ),
        );
    }
    if own.suspicious > 0 {
        section =
            section.verdict(Tone::Caution, format!("{} with suspicious readings.", count(own.suspicious, "device")));
    }
    let differ: Vec<&str> = report
        .quantities
        .iter()
        .filter(|q| q.scattering.as_ref().is_some_and(|s| s.significant == Some(true)))
        .map(|q| q.id.as_str())
        .collect();
    section = match differ.as_slice() {
        [] => section.prose("In no quantity do devices differ by more than their readings scatter."),
        ids => section.prose(format!(
            "Devices differ by more than their readings scatter (p < 0.01) in {}: the line scatters more than it is measured.",
            cells::names(ids, lang)
        )),
    };
    section.prose(format!(
        "{} fitted by the factorisation of a schedule that several devices share, {} by themselves.",
        own.common_schedule, own.own_fit
    ))
}

fn distributions(campaign: &Campaign, report: &BatchReport, summary: &Summary) -> Result<Section> {
    let mut table = Table::new(&[
        ("quantity", Align::Left),
        ("devices", Align::Right),
        ("mean", Align::Decimal),
        ("sd", Align::Decimal),
        ("u", Align::Decimal),
        ("sd of devices", Align::Decimal),
        ("p if alike", Align::Decimal),
        ("least", Align::Decimal),
        ("most", Align::Decimal),
        ("limits", Align::Left),
        ("unit", Align::Left),
    ]);
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
    table.note = "Accepted devices only. sd: between devices; u: root mean square of the devices' standard uncertainties; sd of devices: what of the sd the scatter of their own readings does not explain; p if alike: probability of such an sd if all devices were alike (F, or chi-square where uncertainties are stated).".into();
    let (mut figures, ids) = (Vec::new(), crate::report::batch_quantities(campaign));
    for q in report.quantities.iter().take(DRAWN) {
        let Some(k) = ids.iter().position(|(id, _)| *id == q.id) else { continue };
        let limits = q.limits.map(|[low, high]| [low.unwrap_or(f64::NEG_INFINITY), high.unwrap_or(f64::INFINITY)]);
        let alone = q.scattering.as_ref().map(|s| [q.median, s.u]);
        let svg = plot::distribution(&Distribution {
            label: q.id.clone(),
            unit: q.unit.clone(),
            values: summary.values(k),
            limits,
            alone,
        })?;
        figures.push(Figure {
            svg,
            caption: format!("{} over {}", q.id, count(q.devices, "device")),
            description: format!(
                "Histogram of `{}`; curve: what the scatter of each device's readings alone would leave{}.",
                q.id,
                if q.limits.is_some() { "; dashed: limits" } else { "" }
            ),
            ..Figure::default()
        });
    }
    Ok(Section::new("Distributions").table(table).prose("Each histogram shows the accepted devices; the curve is what the scatter of each device's own readings alone would leave, dashed lines are limits. Values far out are counted in the last bar.").figures(figures))
}

fn limits_text(q: &DistributionReport) -> String {
    let bound = |bound: Option<f64>| bound.map_or(String::new(), |x| significant(x, 4));
    match q.limits {
        None => cells::dash(),
        Some([low, high]) => format!("{} .. {}", bound(low), bound(high)),
    }
}

fn apart(report: &BatchReport) -> Section {
    let section = Section::new("Devices that stand apart");
    if report.outlying.is_empty() {
        return section
            .prose("No accepted device stands apart from the others at 1 % over all devices and quantities.");
    }
    let mut table = Table::new(&[
        (report.by.as_str(), Align::Left),
        ("quantity", Align::Left),
        ("value", Align::Decimal),
        ("z", Align::Decimal),
        ("unit", Align::Left),
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
    }
    table.note = "z = (value - median) / (1.4826 MAD), beyond what a normal distribution leaves at 1 % over all devices and quantities; the farthest first, at most 50. A single report: `tumble fit` with the readings of that device.".into();
    section.table(table)
}

fn lots(report: &BatchReport) -> Result<Section> {
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
            caption: format!("{} by lot", q.id),
            description: format!("Mean of `{}` in each lot; line: mean of all devices; dashed: three standard deviations of a lot's mean, from the scatter within lots; triangles lie beyond.", q.id),
            ..Figure::default()
        });
    }
    let mut section = Section::new("Control charts");
    section = match beyond.is_empty() {
        true => section.verdict(Tone::Good, "No lot lies beyond its control limits."),
        false => section.verdict(Tone::Caution, "Lots beyond their control limits:").list(beyond),
    };
    Ok(section
        .prose("Points are means of lots, the line is the mean of all devices, dashed lines are three standard deviations of a lot's mean from the scatter within lots; triangles lie beyond.")
        .figures(figures))
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
