//! A schedule factorised once: what is left for each device are products, sums and tests.

use super::block::{Kernel, LANES, Lane};
use super::inputs::{Input, inputs};
use super::replicates::{Replicates, runs_p};
use super::row::{Solved, Verdict, chi_square_words, remarks};
use super::{Device, Row};
use crate::algebra::{Scratch as TapeScratch, Tape};
use crate::campaign::{Campaign, Kind, Limited, Role};
use crate::design::{self, Model};
use crate::estimate::{Estimate, Group, System, adjust};
use crate::fit::{self, Estimator, Remount, Settings, resolution};
use crate::quality::{self, NormalScores, Whitened};
use crate::uncertainty::quantiles;
use crate::uncertainty::{Combined, effective_dof};
use faer::Mat;
use pulp::Arch;

/// Above this condition number one step of refinement is not enough.
const ILL: f64 = 1e4;
/// Rows whose uncertainties differ by more than this factor are not solved by products.
const UNLIKE: f64 = 100.0;
/// Share of a threshold within which the exact probability decides.
const SLACK: f64 = 1e-6;

/// What all devices of one schedule share.
#[derive(Debug, Clone)]
pub struct Common {
    campaign: Campaign,
    settings: Settings,
    kernel: Kernel,
    /// The row of the schedule and the place among its values of each row of the design.
    places: Vec<(usize, usize)>,
    /// Values of a row of the schedule.
    sensors: usize,
    /// Sensor of each row of the design.
    sensor: Vec<usize>,
    /// Model at the reference point; for priors, zero.
    predicted: Vec<f64>,
    /// Priors less their reference.
    priors: Vec<f64>,
    reference: Vec<f64>,
    system: System,
    estimate: Estimate,
    /// The readings' part of the cofactor; the rest is that of priors.
    share: Mat<f64>,
    /// Is the scatter of the readings estimated (one scale for all)?
    scaled: bool,
    known: Vec<Input>,
    derived: Vec<Tape>,
    cells: Replicates,
    scores: Option<NormalScores>,
    /// Rows that count for normality, with `1/(u sqrt r)`.
    studentizing: Vec<(usize, f64)>,
    /// `1/(u^2 r)` of each reading that another checks, else 0.
    gain: Vec<f64>,
    /// From here on the largest gain is looked at more closely; `None` where nothing can be tested.
    threshold: Option<f64>,
    /// Greatest relative uncertainty of a row, for the rounding of readings.
    largest_u: f64,
}

/// Buffers, and probabilities that return.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    observed: Vec<Lane>,
    unknowns: Vec<Lane>,
    residuals: Vec<Lane>,
    rest: Vec<f64>,
    ordered: Vec<f64>,
    sums: Vec<f64>,
    factors: Vec<(u64, Option<f64>)>,
}

