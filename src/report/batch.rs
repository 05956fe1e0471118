//! Many devices: the summary as stable JSON, its document, and rows of devices as a table.

use super::fit_document::model_facts;
use super::provenance::begin;
use super::{Input, ReportKind, VERSION, finite};
use crate::batch::{
    Chance, DeviceCounts, NoisyDevice, NotInOrder, OutlyingDevice, Quantity, Reason, Row, Scattering, Summary,
};
use crate::campaign::{Campaign, Decision, Limited};
use crate::document::chart::{Chart, Control, Distribution};
use crate::document::number::{level, rounded, significant};
use crate::document::terminal::alone;
use crate::document::{Cell, Detail, Document, Figure, Rows, Section, Tone};
use crate::fit;
use crate::language::{Language, code, say};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Outlying devices that a report lists.
const MOST: usize = 50;

/// What a table of many devices comes to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct BatchReport {
    /// Version of the program that wrote it.
    pub tumble: String,
    /// Always `batch`.
    #[schemars(extend("const" = "batch"))]
    pub report: ReportKind,
    /// Files that it was made from, with digests.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inputs: Vec<Input>,
    /// The bench.
    pub bench: String,
    /// Model line of each sensor.
    pub model: BTreeMap<String, String>,
    /// `exact` or `linear`.
    pub estimator: fit::Estimator,
    /// Coverage probability of expanded uncertainties.
    pub level: f64,
    /// The column that identifies the device; `file` if each file is a device.
    pub by: String,
    /// Devices, and how many of them are what.
    pub devices: DeviceCounts,
    /// Conformity with the limits; null without limits.
    pub conformity: Option<ConformityCounts>,
    /// Every estimated parameter and derived quantity over the accepted devices.
    pub quantities: Vec<DistributionReport>,
    /// Outlying devices, the farthest first, at most 50.
    pub outlying: Vec<OutlyingDevice>,
    /// Accepted devices whose residuals scatter more than those of the others (1 % over all devices), the noisiest first, at most 50.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub noisy: Vec<NoisyDevice>,
    /// Devices that are not accepted or lie outside a limit, the worst first, at most 100: those without an answer, those that a test rejects
    /// (the least probable first), those outside a limit, those that their limits leave undecided.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub not_in_order: Vec<NotInOrder>,
    /// Devices by what is wrong with them, or suspicious; a device may have several reasons.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub reasons: BTreeMap<Reason, usize>,
    /// For each test of the devices, by the reason that it gives, what chance alone finds.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub chance: BTreeMap<Reason, ChanceReport>,
    /// Lots or dates in the order in which they were met; empty where no column has them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lots: Vec<LotReport>,
}

/// A test of every device.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChanceReport {
    /// Devices that could be tested.
    pub tested: usize,
    /// Devices in which it found something.
    pub found: usize,
    /// In how many it finds something by chance alone, a pure number: one minus the level, times those tested.
    pub expected: f64,
    /// In how many it finds something at the level over all devices together.
    pub beyond: usize,
}

/// Devices by conformity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ConformityCounts {
    /// `simple`, `guard-u` or `risk`.
    pub decision: Decision,
    /// Inside every limit.
    pub pass: usize,
    /// Left open by the uncertainty.
    pub undecided: usize,
    /// Outside some limit.
    pub fail: usize,
}

/// A quantity over the accepted devices, in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DistributionReport {
    /// Name.
    pub id: String,
    /// Unit (`rad` for tilts).
    pub unit: String,
    /// How it is distributed.
    #[serde(flatten)]
    pub of: Quantity,
    /// Limits, in `unit`; null for none.
    pub limits: Option<[Option<f64>; 2]>,
}

/// A lot or a date.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LotReport {
    /// Its name.
    pub name: String,
    /// Accepted devices, for each quantity that some device has.
    pub devices: BTreeMap<String, usize>,
    /// Mean of each quantity.
    pub mean: BTreeMap<String, f64>,
    /// Standard deviation of each quantity within the lot; null for one device.
    pub sd: BTreeMap<String, Option<f64>>,
    /// Control limits of the lot's mean, as their distance from the mean of all devices: three standard deviations of a mean of so many devices,
    /// from the scatter within lots (lots of one device: from the moving range), in the quantity's unit.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub control: BTreeMap<String, f64>,
}

