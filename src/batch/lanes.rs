//! Devices of different schedules, eight side by side: a system for each, solved together, and each device's row from its own; and devices of one
//! schedule whose lines follow the point, each at a point of its own.
//!
//! What is not far from a rank defect, or checked by no other reading, is for the fit of that device by itself.
#![allow(
    clippy::indexing_slicing,
    reason = "a `Lane` has `LANES` numbers, and devices are put into lanes by remainders by that; lists of eight systems have the lengths that `Eight::shape` gives them"
)]

use super::answer::{Answer, Coverage, Question};
use super::block::{LANES, Lane, Sums, lane};
use super::common::ILL;
use super::lane_rows::{Form, Lanes, Parted, Places};
use super::residuals::{Cells, Sizes, Tests, least_runs_p, suspects};
use super::{Device, Row, Solved};
use crate::campaign::{Campaign, Kind};
use crate::design::{self, Model, RowOrigin, Workspace};
use crate::elements::Elements;
use crate::estimate::eight::Eight;
use crate::fit::{self, INVISIBLE, NEGLIGIBLE};
use crate::quality::{Offsets, Whitened};
use faer::Mat;
use pulp::{Arch, Simd, WithSimd};
use std::f64::consts::PI;

/// A reading whose redundancy is less is checked by none: that is for the device's own fit to say.
const CHECKED: f64 = 1e-6;

/// Room to work in.
#[derive(Debug, Default)]
pub(super) struct Room {
    pub(super) eight: Eight,
    pub(super) places: Places,
    judged: Judged,
    parted: Parted,
    cells: Cells,
    memory: Coverage,
    cofactor: Option<Mat<f64>>,
    dx: Vec<f64>,
    v: Vec<f64>,
}

/// Tests of eight devices.
#[derive(Debug, Default)]
struct Judged {
    gain: Vec<Lane>,
    studentized: Vec<Lane>,
    least_redundancy: Lane,
    sums: Option<Sums>,
    normality: Lane,
}

impl Lanes {
    /// A row for each device of a shape; `None` for one that its own fit has to answer.
    pub(super) fn rows(
        &self,
        arch: Arch,
        (form, tests): (&Form, &Tests),
        devices: &[&Device],
        room: &mut Room,
    ) -> Vec<Option<Row>> {
        let mut rows = Vec::with_capacity(devices.len());
        for devices in devices.chunks(LANES) {
            let sizes = self.fill(form, devices, &mut room.eight, &mut room.places);
            room.eight.solve(arch);
            self.judge(arch, tests, room);
            let solved = devices.iter().zip(sizes).enumerate();
            rows.extend(solved.map(|(l, (device, sizes))| {
                self.row((form, tests), None, &self.asked.reference, device, (l, sizes?), room)
            }));
        }
        rows
    }

    /// Tests of the eight systems that were solved.
    pub(super) fn judge(&self, arch: Arch, tests: &Tests, room: &mut Room) {
        arch.dispatch(Judge { eight: &room.eight, tests, judged: &mut room.judged });
    }

