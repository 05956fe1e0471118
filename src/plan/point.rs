//! The point at which a plan judges: rows are derivatives, and those of a bilinear model depend on where they are taken.
//!
//! A value that is given, else that of a fit of the campaign's readings, else the start, the prior's value, zero. In
//! `K*(w + tilt*g)` the tilt's column is `K g`: at `K = 0` it vanishes, although every other value of `K` shows the tilt. What is lost only at the
//! point, and not nearby, is not a rank defect of the schedule: it needs a value.

use super::effort::Noise;
use super::whitened::Independent;
use crate::campaign::{Campaign, Kind, Reading, Readings, Role};
use crate::design::DesignMatrix;
use crate::error::{Fault, Malformed, Result};
use crate::estimate::Estimate;
use crate::fit::Fit;
use crate::number::shuffle;
use crate::vocabulary::vocabulary;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;

vocabulary! {
    /// Where a value of the point comes from.
    PointSource {
        /// The user gave it for this plan.
        Given = "given",
        /// A fit of the campaign's readings.
        Fitted = "fitted",
        /// The campaign's start.
        Start = "start",
        /// The campaign's prior.
        Prior = "prior",
        /// Nothing is stated.
        Zero = "zero",
    }
}

/// A campaign at the point at which it is judged: its reference point.
#[derive(Debug, Clone)]
pub struct Judged {
    /// The campaign, its starts replaced by the point.
    pub campaign: Campaign,
    /// Where each estimated parameter's value comes from.
    pub from: Vec<PointSource>,
}

/// Put a campaign at the point at which it is to be judged: `given` values (parameter and value, radians for tilts) before those that a fit of its
/// readings gives, before starts, priors and zero.
///
/// Errors: a name that is not estimated, a value that is not finite.
pub fn judged_at(campaign: &Campaign, given: &[(String, f64)], fitted: Option<&Fit>) -> Result<Judged> {
    let n = campaign.unknowns();
    for (id, value) in given {
        if campaign.parameter_index(id).is_none_or(|k| k >= n) {
            let what = format!("'{id}' is not estimated, so a plan cannot be evaluated at a value of it");
            return Err(Malformed::unknown(what, id, campaign.estimated().iter().map(|p| &p.id)));
        }
        if !value.is_finite() {
            return Err(Malformed::new(Fault::Value, format!("the value of '{id}' is not finite"))
                .expected("a finite number")
                .found(value.to_string()));
        }
    }
    let fitted = fitted
        .filter(|fit| fit.convergence.as_ref().is_none_or(|c| c.converged) && fit.point.iter().all(|v| v.is_finite()));
    let mut at = campaign.clone();
    let mut from = Vec::with_capacity(n);
    for (k, parameter) in at.parameters.iter_mut().enumerate().take(n) {
        let Role::Estimated { start, prior } = &mut parameter.role else { continue };
        let named = given.iter().rev().find(|(id, _)| *id == parameter.id).map(|(_, value)| *value);
        let of_fit = fitted.filter(|fit| fit.estimate.unknowns.is_estimable(k));
        let of_fit = of_fit.and_then(|fit| fit.point.get(k)).copied();
        let stated = named.map(|v| (v, PointSource::Given)).or(of_fit.map(|v| (v, PointSource::Fitted)));
        from.push(match (stated, &start, &prior) {
            (Some((value, source)), ..) => {
                *start = Some(value);
                source
            }
            (None, Some(_), _) => PointSource::Start,
            (None, None, Some(_)) => PointSource::Prior,
            (None, None, None) => PointSource::Zero,
        });
    }
    Ok(Judged { campaign: at, from })
}

/// What cannot be predicted at the point of evaluation although it could be nearby.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "LackingReport")]
pub struct Lacking {
    /// Parameters whose uncertainty cannot be predicted.
    pub untold: Vec<String>,
    /// Parameters without a stated value on which these uncertainties depend.
    pub needs: Vec<String>,
}

/// Displacements of unstated values, of tilts (rad) and coefficients: arbitrary, but not zero, equal or commensurable.
const NEARBY: [(f64, f64); 2] = [(0.013, 0.71), (-0.0171, 1.37)];

