//! One question about measured navigation errors: its linear system, its noise, and one search of it.

use super::diagnose::Gap;
use super::errors::{ImuErrors, Kind, Source};
use super::measured::{CHANNELS, Measured};
use super::mission::Mission;
use super::signatures::System;
use super::whiten::whiten;
use crate::diagnosis::plain::{self, Answer, Question};
use crate::diagnosis::{NoiseFrom, Settings};
use crate::error::{Fault, Malformed, Result};
use crate::estimate::{self, Fold, Group};
use crate::uncertainty::quantiles::chi_square_survival;
use faer::Mat;

/// An error that even at its largest admissible size stays below so many standard deviations cannot be seen.
const UNSEEN: f64 = 5.0;

/// One question, and what is common to all passes.
pub(super) struct Case<'a> {
    pub mission: &'a Mission,
    pub measured: &'a Measured,
    pub sources: Vec<Source>,
    pub system: System,
    pub values: Vec<f64>,
    pub channel: Vec<usize>,
    pub from: NoiseFrom,
    pub settings: Settings,
}

impl<'a> Case<'a> {
    pub fn new(mission: &'a Mission, measured: &'a Measured, settings: &Settings) -> Result<Self> {
        if !(settings.significance > 0.0 && settings.significance < 1.0) {
            return Err(Malformed::new(Fault::Value, "the significance is no probability")
                .expected("a number between 0 and 1, for example 0.01")
                .found(settings.significance.to_string()));
        }
        let stated = measured.cells().all(|cell| cell.u.is_some());
        if mission.errors.is_noisy() && !stated {
            return Err(Malformed::new(Fault::Missing, "random walks and unknown noise cannot be told apart")
                .expected("a standard uncertainty (a column with _u) of everything measured, or a mission without random walks"));
        }
        Ok(Case {
            mission,
            measured,
            sources: Source::catalogue(),
            system: System::new(mission, measured),
            values: measured.cells().map(|cell| cell.value).collect(),
            channel: measured.cells().map(|cell| cell.channel).collect(),
            from: if stated { NoiseFrom::Stated } else { NoiseFrom::Residuals },
            settings: *settings,
        })
    }

    /// Stated standard uncertainties; where there are none, the gap's own size.
    pub fn first_u(&self, gap: &[f64]) -> Vec<f64> {
        let sizes = self.sizes(gap, 0);
        self.measured.cells().map(|cell| cell.u.unwrap_or(sizes[cell.channel.min(CHANNELS - 1)])).collect()
    }

    /// The same from what a fit left; no less than what rounding makes of the gap.
    pub fn u_of(&self, left: &[f64], fitted: usize, gap: &[f64]) -> Vec<f64> {
        let (sizes, first) = (self.sizes(left, fitted), self.sizes(gap, 0));
        let of = |channel: usize| sizes[channel].max(1e-9 * first[channel]);
        self.measured.cells().map(|cell| cell.u.unwrap_or(of(cell.channel.min(CHANNELS - 1)))).collect()
    }

    /// Root mean square of each channel, less the share of degrees of freedom that a fit took.
    pub fn sizes(&self, values: &[f64], fitted: usize) -> [f64; CHANNELS] {
        let mut sums = [(0.0, 0.0); CHANNELS];
        for (value, channel) in values.iter().zip(&self.channel) {
            sums.get_mut(*channel).into_iter().for_each(|(sum, count)| {
                *sum += value * value;
                *count += 1.0;
            });
        }
        let kept = 1.0 - (fitted as f64 / self.values.len().max(1) as f64).min(0.9);
        sums.map(|(sum, count): (f64, f64)| if sum > 0.0 { (sum / (count * kept)).sqrt() } else { 1.0 })
    }

    /// The mission's errors with a change.
    pub fn with(&self, change: &[f64]) -> ImuErrors {
        let mut errors = self.mission.errors;
        for (source, value) in self.sources.iter().zip(change).filter(|(_, value)| **value != 0.0) {
            source.set(&mut errors, source.of(&self.mission.errors) + value);
        }
        errors
    }

    /// `measured - predicted + J change`: the gap as a linear model through the point that was simulated.
    pub fn laid(&self, predicted: &[f64], change: &[f64]) -> Vec<f64> {
        let mut laid: Vec<f64> = self.values.iter().zip(predicted).map(|(y, p)| y - p).collect();
        for (column, value) in self.system.columns.iter().zip(change).filter(|(_, value)| **value != 0.0) {
            laid.iter_mut().zip(column).for_each(|(y, c)| *y += c * value);
        }
        laid
    }

    pub fn as_change(&self, set: &[usize], fit: &[(f64, f64)]) -> Vec<f64> {
        let mut change = vec![0.0; self.sources.len()];
        for (j, (value, _)) in set.iter().zip(fit) {
            change.get_mut(*j).into_iter().for_each(|slot| *slot = *value);
        }
        change
    }

    /// Would the mission still be one?
    pub fn is_possible(&self, set: &[usize], fit: &[(f64, f64)]) -> bool {
        set.iter().zip(fit).all(|(j, (value, _))| !self.is_absurd(*j, *value))
    }

    pub fn is_absurd(&self, index: usize, value: f64) -> bool {
        self.sources
            .get(index)
            .is_none_or(|source| !((source.of(&self.mission.errors) + value).abs() <= source.limit()))
    }

