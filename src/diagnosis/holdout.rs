//! Leave-one-position-out prediction: does the repaired model predict positions that it has not seen better than the given one?
#![allow(
    clippy::indexing_slicing,
    reason = "groups hold rows of the fit's system; the whitening pads every vector to the same rows, and `scale` follows the group"
)]

use super::noise::{Weighted, positions};
use crate::campaign::Campaign;
use crate::elements::Elements;
use crate::estimate::{Floor, Settings, adjust};
use crate::fit::Fit;
use crate::plan::grouped;
use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};

/// Least pivot of `1 - A'A` (its square root): below, the other readings do not determine what the group needs.
const LEAST_LEFT: f64 = 1e-4;
/// Most rows of a campaign with lines of scatter whose positions are left out.
const MOST_SCATTERED: usize = 3000;

/// Leave-one-position-out prediction.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "HoldoutReport")]
pub struct Holdout {
    /// Positions predicted from the others.
    pub positions: usize,
    /// Positions that cannot be left out, because they alone hold a parameter.
    pub skipped: usize,
    /// Root mean square prediction error before, in standard uncertainties of prediction and reading together: 1 for a true model.
    pub before: f64,
    /// The same with the effects, in the same unit.
    pub after: Option<f64>,
}

/// Leave out each position in turn: `e = (1 - H_gg)^-1 v_g`, `cov e = (1 - H_gg)^-1` (Cook, Weisberg: Residuals and Influence in Regression).
pub(super) fn holdout(
    campaign: &Campaign,
    before: &Fit,
    after: Option<&Fit>,
    (scale, weighted): (&[f64], &Weighted),
) -> Option<Holdout> {
    let groups = grouped(positions(campaign, &before.design, before.design.rows.len()).into_iter().enumerate());
    if groups.len() < 2 {
        return None;
    }
    let scattered = match &weighted.floor {
        None => None,
        // each left-out position costs a pass over all rows for each of its readings
        Some(_) if weighted.weight.len() > MOST_SCATTERED => return None,
        Some(floor) => {
            let of = |fit: &Fit| Scattered::new(fit, floor);
            Some((of(before)?, after.map(of)))
        }
    };
    let (mut sum_before, mut sum_after, mut rows, mut positions, mut skipped) = (0.0, 0.0, 0, 0, 0);
    for group in &groups {
        let (square_before, square_after) = match &scattered {
            None => (left_out(before, group, scale), after.map(|fit| left_out(fit, group, scale))),
            Some((first, second)) => {
                (first.left_out(group), second.as_ref().map(|fit| fit.as_ref().and_then(|fit| fit.left_out(group))))
            }
        };
        match (square_before, square_after) {
            (Some(square), None) => sum_before += square,
            (Some(first), Some(Some(second))) => {
                sum_before += first;
                sum_after += second;
            }
            _ => {
                skipped += 1;
                continue;
            }
        }
        positions += 1;
        rows += group.len();
    }
    if positions == 0 {
        return None;
    }
    let rms = |sum: f64| (sum / rows as f64).sqrt();
    Some(Holdout { positions, skipped, before: rms(sum_before), after: after.map(|_| rms(sum_after)) })
}

