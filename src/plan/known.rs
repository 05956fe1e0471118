//! Known inputs: how their uncertainties reach the estimates, when nobody knows yet how large the tilts are.
//!
//! ```text
//! c(x) = -A^+ d f / d known  at the tilts x,    Type B covariance of the estimates: u^2 E[c c'] = u^2 (c0 c0' + sum_k g_k g_k')
//! g_k = [c(s_k e_k) - c(-s_k e_k)] / 2,         tilts independent, with expected sizes (standard deviations) s_k
//! ```
//!
//! At zero tilts a scale factor error moves no angle at all; at tilts of `x` it moves them by `x u(kI) / kI`. A fit knows `x`, a plan cannot:
//! the user states the size. Where it is not stated, that part is left out, and its value for an example size is reported.

use super::effort::Noise;
use super::whitened::Independent;
use crate::campaign::{Campaign, Kind, Parameter, Role};
use crate::design::DesignMatrix;
use crate::error::Result;
use crate::estimate::Estimate;
use crate::units::ARCSEC;

/// Example size for which the part that was left out is reported: 100 arcsec.
const FOR_EXAMPLE: f64 = 100.0 * std::f64::consts::PI / 648_000.0;

/// What a known input's uncertainty does through the tilts.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "ThroughTiltsReport")]
#[non_exhaustive]
pub struct ThroughTilts {
    /// Size of the tilts in arcseconds: as stated, or an example.
    pub tilts_arcsec: f64,
    /// Is it counted in the predicted uncertainties? Only where the size was stated.
    pub counted: bool,
    /// The known input that matters most.
    pub known: String,
    /// The parameter that it moves most.
    pub parameter: String,
    /// Standard uncertainty from it, in the parameter's unit.
    pub u: f64,
    /// The same in arcseconds, for tilts.
    pub u_arcsec: Option<f64>,
}

/// For each known input, `u c` at the reference point and `u g_k` for each tilt of stated size; and what was left out or added.
pub(super) fn contributions(
    campaign: &Campaign,
    here: &(DesignMatrix, Independent, Estimate),
    noise: &Noise,
) -> Result<(Vec<Vec<f64>>, Option<ThroughTilts>)> {
    let known: Vec<(usize, f64)> = campaign
        .parameters
        .iter()
        .enumerate()
        .filter_map(|(k, p)| match p.role {
            Role::Known(known) if known.u > 0.0 => Some((k, known.u)),
            _ => None,
        })
        .collect();
    let root = campaign.correlation_root(&known.iter().map(|(k, _)| *k).collect::<Vec<usize>>());
    // correlated inputs as independent ones: sum of r_ij p_i p_j' = sum of (sum L_ik p_i)(...)'
    let independent = |parts: Vec<Vec<f64>>| -> Vec<Vec<f64>> {
        let unknowns = parts.first().map_or(0, Vec::len);
        let mut mixed = vec![vec![0.0; unknowns]; parts.len()];
        for (part, row) in parts.iter().zip(&root) {
            for (sum, share) in mixed.iter_mut().zip(row) {
                sum.iter_mut().zip(part).for_each(|(sum, p)| *sum += share * p);
            }
        }
        mixed
    };
    let mut parts: Vec<Vec<f64>> = independent(sensitivities(campaign, here, &known)?);
    let tilts: Vec<(usize, Option<f64>)> = campaign
        .estimated()
        .iter()
        .enumerate()
        .filter(|(_, p)| p.kind == Kind::Tilt && !known.is_empty())
        .filter_map(|(k, p)| Some((k, expected_size(p, noise.tilts)?)))
        .collect();
    let (design, _, estimate) = here;
    let unstated = tilts.iter().any(|(_, size)| size.is_none());
    let mut squares = vec![vec![0.0; campaign.unknowns()]; known.len()];
    for (tilt, size) in &tilts {
        let step = size.unwrap_or(FOR_EXAMPLE);
        let at = |sign: f64| -> Result<Vec<Vec<f64>>> {
            let mut point = design.point.clone();
            if let Some(value) = point.get_mut(*tilt) {
                *value += sign * step;
            }
            sensitivities(campaign, &Independent::at(campaign, &point, noise)?, &known).map(&independent)
        };
        for ((plus, minus), squares) in at(1.0)?.into_iter().zip(at(-1.0)?).zip(&mut squares) {
            let half: Vec<f64> = plus.iter().zip(&minus).map(|(p, m)| 0.5 * (p - m)).collect();
            squares.iter_mut().zip(&half).for_each(|(s, g)| *s += g * g);
            if size.is_some() {
                parts.push(half);
            }
        }
    }
    let share = |(_, k, u): &(usize, usize, f64)| {
        let u_of_readings = estimate.unknowns.covariance[(*k, *k)].sqrt();
        if u_of_readings > 0.0 && estimate.unknowns.is_estimable(*k) { u / u_of_readings } else { 0.0 }
    };
    let all =
        squares.iter().zip(&known).flat_map(|(s, (p, _))| s.iter().enumerate().map(move |(k, s)| (*p, k, s.sqrt())));
    let strongest = all.reduce(|best, next| if share(&best) >= share(&next) { best } else { next });
    let through = strongest.filter(|most| share(most) > 1e-6).map(|(p, k, u)| ThroughTilts {
        // the report says that it is an example
        tilts_arcsec: ARCSEC * if unstated { FOR_EXAMPLE } else { noise.tilts.unwrap_or(FOR_EXAMPLE) },
        counted: !unstated,
        known: campaign.parameter_id(p).to_string(),
        parameter: campaign.parameter_id(k).to_string(),
        u,
        u_arcsec: campaign.parameters.get(k).filter(|p| p.kind == Kind::Tilt).map(|_| u * ARCSEC),
    });
    Ok((parts, through))
}

/// The expected size of a tilt: from its prior, else as the user states it. `None` for one with a start value, which is known well enough.
fn expected_size(parameter: &Parameter, stated: Option<f64>) -> Option<Option<f64>> {
    match &parameter.role {
        Role::Estimated { start: Some(_), .. } => None,
        Role::Estimated { prior: Some(prior), .. } => Some(Some(prior.u)),
        _ => Some(stated),
    }
}

/// For each known input, its uncertainty times the sensitivities of the estimates, `-A^+ df/dp`.
fn sensitivities(
    campaign: &Campaign,
    (design, rows, estimate): &(DesignMatrix, Independent, Estimate),
    known: &[(usize, f64)],
) -> Result<Vec<Vec<f64>>> {
    known
        .iter()
        .map(|(k, u)| {
            let mut shift: Vec<f64> = (0..design.rows.len()).map(|i| -design.jacobian[(i, *k)] * u).collect();
            shift.resize(rows.u.len(), 0.0);
            let mut c = estimate.factor.solve(&rows.column(shift))?;
            c.truncate(campaign.unknowns());
            Ok(c)
        })
        .collect()
}