impl LotReport {
    /// Does the lot's mean of a quantity lie beyond its control limits?
    pub(crate) fn is_beyond(&self, of: &DistributionReport) -> bool {
        self.mean.get(&of.id).zip(self.control.get(&of.id)).is_some_and(|(mean, by)| (mean - of.of.mean).abs() > *by)
    }
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

/// Control limits for each lot, where there are several.
fn controlled(mut lots: Vec<LotReport>) -> Vec<LotReport> {
    if lots.len() < 2 {
        return lots;
    }
    let ids: std::collections::BTreeSet<String> = lots.iter().flat_map(|lot| lot.mean.keys().cloned()).collect();
    for id in ids {
        let Some(sd) = within(&lots, &id) else { continue };
        for lot in &mut lots {
            if let Some(n) = lot.devices.get(&id) {
                lot.control.insert(id.clone(), 3.0 * sd / (*n as f64).sqrt());
            }
        }
    }
    lots
}

/// Names and units of what a row has: estimated parameters, then derived quantities.
pub fn batch_quantities(campaign: &Campaign) -> Vec<(String, String)> {
    let parameters = campaign.estimated().iter().map(|p| (p.id.clone(), p.unit.clone()));
    let derived = campaign.derived.iter().map(|d| (d.id.clone(), d.unit.clone()));
    let errors = campaign.limited_errors().into_iter().map(|id| (id, "ppm".to_string()));
    parameters.chain(derived).chain(errors).collect()
}

/// The summary of many devices.
pub fn batch_report(campaign: &Campaign, settings: &fit::Settings, by: &str, summary: &Summary) -> BatchReport {
    let names = batch_quantities(campaign);
    let n = campaign.unknowns();
    let errors = campaign.scale_factor_errors();
    let limits = |k: usize| {
        let bound = campaign.limits.iter().find(|limit| match limit.of {
            Limited::Parameter(i) => i == k,
            Limited::Derived(i) => n + i == k,
            Limited::ScaleFactor(i) => names.get(k).is_some_and(|(id, _)| errors.get(i) == Some(id)),
        })?;
        Some([bound.lower, bound.upper].map(finite))
    };
    let quantity = |(k, (id, unit)): (usize, &(String, String))| {
        let of = summary.quantity(k)?;
        Some(DistributionReport { id: id.clone(), unit: unit.clone(), of, limits: limits(k) })
    };
    let name = |k: usize| names.get(k).map_or(String::new(), |(id, _)| id.clone());
    let lots = summary.lots.iter().map(|lot| {
        let counted = || lot.of.iter().enumerate().filter(|(_, (count, ..))| *count > 0);
        LotReport {
            name: lot.name.clone(),
            devices: counted().map(|(k, (count, ..))| (name(k), *count)).collect(),
            mean: counted().map(|(k, (_, mean, _))| (name(k), *mean)).collect(),
            sd: counted().map(|(k, (n, _, s))| (name(k), (*n > 1).then(|| (s / (*n - 1) as f64).sqrt()))).collect(),
            control: BTreeMap::new(),
        }
    });
    let level = settings.level;
    let chance = |(reason, counts): (Reason, &Chance)| {
        let (tested, found, expected) = (counts.tested, counts.found(), counts.expected(level));
        (tested > 0).then(|| (reason, ChanceReport { tested, found, expected, beyond: counts.beyond(level) }))
    };
    let tests = [
        (Reason::GlobalTest, &summary.global_test),
        (Reason::SuspiciousReadings, &summary.snooping),
        (Reason::LackOfFit, &summary.lack_of_fit),
    ];
    let [pass, undecided, fail] = summary.conformity;
    BatchReport {
        tumble: VERSION.into(),
        report: ReportKind::Batch,
        inputs: Vec::new(),
        bench: campaign.bench.id.clone(),
        model: super::model_lines(campaign),
        estimator: settings.estimator,
        level: settings.level,
        by: by.into(),
        devices: summary.devices.clone(),
        conformity: (!campaign.limits.is_empty()).then_some(ConformityCounts {
            decision: campaign.decision,
            pass,
            undecided,
            fail,
        }),
        quantities: names.iter().enumerate().filter_map(quantity).collect(),
        outlying: summary.outlying(MOST, &name),
        noisy: summary.noisy(MOST),
        not_in_order: summary.not_in_order.clone(),
        reasons: summary.reasons.clone(),
        chance: tests.into_iter().filter_map(chance).collect(),
        lots: controlled(lots.collect()),
    }
}

/// Letters of a reason that a table has: the file of rows has all.
const LETTERS: usize = 60;

/// Rows as a table for a terminal.
pub fn batch_rows(campaign: &Campaign, by: &str, rows: &[Row], lang: Language) -> String {
    let mut table =
        Rows::of(rows).name(by, |row| &row.label).left(say!(lang, "verdict"), |row| lang.term(row.verdict.name()));
    if !campaign.limits.is_empty() {
        table = table.left(say!(lang, "limits"), |row| row.conformity.map(|outcome| lang.term(outcome.name())));
    }
    for (k, (id, _)) in batch_quantities(campaign).iter().enumerate() {
        let finite = |list: &[f64]| list.get(k).copied().filter(|x| x.is_finite());
        table = table.right(id, |row| Cell::value(finite(&row.value), finite(&row.u)));
    }
    let reason = |row: &Row| {
        let why = lang.name(&row.why);
        let short: String = why.chars().take(LETTERS).collect();
        if short.len() < why.len() { short + "..." } else { short }
    };
    alone(table.left(say!(lang, "reason"), reason), lang)
}

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
    begin(say!(lang, "grouped-by", what = devices, by = report.by), &report.inputs, lang)
        .fact(say!(lang, "bench"), code(&report.bench))
        .fact(say!(lang, "estimator"), lang.term(&report.estimator.to_string()))
        .facts(model_facts(&report.model, lang))
        .facts(fitted.map(|(campaign, _)| campaign.identity.facts(lang)).unwrap_or_default())
        .section(answer(report, lang))
        .section(reasons(report, lang))
        .section(not_in_order(report, links, lang))
        .section(distributions(report, fitted, lang))
        .section(apart(report, links, lang))
        .section(lots(report, lang))
}