    /// The row of a device from its system, whose rows are those at `reference`; `known` are its cells, where they are.
    pub(super) fn row(
        &self,
        (form, tests): (&Form, &Tests),
        known: Option<&(Vec<usize>, usize)>,
        reference: &[f64],
        device: &Device,
        (l, sizes): (usize, Sizes),
        room: &mut Room,
    ) -> Option<Row> {
        let Room { eight, judged, parted, cells, memory, cofactor, dx, v, .. } = room;
        let sums = judged.sums?;
        let (m, n) = (form.readings(), self.asked.campaign.unknowns());
        let squares = sums.squares[l];
        if !(eight.condition[l] < ILL && judged.least_redundancy[l] > CHECKED && squares.is_finite()) {
            return None;
        }
        dx.clear();
        dx.extend(lane(&eight.solution, l));
        let cofactor = match cofactor {
            Some(same) if same.nrows() == n => same,
            slot => slot.insert(Mat::zeros(n, n)),
        };
        for j in 0..n {
            let upper = if self.asked.derived.is_empty() { j } else { 0 };
            for i in upper..=j {
                let element = eight.cofactor(i, j, l);
                (cofactor[(i, j)], cofactor[(j, i)]) = (element, element);
            }
        }
        if !(dx.iter().all(|x| x.is_finite()) && (0..n).all(|j| cofactor[(j, j)].is_finite())) {
            return None;
        }
        v.clear();
        v.extend(lane(&eight.residuals, l));
        let dof = m - n;
        let question = Question {
            asked: &self.asked,
            reference,
            known: &[],
            scaled: form.scaled,
            rank: n,
            dof,
            scale_dof: if form.scaled { dof as f64 } else { f64::INFINITY },
        };
        let rounded = {
            let each = device.values.iter().zip(self.lines.iter().cycle());
            each.filter(|(value, line)| !value.is_nan() && !line.is_reference).map(|(value, _)| *value)
        };
        let least = || fit::rounding_of(fit::resolution(rounded), sizes.in_units());
        let (of, count) = match known {
            Some((of, count)) => (of.as_slice(), *count),
            None => {
                let count = self.cells(device, parted);
                (parted.of.as_slice(), count)
            }
        };
        let lack_of_fit_p = match count < m {
            true => cells.lack_of_fit((of, count), (v, lane(&eight.weight, l).map(|w| w * w)), dof),
            false if device.groups.is_empty() => None,
            false => self.between_positions(form, device, (l, v), eight),
        };
        let runs_p = if form.is_of_one() && sums.zero[l] == 0.0 {
            sums.runs_p(l, m)
        } else {
            let parts = form.parts().enumerate();
            let of = |(slot, (begin, count))| (begin..begin + count).map(move |i| (slot, i));
            least_runs_p(parts.flat_map(of).zip(v.iter()).map(|((slot, i), v)| (slot, i, *v)))
        };
        let (suspects, suspect_p) = match tests.may_be_suspicious(squares, sums.gain[l]) {
            true => self.suspects(form, device, (l, sizes.weighed), eight),
            false => (Vec::new(), f64::NAN),
        };
        let answer = Answer {
            label: &device.label,
            device: Some(device),
            unknowns: None,
            dx,
            cofactor,
            share: cofactor,
            variance: question.variance(squares, least),
            squares,
            tested: squares,
            readings: m,
            largest: sizes.weighed,
            lack_of_fit_p,
            runs_p,
            normality_p: judged.normality[l],
            suspects,
            suspect_p,
            stuck: self.stuck(form, device, l, eight),
            solved: Solved::Alone,
        };
        Some(question.row(answer, memory))
    }

    /// Probability of the test for lack of fit by positions.
    fn between_positions(&self, form: &Form, device: &Device, (l, v): (usize, &[f64]), eight: &Eight) -> Option<f64> {
        let (m, n, sensors) = (form.readings(), self.asked.campaign.unknowns(), self.lines.len());
        let groups = device.positions.len();
        let group = |slot: usize, row: usize| {
            let position = device.groups.get(row).map(|position| *position as usize)?;
            // apart for each sensor; a row without a label has no position
            Some(Some(slot * groups + position).filter(|_| !device.position(row).is_empty()))
        };
        let group: Vec<Option<usize>> = (0..sensors)
            .flat_map(|slot| device.read(slot, sensors).filter_map(move |(row, _)| group(slot, row)))
            .collect();
        let weight: Vec<f64> = lane(&eight.weight, l).collect();
        let q = Mat::from_fn(m, n, |i, j| eight.orthonormal(i, j, l));
        let offsets = Offsets::new(&weight, q.as_ref(), &group, m - n)?;
        offsets.test(v, self.asked.settings.level).map(|test| test.p)
    }

    /// Sensors whose readings are all the same, though their rows are not.
    fn stuck(&self, form: &Form, device: &Device, l: usize, eight: &Eight) -> Vec<(usize, f64)> {
        let (m, n, sensors) = (form.readings(), self.asked.campaign.unknowns(), self.lines.len());
        let of = |(slot, (begin, count)): (usize, (usize, usize))| {
            let value = fit::same(device.read(slot, sensors).map(|(_, value)| value))?;
            if !fit::is_all(value, lane(&eight.residuals, l).skip(begin).take(count)) {
                return None;
            }
            let rows: Vec<usize> = (begin..begin + count).collect();
            let predicted = |i: usize| value - eight.observed.get(i).map_or(0.0, |lanes| lanes[l]);
            let at = |i: usize, j: usize| if j < n { eight.rows[j * m + i][l] } else { predicted(i) };
            fit::changes(&rows, n, at).then_some((self.sensors.get(slot).copied()?, value))
        };
        form.parts().enumerate().filter_map(of).collect()
    }

