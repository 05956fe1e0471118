//! All devices together: how each quantity is distributed, who stands apart, and whether devices differ more than they are measured.

use super::{Row, Solved, Verdict};
use crate::elements::Elements;
use crate::fit::Conformity;
use crate::number;
use crate::uncertainty::quantiles;
use std::collections::HashMap;

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
    /// Devices.
    pub devices: usize,
    /// Devices by verdict: accepted, rejected, malformed.
    pub verdicts: [usize; 3],
    /// Devices by conformity: pass, undecided, fail; all zero without limits.
    pub conformity: [usize; 3],
    /// Devices fitted by a common schedule, by themselves, not at all.
    pub solved: [usize; 3],
    /// Devices with suspicious readings, and with a lack of fit below one minus the level.
    pub suspicious: usize,
    /// Lots in the order in which they were met.
    pub lots: Vec<Lot>,
    /// Devices that are not accepted or lie outside a limit, in the order in which they were met; at most 100.
    pub not_in_order: Vec<NotInOrder>,
    lot_of: HashMap<String, usize>,
    quantities: usize,
    labels: Vec<Box<str>>,
    /// Values, Type A uncertainties and combined uncertainties, one device after the other.
    values: Vec<[f64; 3]>,
    /// Degrees of freedom of each device's own scale; infinite where uncertainties are stated.
    dofs: Vec<f64>,
}

/// A device that is not accepted, or outside a limit.
#[derive(Debug, Clone, PartialEq)]
pub struct NotInOrder {
    /// The device.
    pub label: String,
    /// Is its answer usable?
    pub verdict: Verdict,
    /// The worst outcome of its limits.
    pub conformity: Option<Conformity>,
    /// What is wrong, in words.
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

/// A quantity over the accepted devices.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// Devices that have a value.
    pub devices: usize,
    /// Mean.
    pub mean: f64,
    /// Standard deviation between devices; `None` for one.
    pub sd: Option<f64>,
    /// Least, 5 %, half, 95 %, most.
    pub quantiles: [f64; 5],
    /// Root mean square of the combined standard uncertainties; `None` where none is known.
    pub u: Option<f64>,
    /// Do devices differ more than they are measured? `None` without uncertainties.
    pub scattering: Option<Scattering>,
}

/// Between-device scatter against the uncertainty from each device's own readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scattering {
    /// Root mean square of the Type A standard uncertainties.
    pub u: f64,
    /// Variance between devices over that of the readings.
    pub f: f64,
    /// Degrees of freedom of the numerator: devices less one.
    pub dof: f64,
    /// Degrees of freedom of the denominator; infinite where uncertainties are stated.
    pub u_dof: f64,
    /// Probability of a larger ratio if all devices were alike.
    pub p: f64,
    /// Standard deviation of the devices' true values that explains the rest, `sqrt(sd^2 - u^2)`; 0 where nothing is left.
    pub sd_of_devices: f64,
}

impl Scattering {
    /// Do devices differ by more than their readings scatter: is so large a ratio less probable than 1 %?
    pub fn is_significant(&self) -> bool {
        self.p < 0.01
    }
}

/// A device that stands apart.
#[derive(Debug, Clone, PartialEq)]
pub struct OutlyingDevice {
    /// The device.
    pub label: String,
    /// The quantity, by its index.
    pub quantity: usize,
    /// Its value.
    pub value: f64,
    /// Distance from the median in robust standard deviations.
    pub z: f64,
}

impl Summary {
    /// No device yet.
    pub fn new(quantities: usize) -> Self {
        Summary { quantities, ..Summary::default() }
    }

    /// One more device.
    pub fn add(&mut self, row: &Row) {
        self.devices += 1;
        let verdict = match row.verdict {
            Verdict::Accepted => &mut self.verdicts[0],
            Verdict::Rejected => &mut self.verdicts[1],
            Verdict::Malformed => &mut self.verdicts[2],
        };
        *verdict += 1;
        let solved = match row.solved {
            Solved::Together => &mut self.solved[0],
            Solved::Alone => &mut self.solved[1],
            Solved::Not => &mut self.solved[2],
        };
        *solved += 1;
        match row.conformity {
            Some(Conformity::Pass) => self.conformity[0] += 1,
            Some(Conformity::Undecided) => self.conformity[1] += 1,
            Some(Conformity::Fail) => self.conformity[2] += 1,
            None => {}
        }
        self.suspicious += usize::from(!row.suspects.is_empty());
        let in_order = row.verdict == Verdict::Accepted && matches!(row.conformity, None | Some(Conformity::Pass));
        if !in_order && self.not_in_order.len() < LISTED {
            let (verdict, conformity) = (row.verdict, row.conformity);
            self.not_in_order.push(NotInOrder { label: row.label.clone(), verdict, conformity, why: row.why.clone() });
        }
        if row.verdict != Verdict::Accepted {
            return;
        }
        if !row.lot.is_empty() {
            self.add_to_lot(row);
        }
        if self.labels.len() < KEPT {
            self.labels.push(row.label.as_str().into());
            let at = |list: &[f64], k: usize| list.at(k);
            let own = (0..self.quantities).map(|k| [at(&row.value, k), at(&row.type_a, k), at(&row.u, k)]);
            self.values.extend(own);
            self.dofs.push(if row.chi_square_p.is_nan() { row.dof as f64 } else { f64::INFINITY });
        }
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
    fn column(&self, quantity: usize) -> impl Iterator<Item = (usize, [f64; 3])> + '_ {
        let rows = self.values.chunks_exact(self.quantities.max(1)).enumerate();
        rows.filter_map(move |(k, row)| row.get(quantity).map(|own| (k, *own))).filter(|(_, own)| own[0].is_finite())
    }