/// Rows at a general point near the one at which a campaign is judged, if they determine more than those there; and what is lacking there.
pub(super) fn lacking(
    campaign: &Campaign,
    here: &Estimate,
    noise: &Noise,
) -> Result<Option<(Lacking, DesignMatrix, Estimate)>> {
    let point = campaign.reference_point();
    let free: Vec<usize> = (0..campaign.unknowns())
        .filter(|k| {
            matches!(campaign.parameters.get(*k).map(|p| &p.role), Some(Role::Estimated { start: None, prior: None }))
        })
        .collect();
    if free.is_empty() || here.unknowns.not_estimable.is_empty() {
        return Ok(None);
    }
    let moved = |which: &[usize], sizes: (f64, f64)| -> Result<(DesignMatrix, Estimate)> {
        let mut there = point.clone();
        for (place, k) in which.iter().enumerate() {
            let tilt = campaign.parameters.get(*k).is_some_and(|p| p.kind == Kind::Tilt);
            let size = (if tilt { sizes.0 } else { sizes.1 }) * (1.0 + 0.37 * (place as f64 * 1.618).sin());
            if let Some(slot) = there.get_mut(*k) {
                *slot += size;
            }
        }
        let (design, _, estimate) = Independent::at(campaign, &there, noise)?;
        Ok((design, estimate))
    };
    let mut best: Option<(DesignMatrix, Estimate)> = None;
    for sizes in NEARBY {
        let (design, estimate) = moved(&free, sizes)?;
        if estimate.unknowns.rank > best.as_ref().map_or(here.unknowns.rank, |(_, before)| before.unknowns.rank) {
            best = Some((design, estimate));
        }
    }
    let Some((design, estimate)) = best else { return Ok(None) };
    let is_estimable = |estimate: &Estimate, k: usize| estimate.unknowns.is_estimable(k);
    let untold = (0..campaign.unknowns()).filter(|k| is_estimable(&estimate, *k) && !is_estimable(here, *k));
    let mut needs = Vec::new();
    for k in &free {
        if moved(&[*k], NEARBY[0])?.1.unknowns.rank > here.unknowns.rank {
            needs.push(*k);
        }
    }
    // a product of two may need both
    let needs = if needs.is_empty() { free } else { needs };
    let name = |k: usize| campaign.parameter_id(k).to_string();
    let lacking = Lacking { untold: untold.map(name).collect(), needs: needs.into_iter().map(name).collect() };
    Ok(Some((lacking, design, estimate)))
}

/// A search needs values for what vanishes at the point. Errors: `Missing`, with what to state.
pub(super) fn check_point(campaign: &Campaign, kept: &Readings, candidates: &Readings, noise: &Noise) -> Result<()> {
    /// So many candidates show what vanishes as well as all of them: drawn at random, for a step through a sweep may meet few of a joint's angles.
    const ENOUGH: usize = 2000;
    let mut drawn: Vec<_> = candidates.rows.iter().collect();
    if drawn.len() > ENOUGH {
        shuffle(&mut drawn, &mut Pcg64Mcg::seed_from_u64(0));
    }
    let mut rows: Vec<_> = kept.rows.iter().take(ENOUGH).cloned().collect();
    rows.extend(drawn.into_iter().take(ENOUGH).map(Reading::unread));
    // mountings that scatter change no rank
    let noise = &Noise { remount: Vec::new(), ..noise.clone() };
    let all = campaign.with_readings(Readings { columns: candidates.columns.clone(), rows });
    let (_, _, here) = Independent::at(&all, &all.reference_point(), noise)?;
    let Some((lacking, ..)) = lacking(&all, &here, noise)? else { return Ok(()) };
    let [untold, needs] = [&lacking.untold, &lacking.needs].map(|names| names.join(", "));
    let first = lacking.needs.first().map_or("?", String::as_str);
    Err(Malformed::new(
        Fault::Missing,
        format!("how well the candidates determine {untold} depends on the value of {needs}, which is not stated"),
    )
    .expected("a value to judge at, or a \"start\" in the campaign: an expected value will do")
    .argument("at", format!("{first}=VALUE"))
    .found("zero, where these effects vanish")
    .at_path("estimate"))
}
