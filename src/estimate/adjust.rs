//! One call from a system to an estimate.
#![allow(
    clippy::indexing_slicing,
    reason = "`System::check` has made observed, u and group as long as the rows, and group numbers smaller; per-group lists have `groups::count` entries, per-unknown ones the columns"
)]

use super::factor::{Factor, Unknowns};
use super::groups::{self, Compressed, ScaleHints};
use super::scatter::chain::Part as NoisePart;
use super::scatter::restricted::{NoiseModel, PartNoise, Slot};
use super::{Group, Settings, System};
use crate::error::{Fault, Malformed, Result};
use faer::Mat;

/// What the readings say about the unknowns, and how well. Every number in it is finite.
#[derive(Debug, Clone)]
pub struct Estimate {
    /// What they say of the unknowns.
    pub unknowns: Unknowns,
    /// Observed minus fitted, `m`, in the unit of the reading.
    pub residuals: Vec<f64>,
    /// Diagonal of the hat matrix `Q Q'`, `m`, from 0 to 1.
    pub leverage: Vec<f64>,
    /// Redundancy number of each row, `1 - leverage`; they sum to `dof`.
    pub redundancy: Vec<f64>,
    /// `sum (v/u)^2` with `u` as it was given: chi-square where every `u` is known.
    pub sum_of_squares: f64,
    /// Degrees of freedom, rows minus rank.
    pub dof: usize,
    /// Scale `s_g` of each estimated group; `None` for a group without redundancy.
    pub group_scale: Vec<Option<f64>>,
    /// Sum of the redundancy numbers of each estimated group.
    pub group_redundancy: Vec<f64>,
    /// Steps that the scales of several groups took; 0 where none were needed.
    pub group_iterations: usize,
    /// Whether the scales settled.
    pub group_converged: bool,
    /// Steps of iterative refinement.
    pub refinements: usize,
    /// The factorisation, for sensitivities, projections and other right-hand sides.
    pub factor: Factor,
}

impl Estimate {
    /// Residual standard deviation of unit weight, `sqrt(sum_of_squares / dof)`; `None` without degrees of freedom.
    pub fn residual_sd(&self) -> Option<f64> {
        (self.dof > 0).then(|| (self.sum_of_squares / self.dof as f64).sqrt())
    }

    /// The scale of a group; 1, which leaves its relative uncertainties as they are, where its rows do not determine one
    /// ([`Estimate::group_scale`] is `None`, and no standard uncertainty that depends on it is told).
    pub(crate) fn scale_or_one(&self, group: usize) -> f64 {
        self.group_scale.get(group).copied().flatten().unwrap_or(1.0)
    }

    /// Standard uncertainty of each row of the system, as a divisor: its relative one also where the residuals of its group are all zero.
    pub(crate) fn row_u(&self, system: &System) -> Vec<f64> {
        system.scaled_u(|g| Some(self.scale_or_one(g)).filter(|scale| *scale > 0.0).unwrap_or(1.0))
    }
}

/// Adjusts a system by weighted least squares.
///
/// ```text
/// x = argmin sum ((y - A x) / (s_g u))^2,   cov x = (A' diag(s_g u)^-2 A)^-1
/// ```
///
/// One estimated group alone has `s^2 = v'Pv / dof` (GUM H.3); several, or a mixture with known ones, are iterated.
/// A rank defect is a result. Errors: sizes that disagree, numbers that are not finite, a `u` that is not positive.
///
/// ```
/// use tumble::estimate::{Group, Settings, System, adjust};
/// // A straight line through (0, 1), (1, 3), (2, 4): intercept 7/6, slope 3/2, s^2 = 1/6.
/// let system = System {
///     rows: faer::mat![[1.0, 0.0], [1.0, 1.0], [1.0, 2.0]],
///     observed: vec![1.0, 3.0, 4.0],
///     u: vec![1.0; 3],
///     group: vec![Group::Estimated(0); 3],
/// };
/// let line = adjust(&system, &Settings::default())?;
/// assert!((line.unknowns.solution[0] - 7.0 / 6.0).abs() < 1e-15 && (line.unknowns.solution[1] - 1.5).abs() < 1e-15);
/// assert!((line.unknowns.covariance[(1, 1)] - 1.0 / 12.0).abs() < 1e-15);
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
pub fn adjust(system: &System, settings: &Settings) -> Result<Estimate> {
    adjust_hinted(system, &ScaleHints::default(), settings)
}

