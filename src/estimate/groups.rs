//! Scales of several groups of readings whose standard uncertainties are known only relative to each other: the top of their restricted likelihood
//! (`scatter/restricted.rs`), in the few rows to which each group is compressed.
#![allow(
    clippy::indexing_slicing,
    reason = "`Compressed` has a block and a range for each group, and behind them for the known ones"
)]

use super::compress::{Block, Compressed, Scaled, gram};
use super::factor::Factor;
use super::scatter::chain::Part as NoisePart;
use super::scatter::restricted::NoiseModel;
use super::unknowns::Unknowns;
use super::{Group, Settings};
use crate::error::Result;
use faer::Mat;
use std::ops::Range;

/// Scales of the groups: `None` for a group without redundancy of its own, and how the iteration went.
pub(super) struct Scales {
    pub scale: Vec<Option<f64>>,
    pub iterations: usize,
    pub converged: bool,
}

impl Scales {
    /// Of groups whose scales change no weight relative to another.
    pub(super) fn none(count: usize) -> Self {
        Scales { scale: vec![None; count], iterations: 0, converged: true }
    }

    /// The scales as they enter the weights: a group without redundancy keeps its relative ones.
    pub(super) fn entering(&self) -> Vec<f64> {
        self.scale.iter().map(|scale| scale.unwrap_or(1.0)).collect()
    }
}

/// What is known of the groups' scales beforehand, one number for each group; empty where nothing is.
#[derive(Debug, Clone, Copy, Default)]
pub struct ScaleHints<'a> {
    /// Where the iteration begins: the scales of a system like this one.
    pub start: &'a [f64],
    /// What a scale is at least: the rounding or the resolution of the observations as they were before a prediction was subtracted.
    pub least: &'a [f64],
    /// The scales themselves, where more than these rows tells them; empty where these rows are to.
    pub given: &'a [Option<f64>],
}

/// A group with less redundancy than this has none.
pub(crate) const NO_REDUNDANCY: f64 = 1e-9;
/// Residuals below this share of a group's largest observation are the rounding of the arithmetic: its scale is this share at least.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Number of groups with an estimated scale: one more than the largest number in use.
pub(super) fn count(group: &[Group]) -> usize {
    group.iter().filter_map(|group| group.estimated()).max().map_or(0, |g| g + 1)
}

/// The scales as they are given, or those of these rows.
pub(super) fn scales(rows: &Compressed, hints: &ScaleHints<'_>, settings: &Settings) -> Result<Scales> {
    match hints.given {
        [] => estimate(rows, hints, settings),
        given => Ok(Scales { scale: given.to_vec(), iterations: 1, converged: true }),
    }
}

/// The scales, beginning with what each group's own best fit leaves, or with what is said of them beforehand.
fn estimate(rows: &Compressed, hints: &ScaleHints<'_>, settings: &Settings) -> Result<Scales> {
    let count = rows.groups;
    let largest = rows.blocks.iter().fold(0.0_f64, |most, own| most.max(own.magnitude));
    let least: Vec<f64> = (0..count)
        .map(|g| {
            let size = [rows.blocks[g].magnitude, f64::EPSILON * largest, f64::EPSILON];
            // the last size is above zero
            let arithmetic = ROUNDING * size.into_iter().find(|y| *y > 0.0).unwrap_or(1.0);
            let stated = hints.least.get(g).copied().unwrap_or(0.0); // no hint: no floor
            arithmetic.max(stated).powi(2).max(f64::MIN_POSITIVE)
        })
        .collect();
    let own = |g: usize| rows.blocks[g].own.filter(|(_, dof)| *dof > 0).map(|(squares, dof)| squares / dof as f64);
    let (mut sum, mut known) = (0.0, 0);
    for variance in (0..count).filter_map(own) {
        sum += variance;
        known += 1;
    }
    let other = if known > 0 && sum > 0.0 { sum / f64::from(known) } else { 1.0 };
    let begin = |g: usize| hints.start.get(g).map(|s| s * s).or_else(|| own(g)).unwrap_or(other);
    let mut variance: Vec<f64> = (0..count).map(|g| begin(g).max(least[g])).collect();
    let (mut free, mut parts) = parts(rows, &variance, settings)?;
    if free.len() < count {
        // weights as given where there is nothing to go by
        (0..count).filter(|g| !free.contains(g)).for_each(|g| variance[g] = 1.0);
        (free, parts) = self::parts(rows, &variance, settings)?;
    }
    variance.resize(parts.len(), 1.0);
    let top = NoiseModel::scales(&parts, &mut variance, (&free, &least), settings.group_iterations)?;
    let scale = (0..count).map(|g| free.contains(&g).then(|| variance[g].sqrt())).collect();
    Ok(Scales { scale, iterations: top.iterations, converged: top.converged })
}

/// The groups with redundancy of their own, and every group's sums in the directions of the unknowns at some variances.
fn parts(rows: &Compressed, variance: &[f64], settings: &Settings) -> Result<(Vec<usize>, Vec<NoisePart>)> {
    let factor = rows.factor(|g| variance[g].sqrt(), settings)?;
    let residuals = rows.solve(&factor, 1).residuals;
    let rank = factor.rank();
    let (mut free, mut parts) = (Vec::new(), Vec::with_capacity(rows.range.len()));
    for (g, (range, block)) in rows.range.iter().zip(&rows.blocks).enumerate() {
        let own = sums(&factor, &residuals, &range.clone().collect::<Vec<usize>>());
        let leverage: f64 = (0..rank).map(|j| own[(j, j)]).sum();
        if g < variance.len() && block.size as f64 - leverage > NO_REDUNDANCY {
            free.push(g);
        }
        // of rows as they were before the weights
        let unit = variance.get(g).copied().unwrap_or(1.0);
        parts.push(NoisePart::white(block.size as f64, block.log_determinant, own * faer::Scale(unit)));
    }
    Ok((free, parts))
}

/// Products of the orthonormal columns and the residuals, over some of the weighted rows.
pub(super) fn sums(factor: &Factor, residuals: &[f64], rows: &[usize]) -> Mat<f64> {
    let (q, weight) = (&factor.q, &factor.weight);
    let own = |i: usize, j: usize| if j < q.ncols() { q[(rows[i], j)] } else { residuals[rows[i]] * weight[rows[i]] };
    gram(&Mat::from_fn(rows.len(), q.ncols() + 1, own))
}

impl Compressed {
    /// Everything that the rows say of the unknowns, with estimated scales. Errors: those of [`super::adjust`].
    pub fn adjust(&self, hints: &ScaleHints<'_>, settings: &Settings) -> Result<Scaled> {
        let scales = match self.groups {
            0 => Scales::none(0),
            _ => self::scales(self, hints, settings)?,
        };
        let scale = scales.entering();
        let factor = self.factor(|g| scale[g], settings)?;
        let found = self.solve(&factor, settings.refinements);
        let leverage = factor.leverages();
        let own = |(block, range): (&Block, &Range<usize>)| {
            (block.size as f64 - leverage[range.clone()].iter().sum::<f64>()).max(0.0)
        };
        Ok(Scaled {
            sum_of_squares: found.residuals.iter().zip(&factor.weight).map(|(v, w)| (v * w).powi(2)).sum(),
            unknowns: Unknowns::new(&factor, found.solution, 1.0, |_| true),
            redundancy: self.blocks.iter().zip(&self.range).map(own).collect(),
            settled: scales.converged,
            scale,
            factor,
        })
    }
}
