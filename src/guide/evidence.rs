//! Readings under a model whose unknowns have a prior: the most probable values, what they predict, and how probable the readings are.
//!
//! ```text
//! x = x0 + U z,  z ~ N(c, 1),      r = (y - f(x0)) / sd,  A = df/dx U / sd          r, A: made independent, with the scatter of the campaign
//! M = 1 + A'A,   z^ = M^-1 (A'r + c),   F = |r - A z^|^2 + |z^ - c|^2,   ln p = -1/2 (F + ln |M| + ln |V|) + constant
//! ```
//!
//! Unknowns are the estimated parameters and the known inputs with an uncertainty. What is believed of them before any reading: a stated prior or
//! uncertainty; limits that the campaign states; of a tilt the size that a bench can have; of a coefficient nothing.
#![allow(
    clippy::indexing_slicing,
    reason = "`Rows` are made with one column for each belief; lists over beliefs have one entry for each"
)]

use crate::campaign::{Campaign, Constraint, JointState, Kind, Reading, Readings, Role};
use crate::design::{self, DesignMatrix, Model, RowOrigin};
use crate::error::Result;
use crate::estimate::Whitening;
use crate::fit;
use crate::linear::{Triangle, dot};
use crate::plan::Noise;

/// Standard deviation of an unknown about which nothing is believed, in units of what one reading of its largest row tells of it. Its value follows
/// the estimate, so that it pulls nothing.
const LOOSE: f64 = 1e5;

/// Where a belief comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Source {
    /// The campaign states it.
    Stated,
    /// The size that a bench's tilt can have.
    Supposed,
    /// Nothing is believed.
    Nothing,
}

/// What is believed of one unknown before any reading.
#[derive(Debug, Clone, Copy)]
struct Belief {
    parameter: usize,
    value: f64,
    u: f64,
    source: Source,
}

/// What is believed of all unknowns.
#[derive(Debug, Clone)]
pub(super) struct Beliefs(Vec<Belief>);

impl Beliefs {
    /// Of a campaign whose tilts may be of the size `tilts` (radians), and which may be read at `positions`.
    pub fn new(campaign: &Campaign, positions: &[Reading], noise: &Noise, tilts: f64) -> Result<Self> {
        let of = |(parameter, estimated): (usize, &crate::campaign::Parameter)| {
            let stated = |value, u| Some(Belief { parameter, value, u, source: Source::Stated });
            match &estimated.role {
                Role::Estimated { prior: Some(prior), .. } => stated(prior.value, prior.u),
                Role::Known(known) if known.u > 0.0 => stated(known.value, known.u),
                Role::Estimated { .. } => {
                    let value = estimated.reference();
                    let (value, u, source) = match (limits(campaign, parameter), estimated.kind) {
                        (Some((centre, u)), _) => (centre, u, Source::Stated),
                        (None, Kind::Tilt) => (value, tilts, Source::Supposed),
                        (None, _) => (value, 1.0, Source::Nothing),
                    };
                    Some(Belief { parameter, value, u, source })
                }
                _ => None,
            }
        };
        let mut all = Beliefs(campaign.parameters.iter().enumerate().filter_map(of).collect());
        let rows = Rows::of(campaign, &all, positions, &all.point(campaign), noise)?;
        for (k, belief) in all.0.iter_mut().enumerate().filter(|(_, belief)| belief.source == Source::Nothing) {
            let size = rows.slopes.iter().fold(0.0_f64, |most, row| most.max(row[k].abs()));
            belief.u = LOOSE / if size > 0.0 { size } else { 1.0 };
        }
        Ok(all)
    }

    /// The point of all parameters that is believed.
    pub fn point(&self, campaign: &Campaign) -> Vec<f64> {
        let mut point = campaign.reference_point();
        for belief in &self.0 {
            point[belief.parameter] = belief.value;
        }
        point
    }

    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// A direction along parameters as one along `z`.
    pub fn along(&self, direction: &[f64]) -> Vec<f64> {
        self.0.iter().map(|belief| belief.u * direction.get(belief.parameter).copied().unwrap_or(0.0)).collect()
    }

    /// What is believed, from a point on.
    fn centre(&self, point: &[f64]) -> Vec<f64> {
        let of = |belief: &Belief| match belief.source {
            Source::Nothing => 0.0,
            _ => (belief.value - point[belief.parameter]) / belief.u,
        };
        self.0.iter().map(of).collect()
    }

