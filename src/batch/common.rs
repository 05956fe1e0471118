//! A schedule factorised once: what is left for each device are products, sums and tests.
#![allow(clippy::indexing_slicing, reason = "`lane` is a remainder by `LANES`, the length of every `Lane`")]

use super::answer::{Answer, Coverage, Input, Question, inputs, least_variance};
use super::block::{Kernel, LANES, Lane, Sums};
use super::residuals::{Cells, Tests, runs_of, runs_p, suspects};
use super::{Device, Row, Solved};
use crate::algebra::Tape;
use crate::bench::Sensor;
use crate::campaign::{Campaign, Kind, Role};
use crate::design::{self, Model};
use crate::elements::{Elements, OrNan, Parts};
use crate::estimate::{Estimate, Group, adjust};
use crate::fit::{self, Estimator, Remount, Settings};
use crate::number;
use crate::quality::{self, Offsets, Whitened};
use faer::Mat;
use pulp::Arch;

/// Above this condition number one step of refinement is not enough.
pub(super) const ILL: f64 = 1e4;
/// Rows whose uncertainties differ by more than this factor are not solved by products.
pub(super) const UNLIKE: f64 = 100.0;

/// What all devices of one schedule share.
#[derive(Debug, Clone)]
pub(crate) struct Common {
    campaign: Campaign,
    settings: Settings,
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
    reference: Vec<f64>,
    estimate: Estimate,
    /// The readings' part of the cofactor; the rest is that of priors.
    share: Mat<f64>,
    /// Is the scatter of the readings estimated (one scale for all)?
    scaled: bool,
    known: Vec<Input>,
    derived: Vec<Tape>,
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
    /// Sensors whose readings cannot all be the same.
    channels: Vec<fit::Channel>,
    /// Greatest relative uncertainty of a row, for the rounding of readings.
    largest_u: f64,
}

/// Buffers, and what returns.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    observed: Vec<Lane>,
    unknowns: Vec<Lane>,
    residuals: Vec<Lane>,
    ordered_lanes: Vec<Lane>,
    sizes: Vec<Sizes>,
    sums: Vec<(Sums, Option<Lane>)>,
    rest: Vec<f64>,
    changes: Vec<f64>,
    ordered: Vec<f64>,
    cells: Cells,
    memory: Coverage,
}

/// The least positive and the largest size of a device's values, and the largest in units of its uncertainty.
#[derive(Debug, Clone, Copy)]
struct Sizes {
    least: f64,
    most: f64,
    weighed: f64,
}

