//! A schedule factorised once: what is left for each device are products, sums and tests.
#![allow(clippy::indexing_slicing, reason = "`lane` is a remainder by `LANES`, the length of every `Lane`")]

use super::answer::Coverage;
use super::block::{Kernel, LANES, Lane};
use super::inputs::{Input, inputs};
use super::replicates::Replicates;
use super::simd_tests::{self, Sums};
use super::{Device, Row};
use crate::algebra::Tape;
use crate::campaign::{Campaign, Kind, Role};
use crate::design::{self, Model};
use crate::elements::{Elements, OrNan, Parts};
use crate::estimate::{Estimate, Group, adjust};
use crate::fit::{self, Estimator, Remount, Settings};
use crate::number;
use crate::quality::{self, NormalScores, Offsets, Whitened};
use crate::uncertainty::quantiles;
use faer::Mat;
use pulp::Arch;

/// Above this condition number one step of refinement is not enough.
pub(super) const ILL: f64 = 1e4;
/// Rows whose uncertainties differ by more than this factor are not solved by products.
pub(super) const UNLIKE: f64 = 100.0;
/// Up to so many residuals are sorted side by side.
pub(super) const NETWORK: usize = 256;

/// What all devices of one schedule share.
#[derive(Debug, Clone)]
pub struct Common {
    pub(super) campaign: Campaign,
    pub(super) settings: Settings,
    pub(super) kernel: Kernel,
    /// The row of the schedule and the place among its values of each row of the design.
    pub(super) places: Vec<(usize, usize)>,
    /// Values of a row of the schedule.
    pub(super) sensors: usize,
    /// Sensor of each row of the design.
    pub(super) sensor: Vec<usize>,
    /// Model at the reference point; for priors, zero.
    pub(super) predicted: Vec<f64>,
    /// Priors less their reference.
    pub(super) priors: Vec<f64>,
    pub(super) reference: Vec<f64>,
    pub(super) estimate: Estimate,
    /// The readings' part of the cofactor; the rest is that of priors.
    pub(super) share: Mat<f64>,
    /// Is the scatter of the readings estimated (one scale for all)?
    pub(super) scaled: bool,
    pub(super) known: Vec<Input>,
    pub(super) derived: Vec<Tape>,
    pub(super) cells: Replicates,
    /// Offsets of positions, where nothing is replicated.
    pub(super) offsets: Option<Offsets>,
    pub(super) scores: Option<NormalScores>,
    /// How as many values as count for normality are sorted.
    pub(super) network: Vec<(usize, usize)>,
    /// Reciprocals of the rows' standard uncertainties.
    pub(super) weight: Vec<f64>,
    /// Rows that count for normality, with `1/(u sqrt r)`.
    pub(super) studentizing: Vec<(usize, f64)>,
    /// `1/(u^2 r)` of each reading that another checks, else 0.
    pub(super) gain: Vec<f64>,
    /// From here on the largest gain is looked at more closely; `None` where nothing can be tested.
    pub(super) threshold: Option<f64>,
    /// Sensors whose readings cannot all be the same.
    pub(super) channels: Vec<fit::Channel>,
    /// Greatest relative uncertainty of a row, for the rounding of readings.
    pub(super) largest_u: f64,
}

/// Buffers, and what returns.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    pub(super) observed: Vec<Lane>,
    pub(super) unknowns: Vec<Lane>,
    pub(super) residuals: Vec<Lane>,
    pub(super) ordered_lanes: Vec<Lane>,
    pub(super) sizes: Vec<Sizes>,
    pub(super) sums: Vec<(Sums, Option<Lane>)>,
    pub(super) rest: Vec<f64>,
    pub(super) changes: Vec<f64>,
    pub(super) ordered: Vec<f64>,
    pub(super) cell_sums: Vec<f64>,
    pub(super) memory: Coverage,
}

/// The least positive and the largest size of a device's values, and the largest in units of its uncertainty.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sizes {
    pub(super) least: f64,
    pub(super) most: f64,
    pub(super) weighed: f64,
}

