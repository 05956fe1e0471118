//! A schedule factorised once: what is left for each device are products, sums and tests.
#![allow(clippy::indexing_slicing, reason = "`lane` is a remainder by `LANES`, the length of every `Lane`")]

use super::answer::{Answer, Asked, Coverage, Input, Question, inputs};
use super::block::{Kernel, LANES, Lane, Sums, lane};
use super::residuals::{Cells, Sizes, Tests, UNLIKE, least_runs_p, suspects};
use super::{Device, Row, Solved};
use crate::bench::Sensor;
use crate::campaign::Campaign;
use crate::design::{self, Model};
use crate::elements::{Elements, OrNan, Parts};
use crate::estimate::{Estimate, Group, adjust};
use crate::fit::{self, Estimator, Remount, Settings};
use crate::quality::{self, Offsets, Whitened};
use faer::Mat;
use pulp::Arch;

/// Above this condition number one step of refinement is not enough.
pub(super) const ILL: f64 = 1e4;

/// What all devices of one schedule share.
#[derive(Debug, Clone)]
pub(crate) struct Common {
    asked: Asked,
    kernel: Kernel,
    /// The row of the schedule and the place among its values of each row of the design.
    places: Vec<(usize, usize)>,
    /// Values of a row of the schedule.
    sensors: usize,
    /// Sensor of each row of the design.
    sensor: Vec<usize>,
    /// Is it that of a reference, and no reading?
    is_reference: Vec<bool>,
    /// Model at the reference point; for priors, zero.
    predicted: Vec<f64>,
    /// Priors less their reference.
    priors: Vec<f64>,
    estimate: Estimate,
    /// The readings' part of the cofactor; the rest is that of priors.
    share: Mat<f64>,
    /// Is the scatter of the readings estimated (one scale for all)?
    scaled: bool,
    known: Vec<Input>,
    /// Cell of each row, and how many there are: rows of equal inputs.
    cells: (Vec<usize>, usize),
    /// Offsets of positions, where nothing is replicated.
    offsets: Option<Offsets>,
    tests: Tests,
    /// Reciprocals of the rows' standard uncertainties.
    weight: Vec<f64>,
    /// Their squares.
    squared: Vec<f64>,
    /// Rows that count for normality, with `1/(u sqrt r)`.
    studentizing: Vec<(usize, f64)>,
    /// `1/(u^2 r)` of each reading that another checks, else 0.
    gain: Vec<f64>,
    /// Rows of the design of each sensor.
    of_sensor: Vec<Vec<usize>>,
}

/// Buffers, and what returns.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    observed: Vec<Lane>,
    unknowns: Vec<Lane>,
    residuals: Vec<Lane>,
    ordered_lanes: Vec<Lane>,
    sizes: Vec<Sizes>,
    sums: Vec<(Sums, Lane)>,
    rest: Vec<f64>,
    changes: Vec<f64>,
    cells: Cells,
    memory: Coverage,
}