    /// The values of a quantity, for a figure.
    pub fn values(&self, quantity: usize) -> Vec<f64> {
        self.column(quantity).map(|(_, [x, ..])| x).collect()
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
        let (first, last) = (at(0)?, at(n - 1)?);
        let share = |share: f64| number::count((share * (n - 1) as f64).round());
        let quantiles = [first, at(share(0.05))?, at(share(0.5))?, at(share(0.95))?, last];
        let mean = first + values.iter().map(|x| x - first).sum::<f64>() / n as f64;
        let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
        let variance = (n > 1).then(|| squares / (n - 1) as f64);
        let rms = |which: fn([f64; 3]) -> f64| {
            let own: Vec<f64> = self.column(quantity).map(|(_, own)| which(own)).filter(|u| u.is_finite()).collect();
            (!own.is_empty()).then(|| (own.iter().map(|u| u * u).sum::<f64>() / own.len() as f64).sqrt())
        };
        let u_dof: f64 = self.column(quantity).filter_map(|(k, _)| self.dofs.get(k)).sum();
        let scattering = variance.zip(rms(|own| own[1]).filter(|u| *u > 0.0)).and_then(|(variance, u)| {
            let (f, dof) = (variance / (u * u), (n - 1) as f64);
            let p = match u_dof.is_finite() {
                true => quantiles::fisher_f_survival(f, dof, u_dof),
                false => quantiles::chi_square_survival(f * dof, dof),
            }?;
            Some(Scattering { u, f, dof, u_dof, p, sd_of_devices: (variance - u * u).max(0.0).sqrt() })
        });
        Some(Quantity { devices: n, mean, sd: variance.map(f64::sqrt), quantiles, u: rms(|own| own[2]), scattering })
    }

    /// Devices that stand apart from the others in some quantity, at 1 % over all devices and quantities, the farthest first.
    ///
    /// `z = (x - median) / (1.4826 MAD)`, two-sided normal (B. Iglewicz, D. Hoaglin, How to Detect and Handle Outliers (1993), 3.3).
    pub fn outlying(&self, most: usize) -> Vec<OutlyingDevice> {
        let mut found = Vec::new();
        let all = (self.values.len() as f64).max(1.0);
        // no devices: no limit is drawn
        let far = quantiles::normal_quantile(1.0 - 0.005 / all).unwrap_or(6.0);
        for quantity in 0..self.quantities {
            let mut values = self.values(quantity);
            if values.len() < 8 {
                continue;
            }
            let median = middle(&mut values);
            let mut distances: Vec<f64> = values.iter().map(|x| (x - median).abs()).collect();
            let spread = NORMAL_MAD * middle(&mut distances);
            if !(spread > 0.0) {
                continue;
            }
            for (k, [value, ..]) in self.column(quantity) {
                let z = (value - median) / spread;
                if z.abs() > far {
                    let label = self.labels.get(k).map_or(String::new(), ToString::to_string);
                    found.push(OutlyingDevice { label, quantity, value, z });
                }
            }
        }
        found.sort_by(|a, b| b.z.abs().total_cmp(&a.z.abs()));
        found.truncate(most);
        found
    }
}

/// The median; the list is put in another order.
fn middle(values: &mut [f64]) -> f64 {
    let (half, is_odd) = (values.len() / 2, values.len() % 2 == 1);
    if values.is_empty() {
        return f64::NAN;
    }
    let (below, own, _) = values.select_nth_unstable_by(half, f64::total_cmp);
    let own = *own;
    if is_odd {
        return own;
    }
    let before = below.iter().copied().max_by(f64::total_cmp).unwrap_or(own);
    (before + own) / 2.0
}