/// What is known of a device from the eight that it is one of.
pub(super) struct Found {
    pub(super) sizes: Sizes,
    pub(super) squares: f64,
    pub(super) gain: f64,
    /// Positive residuals and runs, where that is counted.
    pub(super) runs: Option<(usize, usize)>,
    pub(super) normality: Option<f64>,
}

impl Common {
    /// What devices with these readings' schedule share; `None` where each needs a fit of its own.
    ///
    /// That is: a model that is not linear in its unknowns (unless the linear estimator is asked for), constraints, scatter, limits of errors of scale factors, robust weights,
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
        let kernel = Kernel {
            a: (0..m).flat_map(|i| (0..n).map(move |j| (i, j))).map(|(i, j)| system.rows[(i, j)]).collect(),
            p: (0..m).flat_map(|i| (0..n).map(move |j| (j, i))).map(|(j, i)| sensitivities[(j, i)]).collect(),
            m,
            n,
            passes: if estimate.unknowns.condition.is_some_and(|c| c < ILL) { 1 } else { 2 },
        };
        let readings = design.rows.len();
        let slot = |sensor: usize| sensors.iter().position(|own| *own == sensor);
        let places: Option<Vec<(usize, usize)>> =
            design.rows.iter().map(|origin| Some((origin.reading, slot(origin.sensor)?))).collect();
        let places = places?;
        let mut predicted = design.predicted.clone();
        predicted.resize(m, 0.0);
        let known = inputs(campaign, &model, &reference, &design, &sensitivities)?;
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
        let tested = gain.iter().filter(|g| **g > 0.0).count().max(1);
        let single = -(settings.level.ln() / tested as f64).exp_m1();
        let threshold = match (stated, estimate.dof) {
            (true, 1..) => quantiles::chi_square_quantile(1.0 - single, 1.0),
            (false, 2..) => quantiles::fisher_f_quantile(1.0 - single, 1.0, estimate.dof as f64 - 1.0),
            _ => None,
        };
        drop(whitened);
        let cells = Replicates::new(&fit::cells(campaign, &design, m), &system.u, estimate.dof);
        let offsets = || {
            let positions = fit::positions(campaign, &design);
            Offsets::new(estimate.factor.weight(), estimate.factor.thin_q(), &positions, estimate.dof)
        };
        let offsets = if cells.are_tested() { None } else { offsets() };
        let largest_u = system.u.iter().copied().fold(0.0_f64, f64::max);
        Some(Common {
            sensor: design.rows.iter().map(|origin| origin.sensor).collect(),
            channels: fit::Channel::of(&design, n, campaign.bench.sensors.len()),
            cells,
            offsets,
            scores: NormalScores::new(studentizing.len()),
            network: simd_tests::network(if studentizing.len() <= NETWORK { studentizing.len() } else { 0 }),
            weight: system.u.iter().map(|u| 1.0 / u).collect(),
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
            threshold,
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
            let normality = self.scores.as_ref().filter(|_| !self.network.is_empty()).map(|scores| {
                let studentized =
                    self.studentizing.iter().filter_map(|(i, factor)| Some(v.get(*i)?.map(|v| v * factor)));
                work.ordered_lanes.clear();
                work.ordered_lanes.extend(studentized);
                simd_tests::normality(scores, &self.network, &mut work.ordered_lanes)
            });
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
                    let own = from.part(group * width..(group + 1) * width);
                    to.extend(own.iter().map(|numbers| numbers[lane]));
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
}

/// Is the question one that a linear step answers, without constraints, scatter, robust weights or closed circles?
pub(super) fn is_plain(campaign: &Campaign, settings: &Settings) -> bool {
    let one_step = is_linear(campaign) || (settings.estimator == Estimator::Linear && !is_uncertain(campaign));
    one_step && is_alone(campaign, settings)
}

/// Is the question least squares alone?
pub(super) fn is_alone(campaign: &Campaign, settings: &Settings) -> bool {
    settings.robust.is_none()
        && settings.remount == Remount::No
        && campaign.constraints.is_empty()
        && campaign.scatter.is_empty()
        && campaign.correlations.is_empty()
        && campaign.limited_errors().is_empty()
        && campaign.bench.sensors.iter().all(|sensor| sensor.turn.is_none())
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
