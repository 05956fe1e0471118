//! All devices together: how each quantity is distributed, who stands apart, and whether devices differ more than they are measured.

use super::{Reason, Row, Solved, Verdict};
use crate::elements::Elements;
use crate::fit::Conformity;
use crate::number;
use crate::uncertainty::quantiles;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Devices whose values are kept for distributions; of further ones only the counts.
const KEPT: usize = 1 << 20;
/// Devices that are listed as not in order.
const LISTED: usize = 100;
/// Lots that are kept apart.
const LOTS: usize = 2000;
/// Standard deviation of a normal distribution over its median absolute deviation.
const NORMAL_MAD: f64 = 1.482_602_218_505_602;

/// What many rows come to.
#[derive(Debug, Clone, Default)]
pub struct Summary {
    /// Devices, and how many of them are what.
    pub devices: DeviceCounts,
    /// Devices by conformity: pass, undecided, fail; all zero without limits.
    pub conformity: [usize; 3],
    /// Lots in the order in which they were met.
    pub lots: Vec<Lot>,
    /// Devices that are not accepted or lie outside a limit, the worst first, at most 100: those without an answer, then those that a test
    /// rejects by its probability, then those outside a limit, then those that their limits leave undecided.
    pub not_in_order: Vec<NotInOrder>,
    /// Devices by what is wrong with them, or suspicious.
    pub reasons: BTreeMap<Reason, usize>,
    /// The global test over the devices.
    pub global_test: Chance,
    /// The search for suspicious readings over the devices.
    pub snooping: Chance,
    /// The test for lack of fit over the devices.
    pub lack_of_fit: Chance,
    lot_of: HashMap<String, usize>,
    quantities: usize,
    /// How bad each device is that is not in order.
    badness: Vec<(u8, f64, f64)>,
    /// Labels one after the other, and where each ends.
    labels: String,
    ends: Vec<usize>,
    /// Values, one device after the other, and the Type A parts of their standard uncertainties.
    values: Vec<f64>,
    type_a: Vec<f64>,
    /// Residual variance and degrees of freedom of each of these devices; none where its uncertainties are stated, which its global test compares.
    scatters: Vec<Option<(f64, f64)>>,
    /// What is summed for each quantity.
    sums: Vec<Sums>,
}

/// Devices by what became of them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DeviceCounts {
    /// All.
    pub all: usize,
    /// Determined, and the global test passed where there is one.
    pub accepted: usize,
    /// A rank defect, a failed global test, lack of fit, no convergence.
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

/// A test of every device: at a level of 95 % chance alone finds something in one of twenty.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Chance {
    /// Devices that could be tested.
    pub tested: usize,
    /// Probabilities of those in which something was found.
    found: Vec<f64>,
}

impl Chance {
    fn add(&mut self, p: f64, found: bool) {
        self.tested += 1;
        if found {
            self.found.push(p);
        }
    }

    /// Devices in which something was found.
    pub(crate) fn found(&self) -> usize {
        self.found.len()
    }

    /// In how many chance alone finds something.
    pub fn expected(&self, level: f64) -> f64 {
        (1.0 - level) * self.tested as f64
    }

    /// In how many something is found at the level over all devices together (Z. Sidak 1967).
    pub(crate) fn beyond(&self, level: f64) -> usize {
        let single = -(level.ln() / self.tested.max(1) as f64).exp_m1();
        self.found.iter().filter(|p| **p < single).count()
    }
}

/// Sums over the accepted devices that have a value of a quantity.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    /// Squares of combined standard uncertainties, and how many are known.
    u: (f64, usize),
    /// Degrees of freedom of the devices' own scales; infinite where uncertainties are stated.
    dof: f64,
}

/// The root of a mean of squares; `None` of none.
fn rms((squares, count): (f64, usize)) -> Option<f64> {
    (count > 0).then(|| (squares / count as f64).sqrt())
}

/// A device that is not accepted, or outside a limit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "NotInOrderReport")]
pub struct NotInOrder {
    /// The device.
    #[serde(rename = "device")]
    pub label: String,
    /// `rejected`, `malformed`, or `accepted` where only a limit is not kept.
    pub verdict: Verdict,
    /// The worst outcome of its limits; null without limits.
    pub conformity: Option<Conformity>,
    /// What is wrong, in words; empty where only a limit is not kept.
    pub why: String,
}