impl Common {
    /// What devices with these readings' schedule share; `None` where each needs a fit of its own.
    ///
    /// That is: a model that is not linear in its unknowns (unless the linear estimator is asked for), constraints, scatter, robust weights,
    /// scales of several sensors to estimate, uncertainties that differ by more than a factor of 100, closed circles, unknowns that are not estimable, readings that cannot be fitted.
    /// `sensors` are those whose values a device's row has, in its order.
    pub fn new(campaign: &Campaign, settings: &Settings, sensors: &[usize]) -> Option<Common> {
        let plain = settings.robust.is_none()
            && settings.remount == Remount::No
            && campaign.constraints.is_empty()
            && campaign.scatter.is_empty()
            && campaign.bench.sensors.iter().all(|sensor| sensor.turn.is_none());
        let linear = is_linear(campaign);
        let uncertain = campaign.parameters.iter().any(|p| matches!(p.role, Role::Known(known) if known.u != 0.0));
        if !plain || !(linear || (settings.estimator == Estimator::Linear && !uncertain)) {
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
        if estimate.rank < n {
            return None;
        }
        let sensitivities = estimate.factor.sensitivities();
        let share = match m == design.rows.len() {
            true => estimate.cofactor.clone(),
            false => {
                let scaled = Mat::from_fn(n, design.rows.len(), |j, i| {
                    sensitivities[(j, i)] * system.u.get(i).copied().unwrap_or_default()
                });
                &scaled * scaled.transpose()
            }
        };
        let kernel = Kernel {
            a: (0..m).flat_map(|i| (0..n).map(move |j| (i, j))).map(|(i, j)| system.rows[(i, j)]).collect(),
            p: (0..m).flat_map(|i| (0..n).map(move |j| (j, i))).map(|(j, i)| sensitivities[(j, i)]).collect(),
            m,
            n,
            passes: if estimate.condition.is_some_and(|c| c < ILL) { 1 } else { 2 },
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
        let redundancy = |i: usize| estimate.redundancy.get(i).copied().unwrap_or_default();
        let studentizing: Vec<(usize, f64)> =
            (0..readings).filter(|i| redundancy(*i) > 1e-6).map(|i| (i, weight(i) / redundancy(i).sqrt())).collect();
        let whitened = Whitened::independent(
            estimate.factor.thin_q(),
            estimate.factor.weight(),
            &estimate.residuals,
            estimate.dof,
            stated,
        );
        let checked = |i: usize| whitened.redundancy.get(i).copied().unwrap_or_default() > quality::UNCHECKED;
        let gain: Vec<f64> =
            (0..readings)
                .map(|i| {
                    if checked(i) {
                        weight(i).powi(2) / whitened.redundancy.get(i).copied().unwrap_or(1.0)
                    } else {
                        0.0
                    }
                })
                .collect();
        let tested = gain.iter().filter(|g| **g > 0.0).count().max(1);
        let single = -(settings.level.ln() / tested as f64).exp_m1();
        let threshold = match (stated, estimate.dof) {
            (true, 1..) => quantiles::chi_square_quantile(1.0 - single, 1.0),
            (false, 2..) => quantiles::fisher_f_quantile(1.0 - single, 1.0, estimate.dof as f64 - 1.0),
            _ => None,
        };
        drop(whitened);
        let largest_u = system.u.iter().copied().fold(0.0_f64, f64::max);
        Some(Common {
            sensor: design.rows.iter().map(|origin| origin.sensor).collect(),
            cells: Replicates::new(&fit::cells(campaign, &design, m), &system.u, estimate.dof),
            scores: NormalScores::new(studentizing.len()),
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
            system,
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
        for (k, (device, map)) in devices.iter().enumerate() {
            let (group, lane) = (k / LANES, k % LANES);
            let observed = work.observed.get_mut(group * m..(group + 1) * m).unwrap_or_default();
            for (((row, slot), predicted), to) in self.places.iter().zip(&self.predicted).zip(observed.iter_mut()) {
                let row = map.and_then(|map| map.get(*row)).unwrap_or(row);
                let value = device.values.get(row * self.sensors + slot).copied().unwrap_or(f64::NAN);
                to.iter_mut().skip(lane).take(1).for_each(|y| *y = value - predicted);
            }
            for (to, prior) in observed.iter_mut().skip(readings).zip(&self.priors) {
                to.iter_mut().skip(lane).take(1).for_each(|y| *y = *prior);
            }
        }
        self.kernel.solve(arch, &work.observed, &mut work.unknowns, &mut work.residuals);
        let rows = devices
            .iter()
            .enumerate()
            .map(|(k, (device, map))| {
                let (group, lane) = (k / LANES, k % LANES);
                let of = |from: &[Lane], width: usize| -> Vec<f64> {
                    let own = from.get(group * width..(group + 1) * width).unwrap_or_default();
                    own.iter().map(|numbers| numbers.get(lane).copied().unwrap_or(f64::NAN)).collect()
                };
                let dx = of(&work.unknowns, n);
                let mut rest = std::mem::take(&mut work.rest);
                rest.clear();
                let own = work.residuals.get(group * m..(group + 1) * m).unwrap_or_default();
                rest.extend(own.iter().map(|numbers| numbers.get(lane).copied().unwrap_or(f64::NAN)));
                let row = self.row(device, *map, &dx, &rest, &mut work);
                work.rest = rest;
                row
            })
            .collect();
        *scratch = work;
        rows
    }

    fn row(&self, device: &Device, map: Option<&[usize]>, dx: &[f64], v: &[f64], work: &mut Scratch) -> Option<Row> {
        let Common { estimate, settings, campaign, system, .. } = self;
        let (dof, level) = (estimate.dof, settings.level);
        let sizes = device.values.iter().filter(|y| !y.is_nan()).map(|y| y.abs());
        let (least, most) = sizes.fold((f64::INFINITY, 0.0_f64), |(least, most), y| {
            (if y > 0.0 { least.min(y) } else { least }, most.max(y))
        });
        if most > fit::MOST || least < fit::LEAST {
            return None;
        }
        let squares: f64 = v.iter().zip(&system.u).map(|(v, u)| (v / u) * (v / u)).sum();
        if !(squares.is_finite() && dx.iter().all(|x| x.is_finite())) {
            return None;
        }
        let variance = match self.scaled {
            true if dof > 0 => Some((squares / dof as f64).max(self.least(device, map, squares / dof as f64))),
            true => None,
            false => Some(1.0),
        };
        let mut point = self.reference.clone();
        point.iter_mut().zip(dx).for_each(|(x, dx)| *x += dx);
        let known: Vec<Vec<f64>> = self.known.iter().map(|input| input.sensitivity(dx)).collect();
        let n = dx.len();
        let count = n + self.derived.len();
        let [mut value, mut u, mut expanded, mut type_a] = [(); 4].map(|()| Vec::with_capacity(count));
        let mut results: Vec<Option<Combined>> = Vec::with_capacity(if campaign.limits.is_empty() { 0 } else { count });
        let mut say = |found: Option<f64>, own: Option<Combined>| {
            value.push(found.unwrap_or(f64::NAN));
            u.push(own.map_or(f64::NAN, |c| c.u));
            expanded.push(own.map_or(f64::NAN, |c| c.expanded));
            type_a.push(own.map_or(f64::NAN, |c| c.type_a));
            if !campaign.limits.is_empty() {
                results.push(own);
            }
        };
        for (j, x) in point.iter().take(n).enumerate() {
            let through = |k: usize| known.get(k).and_then(|c| c.get(j)).copied().unwrap_or_default();
            say(Some(*x), self.combine([estimate.cofactor[(j, j)], self.share[(j, j)]], variance, through, work));
        }
        for tape in &self.derived {
            let mut gradient = vec![0.0; point.len()];
            let found = tape.gradient(&point, &mut TapeScratch::default(), &mut gradient);
            if !(found.is_finite() && gradient.iter().all(|c| c.is_finite())) {
                say(None, None);
                continue;
            }
            let along = gradient.get(..n).unwrap_or_default();
            let form = |of: &Mat<f64>| -> f64 {
                let terms = || along.iter().enumerate().filter(|(_, c)| **c != 0.0);
                terms().map(|(i, a)| terms().map(|(j, b)| a * b * of[(i, j)]).sum::<f64>()).sum::<f64>().max(0.0)
            };
            let through = |k: usize| {
                let own = self.known.get(k).and_then(|input| gradient.get(input.index)).copied().unwrap_or_default();
                own + known.get(k).map_or(0.0, |c| along.iter().zip(c).map(|(a, c)| a * c).sum())
            };
            say(Some(found), self.combine([form(&estimate.cofactor), form(&self.share)], variance, through, work));
        }
        let limits: Vec<(&str, fit::Conformity)> = campaign
            .limits
            .iter()
            .filter_map(|limit| {
                let (id, k) = match limit.of {
                    Limited::Parameter(k) => (campaign.parameters.get(k)?.id.as_str(), k),
                    Limited::Derived(k) => (campaign.derived.get(k)?.id.as_str(), n + k),
                };
                let found = value.get(k).copied().filter(|x| !x.is_nan());
                let own = results.get(k).copied().flatten();
                Some((id, fit::judge(campaign.decision, limit, found, own.as_ref(), level).0))
            })
            .collect();
        let chi_square_p = match self.scaled {
            false if dof > 0 => quantiles::chi_square_survival(squares, dof as f64),
            _ => None,
        };
        let rejected = chi_square_p.is_some_and(|p| p < 1.0 - level);
        let lack_of_fit_p = self.cells.lack_of_fit(v, &mut work.sums);
        let suspects = self.suspects(v, squares, map);
        let mut why = Vec::new();
        if let Some(p) = chi_square_p.filter(|_| rejected) {
            why.push(chi_square_words(p));
        }
        remarks(&mut why, &suspects, lack_of_fit_p.filter(|p| *p < 1.0 - level), &limits);
        Some(Row {
            label: device.label.clone(),
            lot: String::new(),
            verdict: if rejected { Verdict::Rejected } else { Verdict::Accepted },
            conformity: limits.iter().map(|(_, own)| *own).max(),
            why: why.join("; "),
            readings: self.places.len(),
            rank: estimate.rank,
            dof,
            residual_sd: if dof > 0 { (squares / dof as f64).sqrt() } else { f64::NAN },
            chi_square_p: chi_square_p.unwrap_or(f64::NAN),
            lack_of_fit_p: lack_of_fit_p.unwrap_or(f64::NAN),
            runs_p: self.runs(v, map),
            normality_p: self.normality(v, work),
            suspects,
            solved: Solved::Together,
            value,
            u,
            expanded,
            type_a,
        })
    }

    /// Combined uncertainty of a quantity with this cofactor (and the readings' share of it), as a budget of readings, priors and known inputs says.
    fn combine(
        &self,
        [cofactor, share]: [f64; 2],
        variance: Option<f64>,
        through: impl Fn(usize) -> f64,
        work: &mut Scratch,
    ) -> Option<Combined> {
        let readings = match variance {
            Some(variance) => (share * variance).sqrt(),
            // the scatter of the readings has a part in it, and is not known
            None if cofactor > 0.0 => return None,
            None => 0.0,
        };
        let own_dof = if self.scaled {
            self.estimate.group_redundancy.first().copied().unwrap_or_default()
        } else {
            f64::INFINITY
        };
        let part = |k: usize, input: &Input| (through(k).abs() * input.known.u, input.known.dof);
        let inputs = || self.known.iter().enumerate().map(|(k, input)| part(k, input));
        // priors stand beside readings of stated uncertainty only, so that no scale multiplies them
        let type_b = inputs().map(|(u, _)| u * u).sum::<f64>() + (cofactor - share).max(0.0);
        let u = (readings * readings + type_b).sqrt();
        let dof = if type_b > 0.0 || !(u > 0.0) {
            effective_dof(u, std::iter::once((readings, own_dof)).chain(inputs()))
        } else if own_dof.is_finite() {
            own_dof
        } else {
            f64::INFINITY
        };
        let bits = dof.to_bits();
        let coverage_factor = match work.factors.iter().find(|(own, _)| *own == bits) {
            Some((_, factor)) => *factor,
            None => {
                let factor = quantiles::coverage_factor(self.settings.level, dof);
                if work.factors.len() < 8 {
                    work.factors.push((bits, factor));
                }
                factor
            }
        }?;
        Some(Combined {
            u,
            type_a: readings,
            type_b: type_b.sqrt(),
            dof,
            coverage_factor,
            expanded: coverage_factor * u,
        })
    }

    /// The square of the scale that the rounding of the readings alone would have, where that can matter.
    fn least(&self, device: &Device, map: Option<&[usize]>, variance: f64) -> f64 {
        let values = || {
            self.places.iter().map(|(row, slot)| {
                let row = map.and_then(|map| map.get(*row)).unwrap_or(row);
                device.values.get(row * self.sensors + slot).copied().unwrap_or_default()
            })
        };
        let arithmetic = values().zip(&self.system.u).map(|(y, u)| 2.0 * f64::EPSILON * y.abs() / u);
        let arithmetic = arithmetic.fold(0.0_f64, f64::max).powi(2);
        // a last place this coarse would matter; all readings are whole numbers of it, or it is none
        let coarse = variance.sqrt() * 12f64.sqrt() * self.largest_u;
        let places = coarse.log10().ceil();
        let unit = if places <= 0.0 { 10f64.powf(-places) } else { 0.0 };
        let whole = |y: f64| {
            let count = y * unit;
            (count - count.round()).abs() <= 1e-6 * count.abs().max(1.0)
        };
        if !(coarse > 0.0) || (unit > 0.0 && places > -14.0 && values().all(whole)) {
            let step = resolution(values()).unwrap_or(0.0);
            return arithmetic.max((step / 12f64.sqrt() / self.largest_u).powi(2));
        }
        arithmetic
    }

    /// Suspicious readings, counted from 1 among the device's rows.
    fn suspects(&self, v: &[f64], squares: f64, map: Option<&[usize]>) -> Vec<usize> {
        let Some(threshold) = self.threshold else { return Vec::new() };
        let best = v.iter().zip(&self.gain).map(|(v, gain)| v * v * gain).fold(0.0_f64, f64::max);
        let statistic = if self.scaled {
            let rest = (squares - best).max(0.0) / (self.estimate.dof as f64 - 1.0);
            if rest > 0.0 { best / rest } else { f64::INFINITY }
        } else {
            best
        };
        if statistic < threshold * (1.0 - SLACK) || best == 0.0 {
            return Vec::new();
        }
        let factor = &self.estimate.factor;
        let whitened = Whitened::independent(factor.thin_q(), factor.weight(), v, self.estimate.dof, !self.scaled);
        let found = quality::snoop(&whitened, self.places.len(), self.settings.level);
        let reading = |row: usize| {
            let (row, _) = self.places.get(row)?;
            Some(map.and_then(|map| map.get(*row)).unwrap_or(row) + 1)
        };
        found.iter().flat_map(|found| &found.suspects).filter_map(|suspect| reading(suspect.row)).collect()
    }

    /// The smallest probability of the runs tests of the sensors, in the device's own order of rows.
    fn runs(&self, v: &[f64], map: Option<&[usize]>) -> f64 {
        let mut least = f64::NAN;
        for sensor in 0..self.campaign.bench.sensors.len() {
            let own = || self.sensor.iter().zip(v).enumerate().filter(|(_, (s, _))| **s == sensor);
            let p = match map {
                None => runs_p(own().map(|(_, (_, v))| *v)),
                Some(map) => {
                    let mut sorted: Vec<(usize, f64)> = own()
                        .map(|(i, (_, v))| {
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
        let Some(scores) = &self.scores else { return f64::NAN };
        work.ordered.clear();
        work.ordered.extend(self.studentizing.iter().filter_map(|(i, factor)| v.get(*i).map(|v| v * factor)));
        scores.test(&mut work.ordered).map_or(f64::NAN, |test| test.p)
    }
}

/// Is every sensor's line affine in the unknowns, and no unknown an angle of the chain?
pub(super) fn is_linear(campaign: &Campaign) -> bool {
    let names: Vec<&str> = campaign.estimated().iter().map(|p| p.id.as_str()).collect();
    campaign.estimated().iter().all(|p| p.kind != Kind::Tilt)
        && campaign.bench.sensors.iter().all(|sensor| sensor.model.linear_in(&names))
}