impl Common {
    /// What devices with these readings' schedule share; `None` where each needs a fit of its own.
    ///
    /// That is: a model that is not linear in its unknowns (unless the linear estimator is asked for), constraints, scatter, limits of errors of scale factors, robust weights, known inputs whose error is seen in the residuals,
    /// scales of several sensors to estimate, uncertainties that differ by more than a factor of 100, closed circles, unknowns that are not estimable, readings that cannot be fitted.
    /// `sensors` are those whose values a device's row has, in its order.
    pub fn new(campaign: &Campaign, settings: &Settings, sensors: &[usize]) -> Option<Common> {
        if !is_plain(campaign, settings) {
            return None;
        }
        // everything that a fit refuses is refused here
        fit::askable(campaign).ok()?;
        let model = Model::new(campaign).ok()?;
        let reference = campaign.reference_point();
        let design = design::assemble(campaign, &model, &reference).ok()?;
        fit::check_rows(campaign, &model, &design).ok()?;
        let system = fit::weigh(campaign, &design, settings.weighting).ok()?;
        let scaled = system.is_of_one_scale();
        let stated = system.group.iter().all(|group| *group == Group::Known);
        if system.group.is_empty() || !(scaled || stated) {
            return None;
        }
        // rows of very different weight want the refinement of a fit of their own
        let (least, most) = system.u.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), u| (a.min(*u), b.max(*u)));
        if most > UNLIKE * least {
            return None;
        }
        let estimate = adjust(&system, &settings.adjust).ok()?;
        let (m, n) = system.shape();
        if estimate.unknowns.rank < n {
            return None;
        }
        let sensitivities = estimate.factor.sensitivities();
        let share = match m == design.rows.len() {
            true => estimate.unknowns.cofactor.clone(),
            false => {
                let scaled = Mat::from_fn(n, design.rows.len(), |j, i| sensitivities[(j, i)] * system.u.at(i));
                &scaled * scaled.transpose()
            }
        };
        let condition = estimate.unknowns.condition();
        let kernel = Kernel {
            a: (0..m).flat_map(|i| (0..n).map(move |j| (i, j))).map(|(i, j)| system.rows[(i, j)]).collect(),
            p: (0..m).flat_map(|i| (0..n).map(move |j| (j, i))).map(|(j, i)| sensitivities[(j, i)]).collect(),
            m,
            n,
            passes: if condition.is_some_and(|c| c < ILL) { 1 } else { 2 },
        };
        let readings = design.rows.len();
        let slot = |sensor: usize| sensors.iter().position(|other| *other == sensor);
        let places: Option<Vec<(usize, usize)>> =
            design.rows.iter().map(|origin| Some((origin.reading, slot(origin.sensor)?))).collect();
        let places = places?;
        let mut predicted = design.predicted.clone();
        predicted.resize(m, 0.0);
        let known = inputs(campaign, &model, &design, &sensitivities, condition.unwrap_or(1.0))?;
        let weight = |i: usize| system.u.get(i).map_or(1.0, |u| 1.0 / u);
        let redundancy = |i: usize| estimate.redundancy.at(i);
        let studentizing: Vec<(usize, f64)> =
            (0..readings).filter(|i| redundancy(*i) > 1e-6).map(|i| (i, weight(i) / redundancy(i).sqrt())).collect();
        let whitened = Whitened::independent(
            estimate.factor.thin_q(),
            estimate.factor.weight(),
            &estimate.residuals,
            0.0,
            estimate.dof,
            stated,
        );
        let checked = |i: usize| whitened.redundancy.at(i) > quality::UNCHECKED;
        let gain: Vec<f64> = (0..readings)
            .map(|i| if checked(i) { weight(i).powi(2) / whitened.redundancy.at(i) } else { 0.0 })
            .collect();
        let tested = gain.iter().filter(|g| **g > 0.0).count();
        drop(whitened);
        let cells = fit::cells(&design, m);
        let count = cells.1;
        // something is replicated, and something is left to be lack of fit
        let are_tested = count < m && m - count < estimate.dof;
        let offsets = || {
            let positions = fit::positions(campaign, &design, m);
            Offsets::new(estimate.factor.weight(), estimate.factor.thin_q(), &positions, estimate.dof)
        };
        let offsets = if are_tested { None } else { offsets() };
        Some(Common {
            sensor: design.rows.iter().map(|origin| origin.sensor).collect(),
            is_reference: {
                let own: Vec<bool> = campaign.bench.sensors.iter().map(Sensor::is_reference).collect();
                design.rows.iter().map(|origin| own.get(origin.sensor).copied().unwrap_or(false)).collect()
            },
            of_sensor: {
                let of = |s: usize| {
                    (0..readings).filter(|i| design.rows.get(*i).is_some_and(|own| own.sensor == s)).collect()
                };
                (0..campaign.bench.sensors.len()).map(of).collect()
            },
            cells,
            offsets,
            tests: Tests::new(studentizing.len(), tested, (estimate.dof, scaled, settings.level)),
            weight: system.u.iter().map(|u| 1.0 / u).collect(),
            squared: system.u.iter().map(|u| 1.0 / (u * u)).collect(),
            priors: system.observed.iter().skip(readings).copied().collect(),
            asked: Asked::new(campaign, settings).ok()?,
            share,
            kernel,
            places,
            sensors: sensors.len(),
            predicted,
            estimate,
            scaled,
            known,
            studentizing,
            gain,
        })
    }

    /// A row for each device; `None` for one that needs a fit of its own (numbers out of range).
    ///
    /// With each device comes the row of its own for each row of the schedule, where its rows stand in another order.
    pub(super) fn rows(
        &self,
        arch: Arch,
        devices: &[(&Device, Option<&[usize]>)],
        scratch: &mut Scratch,
    ) -> Vec<Option<Row>> {
        let Kernel { m, n, .. } = self.kernel;
        let groups = devices.len().div_ceil(LANES);
        let readings = self.places.len();
        let work = scratch;
        work.observed.clear();
        work.observed.resize(groups * m, [0.0; LANES]);
        work.unknowns.resize(groups * n, [0.0; LANES]);
        work.residuals.resize(groups * m, [0.0; LANES]);
        work.sizes.clear();
        for (k, (device, map)) in devices.iter().enumerate() {
            let (group, lane) = (k / LANES, k % LANES);
            // rooms for all groups were made above
            let observed = work.observed.get_mut(group * m..(group + 1) * m).unwrap_or_default();
            let mut sizes = Sizes::NONE;
            let rows = self.places.iter().zip(&self.predicted).zip(&self.weight);
            for ((((row, slot), predicted), weight), to) in rows.zip(observed.iter_mut()) {
                // without a map the rows are in the schedule's order
                let row = map.and_then(|map| map.get(*row)).unwrap_or(row);
                let value = device.values.or_nan(row * self.sensors + slot);
                to[lane] = value - predicted;
                sizes.take(value, *weight);
            }
            for (to, prior) in observed.iter_mut().skip(readings).zip(&self.priors) {
                to[lane] = *prior;
            }
            work.sizes.push(sizes);
        }
        self.kernel.solve(arch, &work.observed, &mut work.unknowns, &mut work.residuals);
        work.sums.clear();
        for v in work.residuals.chunks_exact(m.max(1)).take(groups) {
            let studentized = self.studentizing.iter().filter_map(|(i, factor)| Some(v.get(*i)?.map(|v| v * factor)));
            work.ordered_lanes.clear();
            work.ordered_lanes.extend(studentized);
            let normality = self.tests.normality(&mut work.ordered_lanes);
            let [weight, gain] = [&self.weight, &self.gain].map(|list| list.iter().map(|x| [*x; LANES]));
            work.sums.push((Sums::weighted(v, weight, gain), normality));
        }
        let rows = devices.iter().enumerate().map(|(k, (device, map))| {
            let (group, l) = (k / LANES, k % LANES);
            let take = |from: &[Lane], width: usize, to: &mut Vec<f64>| {
                to.clear();
                to.extend(lane(from.part(group * width..(group + 1) * width), l));
            };
            take(&work.unknowns, n, &mut work.changes);
            take(&work.residuals, m, &mut work.rest);
            let ((sums, normality), sizes) = (work.sums.get(group)?, *work.sizes.get(k)?);
            let found = (&*work.changes, &*work.rest, sizes);
            self.row(device, *map, found, (sums, normality[l], l), (&mut work.cells, &mut work.memory))
        });
        rows.collect()
    }

    /// The row of one device, from its unknowns and residuals and the sums of the eight that it is one of.
    fn row(
        &self,
        device: &Device,
        map: Option<&[usize]>,
        (dx, v, sizes): (&[f64], &[f64], Sizes),
        (sums, normality_p, l): (&Sums, f64, usize),
        (cells, memory): (&mut Cells, &mut Coverage),
    ) -> Option<Row> {
        let Common { asked, estimate, .. } = self;
        let (squares, readings, level) = (sums.squares[l], self.places.len(), asked.settings.level);
        if !(sizes.are_plain() && squares.is_finite() && dx.iter().all(|x| x.is_finite())) {
            return None;
        }
        let scale_dof =
            // no group, no degrees of freedom
            if self.scaled { estimate.group_redundancy.first().copied().unwrap_or_default() } else { f64::INFINITY };
        let question = Question {
            asked,
            reference: &asked.reference,
            known: &self.known,
            scaled: self.scaled,
            rank: estimate.unknowns.rank,
            dof: estimate.dof,
            scale_dof,
        };
        // the device's own row; without a map the rows are in the schedule's order
        let own = |row: usize| map.and_then(|map| map.get(row)).copied().unwrap_or(row);
        let reading = |i: usize| self.places.get(i).map(|(row, _)| own(*row));
        let value = |i: usize| {
            let place = self.places.get(i).map(|(row, slot)| own(*row) * self.sensors + slot);
            place.map_or(f64::NAN, |place| device.values.or_nan(place))
        };
        let Kernel { a, n, .. } = &self.kernel;
        let at = |i: usize, j: usize| if j < *n { a.at(i * n + j) } else { self.predicted.at(i) };
        let stuck =
            |(sensor, rows): (usize, &Vec<usize>)| Some((sensor, fit::stuck(rows, (value, |i| v.or_nan(i)), *n, at)?));
        let read = self.is_reference.iter().enumerate().filter(|(_, is_reference)| !**is_reference);
        let step = || fit::resolution(read.map(|(i, _)| value(i)));
        let least = || fit::rounding_of(step(), sizes.in_units());
        let (suspects, suspect_p) = match self.tests.may_be_suspicious(squares, sums.gain[l]) {
            true => {
                let (q, weight) = (estimate.factor.thin_q(), estimate.factor.weight());
                let whitened = Whitened::independent(q, weight, v, sizes.weighed, estimate.dof, !self.scaled);
                suspects(&whitened, (readings, level), reading)
            }
            false => (Vec::new(), f64::NAN),
        };
        // zeros have no sign, and rows in another order have another order of signs
        let is_counted = asked.campaign.bench.sensors.len() == 1 && map.is_none() && sums.zero[l] == 0.0;
        let answer = Answer {
            label: &device.label,
            device: Some(device),
            unknowns: None,
            dx,
            cofactor: &estimate.unknowns.cofactor,
            share: &self.share,
            variance: question.variance(squares, least),
            squares,
            tested: squares,
            readings,
            largest: sizes.weighed,
            lack_of_fit_p: match &self.offsets {
                Some(offsets) => offsets.test(v, level).map(|test| test.p),
                None => {
                    let (cell, count) = &self.cells;
                    cells.lack_of_fit((cell, *count), (v, self.squared.iter().copied()), estimate.dof)
                }
            },
            runs_p: match is_counted {
                true => sums.runs_p(l, readings),
                false => least_runs_p(
                    self.sensor.iter().zip(v).enumerate().map(|(i, (s, v))| (*s, reading(i).unwrap_or(i), *v)),
                ),
            },
            normality_p,
            suspects,
            suspect_p,
            stuck: self.of_sensor.iter().enumerate().filter_map(stuck).collect(),
            solved: Solved::Together,
        };
        Some(question.row(answer, memory))
    }
}