/// What is known of a device from the eight that it is one of.
struct Found {
    sizes: Sizes,
    squares: f64,
    gain: f64,
    /// Positive residuals and runs, where that is counted.
    runs: Option<(usize, usize)>,
    normality: Option<f64>,
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
        let scaled = system.group.iter().all(|group| *group == Group::Estimated(0));
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
        let known = inputs(campaign, &model, &reference, &design, &sensitivities, condition.unwrap_or(1.0))?;
        let ids: Vec<&str> = campaign.parameters.iter().map(|p| p.id.as_str()).collect();
        let derived = campaign.derived.iter().map(|d| Tape::compile(&d.line, &ids)).collect::<Result<_, _>>().ok()?;
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
        let cells = fit::cells(campaign, &design, m);
        let count = cells.iter().max().map_or(0, |most| most + 1);
        // something is replicated, and something is left to be lack of fit
        let are_tested = count < m && m - count < estimate.dof;
        let offsets = || {
            let positions = fit::positions(campaign, &design, m);
            Offsets::new(estimate.factor.weight(), estimate.factor.thin_q(), &positions, estimate.dof)
        };
        let offsets = if are_tested { None } else { offsets() };
        let largest_u = system.u.iter().copied().fold(0.0_f64, f64::max);
        Some(Common {
            sensor: design.rows.iter().map(|origin| origin.sensor).collect(),
            is_reference: {
                let own: Vec<bool> = campaign.bench.sensors.iter().map(Sensor::is_reference).collect();
                design.rows.iter().map(|origin| own.get(origin.sensor).copied().unwrap_or(false)).collect()
            },
            channels: fit::Channel::of(&design, n, campaign.bench.sensors.len()),
            cells: (cells, count),
            offsets,
            tests: Tests::new(studentizing.len(), tested, (estimate.dof, scaled, settings.level)),
            weight: system.u.iter().map(|u| 1.0 / u).collect(),
            squared: system.u.iter().map(|u| 1.0 / (u * u)).collect(),
            priors: system.observed.iter().skip(readings).copied().collect(),
            campaign: campaign.with_readings(Default::default()),
            settings: *settings,
            share,
            kernel,
            places,
            sensors: sensors.len(),
            predicted,
            reference,
            estimate,
            scaled,
            known,
            derived,
            studentizing,
            gain,
            largest_u,
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
        let mut work = std::mem::take(scratch);
        work.observed.clear();
        work.observed.resize(groups * m, [0.0; LANES]);
        work.unknowns.resize(groups * n, [0.0; LANES]);
        work.residuals.resize(groups * m, [0.0; LANES]);
        work.sizes.clear();
        for (k, (device, map)) in devices.iter().enumerate() {
            let (group, lane) = (k / LANES, k % LANES);
            // rooms for all groups were made above
            let observed = work.observed.get_mut(group * m..(group + 1) * m).unwrap_or_default();
            let mut sizes = Sizes { least: f64::INFINITY, most: 0.0, weighed: 0.0 };
            let rows = self.places.iter().zip(&self.predicted).zip(&self.weight);
            for ((((row, slot), predicted), weight), to) in rows.zip(observed.iter_mut()) {
                // without a map the rows are in the schedule's order
                let row = map.and_then(|map| map.get(*row)).unwrap_or(row);
                let value = device.values.or_nan(row * self.sensors + slot);
                to[lane] = value - predicted;
                let size = value.abs();
                sizes.least = if size > 0.0 && size < sizes.least { size } else { sizes.least };
                sizes.most = if size > sizes.most { size } else { sizes.most };
                sizes.weighed = if size * weight > sizes.weighed { size * weight } else { sizes.weighed };
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
            work.sums.push((Sums::of(v, &self.weight, &self.gain), normality));
        }
        let alone = self.campaign.bench.sensors.len() == 1;
        let rows = devices
            .iter()
            .enumerate()
            .map(|(k, (device, map))| {
                let (group, lane) = (k / LANES, k % LANES);
                let (sums, normality) = work.sums.get(group)?;
                let found = Found {
                    sizes: *work.sizes.get(k)?,
                    squares: sums.squares[lane],
                    gain: sums.gain[lane],
                    // zeros have no sign, and rows in another order have another order of signs
                    runs: (alone && map.is_none() && sums.zero[lane] == 0.0)
                        .then(|| (number::count(sums.positive[lane]), 1 + number::count(sums.changes[lane]))),
                    normality: normality.map(|p| p[lane]),
                };
                let take = |from: &[Lane], width: usize, to: &mut Vec<f64>| {
                    to.clear();
                    let part = from.part(group * width..(group + 1) * width);
                    to.extend(part.iter().map(|numbers| numbers[lane]));
                };
                let (mut dx, mut rest) = (std::mem::take(&mut work.changes), std::mem::take(&mut work.rest));
                take(&work.unknowns, n, &mut dx);
                take(&work.residuals, m, &mut rest);
                let row = self.row(device, *map, (&dx, &rest), &found, &mut work);
                (work.changes, work.rest) = (dx, rest);
                row
            })
            .collect();
        *scratch = work;
        rows
    }

    /// The row of one device, from the products and sums of the eight that it is one of.
    fn row(
        &self,
        device: &Device,
        map: Option<&[usize]>,
        (dx, v): (&[f64], &[f64]),
        found: &Found,
        work: &mut Scratch,
    ) -> Option<Row> {
        let (estimate, squares) = (&self.estimate, found.squares);
        if found.sizes.most > fit::MOST || found.sizes.least < fit::LEAST {
            return None;
        }
        if !(squares.is_finite() && dx.iter().all(|x| x.is_finite())) {
            return None;
        }
        let scale_dof =
            // no group, no degrees of freedom
            if self.scaled { estimate.group_redundancy.first().copied().unwrap_or_default() } else { f64::INFINITY };
        let question = Question {
            campaign: &self.campaign,
            settings: &self.settings,
            derived: &self.derived,
            reference: &self.reference,
            known: &self.known,
            scaled: self.scaled,
            rank: estimate.unknowns.rank,
            dof: estimate.dof,
            scale_dof,
        };
        let values = || {
            self.places.iter().map(|(row, slot)| {
                // without a map the rows are in the schedule's order
                let row = map.and_then(|map| map.get(*row)).unwrap_or(row);
                device.values.or_nan(row * self.sensors + slot)
            })
        };
        let (suspects, suspect_p) = self.suspects(v, found, map);
        let value = |i: usize| {
            let (row, slot) = self.places.get(i)?;
            let row = map.and_then(|map| map.get(*row)).unwrap_or(row);
            device.values.get(row * self.sensors + slot).copied()
        };
        let stuck = |channel: &fit::Channel| {
            Some((channel.sensor, channel.stuck(|i| value(i).unwrap_or(f64::NAN), |i| v.or_nan(i))?))
        };
        let rounded =
            || values().zip(&self.is_reference).filter(|(_, is_reference)| !**is_reference).map(|pair| pair.0);
        let least = |variance| least_variance(rounded, (variance, found.sizes.weighed, self.largest_u));
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
            readings: self.places.len(),
            largest: found.sizes.weighed,
            lack_of_fit_p: match &self.offsets {
                Some(offsets) => offsets.test(v, self.settings.level).map(|test| test.p),
                None => {
                    let (cell, count) = &self.cells;
                    work.cells.lack_of_fit((cell, *count), (v, self.squared.iter().copied()), estimate.dof)
                }
            },
            runs_p: match found.runs {
                Some((positive, runs)) => runs_of(positive, self.gain.len() - positive, runs),
                None => self.runs(v, map),
            },
            normality_p: found.normality.unwrap_or_else(|| self.normality(v, work)),
            suspects,
            suspect_p,
            stuck: self.channels.iter().filter_map(stuck).collect(),
            solved: Solved::Together,
        };
        Some(question.row(answer, &mut work.memory))
    }

    /// Suspicious readings, counted from 1 among the device's rows, and the probability of the most significant.
    fn suspects(&self, v: &[f64], found: &Found, map: Option<&[usize]>) -> (Vec<usize>, f64) {
        if !self.tests.may_be_suspicious(found.squares, found.gain) {
            return (Vec::new(), f64::NAN);
        }
        let factor = &self.estimate.factor;
        let whitened = Whitened::independent(
            factor.thin_q(),
            factor.weight(),
            v,
            found.sizes.weighed,
            self.estimate.dof,
            !self.scaled,
        );
        let found = quality::snoop(&whitened, self.places.len(), self.settings.level);
        let reading = |row: usize| {
            let (row, _) = self.places.get(row)?;
            // without a map the rows are in the schedule's order
            Some(*map.and_then(|map| map.get(*row)).unwrap_or(row))
        };
        suspects(found.as_ref(), reading)
    }

    /// The smallest probability of the runs tests of the sensors, in the device's own order of rows.
    fn runs(&self, v: &[f64], map: Option<&[usize]>) -> f64 {
        let mut least = f64::NAN;
        for sensor in 0..self.campaign.bench.sensors.len() {
            let of_sensor = || self.sensor.iter().zip(v).enumerate().filter(|(_, (s, _))| **s == sensor);
            let p = match map {
                None => runs_p(of_sensor().map(|(_, (_, v))| *v)),
                Some(map) => {
                    let mut sorted: Vec<(usize, f64)> = of_sensor()
                        .map(|(i, (_, v))| {
                            // places are of rows that the map has
                            (self.places.get(i).and_then(|(row, _)| map.get(*row)).copied().unwrap_or(i), *v)
                        })
                        .collect();
                    sorted.sort_by_key(|(row, _)| *row);
                    runs_p(sorted.into_iter().map(|(_, v)| v))
                }
            };
            least = least.min(p);
        }
        least
    }

    fn normality(&self, v: &[f64], work: &mut Scratch) -> f64 {
        let Some(scores) = &self.tests.scores else { return f64::NAN };
        work.ordered.clear();
        work.ordered.extend(self.studentizing.iter().filter_map(|(i, factor)| v.get(*i).map(|v| v * factor)));
        scores.test(&mut work.ordered).map_or(f64::NAN, |test| test.p)
    }
}

/// Is the question one that a linear step answers, without constraints, scatter, robust weights, or closed circles?
pub(super) fn is_plain(campaign: &Campaign, settings: &Settings) -> bool {
    let one_step = is_linear(campaign) || (settings.estimator == Estimator::Linear && !is_uncertain(campaign));
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

/// Is an input known with an uncertainty?
pub(super) fn is_uncertain(campaign: &Campaign) -> bool {
    campaign.parameters.iter().any(|p| matches!(p.role, Role::Known(known) if known.u != 0.0))
}

/// Is every sensor's line affine in the unknowns, and no unknown an angle of the chain?
pub(super) fn is_linear(campaign: &Campaign) -> bool {
    let names: Vec<&str> = campaign.estimated().iter().map(|p| p.id.as_str()).collect();
    campaign.estimated().iter().all(|p| p.kind != Kind::Tilt)
        && campaign.bench.sensors.iter().all(|sensor| sensor.model.linear_in(&names))
}
