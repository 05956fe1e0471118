//! Many devices: the summary as stable JSON, and rows of devices as a table.

use super::Input;
use crate::batch::{Chance, Reason, Row, Summary, Verdict};
use crate::campaign::{Campaign, Decision, Limited};
use crate::document::number::rounded;
use crate::document::terminal::plain;
use crate::fit;
use crate::language::{Language, say};
use crate::report::ReportKind;
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
    pub outlying: Vec<OutlyingReport>,
    /// Devices that are not accepted or lie outside a limit, the worst first, at most 100: those without an answer, those that a test rejects
    /// (the least probable first), those outside a limit, those that their limits leave undecided.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub not_in_order: Vec<NotInOrderReport>,
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

/// Devices by what became of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct DeviceCounts {
    /// All.
    pub all: usize,
    /// Determined, and the global test passed where there is one.
    pub accepted: usize,
    /// A rank defect, a failed global test, no convergence.
    pub rejected: usize,
    /// Readings that are no readings of this campaign.
    pub malformed: usize,
    /// With suspicious readings.
    pub suspicious: usize,
    /// Fitted by the factorisation of a common schedule.
    pub common_schedule: usize,
    /// Fitted by themselves.
    pub own_fit: usize,
}

/// A test of every device.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
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
#[non_exhaustive]
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
#[non_exhaustive]
pub struct DistributionReport {
    /// Name.
    pub id: String,
    /// Unit (`rad` for tilts).
    pub unit: String,
    /// Devices that have a value.
    pub devices: usize,
    /// Mean, in `unit`.
    pub mean: f64,
    /// Standard deviation between devices, in `unit`.
    pub sd: Option<f64>,
    /// Least value, in `unit`.
    pub least: f64,
    /// Median, in `unit`.
    pub median: f64,
    /// Largest value, in `unit`.
    pub most: f64,
    /// Value below which 5 % of the devices are, in `unit`.
    pub q05: f64,
    /// Value below which 95 % of the devices are, in `unit`.
    pub q95: f64,
    /// Root mean square of the devices' standard uncertainties.
    pub u: Option<f64>,
    /// Do devices differ more than they are measured? Null without uncertainties.
    pub scattering: Option<BetweenReport>,
    /// Limits, in `unit`; null for none.
    pub limits: Option<[Option<f64>; 2]>,
}

/// Between-device scatter against the uncertainty from each device's own readings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct BetweenReport {
    /// Root mean square of the Type A standard uncertainties.
    pub u: f64,
    /// Variance between devices over that of the readings, a pure number.
    pub f: f64,
    /// Degrees of freedom of the numerator.
    pub dof: f64,
    /// Degrees of freedom of the denominator; null for infinite.
    pub u_dof: Option<f64>,
    /// Probability of a larger ratio if all devices were alike.
    pub p: f64,
    /// Do devices differ by more than their readings scatter (p below 1 %)?
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub significant: Option<bool>,
    /// Standard deviation of the devices' true values that explains the excess scatter, in the quantity's unit.
    pub sd_of_devices: f64,
}

/// An outlying device.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct OutlyingReport {
    /// The device.
    pub device: String,
    /// The quantity.
    pub id: String,
    /// Its value, in the quantity's unit.
    pub value: f64,
    /// Distance from the median in robust standard deviations, `(x - median) / (1.4826 MAD)`.
    pub z: f64,
}

/// A device that is not accepted, or outside a limit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct NotInOrderReport {
    /// The device.
    pub device: String,
    /// `rejected`, `malformed`, or `accepted` where only a limit is not kept.
    pub verdict: Verdict,
    /// The worst outcome of its limits; null without limits.
    pub conformity: Option<fit::Conformity>,
    /// What is wrong, in words; empty where only a limit is not kept.
    pub why: String,
}

