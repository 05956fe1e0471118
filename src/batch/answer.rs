//! A device's row from its solution: values, uncertainties, limits, verdict and remarks; how the unknowns follow known inputs with an uncertainty.

use super::row::{Remarks, Solved, Verdict};
use super::{Device, Row};
use crate::algebra::{Scratch, Tape};
use crate::campaign::{Campaign, Kind, Known, Limited, Readings};
use crate::design::{self, DesignMatrix, Model};
use crate::elements::{Elements, Parts};
use crate::error::Result;
use crate::estimate::{Combination, Unknowns};
use crate::fit::{self, Settings};
use crate::quality;
use crate::uncertainty::{Combined, effective_dof, quantiles};
use faer::Mat;

/// What devices are asked: their campaign without readings, and the point at which its lines begin.
#[derive(Debug, Clone)]
pub(super) struct Asked {
    pub campaign: Campaign,
    pub settings: Settings,
    pub derived: Vec<Tape>,
    pub reference: Vec<f64>,
}

impl Asked {
    /// Errors: a derived line of a name that is no parameter.
    pub(super) fn new(campaign: &Campaign, settings: &Settings) -> Result<Self> {
        let ids: Vec<&str> = campaign.parameters.iter().map(|p| p.id.as_str()).collect();
        let derived = campaign.derived.iter().map(|d| Tape::compile(&d.line, &ids)).collect::<Result<_>>()?;
        let readings = Readings { columns: campaign.readings.columns.clone(), rows: Vec::new() };
        let reference = campaign.reference_point();
        Ok(Asked { campaign: campaign.with_readings(readings), settings: *settings, derived, reference })
    }
}

/// The question, and what the rows of a system say of it.
pub(super) struct Question<'a> {
    pub asked: &'a Asked,
    /// The point of linearisation.
    pub reference: &'a [f64],
    /// Known inputs that have an uncertainty.
    pub known: &'a [Input],
    /// Is the scatter of the readings estimated (one scale for all)?
    pub scaled: bool,
    pub rank: usize,
    pub dof: usize,
    /// Degrees of freedom of the readings' scatter; infinite where it is stated.
    pub scale_dof: f64,
}

/// What was found of one device.
pub(super) struct Answer<'a> {
    pub label: &'a str,
    /// The device, where its readings are in memory.
    pub device: Option<&'a Device>,
    /// What the rows say of the unknowns, where they may leave some of them free.
    pub unknowns: Option<&'a Unknowns>,
    /// Estimates less the reference.
    pub dx: &'a [f64],
    pub cofactor: &'a Mat<f64>,
    /// The readings' part of it; the rest is that of priors.
    pub share: &'a Mat<f64>,
    /// Variance of unit weight; `None` where it cannot be known.
    pub variance: Option<f64>,
    /// `sum (v/u)^2`.
    pub squares: f64,
    /// The same beside known inputs that have an uncertainty, for tests.
    pub tested: f64,
    pub readings: usize,
    /// The largest reading in units of its uncertainty.
    pub largest: f64,
    pub lack_of_fit_p: Option<f64>,
    pub runs_p: f64,
    pub normality_p: f64,
    pub suspects: Vec<usize>,
    /// Probability of the most significant of them; NaN where there is none.
    pub suspect_p: f64,
    /// Sensors, by index, whose readings are all the same whatever the inputs were, with that value.
    pub stuck: Vec<(usize, f64)>,
    pub solved: Solved,
}

/// Coverage factors that return from device to device, and room for the next.
#[derive(Debug, Default, Clone)]
pub struct Coverage {
    factors: Vec<(u64, Option<f64>)>,
    point: Vec<f64>,
    gradient: Vec<f64>,
    scratch: Scratch,
}