    /// One search with the noise and the linear model as they are.
    pub fn look(&self, u: &[f64], laid: &[f64]) -> Result<Look> {
        let mut columns = self.system.columns.clone();
        columns.push(laid.to_vec());
        whiten(self.measured, &self.system.walks, u, &mut columns);
        let mut invisible = Vec::new();
        let mut scale = Vec::with_capacity(columns.len());
        for (j, column) in columns.iter_mut().enumerate() {
            let norm = column.iter().map(|v| v * v).sum::<f64>().sqrt();
            if let Some(source) = self.sources.get(j)
                && !(norm * source.limit() > UNSEEN)
            {
                invisible.push(*source);
                column.fill(0.0);
            }
            let size = if norm > 0.0 && j < self.sources.len() { norm } else { 1.0 };
            column.iter_mut().for_each(|v| *v /= size);
            scale.push(size);
        }
        let triangle = fold(&columns)?;
        let k = self.sources.len();
        let column = |j: usize| (0..=k).map(|i| triangle[(i, j)]).collect::<Vec<f64>>();
        let folded: Vec<Vec<f64>> = (0..k).map(column).collect();
        let residual = column(k);
        let handicap: Vec<f64> = self
            .sources
            .iter()
            .enumerate()
            .map(|(j, source)| {
                let own = folded.get(j).map(Vec::as_slice).unwrap_or_default();
                let square: f64 = own.iter().map(|v| v * v).sum();
                let along: f64 = own.iter().zip(&residual).map(|(a, b)| a * b).sum();
                let alone = if square > 0.0 { along / square / scale.get(j).copied().unwrap_or(1.0) } else { 0.0 };
                0.4 * rank(source) + if self.is_absurd(j, alone) { 5.0 } else { 0.0 }
            })
            .collect();
        let answer = plain::search(&Question {
            columns: &folded,
            residual: &residual,
            rows: self.values.len(),
            from: self.from,
            handicap: &handicap,
            significance: self.settings.significance,
        })?;
        Ok(Look { answer, folded, residual, scale, invisible })
    }

    pub fn gap(&self, left: &[f64], u: &[f64], fitted: usize) -> Gap {
        let mut columns = [left.to_vec()];
        whiten(self.measured, &self.system.walks, u, &mut columns);
        let [white] = columns;
        let chi_square: f64 = white.iter().map(|v| v * v).sum();
        let dof = white.len().saturating_sub(fitted);
        let max = white.iter().fold(0.0_f64, |max, v| max.max(v.abs()));
        let stated = self.from == NoiseFrom::Stated && dof > 0;
        let p = if stated { chi_square_survival(chi_square, dof as f64) } else { None };
        Gap { rms: (chi_square / dof.max(1) as f64).sqrt(), max, chi_square, dof, p }
    }
}

/// One search: its answer, and the folded system that it looked at.
pub(super) struct Look {
    pub answer: Answer,
    /// Weighted columns of all sources, folded and scaled; zero where nothing can be seen.
    pub folded: Vec<Vec<f64>>,
    pub residual: Vec<f64>,
    /// What each column was divided by.
    pub scale: Vec<f64>,
    pub invisible: Vec<Source>,
}

impl Look {
    /// What was found, or what came nearest.
    pub fn set(&self) -> Vec<usize> {
        match &self.answer.verdict {
            plain::Verdict::Nothing => Vec::new(),
            plain::Verdict::Found(members) => members.iter().map(|member| member.index).collect(),
            plain::Verdict::Partly(members, nearest, _) => {
                members.iter().map(|member| member.index).chain(nearest.iter().copied()).collect()
            }
            plain::Verdict::Unexplained(nearest, _) => nearest.clone(),
        }
    }

    /// Least squares of some sources alone: value and standard uncertainty of each, SI; `None` where they are not independent.
    pub fn fit(&self, set: &[usize]) -> Option<Vec<(f64, f64)>> {
        let columns: Option<Vec<&Vec<f64>>> = set.iter().map(|j| self.folded.get(*j)).collect();
        let columns = columns?;
        let m = self.residual.len();
        let rows = Mat::from_fn(m, columns.len(), |i, j| columns.get(j).and_then(|c| c.get(i)).copied().unwrap_or(0.0));
        let system =
            estimate::System { rows, observed: self.residual.clone(), u: vec![1.0; m], group: vec![Group::Known; m] };
        let estimate = estimate::adjust(&system, &estimate::Settings::default()).ok()?;
        if estimate.rank < set.len() {
            return None;
        }
        let scale = |k: usize| set.get(k).and_then(|j| self.scale.get(*j)).copied().unwrap_or(1.0);
        let pairs = estimate.solution.iter().zip(&estimate.standard_uncertainty).enumerate();
        Some(pairs.map(|(k, (value, u))| (value / scale(k), u.unwrap_or(f64::INFINITY) / scale(k))).collect())
    }
}

/// Order among errors that the data cannot tell apart: the most common first.
pub(super) fn rank(source: &Source) -> f64 {
    match source.kind {
        Kind::Bias => 0.0,
        Kind::ScaleFactor | Kind::Installation => 1.0,
        Kind::Attitude => 2.0,
        Kind::Velocity | Kind::Position => 3.0,
        Kind::SecondOrder => 4.0,
    }
}

/// The triangle that has the inner products of all columns.
fn fold(columns: &[Vec<f64>]) -> Result<Mat<f64>> {
    let (observed, unknowns) = match columns.split_last() {
        Some((last, others)) => (last.as_slice(), others),
        None => (&[][..], &[][..]),
    };
    let mut fold = Fold::new(unknowns.len());
    let block = 4 * columns.len().max(1);
    for (at, part) in observed.chunks(block).enumerate() {
        let value = |i: usize, j: usize| unknowns.get(j).and_then(|c| c.get(at * block + i)).copied().unwrap_or(0.0);
        let rows = Mat::from_fn(part.len(), unknowns.len(), value);
        fold.push(rows.as_ref(), part, &vec![1.0; part.len()])?;
    }
    Ok(fold.triangle().to_owned())
}
