//! From chosen portions to a schedule: labels, order, and the criterion once more.

use super::effort::{Noise, Offer, mounting, planned};
use super::largest::Worst;
use super::order::ordered;
use super::pool::{Pool, log_det_of};
use super::problem::{Design, Objective};
use super::request::Request;
use super::whitened::{Beside, adjusted, with_priors};
use crate::campaign::{Campaign, Reading, Readings};
use crate::elements::Elements;
use crate::error::Result;
use crate::estimate::Estimate;

/// Rows of a schedule (what is kept, then what was chosen) in the order to run.
pub(super) fn scheduled(
    campaign: &Campaign,
    kept: &Readings,
    rows: Vec<Reading>,
    offer: &Offer,
    request: &Request,
) -> Result<Campaign> {
    let Offer { noise, costs, .. } = offer;
    let all = planned(campaign, &Readings { columns: kept.columns.clone(), rows });
    let run = ordered(&campaign.with_readings(all), noise, costs, request.order, request.seed, kept.rows.len())?;
    Ok(campaign.with_readings(relabelled(kept, run)))
}

/// Kept readings and chosen ones. New mountings are numbered on from the kept labels; where remounting scatters, a repeat is a new mounting.
pub(super) fn schedule_rows(kept: &Readings, pool: &Pool, chosen: &[usize], repeats_remount: bool) -> Vec<Reading> {
    let mut rows: Vec<Reading> = kept.rows.clone();
    let mut next = 1 + kept.rows.iter().filter_map(|r| r.position.parse::<usize>().ok()).max().unwrap_or(0);
    let mut labels: Vec<((Vec<Option<f64>>, &str), String)> = Vec::new();
    for (portion, level) in chosen.iter().filter_map(|j| pool.portions.get(*j).zip(pool.levels.get(*j))) {
        // portions have readings
        let place = (portion.first().map(mounting).unwrap_or_default(), level.as_str());
        let known =
            labels.iter().find(|(other, _)| !repeats_remount && *other == place).map(|(_, label)| label.clone());
        let label = known.unwrap_or_else(|| {
            let label = next.to_string();
            next += 1;
            labels.push((place, label.clone()));
            label
        });
        rows.extend(portion.iter().map(|r| Reading { position: label.clone(), ..r.clone() }));
    }
    rows
}

/// New mountings numbered in the order in which they are run; labels that were kept stay.
pub(super) fn relabelled(kept: &Readings, mut run: Readings) -> Readings {
    let old: Vec<&str> = kept.rows.iter().map(|r| r.position.as_str()).collect();
    let mut next = 1 + old.iter().filter_map(|label| label.parse::<usize>().ok()).max().unwrap_or(0);
    let mut names: std::collections::HashMap<String, String> = std::collections::HashMap::new();
    for reading in run.rows.iter_mut().filter(|r| !old.contains(&r.position.as_str())) {
        let label = names.entry(reading.position.clone()).or_insert_with(|| {
            next += 1;
            (next - 1).to_string()
        });
        reading.position.clone_from(label);
    }
    run
}

/// The criterion from a fresh QR of the final schedule, against the value that the exchange ended with.
pub(super) fn check(
    schedule: &Campaign,
    noise: &Noise,
    pool: &Pool,
    objective: &Objective,
    design: &Design,
) -> Result<Option<f64>> {
    let n = schedule.unknowns() as f64;
    Ok(criterion_of(schedule, noise, pool, objective)?.map(|found| match objective {
        // per unknown, as a relative change of the determinant
        Objective::Determinant => (found - design.value).abs() / n,
        _ => (found / design.value - 1.0).abs(),
    }))
}

/// The criterion of a schedule from a fresh QR; `None` where it does not determine the unknowns that the pool does.
pub(super) fn criterion_of(
    schedule: &Campaign,
    noise: &Noise,
    pool: &Pool,
    objective: &Objective,
) -> Result<Option<f64>> {
    let n = schedule.unknowns();
    let beside = Beside::new(schedule, noise, &[], &[&schedule.readings]);
    let rows = with_priors(schedule, &schedule.readings, noise, &beside)?;
    let fresh = adjusted(schedule, &rows, beside.columns(schedule))?;
    // deviations are always determined, and the schedule may have fewer of them than the pool
    let rank = fresh.unknowns.rank.saturating_sub(beside.deviations.count());
    let basis = pool.estimate.factor.basis();
    if rank != pool.determined() || fresh.factor.basis().iter().any(|j| *j < n && !basis.contains(j)) {
        return Ok(None);
    }
    Ok(match objective {
        Objective::Determinant => Some(log_det_of(&pool.estimate) - log_det_of(&fresh)),
        _ if rank < n => None,
        Objective::Trace(w) => Some(crate::linear::dot(w, &in_coordinates(pool, &fresh, n))),
        Objective::Largest(rows) => Some(rows.of(&in_coordinates(pool, &fresh, n))),
        Objective::Eigenvalue(combinations) => Some(combinations.of(&in_coordinates(pool, &fresh, n))),
        Objective::Volume(volume) => Some(volume.of(&in_coordinates(pool, &fresh, n))),
    })
}

/// Covariance of `z = R D x`, the pool's coordinates, row by row, from that of the first `parameters` of `x`: nothing is asked of the others.
fn in_coordinates(pool: &Pool, fresh: &Estimate, parameters: usize) -> Vec<f64> {
    let factor = &pool.estimate.factor;
    let (basis, r, scale) = (factor.basis(), factor.r(), factor.scale());
    let n = basis.len();
    let t = |i: usize, k: usize| r[(i, k)] * scale.at(basis.at(k));
    let c = |k: usize, l: usize| match (basis.get(k), basis.get(l)) {
        (Some(a), Some(b)) if *a < parameters && *b < parameters => fresh.unknowns.covariance[(*a, *b)],
        _ => 0.0,
    };
    let half: Vec<Vec<f64>> =
        (0..n).map(|i| (0..n).map(|l| (i..n).map(|k| t(i, k) * c(k, l)).sum()).collect()).collect();
    half.iter()
        .flat_map(|row| {
            (0..n).map(move |j| row.iter().enumerate().skip(j).map(|(l, half)| half * t(j, l)).sum::<f64>())
        })
        .collect()
}