impl Question<'_> {
    /// The row of a device.
    pub(super) fn row(&self, found: Answer<'_>, memory: &mut Coverage) -> Row {
        let Asked { campaign, settings, derived, .. } = self.asked;
        let Answer { dx, cofactor, share, variance, squares, tested, .. } = found;
        let (dof, level) = (self.dof, settings.level);
        let mut point = std::mem::take(&mut memory.point);
        point.clear();
        point.extend_from_slice(self.reference);
        point.iter_mut().zip(dx).for_each(|(x, dx)| *x += dx);
        let known: Vec<Vec<f64>> = self.known.iter().map(|input| input.sensitivity(dx)).collect();
        let n = dx.len();
        let count = n + derived.len();
        let [mut value, mut u, mut expanded, mut type_a] = [(); 4].map(|()| Vec::with_capacity(count));
        let mut results: Vec<Option<Combined>> = Vec::with_capacity(if campaign.limits.is_empty() { 0 } else { count });
        let mut say = |found: Option<f64>, result: Option<Combined>| {
            value.push(found.unwrap_or(f64::NAN));
            u.push(result.map_or(f64::NAN, |c| c.u));
            expanded.push(result.map_or(f64::NAN, |c| c.expanded));
            type_a.push(result.map_or(f64::NAN, |c| c.type_a));
            if !campaign.limits.is_empty() {
                results.push(result);
            }
        };
        for (j, x) in point.iter().take(n).enumerate() {
            if found.unknowns.is_some_and(|unknowns| !unknowns.is_estimable(j)) {
                say(None, None);
                continue;
            }
            let through = |k: usize| known.at(k).at(j);
            say(Some(*x), self.combine([cofactor[(j, j)], share[(j, j)]], variance, through, memory));
        }
        let mut gradient = std::mem::take(&mut memory.gradient);
        gradient.resize(point.len(), 0.0);
        for tape in derived {
            let value = tape.gradient(&point, &mut memory.scratch, &mut gradient);
            let stays = |free: &Combination| {
                let (change, terms) = fit::moved(&free.terms, &gradient);
                change <= fit::SAME * terms
            };
            let determined = found.unknowns.is_none_or(|unknowns| unknowns.free_directions.iter().all(stays));
            if !(determined && value.is_finite() && gradient.iter().all(|c| c.is_finite())) {
                say(None, None);
                continue;
            }
            let along = gradient.part(..n);
            let form = |of: &Mat<f64>| -> f64 {
                let terms = || along.iter().enumerate().filter(|(_, c)| **c != 0.0);
                terms().map(|(i, a)| terms().map(|(j, b)| a * b * of[(i, j)]).sum::<f64>()).sum::<f64>().max(0.0)
            };
            let through = |k: usize| {
                // a line that does not depend on this input
                let direct = self.known.get(k).and_then(|input| gradient.get(input.index)).copied().unwrap_or_default();
                direct + known.get(k).map_or(0.0, |c| along.iter().zip(c).map(|(a, c)| a * c).sum())
            };
            say(Some(value), self.combine([form(cofactor), form(share)], variance, through, memory));
        }
        (memory.point, memory.gradient) = (point, gradient);
        let limits: Vec<(&str, fit::Conformity)> = campaign
            .limits
            .iter()
            .filter_map(|limit| {
                let (id, k) = match limit.of {
                    Limited::Parameter(k) => (campaign.parameters.get(k)?.id.as_str(), k),
                    Limited::Derived(k) => (campaign.derived.get(k)?.id.as_str(), n + k),
                    // such limits need the ordinary fit
                    Limited::ScaleFactor(_) => return None,
                };
                let found = value.get(k).copied().filter(|x| !x.is_nan());
                let result = results.get(k).copied().flatten();
                Some((id, fit::judge(campaign.decision, limit, found, result.as_ref(), level).0))
            })
            .collect();
        let chi_square_p = match self.scaled {
            false if dof > 0 => quantiles::chi_square_survival(tested, dof as f64),
            _ => None,
        };
        let free = |unknowns: &Unknowns| -> Vec<&str> {
            let each = campaign.estimated().iter().enumerate();
            each.filter(|(j, _)| !unknowns.is_estimable(*j)).map(|(_, p)| p.id.as_str()).collect()
        };
        let stuck: Vec<(&str, f64)> = found.stuck.iter().map(|(s, value)| (campaign.sensor_id(*s), *value)).collect();
        let free = found.unknowns.map(free).unwrap_or_default();
        let mut remarks = Remarks::begun(chi_square_p.filter(|p| *p < 1.0 - level), &free, &stuck);
        // rounding says nothing of the model
        let heard = |p: f64| if quality::is_rounding(tested, found.readings, found.largest) { f64::NAN } else { p };
        let lack_of_fit_p = found.lack_of_fit_p.map_or(f64::NAN, heard);
        let is_wrong = !remarks.is_empty();
        let is_wrong = remarks.lack_of_fit(lack_of_fit_p, level) || is_wrong;
        if let Some(device) = found.device {
            remarks.of_device(device, &found.suspects);
        }
        remarks.limits(&limits);
        Row {
            label: found.label.into(),
            lot: String::new(),
            verdict: if is_wrong { Verdict::Rejected } else { Verdict::Accepted },
            conformity: limits.iter().map(|(_, outcome)| *outcome).max(),
            why: remarks.words(),
            reasons: remarks.reasons(),
            readings: found.readings,
            rank: self.rank,
            dof,
            residual_sd: if dof > 0 { (squares / dof as f64).sqrt() } else { f64::NAN },
            chi_square_p: chi_square_p.unwrap_or(f64::NAN),
            lack_of_fit_p,
            runs_p: heard(found.runs_p),
            normality_p: heard(found.normality_p),
            suspects: found.suspects,
            suspect_p: found.suspect_p,
            solved: found.solved,
            value,
            u,
            expanded,
            type_a,
        }
    }

    /// Variance of unit weight from the sum of squares; `least` is the scale that rounding alone would have.
    pub(super) fn variance(&self, squares: f64, least: impl FnOnce() -> f64) -> Option<f64> {
        match self.scaled {
            true => (self.dof > 0).then(|| (squares / self.dof as f64).max(least().powi(2))),
            false => Some(1.0),
        }
    }

    /// Combined uncertainty of a quantity with this cofactor (and the readings' share of it), as a budget of readings, priors and known inputs says.
    fn combine(
        &self,
        [cofactor, share]: [f64; 2],
        variance: Option<f64>,
        through: impl Fn(usize) -> f64,
        memory: &mut Coverage,
    ) -> Option<Combined> {
        let readings = match variance {
            Some(variance) => (share * variance).sqrt(),
            // the scatter of the readings has a part in it, and is not known
            None if cofactor > 0.0 => return None,
            None => 0.0,
        };
        let scale_dof = self.scale_dof;
        let part = |k: usize, input: &Input| (through(k).abs() * input.known.u, input.known.dof);
        let inputs = || self.known.iter().enumerate().map(|(k, input)| part(k, input));
        // priors stand beside readings of stated uncertainty only, so that no scale multiplies them
        let type_b = inputs().map(|(u, _)| u * u).sum::<f64>() + (cofactor - share).max(0.0);
        let u = (readings * readings + type_b).sqrt();
        let dof = if type_b > 0.0 || !(u > 0.0) {
            effective_dof(u, std::iter::once((readings, scale_dof)).chain(inputs()))
        } else {
            scale_dof
        };
        let bits = dof.to_bits();
        let coverage_factor = match memory.factors.iter().find(|(known, _)| *known == bits) {
            Some((_, factor)) => *factor,
            None => {
                let factor = quantiles::coverage_factor(self.asked.settings.level, dof);
                if memory.factors.len() < 8 {
                    memory.factors.push((bits, factor));
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
}

/// A known input with an uncertainty: the unknowns follow it by `base + slope dx`.
#[derive(Debug, Clone)]
pub(super) struct Input {
    pub index: usize,
    pub known: Known,
    pub base: Vec<f64>,
    /// `n x n`, one unknown after the other; empty where all are zero.
    pub slope: Vec<f64>,
}

impl Input {
    pub(crate) fn sensitivity(&self, dx: &[f64]) -> Vec<f64> {
        if self.slope.is_empty() {
            return self.base.clone();
        }
        let rows = self.slope.chunks_exact(dx.len().max(1));
        self.base
            .iter()
            .zip(rows)
            .map(|(base, row)| base + row.iter().zip(dx).map(|(s, dx)| s * dx).sum::<f64>())
            .collect()
    }
}

/// A column that is carried along for the budget of a known input with an uncertainty: `df/dp`, or how much that changes with an unknown.
#[derive(Debug, Clone, Copy)]
pub(super) struct Carried {
    pub parameter: usize,
    pub known: Known,
    pub by: Option<usize>,
}

impl Carried {
    /// Those of a campaign: `df/dp` of each input, and behind it its derivatives by the unknowns that it depends on.
    pub(super) fn of(campaign: &Campaign) -> Vec<Carried> {
        let mut list = Vec::new();
        for (parameter, known) in campaign.uncertain() {
            let Some(input) = campaign.parameters.get(parameter) else { continue };
            list.push(Carried { parameter, known, by: None });
            for (j, unknown) in campaign.estimated().iter().enumerate() {
                let both = [input.id.as_str(), unknown.id.as_str()];
                let apart = input.kind == Kind::Coefficient
                    && campaign.bench.sensors.iter().all(|sensor| sensor.model.linear_in(&both));
                if !apart {
                    list.push(Carried { parameter, known, by: Some(j) });
                }
            }
        }
        list
    }

    /// Their numbers in each row of a design.
    pub(super) fn columns(
        list: &[Carried],
        campaign: &Campaign,
        model: &Model,
        design: &DesignMatrix,
    ) -> Result<Vec<Vec<f64>>> {
        let column = |own: &Carried| {
            let here = design.jacobian.col_as_slice(own.parameter);
            let Some(by) = own.by else { return Ok(here.to_vec()) };
            let mut point = design.point.clone();
            point.get_mut(by).into_iter().for_each(|x| *x += 1.0);
            let moved = design::assemble(campaign, model, &point)?;
            let moved = moved.jacobian.col_as_slice(own.parameter).iter();
            Ok(moved.zip(here).map(|(moved, here)| moved - here).collect())
        };
        list.iter().map(column).collect()
    }
}

/// What the unknowns leave of a column by a projection is rounding below this share of it (a few operations on each of its numbers), times the condition.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// How the unknowns follow the known inputs: `-(dx/dy) df/dp`, where `df/dp` is affine in the unknowns as the model is.
///
/// `None` where an input leaves something in the residuals: these are tested beside it, which is a question of each device.
pub(super) fn inputs(
    campaign: &Campaign,
    model: &Model,
    design: &DesignMatrix,
    sensitivities: &Mat<f64>,
    condition: f64,
) -> Option<Vec<Input>> {
    let (n, rows) = (campaign.unknowns(), design.rows.len());
    let follow = |column: &[f64]| -> Option<Vec<f64>> {
        let along = |j: usize| -column.iter().enumerate().map(|(i, c)| sensitivities[(j, i)] * c).sum::<f64>();
        let follow: Vec<f64> = (0..n).map(along).collect();
        let taken = |i: usize| follow.iter().enumerate().map(|(j, f)| design.jacobian[(i, j)] * f).sum::<f64>();
        let square = |of: &dyn Fn(usize) -> f64| (0..rows).map(|i| of(i) * of(i)).sum::<f64>();
        let left = square(&|i| column.at(i) + taken(i)).sqrt();
        (left <= ROUNDING * condition * square(&|i| column.at(i)).sqrt()).then_some(follow)
    };
    let list = Carried::of(campaign);
    let columns = Carried::columns(&list, campaign, model, design).ok()?;
    let mut found: Vec<Input> = Vec::new();
    for (own, column) in list.iter().zip(&columns) {
        let follow = follow(column)?;
        match own.by.zip(found.last_mut()) {
            None => found.push(Input { index: own.parameter, known: own.known, base: follow, slope: Vec::new() }),
            Some((by, input)) => {
                input.slope.resize(n * n, 0.0);
                input.slope.iter_mut().skip(by).step_by(n).zip(follow).for_each(|(slope, f)| *slope = f);
            }
        }
    }
    Some(found)
}