    /// Suspicious readings, counted from 1 among the device's rows, and the probability of the most significant.
    fn suspects(&self, form: &Form, device: &Device, (l, largest): (usize, f64), eight: &Eight) -> (Vec<usize>, f64) {
        let (m, n) = (form.readings(), self.asked.campaign.unknowns());
        // in the order of the readings, in which the device's own fit would look for them
        let order = self.order(device);
        let row = |i: usize| order.get(i).map_or(0, |(_, row)| *row);
        let at = |list: &[Lane], i: usize| list.get(row(i)).map_or(0.0, |lanes| lanes[l]);
        let q = Mat::from_fn(m, n, |i, j| eight.orthonormal(row(i), j, l));
        let weight: Vec<f64> = (0..m).map(|i| at(&eight.weight, i)).collect();
        let v: Vec<f64> = (0..m).map(|i| at(&eight.residuals, i)).collect();
        let whitened = Whitened::independent(q.as_ref(), &weight, &v, largest, m - n, !form.scaled);
        suspects(&whitened, (m, self.asked.settings.level), |row| order.get(row).map(|(reading, _)| *reading))
    }
}

/// Redundancies, sums and normality of eight devices, by the widest instructions that there are.
struct Judge<'a> {
    eight: &'a Eight,
    tests: &'a Tests,
    judged: &'a mut Judged,
}

impl WithSimd for Judge<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Judge { eight, tests, judged: Judged { gain, studentized, least_redundancy, sums, normality } } = self;
        gain.clear();
        studentized.clear();
        *least_redundancy = [1.0; LANES];
        for ((v, w), h) in eight.residuals.iter().zip(&eight.weight).zip(&eight.leverage) {
            let r: Lane = std::array::from_fn(|l| 1.0 - h[l]);
            for l in 0..LANES {
                // what is no number is not checked
                let less = !(r[l] >= least_redundancy[l]);
                least_redundancy[l] = if less { r[l] } else { least_redundancy[l] };
            }
            gain.push(std::array::from_fn(|l| w[l] * w[l] / r[l]));
            studentized.push(std::array::from_fn(|l| v[l] * (w[l] / r[l].sqrt())));
        }
        *sums = Some(Sums::weighted(&eight.residuals, eight.weight.iter().copied(), gain.iter().copied()));
        *normality = tests.normality(studentized);
    }
}

// Devices of one schedule whose model is not linear in its unknowns: the steps of Gauss-Newton are those of `fit`, as long as each of them is taken
// whole and the fit becomes better; whatever else a device asks for (a rank defect, a step that must be halved) is for its own fit.

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
        let (cells, count) = fit::cells(&design, design.rows.len());
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
        let (m, n) = (form.readings(), self.asked.campaign.unknowns());
        let is_tilt: Vec<bool> =
            self.asked.campaign.estimated().iter().map(|parameter| parameter.kind == Kind::Tilt).collect();
        let (mut work, mut places) = (exact.model.workspace(), design::Room::default());
        let mut predicted = vec![[0.0; LANES]; m];
        let reference: Vec<Lane> = self.asked.reference.iter().map(|x| [*x; LANES]).collect();
        // all devices begin at one point
        let mut begin: Option<(Vec<Lane>, Vec<Lane>)> = None;
        let mut found = Vec::with_capacity(devices.len());
        for devices in devices.chunks(LANES) {
            let sizes = self.fill(form, devices, &mut room.eight, &mut room.places);
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
                eight.solve(arch);
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
            found.extend(devices.iter().zip(sizes).enumerate().map(|(l, (device, sizes))| {
                let sizes = sizes.filter(|_| settled[l] && !failed[l])?;
                let reference: Vec<f64> = point.iter().map(|x| x[l]).collect();
                self.row((form, tests), Some(&exact.cells), &reference, device, (l, sizes), room)
            }));
        }
        found
    }
}