fn answer(report: &BatchReport, lang: Language) -> Section {
    let counts = &report.devices;
    let devices = lang.count(counts.all, "device");
    let accepted = match counts.rejected + counts.malformed {
        0 => (Tone::Good, say!(lang, "all-are-accepted", devices)),
        bad => {
            let [rejected, malformed] = [counts.rejected, counts.malformed].map(|n| n.to_string());
            (Tone::Bad, say!(lang, "of-are-not-accepted-rejected-a-rank", bad, devices, rejected, malformed))
        }
    };
    let noisy = (!report.noisy.is_empty()).then(|| {
        let names = lang.names(report.noisy.iter().map(|device| device.label.as_str()));
        (Tone::Caution, say!(lang, "accepted-devices-are-noisy", names, n = report.noisy.len()))
    });
    let conformity = report.conformity.as_ref().map(|limits| {
        let tone = match (limits.fail, limits.undecided) {
            (0, 0) => Tone::Good,
            (0, _) => Tone::Caution,
            _ => Tone::Bad,
        };
        let [pass, undecided, fail] = [limits.pass, limits.undecided, limits.fail].map(|n| n.to_string());
        let decision = limits.decision.to_string();
        (tone, say!(lang, "conformity-rule-pass-undecided-fail", decision, pass, undecided, fail))
    });
    let differs = |q: &&DistributionReport| q.of.scattering.as_ref().is_some_and(|s| s.significant == Some(true));
    let names = lang.names(report.quantities.iter().filter(differs).map(|q| q.id.as_str()));
    Section::new(say!(lang, "result")).verdicts([accepted]).verdicts(noisy).verdicts(conformity).prose(say!(
        lang,
        "devices-differ-by-more-than-their-readings",
        names
    ))
}

/// Devices by reason, and what chance alone finds; no section where no device has a reason.
fn reasons(report: &BatchReport, lang: Language) -> Section {
    let rows = report.reasons.iter().map(|(reason, devices)| (reason, *devices, report.chance.get(reason)));
    let table = Rows::of(rows)
        .left(say!(lang, "reason"), |(reason, ..)| lang.term(reason.name()))
        .right(say!(lang, "devices"), |(_, devices, _)| devices)
        .right(say!(lang, "devices-tested"), |(.., chance)| chance.map(|tests| tests.tested))
        .decimal(say!(lang, "expected-by-chance"), |(.., chance)| Cell::digits(chance.map(|tests| tests.expected), 2))
        .right(say!(lang, "beyond-chance"), |(.., chance)| chance.map(|tests| tests.beyond))
        .tone(|(.., chance)| if chance.is_some_and(|tests| tests.beyond > 0) { Tone::Caution } else { Tone::Plain })
        .note(say!(lang, "chance-alone-finds", level = level(report.level)));
    Section::new(say!(lang, "reasons")).table(table)
}

