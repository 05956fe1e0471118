//! Linear equations between unknowns, met exactly by elimination: `x = offset + lift t`, then an ordinary adjustment in `t`.
//!
//! Elimination with complete pivoting on scaled columns; the unknowns that are kept stay unknowns of the user's, so a rank defect that
//! remains is still named in them. Deliberately absent: heavy weights instead of equations.
#![allow(
    clippy::indexing_slicing,
    reason = "rows, values and origins have one entry for each equation, each row one for each of the `n` unknowns; terms about others are left out when rows are made"
)]

use super::adjust::adjust_hinted;
use super::basis::Combination;
use super::factor::Embedding;
use super::{Estimate, ScaleHints, Settings, System};
use crate::error::{Fault, Malformed, Result};
use faer::Mat;

/// `sum c_j x_j = value`.
#[derive(Debug, Clone, PartialEq)]
pub struct Equation {
    /// Unknown and coefficient.
    pub terms: Vec<(usize, f64)>,
    /// The value.
    pub value: f64,
}

/// What a list of equations comes to.
#[derive(Debug, Clone, PartialEq)]
pub enum Equations {
    /// They agree: eliminated unknowns, `x = offset + lift t` with `t` the others.
    Consistent(Elimination),
    /// These contradict each other, by index.
    Contradictory(Vec<usize>),
}

/// Unknowns that equations determine from the others.
#[derive(Debug, Clone, PartialEq)]
pub struct Elimination {
    kept: Vec<usize>,
    lift: Mat<f64>,
    offset: Vec<f64>,
}

impl Elimination {
    /// One solution of the equations, `n`: the one where every unknown that was kept is zero.
    pub(crate) fn offset(&self) -> &[f64] {
        &self.offset
    }

    /// Do the equations leave this unknown one value?
    pub(crate) fn fixes(&self, unknown: usize) -> bool {
        unknown < self.lift.nrows() && (0..self.lift.ncols()).all(|t| self.lift[(unknown, t)] == 0.0)
    }
}

/// Relative size below which an eliminated row is empty.
const EMPTY: f64 = 1e-12;
/// Relative size of a right-hand side that an empty row may keep.
const AGREES: f64 = 1e-9;

impl Equations {
    /// Eliminate from `n` unknowns whose natural sizes are `1 / scale`.
    ///
    /// ```
    /// use tumble::estimate::{Equation, Equations};
    /// let is = |value| Equation { terms: vec![(0, 1.0)], value };
    /// assert_eq!(Equations::new(2, &[1.0, 1.0], &[is(1.0), is(2.0)]), Equations::Contradictory(vec![0, 1]));
    /// ```
    pub fn new(n: usize, scale: &[f64], equations: &[Equation]) -> Self {
        // a column of zeros is not scaled
        let size = |j: usize| scale.get(j).copied().filter(|s| *s > 0.0).unwrap_or(1.0);
        let count = equations.len();
        // rows of scaled coefficients, right-hand sides, and which equations went into each
        let mut rows: Vec<Vec<f64>> = Vec::with_capacity(count);
        let mut values: Vec<(f64, f64)> = Vec::with_capacity(count);
        let mut origin: Vec<Vec<f64>> = Vec::with_capacity(count);
        for (k, equation) in equations.iter().enumerate() {
            let mut row = vec![0.0; n];
            for (j, c) in &equation.terms {
                if let Some(slot) = row.get_mut(*j) {
                    *slot += c / size(*j);
                }
            }
            let norm = row.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
            let norm = if norm > 0.0 { norm } else { 1.0 };
            row.iter_mut().for_each(|c| *c /= norm);
            rows.push(row);
            values.push((equation.value / norm, (equation.value / norm).abs()));
            origin.push((0..count).map(|l| if l == k { 1.0 / norm } else { 0.0 }).collect());
        }
        let mut pivots: Vec<(usize, usize)> = Vec::new();
        loop {
            let open = (0..count).filter(|k| !pivots.iter().any(|(row, _)| row == k));
            let best = open
                .flat_map(|k| rows[k].iter().enumerate().map(move |(j, c)| (k, j, c.abs())))
                .max_by(|a, b| a.2.total_cmp(&b.2));
            let Some((k, j, _)) = best.filter(|(_, _, c)| *c > EMPTY) else { break };
            let pivot = rows[k][j];
            rows[k].iter_mut().for_each(|c| *c /= pivot);
            origin[k].iter_mut().for_each(|c| *c /= pivot);
            values[k] = (values[k].0 / pivot, values[k].1 / pivot.abs());
            rows[k][j] = 1.0;
            let (row, value, from) = (rows[k].clone(), values[k], origin[k].clone());
            for other in (0..count).filter(|other| *other != k) {
                let factor = rows[other][j];
                if factor == 0.0 {
                    continue;
                }
                rows[other].iter_mut().zip(&row).for_each(|(c, p)| *c -= factor * p);
                origin[other].iter_mut().zip(&from).for_each(|(c, p)| *c -= factor * p);
                rows[other][j] = 0.0;
                values[other].0 -= factor * value.0;
                values[other].1 = values[other].1.max((factor * value.1).abs());
            }
            pivots.push((k, j));
        }
        for k in (0..count).filter(|k| !pivots.iter().any(|(row, _)| row == k)) {
            if values[k].0.abs() > AGREES * values[k].1 {
                let largest = origin[k].iter().fold(0.0_f64, |most, c| most.max(c.abs()));
                let involved = origin[k].iter().enumerate().filter(|(_, c)| c.abs() > AGREES * largest);
                return Equations::Contradictory(involved.map(|(l, _)| l).collect());
            }
        }
        let kept: Vec<usize> = (0..n).filter(|j| !pivots.iter().any(|(_, column)| column == j)).collect();
        let mut offset = vec![0.0; n];
        let mut lift = Mat::zeros(n, kept.len());
        for (t, j) in kept.iter().enumerate() {
            lift[(*j, t)] = 1.0;
        }
        for (k, j) in &pivots {
            offset[*j] = values[*k].0 / size(*j);
            for (t, free) in kept.iter().enumerate() {
                // scaled: z_j = value - sum c z_free
                lift[(*j, t)] = -rows[*k][*free] * size(*free) / size(*j);
            }
        }
        Equations::Consistent(Elimination { kept, lift, offset })
    }
}

