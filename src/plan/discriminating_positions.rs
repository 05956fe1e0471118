//! Single further positions that tell an effect from its rivals, for a campaign that has been measured.
//!
//! Against one rival, the best position is the T-optimal one (see `discriminate.rs`); against several, the one at which the least told rival is
//! told best (A. C. Atkinson, V. V. Fedorov, Biometrika 62 (1975) 289).
#![allow(
    clippy::indexing_slicing,
    reason = "whitened rows have the unknowns and one column for each term; lists over rivals have one entry for each term but the first"
)]

use super::blocks::{invert, times};
use super::candidates::{Unit, portions};
use super::effort::Offer;
use super::judge::check_question;
use super::whitened::{Beside, Term, adjusted, mounted_apart, single, whitened, with_priors};
use crate::campaign::{Campaign, Reading};
use crate::error::Result;
use crate::linear::dot;

/// A position that tells an effect from its rivals.
#[derive(Debug, Clone)]
pub struct DiscriminatingPosition {
    /// The position.
    pub position: Reading,
    /// What it adds to `T` against the rival that it tells least, as a share of the most that any candidate adds.
    pub least: f64,
    /// The mean of these shares over all rivals.
    pub mean: f64,
    /// The rivals that it tells plainly, by index: it adds at least a tenth of what a reading holds of the effect on average.
    pub told: Vec<usize>,
}

/// A rival that no candidate adds this share of the effect's own information against is told by none of them.
const TELLS: f64 = 1e-4;
/// A position tells a rival plainly if it adds this share of what a reading at hand holds of the effect on average.
const PLAINLY: f64 = 0.1;
/// Weight of a loose prior on parameters where what is kept does not determine all of them, as a share of their columns.
const LOOSE: f64 = 1e-3;

/// Every candidate position that tells `effect` from at least one of `rivals` when it is added to what is kept, the best first.
///
/// Adding rows `F` updates the products of the residual columns, `P_ab + e_a' (I + F (A'A)^-1 F')^-1 e_b` with `e = f - F x`, and
/// `T = P_aa - P_ab^2 / P_bb`. Errors: those of [`discriminate`](super::discriminate()).
pub fn discriminating_positions(
    campaign: &Campaign,
    offer: &Offer,
    effect: &Term,
    rivals: &[Term],
) -> Result<Vec<DiscriminatingPosition>> {
    let Offer { kept, candidates, noise, .. } = offer;
    check_question(campaign)?;
    let terms: Vec<Term> = [effect].into_iter().chain(rivals).cloned().collect();
    let portions = portions(campaign, candidates, Unit::Reading)?;
    let apart = mounted_apart(&portions, candidates);
    let beside = Beside::new(campaign, noise, &terms, &[kept, &apart]);
    let n = beside.fitted(campaign);
    let mut rows = with_priors(campaign, kept, noise, &beside)?;
    let mut estimate = adjusted(campaign, &rows, n)?;
    if estimate.unknowns.rank < n {
        for k in 0..n {
            let size = rows.iter().map(|row| row[k] * row[k]).sum::<f64>().sqrt();
            let weight = if size > 0.0 { LOOSE * size } else { LOOSE };
            rows.push(single(n + terms.len(), k, weight));
        }
        estimate = adjusted(campaign, &rows, n)?;
    }
    let column = |t: usize| rows.iter().map(|row| row[n + t]).collect::<Vec<f64>>();
    let fitted: Vec<Vec<f64>> = (0..terms.len()).map(|t| estimate.factor.solve(&column(t))).collect::<Result<_>>()?;
    let residual: Vec<Vec<f64>> =
        (0..terms.len()).map(|t| estimate.factor.project_out(&column(t))).collect::<Result<_>>()?;
    let further = whitened(campaign, &apart, noise, &beside, true)?;
    let size = (further.len() / portions.len().max(1)).max(1);
    let own = dot(residual.first().map_or(&[], Vec::as_slice), residual.first().map_or(&[], Vec::as_slice));
    let before: Vec<[f64; 3]> = residual.iter().skip(1).map(|b| products(&residual[0], b)).collect();
    // what each candidate adds to T against each rival
    let gains: Vec<Vec<f64>> = further
        .chunks(size)
        .map(|rows| {
            let errors: Vec<Vec<f64>> = fitted
                .iter()
                .enumerate()
                .map(|(t, x)| rows.iter().map(|row| row[n + t] - dot(&row[..n], x)).collect())
                .collect();
            let k = rows.len();
            let spread: Vec<Vec<f64>> = rows
                .iter()
                .map(|row| {
                    (0..n).map(|i| (0..n).map(|j| estimate.unknowns.covariance[(i, j)] * row[j]).sum()).collect()
                })
                .collect();
            let s: Vec<f64> = (0..k * k)
                .map(|at| f64::from(u8::from(at / k == at % k)) + dot(&rows[at / k][..n], &spread[at % k]))
                .collect();
            let Some((inverse, _)) = invert(&s, k) else { return vec![0.0; before.len()] };
            let whitened: Vec<Vec<f64>> = errors.iter().map(|e| times(&inverse, e)).collect();
            before
                .iter()
                .enumerate()
                .map(|(b, [aa, ab, bb])| {
                    let more = [
                        dot(&errors[0], &whitened[0]),
                        dot(&errors[0], &whitened[b + 1]),
                        dot(&errors[b + 1], &whitened[b + 1]),
                    ];
                    told([aa + more[0], ab + more[1], bb + more[2]]) - told([*aa, *ab, *bb])
                })
                .collect()
        })
        .collect();
    let most: Vec<f64> = (0..before.len()).map(|b| gains.iter().map(|g| g[b]).fold(0.0, f64::max)).collect();
    let told_by_some: Vec<usize> = (0..before.len()).filter(|b| most[*b] > TELLS * own).collect();
    let mut list: Vec<DiscriminatingPosition> = portions
        .iter()
        .zip(&gains)
        .filter_map(|(portion, gain)| {
            let shares = told_by_some.iter().map(|b| gain[*b].max(0.0) / most[*b]);
            let mean = shares.clone().sum::<f64>() / told_by_some.len().max(1) as f64;
            let least = shares.reduce(f64::min)?;
            let plain = PLAINLY * own / kept.rows.len().max(1) as f64;
            let told = told_by_some.iter().copied().filter(|b| gain[*b] > plain).collect();
            Some(DiscriminatingPosition { position: portion.first()?.clone(), least, mean, told })
        })
        .filter(|own| own.mean > TELLS)
        .collect();
    // shares that differ by rounding must not order positions
    let rounded = |v: f64| (v * 1e3).round();
    list.sort_by(|a, b| {
        rounded(b.least).total_cmp(&rounded(a.least)).then(rounded(b.mean).total_cmp(&rounded(a.mean)))
    });
    Ok(list)
}

/// `a'a`, `a'b`, `b'b`.
fn products(a: &[f64], b: &[f64]) -> [f64; 3] {
    [dot(a, a), dot(a, b), dot(b, b)]
}

/// `T` from products of residual columns; a rival that the model absorbs takes nothing away.
fn told([aa, ab, bb]: [f64; 3]) -> f64 {
    if bb > 1e-20 * aa { (aa - ab * ab / bb).max(0.0) } else { aa }
}