    fn moved(&self, point: &[f64], z: &[f64], step: f64) -> Vec<f64> {
        let mut point = point.to_vec();
        for (belief, z) in self.0.iter().zip(z) {
            point[belief.parameter] += step * belief.u * z;
        }
        point
    }
}

/// Centre and standard deviation of a parameter within limits: uniform between bounds, or within a ball.
fn limits(campaign: &Campaign, parameter: usize) -> Option<(f64, f64)> {
    campaign.constraints.iter().find_map(|constraint| match constraint {
        Constraint::Linear { terms, lower, upper } => match terms.as_slice() {
            [(k, factor)] if *k == parameter && lower < upper && (upper - lower).is_finite() => {
                Some(((lower + upper) / (2.0 * factor), (upper - lower) / (12.0_f64.sqrt() * factor.abs())))
            }
            _ => None,
        },
        Constraint::Norm { of, at_most } if of.contains(&parameter) && *at_most > 0.0 => {
            Some((0.0, at_most / (of.len() as f64 + 2.0).sqrt()))
        }
        _ => None,
    })
}

/// Rows about a point (`design.rows` says whose): what each value differs from the model there, and how the model's value follows the unknowns; both independent and of unit
/// variance.
#[derive(Debug, Clone)]
pub(super) struct Rows {
    /// By unknown, for each row.
    pub slopes: Vec<Vec<f64>>,
    /// Value less prediction; zero where nothing was read.
    pub white_residual: Vec<f64>,
    /// The same in the sensor's unit, as it was read.
    pub residual: Vec<f64>,
    /// Standard deviations of the values alone.
    pub sd: Vec<f64>,
    pub design: DesignMatrix,
    whitening: Option<Whitening>,
}

impl Rows {
    /// Of these readings; where none has a value, of every sensor at each position.
    pub fn of(
        campaign: &Campaign,
        beliefs: &Beliefs,
        readings: &[Reading],
        point: &[f64],
        noise: &Noise,
    ) -> Result<Self> {
        Rows::stepped(campaign, beliefs, readings, (point, point, usize::MAX), noise)
    }

    /// The same with another point from reading `from` on.
    pub(crate) fn stepped(
        campaign: &Campaign,
        beliefs: &Beliefs,
        readings: &[Reading],
        (point, later, from): (&[f64], &[f64], usize),
        noise: &Noise,
    ) -> Result<Self> {
        let part =
            campaign.with_readings(Readings { columns: campaign.readings.columns.clone(), rows: readings.to_vec() });
        let model = Model::new(&part)?;
        let mut design = design::assemble(&part, &model, point)?;
        if from < readings.len() {
            let then = design::assemble(&part, &model, later)?;
            for i in (0..design.rows.len()).filter(|i| design.rows[*i].reading >= from) {
                design.predicted[i] = then.predicted[i];
                (0..design.jacobian.ncols()).for_each(|k| design.jacobian[(i, k)] = then.jacobian[(i, k)]);
            }
        }
        let reading = |origin: &RowOrigin| readings.get(origin.reading);
        let sd: Vec<f64> = design.rows.iter().map(|o| reading(o).map_or(1.0, |r| noise.u(r, o.sensor))).collect();
        let value =
            |o: &RowOrigin| reading(o)?.observations.iter().find(|seen| seen.sensor == o.sensor).map(|seen| seen.value);
        let residual: Vec<f64> =
            design.rows.iter().zip(&design.predicted).map(|(o, f)| value(o).map_or(0.0, |y| y - f)).collect();
        let whitening = (!part.scatter.is_empty()).then(|| fit::whitening(&part, &design, &sd, &noise.lines));
        let mut rows = Rows { slopes: Vec::new(), white_residual: Vec::new(), residual, sd, design, whitening };
        let columns: Vec<Vec<f64>> = beliefs.0.iter().map(|belief| rows.along(belief.parameter, belief.u, 0)).collect();
        rows.slopes = (0..rows.sd.len()).map(|i| columns.iter().map(|column| column[i]).collect()).collect();
        rows.white_residual = rows.white(rows.residual.clone());
        Ok(rows)
    }

    /// A column over the rows, made independent as the rows are.
    pub(crate) fn white(&self, mut column: Vec<f64>) -> Vec<f64> {
        match &self.whitening {
            Some(whitening) => whitening.whiten(&column),
            None => {
                column.iter_mut().zip(&self.sd).for_each(|(value, sd)| *value /= sd);
                column
            }
        }
    }