/// Is the question one that a linear step answers, without constraints, scatter, robust weights, or closed circles?
pub(super) fn is_plain(campaign: &Campaign, settings: &Settings) -> bool {
    let one_step =
        campaign.is_linear() || (settings.estimator == Estimator::Linear && campaign.uncertain().next().is_none());
    one_step && alone(campaign, settings).is_ok()
}

/// Is the question least squares alone? Else what it is besides, and where that stands in the campaign.
pub(super) fn alone(campaign: &Campaign, settings: &Settings) -> std::result::Result<(), (String, &'static str)> {
    let is = |what: &str, path| Err((what.to_string(), path));
    if settings.robust.is_some() || settings.remount != Remount::No {
        return is("robust weights or a scatter of remounting are asked for", "");
    }
    if !campaign.constraints.is_empty() {
        return is("the campaign has constraints", "constraints");
    }
    if !campaign.scatter.is_empty() {
        return is("the campaign says what scatters", "scatter");
    }
    if !campaign.correlations.is_empty() {
        return is("known inputs are correlated", "correlations");
    }
    if let Some(error) = campaign.limited_errors().first() {
        return is(&format!("{error} has limits"), "limits");
    }
    match campaign.bench.sensors.iter().find(|sensor| sensor.turn.is_some()) {
        Some(sensor) => is(&format!("{} is a closed circle", sensor.id), "bench"),
        None => Ok(()),
    }
}