/// Adjust a system whose unknowns satisfy equations, with what is known of the groups' scales beforehand; everything in the result is in the user's
/// unknowns, and exact on the equations. [`super::adjust`] where there are none.
///
/// `x = offset + N t`, `t = argmin |W (y - A offset - A N t)|`, `cov x = N cov(t) N'`; degrees of freedom grow by the number of equations.
/// Errors: those of [`super::adjust`].
pub(crate) fn adjust_on(
    system: &System,
    elimination: Option<&Elimination>,
    hints: &ScaleHints<'_>,
    settings: &Settings,
) -> Result<Estimate> {
    let Some(Elimination { kept, lift, offset }) = elimination else { return adjust_hinted(system, hints, settings) };
    let (m, n) = system.shape();
    if lift.nrows() != n {
        return Err(Malformed::new(Fault::Value, "the equations are about another number of unknowns")
            .expected(n.to_string())
            .found(lift.nrows().to_string()));
    }
    system.check()?;
    let rows = &system.rows * lift;
    let observed = (0..m).map(|i| {
        let along: f64 = offset.iter().enumerate().map(|(j, x)| system.rows[(i, j)] * x).sum();
        system.observed[i] - along
    });
    let reduced = System { rows, observed: observed.collect(), u: system.u.clone(), group: system.group.clone() };
    let mut estimate = adjust_hinted(&reduced, hints, settings)?;
    // n, which is no unknown, beyond those that are kept
    let user = |k: usize| kept.get(k).copied().unwrap_or(n);
    let mut scale = vec![1.0; n];
    for (j, s) in kept.iter().zip(estimate.factor.scale().to_vec()) {
        scale[*j] = s;
    }
    let basis = estimate.factor.basis().iter().map(|k| user(*k)).collect();
    let embedding = Embedding { lift: lift.clone(), basis, scale };
    estimate.unknowns.solution = embedding
        .direction(&estimate.unknowns.solution)
        .iter()
        .zip(offset)
        .map(|(along, offset)| along + offset)
        .collect();
    let spread = |inner: &Mat<f64>| lift * inner * lift.transpose();
    estimate.unknowns.cofactor = spread(&estimate.unknowns.cofactor);
    estimate.unknowns.covariance = spread(&estimate.unknowns.covariance);
    let follows = |j: usize| (0..kept.len()).filter(move |t| lift[(j, *t)] != 0.0);
    let estimable: Vec<bool> = (0..n).map(|j| follows(j).all(|t| estimate.unknowns.estimable[t])).collect();
    estimate.unknowns.standard_uncertainty = (0..n)
        .map(|j| {
            let known = follows(j).all(|t| estimate.unknowns.standard_uncertainty[t].is_some());
            known.then(|| estimate.unknowns.covariance[(j, j)].max(0.0).sqrt())
        })
        .collect();
    estimate.unknowns.estimable = estimable;
    let rename = |combinations: &mut Vec<Combination>| {
        for (k, _) in combinations.iter_mut().flat_map(|c| c.terms.iter_mut()) {
            *k = user(*k);
        }
    };
    rename(&mut estimate.unknowns.not_estimable);
    rename(&mut estimate.unknowns.free_directions);
    rename(&mut estimate.unknowns.estimable_combinations);
    estimate.factor.embedding = Some(embedding);
    Ok(estimate)
}
