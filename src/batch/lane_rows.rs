//! Devices of different schedules: which of them can go side by side, their rows of the design from the columns of the table, and which of these
//! are replicates: rows whose lines find the same inputs.
#![allow(
    clippy::indexing_slicing,
    reason = "`fill` gives every list the size of the form before it is written, and a `Lane` has `LANES` numbers; a row's inputs are as wide as said"
)]

use super::answer::Asked;
use super::block::LANES;
use super::common::{ILL, alone, is_plain};
use super::device::bits;
use super::residuals::{Sizes, Tests};
use super::{Device, Layout, Use};
use crate::campaign::Campaign;
use crate::design::{Model, Together, Workspace};
use crate::elements::OrNan;
use crate::estimate::eight::Eight;
use crate::fit::{self, Estimator, Settings, Weighting};
use crate::mix::{Mix, Numbers};
use std::hash::Hasher;

/// Most readings of a device, and most sensors, that go this way.
const MOST_ROWS: usize = 2048;
const MOST_SENSORS: usize = 4;

/// What devices of different schedules share: the question, and where in a device's cells its lines find their inputs.
#[derive(Debug)]
pub(super) struct Lanes {
    pub(super) asked: Asked,
    model: Model,
    /// For each sensor of the layout, in the order of a device's values.
    pub(super) lines: Vec<SensorLine>,
    /// Their indices in the bench.
    pub(super) sensors: Vec<usize>,
    /// Cells of inputs in a row.
    pub(super) width: usize,
    /// The cell of the number of samples.
    samples: Option<usize>,
    /// Is the model not linear in its unknowns, so that rows follow the point?
    pub(super) is_exact: bool,
}

/// A sensor's line.
#[derive(Debug)]
pub(super) struct SensorLine {
    sensor: usize,
    /// The columns that it follows, each with its cell; none where rows follow the point, and are predicted elsewhere.
    columns: Vec<(usize, usize)>,
    /// The cell of its stated uncertainty.
    u: Option<usize>,
    /// Is its value a reference, and no reading?
    pub(super) is_reference: bool,
}

/// How many readings of which sensors, with or without stated uncertainties: devices that agree in it go side by side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Form {
    counts: [u16; MOST_SENSORS],
    pub(super) scaled: bool,
}

/// Room for the inputs and outputs of lines.
#[derive(Debug, Default)]
pub(super) struct Places {
    inputs: Vec<f64>,
    values: Vec<f64>,
    work: Workspace,
    room: Together,
}

impl Form {
    /// Readings of all sensors.
    pub(super) fn readings(&self) -> usize {
        self.counts.iter().map(|n| usize::from(*n)).sum()
    }

    /// For each sensor of the layout, where its rows begin and how many they are.
    pub(super) fn parts(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.counts.iter().scan(0, |next, count| {
            let (begin, count) = (*next, usize::from(*count));
            *next += count;
            Some((begin, count))
        })
    }

    /// Does one sensor have all rows?
    pub(super) fn is_of_one(&self) -> bool {
        self.counts.iter().filter(|n| **n > 0).count() == 1
    }
}

