//! Each group's rows turned among themselves until a triangle says the same, `Q_g' [A_g y_g] / u = [R z; 0 rho; 0 0]`; and in these few rows the scales of several
//! groups whose standard uncertainties are known only relative to each other: the top of their restricted likelihood (`scatter/restricted.rs`).
//!
//! An orthogonal change within a group alters neither the solution nor the group's sum of squares nor its share of the information, whatever
//! its scale. So the scales, and steps that need the solution alone, work on a few dozen rows instead of all; of a record that is streamed there are no others.
#![allow(
    clippy::indexing_slicing,
    reason = "`adjust` runs `System::check` first: one observed value, u and group for each row, and `count` is above every group's number; blocks have as many columns, and there is one, with a range, for each group and behind them for the known ones"
)]

use super::factor::{Factor, Refined, Unknowns};
use super::fold::{Fold, triangle_of};
use super::scatter::chain::Part as NoisePart;
use super::scatter::restricted::NoiseModel;
use super::{Group, Settings, System};
use crate::error::Result;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use std::ops::Range;

/// Rows that say the same as those of a group.
#[derive(Debug, Clone)]
pub(crate) struct Block {
    /// Derivatives by the unknowns, over the rows' standard uncertainties; columns that are carried along may follow.
    pub rows: Mat<f64>,
    pub observed: Vec<f64>,
    /// How many rows the group had.
    pub size: usize,
    /// `rho^2` and its degrees of freedom, what the group's own best fit leaves, where the group has more rows than columns.
    pub own: Option<(f64, usize)>,
    /// Largest `|y / u|`.
    pub magnitude: f64,
    /// `ln |V|` of the noise that the rows were divided by.
    pub log_determinant: f64,
}

impl Block {
    /// Single unknowns of so many columns, each with its value and the standard uncertainty of that.
    pub fn stated(columns: usize, values: &[(usize, f64, f64)]) -> Self {
        let of = |i: usize, j: usize| values.get(i).filter(|(k, ..)| *k == j).map_or(0.0, |(.., u)| 1.0 / u);
        Block {
            rows: Mat::from_fn(values.len(), columns, of),
            observed: values.iter().map(|(_, value, u)| value / u).collect(),
            size: values.len(),
            own: None,
            magnitude: 0.0,
            log_determinant: 0.0,
        }
    }

    /// The triangle of a fold, observations about its point.
    pub fn folded(fold: &Fold) -> Self {
        let (triangle, n) = (fold.triangle(), fold.unknowns());
        let last = triangle.ncols() - 1;
        let observed: Vec<f64> = triangle.col(last).iter().copied().collect();
        let dof = fold.rows().saturating_sub(n);
        let own = (dof > 0).then(|| (observed[n..].iter().map(|rho| rho * rho).sum(), dof));
        let rows = triangle.subcols(0, last).to_owned();
        Block { rows, observed, size: fold.rows(), own, magnitude: 0.0, log_determinant: 0.0 }
    }

    /// What the rows say in some directions of the unknowns, a step away.
    pub fn part(&self, directions: &Mat<f64>, step: &[f64]) -> NoisePart {
        let rows = crate::linear::turned(&self.rows, &self.observed, directions, step);
        NoisePart::white(self.size as f64, self.log_determinant, gram(&rows))
    }
}

/// The rows of a system, group by group; behind those whose scale is estimated come those of known uncertainty.
pub(crate) struct Compressed {
    rows: Mat<f64>,
    observed: Vec<f64>,
    /// Which of the rows belong to each block.
    pub range: Vec<Range<usize>>,
    pub blocks: Vec<Block>,
    /// How many groups have a scale that is estimated.
    pub groups: usize,
    total: usize,
}

/// What compressed rows say of the unknowns.
pub(crate) struct Scaled {
    pub unknowns: Unknowns,
    pub sum_of_squares: f64,
    pub factor: Factor,
    /// Scale of each estimated group, 1 where there is none to be known.
    pub scale: Vec<f64>,
    /// Redundancy of each block.
    pub redundancy: Vec<f64>,
    /// Did the scales settle?
    pub settled: bool,
}