fn distributions(report: &BatchReport, fitted: Option<(&Campaign, &Summary)>, lang: Language) -> Section {
    let between = |q: &DistributionReport, of: fn(&Scattering) -> f64| q.of.scattering.as_ref().map(of);
    let bound = |bound: Option<f64>| bound.map_or(String::new(), |x| significant(x, 4));
    let table = Rows::of(&report.quantities)
        .name(say!(lang, "quantity"), |q| &q.id)
        .right(say!(lang, "devices"), |q| q.of.devices)
        .at(Detail::Roomy)
        .decimal(say!(lang, "mean"), |q| Cell::Value(q.of.mean, q.of.sd))
        .decimal(say!(lang, "observed-sd"), |q| Cell::digits(q.of.sd, 3))
        .decimal("u", |q| Cell::digits(q.of.u, 3))
        .decimal(say!(lang, "sd-of-devices"), |q| Cell::digits(between(q, |s| s.sd_of_devices), 3))
        .right(say!(lang, "p-if-alike"), |q| Cell::p(between(q, |s| s.p)))
        .decimal(say!(lang, "min"), |q| Cell::Value(q.of.least, q.of.sd))
        .at(Detail::Full)
        .decimal(say!(lang, "max"), |q| Cell::Value(q.of.most, q.of.sd))
        .at(Detail::Full)
        .left(say!(lang, "limits"), |q| q.limits.map(|[a, b]| format!("{}\u{a0}..\u{a0}{}", bound(a), bound(b))))
        .at(Detail::Roomy)
        .left(say!(lang, "unit"), |q| &q.unit)
        .small()
        .note(say!(lang, "accepted-devices-only-sd-between-devices-u"));
    let ids = fitted.map(|(campaign, _)| batch_quantities(campaign)).unwrap_or_default();
    let figure = |q: &DistributionReport| {
        let (_, summary) = fitted?;
        let values = summary.values(ids.iter().position(|(id, _)| *id == q.id)?);
        let limits = q.limits.map(|[low, high]| [low.unwrap_or(f64::NEG_INFINITY), high.unwrap_or(f64::INFINITY)]);
        let alone = q.of.scattering.as_ref().map(|s| [q.of.median, s.u]);
        let chart = Distribution { label: q.id.clone(), unit: q.unit.clone(), values, limits, alone };
        let caption = format!("{}{}{}", q.id, lang.colon(), lang.count(q.of.devices, "device"));
        Some(Figure::new(caption, Chart::Distribution(chart), false))
    };
    let figures: Vec<Figure> = report.quantities.iter().take(DRAWN).filter_map(figure).collect();
    let how = if figures.is_empty() { "" } else { say!(lang, "each-histogram-shows-the-accepted-devices-the") };
    Section::new(say!(lang, "distributions")).table(table).full().prose(how).figures(figures)
}

/// Devices that are not accepted or outside a limit; no section where there is none.
fn not_in_order(report: &BatchReport, links: &BTreeMap<String, String>, lang: Language) -> Section {
    let section = Section::new(say!(lang, "devices-that-are-not-in-order"));
    let listed = report.not_in_order.len();
    if listed == 0 {
        return section;
    }
    let fails = report.conformity.as_ref().map_or(0, |conformity| conformity.fail);
    let all = (report.devices.rejected + report.devices.malformed).max(fails);
    let [shown, n] = [listed, all].map(|n| n.to_string());
    let first = (listed < all).then(|| say!(lang, "the-first-of-are-listed-the-json", listed = shown, n));
    let mut table = Rows::of(&report.not_in_order)
        .left(report.by.as_str(), |device| &device.label)
        .left(say!(lang, "verdict"), |device| lang.term(device.verdict.name()));
    if report.conformity.is_some() {
        table = table.left(say!(lang, "limits"), |device| device.conformity.map(|outcome| lang.term(outcome.name())));
    }
    let table = table.left(say!(lang, "reason"), |d| lang.name(&d.why)).link(|d| links.get(&d.label));
    section.proses(first).table(table.small())
}