impl Lanes {
    /// The way of a table's devices, from the campaign of one; `None` where none of them can go it.
    ///
    /// That is: a question that needs more than one linear step, priors, uncertain inputs, lines of rates, forces or joints.
    pub(super) fn new(campaign: &Campaign, layout: &Layout, settings: &Settings) -> Option<Lanes> {
        let bench = &campaign.bench;
        let is_exact = settings.estimator == Estimator::Exact && !campaign.is_linear();
        let simple = alone(campaign, settings).is_ok()
            && (settings.estimator == Estimator::Exact || is_plain(campaign, settings))
            && campaign.uncertain().next().is_none()
            && settings.adjust.rank_tolerance.is_none_or(|t| t * ILL < 1.0)
            && fit::check_level(settings.level).is_ok()
            && campaign.unknowns() > 0
            && campaign.priors().next().is_none()
            && layout.uses.iter().all(|kind| *kind != Use::Other)
            && layout.sensors().count() <= MOST_SENSORS
            && campaign.readings.columns == layout.numeric(bench);
        if !simple {
            return None;
        }
        let asked = Asked::new(campaign, settings).ok()?;
        let campaign = &asked.campaign;
        fit::check_ranges(campaign).ok()?;
        let model = Model::new(campaign).ok()?;
        let inputs: Vec<&str> = layout
            .keys
            .iter()
            .zip(&layout.uses)
            .filter(|(_, kind)| **kind == Use::Input)
            .map(|(key, _)| key.as_str())
            .collect();
        let cell = |key: &str| inputs.iter().position(|input| *input == key);
        let has_joints = bench.joints().next().is_some();
        if has_joints && !is_exact {
            return None;
        }
        let line = |sensor: usize| {
            let own = bench.sensors.get(sensor)?;
            let (u, is_reference) = (cell(&format!("{}_u", own.id)), own.is_reference());
            let followed = if is_exact { Vec::new() } else { model.columns_alone(sensor)? };
            let column = |k: usize| Some((k, cell(campaign.readings.columns.get(k)?)?));
            let columns = followed.into_iter().map(column).collect::<Option<_>>()?;
            Some(SensorLine { sensor, columns, u, is_reference })
        };
        let lines = layout.sensors().map(line).collect::<Option<_>>()?;
        let (width, samples) = (inputs.len(), cell("n"));
        let sensors = layout.sensors().collect();
        Some(Lanes { lines, sensors, width, samples, is_exact, model, asked })
    }

    /// The shape of a device; `None` for one that its own fit has to answer, or to refuse.
    pub(super) fn form_of(&self, device: &Device) -> Option<Form> {
        if !device.is_plain() || device.inputs.iter().any(|x| x.abs() > fit::MOST) {
            return None;
        }
        let (mut counts, mut stated) = ([0_u16; MOST_SENSORS], [None; MOST_SENSORS]);
        for row in 0..device.rows {
            let (inputs, values) = (device.input(row, self.width), device.value(row, self.lines.len()));
            if inputs.len() != self.width || self.samples.is_some_and(|k| inputs[k] <= 0.0) {
                return None;
            }
            let sensors = self.lines.iter().zip(values).zip(counts.iter_mut().zip(&mut stated));
            for ((line, value), (count, stated)) in sensors {
                let u = line.u.map_or(f64::NAN, |k| inputs[k]);
                if value.is_nan() {
                    continue;
                }
                let has_u = !u.is_nan();
                if line.columns.iter().any(|(_, k)| inputs[*k].is_nan()) || stated.is_some_and(|before| before != has_u)
                {
                    return None;
                }
                // what is no uncertainty at all is refused in words elsewhere
                if has_u && !(u >= fit::LEAST) {
                    return None;
                }
                *stated = Some(has_u);
                *count = count.checked_add(1)?;
            }
        }
        let relative = self.asked.settings.weighting == Weighting::Relative;
        let mut read = stated.iter().flatten();
        let scaled = match (read.next(), read.next()) {
            (None, _) => return None,
            (Some(stated), None) => relative || !stated,
            _ if relative || stated.contains(&Some(false)) => return None,
            _ => false,
        };
        let form = Form { counts, scaled };
        (form.readings() > self.asked.campaign.unknowns() && form.readings() <= MOST_ROWS).then_some(form)
    }

    /// What the tests of a shape's devices share.
    pub(super) fn tests(&self, form: &Form) -> Tests {
        let m = form.readings();
        Tests::new(m, m, (m.saturating_sub(self.asked.campaign.unknowns()), form.scaled, self.asked.settings.level))
    }