/// Devices of one lot or date: for each quantity how many, their mean and sum of squares about it.
#[derive(Debug, Clone, PartialEq)]
pub struct Lot {
    /// Its name.
    pub name: String,
    /// For each quantity.
    pub of: Vec<(usize, f64, f64)>,
}

/// A quantity over the accepted devices, in its unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Quantity {
    /// Devices that have a value.
    pub devices: usize,
    /// Mean of the devices that do not stand apart (`outlying`), in `unit`.
    pub mean: f64,
    /// Standard deviation between them, in `unit`.
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
    /// Do the devices that do not stand apart differ more than they are measured? Null without uncertainties.
    pub scattering: Option<Scattering>,
}

/// Between-device scatter against the uncertainty from each device's own readings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "BetweenReport")]
pub struct Scattering {
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
#[schemars(rename = "OutlyingReport")]
pub struct OutlyingDevice {
    /// The device.
    #[serde(rename = "device")]
    pub label: String,
    /// The quantity.
    pub id: String,
    /// Its value, in the quantity's unit.
    pub value: f64,
    /// Distance from the median in robust standard deviations, `(x - median) / (1.4826 MAD)`.
    pub z: f64,
}

/// An accepted device whose residuals scatter more than those of the others.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "NoisyDeviceReport")]
pub struct NoisyDevice {
    /// The device.
    #[serde(rename = "device")]
    pub label: String,
    /// Its residual standard deviation, in the sensor's unit.
    pub residual_sd: f64,
    /// That of the devices with no more scatter, pooled, in the sensor's unit.
    pub pooled_sd: f64,
    /// The variance of the one over that of the others, a pure number.
    pub f: f64,
    /// Degrees of freedom of the device.
    pub dof: f64,
    /// Degrees of freedom of the others.
    pub pooled_dof: f64,
    /// Probability of a larger ratio by chance, for this device alone.
    pub p: f64,
}

/// Probability of any outlier over all devices and quantities where there is none.
const OUTLYING: f64 = 0.01;

impl Summary {
    /// No device yet.
    pub fn new(quantities: usize) -> Self {
        Summary { quantities, sums: vec![Sums::default(); quantities], ..Summary::default() }
    }

    /// One more device.
    pub fn add(&mut self, row: &Row) {
        let devices = &mut self.devices;
        devices.all += 1;
        match row.verdict {
            Verdict::Accepted => devices.accepted += 1,
            Verdict::Rejected => devices.rejected += 1,
            Verdict::Malformed => devices.malformed += 1,
        }
        match row.solved {
            Solved::Together => devices.common_schedule += 1,
            Solved::Alone => devices.own_fit += 1,
            Solved::Not => {}
        }
        devices.suspicious += usize::from(!row.suspects.is_empty());
        match row.conformity {
            Some(Conformity::Pass) => self.conformity[0] += 1,
            Some(Conformity::Undecided) => self.conformity[1] += 1,
            Some(Conformity::Fail) => self.conformity[2] += 1,
            None => {}
        }
        row.reasons.iter().for_each(|reason| *self.reasons.entry(*reason).or_default() += 1);
        let has = |reason: Reason| row.reasons.contains(&reason);
        let is_stated = !row.chi_square_p.is_nan();
        if is_stated {
            self.global_test.add(row.chi_square_p, has(Reason::GlobalTest));
        }
        if row.dof > usize::from(!is_stated) {
            self.snooping.add(row.suspect_p, !row.suspects.is_empty());
        }
        if !row.lack_of_fit_p.is_nan() {
            self.lack_of_fit.add(row.lack_of_fit_p, has(Reason::LackOfFit));
        }
        let in_order = row.verdict == Verdict::Accepted && matches!(row.conformity, None | Some(Conformity::Pass));
        if !in_order {
            self.add_not_in_order(row);
        }
        if row.verdict != Verdict::Accepted {
            return;
        }
        if !row.lot.is_empty() {
            self.add_to_lot(row);
        }
        if self.ends.len() < KEPT {
            self.labels.push_str(&row.label);
            self.ends.push(self.labels.len());
            let dof = if is_stated { f64::INFINITY } else { row.dof as f64 };
            let variance = row.residual_sd * row.residual_sd;
            self.scatters.push((!is_stated && variance.is_finite()).then_some((variance, dof)));
            for (k, sums) in self.sums.iter_mut().enumerate() {
                let value = row.value.at(k);
                self.values.push(value);
                self.type_a.push(row.type_a.get(k).copied().unwrap_or(f64::NAN));
                if value.is_finite() {
                    sums.dof += dof;
                    if let Some(u) = row.u.get(k).filter(|u| u.is_finite()) {
                        sums.u.0 += u * u;
                        sums.u.1 += 1;
                    }
                }
            }
        }
    }