/// `v' (1 - H)^-1 v` of the rows of a group, over `scale^2`: the squared errors of their prediction from the others, each over its variance;
/// `None` where the other readings cannot predict them.
fn left_out(fit: &Fit, group: &[usize], scale: &[f64]) -> Option<f64> {
    let factor = &fit.estimate.factor;
    let q = factor.thin_q();
    let size = group.len();
    if size > 400 {
        return None;
    }
    // the basis has few columns: (1 - A A')^-1 v = v + A (1 - A'A)^-1 A'v with A the rows of Q in the group
    let r = q.ncols();
    let mut inner = faer::Mat::<f64>::zeros(r, r);
    let weight = |i: &usize| factor.weight().at(*i);
    let v: Vec<f64> = group.iter().map(|i| fit.estimate.residuals.at(*i) * weight(i)).collect();
    for a in 0..r {
        for b in 0..r {
            let product: f64 = group.iter().map(|i| q[(*i, a)] * q[(*i, b)]).sum();
            inner[(a, b)] = f64::from(u8::from(a == b)) - product;
        }
    }
    // v'(1 - H)^-1 v = v'v + |L^-1 A'v|^2 with L L' = 1 - A'A: a sum of squares, which no rounding makes negative
    let factor = Llt::new(inner.as_ref(), Side::Lower).ok()?;
    let lower = factor.L();
    if (0..r).any(|a| !(lower[(a, a)] > LEAST_LEFT)) {
        return None;
    }
    // noise floor of each row against its weight; the part that the other readings predict has their mean
    let relative = |i: &usize| Some(scale.get(*i).copied().filter(|u| *u > 0.0)? * weight(i));
    let floors: Vec<f64> = group.iter().map(relative).collect::<Option<_>>()?;
    let mean = floors.iter().map(|u| u * u).sum::<f64>() / floors.len() as f64;
    let mut along: Vec<f64> = (0..r).map(|a| group.iter().zip(&v).map(|(i, v)| q[(*i, a)] * v).sum()).collect();
    for a in 0..r {
        let before: f64 = (0..a).map(|b| lower[(a, b)] * along.at(b)).sum();
        if let Some(value) = along.get_mut(a) {
            *value = (*value - before) / lower[(a, a)];
        }
    }
    let independent: f64 = v.iter().zip(&floors).map(|(v, u)| (v / u) * (v / u)).sum();
    let sum = independent + along.iter().map(|x| x * x).sum::<f64>() / mean;
    sum.is_finite().then_some(sum)
}

/// A model whose rows are not independent: `P = V^-1 - V^-1 A (A' V^-1 A)^-1 A' V^-1`, `e = P_gg^-1 (P y)_g`, `cov e = P_gg^-1`.
///
/// The others predict a position with the deviations that they share with it.
struct Scattered<'a> {
    floor: &'a Floor,
    /// `P y`.
    weighted: Vec<f64>,
    /// `W' q` of each direction of the model.
    basis: Vec<Vec<f64>>,
}

impl<'a> Scattered<'a> {
    fn new(fit: &Fit, floor: &'a Floor) -> Option<Self> {
        let whitening = floor.whitening();
        let m = whitening.rows();
        let mut rows = fit.system.rows.clone();
        rows.resize_with(m, fit.system.rows.ncols(), |_, _| 0.0);
        let mut observed = fit.system.observed.clone();
        observed.resize(m, 0.0);
        let white = whitening.system(&rows, &observed);
        let adjusted = adjust(&white, &Settings::default()).ok()?;
        let q = adjusted.factor.thin_q();
        let basis = (0..q.ncols()).map(|k| {
            let direction: Vec<f64> = q.col(k).iter().copied().collect();
            whitening.carry_back(&direction)
        });
        let basis = basis.collect();
        Some(Scattered { floor, weighted: whitening.carry_back(&adjusted.residuals), basis })
    }

    /// `(P y)_g' P_gg^-1 (P y)_g`; `None` where the other readings cannot predict the group.
    fn left_out(&self, group: &[usize]) -> Option<f64> {
        let whitening = self.floor.whitening();
        let size = group.len();
        let mut inner = Mat::<f64>::zeros(size, size);
        for (b, row) in group.iter().enumerate() {
            let mut unit = vec![0.0; whitening.rows()];
            *unit.get_mut(*row)? = 1.0;
            let column = whitening.carry_back(&whitening.whiten(&unit));
            for (a, other) in group.iter().enumerate() {
                let model: f64 = self.basis.iter().map(|q| q[*row] * q[*other]).sum();
                inner[(a, b)] = column[*other] - model;
            }
        }
        let scale: Vec<f64> = group.iter().map(|i| self.floor.total_sd().at(*i)).collect();
        let scaled = Mat::from_fn(size, size, |a, b| 0.5 * (inner[(a, b)] + inner[(b, a)]) * scale[a] * scale[b]);
        let factor = Llt::new(scaled.as_ref(), Side::Lower).ok()?;
        let lower = factor.L();
        if (0..size).any(|a| !(lower[(a, a)] > LEAST_LEFT)) {
            return None;
        }
        let right = Mat::from_fn(size, 1, |a, _| self.weighted[group[a]] * scale[a]);
        let solved = factor.solve(&right);
        let sum: f64 = (0..size).map(|a| right[(a, 0)] * solved[(a, 0)]).sum();
        (sum.is_finite() && sum >= 0.0).then_some(sum)
    }
}