fn apart(report: &BatchReport, links: &BTreeMap<String, String>, lang: Language) -> Section {
    let noisy = Rows::of(&report.noisy)
        .left(report.by.as_str(), |device| &device.label)
        .decimal(say!(lang, "residual-sd"), |device| Cell::digits(Some(device.residual_sd), 3))
        .decimal(say!(lang, "sd-of-the-others"), |device| Cell::digits(Some(device.pooled_sd), 3))
        .decimal("F", |device| Cell::digits(Some(device.f), 3))
        .right("p", |device| Cell::p(Some(device.p)))
        .link(|device| links.get(&device.label))
        .note(say!(lang, "noisy-devices-f"));
    let section = Section::new(say!(lang, "devices-that-stand-apart")).table(noisy);
    if report.outlying.is_empty() {
        return section.prose(say!(lang, "no-accepted-device-stands-apart-from-the"));
    }
    let rows = report.outlying.iter().map(|outlier| (outlier, report.quantities.iter().find(|q| q.id == outlier.id)));
    let table = Rows::of(rows)
        .left(report.by.as_str(), |(outlier, _)| &outlier.label)
        .name(say!(lang, "quantity"), |(outlier, _)| &outlier.id)
        .decimal(say!(lang, "value"), |(outlier, q)| Cell::Value(outlier.value, q.and_then(|q| q.of.u)))
        .decimal("z", |(outlier, _)| Cell::Decimals(outlier.z, 1))
        .left(say!(lang, "unit"), |(_, q)| q.map_or("", |q| q.unit.as_str()))
        .link(|(outlier, _)| links.get(&outlier.label))
        .note(say!(lang, "z-value-median-mad-beyond-what-a"));
    section.table(table)
}

/// Control charts: means of lots against their limits; no section where there are no limits.
fn lots(report: &BatchReport, lang: Language) -> Section {
    let section = Section::new(say!(lang, "control-charts"));
    let (mut figures, mut beyond) = (Vec::new(), Vec::new());
    let limited = |q: &&DistributionReport| report.lots.iter().any(|lot| lot.control.contains_key(&q.id));
    for q in report.quantities.iter().filter(limited).take(DRAWN) {
        let limits = |lot: &'_ LotReport| Some((*lot.mean.get(&q.id)?, *lot.control.get(&q.id)?));
        let judged = || report.lots.iter().filter_map(|lot| Some((lot, limits(lot)?)));
        beyond.extend(judged().filter(|(lot, _)| lot.is_beyond(q)).map(|(lot, (mean, by))| (q, lot, mean, by)));
        let lots = judged().map(|(lot, (mean, by))| (lot.name.clone(), mean, by)).collect();
        let caption = say!(lang, "grouped-by", what = q.id, by = say!(lang, "lot"));
        let control = Control { label: q.id.clone(), unit: q.unit.clone(), lots, mean: q.of.mean };
        figures.push(Figure::new(caption, Chart::Control(control), false));
    }
    if figures.is_empty() {
        return section;
    }
    let (tone, lots) = match beyond.len() {
        0 => (Tone::Good, say!(lang, "none").to_string()),
        n => (Tone::Caution, n.to_string()),
    };
    let table = Rows::of(beyond)
        .name(say!(lang, "quantity"), |(q, ..)| &q.id)
        .left(say!(lang, "lot"), |(_, lot, ..)| &lot.name)
        .right(say!(lang, "devices"), |(q, lot, ..)| lot.devices.get(&q.id).copied().unwrap_or_default())
        .decimal(say!(lang, "mean"), |(.., mean, by)| Cell::Value(mean, Some(by)))
        .left(say!(lang, "control-limits"), |(q, .., by)| {
            let [low, high] = [q.of.mean - by, q.of.mean + by].map(|limit| rounded(limit, Some(by)));
            format!("{low} .. {high}")
        })
        .left(say!(lang, "unit"), |(q, ..)| &q.unit);
    section
        .verdict(tone, say!(lang, "lots-beyond-their-control-limits", lots))
        .table(table)
        .full()
        .prose(say!(lang, "points-are-means-of-lots-the-line"))
        .figures(figures)
}
