//! Devices of one schedule whose model is not linear in its unknowns: Gauss-Newton for eight of them side by side, each at a point of its own.
//!
//! The steps are those of [`crate::fit`] as long as each of them is taken whole and the fit becomes better; whatever else a device asks for (a rank
//! defect, a step that must be halved) is for its own fit.
#![allow(
    clippy::indexing_slicing,
    reason = "a `Lane` has `LANES` numbers, and lists of eight systems have the lengths that `Eight::shape` gives them"
)]

use super::block::{LANES, Lane};
use super::common::ILL;
use super::lane_rows::{Form, Lanes, Placed};
use super::lanes::Room;
use super::residuals::Tests;
use super::{Device, Row};
use crate::campaign::{Campaign, Kind};
use crate::design::{self, Model, RowOrigin, Workspace};
use crate::elements::Elements;
use crate::fit::{self, INVISIBLE, NEGLIGIBLE};
use pulp::Arch;
use std::f64::consts::PI;

/// Steps after which a device is for its own fit.
const STEPS: usize = 12;

/// A schedule of several devices, whose rows follow the point.
pub(super) struct Exact {
    campaign: Campaign,
    model: Model,
    /// For each reading, its sensors and their rows among those of a device's system.
    readings: Vec<(usize, Vec<usize>, Vec<usize>)>,
    /// The cell of each row, and how many cells there are.
    cells: (Vec<usize>, usize),
}

impl Exact {
    /// The schedule of a device's campaign; `None` for one that a fit refuses. `sensors` are those of the layout, in its order.
    pub(super) fn new(campaign: Campaign, sensors: &[usize]) -> Option<Exact> {
        fit::askable(&campaign).ok()?;
        let model = Model::new(&campaign).ok()?;
        let design = design::assemble(&campaign, &model, &campaign.reference_point()).ok()?;
        fit::check_rows(&campaign, &model, &design).ok()?;
        // devices that do not begin at the reference are for their own fits
        if fit::by_coefficients(&campaign, &model, &design, &fit::Settings::default()).ok()?.is_some() {
            return None;
        }
        // rows of a system stand sensor by sensor
        let slot = |row: &usize| design.rows.get(*row).and_then(|row| sensors.iter().position(|s| *s == row.sensor));
        let mut order: Vec<usize> = (0..design.rows.len()).collect();
        order.sort_by_key(slot);
        let mut place = vec![0; order.len()];
        for (row, k) in order.iter().enumerate() {
            place[*k] = row;
        }
        let cells = fit::cells(&campaign, &design, design.rows.len());
        let count = cells.iter().max().map_or(0, |most| most + 1);
        let cells = (order.iter().map(|k| cells.at(*k)).collect(), count);
        let of_reading = |rows: &[(usize, &RowOrigin)]| {
            let reading = rows.first().map_or(0, |(_, row)| row.reading);
            let sensors = rows.iter().map(|(_, row)| row.sensor).collect();
            (reading, sensors, rows.iter().map(|(k, _)| place[*k]).collect())
        };
        let rows: Vec<(usize, &RowOrigin)> = design.rows.iter().enumerate().collect();
        let readings = rows.chunk_by(|a, b| a.1.reading == b.1.reading).map(of_reading).collect();
        Some(Exact { campaign, model, readings, cells })
    }

    /// Rows and predictions at a point of each device; `columns` gets derivatives by the unknowns, `m` of them for each.
    fn at(
        &self,
        point: &[Lane],
        (m, n): (usize, usize),
        columns: &mut [Lane],
        predicted: &mut [Lane],
        (work, room): (&mut Workspace, &mut design::Room<LANES>),
    ) {
        for (reading, sensors, rows) in &self.readings {
            let Some(reading) = self.campaign.readings.rows.get(*reading) else { continue };
            self.model.predict_lanes(
                &self.campaign,
                reading,
                sensors,
                point,
                (work, room),
                |place, value, gradient| {
                    let row = rows[place];
                    predicted[row] = *value;
                    for (j, slope) in gradient.iter().take(n).enumerate() {
                        columns[j * m + row] = *slope;
                    }
                },
            );
        }
    }
}