/// The same with what is known of the groups' scales beforehand.
pub(crate) fn adjust_hinted(system: &System, hints: &ScaleHints<'_>, settings: &Settings) -> Result<Estimate> {
    crate::stop::poll();
    system.check()?;
    let count = groups::count(&system.group);
    let alone = system.is_of_one_scale();
    let scales = match count == 0 || alone {
        true => groups::Scales::none(count),
        false => groups::scales(&Compressed::new(system, count), hints, settings)?,
    };
    let entering = scales.entering();
    let weight = system.scaled_u(|g| entering[g]).into_iter().map(f64::recip).collect();
    let factor = Factor::new(system.rows.as_ref(), weight, 0, settings.rank_tolerance)?;
    let fit = factor.refined(system.rows.as_ref(), &system.observed, settings.refinements);

    let dof = system.u.len() - factor.rank();
    let leverage = factor.leverages();
    let redundancy: Vec<f64> = leverage.iter().map(|h| 1.0 - h).collect();
    let sum_of_squares: f64 = fit.residuals.iter().zip(&system.u).map(|(v, u)| (v / u) * (v / u)).sum();
    let mut group_redundancy = vec![0.0; count];
    for (group, r) in system.group.iter().zip(&redundancy) {
        if let Group::Estimated(g) = group {
            group_redundancy[*g] += r;
        }
    }

    let mut group_scale = scales.scale;
    let mut common = 1.0;
    if alone && dof > 0 {
        // no hint, no floor
        let least = hints.least.first().copied().unwrap_or(0.0);
        let own = (sum_of_squares / dof as f64).max(least * least);
        common = hints.given.first().copied().flatten().map_or(own, |scale| scale * scale);
        group_scale = vec![Some(common.sqrt())];
    }
    let undetermined = depends_on_undetermined(system, &factor, &group_scale);
    let estimate = Estimate {
        unknowns: Unknowns::new(&factor, fit.solution, common, |j| !undetermined[j]),
        residuals: fit.residuals,
        leverage,
        redundancy,
        sum_of_squares,
        dof,
        group_scale,
        group_redundancy,
        group_iterations: scales.iterations,
        group_converged: scales.converged,
        refinements: fit.steps,
        factor,
    };
    let finite = estimate.unknowns.is_finite()
        && estimate.sum_of_squares.is_finite()
        && estimate.residuals.iter().all(|v| v.is_finite());
    if finite { Ok(estimate) } else { Err(out_of_range()) }
}

/// Up to so many rows compressing them costs more than it saves.
const FEW: usize = 64;

/// The unknowns alone, as a step towards them needs them.
#[derive(Debug, Clone)]
pub struct Solution {
    /// Estimate of the unknowns, `n`; those outside the basis are zero.
    pub solution: Vec<f64>,
    /// Number of independent columns.
    pub rank: usize,
    /// Observed minus fitted, `m`, in the unit of the reading.
    pub residuals: Vec<f64>,
    /// Scale of each estimated group where there are several or some rows are known; otherwise 1.
    pub group_scale: Vec<f64>,
}

/// The solution of [`adjust`] without its diagnostics, from rows compressed to a triangle for each group: the same to rounding times the
/// condition number.
///
/// Errors: those of [`adjust`].
pub fn solve(system: &System, hints: &ScaleHints<'_>, settings: &Settings) -> Result<Solution> {
    system.check()?;
    let count = groups::count(&system.group);
    let plain = count == 0 || system.is_of_one_scale();
    let found = if plain && system.observed.len() <= FEW {
        // so few rows are factorised as they are
        let weight = system.u.iter().map(|u| 1.0 / u).collect();
        let factor = Factor::new(system.rows.as_ref(), weight, system.observed.len(), settings.rank_tolerance)?;
        let found = factor.refined(system.rows.as_ref(), &system.observed, settings.refinements.min(1));
        let (rank, group_scale) = (factor.rank(), vec![1.0; count]);
        Solution { solution: found.solution, rank, residuals: found.residuals, group_scale }
    } else {
        let compressed = Compressed::new(system, count);
        let scales = match plain {
            true => groups::Scales::none(count),
            false => groups::scales(&compressed, hints, settings)?,
        };
        let group_scale = scales.entering();
        let factor = compressed.factor(|g| group_scale[g], settings)?;
        let solution = compressed.solve(&factor, 1).solution;
        let residuals = system.residuals(&solution);
        Solution { solution, rank: factor.rank(), residuals, group_scale }
    };
    let finite = found.solution.iter().chain(&found.residuals).all(|value| value.is_finite());
    if finite { Ok(found) } else { Err(out_of_range()) }
}