    /// How the rows follow a parameter that is `size` larger from reading `from` on.
    pub(crate) fn along(&self, parameter: usize, size: f64, from: usize) -> Vec<f64> {
        let of = |(i, origin): (usize, &RowOrigin)| match origin.reading >= from {
            true => size * self.design.jacobian[(i, parameter)],
            false => 0.0,
        };
        self.white(self.design.rows.iter().enumerate().map(of).collect())
    }

    /// Their posterior, with further unknowns in addition to the beliefs: columns for one standard deviation of each.
    pub(crate) fn told(&self, beliefs: &Beliefs, point: &[f64], further: &[Vec<f64>]) -> Option<Told> {
        self.posterior_about(beliefs, point, further, &vec![0.0; further.len()])
    }

    /// The same about values of the further unknowns that the rows have already, in their standard deviations.
    fn posterior_about(&self, beliefs: &Beliefs, point: &[f64], further: &[Vec<f64>], have: &[f64]) -> Option<Told> {
        let mut centre = beliefs.centre(point);
        centre.extend(have.iter().map(|offset| -offset));
        let with = |(i, row): (usize, &Vec<f64>)| -> Vec<f64> {
            row.iter().copied().chain(further.iter().map(|column| column[i])).collect()
        };
        let log_volume = self
            .whitening
            .as_ref()
            .map_or_else(|| 2.0 * self.sd.iter().map(|sd| sd.ln()).sum::<f64>(), Whitening::log_determinant);
        let rows: Vec<Vec<f64>> = self.slopes.iter().enumerate().map(with).collect();
        Told::new(&rows, &self.white_residual, &centre)
            .map(|posterior| Told { log_density: posterior.log_density - 0.5 * log_volume, ..posterior })
    }
}

/// What rows tell of the unknowns.
#[derive(Debug, Clone)]
pub(super) struct Told {
    factor: Triangle,
    /// The most probable `z`, from the point.
    pub estimate: Vec<f64>,
    /// `|r|^2 + |c|^2` at the point itself.
    pub target: f64,
    /// What the step to the estimate takes off it, `z' M z`.
    promised: f64,
    /// `ln p` of the readings.
    pub log_density: f64,
}

impl Told {
    /// From rows that are independent and of unit variance, with the centre of what is believed.
    fn new(rows: &[Vec<f64>], residual: &[f64], centre: &[f64]) -> Option<Self> {
        let n = centre.len();
        let mut information = vec![vec![0.0; n]; n];
        let mut right = centre.to_vec();
        for (row, residual) in rows.iter().zip(residual) {
            for a in 0..n {
                right[a] += row[a] * residual;
                for b in 0..=a {
                    information[a][b] += row[a] * row[b];
                }
            }
        }
        let factor = Triangle::of(n, |a, b| information[a][b] + f64::from(u8::from(a == b)), |_| 0.0)?;
        let estimate = factor.solve(&right);
        let target = dot(residual, residual) + dot(centre, centre);
        let promised = dot(&right, &estimate);
        let log_density = -0.5 * (target - promised + factor.log_determinant());
        log_density.is_finite().then_some(Told { factor, estimate, target, promised, log_density })
    }

    /// Of rows without values.
    pub fn of(beliefs: &Beliefs, rows: &[Vec<f64>]) -> Option<Self> {
        Told::new(rows, &vec![0.0; rows.len()], &vec![0.0; beliefs.count()])
    }

    /// `L^-1 a`, so that `a' C b` is a product of two of them.
    pub fn through(&self, along: &[f64]) -> Vec<f64> {
        let mut solved = along.to_vec();
        self.factor.forward(&mut solved);
        solved
    }

    /// `a' C a`.
    pub fn variance(&self, along: &[f64]) -> f64 {
        let scaled = self.through(along);
        dot(&scaled, &scaled)
    }

    /// `C A' f`: what rows with these residuals would be estimated as.
    pub fn solved(&self, rows: &[Vec<f64>], column: &[f64]) -> Vec<f64> {
        let n = self.estimate.len();
        let right: Vec<f64> = (0..n).map(|k| rows.iter().zip(column).map(|(row, f)| row[k] * f).sum()).collect();
        self.factor.solve(&right)
    }

    /// `a' C a`, and the part of it that is due to beliefs from these sources.
    pub fn variance_from(&self, beliefs: &Beliefs, along: &[f64], sources: &[Source]) -> (f64, f64) {
        let solved = self.factor.solve(along);
        let from = beliefs.0.iter().zip(&solved).filter(|(belief, _)| sources.contains(&belief.source));
        (dot(along, &solved), from.map(|(_, y)| y * y).sum())
    }