impl Lanes {
    /// A row for each device of one schedule; `None` for one that its own fit has to answer.
    pub(super) fn rows_exactly(
        &self,
        arch: Arch,
        (form, tests): (&Form, &Tests),
        exact: &Exact,
        devices: &[&Device],
        room: &mut Room,
    ) -> Vec<Option<Row>> {
        let (m, n) = (form.readings(), self.campaign.unknowns());
        let is_tilt: Vec<bool> =
            self.campaign.estimated().iter().map(|parameter| parameter.kind == Kind::Tilt).collect();
        let (mut work, mut places) = (exact.model.workspace(), design::Room::default());
        let mut predicted = vec![[0.0; LANES]; m];
        let reference: Vec<Lane> = self.reference.iter().map(|x| [*x; LANES]).collect();
        // all devices begin at one point
        let mut begin: Option<(Vec<Lane>, Vec<Lane>)> = None;
        let mut found = Vec::with_capacity(devices.len());
        for devices in devices.chunks(LANES) {
            let placed: Vec<Placed<'_>> = devices.iter().map(|device| (*device, &[] as &[u32])).collect();
            let sizes = self.fill(arch, (form, None), &placed, &mut room.eight, &mut room.places);
            let values = room.eight.observed.clone();
            let mut point = reference.clone();
            let (mut settled, mut failed, mut last) = ([false; LANES], [false; LANES], [f64::INFINITY; LANES]);
            for _ in 0..STEPS {
                let eight = &mut room.eight;
                match &begin {
                    Some((columns, values)) if last == [f64::INFINITY; LANES] => {
                        eight.rows.copy_from_slice(columns);
                        predicted.copy_from_slice(values);
                    }
                    _ => exact.at(&point, (m, n), &mut eight.rows, &mut predicted, (&mut work, &mut places)),
                }
                begin.get_or_insert_with(|| (eight.rows.clone(), predicted.clone()));
                for ((observed, value), predicted) in eight.observed.iter_mut().zip(&values).zip(&predicted) {
                    *observed = std::array::from_fn(|l| value[l] - predicted[l]);
                }
                eight.solve(arch, true);
                let mut sums = [[0.0; LANES]; 4];
                let rows = eight.observed.iter().zip(&eight.residuals).zip(&eight.weight).zip(&predicted);
                for (((y, v), w), f) in rows {
                    for l in 0..LANES {
                        let terms = [y[l], y[l] - v[l], v[l], y[l].abs() + f[l].abs()];
                        sums.iter_mut().zip(terms).for_each(|(sum, term)| sum[l] += (term * w[l]).powi(2));
                    }
                }
                let [before, length, noise, size] = sums;
                for l in 0..LANES {
                    let better = before[l] <= last[l] * (1.0 + 1e-10) + NEGLIGIBLE * NEGLIGIBLE * size[l];
                    failed[l] |= !(better && eight.condition[l] < ILL && length[l].is_finite());
                    settled[l] = length[l].sqrt() <= NEGLIGIBLE * size[l].sqrt()
                        || length[l].sqrt() <= INVISIBLE * noise[l].sqrt();
                }
                last = before;
                if settled.iter().zip(&failed).all(|(settled, failed)| *settled || *failed) {
                    break;
                }
                for ((x, dx), is_tilt) in point.iter_mut().zip(&eight.solution).zip(&is_tilt) {
                    for l in 0..LANES {
                        if settled[l] || failed[l] {
                            continue;
                        }
                        x[l] += dx[l];
                        // a turn away lies the same rotation
                        failed[l] |= *is_tilt && !(x[l].abs() <= PI);
                    }
                }
            }
            self.judge(arch, tests, room);
            found.extend(placed.iter().zip(sizes).enumerate().map(|(l, (device, sizes))| {
                let sizes = sizes.filter(|_| settled[l] && !failed[l])?;
                let reference: Vec<f64> = point.iter().map(|x| x[l]).collect();
                self.row((form, tests), (None, Some(&exact.cells)), &reference, *device, (l, sizes), room)
            }));
        }
        found
    }
}