/// Which unknowns follow readings of a group whose scale is not determined, `n`.
fn depends_on_undetermined(system: &System, factor: &Factor, scale: &[Option<f64>]) -> Vec<bool> {
    let n = system.rows.ncols();
    let undetermined = |group: &Group| group.estimated().is_some_and(|g| scale.get(g).is_none_or(Option::is_none));
    if !system.group.iter().any(undetermined) {
        return vec![false; n];
    }
    let sensitivities = factor.sensitivities();
    let depends = |j: usize| {
        let share = |i: usize| sensitivities[(j, i)].abs() / factor.weight[i];
        let most = (0..system.u.len()).map(share).fold(0.0_f64, f64::max);
        system.group.iter().enumerate().any(|(i, group)| undetermined(group) && share(i) > 1e-10 * most)
    };
    (0..n).map(depends).collect()
}

fn out_of_range() -> Malformed {
    Malformed::new(Fault::Value, "the adjusted values leave the range of a double")
        .expected("units in which observations, derivatives and uncertainties lie nearer to 1")
}

/// What estimated scales cost beyond the covariance that takes them as known.
#[derive(Debug, Clone)]
pub struct ScaleUncertainty {
    /// Covariance of the groups' variances, each relative to its estimate.
    pub relative: Mat<f64>,
    /// Addition to the covariance of the unknowns, `n x n` (M. G. Kenward, J. H. Roger, Biometrics 53 (1997), 983-997).
    pub correction: Mat<f64>,
}

impl Estimate {
    /// How uncertain the scales of several groups are, and what that adds to the covariance of the unknowns; `None` where no scale was
    /// estimated beside others (one group alone leaves the weights as they are, and Student's distribution says the rest).
    ///
    /// With `G_g = Q_g' Q_g` and `W = 2 S^-1`, the covariance of the relative variances, the addition is
    /// `2 T (sum_g W_gg G_g - sum_gh W_gh G_g G_h) T'`, `T T'` being the covariance with known scales: Kenward and Roger's formula for
    /// `V = diag(s_g^2 u^2)` (`scatter/restricted.rs`).
    pub fn scale_uncertainty(&self, system: &System) -> Option<ScaleUncertainty> {
        let count = groups::count(&system.group);
        if self.group_iterations == 0 || count == 0 {
            return None;
        }
        let part = |g: usize| {
            let all = 0..system.group.len().min(self.residuals.len());
            let rows: Vec<usize> = all.filter(|i| system.group[*i].estimated().unwrap_or(count) == g).collect();
            NoisePart::white(rows.len() as f64, 0.0, groups::sums(&self.factor, &self.residuals, &rows))
        };
        let parts: Vec<NoisePart> = (0..=count).map(part).collect();
        // the rows have their weights
        let white = |g: usize| if g < count { Slot::Free(g) } else { Slot::Stated(1.0) };
        let model = NoiseModel {
            parts: (0..=count).map(|g| PartNoise { white: white(g), deviation: None }).collect(),
            range: vec![(f64::NEG_INFINITY, f64::INFINITY); count],
            columns: self.factor.rank(),
        };
        let found = model.likelihood(&vec![0.0; count], &parts)?;
        let among: Vec<usize> = (0..count).filter(|g| found.redundancy[*g] > groups::NO_REDUNDANCY).collect();
        let (relative, correction) = found.costs(Some(&model), &among);
        let directions = self.factor.whitened_directions();
        let correction = &directions * correction * directions.transpose();
        let finite =
            |matrix: &Mat<f64>| (0..matrix.ncols()).flat_map(|j| matrix.col_as_slice(j)).all(|value| value.is_finite());
        (finite(&relative) && finite(&correction)).then_some(ScaleUncertainty { relative, correction })
    }
}