impl Compressed {
    /// Compresses a system with `count` estimated groups.
    pub fn new(system: &System, count: usize) -> Self {
        let n = system.rows.ncols();
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); count + 1];
        for (i, group) in system.group.iter().enumerate() {
            members[group.estimated().unwrap_or(count)].push(i);
        }
        let block = |rows: Vec<usize>| {
            let is_used = |j: &usize| rows.iter().any(|i| system.rows[(*i, *j)] != 0.0);
            let columns: Vec<usize> = (0..n).filter(is_used).collect();
            let k = columns.len();
            let element = |i: usize, l: usize| {
                let row = rows[i];
                columns.get(l).map_or(system.observed[row], |j| system.rows[(row, *j)]) / system.u[row]
            };
            let magnitude = (0..rows.len()).fold(0.0_f64, |most, i| most.max(element(i, k).abs()));
            let (folded, own) = match rows.len() > k + 1 {
                true => {
                    let folded = triangle_of(rows.len(), k + 1, element);
                    let own = (folded[(k, k)].powi(2), rows.len() - k);
                    (folded, Some(own))
                }
                false => (Mat::from_fn(rows.len(), k + 1, element), None),
            };
            let mut all = Mat::zeros(folded.nrows(), n);
            for (l, j) in columns.iter().enumerate() {
                all.col_as_slice_mut(*j).copy_from_slice(folded.col_as_slice(l));
            }
            let observed = folded.col_as_slice(k).to_vec();
            Block { rows: all, observed, size: rows.len(), own, magnitude, log_determinant: 0.0 }
        };
        Compressed::of(members.into_iter().map(block).collect(), n, count)
    }

    /// Of blocks in `n` unknowns, the first of which have a scale that is estimated.
    pub fn of(blocks: Vec<Block>, n: usize, groups: usize) -> Self {
        let kept = blocks.iter().map(|block| block.rows.nrows()).sum();
        let (mut rows, mut observed, mut range) = (Mat::zeros(kept, n), Vec::with_capacity(kept), Vec::new());
        for block in &blocks {
            let own = observed.len()..observed.len() + block.rows.nrows();
            rows.subrows_mut(own.start, own.len()).copy_from(block.rows.subcols(0, n));
            observed.extend(&block.observed);
            range.push(own);
        }
        let total = blocks.iter().map(|block| block.size).sum();
        Compressed { rows, observed, range, blocks, groups, total }
    }

    /// Factorises the rows with these scales of the estimated groups.
    pub(super) fn factor(&self, scale: impl Fn(usize) -> f64, settings: &Settings) -> Result<Factor> {
        let mut weight = vec![1.0; self.observed.len()];
        for (g, range) in self.range.iter().enumerate().take(self.groups) {
            weight[range.clone()].fill(1.0 / scale(g));
        }
        Factor::new(self.rows.as_ref(), weight, self.total, settings.rank_tolerance)
    }

    /// Solution and residuals of the compressed rows.
    pub(super) fn solve(&self, factor: &Factor, refinements: usize) -> Refined {
        factor.refined(self.rows.as_ref(), &self.observed, refinements)
    }

    /// Norm of the weighted observations, and that of what a step makes of the weighted predictions.
    pub fn norms(&self, factor: &Factor, step: &[f64]) -> (f64, f64) {
        let norm = |values: &[f64]| values.iter().zip(&factor.weight).map(|(v, w)| (v * w).powi(2)).sum::<f64>().sqrt();
        let mut moved = vec![0.0; self.observed.len()];
        crate::linear::subtract(&mut moved, &self.rows, step);
        (norm(&self.observed), norm(&moved))
    }

    /// How the unknowns follow a column that is carried along, as if it had been observed. Errors: those of [`Factor::solve`].
    pub fn follow(&self, factor: &Factor, column: usize) -> Result<Vec<f64>> {
        let carried = |block: &Block| block.rows.col_as_slice(self.rows.ncols() + column).to_vec();
        factor.solve(&self.blocks.iter().flat_map(carried).collect::<Vec<f64>>())
    }
}

/// `A' A`.
pub(super) fn gram(rows: &Mat<f64>) -> Mat<f64> {
    let mut gram = Mat::zeros(rows.ncols(), rows.ncols());
    matmul(&mut gram, Accum::Replace, rows.transpose(), rows, 1.0, Par::Seq);
    gram
}

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
    let known: Vec<f64> = (0..count).filter_map(own).collect();
    let sum: f64 = known.iter().sum();
    let other = if sum > 0.0 { sum / known.len() as f64 } else { 1.0 };
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
            _ => scales(self, hints, settings)?,
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