    fn add_not_in_order(&mut self, row: &Row) {
        // no number: nothing was tested
        let p = row.chi_square_p.min(row.lack_of_fit_p);
        let has_answer = !row.reasons.iter().any(|reason| {
            matches!(reason, Reason::NotEstimable | Reason::Stuck | Reason::NoConvergence | Reason::Constraints)
        });
        let badness = match (row.verdict, row.conformity) {
            (Verdict::Malformed, _) => (0, 0.0, 0.0),
            (Verdict::Rejected, _) if !has_answer => (1, 0.0, 0.0),
            (Verdict::Rejected, _) => (2, p, -row.residual_sd),
            (Verdict::Accepted, Some(Conformity::Fail)) => (3, 0.0, 0.0),
            (Verdict::Accepted, _) => (4, 0.0, 0.0),
        };
        let milder = |other: &(u8, f64, f64)| {
            other.0.cmp(&badness.0).then(other.1.total_cmp(&badness.1)).then(other.2.total_cmp(&badness.2)).is_le()
        };
        let place = self.badness.partition_point(milder);
        if place >= LISTED {
            return;
        }
        let (verdict, conformity) = (row.verdict, row.conformity);
        let entry = NotInOrder { label: row.label.clone(), verdict, conformity, why: row.why.clone() };
        self.badness.insert(place, badness);
        self.not_in_order.insert(place, entry);
        self.badness.truncate(LISTED);
        self.not_in_order.truncate(LISTED);
    }

    fn add_to_lot(&mut self, row: &Row) {
        let next = self.lots.len();
        let k = match self.lot_of.get(&row.lot) {
            Some(k) => *k,
            None if next >= LOTS => return,
            None => {
                self.lots.push(Lot { name: row.lot.clone(), of: vec![(0, 0.0, 0.0); self.quantities] });
                self.lot_of.insert(row.lot.clone(), next);
                next
            }
        };
        let Some(lot) = self.lots.get_mut(k) else { return };
        for ((count, mean, squares), x) in lot.of.iter_mut().zip(&row.value).filter(|(_, x)| x.is_finite()) {
            // B. P. Welford 1962
            *count += 1;
            let before = x - *mean;
            *mean += before / *count as f64;
            *squares += before * (x - *mean);
        }
    }

    /// Values of a quantity over the accepted devices, with the index of each device.
    fn column(&self, quantity: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let rows = self.values.chunks_exact(self.quantities.max(1)).enumerate();
        rows.filter_map(move |(k, row)| row.get(quantity).map(|value| (k, *value)))
            .filter(|(_, value)| value.is_finite())
    }

    /// The values of a quantity, for a figure.
    pub(crate) fn values(&self, quantity: usize) -> Vec<f64> {
        self.column(quantity).map(|(_, x)| x).collect()
    }

    /// The label of a device by its index.
    fn label(&self, k: usize) -> String {
        let start = k.checked_sub(1).and_then(|before| self.ends.get(before)).copied().unwrap_or(0);
        let label = self.ends.get(k).and_then(|end| self.labels.get(start..*end));
        label.unwrap_or_default().to_string()
    }