/// A lot or a date.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
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
    pub fn is_beyond(&self, of: &DistributionReport) -> bool {
        self.mean.get(&of.id).zip(self.control.get(&of.id)).is_some_and(|(mean, by)| (mean - of.mean).abs() > *by)
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
        let own = campaign.limits.iter().find(|limit| match limit.of {
            Limited::Parameter(own) => own == k,
            Limited::Derived(own) => n + own == k,
            Limited::ScaleFactor(own) => names.get(k).is_some_and(|(id, _)| errors.get(own) == Some(id)),
        })?;
        Some([own.lower, own.upper].map(|bound| bound.is_finite().then_some(bound)))
    };
    let quantity = |(k, (id, unit)): (usize, &(String, String))| {
        let own = summary.quantity(k)?;
        let [least, q05, median, q95, most] = own.quantiles;
        Some(DistributionReport {
            id: id.clone(),
            unit: unit.clone(),
            devices: own.devices,
            mean: own.mean,
            sd: own.sd,
            least,
            median,
            most,
            q05,
            q95,
            u: own.u,
            scattering: own.scattering.map(|s| BetweenReport {
                u: s.u,
                f: s.f,
                dof: s.dof,
                u_dof: s.u_dof.is_finite().then_some(s.u_dof),
                p: s.p,
                significant: Some(s.is_significant()),
                sd_of_devices: s.sd_of_devices,
            }),
            limits: limits(k),
        })
    };
    let name = |k: usize| names.get(k).map_or(String::new(), |(id, _)| id.clone());
    let lots = summary.lots.iter().map(|lot| {
        let own = || lot.of.iter().enumerate().filter(|(_, (count, ..))| *count > 0);
        LotReport {
            name: lot.name.clone(),
            devices: own().map(|(k, (count, ..))| (name(k), *count)).collect(),
            mean: own().map(|(k, (_, mean, _))| (name(k), *mean)).collect(),
            sd: own().map(|(k, (n, _, s))| (name(k), (*n > 1).then(|| (s / (*n - 1) as f64).sqrt()))).collect(),
            control: BTreeMap::new(),
        }
    });
    let level = settings.level;
    let chance = |(reason, own): (Reason, &Chance)| {
        let (tested, found, expected) = (own.tested, own.found(), own.expected(level));
        (tested > 0).then(|| (reason, ChanceReport { tested, found, expected, beyond: own.beyond(level) }))
    };
    let tests = [
        (Reason::GlobalTest, &summary.global_test),
        (Reason::SuspiciousReadings, &summary.snooping),
        (Reason::LackOfFit, &summary.lack_of_fit),
    ];
    let [accepted, rejected, malformed] = summary.verdicts;
    let [pass, undecided, fail] = summary.conformity;
    BatchReport {
        tumble: env!("CARGO_PKG_VERSION").into(),
        report: ReportKind::Batch,
        inputs: Vec::new(),
        bench: campaign.bench.id.clone(),
        model: campaign.bench.sensors.iter().map(|s| (s.id.clone(), s.model.to_string())).collect(),
        estimator: settings.estimator,
        level: settings.level,
        by: by.into(),
        devices: DeviceCounts {
            all: summary.devices,
            accepted,
            rejected,
            malformed,
            suspicious: summary.suspicious,
            common_schedule: summary.solved[0],
            own_fit: summary.solved[1],
        },
        conformity: (!campaign.limits.is_empty()).then_some(ConformityCounts {
            decision: campaign.decision,
            pass,
            undecided,
            fail,
        }),
        quantities: names.iter().enumerate().filter_map(quantity).collect(),
        outlying: summary
            .outlying(MOST)
            .into_iter()
            .map(|own| OutlyingReport { device: own.label, id: name(own.quantity), value: own.value, z: own.z })
            .collect(),
        not_in_order: summary
            .not_in_order
            .iter()
            .map(|own| NotInOrderReport {
                device: own.label.clone(),
                verdict: own.verdict,
                conformity: own.conformity,
                why: own.why.clone(),
            })
            .collect(),
        reasons: summary.reasons.clone(),
        chance: tests.into_iter().filter_map(chance).collect(),
        lots: controlled(lots.collect()),
    }
}

/// Rows as a table for a terminal.
pub fn batch_rows(campaign: &Campaign, by: &str, rows: &[Row], lang: Language) -> String {
    let names = batch_quantities(campaign);
    let mut header: Vec<&str> = vec![by, say!(lang, "verdict")];
    let limited = !campaign.limits.is_empty();
    if limited {
        header.push(say!(lang, "limits"));
    }
    header.extend(names.iter().map(|(id, _)| id.as_str()));
    header.push(say!(lang, "reason"));
    let cells: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let mut cells = vec![row.label.clone(), lang.term(row.verdict.name())];
            if limited {
                cells.push(row.conformity.map_or("-".into(), |own| lang.term(own.name())));
            }
            cells.extend(row.value.iter().zip(&row.u).map(|(x, u)| match x.is_nan() {
                true => "-".into(),
                false => rounded(*x, Some(*u).filter(|u| u.is_finite())),
            }));
            let told = lang.name(&row.why);
            let mut why: String = told.chars().take(60).collect();
            if told.chars().count() > 60 {
                why += "...";
            }
            cells.push(why);
            cells
        })
        .collect();
    plain(&header, &cells)
}
