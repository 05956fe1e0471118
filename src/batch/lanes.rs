//! Devices of different schedules, eight side by side: a system for each, solved together, and each device's row from its own.
//!
//! What is not far from a rank defect, or checked by no other reading, is for the fit of that device by itself.
#![allow(
    clippy::indexing_slicing,
    reason = "a `Lane` has `LANES` numbers, and devices are put into lanes by remainders by that"
)]

use super::answer::{Answer, Coverage, Question, least_variance};
use super::block::{LANES, Lane, Sums};
use super::common::ILL;
use super::lane_rows::{Form, Lanes, Parted, Placed, Places, Sizes, lane};
use super::positions::Positions;
use super::residuals::{Cells, Tests, runs_of, runs_p, suspects};
use super::{Device, Row, Solved};
use crate::estimate::eight::Eight;
use crate::fit;
use crate::number;
use crate::quality::{self, Offsets, Whitened};
use faer::Mat;
use pulp::{Arch, Simd, WithSimd};

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
    normality: Option<Lane>,
}

impl Lanes {
    /// A row for each device of a shape; `None` for one that its own fit has to answer.
    pub(super) fn rows(
        &self,
        arch: Arch,
        (form, tests): (&Form, &Tests),
        positions: Option<&Positions>,
        devices: &[Placed<'_>],
        room: &mut Room,
    ) -> Vec<Option<Row>> {
        let mut rows = Vec::with_capacity(devices.len());
        for devices in devices.chunks(LANES) {
            let sizes = self.fill(arch, (form, positions), devices, &mut room.eight, &mut room.places);
            room.eight.solve(arch, true);
            self.judge(arch, tests, room);
            let solved = devices.iter().zip(sizes).enumerate();
            rows.extend(solved.map(|(l, (device, sizes))| {
                self.row((form, tests), (positions, None), &self.reference, *device, (l, sizes?), room)
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
        (positions, known): (Option<&Positions>, Option<&(Vec<usize>, usize)>),
        reference: &[f64],
        (device, places): Placed<'_>,
        (l, sizes): (usize, Sizes),
        room: &mut Room,
    ) -> Option<Row> {
        let Room { eight, judged, parted, cells, memory, cofactor, dx, v, .. } = room;
        let sums = judged.sums?;
        let (m, n) = (form.readings(), self.campaign.unknowns());
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
            let upper = if self.derived.is_empty() { j } else { 0 };
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
            campaign: &self.campaign,
            settings: &self.settings,
            derived: &self.derived,
            reference,
            known: &[],
            scaled: form.scaled,
            rank: n,
            dof,
            scale_dof: if form.scaled { dof as f64 } else { f64::INFINITY },
        };
        let rounded = || {
            let each = device.values.iter().zip(self.lines.iter().cycle());
            each.filter(|(value, line)| !value.is_nan() && !line.is_reference).map(|(value, _)| *value)
        };
        let least = |variance| least_variance(rounded, (variance, sizes.weighed, sizes.largest_u));
        let (of, count) = match known {
            Some((of, count)) => (of.as_slice(), *count),
            None => {
                let count = self.cells((device, places), positions, parted);
                (parted.of.as_slice(), count)
            }
        };
        let lack_of_fit_p = match count < m {
            true => cells.lack_of_fit((of, count), (v, lane(&eight.weight, l).map(|w| w * w)), dof),
            false if device.groups.is_empty() => None,
            false => self.between_positions(form, device, (l, v), eight),
        };
        let runs_p = if form.is_of_one() && sums.zero[l] == 0.0 {
            let positive = number::count(sums.positive[l]);
            runs_of(positive, m - positive, 1 + number::count(sums.changes[l]))
        } else {
            let parts = form.parts().filter_map(|(begin, count)| v.get(begin..begin + count));
            parts.map(|residuals| runs_p(residuals.iter().copied())).fold(f64::NAN, f64::min)
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
            normality_p: match (&judged.normality, &tests.scores) {
                (Some(p), _) => p[l],
                (None, Some(scores)) => {
                    let mut studentized: Vec<f64> = lane(&judged.studentized, l).collect();
                    scores.test(&mut studentized).map_or(f64::NAN, |test| test.p)
                }
                (None, None) => f64::NAN,
            },
            suspects,
            suspect_p,
            stuck: self.stuck(form, device, l, eight),
            solved: Solved::Alone,
        };
        Some(question.row(answer, memory))
    }

    /// Probability of the test for lack of fit by positions.
    fn between_positions(&self, form: &Form, device: &Device, (l, v): (usize, &[f64]), eight: &Eight) -> Option<f64> {
        let (m, n, sensors) = (form.readings(), self.campaign.unknowns(), self.lines.len());
        let groups = device.positions.len();
        let group = |slot: usize, row: usize| {
            device.value(row, sensors).get(slot).filter(|value| !value.is_nan())?;
            let position = device.groups.get(row).map(|position| *position as usize)?;
            // apart for each sensor; a row without a label has no position
            Some(Some(slot * groups + position).filter(|_| !device.position(row).is_empty()))
        };
        let group: Vec<Option<usize>> =
            (0..sensors).flat_map(|slot| (0..device.rows).filter_map(move |row| group(slot, row))).collect();
        let weight: Vec<f64> = lane(&eight.weight, l).collect();
        let q = Mat::from_fn(m, n, |i, j| eight.orthonormal(i, j, l));
        let offsets = Offsets::new(&weight, q.as_ref(), &group, m - n)?;
        offsets.test(v, self.settings.level).map(|test| test.p)
    }

    /// Sensors whose readings are all the same, though their rows are not.
    fn stuck(&self, form: &Form, device: &Device, l: usize, eight: &Eight) -> Vec<(usize, f64)> {
        let (m, n, sensors) = (form.readings(), self.campaign.unknowns(), self.lines.len());
        let of = |(slot, (begin, count)): (usize, (usize, usize))| {
            let values = device.values.iter().skip(slot).step_by(sensors).copied().filter(|value| !value.is_nan());
            let value = fit::same(values)?;
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
        let (m, n) = (form.readings(), self.campaign.unknowns());
        // in the order of the readings, in which the device's own fit would look for them
        let order = self.order(device);
        let row = |i: usize| order.get(i).map_or(0, |(_, row)| *row);
        let at = |list: &[Lane], i: usize| list.get(row(i)).map_or(0.0, |lanes| lanes[l]);
        let q = Mat::from_fn(m, n, |i, j| eight.orthonormal(row(i), j, l));
        let weight: Vec<f64> = (0..m).map(|i| at(&eight.weight, i)).collect();
        let v: Vec<f64> = (0..m).map(|i| at(&eight.residuals, i)).collect();
        let whitened = Whitened::independent(q.as_ref(), &weight, &v, largest, m - n, !form.scaled);
        let found = quality::snoop(&whitened, m, self.settings.level);
        suspects(found.as_ref(), |row| order.get(row).map(|(reading, _)| *reading))
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