    /// A quantity over the accepted devices; `None` where no device has one.
    pub fn quantity(&self, quantity: usize) -> Option<Quantity> {
        let mut values = self.values(quantity);
        let n = values.len();
        // in ascending order a quantile's value stands at its place; the rest may stand anywhere
        let mut at = |place: usize| {
            let inside = place.min(n.saturating_sub(1));
            values.get(inside)?;
            Some(*values.select_nth_unstable_by(inside, f64::total_cmp).1)
        };
        let (least, most) = (at(0)?, at(n - 1)?);
        let share = |share: f64| number::count((share * (n - 1) as f64).round());
        let [q05, median, q95] = [at(share(0.05))?, at(share(0.5))?, at(share(0.95))?];
        // mean and scatter are those of the devices that do not stand apart
        let apart: HashSet<usize> = self.outlying_in(quantity).into_iter().map(|(k, ..)| k).collect();
        let alike: Vec<(usize, f64)> = self.column(quantity).filter(|(k, _)| !apart.contains(k)).collect();
        let count = alike.len();
        let mean = least + alike.iter().map(|(_, x)| x - least).sum::<f64>() / count as f64;
        let squares: f64 = alike.iter().map(|(_, x)| (x - mean) * (x - mean)).sum();
        let variance = (count > 1).then(|| squares / (count - 1) as f64);
        let sums = self.sums.get(quantity).copied().unwrap_or_default();
        // infinite where uncertainties are stated
        let u_dof = Some(sums.dof).filter(|dof| dof.is_finite());
        let known = alike.iter().filter_map(|(k, _)| self.type_a.get(k * self.quantities + quantity));
        let type_a = known.filter(|u| u.is_finite()).fold((0.0, 0), |(squares, n), u| (squares + u * u, n + 1));
        let scattering = variance.zip(rms(type_a).filter(|u| *u > 0.0)).and_then(|(variance, u)| {
            let (f, dof) = (variance / (u * u), (count - 1) as f64);
            let p = match u_dof {
                Some(u_dof) => quantiles::fisher_f_survival(f, dof, u_dof),
                None => quantiles::chi_square_survival(f * dof, dof),
            }?;
            let (significant, sd_of_devices) = (Some(p < 0.01), (variance - u * u).max(0.0).sqrt());
            Some(Scattering { u, f, dof, u_dof, p, significant, sd_of_devices })
        });
        let (sd, u) = (variance.map(f64::sqrt), rms(sums.u));
        Some(Quantity { devices: n, mean, sd, least, median, most, q05, q95, u, scattering })
    }

    /// Devices that are outliers in some quantity of these names, at 1 % over all devices and quantities, the farthest first.
    pub(crate) fn outlying(&self, most: usize, name: &dyn Fn(usize) -> String) -> Vec<OutlyingDevice> {
        let of = |quantity: usize| {
            let named = move |(k, value, z)| OutlyingDevice { label: self.label(k), id: name(quantity), value, z };
            self.outlying_in(quantity).into_iter().map(named)
        };
        let mut found: Vec<OutlyingDevice> = (0..self.quantities).flat_map(of).collect();
        found.sort_by(|a, b| b.z.abs().total_cmp(&a.z.abs()));
        found.truncate(most);
        found
    }

    /// Those of one quantity: index, value, `z = (x - median) / (1.4826 MAD)` (B. Iglewicz, D. Hoaglin, How to Detect and Handle Outliers (1993), 3.3).
    ///
    /// Of the `m` nearest to the median the farthest is compared with their mean and standard deviation, `R = |x - mean| / s`, at the level `a` of Grubbs' test,
    /// and all from the first significant one on are outliers (B. Rosner, Technometrics 25 (1983) 165), one half of the devices at most:
    ///
    /// ```text
    /// R > (m - 1) t / sqrt(m (m - 2 + t^2)),   t = t(1 - a/2m, m - 2)
    /// ```
    fn outlying_in(&self, quantity: usize) -> Vec<(usize, f64, f64)> {
        /// No limit of so many values is below 3 (3.75 at 1 %), so that few of a million are compared with theirs.
        const MANY: usize = 100;
        let mut values = self.values(quantity);
        let median = middle(&mut values);
        let mut placed: Vec<(usize, f64)> = self.column(quantity).collect();
        placed.sort_by(|(_, a), (_, b)| (a - median).abs().total_cmp(&(b - median).abs()));
        let mut distances: Vec<f64> = values.iter().map(|x| (x - median).abs()).collect();
        let spread = NORMAL_MAD * middle(&mut distances);
        if !(spread > 0.0) {
            return Vec::new();
        }
        let level = OUTLYING / self.quantities.max(1) as f64;
        let is_far = |count: usize, r: f64| {
            let m = count as f64;
            let t = quantiles::student_t_quantile(1.0 - 0.5 * level / m, m - 2.0);
            t.is_some_and(|t| r > (m - 1.0) * t / (m * (m - 2.0 + t * t)).sqrt())
        };
        let (mut mean, mut squares, mut first) = (0.0, 0.0, placed.len());
        for (k, (_, value)) in placed.iter().enumerate() {
            // B. P. Welford 1962
            let before = value - mean;
            mean += before / (k + 1) as f64;
            squares += before * (value - mean);
            let r = (value - mean).abs() / (squares / k as f64).sqrt();
            if k >= placed.len() / 2 && k > 1 && (k < MANY || r > 3.0) && is_far(k + 1, r) {
                first = k;
                break;
            }
        }
        placed.into_iter().skip(first).map(|(k, value)| (k, value, (value - median) / spread)).collect()
    }

