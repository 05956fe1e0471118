//! Known inputs with an uncertainty: how the unknowns of a linear model follow them, once for all devices of a schedule.

use crate::campaign::{Campaign, Known, Role};
use crate::design::{self, Model};
use crate::elements::Elements;
use faer::Mat;

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
    pub fn sensitivity(&self, dx: &[f64]) -> Vec<f64> {
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

/// How the unknowns follow the known inputs: `-(dx/dy) df/dp`, where `df/dp` is affine in the unknowns as the model is.
pub(super) fn inputs(
    campaign: &Campaign,
    model: &Model,
    reference: &[f64],
    design: &design::DesignMatrix,
    sensitivities: &Mat<f64>,
) -> Option<Vec<Input>> {
    let n = campaign.unknowns();
    let uncertain: Vec<(usize, Known)> = campaign
        .parameters
        .iter()
        .enumerate()
        .filter_map(|(k, p)| match p.role {
            Role::Known(known) if known.u != 0.0 => Some((k, known)),
            _ => None,
        })
        .collect();
    if uncertain.is_empty() {
        return Some(Vec::new());
    }
    let follow = |column: &dyn Fn(usize) -> f64| -> Vec<f64> {
        (0..n).map(|j| -(0..design.rows.len()).map(|i| sensitivities[(j, i)] * column(i)).sum::<f64>()).collect()
    };
    let mut moved = Vec::with_capacity(n);
    for j in 0..n {
        let mut point = reference.to_vec();
        point.get_mut(j).into_iter().for_each(|x| *x += 1.0);
        moved.push(design::assemble(campaign, model, &point).ok()?);
    }
    let input = |(k, known): (usize, Known)| {
        let base = follow(&|i| design.jacobian[(i, k)]);
        let columns: Vec<Vec<f64>> =
            moved.iter().map(|there| follow(&|i| there.jacobian[(i, k)] - design.jacobian[(i, k)])).collect();
        let none = columns.iter().flatten().all(|s| *s == 0.0);
        let at = |j: usize, i: usize| columns.at(i).at(j);
        let slope = if none {
            Vec::new()
        } else {
            (0..n).flat_map(|j| (0..n).map(move |i| (j, i))).map(|(j, i)| at(j, i)).collect()
        };
        Input { index: k, known, base, slope }
    };
    Some(uncertain.into_iter().map(input).collect())
}