    /// Eight devices of a shape into a system each (where there are fewer, the last one again), and what is known of their sizes; `None` for a
    /// device whose numbers its own fit has to look at.
    pub(super) fn fill(
        &self,
        form: &Form,
        devices: &[&Device],
        eight: &mut Eight,
        places: &mut Places,
    ) -> [Option<Sizes>; LANES] {
        let (m, n) = (form.readings(), self.asked.campaign.unknowns());
        let mut sizes = [Sizes::NONE; LANES];
        eight.shape(m, n);
        for (slot, (line, (begin, count))) in self.lines.iter().zip(form.parts()).enumerate() {
            let places_here = count * LANES;
            let Places { inputs, values, work, room } = &mut *places;
            inputs.resize((line.columns.len() * places_here).max(inputs.len()), 0.0);
            for ((_, k), list) in line.columns.iter().zip(inputs.chunks_exact_mut(places_here.max(1))) {
                for l in 0..LANES {
                    let Some(device) = devices.get(l).or(devices.last()) else { continue };
                    let to = list.iter_mut().skip(l).step_by(LANES);
                    let read = device.read(slot, self.lines.len());
                    to.zip(read).for_each(|(to, (row, _))| *to = device.inputs.or_nan(row * self.width + k));
                }
            }
            // rows that follow the point are predicted elsewhere
            values.clear();
            values.resize(places_here, 0.0);
            (0..n).for_each(|j| eight.rows[j * m + begin..j * m + begin + count].fill([0.0; LANES]));
            if !self.is_exact {
                let lists = line.columns.iter().zip(inputs.chunks_exact(places_here.max(1)));
                let lists: Vec<(usize, &[f64])> = lists.map(|((column, _), list)| (*column, list)).collect();
                let (bench, point) = (&self.asked.campaign.bench, &self.asked.reference);
                let asked = (lists.as_slice(), places_here);
                self.model.predict_lists(bench, line.sensor, asked, point, (work, room), |start, own, slopes| {
                    let here = start..start + own.len();
                    values[here.clone()].copy_from_slice(own);
                    for (j, slope) in slopes.iter().enumerate().take(n) {
                        let column = eight.rows[j * m + begin..j * m + begin + count].as_flattened_mut();
                        column[here.clone()].copy_from_slice(&slope[..own.len()]);
                    }
                });
            }
            for l in 0..LANES {
                let Some(device) = devices.get(l).or(devices.last()) else { continue };
                let read = device.read(slot, self.lines.len()).map(|(row, value)| {
                    let cell = |k: usize| device.inputs.get(row * self.width + k).copied();
                    let u = match line.u.and_then(cell).filter(|u| !u.is_nan()) {
                        Some(u) => u,
                        // no count: one sample, as the format says
                        None => 1.0 / self.samples.and_then(cell).filter(|n| !n.is_nan()).unwrap_or(1.0).sqrt(),
                    };
                    (value, u)
                });
                let rows = eight.observed[begin..].iter_mut().zip(&mut eight.weight[begin..]);
                let predicted = values.iter().skip(l).step_by(LANES);
                for (((observed, weight), (value, u)), predicted) in rows.zip(read).zip(predicted) {
                    (observed[l], weight[l]) = (value - predicted, 1.0 / u);
                    sizes[l].take(value, weight[l]);
                }
            }
        }
        sizes.map(|own| own.are_plain().then_some(own))
    }
}

/// The cell of each row of one device: rows of one cell have the same inputs.
#[derive(Debug, Default)]
pub(super) struct Parted {
    /// Cell of each row.
    pub(super) of: Vec<usize>,
    /// By a row (and sensor) of each cell.
    numbers: Numbers<(usize, usize)>,
}

impl Lanes {
    /// Part a device's rows, in the order of the system's, by their inputs; how many cells there are.
    pub(super) fn cells(&self, device: &Device, Parted { of, numbers }: &mut Parted) -> usize {
        of.clear();
        numbers.clear();
        for (slot, line) in self.lines.iter().enumerate() {
            let at = |row: usize, k: usize| device.inputs.get(row * self.width + k).copied().map_or(0, bits);
            let used = || line.columns.iter().map(|(_, k)| *k);
            for (row, _) in device.read(slot, self.lines.len()) {
                let mut hash = Mix(slot as u64);
                used().for_each(|k| hash.write_u64(at(row, k)));
                let is_alike = |(first, kind)| kind == slot && used().all(|k| at(row, k) == at(first, k));
                of.push(numbers.of(hash.finish(), (row, slot), is_alike).0);
            }
        }
        numbers.len()
    }

    /// The rows of a device's system in the order of its readings: the reading (from 0) and the row.
    pub(super) fn order(&self, device: &Device) -> Vec<(usize, usize)> {
        let sensors = self.lines.len();
        let rows = (0..sensors).flat_map(|slot| device.read(slot, sensors));
        let mut order: Vec<(usize, usize)> = rows.enumerate().map(|(row, (reading, _))| (reading, row)).collect();
        order.sort_unstable();
        order
    }
}