    /// Devices whose residuals scatter more than those of the others, at 1 % over all devices, the noisiest first.
    ///
    /// `F = s^2 / (pooled s^2 of the devices with less)`, which for two like devices and more is W. G. Cochran's test of the largest variance (ISO 5725-2, 7.3.3) in
    /// another form. Devices are taken from the noisiest on, one half of them at most, each at 1 % over those that are left; all down to the last that is
    /// significant are noisy, so that several do not hide each other (B. Rosner, Technometrics 25 (1983) 165). Of like devices 1 to 2 % of the families have one
    /// that is noisy by chance (drawn for 2 to 300 devices with 1 to 18 degrees of freedom each; 2 % with one degree of freedom).
    pub fn noisy(&self, most: usize) -> Vec<NoisyDevice> {
        let scatters = self.scatters.iter().enumerate();
        let mut all: Vec<(usize, f64, f64)> =
            scatters.filter_map(|(k, scatter)| scatter.map(|(s, dof)| (k, s, dof))).collect();
        let median = middle(&mut all.iter().map(|(_, variance, _)| *variance).collect::<Vec<f64>>());
        if !(median > 0.0) {
            return Vec::new();
        }
        all.sort_by(|(_, a, m), (_, b, n)| deviate(a / median, *m).total_cmp(&deviate(b / median, *n)));
        let least = all.len().div_ceil(2);
        let mut below = (0.0, 0.0);
        let mut found = Vec::new();
        for (place, (k, variance, dof)) in all.iter().enumerate() {
            if place >= least {
                let (squares, pooled_dof) = below;
                let pooled = squares / pooled_dof;
                let f = variance / pooled;
                let single = OUTLYING / (place + 1) as f64;
                let p = if f > 1.0 { quantiles::fisher_f_survival(f, *dof, pooled_dof) } else { None };
                if let Some(p) = p.filter(|p| *p < single) {
                    let (residual_sd, pooled_sd, dof) = (variance.sqrt(), pooled.sqrt(), *dof);
                    found.push(NoisyDevice { label: self.label(*k), residual_sd, pooled_sd, f, dof, pooled_dof, p });
                }
                // those that scatter more than a noisy one are compared with the same others
                if !found.is_empty() {
                    continue;
                }
            }
            below = (below.0 + variance * dof, below.1 + dof);
        }
        found.reverse();
        found.truncate(most);
        found
    }
}

/// The normal deviate of a variance over that of the others, nearly (E. B. Wilson, M. M. Hilferty 1931): it puts devices with unequal degrees of freedom in order.
fn deviate(ratio: f64, dof: f64) -> f64 {
    let variance = 2.0 / (9.0 * dof);
    (ratio.cbrt() - 1.0 + variance) / variance.sqrt()
}

/// The median; the list is put in another order.
fn middle(values: &mut [f64]) -> f64 {
    let (half, is_odd) = (values.len() / 2, values.len() % 2 == 1);
    if values.is_empty() {
        return f64::NAN;
    }
    let (below, middle, _) = values.select_nth_unstable_by(half, f64::total_cmp);
    let middle = *middle;
    if is_odd {
        return middle;
    }
    let before = below.iter().copied().max_by(f64::total_cmp).unwrap_or(middle);
    (before + middle) / 2.0
}