    /// Do the readings, more than what was supposed, determine this direction?
    pub fn determines(&self, beliefs: &Beliefs, along: &[f64]) -> bool {
        let (variance, supposed) = self.variance_from(beliefs, along, &[Source::Supposed, Source::Nothing]);
        supposed < 0.5 * variance
    }
}

/// A parameter that is larger from a reading on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    pub parameter: usize,
    pub from: usize,
    /// Standard deviation that is believed of it; nothing is nearer than zero.
    pub size: f64,
}

/// Readings with their most probable point, and how large a step in them most probably is.
#[derive(Debug, Clone)]
pub(super) struct Solved {
    pub point: Vec<f64>,
    pub rows: Rows,
    pub posterior: Told,
    by: f64,
}

/// Most steps to the most probable point, halved ones among them.
const STEPS: usize = 40;
/// A step that promises no more than this of the sum of squares ends the search.
const ENOUGH: f64 = 1e-6;

impl Solved {
    /// The most probable point near `start`, by Gauss-Newton steps that are halved while they lead up. `None` where numbers leave their range.
    pub(crate) fn new(judge: Judge, readings: &[Reading], start: &[f64], step: Option<Step>) -> Result<Option<Self>> {
        let Judge { model, beliefs, noise, .. } = judge;
        let at = |point: Vec<f64>, by: f64| -> Result<Option<Self>> {
            let mut later = point.clone();
            let from = step.map_or(usize::MAX, |shift| shift.from);
            step.iter().for_each(|shift| later[shift.parameter] += by);
            let rows = Rows::stepped(model, beliefs, readings, (&point, &later, from), noise)?;
            let column = step.map(|shift| rows.along(shift.parameter, shift.size, shift.from));
            let posterior = match (&column, step) {
                (Some(column), Some(shift)) => {
                    rows.posterior_about(beliefs, &point, std::slice::from_ref(column), &[by / shift.size])
                }
                _ => rows.told(beliefs, &point, &[]),
            };
            Ok(posterior.map(|posterior| Solved { point, rows, posterior, by }))
        };
        let Some(mut best) = at(start.to_vec(), 0.0)? else { return Ok(None) };
        let mut share = 1.0;
        for _ in 0..STEPS {
            if best.posterior.promised < ENOUGH {
                break;
            }
            let more = step.zip(best.posterior.estimate.last()).map_or(0.0, |(shift, z)| share * shift.size * z);
            match at(beliefs.moved(&best.point, &best.posterior.estimate, share), best.by + more)? {
                Some(next) if next.posterior.target <= best.posterior.target => {
                    (best, share) = (next, (2.0 * share).min(1.0))
                }
                _ => share *= 0.5,
            }
        }
        Ok(Some(best))
    }

    /// `ln p` of the readings with a step; `None` where no reading shows it.
    pub(crate) fn log_density_with(&self, beliefs: &Beliefs, step: Step) -> Option<f64> {
        let column = self.rows.along(step.parameter, step.size, step.from);
        let shows = column.iter().any(|value| *value != 0.0);
        let posterior = || self.rows.posterior_about(beliefs, &self.point, &[column], &[self.by / step.size]);
        shows.then(posterior).flatten().map(|posterior| posterior.log_density)
    }
}

/// The model that readings are judged by.
#[derive(Clone, Copy)]
pub(super) struct Judge<'a> {
    pub model: &'a Campaign,
    pub beliefs: &'a Beliefs,
    pub noise: &'a Noise,
    /// The most probable point of all readings; empty where it is not known yet.
    pub point: &'a [f64],
}

impl Judge<'_> {
    /// The most probable point of these readings.
    pub fn solved(&self, readings: &[Reading]) -> Result<Option<Solved>> {
        let start = if self.point.is_empty() { &self.beliefs.point(self.model) } else { self.point };
        Solved::new(*self, readings, start, None)
    }

    /// `ln p` of readings about a point.
    pub fn log_density(&self, readings: &[Reading], point: &[f64]) -> Result<Option<f64>> {
        let rows = Rows::of(self.model, self.beliefs, readings, point, self.noise)?;
        Ok(rows.told(self.beliefs, point, &[]).map(|posterior| posterior.log_density))
    }
}

/// The same setting, whole turns apart or not.
pub(super) fn same_state(a: &JointState, b: &JointState) -> bool {
    match (a, b) {
        (JointState::Held { angle_deg: a }, JointState::Held { angle_deg: b }) => {
            let apart = (a - b).rem_euclid(360.0);
            apart.min(360.0 - apart) < 1e-9
        }
        _ => a == b,
    }
}
